//! A peg of any shape in a hole of any shape, both as meshes.

use super::fit::{self, Misfit};
use super::hole::{self, Hole, ROTATION_SCALE, TRANSLATION_SCALE};
use super::{ContactManifold, PegInHole, Reach, Recall, Rows, Shape, Sketch};
use crate::geometry::extrusion::PegAndHole;
use crate::geometry::round::{Round, is_turned};
use crate::geometry::solids::{Solids, Touch};
use crate::se3::Pose;

/// What is farther from the axis than so many of the peg's radii is none of the hole.
const AROUND: f64 = 1.5;

/// Contact of a peg (the tool) with the body around a hole, into which it goes `depth` (m): as
/// outlines, which is faster, if both are straight ([`PegAndHole::of_straight`]), else as
/// [`SolidInHole`].
///
/// # Errors
/// [`Misfit`] if the peg does not go in.
pub fn peg_in_hole(parts: Solids, depth: f64) -> Result<Box<dyn ContactManifold>, Misfit> {
    fit::check_axis(&parts, depth)?;
    let manifold: Box<dyn ContactManifold> = match PegAndHole::of_straight(&parts, depth) {
        Some(shapes) => Box::new(PegInHole { depth, ..PegInHole::new(shapes) }),
        None => Box::new(SolidInHole::new(parts, depth)),
    };
    fit::check(manifold.as_ref(), depth)?;
    Ok(manifold)
}

/// Contact of a peg with the hole it goes into, as [`PegInHole`](super::PegInHole) but for bodies
/// of any shape: chamfers, cones, steps.
///
/// The frames are the same: the peg's at the centre of its tip with +z away from it, the hole's at
/// the centre of its mouth with +z outwards, and a seated peg has the axes of the hole. The
/// envelope is that of a hole of the given depth.
#[derive(Clone, Debug)]
pub struct SolidInHole {
    shapes: Solids,
    hole: Hole,
}

impl SolidInHole {
    /// A peg (the tool) and the body around a hole, into which the peg goes `depth` (m).
    pub fn new(shapes: Solids, depth: f64) -> Self {
        let peg_radius = shapes.tool().vertices().map(|p| p.xy().coords.norm()).fold(0.0, f64::max);
        let round = Round {
            peg: is_turned(shapes.tool(), f64::INFINITY),
            hole: is_turned(shapes.fixture(), AROUND * peg_radius),
        };
        SolidInHole { shapes, hole: Hole { depth, peg_radius, round } }
    }

    /// Shapes of peg and hole.
    pub fn shapes(&self) -> &Solids {
        &self.shapes
    }
}

impl ContactManifold for SolidInHole {
    fn name(&self) -> &'static str {
        self.hole.name(false)
    }

    fn residual(&self, hole_from_peg: &Pose, resolution: f64, rows: &mut Rows) {
        let (value, gradient) = self.shapes.blended_gap(hole_from_peg, resolution);
        rows.push(value, self.hole.without_turns(hole_from_peg)(gradient));
    }

    fn walls(&self, hole_from_peg: &Pose, reach: &Reach, recall: &mut Recall, rows: &mut Rows) {
        let visit_below = |distance: f64, visit: &mut dyn FnMut(Touch)| {
            self.shapes.visit_below(hole_from_peg, distance, &mut recall.nearby, |touch| visit(touch.clone()));
        };
        self.hole.push_walls(hole_from_peg, reach, visit_below, rows);
    }

    fn surfaces(&self) -> (usize, usize) {
        hole::PARTS
    }

    fn envelope(&self, hole_from_peg: &Pose, rows: &mut Rows) {
        self.hole.push_envelope(hole_from_peg, (TRANSLATION_SCALE, ROTATION_SCALE), rows);
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    /// The shadow of the peg along its axis: as long as the peg, and as deep as the hole.
    fn sketch(&self) -> Sketch {
        let outline = self.shapes.tool().shadow();
        let length = self.shapes.tool().vertices().map(|p| p.z).fold(0.0, f64::max);
        let tool = Shape::Prism { outline: outline.clone(), from: 0.0, to: length };
        Sketch { tool, fixture: Shape::Prism { outline, from: -self.hole.depth, to: 0.0 } }
    }

    fn has_interference(&self) -> bool {
        true
    }
}

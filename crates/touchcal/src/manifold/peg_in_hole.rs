//! A straight peg in a straight hole: the residual is the exact signed gap.

use super::hole::{self, Hole, ROTATION_SCALE, TRANSLATION_SCALE};
use super::{ContactManifold, Reach, Recall, Rows, Shape, Sketch};
use crate::geometry::extrusion::{Gap, PegAndHole};
use crate::geometry::profile::Profile;
use crate::geometry::solids::Touch;
use crate::se3::Pose;

/// Contact of a peg with the hole it goes into. Poses are `hole_from_peg`, frames as in
/// [`PegAndHole`].
///
/// - Residual, one row: the signed gap (m), positive free, negative penetrating; blended over
///   features that the resolution cannot tell apart, see [`PegAndHole::blended_gap`]. Facets that
///   stand for a circle are none of the parts': the Jacobian, not the gap, is that of a round part.
/// - Envelope, six rows: place of the tip's origin in the hole — x and y towards zero, z outside
///   `[−depth, 0]` (zero within) — divided by `translation_scale`, then the rotation vector of
///   `hole_from_peg` divided by `rotation_scale`. Its Jacobian is exact and regular at every angle
///   up to π, where the rotation vector itself jumps to its negative. If either part is round, the
///   peg's axis less the hole's instead, which does not know how far the peg has turned.
#[derive(Clone, Debug)]
pub struct PegInHole {
    /// Shapes of peg and hole.
    pub shapes: PegAndHole,
    /// How far the peg goes in (m): the depth of the envelope.
    pub depth: f64,
    /// Scale of the envelope's translation rows (m).
    pub translation_scale: f64,
    /// Scale of the envelope's rotation rows (rad).
    pub rotation_scale: f64,
}

impl PegInHole {
    /// A peg that goes in down to the floor, with an envelope scale of half a millimetre and one
    /// degree.
    pub fn new(shapes: PegAndHole) -> Self {
        PegInHole {
            depth: shapes.depth(),
            shapes,
            translation_scale: TRANSLATION_SCALE,
            rotation_scale: ROTATION_SCALE,
        }
    }

    fn hole(&self) -> Hole {
        Hole { depth: self.depth, peg_radius: self.shapes.peg_radius(), round: self.shapes.round() }
    }
}

impl ContactManifold for PegInHole {
    fn name(&self) -> &'static str {
        self.hole().name(true)
    }

    fn residual(&self, hole_from_peg: &Pose, resolution: f64, rows: &mut Rows) {
        let (value, gradient) = self.shapes.blended_gap(hole_from_peg, resolution);
        rows.push(value, self.hole().without_turns(hole_from_peg)(gradient));
    }

    fn walls(&self, hole_from_peg: &Pose, reach: &Reach, _recall: &mut Recall, rows: &mut Rows) {
        let visit_below = |distance: f64, visit: &mut dyn FnMut(Touch)| {
            self.shapes.visit_below(hole_from_peg, distance, |gap| visit(gap.into()));
        };
        self.hole().push_walls(hole_from_peg, reach, visit_below, rows);
    }

    fn surfaces(&self) -> (usize, usize) {
        hole::PARTS
    }

    fn envelope(&self, hole_from_peg: &Pose, rows: &mut Rows) {
        self.hole().push_envelope(hole_from_peg, (self.translation_scale, self.rotation_scale), rows);
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn sketch(&self) -> Sketch {
        let prism = |outline: &Profile, from, to| Shape::Prism { outline: outline.vertices().to_vec(), from, to };
        let shapes = &self.shapes;
        Sketch { tool: prism(shapes.peg(), 0.0, shapes.length()), fixture: prism(shapes.hole(), -self.depth, 0.0) }
    }

    fn has_interference(&self) -> bool {
        true
    }
}

impl From<&Gap> for Touch {
    fn from(gap: &Gap) -> Touch {
        Touch {
            value: gap.value,
            gradient: gap.gradient,
            point_in_fixture: gap.point_in_hole,
            normal_in_fixture: gap.normal_in_hole,
        }
    }
}

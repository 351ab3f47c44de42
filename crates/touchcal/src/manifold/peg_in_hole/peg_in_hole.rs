//! The contact manifold of a peg in a hole: the residual is the exact signed gap.

use std::sync::Arc;

use nalgebra::Vector3;

use super::candidates::push_candidates;
use super::hole::{Hole, ROTATION_SCALE, TRANSLATION_SCALE};
use super::shapes::PegInHoleShapes;
use super::surfaces::{SURFACE_COUNTS, is_at_rim};
use crate::geometry::{EdgeFaces, PrismPair, SignedGap};
use crate::manifold::cache::ContactCache;
use crate::manifold::contact_manifold::{ContactManifold, ResidualKind, RotationalOrders, SurfaceCounts};
use crate::manifold::gate::Gate;
use crate::manifold::residual::Residual;
use crate::manifold::sketch::Sketch;
use crate::se3::Pose;

/// Contact of a peg (the tool) with the hole it goes into. Poses are `hole_from_peg` (m), frames as
/// in [`PegInHoleShapes`]; `G` are the shapes, prisms or meshes.
///
/// - Residual, one row: the signed gap (m), positive apart, negative in penetration; the soft
///   minimum over features that the resolution cannot distinguish, see
///   [`GapQuery::blended_gap`](crate::geometry::GapQuery::blended_gap). The Jacobian, not the gap,
///   leaves out what the facets of a round part add.
/// - Envelope, six rows without unit: position of the tip's origin in the hole — x and y towards
///   zero, z outside `[−depth, 0]` (zero within) — over 0.5 mm, then the rotation vector x, y, z of
///   `hole_from_peg` over 1°. Its Jacobian is exact and regular at every angle up to π, where the
///   rotation vector itself jumps to its negative. If either part is round, the last three rows are
///   the peg's axis minus the hole's (unit vectors in the hole's frame) over 1° in radians.
/// - Candidate contacts: of the features that the gate accepts, one for each direction in which
///   they push. Surfaces cannot be distinguished while the tip passes the rim, within 0.2 mm. There
///   are four regions, by the depth of the tip, of 14 surfaces each: for the axis direction of the
///   hole that is nearest to the normal (six) and for the end of the peg's part inside, tip or rim
///   (two), and one at either end for the farther candidates of a direction.
#[derive(Clone, Debug)]
pub struct PegInHole<G> {
    shapes: G,
    hole: Hole,
    edges: Option<[EdgeFaces; 2]>,
}

impl PegInHole<PrismPair> {
    /// A straight peg that goes in down to the floor of a straight hole: [`PrismPair::depth`]. That
    /// the peg fits is not checked, see [`check_fit`](crate::manifold::check_fit).
    pub fn new(shapes: PrismPair) -> Self {
        let depth = shapes.depth();
        PegInHole::with_depth(shapes, depth)
    }
}

impl<G: PegInHoleShapes> PegInHole<G> {
    /// A peg whose tip reaches down to `depth` (m, positive; not checked) below the mouth of a
    /// hole. The depth bounds the envelope and divides the hole into regions; the gap does not
    /// depend on it.
    pub fn with_depth(shapes: G, depth: f64) -> Self {
        let hole = Hole {
            depth,
            peg_radius: shapes.peg_radius(),
            sum_of_edge_radii: shapes.sum_of_edge_radii(),
            symmetry: shapes.symmetry(),
        };
        let edges = shapes.edge_faces();
        PegInHole { shapes, hole, edges }
    }

    /// Shapes of peg and hole, each in its frame.
    pub fn shapes(&self) -> &G {
        &self.shapes
    }

    /// Depth (m) below the hole's mouth down to which the peg's tip reaches.
    pub fn depth(&self) -> f64 {
        self.hole.depth
    }
}

impl<G: PegInHoleShapes + Send + Sync + std::fmt::Debug + 'static> ContactManifold for PegInHole<G> {
    fn name(&self) -> &'static str {
        self.hole.name(G::IS_STRAIGHT)
    }

    fn residual(&self, hole_from_peg: &Pose, resolution: f64, residual: &mut Residual) {
        let (gap, gradient) = self.shapes.blended_gap(hole_from_peg, resolution);
        residual.push(gap, self.hole.without_axial_rotation(hole_from_peg)(gradient));
    }

    fn residual_kind(&self) -> ResidualKind {
        ResidualKind::LeastGap
    }

    fn candidate_contacts(
        &self,
        hole_from_peg: &Pose,
        gate: &Gate,
        cache: &mut ContactCache,
        candidates: &mut Residual,
    ) {
        let visit_below = |cutoff, visit: &mut dyn FnMut(&SignedGap)| {
            self.shapes.visit_below(hole_from_peg, cutoff, &mut cache.neighbors, visit);
        };
        push_candidates(&self.hole, hole_from_peg, gate, visit_below, candidates);
    }

    fn has_distinct_surfaces(&self, hole_from_peg: &Pose) -> bool {
        !is_at_rim(&self.hole, hole_from_peg)
    }

    fn has_edges(&self) -> bool {
        self.edges.is_some()
    }

    fn gap_by_edge_radius(&self, normal_in_tool: &Vector3<f64>, normal_in_fixture: &Vector3<f64>) -> f64 {
        // Outward of the peg, and outward of the hole's outline, into the solid.
        let normals = [normal_in_tool, normal_in_fixture].map(|normal| -normal);
        self.edges.iter().flatten().zip(&normals).map(|(edges, normal)| edges.excess(normal)).sum()
    }

    fn rotational_orders(&self) -> RotationalOrders {
        self.shapes.rotational_orders()
    }

    fn with_scaled_depth(&self, factor: f64) -> Option<Arc<dyn ContactManifold>> {
        let shapes = self.shapes.with_scaled_depth(factor)?;
        Some(Arc::new(PegInHole::with_depth(shapes, factor * self.hole.depth)))
    }

    fn surface_counts(&self) -> SurfaceCounts {
        SURFACE_COUNTS
    }

    fn envelope(&self, hole_from_peg: &Pose, rows: &mut Residual) {
        self.hole.push_envelope(hole_from_peg, (TRANSLATION_SCALE, ROTATION_SCALE), rows);
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn sketch(&self) -> Sketch {
        self.shapes.sketch(self.hole.depth)
    }
}

//! Two meshes and the signed gap between them.

use super::gap_sweep::{DEEP, FeatureDistance, GapSweep, least};
use super::neighbor_list::NeighborList;
use super::posed_pair::PosedPair;
use crate::geometry::gap::{GapQuery, SignedGap};
use crate::geometry::mesh::TriangleMesh;
use crate::geometry::softmin::{self, SoftMin, Term};
use crate::se3::{Pose, Twist};

/// Two bodies of any shape: a tool and the fixture that it touches.
///
/// # Signed gap
/// The least of the signed distances between features that can touch: convex vertices of one body
/// against faces of the other, convex edges against convex edges. Apart it is the distance between
/// the bodies. Each distance passes through zero with an unchanged slope, and is negative by how
/// far a vertex lies beyond the nearest faces, or an edge beyond an edge.
///
/// Overlaps are found from the edges of one body that pierce the surface of the other: from their
/// ends inside, along edges that do not pierce, to all vertices inside, as deep as their signed
/// distance ([`TriangleMesh::signed_distance`]); and between the edges of both bodies of which a
/// part is inside. Where a vertex is more than 2 mm inside, edges are left out, and
/// [`visit_below`](GapQuery::visit_below) reports the deepest overlap alone, whatever the cutoff.
/// The gap is infinite where the bodies are more than 10 m apart, and may be so where they are more
/// than 1.6 mm apart and no corner of the tool is within 10 m of the fixture.
#[derive(Clone, Debug)]
pub struct MeshPair {
    tool: TriangleMesh,
    fixture: TriangleMesh,
}

impl MeshPair {
    /// A tool and a fixture, each in its own frame (m). Nothing is checked.
    pub fn new(tool: TriangleMesh, fixture: TriangleMesh) -> Self {
        MeshPair { tool, fixture }
    }

    /// Mesh of the tool, in the tool frame.
    pub fn tool(&self) -> &TriangleMesh {
        &self.tool
    }

    /// Mesh of the fixture, in the fixture frame.
    pub fn fixture(&self) -> &TriangleMesh {
        &self.fixture
    }

    fn at(&self, fixture_from_tool: &Pose) -> PosedPair<'_> {
        PosedPair {
            body: &self.tool,
            other: &self.fixture,
            rotation: *fixture_from_tool.rotation.to_rotation_matrix().matrix(),
            translation: fixture_from_tool.translation.vector,
        }
    }
}

impl GapQuery for MeshPair {
    fn gap(&self, fixture_from_tool: &Pose) -> SignedGap {
        GapSweep::new(self.at(fixture_from_tool), None).gap()
    }

    fn blended_gap(&self, fixture_from_tool: &Pose, temperature: f64) -> (f64, Twist) {
        let sweep = GapSweep::new(self.at(fixture_from_tool), None);
        let found = if temperature > 0.0 { sweep.nearest(softmin::CUTOFF * temperature) } else { Vec::new() };
        let Some(least) = least(&found) else {
            let gap = sweep.gap();
            return (gap.value, gap.gradient);
        };
        let term = |found: &FeatureDistance| Term { value: found.value, gradient: sweep.gradient(found) };
        let mut blend = SoftMin::new(term(least), temperature);
        found.iter().for_each(|found| blend.add(&term(found)));
        blend.mean()
    }

    fn visit_below(
        &self,
        fixture_from_tool: &Pose,
        cutoff: f64,
        neighbors: &mut Option<Box<NeighborList>>,
        visit: &mut dyn FnMut(&SignedGap),
    ) {
        let tool = self.at(fixture_from_tool);
        let sweep = GapSweep::new(tool, Some(NeighborList::at(neighbors, &tool, cutoff)));
        if sweep.deepest() < -DEEP {
            visit(&self.gap(fixture_from_tool));
        } else {
            let found = sweep.below(cutoff, f64::INFINITY);
            found.iter().filter(|found| found.value < cutoff).for_each(|found| visit(&sweep.signed_gap(found)));
        }
        neighbors.take_if(|neighbors| !neighbors.is_small());
    }
}

//! Signed gaps between a tool and a fixture.

use nalgebra::{Point3, Vector3};

use super::mesh_gap::NeighborList;
use crate::se3::{Pose, Twist};

/// A signed distance between tool and fixture, where it is attained and how it changes with the
/// pose.
#[derive(Clone, Debug, PartialEq)]
pub struct SignedGap {
    /// Signed distance (m): positive apart, negative in penetration.
    pub value: f64,
    /// `∂value/∂ξ` for `fixture_from_tool · Exp(ξ)`, a twist row `[v; ω]`: `[n; p × n]` in the tool
    /// frame.
    pub gradient: Twist,
    /// The point of the tool (m) at which it is attained, in the fixture frame.
    pub point_in_fixture: Point3<f64>,
    /// Unit normal in the fixture frame, from the fixture into the tool: moving the tool along it
    /// opens the gap.
    pub normal_in_fixture: Vector3<f64>,
}

/// A tool and a fixture whose signed gap is known at every pose `fixture_from_tool`.
pub trait GapQuery {
    /// The signed gap: the least signed distance between features of the two.
    fn gap(&self, fixture_from_tool: &Pose) -> SignedGap;

    /// The soft minimum (m) of the signed distances `gₖ` between features, and its gradient as in
    /// [`SignedGap::gradient`].
    ///
    /// `Σ wₖ gₖ / Σ wₖ` with `wₖ = exp(−x) (1 − (x/4)²)²`, `x = (gₖ − min g)/temperature` up to 4.
    /// Where the pose is known only to about the temperature (m), the least of several nearly equal
    /// gaps is too small on average (a minimum of noisy numbers), the soft minimum is not; it also
    /// changes smoothly where the minimum jumps from feature to feature. At temperature 0 it is the
    /// gap.
    fn blended_gap(&self, fixture_from_tool: &Pose, temperature: f64) -> (f64, Twist);

    /// Calls `visit` for the pairs of features whose signed distance is below `cutoff` (m), in no
    /// particular order.
    ///
    /// What a search found may be kept in `neighbors`, which belongs to one contact of this pair;
    /// what is visited does not depend on it.
    fn visit_below(
        &self,
        fixture_from_tool: &Pose,
        cutoff: f64,
        neighbors: &mut Option<Box<NeighborList>>,
        visit: &mut dyn FnMut(&SignedGap),
    );
}

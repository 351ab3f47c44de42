//! Signed gaps between a tool and a fixture.

use nalgebra::{Point3, Vector3};

use super::mesh_gap::NeighborList;
use crate::se3::{Pose, Twist};

/// The signed distance between two features of a tool and a fixture at a pose `fixture_from_tool`,
/// where it is attained and how it changes with the pose.
#[derive(Clone, Debug, PartialEq)]
pub struct SignedGap {
    /// Signed distance (m): positive apart, negative in penetration. Infinite if nothing is near
    /// (see [`MeshPair`](super::mesh_gap::MeshPair)); the other fields then have no meaning.
    pub value: f64,
    /// `∂value/∂ξ` for `fixture_from_tool · Exp(ξ)`, a twist `[v; ω]` (no unit; m/rad):
    /// `[n; p × n]` with the normal `n` and the point `p` (m), both in the tool frame.
    pub gradient: Twist,
    /// The point of the tool at which the distance is attained (m, in the fixture frame).
    pub point_in_fixture: Point3<f64>,
    /// Unit normal in the fixture frame, from the fixture into the tool: the gap opens when the
    /// tool moves along it.
    pub normal_in_fixture: Vector3<f64>,
}

/// Signed gap of a tool and a fixture at every pose `fixture_from_tool` (m) of finite numbers.
pub trait GapQuery {
    /// The signed gap: the least signed distance (m) between features of tool and fixture, negative
    /// if the bodies overlap. Of equally near features any may be returned.
    fn gap(&self, fixture_from_tool: &Pose) -> SignedGap;

    /// The soft minimum (m) of the signed distances `gₖ` (m) between features, and its gradient as
    /// in [`SignedGap::gradient`].
    ///
    /// `Σ wₖ gₖ / Σ wₖ` with `wₖ = exp(−x) (1 − (x/4)²)²`, `x = (gₖ − min g)/temperature` up to 4:
    /// a Boltzmann operator (Asadi & Littman 2017, arXiv 1612.05628), cut off by the biweight
    /// (Beaton & Tukey 1974). Where the pose is known only to about the temperature (m), the least
    /// of several nearly equal gaps is too small on average (a minimum of noisy numbers), the soft
    /// minimum is not; it also changes smoothly where the minimum jumps from feature to feature. At
    /// temperature 0 or below it is the gap.
    fn blended_gap(&self, fixture_from_tool: &Pose, temperature: f64) -> (f64, Twist);

    /// Calls `visit` for the pairs of features whose signed distance is below `cutoff` (m, of
    /// either sign), in no particular order; never if there are none.
    ///
    /// `neighbors` may keep the result of a search for the next call at a nearby pose. It belongs
    /// to one contact of this pair, `None` at first; what is visited does not depend on it.
    fn visit_below(
        &self,
        fixture_from_tool: &Pose,
        cutoff: f64,
        neighbors: &mut Option<Box<NeighborList>>,
        visit: &mut dyn FnMut(&SignedGap),
    );
}

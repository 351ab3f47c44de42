//! The contact manifold: all that the estimator knows of a tool and a fixture.

use super::cache::ContactCache;
use super::gate::Gate;
use super::residual::{MAX_ROWS, Residual};
use super::sketch::{Shape, Sketch};
use crate::se3::{Pose, Twist};

/// Given a pose's index and its residual, writes the derivative of a loss by each row.
pub type Cotangent<'c> = &'c mut dyn FnMut(usize, &[f64], &mut [f64; MAX_ROWS]);

/// What a manifold's residual measures, and with it what the estimator may conclude from it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum ResidualKind {
    /// Two-sided distance from the manifold: positive and negative values are as likely.
    #[default]
    Distance,
    /// Offset from the one point that is the manifold. The fixture's place may then be unknown, and
    /// contacts are scored by their distance from their mean.
    PointOffset,
    /// The least of several one-sided gaps, of which any may be closed at a contact: the active set
    /// is latent. The least of noisy gaps is negative on average even at the true pose, and real
    /// contacts press parts into each other, so a mean gap at contact is fitted.
    LeastGap,
    /// Difference from a projected pose. Motion along the manifold counts too, which contacts do
    /// not measure: no covariance follows from it.
    ProjectionError,
    /// Nothing: the shapes are not known and there are no rows.
    Unmodeled,
}

/// Numbers of the surfaces that candidate contacts are of. How often a surface is touched is
/// estimated region by region: a tool leans to one side in one region and to another elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceCounts {
    /// Regions of the manifold.
    pub regions: usize,
    /// Surfaces of each region.
    pub per_region: usize,
}

/// A pair of tool and fixture that can touch.
///
/// Poses are `fixture_from_tool`, the tool's pose in the fixture's frame. Values are in metres.
pub trait ContactManifold: Send + Sync + std::fmt::Debug {
    /// Tool and fixture in words for people: "ball in socket".
    fn name(&self) -> &'static str;

    /// Appends to `residual` how far the pose is from touching (m): zero on the manifold.
    ///
    /// `resolution` (m) is the standard deviation to which gaps are known at the contact. Features
    /// whose gaps differ by less cannot be told apart, and a manifold of several features may blend
    /// them; 0 asks for the exact distance.
    fn residual(&self, fixture_from_tool: &Pose, resolution: f64, residual: &mut Residual);

    /// [`residual`](Self::residual) of each pose, in place of the former rows. A manifold that
    /// evaluates many poses faster together than one by one overrides this method.
    fn residuals(&self, poses: &[Pose], resolution: f64, residuals: &mut [Residual]) {
        for (pose, residual) in poses.iter().zip(residuals) {
            residual.clear();
            self.residual(pose, resolution, residual);
        }
    }

    /// What the residual measures.
    fn residual_kind(&self) -> ResidualKind {
        ResidualKind::Distance
    }

    /// Appends the signed gaps (m) of the candidate contacts that `gate` accepts, the nearest
    /// first.
    ///
    /// A candidate contact is a surface that can push in one direction; the gaps of all that are
    /// touched at once are zero, on average over the pose's noise. There are none where the
    /// surfaces cannot be distinguished. The default is the residual, for a single surface.
    ///
    /// `cache` is that of the contact, which is evaluated many times at nearby poses.
    fn candidate_contacts(
        &self,
        fixture_from_tool: &Pose,
        gate: &Gate,
        cache: &mut ContactCache,
        candidates: &mut Residual,
    ) {
        let _ = cache;
        self.residual(fixture_from_tool, 0.0, candidates);
        candidates.retain(|gap, gradient| gate.accepts(gap, gradient.dot(&(gate.covariance * gradient))));
    }

    /// Numbers of the surfaces that candidate contacts are of.
    fn surface_counts(&self) -> SurfaceCounts {
        SurfaceCounts { regions: 1, per_region: 1 }
    }

    /// Derivatives of a loss by a right twist of each pose, from those by its residual: `Jᵀ
    /// cotangent(i, residual)`.
    fn pull_back(&self, poses: &[Pose], resolution: f64, cotangent: Cotangent<'_>, gradients: &mut [Twist]) {
        let mut residual = Residual::new();
        for (i, (pose, gradient)) in poses.iter().zip(gradients).enumerate() {
            residual.clear();
            self.residual(pose, resolution, &mut residual);
            let mut each = [0.0; MAX_ROWS];
            cotangent(i, residual.values(), &mut each);
            *gradient = residual.jacobian().iter().zip(each).map(|(row, y)| row * y).sum();
        }
    }

    /// Appends how far the pose lies outside the region in which contacts happen, each row divided
    /// by its scale. Nearly convex in the pose, so that the coarse stage converges from afar.
    fn envelope(&self, fixture_from_tool: &Pose, rows: &mut Residual) {
        self.residual(fixture_from_tool, 0.0, rows);
    }

    /// Components of a fixture twist `[v; ω]` that move the manifold: a socket is a point, a plane
    /// has no place along itself.
    fn fixture_directions(&self) -> &'static [usize];

    /// Components of a tool twist `[v; ω]` that move the residual.
    fn tool_directions(&self) -> &'static [usize];

    /// Shapes of tool and fixture for a picture.
    fn sketch(&self) -> Sketch {
        Sketch { tool: Shape::Point, fixture: Shape::Point }
    }
}

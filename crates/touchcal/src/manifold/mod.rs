//! Contact manifolds: the poses at which a tool can touch a fixture, and how far a pose is from
//! touching.

mod ball_in_socket;
pub mod coordinates;
mod coverage;
pub mod fit;
mod hole;
pub mod learned;
mod nearest;
mod peg_in_hole;
mod plane;
mod projection;
mod samples;
mod sketch;
mod solid_in_hole;
mod training_pairs;
mod tree;
mod unknown;

pub use ball_in_socket::BallInSocket;
pub use coverage::{Coverage, Quantiles};
pub use learned::LearnedProjection;
pub use nearest::{NearestSample, Neighbour};
pub use peg_in_hole::PegInHole;
pub use plane::Plane;
pub use projection::{Projected, Projection};
pub use samples::{PoseSamples, SamplesError};
pub use sketch::{Shape, Sketch};
pub use solid_in_hole::{SolidInHole, peg_in_hole};
pub use training_pairs::TrainingPairs;
pub use unknown::Unknown;

use nalgebra::Matrix6;

use crate::geometry::nearby::Nearby;
use crate::se3::{Pose, Twist};

/// Most rows any manifold's residual or envelope has.
pub const MAX_ROWS: usize = 6;

/// A residual of up to [`MAX_ROWS`] rows with its derivative, held in place so that evaluating a
/// contact allocates nothing.
///
/// `jacobian[k]` is `∂value[k]/∂ξ` for the right perturbation `fixture_from_tool · Exp(ξ)`, ordered
/// `[v; ω]`, but for what facets of round parts add to it; `surface[k]` is which of the manifold's
/// surfaces a wall is of, region by region, see [`ContactManifold::surfaces`], and 0 for other
/// rows.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    len: usize,
    value: [f64; MAX_ROWS],
    jacobian: [Twist; MAX_ROWS],
    surface: [usize; MAX_ROWS],
}

impl Rows {
    /// No rows.
    pub fn new() -> Self {
        Rows { len: 0, value: [0.0; MAX_ROWS], jacobian: [Twist::zeros(); MAX_ROWS], surface: [0; MAX_ROWS] }
    }

    /// Keeps the rows of which `keep(value, derivative)` is true, in their order.
    pub fn retain(&mut self, mut keep: impl FnMut(f64, &Twist) -> bool) {
        let before = std::mem::take(&mut self.len);
        for k in 0..before {
            let (value, jacobian, surface) = (self.value[k], self.jacobian[k], self.surface[k]);
            if keep(value, &jacobian) {
                self.push_wall(value, jacobian, surface);
            }
        }
    }

    /// Forgets all rows.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Appends a row. Rows beyond [`MAX_ROWS`] are a mistake of the manifold and are ignored in
    /// release builds.
    pub fn push(&mut self, value: f64, jacobian: Twist) {
        self.push_wall(value, jacobian, 0);
    }

    /// Appends a wall of one of the manifold's surfaces; all walls of a pose are of one region.
    pub fn push_wall(&mut self, value: f64, jacobian: Twist, surface: usize) {
        debug_assert!(self.len < MAX_ROWS, "a manifold pushed more than {MAX_ROWS} rows");
        if self.len < MAX_ROWS {
            self.value[self.len] = value;
            self.jacobian[self.len] = jacobian;
            self.surface[self.len] = surface;
            self.len += 1;
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Residual values.
    pub fn values(&self) -> &[f64] {
        &self.value[..self.len]
    }

    /// Derivatives, a twist-row for each value.
    pub fn jacobian(&self) -> &[Twist] {
        &self.jacobian[..self.len]
    }

    /// Surface of each wall.
    pub fn surfaces(&self) -> &[usize] {
        &self.surface[..self.len]
    }
}

impl Default for Rows {
    fn default() -> Self {
        Rows::new()
    }
}

/// How near walls must be to be looked at.
#[derive(Clone, Debug)]
pub struct Reach {
    /// Covariance of the pose's noise (right twists).
    pub covariance: Matrix6<f64>,
    /// Variance (m²) of each wall's own noise.
    pub own_variance: f64,
    /// How far (m) beyond its surface a wall is on average.
    pub interference: f64,
    /// Standard deviations up to which a wall is near.
    pub deviations: f64,
}

impl Reach {
    /// Whether a wall at `distance` (m) is near, of which the pose's noise makes `variance` (m²).
    pub fn holds(&self, distance: f64, variance: f64) -> bool {
        distance - self.interference < self.deviations * (variance + self.own_variance).sqrt()
    }

    /// Distance (m) from which on no wall is near that touches the tool within `radius` (m) of its
    /// origin.
    pub fn farthest(&self, radius: f64) -> f64 {
        let size = |k: usize| self.covariance.fixed_view::<3, 3>(k, k).symmetric_eigenvalues().max().max(0.0).sqrt();
        let deviation = (size(0) + radius * size(3)).hypot(self.own_variance.sqrt());
        self.interference.max(0.0) + self.deviations * deviation
    }
}

/// What the manifolds here keep of a contact of theirs from one look at its walls to the next. How
/// fast they are found depends on it, and nothing else.
#[derive(Clone, Debug, Default)]
pub struct Recall {
    /// What of tool and fixture was near each other.
    nearby: Option<Box<Nearby>>,
}

/// Given a pose's index and its residual, the derivative of some loss by each row of it.
pub type Cotangent<'c> = &'c mut dyn FnMut(usize, &[f64], &mut [f64; MAX_ROWS]);

/// One kind of touch: all that the estimator knows of a tool and a fixture.
///
/// Poses are `fixture_from_tool`, the tool's pose in the fixture's frame. Values are in metres.
pub trait ContactManifold: Send + Sync + std::fmt::Debug {
    /// What touches what, in words for people: "ball in socket".
    fn name(&self) -> &'static str;

    /// How far the pose is from touching, appended to `rows`: zero on the manifold.
    ///
    /// `resolution` (m) is how well the pose is known at the contact: features of the parts whose
    /// gaps differ by less cannot be told apart, and a manifold of several features may blend them.
    /// 0 asks for the exact distance.
    fn residual(&self, fixture_from_tool: &Pose, resolution: f64, rows: &mut Rows);

    /// [`residual`](Self::residual) of each pose, in place of what its rows held. Manifolds that
    /// answer many poses faster together than one by one have their own.
    fn residuals(&self, poses: &[Pose], resolution: f64, rows: &mut [Rows]) {
        for (pose, rows) in poses.iter().zip(rows) {
            rows.clear();
            self.residual(pose, resolution, rows);
        }
    }

    /// How far the tool is from each wall that it may touch, the nearest first, appended to `rows`:
    /// those within `reach`. A wall is what can push in one direction; all that the parts touch at
    /// once read zero, on average over the pose's noise. None where it cannot be told which walls
    /// there are. The residual, for a manifold of one wall.
    ///
    /// A contact is looked at again and again, at poses nearby, with its own recall.
    fn walls(&self, fixture_from_tool: &Pose, reach: &Reach, recall: &mut Recall, rows: &mut Rows) {
        let _ = recall;
        self.residual(fixture_from_tool, 0.0, rows);
        rows.retain(|distance, gradient| reach.holds(distance, gradient.dot(&(reach.covariance * gradient))));
    }

    /// Number of regions of the manifold, and of surfaces that walls of each region are of. How
    /// often a surface is touched is learned: where a tool is held, it leans to one side, and
    /// elsewhere to another.
    fn surfaces(&self) -> (usize, usize) {
        (1, 1)
    }

    /// Derivatives of a loss by a right twist of each pose, from those by its residual: `Jᵀ
    /// cotangent(i, residual)`.
    fn pull_back(&self, poses: &[Pose], resolution: f64, cotangent: Cotangent<'_>, gradients: &mut [Twist]) {
        let mut rows = Rows::new();
        for (i, (pose, gradient)) in poses.iter().zip(gradients).enumerate() {
            rows.clear();
            self.residual(pose, resolution, &mut rows);
            let mut each = [0.0; MAX_ROWS];
            cotangent(i, rows.values(), &mut each);
            *gradient = rows.jacobian().iter().zip(each).map(|(row, y)| row * y).sum();
        }
    }

    /// How far the pose lies outside the region in which contacts happen, each row divided by that
    /// row's scale. Nearly convex in the pose, so the coarse stage converges from afar.
    fn envelope(&self, fixture_from_tool: &Pose, rows: &mut Rows) {
        self.residual(fixture_from_tool, 0.0, rows);
    }

    /// Components of a fixture twist `[v; ω]` that move the manifold: a socket is a point, a plane
    /// has no place along itself.
    fn fixture_directions(&self) -> &'static [usize];

    /// Components of a tool twist `[v; ω]` that the contact can feel.
    fn tool_directions(&self) -> &'static [usize];

    /// What tool and fixture look like in a picture.
    fn sketch(&self) -> Sketch {
        Sketch { tool: Shape::Point, fixture: Shape::Point }
    }

    /// Whether the residual is the least of many gaps. The least of noisy gaps is negative on
    /// average even at the true pose, and real contacts press parts into each other; the estimator
    /// then fits the mean gap at contact as a nuisance.
    fn has_interference(&self) -> bool {
        false
    }

    /// Whether the manifold is one point, so that its residual is an offset from it and its place
    /// may be unknown: contacts are then scored by their distance from their mean.
    fn is_point(&self) -> bool {
        false
    }

    /// Whether nothing is known of the shapes, so that the residual has no rows.
    fn is_unknown(&self) -> bool {
        false
    }

    /// Whether the residual is the distance from a projection, which also counts motion along the
    /// manifold: no covariance follows from it.
    fn is_projection(&self) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::se3::twist;

    #[test]
    fn no_wall_is_near_that_is_farther_than_the_farthest() {
        let mut chance = Pcg64::seed_from_u64(1);
        let mut most: f64 = 0.0;
        for k in 0..20_000 {
            let mut each = |size: f64| size * chance.random_range(-1.0..=1.0);
            // Of one joint far away, or of several.
            let mut covariance = Matrix6::zeros();
            for _ in 0..1 + k % 4 {
                let joint = twist(&Vector3::from_fn(|_, _| each(30e-6)), &Vector3::from_fn(|_, _| each(50e-6)));
                covariance += joint * joint.transpose();
            }
            let reach = Reach { covariance, own_variance: 1e-12, interference: each(20e-6), deviations: 4.0 };
            let (normal, out) = (Vector3::from_fn(|_, _| each(1.0)), Vector3::from_fn(|_, _| each(1.0)));
            let (normal, point) = (normal.normalize(), out.normalize() * each(0.05).abs());
            let gradient = twist(&normal, &point.cross(&normal));
            let variance = gradient.dot(&(covariance * gradient));
            let farthest = reach.farthest(0.05);
            assert!(!reach.holds(farthest, variance));
            most = most.max(variance.sqrt() / farthest);
        }
        // Nor is it looked much farther than there may be one, or than in any direction.
        assert!(most > 0.24, "{most}");
        let covariance = Matrix6::identity() * 1e-10;
        let alike = Reach { covariance, own_variance: 0.0, interference: 0.0, deviations: 4.0 };
        assert!((alike.farthest(0.0) - 40e-6).abs() < 1e-12);
    }
}

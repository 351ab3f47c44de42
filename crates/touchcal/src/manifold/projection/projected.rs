//! Residual of a contact as the difference between a pose and its projection onto the manifold.

use std::any::Any;
use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::Matrix6;

use super::coordinates::{Coordinates, Metric, coordinates, coordinates_jacobian};
use crate::manifold::contact_manifold::{ContactManifold, Cotangent, ResidualKind};
use crate::manifold::residual::Residual;
use crate::se3::{Pose, Twist};

/// A map `F` from the coordinates `c` of poses to those of poses on a contact manifold, `[x, y, z,
/// α, β, γ]` (m, rad) of `fixture_from_tool`.
///
/// All methods take many poses at once, which a network evaluates much faster than one by one.
pub trait Projection: Any + Send + Sync + Debug {
    /// Name of the projection for messages and reports, such as "nearest sample".
    fn name(&self) -> &'static str;

    /// Metric whose distance the projection minimizes: the length that a radian counts as.
    fn metric(&self) -> Metric;

    /// Least and greatest value, in this order, of each coordinate `[x, y, z, α, β, γ]` on the
    /// manifold (m for 0–2, rad within ±π for 3–5); the least must not exceed the greatest.
    fn bounds(&self) -> [(f64, f64); 6];

    /// `F(c)` of each pose; replaces the contents of `projected`, one entry (m, rad) per pose, in
    /// order. Coordinates of a pose that is not finite are projected onto NaN.
    fn project(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>);

    /// `F(c)` and `∂F/∂c` (row: coordinate of `F`, column: coordinate of `c`; both in m and rad) of
    /// each pose; replaces the contents of both vectors, one entry per pose, in order. Of a pose
    /// that is not finite `F(c)` is NaN and the derivative without meaning.
    fn linearize(&self, poses: &[Coordinates], projected: &mut Vec<Coordinates>, jacobians: &mut Vec<Matrix6<f64>>);

    /// `(∂F/∂c)ᵀ y` of each pose with `y = cotangent(i, F(cᵢ))`, in reverse mode; replaces the
    /// contents of `pulled`, one entry per pose, in order. `y` and the result are derivatives of a
    /// loss by coordinates (per m, per rad), by those of `F(c)` and of `c`. `cotangent` is called
    /// once for each pose, in order.
    fn pull_back(
        &self,
        poses: &[Coordinates],
        cotangent: &mut dyn FnMut(usize, &Coordinates) -> Coordinates,
        pulled: &mut Vec<Coordinates>,
    );
}

/// The contact manifold of the projection `F` that it holds. Residual: `c − F(c)`, six rows (m) in
/// the order x, y, z, roll, pitch, yaw of `fixture_from_tool`, whatever the resolution; angle
/// differences, the shorter way round, are multiplied by [`Metric::metres_per_radian`]. Envelope,
/// six rows without unit in the same order: how far each coordinate lies outside the projection's
/// bounds (angles times that length too), over 0.5 mm.
///
/// The residual is from point to point: it also counts motion along the manifold, which contacts do
/// not measure, so that no covariance follows from it (Bonnabel, Barczyk & Goulette 2016, arXiv
/// 1410.7632).
#[derive(Debug)]
pub struct Projected(pub Arc<dyn Projection>);

/// Distance (m) that one unit of envelope stands for.
const ENVELOPE_LENGTH: f64 = 0.5e-3;

impl ContactManifold for Projected {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn residual(&self, fixture_from_tool: &Pose, resolution: f64, rows: &mut Residual) {
        let mut own = Residual::new();
        self.residuals(std::slice::from_ref(fixture_from_tool), resolution, std::slice::from_mut(&mut own));
        own.values().iter().zip(own.jacobian()).for_each(|(&value, &jacobian)| rows.push(value, jacobian));
    }

    fn residuals(&self, poses: &[Pose], _: f64, rows: &mut [Residual]) {
        let at: Vec<Coordinates> = poses.iter().map(coordinates).collect();
        let (mut onto, mut changes) = (Vec::new(), Vec::new());
        self.0.linearize(&at, &mut onto, &mut changes);
        let lengths = self.0.metric().point(&[1.0; 6]);
        for (i, (onto, change)) in onto.iter().zip(&changes).enumerate() {
            let jacobian = (Matrix6::identity() - change) * coordinates_jacobian(&poses[i]);
            rows[i].clear();
            for (k, value) in self.0.metric().difference(&at[i], onto).into_iter().enumerate() {
                rows[i].push(value, jacobian.row(k).transpose() * lengths[k]);
            }
        }
    }

    fn pull_back(&self, poses: &[Pose], _: f64, cotangent: Cotangent<'_>, gradients: &mut [Twist]) {
        let at: Vec<Coordinates> = poses.iter().map(coordinates).collect();
        let mut direct = vec![[0.0; 6]; poses.len()];
        let mut pulled = Vec::new();
        let mut of_projection = |i: usize, onto: &Coordinates| {
            let mut y = [0.0; 6];
            cotangent(i, &self.0.metric().difference(&at[i], onto), &mut y);
            direct[i] = self.0.metric().point(&y);
            direct[i]
        };
        self.0.pull_back(&at, &mut of_projection, &mut pulled);
        for (i, (pose, gradient)) in poses.iter().zip(gradients).enumerate() {
            let along: Twist = std::array::from_fn::<f64, 6, _>(|k| direct[i][k] - pulled[i][k]).into();
            *gradient = coordinates_jacobian(pose).transpose() * along;
        }
    }

    fn envelope(&self, fixture_from_tool: &Pose, rows: &mut Residual) {
        let at = coordinates(fixture_from_tool);
        let jacobian = coordinates_jacobian(fixture_from_tool);
        let lengths = self.0.metric().point(&[1.0; 6]);
        for (k, (least, greatest)) in self.0.bounds().into_iter().enumerate() {
            let outside = at[k] - at[k].clamp(least, greatest);
            let scale = if outside == 0.0 { 0.0 } else { lengths[k] / ENVELOPE_LENGTH };
            rows.push(outside * scale, jacobian.row(k).transpose() * scale);
        }
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[0, 1, 2, 3, 4, 5]
    }

    fn residual_kind(&self) -> ResidualKind {
        ResidualKind::ProjectionError
    }
}

//! Six coordinates of a pose, and distances between poses.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Matrix6, Translation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

use crate::se3::Pose;

/// Coordinates `[x, y, z, α, β, γ]` of a pose: position (m), then roll, pitch and yaw (rad) with
/// `R = Rz(γ) Ry(β) Rx(α)`, as in a URDF. Of a pose `a_from_b` the position is that of frame b's
/// origin in frame a.
pub type Coordinates = [f64; 6];

/// Least `cos β` that derivatives divide by: at a pitch of 90° roll and yaw are one.
const LEAST_COSINE: f64 = 1e-6;

/// Coordinates (m, rad) of a pose, roll and yaw within ±π and the pitch within ±π/2; [`pose`] is
/// the inverse. At a pitch of ±π/2 roll and yaw are not unique.
pub fn coordinates(pose: &Pose) -> Coordinates {
    let place = pose.translation.vector;
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    [place.x, place.y, place.z, roll, pitch, yaw]
}

/// The pose with these coordinates (m, rad); angles of any size. Of coordinates that are not finite
/// the pose is not finite.
pub fn pose(coordinates: &Coordinates) -> Pose {
    let [x, y, z, roll, pitch, yaw] = *coordinates;
    Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// `∂c/∂ξ` of the coordinates `c` of `pose · Exp(ξ)` at `ξ = 0`: rows `[x, y, z, α, β, γ]` (m,
/// rad), columns `[v; ω]` (m, rad) in the body's frame. The upper left block is the rotation
/// matrix, the lower right block maps angular velocity to the rates of the angles (Diebel,
/// *Representing attitude* (2006), eq. 76), the others are zero. Near a pitch of ±π/2 the
/// derivative is bounded (1/cos β ≤ 10⁶), not exact.
pub fn coordinates_jacobian(pose: &Pose) -> Matrix6<f64> {
    let (roll, pitch, _) = pose.rotation.euler_angles();
    let (sin_roll, cos_roll) = roll.sin_cos();
    let (sin_pitch, cos_pitch) = pitch.sin_cos();
    let secant = 1.0 / cos_pitch.max(LEAST_COSINE);
    let tangent = sin_pitch * secant;
    #[rustfmt::skip]
    let rates = Matrix3::new(
        1.0, sin_roll * tangent, cos_roll * tangent,
        0.0, cos_roll, -sin_roll,
        0.0, sin_roll * secant, cos_roll * secant,
    );
    let mut jacobian = Matrix6::zeros();
    jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(pose.rotation.to_rotation_matrix().matrix());
    jacobian.fixed_view_mut::<3, 3>(3, 3).copy_from(&rates);
    jacobian
}

/// An angle (rad) brought into ±π by whole turns; NaN if the angle is not finite.
pub fn wrapped(angle: f64) -> f64 {
    if angle.abs() <= PI { angle } else { (angle + PI).rem_euclid(TAU) - PI }
}

/// A distance between poses (m): the Euclidean one of their [`Coordinates`], angles multiplied by a
/// length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Metric {
    /// Length that a radian counts as (m/rad), positive and finite; not checked.
    pub metres_per_radian: f64,
}

impl Metric {
    /// The metric in which a millimetre counts as much as a degree: 0.18/π m/rad, about 57 mm/rad.
    pub const MILLIMETRE_PER_DEGREE: Metric = Metric { metres_per_radian: 0.18 / std::f64::consts::PI };

    /// The coordinates `[x, y, z, α, β, γ]` (m, rad) as a point (six lengths, m) of the space in
    /// which the metric is Euclidean; angles are not wrapped.
    pub fn point(&self, coordinates: &Coordinates) -> [f64; 6] {
        let [x, y, z, roll, pitch, yaw] = *coordinates;
        let length = self.metres_per_radian;
        [x, y, z, roll * length, pitch * length, yaw * length]
    }

    /// Length (m) of a full turn.
    pub(super) fn circumference(&self) -> f64 {
        TAU * self.metres_per_radian
    }

    /// `to − from` as six lengths (m) in the order of [`Coordinates`]: positions, then angle
    /// differences the shorter way round times [`metres_per_radian`](Metric::metres_per_radian).
    pub fn difference(&self, to: &Coordinates, from: &Coordinates) -> [f64; 6] {
        self.point(&std::array::from_fn(|k| if k < 3 { to[k] - from[k] } else { wrapped(to[k] - from[k]) }))
    }

    /// Distance (m) of two poses: the length of their [`difference`](Metric::difference).
    pub fn distance(&self, to: &Coordinates, from: &Coordinates) -> f64 {
        self.difference(to, from).iter().map(|each| each * each).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::se3::{self, Twist};

    #[test]
    fn a_pose_comes_back_and_its_derivative_is_that_of_differences() {
        for c in [[0.01, -0.02, 0.3, 0.1, -0.2, 0.3], [0.0; 6], [1.0, 2.0, -3.0, -2.0, 1.2, 3.0]] {
            let at = pose(&c);
            let back = coordinates(&at);
            assert!(c.iter().zip(back).all(|(a, b)| (a - b).abs() < 1e-12), "{c:?} {back:?}");
            let jacobian = coordinates_jacobian(&at);
            for k in 0..6 {
                let mut step = Twist::zeros();
                step[k] = 1e-6;
                let (ahead, behind) = (coordinates(&(at * se3::exp(&step))), coordinates(&(at * se3::exp(&-step))));
                for i in 0..6 {
                    let slope = (ahead[i] - behind[i]) / 2e-6;
                    assert!((slope - jacobian[(i, k)]).abs() < 1e-8, "{c:?} ({i}, {k}): {slope} {}", jacobian[(i, k)]);
                }
            }
        }
    }

    #[test]
    fn a_degree_is_a_millimetre() {
        let point = Metric::MILLIMETRE_PER_DEGREE.point(&[0.0, 0.0, 0.0, 1f64.to_radians(), 0.0, 0.0]);
        assert!((point[3] - 1e-3).abs() < 1e-15);
        let (ahead, behind) = ([0.0, 0.0, 3e-3, 3.1, 0.0, 0.0], [0.0, 0.0, 0.0, -3.1, 0.0, 0.0]);
        let turn = (TAU - 6.2) * Metric::MILLIMETRE_PER_DEGREE.metres_per_radian;
        let distance = Metric::MILLIMETRE_PER_DEGREE.distance(&ahead, &behind);
        assert!((distance - turn.hypot(3e-3)).abs() < 1e-15, "{distance}");
    }
}

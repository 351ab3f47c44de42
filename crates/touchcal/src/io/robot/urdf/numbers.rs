//! Origins as URDF writes them: `xyz` (m) and `rpy` (rad), fixed-axis roll, pitch and yaw.

use nalgebra::{Translation3, UnitQuaternion};

use crate::se3::Pose;

/// Smaller numbers (m, rad) are rounding errors and are written as 0.
const NEGLIGIBLE: f64 = 1e-15;

/// The pose `Rz(yaw) · Ry(pitch) · Rx(roll)` at `xyz`.
pub(super) fn pose(xyz: [f64; 3], rpy: [f64; 3]) -> Pose {
    let rotation = UnitQuaternion::from_euler_angles(rpy[0], rpy[1], rpy[2]);
    Pose::from_parts(Translation3::new(xyz[0], xyz[1], xyz[2]), rotation)
}

/// Roll, pitch and yaw of a rotation.
///
/// Roll is taken from what remains once yaw is undone, so where pitch is near ±90° and yaw is
/// undetermined, an arbitrary yaw is answered by the roll that belongs to it, and the rotation is
/// kept to rounding.
pub(crate) fn roll_pitch_yaw(rotation: &UnitQuaternion<f64>) -> [f64; 3] {
    let matrix = rotation.to_rotation_matrix();
    let r = matrix.matrix();
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let (sin, cos) = yaw.sin_cos();
    let pitch = (-r[(2, 0)]).atan2(cos * r[(0, 0)] + sin * r[(1, 0)]);
    let roll = (sin * r[(0, 2)] - cos * r[(1, 2)]).atan2(cos * r[(1, 1)] - sin * r[(0, 1)]);
    [roll, pitch, yaw]
}

/// Numbers as an attribute value, each with as many digits as it takes to read the same number
/// back, and without exponent.
pub(crate) fn written<const N: usize>(numbers: [f64; N]) -> String {
    let words = numbers.map(|number| if number.abs() < NEGLIGIBLE { "0".to_owned() } else { format!("{number}") });
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn rpy_survives_everywhere_and_at_gimbal_lock() {
        let angles = [-PI, -2.0, -FRAC_PI_2, -1e-9, 0.0, 0.3, FRAC_PI_2 - 1e-8, FRAC_PI_2, 3.0];
        for roll in angles {
            for pitch in [-FRAC_PI_2, -FRAC_PI_2 + 1e-9, -1.0, 0.0, 1e-7, 1.2, FRAC_PI_2 - 1e-7, FRAC_PI_2, 2.0] {
                for yaw in angles {
                    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
                    let [r, p, y] = roll_pitch_yaw(&rotation);
                    let back = UnitQuaternion::from_euler_angles(r, p, y);
                    let error = (back.to_rotation_matrix().matrix() - rotation.to_rotation_matrix().matrix()).norm();
                    assert!(error < 3e-15, "{roll} {pitch} {yaw}: {error}");
                }
            }
        }
    }

    #[test]
    fn roll_turns_about_x_first() {
        let rotation = pose([0.0; 3], [FRAC_PI_2, 0.0, FRAC_PI_2]).rotation;
        let turned = rotation * nalgebra::Vector3::y();
        assert!((turned - nalgebra::Vector3::z()).norm() < 1e-15);
    }
}

//! The declared pose of the tool that results are relative to, as their files have it.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use super::error::{IoError, Place};
use crate::se3::Pose;

/// Largest distance (m) and angle (rad) between poses that files round differently.
const SAME_PLACE: f64 = 1e-6;
const SAME_ANGLE: f64 = 1e-4;

/// A pose as x, y, z (m), qw, qx, qy, qz.
pub(crate) fn seven(pose: &Pose) -> [f64; 7] {
    let ([x, y, z], [i, j, k, w]): ([f64; 3], [f64; 4]) = (pose.translation.vector.into(), pose.rotation.coords.into());
    [x, y, z, w, i, j, k]
}

/// The pose of such numbers.
pub(crate) fn of_seven([x, y, z, w, i, j, k]: [f64; 7]) -> Pose {
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    Pose::from_parts(Translation3::new(x, y, z), rotation)
}

/// A tool's place as problem.toml states it.
pub(crate) fn as_declared(tip_from_tool: &Pose) -> String {
    let [x, y, z]: [f64; 3] = tip_from_tool.translation.vector.map(|metres| 1e3 * metres).into();
    let [i, j, k, w]: [f64; 4] = tip_from_tool.rotation.coords.into();
    format!("{{ xyz_mm = [{x:.4}, {y:.4}, {z:.4}], quat_wxyz = [{w:.7}, {i:.7}, {j:.7}, {k:.7}] }}")
}

/// Checks that the tool of a problem is at `nominal`; `whose` says in words what has it there, and
/// why it must be the same.
///
/// # Errors
/// [`IoError`] if `tip_from_tool` is another pose.
pub(crate) fn check_same(nominal: &Pose, tip_from_tool: &Pose, whose: &str) -> Result<(), IoError> {
    let between = nominal.inv_mul(tip_from_tool);
    if between.translation.vector.norm() < SAME_PLACE && between.rotation.angle() < SAME_ANGLE {
        return Ok(());
    }
    let expected = format!("{} {whose}", as_declared(nominal));
    let place = Place::file("tool").field("tip_from_tool");
    Err(IoError::unexpected(place, expected, as_declared(tip_from_tool)))
}

//! Arrays of numbers, and poses among them: seven numbers `x, y, z` (m), `qw, qx, qy, qz`, as in
//! files, or 4 × 4 matrices.

use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion};
use numpy::ndarray::{ArrayViewD, Axis};
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLikeDyn, PyArrayMethods};
use pyo3::prelude::*;
use touchcal::se3::Pose;

use crate::error::unexpected;
use crate::plausible;

/// Anything that numpy takes for an array of numbers; arrays of float64 are not copied.
pub type Numbers<'py> = PyArrayLikeDyn<'py, f64, AllowTypeChange>;

/// How far a quaternion's norm may be from 1, and a matrix from a rotation, before it is taken for
/// a mistake.
const TOLERANCE: f64 = 1e-3;

/// `values` as an array that cannot be written to. They are moved, not copied.
pub fn fixed(py: Python<'_>, values: Vec<f64>) -> Bound<'_, PyArray1<f64>> {
    let array = PyArray1::from_vec(py, values);
    array.readwrite().make_nonwriteable();
    array
}

/// The same in rows of `columns` numbers.
pub fn fixed_rows(py: Python<'_>, values: Vec<f64>, columns: usize) -> PyResult<Bound<'_, PyArray2<f64>>> {
    let rows = values.len() / columns.max(1);
    let array = PyArray1::from_vec(py, values).reshape([rows, columns])?;
    array.readwrite().make_nonwriteable();
    Ok(array)
}

/// Seven numbers a pose.
pub fn numbers(pose: &Pose) -> [f64; 7] {
    let (t, r) = (&pose.translation.vector, pose.rotation.quaternion());
    [t.x, t.y, t.z, r.w, r.i, r.j, r.k]
}

/// Poses as an array of shape (N, 7).
pub fn poses_array<'py>(py: Python<'py>, poses: &[Pose]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    fixed_rows(py, poses.iter().flat_map(numbers).collect(), 7)
}

/// One pose of shape (7,) or (4, 4) with a translation of at most 10 m; `what` is its name for
/// messages.
pub fn one_pose(given: &Numbers<'_>, what: &str) -> PyResult<Pose> {
    let pose = of_view(&given.as_array(), what)?;
    let far = pose.translation.vector.norm();
    if far > plausible::REACH {
        let expected = format!("a translation of at most {} m (lengths are metres)", plausible::REACH);
        return Err(unexpected(what, expected, format!("{far} m")));
    }
    Ok(pose)
}

/// Poses of shape (N, 7) or (N, 4, 4).
pub fn many_poses(given: &Numbers<'_>, what: &str) -> PyResult<Vec<Pose>> {
    let view = given.as_array();
    match view.shape() {
        [_, 7] | [_, 4, 4] => view.axis_iter(Axis(0)).map(|pose| of_view(&pose.into_dyn(), what)).collect(),
        shape => Err(unexpected(what, "poses of shape (N, 7) or (N, 4, 4)", format!("shape {shape:?}"))),
    }
}

fn of_view(view: &ArrayViewD<'_, f64>, what: &str) -> PyResult<Pose> {
    if let Some(bad) = view.iter().find(|value| !value.is_finite()) {
        return Err(unexpected(what, "finite numbers", format!("{bad}")));
    }
    match view.shape() {
        [7] => {
            let quaternion = Quaternion::new(view[[3]], view[[4]], view[[5]], view[[6]]);
            Ok(Pose::from_parts(Translation3::new(view[[0]], view[[1]], view[[2]]), rotation(quaternion, what)?))
        }
        [4, 4] => {
            let matrix = Matrix3::from_fn(|i, k| view[[i, k]]);
            let last = [view[[3, 0]], view[[3, 1]], view[[3, 2]], view[[3, 3]]];
            let off = (matrix * matrix.transpose() - Matrix3::identity()).amax();
            if off > TOLERANCE || matrix.determinant() < 0.0 || last != [0.0, 0.0, 0.0, 1.0] {
                return Err(unexpected(what, "a rigid motion as a 4 × 4 matrix", "another matrix"));
            }
            let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix(&matrix));
            Ok(Pose::from_parts(Translation3::new(view[[0, 3]], view[[1, 3]], view[[2, 3]]), rotation))
        }
        shape => Err(unexpected(what, "a pose of shape (7,) or (4, 4)", format!("shape {shape:?}"))),
    }
}

fn rotation(quaternion: Quaternion<f64>, what: &str) -> PyResult<UnitQuaternion<f64>> {
    let norm = quaternion.norm();
    if (norm - 1.0).abs() > TOLERANCE {
        return Err(unexpected(what, "a quaternion of norm 1", format!("norm {norm}")));
    }
    Ok(UnitQuaternion::from_quaternion(quaternion))
}

/// A pose of shape (7,) from a place and a rotation.
///
/// Args:
///     xyz: translation (m).
///     quat_wxyz: rotation as a quaternion of norm 1, or
///     rpy: as roll, pitch and yaw (rad) about the fixed axes x, y, z in this order, as in URDF.
#[pyfunction]
#[pyo3(signature = (xyz=[0.0; 3], *, quat_wxyz=None, rpy=None), text_signature = "(xyz=(0.0, 0.0, 0.0), *, quat_wxyz=None, rpy=None)")]
pub fn pose(
    py: Python<'_>,
    xyz: [f64; 3],
    quat_wxyz: Option<[f64; 4]>,
    rpy: Option<[f64; 3]>,
) -> PyResult<Bound<'_, PyArray1<f64>>> {
    let rotation = match (quat_wxyz, rpy) {
        (None, None) => UnitQuaternion::identity(),
        (Some([w, x, y, z]), None) => rotation(Quaternion::new(w, x, y, z), "quat_wxyz")?,
        (None, Some([roll, pitch, yaw])) => {
            [roll, pitch, yaw].into_iter().try_for_each(|angle| plausible::angle("rpy", angle, 2.0))?;
            UnitQuaternion::from_euler_angles(roll, pitch, yaw)
        }
        (Some(_), Some(_)) => return Err(unexpected("pose", "quat_wxyz or rpy", "both")),
    };
    Ok(fixed(py, numbers(&Pose::from_parts(xyz.into(), rotation)).to_vec()))
}

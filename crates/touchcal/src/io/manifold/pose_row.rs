//! A row of a table of poses.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use crate::io::base::csv::{hint, names, same};
use crate::io::base::error::{IoError, Place};
use crate::se3::Pose;

/// Largest number of poses of one file, 56 bytes of memory each; more are an error.
pub const MAX_POSES: usize = 10_000_000;

pub(crate) const COLUMNS: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];
/// Largest coordinate (m). A larger one is in another unit.
const LARGEST: f64 = 10.0;
/// How far a quaternion's norm may be from 1 (rounded digits) before it is taken for a mistake.
const NORM_TOLERANCE: f64 = 1e-3;

/// Indices of the columns used.
pub(crate) fn columns(cells: &[&[u8]], place: Place) -> Result<[usize; 7], IoError> {
    let mut used = [0; 7];
    for (column, name) in used.iter_mut().zip(COLUMNS) {
        let is = |k: &usize| std::str::from_utf8(cells[*k]).is_ok_and(|cell| same(cell, name));
        let mut found = (0..cells.len()).filter(is);
        *column = match (found.next(), found.next()) {
            (Some(only), None) => only,
            (Some(first), Some(second)) => {
                let found = format!("`{name}` twice (columns {} and {})", first + 1, second + 1);
                return Err(IoError::unexpected(place, "distinct column names", found));
            }
            _ => {
                let expected = format!("a header with {}; `{name}` is missing", COLUMNS.join(","));
                return Err(IoError::unexpected(place, expected, format!("{}{}", names(cells), hint(cells))));
            }
        };
    }
    Ok(used)
}

/// The pose of a row.
pub(crate) fn pose(values: &[f64; 7], place: Place) -> Result<Pose, IoError> {
    let [x, y, z, qw, qx, qy, qz] = *values;
    if let Some(k) = (0..3).find(|&k| values[k].abs() > LARGEST) {
        let found = format!("{}: in millimetres?", values[k]);
        let place = place.field(format!("column {}", COLUMNS[k]));
        return Err(IoError::unexpected(place, format!("metres within ±{LARGEST}"), found));
    }
    let quaternion = Quaternion::new(qw, qx, qy, qz);
    let norm = quaternion.norm();
    if (norm - 1.0).abs() > NORM_TOLERANCE {
        return Err(IoError::unexpected(place, "a quaternion qw,qx,qy,qz of norm 1", format!("norm {norm}")));
    }
    Ok(Pose::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_quaternion(quaternion)))
}

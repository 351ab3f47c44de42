//! Poses of a tool in contact, `fixture_from_tool`, as comma-separated values, plain or gzipped, or
//! (cargo feature `parquet`) as Parquet.
//!
//! A row is a pose. The header names the columns `x,y,z` (m) and `qw,qx,qy,qz` (a quaternion of
//! norm 1), whatever their case and order; others are ignored.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use super::bytes::{self, Hashing, Input};
use super::contact_csv::header::{hint, names};
use super::contact_csv::lines::{Lines, fields};
use super::contact_csv::rows::{finite, shown};
use super::contact_csv::unpacked;
use super::contact_log::joints::same;
use super::error::{IoError, Place};
use crate::manifold::{PoseSamples, SamplesError};
use crate::se3::Pose;

/// Most poses of one file, 56 bytes of memory each.
pub const MAX_POSES: usize = 10_000_000;

pub(super) const COLUMNS: [&str; 7] = ["x", "y", "z", "qw", "qx", "qy", "qz"];
/// What a Parquet file begins with.
const PARQUET: &[u8] = b"PAR1";
/// Largest coordinate (m). A larger one is in another unit.
const LARGEST: f64 = 10.0;
/// How far a quaternion's norm may be from 1 (rounded digits) before it is taken for a mistake.
const NORM_TOLERANCE: f64 = 1e-3;

/// Reads the poses of a file's content; `file` is its name for messages.
///
/// # Errors
/// If the content is no such table, or too large.
pub fn read(content: impl Read, file: &str) -> Result<Vec<Pose>, IoError> {
    let mut lines = Lines::new(unpacked(content, file)?, file);
    let place = Place::file(file);
    let Some((number, header)) = lines.next()? else {
        return Err(IoError::unexpected(place, format!("a header with {}", COLUMNS.join(",")), "an empty file"));
    };
    let cells: Vec<&[u8]> = fields(header).collect();
    let (count, used) = (cells.len(), columns(&cells, place.clone().line(number))?);
    let mut poses = Vec::new();
    while let Some((number, line)) = lines.next()? {
        let place = place.clone().line(number);
        if poses.len() == MAX_POSES {
            return Err(IoError::unexpected(place, format!("at most {MAX_POSES} poses"), "more"));
        }
        let (mut values, mut columns) = ([0.0; 7], 0);
        for (index, cell) in fields(line).enumerate() {
            columns += 1;
            if let Some(k) = used.iter().position(|&column| column == index) {
                values[k] = finite(cell).ok_or_else(|| {
                    let field = format!("column {}", COLUMNS[k]);
                    IoError::unexpected(place.clone().field(field), "a number", shown(cell))
                })?;
            }
        }
        if columns != count {
            return Err(IoError::unexpected(place, format!("{count} columns, as in the header"), format!("{columns}")));
        }
        poses.push(pose(&values, place)?);
    }
    Ok(poses)
}

/// Reads a file of poses as samples of a manifold, and its fingerprint.
///
/// # Errors
/// As [`read`], if the file cannot be read, or if its poses are fewer than two different ones.
pub fn read_file(path: &Path) -> Result<(PoseSamples, Input), IoError> {
    let name = path.display().to_string();
    let failed = |source| IoError::file(path, "read", source);
    let mut file = bytes::open(path)?;
    let mut start = Vec::new();
    file.by_ref().take(PARQUET.len() as u64).read_to_end(&mut start).map_err(failed)?;
    file.rewind().map_err(failed)?;
    let mut hashing = Hashing::new(file.try_clone().map_err(failed)?);
    let poses = if start == PARQUET { read_parquet(file, &name)? } else { read(&mut hashing, &name)? };
    let samples = PoseSamples::from_poses(&poses).map_err(|error| no_samples(Place::file(&name), &error))?;
    let sha256 = hashing.finish().map_err(failed)?;
    Ok((samples, Input { path: name, sha256 }))
}

#[cfg(feature = "parquet")]
fn read_parquet(mut content: File, file: &str) -> Result<Vec<Pose>, IoError> {
    let failed = |source| IoError::file(Path::new(file), "read", source);
    let poses = super::pose_parquet::read(content.try_clone().map_err(failed)?, file)?;
    // Its other handle, which is fingerprinted, shares the position.
    content.rewind().map_err(failed)?;
    Ok(poses)
}

#[cfg(not(feature = "parquet"))]
fn read_parquet(_: File, file: &str) -> Result<Vec<Pose>, IoError> {
    let found = "Parquet, which only a build with the cargo feature `parquet` reads";
    Err(IoError::unexpected(Place::file(file), "CSV or gzipped CSV", found))
}

/// Poses that are no samples, as an error of the file that they were read from.
pub(crate) fn no_samples(place: Place, error: &SamplesError) -> IoError {
    match error {
        SamplesError::TooFew { distinct, count } => {
            IoError::unexpected(place, "at least two different poses", format!("{distinct} in {count}"))
        }
        SamplesError::NotFinite { index, value } => {
            IoError::unexpected(place.field(format!("pose {}", index + 1)), "finite numbers", format!("{value}"))
        }
    }
}

/// Indices of the columns used.
pub(super) fn columns(cells: &[&[u8]], place: Place) -> Result<[usize; 7], IoError> {
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
pub(super) fn pose(values: &[f64; 7], place: Place) -> Result<Pose, IoError> {
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

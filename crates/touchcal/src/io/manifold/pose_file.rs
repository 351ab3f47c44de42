//! Poses of a tool in contact, `fixture_from_tool`, as comma-separated values, plain or gzipped, or
//! (cargo feature `parquet`) as Parquet.
//!
//! A row is a pose. The header names the columns `x,y,z` (m) and `qw,qx,qy,qz` (a quaternion of
//! norm 1), whatever their case and order; others are ignored.

use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

#[cfg(feature = "parquet")]
use super::pose_parquet;
use super::pose_row::{COLUMNS, columns, pose};
use crate::io::base::bytes::{self, Hashing, Input};
use crate::io::base::csv::{Lines, fields, finite, shown, unpacked};
use crate::io::base::error::{IoError, Place};
use crate::manifold::{PoseSamples, SamplesError};
use crate::se3::Pose;

pub use super::pose_row::MAX_POSES;

/// What a Parquet file begins with.
const PARQUET: &[u8] = b"PAR1";
/// Reads the poses `fixture_from_tool` (m) of a file's content, CSV plain or gzipped, in order;
/// `file` is its name for messages. Quaternions are normalized. A header without rows gives no
/// poses.
///
/// # Errors
/// [`IoError`] if the content cannot be read, is of another format, is empty, lacks a column or has
/// one twice, has a cell that is no finite number or a row of another number of columns than the
/// header, a coordinate exceeds 10 m, a quaternion's norm is not 1 within 10⁻³, there are more than
/// [`MAX_POSES`], or the content is larger than
/// [`contact_csv::MAX_BYTES`](crate::io::contact_csv::MAX_BYTES) when unpacked or has a line longer
/// than [`contact_csv::MAX_LINE`](crate::io::contact_csv::MAX_LINE).
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

/// Reads a file of poses `fixture_from_tool` (CSV, gzipped CSV or Parquet, known by its first
/// bytes) as samples of a manifold, in the order of its rows, and returns its fingerprint too.
///
/// # Errors
/// As [`read`], if the file cannot be read or needs a cargo feature that this build lacks, or if it
/// has fewer than two different poses.
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
    Ok((samples, Input { path: name, sha256, is_log: false }))
}

#[cfg(feature = "parquet")]
fn read_parquet(mut content: File, file: &str) -> Result<Vec<Pose>, IoError> {
    let failed = |source| IoError::file(Path::new(file), "read", source);
    let poses = pose_parquet::read(content.try_clone().map_err(failed)?, file)?;
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

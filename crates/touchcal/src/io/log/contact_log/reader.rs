//! Contact logs of any format, distinguished by their first bytes.

use std::ffi::OsString;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

#[cfg(feature = "mcap")]
use super::mcap::read as read_mcap;
use super::options::Options;
#[cfg(feature = "parquet")]
use super::parquet;
use super::rows::RowSink;
use crate::contact::{ContactIngest, ContactLog, KnownRows};
use crate::io::base::bytes::{self, Hashing, Input};
use crate::io::base::error::{IoError, Place};
use crate::io::base::suggest::list;
use crate::io::log::contact_csv;
use crate::robot::Robot;

/// What a Parquet file begins with.
const PARQUET: &[u8] = b"PAR1";
/// What an MCAP file begins with.
const MCAP: &[u8] = b"\x89MCAP";
/// What the folder of a bag may hold beside its files.
const BAG_CONTENTS: &str = "metadata.yaml";

/// Adds the contacts of a file, or of the only file in a bag's folder, to `log`, in the order of
/// the rows, and returns the file's fingerprint. The format is known by the first bytes, whatever
/// the file's name. Joint positions are in rad and m, in the order of the moving joints of `robot`,
/// base first; `log` must be one of [`Robot::dof`] joints. Of rows that are equal in all columns of
/// comma-separated values only the first is a contact.
///
/// # Errors
/// [`IoError`] if the file cannot be read or needs a cargo feature that this build lacks, a bag's
/// folder holds several files, `log` would hold more than
/// [`MAX_CONTACTS`](crate::contact::MAX_CONTACTS) contacts, and as [`contact_csv::read`] for a log
/// of any format; in a bag also if a topic is missing or there are two of its type, messages are
/// not in the order of time, or no wrench is within 0.1 s of a joint state. `log` then holds a part
/// of it and should be dropped.
pub fn read_file(path: &Path, robot: &Robot, options: &Options, log: &mut ContactLog) -> Result<Input, IoError> {
    read_new(path, robot, options, (log, &mut KnownRows::default()))
}

/// Adds the contacts of a file as [`read_file`] does, without those that are `known` from other
/// files; those of this file are then known too.
///
/// # Errors
/// As [`read_file`].
pub fn read_new(
    path: &Path,
    robot: &Robot,
    options: &Options,
    (log, known): (&mut ContactLog, &mut KnownRows),
) -> Result<Input, IoError> {
    let path = &log_in(path)?;
    let mut ingest = ContactIngest::new(robot, &path.display().to_string(), options.ingest(), (log, known));
    read_into(path, robot, options, &mut ingest)
}

/// Passes the rows of a file to `sink`, and returns the file's fingerprint.
pub(super) fn read_into(
    path: &Path,
    robot: &Robot,
    options: &Options,
    sink: &mut dyn RowSink,
) -> Result<Input, IoError> {
    let name = path.display().to_string();
    let failed = |source| IoError::file(path, "read", source);
    let mut file = bytes::open(path)?;
    let mut start = Vec::new();
    file.by_ref().take(MCAP.len() as u64).read_to_end(&mut start).map_err(failed)?;
    file.rewind().map_err(failed)?;
    let mut hashing = Hashing::new(file.try_clone().map_err(failed)?);
    if start.starts_with(PARQUET) {
        read_parquet(&file, &name, robot, options, sink)?;
        // The handle that is fingerprinted shares its position.
        file.rewind().map_err(failed)?;
    } else if start == MCAP {
        read_mcap(&mut hashing, &name, robot, options, sink)?;
    } else {
        contact_csv::read_into(&mut hashing, &name, robot, options, sink)?;
    }
    let sha256 = hashing.finish().map_err(failed)?;
    Ok(Input { path: name, sha256, is_log: true })
}

/// The file itself, or the only one in the folder of a bag, as `ros2 bag record` makes it.
pub(super) fn log_in(path: &Path) -> Result<PathBuf, IoError> {
    if !path.is_dir() {
        return Ok(path.to_owned());
    }
    let failed = |source| IoError::file(path, "read", source);
    let entries = std::fs::read_dir(path).map_err(failed)?;
    let mut names = entries.map(|entry| Ok(entry?.file_name())).collect::<Result<Vec<_>, _>>().map_err(failed)?;
    let of_bag = |name: &OsString| name == BAG_CONTENTS || Path::new(name).extension() == Some("mcap".as_ref());
    if !names.iter().any(of_bag) {
        return Ok(path.to_owned());
    }
    names.retain(|name| name != BAG_CONTENTS && !name.to_string_lossy().starts_with('.'));
    names.sort();
    match names.as_slice() {
        [only] => Ok(path.join(only)),
        _ => {
            let names: Vec<_> = names.iter().map(|name| name.to_string_lossy()).collect();
            let found = format!("a folder of {}", list(names.iter().map(AsRef::as_ref)));
            let place = Place::file(path.display().to_string());
            Err(IoError::unexpected(place, "the folder of a bag with one file", found))
        }
    }
}

#[cfg(feature = "parquet")]
fn read_parquet(
    content: &File,
    file: &str,
    robot: &Robot,
    options: &Options,
    sink: &mut dyn RowSink,
) -> Result<(), IoError> {
    let content = content.try_clone().map_err(|source| IoError::file(Path::new(file), "read", source))?;
    parquet::read(content, file, robot, options, sink)
}

#[cfg(not(feature = "parquet"))]
fn read_parquet(_: &File, file: &str, _: &Robot, _: &Options, _: &mut dyn RowSink) -> Result<(), IoError> {
    Err(without_feature(file, "Parquet", "parquet"))
}

#[cfg(not(feature = "mcap"))]
fn read_mcap(_: impl Read, file: &str, _: &Robot, _: &Options, _: &mut dyn RowSink) -> Result<(), IoError> {
    Err(without_feature(file, "MCAP", "mcap"))
}

/// A format that this build does not read.
#[cfg(not(all(feature = "mcap", feature = "parquet")))]
fn without_feature(file: &str, format: &str, feature: &str) -> IoError {
    let found = format!("{format}, which only a build with the cargo feature `{feature}` reads");
    IoError::unexpected(Place::file(file), "CSV or gzipped CSV", found)
}

//! Contact logs: which formats there are, and what is the same for all of them.
//!
//! A row is one moment: joint positions, and if there are any a wrench or a contact flag.
//!
//! | format | module | known by |
//! |---|---|---|
//! | comma-separated values, plain or gzipped | [`contact_csv`] | what is none of the others |
//! | ROS 2 bag, MCAP (cargo feature `mcap`) | `mcap` | its first five bytes |
//! | Parquet (cargo feature `parquet`) | `parquet` | its first four bytes |
//! | columns in memory | [`Columns`] | |
//!
//! Which rows are contacts: those a force threshold detects, if one is given; else those flagged,
//! if there are flags; else all.

mod columns;
pub(super) mod joints;
mod load;
#[cfg(feature = "mcap")]
mod mcap;
mod numbers;
#[cfg(feature = "parquet")]
mod parquet;
pub(super) mod rows;
mod table;
mod units;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};

use super::bytes::{self, Hashing, Input};
use super::contact_csv;
use super::error::{IoError, Place};
use super::suggest::list;
use crate::contact::ContactLog;
use crate::robot::Robot;
use rows::Keep;

pub use columns::{Columns, read_columns};
pub use load::{Load, LoadFrame, LoadOn};
pub use table::LogTable;

/// Most contacts of one problem, about 80 bytes of memory each, and 48 for its load.
pub const MAX_CONTACTS: usize = 20_000_000;

/// What a Parquet file begins with.
const PARQUET: &[u8] = b"PAR1";
/// What an MCAP file begins with.
const MCAP: &[u8] = b"\x89MCAP";

/// Unit of the revolute joints' columns; prismatic joints are in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AngleUnit {
    /// Not said: radians, but guessed for logs of KUKA's recorder, with a note.
    #[default]
    Undeclared,
    /// Radians.
    Radian,
    /// Degrees.
    Degree,
}

/// Contact from force: see [`crate::contact::Detector`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Force above which contact begins (N).
    pub threshold: f64,
    /// Force below which contact ends (N).
    pub release: f64,
    /// Rows in a row that either takes.
    pub debounce: usize,
}

/// What the folder of a bag may hold beside its files.
const BAG_CONTENTS: &str = "metadata.yaml";

/// How to understand a log.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Index of the fixture that the contacts touch.
    pub fixture: usize,
    /// Unit of the revolute joints' columns.
    pub unit: AngleUnit,
    /// Names of the columns of a file that has no header line; the names of those that are not used
    /// do not matter.
    pub header: Option<Vec<String>>,
    /// Names of moving joints in the order of the columns `q1`…`qn` and of a file without header;
    /// none: the chain's order.
    pub joints: Option<Vec<String>>,
    /// By usual name (`q1`, a joint's name, `fx`, `contact`): the file's name for that column, or
    /// joint.
    pub columns: BTreeMap<String, String>,
    /// Topic of a bag's joint states; none: the only one of their type.
    pub joint_topic: Option<String>,
    /// Topic of a bag's wrenches; none: the only one of their type.
    pub wrench_topic: Option<String>,
    /// Detects contact by force; needs columns `fx`, `fy`, `fz`, or wrenches.
    pub detection: Option<Detection>,
    /// How far (rad or m) some joint must have moved since the last contact for a row to be another
    /// one; none: every row is.
    pub apart: Option<f64>,
    /// What the wrench says of the load on the arm; none: nothing. Needs columns `fx` to `tz`, or
    /// wrenches.
    pub load: Option<Load>,
}

impl Options {
    /// How much of a wrench rows must have: none, the force, or all.
    pub(super) fn wrench_parts(&self) -> usize {
        if self.load.is_some() {
            6
        } else if self.detection.is_some() {
            3
        } else {
            0
        }
    }
}

/// Adds the contacts of a file, whatever its format, or of a bag's folder, to `log`, and returns
/// the file's fingerprint.
///
/// # Errors
/// If the file cannot be read, is no such log, or too large. `log` then holds a part of it and
/// should be dropped.
pub fn read_file(path: &Path, robot: &Robot, options: &Options, log: &mut ContactLog) -> Result<Input, IoError> {
    read_into(path, robot, options, Keep::Contacts(log))
}

fn read_into(path: &Path, robot: &Robot, options: &Options, keep: Keep<'_>) -> Result<Input, IoError> {
    let path = &log_in(path)?;
    let name = path.display().to_string();
    let failed = |source| IoError::file(path, "read", source);
    let mut file = bytes::open(path)?;
    let mut start = Vec::new();
    file.by_ref().take(MCAP.len() as u64).read_to_end(&mut start).map_err(failed)?;
    file.rewind().map_err(failed)?;
    let mut hashing = Hashing::new(file.try_clone().map_err(failed)?);
    if start.starts_with(PARQUET) {
        read_parquet(&file, &name, robot, options, keep)?;
        // The handle that is fingerprinted shares its position.
        file.rewind().map_err(failed)?;
    } else if start == MCAP {
        read_mcap(&mut hashing, &name, robot, options, keep)?;
    } else {
        contact_csv::read_into(&mut hashing, &name, robot, options, keep)?;
    }
    let sha256 = hashing.finish().map_err(failed)?;
    Ok(Input { path: name, sha256 })
}

/// The file itself, or the only one in the folder of a bag, as `ros2 bag record` makes it.
fn log_in(path: &Path) -> Result<PathBuf, IoError> {
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
fn read_parquet(content: &File, file: &str, robot: &Robot, options: &Options, keep: Keep<'_>) -> Result<(), IoError> {
    let content = content.try_clone().map_err(|source| IoError::file(Path::new(file), "read", source))?;
    parquet::read(content, file, robot, options, keep)
}

#[cfg(not(feature = "parquet"))]
fn read_parquet(_: &File, file: &str, _: &Robot, _: &Options, _: Keep<'_>) -> Result<(), IoError> {
    Err(without_feature(file, "Parquet", "parquet"))
}

#[cfg(feature = "mcap")]
use mcap::read as read_mcap;

#[cfg(not(feature = "mcap"))]
fn read_mcap(_: impl Read, file: &str, _: &Robot, _: &Options, _: Keep<'_>) -> Result<(), IoError> {
    Err(without_feature(file, "MCAP", "mcap"))
}

/// A format that this build does not read.
#[cfg(not(all(feature = "mcap", feature = "parquet")))]
fn without_feature(file: &str, format: &str, feature: &str) -> IoError {
    let found = format!("{format}, which only a build with the cargo feature `{feature}` reads");
    IoError::unexpected(Place::file(file), "CSV or gzipped CSV", found)
}

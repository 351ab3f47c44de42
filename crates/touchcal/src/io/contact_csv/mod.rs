//! Contact logs as comma-separated values, plain or gzipped.
//!
//! With a header, columns are found by name, whatever their case and order, and others are ignored:
//! the URDF's joint names or `q1`…`qn`; `fx,fy,fz,tx,ty,tz`; `contact` (0, 1, true or false).
//! Without one, the columns are the joints in order and nothing else, or what [`Options::header`]
//! declares.
//!
//! Logs of KUKA's Sunrise recorder are read as they are (separated by blanks, their header begun
//! with `%`) or made into CSV: `axisQMsr…[0]` is `q1`, `cartForce1_X` is `fx`, `cartTorque1_TauX`
//! is `tx`. Angles are radians or degrees there; if that is not declared it is guessed.

pub(super) mod header;
mod kuka;
pub(super) mod lines;
pub(super) mod rows;

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;

use super::contact_log::rows::Keep;
use super::contact_log::{AngleUnit, Options};
use super::error::{IoError, Place};
use crate::contact::ContactLog;
use crate::robot::Robot;

/// Most bytes of one log, unpacked: about 20 million rows of seven joints.
pub const MAX_BYTES: u64 = 2 << 30;
/// Most bytes of one line.
pub const MAX_LINE: usize = 1 << 16;

/// What to do with a bag in a format that is not read.
const CONVERT: &str =
    "to make MCAP of it: `pip install rosbags`, then `rosbags-convert --src BAG --dst NEW --dst-storage mcap`";

/// Bytes read from the file at a time.
const BUFFER: usize = 1 << 18;

/// Adds the contacts of a log, plain or gzipped, to `log`; `file` is its name for messages and
/// provenance.
///
/// # Errors
/// If the content is not such a log or too large. `log` then holds a part of it and should be
/// dropped.
pub fn read(
    content: impl Read,
    file: &str,
    robot: &Robot,
    options: &Options,
    log: &mut ContactLog,
) -> Result<(), IoError> {
    read_into(content, file, robot, options, Keep::Contacts(log))
}

pub(super) fn read_into(
    content: impl Read,
    file: &str,
    robot: &Robot,
    options: &Options,
    keep: Keep<'_>,
) -> Result<(), IoError> {
    rows::read(unpacked(content, file)?, file, robot, options, keep)
}

/// The text of a table, plain or gzipped; other formats are refused.
pub(super) fn unpacked<'c>(content: impl Read + 'c, file: &str) -> Result<Box<dyn BufRead + 'c>, IoError> {
    let mut content = BufReader::with_capacity(BUFFER, content);
    let start = content.fill_buf().map_err(|source| IoError::file(Path::new(file), "read", source))?;
    refuse_other_formats(start, file)?;
    if start.starts_with(&[0x1f, 0x8b]) {
        return Ok(Box::new(BufReader::with_capacity(BUFFER, MultiGzDecoder::new(content))));
    }
    Ok(Box::new(content))
}

fn refuse_other_formats(start: &[u8], file: &str) -> Result<(), IoError> {
    let bags: [(&[u8], &str); 2] =
        [(b"SQLite format 3\0", "a ROS 2 bag in SQLite (.db3)"), (b"#ROSBAG V2.0", "a ROS 1 bag")];
    if let Some((_, name)) = bags.iter().find(|(magic, _)| start.starts_with(magic)) {
        return Err(IoError::unexpected(Place::file(file), "CSV or gzipped CSV", format!("{name}; {CONVERT}")));
    }
    let known: [(&[u8], &str); 6] = [
        (b"PAR1", "Parquet"),
        (b"\x89MCAP0", "MCAP"),
        (b"\x28\xb5\x2f\xfd", "a file packed by zstd: unpack it first (`zstd -d FILE`)"),
        (b"PK\x03\x04", "a zip archive or spreadsheet"),
        (b"\xff\xfe", "text in UTF-16"),
        (b"\xfe\xff", "text in UTF-16"),
    ];
    match known.iter().find(|(magic, _)| start.starts_with(magic)) {
        Some((_, name)) => Err(IoError::unexpected(Place::file(file), "CSV or gzipped CSV", *name)),
        None => Ok(()),
    }
}

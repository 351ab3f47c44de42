//! A log in memory: columns of numbers, under the names that a file's header has.

use super::numbers::NumberRows;
use super::options::Options;
use crate::contact::{ContactIngest, ContactLog, KnownRows};
use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place};
use crate::robot::Robot;

/// A log in memory: named columns of numbers, one row per moment.
pub struct Columns<'a> {
    /// Names of the columns, as in the header of a file: joints, `fx` … `tz`, `contact`. Other
    /// names are passed over; two equal ones are an error if they are used.
    pub names: &'a [String],
    /// Number of rows (> 0), in the order of time.
    pub rows: usize,
    /// `value(row, column)`: the number in a row and column, both from 0 and below `rows` and the
    /// number of names, in the units of a file (the contact flag 0 or 1). Called for columns with a
    /// known name only, more than once for each number.
    pub value: &'a dyn Fn(usize, usize) -> f64,
}

/// Adds the contacts of columns in memory to `log`, as [`super::read_file`] does those of a file;
/// `name` stands for the file in messages, the first row is line 1. [`Options::header`] and the
/// topics are ignored.
///
/// Returns `name` with the SHA-256 of the numbers used: row by row, the used columns in their
/// order, as 64-bit numbers, lowest byte first.
///
/// # Errors
/// [`IoError`] if there are no rows, the column of a joint or of a wrench that `options` need is
/// missing, a number is not finite or a flag neither 0 nor 1, joint positions do not fit the joint
/// limits in their unit, `log` would hold more than [`MAX_CONTACTS`](crate::contact::MAX_CONTACTS)
/// contacts, or `options` name a joint or column that does not exist. `log` then holds a part of
/// the rows and should be dropped.
pub fn read_columns(
    columns: &Columns<'_>,
    name: &str,
    robot: &Robot,
    options: &Options,
    log: &mut ContactLog,
) -> Result<Input, IoError> {
    let names: Vec<&[u8]> = columns.names.iter().map(|name| name.as_bytes()).collect();
    let at = |file: &str, row| Place::file(file).line(row);
    let mut known = KnownRows::default();
    let mut ingest = ContactIngest::new(robot, name, options.ingest(), (log, &mut known));
    let mut rows = NumberRows::new(&names, (name, at), (robot, options), &mut ingest)?;
    let used: Vec<usize> = rows.used().map(|(column, _)| column).collect();
    for row in 0..columns.rows {
        rows.take(|k| (columns.value)(row, used[k]))?;
    }
    rows.finish()?;
    let values = (0..columns.rows).flat_map(|row| used.iter().map(move |&column| (columns.value)(row, column)));
    let sha256 = bytes::sha256_of_parts(values.map(f64::to_le_bytes));
    Ok(Input { path: name.to_owned(), sha256, is_log: true })
}

//! Contact logs as Parquet: the columns of [`contact_csv`](crate::io::contact_csv) with a header, of numbers (the contact flag may be BOOLEAN),
//! uncompressed, snappy or gzip. A few thousand rows are in memory at a time.

use parquet::file::reader::{ChunkReader, FileReader, SerializedFileReader};

use super::Options;
use super::numbers::NumberRows;
use crate::contact::ContactLog;
use crate::io::error::{IoError, Place};
use crate::io::number_columns::{NumberColumns, caught, damaged};
use crate::robot::Robot;

/// Adds the contacts of a file's content to `log`; `file` is its name for messages and provenance.
pub(super) fn read(
    content: impl ChunkReader + 'static,
    file: &str,
    robot: &Robot,
    options: &Options,
    log: &mut ContactLog,
) -> Result<(), IoError> {
    caught(file, || read_groups(content, file, robot, options, log))
}

fn read_groups(
    content: impl ChunkReader + 'static,
    file: &str,
    robot: &Robot,
    options: &Options,
    log: &mut ContactLog,
) -> Result<(), IoError> {
    let reader = SerializedFileReader::new(content).map_err(|error| damaged(file, &error))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let names: Vec<&[u8]> = schema.columns().iter().map(|column| column.name().as_bytes()).collect();
    let at = |file: &str, row| Place::file(file).field(format!("row {row}"));
    let mut rows = NumberRows::new(&names, (file, at), (robot, options), log)?;
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(|error| damaged(file, &error))?;
        let mut numbers = NumberColumns::new(group.as_ref(), rows.used(), file)?;
        loop {
            let count = numbers.advance()?;
            if count == 0 {
                break;
            }
            for row in 0..count {
                rows.take(|k| numbers.value(k, row))?;
            }
        }
    }
    rows.finish()
}

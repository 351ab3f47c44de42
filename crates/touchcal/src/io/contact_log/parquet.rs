//! Contact logs as Parquet: the columns of [`contact_csv`](crate::io::contact_csv) with a header, of numbers (the contact flag may be BOOLEAN),
//! uncompressed, snappy or gzip. A few thousand rows are in memory at a time.

use parquet::file::reader::{ChunkReader, FileReader, SerializedFileReader};

use super::Options;
use super::rows::{ContactRows, Row};
use crate::contact::ContactLog;
use crate::io::contact_csv::header::{Holds, Layout};
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

fn at(file: &str, row: u64) -> Place {
    Place::file(file).field(format!("row {row}"))
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
    let layout = Layout::named(&names, Place::file(file), robot, options)?;
    let mut rows = ContactRows::new(file, at, layout.joint_names(robot.dof()), (robot, options), log);
    let mut row = Row::new(robot.dof());
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(|error| damaged(file, &error))?;
        let used = layout.used.iter().map(|(column, _, name)| (*column, name.as_str()));
        let mut numbers = NumberColumns::new(group.as_ref(), used, file)?;
        loop {
            let count = numbers.advance()?;
            if count == 0 {
                break;
            }
            for index in 0..count {
                let number = rows.count() + 1;
                for (k, (_, holds, name)) in layout.used.iter().enumerate() {
                    let value = numbers.value(k, index);
                    let unfit = |expected| {
                        let place = at(file, number).field(format!("column {name}"));
                        IoError::unexpected(place, expected, format!("{value}"))
                    };
                    match holds {
                        _ if !value.is_finite() => return Err(unfit("a finite number")),
                        Holds::Joint(joint) => row.q[*joint] = value * layout.scale[*joint],
                        Holds::Wrench(k) => row.wrench[*k] = value,
                        Holds::Contact if value == 0.0 || value == 1.0 => row.flag = value == 1.0,
                        Holds::Contact => return Err(unfit("0, 1, true or false")),
                    }
                }
                rows.take(number, &row)?;
            }
        }
    }
    if rows.count() == 0 {
        return Err(IoError::unexpected(Place::file(file), "rows of joint positions", "none"));
    }
    rows.finish()
}

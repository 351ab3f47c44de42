//! Contact logs as comma-separated values, plain or gzipped.
//!
//! With a header, columns are found by name, whatever their case and order, and others are ignored:
//! the URDF's joint names or `q1`…`qn`; `fx,fy,fz,tx,ty,tz`; `contact` (0, 1, true or false); the
//! torques of joints, `tau_` and the joint's name or `tau_1`…`tau_n`, where these are asked for.
//! Without one, the columns are the joints in order and nothing else, or what [`Options::header`]
//! declares.
//!
//! Logs of KUKA's Sunrise recorder are read as they are (separated by blanks, their header begun
//! with `%`) or made into CSV: `axisQMsr…[0]` is `q1`, `cartForce1_X` is `fx`, `cartTorque1_TauX`
//! is `tx`. Angles are radians or degrees there; if that is not declared it is guessed.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Read;

use super::contact_log::layout::{Holds, Layout};
use super::contact_log::options::Options;
use super::contact_log::rows::{LogRows, RowSink};
use crate::contact::{ContactIngest, ContactLog, KnownRows, Row};
use crate::io::base::csv::{Lines, finite, shown, unpacked};
use crate::io::base::error::{IoError, Place};
use crate::io::base::suggest::list;
use crate::robot::Robot;

pub use crate::io::base::csv::{MAX_BYTES, MAX_LINE};

/// Adds the contacts of a log, comma-separated and plain or gzipped, to `log`, in the order of the
/// rows; `file` is its name for messages and provenance. Joint positions are converted to rad and
/// m, in the order of the moving joints of `robot`, base first, and each contact keeps its line.
/// `log` must be one of [`Robot::dof`] joints.
///
/// # Errors
/// [`IoError`] if the content cannot be read, is of another format, is empty or has only a header,
/// lacks the column of a joint or of a wrench that `options` need, has a cell that is no finite
/// number or a row of another number of columns, has joint positions that do not fit the joint
/// limits in their unit, is larger than [`MAX_BYTES`] when unpacked, has a line longer than
/// [`MAX_LINE`], or gives `log` more than [`MAX_CONTACTS`](crate::contact::MAX_CONTACTS) contacts;
/// and if `options` name a joint or column that does not exist. `log` then holds a part of it and
/// should be dropped.
pub fn read(
    content: impl Read,
    file: &str,
    robot: &Robot,
    options: &Options,
    log: &mut ContactLog,
) -> Result<(), IoError> {
    let mut known = KnownRows::default();
    let mut ingest = ContactIngest::new(robot, file, options.ingest(), (log, &mut known));
    read_into(content, file, robot, options, &mut ingest)
}

/// Passes the rows of a log, plain or gzipped, to `sink`.
pub(super) fn read_into(
    content: impl Read,
    file: &str,
    robot: &Robot,
    options: &Options,
    sink: &mut dyn RowSink,
) -> Result<(), IoError> {
    let mut lines = Lines::new(unpacked(content, file)?, file);
    let Some((number, first)) = lines.next()? else {
        return Err(IoError::unexpected(Place::file(file), "rows of joint positions", "an empty file"));
    };
    let layout = Layout::of(first, at(file, number), robot, options)?;
    let first = if layout.has_header { None } else { Some(first.to_vec()) };
    let mut parser = RowParser { row: Row::new(robot.dof()), file, robot, options, layout };
    let mut rows = LogRows::of(&parser.layout, (file, at), (robot, options), sink);
    if let Some(first) = first {
        rows.take(number, parser.parse(number, &first)?)?;
    }
    while let Some((number, line)) = lines.next()? {
        rows.take(number, parser.parse(number, line)?)?;
    }
    if rows.count() == 0 {
        return Err(IoError::unexpected(at(file, number), "rows of joint positions", "only a header"));
    }
    rows.finish()
}

fn at(file: &str, line: u64) -> Place {
    Place::file(file).line(line)
}

struct RowParser<'a> {
    file: &'a str,
    robot: &'a Robot,
    options: &'a Options,
    layout: Layout,
    row: Row,
}

impl RowParser<'_> {
    fn parse(&mut self, number: u64, line: &[u8]) -> Result<&Row, IoError> {
        let mut hasher = DefaultHasher::new();
        line.hash(&mut hasher);
        self.row.fingerprint = Some(hasher.finish());
        let mut used = self.layout.used.iter().peekable();
        let mut count = 0;
        for (index, cell) in self.layout.separator.fields(line).enumerate() {
            count += 1;
            let Some((_, holds, name)) = used.next_if(|(column, _, _)| *column == index) else { continue };
            if let Holds::Contact = holds {
                self.row.flag = flag(cell)
                    .ok_or_else(|| IoError::unexpected(self.place(number, name), self.expected(*holds), shown(cell)))?;
                continue;
            }
            let value = finite(cell)
                .ok_or_else(|| IoError::unexpected(self.place(number, name), self.expected(*holds), shown(cell)))?;
            match holds {
                Holds::Joint(joint) => self.row.q[*joint] = value * self.layout.scale[*joint],
                Holds::Wrench(k) => self.row.wrench[*k] = value,
                Holds::Torque(joint) => self.row.set_torque(*joint, value),
                Holds::Temperature => self.row.temperature = Some(value),
                Holds::Target(k, unit) => {
                    self.row.place.get_or_insert_default()[*k] = value * unit.in_metres();
                }
                Holds::Normal(k) => self.row.normal.get_or_insert_default()[*k] = value,
                Holds::Contact => {}
            }
        }
        if count != self.layout.columns {
            let joints = list(self.robot.moving().map(|joint| joint.name.as_str()));
            let expected = format!("{} columns, as in the first line (joints {joints})", self.layout.columns);
            return Err(IoError::unexpected(at(self.file, number), expected, format!("{count}")));
        }
        Ok(&self.row)
    }

    fn place(&self, line: u64, column: &str) -> Place {
        at(self.file, line).field(format!("column {column}"))
    }

    fn expected(&self, holds: Holds) -> &'static str {
        holds.expected(self.robot, self.options)
    }
}

fn flag(cell: &[u8]) -> Option<bool> {
    match cell {
        b"1" | b"1.0" => Some(true),
        b"0" | b"0.0" => Some(false),
        _ if cell.eq_ignore_ascii_case(b"true") => Some(true),
        _ if cell.eq_ignore_ascii_case(b"false") => Some(false),
        _ => None,
    }
}

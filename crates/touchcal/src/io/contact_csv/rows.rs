//! The rows of a log, one after the other.

use std::io::BufRead;

use super::Options;
use super::header::{Holds, Layout};
use super::lines::Lines;
use crate::io::contact_log::rows::{ContactRows, Keep, Row};
use crate::io::error::{IoError, Place, quoted};
use crate::robot::Robot;

pub(super) fn read(
    content: impl BufRead,
    file: &str,
    robot: &Robot,
    options: &Options,
    keep: Keep<'_>,
) -> Result<(), IoError> {
    let mut lines = Lines::new(content, file);
    let Some((number, first)) = lines.next()? else {
        return Err(IoError::unexpected(Place::file(file), "rows of joint positions", "an empty file"));
    };
    let layout = Layout::of(first, at(file, number), robot, options)?;
    let first = if layout.has_header { None } else { Some(first.to_vec()) };
    let mut parser = RowParser { row: Row::new(robot.dof()), file, robot, options, layout };
    let mut rows = ContactRows::of(&parser.layout, (file, at), (robot, options), keep);
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
                Holds::Contact => {}
            }
        }
        if count != self.layout.columns {
            let joints = crate::io::suggest::list(self.robot.moving().map(|joint| joint.name.as_str()));
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

pub(in crate::io) fn finite(cell: &[u8]) -> Option<f64> {
    let value: f64 = std::str::from_utf8(cell).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
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

pub(in crate::io) fn shown(cell: &[u8]) -> String {
    quoted(&String::from_utf8_lossy(cell))
}

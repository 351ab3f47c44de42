//! The rows of a log, one after the other.

use std::io::BufRead;

use super::header::{Holds, Layout};
use super::lines::{Lines, fields};
use super::units::UnitCheck;
use super::{AngleUnit, MAX_CONTACTS, Options};
use crate::contact::{ContactLog, Detector, Source, Wrench};
use crate::io::error::{IoError, Place, quoted};
use crate::robot::{JointKind, Robot};

/// What a row says.
struct Row {
    q: Vec<f64>,
    wrench: Wrench,
    flag: bool,
}

pub(super) fn read(
    content: impl BufRead,
    file: &str,
    robot: &Robot,
    options: &Options,
    log: &mut ContactLog,
) -> Result<(), IoError> {
    let mut lines = Lines::new(content, file);
    let place = Place::file(file);
    let Some((number, first)) = lines.next()? else {
        return Err(IoError::unexpected(place, "rows of joint positions", "an empty file"));
    };
    let layout = Layout::of(first, Place::file(file).line(number), robot, options)?;
    let first = if layout.has_header { None } else { Some(first.to_vec()) };
    let mut reader = RowReader::new(file, robot, options, layout, log);
    if let Some(first) = first {
        reader.take(number, &first)?;
    }
    while let Some((number, line)) = lines.next()? {
        reader.take(number, line)?;
    }
    if reader.rows == 0 {
        return Err(IoError::unexpected(place.line(number), "rows of joint positions", "only a header"));
    }
    reader.finish()
}

pub(super) struct RowReader<'a> {
    file: &'a str,
    robot: &'a Robot,
    options: &'a Options,
    layout: Layout,
    row: Row,
    units: UnitCheck,
    detector: Option<Detector>,
    source: Source,
    rows: u64,
    log: &'a mut ContactLog,
}

impl<'a> RowReader<'a> {
    pub(super) fn new(
        file: &'a str,
        robot: &'a Robot,
        options: &'a Options,
        layout: Layout,
        log: &'a mut ContactLog,
    ) -> Self {
        RowReader {
            row: Row { q: vec![0.0; robot.dof()], wrench: [0.0; 6], flag: true },
            units: UnitCheck::new(robot, options.unit),
            detector: options.detection.map(|d| Detector::new(d.threshold, d.release, d.debounce)),
            source: Source { file: log.add_file(file), line: 0 },
            rows: 0,
            file,
            robot,
            options,
            layout,
            log,
        }
    }

    /// Takes a row as text.
    fn take(&mut self, number: u64, line: &[u8]) -> Result<(), IoError> {
        self.parse(number, line)?;
        self.accept(number)
    }

    /// Takes a row of numbers: `value(column)`.
    pub(super) fn take_numbers(&mut self, number: u64, value: impl Fn(usize) -> f64) -> Result<(), IoError> {
        for (column, holds, name) in &self.layout.used {
            let value = value(*column);
            let fits = if *holds == Holds::Contact { [0.0, 1.0].contains(&value) } else { value.is_finite() };
            if !fits {
                return Err(IoError::unexpected(self.place(number, name), self.unit(*holds), format!("{value}")));
            }
            match holds {
                Holds::Joint(joint) => self.row.q[*joint] = value * self.layout.scale[*joint],
                Holds::Wrench(k) => self.row.wrench[*k] = value,
                Holds::Contact => self.row.flag = value == 1.0,
            }
        }
        self.accept(number)
    }

    /// The verdict over all rows.
    pub(super) fn finish(self) -> Result<(), IoError> {
        self.units.finish(self.file)?;
        self.log.count_rows(self.rows);
        Ok(())
    }

    /// Logs the row if it is a contact.
    fn accept(&mut self, number: u64) -> Result<(), IoError> {
        self.rows += 1;
        if let Some(joint) = self.units.row(number, &self.row.q) {
            let name = self.column_of(joint);
            let found = format!("{}", self.row.q[joint]);
            return Err(IoError::unexpected(self.place(number, name), "a joint position", found));
        }
        let touching = match &mut self.detector {
            Some(detector) => detector.update(&self.row.wrench),
            None => self.row.flag,
        };
        if touching {
            if self.log.len() >= MAX_CONTACTS {
                let place = Place::file(self.file).line(number);
                return Err(IoError::unexpected(place, format!("at most {MAX_CONTACTS} contacts"), "more"));
            }
            self.log.push(&self.row.q, self.options.fixture, Source { line: number, ..self.source });
        }
        Ok(())
    }

    fn parse(&mut self, number: u64, line: &[u8]) -> Result<(), IoError> {
        let mut used = self.layout.used.iter().peekable();
        let mut count = 0;
        for (index, cell) in fields(line).enumerate() {
            count += 1;
            let Some((_, holds, name)) = used.next_if(|(column, _, _)| *column == index) else { continue };
            if let Holds::Contact = holds {
                self.row.flag = flag(cell)
                    .ok_or_else(|| IoError::unexpected(self.place(number, name), "0, 1, true or false", shown(cell)))?;
                continue;
            }
            let value = finite(cell)
                .ok_or_else(|| IoError::unexpected(self.place(number, name), self.unit(*holds), shown(cell)))?;
            match holds {
                Holds::Joint(joint) => self.row.q[*joint] = value * self.layout.scale[*joint],
                Holds::Wrench(k) => self.row.wrench[*k] = value,
                Holds::Contact => {}
            }
        }
        if count != self.layout.columns {
            let joints = crate::io::suggest::list(self.robot.moving().map(|joint| joint.name.as_str()));
            let expected = format!("{} columns, as in the first line (joints {joints})", self.layout.columns);
            return Err(IoError::unexpected(Place::file(self.file).line(number), expected, format!("{count}")));
        }
        Ok(())
    }

    fn place(&self, line: u64, column: &str) -> Place {
        Place::file(self.file).line(line).field(format!("column {column}"))
    }

    fn column_of(&self, joint: usize) -> &str {
        let column = self.layout.used.iter().find(|(_, holds, _)| *holds == Holds::Joint(joint));
        column.map_or("", |(_, _, name)| name)
    }

    fn unit(&self, holds: Holds) -> &'static str {
        let prismatic = |joint| self.robot.moving().nth(joint).is_some_and(|joint| joint.kind == JointKind::Prismatic);
        match holds {
            Holds::Joint(joint) if prismatic(joint) => "a number in metres",
            Holds::Joint(_) if self.options.unit == AngleUnit::Degree => "a number in degrees",
            Holds::Joint(_) => "a number in radians",
            Holds::Wrench(0..3) => "a number in N",
            Holds::Wrench(_) => "a number in Nm",
            Holds::Contact => "0 or 1",
        }
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

//! What becomes of a row, whatever format it was read from.

use super::units::UnitCheck;
use super::{MAX_CONTACTS, Options};
use crate::contact::{ContactLog, Detector, Source, Wrench};
use crate::io::error::{IoError, Place};
use crate::robot::Robot;

/// What a row says.
pub(in crate::io) struct Row {
    /// Joint positions (rad or m).
    pub(in crate::io) q: Vec<f64>,
    pub(in crate::io) wrench: Wrench,
    /// Whether it is flagged as a contact.
    pub(in crate::io) flag: bool,
}

impl Row {
    /// A row of an arm with `dof` moving joints.
    pub(in crate::io) fn new(dof: usize) -> Row {
        Row { q: vec![0.0; dof], wrench: [0.0; 6], flag: true }
    }
}

/// Takes a file's rows one after the other and keeps those that are contacts.
pub(in crate::io) struct ContactRows<'a> {
    file: &'a str,
    /// The place of a row in the file, by its number.
    place: fn(&str, u64) -> Place,
    /// The file's name for each joint.
    names: Vec<String>,
    units: UnitCheck,
    detector: Option<Detector>,
    fixture: usize,
    index: u32,
    rows: u64,
    log: &'a mut ContactLog,
}

impl<'a> ContactRows<'a> {
    pub(in crate::io) fn new(
        file: &'a str,
        place: fn(&str, u64) -> Place,
        names: Vec<String>,
        (robot, options): (&Robot, &Options),
        log: &'a mut ContactLog,
    ) -> Self {
        ContactRows {
            file,
            place,
            names,
            units: UnitCheck::new(robot, options.unit),
            detector: options.detection.map(|d| Detector::new(d.threshold, d.release, d.debounce)),
            fixture: options.fixture,
            index: log.add_file(file),
            rows: 0,
            log,
        }
    }

    /// Takes row `number`.
    pub(in crate::io) fn take(&mut self, number: u64, row: &Row) -> Result<(), IoError> {
        self.rows += 1;
        if let Some(joint) = self.units.row(number, &row.q) {
            let place = (self.place)(self.file, number).field(format!("column {}", self.names[joint]));
            return Err(IoError::unexpected(place, "a joint position", format!("{}", row.q[joint])));
        }
        let touching = match &mut self.detector {
            Some(detector) => detector.update(&row.wrench),
            None => row.flag,
        };
        if touching {
            if self.log.len() >= MAX_CONTACTS {
                let place = (self.place)(self.file, number);
                return Err(IoError::unexpected(place, format!("at most {MAX_CONTACTS} contacts"), "more"));
            }
            self.log.push(&row.q, self.fixture, Source { line: number, file: self.index });
        }
        Ok(())
    }

    /// Rows taken so far.
    pub(in crate::io) fn count(&self) -> u64 {
        self.rows
    }

    /// The verdict over all rows.
    pub(in crate::io) fn finish(self) -> Result<(), IoError> {
        self.units.finish(self.file, self.place)?;
        self.log.count_rows(self.rows);
        Ok(())
    }
}

//! The rows of a log, whatever its format.

use super::layout::{Holds, Layout};
use super::options::Options;
use crate::contact::{AngleUnit, ContactIngest, LogFull, MAX_CONTACTS, Row, UnitCheck, UnitGuess};
use crate::io::base::error::{IoError, Place, shown_number};
use crate::robot::Robot;

/// Where the rows of a file go.
pub(crate) trait RowSink {
    /// Declares what rows hold beside joint positions.
    fn set_extras(&mut self, extras: &[Holds]);
    /// Declares that there are forces that are not read.
    #[cfg(feature = "mcap")]
    fn declare_forces(&mut self) {}
    /// Takes row `number`.
    fn push(&mut self, number: u64, row: &Row) -> Result<(), LogFull>;
    /// Multiplies the joint positions of all rows of the file, each joint's by its `scale`.
    fn rescale(&mut self, scale: &[f64]);
    /// Appends a note about the file.
    fn note(&mut self, file: &str, note: &str);
    /// Ends the file after so many `rows`.
    fn finish(&mut self, rows: u64);
}

impl RowSink for ContactIngest<'_> {
    fn set_extras(&mut self, extras: &[Holds]) {
        if extras.contains(&Holds::Wrench(0)) && !extras.contains(&Holds::Contact) {
            self.declare_unflagged_forces();
        }
    }

    #[cfg(feature = "mcap")]
    fn declare_forces(&mut self) {
        self.declare_unflagged_forces();
    }

    fn push(&mut self, number: u64, row: &Row) -> Result<(), LogFull> {
        self.set_temperature(row.temperature);
        self.set_joint_torques(&row.torques);
        self.set_fingerprint(row.fingerprint);
        self.set_target(row.target());
        ContactIngest::push(self, number, &row.q, row.wrench, row.flag)
    }

    fn rescale(&mut self, scale: &[f64]) {
        ContactIngest::rescale(self, scale);
    }

    fn note(&mut self, _: &str, note: &str) {
        ContactIngest::note(self, note);
    }

    fn finish(&mut self, rows: u64) {
        ContactIngest::finish(self, rows);
    }
}

/// Passes a file's rows on to a sink, and checks or guesses the unit of their joint positions.
pub(crate) struct LogRows<'a> {
    file: &'a str,
    /// The place of a row in the file, by its number.
    place: fn(&str, u64) -> Place,
    /// The file's name for each joint.
    names: Vec<String>,
    units: UnitCheck,
    guess: Option<UnitGuess>,
    rows: u64,
    sink: &'a mut dyn RowSink,
}

impl<'a> LogRows<'a> {
    /// Rows in which joints go by `names`, and which hold `extras` beside joint positions.
    pub(crate) fn new(
        (file, place): (&'a str, fn(&str, u64) -> Place),
        names: Vec<String>,
        extras: &[Holds],
        (robot, options): (&Robot, &Options),
        sink: &'a mut dyn RowSink,
    ) -> Self {
        sink.set_extras(extras);
        LogRows { file, place, names, units: UnitCheck::new(robot, options.unit), guess: None, rows: 0, sink }
    }

    /// Rows of a table.
    pub(crate) fn of(
        layout: &Layout,
        at: (&'a str, fn(&str, u64) -> Place),
        (robot, options): (&Robot, &Options),
        sink: &'a mut dyn RowSink,
    ) -> Self {
        let joint = |holds: &Holds| matches!(holds, Holds::Joint(_));
        let extras: Vec<Holds> = layout.used.iter().map(|(_, holds, _)| *holds).filter(|holds| !joint(holds)).collect();
        let mut rows = LogRows::new(at, layout.joint_names(robot.dof()), &extras, (robot, options), sink);
        if layout.from_recorder && options.unit == AngleUnit::Undeclared {
            rows.guess = Some(UnitGuess::new(robot));
        }
        rows
    }

    /// Appends a note about the file.
    #[cfg(feature = "mcap")]
    pub(crate) fn note(&mut self, note: &str) {
        self.sink.note(self.file, note);
    }

    /// Declares that there are forces that are not read.
    #[cfg(feature = "mcap")]
    pub(crate) fn declare_forces(&mut self) {
        self.sink.declare_forces();
    }

    /// Takes row `number`.
    pub(crate) fn take(&mut self, number: u64, row: &Row) -> Result<(), IoError> {
        self.rows += 1;
        let place = || (self.place)(self.file, number);
        if let Some(joint) = self.units.row(number, &row.q) {
            let place = place().field(format!("column {}", self.names[joint]));
            return Err(IoError::unexpected(place, "a joint position", shown_number(row.q[joint])));
        }
        if row.place.is_some() && row.target().is_none() {
            let place = place().field("columns nx, ny, nz");
            return Err(IoError::unexpected(place, "a normal that has a direction", "zeros"));
        }
        if let Some(guess) = &mut self.guess {
            guess.row(number, &row.q);
        }
        let expected = || format!("at most {MAX_CONTACTS} contacts, fewer of an arm with more than 8 joints");
        let full = |LogFull| IoError::unexpected(place(), expected(), "more");
        self.sink.push(number, row).map_err(full)
    }

    /// Rows taken so far.
    pub(crate) fn count(&self) -> u64 {
        self.rows
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If joint positions do not fit the joint limits in their unit.
    pub(crate) fn finish(self) -> Result<(), IoError> {
        let is_degrees = self.guess.is_some() && self.units.is_doubtful() && !self.units.is_within_two_turns();
        let mismatch = match &self.guess {
            Some(guess) if is_degrees => guess.mismatch(),
            _ => self.units.mismatch(),
        };
        if let Some(mismatch) = mismatch {
            let place = (self.place)(self.file, mismatch.row).field(format!("joint `{}`", mismatch.joint));
            return Err(IoError::unexpected(place, mismatch.expected, mismatch.found));
        }
        match self.guess {
            Some(guess) if is_degrees => {
                self.sink.rescale(guess.scale());
                self.sink.note(self.file, "the unit of angles is not declared: taken as DEGREES, since as radians they would be beyond the joint limits; \
                           declare unit = \"deg\"");
            }
            Some(_) => self.sink.note(self.file, "the unit of angles is not declared: taken as RADIANS, which fit the joint limits; declare unit = \"rad\""),
            None => {}
        }
        self.sink.finish(self.rows);
        Ok(())
    }
}

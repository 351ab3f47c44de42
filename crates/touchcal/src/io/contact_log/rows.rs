//! What becomes of a row, whatever format it was read from.

use super::units::UnitCheck;
use super::{AngleUnit, Load, LogTable, MAX_CONTACTS, Options};
use crate::contact::{ContactLog, Detector, Source};
use crate::io::contact_csv::header::{Holds, Layout};
use crate::io::error::{IoError, Place};
use crate::robot::{JointKind, Robot};
use crate::se3::Wrench;

/// What an arm at rest moves by (rad or m): 0.01°, or as far as that is a metre from the axis.
const REST: f64 = 1.7e-4;

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

/// Where rows go.
pub(in crate::io) enum Keep<'a> {
    /// Those that are contacts.
    Contacts(&'a mut ContactLog),
    /// All of them, whole.
    All(&'a mut LogTable),
}

impl Keep<'_> {
    fn len(&self) -> usize {
        match self {
            Keep::Contacts(log) => log.len(),
            Keep::All(table) => table.rows().len(),
        }
    }

    /// Multiplies the joint positions of all that is kept from number `first` on, each joint's by
    /// its `scale`.
    fn rescale(&mut self, first: usize, scale: &[f64]) {
        match self {
            Keep::Contacts(log) => log.rescale(first, scale),
            Keep::All(table) => table.rescale(first, scale),
        }
    }

    /// Thins what is kept from number `first` on to contacts that are `apart`; says if most repeat
    /// one another otherwise.
    fn thin(&mut self, first: usize, apart: Option<f64>) -> Option<String> {
        let Keep::Contacts(log) = self else { return None };
        if let Some(apart) = apart {
            log.keep(first, &log.apart(first, apart));
            return None;
        }
        let (all, apart) = (log.len() - first, log.apart(first, REST).len());
        (all > 2 * apart).then(|| {
            format!(
                "in {} of {all} contacts no joint has moved by 0.01 deg since the one before, and each counts as a measurement of its own; \
                 where the arm was at rest, declare how far apart contacts are (apart_deg in problem.toml, apart in Python)",
                all - apart
            )
        })
    }

    fn note(&mut self, note: String) {
        match self {
            Keep::Contacts(log) => log.note(note),
            Keep::All(table) => table.note(note),
        }
    }
}

/// Radians or degrees?
struct Guess {
    /// What makes rad or m of a row that is in degrees.
    scale: Vec<f64>,
    /// A row, if it is.
    q: Vec<f64>,
    units: UnitCheck,
}

/// Takes a file's rows one after the other and keeps contacts, or all.
pub(in crate::io) struct ContactRows<'a> {
    robot: &'a Robot,
    file: &'a str,
    /// The place of a row in the file, by its number.
    place: fn(&str, u64) -> Place,
    /// The file's name for each joint.
    names: Vec<String>,
    units: UnitCheck,
    guess: Option<Guess>,
    detector: Option<Detector>,
    load: Option<Load>,
    fixture: usize,
    index: u32,
    rows: u64,
    /// How many were kept of the files before.
    first: usize,
    /// See [`Options::apart`].
    apart: Option<f64>,
    /// The rows have forces, and nothing says which of them are contacts.
    unheeded_forces: bool,
    keep: Keep<'a>,
}

impl<'a> ContactRows<'a> {
    /// Rows in which joints go by `names`, and which hold `extras` beside joint positions.
    pub(in crate::io) fn new(
        (file, place): (&'a str, fn(&str, u64) -> Place),
        names: Vec<String>,
        extras: &[Holds],
        (robot, options): (&'a Robot, &Options),
        mut keep: Keep<'a>,
    ) -> Self {
        let index = match &mut keep {
            Keep::Contacts(log) => log.add_file(file),
            Keep::All(table) => {
                table.set_extras(extras);
                0
            }
        };
        ContactRows {
            robot,
            file,
            place,
            names,
            units: UnitCheck::new(robot, options.unit),
            guess: None,
            load: options.load,
            detector: options.detection.map(|d| Detector::new(d.threshold, d.release, d.debounce)),
            fixture: options.fixture,
            index,
            rows: 0,
            first: keep.len(),
            apart: options.apart,
            unheeded_forces: options.detection.is_none()
                && extras.contains(&Holds::Wrench(0))
                && !extras.contains(&Holds::Contact),
            keep,
        }
    }

    /// Rows of a table.
    pub(in crate::io) fn of(
        layout: &Layout,
        at: (&'a str, fn(&str, u64) -> Place),
        (robot, options): (&'a Robot, &Options),
        keep: Keep<'a>,
    ) -> Self {
        let joint = |holds: &Holds| matches!(holds, Holds::Joint(_));
        let extras: Vec<Holds> = layout.used.iter().map(|(_, holds, _)| *holds).filter(|holds| !joint(holds)).collect();
        let mut rows = ContactRows::new(at, layout.joint_names(robot.dof()), &extras, (robot, options), keep);
        // Radians or degrees is found out, if it is not declared.
        if layout.from_recorder && options.unit == AngleUnit::Undeclared {
            let scale = |kind| if kind == JointKind::Prismatic { 1.0 } else { std::f64::consts::PI / 180.0 };
            let scale: Vec<f64> = robot.moving().map(|joint| scale(joint.kind)).collect();
            let units = UnitCheck::new(robot, AngleUnit::Degree);
            rows.guess = Some(Guess { q: scale.clone(), scale, units });
        }
        rows
    }

    /// Remembers what was taken for granted.
    pub(in crate::io) fn note(&mut self, note: &str) {
        self.keep.note(format!("{}: {note}", self.file));
    }

    /// Remembers that there are forces, which nothing asks for.
    #[cfg(feature = "mcap")]
    pub(in crate::io) fn has_forces(&mut self) {
        self.unheeded_forces = true;
    }

    /// Takes row `number`.
    pub(in crate::io) fn take(&mut self, number: u64, row: &Row) -> Result<(), IoError> {
        self.rows += 1;
        if let Some(joint) = self.units.row(number, &row.q) {
            let place = (self.place)(self.file, number).field(format!("column {}", self.names[joint]));
            return Err(IoError::unexpected(place, "a joint position", format!("{}", row.q[joint])));
        }
        if let Some(Guess { scale, q, units, .. }) = &mut self.guess {
            q.iter_mut().zip(&row.q).zip(scale).for_each(|((q, raw), scale)| *q = raw * *scale);
            units.row(number, q);
        }
        let touching = match &mut self.detector {
            Some(detector) => detector.update(&row.wrench),
            None => row.flag,
        };
        if !touching && matches!(self.keep, Keep::Contacts(_)) {
            return Ok(());
        }
        if self.keep.len() >= MAX_CONTACTS {
            let place = (self.place)(self.file, number);
            return Err(IoError::unexpected(place, format!("at most {MAX_CONTACTS} contacts"), "more"));
        }
        match &mut self.keep {
            Keep::Contacts(log) => {
                log.push(&row.q, self.fixture, Source { line: number, file: self.index });
                if self.load.is_some() {
                    log.set_load(row.wrench);
                }
            }
            Keep::All(table) => table.push(row),
        }
        Ok(())
    }

    /// Rows taken so far.
    pub(in crate::io) fn count(&self) -> u64 {
        self.rows
    }

    /// The verdict over all rows.
    pub(in crate::io) fn finish(mut self) -> Result<(), IoError> {
        match self.guess.take() {
            Some(guess) if self.units.doubtful() => {
                guess.units.finish(self.file, self.place)?;
                self.keep.rescale(self.first, &guess.scale);
                self.note("the unit of angles is not declared: taken as DEGREES, since as radians they would be beyond the joint limits; \
                           declare unit = \"deg\"");
            }
            Some(_) => self.note("the unit of angles is not declared: taken as RADIANS, which fit the joint limits; declare unit = \"rad\""),
            None => self.units.finish(self.file, self.place)?,
        }
        if let Some(note) = self.keep.thin(self.first, self.apart) {
            self.note(&note);
        }
        if let Keep::Contacts(log) = &mut self.keep {
            log.count_rows(self.rows);
            if let Some(load) = self.load {
                load.apply(self.robot, log, self.first);
            }
            if self.unheeded_forces {
                self.note("there are forces, but no threshold: every row counts as a contact; declare the force of one (force_threshold_n in problem.toml, force_threshold in Python) if some are not");
            }
        }
        Ok(())
    }
}

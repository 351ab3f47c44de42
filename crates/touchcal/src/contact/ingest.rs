//! From the rows of a log to contacts: detection, loads, and an arm at rest.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use nalgebra::Vector3;

use super::detection::{Detection, Detector};
use super::load::{Load, TorqueOf};
use super::log::{ContactLog, RowsLeftOut, Source};
use super::repetition::repeated_rows_note;
use super::target::target_pose;
use super::wrap::{unwrap, wrap_note};
use crate::robot::Robot;
use crate::se3::{Pose, Wrench};

/// Largest number of contacts that [`ContactIngest`] puts into one log. A contact of a 7-joint arm
/// takes about 100 bytes of memory, 56 for its load, and 80 for its joint torques.
pub const MAX_CONTACTS: usize = 20_000_000;
/// Largest number of joint positions in one log: with more than eight joints there may be fewer
/// contacts.
const MAX_POSITIONS: usize = 8 * MAX_CONTACTS;
/// Motion of an arm at rest (rad or m): 0.01°, or as far as that is a metre from the axis.
const REST: f64 = 1.7e-4;

/// One row of a log: joint positions at one moment.
pub(crate) struct Row {
    /// Joint positions (rad or m).
    pub(crate) q: Vec<f64>,
    /// Wrench (N, N m); zero where the log has none.
    pub(crate) wrench: Wrench,
    /// Torque about each moving joint (N m), or force of a prismatic one (N); empty where the log
    /// has none.
    pub(crate) torques: Vec<f64>,
    /// Whether the row is flagged as a contact.
    pub(crate) flag: bool,
    /// Temperature of the arm (°C); `None` where the log has none.
    pub(crate) temperature: Option<f64>,
    /// Place of the target in the frame of the fixture (m); `None` where the log has none.
    pub(crate) place: Option<Vector3<f64>>,
    /// Normal of the surface there; `None` where the log has none.
    pub(crate) normal: Option<Vector3<f64>>,
    /// Hash of all that the file holds of the row; `None` where not all of it is read.
    pub(crate) fingerprint: Option<u64>,
}

impl Row {
    /// A row of an arm with `dof` moving joints.
    pub(crate) fn new(dof: usize) -> Row {
        Row {
            q: vec![0.0; dof],
            wrench: [0.0; 6],
            torques: Vec::new(),
            flag: true,
            temperature: None,
            place: None,
            normal: None,
            fingerprint: None,
        }
    }
}

impl Row {
    /// Sets the torque about the moving joint of this index.
    pub(crate) fn set_torque(&mut self, joint: usize, torque: f64) {
        self.torques.resize(self.q.len(), 0.0);
        if let Some(of_joint) = self.torques.get_mut(joint) {
            *of_joint = torque;
        }
    }

    /// The target, with its normal if it has one.
    pub(crate) fn target(&self) -> Option<Pose> {
        target_pose(self.place?, self.normal)
    }
}

/// Which rows of a file are contacts, and what becomes of their wrenches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IngestOptions {
    /// Index of the touched fixture in [`Problem::fixtures`](crate::estimate::Problem::fixtures),
    /// from 0; not checked.
    pub fixture: usize,
    /// Contact detection by force; `None`: the rows that are flagged as contacts are, or all where
    /// there are no flags.
    pub detection: Option<Detection>,
    /// How far (rad, or m for a prismatic joint; not negative) some joint must have moved since the
    /// last contact of the file that was kept for a row to be another contact; `None`: every row
    /// is.
    pub apart: Option<f64>,
    /// Body and frame of the wrench as a load on the arm; `None`: wrenches are not used as loads,
    /// and contacts have none.
    pub load: Option<Load>,
    /// Whose torques those of the rows are; `None`: contacts have none.
    pub torques: Option<TorqueOf>,
}

/// The contacts that were read so far, of all files, each once.
#[derive(Clone, Debug, Default)]
pub struct KnownRows(HashSet<u64>);

/// Error of [`ContactIngest::push`]: the log holds [`MAX_CONTACTS`] contacts already, or 8 times as
/// many joint positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LogFull;

/// Appends the contacts among the rows of one file to a [`ContactLog`]. Call
/// [`ContactIngest::push`] for each row in order and [`ContactIngest::finish`] once at the end;
/// without it contacts are not thinned, wrenches not yet loads, and rows not counted.
pub struct ContactIngest<'a> {
    robot: &'a Robot,
    log: &'a mut ContactLog,
    options: IngestOptions,
    detector: Option<Detector>,
    file: u32,
    /// Number of contacts of the files before.
    first: usize,
    /// Temperature of the next rows (°C).
    temperature: Option<f64>,
    /// Measured torques of the next rows' joints.
    torques: Vec<f64>,
    /// Target of the next rows.
    target: Option<Pose>,
    /// Measured wrench of the last row, in contact or not.
    wrench_before: Option<Wrench>,
    /// Hash of all that the file holds of the next row.
    fingerprint: Option<u64>,
    known: &'a mut KnownRows,
    left_out: RowsLeftOut,
    /// The rows have forces, and nothing decides which of them are contacts.
    has_unused_forces: bool,
}

impl<'a> ContactIngest<'a> {
    /// Starts a file named `file`, with rows of `robot`; its contacts are appended to `log`, which
    /// must be of as many moving joints and gets the file's name at once. Contacts that are `known`
    /// are left out, and those of the file become known: a row that is read twice is one
    /// measurement.
    pub fn new(
        robot: &'a Robot,
        file: &str,
        options: IngestOptions,
        (log, known): (&'a mut ContactLog, &'a mut KnownRows),
    ) -> Self {
        let detector = options.detection.map(|d| Detector::new(d.threshold, d.release, d.debounce));
        let (file, first) = (log.add_file(file), log.len());
        ContactIngest {
            robot,
            log,
            options,
            detector,
            file,
            first,
            temperature: None,
            torques: Vec::new(),
            target: None,
            wrench_before: None,
            fingerprint: None,
            known,
            left_out: RowsLeftOut::default(),
            has_unused_forces: false,
        }
    }

    /// Declares that the rows have forces but no contact flags: without detection by force, all
    /// rows count as contacts and [`ContactIngest::finish`] appends a note on that.
    pub fn declare_unflagged_forces(&mut self) {
        self.has_unused_forces = self.options.detection.is_none();
    }

    /// Sets the temperature of the arm (°C) in the rows that follow; `None`, as at the start: it is
    /// not known.
    pub fn set_temperature(&mut self, celsius: Option<f64>) {
        self.temperature = celsius;
    }

    /// Sets the measured joint torques in the rows that follow (N m, or N of a prismatic joint; one
    /// for each moving joint, base first), with the sign that [`IngestOptions::torques`] says;
    /// empty, as at the start: they are not known.
    pub fn set_joint_torques(&mut self, torques: &[f64]) {
        self.torques.clear();
        self.torques.extend_from_slice(torques);
    }

    /// Sets the target of the rows that follow, its pose `fixture_from_target` (m); `None`, as at
    /// the start: they touch the fixture itself.
    pub fn set_target(&mut self, target: Option<Pose>) {
        self.target = target;
    }

    /// Sets the hash of all that the file holds of the next row, by which rows that are read twice
    /// are found; `None`, as at the start: they are found by their number and what
    /// [`ContactIngest::push`] is given.
    pub fn set_fingerprint(&mut self, fingerprint: Option<u64>) {
        self.fingerprint = fingerprint;
    }

    /// Takes row `number` of the file (1 for the first): measured joint positions `q` (rad, or m
    /// for a prismatic joint; one for each moving joint, base first; not checked), measured wrench
    /// `[f; τ]` (N, N m; body and frame as in [`IngestOptions::load`]; zeros if there is none), and
    /// whether the row is flagged as a contact (`true` without flags). The flag has no effect with
    /// detection by force.
    ///
    /// # Errors
    /// [`LogFull`] if the row is a contact and the log is full; the row is then left out.
    pub fn push(&mut self, number: u64, q: &[f64], wrench: Wrench, flag: bool) -> Result<(), LogFull> {
        let wrench_before = self.wrench_before.replace(wrench);
        let is_touching = match &mut self.detector {
            Some(detector) => detector.update(&wrench),
            None => flag,
        };
        if !is_touching {
            self.left_out.out_of_contact += 1;
            return Ok(());
        }
        if self.log.len() >= MAX_CONTACTS.min(MAX_POSITIONS / self.log.dof().max(1)) {
            return Err(LogFull);
        }
        let fingerprint = self.fingerprint.unwrap_or_else(|| self.fingerprint_of(number, q, &wrench));
        if !self.known.0.insert(fingerprint) {
            self.left_out.repeated += 1;
            return Ok(());
        }
        self.log.push(q, self.options.fixture, Source { line: number, file: self.file });
        if let Some(load) = self.options.load {
            self.log.set_load(load.without_lag(wrench, wrench_before));
        }
        if let Some(of) = self.options.torques {
            self.log.set_joint_torques(&of.of_load(&self.torques));
        }
        if let Some(celsius) = self.temperature {
            self.log.set_temperature(celsius);
        }
        if let Some(target) = self.target {
            self.log.set_target(target);
        }
        Ok(())
    }

    fn fingerprint_of(&self, number: u64, q: &[f64], wrench: &Wrench) -> u64 {
        let mut hasher = DefaultHasher::new();
        number.hash(&mut hasher);
        let target = self.target.iter().flat_map(|t| t.translation.vector.iter().chain(t.rotation.coords.iter()));
        let values = q.iter().chain(wrench).chain(&self.torques).chain(&self.temperature).chain(target);
        values.for_each(|value| value.to_bits().hash(&mut hasher));
        hasher.finish()
    }

    /// Multiplies the joint positions of the file's contacts so far: `scale` has one factor (1) for
    /// each moving joint, base first, such as π/180 to make radians of degrees.
    pub fn rescale(&mut self, scale: &[f64]) {
        let each = self.log.positions_mut(self.first);
        each.for_each(|q| q.iter_mut().zip(scale).for_each(|(q, scale)| *q *= scale));
    }

    /// Appends a note about the file, in words for the user, to those of the log, behind the name
    /// of the file.
    pub fn note(&mut self, note: &str) {
        let file = &self.log.files()[self.file as usize];
        self.log.note(format!("{file}: {note}"));
    }

    /// Ends the file after `rows` rows, in contact or not: continues angles that the recorder
    /// wraps, thins contacts ([`IngestOptions::apart`]), converts wrenches to loads
    /// ([`IngestOptions::load`]), and appends notes, each once: on rows that were read twice,
    /// wrapped angles, that contacts repeat one another while the arm is at rest, and that forces
    /// were not used.
    pub fn finish(&mut self, rows: u64) {
        if self.left_out.repeated > 0 {
            let repeated = self.left_out.repeated as usize;
            self.note(&repeated_rows_note(repeated, repeated + self.log.len() - self.first));
        }
        let wraps = unwrap(self.log, self.first, self.robot);
        if let Some(note) = wrap_note(&wraps, self.robot, self.log) {
            self.note(&note);
        }
        if let Some(note) = self.thin() {
            self.note(&note);
        }
        self.log.count_rows(rows);
        self.log.count_left_out(self.left_out);
        if let Some(load) = self.options.load {
            load.apply(self.robot, self.log, self.first);
        }
        if self.has_unused_forces {
            self.note("there are forces, but no threshold: every row counts as a contact; declare the force of one (force_threshold_n in problem.toml, force_threshold in Python) if some are not");
        }
    }

    /// Thins the file's contacts to those that are [`IngestOptions::apart`]; without that option, a
    /// note if most of them repeat one another.
    fn thin(&mut self) -> Option<String> {
        if let Some(apart) = self.options.apart {
            let kept = self.log.apart(self.first, apart);
            self.left_out.at_rest += (self.log.len() - self.first - kept.len()) as u64;
            self.log.keep(self.first, &kept);
            return None;
        }
        let (all, apart) = (self.log.len() - self.first, self.log.apart(self.first, REST).len());
        (all > 2 * apart).then(|| {
            format!(
                "in {} of {all} contacts no joint has moved by 0.01 deg since the one before, and each counts as a measurement of its own; \
                 where the arm was at rest, declare how far apart contacts are (apart_deg in problem.toml, apart in Python)",
                all - apart
            )
        })
    }
}

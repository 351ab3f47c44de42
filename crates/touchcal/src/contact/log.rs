//! The log of contacts.

use serde::{Deserialize, Serialize};

use super::merged_notes::merged;
use crate::robot::JointLoad;
use crate::se3::{Pose, Wrench};

/// Where a contact was read: the file and the row in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Source {
    /// Index into [`ContactLog::files`], as [`ContactLog::add_file`] returned it; not checked.
    pub file: u32,
    /// Line of the file, row of a table or number of a joint state in a bag; 1 for the first.
    pub line: u64,
}

/// Contacts: measured joint positions while the tool touched a fixture, each with fixture, source,
/// load, joint torques and temperature. Contacts are numbered from 0 in the order in which they
/// were appended. The default is an empty log of an arm without joints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContactLog {
    dof: usize,
    q: Vec<f64>,
    /// Up to the last contact whose load is known; `None` where it is not.
    loads: Vec<Option<Wrench>>,
    /// Up to the last contact whose joint torques (N m, or N of a prismatic joint) are measured,
    /// likewise.
    torques: Vec<Option<Vec<f64>>>,
    /// Up to the last contact whose temperature (°C) is known, likewise.
    temperatures: Vec<Option<f64>>,
    /// Up to the last contact that has a target, likewise.
    targets: Vec<Option<Pose>>,
    fixture: Vec<u32>,
    source: Vec<Source>,
    files: Vec<String>,
    /// Up to the last file whose wrenches lag: the lag (rows) that was taken out of its loads.
    load_lags: Vec<f64>,
    notes: Vec<String>,
    rows_read: u64,
    rows_left_out: RowsLeftOut,
}

/// Numbers of rows that were read and are no contacts of a log, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RowsLeftOut {
    /// Below the force threshold, or not flagged as contacts.
    pub out_of_contact: u64,
    /// In contact, but no farther from the contact before than
    /// [`IngestOptions::apart`](crate::contact::IngestOptions::apart).
    pub at_rest: u64,
    /// Read before, in the same file or in another.
    pub repeated: u64,
}

impl std::ops::AddAssign for RowsLeftOut {
    fn add_assign(&mut self, other: RowsLeftOut) {
        self.out_of_contact += other.out_of_contact;
        self.at_rest += other.at_rest;
        self.repeated += other.repeated;
    }
}

impl ContactLog {
    /// An empty log of an arm with `dof` moving joints ([`Robot::dof`](crate::robot::Robot::dof)).
    pub fn new(dof: usize) -> Self {
        ContactLog { dof, ..ContactLog::default() }
    }

    /// Registers a file by name and returns its index, from 0, for [`Source::file`]. The same name
    /// may be registered again and gets another index.
    pub fn add_file(&mut self, name: impl Into<String>) -> u32 {
        self.files.push(name.into());
        (self.files.len() - 1) as u32
    }

    /// Declares that a lag (rows, ≥ 0) was taken out of the loads of this file's contacts, as
    /// [`Load::lag`](crate::contact::Load::lag) describes, which makes their noise larger. Without
    /// effect if there is no such file.
    pub fn set_load_lag(&mut self, file: u32, lag: f64) {
        let file = file as usize;
        if file < self.files.len() && (lag > 0.0 || file < self.load_lags.len()) {
            self.load_lags.resize(self.load_lags.len().max(file + 1), 0.0);
            self.load_lags[file] = lag;
        }
    }

    /// Variance of the noise of contact `i`'s load over that of the measured wrench (1): with the
    /// lag `λ` that was taken out `(1 + λ)² + λ²`.
    pub(crate) fn load_noise_factor(&self, i: usize) -> f64 {
        let lag = self.load_lags.get(self.source(i).file as usize).copied().unwrap_or(0.0);
        (1.0 + lag).powi(2) + lag.powi(2)
    }

    /// Adds `rows` to the number of rows that were read, in contact or not.
    pub fn count_rows(&mut self, rows: u64) {
        self.rows_read += rows;
    }

    /// Adds to the numbers of rows that were read and left out.
    pub fn count_left_out(&mut self, rows: RowsLeftOut) {
        self.rows_left_out += rows;
    }

    /// Appends a note for the user, in words, on an assumption that the reader made.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// Notes on assumptions that readers made, in the order in which they were added.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Merges notes that begin with the names of different `files` and are otherwise the same into
    /// one, with the first of these files and the number of others.
    pub fn merge_notes<'a>(&mut self, files: impl Iterator<Item = &'a str> + Clone) {
        self.notes = merged(std::mem::take(&mut self.notes), files);
    }

    /// Drops all notes but those that fulfil `keep`.
    pub fn retain_notes(&mut self, keep: impl Fn(&str) -> bool) {
        self.notes.retain(|note| keep(note));
    }

    /// The joint positions of the contacts from number `first` on, in order.
    pub(super) fn positions_mut(&mut self, first: usize) -> impl Iterator<Item = &mut [f64]> {
        self.q.chunks_exact_mut(self.dof.max(1)).skip(first)
    }

    /// Changes the loads of all contacts from number `first` on, as far as they are known:
    /// `change(q, load)` of measured joint positions and the load so far.
    pub(crate) fn change_loads(&mut self, first: usize, change: impl Fn(&[f64], Wrench) -> Wrench) {
        let each = self.loads.iter_mut().zip(self.q.chunks_exact(self.dof.max(1)));
        each.skip(first).for_each(|(load, q)| *load = load.map(|load| change(q, load)));
    }

    /// Numbers of the contacts, from number `first` on, at which some joint has moved by more than
    /// `apart` (rad or m) since the one before of these.
    pub(crate) fn apart(&self, first: usize, apart: f64) -> Vec<usize> {
        let mut kept: Vec<usize> = Vec::new();
        for i in first..self.len() {
            let moved = |&last: &usize| self.q(last).iter().zip(self.q(i)).any(|(a, b)| (a - b).abs() > apart);
            if kept.last().is_none_or(moved) {
                kept.push(i);
            }
        }
        kept
    }

    /// Drops the contacts from number `first` on, but for those numbered `kept`, which ascend.
    pub(crate) fn keep(&mut self, first: usize, kept: &[usize]) {
        for (to, &from) in (first..).zip(kept) {
            self.q.copy_within(from * self.dof..(from + 1) * self.dof, to * self.dof);
            self.fixture[to] = self.fixture[from];
            self.source[to] = self.source[from];
            if to < self.loads.len() {
                self.loads[to] = self.known_load(from);
            }
            if to < self.torques.len() {
                self.torques[to] = self.joint_torques(from).map(<[f64]>::to_vec);
            }
            if to < self.temperatures.len() {
                self.temperatures[to] = self.temperature(from);
            }
            if to < self.targets.len() {
                self.targets[to] = self.target(from).copied();
            }
        }
        let left = first + kept.len();
        self.q.truncate(left * self.dof);
        self.fixture.truncate(left);
        self.source.truncate(left);
        self.loads.truncate(left);
        self.torques.truncate(left);
        self.temperatures.truncate(left);
        self.targets.truncate(left);
    }

    /// Appends a contact: measured joint positions `q` (rad, or m for a prismatic joint; base
    /// first) while touching the fixture of index `fixture` (below 2³²; not checked against a
    /// problem). Positions beyond [`ContactLog::dof`] are ignored; if any is missing, the whole
    /// contact is ignored.
    pub fn push(&mut self, q: &[f64], fixture: usize, source: Source) {
        if let Some(q) = q.get(..self.dof) {
            self.q.extend_from_slice(q);
            self.fixture.push(fixture as u32);
            self.source.push(source);
        }
    }

    /// Sets the load of the last contact: the wrench `[f; τ]` (N, N m) that the fixture exerted on
    /// the tool, about the tip's origin, in the tip frame, in place of a former one. Without effect
    /// on an empty log.
    pub fn set_load(&mut self, load: Wrench) {
        if let Some(last) = self.len().checked_sub(1) {
            self.loads.resize(last, None);
            self.loads.push(Some(load));
        }
    }

    /// Sets the measured joint torques of the last contact: what gravity and contact exert about
    /// each moving joint (N m), or along a prismatic one (N), base first, in place of former ones.
    /// One for each joint: fewer, and those of an empty log, are without effect.
    pub fn set_joint_torques(&mut self, torques: &[f64]) {
        if let (Some(last), Some(torques)) = (self.len().checked_sub(1), torques.get(..self.dof)) {
            self.torques.resize(last, None);
            self.torques.push(Some(torques.to_vec()));
        }
    }

    /// Sets the temperature (°C) of the arm in the last contact, in place of a former one. Without
    /// effect on an empty log.
    pub fn set_temperature(&mut self, celsius: f64) {
        if let Some(last) = self.len().checked_sub(1) {
            self.temperatures.resize(last, None);
            self.temperatures.push(Some(celsius));
        }
    }

    /// Sets the target of the last contact: its pose `fixture_from_target` (m) in the frame of the
    /// fixture, in place of a former one. Without effect on an empty log.
    pub fn set_target(&mut self, fixture_from_target: Pose) {
        if let Some(last) = self.len().checked_sub(1) {
            self.targets.resize(last, None);
            self.targets.push(Some(fixture_from_target));
        }
    }

    /// Appends the contacts of `other`, all with fixture index `fixture`, with its files, notes,
    /// loads, joint torques, temperatures, targets and number of rows read; indices of files follow
    /// those of this log. `other` must be of as many moving joints: surplus positions of an arm
    /// with more are ignored, contacts of one with fewer left out.
    pub fn append(&mut self, other: &ContactLog, fixture: usize) {
        let first = self.files.len() as u32;
        self.files.extend_from_slice(&other.files);
        other.load_lags.iter().zip(first..).for_each(|(&lag, file)| self.set_load_lag(file, lag));
        self.notes.extend_from_slice(&other.notes);
        self.rows_read += other.rows_read;
        self.rows_left_out += other.rows_left_out;
        for i in 0..other.len() {
            let Source { file, line } = other.source(i);
            self.push(other.q(i), fixture, Source { file: first + file, line });
            self.copy_measurements(other, i);
        }
    }

    /// Number of moving joints of the arm.
    pub fn dof(&self) -> usize {
        self.dof
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.fixture.len()
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.fixture.is_empty()
    }

    /// Measured joint positions of contact `i` (rad, or m for a prismatic joint),
    /// [`ContactLog::dof`] of them, base first. Panics if `i` is not below [`ContactLog::len`].
    pub fn q(&self, i: usize) -> &[f64] {
        &self.q[i * self.dof..(i + 1) * self.dof]
    }

    /// Wrench `[f; τ]` (N, N m) that the fixture exerted on the tool in contact `i`, about the
    /// tip's origin, in the tip frame; zeros where it is not known, and if there is no contact `i`.
    pub fn load(&self, i: usize) -> Wrench {
        self.known_load(i).unwrap_or([0.0; 6])
    }

    /// The load of contact `i` as in [`ContactLog::load`]; `None` where it is not known, and if
    /// there is no contact `i`.
    pub fn known_load(&self, i: usize) -> Option<Wrench> {
        self.loads.get(i).copied().flatten()
    }

    /// Whether the load of any contact is known, be it zero.
    pub fn has_loads(&self) -> bool {
        self.loads.iter().any(Option::is_some)
    }

    /// Measured joint torques of contact `i`, as in [`ContactLog::set_joint_torques`]; `None` where
    /// they are not known, and if there is no contact `i`.
    pub fn joint_torques(&self, i: usize) -> Option<&[f64]> {
        self.torques.get(i).and_then(Option::as_deref)
    }

    /// Whether the joint torques of any contact are known.
    pub fn has_joint_torques(&self) -> bool {
        self.torques.iter().any(Option::is_some)
    }

    /// What deflects the joints in contact `i`: measured torques where they are known, else gravity
    /// and the wrench `on_tip`.
    pub fn load_on_joints<'a>(&'a self, i: usize, on_tip: &'a Wrench) -> JointLoad<'a> {
        self.joint_torques(i).map_or(JointLoad::OnTip(on_tip), JointLoad::Torques)
    }

    /// Temperature of the arm in contact `i` (°C); `None` where it is not known, and if there is no
    /// contact `i`.
    pub fn temperature(&self, i: usize) -> Option<f64> {
        self.temperatures.get(i).copied().flatten()
    }

    /// Target of contact `i`, its pose `fixture_from_target` (m) in the frame of the fixture;
    /// `None` where it has none, as where the fixture itself is touched, and if there is no contact
    /// `i`.
    pub fn target(&self, i: usize) -> Option<&Pose> {
        self.targets.get(i).and_then(Option::as_ref)
    }

    /// Index of the fixture touched in contact `i`. Panics if `i` is not below [`ContactLog::len`].
    pub fn fixture(&self, i: usize) -> usize {
        self.fixture[i] as usize
    }

    /// File and row from which contact `i` was read. Panics if `i` is not below
    /// [`ContactLog::len`].
    pub fn source(&self, i: usize) -> Source {
        self.source[i]
    }

    /// Names of the files read, in the order of [`Source::file`].
    pub fn files(&self) -> &[String] {
        &self.files
    }

    /// Number of rows read, in contact or not, as [`ContactLog::count_rows`] added them up.
    pub fn rows_read(&self) -> u64 {
        self.rows_read
    }

    /// Numbers of rows read that are no contacts, as [`ContactLog::count_left_out`] added them up.
    pub fn rows_left_out(&self) -> RowsLeftOut {
        self.rows_left_out
    }

    /// The contacts whose number `i` fulfils `keep(i)`, in order, with their loads, joint torques
    /// and temperatures, all files and notes and the number of rows read. `keep` is called once for
    /// each contact, in order.
    pub fn filtered(&self, mut keep: impl FnMut(usize) -> bool) -> ContactLog {
        let (files, notes, load_lags) = (self.files.clone(), self.notes.clone(), self.load_lags.clone());
        let (rows_read, rows_left_out) = (self.rows_read, self.rows_left_out);
        let mut log = ContactLog { files, notes, load_lags, rows_read, rows_left_out, ..ContactLog::new(self.dof) };
        for i in (0..self.len()).filter(|&i| keep(i)) {
            log.push(self.q(i), self.fixture(i), self.source(i));
            log.copy_measurements(self, i);
        }
        log
    }

    /// The contacts with other joint positions: `change(i, q)` changes those of contact `i` in
    /// place (rad, or m for a prismatic joint), in order; all else stays.
    pub(crate) fn with_positions(&self, mut change: impl FnMut(usize, &mut [f64])) -> ContactLog {
        let mut log = self.clone();
        log.q.chunks_exact_mut(self.dof.max(1)).enumerate().for_each(|(i, q)| change(i, q));
        log
    }

    /// The contacts with other fixtures: `fixture(f)` is the index of the fixture of those that
    /// touched fixture `f`; all else stays.
    pub(crate) fn with_fixtures(&self, fixture: impl Fn(usize) -> usize) -> ContactLog {
        let mut log = self.clone();
        log.fixture.iter_mut().for_each(|f| *f = fixture(*f as usize) as u32);
        log
    }

    fn copy_measurements(&mut self, other: &ContactLog, i: usize) {
        if let Some(load) = other.known_load(i) {
            self.set_load(load);
        }
        if let Some(torques) = other.joint_torques(i) {
            self.set_joint_torques(torques);
        }
        if let Some(celsius) = other.temperature(i) {
            self.set_temperature(celsius);
        }
        if let Some(target) = other.target(i) {
            self.set_target(*target);
        }
    }
}

#[cfg(test)]
mod tests;

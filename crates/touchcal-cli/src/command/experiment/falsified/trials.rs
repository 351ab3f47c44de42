//! The trials: read from their files where they are there, computed in parallel and saved where
//! not.

use std::ops::ControlFlow;
use std::path::PathBuf;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::experiment::Trial;
use touchcal::experiment::falsified::{
    Excitation, FalsifiedError, FalsifiedKind, FalsifiedOptions, FalsifiedRow, falsified_recorded_trial,
    falsified_trial,
};
use touchcal::io::trial_folder;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::Robot;

use super::super::saved;
use crate::args::FalsifiedArgs;
use crate::failure::Failure;
use crate::progress::{Counter, interrupted};

/// A trial's file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedRow {
    /// All that the row depends on.
    settings: String,
    row: FalsifiedRow,
}

/// The origin of a trial's contacts.
#[derive(Clone, Copy)]
enum Contacts<'a> {
    Simulated(Excitation),
    /// With the name of its row.
    Recorded(&'a str, &'a Trial),
}

/// A trial to be computed.
struct Job<'a> {
    kind: &'a FalsifiedKind,
    contacts: Contacts<'a>,
    seed: u64,
}

/// The rows of all trials: kind by kind, excitation by excitation or recorded trial by recorded
/// trial, in the order of seeds.
pub fn run(args: &FalsifiedArgs, kinds: &[FalsifiedKind]) -> Result<Vec<FalsifiedRow>, Failure> {
    let robot = urdf::read_builtin("iiwa14", Ends::default())?.robot;
    let recorded = recorded(args, &robot)?;
    let mut jobs = Vec::new();
    for kind in kinds {
        let contacts: Vec<Contacts<'_>> = match recorded.as_slice() {
            [] => kind.excitations.iter().map(|&excitation| Contacts::Simulated(excitation)).collect(),
            trials => trials.iter().map(|(name, trial)| Contacts::Recorded(name, trial)).collect(),
        };
        for contacts in contacts {
            let seeds = (0..args.trials).map(|trial| args.seed.wrapping_add(trial));
            jobs.extend(seeds.map(|seed| Job { kind, contacts, seed }));
        }
    }
    let counter = Counter::new("Trials", 0, jobs.len() as u64);
    let rows = jobs.par_iter().map(|job| {
        let row = job.row(args, &robot)?;
        counter.advance(1);
        Ok(row)
    });
    rows.collect()
}

/// The recorded trials, each with a name of its folder and its own.
fn recorded(args: &FalsifiedArgs, robot: &Robot) -> Result<Vec<(String, Trial)>, Failure> {
    let mut trials = Vec::new();
    for folder in &args.logs {
        let of = folder.file_name().map_or_else(String::new, |name| format!("{}.", name.to_string_lossy()));
        let each = trial_folder::read(folder, robot)?.into_iter();
        trials.extend(each.map(|trial| (format!("{of}{}", trial.name), trial)));
    }
    Ok(trials)
}

impl Job<'_> {
    fn row(&self, args: &FalsifiedArgs, robot: &Robot) -> Result<FalsifiedRow, Failure> {
        let (settings, path) = (self.settings(args), self.path(args));
        if let Some(saved) = saved::load::<SavedRow>(&path).filter(|saved| saved.settings == settings) {
            return Ok(saved.row);
        }
        let mut watch = || if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let options = FalsifiedOptions { seed: self.seed, free_effects: args.free_suspects };
        let found = match self.contacts {
            Contacts::Simulated(excitation) => {
                falsified_trial(self.kind, (excitation, robot, args.contacts), options, &mut watch)
            }
            Contacts::Recorded(name, trial) => falsified_recorded_trial(self.kind, (name, trial), options, &mut watch),
        };
        // What was broken off is neither an error of the trial nor a row.
        if interrupted() {
            return Err(Failure::ExperimentInterrupted);
        }
        let row = found.map_err(|error| match error {
            FalsifiedError::Simulation(error) => {
                let folder = path.with_extension("").display().to_string();
                Failure::Trial { folder, seed: self.seed, error }
            }
            error => Failure::Setup(error.to_string()),
        })?;
        let saved = SavedRow { settings, row };
        saved::save(&path, &saved)?;
        Ok(saved.row)
    }

    fn settings(&self, args: &FalsifiedArgs) -> String {
        let version = env!("CARGO_PKG_VERSION");
        let FalsifiedKind { falsification, declared, .. } = self.kind;
        let contacts = match self.contacts {
            Contacts::Simulated(_) => format!("{} contacts", args.contacts),
            Contacts::Recorded(_, trial) => trial.origin.clone(),
        };
        let freed = if args.free_suspects { ", freed suspects" } else { "" };
        format!("touchcal {version}, {contacts}, {falsification:?}, {declared:?}{freed}")
    }

    fn path(&self, args: &FalsifiedArgs) -> PathBuf {
        let contacts = match self.contacts {
            Contacts::Simulated(excitation) => excitation.name(),
            Contacts::Recorded(name, _) => name,
        };
        let name = format!("{}.{contacts}.{}.json", self.kind.name, self.seed);
        args.out.join(saved::ROWS).join(name)
    }
}

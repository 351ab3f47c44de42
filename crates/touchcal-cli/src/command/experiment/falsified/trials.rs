//! The trials: read from their files where they are there, computed in parallel and saved where
//! not.

use std::ops::ControlFlow;
use std::path::PathBuf;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::experiment::falsified::{Excitation, FalsifiedError, FalsifiedKind, FalsifiedRow, falsified_trial};
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

/// A trial to be computed.
struct Job<'a> {
    kind: &'a FalsifiedKind,
    excitation: Excitation,
    seed: u64,
}

/// The rows of all trials: kind by kind, excitation by excitation, in the order of seeds.
pub fn run(args: &FalsifiedArgs, kinds: &[FalsifiedKind]) -> Result<Vec<FalsifiedRow>, Failure> {
    let robot = urdf::read_builtin("iiwa14", Ends::default())?.robot;
    let mut jobs = Vec::new();
    for kind in kinds {
        for &excitation in kind.excitations {
            let seeds = (0..args.trials).map(|trial| args.seed.wrapping_add(trial));
            jobs.extend(seeds.map(|seed| Job { kind, excitation, seed }));
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

impl Job<'_> {
    fn row(&self, args: &FalsifiedArgs, robot: &Robot) -> Result<FalsifiedRow, Failure> {
        let (settings, path) = (self.settings(args), self.path(args));
        if let Some(saved) = saved::load::<SavedRow>(&path).filter(|saved| saved.settings == settings) {
            return Ok(saved.row);
        }
        let mut watch = || if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let found = falsified_trial(self.kind, (self.excitation, robot, args.contacts), self.seed, &mut watch);
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
        format!("touchcal {version}, {} contacts, {falsification:?}, {declared:?}", args.contacts)
    }

    fn path(&self, args: &FalsifiedArgs) -> PathBuf {
        let name = format!("{}.{}.{}.json", self.kind.name, self.excitation.name(), self.seed);
        args.out.join("rows").join(name)
    }
}

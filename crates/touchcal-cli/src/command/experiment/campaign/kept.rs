//! The parts of one scenario's trials: computed, kept in a folder, and taken from there.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use touchcal::experiment::{CampaignRow, CampaignSummary, campaign_trial};
use touchcal::io::campaign_folder::CampaignFolder;
use touchcal::io::campaign_parquet::{self, Part};
use touchcal::io::scenario_file::TextFile;

use crate::args::CampaignArgs;
use crate::command::Failure;
use crate::progress::{Counter, interrupted};

/// Trials of one scenario.
pub struct Campaign {
    parts: CampaignFolder,
}

/// What a campaign's parts come to.
pub struct Found {
    pub summary: CampaignSummary,
    /// Seconds of one core that its trials took.
    pub core_seconds: f64,
    /// Parts computed now.
    pub computed: u64,
    /// Parts that are not there.
    pub missing: u64,
}

impl Campaign {
    /// A campaign in `folder`, of the scenario that `files` are.
    pub fn new(files: &[TextFile], folder: PathBuf, args: &CampaignArgs) -> Result<Self, Failure> {
        Ok(Campaign { parts: CampaignFolder::new(files, folder, args.trials, args.seed)? })
    }

    /// Where it is kept.
    pub fn folder(&self) -> &Path {
        self.parts.folder()
    }

    /// Takes the parts that are there, and computes the others that are `mine`.
    pub fn run(&self, mine: impl Fn(u64) -> bool, counter: &Counter) -> Result<Found, Failure> {
        let mut found = Found { summary: CampaignSummary::default(), core_seconds: 0.0, computed: 0, missing: 0 };
        for number in 0..self.parts.count() {
            let part = match self.parts.kept(number) {
                Some(part) => {
                    counter.more(part.rows.len() as u64);
                    part
                }
                None if mine(number) => {
                    found.computed += 1;
                    self.compute(number, counter)?
                }
                None => {
                    found.missing += 1;
                    continue;
                }
            };
            part.rows.iter().for_each(|row| found.summary.add(row));
            found.core_seconds += part.core_seconds;
        }
        Ok(found)
    }

    fn compute(&self, number: u64, counter: &Counter) -> Result<Part, Failure> {
        let first_seed = self.parts.first_seed();
        let trial = |trial: u64| {
            if interrupted() {
                return Err(Failure::ExperimentInterrupted);
            }
            let row = campaign_trial(self.parts.scenario(), first_seed, trial).map_err(|error| Failure::Trial {
                folder: self.folder().display().to_string(),
                seed: first_seed.wrapping_add(trial),
                error,
            })?;
            counter.more(1);
            Ok(row)
        };
        let trials: Vec<u64> = self.parts.range(number).collect();
        let start = Instant::now();
        let rows: Vec<CampaignRow> = trials.into_par_iter().map(trial).collect::<Result<_, Failure>>()?;
        // Threads work on several trials at a time, so that one's own time says little.
        let core_seconds = start.elapsed().as_secs_f64() * rayon::current_num_threads() as f64;
        if interrupted() {
            return Err(Failure::ExperimentInterrupted);
        }
        let part = self.parts.part(rows, core_seconds);
        self.parts.keep(number, &campaign_parquet::to_bytes(&part)?)?;
        Ok(part)
    }
}

//! The parts of a campaign: read from its folder where they are there, computed where not.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use touchcal::experiment::{CampaignRow, CampaignSummary, campaign_trial};
use touchcal::io::campaign_folder::CampaignFolder;
use touchcal::io::campaign_parquet::{self, Part};
use touchcal::io::scenario_file::TextFile;

use crate::args::CampaignArgs;
use crate::failure::Failure;
use crate::progress::{Counter, interrupted};

/// Trials of one scenario.
pub struct Campaign {
    parts: CampaignFolder,
}

/// The trials of a campaign's parts, added up.
pub struct PartsSummary {
    /// Sums over the trials.
    pub summary: CampaignSummary,
    /// Time that the trials took on one core (s).
    pub core_seconds: f64,
    /// Number of parts computed by this run.
    pub computed: u64,
    /// Number of parts that are missing.
    pub missing: u64,
}

impl Campaign {
    /// A campaign in `folder`, of the scenario that `files` are.
    pub fn new(files: &[TextFile], folder: PathBuf, args: &CampaignArgs) -> Result<Self, Failure> {
        Ok(Campaign { parts: CampaignFolder::new(files, folder, args.trials, args.seed)? })
    }

    /// The campaign's folder.
    pub fn folder(&self) -> &Path {
        self.parts.folder()
    }

    /// Checks that all parts are in the folder, which another run with other settings may have
    /// written into.
    pub fn check(&self) -> Result<(), Failure> {
        Ok(self.parts.check()?)
    }

    /// Removes what ended runs left among the parts, all of which must be there.
    pub fn remove_left_over(&self) {
        self.parts.remove_left_over();
    }

    /// Reads the parts that are in the folder, computes those missing of which `is_own` is true,
    /// and adds them up.
    pub fn run(&self, is_own: impl Fn(u64) -> bool, counter: &Counter) -> Result<PartsSummary, Failure> {
        let mut total =
            PartsSummary { summary: CampaignSummary::default(), core_seconds: 0.0, computed: 0, missing: 0 };
        for number in 0..self.parts.count() {
            let part = match self.parts.kept(number) {
                Some(part) => {
                    counter.skip(part.rows.len() as u64);
                    part
                }
                None if is_own(number) => {
                    total.computed += 1;
                    self.compute(number, counter)?
                }
                None => {
                    total.missing += 1;
                    continue;
                }
            };
            part.rows.iter().for_each(|row| total.summary.add(row));
            total.core_seconds += part.core_seconds;
        }
        Ok(total)
    }

    fn check_folder(&self) -> Result<(), Failure> {
        let folder = self.folder();
        if folder.is_dir() { Ok(()) } else { Err(Failure::FolderGone(folder.display().to_string())) }
    }

    fn compute(&self, number: u64, counter: &Counter) -> Result<Part, Failure> {
        let first_seed = self.parts.first_seed();
        let trial = |trial: u64| {
            self.check_folder()?;
            if interrupted() {
                return Err(Failure::ExperimentInterrupted);
            }
            let row = campaign_trial(self.parts.scenario(), first_seed, trial).map_err(|error| Failure::Trial {
                folder: self.folder().display().to_string(),
                seed: first_seed.wrapping_add(trial),
                error,
            })?;
            counter.advance(1);
            Ok(row)
        };
        let trials: Vec<u64> = self.parts.range(number).collect();
        let start = Instant::now();
        let rows: Vec<CampaignRow> = trials.into_par_iter().map(trial).collect::<Result<_, Failure>>()?;
        // Threads work on several trials at a time, so a trial's own time is not what it costs.
        let core_seconds = start.elapsed().as_secs_f64() * rayon::current_num_threads() as f64;
        if interrupted() {
            return Err(Failure::ExperimentInterrupted);
        }
        self.check_folder()?;
        let part = self.parts.part(rows, core_seconds);
        self.parts.keep(number, &campaign_parquet::to_bytes(&part)?)?;
        Ok(part)
    }
}

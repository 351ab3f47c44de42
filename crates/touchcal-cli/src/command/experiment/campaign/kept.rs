//! The parts of one scenario's trials: computed, kept in a folder, and taken from there.

use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use touchcal::experiment::{CampaignRow, CampaignSummary, campaign_trial};
use touchcal::io::campaign_parquet::{self, Part};
use touchcal::io::scenario_file::{self, SCENARIO, ScenarioFile, TextFile};
use touchcal::io::{IoError, atomic};

use super::PART;
use crate::args::CampaignArgs;
use crate::command::Failure;
use crate::progress::{Counter, interrupted};

/// Folder of the parts, within that of the campaign.
pub const PARTS: &str = "parts";

/// Trials of one scenario.
pub struct Campaign {
    file: ScenarioFile,
    /// All that rows depend on.
    settings: String,
    folder: PathBuf,
    first_seed: u64,
    trials: u64,
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
    /// Writes the scenario beside the parts, and reads it from there: what is simulated is what that text says, to the last bit.
    pub fn new(files: &[TextFile], folder: PathBuf, args: &CampaignArgs) -> Result<Self, Failure> {
        let parts = folder.join(PARTS);
        files.iter().try_for_each(|file| atomic::write(&parts.join(&file.name), file.text.as_bytes()))?;
        let file = scenario_file::read_file(&parts.join(SCENARIO))?;
        let scenario: String = files.iter().map(|file| file.text.as_str()).collect();
        let settings = format!("touchcal {}, first seed {}\n{scenario}", env!("CARGO_PKG_VERSION"), args.seed);
        Ok(Campaign { file, settings, folder, first_seed: args.seed, trials: args.trials })
    }

    /// Where it is kept.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Takes the parts that are there, and computes the others that are `mine`.
    pub fn run(&self, mine: impl Fn(u64) -> bool, counter: &Counter) -> Result<Found, Failure> {
        let mut found = Found { summary: CampaignSummary::default(), core_seconds: 0.0, computed: 0, missing: 0 };
        for number in 0..self.trials.div_ceil(PART) {
            let part = match self.kept(number) {
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

    fn range(&self, part: u64) -> std::ops::Range<u64> {
        part * PART..((part + 1) * PART).min(self.trials)
    }

    fn path(&self, part: u64) -> PathBuf {
        self.folder.join(PARTS).join(format!("part-{part:06}.parquet"))
    }

    /// A part that is there, whole and of these settings; any other is no part of this campaign.
    fn kept(&self, number: u64) -> Option<Part> {
        let path: &Path = &self.path(number);
        let part = path.exists().then(|| campaign_parquet::read_file(path).ok()).flatten()?;
        let whole = part.rows.iter().map(|row| row.trial).eq(self.range(number));
        (whole && part.settings == self.settings).then_some(part)
    }

    fn compute(&self, number: u64, counter: &Counter) -> Result<Part, Failure> {
        let trial = |trial: u64| {
            if interrupted() {
                return Err(Failure::ExperimentInterrupted);
            }
            let row = campaign_trial(&self.file.scenario, self.first_seed, trial).map_err(|error| Failure::Trial {
                folder: self.folder.display().to_string(),
                seed: self.first_seed.wrapping_add(trial),
                error,
            })?;
            counter.more(1);
            Ok(row)
        };
        let trials: Vec<u64> = self.range(number).collect();
        let start = Instant::now();
        let rows: Vec<CampaignRow> = trials.into_par_iter().map(trial).collect::<Result<_, Failure>>()?;
        // Threads work on several trials at a time, so that one's own time says little.
        let core_seconds = start.elapsed().as_secs_f64() * rayon::current_num_threads() as f64;
        if interrupted() {
            return Err(Failure::ExperimentInterrupted);
        }
        let part = Part { settings: self.settings.clone(), trials: self.trials, core_seconds, rows };
        let bytes: Result<Vec<u8>, IoError> = campaign_parquet::to_bytes(&part);
        atomic::write(&self.path(number), &bytes?)?;
        Ok(part)
    }
}

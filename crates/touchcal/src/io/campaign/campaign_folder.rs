//! A campaign's folder: the scenario, and a Parquet file of its own name for every [`PART`] trials.
//! Who computes which, where and when, is of no consequence.

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::experiment::CampaignRow;
use crate::io::base::atomic;
use crate::io::base::error::{IoError, Place};
use crate::io::campaign::campaign_parquet::{self, Part};
use crate::io::scenario::scenario_file::{self, SCENARIO, TextFile};
use crate::sim::Scenario;

/// Trials of a part: what is computed, written and kept together.
pub const PART: u64 = 50;
/// Folder of the parts, within that of the campaign.
pub const PARTS: &str = "parts";

/// Trials of one scenario.
#[derive(Clone, Debug)]
pub struct CampaignFolder {
    scenario: Scenario,
    /// All that rows depend on.
    settings: String,
    folder: PathBuf,
    first_seed: u64,
    trials: u64,
}

impl CampaignFolder {
    /// Writes the scenario beside the parts, and reads it from there: what is simulated is what
    /// that text says, to the last bit. `files` are those of
    /// [`scenario_text`](scenario_file::scenario_text).
    ///
    /// # Errors
    /// If they cannot be written, or are no scenario.
    pub fn new(files: &[TextFile], folder: PathBuf, trials: u64, first_seed: u64) -> Result<Self, IoError> {
        let parts = folder.join(PARTS);
        files.iter().try_for_each(|file| atomic::write(&parts.join(&file.name), file.text.as_bytes()))?;
        let scenario = scenario_file::read_file(&parts.join(SCENARIO))?.scenario;
        let text: String = files.iter().map(|file| file.text.as_str()).collect();
        let settings = format!("touchcal {}, first seed {first_seed}\n{text}", env!("CARGO_PKG_VERSION"));
        Ok(CampaignFolder { scenario, settings, folder, first_seed, trials })
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The scenario that all trials of the campaign simulate.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Seed of the first trial; the others count on from it.
    pub fn first_seed(&self) -> u64 {
        self.first_seed
    }

    /// Number of parts.
    pub fn count(&self) -> u64 {
        self.trials.div_ceil(PART)
    }

    /// Trials of a part.
    pub fn range(&self, part: u64) -> Range<u64> {
        part * PART..((part + 1) * PART).min(self.trials)
    }

    fn path(&self, part: u64) -> PathBuf {
        self.folder.join(PARTS).join(format!("part-{part:06}.parquet"))
    }

    /// A part that is there, whole and of these settings; any other is no part of this campaign.
    pub fn kept(&self, part: u64) -> Option<Part> {
        campaign_parquet::read_file(&self.path(part)).ok().filter(|found| self.is_whole(part, found))
    }

    /// Writes the bytes of a part, wherever it was computed.
    ///
    /// # Errors
    /// If they are not whole or not of these settings, or cannot be written; the file is then as it
    /// was.
    pub fn keep(&self, part: u64, content: &[u8]) -> Result<(), IoError> {
        let path = self.path(part);
        atomic::write_by(&path, |file| {
            let failed = |source| IoError::file(&path, "write", source);
            file.write_all(content).map_err(failed)?;
            let found = campaign_parquet::read_open(file.try_clone().map_err(failed)?, &path)?;
            let other = || IoError::unexpected(place(&path), "a part of this campaign and version", "another");
            self.is_whole(part, &found).then_some(()).ok_or_else(other)
        })
    }

    fn is_whole(&self, part: u64, found: &Part) -> bool {
        found.rows.iter().map(|row| row.trial).eq(self.range(part)) && found.settings == self.settings
    }

    /// Rows as a part of this campaign, and the seconds of one core that they took.
    pub fn part(&self, rows: Vec<CampaignRow>, core_seconds: f64) -> Part {
        Part { settings: self.settings.clone(), trials: self.trials, core_seconds, rows }
    }

    /// Writes the rows of all parts to one file; only some are in memory at a time.
    ///
    /// # Errors
    /// If a part is not there, or the file cannot be written.
    pub fn write_rows(&self, path: &Path) -> Result<(), IoError> {
        let missing = |part| IoError::unexpected(place(&self.path(part)), "a part of this campaign", "none");
        let whole = |part| self.kept(part).ok_or_else(|| missing(part));
        let mut core_seconds = 0.0;
        for part in 0..self.count() {
            core_seconds += whole(part)?.core_seconds;
        }
        let rows = (0..self.count()).map(|part| Ok(whole(part)?.rows));
        campaign_parquet::write_file(path, &self.part(Vec::new(), core_seconds), rows)
    }
}

fn place(path: &Path) -> Place {
    Place::file(path.display().to_string())
}

//! A campaign's folder: the scenario, and a Parquet file for every [`PART`] trials. Parts may be
//! computed in any order, by any number of processes or machines.

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use crate::experiment::CampaignRow;
use crate::io::base::atomic;
use crate::io::base::error::{IoError, Place};
use crate::io::campaign::campaign_parquet::{self, Part};
use crate::io::scenario::scenario_file::{self, SCENARIO, TextFile};
use crate::sim::Scenario;

/// Number of trials in a part (fewer in the last): what is computed, written and kept together.
pub const PART: u64 = 50;
/// Name of the folder that holds the parts, within that of the campaign.
pub const PARTS: &str = "parts";

/// The folder of a campaign: simulated trials of one scenario with successive seeds, divided into
/// parts.
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
    /// Writes the scenario's files into `folder`, beside the parts, and reads the scenario back, so
    /// that all processes simulate the same text, to the last bit. `files` are those of
    /// [`scenario_text`](scenario_file::scenario_text), among them one named [`SCENARIO`]; the
    /// campaign has `trials` (≥ 0) trials with the seeds `first_seed`, `first_seed + 1`, … Missing
    /// folders are made; parts that are there are left.
    ///
    /// # Errors
    /// [`IoError`] if the files cannot be written, or are no scenario; some may then be written.
    pub fn new(files: &[TextFile], folder: PathBuf, trials: u64, first_seed: u64) -> Result<Self, IoError> {
        let parts = folder.join(PARTS);
        files.iter().try_for_each(|file| atomic::write(&parts.join(&file.name), file.text.as_bytes()))?;
        let scenario = scenario_file::read_file(&parts.join(SCENARIO))?.scenario;
        let text: String = files.iter().map(|file| file.text.as_str()).collect();
        let settings = format!("touchcal {}, first seed {first_seed}\n{text}", env!("CARGO_PKG_VERSION"));
        Ok(CampaignFolder { scenario, settings, folder, first_seed, trials })
    }

    /// Path of the campaign's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The scenario that all trials of the campaign simulate.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// Seed of trial 0; that of trial `k` is greater by `k`, wrapping around.
    pub fn first_seed(&self) -> u64 {
        self.first_seed
    }

    /// Number of parts: trials over [`PART`], rounded up; 0 without trials.
    pub fn count(&self) -> u64 {
        self.trials.div_ceil(PART)
    }

    /// Numbers of the trials in part `part` (from 0), ascending; empty where `part` is
    /// [`count`](CampaignFolder::count) or more.
    pub fn range(&self, part: u64) -> Range<u64> {
        part * PART..((part + 1) * PART).min(self.trials)
    }

    fn path(&self, part: u64) -> PathBuf {
        self.folder.join(PARTS).join(format!("part-{part:06}.parquet"))
    }

    /// Part `part` (from 0) from its file; `None` if the file is missing, damaged, incomplete, or
    /// computed with other settings, such as another version or scenario.
    pub fn kept(&self, part: u64) -> Option<Part> {
        campaign_parquet::read_file(&self.path(part)).ok().filter(|found| self.is_whole(part, found))
    }

    /// Writes part `part` (from 0, below [`count`](CampaignFolder::count)), given as the bytes of
    /// its Parquet file, see [`to_bytes`](campaign_parquet::to_bytes), after checking that it is
    /// complete.
    ///
    /// # Errors
    /// [`IoError`] if the bytes are no part, the part is incomplete or has other settings, or it
    /// cannot be written; the file is then as it was.
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

    /// Removes the temporary files that ended runs of this machine left among the parts. Not while
    /// other machines write parts.
    pub fn remove_left_over(&self) {
        atomic::remove_left_over(&self.folder.join(PARTS));
    }

    /// A part of this campaign from its rows, one per trial in the order of
    /// [`range`](CampaignFolder::range), and the computing time of them all (s, on one core). The
    /// rows are not checked here but in [`keep`](CampaignFolder::keep).
    pub fn part(&self, rows: Vec<CampaignRow>, core_seconds: f64) -> Part {
        Part { settings: self.settings.clone(), trials: self.trials, core_seconds, rows }
    }

    /// Checks that all parts are in the folder, as they are unless another run with other settings
    /// wrote into it.
    ///
    /// # Errors
    /// [`IoError`] that names the first part that [`kept`](CampaignFolder::kept) does not return.
    pub fn check(&self) -> Result<(), IoError> {
        (0..self.count()).try_for_each(|part| self.whole(part).map(drop))
    }

    fn whole(&self, part: u64) -> Result<Part, IoError> {
        let found = "none: the file was removed or damaged, or another run with other settings writes into the folder";
        self.kept(part).ok_or_else(|| IoError::unexpected(place(&self.path(part)), "a part of this campaign", found))
    }

    /// Writes the rows of all parts, in the order of trials, to one Parquet file; only some are in
    /// memory at a time.
    ///
    /// # Errors
    /// [`IoError`] if a part is missing or not one that [`kept`](CampaignFolder::kept) returns, or
    /// the file cannot be written; `path` is then as it was.
    pub fn write_rows(&self, path: &Path) -> Result<(), IoError> {
        let mut core_seconds = 0.0;
        for part in 0..self.count() {
            core_seconds += self.whole(part)?.core_seconds;
        }
        let rows = (0..self.count()).map(|part| Ok(self.whole(part)?.rows));
        campaign_parquet::write_file(path, &self.part(Vec::new(), core_seconds), rows)
    }
}

fn place(path: &Path) -> Place {
    Place::file(path.display().to_string())
}

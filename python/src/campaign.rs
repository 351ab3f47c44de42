//! Many trials of one scenario, a part at a time.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use touchcal::experiment::{CampaignRow, campaign_trial};
use touchcal::io::campaign_folder::CampaignFolder;
use touchcal::io::campaign_parquet;
use touchcal::io::scenario_file::{self, TextFile};

use crate::error::{Error, SimulationError, io, refused, unexpected, unpicklable};
use crate::simulation::scenario_of;
use crate::threads::detached;

/// How often Ctrl-C is looked for.
const LOOK: Duration = Duration::from_millis(50);
/// Most trials and threads, as on the command line.
const MOST_TRIALS: u64 = 100_000_000;
const MOST_THREADS: usize = 1024;

/// Trials of one scenario, in parts of fifty that are kept in a folder: the one that `touchcal
/// experiment campaign` writes and `merge` takes.
///
/// Trial k follows from the scenario and `seed` + k alone, so parts may be computed anywhere, in
/// any order. `touchcal.distributed.run_campaign` does so.
///
/// Args:
///     folder: where it is, or is to be; the scenario is written there.
///     scenario: path of a scenario.toml; or the name of a preset: a str without `/` and `.`.
///     trials: how many.
///     seed: of the first trial; the others count on from it.
///     contacts: contacts with each fixture; default: what the scenario says.
///
/// Attributes:
///     files: names and texts of what it simulates: scenario.toml and what that refers to.
///     trials, seed: as given.
///
/// Raises:
///     FileError, InputError: if the scenario is not one, or the folder cannot be written.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug)]
pub struct Campaign {
    parts: CampaignFolder,
    #[pyo3(get)]
    files: Vec<(String, String)>,
    #[pyo3(get)]
    trials: u64,
    #[pyo3(get)]
    seed: u64,
}

#[pymethods]
impl Campaign {
    #[new]
    #[pyo3(signature = (folder, scenario, trials, seed=1, *, contacts=None))]
    fn new(
        folder: PathBuf,
        scenario: &Bound<'_, PyAny>,
        trials: u64,
        seed: u64,
        contacts: Option<usize>,
    ) -> PyResult<Campaign> {
        let files = scenario_file::scenario_text(&scenario_of(scenario, contacts)?);
        Campaign::from_files(folder, files.into_iter().map(|file| (file.name, file.text)).collect(), trials, seed)
    }

    /// The same campaign in another folder, maybe on another machine.
    ///
    /// Args:
    ///     folder: where it is to be.
    ///     files, trials, seed: the attributes of the campaign.
    #[staticmethod]
    fn from_files(folder: PathBuf, files: Vec<(String, String)>, trials: u64, seed: u64) -> PyResult<Campaign> {
        if !(1..=MOST_TRIALS).contains(&trials) {
            return Err(unexpected("trials", format!("a number from 1 to {MOST_TRIALS}"), format!("{trials}")));
        }
        let texts: Vec<TextFile> = files.iter().cloned().map(|(name, text)| TextFile { name, text }).collect();
        let parts = CampaignFolder::new(&texts, folder, trials, seed).map_err(io)?;
        Ok(Campaign { parts, files, trials, seed })
    }

    /// Number of parts.
    #[getter]
    fn parts(&self) -> u64 {
        self.parts.count()
    }

    /// Whether a part is in the folder, whole and of this campaign.
    fn has(&self, py: Python<'_>, part: u64) -> PyResult<bool> {
        self.check(part)?;
        Ok(detached(py, || self.parts.kept(part).is_some()))
    }

    /// Simulates and calibrates the trials of a part. Nothing is written.
    ///
    /// Args:
    ///     part: its number.
    ///     threads: how many to use; the rows do not depend on it.
    ///
    /// Returns:
    ///     its Parquet file, for `keep`.
    ///
    /// Raises:
    ///     SimulationError: if a trial cannot be simulated.
    #[pyo3(signature = (part, threads=1))]
    fn compute<'py>(&self, py: Python<'py>, part: u64, threads: usize) -> PyResult<Bound<'py, PyBytes>> {
        self.check(part)?;
        let start = Instant::now();
        let rows = detached(py, || self.watched(part, threads))?;
        let part = self.parts.part(rows, start.elapsed().as_secs_f64() * threads as f64);
        Ok(PyBytes::new(py, &campaign_parquet::to_bytes(&part).map_err(io)?))
    }

    /// Writes a part to the folder, wherever it was computed.
    ///
    /// Args:
    ///     part: its number.
    ///     content: its Parquet file.
    ///
    /// Raises:
    ///     InputError: if it is not whole, or not of this campaign and version of touchcal; nothing
    ///         is written.
    fn keep(&self, part: u64, content: &[u8]) -> PyResult<()> {
        self.check(part)?;
        self.parts.keep(part, content).map_err(io)
    }

    /// Writes the rows of all parts to one Parquet file, as `touchcal experiment merge --rows`
    /// does.
    ///
    /// Raises:
    ///     InputError: if a part is not there.
    fn write_rows(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        detached(py, || self.parts.write_rows(&path)).map_err(io)
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(unpicklable("Campaign", "send `files`, `trials` and `seed`, of which `Campaign.from_files` makes it again"))
    }

    fn __repr__(&self) -> String {
        format!("Campaign({:?}, trials={}, seed={})", self.parts.folder(), self.trials, self.seed)
    }
}

impl Campaign {
    fn check(&self, part: u64) -> PyResult<()> {
        match self.parts.count() {
            parts if part < parts => Ok(()),
            parts => Err(unexpected("part", format!("a number below {parts}"), format!("{part}"))),
        }
    }

    /// The rows of a part from threads of their own, while this one looks for Ctrl-C.
    fn watched(&self, part: u64, threads: usize) -> PyResult<Vec<CampaignRow>> {
        if !(1..=MOST_THREADS).contains(&threads) {
            return Err(unexpected("threads", format!("a number from 1 to {MOST_THREADS}"), format!("{threads}")));
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(|error| refused("threads", error))?;
        let stop = &AtomicBool::new(false);
        let (done, wait) = channel();
        pool.in_place_scope(|scope| {
            scope.spawn(move |_| drop(done.send(self.rows(part, stop))));
            let mut raised = None;
            loop {
                match wait.recv_timeout(LOOK) {
                    Ok(rows) => return raised.map_or(rows, Err),
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(error) = Python::attach(|py| py.check_signals()) {
                            stop.store(true, Ordering::Relaxed);
                            raised = Some(error);
                        }
                    }
                    // The scope passes the panic on.
                    Err(RecvTimeoutError::Disconnected) => return Ok(Vec::new()),
                }
            }
        })
    }

    fn rows(&self, part: u64, stop: &AtomicBool) -> PyResult<Vec<CampaignRow>> {
        let trial = |trial| {
            if stop.load(Ordering::Relaxed) {
                return Err(Error::new_err("interrupted"));
            }
            let seed = self.seed.wrapping_add(trial);
            let failed = |error| SimulationError::new_err(format!("seed {seed}: {error}"));
            campaign_trial(self.parts.scenario(), self.seed, trial).map_err(failed)
        };
        let trials: Vec<u64> = self.parts.range(part).collect();
        trials.into_par_iter().map(trial).collect()
    }
}

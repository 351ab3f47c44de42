//! The commands, each from arguments to output.

pub mod calibrate;
pub mod convert;
pub mod demo;
pub mod evaluate;
pub mod experiment;
pub mod inspect;
pub mod manifold;
pub mod manual;
pub mod new;
pub mod simulate;
pub mod train;

use std::path::{Path, PathBuf};
use std::time::Instant;

use touchcal::estimate::StopReason;
use touchcal::io::calibration_folder::Solved;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{IoError, Loaded, problem_file};
use touchcal::manifold::SamplesError;
use touchcal::manifold::learned::TrainingError;
use touchcal::sim::{PartsError, SimulationError};

use crate::args::{Arm, Source};
use crate::progress::Spinner;

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// As it should.
    Done,
    /// It ran, but its result is not usable.
    NotUsable,
}

/// Why a command could not run to its end.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// A file.
    #[error(transparent)]
    Io(#[from] IoError),
    /// A simulation.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A simulation of a campaign.
    #[cfg(feature = "parquet")]
    #[error("{folder}, seed {seed}: {error}")]
    Trial {
        /// Where the campaign is kept.
        folder: String,
        /// Seed of the trial.
        seed: u64,
        /// What is wrong.
        error: SimulationError,
    },
    /// A scenario's parts.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// Poses that are no manifold.
    #[error("{of}: {error}")]
    Samples {
        /// Where they came from.
        of: String,
        /// What is wrong with them.
        error: SamplesError,
    },
    /// A training.
    #[error("could not train: {0}")]
    Training(#[from] TrainingError),
    /// The user, while something can go on later.
    #[error("interrupted after {step} steps; {checkpoint} is kept, go on with `{command}`")]
    TrainingInterrupted {
        /// Steps done.
        step: u64,
        /// What was written.
        checkpoint: String,
        /// How to go on.
        command: String,
    },
    /// The user, between the rows of an experiment.
    #[error("interrupted; rows that are done are kept, the same command goes on with the others")]
    ExperimentInterrupted,
    /// The user.
    #[error("interrupted; no result was written")]
    Interrupted,
    /// Parts of a campaign that are not one whole.
    #[cfg(feature = "parquet")]
    #[error("could not merge: {0}")]
    Merge(String),
    /// Output over input.
    #[error(
        "{output}: expected an output that is none of the inputs, found the {input} that is read; choose another --out"
    )]
    OverInput {
        /// What would be written.
        output: String,
        /// What is read, as it was named.
        input: String,
    },
    /// Output into a file.
    #[error("{0}: expected a folder to write into, found a file; choose another --out")]
    IntoFile(String),
    /// Parts that do not fit, or arguments that lack a part.
    #[error("could not begin: {0}")]
    Setup(String),
    /// JSON.
    #[error("could not write JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Stdout.
    #[error("could not write to stdout: {0}")]
    Stdout(std::io::Error),
}

/// Refuses to write over what is read, and into what is no folder: before long work, not after it.
fn check_outputs<'a>(
    outputs: impl IntoIterator<Item = PathBuf>,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Failure> {
    let there = |path: &Path| path.canonicalize().ok();
    let inputs: Vec<&Path> = inputs.into_iter().collect();
    for output in outputs {
        if let Some(file) = output.ancestors().skip(1).find(|above| above.is_file()) {
            return Err(Failure::IntoFile(file.display().to_string()));
        }
        let Some(found) = there(&output) else { continue };
        if let Some(input) = inputs.iter().find(|input| there(input).as_ref() == Some(&found)) {
            let [output, input] = [&*output, input].map(|path| path.display().to_string());
            return Err(Failure::OverInput { output, input });
        }
    }
    Ok(())
}

/// Reads a problem; `arm` is that of a `--mukca` folder.
fn load(source: &Source, arm: &Arm) -> Result<Loaded, Failure> {
    let loaded = match (&source.mukca, &arm.urdf, &source.problem) {
        (Some(folder), Some(urdf), _) => {
            let options = MukcaOptions { joint_compliance: arm.joint_compliance, ..mukca_options(source) };
            mukca::read(folder, urdf::read_file(urdf, ends(source))?, &options)?
        }
        (_, _, Some(problem)) => problem_file::read_file(problem)?,
        // clap lets neither through.
        _ => return Err(Failure::Setup("neither a problem file nor --mukca with --urdf".to_owned())),
    };
    crate::output::notes(loaded.problem.contacts.notes());
    Ok(loaded.with_known_shapes()?)
}

/// The chain of a `--mukca` folder's arm.
fn ends(source: &Source) -> Ends<'_> {
    Ends { base: None, tip: source.tip.as_deref() }
}

fn mukca_options(source: &Source) -> MukcaOptions {
    MukcaOptions {
        only: source.only.clone(),
        except: source.except.clone(),
        spacing: source.spacing_mm * 1e-3,
        ..MukcaOptions::default()
    }
}

/// Calibrates, watched.
fn calibrate(loaded: &Loaded) -> Result<Solved, Failure> {
    let spinner = Spinner::new("Calibrating");
    let start = Instant::now();
    let mut steps = Vec::new();
    let estimate = touchcal::estimate::calibrate(&loaded.problem, &mut |progress| {
        steps.push(*progress);
        spinner.observe(progress)
    });
    let seconds = start.elapsed().as_secs_f64();
    // Between the last look and here the user may have asked too.
    if estimate.termination.reason == StopReason::Interrupted || crate::progress::interrupted() {
        return Err(Failure::Interrupted);
    }
    Ok(Solved { estimate, prefit: touchcal::estimate::evaluate(&loaded.problem), steps, seconds })
}

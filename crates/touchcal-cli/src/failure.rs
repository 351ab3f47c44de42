//! How a command ends, and why it fails.

use touchcal::estimate::SelectionError;
use touchcal::io::IoError;
use touchcal::manifold::SamplesError;
use touchcal::manifold::learned::TrainingError;
use touchcal::sim::{PartsError, SimulationError};

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Successfully.
    Done,
    /// With a result that must not be used.
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
        /// The campaign's folder.
        folder: String,
        /// Seed of the trial.
        seed: u64,
        /// The error.
        error: SimulationError,
    },
    /// Calibrations of which none of the arm's parameters is in both.
    #[error("{} and {}: expected parameters of the arm that both estimate, found none", .0[0], .0[1])]
    NothingInCommon([String; 2]),
    /// A calibration without uncertainties.
    #[error(
        "{0}: expected estimates with uncertainties, found none (gradient descent, or a sampled or learned manifold)"
    )]
    NoUncertainty(String),
    /// A scenario's parts.
    #[error(transparent)]
    Parts(#[from] PartsError),
    /// Poses that are no manifold.
    #[error("{of}: {error}")]
    Samples {
        /// Where they came from.
        of: String,
        /// The error.
        error: SamplesError,
    },
    /// Contacts of an arm that misses its fixture.
    #[error(
        "{problem}: {evidence}: the arm is not calibrated, or tool or fixture are not what and where they are declared; calibrate the arm (touchcal calibrate {problem} --out out), and name out/calibrated.urdf as `urdf` and the places that it found in the problem file"
    )]
    ArmMisses {
        /// Path of the problem file.
        problem: String,
        /// What was expected, and what was found.
        evidence: String,
    },
    /// A choice of a model.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// A training.
    #[error("could not train: {0}")]
    Training(#[from] TrainingError),
    /// Interrupted during a training.
    #[error("interrupted after {step} steps; {checkpoint} is saved, resume with `{command}`")]
    TrainingInterrupted {
        /// Steps done.
        step: u64,
        /// The checkpoint's path.
        checkpoint: String,
        /// The command that resumes.
        command: String,
    },
    /// Interrupted between the rows of an experiment.
    #[error("interrupted; finished rows are saved, the same command continues with the others")]
    ExperimentInterrupted,
    /// Interrupted.
    #[error("interrupted; no result was written")]
    Interrupted,
    /// Parts of a campaign that are not one whole.
    #[cfg(feature = "parquet")]
    #[error("could not merge: {0}")]
    Merge(String),
    /// Output over input.
    #[error("{output}: expected an output that is no input, found the input {input}; choose another --out")]
    OverInput {
        /// Path of the output.
        output: String,
        /// Path of the input, as given.
        input: String,
    },
    /// Output into a file.
    #[error("{0}: expected a folder to write into, found a file; choose another --out")]
    IntoFile(String),
    /// A campaign's folder that was removed meanwhile.
    #[cfg(feature = "parquet")]
    #[error("{0}: the folder of the campaign is gone; the same command starts from the first trial")]
    FolderGone(String),
    /// Parts that do not fit, or arguments that lack a part.
    #[error("could not start: {0}")]
    Setup(String),
    /// Arguments that are not, or no longer, accepted.
    #[error("{0}")]
    Usage(String),
    /// JSON.
    #[error("could not write JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Stdout.
    #[error("could not write to stdout: {0}")]
    Stdout(std::io::Error),
}

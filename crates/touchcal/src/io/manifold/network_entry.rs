//! What a network's files say about it: one schema for weights and checkpoints.

use serde::{Deserialize, Serialize};

use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place, quoted};
use crate::manifold::TrainingPairs;
use crate::manifold::coordinates::{Coordinates, Metric};
use crate::manifold::learned::{Output, Scaling, TrainingOptions};

const POSE: &str = "fixture_from_tool";
const COLUMNS: [&str; 6] = ["x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad"];
const ACTIVATION: &str = "relu";
/// Most layers, and greatest width, of a file that is read.
const MOST_LAYERS: usize = 64;
const GREATEST_WIDTH: usize = 1 << 16;

/// Manifold and pairs from which a network learned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Teacher {
    /// Path and fingerprint of the manifold file.
    pub manifold: Input,
    /// Number of samples in the manifold file.
    pub samples: u64,
    /// Least and greatest value of each coordinate `[x, y, z, α, β, γ]` of the samples
    /// `fixture_from_tool` (m for 0–2, rad for 3–5).
    pub bounds: [(f64, f64); 6],
    /// Largest offset (≥ 0) of a pair's input from a sample in each coordinate `[x, y, z, α, β, γ]`
    /// (m, rad), in the tool's frame: [`TrainingPairs::bounds`].
    pub offsets: Coordinates,
    /// Seed of the pairs: [`TrainingPairs::seed`].
    pub seed: u64,
}

impl Teacher {
    /// The pairs from which the network learned, from `offsets` and `seed`.
    pub fn pairs(&self) -> TrainingPairs {
        TrainingPairs { bounds: self.offsets, seed: self.seed }
    }
}

/// A network, without its weights.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NetworkEntry {
    pose: String,
    columns: Vec<String>,
    widths: Vec<usize>,
    activation: String,
    output: OutputEntry,
    metres_per_radian: f64,
    input_centre: Coordinates,
    input_scale: Coordinates,
    output_centre: Coordinates,
    output_length: f64,
    training: TrainingEntry,
    teacher: Teacher,
    version: String,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum OutputEntry {
    Pose,
    Correction,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TrainingEntry {
    batch: usize,
    steps: u64,
    rate: f64,
    pairs: u64,
    held_out: usize,
    check_every: u64,
    patience: u64,
    seed: u64,
}

impl NetworkEntry {
    pub(crate) fn new(scaling: &Scaling, options: &TrainingOptions, teacher: &Teacher) -> NetworkEntry {
        let TrainingOptions { batch, steps, rate, pairs, held_out, check_every, patience, seed, .. } = *options;
        NetworkEntry {
            pose: POSE.to_owned(),
            columns: COLUMNS.map(str::to_owned).to_vec(),
            widths: [6].iter().chain(&options.hidden).chain(&[6]).copied().collect(),
            activation: ACTIVATION.to_owned(),
            output: match scaling.output {
                Output::Pose => OutputEntry::Pose,
                Output::Correction => OutputEntry::Correction,
            },
            metres_per_radian: scaling.metric.metres_per_radian,
            input_centre: scaling.input_centre,
            input_scale: scaling.input_scale,
            output_centre: scaling.output_centre,
            output_length: scaling.output_length,
            training: TrainingEntry { batch, steps, rate, pairs, held_out, check_every, patience, seed },
            teacher: teacher.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }

    pub(crate) fn widths(&self) -> &[usize] {
        &self.widths
    }

    pub(crate) fn teacher(&self) -> &Teacher {
        &self.teacher
    }

    pub(crate) fn scaling(&self) -> Scaling {
        Scaling {
            output: self.output(),
            metric: Metric { metres_per_radian: self.metres_per_radian },
            input_centre: self.input_centre,
            input_scale: self.input_scale,
            output_centre: self.output_centre,
            output_length: self.output_length,
        }
    }

    pub(crate) fn options(&self) -> TrainingOptions {
        let TrainingEntry { batch, steps, rate, pairs, held_out, check_every, patience, seed } = self.training;
        let hidden = self.widths[1..self.widths.len() - 1].to_vec();
        TrainingOptions {
            hidden,
            output: self.output(),
            batch,
            steps,
            rate,
            pairs,
            held_out,
            check_every,
            patience,
            seed,
        }
    }

    fn output(&self) -> Output {
        match self.output {
            OutputEntry::Pose => Output::Pose,
            OutputEntry::Correction => Output::Correction,
        }
    }

    /// Refuses what no network of this kind has; JSON has already refused what is no number.
    pub(crate) fn check(&self, file: &str) -> Result<(), IoError> {
        let wrong = |field: &str, expected: &str, found: String| {
            Err(IoError::unexpected(Place::file(file).field(format!("metadata, {field}")), expected, found))
        };
        if self.pose != POSE {
            return wrong("pose", POSE, quoted(&self.pose));
        }
        if self.columns != COLUMNS {
            return wrong("columns", &COLUMNS.join(","), quoted(&self.columns.join(",")));
        }
        if self.activation != ACTIVATION {
            return wrong("activation", ACTIVATION, quoted(&self.activation));
        }
        let widths = &self.widths;
        let ends = (widths.first(), widths.last());
        let sizes = widths.iter().all(|width| (1..=GREATEST_WIDTH).contains(width));
        if !(2..=MOST_LAYERS + 1).contains(&widths.len()) || ends != (Some(&6), Some(&6)) || !sizes {
            let expected = format!("6, … 6, at most {MOST_LAYERS} layers of up to {GREATEST_WIDTH}");
            return wrong("widths", &expected, quoted(&format!("{widths:?}")));
        }
        let lengths = self.input_scale.iter().chain([&self.output_length, &self.metres_per_radian]);
        if let Some(found) = lengths.into_iter().find(|value| **value <= 0.0) {
            return wrong("input_scale, output_length or metres_per_radian", "positive numbers", format!("{found}"));
        }
        match self.teacher.bounds.iter().find(|(least, greatest)| least > greatest) {
            Some(found) => wrong("bounds", "the least before the greatest", format!("{found:?}")),
            None => Ok(()),
        }
    }
}

//! Output of a training.

use std::path::PathBuf;

use serde::Serialize;
use touchcal::io::Input;
use touchcal::io::weights_file::WeightsFile;
use touchcal::manifold::learned::{Accuracy, Ending, Output, PoseDistance, Spread};

use crate::failure::Failure;
use crate::table::Table;

/// A trained network with its accuracy.
pub struct TrainingSummary<'a> {
    pub weights: &'a WeightsFile,
    pub ending: Ending,
    pub rows: &'a [Accuracy],
    pub seconds: f64,
}

impl TrainingSummary<'_> {
    /// Text for a terminal.
    pub fn text(&self, written: &[PathBuf]) -> String {
        let WeightsFile { options, step, teacher, .. } = self.weights;
        let hidden = options.hidden.iter().map(|width| format!("{width} - ")).collect::<String>();
        let early = if self.ending == Ending::NoGain { ", stopped without further improvement" } else { "" };
        let held_out = self.error().map_or_else(|| "-".to_owned(), |error| format!("{:.3} mm", 1e3 * error));
        let written: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
        [
            format!("Network   6 - {hidden}6, trained on projections onto {} samples\n", teacher.samples),
            format!("Training  {:.0} s, best after {step} steps of {} pairs{early}\n", self.seconds, options.batch),
            format!(
                "Held out  {held_out} from the nearest sample (root mean square, rotations weighted by the metric)\n\n"
            ),
            format!("{}\n{}\n", self.table(Part::Place), self.table(Part::Turn)),
            format!("Written   {}\n", written.join(", ")),
        ]
        .concat()
    }

    /// Distances of places in millimetres, or angles in degrees.
    fn table(&self, part: Part) -> Table {
        let unit = part.unit();
        let heading = format!("{unit}, offsets up to");
        let headings = [&heading, "pose to sample", "output to manifold", "(95 %)", "output to sample", "(95 %)"];
        let mut table = Table::new(headings);
        let trained = self.weights.teacher.offsets[0];
        for row in self.rows {
            let (mm, deg) = (round(1e3 * row.offset[0]), round(row.offset[3].to_degrees()));
            let outside = if row.offset[0] > trained * (1.0 + 1e-9) { ", outside" } else { "" };
            let Spread { mean, .. } = part.of(&row.before);
            let (manifold, sample) = (part.of(&row.to_manifold), part.of(&row.to_target));
            let cells = [mean, manifold.mean, manifold.q95, sample.mean, sample.q95];
            let cells = cells.map(|value| format!("{:.3}", part.factor() * value));
            table.row([format!("{mm} mm, {deg} deg{outside}")].into_iter().chain(cells));
        }
        table
    }

    /// Root mean square error (m) on the held-out pairs.
    fn error(&self) -> Option<f64> {
        self.weights.loss.map(|loss| self.weights.projection.scaling().distance(loss))
    }

    /// JSON, in SI units and radians.
    pub fn json(&self) -> Result<String, Failure> {
        let WeightsFile { options, teacher, step, .. } = self.weights;
        let metrics = Metrics {
            schema: 1,
            hidden: &options.hidden,
            output: self.output(),
            manifold: &teacher.manifold,
            offsets: teacher.offsets,
            metres_per_radian: self.weights.projection.scaling().metric.metres_per_radian,
            seed: options.seed,
            steps: options.steps,
            best_step: *step,
            batch: options.batch,
            held_out_rms: self.error(),
            seconds: self.seconds,
            accuracy: self.rows.iter().map(Row::from).collect(),
            version: env!("CARGO_PKG_VERSION"),
        };
        Ok(serde_json::to_string_pretty(&metrics)? + "\n")
    }

    /// Metadata of an exported network.
    pub fn properties(&self) -> Vec<(&'static str, String)> {
        let WeightsFile { projection, teacher, .. } = self.weights;
        vec![
            ("touchcal_version", env!("CARGO_PKG_VERSION").to_owned()),
            ("pose", "fixture_from_tool: x_m, y_m, z_m, roll_rad, pitch_rad, yaw_rad".to_owned()),
            ("metres_per_radian", projection.scaling().metric.metres_per_radian.to_string()),
            ("manifold_sha256", teacher.manifold.sha256.clone()),
        ]
    }

    fn output(&self) -> &'static str {
        match self.weights.options.output {
            Output::Pose => "pose",
            Output::Correction => "correction",
        }
    }
}

/// Part of the distance between poses.
#[derive(Clone, Copy)]
enum Part {
    Place,
    Turn,
}

impl Part {
    fn unit(self) -> &'static str {
        match self {
            Part::Place => "mm",
            Part::Turn => "deg",
        }
    }

    fn factor(self) -> f64 {
        match self {
            Part::Place => 1e3,
            Part::Turn => 1f64.to_degrees(),
        }
    }

    fn of(self, apart: &PoseDistance) -> Spread {
        match self {
            Part::Place => apart.place,
            Part::Turn => apart.turn,
        }
    }
}

/// Rounds to 1e-6, which undoes the conversion from degrees to radians and back.
fn round(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

#[derive(Serialize)]
struct Metrics<'a> {
    schema: u32,
    hidden: &'a [usize],
    output: &'static str,
    manifold: &'a Input,
    offsets: [f64; 6],
    metres_per_radian: f64,
    seed: u64,
    steps: u64,
    best_step: u64,
    batch: usize,
    held_out_rms: Option<f64>,
    seconds: f64,
    accuracy: Vec<Row>,
    version: &'static str,
}

#[derive(Serialize)]
struct Row {
    offset: [f64; 6],
    poses: usize,
    pose_to_nearest: Distances,
    output_to_manifold: Distances,
    output_to_nearest: Distances,
}

/// Metres and radians.
#[derive(Serialize)]
struct Distances {
    place_mean: f64,
    place_q95: f64,
    turn_mean: f64,
    turn_q95: f64,
}

impl From<&Accuracy> for Row {
    fn from(row: &Accuracy) -> Row {
        let distances = |apart: &PoseDistance| Distances {
            place_mean: apart.place.mean,
            place_q95: apart.place.q95,
            turn_mean: apart.turn.mean,
            turn_q95: apart.turn.q95,
        };
        Row {
            offset: row.offset,
            poses: row.poses,
            pose_to_nearest: distances(&row.before),
            output_to_manifold: distances(&row.to_manifold),
            output_to_nearest: distances(&row.to_target),
        }
    }
}

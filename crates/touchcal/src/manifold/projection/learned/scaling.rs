//! Conversion between coordinates of poses and the network's inputs and outputs, of order one.

use serde::{Deserialize, Serialize};

use crate::manifold::projection::coordinates::{Coordinates, Metric, wrapped};

/// Quantity that a network's outputs represent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Output {
    /// The projected pose (Negi, Manyar & Gupta 2025, arXiv 2506.17458).
    Pose,
    /// The difference from the pose to its projection.
    Correction,
}

/// Conversion between coordinates `c` (m, rad) of poses and a network's six inputs `x` and six
/// outputs `y`, both without unit: `x = (c − input_centre) / input_scale`, angles the shorter way
/// round, and `F(c) = from + y · output_length / metric`, where `from` is `output_centre` or, for
/// corrections, `c`, and `metric` is 1 for positions and [`Metric::metres_per_radian`] for angles.
///
/// One length for all outputs, so that the mean square of an error of `y` is proportional to that
/// of the metric's distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// Quantity that the outputs represent.
    pub output: Output,
    /// Length that a radian counts as in the outputs: the projection's metric.
    pub metric: Metric,
    /// Mean of the inputs `[x, y, z, α, β, γ]` (m, rad); of angles that of the differences the
    /// shorter way round from the first input.
    pub input_centre: Coordinates,
    /// Root mean square of each input about its mean (m, rad), at least 10⁻⁹.
    pub input_scale: Coordinates,
    /// Mean of the targets `[x, y, z, α, β, γ]` (m, rad), of angles as for the inputs; unused for
    /// corrections.
    pub output_centre: Coordinates,
    /// Length (m) that one unit of an output represents: root mean square of the outputs, at least
    /// 10⁻⁹.
    pub output_length: f64,
}

/// Least scale (m, rad): of an input that never changes.
const LEAST: f64 = 1e-9;

impl Scaling {
    /// Scaling by means and root mean squares of training pairs: `inputs[i]` and its projection
    /// `targets[i]` (m, rad), as many of both. Without pairs the centres are zero and the scales
    /// 10⁻⁹.
    pub fn of(output: Output, metric: Metric, inputs: &[Coordinates], targets: &[Coordinates]) -> Scaling {
        let input_centre = centre(inputs);
        let input_scale = root_mean_square(inputs.iter().map(|c| difference(c, &input_centre))).map(|s| s.max(LEAST));
        let output_centre = centre(targets);
        let squares = inputs.iter().zip(targets).map(|(c, target)| match output {
            Output::Pose => metric.distance(target, &output_centre).powi(2),
            Output::Correction => metric.distance(target, c).powi(2),
        });
        let output_length = (squares.sum::<f64>() / (6 * targets.len().max(1)) as f64).sqrt().max(LEAST);
        Scaling { output, metric, input_centre, input_scale, output_centre, output_length }
    }

    /// The network's input for a pose.
    pub(super) fn input(&self, c: &Coordinates) -> [f32; 6] {
        let difference = difference(c, &self.input_centre);
        std::array::from_fn(|k| (difference[k] / self.input_scale[k]) as f32)
    }

    /// The network's output for a pose whose projection is `target`.
    pub(super) fn target(&self, c: &Coordinates, target: &Coordinates) -> [f32; 6] {
        self.metric.difference(target, self.from(c)).map(|each| (each / self.output_length) as f32)
    }

    /// `F(c)` from the network's output; no number for a pose that is not finite.
    pub(super) fn projected(&self, c: &Coordinates, output: &[f32]) -> Coordinates {
        if c.iter().any(|value| !value.is_finite()) {
            return [f64::NAN; 6];
        }
        let (from, scale) = (self.from(c), self.output_scale());
        std::array::from_fn(|k| from[k] + f64::from(output[k]) * scale[k])
    }

    /// Size of one unit of each output, in the order `[x, y, z, α, β, γ]` (m for 0–2, rad for 3–5).
    pub fn output_scale(&self) -> Coordinates {
        self.metric.point(&[1.0; 6]).map(|length| self.output_length / length)
    }

    /// Root mean square distance (m, in the metric) between projected poses and targets whose
    /// outputs have the mean square error `loss` (no unit, not negative):
    /// `output_length · √(6 loss)`.
    pub fn distance(&self, loss: f64) -> f64 {
        self.output_length * (6.0 * loss).sqrt()
    }

    fn from<'c>(&'c self, c: &'c Coordinates) -> &'c Coordinates {
        match self.output {
            Output::Pose => &self.output_centre,
            Output::Correction => c,
        }
    }
}

/// `to − from`, angles the shorter way round.
fn difference(to: &Coordinates, from: &Coordinates) -> Coordinates {
    std::array::from_fn(|k| if k < 3 { to[k] - from[k] } else { wrapped(to[k] - from[k]) })
}

/// The mean, of angles the mean of their differences from the first one.
fn centre(all: &[Coordinates]) -> Coordinates {
    let Some(first) = all.first() else { return [0.0; 6] };
    let mut sum = [0.0; 6];
    for each in all {
        sum.iter_mut().zip(difference(each, first)).for_each(|(sum, d)| *sum += d);
    }
    std::array::from_fn(|k| first[k] + sum[k] / all.len() as f64)
}

fn root_mean_square(all: impl ExactSizeIterator<Item = Coordinates>) -> Coordinates {
    let count = all.len().max(1) as f64;
    let mut sum = [0.0; 6];
    for each in all {
        sum.iter_mut().zip(each).for_each(|(sum, d)| *sum += d * d);
    }
    sum.map(|sum| (sum / count).sqrt())
}

//! Between coordinates of poses and the numbers of order one that a network likes.

use crate::manifold::projection::coordinates::{Coordinates, Metric, wrapped};

/// What a network's outputs stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// The projected pose (Negi, Manyar & Gupta 2025, arXiv 2506.17458).
    Pose,
    /// The way from the pose to its projection.
    Correction,
}

/// `x = (c − centre) / scale` of the network's input, angles the shorter way round; of its output
/// `y`, `F(c) = from + y · length / metric` where `from` is the centre of the targets or the pose
/// itself.
///
/// One length for all outputs, so that the mean square of an error of `y` is that of the metric's
/// distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling {
    /// What outputs stand for.
    pub output: Output,
    /// How angles compare with lengths.
    pub metric: Metric,
    /// Centre of the inputs (m, rad).
    pub input_centre: Coordinates,
    /// What counts as one in each input (m, rad).
    pub input_scale: Coordinates,
    /// Centre of the targets (m, rad); unused for corrections.
    pub output_centre: Coordinates,
    /// What counts as one in the outputs (m).
    pub output_length: f64,
}

/// Least scale (m, rad): of an input that never changes.
const LEAST: f64 = 1e-9;

impl Scaling {
    /// Centres and root mean squares of pairs, at least one.
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

    /// What one unit of each output is (m, rad).
    pub fn output_scale(&self) -> Coordinates {
        self.metric.point(&[1.0; 6]).map(|length| self.output_length / length)
    }

    /// Distance (m) in the metric of which `loss` is the mean square in each output.
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

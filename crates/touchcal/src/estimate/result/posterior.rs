//! What a calibration knows of its parameters, by name.

use nalgebra::DMatrix;

use super::estimate::{Estimate, NoiseSigma};
use super::warning::Warning;

/// Estimates of a calibration with their covariance, each parameter by its name: what is needed to
/// predict how well the calibrated arm fits contacts of another log.
#[derive(Clone, Debug)]
pub struct ParameterPosterior {
    /// The parameters.
    pub entries: Vec<PosteriorEntry>,
    /// Covariance of the estimates (SI), square, rows and columns in the order of `entries`; zero
    /// for fixed parameters.
    pub covariance: DMatrix<f64>,
    /// Noise of the calibration's contacts; `None` if it is not known.
    pub noise: Option<NoiseSigma>,
}

/// A parameter of a [`ParameterPosterior`].
#[derive(Clone, Debug, PartialEq)]
pub struct PosteriorEntry {
    /// Name, such as `joint_offset.joint_a1`.
    pub name: String,
    /// Estimate (SI).
    pub value: f64,
    /// Standard deviation of the prior (SI), the estimated one of a variance component; `None` for
    /// a flat prior.
    pub prior_sigma: Option<f64>,
}

impl ParameterPosterior {
    /// The posterior of an estimate; `None` if it has no uncertainty, because contacts were
    /// measured by a projection.
    pub fn of_estimate(estimate: &Estimate) -> Option<ParameterPosterior> {
        let entries = estimate.parameters.iter().map(|entry| PosteriorEntry {
            name: entry.parameter.name.clone(),
            value: entry.value,
            prior_sigma: entry.parameter.prior_sigma(),
        });
        (!estimate.warnings.contains(&Warning::NoUncertainty)).then(|| ParameterPosterior {
            entries: entries.collect(),
            covariance: estimate.covariance.clone(),
            noise: Some(estimate.noise),
        })
    }

    /// Index of the parameter of this name.
    pub(crate) fn index(&self, name: &str) -> Option<usize> {
        self.entries.iter().position(|entry| entry.name == name)
    }

    /// Greatest prior standard deviation (SI) of the parameter of this name, or of a block of this
    /// name; 0 if there is none.
    pub(crate) fn greatest_prior_sigma(&self, name: &str) -> f64 {
        let is_of = |rest: &str| rest.is_empty() || rest.starts_with('.');
        let each = self.entries.iter().filter(|entry| entry.name.strip_prefix(name).is_some_and(is_of));
        each.filter_map(|entry| entry.prior_sigma).fold(0.0, f64::max)
    }
}

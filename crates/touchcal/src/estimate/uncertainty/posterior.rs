//! Uncertainty of every parameter at the minimum.

use nalgebra::{DMatrix, DVector};

use super::identifiability::{GaugeFix, identifiability};
use crate::estimate::model::{CalibrationModel, prior_information};
use crate::estimate::result::Identifiability;
use crate::parameter::ParameterId;
use crate::solver::FreeParameters;

/// Uncertainty of every parameter, and what the data contribute to it.
pub(crate) struct Posterior {
    /// Covariance (SI); rows and columns of fixed parameters are zero.
    pub covariance: DMatrix<f64>,
    /// Covariance (SI) if every parameter, free or fixed, had a prior of its scale: what the data
    /// leave of that.
    pub covariance_from_scales: DMatrix<f64>,
    /// Directions that the data determine, and those that they do not.
    pub identifiability: Identifiability,
    /// Whether the data determine each parameter, in order.
    pub identifiable: Vec<bool>,
    /// Whether anything, data or prior, bounds each parameter.
    bounded: Vec<bool>,
}

impl Posterior {
    /// The posterior from the information `data` (inverse SI units) of contacts and known
    /// distances, and the priors.
    pub fn new(model: &CalibrationModel<'_>, data: &DMatrix<f64>, free: &FreeParameters, fixed: &GaugeFix) -> Self {
        let parameters = &model.layout.parameters;
        let options = &model.problem.options.identifiability;
        // What measurements and parts are off by is no question to the data.
        let is_in_question = |id| {
            let of_wrench = matches!(id, ParameterId::WrenchBias(_) | ParameterId::WrenchScale);
            let of_log = matches!(id, ParameterId::JointTrend(_) | ParameterId::JointWalk(..));
            !(of_wrench || of_log || matches!(id, ParameterId::DirectionalGapBias(..)))
        };
        let without = |scale: DVector<f64>, is_kept: &dyn Fn(ParameterId) -> bool| {
            scale.map_with_location(|k, _, scale| if is_kept(parameters[k].id) { scale } else { 0.0 })
        };
        let scales = without(model.layout.scale(), &|id| !matches!(id, ParameterId::DirectionalGapBias(..)));
        let in_question = FreeParameters::new(without(scales.clone(), &is_in_question));
        let prior = DMatrix::from_diagonal(&scales.map(|sigma| sigma.powi(-2)));
        let all = FreeParameters::new(scales.clone());
        let covariance_from_scales = all.covariance(&(data + prior));
        let with_prior = parameters.iter().map(|parameter| parameter.prior_sigma().is_some());
        let bounded: Vec<bool> =
            with_prior.enumerate().map(|(k, prior)| prior || !fixed.participants.contains(&k)).collect();
        let is_reduced =
            |k: usize| covariance_from_scales[(k, k)].max(0.0).sqrt() < options.max_sigma_ratio * scales[k];
        Posterior {
            covariance: free.covariance(&(data + prior_information(model))),
            identifiability: identifiability(data, parameters, &in_question, options),
            identifiable: bounded.iter().enumerate().map(|(k, bounded)| *bounded && is_reduced(k)).collect(),
            covariance_from_scales,
            bounded,
        }
    }

    /// Standard deviation of parameter `k` (SI); `None` where neither data nor prior bound it.
    pub fn sigma(&self, k: usize) -> Option<f64> {
        self.bounded[k].then(|| self.covariance[(k, k)].max(0.0).sqrt())
    }
}

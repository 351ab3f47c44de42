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
    /// How far each parameter may be off (SI) with what is fixed at zero; `None` where neither data
    /// nor prior bound it.
    with_fixed: Vec<Option<f64>>,
}

impl Posterior {
    /// The posterior from the information `data` (inverse SI units) of contacts and known
    /// distances, and the priors.
    pub fn new(model: &CalibrationModel<'_>, data: &DMatrix<f64>, free: &FreeParameters, fixed: &GaugeFix) -> Self {
        let parameters = &model.layout.parameters;
        let options = &model.problem.options.identifiability;
        let without = |scale: DVector<f64>, is_kept: &dyn Fn(ParameterId) -> bool| {
            scale.map_with_location(|k, _, scale| if is_kept(parameters[k].id) { scale } else { 0.0 })
        };
        let scales = without(model.layout.scale(), &|id| !matches!(id, ParameterId::DirectionalGapBias(..)));
        let in_question = FreeParameters::new(without(scales.clone(), &Identifiability::counts));
        let prior = DMatrix::from_diagonal(&scales.map(|sigma| sigma.powi(-2)));
        let all = FreeParameters::new(scales.clone());
        let covariance_from_scales = all.covariance(&(data + prior));
        let with_fixed = |k: usize| {
            let share = match parameters[k].prior_sigma() {
                Some(_) => 0.0,
                None => fixed.share(k),
            };
            (share < options.max_sigma_ratio).then_some(share * scales[k])
        };
        let with_fixed: Vec<Option<f64>> = (0..parameters.len()).map(with_fixed).collect();
        let is_reduced =
            |k: usize| covariance_from_scales[(k, k)].max(0.0).sqrt() < options.max_sigma_ratio * scales[k];
        Posterior {
            covariance: free.covariance(&(data + prior_information(model))),
            identifiability: identifiability(data, parameters, &in_question, options),
            identifiable: (0..parameters.len()).map(|k| with_fixed[k].is_some() && is_reduced(k)).collect(),
            covariance_from_scales,
            with_fixed,
        }
    }

    /// Standard deviation of parameter `k` (SI); `None` where neither data nor prior bound it.
    pub fn sigma(&self, k: usize) -> Option<f64> {
        self.with_fixed[k].map(|share| self.covariance[(k, k)].max(0.0).sqrt().hypot(share))
    }
}

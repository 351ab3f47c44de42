//! Normalised estimation error squared (NEES) of an arm's parameters.

use nalgebra::{DMatrix, DVector};
use touchcal::estimate::Estimate;
use touchcal::sim::Truth;

/// `eᵀ P⁻¹ e` of the arm's parameters, and their number.
fn nees(estimate: &Estimate, truth: &Truth) -> (f64, usize) {
    let has_sigma = |k: &usize| {
        let entry = &estimate.parameters[*k];
        !entry.parameter.id.block().is_nuisance() && entry.sigma.is_some_and(|sigma| sigma > 0.0)
    };
    let arm: Vec<usize> = (0..estimate.parameters.len()).filter(has_sigma).collect();
    let error = |&k: &usize| estimate.parameters[k].value - truth.value(estimate.parameters[k].parameter.id);
    let error = DVector::from_iterator(arm.len(), arm.iter().map(error));
    let covariance = DMatrix::from_fn(arm.len(), arm.len(), |i, j| estimate.covariance[(arm[i], arm[j])]);
    (error.dot(&covariance.cholesky().expect("positive definite").solve(&error)), arm.len())
}

/// Sums of NEES and of parameters over trials.
#[derive(Default)]
pub struct NeesSum {
    nees: f64,
    parameters: usize,
}

impl NeesSum {
    pub fn add(&mut self, estimate: &Estimate, truth: &Truth) {
        let (nees, parameters) = nees(estimate, truth);
        self.nees += nees;
        self.parameters += parameters;
    }

    /// 1 where errors are as large as reported.
    pub fn per_parameter(&self) -> f64 {
        self.nees / self.parameters as f64
    }
}

//! Errors of the arm's parameters against the truth of a simulation.

use nalgebra::{DMatrix, DVector};

use crate::estimate::{Estimate, Problem};
use crate::parameter::{ParameterId, kinematic_part};
use crate::robot::{Robot, calibrated};
use crate::sim::Truth;

/// Errors of a problem's parameters of the arm that have a standard deviation above 0.
pub(super) struct ParameterErrors {
    /// Their indices in [`Estimate::parameters`].
    pub which: Vec<usize>,
    /// Estimate minus truth (SI), in the order of `which`.
    pub errors: DVector<f64>,
}

impl ParameterErrors {
    /// Those of `estimate`, which may have further parameters ([`Estimate::freed_effects`]): freed
    /// effects may stand for others, and have no truth.
    pub(super) fn new(problem: &Problem, estimate: &Estimate, truth: &Truth) -> ParameterErrors {
        let is_posed = |id: ParameterId| problem.parameters.iter().any(|parameter| parameter.id == id);
        let has_sigma = |k: &usize| {
            let parameter = &estimate.parameters[*k];
            let id = parameter.parameter.id;
            !id.block().is_nuisance() && is_posed(id) && parameter.sigma.is_some_and(|sigma| sigma > 0.0)
        };
        let which: Vec<usize> = (0..estimate.parameters.len()).filter(has_sigma).collect();
        let error = |k: usize| estimate.parameters[k].value - truth.value(estimate.parameters[k].parameter.id);
        let errors = DVector::from_iterator(which.len(), which.iter().map(|&k| error(k)));
        ParameterErrors { which, errors }
    }

    /// `eᵀ P⁻¹ e` (1) with the part of `covariance`, of all parameters, that these have; 0 without
    /// parameters. `None` if it is not positive definite.
    pub(super) fn nees(&self, covariance: &DMatrix<f64>) -> Option<f64> {
        let count = self.which.len();
        let part = DMatrix::from_fn(count, count, |i, j| covariance[(self.which[i], self.which[j])]);
        part.cholesky().map(|factor| self.errors.dot(&factor.solve(&self.errors)))
    }
}

/// `robot` with the errors of the arm that `truth` has; those of tool and fixtures are left out.
pub(crate) fn true_robot(robot: &Robot, truth: &Truth) -> Robot {
    let arm = truth.errors.iter().filter(|(id, _)| !id.block().is_nuisance());
    let (parameters, values) = kinematic_part(arm.copied());
    calibrated(robot, &parameters, &values)
}

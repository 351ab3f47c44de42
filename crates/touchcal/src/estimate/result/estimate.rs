//! The result of a calibration.

use nalgebra::{DMatrix, DVector};

use super::identifiability::Identifiability;
use super::score::Score;
use super::warning::Warning;
use crate::parameter::{Parameter, ParameterId};
use crate::robot::{KinematicParameter, Robot};
use crate::se3::{self, Pose, Twist};
use crate::solver::Termination;

/// What may be done with an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Use it.
    Converged,
    /// The minimization did not end: do not use it.
    NotConverged,
    /// It ended, but the data do not determine the arm or contradict what was declared: do not use
    /// it.
    NotUsable,
}

impl Status {
    /// Name in files: `converged`, `not_converged`, `not_usable`.
    pub fn name(self) -> &'static str {
        match self {
            Status::Converged => "converged",
            Status::NotConverged => "not_converged",
            Status::NotUsable => "not_usable",
        }
    }
}

/// What became of one contact in the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It was used with this weight.
    Used {
        /// Robust weight, 0 to 1.
        weight: f64,
    },
    /// It lay too far off the manifold to be used.
    Rejected {
        /// Mahalanobis distance from the manifold (standard deviations).
        deviations: f64,
    },
}

/// A parameter with its estimate.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterEstimate {
    /// Which parameter.
    pub parameter: Parameter,
    /// Its estimate (SI); zero, the nominal value, before an estimation.
    pub value: f64,
    /// Its standard deviation (SI); none where neither data nor prior bound it, or where contacts
    /// are measured by a projection.
    pub sigma: Option<f64>,
    /// Whether the data determine it.
    pub identifiable: bool,
}

/// Numbers of contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactCount {
    /// Rows read, in contact or not.
    pub read: u64,
    /// Contacts used.
    pub used: usize,
    /// Contacts rejected by the robust loss.
    pub rejected: usize,
}

/// The result of [`calibrate`](crate::estimate::calibrate).
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Whether it may be used.
    pub status: Status,
    /// Every parameter, in order.
    pub parameters: Vec<ParameterEstimate>,
    /// Covariance of the parameters (SI); rows and columns of fixed parameters are zero.
    pub covariance: DMatrix<f64>,
    /// What the data determine and what they do not.
    pub identifiability: Identifiability,
    /// Distances of the contacts from their manifolds with the calibrated arm;
    /// [`evaluate`](crate::estimate::evaluate) returns those with the nominal one.
    pub postfit: Score,
    /// Numbers of contacts.
    pub contacts: ContactCount,
    /// One for each contact, in the order of the log.
    pub verdicts: Vec<Verdict>,
    /// Why the minimization stopped.
    pub termination: Termination,
    /// Warnings, those that forbid the use of the result first.
    pub warnings: Vec<Warning>,
    /// Measured over declared standard deviation of the contacts (1).
    pub noise_factor: f64,
    /// The calibrated arm.
    pub robot: Robot,
}

impl Estimate {
    /// Parameter values (SI), in order.
    pub fn values(&self) -> DVector<f64> {
        DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(|p| p.value))
    }

    /// Estimated motion `Exp(ξ)` of the tool, to the right of its nominal `tip_from_tool`; none if
    /// it was not estimated.
    pub fn tool_motion(&self) -> Option<Pose> {
        let mut twist = Twist::zeros();
        let mut is_estimated = false;
        for entry in &self.parameters {
            if let ParameterId::Kinematic(KinematicParameter::Tool(k)) = entry.parameter.id {
                twist[k] = entry.value;
                is_estimated = true;
            }
        }
        is_estimated.then(|| se3::exp(&twist))
    }

    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&ParameterEstimate> {
        self.parameters.iter().find(|p| p.parameter.name == name)
    }
}

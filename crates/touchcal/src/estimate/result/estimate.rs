//! The result of a calibration.

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::acceptance::AcceptanceResult;
use super::competing_minimum::CompetingMinimum;
use super::effect_test::{EffectTest, FreedEffect};
use super::evaluation::Evaluation;
use super::identifiability::Identifiability;
use super::predictive_check::PredictiveCheck;
use super::prior_test::PriorTest;
use super::score::Score;
use super::status::Status;
use super::warning::Warning;
use super::workspace_uncertainty::WorkspaceUncertainty;
use crate::parameter::{Parameter, ParameterId};
use crate::robot::{EncoderTerm, KinematicParameter, Robot};
use crate::se3::{self, Pose, Twist};
use crate::solver::Termination;

/// Use of one contact in the fit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Verdict {
    /// The contact was used with this weight.
    Used {
        /// Robust weight ρ′ of its squared residual at the minimum (1), of a one-sided contact that
        /// of its least gap: at least the threshold
        /// [`rejected_weight`](crate::estimate::WarningThresholds::rejected_weight) and at most 1.
        weight: f64,
    },
    /// The contact lay too far off the manifold: the robust loss gave it a weight below the
    /// threshold [`rejected_weight`](crate::estimate::WarningThresholds::rejected_weight).
    Rejected {
        /// Mahalanobis distance of the contact from the manifold (1, standard deviations of its
        /// noise).
        deviations: f64,
    },
}

/// A parameter with its estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterEstimate {
    /// The parameter: name, unit and prior.
    pub parameter: Parameter,
    /// Estimate in the parameter's unit (SI); 0, the nominal value, where nothing was estimated yet
    /// or the parameter was fixed.
    pub value: f64,
    /// Standard deviation of the estimate in the parameter's unit (SI); `None` where neither data
    /// nor prior bound it, or where contacts are measured by a projection.
    pub sigma: Option<f64>,
    /// Whether the data determine the parameter: they leave its standard deviation below a share of
    /// its scale, see
    /// [`max_sigma_ratio`](crate::estimate::IdentifiabilityOptions::max_sigma_ratio).
    pub identifiable: bool,
}

/// Numbers of rows read, contacts used and contacts rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ContactCount {
    /// Rows read from the logs, in contact or not.
    pub read: u64,
    /// Contacts used in the fit; used and rejected contacts are all contacts.
    pub used: usize,
    /// Contacts rejected by the robust loss.
    pub rejected: usize,
}

/// Standard deviations of the measurement noise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseSigma {
    /// Of each revolute joint's measured position (rad).
    pub encoder: f64,
    /// Of each residual row apart from the encoders (m).
    pub contact: f64,
}

/// The result of [`calibrate`](crate::estimate::calibrate): parameters with covariance, the
/// calibrated arm, warnings and statistics.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Estimate {
    /// Whether the estimate may be used.
    pub status: Status,
    /// Every parameter with its estimate. Their order is that of the problem's parameters of the
    /// arm, then drifts (placement by placement), tool, fixtures and gap biases, the last two in
    /// the order of [`Problem::fixtures`](crate::estimate::Problem::fixtures); indices of
    /// parameters everywhere are into this list.
    pub parameters: Vec<ParameterEstimate>,
    /// Covariance of the estimates, square, rows and columns in the order of `parameters`; entry
    /// (i, j) in the product of the units of parameters i and j (SI). Rows and columns of fixed
    /// parameters are zero. Without meaning where contacts are measured by a projection.
    pub covariance: DMatrix<f64>,
    /// How well the calibrated arm's tool is known; `None` where contacts are measured by a
    /// projection.
    pub workspace_uncertainty: Option<WorkspaceUncertainty>,
    /// Directions in parameter space that the data determine, and those that they do not.
    pub identifiability: Identifiability,
    /// Distances (m) of the contacts from their manifolds with the calibrated arm, and tool and
    /// fixtures at their estimated poses, see
    /// [`contact_distances`](crate::estimate::contact_distances);
    /// [`evaluate`](crate::estimate::evaluate()) returns those with the nominal ones.
    pub postfit: Score,
    /// Numbers of rows read, and of contacts used and rejected.
    pub contacts: ContactCount,
    /// Use of each contact, in the order of the log; as many as contacts.
    pub verdicts: Vec<Verdict>,
    /// Why, where and after how many iterations the minimization stopped.
    pub termination: Termination,
    /// Tests of effects that the model leaves out, the most significant first; empty where the
    /// search did not converge, or contacts have no likelihood.
    pub effect_tests: Vec<EffectTest>,
    /// Tests of what is declared with a standard deviation, the least p-value first; empty where
    /// the search did not converge, or contacts are measured by a projection.
    pub prior_tests: Vec<PriorTest>,
    /// Names of effects ([`OmittedEffect::name`](crate::estimate::OmittedEffect::name)) and of
    /// declarations ([`Declaration::name`](crate::estimate::Declaration::name)) that contacts
    /// cannot test: they would not show a plausible size of the effect, or determine no direction
    /// of what is declared better than that; and `friction`, of which there is none in the model,
    /// where one-sided contacts have no known load. Empty where the search did not converge, and
    /// after a gradient descent, of which nothing is tested.
    pub untested: Vec<String>,
    /// Effects that were estimated in addition to the problem's parameters, in the order in which
    /// they were tried; empty but for
    /// [`calibrate_with_freed_effects`](crate::estimate::calibrate_with_freed_effects).
    pub freed_effects: Vec<FreedEffect>,
    /// How far stretches of the log are from what the others predict; `None` where contacts are too
    /// few for two stretches, of sampled manifolds, or the search has not converged.
    pub predictive_check: Option<PredictiveCheck>,
    /// The result on contacts that were held out; `None` if
    /// [`Problem::held_out`](crate::estimate::Problem::held_out) is empty, or contacts are measured
    /// by a projection.
    pub held_out: Option<Evaluation>,
    /// Minima that contacts do not rule out, the one with the least cost first; empty where the
    /// minimum is the only one, as far as searches from other starts tell.
    pub competing_minima: Vec<CompetingMinimum>,
    /// Whether the calibration reaches what
    /// [`Problem::acceptance`](crate::estimate::Problem::acceptance) asks of it; `None` if nothing
    /// is asked.
    pub acceptance: Option<AcceptanceResult>,
    /// Warnings, those that forbid the use of the result first.
    pub warnings: Vec<Warning>,
    /// Measured standard deviation of the contacts' residuals over the declared one, or over the
    /// estimated one if [`Noise::is_estimated`](crate::estimate::Noise::is_estimated) (1): about 1
    /// where the noise is right.
    pub noise_factor: f64,
    /// The noise of the contacts: as declared, or as estimated if
    /// [`Noise::is_estimated`](crate::estimate::Noise::is_estimated).
    pub noise: NoiseSigma,
    /// The calibrated arm: strains, encoder offsets and origin twists are in its joint origins,
    /// compliances in its joints; neither the tool's pose nor the drifts of placements are part of
    /// it.
    pub robot: Robot,
}

impl Estimate {
    /// Parameter values (SI), in the order of [`Estimate::parameters`] and as many.
    pub fn values(&self) -> DVector<f64> {
        DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(|p| p.value))
    }

    /// Estimated motion `Exp(ξ)` (m) of the tool in its own frame, to the right of its nominal
    /// pose: the estimated pose is `tip_from_tool · Exp(ξ)`; components of `ξ` that were not
    /// estimated are 0. `None` if none was.
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

    /// Estimated errors of the encoders that depend on the measured position: index of the moving
    /// joint, base first, term, and amplitude (SI), in the order of [`Estimate::parameters`].
    pub fn encoder_errors(&self) -> impl Iterator<Item = (usize, EncoderTerm, f64)> {
        self.parameters.iter().filter_map(|entry| match entry.parameter.id {
            ParameterId::EncoderError(joint, term) => Some((joint, term, entry.value)),
            _ => None,
        })
    }

    /// Kinds ([`Warning::kind`]) of the warnings, each once, those that forbid the use of the
    /// result first.
    pub fn warning_kinds(&self) -> Vec<String> {
        let mut kinds: Vec<String> = Vec::new();
        for kind in self.warnings.iter().map(Warning::kind) {
            if kinds.iter().all(|known| known != kind) {
                kinds.push(kind.to_owned());
            }
        }
        kinds
    }

    /// Whether what the data determine was found at a minimum, where it says something of the data:
    /// not after a gradient descent that failed ([`Warning::DescentFailed`]).
    pub fn has_identifiability(&self) -> bool {
        !self.warnings.iter().any(|warning| matches!(warning, Warning::DescentFailed(_)))
    }

    /// Warnings by which the model is incomplete: contacts scatter more than the noise, deviate
    /// from predictions, or show an effect that the model lacks, beyond the significance levels of
    /// [`WarningThresholds`](crate::estimate::WarningThresholds). Empty without such warnings.
    pub fn incompleteness(&self) -> Vec<&Warning> {
        let says_so = |warning: &&Warning| {
            matches!(
                warning,
                Warning::NoiseExceeded { .. }
                    | Warning::NoiseContradicted { .. }
                    | Warning::PredictionContradicted { .. }
                    | Warning::OmittedEffect { .. }
            )
        };
        self.warnings.iter().filter(says_so).collect()
    }

    /// The parameter of this exact name, such as `joint_offset.joint_a1`; `None` if there is none.
    pub fn parameter(&self, name: &str) -> Option<&ParameterEstimate> {
        self.parameters.iter().find(|p| p.parameter.name == name)
    }
}

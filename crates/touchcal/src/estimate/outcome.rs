//! What an estimation ends with: values, never log text.

use nalgebra::{DMatrix, DVector};

use super::identifiability::Identifiability;
use super::score::Score;
use crate::robot::{Column, Parameter, Robot};
use crate::se3::{self, Pose, Twist};

/// A stage of the estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Towards the manifolds' envelopes, from afar.
    Coarse,
    /// Onto the manifolds.
    Fine,
    /// Gradient descent.
    Descent,
}

/// Where a running estimation stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Current stage.
    pub stage: Stage,
    /// Linearizations so far in this stage.
    pub iteration: usize,
    /// Current cost.
    pub cost: f64,
}

/// Why a minimisation stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The Newton decrement, or what gradient descent could still gain, is below its threshold.
    Converged,
    /// The iteration limit came first.
    IterationLimit,
    /// No step, however short, lowered the cost.
    NoDescent,
    /// The cost became NaN or infinite.
    NotFinite,
    /// The caller asked to stop.
    Interrupted,
}

impl StopReason {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            StopReason::Converged => "converged",
            StopReason::IterationLimit => "iteration_limit",
            StopReason::NoDescent => "no_descent",
            StopReason::NotFinite => "not_finite",
            StopReason::Interrupted => "interrupted",
        }
    }
}

/// Why and where a minimisation stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Termination {
    /// Why.
    pub reason: StopReason,
    /// Newton decrement of the last step; of gradient descent, the share of the loss that a further step would take off.
    pub measured: f64,
    /// What it had to fall below.
    pub threshold: f64,
    /// Linearizations of both stages, or steps of gradient descent.
    pub iterations: usize,
}

/// What may be done with an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Use it.
    Converged,
    /// The minimisation did not end: do not use it.
    NotConverged,
    /// It ended, but the data do not determine the arm or contradict what was declared: do not use it.
    NotUsable,
}

impl Status {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Status::Converged => "converged",
            Status::NotConverged => "not_converged",
            Status::NotUsable => "not_usable",
        }
    }
}

/// What became of one contact in the fine stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// It counted with this weight, 0 to 1.
    Used {
        /// Robust weight.
        weight: f64,
    },
    /// It lay too far off the manifold to count.
    Rejected {
        /// Distance from the manifold in standard deviations.
        deviations: f64,
    },
}

/// Share of contacts from which rejecting them forbids the result: then most say otherwise.
const MOST_REJECTED: f64 = 0.5;
/// Errors over standard deviations where the least gap is taken, as simulated pegs at the rim and in holes with little play have them.
pub(super) const LEAST_GAP_ERROR: f64 = 3.0;

/// Something a user should know, with advice.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Fewer measured rows than parameters without a prior.
    TooFewContacts {
        /// Rows.
        rows: usize,
        /// Parameters.
        parameters: usize,
    },
    /// A fixture without contacts.
    Untouched {
        /// Its name.
        fixture: String,
    },
    /// The tool's frame is outside of the tool's outline, as where a drawing has its origin in a corner of the sheet.
    ToolAside {
        /// Middle of the outline in that frame (m).
        middle: [f64; 2],
    },
    /// Even the nominal arm's contacts have two sockets at another distance than is declared.
    DistanceContradicted {
        /// Names of the fixtures.
        between: [String; 2],
        /// Distance declared (m).
        declared: f64,
        /// Distance by the nominal arm (m).
        measured: f64,
    },
    /// Parameters that the data cannot determine were held at zero.
    Held {
        /// Their names.
        names: Vec<String>,
    },
    /// Even together with their priors the data leave the arm's geometry about as uncertain as it was.
    ArmUndetermined {
        /// Uncertainty left of distances between tool positions, as a share of the uncertainty before.
        left: f64,
    },
    /// Contacts scatter more than the declared noise explains, or where none is declared the noise assumed; the uncertainties are widened accordingly.
    NoiseExceeded {
        /// Measured over declared or assumed standard deviation.
        factor: f64,
        /// Whether the noise was declared.
        declared: bool,
    },
    /// Contacts of one-sided gaps scatter so much more than declared that it is no noise.
    NoiseContradicted {
        /// Measured over declared standard deviation.
        factor: f64,
    },
    /// Contacts that follow each other err alike; the uncertainties are widened accordingly.
    ErrAlike {
        /// As many say as much as one would if each erred on its own.
        contacts: f64,
        /// Whether the result may be used.
        usable: bool,
    },
    /// Contacts float or penetrate on average, further than parts that touch do.
    NotTouching {
        /// Name of the interference.
        name: String,
        /// Mean gap at contact (m), negative if they penetrate.
        gap: f64,
    },
    /// Few contacts of one-sided gaps tell which walls they touch; all were taken to touch the nearest, which errs to one side by more than the uncertainties say.
    FewTellWalls {
        /// Share of these contacts that do, 0 to 1.
        share: f64,
    },
    /// Searches from other starts ended elsewhere and fit about as well.
    Ambiguous,
    /// Many contacts do not lie on their manifold.
    ManyRejected {
        /// Share of contacts, 0 to 1.
        share: f64,
    },
    /// A joint hardly moved, so errors on both sides of it look alike.
    JointHardlyMoved {
        /// Name of the joint.
        joint: String,
        /// Range of its positions (rad or m).
        range: f64,
    },
    /// A parameter of the arm ended beyond anything that a calibration corrects.
    Implausible {
        /// Name of the parameter.
        name: String,
        /// Its value (SI).
        value: f64,
    },
    /// Contacts were measured by their distance from a projection, from which no uncertainty follows.
    NoUncertainty,
    /// A parameter ended far outside its prior.
    FarFromPrior {
        /// Name of the parameter.
        name: String,
        /// Distance in prior standard deviations.
        deviations: f64,
    },
}

impl Warning {
    /// Whether a result with it must not be used.
    pub fn forbids(&self) -> bool {
        match self {
            Warning::TooFewContacts { .. }
            | Warning::ArmUndetermined { .. }
            | Warning::DistanceContradicted { .. }
            | Warning::Implausible { .. }
            | Warning::NoiseContradicted { .. }
            | Warning::NotTouching { .. }
            | Warning::Ambiguous => true,
            Warning::ErrAlike { usable, .. } => !usable,
            Warning::ManyRejected { share } => *share > MOST_REJECTED,
            _ => false,
        }
    }

    /// Name in files.
    pub fn kind(&self) -> &'static str {
        match self {
            Warning::TooFewContacts { .. } => "too_few_contacts",
            Warning::Untouched { .. } => "untouched",
            Warning::ToolAside { .. } => "tool_aside",
            Warning::DistanceContradicted { .. } => "distance_contradicted",
            Warning::Held { .. } => "held",
            Warning::ArmUndetermined { .. } => "arm_undetermined",
            Warning::NoiseExceeded { .. } => "noise_exceeded",
            Warning::NoiseContradicted { .. } => "noise_contradicted",
            Warning::ErrAlike { .. } => "err_alike",
            Warning::NotTouching { .. } => "not_touching",
            Warning::FewTellWalls { .. } => "few_tell_walls",
            Warning::Ambiguous => "ambiguous",
            Warning::ManyRejected { .. } => "many_rejected",
            Warning::JointHardlyMoved { .. } => "joint_hardly_moved",
            Warning::Implausible { .. } => "implausible",
            Warning::NoUncertainty => "no_uncertainty",
            Warning::FarFromPrior { .. } => "far_from_prior",
        }
    }

    /// What is the matter.
    pub fn words(&self) -> String {
        match self {
            Warning::TooFewContacts { rows, parameters } => {
                format!("{rows} measured rows cannot determine {parameters} parameters")
            }
            Warning::Untouched { fixture } => format!("fixture `{fixture}` has no contacts"),
            Warning::ToolAside { middle: [x, y] } => format!(
                "the tool's outline does not enclose its origin, where `tip_from_tool` has the tool's frame: its middle is at x {:.1} mm, y {:.1} mm",
                1e3 * x,
                1e3 * y
            ),
            Warning::DistanceContradicted { between: [a, b], declared, measured } => {
                let [declared, measured] = [declared, measured].map(|metres| 1e3 * metres);
                format!(
                    "`{a}` and `{b}` are declared {declared} mm apart, but the nominal arm has them {measured:.1} mm apart: \
                     do not use the result"
                )
            }
            Warning::Held { names } => {
                format!("held at zero because the data cannot determine them: {}", names.join(", "))
            }
            Warning::ArmUndetermined { left } => {
                format!("these contacts leave {:.0} % of the arm's uncertainty: do not use the result", 100.0 * left)
            }
            Warning::NoiseExceeded { factor, declared } => {
                let noise = if *declared { "[noise] declares" } else { "is assumed where there is no [noise]" };
                format!(
                    "contacts scatter {factor:.1} times more than {noise}; uncertainties were widened by that factor"
                )
            }
            Warning::NoiseContradicted { factor } => {
                format!("contacts scatter {factor:.1} times more than [noise] declares: do not use the result")
            }
            Warning::ErrAlike { contacts, usable } => {
                let then = if *usable { "uncertainties were widened for that" } else { "do not use the result" };
                format!("contacts err alike, {contacts:.0} of them say as much as one: {then}")
            }
            Warning::NotTouching { name, gap } => {
                let how = if *gap > 0.0 { "float" } else { "penetrate" };
                format!("`{name}`: contacts {how} by {:.2} mm on average: do not use the result", 1e3 * gap.abs())
            }
            Warning::FewTellWalls { share } => format!(
                "only {:.0} % of the one-sided contacts tell which walls they touch; the nearest is taken, and uncertainties were widened {LEAST_GAP_ERROR} times for that",
                100.0 * share
            ),
            Warning::Ambiguous => {
                "other parameters, found from other starts, fit these contacts about as well: do not use the result"
                    .to_owned()
            }
            Warning::ManyRejected { share } => {
                let forbidden = if self.forbids() { ": do not use the result" } else { "" };
                format!("{:.0} % of the contacts do not fit and were rejected{forbidden}", 100.0 * share)
            }
            Warning::JointHardlyMoved { joint, range } => {
                format!("joint `{joint}` moved only {:.2}° in all contacts", range.to_degrees())
            }
            Warning::Implausible { name, value } => {
                format!("`{name}` ended at {value:.3}, which is no calibration: do not use the result")
            }
            Warning::NoUncertainty => {
                "a projection also counts motion along the manifold, so no uncertainty follows from it".to_owned()
            }
            Warning::FarFromPrior { name, deviations } => {
                format!("`{name}` ended {deviations:.1} prior standard deviations from zero")
            }
        }
    }

    /// What to do about it.
    pub fn advice(&self) -> &'static str {
        match self {
            Warning::TooFewContacts { .. } => "record more contacts, or estimate fewer parameters",
            Warning::Untouched { .. } => "check the force threshold, and the logs that name it as their fixture",
            Warning::ToolAside { .. } => {
                "draw the outlines about the origin; if the tool's frame is meant to be there, nothing is wrong"
            }
            Warning::DistanceContradicted { .. } => "check the unit of `mm`, and which log belongs to which fixture",
            Warning::Held { .. } => "touch more fixtures or from other elbow positions, or give a prior",
            Warning::ArmUndetermined { .. } => {
                "touch more places, other kinds of fixtures, or fixtures whose place or spacing is known"
            }
            Warning::NoiseExceeded { .. } => {
                "check the noise values, the parts' shapes, and whether more parameters should be free"
            }
            Warning::NoiseContradicted { .. } => {
                "declare the noise as large as it is; else check the parts' shapes, and where the search starts"
            }
            Warning::ErrAlike { .. } => {
                "something is not in the model: the tool's length or place (`tip_from_tool`, or its `sigma_mm`), the parts' shapes, or joints that give way (`joint_compliance`, and `load_on` for the force)"
            }
            Warning::NotTouching { .. } => {
                "check the parts' shapes; or the search ended in a wrong minimum: give the fixture's place as well as it is known"
            }
            Warning::FewTellWalls { .. } => "record longer with the tool inside of the hole, not at its rim",
            Warning::Ambiguous => "record longer, with more motion of the tool and the elbow, or give priors",
            Warning::ManyRejected { .. } => {
                "check the force threshold, the parts' shapes, and the places of the tool and the fixtures"
            }
            Warning::JointHardlyMoved { .. } => "move it more to tell its errors from its neighbours'",
            Warning::Implausible { .. } => "check units, the robot, and where the fixtures are",
            Warning::NoUncertainty => "use the parts' exact shapes for error bars",
            Warning::FarFromPrior { name, .. } if name.starts_with("tool.") => {
                "check tip_from_tool and its unit, or give a larger sigma_mm in [tool]"
            }
            Warning::FarFromPrior { name, .. } if name.starts_with("fixture.") => {
                "check base_from_fixture and its unit, or give a larger sigma_mm in [[fixture]]"
            }
            Warning::FarFromPrior { .. } => "check the nominal model or widen its prior",
        }
    }
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}; {}", self.words(), self.advice())
    }
}

/// An estimated parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimated {
    /// Which parameter.
    pub parameter: Parameter,
    /// Its estimate (SI).
    pub value: f64,
    /// Its standard deviation; none where neither data nor prior bound it, or contacts were measured by a projection.
    pub sigma: Option<f64>,
    /// Whether the data determine it.
    pub identifiable: bool,
}

/// Contacts in and out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactCount {
    /// Rows read, in contact or not.
    pub read: u64,
    /// Contacts that counted.
    pub used: usize,
    /// Contacts rejected by the robust loss.
    pub rejected: usize,
}

/// The result of [`calibrate`](super::calibrate).
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Whether it may be used.
    pub status: Status,
    /// Every parameter, in order.
    pub parameters: Vec<Estimated>,
    /// Covariance of the parameters (SI); rows and columns of held parameters are zero.
    pub covariance: DMatrix<f64>,
    /// What the data determine and what they do not.
    pub identifiability: Identifiability,
    /// Distances from touching with the calibrated arm; [`evaluate`](super::evaluate) gives those with the nominal one.
    pub postfit: Score,
    /// How many contacts counted.
    pub contacts: ContactCount,
    /// One for each contact.
    pub verdicts: Vec<Verdict>,
    /// Why the minimisation stopped.
    pub termination: Termination,
    /// What a user should know.
    pub warnings: Vec<Warning>,
    /// Measured over declared standard deviation of the contacts.
    pub noise_factor: f64,
    /// The calibrated arm.
    pub robot: Robot,
}

impl Estimate {
    /// Parameter values (SI), in order.
    pub fn values(&self) -> DVector<f64> {
        DVector::from_iterator(self.parameters.len(), self.parameters.iter().map(|p| p.value))
    }

    /// The estimated motion `Exp(ξ)` of the tool on the tip, on the right of its nominal place; none if it was not estimated.
    pub fn tool_motion(&self) -> Option<Pose> {
        let mut twist = Twist::zeros();
        let mut estimated = false;
        for entry in &self.parameters {
            if let Column::Tool(k) = entry.parameter.column {
                twist[k] = entry.value;
                estimated = true;
            }
        }
        estimated.then(|| se3::exp(&twist))
    }

    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&Estimated> {
        self.parameters.iter().find(|p| p.parameter.name == name)
    }
}

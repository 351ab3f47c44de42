//! What is to be solved: an arm, what touches, what is touched, the contacts, and what may be
//! wrong.

use std::sync::Arc;

use super::options::EstimatorOptions;
use crate::contact::ContactLog;
use crate::manifold::{ContactManifold, ResidualKind};
use crate::parameter::Parameter;
use crate::robot::Robot;
use crate::se3::Pose;
use crate::solver::Loss;

/// Start of encoder noise that is estimated (rad): 0.005°, an industrial encoder.
pub const DEFAULT_ENCODER: f64 = 0.005 * std::f64::consts::PI / 180.0;
/// Start of contact noise that is estimated (m): 0.05 mm, machined parts.
pub const DEFAULT_CONTACT: f64 = 0.05e-3;

/// Prior of a pose about its nominal value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlacePrior {
    /// Known exactly: not estimated.
    Fixed,
    /// Gaussian, the components of the local twist independent of each other.
    Gaussian {
        /// Standard deviation of each translation component (m).
        sigma: f64,
        /// Standard deviation of each rotation component (rad).
        sigma_angle: f64,
    },
    /// None: the contacts alone decide.
    Flat,
}

/// The tool: the part on the arm that touches, and its pose on the tip link.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Nominal pose of the tool frame in the tip link's frame.
    pub tip_from_tool: Pose,
    /// Prior of that pose.
    pub prior: PlacePrior,
}

/// A fixture: the part that is touched, a contact manifold at a pose in base.
#[derive(Clone, Debug)]
pub struct Fixture {
    /// Unique name.
    pub name: String,
    /// How the tool touches it.
    pub manifold: Arc<dyn ContactManifold>,
    /// Nominal pose in base. None: the mean tool position of its contacts by the nominal arm.
    pub base_from_fixture: Option<Pose>,
    /// Prior of that pose.
    pub prior: PlacePrior,
    /// Fixtures of one placement share this name: they were touched in one go, with the same drift
    /// of the joints.
    pub placement: String,
}

/// A known distance between the origins of two fixtures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Indices of the two fixtures.
    pub between: (usize, usize),
    /// Distance (m).
    pub distance: f64,
    /// Its standard deviation (m).
    pub sigma: f64,
}

/// Measurement noise, independent from contact to contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of each revolute joint's measurement (rad); prismatic joints have none.
    pub encoder: f64,
    /// Standard deviation of each residual row apart from the encoders (m): deflection, form errors
    /// of the parts, contact detection.
    pub contact: f64,
    /// Whether these are a start only, and a factor common to both is estimated from the contacts.
    pub is_estimated: bool,
}

/// How the cost is minimized.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// Coarse-to-fine Levenberg–Marquardt with a marginal likelihood for one-sided contacts.
    #[default]
    LevenbergMarquardt,
    /// Gradient descent on mean absolute distances, for comparison (Negi, Manyar & Gupta 2025).
    GradientDescent(GradientDescent),
}

/// Steps of gradient descent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientDescent {
    /// Rule of the steps.
    pub optimizer: Optimizer,
    /// Number of steps.
    pub steps: usize,
    /// Length of the first step, in plausible sizes of the parameters.
    pub rate: f64,
    /// Maximum number of contacts used, about evenly spread over the log.
    pub contacts: usize,
}

impl Default for GradientDescent {
    /// Adam, 5000 steps, the first of 5 % of a plausible size, on 500 contacts.
    fn default() -> Self {
        GradientDescent { optimizer: Optimizer::Adam, steps: 5000, rate: 0.05, contacts: 500 }
    }
}

/// Rule of gradient descent's steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Optimizer {
    /// Against the gradient, divided by the length of the first gradient.
    Plain,
    /// Adam (Kingma & Ba 2015, algorithm 1).
    Adam,
}

/// A calibration problem. [`Problem::new`] has the defaults of everything that is optional.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The arm.
    pub robot: Robot,
    /// What touches.
    pub tool: Tool,
    /// What is touched; the contacts name fixtures by their index here.
    pub fixtures: Vec<Fixture>,
    /// Known distances between fixtures.
    pub distances: Vec<Distance>,
    /// The contacts.
    pub contacts: ContactLog,
    /// Measurement noise.
    pub noise: Noise,
    /// Parameters of the arm to estimate; those of tool and fixtures follow from their
    /// [`PlacePrior`].
    pub parameters: Vec<Parameter>,
    /// Whether each placement has encoder offsets of its own (`joint_drift`); takes effect with two
    /// placements or more.
    pub joint_drift: bool,
    /// How the cost is minimized.
    pub method: Method,
    /// Robust loss of the residuals; gradient descent has its own.
    pub loss: Loss,
    /// Tuning of the estimator.
    pub options: EstimatorOptions,
}

impl Problem {
    /// A problem without distances and without parameters of the arm, with noise that is estimated
    /// from the contacts (starting at 0.005° and 0.05 mm), a Geman–McClure loss of scale 3 and
    /// default options.
    pub fn new(robot: Robot, tool: Tool, fixtures: Vec<Fixture>, contacts: ContactLog) -> Self {
        Problem {
            robot,
            tool,
            fixtures,
            distances: Vec::new(),
            contacts,
            noise: Noise { encoder: DEFAULT_ENCODER, contact: DEFAULT_CONTACT, is_estimated: true },
            parameters: Vec::new(),
            joint_drift: false,
            method: Method::LevenbergMarquardt,
            loss: Loss::GemanMcClure(3.0),
            options: EstimatorOptions::default(),
        }
    }

    /// The same problem with these parameters of the arm.
    pub fn with_parameters(self, parameters: Vec<Parameter>) -> Self {
        Problem { parameters, ..self }
    }

    /// The same problem with this noise.
    pub fn with_noise(self, noise: Noise) -> Self {
        Problem { noise, ..self }
    }

    /// Whether the tool frame is the tip link's, whose pose the calibrated chain can carry: its
    /// last joint is fixed.
    pub fn tool_is_tip(&self) -> bool {
        self.tool.tip_from_tool == Pose::identity() && self.robot.with_tip_moved(&Pose::identity()).is_some()
    }

    /// Whether any contact is measured by the distance from a projection, from which no uncertainty
    /// follows.
    pub(crate) fn has_projection(&self) -> bool {
        self.fixtures.iter().any(|fixture| fixture.manifold.residual_kind() == ResidualKind::ProjectionError)
    }
}

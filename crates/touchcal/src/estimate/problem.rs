//! What is to be solved: an arm, what touches, what is touched, the contacts, and what may be wrong.

use std::sync::Arc;

use super::gradient_descent::Descent;
use super::loss::Loss;
use crate::contact::ContactLog;
use crate::manifold::ContactManifold;
use crate::robot::{Parameter, Robot};
use crate::se3::Pose;

/// How well a place is known beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Freedom {
    /// Exactly.
    Known,
    /// Up to a Gaussian error of these standard deviations (m, rad); it is estimated with that prior.
    Uncertain {
        /// Of each translation component (m).
        sigma: f64,
        /// Of each rotation component (rad).
        sigma_angle: f64,
    },
    /// Not at all: the contacts alone decide.
    Free,
}

/// What touches: its place on the arm's tip.
#[derive(Clone, Debug, PartialEq)]
pub struct Tool {
    /// Nominal pose of the tool frame on the tip link.
    pub tip_from_tool: Pose,
    /// How well that is known.
    pub freedom: Freedom,
}

/// What is touched: a contact manifold at a place in base.
#[derive(Clone, Debug)]
pub struct Fixture {
    /// Unique name.
    pub name: String,
    /// How the tool touches it.
    pub manifold: Arc<dyn ContactManifold>,
    /// Nominal pose in base. Without one, the fixture starts where the nominal arm puts the mean of its contacts.
    pub base_from_fixture: Option<Pose>,
    /// How well that is known.
    pub freedom: Freedom,
    /// Fixtures that were touched in one go, with the same drifts of the joints, share this name.
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

/// Measurement noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of each revolute joint's measurement (rad).
    pub encoder: f64,
    /// Standard deviation of what the contact itself adds (m): deflection, form errors, detection.
    pub contact: f64,
    /// Whether these are only a start, and one factor common to both is learned from the data.
    pub learned: bool,
}

/// How the parameters are searched for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Method {
    /// Coarse and fine Levenberg–Marquardt: the method of choice.
    #[default]
    LevenbergMarquardt,
    /// Gradient descent on mean absolute distances, to compare with.
    GradientDescent(Descent),
}

/// A calibration problem.
#[derive(Clone, Debug)]
pub struct Problem {
    /// The arm.
    pub robot: Robot,
    /// What touches.
    pub tool: Tool,
    /// What is touched.
    pub fixtures: Vec<Fixture>,
    /// Known distances between fixtures.
    pub distances: Vec<Distance>,
    /// The contacts.
    pub contacts: ContactLog,
    /// Measurement noise.
    pub noise: Noise,
    /// Parameters of the arm to estimate; those of tool and fixtures follow from their [`Freedom`].
    pub parameters: Vec<Parameter>,
    /// Whether the joints' zeros may differ a little from placement to placement; takes effect with two placements or more.
    pub joint_drift: bool,
    /// How they are searched for.
    pub method: Method,
    /// Loss of the fine stage; gradient descent has its own.
    pub loss: Loss,
}

//! What is to be solved: an arm, what touches, what is touched, the contacts, and what may be
//! wrong.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::options::{EstimatorOptions, Method, UnseenEffects};
use super::result::{Acceptance, ErrorFrame};
use crate::contact::ContactLog;
use crate::manifold::{ContactManifold, ResidualKind, manifold_data};
use crate::parameter::Parameter;
use crate::robot::Robot;
use crate::se3::Pose;
use crate::solver::Loss;

/// Initial standard deviation (rad) of the encoders where noise is estimated: 0.005°, an industrial
/// encoder.
pub const DEFAULT_ENCODER: f64 = 0.005 * std::f64::consts::PI / 180.0;
/// Initial standard deviation (m) of contacts where noise is estimated: 0.05 mm, machined parts.
pub const DEFAULT_CONTACT: f64 = 0.05e-3;

/// Standard deviation (m) of a declared distance of fixtures where none is given: what a workshop
/// reaches.
pub const DEFAULT_DISTANCE_SIGMA: f64 = 0.1e-3;
/// Standard deviation (m) of a distance that is declared exact: a micrometre, the weight that it
/// needs in the cost.
pub const EXACT_DISTANCE_SIGMA: f64 = 1e-6;

/// Plausible amplitude (rad) of the sine and of the cosine of an encoder's harmonic of once a turn:
/// 0.01°, what an encoder that is not quite centred makes.
pub const PLAUSIBLE_HARMONIC: f64 = 0.01 * std::f64::consts::PI / 180.0;

/// Prior of a pose about its nominal value: of the local twist `ξ = [v; ω]` (m, rad) in `nominal ·
/// Exp(ξ)`. Whatever the prior, only components that change a contact are estimated:
/// [`ContactManifold::fixture_directions`] and [`ContactManifold::tool_directions`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum PlacePrior {
    /// Known exactly: not estimated.
    Fixed,
    /// Gaussian with mean zero, the components of the local twist independent of each other.
    /// Components of standard deviation 0 are not estimated.
    Gaussian {
        /// Standard deviation of each translation component (m, ≥ 0).
        sigma: f64,
        /// Standard deviation of each rotation component (rad, ≥ 0).
        sigma_angle: f64,
    },
    /// No prior: contacts and known distances alone determine the pose.
    Flat,
}

impl PlacePrior {
    /// Default prior of a fixture's pose, what a workshop reaches: 1 mm and 0.5°.
    pub const DEFAULT_FIXTURE: PlacePrior =
        PlacePrior::Gaussian { sigma: 1e-3, sigma_angle: 0.5 * std::f64::consts::PI / 180.0 };
    /// Default prior of the tool's pose on the tip link: 0.3 mm and 0.2°.
    pub const DEFAULT_TOOL: PlacePrior =
        PlacePrior::Gaussian { sigma: 0.3e-3, sigma_angle: 0.2 * std::f64::consts::PI / 180.0 };
}

/// Standard deviations (m) of the shapes of tool and fixture together; 0 is exact.
///
/// They widen the covariance of one-sided contacts by what an error of that size would move the
/// estimates; the shapes themselves are not estimated. Gap biases are, whatever the tolerance.
/// Other fixtures have none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShapeTolerance {
    /// Standard deviation (m, ≥ 0) of the clearance on each side: contacts whose normal is nearest
    /// to ±x or ±y of the fixture.
    pub clearance: f64,
    /// Standard deviation (m, ≥ 0) of the depth: contacts whose normal is nearest to ±z of the
    /// fixture.
    pub depth: f64,
    /// Standard deviation (m, ≥ 0) of the radius of all edges of tool and fixture beyond that of
    /// their shapes.
    pub edge_radius: f64,
}

impl ShapeTolerance {
    /// Exact shapes.
    pub const EXACT: ShapeTolerance = ShapeTolerance { clearance: 0.0, depth: 0.0, edge_radius: 0.0 };
    /// Default tolerance, what a workshop reaches: 0.03 mm of the clearance on each side and of the
    /// depth, 0.05 mm of the radius of edges.
    pub const DEFAULT: ShapeTolerance = ShapeTolerance { clearance: 0.03e-3, depth: 0.03e-3, edge_radius: 0.05e-3 };

    /// Standard deviation (m) of gaps at contact in axis direction `k`: 0 to 5 for +x, −x, +y, −y,
    /// +z, −z.
    pub(crate) fn towards(&self, k: usize) -> f64 {
        if k < 4 { self.clearance } else { self.depth }
    }

    /// This tolerance, with exact edges where a shape [has none](ContactManifold::has_edges).
    pub fn of(self, manifold: &dyn ContactManifold) -> ShapeTolerance {
        let edge_radius = if manifold.has_edges() { self.edge_radius } else { 0.0 };
        ShapeTolerance { edge_radius, ..self }
    }
}

/// Standard deviations of the errors of the measured wrench, where it is used as a load; 0 is
/// exact: measured = (1 + s) · true + b + noise, in the tip frame, with which the sensor turns.
/// Those of `b` and `s`, the same for all contacts, are priors of parameters that are estimated
/// with the arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WrenchTolerance {
    /// Standard deviation (N, ≥ 0) of the bias `b` of each component of the force.
    pub force: f64,
    /// Standard deviation (N m, ≥ 0) of the bias `b` of each component of the moment.
    pub torque: f64,
    /// Standard deviation (1, ≥ 0) of the relative error `s` of the scale, common to forces and
    /// moments.
    pub scale: f64,
    /// Standard deviation (N, ≥ 0) of the noise of each component of the measured force in each
    /// row, before a lag is taken out. Noise that is not declared makes joints seem stiffer than
    /// they are.
    pub force_noise: f64,
    /// Standard deviation (N m, ≥ 0) of the noise of each component of the moment, likewise.
    pub torque_noise: f64,
}

impl WrenchTolerance {
    /// An exact wrench.
    pub const EXACT: WrenchTolerance =
        WrenchTolerance { force: 0.0, torque: 0.0, scale: 0.0, force_noise: 0.0, torque_noise: 0.0 };
    /// Default tolerance, what a wrist sensor that was zeroed reaches: 0.5 N, 0.05 N m and 2 %,
    /// with a noise of 0.1 N and 0.005 N m.
    pub const DEFAULT: WrenchTolerance =
        WrenchTolerance { force: 0.5, torque: 0.05, scale: 0.02, force_noise: 0.1, torque_noise: 0.005 };

    /// This tolerance of bias and scale, with the noise of another.
    pub fn with_noise_of(self, other: &WrenchTolerance) -> WrenchTolerance {
        WrenchTolerance { force_noise: other.force_noise, torque_noise: other.torque_noise, ..self }
    }
}

/// The tool: the part on the arm that touches, and its pose on the tip link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tool {
    /// Nominal pose of the tool frame in the tip link's frame (m).
    pub tip_from_tool: Pose,
    /// Prior of `tip_from_tool`; [`PlacePrior::Fixed`] if it is known exactly.
    pub prior: PlacePrior,
}

/// A fixture: the part that is touched, a contact manifold at a pose in base.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Fixture {
    /// Name, unique in the problem (not checked); parameters of the fixture's pose are named
    /// `fixture.{name}.{x|y|z|rx|ry|rz}`.
    pub name: String,
    /// Contact manifold: the poses `fixture_from_tool` at which the tool touches the fixture.
    #[serde(with = "manifold_data")]
    pub manifold: Arc<dyn ContactManifold>,
    /// Nominal pose of the fixture in base (m). `None`: the origin is the mean tool position of its
    /// contacts by the nominal arm (that of base without contacts), the axes are those of base.
    pub base_from_fixture: Option<Pose>,
    /// Prior of `base_from_fixture`.
    pub prior: PlacePrior,
    /// Tolerance of the shapes of fixture and tool.
    pub tolerance: ShapeTolerance,
    /// Name of the placement: fixtures with the same name here were touched in one go, with the
    /// same drift of the joints.
    pub placement: String,
}

impl Fixture {
    /// Whether its place in base is declared, exactly or with a standard deviation.
    pub(crate) fn is_located(&self) -> bool {
        self.base_from_fixture.is_some() && self.prior != PlacePrior::Flat
    }

    /// Whether the radius of the edges has a tolerance.
    pub(crate) fn has_uncertain_edges(&self) -> bool {
        self.tolerance.edge_radius > 0.0 && self.manifold.has_edges()
    }

    /// Whether the radius of the edges is exact.
    pub(crate) fn has_exact_edges(&self) -> bool {
        self.tolerance.edge_radius == 0.0 && self.manifold.has_edges()
    }
}

/// A known distance between the origins of two fixtures' frames, measured independently of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Distance {
    /// Indices of the two fixtures in [`Problem::fixtures`], two different ones; their order is
    /// without effect. An index beyond the list panics where the problem is solved.
    pub between: (usize, usize),
    /// Declared distance (m, > 0).
    pub distance: f64,
    /// Standard deviation of the declared distance (m, > 0).
    pub sigma: f64,
}

/// Share of [`DEFAULT_DISTANCE_SIGMA`] below which a distance is nearly exact.
const NEARLY_EXACT: f64 = 0.5;

impl Distance {
    /// Whether the distance is declared so much better than is usual that contacts follow it, and
    /// only a score test shows whether it is right.
    pub(crate) fn is_nearly_exact(&self) -> bool {
        self.sigma < NEARLY_EXACT * DEFAULT_DISTANCE_SIGMA
    }
}

/// What encoder offsets change with, where they change linearly
/// ([`ParameterId::JointTrend`](crate::parameter::ParameterId::JointTrend)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TrendVariable {
    /// The number of the contact in the log: minus the trend at the first, plus the trend at the
    /// last.
    #[default]
    Log,
    /// The temperature of the arm ([`ContactLog::temperature`]): minus the trend at the lowest,
    /// plus the trend at the highest. Contacts of unknown temperature count as halfway.
    Temperature,
}

/// Measurement noise: standard deviations, independent from contact to contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Standard deviation of each revolute joint's measured position (rad, ≥ 0); prismatic joints
    /// count as exact. With 0 one-sided contacts count by their least gap, not by their likelihood.
    pub encoder: f64,
    /// Standard deviation of each residual row apart from the encoders (m, ≥ 0): deflection, form
    /// errors of the parts, contact detection. Not 0 together with `encoder`.
    pub contact: f64,
    /// Whether `encoder` and `contact` are initial values only, and one factor on both is estimated
    /// from the contacts. [`Method::GradientDescent`] estimates none.
    pub is_estimated: bool,
}

/// A calibration problem. [`Problem::new`] has the defaults of everything that is optional.
///
/// Its data (serde) are for other processes: but for what
/// [`manifold_data`](crate::manifold::manifold_data) checks, they are trusted, and their format
/// must keep infinite numbers, as CBOR does and JSON does not.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Problem {
    /// The nominal arm.
    pub robot: Robot,
    /// The tool: the part on the arm that touches.
    pub tool: Tool,
    /// The fixtures: the parts that are touched. A contact's fixture is an index into this list;
    /// one beyond it panics where the problem is solved or evaluated.
    pub fixtures: Vec<Fixture>,
    /// Known distances between fixtures; may be empty.
    pub distances: Vec<Distance>,
    /// Contacts: joint positions measured while the tool touched a fixture, of as many joints as
    /// the arm has moving ones.
    pub contacts: ContactLog,
    /// Contacts that are not fitted: the result is tested with them
    /// ([`Estimate::held_out`](super::Estimate::held_out)); may be empty.
    pub held_out: ContactLog,
    /// Measurement noise of encoders and contacts.
    pub noise: Noise,
    /// Parameters of the arm ([`ParameterId::Kinematic`](crate::parameter::ParameterId::Kinematic))
    /// and of its encoders ([`joint_trend`](crate::parameter::joint_trend), `joint_walk`,
    /// `joint_harmonic`, …) to estimate, each once, with their priors; those of tool and fixtures
    /// follow from their [`PlacePrior`]s. May be empty.
    pub parameters: Vec<Parameter>,
    /// Whether each placement ([`Fixture::placement`]) has encoder offsets of its own
    /// ([`joint_drift`](crate::parameter::joint_drift)); takes effect with two placements or more.
    pub joint_drift: bool,
    /// What linear changes of encoder offsets follow.
    pub trend_variable: TrendVariable,
    /// How well the measured wrench is known, where joints deflect under the loads of contacts;
    /// without effect elsewhere.
    pub wrench: WrenchTolerance,
    /// How the cost is minimized.
    pub method: Method,
    /// Robust loss of the whitened residuals. [`Method::GradientDescent`] does not minimize it, but
    /// verdicts and covariance use it there too.
    pub loss: Loss,
    /// Settings of the estimator.
    pub options: EstimatorOptions,
    /// What is asked of the calibration; `None` if nothing is.
    pub acceptance: Option<Acceptance>,
    /// Arms that a log may be of by mistake, whose names a warning gives
    /// ([`DeclarationMistake::OtherArm`](super::DeclarationMistake::OtherArm)); may be empty.
    pub other_arms: Vec<Robot>,
}

impl Problem {
    /// The problem with the contacts that are held out, if there are any, in place of the others:
    /// what an evaluation is made on.
    pub fn of_held_out_contacts(mut self) -> Problem {
        if !self.held_out.is_empty() {
            self.contacts = std::mem::take(&mut self.held_out);
        }
        self
    }

    /// A problem without distances, drift and parameters of the arm, solved by Levenberg–Marquardt
    /// with noise that is estimated from the contacts (starting at [`DEFAULT_ENCODER`] and
    /// [`DEFAULT_CONTACT`]), [`WrenchTolerance::DEFAULT`], a Geman–McClure loss of scale 3 and
    /// default options. Where joint torques of contacts are known, the arm's torques are
    /// [measured](Robot::with_measured_torques). Nothing is checked.
    pub fn new(robot: Robot, tool: Tool, fixtures: Vec<Fixture>, contacts: ContactLog) -> Self {
        Problem {
            robot: if contacts.has_joint_torques() { robot.with_measured_torques() } else { robot },
            tool,
            fixtures,
            distances: Vec::new(),
            contacts,
            held_out: ContactLog::default(),
            noise: Noise { encoder: DEFAULT_ENCODER, contact: DEFAULT_CONTACT, is_estimated: true },
            parameters: Vec::new(),
            joint_drift: false,
            trend_variable: TrendVariable::Log,
            wrench: WrenchTolerance::DEFAULT,
            method: Method::LevenbergMarquardt,
            loss: Loss::GemanMcClure(3.0),
            options: EstimatorOptions::default(),
            acceptance: None,
            other_arms: Vec::new(),
        }
    }

    /// Root mean squares over the contacts of the torque of each joint (N m, or N of a prismatic
    /// joint), with the sign of its mean, where joints deflect by measured torques; else empty.
    pub(crate) fn usual_torques(&self) -> Vec<f64> {
        if !self.robot.has_measured_torques() {
            return Vec::new();
        }
        let of_joint = |joint: usize| {
            let each = (0..self.contacts.len()).filter_map(|i| Some(self.contacts.joint_torques(i)?[joint]));
            let (count, sum, squares) =
                each.fold((0.0, 0.0, 0.0), |(n, sum, squares), tau| (n + 1.0, sum + tau, squares + tau * tau));
            f64::sqrt(squares / f64::max(count, 1.0)).copysign(sum)
        };
        (0..self.robot.dof()).map(of_joint).collect()
    }

    /// Whether the covariance is to allow for errors of the arm that are not estimated and that
    /// contacts would not show: [`UnseenEffects::Widen`], and some place is not exact. It does so
    /// where effects are tested ([`Estimate::effect_tests`](super::Estimate::effect_tests)).
    pub fn allows_for_unseen_effects(&self) -> bool {
        let mut places = self.fixtures.iter().map(|fixture| fixture.prior).chain([self.tool.prior]);
        self.options.unseen_effects == UnseenEffects::Widen && places.any(|prior| prior != PlacePrior::Fixed)
    }

    /// Frame in which errors of the tool count: that of the task that is asked for, else the base.
    pub fn error_frame(&self) -> ErrorFrame {
        self.acceptance.as_ref().map_or(ErrorFrame::Base, |asked| asked.frame)
    }

    /// The same problem with `parameters` of the arm to estimate, in place of the former ones.
    pub fn with_parameters(self, parameters: Vec<Parameter>) -> Self {
        Problem { parameters, ..self }
    }

    /// The same problem with this measurement noise, in place of the former.
    pub fn with_noise(self, noise: Noise) -> Self {
        Problem { noise, ..self }
    }

    /// Whether the tool frame is the tip link's frame and the calibrated chain can hold an
    /// estimated motion of it, because its last joint is fixed.
    pub fn tool_is_tip(&self) -> bool {
        self.tool.tip_from_tool == Pose::identity() && self.robot.with_tip_moved(&Pose::identity()).is_some()
    }

    /// Whether joints deflect under loads of contacts: some are known, and the arm is compliant, or
    /// its compliances or backlashes are parameters.
    pub(crate) fn deflects_under_loads(&self) -> bool {
        let is_deflection = |parameter: &Parameter| parameter.id.block().is_deflection();
        self.contacts.has_loads() && (self.robot.is_compliant() || self.parameters.iter().any(is_deflection))
    }

    /// Whether standard deviations follow from the contacts: not where any is measured by the
    /// distance from a projection, nor where gradient descent ends, which is at no minimum of the
    /// likelihood.
    pub(crate) fn has_uncertainty(&self) -> bool {
        let is_projection = |fixture: &Fixture| fixture.manifold.residual_kind() == ResidualKind::ProjectionError;
        self.method == Method::LevenbergMarquardt && !self.fixtures.iter().any(is_projection)
    }
}

//! What is simulated: an arm and its possible errors, what it touches, how it explores, and the
//! recorder.

use super::equilibrium::Stiffness;
use super::exploration::Exploration;
use super::recorder::Recorder;
use crate::geometry::Parts;
use crate::robot::Robot;
use crate::se3::Pose;

/// A calibration to be simulated, without its random numbers: [`simulate`](crate::sim::simulate())
/// draws the truth from a seed and runs it. Its numbers are not checked here;
/// [`scenario_file`](crate::io::scenario_file) checks those that it reads.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The nominal arm, without errors.
    pub robot: Robot,
    /// Sizes of the possible errors of the arm.
    pub errors: ArmErrors,
    /// Nominal pose of the tool frame in the tip link's frame (m).
    pub tip_from_tool: Pose,
    /// Standard deviations of the error of the tool's pose: of a twist in the tool frame.
    pub tool_error: PlaceError,
    /// Fixtures to explore, in this order; may be empty.
    pub touches: Vec<Touch>,
    /// Distances between fixtures that are measured, in any order; may be empty.
    pub distances: Vec<MeasuredDistance>,
    /// Number of contacts to log with each fixture, shared by its postures as equally as whole
    /// numbers allow.
    pub contacts: usize,
    /// Stiffness of the arm under impedance control, at the tool.
    pub stiffness: Stiffness,
    /// Coefficient of friction μ between tool and fixture (1, ≥ 0).
    pub friction: f64,
    /// Standard deviation of form errors (m, ≥ 0): in each row, each surface that the tool touches
    /// stands out by a Gaussian number of this standard deviation.
    pub contact_sigma: f64,
    /// Encoders, force sensor and contact detection.
    pub recorder: Recorder,
    /// Relation of strain and temperature, where the temperatures of the arm's
    /// [`segments`](crate::robot::segments()) are recorded; `None`: they are not.
    pub thermal: Option<Thermal>,
}

/// A fixture to explore, and how.
#[derive(Clone, Debug)]
pub struct Touch {
    /// Name of the fixture, unique in the scenario; `{block}/{number}` for several on one block.
    pub name: String,
    /// Nominal pose of the fixture in base (m). Fixtures whose names are alike up to the last `/`
    /// stand on one block, which is displaced as a whole, by the error of its first fixture.
    pub base_from_fixture: Pose,
    /// Standard deviations of the error of that pose: of a twist in the fixture frame. The
    /// displacement of a block is drawn by those of its first fixture.
    pub place_error: PlaceError,
    /// Whether the pose is unknown to the estimator, which then has neither nominal value nor prior
    /// for it.
    pub free: bool,
    /// Nominal shapes of tool and fixture. The simulator needs at least one point of a tool
    /// [`OnPlane`](Parts::OnPlane).
    pub parts: Parts,
    /// Standard deviation of how much wider the true hole is than its nominal outline (m per side,
    /// ≥ 0); without effect on parts other than a peg in a hole.
    pub clearance_sigma: f64,
    /// Standard deviation of how much deeper the true hole is than its nominal depth (m, ≥ 0);
    /// without effect on parts other than a peg in a hole.
    pub depth_sigma: f64,
    /// Standard deviation of how much wider the true hole is along x of the fixture's frame than by
    /// [`Touch::clearance_sigma`], and, independently of it, along y (m per side, ≥ 0); without
    /// effect on parts other than a peg in a hole.
    pub unequal_clearance_sigma: f64,
    /// Radius by which edges of the true peg and hole are worn beyond their nominal
    /// [radii](crate::geometry::EdgeRadii) (m, ≥ 0); without effect on parts other than a peg in
    /// a hole.
    pub edge_wear: f64,
    /// Standard deviation of a normal draw whose absolute value is the radius by which these edges
    /// are worn further (m, ≥ 0); likewise.
    pub edge_radius_sigma: f64,
    /// Postures near which to work, each in turn: lists of joint positions (rad, or m for a
    /// prismatic joint; exactly one for each moving joint, base first). Without a posture the log
    /// is empty.
    pub postures: Vec<Vec<f64>>,
    /// Motion of the command at the fixture.
    pub exploration: Exploration,
}

impl Touch {
    /// The block that the fixture stands on: its name up to the last `/`, the whole name where
    /// there is none.
    pub fn block(&self) -> &str {
        self.name.rsplit_once('/').map_or(&self.name, |(block, _)| block)
    }
}

/// A distance between the origins of two fixtures' frames that is measured independently of the
/// arm, with a Gaussian error, and known to the estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredDistance {
    /// Indices of the two fixtures in [`Scenario::touches`], two different ones; their order is
    /// without effect.
    pub between: (usize, usize),
    /// Standard deviation of the error (m, ≥ 0); 0 for an exact measurement.
    pub sigma: f64,
}

/// Strain of a link from its temperature `T`: `ε = α (T − T₀)`, `l = l₀ (1 + ε)`. The simulator
/// draws strains `ε` by [`Scenario::errors`] and records the temperatures that they follow from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    /// Coefficient of thermal expansion α (1/K). Above 0 in a scenario: at 0 the temperatures of a
    /// simulation are not finite.
    pub expansion: f64,
    /// Temperature T₀ at which the arm has its nominal lengths (°C).
    pub reference: f64,
    /// Standard deviation of the noise of each recorded temperature (K, ≥ 0).
    pub sensor_sigma: f64,
}

impl Thermal {
    /// No expansion: α = 0 at 20 °C, exact sensors. For numbers to start from, not for a
    /// [`Scenario`], which has `None` for an arm without expansion.
    pub const NONE: Thermal = Thermal { expansion: 0.0, reference: 20.0, sensor_sigma: 0.0 };
}

/// Standard deviations of the error of a pose: of the components of a local twist `ξ = [v; ω]` in
/// `nominal · Exp(ξ)`, so in the frame that is placed; independent and Gaussian, 0 for no error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaceError {
    /// Standard deviation of each translation component of `ξ` (m, ≥ 0).
    pub length: f64,
    /// Standard deviation of each rotation component of `ξ` (rad, ≥ 0).
    pub angle: f64,
}

/// Distribution from which an error of a given size (≥ 0) is drawn, in the error's unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Plus or minus the size, each with probability 1/2.
    Sign,
    /// Uniform between minus and plus the size.
    Uniform,
    /// Gaussian with mean zero, the size being the standard deviation.
    Normal,
}

impl Distribution {
    /// All distributions, in the order of their definition.
    pub const ALL: [Distribution; 3] = [Distribution::Sign, Distribution::Uniform, Distribution::Normal];

    /// Name in files: `sign`, `uniform`, `normal`.
    pub fn name(self) -> &'static str {
        match self {
            Distribution::Sign => "sign",
            Distribution::Uniform => "uniform",
            Distribution::Normal => "normal",
        }
    }
}

/// Sizes (≥ 0) of the possible errors of an arm; 0 for no error. `distribution` gives a size its
/// meaning.
///
/// Errors of joint origins are components `x, y, z` (m) and `rx, ry, rz` (rad) of a local twist `ξ`
/// in the joint's frame, `origin · Exp(ξ)`, as estimated by
/// [`joint_origin`](crate::parameter::joint_origin()).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmErrors {
    /// Distribution from which every error but compliance and backlash is drawn.
    pub distribution: Distribution,
    /// Size of the strain common to all links (1). Where `segment_strain` is not 0, the truth holds
    /// it as part of each segment's strain.
    pub strain: f64,
    /// Size of the strain of each of the arm's [`segments`](crate::robot::segments()) (1), on top
    /// of the common one.
    pub segment_strain: f64,
    /// Size of the encoder offset of each moving joint (rad, or m for a prismatic joint).
    pub joint_offset: f64,
    /// Size of each translation component `x`, `y` and `z` of each moving joint's origin (m).
    pub origin_length: f64,
    /// Size of each rotation component `rx`, `ry` and `rz` of each moving joint's origin (rad) but
    /// those of `origin_zero`: the two across the axis of a revolute or continuous joint where that
    /// is along x, y or z of the joint's frame, all three of a prismatic joint.
    pub origin_angle: f64,
    /// Size of the rotation components (rad) of each revolute or continuous joint's origin for
    /// which the axis, a unit vector in the joint's frame, has an entry above 0.5 in magnitude: the
    /// rotation about the axis where that is along x, y or z; up to three components for an oblique
    /// axis.
    pub origin_zero: f64,
    /// Compliance of each revolute or continuous joint (rad/(N m)) under gravity and the contact's
    /// load; the same for all and not drawn.
    pub joint_compliance: f64,
    /// Half of the play of each moving joint (rad, or m for a prismatic joint), which rests at the
    /// side to which gravity and the contact's load push it; the same for all and not drawn.
    pub joint_backlash: f64,
    /// Size of each amplitude, of sine and cosine, of a harmonic of once a turn in the encoder of
    /// each revolute or continuous joint (rad).
    pub joint_harmonic: f64,
    /// The same of twice a turn (rad).
    pub joint_harmonic_2: f64,
    /// Size of the relative error of the ratio between encoder and joint of each moving joint (1).
    pub joint_gear_ratio: f64,
}

impl ArmErrors {
    /// No errors: all sizes 0.
    pub const NONE: ArmErrors = ArmErrors {
        distribution: Distribution::Uniform,
        strain: 0.0,
        segment_strain: 0.0,
        joint_offset: 0.0,
        origin_length: 0.0,
        origin_angle: 0.0,
        origin_zero: 0.0,
        joint_compliance: 0.0,
        joint_backlash: 0.0,
        joint_harmonic: 0.0,
        joint_harmonic_2: 0.0,
        joint_gear_ratio: 0.0,
    };

    /// Whether joints deflect under torques.
    pub fn deflect_joints(&self) -> bool {
        self.joint_compliance > 0.0 || self.joint_backlash > 0.0
    }
}

//! What is simulated: an arm and its possible errors, what it touches, how it explores, and the
//! recorder.

use super::equilibrium::Stiffness;
use super::exploration::Exploration;
use super::recorder::Recorder;
use crate::geometry::Parts;
use crate::robot::Robot;
use crate::se3::Pose;

/// A calibration to be simulated, without its random numbers: [`simulate`](crate::sim::simulate())
/// draws the truth from a seed and runs it.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The nominal arm, without errors.
    pub robot: Robot,
    /// Sizes of the possible errors of the arm.
    pub errors: ArmErrors,
    /// Nominal pose of the tool frame in the tip link's frame (m).
    pub tip_from_tool: Pose,
    /// Standard deviations of the error of the tool's pose.
    pub tool_error: PlaceError,
    /// Fixtures to explore, in this order.
    pub touches: Vec<Touch>,
    /// Number of contacts to log with each fixture, shared equally by its postures.
    pub contacts: usize,
    /// Stiffness of the arm under impedance control.
    pub stiffness: Stiffness,
    /// Coefficient of friction μ between tool and fixture (1).
    pub friction: f64,
    /// Standard deviation of form errors (m): in each row, each surface that the tool touches
    /// stands out by a Gaussian number of this size.
    pub contact_sigma: f64,
    /// Encoders, force sensor and contact detection.
    pub recorder: Recorder,
    /// Strain from temperature, where the links' temperatures are recorded; `None`: they are not.
    pub thermal: Option<Thermal>,
}

/// A fixture to explore, and how.
#[derive(Clone, Debug)]
pub struct Touch {
    /// Name of the fixture, `{block}/{number}` for several on one block.
    pub name: String,
    /// Nominal pose of the fixture in base (m). Fixtures whose names are alike up to the last `/`
    /// stand on one block, which is displaced as a whole.
    pub base_from_fixture: Pose,
    /// Standard deviations of the error of that pose.
    pub place_error: PlaceError,
    /// Whether the pose is unknown to the estimator, which then has neither nominal value nor prior
    /// for it.
    pub free: bool,
    /// Nominal shapes of tool and fixture.
    pub parts: Parts,
    /// Standard deviation of how much wider the true hole is than its nominal outline (m per side).
    pub clearance_sigma: f64,
    /// Postures near which to work, each in turn: lists of joint positions (rad, or m for a
    /// prismatic joint; one for each moving joint, base first).
    pub postures: Vec<Vec<f64>>,
    /// Motion of the command at the fixture.
    pub exploration: Exploration,
}

impl Touch {
    /// The block that the fixture stands on: its name up to the last `/`.
    pub fn block(&self) -> &str {
        self.name.rsplit_once('/').map_or(&self.name, |(block, _)| block)
    }
}

/// Strain of a link from its temperature `T`: `ε = α (T − T₀)`, `l = l₀ (1 + ε)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    /// Coefficient of thermal expansion α (1/K).
    pub expansion: f64,
    /// Temperature T₀ at which the arm has its nominal lengths (°C).
    pub reference: f64,
    /// Standard deviation of each recorded temperature (K).
    pub sensor_sigma: f64,
}

impl Thermal {
    /// No expansion: α = 0 at 20 °C, exact sensors.
    pub const NONE: Thermal = Thermal { expansion: 0.0, reference: 20.0, sensor_sigma: 0.0 };
}

/// Standard deviations of the error of a pose: of the components of a local twist, independent and
/// Gaussian; 0 for no error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaceError {
    /// Standard deviation of each translation component (m).
    pub length: f64,
    /// Standard deviation of each rotation component (rad).
    pub angle: f64,
}

/// Distribution from which an error of a given size is drawn, in the error's unit.
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

/// Sizes of the possible errors of an arm; 0 for no error. `distribution` gives a size its meaning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmErrors {
    /// Distribution from which every error but the compliance is drawn.
    pub distribution: Distribution,
    /// Size of the strain common to all links (1).
    pub strain: f64,
    /// Size of the strain of each segment (1), on top of the common one.
    pub segment_strain: f64,
    /// Size of the encoder offset of each moving joint (rad, or m for a prismatic joint).
    pub joint_offset: f64,
    /// Size of each component of the displacement of each moving joint's origin (m).
    pub origin_length: f64,
    /// Size of each component of the rotation of each moving joint's origin across its axis (rad).
    pub origin_angle: f64,
    /// Size of the rotation of each revolute joint's origin about its axis (rad).
    pub origin_zero: f64,
    /// Compliance of each revolute joint (rad/(N m)) under gravity and the contact's load; the same
    /// for all and not drawn.
    pub joint_compliance: f64,
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
    };
}

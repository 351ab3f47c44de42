//! What is simulated: an arm and what may be wrong with it, what it touches, how it explores, and
//! what records it.

use super::equilibrium::Stiffness;
use super::exploration::Exploration;
use super::recorder::Recorder;
use crate::geometry::Parts;
use crate::robot::Robot;
use crate::se3::Pose;

/// A calibration to be simulated: all but the chance. [`simulate`](crate::sim::simulate()) draws
/// the truth from a seed and runs it.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The arm as its maker drew it.
    pub robot: Robot,
    /// What may be wrong with it.
    pub errors: ArmErrors,
    /// The tool's place on the tip, as the user believes it.
    pub tip_from_tool: Pose,
    /// How far it may be off.
    pub tool_error: PlaceError,
    /// What is touched, one after the other.
    pub touches: Vec<Touch>,
    /// Contacts logged with each, shared equally by its postures.
    pub contacts: usize,
    /// How the arm yields.
    pub stiffness: Stiffness,
    /// Coefficient of friction.
    pub friction: f64,
    /// Standard deviation of what the contact itself adds (m): each surface that the tool touches
    /// stands out by so much.
    pub contact_sigma: f64,
    /// What writes it down.
    pub recorder: Recorder,
    /// How links stretch, where their temperature is recorded.
    pub thermal: Option<Thermal>,
}

/// A fixture to explore.
#[derive(Clone, Debug)]
pub struct Touch {
    /// Its name.
    pub name: String,
    /// Its place, as the user believes it. Fixtures whose names begin alike up to a `/` stand on
    /// one block, which is off as a whole.
    pub base_from_fixture: Pose,
    /// How far it may be off.
    pub place_error: PlaceError,
    /// The user does not know its place at all.
    pub free: bool,
    /// Tool and fixture, as the user believes them.
    pub parts: Parts,
    /// Standard deviation of how much wider a hole is than its outline (m per side).
    pub clearance_sigma: f64,
    /// Joint positions (rad or m) near which to work, each in turn.
    pub postures: Vec<Vec<f64>>,
    /// How the tool is moved there.
    pub exploration: Exploration,
}

impl Touch {
    /// The block that the fixture stands on: its name up to the last `/`.
    pub fn block(&self) -> &str {
        self.name.rsplit_once('/').map_or(&self.name, |(block, _)| block)
    }
}

/// Strain from temperature: `ε = α (T − T₀)`, `l = l₀ (1 + ε)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    /// Coefficient of expansion α (1/K).
    pub expansion: f64,
    /// Temperature T₀ at which the arm is as drawn (°C).
    pub reference: f64,
    /// Standard deviation of each temperature recorded (K).
    pub sensor_sigma: f64,
}

impl Thermal {
    /// Links that do not stretch.
    pub const NONE: Thermal = Thermal { expansion: 0.0, reference: 20.0, sensor_sigma: 0.0 };
}

/// Standard deviations of a place, each component Gaussian.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlaceError {
    /// Of its position (m, each component).
    pub length: f64,
    /// Of its rotation (rad, each component).
    pub angle: f64,
}

/// How numbers of a given size are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    /// Plus or minus the size.
    Sign,
    /// Evenly between minus and plus the size.
    Uniform,
    /// Normally, the size being the standard deviation.
    Normal,
}

impl Distribution {
    /// All of them.
    pub const ALL: [Distribution; 3] = [Distribution::Sign, Distribution::Uniform, Distribution::Normal];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Distribution::Sign => "sign",
            Distribution::Uniform => "uniform",
            Distribution::Normal => "normal",
        }
    }
}

/// Sizes of what may be wrong with an arm; 0 for what is right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArmErrors {
    /// How they are drawn.
    pub distribution: Distribution,
    /// Strain common to all links.
    pub strain: f64,
    /// Strain of each segment on top of it.
    pub segment_strain: f64,
    /// Encoder biases (rad or m).
    pub joint_offset: f64,
    /// Displacement of each joint's origin (m, each component).
    pub origin_length: f64,
    /// Rotation of each joint's origin across its axis (rad, each component).
    pub origin_angle: f64,
    /// Rotation of each joint's origin about its axis (rad).
    pub origin_zero: f64,
    /// Compliance of each joint (rad/(N m)), not drawn: under gravity, and under what presses on
    /// the tool.
    pub joint_compliance: f64,
}

impl ArmErrors {
    /// Nothing wrong.
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

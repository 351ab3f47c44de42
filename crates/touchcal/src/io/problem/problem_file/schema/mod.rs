//! The tables and keys of `problem.toml`, as written. The comment of a key is its entry in the
//! guide's reference, whose table of defaults and examples is made of what follows
//! `Without it:` and `Example:`.

mod contacts;
mod estimate;
mod part;
mod value;

use serde::Deserialize;
use toml::{Spanned, Value};

pub(crate) use contacts::{ContactsToml, LoadFrameToml, LoadOnToml, LogToml, TauJointToml, UnitToml};
pub(crate) use estimate::{
    EstimateToml, LossToml, NoiseToml, OptimiserToml, PriorToml, TrendOverToml, UnseenEffectsToml,
};
pub(crate) use part::{FixtureKind, FixtureToml, LengthUnitToml, ManifoldToml, PoseToml, ToolKind, ToolToml};
pub(crate) use value::{Number, Text};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProblemToml {
    /// Version of the format. Without it: 1.
    /// Example: `schema = 1`
    pub(crate) schema: Option<Spanned<i64>>,
    /// The arm.
    pub(crate) robot: Spanned<RobotToml>,
    /// What touches the fixtures.
    pub(crate) tool: Spanned<ToolToml>,
    /// What is touched, a table each; at most 1000.
    #[serde(default)]
    pub(crate) fixture: Vec<Spanned<FixtureToml>>,
    /// Distances between fixtures that are known, a table each.
    #[serde(default)]
    pub(crate) distance: Vec<Spanned<DistanceToml>>,
    /// How all logs are to be read. A key here holds for each table of `[[contacts]]` that does not
    /// have the same key.
    #[serde(default)]
    pub(crate) log: LogToml,
    /// The logs, a table each. Keys that are in `[log]` too take precedence over it.
    #[serde(default)]
    pub(crate) contacts: Vec<Spanned<ContactsToml>>,
    /// Noise of encoders, contacts and wrench. Without `encoder_deg` and `contact_mm`, that of
    /// encoders and contacts is estimated.
    #[serde(default)]
    pub(crate) noise: NoiseToml,
    /// What is estimated, and how.
    pub(crate) estimate: EstimateToml,
    /// What is asked of the calibration: an accuracy of the tool, and where.
    pub(crate) accept: Option<Spanned<AcceptToml>>,
}

/// What is asked of the calibration.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AcceptToml {
    /// Largest distance of the tool from where the calibrated arm has it. Without it: required.
    /// Example: `tolerance_mm = 0.2`
    pub(crate) tolerance_mm: Option<Number>,
    /// Largest angle of the tool to its calibrated orientation. Without it: angles do not count.
    /// Example: `tolerance_deg = 0.1`
    pub(crate) tolerance_deg: Option<Number>,
    /// Probability with which a PASS or FAIL is to be right, above 0.5 and at most 0.999. Without
    /// it: 0.95.
    /// Example: `confidence = 0.99`
    pub(crate) confidence: Option<Number>,
    /// Frame in which errors of the tool count: the arm's base, or the base after it was moved to
    /// fit the tool's positions best. Without it: base.
    /// Example: `frame = "base_aligned"`
    pub(crate) frame: Option<ErrorFrameToml>,
    /// The task as joint positions (mm for prismatic joints), at most 1000; alone. Without it:
    /// `joints_deg` or `region` is required.
    /// Example: `postures_deg = [[0, 40, 0, -90, 0, 50, 0]]`
    pub(crate) postures_deg: Option<Spanned<Vec<Vec<f64>>>>,
    /// The task as a box of joint positions, least and greatest of each joint; beside `region` it
    /// limits the joints there. Without it: the joint limits beside `region`, else another task is
    /// required.
    /// Example: `joints_deg = [[-20, 20], [20, 60], [-90, 90]]`
    pub(crate) joints_deg: Option<Spanned<Vec<[f64; 2]>>>,
    /// The task as a box of tool positions. Without it: `postures_deg` or `joints_deg` is required.
    /// Example: `region = { center_mm = [500, 0, 300], size_mm = [200, 200, 100] }`
    pub(crate) region: Option<Spanned<RegionToml>>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ErrorFrameToml {
    Base,
    BaseAligned,
}

/// A box in the base frame.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RegionToml {
    /// Centre of the box in the base frame.
    /// Example: `center_mm = [500, 0, 300]`
    pub(crate) center_mm: Spanned<[f64; 3]>,
    /// Lengths of its edges along the axes of the base frame.
    /// Example: `size_mm = [200, 200, 100]`
    pub(crate) size_mm: Spanned<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RobotToml {
    /// URDF file of the nominal arm. Without it: `builtin` is required.
    /// Example: `urdf = "robot.urdf"`
    pub(crate) urdf: Option<Text>,
    /// Instead of a file: a built-in arm. One of: `iiwa14`, `panda`. Without it: `urdf` is
    /// required.
    /// Example: `builtin = "iiwa14"`
    pub(crate) builtin: Option<Text>,
    /// Link where the chain begins. Without it: the only link that is no joint's child.
    /// Example: `base = "base_link"`
    pub(crate) base: Option<String>,
    /// Link where the chain ends. Without it: the only link below the base that carries no other;
    /// the flange of a built-in arm.
    /// Example: `tip = "flange"`
    pub(crate) tip: Option<String>,
    /// The moving joints in the order of the logs' columns `q1` to `qn`. Without it: base first.
    /// Example: `joints = ["shoulder", "elbow", "wrist"]`
    pub(crate) joints: Option<Spanned<Vec<String>>>,
    /// Acceleration of gravity in the base frame (m/s²). Without it: [0, 0, -9.81].
    /// Example: `gravity = [0, 9.81, 0]`
    pub(crate) gravity: Option<Spanned<[f64; 3]>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DistanceToml {
    /// Names of the two fixtures.
    /// Example: `between = ["A/0", "A/1"]`
    pub(crate) between: [Text; 2],
    /// Distance of their origins.
    /// Example: `mm = 50`
    pub(crate) mm: Number,
    /// Standard deviation of the distance. Without it: 0.1.
    /// Example: `sigma_mm = 0.01`
    pub(crate) sigma_mm: Option<Number>,
    /// Whether the distance is exact: `true`, or `["length"]`. Without it: false.
    /// Example: `exact = true`
    pub(crate) exact: Option<Spanned<Value>>,
}

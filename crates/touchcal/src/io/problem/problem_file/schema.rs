//! The tables and keys of `problem.toml`, as written.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::{Spanned, Value};

/// A number with its place in the file.
pub(crate) type Number = Spanned<f64>;
/// A text with its place in the file.
pub(crate) type Text = Spanned<String>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ProblemToml {
    pub(crate) schema: Option<Spanned<i64>>,
    pub(crate) robot: Spanned<RobotToml>,
    pub(crate) tool: Spanned<ToolToml>,
    #[serde(default)]
    pub(crate) fixture: Vec<Spanned<FixtureToml>>,
    #[serde(default)]
    pub(crate) distance: Vec<Spanned<DistanceToml>>,
    #[serde(default)]
    pub(crate) contacts: Vec<Spanned<ContactsToml>>,
    #[serde(default)]
    pub(crate) noise: NoiseToml,
    pub(crate) estimate: EstimateToml,
    pub(crate) accept: Option<Spanned<AcceptToml>>,
}

/// What is asked of the calibration.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AcceptToml {
    pub(crate) tolerance_mm: Option<Number>,
    pub(crate) tolerance_deg: Option<Number>,
    pub(crate) confidence: Option<Number>,
    pub(crate) postures_deg: Option<Spanned<Vec<Vec<f64>>>>,
    pub(crate) joints_deg: Option<Spanned<Vec<[f64; 2]>>>,
    pub(crate) region: Option<Spanned<RegionToml>>,
}

/// A box in the base frame.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RegionToml {
    pub(crate) center_mm: Spanned<[f64; 3]>,
    pub(crate) size_mm: Spanned<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RobotToml {
    pub(crate) urdf: Option<Text>,
    pub(crate) builtin: Option<Text>,
    pub(crate) base: Option<String>,
    pub(crate) tip: Option<String>,
    pub(crate) joints: Option<Spanned<Vec<String>>>,
    pub(crate) gravity: Option<Spanned<[f64; 3]>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseToml {
    #[serde(default)]
    pub(crate) xyz_mm: [f64; 3],
    pub(crate) quat_wxyz: Option<[f64; 4]>,
    pub(crate) rpy_deg: Option<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ToolKind {
    Peg,
    Ball,
    Point,
}

/// The unit of a drawing or mesh.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LengthUnitToml {
    Mm,
    Cm,
    M,
    Inch,
}

impl LengthUnitToml {
    /// How long it is (m).
    pub(crate) fn metres(self) -> f64 {
        match self {
            LengthUnitToml::Mm => 1e-3,
            LengthUnitToml::Cm => 1e-2,
            LengthUnitToml::M => 1.0,
            LengthUnitToml::Inch => 25.4e-3,
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ToolToml {
    pub(crate) kind: ToolKind,
    pub(crate) tip_from_tool: Option<Spanned<PoseToml>>,
    pub(crate) outline: Option<Text>,
    pub(crate) outline_name: Option<Text>,
    pub(crate) outline_unit: Option<Spanned<LengthUnitToml>>,
    pub(crate) builtin: Option<Text>,
    pub(crate) mesh: Option<Text>,
    pub(crate) mesh_unit: Option<Spanned<LengthUnitToml>>,
    pub(crate) length_mm: Option<Number>,
    pub(crate) edge_radius_mm: Option<Number>,
    pub(crate) radius_mm: Option<Number>,
    pub(crate) sigma_mm: Option<Number>,
    pub(crate) sigma_deg: Option<Number>,
    #[serde(default)]
    pub(crate) free: bool,
    pub(crate) exact: Option<Spanned<Value>>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum FixtureKind {
    Hole,
    Socket,
    Plane,
}

/// How the contact manifold of a hole is known.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ManifoldToml {
    #[default]
    Exact,
    Nearest,
    Learned,
    Unknown,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FixtureToml {
    pub(crate) name: Text,
    pub(crate) kind: FixtureKind,
    pub(crate) placement: Option<String>,
    pub(crate) base_from_fixture: Option<Spanned<PoseToml>>,
    pub(crate) outline: Option<Text>,
    pub(crate) outline_name: Option<Text>,
    pub(crate) outline_unit: Option<Spanned<LengthUnitToml>>,
    pub(crate) outline_offset_mm: Option<Number>,
    pub(crate) builtin: Option<Text>,
    pub(crate) mesh: Option<Text>,
    pub(crate) mesh_unit: Option<Spanned<LengthUnitToml>>,
    pub(crate) depth_mm: Option<Number>,
    pub(crate) edge_radius_mm: Option<Number>,
    pub(crate) manifold: Option<Spanned<ManifoldToml>>,
    pub(crate) samples: Option<Text>,
    pub(crate) weights: Option<Text>,
    pub(crate) neighbours: Option<Number>,
    pub(crate) mm_per_deg: Option<Number>,
    pub(crate) sigma_mm: Option<Number>,
    pub(crate) sigma_deg: Option<Number>,
    pub(crate) clearance_sigma_mm: Option<Number>,
    pub(crate) depth_sigma_mm: Option<Number>,
    pub(crate) edge_radius_sigma_mm: Option<Number>,
    #[serde(default)]
    pub(crate) free: bool,
    pub(crate) exact: Option<Spanned<Value>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DistanceToml {
    pub(crate) between: [Text; 2],
    pub(crate) mm: Number,
    pub(crate) sigma_mm: Option<Number>,
    pub(crate) exact: Option<Spanned<Value>>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) enum UnitToml {
    #[serde(rename = "rad")]
    Radian,
    #[serde(rename = "deg")]
    Degree,
}

/// What the wrench of a log is exerted on.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LoadOnToml {
    Tool,
    Fixture,
}

/// What linear changes of encoder offsets follow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum TrendOverToml {
    Log,
    Temperature,
}

/// Along whose axes the wrench of a log is given.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LoadFrameToml {
    Tip,
    Base,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContactsToml {
    pub(crate) file: Text,
    pub(crate) fixture: Text,
    /// Whether contacts are not fitted, but test the result.
    #[serde(default)]
    pub(crate) held_out: bool,
    pub(crate) force_threshold_n: Option<Number>,
    pub(crate) release_n: Option<Number>,
    pub(crate) debounce: Option<Spanned<i64>>,
    pub(crate) apart_deg: Option<Number>,
    pub(crate) load_on: Option<LoadOnToml>,
    pub(crate) load_frame: Option<Spanned<LoadFrameToml>>,
    pub(crate) load_lag_rows: Option<Number>,
    pub(crate) unit: Option<UnitToml>,
    pub(crate) header: Option<Vec<String>>,
    pub(crate) temperature: Option<String>,
    pub(crate) joint_topic: Option<String>,
    pub(crate) wrench_topic: Option<String>,
    #[serde(default)]
    pub(crate) columns: BTreeMap<String, String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NoiseToml {
    pub(crate) encoder_deg: Option<Number>,
    pub(crate) contact_mm: Option<Number>,
    pub(crate) encoder_trend_deg: Option<Number>,
    pub(crate) encoder_trend_over: Option<Spanned<TrendOverToml>>,
    pub(crate) encoder_walk_deg: Option<Number>,
    /// Whether the noise is estimated too, the values being where that starts.
    pub(crate) estimated: Option<bool>,
    pub(crate) force_bias_n: Option<Number>,
    pub(crate) torque_bias_nm: Option<Number>,
    pub(crate) force_noise_n: Option<Number>,
    pub(crate) torque_noise_nm: Option<Number>,
    pub(crate) wrench_scale: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct PriorToml {
    pub(crate) strain: Option<Number>,
    pub(crate) segment_strain: Option<Number>,
    pub(crate) joint_offset_deg: Option<Number>,
    pub(crate) joint_offset_mm: Option<Number>,
    pub(crate) joint_origin_mm: Option<Number>,
    pub(crate) joint_origin_deg: Option<Number>,
    pub(crate) joint_compliance_rad_per_nm: Option<Number>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LossToml {
    Squared,
    Huber,
    Cauchy,
    // Spelt out: the derived name would split "McClure".
    #[default]
    #[serde(rename = "geman_mcclure")]
    GemanMcClure,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum OptimiserToml {
    Adam,
    Plain,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DescentToml {
    pub(crate) optimiser: Option<OptimiserToml>,
    pub(crate) steps: Option<Number>,
    pub(crate) rate: Option<Number>,
    pub(crate) contacts: Option<Number>,
}

/// What is done about errors of the arm that are not estimated and that contacts cannot see.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(crate) enum UnseenEffectsToml {
    #[default]
    Widen,
    Ignore,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EstimateToml {
    pub(crate) parameters: Vec<Text>,
    #[serde(default)]
    pub(crate) loss: LossToml,
    pub(crate) loss_scale: Option<Number>,
    #[serde(default)]
    pub(crate) freeze: Vec<Text>,
    #[serde(default)]
    pub(crate) prior: PriorToml,
    pub(crate) method: Option<Text>,
    #[serde(default)]
    pub(crate) unseen_effects: UnseenEffectsToml,
    pub(crate) descent: Option<Spanned<DescentToml>>,
}

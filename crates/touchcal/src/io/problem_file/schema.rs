//! The tables and keys of `problem.toml`, as written.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

/// A number with its place in the file.
pub(super) type Number = Spanned<f64>;
/// A text with its place in the file.
pub(super) type Text = Spanned<String>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ProblemToml {
    pub(super) schema: Option<Spanned<i64>>,
    pub(super) robot: Spanned<RobotToml>,
    pub(super) tool: Spanned<ToolToml>,
    #[serde(default)]
    pub(super) fixture: Vec<Spanned<FixtureToml>>,
    #[serde(default)]
    pub(super) distance: Vec<Spanned<DistanceToml>>,
    #[serde(default)]
    pub(super) contacts: Vec<Spanned<ContactsToml>>,
    #[serde(default)]
    pub(super) noise: NoiseToml,
    pub(super) estimate: EstimateToml,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotToml {
    pub(super) urdf: Option<Text>,
    pub(super) builtin: Option<Text>,
    pub(super) base: Option<String>,
    pub(super) tip: Option<String>,
    pub(super) joints: Option<Spanned<Vec<String>>>,
    pub(super) gravity: Option<Spanned<[f64; 3]>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseToml {
    #[serde(default)]
    pub(super) xyz_mm: [f64; 3],
    pub(super) quat_wxyz: Option<[f64; 4]>,
    pub(super) rpy_deg: Option<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(super) enum ToolKind {
    Peg,
    Ball,
    Point,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ToolToml {
    pub(super) kind: ToolKind,
    pub(super) tip_from_tool: Option<Spanned<PoseToml>>,
    pub(super) outline: Option<Text>,
    pub(super) builtin: Option<Text>,
    pub(super) mesh: Option<Text>,
    pub(super) length_mm: Option<Number>,
    pub(super) radius_mm: Option<Number>,
    pub(super) sigma_mm: Option<Number>,
    pub(super) sigma_deg: Option<Number>,
    #[serde(default)]
    pub(super) free: bool,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(super) enum FixtureKind {
    Hole,
    Socket,
    Plane,
}

/// How the contact manifold of a hole is known.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(super) enum ManifoldToml {
    #[default]
    Exact,
    Nearest,
    Learned,
    Unknown,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FixtureToml {
    pub(super) name: Text,
    pub(super) kind: FixtureKind,
    pub(super) placement: Option<String>,
    pub(super) base_from_fixture: Option<Spanned<PoseToml>>,
    pub(super) outline: Option<Text>,
    pub(super) outline_offset_mm: Option<Number>,
    pub(super) builtin: Option<Text>,
    pub(super) mesh: Option<Text>,
    pub(super) depth_mm: Option<Number>,
    pub(super) manifold: Option<Spanned<ManifoldToml>>,
    pub(super) samples: Option<Text>,
    pub(super) weights: Option<Text>,
    pub(super) neighbours: Option<Number>,
    pub(super) mm_per_deg: Option<Number>,
    pub(super) sigma_mm: Option<Number>,
    pub(super) sigma_deg: Option<Number>,
    #[serde(default)]
    pub(super) free: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DistanceToml {
    pub(super) between: [Text; 2],
    pub(super) mm: Number,
    pub(super) sigma_mm: Option<Number>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
pub(super) enum UnitToml {
    #[default]
    #[serde(rename = "rad")]
    Radian,
    #[serde(rename = "deg")]
    Degree,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ContactsToml {
    pub(super) file: Text,
    pub(super) fixture: Text,
    pub(super) force_threshold_n: Option<Number>,
    pub(super) release_n: Option<Number>,
    pub(super) debounce: Option<Spanned<i64>>,
    #[serde(default)]
    pub(super) unit: UnitToml,
    #[serde(default)]
    pub(super) columns: BTreeMap<String, String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NoiseToml {
    pub(super) encoder_deg: Option<Number>,
    pub(super) contact_mm: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PriorToml {
    pub(super) strain: Option<Number>,
    pub(super) segment_strain: Option<Number>,
    pub(super) joint_offset_deg: Option<Number>,
    pub(super) joint_offset_mm: Option<Number>,
    pub(super) joint_origin_mm: Option<Number>,
    pub(super) joint_origin_deg: Option<Number>,
    pub(super) joint_compliance_rad_per_nm: Option<Number>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum LossToml {
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
pub(super) enum OptimiserToml {
    Adam,
    Plain,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DescentToml {
    pub(super) optimiser: Option<OptimiserToml>,
    pub(super) steps: Option<Number>,
    pub(super) rate: Option<Number>,
    pub(super) contacts: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EstimateToml {
    pub(super) parameters: Vec<Text>,
    #[serde(default)]
    pub(super) loss: LossToml,
    pub(super) loss_scale: Option<Number>,
    #[serde(default)]
    pub(super) freeze: Vec<Text>,
    #[serde(default)]
    pub(super) prior: PriorToml,
    pub(super) method: Option<Text>,
    pub(super) descent: Option<Spanned<DescentToml>>,
}

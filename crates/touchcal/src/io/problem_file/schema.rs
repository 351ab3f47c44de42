//! The tables and keys of `problem.toml`, as written.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

/// A number with its place in the file.
pub(in crate::io) type Number = Spanned<f64>;
/// A text with its place in the file.
pub(in crate::io) type Text = Spanned<String>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct ProblemToml {
    pub(in crate::io) schema: Option<Spanned<i64>>,
    pub(in crate::io) robot: Spanned<RobotToml>,
    pub(in crate::io) tool: Spanned<ToolToml>,
    #[serde(default)]
    pub(in crate::io) fixture: Vec<Spanned<FixtureToml>>,
    #[serde(default)]
    pub(in crate::io) distance: Vec<Spanned<DistanceToml>>,
    #[serde(default)]
    pub(in crate::io) contacts: Vec<Spanned<ContactsToml>>,
    #[serde(default)]
    pub(in crate::io) noise: NoiseToml,
    pub(in crate::io) estimate: EstimateToml,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct RobotToml {
    pub(in crate::io) urdf: Option<Text>,
    pub(in crate::io) builtin: Option<Text>,
    pub(in crate::io) base: Option<String>,
    pub(in crate::io) tip: Option<String>,
    pub(in crate::io) joints: Option<Spanned<Vec<String>>>,
    pub(in crate::io) gravity: Option<Spanned<[f64; 3]>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct PoseToml {
    #[serde(default)]
    pub(in crate::io) xyz_mm: [f64; 3],
    pub(in crate::io) quat_wxyz: Option<[f64; 4]>,
    pub(in crate::io) rpy_deg: Option<[f64; 3]>,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(in crate::io) enum ToolKind {
    Peg,
    Ball,
    Point,
}

/// The unit of a drawing or mesh.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::io) enum LengthUnitToml {
    Mm,
    Cm,
    M,
    Inch,
}

impl LengthUnitToml {
    /// How long it is (m).
    pub(in crate::io) fn metres(self) -> f64 {
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
pub(in crate::io) struct ToolToml {
    pub(in crate::io) kind: ToolKind,
    pub(in crate::io) tip_from_tool: Option<Spanned<PoseToml>>,
    pub(in crate::io) outline: Option<Text>,
    pub(in crate::io) outline_name: Option<Text>,
    pub(in crate::io) outline_unit: Option<Spanned<LengthUnitToml>>,
    pub(in crate::io) builtin: Option<Text>,
    pub(in crate::io) mesh: Option<Text>,
    pub(in crate::io) mesh_unit: Option<Spanned<LengthUnitToml>>,
    pub(in crate::io) length_mm: Option<Number>,
    pub(in crate::io) radius_mm: Option<Number>,
    pub(in crate::io) sigma_mm: Option<Number>,
    pub(in crate::io) sigma_deg: Option<Number>,
    #[serde(default)]
    pub(in crate::io) free: bool,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(in crate::io) enum FixtureKind {
    Hole,
    Socket,
    Plane,
}

/// How the contact manifold of a hole is known.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
pub(in crate::io) enum ManifoldToml {
    #[default]
    Exact,
    Nearest,
    Learned,
    Unknown,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct FixtureToml {
    pub(in crate::io) name: Text,
    pub(in crate::io) kind: FixtureKind,
    pub(in crate::io) placement: Option<String>,
    pub(in crate::io) base_from_fixture: Option<Spanned<PoseToml>>,
    pub(in crate::io) outline: Option<Text>,
    pub(in crate::io) outline_name: Option<Text>,
    pub(in crate::io) outline_unit: Option<Spanned<LengthUnitToml>>,
    pub(in crate::io) outline_offset_mm: Option<Number>,
    pub(in crate::io) builtin: Option<Text>,
    pub(in crate::io) mesh: Option<Text>,
    pub(in crate::io) mesh_unit: Option<Spanned<LengthUnitToml>>,
    pub(in crate::io) depth_mm: Option<Number>,
    pub(in crate::io) manifold: Option<Spanned<ManifoldToml>>,
    pub(in crate::io) samples: Option<Text>,
    pub(in crate::io) weights: Option<Text>,
    pub(in crate::io) neighbours: Option<Number>,
    pub(in crate::io) mm_per_deg: Option<Number>,
    pub(in crate::io) sigma_mm: Option<Number>,
    pub(in crate::io) sigma_deg: Option<Number>,
    #[serde(default)]
    pub(in crate::io) free: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct DistanceToml {
    pub(in crate::io) between: [Text; 2],
    pub(in crate::io) mm: Number,
    pub(in crate::io) sigma_mm: Option<Number>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(in crate::io) enum UnitToml {
    #[serde(rename = "rad")]
    Radian,
    #[serde(rename = "deg")]
    Degree,
}

/// What the wrench of a log is exerted on.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::io) enum LoadOnToml {
    Tool,
    Fixture,
}

/// Along whose axes the wrench of a log is given.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::io) enum LoadFrameToml {
    Tip,
    Base,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct ContactsToml {
    pub(in crate::io) file: Text,
    pub(in crate::io) fixture: Text,
    pub(in crate::io) force_threshold_n: Option<Number>,
    pub(in crate::io) release_n: Option<Number>,
    pub(in crate::io) debounce: Option<Spanned<i64>>,
    pub(in crate::io) apart_deg: Option<Number>,
    pub(in crate::io) load_on: Option<LoadOnToml>,
    pub(in crate::io) load_frame: Option<Spanned<LoadFrameToml>>,
    pub(in crate::io) unit: Option<UnitToml>,
    pub(in crate::io) header: Option<Vec<String>>,
    pub(in crate::io) joint_topic: Option<String>,
    pub(in crate::io) wrench_topic: Option<String>,
    #[serde(default)]
    pub(in crate::io) columns: BTreeMap<String, String>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct NoiseToml {
    pub(in crate::io) encoder_deg: Option<Number>,
    pub(in crate::io) contact_mm: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct PriorToml {
    pub(in crate::io) strain: Option<Number>,
    pub(in crate::io) segment_strain: Option<Number>,
    pub(in crate::io) joint_offset_deg: Option<Number>,
    pub(in crate::io) joint_offset_mm: Option<Number>,
    pub(in crate::io) joint_origin_mm: Option<Number>,
    pub(in crate::io) joint_origin_deg: Option<Number>,
    pub(in crate::io) joint_compliance_rad_per_nm: Option<Number>,
}

#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::io) enum LossToml {
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
pub(in crate::io) enum OptimiserToml {
    Adam,
    Plain,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct DescentToml {
    pub(in crate::io) optimiser: Option<OptimiserToml>,
    pub(in crate::io) steps: Option<Number>,
    pub(in crate::io) rate: Option<Number>,
    pub(in crate::io) contacts: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::io) struct EstimateToml {
    pub(in crate::io) parameters: Vec<Text>,
    #[serde(default)]
    pub(in crate::io) loss: LossToml,
    pub(in crate::io) loss_scale: Option<Number>,
    #[serde(default)]
    pub(in crate::io) freeze: Vec<Text>,
    #[serde(default)]
    pub(in crate::io) prior: PriorToml,
    pub(in crate::io) method: Option<Text>,
    pub(in crate::io) descent: Option<Spanned<DescentToml>>,
}

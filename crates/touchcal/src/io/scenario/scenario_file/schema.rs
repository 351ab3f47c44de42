//! The tables and keys of `scenario.toml`, as written. Robot and tool are described as in
//! `problem.toml`.

use serde::Deserialize;
use toml::{Spanned, Value};

use crate::io::problem::problem_file::schema::{
    FixtureKind, FixtureToml, LengthUnitToml, Number, PoseToml, RobotToml, Text, ToolToml,
};

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScenarioToml {
    pub(super) schema: Option<Spanned<i64>>,
    pub(super) preset: Option<Text>,
    pub(super) contacts: Option<Number>,
    pub(super) friction: Option<Number>,
    pub(super) contact_mm: Option<Number>,
    pub(super) robot: Option<Spanned<RobotToml>>,
    #[serde(default)]
    pub(super) errors: ErrorsToml,
    pub(super) tool: Option<Spanned<ToolToml>>,
    #[serde(default)]
    pub(super) fixture: Vec<Spanned<TouchToml>>,
    #[serde(default)]
    pub(super) distance: Vec<Spanned<DistanceToml>>,
    #[serde(default)]
    pub(super) exploration: ExplorationToml,
    #[serde(default)]
    pub(super) stiffness: StiffnessToml,
    #[serde(default)]
    pub(super) recorder: RecorderToml,
    #[serde(default)]
    pub(super) thermal: ThermalToml,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ErrorsToml {
    pub(super) distribution: Option<Text>,
    pub(super) strain: Option<Number>,
    pub(super) segment_strain: Option<Number>,
    pub(super) joint_offset_deg: Option<Number>,
    pub(super) origin_mm: Option<Number>,
    pub(super) origin_deg: Option<Number>,
    pub(super) origin_zero_deg: Option<Number>,
    pub(super) joint_compliance_rad_per_nm: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TouchToml {
    pub(super) name: Text,
    pub(super) kind: FixtureKind,
    pub(super) base_from_fixture: Spanned<PoseToml>,
    pub(super) outline: Option<Text>,
    pub(super) outline_name: Option<Text>,
    pub(super) outline_unit: Option<Spanned<LengthUnitToml>>,
    pub(super) outline_offset_mm: Option<Number>,
    pub(super) builtin: Option<Text>,
    /// Refused, with a word of why.
    pub(super) mesh: Option<Text>,
    pub(super) mesh_unit: Option<Spanned<LengthUnitToml>>,
    pub(super) depth_mm: Option<Number>,
    pub(super) edge_radius_mm: Option<Number>,
    pub(super) sigma_mm: Option<Number>,
    pub(super) sigma_deg: Option<Number>,
    #[serde(default)]
    pub(super) free: bool,
    pub(super) clearance_sigma_mm: Option<Number>,
    pub(super) depth_sigma_mm: Option<Number>,
    pub(super) edge_radius_sigma_mm: Option<Number>,
    pub(super) unequal_clearance_sigma_mm: Option<Number>,
    pub(super) edge_wear_mm: Option<Number>,
    pub(super) exact: Option<Spanned<Value>>,
    pub(super) postures_deg: Spanned<Vec<Vec<f64>>>,
    #[serde(default)]
    pub(super) exploration: ExplorationToml,
}

impl TouchToml {
    /// The fixture as `problem.toml` would describe it, without how well it is known.
    pub(super) fn fixture(table: &Spanned<TouchToml>) -> Spanned<FixtureToml> {
        let touch = table.get_ref();
        let fixture = FixtureToml {
            name: touch.name.clone(),
            kind: touch.kind,
            placement: None,
            base_from_fixture: None,
            outline: touch.outline.clone(),
            outline_name: touch.outline_name.clone(),
            outline_unit: touch.outline_unit.clone(),
            outline_offset_mm: touch.outline_offset_mm.clone(),
            builtin: touch.builtin.clone(),
            mesh: None,
            mesh_unit: None,
            depth_mm: touch.depth_mm.clone(),
            edge_radius_mm: touch.edge_radius_mm.clone(),
            manifold: None,
            samples: None,
            weights: None,
            neighbours: None,
            mm_per_deg: None,
            sigma_mm: None,
            sigma_deg: None,
            clearance_sigma_mm: None,
            depth_sigma_mm: None,
            edge_radius_sigma_mm: None,
            free: false,
            exact: None,
        };
        Spanned::new(table.span(), fixture)
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DistanceToml {
    pub(super) between: [Text; 2],
    /// Refused, with a word of why.
    pub(super) mm: Option<Number>,
    pub(super) sigma_mm: Option<Number>,
    pub(super) exact: Option<Spanned<Value>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExplorationToml {
    pub(super) radius_mm: Option<Number>,
    pub(super) tilt_deg: Option<Number>,
    pub(super) press_mm: Option<Number>,
    pub(super) lift_mm: Option<Number>,
    pub(super) swing_deg: Option<Number>,
    pub(super) pace: Option<Number>,
    pub(super) random_phases: Option<bool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StiffnessToml {
    pub(super) n_per_m: Option<Number>,
    pub(super) nm_per_rad: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RecorderToml {
    pub(super) rate_hz: Option<Number>,
    pub(super) encoder_deg: Option<Number>,
    pub(super) encoder_step_deg: Option<Number>,
    pub(super) encoder_trend_deg: Option<Number>,
    pub(super) warm_up_k: Option<Number>,
    pub(super) encoder_walk_deg: Option<Number>,
    pub(super) force_lag_s: Option<Number>,
    pub(super) force_sigma_n: Option<Number>,
    pub(super) torque_sigma_nm: Option<Number>,
    pub(super) force_bias_n: Option<Number>,
    pub(super) torque_bias_nm: Option<Number>,
    pub(super) wrench_scale: Option<Number>,
    pub(super) force_threshold_n: Option<Number>,
    pub(super) missed: Option<Number>,
    pub(super) spurious: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThermalToml {
    pub(super) expansion_per_k: Option<Number>,
    pub(super) reference_c: Option<Number>,
    pub(super) sensor_sigma_k: Option<Number>,
}

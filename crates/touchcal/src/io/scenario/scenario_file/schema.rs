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
    /// Version of the format. Without it: 1.
    /// Example: `schema = 1`
    pub(super) schema: Option<Spanned<i64>>,
    /// Built-in scenario from which all is taken that the file leaves out. One of: `paper`,
    /// `leo_aluminium`, `leo_cfrp`, `workcell`, `mukca`. Without it: `paper`, with an arm without
    /// errors.
    /// Example: `preset = "workcell"`
    pub(super) preset: Option<Text>,
    /// Number of contacts with each fixture. Without it: as in the preset.
    /// Example: `contacts = 3000`
    pub(super) contacts: Option<Number>,
    /// Coefficient of friction between tool and fixture. Without it: as in the preset.
    /// Example: `friction = 0.1`
    pub(super) friction: Option<Number>,
    /// Standard deviation of form errors: by how much each touched surface stands out in each row.
    /// Without it: as in the preset.
    /// Example: `contact_mm = 0.01`
    pub(super) contact_mm: Option<Number>,
    /// The nominal arm, as in `problem.toml`; `iiwa14` without this table.
    pub(super) robot: Option<Spanned<RobotToml>>,
    /// Sizes of the arm's errors.
    #[serde(default)]
    pub(super) errors: ErrorsToml,
    /// What touches the fixtures, as in `problem.toml`, but for meshes and `free`; `sigma_mm` and
    /// `sigma_deg` are the sizes of its true error, 0 without them.
    pub(super) tool: Option<Spanned<ToolToml>>,
    /// What is touched, a table each, with standard deviations as sizes of true errors.
    #[serde(default)]
    pub(super) fixture: Vec<Spanned<TouchToml>>,
    /// Distances between fixtures that are measured, a table each.
    #[serde(default)]
    pub(super) distance: Vec<Spanned<MeasuredDistanceToml>>,
    /// Motion of the command at all fixtures; without it as in the preset.
    #[serde(default)]
    pub(super) exploration: ExplorationToml,
    /// Stiffness of the arm under impedance control, at the tool.
    #[serde(default)]
    pub(super) stiffness: StiffnessToml,
    /// Encoders, force sensor and detection of contact.
    #[serde(default)]
    pub(super) recorder: RecorderToml,
    /// Temperatures of the arm's segments, recorded where `expansion_per_k` is above 0.
    #[serde(default)]
    pub(super) thermal: ThermalToml,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ErrorsToml {
    /// Distribution from which errors are drawn: plus or minus the size, uniformly between these,
    /// or with the size as standard deviation. One of: `sign`, `uniform`, `normal`. Without it: as
    /// in the preset, `uniform` without one.
    /// Example: `distribution = "normal"`
    pub(super) distribution: Option<Text>,
    /// Size of the strain common to all links. Without it: as in the preset, 0 without one.
    /// Example: `strain = 0.001`
    pub(super) strain: Option<Number>,
    /// Size of the strain of each segment, on top of the common one. Without it: as in the preset,
    /// 0 without one.
    /// Example: `segment_strain = 0.0005`
    pub(super) segment_strain: Option<Number>,
    /// Size of each joint's encoder offset (of a prismatic joint: the same angle at a metre).
    /// Without it: as in the preset, 0 without one.
    /// Example: `joint_offset_deg = 0.3`
    pub(super) joint_offset_deg: Option<Number>,
    /// Size of each translation of a joint's origin. Without it: as in the preset, 0 without one.
    /// Example: `origin_mm = 0.5`
    pub(super) origin_mm: Option<Number>,
    /// Size of each rotation of a joint's origin across its axis. Without it: as in the preset, 0
    /// without one.
    /// Example: `origin_deg = 0.1`
    pub(super) origin_deg: Option<Number>,
    /// Size of the rotation of a joint's origin about its axis. Without it: as in the preset, 0
    /// without one.
    /// Example: `origin_zero_deg = 0.5`
    pub(super) origin_zero_deg: Option<Number>,
    /// Compliance of each turning joint under gravity and load; not drawn. Without it: as in the
    /// preset, 0 without one.
    /// Example: `joint_compliance_rad_per_nm = 1e-5`
    pub(super) joint_compliance_rad_per_nm: Option<Number>,
    /// Half of the play of each joint, which rests at the side to which gravity and load push it
    /// (of a prismatic joint: the same angle at a metre); not drawn. Without it: as in the preset,
    /// 0 without one. Example: `joint_backlash_deg = 0.02`
    pub(super) joint_backlash_deg: Option<Number>,
    /// Size of each amplitude of a harmonic of once a turn in the encoder of each turning joint.
    /// Without it: as in the preset, 0 without one.
    /// Example: `joint_harmonic_deg = 0.01`
    pub(super) joint_harmonic_deg: Option<Number>,
    /// The same of twice a turn. Without it: as in the preset, 0 without one.
    /// Example: `joint_harmonic_2_deg = 0.01`
    pub(super) joint_harmonic_2_deg: Option<Number>,
    /// Size of the relative error of the ratio between encoder and joint. Without it: as in the
    /// preset, 0 without one.
    /// Example: `joint_gear_ratio = 1e-4`
    pub(super) joint_gear_ratio: Option<Number>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TouchToml {
    /// Name, unique in the file; `A/0` and `A/1` stand on one block, displaced as a whole.
    /// Example: `name = "hole"`
    pub(super) name: Text,
    /// Kind of fixture.
    /// Example: `kind = "hole"`
    pub(super) kind: FixtureKind,
    /// Nominal pose of the fixture in the base frame.
    /// Example: `base_from_fixture = { xyz_mm = [600, 100, 150] }`
    pub(super) base_from_fixture: Spanned<PoseToml>,
    /// Drawing of a hole's section: CSV with `x_mm,y_mm`, SVG or DXF. Without it: that of the peg,
    /// larger by `outline_offset_mm`.
    /// Example: `outline = "hole.dxf"`
    pub(super) outline: Option<Text>,
    /// The outline in a drawing of several. Without it: the only closed outline.
    /// Example: `outline_name = "hole"`
    pub(super) outline_name: Option<Text>,
    /// Unit of a drawing that does not state it. Without it: as the drawing states.
    /// Example: `outline_unit = "mm"`
    pub(super) outline_unit: Option<Spanned<LengthUnitToml>>,
    /// Instead of a section of its own: by how much the hole's is larger than the peg's, on each
    /// side. Without it: the hole's own section is required.
    /// Example: `outline_offset_mm = 0.5`
    pub(super) outline_offset_mm: Option<Number>,
    /// Instead of a drawing: a built-in section. One of: `extrusion25`. Without it: that of the
    /// peg, larger by `outline_offset_mm`.
    /// Example: `builtin = "extrusion25"`
    pub(super) builtin: Option<Text>,
    /// Refused: meshes are not simulated. Without it: none.
    pub(super) mesh: Option<Text>,
    /// Refused: meshes are not simulated. Without it: none.
    pub(super) mesh_unit: Option<Spanned<LengthUnitToml>>,
    /// Depth of a hole. Without it: required for a hole.
    /// Example: `depth_mm = 30`
    pub(super) depth_mm: Option<Number>,
    /// Radius of a hole's edges. Without it: 0.
    /// Example: `edge_radius_mm = 0.2`
    pub(super) edge_radius_mm: Option<Number>,
    /// Standard deviation of each component of the error of the fixture's position. Without it: 0.
    /// Example: `sigma_mm = 1`
    pub(super) sigma_mm: Option<Number>,
    /// Standard deviation of each component of the error of its rotation. Without it: 0.
    /// Example: `sigma_deg = 0.2`
    pub(super) sigma_deg: Option<Number>,
    /// Whether `problem.toml` states no pose of a socket. Without it: false.
    /// Example: `free = true`
    #[serde(default)]
    pub(super) free: bool,
    /// Standard deviation of how much wider the true hole is, on each side. Without it: 0.
    /// Example: `clearance_sigma_mm = 0.02`
    pub(super) clearance_sigma_mm: Option<Number>,
    /// Standard deviation of how much deeper the true hole is. Without it: 0.
    /// Example: `depth_sigma_mm = 0.02`
    pub(super) depth_sigma_mm: Option<Number>,
    /// Standard deviation of a normal number whose absolute value is the radius by which edges are
    /// worn further. Without it: 0.
    /// Example: `edge_radius_sigma_mm = 0.05`
    pub(super) edge_radius_sigma_mm: Option<Number>,
    /// Standard deviation of how much wider the true hole is along x than along y, on each side.
    /// Without it: 0.
    /// Example: `unequal_clearance_sigma_mm = 0.01`
    pub(super) unequal_clearance_sigma_mm: Option<Number>,
    /// Radius by which the edges of peg and hole are worn beyond the declared. Without it: 0.
    /// Example: `edge_wear_mm = 0.05`
    pub(super) edge_wear_mm: Option<Number>,
    /// What `problem.toml` declares exact, as there. Without it: nothing.
    /// Example: `exact = ["depth"]`
    pub(super) exact: Option<Spanned<Value>>,
    /// Joint positions near which to work, each in turn (mm for prismatic joints).
    /// Example: `postures_deg = [[0, 40, 0, -90, 0, 50, 0]]`
    pub(super) postures_deg: Spanned<Vec<Vec<f64>>>,
    /// Motion of the command at this fixture, where it differs from that of `[exploration]`.
    /// Example: `exploration = { lift_mm = 8 }`
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
            along_normal: None,
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
pub(super) struct MeasuredDistanceToml {
    /// Names of the two fixtures.
    /// Example: `between = ["A/0", "A/1"]`
    pub(super) between: [Text; 2],
    /// Refused: the true distance follows from the poses. Without it: none.
    pub(super) mm: Option<Number>,
    /// Standard deviation of the error of the measurement. Without it: 0.1.
    /// Example: `sigma_mm = 0.01`
    pub(super) sigma_mm: Option<Number>,
    /// Whether the measurement is exact. Without it: false.
    /// Example: `exact = true`
    pub(super) exact: Option<Spanned<Value>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExplorationToml {
    /// Largest radius of the spiral in x and y. Without it: as in the preset.
    /// Example: `radius_mm = 4`
    pub(super) radius_mm: Option<Number>,
    /// Amplitude of each component of the rotation. Without it: as in the preset.
    /// Example: `tilt_deg = 5`
    pub(super) tilt_deg: Option<Number>,
    /// Distance of the command beyond the deepest pose. Without it: as in the preset.
    /// Example: `press_mm = 6`
    pub(super) press_mm: Option<Number>,
    /// Height of the command's upper end above first touch; above 0 the tool leaves the fixture
    /// between presses. Without it: as in the preset.
    /// Example: `lift_mm = 8`
    pub(super) lift_mm: Option<Number>,
    /// Amplitude of the swing of redundant joints about their posture. Without it: as in the
    /// preset.
    /// Example: `swing_deg = 6`
    pub(super) swing_deg: Option<Number>,
    /// Frequency of the motion over the built-in one, above 0 and at most 1000. Without it: as in
    /// the preset.
    /// Example: `pace = 0.5`
    pub(super) pace: Option<Number>,
    /// Whether each trial follows a path of its own. Without it: as in the preset.
    /// Example: `random_phases = true`
    pub(super) random_phases: Option<bool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StiffnessToml {
    /// Of translations (N/m). Without it: as in the preset.
    /// Example: `n_per_m = 3000`
    pub(super) n_per_m: Option<Number>,
    /// Of rotations (N m/rad). Without it: as in the preset.
    /// Example: `nm_per_rad = 50`
    pub(super) nm_per_rad: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RecorderToml {
    /// Rows per second. Without it: as in the preset.
    /// Example: `rate_hz = 100`
    pub(super) rate_hz: Option<Number>,
    /// Standard deviation of each encoder's noise in each row. Without it: as in the preset.
    /// Example: `encoder_deg = 0.002`
    pub(super) encoder_deg: Option<Number>,
    /// Step of the encoders; 0 for none. Without it: as in the preset.
    /// Example: `encoder_step_deg = 0.001`
    pub(super) encoder_step_deg: Option<Number>,
    /// Standard deviation of half the change of each turning joint's encoder offset over the trial.
    /// Without it: as in the preset.
    /// Example: `encoder_trend_deg = 0.01`
    pub(super) encoder_trend_deg: Option<Number>,
    /// Temperature by which the arm warms up from 20 °C over the trial, recorded if above 0.
    /// Without it: as in the preset.
    /// Example: `warm_up_k = 10`
    pub(super) warm_up_k: Option<Number>,
    /// Standard deviation of a random walk of each turning joint's encoder offset, from the first
    /// to the last contact. Without it: as in the preset.
    /// Example: `encoder_walk_deg = 0.01`
    pub(super) encoder_walk_deg: Option<Number>,
    /// Time constant of the force sensor's first-order low-pass filter; 0 for none. Without it: as
    /// in the preset.
    /// Example: `force_lag_s = 0.01`
    pub(super) force_lag_s: Option<Number>,
    /// Standard deviation of the noise of each component of the force in each row. Without it: as
    /// in the preset.
    /// Example: `force_sigma_n = 0.2`
    pub(super) force_sigma_n: Option<Number>,
    /// Standard deviation of the noise of each component of the torque in each row. Without it: as
    /// in the preset.
    /// Example: `torque_sigma_nm = 0.01`
    pub(super) torque_sigma_nm: Option<Number>,
    /// Standard deviation of the bias of each component of the force, drawn once a trial. Without
    /// it: as in the preset.
    /// Example: `force_bias_n = 0.2`
    pub(super) force_bias_n: Option<Number>,
    /// Standard deviation of the bias of each component of the torque, drawn once a trial. Without
    /// it: as in the preset.
    /// Example: `torque_bias_nm = 0.02`
    pub(super) torque_bias_nm: Option<Number>,
    /// Standard deviation of the relative error of the wrench's scale, drawn once a trial. Without
    /// it: as in the preset.
    /// Example: `wrench_scale = 0.02`
    pub(super) wrench_scale: Option<Number>,
    /// Standard deviation of the noise of each joint's torque in each row; above 0 the torques are
    /// recorded, and take the place of the load in `problem.toml`. Without it: as in the preset.
    /// Example: `tau_joint_sigma_nm = 0.1`
    pub(super) tau_joint_sigma_nm: Option<Number>,
    /// Measured force above which a row counts as contact. Without it: as in the preset.
    /// Example: `force_threshold_n = 3`
    pub(super) force_threshold_n: Option<Number>,
    /// Share of the rows in contact that are recorded as free, 0 to below 1. Without it: as in the
    /// preset.
    /// Example: `missed = 0.05`
    pub(super) missed: Option<Number>,
    /// Share of the rows recorded as contact without any, 0 to below 1. Without it: as in the
    /// preset.
    /// Example: `spurious = 0.05`
    pub(super) spurious: Option<Number>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ThermalToml {
    /// Coefficient of thermal expansion (1/K). Without it: as in the preset.
    /// Example: `expansion_per_k = 2.3e-5`
    pub(super) expansion_per_k: Option<Number>,
    /// Temperature at which the arm has its nominal lengths (°C). Without it: as in the preset.
    /// Example: `reference_c = 20`
    pub(super) reference_c: Option<Number>,
    /// Standard deviation of the noise of each recorded temperature. Without it: as in the preset.
    /// Example: `sensor_sigma_k = 0.5`
    pub(super) sensor_sigma_k: Option<Number>,
}

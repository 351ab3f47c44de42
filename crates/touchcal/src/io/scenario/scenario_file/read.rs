//! Reads `scenario.toml`.

use std::path::Path;

use toml::Spanned;

use super::declared::{distances, set_errors, tool_error};
use super::schema::{ErrorsToml, ExplorationToml, RecorderToml, ScenarioToml, StiffnessToml, ThermalToml, TouchToml};
use crate::io::base::bytes;
use crate::io::base::error::{IoError, Place, quoted, shown_number};
use crate::io::base::suggest::{did_you_mean, list};
use crate::io::problem::problem_file::context::{Allowed, Context, DEG, MM};
use crate::io::problem::problem_file::schema::{Number, Text};
use crate::io::problem::problem_file::touch::Shape;
use crate::io::problem::problem_file::{self, Assumptions};
use crate::io::robot::urdf::{self, Ends};
use crate::robot::{JointKind, Robot};
use crate::sim::{ArmErrors, Distribution, Exploration, PlaceError, Preset, Scenario, Stiffness, Thermal, Touch};

/// Largest scenario file read (bytes), 4 MiB.
pub const MAX_BYTES: u64 = 4 << 20;
/// Most contacts logged with one fixture.
const MOST_CONTACTS: f64 = 1e6;
/// The arm of a scenario that names none.
const ARM: &str = "iiwa14";
/// Largest joint position (degrees or mm).
const LARGEST_POSITION: f64 = 1e4;
/// Highest rate (Hz).
const FASTEST: f64 = 1e5;

/// A scenario, and the robot description it was read with.
#[derive(Clone, Debug)]
pub struct ScenarioFile {
    /// What to simulate.
    pub scenario: Scenario,
    /// Name of the built-in arm, see [`builtin::ALL`](crate::robot::builtin::ALL); `None` if the
    /// robot is read from a URDF file.
    pub builtin: Option<String>,
    /// Whole text of the robot's URDF.
    pub urdf: String,
}

/// The scenario of a preset, by its name ([`Preset::name`]), with the built-in arm `iiwa14`.
///
/// # Errors
/// [`IoError::Unexpected`] if there is no preset of that name.
pub fn preset(name: &str) -> Result<ScenarioFile, IoError> {
    read(&format!("preset = {name:?}"), "preset", Path::new(""))
}

/// Reads a scenario file, with paths relative to its folder.
///
/// # Errors
/// As [`read`], and if the file itself cannot be read.
pub fn read_file(path: &Path) -> Result<ScenarioFile, IoError> {
    let (text, input) = bytes::read_text(path, MAX_BYTES)?;
    read(&text, &input.path, path.parent().unwrap_or(Path::new("")))
}

/// Reads a scenario from its text. `file` is its name for messages; relative paths begin at
/// `folder`. Lengths and angles are converted to m and rad. What the text leaves out is as in its
/// preset; without one, as in [`Preset::Paper`], but with an arm that has no errors. Without a
/// `[robot]` table the arm is `iiwa14`.
///
/// # Errors
/// [`IoError`] if the text is longer than [`MAX_BYTES`], no TOML, of another schema than 1, or has
/// an unknown key, a name that does not resolve, a number out of range, standard deviations of what
/// is exact, a tool without fixtures or fixtures without a tool, a mesh, the length of a distance,
/// or postures for another number of joints; or a file it refers to cannot be read.
pub fn read(text: &str, file: &str, folder: &Path) -> Result<ScenarioFile, IoError> {
    let context = Context { text, file, folder };
    bytes::check_size(text.len() as u64, MAX_BYTES, file)?;
    let toml: ScenarioToml = toml::from_str(text).map_err(|error| context.syntax(&error))?;
    if let Some(schema) = toml.schema.as_ref().filter(|schema| *schema.get_ref() != 1) {
        let place = context.place(schema.span(), "schema");
        return Err(IoError::unexpected(place, "schema 1", format!("{}", schema.get_ref())));
    }
    let builtin = match &toml.robot {
        None => Some(ARM.to_owned()),
        Some(robot) => robot.get_ref().builtin.as_ref().map(|name| name.get_ref().clone()),
    };
    let robot = match &toml.robot {
        None => urdf::read_builtin(ARM, Ends::default())?,
        Some(table) => problem_file::robot(table, &context)?,
    };
    let scenario = scenario(&toml, robot.robot, &context)?;
    Ok(ScenarioFile { scenario, builtin, urdf: robot.text })
}

fn scenario(toml: &ScenarioToml, robot: Robot, context: &Context<'_>) -> Result<Scenario, IoError> {
    let named = toml.preset.as_ref().map(|name| chosen(name, &Preset::ALL, |preset| preset.name(), context, "preset"));
    let start = match named.transpose()? {
        Some(preset) => preset.scenario(robot),
        // Without a preset nothing is wrong but what the file says.
        None => Preset::Paper.scenario(robot).map(|paper| Scenario { errors: ArmErrors::NONE, ..paper }),
    };
    let parts = |error: crate::sim::PartsError| IoError::syntax(Place::file(context.file), error.to_string());
    let mut scenario = start.map_err(parts)?;
    if let Some(contacts) = context.whole(toml.contacts.as_ref(), MOST_CONTACTS, "contacts")? {
        scenario.contacts = contacts;
    }
    set(&mut scenario.friction, &toml.friction, 1.0, "friction", context)?;
    set(&mut scenario.contact_sigma, &toml.contact_mm, MM, "contact_mm", context)?;
    errors(&mut scenario.errors, &toml.errors, context)?;
    stiffness(&mut scenario.stiffness, &toml.stiffness, context)?;
    recorder(&mut scenario, &toml.recorder, context)?;
    thermal(&mut scenario.thermal, &toml.thermal, context)?;
    for touch in &mut scenario.touches {
        exploration(&mut touch.exploration, &toml.exploration, "exploration", context)?;
    }
    touches(&mut scenario, toml, context)?;
    scenario.distances = distances(&toml.distance, &scenario.touches, context)?;
    let dof = scenario.robot.dof();
    match scenario.touches.iter().find(|touch| touch.postures.iter().any(|posture| posture.len() != dof)) {
        None => Ok(scenario),
        Some(touch) => {
            let expected = format!("[[fixture]] tables with postures of {dof} joints, as the robot has");
            let found = format!("those of `{}`, for another arm", touch.name);
            Err(IoError::unexpected(Place::file(context.file), expected, found))
        }
    }
}

/// The one of `known` that a text names.
fn chosen<T: Copy>(
    text: &Text,
    known: &[T],
    name: impl Fn(T) -> &'static str,
    context: &Context<'_>,
    field: &str,
) -> Result<T, IoError> {
    known.iter().copied().find(|&one| name(one) == text.get_ref()).ok_or_else(|| {
        let names = || known.iter().map(|&one| name(one));
        let found = format!("{}{}", quoted(text.get_ref()), did_you_mean(text.get_ref(), names()));
        IoError::unexpected(context.place(text.span(), field), list(names()), found)
    })
}

/// Takes a number of at least 0 over, times `unit`, if it is there.
fn set(value: &mut f64, number: &Option<Number>, unit: f64, field: &str, context: &Context<'_>) -> Result<(), IoError> {
    if let Some(number) = context.number(number.as_ref(), unit, Allowed::NotNegative, field)? {
        *value = number;
    }
    Ok(())
}

/// The same for a number above 0 and at most `most`.
fn set_positive(
    value: &mut f64,
    number: &Option<Number>,
    (unit, most): (f64, f64),
    field: &str,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let Some(given) = context.number(number.as_ref(), 1.0, Allowed::Positive, field)? else { return Ok(()) };
    if given > most {
        let place = context.place(number.as_ref().map_or(0..0, Spanned::span), field);
        return Err(IoError::unexpected(place, format!("a number of at most {most}"), format!("{given}")));
    }
    *value = given * unit;
    Ok(())
}

/// The same for a share, which stays below 1.
fn set_share(value: &mut f64, number: &Option<Number>, field: &str, context: &Context<'_>) -> Result<(), IoError> {
    set(value, number, 1.0, field, context)?;
    if *value < 1.0 {
        return Ok(());
    }
    let place = context.place(number.as_ref().map_or(0..0, Spanned::span), field);
    Err(IoError::unexpected(place, "a share from 0 to below 1", shown_number(*value)))
}

fn errors(errors: &mut ArmErrors, toml: &ErrorsToml, context: &Context<'_>) -> Result<(), IoError> {
    if let Some(name) = &toml.distribution {
        errors.distribution =
            chosen(name, &Distribution::ALL, |distribution| distribution.name(), context, "errors, distribution")?;
    }
    set(&mut errors.strain, &toml.strain, 1.0, "errors, strain", context)?;
    set(&mut errors.segment_strain, &toml.segment_strain, 1.0, "errors, segment_strain", context)?;
    set(&mut errors.joint_offset, &toml.joint_offset_deg, DEG, "errors, joint_offset_deg", context)?;
    set(&mut errors.origin_length, &toml.origin_mm, MM, "errors, origin_mm", context)?;
    set(&mut errors.origin_angle, &toml.origin_deg, DEG, "errors, origin_deg", context)?;
    set(&mut errors.origin_zero, &toml.origin_zero_deg, DEG, "errors, origin_zero_deg", context)?;
    let compliance = &toml.joint_compliance_rad_per_nm;
    set(&mut errors.joint_compliance, compliance, 1.0, "errors, joint_compliance_rad_per_nm", context)?;
    set(&mut errors.joint_backlash, &toml.joint_backlash_deg, DEG, "errors, joint_backlash_deg", context)?;
    set(&mut errors.joint_harmonic, &toml.joint_harmonic_deg, DEG, "errors, joint_harmonic_deg", context)?;
    set(&mut errors.joint_harmonic_2, &toml.joint_harmonic_2_deg, DEG, "errors, joint_harmonic_2_deg", context)?;
    set(&mut errors.joint_gear_ratio, &toml.joint_gear_ratio, 1.0, "errors, joint_gear_ratio", context)
}

fn stiffness(stiffness: &mut Stiffness, toml: &StiffnessToml, context: &Context<'_>) -> Result<(), IoError> {
    set_positive(&mut stiffness.translation, &toml.n_per_m, (1.0, 1e6), "stiffness, n_per_m", context)?;
    set_positive(&mut stiffness.rotation, &toml.nm_per_rad, (1.0, 1e6), "stiffness, nm_per_rad", context)
}

fn recorder(scenario: &mut Scenario, toml: &RecorderToml, context: &Context<'_>) -> Result<(), IoError> {
    let recorder = &mut scenario.recorder;
    set_positive(&mut recorder.rate, &toml.rate_hz, (1.0, FASTEST), "recorder, rate_hz", context)?;
    set(&mut recorder.encoder_sigma, &toml.encoder_deg, DEG, "recorder, encoder_deg", context)?;
    set(&mut recorder.encoder_step, &toml.encoder_step_deg, DEG, "recorder, encoder_step_deg", context)?;
    set(&mut recorder.encoder_trend, &toml.encoder_trend_deg, DEG, "recorder, encoder_trend_deg", context)?;
    set(&mut recorder.warm_up, &toml.warm_up_k, 1.0, "recorder, warm_up_k", context)?;
    set(&mut recorder.encoder_walk, &toml.encoder_walk_deg, DEG, "recorder, encoder_walk_deg", context)?;
    set(&mut recorder.force_lag, &toml.force_lag_s, 1.0, "recorder, force_lag_s", context)?;
    set(&mut recorder.force_sigma, &toml.force_sigma_n, 1.0, "recorder, force_sigma_n", context)?;
    set(&mut recorder.torque_sigma, &toml.torque_sigma_nm, 1.0, "recorder, torque_sigma_nm", context)?;
    set(&mut recorder.force_bias, &toml.force_bias_n, 1.0, "recorder, force_bias_n", context)?;
    set(&mut recorder.torque_bias, &toml.torque_bias_nm, 1.0, "recorder, torque_bias_nm", context)?;
    set(&mut recorder.wrench_scale, &toml.wrench_scale, 1.0, "recorder, wrench_scale", context)?;
    set(&mut recorder.joint_torque_sigma, &toml.tau_joint_sigma_nm, 1.0, "recorder, tau_joint_sigma_nm", context)?;
    let threshold = &toml.force_threshold_n;
    set_positive(&mut recorder.force_threshold, threshold, (1.0, 1e6), "recorder, force_threshold_n", context)?;
    set_share(&mut recorder.missed, &toml.missed, "recorder, missed", context)?;
    set_share(&mut recorder.spurious, &toml.spurious, "recorder, spurious", context)
}

fn thermal(thermal: &mut Option<Thermal>, toml: &ThermalToml, context: &Context<'_>) -> Result<(), IoError> {
    let mut given = thermal.unwrap_or(Thermal::NONE);
    set(&mut given.expansion, &toml.expansion_per_k, 1.0, "thermal, expansion_per_k", context)?;
    set(&mut given.reference, &toml.reference_c, 1.0, "thermal, reference_c", context)?;
    set(&mut given.sensor_sigma, &toml.sensor_sigma_k, 1.0, "thermal, sensor_sigma_k", context)?;
    *thermal = Some(given).filter(|thermal| thermal.expansion > 0.0);
    Ok(())
}

fn exploration(
    exploration: &mut Exploration,
    toml: &ExplorationToml,
    field: &str,
    context: &Context<'_>,
) -> Result<(), IoError> {
    let named = |key: &str| format!("{field}, {key}");
    set(&mut exploration.radius, &toml.radius_mm, MM, &named("radius_mm"), context)?;
    set(&mut exploration.tilt, &toml.tilt_deg, DEG, &named("tilt_deg"), context)?;
    set(&mut exploration.press, &toml.press_mm, MM, &named("press_mm"), context)?;
    set(&mut exploration.lift, &toml.lift_mm, MM, &named("lift_mm"), context)?;
    set(&mut exploration.swing, &toml.swing_deg, DEG, &named("swing_deg"), context)?;
    exploration.random_phases = toml.random_phases.unwrap_or(exploration.random_phases);
    set_positive(&mut exploration.pace, &toml.pace, (1.0, 1e3), &named("pace"), context)
}

/// Tool and fixtures, where the file describes its own.
fn touches(scenario: &mut Scenario, toml: &ScenarioToml, context: &Context<'_>) -> Result<(), IoError> {
    let Some(tool) = &toml.tool else {
        return match toml.fixture.first() {
            None => Ok(()),
            Some(fixture) => {
                let place = context.place(fixture.span(), "fixture");
                Err(IoError::unexpected(place, "a [tool] table that touches the fixtures", "none"))
            }
        };
    };
    if toml.fixture.is_empty() {
        let place = context.place(tool.span(), "tool");
        return Err(IoError::unexpected(place, "[[fixture]] tables that the tool touches", "none"));
    }
    no_meshes(toml, context)?;
    let mut inputs = Vec::new();
    let shape = Shape::of(tool, context, (&mut inputs, &mut Assumptions::default()))?;
    let given = tool.get_ref();
    scenario.tip_from_tool = context.pose(given.tip_from_tool.as_ref(), "tool, tip_from_tool")?.unwrap_or_default();
    if given.free {
        let place = context.place(tool.span(), "tool, free");
        return Err(IoError::unexpected(place, "sigma_mm and sigma_deg, how far the tool may be off", "free"));
    }
    scenario.tool_error = tool_error(tool, context)?;
    let usual = scenario.touches.first().map(|touch| touch.exploration);
    let usual = usual.ok_or_else(|| IoError::unexpected(Place::file(context.file), "a fixture", "none"))?;
    scenario.touches.clear();
    for table in &toml.fixture {
        let name = &table.get_ref().name;
        if scenario.touches.iter().any(|touch| touch.name == *name.get_ref()) {
            let found = format!("{} twice", quoted(name.get_ref()));
            return Err(IoError::unexpected(context.place(name.span(), "fixture, name"), "distinct names", found));
        }
        let parts = shape.parts(&TouchToml::fixture(table), context, &mut inputs)?;
        let touch = table.get_ref();
        let field = format!("fixture `{}`", name.get_ref());
        let place = context.pose(Some(&touch.base_from_fixture), &format!("{field}, base_from_fixture"))?;
        let mut described = Touch {
            name: name.get_ref().clone(),
            base_from_fixture: place.unwrap_or_default(),
            place_error: PlaceError::default(),
            free: touch.free,
            parts,
            clearance_sigma: 0.0,
            depth_sigma: 0.0,
            unequal_clearance_sigma: 0.0,
            edge_wear: 0.0,
            edge_radius_sigma: 0.0,
            postures: postures(touch, &scenario.robot, &field, context)?,
            exploration: usual,
        };
        set_errors(&mut described, table, &scenario.touches, context)?;
        exploration(&mut described.exploration, &touch.exploration, &format!("{field}, exploration"), context)?;
        scenario.touches.push(described);
    }
    Ok(())
}

/// The simulator has outlines alone.
fn no_meshes(toml: &ScenarioToml, context: &Context<'_>) -> Result<(), IoError> {
    let key = |mesh: &Option<Text>, unit: &Option<Spanned<_>>| {
        mesh.as_ref().map(Spanned::span).or(unit.as_ref().map(Spanned::span))
    };
    let tool = toml.tool.iter().map(|tool| (key(&tool.get_ref().mesh, &tool.get_ref().mesh_unit), "tool".to_owned()));
    let fixtures = toml.fixture.iter().map(|table| {
        let touch = table.get_ref();
        (key(&touch.mesh, &touch.mesh_unit), format!("fixture `{}`", touch.name.get_ref()))
    });
    match tool.chain(fixtures).find_map(|(span, field)| Some((span?, field))) {
        None => Ok(()),
        Some((span, field)) => {
            let expected = "`outline` or `builtin`: meshes can be calibrated with, but not simulated";
            Err(IoError::unexpected(context.place(span, field), expected, "a mesh"))
        }
    }
}

/// Joint positions in degrees, in millimetres where a joint slides.
fn postures(touch: &TouchToml, robot: &Robot, field: &str, context: &Context<'_>) -> Result<Vec<Vec<f64>>, IoError> {
    let units: Vec<f64> =
        robot.moving().map(|joint| if joint.kind == JointKind::Prismatic { MM } else { DEG }).collect();
    let given = touch.postures_deg.get_ref();
    let fits = |posture: &Vec<f64>| posture.len() == units.len() && posture.iter().all(|q| q.abs() <= LARGEST_POSITION);
    if given.is_empty() || !given.iter().all(fits) {
        let place = context.place(touch.postures_deg.span(), format!("{field}, postures_deg"));
        let expected = format!("lists of {} joint positions in degrees", units.len());
        let found = format!("lists of {:?}", given.iter().map(Vec::len).collect::<Vec<_>>());
        return Err(IoError::unexpected(place, expected, found));
    }
    Ok(given.iter().map(|posture| posture.iter().zip(&units).map(|(q, unit)| q * unit).collect()).collect())
}

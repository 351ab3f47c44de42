//! The tables that say nothing of robot, parts and logs: `[noise]` and `[estimate]`.

use std::path::Path;

use serde::Deserialize;

use super::assumptions::Assumptions;
use super::context::{Allowed, Context, DEG, MAX_BYTES, MM};
use super::parameters::{self, Drift, Wanted};
use super::schema::{EstimateToml, NoiseToml, Number, TrendOverToml};
use super::tolerance::DeclaredPrior;
use crate::contact::ContactLog;
use crate::estimate::{
    Distance, EstimatorOptions, Fixture, Noise, PlacePrior, Problem, Tool, TrendVariable, WrenchTolerance,
};
use crate::io::base::bytes;
use crate::io::base::error::{IoError, Place};
use crate::io::robot::urdf;
use crate::manifold::ResidualKind;
use crate::robot::Robot;

/// Standard deviation of the encoder noise if none is declared (rad): 0.005°, the repeatability of
/// a good arm's joint.
pub const DEFAULT_ENCODER: f64 = 0.005 * DEG;
/// Standard deviation of the contact noise if none is declared (m): 0.05 mm.
pub const DEFAULT_CONTACT: f64 = 0.05 * MM;

/// Keys that declare what is assumed of the wrench without them.
const WRENCH_KEYS: &str = "force_bias_n, torque_bias_nm, force_noise_n, torque_noise_nm, wrench_scale in [noise]";

/// Settings of a problem that do not concern robot, parts and logs: its noise, parameters, priors,
/// loss and method.
#[derive(Debug)]
pub struct Settings {
    noise: Noise,
    /// Declared standard deviations of the wrench's bias and noise (N, N m), and of its scale (1).
    wrench: [Option<f64>; 5],
    /// Where the file says that encoder offsets change with temperature.
    over_temperature: Option<Place>,
    wanted: Wanted,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SettingsToml {
    #[serde(default)]
    noise: NoiseToml,
    estimate: EstimateToml,
}

impl Settings {
    /// Reads the tables `[noise]`, which may be absent, and `[estimate]` of a problem file from a
    /// text that holds these alone, for the joints of `robot`. `file` is its name for messages.
    ///
    /// # Errors
    /// [`IoError`] if the text is longer than [`MAX_BYTES`], is no TOML or has other tables or
    /// keys; a number is out of range or both kinds of noise are 0; or a block is not known or
    /// listed twice, or a parameter to freeze is not known.
    pub fn read(text: &str, file: &str, robot: &Robot) -> Result<Settings, IoError> {
        let context = Context { text, file, folder: Path::new("") };
        bytes::check_size(text.len() as u64, MAX_BYTES, file)?;
        let toml: SettingsToml = toml::from_str(text).map_err(|error| context.syntax(&error))?;
        Settings::of(&toml.noise, &toml.estimate, robot, &context)
    }

    pub(super) fn of(
        noise: &NoiseToml,
        estimate: &EstimateToml,
        robot: &Robot,
        context: &Context<'_>,
    ) -> Result<Settings, IoError> {
        let angle = |value: &Option<Number>, name: &str| {
            context.number(value.as_ref(), DEG, Allowed::NotNegative, &format!("noise, {name}"))
        };
        let drift = Drift {
            trend: angle(&noise.encoder_trend_deg, "encoder_trend_deg")?,
            walk: angle(&noise.encoder_walk_deg, "encoder_walk_deg")?,
        };
        let wanted = parameters::wanted(estimate, drift, robot, context)?;
        let over = noise.encoder_trend_over.as_ref().filter(|over| *over.get_ref() == TrendOverToml::Temperature);
        let over_temperature = over.map(|over| context.place(over.span(), "noise, encoder_trend_over"));
        Ok(Settings { noise: self::noise(noise, context)?, wrench: wrench(noise, context)?, over_temperature, wanted })
    }

    /// Prior of a fixture's place: [`PlacePrior::Flat`] where nothing is declared and the places of
    /// all fixtures are to be estimated, else the declared or default one.
    pub fn fixture_prior(&self, place: DeclaredPrior) -> PlacePrior {
        if self.wanted.fixtures && place.is_assumed { PlacePrior::Flat } else { place.prior }
    }

    /// Prior of the tool's place, likewise.
    pub fn tool_prior(&self, place: DeclaredPrior) -> PlacePrior {
        if self.wanted.tool && place.is_assumed { PlacePrior::Flat } else { place.prior }
    }

    /// The problem with these settings and the given tool, fixtures, known distances and contacts.
    /// Notes are appended to `contacts` if loads or joint torques have no effect, if the robot has
    /// no masses for torques of gravity, and on what is assumed of the wrench.
    ///
    /// # Errors
    /// [`IoError::Unexpected`] if joint compliances or backlashes are to be estimated although
    /// neither gravity nor a load acts on the joints, so that no contact determines them; if
    /// encoder offsets change with temperature and that of a contact is not known; and as
    /// [`check_joint_torques`].
    pub fn problem(
        self,
        robot: Robot,
        (tool, fixtures, distances): (Tool, Vec<Fixture>, Vec<Distance>),
        mut contacts: ContactLog,
    ) -> Result<Problem, IoError> {
        let Settings { noise, wrench, over_temperature, wanted } = self;
        let unknown = (0..contacts.len()).filter(|&i| contacts.temperature(i).is_none()).count();
        if let Some(place) = over_temperature.clone().filter(|_| unknown > 0) {
            let expected = "the temperature of each contact (`temperature` in [[contacts]], the name of its column)";
            return Err(IoError::unexpected(place, expected, format!("{unknown} contacts without")));
        }
        let is_one_sided = |fixture: &Fixture| fixture.manifold.residual_kind() == ResidualKind::LeastGap;
        let is_measured = contacts.has_joint_torques();
        check_joint_torques(&robot, &contacts, is_measured)?;
        let (weightless, loaded) = (robot.gravity().norm() == 0.0, contacts.has_loads());
        let is_rigid = !robot.is_compliant();
        match wanted.deflection {
            Some((place, block)) if weightless && !loaded && !is_measured => {
                let expected = "gravity or a load (`load_on` or `tau_joint` in [[contacts]]) \
                                under which joints give way";
                let found = format!("\"{}\" with `gravity` of 0", block.name());
                return Err(IoError::unexpected(place, expected, found));
            }
            None if loaded && is_rigid && !fixtures.iter().any(is_one_sided) => contacts.note(
                "load_on: no joint deflects and no fixture is a hole of known shape, so that the load changes nothing; \
                 ask for joint_compliance, or name a URDF that was calibrated with it",
            ),
            None if is_measured && is_rigid => contacts.note(
                "tau_joint: no joint deflects, so that its torques change nothing; \
                 ask for joint_compliance, or name a URDF that was calibrated with it",
            ),
            None if is_rigid => {}
            _ if is_measured => {}
            _ if !weightless && loaded && !robot.has_masses() => contacts.note(
                "joint_compliance: the URDF lacks masses; 1 kg a link stands in for them, beside which the load counts too much or too little; \
                 give links an <inertial>, or declare gravity = [0, 0, 0] if the arm makes up for its weight",
            ),
            _ => {}
        }
        let mut problem = Problem {
            distances,
            noise,
            wrench: tolerance(wrench),
            parameters: wanted.parameters,
            joint_drift: wanted.joint_drift,
            trend_variable: over_temperature.map_or(TrendVariable::Log, |_| TrendVariable::Temperature),
            method: wanted.method,
            loss: wanted.loss,
            options: EstimatorOptions { unseen_effects: wanted.unseen_effects, ..EstimatorOptions::default() },
            other_arms: urdf::builtin_arms(),
            ..Problem::new(robot, tool, fixtures, contacts)
        };
        note_wrench(&mut problem, wrench);
        Ok(problem)
    }
}

/// Checks that the joint torques of all `contacts` are known, if they are `wanted` or if `robot`
/// deflects by measured ones, and else those of none.
///
/// # Errors
/// [`IoError::Unexpected`] with the log of a contact that is otherwise.
pub fn check_joint_torques(robot: &Robot, contacts: &ContactLog, wanted: bool) -> Result<(), IoError> {
    let by_robot = robot.is_compliant() && robot.has_measured_torques();
    if wanted && robot.is_compliant() && !robot.has_measured_torques() {
        let place = Place::file(contacts.files().first().cloned().unwrap_or_default()).field("tau_joint");
        let expected = "a robot whose compliances belong to measured torques, or a stiff one";
        return Err(IoError::unexpected(place, expected, "compliances of gravity and load in the URDF"));
    }
    let Some(other) = (0..contacts.len()).find(|&i| contacts.joint_torques(i).is_some() != (wanted || by_robot)) else {
        return Ok(());
    };
    let file = contacts.files().get(contacts.source(other).file as usize).cloned().unwrap_or_default();
    let place = Place::file(file).field("tau_joint");
    if by_robot {
        let expected = "the torques of joints, to which the compliances of the URDF belong";
        return Err(IoError::unexpected(place, expected, "a log without `tau_joint`"));
    }
    let found = if wanted { "a log without" } else { "a log with them" };
    Err(IoError::unexpected(place, "the torques of joints in each log or in none", found))
}

/// Declared standard deviations of the wrench's bias and noise (N, N m), and of its scale (1).
fn wrench(table: &NoiseToml, context: &Context<'_>) -> Result<[Option<f64>; 5], IoError> {
    let sigma = |number: &Option<Number>, key: &str| {
        context.number(number.as_ref(), 1.0, Allowed::NotNegative, &format!("noise, {key}"))
    };
    Ok([
        sigma(&table.force_bias_n, "force_bias_n")?,
        sigma(&table.torque_bias_nm, "torque_bias_nm")?,
        sigma(&table.force_noise_n, "force_noise_n")?,
        sigma(&table.torque_noise_nm, "torque_noise_nm")?,
        sigma(&table.wrench_scale, "wrench_scale")?,
    ])
}

/// The declared standard deviations, and the default ones where none are.
fn tolerance([force, torque, force_noise, torque_noise, scale]: [Option<f64>; 5]) -> WrenchTolerance {
    let default = WrenchTolerance::DEFAULT;
    WrenchTolerance {
        force: force.unwrap_or(default.force),
        torque: torque.unwrap_or(default.torque),
        scale: scale.unwrap_or(default.scale),
        force_noise: force_noise.unwrap_or(default.force_noise),
        torque_noise: torque_noise.unwrap_or(default.torque_noise),
    }
}

/// Notes what is assumed of the wrench where it is used, or that what is `declared` of it has no
/// effect.
fn note_wrench(problem: &mut Problem, declared: [Option<f64>; 5]) {
    if problem.deflects_under_loads() {
        let mut assumptions = Assumptions::default();
        assumptions.wrench(declared, problem.wrench);
        assumptions.notes(WRENCH_KEYS).into_iter().for_each(|note| problem.contacts.note(note));
    } else if declared.iter().any(Option::is_some) {
        problem.contacts.note(format!("{WRENCH_KEYS}: no joint deflects under a load, so that they change nothing"));
    }
}

fn noise(table: &NoiseToml, context: &Context<'_>) -> Result<Noise, IoError> {
    let encoder = context.number(table.encoder_deg.as_ref(), DEG, Allowed::NotNegative, "noise, encoder_deg")?;
    let contact = context.number(table.contact_mm.as_ref(), MM, Allowed::NotNegative, "noise, contact_mm")?;
    let noise = Noise {
        encoder: encoder.unwrap_or(DEFAULT_ENCODER),
        contact: contact.unwrap_or(DEFAULT_CONTACT),
        is_estimated: table.estimated.unwrap_or(encoder.is_none() && contact.is_none()),
    };
    if noise.encoder == 0.0 && noise.contact == 0.0 {
        let place = Place::file(context.file).field("noise");
        return Err(IoError::unexpected(place, "encoder or contact noise above 0", "both 0"));
    }
    Ok(noise)
}

//! `touchcal simulate`: logs of an arm with known errors.

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;

use touchcal::io::scenario_file::{self, ScenarioFile};
use touchcal::robot::{Joint, JointKind};
use touchcal::sim::{self, Preset, Seeds, SimulatedTrial, SimulationError};
use touchcal::statistics::floor_rank;

use crate::args::{ScenarioSource, SimulateArgs};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::{Spinner, defer_interrupts, interrupted};
use crate::table::Table;

/// Distance (rad) of a joint from the posture given, beyond its swing, from which the arm works in
/// another posture: shoulder, elbow or wrist are flipped by more, and hardly any task moves a joint
/// as far about one posture.
const FAR_FROM_POSTURE: f64 = 60.0 * PI / 180.0;

/// Simulates a scenario and writes logs, problem, scenario and truth.
pub fn run(args: &SimulateArgs) -> Result<Outcome, Failure> {
    super::prepare_outputs([args.out.join(scenario_file::SCENARIO)], args.source.scenario.as_deref())?;
    scenario_file::check_folder(&args.out)?;
    let file = scenario(&args.source)?;
    let seeds = Seeds { errors: args.seed, noise: args.noise_seed.unwrap_or(args.seed) };
    let simulated = simulate(&file, seeds)?;
    scenario_file::write_folder(&args.out, &file, &simulated, seeds)?;
    for note in beyond_limits(&file, &simulated).into_iter().chain(far_from_postures(&file, &simulated)) {
        output::diagnostic(&note);
    }
    output::print(&summary(&args.out, &file, &simulated))?;
    Ok(Outcome::Done)
}

/// The scenario of the arguments.
pub fn scenario(source: &ScenarioSource) -> Result<ScenarioFile, Failure> {
    let mut file = match (&source.scenario, &source.preset) {
        (Some(path), _) => scenario_file::read_file(path)?,
        (None, Some(preset)) => scenario_file::preset(Preset::from(*preset).name())?,
        // clap requires one of them.
        (None, None) => return Err(Failure::Setup("neither a scenario file nor --preset".to_owned())),
    };
    if let Some(contacts) = source.contacts {
        file.scenario.contacts = contacts as usize;
    }
    Ok(file)
}

/// Simulates with progress, until interrupted.
pub fn simulate(file: &ScenarioFile, seeds: Seeds) -> Result<SimulatedTrial, Failure> {
    defer_interrupts();
    let spinner = Spinner::new("Simulating");
    let truth = sim::draw_truth(&file.scenario, seeds.errors);
    let mut observer = |contacts: usize| {
        spinner.show(|| format!("{contacts} contacts"));
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match sim::run(&file.scenario, &truth, seeds.noise, &mut observer) {
        Err(SimulationError::Interrupted) => Err(Failure::Interrupted),
        logs => Ok(SimulatedTrial { truth, logs: logs? }),
    }
}

/// A note on each joint that is beyond its limits in some contact: commands follow the tool, not
/// the limits.
fn beyond_limits(file: &ScenarioFile, simulated: &SimulatedTrial) -> Vec<String> {
    let each = file.scenario.robot.moving().enumerate().filter_map(|(k, joint)| {
        let limits = joint.limits?;
        let rows = |log: &sim::Log| log.contact.iter().zip(log.q.chunks(log.dof.max(1))).filter(|(contact, _)| **contact).map(|(_, q)| q[k]).collect::<Vec<f64>>();
        let positions: Vec<f64> = simulated.logs.iter().flat_map(rows).collect();
        let excess = |q: &f64| (limits.lower - q).max(q - limits.upper);
        let beyond: Vec<f64> = positions.iter().map(excess).filter(|excess| *excess > 0.0).collect();
        let most = beyond.iter().copied().fold(0.0, f64::max);
        let most = if joint.kind == JointKind::Prismatic { format!("{:.1} mm", 1e3 * most) } else { format!("{:.1}°", most.to_degrees()) };
        (!beyond.is_empty()).then(|| {
            format!(
                "note: `{}` is beyond its limits in {} of {} contacts, by up to {most}: a real arm stops there; choose other `postures_deg`",
                joint.name,
                beyond.len(),
                positions.len()
            )
        })
    });
    each.collect()
}

/// A note on each fixture where the arm is far from all postures given in most contacts: of several
/// ways to reach a pose, inverse kinematics takes the first that it finds.
fn far_from_postures(file: &ScenarioFile, simulated: &SimulatedTrial) -> Vec<String> {
    let robot = &file.scenario.robot;
    let joints: Vec<&Joint> = robot.moving().collect();
    let each = file.scenario.touches.iter().zip(&simulated.logs).filter_map(|(touch, log)| {
        // The joint that is farthest from a posture, and how far it is.
        let farthest = |posture: &Vec<f64>, q: &[f64]| {
            let turning = (0..joints.len()).filter(|&k| joints[k].kind != JointKind::Prismatic);
            turning.map(|k| (k, (q[k] - posture[k]).abs())).max_by(|a, b| a.1.total_cmp(&b.1))
        };
        let nearest = |row: usize| {
            let each = touch.postures.iter().filter_map(|posture| farthest(posture, log.q(row)));
            each.min_by(|a, b| a.1.total_cmp(&b.1))
        };
        let distances: Vec<(usize, f64)> = log.contacts().filter_map(nearest).collect();
        let far = |(_, distance): &&(usize, f64)| *distance > FAR_FROM_POSTURE + touch.exploration.swing;
        let count = distances.iter().filter(far).count();
        let (k, most) = distances.iter().filter(far).copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
        (2 * count > distances.len()).then(|| format!(
            "note: `{}`: the arm works in another posture than given in {count} of {} contacts, `{}` by up to {:.0}°; \
             choose `postures_deg` that put the tool near the fixture, turned as it is to be there",
            touch.name,
            distances.len(),
            joints[k].name,
            most.to_degrees()
        ))
    });
    each.collect()
}

fn summary(folder: &Path, file: &ScenarioFile, simulated: &SimulatedTrial) -> String {
    let mut table = Table::new(["fixture", "rows", "contacts", "force N: median", "95 %", "recorded s"]);
    for (touch, log) in file.scenario.touches.iter().zip(&simulated.logs) {
        let size = |row: usize| log.wrench[row][..3].iter().map(|part| part * part).sum::<f64>().sqrt();
        let mut forces: Vec<f64> = log.contacts().map(size).collect();
        forces.sort_unstable_by(f64::total_cmp);
        let quantile = |percent| floor_rank(&forces, percent).unwrap_or(f64::NAN);
        table.row([
            touch.name.clone(),
            log.len().to_string(),
            forces.len().to_string(),
            format!("{:.1}", quantile(50)),
            format!("{:.1}", quantile(95)),
            format!("{:.1}", log.time.last().copied().unwrap_or(0.0)),
        ]);
    }
    let folder = folder.display();
    [
        table.to_string(),
        format!(
            "\nWritten to {folder}: problem.toml and the logs it names, scenario.toml, truth.json, true.urdf.\n\nNext\n"
        ),
        format!("  touchcal inspect {folder}/problem.toml\n"),
        format!("  touchcal calibrate {folder}/problem.toml --out {folder}/calibrated\n"),
    ]
    .concat()
}

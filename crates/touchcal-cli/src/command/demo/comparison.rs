//! What was found against the truth.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::estimate::{Estimate, Problem};
use touchcal::robot::{Block, Column, Kinematics, Robot};

use super::experiment::Experiment;
use crate::summary::in_user_units;
use crate::table::{Table, signed};

/// Other poses at which arms are compared.
const OTHER_POSES: usize = 100;

/// Tables of parameters and of tool errors, before and after.
pub fn text(experiment: &Experiment, problem: &Problem, estimate: &Estimate) -> String {
    let contacts = problem.contacts.len();
    [
        format!(
            "An iiwa 14 with wrong link lengths and encoder zeros explored a hole with a peg: {contacts} contacts.\n"
        ),
        "Calibrated from zero, from joint positions alone; peg and hole known.\n\n".to_owned(),
        parameters(experiment, estimate),
        "\nTool error against the true arm (mean)\n".to_owned(),
        tool_errors(experiment, problem, estimate),
        "\n".to_owned(),
    ]
    .concat()
}

fn parameters(experiment: &Experiment, estimate: &Estimate) -> String {
    let truth =
        |column: Column| experiment.insertion.errors.iter().find(|(c, _)| *c == column).map(|(_, value)| *value);
    let mut table = Table::new(["parameter", "true", "start", "estimate", "± sigma", "error", "unit"]);
    for entry in &estimate.parameters {
        let Some(truth) = truth(entry.parameter.column) else { continue };
        let (factor, unit, decimals) = in_user_units(entry.parameter.unit);
        let sigma = entry.sigma.map_or("-".to_owned(), |sigma| format!("{:.decimals$}", factor * sigma));
        table.row([
            entry.parameter.name.clone(),
            signed(factor * truth, decimals),
            "0".to_owned(),
            signed(factor * entry.value, decimals),
            sigma,
            signed(factor * (entry.value - truth), decimals),
            unit.to_owned(),
        ]);
    }
    let errors = estimate.parameters.iter().filter(|entry| entry.parameter.column.block() == Block::JointOffset);
    let errors: Vec<f64> =
        errors.filter_map(|entry| Some((entry.value - truth(entry.parameter.column)?).abs().to_degrees())).collect();
    let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    format!("{table}  mean size of the offsets' errors: {mean:.4} deg\n")
}

/// How far the tool is from where an arm's model puts it, at the same encoder readings.
fn tool_errors(experiment: &Experiment, problem: &Problem, estimate: &Estimate) -> String {
    let nominal = &experiment.insertion.robot;
    let (columns, values): (Vec<Column>, Vec<f64>) = experiment.insertion.errors.iter().copied().unzip();
    let truth = nominal.calibrated(&columns, &values);
    let contacts = &problem.contacts;
    let at_hole: Vec<Vec<f64>> = (0..contacts.len()).map(|i| contacts.q(i).to_vec()).collect();
    let elsewhere = other_poses(nominal, experiment.seed);
    let mut table = Table::new(["", "before mm", "before deg", "after mm", "after deg"]);
    let named = [("at the hole".to_owned(), at_hole), (format!("at {OTHER_POSES} other poses"), elsewhere)];
    for (name, poses) in named {
        let (before, turned_before) = mean_error(experiment, [&truth, nominal], &poses);
        let (after, turned_after) = mean_error(experiment, [&truth, &estimate.robot], &poses);
        table.row([
            name,
            format!("{before:.3}"),
            format!("{turned_before:.3}"),
            format!("{after:.3}"),
            format!("{turned_after:.4}"),
        ]);
    }
    table.to_string()
}

/// Mean distance (mm) and angle (deg) between two arms' tools.
fn mean_error(experiment: &Experiment, arms: [&Robot; 2], poses: &[Vec<f64>]) -> (f64, f64) {
    let [truth, model] = arms.map(|arm| Kinematics::new(arm, &[], experiment.insertion.tip_from_peg));
    let (mut distance, mut angle) = (0.0, 0.0);
    for q in poses {
        let between = truth.pose(q).inverse() * model.pose(q);
        distance += between.translation.vector.norm();
        angle += between.rotation.angle();
    }
    let count = poses.len().max(1) as f64;
    (1e3 * distance / count, (angle / count).to_degrees())
}

/// Joint positions spread over the joint limits.
fn other_poses(robot: &Robot, seed: u64) -> Vec<Vec<f64>> {
    let mut chance = Pcg64::seed_from_u64(seed.wrapping_add(1));
    let mut pose = || {
        let each = robot.moving().map(|joint| match joint.limits {
            Some(limits) => chance.random_range(limits.lower..=limits.upper),
            None => chance.random_range(-std::f64::consts::PI..=std::f64::consts::PI),
        });
        each.collect()
    };
    (0..OTHER_POSES).map(|_| pose()).collect()
}

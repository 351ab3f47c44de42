//! Estimates compared with the truth.

use touchcal::estimate::{Estimate, Problem};
use touchcal::experiment::{random_positions, tool_error};
use touchcal::parameter::Block;
use touchcal::report::signed;
use touchcal::robot::{Robot, calibrated};
use touchcal::sim::Truth;

use crate::table::Table;

/// Other poses at which arms are compared.
const OTHER_POSES: usize = 100;

/// Tables of parameters and of tool errors, before and after.
pub fn text(nominal: &Robot, truth: &Truth, seed: u64, problem: &Problem, estimate: &Estimate) -> String {
    let contacts = problem.contacts.len();
    [
        format!(
            "An iiwa 14 with errors of link lengths and encoder offsets explored a hole with a peg: {contacts} contacts.\n"
        ),
        "Calibrated from joint positions alone, starting at zero errors; poses of peg and hole known.\n\n".to_owned(),
        parameters(truth, estimate),
        "\nMean tool error, compared with the true arm\n".to_owned(),
        tool_errors((nominal, truth), seed, problem, estimate),
        "\n".to_owned(),
    ]
    .concat()
}

fn parameters(truth: &Truth, estimate: &Estimate) -> String {
    let truth = |column| truth.errors.iter().find(|(c, _)| *c == column).map(|(_, value)| *value);
    let mut table = Table::new(["parameter", "true", "start", "estimate", "± sigma", "error", "unit"]);
    for entry in &estimate.parameters {
        let Some(truth) = truth(entry.parameter.id) else { continue };
        let (factor, unit, decimals) = entry.parameter.unit.in_user_units();
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
    let errors = estimate.parameters.iter().filter(|entry| entry.parameter.id.block() == Block::JointOffset);
    let errors: Vec<f64> =
        errors.filter_map(|entry| Some((entry.value - truth(entry.parameter.id)?).abs().to_degrees())).collect();
    let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
    format!("{table}  mean absolute error of the encoder offsets: {mean:.4} deg\n")
}

/// How far the tool is from where an arm's model puts it, at the same encoder readings.
fn tool_errors((nominal, truth): (&Robot, &Truth), seed: u64, problem: &Problem, estimate: &Estimate) -> String {
    let (columns, values) = truth.of_kinematics();
    let truth = calibrated(nominal, &columns, &values);
    let contacts = &problem.contacts;
    let at_hole: Vec<Vec<f64>> = (0..contacts.len()).map(|i| contacts.q(i).to_vec()).collect();
    let elsewhere = random_positions(nominal, OTHER_POSES, seed.wrapping_add(1));
    let mut table = Table::new(["", "before mm", "before deg", "after mm", "after deg"]);
    let named = [("at the hole".to_owned(), at_hole), (format!("at {OTHER_POSES} other poses"), elsewhere)];
    for (name, poses) in named {
        let positions = || poses.iter().map(Vec::as_slice);
        let tip_from_tool = problem.tool.tip_from_tool;
        let [before, after] = [nominal, &estimate.robot].map(|arm| tool_error(&truth, arm, tip_from_tool, positions()));
        table.row([
            name,
            format!("{:.3}", 1e3 * before.mean_distance),
            format!("{:.3}", before.mean_angle.to_degrees()),
            format!("{:.3}", 1e3 * after.mean_distance),
            format!("{:.4}", after.mean_angle.to_degrees()),
        ]);
    }
    table.to_string()
}

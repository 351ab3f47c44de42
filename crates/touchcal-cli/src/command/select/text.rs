//! What `select` prints.

use touchcal::estimate::{Estimate, GroupMean, ModelChoice};
use touchcal::parameter::Block;
use touchcal::report::signed;

use crate::summary::{self, INDENT, advice, millimetres, wrapped};
use crate::table::Table;

/// Fewer groups than this say little about their scatter.
const FEW_GROUPS: usize = 6;

/// The choice as text, with the calibration of the chosen model.
pub fn of(choice: &ModelChoice, estimate: &Estimate) -> String {
    [chosen(choice), few_groups(choice), models(choice), gains(choice), alarms(choice), incompleteness(estimate)]
        .concat()
        + &next(choice)
}

fn chosen(choice: &ModelChoice) -> String {
    let name = wrapped(&choice.models[choice.chosen].name());
    format!("Model     {name}\n{INDENT}{}\n", wrapped(&choice.prediction()))
}

fn few_groups(choice: &ModelChoice) -> String {
    let count = choice.groups.len();
    let mut notes = String::new();
    if count < FEW_GROUPS {
        let words =
            format!("{count} groups: standard errors are rough, and the choice proves little about other places");
        notes += &format!("Note      {}\n", wrapped(&words));
    }
    if choice.outliers > 0 {
        let words = format!("{} contacts that all models reject are left out of the errors", choice.outliers);
        notes += &format!("Note      {}\n", wrapped(&words));
    }
    notes
}

fn models(choice: &ModelChoice) -> String {
    let mut table = Table::new(["model", "parameters", "held out: rms mm", "above the best: mm", "in sample: rms mm"]);
    let best = &choice.models[choice.best];
    for (m, model) in choice.models.iter().enumerate() {
        let mark = if m == choice.chosen { "*" } else { "" };
        let above = match m == choice.best {
            true => "-".to_owned(),
            false => with_error(&model.difference(best)),
        };
        table.row([
            model.name() + mark,
            model.parameters.to_string(),
            with_error(&model.held_out),
            above,
            millimetres(model.in_sample),
        ]);
    }
    format!(
        "\n{table}  * chosen: the fewest parameters that predict no worse than the best by more than a standard error and 1 %\n"
    )
}

fn gains(choice: &ModelChoice) -> String {
    let mut table = Table::new(["block", "chosen", "held-out error without it less with it: mm"]);
    for gain in &choice.gains {
        let is_chosen = if gain.is_chosen { "yes" } else { "no" };
        table.row([gain.block.name().to_owned(), is_chosen.to_owned(), signed_with_error(&gain.gain)]);
    }
    format!("\nPredictive gain of each block beside the others of the chosen model\n{table}")
}

fn alarms(choice: &ModelChoice) -> String {
    let chosen = &choice.models[choice.chosen];
    let each = choice.extrapolate_worse.iter().map(|&m| {
        let model = &choice.models[m];
        let words = format!(
            "{} fits better ({} mm in place of {} mm rms) but predicts worse, by {} mm: do not estimate it from these contacts",
            model.name(),
            millimetres(model.in_sample),
            millimetres(chosen.in_sample),
            with_error(&model.difference(chosen))
        );
        format!("\nAlarm     {}\n", wrapped(&words))
    });
    each.collect()
}

fn incompleteness(estimate: &Estimate) -> String {
    let reasons = estimate.incompleteness();
    if reasons.is_empty() {
        return String::new();
    }
    let words = "the chosen model is incomplete, by the calibration with all contacts";
    let each = reasons.iter().map(|reason| summary::warning(reason.severity(), &reason.message(), reason.advice()));
    format!("\nWarning   {}\n{}", wrapped(words), each.collect::<String>())
}

fn next(choice: &ModelChoice) -> String {
    let names = choice.models[choice.chosen].blocks.iter().map(|block| format!("{:?}", block.name()));
    let names = names.collect::<Vec<_>>().join(", ");
    let line = format!(
        "in [estimate]: parameters = [{names}]{}, beside those blocks that are not compared above",
        priors(choice)
    );
    let auto = advice(INDENT, "or, in one go: touchcal calibrate --model auto");
    format!("\nNext      calibrate with the chosen model\n{}{auto}", advice(INDENT, &line))
}

/// The key of narrower priors of the chosen model, if it has such.
fn priors(choice: &ModelChoice) -> String {
    let chosen = &choice.models[choice.chosen];
    let each = chosen.blocks.iter().filter_map(|block| {
        let parameter = choice.problem.parameters.iter().find(|parameter| parameter.id.block() == *block)?;
        let sigma = parameter.prior_sigma()?;
        match block {
            Block::JointHarmonic | Block::JointHarmonic2 => {
                Some(format!("{}_deg = {}", block.name(), sigma.to_degrees()))
            }
            Block::JointGearRatio => Some(format!("{} = {sigma}", block.name())),
            _ => None,
        }
    });
    let keys = each.collect::<Vec<_>>().join(", ");
    if chosen.prior_width < 1.0 { format!(" and prior = {{ {keys} }}") } else { String::new() }
}

/// A mean in mm, with its standard error.
fn with_error(mean: &GroupMean) -> String {
    around(mean, millimetres(mean.mean))
}

/// The same with its sign.
fn signed_with_error(mean: &GroupMean) -> String {
    around(mean, signed(1e3 * mean.mean, 3))
}

fn around(mean: &GroupMean, text: String) -> String {
    if mean.mean.is_finite() {
        format!("{text} ± {}", millimetres(mean.standard_error))
    } else {
        "no prediction".to_owned()
    }
}

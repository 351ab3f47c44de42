//! What `compare` prints.

use touchcal::estimate::{Comparison, ParameterChange};
use touchcal::experiment::PoseErrors;
use touchcal::io::{CalibrationChanges, SavedCalibration};
use touchcal::parameter::Unit;
use touchcal::report::{fixed, signed};
use touchcal::statistics::p_value_statement;

use crate::summary::{INDENT, millimetres, wrapped};
use crate::table::Table;

/// Most parameters listed.
const MOST_PARAMETERS: usize = 10;
/// Probability below which a change is not taken for chance.
const RARE: f64 = 0.01;

/// The comparison as text; of more than ten parameters those that changed most, unless `all` are
/// wanted.
pub fn of(both: &[SavedCalibration; 2], changes: &CalibrationChanges, all: bool) -> String {
    let [earlier, later] = both.each_ref().map(described);
    let CalibrationChanges { arm, tool, tip_motion, .. } = changes;
    let tip_motion = tip_motion.as_ref().map_or_else(String::new, motion);
    [
        format!("Arm       {}\n", wrapped(&verdict(arm))),
        of_tool(tool.as_ref()),
        tip_motion,
        format!("Earlier   {earlier}\n"),
        format!("Later     {later}\n"),
        notes(changes),
        "\n".to_owned(),
        table(arm.parameters.iter().chain(tool.iter().flat_map(|tool| &tool.parameters)), &both[0], all),
    ]
    .concat()
}

fn described(calibration: &SavedCalibration) -> String {
    let status = calibration.file.status.name().replace('_', " ");
    let when = calibration.file.created.as_deref().unwrap_or("at an unknown time");
    format!("{}: {status}, {when}", calibration.name)
}

fn verdict(found: &Comparison) -> String {
    let Comparison { statistic, degrees_of_freedom, p_value, .. } = found;
    let chi_squared = format!("chi-squared {statistic:.1}, {degrees_of_freedom} degrees of freedom");
    match *p_value {
        None => "contacts determine none of its parameters, no change can be seen".to_owned(),
        Some(p) if p < RARE => {
            format!("CHANGED by more than the uncertainties explain ({}; {chi_squared})", p_value_statement(p))
        }
        Some(p) => format!("no change beyond the uncertainties (p = {p:.2}; {chi_squared})"),
    }
}

fn of_tool(tool: Option<&Comparison>) -> String {
    match tool {
        Some(tool) if tool.parameters.is_empty() => String::new(),
        Some(tool) => format!("Tool      {}\n", wrapped(&format!("its place on the tip: {}", verdict(tool)))),
        None => "Tool      not compared: its nominal poses differ, or are not known\n".to_owned(),
    }
}

fn motion(found: &PoseErrors) -> String {
    let [rms, max] = [found.position.rms, found.position.max].map(millimetres);
    let [angle, largest] = [found.angle.rms, found.angle.max].map(|angle| fixed(angle.to_degrees(), 3));
    let distance = millimetres(found.distance.rms);
    let words = format!(
        "moves by {rms} mm, {angle}° rms in base over the workspace (at most {max} mm, {largest}°), distances between two positions change by {distance} mm rms"
    );
    format!("Tip       {}\n", wrapped(&words))
}

/// What to keep in mind about the comparison.
fn notes(changes: &CalibrationChanges) -> String {
    let note = |(words, advice): &(String, &str)| format!("Note      {}\n{INDENT}-> {advice}\n", wrapped(words));
    changes.notes().iter().map(note).collect()
}

/// Parameters, those first that changed by the most standard deviations.
fn table<'a>(changes: impl Iterator<Item = &'a ParameterChange>, calibration: &SavedCalibration, all: bool) -> String {
    let size = |change: &ParameterChange| change.deviations().map_or(0.0, f64::abs);
    let mut changes: Vec<&ParameterChange> = changes.collect();
    changes.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let shown = if all { changes.len() } else { MOST_PARAMETERS };
    let mut table = Table::new(["parameter", "earlier", "later", "change", "± sigma", "deviations", "unit"]);
    for change in changes.iter().take(shown) {
        let entry = calibration.file.parameters.iter().find(|entry| entry.name == change.name);
        let unit = entry.and_then(|entry| Unit::from_symbol(&entry.unit)).unwrap_or(Unit::One);
        let (factor, symbol, decimals) = unit.in_user_units();
        let [earlier, later] = change.values.map(|value| factor * value);
        table.row([
            change.name.clone(),
            signed(earlier, decimals),
            signed(later, decimals),
            signed(later - earlier, decimals),
            fixed(factor * change.sigma, decimals),
            change.deviations().map_or_else(|| "-".to_owned(), |deviations| signed(deviations, 1)),
            symbol.to_owned(),
        ]);
    }
    match changes.len().saturating_sub(shown) {
        0 => table.to_string(),
        more => format!("{table}  … and {more} more, which changed by fewer standard deviations (--all lists them)\n"),
    }
}

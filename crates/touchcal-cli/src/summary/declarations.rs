//! What contacts say against the problem file, as text.

use touchcal::estimate::{DeclaredValue, EffectTest, ErrorFrame, EffectValue, Estimate, FreedEffect, PriorTest, Problem};
use touchcal::parameter::Unit;
use touchcal::statistics::{p_value_statement, p_value_text};

use super::layout::{millimetres, wrapped};
use crate::table::{Table, signed};

/// What contacts say against the problem file: a table of what they contradict, of effects that the
/// model leaves out and of what is declared with a standard deviation, and the names of what they
/// do not contradict and of what they cannot test.
pub fn declarations(estimate: &Estimate, problem: &Problem) -> String {
    let thresholds = &problem.options.thresholds;
    let (effects, agreeing_effects): (Vec<_>, Vec<_>) =
        estimate.effect_tests.iter().partition(|test| test.p_value < thresholds.listed_p_value);
    let is_contradicted =
        |test: &&PriorTest| test.is_contradicted(thresholds.listed_p_value, thresholds.prior_deviations[0]);
    let (declared, agreeing): (Vec<_>, Vec<_>) = estimate.prior_tests.iter().partition(is_contradicted);
    let mut text = String::new();
    if !effects.is_empty() || !declared.is_empty() {
        let mut table = Table::new([
            "left out or declared",
            "p",
            "strongest value",
            "moves the tool (mm)",
            "95 % region (mm)",
            "problem file",
        ]);
        effects.into_iter().for_each(|test| table.row(effect_row(test)));
        declared.into_iter().for_each(|test| table.row(declared_row(test)));
        let frame = match problem.error_frame() {
            ErrorFrame::Base => "",
            ErrorFrame::BaseAligned => " (motion of the tool with the base aligned)",
        };
        text += &format!("What contacts say against the problem file{frame}\n{table}");
    }
    if !agreeing_effects.is_empty() {
        let names = agreeing_effects.iter().map(|test| test.effect.name()).collect::<Vec<String>>().join(", ");
        let allowed =
            if problem.allows_for_unseen_effects() { "; intervals allow for what contacts would not show" } else { "" };
        let words = format!("contacts do not contradict that these are zero: {names}{allowed}");
        text += &format!("Left out  {}\n", wrapped(&words));
    }
    if !agreeing.is_empty() {
        let names = agreeing.iter().map(|test| test.declaration.name()).collect::<Vec<String>>().join(", ");
        let words = format!("contacts do not contradict the standard deviations of these: {names}");
        text += &format!("Declared  {}\n", wrapped(&words));
    }
    if !estimate.untested.is_empty() {
        let words = format!("contacts cannot tell whether these are as declared: {}", estimate.untested.join(", "));
        text += &format!("Untested  {}\n", wrapped(&words));
    }
    if text.is_empty() { text } else { text + "\n" }
}

fn effect_row(test: &EffectTest) -> [String; 6] {
    let value = test.strongest_values().first().map_or_else(|| "-".to_owned(), |value| effect_value(value));
    let [displacement, radius] = [test.displacement, test.radius].map(millimetres);
    [test.effect.name(), p_value_text(test.p_value), value, displacement, radius, test.effect.declared_in()]
}

fn declared_row(test: &PriorTest) -> [String; 6] {
    let value = test.strongest_values().first().map_or_else(|| "-".to_owned(), |value| declared_value(value));
    let displacement = test.displacement.map_or_else(|| "-".to_owned(), millimetres);
    let declaration = &test.declaration;
    [declaration.name(), p_value_text(test.p_value), value, displacement, "-".to_owned(), declaration.declared_in()]
}

/// Effects that were freed, and what each is worth.
pub fn freed_effects(freed: &[FreedEffect]) -> String {
    let line = |FreedEffect { effect, p_value, gain, predictive_ratio }: &FreedEffect| {
        let without =
            predictive_ratio.map_or_else(String::new, |ratio| format!(", predicted scatter {ratio:.2} without it"));
        let p = p_value_statement(*p_value);
        format!("Freed     {}: {gain:+.1} in the log-likelihood ({p}){without}\n", effect.name())
    };
    freed.iter().map(line).collect()
}

/// A value that an effect would take, without the name of its block.
fn effect_value(entry: &EffectValue) -> String {
    let (factor, unit, decimals) = entry.unit.in_user_units();
    let name = without_block(&entry.name);
    format!("{name} {} ± {:.decimals$} {unit}", signed(factor * entry.value, decimals), factor * entry.sigma)
}

/// The estimate of something declared, without the name of its block.
fn declared_value(entry: &DeclaredValue) -> String {
    let (factor, unit, decimals) = entry.unit.in_user_units();
    if entry.unit == Unit::One && entry.name == "noise" {
        return format!("{:.2} ± {:.2} times the declared", entry.value, entry.sigma);
    }
    let declared = match factor * entry.sigma {
        0.0 => "exact".to_owned(),
        sigma => format!("± {sigma:.decimals$}"),
    };
    let name = without_block(&entry.name);
    if entry.name.starts_with("gap_bias.") {
        let (gap, side) = (factor * entry.value.abs(), if entry.value > 0.0 { "apart" } else { "overlapping" });
        return format!("{name} {gap:.decimals$} {unit} {side} at contact (declared {declared})");
    }
    format!("{name} {} {unit} (declared {declared})", signed(factor * entry.value, decimals))
}

fn without_block(name: &str) -> &str {
    name.split_once('.').map_or(name, |(_, name)| name)
}

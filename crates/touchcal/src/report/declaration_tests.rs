//! What contacts say against a problem, as rows and lines of summaries.

use super::number_text::{fixed, signed};
use crate::estimate::{DeclaredValue, EffectTest, EffectValue, ErrorFrame, Estimate, PriorTest, Problem};
use crate::parameter::Unit;
use crate::statistics::p_value_text;

/// What contacts say against a problem: what they contradict of effects that the model leaves out
/// and of what is declared with a standard deviation, and the names of what they do not contradict
/// and of what they cannot test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeclarationTests {
    /// Title of the table of what contacts contradict.
    pub title: &'static str,
    /// What contacts contradict, with the cells of [`DeclarationTests::HEADINGS`].
    pub contradicted: Vec<[String; 6]>,
    /// Labels (`Left out`, `Declared`, `Untested`) with texts on all others.
    pub others: Vec<(&'static str, String)>,
}

impl DeclarationTests {
    /// Headings of that table.
    pub const HEADINGS: [&str; 6] =
        ["left out or declared", "p", "strongest value", "moves the tool (mm)", "95 % region (mm)", "problem file"];

    /// Of an estimate and its problem.
    pub fn new(estimate: &Estimate, problem: &Problem) -> DeclarationTests {
        let thresholds = &problem.options.thresholds;
        let (effects, agreeing_effects): (Vec<_>, Vec<_>) =
            estimate.effect_tests.iter().partition(|test| test.p_value < thresholds.listed_p_value);
        let is_contradicted =
            |test: &&PriorTest| test.is_contradicted(thresholds.listed_p_value, thresholds.prior_deviations[0]);
        let (declared, agreeing): (Vec<_>, Vec<_>) = estimate.prior_tests.iter().partition(is_contradicted);
        let contradicted = effects.into_iter().map(effect_row).chain(declared.into_iter().map(declared_row)).collect();
        let allowed =
            if problem.allows_for_unseen_effects() { "; intervals allow for what contacts would not show" } else { "" };
        let zero = agreeing_effects.iter().map(|test| test.effect.name()).collect::<Vec<String>>();
        let within = agreeing.iter().map(|test| test.declaration.name()).collect::<Vec<String>>();
        let others = [
            ("Left out", "contacts do not contradict that these are zero", zero, allowed),
            ("Declared", "contacts do not contradict the standard deviations of these", within, ""),
            ("Untested", "contacts cannot tell whether these are as declared", estimate.untested.clone(), ""),
        ];
        let others = others.into_iter().filter(|(_, _, names, _)| !names.is_empty());
        let line = |(label, words, names, end): (_, &str, Vec<String>, &str)| {
            (label, format!("{words}: {}{end}", names.join(", ")))
        };
        let title = match problem.error_frame() {
            ErrorFrame::Base => "What contacts say against the problem file",
            ErrorFrame::BaseAligned => {
                "What contacts say against the problem file (motion of the tool with the base aligned)"
            }
        };
        DeclarationTests { title, contradicted, others: others.map(line).collect() }
    }
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

fn millimetres(metres: f64) -> String {
    fixed(1e3 * metres, 3)
}

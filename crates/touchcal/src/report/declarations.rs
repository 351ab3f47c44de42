//! What contacts say against the problem, and what is assumed where it says nothing.

use serde::Serialize;

use super::relative::CommonFolder;
use crate::estimate::{
    CompetingMinimum, DeclaredValue, EffectTest, EffectValue, Estimate, ParameterEstimate, PriorTest, Problem,
    WarningThresholds,
};
use crate::statistics::p_value_text;

/// The page's data of what is declared and assumed.
#[derive(Serialize)]
pub(super) struct Declarations<'a> {
    /// Tests of effects that the model leaves out, the most significant first.
    effects: Vec<EffectEntry<'a>>,
    /// Tests of what is declared with a standard deviation, the most significant first.
    declared: Vec<EffectEntry<'a>>,
    /// Names of what contacts cannot test.
    untested: &'a [String],
    /// Minima that contacts do not rule out, the one with the least cost first.
    minima: Vec<MinimumEntry<'a>>,
    /// Assumptions in words.
    notes: Vec<String>,
    /// Whether intervals allow for errors of the arm that contacts would not show.
    allows_for_unseen_effects: bool,
}

/// A test of an effect that the model leaves out, or of something declared.
#[derive(Serialize)]
struct EffectEntry<'a> {
    name: String,
    description: String,
    remedy: &'static str,
    /// Where a problem file leaves the effect out, or declares it.
    declared_in: String,
    is_significant: bool,
    /// Probability that it is chance.
    p_value: String,
    /// Those that contacts see, the most standard deviations from zero first.
    values: Vec<ValueEntry<'a>>,
    /// Motion of the tool, where there is one, and radius of its reported region (m), for effects
    /// that are left out.
    displacement: Option<f64>,
    radius: Option<f64>,
}

/// A minimum that contacts do not rule out.
#[derive(Serialize)]
struct MinimumEntry<'a> {
    /// Distance of the tool from where the result has it (m).
    tool_distance: f64,
    cost_ratio: f64,
    /// The parameter that differs most, and its values (SI).
    parameter: &'a str,
    unit: &'static str,
    there: f64,
    here: f64,
}

/// A value that a parameter of the effect would take with its standard deviation, or that something
/// declared has with that declared (SI).
#[derive(Serialize)]
struct ValueEntry<'a> {
    name: &'a str,
    unit: &'static str,
    value: f64,
    sigma: f64,
}

impl<'a> Declarations<'a> {
    /// The page's data of a problem and its estimate; notes name files without `folder`.
    pub fn new(problem: &'a Problem, estimate: &'a Estimate, folder: &CommonFolder) -> Self {
        let thresholds = &problem.options.thresholds;
        Declarations {
            effects: estimate.effect_tests.iter().map(|test| effect_entry(test, thresholds)).collect(),
            declared: estimate.prior_tests.iter().map(|test| declared_entry(test, thresholds)).collect(),
            untested: &estimate.untested,
            minima: estimate.competing_minima.iter().map(|other| minimum_entry(other, estimate)).collect(),
            notes: problem.contacts.notes().iter().map(|note| folder.shown_in(note)).collect(),
            allows_for_unseen_effects: problem.allows_for_unseen_effects(),
        }
    }
}

fn minimum_entry<'a>(other: &CompetingMinimum, estimate: &'a Estimate) -> MinimumEntry<'a> {
    let ParameterEstimate { parameter, value, .. } = &estimate.parameters[other.parameter];
    MinimumEntry {
        tool_distance: other.tool_distance,
        cost_ratio: other.cost_ratio,
        parameter: &parameter.name,
        unit: parameter.unit.symbol(),
        there: other.values[other.parameter],
        here: *value,
    }
}

fn effect_entry<'a>(test: &'a EffectTest, thresholds: &WarningThresholds) -> EffectEntry<'a> {
    EffectEntry {
        name: test.effect.name(),
        description: test.effect.description(),
        remedy: test.effect.remedy(),
        declared_in: test.effect.declared_in(),
        is_significant: test.p_value < thresholds.listed_p_value,
        p_value: p_value_text(test.p_value),
        values: test.strongest_values().into_iter().map(value_entry).collect(),
        displacement: Some(test.displacement),
        radius: Some(test.radius),
    }
}

fn declared_entry<'a>(test: &'a PriorTest, thresholds: &WarningThresholds) -> EffectEntry<'a> {
    EffectEntry {
        name: test.declaration.name(),
        description: test.declaration.description(),
        remedy: test.declaration.remedy(),
        declared_in: test.declaration.declared_in(),
        is_significant: test.is_contradicted(thresholds.listed_p_value, thresholds.prior_deviations[0]),
        p_value: p_value_text(test.p_value),
        values: test.strongest_values().into_iter().map(declared_value).collect(),
        displacement: test.displacement,
        radius: None,
    }
}

fn value_entry(entry: &EffectValue) -> ValueEntry<'_> {
    ValueEntry { name: &entry.name, unit: entry.unit.symbol(), value: entry.value, sigma: entry.sigma }
}

fn declared_value(entry: &DeclaredValue) -> ValueEntry<'_> {
    ValueEntry { name: &entry.name, unit: entry.unit.symbol(), value: entry.value, sigma: entry.sigma }
}

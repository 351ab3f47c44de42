//! What contacts say against the problem, and what is assumed where it says nothing.

use serde::Serialize;

use crate::estimate::{EffectTest, EffectValue, Estimate, Problem};

/// The page's data of what is declared and assumed.
#[derive(Serialize)]
pub(super) struct Declarations<'a> {
    /// Tests of effects that the model leaves out, the most significant first.
    effects: Vec<EffectEntry<'a>>,
    /// Assumptions in words.
    notes: &'a [String],
    /// Whether intervals allow for errors of the arm that contacts would not show.
    allows_for_unseen_effects: bool,
}

#[derive(Serialize)]
struct EffectEntry<'a> {
    name: String,
    description: String,
    remedy: &'static str,
    /// Where a problem file leaves the effect out.
    declared_in: String,
    is_significant: bool,
    /// Probability that it is chance.
    p_value: String,
    /// Those that contacts see, the most standard deviations from zero first.
    values: Vec<ValueEntry<'a>>,
    /// Motion of the tool, and radius of its reported region (m).
    displacement: f64,
    radius: f64,
}

/// A value that a parameter of the effect would take (SI).
#[derive(Serialize)]
struct ValueEntry<'a> {
    name: &'a str,
    unit: &'static str,
    value: f64,
    sigma: f64,
}

impl<'a> Declarations<'a> {
    /// The page's data of a problem and its estimate.
    pub fn new(problem: &'a Problem, estimate: &'a Estimate) -> Self {
        let threshold = problem.options.thresholds.effect_p_value;
        Declarations {
            effects: estimate.effect_tests.iter().map(|test| effect_entry(test, threshold)).collect(),
            notes: problem.contacts.notes(),
            allows_for_unseen_effects: problem.allows_for_unseen_effects(),
        }
    }
}

fn effect_entry(test: &EffectTest, threshold: f64) -> EffectEntry<'_> {
    EffectEntry {
        name: test.effect.name(),
        description: test.effect.description(),
        remedy: test.effect.remedy(),
        declared_in: test.effect.declared_in(),
        is_significant: test.p_value < threshold,
        p_value: format!("{:.0e}", test.p_value),
        values: test.strongest_values().into_iter().map(value_entry).collect(),
        displacement: test.displacement,
        radius: test.radius,
    }
}

fn value_entry(entry: &EffectValue) -> ValueEntry<'_> {
    ValueEntry { name: &entry.name, unit: entry.unit.symbol(), value: entry.value, sigma: entry.sigma }
}

//! Tests of what a problem declares with a standard deviation.

use super::warning_text::far_from_prior_advice;
use crate::parameter::Unit;

/// The estimate of one declared quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredValue {
    /// Name of the parameter, of the distance, or of the gap by direction.
    pub name: String,
    /// Unit of value and standard deviation.
    pub unit: Unit,
    /// Estimate minus declared value (SI); of noise the estimate over the declared value.
    pub value: f64,
    /// Standard deviation (SI) of the declared value; of noise that of the estimate.
    pub sigma: f64,
}

/// A test of the hypothesis that something declared is right within its standard deviations: the
/// posterior against its prior.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorTest {
    /// What is declared: `tool`, `fixture.{name}`, `distance.{a}.{b}`, `gap_bias.{fixture}`
    /// (outline, clearance and depth), `wrench`, `noise`, or a block of parameters of the arm with
    /// priors, such as `joint_origin`.
    pub name: String,
    /// Statistic (1): chi-squared distributed if what is declared is right.
    pub statistic: f64,
    /// Number of directions in which contacts say more than what is declared.
    pub degrees_of_freedom: usize,
    /// Probability (0 to 1) of a statistic as large by chance, times the number of these tests, at
    /// most 1 (Bonferroni).
    pub p_value: f64,
    /// The estimates.
    pub values: Vec<DeclaredValue>,
    /// Root mean square motion (m) of the tool in base, in the poses of the task or over the
    /// workspace, between this result and the one with what is declared held exact; 0 for noise.
    pub displacement: f64,
}

impl PriorTest {
    /// The values, the one that is most standard deviations from what is declared first.
    pub fn strongest_values(&self) -> Vec<&DeclaredValue> {
        let mut values: Vec<&DeclaredValue> = self.values.iter().collect();
        let deviations = |entry: &DeclaredValue| (entry.value / entry.sigma.max(f64::MIN_POSITIVE)).abs();
        values.sort_by(|a, b| deviations(b).total_cmp(&deviations(a)));
        values
    }

    /// What is declared, in English words.
    pub fn description(&self) -> String {
        let (kind, name) = self.name.split_once('.').unwrap_or((&self.name, ""));
        match kind {
            "tool" => "the tool's place".to_owned(),
            "fixture" => format!("the place of fixture `{name}`"),
            "gap_bias" => format!("outline, clearance and depth of fixture `{name}`, as gaps at contact"),
            "distance" => "the distance between two fixtures".to_owned(),
            "wrench" => "bias and scale of the measured wrench".to_owned(),
            "noise" => "the scatter of contacts".to_owned(),
            _ => format!("parameters `{kind}` within their priors"),
        }
    }

    /// What to do where contacts contradict the declaration, without a full stop.
    pub fn remedy(&self) -> &'static str {
        match self.name.as_str() {
            "noise" => "declare a larger noise, or leave out `[noise]` so that it is estimated",
            "wrench" => "zero the force sensor, or give bias and scale of the wrench a larger standard deviation",
            name => far_from_prior_advice(name),
        }
    }

    /// Key and table of a problem file (`problem.toml`) that declare it, such as
    /// `sigma_mm, sigma_deg in [tool]`.
    pub fn declared_in(&self) -> String {
        let (kind, name) = self.name.split_once('.').unwrap_or((&self.name, ""));
        match kind {
            "tool" => "sigma_mm, sigma_deg in [tool]".to_owned(),
            "fixture" => format!("sigma_mm, sigma_deg in [[fixture]] {name}"),
            "gap_bias" => format!("clearance_sigma_mm in [[fixture]] {name}"),
            "distance" => "distance_mm, sigma_mm in [[distance]]".to_owned(),
            "wrench" | "noise" => "[noise]".to_owned(),
            _ => "[estimate]".to_owned(),
        }
    }
}

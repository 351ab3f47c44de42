//! Tests of what a problem declares with a standard deviation.

use serde::{Deserialize, Serialize};

use super::warning_text::far_from_prior_advice;
use crate::parameter::{Block, Unit};

/// Something that a problem declares with a standard deviation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Declaration {
    /// The place of the tool.
    ToolPlace,
    /// The place of a fixture.
    FixturePlace {
        /// Name of the fixture.
        fixture: String,
    },
    /// Outline, clearance and depth of a fixture.
    Shape {
        /// Name of the fixture.
        fixture: String,
    },
    /// A distance between two fixtures.
    Distance {
        /// Names of the fixtures.
        between: [String; 2],
    },
    /// Bias and scale of the measured wrench.
    Wrench,
    /// Standard deviations of encoders and contacts.
    Noise,
    /// Parameters of the arm with priors.
    Parameters(Block),
}

impl Declaration {
    /// Name in files: `tool`, `fixture.{name}`, `gap_bias.{fixture}`, `distance.{a}.{b}`, `wrench`,
    /// `noise`, or the name of a block of parameters, such as `joint_origin`.
    pub fn name(&self) -> String {
        match self {
            Declaration::ToolPlace => "tool".to_owned(),
            Declaration::FixturePlace { fixture } => format!("fixture.{fixture}"),
            Declaration::Shape { fixture } => format!("gap_bias.{fixture}"),
            Declaration::Distance { between: [a, b] } => format!("distance.{a}.{b}"),
            Declaration::Wrench => "wrench".to_owned(),
            Declaration::Noise => "noise".to_owned(),
            Declaration::Parameters(block) => block.name().to_owned(),
        }
    }

    /// What is declared, in English words.
    pub fn description(&self) -> String {
        match self {
            Declaration::ToolPlace => "the tool's place".to_owned(),
            Declaration::FixturePlace { fixture } => format!("the place of fixture `{fixture}`"),
            Declaration::Shape { fixture } => {
                format!("outline, clearance and depth of fixture `{fixture}`, as gaps at contact")
            }
            Declaration::Distance { between: [a, b] } => format!("the distance of fixtures `{a}` and `{b}`"),
            Declaration::Wrench => "bias and scale of the measured wrench".to_owned(),
            Declaration::Noise => "the scatter of contacts".to_owned(),
            Declaration::Parameters(block) => format!("parameters `{}` within their priors", block.name()),
        }
    }

    /// What to do where contacts contradict it, without a full stop.
    pub fn remedy(&self) -> &'static str {
        match self {
            Declaration::Noise => "declare a larger noise, or leave out `[noise]` so that it is estimated",
            Declaration::Wrench => {
                "zero the force sensor, or give bias and scale of the wrench a larger standard deviation"
            }
            other => far_from_prior_advice(&other.name()),
        }
    }

    /// Keys and table of a problem file (`problem.toml`) that declare it, such as
    /// `tip_from_tool in [tool]`.
    pub fn declared_in(&self) -> String {
        match self {
            Declaration::ToolPlace => "tip_from_tool in [tool]".to_owned(),
            Declaration::FixturePlace { fixture } => format!("base_from_fixture in [[fixture]] {fixture}"),
            Declaration::Shape { fixture } => format!("outline, depth_mm in [[fixture]] {fixture}"),
            Declaration::Distance { .. } => "mm in [[distance]]".to_owned(),
            Declaration::Wrench | Declaration::Noise => "[noise]".to_owned(),
            Declaration::Parameters(_) => "[estimate]".to_owned(),
        }
    }
}

/// The estimate of one declared quantity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DeclaredValue {
    /// Name of the parameter or of the distance; of gaps at contact in one direction that of its
    /// directional gap bias, to which the common one is added here.
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PriorTest {
    /// What is declared.
    pub declaration: Declaration,
    /// Statistic (1): at most chi-squared distributed if what is declared is right.
    pub statistic: f64,
    /// Number of directions in which contacts and other declarations say more than this one.
    pub degrees_of_freedom: usize,
    /// Probability (0 to 1) of a statistic as large by chance, times the number of these tests, at
    /// most 1 (Bonferroni).
    pub p_value: f64,
    /// The estimates.
    pub values: Vec<DeclaredValue>,
    /// Root mean square motion (m) of the tool, in the poses of the task or over the
    /// workspace, between this result and the one with what is declared held exact; `None` for
    /// noise, for shapes, whose gaps are estimated whatever is declared, and where nothing changes
    /// the quantity.
    pub displacement: Option<f64>,
}

impl PriorTest {
    /// Whether contacts contradict what is declared: with a p-value below `p_value`, or with one
    /// value that is more than so many `deviations` (standard deviations) from what is declared.
    pub fn is_contradicted(&self, p_value: f64, deviations: f64) -> bool {
        let has_far_values = !matches!(self.declaration, Declaration::Shape { .. } | Declaration::Noise);
        let is_far = |entry: &DeclaredValue| entry.value.abs() > deviations * entry.sigma;
        self.p_value < p_value || has_far_values && self.values.iter().any(is_far)
    }

    /// The values, the one that is most standard deviations from what is declared first.
    pub fn strongest_values(&self) -> Vec<&DeclaredValue> {
        let mut values: Vec<&DeclaredValue> = self.values.iter().collect();
        let deviations = |entry: &DeclaredValue| (entry.value / entry.sigma.max(f64::MIN_POSITIVE)).abs();
        values.sort_by(|a, b| deviations(b).total_cmp(&deviations(a)));
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_far_from_what_is_declared_is_enough() {
        let is_contradicted = |declaration: Declaration, deviations: f64, p_value: f64| {
            let entry = DeclaredValue { name: "x".to_owned(), unit: Unit::Meter, value: deviations, sigma: 1.0 };
            let (values, displacement) = (vec![entry], None);
            let test = PriorTest { declaration, statistic: 1.0, degrees_of_freedom: 6, p_value, values, displacement };
            test.is_contradicted(1e-3, 4.0)
        };
        assert!(
            is_contradicted(Declaration::ToolPlace, -4.1, 0.02) && !is_contradicted(Declaration::ToolPlace, 3.9, 0.02)
        );
        assert!(is_contradicted(Declaration::ToolPlace, 0.0, 9e-4) && !is_contradicted(Declaration::Noise, 4.1, 0.02));
    }
}

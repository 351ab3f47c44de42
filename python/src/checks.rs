//! What contacts say against a problem: tests of effects that are left out and of declarations, and
//! the prediction of stretches of the log.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, DeclaredValue, EffectValue};

use crate::repr::{length, number};

/// A score test of an effect that the model leaves out.
///
/// Attributes:
///     effect: for programs: "joint_compliance", "segment_strain", "joint_origin",
///         "joint_harmonic", "joint_trend", "joint_walk", "tool", "fixture.{name}",
///         "edge_radius.{fixture}", "distance.{a}.{b}" or "wrench".
///     description: the effect in words.
///     declared_in: key and table of a problem file that leave it out.
///     remedy: what to do about it.
///     statistic: score statistic, chi-squared distributed if the effect is zero.
///     degrees_of_freedom: number of directions tested.
///     p_value: probability, 0 to 1, of a statistic as large by chance, times the number of tests.
///     values: by name of the parameter that the effect would have, its one-step estimate and the
///         standard deviation of that, in SI units.
///     displacement: root mean square motion of the tool, in the poses of the task or over the
///         workspace, if the effect were estimated (m).
///     radius: root mean square radius of the tool's reported 95 % region in the same poses (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectTest {
    effect: String,
    description: String,
    declared_in: String,
    remedy: String,
    statistic: f64,
    degrees_of_freedom: usize,
    p_value: f64,
    values: BTreeMap<String, (f64, f64)>,
    displacement: f64,
    radius: f64,
}

impl From<&estimate::EffectTest> for EffectTest {
    fn from(test: &estimate::EffectTest) -> Self {
        let value = |entry: &EffectValue| (entry.name.clone(), (entry.value, entry.sigma));
        EffectTest {
            effect: test.effect.name(),
            description: test.effect.description(),
            declared_in: test.effect.declared_in(),
            remedy: test.effect.remedy().to_owned(),
            statistic: test.statistic,
            degrees_of_freedom: test.degrees_of_freedom,
            p_value: test.p_value,
            values: test.values.iter().map(value).collect(),
            displacement: test.displacement,
            radius: test.radius,
        }
    }
}

#[pymethods]
impl EffectTest {
    fn __repr__(&self) -> String {
        let EffectTest { effect, p_value, displacement, .. } = self;
        format!("EffectTest({effect:?}, p = {}, moves the tool by {})", number(*p_value), length(*displacement))
    }
}

/// A test of something declared with a standard deviation: the posterior against its prior.
///
/// Attributes:
///     name: for programs: "tool", "fixture.{name}", "distance.{a}.{b}", "gap_bias.{fixture}"
///         (outline, clearance and depth), "wrench", "noise", or a block of parameters of the arm
///         with priors, such as "joint_origin".
///     description: what is declared, in words.
///     declared_in: keys and table of a problem file that declare it.
///     remedy: what to do where contacts contradict it.
///     statistic: chi-squared distributed if what is declared is right.
///     degrees_of_freedom: number of directions tested.
///     p_value: probability, 0 to 1, of a statistic as large by chance, times the number of tests.
///     values: by name the estimate less the declared value, and the standard deviation declared,
///         in SI units; of "noise" the estimate over the declared value, and the standard deviation
///         of that.
///     displacement: root mean square motion of the tool between this result and the one with what
///         is declared held exact (m); None for noise, and where nothing changes the quantity.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PriorTest {
    name: String,
    description: String,
    declared_in: String,
    remedy: String,
    statistic: f64,
    degrees_of_freedom: usize,
    p_value: f64,
    values: BTreeMap<String, (f64, f64)>,
    displacement: Option<f64>,
}

impl From<&estimate::PriorTest> for PriorTest {
    fn from(test: &estimate::PriorTest) -> Self {
        let value = |entry: &DeclaredValue| (entry.name.clone(), (entry.value, entry.sigma));
        PriorTest {
            name: test.declaration.name(),
            description: test.declaration.description(),
            declared_in: test.declaration.declared_in(),
            remedy: test.declaration.remedy().to_owned(),
            statistic: test.statistic,
            degrees_of_freedom: test.degrees_of_freedom,
            p_value: test.p_value,
            values: test.values.iter().map(value).collect(),
            displacement: test.displacement,
        }
    }
}

#[pymethods]
impl PriorTest {
    fn __repr__(&self) -> String {
        let PriorTest { name, p_value, displacement, .. } = self;
        let moves = displacement.map_or_else(String::new, |by| format!(", moves the tool by {}", length(by)));
        format!("PriorTest({name:?}, p = {}{moves})", number(*p_value))
    }
}

/// How far stretches of the log are from what all others predict: a stretch is left out, and its
/// contacts are compared with those that the estimates without it predict.
///
/// Attributes:
///     ratio: scatter found over scatter predicted, over all stretches; about 1 if the model is
///         right.
///     p_value: probability of a ratio as large by chance.
///     widening: factor by which standard deviations were multiplied for it.
///     stretches: ratio of each stretch, in the order of the log.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PredictiveCheck {
    ratio: f64,
    p_value: f64,
    widening: f64,
    stretches: Vec<f64>,
}

impl From<&estimate::PredictiveCheck> for PredictiveCheck {
    fn from(check: &estimate::PredictiveCheck) -> Self {
        let estimate::PredictiveCheck { ratio, p_value, widening, stretches } = check.clone();
        PredictiveCheck { ratio, p_value, widening, stretches }
    }
}

#[pymethods]
impl PredictiveCheck {
    fn __repr__(&self) -> String {
        format!("PredictiveCheck(ratio {}, p = {})", number(self.ratio), number(self.p_value))
    }
}

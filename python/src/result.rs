//! Parts of a result: parameters, undetermined directions, warnings, termination.

use std::collections::BTreeMap;

use pyo3::prelude::*;
use touchcal::estimate::{self, DeclaredValue, EffectValue, Identifiability};
use touchcal::io::estimate_file::{ParameterEntry, Severity, WarningEntry};

use crate::repr::{python_bool, shown};

/// One estimated number.
///
/// Attributes:
///     name: "joint_offset.joint_a1".
///     block: "joint_offset".
///     unit: "m", "rad", "1", "rad/(N m)", "N" or "N m".
///     value: the estimate.
///     sigma: its standard deviation; None where the data do not determine it.
///     prior_sigma: standard deviation of its prior, where it has one.
///     identifiable: whether the data determine it.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    name: String,
    block: String,
    unit: String,
    value: f64,
    sigma: Option<f64>,
    prior_sigma: Option<f64>,
    identifiable: bool,
}

impl From<&ParameterEntry> for Parameter {
    fn from(entry: &ParameterEntry) -> Self {
        let ParameterEntry { name, block, unit, value, sigma, prior_sigma, identifiable } = entry.clone();
        Parameter { name, block, unit, value, sigma, prior_sigma, identifiable }
    }
}

#[pymethods]
impl Parameter {
    fn __repr__(&self) -> String {
        let Parameter { name, value, sigma, unit, identifiable, .. } = self;
        let (sigma, known) = (shown(*sigma), python_bool(*identifiable));
        format!("Parameter({name:?}, value={value:?}, sigma={sigma}, unit={unit:?}, identifiable={known})")
    }
}

/// A direction of the parameters that the data do not determine.
///
/// Attributes:
///     description: what cannot be determined.
///     remedy: what would determine it besides other contacts; None where nothing that is declared
///         takes part.
///     direction: parts of the parameters by name, in units of their scales; the largest is 1.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct NullDirection {
    description: String,
    remedy: Option<String>,
    direction: BTreeMap<String, f64>,
}

impl NullDirection {
    /// All of them; `name(k)` is that of parameter number `k`.
    pub fn each(found: &Identifiability, name: impl Fn(usize) -> String) -> Vec<NullDirection> {
        let each = found.null_space.iter().map(|null| NullDirection {
            description: null.description.clone(),
            remedy: null.remedy.clone(),
            direction: null.direction.iter().map(|&(k, part)| (name(k), part)).collect(),
        });
        each.collect()
    }
}

#[pymethods]
impl NullDirection {
    fn __repr__(&self) -> String {
        format!("NullDirection({:?})", self.description)
    }
}

/// A warning about a problem or a result.
///
/// Attributes:
///     kind: for programs: "too_few_contacts".
///     severity: "unusable" if the result must not be used, "doubtful" if contacts contradict
///         something, else "caution".
///     message: what is wrong.
///     advice: what to do about it.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    kind: String,
    severity: &'static str,
    message: String,
    advice: String,
}

impl From<WarningEntry> for Warning {
    fn from(WarningEntry { kind, severity, message, advice }: WarningEntry) -> Warning {
        let severity = match severity {
            Severity::Unusable => "unusable",
            Severity::Doubtful => "doubtful",
            Severity::Caution => "caution",
        };
        Warning { kind, severity, message, advice }
    }
}

#[pymethods]
impl Warning {
    fn __repr__(&self) -> String {
        format!("Warning({:?}, {:?})", self.kind, self.message)
    }
}

/// A score test of an effect that the model leaves out.
///
/// Attributes:
///     effect: for programs: "joint_compliance", "segment_strain", "joint_origin",
///         "joint_harmonic", "joint_trend", "joint_walk", "tool", "fixture.{name}" or
///         "wrench".
///     description: the effect in words.
///     statistic: score statistic, chi-squared distributed if the effect is zero.
///     degrees_of_freedom: number of directions tested.
///     p_value: probability, 0 to 1, of a statistic as large by chance, times the number of tests.
///     values: by name of the parameter that the effect would have, its one-step estimate and the
///         standard deviation of that, in SI units.
///     displacement: root mean square motion of the tool, in the poses of the task or over the
///         workspace, if the effect were estimated (m).
///     radius: root mean square radius of the tool's reported 95 % region in the same poses (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct EffectTest {
    effect: String,
    description: String,
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
        format!("EffectTest({effect:?}, p_value={p_value:?}, displacement={displacement:?})")
    }
}

/// A test of something declared with a standard deviation: the posterior against its prior.
///
/// Attributes:
///     name: for programs: "tool", "fixture.{name}", "distance.{a}.{b}", "gap_bias.{fixture}"
///         (outline, clearance and depth), "wrench", "noise", or a block of parameters of the arm
///         with priors, such as "joint_origin".
///     description: what is declared, in words.
///     statistic: chi-squared distributed if what is declared is right.
///     degrees_of_freedom: number of directions tested.
///     p_value: probability, 0 to 1, of a statistic as large by chance, times the number of tests.
///     values: by name the estimate less the declared value, and the standard deviation declared,
///         in SI units; of "noise" the estimate over the declared value, and the standard deviation
///         of that.
///     displacement: root mean square motion of the tool between this result and the one with what
///         is declared held exact (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct PriorTest {
    name: String,
    description: String,
    statistic: f64,
    degrees_of_freedom: usize,
    p_value: f64,
    values: BTreeMap<String, (f64, f64)>,
    displacement: f64,
}

impl From<&estimate::PriorTest> for PriorTest {
    fn from(test: &estimate::PriorTest) -> Self {
        let value = |entry: &DeclaredValue| (entry.name.clone(), (entry.value, entry.sigma));
        PriorTest {
            name: test.name.clone(),
            description: test.description(),
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
        format!("PriorTest({name:?}, p_value={p_value:?}, displacement={displacement:?})")
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
#[derive(Clone, Debug, PartialEq)]
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
        format!("PredictiveCheck(ratio={:?}, p_value={:?})", self.ratio, self.p_value)
    }
}

/// Standard deviations of the calibrated arm's tool, root mean squares over joint positions spread
/// evenly over the workspace.
///
/// Attributes:
///     position: of the tool's position in base, all three components together (m).
///     angle: of the tool's rotation vector in base, all three components together (rad).
///     distance: of the distance between two positions of the tool, which does not depend on where
///         the base is (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct WorkspaceUncertainty {
    position: f64,
    angle: f64,
    distance: f64,
}

impl From<estimate::WorkspaceUncertainty> for WorkspaceUncertainty {
    fn from(found: estimate::WorkspaceUncertainty) -> Self {
        let estimate::WorkspaceUncertainty { position, angle, distance } = found;
        WorkspaceUncertainty { position, angle, distance }
    }
}

#[pymethods]
impl WorkspaceUncertainty {
    fn __repr__(&self) -> String {
        let WorkspaceUncertainty { position, angle, distance } = self;
        format!("WorkspaceUncertainty(position={position:?}, angle={angle:?}, distance={distance:?})")
    }
}

/// A minimum in which a search from another start ended, and which contacts do not rule out.
///
/// Attributes:
///     tool_distance: distance of the tool from where the result has it, root mean square over the
///         workspace (m).
///     cost_ratio: cost of the least gaps over that at the result.
///     parameter: name of the parameter of arm or tool that differs most.
///     values: values of all parameters by name (SI).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct CompetingMinimum {
    tool_distance: f64,
    cost_ratio: f64,
    parameter: String,
    values: BTreeMap<String, f64>,
}

impl CompetingMinimum {
    pub fn new(other: &estimate::CompetingMinimum, parameters: &[estimate::ParameterEstimate]) -> Self {
        let names = parameters.iter().map(|entry| entry.parameter.name.clone());
        CompetingMinimum {
            tool_distance: other.tool_distance,
            cost_ratio: other.cost_ratio,
            parameter: parameters[other.parameter].parameter.name.clone(),
            values: names.zip(other.values.iter().copied()).collect(),
        }
    }
}

#[pymethods]
impl CompetingMinimum {
    fn __repr__(&self) -> String {
        let CompetingMinimum { tool_distance, cost_ratio, parameter, .. } = self;
        format!("CompetingMinimum(tool_distance={tool_distance:?}, cost_ratio={cost_ratio:?}, parameter={parameter:?})")
    }
}

/// Whether a calibration reaches what the table [accept] of its problem asks for.
///
/// Attributes:
///     decision: "pass", "fail" or "undecided".
///     probability: probability that the tool is within the tolerance in all poses of the task;
///         None where the result must not be used.
///     distance: largest distance over the poses that is not exceeded with the confidence asked
///         for (m).
///     angle: largest angle that is not exceeded with that confidence (rad).
///     worst_pose: index of the pose with the largest variance.
///     parameter: the parameter whose exact value would take away most of that variance.
///     share: the share that it would take away.
///     message: the decision as a sentence.
///     advice: what to do next.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct Acceptance {
    decision: String,
    probability: Option<f64>,
    distance: Option<f64>,
    angle: Option<f64>,
    worst_pose: Option<usize>,
    parameter: Option<String>,
    share: Option<f64>,
    message: String,
    advice: String,
}

impl Acceptance {
    pub fn new(asked: &estimate::Acceptance, result: &estimate::AcceptanceResult) -> Self {
        let errors = result.errors.as_ref();
        Acceptance {
            decision: result.decision.name().to_owned(),
            probability: errors.map(|errors| errors.probability),
            distance: errors.map(|errors| errors.distance),
            angle: errors.map(|errors| errors.angle),
            worst_pose: errors.map(|errors| errors.worst_pose),
            parameter: errors.map(|errors| errors.parameter.clone()),
            share: errors.map(|errors| errors.share),
            message: result.message(asked),
            advice: result.advice(),
        }
    }
}

#[pymethods]
impl Acceptance {
    fn __repr__(&self) -> String {
        format!("Acceptance({:?})", self.message)
    }
}

/// Why the search stopped.
///
/// Attributes:
///     reason: "converged", "iteration_limit", "no_descent" or "not_finite".
///     measured: value of the criterion.
///     threshold: its threshold.
///     iterations: steps made.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct Termination {
    reason: &'static str,
    measured: f64,
    threshold: f64,
    iterations: usize,
}

#[pymethods]
impl Termination {
    fn __repr__(&self) -> String {
        format!("Termination({:?}, iterations={})", self.reason, self.iterations)
    }
}

impl From<&estimate::Termination> for Termination {
    fn from(termination: &estimate::Termination) -> Self {
        let estimate::Termination { reason, measured, threshold, iterations } = *termination;
        Termination { reason: reason.name(), measured, threshold, iterations }
    }
}

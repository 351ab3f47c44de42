//! Parts of a result: parameters, undetermined directions, warnings, termination.

use std::borrow::Cow;
use std::collections::BTreeMap;

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, Identifiability};
use touchcal::io::estimate_file::{self, ParameterEntry, Severity, WarningEntry, WorkspaceUncertaintyEntry};

use touchcal::parameter::Unit;

use crate::repr::{angle, length, number, quantity};

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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
        let value = quantity(Unit::from_symbol(unit).unwrap_or(Unit::One), *value, *sigma);
        let mark = if *identifiable { "" } else { ", not identifiable" };
        format!("Parameter({name:?}, {value}{mark})")
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

impl From<estimate_file::NullDirection> for NullDirection {
    fn from(estimate_file::NullDirection { description, remedy, direction }: estimate_file::NullDirection) -> Self {
        NullDirection { description, remedy, direction }
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
///         something or are few, else "caution".
///     message: what is wrong.
///     advice: what to do about it.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibrationWarning {
    kind: String,
    severity: Cow<'static, str>,
    message: String,
    advice: String,
}

impl From<WarningEntry> for CalibrationWarning {
    fn from(WarningEntry { kind, severity, message, advice }: WarningEntry) -> CalibrationWarning {
        let severity = match severity {
            Severity::Unusable => "unusable",
            Severity::Doubtful => "doubtful",
            Severity::Caution => "caution",
        };
        CalibrationWarning { kind, severity: severity.into(), message, advice }
    }
}

#[pymethods]
impl CalibrationWarning {
    fn __repr__(&self) -> String {
        format!("CalibrationWarning({:?}, {:?})", self.kind, self.message)
    }
}

/// Expected errors of the tool, root mean squares over joint positions spread evenly over the
/// workspace: standard deviations for the calibrated arm, and for the nominal one its distance from
/// the calibrated arm together with these. Harmonics of the encoders count as corrected in both.
///
/// Attributes:
///     position: of the tool's position in base, all three components together (m).
///     angle: of the tool's rotation vector in base, all three components together (rad).
///     distance: of the distance between two positions of the tool, which does not depend on where
///         the base is (m).
///     nominal_position: expected error of the nominal arm's tool: of its position in base (m).
///     nominal_angle: of its rotation (rad).
///     nominal_distance: of the distance between two of its positions (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkspaceUncertainty {
    position: f64,
    angle: f64,
    distance: f64,
    nominal_position: f64,
    nominal_angle: f64,
    nominal_distance: f64,
}

impl From<estimate::WorkspaceUncertainty> for WorkspaceUncertainty {
    fn from(found: estimate::WorkspaceUncertainty) -> Self {
        WorkspaceUncertainty {
            position: found.position,
            angle: found.angle,
            distance: found.distance,
            nominal_position: found.nominal_position,
            nominal_angle: found.nominal_angle,
            nominal_distance: found.nominal_distance,
        }
    }
}

impl From<WorkspaceUncertaintyEntry> for WorkspaceUncertainty {
    fn from(found: WorkspaceUncertaintyEntry) -> Self {
        WorkspaceUncertainty {
            position: 1e-3 * found.position_mm,
            angle: found.angle_deg.to_radians(),
            distance: 1e-3 * found.distance_mm,
            nominal_position: 1e-3 * found.nominal_position_mm,
            nominal_angle: found.nominal_angle_deg.to_radians(),
            nominal_distance: 1e-3 * found.nominal_distance_mm,
        }
    }
}

#[pymethods]
impl WorkspaceUncertainty {
    fn __repr__(&self) -> String {
        let [position, nominal_position] = [self.position, self.nominal_position].map(length);
        let [turn, nominal_turn] = [self.angle, self.nominal_angle].map(angle);
        let [distance, nominal_distance] = [self.distance, self.nominal_distance].map(length);
        format!(
            "WorkspaceUncertainty({position}, {turn}, distances {distance}; before: {nominal_position}, \
             {nominal_turn}, distances {nominal_distance})"
        )
    }
}

/// A minimum in which a search from another start ended, and which contacts do not rule out.
///
/// Attributes:
///     tool_distance: distance of the tool from where the result has it, root mean square in the
///         poses of the task or over the workspace (m).
///     cost_ratio: cost of the least gaps over that at the result.
///     parameter: name of the parameter of arm or tool that differs most.
///     values: values of all parameters by name (SI).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
        let (away, ratio) = (length(*tool_distance), number(*cost_ratio));
        format!("CompetingMinimum({away} away, {ratio} times the cost, differs most in {parameter:?})")
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
///     aligned_probability: probability that the tool is within the tolerance, with the base
///         aligned.
///     message: the decision as a sentence.
///     advice: what to do next.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Acceptance {
    decision: String,
    probability: Option<f64>,
    distance: Option<f64>,
    angle: Option<f64>,
    worst_pose: Option<usize>,
    parameter: Option<String>,
    share: Option<f64>,
    aligned_probability: Option<f64>,
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
            aligned_probability: errors.and_then(|errors| errors.aligned_probability),
            message: result.message(asked),
            advice: result.advice(asked),
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Termination {
    reason: Cow<'static, str>,
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
        Termination { reason: reason.name().into(), measured, threshold, iterations }
    }
}

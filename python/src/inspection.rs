//! Expected standard deviations and identifiability before calibration.

use std::borrow::Cow;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, StopReason};
use touchcal::io::estimate_file::WarningEntry;
use touchcal::parameter::Unit;
use touchcal::robot::JointKind;

use crate::array::fixed;
use crate::error::{Given, argument};
use crate::frame::Frame;
use crate::pickle::{Reduced, reduced};
use crate::problem::Problem;
use crate::progress::Observer;
use crate::repr::{number, quantity};
use crate::result::{CalibrationWarning, NullDirection};
use crate::score::Score;
use crate::threads::detached;

/// Expected standard deviation of a parameter.
///
/// Attributes:
///     name: "joint_offset.joint_a1".
///     unit: of sigma: "m", "rad", "1", "rad/(N m)", "N" or "N m".
///     sigma: expected standard deviation; None where nothing bounds it, or with a projection.
///     prior_sigma: standard deviation of its prior, where it has one.
///     identifiable: whether the data determine it.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Expected {
    name: String,
    unit: Cow<'static, str>,
    sigma: Option<f64>,
    prior_sigma: Option<f64>,
    identifiable: bool,
}

#[pymethods]
impl Expected {
    fn __repr__(&self) -> String {
        let unit = Unit::from_symbol(&self.unit).unwrap_or(Unit::One);
        let sigma =
            self.sigma.map_or_else(|| "no sigma".to_owned(), |sigma| format!("± {}", quantity(unit, sigma, None)));
        let mark = if self.identifiable { "" } else { ", not identifiable" };
        format!("Expected({:?}, {sigma}{mark})", self.name)
    }
}

/// The range of a joint's measured positions.
///
/// Attributes:
///     joint: its name.
///     least, most: rad or m.
///     share: share of the joint's limits that this covers, where it has limits.
#[pyclass(frozen, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointRange {
    #[pyo3(get)]
    joint: String,
    #[pyo3(get)]
    least: f64,
    #[pyo3(get)]
    most: f64,
    #[pyo3(get)]
    share: Option<f64>,
    unit: Unit,
}

#[pymethods]
impl JointRange {
    fn __repr__(&self) -> String {
        let [least, most] = [self.least, self.most].map(|position| quantity(self.unit, position, None));
        let share = self.share.map_or_else(String::new, |share| format!(", {} % of its limits", number(1e2 * share)));
        format!("JointRange({:?}, {least} to {most}{share})", self.joint)
    }
}

/// What a problem's contacts determine, with the assumed noise and without outliers.
///
/// Attributes:
///     rank: number of directions of the parameters that the data determine.
///     condition: largest over smallest singular value of those.
///     observability: indices O1 to O5 (Sun & Hollerbach 2008), shape (5,).
///     converged: whether the coarse stage did; if not, expectations are rough.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug)]
pub struct Inspection {
    pub problem: Py<Problem>,
    pub inspection: estimate::Inspection,
}

#[pymethods]
impl Inspection {
    #[getter]
    fn rank(&self) -> usize {
        self.inspection.identifiability.rank
    }

    #[getter]
    fn condition(&self) -> f64 {
        self.inspection.identifiability.condition
    }

    #[getter]
    fn observability<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        fixed(py, self.inspection.observability.to_vec())
    }

    #[getter]
    fn converged(&self) -> bool {
        self.inspection.reason == StopReason::Converged
    }

    /// Singular values of the whitened Jacobian in units of the parameters' scales, largest first.
    #[getter]
    fn singular_values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        fixed(py, self.inspection.identifiability.singular_values.clone())
    }

    /// Every parameter, in order.
    #[getter]
    fn parameters(&self) -> Vec<Expected> {
        let each = self.inspection.parameters.iter().map(|expected| Expected {
            name: expected.parameter.name.clone(),
            unit: expected.parameter.unit.symbol().into(),
            sigma: expected.sigma,
            prior_sigma: expected.parameter.prior_sigma(),
            identifiable: expected.identifiable,
        });
        each.collect()
    }

    /// Range of every moving joint, in order; none without contacts.
    #[getter]
    fn ranges(&self) -> Vec<JointRange> {
        let robot = &self.problem.get().loaded.problem.robot;
        let unit = |name: &str| match robot.moving().find(|joint| joint.name == name).map(|joint| joint.kind) {
            Some(JointKind::Prismatic) => Unit::Meter,
            _ => Unit::Radian,
        };
        let each = self.inspection.ranges.iter().cloned();
        each.map(|estimate::JointRange { joint, least, greatest: most, share }| JointRange {
            unit: unit(&joint),
            joint,
            least,
            most,
            share,
        })
        .collect()
    }

    /// Number of contacts by name of the fixture.
    #[getter]
    fn per_fixture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counts = PyDict::new(py);
        let fixtures = &self.problem.get().loaded.problem.fixtures;
        let each = fixtures.iter().zip(&self.inspection.nominal.per_fixture);
        each.into_iter().try_for_each(|(fixture, spread)| counts.set_item(&fixture.name, spread.count))?;
        Ok(counts)
    }

    /// Distances from contact with the nominal arm.
    #[getter]
    fn nominal(&self) -> Score {
        Score::new(&self.inspection.nominal, &self.problem.get().loaded.problem.fixtures)
    }

    /// Warnings about the problem's declarations, and about what contacts do not determine, with
    /// advice.
    #[getter]
    fn warnings(&self) -> Vec<CalibrationWarning> {
        self.inspection.warnings.iter().map(|warning| WarningEntry::from(warning).into()).collect()
    }

    /// Directions of the parameters that the data do not determine.
    #[getter]
    fn null_space(&self) -> Vec<NullDirection> {
        let name = |k: usize| self.inspection.parameters[k].parameter.name.clone();
        NullDirection::each(&self.inspection.identifiability, name)
    }

    /// A row a parameter: name, unit, sigma, prior_sigma, identifiable.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let parameters = self.parameters();
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Frame::new(py)
            .column("name", parameters.iter().map(|p| &p.name).collect::<Vec<_>>())?
            .column("unit", parameters.iter().map(|p| &p.unit).collect::<Vec<_>>())?
            .column("sigma", parameters.iter().map(|p| number(p.sigma)).collect::<Vec<_>>())?
            .column("prior_sigma", parameters.iter().map(|p| number(p.prior_sigma)).collect::<Vec<_>>())?
            .column("identifiable", parameters.iter().map(|p| p.identifiable).collect::<Vec<_>>())?
            .build()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "Inspection", &self.inspection, Some(self.problem.clone_ref(py).into_any()))
    }

    fn __repr__(&self) -> String {
        let identifiability = &self.inspection.identifiability;
        format!("Inspection({} of {} directions identifiable)", identifiability.rank, self.inspection.parameters.len())
    }
}

/// Computes which parameters a problem's contacts determine, as `touchcal inspect` does.
///
/// Args:
///     problem: the problem.
///     progress: called with a `Progress` at each step; what it raises ends the work, as Ctrl-C
///         does.
#[pyfunction]
#[pyo3(signature = (problem, progress=None))]
pub fn inspect(py: Python<'_>, problem: &Bound<'_, PyAny>, progress: Option<Py<PyAny>>) -> PyResult<Inspection> {
    let problem = argument::<Given<Problem>>(problem, "problem")?.0;
    let mut observer = Observer::new(progress);
    let solved = &problem.get().loaded.problem;
    let inspection = detached(py, || estimate::inspect(solved, &mut |step| observer.step(step)));
    observer.finish()?;
    Ok(Inspection { problem, inspection })
}

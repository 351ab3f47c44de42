//! How well an arm explains contacts.

use std::borrow::Cow;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use touchcal::estimate;
use touchcal::io::estimate_file::WarningEntry;

use crate::repr::{length, number};
use crate::result::CalibrationWarning;
use crate::score::{Score, Spread};

/// Scatter of contacts: root mean square distances from contact.
///
/// Attributes:
///     found: with this arm (m).
///     predicted: from noise, and from what the calibration leaves uncertain (m).
///     ratio: found over predicted.
///     by_chance: range of the ratio that holds 99.9 % of what chance makes.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scatter {
    found: f64,
    predicted: f64,
    ratio: f64,
    by_chance: (f64, f64),
}

impl From<&estimate::Scatter> for Scatter {
    fn from(scatter: &estimate::Scatter) -> Self {
        let estimate::Scatter { found, predicted, by_chance: [low, high] } = *scatter;
        Scatter { found, predicted, ratio: scatter.ratio(), by_chance: (low, high) }
    }
}

#[pymethods]
impl Scatter {
    fn __repr__(&self) -> String {
        let [found, predicted] = [self.found, self.predicted].map(length);
        format!("Scatter(found {found}, predicted {predicted}, ratio {})", number(self.ratio))
    }
}

/// The distance between two fixtures, found with an arm and declared.
///
/// Attributes:
///     between: names of the fixtures.
///     source: what declares the distance: "distance", or "places" of both fixtures.
///     declared, found: distances of their origins (m).
///     sigma: standard deviation of the difference (m): of what is declared, of the calibrated arm
///         and of noise.
///     deviations: found minus declared, in these standard deviations.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FixtureDistance {
    between: (String, String),
    source: Cow<'static, str>,
    declared: f64,
    found: f64,
    sigma: f64,
    deviations: f64,
}

impl From<&estimate::FixtureDistance> for FixtureDistance {
    fn from(distance: &estimate::FixtureDistance) -> Self {
        let [a, b] = distance.between.clone();
        let estimate::FixtureDistance { source, declared, found, sigma, .. } = *distance;
        let deviations = distance.deviations();
        FixtureDistance { between: (a, b), source: source.name().into(), declared, found, sigma, deviations }
    }
}

#[pymethods]
impl FixtureDistance {
    fn __repr__(&self) -> String {
        let FixtureDistance { between: (a, b), declared, found, sigma, .. } = self;
        // To a micrometre: the difference of the two is what matters.
        let [declared, found, sigma] = [declared, found, sigma].map(|metres| 1e3 * metres);
        format!("FixtureDistance({a:?} to {b:?}, declared {declared:.3} mm, found {found:.3} ± {sigma:.3} mm)")
    }
}

/// An arm on contacts that need not be those of its calibration: what is found, beside what is
/// predicted.
///
/// Without a calibration, predictions are those of an exact arm with the declared tolerances, and
/// nothing is contradicted.
///
/// Attributes:
///     scatter: of all contacts; None without contacts, or if a fixture's cannot be predicted.
///     distances: between fixtures: those declared as distances, then those of declared places.
///     common_strain: found over declared distances minus one, common to all, and its standard
///         deviation; None of fewer than two.
///     warnings: what contradicts the calibration beyond chance, with advice.
#[pyclass(frozen, module = "touchcal")]
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Evaluation {
    score: Score,
    names: Vec<String>,
    evaluation: estimate::Evaluation,
}

impl Evaluation {
    /// An evaluation of contacts with these fixtures.
    pub fn new(evaluation: estimate::Evaluation, fixtures: &[estimate::Fixture]) -> Self {
        let names = fixtures.iter().map(|fixture| fixture.name.clone()).collect();
        Evaluation { score: Score::new(&evaluation.score, fixtures), names, evaluation }
    }
}

#[pymethods]
impl Evaluation {
    /// Distances from contact over all contacts.
    #[getter]
    fn all(&self) -> Spread {
        self.score.all()
    }

    /// Distances from contact by name of the fixture.
    #[getter]
    fn per_fixture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.score.per_fixture(py)
    }

    #[getter]
    fn scatter(&self) -> Option<Scatter> {
        self.evaluation.scatter.as_ref().map(Scatter::from)
    }

    /// Scatter by name of the fixture; None as of all contacts, and for projections.
    #[getter]
    fn scatter_per_fixture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let each = self.names.iter().zip(&self.evaluation.per_fixture);
        each.into_iter().try_for_each(|(name, scatter)| dict.set_item(name, scatter.as_ref().map(Scatter::from)))?;
        Ok(dict)
    }

    #[getter]
    fn distances(&self) -> Vec<FixtureDistance> {
        self.evaluation.distances.iter().map(FixtureDistance::from).collect()
    }

    #[getter]
    fn common_strain(&self) -> Option<(f64, f64)> {
        self.evaluation.common_strain.map(|common| (common.strain, common.sigma))
    }

    #[getter]
    fn warnings(&self) -> Vec<CalibrationWarning> {
        let entry = |contradiction: &estimate::Contradiction| WarningEntry {
            kind: contradiction.kind().to_owned(),
            severity: contradiction.severity().into(),
            message: contradiction.message(),
            advice: contradiction.advice().to_owned(),
        };
        self.evaluation.contradictions.iter().map(|each| entry(each).into()).collect()
    }

    /// A row a fixture: fixture, contacts, mean, rms, max, predicted rms (m; NaN where there is
    /// none).
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let each = self.evaluation.per_fixture.iter();
        let predicted = each.map(|scatter| scatter.map_or(f64::NAN, |scatter| scatter.predicted));
        self.score.frame(py)?.column("predicted", predicted.collect::<Vec<f64>>())?.build()
    }

    fn __repr__(&self) -> String {
        let shown = self.scatter().map_or_else(|| "None".to_owned(), |scatter| scatter.__repr__());
        format!("Evaluation({}, {shown}, {} warnings)", self.score.all().__repr__(), self.warnings().len())
    }
}

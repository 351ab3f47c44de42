//! Distances of contacts from their manifolds.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::{Deserialize, Serialize};
use touchcal::estimate;

use crate::frame::Frame;
use crate::repr::length;

/// Statistics of distances from contact, in metres.
///
/// Attributes:
///     count: number of contacts.
///     mean, rms, max: of their distances (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Spread {
    count: usize,
    mean: f64,
    rms: f64,
    max: f64,
}

impl From<&estimate::Spread> for Spread {
    fn from(spread: &estimate::Spread) -> Self {
        let estimate::Spread { count, mean, rms, max } = *spread;
        Spread { count, mean, rms, max }
    }
}

#[pymethods]
impl Spread {
    pub fn __repr__(&self) -> String {
        let [mean, rms, max] = [self.mean, self.rms, self.max].map(length);
        format!("Spread({} contacts: mean {mean}, rms {rms}, max {max})", self.count)
    }
}

/// Distances from contact by an arm's model: over all contacts, and per fixture.
///
/// A contact's distance is the size of its manifold's residual; for a socket, the distance of the
/// ball's centre from the mean of all centres computed for that socket.
///
/// Attributes:
///     all: over all contacts.
#[pyclass(frozen, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Score {
    #[pyo3(get)]
    all: Spread,
    per_fixture: Vec<(String, Spread)>,
}

impl Score {
    /// The score of a problem's fixtures.
    pub fn new(score: &estimate::Score, fixtures: &[estimate::Fixture]) -> Score {
        let each =
            fixtures.iter().zip(&score.per_fixture).map(|(fixture, spread)| (fixture.name.clone(), spread.into()));
        Score { all: (&score.all).into(), per_fixture: each.collect() }
    }

    /// Over all contacts.
    pub fn all(&self) -> Spread {
        self.all.clone()
    }

    /// A row a fixture.
    pub fn frame<'py>(&self, py: Python<'py>) -> PyResult<Frame<'py>> {
        let each =
            |value: fn(&Spread) -> f64| self.per_fixture.iter().map(|(_, spread)| value(spread)).collect::<Vec<_>>();
        Frame::new(py)
            .column("fixture", self.per_fixture.iter().map(|(name, _)| name).collect::<Vec<_>>())?
            .column("contacts", self.per_fixture.iter().map(|(_, spread)| spread.count).collect::<Vec<_>>())?
            .column("mean", each(|spread| spread.mean))?
            .column("rms", each(|spread| spread.rms))?
            .column("max", each(|spread| spread.max))
    }
}

#[pymethods]
impl Score {
    /// By name of the fixture.
    #[getter]
    pub fn per_fixture<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.per_fixture.iter().try_for_each(|(name, spread)| dict.set_item(name, spread.clone()))?;
        Ok(dict)
    }

    /// A row a fixture: fixture, contacts, mean, rms, max (m).
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.frame(py)?.build()
    }

    fn __repr__(&self) -> String {
        format!("Score({})", self.all.__repr__())
    }
}

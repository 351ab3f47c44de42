//! What a waiting program sees of work under way, and the way out.

use std::ops::ControlFlow;

use pyo3::prelude::*;
use touchcal::estimate::{self, Stage};

/// Where work stands: what a progress callback is called with.
///
/// Attributes:
///     stage: "coarse", "fine" or "descent" in an estimation, "simulation" in a simulation.
///     iteration: steps so far in this stage; contacts so far in a simulation.
///     cost: current cost; 0 in a simulation.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    stage: &'static str,
    iteration: usize,
    cost: f64,
}

impl From<&estimate::Progress> for Progress {
    fn from(progress: &estimate::Progress) -> Self {
        let stage = match progress.stage {
            Stage::Coarse => "coarse",
            Stage::Fine => "fine",
            Stage::Descent => "descent",
        };
        Progress { stage, iteration: progress.iteration, cost: progress.cost }
    }
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        format!("Progress(stage={:?}, iteration={}, cost={:?})", self.stage, self.iteration, self.cost)
    }
}

/// Calls back, and asks whether Ctrl-C was pressed; either may end the work.
pub struct Watch {
    callback: Option<Py<PyAny>>,
    raised: Option<PyErr>,
}

impl Watch {
    /// Calls `callback` at each look, if there is one.
    pub fn new(callback: Option<Py<PyAny>>) -> Self {
        Watch { callback, raised: None }
    }

    /// A step of an estimation.
    pub fn step(&mut self, progress: &estimate::Progress) -> ControlFlow<()> {
        self.look(progress.into())
    }

    /// So many contacts of a simulation.
    pub fn contacts(&mut self, count: usize) -> ControlFlow<()> {
        self.look(Progress { stage: "simulation", iteration: count, cost: 0.0 })
    }

    /// What was raised meanwhile.
    pub fn finish(self) -> PyResult<()> {
        self.raised.map_or(Ok(()), Err)
    }

    fn look(&mut self, progress: Progress) -> ControlFlow<()> {
        let seen = Python::attach(|py| {
            py.check_signals()?;
            match &self.callback {
                Some(callback) => callback.call1(py, (progress,)).map(drop),
                None => Ok(()),
            }
        });
        match seen {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.raised.get_or_insert(error);
                ControlFlow::Break(())
            }
        }
    }
}

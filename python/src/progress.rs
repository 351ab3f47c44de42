//! Progress callbacks, and interruption.

use std::borrow::Cow;
use std::ops::ControlFlow;

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, Stage};

/// Progress of a computation: the argument of a progress callback.
///
/// Attributes:
///     stage: "coarse", "fine" or "descent" in an estimation, "simulation" in a simulation,
///         "selection" in the choice of a model.
///     iteration: steps so far in this stage; contacts so far in a simulation, fits so far in a
///         selection.
///     cost: current cost; 0 in a simulation and in a selection.
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    stage: Cow<'static, str>,
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
        Progress { stage: stage.into(), iteration: progress.iteration, cost: progress.cost }
    }
}

#[pymethods]
impl Progress {
    fn __repr__(&self) -> String {
        format!("Progress(stage={:?}, iteration={}, cost={:?})", self.stage, self.iteration, self.cost)
    }
}

/// Calls a callback and checks for Ctrl-C; either may end the work.
pub struct Observer {
    callback: Option<Py<PyAny>>,
    raised: Option<PyErr>,
}

impl Observer {
    /// An observer that calls `callback`, if there is one.
    pub fn new(callback: Option<Py<PyAny>>) -> Self {
        Observer { callback, raised: None }
    }

    /// A step of an estimation.
    pub fn step(&mut self, progress: &estimate::Progress) -> ControlFlow<()> {
        self.notify(Some(progress.into()))
    }

    /// Number of contacts of a simulation so far.
    pub fn contacts(&mut self, count: usize) -> ControlFlow<()> {
        self.notify(Some(Progress { stage: "simulation".into(), iteration: count, cost: 0.0 }))
    }

    /// Number of fits of a selection so far.
    pub fn fits(&mut self, count: usize) -> ControlFlow<()> {
        self.notify(Some(Progress { stage: "selection".into(), iteration: count, cost: 0.0 }))
    }

    /// Looks at signals alone.
    pub fn signals(&mut self) -> ControlFlow<()> {
        self.notify(None)
    }

    /// The exception raised by callback or Ctrl-C, if any.
    pub fn finish(self) -> PyResult<()> {
        self.raised.map_or(Ok(()), Err)
    }

    fn notify(&mut self, progress: Option<Progress>) -> ControlFlow<()> {
        let seen = Python::attach(|py| {
            py.check_signals()?;
            match (&self.callback, progress) {
                (Some(callback), Some(progress)) => callback.call1(py, (progress,)).map(drop),
                _ => Ok(()),
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

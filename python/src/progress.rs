//! Progress callbacks, and interruption.

use std::borrow::Cow;
use std::ops::ControlFlow;

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, Stage};

/// Progress of a computation: the argument of a progress callback.
///
/// Attributes:
///     stage: "coarse", "fine" or "descent" in an estimation, "simulation" in a simulation.
///     iteration: steps so far in this stage; contacts so far in a simulation.
///     cost: current cost; 0 in a simulation.
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
        self.notify(progress.into())
    }

    /// Number of contacts of a simulation so far.
    pub fn contacts(&mut self, count: usize) -> ControlFlow<()> {
        self.notify(Progress { stage: "simulation".into(), iteration: count, cost: 0.0 })
    }

    /// The exception raised by callback or Ctrl-C, if any.
    pub fn finish(self) -> PyResult<()> {
        self.raised.map_or(Ok(()), Err)
    }

    fn notify(&mut self, progress: Progress) -> ControlFlow<()> {
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

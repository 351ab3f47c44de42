//! Calibration of an arm.

use std::time::Instant;

use jiff::Timestamp;
use pyo3::prelude::*;
use touchcal::estimate::{self, calibrate_with_freed_effects};
use touchcal::io::Loaded;
use touchcal::io::calibration_folder::Solved;

use crate::calibration::Calibration;
use crate::error::{Given, argument};
use crate::problem::Problem;
use crate::progress::Observer;
use crate::threads::detached;

/// Estimates an arm's errors, as `touchcal calibrate` does. The same input gives the same bits.
///
/// Args:
///     problem: the problem.
///     progress: called with a `Progress` at each step; what it raises ends the work, as Ctrl-C
///         does. See `touchcal.bar`.
///     free_suspects: estimate what the problem leaves out or declares exact where contacts
///         contradict it, and noise that is larger than declared; the result's problem then has
///         these parameters. What would make a usable result unusable is left out.
///
/// Returns:
///     The result, which may be not usable: that is no exception, but its `status`.
#[pyfunction]
#[pyo3(signature = (problem, progress=None, *, free_suspects=false))]
pub fn calibrate(
    py: Python<'_>,
    problem: &Bound<'_, PyAny>,
    progress: Option<Py<PyAny>>,
    free_suspects: bool,
) -> PyResult<Calibration> {
    let problem = argument::<Given<Problem>>(problem, "problem")?.0;
    let mut observer = Observer::new(progress);
    let loaded = &problem.get().loaded;
    let mut steps = Vec::new();
    let start = Instant::now();
    let (freed, estimate) = detached(py, || {
        let mut observe = |progress: &estimate::Progress| {
            steps.push(*progress);
            observer.step(progress)
        };
        if free_suspects {
            let (problem, estimate) = calibrate_with_freed_effects(&loaded.problem, &mut observe);
            // No file poses this problem.
            (Some(Loaded { problem, settings: String::new(), ..loaded.clone() }), estimate)
        } else {
            (None, estimate::calibrate(&loaded.problem, &mut observe))
        }
    });
    let seconds = start.elapsed().as_secs_f64();
    observer.finish()?;
    let problem = freed.map_or(Ok(problem), |loaded| Py::new(py, Problem::of(loaded)?))?;
    let loaded = &problem.get().loaded;
    let prefit = detached(py, || estimate::evaluate(&loaded.problem));
    let solved = Solved { estimate, prefit, steps, ended: Timestamp::now(), seconds };
    Ok(Calibration::new(problem, solved))
}

//! The choice of a model by how well it predicts contacts that it was not fitted to.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use pyo3::prelude::*;
use serde::{Deserialize, Serialize};
use touchcal::estimate::{self, SelectionProgress};
use touchcal::io::Loaded;

use crate::error::{Given, argument, refused};
use crate::frame::Frame;
use crate::pickle::{Reduced, reduced};
use crate::problem::Problem;
use crate::progress::Observer;
use crate::repr::length;
use crate::threads::detached_with_reports;

/// A model that was compared.
///
/// Attributes:
///     name: its blocks with pluses between them, or "nominal".
///     blocks: blocks of parameters that it has beside those that all models have.
///     prior_width: standard deviations of the priors of harmonics and gear ratios, over the
///         declared or usual ones.
///     parameters: number of parameters of the arm and its encoders.
///     errors: on each group, which was left out of the fit: root mean square distance of its
///         contacts from contact (m); infinite where the fit predicts none.
///     held_out, held_out_error: their mean, and its standard error (m).
///     above_best, above_best_error: the same of the errors less those of the best model (m).
///     in_sample: root mean square distance of all contacts by a fit to all (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComparedModel {
    name: String,
    blocks: Vec<Cow<'static, str>>,
    prior_width: f64,
    parameters: usize,
    errors: Vec<f64>,
    held_out: f64,
    held_out_error: f64,
    above_best: f64,
    above_best_error: f64,
    in_sample: f64,
}

impl ComparedModel {
    fn new(model: &estimate::ComparedModel, best: &estimate::ComparedModel) -> Self {
        let above_best = model.difference(best);
        ComparedModel {
            name: model.name(),
            blocks: model.blocks.iter().map(|block| block.name().into()).collect(),
            prior_width: model.prior_width,
            parameters: model.parameters,
            errors: model.errors.clone(),
            held_out: model.held_out.mean,
            held_out_error: model.held_out.standard_error,
            above_best: above_best.mean,
            above_best_error: above_best.standard_error,
            in_sample: model.in_sample,
        }
    }
}

#[pymethods]
impl ComparedModel {
    fn __repr__(&self) -> String {
        let [held_out, error] = [self.held_out, self.held_out_error].map(length);
        format!("ComparedModel({:?}, held out {held_out} ± {error})", self.name)
    }
}

/// The predictive gain of a block of parameters beside the others of the chosen model.
///
/// Attributes:
///     block: its name.
///     chosen: whether the chosen model has it.
///     gain: mean over the groups of the error without it less that with it (m).
///     gain_error: standard error of that mean (m).
#[pyclass(frozen, get_all, eq, module = "touchcal")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BlockGain {
    block: Cow<'static, str>,
    chosen: bool,
    gain: f64,
    gain_error: f64,
}

impl From<&estimate::BlockGain> for BlockGain {
    fn from(gain: &estimate::BlockGain) -> Self {
        let estimate::BlockGain { block, is_chosen, gain } = gain;
        BlockGain { block: block.name().into(), chosen: *is_chosen, gain: gain.mean, gain_error: gain.standard_error }
    }
}

#[pymethods]
impl BlockGain {
    fn __repr__(&self) -> String {
        let [gain, error] = [self.gain, self.gain_error].map(length);
        format!("BlockGain({:?}, {gain} ± {error}{})", self.block, if self.chosen { ", chosen" } else { "" })
    }
}

/// The models and the choice among them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Compared {
    models: Vec<ComparedModel>,
    chosen: usize,
    best: usize,
    gains: Vec<BlockGain>,
    extrapolate_worse: Vec<usize>,
    group_kind: Cow<'static, str>,
    groups: Vec<String>,
    outliers: usize,
    prediction: String,
}

/// The choice of a model: the result of `touchcal.select`.
///
/// Attributes:
///     problem: the problem with the blocks of the chosen model, to calibrate with.
#[pyclass(frozen, module = "touchcal")]
#[derive(Debug)]
pub struct ModelChoice {
    #[pyo3(get)]
    pub problem: Py<Problem>,
    pub compared: Compared,
}

#[pymethods]
impl ModelChoice {
    /// The models, those with fewer parameters first.
    #[getter]
    fn models(&self) -> Vec<ComparedModel> {
        self.compared.models.clone()
    }

    /// The chosen model: that with the fewest parameters whose mean error is not above that of the
    /// best by more than a standard error and 1 %.
    #[getter]
    fn chosen(&self) -> ComparedModel {
        self.compared.models[self.compared.chosen].clone()
    }

    /// The model with the least mean error.
    #[getter]
    fn best(&self) -> ComparedModel {
        self.compared.models[self.compared.best].clone()
    }

    /// The predictive gain of each block beside the others of the chosen model.
    #[getter]
    fn gains(&self) -> Vec<BlockGain> {
        self.compared.gains.clone()
    }

    /// Models that have all blocks of the chosen one and more, fit all contacts better, and predict
    /// groups worse, by more than the standard error and 1 % of the error.
    #[getter]
    fn extrapolate_worse(&self) -> Vec<ComparedModel> {
        self.compared.extrapolate_worse.iter().map(|&m| self.compared.models[m].clone()).collect()
    }

    /// What the groups are: "placements", "fixtures" or "regions".
    #[getter]
    fn group_kind(&self) -> &str {
        &self.compared.group_kind
    }

    /// Name of each group, of a region its number from 1.
    #[getter]
    fn groups(&self) -> Vec<String> {
        self.compared.groups.clone()
    }

    /// Number of contacts that all nested models reject: no error counts them.
    #[getter]
    fn outliers(&self) -> usize {
        self.compared.outliers
    }

    /// A row a model: model, prior_width, parameters, held_out, held_out_error, above_best,
    /// above_best_error, in_sample (m), chosen.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let models = &self.compared.models;
        let metres = |part: fn(&ComparedModel) -> f64| models.iter().map(part).collect::<Vec<f64>>();
        let is_chosen: Vec<bool> = (0..models.len()).map(|m| m == self.compared.chosen).collect();
        Frame::new(py)
            .column("model", models.iter().map(|model| model.name.as_str()).collect::<Vec<&str>>())?
            .column("prior_width", metres(|model| model.prior_width))?
            .column("parameters", models.iter().map(|model| model.parameters).collect::<Vec<usize>>())?
            .column("held_out", metres(|model| model.held_out))?
            .column("held_out_error", metres(|model| model.held_out_error))?
            .column("above_best", metres(|model| model.above_best))?
            .column("above_best_error", metres(|model| model.above_best_error))?
            .column("in_sample", metres(|model| model.in_sample))?
            .column("chosen", is_chosen)?
            .build()
    }

    fn __repr__(&self) -> String {
        let Compared { models, chosen, prediction, .. } = &self.compared;
        format!("ModelChoice({:?} of {} models: {prediction})", models[*chosen].name, models.len())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduced(py, "ModelChoice", &self.compared, Some(self.problem.clone_ref(py).into_any()))
    }
}

/// Compares models of the arm by how well they predict contacts that are left out of the fit, as
/// `touchcal select` does: whole placements, fixtures or regions of the workspace, never single
/// rows.
///
/// The result does not say whether the chosen model is complete: the warnings of a calibration with
/// its problem do.
///
/// Args:
///     problem: contacts at three placements or fixtures, or 20 contacts; its blocks are among the
///         models, with their priors.
///     progress: called with a `Progress` after each fit; what it raises ends the work, as Ctrl-C
///         does.
///
/// Raises:
///     InputError: with too few contacts, or if no model predicts all groups.
#[pyfunction]
#[pyo3(signature = (problem, progress=None))]
pub fn select(py: Python<'_>, problem: &Bound<'_, PyAny>, progress: Option<Py<PyAny>>) -> PyResult<ModelChoice> {
    let problem = argument::<Given<Problem>>(problem, "problem")?.0;
    let mut observer = Observer::new(progress);
    let given = &problem.get().loaded;
    let is_ended = AtomicBool::new(false);
    let work = |report: &(dyn Fn(usize) + Sync)| {
        estimate::select(&given.problem, &|progress: &SelectionProgress| {
            report(progress.done);
            if is_ended.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    };
    let mut shown = 0;
    let chosen = detached_with_reports(py, work, |done| {
        let is_new = done.is_some_and(|done| done > shown);
        shown = done.unwrap_or(shown).max(shown);
        // Fits end for a while after that.
        if !is_ended.load(Ordering::Relaxed) {
            let answer = if is_new { observer.fits(shown) } else { observer.signals() };
            is_ended.store(answer.is_break(), Ordering::Relaxed);
        }
    });
    observer.finish()?;
    let choice = chosen.map_err(|error| refused("select", error))?;
    let best = &choice.models[choice.best];
    let compared = Compared {
        models: choice.models.iter().map(|model| ComparedModel::new(model, best)).collect(),
        chosen: choice.chosen,
        best: choice.best,
        gains: choice.gains.iter().map(BlockGain::from).collect(),
        extrapolate_worse: choice.extrapolate_worse.clone(),
        group_kind: choice.group_kind.name().into(),
        groups: choice.groups.clone(),
        outliers: choice.outliers,
        prediction: choice.prediction(),
    };
    // No file poses this problem.
    let loaded = Loaded { problem: choice.problem, settings: String::new(), ..given.clone() };
    Ok(ModelChoice { problem: Py::new(py, Problem::of(loaded)?)?, compared })
}

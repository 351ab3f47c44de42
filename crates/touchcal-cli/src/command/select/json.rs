//! What `select --json` prints.

use serde::Serialize;
use touchcal::estimate::{BlockGain, ComparedModel, Estimate, GroupMean, ModelChoice};
use touchcal::io::estimate_file::WarningEntry;
use touchcal::io::{Input, Loaded};

use crate::failure::Failure;
use crate::output::finite;

/// Lengths are in metres; those of fits without a prediction are null.
#[derive(Serialize)]
struct ChoiceJson<'a> {
    schema: u32,
    chosen: Vec<&'static str>,
    best: Vec<&'static str>,
    group_kind: &'static str,
    groups: &'a [String],
    outliers: usize,
    models: Vec<ModelJson>,
    gains: Vec<GainJson>,
    extrapolate_worse: Vec<Vec<&'static str>>,
    /// What says that the chosen model is incomplete.
    incomplete: Vec<WarningEntry>,
    status: &'static str,
    inputs: &'a [Input],
}

#[derive(Serialize)]
struct ModelJson {
    blocks: Vec<&'static str>,
    prior_width: f64,
    parameters: usize,
    held_out: MeanJson,
    /// Less that of the chosen model, group by group.
    above_chosen: MeanJson,
    errors: Vec<Option<f64>>,
    in_sample: Option<f64>,
}

#[derive(Serialize)]
struct GainJson {
    block: &'static str,
    chosen: bool,
    gain: MeanJson,
}

#[derive(Serialize)]
struct MeanJson {
    mean: Option<f64>,
    standard_error: Option<f64>,
}

/// The choice as JSON, with the calibration of the chosen model.
pub fn of(loaded: &Loaded, choice: &ModelChoice, estimate: &Estimate) -> Result<String, Failure> {
    let chosen = &choice.models[choice.chosen];
    let json = ChoiceJson {
        schema: 1,
        chosen: names(chosen),
        best: names(&choice.models[choice.best]),
        group_kind: choice.group_kind.name(),
        groups: &choice.groups,
        outliers: choice.outliers,
        models: choice.models.iter().map(|model| model_json(model, chosen)).collect(),
        gains: choice.gains.iter().map(gain_json).collect(),
        extrapolate_worse: choice.extrapolate_worse.iter().map(|&m| names(&choice.models[m])).collect(),
        incomplete: estimate.incompleteness().into_iter().map(Into::into).collect(),
        status: estimate.status.name(),
        inputs: &loaded.inputs,
    };
    Ok(serde_json::to_string_pretty(&json)? + "\n")
}

fn names(model: &ComparedModel) -> Vec<&'static str> {
    model.blocks.iter().map(|block| block.name()).collect()
}

fn model_json(model: &ComparedModel, chosen: &ComparedModel) -> ModelJson {
    ModelJson {
        blocks: names(model),
        prior_width: model.prior_width,
        parameters: model.parameters,
        held_out: mean_json(&model.held_out),
        above_chosen: mean_json(&model.difference(chosen)),
        errors: model.errors.iter().map(|error| finite(*error)).collect(),
        in_sample: finite(model.in_sample),
    }
}

fn gain_json(gain: &BlockGain) -> GainJson {
    GainJson { block: gain.block.name(), chosen: gain.is_chosen, gain: mean_json(&gain.gain) }
}

fn mean_json(mean: &GroupMean) -> MeanJson {
    MeanJson { mean: finite(mean.mean), standard_error: finite(mean.standard_error) }
}

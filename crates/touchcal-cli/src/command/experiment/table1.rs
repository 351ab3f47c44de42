//! `touchcal experiment table1`: the table of Negi, Manyar & Gupta (2025), and what each part of
//! the method contributes.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;
use touchcal::estimate::{GradientDescent, StopReason};
use touchcal::experiment::Trial;
use touchcal::geometry::Parts;
use touchcal::io::result_folder::{self, ResultFile, ResultKind};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::weights_file::WeightsFile;
use touchcal::io::{Input, atomic, manifold_file, trial_folder};
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::{NearestSample, Projection};
use touchcal::sim::{Preset, Scenario};

use super::approach::{ALL, Approach, ContactModel, Manifolds};
use super::row::{Row, Tool};
use super::{figure, saved};
use crate::args::{ApproachName, Table1Args};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::{Counter, interrupted};
use crate::table::Table;

/// Results published in the paper: mean absolute errors of strain and biases (deg), and their
/// reduction factors.
const PUBLISHED_STRAIN: f64 = 0.019;
const PUBLISHED_BIAS_DEG: f64 = 1.48;
const PUBLISHED_REDUCTION: (f64, f64) = (2.6, 3.37);

const JSON: &str = "table1.json";
const CSV: &str = "table1.csv";
/// Name of the figure, the last file that is written.
pub const FIGURE: &str = "table1.svg";

/// The source of a trial.
enum Source {
    Simulated { scenario: Arc<Scenario>, seed: u64 },
    Recorded(Box<Trial>),
}

/// Runs all approaches on all trials, saving each row; then writes the table as text, CSV, JSON and
/// figure.
pub fn run(args: &Table1Args) -> Result<Outcome, Failure> {
    result_folder::check(&args.out, ResultKind::Table1, &[JSON, CSV, FIGURE], &[])?;
    atomic::remove_left_over(&args.out.join(saved::ROWS));
    let robot = urdf::read_builtin("iiwa14", Ends::default())?.robot;
    let scenario = Scenario { contacts: args.contacts as usize, ..Preset::Paper.scenario(robot.clone())? };
    let Some(Parts::PegInHole(parts)) = scenario.touches.first().map(|touch| touch.parts.clone()) else {
        return Err(Failure::Setup("the paper's experiment has no hole".to_owned()));
    };
    let mut inputs = Vec::new();
    let nearest = args.manifold.as_ref().map(|path| nearest(args, path, &mut inputs)).transpose()?;
    let learned = args.weights.as_ref().map(|path| learned(path, &mut inputs)).transpose()?;
    let manifolds = Manifolds { parts: *parts, nearest, learned, inputs };
    let sources: Vec<Source> = match &args.logs {
        Some(folder) => {
            let trials = trial_folder::read(folder, &robot)?;
            trials.into_iter().map(|trial| Source::Recorded(Box::new(trial))).collect()
        }
        None => {
            let seeds = (0..u64::from(args.trials)).map(|k| args.seed.wrapping_add(k));
            let scenario = Arc::new(scenario);
            seeds.map(|seed| Source::Simulated { scenario: Arc::clone(&scenario), seed }).collect()
        }
    };
    let wanted = |approach: &Approach| args.only.is_empty() || args.only.contains(&approach.name);
    let given = |approach: &Approach| manifolds.manifold(approach.model).is_some();
    let approaches: Vec<Approach> = ALL.into_iter().filter(|approach| wanted(approach) && given(approach)).collect();
    if let Some(name) = args.only.iter().find(|name| !approaches.iter().any(|approach| approach.name == **name)) {
        let missing = match name {
            ApproachName::NearestGd | ApproachName::NearestLm => "--manifold FILE",
            _ => "--weights FILE",
        };
        return Err(Failure::Setup(format!("--only {} needs {missing}", name.key())));
    }
    let rows = rows(args, &sources, &approaches, &manifolds)?;
    let of = |approach: &Approach| rows.iter().filter(|row| row.approach == approach.name.key()).collect::<Vec<&Row>>();
    let grouped: Vec<Vec<&Row>> = approaches.iter().map(of).collect();
    let summaries: Vec<Summary> =
        approaches.iter().zip(&grouped).map(|(approach, rows)| Summary::of(approach, rows)).collect();
    let labels: Vec<&str> = approaches.iter().map(|approach| approach.label).collect();
    let svg = figure::svg(&labels, &grouped, (PUBLISHED_BIAS_DEG, PUBLISHED_STRAIN)).map_err(Failure::Setup)?;
    let files = [
        ResultFile::new(JSON, json(&rows, &summaries)?),
        ResultFile::new(CSV, csv(&rows)),
        ResultFile::new(FIGURE, svg),
    ];
    result_folder::write(&args.out, ResultKind::Table1, &files, &[])?;
    output::print(&text(args, sources.len(), &summaries))?;
    Ok(Outcome::Done)
}

/// Rows of all trials and approaches: read where saved, computed in parallel and saved where not.
fn rows(
    args: &Table1Args,
    sources: &[Source],
    approaches: &[Approach],
    manifolds: &Manifolds,
) -> Result<Vec<Row>, Failure> {
    let counter = Counter::new("Calibrating", 0, (sources.len() * approaches.len()) as u64);
    let per_trial = sources.par_iter().map(|source| {
        let trial = begin(source)?;
        let mut rows = Vec::with_capacity(approaches.len());
        for approach in approaches {
            let settings = settings(args, &trial, approach, manifolds);
            let path = Row::path(&args.out, &trial.name, approach.name.key());
            let row = match Row::load(&path, &settings) {
                Some(row) => row,
                None => {
                    let row = solve(args, &trial, approach, manifolds, settings)?;
                    row.save(&path)?;
                    row
                }
            };
            counter.advance(1);
            rows.push(row);
        }
        Ok(rows)
    });
    let per_trial: Vec<Vec<Row>> = per_trial.collect::<Result<_, Failure>>()?;
    Ok(per_trial.into_iter().flatten().collect())
}

fn begin(source: &Source) -> Result<Trial, Failure> {
    if interrupted() {
        return Err(Failure::ExperimentInterrupted);
    }
    match source {
        Source::Simulated { scenario, seed } => Ok(Trial::simulated(scenario, *seed)?),
        Source::Recorded(trial) => Ok(Trial::clone(trial)),
    }
}

fn descent(args: &Table1Args) -> GradientDescent {
    GradientDescent {
        steps: args.steps as usize,
        contacts: args.descent_contacts as usize,
        ..GradientDescent::default()
    }
}

/// The samples of `path`, in the metric asked for.
fn nearest(
    args: &Table1Args,
    path: &Path,
    inputs: &mut Vec<(ContactModel, Input)>,
) -> Result<Arc<dyn Projection>, Failure> {
    let (samples, _, input) = manifold_file::read_samples(path)?;
    let metric = Metric { metres_per_radian: 1e-3 * args.mm_per_deg * 180.0 / std::f64::consts::PI };
    inputs.push((ContactModel::Nearest, input));
    Ok(Arc::new(NearestSample::new(samples, metric)))
}

/// The network of `path`.
fn learned(path: &Path, inputs: &mut Vec<(ContactModel, Input)>) -> Result<Arc<dyn Projection>, Failure> {
    let (file, input) = WeightsFile::read_file(path)?;
    inputs.push((ContactModel::Learned, input));
    Ok(Arc::new(file.projection))
}

/// Everything that a row depends on but its trial's name.
fn settings(args: &Table1Args, trial: &Trial, approach: &Approach, manifolds: &Manifolds) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let mut settings = format!("touchcal {version}; {}; {:?}", trial.origin, approach.search(descent(args)));
    if let Some((_, input)) = manifolds.inputs.iter().find(|(model, _)| *model == approach.model) {
        settings.push_str(&format!("; {}; {} mm per degree", input.sha256, args.mm_per_deg));
    }
    settings
}

fn solve(
    args: &Table1Args,
    trial: &Trial,
    approach: &Approach,
    manifolds: &Manifolds,
    settings: String,
) -> Result<Row, Failure> {
    let Some(manifold) = manifolds.manifold(approach.model) else {
        return Err(Failure::Setup(format!("nothing was given for {}", approach.label)));
    };
    let problem = trial.problem(manifold, approach.search(descent(args)));
    let start = Instant::now();
    let mut observer = |_: &_| if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let estimate = touchcal::estimate::calibrate(&problem, &mut observer);
    let seconds = start.elapsed().as_secs_f64();
    if estimate.termination.reason == StopReason::Interrupted || interrupted() {
        return Err(Failure::ExperimentInterrupted);
    }
    Ok(Row::new(settings, trial, approach.name.key(), &estimate, seconds))
}

/// A row of the table: means over the trials.
#[derive(Debug, Serialize)]
struct Summary {
    approach: &'static str,
    label: &'static str,
    trials: usize,
    strain_mae: f64,
    bias_mae_deg: f64,
    strain_reduction: f64,
    bias_reduction: f64,
    hole: Tool,
    workspace: Tool,
    usable: f64,
    seconds: f64,
}

impl Summary {
    fn of(approach: &Approach, rows: &[&Row]) -> Summary {
        let mean = |value: &dyn Fn(&Row) -> f64| rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64;
        let tool = |tool: fn(&Row) -> Tool| Tool {
            mean_mm: mean(&|row| tool(row).mean_mm),
            mm_95: mean(&|row| tool(row).mm_95),
            mean_deg: mean(&|row| tool(row).mean_deg),
            deg_95: mean(&|row| tool(row).deg_95),
        };
        let strain_mae = mean(&|row| row.strain_error);
        let bias_mae_deg = mean(&|row| row.bias_error_deg);
        Summary {
            approach: approach.name.key(),
            label: approach.label,
            trials: rows.len(),
            strain_mae,
            bias_mae_deg,
            strain_reduction: mean(&|row| row.strain_before) / strain_mae,
            bias_reduction: mean(&|row| row.bias_before_deg) / bias_mae_deg,
            hole: tool(|row| row.hole),
            workspace: tool(|row| row.workspace),
            usable: mean(&|row| f64::from(u8::from(row.is_usable()))),
            seconds: mean(&|row| row.seconds),
        }
    }
}

#[derive(Serialize)]
struct Published {
    strain_mae: f64,
    bias_mae_deg: f64,
    strain_reduction: f64,
    bias_reduction: f64,
}

#[derive(Serialize)]
struct File<'a> {
    version: &'static str,
    published: Published,
    summary: &'a [Summary],
    rows: &'a [Row],
}

fn json(rows: &[Row], summary: &[Summary]) -> Result<String, Failure> {
    let published = Published {
        strain_mae: PUBLISHED_STRAIN,
        bias_mae_deg: PUBLISHED_BIAS_DEG,
        strain_reduction: PUBLISHED_REDUCTION.0,
        bias_reduction: PUBLISHED_REDUCTION.1,
    };
    let file = File { version: env!("CARGO_PKG_VERSION"), published, summary, rows };
    Ok(serde_json::to_string_pretty(&file)? + "\n")
}

fn csv(rows: &[Row]) -> String {
    let mut text = "trial,approach,status,strain_error,bias_error_deg,strain_before,bias_before_deg,hole_mean_mm,hole_mm_95,\
                    hole_mean_deg,hole_deg_95,workspace_mean_mm,workspace_mm_95,workspace_mean_deg,workspace_deg_95,seconds\n"
        .to_owned();
    for row in rows {
        let trial = format!("\"{}\"", row.trial.replace('"', "\"\""));
        let of = |tool: &Tool| [tool.mean_mm, tool.mm_95, tool.mean_deg, tool.deg_95];
        let numbers = [row.strain_error, row.bias_error_deg, row.strain_before, row.bias_before_deg].into_iter();
        let numbers = numbers.chain(of(&row.hole)).chain(of(&row.workspace)).chain([row.seconds]);
        let numbers: Vec<String> = numbers.map(|number| format!("{number:.6e}")).collect();
        text.push_str(&format!("{trial},{},{},{}\n", row.approach, row.status, numbers.join(",")));
    }
    text
}

fn text(args: &Table1Args, trials: usize, summaries: &[Summary]) -> String {
    let mut table = Table::new([
        "",
        "strain",
        "bias deg",
        "strain ×",
        "bias ×",
        "hole mm",
        "95 %",
        "deg",
        "other poses mm",
        "95 %",
        "deg",
        "95 %",
        "usable",
        "s",
    ]);
    let blank = || "-".to_owned();
    let published = [
        "paper (published, real arm)".to_owned(),
        format!("{PUBLISHED_STRAIN}"),
        format!("{PUBLISHED_BIAS_DEG}"),
        format!("{:.1}", PUBLISHED_REDUCTION.0),
        format!("{:.1}", PUBLISHED_REDUCTION.1),
    ];
    table.row(published.into_iter().chain(std::iter::repeat_with(blank).take(9)));
    for summary in summaries {
        let Summary { hole, workspace, .. } = summary;
        table.row([
            summary.label.to_owned(),
            format!("{:.1e}", summary.strain_mae),
            format!("{:.4}", summary.bias_mae_deg),
            format!("{:.1}", summary.strain_reduction),
            format!("{:.1}", summary.bias_reduction),
            format!("{:.3}", hole.mean_mm),
            format!("{:.3}", hole.mm_95),
            format!("{:.4}", hole.mean_deg),
            format!("{:.3}", workspace.mean_mm),
            format!("{:.3}", workspace.mm_95),
            format!("{:.4}", workspace.mean_deg),
            format!("{:.4}", workspace.deg_95),
            format!("{:.0} %", 100.0 * summary.usable),
            format!("{:.2}", summary.seconds),
        ]);
    }
    [
        format!("Mean absolute errors over {trials} trials: parameters, tool at the hole, tool at 1000 other poses\n"),
        table.to_string(),
        format!(
            "\nWritten to {}: table1.csv, table1.json, table1.svg, and one file per row in rows/.\n",
            args.out.display()
        ),
        missing_rows(args),
    ]
    .concat()
}

/// Rows that are missing in the table, and the options that add them.
fn missing_rows(args: &Table1Args) -> String {
    let mut text = String::new();
    if args.manifold.is_none() {
        text.push_str("Not computed without --manifold FILE (see `touchcal manifold`): nearest sample.\n");
    }
    if args.weights.is_none() {
        text.push_str("Not computed without --weights FILE (see `touchcal train`): MLP.\n");
    }
    text
}

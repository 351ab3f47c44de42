//! `touchcal experiment table1`: the table of Negi, Manyar & Gupta (2025), and what each part of
//! the method contributes.

mod figure;
mod latex;
mod summary;

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;
use touchcal::estimate::{GradientDescent, StopReason};
use touchcal::experiment::Trial;
use touchcal::geometry::Parts;
use touchcal::io::result_folder::{self, ResultFile, ResultKind};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::weights_file::WeightsFile;
use touchcal::io::{Input, atomic, manifold_file, scenario_file, trial_folder};
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::{NearestSample, Projection};
use touchcal::sim::{Preset, Scenario};

use super::approach::{ALL, Approach, ContactModel, Manifolds};
use super::row::{Row, Tool};
use super::saved;
use crate::args::{ApproachName, Table1Args};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::{Counter, interrupted};
use summary::Summary;

const JSON: &str = "table1.json";
const CSV: &str = "table1.csv";
const LATEX: &str = "table1.tex";
const FIGURE: &str = "table1.svg";

/// The source of a trial.
enum Source {
    Simulated { scenario: Arc<Scenario>, seed: u64 },
    Recorded(Box<Trial>),
}

/// Runs all approaches on all trials, saving each row; then writes the table as text, CSV, JSON,
/// LaTeX and figure.
pub fn run(args: &Table1Args) -> Result<Outcome, Failure> {
    result_folder::check(&args.out, ResultKind::Table1, &[JSON, CSV, LATEX, FIGURE], &[])?;
    atomic::remove_left_over(&args.out.join(saved::ROWS));
    let mut scenario = match &args.scenario {
        Some(path) => scenario_file::read_file(path)?.scenario,
        None => Preset::Paper.scenario(urdf::read_builtin("iiwa14", Ends::default())?.robot)?,
    };
    if let Some(contacts) = args.contacts {
        scenario.contacts = contacts as usize;
    }
    let Some(Parts::PegInHole(parts)) = scenario.touches.first().map(|touch| touch.parts.clone()) else {
        return Err(Failure::Setup("the first fixture of the scenario is no hole with a peg".to_owned()));
    };
    let mut inputs = Vec::new();
    let nearest = args.manifold.as_ref().map(|path| nearest(args, path, &mut inputs)).transpose()?;
    let learned = args.weights.as_ref().map(|path| learned(path, &mut inputs)).transpose()?;
    let manifolds = Manifolds { parts: *parts, nearest, learned, inputs };
    let sources: Vec<Source> = match &args.logs {
        Some(folder) => {
            let trials = trial_folder::read(folder, &scenario.robot)?;
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
    let svg = figure::figure(&labels, &grouped).map_err(Failure::Setup)?;
    let files = [
        ResultFile::new(JSON, summary::json(&rows, &summaries)?),
        ResultFile::new(CSV, csv(&rows)),
        ResultFile::new(LATEX, latex::table(&summaries, sources.len())),
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
    [
        format!("Mean absolute errors (number of trials: {trials}): parameters, tool at the hole, tool at 1000 other poses\n"),
        summary::table(summaries).to_string(),
        refused_rows(summaries),
        format!(
            "\nWritten to {}: table1.csv, table1.json, table1.tex, table1.svg, and one file per row in rows/.\n",
            args.out.display()
        ),
        missing_rows(args),
    ]
    .concat()
}

/// That the means include results that are refused.
fn refused_rows(summaries: &[Summary]) -> String {
    let has_refused = summaries.iter().any(|summary| summary.refused > 0);
    if has_refused { "Means include trials whose result is refused.\n".to_owned() } else { String::new() }
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

//! The page of an evaluation.

use serde::Serialize;

use super::content::{Change, Input, InputEntry, change, input_entries};
use super::page::{Template, page};
use super::relative::CommonFolder;
use super::settings::{Units, units};
use super::warning_text::{WarningText, sorted};
use crate::estimate::{Evaluation, Problem, Scatter, Score, Status};
use crate::parameter::Unit;

/// The evaluation of an arm on contacts, as a report shows it. `problem`, `nominal` and
/// `evaluation` are of the same contacts.
#[derive(Clone, Copy, Debug)]
pub struct EvaluationReport<'a> {
    /// The problem, whose arm is the nominal one.
    pub problem: &'a Problem,
    /// What was evaluated, such as the path of a URDF, as the page shows it.
    pub evaluated: &'a str,
    /// Scores of the nominal arm.
    pub nominal: &'a Score,
    /// The evaluated arm's, beside what is predicted.
    pub evaluation: &'a Evaluation,
    /// Whether it is known what the calibration leaves uncertain.
    pub is_calibrated: bool,
    /// Whether the calibration that is evaluated may be used; `None` if it is not known.
    pub status: Option<Status>,
    /// When the page was written, as text that it shows; `None` if that is not known.
    pub created: Option<&'a str>,
    /// Errors relative to a true arm; empty where none is known.
    pub tool_errors: &'a [ToolError],
    /// What contradicts the calibration; may be empty.
    pub warnings: &'a [WarningText],
    /// Input files; may be empty.
    pub inputs: &'a [Input],
}

/// An error of the tool across the workspace.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolError {
    /// What errs, as the page shows it.
    pub name: &'static str,
    /// Metres or radians.
    pub unit: Unit,
    /// Root mean square and maximum with the nominal arm.
    pub nominal: [f64; 2],
    /// With the evaluated one.
    pub given: [f64; 2],
}

impl EvaluationReport<'_> {
    /// The text of the page: one HTML document in UTF-8. The same report gives the same text.
    ///
    /// # Errors
    /// If the data cannot be written as JSON; numbers that are not finite become null.
    pub fn html(&self) -> serde_json::Result<String> {
        Ok(page(Template::Evaluation, &serde_json::to_string(&Content::new(self))?))
    }
}

/// The page's data; lengths in m.
#[derive(Serialize)]
struct Content<'a> {
    version: &'static str,
    robot: &'a str,
    created: Option<&'a str>,
    evaluated: String,
    is_calibrated: bool,
    status: Option<&'static str>,
    agrees: Option<bool>,
    warnings: Vec<&'a WarningText>,
    all: Row<'a>,
    fixtures: Vec<Row<'a>>,
    distances: Vec<Distance<'a>>,
    /// Strain common to all distances, and its standard deviation.
    common_strain: Option<[f64; 2]>,
    tool_errors: Vec<ToolErrorEntry>,
    inputs: Vec<InputEntry<'a>>,
    units: Units,
}

/// Scores of a fixture, or of all.
#[derive(Serialize)]
struct Row<'a> {
    name: &'a str,
    contacts: usize,
    change: Change,
    scatter: Option<ScatterEntry>,
}

#[derive(Serialize)]
struct ScatterEntry {
    found: f64,
    predicted: f64,
    ratio: f64,
    by_chance: [f64; 2],
    is_exceeded: bool,
}

#[derive(Serialize)]
struct Distance<'a> {
    between: &'a [String; 2],
    source: &'static str,
    declared: f64,
    found: f64,
    difference: f64,
    sigma: f64,
    deviations: f64,
}

#[derive(Serialize)]
struct ToolErrorEntry {
    name: &'static str,
    unit: &'static str,
    nominal: [f64; 2],
    given: [f64; 2],
}

impl<'a> Content<'a> {
    fn new(report: &EvaluationReport<'a>) -> Self {
        let EvaluationReport { problem, nominal, evaluation, .. } = *report;
        let given = &evaluation.score;
        let paths = report.inputs.iter().map(|input| &*input.path).chain([report.evaluated]);
        let folder = CommonFolder::of(paths);
        let fixtures = problem.fixtures.iter().zip(&evaluation.per_fixture).enumerate();
        let fixtures = fixtures.map(|(f, (fixture, scatter))| Row {
            name: &fixture.name,
            contacts: given.per_fixture.get(f).map_or(0, |spread| spread.count),
            change: change(nominal.per_fixture.get(f), given.per_fixture.get(f)),
            scatter: scatter.map(scatter_entry),
        });
        let distances = evaluation.distances.iter().map(|distance| Distance {
            between: &distance.between,
            source: distance.source.name(),
            declared: distance.declared,
            found: distance.found,
            difference: distance.difference(),
            sigma: distance.sigma,
            deviations: distance.deviations(),
        });
        Content {
            version: env!("CARGO_PKG_VERSION"),
            robot: problem.robot.name(),
            created: report.created,
            evaluated: folder.shown(report.evaluated),
            is_calibrated: report.is_calibrated,
            status: report.status.map(Status::name),
            agrees: evaluation.agrees(),
            warnings: sorted(report.warnings),
            all: Row {
                name: "all",
                contacts: given.all.count,
                change: change(Some(&nominal.all), Some(&given.all)),
                scatter: evaluation.scatter.map(scatter_entry),
            },
            fixtures: fixtures.collect(),
            distances: distances.collect(),
            common_strain: evaluation.common_strain.map(|common| [common.strain, common.sigma]),
            tool_errors: report.tool_errors.iter().map(tool_error_entry).collect(),
            inputs: input_entries(report.inputs, &folder),
            units: units(),
        }
    }
}

fn scatter_entry(scatter: Scatter) -> ScatterEntry {
    let Scatter { found, predicted, by_chance } = scatter;
    ScatterEntry { found, predicted, ratio: scatter.ratio(), by_chance, is_exceeded: scatter.is_exceeded() }
}

fn tool_error_entry(error: &ToolError) -> ToolErrorEntry {
    let ToolError { name, unit, nominal, given } = *error;
    ToolErrorEntry { name, unit: unit.symbol(), nominal, given }
}

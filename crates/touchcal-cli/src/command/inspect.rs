//! `touchcal inspect`.

use std::collections::BTreeMap;

use serde::Serialize;
use touchcal::estimate::{
    DistanceSource, FixtureDistance, Inspection, Problem, Severity, StopReason, Warning, evaluate_held_out, inspect,
};
use touchcal::io::Input;
use touchcal::io::estimate_file::{ResidualStats, WarningEntry};
use touchcal::io::{Loaded, calibration_folder};
use touchcal::robot::JointKind;

use crate::args::InspectArgs;
use crate::failure::{Failure, Outcome};
use crate::output::{self, finite};
use crate::progress::Spinner;
use crate::summary::{self, Detail, MOST_FIXTURES, ParameterRow};
use crate::table::Table;

/// Reads a problem, computes expected standard deviations, prints them; [`Outcome::NotUsable`] if
/// contacts contradict the problem or leave the arm undetermined so far that a calibration would
/// not be usable, or a mesh has several bodies.
pub fn run(args: &InspectArgs) -> Result<Outcome, Failure> {
    super::refuse_replaced(&args.source, &args.arm, ["inspect", ""])?;
    let loaded = super::load(&args.source)?;
    let spinner = Spinner::new("Inspecting");
    let inspection = inspect(&loaded.problem, &mut |progress| spinner.observe(progress));
    drop(spinner);
    let detail = if args.all { Detail::Every } else { Detail::Grouped };
    let text = if args.json { json(&loaded, &inspection)? } else { text(&loaded, &inspection, detail) };
    output::print(&text)?;
    let is_unusable = inspection.warnings.iter().any(|warning| warning.severity() == Severity::Unusable);
    Ok(if is_unusable || loaded.assumptions.has_several_bodies() { Outcome::NotUsable } else { Outcome::Done })
}

fn text(loaded: &Loaded, inspection: &Inspection, detail: Detail) -> String {
    let problem = &loaded.problem;
    let lines = inspection.parameters.iter().map(|expected| ParameterRow {
        parameter: &expected.parameter,
        value: None,
        sigma: expected.sigma,
        identifiable: expected.identifiable,
    });
    let lines: Vec<ParameterRow<'_>> = lines.collect();
    let [o1, o2, o3, o4, o5] = inspection.observability;
    let (files, contacts, rows) =
        (problem.contacts.files().len(), problem.contacts.len(), problem.contacts.rows_read());
    let left_out = summary::left_out(&problem.contacts);
    let note = match inspection.reason {
        StopReason::Converged => "",
        _ => "Note: the coarse stage did not converge, so these values are rough.\n",
    };
    [
        format!("Robot     {}\n", summary::robot(loaded)),
        format!("Contacts  {rows} rows read from {files} files: {contacts} contacts{left_out}\n{}\n", held_out(loaded)),
        fixtures(loaded, inspection),
        distances(&loaded.problem),
        joints(loaded, inspection),
        heading(inspection),
        summary::parameters(&lines, detail),
        summary::identifiability(&inspection.identifiability, &inspection.parameters, detail),
        format!("Observability  O1 {o1:.3e}  O2 {o2:.3e}  O3 {o3:.3e}  O4 {o4:.3e}  O5 {o5:.3e}\n"),
        note.to_owned(),
        warnings(inspection),
    ]
    .concat()
}

fn held_out(loaded: &Loaded) -> String {
    let (contacts, files) = (loaded.problem.held_out.len(), loaded.problem.held_out.files().len());
    if contacts == 0 { String::new() } else { format!("Held out  {contacts} contacts from {files} files\n") }
}

/// The heading of the parameters.
fn heading(inspection: &Inspection) -> String {
    match inspection.warnings.contains(&Warning::NoUncertainty) {
        true => "Parameters, without standard deviations: see below\n".to_owned(),
        false => "Expected standard deviations with the assumed noise; `calibrate` adds those of errors\nof the arm that are not estimated and that contacts do not show\n"
            .to_owned(),
    }
}

fn warnings(inspection: &Inspection) -> String {
    let warnings = inspection.warnings.iter();
    let text: String =
        warnings.map(|warning| summary::warning(warning.severity(), &warning.message(), warning.advice())).collect();
    if text.is_empty() { text } else { format!("\n{text}") }
}

fn fixtures(loaded: &Loaded, inspection: &Inspection) -> String {
    let mut table = Table::new(["fixture", "touch", "contacts", "nominal: mean mm", "max mm"]);
    for (fixture, spread) in loaded.problem.fixtures.iter().zip(&inspection.nominal.per_fixture) {
        let shown = |metres| if spread.count == 0 { "-".to_owned() } else { summary::millimetres(metres) };
        let [mean, max] = [spread.mean, spread.max].map(shown);
        table.row([fixture.name.clone(), fixture.manifold.name().to_owned(), spread.count.to_string(), mean, max]);
    }
    format!("{table}\n")
}

/// Declared distances beside those of the nominal arm; of many, those that differ most.
fn distances(problem: &Problem) -> String {
    if problem.distances.is_empty() {
        return String::new();
    }
    let found = evaluate_held_out(problem, problem, None).distances;
    let mut declared: Vec<_> = found.iter().filter(|each| each.source == DistanceSource::Distance).collect();
    let off = |each: &FixtureDistance| (each.found - each.declared).abs();
    declared.sort_by(|a, b| off(b).total_cmp(&off(a)));
    let mut table = Table::new(["distance", "declared mm", "by the nominal arm mm"]);
    for each in declared.iter().take(MOST_FIXTURES) {
        let [declared, found] = [each.declared, each.found].map(summary::millimetres);
        table.row([each.between.join(" to "), declared, found]);
    }
    if declared.len() > MOST_FIXTURES {
        table.row([format!("… and {} more, which differ less", declared.len() - MOST_FIXTURES)]);
    }
    format!("{table}\n")
}

fn joints(loaded: &Loaded, inspection: &Inspection) -> String {
    let mut table = Table::new(["joint", "minimum", "maximum", "range", "unit", "of limits"]);
    for (range, joint) in inspection.ranges.iter().zip(loaded.problem.robot.moving()) {
        let (factor, unit) = match joint.kind {
            JointKind::Prismatic => (1e3, "mm"),
            _ => (1f64.to_degrees(), "deg"),
        };
        let number = |value: f64| format!("{:.2}", factor * value);
        table.row([
            range.joint.clone(),
            number(range.least),
            number(range.greatest),
            number(range.greatest - range.least),
            unit.to_owned(),
            range.share.map_or("-".to_owned(), |share| format!("{:.0} %", 100.0 * share)),
        ]);
    }
    format!("{table}\n")
}

/// What `--json` prints: SI units and radians.
#[derive(Serialize)]
struct InspectionJson<'a> {
    schema: u32,
    rows_read: u64,
    contacts: usize,
    contacts_per_fixture: BTreeMap<&'a str, usize>,
    files: &'a [String],
    joints: Vec<JointJson<'a>>,
    parameters: Vec<ParameterJson<'a>>,
    rank: usize,
    condition: Option<f64>,
    singular_values: &'a [f64],
    observability: [f64; 5],
    null_space: Vec<&'a str>,
    nominal: ResidualStats,
    warnings: Vec<WarningEntry>,
    inputs: Vec<Input>,
}

#[derive(Serialize)]
struct JointJson<'a> {
    name: &'a str,
    least: f64,
    most: f64,
    share_of_limits: Option<f64>,
}

#[derive(Serialize)]
struct ParameterJson<'a> {
    name: &'a str,
    unit: &'static str,
    sigma: Option<f64>,
    prior_sigma: Option<f64>,
    identifiable: bool,
}

fn json(loaded: &Loaded, inspection: &Inspection) -> Result<String, Failure> {
    let problem = &loaded.problem;
    let identifiability = &inspection.identifiability;
    let names = problem.fixtures.iter().map(|fixture| fixture.name.as_str());

    let json = InspectionJson {
        schema: 1,
        rows_read: problem.contacts.rows_read(),
        contacts: problem.contacts.len(),
        contacts_per_fixture: names.zip(inspection.nominal.per_fixture.iter().map(|spread| spread.count)).collect(),
        files: problem.contacts.files(),
        joints: inspection.ranges.iter().map(joint_json).collect(),
        parameters: inspection.parameters.iter().map(parameter_json).collect(),
        rank: identifiability.rank,
        condition: finite(identifiability.condition),
        singular_values: &identifiability.singular_values,
        observability: inspection.observability,
        null_space: identifiability.null_space.iter().map(|null| null.description.as_str()).collect(),
        nominal: calibration_folder::stats(&inspection.nominal, &problem.fixtures),
        warnings: inspection.warnings.iter().map(Into::into).collect(),
        inputs: loaded.inputs.clone(),
    };
    Ok(serde_json::to_string_pretty(&json)? + "\n")
}

fn joint_json(range: &touchcal::estimate::JointRange) -> JointJson<'_> {
    JointJson { name: &range.joint, least: range.least, most: range.greatest, share_of_limits: range.share }
}

fn parameter_json(expected: &touchcal::estimate::ParameterEstimate) -> ParameterJson<'_> {
    ParameterJson {
        name: &expected.parameter.name,
        unit: expected.parameter.unit.symbol(),
        sigma: expected.sigma,
        prior_sigma: expected.parameter.prior_sigma(),
        identifiable: expected.identifiable,
    }
}

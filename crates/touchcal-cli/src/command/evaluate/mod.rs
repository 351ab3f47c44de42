//! `touchcal evaluate`.

mod json;
mod page;
mod tables;
mod truth;

use std::path::{Path, PathBuf};

use touchcal::estimate::{Evaluation, Fixture, PlacePrior, Problem, Score, evaluate, evaluate_held_out};
use touchcal::experiment::PoseErrors;
use touchcal::io::calibration_folder::{CORRECTION, ESTIMATE, apply_written};
use touchcal::io::estimate_file::{EstimateFile, RobotEntry, Status};
use touchcal::io::problem_file::check_joint_torques;
use touchcal::io::{Input, Loaded, atomic, urdf};
use touchcal::parameter::encoder_errors;

use crate::args::{Arm, EvaluateArgs};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::summary::residuals;
use json::{EvaluationJson, TruthJson};
use tables::evaluation;
use truth::{ParameterError, TrueArm};

/// Reads a problem, evaluates the arms, prints their scores, beside what the calibration predicts.
pub fn run(args: &EvaluateArgs) -> Result<Outcome, Failure> {
    let nominal = Arm { urdf: args.nominal.clone(), joint_compliance: false };
    let urdf = format!(" --urdf {}", args.urdf.display());
    super::refuse_replaced(&args.source, &nominal, ["evaluate", &urdf])?;
    let Loaded { problem, mut inputs, .. } = super::load(&args.source)?;
    let is_held_out = !problem.held_out.is_empty();
    let problem = contacts_to_score(problem)?;
    super::prepare_outputs(args.report.clone(), read_files(args, &inputs))?;
    let urdf = urdf::read_like(&problem.robot, &args.urdf)?;
    inputs.push(urdf.input);
    let estimate = args.estimate.as_deref().map(EstimateFile::read_with_input).transpose()?;
    let estimate = estimate.map(|(file, input)| {
        inputs.push(input);
        file
    });
    if let (Some(path), Some(found)) = (&args.estimate, &estimate) {
        let file = path.display().to_string();
        found.check_robot(&RobotEntry::of(&problem.robot), &file)?;
        found.check_tool(&problem.tool.tip_from_tool, &file)?;
    }
    let mut evaluated = problem.clone();
    match &estimate {
        Some(found) => {
            output::notes(fitted_logs(found, &inputs, is_held_out).as_slice());
            apply_written(&mut evaluated, found);
        }
        None => {
            output::notes(uncertain(&problem).as_slice());
            output::notes(uncorrected(&args.urdf).as_slice());
        }
    }
    evaluated.robot = urdf.robot;
    check_joint_torques(&evaluated.robot, &problem.contacts, problem.contacts.has_joint_torques())?;
    let truth = args.truth.as_deref().map(|path| TrueArm::read(path, &problem)).transpose()?;
    inputs.extend(truth.as_ref().map(|truth| truth.input.clone()));
    let posterior = estimate.as_ref().and_then(EstimateFile::posterior);
    let report = Report {
        urdf: &args.urdf,
        fixtures: &problem.fixtures,
        nominal: evaluate(&problem),
        evaluation: evaluate_held_out(&problem, &evaluated, posterior.as_ref()),
        is_calibrated: posterior.is_some(),
        parameter_errors: truth
            .as_ref()
            .zip(estimate.as_ref())
            .map_or_else(Vec::new, |(truth, estimate)| truth.parameters(&problem, estimate)),
        tool_errors: truth.map(|truth| {
            let found = |name: &str| Some(estimate.as_ref()?.parameters.iter().find(|entry| entry.name == name)?.value);
            let corrected = encoder_errors(&problem.robot, found);
            [truth.errors_of(&problem, &[]), truth.errors_of(&evaluated, &corrected)]
        }),
    };
    if let Some(path) = &args.report {
        let status = estimate.as_ref().map(|found| found.status);
        atomic::write(path, page::html(&problem, &report, status, &inputs)?.as_bytes())?;
    }
    output::print(&if args.json { report.json()? } else { report.text(args.all) })?;
    Ok(outcome(args.estimate.as_deref(), estimate.as_ref()))
}

/// The problem with the contacts that are scored: those that are held out, if there are any.
fn contacts_to_score(problem: Problem) -> Result<Problem, Failure> {
    let (fitted, held_out) = (problem.contacts.len(), problem.held_out.len());
    if fitted + held_out == 0 {
        return Err(Failure::Setup("expected contacts to evaluate on, found none".to_owned()));
    }
    if fitted > 0 && held_out > 0 {
        output::notes(&[format!("scored are the {held_out} contacts that are held out, not the {fitted} others")]);
    }
    Ok(problem.of_held_out_contacts())
}

/// The files that are read, which the page must not replace.
fn read_files<'a>(args: &'a EvaluateArgs, inputs: &'a [Input]) -> impl Iterator<Item = &'a Path> {
    let given = [Some(&args.urdf), args.estimate.as_ref(), args.truth.as_ref()];
    inputs.iter().map(|input| Path::new(&input.path)).chain(given.into_iter().flatten().map(PathBuf::as_path))
}

/// A calibration that must not be used is not, however well it does here.
fn outcome(path: Option<&Path>, estimate: Option<&EstimateFile>) -> Outcome {
    let (Some(path), Some(estimate)) = (path, estimate) else { return Outcome::Done };
    if estimate.status != Status::NotUsable {
        return Outcome::Done;
    }
    output::diagnostic(&format!("the calibration of {} is not usable: do not use it", path.display()));
    Outcome::NotUsable
}

/// A note where declared poses are uncertain; that of a socket without a nominal pose does not
/// count.
fn uncertain(problem: &Problem) -> Option<String> {
    let placed = problem.fixtures.iter().filter(|fixture| fixture.base_from_fixture.is_some());
    let fixtures = placed.map(|fixture| (format!("fixture `{}`", fixture.name), fixture.prior));
    // A tool that is the tip link is where the URDF has it.
    let tool = (!problem.tool_is_tip()).then(|| ("the tool".to_owned(), problem.tool.prior));
    let mut places = tool.into_iter().chain(fixtures);
    let (whose, _) = places.find(|(_, prior)| *prior != PlacePrior::Fixed)?;
    Some(format!(
        "poses are taken as declared, though that of {whose} is uncertain; `--estimate {ESTIMATE}` of the calibration uses the estimated ones"
    ))
}

/// A note where the contacts are those that the calibration was fitted to.
fn fitted_logs(estimate: &EstimateFile, inputs: &[Input], is_held_out: bool) -> Option<String> {
    let is_fitted = |log: &Input| estimate.inputs.iter().any(|input| input.is_log && input.sha256 == log.sha256);
    let logs = || inputs.iter().filter(|input| input.is_log);
    let (all, fitted) = (logs().count(), logs().filter(|log| is_fitted(log)).count());
    (fitted > 0 && !is_held_out).then(|| {
        format!(
            "{fitted} of {all} logs are those of the calibration: agreement with contacts that it was fitted to proves little"
        )
    })
}

/// A note where joints need a correction that the URDF cannot say.
fn uncorrected(urdf: &Path) -> Option<String> {
    let correction = urdf.with_file_name(CORRECTION);
    let words = "errors of encoders are corrected only with `--estimate` of the calibration, not by";
    correction.is_file().then(|| format!("{words} {}", correction.display()))
}

/// What is printed.
struct Report<'a> {
    urdf: &'a Path,
    fixtures: &'a [Fixture],
    nominal: Score,
    evaluation: Evaluation,
    /// Whether it is known what the calibration leaves uncertain.
    is_calibrated: bool,
    /// Errors of the tool with the nominal and the given arm, if the truth is known.
    tool_errors: Option<[PoseErrors; 2]>,
    /// Parameters of the calibration beside the true ones, if both are known.
    parameter_errors: Vec<ParameterError>,
}

impl Report<'_> {
    fn json(&self) -> Result<String, Failure> {
        let mut json = EvaluationJson::new(self.urdf, self.fixtures, &self.evaluation, &self.nominal);
        json.truth = self.tool_errors.as_ref().map(|errors| TruthJson::new(errors, &self.parameter_errors));
        Ok(serde_json::to_string_pretty(&json)? + "\n")
    }

    fn text(&self, all: bool) -> String {
        let (title, score) = (self.urdf.display(), &self.evaluation.score);
        let title = format!("Score of {title} on {} contacts (distance from contact, mm)\n", score.all.count);
        let scores = residuals(self.fixtures, &[("nominal", &self.nominal), ("given", score)]);
        let tool_errors = self.tool_errors.as_ref().map_or_else(String::new, truth::text);
        let parameters = truth::parameter_table(&self.parameter_errors, all);
        title + &scores + &tool_errors + &parameters + &evaluation(self.fixtures, &self.evaluation, self.is_calibrated)
    }
}

//! `touchcal evaluate`.

use std::path::Path;

use serde::Serialize;
use touchcal::estimate::{Fixture, PlacePrior, Problem, Score, evaluate};
use touchcal::io::calibration_folder::{ESTIMATE, place_written, stats};
use touchcal::io::estimate_file::{EstimateFile, ResidualStats};
use touchcal::io::urdf;
use touchcal::robot::Robot;

use crate::args::{Arm, EvaluateArgs};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::summary::residuals;

/// Scores as printed with `--json`.
#[derive(Serialize)]
struct ScoresJson {
    urdf: String,
    /// Of the given URDF, at the top.
    #[serde(flatten)]
    given: ResidualStats,
    /// Of the nominal one.
    nominal: ResidualStats,
}

/// Reads a problem, evaluates the arms, prints their scores.
pub fn run(args: &EvaluateArgs) -> Result<Outcome, Failure> {
    let nominal = Arm { urdf: args.nominal.clone(), joint_compliance: false };
    let urdf = format!(" --urdf {}", args.urdf.display());
    super::refuse_replaced(&args.source, &nominal, ["evaluate", &urdf])?;
    let mut problem = super::load(&args.source)?.problem;
    let given = urdf::read_like(&problem.robot, &args.urdf)?.robot;
    let nominal = evaluate(&problem);
    match &args.estimate {
        Some(path) => place_written(&mut problem, &EstimateFile::read_file(path)?),
        None => output::notes(uncertain(&problem).as_slice()),
    }
    let score = score_with(&mut problem, given);
    let scores = Scores { score, nominal, problem };
    output::print(&if args.json { scores.json(&args.urdf)? } else { scores.table(&args.urdf) })?;
    Ok(Outcome::Done)
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

struct Scores {
    score: Score,
    nominal: Score,
    problem: Problem,
}

impl Scores {
    fn json(&self, urdf: &Path) -> Result<String, Failure> {
        let fixtures = &self.problem.fixtures;
        let scores = ScoresJson {
            urdf: urdf.display().to_string(),
            given: stats(&self.score, fixtures),
            nominal: stats(&self.nominal, fixtures),
        };
        Ok(serde_json::to_string_pretty(&scores)? + "\n")
    }

    fn table(&self, urdf: &Path) -> String {
        let fixtures: &[Fixture] = &self.problem.fixtures;
        let contacts = self.problem.contacts.len();
        let title = format!("Score of {} on {contacts} contacts (distance from touching, mm)\n", urdf.display());
        title + &residuals(fixtures, &[("nominal", &self.nominal), ("given", &self.score)])
    }
}

/// The score of another arm; `problem` keeps that arm.
fn score_with(problem: &mut Problem, robot: Robot) -> Score {
    problem.robot = robot;
    evaluate(problem)
}

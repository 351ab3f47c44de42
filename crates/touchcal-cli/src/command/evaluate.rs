//! `touchcal evaluate`.

use std::path::Path;

use serde::Serialize;
use touchcal::estimate::{Fixture, PlacePrior, Problem, Score, evaluate};
use touchcal::io::calibration_folder::{ESTIMATE, place_written, stats};
use touchcal::io::estimate_file::{EstimateFile, ResidualStats};
use touchcal::io::mukca;
use touchcal::io::urdf;
use touchcal::robot::Robot;

use super::{Failure, Outcome};
use crate::args::{Arm, EvaluateArgs};
use crate::output;
use crate::summary::residuals;

/// Scores as printed with `--json`.
#[derive(Serialize)]
struct ScoresJson {
    urdf: String,
    /// Of the given URDF, at the top.
    #[serde(flatten)]
    given: ResidualStats,
    /// Of the nominal one, where there is one.
    nominal: Option<ResidualStats>,
}

/// Reads, scores, tells.
pub fn run(args: &EvaluateArgs) -> Result<Outcome, Failure> {
    let scored = match &args.source.mukca {
        Some(folder) => {
            let given = urdf::read_file(&args.urdf, super::ends(&args.source))?;
            let nominal = args
                .nominal
                .as_deref()
                .map(|path| urdf::read_like(&given.robot, path))
                .transpose()?
                .map(|file| file.robot);
            let mut problem = mukca::read(folder, given, &super::mukca_options(&args.source))?.problem;
            let score = evaluate(&problem);
            let nominal = nominal.map(|nominal| with(&mut problem, nominal));
            Scored { score, nominal, problem }
        }
        None => {
            let mut problem = super::load(&args.source, &Arm::default())?.problem;
            let given = urdf::read_like(&problem.robot, &args.urdf)?.robot;
            let nominal = evaluate(&problem);
            match &args.estimate {
                Some(path) => place_written(&mut problem, &EstimateFile::read_file(path)?),
                None => output::notes(uncertain(&problem).as_slice()),
            }
            let score = with(&mut problem, given);
            Scored { score, nominal: Some(nominal), problem }
        }
    };
    output::print(&if args.json { scored.json(&args.urdf)? } else { scored.table(&args.urdf) })?;
    Ok(Outcome::Done)
}

/// What is taken for granted where places are not known for sure; that of a socket without one does
/// not count.
fn uncertain(problem: &Problem) -> Option<String> {
    let placed = problem.fixtures.iter().filter(|fixture| fixture.base_from_fixture.is_some());
    let fixtures = placed.map(|fixture| (format!("fixture `{}`", fixture.name), fixture.prior));
    let mut places = std::iter::once(("the tool".to_owned(), problem.tool.prior)).chain(fixtures);
    let (whose, _) = places.find(|(_, freedom)| *freedom != PlacePrior::Fixed)?;
    Some(format!(
        "places are taken as the problem declares them, though that of {whose} is uncertain; `--estimate {ESTIMATE}` of the calibration takes them as found"
    ))
}

struct Scored {
    score: Score,
    nominal: Option<Score>,
    problem: Problem,
}

impl Scored {
    fn json(&self, urdf: &Path) -> Result<String, Failure> {
        let fixtures = &self.problem.fixtures;
        let scores = ScoresJson {
            urdf: urdf.display().to_string(),
            given: stats(&self.score, fixtures),
            nominal: self.nominal.as_ref().map(|nominal| stats(nominal, fixtures)),
        };
        Ok(serde_json::to_string_pretty(&scores)? + "\n")
    }

    fn table(&self, urdf: &Path) -> String {
        let fixtures: &[Fixture] = &self.problem.fixtures;
        let contacts = self.problem.contacts.len();
        let title = format!("Score of {} on {contacts} contacts (distance from touching, mm)\n", urdf.display());
        match &self.nominal {
            Some(nominal) => title + &residuals(fixtures, &[("nominal", nominal), ("given", &self.score)]),
            None => title + &residuals(fixtures, &[("given", &self.score)]),
        }
    }
}

/// The score with another arm.
fn with(problem: &mut Problem, robot: Robot) -> Score {
    problem.robot = robot;
    evaluate(problem)
}

//! The battery on recorded contacts.

use std::ops::ControlFlow;

use super::declare::change_parts;
use super::excitation::Excitation;
use super::kind::FalsifiedKind;
use super::trial::{FalsifiedError, FalsifiedOptions, FalsifiedRow, answer};
use crate::estimate::{Loss, Method, Noise, Problem};
use crate::experiment::problem::LOSS_SCALE;
use crate::experiment::trial::{Search, Trial};
use crate::geometry::{Parts, PrismPair};
use crate::manifold::Unmodeled;
use crate::robot::Kinematics;
use crate::sim::{PartsError, Truth};

const DEG: f64 = std::f64::consts::PI / 180.0;
/// Noise that recorded contacts are declared to have: encoders of 0.002°, parts of 0.02 mm.
const NOISE: Noise = Noise { encoder: 0.002 * DEG, contact: 0.02e-3, is_estimated: false };

/// Whether `kind` can be tried with recorded contacts of a peg in a hole: the problem alone is
/// false.
pub fn has_recorded(kind: &FalsifiedKind) -> bool {
    kind.excitations.contains(&Excitation::Paper) && kind.falsification.is_of_problem()
}

/// Calibrates a recorded `trial`, of an iiwa 14 with the parts of [`Excitation::Paper`], with the
/// problem that declares what is false by `kind` (see [`has_recorded`]), and compares the estimate
/// with the trial's truth. `name` is the row's excitation. The same arguments give the same row.
/// `watch` is called again and again; if it breaks, the row is of no use.
///
/// # Errors
/// If falsified shapes are not valid.
pub fn falsified_recorded_trial(
    kind: &FalsifiedKind,
    (name, trial): (&str, &Trial),
    options: FalsifiedOptions,
    watch: &mut dyn FnMut() -> ControlFlow<()>,
) -> Result<FalsifiedRow, FalsifiedError> {
    let problem = problem(kind, trial, options.seed)?;
    let truth = Truth { errors: trial.truth.clone(), ..Truth::default() };
    let true_arm = Kinematics::new(&trial.true_robot(), &[], trial.tip_from_peg);
    let truth = kind.falsification.relative_truth(&truth);
    Ok(answer(kind, (name, options), &problem, (&truth, &true_arm), watch))
}

fn problem(kind: &FalsifiedKind, trial: &Trial, seed: u64) -> Result<Problem, PartsError> {
    let scenario = Excitation::Paper.scenario(trial.robot.clone(), trial.contacts.len())?;
    let search = Search { method: Method::default(), noise: NOISE, loss: Loss::GemanMcClure(LOSS_SCALE) };
    let mut posed = trial.problem(Box::new(Unmodeled), search);
    let as_they_are = |parts: &PrismPair| Ok(Parts::PegInHole(Box::new(parts.clone())));
    change_parts(&mut posed, &scenario, as_they_are)?;
    kind.declared.apply(&mut posed);
    kind.falsification.falsify_problem(&mut posed, &scenario, seed)?;
    Ok(posed)
}

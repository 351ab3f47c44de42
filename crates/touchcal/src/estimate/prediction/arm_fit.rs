//! Whether an arm meets the fixtures of its problem.

use super::held_out::scatter;
use super::prediction_model::{ArmOf, PredictionModel};
use crate::estimate::evaluate::evaluate;
use crate::estimate::problem::Problem;
use crate::estimate::result::{ArmFit, Scatter};

/// Distance (m) that a calibrated arm may be off besides: what calibrations of real arms leave at
/// places that they have not seen is mostly less.
const OF_ARM: f64 = 0.5e-3;

/// Whether contacts with the fixture of index `fixture` in [`Problem::fixtures`] can be taken for
/// poses on its contact manifold: the problem's arm meets that fixture, or, if its shape is not
/// known, all others whose shapes are. Allowed are distances that the noise and the declared
/// tolerances of tool, fixtures and shapes make by chance, and half a millimetre of the arm. Panics
/// if a contact's fixture is not in [`Problem::fixtures`].
pub fn arm_fit(problem: &Problem, fixture: usize) -> ArmFit {
    let prediction = PredictionModel::new(problem, None, ArmOf::Calibrated);
    let (_, per_fixture) = scatter(&prediction, &evaluate(problem));
    let judged: Vec<(usize, Scatter)> = match per_fixture.get(fixture).copied().flatten() {
        Some(own) => vec![(fixture, own)],
        None => per_fixture.into_iter().enumerate().filter_map(|(f, scatter)| Some((f, scatter?))).collect(),
    };
    let allowed = |scatter: &Scatter| OF_ARM + scatter.by_chance[1] * scatter.predicted;
    let excess = |scatter: &Scatter| scatter.found / allowed(scatter);
    match judged.into_iter().max_by(|(_, a), (_, b)| excess(a).total_cmp(&excess(b))) {
        None => ArmFit::Unknown,
        Some((fixture, worst)) if excess(&worst) > 1.0 => {
            ArmFit::Missed { fixture, found: worst.found, allowed: allowed(&worst) }
        }
        Some(_) => ArmFit::Met,
    }
}

//! Whether an arm meets the fixtures of its problem.

use super::held_out::scatter;
use super::place_fit::PlaceFit;
use super::prediction_model::{ArmOf, PredictionModel};
use crate::estimate::evaluate::evaluate;
use crate::estimate::problem::Problem;
use crate::estimate::result::{ArmFit, Scatter};

/// Distance (m) that a calibrated arm may be off: what calibrations of real arms leave at
/// places that they have not seen is mostly less.
const OF_ARM: f64 = 0.5e-3;
/// Angle (rad) of the tool that such an arm may be off.
const ANGLE_OF_ARM: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Probability (1) below which a place is none that its declaration allows.
const IMPOSSIBLE: f64 = 1e-3;

/// Whether contacts with the fixture of index `fixture` in [`Problem::fixtures`] can be taken for
/// poses on its contact manifold: the problem's arm meets that fixture, or, if its shape is not
/// known, all others whose shapes are.
///
/// The places of tool and fixture are fitted to the contacts, within what is declared of them. Then
/// contacts may scatter as much as the noise and the tolerance of the shapes make by chance, and
/// half a millimetre more; and the place must be one that its declaration allows, with a
/// probability of 0.001 at least and 0.2 mm and 0.02° (standard deviation) of the arm besides.
/// Panics if a contact's fixture is not in [`Problem::fixtures`].
pub fn arm_fit(problem: &Problem, fixture: usize) -> ArmFit {
    let prediction = PredictionModel::new(problem, None, ArmOf::Calibrated);
    let (_, known) = scatter(&prediction, &evaluate(problem));
    let judged = match known.get(fixture) {
        Some(Some(_)) => fixture..fixture + 1,
        _ => 0..known.len(),
    };
    let each = judged.filter(|&f| known[f].is_some()).map(|f| fit(problem, f));
    each.fold(ArmFit::Unknown, |worst, fit| if severity(&fit) > severity(&worst) { fit } else { worst })
}

/// How bad a fit is: its kind, then its size.
fn severity(fit: &ArmFit) -> (u8, f64) {
    match fit {
        ArmFit::Unknown => (0, 0.0),
        ArmFit::Met => (1, 0.0),
        ArmFit::Displaced(displacement) => (2, displacement.distance),
        ArmFit::Elsewhere(displacement) => (3, displacement.distance),
        ArmFit::Missed { found, .. } => (4, *found),
    }
}

fn fit(problem: &Problem, fixture: usize) -> ArmFit {
    let Some(PlaceFit { placed, displacement }) = PlaceFit::new(problem, fixture) else { return ArmFit::Unknown };
    let prediction = PredictionModel::new(&placed, None, ArmOf::Calibrated);
    let (_, per_fixture) = scatter(&prediction, &evaluate(&placed));
    let allowed = |scatter: &Scatter| OF_ARM + scatter.by_chance[1] * scatter.predicted;
    match per_fixture[fixture] {
        Some(scatter) if scatter.found > allowed(&scatter) => {
            ArmFit::Missed { fixture, found: scatter.found, allowed: allowed(&scatter) }
        }
        _ if displacement.p_value < IMPOSSIBLE => ArmFit::Elsewhere(displacement),
        _ if displacement.distance > OF_ARM || displacement.angle > ANGLE_OF_ARM => ArmFit::Displaced(displacement),
        _ => ArmFit::Met,
    }
}

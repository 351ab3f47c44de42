//! An arm on contacts that it was not calibrated with.

use statrs::distribution::{ContinuousCDF, Normal};

use super::distances::{FixtureDistances, fixture_distances};
use super::prediction_model::{ArmOf, PredictionModel};
use super::scatter::{SquaredDistances, TAIL, squared_distances};
use crate::estimate::evaluate::{apply_estimate, evaluate};
use crate::estimate::problem::Problem;
use crate::estimate::result::{Contradiction, Estimate, Evaluation, ParameterPosterior, Scatter, Score};

/// Evaluates the arm of `evaluated` on its contacts, beside how well it should do: with the noise
/// of the problem (of the calibration, if the problem declares none), and the errors of arm, tool
/// and fixtures that the calibration's `posterior` leaves. Without a posterior the arm counts as
/// exact and tool and fixtures have their declared tolerances, so that nothing is contradicted.
///
/// `nominal` is the problem as it is declared, with the arm and the places from which the
/// calibration started; `evaluated` has the same contacts with the calibrated arm and all else that
/// the calibration found ([`apply_estimate`](crate::estimate::apply_estimate)). If the estimates do
/// not lead from the one arm to the other, as where encoder offsets are applied elsewhere,
/// derivatives are taken at the evaluated arm, which is less exact. Errors in directions that the
/// calibration fixed at zero are not predicted. Panics if a contact's fixture is not in
/// [`Problem::fixtures`].
pub fn evaluate_held_out(nominal: &Problem, evaluated: &Problem, posterior: Option<&ParameterPosterior>) -> Evaluation {
    let estimated = posterior.map(|known| PredictionModel::new(nominal, Some(known), ArmOf::Nominal));
    let estimated = estimated.filter(|prediction| prediction.has_arm_of(evaluated));
    let prediction = estimated.unwrap_or_else(|| PredictionModel::new(evaluated, posterior, ArmOf::Calibrated));
    let score = evaluate(evaluated);
    let (scatter, per_fixture) = scatter(&prediction, &score);
    let FixtureDistances { each: distances, common: common_strain } =
        fixture_distances(&prediction, nominal, &per_fixture);
    let evaluation = Evaluation { score, scatter, per_fixture, distances, common_strain, contradictions: Vec::new() };
    match posterior {
        Some(_) => Evaluation { contradictions: contradictions(&evaluation, nominal), ..evaluation },
        None => evaluation,
    }
}

/// Evaluates `estimate`, one of `problem`, on the contacts that are held out from it; `None` if
/// there are none, or the estimate has no uncertainty. Panics as [`evaluate_held_out`].
pub(crate) fn held_out(problem: &Problem, estimate: &Estimate) -> Option<Evaluation> {
    let posterior = ParameterPosterior::of_estimate(estimate).filter(|_| !problem.held_out.is_empty())?;
    let nominal = Problem { contacts: problem.held_out.clone(), ..problem.clone() };
    let mut evaluated = Problem { robot: estimate.robot.clone(), ..nominal.clone() };
    apply_estimate(&mut evaluated, |name| Some(estimate.parameter(name)?.value));
    Some(evaluate_held_out(&nominal, &evaluated, Some(&posterior)))
}

/// Scatter of all contacts and of those with each fixture.
pub(super) fn scatter(prediction: &PredictionModel<'_>, score: &Score) -> (Option<Scatter>, Vec<Option<Scatter>>) {
    let covariance = &prediction.covariance;
    let touched = score.per_fixture.iter().filter(|spread| spread.count > 0).count();
    let mut all = Some(SquaredDistances::new(covariance.nrows()));
    let each = score.per_fixture.iter().enumerate().map(|(f, spread)| {
        if spread.count == 0 {
            return None;
        }
        let sums = squared_distances(prediction, f);
        all = match (all.take(), &sums) {
            (Some(mut all), Some(sums)) => {
                all.add(sums);
                Some(all)
            }
            _ => None,
        };
        sums?.scatter(spread, covariance, touched)
    });
    let per_fixture = each.collect();
    (all.and_then(|all| all.scatter(&score.all, covariance, 1)), per_fixture)
}

/// What is found and cannot be chance: the scatter of all contacts, else that with single fixtures;
/// the common strain of all distances, else single ones, of which one in a thousand evaluations has
/// any by chance.
fn contradictions(evaluation: &Evaluation, problem: &Problem) -> Vec<Contradiction> {
    let of_scatter = |fixture: Option<&str>, scatter: &Scatter| Contradiction::Scatter {
        fixture: fixture.map(str::to_owned),
        ratio: scatter.ratio(),
        limit: scatter.by_chance[1],
    };
    let all = evaluation.scatter.iter().filter(|scatter| scatter.is_exceeded());
    let mut found: Vec<Contradiction> = all.map(|scatter| of_scatter(None, scatter)).collect();
    if found.is_empty() {
        let each = problem.fixtures.iter().zip(&evaluation.per_fixture);
        let exceeded = each.filter_map(|(fixture, scatter)| Some((fixture, scatter.filter(Scatter::is_exceeded)?)));
        found.extend(exceeded.map(|(fixture, scatter)| of_scatter(Some(&fixture.name), &scatter)));
    }
    let limit = |count: usize| Normal::standard().inverse_cdf(1.0 - TAIL / count.max(1) as f64);
    if let Some(common) = evaluation.common_strain.filter(|common| common.deviations().abs() > limit(1)) {
        found.push(Contradiction::CommonStrain { strain: common.strain, deviations: common.deviations() });
        return found;
    }
    let limit = limit(evaluation.distances.len());
    let beyond = evaluation.distances.iter().filter(|distance| distance.deviations().abs() > limit);
    found.extend(beyond.map(|distance| Contradiction::Distance {
        between: distance.between.clone(),
        difference: distance.difference(),
        deviations: distance.deviations(),
    }));
    found
}

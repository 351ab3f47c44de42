//! What is made of a minimum: verdicts, uncertainty, warnings and a status.

use nalgebra::{DMatrix, DVector};

use super::calibrate::Search;
use super::knowledge::Knowledge;
use super::mistakes::mistakes;
use super::outcome::{
    ContactCount, Estimate, Estimated, LEAST_GAP_ERROR, Status, StopReason, Termination, Verdict, Warning,
};
use super::problem::Problem;
use super::score::score;
use super::system::System;
use super::workspace::arm_uncertainty_left;
use crate::robot::{Column, Parameter};

/// A contact whose robust weight falls below this counts as rejected.
const REJECTED_BELOW: f64 = 0.05;
/// Share of rejected contacts that deserves a warning.
const MANY_REJECTED: f64 = 0.2;
/// Measured over declared noise that deserves a warning.
const NOISE_EXCEEDED: f64 = 1.5;
/// Measured over declared noise from which one-sided gaps are not usable: what scatters so much is no noise, but another shape or place.
const NOISE_CONTRADICTED: f64 = 3.0;
/// Contacts that say as much as one from which that deserves a warning: they make uncertainties twice as large.
const ALIKE: f64 = 4.0;
/// And from which the result is not usable: errors that are the same so often bias it, and how much no contact can tell.
const ALL_ALIKE: f64 = 9.0;
/// A joint range (rad or m) below which its parameters resemble its neighbours'.
const HARDLY_MOVED: f64 = 0.035;
/// A result is usable if the data bring the arm's uncertainty below this share of what it was.
const USABLE_BELOW: f64 = 0.5;
/// An arm's parameter beyond so many plausible sizes is no calibration: strains of 25 %, offsets of 25°.
const IMPLAUSIBLE: f64 = 5.0;
/// Prior standard deviations that deserve a warning.
const FAR_FROM_PRIOR: f64 = 4.0;

/// Statistics of the contacts at a minimum.
struct Found {
    /// `A²/B · Σ JᵀJ` of all contacts, and the known distances.
    data: DMatrix<f64>,
    /// Robust weight and deviation of each contact.
    verdicts: Vec<Verdict>,
    noise_factor: f64,
    rows: usize,
}

impl Found {
    fn new(system: &System<'_>, theta: &DVector<f64>) -> Self {
        let loss = system.problem.loss;
        let (mut slope, mut square, mut count) = (0.0, 0.0, 0);
        let mut verdicts = Vec::with_capacity(system.problem.contacts.len());
        let (information, norms) = system.statistics(theta);
        for (squared, dimension) in norms {
            let weight = loss.weight(squared);
            count += dimension;
            // ψ(r) = w(s) r with s = ‖r‖²: trace of ψ′ is d·w + 2 s w′.
            slope += dimension as f64 * weight + 2.0 * squared * loss.weight_slope(squared);
            square += weight * weight * squared;
            verdicts.push(if weight < REJECTED_BELOW {
                Verdict::Rejected { deviations: squared.sqrt() }
            } else {
                Verdict::Used { weight }
            });
        }
        let contacts = verdicts.len().max(1);
        let rows = count.max(1) as f64;
        let expected = loss.gaussian_variance((count + contacts / 2) / contacts);
        let (slope, square) = ((slope / rows).max(0.05), square / rows);
        let noise_factor = (square / (slope * slope * expected)).max(0.0).sqrt();
        // Declared noise is a floor: a lucky sample makes nothing more certain.
        let share = 1.0 / (expected * noise_factor.max(1.0).powi(2));
        let data = information * share + system.distance_information(theta);
        Found { data, verdicts, noise_factor, rows: count }
    }
}

/// Puts the outcome together.
pub(super) fn conclude(search: &Search<'_>) -> Estimate {
    let Search { system, scale, theta, held, termination, .. } = search;
    let problem = system.problem;
    let found = Found::new(system, theta);
    // The least of several gaps scatters otherwise than each of them.
    let noise_factor = if search.sees_walls() { system.wall_noise } else { found.noise_factor };
    let found = &Found { noise_factor, ..found };
    let mut known = Knowledge::new(system, &found.data, scale, held);
    let mut alike = None;
    if let Some((covariance, effect)) = search.wall_covariance() {
        known.covariance = covariance;
        alike = Some(effect);
    } else if search.telling.is_some() {
        known.covariance *= LEAST_GAP_ERROR.powi(2);
    }
    let projected = has_projection(problem);
    let estimated = system.parameters.iter().enumerate().map(|(k, parameter)| Estimated {
        parameter: parameter.clone(),
        value: theta[k],
        sigma: if projected { None } else { known.sigma(k) },
        identifiable: known.identifiable[k],
    });
    let parameters: Vec<Estimated> = estimated.collect();
    let columns: Vec<Column> = system.parameters.iter().map(|parameter| parameter.column).collect();
    let rejected = found.verdicts.iter().filter(|verdict| matches!(verdict, Verdict::Rejected { .. })).count();
    let mut estimate = Estimate {
        status: Status::Converged,
        covariance: known.covariance,
        identifiability: known.identifiability,
        postfit: score(problem, &system.at(theta)),
        contacts: ContactCount { read: problem.contacts.rows_read(), used: found.verdicts.len() - rejected, rejected },
        verdicts: found.verdicts.clone(),
        termination: *termination,
        warnings: Vec::new(),
        noise_factor: found.noise_factor,
        robot: problem.robot.calibrated(&columns, theta.as_slice()),
        parameters,
    };
    let left = arm_uncertainty_left(problem, &system.parameters, &known.posterior, &system.scale());
    estimate.warnings = warnings(search, found, &estimate, (left, alike));
    estimate.status = status(&estimate.termination, &estimate.warnings);
    estimate
}

fn status(termination: &Termination, warnings: &[Warning]) -> Status {
    match termination.reason {
        _ if warnings.iter().any(Warning::forbids) => Status::NotUsable,
        StopReason::Converged => Status::Converged,
        _ => Status::NotConverged,
    }
}

/// Whether any contacts are measured by a projection, from which no uncertainty follows.
pub(super) fn has_projection(problem: &Problem) -> bool {
    problem.fixtures.iter().any(|fixture| fixture.manifold.is_projection())
}

/// Those that forbid the result first; `left` of the arm's uncertainty, and so many contacts `alike` as say as much as one, if that follows from walls.
fn warnings(
    search: &Search<'_>,
    found: &Found,
    estimate: &Estimate,
    (left, alike): (f64, Option<f64>),
) -> Vec<Warning> {
    let Search { system, held, .. } = search;
    let mut warnings = mistakes(system);
    let without_prior = system.parameters.iter().filter(|parameter| parameter.prior_sigma.is_none()).count();
    let rows = found.rows + system.problem.distances.len();
    if found.verdicts.is_empty() || rows < without_prior {
        warnings.push(Warning::TooFewContacts { rows, parameters: without_prior });
    }
    if left > USABLE_BELOW {
        warnings.push(Warning::ArmUndetermined { left });
    }
    if !held.pivots.is_empty() {
        let names = held.pivots.iter().map(|&k| system.parameters[k].name.clone()).collect();
        warnings.push(Warning::Held { names });
    }
    let factor = found.noise_factor;
    let declared = !system.problem.noise.learned;
    if factor > NOISE_CONTRADICTED && system.has_walls() && declared {
        warnings.push(Warning::NoiseContradicted { factor });
    } else if factor > NOISE_EXCEEDED {
        warnings.push(Warning::NoiseExceeded { factor, declared });
    }
    let share = estimate.contacts.rejected as f64 / found.verdicts.len().max(1) as f64;
    if share > MANY_REJECTED {
        warnings.push(Warning::ManyRejected { share });
    }
    match (alike, search.telling) {
        (Some(contacts), _) if contacts > ALIKE => {
            warnings.push(Warning::ErrAlike { contacts, usable: contacts < ALL_ALIKE });
        }
        (None, Some(share)) => warnings.push(Warning::FewTellWalls { share }),
        _ => {}
    }
    if search.ambiguous {
        warnings.push(Warning::Ambiguous);
    }
    if has_projection(system.problem) {
        warnings.push(Warning::NoUncertainty);
    }
    let contacts = &system.problem.contacts;
    for (i, joint) in system.problem.robot.moving().enumerate() {
        let positions = (0..contacts.len()).map(|c| contacts.q(c)[i]);
        let (least, most) = positions.fold((f64::MAX, f64::MIN), |(a, b), q| (a.min(q), b.max(q)));
        if most - least < HARDLY_MOVED && !contacts.is_empty() {
            warnings.push(Warning::JointHardlyMoved { joint: joint.name.clone(), range: most - least });
        }
    }
    warnings.extend(estimate.parameters.iter().filter_map(implausible));
    warnings.sort_by_key(|warning| !warning.forbids());
    warnings
}

/// What is the matter with a parameter's value.
fn implausible(estimated: &Estimated) -> Option<Warning> {
    let Parameter { name, column, scale, .. } = &estimated.parameter;
    let (name, value) = (name.clone(), estimated.value);
    let deviations = estimated.parameter.prior_sigma.map_or(0.0, |sigma| value.abs() / sigma);
    match column {
        _ if !column.block().is_nuisance() && value.abs() > IMPLAUSIBLE * scale => {
            Some(Warning::Implausible { name, value })
        }
        // Parts touch with their surfaces: half a millimetre off is another place, or another part.
        Column::Interference(_) if deviations > FAR_FROM_PRIOR => Some(Warning::NotTouching { name, gap: value }),
        _ if deviations > FAR_FROM_PRIOR => Some(Warning::FarFromPrior { name, deviations }),
        _ => None,
    }
}

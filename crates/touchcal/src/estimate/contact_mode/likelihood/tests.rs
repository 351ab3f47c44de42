//! Derivatives against differences, and the score at the truth.

use nalgebra::SVector;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::{MarginalLikelihood, marginal_likelihood};
use crate::estimate::contact_mode::{CandidateContacts, CandidateMatrix, CandidateVector};
use crate::estimate::options::ContactModeOptions;

const ODDS: f64 = 2e-4;
const MICRON: f64 = 1e-6;

/// Three candidates, the first two of opposite normals, so that their noise is anticorrelated.
fn covariance(opposite: f64) -> CandidateMatrix {
    let mut covariance = CandidateMatrix::zeros();
    let entries = [(0, 0, 700.0), (1, 1, 750.0), (2, 2, 500.0), (0, 1, -opposite), (0, 2, 80.0), (1, 2, -30.0)];
    for (a, b, entry) in entries {
        covariance[(a, b)] = entry * MICRON * MICRON;
        covariance[(b, a)] = covariance[(a, b)];
    }
    covariance
}

fn likelihood_of(candidates: &CandidateContacts) -> MarginalLikelihood {
    marginal_likelihood(candidates, &ContactModeOptions::default())
}

fn distances(each: [f64; 3]) -> CandidateVector {
    let mut distances = CandidateVector::zeros();
    each.iter().enumerate().for_each(|(k, distance)| distances[k] = distance * MICRON);
    distances
}

/// Candidates of surfaces that are touched equally often.
fn candidates(
    distances: CandidateVector,
    covariance: CandidateMatrix,
    count: usize,
    no_contact: f64,
) -> CandidateContacts {
    CandidateContacts {
        no_contact,
        count,
        distances,
        covariance,
        odds: CandidateVector::repeat(ODDS),
        with_odds_derivatives: true,
    }
}

#[test]
fn derivatives_are_those_of_the_cost() {
    let (covariance, h) = (covariance(650.0), 1e-3 * MICRON);
    for each in [[3.0, 5.0, -4.0], [40.0, -30.0, 80.0], [-20.0, 35.0, 10.0], [60.0, 70.0, 90.0], [-150.0, 20.0, 0.0]] {
        let at = |d: &CandidateVector| likelihood_of(&candidates(*d, covariance, 3, 1e-3));
        let d = distances(each);
        let found = at(&d);
        for k in 0..3 {
            let mut step = CandidateVector::zeros();
            step[k] = h;
            let (after, before) = (at(&(d + step)), at(&(d - step)));
            let slope = (after.nll - before.nll) / (2.0 * h);
            assert!((slope - found.score[k]).abs() < 1e-4 / MICRON, "{each:?}: {slope:e} {:e}", found.score[k]);
            let curvature = (after.score - before.score) / (2.0 * h);
            let off = (curvature - found.observed_information.column(k)).amax();
            assert!(
                off < 1e-4 * found.complete_information.amax().max(1.0 / (30.0 * MICRON).powi(2)),
                "{each:?}: {off:e}"
            );
        }
    }
}

#[test]
fn derivatives_by_odds_are_those_of_cost_and_slope() {
    const H: f64 = 1e-5;
    for each in [[3.0, 5.0, -4.0], [40.0, -30.0, 80.0], [-20.0, 35.0, 10.0], [60.0, 70.0, 90.0]] {
        let at = |k: usize, step: f64| {
            let mut near = candidates(distances(each), covariance(650.0), 3, 1e-3);
            near.odds[k] *= step.exp();
            likelihood_of(&near)
        };
        let found = at(0, 0.0);
        for k in 0..3 {
            let (after, before) = (at(k, H), at(k, -H));
            assert!(((before.nll - after.nll) / (2.0 * H) - found.active[k]).abs() < 1e-8, "{each:?}");
            let touched = (after.active - before.active) / (2.0 * H);
            assert!((touched - found.active_covariance.column(k)).amax() < 1e-8, "{each:?}");
            let slope = (after.score - before.score) / (2.0 * H);
            let off = (slope - found.score_by_odds.column(k)).amax();
            assert!(off < 1e-6 * found.score.amax(), "{each:?}: {off:e} of {:e}", found.score.amax());
        }
    }
}

#[test]
fn one_candidate_active_for_sure_is_least_squares() {
    let variance = (28.0 * MICRON).powi(2);
    let one = candidates(distances([20.0, 0.0, 0.0]), CandidateMatrix::identity() * variance, 1, 1e-13);
    let found = likelihood_of(&one);
    assert!((found.score[0] * variance / (20.0 * MICRON) - 1.0).abs() < 1e-6);
    assert!((found.complete_information[(0, 0)] * variance - 1.0).abs() < 1e-6);
    assert!((found.active[0] - 1.0).abs() < 1e-6 && (found.in_contact - 1.0).abs() < 1e-6);
}

/// Candidates drawn from the model: active or free, free ones evenly spread, with noise. The least
/// distance is off by several of its standard errors.
#[test]
fn the_score_is_zero_on_average_where_the_least_distance_is_not() {
    const CONTACTS: usize = 40_000;
    let band = 400.0 * MICRON;
    let touched_share = ODDS / (ODDS + band);
    let covariance = covariance(150.0);
    let factor = covariance.fixed_view::<3, 3>(0, 0).into_owned().cholesky().unwrap().l();
    let mut chance = Pcg64::seed_from_u64(7);
    let (mut sum, mut squares, mut least) = ([0.0; 3], [0.0; 3], 0.0);
    let mut contacts = 0;
    while contacts < CONTACTS {
        let touched: [bool; 3] = std::array::from_fn(|_| chance.random::<f64>() < touched_share);
        if !touched.contains(&true) {
            continue;
        }
        contacts += 1;
        let noise = factor * SVector::<f64, 3>::from_fn(|_, _| StandardNormal.sample(&mut chance));
        let each: [f64; 3] =
            std::array::from_fn(|k| noise[k] + if touched[k] { 0.0 } else { band * chance.random::<f64>() });
        let found = likelihood_of(&candidates(distances(each.map(|d| d / MICRON)), covariance, 3, 1e-7));
        for k in 0..3 {
            sum[k] += found.score[k];
            squares[k] += found.score[k].powi(2);
        }
        least += each.iter().copied().fold(f64::INFINITY, f64::min) / CONTACTS as f64;
    }
    for k in 0..3 {
        let standard_error = squares[k].sqrt();
        assert!(sum[k].abs() < 3.5 * standard_error, "{k}: {} standard errors", sum[k] / standard_error);
    }
    assert!(least < -20.0 * 27.0 * MICRON / (CONTACTS as f64).sqrt(), "{least:e}");
}

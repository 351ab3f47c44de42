//! The marginal likelihood of one contact over its active sets.
//!
//! Given the distances `d` of the candidate contacts, with noise of covariance `S`, each active set
//! `A` has the likelihood
//!
//! `L_A = Π_{j∈A} κⱼ · N(d_A; 0, S_AA) · Π_{k∉A} Φ(d′ₖ / sₖ)`:
//!
//! active distances are zero but for noise, the others positive. `d′ₖ` is the distance of an
//! inactive candidate conditioned on the active ones, `sₖ` its standard deviation, `Φ` the normal
//! distribution, and `κⱼ` (m) the odds that the surface of candidate `j` is touched. A contact that
//! touches nothing has `η Πₖ Φ(dₖ / sₖ)`, an outlier `η`. The contact's likelihood `L` is the sum
//! over all active sets.
//!
//! The score `−∂ ln L/∂d` is zero on average at the true parameters; that of the least distance is
//! not, since the least of several noisy distances is biased towards zero.
//!
//! Source: mixtures as in Dempster, Laird & Rubin, *Maximum likelihood from incomplete data via the
//! EM algorithm* (1977); [`MarginalLikelihood::observed_information`] is, but for the gate,
//! equation 3.2 of Louis, *Finding the observed information matrix when using the EM algorithm*
//! (1982).

use nalgebra::SMatrix;

use super::active_set::{ActiveSet, LogOdds, LogSumExp};
use super::candidates::{CandidateContacts, CandidateMatrix, CandidateVector};
use super::soft_gate::gate_cost;
use crate::estimate::options::ContactModeOptions;
use crate::manifold::MAX_ROWS;

/// The likelihood of one contact with its derivatives by the candidates' distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MarginalLikelihood {
    /// Negative log-likelihood `−ln L` (1; `L` in units that cancel in differences).
    pub nll: f64,
    /// Derivative of `nll` by each candidate's distance (1/m).
    pub score: CandidateVector,
    /// Second derivative of `nll` by the distances if the active set were known (1/m²): positive
    /// semi-definite.
    pub complete_information: CandidateMatrix,
    /// Second derivative of `nll` by the distances (1/m²): the observed information of Louis
    /// (1982), but for the gate.
    pub observed_information: CandidateMatrix,
    /// Posterior probability that any candidate is active.
    pub in_contact: f64,
    /// Responsibilities: posterior probability that each candidate is active.
    pub active: CandidateVector,
    /// Posterior covariance of the indicators of active candidates: derivative of `active` by `ln
    /// κⱼ`. This and the next are zero unless derivatives by the odds are needed.
    pub active_covariance: CandidateMatrix,
    /// Derivative of the score by each `ln κⱼ`, a column each (1/m).
    pub score_by_odds: CandidateMatrix,
    /// Expected squared Mahalanobis distance `d_Aᵀ S_AA⁻¹ d_A` (1) of the active candidates.
    pub squared_distance: f64,
    /// Sum of the standard deviations of all candidates (m).
    pub sigma_sum: f64,
}

const _: () = assert!(MAX_ROWS == 6, "marginal_likelihood has an arm for each count");

/// The marginal likelihood of a contact.
pub(crate) fn marginal_likelihood(candidates: &CandidateContacts, options: &ContactModeOptions) -> MarginalLikelihood {
    match candidates.count {
        0 => of_count::<0>(candidates, options),
        1 => of_count::<1>(candidates, options),
        2 => of_count::<2>(candidates, options),
        3 => of_count::<3>(candidates, options),
        4 => of_count::<4>(candidates, options),
        5 => of_count::<5>(candidates, options),
        _ => of_count::<MAX_ROWS>(candidates, options),
    }
}

/// With `N` candidates, in matrices of that size.
fn of_count<const N: usize>(candidates: &CandidateContacts, options: &ContactModeOptions) -> MarginalLikelihood {
    let distances: CandidateVector<N> = CandidateVector::from_fn(|k, _| candidates.distances[k]);
    let covariance: CandidateMatrix<N> = CandidateMatrix::from_fn(|i, j| candidates.covariance[(i, j)]);
    let odds = CandidateVector::from_fn(|k, _| candidates.odds[k].ln());
    let logs = LogOdds { odds, no_contact: candidates.no_contact.ln(), options };
    let mut sum = LogSumExp::new(logs.no_contact, candidates.with_odds_derivatives);
    ActiveSet::empty(&distances, &covariance).visit(0, &logs, &mut sum);
    let score = sum.score / sum.total;
    let complete = sum.curvature / sum.total;
    let active = sum.active / sum.total;
    let mut likelihood = MarginalLikelihood {
        nll: -(sum.total.ln() + sum.offset),
        score: padded(&score),
        complete_information: padded(&complete),
        observed_information: padded(&(complete - sum.score_outer_product / sum.total + score * score.transpose())),
        in_contact: sum.in_contact / sum.total,
        active: padded(&active),
        active_covariance: padded(&(sum.active_outer_product / sum.total - active * active.transpose())),
        score_by_odds: padded(&(sum.score_by_active / sum.total - score * active.transpose())),
        squared_distance: sum.squared_distance / sum.total,
        sigma_sum: 0.0,
    };
    for k in 0..N {
        let sigma = covariance[(k, k)].sqrt();
        let gate = gate_cost(distances[k], sigma, options);
        likelihood.sigma_sum += sigma;
        likelihood.nll += gate.cost;
        likelihood.score[k] += gate.slope;
        likelihood.observed_information[(k, k)] += gate.curvature;
    }
    likelihood
}

/// With zeros behind.
fn padded<const N: usize, const C: usize, const P: usize>(matrix: &SMatrix<f64, N, C>) -> SMatrix<f64, MAX_ROWS, P> {
    SMatrix::from_fn(|i, j| if i < N && j < C { matrix[(i, j)] } else { 0.0 })
}

#[cfg(test)]
mod tests;

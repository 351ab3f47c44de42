//! Sets of active constraints, visited in depth-first order, and sums over them.

use super::candidates::{CandidateMatrix, CandidateVector};
use crate::estimate::options::ContactModeOptions;

/// Standard deviations above zero from which `Φ` is taken as 1, over the gate.
const CERTAINLY_FREE: f64 = 1.2;
/// Standard deviations below zero from which `Φ` is taken by its asymptotic expansion.
const FAR_TAIL: f64 = -20.0;

/// Logarithms of the odds `κⱼ` and `η`, and what bounds the visit.
pub(super) struct LogOdds<'o, const N: usize> {
    /// `ln κⱼ` of each candidate's surface, κ in m.
    pub odds: CandidateVector<N>,
    /// `ln η` of the odds (1) that nothing is touched.
    pub no_contact: f64,
    /// Bounds on active sets that are visited.
    pub options: &'o ContactModeOptions,
}

/// Sums over active sets `A`, each weighted by its likelihood `L_A` as `exp(ln L_A − offset)`.
pub(super) struct LogSumExp<const N: usize> {
    with_odds_derivatives: bool,
    /// Largest `ln L_A` so far.
    pub offset: f64,
    /// `Σ w`.
    pub total: f64,
    /// `Σ w s`, with the score `s = −∂ ln L_A/∂d`.
    pub score: CandidateVector<N>,
    /// `Σ w K`, with the curvature `K = −∂² ln L_A/∂d²`.
    pub curvature: CandidateMatrix<N>,
    /// `Σ w s sᵀ`.
    pub score_outer_product: CandidateMatrix<N>,
    /// `Σ w` over sets that are not empty.
    pub in_contact: f64,
    /// `Σ w a`, with the indicator `a` of active candidates.
    pub active: CandidateVector<N>,
    /// `Σ w a aᵀ`.
    pub active_outer_product: CandidateMatrix<N>,
    /// `Σ w s aᵀ`.
    pub score_by_active: CandidateMatrix<N>,
    /// `Σ w d_Aᵀ S_AA⁻¹ d_A`.
    pub squared_distance: f64,
}

impl<const N: usize> LogSumExp<N> {
    /// The sum over the outlier mode alone, of likelihood `exp(offset)` whatever the distances.
    pub fn new(offset: f64, with_odds_derivatives: bool) -> Self {
        let (vector, matrix) = (CandidateVector::zeros(), CandidateMatrix::zeros());
        LogSumExp {
            with_odds_derivatives,
            offset,
            total: 1.0,
            score: vector,
            curvature: matrix,
            score_outer_product: matrix,
            in_contact: 0.0,
            active: vector,
            active_outer_product: matrix,
            score_by_active: matrix,
            squared_distance: 0.0,
        }
    }

    /// Raises the offset to `log` if that is larger, rescaling the sums.
    fn rescale(&mut self, log: f64) {
        if log > self.offset {
            let factor = (self.offset - log).exp();
            self.offset = log;
            self.total *= factor;
            self.score *= factor;
            self.curvature *= factor;
            self.score_outer_product *= factor;
            self.in_contact *= factor;
            self.active *= factor;
            self.active_outer_product *= factor;
            self.score_by_active *= factor;
            self.squared_distance *= factor;
        }
    }
}

/// A set `A` of active candidates.
///
/// Candidates join one after the other. Each takes what it has in common with the inactive ones out
/// of these (a step of Gaussian elimination), so that the next is independent of it.
#[derive(Clone)]
pub(super) struct ActiveSet<const N: usize> {
    /// `ln (Πⱼ κⱼ · N(d_A; 0, S_AA))`.
    log: f64,
    /// `d_Aᵀ S_AA⁻¹ d_A`.
    squared_distance: f64,
    /// `S_AA⁻¹ d_A` and `S_AA⁻¹`, zero elsewhere.
    score: CandidateVector<N>,
    information: CandidateMatrix<N>,
    /// Conditional distances `d′` of the inactive candidates, their covariance, and `∂d′/∂d`.
    conditional: CandidateVector<N>,
    covariance: CandidateMatrix<N>,
    by_distance: CandidateMatrix<N>,
    is_active: [bool; N],
}

impl<const N: usize> ActiveSet<N> {
    /// The empty set, for distances `d` (m) with covariance `S` (m²).
    pub fn empty(distances: &CandidateVector<N>, covariance: &CandidateMatrix<N>) -> Self {
        ActiveSet {
            log: 0.0,
            squared_distance: 0.0,
            score: CandidateVector::zeros(),
            information: CandidateMatrix::zeros(),
            conditional: *distances,
            covariance: *covariance,
            by_distance: CandidateMatrix::identity(),
            is_active: [false; N],
        }
    }

    /// Adds this set to the sum, and all that contain more of the candidates from `next` on.
    pub fn visit(&self, next: usize, logs: &LogOdds<'_, N>, sum: &mut LogSumExp<N>) {
        self.add_to(logs, sum);
        for k in next..N {
            let (distance, variance) = (self.conditional[k], self.covariance[(k, k)]);
            if self.squared_distance + distance * distance / variance < logs.options.max_squared_distance {
                self.with(k, logs).visit(k + 1, logs, sum);
            }
        }
    }

    /// With candidate `k` active too.
    fn with(&self, k: usize, logs: &LogOdds<'_, N>) -> Self {
        let mut set = self.clone();
        let (distance, variance) = (self.conditional[k], self.covariance[(k, k)]);
        let row = self.by_distance.row(k).transpose();
        set.squared_distance += distance * distance / variance;
        set.log += logs.odds[k] - 0.5 * (distance * distance / variance + (std::f64::consts::TAU * variance).ln());
        set.score += row * (distance / variance);
        set.information += row * row.transpose() / variance;
        set.is_active[k] = true;
        for i in (0..N).filter(|&i| !self.is_active[i] && i != k) {
            let share = self.covariance[(i, k)] / variance;
            set.conditional[i] -= share * distance;
            for j in 0..N {
                set.covariance[(i, j)] -= share * self.covariance[(k, j)];
                set.by_distance[(i, j)] -= share * row[j];
            }
        }
        set
    }

    fn add_to(&self, logs: &LogOdds<'_, N>, sum: &mut LogSumExp<N>) {
        let is_empty = !self.is_active.contains(&true);
        let mut log = self.log + if is_empty { logs.no_contact } else { 0.0 };
        // Of each inactive candidate, the slope and curvature of ln Φ.
        let mut free = [(0.0, 0.0); N];
        for k in (0..N).filter(|&k| !self.is_active[k]) {
            let sigma = self.covariance[(k, k)].max(f64::MIN_POSITIVE).sqrt();
            let (log_free, slope) = log_normal_cdf(self.conditional[k] / sigma, CERTAINLY_FREE * logs.options.gate);
            log += log_free;
            let curvature = slope * (slope + self.conditional[k] / sigma);
            free[k] = (slope / sigma, curvature / (sigma * sigma));
        }
        sum.rescale(log);
        let weight = (log - sum.offset).exp();
        if weight < logs.options.min_share * sum.total {
            return;
        }
        let (mut score, mut curvature) = (self.score, self.information);
        for (k, (slope, bend)) in free.iter().enumerate().filter(|(_, (slope, _))| *slope != 0.0) {
            let row = self.by_distance.row(k).transpose();
            score -= row * *slope;
            curvature += row * row.transpose() * *bend;
        }
        sum.total += weight;
        sum.score += score * weight;
        sum.curvature += curvature * weight;
        sum.score_outer_product += score * score.transpose() * weight;
        sum.in_contact += if is_empty { 0.0 } else { weight };
        let active = CandidateVector::<N>::from_fn(|k, _| f64::from(u8::from(self.is_active[k])));
        sum.active += active * weight;
        if sum.with_odds_derivatives {
            sum.active_outer_product += active * active.transpose() * weight;
            sum.score_by_active += score * active.transpose() * weight;
        }
        sum.squared_distance += weight * self.squared_distance;
    }
}

/// `ln Φ(x)` and its derivative; exactly 0 beyond `certain`.
fn log_normal_cdf(x: f64, certain: f64) -> (f64, f64) {
    if x > certain {
        return (0.0, 0.0);
    }
    if x < FAR_TAIL {
        // Φ(x) ≈ φ(x)/(−x − 1/x) far below zero.
        let slope = -x - 1.0 / x;
        return (-0.5 * (x * x + std::f64::consts::TAU.ln()) - slope.ln(), slope);
    }
    let below = 0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2);
    (below.ln(), (-0.5 * x * x).exp() / (std::f64::consts::TAU.sqrt() * below))
}

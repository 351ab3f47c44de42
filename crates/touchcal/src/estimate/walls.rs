//! What the walls near one contact say, when it is not known which of them are touched.
//!
//! A peg in a hole rests against one wall or against several at once, and noise moves all their distances together. Given their distances `d` with noise of
//! covariance `S`, each set `A` of touched walls has a likelihood: those in `A` are at zero but for noise, the others somewhere above it,
//!
//! `L_A = Π_j κ_j · N(d_A; 0, S_AA) Π_k Φ(d′_k / s_k)`,
//!
//! with `d′_k` the distance of a free wall less what the noise of the touched ones makes one expect, `s_k` its standard deviation, and `Φ` the normal distribution. `κ_j` (m) is how
//! often the surface that wall `j` is of is touched over how often it is free within a metre: where a tool is held, it leans to one side. A contact that touches nothing has `η Π_k Φ(d_k / s_k)`, and
//! one that fits nowhere `η`. The contact's likelihood `L` is the sum. The slope of its logarithm is zero on average at the true parameters; that of the least distance
//! is not, since the least of several noisy distances is too small.
//!
//! Walls join a set one after the other. Each one takes what it has in common with the others out of them, so that the next is independent of it.
//!
//! Source: mixtures as in Dempster, Laird & Rubin (1977); [`Said::observed`] is, but for the way out of reach, equation 3.2 of Louis, *Finding the observed information matrix when using the
//! EM algorithm* (1982).

use nalgebra::{SMatrix, SVector};

use crate::manifold::MAX_ROWS;

pub(super) type Distances<const N: usize = MAX_ROWS> = SVector<f64, N>;
pub(super) type Square<const N: usize = MAX_ROWS> = SMatrix<f64, N, N>;

/// Standard deviations above zero from which a wall is free beyond doubt. Farther free walls must not count: how often one is free is to be known near zero, and
/// a tool does not come near all of a wall's surroundings equally often.
pub(super) const REACH: f64 = 4.0;
/// Standard deviations above zero from which walls begin to leave, see [`leave`].
const LEAVING: f64 = 2.0;
/// Least way (m) out of reach: where noise moves nothing, too.
const SHORTEST_WAY: f64 = 1e-12;
/// A set of walls whose squared whitened distances exceed this is not touched.
const IMPOSSIBLE: f64 = 60.0;
/// Start of `κ` (m) and of `η`.
const ANOTHER: f64 = 1e-4;
const NONE: f64 = 1e-4;
/// Share of the likelihood below which a set is left out.
const NEGLIGIBLE: f64 = 1e-9;

/// The walls near one contact, the first `count` of each.
pub(super) struct Near {
    /// `η`.
    pub none: f64,
    pub count: usize,
    /// How far away (m).
    pub distances: Distances,
    /// Covariance of their noise (m²).
    pub covariance: Square,
    /// How often each one's surface is touched, `κ_j` (m).
    pub another: Distances,
    /// Whether derivatives by `ln κ_j` are wanted, which a search can do without.
    pub by_odds: bool,
}

/// How often the walls of one region are touched.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Odds {
    /// `κ_j` (m) of each surface.
    pub another: Vec<f64>,
    /// `η`.
    pub none: f64,
    /// Share of each surface's walls in reach that are touched.
    pub share: Vec<f64>,
}

impl Odds {
    /// Before anything is known, with so many surfaces.
    pub fn start(surfaces: usize) -> Odds {
        Odds { another: vec![ANOTHER; surfaces], none: NONE, share: vec![0.5; surfaces] }
    }
}

/// What one contact says of its walls. Derivatives are by the distances.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said {
    /// `−ln L`.
    pub cost: f64,
    /// Its derivative.
    pub slope: Distances,
    /// What its second derivative would be if it were known which walls are touched: positive semi-definite.
    pub complete: Square,
    /// Its second derivative.
    pub observed: Square,
    /// Probability that a wall is touched.
    pub touching: f64,
    /// Probability that each wall is touched.
    pub touched: Distances,
    /// Its derivative by each `ln κ_j`: the covariance of which walls are touched. This and the next only if they were wanted.
    pub touched_together: Square,
    /// The slope's derivative by each `ln κ_j`, a column each.
    pub slope_by_odds: Square,
    /// Expected `d_Aᵀ S_AA⁻¹ d_A`.
    pub squares: f64,
    /// Sum of the standard deviations (m) of all walls.
    pub deviations: f64,
}

const _: () = assert!(MAX_ROWS == 6, "weigh has an arm for each count");

/// What they say.
pub(super) fn weigh(near: &Near) -> Said {
    match near.count {
        0 => weigh_each::<0>(near),
        1 => weigh_each::<1>(near),
        2 => weigh_each::<2>(near),
        3 => weigh_each::<3>(near),
        4 => weigh_each::<4>(near),
        5 => weigh_each::<5>(near),
        _ => weigh_each::<MAX_ROWS>(near),
    }
}

/// What `N` walls say, without the room for more.
fn weigh_each<const N: usize>(near: &Near) -> Said {
    let distances: Distances<N> = Distances::from_fn(|k, _| near.distances[k]);
    let covariance: Square<N> = Square::from_fn(|i, j| near.covariance[(i, j)]);
    let logs = Logs { another: Distances::from_fn(|k, _| near.another[k].ln()), none: near.none.ln() };
    let mut sum = Sum::new(logs.none, near.by_odds);
    Set::empty(&distances, &covariance).visit(0, &logs, &mut sum);
    let slope = sum.slope / sum.total;
    let complete = sum.complete / sum.total;
    let touched = sum.touched / sum.total;
    let mut said = Said {
        cost: -(sum.total.ln() + sum.most),
        slope: padded(&slope),
        complete: padded(&complete),
        observed: padded(&(complete - sum.squares_of_slope / sum.total + slope * slope.transpose())),
        touching: sum.touching / sum.total,
        touched: padded(&touched),
        touched_together: padded(&(sum.together / sum.total - touched * touched.transpose())),
        slope_by_odds: padded(&(sum.slope_of_touched / sum.total - slope * touched.transpose())),
        squares: sum.squares / sum.total,
        deviations: 0.0,
    };
    for k in 0..N {
        let deviation = covariance[(k, k)].sqrt();
        let (cost, slope, curvature) = leave(distances[k], deviation);
        said.deviations += deviation;
        said.cost += cost;
        said.slope[k] += slope;
        said.observed[(k, k)] += curvature;
    }
    said
}

/// With zeros behind.
fn padded<const N: usize, const C: usize, const P: usize>(matrix: &SMatrix<f64, N, C>) -> SMatrix<f64, MAX_ROWS, P> {
    SMatrix::from_fn(|i, j| if i < N && j < C { matrix[(i, j)] } else { 0.0 })
}

/// What a wall adds to the cost on its way out of reach, and its derivatives. Free walls push away from zero, where as many of them begin as end somewhere out of reach: evenly spread
/// ones must on average push back as much on their way out. Smoothly, since touched walls come that far too, and their slope's derivative counts.
fn leave(distance: f64, deviation: f64) -> (f64, f64, f64) {
    let way = ((REACH - LEAVING) * deviation).max(SHORTEST_WAY);
    let left = ((distance - LEAVING * deviation) / way).clamp(0.0, 1.0);
    let within = f64::from(u8::from(left > 0.0 && left < 1.0));
    let cost = left * left * (3.0 - 2.0 * left) - 1.0;
    (cost, 6.0 * left * (1.0 - left) / way, within * 6.0 * (1.0 - 2.0 * left) / (way * way))
}

/// Sums over sets, of which each counts `exp(ln L_A − most)`.
struct Sum<const N: usize> {
    by_odds: bool,
    most: f64,
    total: f64,
    slope: Distances<N>,
    complete: Square<N>,
    squares_of_slope: Square<N>,
    touching: f64,
    touched: Distances<N>,
    together: Square<N>,
    slope_of_touched: Square<N>,
    squares: f64,
}

/// Logarithms of `κ_j` and `η`.
struct Logs<const N: usize> {
    another: Distances<N>,
    none: f64,
}

impl<const N: usize> Sum<N> {
    /// Of one that fits nowhere.
    fn new(most: f64, by_odds: bool) -> Self {
        let (vector, square) = (Distances::zeros(), Square::zeros());
        Sum {
            by_odds,
            most,
            total: 1.0,
            slope: vector,
            complete: square,
            squares_of_slope: square,
            touching: 0.0,
            touched: vector,
            together: square,
            slope_of_touched: square,
            squares: 0.0,
        }
    }

    fn rise_to(&mut self, log: f64) {
        if log > self.most {
            let shrunk = (self.most - log).exp();
            self.most = log;
            self.total *= shrunk;
            self.slope *= shrunk;
            self.complete *= shrunk;
            self.squares_of_slope *= shrunk;
            self.touching *= shrunk;
            self.touched *= shrunk;
            self.together *= shrunk;
            self.slope_of_touched *= shrunk;
            self.squares *= shrunk;
        }
    }
}

/// A set of touched walls.
#[derive(Clone)]
struct Set<const N: usize> {
    /// `ln (Π_j κ_j · N(d_A; 0, S_AA))`.
    log: f64,
    /// `d_Aᵀ S_AA⁻¹ d_A`.
    squares: f64,
    /// `S_AA⁻¹ d_A` and `S_AA⁻¹`, zero elsewhere.
    slope: Distances<N>,
    information: Square<N>,
    /// `d′`, its covariance, and its derivative by the distances.
    left: Distances<N>,
    covariance: Square<N>,
    from_distances: Square<N>,
    is_touched: [bool; N],
}

impl<const N: usize> Set<N> {
    fn empty(distances: &Distances<N>, covariance: &Square<N>) -> Self {
        Set {
            log: 0.0,
            squares: 0.0,
            slope: Distances::zeros(),
            information: Square::zeros(),
            left: *distances,
            covariance: *covariance,
            from_distances: Square::identity(),
            is_touched: [false; N],
        }
    }

    /// Adds this set to the sum, and all that have more of the walls from `next` on.
    fn visit(&self, next: usize, logs: &Logs<N>, sum: &mut Sum<N>) {
        self.add(logs, sum);
        for k in next..N {
            let (left, variance) = (self.left[k], self.covariance[(k, k)]);
            if self.squares + left * left / variance < IMPOSSIBLE {
                self.with(k, logs).visit(k + 1, logs, sum);
            }
        }
    }

    /// With wall `k` touched too.
    fn with(&self, k: usize, logs: &Logs<N>) -> Self {
        let mut set = self.clone();
        let (left, variance) = (self.left[k], self.covariance[(k, k)]);
        let row = self.from_distances.row(k).transpose();
        set.squares += left * left / variance;
        set.log += logs.another[k] - 0.5 * (left * left / variance + (std::f64::consts::TAU * variance).ln());
        set.slope += row * (left / variance);
        set.information += row * row.transpose() / variance;
        set.is_touched[k] = true;
        for i in (0..N).filter(|&i| !self.is_touched[i] && i != k) {
            let share = self.covariance[(i, k)] / variance;
            set.left[i] -= share * left;
            for j in 0..N {
                set.covariance[(i, j)] -= share * self.covariance[(k, j)];
                set.from_distances[(i, j)] -= share * row[j];
            }
        }
        set
    }

    fn add(&self, logs: &Logs<N>, sum: &mut Sum<N>) {
        let is_empty = !self.is_touched.contains(&true);
        let mut log = self.log + if is_empty { logs.none } else { 0.0 };
        let mut free = [(0.0, 0.0); N];
        for k in (0..N).filter(|&k| !self.is_touched[k]) {
            let deviation = self.covariance[(k, k)].max(f64::MIN_POSITIVE).sqrt();
            let (log_of_free, slope) = log_normal_distribution(self.left[k] / deviation);
            log += log_of_free;
            let curvature = slope * (slope + self.left[k] / deviation);
            free[k] = (slope / deviation, curvature / (deviation * deviation));
        }
        sum.rise_to(log);
        let share = (log - sum.most).exp();
        if share < NEGLIGIBLE * sum.total {
            return;
        }
        let (mut slope, mut information) = (self.slope, self.information);
        for (k, (push, curvature)) in free.iter().enumerate().filter(|(_, (push, _))| *push != 0.0) {
            let row = self.from_distances.row(k).transpose();
            slope -= row * *push;
            information += row * row.transpose() * *curvature;
        }
        sum.total += share;
        sum.slope += slope * share;
        sum.complete += information * share;
        sum.squares_of_slope += slope * slope.transpose() * share;
        sum.touching += if is_empty { 0.0 } else { share };
        let touched = Distances::<N>::from_fn(|k, _| f64::from(u8::from(self.is_touched[k])));
        sum.touched += touched * share;
        if sum.by_odds {
            sum.together += touched * touched.transpose() * share;
            sum.slope_of_touched += slope * touched.transpose() * share;
        }
        sum.squares += share * self.squares;
    }
}

/// `ln Φ(x)` and its derivative; exactly 0 where a wall is free beyond doubt.
fn log_normal_distribution(x: f64) -> (f64, f64) {
    if x > 1.2 * REACH {
        return (0.0, 0.0);
    }
    if x < -20.0 {
        // Φ(x) ≈ φ(x)/(−x − 1/x) far below zero.
        let slope = -x - 1.0 / x;
        return (-0.5 * (x * x + std::f64::consts::TAU.ln()) - slope.ln(), slope);
    }
    let below = 0.5 * libm::erfc(-x * std::f64::consts::FRAC_1_SQRT_2);
    (below.ln(), (-0.5 * x * x).exp() / (std::f64::consts::TAU.sqrt() * below))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    const ANOTHER: f64 = 2e-4;
    const MICRON: f64 = 1e-6;

    /// Three walls, the first two pushing against each other, so that their noise is more or less opposite.
    fn covariance(opposite: f64) -> Square {
        let mut covariance = Square::zeros();
        let entries = [(0, 0, 700.0), (1, 1, 750.0), (2, 2, 500.0), (0, 1, -opposite), (0, 2, 80.0), (1, 2, -30.0)];
        for (a, b, entry) in entries {
            covariance[(a, b)] = entry * MICRON * MICRON;
            covariance[(b, a)] = covariance[(a, b)];
        }
        covariance
    }

    fn distances(each: [f64; 3]) -> Distances {
        let mut distances = Distances::zeros();
        each.iter().enumerate().for_each(|(k, distance)| distances[k] = distance * MICRON);
        distances
    }

    /// Walls of surfaces that are touched equally often.
    fn near(distances: Distances, covariance: Square, count: usize, none: f64) -> Near {
        Near { none, count, distances, covariance, another: Distances::repeat(ANOTHER), by_odds: true }
    }

    #[test]
    fn derivatives_are_those_of_the_cost() {
        let (covariance, h) = (covariance(650.0), 1e-3 * MICRON);
        for each in
            [[3.0, 5.0, -4.0], [40.0, -30.0, 80.0], [-20.0, 35.0, 10.0], [60.0, 70.0, 90.0], [-150.0, 20.0, 0.0]]
        {
            let at = |d: &Distances| weigh(&near(*d, covariance, 3, 1e-3));
            let d = distances(each);
            let said = at(&d);
            for k in 0..3 {
                let mut step = Distances::zeros();
                step[k] = h;
                let (after, before) = (at(&(d + step)), at(&(d - step)));
                let slope = (after.cost - before.cost) / (2.0 * h);
                assert!((slope - said.slope[k]).abs() < 1e-4 / MICRON, "{each:?}: {slope:e} {:e}", said.slope[k]);
                let curvature = (after.slope - before.slope) / (2.0 * h);
                let off = (curvature - said.observed.column(k)).amax();
                assert!(off < 1e-4 * said.complete.amax().max(1.0 / (30.0 * MICRON).powi(2)), "{each:?}: {off:e}");
            }
        }
    }

    #[test]
    fn derivatives_by_odds_are_those_of_cost_and_slope() {
        const H: f64 = 1e-5;
        for each in [[3.0, 5.0, -4.0], [40.0, -30.0, 80.0], [-20.0, 35.0, 10.0], [60.0, 70.0, 90.0]] {
            let at = |k: usize, step: f64| {
                let mut near = near(distances(each), covariance(650.0), 3, 1e-3);
                near.another[k] *= step.exp();
                weigh(&near)
            };
            let said = at(0, 0.0);
            for k in 0..3 {
                let (after, before) = (at(k, H), at(k, -H));
                assert!(((before.cost - after.cost) / (2.0 * H) - said.touched[k]).abs() < 1e-8, "{each:?}");
                let touched = (after.touched - before.touched) / (2.0 * H);
                assert!((touched - said.touched_together.column(k)).amax() < 1e-8, "{each:?}");
                let slope = (after.slope - before.slope) / (2.0 * H);
                let off = (slope - said.slope_by_odds.column(k)).amax();
                assert!(off < 1e-6 * said.slope.amax(), "{each:?}: {off:e} of {:e}", said.slope.amax());
            }
        }
    }

    #[test]
    fn one_wall_touched_for_sure_is_least_squares() {
        let variance = (28.0 * MICRON).powi(2);
        let one = near(distances([20.0, 0.0, 0.0]), Square::identity() * variance, 1, 1e-13);
        let said = weigh(&one);
        assert!((said.slope[0] * variance / (20.0 * MICRON) - 1.0).abs() < 1e-6);
        assert!((said.complete[(0, 0)] * variance - 1.0).abs() < 1e-6);
        assert!((said.touched[0] - 1.0).abs() < 1e-6 && (said.touching - 1.0).abs() < 1e-6);
    }

    /// Walls drawn as the model has them: touched or free, free ones evenly spread, with noise. The least distance is off by several of its standard errors.
    #[test]
    fn the_slope_is_zero_on_average_where_the_least_distance_is_not() {
        const CONTACTS: usize = 40_000;
        let band = 400.0 * MICRON;
        let touched_share = ANOTHER / (ANOTHER + band);
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
            let said = weigh(&near(distances(each.map(|d| d / MICRON)), covariance, 3, 1e-7));
            for k in 0..3 {
                sum[k] += said.slope[k];
                squares[k] += said.slope[k].powi(2);
            }
            least += each.iter().copied().fold(f64::INFINITY, f64::min) / CONTACTS as f64;
        }
        for k in 0..3 {
            let standard_error = squares[k].sqrt();
            assert!(sum[k].abs() < 3.5 * standard_error, "{k}: {} standard errors", sum[k] / standard_error);
        }
        assert!(least < -20.0 * 27.0 * MICRON / (CONTACTS as f64).sqrt(), "{least:e}");
    }
}

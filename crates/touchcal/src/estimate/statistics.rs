//! What all contacts together say of their walls: how well that fixes the parameters, how often walls are touched, how noisy they are, and how much
//! they differ.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::knowledge::covariance;
use super::normal::{NormalEquations, scaled};
use super::system::System;
use super::walls::{Odds, REACH};
use crate::robot::Column;

/// Walls that the declared noise counts as much as.
const NOISE_STRENGTH: f64 = 100.0;
/// Start of the standard deviation (m) of how much walls of one fixture differ in how far they are penetrated. It counts for little: good parts must come out as good.
pub(super) const WALL_SIGMA: f64 = 1e-6;
const WALL_STRENGTH: f64 = 0.01;
/// Steps towards that standard deviation from one look at the contacts.
const WIDTH_STEPS: usize = 20;
/// About so many contacts say how often walls are touched.
const ENOUGH: usize = 1000;
/// Share of the contacts that must tell which walls they touch.
const TELLING: f64 = 0.3;
/// Directions of which contacts say less than this share of what they say of the best are not seen.
const SEEN: f64 = 1e-10;
/// Standard deviations within which a design effect may be chance.
const BY_CHANCE: f64 = 2.6;

/// Sums over the contacts, at one set of parameters.
#[derive(Clone, Debug)]
pub(crate) struct Statistics {
    /// Second derivative of `−ln L`.
    pub observed: NormalEquations,
    /// `Σ s sᵀ` of each contact's slope `s`: the covariance of their sum.
    pub squares_of_slope: NormalEquations,
    /// `Σ s sᵀ` of the sums `s` over blocks of contacts that follow each other, and the number of blocks.
    squares_of_blocks: DMatrix<f64>,
    blocks: f64,
    /// Contacts that touch a wall, and walls that are touched.
    pub touching: f64,
    pub touched: f64,
    /// Squared whitened distances of those walls.
    pub squares: f64,
    /// Walls in reach, touched or free, and the sum of their standard deviations (m).
    pub walls: f64,
    pub deviations: f64,
    /// Contacts with walls in reach of which none is touched.
    pub not_touching: f64,
}

impl Statistics {
    fn new(size: usize) -> Self {
        Statistics {
            observed: NormalEquations::new(size),
            squares_of_slope: NormalEquations::new(size),
            squares_of_blocks: DMatrix::zeros(size, size),
            blocks: 0.0,
            touching: 0.0,
            touched: 0.0,
            squares: 0.0,
            walls: 0.0,
            deviations: 0.0,
            not_touching: 0.0,
        }
    }

    fn add(&mut self, other: &Statistics) {
        self.observed.add(&other.observed);
        self.squares_of_slope.add(&other.squares_of_slope);
        let slope = &other.squares_of_slope.gradient;
        self.squares_of_blocks.ger(1.0, slope, slope, 1.0);
        self.blocks += 1.0;
        self.touching += other.touching;
        self.touched += other.touched;
        self.squares += other.squares;
        self.walls += other.walls;
        self.deviations += other.deviations;
        self.not_touching += other.not_touching;
    }

    fn scale(&mut self, factor: f64) {
        self.observed.scale(factor);
        self.squares_of_slope.scale(factor);
        self.squares_of_blocks *= factor;
        self.touching *= factor;
        self.touched *= factor;
        self.squares *= factor;
        self.walls *= factor;
        self.deviations *= factor;
        self.not_touching *= factor;
    }

    /// How often walls are touched and how noisy they are, from what was expected `before`: a step of expectation–maximisation, of which the first number is taken
    /// twice as far, since it creeps.
    fn odds(&self, before: Odds, parameters: usize) -> Odds {
        let band = REACH * before.noise * self.deviations / self.walls.max(1.0);
        let free = (self.walls - self.touched).max(1.0);
        let another = (self.touched - self.touching).max(1.0) * band / free;
        let none = self.not_touching.max(1.0) / (self.touching.max(1.0) * band.max(f64::MIN_POSITIVE));
        let freedom = (self.touched - parameters as f64).max(0.0) + NOISE_STRENGTH;
        let squares = self.squares + NOISE_STRENGTH / before.noise.powi(2);
        Odds { another: another.powi(2) / before.another, none, noise: before.noise * (squares / freedom).sqrt() }
    }

    /// The covariance of parameters found at the minimum: `D (H + Λ)⁻¹ (B + Λ) (H + Λ)⁻¹`, with `H` the second derivative, `B` the covariance of its slope, `Λ` of what is
    /// `known` besides, and `D` the [design effect](Statistics::design_effect). None where the cost does not curve up in all directions, as it does at a minimum that enough contacts say.
    ///
    /// Source: Huber, *The behavior of maximum likelihood estimates under nonstandard conditions* (1967), theorem 3.
    pub fn covariance(&self, known: &DMatrix<f64>, scale: &DVector<f64>) -> Option<DMatrix<f64>> {
        let curvature = &self.observed.information + known;
        let held = DMatrix::from_diagonal(&scale.map(|scale| f64::from(u8::from(scale == 0.0))));
        Cholesky::new(scaled(&curvature, scale) + held)?;
        let bread = covariance(&curvature, scale);
        Some(&bread * (&self.squares_of_slope.information + known) * &bread * self.design_effect(scale))
    }

    /// How many contacts say as much as one that is independent of the others: the variance of slopes summed over blocks of contacts that follow each other, over what it would be if
    /// each had noise of its own; the mean over all directions, or 1 if that may be chance. Parts that give way or are not of their shape
    /// err in the same way for many contacts.
    ///
    /// Source: Kish, *Survey sampling* (1965), section 5.4; for estimates Liang & Zeger (1986).
    fn design_effect(&self, scale: &DVector<f64>) -> f64 {
        let blocks = scaled(&self.squares_of_blocks, scale);
        let each = self.squares_of_slope.scaled_information(scale).symmetric_eigen();
        let least = SEEN * each.eigenvalues.max();
        let seen = each.eigenvalues.iter().zip(each.eigenvectors.column_iter()).filter(|(value, _)| **value > least);
        let (mut sum, mut directions) = (0.0, 0.0);
        for (value, direction) in seen {
            sum += direction.dot(&(&blocks * direction)) / value;
            directions += 1.0;
        }
        let effect = sum / f64::max(directions, 1.0);
        // Of each direction, a χ² of as many degrees of freedom as there are blocks.
        let chance = BY_CHANCE * (2.0 / (self.blocks * f64::max(directions, 1.0)).max(1.0)).sqrt();
        if effect > 1.0 + chance { effect } else { 1.0 }
    }
}

impl System<'_> {
    /// Whether any contact is one-sided, so that it has walls.
    pub fn has_walls(&self) -> bool {
        let one_sided = self.problem.fixtures.iter().any(|fixture| fixture.manifold.has_interference());
        one_sided && self.problem.noise.encoder > 0.0 && !self.problem.contacts.is_empty()
    }

    /// What every `stride`-th contact says at `theta`, weighted to stand for all.
    pub fn wall_statistics(&self, theta: &DVector<f64>, stride: usize) -> Statistics {
        let at = self.at(theta);
        let size = self.parameters.len();
        let room = || (at.rows(), Statistics::new(size));
        let (_, rooms) = self.sum(stride, room, |batch, (rows, statistics), _| {
            batch.iter().for_each(|&i| at.add_to(statistics, i, rows));
        });
        let mut total = Statistics::new(size);
        rooms.iter().for_each(|(_, statistics)| total.add(statistics));
        total.scale(stride as f64);
        Statistics { observed: total.observed.complete(), squares_of_slope: total.squares_of_slope.complete(), ..total }
    }

    /// Every so many contacts are enough to learn how often walls are touched.
    pub fn wall_stride(&self) -> usize {
        (self.problem.contacts.len() / ENOUGH).max(1)
    }

    /// Whether enough contacts tell which walls there are.
    pub fn tells_walls(&self, theta: &DVector<f64>) -> bool {
        self.wall_statistics(theta, self.wall_stride()).touching > TELLING * self.problem.contacts.len() as f64
    }

    /// Learns how often walls are touched, how noisy they are and how much they differ; the largest relative change. Some contacts are enough for that.
    pub fn learn_walls(&mut self, theta: &DVector<f64>, scale: &DVector<f64>) -> f64 {
        let found = self.wall_statistics(theta, self.wall_stride());
        let before = self.odds;
        self.odds = found.odds(before, self.parameters.len());
        let change = |after: f64, before: f64| (after / before).ln().abs();
        let of_odds = change(self.odds.another, before.another).max(change(self.odds.none, before.none));
        let mut most = of_odds.max(change(self.odds.noise, before.noise));
        let data = &found.observed.information + self.distance_information(theta);
        for f in 0..self.problem.fixtures.len() {
            let of_fixture = |column: Column| matches!(column, Column::Wall(of, _) if of == f);
            let walls: Vec<usize> =
                (0..self.parameters.len()).filter(|&k| of_fixture(self.parameters[k].column)).collect();
            for _ in 0..if walls.is_empty() { 0 } else { WIDTH_STEPS } {
                let covariance = covariance(&(&data + self.prior_information()), scale);
                let squares: f64 = walls.iter().map(|&k| theta[k].powi(2) + covariance[(k, k)].max(0.0)).sum();
                let count = walls.len() as f64 + WALL_STRENGTH;
                let sigma = ((squares + WALL_STRENGTH * WALL_SIGMA.powi(2)) / count).sqrt();
                for &k in &walls {
                    let before = self.parameters[k].prior_sigma.replace(sigma);
                    most = most.max(before.map_or(0.0, |before| change(sigma, before)));
                }
            }
        }
        most
    }
}

//! What all contacts together say of their walls: how well that fixes the parameters, how often walls are touched, how noisy they are, and how much
//! they differ.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::knowledge::covariance;
use super::normal::{NormalEquations, scaled};
use super::rows::Rung;
use super::system::System;
use super::walls::{Odds, REACH};
use crate::robot::Column;

/// Touched walls of a surface that how often all are touched counts as much as.
const SURFACE_STRENGTH: f64 = 5.0;
/// Steps towards how often surfaces are touched.
const TALLY_STEPS: usize = 20;
/// Bounds of `κ` (m).
const LEAST_ODDS: f64 = 1e-8;
const MOST_ODDS: f64 = 1.0;
/// No surface is touched more often than this.
const MOST_TOUCHED: f64 = 0.99;
/// Walls that the declared noise counts as much as.
const NOISE_STRENGTH: f64 = 100.0;
/// Start of the standard deviation (m) of how much walls of one fixture differ in how far they are penetrated. It counts for little: good parts must come out as good.
pub(super) const WALL_SIGMA: f64 = 1e-6;
const WALL_STRENGTH: f64 = 0.01;
/// Steps towards that standard deviation from one look at the contacts.
const WIDTH_STEPS: usize = 20;
/// Newton decrement of steps that may be taken without a look at where they lead: a standard deviation.
pub(super) const SHORT: f64 = 1.0;
/// Directions of which contacts say less than this share of what they say of the best are not seen.
const SEEN: f64 = 1e-10;

/// Sums over the contacts, at one set of parameters. Where the covariance is wanted, the `ln κ_j` of all surfaces are columns too, behind these.
#[derive(Clone, Debug)]
pub(crate) struct Statistics {
    /// Derivatives of `−ln L`. The second is what it would be if it were known which walls are touched, as a search wants it, or the true one with `ln κ_j` for the covariance. The first is the parameters' part only.
    pub derivatives: NormalEquations,
    /// `Σ s sᵀ` of each contact's slope `s`: the covariance of their sum. Empty in a search.
    pub squares_of_slope: NormalEquations,
    /// Sums of slopes over blocks of contacts that follow each other.
    slopes_of_blocks: Vec<DVector<f64>>,
    /// Squared whitened distances of walls that are touched.
    pub squares: f64,
    /// Sum of the standard deviations (m) of all walls in reach.
    pub deviations: f64,
    /// Of each fixture and region of it.
    pub tallies: Vec<Vec<Tally>>,
}

/// How often walls of one region are touched.
#[derive(Clone, Debug)]
pub(crate) struct Tally {
    /// Contacts that touch a wall, and contacts with walls in reach that touch none.
    pub touching: f64,
    pub not_touching: f64,
    /// Of each surface, walls in reach, and those that are touched.
    pub walls: Vec<f64>,
    pub touched: Vec<f64>,
}

impl Tally {
    fn new(surfaces: usize) -> Tally {
        Tally { touching: 0.0, not_touching: 0.0, walls: vec![0.0; surfaces], touched: vec![0.0; surfaces] }
    }

    fn each(&mut self) -> impl Iterator<Item = &mut f64> {
        [&mut self.touching, &mut self.not_touching].into_iter().chain(&mut self.walls).chain(&mut self.touched)
    }

    /// Walls of a surface that are taken to be touched, and to be free, before any is seen: as many as of all surfaces.
    fn before(&self) -> (f64, f64) {
        let (walls, touched): (f64, f64) = (self.walls.iter().sum(), self.touched.iter().sum());
        (SURFACE_STRENGTH, SURFACE_STRENGTH * (walls - touched).max(1.0) / touched.max(1.0))
    }

    /// How often each surface is touched, and how often nothing is: walls in reach are within `band` (m) on average, and for each contact that touches there are `none` that do not. That is up to
    /// what was taken for a contact, and the same in all regions: a region of its own with few contacts, or walls that are not quite what they are taken for, would lose itself to touching nothing.
    ///
    /// With walls touched independently of each other, each with probability `q`, contacts are what touches at least one, a share `z` of all poses. A free wall is seen only
    /// where another is touched, or nothing is.
    fn odds(&self, band: f64, none: f64) -> Odds {
        if self.touching < 1.0 {
            return Odds::start(self.walls.len());
        }
        let contacts = self.touching;
        let (mut q, mut z) = (Vec::new(), 1.0);
        for _ in 0..TALLY_STEPS {
            q = self.touched.iter().map(|touched| (z * touched / contacts).min(MOST_TOUCHED)).collect();
            z = 1.0 - q.iter().map(|q: &f64| 1.0 - q).product::<f64>();
        }
        let (more, free) = self.before();
        let each = |((walls, touched), q): ((&f64, &f64), &f64)| {
            let seen = 1.0 - (1.0 - z) / (1.0 - q) + z * none;
            (seen * band * (touched + more) / ((walls - touched).max(0.0) + free)).clamp(LEAST_ODDS, MOST_ODDS)
        };
        let another = self.walls.iter().zip(&self.touched).zip(&q).map(each).collect();
        let share = |(walls, touched): (&f64, &f64)| (touched + more) / (walls.max(*touched) + more + free);
        let share = self.walls.iter().zip(&self.touched).map(share).collect();
        Odds { another, none: none * z / (1.0 - z), share }
    }

    /// What walls tell of each surface's `ln κ_j` if it is known which are touched, and what was known before.
    fn told(&self, odds: &Odds) -> impl Iterator<Item = (f64, f64)> {
        let (more, free) = self.before();
        self.walls.iter().zip(&odds.share).map(move |(walls, share)| {
            let each = share * (1.0 - share);
            (each * walls, each * (more + free))
        })
    }

    /// [`odds`](Tally::odds) from what was expected `before`, taken twice as far, since steps of expectation–maximisation creep; but not where no wall was seen.
    fn odds_after(&self, before: &Odds, band: f64, none: f64) -> Odds {
        let mut odds = self.odds(band, none);
        for ((found, before), walls) in odds.another.iter_mut().zip(&before.another).zip(&self.walls) {
            if *walls > 0.0 {
                *found = (*found * *found / before).clamp(LEAST_ODDS, MOST_ODDS);
            }
        }
        odds
    }
}

/// A step of learning how often walls are touched.
pub(crate) struct Learned {
    /// Share of the one-sided contacts that tell which walls they touch.
    pub telling: f64,
    /// The relative change of that.
    pub change: f64,
    /// The cost where it was learned.
    pub cost: f64,
    /// The parameters' own step towards what contacts say, if it is short.
    pub step: Option<DVector<f64>>,
}

impl Statistics {
    fn new(parameters: usize, odds: &[Vec<Odds>], for_covariance: bool) -> Self {
        let none = |odds: &Odds| Tally::new(odds.another.len());
        let surfaces = || odds.iter().flatten().map(|odds| odds.another.len()).sum::<usize>();
        let size = parameters + if for_covariance { surfaces() } else { 0 };
        let size_of_squares = if for_covariance { size } else { 0 };
        Statistics {
            derivatives: NormalEquations::new(size),
            squares_of_slope: NormalEquations::new(size_of_squares),
            slopes_of_blocks: Vec::new(),
            squares: 0.0,
            deviations: 0.0,
            tallies: odds.iter().map(|regions| regions.iter().map(none).collect()).collect(),
        }
    }

    fn add(&mut self, other: &Statistics) {
        self.derivatives.add(&other.derivatives);
        self.squares_of_slope.add(&other.squares_of_slope);
        self.slopes_of_blocks.push(other.squares_of_slope.gradient.clone());
        self.squares += other.squares;
        self.deviations += other.deviations;
        for (tally, more) in self.tallies.iter_mut().flatten().zip(other.tallies.iter().flatten()) {
            tally.each().zip(more.clone().each()).for_each(|(sum, more)| *sum += *more);
        }
    }

    fn scale(&mut self, factor: f64) {
        self.derivatives.scale(factor);
        self.squares_of_slope.scale(factor);
        self.slopes_of_blocks.iter_mut().for_each(|slope| *slope *= factor.sqrt());
        self.squares *= factor;
        self.deviations *= factor;
        self.tallies.iter_mut().flatten().flat_map(Tally::each).for_each(|count| *count *= factor);
    }

    /// Share of the one-sided contacts that tell which walls they touch.
    pub fn telling(&self, system: &System<'_>) -> f64 {
        let contacts = &system.problem.contacts;
        let is_one_sided = |i: &usize| system.problem.fixtures[contacts.fixture(*i)].manifold.has_interference();
        let one_sided = (0..contacts.len()).filter(is_one_sided).count();
        let touching: f64 = self.tallies.iter().flatten().map(|tally| tally.touching).sum();
        touching / one_sided.max(1) as f64
    }

    /// How often walls are touched, from what was expected `before`.
    fn odds(&self, before: &[Vec<Odds>]) -> Vec<Vec<Odds>> {
        let walls: f64 = self.tallies.iter().flatten().flat_map(|tally| &tally.walls).sum();
        let band = (REACH * self.deviations / walls.max(1.0)).max(f64::MIN_POSITIVE);
        let of_fixture = |(tallies, before): (&Vec<Tally>, &Vec<Odds>)| {
            let sum = |each: fn(&Tally) -> f64| tallies.iter().map(each).sum::<f64>();
            let none = sum(|tally| tally.not_touching).max(1.0) / sum(|tally| tally.touching).max(1.0);
            tallies.iter().zip(before).map(|(tally, before)| tally.odds_after(before, band, none)).collect()
        };
        self.tallies.iter().zip(before).map(of_fixture).collect()
    }

    /// How noisy walls are, from what was expected `before`: a step of expectation–maximisation.
    fn noise(&self, before: f64, parameters: usize) -> f64 {
        let touched: f64 = self.tallies.iter().flatten().flat_map(|tally| &tally.touched).sum();
        let freedom = (touched - parameters as f64).max(0.0) + NOISE_STRENGTH;
        before * ((self.squares + NOISE_STRENGTH / before.powi(2)) / freedom).sqrt()
    }

    /// Mean relative change of how often walls are touched.
    fn change(&self, before: &[Vec<Odds>], after: &[Vec<Odds>]) -> f64 {
        let (mut sum, mut count) = (0.0, 1.0);
        let odds = before.iter().flatten().zip(after.iter().flatten());
        for (tally, (before, after)) in self.tallies.iter().flatten().zip(odds) {
            for (touched, (before, after)) in tally.touched.iter().zip(before.another.iter().zip(&after.another)) {
                sum += touched * (after / before).ln().abs();
                count += touched;
            }
        }
        sum / count
    }

    /// The covariance of parameters found at the minimum, and `D`: `D (H + Λ)⁻¹ (B + Λ) (H + Λ)⁻¹`, with `H` the second derivative, `B` the covariance of its slope, `Λ` of what is
    /// `known` besides, and `D` the [design effect](Statistics::design_effect). How often surfaces are touched, `odds`, was found from the same contacts and counts as a parameter for each.
    /// None where the cost does not curve up in all directions, as it does at a minimum that enough contacts say.
    ///
    /// Source: Huber, *The behavior of maximum likelihood estimates under nonstandard conditions* (1967), theorem 3.
    pub fn covariance(
        &self,
        known: &DMatrix<f64>,
        scale: &DVector<f64>,
        odds: &[Vec<Odds>],
    ) -> Option<(DMatrix<f64>, f64)> {
        let (parameters, size) = (scale.len(), self.derivatives.information.nrows());
        let (mut curvature, mut squares) =
            (self.derivatives.information.clone(), self.squares_of_slope.information.clone());
        for sum in [&mut curvature, &mut squares] {
            let mut of_parameters = sum.view_mut((0, 0), (parameters, parameters));
            of_parameters += known;
        }
        let tallies = self.tallies.iter().flatten().zip(odds.iter().flatten());
        let (by_walls, before): (Vec<f64>, Vec<f64>) = tallies.flat_map(|(tally, odds)| tally.told(odds)).unzip();
        let (by_walls, before) = (DVector::from_vec(by_walls), DVector::from_vec(before));
        for sum in [&mut curvature, &mut squares] {
            let mut of_odds = sum.view_mut((parameters, parameters), (size - parameters, size - parameters));
            of_odds += DMatrix::from_diagonal(&before);
        }
        let mut of_odds = curvature.view_mut((parameters, parameters), (size - parameters, size - parameters));
        of_odds += DMatrix::from_diagonal(&by_walls);
        of_odds.copy_from(&at_least(&of_odds.clone_owned(), &before));
        let scales = DVector::from_fn(size, |k, _| if k < parameters { scale[k] } else { 1.0 });
        let held = DMatrix::from_diagonal(&scales.map(|scale| f64::from(u8::from(scale == 0.0))));
        Cholesky::new(scaled(&curvature, &scales) + held)?;
        let bread = covariance(&curvature, &scales);
        let effect = self.design_effect(scale);
        let found = &bread * squares * &bread * effect;
        Some((found.view((0, 0), (parameters, parameters)).into_owned(), effect))
    }

    /// How many contacts say as much as one that is independent of the others: the variance of slopes summed over blocks of contacts that follow each other, over what it would be if
    /// each had noise of its own; the mean over all directions, less what may be chance as the blocks' scatter tells, and at least 1. Parts that give way or are not of their shape
    /// err in the same way for many contacts.
    ///
    /// Source: Kish, *Survey sampling* (1965), section 5.4; for estimates Liang & Zeger (1986).
    fn design_effect(&self, scale: &DVector<f64>) -> f64 {
        let each = self.squares_of_slope.scaled_information(scale).symmetric_eigen();
        let weakest = SEEN * each.eigenvalues.max();
        let pairs = each.eigenvalues.iter().zip(each.eigenvectors.column_iter());
        let seen: Vec<_> = pairs.filter(|(value, _)| **value > weakest).collect();
        let of_block = |slope: &DVector<f64>| {
            let scaled = slope.rows(0, scale.len()).component_mul(scale);
            let squares: f64 = seen.iter().map(|(value, direction)| direction.dot(&scaled).powi(2) / *value).sum();
            squares / seen.len().max(1) as f64
        };
        let blocks: Vec<f64> = self.slopes_of_blocks.iter().map(of_block).collect();
        let (count, effect) = (blocks.len() as f64, blocks.iter().sum::<f64>());
        let scatter: f64 = blocks.iter().map(|block| (block - effect / count).powi(2)).sum();
        // Normal slopes, independent of each other, would scatter at least so much.
        let least = 2.0 / (count * seen.len() as f64).max(1.0);
        let chance = (scatter * count / f64::max(count - 1.0, 1.0)).max(least);
        let excess = (effect - 1.0).max(0.0);
        1.0 + excess.powi(3) / (excess.powi(2) + chance).max(f64::MIN_POSITIVE)
    }
}

/// Information with at least what was known `before` in every direction: contacts that do not tell which of several walls they touch may have a cost that curves down along how often
/// these are touched, but tell no less than nothing.
fn at_least(information: &DMatrix<f64>, before: &DVector<f64>) -> DMatrix<f64> {
    // The decomposition never ends on what is not a number.
    if before.is_empty() || information.iter().any(|entry| !entry.is_finite()) {
        return information.clone();
    }
    let units = before.map(|known| known.sqrt().recip());
    let mut seen = scaled(information, &units).symmetric_eigen();
    seen.eigenvalues.apply(|value| *value = value.max(1.0));
    scaled(&seen.recompose(), &units.map(f64::recip))
}

impl System<'_> {
    /// Whether any contact is one-sided, so that it has walls.
    pub fn has_walls(&self) -> bool {
        let one_sided = self.problem.fixtures.iter().any(|fixture| fixture.manifold.has_interference());
        one_sided && self.problem.noise.encoder > 0.0 && !self.problem.contacts.is_empty()
    }

    /// What every `stride`-th contact says at `theta`, weighted to stand for all: as a search wants it, or as the covariance does.
    pub fn wall_statistics(&self, theta: &DVector<f64>, stride: usize, for_covariance: bool) -> Statistics {
        let at = self.at(theta);
        let size = self.parameters.len();
        let room = || {
            let mut rows = at.rows();
            rows.for_covariance = for_covariance;
            (rows, Statistics::new(size, &self.odds, for_covariance))
        };
        let (_, rooms) = self.sum(stride, room, |batch, (rows, statistics), _| {
            batch.iter().for_each(|&i| at.add_to(statistics, i, rows));
        });
        let mut total = Statistics::new(size, &self.odds, for_covariance);
        rooms.iter().for_each(|(_, statistics)| total.add(statistics));
        total.scale(stride as f64);
        Statistics {
            derivatives: total.derivatives.complete(),
            squares_of_slope: total.squares_of_slope.complete(),
            ..total
        }
    }

    /// Learns from every `stride`-th contact how often walls are touched, how noisy they are and how much they differ: a step of expectation–maximisation.
    pub fn learn_walls(&mut self, theta: &DVector<f64>, scale: &DVector<f64>, stride: usize) -> Learned {
        let mut found = self.wall_statistics(theta, stride, false);
        let telling = found.telling(self);
        let (odds, noise) = (found.odds(&self.odds), found.noise(self.wall_noise, self.parameters.len()));
        let mut change = found.change(&self.odds, &odds).max((noise / self.wall_noise).ln().abs());
        self.at(theta).add_distances(&mut found.derivatives);
        let data = found.derivatives.clone().complete().information;
        self.add_priors(theta, Rung::Walls, &mut found.derivatives);
        let normal = found.derivatives.complete();
        let step = normal.damped(scale, 0.0).map(|damped| damped.step(&normal.gradient));
        let step = step.filter(|step| -normal.gradient.dot(step) < SHORT);
        (self.odds, self.wall_noise) = (odds, noise);
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
                    change = change.max(before.map_or(0.0, |before| (sigma / before).ln().abs()));
                }
            }
        }
        Learned { telling, change, cost: normal.cost, step }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    /// Of 4096 contacts in blocks of 64, `alike` of which in a row have the same slope.
    fn design_effect(alike: usize, seed: u64) -> f64 {
        const PARAMETERS: usize = 6;
        let mut chance = Pcg64::seed_from_u64(seed);
        let mut statistics = Statistics::new(PARAMETERS, &[], true);
        for _ in 0..64 {
            let mut block = Statistics::new(PARAMETERS, &[], true);
            for _ in 0..64 / alike {
                let slope = DVector::from_fn(PARAMETERS, |_, _| StandardNormal.sample(&mut chance));
                block.squares_of_slope.information += &slope * slope.transpose() * alike as f64;
                block.squares_of_slope.gradient += slope * alike as f64;
            }
            statistics.add(&block);
        }
        statistics.design_effect(&DVector::repeat(PARAMETERS, 0.1))
    }

    #[test]
    fn contacts_tell_no_less_than_nothing() {
        // Eigenvectors (1, 1) and (1, −1) in units of what was known before: contacts add 3 to the one, take 3 from the other.
        let (before, told) = (DVector::from_vec(vec![4.0, 25.0]), DMatrix::from_row_slice(2, 2, &[1.0, 3.0, 3.0, 1.0]));
        let known = at_least(&scaled(&told, &before.map(f64::sqrt)), &before);
        let expected = scaled(&DMatrix::from_row_slice(2, 2, &[2.5, 1.5, 1.5, 2.5]), &before.map(f64::sqrt));
        assert!((&known - &expected).amax() < 1e-12, "{known}");
        assert!((at_least(&expected, &before) - expected).amax() < 1e-12);
    }

    #[test]
    fn contacts_that_err_alike_count_once() {
        for alike in [1, 2, 4, 8] {
            let mean = (0..20).map(|seed| design_effect(alike, seed)).sum::<f64>() / 20.0;
            println!("{alike} alike: {mean:.3}");
            assert!((mean / alike as f64 - 1.0).abs() < 0.1, "{alike} alike: {mean}");
        }
    }
}

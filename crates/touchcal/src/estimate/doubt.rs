//! Whether the minimum found is the only one.
//!
//! Gaps have many minima. From contacts that cover the hole well, every search ends in the same one; from few contacts, or little motion, searches end
//! here and there, each sure of itself. Where contacts scatter more than a right minimum lets them, the search is run again from other starts, as likely by what
//! the coarse stage knows; if one ends elsewhere and fits about as well, nothing is known.

use nalgebra::{Cholesky, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::calibrate::{Observe, Search};
use super::rows::Rung;

/// Scatter of whitened gaps (root mean square) beyond which a minimum is doubted. A right one has less than 1: blended gaps are smoother than single ones.
const DOUBTFUL: f64 = 0.9;
/// Other starts.
const STARTS: u64 = 4;
/// Squared distance of minima, by the information of the contacts looked at, beyond which they are different ones.
const ELSEWHERE: f64 = 100.0;
/// A minimum of up to this many times the cost, twice the scatter, fits about as well: where minima abound, the deepest is not yet the right one.
const AS_WELL: f64 = 4.0;

impl Search<'_> {
    /// Whether other starts lead elsewhere; leaves the search as it was.
    pub(super) fn has_other_minima(&mut self, coarse: &DVector<f64>, observe: Observe<'_>) -> bool {
        let rung = Rung::Residual(self.system.problem.loss);
        let stride = self.stride();
        let contacts = self.system.contacts(&self.theta, rung, stride);
        let scatter = (contacts.squares / contacts.rows.max(f64::MIN_POSITIVE)).sqrt();
        if !self.system.has_walls() || self.system.problem.noise.learned || scatter < DOUBTFUL {
            return false;
        }
        let Some(starts) = self.starts(coarse) else { return false };
        let found = self.theta.clone();
        let here = self.system.linearize(&found, rung, stride);
        let (termination, resolution) = (self.termination, self.system.resolution);
        let mut elsewhere = false;
        for start in starts {
            self.theta = start;
            self.glance(observe);
            self.system.resolution = resolution;
            let cost = self.system.linearize(&self.theta, rung, stride).cost;
            let step = &self.theta - &found;
            let distance = step.dot(&(&here.information * &step)) / stride as f64;
            elsewhere |= distance > ELSEWHERE && cost < AS_WELL * here.cost;
            if elsewhere || self.interrupted() {
                break;
            }
        }
        if !self.interrupted() {
            self.termination = termination;
        }
        self.system.resolution = resolution;
        self.theta = found;
        elsewhere
    }

    /// Starts drawn from the posterior of the coarse stage.
    fn starts(&self, coarse: &DVector<f64>) -> Option<Vec<DVector<f64>>> {
        let normal = self.system.linearize(coarse, Rung::Envelope, self.stride());
        let mut scaled = normal.scaled_information(&self.scale);
        for k in (0..self.scale.len()).filter(|&k| self.scale[k] == 0.0) {
            scaled[(k, k)] = 1.0;
        }
        let factor = Cholesky::new(scaled)?.l();
        let start = |seed| {
            let mut chance = Pcg64::seed_from_u64(seed);
            let each = (0..self.scale.len()).map(|_| StandardNormal.sample(&mut chance));
            let draw = DVector::from_iterator(self.scale.len(), each);
            Some(coarse + factor.tr_solve_lower_triangular(&draw)?.component_mul(&self.scale))
        };
        (0..STARTS).map(start).collect()
    }
}

//! What noise does to an estimate on average, and taking it away.
//!
//! A gap is the least of many features' gaps, so it answers encoder noise one-sidedly: two walls that both touch make the noisy
//! gap too small, a wall not quite touching makes it too small now and then. Fitted to such gaps, the parameters are biased by more than
//! their standard deviation once thousands of contacts have averaged the noise away.
//!
//! The bias is measured where it arises: every contact is moved onto the manifold, given noise drawn in antithetic pairs (whose linear effects cancel,
//! leaving only the one-sided part), and the step that the estimator would take from there is its bias.
//! Source: Efron & Tibshirani, *An introduction to the bootstrap* (1993), section 10.2, parametric, with one Gauss–Newton step for each refit.

use nalgebra::DVector;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use super::rows::{ContactRows, Entry, Rung};
use super::system::System;

/// Antithetic pairs drawn for each contact.
const PAIRS: usize = 2;
/// A bias is an average: about this many contacts are enough to measure it.
const ENOUGH: usize = 750;

struct Room {
    rows: ContactRows,
    on_manifold: Vec<f64>,
    noise: Vec<f64>,
    measured: Vec<f64>,
}

impl System<'_> {
    /// Whether noise moves the estimate on average: only one-sided residuals do.
    pub fn has_noise_bias(&self) -> bool {
        let one_sided = self.problem.fixtures.iter().any(|fixture| fixture.manifold.has_interference());
        one_sided && self.problem.noise.encoder > 0.0 && !self.problem.contacts.is_empty()
    }

    /// The average error that encoder noise gives to an estimate that should be `theta`, zero for parameters of `scale` 0.
    pub fn noise_bias(&self, theta: &DVector<f64>, scale: &DVector<f64>) -> Option<DVector<f64>> {
        let at = self.at(theta);
        let contacts = &self.problem.contacts;
        let stride = (contacts.len() / ENOUGH).max(1);
        let rung = Rung::Residual(self.problem.loss);
        let entry = Entry { rung, share: stride as f64 / (2 * PAIRS) as f64 };
        let zeros = || vec![0.0; contacts.dof()];
        let room = || Room { rows: at.rows(), on_manifold: zeros(), noise: zeros(), measured: zeros() };
        let (simulated, _) = self.sum(stride, room, |batch, room, normal| {
            for &i in batch.iter().filter(|&&i| self.problem.fixtures[contacts.fixture(i)].manifold.has_interference())
            {
                room.on_manifold.copy_from_slice(contacts.q(i));
                at.move_onto_manifold(i, &mut room.on_manifold, &mut room.rows);
                // A stream of its own for each contact: the same whatever thread comes by.
                let mut chance = Pcg64::seed_from_u64(i as u64);
                for _ in 0..PAIRS {
                    for (noise, variance) in room.noise.iter_mut().zip(&self.joint_variance) {
                        let standard: f64 = StandardNormal.sample(&mut chance);
                        *noise = standard * variance.sqrt() * self.noise_factor;
                    }
                    for sign in [1.0, -1.0] {
                        let moved = room.on_manifold.iter().zip(&room.noise);
                        room.measured.iter_mut().zip(moved).for_each(|(to, (q, noise))| *to = q + sign * noise);
                        at.touch(i, &room.measured, rung, &mut room.rows);
                        at.add(i, entry, &room.rows, normal);
                    }
                }
            }
        });
        let mut normal = self.linearize(theta, rung, stride);
        normal.gradient = simulated.gradient;
        normal.damped_step(scale, DAMPING)
    }
}

/// Keeps directions without information where they are (in units of the scales).
const DAMPING: f64 = 1e-6;

//! What is known of the parameters once information and priors are counted.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::identifiability::{Held, Identifiability};
use super::system::System;
use crate::robot::Column;

/// A parameter is identifiable if the data bring its standard deviation below this share of what it was.
const IDENTIFIABLE_BELOW: f64 = 0.5;

/// Uncertainty of every parameter, and what the data have to do with it.
pub(super) struct Knowledge {
    /// Covariance (SI); rows and columns of held parameters are zero.
    pub covariance: DMatrix<f64>,
    /// Covariance that the data leave of parameters that were known to their scale before, all of them.
    pub posterior: DMatrix<f64>,
    /// What the data determine and what they do not.
    pub identifiability: Identifiability,
    /// Whether the data determine each parameter.
    pub identifiable: Vec<bool>,
    /// Whether anything, data or prior, bounds each parameter.
    bounded: Vec<bool>,
}

impl Knowledge {
    /// From the information `data` of contacts and known distances; `scale` is 0 where a parameter is `held`.
    pub fn new(system: &System<'_>, data: &DMatrix<f64>, scale: &DVector<f64>, held: &Held) -> Self {
        // How walls differ is no concern of what the data determine.
        let is_wall = |k: usize| matches!(system.parameters[k].column, Column::Wall(..));
        let plausible = system.scale().map_with_location(|k, _, scale| if is_wall(k) { 0.0 } else { scale });
        let covariance = covariance(&(data + system.prior_information()), scale);
        let posterior = posterior(data, &plausible);
        let with_prior = system.parameters.iter().map(|parameter| parameter.prior_sigma.is_some());
        let bounded: Vec<bool> =
            with_prior.enumerate().map(|(k, prior)| prior || !held.participants.contains(&k)).collect();
        let shrunk = |k: usize| posterior[(k, k)].max(0.0).sqrt() < IDENTIFIABLE_BELOW * plausible[k];
        let identifiable = bounded.iter().enumerate().map(|(k, bounded)| *bounded && shrunk(k)).collect();
        let identifiability = Identifiability::new(data, &system.parameters, &plausible);
        Knowledge { covariance, posterior, identifiability, identifiable, bounded }
    }

    /// Standard deviation of parameter `k` (SI); none where nothing bounds it.
    pub fn sigma(&self, k: usize) -> Option<f64> {
        self.bounded[k].then(|| self.covariance[(k, k)].max(0.0).sqrt())
    }
}

/// Inverse of the information over the parameters that are not held.
pub(super) fn covariance(information: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    let size = scale.len();
    let scaled = DMatrix::from_fn(size, size, |i, j| {
        let held = scale[i] == 0.0 || scale[j] == 0.0;
        if held { f64::from(u8::from(i == j)) } else { scale[i] * information[(i, j)] * scale[j] }
    });
    let inverse = Cholesky::new(scaled.clone()).map(|cholesky| cholesky.inverse());
    let inverse = inverse.or_else(|| scaled.pseudo_inverse(1e-14).ok()).unwrap_or_else(|| DMatrix::zeros(size, size));
    DMatrix::from_fn(size, size, |i, j| scale[i] * inverse[(i, j)] * scale[j])
}

/// Covariance that the data leave of parameters that had standard deviations `scale` before, all of them.
fn posterior(data: &DMatrix<f64>, scale: &DVector<f64>) -> DMatrix<f64> {
    let prior = DMatrix::from_diagonal(&scale.map(|sigma| sigma.powi(-2)));
    covariance(&(data + prior), scale)
}

//! The noise of contacts.

use crate::estimate::problem::Noise;
use crate::robot::{JointKind, Robot};

/// Variances of the measurements, and the factors that were estimated for them.
#[derive(Clone, Debug)]
pub(crate) struct NoiseModel {
    /// Variance of each moving joint's measurement (rad²); 0 for a prismatic joint.
    pub joint_variance: Vec<f64>,
    /// Standard deviation of a residual row apart from the encoders (m).
    pub contact: f64,
    /// Estimated over declared standard deviation of whitened residuals (1).
    pub factor: f64,
    /// Estimated over declared standard deviation of candidate contacts (1), on top of `factor`.
    pub mode_factor: f64,
    /// Standard deviation (m) of residuals, to which the manifolds blend nearly equal gaps; see
    /// [`ContactManifold::residual`](crate::manifold::ContactManifold::residual).
    pub resolution: f64,
}

impl NoiseModel {
    /// The declared noise of `robot`'s joints and of contacts, with factors of 1.
    pub fn new(robot: &Robot, noise: &Noise) -> Self {
        let joint_variance = robot.moving().map(|joint| match joint.kind {
            // The declared angle is that of a revolute joint; an encoder of length would be rated
            // in metres.
            JointKind::Prismatic => 0.0,
            _ => noise.encoder.powi(2),
        });
        NoiseModel {
            joint_variance: joint_variance.collect(),
            contact: noise.contact,
            factor: 1.0,
            mode_factor: 1.0,
            resolution: 0.0,
        }
    }

    /// Factor (1) on the variances of residuals.
    pub fn residual_variance_factor(&self) -> f64 {
        self.factor.powi(2)
    }

    /// Factor (1) on the variances of candidate contacts.
    pub fn mode_variance_factor(&self) -> f64 {
        (self.factor * self.mode_factor).powi(2)
    }
}

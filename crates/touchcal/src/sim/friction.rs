//! Friction of pairs that touch: tangential springs whose force is bounded.

use nalgebra::{Matrix3x6, Matrix6, Point3, Vector3};

use super::parts::Pair;
use crate::se3::{Pose, Twist};

/// Tangential stiffness of what sticks (N/m): 10 N shear it by 1 µm.
pub(super) const STICKING: f64 = 1e7;

/// Friction of a pair in the linear model; forces and lengths in the tool frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Friction {
    /// Tangential motion of the point for a displacement of the tool.
    pub slip_by: Matrix3x6<f64>,
    /// Force (N) if the pair sticks.
    pub trial: Vector3<f64>,
    /// Greatest force (N).
    pub most: f64,
}

impl Friction {
    pub fn force(&self) -> Vector3<f64> {
        bounded(&self.trial, self.most)
    }

    /// Adds what it contributes to the gradient and the curvature of the energy by a displacement
    /// of the tool.
    pub fn add_to(&self, gradient: &mut Twist, curvature: &mut Matrix6<f64>) {
        let size = self.trial.norm();
        *gradient -= self.slip_by.tr_mul(&self.force());
        let sticking = (self.most / size).min(1.0) * STICKING;
        *curvature += self.slip_by.tr_mul(&self.slip_by) * sticking;
        if size > self.most {
            let along = self.slip_by.tr_mul(&(self.trial / size));
            curvature.ger(-sticking, &along, &along, 1.0);
        }
    }
}

/// A point of the tool that rubs; directions and forces in the fixture's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rubbing {
    pub pair: Pair,
    pub point_in_tool: Point3<f64>,
    pub normal: Vector3<f64>,
    /// Force (N) when the last command ended.
    pub carried: Vector3<f64>,
    /// Greatest force (N).
    pub most: f64,
}

impl Rubbing {
    /// Force (N) at `pose` if the point sticks.
    pub fn trial(&self, pose: &Pose, before: &Pose) -> Vector3<f64> {
        let moved = pose * self.point_in_tool - before * self.point_in_tool;
        let trial = self.carried - moved * STICKING;
        trial - self.normal * self.normal.dot(&trial)
    }

    /// Energy (J) of the tangential spring and of what has slid.
    pub fn energy(&self, pose: &Pose, before: &Pose) -> f64 {
        let size = self.trial(pose, before).norm();
        let energy = if size <= self.most { 0.5 * size * size } else { self.most * (size - 0.5 * self.most) };
        energy / STICKING
    }
}

/// A vector, shortened to a length.
pub(super) fn bounded(vector: &Vector3<f64>, most: f64) -> Vector3<f64> {
    let size = vector.norm();
    if size <= most { *vector } else { vector * (most / size) }
}

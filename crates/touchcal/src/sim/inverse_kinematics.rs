//! Joint positions that reach a pose.

use nalgebra::{Cholesky, DVector, Matrix6};

use crate::robot::Kinematics;
use crate::se3::{self, Pose, Twist};

/// Newton steps before a pose counts as out of reach.
const STEPS: usize = 200;
/// Longest step (rad or m) of any joint.
const LONGEST_STEP: f64 = 0.2;
/// Share of the way to the preferred posture taken at each step.
const POSTURE_SHARE: f64 = 0.2;

/// Joint positions that put the tool at `base_from_tool`, searched from `q`; redundant joints go towards `posture`.
/// `None` if the pose is out of reach from there.
///
/// Newton steps `q ← q + J⁺ e + (I − J⁺J)(posture − q)` with `J⁺ = Jᵀ(JJᵀ + λI)⁻¹`; the pose is met to 1e-12.
pub fn follow(kinematics: &Kinematics, base_from_tool: &Pose, q: &[f64], posture: &[f64]) -> Option<Vec<f64>> {
    let mut scratch = kinematics.scratch();
    let mut q = q.to_vec();
    for step in 0..STEPS {
        let error = se3::log(&(kinematics.pose_and_jacobian(&q, &mut scratch).inverse() * base_from_tool));
        // The posture is given up towards the end: the pose is what counts.
        let posture_share = if step < STEPS / 2 { POSTURE_SHARE } else { 0.0 };
        let towards = DVector::from_iterator(q.len(), posture.iter().zip(&q).map(|(p, q)| posture_share * (p - q)));
        let along: Twist = scratch.joints.iter().zip(towards.iter()).map(|(joint, towards)| joint * *towards).sum();
        let mut gram = Matrix6::identity() * 1e-9;
        for joint in &scratch.joints {
            gram += joint * joint.transpose();
        }
        let lift = Cholesky::new(gram)?.solve(&(error - along));
        let move_by = DVector::from_iterator(q.len(), scratch.joints.iter().map(|joint| joint.dot(&lift))) + &towards;
        if error.amax() < 1e-12 && move_by.amax() < 1e-7 {
            return Some(q);
        }
        let share = (LONGEST_STEP / move_by.amax()).min(1.0);
        q.iter_mut().zip(move_by.iter()).for_each(|(q, by)| *q += share * by);
    }
    let error = se3::log(&(kinematics.pose(&q).inverse() * base_from_tool));
    (error.amax() < 1e-10).then_some(q)
}

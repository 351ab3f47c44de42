//! Joint positions that reach a pose.

use nalgebra::{Cholesky, DVector, Matrix6};

use crate::robot::{Kinematics, KinematicsScratch};
use crate::se3::{self, Pose, Twist, Wrench};

/// Newton steps before a pose counts as out of reach.
const STEPS: usize = 200;
/// Of these, the first go towards the posture too.
const POSTURE_STEPS: usize = 30;
/// Longest step (rad or m) of any joint.
const LONGEST_STEP: f64 = 0.2;
/// Close enough to the posture (rad or m): the pose is what counts.
const POSTURE_MET: f64 = 1e-3;

/// Joint positions (rad, or m for a prismatic joint; base first) that put the tool at
/// `base_from_tool` (m), searched from `q`; redundant joints go towards `posture`. `q`, `posture`
/// and the result hold [`Kinematics::dof`] positions in this order; panics if `q` or `posture` has
/// fewer. `None` if the search from `q` does not reach the pose. Joint limits have no effect; no
/// load acts.
///
/// Newton steps `q ← q + J⁺ e + (I − J⁺J)(posture − q)`: the null space of the Jacobian `J` of the
/// tool pose (right twists) takes up the pull to the posture (Liégeois 1977), and
/// `J⁺ = Jᵀ(JJᵀ + λI)⁻¹` is damped by λ = 1e-9 (Wampler 1986). `e` is the pose error
/// `Log(pose⁻¹ · base_from_tool)` (m and rad). A step is shortened to at most 0.2 (rad or m) for
/// any joint. The pull ends after 30 steps, or after a step below 1e-3 (rad or m) for all joints.
/// The pose is met where all components of `e` are below 1e-12 (m, rad), or below 1e-10 after the
/// last of 200 steps.
pub fn follow(kinematics: &Kinematics, base_from_tool: &Pose, q: &[f64], posture: &[f64]) -> Option<Vec<f64>> {
    let mut q = q.to_vec();
    Follower::new(kinematics).follow((base_from_tool, &[0.0; 6]), &mut q, posture).then_some(q)
}

/// An arm that follows poses.
pub(super) struct Follower<'a> {
    kinematics: &'a Kinematics,
    scratch: KinematicsScratch,
    towards: DVector<f64>,
    step: DVector<f64>,
}

impl<'a> Follower<'a> {
    /// A follower for an arm with these kinematics, at the parameter values that they have.
    pub fn new(kinematics: &'a Kinematics) -> Self {
        let zeros = || DVector::zeros(kinematics.dof());
        Follower { kinematics, scratch: kinematics.scratch(), towards: zeros(), step: zeros() }
    }

    /// Moves `q` as [`follow`] does, which says what lengths `q` and `posture` have, to where the
    /// arm reaches the pose under `load`: the wrench `[f; τ]` (N, N m) exerted on the tool about
    /// the tip's origin, in the tip frame. False if the pose is not reached: `q` then holds the
    /// positions of the last step.
    pub fn follow(&mut self, (base_from_tool, load): (&Pose, &Wrench), q: &mut [f64], posture: &[f64]) -> bool {
        let mut pulled = true;
        for step in 0..STEPS {
            let pose = self.kinematics.pose_and_jacobian_under(q, load, &mut self.scratch);
            let error = se3::log(&(pose.inverse() * base_from_tool));
            if !pulled && error.amax() < 1e-12 {
                return true;
            }
            pulled = pulled && step < POSTURE_STEPS;
            for (i, towards) in self.towards.iter_mut().enumerate() {
                *towards = if pulled { posture[i] - q[i] } else { 0.0 };
            }
            let joints = &self.scratch.joints;
            let along: Twist = joints.iter().zip(self.towards.iter()).map(|(joint, towards)| joint * *towards).sum();
            let mut gram = Matrix6::identity() * 1e-9;
            for joint in joints {
                gram.ger(1.0, joint, joint, 1.0);
            }
            let Some(cholesky) = Cholesky::new(gram) else { return false };
            let lift = cholesky.solve(&(error - along));
            for (i, joint) in joints.iter().enumerate() {
                self.step[i] = joint.dot(&lift) + self.towards[i];
            }
            let longest = self.step.amax();
            let share = (LONGEST_STEP / longest).min(1.0);
            q.iter_mut().zip(self.step.iter()).for_each(|(q, by)| *q += share * by);
            pulled = pulled && longest > POSTURE_MET;
        }
        let error = se3::log(&(self.kinematics.pose_under(q, load).inverse() * base_from_tool));
        error.amax() < 1e-10
    }
}

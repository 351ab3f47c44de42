//! What a robot description cannot say about joint positions: errors of encoders that depend on
//! the position, and joints that deflect.

use nalgebra::Vector3;

use super::chain::Robot;
use super::deflection::Deflection;
use super::encoder_term::{EncoderTerm, encoder_error, measured_position};
use super::gravity_torque::{Gravity, JointTorques};
use super::joint_load::JointLoad;
use super::joint_stage::{JointStage, stages};
use super::rest::come_to_rest;
use crate::se3::{Pose, Wrench};

/// Converts measured joint positions into those of an arm's description, and back.
///
/// `true = measured − e(measured) + d(τ(true))`, joint by joint, with the error `e` of the encoder
/// ([`EncoderTerm`]s), the deflection `d` by compliance and backlash and the torque `τ` (N m) about
/// the joint, of gravity and load or as measured, as in [`Kinematics`](super::Kinematics). The tool
/// is where a stiff arm with the same joint origins has it at the true positions. Encoder offsets
/// are part of the origins of a calibrated arm and none of this.
#[derive(Clone, Debug)]
pub struct JointCorrection {
    stages: Vec<JointStage>,
    tip: JointStage,
    gravity: Gravity,
    has_measured_torques: bool,
    /// Terms of the error of each joint's encoder, with their amplitudes.
    errors: Vec<Vec<(EncoderTerm, f64)>>,
}

/// A part of the chain from which the torques of gravity follow: a moving joint with the fixed
/// joints before it, or what follows the last moving one.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedLink {
    /// Pose of the joint's frame at position zero, or of the tip, in the frame of the moving joint
    /// before, or of the base (m).
    pub parent_from_joint: Pose,
    /// Mass (kg) of all links that move with this joint, but not with the next moving one.
    pub mass: f64,
    /// Their common centre (m) in the joint's frame, which moves with the joint; zero without mass.
    pub center: Vector3<f64>,
}

impl JointCorrection {
    /// The correction of `robot`, whose encoders have these `errors`: index of the moving joint,
    /// base first, term, and its amplitude. Errors of joints that the arm does not have are left
    /// out.
    pub fn new(robot: &Robot, errors: impl IntoIterator<Item = (usize, EncoderTerm, f64)>) -> Self {
        let (stages, tip) = stages(robot);
        let mut of_joints = vec![Vec::new(); stages.len()];
        for (joint, term, amplitude) in errors {
            if let Some(terms) = of_joints.get_mut(joint).filter(|_| amplitude != 0.0) {
                terms.push((term, amplitude));
            }
        }
        let has_measured_torques = robot.has_measured_torques();
        JointCorrection { stages, tip, gravity: Gravity::of(robot), has_measured_torques, errors: of_joints }
    }

    /// Whether true positions are the measured ones, whatever they are.
    pub fn is_identity(&self) -> bool {
        self.errors.iter().all(Vec::is_empty) && !self.is_compliant()
    }

    /// The chain and its masses: an entry for each moving joint, base first, and one for the tip.
    pub fn links(&self) -> Vec<LoadedLink> {
        let chain = self.stages.iter().chain(std::iter::once(&self.tip));
        let each = chain.zip(self.gravity.masses()).map(|(stage, (mass, center))| LoadedLink {
            parent_from_joint: stage.nominal,
            mass,
            center,
        });
        each.collect()
    }

    /// True positions at `measured` ones (rad, or m for a prismatic joint; one for each moving
    /// joint, base first) under `load`. Surplus positions are ignored; with fewer the result has no
    /// meaning.
    pub fn true_positions<'a>(&self, measured: &[f64], load: impl Into<JointLoad<'a>>) -> Vec<f64> {
        let stiff: Vec<f64> =
            measured.iter().zip(&self.errors).map(|(q, terms)| q - encoder_error(terms, *q)).collect();
        let mut positions = stiff.clone();
        if self.is_compliant() {
            let mut torques = JointTorques::new(self.stages.len());
            let chain = (&self.stages[..], &self.tip);
            come_to_rest(&self.gravity, chain, (&stiff, load.into()), &mut positions, &mut torques);
        }
        positions
    }

    /// The positions that are measured where `wanted` is true: the inverse of
    /// [`true_positions`](JointCorrection::true_positions) under a wrench `[f; τ]` (N, N m) on the
    /// tip, to 1e-14. `None` if an encoder's error changes as fast as the position there, so that
    /// there is no inverse; if joints deflect by measured torques, which nobody knows before the
    /// arm is there; and if joints have a backlash, at whose side they will be held by friction
    /// too.
    pub fn commanded_positions(&self, wanted: &[f64], load: &Wrench) -> Option<Vec<f64>> {
        let mut torques = JointTorques::new(self.stages.len());
        if self.is_compliant() {
            if self.has_measured_torques || self.stages.iter().any(|stage| stage.deflection.backlash != 0.0) {
                return None;
            }
            let load = JointLoad::OnTip(load);
            torques.update(&self.gravity, load, (&self.stages, &self.tip), wanted);
        }
        let each = self.stages.iter().zip(wanted).zip(&self.errors).enumerate();
        let stiff = |i: usize, stage: &JointStage, wanted: f64| wanted - stage.deflection.at(torques.torque(i));
        each.map(|(i, ((stage, wanted), terms))| measured_position(terms, stiff(i, stage, *wanted))).collect()
    }

    fn is_compliant(&self) -> bool {
        self.stages.iter().any(|stage| stage.deflection != Deflection::NONE)
    }
}

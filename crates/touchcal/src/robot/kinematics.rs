//! Forward kinematics of an arm with erroneous parameters and compliant joints, and its
//! derivatives.

use nalgebra::{Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3};

use super::chain::Robot;
use super::deflection::{Deflection, side_of_play};
use super::gravity_torque::{Gravity, JointTorques};
use super::joint_load::JointLoad;
use super::joint_stage::{JointStage, LinkPose, stages};
use super::kinematic_parameter::KinematicParameter;
use super::rest::{CONVERGED, DEFLECTION_ITERATIONS, come_to_rest};
use crate::se3::{self, Pose, Twist, Wrench};

const NO_LOAD: Wrench = [0.0; 6];

/// Forward kinematics of one arm with its tool at one value of its parameters.
///
/// `base_from_tool(q) = ∏ᵢ [Oᵢ(r) · Exp(ξᵢ) · Motion(axisᵢ, qᵢ − bᵢ + dᵢ(τᵢ))] · O_tip(r) ·
/// tip_from_tool · Exp(ξ_tool)`
///
/// The product is over the moving joints, base first: `qᵢ` is the measured position (rad, or m for
/// a prismatic joint), `bᵢ` the encoder offset, `dᵢ` the deflection by compliance and backlash, and
/// `ξᵢ` the twist on the origin (m, rad). The translation of the joint origin `Oᵢ(r)` is scaled by
/// `1 + r + r_segment`. `τᵢ` (N m) is the torque about joint `i` of gravity and of the load at the
/// tip, where the deflected joints are: of an arm at rest; or it is measured ([`JointLoad`]).
///
/// Derivatives are exact.
#[derive(Clone, Debug)]
pub struct Kinematics {
    parameters: Vec<KinematicParameter>,
    stages: Vec<JointStage>,
    tip: JointStage,
    /// None if all joints are stiff.
    gravity: Option<Gravity>,
    tip_from_tool: Pose,
    tool_rotation: Matrix3<f64>,
    tool_translation: Vector3<f64>,
    tool_jacobian: Matrix6<f64>,
    /// Torques of [`Kinematics::with_usual_torques`].
    usual_torques: Vec<f64>,
}

/// Torques and derivatives of the last evaluation by [`Kinematics::pose_and_jacobian`],
/// [`Kinematics::pose_and_jacobian_under`] or [`Kinematics::differentiate_by_load`], in memory that
/// is reused from evaluation to evaluation. Made by [`Kinematics::scratch`]; zeros before the first
/// evaluation.
#[derive(Clone, Debug)]
pub struct KinematicsScratch {
    rotation: Vec<Matrix3<f64>>,
    position: Vec<Vector3<f64>>,
    /// Rotation of the frame that each stage's translation is given in, the tip's last.
    parent: Vec<Matrix3<f64>>,
    /// Joint positions of the arm at rest, encoder offsets taken off.
    positions: Vec<f64>,
    /// What the joints carry there, of a compliant arm.
    at_rest: JointTorques,
    /// Derivatives by joint positions of an arm that does not deflect.
    stiff_joints: Vec<Twist>,
    /// Deflection `dᵢ' ∂τᵢ/∂qⱼ` of joint `i` by the motion of joint `j`, joint by joint `j`.
    deflections: Vec<f64>,
    /// Torque (N m) of gravity and load about each moving joint, or force (N) along a prismatic
    /// one, [`Kinematics::dof`] of them, base first; zeros for a stiff arm.
    pub torques: Vec<f64>,
    /// Derivative of the tool pose `base_from_tool` by each joint position, [`Kinematics::dof`] of
    /// them, base first: right twists `[v; ω]` in the tool frame (m, rad per rad, or per m for a
    /// prismatic joint).
    pub joints: Vec<Twist>,
    /// Derivative of the tool pose `base_from_tool` by each parameter, in the order given to
    /// [`Kinematics::new`]: right twists `[v; ω]` in the tool frame (m, rad per unit of the
    /// parameter).
    pub parameters: Vec<Twist>,
    /// Derivative of the tool pose `base_from_tool` by the load `[f; τ]` about the tip's origin, in
    /// its frame: a right twist `[v; ω]` in the tool frame for each component, in columns (m, rad
    /// per N or N m). Of the last [`Kinematics::differentiate_by_load`] alone.
    pub load: Matrix6<f64>,
}

impl KinematicsScratch {
    /// Derivative of the torque (N m) about moving joint `i` by the load `[f; τ]` about the tip's
    /// origin, in its frame (m, 1), of a compliant arm.
    pub fn torque_by_load(&self, i: usize) -> Twist {
        self.at_rest.by_load(i)
    }
}

impl Kinematics {
    /// Kinematics of `robot` with the tool at pose `tip_from_tool` (m), and all `parameters` at
    /// zero. `parameters` may be empty.
    ///
    /// # Panics
    /// If the index of a joint in `parameters` is not below [`Robot::dof`], or that of a component
    /// of a twist not below 6.
    pub fn new(robot: &Robot, parameters: &[KinematicParameter], tip_from_tool: Pose) -> Self {
        let (stages, tip) = stages(robot);
        let deflects = |p| matches!(p, KinematicParameter::JointCompliance(_) | KinematicParameter::JointBacklash(_));
        let is_compliant = robot.is_compliant() || parameters.iter().any(|&p| deflects(p));
        let mut kinematics = Kinematics {
            parameters: parameters.to_vec(),
            stages,
            tip,
            gravity: is_compliant.then(|| Gravity::of(robot)),
            tip_from_tool,
            tool_rotation: Matrix3::identity(),
            tool_translation: Vector3::zeros(),
            tool_jacobian: Matrix6::identity(),
            usual_torques: Vec::new(),
        };
        kinematics.set(&vec![0.0; parameters.len()]);
        kinematics
    }

    /// Sets the parameter values `theta` (SI): one for each parameter, in the order given to
    /// [`Kinematics::new`]; surplus values are ignored. Of a parameter listed twice the last value
    /// counts.
    pub fn set(&mut self, theta: &[f64]) {
        let mut strain = 0.0;
        let mut segment_strain: Vec<f64> = Vec::new();
        let mut tool = Twist::zeros();
        for (&parameter, &value) in self.parameters.iter().zip(theta) {
            match parameter {
                KinematicParameter::Strain => strain = value,
                KinematicParameter::SegmentStrain(k) => {
                    segment_strain.resize(segment_strain.len().max(k + 1), 0.0);
                    segment_strain[k] = value;
                }
                KinematicParameter::JointOffset(i) => self.stages[i].offset = value,
                KinematicParameter::JointOrigin(i, k) => self.stages[i].twist[k] = value,
                KinematicParameter::JointCompliance(i) if self.stages[i].prismatic => {}
                KinematicParameter::JointCompliance(i) => {
                    self.stages[i].deflection.compliance = self.stages[i].nominal_deflection.compliance + value;
                }
                KinematicParameter::JointBacklash(i) => {
                    self.stages[i].deflection.backlash = self.stages[i].nominal_deflection.backlash + value;
                }
                KinematicParameter::Tool(k) => tool[k] = value,
            }
        }
        for stage in self.stages.iter_mut().chain(std::iter::once(&mut self.tip)) {
            stage.update_origin(strain, &segment_strain);
        }
        let tip_from_tool = self.tip_from_tool * se3::exp(&tool);
        self.tool_rotation = *tip_from_tool.rotation.to_rotation_matrix().matrix();
        self.tool_translation = tip_from_tool.translation.vector;
        self.tool_jacobian = se3::right_jacobian(&tool);
    }

    /// With the torques (N m, or N of a prismatic joint; one for each moving joint, base first)
    /// that joints of an arm that deflects by measured torques bear where none are given; without
    /// them it is stiff there.
    pub fn with_usual_torques(mut self, torques: Vec<f64>) -> Self {
        self.usual_torques = torques;
        self
    }

    fn usual_load(&self) -> JointLoad<'_> {
        if self.usual_torques.is_empty() { JointLoad::OnTip(&NO_LOAD) } else { JointLoad::Torques(&self.usual_torques) }
    }

    /// Number of moving joints, as [`Robot::dof`].
    pub fn dof(&self) -> usize {
        self.stages.len()
    }

    /// Scratch of the right size for [`Kinematics::pose_and_jacobian`] of this arm with these
    /// parameters.
    pub fn scratch(&self) -> KinematicsScratch {
        let n = self.stages.len();
        KinematicsScratch {
            rotation: vec![Matrix3::identity(); n],
            position: vec![Vector3::zeros(); n],
            parent: vec![Matrix3::identity(); n + 1],
            positions: vec![0.0; n],
            at_rest: JointTorques::new(n),
            stiff_joints: vec![Twist::zeros(); n],
            deflections: vec![0.0; n * n],
            torques: vec![0.0; n],
            joints: vec![Twist::zeros(); n],
            parameters: vec![Twist::zeros(); self.parameters.len()],
            load: Matrix6::zeros(),
        }
    }

    /// Pose `base_from_tool` (m) at measured joint positions `q` (rad, or m for a prismatic joint;
    /// [`Kinematics::dof`] of them, base first), without load, or under the usual torques
    /// ([`Kinematics::with_usual_torques`]). Surplus positions are ignored; with fewer the pose has
    /// no meaning.
    pub fn pose(&self, q: &[f64]) -> Pose {
        self.pose_under(q, self.usual_load())
    }

    /// Pose `base_from_tool` (m) at measured joint positions `q` (as in [`Kinematics::pose`]) under
    /// `load`: gravity and a wrench on the tip, or measured torques. A stiff arm does not depend on
    /// it.
    pub fn pose_under<'a>(&self, q: &[f64], load: impl Into<JointLoad<'a>>) -> Pose {
        let stiff = self.stages.iter().zip(q).map(|(stage, q)| q - stage.offset);
        let tool = match &self.gravity {
            None => self.forward(stiff, |_, _, _| {}),
            Some(gravity) => {
                let mut positions = vec![0.0; self.stages.len()];
                let mut torques = JointTorques::new(self.stages.len());
                come_to_rest(gravity, (&self.stages, &self.tip), (q, load.into()), &mut positions, &mut torques);
                self.forward(positions.iter().copied(), |_, _, _| {})
            }
        };
        to_pose(&tool)
    }

    /// Torque (N m, or N of a prismatic joint) about each moving joint at measured joint positions
    /// `q` under `load`, where the deflected joints are, as [`KinematicsScratch::torques`] has it.
    pub fn torques<'a>(&self, q: &[f64], load: impl Into<JointLoad<'a>>) -> Vec<f64> {
        let mut scratch = self.scratch();
        self.pose_and_jacobian_under(q, load, &mut scratch);
        scratch.torques
    }

    /// Pose `base_from_tool` (m), as [`Kinematics::pose`], at measured joint positions `q` (rad, or
    /// m for a prismatic joint; [`Kinematics::dof`] of them, base first). Its derivatives by joint
    /// positions and parameters are written to `scratch`, which must be of these kinematics.
    pub fn pose_and_jacobian(&self, q: &[f64], scratch: &mut KinematicsScratch) -> Pose {
        self.pose_and_jacobian_under(q, self.usual_load(), scratch)
    }

    /// Pose `base_from_tool` (m) at measured joint positions `q` under `load`, as in
    /// [`Kinematics::pose_under`]. Its derivatives by joint positions and parameters are written to
    /// `scratch`; `q` is as in [`Kinematics::pose_and_jacobian`].
    pub fn pose_and_jacobian_under<'a>(
        &self,
        q: &[f64],
        load: impl Into<JointLoad<'a>>,
        scratch: &mut KinematicsScratch,
    ) -> Pose {
        match &self.gravity {
            None => {
                let stiff = self.stages.iter().zip(q).map(|(stage, q)| q - stage.offset);
                scratch.positions.iter_mut().zip(stiff).for_each(|(position, stiff)| *position = stiff);
            }
            Some(gravity) => {
                let KinematicsScratch { positions, at_rest, .. } = scratch;
                come_to_rest(gravity, (&self.stages, &self.tip), (q, load.into()), positions, at_rest);
                scratch.torques.iter_mut().enumerate().for_each(|(i, torque)| *torque = scratch.at_rest.torque(i));
            }
        }
        let tool = self.forward(scratch.positions.iter().copied(), |i, parent, joint| {
            scratch.parent[i] = parent;
            if i < self.stages.len() {
                scratch.rotation[i] = joint.rotation;
                scratch.position[i] = joint.position;
            }
        });
        let into_tool = tool.rotation.transpose();
        for (i, stage) in self.stages.iter().enumerate() {
            let axis = scratch.rotation[i] * stage.axis;
            scratch.joints[i] = if stage.prismatic {
                se3::twist(&(into_tool * axis), &Vector3::zeros())
            } else {
                se3::twist(&(into_tool * axis.cross(&(tool.position - scratch.position[i]))), &(into_tool * axis))
            };
        }
        if self.gravity.is_some() {
            self.add_deflections(scratch);
        }
        for (k, &parameter) in self.parameters.iter().enumerate() {
            scratch.parameters[k] = self.derivative(parameter, scratch, &into_tool, &tool.position);
        }
        to_pose(&tool)
    }

    /// Writes the derivative of the tool pose by the load to `scratch`, at its last evaluation:
    /// `Σᵢ Jᵢ dᵢ' ∂τᵢ/∂load` with the derivatives `Jᵢ` by the joint positions; zero for a stiff
    /// arm.
    pub fn differentiate_by_load(&self, scratch: &mut KinematicsScratch) {
        scratch.load = Matrix6::zeros();
        if self.gravity.is_some() {
            for (i, stage) in self.stages.iter().enumerate() {
                let slope = stage.deflection.slope(scratch.torques[i]);
                scratch.load += scratch.joints[i] * slope * scratch.at_rest.by_load(i).transpose();
            }
        }
    }

    /// Adds to the derivatives by joint positions, those of a stiff arm, how the joints deflect:
    /// `Jⱼ = Jⱼ,stiff + Σᵢ Jᵢ dᵢ' ∂τᵢ/∂qⱼ`, by fixed-point iteration.
    fn add_deflections(&self, scratch: &mut KinematicsScratch) {
        let KinematicsScratch { joints, stiff_joints, deflections, at_rest, torques, .. } = scratch;
        let n = joints.len();
        stiff_joints.copy_from_slice(joints);
        for (k, deflection) in deflections.iter_mut().enumerate() {
            *deflection = self.stages[k % n].deflection.slope(torques[k % n]) * at_rest.slope(k % n, k / n);
        }
        for _ in 0..DEFLECTION_ITERATIONS {
            let mut change = 0.0f64;
            for (j, stiff) in stiff_joints.iter().enumerate() {
                let following = joints.iter().zip(&deflections[j * n..]).map(|(joint, deflection)| joint * *deflection);
                let deflected = stiff + following.sum::<Twist>();
                change = change.max((deflected - joints[j]).amax());
                joints[j] = deflected;
            }
            if change <= CONVERGED {
                break;
            }
        }
    }

    /// The recursion from base to tool, at joint positions without encoder offsets.
    /// `visit(i, parent rotation, joint frame before its motion)` is called for every stage, the
    /// tip last.
    fn forward(
        &self,
        positions: impl Iterator<Item = f64>,
        mut visit: impl FnMut(usize, Matrix3<f64>, &LinkPose),
    ) -> LinkPose {
        let mut frame = LinkPose::base();
        for (i, (stage, position)) in self.stages.iter().zip(positions).enumerate() {
            let parent = frame.rotation;
            frame.advance_to_joint(stage);
            visit(i, parent, &frame);
            frame.advance_through_joint(stage, position);
        }
        let parent = frame.rotation;
        frame.advance_to_joint(&self.tip);
        visit(self.stages.len(), parent, &frame);
        LinkPose {
            rotation: frame.rotation * self.tool_rotation,
            position: frame.position + frame.rotation * self.tool_translation,
        }
    }

    fn derivative(
        &self,
        parameter: KinematicParameter,
        at: &KinematicsScratch,
        into_tool: &Matrix3<f64>,
        tool: &Vector3<f64>,
    ) -> Twist {
        match parameter {
            KinematicParameter::Strain => self.by_translations(at, into_tool, |stage| stage.nominal.translation.vector),
            KinematicParameter::SegmentStrain(k) => self.by_translations(at, into_tool, |stage| {
                stage.shares.iter().filter(|(segment, _)| *segment == k).map(|(_, share)| *share).sum()
            }),
            KinematicParameter::JointOffset(i) => -at.joints[i],
            KinematicParameter::JointCompliance(i) if self.stages[i].prismatic => Twist::zeros(),
            KinematicParameter::JointCompliance(i) => at.joints[i] * at.torques[i],
            KinematicParameter::JointBacklash(i) => at.joints[i] * side_of_play(at.torques[i]),
            KinematicParameter::JointOrigin(i, k) => {
                let local: Twist = self.stages[i].right_jacobian.column(k).into();
                let w = at.rotation[i] * se3::angular(&local);
                let v = at.rotation[i] * se3::linear(&local);
                let of_tool = v + w.cross(&(tool - at.position[i]));
                se3::twist(&(into_tool * of_tool), &(into_tool * w)) + self.deflection(at, i, &v, &w)
            }
            KinematicParameter::Tool(k) => self.tool_jacobian.column(k).into(),
        }
    }

    /// Derivative by a parameter that moves the origin of each stage by `translation` (m), in the
    /// frame before.
    fn by_translations(
        &self,
        at: &KinematicsScratch,
        into_tool: &Matrix3<f64>,
        translation: impl Fn(&JointStage) -> Vector3<f64>,
    ) -> Twist {
        let each = self.all_stages().zip(&at.parent).enumerate().map(|(j, (stage, parent))| {
            let moved = parent * translation(stage);
            se3::twist(&(into_tool * moved), &Vector3::zeros()) + self.deflection(at, j, &moved, &Vector3::zeros())
        });
        each.sum()
    }

    /// Motion of the tool by joints that deflect as the origin of stage `j` moves, in base: its
    /// `velocity` (m) and the `rotation` (rad) about it.
    fn deflection(&self, at: &KinematicsScratch, j: usize, velocity: &Vector3<f64>, rotation: &Vector3<f64>) -> Twist {
        if self.gravity.is_none() {
            return Twist::zeros();
        }
        let compliant = self.stages.iter().enumerate().filter(|(_, stage)| stage.deflection != Deflection::NONE);
        let each = compliant.map(|(i, stage)| {
            let slope = stage.deflection.slope(at.torques[i]);
            at.joints[i] * (slope * at.at_rest.slope_by_origin(i, j, velocity, rotation))
        });
        each.sum()
    }

    fn all_stages(&self) -> impl Iterator<Item = &JointStage> {
        self.stages.iter().chain(std::iter::once(&self.tip))
    }
}

fn to_pose(frame: &LinkPose) -> Pose {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame.rotation));
    Pose::from_parts(frame.position.into(), rotation)
}

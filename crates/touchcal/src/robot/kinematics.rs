//! Forward kinematics of an arm with wrong parameters that bends, and the derivative of the tool pose with respect to them.

use nalgebra::{Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3};

use super::chain::{Joint, JointKind, Robot};
use super::gravity::{Gravity, Torques};
use super::parameters::{Block, Column};
use super::segments::segments;
use super::stage::{Frame, Stage};
use crate::se3::{self, Pose, Twist, Wrench};

const NO_LOAD: Wrench = [0.0; 6];

/// Kinematics of one arm at one value of its parameters.
///
/// `base_from_tool(q) = ∏ᵢ [Oᵢ(r) · Exp(ξᵢ) · Motion(axisᵢ, qᵢ − bᵢ + cᵢ τᵢ)] · O_tip(r) · tip_from_tool · Exp(ξ_tool)`, where `Oᵢ(r)` has
/// its translation scaled by `1 + r + r_segment`, and `τᵢ` (N m) is the torque about joint `i` of gravity and of the load at the tip, on the same arm not bent, at `q − b`: how
/// bending changes the torques is of second order in `c`. [`Column::JointDrift`], [`Column::Fixture`] and
/// [`Column::Interference`] and [`Column::Wall`] columns are left zero: they belong to single placements and to what the tool touches.
///
/// Derivatives leave out how torques change with positions and with other parameters: relative errors of about `c ∂τ/∂q`, less than 1 % for
/// compliances of 1e-4 rad/(N m) and loads of tens of N m.
#[derive(Clone, Debug)]
pub struct Kinematics {
    columns: Vec<Column>,
    stages: Vec<Stage>,
    tip: Stage,
    /// None where no joint can bend.
    gravity: Option<Gravity>,
    tip_from_tool: Pose,
    tool_rotation: Matrix3<f64>,
    tool_translation: Vector3<f64>,
    tool_jacobian: Matrix6<f64>,
}

/// Room for the results of [`Kinematics::pose_and_jacobian`], reused from contact to contact.
#[derive(Clone, Debug)]
pub struct Scratch {
    rotation: Vec<Matrix3<f64>>,
    position: Vec<Vector3<f64>>,
    /// Rotation of the frame that each stage's translation is given in, the tip's last.
    parent: Vec<Matrix3<f64>>,
    /// Torque (N m) of gravity and load about each moving joint, zeros for an arm that cannot bend.
    pub torques: Vec<f64>,
    /// `∂/∂qᵢ` of the tool pose, right twists in the tool frame (moving joints).
    pub joints: Vec<Twist>,
    /// `∂/∂θₖ` of the tool pose, right twists in the tool frame, in the order of the columns.
    pub columns: Vec<Twist>,
}

impl Kinematics {
    /// Kinematics with all parameters at zero. `columns` says which parameters exist, in which order.
    pub fn new(robot: &Robot, columns: &[Column], tip_from_tool: Pose) -> Self {
        let segment_of = segment_of_each_joint(robot);
        let mut stages = Vec::with_capacity(robot.dof());
        let mut origin = Pose::identity();
        let mut shares: Vec<(usize, Vector3<f64>)> = Vec::new();
        for (index, joint) in robot.joints().iter().enumerate() {
            if let Some(segment) = segment_of[index] {
                shares.push((segment, origin.rotation * joint.parent_from_joint.translation.vector));
            }
            origin *= joint.parent_from_joint;
            if joint.kind != JointKind::Fixed {
                stages.push(Stage::moving(origin, joint, std::mem::take(&mut shares)));
                origin = Pose::identity();
            }
        }
        let bends = robot.bends() || columns.iter().any(|column| column.block() == Block::JointCompliance);
        let mut kinematics = Kinematics {
            columns: columns.to_vec(),
            stages,
            tip: Stage::tip(origin, shares),
            gravity: bends.then(|| Gravity::of(robot)),
            tip_from_tool,
            tool_rotation: Matrix3::identity(),
            tool_translation: Vector3::zeros(),
            tool_jacobian: Matrix6::identity(),
        };
        kinematics.set(&vec![0.0; columns.len()]);
        kinematics
    }

    /// Takes over parameter values, one for each column.
    pub fn set(&mut self, theta: &[f64]) {
        let mut strain = 0.0;
        let mut segment_strain: Vec<f64> = Vec::new();
        let mut tool = Twist::zeros();
        for (&column, &value) in self.columns.iter().zip(theta) {
            match column {
                Column::Strain => strain = value,
                Column::SegmentStrain(k) => {
                    segment_strain.resize(segment_strain.len().max(k + 1), 0.0);
                    segment_strain[k] = value;
                }
                Column::JointOffset(i) => self.stages[i].offset = value,
                Column::JointOrigin(i, k) => self.stages[i].twist[k] = value,
                Column::JointCompliance(i) => {
                    self.stages[i].compliance = self.stages[i].nominal_compliance + value;
                }
                Column::Tool(k) => tool[k] = value,
                Column::JointDrift(..) | Column::Fixture(..) | Column::Interference(_) | Column::Wall(..) => {}
            }
        }
        for stage in self.stages.iter_mut().chain(std::iter::once(&mut self.tip)) {
            stage.apply(strain, &segment_strain);
        }
        let tip_from_tool = self.tip_from_tool * se3::exp(&tool);
        self.tool_rotation = *tip_from_tool.rotation.to_rotation_matrix().matrix();
        self.tool_translation = tip_from_tool.translation.vector;
        self.tool_jacobian = se3::right_jacobian(&tool);
    }

    /// Number of moving joints.
    pub fn dof(&self) -> usize {
        self.stages.len()
    }

    /// Room for results.
    pub fn scratch(&self) -> Scratch {
        let n = self.stages.len();
        Scratch {
            rotation: vec![Matrix3::identity(); n],
            position: vec![Vector3::zeros(); n],
            parent: vec![Matrix3::identity(); n + 1],
            torques: vec![0.0; n],
            joints: vec![Twist::zeros(); n],
            columns: vec![Twist::zeros(); self.columns.len()],
        }
    }

    /// The tool's pose in base at measured joint positions `q` (rad or m), where it touches nothing.
    pub fn pose(&self, q: &[f64]) -> Pose {
        self.pose_under(q, &NO_LOAD)
    }

    /// The tool's pose in base under `load`, what is exerted on the tool: a wrench about the tip's origin, in the tip frame.
    pub fn pose_under(&self, q: &[f64], load: &Wrench) -> Pose {
        let tool = self.walk(q, load, |_, _, _, _| {});
        to_pose(&tool)
    }

    /// The tool's pose in base, and its derivatives with respect to joint positions and parameters, left in `scratch`, where it touches nothing.
    pub fn pose_and_jacobian(&self, q: &[f64], scratch: &mut Scratch) -> Pose {
        self.pose_and_jacobian_under(q, &NO_LOAD, scratch)
    }

    /// The same under `load`, see [`pose_under`](Kinematics::pose_under).
    pub fn pose_and_jacobian_under(&self, q: &[f64], load: &Wrench, scratch: &mut Scratch) -> Pose {
        let tool = self.walk(q, load, |i, parent, joint, torque| {
            scratch.parent[i] = parent;
            if i < self.stages.len() {
                scratch.rotation[i] = joint.rotation;
                scratch.position[i] = joint.position;
                scratch.torques[i] = torque;
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
        for (k, &column) in self.columns.iter().enumerate() {
            scratch.columns[k] = self.column(column, scratch, &into_tool, &tool.position);
        }
        to_pose(&tool)
    }

    /// Walks from base to tool. `visit(i, parent rotation, joint's frame before its motion, torque about it)` sees every
    /// stage, the tip last.
    fn walk(&self, q: &[f64], load: &Wrench, visit: impl FnMut(usize, Matrix3<f64>, &Frame, f64)) -> Frame {
        // Two loops: one that asked at every joint whether it bends would slow the arm that does not.
        match &self.gravity {
            None => self.walk_with(q, |_, motion| (motion, 0.0), visit),
            Some(gravity) => {
                let mut torques = Torques::new(gravity, load, (&self.stages, &self.tip), q);
                let bend = |stage: &Stage, motion: f64| {
                    let torque = torques.next(stage, motion);
                    (motion + stage.compliance * torque, torque)
                };
                self.walk_with(q, bend, visit)
            }
        }
    }

    /// The same walk; `bend(stage, motion)` says how far a joint moves that an ideal one moves by `motion`, and the torque about it.
    #[inline]
    fn walk_with(
        &self,
        q: &[f64],
        mut bend: impl FnMut(&Stage, f64) -> (f64, f64),
        mut visit: impl FnMut(usize, Matrix3<f64>, &Frame, f64),
    ) -> Frame {
        let mut frame = Frame::base();
        for (i, (stage, &q)) in self.stages.iter().zip(q).enumerate() {
            let parent = frame.rotation;
            frame.enter(stage);
            let (motion, torque) = bend(stage, q - stage.offset);
            visit(i, parent, &frame, torque);
            frame.pass(stage, motion);
        }
        let parent = frame.rotation;
        frame.enter(&self.tip);
        visit(self.stages.len(), parent, &frame, 0.0);
        Frame {
            rotation: frame.rotation * self.tool_rotation,
            position: frame.position + frame.rotation * self.tool_translation,
        }
    }

    fn column(&self, column: Column, at: &Scratch, into_tool: &Matrix3<f64>, tool: &Vector3<f64>) -> Twist {
        match column {
            Column::Strain => {
                let moved =
                    self.all_stages().zip(&at.parent).map(|(stage, parent)| parent * stage.nominal.translation.vector);
                se3::twist(&(into_tool * moved.sum::<Vector3<f64>>()), &Vector3::zeros())
            }
            Column::SegmentStrain(k) => {
                let moved = self.all_stages().zip(&at.parent).flat_map(|(stage, parent)| {
                    let shares = stage.shares.iter().filter(move |(segment, _)| *segment == k);
                    shares.map(move |(_, share)| parent * share)
                });
                se3::twist(&(into_tool * moved.sum::<Vector3<f64>>()), &Vector3::zeros())
            }
            Column::JointOffset(i) => -at.joints[i],
            Column::JointCompliance(i) => at.joints[i] * at.torques[i],
            Column::JointOrigin(i, k) => {
                let local: Twist = self.stages[i].right_jacobian.column(k).into();
                let w = at.rotation[i] * se3::angular(&local);
                let v = at.rotation[i] * se3::linear(&local) + w.cross(&(tool - at.position[i]));
                se3::twist(&(into_tool * v), &(into_tool * w))
            }
            Column::Tool(k) => self.tool_jacobian.column(k).into(),
            Column::JointDrift(..) | Column::Fixture(..) | Column::Interference(_) | Column::Wall(..) => Twist::zeros(),
        }
    }

    fn all_stages(&self) -> impl Iterator<Item = &Stage> {
        self.stages.iter().chain(std::iter::once(&self.tip))
    }
}

impl Robot {
    /// The calibrated chain: compliances added to the joints', every other parameter of the arm folded into the joint origins.
    ///
    /// An encoder bias folds exactly: `Rot(axis, q − b) = Rot(axis, −b) · Rot(axis, q)`. Tool, fixture and interference
    /// parameters are not the arm's and are left out.
    pub fn calibrated(&self, columns: &[Column], theta: &[f64]) -> Robot {
        let segment_of = segment_of_each_joint(self);
        let sum = |wanted: &dyn Fn(Column) -> bool| -> f64 {
            columns.iter().zip(theta).filter(|(column, _)| wanted(**column)).map(|(_, value)| *value).sum()
        };
        let mut robot = self.clone();
        let mut moving = 0;
        for (joint, segment) in robot.joints_mut().iter_mut().zip(segment_of) {
            let strain = sum(&|column| match column {
                Column::Strain => true,
                Column::SegmentStrain(k) => segment == Some(k),
                _ => false,
            });
            joint.parent_from_joint.translation.vector *= 1.0 + strain;
            if joint.kind == JointKind::Fixed {
                continue;
            }
            let twist = Twist::from_fn(|k, _| sum(&|column| column == Column::JointOrigin(moving, k)));
            let offset = sum(&|column| column == Column::JointOffset(moving));
            joint.parent_from_joint = joint.parent_from_joint * se3::exp(&twist) * bias(joint, offset);
            joint.compliance += sum(&|column| column == Column::JointCompliance(moving));
            moving += 1;
        }
        robot
    }

    /// The chain with its tip moved: the last joint's origin followed by `tip_from_moved_tip`. None if that joint moves: its origin
    /// then lies before its motion, not at the tip.
    pub fn with_tip_moved(&self, tip_from_moved_tip: &Pose) -> Option<Robot> {
        let mut robot = self.clone();
        let last = robot.joints_mut().last_mut().filter(|joint| joint.kind == JointKind::Fixed)?;
        last.parent_from_joint *= *tip_from_moved_tip;
        Some(robot)
    }
}

/// The motion of a moving joint by `−offset`, which stands before its own.
pub(super) fn bias(joint: &Joint, offset: f64) -> Pose {
    if joint.kind == JointKind::Prismatic {
        Pose::translation(-offset * joint.axis.x, -offset * joint.axis.y, -offset * joint.axis.z)
    } else {
        Pose::from_parts(Vector3::zeros().into(), UnitQuaternion::from_axis_angle(&joint.axis, -offset))
    }
}

fn segment_of_each_joint(robot: &Robot) -> Vec<Option<usize>> {
    let mut of = vec![None; robot.joints().len()];
    for (k, segment) in segments(robot).iter().enumerate() {
        for &joint in &segment.joints {
            of[joint] = Some(k);
        }
    }
    of
}

fn to_pose(frame: &Frame) -> Pose {
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame.rotation));
    Pose::from_parts(frame.position.into(), rotation)
}

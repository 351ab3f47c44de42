//! How errors of the parameters move the tool, in the poses in which errors of the tool count.

use nalgebra::{DMatrix, DVector, Matrix6, Vector3};

use crate::estimate::result::ErrorFrame;
use crate::parameter::ParameterId;
use crate::robot::Kinematics;
use crate::se3::{self, Pose, Twist};

/// Share of the largest singular value up to which a motion of the base moves no position.
const ROUNDING: f64 = 1e-9;

/// Derivatives of the tool's pose by parameters, over some poses.
pub(crate) struct ToolMotion {
    /// Six rows for each pose: motion of the tool's origin (m) and rotation vector (rad), both
    /// along the axes of base, by each parameter (SI).
    pub derivatives: DMatrix<f64>,
}

impl ToolMotion {
    /// Derivatives by parameters with these `ids`, in their order, among which those of the arm's
    /// `kinematics` are, at each of the joint `positions`; in `frame`.
    pub fn new(kinematics: &Kinematics, ids: &[ParameterId], positions: &[Vec<f64>], frame: ErrorFrame) -> Self {
        let jacobians = tool_jacobians(kinematics, ids, positions.iter().map(Vec::as_slice));
        let mut derivatives = DMatrix::zeros(6 * positions.len(), ids.len());
        let mut by_base = DMatrix::zeros(6 * positions.len(), 6);
        let poses: Vec<Pose> = positions.iter().map(|q| kinematics.pose(q)).collect();
        let middle = poses.iter().map(|pose| pose.translation.vector).sum::<Vector3<f64>>() / poses.len().max(1) as f64;
        for (k, (jacobian, pose)) in jacobians.iter().zip(&poses).enumerate() {
            let rotation = pose.rotation.to_rotation_matrix();
            for from in [0, 3] {
                derivatives.rows_mut(6 * k + from, 3).copy_from(&(rotation.matrix() * jacobian.rows(from, 3)));
            }
            by_base.rows_mut(6 * k, 6).copy_from(&motion_by_base(&(pose.translation.vector - middle)));
        }
        match frame {
            ErrorFrame::Base => {}
            ErrorFrame::BaseAligned => derivatives -= &by_base * alignment(&by_base, &derivatives),
        }
        ToolMotion { derivatives }
    }

    /// Number of poses.
    fn poses(&self) -> usize {
        self.derivatives.nrows() / 6
    }

    /// Root mean square motion (m) of the tool's origin by a change of the parameters (SI).
    pub fn displacement(&self, change: &DVector<f64>) -> f64 {
        let twists = &self.derivatives * change;
        let squares: f64 = (0..self.poses()).map(|k| twists.rows(6 * k, 3).norm_squared()).sum();
        (squares / self.poses().max(1) as f64).sqrt()
    }

    /// Root mean square standard deviation (m) of the tool's origin, all three components together,
    /// for a covariance of the parameters (SI).
    pub fn deviation(&self, covariance: &DMatrix<f64>) -> f64 {
        let moved = &self.derivatives * covariance;
        let variance = |row: usize| moved.row(row).dot(&self.derivatives.row(row));
        let squares: f64 = (0..self.poses()).flat_map(|k| 6 * k..6 * k + 3).map(variance).sum();
        (squares.max(0.0) / self.poses().max(1) as f64).sqrt()
    }
}

/// Derivative of the tool's pose (its local twist, m and rad) by parameters with these `ids` (SI),
/// at each of the joint `positions`: 6 rows. The parameters of `kinematics` are among them, in
/// their order; columns of what moves neither arm nor tool are zero.
pub(crate) fn tool_jacobians<'q>(
    kinematics: &Kinematics,
    ids: &[ParameterId],
    positions: impl Iterator<Item = &'q [f64]>,
) -> Vec<DMatrix<f64>> {
    let mut scratch = kinematics.scratch();
    let mut jacobian = |q: &[f64]| {
        kinematics.pose_and_jacobian(q, &mut scratch);
        let mut of_kinematics = scratch.parameters.iter();
        let columns = ids.iter().map(|id| match id {
            ParameterId::Kinematic(_) => of_kinematics.next().copied().unwrap_or_default(),
            ParameterId::EncoderError(i, term) => scratch.joints[*i] * -term.error(q[*i]),
            _ => Twist::zeros(),
        });
        let entries: Vec<f64> = columns.flat_map(<[f64; 6]>::from).collect();
        DMatrix::from_vec(6, ids.len(), entries)
    };
    positions.map(&mut jacobian).collect()
}

/// Motion of a tool at `place` (m) by one of base, translation and rotation vector about the origin
/// of `place`.
fn motion_by_base(place: &Vector3<f64>) -> Matrix6<f64> {
    let mut motion = Matrix6::identity();
    motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-se3::skew(place));
    motion
}

/// The motions of base, one for each column of `derivatives`, that come closest to the motions of
/// the tool's origin in squares; those of least size where some of base do not move it.
fn alignment(by_base: &DMatrix<f64>, derivatives: &DMatrix<f64>) -> DMatrix<f64> {
    let rows: Vec<usize> = (0..by_base.nrows()).filter(|row| row % 6 < 3).collect();
    let (of_base, of_tool) = (by_base.select_rows(&rows), derivatives.select_rows(&rows));
    let negligible = ROUNDING * of_base.norm();
    of_base.svd(true, true).solve(&of_tool, negligible).unwrap_or_else(|_| DMatrix::zeros(6, derivatives.ncols()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameter::joint_offset;
    use crate::robot::{Joint, JointKind, Robot};

    /// Three joints about z and y, links of 0.5 m, over a grid of positions.
    fn motion(frame: ErrorFrame) -> ToolMotion {
        let joint = |name: &str, axis: Vector3<f64>, x: f64| Joint {
            name: name.to_owned(),
            child_link: format!("after {name}"),
            kind: JointKind::Revolute,
            parent_from_joint: Pose::translation(x, 0.0, 0.0),
            axis: nalgebra::Unit::new_normalize(axis),
            limits: None,
            compliance: 0.0,
            backlash: 0.0,
            inertia: None,
        };
        let joints = vec![joint("a", Vector3::z(), 0.0), joint("b", Vector3::y(), 0.5), joint("c", Vector3::y(), 0.5)];
        let robot = Robot::new("arm", "base", joints).expect("an arm");
        let ids: Vec<ParameterId> = joint_offset(&robot).iter().map(|parameter| parameter.id).collect();
        let columns: Vec<_> = ids.iter().filter_map(|id| id.kinematic()).collect();
        let kinematics = Kinematics::new(&robot, &columns, Pose::translation(0.5, 0.0, 0.0));
        let turn = |k: usize| -1.0 + f64::from(k as u8);
        let positions: Vec<Vec<f64>> = (0..27).map(|k| vec![turn(k % 3), turn(k / 3 % 3), turn(k / 9)]).collect();
        ToolMotion::new(&kinematics, &ids, &positions, frame)
    }

    /// An offset of the first joint moves the tool with the whole arm, which locating the base
    /// takes away; one of the last joint moves it by its 0.5 m in base, and locating takes some of
    /// that away.
    #[test]
    fn motion_of_the_whole_arm_counts_in_base_alone() {
        let [base, aligned] = [ErrorFrame::Base, ErrorFrame::BaseAligned].map(motion);
        let offset = |k: usize| DVector::from_fn(3, |row, _| if row == k { 1e-3 } else { 0.0 });
        assert!(base.displacement(&offset(0)) > 0.5e-3);
        assert!(aligned.displacement(&offset(0)) < 1e-12, "{}", aligned.displacement(&offset(0)));
        assert!((base.displacement(&offset(2)) - 0.5e-3).abs() < 1e-12);
        let left = aligned.displacement(&offset(2));
        assert!(left > 0.1e-3 && left < 0.5e-3, "{left}");
        let covariance = offset(2) * offset(2).transpose();
        assert!((aligned.deviation(&covariance) - left).abs() < 1e-12);
    }

    /// Of a common translation nothing is left, and it is not taken for a rotation.
    #[test]
    fn a_translation_of_base_is_aligned_without_rotation() {
        let places = [Vector3::new(1.0, 0.2, 0.1), Vector3::new(1.1, -0.3, 0.4), Vector3::new(0.9, 0.1, -0.2)];
        let middle = places.iter().sum::<Vector3<f64>>() / 3.0;
        let mut by_base = DMatrix::zeros(18, 6);
        let mut moved = DMatrix::zeros(18, 1);
        for (k, place) in places.iter().enumerate() {
            by_base.rows_mut(6 * k, 6).copy_from(&motion_by_base(&(place - middle)));
            moved[(6 * k + 1, 0)] = 1e-3;
        }
        let base = alignment(&by_base, &moved);
        let expected = DMatrix::from_column_slice(6, 1, &[0.0, 1e-3, 0.0, 0.0, 0.0, 0.0]);
        assert!((&base - expected).amax() < 1e-12, "{base}");
    }
}

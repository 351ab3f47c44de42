//! Errors of the tool relative to the true arm.

use std::path::Path;

use touchcal::estimate::{Problem, workspace_configurations};
use touchcal::experiment::{PoseErrors, pose_errors};
use touchcal::io::truth_file;
use touchcal::robot::Kinematics;
use touchcal::se3::Pose;

use crate::failure::Failure;
use crate::summary::millimetres;
use crate::table::{Table, fixed};

/// Configurations over the workspace at which poses are compared.
const CONFIGURATIONS: usize = 1000;

/// The true arm.
pub struct TrueArm {
    /// Joint positions (rad, m).
    positions: Vec<Vec<f64>>,
    /// True poses `base_from_tool` there.
    poses: Vec<Pose>,
}

impl TrueArm {
    /// The arm and tool of `problem` with the errors in a file.
    pub fn read(path: &Path, problem: &Problem) -> Result<Self, Failure> {
        let (parameters, values) = truth_file::read_file(path, &problem.robot)?;
        let mut kinematics = Kinematics::new(&problem.robot, &parameters, problem.tool.tip_from_tool);
        kinematics.set(&values);
        let positions = workspace_configurations(&problem.robot, CONFIGURATIONS);
        let poses = positions.iter().map(|q| kinematics.pose(q)).collect();
        Ok(TrueArm { positions, poses })
    }

    /// Errors of the arm and tool of `problem`.
    pub fn errors_of(&self, problem: &Problem) -> PoseErrors {
        let kinematics = Kinematics::new(&problem.robot, &[], problem.tool.tip_from_tool);
        let poses: Vec<Pose> = self.positions.iter().map(|q| kinematics.pose(q)).collect();
        pose_errors(&self.poses, &poses)
    }
}

/// A table of errors with the nominal and the given arm.
pub fn text([nominal, given]: &[PoseErrors; 2]) -> String {
    let mut table = Table::new(["", "nominal: rms", "max", "given: rms", "max", "unit"]);
    let mut row = |name: &str, of: fn(&PoseErrors) -> [f64; 2], unit: &str| {
        let numbers = [nominal, given].map(of).concat();
        let shown = |value: f64| if unit == "mm" { millimetres(value) } else { fixed(value.to_degrees(), 4) };
        let numbers = numbers.into_iter().map(shown);
        table.row([name.to_owned()].into_iter().chain(numbers).chain([unit.to_owned()]));
    };
    row("position in base", |errors| [errors.position.rms, errors.position.max], "mm");
    row("rotation in base", |errors| [errors.angle.rms, errors.angle.max], "deg");
    row("position, base aligned", |errors| [errors.aligned_position.rms, errors.aligned_position.max], "mm");
    row("rotation, base aligned", |errors| [errors.aligned_angle.rms, errors.aligned_angle.max], "deg");
    row("distance of two positions", |errors| [errors.distance.rms, errors.distance.max], "mm");
    format!(
        "Error of the tool relative to the true arm, at {CONFIGURATIONS} configurations over the workspace\n{table}\n"
    )
}

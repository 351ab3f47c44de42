//! Errors of the tool relative to the true arm.

use std::path::Path;

use touchcal::estimate::{Problem, workspace_configurations};
use touchcal::experiment::{PoseErrors, RmsAndMax, pose_errors};
use touchcal::io::Input;
use touchcal::io::truth_file::{self, TruthFile};
use touchcal::parameter::Unit;
use touchcal::report::ToolError;
use touchcal::report::fixed;
use touchcal::robot::Kinematics;
use touchcal::se3::Pose;

use crate::failure::Failure;
use crate::summary::millimetres;
use crate::table::Table;

/// Configurations over the workspace at which poses are compared.
const CONFIGURATIONS: usize = 1000;

/// The true arm.
pub struct TrueArm {
    /// Joint positions (rad, m).
    positions: Vec<Vec<f64>>,
    /// True poses `base_from_tool` there.
    poses: Vec<Pose>,
    /// The file with its fingerprint.
    pub input: Input,
}

impl TrueArm {
    /// The arm and tool of `problem` with the errors in a file.
    pub fn read(path: &Path, problem: &Problem) -> Result<Self, Failure> {
        let TruthFile { parameters, values, input } = truth_file::read_file(path, &problem.robot)?;
        let mut kinematics = Kinematics::new(&problem.robot, &parameters, problem.tool.tip_from_tool);
        kinematics.set(&values);
        let positions = workspace_configurations(&problem.robot, CONFIGURATIONS);
        let poses = positions.iter().map(|q| kinematics.pose(q)).collect();
        Ok(TrueArm { positions, poses, input })
    }

    /// Errors of the arm and tool of `problem`.
    pub fn errors_of(&self, problem: &Problem) -> PoseErrors {
        let kinematics = Kinematics::new(&problem.robot, &[], problem.tool.tip_from_tool);
        let poses: Vec<Pose> = self.positions.iter().map(|q| kinematics.pose(q)).collect();
        pose_errors(&self.poses, &poses)
    }
}

/// Errors with the nominal and the given arm, a row each.
pub fn rows([nominal, given]: &[PoseErrors; 2]) -> Vec<ToolError> {
    let row = |name: &'static str, unit: Unit, of: fn(&PoseErrors) -> RmsAndMax| {
        let [nominal, given] = [nominal, given].map(of).map(|errors| [errors.rms, errors.max]);
        ToolError { name, unit, nominal, given }
    };
    vec![
        row("position in base", Unit::Meter, |errors| errors.position),
        row("rotation in base", Unit::Radian, |errors| errors.angle),
        row("position, base aligned", Unit::Meter, |errors| errors.aligned_position),
        row("rotation, base aligned", Unit::Radian, |errors| errors.aligned_angle),
        row("distance of two positions", Unit::Meter, |errors| errors.distance),
    ]
}

/// A table of errors with the nominal and the given arm.
pub fn text(errors: &[PoseErrors; 2]) -> String {
    let mut table = Table::new(["", "nominal: rms", "max", "given: rms", "max", "unit"]);
    for ToolError { name, unit, nominal, given } in rows(errors) {
        let shown = |value: f64| if unit == Unit::Meter { millimetres(value) } else { fixed(value.to_degrees(), 4) };
        let numbers = [nominal, given].concat().into_iter().map(shown);
        let (_, symbol, _) = unit.in_user_units();
        table.row([name.to_owned()].into_iter().chain(numbers).chain([symbol.to_owned()]));
    }
    format!(
        "Error of the tool relative to the true arm, at {CONFIGURATIONS} configurations over the workspace\n{table}\n"
    )
}

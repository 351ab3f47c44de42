//! `touchcal compare`.

mod calibration;
mod json;
mod text;

use touchcal::estimate::{Comparison, ParameterPosterior, compare, workspace_configurations};
use touchcal::experiment::{PoseErrors, pose_errors};
use touchcal::io::estimate_file::Status;
use touchcal::io::urdf;
use touchcal::parameter::Block;
use touchcal::robot::Kinematics;
use touchcal::se3::Pose;

use crate::args::CompareArgs;
use crate::failure::{Failure, Outcome};
use crate::output;
use calibration::Calibration;

/// Blocks of the arm's own parameters: not those of one log.
const ARM: [Block; 6] = [
    Block::Strain,
    Block::SegmentStrain,
    Block::JointOffset,
    Block::JointHarmonic,
    Block::JointOrigin,
    Block::JointCompliance,
];
/// Difference of the numbers of two nominal poses of a tool that is rounding.
const ROUNDING: f64 = 1e-9;
/// Configurations over the workspace at which poses are compared.
const CONFIGURATIONS: usize = 1000;

/// Reads two calibrations, prints what changed between them.
pub fn run(args: &CompareArgs) -> Result<Outcome, Failure> {
    let both = [Calibration::read(&args.earlier)?, Calibration::read(&args.later)?];
    let [earlier, later] = &both;
    match (&earlier.file.robot, &later.file.robot) {
        (Some(robot), Some(_)) => later.file.check_robot(robot, &later.name())?,
        _ => output::diagnostic("note: a file of an earlier version does not say of which robot it is"),
    }
    let posteriors = [earlier.posterior()?, later.posterior()?];
    let changes = Changes {
        arm: changes_of(&posteriors, &ARM),
        tool: has_same_tool(&both).then(|| changes_of(&posteriors, &[Block::Tool])),
        tip_motion: tip_motion(&both)?,
        common_logs: earlier.logs_in_common(later),
    };
    if changes.arm.parameters.is_empty() {
        return Err(Failure::NothingInCommon([earlier, later].map(Calibration::name)));
    }
    output::print(&if args.json { json::of(&both, &changes)? } else { text::of(&both, &changes, args.all) })?;
    let unusable = both.iter().find(|calibration| calibration.file.status == Status::NotUsable);
    Ok(unusable.map_or(Outcome::Done, |calibration| {
        output::diagnostic(&format!(
            "the calibration of {} is not usable: the comparison is not either",
            calibration.name()
        ));
        Outcome::NotUsable
    }))
}

/// What changed between two calibrations.
struct Changes {
    /// In the arm.
    arm: Comparison,
    /// In how the tool is mounted, where both have the same nominal pose for it.
    tool: Option<Comparison>,
    /// How far the tip moves at equal joint positions, where both calibrations have a URDF.
    tip_motion: Option<PoseErrors>,
    /// Logs from which both were made.
    common_logs: Vec<String>,
}

fn has_same_tool([earlier, later]: &[Calibration; 2]) -> bool {
    let (Some(first), Some(second)) = (earlier.file.tip_from_tool, later.file.tip_from_tool) else { return false };
    first.iter().zip(second).all(|(a, b)| (a - b).abs() < ROUNDING)
}

fn changes_of([earlier, later]: &[ParameterPosterior; 2], blocks: &[Block]) -> Comparison {
    compare(earlier, later, |name| blocks.iter().any(|block| name.split('.').next() == Some(block.name())))
}

/// The distances between the poses of both calibrated tips over the workspace, of arms that stand
/// upright.
fn tip_motion([earlier, later]: &[Calibration; 2]) -> Result<Option<PoseErrors>, Failure> {
    let (Some(first), Some(second)) = (earlier.robot()?, later.robot()?) else { return Ok(None) };
    urdf::check_like(&first, &second, &later.name())?;
    let positions = workspace_configurations(&first, CONFIGURATIONS);
    let [first, second] = [first, second].map(|robot| {
        let kinematics = Kinematics::new(&robot, &[], Pose::identity());
        positions.iter().map(|q| kinematics.pose(q)).collect::<Vec<Pose>>()
    });
    Ok(Some(pose_errors(&first, &second)))
}

//! What changed between two calibrations that were written.

use crate::estimate::{Comparison, ParameterPosterior, compare, workspace_configurations};
use crate::experiment::{PoseErrors, pose_errors};
use crate::io::base::error::IoError;
use crate::io::result::saved_calibration::SavedCalibration;
use crate::io::robot::urdf;
use crate::parameter::Block;
use crate::robot::Kinematics;
use crate::se3::Pose;

/// Blocks of the arm's own parameters: not those of one log.
const ARM: [Block; 9] = [
    Block::Strain,
    Block::SegmentStrain,
    Block::JointOffset,
    Block::JointHarmonic,
    Block::JointHarmonic2,
    Block::JointGearRatio,
    Block::JointOrigin,
    Block::JointCompliance,
    Block::JointBacklash,
];
/// Difference of the numbers of two nominal poses of a tool that is rounding.
const ROUNDING: f64 = 1e-9;
/// Most names in a note.
const MOST_NAMES: usize = 6;
/// Configurations over the workspace at which poses are compared.
const CONFIGURATIONS: usize = 1000;

/// What changed between two calibrations of one arm.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationChanges {
    /// In the arm.
    pub arm: Comparison,
    /// In how the tool is mounted; `None` unless both have the same nominal pose for it.
    pub tool: Option<Comparison>,
    /// How far the tip moves at equal joint positions across the workspace, of arms that stand
    /// upright; `None` unless both have a URDF.
    pub tip_motion: Option<PoseErrors>,
    /// Paths of the logs from which both were made.
    pub common_logs: Vec<String>,
    /// Whether joints deflect by measured torques in one of them and by gravity and load in the
    /// other; `None` if neither estimates a deflection, or one has no URDF.
    pub other_torques: Option<bool>,
}

impl CalibrationChanges {
    /// From the earlier to the later one of two calibrations, whose posteriors these are.
    ///
    /// # Errors
    /// As [`EstimateFile::check_robot`](crate::io::estimate_file::EstimateFile::check_robot) and
    /// [`urdf::check_like`]: they are of two arms.
    pub fn new(both: [&SavedCalibration; 2], posteriors: &[ParameterPosterior; 2]) -> Result<Self, IoError> {
        let [earlier, later] = both;
        earlier.file.robot.as_ref().map_or(Ok(()), |robot| later.file.check_robot(robot, &later.name))?;
        let arm = changes_of(posteriors, &ARM);
        Ok(CalibrationChanges {
            other_torques: other_torques(both, &arm),
            arm,
            tool: has_same_tool(both).then(|| changes_of(posteriors, &[Block::Tool])),
            tip_motion: tip_motion(both)?,
            common_logs: earlier.logs_in_common(later),
        })
    }

    /// What to keep in mind about the comparison, each with an advice.
    pub fn notes(&self) -> Vec<(String, &'static str)> {
        let mut notes = Vec::new();
        if !self.arm.only_in_one.is_empty() {
            let names = list_shortened(&self.arm.only_in_one);
            let words = format!(
                "only one calibration estimates {names}: what that one finds there, the other finds elsewhere, and both then differ without a change of the arm"
            );
            notes.push((words, "estimate the same parameters in both"));
        }
        if self.other_torques == Some(true) {
            let words = "one calibration has compliances and backlashes under measured joint torques, the other under torques of gravity and load: they differ without a change of the arm, and the tip's motion is without deflections of either".to_owned();
            notes.push((words, "calibrate both with `tau_joint`, or both without"));
        }
        if !self.common_logs.is_empty() {
            let words = format!(
                "both calibrations read {}: their errors are correlated, so that the standard deviations of changes are too large",
                list_shortened(&self.common_logs)
            );
            notes.push((words, "compare calibrations that were made from different logs"));
        }
        notes
    }
}

/// The first names of a list, and how many more there are.
fn list_shortened(names: &[String]) -> String {
    let shown = names.iter().take(MOST_NAMES).cloned().collect::<Vec<String>>().join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

fn has_same_tool([earlier, later]: [&SavedCalibration; 2]) -> bool {
    let (Some(first), Some(second)) = (earlier.file.tip_from_tool, later.file.tip_from_tool) else { return false };
    first.iter().zip(second).all(|(a, b)| (a - b).abs() < ROUNDING)
}

fn other_torques([earlier, later]: [&SavedCalibration; 2], arm: &Comparison) -> Option<bool> {
    let is_deflection = |name: &str| {
        let block = name.split('.').next();
        [Block::JointCompliance, Block::JointBacklash].iter().any(|of| block == Some(of.name()))
    };
    let compared = arm.parameters.iter().map(|change| &change.name).chain(&arm.only_in_one);
    let [first, second] = [earlier.urdf.as_ref()?, later.urdf.as_ref()?].map(|urdf| urdf.robot.has_measured_torques());
    compared.into_iter().any(|name| is_deflection(name)).then_some(first != second)
}

fn changes_of([earlier, later]: &[ParameterPosterior; 2], blocks: &[Block]) -> Comparison {
    compare(earlier, later, |name| blocks.iter().any(|block| name.split('.').next() == Some(block.name())))
}

fn tip_motion([earlier, later]: [&SavedCalibration; 2]) -> Result<Option<PoseErrors>, IoError> {
    let (Some(first), Some(second)) = (&earlier.urdf, &later.urdf) else { return Ok(None) };
    urdf::check_like(&first.robot, &second.robot, &later.name)?;
    let positions = workspace_configurations(&first.robot, CONFIGURATIONS);
    let [first, second] = [first, second].map(|urdf| {
        let kinematics = Kinematics::new(&urdf.robot, &[], Pose::identity());
        positions.iter().map(|q| kinematics.pose(q)).collect::<Vec<Pose>>()
    });
    Ok(Some(pose_errors(&first, &second)))
}

//! `truth.json` of a simulation, read back: the true arm and tool.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::tool_pose::{self, of_seven};
use crate::parameter::{Block, encoder_errors, joint_offset, kinematic_part, of_arm_and_tool, strain};
use crate::robot::{EncoderTerm, KinematicParameter, Robot};
use crate::se3::Pose;

/// Largest size of the file (bytes).
pub const MAX_BYTES: u64 = 1 << 20;

/// What is read of the file: of a simulation, or of a recorded trial.
#[derive(Deserialize)]
struct TruthEntries {
    /// Values (SI) by name.
    parameters: Option<BTreeMap<String, f64>>,
    /// Declared pose of the tool, which its errors are relative to.
    tip_from_tool: Option<[f64; 7]>,
    /// Strain (1).
    r: Option<f64>,
    /// Encoder offsets (rad), base first.
    b_rad: Option<Vec<f64>>,
}

impl TruthEntries {
    /// Values (SI) by name; `None` if the file has neither them nor an offset of each joint.
    fn by_name(self, robot: &Robot) -> Option<BTreeMap<String, f64>> {
        let recorded = || {
            let offsets = joint_offset(robot);
            let values = self.b_rad.filter(|values| values.len() == offsets.len())?;
            let names = std::iter::once(strain()).chain(offsets).map(|parameter| parameter.name);
            Some(names.zip(std::iter::once(self.r?).chain(values)).collect())
        };
        self.parameters.or_else(recorded)
    }
}

/// True errors of arm and tool, and of what else was simulated.
#[derive(Clone, Debug)]
pub struct TruthFile {
    /// Parameters of the robot's kinematics.
    pub parameters: Vec<KinematicParameter>,
    /// Their values (SI).
    pub values: Vec<f64>,
    /// Declared pose of the tool, which its errors are relative to; `None` in recorded trials and
    /// in files of earlier versions.
    pub tip_from_tool: Option<Pose>,
    /// Errors of encoders that depend on the position: index of the moving joint, base first, term,
    /// and amplitude (SI).
    pub encoder_errors: Vec<(usize, EncoderTerm, f64)>,
    /// All values of the file (SI) by the names of the parameters, those of fixtures, edges, wrench
    /// and trends too.
    pub by_name: BTreeMap<String, f64>,
    /// The file with its fingerprint.
    pub input: Input,
}

impl TruthFile {
    /// Checks that the tool of a problem is declared as in the simulation. Files without the pose
    /// pass.
    ///
    /// # Errors
    /// [`IoError`] if it is at another pose: the errors would be applied to the wrong one.
    pub fn check_tool(&self, tip_from_tool: &Pose) -> Result<(), IoError> {
        let Some(nominal) = &self.tip_from_tool else { return Ok(()) };
        let whose = format!("as in the simulation, since the truth in {} is relative to it", self.input.path);
        tool_pose::check_same(nominal, tip_from_tool, &whose)
    }
}

/// True errors of arm and tool of `robot`, as [`truth_text`](super::scenario_file::truth_text)
/// writes them, or as a recorded trial has them ([`trial_folder`](crate::io::trial_folder)). Those
/// of fixtures, parts and measured wrenches, and encoder offsets that change over the log, are in
/// [`TruthFile::by_name`] alone.
///
/// # Errors
/// [`IoError`] if the file cannot be read, is larger than [`MAX_BYTES`] or not of this form, or a
/// parameter is not of this robot.
pub fn read_file(path: &Path, robot: &Robot) -> Result<TruthFile, IoError> {
    let (text, input) = bytes::read_text(path, MAX_BYTES)?;
    let place = || Place::file(&input.path);
    let truth: TruthEntries =
        serde_json::from_str(&text).map_err(|error| IoError::syntax(place(), error.to_string()))?;
    let tip_from_tool = truth.tip_from_tool.map(of_seven);
    let by_name = truth.by_name(robot).ok_or_else(|| {
        let expected =
            "`parameters`, as of a simulation, or `r` and `b_rad` with an offset of each joint, as of a recorded trial";
        IoError::unexpected(place(), expected, "neither")
    })?;
    let known = of_arm_and_tool(robot);
    let encoder_errors = encoder_errors(robot, |name| by_name.get(name).copied());
    let of_others = [
        Block::JointHarmonic,
        Block::JointHarmonic2,
        Block::JointGearRatio,
        Block::Fixture,
        Block::EdgeRadius,
        Block::WrenchBias,
        Block::WrenchScale,
        Block::JointTrend,
    ];
    let mut found = Vec::new();
    for (name, &value) in &by_name {
        let block = name.split('.').next().unwrap_or_default();
        match known.iter().find(|parameter| parameter.name == *name) {
            Some(parameter) => found.push((parameter.id, value)),
            None if of_others.iter().any(|other| other.name() == block) => {}
            None => {
                let expected = format!("a parameter of the robot {}", quoted(robot.name()));
                return Err(IoError::unexpected(place().field("parameters"), expected, quoted(name)));
            }
        }
    }
    let (parameters, values) = kinematic_part(found);
    Ok(TruthFile { parameters, values, tip_from_tool, encoder_errors, by_name, input })
}

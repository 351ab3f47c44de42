//! `truth.json` of a simulation, read back: the true arm and tool.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place, quoted};
use crate::parameter::{Block, kinematic_part, of_arm_and_tool};
use crate::robot::{KinematicParameter, Robot};

/// Largest size of the file (bytes).
pub const MAX_BYTES: u64 = 1 << 20;

/// What is read of the file.
#[derive(Deserialize)]
struct TruthEntries {
    /// Values (SI) by name.
    parameters: BTreeMap<String, f64>,
}

/// True errors of arm and tool, and of what else was simulated.
#[derive(Clone, Debug)]
pub struct TruthFile {
    /// Parameters of the robot's kinematics.
    pub parameters: Vec<KinematicParameter>,
    /// Their values (SI).
    pub values: Vec<f64>,
    /// All values of the file (SI) by the names of the parameters, those of fixtures, edges, wrench
    /// and trends too.
    pub by_name: BTreeMap<String, f64>,
    /// The file with its fingerprint.
    pub input: Input,
}

/// True errors of arm and tool of `robot`, as [`truth_text`](super::scenario_file::truth_text)
/// writes them. Those of fixtures, parts and measured wrenches, and encoder offsets that change
/// over the log, are in [`TruthFile::by_name`] alone.
///
/// # Errors
/// [`IoError`] if the file cannot be read, is larger than [`MAX_BYTES`] or not of this form, or a
/// parameter is not of this robot.
pub fn read_file(path: &Path, robot: &Robot) -> Result<TruthFile, IoError> {
    let (text, input) = bytes::read_text(path, MAX_BYTES)?;
    let place = || Place::file(&input.path);
    let truth: TruthEntries =
        serde_json::from_str(&text).map_err(|error| IoError::syntax(place(), error.to_string()))?;
    let known = of_arm_and_tool(robot);
    let of_others = [Block::Fixture, Block::EdgeRadius, Block::WrenchBias, Block::WrenchScale, Block::JointTrend];
    let mut found = Vec::new();
    for (name, &value) in &truth.parameters {
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
    Ok(TruthFile { parameters, values, by_name: truth.parameters, input })
}

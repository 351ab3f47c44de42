//! URDF: the robot's kinematics, read into a [`Robot`], and a calibrated robot written back into
//! the same text.
//!
//! Only what a serial chain needs is read: joints with their kind, origin, axis and limits, their
//! links' masses, the joints' compliance, `<touchcal_compliance rad_per_nm="…"/>`, and backlash,
//! `<touchcal_backlash half="…"/>`, with `torque="measured"` where they belong to measured joint
//! torques: elements of our own that other readers of URDF pass over. Meshes, transmissions and
//! vendor elements are left alone, when reading and when writing.

mod document;
mod edit;
mod numbers;
mod read;
mod transmission;
mod weight;
mod write;
mod xacro;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place};
use crate::io::base::suggest;
use crate::robot::{Robot, builtin};

pub(crate) use numbers::{roll_pitch_yaw, written};
pub use read::Ends;
pub use transmission::with_transmission_offsets;
pub use write::rewrite;
pub use xacro::xacro_macro;

/// Largest URDF read (bytes), 64 MiB. Those of whole humanoids have about 1 MB.
pub const MAX_BYTES: u64 = 64 << 20;

/// A kinematic chain with the text of the URDF it was read from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UrdfFile {
    /// The chain, in m, rad and kg; its gravity is not from the text.
    pub robot: Robot,
    /// The whole text of the URDF.
    pub text: String,
    /// Path and fingerprint of the file, for provenance; for a built-in arm the path is
    /// `builtin:NAME`.
    pub input: Input,
}

/// Reads the chain between `ends` from URDF text; `file` is its name for messages. The text does
/// not state gravity: it is [`GRAVITY`](crate::robot::GRAVITY).
///
/// # Errors
/// [`IoError`] if the text is no URDF, has unexpanded xacro, names a link or joint twice or a link
/// that it lacks, or has a link below two joints; if the chain cannot be found, is ambiguous, is
/// longer than 1000 joints, or has no moving joint; or if a joint in it is of an unsupported kind,
/// mimics another, or has a malformed origin, axis, limit, compliance or link mass, or one beyond
/// ±1000 m, rad, kg or rad/(N m) (limits of joints are cut there).
pub fn read(text: &str, file: &str, ends: Ends<'_>) -> Result<Robot, IoError> {
    read::robot(text, file, ends)
}

/// Reads the chain between `ends` from the bytes of a URDF; `file` is its name for messages.
///
/// # Errors
/// As [`read`], and if there are more than [`MAX_BYTES`] or they are not UTF-8.
pub fn read_bytes(content: &[u8], file: &str, ends: Ends<'_>) -> Result<Robot, IoError> {
    bytes::check_size(content.len() as u64, MAX_BYTES, file)?;
    read(bytes::text_from(content, file)?, file, ends)
}

/// Reads the chain between `ends` from a URDF file.
///
/// # Errors
/// As [`read_bytes`], and if the file cannot be read, or is of a calibration whose writing was
/// interrupted.
pub fn read_file(path: &Path, ends: Ends<'_>) -> Result<UrdfFile, IoError> {
    let (text, input) = bytes::read_text(path, MAX_BYTES)?;
    let robot = read(&text, &input.path, ends)?;
    Ok(UrdfFile { robot, text, input })
}

/// Reads from another URDF the chain between the links that `robot` has as base and tip, and gives
/// it the gravity of `robot`.
///
/// # Errors
/// As [`read_file`], if one of the links is missing, and as [`check_like`].
pub fn read_like(robot: &Robot, path: &Path) -> Result<UrdfFile, IoError> {
    let mut other = read_file(path, Ends { base: Some(robot.base()), tip: Some(robot.tip()) })?;
    check_like(robot, &other.robot, &other.input.path)?;
    other.robot = other.robot.with_gravity(*robot.gravity());
    Ok(other)
}

/// Checks that `other`, read from `file`, has moving joints of the same names in the same order as
/// `robot`. Kinds of joints, fixed joints and origins may differ.
///
/// # Errors
/// [`IoError::Unexpected`] if it has not.
pub fn check_like(robot: &Robot, other: &Robot, file: &str) -> Result<(), IoError> {
    let names = |robot: &Robot| robot.moving().map(|joint| joint.name.clone()).collect::<Vec<_>>().join(", ");
    let (expected, found) = (names(robot), names(other));
    if expected == found {
        return Ok(());
    }
    Err(IoError::unexpected(Place::file(file), format!("the moving joints {expected}"), found))
}

/// Reads one of the arms in [`builtin::ALL`] by its name; its tip is its flange unless `ends` names
/// another link.
///
/// # Errors
/// [`IoError::Unexpected`] if there is no such arm, no such link in it, or no chain between the
/// ends.
pub fn read_builtin(name: &str, ends: Ends<'_>) -> Result<UrdfFile, IoError> {
    let file = format!("builtin:{name}");
    let Some((_, text)) = builtin::ALL.iter().find(|(known, _)| *known == name) else {
        let known = || builtin::ALL.iter().map(|(name, _)| *name);
        let expected = format!("a built-in arm ({})", suggest::list(known()));
        let found = format!("`{name}`{}", suggest::did_you_mean(name, known()));
        return Err(IoError::unexpected(Place::file("builtin"), expected, found));
    };
    let robot = read(text, &file, ends)?;
    Ok(UrdfFile { robot, text: (*text).to_owned(), input: Input::of(file, text) })
}

/// All arms in [`builtin::ALL`], each to its flange.
pub(crate) fn builtin_arms() -> Vec<Robot> {
    builtin::ALL.iter().filter_map(|(name, _)| Some(read_builtin(name, Ends::default()).ok()?.robot)).collect()
}

//! Recorded trials with known truth: a folder for each, with `contact.csv` or `contact.csv.gz`
//! (joint positions in contact, rad) and `truth.json`.
//!
//! Keys of `truth.json` that are read: `r` (strain), `b_rad` (encoder offsets, one for each joint),
//! `T_flange_peg` and `T_base_hole` (each with `position_m` and `quat_wxyz`), `geometry` (must be
//! `"extrusion"`, the 25 mm extrusion in its hole of 1.0 mm clearance).

use std::path::{Path, PathBuf};

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use serde::Deserialize;

use crate::contact::ContactLog;
use crate::experiment::Trial;
use crate::io::base::bytes;
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::log::contact_log;
use crate::robot::{KinematicParameter, Robot};
use crate::se3::Pose;

/// Largest `truth.json` read (bytes).
const MAX_BYTES: u64 = 1 << 20;
/// Most entries of one folder looked at.
const MAX_ENTRIES: usize = 100_000;
/// How far a quaternion's length may be from 1.
const UNIT_TOLERANCE: f64 = 1e-6;

#[derive(Deserialize)]
struct Truth {
    geometry: String,
    r: f64,
    b_rad: Vec<f64>,
    #[serde(rename = "T_flange_peg")]
    flange_from_peg: Placed,
    #[serde(rename = "T_base_hole")]
    base_from_hole: Placed,
}

#[derive(Deserialize)]
struct Placed {
    position_m: [f64; 3],
    quat_wxyz: [f64; 4],
}

impl Placed {
    fn pose(&self, field: &str, file: &str) -> Result<Pose, IoError> {
        let [w, i, j, k] = self.quat_wxyz;
        let quaternion = Quaternion::new(w, i, j, k);
        // The first is false for NaN too.
        let unit = (quaternion.norm() - 1.0).abs() < UNIT_TOLERANCE;
        if !unit || self.position_m.iter().any(|x| !x.is_finite()) {
            let place = Place::file(file).field(field);
            let found = format!("{:?}, {:?}", self.position_m, self.quat_wxyz);
            return Err(IoError::unexpected(place, "a finite position and a unit quaternion", found));
        }
        let rotation = UnitQuaternion::from_quaternion(quaternion);
        Ok(Pose::from_parts(Translation3::from(self.position_m), rotation))
    }
}

/// Reads the trials of all subfolders of `folder` that hold a `truth.json`, recorded with `robot`,
/// sorted by name. Where a subfolder has both `contact.csv.gz` and `contact.csv`, the former is
/// read. Only the first 100 000 entries of `folder` are looked at.
///
/// The contacts are of fixture 0. [`Trial::truth`] lists the strain, then the encoder offsets, base
/// first.
///
/// # Errors
/// [`IoError`] if the folder cannot be read or has no such subfolder; or a trial lacks its log or a
/// key of the truth, has a `truth.json` of more than 1 MiB, other parts, another number of offsets
/// than the robot has moving joints, a position that is not finite, a quaternion whose norm is not
/// 1 within 10⁻⁶, or a log that is none of this arm.
pub fn read(folder: &Path, robot: &Robot) -> Result<Vec<Trial>, IoError> {
    let failed = |source| IoError::file(folder, "list the folder", source);
    let mut folders: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)?.take(MAX_ENTRIES) {
        let path = entry.map_err(failed)?.path();
        if path.join("truth.json").is_file() {
            folders.push(path);
        }
    }
    folders.sort();
    if folders.is_empty() {
        let place = Place::file(folder.display().to_string());
        return Err(IoError::unexpected(place, "subfolders with contact.csv.gz and truth.json", "none"));
    }
    folders.iter().map(|path| read_trial(path, robot)).collect()
}

fn read_trial(folder: &Path, robot: &Robot) -> Result<Trial, IoError> {
    let (text, input) = bytes::read_text(&folder.join("truth.json"), MAX_BYTES)?;
    let place = |field: &str| Place::file(input.path.as_str()).field(field);
    let truth: Truth = serde_json::from_str(&text).map_err(|error| {
        IoError::syntax(Place::file(input.path.as_str()).line(error.line() as u64), error.to_string())
    })?;
    if truth.geometry != "extrusion" {
        let expected = "`extrusion`, the T-slot peg; contacts of other parts need a problem file";
        return Err(IoError::unexpected(place("geometry"), expected, quoted(&truth.geometry)));
    }
    if truth.b_rad.len() != robot.dof() {
        let expected = format!("{} numbers, one for each joint", robot.dof());
        return Err(IoError::unexpected(place("b_rad"), expected, format!("{}", truth.b_rad.len())));
    }
    let mut contacts = ContactLog::new(robot.dof());
    let gzipped = folder.join("contact.csv.gz");
    let log = if gzipped.is_file() { gzipped } else { folder.join("contact.csv") };
    let logged = contact_log::read_file(&log, robot, &contact_log::Options::default(), &mut contacts)?;
    let offsets = truth.b_rad.iter().enumerate().map(|(i, &b)| (KinematicParameter::JointOffset(i).into(), b));
    Ok(Trial {
        name: folder.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
        origin: format!("{} and {}", logged.sha256, input.sha256),
        robot: robot.clone(),
        tip_from_peg: truth.flange_from_peg.pose("T_flange_peg", &input.path)?,
        base_from_hole: truth.base_from_hole.pose("T_base_hole", &input.path)?,
        contacts,
        truth: std::iter::once((KinematicParameter::Strain.into(), truth.r)).chain(offsets).collect(),
    })
}

//! A calibration that was written, read back.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place};
use crate::io::base::manifest::{Manifest, ResultKind};
use crate::io::result::calibration_folder::{CALIBRATED, ESTIMATE};
use crate::io::result::estimate_file::EstimateFile;
use crate::io::robot::urdf::{self, Ends, UrdfFile};

/// A calibration as its files have it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedCalibration {
    /// The path as given.
    pub name: String,
    /// Content of `estimate.json`.
    pub file: EstimateFile,
    /// The calibrated arm, which stands upright, with its text; `None` of an `estimate.json` alone,
    /// of a folder without `calibrated.urdf`, and of an earlier version.
    pub urdf: Option<UrdfFile>,
}

impl SavedCalibration {
    /// Reads the calibration in a folder, or an `estimate.json` alone.
    ///
    /// # Errors
    /// As [`EstimateFile::read_file`] and [`urdf::read_file`], and if one of the files is not what
    /// the folder's manifest lists: it was changed since it was written. Folders of earlier
    /// versions have no manifest, and are not checked.
    pub fn read(path: &Path) -> Result<SavedCalibration, IoError> {
        let name = path.display().to_string();
        if !path.is_dir() {
            return Ok(SavedCalibration { name, file: EstimateFile::read_file(path)?, urdf: None });
        }
        let (file, input) = EstimateFile::read_with_input(&path.join(ESTIMATE))?;
        check_listed(path, ESTIMATE, &input)?;
        let calibrated = path.join(CALIBRATED);
        let robot = file.robot.as_ref().filter(|_| calibrated.exists());
        let ends = robot.map(|robot| Ends { base: Some(&robot.base), tip: Some(&robot.tip) });
        let urdf = ends.map(|ends| urdf::read_file(&calibrated, ends)).transpose()?;
        urdf.as_ref().map_or(Ok(()), |urdf| check_listed(path, CALIBRATED, &urdf.input))?;
        Ok(SavedCalibration { name, file, urdf })
    }

    /// Paths of the logs that `other` was made from too, as this one has them.
    pub fn logs_in_common(&self, other: &SavedCalibration) -> Vec<String> {
        let is_common = |sha256: &String| other.file.inputs.iter().any(|input| input.sha256 == *sha256);
        let common = self.file.inputs.iter().filter(|input| input.is_log && is_common(&input.sha256));
        common.map(|input| input.path.clone()).collect()
    }
}

/// Checks that a file is as the manifest of its folder lists it, if it lists a calibration.
fn check_listed(folder: &Path, name: &str, found: &Input) -> Result<(), IoError> {
    let manifest = Manifest::read(folder)?;
    let Some(listed) = manifest.results.get(&ResultKind::Calibration) else { return Ok(()) };
    if listed.files.get(name).is_some_and(|sha256| *sha256 == found.sha256) {
        return Ok(());
    }
    let expected = "the file that touchcal.json lists, as it was written";
    Err(IoError::unexpected(Place::file(found.path.clone()), expected, "another or a changed one"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_was_changed_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let manifest = |sha256: &str| {
            format!(
                r#"{{"schema": 1, "results": {{"calibration": {{"unfinished": false, "files": {{"estimate.json": "{sha256}"}}}}}}}}"#
            )
        };
        let input = Input::of(folder.path().join(ESTIMATE).display().to_string(), "{}");
        // Without a manifest nothing is known.
        check_listed(folder.path(), ESTIMATE, &input).unwrap();
        std::fs::write(folder.path().join("touchcal.json"), manifest(&input.sha256)).unwrap();
        check_listed(folder.path(), ESTIMATE, &input).unwrap();
        assert!(check_listed(folder.path(), CALIBRATED, &input).is_err());
        std::fs::write(folder.path().join("touchcal.json"), manifest(&Input::of("", "{ }").sha256)).unwrap();
        let error = check_listed(folder.path(), ESTIMATE, &input).unwrap_err().to_string();
        assert!(error.contains("estimate.json") && error.contains("changed"), "{error}");
    }
}

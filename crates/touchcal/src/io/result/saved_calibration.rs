//! A calibration that was written, read back.

use std::ffi::OsStr;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place};
use crate::io::base::manifest::{ListedResult, Manifest, ResultKind};
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
    /// the folder's manifest lists: it is missing, or was changed since it was written. Folders of
    /// earlier versions have no manifest, and are not checked; nor is an `estimate.json` alone that
    /// no manifest beside it lists.
    pub fn read(path: &Path) -> Result<SavedCalibration, IoError> {
        let name = path.display().to_string();
        if !path.is_dir() {
            if path.extension().is_some_and(|extension| extension == "urdf") {
                let expected = "the folder of a calibration, or its estimate.json";
                return Err(IoError::unexpected(Place::file(name), expected, "a URDF"));
            }
            let (file, input) = EstimateFile::read_with_input(path)?;
            check_alone(path, &input)?;
            return Ok(SavedCalibration { name, file, urdf: None });
        }
        let listed = Manifest::read(path)?.results.remove(&ResultKind::Calibration);
        let (file, input) = EstimateFile::read_with_input(&path.join(ESTIMATE))?;
        check_listed(listed.as_ref(), ESTIMATE, &input)?;
        let calibrated = path.join(CALIBRATED);
        // One that is listed and missing is an error of reading it.
        let is_listed = listed.as_ref().is_some_and(|listed| listed.files.contains_key(CALIBRATED));
        let robot = file.robot.as_ref().filter(|_| is_listed || calibrated.exists());
        let ends = robot.map(|robot| Ends { base: Some(&robot.base), tip: Some(&robot.tip) });
        let urdf = ends.map(|ends| urdf::read_file(&calibrated, ends)).transpose()?;
        urdf.as_ref().map_or(Ok(()), |urdf| check_listed(listed.as_ref(), CALIBRATED, &urdf.input))?;
        Ok(SavedCalibration { name, file, urdf })
    }

    /// Paths of the logs that `other` was made from too, as this one has them.
    pub fn logs_in_common(&self, other: &SavedCalibration) -> Vec<String> {
        let is_common = |sha256: &String| other.file.inputs.iter().any(|input| input.sha256 == *sha256);
        let common = self.file.inputs.iter().filter(|input| input.is_log && is_common(&input.sha256));
        common.map(|input| input.path.clone()).collect()
    }
}

/// Checks a file by the manifest beside it, if that lists the file.
fn check_alone(path: &Path, found: &Input) -> Result<(), IoError> {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name().and_then(OsStr::to_str)) else { return Ok(()) };
    // A file of that name that is no manifest is of somebody else.
    let Ok(mut manifest) = Manifest::read(folder) else { return Ok(()) };
    let listed = manifest.results.remove(&ResultKind::Calibration);
    check_listed(listed.filter(|listed| listed.files.contains_key(name)).as_ref(), name, found)
}

/// Checks that a file is as the manifest of its folder lists it, if it lists a calibration.
fn check_listed(listed: Option<&ListedResult>, name: &str, found: &Input) -> Result<(), IoError> {
    let Some(listed) = listed else { return Ok(()) };
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
        let write = |text: &str| std::fs::write(folder.path().join("touchcal.json"), text).unwrap();
        let [path, copy] = [ESTIMATE, "copy.json"].map(|name| folder.path().join(name));
        let input = Input::of(path.display().to_string(), "{}");
        // Without a manifest, and with a file of that name that is none, nothing is known.
        check_alone(&path, &input).unwrap();
        write("another's");
        check_alone(&path, &input).unwrap();
        write(&manifest(&input.sha256));
        check_alone(&path, &input).unwrap();
        let mut read = Manifest::read(folder.path()).unwrap();
        let listed = read.results.remove(&ResultKind::Calibration);
        check_listed(listed.as_ref(), ESTIMATE, &input).unwrap();
        assert!(check_listed(listed.as_ref(), CALIBRATED, &input).is_err());
        write(&manifest(&Input::of("", "{ }").sha256));
        let error = check_alone(&path, &input).unwrap_err().to_string();
        assert!(error.contains("estimate.json") && error.contains("changed"), "{error}");
        // A copy beside it is not listed.
        check_alone(&copy, &input).unwrap();
    }
}

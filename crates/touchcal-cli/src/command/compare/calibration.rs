//! A calibration that is compared.

use std::path::{Path, PathBuf};

use touchcal::estimate::ParameterPosterior;
use touchcal::io::IoError;
use touchcal::io::calibration_folder::{CALIBRATED, ESTIMATE};
use touchcal::io::estimate_file::{EstimateFile, Status};
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::Robot;

use crate::failure::Failure;

/// A calibration that was written.
pub struct Calibration {
    path: PathBuf,
    folder: Option<PathBuf>,
    /// Its estimate.
    pub file: EstimateFile,
}

impl Calibration {
    /// The calibration in a folder, or of an `estimate.json` alone.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let folder = path.is_dir().then(|| path.to_owned());
        let path = folder.as_ref().map_or_else(|| path.to_owned(), |folder| folder.join(ESTIMATE));
        let file = EstimateFile::read_file(&path)?;
        Ok(Calibration { path, folder, file })
    }

    /// The path as given.
    pub fn name(&self) -> String {
        self.folder.as_ref().unwrap_or(&self.path).display().to_string()
    }

    /// Whether it may be used.
    pub fn status(&self) -> &'static str {
        match self.file.status {
            Status::Usable => "usable",
            Status::Doubtful => "doubtful",
            Status::NotUsable => "not_usable",
        }
    }

    /// Estimates and covariance, which a result of gradient descent lacks.
    pub fn posterior(&self) -> Result<ParameterPosterior, Failure> {
        self.file.posterior().ok_or_else(|| Failure::NoUncertainty(self.name()))
    }

    /// The calibrated arm, of a folder that has one.
    pub fn robot(&self) -> Result<Option<Robot>, IoError> {
        let (Some(folder), Some(robot)) = (&self.folder, &self.file.robot) else { return Ok(None) };
        let path = folder.join(CALIBRATED);
        if !path.exists() {
            return Ok(None);
        }
        let ends = Ends { base: Some(&robot.base), tip: Some(&robot.tip) };
        Ok(Some(urdf::read_file(&path, ends)?.robot))
    }

    /// Paths of the logs that `other` was made from too.
    pub fn logs_in_common(&self, other: &Calibration) -> Vec<String> {
        let is_common = |sha256: &String| other.file.inputs.iter().any(|input| input.sha256 == *sha256);
        let common = self.file.inputs.iter().filter(|input| input.is_log && is_common(&input.sha256));
        common.map(|input| input.path.clone()).collect()
    }
}

//! Formats of other programs in which a calibrated arm is written.

use crate::io::base::error::IoError;
use crate::io::problem::loaded::Loaded;
use crate::io::result::export_text::ExportText;
use crate::io::result::{dh_file, ur_kinematics};
use crate::io::robot::urdf;
use crate::robot::Robot;

/// A format of another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Export {
    /// Joint origins for the driver of Universal Robots, [`ur_kinematics`].
    Ur,
    /// Denavit–Hartenberg parameters, [`dh_file`].
    Dh,
    /// A macro of xacro, [`urdf::xacro_macro`].
    Xacro,
}

impl Export {
    /// All of them.
    pub const ALL: [Export; 3] = [Export::Ur, Export::Dh, Export::Xacro];

    /// Name of the format, as users give it.
    pub fn name(self) -> &'static str {
        match self {
            Export::Ur => "ur",
            Export::Dh => "dh",
            Export::Xacro => "xacro",
        }
    }

    /// Name of the file in a calibration's folder.
    pub const fn file_name(self) -> &'static str {
        match self {
            Export::Ur => "ur_kinematics.yaml",
            Export::Dh => "dh.json",
            Export::Xacro => "calibrated.xacro",
        }
    }

    /// The file for `calibrated`, the arm of `loaded` with other numbers.
    ///
    /// # Errors
    /// As [`ur_kinematics::of`], [`urdf::rewrite`] and [`urdf::xacro_macro`].
    pub fn of(self, calibrated: &Robot, loaded: &Loaded) -> Result<ExportText, IoError> {
        match self {
            Export::Ur => ur_kinematics::of(calibrated, &loaded.problem.robot),
            Export::Dh => Ok(dh_file::of(calibrated)),
            Export::Xacro => {
                let text = urdf::xacro_macro(&urdf::rewrite(&loaded.urdf, calibrated)?)?;
                Ok(ExportText { text, left_out: Vec::new() })
            }
        }
    }

    /// Checks that the arm of `loaded` can be written in this format, before it is calibrated.
    ///
    /// # Errors
    /// As [`of`](Export::of).
    pub fn check(self, loaded: &Loaded) -> Result<(), IoError> {
        self.of(&loaded.problem.robot, loaded).map(drop)
    }
}

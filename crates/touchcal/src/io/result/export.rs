//! Formats of other programs in which a calibrated arm is written.

use crate::io::base::error::{IoError, Place};
use crate::io::problem::loaded::Loaded;
use crate::io::result::export_text::ExportText;
use crate::io::result::{dh_file, ur_kinematics};
use crate::io::robot::urdf;
use crate::robot::{Robot, split_offsets};

/// A format of another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Export {
    /// Joint origins for the driver of Universal Robots, [`ur_kinematics`].
    Ur,
    /// Denavit–Hartenberg parameters, [`dh_file`].
    Dh,
    /// A macro of xacro, [`urdf::xacro_macro`].
    Xacro,
    /// A URDF with the encoder offsets in the transmissions of ros2_control instead of the joint
    /// origins, [`urdf::with_transmission_offsets`].
    Ros2Control,
}

impl Export {
    /// All of them.
    pub const ALL: [Export; 4] = [Export::Ur, Export::Dh, Export::Xacro, Export::Ros2Control];

    /// Name of the format, as users give it.
    pub fn name(self) -> &'static str {
        match self {
            Export::Ur => "ur",
            Export::Dh => "dh",
            Export::Xacro => "xacro",
            Export::Ros2Control => "ros2_control",
        }
    }

    /// Name of the file in a calibration's folder.
    pub const fn file_name(self) -> &'static str {
        match self {
            Export::Ur => "ur_kinematics.yaml",
            Export::Dh => "dh.json",
            Export::Xacro => "calibrated.xacro",
            Export::Ros2Control => "ros2_control.urdf",
        }
    }

    /// The file for `calibrated`, the arm of `loaded` with other numbers.
    ///
    /// # Errors
    /// As [`ur_kinematics::of`], [`urdf::rewrite`], [`urdf::xacro_macro`] and
    /// [`urdf::with_transmission_offsets`].
    pub fn of(self, calibrated: &Robot, loaded: &Loaded) -> Result<ExportText, IoError> {
        match self {
            Export::Ur => ur_kinematics::of(calibrated, &loaded.problem.robot),
            Export::Dh => Ok(dh_file::of(calibrated)),
            Export::Xacro => {
                let text = urdf::xacro_macro(&urdf::rewrite(&loaded.urdf, calibrated)?)?;
                Ok(ExportText { text, left_out: Vec::new() })
            }
            Export::Ros2Control => ros2_control(calibrated, loaded),
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

/// The URDF with the encoder offsets in its transmissions.
fn ros2_control(calibrated: &Robot, loaded: &Loaded) -> Result<ExportText, IoError> {
    let nominal = &loaded.problem.robot;
    let Some((robot, offsets)) = split_offsets(calibrated, nominal) else {
        return Err(IoError::unexpected(Place::file(nominal.name()), "the joints of the nominal arm", "others"));
    };
    let names = robot.moving().map(|joint| joint.name.as_str());
    let text = urdf::with_transmission_offsets(&urdf::rewrite(&loaded.urdf, &robot)?, names.zip(offsets))?;
    Ok(ExportText { text, left_out: Vec::new() })
}

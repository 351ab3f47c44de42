//! Arguments of the commands that read a problem: `inspect`, `calibrate`, `evaluate`.

use std::path::PathBuf;

use touchcal::io::Export;

use super::help::{ARM, CONTACTS, ESTIMATION, OUTPUT, examples};

/// Where a problem is read from.
#[derive(Debug, clap::Args)]
pub struct Source {
    /// What to calibrate, with what, from which contacts; `touchcal new` writes one to fill in
    #[arg(value_name = "PROBLEM.toml", required_unless_present = "mukca", conflicts_with = "mukca")]
    pub problem: Option<PathBuf>,
    /// Read only this placement: fixtures named PLACEMENT/… (may be repeated)
    #[arg(long, value_name = "PLACEMENT", help_heading = CONTACTS)]
    pub only: Vec<String>,
    /// Leave this placement out (may be repeated)
    #[arg(long, value_name = "PLACEMENT", help_heading = CONTACTS)]
    pub except: Vec<String>,
    /// Replaced by `touchcal new sockets --from`.
    #[arg(long, value_name = "DIR", hide = true)]
    pub mukca: Option<PathBuf>,
    /// Replaced likewise.
    #[arg(long, value_name = "MM", hide = true, requires = "mukca", conflicts_with = "problem")]
    pub spacing_mm: Option<f64>,
    /// Replaced likewise.
    #[arg(long, value_name = "LINK", hide = true, requires = "mukca", conflicts_with = "problem")]
    pub tip: Option<String>,
}

/// The arm of a folder of logs; replaced by `touchcal new sockets --from`.
#[derive(Debug, Default, clap::Args)]
pub struct Arm {
    /// Replaced.
    #[arg(long, value_name = "FILE", hide = true, requires = "mukca", conflicts_with = "problem")]
    pub urdf: Option<PathBuf>,
    /// Replaced.
    #[arg(long, hide = true, requires = "mukca", conflicts_with = "problem")]
    pub joint_compliance: bool,
}

/// A format of another program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ExportFormat {
    // With doc comments the help of all options would take more lines.
    Ur,
    Dh,
    Xacro,
    #[value(name = "ros2_control")]
    Ros2Control,
}

impl ExportFormat {
    /// The library's name of it.
    pub fn export(self) -> Export {
        match self {
            ExportFormat::Ur => Export::Ur,
            ExportFormat::Dh => Export::Dh,
            ExportFormat::Xacro => Export::Xacro,
            ExportFormat::Ros2Control => Export::Ros2Control,
        }
    }
}

/// Which blocks of parameters are estimated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ModelName {
    // With doc comments the help of all options would take more lines.
    Declared,
    Auto,
}

/// Arguments of `calibrate`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("All results into out/", "touchcal calibrate sim/problem.toml --out out"),
    (
        "Without one placement, on which `evaluate` then tests the result",
        "touchcal calibrate sim/problem.toml --except left --out fitted",
    ),
    (
        "Also the encoder offsets for a driver, and Denavit-Hartenberg parameters",
        "touchcal calibrate sim/problem.toml --driver-offsets --export dh --out out",
    ),
]))]
pub struct CalibrateArgs {
    /// The problem.
    #[command(flatten)]
    pub source: Source,
    /// The arm of a folder, replaced.
    #[command(flatten)]
    pub arm: Arm,
    /// Estimate what the problem leaves out or declares exact where contacts contradict it, and
    /// noise that is larger than declared
    #[arg(long, help_heading = ESTIMATION)]
    pub free_suspects: bool,
    /// Parameters of the arm: those that the problem declares, or (auto) those that `touchcal
    /// select` chooses
    #[arg(
        long,
        value_enum,
        value_name = "MODEL",
        default_value = "declared",
        conflicts_with = "free_suspects",
        help_heading = ESTIMATION
    )]
    pub model: ModelName,
    /// Folder to write calibrated.urdf, estimate.json and report.html into
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub out: PathBuf,
    /// Also write DIR/driver for drivers that apply encoder offsets: joint_offsets.yaml, and the
    /// matching robot.urdf
    #[arg(long, help_heading = OUTPUT)]
    pub driver_offsets: bool,
    /// Also write the arm for other programs (may be repeated); ur: DIR/ur_kinematics.yaml, the
    /// kinematics_params_file of the ROS 2 driver of Universal Robots; dh: DIR/dh.json,
    /// Denavit-Hartenberg parameters; xacro: DIR/calibrated.xacro, the URDF as a macro with a
    /// prefix; ros2_control: DIR/ros2_control.urdf, encoder offsets in its transmissions
    #[arg(long, value_name = "FORMAT", value_delimiter = ',', help_heading = OUTPUT)]
    pub export: Vec<ExportFormat>,
    /// Also write DIR/calibration.mcap for Foxglove and Rerun
    #[cfg(feature = "mcap")]
    #[arg(long, help_heading = OUTPUT)]
    pub mcap: bool,
    /// Print every parameter on a line of its own
    #[arg(long, help_heading = OUTPUT)]
    pub all: bool,
    /// Print estimate.json instead of the summary
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    (
        "On held-out contacts, those of a placement left out of the fit",
        "touchcal evaluate sim/problem.toml --only left \\\n--urdf fitted/calibrated.urdf --estimate fitted/estimate.json",
    ),
    (
        "Against the true arm of a simulation",
        "touchcal evaluate sim/problem.toml --urdf out/calibrated.urdf \\\n--estimate out/estimate.json --truth sim/truth.json",
    ),
]))]
pub struct EvaluateArgs {
    /// The problem.
    #[command(flatten)]
    pub source: Source,
    /// The URDF to evaluate
    #[arg(long, value_name = "FILE", help_heading = ARM)]
    pub urdf: PathBuf,
    /// estimate.json of the calibration, to use its estimated poses of tool and fixtures, and to
    /// predict from its covariance how well the contacts should fit
    #[arg(long, value_name = "FILE", help_heading = ARM)]
    pub estimate: Option<PathBuf>,
    /// truth.json of the simulation that wrote the problem and its logs, to print how far the tool
    /// is from where it truly is, across the workspace, and with --estimate how far parameters are
    /// from the true ones
    #[arg(long, value_name = "FILE", help_heading = ARM)]
    pub truth: Option<PathBuf>,
    /// Also write the scores as a page, to open in a browser
    #[arg(long, value_name = "FILE.html", help_heading = OUTPUT)]
    pub report: Option<PathBuf>,
    /// Replaced: the problem names the nominal URDF.
    #[arg(long, value_name = "FILE", hide = true, requires = "mukca", conflicts_with = "problem")]
    pub nominal: Option<PathBuf>,
    /// Print every parameter that is compared with the truth
    #[arg(long, requires = "truth", help_heading = OUTPUT)]
    pub all: bool,
    /// Print JSON instead of a table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("Before the calibration", "touchcal inspect sim/problem.toml"),
    ("Every parameter on a line of its own", "touchcal inspect sim/problem.toml --all"),
]))]
pub struct InspectArgs {
    /// The problem.
    #[command(flatten)]
    pub source: Source,
    /// The arm of a folder, replaced.
    #[command(flatten)]
    pub arm: Arm,
    /// Print every parameter on a line of its own
    #[arg(long, help_heading = OUTPUT)]
    pub all: bool,
    /// Print JSON instead of tables
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

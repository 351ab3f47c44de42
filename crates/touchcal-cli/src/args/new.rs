//! Arguments of `new`.

use std::path::PathBuf;

use clap::ValueEnum;

use super::help::examples;
use super::number::{coordinate, positive};

/// Heading of options on recorded logs.
const FROM_LOGS: &str = "Recorded logs of sockets";

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("A template to fill in", "touchcal new sockets"),
    ("The whole problem of recorded logs", "touchcal new sockets --from logs --urdf arm.urdf --out recorded"),
    (
        "With logs of any names, their sockets, and a ball 120 mm before the flange",
        "touchcal new sockets --from front/0=logs/a.csv --from front/1=logs/b.csv \\\n--urdf arm.urdf --ball-mm 0 0 120 --out named",
    ),
]))]
pub struct NewArgs {
    /// Kind of contact
    #[arg(value_name = "KIND")]
    pub kind: Start,
    /// Folder to write into, created if missing; named after the kind if not given
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// With sockets: write a complete problem for logs of a ball in sockets, one for each socket: a
    /// folder of logs named PLACEMENT_N (front_0.csv) or PLACEMENT/N (front/0.csv,
    /// front/hole_0.csv), N the number of the socket; or a log; or a log with the name of its
    /// socket, as front/0=logs/a.csv (may be repeated)
    #[arg(long, value_name = "DIR|[SOCKET=]FILE", requires = "urdf", help_heading = FROM_LOGS)]
    pub from: Vec<PathBuf>,
    /// With --from: the nominal URDF
    #[arg(long, value_name = "FILE", requires = "from", help_heading = FROM_LOGS)]
    pub urdf: Option<PathBuf>,
    /// With --from: the link that is the ball, or carries it; the only leaf if not given
    #[arg(long, value_name = "LINK", requires = "from", help_heading = FROM_LOGS)]
    pub tip: Option<String>,
    /// With --from: centre of the ball in the frame of that link
    #[arg(
        long,
        num_args = 3,
        value_names = ["X_MM", "Y_MM", "Z_MM"],
        default_values_t = [0.0; 3],
        requires = "from",
        value_parser = coordinate,
        allow_negative_numbers = true,
        help_heading = FROM_LOGS
    )]
    pub ball_mm: Vec<f64>,
    /// With --from: distance of neighbouring sockets
    #[arg(long, value_name = "MM", default_value_t = 50.0, requires = "from", value_parser = positive, help_heading = FROM_LOGS)]
    pub spacing_mm: f64,
    /// With --from: estimate the compliance of the joints under gravity too; only touchcal reads it
    /// from a URDF
    #[arg(long, requires = "from", help_heading = FROM_LOGS)]
    pub joint_compliance: bool,
}

/// Kinds of template problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Start {
    /// A peg explores a hole
    PegInHole,
    /// A ball sits in sockets
    Sockets,
    /// A ball touches planes
    Planes,
}

impl Start {
    /// Name in arguments and of the folder written if none is given.
    pub fn name(self) -> &'static str {
        match self {
            Start::PegInHole => "peg-in-hole",
            Start::Sockets => "sockets",
            Start::Planes => "planes",
        }
    }
}

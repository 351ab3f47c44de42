//! Arguments of `convert`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::ValueEnum;
use touchcal::contact::AngleUnit;
use touchcal::io::contact_log::Options;

use super::help::{ARM, OUTPUT, examples};

/// Heading of options on the columns of a log, and their units.
const COLUMNS: &str = "Columns and units";
/// Heading of options on a bag.
const TOPICS: &str = "ROS 2 bags";

/// Arguments of `convert`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("A CSV log as Parquet", "touchcal convert log.csv --urdf arm.urdf --out log.parquet"),
    (
        "Degrees, in a file without header",
        "touchcal convert degrees.csv --urdf arm.urdf --unit deg \\\n--header q1,q2,q3,q4,q5,q6,q7 --out radians.csv",
    ),
]))]
pub struct ConvertArgs {
    /// The log: CSV, plain or gzipped, Parquet, a ROS 2 bag (MCAP), or of KUKA's recorder
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// URDF of the arm whose joints these are, or the name of a built-in arm
    #[arg(long, value_name = "FILE|NAME", help_heading = ARM)]
    pub urdf: PathBuf,
    /// Link where the chain ends; the only leaf if not given
    #[arg(long, value_name = "LINK", help_heading = ARM)]
    pub tip: Option<String>,
    /// File to write: .csv, .csv.gz or .parquet
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    pub out: PathBuf,
    /// Unit of the log's angles; radians if not given, but guessed for KUKA's recorder
    #[arg(long, help_heading = COLUMNS)]
    pub unit: Option<UnitName>,
    /// Names of the moving joints in the order of q1 to qn, or of the columns of a log without
    /// header
    #[arg(long, value_name = "JOINT,…", value_delimiter = ',', help_heading = COLUMNS)]
    pub joints: Option<Vec<String>>,
    /// Names of the columns of a CSV file that has no header
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', help_heading = COLUMNS)]
    pub header: Option<Vec<String>>,
    /// Name of a column or joint in the log (may be repeated): q1=shoulder, fz=force
    #[arg(long = "column", value_name = "USUAL=NAME", value_parser = column_name, help_heading = COLUMNS)]
    pub columns: Vec<(String, String)>,
    /// A bag's topic of joint states; the only one if not given
    #[arg(long, value_name = "TOPIC", help_heading = TOPICS)]
    pub joint_topic: Option<String>,
    /// A bag's topic of wrenches; without it, they are not read
    #[arg(long, value_name = "TOPIC", help_heading = TOPICS)]
    pub wrench_topic: Option<String>,
}

impl ConvertArgs {
    /// Options for reading the log.
    pub fn options(&self) -> Options {
        Options {
            unit: self.unit.map_or_else(AngleUnit::default, AngleUnit::from),
            header: self.header.clone(),
            joints: self.joints.clone(),
            columns: self.columns.iter().cloned().collect::<BTreeMap<_, _>>(),
            joint_topic: self.joint_topic.clone(),
            wrench_topic: self.wrench_topic.clone(),
            ..Options::default()
        }
    }
}

/// Names of units in arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum UnitName {
    /// Radians
    Rad,
    /// Degrees
    Deg,
}

impl From<UnitName> for AngleUnit {
    fn from(name: UnitName) -> AngleUnit {
        match name {
            UnitName::Rad => AngleUnit::Radian,
            UnitName::Deg => AngleUnit::Degree,
        }
    }
}

fn column_name(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(usual, name)| !usual.is_empty() && !name.is_empty());
    pair.map(|(usual, name)| (usual.to_owned(), name.to_owned())).ok_or_else(|| "expected USUAL=NAME".to_owned())
}

//! Arguments of `convert`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use touchcal::io::contact_log::{AngleUnit, Options};

/// Arguments of `convert`.
#[derive(Debug, clap::Args)]
pub struct ConvertArgs {
    /// The log: CSV, plain or gzipped, Parquet, a ROS 2 bag (MCAP), or of KUKA's recorder
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// URDF of the arm whose joints these are, or the name of a built-in arm
    #[arg(long, value_name = "FILE|NAME")]
    pub urdf: PathBuf,
    /// Link where the chain ends; the only leaf if not given
    #[arg(long, value_name = "LINK")]
    pub tip: Option<String>,
    /// File to write: .csv, .csv.gz or .parquet
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Unit of the log's angles; radians if not given, but guessed for KUKA's recorder
    #[arg(long, value_parser = unit())]
    pub unit: Option<AngleUnit>,
    /// Names of the moving joints in the order of q1 to qn, or of the columns of a log without
    /// header
    #[arg(long, value_name = "JOINT,…", value_delimiter = ',')]
    pub joints: Option<Vec<String>>,
    /// Names of the columns of a CSV file that has no header
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pub header: Option<Vec<String>>,
    /// What the log calls a column or joint (may be repeated): q1=shoulder, fz=force
    #[arg(long = "column", value_name = "USUAL=NAME", value_parser = renamed)]
    pub columns: Vec<(String, String)>,
    /// A bag's topic of joint states; the only one if not given
    #[arg(long, value_name = "TOPIC")]
    pub joint_topic: Option<String>,
    /// A bag's topic of wrenches; without it, they are not read
    #[arg(long, value_name = "TOPIC")]
    pub wrench_topic: Option<String>,
}

impl ConvertArgs {
    /// How to understand the log.
    pub fn options(&self) -> Options {
        Options {
            unit: self.unit.unwrap_or_default(),
            header: self.header.clone(),
            joints: self.joints.clone(),
            columns: self.columns.iter().cloned().collect::<BTreeMap<_, _>>(),
            joint_topic: self.joint_topic.clone(),
            wrench_topic: self.wrench_topic.clone(),
            ..Options::default()
        }
    }
}

fn unit() -> impl TypedValueParser<Value = AngleUnit> {
    PossibleValuesParser::new(["rad", "deg"])
        .map(|name| if name == "deg" { AngleUnit::Degree } else { AngleUnit::Radian })
}

fn renamed(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(usual, name)| !usual.is_empty() && !name.is_empty());
    pair.map(|(usual, name)| (usual.to_owned(), name.to_owned())).ok_or_else(|| "expected USUAL=NAME".to_owned())
}

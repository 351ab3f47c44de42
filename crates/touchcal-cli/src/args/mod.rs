//! What may be asked for.

mod convert;
mod experiment;

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Parser, Subcommand};
use clap_complete::Shell;
use touchcal::manifold::learned::Device;
use touchcal::sim::Preset;

pub use convert::ConvertArgs;
pub use experiment::*;

/// Calibrate a robot arm by touch: URDF, joint log and touched parts in, calibrated URDF with
/// honest error bars out.
#[derive(Debug, Parser)]
#[command(
    name = "touchcal",
    version,
    max_term_width = 100,
    after_help = "Exit codes: 0 done, 1 failed, 2 wrong usage, 3 the result is not usable, 130 interrupted."
)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a problem.toml to fill in, and a README.md of what to record
    New(NewArgs),
    /// Simulate an arm with wrong kinematics that explores a hole, calibrate it, and compare with
    /// the truth
    Demo(DemoArgs),
    /// Say what a log contains and what it can determine, before solving
    Inspect(InspectArgs),
    /// Estimate what is wrong with an arm; write calibrated.urdf, estimate.json and report.html
    Calibrate(CalibrateArgs),
    /// Score a URDF on contacts, without fitting anything
    Evaluate(EvaluateArgs),
    /// Write a log in another format: joint positions in radians under the joints' names
    Convert(ConvertArgs),
    /// Store a contact manifold: recorded poses of the tool, thinned, with what they cover
    Manifold(ManifoldArgs),
    /// Teach a network the projection onto a stored manifold
    Train(TrainArgs),
    /// Simulate an arm of which it is known what is wrong with it; write logs, problem.toml and
    /// truth.json
    Simulate(SimulateArgs),
    /// Compare methods on trials of which the truth is known
    #[command(subcommand)]
    Experiment(ExperimentArgs),
    /// Print a script that completes touchcal's arguments in a shell
    Completions(CompletionsArgs),
    /// Print the manual page, or write one for each command
    Man(ManArgs),
    /// Print the reference of all commands as Markdown, for the guide
    #[command(hide = true)]
    Reference,
}

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub struct NewArgs {
    /// What touches what
    #[arg(value_name = "KIND", value_parser = start())]
    pub kind: Start,
    /// Folder to write into, made if it is not there; named like the kind if not given
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Problems to start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// A peg explores a hole.
    PegInHole,
    /// A ball sits in sockets.
    Sockets,
    /// A ball touches planes.
    Planes,
}

impl Start {
    const ALL: [Start; 3] = [Start::PegInHole, Start::Sockets, Start::Planes];

    /// Name in arguments.
    pub fn name(self) -> &'static str {
        match self {
            Start::PegInHole => "peg-in-hole",
            Start::Sockets => "sockets",
            Start::Planes => "planes",
        }
    }
}

fn start() -> impl TypedValueParser<Value = Start> {
    let found = |name: String| Start::ALL.into_iter().find(|start| start.name() == name);
    PossibleValuesParser::new(Start::ALL.map(Start::name)).map(move |name| found(name).unwrap_or(Start::Sockets))
}

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL", value_parser = shell())]
    pub shell: Shell,
}

fn shell() -> impl TypedValueParser<Value = Shell> {
    PossibleValuesParser::new(["bash", "zsh", "fish"]).map(|name| match name.as_str() {
        "zsh" => Shell::Zsh,
        "fish" => Shell::Fish,
        _ => Shell::Bash,
    })
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// Folder to write touchcal.1, touchcal-calibrate.1 and so on into
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Where a problem is read from. What `requires` the folder also `conflicts_with` the problem file:
/// clap requires nothing that conflicts with what is given.
#[derive(Debug, clap::Args)]
pub struct Source {
    /// What to calibrate, with what, from which contacts; `touchcal new` writes one to fill in
    #[arg(value_name = "PROBLEM.toml", required_unless_present = "mukca", conflicts_with = "mukca")]
    pub problem: Option<PathBuf>,
    /// Instead of a problem file: a folder PLACEMENT/hole_N.csv of ball-in-socket logs, joint
    /// angles in radians
    #[arg(long, value_name = "DIR", requires = "urdf")]
    pub mukca: Option<PathBuf>,
    /// With --mukca: distance of neighbouring sockets
    #[arg(long, value_name = "MM", default_value_t = 50.0, requires = "mukca", conflicts_with = "problem")]
    pub spacing_mm: f64,
    /// With --mukca: link that carries the ball; the only leaf if not given
    #[arg(long, value_name = "LINK", requires = "mukca", conflicts_with = "problem")]
    pub tip: Option<String>,
    /// With --mukca: read only this placement (may be repeated)
    #[arg(long, value_name = "PLACEMENT", requires = "mukca", conflicts_with = "problem")]
    pub only: Vec<String>,
    /// With --mukca: leave this placement out (may be repeated)
    #[arg(long, value_name = "PLACEMENT", requires = "mukca", conflicts_with = "problem")]
    pub except: Vec<String>,
}

/// The arm of a `--mukca` folder, which no problem file describes.
#[derive(Debug, Default, clap::Args)]
pub struct Arm {
    /// With --mukca: the nominal URDF, whose tip link carries the ball
    #[arg(long, value_name = "FILE", requires = "mukca", conflicts_with = "problem")]
    pub urdf: Option<PathBuf>,
    /// With --mukca: estimate how far the joints give way to gravity too; only touchcal reads that
    /// from a URDF
    #[arg(long, requires = "mukca", conflicts_with = "problem")]
    pub joint_compliance: bool,
}

/// Arguments of `calibrate`.
#[derive(Debug, clap::Args)]
pub struct CalibrateArgs {
    /// The problem.
    #[command(flatten)]
    pub source: Source,
    /// The arm of a folder.
    #[command(flatten)]
    pub arm: Arm,
    /// Folder to write calibrated.urdf, estimate.json and report.html into
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Write DIR/driver too, for a driver that takes encoder offsets: joint_offsets.yaml, and the
    /// robot.urdf that goes with it
    #[arg(long)]
    pub driver_offsets: bool,
    /// Write DIR/calibration.mcap too, to look at the contacts in Foxglove or Rerun
    #[cfg(feature = "mcap")]
    #[arg(long)]
    pub mcap: bool,
    /// Print every parameter on a line of its own
    #[arg(long)]
    pub all: bool,
    /// Print estimate.json instead of the summary
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `evaluate`.
#[derive(Debug, clap::Args)]
pub struct EvaluateArgs {
    /// The problem.
    #[command(flatten)]
    pub source: Source,
    /// The URDF to score
    #[arg(long, value_name = "FILE")]
    pub urdf: PathBuf,
    /// With a problem file: estimate.json of the calibration, to score the URDF with tool and
    /// fixtures where it found them
    #[arg(long, value_name = "FILE", conflicts_with = "mukca")]
    pub estimate: Option<PathBuf>,
    /// With --mukca: another URDF to compare with; a problem file names its own
    #[arg(long, value_name = "FILE", requires = "mukca", conflicts_with = "problem")]
    pub nominal: Option<PathBuf>,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct InspectArgs {
    /// The problem.
    #[command(flatten)]
    pub source: Source,
    /// The arm of a folder.
    #[command(flatten)]
    pub arm: Arm,
    /// Print every parameter on a line of its own
    #[arg(long)]
    pub all: bool,
    /// Print JSON instead of tables
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `manifold`.
#[derive(Debug, clap::Args)]
pub struct ManifoldArgs {
    /// Take the poses from the contacts of a problem whose arm is calibrated
    #[arg(value_name = "PROBLEM.toml", required_unless_present = "poses", conflicts_with = "poses")]
    pub problem: Option<PathBuf>,
    /// Instead of a problem: poses of the tool in the fixture, a table x,y,z,qw,qx,qy,qz in metres
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    /// The fixture that was touched; needed if the problem has several
    #[arg(long, value_name = "NAME")]
    pub fixture: Option<String>,
    /// Keep only samples that are this far apart
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = not_negative)]
    pub spacing_mm: f64,
    /// Millimetres that count as much as a degree
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = positive)]
    pub mm_per_deg: f64,
    /// File to write
    #[arg(long, value_name = "FILE.safetensors")]
    pub out: PathBuf,
    /// Print JSON instead of tables
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `train`.
#[derive(Debug, clap::Args)]
pub struct TrainArgs {
    /// Samples of the manifold: from `touchcal manifold`, or a table x,y,z,qw,qx,qy,qz in metres
    #[arg(long, value_name = "FILE.safetensors")]
    pub manifold: PathBuf,
    /// Folder to write weights.safetensors and metrics.json into
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Go on from DIR's checkpoint, with its options, to the result that an uninterrupted run has
    #[arg(long, conflicts_with_all = OF_THE_START)]
    pub resume: bool,
    /// Width of the hidden layers
    #[arg(long, default_value_t = 512, value_parser = count(1, 1 << 16))]
    pub width: usize,
    /// Number of hidden layers
    #[arg(long, default_value_t = 4, value_parser = count(0, 63))]
    pub depth: usize,
    /// Pairs a step
    #[arg(long, default_value_t = 1024, value_parser = count(1, 1 << 20))]
    pub batch: usize,
    /// Steps in all
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..), conflicts_with = "minutes")]
    pub steps: u64,
    /// Instead of --steps: as many as take about this long here
    #[arg(long, value_name = "M", value_parser = positive)]
    pub minutes: Option<f64>,
    /// Greatest learning rate
    #[arg(long, value_name = "RATE", default_value_t = 1e-3, value_parser = positive)]
    pub learning_rate: f64,
    /// Different pairs to learn from
    #[arg(long, value_name = "N", default_value_t = 1 << 20, value_parser = clap::value_parser!(u64).range(1..=1 << 26))]
    pub pairs: u64,
    /// Stop early when this many looks in a row (every 500 steps) find nothing better on held-out
    /// pairs; 0: never
    #[arg(long, value_name = "LOOKS", default_value_t = 0)]
    pub patience: u64,
    /// Seed of weights and pairs
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// What to train on: the processor, or a GPU, through CUDA or wgpu if this build has it
    #[arg(long, value_name = "DEVICE", default_value = "cpu", value_parser = device())]
    pub device: Device,
    /// Learn the way to the projection instead of the projected pose
    #[arg(long)]
    pub correction: bool,
    /// Millimetres that count as much as a degree; as stored in the manifold, or 1, if not given
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub mm_per_deg: Option<f64>,
    /// Learn from poses up to this far from samples in each direction
    #[arg(long, value_name = "MM", default_value_t = 10.0, value_parser = positive)]
    pub offset_mm: f64,
    /// Learn from poses turned up to this much from samples in each angle
    #[arg(long, value_name = "DEG", default_value_t = 10.0, value_parser = positive)]
    pub offset_deg: f64,
    /// Seconds between checkpoints
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = not_negative)]
    pub checkpoint_seconds: f64,
    /// Write weights.onnx too
    #[arg(long)]
    pub onnx: bool,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// What a checkpoint has settled.
const OF_THE_START: [&str; 13] = [
    "width",
    "depth",
    "batch",
    "steps",
    "minutes",
    "learning_rate",
    "pairs",
    "patience",
    "seed",
    "correction",
    "mm_per_deg",
    "offset_mm",
    "offset_deg",
];

fn device() -> impl TypedValueParser<Value = Device> {
    let found = |name: String| Device::ALL.into_iter().find(|device| device.name() == name);
    PossibleValuesParser::new(Device::ALL.map(Device::name)).map(move |name| found(name).unwrap_or_default())
}

fn count(least: usize, most: usize) -> impl Fn(&str) -> Result<usize, String> + Clone {
    move |text| match text.parse() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("expected a whole number from {least} to {most}")),
    }
}

/// Largest number of an argument.
const LARGEST: f64 = 1e4;

fn not_negative(text: &str) -> Result<f64, String> {
    let value = text.parse().map_err(|_| "expected a number".to_owned())?;
    if (0.0..=LARGEST).contains(&value) { Ok(value) } else { Err(format!("expected a number from 0 to {LARGEST}")) }
}

fn positive(text: &str) -> Result<f64, String> {
    let value = not_negative(text)?;
    if value > 0.0 { Ok(value) } else { Err("expected a number above 0".to_owned()) }
}

/// Arguments of `demo`.
#[derive(Debug, clap::Args)]
pub struct DemoArgs {
    /// Folder to write the example into
    #[arg(long, value_name = "DIR", default_value = "touchcal-demo")]
    pub out: PathBuf,
    /// Seed of the simulated errors and noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Contacts to simulate
    #[arg(long, default_value_t = 3000, value_parser = clap::value_parser!(u32).range(20..=1_000_000))]
    pub contacts: u32,
}

/// Where a scenario comes from.
#[derive(Debug, clap::Args)]
pub struct ScenarioSource {
    /// What to simulate
    #[arg(value_name = "SCENARIO.toml", required_unless_present = "preset", conflicts_with = "preset")]
    pub scenario: Option<PathBuf>,
    /// Instead of a scenario file: a scenario that comes with touchcal
    #[arg(long, value_name = "NAME", value_parser = Preset::ALL.map(Preset::name))]
    pub preset: Option<String>,
    /// Contacts to simulate with each fixture; the scenario says how many otherwise
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub contacts: Option<u32>,
}

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
pub struct SimulateArgs {
    /// The scenario.
    #[command(flatten)]
    pub source: ScenarioSource,
    /// Folder to write the logs, problem.toml, scenario.toml and truth.json into
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Seed of the errors and the noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Another seed for the noise alone: the same arm, recorded once more
    #[arg(long, value_name = "SEED")]
    pub noise_seed: Option<u64>,
}

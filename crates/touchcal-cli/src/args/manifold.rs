//! Arguments of `manifold` and `train`.

use std::path::PathBuf;

use clap::ValueEnum;
use touchcal::manifold::learned::Device;

use super::help::{MACHINE, OUTPUT, examples};
use super::number::{count, not_negative, positive};

/// Heading of options on the network.
const NETWORK: &str = "Network";
/// Heading of options on the pairs of poses that it is trained on.
const PAIRS: &str = "Training pairs";
/// Heading of options on the training.
const TRAINING: &str = "Training";

/// Arguments of `manifold`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    (
        "From a problem's contacts with its calibrated arm",
        "touchcal manifold calibrated.toml --spacing-mm 0.2 --out hole.safetensors",
    ),
    ("From a table of poses", "touchcal manifold --poses poses.csv --spacing-mm 0.2 --out h.safetensors"),
]))]
pub struct ManifoldArgs {
    /// Take the poses from the contacts of a problem with a calibrated arm; those of an arm that
    /// misses its fixtures are refused
    #[arg(value_name = "PROBLEM.toml", required_unless_present = "poses", conflicts_with = "poses")]
    pub problem: Option<PathBuf>,
    /// Instead of a problem: poses of the tool in the fixture, a table x,y,z,qw,qx,qy,qz in metres
    #[arg(long, value_name = "FILE")]
    pub poses: Option<PathBuf>,
    /// The fixture; needed if the problem has several
    #[arg(long, value_name = "NAME")]
    pub fixture: Option<String>,
    /// Minimum distance between samples
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = not_negative)]
    pub spacing_mm: f64,
    /// Millimetres equivalent to one degree in distances between poses
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
#[command(after_help = examples(&[
    ("Train for ten minutes", "touchcal train --manifold hole.safetensors --minutes 10 --out net"),
    ("Continue after Ctrl-C", "touchcal train --manifold hole.safetensors --resume --out net"),
]))]
pub struct TrainArgs {
    /// Samples of the manifold: from `touchcal manifold`, or a table x,y,z,qw,qx,qy,qz in metres
    #[arg(long, value_name = "FILE.safetensors")]
    pub manifold: PathBuf,
    /// Folder to write weights.safetensors and metrics.json into
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub out: PathBuf,
    /// Resume from DIR's checkpoint with its options; the result is that of an uninterrupted run
    #[arg(long, conflicts_with_all = OF_THE_START, help_heading = TRAINING)]
    pub resume: bool,
    /// Width of the hidden layers
    #[arg(long, default_value_t = 512, value_parser = count(1, 1 << 16), help_heading = NETWORK)]
    pub width: usize,
    /// Number of hidden layers
    #[arg(long, default_value_t = 4, value_parser = count(0, 63), help_heading = NETWORK)]
    pub depth: usize,
    /// Pairs per step
    #[arg(long, default_value_t = 1024, value_parser = count(1, 1 << 20), help_heading = TRAINING)]
    pub batch: usize,
    /// Number of steps
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u64).range(1..), conflicts_with = "minutes", help_heading = TRAINING)]
    pub steps: u64,
    /// Instead of --steps: as many as take about this many minutes on this machine
    #[arg(long, value_name = "M", value_parser = positive, help_heading = TRAINING)]
    pub minutes: Option<f64>,
    /// Maximum learning rate
    #[arg(long, value_name = "RATE", default_value_t = 1e-3, value_parser = positive, help_heading = TRAINING)]
    pub learning_rate: f64,
    /// Number of distinct training pairs
    #[arg(long, value_name = "N", default_value_t = 1 << 20, value_parser = clap::value_parser!(u64).range(1..=1 << 26), help_heading = PAIRS)]
    pub pairs: u64,
    /// Stop after this many evaluations (one every 500 steps) without improvement on held-out
    /// pairs; 0: never
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = TRAINING)]
    pub patience: u64,
    /// Seed of weights and pairs
    #[arg(long, default_value_t = 1, help_heading = TRAINING)]
    pub seed: u64,
    /// Device to train on
    #[arg(long, value_name = "DEVICE", value_enum, default_value_t = DeviceName::Cpu, help_heading = MACHINE)]
    pub device: DeviceName,
    /// Predict the correction to the projection instead of the projected pose
    #[arg(long, help_heading = NETWORK)]
    pub correction: bool,
    /// Millimetres equivalent to one degree; as stored in the manifold, or 1, if not given
    #[arg(long, value_name = "MM", value_parser = positive, help_heading = PAIRS)]
    pub mm_per_deg: Option<f64>,
    /// Largest offset of training poses from samples along each axis
    #[arg(long, value_name = "MM", default_value_t = 10.0, value_parser = positive, help_heading = PAIRS)]
    pub offset_mm: f64,
    /// Largest offset of training poses from samples in each angle
    #[arg(long, value_name = "DEG", default_value_t = 10.0, value_parser = positive, help_heading = PAIRS)]
    pub offset_deg: f64,
    /// Seconds between checkpoints
    #[arg(long, value_name = "S", default_value_t = 30.0, value_parser = not_negative, help_heading = MACHINE)]
    pub checkpoint_seconds: f64,
    /// Write weights.onnx too
    #[arg(long, help_heading = OUTPUT)]
    pub onnx: bool,
    /// Print JSON instead of a table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Options that a checkpoint fixes.
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

/// Names of devices in arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum DeviceName {
    /// The processor
    Cpu,
    /// The first NVIDIA GPU, through CUDA; needs a build with `--features cuda`
    Cuda,
    /// A GPU, through Vulkan, Metal or DirectX 12; needs a build with `--features wgpu`
    Wgpu,
}

impl From<DeviceName> for Device {
    fn from(name: DeviceName) -> Device {
        match name {
            DeviceName::Cpu => Device::Cpu,
            DeviceName::Cuda => Device::Cuda,
            DeviceName::Wgpu => Device::Wgpu,
        }
    }
}

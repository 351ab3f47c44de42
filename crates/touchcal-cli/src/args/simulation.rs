//! Arguments of `demo` and `simulate`.

use std::path::PathBuf;

use clap::ValueEnum;
use touchcal::sim::Preset;

use super::help::{OUTPUT, SCENARIO, examples};

/// Arguments of `demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("With a third of the contacts", "touchcal demo --contacts 1000"),
]))]
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

/// The source of a scenario.
#[derive(Debug, clap::Args)]
pub struct ScenarioSource {
    /// The scenario
    #[arg(value_name = "SCENARIO.toml", required_unless_present = "preset", conflicts_with = "preset")]
    pub scenario: Option<PathBuf>,
    /// Instead of a scenario file: a built-in scenario
    #[arg(long, value_name = "NAME", help_heading = SCENARIO)]
    pub preset: Option<PresetName>,
    /// Contacts to simulate with each fixture; as in the scenario if not given
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000), help_heading = SCENARIO)]
    pub contacts: Option<u32>,
}

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("A ball in two sockets, three placements", "touchcal simulate --preset mukca --out sim"),
    ("The same arm, recorded again", "touchcal simulate --preset mukca --noise-seed 2 --out again"),
    ("A scenario of your own", "touchcal simulate scenario.toml --seed 2 --out own"),
]))]
pub struct SimulateArgs {
    /// The scenario.
    #[command(flatten)]
    pub source: ScenarioSource,
    /// Folder to write the logs, problem.toml, scenario.toml, truth.json and true.urdf into
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub out: PathBuf,
    /// Seed of the errors and the noise
    #[arg(long, default_value_t = 1, help_heading = SCENARIO)]
    pub seed: u64,
    /// Seed of noise and random phases: the same arm, recorded again
    #[arg(long, value_name = "SEED", help_heading = SCENARIO)]
    pub noise_seed: Option<u64>,
}

/// Names of presets in arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum PresetName {
    /// The paper's experiment
    Paper,
    /// An aluminium arm in low Earth orbit
    LeoAluminium,
    /// A carbon-fibre arm in low Earth orbit
    LeoCfrp,
    /// A robot cell in a hall
    Workcell,
    /// A ball in two sockets, three placements
    Mukca,
}

impl From<PresetName> for Preset {
    fn from(name: PresetName) -> Preset {
        match name {
            PresetName::Paper => Preset::Paper,
            PresetName::LeoAluminium => Preset::LeoAluminium,
            PresetName::LeoCfrp => Preset::LeoCfrp,
            PresetName::Workcell => Preset::Workcell,
            PresetName::Mukca => Preset::Mukca,
        }
    }
}

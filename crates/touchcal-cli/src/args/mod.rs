//! The definition of commands and arguments.

mod compare;
mod convert;
mod experiment;
mod help;
mod manifold;
mod manual;
mod new;
mod number;
mod problem;
mod select;
mod simulation;

use clap::{Parser, Subcommand};

pub use compare::CompareArgs;
pub use convert::ConvertArgs;
pub use experiment::{ApproachName, ExperimentArgs, PaperArgs, Table1Args};
#[cfg(feature = "parquet")]
pub use experiment::{CampaignArgs, FalsifiedArgs, MergeArgs, Vary};
pub use manifold::{ManifoldArgs, TrainArgs};
pub use manual::{CompletionsArgs, ManArgs, SchemaArgs, SchemaName};
pub use new::{NewArgs, Start};
pub use problem::{Arm, CalibrateArgs, EvaluateArgs, InspectArgs, ModelName, Source};
pub use select::SelectArgs;
pub use simulation::{DemoArgs, ScenarioSource, SimulateArgs};

/// The section of exit codes at the end of the help.
const EXIT_STATUS: &str = "

Exit status:
  0 done, 1 failed, 2 wrong usage, 3 the result is not usable, 130 interrupted";

/// Calibrate a robot arm by touch: URDF, joint log and touched parts in, calibrated URDF with
/// honest error bars out.
#[derive(Debug, Parser)]
#[command(
    name = "touchcal",
    version = env!("TOUCHCAL_VERSION"),
    max_term_width = 100,
    after_help = help::examples(&[
        ("See a simulated arm calibrated", "touchcal demo"),
        ("Begin with an arm of your own", "touchcal new sockets"),
    ]) + EXIT_STATUS
)]
pub struct Args {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write a template problem.toml, and a README.md on what to record
    New(NewArgs),
    /// Simulate an arm with known errors that explores a hole, calibrate it, and compare with the
    /// truth
    Demo(DemoArgs),
    /// Summarize logs and predict which parameters they determine, before calibration
    Inspect(InspectArgs),
    /// Compare models of the arm by how well they predict contacts that are left out
    Select(SelectArgs),
    /// Estimate an arm's errors; write calibrated.urdf, estimate.json and report.html
    Calibrate(CalibrateArgs),
    /// Evaluate a URDF on contacts, without estimation
    Evaluate(EvaluateArgs),
    /// Compare two calibrations of an arm: what changed, and whether by more than chance
    Compare(CompareArgs),
    /// Convert a log: joint positions in radians, columns named after the joints
    Convert(ConvertArgs),
    /// Sample a contact manifold from recorded tool poses; report its coverage
    Manifold(ManifoldArgs),
    /// Train a network to project onto a sampled contact manifold
    Train(TrainArgs),
    /// Simulate an arm with known errors; write logs, problem.toml, truth.json and true.urdf
    Simulate(SimulateArgs),
    /// Run experiments on trials with known errors
    #[command(subcommand, after_help = help::examples(&[
        ("The paper's experiment within minutes", "touchcal experiment paper --quick --out paper"),
    ]))]
    Experiment(ExperimentArgs),
    /// Print a shell completion script
    Completions(CompletionsArgs),
    /// Print the manual page, or write the pages of all commands
    Man(ManArgs),
    /// Print the JSON Schema of problem.toml or scenario.toml, for editors
    Schema(SchemaArgs),
    /// Print the reference of all commands as Markdown, for the guide
    #[command(hide = true)]
    Reference,
}

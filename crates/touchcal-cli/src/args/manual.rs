//! Arguments of `completions`, `man` and `schema`.

use std::path::PathBuf;

use clap_complete::Shell;

use super::help::examples;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("For Bash; source the file, or put it among the system's completions", "touchcal completions bash > touchcal.bash"),
]))]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("The pages of all commands; then `man man1/touchcal-calibrate.1`", "touchcal man --out man1"),
]))]
pub struct ManArgs {
    /// Folder to write touchcal.1, touchcal-calibrate.1 and so on into
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("For an editor's TOML plug-in", "touchcal schema problem > problem.schema.json"),
]))]
pub struct SchemaArgs {
    /// The file
    #[arg(value_name = "FILE")]
    pub file: SchemaName,
}

/// Files with a JSON Schema.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub enum SchemaName {
    /// problem.toml
    Problem,
    /// scenario.toml
    Scenario,
}

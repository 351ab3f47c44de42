//! Arguments of `completions`, `man` and `schema`.

use std::path::PathBuf;

use clap_complete::Shell;

/// Arguments of `completions`.
#[derive(Debug, clap::Args)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct ManArgs {
    /// Folder to write touchcal.1, touchcal-calibrate.1 and so on into
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
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

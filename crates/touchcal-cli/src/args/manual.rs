//! Arguments of `completions` and `man`.

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

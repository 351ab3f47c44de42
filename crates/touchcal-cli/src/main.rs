//! `touchcal`: calibrate a robot arm by touch, from the command line.

mod args;
mod command;
mod failure;
mod output;
mod progress;
mod summary;
mod table;

use std::io::{ErrorKind, Write};
use std::process::ExitCode;

use clap::Parser;

use args::Args;
use failure::{Failure, Outcome};

/// Exit codes; clap answers wrong usage with 2.
const FAILED: u8 = 1;
const WRONG_USAGE: u8 = 2;
const NOT_USABLE: u8 = 3;
const INTERRUPTED: u8 = 130;

fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(answer) => return usage(&answer),
    };
    progress::catch_interrupts();
    let result = command::run(&args.command);
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::NotUsable) => ExitCode::from(NOT_USABLE),
        Err(failure) => {
            output::diagnostic(&format!("error: {failure}"));
            ExitCode::from(match failure {
                Failure::Interrupted | Failure::TrainingInterrupted { .. } | Failure::ExperimentInterrupted => {
                    INTERRUPTED
                }
                Failure::ArmMisses { .. } => NOT_USABLE,
                Failure::OverInput { .. } | Failure::IntoFile(_) | Failure::Usage(_) => WRONG_USAGE,
                _ => FAILED,
            })
        }
    }
}

/// Answers `--help`, `--version` and wrong usage.
fn usage(answer: &clap::Error) -> ExitCode {
    let is_wrong = answer.use_stderr();
    match answer.print().and_then(|()| std::io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe && !is_wrong => {
            output::diagnostic(&format!("error: {}", Failure::Stdout(error)));
            ExitCode::from(FAILED)
        }
        _ if is_wrong => ExitCode::from(WRONG_USAGE),
        _ => ExitCode::SUCCESS,
    }
}

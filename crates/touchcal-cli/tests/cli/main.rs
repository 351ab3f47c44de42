//! `touchcal` as a user runs it: arguments in, exit code, texts and files out.

// Helpers of tests fail by panicking too; the exception in clippy.toml covers only the tests
// themselves.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[cfg(feature = "parquet")]
mod accept;
mod campaign;
#[cfg(all(feature = "mcap", feature = "parquet"))]
mod compare;
mod convert;
mod demo;
mod descent;
mod directions;
mod driver;
mod evaluate;
#[cfg(unix)]
mod examples;
mod experiment;
mod failures;
#[cfg(feature = "parquet")]
mod falsified;
mod golden;
#[cfg(unix)]
mod interrupt;
mod manifold;
mod manual;
mod new;
mod real;
mod select;
mod simulate;
mod train;

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use assert_cmd::assert::Assert;

/// Runs `touchcal` in `folder`.
fn touchcal(folder: &Path, args: &[&str]) -> Assert {
    Command::new(env!("CARGO_BIN_EXE_touchcal")).current_dir(folder).args(args).assert()
}

fn stdout(done: &Assert) -> String {
    String::from_utf8(done.get_output().stdout.clone()).unwrap()
}

fn stderr(done: &Assert) -> String {
    String::from_utf8(done.get_output().stderr.clone()).unwrap()
}

/// What is printed to stderr, without the lines of progress that a slow machine adds.
fn errors(done: &Assert) -> String {
    let is_progress = |line: &&str| {
        let seconds = line.split_once(" s: ").and_then(|(before, _)| before.rsplit_once(", "));
        seconds.is_some_and(|(_, seconds)| seconds.parse::<u32>().is_ok())
    };
    stderr(done).lines().filter(|line| !is_progress(line)).flat_map(|line| [line, "\n"]).collect()
}

fn json(path: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The folder `data` of the repository.
fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").canonicalize().unwrap()
}

/// The program, left running.
fn start(folder: &Path, args: &[&str]) -> std::process::Child {
    std::process::Command::new(env!("CARGO_BIN_EXE_touchcal"))
        .current_dir(folder)
        .args(args)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap()
}

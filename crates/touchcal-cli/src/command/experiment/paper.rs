//! `touchcal experiment paper`: the experiment of Negi, Manyar & Gupta (2025) from its beginning,
//! as a list of commands.

use std::path::{Path, PathBuf};

use clap::Parser;
use touchcal::io::atomic;

use super::table1;
use crate::args::{Args, Command, ExperimentArgs, PaperArgs};
use crate::command::train::{self, CHECKPOINT};
use crate::command::{manifold, simulate};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::interrupted;

/// Sizes of the experiment.
struct Sizes {
    poses: u32,
    pairs: u32,
    training_steps: u32,
    trials: u32,
    descent_steps: u32,
    descent_contacts: u32,
}

const WHOLE: Sizes = Sizes {
    poses: 80_000,
    pairs: 1 << 20,
    training_steps: 10_000,
    trials: 20,
    descent_steps: 1000,
    descent_contacts: 250,
};
const QUICK: Sizes =
    Sizes { poses: 20_000, pairs: 1 << 18, training_steps: 1000, trials: 1, descent_steps: 300, descent_contacts: 250 };

/// The paper's scenario with an arm without errors: the default of a scenario.
const OFFLINE: &str = "# The paper's peg in hole, touched by an arm without errors.\nschema = 1\n";

/// A command of the experiment.
struct Step {
    title: &'static str,
    words: Vec<String>,
    /// What it leaves behind, with which it is not run again; `None` of the table, which reads its
    /// saved trials and prints them.
    result: Option<PathBuf>,
}

/// Runs the commands whose results are missing.
pub fn run(args: &PaperArgs) -> Result<Outcome, Failure> {
    let sizes = if args.quick { QUICK } else { WHOLE };
    let offline = args.out.join("offline.toml");
    if !offline.is_file() {
        atomic::write(&offline, OFFLINE.as_bytes())?;
    }
    for (number, step) in steps(&args.out, &offline, &sizes).iter().enumerate() {
        output::print(&format!(
            "\n{}. {}\n   touchcal {}\n\n",
            number + 1,
            step.title,
            step.words.iter().map(|word| for_shell(word)).collect::<Vec<String>>().join(" ")
        ))?;
        if let Some(result) = step.result.as_ref().filter(|result| result.is_file()) {
            output::print(&format!("  {} is there already\n", result.display()))?;
            continue;
        }
        let words = std::iter::once("touchcal").chain(step.words.iter().map(String::as_str));
        let args = Args::try_parse_from(words).map_err(|error| Failure::Setup(error.to_string()))?;
        run_step(&args.command)?;
        if interrupted() {
            return Err(Failure::ExperimentInterrupted);
        }
    }
    Ok(Outcome::Done)
}

fn run_step(command: &Command) -> Result<Outcome, Failure> {
    match command {
        Command::Simulate(args) => simulate::run(args),
        Command::Manifold(args) => manifold::run(args),
        Command::Train(args) => train::run(args),
        Command::Experiment(ExperimentArgs::Table1(args)) => table1::run(args),
        _ => Err(Failure::Setup("a command that is no step of the experiment".to_owned())),
    }
}

/// A word as a POSIX shell takes it.
fn for_shell(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=".contains(c);
    if word.chars().all(is_plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

/// The commands in their order. Results are named after the sizes, so that those of others are not
/// taken for these.
fn steps(out: &Path, offline: &Path, sizes: &Sizes) -> [Step; 4] {
    let Sizes { poses, pairs, training_steps, trials, descent_steps, descent_contacts } = sizes;
    let simulated = out.join(format!("{poses}_poses"));
    let manifold = out.join(format!("{poses}_poses.safetensors"));
    let network = out.join(format!("{poses}_poses_{training_steps}_steps"));
    let table = out.join(format!("{poses}_poses_{training_steps}_steps_{trials}_trials"));
    let (problem, weights) = (simulated.join("problem.toml"), network.join("weights.safetensors"));
    let text = |path: &Path| path.display().to_string();
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<String>>();
    let [poses, pairs, training_steps, trials, descent_steps, descent_contacts] =
        [poses, pairs, training_steps, trials, descent_steps, descent_contacts].map(u32::to_string);
    // The checkpoint of an interrupted training has its settings.
    let settings = match network.join(CHECKPOINT).is_file() {
        true => words(&["--resume"]),
        false => words(&["--steps", &training_steps, "--pairs", &pairs]),
    };
    let [offline, simulated, network, table] = [offline, &simulated, &network, &table].map(text);
    let manifold_text = text(&manifold);
    let table1 = ["experiment", "table1", "--manifold", &manifold_text, "--weights", &text(&weights), "--out", &table];
    let of_table = ["--trials", &trials, "--steps", &descent_steps, "--descent-contacts", &descent_contacts];
    [
        Step {
            title: "Contact poses of an arm without errors (offline phase)",
            words: words(&["simulate", &offline, "--contacts", &poses, "--out", &simulated]),
            result: Some(problem.clone()),
        },
        Step {
            title: "The contact manifold, sampled from these poses",
            words: words(&["manifold", &text(&problem), "--spacing-mm", "0.2", "--out", &manifold_text]),
            result: Some(manifold.clone()),
        },
        Step {
            title: "The metric projection function: a network",
            words: [words(&["train", "--manifold", &manifold_text, "--out", &network]), settings].concat(),
            result: Some(weights.clone()),
        },
        Step {
            title: "Link strain and encoder offsets: table I, and what each part of the method contributes",
            words: [words(&table1), words(&of_table)].concat(),
            result: None,
        },
    ]
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    /// Each command is one that the command line takes, blanks in paths included, and begins with
    /// what the one before leaves.
    #[test]
    fn commands_follow_from_each_other() {
        for sizes in [WHOLE, QUICK] {
            let steps = steps(Path::new("a b"), Path::new("a b/offline.toml"), &sizes);
            for step in &steps {
                let words = std::iter::once("touchcal").chain(step.words.iter().map(String::as_str));
                assert!(Args::try_parse_from(words).is_ok(), "{:?}", step.words);
            }
            for pair in steps.windows(2) {
                let result = pair[0].result.as_ref().unwrap().to_str().unwrap();
                assert!(pair[1].words.iter().any(|word| word == result), "{result}: {:?}", pair[1].words);
            }
        }
    }
}

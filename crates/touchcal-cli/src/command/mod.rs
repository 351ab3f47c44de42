//! The commands, each from arguments to output.

mod calibrate;
mod compare;
mod convert;
mod demo;
mod evaluate;
mod experiment;
mod inspect;
mod manifold;
mod manual;
mod new;
mod rms_and_max;
mod select;
mod simulate;
mod train;

use std::path::{Path, PathBuf};
use std::time::Instant;

use jiff::Timestamp;
use touchcal::estimate::{Progress, StopReason, calibrate_with_freed_effects};
use touchcal::io::Loaded;
use touchcal::io::atomic;
use touchcal::io::calibration_folder::Solved;
use touchcal::io::problem_file::{self, Selection};

use crate::args::{Arm, Command, Source};
use crate::failure::{Failure, Outcome};
use crate::progress::Spinner;

/// Runs a command.
pub fn run(command: &Command) -> Result<Outcome, Failure> {
    match command {
        Command::New(args) => new::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Convert(args) => convert::run(args),
        Command::Evaluate(args) => evaluate::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Manifold(args) => manifold::run(args),
        Command::Train(args) => train::run(args),
        Command::Experiment(args) => experiment::run(args),
        Command::Select(args) => select::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Completions(args) => manual::completions(args),
        Command::Man(args) => manual::pages(args),
        Command::Schema(args) => manual::schema(args),
        Command::Reference => manual::reference(),
    }
}

/// Refuses, before long work, to overwrite an input or to write into a path that is no folder. Then
/// removes what runs that were ended left beside the outputs.
fn prepare_outputs<'a>(
    outputs: impl IntoIterator<Item = PathBuf> + Clone,
    inputs: impl IntoIterator<Item = &'a Path>,
) -> Result<(), Failure> {
    let canonical = |path: &Path| path.canonicalize().ok();
    let inputs: Vec<&Path> = inputs.into_iter().collect();
    for output in outputs.clone() {
        if let Some(file) = output.ancestors().skip(1).find(|above| above.is_file()) {
            return Err(Failure::IntoFile(file.display().to_string()));
        }
        let Some(found) = canonical(&output) else { continue };
        if let Some(input) = inputs.iter().find(|input| canonical(input).as_ref() == Some(&found)) {
            let [output, input] = [&*output, input].map(|path| path.display().to_string());
            return Err(Failure::OverInput { output, input });
        }
    }
    for output in outputs {
        let folder = output.parent().filter(|folder| !folder.as_os_str().is_empty());
        atomic::remove_left_over(folder.unwrap_or(Path::new(".")));
    }
    Ok(())
}

/// Reads the selected placements of a problem; notes go to stderr.
fn load(source: &Source) -> Result<Loaded, Failure> {
    let loaded = read(source)?;
    crate::output::notes(loaded.problem.contacts.notes());
    Ok(loaded)
}

/// Reads the selected placements of a problem.
fn read(source: &Source) -> Result<Loaded, Failure> {
    let Some(problem) = &source.problem else {
        // clap requires a problem file or --mukca, which `refuse_replaced` has refused.
        return Err(Failure::Usage("expected a problem file, found none".to_owned()));
    };
    let selection = Selection { only: source.only.clone(), except: source.except.clone() };
    let spinner = Spinner::new("Reading");
    spinner.run();
    Ok(problem_file::read_selected(problem, &selection)?.with_known_shapes()?)
}

/// Refuses `--mukca` and its companions, and shows the commands that replace them; `command` is the
/// command with its further arguments.
fn refuse_replaced(source: &Source, arm: &Arm, command: [&str; 2]) -> Result<(), Failure> {
    let Some(folder) = &source.mukca else { return Ok(()) };
    let mut new = format!("touchcal new sockets --from {}", folder.display());
    let urdf = arm.urdf.as_ref().map_or_else(|| "FILE".to_owned(), |urdf| urdf.display().to_string());
    new += &format!(" --urdf {urdf}");
    new += &source.tip.as_ref().map_or_else(String::new, |tip| format!(" --tip {tip}"));
    new += &source.spacing_mm.map_or_else(String::new, |spacing| format!(" --spacing-mm {spacing}"));
    new += if arm.joint_compliance { " --joint-compliance" } else { "" };
    let [name, more] = command;
    let selection = selection_flags(&source.only, &source.except);
    Err(Failure::Usage(format!(
        "--mukca was replaced by a problem file:\n  {new} --out sockets\n  touchcal {name} sockets/problem.toml{selection}{more}"
    )))
}

/// A selection of placements as arguments.
fn selection_flags(only: &[String], except: &[String]) -> String {
    let flags = |flag: &'static str, names: &[String]| names.iter().map(|name| format!(" --{flag} {name}")).collect();
    let [only, except]: [String; 2] = [flags("only", only), flags("except", except)];
    only + &except
}

/// Calibrates with progress, until interrupted. With `free_suspects` the problem becomes the one
/// with what contacts contradict as parameters.
fn calibrate(loaded: &mut Loaded, free_suspects: bool) -> Result<Solved, Failure> {
    crate::progress::defer_interrupts();
    let spinner = Spinner::new("Calibrating");
    let start = Instant::now();
    let mut steps = Vec::new();
    let mut observe = |progress: &Progress| {
        steps.push(*progress);
        spinner.observe(progress)
    };
    let estimate = if free_suspects {
        let (problem, estimate) = calibrate_with_freed_effects(&loaded.problem, &mut observe);
        loaded.problem = problem;
        estimate
    } else {
        touchcal::estimate::calibrate(&loaded.problem, &mut observe)
    };
    let seconds = start.elapsed().as_secs_f64();
    // An interrupt may have come since the last step.
    if estimate.termination.reason == StopReason::Interrupted || crate::progress::interrupted() {
        return Err(Failure::Interrupted);
    }
    let prefit = touchcal::estimate::evaluate(&loaded.problem);
    Ok(Solved { estimate, prefit, steps, ended: Timestamp::now(), seconds })
}

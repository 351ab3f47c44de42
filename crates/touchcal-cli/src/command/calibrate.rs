//! `touchcal calibrate`.

use std::collections::BTreeSet;
use std::path::Path;

use touchcal::estimate::{Decision, Estimate, Status};
use touchcal::io::calibration_folder::{self, CALIBRATED, ESTIMATE, Wanted, Written};
use touchcal::io::{Export, Loaded};
use touchcal::solver::StopReason;

use crate::args::{CalibrateArgs, ModelName};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::summary::{Calibration, Detail, INDENT};

/// Reads a problem, calibrates, writes the result, prints a summary.
pub fn run(args: &CalibrateArgs) -> Result<Outcome, Failure> {
    let out = format!(" --out {}", args.out.display());
    super::refuse_replaced(&args.source, &args.arm, ["calibrate", &out])?;
    let mut loaded = super::read(&args.source)?;
    super::prepare_outputs(
        calibration_folder::paths(&args.out),
        loaded.inputs.iter().map(|input| Path::new(&input.path)),
    )?;
    calibration_folder::check_folder(&args.out)?;
    let exports: Vec<Export> = args.export.iter().map(|format| format.export()).collect();
    for export in &exports {
        // Refused before the calibration rather than after it.
        export.check(&loaded)?;
    }
    if args.model == ModelName::Auto {
        super::select::apply(&mut loaded)?;
    }
    let solved = super::calibrate(&mut loaded, args.free_suspects)?;
    let file = calibration_folder::estimate_file(&loaded, &solved);
    let wanted = Wanted { driver: args.driver_offsets, mcap: mcap(args), exports };
    let written = calibration_folder::write(&args.out, &loaded, &solved, &file, &wanted)?;
    let calibration = Calibration { loaded: &loaded, solved: &solved, file: &file, written: &written };
    if args.json {
        output::print(&file.to_json()?)?;
    } else {
        let detail = if args.all { Detail::Every } else { Detail::Grouped };
        output::print_result(solved.estimate.status, &calibration.summary(detail, &next(args, &loaded, &written)))?;
    }
    Ok(outcome(&solved.estimate))
}

#[cfg(feature = "mcap")]
fn mcap(args: &CalibrateArgs) -> bool {
    args.mcap
}

#[cfg(not(feature = "mcap"))]
fn mcap(_: &CalibrateArgs) -> bool {
    false
}

/// The outcome of a calibration; a result that must not be used, or does not reach what is asked
/// of it, is reported on stderr.
pub fn outcome(estimate: &Estimate) -> Outcome {
    let decision = estimate.acceptance.as_ref().map(|result| result.decision);
    match estimate.status {
        Status::Usable | Status::Doubtful => match decision {
            None | Some(Decision::Pass) => return Outcome::Done,
            Some(Decision::Fail) => output::diagnostic("FAIL: the tool is not within the tolerance of [accept]"),
            Some(Decision::Undecided) => {
                output::diagnostic("UNDECIDED: the tool may or may not be within the tolerance of [accept]");
            }
        },
        Status::NotUsable if estimate.termination.reason == StopReason::Converged => {
            output::diagnostic("the result is NOT USABLE: see its warnings");
        }
        Status::NotUsable => output::diagnostic("the result is NOT USABLE: the search did not converge"),
    }
    Outcome::NotUsable
}

/// The last placement with contacts, if there are several.
fn last_of_several_placements(loaded: &Loaded) -> Option<&str> {
    let (contacts, fixtures) = (&loaded.problem.contacts, &loaded.problem.fixtures);
    let placement = |i| fixtures[contacts.fixture(i)].placement.as_str();
    let placements: BTreeSet<&str> = (0..contacts.len()).map(placement).collect();
    placements.last().copied().filter(|_| placements.len() > 1)
}

/// How to evaluate the result on contacts that were not used.
fn next(args: &CalibrateArgs, loaded: &Loaded, written: &Written) -> String {
    let source = &args.source;
    let [urdf, estimate] = [&written.urdf, &written.estimate].map(|path| path.display());
    let problem = source.problem.as_deref().unwrap_or(Path::new("PROBLEM.toml")).display();
    if source.only.is_empty() && source.except.is_empty() {
        if !loaded.problem.held_out.is_empty() {
            return format!(
                "evaluate it on the contacts that are held out\n{INDENT}touchcal evaluate {problem} --urdf {urdf} --estimate {estimate}"
            );
        }
        if let Some(placement) = last_of_several_placements(loaded) {
            let placement = [placement.to_owned()];
            let (except, only) = (super::selection_flags(&[], &placement), super::selection_flags(&placement, &[]));
            let without = args.out.join("without");
            let without = without.display();
            return format!(
                "evaluate the model on a placement that a calibration without it has not used\n{INDENT}touchcal calibrate {problem}{except} --out {without}\n{INDENT}touchcal evaluate {problem}{only} --urdf {without}/{CALIBRATED} --estimate {without}/{ESTIMATE}"
            );
        }
        return format!(
            "evaluate it on contacts that were not used, by the problem file of another log\n{INDENT}touchcal evaluate OTHER.toml --urdf {urdf} --estimate {estimate}"
        );
    }
    // The others are what was left out, or all but what was read.
    let held_out = match source.except.as_slice() {
        [] => super::selection_flags(&[], &source.only),
        except => super::selection_flags(except, &[]),
    };
    format!(
        "evaluate it on the placements that were not used\n{INDENT}touchcal evaluate {problem}{held_out} --urdf {urdf} --estimate {estimate}"
    )
}

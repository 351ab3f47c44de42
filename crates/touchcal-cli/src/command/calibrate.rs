//! `touchcal calibrate`.

use std::path::Path;

use touchcal::estimate::{PlacePrior, Problem, Status};
use touchcal::io::Loaded;
use touchcal::io::calibration_folder::{self, Written};

use super::{Failure, Outcome};
use crate::args::{CalibrateArgs, Source};
use crate::output;
use crate::summary::{Calibration, Detail, INDENT};

/// Reads, estimates, writes, tells.
pub fn run(args: &CalibrateArgs) -> Result<Outcome, Failure> {
    let loaded = super::load(&args.source, &args.arm)?;
    super::check_outputs(
        calibration_folder::paths(&args.out),
        loaded.inputs.iter().map(|input| Path::new(&input.path)),
    )?;
    let solved = super::calibrate(&loaded)?;
    let file = calibration_folder::estimate_file(&loaded, &solved);
    let mut written = calibration_folder::write(&args.out, &loaded, &solved, &file)?;
    if args.driver_offsets {
        written.driver = calibration_folder::write_driver(&args.out, &loaded, &solved.estimate)?;
    }
    #[cfg(feature = "mcap")]
    if args.mcap {
        written.mcap = Some(calibration_folder::write_mcap(&args.out, &loaded, &solved.estimate)?);
    }
    let calibration = Calibration { loaded: &loaded, solved: &solved, file: &file, written: &written };
    if args.json {
        output::print(&file.to_json()?)?;
    } else {
        let detail = if args.all { Detail::Every } else { Detail::Grouped };
        output::print(&calibration.summary(detail, &next(&loaded, &args.source, &written)))?;
    }
    Ok(outcome(solved.estimate.status))
}

/// What a status means for the exit code, said on stderr too where it is bad.
pub fn outcome(status: Status) -> Outcome {
    match status {
        Status::Converged => return Outcome::Done,
        Status::NotConverged => output::complain("the estimation did NOT CONVERGE: do not use the result"),
        Status::NotUsable => output::complain("the result is NOT USABLE: its warnings say why"),
    }
    Outcome::NotUsable
}

/// How to score the result on contacts that it was not fitted to.
fn next(loaded: &Loaded, source: &Source, written: &Written) -> String {
    let urdf = written.urdf.display();
    let (Some(folder), None) = (&source.mukca, &source.problem) else {
        let problem = source.problem.as_deref().unwrap_or(Path::new("PROBLEM.toml")).display();
        let Problem { tool, fixtures, .. } = &loaded.problem;
        let places = fixtures.iter().map(|fixture| fixture.prior).chain([tool.prior]);
        let found = match places.into_iter().any(|freedom| freedom != PlacePrior::Fixed) {
            true => format!(" --estimate {}", written.estimate.display()),
            false => String::new(),
        };
        return format!(
            "score it; best on other contacts, named in a copy of the problem file\n{INDENT}touchcal evaluate {problem} --urdf {urdf}{found}"
        );
    };
    let folder = folder.display();
    let tip = source.tip.as_ref().map_or_else(String::new, |tip| format!(" --tip {tip}"));
    let score = |choice: String| format!("touchcal evaluate --mukca {folder}{choice} --urdf {urdf}{tip}");
    let chosen = |flag: &str, names: &[String]| names.iter().map(|name| format!(" --{flag} {name}")).collect();
    let held_out = "score it on the placements that were not used\n";
    match (source.only.as_slice(), source.except.as_slice()) {
        ([], []) => {
            let last = loaded.problem.fixtures.last().map_or("PLACEMENT", |fixture| fixture.placement.as_str());
            format!(
                "all placements were used: to test the result, calibrate again with `--except {last}`, then\n{INDENT}{}",
                score(format!(" --only {last}"))
            )
        }
        (only, []) => format!("{held_out}{INDENT}{}", score(chosen("except", only))),
        (_, except) => format!("{held_out}{INDENT}{}", score(chosen("only", except))),
    }
}

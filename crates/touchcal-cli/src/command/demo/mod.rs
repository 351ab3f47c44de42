//! `touchcal demo`: simulation, calibration and comparison with the truth, without input.

mod comparison;

use std::path::Path;

use touchcal::io::calibration_folder::{self, Solved, Wanted};
use touchcal::io::{problem_file, scenario_file};

use super::{calibrate, simulate};
use crate::args::DemoArgs;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::summary;

/// Simulates, writes the example, calibrates it as `touchcal calibrate` does, and compares with the
/// truth.
pub fn run(args: &DemoArgs) -> Result<Outcome, Failure> {
    scenario_file::check_folder(&args.out)?;
    calibration_folder::check_folder(&args.out)?;
    let mut file = scenario_file::preset("paper")?;
    file.scenario.contacts = args.contacts as usize;
    let simulated = simulate::simulate(&file, args.seed.into())?;
    scenario_file::write_folder(&args.out, &file, &simulated, args.seed)?;
    let mut loaded = problem_file::read_file(&args.out.join(scenario_file::PROBLEM))?;
    let solved = super::calibrate(&mut loaded, false)?;
    let Solved { estimate, prefit, .. } = &solved;
    let written = calibration_folder::estimate_file(&loaded, &solved);
    calibration_folder::write(&args.out, &loaded, &solved, &written, &Wanted::default())?;
    let text = [
        comparison::text(&file.scenario.robot, &simulated.truth, args.seed, &loaded.problem, estimate),
        "Distance from contact (mm)\n".to_owned(),
        summary::residuals(&loaded.problem.fixtures, &[("before", prefit), ("after", &estimate.postfit)]),
        next(&args.out),
    ];
    output::print(&text.concat())?;
    Ok(calibrate::outcome(estimate))
}

fn next(folder: &Path) -> String {
    let folder = folder.display();
    [
        format!("Written to {folder}: problem.toml and hole.csv (a template), scenario.toml, truth.json, true.urdf,\n"),
        "calibrated.urdf, estimate.json and report.html (open it in a browser).\n\n".to_owned(),
        "Next\n".to_owned(),
        format!("  touchcal inspect {folder}/problem.toml\n"),
        format!("  touchcal calibrate {folder}/problem.toml --out {folder}/again\n"),
        format!("  touchcal evaluate {folder}/problem.toml --urdf {folder}/calibrated.urdf\n"),
    ]
    .concat()
}

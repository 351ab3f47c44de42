//! `touchcal compare`.

mod json;
mod text;

use touchcal::io::estimate_file::Status;
use touchcal::io::{CalibrationChanges, SavedCalibration};

use crate::args::CompareArgs;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Reads two calibrations, prints what changed between them.
pub fn run(args: &CompareArgs) -> Result<Outcome, Failure> {
    let both = [SavedCalibration::read(&args.earlier)?, SavedCalibration::read(&args.later)?];
    let [earlier, later] = &both;
    if earlier.file.robot.is_none() || later.file.robot.is_none() {
        output::diagnostic("note: a file of an earlier version does not say of which robot it is");
    }
    let posterior = |calibration: &SavedCalibration| {
        calibration.file.posterior().ok_or_else(|| Failure::NoUncertainty(calibration.name.clone()))
    };
    let changes = CalibrationChanges::new([earlier, later], &[posterior(earlier)?, posterior(later)?])?;
    if changes.arm.parameters.is_empty() {
        return Err(Failure::NothingInCommon([earlier, later].map(|calibration| calibration.name.clone())));
    }
    output::print(&if args.json { json::of(&both, &changes)? } else { text::of(&both, &changes, args.all) })?;
    let unusable = both.iter().find(|calibration| calibration.file.status == Status::NotUsable);
    Ok(unusable.map_or(Outcome::Done, |calibration| {
        output::diagnostic(&format!(
            "the calibration of {} is not usable: the comparison is not either",
            calibration.name
        ));
        Outcome::NotUsable
    }))
}

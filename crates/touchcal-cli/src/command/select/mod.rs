//! `touchcal select`.

mod json;
mod text;

use std::ops::ControlFlow;

use touchcal::estimate::{ModelChoice, SelectionError, SelectionProgress, Status, select};
use touchcal::io::Loaded;

use crate::args::{Arm, SelectArgs};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::{Spinner, interrupted};

/// Reads a problem, compares models, prints what was chosen; [`Outcome::NotUsable`] if a
/// calibration with the chosen model is not.
pub fn run(args: &SelectArgs) -> Result<Outcome, Failure> {
    super::refuse_replaced(&args.source, &Arm::default(), ["select", ""])?;
    let mut loaded = super::load(&args.source)?;
    let choice = choose(&loaded)?;
    loaded.problem = choice.problem.clone();
    let estimate = super::calibrate(&mut loaded, false)?.estimate;
    output::print(&if args.json { json::of(&loaded, &choice, &estimate)? } else { text::of(&choice, &estimate) })?;
    if estimate.status == Status::NotUsable {
        output::diagnostic("a calibration with the chosen model is NOT USABLE: `touchcal calibrate` says why");
        return Ok(Outcome::NotUsable);
    }
    Ok(Outcome::Done)
}

/// Gives the problem the parameters of the chosen model.
pub fn apply(loaded: &mut Loaded) -> Result<(), Failure> {
    loaded.problem = choose(loaded)?.problem;
    Ok(())
}

/// Chooses with progress, until interrupted.
fn choose(loaded: &Loaded) -> Result<ModelChoice, Failure> {
    crate::progress::defer_interrupts();
    let spinner = Spinner::new("Selecting");
    let observe = |progress: &SelectionProgress| {
        spinner.show(|| format!("{} of {} fits", progress.done, progress.count));
        if interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match select(&loaded.problem, &observe) {
        Err(SelectionError::Interrupted) => Err(Failure::Interrupted),
        result => Ok(result?),
    }
}

//! How well an arm explains contacts that it need not have been fitted to.

use nalgebra::DVector;

use super::problem::Problem;
use super::score::{Score, score};
use super::system::System;

/// Scores the problem's arm as it is, with tool and fixtures where the problem puts them; nothing is estimated.
pub fn evaluate(problem: &Problem) -> Score {
    let system = System::new(problem);
    score(problem, &system.at(&DVector::zeros(system.parameters.len())))
}

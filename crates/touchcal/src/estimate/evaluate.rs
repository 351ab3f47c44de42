//! How well an arm explains contacts that it need not have been fitted to.

use nalgebra::DVector;

use super::problem::{Freedom, Problem};
use super::score::{self, Score, score};
use super::system::System;
use crate::robot::Column;
use crate::se3::{self, Twist};

/// Scores the problem's arm as it is, with tool and fixtures where the problem puts them; nothing is estimated.
pub fn evaluate(problem: &Problem) -> Score {
    let system = System::new(problem);
    score(problem, &system.at(&DVector::zeros(system.parameters.len())))
}

/// Distance (m) from touching of each contact, in order, at parameters `values` (SI, as [`Estimate::values`](super::Estimate::values) has them; zeros are the
/// problem's arm as it is): what a [`Score`] is made of.
pub fn distances(problem: &Problem, values: &DVector<f64>) -> Vec<f64> {
    score::distances(problem, &System::new(problem).at(values))
}

/// Puts tool and fixtures where a calibration found them: `found(name)` is the value of the parameter of that name (m, rad). What it did not
/// estimate stays where it is.
///
/// A fixture without a nominal place has none to count from: it is left as it is, and the score of a socket does not need it.
pub fn place(problem: &mut Problem, found: impl Fn(&str) -> Option<f64>) {
    let mut tool = Twist::zeros();
    let mut fixtures = vec![Twist::zeros(); problem.fixtures.len()];
    for parameter in System::new(problem).parameters {
        let value = found(&parameter.name).unwrap_or(0.0);
        match parameter.column {
            Column::Tool(k) => tool[k] = value,
            Column::Fixture(f, k) => fixtures[f][k] = value,
            _ => {}
        }
    }
    problem.tool.tip_from_tool *= se3::exp(&tool);
    problem.tool.freedom = Freedom::Known;
    for (fixture, twist) in problem.fixtures.iter_mut().zip(&fixtures) {
        if let Some(base_from_fixture) = &mut fixture.base_from_fixture {
            *base_from_fixture *= se3::exp(twist);
            fixture.freedom = Freedom::Known;
        }
    }
}

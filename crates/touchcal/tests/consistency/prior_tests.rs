//! Tests of declarations that are drawn from their standard deviations.

use std::ops::ControlFlow;

use touchcal::estimate::calibrate;

use crate::freed_effects::posed;
use crate::support::report;

/// Tool, hole, shapes and trends off by draws from what is declared: tests of the posterior against
/// the prior reject none, and their statistics are those of so many directions, or somewhat less,
/// since estimates vary less than what they estimate.
#[test]
fn what_is_drawn_from_its_prior_agrees_with_it() {
    let (mut statistic, mut directions, mut least) = (0.0, 0, 1.0_f64);
    for seed in 1..=12 {
        let (problem, _) = posed("all_drawn", seed);
        let estimate = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
        let tests = &estimate.prior_tests;
        for name in ["tool", "fixture.hole", "gap_bias.hole"] {
            assert!(tests.iter().any(|test| test.name == name), "seed {seed}: {tests:?}");
        }
        statistic += tests.iter().map(|test| test.statistic).sum::<f64>();
        directions += tests.iter().map(|test| test.degrees_of_freedom).sum::<usize>();
        least = tests.iter().map(|test| test.p_value).fold(least, f64::min);
    }
    let mean = statistic / directions as f64;
    report("declarations drawn from their priors", &[("statistic a direction", mean), ("least p-value", least)]);
    assert!(mean > 0.4 && mean < 1.1, "{mean}");
    assert!(least > 1e-3, "{least}");
}

//! Effects that contacts contradict are estimated where nothing is known of them.

use std::ops::ControlFlow;

use touchcal::estimate::{Estimate, OmittedEffect, Problem, StopReason, calibrate, calibrate_with_freed_effects};
use touchcal::experiment::falsified::{Excitation, FalsifiedKind};
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Truth};

/// The problem of 3000 contacts by rich excitation, and the truth.
fn posed(name: &str, seed: u64) -> (Problem, Truth) {
    let kind = FalsifiedKind::by_name(name).expect("a kind");
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let declared = Excitation::Rich.scenario(robot, 3000).expect("a scenario");
    let mut scenario = declared.clone();
    kind.falsification.falsify_scenario(&mut scenario);
    let simulated = sim::simulate(&scenario, seed).expect("contacts");
    (kind.problem(&declared, &simulated, seed).expect("a problem"), simulated.truth)
}

fn freed_effects(estimate: &Estimate) -> Vec<&OmittedEffect> {
    estimate.freed_effects.iter().map(|freed| &freed.effect).collect()
}

/// Asserts that the arm is within four standard deviations of the truth.
fn assert_right(estimate: &Estimate, truth: &Truth) {
    for entry in estimate.parameters.iter().filter(|entry| !entry.parameter.id.block().is_nuisance()) {
        let deviations = (entry.value - truth.value(entry.parameter.id)) / entry.sigma.expect("a standard deviation");
        assert!(deviations.abs() < 4.0, "{}: {} ({deviations} σ)", entry.parameter.name, entry.value);
    }
}

/// Joints that give way by so much that contacts have no likelihood: there is nothing to test
/// effects with, and the answer is refused. With all effects of the arm estimated together the
/// compliances show, and the answer with these is right.
#[test]
fn a_compliance_that_leaves_no_likelihood_is_freed() {
    let (problem, truth) = posed("compliance_2e-5", 20001);
    let without = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
    assert!(!without.status.is_usable() && without.effect_tests.is_empty(), "{:?}", without.warnings);
    let (_, with) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
    assert!(freed_effects(&with).contains(&&OmittedEffect::JointCompliance), "{:?}", with.freed_effects);
    assert!(with.status.is_usable(), "{:?}", with.warnings);
    assert_right(&with, &truth);
    let compliance = with.parameter("joint_compliance.joint_a2").expect("a compliance");
    assert!(compliance.value > 1e-5, "{}", compliance.value);
}

/// Noise that no effect explains is estimated: here three times the declared one.
#[test]
fn noise_declared_too_small_is_freed() {
    let (problem, _) = posed("encoder_noise", 20001);
    let mut steps = 0;
    let without = calibrate(&problem, &mut |_| {
        steps += 1;
        ControlFlow::Continue(())
    });
    assert!(!without.status.is_usable(), "{:?}", without.warnings);
    let (_, with) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
    assert_eq!(freed_effects(&with), [&OmittedEffect::Noise]);
    let factor = with.noise.encoder / problem.noise.encoder;
    assert!(with.status.is_usable() && factor > 2.0 && factor < 3.3, "{factor}: {:?}", with.warnings);

    // A break is heard in the first calibration and in later ones, and is not lost.
    for end in [1, steps + 1] {
        let mut calls = 0;
        let (_, ended) = calibrate_with_freed_effects(&problem, &mut |_| {
            calls += 1;
            if calls == end { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!((ended.termination.reason, calls), (StopReason::Interrupted, end));
        assert!(!ended.status.is_usable() && ended.freed_effects.is_empty());
    }
}

/// With the declared noise the search ends beside the right minimum, and what looks like a random
/// walk of encoders there does not make the result usable: noise is estimated instead.
#[test]
fn noise_is_freed_where_another_effect_does_not_help() {
    let (problem, truth) = posed("encoder_noise", 20004);
    let (_, with) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
    assert!(freed_effects(&with).contains(&&OmittedEffect::Noise), "{:?}", with.freed_effects);
    assert!(with.status.is_usable(), "{:?}", with.warnings);
    assert_right(&with, &truth);
}

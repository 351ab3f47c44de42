//! Effects that contacts contradict are estimated where nothing is known of them.

use std::ops::ControlFlow;

use touchcal::estimate::{Estimate, OmittedEffect, Problem, StopReason, calibrate, calibrate_with_freed_effects};
use touchcal::experiment::falsified::{Excitation, Falsification, FalsifiedKind};
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{self, Truth};

/// The problem of 3000 contacts by rich excitation, and the truth.
pub fn posed(name: &str, seed: u64) -> (Problem, Truth) {
    let kind = FalsifiedKind::by_name(name).expect("a kind");
    posed_with(&kind, kind.falsification, seed)
}

/// The same where `falsification` is simulated in place of the kind's own.
fn posed_with(kind: &FalsifiedKind, falsification: Falsification, seed: u64) -> (Problem, Truth) {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let declared = Excitation::Rich.scenario(robot, 3000).expect("a scenario");
    let mut scenario = declared.clone();
    falsification.falsify_scenario(&mut scenario);
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

/// Joints that give way by so much, 5e-5 rad/(N m), that contacts have no likelihood: there is
/// nothing to test effects with, and the answer is refused. With all effects of the arm estimated
/// together the compliances show, and the answer with these is right.
#[test]
fn a_compliance_that_leaves_no_likelihood_is_freed() {
    let kind = FalsifiedKind::by_name("compliance_2e-5").expect("a kind");
    let (problem, truth) = posed_with(&kind, Falsification::JointCompliance(5e-5), 20001);
    let without = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
    assert!(!without.status.is_usable() && without.effect_tests.is_empty(), "{:?}", without.warnings);
    let (_, with) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
    assert!(freed_effects(&with).contains(&&OmittedEffect::JointCompliance), "{:?}", with.freed_effects);
    assert!(with.status.is_usable(), "{:?}", with.warnings);
    assert_right(&with, &truth);
    let compliance = with.parameter("joint_compliance.joint_a2").expect("a compliance");
    assert!(compliance.value > 4e-5, "{}", compliance.value);
}

/// A compliance of 2e-5 rad/(N m), with a search that ends beside the right minimum: tests show
/// nothing of the compliance there, and a larger noise does not help.
#[test]
fn a_compliance_is_freed_where_tests_show_nothing() {
    let (problem, truth) = posed("compliance_2e-5", 20004);
    let without = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
    let tests = &without.effect_tests;
    let threshold = problem.options.thresholds.effect_p_value;
    assert!(!without.status.is_usable() && !tests.is_empty(), "{:?}", without.warnings);
    assert!(tests.iter().all(|test| test.p_value > threshold), "{tests:?}");
    let (_, with) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
    assert_eq!(freed_effects(&with), [&OmittedEffect::JointCompliance]);
    assert!(with.status.is_usable(), "{:?}", with.warnings);
    assert_right(&with, &truth);
}

/// A hole that is declared exact, 1 mm off: each freed effect has the prediction of a calibration
/// with the others.
#[test]
fn each_freed_effect_says_what_it_bought() {
    let (problem, _) = posed("hole_exact_1mm", 20000);
    let (freed, with) = calibrate_with_freed_effects(&problem, &mut |_| ControlFlow::Continue(()));
    assert!(with.freed_effects.len() > 1, "{:?}", with.freed_effects);
    let place = with.freed_effects.iter().find(|freed| matches!(freed.effect, OmittedEffect::FixturePlace { .. }));
    let mut without_place = freed;
    without_place.fixtures[0].prior = problem.fixtures[0].prior;
    let check = calibrate(&without_place, &mut |_| ControlFlow::Continue(())).predictive_check.expect("a prediction");
    assert_eq!(place.expect("the hole").predictive_ratio, Some(check.ratio));
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

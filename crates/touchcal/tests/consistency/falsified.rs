//! False declarations are false by as much as they say, and by nothing else.

use std::ops::ControlFlow;

use touchcal::estimate::{PlacePrior, Problem, ShapeTolerance, UnseenEffects, WrenchTolerance, calibrate};
use touchcal::experiment::falsified::{
    Excitation, Falsification, FalsifiedKind, FalsifiedOptions, Quantity, falsified_trial,
};
use touchcal::experiment::problem;
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{Block, ParameterId};
use touchcal::robot::Robot;
use touchcal::se3::{self, Pose};
use touchcal::sim::{self, Scenario};

const DEG: f64 = std::f64::consts::PI / 180.0;

fn robot() -> Robot {
    urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot
}

fn kind(name: &str) -> FalsifiedKind {
    FalsifiedKind::by_name(name).expect("a kind")
}

fn options(seed: u64) -> FalsifiedOptions {
    FalsifiedOptions { seed, free_effects: false }
}

/// The scenario that is declared, the problem as it should be, and as `name` poses it of a
/// simulation with the same seed.
fn falsified(name: &str, excitation: Excitation) -> (Scenario, Problem, Problem) {
    let mut declared = excitation.scenario(robot(), 40).expect("a scenario");
    kind(name).falsification.prepare_scenario(&mut declared).expect("parts");
    let mut scenario = declared.clone();
    kind(name).falsification.falsify_scenario(&mut scenario);
    let simulated = |scenario: &Scenario| sim::simulate(scenario, 3).expect("contacts");
    let nothing = FalsifiedKind { falsification: Falsification::Nothing, ..kind(name) };
    let with_loads = nothing.problem(&declared, &simulated(&declared), 3).expect("a problem");
    let right = Problem { contacts: with_loads.contacts, ..problem(&declared, &simulated(&declared)) };
    (declared.clone(), right, kind(name).problem(&declared, &simulated(&scenario), 3).expect("a problem"))
}

/// Differences (rad) of the joint positions of all contacts, joint by joint.
fn differences(one: &Problem, other: &Problem) -> Vec<Vec<f64>> {
    let dof = one.contacts.dof();
    assert_eq!(one.contacts.len(), other.contacts.len());
    let of = |joint: usize| (0..one.contacts.len()).map(move |i| other.contacts.q(i)[joint] - one.contacts.q(i)[joint]);
    (0..dof).map(|joint| of(joint).collect()).collect()
}

#[track_caller]
fn apart(declared: &Pose, truth: &Pose, length: f64, angle: f64) {
    let by = se3::log(&(declared.inverse() * truth));
    let (v, w) = (se3::linear(&by).norm(), se3::angular(&by).norm());
    assert!((v - length).abs() < 1e-9 && (w - angle).abs() < 1e-9, "{v} m, {w} rad");
}

#[test]
fn names_are_unique() {
    for (k, kind) in FalsifiedKind::ALL.iter().enumerate() {
        assert!(FalsifiedKind::ALL[..k].iter().all(|other| other.name != kind.name), "{}", kind.name);
        let is_plain = |c: char| c.is_ascii_alphanumeric() || ['_', '.', '-'].contains(&c);
        assert!(kind.name.chars().all(is_plain), "{}", kind.name);
    }
}

#[test]
fn places_are_off_by_the_size() {
    for (name, length) in [("hole_1mm", 1e-3), ("hole_exact_0.1mm", 1e-4), ("hole_sigma_2mm", 2e-3)] {
        let (scenario, right, wrong) = falsified(name, Excitation::Paper);
        let place = wrong.fixtures[0].base_from_fixture.expect("a place");
        apart(&place, &scenario.touches[0].base_from_fixture, length, 0.0);
        assert_eq!((&wrong.contacts, &wrong.tool.tip_from_tool), (&right.contacts, &right.tool.tip_from_tool));
    }
    let (scenario, _, wrong) = falsified("tool_0.5mm", Excitation::Paper);
    apart(&wrong.tool.tip_from_tool, &scenario.tip_from_tool, 0.5e-3, 0.2 * DEG);
    let (scenario, right, wrong) = falsified("tool_in_metres", Excitation::Paper);
    let height = wrong.tool.tip_from_tool.translation.z;
    assert!((1e3 * height - scenario.tip_from_tool.translation.z).abs() < 1e-15 && right.contacts == wrong.contacts);
}

#[test]
fn draws_have_the_size_on_average() {
    let declared = Excitation::Paper.scenario(robot(), 40).expect("a scenario");
    let simulated = sim::simulate(&declared, 3).expect("contacts");
    let truth = declared.touches[0].base_from_fixture;
    let draw = |seed: u64| {
        let problem = kind("hole_drawn").problem(&declared, &simulated, seed).expect("a problem");
        se3::log(&(problem.fixtures[0].base_from_fixture.expect("a place").inverse() * truth))
    };
    assert_eq!(draw(1), draw(1));
    let twists: Vec<_> = (0..300).map(draw).collect();
    for (k, sigma) in [1e-3, 1e-3, 1e-3, 0.5 * DEG, 0.5 * DEG, 0.5 * DEG].into_iter().enumerate() {
        let square: f64 = twists.iter().map(|twist| (twist[k] / sigma).powi(2)).sum::<f64>() / 300.0;
        // Four standard deviations of the mean square of 300 normal numbers.
        assert!((square - 1.0).abs() < 4.0 * (2.0 / 300.0_f64).sqrt(), "{k}: {square}");
    }
}

/// What is drawn differs from the truth by its default on average.
#[test]
fn what_is_drawn_has_the_size_of_its_default() {
    let paper = Excitation::Paper.scenario(robot(), 40).expect("a scenario");
    let pegs = sim::simulate(&paper, 3).expect("contacts");
    let sockets = Excitation::Sockets.scenario(robot(), 40).expect("a scenario");
    let balls = sim::simulate(&sockets, 3).expect("contacts");
    let (right_pegs, right_balls) = (problem(&paper, &pegs), problem(&sockets, &balls));
    let of_all = |seed: u64| {
        let of_pegs = |name: &str| kind(name).problem(&paper, &pegs, seed).expect("a problem");
        let all = of_pegs("all_drawn");
        let balls = kind("all_drawn").problem(&sockets, &balls, seed).expect("a problem");
        let tool = se3::log(&(all.tool.tip_from_tool.inverse() * paper.tip_from_tool));
        let wider = gap(&all, -0.015) - gap(&right_pegs, -0.015);
        let longer = balls.distances[1].distance - right_balls.distances[1].distance;
        let last = *differences(&right_pegs, &of_pegs("trends_drawn"))[4].last().expect("a contact");
        let mut off = right_pegs.clone();
        let harmonics = Falsification::Drawn(Quantity::UnseenEffects);
        harmonics.falsify_problem(&mut off, &paper, seed).expect("a problem");
        let harmonic = differences(&right_pegs, &off)[4][0] / (0.01 * DEG);
        [harmonic, tool[2] / 0.3e-3, tool[3] / (0.2 * DEG), wider / 0.03e-3, longer / 0.1e-3, last / (0.005 * DEG)]
    };
    let draws: Vec<_> = (0..300).map(of_all).collect();
    for k in 0..6 {
        let square: f64 = draws.iter().map(|draw| draw[k].powi(2)).sum::<f64>() / 300.0;
        // Four standard deviations of the mean square of 300 normal numbers.
        assert!((square - 1.0).abs() < 4.0 * (2.0 / 300.0_f64).sqrt(), "{k}: {square}");
    }
}

#[test]
fn declared_standard_deviations_are_those_of_the_kind() {
    let priors = |name: &str| {
        let (_, _, wrong) = falsified(name, Excitation::Paper);
        (wrong.tool.prior, wrong.fixtures[0].prior, wrong.fixtures[0].tolerance)
    };
    let (tool, fixture, shape) = (PlacePrior::DEFAULT_TOOL, PlacePrior::DEFAULT_FIXTURE, ShapeTolerance::DEFAULT);
    let (fixed, exact) = (PlacePrior::Fixed, ShapeTolerance::EXACT);
    assert_eq!(priors("nothing_exact"), (fixed, fixed, exact));
    assert_eq!(priors("nothing"), (tool, fixture, shape));
    assert_eq!(priors("tool_drawn"), (tool, fixed, exact));
    assert_eq!(priors("shapes_drawn"), (fixed, fixed, shape));
    assert_eq!(priors("hole_exact_1mm"), (tool, fixed, shape));
    assert_eq!(priors("tool_exact_0.5mm"), (fixed, fixture, shape));
    assert_eq!(priors("clearance_exact"), (tool, fixture, exact));
    let unseen = |name: &str| falsified(name, Excitation::Paper).2.options.unseen_effects;
    assert_eq!((unseen("tool_drawn"), unseen("nothing")), (UnseenEffects::Ignore, UnseenEffects::Widen));
    assert_eq!(priors("hole_free"), (tool, PlacePrior::Flat, shape));
    let (_, _, wrong) = falsified("hole_sigma_2mm", Excitation::Paper);
    assert_eq!(wrong.fixtures[0].prior, PlacePrior::Gaussian { sigma: 2e-3, sigma_angle: 0.5 * DEG });
}

/// Gap (m) of a peg upright over the middle of the hole, its origin at this height.
fn gap(problem: &Problem, height: f64) -> f64 {
    let mut rows = touchcal::manifold::Residual::new();
    problem.fixtures[0].manifold.residual(&Pose::translation(0.0, 0.0, height), 0.0, &mut rows);
    rows.values()[0]
}

/// A peg upright over the middle of the hole is as far from its walls as they were moved.
#[test]
fn shapes_are_off_by_the_size() {
    for (name, height, expected) in [
        ("clearance_wide_0.05mm", -0.015, 0.05e-3),
        ("clearance_narrow_0.05mm", -0.015, -0.05e-3),
        ("depth_0.05mm", -0.0299, 0.05e-3),
    ] {
        let (_, right, wrong) = falsified(name, Excitation::Paper);
        let wider = gap(&wrong, height) - gap(&right, height);
        assert!((wider - expected).abs() < 1e-9, "{name}: {wider}");
    }
    // Clearance grows with the outlines.
    let (_, right, wrong) = falsified("outline_0.2_percent", Excitation::Paper);
    let ratio = gap(&wrong, -0.015) / gap(&right, -0.015);
    assert!((ratio - 1.002).abs() < 1e-9, "{ratio}");
}

#[test]
fn encoders_are_off_by_the_size() {
    let moved = |name: &str| {
        let (_, right, wrong) = falsified(name, Excitation::Rich);
        differences(&right, &wrong)
    };
    let one = |joints: Vec<Vec<f64>>| -> Vec<f64> {
        let mut moved = joints.into_iter().filter(|joint| joint.iter().any(|change| *change != 0.0));
        let only = moved.next().expect("a joint");
        assert!(moved.next().is_none());
        only
    };
    let drift = one(moved("encoder_drift"));
    let (first, last) = (drift[0], drift[drift.len() - 1]);
    assert!((first + 0.01 * DEG).abs() < 1e-12 && (last - 0.01 * DEG).abs() < 1e-12, "{first} to {last}");
    assert!(one(moved("encoder_harmonic")).iter().all(|change| change.abs() <= 0.02 * DEG + 1e-12));

    let (_, right, wrong) = falsified("joints_exchanged", Excitation::Paper);
    let joint = (0..6).find(|&joint| wrong.contacts.q(0)[joint] == right.contacts.q(0)[joint + 1]).expect("a pair");
    assert!((0..40).all(|i| wrong.contacts.q(i)[joint + 1] == right.contacts.q(i)[joint]));
}

#[test]
fn declarations_are_wrong_in_kind() {
    let tool = |name: &str| {
        let (_, right, wrong) = falsified(name, Excitation::Paper);
        (right.tool.tip_from_tool, wrong.tool.tip_from_tool)
    };
    let (right, turned) = tool("tool_turned");
    apart(&turned, &right, 0.0, std::f64::consts::PI);
    let (right, opposite) = tool("tool_opposite");
    assert_eq!(opposite.translation.vector, -right.translation.vector);
    let (_, right, wrong) = falsified("hole_in_metres", Excitation::Paper);
    let [right, wrong] = [right, wrong].map(|problem| problem.fixtures[0].base_from_fixture.expect("a place"));
    assert!((wrong.translation.vector * 1e3 - right.translation.vector).norm() < 1e-15);

    let positions = |name: &str| {
        let (_, right, wrong) = falsified(name, Excitation::Sockets);
        [right, wrong].map(|problem| problem.contacts.q(7).to_vec())
    };
    let [right, wrong] = positions("joints_reversed");
    assert!(right.iter().rev().eq(&wrong));
    let [right, wrong] = positions("joints_degrees");
    assert!(right.iter().zip(&wrong).all(|(right, wrong)| (right - wrong.to_radians()).abs() < 1e-15));
    let [right, wrong] = positions("joint_sign");
    let differ: Vec<usize> = (0..7).filter(|&joint| right[joint] != wrong[joint]).collect();
    assert!(differ.len() == 1 && wrong[differ[0]] == -right[differ[0]], "{right:?}, {wrong:?}");
    let (_, right, wrong) = falsified("other_arm", Excitation::Sockets);
    for (right, wrong) in right.robot.joints().iter().zip(wrong.robot.joints()) {
        let [right, wrong] = [right, wrong].map(|joint| joint.parent_from_joint.translation.vector);
        assert!((wrong - right * 0.9).norm() < 1e-15);
    }
}

/// A strain that is estimated makes up for an arm described too small, by a ninth.
#[test]
fn an_arm_described_too_small_is_estimated_as_it_is() {
    let on = &mut || ControlFlow::Continue(());
    let row = falsified_trial(&kind("other_arm"), (Excitation::Rich, &robot(), 1000), options(2), on).expect("a row");
    assert!(row.is_answered() && row.useful && row.tool_error < 1e-3, "{row:?}");
}

/// An encoder that is off once a turn looks like an offset: the intervals allow for it. In these
/// trials its errors are several standard deviations without that.
#[test]
fn an_error_that_contacts_would_not_show_is_within_the_intervals() {
    for seed in [9002, 9004] {
        let on = &mut || ControlFlow::Continue(());
        let row = falsified_trial(&kind("encoder_harmonic"), (Excitation::Rich, &robot(), 3000), options(seed), on);
        let row = row.expect("a row");
        assert!(row.useful && row.nees.expect("a NEES") < 8.0, "{row:?}");

        let declared = Excitation::Rich.scenario(robot(), 3000).expect("a scenario");
        let simulated = sim::simulate(&declared, seed).expect("contacts");
        let mut problem = kind("encoder_harmonic").problem(&declared, &simulated, seed).expect("a problem");
        problem.options.unseen_effects = UnseenEffects::Ignore;
        let estimate = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
        let deviations = estimate.parameters.iter().filter(|entry| !entry.parameter.id.block().is_nuisance());
        let most = deviations.map(|entry| {
            (entry.value - simulated.truth.value(entry.parameter.id)).abs() / entry.sigma.unwrap_or(f64::MAX)
        });
        let most = most.fold(0.0, f64::max);
        assert!(most > 3.0, "seed {seed}: {most}");
    }
}

#[test]
fn a_fifth_of_the_contacts_is_false() {
    let declared = Excitation::Paper.scenario(robot(), 1000).expect("a scenario");
    let simulated = sim::simulate(&declared, 3).expect("contacts");
    let right = problem(&declared, &simulated);
    let wrong = kind("false_contacts").problem(&declared, &simulated, 3).expect("a problem");
    let changes: Vec<f64> = differences(&right, &wrong)[2].iter().copied().filter(|change| *change != 0.0).collect();
    // Within four standard deviations: of a count of 1000 with a share of 0.2, of a mean square.
    assert!((changes.len() as f64 - 200.0).abs() < 4.0 * 160.0_f64.sqrt(), "{}", changes.len());
    let square = changes.iter().map(|change| (change / (0.3 * DEG)).powi(2)).sum::<f64>() / changes.len() as f64;
    assert!((square - 1.0).abs() < 4.0 * (2.0 / changes.len() as f64).sqrt(), "{square}");
}

/// Rows that are no contacts leave the likelihood of the others as it is. In these trials nearly
/// all contacts counted as touching nothing once some rows did, and errors were five standard
/// deviations.
#[test]
fn false_rows_leave_contacts_their_likelihood() {
    for (name, seed) in [("false_contacts_0.3", 20006), ("false_contacts", 20023)] {
        let on = &mut || ControlFlow::Continue(());
        let row = falsified_trial(&kind(name), (Excitation::Rich, &robot(), 3000), options(seed), on).expect("a row");
        assert!(row.useful && row.nees.expect("a NEES") < 8.0, "{row:?}");
        assert!(!row.warnings.iter().any(|warning| warning == "few_informative_contacts"), "{row:?}");
    }
}

/// With a wide hole most contacts are at the rim, and searches end in many minima: here none of the
/// first ten in the right one.
#[test]
fn a_search_goes_on_until_its_end_is_plausible() {
    let on = &mut || ControlFlow::Continue(());
    let row = falsified_trial(&kind("clearance_0.25mm"), (Excitation::Paper, &robot(), 3000), options(20025), on);
    let row = row.expect("a row");
    assert!(row.useful && row.nees.expect("a NEES") < 16.0, "{row:?}");
}

#[test]
fn distances_are_too_large_by_the_share() {
    let (_, right, wrong) = falsified("spacing_2.5_percent", Excitation::Sockets);
    assert_eq!((right.distances.len(), wrong.distances.len()), (3, 3));
    for (right, wrong) in right.distances.iter().zip(&wrong.distances) {
        assert!((wrong.distance / right.distance - 1.025).abs() < 1e-12 && wrong.sigma == 0.1e-3);
    }
}

/// Loads are off by the bias of the truth, and compliances are parameters.
#[test]
fn the_wrench_is_off_by_the_bias() {
    let tolerances = [WrenchTolerance::DEFAULT.with_noise_of(&WrenchTolerance::EXACT), WrenchTolerance::EXACT];
    for (name, tolerance) in ["wrench_bias", "wrench_bias_exact"].into_iter().zip(tolerances) {
        let (mut scenario, right, wrong) = falsified(name, Excitation::Paper);
        assert_eq!((right.wrench, wrong.wrench), (WrenchTolerance::EXACT, tolerance));
        let has_compliance =
            |problem: &Problem| problem.parameters.iter().any(|p| p.id.block() == Block::JointCompliance);
        assert!(has_compliance(&right) && has_compliance(&wrong));
        kind(name).falsification.falsify_scenario(&mut scenario);
        let truth = sim::draw_truth(&scenario, 3);
        // A bias decides on contact, too: the first rows are the same.
        let (without, with) = (right.contacts.load(0), wrong.contacts.load(0));
        for k in 0..6 {
            let bias = truth.value(ParameterId::WrenchBias(k));
            assert!((with[k] - without[k] - bias).abs() < 1e-4 && bias != 0.0, "{k}: {with:?} {without:?} {bias}");
        }
    }
}

/// The third joint, which only the elbow moves much, has several times the range.
#[test]
fn rich_excitation_moves_the_elbow() {
    let range = |excitation: Excitation| {
        let declared = excitation.scenario(robot(), 400).expect("a scenario");
        let log = &sim::simulate(&declared, 3).expect("contacts").logs[0];
        let each = || (0..log.len()).map(|i| log.q(i)[2]);
        each().fold(f64::MIN, f64::max) - each().fold(f64::MAX, f64::min)
    };
    let (paper, rich) = (range(Excitation::Paper), range(Excitation::Rich));
    assert!(rich > 0.5 && rich > 4.0 * paper, "{paper} and {rich} rad");
}

#[test]
fn a_row_says_what_the_answer_was() {
    let run = |name: &str, seed: u64| {
        let on = &mut || ControlFlow::Continue(());
        falsified_trial(&kind(name), (Excitation::Sockets, &robot(), 1000), options(seed), on).expect("a row")
    };
    let row = run("nothing_exact", 1);
    assert_eq!(row, run("nothing_exact", 1));
    assert!(row.is_answered() && row.honest && row.useful, "{row:?}");
    assert!(row.nees.expect("a NEES") < 3.0 * row.degrees_of_freedom as f64 && row.tool_error > 0.0, "{row:?}");
    let row = run("spacing_2.5_percent", 1);
    assert!(!row.is_answered() && row.honest && !row.useful, "{row:?}");
}

/// Joints that give way by much: stretches that contradict each other refuse an answer that no
/// likelihood tests, and whose errors are beyond the 99.9 % quantile of χ².
#[test]
fn without_a_likelihood_contradicted_stretches_refuse_an_answer() {
    let falsification = Falsification::JointCompliance(5e-5);
    let (kind, seed) = (FalsifiedKind { falsification, ..kind("compliance_2e-5") }, 20031);
    let on = &mut || ControlFlow::Continue(());
    let row = falsified_trial(&kind, (Excitation::Rich, &robot(), 3000), options(seed), on).expect("a row");
    assert!(!row.is_answered() && row.nees.expect("a NEES") > 26.12, "{row:?}");
    assert!(row.warnings.iter().any(|kind| kind == "few_informative_contacts"), "{row:?}");
    // Warnings that forbid the use come first, and one does.
    assert_eq!(row.warnings.first().map(String::as_str), Some("prediction_contradicted"), "{row:?}");
}

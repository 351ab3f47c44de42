//! Declarations that are wrong in kind are named, and true ones are not.

use std::f64::consts::FRAC_PI_2;
use std::ops::ControlFlow;

use nalgebra::{UnitQuaternion, Vector3};
use touchcal::contact::ContactLog;
use touchcal::estimate::{DeclarationMistake, DeclaredLength, Problem, Status, Warning, inspect};
use touchcal::experiment::falsified::{Excitation, FalsifiedKind};
use touchcal::experiment::problem;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{KinematicParameter, Robot, calibrated};
use touchcal::se3::Pose;
use touchcal::sim::{self, Preset};

use crate::support::{data, mujoco_trial, mujoco_trials, solve};

fn arm(name: &str) -> Robot {
    urdf::read_builtin(name, Ends::default()).expect("built in").robot
}

/// The problem of a simulated trial as `kind` declares it.
fn declared(kind: &str, excitation: Excitation, seed: u64) -> Problem {
    let kind = FalsifiedKind::by_name(kind).expect("a kind");
    let scenario = excitation.scenario(arm("iiwa14"), 1000).expect("a scenario");
    kind.problem(&scenario, &sim::simulate(&scenario, seed).expect("contacts"), seed).expect("a problem")
}

fn mistakes(warnings: &[Warning]) -> Vec<DeclarationMistake> {
    let of = |warning: &Warning| match warning {
        Warning::MistakenDeclaration { mistake, .. } => Some(mistake.clone()),
        _ => None,
    };
    warnings.iter().filter_map(of).collect()
}

/// The mistakes that an inspection names.
fn inspected(problem: &Problem) -> Vec<DeclarationMistake> {
    mistakes(&inspect(problem, &mut |_| ControlFlow::Continue(())).warnings)
}

/// The problem with the joint positions of each contact changed.
fn with_positions(problem: &Problem, change: impl Fn(&mut [f64])) -> Problem {
    let old = &problem.contacts;
    let mut contacts = ContactLog::new(old.dof());
    for i in 0..old.len() {
        let mut q = old.q(i).to_vec();
        change(&mut q);
        contacts.push(&q, old.fixture(i), old.source(i));
    }
    Problem { contacts, ..problem.clone() }
}

/// Names of the joints whose positions in the first contact differ between two problems.
fn differing(one: &Problem, other: &Problem) -> Vec<String> {
    let both = one.contacts.q(0).iter().zip(other.contacts.q(0));
    let named = one.robot.moving().zip(both).filter(|(_, (a, b))| a != b);
    named.map(|(joint, _)| joint.name.clone()).collect()
}

/// What a declaration is named by that is wrong in this kind.
fn expected(kind: &str, right: &Problem, wrong: &Problem) -> DeclarationMistake {
    match kind {
        "tool_in_metres" => unit(DeclaredLength::Tool, 1e3),
        "hole_in_metres" => unit(DeclaredLength::Fixture("hole".to_owned()), 1e3),
        "depth_in_metres" => unit(DeclaredLength::Depth("hole".to_owned()), 1e3),
        "tool_turned" => DeclarationMistake::ToolTurned { axis: 0, quarters: 2 },
        "tool_opposite" => DeclarationMistake::ToolOpposite,
        "joints_exchanged" => {
            let joints = differing(right, wrong).try_into().expect("two joints");
            DeclarationMistake::JointsExchanged { joints }
        }
        "joint_sign" => {
            let [joint] = differing(right, wrong).try_into().expect("a joint");
            DeclarationMistake::JointSign { joint }
        }
        "joints_reversed" => DeclarationMistake::JointsReversed,
        "joints_degrees" => DeclarationMistake::DegreesAsRadians,
        other => panic!("{other}"),
    }
}

#[track_caller]
fn is_named(kind: &str, excitation: Excitation, seed: u64) {
    let wrong = declared(kind, excitation, seed);
    let expected = expected(kind, &declared("nothing", excitation, seed), &wrong);
    assert_eq!(inspected(&wrong), std::slice::from_ref(&expected), "{kind}, {excitation:?}, {seed}");
    // A peg's search for what cannot be found takes seconds.
    if excitation == Excitation::Sockets {
        let estimate = solve(&wrong);
        assert_eq!(mistakes(&estimate.warnings), [expected], "{kind}, {excitation:?}, {seed}");
        assert_eq!(estimate.status, Status::NotUsable, "{kind}, {excitation:?}, {seed}");
    }
}

fn unit(of: DeclaredLength, factor: f64) -> DeclarationMistake {
    DeclarationMistake::LengthUnit { of, factor }
}

/// The kinds that a ball shows in sockets too, and those that only a peg shows in a hole.
const KINDS_OF_ALL: [&str; 6] =
    ["tool_in_metres", "tool_opposite", "joints_exchanged", "joint_sign", "joints_reversed", "joints_degrees"];
const KINDS_OF_PEGS: [&str; 3] = ["hole_in_metres", "depth_in_metres", "tool_turned"];

#[test]
fn mistakes_of_kind_are_named() {
    KINDS_OF_ALL.iter().for_each(|kind| is_named(kind, Excitation::Sockets, 2));
    KINDS_OF_PEGS.iter().for_each(|kind| is_named(kind, Excitation::Rich, 1));
}

#[test]
#[ignore = "long form: scripts/test long"]
fn mistakes_of_kind_are_named_with_each_excitation() {
    for seed in 1..=4 {
        for excitation in [Excitation::Paper, Excitation::Rich] {
            KINDS_OF_ALL.iter().chain(&KINDS_OF_PEGS).for_each(|kind| is_named(kind, excitation, seed));
        }
        KINDS_OF_ALL.iter().for_each(|kind| is_named(kind, Excitation::Sockets, seed));
    }
}

/// Where a declaration is wrong in kind no other start is searched from: there is no other minimum
/// to compete with what was found.
#[test]
fn a_problem_with_a_mistake_is_searched_once() {
    let estimate = solve(&declared("tool_in_metres", Excitation::Rich, 1));
    assert_eq!(mistakes(&estimate.warnings), [unit(DeclaredLength::Tool, 1e3)]);
    assert!(estimate.competing_minima.is_empty(), "{:?}", estimate.competing_minima);
}

#[test]
fn lengths_in_another_unit() {
    let mut everything = declared("tool_in_metres", Excitation::Paper, 1);
    everything.fixtures[0].base_from_fixture.as_mut().expect("a place").translation.vector *= 1e-3;
    assert_eq!(inspected(&everything), [unit(DeclaredLength::All, 1e3)]);

    let mut inches = declared("nothing", Excitation::Paper, 1);
    inches.tool.tip_from_tool.translation.vector /= 25.4;
    assert_eq!(inspected(&inches), [unit(DeclaredLength::Tool, 25.4)]);

    let mut distances = declared("nothing", Excitation::Sockets, 1);
    distances.distances[1].distance *= 1e3;
    let between = ["left/0", "left/1"].map(str::to_owned);
    assert_eq!(inspected(&distances), [unit(DeclaredLength::Distance(between), 1e-3)]);
    for k in [0, 2] {
        distances.distances[k].distance *= 1e3;
    }
    assert_eq!(inspected(&distances), [unit(DeclaredLength::Distances, 1e-3)]);
}

/// The problem in which contacts with the fixtures of these names are declared as those of the
/// other.
fn exchanged(problem: &Problem, names: [&str; 2]) -> Problem {
    let index = |name: &str| problem.fixtures.iter().position(|fixture| fixture.name == name).expect("a fixture");
    let [a, b] = names.map(index);
    let old = &problem.contacts;
    let mut contacts = ContactLog::new(old.dof());
    for i in 0..old.len() {
        let fixture = match old.fixture(i) {
            f if f == a => b,
            f if f == b => a,
            f => f,
        };
        contacts.push(old.q(i), fixture, old.source(i));
    }
    Problem { contacts, ..problem.clone() }
}

/// Of two blocks with two sockets each, exchanged contacts of one socket of each block cannot be
/// distinguished from exchanged contacts of the other two sockets.
#[test]
fn exchanged_fixtures_are_named() {
    for (names, others) in
        [(["front/0", "left/0"], ["front/1", "left/1"]), (["left/0", "right/1"], ["left/1", "right/0"])]
    {
        let found = inspected(&exchanged(&declared("nothing", Excitation::Sockets, 1), names));
        let [DeclarationMistake::FixturesExchanged { fixtures, or }] = found.as_slice() else { panic!("{found:?}") };
        let mut pairs = vec![fixtures.each_ref().map(String::as_str)];
        pairs.extend(or.iter().map(|pair| pair.each_ref().map(String::as_str)));
        pairs.sort_unstable();
        let mut expected = [names, others];
        expected.sort_unstable();
        assert_eq!(pairs, expected);
        let words = found[0].description();
        assert!(pairs.iter().flatten().all(|name| words.contains(&format!("`{name}`"))), "{words}");
    }
}

#[test]
fn radians_declared_as_degrees() {
    for excitation in [Excitation::Paper, Excitation::Sockets] {
        let right = declared("nothing", excitation, 1);
        let wrong = with_positions(&right, |q| q.iter_mut().for_each(|q| *q = q.to_radians()));
        assert_eq!(inspected(&wrong), [DeclarationMistake::RadiansAsDegrees], "{excitation:?}");
    }
}

/// A peg in a hole whose encoders have no prior: offsets of any size cannot make up for the
/// mistake.
#[test]
fn mistakes_are_named_where_offsets_are_free() {
    let scenario = Preset::Workcell.scenario(arm("iiwa14")).expect("a scenario");
    let right = problem(&scenario, &sim::simulate(&scenario, 3).expect("contacts"));
    assert_eq!(inspected(&right), []);
    let radians = with_positions(&right, |q| q.iter_mut().for_each(|q| *q = q.to_radians()));
    assert_eq!(inspected(&radians), [DeclarationMistake::RadiansAsDegrees]);
    let mut turned = right.clone();
    turned.tool.tip_from_tool.rotation = UnitQuaternion::identity();
    assert_eq!(inspected(&turned), [DeclarationMistake::ToolTurned { axis: 1, quarters: 2 }]);
}

/// With the peg every search is beside the hole; the answer is refused with the name of the
/// mistake.
#[test]
fn a_calibration_names_the_mistake() {
    let estimate = solve(&declared("tool_turned", Excitation::Paper, 1));
    assert_eq!(estimate.status, Status::NotUsable);
    let turned = DeclarationMistake::ToolTurned { axis: 0, quarters: 2 };
    assert_eq!(mistakes(&estimate.warnings), [turned], "{:?}", estimate.warnings);
}

/// Arms of one shape: described with 0.9 times the lengths, and with an upper arm 40 mm too short.
#[test]
fn another_arm_of_the_same_shape() {
    for seed in 1..=3 {
        let wrong = declared("other_arm", Excitation::Sockets, seed);
        let found = inspected(&wrong);
        let [DeclarationMistake::ArmLengths { segments }] = found.as_slice() else { panic!("{seed}: {found:?}") };
        for (name, described, true_length) in segments {
            let factor = true_length / described;
            assert!((factor * 0.9 - 1.0).abs() < 0.01, "{seed}, {name}: {factor}");
        }
        assert_eq!(solve(&wrong).status, Status::NotUsable);

        let mut wrong = declared("nothing", Excitation::Sockets, seed);
        wrong.robot = calibrated(&wrong.robot, &[KinematicParameter::SegmentStrain(1)], &[-40.0 / 420.0]);
        let found = inspected(&wrong);
        let [DeclarationMistake::ArmLengths { segments }] = found.as_slice() else { panic!("{seed}: {found:?}") };
        let (_, described, true_length) = &segments[1];
        // Twice the standard deviation of the ball's place.
        assert!((described - 0.38).abs() < 1e-9 && (true_length - 0.42).abs() < 4e-3, "{seed}: {segments:?}");
    }
}

#[test]
fn another_arm_by_name() {
    for excitation in [Excitation::Paper, Excitation::Sockets] {
        let right = declared("nothing", excitation, 1);
        let arms = vec![arm("panda"), arm("iiwa14")];
        let wrong = Problem { robot: arm("panda"), other_arms: arms, ..right };
        let name = "iiwa14".to_owned();
        assert_eq!(inspected(&wrong), [DeclarationMistake::OtherArm { name }], "{excitation:?}");
    }
}

/// Recorded logs with the robot description of another arm, whose tip is a ball at another place.
#[test]
fn another_arm_of_recorded_logs() {
    let folder = data().join("mukca");
    for (logs, file, name) in [("kuka_14", "panda.urdf", "iiwa14"), ("panda_3", "iiwa14.urdf", "panda")] {
        let urdf = urdf::read_file(&folder.join(file), Ends::default()).expect("a URDF");
        let problem = mukca::read(&folder.join(logs), urdf, &MukcaOptions::default()).expect("placements").problem;
        let name = name.to_owned();
        assert_eq!(inspected(&problem), [DeclarationMistake::OtherArm { name }], "{logs}");
    }
}

/// A hole turned by 110°, and a tool by 180°, declared in radians where degrees are asked for.
#[test]
fn rotations_in_radians() {
    let in_radians = |place: &mut Pose| {
        let (roll, pitch, yaw) = place.rotation.euler_angles();
        let [roll, pitch, yaw] = [roll, pitch, yaw].map(f64::to_radians);
        place.rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    };
    let mut scenario = Excitation::Rich.scenario(arm("iiwa14"), 1000).expect("a scenario");
    let hole = scenario.touches[0].base_from_fixture;
    scenario.touches[0].base_from_fixture.rotation =
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), FRAC_PI_2) * hole.rotation;
    let right = problem(&scenario, &sim::simulate(&scenario, 1).expect("contacts"));

    let mut wrong = right.clone();
    in_radians(wrong.fixtures[0].base_from_fixture.as_mut().expect("a place"));
    let fixture = "hole".to_owned();
    assert_eq!(inspected(&wrong), [DeclarationMistake::FixtureRotationInRadians { fixture }]);

    let mut wrong = right.clone();
    in_radians(&mut wrong.tool.tip_from_tool);
    assert_eq!(inspected(&wrong), [DeclarationMistake::ToolRotationInRadians]);
}

#[test]
fn true_declarations_of_simulations() {
    for preset in Preset::ALL {
        for seed in 1..=2 {
            let mut scenario = preset.scenario(arm("iiwa14")).expect("a scenario");
            scenario.contacts = scenario.contacts.min(600);
            let mut problem = problem(&scenario, &sim::simulate(&scenario, seed).expect("contacts"));
            problem.other_arms = vec![arm("panda")];
            assert_eq!(inspected(&problem), [], "{preset:?}, {seed}");
        }
    }
}

#[test]
fn true_declarations_of_recorded_logs() {
    let folder = data().join("mukca");
    for (logs, file) in [
        ("kuka_14", "iiwa14.urdf"),
        ("panda_1", "panda.urdf"),
        ("panda_3", "panda.urdf"),
        ("dinova_2", "gen3lite.urdf"),
    ] {
        let names = mukca::placement_names(&folder.join(logs)).expect("placements");
        for only in std::iter::once(Vec::new()).chain(names.into_iter().map(|name| vec![name])) {
            let urdf = urdf::read_file(&folder.join(file), Ends::default()).expect("a URDF");
            let options = MukcaOptions { only: only.clone(), ..MukcaOptions::default() };
            let problem = mukca::read(&folder.join(logs), urdf, &options).expect("placements").problem;
            assert_eq!(inspected(&problem), [], "{logs} {only:?}");
        }
    }
    // The other logs are calibrated by `recorded_logs`, and refused for any mistake.
    for profile in ["extrusion/paper", "extrusion/rich", "square/paper", "square/rich"] {
        for trial in mujoco_trials(profile).iter().take(2) {
            assert_eq!(inspected(&mujoco_trial(trial).0), [], "{trial}");
        }
    }
}

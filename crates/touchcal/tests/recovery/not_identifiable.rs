//! Problems whose data cannot answer the question: the answer must say so, and never be a confident
//! number.

use std::sync::Arc;

use crate::support::{data, mujoco_trial, report, solve};
use nalgebra::{UnitQuaternion, Vector3};
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::{
    Estimate, Fixture, Loss, Method, Noise, PlacePrior, Problem, ShapeTolerance, Status, Tool, Warning,
};
use touchcal::experiment;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::scenario_file;
use touchcal::io::urdf::{self, Ends};
use touchcal::manifold::Plane;
use touchcal::robot::{self, KinematicParameter, Kinematics};
use touchcal::se3::Pose;
use touchcal::sim::{follow, simulate};

/// Held at its prior mean without a standard deviation, or with one that says that the data told
/// nothing.
fn makes_no_claim(estimate: &Estimate, name: &str) -> bool {
    let found = estimate.parameter(name).expect("a parameter of that name");
    let vague = found.sigma.is_none_or(|sigma| {
        let before = found.parameter.prior_sigma().unwrap_or(found.parameter.scale);
        sigma > 0.5 * before
    });
    !found.identifiable && vague
}

fn words(estimate: &Estimate) -> String {
    estimate.identifiability.null_space.iter().map(|null| null.description.clone()).collect::<Vec<_>>().join("\n")
}

#[test]
fn one_free_socket_determines_neither_scale_nor_base_joint() {
    let folder = data().join("mukca");
    let file = urdf::read_file(&folder.join("iiwa14.urdf"), Ends::default()).expect("a URDF");
    let options = MukcaOptions { only: vec!["front".to_owned()], ..MukcaOptions::default() };
    let mut problem = mukca::read(&folder.join("kuka_14"), file, &options).expect("contacts").problem;
    let first = problem.contacts.filtered(|i| problem.contacts.fixture(i) == 0);
    problem.contacts = first;
    problem.fixtures.truncate(1);
    problem.distances.clear();
    problem.tool.prior = PlacePrior::Flat;
    problem.parameters = vec![touchcal::parameter::strain()];
    problem.parameters.extend(touchcal::parameter::joint_offset(&problem.robot));
    let estimate = solve(&problem);
    println!("{:?}\n{}\n{:#?}", estimate.status, words(&estimate), estimate.warnings);
    for name in ["strain", "joint_offset.joint_a1"] {
        assert!(makes_no_claim(&estimate, name), "{name}: {:?}", estimate.parameter(name));
    }
    assert!(words(&estimate).contains("encoder offset of joint_a1"), "{}", words(&estimate));
}

#[test]
fn hole_and_base_joint_cannot_both_be_found() {
    let (mut problem, truth) = mujoco_trial("extrusion/paper/trial_00");
    problem.fixtures[0].prior = PlacePrior::Flat;
    let estimate = solve(&problem);
    println!("{:?}\n{}\n{:#?}", estimate.status, words(&estimate), estimate.warnings);
    assert!(makes_no_claim(&estimate, "joint_offset.joint_a1"), "{:?}", estimate.parameter("joint_offset.joint_a1"));
    assert!(makes_no_claim(&estimate, "fixture.hole.rz"), "{:?}", estimate.parameter("fixture.hole.rz"));
    assert_eq!(estimate.parameter("joint_offset.joint_a1").map(|p| p.value), Some(0.0), "held at zero");
    let words = words(&estimate);
    assert!(words.contains("encoder offset of joint_a1") && words.contains("rz of fixture hole"), "{words}");
    assert!(estimate.warnings.iter().any(|warning| matches!(warning, Warning::Unobservable { .. })));
    // What can be told is still right.
    for (estimated, truth) in estimate.parameters[2..8].iter().zip(&truth.offset[1..]) {
        let sigma = estimated.sigma.expect("determined");
        assert!((estimated.value - truth).abs() < 4.0 * sigma, "{}: {}", estimated.parameter.name, estimated.value);
        assert!(sigma < 0.2f64.to_radians());
    }
    let remedy = |estimate: &Estimate, fixture: &str| {
        let mut null_space = estimate.identifiability.null_space.iter();
        null_space.find(|null| null.description.contains(fixture)).and_then(|null| null.remedy.clone())
    };
    let of_hole = "smaller standard deviations of the place of fixture hole";
    assert_eq!(remedy(&estimate, "fixture hole").as_deref(), Some(of_hole));
    problem.fixtures[0].name = "hole.1".to_owned();
    assert_eq!(remedy(&solve(&problem), "fixture hole.1"), Some(format!("{of_hole}.1")));
}

/// A stylus that touches one horizontal table: nothing is said of the plane's own directions.
fn table(parameters: fn(&robot::Robot) -> Vec<touchcal::parameter::Parameter>) -> Problem {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let tip_from_tool = Pose::translation(0.0, 0.0, 0.1);
    let kinematics = Kinematics::new(&robot, &[], tip_from_tool);
    let mut contacts = ContactLog::new(7);
    let mut q = vec![0.0, 0.5, 0.0, -1.5, 0.0, 1.1, 0.0];
    let posture = q.clone();
    for i in 0..400u32 {
        let phase = f64::from(i);
        let (x, y) = (0.55 + 0.1 * (phase * 0.7).sin(), 0.15 * (phase * 0.31).cos());
        let tilt = Vector3::new(0.3 * (phase * 1.3).sin(), 0.3 * (phase * 0.9).cos(), 0.4 * (phase * 0.23).sin());
        let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
        let target = Pose::from_parts(Vector3::new(x, y, 0.1).into(), UnitQuaternion::from_scaled_axis(tilt) * down);
        q = follow(&kinematics, &target, &q, &posture).expect("within reach");
        contacts.push(&q, 0, Source { file: 0, line: u64::from(i) + 1 });
    }
    Problem {
        parameters: parameters(&robot),
        robot,
        tool: Tool { tip_from_tool, prior: PlacePrior::Fixed },
        fixtures: vec![Fixture {
            name: "table".to_owned(),
            manifold: Arc::new(Plane::ball(0.0)),
            base_from_fixture: Some(Pose::translation(0.0, 0.0, 0.1)),
            prior: PlacePrior::Fixed,
            tolerance: ShapeTolerance::EXACT,
            placement: String::new(),
        }],
        distances: Vec::new(),
        contacts,
        noise: Noise { encoder: 1e-5, contact: 1e-5, is_estimated: false },
        joint_drift: false,
        trend_variable: touchcal::estimate::TrendVariable::Log,
        wrench: touchcal::estimate::WrenchTolerance::DEFAULT,
        method: Method::LevenbergMarquardt,
        loss: Loss::GemanMcClure(3.0),
        options: touchcal::estimate::EstimatorOptions::default(),
        held_out: ContactLog::default(),
        acceptance: None,
        other_arms: Vec::new(),
    }
}

#[test]
fn one_plane_does_not_calibrate_an_arm() {
    let estimate = solve(&table(touchcal::parameter::joint_origin));
    println!(
        "{:?} rank {}\n{}\n{:#?}",
        estimate.status,
        estimate.identifiability.rank,
        words(&estimate),
        estimate.warnings
    );
    assert!(!estimate.identifiability.null_space.is_empty());
    for name in ["joint_origin.joint_a1.x", "joint_origin.joint_a1.y", "joint_origin.joint_a1.rz"] {
        assert!(makes_no_claim(&estimate, name), "{name}: {:?}", estimate.parameter(name));
    }
    let estimate = solve(&table(touchcal::parameter::joint_offset));
    println!("{:?}\n{}\n{:#?}", estimate.status, words(&estimate), estimate.warnings);
    assert!(makes_no_claim(&estimate, "joint_offset.joint_a1"));
}

#[test]
fn no_contacts_and_too_few_contacts_are_outcomes() {
    let (mut problem, _) = mujoco_trial("extrusion/paper/trial_00");
    problem.contacts = problem.contacts.filtered(|i| i < 5);
    let estimate = solve(&problem);
    println!("{:?} {:#?}", estimate.status, estimate.warnings);
    assert_eq!(estimate.status, Status::NotUsable);
    assert!(matches!(estimate.warnings[0], Warning::TooFewContacts { .. }));
    problem.contacts = problem.contacts.filtered(|_| false);
    let estimate = solve(&problem);
    assert_eq!(estimate.status, Status::NotUsable);
    assert!(estimate.parameters.iter().all(|p| p.value == 0.0 && !p.identifiable));
}

/// A UR10 with a ball in two blocks of two sockets of unknown place.
fn ur10_in_sockets(seed: u64) -> (Problem, Vec<f64>) {
    let fixture = |name: &str, pan: f64, [x, y]: [f64; 2]| {
        format!(
            "[[fixture]]\nname = \"{name}\"\nkind = \"socket\"\nfree = true\n\
             base_from_fixture = {{ xyz_mm = [{x}, {y}, 150] }}\npostures_deg = [[{pan}, -60, 100, -130, -90, 0]]\n\
             exploration = {{ radius_mm = 0, tilt_deg = 25, press_mm = 10, lift_mm = 0, swing_deg = 20 }}\n"
        )
    };
    let fixtures = [
        fixture("a/0", 0.0, [-700.0, -100.0]),
        fixture("a/1", 0.0, [-750.0, -100.0]),
        fixture("b/0", 40.0, [-500.0, -500.0]),
        fixture("b/1", 40.0, [-550.0, -500.0]),
    ];
    let distance = |block: &str| format!("[[distance]]\nbetween = [\"{block}/0\", \"{block}/1\"]\nsigma_mm = 0.05\n");
    let text = format!(
        "contacts = 40\nfriction = 0.1\ncontact_mm = 0.03\n[robot]\nurdf = \"ur10.urdf\"\n\
         [errors]\ndistribution = \"normal\"\njoint_offset_deg = 0.3\n\
         [tool]\nkind = \"ball\"\ntip_from_tool = {{ xyz_mm = [0, 0, 120] }}\nsigma_mm = 1\n{}{}{}",
        fixtures.concat(),
        distance("a"),
        distance("b")
    );
    let scenario = scenario_file::read(&text, "scenario.toml", &data().join("ur10")).expect("a scenario").scenario;
    let simulated = simulate(&scenario, seed).expect("contacts");
    let (columns, values) = simulated.truth.of_kinematics();
    let offset = |joint: usize| {
        let k = columns.iter().position(|column| *column == KinematicParameter::JointOffset(joint));
        k.map_or(0.0, |k| values[k])
    };
    let truth = (0..6).map(offset).collect();
    let problem = experiment::problem(&scenario, &simulated);
    let parameters = touchcal::parameter::joint_offset(&problem.robot);
    (problem.with_parameters(parameters), truth)
}

/// The shoulder's offset compensates the sockets' places. A small part of that is the elbow's,
/// which contacts determine all the same: it has a standard deviation, which allows for that part.
#[test]
fn a_small_part_of_what_is_fixed_widens_a_parameter() {
    let mut squares = Vec::new();
    for seed in 1..=8 {
        let (problem, truth) = ur10_in_sockets(seed);
        let estimate = solve(&problem);
        let offset = |joint: usize| &estimate.parameters[joint];
        assert!(!offset(0).identifiable && offset(0).sigma.is_none(), "{:?}", offset(0));
        let elbow = offset(2);
        let sigma = elbow.sigma.expect("a standard deviation");
        assert!(elbow.identifiable && sigma < 0.4f64.to_radians(), "{seed}: {elbow:?}");
        squares.extend((1..5).filter_map(|k| Some(((offset(k).value - truth[k]) / offset(k).sigma?).powi(2))));
        assert!(
            estimate.parameters.iter().any(|entry| !entry.identifiable && entry.parameter.name.starts_with("fixture"))
        );
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    report("error over standard deviation of offsets", &[("rms", rms), ("count", squares.len() as f64)]);
    assert!(rms < 1.3, "{rms}");
}

/// What no contact of the fit touches is not asked of the contacts: places of such fixtures are no
/// parameters, and do not make contacts too few.
#[test]
fn untouched_fixtures_of_unknown_place_are_no_parameters() {
    let folder = data().join("mukca");
    let file = urdf::read_file(&folder.join("iiwa14.urdf"), Ends::default()).expect("a URDF");
    let options = MukcaOptions { only: vec!["front".to_owned()], ..MukcaOptions::default() };
    let mut problem = mukca::read(&folder.join("kuka_14"), file, &options).expect("contacts").problem;
    problem.parameters = touchcal::parameter::joint_offset(&problem.robot);
    let before = solve(&problem);
    // With their places there would be more parameters without a prior than measured rows.
    let rows = 3 * problem.contacts.len() + problem.distances.len();
    let other = problem.fixtures[0].clone();
    for k in 0..rows.div_ceil(3) {
        problem.fixtures.push(Fixture { name: format!("other/{k}"), placement: "front".to_owned(), ..other.clone() });
    }
    let inspection = touchcal::estimate::inspect(&problem, &mut |_| std::ops::ControlFlow::Continue(()));
    let estimate = solve(&problem);
    let is_too_few = |warning: &Warning| matches!(warning, Warning::TooFewContacts { .. });
    assert!(!estimate.warnings.iter().any(is_too_few) && !inspection.warnings.iter().any(is_too_few));
    let is_unobservable = |warning: &Warning| matches!(warning, Warning::Unobservable { .. });
    let unobservable = |estimate: &Estimate| estimate.warnings.iter().filter(|w| is_unobservable(w)).count();
    assert_eq!(unobservable(&estimate), unobservable(&before));
    // Nothing else changes.
    assert_eq!(estimate.parameters, before.parameters);
    assert_eq!(estimate.covariance, before.covariance);
    assert_eq!(estimate.identifiability.rank, before.identifiability.rank);
    assert_eq!(inspection.parameters.len(), before.parameters.len());
    let is_missing = |warning: &&Warning| matches!(warning, Warning::FixtureWithoutContacts { .. });
    assert_eq!(estimate.warnings.iter().filter(is_missing).count(), rows.div_ceil(3));
}

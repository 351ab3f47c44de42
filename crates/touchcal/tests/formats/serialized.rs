//! Problems as data for other processes.

use std::sync::Arc;

use nalgebra::Vector3;
use touchcal::contact::{ContactLog, Source, target_pose};
use touchcal::estimate::{Fixture, PlacePrior, Problem, ShapeTolerance, Tool};
use touchcal::geometry::{EdgeRadii, Polygon, PrismPair};
use touchcal::io::urdf::{Ends, read_builtin};
use touchcal::manifold::coordinates::Metric;
use touchcal::manifold::{
    BallInSocket, ContactManifold, NearestSample, PegInHole, Plane, PoseSamples, Projected, ResidualKind, Target,
    Unmodeled,
};
use touchcal::parameter::{
    Parameter, Prior, joint_backlash, joint_compliance, joint_drift, joint_gear_ratio, joint_harmonic,
    joint_harmonic_2, joint_offset, joint_origin, joint_trend, strain,
};
use touchcal::robot::{JointKind, Robot};
use touchcal::se3::Pose;

/// An arm whose second moving joint is prismatic.
fn robot() -> Robot {
    let arm = read_builtin("iiwa14", Ends::default()).unwrap().robot;
    let mut joints = arm.joints().to_vec();
    joints.iter_mut().filter(|joint| joint.kind != JointKind::Fixed).nth(1).unwrap().kind = JointKind::Prismatic;
    Robot::new(arm.name(), arm.base(), joints).unwrap()
}

fn fixture(name: &str, manifold: Arc<dyn ContactManifold>) -> Fixture {
    Fixture {
        name: name.to_owned(),
        manifold,
        base_from_fixture: Some(Pose::translation(0.1, 1.0 / 3.0, -0.2)),
        prior: PlacePrior::DEFAULT_FIXTURE,
        tolerance: ShapeTolerance::DEFAULT,
        placement: "here".to_owned(),
    }
}

fn problem() -> Problem {
    let peg = Polygon::extrusion25();
    let hole = peg.offset_mitred(0.5e-3).unwrap();
    let shapes = PrismPair::new(peg, 0.04, hole, 0.03).unwrap();
    let shapes = shapes.with_edge_radii(EdgeRadii { peg: 2e-4, hole: 1e-4 }).unwrap();
    let poses: Vec<Pose> = (0..9).map(|k| Pose::translation(0.1 * f64::from(k), (f64::from(k)).sin(), 0.0)).collect();
    let samples = PoseSamples::from_poses(&poses).unwrap();
    let nearest = NearestSample::new(samples, Metric { metres_per_radian: 0.07 }).with_neighbours(3);
    let fixtures = vec![
        fixture("socket", Arc::new(BallInSocket)),
        fixture("plane", Arc::new(Plane::ball(0.01))),
        fixture("hole", Arc::new(PegInHole::with_depth(shapes, 0.025))),
        fixture("samples", Arc::new(Projected(Arc::new(nearest)))),
        fixture("unknown", Arc::new(Unmodeled)),
        fixture("target", Arc::new(Target::AlongNormal { radius: 2e-3 })),
    ];
    let robot = robot();
    let mut contacts = ContactLog::new(robot.dof());
    contacts.add_file("log.csv");
    for k in 0..6_u32 {
        let q: Vec<f64> = (0..robot.dof()).map(|j| (0.37 * f64::from(k) + j as f64).sin()).collect();
        contacts.push(&q, k as usize, Source { file: 0, line: u64::from(k) + 1 });
    }
    contacts.set_joint_torques(&vec![0.1; robot.dof()]);
    contacts.set_target(target_pose(Vector3::new(0.1, 0.2, 1.0 / 7.0), Some(Vector3::new(1.0, 2.0, 3.0))).unwrap());
    let blocks: [Vec<Parameter>; 10] = [
        vec![strain()],
        joint_offset(&robot),
        joint_drift(&robot, 0, "here"),
        joint_trend(&robot),
        joint_harmonic(&robot),
        joint_harmonic_2(&robot),
        joint_gear_ratio(&robot),
        joint_origin(&robot),
        joint_compliance(&robot),
        joint_backlash(&robot),
    ];
    let tool = Tool { tip_from_tool: Pose::translation(0.0, 0.0, 0.1), prior: PlacePrior::DEFAULT_TOOL };
    Problem::new(robot, tool, fixtures, contacts).with_parameters(blocks.concat())
}

#[test]
fn a_problem_is_the_same_afterwards() {
    let before = problem();
    let text = serde_json::to_string(&before).unwrap();
    let after: Problem = serde_json::from_str(&text).unwrap();
    assert_eq!(format!("{after:?}"), format!("{before:?}"));
    assert_eq!(serde_json::to_string(&after).unwrap(), text);
}

/// A manifold of one's own.
#[derive(Debug)]
struct Own;

impl ContactManifold for Own {
    fn name(&self) -> &'static str {
        "own"
    }

    fn residual(&self, _: &Pose, _: f64, _: &mut touchcal::manifold::Residual) {}

    fn residual_kind(&self) -> ResidualKind {
        ResidualKind::Unmodeled
    }

    fn fixture_directions(&self) -> &'static [usize] {
        &[]
    }

    fn tool_directions(&self) -> &'static [usize] {
        &[]
    }
}

#[test]
fn what_has_no_data_is_refused() {
    let error = serde_json::to_string(&fixture("own", Arc::new(Own))).unwrap_err().to_string();
    assert_eq!(error, "a manifold `own` of one's own has no data");
    // Shapes are checked as in files.
    let text = serde_json::to_string(&problem()).unwrap().replace("[0.04", "[-0.04").replace(",0.04]", ",-0.04]");
    let error = serde_json::from_str::<Problem>(&text).unwrap_err().to_string();
    assert!(error.contains("length"), "{error}");
    let text = serde_json::to_string(&problem().fixtures).unwrap();
    let samples = text.find("\"samples\":[[").unwrap();
    let end = samples + text[samples..].find("]]").unwrap();
    let one = text[samples..].find(']').unwrap() + samples;
    let error = serde_json::from_str::<Vec<Fixture>>(&format!("{}{}", &text[..one], &text[end..])).unwrap_err();
    assert!(error.to_string().contains("at least two different poses, found 1 in 1"), "{error}");
    // The second vertex as the first.
    let outline = text.find("\"peg\":[[[").unwrap() + 9;
    let [first, second] = [0, 1].map(|k| text[outline..].split("],").nth(k).unwrap());
    let error = serde_json::from_str::<Vec<Fixture>>(&text.replacen(second, &format!("[{first}"), 1)).unwrap_err();
    assert!(error.to_string().contains("the same point twice"), "{error}");
}

#[test]
fn infinite_numbers_need_a_format_that_has_them() {
    let mut before = problem();
    before.parameters[0].prior = Prior::Gaussian { sigma: f64::INFINITY };
    let mut bytes = Vec::new();
    ciborium::into_writer(&before, &mut bytes).unwrap();
    let after: Problem = ciborium::from_reader(bytes.as_slice()).unwrap();
    assert_eq!(after.parameters, before.parameters);
    assert_eq!(format!("{after:?}"), format!("{before:?}"));
    assert!(serde_json::from_str::<Problem>(&serde_json::to_string(&before).unwrap()).is_err());
}

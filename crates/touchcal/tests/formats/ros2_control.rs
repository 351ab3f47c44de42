//! Encoder offsets in the transmissions of ros2_control.

use std::path::Path;

use touchcal::contact::ContactLog;
use touchcal::estimate::{PlacePrior, Problem, Tool, workspace_configurations};
use touchcal::io::problem_file::Assumptions;
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{Export, Loaded};
use touchcal::robot::{KinematicParameter, Kinematics, Robot, calibrated};
use touchcal::se3::Pose;

/// Reduction and offset of joint number `k`.
fn transmission(k: usize) -> (f64, f64) {
    (50.0 - 20.0 * k as f64, 0.3 * (k as f64).cos())
}

/// A UR10 whose controller has transmissions.
fn arm() -> Loaded {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/ur10/ur10.urdf");
    let mut file = urdf::read_file(&path, Ends::default()).unwrap();
    let each = file.robot.moving().enumerate().map(|(k, joint)| {
        let (reduction, offset) = transmission(k);
        format!(
            "<transmission name=\"t{k}\"><plugin>transmission_interface/SimpleTransmission</plugin><joint name=\"{}\">\
             <mechanical_reduction>{reduction}</mechanical_reduction><offset>{offset}</offset></joint></transmission>",
            joint.name
        )
    });
    let system =
        format!("<ros2_control name=\"s\" type=\"system\">{}</ros2_control></robot>", each.collect::<String>());
    file.text = file.text.replace("</robot>", &system);
    let tool = Tool { tip_from_tool: Pose::identity(), prior: PlacePrior::Fixed };
    let problem = Problem::new(file.robot, tool, Vec::new(), ContactLog::new(6));
    Loaded {
        problem,
        urdf: file.text,
        inputs: Vec::new(),
        settings: String::new(),
        assumptions: Assumptions::default(),
    }
}

fn offsets(text: &str) -> Vec<f64> {
    text.split("<offset>").skip(1).map(|rest| rest.split('<').next().unwrap().parse().unwrap()).collect()
}

fn poses(robot: &Robot) -> impl Fn(&[f64]) -> Pose {
    let kinematics = Kinematics::new(robot, &[], Pose::identity());
    move |q| kinematics.pose(q)
}

#[test]
fn actuators_put_the_tip_where_the_calibrated_arm_has_it() {
    let loaded = arm();
    let nominal = &loaded.problem.robot;
    let columns: Vec<KinematicParameter> = (0..6)
        .flat_map(|i| (0..6).map(move |k| KinematicParameter::JointOrigin(i, k)))
        .chain((0..6).map(KinematicParameter::JointOffset))
        .collect();
    let values: Vec<f64> = (0..columns.len()).map(|k| 5e-3 * (1.7 * k as f64).sin()).collect();
    let truth = calibrated(nominal, &columns, &values);
    let text = Export::Ros2Control.of(&truth, &loaded).unwrap().text;
    let controlled = urdf::read(&text, "text", Ends::default()).unwrap();
    let after = offsets(&text);
    assert_eq!(after.len(), 6);
    // What the driver makes of actuators: joint = actuator / reduction + offset.
    let positions = |q: &[f64]| -> Vec<f64> {
        let actuator = |k: usize| (q[k] - transmission(k).1) * transmission(k).0;
        (0..6).map(|k| actuator(k) / transmission(k).0 + after[k]).collect()
    };
    let (expected, found) = (poses(&truth), poses(&controlled));
    let difference = |q: Vec<f64>| {
        let between = expected(&q).inv_mul(&found(&positions(&q)));
        between.translation.vector.norm().max(between.rotation.angle())
    };
    let worst = workspace_configurations(nominal, 1000).into_iter().map(difference).fold(0.0, f64::max);
    assert!(worst < 1e-12, "{worst:e}");
    // Offsets alone leave all joint origins as they are, and change offsets by their negative.
    let only = calibrated(nominal, &[KinematicParameter::JointOffset(2)], &[0.02]);
    let text = Export::Ros2Control.of(&only, &loaded).unwrap().text;
    let change: Vec<f64> = offsets(&text).iter().enumerate().map(|(k, offset)| offset - transmission(k).1).collect();
    assert!((change[2] + 0.02).abs() < 1e-12, "{change:?}");
    let controlled = urdf::read(&text, "text", Ends::default()).unwrap();
    for (joint, before) in controlled.joints().iter().zip(nominal.joints()) {
        let moved = before.parent_from_joint.inv_mul(&joint.parent_from_joint);
        assert!(moved.translation.vector.norm() < 1e-12 && moved.rotation.angle() < 1e-12, "{}", joint.name);
    }
    // An arm without transmissions is refused before it is calibrated.
    let without = Loaded { urdf: loaded.urdf.replace("ros2_control", "other"), ..loaded };
    assert!(Export::Ros2Control.check(&without).is_err());
}

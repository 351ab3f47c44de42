//! Kinematics and their derivatives: against central differences, and against the folded chain that
//! is exported.

use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::Parameter;
use touchcal::robot::{self, KinematicParameter, Kinematics, Robot, calibrated, split_offsets};
use touchcal::se3::{self, Pose, Twist, Wrench};

fn all_columns(robot: &Robot) -> Vec<KinematicParameter> {
    let mut parameters: Vec<Parameter> = vec![touchcal::parameter::strain()];
    parameters.extend(touchcal::parameter::segment_strain(robot));
    parameters.extend(touchcal::parameter::joint_offset(robot));
    parameters.extend(touchcal::parameter::joint_origin(robot));
    let mut columns: Vec<KinematicParameter> =
        parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
    columns.extend((0..6).map(KinematicParameter::Tool));
    columns
}

/// Numbers spread over (−1, 1), the same at every call.
fn spread(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed;
    (0..count)
        .map(|_| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        })
        .collect()
}

fn tip_from_tool() -> Pose {
    se3::exp(&Twist::new(0.03, -0.02, 0.15, 0.3, 2.5, -0.4))
}

/// A lift, a bracket and a turntable: prismatic, fixed and continuous joints with skew axes.
const SLIDER: &str = r#"<robot name="slider"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="lift" type="prismatic"><origin xyz="0.1 0 0.2" rpy="0.1 0.2 0.3"/><parent link="a"/><child link="b"/>
<axis xyz="1 2 2"/><limit lower="0" upper="1"/></joint>
<joint name="mount" type="fixed"><origin xyz="0 0.1 0.3" rpy="1 0 0"/><parent link="b"/><child link="c"/></joint>
<joint name="turn" type="continuous"><origin xyz="0.2 0 0"/><parent link="c"/><child link="d"/><axis xyz="0 3 4"/></joint>
</robot>"#;

fn built_in(name: &str) -> Robot {
    urdf::read_builtin(name, Ends::default()).expect("built in").robot
}

fn robots() -> Vec<Robot> {
    let slider = urdf::read(SLIDER, "slider.urdf", Ends::default()).expect("a valid chain");
    ["iiwa14", "panda"].iter().map(|name| built_in(name)).chain([slider]).collect()
}

/// Every column of the one-pass Jacobian against central differences on the manifold; the error
/// must fall as h².
#[test]
fn jacobian_matches_central_differences() {
    for robot in robots() {
        let columns = all_columns(&robot);
        let mut kinematics = Kinematics::new(&robot, &columns, tip_from_tool());
        let theta: Vec<f64> = spread(columns.len(), 3).iter().map(|v| v * 0.1).collect();
        let q: Vec<f64> = spread(robot.dof(), 4).iter().map(|v| v * 2.0).collect();
        kinematics.set(&theta);
        let mut scratch = kinematics.scratch();
        let pose = kinematics.pose_and_jacobian(&q, &mut scratch);
        assert!((pose.to_homogeneous() - kinematics.pose(&q).to_homogeneous()).amax() < 1e-15);
        for (k, column) in columns.iter().enumerate() {
            let mut slope = |h: f64| {
                let mut at = |sign: f64| {
                    let mut moved = theta.clone();
                    moved[k] += sign * h;
                    kinematics.set(&moved);
                    se3::log(&(pose.inverse() * kinematics.pose(&q)))
                };
                (at(1.0) - at(-1.0)) / (2.0 * h)
            };
            let (coarse, fine) = (slope(2e-3), slope(1e-3));
            let (error, half) = ((coarse - scratch.parameters[k]).amax(), (fine - scratch.parameters[k]).amax());
            assert!(half < 0.3 * error || error < 1e-10, "{} {column:?}: {error} {half}", robot.name());
            let richardson = (fine * 4.0 - coarse) / 3.0;
            assert!((richardson - scratch.parameters[k]).amax() < 1e-9, "{} {column:?}", robot.name());
        }
        kinematics.set(&theta);
        for i in 0..robot.dof() {
            let slope = |h: f64| {
                let at = |sign: f64| {
                    let mut moved = q.clone();
                    moved[i] += sign * h;
                    se3::log(&(pose.inverse() * kinematics.pose(&moved)))
                };
                (at(1.0) - at(-1.0)) / (2.0 * h)
            };
            let richardson = (slope(1e-3) * 4.0 - slope(2e-3)) / 3.0;
            assert!((richardson - scratch.joints[i]).amax() < 1e-9, "{} joint {i}", robot.name());
        }
    }
}

/// The derivative by the load is exact, also where joints deflect by degrees; the error of central
/// differences must fall as h². It is the same for compliances that the arm declares.
#[test]
fn derivative_by_the_load_matches_central_differences() {
    for robot in robots() {
        let parameters = [touchcal::parameter::joint_compliance(&robot), touchcal::parameter::joint_origin(&robot)];
        let columns: Vec<KinematicParameter> =
            parameters.iter().flatten().filter_map(|parameter| parameter.id.kinematic()).collect();
        let is_compliance = |column: &KinematicParameter| matches!(column, KinematicParameter::JointCompliance(_));
        let each = columns.iter().zip(spread(columns.len(), 8));
        let theta: Vec<f64> = each.map(|(c, v)| if is_compliance(c) { 2e-3 * (1.5 + v) } else { 0.05 * v }).collect();
        let mut kinematics = Kinematics::new(&robot, &columns, tip_from_tool());
        kinematics.set(&theta);
        let q: Vec<f64> = spread(robot.dof(), 9).iter().map(|v| v * 2.0).collect();
        let load: Wrench = [5.0, -20.0, 10.0, 1.0, -2.0, 0.5];
        let mut scratch = kinematics.scratch();
        let pose = kinematics.pose_and_jacobian_under(&q, &load, &mut scratch);
        kinematics.differentiate_by_load(&mut scratch);
        for k in 0..6 {
            let slope = |h: f64| {
                let at = |sign: f64| {
                    let mut changed = load;
                    changed[k] += sign * h;
                    se3::log(&(pose.inverse() * kinematics.pose_under(&q, &changed)))
                };
                (at(1.0) - at(-1.0)) / (2.0 * h)
            };
            let (coarse, fine) = (slope(2.0), slope(1.0));
            let found = scratch.load.column(k);
            let (error, half) = ((coarse - found).amax(), (fine - found).amax());
            assert!(half < 0.3 * error || error < 1e-12, "{} component {k}: {error} {half}", robot.name());
            let richardson = (fine * 4.0 - coarse) / 3.0;
            assert!((richardson - found).amax() < 1e-10, "{} component {k}: {richardson} {found}", robot.name());
        }
        let folded = Kinematics::new(&calibrated(&robot, &columns, &theta), &[], tip_from_tool());
        let mut of_folded = folded.scratch();
        folded.pose_and_jacobian_under(&q, &load, &mut of_folded);
        folded.differentiate_by_load(&mut of_folded);
        assert!((of_folded.load - scratch.load).amax() < 1e-14, "{}", robot.name());
        // Nothing deflects a stiff arm.
        let stiff = Kinematics::new(&robot, &[], tip_from_tool());
        let mut of_stiff = stiff.scratch();
        stiff.pose_and_jacobian_under(&q, &load, &mut of_stiff);
        stiff.differentiate_by_load(&mut of_stiff);
        assert_eq!(of_stiff.load.amax(), 0.0);
    }
}

/// The exported chain, driven with measured positions, does what the parameterised one does.
#[test]
fn calibrated_chain_folds_all_parameters_of_the_arm() {
    for robot in robots() {
        let columns = all_columns(&robot);
        let arm: Vec<KinematicParameter> =
            columns.into_iter().filter(|column| !matches!(column, KinematicParameter::Tool(_))).collect();
        let theta: Vec<f64> = spread(arm.len(), 5).iter().map(|v| v * 0.1).collect();
        let mut kinematics = Kinematics::new(&robot, &arm, tip_from_tool());
        kinematics.set(&theta);
        let folded = Kinematics::new(&calibrated(&robot, &arm, &theta), &[], tip_from_tool());
        for seed in 0..20 {
            let q: Vec<f64> = spread(robot.dof(), seed).iter().map(|v| v * 3.0).collect();
            let difference = kinematics.pose(&q).to_homogeneous() - folded.pose(&q).to_homogeneous();
            assert!(difference.amax() < 1e-14, "{}: {}", robot.name(), difference.amax());
        }
    }
}

/// With its offsets in the driver and the rest in the file, an arm does what it does with all of it
/// in the file.
#[test]
fn a_driver_can_take_the_offsets() {
    for robot in robots() {
        let columns = all_columns(&robot);
        let theta: Vec<f64> = spread(columns.len(), 6).iter().map(|v| v * 0.1).collect();
        let calibrated = calibrated(&robot, &columns, &theta);
        let (rest, offsets) = split_offsets(&calibrated, &robot).expect("the same joints");
        let whole = Kinematics::new(&calibrated, &[], tip_from_tool());
        let rest = Kinematics::new(&rest, &[], tip_from_tool());
        for seed in 0..20 {
            let q: Vec<f64> = spread(robot.dof(), seed).iter().map(|v| v * 3.0).collect();
            let taken_off: Vec<f64> = q.iter().zip(&offsets).map(|(q, b)| q - b).collect();
            let difference = whole.pose(&q).to_homogeneous() - rest.pose(&taken_off).to_homogeneous();
            assert!(difference.amax() < 1e-14, "{}: {}", robot.name(), difference.amax());
        }
    }
}

/// Biases alone leave nothing in the file, even beyond a quarter of a turn.
#[test]
fn offsets_alone_come_back_and_leave_the_nominal_arm() {
    for robot in robots() {
        let columns: Vec<KinematicParameter> =
            touchcal::parameter::joint_offset(&robot).iter().filter_map(|parameter| parameter.id.kinematic()).collect();
        let biases: Vec<f64> = spread(columns.len(), 7).iter().map(|v| v * 3.0).collect();
        let (rest, offsets) = split_offsets(&calibrated(&robot, &columns, &biases), &robot).expect("the same joints");
        for (found, bias) in offsets.iter().zip(&biases) {
            assert!((found - bias).abs() < 1e-14, "{found} {bias}");
        }
        for (joint, nominal) in rest.joints().iter().zip(robot.joints()) {
            let left = joint.parent_from_joint.to_homogeneous() - nominal.parent_from_joint.to_homogeneous();
            assert!(left.amax() < 1e-14, "{}: {}", joint.name, left.amax());
        }
    }
    let [arm, other] = ["iiwa14", "panda"].map(built_in);
    assert_eq!(split_offsets(&arm, &other), None);
}

/// However many links a maker's file cuts them into, an iiwa has four lengths that can be told
/// apart.
#[test]
fn collinear_links_merge_into_segments() {
    let iiwa = built_in("iiwa14");
    let segments = robot::segments(&iiwa);
    let lengths: Vec<f64> = segments.iter().map(|segment| segment.length).collect();
    let expected = [0.360, 0.420, 0.400, 0.126];
    assert_eq!(lengths.len(), 4, "{segments:?}");
    assert!(lengths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{lengths:?}");
    let names: Vec<&str> = segments.iter().map(|segment| segment.name.as_str()).collect();
    assert_eq!(names, ["joint_a1..joint_a2", "joint_a3..joint_a4", "joint_a5..joint_a6", "joint_a7..flange_joint"]);
    let panda = built_in("panda");
    assert_eq!(robot::segments(&panda).len(), 6);
}

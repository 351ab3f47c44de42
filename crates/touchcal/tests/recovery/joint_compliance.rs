//! Joints that give way to gravity and to what presses on the tool: torques, derivatives, estimates
//! and files.

use super::ball_in_sockets::{SOCKETS, ball_in_sockets};
use crate::support::{report, solve, uniform};
use nalgebra::{Point3, Vector3};
use touchcal::estimate::{Estimate, Noise, Problem, evaluate};
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{
    Block, Parameter, Prior, joint_backlash, joint_compliance, joint_offset, joint_origin, segment_strain, strain,
};
use touchcal::robot::{JointKind, JointLoad, KinematicParameter, Kinematics, Robot, calibrated};
use touchcal::se3::{self, Pose, Twist, Wrench};

/// Turntable, fixed bracket, slide and wrist with skew axes; every moving joint carries a mass, the
/// bracket one more.
const WEIGHED: &str = r#"<robot name="weighed">
<link name="base"/>
<link name="table"><inertial><origin xyz="0.1 0.02 0.3" rpy="1 2 3"/><mass value="4"/></inertial></link>
<link name="bracket"><inertial><origin xyz="0 -0.1 0.05"/><mass value="1.5"/></inertial></link>
<link name="slide"><inertial><mass value="2.5"/></inertial></link>
<link name="wrist"><inertial><origin xyz="0.2 0.1 0"/><mass value="0.7"/></inertial></link>
<link name="tool"/>
<joint name="turn" type="continuous"><origin xyz="0.1 0 0.2" rpy="1.1 0.2 0.3"/><parent link="base"/><child link="table"/>
<axis xyz="1 2 2"/></joint>
<joint name="mount" type="fixed"><origin xyz="0 0.1 0.3" rpy="1 0 0"/><parent link="table"/><child link="bracket"/></joint>
<joint name="lift" type="prismatic"><origin xyz="0.2 0 0.1"/><parent link="bracket"/><child link="slide"/><axis xyz="0 3 4"/></joint>
<joint name="bend" type="revolute"><origin xyz="0.3 0.1 0" rpy="0.4 -1 0"/><parent link="slide"/><child link="wrist"/><axis xyz="0 1 0"/></joint>
<joint name="end" type="fixed"><origin xyz="0 0 0.2"/><parent link="wrist"/><child link="tool"/></joint>
</robot>"#;

fn built_in(name: &str) -> Robot {
    urdf::read_builtin(name, Ends::default()).expect("built in").robot
}

fn weighed() -> Robot {
    urdf::read(WEIGHED, "weighed.urdf", Ends::default()).expect("a valid chain")
}

fn normal(count: usize, seed: u64) -> Vec<f64> {
    let sums = uniform(12 * count, seed);
    sums.chunks(12).map(|twelve| twelve.iter().sum::<f64>() / 2.0).collect()
}

/// Position in base of `point` in the frame that joint number `joint` of the chain carries.
fn place(robot: &Robot, joint: usize, point: Vector3<f64>, q: &[f64]) -> Vector3<f64> {
    let part = Robot::new("part", "base", robot.joints()[..=joint].to_vec()).expect("a moving joint");
    let pose = Kinematics::new(&part, &[], Pose::identity()).pose(q);
    (pose * Point3::from(point)).coords
}

/// Masses (kg) and their places: the links' own, or else a kilogram in the middle of each moving
/// link and one at the tip.
fn masses(robot: &Robot, q: &[f64]) -> Vec<(f64, Vector3<f64>)> {
    let joints = robot.joints();
    let of_link = |(k, joint): (usize, &touchcal::robot::Joint)| {
        joint.inertia.map(|inertia| (inertia.mass, place(robot, k, inertia.center, q)))
    };
    let weighed: Vec<_> = joints.iter().enumerate().filter_map(of_link).collect();
    if !weighed.is_empty() {
        return weighed;
    }
    let moving = (0..joints.len()).filter(|&k| joints[k].kind != JointKind::Fixed);
    let ends: Vec<Vector3<f64>> =
        moving.chain([joints.len() - 1]).map(|k| place(robot, k, Vector3::zeros(), q)).collect();
    let links = ends.windows(2).map(|ends| (1.0, (ends[0] + ends[1]) / 2.0));
    links.chain(ends.last().map(|tip| (1.0, *tip))).collect()
}

/// Minus the slope of the potential energy of weights, less the work of `load` on the tip, by the
/// position of moving joint `i` of a stiff arm.
fn torque_by_energy(robot: &Robot, q: &[f64], load: &Wrench, i: usize) -> f64 {
    let kinematics = Kinematics::new(robot, &[], Pose::identity());
    let energy = |q: &[f64]| -> f64 { masses(robot, q).iter().map(|(mass, at)| -mass * robot.gravity().dot(at)).sum() };
    let at = |h: f64| {
        let mut moved = q.to_vec();
        moved[i] += h;
        let motion = se3::log(&(kinematics.pose(q).inverse() * kinematics.pose(&moved)));
        energy(&moved) - motion.dot(&Twist::from(*load))
    };
    let slope = |h: f64| (at(h) - at(-h)) / (2.0 * h);
    (slope(2e-3) - 4.0 * slope(1e-3)) / 3.0
}

/// Torques are the slopes of the energy where the deflected joints are, and the deflections the
/// compliances times the torques: the arm is at rest.
#[test]
fn torque_is_the_slope_of_the_potential_energy_and_the_work_of_the_load() {
    let tilted = Vector3::new(1.0, -3.0, 9.0);
    for robot in [built_in("iiwa14"), built_in("panda"), built_in("panda").with_gravity(tilted), weighed()] {
        let columns: Vec<KinematicParameter> = (0..robot.dof()).map(KinematicParameter::JointCompliance).collect();
        let stiff = Kinematics::new(&robot, &[], Pose::identity());
        for compliance in [0.0, 1e-4, 1e-3] {
            let mut kinematics = Kinematics::new(&robot, &columns, Pose::identity());
            kinematics.set(&vec![compliance; columns.len()]);
            let mut scratch = kinematics.scratch();
            for seed in 1..10 {
                let q: Vec<f64> = uniform(robot.dof(), seed).iter().map(|v| 2.0 * v).collect();
                let load: Wrench = std::array::from_fn(|k| 20.0 * uniform(6, seed + 50)[k]);
                let pose = kinematics.pose_and_jacobian_under(&q, &load, &mut scratch);
                // A prismatic joint has no compliance.
                let compliances = robot.moving().map(|joint| match joint.kind {
                    JointKind::Prismatic => 0.0,
                    _ => compliance,
                });
                let deflected = q.iter().zip(&scratch.torques).zip(compliances).map(|((q, torque), c)| q + c * torque);
                let deflected: Vec<f64> = deflected.collect();
                let difference = pose.to_homogeneous() - stiff.pose(&deflected).to_homogeneous();
                assert!(difference.amax() < 1e-12, "{}: {:e}", robot.name(), difference.amax());
                for (i, found) in scratch.torques.iter().enumerate() {
                    let torque = torque_by_energy(&robot, &deflected, &load, i);
                    assert!((found - torque).abs() < 1e-8, "{} joint {i}: {found} {torque}", robot.name());
                }
            }
        }
    }
}

/// All columns are exact. That of an offset is then that of the origin's rotation about the axis:
/// else contacts would seem to distinguish the two.
#[test]
fn jacobian_matches_central_differences() {
    for robot in [built_in("iiwa14"), built_in("panda"), weighed()] {
        let lengths = [vec![strain()], segment_strain(&robot)].concat();
        let parameters = [joint_compliance(&robot), joint_origin(&robot), joint_offset(&robot), lengths].concat();
        let columns: Vec<KinematicParameter> =
            parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
        let mut kinematics = Kinematics::new(&robot, &columns, Pose::translation(0.1, 0.05, 0.1));
        let theta: Vec<f64> =
            uniform(columns.len(), 3).iter().zip(&parameters).map(|(v, p)| 0.1 * v * p.scale).collect();
        let q: Vec<f64> = uniform(robot.dof(), 4).iter().map(|v| v * 2.0).collect();
        kinematics.set(&theta);
        let mut scratch = kinematics.scratch();
        let load: Wrench = [5.0, -20.0, 10.0, 1.0, -2.0, 0.5];
        let pose = kinematics.pose_and_jacobian_under(&q, &load, &mut scratch);
        assert!((pose.to_homogeneous() - kinematics.pose_under(&q, &load).to_homogeneous()).amax() < 1e-15);
        for (k, column) in columns.iter().enumerate() {
            let mut slope = |h: f64| {
                let mut at = |sign: f64| {
                    let mut moved = theta.clone();
                    moved[k] += sign * h;
                    kinematics.set(&moved);
                    se3::log(&(pose.inverse() * kinematics.pose_under(&q, &load)))
                };
                (at(1.0) - at(-1.0)) / (2.0 * h)
            };
            let error = ((slope(5e-4) * 4.0 - slope(1e-3)) / 3.0 - scratch.parameters[k]).amax();
            let allowed = 1e-7 * scratch.parameters[k].amax().max(1e-3);
            assert!(error <= allowed, "{} {column:?}: {error} of {}", robot.name(), scratch.parameters[k].amax());
        }
    }
}

/// Where joints have play too, also where their torques are about 0, of gravity and load or
/// measured.
#[test]
fn jacobian_with_backlash_matches_central_differences() {
    for robot in [built_in("iiwa14"), weighed()] {
        let offsets = [joint_offset(&robot), vec![strain()]].concat();
        let parameters = [joint_backlash(&robot), joint_compliance(&robot), joint_origin(&robot), offsets].concat();
        let columns: Vec<KinematicParameter> =
            parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
        let mut kinematics = Kinematics::new(&robot, &columns, Pose::translation(0.1, 0.05, 0.1));
        let size = |parameter: &Parameter| match parameter.id.block() {
            Block::JointBacklash => 5e-4,
            Block::JointCompliance => 1e-4,
            _ => 0.01,
        };
        let theta: Vec<f64> = uniform(columns.len(), 3).iter().zip(&parameters).map(|(v, p)| v * size(p)).collect();
        let q: Vec<f64> = uniform(robot.dof(), 4).iter().map(|v| v * 2.0).collect();
        let load: Wrench = [5.0, -20.0, 10.0, 1.0, -2.0, 0.5];
        let measured: Vec<f64> = uniform(robot.dof(), 5).iter().map(|v| v.powi(3)).collect();
        let mut scratch = kinematics.scratch();
        for load in [JointLoad::OnTip(&load), JointLoad::Torques(&measured)] {
            kinematics.set(&theta);
            let pose = kinematics.pose_and_jacobian_under(&q, load, &mut scratch);
            assert!((pose.to_homogeneous() - kinematics.pose_under(&q, load).to_homogeneous()).amax() < 1e-15);
            for (k, column) in columns.iter().enumerate() {
                let mut slope = |h: f64| {
                    let mut at = |sign: f64| {
                        let mut moved = theta.clone();
                        moved[k] += sign * h;
                        kinematics.set(&moved);
                        se3::log(&(pose.inverse() * kinematics.pose_under(&q, load)))
                    };
                    (at(1.0) - at(-1.0)) / (2.0 * h)
                };
                let h = 1e-2 * size(&parameters[k]);
                let error = ((slope(0.5 * h) * 4.0 - slope(h)) / 3.0 - scratch.parameters[k]).amax();
                // Rounding of poses over the step.
                let allowed = 1e-6 * scratch.parameters[k].amax().max(1e-3) + 1e-14 / h;
                assert!(error <= allowed, "{} {column:?}: {error:e} of {}", robot.name(), scratch.parameters[k].amax());
            }
        }
        // By the load: a wrench alone changes it.
        kinematics.set(&theta);
        kinematics.pose_and_jacobian_under(&q, &load, &mut scratch);
        kinematics.differentiate_by_load(&mut scratch);
        for k in 0..6 {
            let at = |by: f64| {
                let mut moved = load;
                moved[k] += by;
                kinematics.pose_under(&q, &moved)
            };
            let difference = se3::log(&(at(-1e-4).inverse() * at(1e-4))) / 2e-4;
            assert!((difference - scratch.load.column(k)).amax() < 1e-9, "{} {k}", robot.name());
        }
    }
}

/// The exported chain bends as the parameterised one does, and so does the one read from its URDF.
#[test]
fn calibrated_chain_bends_in_memory_and_as_urdf() {
    let built_in = ["iiwa14", "panda"].map(|name| urdf::read_builtin(name, Ends::default()).expect("built in"));
    let each = built_in.iter().map(|file| (file.robot.clone(), file.text.as_str()));
    for (robot, text) in each.chain([(weighed(), WEIGHED)]) {
        let parameters = [joint_compliance(&robot), joint_origin(&robot)].concat();
        let columns: Vec<KinematicParameter> =
            parameters.iter().filter_map(|parameter| parameter.id.kinematic()).collect();
        let theta: Vec<f64> = uniform(columns.len(), 5).iter().zip(&parameters).map(|(v, p)| v * p.scale).collect();
        let tool = Pose::translation(0.0, 0.1, 0.1);
        let mut kinematics = Kinematics::new(&robot, &columns, tool);
        kinematics.set(&theta);
        let calibrated = calibrated(&robot, &columns, &theta);
        assert!(calibrated.is_compliant() && !robot.is_compliant());
        let written = urdf::rewrite(text, &calibrated).expect("the same text");
        let ends = Ends { base: Some(robot.base()), tip: Some(robot.tip()) };
        let back = urdf::read(&written, "calibrated.urdf", ends).expect("a URDF");
        assert_eq!(urdf::rewrite(&written, &back).expect("the same text"), written);
        for (a, b) in calibrated.joints().iter().zip(back.joints()) {
            assert_eq!(a.compliance, b.compliance, "{}", a.name);
        }
        let [folded, read] = [&calibrated, &back].map(|robot| Kinematics::new(robot, &[], tool));
        for seed in 0..20 {
            let q: Vec<f64> = uniform(robot.dof(), seed).iter().map(|v| v * 3.0).collect();
            let pose = kinematics.pose(&q).to_homogeneous();
            for (bent, within) in [(&folded, 1e-13), (&read, 1e-12)] {
                let difference = (pose - bent.pose(&q).to_homogeneous()).amax();
                assert!(difference < within, "{}: {difference:e}", robot.name());
            }
        }
    }
}

#[test]
fn malformed_weights_and_compliances_are_refused() {
    let compliant =
        WEIGHED.replace("<axis xyz=\"1 2 2\"/>", "<axis xyz=\"1 2 2\"/><touchcal_compliance rad_per_nm='1e-4'/>");
    let robot = urdf::read(&compliant, "arm.urdf", Ends::default()).expect("a valid chain");
    assert_eq!(robot.joints()[0].compliance, 1e-4);
    let stiff = calibrated(&robot, &[KinematicParameter::JointCompliance(0)], &[-1e-4]);
    assert!(urdf::rewrite(&compliant, &stiff).expect("the same text").contains("rad_per_nm='0e0'"));
    let cases = [
        (
            "rad_per_nm='1e-4'",
            "rad_per_nm='soft'",
            ["joint `turn`, touchcal_compliance", "a finite number in `rad_per_nm`", "\"soft\""],
        ),
        ("rad_per_nm='1e-4'", "rad_per_nm='inf'", ["arm.urdf:9:", "a finite number", "\"inf\""]),
        ("rad_per_nm='1e-4'", "", ["arm.urdf:9:", "attribute `rad_per_nm` of <touchcal_compliance>", "none"]),
        ("continuous", "prismatic", ["joint `turn`, touchcal_compliance", "`revolute` or `continuous`", "`prismatic`"]),
        ("<mass value=\"4\"/>", "", ["link `table`, inertial", "a <mass value=\"…\"/>", "none"]),
        ("<mass value=\"4\"/>", "<mass/>", ["arm.urdf:3:", "attribute `value` of <mass>", "none"]),
        ("value=\"4\"", "value=\"-4\"", ["link `table`, inertial", "a mass of at least 0", "-4"]),
        ("value=\"4\"", "value=\"4 kg\"", ["link `table`, inertial", "a finite number in `value`", "\"4 kg\""]),
        ("0.1 0.02 0.3", "0.1 0.02", ["link `table`, inertial", "3 finite numbers in `xyz`", "\"0.1 0.02\""]),
    ];
    for (from, to, parts) in cases {
        assert!(compliant.contains(from), "{from}");
        let message =
            urdf::read(&compliant.replacen(from, to, 1), "arm.urdf", Ends::default()).expect_err(to).to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
}

/// Noise of joint positions (rad).
struct Noisy {
    sigma: f64,
    seed: u64,
}

/// A ball held in `sockets` (known places) by an arm of these errors.
fn touching(errors: &[(KinematicParameter, f64)], sockets: &[[f64; 3]], noise: &Noisy) -> Problem {
    let problem = ball_in_sockets(errors, sockets, |_, _, seed, q| {
        let noise = normal(7, 30_000 * noise.seed + seed).into_iter().map(|n| noise.sigma * n);
        (q.iter().zip(noise).map(|(q, n)| q + n).collect(), None)
    });
    Problem {
        parameters: joint_compliance(&problem.robot),
        noise: Noise { encoder: noise.sigma.max(1e-6), contact: 1e-6, is_estimated: false },
        ..problem
    }
}

fn compliances(estimate: &Estimate) -> Vec<f64> {
    let of = |entry: &&touchcal::estimate::ParameterEstimate| entry.parameter.id.block() == Block::JointCompliance;
    estimate.parameters.iter().filter(of).map(|entry| entry.value).collect()
}

#[test]
fn without_noise_compliances_and_offsets_are_found() {
    let truth: Vec<f64> = uniform(7, 7).iter().map(|v| 1e-4 * (1.0 + 0.5 * v)).collect();
    let offset: Vec<f64> = uniform(7, 8).iter().map(|v| 0.02 * v).collect();
    let softness = truth.iter().enumerate().map(|(i, &c)| (KinematicParameter::JointCompliance(i), c));
    let biases = offset.iter().enumerate().map(|(i, &b)| (KinematicParameter::JointOffset(i), b));
    let mut problem = touching(&softness.chain(biases).collect::<Vec<_>>(), &SOCKETS, &Noisy { sigma: 0.0, seed: 1 });
    let robot = problem.robot.clone();
    problem.parameters.extend(joint_offset(&robot));
    // A prior would pull by its share.
    problem.parameters.iter_mut().for_each(|parameter| parameter.prior = Prior::Flat);
    let estimate = solve(&problem);
    assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
    println!("{:?}\n{truth:?}", compliances(&estimate));
    // The first joint's axis is along gravity, the seventh's goes through all that it carries: no
    // torque about either.
    for joint in ["joint_compliance.joint_a1", "joint_compliance.joint_a7"] {
        let held = estimate.parameter(joint).expect("estimated");
        assert!(held.value == 0.0 && !held.identifiable, "{held:?}");
    }
    for (found, truth) in compliances(&estimate)[1..6].iter().zip(&truth[1..6]) {
        assert!((found - truth).abs() < 1e-9, "{found} {truth}");
    }
    problem.robot = estimate.robot;
    assert!(evaluate(&problem).all.max < 1e-8, "{:?}", evaluate(&problem).all);
}

/// Where nothing bends the learned width closes, from 1e-4 rad/(N m), and asking for compliances
/// hardly costs anything at other sockets.
#[test]
fn a_stiff_arm_is_found_stiff() {
    let (near, far) = SOCKETS.split_at(2);
    let (mut bent, mut straight) = (0.0, 0.0);
    for seed in 1..=10 {
        let noise = Noisy { sigma: 5e-5, seed };
        let mut rigid = touching(&[], near, &noise);
        rigid.parameters = joint_origin(&rigid.robot);
        let mut bending = touching(&[], near, &noise);
        bending.parameters.extend(rigid.parameters.clone());
        let scored = |problem: &Problem| {
            let estimate = solve(problem);
            assert!(estimate.status.is_usable(), "{:?}", estimate.warnings);
            let elsewhere = Problem { robot: estimate.robot.clone(), ..touching(&[], far, &noise) };
            (evaluate(&elsewhere).all.mean, estimate)
        };
        let ((error, estimate), (rigid_error, _)) = (scored(&bending), scored(&rigid));
        let width = estimate.parameters[0].parameter.prior_sigma().expect("learned");
        let found = compliances(&estimate);
        let figures = [("width", 1e6 * width), ("held out", 1e3 * error), ("rigid", 1e3 * rigid_error)];
        report(&format!("stiff arm, seed {seed}"), &figures);
        assert!(width < 1.2e-5, "{width:e}");
        assert!(found.iter().all(|c| c.abs() < 1.2e-5), "{found:?}");
        bent += error;
        straight += rigid_error;
    }
    assert!(bent < 1.05 * straight, "{bent} {straight}");
}

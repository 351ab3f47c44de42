//! Simulated logs against what they must be: poses, wrenches, bending, the recorder's faults.

use nalgebra::{Point2, Point3};
use touchcal::geometry::{GapQuery, Parts, Polygon, PrismPair};
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{Block, ParameterId};
use touchcal::robot::{KinematicParameter, Kinematics, Robot, calibrated, segments};
use touchcal::se3::{self, Pose, Twist};
use touchcal::sim::{self, ArmErrors, Distribution, Log, PlaceError, Preset, Scenario, Truth};

pub(crate) fn iiwa() -> Robot {
    urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot
}

pub(crate) fn paper(contacts: usize) -> Scenario {
    Scenario { contacts, ..Preset::Paper.scenario(iiwa()).expect("parts") }
}

/// A ball of 10 mm radius that wanders over a table.
fn table(contacts: usize) -> Scenario {
    let mut scenario = paper(contacts);
    scenario.touches[0].parts = Parts::OnPlane { points: vec![Point3::origin()], radius: 0.01 };
    scenario.touches[0].exploration.radius = 0.03;
    scenario
}

/// A hole so narrow that the tilted peg is wedged.
fn narrow(contacts: usize) -> Scenario {
    let mut scenario = paper(contacts);
    let parts = hole(&scenario);
    let outline = parts.peg().offset_mitred(0.25e-3).unwrap();
    let parts = PrismPair::new(parts.peg().clone(), parts.length(), outline, parts.depth()).unwrap();
    scenario.touches[0].parts = Parts::PegInHole(Box::new(parts));
    scenario
}

/// A shaft of 48 sides with a key. Edges of its end come to lie over the rim with both of their own
/// ends in the solid.
fn keyed(contacts: usize) -> Scenario {
    let outline = |radius: f64, half_key: f64, tip: f64| {
        let shoulder = (half_key / radius).asin();
        let round = (0..=48).map(|k| {
            let (sin, cos) = (shoulder + (std::f64::consts::TAU - 2.0 * shoulder) * f64::from(k) / 48.0).sin_cos();
            Point2::new(radius * cos, radius * sin)
        });
        let key = [Point2::new(tip, -half_key), Point2::new(tip, half_key)];
        Polygon::new(key.into_iter().chain(round).collect()).unwrap()
    };
    let mut scenario = paper(contacts);
    let parts = hole(&scenario);
    let (peg, wall) = (outline(12e-3, 3e-3, 15e-3), outline(12.5e-3, 3.5e-3, 15.5e-3));
    let parts = PrismPair::new(peg, parts.length(), wall, parts.depth()).unwrap();
    scenario.touches[0].parts = Parts::PegInHole(Box::new(parts));
    scenario
}

pub(crate) fn hole(scenario: &Scenario) -> &PrismPair {
    match &scenario.touches[0].parts {
        Parts::PegInHole(parts) => parts,
        _ => panic!("a hole"),
    }
}

fn only_log(scenario: &Scenario, seed: u64) -> Log {
    sim::simulate(scenario, seed).expect("contacts").logs.remove(0)
}

#[test]
fn parts_overlap_by_less_than_a_micrometre_and_touch_where_there_is_force() {
    let free = |friction: f64, seed: u64| (Scenario { friction, ..paper(1500) }, seed);
    let others = [(narrow(2500), 1), (keyed(1500), 1), (keyed(1500), 2)];
    for (scenario, seed) in [free(0.0, 1), free(0.2, 1), free(0.2, 2), free(0.4, 1)].into_iter().chain(others) {
        let scenario = Scenario { contact_sigma: 0.0, ..scenario };
        let log = only_log(&scenario, seed);
        for row in &log.truth {
            let gap = hole(&scenario).gap(&row.fixture_from_tool).value;
            assert!(gap > -1e-6, "{gap:e}");
            if row.force > 1e-2 {
                assert!(row.touching && gap < 1e-7, "{gap:e} at {} N", row.force);
            }
        }
    }
}

#[test]
fn a_seed_gives_the_same_log_and_more_contacts_only_a_longer_one() {
    let short = sim::simulate(&paper(200), 7).unwrap();
    assert_eq!(short, sim::simulate(&paper(200), 7).unwrap());
    assert_ne!(short.truth, sim::simulate(&paper(200), 8).unwrap().truth);
    let long = sim::simulate(&paper(300), 7).unwrap();
    assert_eq!(short.truth, long.truth);
    assert_eq!(short.logs[0].q[..], long.logs[0].q[..short.logs[0].q.len()]);
}

/// The arm, errors folded into it, puts the tool where the simulation says it is, whatever is off.
#[test]
fn joint_positions_reach_the_true_pose() {
    let mut scenario = paper(200);
    scenario.errors = ArmErrors {
        distribution: Distribution::Uniform,
        strain: 0.003,
        segment_strain: 0.001,
        joint_offset: 0.02,
        origin_length: 5e-4,
        origin_angle: 2e-3,
        origin_zero: 1e-2,
        joint_harmonic: 1e-3,
        joint_harmonic_2: 5e-4,
        joint_gear_ratio: 1e-3,
        ..ArmErrors::NONE
    };
    scenario.recorder.encoder_sigma = 0.0;
    scenario.tool_error = PlaceError { length: 1e-3, angle: 5e-3 };
    scenario.touches[0].place_error = PlaceError { length: 2e-3, angle: 4e-3 };
    let simulated = sim::simulate(&scenario, 5).unwrap();
    let truth = &simulated.truth;
    let twist = |column: fn(usize) -> ParameterId| Twist::from_fn(|k, _| truth.value(column(k)));
    let (columns, values) = truth.of_kinematics();
    let tip_from_tool = scenario.tip_from_tool * se3::exp(&twist(ParameterId::tool));
    let arm = Kinematics::new(&calibrated(&scenario.robot, &columns, &values), &[], tip_from_tool);
    let base_from_fixture = scenario.touches[0].base_from_fixture * se3::exp(&twist(|k| ParameterId::Fixture(0, k)));
    let log = &simulated.logs[0];
    for row in 0..log.len() {
        let pose = base_from_fixture * log.truth[row].fixture_from_tool;
        // An encoder's error is a function of what it measures.
        let mut q = log.q(row).to_vec();
        for (column, amplitude) in &truth.errors {
            if let ParameterId::EncoderError(joint, term) = column {
                q[*joint] -= amplitude * term.error(log.q(row)[*joint]);
            }
        }
        let apart = se3::log(&(arm.pose(&q).inverse() * pose)).amax();
        assert!(apart < 1e-10, "{apart:e}");
    }
    let blocks = |block| truth.errors.iter().filter(|(column, _)| column.block() == block).count();
    assert_eq!((blocks(Block::Fixture), blocks(Block::Tool), blocks(Block::JointOrigin)), (6, 6, 42));
    let of_encoders = [Block::JointHarmonic, Block::JointHarmonic2, Block::JointGearRatio].map(blocks);
    assert_eq!(of_encoders, [14, 14, 7]);
}

/// Without weight, an encoder on the motor's side reads less than the true angle by compliance
/// times the torque of what presses on the tool.
#[test]
fn a_joint_gives_way_to_the_load_by_compliance_times_torque() {
    const COMPLIANCE: f64 = 2e-4;
    let mut scenario = compliant(COMPLIANCE);
    scenario.robot = iiwa().with_gravity(nalgebra::Vector3::zeros());
    let log = only_log(&scenario, 2);
    let arm = Kinematics::new(&scenario.robot, &[], Pose::identity());
    let tool = Kinematics::new(&scenario.robot, &[], scenario.tip_from_tool);
    let mut most = 0f64;
    for row in (0..log.len()).step_by(7) {
        let wrench = Twist::from_row_slice(&log.wrench[row]);
        // Power of the wrench at the tip for a unit of joint speed, by central differences.
        let torque = |q: &[f64], i: usize| {
            let at = |by: f64| {
                arm.pose(&q.iter().enumerate().map(|(j, q)| if i == j { q + by } else { *q }).collect::<Vec<_>>())
            };
            (se3::log(&(at(-1e-6).inverse() * at(1e-6))) / 2e-6).dot(&wrench)
        };
        let mut q = log.q(row).to_vec();
        for _ in 0..5 {
            q = (0..7).map(|i| log.q(row)[i] + COMPLIANCE * torque(&q, i)).collect();
        }
        most = (0..7).map(|i| torque(&q, i).abs()).fold(most, f64::max);
        assert!(apart(&scenario, &log, row, tool.pose(&q)) < 1e-7, "row {row}");
    }
    assert!(most > 2.0, "torques of {most} N m");
}

/// With weight, the encoders read what puts the tool where it is under gravity and load together.
#[test]
fn an_arm_is_at_rest_under_gravity_and_load() {
    let mut scenario = compliant(2e-4);
    scenario.errors.joint_backlash = 3e-4;
    let log = only_log(&scenario, 2);
    let of_joint = |i| [KinematicParameter::JointCompliance(i), KinematicParameter::JointBacklash(i)];
    let columns: Vec<KinematicParameter> = (0..7).flat_map(of_joint).collect();
    let mut arm = Kinematics::new(&scenario.robot, &columns, scenario.tip_from_tool);
    arm.set(&[2e-4, 3e-4].repeat(7));
    for row in 0..log.len() {
        let apart = apart(&scenario, &log, row, arm.pose_under(log.q(row), &log.wrench[row]));
        assert!(apart < 1e-7, "row {row}: {apart:e}");
    }
}

/// A ball on a table, held by an arm without errors but for its compliance (rad/(N m)).
fn compliant(compliance: f64) -> Scenario {
    let mut scenario = table(60);
    scenario.errors = ArmErrors { joint_compliance: compliance, ..ArmErrors::NONE };
    scenario.recorder.encoder_sigma = 0.0;
    scenario
}

/// How far (m, rad) a pose of the tool is from where it truly is in a row.
fn apart(scenario: &Scenario, log: &Log, row: usize, base_from_tool: Pose) -> f64 {
    let truth = scenario.touches[0].base_from_fixture * log.truth[row].fixture_from_tool;
    se3::log(&(base_from_tool.inverse() * truth)).amax()
}

#[test]
fn wrenches_balance_the_springs_at_the_tip() {
    let mut scenario = table(200);
    scenario.touches[0].exploration.tilt = 0.0;
    scenario.touches[0].exploration.radius = 0.0;
    let log = only_log(&scenario, 1);
    for row in log.contacts() {
        let [fx, fy, fz, tx, ty, tz] = log.wrench[row];
        // The tool points down: what presses it up is −z of the tip, and has no lever about it.
        assert!((fz + log.truth[row].force).abs() < 1e-3 && log.truth[row].force > 3.0);
        assert!([fx, fy, tx, ty, tz].iter().all(|part| part.abs() < 1e-3), "{:?}", log.wrench[row]);
    }
}

#[test]
fn the_recorder_counts_misses_and_invents() {
    let mut scenario = paper(2000);
    let step = 1e-4;
    scenario.recorder.encoder_step = step;
    scenario.recorder.missed = 0.1;
    scenario.recorder.spurious = 0.3;
    let log = only_log(&scenario, 3);
    assert!(log.q.iter().all(|q| (q / step - (q / step).round()).abs() < 1e-6));
    let threshold = scenario.recorder.force_threshold;
    let free = log.contacts().filter(|&row| log.truth[row].force == 0.0).count() as f64 / 2000.0;
    assert!((free - 0.3 / (0.3 + 0.7 * 0.9)).abs() < 0.04, "{free}");
    let touching = |row: &usize| log.truth[*row].force > threshold;
    let touched = (0..log.len()).filter(touching).count() as f64;
    let missed = (0..log.len()).filter(touching).filter(|&row| !log.contact[row]).count() as f64 / touched;
    assert!((missed - 0.1).abs() < 0.03, "{missed}");
    let parts = hole(&scenario);
    for row in log.contacts().filter(|&row| !log.truth[row].touching) {
        let pose = log.truth[row].fixture_from_tool;
        assert!(parts.gap(&pose).value > 0.0 && pose.translation.z < 0.0 && pose.translation.z > -parts.depth());
    }
}

#[test]
fn force_sensors_are_noisy_and_biased() {
    let mut scenario = Scenario { contact_sigma: 0.0, ..table(1500) };
    let exact = only_log(&scenario, 4);
    scenario.recorder.force_sigma = 0.5;
    scenario.recorder.torque_sigma = 0.02;
    scenario.recorder.force_bias = 2.0;
    let noisy = only_log(&scenario, 4);
    let rows = exact.len().min(noisy.len());
    for (part, sigma) in [(0, 0.5), (2, 0.5), (4, 0.02)] {
        let off: Vec<f64> = (0..rows).map(|row| noisy.wrench[row][part] - exact.wrench[row][part]).collect();
        let mean = off.iter().sum::<f64>() / rows as f64;
        let spread = (off.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / rows as f64).sqrt();
        assert!((spread / sigma - 1.0).abs() < 0.1, "part {part}: {spread}");
        // The bias stays through the log: far from 0 for a force, none for a torque.
        assert_eq!(mean.abs() > 0.1, part < 3, "part {part}: {mean}");
    }
}

/// Bias and scale are drawn once, by the truth's seed, and change nothing else; their draws have
/// the recorder's standard deviations.
#[test]
fn bias_and_scale_of_the_wrench_are_those_of_the_truth() {
    let mut scenario = table(300);
    let exact = sim::simulate(&scenario, 4).unwrap();
    let of_wrench = |(id, _): &&(ParameterId, f64)| matches!(id.block(), Block::WrenchBias | Block::WrenchScale);
    assert_eq!(exact.truth.errors.iter().filter(of_wrench).count(), 0);
    scenario.recorder.force_bias = 0.5;
    scenario.recorder.torque_bias = 0.05;
    scenario.recorder.wrench_scale = 0.02;
    let draws: Vec<Truth> = (0..300).map(|seed| sim::draw_truth(&scenario, seed)).collect();
    for (id, sigma) in
        [(ParameterId::WrenchBias(1), 0.5), (ParameterId::WrenchBias(5), 0.05), (ParameterId::WrenchScale, 0.02)]
    {
        let square = draws.iter().map(|truth| (truth.value(id) / sigma).powi(2)).sum::<f64>() / 300.0;
        // Four standard deviations of the mean square of 300 normal numbers.
        assert!((square - 1.0).abs() < 4.0 * (2.0 / 300.0_f64).sqrt(), "{id:?}: {square}");
    }
    let wrong = sim::simulate(&scenario, 4).unwrap();
    let names: Vec<String> = wrong.truth.named(&scenario).into_iter().map(|(parameter, _)| parameter.name).collect();
    assert!(names.ends_with(&["wrench_bias.tz".to_owned(), "wrench_scale".to_owned()]), "{names:?}");
    let others: Vec<_> = wrong.truth.errors.iter().filter(|error| !of_wrench(error)).copied().collect();
    assert_eq!(others, exact.truth.errors);
    let rows = exact.logs[0].len().min(wrong.logs[0].len());
    let scale = 1.0 + wrong.truth.value(ParameterId::WrenchScale);
    for row in 0..rows {
        assert_eq!(exact.logs[0].q(row), wrong.logs[0].q(row));
        for k in 0..6 {
            let expected = scale * exact.logs[0].wrench[row][k] + wrong.truth.value(ParameterId::WrenchBias(k));
            // Both are rounded to the last digit.
            assert!((wrong.logs[0].wrench[row][k] - expected).abs() < 1.1e-4, "row {row}, {k}");
        }
    }
}

/// Readings with minus those without, at each contact.
fn encoder_changes(scenario: &Scenario, changing: &Scenario, seed: u64) -> Vec<Vec<f64>> {
    let (exact, changed) = (only_log(scenario, seed), only_log(changing, seed));
    let rows = exact.contacts().zip(changed.contacts());
    rows.map(|(one, other)| changed.q(other).iter().zip(exact.q(one)).map(|(q, exact)| q - exact).collect()).collect()
}

#[test]
fn trends_of_encoders_are_those_of_the_truth() {
    let scenario = table(300);
    let mut changing = scenario.clone();
    changing.recorder.encoder_trend = 1e-4;
    let truth = sim::draw_truth(&changing, 4);
    assert_eq!(truth.named(&changing).last().expect("a trend").0.name, "joint_trend.joint_a7");
    for (i, change) in encoder_changes(&scenario, &changing, 4).iter().enumerate() {
        for (joint, change) in change.iter().enumerate() {
            let expected = truth.value(ParameterId::JointTrend(joint)) * (2.0 * i as f64 / 299.0 - 1.0);
            assert!((change - expected).abs() < 1e-12, "contact {i}, {joint}: {change} {expected}");
        }
    }
}

/// An arm that warms up by 12 K: an exponential of which the log has three time constants, and
/// trends that are linear in it.
#[test]
fn trends_follow_the_temperature_of_an_arm_that_warms_up() {
    let scenario = table(300);
    let mut changing = scenario.clone();
    (changing.recorder.encoder_trend, changing.recorder.warm_up) = (1e-4, 12.0);
    let log = only_log(&changing, 4);
    assert!(only_log(&scenario, 4).arm_temperature.is_empty() && log.arm_temperature.len() == log.len());
    let temperatures: Vec<f64> = log.contacts().map(|row| log.arm_temperature[row]).collect();
    let truth = sim::draw_truth(&changing, 4);
    for (i, change) in encoder_changes(&scenario, &changing, 4).iter().enumerate() {
        let warmth = (1.0 - (-3.0 * i as f64 / 299.0).exp()) / (1.0 - (-3.0f64).exp());
        assert!((temperatures[i] - 20.0 - 12.0 * warmth).abs() < 0.6e-3, "contact {i}: {}", temperatures[i]);
        for (joint, change) in change.iter().enumerate() {
            let expected = truth.value(ParameterId::JointTrend(joint)) * (2.0 * warmth - 1.0);
            assert!((change - expected).abs() < 1e-12, "contact {i}, {joint}: {change} {expected}");
        }
    }
}

/// From the first contact to the last as far as declared, by steps, and zero on average.
#[test]
fn encoders_walk_at_random() {
    let scenario = table(200);
    let mut changing = scenario.clone();
    changing.recorder.encoder_walk = 1e-4;
    let (mut ends, mut steps) = (Vec::new(), Vec::new());
    for seed in 0..20 {
        let path = encoder_changes(&scenario, &changing, seed);
        for joint in 0..scenario.robot.dof() {
            assert!(path.iter().map(|change| change[joint]).sum::<f64>().abs() < 1e-10, "seed {seed}");
            ends.push(((path[199][joint] - path[0][joint]) / 1e-4).powi(2));
            steps.extend(path.windows(2).map(|pair| ((pair[1][joint] - pair[0][joint]) / 1e-4).powi(2) * 199.0));
        }
    }
    for squares in [ends, steps] {
        let n = squares.len() as f64;
        // Four standard deviations of the mean square of so many normal numbers.
        assert!((squares.iter().sum::<f64>() / n - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
    }
}

#[test]
fn temperatures_tell_the_strain() {
    let mut scenario = Preset::LeoAluminium.scenario(iiwa()).unwrap();
    scenario.contacts = 400;
    let simulated = sim::simulate(&scenario, 9).unwrap();
    let (log, thermal) = (&simulated.logs[0], scenario.thermal.unwrap());
    let count = segments(&scenario.robot).len();
    assert_eq!(log.temperature.len(), count * log.len());
    for k in 0..count {
        let rows = log.temperature.chunks(count);
        let celsius = rows.map(|row| row[k]).sum::<f64>() / log.len() as f64;
        let strain = thermal.expansion * (celsius - thermal.reference);
        assert!((strain - simulated.truth.strain(k)).abs() < 4.0 * thermal.expansion * thermal.sensor_sigma / 20.0);
        assert!(simulated.truth.strain(k).abs() < 0.004 && simulated.truth.strain(k) != 0.0);
    }
}

/// Rows after a contact count as contacts until the filtered force is below the threshold.
#[test]
fn a_lagging_force_sensor_flags_rows_that_are_free_again() {
    const LAG: f64 = 0.1;
    let mut scenario = paper(3000);
    scenario.touches[0].exploration.lift = 10e-3;
    let sharp = only_log(&scenario, 4);
    scenario.recorder.force_lag = LAG;
    let lagging = only_log(&scenario, 4);
    let share = 1.0 - (-1.0 / (300.0 * LAG)).exp();
    let mut filtered = [0.0; 6];
    let mut free_contacts = 0;
    for row in 0..sharp.len().min(lagging.len()) {
        filtered = std::array::from_fn(|k| filtered[k] + share * (sharp.wrench[row][k] - filtered[k]));
        let apart = (0..6).map(|k| (filtered[k] - lagging.wrench[row][k]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-3, "row {row}: {apart}");
        assert_eq!(sharp.truth[row], lagging.truth[row]);
        if lagging.contact[row] && !lagging.truth[row].touching {
            free_contacts += 1;
            assert!(row > 0 && lagging.contact[row - 1], "row {row}");
        }
        assert!(!sharp.contact[row] || sharp.truth[row].touching);
    }
    println!("{free_contacts} of {} contacts are free", lagging.contacts().count());
    assert!(free_contacts > 0);
}

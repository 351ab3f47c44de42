//! `correction.json`: the library's corrections against kinematics, and against the files from
//! which the readers in Python and C++ are tested.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::Value;
use touchcal::estimate::Status;
use touchcal::io::correction_file;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{
    EncoderTerm, JointCorrection, JointKind, JointLoad, KinematicParameter, Kinematics, Robot, calibrated,
};
use touchcal::se3::{Pose, Wrench};

use crate::support::{data, uniform};

/// Configurations of each arm.
const ROWS: usize = 40;
/// An arm whose second joint slides, with axes in all directions and masses beside the axes.
const SLIDING: &str = "<robot name='sliding'><link name='b'/>\
  <link name='l1'><inertial><origin xyz='0.1 0.05 0.2'/><mass value='4'/></inertial></link>\
  <link name='l2'><inertial><origin xyz='-0.1 0.1 0.1'/><mass value='2'/></inertial></link>\
  <link name='l3'><inertial><origin xyz='0.05 0 0.1'/><mass value='1'/></inertial></link>\
  <link name='t'><inertial><origin xyz='0 0 0.03'/><mass value='0.7'/></inertial></link>\
  <joint name='j1' type='revolute'><origin xyz='0.1 -0.2 0.3' rpy='0.3 -0.2 0.5'/><parent link='b'/><child link='l1'/><axis xyz='1 2 -1'/></joint>\
  <joint name='j2' type='prismatic'><origin xyz='0.2 0.1 0.4' rpy='1.1 0 0.7'/><parent link='l1'/><child link='l2'/><axis xyz='0 1 0'/></joint>\
  <joint name='j3' type='continuous'><origin xyz='0.4 0.2 0' rpy='0.1 0.02 0.03'/><parent link='l2'/><child link='l3'/></joint>\
  <joint name='end' type='fixed'><origin xyz='0.1 0.2 0.3' rpy='1 2 3'/><parent link='l3'/><child link='t'/></joint></robot>";

/// An arm with all errors, drawn from a seed.
struct Case {
    name: &'static str,
    nominal: Robot,
    parameters: Vec<KinematicParameter>,
    theta: Vec<f64>,
    errors: Vec<(usize, EncoderTerm, f64)>,
}

impl Case {
    /// With joints of up to `backlash` (rad, m).
    fn new(name: &'static str, nominal: Robot, (seed, backlash): (u64, f64)) -> Case {
        let dof = nominal.dof();
        let offsets = (0..dof).map(|i| (KinematicParameter::JointOffset(i), 0.01));
        let compliances = (0..dof).map(|i| (KinematicParameter::JointCompliance(i), 2e-4));
        let backlashes = (0..dof).map(|i| (KinematicParameter::JointBacklash(i), backlash)).filter(|_| backlash > 0.0);
        let origins = (0..dof).flat_map(|i| (0..6).map(move |k| (KinematicParameter::JointOrigin(i, k), 2e-3)));
        let sizes: Vec<_> = offsets.chain(compliances).chain(origins).chain(backlashes).collect();
        let turns = |i: usize| nominal.moving().nth(i).is_some_and(|joint| joint.kind != JointKind::Prismatic);
        let is_of = |i: usize, term: EncoderTerm| term == EncoderTerm::GearRatio || turns(i);
        let terms = (0..dof).flat_map(|i| EncoderTerm::ALL.map(|term| (i, term)));
        let terms: Vec<_> = terms.filter(|(i, term)| is_of(*i, *term)).collect();
        let draws = uniform(sizes.len() + terms.len(), seed);
        let (of_arm, of_encoders) = draws.split_at(sizes.len());
        Case {
            name,
            parameters: sizes.iter().map(|(parameter, _)| *parameter).collect(),
            theta: sizes.iter().zip(of_arm).map(|((_, size), draw)| size * draw).collect(),
            errors: terms.iter().zip(of_encoders).map(|((i, term), draw)| (*i, *term, 0.02 * draw)).collect(),
            nominal,
        }
    }

    fn calibrated(&self) -> Robot {
        calibrated(&self.nominal, &self.parameters, &self.theta)
    }

    fn correction(&self) -> JointCorrection {
        JointCorrection::new(&self.calibrated(), self.errors.iter().copied())
    }

    /// Measured positions and loads, or joint torques where these are measured; every other is
    /// none.
    fn rows(&self) -> Vec<(Vec<f64>, Vec<f64>)> {
        let dof = self.nominal.dof();
        let numbers = if self.nominal.has_measured_torques() { dof } else { 6 };
        let row = |draws: &[f64], k: usize| {
            let size = |j: usize| match j {
                _ if k.is_multiple_of(2) => 0.0,
                0..3 => 50.0,
                _ => 5.0,
            };
            let carried = (0..numbers).map(|j| size(j) * draws[dof + j]);
            (draws[..dof].iter().map(|q| 2.9 * q).collect(), carried.collect())
        };
        uniform(ROWS * (dof + numbers), 7).chunks(dof + numbers).enumerate().map(|(k, draws)| row(draws, k)).collect()
    }

    /// True positions in a row.
    fn true_positions(&self, (measured, carried): &(Vec<f64>, Vec<f64>)) -> Vec<f64> {
        match self.nominal.has_measured_torques() {
            true => self.correction().true_positions(measured, JointLoad::Torques(carried)),
            false => self.correction().true_positions(measured, &load(carried)),
        }
    }

    fn text(&self, status: Status) -> String {
        correction_file::text([&self.calibrated(), &self.nominal], &self.errors, status).unwrap().expect("a correction")
    }
}

/// The wrench of a row.
fn load(carried: &[f64]) -> Wrench {
    std::array::from_fn(|k| carried[k])
}

fn cases() -> Vec<Case> {
    let ur10 = urdf::read_file(&data().join("ur10/ur10.urdf"), Ends::default()).unwrap().robot;
    vec![
        Case::new("ur10", ur10, (1, 0.0)),
        Case::new("iiwa14", urdf::read_builtin("iiwa14", Ends::default()).unwrap().robot, (2, 0.0)),
        Case::new(
            "torques",
            urdf::read(SLIDING, "arm.urdf", Ends::default()).unwrap().with_measured_torques(),
            (4, 1e-3),
        ),
        Case::new("sliding", urdf::read(SLIDING, "arm.urdf", Ends::default()).unwrap(), (3, 0.0)),
        Case::new("backlash", urdf::read(SLIDING, "arm.urdf", Ends::default()).unwrap(), (5, 1e-3)),
    ]
}

fn most_apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// A stiff arm with the calibrated origins is, at the true positions, where the erroneous arm is at
/// the measured ones; and back.
#[test]
fn corrected_positions_are_those_of_the_calibrated_description() {
    for case in cases() {
        let correction = case.correction();
        let mut erroneous = Kinematics::new(&case.nominal, &case.parameters, Pose::identity());
        erroneous.set(&case.theta);
        let bent = case.calibrated();
        let compliances =
            bent.moving().enumerate().map(|(i, j)| (KinematicParameter::JointCompliance(i), -j.compliance));
        let backlashes = bent.moving().enumerate().map(|(i, j)| (KinematicParameter::JointBacklash(i), -j.backlash));
        let (stiffening, values): (Vec<_>, Vec<f64>) = compliances.chain(backlashes).unzip();
        let stiff = calibrated(&bent, &stiffening, &values);
        assert!(!stiff.is_compliant());
        let stiff = Kinematics::new(&stiff, &[], Pose::identity());
        let mut corrected = 0.0f64;
        for row in case.rows() {
            let (measured, carried) = &row;
            let mut less_errors = measured.clone();
            case.errors.iter().for_each(|(i, term, size)| less_errors[*i] -= size * term.error(measured[*i]));
            let is_measured = case.nominal.has_measured_torques();
            let load = if is_measured { [0.0; 6] } else { load(carried) };
            let on_joints = if is_measured { JointLoad::Torques(carried) } else { JointLoad::OnTip(&load) };
            let expected = erroneous.pose_under(&less_errors, on_joints);
            let positions = case.true_positions(&row);
            corrected = corrected.max(most_apart(&positions, measured));
            let found = stiff.pose(&positions);
            let apart = (found.translation.vector - expected.translation.vector).norm();
            let turned = (found.rotation.inverse() * expected.rotation).imag().norm();
            assert!(apart < 1e-12 && turned < 1e-12, "{}: {apart:e}", case.name);
            let again = correction.commanded_positions(&positions, &load);
            let has_backlash = bent.moving().any(|joint| joint.backlash != 0.0);
            assert_eq!(again.is_some(), !is_measured && !has_backlash, "{}", case.name);
            let apart = again.map_or(0.0, |again| most_apart(&again, measured));
            assert!(apart < 1e-13, "{}: {apart:e}", case.name);
        }
        assert!(corrected > 1e-2, "{}: nothing was corrected", case.name);
    }
}

/// The numbers of two files are the same to rounding, and all else is the same.
fn assert_same(a: &Value, b: &Value) {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            assert!((a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-13, "{a} {b}");
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).for_each(|(a, b)| assert_same(a, b))
        }
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            a.values().zip(b.values()).for_each(|(a, b)| assert_same(a, b));
        }
        _ => assert_eq!(a, b),
    }
}

/// Writes them anew with `TOUCHCAL_UPDATE=1`.
#[test]
fn files_for_the_readers_in_python_and_cpp_are_those_of_the_library() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/formats/correction");
    for case in cases() {
        let [json, csv] = ["json", "csv"].map(|ending| folder.join(format!("{}.{ending}", case.name)));
        let rows = case.rows();
        if std::env::var_os("TOUCHCAL_UPDATE").is_some() {
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(&json, case.text(Status::Usable)).unwrap();
            let mut text = String::new();
            for row in &rows {
                let numbers = [row.0.as_slice(), &row.1, &case.true_positions(row)].concat();
                let row: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
                writeln!(text, "{}", row.join(",")).unwrap();
            }
            std::fs::write(&csv, text).unwrap();
        }
        let text = std::fs::read_to_string(&json).unwrap();
        let content = [text, case.text(Status::Usable)].map(|text| {
            let mut content: Value = serde_json::from_str(&text).unwrap();
            content["version"] = Value::Null;
            content
        });
        assert_same(&content[0], &content[1]);
        let table = std::fs::read_to_string(&csv).unwrap();
        assert_eq!(table.lines().count(), ROWS);
        for (row, line) in rows.iter().zip(table.lines()) {
            let expected: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            let found = [row.0.as_slice(), &row.1, &case.true_positions(row)].concat();
            assert!(most_apart(&found, &expected) < 1e-13, "{}", case.name);
        }
    }
}

#[test]
fn the_file_says_what_it_is_of_and_whether_it_may_be_used() {
    let case = &cases()[0];
    let content: Value = serde_json::from_str(&case.text(Status::NotUsable)).unwrap();
    assert_eq!(content["torque"], "gravity_and_load");
    let of_torques: Value = serde_json::from_str(&cases()[2].text(Status::Usable)).unwrap();
    assert_eq!((&of_torques["torque"], &of_torques["joints"][0]["mass_kg"]), (&"measured".into(), &0.0.into()));
    assert_eq!((&content["schema"], &content["status"]), (&Value::from(1), &Value::from("not_usable")));
    assert!(content["warning"].as_str().unwrap().starts_with("NOT USABLE"));
    assert!(!case.text(Status::Doubtful).contains("NOT USABLE"));
    // Offsets are those that the calibrated description contains: nearly those that were put in.
    let offset = content["joints"][2]["offset_in_urdf"].as_f64().unwrap();
    assert!((offset - case.theta[2]).abs() < 4e-3 && offset != 0.0, "{offset} {}", case.theta[2]);
    let joint = &content["joints"][2];
    let numbers = [0, 1].map(|k| &joint["harmonics"][k]).map(|harmonic| [&harmonic["sin"], &harmonic["cos"]]).concat();
    let found: Vec<f64> = numbers.into_iter().chain([&joint["gear_ratio"]]).map(|x| x.as_f64().unwrap()).collect();
    let errors: Vec<f64> = case.errors.iter().filter(|(i, ..)| *i == 2).map(|(.., amplitude)| *amplitude).collect();
    assert_eq!(found, errors);
    // Nothing is to be said of an arm with offsets and origins alone.
    let stiff = calibrated(&case.nominal, &[KinematicParameter::JointOffset(1)], &[0.01]);
    assert_eq!(correction_file::text([&stiff, &case.nominal], &[], Status::Usable).unwrap(), None);
    let no_error = [(0, EncoderTerm::Sine, 0.0)];
    assert_eq!(correction_file::text([&stiff, &case.nominal], &no_error, Status::Usable).unwrap(), None);
}

/// An encoder that turns back has no inverse.
#[test]
fn errors_as_large_as_positions_have_no_inverse() {
    let case = &cases()[0];
    let correction = JointCorrection::new(&case.nominal, [(0, EncoderTerm::Sine, 1.5)]);
    assert_eq!(correction.commanded_positions(&[0.0; 6], &[0.0; 6]), None);
}

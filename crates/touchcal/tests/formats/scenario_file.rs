//! Scenario files: every key read and written back, presets, several fixtures and postures, nothing
//! that panics.

use std::path::Path;

use proptest::prelude::*;
use touchcal::estimate::{DEFAULT_DISTANCE_SIGMA, PlacePrior, Problem};
use touchcal::experiment;
use touchcal::geometry::{EdgeRadii, Parts};
use touchcal::io::scenario_file::ScenarioFile;
use touchcal::io::{problem_file, scenario_file};
use touchcal::manifold::Residual;
use touchcal::parameter::{Block, ParameterId};
use touchcal::se3::{self, Pose};
use touchcal::sim::{self, Distribution, Preset, Scenario};

const FULL: &str = r#"schema = 1
preset = "leo_cfrp"
contacts = 40
friction = 0.1
contact_mm = 0.02
[robot]
builtin = "iiwa14"
gravity = [0, 0, -1.62]
[errors]
distribution = "normal"
strain = 0.01
segment_strain = 0.002
joint_offset_deg = 0.5
origin_mm = 0.1
origin_deg = 0.05
origin_zero_deg = 0.2
joint_compliance_rad_per_nm = 1e-5
joint_harmonic_deg = 0.03
joint_harmonic_2_deg = 0.02
joint_gear_ratio = 2e-4
joint_backlash_deg = 0.03
[tool]
kind = "peg"
outline = "mine.csv"
length_mm = 40
edge_radius_mm = 0.02
tip_from_tool = { xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }
sigma_mm = 0.2
sigma_deg = 0.1
[exploration]
press_mm = 5
[[fixture]]
name = "left"
kind = "hole"
base_from_fixture = { xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }
outline_offset_mm = 0.5
depth_mm = 30
sigma_mm = 0.3
clearance_sigma_mm = 0.01
depth_sigma_mm = 0.02
unequal_clearance_sigma_mm = 0.03
edge_wear_mm = 0.1
edge_radius_sigma_mm = 0.02
edge_radius_mm = 0.05
postures_deg = [[0, 42, 15, -89, -13, 50, -1], [10, 45, -10, -85, 10, 48, 0]]
[[fixture]]
name = "table top"
kind = "plane"
base_from_fixture = { xyz_mm = [500, -100, 100] }
postures_deg = [[0, 42, 15, -89, -13, 50, -1]]
exploration = { radius_mm = 20, tilt_deg = 3, press_mm = 4, lift_mm = 6, swing_deg = 8, pace = 0.5, random_phases = false }
exact = true
[[distance]]
between = ["left", "table top"]
sigma_mm = 0.05
[[distance]]
between = ["table top", "left"]
exact = true
[stiffness]
n_per_m = 2500
nm_per_rad = 40
[recorder]
rate_hz = 100
encoder_deg = 0.001
force_lag_s = 0.01
encoder_step_deg = 0.0005
encoder_trend_deg = 0.004
warm_up_k = 7
encoder_walk_deg = 0.003
force_sigma_n = 0.2
torque_sigma_nm = 0.01
force_bias_n = 0.3
torque_bias_nm = 0.02
wrench_scale = 0.03
force_threshold_n = 4
missed = 0.05
spurious = 0.1
[thermal]
expansion_per_k = 1e-5
reference_c = 25
sensor_sigma_k = 0.5
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mine.csv"), "-10,-10\n10,-10\n10,12\n-10,10\n").unwrap();
    folder
}

#[test]
fn every_key_is_read() {
    let folder = folder();
    let scenario = scenario_file::read(FULL, "s.toml", folder.path()).unwrap().scenario;
    let near = |value: f64, wanted: f64| assert!((value - wanted).abs() <= 1e-12 * wanted.abs(), "{value} {wanted}");
    assert_eq!((scenario.contacts, scenario.errors.distribution), (40, Distribution::Normal));
    near(scenario.errors.origin_zero, 0.2f64.to_radians());
    near(scenario.errors.joint_compliance, 1e-5);
    near(scenario.errors.joint_harmonic, 0.03f64.to_radians());
    near(scenario.errors.joint_harmonic_2, 0.02f64.to_radians());
    near(scenario.errors.joint_gear_ratio, 2e-4);
    near(scenario.errors.joint_backlash, 0.03_f64.to_radians());
    near(scenario.tool_error.angle, 0.1f64.to_radians());
    near(scenario.robot.gravity().z, -1.62);
    near(scenario.stiffness.rotation, 40.0);
    near(scenario.recorder.torque_bias, 0.02);
    near(scenario.recorder.force_lag, 0.01);
    near(scenario.recorder.wrench_scale, 0.03);
    near(scenario.recorder.encoder_step, 0.0005f64.to_radians());
    near(scenario.recorder.encoder_trend, 0.004f64.to_radians());
    near(scenario.recorder.encoder_walk, 0.003f64.to_radians());
    near(scenario.recorder.warm_up, 7.0);
    near(scenario.thermal.unwrap().reference, 25.0);
    let [left, table] = &scenario.touches[..] else { panic!("two fixtures") };
    near(left.place_error.length, 0.3e-3);
    near(left.clearance_sigma, 0.01e-3);
    near(left.depth_sigma, 0.02e-3);
    near(left.unequal_clearance_sigma, 0.03e-3);
    near(left.edge_wear, 0.1e-3);
    near(left.edge_radius_sigma, 0.02e-3);
    let Parts::PegInHole(parts) = &left.parts else { panic!("a hole") };
    assert_eq!(parts.edge_radii(), EdgeRadii { peg: 0.02e-3, hole: 0.05e-3 });
    // The file's own exploration for all, the preset's where it says nothing.
    near(left.exploration.press, 5e-3);
    near(left.exploration.tilt, 5f64.to_radians());
    near(table.exploration.press, 4e-3);
    near(table.exploration.lift, 6e-3);
    near(table.exploration.pace, 0.5);
    assert!(left.exploration.random_phases && !table.exploration.random_phases);
    assert_eq!((left.postures.len(), table.postures.len()), (2, 1));
    near(left.postures[1][5], 48f64.to_radians());
    let [measured, exact] = &scenario.distances[..] else { panic!("two distances") };
    near(measured.sigma, 0.05e-3);
    assert_eq!((measured.between, exact.between, exact.sigma), ((0, 1), (1, 0), 0.0));
    let Parts::OnPlane { points, radius } = &table.parts else { panic!("a plane") };
    assert_eq!((points.len(), points[0].z, *radius), (4, 0.02e-3, 0.02e-3));
}

#[track_caller]
fn same_prior(read: PlacePrior, made: PlacePrior) {
    let numbers = |prior: PlacePrior| match prior {
        PlacePrior::Gaussian { sigma, sigma_angle } => Some((sigma, sigma_angle)),
        PlacePrior::Fixed | PlacePrior::Flat => None,
    };
    assert_eq!(std::mem::discriminant(&read), std::mem::discriminant(&made));
    if let (Some(read), Some(made)) = (numbers(read), numbers(made)) {
        assert!((read.0 - made.0).abs() <= 1e-9 * made.0 && (read.1 - made.1).abs() <= 1e-9 * made.1);
    }
}

/// The problem read from files is the one made in memory, to the digits of the file.
#[track_caller]
fn same(read: &Problem, made: &Problem) {
    let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} {b}");
    let names = |problem: &Problem| problem.parameters.iter().map(|p| p.name.clone()).collect::<Vec<_>>();
    assert_eq!(names(read), names(made));
    assert_eq!((read.method, read.loss, read.joint_drift), (made.method, made.loss, made.joint_drift));
    near(read.noise.encoder, made.noise.encoder);
    near(read.noise.contact, made.noise.contact);
    let bends = read.parameters.iter().any(|parameter| parameter.id.block() == Block::JointCompliance);
    assert_eq!(bends && !read.contacts.has_loads(), made.contacts.has_joint_torques());
    if bends && read.contacts.has_loads() {
        near(read.wrench.force, made.wrench.force);
        near(read.wrench.torque, made.wrench.torque);
        near(read.wrench.scale, made.wrench.scale);
        near(read.wrench.force_noise, made.wrench.force_noise);
        near(read.wrench.torque_noise, made.wrench.torque_noise);
    }
    same_prior(read.tool.prior, made.tool.prior);
    assert_eq!((read.fixtures.len(), read.distances.len()), (made.fixtures.len(), made.distances.len()));
    for (a, b) in read.fixtures.iter().zip(&made.fixtures) {
        assert_eq!((&a.name, &a.placement), (&b.name, &b.placement));
        same_prior(a.prior, b.prior);
        near(a.tolerance.clearance, b.tolerance.clearance);
        near(a.tolerance.depth, b.tolerance.depth);
        near(a.tolerance.edge_radius, b.tolerance.edge_radius);
        let apart = a.base_from_fixture.zip(b.base_from_fixture).map(|(a, b)| se3::log(&(a.inverse() * b)).norm());
        assert!(apart < Some(1e-9) && a.base_from_fixture.is_some() == b.base_from_fixture.is_some());
        // The same shapes: the same rows at any pose.
        let pose = Pose::translation(1e-3, -2e-3, 3e-3);
        let rows = |fixture: &touchcal::estimate::Fixture| {
            let mut rows = Residual::new();
            fixture.manifold.residual(&pose, 0.0, &mut rows);
            rows.values().to_vec()
        };
        for (a, b) in rows(a).into_iter().zip(rows(b)) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
    for (a, b) in read.distances.iter().zip(&made.distances) {
        assert_eq!(a.between, b.between);
        near(a.distance, b.distance);
        near(a.sigma, b.sigma);
    }
    assert_eq!(read.contacts.len(), made.contacts.len());
    assert_eq!(read.contacts.rows_read(), made.contacts.rows_read());
    assert_eq!(read.contacts.rows_left_out(), made.contacts.rows_left_out());
    assert_eq!(read.contacts.has_loads(), made.contacts.has_loads());
    assert!((0..read.contacts.len()).all(|i| read.contacts.joint_torques(i) == made.contacts.joint_torques(i)));
    for i in 0..read.contacts.len() {
        let (a, b) = (read.contacts.load(i), made.contacts.load(i));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6), "contact {i}: {a:?} {b:?}");
    }
}

/// What is written reads as the same scenario, whose text is the same again; the logs, simulated
/// from it, make a problem that can be read.
#[test]
fn what_is_written_is_read_again() {
    let folder = folder();
    let mut files = vec![scenario_file::read(FULL, "s.toml", folder.path()).unwrap()];
    files.extend(Preset::ALL.map(|preset| scenario_file::preset(preset.name()).unwrap()));
    let mut torques = scenario_file::preset("mukca").unwrap();
    (torques.scenario.recorder.joint_torque_sigma, torques.scenario.errors.joint_compliance) = (0.1, 1e-5);
    files.push(torques);
    for mut file in files {
        let out = tempfile::tempdir().unwrap();
        let write = |files: &[scenario_file::TextFile]| {
            files.iter().for_each(|file| std::fs::write(out.path().join(&file.name), &file.text).unwrap());
        };
        file.scenario.contacts = file.scenario.contacts.min(40);
        let texts = scenario_file::scenario_text(&file);
        write(&texts);
        let again = scenario_file::read_file(&out.path().join("scenario.toml")).unwrap();
        assert_eq!(texts, scenario_file::scenario_text(&again));

        let simulated = sim::simulate(&file.scenario, 1).unwrap();
        write(&scenario_file::log_texts(&file.scenario, &simulated));
        write(&scenario_file::problem_text(&file, &simulated.truth));
        let problem = problem_file::read_file(&out.path().join(scenario_file::PROBLEM)).unwrap().problem;
        same(&problem, &experiment::problem(&file.scenario, &simulated));
        // Nothing is left to be assumed: what is known exactly is declared so.
        let notes = problem.contacts.notes();
        assert!(!notes.iter().any(|note| note.starts_with("assumed")), "{notes:?}");
        // Detection by force finds the rows that the recorder took for contacts.
        let contacts: usize = simulated.logs.iter().map(|log| log.contacts().count()).sum();
        assert_eq!(problem.contacts.len(), contacts);
        let (log, first) = (&simulated.logs[0], problem.contacts.q(0));
        let row = log.contacts().next().unwrap();
        assert!(log.q(row).iter().zip(first).all(|(a, b)| (a - b).abs() < 1e-8));
    }
}

/// A peg, a hole and a plane, with more lines in each of their tables and in that of the distance.
fn described(tool: &str, hole: &str, plane: &str, distance: &str) -> Result<Scenario, String> {
    let text = format!(
        "[tool]\nkind = 'peg'\nbuiltin = 'extrusion25'\nlength_mm = 40\n{tool}\n\
         [[fixture]]\nname = 'block/hole'\nkind = 'hole'\noutline_offset_mm = 0.5\ndepth_mm = 30\n\
         base_from_fixture = {{ xyz_mm = [600, 100, 150] }}\npostures_deg = [[0, 40, 0, -90, 0, 50, 0]]\n{hole}\n\
         [[fixture]]\nname = 'block/rim'\nkind = 'plane'\n\
         base_from_fixture = {{ xyz_mm = [600, 150, 150] }}\npostures_deg = [[0, 40, 0, -90, 0, 50, 0]]\n{plane}\n\
         [[distance]]\nbetween = ['block/hole', 'block/rim']\n{distance}\n"
    );
    let read = scenario_file::read(&text, "s.toml", Path::new("")).map_err(|error| error.to_string());
    read.map(|file| file.scenario)
}

#[test]
fn what_is_exact_has_no_error() {
    let uncertain = "sigma_mm = 1\nsigma_deg = 1\nclearance_sigma_mm = 0.1\ndepth_sigma_mm = 0.1";
    let scenario = described("sigma_mm = 0.1", uncertain, "", "").unwrap();
    assert_eq!(scenario.distances[0].sigma, DEFAULT_DISTANCE_SIGMA);
    let truth = sim::draw_truth(&scenario, 1);
    assert!(truth.value(ParameterId::tool(0)) != 0.0 && truth.value(ParameterId::Fixture(0, 5)) != 0.0);
    assert!(truth.clearance[0] != 0.0 && truth.depth[0] != 0.0 && truth.distance_error[0] != 0.0);

    let scenario = described("exact = ['place', 'outline']", "exact = true", "exact = true", "exact = true").unwrap();
    let truth = sim::draw_truth(&scenario, 1);
    assert_eq!((truth.errors.len(), truth.clearance[0], truth.depth[0], truth.distance_error[0]), (0, 0.0, 0.0, 0.0));

    // A part alone; a standard deviation of 0 says the same.
    let place = "exact = ['place']\nsigma_mm = 0\nclearance_sigma_mm = 0.1\ndepth_sigma_mm = 0.1";
    let truth = sim::draw_truth(&described("", place, "", "").unwrap(), 1);
    assert!(truth.errors.is_empty() && truth.clearance[0] != 0.0 && truth.depth[0] != 0.0);
    let shape = "exact = ['clearance', 'depth']\nfree = true\nsigma_mm = 1";
    let scenario = described("", shape, "", "exact = ['length']\nsigma_mm = 0").unwrap();
    assert!(scenario.touches[0].free && scenario.touches[0].place_error.length > 0.0);
    assert_eq!((scenario.touches[0].depth_sigma, scenario.distances[0].sigma), (0.0, 0.0));
}

#[test]
fn what_contradicts_exact_is_refused() {
    let refused = |[tool, hole, plane, distance]: [&str; 4], message: &str| {
        let error = described(tool, hole, plane, distance).unwrap_err();
        assert!(error.contains(message) && error.lines().count() == 1, "expected `{message}` in: {error}");
    };
    let exact = "a list of what is exact (`place`, `outline`, `clearance`, `depth` or `edge_radius`), found \"depht\"; did you mean";
    refused(["", "exact = ['depht']", "", ""], exact);
    refused(["", "", "exact = ['depth']", ""], "fixture `block/rim`, exact: expected true, false, or a list of what");
    refused(["exact = ['depth']", "", "", ""], "s.toml:5:9, tool, exact: expected true, false, or a list of what");
    refused(["", "", "", "exact = ['lenght']"], "distance, exact: expected true, false, or a list of what is exact");
    refused(["exact = true\nsigma_mm = 1", "", "", ""], "s.toml:6:12, tool: expected exact or standard deviations");
    let both = "fixture `block/hole`: expected exact or standard deviations above 0, found both";
    refused(["", "exact = ['place']\nsigma_deg = 1", "", ""], both);
    let both = "fixture `block/hole`, depth_sigma_mm: expected depth_sigma_mm or `exact` with \"depth\", found both";
    refused(["", "exact = true\ndepth_sigma_mm = 1", "", ""], both);
    refused(["", "exact = true\nfree = true", "", ""], "fixture `block/hole`: expected free or exact, found both");
    refused(["", "", "", "exact = true\nsigma_mm = 1"], "distance, sigma_mm: expected sigma_mm or exact, found both");
    let length = "distance, mm: expected `sigma_mm` or `exact` alone, since the length is that of the simulated";
    refused(["", "", "", "mm = 50"], length);
    let block = "fixture `block/rim`, exact: expected `block/hole`, with which it is displaced, to be exact too";
    refused(["", "sigma_mm = 1", "exact = true", ""], block);
    let of_preset = |between: &str| {
        let text = format!("preset = 'mukca'\n[[distance]]\nbetween = {between}\n");
        scenario_file::read(&text, "s.toml", Path::new("")).map(|file| file.scenario.distances[0].between)
    };
    assert_eq!(of_preset("['front/0', 'right/0']").unwrap(), (0, 4));
    let unknown = of_preset("['front/0', 'rigth/0']").unwrap_err().to_string();
    assert!(
        unknown.contains("s.toml:3:23, distance, between: expected the name of a fixture (`front/0`, "),
        "{unknown}"
    );
    assert!(unknown.ends_with("did you mean `right/0`?"), "{unknown}");
    let twice = of_preset("['left/0', 'left/0']").unwrap_err().to_string();
    assert!(twice.contains("expected two fixtures, found \"left/0\" twice"), "{twice}");
}

#[test]
fn a_number_is_replaced_by_its_name() {
    let folder = folder();
    let file = scenario_file::read(FULL, "s.toml", folder.path()).unwrap();
    let varied = |name: &str, value: f64| {
        let out = tempfile::tempdir().unwrap();
        for file in scenario_file::varied_text(&file, name, value)? {
            std::fs::write(out.path().join(&file.name), &file.text).unwrap();
        }
        scenario_file::read_file(&out.path().join(scenario_file::SCENARIO)).map(|file| file.scenario)
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
    near(varied("spurious", 0.25).unwrap().recorder.spurious, 0.25);
    near(varied("tool.sigma_mm", 7.0).unwrap().tool_error.length, 7e-3);
    near(varied("expansion_per_k", 1e-5).unwrap().thermal.unwrap().expansion, 1e-5);
    assert_eq!(varied("contacts", 77.0).unwrap().contacts, 77);
    // All fixtures have it, and nothing else changes.
    let swung = varied("exploration.swing_deg", 15.0).unwrap();
    assert!(swung.touches.iter().all(|touch| (touch.exploration.swing.to_degrees() - 15.0).abs() < 1e-12));
    let back = ScenarioFile { scenario: swung, ..file.clone() };
    let mut expected = file.clone();
    expected.scenario.touches.iter_mut().for_each(|touch| touch.exploration.swing = 15f64.to_radians());
    assert_eq!(scenario_file::scenario_text(&back), scenario_file::scenario_text(&expected));

    for (name, value, part) in [
        ("spuroius", 0.1, "found \"spuroius\"; did you mean `spurious`?"),
        ("recordr.spurious", 0.1, "did you mean `recorder.spurious`?"),
        ("sigma_mm", 0.1, "expected `distance.sigma_mm`, `fixture.sigma_mm` or `tool.sigma_mm`, found \"sigma_mm\""),
        ("distribution", 0.1, "found \"distribution\""),
        ("schema", 1.0, "found \"schema\""),
        ("spurious", 1.5, "recorder, spurious: expected a share from 0 to below 1, found 1.5"),
        ("contacts", 1.5, "contacts: expected a whole number from 1 to 1000000, found 1.5"),
    ] {
        let error = varied(name, value).unwrap_err().to_string();
        assert!(error.contains(part) && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn postures_share_the_contacts() {
    let folder = folder();
    let scenario = scenario_file::read(FULL, "s.toml", folder.path()).unwrap().scenario;
    let log = &sim::simulate(&scenario, 2).unwrap().logs[0];
    let elbow: Vec<f64> = log.contacts().map(|row| log.q(row)[2]).collect();
    assert_eq!(elbow.len(), 40);
    // The third joint is at 15° in one posture and at −10° in the other.
    let apart = elbow[..20].iter().sum::<f64>() / 20.0 - elbow[20..].iter().sum::<f64>() / 20.0;
    assert!(apart.to_degrees() > 10.0, "{}°", apart.to_degrees());
}

proptest! {
    /// Whatever becomes of a line, there is a scenario or one error.
    #[test]
    fn damaged_files_never_panic(line in 0usize..64, at in 0usize..80, by in "[ -~]{0,6}") {
        let mut lines: Vec<String> = FULL.lines().map(str::to_owned).collect();
        let count = lines.len();
        let line = &mut lines[line % count];
        let at = at % (line.len() + 1);
        line.replace_range(at.., &by);
        let folder = folder();
        if let Err(error) = scenario_file::read(&lines.join("\n"), "s.toml", folder.path()) {
            prop_assert!(!error.to_string().contains('\n'), "{error}");
        }
    }
}

//! What several tests need: where the data lie, and problems made from them.
#![allow(dead_code, reason = "each test crate uses a part")]

pub mod parts;
pub mod small_arm;

use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use flate2::{Compression, write::GzEncoder};
use touchcal::estimate::{Estimate, Loss, Method, Noise, Problem, calibrate};
use touchcal::experiment::{Search, Trial};
use touchcal::geometry::{Parts, PrismPair};
use touchcal::io::problem_file;
use touchcal::io::urdf::{self, Ends};
use touchcal::sim::{Exploration, Preset};

/// The folder `data` of the repository.
pub fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data")
}

/// What a trial's parameters truly are.
pub struct Truth {
    /// Common strain.
    pub strain: f64,
    /// Encoder biases (rad).
    pub offset: Vec<f64>,
}

/// A simulated peg-in-hole trial of `mujoco_iiwa14`, such as `extrusion/paper/trial_00`, with all
/// that is declared exact, and its truth.
pub fn mujoco_trial(name: &str) -> (Problem, Truth) {
    let text = std::fs::read_to_string(data().join("mujoco_iiwa14").join(name).join("truth.json")).expect("truth.json");
    let truth: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let offset = truth["b_rad"].as_array().expect("b_rad").iter().map(|b| b.as_f64().expect("a number")).collect();
    let truth = Truth { strain: truth["r"].as_f64().expect("r"), offset };
    let outline = if name.starts_with("square") {
        let outline = std::env::temp_dir().join(format!("touchcal_square_{}.csv", std::process::id()));
        std::fs::write(&outline, "-12.5,-12.5\n12.5,-12.5\n12.5,12.5\n-12.5,12.5\n").expect("a temporary file");
        format!("outline = {:?}", outline.display().to_string())
    } else {
        "builtin = \"extrusion25\"".to_owned()
    };
    let rest = "[noise]\nencoder_deg = 0.002\ncontact_mm = 0.02\nencoder_trend_deg = 0\n\
                [estimate]\nparameters = [\"strain\", \"joint_offset\"]\nloss = \"geman_mcclure\"\n";
    (mujoco_problem(name, &outline, "exact = true", rest), truth)
}

/// The problem of a recorded log: a peg with an `outline`, a line of tool and hole about what is
/// `exact`, and the `rest` of the file, each as in a problem file.
pub fn mujoco_problem(name: &str, outline: &str, exact: &str, rest: &str) -> Problem {
    let toml = format!(
        r#"
[robot]
builtin = "iiwa14"
[tool]
kind = "peg"
tip_from_tool = {{ xyz_mm = [0, 0, 150], quat_wxyz = [0, 0, 1, 0] }}
{exact}
{outline}
length_mm = 40
[[fixture]]
name = "hole"
kind = "hole"
base_from_fixture = {{ xyz_mm = [600, 100, 150], rpy_deg = [0, 0, 20] }}
outline_offset_mm = 0.5
depth_mm = 30
{exact}
[[contacts]]
file = "contact.csv.gz"
fixture = "hole"
{rest}"#
    );
    let folder = data().join("mujoco_iiwa14").join(name);
    problem_file::read(&toml, "problem.toml", &folder).expect("a valid problem").problem
}

/// The trials of a folder such as `extrusion/paper`, sorted.
pub fn mujoco_trials(profile: &str) -> Vec<String> {
    let folder = data().join("mujoco_iiwa14").join(profile);
    let entries = std::fs::read_dir(folder).expect("trials");
    let names = entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned());
    let mut trials: Vec<String> = names.map(|name| format!("{profile}/{name}")).collect();
    trials.sort();
    assert!(!trials.is_empty());
    trials
}

/// Prints a line that `scripts/validate` reads: what was measured, and its figures by name.
#[allow(clippy::print_stdout, reason = "a test reports by printing")]
pub fn report(what: &str, figures: &[(&str, f64)]) {
    let figures: String = figures.iter().map(|(name, value)| format!(" | {name} {value:e}")).collect();
    println!("validate: {what}{figures}");
}

/// Mean, q75, q99 and greatest of absolute errors.
pub fn spread(mut errors: Vec<f64>) -> [(&'static str, f64); 4] {
    errors.sort_unstable_by(f64::total_cmp);
    let quantile = |share: f64| errors[((errors.len() - 1) as f64 * share).ceil() as usize];
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    [("mean", mean), ("q75", quantile(0.75)), ("q99", quantile(0.99)), ("max", quantile(1.0))]
}

/// Numbers spread over (−1, 1), the same for the same seed.
pub fn uniform(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

/// Asserts that a result is an error whose message has all parts.
#[track_caller]
pub fn refused<T>(result: Result<T, String>, parts: &[&str]) {
    let message = result.err().expect("accepted");
    for part in parts {
        assert!(message.contains(part), "expected `{part}` in: {message}");
    }
}

/// Bytes as a gzip file.
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}

/// Calibrates without watching.
pub fn solve(problem: &Problem) -> Estimate {
    calibrate(problem, &mut |_| ControlFlow::Continue(()))
}

/// The estimate of one core, and its seconds.
pub fn timed(problem: &Problem) -> (Estimate, f64) {
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let start = std::time::Instant::now();
    let estimate = one_core.install(|| solve(problem));
    (estimate, start.elapsed().as_secs_f64())
}

/// 3000 contacts of these parts, whose surfaces are off by 20 µm, and how they are searched.
pub fn simulated(parts: &PrismPair, seed: u64) -> (Trial, Search) {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("an arm").robot;
    let mut scenario = Preset::Paper.scenario(robot).expect("parts");
    scenario.contact_sigma = 20e-6;
    scenario.stiffness.rotation = 30.0;
    scenario.touches[0].exploration =
        Exploration { radius: 2e-3, tilt: 0.04, press: 3e-3, lift: 0.0, swing: 0.2, pace: 1.0, random_phases: false };
    scenario.touches[0].parts = Parts::PegInHole(Box::new(parts.clone()));
    let noise = Noise { encoder: 3.5e-5, contact: 20e-6, is_estimated: false };
    let search = Search { method: Method::LevenbergMarquardt, noise, loss: Loss::GemanMcClure(3.0) };
    (Trial::simulated(&scenario, seed).expect("contacts"), search)
}

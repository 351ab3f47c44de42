//! Training: what it writes and says, what a kill leaves, and calibrating with the result.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use super::manifold::no_uncertainty_is_expected;
use super::{data, errors, json, start, stderr, stdout, touchcal};

/// Options of a network that learns in a second.
const SMALL: [&str; 8] = ["--width", "32", "--depth", "2", "--pairs", "20000", "--learning-rate", "0.003"];

fn with_manifold() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let poses = data().join("mujoco_iiwa14/extrusion/offline/contact_poses.csv.gz");
    let args = ["manifold", "--poses", poses.to_str().unwrap(), "--spacing-mm", "2", "--out", "m.safetensors"];
    touchcal(folder.path(), &args).success();
    folder
}

fn train<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["train", "--manifold", "m.safetensors", "--out", out], &SMALL[..], more].concat()
}

/// Waits for the first checkpoint, and then for a later one.
fn wait_for_checkpoints(path: &Path) {
    let start = Instant::now();
    let mut first = None;
    while start.elapsed() < Duration::from_secs(60) {
        let written = std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok();
        if written.is_some() && written != *first.get_or_insert(written) {
            return;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("no checkpoints at {}", path.display());
}

#[test]
fn a_network_is_trained_and_used() {
    let folder = with_manifold();
    let done = touchcal(folder.path(), &train("new/net", &["--steps", "300", "--onnx"])).success();
    assert_eq!(errors(&done), "");
    let shown = stdout(&done);
    for part in
        ["Network   6 - 32 - 32 - 6", "mm, offsets up to", "10 mm, 10 deg ", "100 mm, 30 deg, outside", "weights.onnx"]
    {
        assert!(shown.contains(part), "expected `{part}` in:\n{shown}");
    }
    let out = folder.path().join("new/net");
    let mut names: Vec<_> = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["metrics.json", "touchcal.json", "weights.onnx", "weights.safetensors"]);
    let metrics = json(&out.join("metrics.json"));
    let near = &metrics["accuracy"][3];
    let value = |name: &str| near[name]["place_mean"].as_f64().unwrap();
    assert!(value("output_to_nearest") < 0.6 * value("pose_to_nearest"), "{near}");

    touchcal(folder.path(), &["demo", "--contacts", "600", "--out", "."]).success();
    let text = std::fs::read_to_string(folder.path().join("problem.toml")).unwrap();
    let key = "outline_offset_mm";
    let learned = |weights: &str| text.replace(key, &format!("manifold = \"learned\"\nweights = \"{weights}\"\n{key}"));
    std::fs::write(folder.path().join("learned.toml"), learned("new/net/weights.safetensors")).unwrap();
    let score = touchcal(folder.path(), &["evaluate", "learned.toml", "--urdf", "calibrated.urdf", "--json"]).success();
    let score: serde_json::Value = serde_json::from_str(&stdout(&score)).unwrap();
    assert!(
        score["mean_mm"].as_f64().unwrap() < 20.0 && score["nominal"]["mean_mm"].as_f64().unwrap() > 20.0,
        "{score}"
    );
    no_uncertainty_is_expected(folder.path(), "learned.toml");
    std::fs::write(folder.path().join("learned.toml"), learned("m.safetensors")).unwrap();
    let failed = touchcal(folder.path(), &["evaluate", "learned.toml", "--urdf", "calibrated.urdf"]).code(1);
    assert!(
        stderr(&failed).contains("m.safetensors, metadata: expected entry `touchcal_network`"),
        "{}",
        stderr(&failed)
    );
}

/// Enough steps that a kill comes before their end.
const LONG: [&str; 4] = ["--steps", "600", "--checkpoint-seconds", "0.02"];

#[test]
fn a_killed_training_goes_on_to_the_same_weights() {
    let folder = with_manifold();
    touchcal(folder.path(), &train("whole", &LONG[..2])).success();
    let mut child = start(folder.path(), &train("killed", &LONG));
    let checkpoint = folder.path().join("killed/checkpoint.safetensors");
    wait_for_checkpoints(&checkpoint);
    child.kill().unwrap();
    assert!(!child.wait().unwrap().success() && checkpoint.exists());
    let refused = touchcal(folder.path(), &train("killed", &LONG)).code(1);
    assert!(stderr(&refused).contains("checkpoint.safetensors exists: resume it (--resume)"), "{}", stderr(&refused));
    let resume = ["train", "--manifold", "m.safetensors", "--out", "killed", "--resume"];
    touchcal(folder.path(), &resume).success();
    assert!(!checkpoint.exists());
    let weights = |out: &str| std::fs::read(folder.path().join(out).join("weights.safetensors")).unwrap();
    assert!(weights("whole") == weights("killed"), "not the same weights");
}

#[cfg(unix)]
#[test]
fn an_interrupted_training_says_how_to_go_on() {
    let folder = with_manifold();
    let child = start(folder.path(), &train("out", &["--steps", "1000000", "--checkpoint-seconds", "0.02"]));
    let checkpoint = folder.path().join("out/checkpoint.safetensors");
    wait_for_checkpoints(&checkpoint);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let message = String::from_utf8(output.stderr).unwrap();
    let advice = "resume with `touchcal train --manifold m.safetensors --out out --resume`\n";
    assert!(message.starts_with("touchcal: error: interrupted after ") && message.ends_with(advice), "{message}");
    assert!(checkpoint.exists() && !folder.path().join("out/weights.safetensors").exists());

    let poses = std::fs::read(folder.path().join("m.safetensors")).unwrap();
    std::fs::write(folder.path().join("short.safetensors"), &poses[..poses.len() / 2]).unwrap();
    let other = "x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n0.5,0,0,1,0,0,0\n";
    std::fs::write(folder.path().join("other.csv"), other).unwrap();
    let resume = |manifold: &str| {
        stderr(&touchcal(folder.path(), &["train", "--manifold", manifold, "--out", "out", "--resume"]).code(1))
    };
    assert!(resume("short.safetensors").contains("a whole safetensors file"));
    assert!(resume("other.csv").contains("other.csv: expected the manifold of out/checkpoint.safetensors"));
    std::fs::write(&checkpoint, &std::fs::read(&checkpoint).unwrap()[..2000]).unwrap();
    assert!(resume("m.safetensors").contains("checkpoint.safetensors: expected a whole safetensors file"));
}

#[cfg(not(any(feature = "cuda", feature = "wgpu")))]
#[test]
fn a_device_that_this_build_lacks_is_refused_before_anything_is_read() {
    let folder = tempfile::tempdir().unwrap();
    for (device, name) in [("cuda", "CUDA"), ("wgpu", "wgpu")] {
        let args = ["train", "--manifold", "m.safetensors", "--out", "out", "--device", device];
        let refused = touchcal(folder.path(), &args).code(1);
        let expected =
            format!("touchcal: error: could not train: this build has no {name}: build with --features {device}\n");
        assert_eq!(stderr(&refused), expected);
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn wrong_usage_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |args: &[&str], part: &str| {
        let args = [&["train", "--manifold", "m.safetensors", "--out", "out"], args].concat();
        let message = stderr(&touchcal(folder.path(), &args).code(2));
        assert!(message.contains(part), "expected `{part}` in: {message}");
    };
    refused(&["--width", "0"], "a whole number from 1 to 65536");
    refused(&["--minutes", "1", "--steps", "5"], "cannot be used with");
    refused(&["--resume", "--width", "8"], "cannot be used with");
    refused(&["--learning-rate", "0"], "above 0");
    refused(&["--device", "tpu"], "[possible values: cpu, cuda, wgpu]");
    let missing = touchcal(folder.path(), &["train", "--manifold", "m.safetensors", "--out", "out"]).code(1);
    assert!(stderr(&missing).contains("m.safetensors"));
    let none = touchcal(folder.path(), &["train", "--manifold", "m.safetensors", "--out", "out", "--resume"]).code(1);
    assert!(stderr(&none).contains("checkpoint.safetensors: could not open"), "{}", stderr(&none));
}

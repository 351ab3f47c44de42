//! Ctrl-C and SIGTERM.

use std::process::Command;
use std::time::Duration;

use super::{start, touchcal};

#[test]
fn an_interrupted_calibration_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["demo", "--contacts", "500", "--out", "."]).success();
    for name in ["calibrated.urdf", "estimate.json", "report.html"] {
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
    // Enough contacts for ten seconds.
    let contacts = folder.path().join("hole.csv");
    let text = std::fs::read_to_string(&contacts).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    let moments = (0..150).flat_map(|k| rows.lines().map(move |row| format!("{row},{k}\n")));
    std::fs::write(&contacts, format!("{header},t\n{}", moments.collect::<String>())).unwrap();
    for signal in ["-INT", "-TERM"] {
        let child = start(folder.path(), &["calibrate", "problem.toml", "--out", "out"]);
        std::thread::sleep(Duration::from_secs(2));
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{signal}");
        assert_eq!(String::from_utf8(output.stderr).unwrap(), "touchcal: error: interrupted; no result was written\n");
        assert!(output.stdout.is_empty() && !folder.path().join("out").exists());
    }
}

/// Reading a log, and commands that have no steps.
#[test]
fn an_interrupt_ends_reading_at_once() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "paper", "--contacts", "500", "--out", "."]).success();
    let contacts = folder.path().join("hole.csv");
    let text = std::fs::read_to_string(&contacts).unwrap();
    let (header, rows) = text.split_once('\n').unwrap();
    // Seconds of reading.
    std::fs::write(&contacts, format!("{header}\n{}", rows.repeat(2_000))).unwrap();
    for command in [&["inspect", "problem.toml"][..], &["calibrate", "problem.toml", "--out", "out"]] {
        let child = start(folder.path(), command);
        std::thread::sleep(Duration::from_millis(300));
        let sent = std::time::Instant::now();
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        assert!(sent.elapsed() < Duration::from_secs(1), "{command:?}: {:?}", sent.elapsed());
        assert_eq!(output.status.code(), Some(130), "{command:?}");
        assert!(output.stdout.is_empty() && !folder.path().join("out").exists());
    }
}

#[test]
fn an_interrupted_simulation_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["simulate", "--preset", "paper", "--contacts", "1000000", "--out", "out"];
    let child = start(folder.path(), &args);
    std::thread::sleep(Duration::from_secs(1));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "touchcal: error: interrupted; no result was written\n");
    assert!(output.stdout.is_empty() && !folder.path().join("out").exists());
}

#[cfg(feature = "parquet")]
#[test]
fn an_interrupted_battery_keeps_its_rows() {
    let folder = tempfile::tempdir().unwrap();
    let child =
        start(folder.path(), &["experiment", "falsified", "--contacts", "300", "--threads", "1", "--out", "out"]);
    let rows = || std::fs::read_dir(folder.path().join("out/rows")).map_or(0, Iterator::count);
    while rows() == 0 {
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let printed = "touchcal: error: interrupted; finished rows are saved, the same command continues with the others\n";
    let stderr = String::from_utf8(output.stderr).unwrap();
    // On a slow machine lines of progress precede it.
    let (before, last) = stderr.split_at(stderr.len().saturating_sub(printed.len()));
    assert_eq!(last, printed);
    assert!(before.lines().all(|line| line.starts_with("touchcal: Trials, ")), "{stderr}");
    assert!(output.stdout.is_empty() && rows() > 0 && !folder.path().join("out/falsified.json").exists());
}

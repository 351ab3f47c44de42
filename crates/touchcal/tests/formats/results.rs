//! What is written: estimates and files that are whole or not there.

use proptest::prelude::*;
use touchcal::io::atomic;
use touchcal::io::estimate_file::{
    ContactCounts, EstimateFile, FixtureResidual, InputEntry, NullDirection, ParameterEntry, ResidualStats, Residuals,
    Status, TerminationEntry, WarningEntry,
};

fn stats() -> ResidualStats {
    let one = FixtureResidual { contacts: 3, mean_mm: Some(0.1), rms_mm: Some(0.2), max_mm: None };
    ResidualStats {
        mean_mm: Some(0.1),
        rms_mm: Some(0.2),
        max_mm: Some(0.3),
        per_fixture: [("hole".to_owned(), one)].into(),
    }
}

fn estimate() -> EstimateFile {
    EstimateFile {
        schema: 1,
        status: Status::NotConverged,
        parameters: vec![ParameterEntry {
            name: "strain".to_owned(),
            block: "strain".to_owned(),
            unit: "1".to_owned(),
            value: 0.05,
            sigma: Some(1e-4),
            prior_sigma: None,
            identifiable: true,
        }],
        covariance: vec![vec![1e-8]],
        rank: 1,
        condition: None,
        null_space: vec![NullDirection { words: "a and b".to_owned(), direction: [("strain".to_owned(), 1.0)].into() }],
        residuals: Residuals { prefit: stats(), postfit: stats() },
        contacts: ContactCounts { read: 10, used: 3, rejected: 0 },
        termination: TerminationEntry {
            reason: "step".to_owned(),
            measured: Some(1e-9),
            threshold: None,
            iterations: 4,
        },
        warnings: vec![WarningEntry { kind: "k".to_owned(), words: "w".to_owned(), advice: "a".to_owned() }],
        inputs: vec![InputEntry { path: "a".to_owned(), sha256: "0".to_owned() }],
        version: "0.1.0".to_owned(),
        seconds: 0.5,
    }
}

#[track_caller]
fn refused(text: &str, parts: &[&str]) {
    let message = EstimateFile::from_json(text, "estimate.json").unwrap_err().to_string();
    for part in parts {
        assert!(message.contains(part), "expected `{part}` in: {message}");
    }
}

#[test]
fn estimates_survive_json() {
    let text = estimate().to_json().unwrap();
    assert_eq!(EstimateFile::from_json(&text, "e").unwrap(), estimate());
    for part in ["\"status\": \"not_converged\"", "\"prior_sigma\": null", "\"condition\": null", "\"rms_mm\": 0.2"] {
        assert!(text.contains(part), "{part}");
    }
}

#[test]
fn numbers_that_json_cannot_hold_are_not_written() {
    let mut bad = estimate();
    bad.covariance[0][0] = f64::NAN;
    assert_eq!(
        bad.to_json().unwrap_err().to_string(),
        "estimate.json, covariance[0][0]: expected a finite number, found NaN"
    );
    let mut bad = estimate();
    bad.residuals.postfit.max_mm = Some(f64::INFINITY);
    assert!(bad.to_json().unwrap_err().to_string().contains("residuals.postfit"));
    let mut bad = estimate();
    bad.covariance.clear();
    assert!(bad.to_json().unwrap_err().to_string().contains("1 rows of 1 numbers"));
}

#[test]
fn other_json_is_refused() {
    let text = estimate().to_json().unwrap();
    refused("", &["estimate.json:1:0"]);
    refused("{", &["estimate.json:1:1", "EOF"]);
    refused("{}", &["missing field `schema`"]);
    refused(&text.replace("\"schema\": 1", "\"schema\": 7"), &["estimate.json, schema: expected schema 1, found 7"]);
    refused(&text.replace("not_converged", "maybe"), &["estimate.json:3:", "unknown variant `maybe`", "`converged`"]);
    refused(&text.replace("\"rank\"", "\"rnk\""), &["unknown field `rnk`"]);
    refused(&text.replace("\"value\": 0.05", "\"value\": null"), &["invalid type: null"]);
    refused(&"[".repeat(100_000), &["estimate.json:1:"]);
}

#[test]
fn files_are_written_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a/b/out.txt");
    atomic::write(&path, b"one").unwrap();
    atomic::write(&path, b"two").unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), b"two");
    assert_eq!(std::fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    let under_a_file = atomic::write(&path.join("x"), b"").unwrap_err().to_string();
    assert!(under_a_file.contains("out.txt: could not make the folder"), "{under_a_file}");
    let on_a_folder = atomic::write(&folder.path().join("a"), b"").unwrap_err().to_string();
    assert!(on_a_folder.contains("a: could not write"), "{on_a_folder}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[cfg(unix)]
#[test]
fn written_files_are_as_readable_as_others() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let (ours, plain) = (folder.path().join("ours"), folder.path().join("plain"));
    atomic::write(&ours, b"").unwrap();
    std::fs::write(&plain, b"").unwrap();
    let mode = |path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&ours), mode(&plain));
}

proptest! {
    #[test]
    fn mutated_estimates_are_answered(at in 0..900usize, cut in 0..20usize, with in "[{}\\[\\],:\"a-z0-9.e-]{0,5}") {
        let mut text = estimate().to_json().unwrap();
        let at = at.min(text.len());
        text.replace_range(at..(at + cut).min(text.len()), &with);
        let _ = EstimateFile::from_json(&text, "e");
    }

    #[test]
    fn any_text_is_answered(text in "\\PC{0,100}") {
        let _ = EstimateFile::from_json(&text, "e");
    }
}

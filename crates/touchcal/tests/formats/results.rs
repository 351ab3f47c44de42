//! What is written: estimates and files that are whole or not there.

use proptest::prelude::*;
use touchcal::io::estimate_file::{
    AcceptanceEntry, CompetingMinimumEntry, ContactCounts, Decision, EffectTestEntry, EffectValueEntry, EstimateFile,
    FixtureResidual, FreedEffectEntry, HeldOutEntry, NoiseEntry, NullDirection, ParameterEntry, PredictiveCheckEntry,
    PriorTestEntry, ResidualStats, Residuals, RobotEntry, ScatterEntry, Severity, Status, TaskErrorsEntry,
    TerminationEntry, WarningEntry, WorkspaceUncertaintyEntry,
};
use touchcal::io::{Input, atomic};

fn known() -> WorkspaceUncertaintyEntry {
    WorkspaceUncertaintyEntry {
        position_mm: 0.1,
        angle_deg: 0.01,
        distance_mm: 0.05,
        nominal_position_mm: 7.0,
        nominal_angle_deg: 1.0,
        nominal_distance_mm: 3.0,
    }
}

fn stats() -> ResidualStats {
    let one = FixtureResidual { contacts: 3, mean_mm: Some(0.1), rms_mm: Some(0.2), max_mm: None };
    ResidualStats {
        mean_mm: Some(0.1),
        rms_mm: Some(0.2),
        max_mm: Some(0.3),
        per_fixture: [("hole".to_owned(), one)].into(),
    }
}

fn null_direction() -> NullDirection {
    let direction = [("strain".to_owned(), 1.0)].into();
    NullDirection { description: "a and b".to_owned(), remedy: Some("c".to_owned()), direction }
}

fn estimate() -> EstimateFile {
    EstimateFile {
        schema: 2,
        status: Status::NotUsable,
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
        workspace_uncertainty: Some(known()),
        rank: 1,
        condition: None,
        null_space: vec![null_direction()],
        residuals: Residuals { prefit: stats(), postfit: stats() },
        contacts: ContactCounts { read: 10, used: 3, rejected: 0 },
        noise: Some(NoiseEntry { encoder: 3.5e-5, contact: 2e-5 }),
        termination: TerminationEntry {
            reason: "step".to_owned(),
            measured: Some(1e-9),
            threshold: None,
            iterations: 4,
        },
        warnings: vec![WarningEntry {
            kind: "k".to_owned(),
            severity: Severity::Caution,
            message: "w".to_owned(),
            advice: "a".to_owned(),
        }],
        competing_minima: vec![CompetingMinimumEntry { tool_distance_mm: 12.5, cost_ratio: 1.1, values: vec![0.04] }],
        effect_tests: vec![EffectTestEntry {
            effect: "joint_trend".to_owned(),
            description: "d".to_owned(),
            declared_in: "f".to_owned(),
            remedy: "r".to_owned(),
            statistic: 9.5,
            degrees_of_freedom: 2,
            p_value: 0.03,
            values: [("joint_trend.joint_a1".to_owned(), EffectValueEntry { value: 1e-4, sigma: 2e-5 })].into(),
            displacement_mm: 0.1,
            radius_mm: 0.2,
        }],
        prior_tests: vec![prior_test()],
        untested: vec!["joint_harmonic".to_owned()],
        freed_effects: vec![freed_effect()],
        predictive_check: Some(predictive_check()),
        held_out: Some(held_out()),
        acceptance: Some(acceptance()),
        notes: vec!["n".to_owned()],
        robot: Some(robot()),
        tip_from_tool: Some([0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0]),
        inputs: vec![Input { path: "a".to_owned(), sha256: "0".to_owned(), is_log: true }],
        version: "0.1.0".to_owned(),
        created: Some("2026-11-24T09:30:00Z".to_owned()),
        seconds: 0.5,
    }
}

fn robot() -> RobotEntry {
    let [name, base, tip, sha256] = ["r", "b", "t", "1"].map(str::to_owned);
    RobotEntry { name, base, tip, sha256 }
}

fn freed_effect() -> FreedEffectEntry {
    FreedEffectEntry { effect: "joint_harmonic".to_owned(), p_value: 1e-9, gain: 20.0, predictive_ratio: Some(1.5) }
}

fn prior_test() -> PriorTestEntry {
    PriorTestEntry {
        name: "fixture.hole".to_owned(),
        description: "d".to_owned(),
        declared_in: "f".to_owned(),
        remedy: "r".to_owned(),
        statistic: 3.5,
        degrees_of_freedom: 1,
        p_value: 0.06,
        values: [("fixture.hole.x".to_owned(), EffectValueEntry { value: 1e-3, sigma: 1e-3 })].into(),
        displacement_mm: Some(0.4),
    }
}

fn predictive_check() -> PredictiveCheckEntry {
    PredictiveCheckEntry { ratio: 1.1, p_value: 0.2, widening: 1.05, stretches: vec![1.0, 1.2] }
}

fn held_out() -> HeldOutEntry {
    let scatter = ScatterEntry { found_mm: 0.21, predicted_mm: 0.2, ratio: 1.05, by_chance: [0.9, 1.1] };
    HeldOutEntry { contacts: 300, scatter: Some(scatter) }
}

fn acceptance() -> AcceptanceEntry {
    let errors = TaskErrorsEntry {
        probability: 0.6,
        distance_mm: 0.4,
        angle_deg: 0.03,
        worst_pose: 17,
        parameter: "joint_offset.joint_a1".to_owned(),
        share: 0.7,
        aligned_probability: Some(0.97),
    };
    AcceptanceEntry {
        decision: Decision::Undecided,
        tolerance_mm: 0.2,
        tolerance_deg: None,
        confidence: 0.95,
        poses: 100,
        frame: "base".to_owned(),
        errors: Some(errors),
        message: "UNDECIDED".to_owned(),
        advice: "record more".to_owned(),
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
    // Version 0.2.0 wrote no tests of effects, no predictive check and no noise.
    let mut older: serde_json::Value = serde_json::from_str(&text).unwrap();
    for added in [
        "acceptance",
        "competing_minima",
        "effect_tests",
        "freed_effects",
        "held_out",
        "noise",
        "notes",
        "predictive_check",
        "prior_tests",
        "untested",
        "workspace_uncertainty",
    ] {
        older.as_object_mut().unwrap().remove(added);
    }
    let older = EstimateFile::from_json(&older.to_string(), "e").unwrap();
    assert_eq!(
        older,
        EstimateFile {
            competing_minima: Vec::new(),
            effect_tests: Vec::new(),
            prior_tests: Vec::new(),
            untested: Vec::new(),
            freed_effects: Vec::new(),
            notes: Vec::new(),
            noise: None,
            predictive_check: None,
            workspace_uncertainty: None,
            held_out: None,
            acceptance: None,
            ..estimate()
        }
    );
    for part in ["\"status\": \"not_usable\"", "\"prior_sigma\": null", "\"condition\": null", "\"rms_mm\": 0.2"] {
        assert!(text.contains(part), "{part}");
    }
}

/// What is needed to predict with an estimate comes back from its file.
#[test]
fn the_posterior_of_a_file_is_that_of_the_estimate() {
    let mut file = estimate();
    let posterior = file.posterior().unwrap();
    assert_eq!((posterior.entries[0].name.as_str(), posterior.entries[0].value), ("strain", 0.05));
    assert_eq!((posterior.covariance[(0, 0)], posterior.noise.unwrap().contact), (1e-8, 2e-5));
    file.parameters[0].sigma = None;
    assert!(file.posterior().is_none(), "nothing has an uncertainty");
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
    bad.effect_tests[0].p_value = f64::NAN;
    assert!(bad.to_json().unwrap_err().to_string().contains("effect_tests, joint_trend: expected a finite number"));
    let mut bad = estimate();
    bad.prior_tests[0].statistic = f64::INFINITY;
    assert!(bad.to_json().unwrap_err().to_string().contains("prior_tests, fixture.hole: expected a finite number"));
    let mut bad = estimate();
    bad.noise = Some(NoiseEntry { encoder: f64::NAN, contact: 0.0 });
    assert!(bad.to_json().unwrap_err().to_string().contains("noise.encoder: expected a finite number"));
    let mut bad = estimate();
    bad.workspace_uncertainty = Some(WorkspaceUncertaintyEntry { angle_deg: f64::NAN, ..known() });
    assert!(
        bad.to_json().unwrap_err().to_string().contains("workspace_uncertainty.angle_deg: expected a finite number")
    );
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
    refused(
        &text.replace("\"schema\": 2", "\"schema\": 7"),
        &["estimate.json, schema: expected schema 1 or 2, found 7"],
    );
    refused(&text.replace("not_usable", "maybe"), &["estimate.json:3:", "unknown variant `maybe`", "`usable`"]);
    refused(&text.replace("\"rank\"", "\"rnk\""), &["unknown field `rnk`"]);
    refused(&text.replace("\"value\": 0.05", "\"value\": null"), &["invalid type: null"]);
    refused(&"[".repeat(100_000), &["estimate.json:1:"]);
}

/// A result as version 0.1.0 wrote it, schema 1.
const SCHEMA_1: &str = include_str!("../../../../fuzz/corpus/estimate/good.json");

#[test]
fn a_result_of_version_0_1_is_read() {
    let file = EstimateFile::from_json(SCHEMA_1, "estimate.json").unwrap();
    assert_eq!((file.schema, file.status, file.parameters.len()), (2, Status::Usable, 20));
    let names: Vec<&str> = file.parameters.iter().map(|entry| entry.name.as_str()).collect();
    assert!(names.contains(&"gap_bias.hole") && names.contains(&"gap_bias.hole.-z"), "{names:?}");
    assert!(!names.iter().any(|name| name.contains("interference")), "{names:?}");
    assert!(file.parameters.iter().all(|entry| entry.name.starts_with(&entry.block)));
    let null = &file.null_space[0];
    assert!(null.description.starts_with("the offset of joint_a5") && null.direction.contains_key("gap_bias.hole"));
    assert_eq!(file.warnings.len(), 4);
    assert!(file.warnings.iter().all(|warning| warning.kind == "little_joint_motion"));
    assert!(file.warnings.iter().all(|warning| warning.severity == Severity::Caution));
    assert_eq!(file.warnings[0].message, "joint `joint_a2` moved only 1.64° in all contacts");
    // Numbers are as they were.
    let old: serde_json::Value = serde_json::from_str(SCHEMA_1).unwrap();
    let new: serde_json::Value = serde_json::from_str(&file.to_json().unwrap()).unwrap();
    assert_eq!((&old["status"], &new["status"]), (&"converged".into(), &"usable".into()));
    for key in ["covariance", "rank", "condition", "residuals", "contacts", "termination", "inputs"] {
        assert_eq!(old[key], new[key], "{key}");
    }
    for (old, new) in old["parameters"].as_array().unwrap().iter().zip(new["parameters"].as_array().unwrap()) {
        for key in ["unit", "value", "sigma", "prior_sigma", "identifiable"] {
            assert_eq!(old[key], new[key], "{key}");
        }
    }
}

/// What a status was called before it said whether a result is doubtful.
#[test]
fn earlier_names_of_a_status_are_read() {
    let text = estimate().to_json().unwrap();
    let status = |name: &str| EstimateFile::from_json(&text.replace("not_usable", name), "e").unwrap().status;
    assert_eq!((status("converged"), status("not_converged")), (Status::Usable, Status::NotUsable));
    assert_eq!((status("usable"), status("doubtful")), (Status::Usable, Status::Doubtful));
}

#[test]
fn severities_of_version_0_1_follow_from_its_words() {
    let warning = |kind: &str, words: &str| {
        let first =
            "\"kind\": \"joint_hardly_moved\",\n      \"words\": \"joint `joint_a2` moved only 1.64° in all contacts\"";
        assert!(SCHEMA_1.contains(first));
        let text = SCHEMA_1.replace(first, &format!("\"kind\": \"{kind}\", \"words\": \"{words}\""));
        let WarningEntry { kind, severity, .. } = EstimateFile::from_json(&text, "e").unwrap().warnings.remove(0);
        (kind, severity)
    };
    let unusable = |kind: &str| (kind.to_owned(), Severity::Unusable);
    let caution = |kind: &str| (kind.to_owned(), Severity::Caution);
    assert_eq!(warning("not_touching", "parts float: do not use the result"), unusable("not_touching"));
    assert_eq!(warning("ambiguous", "other parameters: do not use the result"), unusable("competing_minimum"));
    assert_eq!(warning("err_alike", "uncertainties were widened for that"), caution("correlated_errors"));
    assert_eq!(warning("too_few_contacts", "1 measured rows"), unusable("too_few_contacts"));
    assert_eq!(warning("compliance_needs_driver", "only touchcal reads"), caution("compliance_in_robot"));
}

#[test]
fn keys_of_one_schema_are_refused_in_the_other() {
    let new = estimate().to_json().unwrap();
    refused(&new.replace("\"schema\": 2", "\"schema\": 1"), &["unknown field `workspace_uncertainty`"]);
    refused(&SCHEMA_1.replace("\"schema\": 1", "\"schema\": 2"), &["unknown field `words`"]);
    refused(&new.replace("\"caution\"", "\"fatal\""), &["unknown variant `fatal`", "`unusable`"]);
    refused(&new.replace("      \"severity\": \"caution\",\n", ""), &["missing field `severity`"]);
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

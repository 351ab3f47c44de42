//! `select`: a model by prediction.

use super::golden::golden;
use super::{errors, json, stdout, touchcal};

#[test]
fn a_model_is_chosen_with_its_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| touchcal(folder.path(), args);
    run(&["simulate", "--preset", "mukca", "--contacts", "30", "--seed", "1", "--out", "sim"]).success();
    let text = stdout(&run(&["select", "sim/problem.toml"]).success());
    golden("select_mukca.txt", &text);
    let json: serde_json::Value =
        serde_json::from_str(&stdout(&run(&["select", "sim/problem.toml", "--json"]).success())).unwrap();
    assert_eq!(json["group_kind"], "placements");
    assert_eq!(json["groups"].as_array().unwrap().len(), 3);
    let models = json["models"].as_array().unwrap();
    let chosen = models.iter().find(|model| model["blocks"] == json["chosen"]).unwrap();
    assert_eq!(chosen["above_chosen"]["mean"], 0.0);
    assert_eq!(chosen["errors"].as_array().unwrap().len(), 3);
    let mean = chosen["held_out"]["mean"].as_f64().unwrap();
    assert!(text.contains(&format!("predicted to {:.3} ±", 1e3 * mean)), "{text}\n{json}");
    let names = chosen["blocks"].as_array().unwrap().iter().map(|name| name.as_str().unwrap());
    assert!(text.starts_with(&format!("Model     {}\n", names.collect::<Vec<_>>().join(" + "))), "{text}");
}

#[test]
fn too_few_contacts_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    touchcal(folder.path(), &["simulate", "--preset", "mukca", "--contacts", "8", "--out", "sim"]).success();
    let refused = touchcal(folder.path(), &["select", "sim/problem.toml", "--only", "left"]).code(1);
    let expected = "at least 3 placements or fixtures, or 20 contacts, to leave some out; found 16 contacts";
    assert!(errors(&refused).contains(expected), "{}", errors(&refused));
}

#[test]
fn a_calibration_has_the_chosen_model() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| touchcal(folder.path(), args);
    run(&["simulate", "--preset", "mukca", "--contacts", "15", "--seed", "1", "--out", "sim"]).success();
    let problem = folder.path().join("sim/problem.toml");
    let text = std::fs::read_to_string(&problem).unwrap();
    let declared = text.lines().find(|line| line.starts_with("parameters = ")).unwrap();
    assert!(declared.contains("joint_origin"), "{declared}");
    std::fs::write(&problem, text.replace(declared, "parameters = [\"joint_offset\"]")).unwrap();
    let done = run(&["calibrate", "sim/problem.toml", "--model", "auto", "--out", "out"]).success();
    let note = "model: joint_origin; 3 placements, each left out";
    let summary = stdout(&done);
    assert!(summary.contains(&format!("Note      {note}")), "{summary}");
    let found = json(&folder.path().join("out/estimate.json"));
    let notes = found["notes"].as_array().unwrap();
    assert!(notes.iter().any(|each| each.as_str().unwrap().starts_with(note)), "{notes:?}");
    let names = found["parameters"].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap());
    let (origins, offsets): (Vec<&str>, Vec<&str>) =
        names.filter(|name| name.starts_with("joint_")).partition(|name| name.starts_with("joint_origin."));
    assert!(origins.len() == 42 && offsets.iter().all(|name| !name.starts_with("joint_offset.")), "{offsets:?}");
}

//! `calibrate` by gradient descent: what the summary says of a search that is none for a minimum.

use super::{json, stdout, touchcal};

#[test]
fn the_summary_says_what_a_descent_has_used_and_where_it_ended() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| touchcal(folder.path(), args);
    // Without errors the descent starts where it ends.
    let scenario = "preset = \"paper\"\ncontacts = 90\n[errors]\nstrain = 0\njoint_offset_deg = 0\n";
    std::fs::write(folder.path().join("scenario.toml"), scenario).unwrap();
    run(&["simulate", "scenario.toml", "--seed", "1", "--out", "sim"]).success();
    let problem = folder.path().join("sim/problem.toml");
    let text = std::fs::read_to_string(&problem).unwrap();
    let method = "[estimate]\nmethod = \"gradient_descent\"\ndescent = { steps = 20, contacts = 40, rate = 1e-6 }";
    std::fs::write(&problem, text.replace("[estimate]", method)).unwrap();
    let said = stdout(&run(&["calibrate", "sim/problem.toml", "--out", "out"]).success()).replace("\n          ", " ");
    assert!(said.starts_with("DOUBTFUL"), "{said}");
    // Every third of 90.
    assert!(said.contains("90 contacts, of which the descent uses 30; 0 do not fit its result"), "{said}");
    assert!(said.contains("Search    all 20 steps of gradient descent, "), "{said}");
    assert!(said.contains("by less than 0.1 %, but more steps may still move parameters"), "{said}");
    assert!(!said.contains("Untested") && !said.contains("do not contradict"), "{said}");
    assert_eq!(json(&folder.path().join("out/estimate.json"))["untested"], serde_json::json!([]));
}

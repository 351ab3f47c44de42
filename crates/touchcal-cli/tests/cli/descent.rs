//! `calibrate` by gradient descent: what the summary says of a search that is none for a minimum.

use super::{json, stderr, stdout, touchcal};

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
    let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    assert!(report.contains("\"used_by_descent\":30"));
    assert!(said.contains("Search    all 20 steps of gradient descent, "), "{said}");
    assert!(said.contains("by less than 0.1 %, but more steps may still move parameters"), "{said}");
    assert!(!said.contains("Untested") && !said.contains("do not contradict"), "{said}");
    assert_eq!(json(&folder.path().join("out/estimate.json"))["untested"], serde_json::json!([]));
}

/// A descent that diverged: the first warning is on the search and its remedy, and nothing is said
/// of the data from where it ended.
#[test]
fn the_first_advice_on_a_descent_that_failed_is_on_the_search() {
    let folder = tempfile::tempdir().unwrap();
    let run = |args: &[&str]| touchcal(folder.path(), args);
    run(&["simulate", "--preset", "paper", "--contacts", "200", "--seed", "1", "--out", "sim"]).success();
    let problem = folder.path().join("sim/problem.toml");
    let text = std::fs::read_to_string(&problem).unwrap();
    let descend = |descent: &str| {
        let method = format!("[estimate]\nmethod = \"gradient_descent\"\ndescent = {{ {descent} }}");
        std::fs::write(&problem, text.replace("[estimate]", &method)).unwrap();
        let done = run(&["calibrate", "sim/problem.toml", "--out", "out"]).code(3);
        assert!(stderr(&done).contains("NOT USABLE"), "{}", stderr(&done));
        (stdout(&done).replace("\n          ", " "), json(&folder.path().join("out/estimate.json")))
    };
    for descent in ["steps = 30, contacts = 40, rate = 0.5", "steps = 30, contacts = 40, rate = 50"] {
        let (said, estimate) = descend(descent);
        let (_, warnings) = said.split_once("Warning   ").unwrap();
        let first = "(not usable) the gradient descent did not end at a minimum that contacts agree with: after 30 steps another one lowers their mean distance by ";
        assert!(warnings.starts_with(first), "{said}");
        let advice = warnings.split_once("-> ").unwrap().1;
        assert!(
            advice.starts_with("take the default method (method = \"levenberg_marquardt\"), or more `steps`"),
            "{said}"
        );
        assert_eq!(estimate["warnings"][0]["kind"], "descent_failed");
        assert!(
            said.contains("Identifiable  not stated, since the gradient descent did not end at a minimum\n"),
            "{said}"
        );
        for of_the_data in
            ["nothing in the data depends", "not identifiable", "too large for a calibration", "check units"]
        {
            assert!(!said.contains(of_the_data), "{of_the_data}: {said}");
        }
        assert!(said.contains("Next      calibrate by the default method"), "{said}");
        let report = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
        assert!(report.contains("\"null_space\":[],\"unknown\":\"not stated, since the gradient descent"));
        assert!(!report.contains("nothing in the data depends"));
    }
}

//! `touchcal experiment table1`: what it measures, keeps and refuses.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use super::{data, json, start, stderr, stdout, touchcal};

/// Rows of `table1.json` by one approach.
fn rows<'f>(file: &'f serde_json::Value, approach: &'f str) -> impl Iterator<Item = &'f serde_json::Value> {
    file["rows"].as_array().unwrap().iter().filter(move |row| row["approach"] == approach)
}

#[test]
#[ignore = "long form: scripts/test long"]
fn exact_gaps_beat_the_nearest_sample_on_recorded_trials() {
    let trials = ["00", "01", "02", "03", "20", "25", "28"].map(|number| format!("trial_{number}"));
    let folder = tempfile::tempdir().unwrap();
    let logs = data().join("mujoco_iiwa14/extrusion");
    for trial in &trials {
        let (from, to) = (logs.join("rich").join(trial), folder.path().join("rich").join(trial));
        std::fs::create_dir_all(&to).unwrap();
        for name in ["contact.csv.gz", "truth.json"] {
            std::fs::copy(from.join(name), to.join(name)).unwrap();
        }
    }
    let poses = logs.join("offline/contact_poses.csv.gz");
    let manifold = ["manifold", "--poses", poses.to_str().unwrap(), "--spacing-mm", "1", "--out", "m.safetensors"];
    touchcal(folder.path(), &manifold).success();
    let args = ["experiment", "table1", "--logs", "rich", "--manifold", "m.safetensors", "--out", "out"];
    let args = [&args[..], &["--steps", "500", "--descent-contacts", "100"]].concat();
    let done = touchcal(folder.path(), &args).success();
    assert!(stdout(&done).contains("Not computed without --weights FILE"), "{}", stdout(&done));
    let file = json(&folder.path().join("out/table1.json"));
    for row in rows(&file, "exact_lm") {
        let bias = |row: &serde_json::Value| row["bias_error_deg"].as_f64().unwrap();
        let nearest = rows(&file, "nearest_gd").find(|other| other["trial"] == row["trial"]).unwrap();
        assert!(bias(row) < 0.005 && bias(nearest) > 4.0 * bias(row), "{row} {nearest}");
        assert!(row["workspace"]["mean_mm"].as_f64().unwrap() < 0.1, "{row}");
    }
    let csv = std::fs::read_to_string(folder.path().join("out/table1.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + file["rows"].as_array().unwrap().len());
    assert_eq!(rows(&file, "exact_lm").count(), trials.len());
    let svg = std::fs::read_to_string(folder.path().join("out/table1.svg")).unwrap();
    assert!(
        svg.contains("<svg") && svg.contains("nearest sample") && svg.matches("<circle").count() >= 3 * trials.len()
    );
}

#[test]
fn rows_that_are_there_are_not_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["experiment", "table1", "--trials", "2", "--contacts", "600", "--out", "out"];
    touchcal(folder.path(), &args).success();
    let path = folder.path().join("out/rows/seed_1.exact_lm.json");
    let before = json(&path);
    assert!(before["bias_error_deg"].as_f64().unwrap() < 0.1, "{before}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    // One column wide; two trials and their mean in each panel, and one of each in the legend.
    let svg = read("table1.svg");
    assert!(svg.starts_with("<svg width=\"88mm\" height=\"23mm\"") && svg.matches("<circle").count() == 8, "{svg}");
    for words in ["encoder offset error (deg)", "link strain error (m/m)", "paper, real arm", "1.48", "0.019"] {
        assert!(svg.contains(&format!("\n{words}\n")), "expected the text `{words}` in:\n{svg}");
    }
    let latex = read("table1.tex");
    assert!(latex.contains("number of trials: 2.") && latex.contains("\nexact gap + LM & $"), "{latex}");
    // A mark that a second run would overwrite.
    let marked = std::fs::read_to_string(&path).unwrap().replace("\"seconds\": ", "\"seconds\": 1234");
    std::fs::write(&path, &marked).unwrap();
    std::fs::write(folder.path().join("out/rows/seed_2.exact_lm.json"), "{ half a row").unwrap();
    touchcal(folder.path(), &args).success();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), marked);
    assert_eq!(json(&folder.path().join("out/rows/seed_2.exact_lm.json"))["trial"], "seed_2");
    // Other settings are another experiment.
    touchcal(folder.path(), &["experiment", "table1", "--trials", "1", "--contacts", "500", "--out", "out"]).success();
    assert_ne!(std::fs::read_to_string(&path).unwrap(), marked);
}

/// The means include results that must not be used: text, LaTeX and figure say so, with their
/// number.
#[test]
fn refused_trials_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let args = ["experiment", "table1", "--trials", "2", "--contacts", "600", "--out", "out"];
    let said = stdout(&touchcal(folder.path(), &args).success());
    let read = |name: &str| std::fs::read_to_string(folder.path().join("out").join(name)).unwrap();
    assert!(!said.contains("Means include trials") && !read("table1.tex").contains("touchcal refuses"));
    assert!(!read("table1.svg").contains("of 2 refused"));
    let path = folder.path().join("out/rows/seed_2.exact_lm.json");
    let mut row = json(&path);
    assert_ne!(row["status"], "not_usable");
    row["status"] = "not_usable".into();
    std::fs::write(&path, row.to_string()).unwrap();
    let said = stdout(&touchcal(folder.path(), &args).success());
    assert!(said.contains("Means include trials whose result is refused."), "{said}");
    assert!(read("table1.tex").contains("touchcal refuses (not usable): exact gap + LM: 1 of 2.}"));
    assert!(read("table1.svg").contains("\n1 of 2 refused\n"), "{}", read("table1.svg"));
    assert_eq!(json(&folder.path().join("out/table1.json"))["summary"][0]["refused"], 1);
}

/// Waits until this many rows are kept.
fn wait_for_rows(folder: &Path, count: usize) {
    let begin = Instant::now();
    while std::fs::read_dir(folder).map_or(0, Iterator::count) < count {
        assert!(begin.elapsed() < Duration::from_secs(60), "no rows in {}", folder.display());
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[cfg(unix)]
#[test]
fn an_experiment_interrupted_and_killed_goes_on_to_the_same_table() {
    let folder = tempfile::tempdir().unwrap();
    let table = |out: &'static str| ["experiment", "table1", "--trials", "8", "--contacts", "600", "--out", out];
    touchcal(folder.path(), &table("whole")).success();
    let rows = folder.path().join("out/rows");

    let child = start(folder.path(), &table("out"));
    wait_for_rows(&rows, 1);
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("finished rows are saved, the same command continues"), "{said}");

    let kept = std::fs::read_dir(&rows).unwrap().count();
    let mut child = start(folder.path(), &table("out"));
    wait_for_rows(&rows, kept + 2);
    child.kill().unwrap();
    assert!(!child.wait().unwrap().success() && !folder.path().join("out/table1.json").exists());

    touchcal(folder.path(), &table("out")).success();
    let without_seconds = |out: &str| {
        let mut file = json(&folder.path().join(out).join("table1.json"));
        for table in ["rows", "summary"] {
            file[table].as_array_mut().unwrap().iter_mut().for_each(|row| row["seconds"] = 0.into());
        }
        file
    };
    assert_eq!(without_seconds("out"), without_seconds("whole"));
    let names = std::fs::read_dir(&rows).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    assert_eq!(names.filter(|name| name.ends_with(".exact_lm.json")).count(), 8);
}

#[test]
fn what_is_not_there_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("logs/one")).unwrap();
    let truth = r#"{"geometry": "square", "r": 0, "b_rad": [0], "T_flange_peg": {"position_m": [0, 0, 0], "quat_wxyz": [1, 0, 0, 0]},
        "T_base_hole": {"position_m": [0, 0, 0], "quat_wxyz": [1, 0, 0, 0]}}"#;
    let write = |text: &str| std::fs::write(folder.path().join("logs/one/truth.json"), text).unwrap();
    for (text, part) in [
        (
            truth.to_owned(),
            "truth.json, geometry: expected `extrusion`, the T-slot peg; contacts of other parts need a problem file, found \"square\"",
        ),
        (truth.replace("square", "extrusion"), "b_rad: expected 7 numbers, one for each joint, found 1"),
        (truth.replace("\"r\"", "\"q\""), "missing field `r`"),
        (truth[..50].to_owned(), "truth.json:1"),
    ] {
        write(&text);
        let done = touchcal(folder.path(), &["experiment", "table1", "--logs", "logs", "--out", "out"]).code(1);
        assert!(stderr(&done).contains(part) && stderr(&done).lines().count() == 1, "{}", stderr(&done));
    }
    let done = touchcal(folder.path(), &["experiment", "table1", "--only", "learned_gd", "--out", "out"]).code(1);
    assert!(stderr(&done).contains("--only learned_gd needs --weights FILE"), "{}", stderr(&done));
    for (args, part) in [(["--logs", "none"], "none"), (["--manifold", "m.csv"], "m.csv"), (["--weights", "w"], "w")] {
        let done = touchcal(folder.path(), &[&["experiment", "table1", "--out", "out"], &args[..]].concat()).code(1);
        assert!(stderr(&done).contains(part) && stderr(&done).lines().count() == 1, "{}", stderr(&done));
    }
}

/// Errors are those of the scenario that is given; one without a hole is refused.
#[test]
fn trials_of_another_scenario() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("errors.toml"), "schema = 1\n[errors]\njoint_offset_deg = 0.2\n").unwrap();
    let args = ["experiment", "table1", "--trials", "1", "--contacts", "60", "--only", "exact_lm", "--scenario"];
    touchcal(folder.path(), &[&args[..], &["errors.toml", "--out", "out"]].concat()).success();
    let file = json(&folder.path().join("out/table1.json"));
    let row = rows(&file, "exact_lm").next().unwrap();
    assert_eq!(row["strain_before"], 0.0);
    let before = row["bias_before_deg"].as_f64().unwrap();
    assert!((0.02..0.5).contains(&before), "{before}");
    std::fs::write(folder.path().join("sockets.toml"), "schema = 1\npreset = \"mukca\"\n").unwrap();
    let refused = touchcal(folder.path(), &[&args[..], &["sockets.toml", "--out", "no"]].concat()).code(1);
    assert!(stderr(&refused).contains("no hole with a peg"), "{}", stderr(&refused));
    assert!(!folder.path().join("no").exists());
}

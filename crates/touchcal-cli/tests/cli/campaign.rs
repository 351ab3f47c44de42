//! `touchcal experiment campaign` and `merge`: the same rows however they are computed, and what is
//! put together wrongly is named.

use std::path::Path;

use touchcal::experiment::CampaignRow;
use touchcal::io::campaign_parquet::{self, Part};

use super::{json, stderr, stdout, touchcal};

/// A campaign of balls in sockets, of three parts.
fn campaign<'a>(out: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let args = ["experiment", "campaign", "--preset", "mukca", "--trials", "110", "--contacts", "10", "--out", out];
    [&args[..], more].concat()
}

fn part(folder: &Path, out: &str, number: u32) -> std::path::PathBuf {
    folder.join(out).join(format!("parts/part-{number:06}.parquet"))
}

#[track_caller]
fn same(one: &[CampaignRow], other: &[CampaignRow]) {
    let alike = one.iter().zip(other).all(|(one, other)| campaign_parquet::identical(one, other));
    assert!(one.len() == other.len() && alike, "{} and {} rows", one.len(), other.len());
}

/// What is told but for how long it took.
fn without_seconds(mut told: serde_json::Value) -> serde_json::Value {
    assert!(told["seconds_a_trial"].as_f64().unwrap() > 0.0, "{told}");
    told["seconds_a_trial"] = 0.into();
    told
}

/// On one thread or several, whole or in shards, resumed or merged: always the same rows.
#[test]
fn shards_are_merged_to_the_whole_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let run = |args: &[&str]| touchcal(path, args);
    let whole = run(&campaign("whole", &["--threads", "1", "--json"])).success();
    let told: serde_json::Value = serde_json::from_str(&stdout(&whole)).unwrap();
    assert_eq!(told["trials"], 110);
    assert!(told["coverage"][2].as_f64().unwrap() > 0.8 && told["usable"].as_f64().unwrap() > 0.9, "{told}");
    assert!(std::fs::read_to_string(path.join("whole/campaign.svg")).unwrap().matches("<circle").count() == 5);
    let rows: Vec<CampaignRow> =
        (0..3).flat_map(|k| campaign_parquet::read_file(&part(path, "whole", k)).unwrap().rows).collect();
    assert!(rows.iter().map(|row| row.trial).eq(0..110));

    for (out, shard) in [("a", "1/3"), ("b", "2/3"), ("c", "3/3")] {
        let done = run(&campaign(out, &["--shard", shard, "--threads", "2"])).success();
        assert!(stdout(&done).contains("1 parts computed, 2 of other shards are not in"), "{}", stdout(&done));
        assert!(!path.join(out).join("campaign.json").exists());
    }
    let done = run(&["experiment", "merge", "c", "a", "b", "--out", "merged", "--rows", "--json"]).success();
    let merged: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    assert_eq!(without_seconds(merged), without_seconds(told.clone()));
    same(&campaign_parquet::read_file(&path.join("merged/rows.parquet")).unwrap().rows, &rows);

    // Copied into one folder, one damaged: only that is computed again.
    for (out, k) in [("b", 1), ("c", 2)] {
        std::fs::copy(part(path, out, k), part(path, "a", k)).unwrap();
    }
    let bytes = std::fs::read(part(path, "a", 1)).unwrap();
    std::fs::write(part(path, "a", 1), &bytes[..bytes.len() / 2]).unwrap();
    let untouched = std::fs::metadata(part(path, "a", 0)).unwrap().modified().unwrap();
    run(&campaign("a", &[])).success();
    assert_eq!(without_seconds(json(&path.join("a/campaign.json"))), without_seconds(told));
    assert_eq!(std::fs::metadata(part(path, "a", 0)).unwrap().modified().unwrap(), untouched);
    same(&campaign_parquet::read_file(&part(path, "a", 1)).unwrap().rows, &rows[50..100]);

    // All of `a` is there, and part of it elsewhere too.
    let done = run(&["experiment", "merge", "a", "c", "--out", "merged"]).success();
    assert!(stdout(&done).contains("Trials 100 to 109 are identical in two files and counted once: a/parts"));
    same(&campaign_parquet::read_file(&path.join("merged/rows.parquet")).unwrap().rows, &rows);
}

#[test]
fn what_does_not_make_a_whole_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // Rows of any content: what is checked is which there are, and that they are of one campaign.
    let write = |out: &str, number: u32, trials: std::ops::Range<u64>, settings: &str, nees: f64| {
        let rows = trials.map(|trial| CampaignRow { trial, parameters: 1, nees, ..CampaignRow::default() }).collect();
        let part = Part { settings: settings.to_owned(), trials: 170, core_seconds: 1.0, rows };
        std::fs::create_dir_all(path.join(out).join("parts")).unwrap();
        std::fs::write(self::part(path, out, number), campaign_parquet::to_bytes(&part).unwrap()).unwrap();
    };
    write("a", 0, 0..50, "seed 1\ncontacts = 20\n", 1.0);
    write("b", 2, 100..150, "seed 1\ncontacts = 20\n", f64::NAN);
    write("twice", 2, 100..150, "seed 1\ncontacts = 20\n", f64::NAN);
    write("differs", 0, 0..20, "seed 1\ncontacts = 20\n", 2.0);
    write("other", 1, 50..100, "seed 1\ncontacts = 30\n", 1.0);
    write("rest", 1, 50..100, "seed 1\ncontacts = 20\n", 1.0);
    write("rest", 3, 150..170, "seed 1\ncontacts = 20\n", 1.0);
    write("shuffled", 0, 3..53, "seed 1\ncontacts = 20\n", 1.0);
    std::fs::create_dir_all(path.join("empty/parts")).unwrap();
    for (folders, part) in [
        (&["b", "a"][..], "of trials 0 to 169 these are in none of b, a: 50 to 99, 150 to 169"),
        (&["a", "differs"], "trial 0 of differs/parts/part-000000.parquet is not that of a/parts/part-000000.parquet"),
        (&["a", "other"], "expected \"contacts = 20\" as in a/parts/part-000000.parquet, found \"contacts = 30\""),
        (&["a", "shuffled"], "shuffled/parts/part-000000.parquet: expected trials of one part, found others"),
        (&["a", "empty"], "empty/parts: expected parts of a campaign, found none"),
        (&["a", "none"], "none/parts: No such file"),
    ] {
        let done = touchcal(path, &[&["experiment", "merge", "--out", "out"], folders].concat()).code(1);
        assert!(stderr(&done).contains(part) && stderr(&done).lines().count() == 1, "{}", stderr(&done));
        assert!(!path.join("out").exists());
    }
    let done = touchcal(path, &["experiment", "merge", "a", "b", "rest", "twice", "--out", "out"]).success();
    assert!(
        stdout(&done).contains("Trials 100 to 149 are identical in two files") && stdout(&done).contains("170 trials")
    );
}

#[test]
fn a_number_is_varied() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let args = ["experiment", "campaign", "--preset", "mukca", "--trials", "20"];
    let run = |more: &[&str]| touchcal(path, &[&args[..], more].concat());
    let half = run(&["--vary", "contacts=10,40", "--out", "out", "--shard", "2/2"]).success();
    assert!(stdout(&half).contains("1 parts computed, 1 of other shards are not in the folders of out"));
    assert!(!part(path, "out/contacts=10", 0).exists() && part(path, "out/contacts=40", 0).exists());
    let done = run(&["--vary", "contacts=10,40", "--out", "out"]).success();
    assert!(stdout(&done).contains("20 trials each"), "{}", stdout(&done));
    let sweep = json(&path.join("out/sweep.json"));
    assert_eq!(sweep["setting"], "contacts");
    assert_eq!((&sweep["campaigns"][0]["value"], &sweep["campaigns"][1]["value"]), (&10.0.into(), &40.0.into()));
    assert_eq!(sweep["campaigns"][1]["coverage"], json(&path.join("out/contacts=40/campaign.json"))["coverage"]);
    let svg = std::fs::read_to_string(path.join("out/sweep.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains("contacts") && svg.matches("<circle").count() >= 6);

    // A value is a campaign like any other.
    run(&["--contacts", "10", "--out", "plain"]).success();
    let rows = |out: &str| campaign_parquet::read_file(&part(path, out, 0)).unwrap();
    assert_eq!(rows("plain").settings, rows("out/contacts=10").settings);
    same(&rows("plain").rows, &rows("out/contacts=10").rows);
    assert!(rows("out/contacts=40").rows.iter().all(|row| row.contacts >= 200));

    for (vary, code, part) in [
        ("contcts=10,20", 1, "found \"contcts\"; did you mean `contacts`?"),
        ("spurious=0.1,2", 1, "recorder, spurious: expected a share from 0 to below 1, found 2"),
        ("spurious", 2, "expected a setting's name and numbers, as in contacts=300,1000,3000"),
        ("spurious=0.1,,0.2", 2, "expected a setting's name and numbers"),
    ] {
        let done = run(&["--vary", vary, "--out", "wrong"]).code(code);
        assert!(stderr(&done).contains(part), "{}", stderr(&done));
    }
    // What cannot be simulated is said with its seed.
    let done = run(&["--vary", "force_threshold_n=1000", "--out", "never", "--threads", "1"]).code(1);
    let said = stderr(&done);
    assert!(said.contains("never/force_threshold_n=1000, seed ") && said.contains("expected contacts with"), "{said}");
    let wrong = run(&["--out", "wrong", "--shard", "3/2"]).code(2);
    assert!(stderr(&wrong).contains("expected i/n with i from 1 to n"), "{}", stderr(&wrong));
}

#[cfg(unix)]
#[test]
fn a_campaign_without_its_folder_ends_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = folder.path().join("out/parts/scenario.toml");
    let args = ["experiment", "campaign", "--preset", "paper", "--contacts", "1000", "--trials", "50", "--out", "out"];
    let child = super::start(folder.path(), &args);
    while !scenario.exists() {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::fs::remove_dir_all(folder.path().join("out")).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("out: the folder of the campaign is gone"), "{message}");
    assert!(!folder.path().join("out").exists());
}

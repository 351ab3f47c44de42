//! `inspect` and `calibrate` count directions of the same parameters, and say of which.

use std::path::Path;

use super::{json, stdout, touchcal};

/// The numbers before names in a list such as "7 joint_offset, 3 tool".
fn sum(list: &str) -> usize {
    list.split(", ")
        .filter(|part| !part.is_empty())
        .map(|part| part.split(' ').next().unwrap().parse::<usize>().unwrap())
        .sum()
}

/// All directions that a text counts, and the parameters that it counts for them and leaves out.
fn counts(text: &str) -> (usize, String, String) {
    let (_, after) = text.split_once("Identifiable  ").unwrap();
    let all = after.split(' ').nth(2).unwrap().parse().unwrap();
    let (_, words) = after.split_once("of these parameters: ").unwrap();
    // Up to the next line of another kind.
    let lines: Vec<&str> = words
        .lines()
        .take_while(|line| !line.contains("in ") && !line.is_empty() && !line.starts_with("Directions"))
        .collect();
    let words = lines.iter().map(|line| line.trim()).collect::<Vec<_>>().join(" ");
    let (counted, others) = words.split_once("; not counted are ").unwrap_or((&words, ""));
    (all, counted.to_owned(), others.to_owned())
}

fn agree(folder: &Path, preset: &str, contacts: &str) -> String {
    touchcal(folder, &["simulate", "--preset", preset, "--contacts", contacts, "--out", preset]).success();
    let problem = format!("{preset}/problem.toml");
    let inspected = stdout(&touchcal(folder, &["inspect", &problem, "--all"]));
    let calibrated = stdout(&touchcal(folder, &["calibrate", &problem, "--all", "--out", "out"]));
    let (all, counted, others) = counts(&inspected);
    assert_eq!((all, counted.clone(), others.clone()), counts(&calibrated), "{inspected}{calibrated}");
    assert_eq!(all, sum(&counted), "{inspected}");
    let parameters = json(&folder.join("out/estimate.json"))["parameters"].as_array().unwrap().len();
    assert_eq!(sum(&counted) + sum(&others), parameters, "{inspected}");
    others
}

#[test]
fn directions_are_of_the_same_parameters() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(agree(folder.path(), "mukca", "30"), "");
    let others = agree(folder.path(), "workcell", "600");
    assert!(others.contains("gap_bias"), "{others}");
}

//! `[log]`: how all logs are to be read, unless their tables of `[[contacts]]` have other values.

use super::problem_file::{FULL, folder, read, read_in};

const TWO: &str = "[[contacts]]\nfile = \"deg.csv\"\nfixture = \"table\"\n\
    [[contacts]]\nfile = \"deg.csv\"\nfixture = \"hole\"\n";

/// The full problem with these tables in place of its logs.
fn with(tables: &str) -> String {
    let (before, after) = (FULL.find("[[contacts]]").unwrap(), FULL.find("[noise]").unwrap());
    format!("{}{tables}{}", &FULL[..before], &FULL[after..])
}

#[test]
fn its_keys_hold_for_each_log() {
    let keys = "unit = \"deg\"\ncolumns = { q1 = \"axis1\" }\n";
    let each = TWO.replace("[[contacts]]\n", &format!("[[contacts]]\n{keys}"));
    let (once, each) = (with(&format!("[log]\n{keys}{TWO}")), with(&each));
    let folder = folder();
    let contacts = |text: &str| format!("{:?}", read_in(folder.path(), text).unwrap().problem.contacts);
    assert_eq!(contacts(&once), contacts(&each));
    // The place of the table does not matter.
    assert_eq!(contacts(&with(&format!("{TWO}[log]\n{keys}"))), contacts(&each));
}

#[test]
fn a_log_can_say_otherwise() {
    let log = "[log]\nunit = \"deg\"\nforce_threshold_n = 10\n";
    let logs = "[[contacts]]\nfile = \"log.csv\"\nfixture = \"hole\"\nunit = \"rad\"\nforce_threshold_n = 3\n";
    let contacts = read(&with(&format!("{log}{logs}"))).unwrap().problem.contacts;
    assert_eq!(contacts.len(), 1);
    assert_eq!(contacts.q(0)[3], 1.0);
}

#[test]
fn what_is_wrong_in_it_is_refused_there() {
    for (log, parts) in [
        ("unti = \"deg\"", ["problem.toml:32:1", "unknown field `unti`, expected one of", "did you mean `unit`?"]),
        ("file = \"deg.csv\"", ["problem.toml:32:1", "unknown field `file`", "`columns`"]),
        ("apart_deg = -1", ["problem.toml:32:13, log, apart_deg", "a positive number", "found -1"]),
        ("release_n = 2", ["problem.toml:32:13, log", "`force_threshold_n`", "without it"]),
        ("load_lag_rows = 2", ["problem.toml:32:17, log, load_lag_rows", "`load_on`", "without it"]),
        ("columns = { p1 = \"axis1\" }", ["deg.csv, columns", "`p1`", ""]),
    ] {
        let message = read(&with(&format!("[log]\n{log}\n{TWO}"))).expect_err(log);
        for part in parts {
            assert!(message.contains(part), "expected `{part}` in: {message}");
        }
    }
    // Of a key that only one of the two tables has, that table is named.
    let release = "[log]\nrelease_n = 5\n[[contacts]]\nfile = \"log.csv\"\nfixture = \"hole\"\nforce_threshold_n = 3\n";
    let message = read(&with(release)).unwrap_err();
    assert!(
        message.contains("problem.toml:32:13, log, release_n: expected at most force_threshold_n (3)"),
        "{message}"
    );
}

//! Defaults of the reference of `problem.toml` against the reader: written out, a default changes
//! nothing, and another value does.

use touchcal::contact::ContactLog;
use touchcal::io::problem_file;

use super::keys::{Key, Keys, Value};

/// A problem in which each key below has an effect; keys are inserted after the heads of tables.
const BASE: &str = "[robot]\nbuiltin = \"iiwa14\"\n[tool]\nkind = \"peg\"\nbuiltin = \"extrusion25\"\nlength_mm = 40\n\
    tip_from_tool = { xyz_mm = [0, 0, 150] }\n[[fixture]]\nname = \"hole\"\nkind = \"hole\"\noutline_offset_mm = 0.5\n\
    depth_mm = 30\nbase_from_fixture = { xyz_mm = [600, 100, 150] }\n[[fixture]]\nname = \"other\"\nkind = \"hole\"\n\
    outline_offset_mm = 0.5\ndepth_mm = 30\nbase_from_fixture = { xyz_mm = [600, -100, 150] }\n[[distance]]\n\
    between = [\"hole\", \"other\"]\nmm = 200\n[log]\n[[contacts]]\nfile = \"hole.csv\"\nfixture = \"hole\"\n\
    force_threshold_n = 3\nload_on = \"tool\"\n[noise]\n[estimate.prior]\n[estimate.descent]\n";
const SEARCH: &str = "[estimate]\nparameters = [\"strain\", \"joint_offset\", \"joint_origin\", \
    \"joint_backlash\", \"joint_harmonic\", \"joint_harmonic_2\", \"joint_gear_ratio\"]\n";
const DESCENT: &str = "[estimate]\nmethod = \"gradient_descent\"\nparameters = [\"joint_offset\"]\n";
const LOG: &str = "joint_a1,joint_a2,joint_a3,joint_a4,joint_a5,joint_a6,joint_a7,fx,fy,fz,tx,ty,tz\n\
    0,0.5,0,-1,0,0.7,0,0,0,5,0,0,0\n0,0.5,0,-1,0,0.7,0.1,0,0,5,0,0,0\n0,0.5,0,-1,0,0.7,0.2,0,0,1,0,0,0\n\
    0,0.5,0,-1,0,0.7,0.3,0,0,2,0,0,0\n0,0.5,0,-1,0,0.7,0.4,0,0,6,0,0,0\n0,0.5,0,-1,0,0.7,0.5,0,0,6,0,0,0\n";

/// Keys that need another one beside them, or whose default is not one value.
const NOT_ALONE: [&str; 3] = ["mesh_unit", "neighbours", "joint_origin_deg"];

/// The default as a file would state it, and another value; `None` where the default is no value.
pub fn values(key: &Key) -> Option<(String, String)> {
    let words = key.default.as_deref()?;
    if words.starts_with('[') {
        return Some((words.to_owned(), words.replace("-9.81", "-3.7")));
    }
    let first = words.split([';', ',', ' ']).next()?;
    match &key.value {
        Value::Number | Value::Integer => first
            .parse()
            .ok()
            .map(|x: f64| (first.to_owned(), format!("{}", if x.fract() == 0.0 { x + 1.0 } else { 0.9 * x }))),
        Value::Flag => first.parse().ok().map(|flag: bool| (first.to_owned(), format!("{}", !flag))),
        Value::OneOf(names) if names.iter().any(|name| name == first) => {
            let other = names.iter().find(|name| *name != first)?;
            Some((format!("\"{first}\""), format!("\"{other}\"")))
        }
        _ => None,
    }
}

/// What is estimated, but for its contacts: their notes say what was assumed.
fn problem(text: &str, with_contacts: bool) -> Result<String, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("hole.csv"), LOG).unwrap();
    let loaded = problem_file::read(text, "problem.toml", folder.path()).map_err(|error| error.to_string())?;
    let mut problem = loaded.problem;
    if !with_contacts {
        problem.contacts = ContactLog::default();
    }
    Ok(format!("{problem:?}").replace(&folder.path().display().to_string(), ""))
}

#[test]
fn defaults_are_those_of_the_reader() {
    let keys = Keys::read();
    let mut tested = 0;
    for (table, head, search) in [
        ("RobotToml", "[robot]\n", SEARCH),
        ("ToolToml", "[tool]\n", SEARCH),
        ("FixtureToml", "[[fixture]]\n", SEARCH),
        ("DistanceToml", "[[distance]]\n", SEARCH),
        ("LogToml", "[log]\n", SEARCH),
        ("ContactsToml", "[[contacts]]\n", SEARCH),
        ("NoiseToml", "[noise]\n", SEARCH),
        ("EstimateToml", "[estimate]\n", SEARCH),
        ("PriorToml", "[estimate.prior]\n", SEARCH),
        ("DescentToml", "[estimate.descent]\n", DESCENT),
    ] {
        let base = format!("{BASE}{search}");
        let base = if table == "DescentToml" { base } else { base.replace("[estimate.descent]\n", "") };
        let with_contacts = ["LogToml", "ContactsToml"].contains(&table);
        for key in keys.of(table).iter().filter(|key| !NOT_ALONE.contains(&key.name.as_str())) {
            let Some((default, other)) = values(key) else { continue };
            let place = format!("{table}.{} = {default}", key.name);
            // Noise that is declared is not estimated; the reference says so.
            let shown = |text: String| match (table, key.name.as_str()) {
                ("NoiseToml", "encoder_deg" | "contact_mm") => {
                    text.replace("is_estimated: false", "is_estimated: true")
                }
                _ => text,
            };
            let with = |value: &str| {
                let text = base.replacen(head, &format!("{head}{} = {value}\n", key.name), 1);
                problem(&text, with_contacts).map(shown)
            };
            let without = problem(&base, with_contacts).map(shown);
            assert_eq!(with(&default), without, "{place}");
            // Another value changes the problem, or is refused without another key.
            assert_ne!(with(&other), without, "{place}, not {other}");
            tested += 1;
        }
    }
    assert_eq!(tested, 42);
}

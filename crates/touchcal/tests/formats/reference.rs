//! The reference of `problem.toml` and `scenario.toml` in the guide, and their JSON Schemas: made
//! of the types that are read and their comments. `TOUCHCAL_UPDATE=1 cargo test` writes them anew.

mod defaults;
mod json_schema;
mod keys;
mod page;
mod scenario_defaults;

use std::path::Path;

use keys::{Keys, Value};
use touchcal::io::{problem_file, scenario_file};

const FILES: [(&str, &str, &str, &str); 2] = [
    ("problem.toml", "ProblemToml", "src/io/problem/problem.schema.json", problem_file::JSON_SCHEMA),
    ("scenario.toml", "ScenarioToml", "src/io/scenario/scenario.schema.json", scenario_file::JSON_SCHEMA),
];

#[track_caller]
fn same(path: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    if std::env::var_os("TOUCHCAL_UPDATE").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert_eq!(found, text, "{} differs; TOUCHCAL_UPDATE=1 takes the new text over", path.display());
}

#[test]
fn the_guides_reference_is_what_is_read() {
    let keys = Keys::read();
    same("../../guide/src/file-reference.md", &page::text(&keys));
    for (_, root, path, embedded) in FILES {
        let schema = json_schema::text(&keys, root);
        same(path, &schema);
        // After an update the next build has it.
        assert!(embedded == schema || std::env::var_os("TOUCHCAL_UPDATE").is_some(), "{path}");
    }
}

/// Each key says what it is, an optional one what it is without it, and each value has an example
/// that the reader's own types accept.
#[test]
fn each_key_is_explained() {
    let keys = Keys::read();
    for (name, table) in keys.tables() {
        for key in table {
            let place = format!("{name}.{}", key.name);
            assert!(key.meaning.ends_with('.'), "{place}: {:?}", key.meaning);
            let refused = key.meaning.starts_with("Refused");
            assert!(key.is_table || key.is_required || key.default.is_some(), "{place} has no default");
            match &key.example {
                Some(example) => {
                    let value: toml::Table = toml::from_str(example).unwrap();
                    assert_eq!(value.keys().collect::<Vec<_>>(), [&key.name], "{place}");
                    assert!(json_schema::accepts(&keys, &key.value, &value[&key.name]), "{place}: {example}");
                }
                None => assert!(key.is_table || refused, "{place} has no example"),
            }
        }
    }
}

/// Texts that must be among some names: the reference has the names that the readers' errors list.
#[test]
fn names_are_those_that_the_readers_expect() {
    let keys = Keys::read();
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    for (table, key, file, before) in [
        ("RobotToml", "builtin", "problem/good.toml", "builtin = \"iiwa14\""),
        ("ToolToml", "builtin", "problem/good.toml", "builtin = \"extrusion25\""),
        ("FixtureToml", "builtin", "problem/good.toml", "outline_offset_mm = 0.5"),
        ("EstimateToml", "parameters", "problem/good.toml", "parameters = [\"joint_offset\"]"),
        ("EstimateToml", "method", "problem/good.toml", "loss = \"geman_mcclure\""),
        ("ScenarioToml", "preset", "scenario/good.toml", "schema = 1"),
        ("ErrorsToml", "distribution", "scenario/good.toml", "distribution = \"uniform\""),
        ("TouchToml", "builtin", "scenario/good.toml", "outline_offset_mm = 0.5"),
    ] {
        let key = keys.of(table).iter().find(|found| found.name == key).unwrap();
        let (names, wrong) = match &key.value {
            Value::OneOf(names) => (names, format!("{} = \"none\"", key.name)),
            Value::List(inner, None) => match &**inner {
                Value::OneOf(names) => (names, format!("{} = [\"none\"]", key.name)),
                other => panic!("{other:?}"),
            },
            other => panic!("{other:?}"),
        };
        let text = std::fs::read_to_string(corpus.join(file)).unwrap();
        assert!(text.contains(before), "{file}: {before}");
        let (text, folder) = (text.replacen(before, &wrong, 1), corpus.join("problem"));
        let refusal = match file.starts_with("problem") {
            true => problem_file::read(&text, file, &folder).err().unwrap().to_string(),
            false => scenario_file::read(&text, file, &folder).err().unwrap().to_string(),
        };
        let expected = refusal.split("expected ").nth(1).and_then(|text| text.split(", found").next()).unwrap();
        let listed: Vec<&str> = expected.split('`').skip(1).step_by(2).collect();
        assert_eq!(&listed, names, "{table}.{}: {refusal}", key.name);
    }
}

/// Files that are read fit the schemas, and files that are refused for a key or the type of a value
/// do not.
#[test]
fn schemas_accept_what_is_read() {
    let keys = Keys::read();
    let fits = |root: &str, text: &str| {
        let value = toml::Value::Table(toml::from_str(text).unwrap());
        json_schema::accepts(&keys, &Value::Table(root.to_owned()), &value)
    };
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    for (root, file) in [
        ("ProblemToml", "problem/good.toml"),
        ("ProblemToml", "problem/good_more.toml"),
        ("ScenarioToml", "scenario/good.toml"),
        ("ScenarioToml", "scenario/good_distance.toml"),
    ] {
        assert!(fits(root, &std::fs::read_to_string(corpus.join(file)).unwrap()), "{file}");
    }
    let problem = "[robot]\nbuiltin = \"iiwa14\"\n[tool]\nkind = \"point\"\n[[fixture]]\nname = \"table\"\nkind = \"plane\"\n\
        base_from_fixture = { xyz_mm = [0, 0, 1] }\n[[contacts]]\nfile = \"a.csv\"\nfixture = \"table\"\n\
        [estimate]\nparameters = [\"joint_offset\"]\nprior = { joint_offset_deg = 1 }\n";
    assert!(fits("ProblemToml", problem));
    for (before, after) in [
        ("kind = \"plane\"", "kind = \"plan\""),
        ("name = \"table\"", "name = 5"),
        ("[0, 0, 1]", "[0, 0]"),
        ("[[fixture]]", "[fixture]"),
        ("prior = {", "priors = {"),
        ("[\"joint_offset\"]", "\"joint_offset\""),
        ("kind = \"point\"\n", ""),
    ] {
        let wrong = problem.replace(before, after);
        assert_ne!(wrong, problem);
        assert!(!fits("ProblemToml", &wrong), "{after}");
    }
}

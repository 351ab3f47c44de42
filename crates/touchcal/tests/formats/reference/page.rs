//! The page of the guide.

use super::FILES;
use super::keys::{Key, Keys, Value};

/// Ends of keys and the units they stand for, the longer ones first.
const UNITS: [(&str, &str); 16] = [
    ("rad_per_nm", "rad/(N m)"),
    ("nm_per_rad", "N m/rad"),
    ("mm_per_deg", "mm/°"),
    ("n_per_m", "N/m"),
    ("_per_k", "1/K"),
    ("gravity", "m/s²"),
    ("_rows", "rows"),
    ("_deg", "°"),
    ("_mm", "mm"),
    ("_nm", "N m"),
    ("_hz", "Hz"),
    ("mm", "mm"),
    ("_n", "N"),
    ("_s", "s"),
    ("_k", "K"),
    ("_c", "°C"),
];

const HEAD: &str = "# Reference of the files

Each key of `problem.toml` and `scenario.toml`, with what holds without it.
[The problem file](problem-file.md) explains what belongs together.
The page is generated from the types that the readers use.
What a preset has is in the `scenario.toml` that `touchcal simulate --preset NAME --out DIR` writes: every value is in it.

`touchcal schema problem` and `touchcal schema scenario` print JSON Schemas.
With the line `#:schema problem.schema.json` at the top of a `problem.toml`, an editor that knows TOML (Even Better TOML, taplo) completes keys and shows what they mean:

```sh
touchcal new peg-in-hole
touchcal schema problem > peg-in-hole/problem.schema.json
```
";

/// The page as Markdown.
pub fn text(keys: &Keys) -> String {
    let mut page = HEAD.to_owned();
    let mut shown: Vec<String> = Vec::new();
    for (file, root, ..) in FILES {
        page += &format!("\n## {file}\n");
        let single: Vec<&Key> = keys.of(root).iter().filter(|key| !key.is_table).collect();
        page += &format!("\nBefore all tables:\n\n{}", rows(&single));
        for key in keys.of(root).iter().filter(|key| key.is_table) {
            section(&mut page, keys, (&key.name, key), &mut shown);
        }
    }
    page += &format!(
        "\n## Poses\n\nA pose is a table of these keys.\n\n{}",
        rows(&keys.of("PoseToml").iter().collect::<Vec<_>>())
    );
    page += &format!(
        "\n## Regions\n\nA region is a table of these keys.\n\n{}",
        rows(&keys.of("RegionToml").iter().collect::<Vec<_>>())
    );
    page
}

/// A table of the file, and those in it.
fn section(page: &mut String, keys: &Keys, (path, key): (&str, &Key), shown: &mut Vec<String>) {
    let (title, name) = match &key.value {
        Value::List(inner, _) => (format!("[[{path}]]"), inner.as_ref()),
        value => (format!("[{path}]"), value),
    };
    let Value::Table(name) = name else { return };
    *page += &format!("\n### {title}\n\n");
    for sentence in key.meaning.split_inclusive(". ") {
        *page += &format!("{}\n", sentence.trim());
    }
    if shown.contains(name) {
        return;
    }
    shown.push(name.clone());
    let table = keys.of(name);
    *page += &format!("\n{}", rows(&table.iter().filter(|key| !key.is_table).collect::<Vec<_>>()));
    for inner in table.iter().filter(|key| key.is_table) {
        section(page, keys, (&format!("{path}.{}", inner.name), inner), shown);
    }
}

fn rows(keys: &[&Key]) -> String {
    let mut text = "| key | value | without it | meaning |\n|---|---|---|---|\n".to_owned();
    for key in keys {
        let default = match &key.default {
            _ if key.is_required => "required",
            Some(default) => default,
            None => "",
        };
        let example = key.example.as_ref().map_or_else(String::new, |example| format!(" `{example}`"));
        text += &format!("| `{}` | {} | {default} | {}{example} |\n", key.name, kind(key), key.meaning);
    }
    text
}

fn kind(key: &Key) -> String {
    let unit = UNITS.iter().find(|(end, _)| key.name.ends_with(end)).map_or("", |(_, unit)| unit);
    let words = words(&key.value);
    if unit.is_empty() || !matches!(key.value, Value::Number | Value::List(..)) {
        words
    } else {
        format!("{words}, {unit}")
    }
}

fn words(value: &Value) -> String {
    match value {
        Value::Number => "number".to_owned(),
        Value::Integer => "whole number".to_owned(),
        Value::Text => "text".to_owned(),
        Value::Flag => "true or false".to_owned(),
        Value::FlagOrTexts => "true, false or texts".to_owned(),
        Value::OneOf(names) => names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "),
        Value::List(inner, Some(length)) => format!("{length} × {}", self::words(inner)),
        Value::List(inner, None) => format!("list: {}", self::words(inner)),
        Value::Texts => "texts by name".to_owned(),
        Value::Table(name) if name == "PoseToml" => "[pose](#poses)".to_owned(),
        Value::Table(name) if name == "RegionToml" => "[region](#regions)".to_owned(),
        Value::Table(_) => "table".to_owned(),
    }
}

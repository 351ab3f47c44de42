//! Defaults of the reference of `scenario.toml` against the reader: written out, a default changes
//! nothing, and another value does.

use std::path::Path;

use touchcal::io::scenario_file;
use touchcal::sim::Preset;

use super::defaults::values;
use super::keys::{Key, Keys};

/// A scenario in which each key of a part below has an effect.
const PARTS: &str = "[tool]\nkind = \"peg\"\nbuiltin = \"extrusion25\"\nlength_mm = 40\n\
    tip_from_tool = { xyz_mm = [0, 0, 150] }\n[[fixture]]\nname = \"hole\"\nkind = \"hole\"\noutline_offset_mm = 0.5\n\
    depth_mm = 30\nbase_from_fixture = { xyz_mm = [600, 100, 150] }\npostures_deg = [[0, 42, 15, -89, -13, 50, -1]]\n\
    [[fixture]]\nname = \"other\"\nkind = \"hole\"\noutline_offset_mm = 0.5\ndepth_mm = 30\n\
    base_from_fixture = { xyz_mm = [600, -100, 150] }\npostures_deg = [[0, 42, 15, -89, -13, 50, -1]]\n\
    [[distance]]\nbetween = [\"hole\", \"other\"]\n";
/// Tables of which keys are as in the preset, and their heads.
const OF_PRESETS: [(&str, &str); 6] = [
    ("ScenarioToml", ""),
    ("ErrorsToml", "errors"),
    ("ExplorationToml", "exploration"),
    ("StiffnessToml", "stiffness"),
    ("RecorderToml", "recorder"),
    ("ThermalToml", "thermal"),
];
const AS_IN_THE_PRESET: &str = "as in the preset";

/// All that a scenario says, with every key, or why it is refused.
fn scenario(text: &str) -> Result<String, String> {
    let file = scenario_file::read(text, "scenario.toml", Path::new("")).map_err(|error| error.to_string())?;
    Ok(scenario_file::scenario_text(&file).into_iter().map(|file| file.text).collect())
}

/// A table of a scenario with every key; that of the exploration is of the first fixture.
fn table(text: &str, name: &str) -> toml::Table {
    let whole: toml::Table = toml::from_str(text).unwrap();
    match name {
        "" => whole,
        "exploration" => whole["fixture"][0]["exploration"].as_table().unwrap().clone(),
        _ => whole[name].as_table().unwrap().clone(),
    }
}

/// The key with another default in words.
fn with_default(key: &Key, default: &str) -> Key {
    Key { default: Some(default.to_owned()), ..key.clone() }
}

/// A scenario that begins with `start`, with a line in the table `name`.
fn with_line(start: &str, name: &str, line: &str) -> Result<String, String> {
    scenario(&if name.is_empty() { format!("{line}\n{start}") } else { format!("{start}[{name}]\n{line}\n") })
}

#[test]
fn keys_are_as_in_the_preset() {
    let keys = Keys::read();
    let mut tested = 0;
    for (of, name) in OF_PRESETS {
        let is_of_preset = |key: &&Key| key.default.as_deref().is_some_and(|words| words.starts_with(AS_IN_THE_PRESET));
        for key in keys.of(of).iter().filter(is_of_preset) {
            let mut has_effect = false;
            for preset in Preset::ALL {
                let start = format!("preset = \"{}\"\n", preset.name());
                let without = scenario(&start).unwrap();
                let default = table(&without, name)[&key.name].to_string();
                let (_, other) = values(&with_default(key, default.trim_matches('"'))).unwrap();
                let with = |value: &str| with_line(&start, name, &format!("{} = {value}", key.name));
                assert_eq!(with(&default).as_ref(), Ok(&without), "{of}.{} = {default}, {}", key.name, preset.name());
                // Another value changes the scenario, or is refused: a share of 1.
                has_effect |= with(&other).as_ref() != Ok(&without);
            }
            assert!(has_effect, "{of}.{}", key.name);
            tested += 1;
        }
    }
    assert_eq!(tested, 43);
}

/// Without a preset a scenario is that of the paper, with the errors that the reference states.
#[test]
fn keys_without_a_preset_have_the_stated_defaults() {
    let keys = Keys::read();
    let without = scenario("").unwrap();
    let paper = scenario("preset = \"paper\"\n").unwrap();
    for (_, name) in OF_PRESETS.into_iter().filter(|(of, _)| *of != "ErrorsToml" && *of != "ScenarioToml") {
        assert_eq!(table(&without, name), table(&paper, name), "{name}");
    }
    for key in ["contacts", "friction", "contact_mm", "robot", "tool", "fixture"] {
        assert_eq!(table(&without, "")[key], table(&paper, "")[key], "{key}");
    }
    let mut tested = 0;
    for key in keys.of("ErrorsToml") {
        let words = key.default.as_deref().unwrap().replace('`', "");
        let stated =
            words.strip_prefix(&format!("{AS_IN_THE_PRESET}, ")).and_then(|words| words.strip_suffix(" without one"));
        let (default, other) = values(&with_default(key, stated.unwrap())).unwrap();
        let with = |value: &str| with_line("", "errors", &format!("{} = {value}", key.name));
        assert_eq!(with(&default).as_ref(), Ok(&without), "{} = {default}", key.name);
        assert_ne!(with(&other).as_ref(), Ok(&without), "{}, not {other}", key.name);
        tested += 1;
    }
    assert_eq!(tested, 12);
}

#[test]
fn parts_have_the_stated_defaults() {
    let keys = Keys::read();
    let without = scenario(PARTS);
    assert!(without.is_ok(), "{without:?}");
    let mut tested = 0;
    for (of, head) in [("ScenarioToml", ""), ("TouchToml", "[[fixture]]\n"), ("MeasuredDistanceToml", "[[distance]]\n")]
    {
        for key in keys.of(of) {
            let Some((default, other)) = values(key) else { continue };
            let with = |value: &str| scenario(&PARTS.replacen(head, &format!("{head}{} = {value}\n", key.name), 1));
            assert_eq!(with(&default), without, "{of}.{} = {default}", key.name);
            // Another value changes the scenario, or is refused without another key.
            assert_ne!(with(&other), without, "{of}.{}, not {other}", key.name);
            tested += 1;
        }
    }
    assert_eq!(tested, 11);
}

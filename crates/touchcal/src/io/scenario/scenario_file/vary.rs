//! A scenario with one number replaced, by the name that `scenario.toml` has for it.

use std::collections::BTreeSet;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::read::ScenarioFile;
use super::write::{SCENARIO, TextFile, scenario_text};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::{did_you_mean, list};
use crate::io::base::toml_text::number;

/// The files of [`scenario_text`] with the number called `name` replaced by `value` (in the unit of
/// its key, twelve digits) in every table that has it. Numbers in lists, such as a pose's, have no
/// name.
///
/// A name is a key, preceded by as many names of its tables as make it unique: `spurious`,
/// `tool.sigma_mm`.
///
/// # Errors
/// [`IoError::Unexpected`] if no number has that name, or numbers of different tables have. Whether
/// the value is allowed is checked by [`read_file`](super::read_file).
pub fn varied_text(file: &ScenarioFile, name: &str, value: f64) -> Result<Vec<TextFile>, IoError> {
    let mut files = scenario_text(file);
    for file in files.iter_mut().filter(|file| file.name == SCENARIO) {
        let mut places = places(&file.text, name)?;
        // From the end, so that the places before stay where they are.
        places.sort_unstable_by_key(|place| std::cmp::Reverse(place.start));
        places.into_iter().for_each(|place| file.text.replace_range(place, &number(value)));
    }
    Ok(files)
}

/// Where a scenario's text has the number `name`.
fn places(text: &str, name: &str) -> Result<Vec<Range<usize>>, IoError> {
    let table = DeTable::parse(text).map_err(|error| IoError::syntax(Place::file(SCENARIO), error.message()))?;
    let mut numbers = Vec::new();
    collect(table.get_ref(), "", &mut numbers);
    let unexpected = |expected: String, found: String| Err(IoError::unexpected(Place::file(SCENARIO), expected, found));
    let meant = |full: &str| full == name || full.strip_suffix(name).is_some_and(|tables| tables.ends_with('.'));
    let names: BTreeSet<&str> = numbers.iter().map(|(full, _)| full.as_str()).filter(|full| meant(full)).collect();
    match names.len() {
        1 => Ok(numbers.iter().filter(|(full, _)| meant(full)).map(|(_, place)| place.clone()).collect()),
        0 => {
            let keys = || numbers.iter().map(|(full, _)| full.rsplit('.').next().unwrap_or_default());
            let hint = did_you_mean(name, numbers.iter().map(|(full, _)| full.as_str()).chain(keys()));
            let known: BTreeSet<&str> = keys().collect();
            unexpected(format!("the name of a number, {}", list(known)), format!("{}{hint}", quoted(name)))
        }
        _ => unexpected(list(names), format!("{}, which each of them could be", quoted(name))),
    }
}

/// The numbers of a table by their full names, and where they are; the tables of an array share
/// their names.
fn collect(table: &DeTable<'_>, before: &str, numbers: &mut Vec<(String, Range<usize>)>) {
    for (key, value) in table {
        let name = format!("{before}{}", key.get_ref());
        match value.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) if name != "schema" => numbers.push((name, value.span())),
            DeValue::Table(table) => collect(table, &format!("{name}."), numbers),
            DeValue::Array(values) => {
                let tables = values.iter().filter_map(|value: &Spanned<DeValue<'_>>| value.get_ref().as_table());
                tables.for_each(|table| collect(table, &format!("{name}."), numbers));
            }
            _ => {}
        }
    }
}

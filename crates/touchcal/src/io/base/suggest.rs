//! "Did you mean": the known name nearest to an unknown one.

use super::error::shown_name;

/// Longest name compared (bytes): the comparison takes time proportional to the product of both
/// lengths.
const LONGEST: usize = 100;

/// `; did you mean "x"?` where a known name is near enough to be a typing error, else nothing.
pub fn did_you_mean<'a>(unknown: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    if unknown.len() > LONGEST {
        return String::new();
    }
    let unknown = unknown.to_lowercase();
    // A third of the letters wrong is still recognisable; more is a different word.
    let most = (unknown.chars().count() / 3).max(1);
    let near = known.into_iter().filter(|name| name.len() <= LONGEST).map(|name| {
        let lower = name.to_lowercase();
        // `sigma` for `sigma_mm`: the unit is left out.
        let lacks_unit = lower.strip_prefix(&unknown).is_some_and(|rest| rest.starts_with('_'));
        (if lacks_unit { 1 } else { strsim::osa_distance(&unknown, &lower) }, name)
    });
    match near.filter(|(distance, _)| *distance <= most).min_by_key(|(distance, _)| *distance) {
        Some((_, name)) => format!("; did you mean `{name}`?"),
        None => String::new(),
    }
}

/// `` `a`, `b` or `c` ``, for messages; long lists are cut.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    /// More names than this do not help anyone.
    const MOST: usize = 20;
    let names: Vec<String> = names.into_iter().map(|name| format!("`{}`", shown_name(name))).collect();
    match names.as_slice() {
        [] => "none".to_owned(),
        [only] => only.clone(),
        [first @ .., last] if names.len() <= MOST => format!("{} or {last}", first.join(", ")),
        _ => format!("{} … ({} in all)", names[..MOST].join(", "), names.len()),
    }
}

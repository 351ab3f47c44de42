//! Values as Python writes them.

/// A number as Python writes it.
pub fn shown(value: Option<f64>) -> String {
    value.map_or("None".to_owned(), |value| format!("{value:?}"))
}

/// A truth value as Python writes it.
pub fn python_bool(value: bool) -> &'static str {
    if value { "True" } else { "False" }
}

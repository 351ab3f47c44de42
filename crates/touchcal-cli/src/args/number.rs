//! Parsers of bounded numbers.

/// A parser of whole numbers from `least` to `most`.
pub fn count(least: usize, most: usize) -> impl Fn(&str) -> Result<usize, String> + Clone {
    move |text| match text.parse() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("expected a whole number from {least} to {most}")),
    }
}

/// Largest value of an argument.
const LARGEST: f64 = 1e4;

/// Parses a number from 0 to [`LARGEST`].
pub fn not_negative(text: &str) -> Result<f64, String> {
    let value = text.parse().map_err(|_| "expected a number".to_owned())?;
    if (0.0..=LARGEST).contains(&value) { Ok(value) } else { Err(format!("expected a number from 0 to {LARGEST}")) }
}

/// Parses a number from −[`LARGEST`] to [`LARGEST`].
pub fn coordinate(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "expected a number".to_owned())?;
    if value.abs() <= LARGEST { Ok(value) } else { Err(format!("expected a number from -{LARGEST} to {LARGEST}")) }
}

/// Parses a number above 0, up to [`LARGEST`].
pub fn positive(text: &str) -> Result<f64, String> {
    let value = not_negative(text)?;
    if value > 0.0 { Ok(value) } else { Err("expected a number above 0".to_owned()) }
}

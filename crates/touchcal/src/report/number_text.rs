//! Numbers as summaries have them.

/// Most digits of a number; one with more has an exponent.
const MOST_DIGITS: usize = 17;

/// A number with `decimals`, or with an exponent where that takes more than 17 digits.
pub fn fixed(value: f64, decimals: usize) -> String {
    short(format!("{value:.decimals$}"), || format!("{value:.decimals$e}"))
}

/// A number as [`fixed`] has it, with its sign; tiny ones do not become "-0.000".
pub fn signed(value: f64, decimals: usize) -> String {
    let text = short(format!("{value:+.decimals$}"), || format!("{value:+.decimals$e}"));
    if text.trim_start_matches(['-', '0', '.']).is_empty() { text.replace('-', "+") } else { text }
}

fn short(text: String, with_exponent: impl FnOnce() -> String) -> String {
    let is_short = text.bytes().filter(u8::is_ascii_digit).count() <= MOST_DIGITS;
    if is_short { text } else { with_exponent() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_seventeen_digits_at_most() {
        assert_eq!(fixed(12.34567, 3), "12.346");
        assert_eq!(fixed(-99_999_999_999_999.0, 3), "-99999999999999.000");
        assert_eq!(fixed(1_860_015_338_233_801.5, 3), "1.860e15");
        assert_eq!(signed(-1e300, 3), "-1.000e300");
        assert_eq!(signed(-1e-9, 3), "+0.000");
    }
}

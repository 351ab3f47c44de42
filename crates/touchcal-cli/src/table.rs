//! Aligned columns of text.

/// A table that is printed without lines: first column flush left, the others flush right.
#[derive(Debug, Default)]
pub struct Table {
    rows: Vec<Vec<String>>,
}

/// Blanks between columns.
const GAP: &str = "  ";

impl Table {
    /// A table with these headings.
    pub fn new<const N: usize>(headings: [&str; N]) -> Self {
        Table { rows: vec![headings.map(str::to_owned).to_vec()] }
    }

    /// Appends a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |column: usize| self.rows.iter().filter_map(|row| row.get(column)).map(|c| c.chars().count()).max();
        let widths: Vec<usize> = (0..columns).map(|column| width(column).unwrap_or(0)).collect();
        for row in &self.rows {
            let mut line = GAP.to_owned();
            for (column, cell) in row.iter().enumerate() {
                let width = widths[column];
                match column {
                    0 => line.push_str(&format!("{cell:<width$}")),
                    _ => line.push_str(&format!("{GAP}{cell:>width$}")),
                }
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

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

//! What contacts say against the problem file, as text.

use touchcal::estimate::{Estimate, FreedEffect, Problem};
use touchcal::report::DeclarationTests;
use touchcal::statistics::p_value_statement;

use super::layout::wrapped;
use crate::table::Table;

/// What contacts say against the problem file: a table of what they contradict, and lines on what
/// they do not contradict and what they cannot test.
pub fn declarations(estimate: &Estimate, problem: &Problem) -> String {
    let DeclarationTests { title, contradicted, others } = DeclarationTests::new(estimate, problem);
    let mut text = String::new();
    if !contradicted.is_empty() {
        let mut table = Table::new(DeclarationTests::HEADINGS);
        contradicted.into_iter().for_each(|row| table.row(row));
        text += &format!("{title}\n{table}");
    }
    text.extend(others.iter().map(|(label, words)| format!("{label}  {}\n", wrapped(words))));
    if text.is_empty() { text } else { text + "\n" }
}

/// Effects that were freed, and what each is worth.
pub fn freed_effects(freed: &[FreedEffect]) -> String {
    let line = |FreedEffect { effect, p_value, gain, predictive_ratio }: &FreedEffect| {
        let without =
            predictive_ratio.map_or_else(String::new, |ratio| format!(", predicted scatter {ratio:.2} without it"));
        let p = p_value_statement(*p_value);
        format!("Freed     {}: {gain:+.1} in the log-likelihood ({p}){without}\n", effect.name())
    };
    freed.iter().map(line).collect()
}

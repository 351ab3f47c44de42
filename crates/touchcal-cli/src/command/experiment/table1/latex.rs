//! The table as LaTeX.

use super::summary::{PUBLISHED_BIAS_DEG, PUBLISHED_REDUCTION, PUBLISHED_STRAIN, Summary};

/// A number that was not published, or is not finite.
const NONE: &str = "--";

const HEAD: &str = r"% Needs \usepackage{booktabs}.
\begin{tabular}{lrrrrrrrr}
\toprule
 & \multicolumn{2}{c}{Mean absolute error} & \multicolumn{2}{c}{Error before\,/\,after}
 & \multicolumn{2}{c}{Tool at the hole} & \multicolumn{2}{c}{Tool at other poses} \\
\cmidrule(lr){2-3}\cmidrule(lr){4-5}\cmidrule(lr){6-7}\cmidrule(lr){8-9}
Method & strain (m/m) & offset ($^\circ$) & strain & offset & (mm) & ($^\circ$) & (mm) & ($^\circ$) \\
\midrule
";
const BOTTOM: &str = "\\bottomrule\n";
const FOOT: &str = "\\end{tabular}\n";

/// A `tabular` with the lines of the package booktabs: first the row that the paper published, in
/// italics, then the means over `trials` trials, and a note on those that are refused.
pub fn table(summaries: &[Summary], trials: usize) -> String {
    let (strain, bias) = PUBLISHED_REDUCTION;
    let published = [
        r"\textit{Negi et al.\ (2025), real arm}".to_owned(),
        PUBLISHED_STRAIN.to_string(),
        PUBLISHED_BIAS_DEG.to_string(),
        strain.to_string(),
        bias.to_string(),
    ];
    let blank = std::iter::repeat_with(|| NONE.to_owned()).take(4);
    let mut rows = line(published.into_iter().chain(blank)) + "\\midrule\n";
    for Summary { label, strain_mae, bias_mae_deg, strain_reduction, bias_reduction, hole, workspace, .. } in summaries
    {
        rows += &line([
            escaped(label),
            scientific(*strain_mae),
            fixed(*bias_mae_deg, 4),
            fixed(*strain_reduction, 1),
            fixed(*bias_reduction, 1),
            fixed(hole.mean_mm, 3),
            fixed(hole.mean_deg, 4),
            fixed(workspace.mean_mm, 3),
            fixed(workspace.mean_deg, 4),
        ]);
    }
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "% touchcal {version}, experiment table1; number of trials: {trials}.\n{HEAD}{rows}{BOTTOM}{}{FOOT}",
        note(summaries)
    )
}

/// A row below the table: that means include results that must not be used, and how many; none
/// where there are no such results.
fn note(summaries: &[Summary]) -> String {
    let with_refused = summaries.iter().filter(|summary| summary.refused > 0);
    let counts: Vec<String> = with_refused
        .map(|Summary { label, refused, trials, .. }| format!("{}: {refused} of {trials}", escaped(label)))
        .collect();
    if counts.is_empty() {
        return String::new();
    }
    let words = format!("Means include trials whose result touchcal refuses (not usable): {}.", counts.join("; "));
    format!("\\multicolumn{{9}}{{p{{0.95\\linewidth}}}}{{\\footnotesize {words}}} \\\\\n")
}

fn line(cells: impl IntoIterator<Item = String>) -> String {
    cells.into_iter().collect::<Vec<String>>().join(" & ") + " \\\\\n"
}

fn fixed(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { NONE.to_owned() }
}

/// A number with two digits and a power of ten.
fn scientific(value: f64) -> String {
    let text = format!("{value:.1e}");
    match text.split_once('e') {
        Some((digits, exponent)) if value.is_finite() => format!("${digits}\\times 10^{{{exponent}}}$"),
        _ => NONE.to_owned(),
    }
}

/// Text in which no character is a command of LaTeX.
fn escaped(text: &str) -> String {
    let escape = |character: char| match character {
        '\\' => r"\textbackslash{}".to_owned(),
        '~' => r"\textasciitilde{}".to_owned(),
        '^' => r"\textasciicircum{}".to_owned(),
        '&' | '%' | '$' | '#' | '_' | '{' | '}' => format!("\\{character}"),
        _ => character.to_string(),
    };
    text.chars().map(escape).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::row::Tool;
    use super::*;

    const EXPECTED: &str = r"
\midrule
\textit{Negi et al.\ (2025), real arm} & 0.019 & 1.48 & 2.6 & 3.37 & -- & -- & -- & -- \\
\midrule
50 \% of a\_b \& c & $1.2\times 10^{-5}$ & 0.0012 & 4100.0 & 2000.5 & 0.012 & 0.0020 & 0.101 & 0.0300 \\
none & -- & -- & -- & -- & 0.012 & 0.0020 & 0.101 & 0.0300 \\
\bottomrule
\end{tabular}
";

    #[test]
    fn the_table_is_latex() {
        let tool = |mean_mm, mean_deg| Tool { mean_mm, mm_95: 9.0, mean_deg, deg_95: 9.0 };
        let row = |label, [strain_mae, bias_mae_deg, strain_reduction, bias_reduction]: [f64; 4]| Summary {
            approach: "exact_lm",
            label,
            trials: 3,
            strain_mae,
            bias_mae_deg,
            strain_reduction,
            bias_reduction,
            hole: tool(0.0123, 0.002),
            workspace: tool(0.1011, 0.03),
            not_refused: 1.0,
            refused: 0,
            seconds: 2.0,
        };
        let rows = [row("50 % of a_b & c", [1.2e-5, 0.0012, 4100.0, 2000.49]), row("none", [f64::NAN; 4])];
        let text = table(&rows, 3);
        assert!(text.contains("experiment table1; number of trials: 3.\n") && text.ends_with(EXPECTED), "{text}");
        let half = Summary { refused: 2, not_refused: 1.0 / 3.0, ..row("50 % of a_b & c", [0.1; 4]) };
        let note = table(&[half, row("all", [0.1; 4])], 3);
        let expected = "\\bottomrule\n\\multicolumn{9}{p{0.95\\linewidth}}{\\footnotesize Means include trials whose result \
                        touchcal refuses (not usable): 50 \\% of a\\_b \\& c: 2 of 3.} \\\\\n\\end{tabular}\n";
        assert!(note.ends_with(expected), "{note}");
        // As many cells in each row as the table has columns, two rows of heads.
        assert!(text.contains("{lrrrrrrrr}"));
        let cells: Vec<usize> =
            text.replace("\n &", " &").lines().map(|line| line.replace("\\&", "").matches(" & ").count()).collect();
        assert_eq!(cells.iter().filter(|cells| **cells == 8).count(), 4, "{text}");
    }

    #[test]
    fn no_character_is_a_command() {
        assert_eq!(escaped("a\\~^{}#$"), r"a\textbackslash{}\textasciitilde{}\textasciicircum{}\{\}\#\$");
    }
}

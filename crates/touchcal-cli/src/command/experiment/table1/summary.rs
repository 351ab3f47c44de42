//! Statistics of the approaches, beside those that the paper published, as JSON and for people.

use serde::Serialize;

use super::super::approach::Approach;
use super::super::row::{Row, Tool};
use crate::failure::Failure;
use crate::table::Table;

/// Results published in the paper: mean absolute errors of strain and biases (deg), and their
/// reduction factors.
pub const PUBLISHED_STRAIN: f64 = 0.019;
pub const PUBLISHED_BIAS_DEG: f64 = 1.48;
pub const PUBLISHED_REDUCTION: (f64, f64) = (2.6, 3.37);

/// A row of the table: means over the trials.
#[derive(Debug, Serialize)]
pub struct Summary {
    pub approach: &'static str,
    pub label: &'static str,
    pub trials: usize,
    pub strain_mae: f64,
    pub bias_mae_deg: f64,
    pub strain_reduction: f64,
    pub bias_reduction: f64,
    pub hole: Tool,
    pub workspace: Tool,
    /// Share of the other trials: usable or doubtful.
    pub not_refused: f64,
    /// Number of trials whose result must not be used; the means include them.
    pub refused: usize,
    pub seconds: f64,
}

impl Summary {
    /// The means of an approach's rows.
    pub fn of(approach: &Approach, rows: &[&Row]) -> Summary {
        let mean = |value: &dyn Fn(&Row) -> f64| rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64;
        let tool = |tool: fn(&Row) -> Tool| Tool {
            mean_mm: mean(&|row| tool(row).mean_mm),
            mm_95: mean(&|row| tool(row).mm_95),
            mean_deg: mean(&|row| tool(row).mean_deg),
            deg_95: mean(&|row| tool(row).deg_95),
        };
        let strain_mae = mean(&|row| row.strain_error);
        let bias_mae_deg = mean(&|row| row.bias_error_deg);
        Summary {
            approach: approach.name.key(),
            label: approach.label,
            trials: rows.len(),
            strain_mae,
            bias_mae_deg,
            strain_reduction: mean(&|row| row.strain_before) / strain_mae,
            bias_reduction: mean(&|row| row.bias_before_deg) / bias_mae_deg,
            hole: tool(|row| row.hole),
            workspace: tool(|row| row.workspace),
            refused: refused(rows),
            not_refused: mean(&|row| f64::from(u8::from(row.is_usable()))),
            seconds: mean(&|row| row.seconds),
        }
    }
}

/// Number of trials whose result must not be used.
pub fn refused(rows: &[&Row]) -> usize {
    rows.iter().filter(|row| !row.is_usable()).count()
}

#[derive(Serialize)]
struct Published {
    strain_mae: f64,
    bias_mae_deg: f64,
    strain_reduction: f64,
    bias_reduction: f64,
}

#[derive(Serialize)]
struct File<'a> {
    version: &'static str,
    published: Published,
    summary: &'a [Summary],
    rows: &'a [Row],
}

/// The file table1.json.
pub fn json(rows: &[Row], summary: &[Summary]) -> Result<String, Failure> {
    let published = Published {
        strain_mae: PUBLISHED_STRAIN,
        bias_mae_deg: PUBLISHED_BIAS_DEG,
        strain_reduction: PUBLISHED_REDUCTION.0,
        bias_reduction: PUBLISHED_REDUCTION.1,
    };
    let file = File { version: env!("CARGO_PKG_VERSION"), published, summary, rows };
    Ok(serde_json::to_string_pretty(&file)? + "\n")
}

/// The table for people.
pub fn table(summaries: &[Summary]) -> Table {
    let mut table = Table::new([
        "",
        "strain",
        "offset deg",
        "strain ×",
        "offset ×",
        "hole mm",
        "95 %",
        "deg",
        "other poses mm",
        "95 %",
        "deg",
        "95 %",
        "not refused",
        "s",
    ]);
    let blank = || "-".to_owned();
    let published = [
        "paper (published, real arm)".to_owned(),
        format!("{PUBLISHED_STRAIN}"),
        format!("{PUBLISHED_BIAS_DEG}"),
        format!("{:.1}", PUBLISHED_REDUCTION.0),
        format!("{:.1}", PUBLISHED_REDUCTION.1),
    ];
    table.row(published.into_iter().chain(std::iter::repeat_with(blank).take(9)));
    for summary in summaries {
        let Summary { hole, workspace, .. } = summary;
        table.row([
            summary.label.to_owned(),
            format!("{:.1e}", summary.strain_mae),
            format!("{:.4}", summary.bias_mae_deg),
            format!("{:.1}", summary.strain_reduction),
            format!("{:.1}", summary.bias_reduction),
            format!("{:.3}", hole.mean_mm),
            format!("{:.3}", hole.mm_95),
            format!("{:.4}", hole.mean_deg),
            format!("{:.3}", workspace.mean_mm),
            format!("{:.3}", workspace.mm_95),
            format!("{:.4}", workspace.mean_deg),
            format!("{:.4}", workspace.deg_95),
            format!("{:.0} %", 100.0 * summary.not_refused),
            format!("{:.2}", summary.seconds),
        ]);
    }
    table
}

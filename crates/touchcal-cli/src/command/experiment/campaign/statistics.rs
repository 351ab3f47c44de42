//! Statistics of a campaign's trials.

use serde::Serialize;
use touchcal::experiment::{CampaignSummary, LEVELS};

use crate::table::Table;

const MM: f64 = 1e-3;
/// Quantiles of errors: median and 95 %.
const SHARES: [f64; 2] = [0.5, 0.95];

/// What is written as campaign.json.
#[derive(Clone, Debug, Serialize)]
pub struct CampaignStatistics {
    /// Number of trials.
    pub trials: u64,
    /// Share of trials whose result is usable or doubtful.
    pub usable: f64,
    /// Share of true values within the intervals of 50, 90, 95 and 99 %.
    pub coverage: [f64; 4],
    /// Intervals in which `coverage` is by chance in 99 % of campaigns.
    pub coverage_bounds_99: [[f64; 2]; 4],
    /// NEES over the number of parameters.
    pub nees: f64,
    /// Interval in which `nees` is by chance in 99 % of campaigns.
    pub nees_bounds_99: [f64; 2],
    /// Root mean square of errors over their Cramér–Rao bounds.
    pub error_over_cramer_rao: f64,
    /// Median and 95 % quantile of the trials' mean errors, and their mean at the Cramér–Rao bound.
    pub offset_error_deg: [f64; 2],
    pub offset_cramer_rao_deg: f64,
    pub strain_error: [f64; 2],
    pub strain_cramer_rao: f64,
    /// Mean errors over the workspace; median and 95 % quantile of the trials.
    pub tool_error_mm: f64,
    pub tool_error_deg: f64,
    pub tool_error_mm_quantiles: [f64; 2],
    /// Time to simulate and calibrate a trial on one core (s).
    pub seconds_a_trial: f64,
}

impl CampaignStatistics {
    /// The statistics of `summary`, whose trials took `core_seconds` on one core (s).
    pub fn new(summary: &CampaignSummary, core_seconds: f64) -> CampaignStatistics {
        let (nees, nees_bounds_99) = summary.nees();
        let (distance, angle) = summary.tool();
        CampaignStatistics {
            trials: summary.trials,
            usable: summary.usable as f64 / summary.trials as f64,
            coverage: summary.coverage(),
            coverage_bounds_99: summary.coverage_bounds(),
            nees,
            nees_bounds_99,
            error_over_cramer_rao: summary.error_over_bound(),
            offset_error_deg: SHARES.map(|share| summary.offset_error(share).to_degrees()),
            offset_cramer_rao_deg: summary.offset_bound().to_degrees(),
            strain_error: SHARES.map(|share| summary.strain_error(share)),
            strain_cramer_rao: summary.strain_bound(),
            tool_error_mm: distance / MM,
            tool_error_deg: angle.to_degrees(),
            tool_error_mm_quantiles: SHARES.map(|share| summary.tool_distance(share) / MM),
            seconds_a_trial: core_seconds / summary.trials as f64,
        }
    }

    /// The table for people.
    pub fn table(&self) -> String {
        let mut table = Table::new(["", "measured", "expected"]);
        let mut row = |name: &str, measured: String, expected: String| table.row([name.to_owned(), measured, expected]);
        row("usable", format!("{:.1} %", 100.0 * self.usable), "100 %".to_owned());
        if self.usable == 0.0 {
            return format!("{} trials, none of which is usable\n{table}", self.trials);
        }
        for (k, level) in LEVELS.iter().enumerate() {
            let name = format!("true values within {:.0} % intervals", 100.0 * level);
            let [least, most] = self.coverage_bounds_99[k].map(|bound| 100.0 * bound);
            row(&name, format!("{:.1} %", 100.0 * self.coverage[k]), format!("{least:.1} to {most:.1} %"));
        }
        let [least, most] = self.nees_bounds_99;
        row("NEES per parameter", format!("{:.3}", self.nees), format!("{least:.3} to {most:.3}"));
        row("error over the Cramér-Rao bound", format!("{:.2}", self.error_over_cramer_rao), "1".to_owned());
        let bound = |bound: f64| format!("{bound:.2e} at the bound");
        row(
            "mean error of encoder offsets, deg, median (95 %)",
            quantiles(self.offset_error_deg),
            bound(self.offset_cramer_rao_deg),
        );
        row("mean error of link strains, median (95 %)", quantiles(self.strain_error), bound(self.strain_cramer_rao));
        row("mean tool error at 1000 other poses, mm", format!("{:.4}", self.tool_error_mm), String::new());
        row("mean tool error at 1000 other poses, deg", format!("{:.4}", self.tool_error_deg), String::new());
        row("core seconds per trial", format!("{:.2}", self.seconds_a_trial), String::new());
        format!("{} trials\n{table}", self.trials)
    }
}

/// Median and 95 % quantile as text.
pub fn quantiles([median, most]: [f64; 2]) -> String {
    format!("{median:.2e} ({most:.2e})")
}

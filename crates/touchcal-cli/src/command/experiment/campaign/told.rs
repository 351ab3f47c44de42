//! What a campaign comes to, as it is told.

use std::path::Path;

use serde::Serialize;
use touchcal::experiment::{CampaignSummary, LEVELS};
use touchcal::io::atomic;

use super::figure;
use crate::command::Failure;
use crate::output;
use crate::table::Table;

const MM: f64 = 1e-3;
/// Quantiles told of errors.
const SHARES: [f64; 2] = [0.5, 0.95];

/// What is written as campaign.json.
#[derive(Clone, Debug, Serialize)]
pub struct Told {
    pub trials: u64,
    pub converged: f64,
    /// Share of true values within the intervals of 50, 90, 95 and 99 %.
    pub coverage: [f64; 4],
    /// What chance leaves of it.
    pub coverage_bounds_99: [[f64; 2]; 4],
    /// Over the number of parameters.
    pub nees: f64,
    pub nees_bounds_99: [f64; 2],
    pub error_over_cramer_rao: f64,
    /// Median and 95 % of the trials' mean errors, and what they would be on average at the
    /// Cramér–Rao bound.
    pub offset_error_deg: [f64; 2],
    pub offset_cramer_rao_deg: f64,
    pub strain_error: [f64; 2],
    pub strain_cramer_rao: f64,
    /// Means over the workspace; median and 95 % of the trials.
    pub tool_error_mm: f64,
    pub tool_error_deg: f64,
    pub tool_error_mm_quantiles: [f64; 2],
    /// Simulated and calibrated, on one core.
    pub seconds_a_trial: f64,
}

impl Told {
    pub fn new(summary: &CampaignSummary, core_seconds: f64) -> Told {
        let (nees, nees_bounds_99) = summary.nees();
        let (distance, angle) = summary.tool();
        Told {
            trials: summary.trials,
            converged: summary.converged as f64 / summary.trials as f64,
            coverage: summary.coverage(),
            coverage_bounds_99: summary.coverage_bounds(),
            nees,
            nees_bounds_99,
            error_over_cramer_rao: summary.over_bound(),
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

    /// Writes campaign.json and campaign.svg.
    pub fn write(&self, folder: &Path) -> Result<(), Failure> {
        atomic::write(&folder.join("campaign.json"), (serde_json::to_string_pretty(self)? + "\n").as_bytes())?;
        let svg = figure::coverage(self).map_err(Failure::Setup)?;
        atomic::write(&folder.join("campaign.svg"), svg.as_bytes())?;
        Ok(())
    }

    /// Says what was written to `folder`.
    pub fn print(&self, folder: &Path, json: bool) -> Result<(), Failure> {
        let text = if json { serde_json::to_string_pretty(self)? + "\n" } else { self.text() };
        let written = format!("\nWritten   {}: campaign.json and campaign.svg\n", folder.display());
        output::print(&if json { text } else { text + &written })
    }

    fn text(&self) -> String {
        let mut table = Table::new(["", "found", "expected"]);
        let mut row = |what: &str, found: String, expected: String| table.row([what.to_owned(), found, expected]);
        row("converged", format!("{:.1} %", 100.0 * self.converged), "100 %".to_owned());
        if self.converged == 0.0 {
            return format!("{} trials, of which nothing else can be said\n{table}", self.trials);
        }
        for (k, level) in LEVELS.iter().enumerate() {
            let what = format!("true values within {:.0} % intervals", 100.0 * level);
            let [least, most] = self.coverage_bounds_99[k].map(|bound| 100.0 * bound);
            row(&what, format!("{:.1} %", 100.0 * self.coverage[k]), format!("{least:.1} to {most:.1} %"));
        }
        let [least, most] = self.nees_bounds_99;
        row("NEES a parameter", format!("{:.3}", self.nees), format!("{least:.3} to {most:.3}"));
        row("error over the Cramer-Rao bound", format!("{:.2}", self.error_over_cramer_rao), "1".to_owned());
        let bound = |bound: f64| format!("{bound:.2e} at the bound");
        row(
            "joint offsets' mean error, deg, median (95 %)",
            quantiles(self.offset_error_deg),
            bound(self.offset_cramer_rao_deg),
        );
        row("strains' mean error, median (95 %)", quantiles(self.strain_error), bound(self.strain_cramer_rao));
        row("tool at 1000 other poses, mm", format!("{:.4}", self.tool_error_mm), String::new());
        row("and deg", format!("{:.4}", self.tool_error_deg), String::new());
        row("seconds of one core a trial", format!("{:.2}", self.seconds_a_trial), String::new());
        format!("{} trials\n{table}", self.trials)
    }
}

/// Median and 95 %.
pub fn quantiles([median, most]: [f64; 2]) -> String {
    format!("{median:.2e} ({most:.2e})")
}

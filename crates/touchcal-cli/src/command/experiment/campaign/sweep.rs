//! Campaigns that differ in one setting, side by side.

use std::path::Path;

use serde::Serialize;
use touchcal::io::result_folder::{self, ResultFile, ResultKind};

use super::figure;
use super::statistics::{CampaignStatistics, quantiles};
use crate::args::{CampaignArgs, Vary};
use crate::failure::Failure;
use crate::output;
use crate::table::Table;

/// What is written as sweep.json.
#[derive(Serialize)]
struct Sweep<'a> {
    setting: &'a str,
    campaigns: Vec<SweepEntry<'a>>,
}

#[derive(Serialize)]
struct SweepEntry<'a> {
    value: f64,
    #[serde(flatten)]
    statistics: &'a CampaignStatistics,
}

const STATISTICS: &str = "sweep.json";
const FIGURE: &str = "sweep.svg";

/// Refuses to replace files in `folder` that touchcal did not write.
pub fn check(folder: &Path) -> Result<(), Failure> {
    Ok(result_folder::check(folder, ResultKind::Sweep, &[STATISTICS, FIGURE], &[])?)
}

/// Writes sweep.json and sweep.svg, and prints the statistics of each value.
pub fn output(args: &CampaignArgs, vary: &Vary, statistics: &[CampaignStatistics]) -> Result<(), Failure> {
    let campaigns =
        vary.values.iter().zip(statistics).map(|(&value, statistics)| SweepEntry { value, statistics }).collect();
    let json = serde_json::to_string_pretty(&Sweep { setting: &vary.setting, campaigns })? + "\n";
    let svg = figure::sweep(vary, statistics).map_err(Failure::Setup)?;
    let files = [ResultFile::new(STATISTICS, json.as_str()), ResultFile::new(FIGURE, svg)];
    result_folder::write(&args.out, ResultKind::Sweep, &files, &[])?;
    output::print(&if args.json { json } else { text(args, vary, statistics) })
}

fn text(args: &CampaignArgs, vary: &Vary, statistics: &[CampaignStatistics]) -> String {
    let mut table = Table::new([
        vary.setting.as_str(),
        "usable",
        "encoder offset error, deg (95 %)",
        "Cramér-Rao bound",
        "tool error, mm (95 %)",
        "mean, deg",
        "in 95 % intervals",
        "expected",
        "NEES",
        "error/bound",
        "s per trial",
    ]);
    for (value, each) in vary.values.iter().zip(statistics) {
        if each.usable == 0.0 {
            table.row([value.to_string(), "0.0 %".to_owned()]);
            continue;
        }
        let [least, most] = each.coverage_bounds_99[2].map(|bound| 100.0 * bound);
        table.row([
            value.to_string(),
            format!("{:.1} %", 100.0 * each.usable),
            quantiles(each.offset_error_deg),
            format!("{:.2e}", each.offset_cramer_rao_deg),
            quantiles(each.tool_error_mm_quantiles),
            format!("{:.2e}", each.tool_error_deg),
            format!("{:.1} %", 100.0 * each.coverage[2]),
            format!("{least:.1} to {most:.1}"),
            format!("{:.2}", each.nees),
            format!("{:.2}", each.error_over_cramer_rao),
            format!("{:.2}", each.seconds_a_trial),
        ]);
    }
    let trials = statistics.first().map_or(0, |each| each.trials);
    let out = args.out.display();
    format!(
        "{trials} trials each; errors are medians (95 % quantiles) over the trials, tool errors at 1000 other poses\n{table}\nWritten   {out}: sweep.json, sweep.svg, and a folder per value\n"
    )
}

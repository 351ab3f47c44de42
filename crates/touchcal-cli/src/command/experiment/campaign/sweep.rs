//! Campaigns that differ in one number, side by side.

use serde::Serialize;
use touchcal::io::atomic;

use super::figure;
use super::told::{Told, quantiles};
use crate::args::{CampaignArgs, Vary};
use crate::command::Failure;
use crate::output;
use crate::table::Table;

/// What is written as sweep.json.
#[derive(Serialize)]
struct Sweep<'a> {
    setting: &'a str,
    campaigns: Vec<One<'a>>,
}

#[derive(Serialize)]
struct One<'a> {
    value: f64,
    #[serde(flatten)]
    told: &'a Told,
}

/// Writes and says what came of each value.
pub fn tell(args: &CampaignArgs, vary: &Vary, told: &[Told]) -> Result<(), Failure> {
    let campaigns = vary.values.iter().zip(told).map(|(&value, told)| One { value, told }).collect();
    let json = serde_json::to_string_pretty(&Sweep { setting: &vary.setting, campaigns })? + "\n";
    atomic::write(&args.out.join("sweep.json"), json.as_bytes())?;
    let svg = figure::sweep(vary, told).map_err(Failure::Setup)?;
    atomic::write(&args.out.join("sweep.svg"), svg.as_bytes())?;
    output::print(&if args.json { json } else { text(args, vary, told) })
}

fn text(args: &CampaignArgs, vary: &Vary, told: &[Told]) -> String {
    let mut table = Table::new([
        vary.setting.as_str(),
        "converged",
        "offsets off by, deg (95 %)",
        "at the bound",
        "tool elsewhere, mm (95 %)",
        "deg, mean",
        "within 95 %",
        "by chance",
        "NEES",
        "error/bound",
        "s/trial",
    ]);
    for (value, told) in vary.values.iter().zip(told) {
        if told.converged == 0.0 {
            table.row([value.to_string(), "0.0 %".to_owned()]);
            continue;
        }
        let [least, most] = told.coverage_bounds_99[2].map(|bound| 100.0 * bound);
        table.row([
            value.to_string(),
            format!("{:.1} %", 100.0 * told.converged),
            quantiles(told.offset_error_deg),
            format!("{:.2e}", told.offset_cramer_rao_deg),
            quantiles(told.tool_error_mm_quantiles),
            format!("{:.2e}", told.tool_error_deg),
            format!("{:.1} %", 100.0 * told.coverage[2]),
            format!("{least:.1} to {most:.1}"),
            format!("{:.2}", told.nees),
            format!("{:.2}", told.error_over_cramer_rao),
            format!("{:.2}", told.seconds_a_trial),
        ]);
    }
    let trials = told.first().map_or(0, |told| told.trials);
    let out = args.out.display();
    format!(
        "{trials} trials each; errors are medians (95 %) of trials\n{table}\nWritten   {out}: sweep.json, sweep.svg, and a folder for each value\n"
    )
}

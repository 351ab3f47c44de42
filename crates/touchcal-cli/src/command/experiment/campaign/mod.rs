//! `touchcal experiment campaign`: one scenario, many seeds; whether uncertainties are true.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use touchcal::experiment::{CampaignRow, CampaignSummary, LEVELS, campaign_trial};
use touchcal::io::scenario_file::{self, ScenarioFile};
use touchcal::io::{atomic, campaign_parquet};

use crate::args::CampaignArgs;
use crate::command::{Failure, Outcome, simulate};
use crate::output;
use crate::progress::{Counter, interrupted};
use crate::table::Table;

/// Trials of a part: what is computed, written and kept together.
const PART: u64 = 50;
const MM: f64 = 1e-3;

/// Computes the parts that are not there yet, of this shard; the summary, once all are there.
pub fn run(args: &CampaignArgs) -> Result<Outcome, Failure> {
    let campaign = Campaign::new(args)?;
    let parts = 0..args.trials.div_ceil(PART);
    let mine = |part: &u64| part % args.shard.of == args.shard.number - 1;
    let counter =
        Counter::new("Trials", 0, parts.clone().filter(mine).map(|part| campaign.trials(part).count() as u64).sum());
    let mut summary = CampaignSummary::default();
    let (mut computed, mut missing) = (0, 0);
    for part in parts {
        let rows = match campaign.kept(part) {
            Some(rows) => Some(rows),
            None if mine(&part) => {
                computed += 1;
                Some(campaign.compute(part, &counter)?)
            }
            None => None,
        };
        match rows {
            Some(rows) => rows.iter().for_each(|row| summary.add(row)),
            None => missing += 1,
        }
    }
    if missing > 0 {
        output::print(&format!(
            "{computed} parts computed, {missing} of other shards are not in {}\nNext      copy them there, and run the same without --shard\n",
            campaign.folder.display()
        ))?;
        return Ok(Outcome::Done);
    }
    let told = Told::new(&summary);
    let json = serde_json::to_string_pretty(&told)? + "\n";
    atomic::write(&args.out.join("campaign.json"), json.as_bytes())?;
    output::print(&if args.json { json } else { told.text(args) })?;
    Ok(Outcome::Done)
}

struct Campaign<'a> {
    args: &'a CampaignArgs,
    file: ScenarioFile,
    /// All that rows depend on.
    settings: String,
    folder: PathBuf,
}

impl<'a> Campaign<'a> {
    fn new(args: &'a CampaignArgs) -> Result<Self, Failure> {
        let file = simulate::scenario(&args.source)?;
        let scenario: String = scenario_file::scenario_text(&file).into_iter().map(|file| file.text).collect();
        let settings = format!("touchcal {}, first seed {}\n{scenario}", env!("CARGO_PKG_VERSION"), args.seed);
        Ok(Campaign { args, file, settings, folder: args.out.join("parts") })
    }

    fn trials(&self, part: u64) -> std::ops::Range<u64> {
        part * PART..((part + 1) * PART).min(self.args.trials)
    }

    fn path(&self, part: u64) -> PathBuf {
        self.folder.join(format!("part-{part:06}.parquet"))
    }

    /// A part that is there, whole and of these settings; any other is no part of this campaign.
    fn kept(&self, part: u64) -> Option<Vec<CampaignRow>> {
        let path: &Path = &self.path(part);
        let (rows, settings) = path.exists().then(|| campaign_parquet::read_file(path).ok()).flatten()?;
        let whole = rows.iter().map(|row| row.trial).eq(self.trials(part));
        (whole && settings == self.settings).then_some(rows)
    }

    fn compute(&self, part: u64, counter: &Counter) -> Result<Vec<CampaignRow>, Failure> {
        let trial = |trial: u64| {
            if interrupted() {
                return Err(Failure::ExperimentInterrupted);
            }
            let row = campaign_trial(&self.file.scenario, self.args.seed, trial)?;
            counter.one_more();
            Ok(row)
        };
        let trials: Vec<u64> = self.trials(part).collect();
        let rows: Vec<CampaignRow> = trials.into_par_iter().map(trial).collect::<Result<_, Failure>>()?;
        if interrupted() {
            return Err(Failure::ExperimentInterrupted);
        }
        atomic::write(&self.path(part), &campaign_parquet::to_bytes(&rows, &self.settings)?)?;
        Ok(rows)
    }
}

/// What is told, and written as campaign.json.
#[derive(Serialize)]
struct Told {
    trials: u64,
    converged: f64,
    /// Share of true values within the intervals of 50, 90, 95 and 99 %.
    coverage: [f64; 4],
    /// Over the number of parameters.
    nees: f64,
    nees_bounds_99: [f64; 2],
    error_over_cramer_rao: f64,
    /// Median and 95 % of the trials' mean errors.
    offset_error_deg: [f64; 2],
    strain_error: [f64; 2],
    /// Means over the workspace.
    tool_error_mm: f64,
    tool_error_deg: f64,
}

impl Told {
    fn new(summary: &CampaignSummary) -> Told {
        let (nees, nees_bounds_99) = summary.nees();
        let (distance, angle) = summary.tool();
        Told {
            trials: summary.trials,
            converged: summary.converged as f64 / summary.trials as f64,
            coverage: summary.coverage(),
            nees,
            nees_bounds_99,
            error_over_cramer_rao: summary.over_bound(),
            offset_error_deg: [0.5, 0.95].map(|share| summary.offset_error(share).to_degrees()),
            strain_error: [0.5, 0.95].map(|share| summary.strain_error(share)),
            tool_error_mm: distance / MM,
            tool_error_deg: angle.to_degrees(),
        }
    }

    fn text(&self, args: &CampaignArgs) -> String {
        let mut table = Table::new(["", "found", "expected"]);
        let mut row = |what: &str, found: String, expected: String| table.row([what.to_owned(), found, expected]);
        row("converged", format!("{:.1} %", 100.0 * self.converged), "100 %".to_owned());
        for (level, coverage) in LEVELS.iter().zip(self.coverage) {
            let what = format!("true values within {:.0} % intervals", 100.0 * level);
            row(&what, format!("{:.1} %", 100.0 * coverage), format!("{:.0} %", 100.0 * level));
        }
        let [least, most] = self.nees_bounds_99;
        row("NEES a parameter", format!("{:.3}", self.nees), format!("{least:.3} to {most:.3}"));
        row("error over the Cramer-Rao bound", format!("{:.2}", self.error_over_cramer_rao), "1".to_owned());
        let quantiles = |[median, most]: [f64; 2]| format!("{median:.2e} ({most:.2e})");
        row("joint offsets' mean error, deg, median (95 %)", quantiles(self.offset_error_deg), String::new());
        row("strains' mean error, median (95 %)", quantiles(self.strain_error), String::new());
        row("tool at 1000 other poses, mm", format!("{:.4}", self.tool_error_mm), String::new());
        row("and deg", format!("{:.4}", self.tool_error_deg), String::new());
        let written = format!("\nWritten   {0}/campaign.json, and a row a trial in {0}/parts\n", args.out.display());
        format!("{} trials\n{table}{written}", self.trials)
    }
}

//! `touchcal experiment falsified`: calibrations of problems with false declarations, and whether
//! their answers are honest.

mod figure;
mod statistics;
mod trials;

use touchcal::experiment::falsified::{FalsifiedKind, FalsifiedRow, has_recorded};
use touchcal::io::{atomic, falsified_parquet};

use super::threads;
use crate::args::FalsifiedArgs;
use crate::failure::{Failure, Outcome};
use crate::output;
use statistics::KindStatistics;

/// Computes the missing trials, writes all of them and their statistics, and prints these.
pub fn run(args: &FalsifiedArgs) -> Result<Outcome, Failure> {
    threads::set(args.threads)?;
    let is_wanted = |kind: &FalsifiedKind| args.kind.is_empty() || args.kind.iter().any(|name| name == kind.name);
    let kinds: Vec<FalsifiedKind> = FalsifiedKind::ALL.into_iter().filter(is_wanted).collect();
    let is_tried = |kind: &FalsifiedKind| args.logs.is_empty() || has_recorded(kind);
    let (kinds, not_recorded): (Vec<FalsifiedKind>, Vec<FalsifiedKind>) = kinds.into_iter().partition(is_tried);
    if let (Some(kind), false) = (not_recorded.first(), args.kind.is_empty()) {
        return Err(Failure::Setup(format!("--kind {} needs a simulation, without --logs", kind.name)));
    }
    let rows = trials::run(args, &kinds)?;
    let statistics: Vec<KindStatistics> = kinds.iter().map(|kind| KindStatistics::new(kind, &rows)).collect();
    write(args, &rows, &statistics)
}

fn write(args: &FalsifiedArgs, rows: &[FalsifiedRow], statistics: &[KindStatistics]) -> Result<Outcome, Failure> {
    falsified_parquet::write_file(&args.out.join("falsified.parquet"), rows)?;
    let json = serde_json::to_string_pretty(statistics)? + "\n";
    atomic::write(&args.out.join("falsified.json"), json.as_bytes())?;
    let svg = figure::svg(statistics).map_err(Failure::Setup)?;
    atomic::write(&args.out.join("falsified.svg"), svg.as_bytes())?;
    let files = "falsified.parquet, falsified.json, falsified.svg and rows/";
    let text = format!("{}Written   {}: {files}\n", statistics::table(statistics), args.out.display());
    output::print(if args.json { &json } else { &text })?;
    Ok(Outcome::Done)
}

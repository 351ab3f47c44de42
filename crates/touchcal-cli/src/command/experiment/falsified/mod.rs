//! `touchcal experiment falsified`: calibrations of problems with false declarations, and whether
//! their answers are honest.

mod figure;
mod statistics;
mod trials;

use touchcal::experiment::falsified::{FalsifiedKind, FalsifiedRow, has_recorded};
use touchcal::io::result_folder::{self, ResultFile, ResultKind};
use touchcal::io::{atomic, falsified_parquet};

use super::{saved, threads};
use crate::args::FalsifiedArgs;
use crate::failure::{Failure, Outcome};
use crate::output;
use statistics::KindStatistics;

const ROWS: &str = "falsified.parquet";
const STATISTICS: &str = "falsified.json";
const FIGURE: &str = "falsified.svg";

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
    result_folder::check(&args.out, ResultKind::Falsified, &[ROWS, STATISTICS, FIGURE], &[])?;
    atomic::remove_left_over(&args.out.join(saved::ROWS));
    let rows = trials::run(args, &kinds)?;
    let statistics: Vec<KindStatistics> = kinds.iter().map(|kind| KindStatistics::new(kind, &rows)).collect();
    write(args, &rows, &statistics)
}

fn write(args: &FalsifiedArgs, rows: &[FalsifiedRow], statistics: &[KindStatistics]) -> Result<Outcome, Failure> {
    let json = serde_json::to_string_pretty(statistics)? + "\n";
    let svg = figure::figure(statistics).map_err(Failure::Setup)?;
    let results = [
        ResultFile::new(ROWS, falsified_parquet::to_bytes(rows)?),
        ResultFile::new(STATISTICS, json.as_str()),
        ResultFile::new(FIGURE, svg),
    ];
    result_folder::write(&args.out, ResultKind::Falsified, &results, &[])?;
    let files = "falsified.parquet, falsified.json, falsified.svg and rows/";
    let text = format!("{}Written   {}: {files}\n", statistics::table(statistics), args.out.display());
    output::print(if args.json { &json } else { &text })?;
    Ok(Outcome::Done)
}

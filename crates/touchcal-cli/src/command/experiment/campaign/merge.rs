//! `touchcal experiment merge`: the parts of several folders as one campaign.

use std::path::{Path, PathBuf};

use touchcal::experiment::CampaignSummary;
use touchcal::io::campaign_folder::{PART, PARTS};
use touchcal::io::campaign_parquet::{self, Part};

use super::files;
use super::statistics::CampaignStatistics;
use crate::args::MergeArgs;
use crate::failure::{Failure, Outcome};
use crate::output;

/// Checks all parts before anything is written. Rows are read part by part.
pub fn run(args: &MergeArgs) -> Result<Outcome, Failure> {
    files::check(&args.out)?;
    let (settings, parts) = find_parts(&args.folders)?;
    let (parts, duplicates) = without_duplicates(parts)?;
    check_gaps(&parts, &args.folders)?;

    let rows = || parts.iter().map(|part| campaign_parquet::read_file(&part.path).map(|part| part.rows));
    let mut summary = CampaignSummary::default();
    for rows in rows() {
        rows?.iter().for_each(|row| summary.add(row));
    }
    let core_seconds = parts.iter().map(|part| part.core_seconds).sum();
    let statistics = CampaignStatistics::new(&summary, core_seconds);
    if args.rows {
        let header = Part { settings, trials: summary.trials, core_seconds, rows: Vec::new() };
        campaign_parquet::write_file(&args.out.join("rows.parquet"), &header, rows())?;
    }
    files::write(&statistics, &args.out)?;
    if !args.json {
        output::print(&duplicates)?;
    }
    files::print(&statistics, &args.out, args.json)?;
    Ok(Outcome::Done)
}

/// A part in a file; its rows stay there.
struct PartFile {
    path: PathBuf,
    /// Its first trial.
    first: u64,
    /// How many it has.
    count: u64,
    /// Trials of the campaign that it was computed for.
    trials: u64,
    core_seconds: f64,
}

impl PartFile {
    fn end(&self) -> u64 {
        self.first + self.count
    }
}

/// All parts in the order of their trials, of equal first trials the longest first, and the
/// settings that they share.
fn find_parts(folders: &[PathBuf]) -> Result<(String, Vec<PartFile>), Failure> {
    let mut shared: Option<(String, PathBuf)> = None;
    let mut parts = Vec::new();
    for folder in folders {
        for path in paths(&folder.join(PARTS))? {
            let part = campaign_parquet::read_file(&path)?;
            let (count, first) = (part.rows.len() as u64, part.rows.first().map_or(1, |row| row.trial));
            if first % PART != 0 || count > PART || !part.rows.iter().map(|row| row.trial).eq(first..first + count) {
                let message = format!("{}: expected trials of one part, found others", path.display());
                return Err(Failure::Merge(message));
            }
            parts.push(PartFile {
                path: path.clone(),
                first,
                count,
                trials: part.trials,
                core_seconds: part.core_seconds,
            });
            match &shared {
                None => shared = Some((part.settings, path)),
                Some((settings, _)) if *settings == part.settings => {}
                Some((settings, of)) => {
                    let (expected, other) = difference(settings, &part.settings);
                    let (path, of) = (path.display(), of.display());
                    return Err(Failure::Merge(format!("{path}: expected {expected:?} as in {of}, found {other:?}")));
                }
            }
        }
    }
    parts.sort_by_key(|part| (part.first, std::cmp::Reverse(part.count)));
    Ok((shared.map(|(settings, _)| settings).unwrap_or_default(), parts))
}

/// The part files of a folder.
fn paths(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let unread = |source| Failure::Merge(format!("{}: {source}", folder.display()));
    let entries = std::fs::read_dir(folder).map_err(unread)?.collect::<Result<Vec<_>, _>>().map_err(unread)?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "parquet"));
    paths.sort();
    if paths.is_empty() {
        return Err(Failure::Merge(format!("{}: expected parts of a campaign, found none", folder.display())));
    }
    Ok(paths)
}

/// The first line in which settings differ.
fn difference<'a>(one: &'a str, other: &'a str) -> (&'a str, &'a str) {
    let mut lines = one.lines().zip(other.lines());
    lines.find(|(one, other)| one != other).unwrap_or(("the same scenario", "a longer or shorter one"))
}

/// Parts of which no trial is there twice, and in words which were. Trials that are not the same to
/// the last bit are an error.
fn without_duplicates(parts: Vec<PartFile>) -> Result<(Vec<PartFile>, String), Failure> {
    let mut unique: Vec<PartFile> = Vec::new();
    let mut notes = String::new();
    for part in parts {
        let Some(before) = unique.last().filter(|before| before.first == part.first) else {
            unique.push(part);
            continue;
        };
        let (before_path, path) = (before.path.display(), part.path.display());
        let (one, other) = (campaign_parquet::read_file(&before.path)?, campaign_parquet::read_file(&part.path)?);
        let mut pairs = one.rows.iter().zip(&other.rows);
        if let Some((row, _)) = pairs.find(|(one, other)| !campaign_parquet::identical(one, other)) {
            let message = format!("trial {} of {path} is not that of {before_path}", row.trial);
            return Err(Failure::Merge(message));
        }
        let last = part.end() - 1;
        notes += &format!(
            "Trials {} to {last} are identical in two files and counted once: {before_path}, {path}\n",
            part.first
        );
    }
    Ok((unique, notes))
}

/// Trials that should be there and are not are an error.
fn check_gaps(parts: &[PartFile], folders: &[PathBuf]) -> Result<(), Failure> {
    let trials = parts.iter().map(|part| part.trials.max(part.end())).max().unwrap_or(0);
    let ends = parts.iter().map(PartFile::end);
    let begins = parts.iter().map(|part| part.first).chain([trials]);
    let gaps = std::iter::once(0).chain(ends).zip(begins).filter(|(end, begin)| end < begin);
    let gaps: Vec<String> = gaps.map(|(end, begin)| format!("{end} to {}", begin - 1)).collect();
    if gaps.is_empty() {
        return Ok(());
    }
    let folders: Vec<String> = folders.iter().map(|folder| folder.display().to_string()).collect();
    let (gaps, folders) = (gaps.join(", "), folders.join(", "));
    Err(Failure::Merge(format!("of trials 0 to {} these are in none of {folders}: {gaps}", trials - 1)))
}

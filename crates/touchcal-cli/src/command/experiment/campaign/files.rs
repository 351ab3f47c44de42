//! Files and output of a campaign.

use std::path::Path;

use touchcal::io::result_folder::{self, ResultFile, ResultKind};

use super::figure;
use super::statistics::CampaignStatistics;
use crate::failure::Failure;
use crate::output;

const STATISTICS: &str = "campaign.json";
const FIGURE: &str = "campaign.svg";

/// Refuses to replace files in `folder` that touchcal did not write.
pub fn check(folder: &Path) -> Result<(), Failure> {
    Ok(result_folder::check(folder, ResultKind::Campaign, &[STATISTICS, FIGURE], &[])?)
}

/// Writes campaign.json and campaign.svg into `folder`.
pub fn write(statistics: &CampaignStatistics, folder: &Path) -> Result<(), Failure> {
    let svg = figure::coverage(statistics).map_err(Failure::Setup)?;
    let files = [ResultFile::new(STATISTICS, json(statistics)?), ResultFile::new(FIGURE, svg)];
    Ok(result_folder::write(folder, ResultKind::Campaign, &files, &[])?)
}

/// Prints the statistics: as JSON, or as a table with the files written to `folder`.
pub fn print(statistics: &CampaignStatistics, folder: &Path, as_json: bool) -> Result<(), Failure> {
    if as_json {
        return output::print(&json(statistics)?);
    }
    let files = format!("\nWritten   {}: campaign.json and campaign.svg\n", folder.display());
    output::print(&(statistics.table() + &files))
}

fn json(statistics: &CampaignStatistics) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(statistics)? + "\n")
}

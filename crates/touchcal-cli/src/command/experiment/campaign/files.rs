//! Files and output of a campaign.

use std::path::Path;

use touchcal::io::atomic;

use super::figure;
use super::statistics::CampaignStatistics;
use crate::failure::Failure;
use crate::output;

/// Writes campaign.json and campaign.svg into `folder`.
pub fn write(statistics: &CampaignStatistics, folder: &Path) -> Result<(), Failure> {
    atomic::write(&folder.join("campaign.json"), json(statistics)?.as_bytes())?;
    let svg = figure::coverage(statistics).map_err(Failure::Setup)?;
    atomic::write(&folder.join("campaign.svg"), svg.as_bytes())?;
    Ok(())
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

//! `touchcal experiment campaign`: many trials of one scenario, or of several values of one of its
//! settings; compares errors with their standard deviations.

mod figure;
mod files;
pub mod merge;
mod parts;
mod statistics;
mod sweep;

use touchcal::io::campaign_folder::PART;
use touchcal::io::scenario_file::{self, ScenarioFile};

use super::threads;
use crate::args::CampaignArgs;
use crate::command::simulate;
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::progress::Counter;
use parts::{Campaign, PartsSummary};
use statistics::CampaignStatistics;

/// Computes the missing parts of this shard; once all parts are there, writes and prints the
/// statistics.
pub fn run(args: &CampaignArgs) -> Result<Outcome, Failure> {
    threads::set(args.threads)?;
    let campaigns = campaigns(args, &simulate::scenario(&args.source)?)?;
    let parts = args.trials.div_ceil(PART);
    let is_own = |campaign: usize, part: u64| (campaign as u64 * parts + part) % args.shard.of == args.shard.number - 1;
    let counter = Counter::new("Trials", 0, campaigns.len() as u64 * args.trials);
    let totals = campaigns.iter().enumerate().map(|(k, campaign)| campaign.run(|part| is_own(k, part), &counter));
    let totals: Vec<PartsSummary> = totals.collect::<Result<_, Failure>>()?;
    drop(counter);
    let missing: u64 = totals.iter().map(|total| total.missing).sum();
    if missing > 0 {
        let computed: u64 = totals.iter().map(|total| total.computed).sum();
        let folders = if args.vary.is_some() { "the folders of " } else { "" };
        output::print(&format!(
            "{computed} parts computed, {missing} of other shards are not in {folders}{}\n\
             Next      copy them there, and run the same without --shard; or touchcal experiment merge\n",
            args.out.display()
        ))?;
        return Ok(Outcome::Done);
    }
    let statistics: Vec<CampaignStatistics> =
        totals.iter().map(|total| CampaignStatistics::new(&total.summary, total.core_seconds)).collect();
    for (campaign, statistics) in campaigns.iter().zip(&statistics) {
        campaign.check()?;
        files::write(statistics, campaign.folder())?;
        campaign.remove_left_over();
    }
    match &args.vary {
        Some(vary) => sweep::output(args, vary, &statistics)?,
        None => statistics.iter().try_for_each(|statistics| files::print(statistics, &args.out, args.json))?,
    }
    Ok(Outcome::Done)
}

/// One campaign, or one for each value of the varied setting.
fn campaigns(args: &CampaignArgs, file: &ScenarioFile) -> Result<Vec<Campaign>, Failure> {
    let Some(vary) = &args.vary else {
        files::check(&args.out)?;
        return Ok(vec![Campaign::new(&scenario_file::scenario_text(file), args.out.clone(), args)?]);
    };
    sweep::check(&args.out)?;
    let campaign = |value: &f64| {
        let folder = args.out.join(format!("{}={value}", vary.setting));
        files::check(&folder)?;
        Campaign::new(&scenario_file::varied_text(file, &vary.setting, *value)?, folder, args)
    };
    vary.values.iter().map(campaign).collect()
}

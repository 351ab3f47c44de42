//! `touchcal experiment campaign`: one scenario, many seeds; whether uncertainties are true. And
//! the same for several values of one of its numbers.

mod figure;
mod kept;
pub mod merge;
mod sweep;
mod told;

use touchcal::io::campaign_folder::PART;
use touchcal::io::scenario_file::{self, ScenarioFile};

use crate::args::CampaignArgs;
use crate::command::{Failure, Outcome, simulate};
use crate::output;
use crate::progress::Counter;
use kept::{Campaign, Found};
use told::Told;

/// Computes the parts that are not there yet, of this shard; the summaries, once all are there.
pub fn run(args: &CampaignArgs) -> Result<Outcome, Failure> {
    if let Some(threads) = args.threads {
        let begun = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        begun.map_err(|error| Failure::Setup(format!("{threads} threads: {error}")))?;
    }
    let campaigns = campaigns(args, &simulate::scenario(&args.source)?)?;
    let parts = args.trials.div_ceil(PART);
    let mine = |campaign: usize, part: u64| (campaign as u64 * parts + part) % args.shard.of == args.shard.number - 1;
    let counter = Counter::new("Trials", 0, campaigns.len() as u64 * args.trials);
    let found = campaigns.iter().enumerate().map(|(k, campaign)| campaign.run(|part| mine(k, part), &counter));
    let found: Vec<Found> = found.collect::<Result<_, Failure>>()?;
    drop(counter);
    let missing: u64 = found.iter().map(|found| found.missing).sum();
    if missing > 0 {
        let computed: u64 = found.iter().map(|found| found.computed).sum();
        let folders = if args.vary.is_some() { "the folders of " } else { "" };
        output::print(&format!(
            "{computed} parts computed, {missing} of other shards are not in {folders}{}\n\
             Next      copy them there, and run the same without --shard; or touchcal experiment merge\n",
            args.out.display()
        ))?;
        return Ok(Outcome::Done);
    }
    let told: Vec<Told> = found.iter().map(|found| Told::new(&found.summary, found.core_seconds)).collect();
    for (campaign, told) in campaigns.iter().zip(&told) {
        told.write(campaign.folder())?;
    }
    match (&args.vary, told.as_slice()) {
        (Some(vary), _) => sweep::tell(args, vary, &told)?,
        (None, told) => told.iter().try_for_each(|told| told.print(&args.out, args.json))?,
    }
    Ok(Outcome::Done)
}

/// The scenario as it is, or once for each value.
fn campaigns(args: &CampaignArgs, file: &ScenarioFile) -> Result<Vec<Campaign>, Failure> {
    let Some(vary) = &args.vary else {
        return Ok(vec![Campaign::new(&scenario_file::scenario_text(file), args.out.clone(), args)?]);
    };
    let campaign = |value: &f64| {
        let files = scenario_file::varied_text(file, &vary.setting, *value)?;
        Campaign::new(&files, args.out.join(format!("{}={value}", vary.setting)), args)
    };
    vary.values.iter().map(campaign).collect()
}

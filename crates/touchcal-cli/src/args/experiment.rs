//! Arguments of `experiment`.

use std::path::PathBuf;

#[cfg(feature = "parquet")]
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Subcommand, ValueEnum};
#[cfg(feature = "parquet")]
use touchcal::experiment::falsified::FalsifiedKind;

#[cfg(feature = "parquet")]
use super::help::{ESTIMATION, MACHINE, SCENARIO};
use super::help::{OUTPUT, TRIALS, examples};
#[cfg(feature = "parquet")]
use super::number::count;
use super::number::positive;
#[cfg(feature = "parquet")]
use super::simulation::ScenarioSource;

/// Heading of options on contact manifolds.
const MANIFOLDS: &str = "Contact manifolds";
/// Heading of options on the methods that are compared.
const METHODS: &str = "Methods";

/// The experiments.
#[derive(Debug, Subcommand)]
pub enum ExperimentArgs {
    /// The paper from its beginning: contact poses of an arm without errors, their manifold, a
    /// network, and its table
    Paper(PaperArgs),
    /// The paper's table: learned, nearest and exact contact manifolds, by gradient descent and
    /// Levenberg-Marquardt
    Table1(Table1Args),
    /// Simulate and calibrate a scenario many times; compare errors with standard deviations
    #[cfg(feature = "parquet")]
    Campaign(CampaignArgs),
    /// Merge parts of a campaign computed in several places; refuse gaps, drop duplicates
    #[cfg(feature = "parquet")]
    Merge(MergeArgs),
    /// Calibrate problems whose declarations are false; say whether the answers are honest
    #[cfg(feature = "parquet")]
    Falsified(FalsifiedArgs),
}

/// Arguments of `experiment falsified`.
#[cfg(feature = "parquet")]
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    (
        "All kinds of false declarations, four trials of each",
        "touchcal experiment falsified --out falsified",
    ),
    (
        "One kind",
        "touchcal experiment falsified --kind edges_worn_0.2mm --out worn",
    ),
]))]
pub struct FalsifiedArgs {
    /// Folder to write falsified.parquet, falsified.json, falsified.svg and rows/ into; trials
    /// found there are not computed again
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub out: PathBuf,
    /// Only this kind (may be repeated)
    #[arg(long, value_name = "NAME", value_parser = falsified_kind(), help_heading = TRIALS)]
    pub kind: Vec<String>,
    /// Recorded trials of the paper's peg instead of simulated ones: subfolders of DIR with
    /// contact.csv and truth.json (may be repeated)
    #[arg(long, value_name = "DIR", conflicts_with = "contacts", help_heading = TRIALS)]
    pub logs: Vec<PathBuf>,
    /// Trials of each kind and excitation, or recorded trial
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=100_000), help_heading = TRIALS)]
    pub trials: u64,
    /// Seed of the first trial of each kind; later trials use the following numbers
    #[arg(long, default_value_t = 1, help_heading = TRIALS)]
    pub seed: u64,
    /// Estimate what contacts contradict, as `calibrate --free-suspects` does
    #[arg(long, help_heading = ESTIMATION)]
    pub free_suspects: bool,
    /// Contacts of the peg in each trial; a hundredth of that with each socket
    #[arg(long, value_name = "N", default_value_t = 3000, value_parser = count(20, 1_000_000), help_heading = TRIALS)]
    pub contacts: usize,
    /// Threads; as many as cores if not given; results do not depend on it
    #[arg(long, value_name = "N", value_parser = count(1, 1024), help_heading = MACHINE)]
    pub threads: Option<usize>,
    /// Print JSON instead of a table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Names of the battery's kinds, with what is false.
#[cfg(feature = "parquet")]
fn falsified_kind() -> PossibleValuesParser {
    let named = |kind: FalsifiedKind| PossibleValue::new(kind.name).help(kind.description);
    PossibleValuesParser::new(FalsifiedKind::ALL.map(named))
}

/// Arguments of `experiment campaign`.
#[cfg(feature = "parquet")]
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    (
        "Are the standard deviations those of the errors?",
        "touchcal experiment campaign --preset workcell --trials 200 --out cell",
    ),
    (
        "How many contacts are enough?",
        "touchcal experiment campaign --preset paper --trials 100 \\\n--vary contacts=300,1000,3000 --out contacts",
    ),
    (
        "The first of four machines",
        "touchcal experiment campaign scenario.toml --shard 1/4 --out first",
    ),
]))]
pub struct CampaignArgs {
    /// The scenario.
    #[command(flatten)]
    pub source: ScenarioSource,
    /// Folder to write campaign.json, campaign.svg and parts/ into; parts found there are not
    /// computed again
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub out: PathBuf,
    /// Trials
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u64).range(1..=100_000_000), help_heading = TRIALS)]
    pub trials: u64,
    /// Seed of the first trial; later trials use the following numbers
    #[arg(long, default_value_t = 1, help_heading = TRIALS)]
    pub seed: u64,
    /// Run the campaign for several values of one setting, named as in scenario.toml:
    /// contacts=300,1000,3000
    #[arg(long, value_name = "SETTING=A,B,…", help_heading = SCENARIO)]
    pub vary: Option<Vary>,
    /// Compute only the i-th of n equal shares of the parts
    #[arg(long, value_name = "I/N", default_value = "1/1", help_heading = MACHINE)]
    pub shard: Shard,
    /// Threads; as many as cores if not given; results do not depend on it
    #[arg(long, value_name = "N", value_parser = count(1, 1024), help_heading = MACHINE)]
    pub threads: Option<usize>,
    /// Print JSON instead of a table
    #[arg(long, help_heading = OUTPUT)]
    pub json: bool,
}

/// Arguments of `experiment merge`.
#[cfg(feature = "parquet")]
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("Parts of two machines", "touchcal experiment merge first second --out merged"),
]))]
pub struct MergeArgs {
    /// Folders that `experiment campaign` wrote, each with parts/
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Folder to write campaign.json and campaign.svg into
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Also write rows.parquet with the rows of all trials
    #[arg(long)]
    pub rows: bool,
    /// Print JSON instead of a table
    #[arg(long)]
    pub json: bool,
}

/// Values of one setting of a scenario.
#[cfg(feature = "parquet")]
#[derive(Clone, Debug)]
pub struct Vary {
    /// Its name.
    pub setting: String,
    /// Its values, one campaign each.
    pub values: Vec<f64>,
}

#[cfg(feature = "parquet")]
impl std::str::FromStr for Vary {
    type Err = String;

    fn from_str(text: &str) -> Result<Vary, String> {
        let number = |text: &str| text.trim().parse().ok().filter(|value: &f64| value.is_finite());
        let values = |text: &str| text.split(',').map(number).collect::<Option<Vec<f64>>>();
        match text.split_once('=').map(|(setting, text)| (setting.trim(), values(text))) {
            Some((setting, Some(values))) if !setting.is_empty() => Ok(Vary { setting: setting.to_owned(), values }),
            _ => Err("expected a setting's name and numbers, as in contacts=300,1000,3000".to_owned()),
        }
    }
}

/// A share of a campaign's parts.
#[cfg(feature = "parquet")]
#[derive(Clone, Copy, Debug)]
pub struct Shard {
    /// From 1 to `of`.
    pub number: u64,
    /// Number of shares.
    pub of: u64,
}

#[cfg(feature = "parquet")]
impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Shard, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match numbers {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Shard { number, of }),
            _ => Err("expected i/n with i from 1 to n".to_owned()),
        }
    }
}

/// Arguments of `experiment table1`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("The exact gap alone", "touchcal experiment table1 --trials 5 --only exact_lm --out exact"),
    (
        "All methods",
        "touchcal experiment table1 --manifold hole.safetensors \\\n--weights net/weights.safetensors --out table1",
    ),
]))]
pub struct Table1Args {
    /// Folder to write table1.csv, table1.json, table1.tex, table1.svg and rows/ into; rows found
    /// there are not computed again
    #[arg(long, value_name = "DIR", help_heading = OUTPUT)]
    pub out: PathBuf,
    /// Instead of simulating: a folder of trials, each with contact.csv.gz and truth.json
    #[arg(long, value_name = "DIR", help_heading = TRIALS)]
    pub logs: Option<PathBuf>,
    /// Trials to simulate
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000), conflicts_with = "logs", help_heading = TRIALS)]
    pub trials: u32,
    /// Simulate this scenario, whose first fixture is a hole, instead of the paper's
    #[arg(long, value_name = "FILE", conflicts_with = "logs", help_heading = TRIALS)]
    pub scenario: Option<PathBuf>,
    /// Contacts to simulate per trial, instead of the scenario's (the paper's has 3000)
    #[arg(long, value_parser = clap::value_parser!(u32).range(20..=1_000_000), conflicts_with = "logs", help_heading = TRIALS)]
    pub contacts: Option<u32>,
    /// Seed of the first simulated trial; later trials use the following numbers
    #[arg(long, default_value_t = 1, conflicts_with = "logs", help_heading = TRIALS)]
    pub seed: u64,
    /// Samples of the contact manifold, from `touchcal manifold`
    #[arg(long, value_name = "FILE", help_heading = MANIFOLDS)]
    pub manifold: Option<PathBuf>,
    /// Trained weights of the projection, from `touchcal train`
    #[arg(long, value_name = "FILE", help_heading = MANIFOLDS)]
    pub weights: Option<PathBuf>,
    /// Millimetres equivalent to one degree in the distance to the nearest sample
    #[arg(long, value_name = "MM", default_value_t = 1.0, value_parser = positive, help_heading = MANIFOLDS)]
    pub mm_per_deg: f64,
    /// Only this method (may be repeated)
    #[arg(long, value_name = "METHOD", value_enum, help_heading = METHODS)]
    pub only: Vec<ApproachName>,
    /// Steps of gradient descent
    #[arg(long, default_value_t = 5000, value_parser = clap::value_parser!(u32).range(10..=1_000_000), help_heading = METHODS)]
    pub steps: u32,
    /// Contacts used by gradient descent
    #[arg(long, default_value_t = 500, value_parser = clap::value_parser!(u32).range(10..=1_000_000), help_heading = METHODS)]
    pub descent_contacts: u32,
}

/// Arguments of `experiment paper`.
#[derive(Debug, clap::Args)]
#[command(after_help = examples(&[
    ("Minutes", "touchcal experiment paper --quick --out paper"),
    ("Half an hour", "touchcal experiment paper --out paper"),
]))]
pub struct PaperArgs {
    /// Folder to write all results into; what is found there is not computed again
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Two to five minutes on two cores instead of half an hour: fewer poses, steps and trials
    #[arg(long)]
    pub quick: bool,
}

/// Names of the approaches that the table compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum ApproachName {
    /// A network's projection, gradient descent
    LearnedGd,
    /// A network's projection, Levenberg-Marquardt
    LearnedLm,
    /// The nearest sample, gradient descent
    NearestGd,
    /// The nearest sample, Levenberg-Marquardt
    NearestLm,
    /// The exact gap, Levenberg-Marquardt
    ExactLm,
}

impl ApproachName {
    /// Name in arguments and files: `exact_lm`.
    pub fn key(self) -> &'static str {
        match self {
            ApproachName::LearnedGd => "learned_gd",
            ApproachName::LearnedLm => "learned_lm",
            ApproachName::NearestGd => "nearest_gd",
            ApproachName::NearestLm => "nearest_lm",
            ApproachName::ExactLm => "exact_lm",
        }
    }
}

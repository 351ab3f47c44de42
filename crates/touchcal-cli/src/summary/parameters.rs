//! The table of parameters.

use touchcal::parameter::{Block, Parameter, ParameterId};
use touchcal::report::{fixed, signed};

use crate::table::Table;

/// Largest number of groups listed per block.
const MOST_GROUPS: usize = 8;
/// Largest number of other parameters listed.
const MOST_SCALARS: usize = 10;
/// Marks parameters that the data do not determine.
const MARK: &str = "*";

/// How much to print.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// The components of a pose on one line, directional gap biases left out, long lists shortened.
    Grouped,
    /// Every parameter on a line of its own.
    Every,
}

/// A row of the table: a parameter with its estimate.
pub struct ParameterRow<'a> {
    /// Which parameter.
    pub parameter: &'a Parameter,
    /// Its estimate (SI); none before solving.
    pub value: Option<f64>,
    /// Its standard deviation (SI); none where nothing bounds it.
    pub sigma: Option<f64>,
    /// Whether the data determine it.
    pub identifiable: bool,
}

/// Blocks of the encoders that hold for one log only, and their titles.
const OF_LOG: [(Block, &str); 3] = [
    (Block::JointDrift, "joint drifts between placements"),
    (Block::JointTrend, "joint trends"),
    (Block::JointWalk, "joint walks over the log"),
];

/// Tables of all parameters.
pub fn parameters(lines: &[ParameterRow<'_>], detail: Detail) -> String {
    let apart = |line: &&ParameterRow<'_>| {
        let block = line.parameter.id.block();
        let place = matches!(block, Block::JointOrigin | Block::Tool | Block::Fixture);
        detail == Detail::Grouped && (place || OF_LOG.iter().any(|(of_log, _)| *of_log == block))
    };
    let is_directional = |line: &&ParameterRow<'_>| matches!(line.parameter.id, ParameterId::DirectionalGapBias(..));
    let directional = lines.iter().filter(is_directional).count();
    let lines: Vec<&ParameterRow<'_>> =
        lines.iter().filter(|line| detail == Detail::Every || !is_directional(line)).collect();
    let single: Vec<&ParameterRow<'_>> = lines.iter().copied().filter(|line| !apart(line)).collect();
    let mut text = scalars(&single, if detail == Detail::Grouped { MOST_SCALARS } else { usize::MAX });
    if detail == Detail::Grouped {
        for (block, title) in [(Block::JointOrigin, "joint origin"), (Block::Tool, "tool"), (Block::Fixture, "fixture")]
        {
            let members: Vec<&ParameterRow<'_>> =
                lines.iter().copied().filter(|l| l.parameter.id.block() == block).collect();
            text.push_str(&places(&members, title));
        }
        for (block, what) in OF_LOG {
            let members: Vec<&ParameterRow<'_>> =
                lines.iter().copied().filter(|l| l.parameter.id.block() == block).collect();
            text.push_str(&root_mean_square(&members, what));
        }
        if directional > 0 {
            text.push_str(&format!("  {directional} gap biases by direction (--all lists them)\n"));
        }
    }
    // Rows of a sum, and those left out of a long list, have no mark.
    if text.contains(MARK) {
        text.push_str(&format!(
            "  {MARK} not identifiable from these contacts: determined by the prior, fixed at zero,\n    or known only relative to what is fixed\n"
        ));
    }
    text + "\n"
}

/// A line for each parameter; of more than `most` only the first that are identifiable. Before
/// solving there are no values, and no column for them.
fn scalars(all: &[&ParameterRow<'_>], most: usize) -> String {
    if all.is_empty() {
        return String::new();
    }
    let is_listed = |line: &&&ParameterRow<'_>| all.len() <= most || line.identifiable;
    let lines: Vec<&ParameterRow<'_>> = all.iter().filter(is_listed).take(most).copied().collect();
    let solved = lines.iter().any(|line| line.value.is_some());
    let mut table = Table::default();
    let headings = ["parameter", "value", "± sigma", "prior", "unit", ""];
    let shown =
        |cells: [String; 6]| cells.into_iter().enumerate().filter(move |(i, _)| solved || *i != 1).map(|(_, c)| c);
    table.row(shown(headings.map(str::to_owned)));
    for line in &lines {
        let (factor, unit, decimals) = line.parameter.unit.in_user_units();
        let number =
            |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{:.decimals$}", factor * value));
        table.row(shown([
            line.parameter.name.clone(),
            line.value.map_or("-".to_owned(), |value| signed(factor * value, decimals)),
            number(line.sigma),
            number(line.parameter.prior_sigma()),
            unit.to_owned(),
            if line.identifiable { String::new() } else { format!("{MARK} not identifiable") },
        ]));
    }
    let more = match all.len() - lines.len() {
        0 => String::new(),
        more => {
            let unknown = all.iter().filter(|line| !line.identifiable).count();
            format!("  … and {more} more parameters, of which {unknown} are not identifiable (--all lists them)\n")
        }
    };
    format!("{table}{more}")
}

/// Twists, a line of values and a line of standard deviations each.
fn places(lines: &[&ParameterRow<'_>], title: &str) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let owner =
        |line: &ParameterRow<'_>| line.parameter.name.rsplit_once('.').map_or(String::new(), |(o, _)| o.to_owned());
    let mut owners: Vec<String> = lines.iter().map(|line| owner(line)).collect();
    owners.dedup();
    let component = |line: &ParameterRow<'_>| line.parameter.name.rsplit('.').next().unwrap_or("").to_owned();
    let mut components: Vec<String> = Vec::new();
    for line in lines {
        if !components.contains(&component(line)) {
            components.push(component(line));
        }
    }
    let with_unit = |name: &String| format!("{name} {}", if name.starts_with('r') { "deg" } else { "mm" });
    let mut table = Table::default();
    table.row(std::iter::once(title.to_owned()).chain(components.iter().map(with_unit)));
    for owner_name in owners.iter().take(MOST_GROUPS) {
        let of: Vec<Option<&&ParameterRow<'_>>> = components
            .iter()
            .map(|wanted| lines.iter().find(|line| owner(line) == *owner_name && component(line) == *wanted))
            .collect();
        let short = owner_name.split_once('.').map_or(owner_name.as_str(), |(_, rest)| rest);
        if of.iter().flatten().any(|line| line.value.is_some()) {
            table.row(std::iter::once(short.to_owned()).chain(of.iter().map(|line| cell(*line, true))));
            table.row(std::iter::once("  ±".to_owned()).chain(of.iter().map(|line| cell(*line, false))));
        } else {
            table.row(std::iter::once(format!("{short} ±")).chain(of.iter().map(|line| cell(*line, false))));
        }
    }
    let more = match owners.len().saturating_sub(MOST_GROUPS) {
        0 => String::new(),
        more => format!("  … and {more} more (--all lists them)\n"),
    };
    format!("{table}{more}")
}

fn cell(line: Option<&&ParameterRow<'_>>, wants_value: bool) -> String {
    let Some(line) = line else { return "-".to_owned() };
    let (factor, ..) = line.parameter.unit.in_user_units();
    let text = match (wants_value, line.value, line.sigma) {
        (true, Some(value), _) => signed(factor * value, 3),
        (false, _, Some(sigma)) => fixed(factor * sigma, 3),
        _ => "-".to_owned(),
    };
    let marked = !line.identifiable && (wants_value || line.value.is_none());
    // A blank where there is no mark keeps the digits below each other.
    text + if marked { MARK } else { " " }
}

fn root_mean_square(lines: &[&ParameterRow<'_>], what: &str) -> String {
    if lines.is_empty() {
        return String::new();
    }
    let count = lines.len();
    let squares: f64 = lines.iter().filter_map(|line| line.value).map(|value| value * value).sum();
    let rms = (squares / count as f64).sqrt().to_degrees();
    match lines.iter().all(|line| line.value.is_some()) {
        true => format!("  {count} {what}, rms {rms:.4} deg (--all lists them)\n"),
        false => format!("  {count} {what} (--all lists them)\n"),
    }
}

//! Results as text for a terminal.

mod declarations;
mod layout;
mod parameters;

use layout::hanging;
pub use layout::{INDENT, advice, millimetres, wrapped};
pub use parameters::{Detail, ParameterRow, parameters};

use touchcal::contact::{ContactLog, RowsLeftOut};
use touchcal::estimate::{
    Estimate, Fixture, Identifiability, Method, NullDirection, ParameterEstimate, PredictiveCheck, Score, Severity,
    Spread, Status,
};
use touchcal::io::calibration_folder::{Solved, Written, WrittenExport};
use touchcal::io::estimate_file::{EstimateFile, HeldOutEntry, ScatterEntry};
use touchcal::io::{Export, Loaded};
use touchcal::parameter::{Block, ParameterId};
use touchcal::report::{fixed, signed};
use touchcal::solver::{StopReason, Termination};

use crate::table::Table;
use declarations::{declarations, freed_effects};

/// Most fixtures listed one by one.
pub const MOST_FIXTURES: usize = 12;
/// Most directions of the null space listed one by one.
const MOST_DIRECTIONS: usize = 3;
/// Most remedies listed below directions that are not.
const MOST_REMEDIES: usize = 2;

/// A calibration and its files.
pub struct Calibration<'a> {
    /// The input.
    pub loaded: &'a Loaded,
    /// The result.
    pub solved: &'a Solved,
    /// The content of estimate.json.
    pub file: &'a EstimateFile,
    /// Paths of the output files.
    pub written: &'a Written,
}

impl Calibration<'_> {
    /// The summary after the [`verdict`], its first words; `next` is the advice for a usable
    /// result.
    pub fn summary(&self, detail: Detail, next: &str) -> String {
        let Solved { estimate, prefit, .. } = self.solved;
        let problem = &self.loaded.problem;
        let lines = estimate.parameters.iter().map(|entry| ParameterRow {
            parameter: &entry.parameter,
            value: Some(entry.value),
            sigma: entry.sigma,
            // After a failed descent no parameter is marked as not identifiable.
            identifiable: entry.identifiable || !estimate.has_identifiability(),
        });
        let lines: Vec<ParameterRow<'_>> = lines.collect();
        let scores = [("before", prefit), ("after", &estimate.postfit)];
        let source = if problem.noise.is_estimated { "estimated noise" } else { "declared noise" };
        [
            format!("{}\n", self.headline()),
            self.acceptance(),
            format!("Contacts  {}\n", wrapped(&self.rows())),
            format!("Noise     {:.2} times the {source}\n", estimate.noise_factor),
            format!("Robot     {}\n", robot(self.loaded)),
            format!("Search    {}\n", wrapped(&self.search())),
            predictive_check(estimate.predictive_check.as_ref()),
            freed_effects(&estimate.freed_effects),
            self.held_out(),
            self.notes(),
            "\n".to_owned(),
            "Distance from contact (mm)\n".to_owned(),
            residuals(&problem.fixtures, &scores),
            parameters(&lines, detail),
            match estimate.has_identifiability() {
                true => identifiability(&estimate.identifiability, &estimate.parameters, detail),
                false => format!("Identifiable  {}\n\n", Identifiability::UNKNOWN),
            },
            declarations(estimate, problem),
            competing_minima(estimate),
            self.warnings(),
            self.paths(),
            self.next(next),
        ]
        .concat()
    }

    /// What follows the verdict: the expected error of the tool, or that the result must not be
    /// used.
    fn headline(&self) -> String {
        let Estimate { status, termination, .. } = &self.solved.estimate;
        let error = self.file.tool_error();
        let blanks = " ".repeat(INDENT.len().saturating_sub(verdict(*status).len()));
        match status {
            Status::Usable => blanks + &wrapped(&error),
            Status::Doubtful => blanks + &wrapped(&format!("{error}; see the warnings")),
            Status::NotUsable if termination.reason == StopReason::Converged => {
                ": DO NOT USE this result, see the warnings".to_owned()
            }
            Status::NotUsable => ": DO NOT USE this result, the search did not converge".to_owned(),
        }
    }

    /// What became of the rows that were read.
    fn rows(&self) -> String {
        let count = &self.file.contacts;
        let others = left_out(&self.loaded.problem.contacts);
        match &self.loaded.problem.method {
            Method::GradientDescent(options) => {
                let all = self.loaded.problem.contacts.len();
                let (used, read) = (options.contacts_used(all), count.read);
                format!(
                    "{read} rows read: {all} contacts, of which the descent uses {used}; {} do not fit its result{others}",
                    count.rejected
                )
            }
            Method::LevenbergMarquardt => {
                format!("{} rows read: {} used, {} rejected{others}", count.read, count.used, count.rejected)
            }
        }
    }

    /// How the search ended.
    fn search(&self) -> String {
        let Termination { reason, iterations, threshold, .. } = self.solved.estimate.termination;
        let seconds = self.file.seconds;
        match (&self.loaded.problem.method, reason) {
            (Method::GradientDescent(_), StopReason::Converged) => format!(
                "all {iterations} steps of gradient descent, {seconds:.2} s; another step lowers the mean distance by less than {} %, but more steps may still move parameters",
                100.0 * threshold
            ),
            _ => format!("{} after {iterations} steps, {seconds:.2} s", reason.name().replace('_', " ")),
        }
    }

    /// The scatter of contacts that were held out.
    fn held_out(&self) -> String {
        let Some(HeldOutEntry { contacts, scatter }) = self.file.held_out else { return String::new() };
        let scatter = scatter.map_or_else(
            || "their scatter cannot be predicted".to_owned(),
            |ScatterEntry { ratio, by_chance, .. }| {
                format!("{ratio:.2} times the predicted scatter; by chance up to {:.2}", by_chance[1])
            },
        );
        format!("Held out  {contacts} contacts: {scatter}\n")
    }

    /// Whether the calibration reaches what is asked of it.
    fn acceptance(&self) -> String {
        self.file.acceptance.as_ref().map_or_else(String::new, |entry| {
            format!("Accept    {}\n{}", wrapped(&entry.message), advice(INDENT, &entry.advice))
        })
    }

    /// What is assumed where the problem declares nothing, and other notes on its files.
    fn notes(&self) -> String {
        self.file.notes.iter().map(|note| format!("Note      {}\n", wrapped(note))).collect()
    }

    fn paths(&self) -> String {
        let Written { urdf, correction, estimate, report, driver, mcap, exports } = self.written;
        let [urdf, estimate, report] = [urdf, estimate, report].map(|path| path.display());
        let correction = correction.as_ref().map_or(String::new(), |path| {
            format!("{INDENT}{}, which corrects joint positions where a URDF cannot\n", path.display())
        });
        let driver = driver.as_ref().map_or(String::new(), |[urdf, offsets]| {
            let [urdf, offsets] = [urdf, offsets].map(|path| path.display());
            format!("{INDENT}{urdf} and {offsets}, for drivers that apply encoder offsets: use both or neither\n")
        });
        let mcap =
            mcap.as_ref().map_or(String::new(), |path| format!("{INDENT}{}, for Foxglove or Rerun\n", path.display()));
        let exports: String = exports.iter().map(written_export).collect();
        format!("Written   {urdf}\n{correction}{INDENT}{estimate}\n{INDENT}{report}\n{driver}{mcap}{exports}")
    }

    fn warnings(&self) -> String {
        let each = self.file.warnings.iter();
        let text: String = each.map(|entry| warning(entry.severity.into(), &entry.message, &entry.advice)).collect();
        if text.is_empty() { text } else { text + "\n" }
    }

    fn next(&self, next: &str) -> String {
        match self.solved.estimate.status {
            Status::Usable | Status::Doubtful => format!("Next      {next}\n"),
            Status::NotUsable if self.file.warnings.is_empty() => {
                "Next      estimate fewer parameters or record more contacts, and calibrate again\n".to_owned()
            }
            _ if matches!(self.loaded.problem.method, Method::GradientDescent(_)) => {
                "Next      calibrate by the default method, whose search depends less on where it starts\n".to_owned()
            }
            _ => "Next      follow the advice above, record more contacts, and calibrate again\n".to_owned(),
        }
    }
}

/// A file for another program, with what it lacks.
fn written_export(written: &WrittenExport) -> String {
    let what = match written.export {
        Export::Ur => "kinematics_params_file of the driver of Universal Robots",
        Export::Dh => "Denavit-Hartenberg parameters",
        Export::Ros2Control => "URDF with the encoder offsets in the transmissions of ros2_control",
        Export::Xacro => "a macro with a prefix for descriptions of cells",
    };
    let lacks: String = written.left_out.iter().map(|words| advice(INDENT, &format!("it lacks {words}"))).collect();
    format!("{INDENT}{}, {what}\n{lacks}", written.path.display())
}

/// The verdict on a result, with which its summary begins.
pub fn verdict(status: Status) -> &'static str {
    match status {
        Status::Usable => "USABLE",
        Status::Doubtful => "DOUBTFUL",
        Status::NotUsable => "NOT USABLE",
    }
}

/// Which rows of a log are no contacts, and why, each after a comma.
pub fn left_out(contacts: &ContactLog) -> String {
    let RowsLeftOut { out_of_contact, at_rest, repeated } = contacts.rows_left_out();
    let rows = [(out_of_contact, "not in contact"), (at_rest, "at rest"), (repeated, "read twice")];
    rows.iter().filter(|(rows, _)| *rows > 0).map(|(rows, why)| format!(", {rows} {why}")).collect()
}

/// A warning with its advice; one that forbids the use of the result says so.
pub fn warning(severity: Severity, words: &str, advice: &str) -> String {
    let words = match severity {
        Severity::Unusable => &format!("(not usable) {words}"),
        Severity::Doubtful | Severity::Caution => words,
    };
    format!("Warning   {}\n{}", wrapped(words), layout::advice(INDENT, advice))
}

/// Name, size and ends of the chain.
pub fn robot(loaded: &Loaded) -> String {
    let robot = &loaded.problem.robot;
    format!("{}, {} joints from {} to {}", robot.name(), robot.dof(), robot.base(), robot.tip())
}

/// A table of scores side by side: over all contacts, then by fixture, of those with contacts.
pub fn residuals(fixtures: &[Fixture], scores: &[(&str, &Score)]) -> String {
    let mut table = Table::default();
    let headings = scores.iter().flat_map(|(name, _)| [format!("{name}: mean"), "rms".to_owned(), "max".to_owned()]);
    table.row(["".to_owned(), "contacts".to_owned()].into_iter().chain(headings));
    let row = |name: &str, spreads: &[&Spread]| {
        let count = spreads.first().map_or(0, |spread| spread.count);
        let numbers = spreads.iter().flat_map(|spread| [spread.mean, spread.rms, spread.max].map(millimetres));
        [name.to_owned(), count.to_string()].into_iter().chain(numbers).collect::<Vec<String>>()
    };
    table.row(row("all", &scores.iter().map(|(_, score)| &score.all).collect::<Vec<_>>()));
    if fixtures.len() > 1 {
        let spreads = |f: usize| scores.iter().filter_map(|(_, score)| score.per_fixture.get(f)).collect();
        let each = fixtures.iter().enumerate().map(|(f, fixture)| (fixture, spreads(f)));
        let touched: Vec<(&Fixture, Vec<&Spread>)> =
            each.filter(|(_, spreads): &(_, Vec<&Spread>)| spreads.iter().any(|spread| spread.count > 0)).collect();
        touched.iter().take(MOST_FIXTURES).for_each(|(fixture, spreads)| table.row(row(&fixture.name, spreads)));
        if touched.len() > MOST_FIXTURES {
            table.row([format!("… and {} more", touched.len() - MOST_FIXTURES)]);
        }
    }
    format!("{table}\n")
}

/// Minima that contacts do not rule out.
fn competing_minima(estimate: &Estimate) -> String {
    let minima = &estimate.competing_minima;
    if minima.is_empty() {
        return String::new();
    }
    let mut table = Table::new([
        "other minimum",
        "distance of the tool (mm)",
        "cost over that here",
        "differs most in",
        "there",
        "here",
    ]);
    for (k, other) in minima.iter().enumerate() {
        let entry = &estimate.parameters[other.parameter];
        let (factor, unit, decimals) = entry.parameter.unit.in_user_units();
        let value = |value: f64| format!("{} {unit}", signed(factor * value, decimals));
        table.row([
            format!("{}", k + 1),
            millimetres(other.tool_distance),
            format!("{:.2}", other.cost_ratio),
            entry.parameter.name.clone(),
            value(other.values[other.parameter]),
            value(entry.value),
        ]);
    }
    format!("Contacts do not rule out these other minima\n{table}\n")
}

/// How far stretches of the log are from what the others predict.
fn predictive_check(check: Option<&PredictiveCheck>) -> String {
    check.map_or_else(String::new, |PredictiveCheck { ratio, stretches, .. }| {
        let count = stretches.len();
        format!("Predicted {count} stretches of the log, each from the others: {ratio:.2} times the expected scatter\n")
    })
}

/// Rank, condition number and null space as text; the null space of `parameters` by groups, unless
/// few directions or `detail` is asked for.
pub fn identifiability(found: &Identifiability, parameters: &[ParameterEstimate], detail: Detail) -> String {
    let (rank, all, null) = (found.rank, found.singular_values.len(), &found.null_space);
    let condition = fixed(found.condition, 0);
    let counted = wrapped(&counted(parameters));
    let head = format!("Identifiable  {rank} of {all} directions (condition number {condition})\n{INDENT}{counted}\n");
    if null.is_empty() {
        return head + "\n";
    }
    if detail == Detail::Grouped && null.len() > MOST_DIRECTIONS {
        let (count, kinds) = (null.len(), kinds(null, parameters));
        let words = format!("in {count} directions the data add less than the prior: {kinds} (--all lists them)");
        let mut remedies: Vec<&String> = null.iter().filter_map(|null| null.remedy.as_ref()).collect();
        remedies.dedup();
        let remedies = remedies.into_iter().take(MOST_REMEDIES).map(|words| advice(INDENT, words));
        return format!("{head}{INDENT}{}\n{}\n", wrapped(&words), remedies.collect::<String>());
    }
    let remedy = |words: &String| advice("    ", words);
    let line = |null: &NullDirection| {
        format!("  - {}\n{}", hanging(&null.description, 4), null.remedy.as_ref().map_or_else(String::new, remedy))
    };
    let each: String = null.iter().map(line).collect();
    format!("{head}Directions that are not identifiable (the data add less than the prior):\n{each}\n")
}

/// Which parameters the directions are of, and which they are not, by their blocks.
fn counted(parameters: &[ParameterEstimate]) -> String {
    let names = |counts: bool| {
        let ids = parameters.iter().map(|entry| entry.parameter.id).filter(|id| Identifiability::counts(*id) == counts);
        let mut blocks: Vec<(&str, usize)> = Vec::new();
        for name in ids.map(|id| match id {
            ParameterId::DirectionalGapBias(..) => "gap_bias by direction",
            id => id.block().name(),
        }) {
            match blocks.iter_mut().find(|(known, _)| *known == name) {
                Some((_, count)) => *count += 1,
                None => blocks.push((name, 1)),
            }
        }
        blocks.iter().map(|(name, count)| format!("{count} {name}")).collect::<Vec<String>>().join(", ")
    };
    let others = names(false);
    let others = if others.is_empty() { others } else { format!("; not counted are {others}") };
    format!("of these parameters: {}{others}", names(true))
}

/// Numbers of directions by the parameters that take part.
fn kinds(null: &[NullDirection], parameters: &[ParameterEstimate]) -> String {
    const KINDS: [&str; 6] = [
        "between arm and fixtures",
        "between arm and tool",
        "between tool and fixtures",
        "within the arm",
        "of one parameter on which no contact depends",
        "others",
    ];
    let mut counts = [0; KINDS.len()];
    for direction in null {
        let blocks: Vec<Block> = direction.named().map(|k| parameters[k].parameter.id.block()).collect();
        let has_arm = blocks.iter().any(|block| !block.is_nuisance());
        let (has_tool, has_fixture) = (blocks.contains(&Block::Tool), blocks.contains(&Block::Fixture));
        counts[match (has_arm, has_tool, has_fixture) {
            _ if blocks.len() == 1 => 4,
            (true, _, true) => 0,
            (true, true, false) => 1,
            (false, true, true) => 2,
            (true, false, false) if blocks.iter().all(|block| !block.is_nuisance()) => 3,
            _ => 5,
        }] += 1;
    }
    let each = counts.iter().zip(KINDS).filter(|(count, _)| **count > 0);
    each.map(|(count, kind)| format!("{count} {kind}")).collect::<Vec<String>>().join(", ")
}

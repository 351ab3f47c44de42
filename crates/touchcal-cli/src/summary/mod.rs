//! Results as text for a terminal.

mod declarations;
mod layout;
mod parameters;

pub use layout::{INDENT, millimetres};
pub use parameters::{Detail, ParameterRow, in_user_units, parameters};

use touchcal::estimate::{Estimate, Fixture, Identifiability, NullDirection, PredictiveCheck, Score, Spread, Status};
use touchcal::io::Loaded;
use touchcal::io::calibration_folder::{Solved, Written};
use touchcal::io::estimate_file::{EstimateFile, HeldOutEntry, ScatterEntry};
use touchcal::solver::{StopReason, Termination};

use crate::table::{Table, fixed, signed};
use declarations::{declarations, freed_effects};
use layout::wrapped;

/// Most fixtures listed one by one.
pub const MOST_FIXTURES: usize = 12;
/// Most directions of the null space listed one by one.
const MOST_DIRECTIONS: usize = 8;

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
    /// The summary; `next` is the advice for a usable result.
    pub fn summary(&self, detail: Detail, next: &str) -> String {
        let Solved { estimate, prefit, .. } = self.solved;
        let problem = &self.loaded.problem;
        let count = &self.file.contacts;
        let lines = estimate.parameters.iter().map(|entry| ParameterRow {
            parameter: &entry.parameter,
            value: Some(entry.value),
            sigma: entry.sigma,
            identifiable: entry.identifiable,
        });
        let lines: Vec<ParameterRow<'_>> = lines.collect();
        let scores = [("before", prefit), ("after", &estimate.postfit)];
        let source = if problem.noise.is_estimated { "estimated noise" } else { "declared noise" };
        [
            format!("{}\n", self.headline()),
            format!("Robot     {}\n", robot(self.loaded)),
            format!("Contacts  {} rows read, {} contacts used, {} rejected\n", count.read, count.used, count.rejected),
            format!("Noise     {:.2} times the {source}\n", estimate.noise_factor),
            self.tool(),
            predictive_check(estimate.predictive_check.as_ref()),
            freed_effects(&estimate.freed_effects),
            self.held_out(),
            self.acceptance(),
            self.notes(),
            "\n".to_owned(),
            "Distance from touching (mm)\n".to_owned(),
            residuals(&problem.fixtures, &scores),
            parameters(&lines, detail),
            identifiability(&estimate.identifiability, detail),
            declarations(estimate, problem),
            competing_minima(estimate),
            self.warnings(),
            self.paths(),
            self.next(next),
        ]
        .concat()
    }

    /// Whether the result may be used.
    fn headline(&self) -> String {
        let Termination { reason, iterations, .. } = self.solved.estimate.termination;
        let search = format!("converged in {iterations} steps, {:.2} s", self.file.seconds);
        match self.solved.estimate.status {
            Status::Usable => format!("Calibrated: usable ({search})."),
            Status::Doubtful => format!("Calibrated: DOUBTFUL, see the warnings ({search})."),
            Status::NotUsable if reason == StopReason::Converged => {
                "*** NOT USABLE (see the warnings): DO NOT USE this result. ***".to_owned()
            }
            Status::NotUsable => {
                let reason = reason.name().replace('_', " ");
                format!(
                    "*** NOT USABLE (not converged: {reason} after {iterations} steps): DO NOT USE this result. ***"
                )
            }
        }
    }

    /// How well the tool is known.
    fn tool(&self) -> String {
        self.solved.estimate.workspace_uncertainty.map_or_else(String::new, |known| {
            let [position, distance] = [known.position, known.distance].map(millimetres);
            let angle = fixed(known.angle.to_degrees(), 3);
            format!(
                "Tool      ± {position} mm and {angle}° in base, ± {distance} mm between two positions (standard deviations)\n"
            )
        })
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
            format!("Accept    {}\n{INDENT}-> {}\n", wrapped(&entry.message), entry.advice)
        })
    }

    /// What is assumed where the problem declares nothing, and other notes on its files.
    fn notes(&self) -> String {
        self.file.notes.iter().map(|note| format!("Note      {}\n", wrapped(note))).collect()
    }

    fn paths(&self) -> String {
        let Written { urdf, estimate, report, driver, mcap, ur } = self.written;
        let [urdf, estimate, report] = [urdf, estimate, report].map(|path| path.display());
        let driver = driver.as_ref().map_or(String::new(), |[urdf, offsets]| {
            let [urdf, offsets] = [urdf, offsets].map(|path| path.display());
            format!("{INDENT}{urdf} and {offsets}, for drivers that apply encoder offsets: use both or neither\n")
        });
        let mcap =
            mcap.as_ref().map_or(String::new(), |path| format!("{INDENT}{}, for Foxglove or Rerun\n", path.display()));
        let ur = ur.as_ref().map_or(String::new(), |(path, left_out)| {
            let lacks: String = left_out.iter().map(|words| format!("{INDENT}-> it lacks {words}\n")).collect();
            format!("{INDENT}{}, kinematics_params_file of the driver of Universal Robots\n{lacks}", path.display())
        });
        format!("Written   {urdf}\n{INDENT}{estimate}\n{INDENT}{report}\n{driver}{mcap}{ur}")
    }

    fn warnings(&self) -> String {
        let each = self.file.warnings.iter();
        let text: String = each.map(|entry| warning(&entry.message, &entry.advice)).collect();
        if text.is_empty() { text } else { text + "\n" }
    }

    fn next(&self, next: &str) -> String {
        match self.solved.estimate.status {
            Status::Usable | Status::Doubtful => format!("Next      {next}\n"),
            Status::NotUsable if self.file.warnings.is_empty() => {
                "Next      estimate fewer parameters or record more contacts, and calibrate again\n".to_owned()
            }
            _ => "Next      follow the advice above, record more contacts, and calibrate again\n".to_owned(),
        }
    }
}

/// A warning with its advice.
pub fn warning(words: &str, advice: &str) -> String {
    format!("Warning   {}\n          -> {advice}\n", wrapped(words))
}

/// Name, size and ends of the chain.
pub fn robot(loaded: &Loaded) -> String {
    let robot = &loaded.problem.robot;
    format!("{}, {} joints from {} to {}", robot.name(), robot.dof(), robot.base(), robot.tip())
}

/// A table of scores side by side: over all contacts, then by fixture.
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
        for (f, fixture) in fixtures.iter().enumerate().take(MOST_FIXTURES) {
            let spreads: Vec<&Spread> = scores.iter().filter_map(|(_, score)| score.per_fixture.get(f)).collect();
            table.row(row(&fixture.name, &spreads));
        }
        if fixtures.len() > MOST_FIXTURES {
            table.row([format!("… and {} more", fixtures.len() - MOST_FIXTURES)]);
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
        let (factor, unit, decimals) = in_user_units(entry.parameter.unit);
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

/// Rank, condition number and null space as text.
pub fn identifiability(identifiability: &Identifiability, detail: Detail) -> String {
    let (rank, parameters, null) =
        (identifiability.rank, identifiability.singular_values.len(), &identifiability.null_space);
    let head = format!(
        "Identifiable  {rank} of {parameters} directions (condition number {})\n",
        fixed(identifiability.condition, 0)
    );
    if null.is_empty() {
        return head + "\n";
    }
    let shown = if detail == Detail::Every { null.len() } else { MOST_DIRECTIONS.min(null.len()) };
    let remedy = |words: &String| format!("    -> {words}\n");
    let line = |null: &NullDirection| {
        format!("  - {}\n{}", null.description, null.remedy.as_ref().map_or_else(String::new, remedy))
    };
    let each: String = null[..shown].iter().map(line).collect();
    let more = match null.len() - shown {
        0 => String::new(),
        more => format!("  … and {more} more (--all lists them)\n"),
    };
    format!("{head}Unobservable directions (the data add less than the prior):\n{each}{more}\n")
}

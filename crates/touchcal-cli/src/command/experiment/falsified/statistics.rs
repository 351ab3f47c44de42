//! Statistics of each kind of false declaration.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use touchcal::experiment::falsified::{FalsifiedKind, FalsifiedRow, FalsifiedSummary};

use crate::table::Table;

/// An entry of falsified.json: figures over all trials of a kind, and those of each excitation.
#[derive(Serialize)]
pub struct KindStatistics {
    /// Name of the kind.
    pub kind: &'static str,
    /// What is false, in words.
    pub description: &'static str,
    #[serde(flatten)]
    pub all: Figures,
    /// Figures of each excitation, or of each recorded trial.
    pub excitations: BTreeMap<String, Figures>,
}

/// Figures over trials; those after `answered` are over the answers that were not refused, null
/// where all were.
#[derive(Serialize)]
pub struct Figures {
    /// Number of trials, and of those whose answer is honest, useful, not refused.
    pub trials: u64,
    pub honest: u64,
    pub useful: u64,
    pub answered: u64,
    /// About 1 if uncertainties are right.
    pub nees_per_parameter: Option<f64>,
    /// Root mean squares.
    pub tool_error_mm: Option<f64>,
    pub tool_sigma_mm: Option<f64>,
    /// How many trials have a warning of each kind.
    pub warnings: BTreeMap<String, u64>,
}

impl KindStatistics {
    /// The figures of `kind`, from the rows of all kinds.
    pub fn new(kind: &FalsifiedKind, rows: &[FalsifiedRow]) -> KindStatistics {
        let own = || rows.iter().filter(|row| row.kind == kind.name);
        let names: BTreeSet<&String> = own().map(|row| &row.excitation).collect();
        let of = |name: &String| (name.clone(), Figures::new(own().filter(|row| row.excitation == *name)));
        KindStatistics {
            kind: kind.name,
            description: kind.description,
            all: Figures::new(own()),
            excitations: names.into_iter().map(of).collect(),
        }
    }
}

impl Figures {
    fn new<'a>(rows: impl Iterator<Item = &'a FalsifiedRow>) -> Figures {
        let mut summary = FalsifiedSummary::default();
        let mut warnings = BTreeMap::new();
        for row in rows {
            summary.add(row);
            row.warnings.iter().for_each(|warning| *warnings.entry(warning.clone()).or_default() += 1);
        }
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        Figures {
            trials: summary.trials,
            honest: summary.honest,
            useful: summary.useful,
            answered: summary.answered,
            nees_per_parameter: finite(summary.nees_per_parameter()),
            tool_error_mm: summary.tool_error().map(|error| 1e3 * error),
            tool_sigma_mm: summary.tool_sigma().map(|sigma| 1e3 * sigma),
            warnings,
        }
    }
}

/// The table for people.
pub fn table(kinds: &[KindStatistics]) -> String {
    let headings = ["kind", "trials", "honest", "useful", "NEES/parameter", "tool error, mm", "tool sigma, mm"];
    let mut table = Table::new(headings);
    let mut sums = [0; 3];
    for KindStatistics { kind, all, .. } in kinds {
        let figure = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.3}"));
        let counts = [all.trials, all.honest, all.useful];
        sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        let [trials, honest, useful] = counts.map(|count| count.to_string());
        let nees = all.nees_per_parameter.map_or_else(|| "–".to_owned(), |nees| format!("{nees:.2}"));
        let (error, sigma) = (figure(all.tool_error_mm), figure(all.tool_sigma_mm));
        table.row([(*kind).to_owned(), trials, honest, useful, nees, error, sigma]);
    }
    let [trials, honest, useful] = sums.map(|sum| sum.to_string());
    table.row(["all".to_owned(), trials, honest, useful]);
    format!(
        "honest: refused, or errors within the reported covariance; useful: honest and not refused\n\
         NEES, tool error and its standard deviation (root mean squares) are of answers not refused\n{table}"
    )
}

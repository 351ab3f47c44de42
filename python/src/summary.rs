//! A calibration in some lines: as text, and as HTML for a notebook.

use touchcal::estimate::{Identifiability, StopReason};
use touchcal::io::estimate_file::{EstimateFile, ParameterEntry, Status};
use touchcal::parameter::{Block, DIRECTION_NAMES, Unit};
use touchcal::report::{DeclarationTests, signed};

/// Most directions that are not determined, and most warnings, listed one by one.
const MOST_LISTED: usize = 3;
/// Columns of the labels.
const LABEL: usize = 18;
const HEADINGS: [&str; 5] = ["parameter", "value", "± sigma", "prior", "unit"];

/// What a summary says, in order.
pub struct Summary(Vec<Part>);

enum Part {
    /// A label and its text.
    Line(&'static str, String),
    Table {
        title: Option<&'static str>,
        /// The headings first.
        rows: Vec<Vec<String>>,
    },
}

impl Part {
    fn table<const N: usize>(title: Option<&'static str>, headings: [&str; N], rows: Vec<[String; N]>) -> Part {
        let rows = std::iter::once(headings.map(str::to_owned)).chain(rows);
        Part::Table { title, rows: rows.map(Vec::from).collect() }
    }

    /// As text: the first and the last column of a table flush left, the others flush right.
    fn text(&self) -> String {
        let (title, rows) = match self {
            Part::Line(label, text) => return format!("{label:<LABEL$}{text}\n"),
            Part::Table { title, rows } => (title.map_or_else(String::new, |title| format!("{title}\n")), rows),
        };
        let last = rows.first().map_or(0, |row| row.len().saturating_sub(1));
        let width =
            |column: usize| rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max();
        let widths: Vec<usize> = (0..=last).map(|column| width(column).unwrap_or(0)).collect();
        let cell = |(column, (text, &width)): (usize, (&String, &usize))| match column {
            0 => format!("  {text:<width$}"),
            _ if column == last => format!("  {text}"),
            _ => format!("  {text:>width$}"),
        };
        let lines = rows.iter().map(|row| row.iter().zip(&widths).enumerate().map(cell).collect::<String>() + "\n");
        title + &lines.collect::<String>()
    }

    /// As a piece of HTML.
    fn html(&self) -> String {
        let (title, rows) = match self {
            Part::Line(label, text) => return format!("<b>{label}</b> {}<br>", escaped(text)),
            Part::Table { title, rows } => (title.map_or_else(String::new, |title| format!("<b>{title}</b>")), rows),
        };
        let row = |cells: &Vec<String>, tag: &str| {
            let cells = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)));
            format!("<tr>{}</tr>", cells.collect::<String>())
        };
        let headings = rows.first().map_or_else(String::new, |headings| row(headings, "th"));
        let body = rows.iter().skip(1).map(|cells| row(cells, "td")).collect::<String>();
        // A table stands between the paragraphs of the lines.
        format!("{title}</p><table><thead>{headings}</thead><tbody>{body}</tbody></table><p>")
    }
}

impl Summary {
    /// Of a result, with its noise in words and what contacts say against its problem where these
    /// are known, and `most` parameters.
    pub fn new(file: &EstimateFile, noise: Option<String>, tests: Option<DeclarationTests>, most: usize) -> Summary {
        let count = &file.contacts;
        let [before, after] =
            [&file.residuals.prefit, &file.residuals.postfit].map(|stats| stats.rms_mm.unwrap_or(0.0));
        let mut parts = vec![
            Part::Line(verdict(file.status), verdict_text(file)),
            Part::Line(
                "Contacts",
                format!("{} rows read: {} used, {} rejected", count.read, count.used, count.rejected),
            ),
            Part::Line("Distances", format!("from contact {after:.3} mm rms (before: {before:.3} mm)")),
        ];
        parts.extend(noise.map(|noise| Part::Line("Noise", noise)));
        parts.extend(parameters(file, most));
        parts.extend(undetermined(file));
        if let Some(DeclarationTests { title, contradicted, others }) = tests {
            if !contradicted.is_empty() {
                parts.push(Part::table(Some(title), DeclarationTests::HEADINGS, contradicted));
            }
            parts.extend(others.into_iter().map(|(label, text)| Part::Line(label, text)));
        }
        let warnings = file.warnings.iter().map(|entry| format!("{} -> {}", entry.message, entry.advice));
        parts.extend(shortened(warnings.collect(), "warnings").into_iter().map(|text| Part::Line("Warning", text)));
        Summary(parts)
    }

    /// As text.
    pub fn text(&self) -> String {
        self.0.iter().map(Part::text).collect::<String>().trim_end().to_owned()
    }

    /// As a piece of HTML.
    pub fn html(&self) -> String {
        format!("<div><p>{}</p></div>", self.0.iter().map(Part::html).collect::<String>())
    }
}

/// The first `most` parameters, and how many there are besides.
fn parameters(file: &EstimateFile, most: usize) -> Vec<Part> {
    let all: Vec<&ParameterEntry> =
        file.parameters.iter().filter(|entry| !is_directional(entry, &file.parameters)).collect();
    let is_listed = |entry: &&ParameterEntry| all.len() <= most || entry.identifiable;
    let is_unknown = |entry: &ParameterEntry| file.has_identifiability() && !entry.identifiable;
    let rows = all.iter().copied().filter(is_listed).take(most).map(|entry| row(entry, is_unknown(entry)));
    let rows: Vec<_> = rows.collect();
    let more = all.len() - rows.len();
    let mut parts = Vec::new();
    // Without parameters no headings.
    if !rows.is_empty() {
        parts.push(Part::table(None, HEADINGS, rows));
    }
    if more > 0 {
        let unknown = all.iter().filter(|entry| is_unknown(entry)).count();
        let text = format!("{more} more; {unknown} of all {} are not identifiable", all.len());
        parts.push(Part::Line("Parameters", text));
    }
    parts
}

/// Whether a gap bias is one of a direction, on top of that of its fixture.
fn is_directional(entry: &ParameterEntry, all: &[ParameterEntry]) -> bool {
    let parts = entry.name.rsplit_once('.').filter(|(_, direction)| DIRECTION_NAMES.contains(direction));
    let is_of = |fixture: &str| all.iter().any(|other| other.name == fixture);
    entry.block == Block::GapBias.name() && parts.is_some_and(|(fixture, _)| is_of(fixture))
}

fn verdict(status: Status) -> &'static str {
    match status {
        Status::Usable => "USABLE",
        Status::Doubtful => "DOUBTFUL",
        Status::NotUsable => "NOT USABLE",
    }
}

/// The expected error of the tool, or why the result must not be used.
fn verdict_text(file: &EstimateFile) -> String {
    let error = file.tool_error();
    match file.status {
        Status::Usable => error,
        Status::Doubtful => format!("{error}; see the warnings"),
        Status::NotUsable if file.termination.reason == StopReason::Converged.name() => {
            "do not use this result, see the warnings".to_owned()
        }
        Status::NotUsable => "do not use this result, the search did not converge".to_owned(),
    }
}

fn row(entry: &ParameterEntry, is_unknown: bool) -> [String; 5] {
    let (factor, unit, decimals) = Unit::from_symbol(&entry.unit).unwrap_or(Unit::One).in_user_units();
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{:.decimals$}", factor * v));
    let name = &entry.name;
    [
        if is_unknown { format!("{name} (not identifiable)") } else { name.clone() },
        signed(factor * entry.value, decimals),
        number(entry.sigma),
        number(entry.prior_sigma),
        unit.to_owned(),
    ]
}

/// How many directions the data determine, and which they do not.
fn undetermined(file: &EstimateFile) -> Vec<Part> {
    if !file.has_identifiability() {
        return vec![Part::Line("Identifiable", Identifiability::UNKNOWN.to_owned())];
    }
    let all = file.rank + file.null_space.len();
    let mut lines = vec![Part::Line("Identifiable", format!("{} of {all} directions", file.rank))];
    let null = file.null_space.iter().map(|direction| direction.description.clone()).collect();
    lines.extend(shortened(null, "directions").into_iter().map(|text| Part::Line("Not identifiable", text)));
    lines
}

/// The first few of `texts`, and how many there are besides.
fn shortened(mut texts: Vec<String>, what: &str) -> Vec<String> {
    if texts.len() > MOST_LISTED {
        let more = texts.len() - MOST_LISTED;
        texts.truncate(MOST_LISTED);
        texts.push(format!("… and {more} more {what}"));
    }
    texts
}

/// Text as HTML has it.
fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;").replace('\'', "&#39;")
}

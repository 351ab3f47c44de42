//! A calibration in some lines: as text, and as HTML for a notebook.

use touchcal::estimate::StopReason;
use touchcal::io::estimate_file::{EstimateFile, ParameterEntry, Status, WorkspaceUncertaintyEntry};
use touchcal::parameter::{Block, DIRECTION_NAMES, Unit};

/// Most directions that are not determined, and most warnings, listed one by one.
const MOST_LISTED: usize = 3;
/// Columns of the labels.
const LABEL: usize = 18;
const HEADINGS: [&str; 5] = ["parameter", "value", "± sigma", "prior", "unit"];

/// What a summary says, in order: labelled lines, a table of parameters, more such lines.
pub struct Summary {
    head: Vec<(&'static str, String)>,
    rows: Vec<[String; 5]>,
    foot: Vec<(&'static str, String)>,
}

impl Summary {
    /// Of a result, with its noise in words where that is known, and `most` parameters.
    pub fn new(file: &EstimateFile, noise: Option<String>, most: usize) -> Summary {
        let count = &file.contacts;
        let [before, after] =
            [&file.residuals.prefit, &file.residuals.postfit].map(|stats| stats.rms_mm.unwrap_or(0.0));
        let mut head = vec![
            (verdict(file.status), verdict_text(file)),
            ("Contacts", format!("{} rows read: {} used, {} rejected", count.read, count.used, count.rejected)),
            ("Distances", format!("from contact {after:.3} mm rms (before: {before:.3} mm)")),
        ];
        head.extend(noise.map(|noise| ("Noise", noise)));
        let all: Vec<&ParameterEntry> =
            file.parameters.iter().filter(|entry| !is_directional(entry, &file.parameters)).collect();
        let is_listed = |entry: &&ParameterEntry| all.len() <= most || entry.identifiable;
        let rows: Vec<_> = all.iter().copied().filter(is_listed).take(most).map(row).collect();
        let mut foot = Vec::new();
        if rows.len() < all.len() {
            let (more, unknown) = (all.len() - rows.len(), all.iter().filter(|entry| !entry.identifiable).count());
            foot.push(("Parameters", format!("{more} more; {unknown} of all {} are not identifiable", all.len())));
        }
        foot.extend(undetermined(file));
        let warnings = file.warnings.iter().map(|entry| format!("{} -> {}", entry.message, entry.advice));
        foot.extend(shortened(warnings.collect(), "warnings").into_iter().map(|text| ("Warning", text)));
        Summary { head, rows, foot }
    }

    /// As text.
    pub fn text(&self) -> String {
        let line = |(label, text): &(&str, String)| format!("{label:<LABEL$}{text}\n");
        let cells: Vec<[&str; 5]> =
            std::iter::once(HEADINGS).chain(self.rows.iter().map(|row| row.each_ref().map(String::as_str))).collect();
        let width = |column: usize| cells.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: [usize; 5] = std::array::from_fn(width);
        // Without parameters no headings.
        let cells = if self.rows.is_empty() { &[] } else { &cells[..] };
        let table = cells.iter().map(|[name, value, sigma, prior, unit]| {
            let [first, second, third, fourth, _] = widths;
            format!("  {name:<first$}  {value:>second$}  {sigma:>third$}  {prior:>fourth$}  {unit}\n")
        });
        let head = self.head.iter().map(line);
        let text: String = head.chain(table).chain(self.foot.iter().map(line)).collect();
        text.trim_end().to_owned()
    }

    /// As a piece of HTML.
    pub fn html(&self) -> String {
        let lines = |lines: &[(&str, String)]| {
            let line = |(label, text): &(&str, String)| format!("<b>{label}</b> {}<br>", escaped(text));
            lines.iter().map(line).collect::<String>()
        };
        let row = |cells: &[String; 5]| {
            let cells = cells.iter().map(|cell| format!("<td>{}</td>", escaped(cell)));
            format!("<tr>{}</tr>", cells.collect::<String>())
        };
        format!(
            "<div><p>{}</p><table><thead><tr>{}</tr></thead><tbody>{}</tbody></table><p>{}</p></div>",
            lines(&self.head),
            HEADINGS.map(|heading| format!("<th>{heading}</th>")).concat(),
            self.rows.iter().map(row).collect::<String>(),
            lines(&self.foot)
        )
    }
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
    let error =
        file.workspace_uncertainty.as_ref().map_or_else(|| "expected tool error not known".to_owned(), tool_error);
    match file.status {
        Status::Usable => error,
        Status::Doubtful => format!("{error}; see the warnings"),
        Status::NotUsable if file.termination.reason == StopReason::Converged.name() => {
            "do not use this result, see the warnings".to_owned()
        }
        Status::NotUsable => "do not use this result, the search did not converge".to_owned(),
    }
}

fn tool_error(tool: &WorkspaceUncertaintyEntry) -> String {
    let pose = |mm: f64, degrees: f64| format!("{mm:.3} mm, {degrees:.3}°");
    let before = pose(tool.nominal_position_mm, tool.nominal_angle_deg);
    format!(
        "expected tool error in base {} (before: {before}), between two positions {:.3} mm (before: {:.3} mm)",
        pose(tool.position_mm, tool.angle_deg),
        tool.distance_mm,
        tool.nominal_distance_mm
    )
}

fn row(entry: &ParameterEntry) -> [String; 5] {
    let (factor, unit, decimals) = Unit::from_symbol(&entry.unit).unwrap_or(Unit::One).in_user_units();
    let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |v| format!("{:.decimals$}", factor * v));
    let name = &entry.name;
    // A tiny negative value is no "-0.0000".
    let least = 0.5 * 10f64.powi(-(decimals as i32));
    let value = Some(factor * entry.value).filter(|value| value.abs() >= least).unwrap_or(0.0);
    [
        if entry.identifiable { name.clone() } else { format!("{name} (not identifiable)") },
        format!("{value:+.decimals$}"),
        number(entry.sigma),
        number(entry.prior_sigma),
        unit.to_owned(),
    ]
}

/// How many directions the data determine, and which they do not.
fn undetermined(file: &EstimateFile) -> Vec<(&'static str, String)> {
    let all = file.rank + file.null_space.len();
    let mut lines = vec![("Identifiable", format!("{} of {all} directions", file.rank))];
    let null = file.null_space.iter().map(|direction| direction.description.clone()).collect();
    lines.extend(shortened(null, "directions").into_iter().map(|text| ("Not identifiable", text)));
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

//! Figures of campaigns, as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;
use touchcal::experiment::LEVELS;

use super::super::figure::draw_mesh;
use super::told::Told;
use crate::args::Vary;

/// Size of a panel (px).
const PANEL: (u32, u32) = (430, 380);
const FOUND: RGBColor = RGBColor(31, 119, 180);
const MOST: RGBColor = RGBColor(140, 180, 215);
const BOUND: RGBColor = RGBColor(200, 60, 40);
const CHANCE: RGBColor = RGBColor(225, 225, 225);
/// Half the width of what chance leaves (share of the axis).
const HALF_BAND: f64 = 0.025;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// An SVG of panels side by side.
fn svg(panels: &[&dyn Fn(&Area<'_>) -> Drawn]) -> Result<String, String> {
    let mut text = String::new();
    {
        let size = (PANEL.0 * panels.len() as u32, PANEL.1);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(|error| error.to_string())?;
        for (area, panel) in root.split_evenly((1, panels.len())).iter().zip(panels) {
            panel(area).map_err(|error| error.to_string())?;
        }
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

/// Found less nominal share of true values within the intervals of each level, on what chance
/// leaves of it.
pub fn coverage(told: &Told) -> Result<String, String> {
    let [least, most] = told.nees_bounds_99;
    let title = format!(
        "{} trials, {:.1} % converged, NEES {:.2} ({least:.2} to {most:.2}), error {:.2} of the bound",
        told.trials,
        100.0 * told.converged,
        told.nees,
        told.error_over_cramer_rao
    );
    let places = [0.1, 0.35, 0.6, 0.85];
    let labels: Vec<String> = LEVELS.iter().map(|level| format!("{:.0} %", 100.0 * level)).collect();
    let above = |k: usize, share: f64| 100.0 * (share - LEVELS[k]);
    let columns: Vec<Column> = (0..LEVELS.len())
        .map(|k| Column {
            place: places[k],
            label: labels[k].clone(),
            chance: told.coverage_bounds_99[k].map(|bound| above(k, bound)),
            found: above(k, told.coverage[k]),
            said: format!("{:.1} %", 100.0 * told.coverage[k]),
        })
        .collect();
    let panel = |area: &Area<'_>| bands(area, (&title, 12), "intervals", "found less nominal share (points)", &columns);
    svg(&[&panel])
}

/// Errors and coverage against what was varied.
pub fn sweep(vary: &Vary, told: &[Told]) -> Result<String, String> {
    let places = places(&vary.values);
    let labels: Vec<(f64, String)> = places.iter().copied().zip(vary.values.iter().map(f64::to_string)).collect();
    let curve = |name, colour, value: &dyn Fn(&Told) -> f64| {
        let points = places.iter().copied().zip(told.iter().map(value));
        Curve { name, colour, points: points.filter(|(_, y)| *y > 0.0 && y.is_finite()).collect() }
    };
    let errors = |area: &Area<'_>, title: &str, curves: &[Curve]| lines(area, title, &vary.setting, &labels, curves);
    let offsets = [
        curve("95 % of trials", MOST, &|told| told.offset_error_deg[1]),
        curve("median", FOUND, &|told| told.offset_error_deg[0]),
        curve("Cramér–Rao bound", BOUND, &|told| told.offset_cramer_rao_deg),
    ];
    let tool = [
        curve("95 % of trials", MOST, &|told| told.tool_error_mm_quantiles[1]),
        curve("median", FOUND, &|told| told.tool_error_mm_quantiles[0]),
    ];
    let columns: Vec<Column> = (labels.iter().zip(told))
        .map(|((place, label), told)| Column {
            place: *place,
            label: label.clone(),
            chance: told.coverage_bounds_99[2].map(|bound| 100.0 * bound),
            found: 100.0 * told.coverage[2],
            said: String::new(),
        })
        .collect();
    let title = ("true values within 95 % intervals (%)", 16);
    let coverage = |area: &Area<'_>| bands(area, title, &vary.setting, "", &columns);
    let offsets_panel = |area: &Area<'_>| errors(area, "joint offsets' mean error (deg)", &offsets);
    let tool_panel = |area: &Area<'_>| errors(area, "tool at 1000 other poses, mean error (mm)", &tool);
    // Arms whose offsets are not estimated have no such error.
    match offsets[0].points.is_empty() {
        true => svg(&[&tool_panel, &coverage]),
        false => svg(&[&offsets_panel, &tool_panel, &coverage]),
    }
}

/// Where values are on an axis from 0 to 1: by their logarithms where they are far apart.
fn places(values: &[f64]) -> Vec<f64> {
    let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), &v| (a.min(v), b.max(v)));
    let by = |value: f64| if least > 0.0 && most > 5.0 * least { value.ln() } else { value };
    let width = by(most) - by(least);
    values.iter().map(|&v| if width > 0.0 { 0.1 + 0.8 * (by(v) - by(least)) / width } else { 0.5 }).collect()
}

/// A line through points.
struct Curve {
    name: &'static str,
    colour: RGBColor,
    points: Vec<(f64, f64)>,
}

fn lines(area: &Area<'_>, title: &str, below: &str, labels: &[(f64, String)], curves: &[Curve]) -> Drawn {
    // Whole decades, so that each axis has numbers, and room for the names of the curves.
    let values = curves.iter().flat_map(|curve| &curve.points).map(|(_, y)| y.log10());
    let (least, most) = values.fold((0.0f64, -1.0f64), |(a, b), v| if a > b { (v, v) } else { (a.min(v), b.max(v)) });
    let decades = 10f64.powf(least.floor())..10f64.powf((most + 0.5).ceil());
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 16))
        .margin(10)
        .x_label_area_size(45)
        .y_label_area_size(55)
        .build_cartesian_2d(0.0..1.0, decades.log_scale())?;
    draw_mesh(&mut chart)?;
    for Curve { name, colour, points } in curves {
        let series = LineSeries::new(points.iter().copied(), colour.stroke_width(2)).point_size(3);
        let mark = move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2));
        chart.draw_series(series)?.label(*name).legend(mark);
    }
    chart.configure_series_labels().position(SeriesLabelPosition::UpperRight).label_font(("sans-serif", 12)).draw()?;
    let range = chart.plotting_area().get_pixel_range();
    write_below(area, range, below, labels)
}

/// A dot on what chance leaves of it.
struct Column {
    place: f64,
    label: String,
    chance: [f64; 2],
    found: f64,
    /// Beside the dot.
    said: String,
}

fn bands(area: &Area<'_>, (title, size): (&str, i32), below: &str, beside: &str, columns: &[Column]) -> Drawn {
    let values = columns.iter().flat_map(|column| [column.chance[0], column.chance[1], column.found]);
    let finite = values.filter(|value| value.is_finite());
    let (least, most) = finite.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
    let (least, most) = if least < most { (least, most) } else { (0.0, 1.0) };
    let room = 0.15 * (most - least);
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", size))
        .margin(10)
        .x_label_area_size(45)
        .y_label_area_size(55)
        .build_cartesian_2d(0.0..1.0, least - room..most + room)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .x_labels(0)
        .y_desc(beside)
        .y_label_formatter(&|value| format!("{value:.1}"))
        .light_line_style(WHITE)
        .draw()?;
    let known = || columns.iter().filter(|column| column.found.is_finite());
    chart.draw_series(known().map(|Column { place, chance: [least, most], .. }| {
        Rectangle::new([(place - HALF_BAND, *least), (place + HALF_BAND, *most)], CHANCE.filled())
    }))?;
    chart.draw_series(known().map(|column| Circle::new((column.place, column.found), 4, FOUND.filled())))?;
    let style = ("sans-serif", 12).into_text_style(area);
    chart.draw_series(
        known().map(|column| {
            Text::new(column.said.clone(), (column.place + 1.4 * HALF_BAND, column.found), style.clone())
        }),
    )?;
    let labels: Vec<(f64, String)> = columns.iter().map(|column| (column.place, column.label.clone())).collect();
    write_below(area, chart.plotting_area().get_pixel_range(), below, &labels)
}

/// Labels under their places, and what they are under all.
fn write_below(
    area: &Area<'_>,
    (across, down): (std::ops::Range<i32>, std::ops::Range<i32>),
    below: &str,
    labels: &[(f64, String)],
) -> Drawn {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    let style = ("sans-serif", 12).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Top));
    let (left, top) = area.get_base_pixel();
    let x = |place: f64| across.start - left + (f64::from(across.end - across.start) * place) as i32;
    for (place, label) in labels {
        area.draw_text(label, &style, (x(*place), down.end - top + 6))?;
    }
    area.draw_text(below, &style, (x(0.5), down.end - top + 24))
}

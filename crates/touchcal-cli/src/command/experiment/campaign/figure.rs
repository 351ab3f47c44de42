//! Figures of campaigns, as SVG.

use plotters::coord::Shift;
use plotters::prelude::*;
use touchcal::experiment::LEVELS;

use super::super::figure::draw_mesh;
use super::statistics::CampaignStatistics;
use crate::args::Vary;

/// Size of a panel (px).
const PANEL: (u32, u32) = (430, 380);
const MEASURED: RGBColor = RGBColor(31, 119, 180);
const MOST: RGBColor = RGBColor(140, 180, 215);
const BOUND: RGBColor = RGBColor(200, 60, 40);
const CHANCE: RGBColor = RGBColor(225, 225, 225);
/// Half the width of the band that chance explains (share of the axis).
const HALF_BAND: f64 = 0.025;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type DrawingResult = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// An SVG of panels side by side.
fn svg(panels: &[&dyn Fn(&Area<'_>) -> DrawingResult]) -> Result<String, String> {
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

/// Measured minus nominal share of true values within the intervals of each level, over the range
/// that chance explains.
pub fn coverage(statistics: &CampaignStatistics) -> Result<String, String> {
    let [least, most] = statistics.nees_bounds_99;
    let title = format!(
        "{} trials, {:.1} % usable, NEES {:.2} ({least:.2} to {most:.2}), error {:.2} of the bound",
        statistics.trials,
        100.0 * statistics.usable,
        statistics.nees,
        statistics.error_over_cramer_rao
    );
    let places = [0.1, 0.35, 0.6, 0.85];
    let labels: Vec<String> = LEVELS.iter().map(|level| format!("{:.0} %", 100.0 * level)).collect();
    let above = |k: usize, share: f64| 100.0 * (share - LEVELS[k]);
    let columns: Vec<Column> = (0..LEVELS.len())
        .map(|k| Column {
            place: places[k],
            label: labels[k].clone(),
            chance: statistics.coverage_bounds_99[k].map(|bound| above(k, bound)),
            measured: above(k, statistics.coverage[k]),
            note: format!("{:.1} %", 100.0 * statistics.coverage[k]),
        })
        .collect();
    let panel =
        |area: &Area<'_>| bands(area, (&title, 12), "intervals", "measured minus nominal share (points)", &columns);
    svg(&[&panel])
}

/// Errors and coverage over the varied setting.
pub fn sweep(vary: &Vary, statistics: &[CampaignStatistics]) -> Result<String, String> {
    let places = places(&vary.values);
    let labels: Vec<(f64, String)> = places.iter().copied().zip(vary.values.iter().map(f64::to_string)).collect();
    let curve = |name, colour, value: &dyn Fn(&CampaignStatistics) -> f64| {
        let points = places.iter().copied().zip(statistics.iter().map(value));
        Curve { name, colour, points: points.filter(|(_, y)| *y > 0.0 && y.is_finite()).collect() }
    };
    let errors = |area: &Area<'_>, title: &str, curves: &[Curve]| lines(area, title, &vary.setting, &labels, curves);
    let offsets = [
        curve("95 % of trials", MOST, &|each| each.offset_error_deg[1]),
        curve("median", MEASURED, &|each| each.offset_error_deg[0]),
        curve("Cramér–Rao bound", BOUND, &|each| each.offset_cramer_rao_deg),
    ];
    let tool = [
        curve("95 % of trials", MOST, &|each| each.tool_error_mm_quantiles[1]),
        curve("median", MEASURED, &|each| each.tool_error_mm_quantiles[0]),
    ];
    let columns: Vec<Column> = (labels.iter().zip(statistics))
        .map(|((place, label), each)| Column {
            place: *place,
            label: label.clone(),
            chance: each.coverage_bounds_99[2].map(|bound| 100.0 * bound),
            measured: 100.0 * each.coverage[2],
            note: String::new(),
        })
        .collect();
    let title = ("true values within 95 % intervals (%)", 16);
    let coverage = |area: &Area<'_>| bands(area, title, &vary.setting, "", &columns);
    let offsets_panel = |area: &Area<'_>| errors(area, "mean error of joint offsets (deg)", &offsets);
    let tool_panel = |area: &Area<'_>| errors(area, "mean tool error at 1000 other poses (mm)", &tool);
    // Arms whose offsets are not estimated have no such error.
    match offsets[0].points.is_empty() {
        true => svg(&[&tool_panel, &coverage]),
        false => svg(&[&offsets_panel, &tool_panel, &coverage]),
    }
}

/// Positions of values on an axis from 0 to 1: logarithmic where they span more than a factor of 5.
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

fn lines(area: &Area<'_>, title: &str, below: &str, labels: &[(f64, String)], curves: &[Curve]) -> DrawingResult {
    // Whole decades, so that each axis has tick labels, and room for the legend.
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

/// A measured value on the range that chance explains.
struct Column {
    place: f64,
    label: String,
    chance: [f64; 2],
    measured: f64,
    /// Text beside the dot.
    note: String,
}

fn bands(area: &Area<'_>, (title, size): (&str, i32), below: &str, beside: &str, columns: &[Column]) -> DrawingResult {
    let values = columns.iter().flat_map(|column| [column.chance[0], column.chance[1], column.measured]);
    let numbers = values.filter(|value| value.is_finite());
    let (least, most) = numbers.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
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
    let finite = || columns.iter().filter(|column| column.measured.is_finite());
    chart.draw_series(finite().map(|Column { place, chance: [least, most], .. }| {
        Rectangle::new([(place - HALF_BAND, *least), (place + HALF_BAND, *most)], CHANCE.filled())
    }))?;
    chart.draw_series(finite().map(|column| Circle::new((column.place, column.measured), 4, MEASURED.filled())))?;
    let style = ("sans-serif", 12).into_text_style(area);
    chart.draw_series(finite().map(|column| {
        Text::new(column.note.clone(), (column.place + 1.4 * HALF_BAND, column.measured), style.clone())
    }))?;
    let labels: Vec<(f64, String)> = columns.iter().map(|column| (column.place, column.label.clone())).collect();
    write_below(area, chart.plotting_area().get_pixel_range(), below, &labels)
}

/// Tick labels below the axis, and the axis's label below them.
fn write_below(
    area: &Area<'_>,
    (across, down): (std::ops::Range<i32>, std::ops::Range<i32>),
    below: &str,
    labels: &[(f64, String)],
) -> DrawingResult {
    use plotters::style::text_anchor::{HPos, Pos, VPos};
    let style = ("sans-serif", 12).into_text_style(area).pos(Pos::new(HPos::Center, VPos::Top));
    let (left, top) = area.get_base_pixel();
    let x = |place: f64| across.start - left + (f64::from(across.end - across.start) * place) as i32;
    for (place, label) in labels {
        area.draw_text(label, &style, (x(*place), down.end - top + 6))?;
    }
    area.draw_text(below, &style, (x(0.5), down.end - top + 24))
}

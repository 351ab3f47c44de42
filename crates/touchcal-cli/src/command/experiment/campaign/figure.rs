//! Figures of campaigns, as SVG.

use plotters::coord::ranged1d::ValueFormatter;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use touchcal::experiment::LEVELS;

use super::super::figure::{
    Area, CHANCE, DASHES, DrawingResult, LARGE_DOT, LEGEND, LINE, MEASURED, MM, Mark, WIDTH, legend, power_of_ten, svg,
    text, write,
};
use super::statistics::CampaignStatistics;
use crate::args::Vary;

/// Height of a panel, and widths of what is below and beside its axes (px).
const PANEL: i32 = 48 * MM;
const BELOW: i32 = 8 * MM;
const BESIDE: i32 = 13 * MM;
/// Half the width of the band that chance explains (share of the axis).
const HALF_BAND: f64 = 0.025;

/// Measured minus nominal share of true values within the intervals of each level, over the range
/// that chance explains.
pub fn coverage(statistics: &CampaignStatistics) -> Result<String, String> {
    let [least, most] = statistics.nees_bounds_99;
    let title = [
        format!("{} trials, {:.1} % usable", statistics.trials, 100.0 * statistics.usable),
        format!(
            "NEES {:.2} ({least:.2} to {most:.2} by chance), error {:.2} × the Cramér–Rao bound",
            statistics.nees, statistics.error_over_cramer_rao
        ),
    ];
    let places = [0.1, 0.35, 0.6, 0.85];
    let above = |k: usize, share: f64| 100.0 * (share - LEVELS[k]);
    let columns: Vec<Column> = (0..LEVELS.len())
        .map(|k| Column {
            place: places[k],
            label: format!("{:.0} %", 100.0 * LEVELS[k]),
            chance: statistics.coverage_bounds_99[k].map(|bound| above(k, bound)),
            measured: above(k, statistics.coverage[k]),
            note: format!("{:.1} %", 100.0 * statistics.coverage[k]),
        })
        .collect();
    let titles = LINE * title.len() as i32 + MM / 2;
    let panel = Panel { below: "interval", beside: "measured − nominal (%)" };
    svg(titles + PANEL, |root| {
        for (line, words) in title.iter().enumerate() {
            write(root, words, (MM, LINE * line as i32 + 2 * MM), HPos::Left)?;
        }
        panel.bands(&root.clone().shrink((0, titles), (WIDTH, PANEL)), &columns)
    })
}

/// Errors and coverage over the varied setting.
pub fn sweep(vary: &Vary, statistics: &[CampaignStatistics]) -> Result<String, String> {
    let places = places(&vary.values);
    let labels: Vec<(f64, String)> = places.iter().copied().zip(vary.values.iter().map(f64::to_string)).collect();
    let curve = |mark, name, value: &dyn Fn(&CampaignStatistics) -> f64| {
        let points = places.iter().copied().zip(statistics.iter().map(value));
        Curve { mark, name, points: points.filter(|(_, y)| *y > 0.0 && y.is_finite()).collect() }
    };
    let (median, most) = (Mark::Line { filled: true }, Mark::Line { filled: false });
    let offsets = [
        curve(most, "95 % of trials", &|each| each.offset_error_deg[1]),
        curve(median, "median", &|each| each.offset_error_deg[0]),
        curve(Mark::Dashes, "Cramér–Rao bound", &|each| each.offset_cramer_rao_deg),
    ];
    let tool = [
        curve(most, "95 % of trials", &|each| each.tool_error_mm_quantiles[1]),
        curve(median, "median", &|each| each.tool_error_mm_quantiles[0]),
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
    let panel = |beside| Panel { below: &vary.setting, beside };
    // Arms whose encoder offsets are not estimated have no such error.
    let has_offsets = !offsets[0].points.is_empty();
    let panels = 2 + i32::from(has_offsets);
    svg(PANEL * panels, |root| {
        let area = |k: i32| root.clone().shrink((0, PANEL * k), (WIDTH, PANEL));
        if has_offsets {
            panel("encoder offset error (deg)").lines(&area(0), &labels, &offsets)?;
        }
        panel("tool error (mm)").lines(&area(panels - 2), &labels, &tool)?;
        panel("in 95 % intervals (%)").bands(&area(panels - 1), &columns)
    })
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
    mark: Mark,
    name: &'static str,
    points: Vec<(f64, f64)>,
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

/// A chart with a legend above it, and the names of its axes.
struct Panel<'a> {
    below: &'a str,
    beside: &'a str,
}

type Chart<'a, 'b, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, Y>>;

impl Panel<'_> {
    /// Curves on a logarithmic axis.
    fn lines(&self, area: &Area<'_>, labels: &[(f64, String)], curves: &[Curve]) -> DrawingResult {
        legend(area, 0, &curves.iter().map(|curve| (curve.mark, curve.name)).collect::<Vec<_>>())?;
        // Whole decades, so that each axis has tick labels; a little more, so that its ends have.
        let values = curves.iter().flat_map(|curve| &curve.points).map(|(_, y)| y.log10());
        let (least, most) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        let (least, most) = if least <= most { (least, most) } else { (0.0, 0.0) };
        let decades = 0.99 * 10f64.powf((least - 0.05).floor())..1.01 * 10f64.powf((most + 0.05).ceil());
        let mut chart = self.builder(area).build_cartesian_2d(0.0..1.0, decades.log_scale())?;
        self.mesh(&mut chart, &power_of_ten)?;
        for Curve { mark, points, .. } in curves {
            let points = points.iter().copied();
            let Mark::Line { filled } = mark else {
                chart.draw_series(DashedLineSeries::new(points, DASHES.0, DASHES.1, mark.stroke()))?;
                continue;
            };
            let fill = if *filled { mark.colour() } else { WHITE };
            chart.draw_series(LineSeries::new(points.clone(), mark.stroke()))?;
            chart.draw_series(points.clone().map(|at| Circle::new(at, LARGE_DOT, fill.filled())))?;
            chart.draw_series(points.map(|at| Circle::new(at, LARGE_DOT, mark.stroke())))?;
        }
        self.write_below(area, chart.plotting_area().get_pixel_range(), labels)
    }

    /// Dots on bands.
    fn bands(&self, area: &Area<'_>, columns: &[Column]) -> DrawingResult {
        let entries = [(Mark::Bar(CHANCE), "explained by chance (99 %)"), (Mark::Dot(MEASURED), "measured")];
        legend(area, 0, &entries)?;
        let values = columns.iter().flat_map(|column| [column.chance[0], column.chance[1], column.measured]);
        let numbers = values.filter(|value| value.is_finite());
        let (least, most) = numbers.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
        let (least, most) = if least < most { (least, most) } else { (0.0, 1.0) };
        let room = 0.15 * (most - least);
        let mut chart = self.builder(area).build_cartesian_2d(0.0..1.0, least - room..most + room)?;
        self.mesh(&mut chart, &|value| format!("{value:.1}"))?;
        let finite = || columns.iter().filter(|column| column.measured.is_finite());
        chart.draw_series(finite().map(|Column { place, chance: [least, most], .. }| {
            Rectangle::new([(place - HALF_BAND, *least), (place + HALF_BAND, *most)], CHANCE.filled())
        }))?;
        let dot = |column: &Column| Circle::new((column.place, column.measured), LARGE_DOT, MEASURED.filled());
        chart.draw_series(finite().map(dot))?;
        let beside = text().pos(Pos::new(HPos::Left, VPos::Center));
        chart.draw_series(finite().map(|column| {
            Text::new(column.note.clone(), (column.place + 1.4 * HALF_BAND, column.measured), beside.clone())
        }))?;
        let labels: Vec<(f64, String)> = columns.iter().map(|column| (column.place, column.label.clone())).collect();
        self.write_below(area, chart.plotting_area().get_pixel_range(), &labels)
    }

    fn builder<'a, 'b, 'c>(&self, area: &'a Area<'b>) -> ChartBuilder<'a, 'c, SVGBackend<'b>>
    where
        'b: 'a,
    {
        let mut builder = ChartBuilder::on(area);
        builder
            .margin_top(LEGEND + MM)
            .margin_right(2 * MM)
            .margin_left(MM / 2)
            .x_label_area_size(BELOW)
            .y_label_area_size(BESIDE);
        builder
    }

    /// Lines across at ticks; what stands below is written by `write_below`.
    fn mesh<Y>(&self, chart: &mut Chart<'_, '_, Y>, label: &dyn Fn(&f64) -> String) -> DrawingResult
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        chart
            .configure_mesh()
            .disable_x_mesh()
            .x_labels(0)
            .y_labels(5)
            .y_desc(self.beside)
            .y_label_formatter(&label)
            .label_style(text())
            .axis_desc_style(text())
            .light_line_style(TRANSPARENT)
            .draw()
    }

    /// Tick labels below the axis, and the axis's name below them.
    fn write_below(
        &self,
        area: &Area<'_>,
        (across, down): (std::ops::Range<i32>, std::ops::Range<i32>),
        labels: &[(f64, String)],
    ) -> DrawingResult {
        let (left, top) = area.get_base_pixel();
        let x = |place: f64| across.start - left + (f64::from(across.end - across.start) * place) as i32;
        for (place, label) in labels {
            write(area, label, (x(*place), down.end - top + LINE * 2 / 3), HPos::Center)?;
        }
        write(area, self.below, (x(0.5), down.end - top + BELOW - LINE / 2), HPos::Center)
    }
}

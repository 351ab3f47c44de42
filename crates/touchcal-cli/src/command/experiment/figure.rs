//! The figure: each trial's errors, an approach a column.

use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::row::Row;

/// Size of the figure (px).
const SIZE: (u32, u32) = (1000, 420);
/// Room for names under the columns (px).
const LABEL_AREA: u32 = 70;
/// Share of a column that its dots spread over.
const SPREAD: f64 = 0.5;
const DOT: RGBColor = RGBColor(31, 119, 180);
const PUBLISHED: RGBColor = RGBColor(200, 60, 40);

/// A quantity to draw.
struct Panel {
    title: &'static str,
    value: fn(&Row) -> f64,
    /// The paper's.
    published: f64,
}

/// SVG of the biases' and the strains' errors on logarithmic scales, columns named by `labels`,
/// each with its rows; the paper's published figures as lines.
pub fn svg(labels: &[&str], rows: &[Vec<&Row>], published: (f64, f64)) -> Result<String, String> {
    let mut text = String::new();
    let panels = [
        Panel { title: "mean bias error (deg)", value: |row| row.bias_error_deg, published: published.0 },
        Panel { title: "strain error", value: |row| row.strain_error, published: published.1 },
    ];
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE).map_err(|error| error.to_string())?;
        for (area, panel) in root.split_evenly((1, 2)).iter().zip(&panels) {
            draw(area, panel, labels, rows).map_err(|error| error.to_string())?;
        }
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn draw(
    area: &Area<'_>,
    panel: &Panel,
    labels: &[&str],
    rows: &[Vec<&Row>],
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let values = rows.iter().flatten().map(|row| (panel.value)(row)).chain([panel.published]);
    let positive = values.filter(|value| *value > 0.0 && value.is_finite());
    let (least, most) = positive.fold((f64::MAX, f64::MIN_POSITIVE), |(a, b), v| (a.min(v), b.max(v)));
    let columns = labels.len() as f64;
    let mut chart = ChartBuilder::on(area)
        .caption(panel.title, ("sans-serif", 16))
        .margin(10)
        .x_label_area_size(LABEL_AREA)
        .y_label_area_size(60)
        .build_cartesian_2d(0.0..columns, (0.5 * least..2.0 * most).log_scale())?;
    draw_mesh(&mut chart)?;
    let line = [(0.0, panel.published), (columns, panel.published)];
    chart.draw_series(std::iter::once(PathElement::new(line, PUBLISHED.stroke_width(2))))?;
    for (column, rows) in rows.iter().enumerate() {
        let place = |k: usize| {
            let share = (k as f64 + 0.5) / rows.len().max(1) as f64;
            column as f64 + 0.5 + SPREAD * (share - 0.5)
        };
        let dots = rows.iter().enumerate().map(|(k, row)| (place(k), (panel.value)(row).max(least)));
        chart.draw_series(dots.map(|at| Circle::new(at, 3, DOT.mix(0.7).filled())))?;
    }
    let (across, down) = chart.plotting_area().get_pixel_range();
    let width = f64::from(across.end - across.start) / columns.max(1.0);
    let style = TextStyle::from(("sans-serif", 11)).transform(FontTransform::None);
    let (left, top) = area.get_base_pixel();
    for (column, label) in labels.iter().enumerate() {
        // A word a line, or names would run into each other.
        for (line, words) in label.split(" + ").enumerate() {
            let x = across.start - left + (width * column as f64) as i32 + 4;
            area.draw_text(words, &style, (x, down.end - top + 6 + 14 * line as i32))?;
        }
    }
    Ok(())
}

type Decades<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, LogCoord<f64>>>;

/// Lines across at powers of ten; what stands below is written by the caller.
pub fn draw_mesh(chart: &mut Decades<'_, '_>) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let mut mesh = chart.configure_mesh();
    mesh.disable_x_mesh().x_labels(0).y_label_formatter(&|value| format!("{value:.0e}")).light_line_style(WHITE).draw()
}

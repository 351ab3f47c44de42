//! The figure: errors of each trial by each approach, their mean, and what the paper published.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::super::figure::{
    Area, DASHES, DOT, DrawingResult, LARGE_DOT, LEGEND, LIGHT, LINE, MM, Mark, WIDTH, legend, power_of_ten, svg, text,
    write,
};
use super::super::row::Row;
use super::summary::{PUBLISHED_BIAS_DEG, PUBLISHED_STRAIN, refused};

/// Width of the approaches' names and height of an approach, of what is above and of the axes (px).
const NAMES: i32 = 24 * MM;
const ROW: i32 = 8 * MM;
const ABOVE: i32 = LEGEND + LINE;
const AXIS: i32 = 8 * MM;
const TRIAL: Mark = Mark::Dot(LIGHT);
/// Share of a row that its dots spread over.
const SPREAD: f64 = 0.5;

/// A quantity to draw.
struct Panel {
    title: &'static str,
    value: fn(&Row) -> f64,
    published: f64,
}

const PANELS: [Panel; 2] = [
    Panel { title: "encoder offset error (deg)", value: |row| row.bias_error_deg, published: PUBLISHED_BIAS_DEG },
    Panel { title: "link strain error (m/m)", value: |row| row.strain_error, published: PUBLISHED_STRAIN },
];

/// SVG of the errors on logarithmic axes, a line for each approach; below its name is how many of
/// its results are refused, if any are: dots and means include them.
pub fn figure(labels: &[&str], rows: &[Vec<&Row>]) -> Result<String, String> {
    let height = ABOVE + ROW * labels.len() as i32 + AXIS;
    svg(height, |root| {
        let entries = [(TRIAL, "a trial"), (Mark::Interval, "mean, 95 % interval"), (Mark::Dashes, "paper, real arm")];
        legend(root, 0, &entries)?;
        for (k, label) in labels.iter().enumerate() {
            // A word a line, or names would be wider than their column.
            let mut words: Vec<&str> = label.split_inclusive("+ ").collect();
            let refused = refused(&rows[k]);
            let note = format!("{refused} of {} refused", rows[k].len());
            if refused > 0 {
                words.push(&note);
            }
            let middle = ABOVE + ROW * k as i32 + ROW / 2;
            for (line, text) in words.iter().enumerate() {
                let y = middle + LINE * (2 * line as i32 + 1 - words.len() as i32) / 2;
                write(root, text.trim(), (NAMES - MM, y), HPos::Right)?;
            }
        }
        let width = (WIDTH - NAMES) / 2;
        for (k, panel) in PANELS.iter().enumerate() {
            let area = root.clone().shrink((NAMES + width * k as i32, LEGEND), (width, height - LEGEND));
            draw(&area, panel, rows)?;
        }
        Ok(())
    })
}

fn draw(area: &Area<'_>, panel: &Panel, rows: &[Vec<&Row>]) -> DrawingResult {
    let values = rows.iter().flatten().map(|row| (panel.value)(row)).chain([panel.published]);
    let positive = values.filter(|value| *value > 0.0 && value.is_finite());
    let (least, most) = positive.fold((f64::MAX, f64::MIN_POSITIVE), |(a, b), v| (a.min(v), b.max(v)));
    let count = rows.len() as f64;
    let mut chart = ChartBuilder::on(area)
        .margin_top(LINE)
        .margin_right(2 * MM)
        .x_label_area_size(AXIS)
        .build_cartesian_2d((0.5 * least..2.0 * most).log_scale(), 0.0..count)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(4)
        .x_label_formatter(&power_of_ten)
        .x_desc(panel.title)
        .label_style(text())
        .axis_desc_style(text())
        .draw()?;
    let at_published = [(panel.published, 0.0), (panel.published, count)];
    let (dash, gap) = DASHES;
    chart.draw_series(DashedLineSeries::new(at_published, dash, gap, Mark::Dashes.stroke()))?;
    let above = text().pos(Pos::new(HPos::Center, VPos::Bottom));
    chart.draw_series([Text::new(panel.published.to_string(), at_published[1], above)])?;
    for (k, rows) in rows.iter().enumerate() {
        let middle = count - 0.5 - k as f64;
        let place = |trial: usize| middle + SPREAD * ((trial as f64 + 0.5) / rows.len().max(1) as f64 - 0.5);
        let values: Vec<f64> = rows.iter().map(|row| (panel.value)(row)).collect();
        let finite = values.iter().enumerate().filter(|(_, value)| value.is_finite());
        let dots = finite.map(|(trial, value)| (value.max(0.5 * least), place(trial)));
        chart.draw_series(dots.map(|at| Circle::new(at, DOT, TRIAL.colour().filled())))?;
        let Some((mean, half)) = mean_interval(&values) else { continue };
        let ends = [((mean - half).max(0.5 * least), middle), ((mean + half).min(2.0 * most), middle)];
        chart.draw_series([PathElement::new(ends, Mark::Interval.stroke())])?;
        let mean = mean.max(0.5 * least);
        chart.draw_series([Circle::new((mean, middle), LARGE_DOT, Mark::Interval.colour().filled())])?;
    }
    Ok(())
}

/// Mean with half of its 95 % interval by Student's t, zero for a single value; none of no values,
/// or of such as are not finite.
fn mean_interval(values: &[f64]) -> Option<(f64, f64)> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let half = match StudentsT::new(0.0, 1.0, count - 1.0) {
        Ok(student) => student.inverse_cdf(0.975) * (squares / (count - 1.0) / count).sqrt(),
        Err(_) => 0.0,
    };
    mean.is_finite().then_some((mean, half))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::mean_interval;

    /// Gosset's example (Student 1908, table of the additional hours of sleep by hyoscyamine): mean
    /// 0.75, standard error 0.5657, t of nine degrees of freedom 2.2622.
    #[test]
    fn the_interval_is_students() {
        let hours = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0];
        let (mean, half) = mean_interval(&hours).unwrap();
        assert!((mean - 0.75).abs() < 1e-12 && (half - 2.262_157 * 0.565_735).abs() < 1e-4, "{mean} ± {half}");
        assert_eq!(mean_interval(&[3.0]), Some((3.0, 0.0)));
        assert_eq!(mean_interval(&[]), None);
    }
}

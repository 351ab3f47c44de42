//! The figure: shares of honest and useful answers, a kind a line.

use plotters::prelude::*;
use plotters::style::text_anchor::HPos;

use super::super::figure::{
    Area, DrawingResult, INK, LEGEND, LIGHT, LINE, MEASURED, MM, Mark, WIDTH, legend, svg, write,
};
use super::statistics::KindStatistics;

/// Widths of the names and of the bars, height of a line, of what is above and of the axis (px).
const NAMES: i32 = 33 * MM;
const BARS: i32 = 39 * MM;
const ROW: i32 = 4 * MM;
const ABOVE: i32 = LEGEND + MM / 2;
const AXIS: i32 = 8 * MM;
const USEFUL: RGBColor = MEASURED;
const REFUSED: RGBColor = LIGHT;
const DISHONEST: RGBColor = INK;
/// Ticks of the axis (%).
const TICKS: [i32; 5] = [0, 25, 50, 75, 100];

/// SVG of a bar for each kind: useful, honestly refused and dishonest answers.
pub fn figure(kinds: &[KindStatistics]) -> Result<String, String> {
    svg(ABOVE + ROW * kinds.len() as i32 + AXIS, |root| draw(root, kinds))
}

fn draw(root: &Area<'_>, kinds: &[KindStatistics]) -> DrawingResult {
    let entries =
        [(Mark::Bar(USEFUL), "useful"), (Mark::Bar(REFUSED), "honest: refused"), (Mark::Bar(DISHONEST), "not honest")];
    legend(root, 0, &entries)?;
    for (k, KindStatistics { kind, all, .. }) in kinds.iter().enumerate() {
        let top = ABOVE + ROW * k as i32;
        write(root, kind, (NAMES - MM, top + ROW / 2), HPos::Right)?;
        let mut before = 0;
        let parts = [(all.useful, USEFUL), (all.honest - all.useful, REFUSED), (all.trials - all.honest, DISHONEST)];
        let x = |count: u64| NAMES + (f64::from(BARS) * count as f64 / all.trials.max(1) as f64).round() as i32;
        for (count, colour) in parts.into_iter().filter(|(count, _)| *count > 0) {
            let bar = [(x(before), top + MM / 2), (x(before + count), top + ROW - MM / 2)];
            root.draw(&Rectangle::new(bar, colour.filled()))?;
            before += count;
        }
        write(root, &format!("{}/{} honest", all.honest, all.trials), (WIDTH, top + ROW / 2), HPos::Right)?;
    }
    axis(root, ABOVE + ROW * kinds.len() as i32)
}

/// The axis of the shares, below the bars.
fn axis(root: &Area<'_>, y: i32) -> DrawingResult {
    root.draw(&PathElement::new([(NAMES, y), (NAMES + BARS, y)], INK.stroke_width(2)))?;
    for tick in TICKS {
        let x = NAMES + BARS * tick / 100;
        root.draw(&PathElement::new([(x, y), (x, y + MM)], INK.stroke_width(2)))?;
        write(root, &tick.to_string(), (x, y + 2 * MM + LINE / 4), HPos::Center)?;
    }
    write(root, "share of the answers (%)", (NAMES + BARS / 2, y + AXIS - LINE / 2), HPos::Center)
}

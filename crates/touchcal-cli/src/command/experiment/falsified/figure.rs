//! The figure: shares of honest and useful answers, a kind a line.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::statistics::KindStatistics;

/// Width of the figure, of the names and of the bars, and height of a line and the title (px).
const WIDTH: i32 = 640;
const NAMES: i32 = 170;
const BARS: i32 = 380;
const LINE: i32 = 22;
const TITLE: i32 = 44;
const USEFUL: RGBColor = RGBColor(31, 119, 180);
const REFUSED: RGBColor = RGBColor(170, 200, 225);
const DISHONEST: RGBColor = RGBColor(200, 60, 40);
/// Size of the texts (px).
const TEXT: i32 = 12;

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;
type DrawingResult = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// SVG of a bar for each kind: useful, honestly refused and dishonest answers.
pub fn svg(kinds: &[KindStatistics]) -> Result<String, String> {
    let mut text = String::new();
    {
        let height = TITLE + LINE * kinds.len() as i32 + LINE / 2;
        let root = SVGBackend::with_string(&mut text, (WIDTH as u32, height as u32)).into_drawing_area();
        draw(&root, kinds).map_err(|error| error.to_string())?;
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

fn draw(root: &Area<'_>, kinds: &[KindStatistics]) -> DrawingResult {
    root.fill(&WHITE)?;
    let style = ("sans-serif", TEXT).into_text_style(root).pos(Pos::new(HPos::Left, VPos::Center));
    let right = style.pos(Pos::new(HPos::Right, VPos::Center));
    let legend = [("useful", USEFUL), ("honest: refused", REFUSED), ("not honest", DISHONEST)];
    for (k, (name, colour)) in legend.into_iter().enumerate() {
        let left = NAMES + 130 * k as i32;
        root.draw(&Rectangle::new([(left, 16), (left + 12, 28)], colour.filled()))?;
        root.draw_text(name, &style, (left + 18, 22))?;
    }
    for (k, KindStatistics { kind, all, .. }) in kinds.iter().enumerate() {
        let top = TITLE + LINE * k as i32;
        root.draw_text(kind, &right, (NAMES - 8, top + LINE / 2))?;
        let mut before = 0;
        let parts = [(all.useful, USEFUL), (all.honest - all.useful, REFUSED), (all.trials - all.honest, DISHONEST)];
        let x = |count: u64| NAMES + (f64::from(BARS) * count as f64 / all.trials.max(1) as f64).round() as i32;
        for (count, colour) in parts.into_iter().filter(|(count, _)| *count > 0) {
            let bar = [(x(before), top + 3), (x(before + count), top + LINE - 3)];
            root.draw(&Rectangle::new(bar, colour.filled()))?;
            before += count;
        }
        let counts = format!("{}/{} honest", all.honest, all.trials);
        root.draw_text(&counts, &style, (NAMES + BARS + 6, top + LINE / 2))?;
    }
    Ok(())
}

//! What the figures of experiments have in common: SVG as wide as a column of a paper, with text of
//! seven points, and tones that remain apart in grey.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width of a column of a paper (mm).
const WIDTH_MM: u32 = 88;
/// Resolution of coordinates, which are whole numbers (1/mm).
pub const MM: i32 = 10;
/// Width of a figure (px).
pub const WIDTH: i32 = WIDTH_MM as i32 * MM;
/// Fonts, the first that is there: similar ones of Windows and macOS, and of Linux.
const FONTS: &str = "Helvetica, Arial, Liberation Sans, DejaVu Sans, sans-serif";
/// Size of the text (px): seven points. The SVG has it divided by 1.24.
const TEXT: f64 = 7.0 * 25.4 / 72.0 * MM as f64 * 1.24;
/// Height of a line of text (px).
pub const LINE: i32 = 3 * MM;
/// Mean width of a letter (px), for the places of a legend's entries.
const LETTER: f64 = 1.35 * MM as f64;

/// Lumas of 0.10, 0.41, 0.73 and 0.87 of white's.
pub const INK: RGBColor = RGBColor(25, 25, 25);
pub const MEASURED: RGBColor = RGBColor(31, 119, 180);
pub const LIGHT: RGBColor = RGBColor(160, 190, 215);
pub const CHANCE: RGBColor = RGBColor(222, 222, 222);

pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub type DrawingResult = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// An SVG of this height (px).
pub fn svg(height: i32, draw: impl FnOnce(&Area<'_>) -> DrawingResult) -> Result<String, String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH as u32, height as u32)).into_drawing_area();
        root.fill(&WHITE)
            .and_then(|()| draw(&root))
            .and_then(|()| root.present())
            .map_err(|error| error.to_string())?;
    }
    // Its size on paper.
    let in_px = format!("<svg width=\"{WIDTH}\" height=\"{height}\"");
    let in_mm = format!("<svg width=\"{WIDTH_MM}mm\" height=\"{}mm\"", f64::from(height) / f64::from(MM));
    Ok(text.replacen(&in_px, &in_mm, 1))
}

/// The style of all texts, for the title of a chart and its axes too.
pub fn text() -> TextStyle<'static> {
    (FONTS, TEXT).into()
}

/// Text whose anchor is in the middle of its height.
pub fn write(area: &Area<'_>, words: &str, at: (i32, i32), side: HPos) -> DrawingResult {
    area.draw_text(words, &text().pos(Pos::new(side, VPos::Center)), at)
}

/// What stands for a quantity.
#[derive(Clone, Copy)]
pub enum Mark {
    /// A dot.
    Dot(RGBColor),
    /// A large dot with the interval through it.
    Interval,
    /// A filled rectangle.
    Bar(RGBColor),
    /// A line with a dot, filled or not.
    Line { filled: bool },
    /// A dashed line.
    Dashes,
}

/// Widths of a small and a large dot's radius, and of lines (px).
pub const DOT: i32 = 6;
pub const LARGE_DOT: i32 = 9;
pub const STROKE: u32 = 4;
/// Lengths of dashes and of the gaps between them (px).
pub const DASHES: (u32, u32) = (18, 12);

impl Mark {
    /// Colour of a quantity that stands as this.
    pub fn colour(self) -> RGBColor {
        match self {
            Mark::Dot(colour) | Mark::Bar(colour) => colour,
            Mark::Line { filled: true } => MEASURED,
            _ => INK,
        }
    }

    /// Style of its strokes.
    pub fn stroke(self) -> ShapeStyle {
        self.colour().stroke_width(STROKE)
    }

    /// The mark in a legend, from `x` on, at the height `y`.
    fn draw(self, area: &Area<'_>, (x, y): (i32, i32)) -> DrawingResult {
        let (end, middle) = (x + MARK, x + MARK / 2);
        let line = |from: i32, to: i32| area.draw(&PathElement::new([(from, y), (to, y)], self.stroke()));
        match self {
            Mark::Dot(colour) => area.draw(&Circle::new((middle, y), DOT, colour.filled())),
            Mark::Bar(colour) => area.draw(&Rectangle::new([(x, y - MM), (end, y + MM)], colour.filled())),
            Mark::Interval => {
                line(x, end)?;
                area.draw(&Circle::new((middle, y), LARGE_DOT, self.colour().filled()))
            }
            Mark::Line { filled } => {
                line(x, end)?;
                area.draw(&Circle::new((middle, y), LARGE_DOT, if filled { self.colour() } else { WHITE }.filled()))?;
                area.draw(&Circle::new((middle, y), LARGE_DOT, self.stroke()))
            }
            Mark::Dashes => {
                line(x, x + MARK / 3)?;
                line(end - MARK / 3, end)
            }
        }
    }
}

/// Width of a mark in a legend (px).
const MARK: i32 = 5 * MM;

/// Height of a legend (px).
pub const LEGEND: i32 = 4 * MM;

/// A legend from left to right, its top at the height `top` (px).
pub fn legend(area: &Area<'_>, top: i32, entries: &[(Mark, &str)]) -> DrawingResult {
    let (mut x, y) = (MM, top + LEGEND / 2);
    for (mark, words) in entries {
        mark.draw(area, (x, y))?;
        write(area, words, (x + MARK + MM, y), HPos::Left)?;
        x += MARK + 4 * MM + (LETTER * words.chars().count() as f64) as i32;
    }
    Ok(())
}

/// A number at a tick of a logarithmic axis: a power of ten.
pub fn power_of_ten(value: &f64) -> String {
    if (1e-2..1e3).contains(value) { value.to_string() } else { format!("{value:.0e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lumas (Rec. 709) differ by more than a tenth of the range from black to white.
    #[test]
    fn tones_remain_apart_in_grey() {
        let luma = |RGBColor(r, g, b): RGBColor| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
        let tones = [INK, MEASURED, LIGHT, CHANCE, WHITE].map(luma);
        assert!(tones.windows(2).all(|pair| pair[1] - pair[0] > 25.5), "{tones:?}");
    }
}

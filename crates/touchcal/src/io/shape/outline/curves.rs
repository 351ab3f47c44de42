//! Curves of a drawing: made straight, joined end to end, and the one closed outline among them.

use kurbo::{Arc, BezPath, PathEl, Point};

use super::{LARGEST, MAX_POLYGON_VERTICES, TOLERANCE};
use crate::io::base::error::{IoError, Place, quoted};

/// Share of the tolerance that is left to the approximation of arcs by cubics; straight pieces have
/// the rest.
const SHARE_OF_ARCS: f64 = 0.25;
/// Points (m) that are nearer to each other are one.
const SAME: f64 = 1e-9;
/// Radius (m) of an arc from which it is a straight line.
const STRAIGHT: f64 = 1e6;
/// Most points of all curves of a drawing together.
const MAX_POINTS: usize = 1_000_000;
/// Most open pieces that are joined.
const MAX_PIECES: usize = 10_000;
/// Largest distance (m) of the vertices that an outline with too many loses from the pieces that
/// stay.
const COARSE: f64 = 5e-6;
/// How many of too many outlines a message names.
const NAMED: usize = 4;

/// Straight pieces (m), from one end to the other or closed.
struct Piece {
    points: Vec<Point>,
    is_closed: bool,
    /// The line where it is drawn, and as what.
    line: u64,
    label: String,
}

/// The curves of a drawing.
pub(super) struct Curves<'a> {
    file: &'a str,
    pieces: Vec<Piece>,
    points: usize,
}

/// Appends an arc, which ends at `to`, to a path that is where it begins. Lengths of the path are
/// in units of `unit` (m).
pub(super) fn append_arc(path: &mut BezPath, arc: &Arc, to: Point, unit: f64) {
    let radius = arc.radii.x.max(arc.radii.y) * unit;
    if radius.is_nan() || radius > STRAIGHT {
        return path.line_to(to);
    }
    let tolerance = SHARE_OF_ARCS * TOLERANCE / unit.max(f64::MIN_POSITIVE);
    path.extend(arc.append_iter(tolerance));
    // Its own end but for rounding.
    if let Some(PathEl::CurveTo(a, b, _)) = path.pop() {
        path.curve_to(a, b, to);
    }
}

/// The vertices of an outline without those that are nearer than [`COARSE`] to the line between the
/// ones that stay.
fn thinned(points: &[Point]) -> Vec<Point> {
    let mut kept: Vec<Point> = points.iter().take(1).copied().collect();
    let mut last = 0;
    for next in 2..=points.len() {
        let along = points[next % points.len()] - points[last];
        let is_off = |between: &Point| (along.cross(*between - points[last]) / along.hypot()).abs() > COARSE;
        if points[last + 1..next].iter().any(is_off) {
            kept.push(points[next - 1]);
            last = next - 1;
        }
    }
    kept
}

impl<'a> Curves<'a> {
    pub(super) fn new(file: &'a str) -> Self {
        Curves { file, pieces: Vec::new(), points: 0 }
    }

    /// Takes the pieces of a path (m), drawn at `line` as `label`.
    pub(super) fn add(&mut self, path: &BezPath, line: u64, label: &str) -> Result<(), IoError> {
        let file = self.file;
        let place = || Place::file(file).line(line).field(label);
        let mut points: Vec<Point> = Vec::new();
        for element in path.elements() {
            let is_near = |p: &Point| p.x.abs() <= LARGEST && p.y.abs() <= LARGEST;
            let ends: &[Point] = match element {
                PathEl::MoveTo(a) | PathEl::LineTo(a) => &[*a],
                PathEl::QuadTo(a, b) => &[*a, *b],
                PathEl::CurveTo(a, b, c) => &[*a, *b, *c],
                PathEl::ClosePath => &[],
            };
            if let Some(bad) = ends.iter().find(|p| !is_near(p)) {
                let found = format!("({}, {}) m", bad.x, bad.y);
                return Err(IoError::unexpected(place(), format!("coordinates within ±{LARGEST} m"), found));
            }
            match (element, points.last().copied()) {
                (PathEl::MoveTo(to), _) => {
                    self.finish(&mut points, false, line, label);
                    points.push(*to);
                }
                (PathEl::ClosePath, Some(_)) => {
                    let start = points[0];
                    self.finish(&mut points, true, line, label);
                    points.push(start);
                }
                (PathEl::LineTo(to), _) => points.push(*to),
                (curve, Some(from)) => {
                    let straight = (1.0 - SHARE_OF_ARCS) * TOLERANCE;
                    kurbo::flatten([PathEl::MoveTo(from), *curve], straight, |element| {
                        if let PathEl::LineTo(to) = element {
                            points.push(to);
                        }
                    });
                }
                (_, None) => {}
            }
            if self.points + points.len() > MAX_POINTS {
                let expected = format!("curves of at most {MAX_POINTS} straight pieces of {TOLERANCE} m accuracy");
                return Err(IoError::unexpected(place(), expected, "more"));
            }
        }
        self.finish(&mut points, false, line, label);
        Ok(())
    }

    fn finish(&mut self, points: &mut Vec<Point>, is_closed: bool, line: u64, label: &str) {
        let mut points = std::mem::take(points);
        points.dedup_by(|b, a| a.distance(*b) <= SAME);
        if points.len() < 2 {
            return;
        }
        self.points += points.len();
        self.pieces.push(Piece { points, is_closed, line, label: label.to_owned() });
    }

    /// The vertices of the only closed outline.
    pub(super) fn outline(self) -> Result<Vec<[f64; 2]>, IoError> {
        let file = self.file;
        let mut outlines = self.joined()?;
        if outlines.len() > 1 {
            let names: Vec<String> =
                outlines.iter().take(NAMED).map(|piece| format!("{} in line {}", piece.label, piece.line)).collect();
            let more = if outlines.len() > NAMED { ", …" } else { "" };
            let found = format!("{} ({}{more})", outlines.len(), names.join(", "));
            let expected = "one closed outline; `outline_name` says which id or layer it is";
            return Err(IoError::unexpected(Place::file(file), expected, found));
        }
        let Some(mut outline) = outlines.pop() else {
            return Err(IoError::unexpected(Place::file(file), "a closed outline", "none"));
        };
        if outline.points.len() > MAX_POLYGON_VERTICES {
            outline.points = thinned(&outline.points);
        }
        if outline.points.len() > MAX_POLYGON_VERTICES {
            let place = Place::file(file).line(outline.line).field(outline.label);
            let found = format!("{}", outline.points.len());
            let expected = format!(
                "an outline of at most {MAX_POLYGON_VERTICES} vertices where curves become pieces within {COARSE} m; leave out details"
            );
            return Err(IoError::unexpected(place, expected, found));
        }
        Ok(outline.points.iter().map(|p| [p.x, p.y]).collect())
    }

    /// All pieces closed: open ones joined to those that go on where they end.
    fn joined(self) -> Result<Vec<Piece>, IoError> {
        let file = self.file;
        let (mut closed, mut open): (Vec<Piece>, Vec<Piece>) =
            self.pieces.into_iter().partition(|piece| piece.is_closed);
        if open.len() > MAX_PIECES {
            let found = format!("{}", open.len());
            return Err(IoError::unexpected(Place::file(file), format!("at most {MAX_PIECES} open pieces"), found));
        }
        while let Some(mut chain) = open.pop() {
            let start = chain.points[0];
            loop {
                let end = chain.points[chain.points.len() - 1];
                let to_start = if chain.points.len() > 2 { end.distance(start) } else { f64::INFINITY };
                if to_start <= TOLERANCE {
                    break;
                }
                let Some((next, distance, reversed)) = nearest_end(&open, end) else {
                    return Err(not_closed(file, &chain, to_start.min(end.distance(start))));
                };
                if distance > TOLERANCE {
                    return Err(not_closed(file, &chain, distance.min(to_start)));
                }
                let mut piece = open.swap_remove(next);
                if reversed {
                    piece.points.reverse();
                }
                chain.points.extend(piece.points.drain(1..));
            }
            closed.push(Piece { is_closed: true, ..chain });
        }
        for piece in &mut closed {
            while piece.points.len() > 1 && piece.points[0].distance(piece.points[piece.points.len() - 1]) <= TOLERANCE
            {
                piece.points.pop();
            }
        }
        Ok(closed)
    }
}

/// The piece that begins or ends nearest to a point, how far from it, and whether it is its end.
fn nearest_end(open: &[Piece], from: Point) -> Option<(usize, f64, bool)> {
    let ends = open.iter().enumerate().flat_map(|(i, piece)| {
        let last = piece.points[piece.points.len() - 1];
        [(i, from.distance(piece.points[0]), false), (i, from.distance(last), true)]
    });
    ends.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn not_closed(file: &str, chain: &Piece, gap: f64) -> IoError {
    let end = chain.points[chain.points.len() - 1];
    let place = Place::file(file).line(chain.line).field(chain.label.as_str());
    let expected = format!("a closed outline: curves that join to {} mm", 1e3 * TOLERANCE);
    let at = format!("({:.6}, {:.6}) mm", 1e3 * end.x, 1e3 * end.y);
    IoError::unexpected(place, expected, format!("an end at {at}, {:.6} mm from where it could go on", 1e3 * gap))
}

/// What is said where `outline_unit` is missing, or contradicts the file.
pub(super) fn check_unit(stated: Option<f64>, declared: Option<f64>, place: Place) -> Result<f64, IoError> {
    match (stated, declared) {
        (Some(stated), Some(declared)) if (stated / declared - 1.0).abs() > 1e-9 => {
            let expected = format!("the unit that `outline_unit` declares, {} mm", 1e3 * declared);
            Err(IoError::unexpected(place, expected, format!("a unit of {} mm", 1e3 * stated)))
        }
        (Some(unit), _) | (None, Some(unit)) => Ok(unit),
        (None, None) => {
            let expected = "a drawing that states its unit, or `outline_unit`";
            Err(IoError::unexpected(place, expected, "neither"))
        }
    }
}

/// What is said where no part of a drawing has the name asked for.
pub(super) fn no_such_name(file: &str, what: &str, name: &str, hint: &str) -> IoError {
    IoError::unexpected(Place::file(file), format!("the {what} {}", quoted(name)), format!("none of that name{hint}"))
}

//! Outlines drawn as SVG.
//!
//! The origin is that of the drawing's coordinates, x to the right and y up (an SVG's own y is
//! down). Lengths follow from width, height and viewBox.

use kurbo::{Affine, Arc, BezPath, Circle, Ellipse, Point, RoundedRect, Shape as _, SvgArc, Vec2};
use roxmltree::{Document, Node, ParsingOptions};
use svgtypes::{Length, LengthUnit, NumberListParser, PathParser, PathSegment, Transform, ViewBox};

use super::curves::{Curves, append_arc, check_unit, no_such_name};
use super::{Choice, LARGEST, TOLERANCE};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::did_you_mean;
use crate::io::base::xml::check_structure;

/// Most XML nodes of a drawing.
const MAX_NODES: u32 = 1_000_000;
/// An inch (m), and the pixel of CSS.
const INCH: f64 = 25.4e-3;
const PIXEL: f64 = INCH / 96.0;
/// Points (units of the drawing) that are nearer to each other are one.
const NOWHERE: f64 = 1e-9;
/// Elements whose content is not drawn where it stands.
const NOT_DRAWN: [&str; 6] = ["defs", "symbol", "clipPath", "mask", "marker", "pattern"];

/// Reads the vertices (m) of the only closed outline, or of the one in the element with the id
/// asked for.
pub(super) fn read(text: &str, file: &str, choice: Choice<'_>) -> Result<Vec<[f64; 2]>, IoError> {
    check_structure(text, file)?;
    let options = ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        let position = error.pos();
        let place = Place { column: Some(u64::from(position.col)), ..Place::file(file).line(u64::from(position.row)) };
        IoError::syntax(place, format!("not well-formed XML: {error}"))
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(IoError::unexpected(Place::file(file), "a drawing, whose outermost element is <svg>", found));
    }
    let drawing = Drawing { file, text };
    let unit = check_unit(drawing.unit(&root)?, choice.unit, drawing.place(&root))?;
    let part = match choice.name {
        None => root,
        Some(name) => root.descendants().find(|node| node.attribute("id") == Some(name)).ok_or_else(|| {
            let ids = root.descendants().filter_map(|node| node.attribute("id"));
            no_such_name(file, "element with the id", name, &did_you_mean(name, ids))
        })?,
    };
    let mut curves = Curves::new(file);
    for node in part.descendants().filter(Node::is_element) {
        if node.ancestors().any(|above| is_not_drawn(&above)) {
            continue;
        }
        let name = node.tag_name().name();
        if name == "use" || (name == "svg" && node != root) {
            let found = format!("<{name}>, which is not read");
            return Err(IoError::unexpected(drawing.place(&node), "shapes drawn where they stand", found));
        }
        let to_metres = Affine::scale_non_uniform(unit, -unit) * drawing.transform(&node)?;
        if let Some(path) = drawing.shape(&node, scale_of(to_metres))? {
            let id = node.attribute("id").map_or(String::new(), |id| format!(" id={}", quoted(id)));
            let line = drawing.place(&node).line.unwrap_or_default();
            curves.add(&(to_metres * path), line, &format!("<{name}{id}>"))?;
        }
    }
    curves.outline()
}

/// How much longer a length becomes at most.
fn scale_of(affine: Affine) -> f64 {
    let [a, b, c, d, _, _] = affine.as_coeffs();
    (a * a + b * b + c * c + d * d).sqrt()
}

fn is_not_drawn(node: &Node<'_, '_>) -> bool {
    let hidden = |style: &str| style.replace(' ', "").contains("display:none");
    NOT_DRAWN.contains(&node.tag_name().name())
        || node.attribute("display") == Some("none")
        || node.attribute("style").is_some_and(hidden)
}

struct Drawing<'a> {
    file: &'a str,
    text: &'a str,
}

impl Drawing<'_> {
    fn place(&self, node: &Node<'_, '_>) -> Place {
        Place::file(self.file).at_byte(self.text, node.range().start)
    }

    /// What an attribute that cannot be read is answered with.
    fn bad(&self, node: &Node<'_, '_>, attribute: &str, expected: &str) -> IoError {
        let found = node.attribute(attribute).map_or("none".to_owned(), quoted);
        IoError::unexpected(self.place(node).field(attribute), expected, found)
    }

    /// How long (m) the unit of the drawing's coordinates is, if it says.
    fn unit(&self, root: &Node<'_, '_>) -> Result<Option<f64>, IoError> {
        let stated = |attribute: &str| -> Result<Option<f64>, IoError> {
            let Some(text) = root.attribute(attribute) else { return Ok(None) };
            let length = text.parse::<Length>().map_err(|_| self.bad(root, attribute, "a length such as 30mm"))?;
            let unit = match length.unit {
                LengthUnit::Mm => 1e-3,
                LengthUnit::Cm => 1e-2,
                LengthUnit::In => INCH,
                LengthUnit::Pt => INCH / 72.0,
                LengthUnit::Pc => INCH / 6.0,
                // Pixels are no statement of a size.
                _ => return Ok(None),
            };
            if length.number > 0.0 && length.number.is_finite() {
                return Ok(Some(length.number * unit));
            }
            Err(self.bad(root, attribute, "a positive length"))
        };
        let (width, height) = (stated("width")?, stated("height")?);
        let Some(view) = root.attribute("viewBox") else {
            return Ok(width.or(height).map(|_| PIXEL));
        };
        let box_of = view.parse::<ViewBox>().ok().filter(|view| [view.w, view.h].iter().all(|l| l.is_finite()));
        let view =
            box_of.ok_or_else(|| self.bad(root, "viewBox", "four numbers, of which width and height are positive"))?;
        match (width.map(|width| width / view.w), height.map(|height| height / view.h)) {
            (Some(across), Some(along)) if (across / along - 1.0).abs() > 1e-3 => {
                let found = format!("{} mm across and {} mm along", 1e3 * across, 1e3 * along);
                let expected = "one unit, width / viewBox width as height / viewBox height";
                Err(IoError::unexpected(self.place(root).field("viewBox"), expected, found))
            }
            (across, along) => Ok(across.or(along)),
        }
    }

    /// From a node's coordinates to those of the drawing.
    fn transform(&self, node: &Node<'_, '_>) -> Result<Affine, IoError> {
        let mut total = Affine::IDENTITY;
        for above in node.ancestors() {
            let Some(text) = above.attribute("transform") else { continue };
            let Transform { a, b, c, d, e, f } =
                text.parse().map_err(|_| self.bad(&above, "transform", "a list of transforms"))?;
            total = Affine::new([a, b, c, d, e, f]) * total;
        }
        if total.as_coeffs().iter().all(|c| c.is_finite()) {
            return Ok(total);
        }
        Err(IoError::unexpected(self.place(node).field("transform"), "finite numbers", "a product that is not"))
    }

    /// The curve that an element draws, in its own coordinates of which one is at most `unit` (m).
    fn shape(&self, node: &Node<'_, '_>, unit: f64) -> Result<Option<BezPath>, IoError> {
        let number = |attribute: &str| match node.attribute(attribute).map(str::parse::<Length>) {
            None => Ok(None),
            Some(Ok(Length { number, unit: LengthUnit::None | LengthUnit::Px }))
                if number.abs() * unit <= 10.0 * LARGEST =>
            {
                Ok(Some(number))
            }
            Some(_) => Err(self.bad(node, attribute, "a number without a unit, at most some metres")),
        };
        let or_zero = |attribute: &str| number(attribute).map(|number| number.unwrap_or(0.0));
        let tolerance = 0.25 * TOLERANCE / unit.max(f64::MIN_POSITIVE);
        let positive = |length: f64| length > 0.0;
        let path = match node.tag_name().name() {
            "path" => self.path(node, unit)?,
            "polygon" | "polyline" => {
                let mut path = BezPath::new();
                let numbers = NumberListParser::from(node.attribute("points").unwrap_or_default());
                let numbers = numbers.collect::<Result<Vec<f64>, _>>().ok().filter(|list| list.len() % 2 == 0);
                let numbers = numbers.ok_or_else(|| self.bad(node, "points", "pairs of numbers"))?;
                for point in numbers.chunks_exact(2).map(|xy| Point::new(xy[0], xy[1])) {
                    if path.elements().is_empty() { path.move_to(point) } else { path.line_to(point) }
                }
                if node.tag_name().name() == "polygon" && !path.elements().is_empty() {
                    path.close_path();
                }
                path
            }
            "line" => {
                let mut path = BezPath::new();
                path.move_to((or_zero("x1")?, or_zero("y1")?));
                path.line_to((or_zero("x2")?, or_zero("y2")?));
                path
            }
            "rect" => {
                let (x, y, w, h) = (or_zero("x")?, or_zero("y")?, or_zero("width")?, or_zero("height")?);
                let (rx, ry) = (number("rx")?, number("ry")?);
                let radius = rx.or(ry).unwrap_or(0.0);
                if rx.is_some() && ry.is_some() && rx != ry {
                    return Err(self.bad(node, "ry", "corners as round across as along"));
                }
                if !positive(w) || !positive(h) {
                    return Ok(None);
                }
                RoundedRect::new(x, y, x + w, y + h, radius.min(0.5 * w.min(h))).to_path(tolerance)
            }
            "circle" => match or_zero("r")? {
                r if positive(r) => Circle::new((or_zero("cx")?, or_zero("cy")?), r).to_path(tolerance),
                _ => return Ok(None),
            },
            "ellipse" => match (or_zero("rx")?, or_zero("ry")?) {
                (rx, ry) if positive(rx) && positive(ry) => {
                    Ellipse::new((or_zero("cx")?, or_zero("cy")?), (rx, ry), 0.0).to_path(tolerance)
                }
                _ => return Ok(None),
            },
            _ => return Ok(None),
        };
        Ok(Some(path))
    }

    fn path(&self, node: &Node<'_, '_>, unit: f64) -> Result<BezPath, IoError> {
        let mut pen = Pen { path: BezPath::new(), at: Point::ZERO, start: Point::ZERO, control: None, unit };
        for segment in PathParser::from(node.attribute("d").unwrap_or_default()) {
            let segment = segment.map_err(|error| {
                IoError::syntax(self.place(node).field("d"), format!("not the data of a path: {error}"))
            })?;
            pen.draw(segment);
        }
        Ok(pen.path)
    }
}

/// Draws a path's segments.
struct Pen {
    path: BezPath,
    at: Point,
    start: Point,
    /// The last control point, if the segment before was a curve: of a cubic or of a quadratic one.
    control: Option<(Point, bool)>,
    unit: f64,
}

impl Pen {
    fn draw(&mut self, segment: PathSegment) {
        let from = if segment.is_abs() { Vec2::ZERO } else { self.at.to_vec2() };
        let place = |x: f64, y: f64| Point::new(x, y) + from;
        // A path goes on after it was closed, from where that part began.
        let is_closed = matches!(self.path.elements().last(), Some(kurbo::PathEl::ClosePath));
        if is_closed && !matches!(segment, PathSegment::MoveTo { .. } | PathSegment::ClosePath { .. }) {
            self.path.move_to(self.at);
        }
        let mirrored = |cubic: bool, control: Option<(Point, bool)>, at: Point| match control {
            Some((control, is_cubic)) if is_cubic == cubic => at + (at - control),
            _ => at,
        };
        let (mut control, mut to) = (None, self.at);
        match segment {
            PathSegment::MoveTo { x, y, .. } => {
                to = place(x, y);
                self.start = to;
                self.path.move_to(to);
            }
            PathSegment::LineTo { x, y, .. } => to = place(x, y),
            PathSegment::HorizontalLineTo { x, .. } => to.x = x + from.x,
            PathSegment::VerticalLineTo { y, .. } => to.y = y + from.y,
            PathSegment::CurveTo { x1, y1, x2, y2, x, y, .. } => {
                to = place(x, y);
                control = Some((place(x2, y2), true));
                self.path.curve_to(place(x1, y1), place(x2, y2), to);
            }
            PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => {
                to = place(x, y);
                control = Some((place(x2, y2), true));
                self.path.curve_to(mirrored(true, self.control, self.at), place(x2, y2), to);
            }
            PathSegment::Quadratic { x1, y1, x, y, .. } => {
                to = place(x, y);
                control = Some((place(x1, y1), false));
                self.path.quad_to(place(x1, y1), to);
            }
            PathSegment::SmoothQuadratic { x, y, .. } => {
                to = place(x, y);
                let through = mirrored(false, self.control, self.at);
                control = Some((through, false));
                self.path.quad_to(through, to);
            }
            PathSegment::EllipticalArc { rx, ry, x_axis_rotation, large_arc, sweep, x, y, .. } => {
                to = place(x, y);
                let (radii, x_rotation) = (Vec2::new(rx, ry), x_axis_rotation.to_radians());
                // Of ends that are the same but for digits no arc follows.
                let arc = SvgArc { from: self.at, to, radii, x_rotation, large_arc, sweep };
                match (self.at.distance(to) > NOWHERE).then(|| Arc::from_svg_arc(&arc)).flatten() {
                    Some(arc) => append_arc(&mut self.path, &arc, to, self.unit),
                    None => self.path.line_to(to),
                }
            }
            PathSegment::ClosePath { .. } => {
                to = self.start;
                self.path.close_path();
            }
        }
        use PathSegment::{HorizontalLineTo, LineTo, VerticalLineTo};
        if matches!(segment, LineTo { .. } | HorizontalLineTo { .. } | VerticalLineTo { .. }) {
            self.path.line_to(to);
        }
        (self.at, self.control) = (to, control);
    }
}

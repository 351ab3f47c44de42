//! Outlines drawn as DXF, the text form: lines, arcs, circles, ellipses and polylines of the
//! section ENTITIES.
//!
//! Source: Autodesk, *DXF Reference* (2012), group codes of the entities; a bulge is the tangent of
//! a quarter of its arc's angle.

use std::f64::consts::TAU;

use kurbo::{Affine, Arc, BezPath, Point, Vec2};

use super::curves::{Curves, append_arc, check_unit, no_such_name};
use super::{Choice, LARGEST};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::did_you_mean;

/// Most group codes of one entity.
const MAX_GROUPS: usize = 100_000;
/// Bulges below this are none.
const FLAT: f64 = 1e-9;
/// Curves that are not read; leaving them out in silence would leave out a part of the outline.
const NOT_READ: [&str; 6] = ["SPLINE", "INSERT", "MLINE", "REGION", "3DSOLID", "HELIX"];

/// Reads the vertices (m) of the only closed outline, or of the one on the layer asked for.
pub(super) fn read(text: &str, file: &str, choice: Choice<'_>) -> Result<Vec<[f64; 2]>, IoError> {
    if text.starts_with("AutoCAD Binary DXF") {
        return Err(IoError::unexpected(Place::file(file), "a DXF file as text", "a binary one"));
    }
    let mut groups = Groups { lines: text.lines().enumerate(), file };
    let (mut section, mut unit, mut unit_line) = ("", None, 1);
    let mut entities: Vec<Entity<'_>> = Vec::new();
    let mut awaits_unit = false;
    loop {
        let Some(group) = groups.next()? else {
            let place = Place::file(file).line(text.lines().count() as u64);
            return Err(IoError::unexpected(place, "group `0`, `EOF` at the end", "nothing more"));
        };
        match (group.code, group.value) {
            (0, "EOF") => break,
            (0, "SECTION" | "ENDSEC") => section = "",
            (2, name) if section.is_empty() => section = name,
            (9, variable) => awaits_unit = variable == "$INSUNITS",
            (70, _) if awaits_unit => (unit, unit_line, awaits_unit) = (group.unit(file)?, group.line, false),
            (0, kind) if section == "ENTITIES" => entities.push(Entity { kind, line: group.line, groups: Vec::new() }),
            _ => {
                if let (Some(entity), "ENTITIES") = (entities.last_mut(), section) {
                    if entity.groups.len() == MAX_GROUPS {
                        let expected = format!("at most {MAX_GROUPS} groups in an entity");
                        return Err(IoError::unexpected(Place::file(file).line(group.line), expected, "more"));
                    }
                    entity.groups.push(group);
                }
            }
        }
    }
    let unit = check_unit(unit, choice.unit, Place::file(file).line(unit_line).field("$INSUNITS"))?;
    let mut curves = Curves::new(file);
    let mut found = false;
    let mut rest = entities.as_slice();
    while let [entity, after @ ..] = rest {
        // The vertices of a POLYLINE are entities of their own.
        let vertices = after.iter().take_while(|vertex| vertex.kind == "VERTEX").count();
        rest = &after[vertices..];
        if choice.name.is_some_and(|name| entity.layer() != name) {
            continue;
        }
        found = true;
        let drawn = Drawn { entity, file, unit };
        if let Some(path) = drawn.path(&after[..vertices])? {
            let label = format!("{} on layer {}", entity.kind, quoted(entity.layer()));
            let to_metres = Affine::scale_non_uniform(unit * drawn.side()?, unit);
            curves.add(&(to_metres * path), entity.line, &label)?;
        }
    }
    match choice.name {
        Some(name) if !found => {
            let layers = entities.iter().map(Entity::layer);
            Err(no_such_name(file, "layer", name, &did_you_mean(name, layers)))
        }
        _ => curves.outline(),
    }
}

/// A group code and its value.
#[derive(Clone, Copy)]
struct Group<'a> {
    code: i32,
    value: &'a str,
    line: u64,
}

impl Group<'_> {
    fn number(&self, file: &str) -> Result<f64, IoError> {
        self.value.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
            let place = Place::file(file).line(self.line).field(format!("group {}", self.code));
            IoError::unexpected(place, "a finite number", quoted(self.value))
        })
    }

    /// What `$INSUNITS` says (m); nothing for drawings without a unit.
    fn unit(&self, file: &str) -> Result<Option<f64>, IoError> {
        Ok(Some(match self.value {
            "0" => return Ok(None),
            "1" => 25.4e-3,
            "2" => 304.8e-3,
            "4" => 1e-3,
            "5" => 1e-2,
            "6" => 1.0,
            "13" => 1e-6,
            "14" => 1e-1,
            other => {
                let place = Place::file(file).line(self.line).field("$INSUNITS");
                let expected = "1 (inch), 2 (foot), 4 (mm), 5 (cm), 6 (m), 13 (µm), 14 (dm) or 0 (none)";
                return Err(IoError::unexpected(place, expected, quoted(other)));
            }
        }))
    }
}

/// The groups of a file, one after another.
struct Groups<'a, L> {
    lines: L,
    file: &'a str,
}

impl<'a, L: Iterator<Item = (usize, &'a str)>> Groups<'a, L> {
    fn next(&mut self) -> Result<Option<Group<'a>>, IoError> {
        let Some((index, code)) = self.lines.next() else { return Ok(None) };
        let line = index as u64 + 1;
        if code.trim().is_empty() {
            // Blank lines at the end.
            return Ok(None);
        }
        let code = code.trim().parse().map_err(|_| {
            IoError::unexpected(Place::file(self.file).line(line), "a group code of a DXF file", quoted(code))
        })?;
        match self.lines.next() {
            Some((_, value)) => Ok(Some(Group { code, value: value.trim(), line: line + 1 })),
            None => {
                let place = Place::file(self.file).line(line);
                Err(IoError::unexpected(place, format!("a value of group {code}"), "the end of the file"))
            }
        }
    }
}

/// What stands between two groups `0`.
struct Entity<'a> {
    kind: &'a str,
    line: u64,
    groups: Vec<Group<'a>>,
}

impl Entity<'_> {
    fn text(&self, code: i32) -> Option<&str> {
        self.groups.iter().find(|group| group.code == code).map(|group| group.value)
    }

    fn layer(&self) -> &str {
        self.text(8).unwrap_or("0")
    }

    fn flag(&self, bit: i32) -> bool {
        self.text(70).and_then(|flags| flags.parse::<i32>().ok()).is_some_and(|flags| flags & bit != 0)
    }
}

/// An entity that is drawn.
struct Drawn<'a> {
    entity: &'a Entity<'a>,
    file: &'a str,
    unit: f64,
}

impl Drawn<'_> {
    fn place(&self) -> Place {
        Place::file(self.file).line(self.entity.line).field(self.entity.kind)
    }

    fn number_or(&self, code: i32, otherwise: f64) -> Result<f64, IoError> {
        let group = self.entity.groups.iter().find(|group| group.code == code);
        group.map_or(Ok(otherwise), |group| group.number(self.file))
    }

    /// A number that must be there.
    fn number(&self, code: i32) -> Result<f64, IoError> {
        match self.entity.text(code) {
            Some(_) => self.number_or(code, 0.0),
            None => Err(IoError::unexpected(self.place(), format!("group {code}"), "none")),
        }
    }

    fn point(&self, code: i32) -> Result<Point, IoError> {
        Ok(Point::new(self.number(code)?, self.number(code + 10)?))
    }

    /// +1, or −1 if it is drawn from behind, where x points the other way.
    fn side(&self) -> Result<f64, IoError> {
        if self.entity.kind == "LINE" || self.entity.kind == "ELLIPSE" {
            return Ok(1.0);
        }
        let towards = [self.number_or(210, 0.0)?, self.number_or(220, 0.0)?, self.number_or(230, 1.0)?];
        if towards[0].abs().max(towards[1].abs()) > 1e-9 {
            let found = format!("extruded along ({}, {}, {})", towards[0], towards[1], towards[2]);
            return Err(IoError::unexpected(self.place(), "a drawing in the plane of x and y", found));
        }
        Ok(towards[2].signum())
    }

    /// The curve, in units of the drawing.
    fn path(&self, vertices: &[Entity<'_>]) -> Result<Option<BezPath>, IoError> {
        let mut path = BezPath::new();
        match self.entity.kind {
            "LINE" => {
                path.move_to(self.point(10)?);
                path.line_to(self.point(11)?);
            }
            "CIRCLE" => self.round(&mut path, self.number(40)?, 0.0, TAU)?,
            "ARC" => {
                let (start, end) = (self.number(50)?.to_radians(), self.number(51)?.to_radians());
                self.round(&mut path, self.number(40)?, start, positive_turn(end - start))?;
            }
            "ELLIPSE" => self.ellipse(&mut path)?,
            "LWPOLYLINE" => {
                let corners = self.light_corners()?;
                self.polyline(&mut path, &corners);
            }
            "POLYLINE" => {
                if self.entity.flag(16 | 64) {
                    return Err(IoError::unexpected(self.place(), "a polyline", "a mesh"));
                }
                let corners = vertices.iter().map(|vertex| {
                    let vertex = Drawn { entity: vertex, ..*self };
                    Ok((vertex.point(10)?, vertex.number_or(42, 0.0)?))
                });
                let corners = corners.collect::<Result<Vec<_>, IoError>>()?;
                self.polyline(&mut path, &corners);
            }
            kind if NOT_READ.contains(&kind) => {
                let expected = "lines, arcs, circles, ellipses and polylines (explode or convert the others)";
                return Err(IoError::unexpected(self.place(), expected, kind));
            }
            _ => return Ok(None),
        }
        Ok(Some(path))
    }

    /// An arc about group 10.
    fn round(&self, path: &mut BezPath, radius: f64, start: f64, sweep: f64) -> Result<(), IoError> {
        self.arc(path, Arc::new(self.point(10)?, Vec2::new(radius, radius), start, sweep, 0.0))
    }

    /// Group 11 is the end of the major axis from the centre; group 41 and 42 are angles of its
    /// parameter.
    fn ellipse(&self, path: &mut BezPath) -> Result<(), IoError> {
        let major = self.point(11)?.to_vec2();
        let (ratio, start) = (self.number(40)?, self.number_or(41, 0.0)?);
        let sweep = positive_turn(self.number_or(42, TAU)? - start);
        let (radius, turn) = (major.hypot(), major.atan2());
        // Seen from behind, the minor axis points the other way.
        let side = if self.number_or(230, 1.0)? < 0.0 { -1.0 } else { 1.0 };
        self.arc(path, Arc::new(self.point(10)?, Vec2::new(radius, radius * ratio), side * start, side * sweep, turn))
    }

    fn arc(&self, path: &mut BezPath, arc: Arc) -> Result<(), IoError> {
        let largest = arc.radii.x.max(arc.radii.y) * self.unit;
        if !(largest <= LARGEST && arc.radii.x > 0.0 && arc.radii.y > 0.0) {
            let found = format!("({}, {})", arc.radii.x, arc.radii.y);
            return Err(IoError::unexpected(self.place(), format!("positive radii of at most {LARGEST} m"), found));
        }
        let at = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            arc.center + (Affine::rotate(arc.x_rotation) * Point::new(arc.radii.x * cos, arc.radii.y * sin)).to_vec2()
        };
        path.move_to(at(arc.start_angle));
        append_arc(path, &arc, at(arc.start_angle + arc.sweep_angle), self.unit);
        Ok(())
    }

    /// Corners of an LWPOLYLINE, with the bulges of what follows them.
    fn light_corners(&self) -> Result<Vec<(Point, f64)>, IoError> {
        let mut corners: Vec<(Point, f64)> = Vec::new();
        for group in self.entity.groups.iter().filter(|group| [10, 20, 42].contains(&group.code)) {
            let number = group.number(self.file)?;
            match (group.code, corners.last_mut()) {
                (10, _) => corners.push((Point::new(number, f64::NAN), 0.0)),
                (20, Some((point, _))) => point.y = number,
                (_, Some((_, bulge))) => *bulge = number,
                (_, None) => {}
            }
        }
        match corners.iter().find(|(point, _)| point.y.is_nan()) {
            Some(_) => Err(IoError::unexpected(self.place(), "group 20 after each group 10", "none")),
            None => Ok(corners),
        }
    }

    fn polyline(&self, path: &mut BezPath, corners: &[(Point, f64)]) {
        let [(first, _), rest @ ..] = corners else { return };
        let is_closed = self.entity.flag(1);
        path.move_to(*first);
        let ends = rest.iter().chain(is_closed.then_some(&corners[0]));
        for (&(from, bulge), &(to, _)) in corners.iter().zip(ends) {
            let chord = to - from;
            if bulge.abs() < FLAT || chord.hypot() == 0.0 {
                path.line_to(to);
                continue;
            }
            let across = Vec2::new(-chord.y, chord.x);
            let centre = from + 0.5 * chord + across * ((1.0 - bulge * bulge) / (4.0 * bulge));
            let radius = chord.hypot() * (1.0 + bulge * bulge) / (4.0 * bulge.abs());
            let start = (from - centre).atan2();
            let arc = Arc::new(centre, Vec2::new(radius, radius), start, 4.0 * bulge.atan(), 0.0);
            append_arc(path, &arc, to, self.unit);
        }
        if is_closed {
            path.close_path();
        }
    }
}

/// The same direction, turned by more than nothing and at most all round.
fn positive_turn(angle: f64) -> f64 {
    let turn = angle.rem_euclid(TAU);
    if turn == 0.0 { TAU } else { turn }
}

//! Bodies that are straight along z, and the outlines that they have.

use std::collections::{HashMap, HashSet};

use nalgebra::{Point2, Point3};

use crate::geometry::mesh::TriangleMesh;
use crate::geometry::mesh_gap::MeshPair;
use crate::geometry::polygon::{Polygon, signed_area};
use crate::geometry::prism_gap::PrismPair;

/// How far a point may be off, as a part of the body's largest coordinate: STL rounds to 6e-8 of
/// it, and programs that write STL do so more than once.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;
/// Levels of a straight part: two ends of a peg; top, floor and bottom of a body with a hole.
const MOST_LEVELS: usize = 3;
/// Most points along the border of a cross-section, those on straight edges too.
const MAX_BORDER_POINTS: usize = 10_000;

/// Outlines of a peg and a hole that are given as meshes, if both are straight along z to the
/// rounding of their files: a peg with two flat ends, its tip at z = 0, and a body with one hole
/// from its top face at z = 0 down to a flat floor, or through it if it is thicker than `depth` (m,
/// positive), to which the peg goes in. `None` otherwise, and for outlines that are no [`Polygon`].
/// Frames are as in [`PrismPair`].
///
/// The rounding is 4.8e-7 of a body's largest coordinate. The result extends the top face sideways
/// without limit, and walls without a floor down to where the peg does not come.
pub fn prisms_of(parts: &MeshPair, depth: f64) -> Option<PrismPair> {
    let (peg, length) = straight_peg(parts.tool())?;
    let (hole, floor) = straight_hole(parts.fixture())?;
    let below = match floor {
        Floor::Flat(below) => below,
        Floor::Open(thickness) if depth + rounding(parts.fixture()) < thickness => thickness + length,
        Floor::Open(_) => return None,
    };
    PrismPair::new(peg, length, hole, below).ok()
}

/// What ends a hole.
enum Floor {
    /// A flat floor so deep (m).
    Flat(f64),
    /// Nothing: the hole goes through a body so thick (m).
    Open(f64),
}

/// Outline and length of a straight peg.
fn straight_peg(solid: &TriangleMesh) -> Option<(Polygon, f64)> {
    let rounding = rounding(solid);
    match levels(solid, rounding)?.as_slice() {
        [tip, end] if tip.z.abs() <= rounding && !tip.is_up && end.is_up => {
            let ([around], [other]) = (tip.loops.as_slice(), end.loops.as_slice()) else { return None };
            if !is_as_large(around, other, rounding) {
                return None;
            }
            Some((outline(around, rounding)?, end.z))
        }
        _ => None,
    }
}

/// Outline of the only hole in the top face of a body, and what ends it.
fn straight_hole(solid: &TriangleMesh) -> Option<(Polygon, Floor)> {
    let rounding = rounding(solid);
    let levels = levels(solid, rounding)?;
    let (below, top) = match levels.as_slice() {
        [below @ .., top] if top.z.abs() <= rounding && top.is_up => (below, top),
        _ => return None,
    };
    let [one, other] = top.loops.as_slice() else { return None };
    // The other one is the block's outside.
    let hole = [one, other].into_iter().find(|border| signed_area(border) < 0.0)?;
    let (floor, ends) = match below {
        [bottom] if !bottom.is_up && bottom.loops.len() == 2 => (Floor::Open(-bottom.z), &bottom.loops),
        [bottom, floor] if !bottom.is_up && floor.is_up && bottom.loops.len() == 1 && floor.loops.len() == 1 => {
            (Floor::Flat(-floor.z), &floor.loops)
        }
        _ => return None,
    };
    let is_straight = ends.iter().any(|border| is_as_large(border, hole, rounding));
    if is_straight { Some((outline(hole, rounding)?, floor)) } else { None }
}

/// How far (m) a body's points may be off.
fn rounding(solid: &TriangleMesh) -> f64 {
    ROUNDING * solid.vertices().fold(0.0, |most, p| p.coords.amax().max(most))
}

/// All horizontal faces at one height.
struct Level {
    z: f64,
    is_up: bool,
    /// Their borders, with the faces to the left seen from above.
    loops: Vec<Vec<Point2<f64>>>,
}

/// The levels of a body without other faces than horizontal and upright ones, [`MOST_LEVELS`] at
/// most, the lowest first.
fn levels(solid: &TriangleMesh, rounding: f64) -> Option<Vec<Level>> {
    let vertices: Vec<Point3<f64>> = solid.vertices().collect();
    // Height, direction and triangles of each level.
    let mut levels: Vec<(f64, bool, Vec<[u32; 3]>)> = Vec::new();
    for triangle in solid.triangles() {
        let [a, b, c] = triangle.map(|i| vertices[i as usize]);
        let turn = (b - a).xy().perp(&(c - a).xy());
        let longest = (b - a).xy().norm().max((c - b).xy().norm()).max((a - c).xy().norm());
        if turn.abs() <= rounding * longest {
            // Upright: seen from above it is a line.
            continue;
        }
        let is_at = |z: f64| [a, b, c].iter().all(|p| (p.z - z).abs() <= rounding);
        let is_up = turn > 0.0;
        match levels.iter_mut().find(|(z, up, _)| *up == is_up && is_at(*z)) {
            Some((_, _, triangles)) => triangles.push(*triangle),
            None if is_at(a.z) => levels.push((a.z, is_up, vec![*triangle])),
            None => return None,
        }
        if levels.len() > MOST_LEVELS {
            return None;
        }
    }
    levels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let level = |(z, is_up, triangles): &(f64, bool, Vec<[u32; 3]>)| {
        let loops = borders(triangles)?.into_iter();
        let loops = loops.map(|border| {
            let mut border: Vec<Point2<f64>> = border.into_iter().map(|i| vertices[i as usize].xy()).collect();
            if !is_up {
                border.reverse();
            }
            border
        });
        Some(Level { z: *z, is_up: *is_up, loops: loops.collect() })
    };
    levels.iter().map(level).collect()
}

/// The closed lines of edges that have a triangle on one side only; none if one of them meets
/// itself or another.
fn borders(triangles: &[[u32; 3]]) -> Option<Vec<Vec<u32>>> {
    let sides = || triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let inner: HashSet<(u32, u32)> = sides().collect();
    let mut next: HashMap<u32, u32> = HashMap::new();
    let mut starts: Vec<u32> = Vec::new();
    for (from, to) in sides().filter(|&(from, to)| !inner.contains(&(to, from))) {
        starts.push(from);
        if next.insert(from, to).is_some() {
            return None;
        }
    }
    let mut borders = Vec::new();
    for start in starts {
        let mut border = Vec::new();
        let mut at = start;
        while let Some(to) = next.remove(&at) {
            border.push(at);
            at = to;
        }
        if !border.is_empty() {
            borders.push(border);
        }
    }
    Some(borders)
}

/// The outline along a border, without the points that lie on the line between those that remain.
fn outline(border: &[Point2<f64>], rounding: f64) -> Option<Polygon> {
    let n = border.len();
    if n > MAX_BORDER_POINTS {
        return None;
    }
    // The point farthest from another is a corner.
    let apart = |i: &usize| (border[*i] - border[0]).norm_squared();
    let first = (0..n).max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    let at = |k: usize| border[(first + k) % n];
    let mut kept = vec![at(0)];
    let mut last = 0;
    for k in 1..n {
        let along = at(k + 1) - at(last);
        let off = |between: usize| (along.perp(&(at(between) - at(last))) / along.norm()).abs();
        if !(last + 1..=k).all(|between| off(between) <= rounding) {
            kept.push(at(k));
            last = k;
        }
    }
    Polygon::new(kept).ok()
}

/// Whether two borders enclose the same area but for rounding. Triangles that lean by less than
/// that may add up to a cone.
fn is_as_large(a: &[Point2<f64>], b: &[Point2<f64>], rounding: f64) -> bool {
    (signed_area(a).abs() - signed_area(b).abs()).abs() <= rounding * perimeter(b)
}

fn perimeter(border: &[Point2<f64>]) -> f64 {
    sides(border).map(|(a, b)| (b - a).norm()).sum()
}

fn sides(border: &[Point2<f64>]) -> impl Iterator<Item = (&Point2<f64>, &Point2<f64>)> {
    border.iter().zip(border.iter().cycle().skip(1))
}

//! Parts that are round, which come as polygons or triangles: their facets are none of theirs.

use std::f64::consts::TAU;

use nalgebra::{Point2, Point3, Rotation2};

use crate::geometry::mesh::TriangleMesh;
use crate::geometry::polygon::{Polygon, foot_on_segment};

/// Whether peg and hole are each round about the z axis of their frame, up to facets of at most
/// 24°: a rotation about that axis changes no gap. An outline is round if its vertices are on a
/// circle within 0.1 % of its radius, a mesh as [`is_surface_of_revolution`] says. Neither part is
/// round by default.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AxialSymmetry {
    /// Whether the peg is round about the z axis of the peg frame.
    pub peg: bool,
    /// Whether the hole is round about the z axis of the hole frame.
    pub hole: bool,
}

impl AxialSymmetry {
    /// Whether peg or hole or both are round.
    pub fn any(self) -> bool {
        self.peg || self.hole
    }
}

/// How far from a circle corners may be, over its radius.
const TOLERANCE: f64 = 1e-3;
/// How far apart heights or radii that are the same may be, over the radius: digits of files.
const DIGITS: f64 = 1e-5;
/// Widest turn (rad) of a facet that stands for a piece of a circle: sixteen do, the twelve of a
/// prism do not.
const WIDEST: f64 = TAU / 15.0;
/// Largest rotational order that is looked for: parts with more teeth are round to a contact.
const MOST_ROTATIONS: usize = 12;
/// Widest turn over that of most facets: a flat is wider.
const WIDER: f64 = 2.5;

/// Whether an outline is a circle about the origin.
pub(crate) fn is_circle(outline: &Polygon) -> bool {
    let vertices = outline.vertices();
    let mean = vertices.iter().map(|p| p.coords.norm()).sum::<f64>() / vertices.len() as f64;
    let is_on_circle = |p: &Point2<f64>| (p.coords.norm() - mean).abs() < TOLERANCE * mean;
    let next = vertices.iter().cycle().skip(1);
    vertices.iter().all(is_on_circle) && are_facets(vertices.iter().zip(next).map(|(a, b)| turn(a, b)).collect())
}

/// Order (1 to 12) of the discrete rotational symmetry of an outline about the origin: rotated by a
/// whole turn over the order, the outline is the same up to 0.1 % of its radius. 4 for a square; 1
/// for an outline without such a symmetry, and for a circle, which any rotation leaves the same.
pub fn rotational_order(outline: &Polygon) -> usize {
    let tolerance = TOLERANCE * outline.bounding_radius();
    let is_on_outline = |p: Point2<f64>| {
        (0..outline.len()).any(|edge| (foot_on_segment(&p, outline.edge(edge)) - p).norm() < tolerance)
    };
    let is_same = |order: &usize| {
        let turned = Rotation2::new(TAU / *order as f64);
        outline.vertices().iter().all(|p| is_on_outline(turned * p))
    };
    let order = (2..=MOST_ROTATIONS).rev().find(is_same).filter(|_| !is_circle(outline));
    order.unwrap_or(1)
}

/// Whether a body's surface within `reach` (m, positive; infinite for all of it) of the z axis of
/// its frame is one of revolution about that axis, up to facets: each triangle is horizontal or has
/// an edge around the axis, whose ends are as far from it within about 0.2 % of the radius times
/// the angle between them (rad). Facets span at most 24°, and if above 5.1° at most 2.5 times their
/// median. False if no such facet is within reach.
pub fn is_surface_of_revolution(body: &TriangleMesh, reach: f64) -> bool {
    let vertices: Vec<Point3<f64>> = body.vertices().collect();
    let mut turns = Vec::new();
    for triangle in body.triangles() {
        let [a, b, c] = triangle.map(|k| vertices[k as usize]);
        let edges = [(a, b), (b, c), (c, a)];
        let is_near =
            edges.iter().any(|(p, q)| foot_on_segment(&Point2::origin(), (p.xy(), q.xy())).coords.norm() < reach);
        if !is_near || edges.iter().all(|(p, q)| is_level(p, q)) {
            continue;
        }
        match edges.iter().find_map(|(p, q)| turn_about_axis(p, q)) {
            Some(turn) => turns.push(turn),
            None => return false,
        }
    }
    are_facets(turns)
}

fn is_level(p: &Point3<f64>, q: &Point3<f64>) -> bool {
    (p.z - q.z).abs() <= DIGITS * p.xy().coords.norm().max(q.xy().coords.norm())
}

/// The turn (rad) from one end of an edge to the other, if it goes around the axis.
fn turn_about_axis(p: &Point3<f64>, q: &Point3<f64>) -> Option<f64> {
    let (radius, other) = (p.xy().coords.norm(), q.xy().coords.norm());
    let turn = turn(&p.xy(), &q.xy());
    // An oval that leaves the circle by the tolerance has twice its slope.
    let allowed = (DIGITS + 2.0 * TOLERANCE * turn) * radius;
    (radius > 0.0 && is_level(p, q) && (radius - other).abs() <= allowed).then_some(turn)
}

/// Angle (rad) at the origin between two points.
fn turn(a: &Point2<f64>, b: &Point2<f64>) -> f64 {
    a.coords.perp(&b.coords).atan2(a.coords.dot(&b.coords)).abs()
}

/// Whether facets of such turns (rad) stand for a circle, none of them for a flat that is deeper
/// than the tolerance.
fn are_facets(mut turns: Vec<f64>) -> bool {
    turns.sort_unstable_by(f64::total_cmp);
    let (Some(most), Some(widest)) = (turns.get(turns.len() / 2), turns.last()) else { return false };
    let shallow = 2.0 * (1.0 - TOLERANCE).acos();
    *widest <= WIDEST.min((WIDER * most).max(shallow))
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 12.5e-3;

    /// An outline of so many corners at these distances (m) from the origin.
    fn outline(corners: usize, radius: impl Fn(f64) -> f64) -> Polygon {
        let corner = |k: usize| {
            let angle = TAU * k as f64 / corners as f64;
            Point2::new(radius(angle) * angle.cos(), radius(angle) * angle.sin())
        };
        Polygon::new((0..corners).map(corner).collect()).unwrap()
    }

    /// A body that widens a little from its tip, its ends with their middles.
    fn body(tip: &Polygon) -> TriangleMesh {
        let n = tip.len() as u32;
        let end = |scale: f64, z: f64| {
            let corners = tip.vertices().iter().map(move |p| Point3::new(scale * p.x, scale * p.y, z));
            corners.chain([Point3::new(0.0, 0.0, z)])
        };
        let vertices: Vec<_> = end(1.0, 0.0).chain(end(1.1, 0.04)).collect();
        let above = n + 1;
        let triangles = (0..n).flat_map(|k| {
            let next = (k + 1) % n;
            let sides = [[k, next, above + next], [k, above + next, above + k]];
            sides.into_iter().chain([[next, k, n], [above + k, above + next, above + n]])
        });
        TriangleMesh::new(&vertices, &triangles.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn outlines_are_the_same_after_rotations() {
        let regular = |corners: usize| outline(corners, |_| RADIUS);
        let rectangle = outline(4, |angle| RADIUS * (1.0 + 0.1 * (2.0 * angle).cos()));
        let three_teeth = outline(120, |angle| RADIUS * (1.0 + 0.1 * (3.0 * angle).cos()));
        let slotted = outline(64, |angle| if angle.cos() > 0.9 { 0.8 * RADIUS } else { RADIUS });
        for (name, outline, order) in [
            ("triangle", regular(3), 3),
            ("square", regular(4), 4),
            ("hexagon", regular(6), 6),
            ("T-slot extrusion", Polygon::extrusion25(), 4),
            ("rhombus", rectangle, 2),
            ("three teeth", three_teeth, 3),
            ("slotted", slotted, 1),
            ("circle", regular(64), 1),
        ] {
            assert_eq!(rotational_order(&outline), order, "{name}");
        }
    }

    #[test]
    fn circles_are_told_from_what_turns() {
        let oval = |share: f64| move |angle: f64| RADIUS * (1.0 + share * (2.0 * angle).cos());
        let toothed = |angle: f64| if (8.0 * angle).sin() > 0.0 { RADIUS } else { 0.9 * RADIUS };
        let flat = |angle: f64| if angle.cos() > 0.98 { 0.98 * RADIUS / angle.cos() } else { RADIUS };
        for (name, outline, round) in [
            ("16 corners", outline(16, |_| RADIUS), true),
            ("400 corners", outline(400, |_| RADIUS), true),
            ("12 corners", outline(12, |_| RADIUS), false),
            ("hundredths of a millimetre", outline(128, |angle| RADIUS + 5e-6 * (37.0 * angle).sin()), true),
            ("oval by 0.05 %", outline(400, oval(5e-4)), true),
            ("oval by 0.3 %", outline(400, oval(3e-3)), false),
            ("toothed", outline(400, toothed), false),
            ("with a flat", outline(400, flat), false),
        ] {
            assert_eq!(is_circle(&outline), round, "{name}");
            // A mesh has more digits.
            if !name.starts_with("hundredths") {
                assert_eq!(is_surface_of_revolution(&body(&outline), f64::INFINITY), round, "{name}, as a body");
            }
        }
        let beside: Vec<Point2<f64>> =
            outline(128, |_| RADIUS).vertices().iter().map(|p| Point2::new(p.x + 0.1e-3, p.y)).collect();
        assert!(!is_circle(&Polygon::new(beside).unwrap()));
    }
}

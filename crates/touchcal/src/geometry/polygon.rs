//! Outlines: simple polygons in the plane, the cross-sections of pegs and holes.

use nalgebra::{Point2, Vector2};

/// Largest number of vertices that [`Polygon::new`] accepts. Where parts are far apart, the time
/// for a contact grows with the square of that number; with this many it is tens of milliseconds.
pub const MAX_POLYGON_VERTICES: usize = 512;
/// Below this difference of one and the cosine of their angle, edges lie on one line.
const COLLINEAR: f64 = 1e-12;

/// Why points are no outline, or an outline cannot be offset. Indices are those of the points as
/// they were given.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PolygonError {
    /// Fewer than 3 vertices, or more than [`MAX_POLYGON_VERTICES`].
    #[error(
        "an outline needs 3 to {MAX_POLYGON_VERTICES} vertices, found {found} (simplify a finer one; within 0.005 mm of the part it is accurate enough)"
    )]
    VertexCount {
        /// Number of vertices given.
        found: usize,
    },
    /// A coordinate is NaN or infinite; the first such vertex is reported.
    #[error("vertex {vertex}: expected finite coordinates, found ({x}, {y})")]
    NotFinite {
        /// Index of the vertex, from 0.
        vertex: usize,
        /// Coordinate x of the vertex (m).
        x: f64,
        /// Coordinate y of the vertex (m).
        y: f64,
    },
    /// Two consecutive vertices coincide exactly; the last one precedes the first.
    #[error(
        "vertices {vertex} and {next}: expected distinct points, found the same point twice (the last vertex is joined to the first)"
    )]
    RepeatedVertex {
        /// Index of the first of the two vertices, from 0.
        vertex: usize,
        /// Index of the vertex after it; 0 after the last.
        next: usize,
    },
    /// Two edges that are not neighbours touch or cross, or two neighbours overlap.
    #[error(
        "expected an outline that does not meet itself, found that the edges from vertices {first} and {second} meet"
    )]
    SelfIntersecting {
        /// Index of one edge, from 0: that of its start vertex.
        first: usize,
        /// Index of the other edge, greater than `first`.
        second: usize,
    },
    /// The outline encloses exactly no area, or one that is not finite.
    #[error("expected an outline that encloses an area, found {area} m²")]
    NoArea {
        /// The signed area (m²), negative if clockwise.
        area: f64,
    },
    /// An offset too large for the outline's shape: it shrinks an edge to nothing or turns it
    /// round.
    #[error(
        "expected an offset that keeps every edge and its direction, found that {distance} m removes the edge from vertex {edge}"
    )]
    EdgeLost {
        /// The offset asked for (m), positive outwards.
        distance: f64,
        /// Index of the lost edge, from 0: that of its start vertex.
        edge: usize,
    },
}

/// A simple polygon in the plane (m), counter-clockwise, possibly non-convex: the cross section of
/// a peg or a hole in x and y of its frame. Edge `i` runs from vertex `i` to vertex `i + 1`, the
/// last to vertex 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    vertices: Vec<Point2<f64>>,
    convex: Vec<bool>,
}

impl Polygon {
    /// An outline from its vertices (m) in order, either way round; the last is joined to the
    /// first. If they are clockwise, their order is reversed.
    ///
    /// # Errors
    /// [`PolygonError`] if the number of vertices is not 3 to [`MAX_POLYGON_VERTICES`], a
    /// coordinate is not finite, two consecutive vertices coincide, the outline meets itself, or it
    /// encloses no area; the first in this order.
    pub fn new(mut vertices: Vec<Point2<f64>>) -> Result<Self, PolygonError> {
        let n = vertices.len();
        if !(3..=MAX_POLYGON_VERTICES).contains(&n) {
            return Err(PolygonError::VertexCount { found: n });
        }
        if let Some((vertex, p)) = vertices.iter().enumerate().find(|(_, p)| !(p.x.is_finite() && p.y.is_finite())) {
            return Err(PolygonError::NotFinite { vertex, x: p.x, y: p.y });
        }
        for vertex in 0..n {
            let next = (vertex + 1) % n;
            if vertices[vertex] == vertices[next] {
                return Err(PolygonError::RepeatedVertex { vertex, next });
            }
        }
        if let Some((first, second)) = self_intersection(&vertices) {
            return Err(PolygonError::SelfIntersecting { first, second });
        }
        let area = signed_area(&vertices);
        if area == 0.0 || !area.is_finite() {
            return Err(PolygonError::NoArea { area });
        }
        if area < 0.0 {
            vertices.reverse();
        }
        let convex = (0..n)
            .map(|i| {
                let (before, here, after) = (vertices[(i + n - 1) % n], vertices[i], vertices[(i + 1) % n]);
                (here - before).perp(&(after - here)) > 0.0
            })
            .collect();
        Ok(Polygon { vertices, convex })
    }

    /// The outline (m) of the built-in peg `extrusion25`: a 25 mm T-slot extrusion with a slot on
    /// each of its four sides, 36 vertices, its sides along x and y, centred at the origin.
    pub fn extrusion25() -> Self {
        // One quarter, counter-clockwise from the right-hand slot; the others are its turns by 90°.
        const QUARTER_MM: [(f64, f64); 9] = [
            (6.0, 5.5),
            (10.5, 5.5),
            (10.5, 3.5),
            (12.5, 3.5),
            (12.5, 12.5),
            (3.5, 12.5),
            (3.5, 10.5),
            (5.5, 10.5),
            (5.5, 6.0),
        ];
        const CONVEX: [bool; 9] = [false, false, true, true, true, true, true, false, false];
        let mut vertices = Vec::with_capacity(36);
        let mut convex = Vec::with_capacity(36);
        for (cos, sin) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
            for (x, y) in QUARTER_MM {
                vertices.push(Point2::new((cos * x - sin * y) * 1e-3, (sin * x + cos * y) * 1e-3));
            }
            convex.extend(CONVEX);
        }
        Polygon { vertices, convex }
    }

    /// The outline with every edge moved outwards by `distance` (m), corners mitred; inwards if
    /// negative. Vertex `i` of the result belongs to vertex `i`.
    ///
    /// # Errors
    /// [`PolygonError::EdgeLost`] if an edge shrinks to nothing, otherwise as [`Polygon::new`].
    pub fn offset_mitred(&self, distance: f64) -> Result<Self, PolygonError> {
        self.offset_mitred_by(|_| distance)
    }

    /// The same with a distance (m) for each outward unit normal of an edge.
    ///
    /// # Errors
    /// As [`Polygon::offset_mitred`].
    pub fn offset_mitred_by(&self, distance: impl Fn(&Vector2<f64>) -> f64) -> Result<Self, PolygonError> {
        let n = self.len();
        let moved: Vec<Point2<f64>> = (0..n)
            .map(|i| {
                let (before, after) = (self.outward((i + n - 1) % n), self.outward(i));
                let (first, second) = (distance(&before), distance(&after));
                // The point at these distances from both edges' lines.
                let cosine = before.dot(&after);
                let common = (before + after) * (0.5 * (first + second) / (1.0 + cosine));
                let difference = 0.5 * (first - second);
                // Edges on one line have one distance.
                let apart = if 1.0 - cosine < COLLINEAR { 0.0 } else { difference / (1.0 - cosine) };
                self.vertices[i] + common + (before - after) * apart
            })
            .collect();
        for edge in 0..n {
            let was = self.vertices[(edge + 1) % n] - self.vertices[edge];
            if (moved[(edge + 1) % n] - moved[edge]).dot(&was) <= 0.0 {
                return Err(PolygonError::EdgeLost { distance: distance(&self.outward(edge)), edge });
            }
        }
        Polygon::new(moved)
    }

    /// Number of vertices, which is also that of edges: 3 to [`MAX_POLYGON_VERTICES`].
    #[inline]
    pub fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Always false: an outline has at least three vertices.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Vertices (m), counter-clockwise, in the order given to [`new`](Polygon::new) or, if that was
    /// clockwise, in the reverse order.
    #[inline]
    pub fn vertices(&self) -> &[Point2<f64>] {
        &self.vertices
    }

    /// Whether the interior angle at vertex `i` is below 180°. A vertex on a straight line counts
    /// as reflex. Panics if `i` is not below [`len`](Polygon::len).
    #[inline]
    pub fn is_convex_at(&self, i: usize) -> bool {
        self.convex[i]
    }

    /// Start and end (m) of edge `i`, from vertex `i` to the next. Panics if `i` is not below
    /// [`len`](Polygon::len).
    #[inline]
    pub fn edge(&self, i: usize) -> (Point2<f64>, Point2<f64>) {
        let next = if i + 1 == self.len() { 0 } else { i + 1 };
        (self.vertices[i], self.vertices[next])
    }

    /// Unit outward normal of edge `i`, square to it. Panics if `i` is not below
    /// [`len`](Polygon::len).
    pub fn outward(&self, i: usize) -> Vector2<f64> {
        let (a, b) = self.edge(i);
        let along = (b - a).normalize();
        Vector2::new(along.y, -along.x)
    }

    /// Enclosed area (m²), positive.
    pub fn area(&self) -> f64 {
        signed_area(&self.vertices)
    }

    /// Largest distance (m) of a vertex from the origin, which is that of the part's z axis.
    pub fn bounding_radius(&self) -> f64 {
        self.vertices.iter().map(|p| p.coords.norm()).fold(0.0, f64::max)
    }

    /// Whether `point` (m) lies inside, by the winding number (Hormann & Agathos 2001); a point on
    /// the outline may count either way, NaN counts as outside.
    pub fn contains(&self, point: &Point2<f64>) -> bool {
        let mut winding = 0;
        for i in 0..self.len() {
            let (a, b) = self.edge(i);
            let side = (b - a).perp(&(point - a));
            if a.y <= point.y && b.y > point.y && side > 0.0 {
                winding += 1;
            } else if a.y > point.y && b.y <= point.y && side < 0.0 {
                winding -= 1;
            }
        }
        winding != 0
    }

    /// Distance (m) from `point` (m, finite) to the outline, negative inside.
    pub fn signed_distance(&self, point: &Point2<f64>) -> f64 {
        let nearest = (0..self.len()).map(|i| distance_to_segment(point, self.edge(i))).fold(f64::INFINITY, f64::min);
        if self.contains(point) { -nearest } else { nearest }
    }
}

/// Distance from a point to a segment.
fn distance_to_segment(point: &Point2<f64>, segment: (Point2<f64>, Point2<f64>)) -> f64 {
    (point - foot_on_segment(point, segment)).norm()
}

/// The point of a segment nearest to a point.
pub(crate) fn foot_on_segment(point: &Point2<f64>, (a, b): (Point2<f64>, Point2<f64>)) -> Point2<f64> {
    let along = b - a;
    a + along * ((point - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0)
}

/// Enclosed area (m²), negative if clockwise.
pub(crate) fn signed_area(vertices: &[Point2<f64>]) -> f64 {
    let n = vertices.len();
    // Relative to one vertex, so that a far-away outline keeps its digits.
    let origin = vertices[0];
    (1..n - 1).map(|i| (vertices[i] - origin).perp(&(vertices[i + 1] - origin))).sum::<f64>() / 2.0
}

/// Two edges that meet other than at their shared vertex, found by sweeping over x.
fn self_intersection(vertices: &[Point2<f64>]) -> Option<(usize, usize)> {
    let n = vertices.len();
    let ends = |i: usize| (vertices[i], vertices[(i + 1) % n]);
    let span = |i: usize| {
        let (a, b) = ends(i);
        (a.x.min(b.x), a.x.max(b.x))
    };
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| span(i).0.total_cmp(&span(j).0));
    for (rank, &i) in order.iter().enumerate() {
        for &j in order[rank + 1..].iter().take_while(|&&j| span(j).0 <= span(i).1) {
            let (first, second) = (i.min(j), i.max(j));
            let meet = if second == first + 1 || (first == 0 && second == n - 1) {
                // Neighbours share a vertex; they overlap if one folds back on the other.
                let (before, after) = if second == first + 1 { (first, second) } else { (second, first) };
                let (u, v) = (ends(before).1 - ends(before).0, ends(after).1 - ends(after).0);
                u.perp(&v) == 0.0 && u.dot(&v) < 0.0
            } else {
                segments_meet(ends(i), ends(j))
            };
            if meet {
                return Some((first, second));
            }
        }
    }
    None
}

fn segments_meet((a, b): (Point2<f64>, Point2<f64>), (c, d): (Point2<f64>, Point2<f64>)) -> bool {
    let side = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q - p).perp(&(r - p));
    let within = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| {
        r.x >= p.x.min(q.x) && r.x <= p.x.max(q.x) && r.y >= p.y.min(q.y) && r.y <= p.y.max(q.y)
    };
    let (s1, s2, s3, s4) = (side(a, b, c), side(a, b, d), side(c, d, a), side(c, d, b));
    (s1 * s2 < 0.0 && s3 * s4 < 0.0)
        || (s1 == 0.0 && within(a, b, c))
        || (s2 == 0.0 && within(a, b, d))
        || (s3 == 0.0 && within(c, d, a))
        || (s4 == 0.0 && within(c, d, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(points: &[(f64, f64)]) -> Result<Polygon, PolygonError> {
        Polygon::new(points.iter().map(|&(x, y)| Point2::new(x, y)).collect())
    }

    #[test]
    fn refuses_what_is_no_outline() {
        assert_eq!(outline(&[(0.0, 0.0), (1.0, 0.0)]), Err(PolygonError::VertexCount { found: 2 }));
        assert!(matches!(
            outline(&[(0.0, 0.0), (1.0, f64::NAN), (1.0, 1.0)]),
            Err(PolygonError::NotFinite { vertex: 1, .. })
        ));
        let repeated = outline(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 0.0)]);
        assert_eq!(repeated, Err(PolygonError::RepeatedVertex { vertex: 3, next: 0 }));
        let bow_tie = outline(&[(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)]);
        assert_eq!(bow_tie, Err(PolygonError::SelfIntersecting { first: 0, second: 2 }));
        assert!(outline(&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0)]).is_err());
        let message = outline(&[(0.0, 0.0)]).unwrap_err().to_string();
        assert_eq!(
            message,
            "an outline needs 3 to 512 vertices, found 1 (simplify a finer one; within 0.005 mm of the part it is accurate enough)"
        );
    }

    #[test]
    fn clockwise_is_turned_round() {
        let square = outline(&[(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]).unwrap();
        assert_eq!(square.area(), 1.0);
        assert!((0..4).all(|i| square.is_convex_at(i)));
    }

    #[test]
    fn extrusion25_is_a_valid_outline_with_four_slots() {
        let profile = Polygon::extrusion25();
        assert_eq!(Polygon::new(profile.vertices().to_vec()), Ok(profile.clone()));
        assert_eq!((0..36).filter(|&i| profile.is_convex_at(i)).count(), 20);
        assert!((profile.bounding_radius() - 12.5e-3 * 2f64.sqrt()).abs() < 1e-15);
        // Centre square 12 × 12, four corner squares 7 × 7 that overlap it by 0.5 × 0.5, eight lips
        // 2 × 2.
        assert!((profile.area() - 371e-6).abs() < 1e-15, "{}", profile.area());
    }

    #[test]
    fn offset_moves_every_edge_outwards() {
        let profile = Polygon::extrusion25();
        let wider = profile.offset_mitred(0.5e-3).unwrap();
        for (i, (inner, outer)) in profile.vertices().iter().zip(wider.vertices()).enumerate() {
            assert!(((outer - inner).norm() - 0.5e-3 * 2f64.sqrt()).abs() < 1e-15);
            assert!(wider.contains(inner));
            let clearance = if profile.is_convex_at(i) { 0.5e-3 } else { 0.5e-3 * 2f64.sqrt() };
            assert!((wider.signed_distance(inner) + clearance).abs() < 1e-15);
        }
        assert!(profile.offset_mitred(2.5e-3).is_err());
        assert!(matches!(profile.offset_mitred(-1.1e-3), Err(PolygonError::EdgeLost { .. })));
    }

    #[test]
    fn signed_distance_is_negative_inside() {
        let square = outline(&[(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]).unwrap();
        assert_eq!(square.signed_distance(&Point2::new(0.25, 0.0)), -0.75);
        assert_eq!(square.signed_distance(&Point2::new(4.0, 5.0)), 5.0);
    }
}

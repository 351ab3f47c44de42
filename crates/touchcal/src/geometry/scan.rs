//! One sweep over the features of a peg and a hole at a pose.

use super::extrusion::{Feature, PegAndHole};
use super::nearness::Nearness;
use super::profile::Profile;
use crate::se3::Pose;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Beyond this depth (m) of a peg end below the top face, its edges are no longer compared with the rim from below: the
/// walls are nearer.
const RIM_DEPTH: f64 = 1e-3;
/// Slack of the test that a normal lies between two faces' normals.
const CONE_SLACK: f64 = 1e-9;

/// A signed distance. `normal` points from the solid into the peg, `point` lies on the peg; both are in the peg frame if `in_peg`, else in
/// the hole frame.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub(super) value: f64,
    pub(super) point: Vector3<f64>,
    pub(super) normal: Vector3<f64>,
    pub(super) in_peg: bool,
    pub(super) feature: Feature,
}

impl Candidate {
    /// Farther than anything.
    pub(super) fn none() -> Self {
        Candidate {
            value: f64::INFINITY,
            point: Vector3::zeros(),
            normal: Vector3::z(),
            in_peg: false,
            feature: Feature::CornerFloor { peg_vertex: 0 },
        }
    }
}

/// What becomes of the distances found.
pub(super) trait Sink {
    /// Whether near misses are wanted, or only the smallest.
    const ALL: bool;
    /// Distances from here on are of no interest.
    fn reach(&self) -> f64;
    /// Receives a distance below [`Sink::reach`].
    fn take(&mut self, candidate: Candidate);
}

/// An outline seen along an axis: an affine image of the polygon in a plane.
struct Loop<'a> {
    profile: &'a Profile,
    linear: Matrix2<f64>,
    offset: Vector2<f64>,
    /// Height of an outline point along the axis: `slope · p + height`.
    slope: Vector2<f64>,
    height: f64,
    /// Most that an outline point is displaced from its aligned place.
    moved: f64,
    /// +1, or −1 where the image is mirrored.
    turn: f64,
    near: &'a Nearness,
}

/// The point of a loop nearest to a query.
#[derive(Clone, Copy)]
struct Foot {
    edge: usize,
    /// Place along the edge, 0 to 1.
    t: f64,
    distance: f64,
}

impl Foot {
    const NONE: Foot = Foot { edge: 0, t: 0.0, distance: f64::INFINITY };

    fn at_vertex(&self) -> bool {
        self.t <= 0.0 || self.t >= 1.0
    }
}

/// A signed distance from a loop in its plane: positive along `normal`.
struct Offset {
    edge: usize,
    t: f64,
    value: f64,
    /// Unit normal of the loop towards the free side.
    normal: Vector2<f64>,
}

impl Loop<'_> {
    fn segment(&self, edge: usize) -> (Vector2<f64>, Vector2<f64>) {
        let (a, b) = self.profile.edge(edge);
        (self.linear * a.coords + self.offset, self.linear * (b - a))
    }

    fn point(&self, edge: usize, t: f64) -> Vector2<f64> {
        let (a, along) = self.segment(edge);
        a + along * t
    }

    /// Height of a point of an edge.
    fn height_at(&self, edge: usize, t: f64) -> f64 {
        let (a, b) = self.profile.edge(edge);
        self.slope.dot(&(a.coords + (b - a) * t)) + self.height
    }

    fn foot(&self, edge: usize, x: &Vector2<f64>) -> Foot {
        let (a, along) = self.segment(edge);
        let t = ((x - a).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        Foot { edge, t, distance: (x - a - along * t).norm() }
    }

    /// Nearest point of the loop to the query, and nearest point that counts and is closer than `reach`.
    fn nearest(&self, query: &Query, reach: f64) -> (Foot, Foot) {
        let (mut any, mut counted) = (Foot::NONE, Foot::NONE);
        self.near.scan(query.vertex, self.moved, |edge| {
            let foot = self.foot(edge, &query.x);
            if foot.distance < any.distance {
                any = foot;
            }
            if foot.distance < counted.distance {
                let height = self.height_at(edge, foot.t);
                if query.range.0 <= height && height <= query.range.1 {
                    counted = foot;
                }
            }
            any.distance.max(counted.distance.min(reach))
        });
        (any, counted)
    }

    /// Nearest point of the loop.
    fn nearest_any(&self, vertex: usize, x: &Vector2<f64>) -> Foot {
        let mut any = Foot::NONE;
        self.near.scan(vertex, self.moved, |edge| {
            let foot = self.foot(edge, x);
            if foot.distance < any.distance {
                any = foot;
            }
            any.distance
        });
        any
    }

    /// Whether `x`, whose nearest point is `foot`, lies within the outline.
    fn encloses(&self, x: &Vector2<f64>, foot: &Foot) -> bool {
        let left = |edge: usize| {
            let (a, along) = self.segment(edge);
            along.perp(&(x - a)) * self.turn > 0.0
        };
        if !foot.at_vertex() {
            return left(foot.edge);
        }
        let (before, after) = self.edges_at(foot);
        if self.profile.is_convex_at(after) { left(before) && left(after) } else { left(before) || left(after) }
    }

    /// The edges before and after the vertex at which a foot lies.
    fn edges_at(&self, foot: &Foot) -> (usize, usize) {
        let n = self.profile.len();
        let after = if foot.t <= 0.0 { foot.edge } else { (foot.edge + 1) % n };
        ((after + n - 1) % n, after)
    }

    /// Signed distance from an edge's line; `free` is +1 if the free side is the inside of the outline, else −1.
    fn from_line(&self, x: &Vector2<f64>, edge: usize, t: f64, free: f64) -> Offset {
        let (a, along) = self.segment(edge);
        let along = along.normalize() * (self.turn * free);
        let normal = Vector2::new(-along.y, along.x);
        Offset { edge, t, value: normal.dot(&(x - a)), normal }
    }

    /// Signed distance on the free side: from the edge, or from the vertex at which the foot lies.
    fn from_foot(&self, x: &Vector2<f64>, foot: &Foot, free: f64) -> Offset {
        let line = self.from_line(x, foot.edge, foot.t, free);
        if foot.distance <= 1e-12 || (!foot.at_vertex() && line.value > 0.0) {
            return line;
        }
        let normal = (x - self.point(foot.edge, foot.t)) / foot.distance;
        Offset { value: foot.distance, normal, ..line }
    }

    /// Signed distances on the penetrating side. Beyond a vertex both edges continue straight.
    fn beyond(&self, x: &Vector2<f64>, foot: &Foot, free: f64) -> (Offset, Option<Offset>) {
        if !foot.at_vertex() {
            return (self.from_line(x, foot.edge, foot.t, free), None);
        }
        let (before, after) = self.edges_at(foot);
        (self.from_line(x, before, 1.0, free), Some(self.from_line(x, after, 0.0, free)))
    }
}

/// A peg and a hole at a pose.
pub(super) struct Scan<'a> {
    pair: &'a PegAndHole,
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    /// The hole's origin in the peg frame.
    hole_in_peg: Vector3<f64>,
}

const UNLIMITED: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

fn lift(v: &Vector2<f64>, z: f64) -> Vector3<f64> {
    Vector3::new(v.x, v.y, z)
}

impl<'a> Scan<'a> {
    pub(super) fn new(pair: &'a PegAndHole, hole_from_peg: &Pose) -> Self {
        let rotation = *hole_from_peg.rotation.to_rotation_matrix().matrix();
        let translation = hole_from_peg.translation.vector;
        Scan { pair, rotation, translation, hole_in_peg: -(rotation.tr_mul(&translation)) }
    }

    /// Reports the features to `sink`.
    pub(super) fn run<S: Sink>(&self, sink: &mut S) {
        for end in [0.0, self.pair.length] {
            let (lowest, highest) = self.heights(end);
            if lowest >= sink.reach().max(0.0) {
                continue;
            }
            let ring = self.ring(end);
            self.corners(end, sink);
            self.wall_corners(&ring, end, sink);
            if highest > -sink.reach().max(RIM_DEPTH) {
                self.end_edges(end, sink);
            }
        }
        self.rim_corners(sink);
        self.side_edges(sink);
        self.crossing_corners(sink);
    }

    /// Least and greatest height of an end of the peg in the hole frame.
    fn heights(&self, end: f64) -> (f64, f64) {
        let pair = self.pair;
        let slope = Vector2::new(self.rotation[(2, 0)], self.rotation[(2, 1)]);
        let middle = self.translation.z + self.rotation[(2, 2)] * end;
        pair.peg_corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &i| {
            let z = middle + slope.dot(&pair.peg.vertices()[i].coords);
            (low.min(z), high.max(z))
        })
    }

    /// The outline of an end of the peg, seen along the hole's axis.
    fn ring(&self, end: f64) -> Loop<'a> {
        let (r, t) = (&self.rotation, &self.translation);
        let centre = t + r.column(2) * end;
        let linear = r.fixed_view::<2, 2>(0, 0).into_owned();
        let offset = centre.xy();
        Loop {
            profile: &self.pair.peg,
            linear,
            offset,
            slope: Vector2::new(r[(2, 0)], r[(2, 1)]),
            height: centre.z,
            moved: displacement(&self.pair.peg, &self.pair.peg_corners, &linear, &offset),
            turn: r[(2, 2)].signum(),
            near: &self.pair.hole_to_peg,
        }
    }

    /// The rim, seen along the peg's axis.
    fn rim(&self) -> Loop<'a> {
        let r = &self.rotation;
        let linear = r.fixed_view::<2, 2>(0, 0).transpose();
        let offset = self.hole_in_peg.xy();
        Loop {
            profile: &self.pair.hole,
            linear,
            offset,
            slope: Vector2::new(r[(0, 2)], r[(1, 2)]),
            height: self.hole_in_peg.z,
            moved: displacement(&self.pair.hole, &self.pair.hole_hull, &linear, &offset),
            turn: r[(2, 2)].signum(),
            near: &self.pair.peg_to_hole,
        }
    }

    /// Corners of a peg end against walls, rim, top face and floor.
    fn corners<S: Sink>(&self, end: f64, sink: &mut S) {
        let pair = self.pair;
        let mut walls = still(&pair.hole, &pair.peg_to_hole);
        for &i in &pair.peg_corners {
            let aligned = pair.peg.vertices()[i].coords;
            let corner = self.rotation * lift(&aligned, end) + self.translation;
            let xy = corner.xy();
            let z = corner.z;
            walls.moved = (xy - aligned).norm();
            let upright = |value: f64, feature: Feature| Candidate {
                value,
                point: corner,
                normal: Vector3::z(),
                in_peg: false,
                feature,
            };
            if z + pair.depth < sink.reach() {
                sink.take(upright(z + pair.depth, Feature::CornerFloor { peg_vertex: i }));
            }
            if z >= sink.reach() || pair.peg_clearance[i] - walls.moved >= sink.reach() {
                continue;
            }
            let to_wall = |offset: &Offset| {
                let value = if z > 0.0 { offset.value.hypot(z) } else { offset.value };
                let normal =
                    if z > 0.0 { lift(&(offset.normal * offset.value), z) / value } else { lift(&offset.normal, 0.0) };
                let feature = Feature::CornerWall { peg_vertex: i, hole_edge: offset.edge };
                Candidate { value, point: corner, normal, in_peg: false, feature }
            };
            let foot = walls.nearest_any(i, &xy);
            if walls.encloses(&xy, &foot) {
                free_offsets(&walls, &Query { vertex: i, x: xy, range: UNLIMITED, free: 1.0 }, &foot, sink, to_wall);
            } else if z > 0.0 || foot.distance > -z {
                if z < sink.reach() {
                    sink.take(upright(z, Feature::CornerTop { peg_vertex: i }));
                }
            } else {
                deep_offsets(walls.beyond(&xy, &foot, 1.0), sink, to_wall);
            }
        }
    }

    /// Corners of the rim against the peg's sides and ends.
    fn rim_corners<S: Sink>(&self, sink: &mut S) {
        let pair = self.pair;
        let mut sides = still(&pair.peg, &pair.hole_to_peg);
        for &u in &pair.wall_corners {
            let aligned = pair.hole.vertices()[u].coords;
            let corner = self.rotation.tr_mul(&lift(&aligned, 0.0)) + self.hole_in_peg;
            let (xy, z) = (corner.xy(), corner.z);
            sides.moved = (xy - aligned).norm();
            // How far beyond the nearer end face, along the axis.
            let over = if z < 0.5 * pair.length { -z } else { z - pair.length };
            let outward = if z < 0.5 * pair.length { -1.0 } else { 1.0 };
            if over >= sink.reach() || pair.hole_clearance[u] - sides.moved >= sink.reach() {
                continue;
            }
            let to_side = |offset: &Offset| {
                let from_peg = if over > 0.0 {
                    lift(&(offset.normal * offset.value), outward * over)
                } else {
                    lift(&offset.normal, 0.0)
                };
                let value = if over > 0.0 { offset.value.hypot(over) } else { offset.value };
                let normal = if over > 0.0 { -from_peg / value } else { -from_peg };
                let feature = Feature::RimCornerSide { hole_vertex: u, peg_edge: offset.edge };
                Candidate { value, point: corner + normal * value, normal, in_peg: true, feature }
            };
            let foot = sides.nearest_any(u, &xy);
            if !sides.encloses(&xy, &foot) {
                free_offsets(&sides, &Query { vertex: u, x: xy, range: UNLIMITED, free: -1.0 }, &foot, sink, to_side);
            } else if over > 0.0 || foot.distance > -over {
                if over < sink.reach() {
                    let normal = Vector3::z() * -outward;
                    let feature = Feature::RimCornerEnd { hole_vertex: u };
                    sink.take(Candidate { value: over, point: corner + normal * over, normal, in_peg: true, feature });
                }
            } else {
                deep_offsets(sides.beyond(&xy, &foot, -1.0), sink, to_side);
            }
        }
    }

    /// Wall corners against the edges of a peg end.
    fn wall_corners<S: Sink>(&self, ring: &Loop, end: f64, sink: &mut S) {
        let pair = self.pair;
        let range = (-pair.depth, 0.0);
        for &u in &pair.wall_corners {
            if pair.hole_clearance[u] - ring.moved >= sink.reach() {
                continue;
            }
            let xy = pair.hole.vertices()[u].coords;
            let to_edge = |offset: &Offset| {
                let foot = xy - offset.normal * offset.value;
                let point = lift(&foot, ring.height_at(offset.edge, offset.t));
                let feature = Feature::WallCornerEndEdge { hole_vertex: u, peg_edge: offset.edge };
                Candidate { value: offset.value, point, normal: lift(&-offset.normal, 0.0), in_peg: false, feature }
            };
            let query = Query { vertex: u, x: xy, range, free: -1.0 };
            let (any, foot) = ring.nearest(&query, sink.reach());
            let over_end = self.rotation.column(2).dot(&(lift(&xy, 0.0) - self.translation)) - end;
            let pierce = -over_end / self.rotation[(2, 2)];
            if !(ring.encloses(&xy, &any) && range.0 < pierce && pierce < range.1) {
                if !ring.encloses(&xy, &any) {
                    free_offsets(ring, &query, &foot, sink, to_edge);
                }
            } else if foot.distance <= over_end.abs() {
                deep_offsets(ring.beyond(&xy, &foot, -1.0), sink, to_edge);
            } else if -over_end.abs() < sink.reach() {
                // Shorter to move the end face off the top of this corner.
                let normal = self.rotation.column(2) * over_end.signum();
                let corner = lift(&xy, 0.0);
                let (value, feature) = (-over_end.abs(), Feature::RimCornerEnd { hole_vertex: u });
                sink.take(Candidate { value, point: corner + normal * value, normal, in_peg: false, feature });
            }
        }
    }

    /// Longitudinal edges of the peg against the rim.
    fn side_edges<S: Sink>(&self, sink: &mut S) {
        let pair = self.pair;
        let rim = self.rim();
        let range = (0.0, pair.length);
        for &i in &pair.peg_corners {
            if pair.peg_clearance[i] - rim.moved >= sink.reach() {
                continue;
            }
            let xy = pair.peg.vertices()[i].coords;
            let to_rim = |offset: &Offset| {
                let point = lift(&xy, rim.height_at(offset.edge, offset.t));
                let feature = Feature::SideEdgeRim { peg_vertex: i, hole_edge: offset.edge };
                Candidate { value: offset.value, point, normal: lift(&offset.normal, 0.0), in_peg: true, feature }
            };
            let query = Query { vertex: i, x: xy, range, free: 1.0 };
            let (any, foot) = rim.nearest(&query, sink.reach());
            let tip = self.rotation * lift(&xy, 0.0) + self.translation;
            let pierce = -tip.z / self.rotation[(2, 2)];
            if rim.encloses(&xy, &any) || pierce <= 0.0 || pierce >= pair.length {
                free_offsets(&rim, &query, &foot, sink, to_rim);
                continue;
            }
            let lower = if tip.z <= 0.0 { tip } else { tip + self.rotation.column(2) * pair.length };
            if foot.distance <= -lower.z {
                deep_offsets(rim.beyond(&xy, &foot, 1.0), sink, to_rim);
            } else if lower.z < sink.reach() {
                // Shorter to lift the edge's lower end out of the top face.
                let feature = Feature::CornerTop { peg_vertex: i };
                sink.take(Candidate { value: lower.z, point: lower, normal: Vector3::z(), in_peg: false, feature });
            }
        }
    }

    /// Longitudinal edges of the peg against wall corners.
    fn crossing_corners<S: Sink>(&self, sink: &mut S) {
        let pair = self.pair;
        let axis: Vector3<f64> = self.rotation.column(2).into_owned();
        for &i in &pair.peg_corners {
            let aligned = lift(&pair.peg.vertices()[i].coords, 0.0);
            let tip = self.rotation * aligned + self.translation;
            let far = tip + axis * pair.length;
            if tip.z.min(far.z) >= 0.0 {
                continue;
            }
            // Between tip and top face the edge strays no more than at one of the two.
            let moved = if axis.z > 0.3 {
                let through = tip - axis * (tip.z / axis.z);
                (tip - aligned).xy().norm_squared().max((through - aligned).xy().norm_squared()).sqrt()
            } else {
                f64::INFINITY
            };
            if pair.corner_clearance[i] - moved >= sink.reach() {
                continue;
            }
            for &u in &pair.wall_corners {
                if let Some(candidate) = self.crossing((tip, far), i, u) {
                    if candidate.value < sink.reach() {
                        sink.take(candidate);
                    }
                }
            }
        }
    }

    /// A longitudinal edge against a wall corner, if they are nearest at inner points and face each other.
    fn crossing(&self, (tip, far): (Vector3<f64>, Vector3<f64>), i: usize, u: usize) -> Option<Candidate> {
        let (peg, hole) = (&self.pair.peg, &self.pair.hole);
        let corner = hole.vertices()[u].coords;
        let along = (far - tip).xy();
        let t = (corner - tip.xy()).dot(&along) / along.norm_squared();
        let point = tip + (far - tip) * t;
        // Not for parallel edges: t is then not a number.
        if !(t > 0.0 && t < 1.0 && point.z > -self.pair.depth && point.z < 0.0) {
            return None;
        }
        let before = if u == 0 { hole.len() - 1 } else { u - 1 };
        let (to_wall, to_next) = (-hole.outward(before), -hole.outward(u));
        let across = Vector2::new(-along.y, along.x).normalize();
        let normal = across * across.dot(&(to_wall + to_next)).signum();
        let in_peg = self.rotation.tr_mul(&lift(&normal, 0.0)).xy();
        let n = peg.len();
        let here = peg.vertices()[i];
        let into_peg = (peg.vertices()[(i + 1) % n] - here)
            .dot(&in_peg)
            .min((peg.vertices()[(i + n - 1) % n] - here).dot(&in_peg));
        if normal.dot(&to_wall).min(normal.dot(&to_next)) < -CONE_SLACK || into_peg < 0.0 {
            return None;
        }
        let value = normal.dot(&(point.xy() - corner));
        if value < 0.0 && !(self.pierces_wall(&tip, &far, before) && self.pierces_wall(&tip, &far, u)) {
            return None;
        }
        let feature = Feature::SideEdgeWallCorner { peg_vertex: i, hole_vertex: u };
        Some(Candidate { value, point, normal: lift(&normal, 0.0), in_peg: false, feature })
    }

    /// Whether the segment passes through a wall.
    fn pierces_wall(&self, a: &Vector3<f64>, b: &Vector3<f64>, wall: usize) -> bool {
        let (r, s) = self.pair.hole.edge(wall);
        let (side_a, side_b) = ((s - r).perp(&(a.xy() - r.coords)), (s - r).perp(&(b.xy() - r.coords)));
        if side_a * side_b >= 0.0 {
            return false;
        }
        let through = a + (b - a) * (side_a / (side_a - side_b));
        let along = (through.xy() - r.coords).dot(&(s - r)) / (s - r).norm_squared();
        (0.0..=1.0).contains(&along) && through.z < 0.0 && through.z > -self.pair.depth
    }

    /// Edges of a peg end against the rim.
    fn end_edges<S: Sink>(&self, end: f64, sink: &mut S) {
        let pair = self.pair;
        for k in 0..pair.peg.len() {
            let (a, b) = pair.peg.edge(k);
            let place = |p: &Vector2<f64>| self.rotation * lift(p, end) + self.translation;
            let (a, b) = (place(&a.coords), place(&b.coords));
            let (low, high) = (a.z.min(b.z), a.z.max(b.z));
            if low >= sink.reach().max(0.0) || high <= -sink.reach().max(RIM_DEPTH) {
                continue;
            }
            if low < 0.0 && high > 0.0 {
                self.pierced_top((a, b), k, sink);
            }
            for j in 0..pair.hole.len() {
                let reach = sink.reach();
                let (r, s) = pair.hole.edge(j);
                let apart = |axis: usize| {
                    (a[axis].min(b[axis]) - r[axis].max(s[axis])).max(r[axis].min(s[axis]) - a[axis].max(b[axis]))
                };
                if apart(0).max(apart(1)) >= reach.abs().max(RIM_DEPTH) {
                    continue;
                }
                if let Some(candidate) = self.edge_rim((a, b), k, j, end) {
                    if candidate.value < sink.reach() {
                        sink.take(candidate);
                    }
                }
            }
        }
    }

    /// An edge of a peg end that passes through the top face: how far to the nearest point of the rim, or to lift its lower end.
    /// Overlap near the corners of the hole that [`Scan::edge_rim`] does not see, and never more than that where it does.
    fn pierced_top<S: Sink>(&self, (a, b): (Vector3<f64>, Vector3<f64>), k: usize, sink: &mut S) {
        let pair = self.pair;
        let e = b - a;
        let through = a - e * (a.z / e.z);
        if pair.hole.contains(&through.xy().into()) {
            return;
        }
        let mut best = Candidate::none();
        for j in 0..pair.hole.len() {
            let (r, s) = pair.hole.edge(j);
            let (r, s) = (lift(&r.coords, 0.0), lift(&s.coords, 0.0));
            let (point, on_rim) = nearest_points((a, b), (r, s));
            let out = on_rim - point;
            let distance = out.norm();
            if distance < -best.value || best.value > 0.0 {
                let normal = if distance > 0.0 { out / distance } else { Vector3::z() };
                let feature = Feature::EndEdgeRim { peg_edge: k, hole_edge: j };
                best = Candidate { value: -distance, point, normal, in_peg: false, feature };
            }
        }
        let (lower, vertex) = if a.z < b.z { (a, k) } else { (b, (k + 1) % pair.peg.len()) };
        if lower.z > best.value {
            let feature = Feature::CornerTop { peg_vertex: vertex };
            best = Candidate { value: lower.z, point: lower, normal: Vector3::z(), in_peg: false, feature };
        }
        if best.value < sink.reach() {
            sink.take(best);
        }
    }

    /// An edge of a peg end against a rim edge, if they are nearest at inner points and face each other.
    fn edge_rim(&self, (a, b): (Vector3<f64>, Vector3<f64>), k: usize, j: usize, end: f64) -> Option<Candidate> {
        let pair = self.pair;
        let (r, s) = pair.hole.edge(j);
        let (r, f) = (lift(&r.coords, 0.0), lift(&(s - r), 0.0));
        let e = b - a;
        let w = a - r;
        let (ee, ef, ff, ew, fw) = (e.dot(&e), e.dot(&f), f.dot(&f), e.dot(&w), f.dot(&w));
        let det = ee * ff - ef * ef;
        if det <= 1e-12 * ee * ff {
            return None;
        }
        let (on_peg, on_rim) = ((ef * fw - ff * ew) / det, (ee * fw - ef * ew) / det);
        if !(0.0..=1.0).contains(&on_peg) || !(0.0..=1.0).contains(&on_rim) {
            return None;
        }
        let into_cavity = lift(&-pair.hole.outward(j), 0.0);
        let cross = e.cross(&f);
        let towards_free = cross.dot(&(into_cavity + Vector3::z()));
        let normal = cross * (towards_free.signum() / cross.norm());
        let axis = if end > 0.0 { self.rotation.column(2).into_owned() } else { -self.rotation.column(2) };
        let side = self.rotation * lift(&pair.peg.outward(k), 0.0);
        if normal.z.min(normal.dot(&into_cavity)).min(-normal.dot(&axis)).min(-normal.dot(&side)) < -CONE_SLACK {
            return None;
        }
        let point = a + e * on_peg;
        let value = normal.dot(&(point - r));
        if value < 0.0 {
            // Overlap only if the edge passes from the cavity into the wall, and no deeper than its end is in the wall.
            let (behind_a, behind_b) = (-into_cavity.dot(&(a - r)), -into_cavity.dot(&(b - r)));
            if behind_a.min(behind_b) > 0.0 {
                return None;
            }
            let (point, behind) = if behind_a > behind_b { (a, behind_a) } else { (b, behind_b) };
            if behind < -value {
                let vertex = if behind_a > behind_b { k } else { (k + 1) % pair.peg.len() };
                let feature = Feature::CornerWall { peg_vertex: vertex, hole_edge: j };
                return Some(Candidate { value: -behind, point, normal: into_cavity, in_peg: false, feature });
            }
        }
        Some(Candidate {
            value,
            point,
            normal,
            in_peg: false,
            feature: Feature::EndEdgeRim { peg_edge: k, hole_edge: j },
        })
    }
}

/// A point to compare with a loop.
struct Query {
    vertex: usize,
    x: Vector2<f64>,
    /// Heights of the loop that count.
    range: (f64, f64),
    /// +1 if the free side is the inside of the loop, else −1.
    free: f64,
}

/// Reports the nearest edge of a loop to a point on the free side; all edges within reach if the sink wants them.
fn free_offsets<S: Sink>(
    around: &Loop,
    query: &Query,
    foot: &Foot,
    sink: &mut S,
    candidate: impl Fn(&Offset) -> Candidate,
) {
    if foot.distance >= sink.reach() {
        return;
    }
    if !S::ALL {
        let candidate = candidate(&around.from_foot(&query.x, foot, query.free));
        if candidate.value < sink.reach() {
            sink.take(candidate);
        }
        return;
    }
    let reach = sink.reach();
    around.near.scan(query.vertex, around.moved, |edge| {
        let foot = around.foot(edge, &query.x);
        let height = around.height_at(edge, foot.t);
        // A vertex counts once, at the start of its edge, and only if it points to the free side.
        let counts = !foot.at_vertex() || (foot.t <= 0.0 && around.profile.is_convex_at(edge) == (query.free < 0.0));
        let offset = around.from_foot(&query.x, &foot, query.free);
        if counts && offset.value >= 0.0 && query.range.0 <= height && height <= query.range.1 {
            let candidate = candidate(&offset);
            if candidate.value < reach {
                sink.take(candidate);
            }
        }
        reach
    });
}

/// Reports the offsets of a penetrating point.
fn deep_offsets<S: Sink>(offsets: (Offset, Option<Offset>), sink: &mut S, candidate: impl Fn(&Offset) -> Candidate) {
    for offset in [Some(offsets.0), offsets.1].into_iter().flatten() {
        if offset.value < sink.reach() {
            sink.take(candidate(&offset));
        }
    }
}

/// The points of two segments nearest to each other (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.9).
fn nearest_points(
    (a, b): (Vector3<f64>, Vector3<f64>),
    (r, s): (Vector3<f64>, Vector3<f64>),
) -> (Vector3<f64>, Vector3<f64>) {
    let (e, f, w) = (b - a, s - r, a - r);
    let (ee, ef, ff, ew, fw) = (e.dot(&e), e.dot(&f), f.dot(&f), e.dot(&w), f.dot(&w));
    let det = ee * ff - ef * ef;
    let first = if det > 1e-12 * ee * ff { ((ef * fw - ff * ew) / det).clamp(0.0, 1.0) } else { 0.0 };
    let second = ((ef * first + fw) / ff).clamp(0.0, 1.0);
    let first = ((ef * second - ew) / ee).clamp(0.0, 1.0);
    (a + e * first, r + f * second)
}

/// Most that the map displaces a point of an outline, attained at a vertex of its hull.
fn displacement(profile: &Profile, hull: &[usize], linear: &Matrix2<f64>, offset: &Vector2<f64>) -> f64 {
    let change = linear - Matrix2::identity();
    let squared =
        hull.iter().map(|&i| (change * profile.vertices()[i].coords + offset).norm_squared()).fold(0.0, f64::max);
    squared.sqrt()
}

/// An outline in its own plane.
fn still<'a>(profile: &'a Profile, near: &'a Nearness) -> Loop<'a> {
    Loop {
        profile,
        linear: Matrix2::identity(),
        offset: Vector2::zeros(),
        slope: Vector2::zeros(),
        height: 0.0,
        moved: 0.0,
        turn: 1.0,
        near,
    }
}

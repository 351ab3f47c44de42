//! Distances between edges of the peg and edges of the solid, in space.

use super::feature::{Feature, FeatureDistance, Sink};
use super::feature_sweep::{FeatureSweep, lift};
use super::projected_polygon::ProjectedPolygon;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Beyond this depth (m) of a peg end below the top face, its edges are no longer compared with the
/// rim from below: the walls are nearer.
pub(super) const RIM_DEPTH: f64 = 1e-3;

/// Slack of the test that a normal lies between two faces' normals.
const CONE_SLACK: f64 = 1e-9;

/// Two points, in the hole frame.
type Segment = (Vector3<f64>, Vector3<f64>);

/// Longitudinal edges of the peg against wall corners.
pub(super) fn crossing_corners<S: Sink>(sweep: &FeatureSweep<'_>, sink: &mut S) {
    let pair = sweep.pair;
    let axis: Vector3<f64> = sweep.rotation.column(2).into_owned();
    if pair.closest_corners - strayed(sweep) >= sink.reach() {
        return;
    }
    for &i in &pair.peg_corners {
        let aligned = lift(&pair.eroded_peg.vertices()[i].coords, 0.0);
        let tip = sweep.rotation * aligned + sweep.translation;
        let far = tip + axis * pair.eroded_length;
        if tip.z.min(far.z) >= 0.0 || (sink.reach() <= 0.0 && is_beside_hole(sweep, (tip, far))) {
            continue;
        }
        // Between tip and top face the edge strays no more than at one of the two.
        let moved = if axis.z > 0.3 {
            let through = tip - axis * (tip.z / axis.z);
            (tip - aligned).xy().norm_squared().max((through - aligned).xy().norm_squared()).sqrt()
        } else {
            f64::INFINITY
        };
        // A corner is where its edge starts, and no nearer than that.
        for u in pair.peg_to_hole.within(i, sink.reach() + moved) {
            if !pair.eroded_hole.is_convex_at(u)
                && let Some(candidate) = crossing(sweep, (tip, far), i, u)
                && candidate.value < sink.reach()
            {
                sink.take(candidate);
            }
        }
    }
}

/// Most that a longitudinal edge of the peg strays sideways from its aligned place below the
/// top face.
fn strayed(sweep: &FeatureSweep<'_>) -> f64 {
    let (r, radius) = (&sweep.rotation, sweep.pair.peg_radius);
    if r[(2, 2)] <= 0.3 {
        return f64::INFINITY;
    }
    let turn = r.fixed_view::<2, 2>(0, 0) - Matrix2::identity();
    let tilt = sweep.tilt();
    let depth = (tilt * radius - sweep.translation.z).max(0.0);
    // At the tip, and from there up to the top face.
    sweep.translation.xy().norm() + turn.norm() * radius + depth * tilt / r[(2, 2)]
}

/// A longitudinal edge against a wall corner, if they are nearest at inner points and face each
/// other.
fn crossing(sweep: &FeatureSweep<'_>, (tip, far): Segment, i: usize, u: usize) -> Option<FeatureDistance> {
    let (peg, hole) = (&sweep.pair.eroded_peg, &sweep.pair.eroded_hole);
    let corner = hole.vertices()[u].coords;
    let along = (far - tip).xy();
    let t = (corner - tip.xy()).dot(&along) / along.norm_squared();
    let point = tip + (far - tip) * t;
    // Not for parallel edges: t is then not a number.
    if !(t > 0.0 && t < 1.0 && point.z > -sweep.pair.depth && point.z < 0.0) {
        return None;
    }
    let before = if u == 0 { hole.len() - 1 } else { u - 1 };
    let (to_wall, to_next) = (-hole.outward(before), -hole.outward(u));
    let across = Vector2::new(-along.y, along.x).normalize();
    let normal = across * across.dot(&(to_wall + to_next)).signum();
    let in_peg = sweep.rotation.tr_mul(&lift(&normal, 0.0)).xy();
    let n = peg.len();
    let here = peg.vertices()[i];
    let into_peg =
        (peg.vertices()[(i + 1) % n] - here).dot(&in_peg).min((peg.vertices()[(i + n - 1) % n] - here).dot(&in_peg));
    if normal.dot(&to_wall).min(normal.dot(&to_next)) < -CONE_SLACK || into_peg < 0.0 {
        return None;
    }
    let value = normal.dot(&(point.xy() - corner));
    if value < 0.0 && !(pierces_wall(sweep, &tip, &far, before) && pierces_wall(sweep, &tip, &far, u)) {
        return None;
    }
    let feature = Feature::SideEdgeWallCorner { peg_vertex: i, hole_vertex: u };
    Some(FeatureDistance { value, point, normal: lift(&normal, 0.0), in_peg: false, feature })
}

/// Whether a segment for sure passes no wall, being far to one side of them all: as is all of a
/// peg that is far from where it belongs.
fn is_beside_hole(sweep: &FeatureSweep<'_>, (a, b): Segment) -> bool {
    let radius = sweep.pair.hole_radius;
    (0..2).any(|k| a[k].min(b[k]) > radius || a[k].max(b[k]) < -radius)
}

/// Whether the segment passes through a wall.
fn pierces_wall(sweep: &FeatureSweep<'_>, a: &Vector3<f64>, b: &Vector3<f64>, wall: usize) -> bool {
    let (r, s) = sweep.pair.eroded_hole.edge(wall);
    let (side_a, side_b) = ((s - r).perp(&(a.xy() - r.coords)), (s - r).perp(&(b.xy() - r.coords)));
    if side_a * side_b >= 0.0 {
        return false;
    }
    let through = a + (b - a) * (side_a / (side_a - side_b));
    let along = (through.xy() - r.coords).dot(&(s - r)) / (s - r).norm_squared();
    (0.0..=1.0).contains(&along) && through.z < 0.0 && through.z > -sweep.pair.depth
}

/// Edges of a peg end against the rim.
pub(super) fn end_edges<S: Sink>(sweep: &FeatureSweep<'_>, ring: &ProjectedPolygon, end: f64, sink: &mut S) {
    let pair = sweep.pair;
    for k in 0..pair.eroded_peg.len() {
        let (a, b) = pair.eroded_peg.edge(k);
        let place = |p: &Vector2<f64>| sweep.rotation * lift(p, end) + sweep.translation;
        let (a, b) = (place(&a.coords), place(&b.coords));
        let (low, high) = (a.z.min(b.z), a.z.max(b.z));
        // An edge overlaps by no more than its length.
        let deepest = RIM_DEPTH.min((b - a).norm());
        if low >= sink.reach().max(0.0) || high <= -sink.reach().max(deepest) {
            continue;
        }
        if low < 0.0 && high > 0.0 {
            pierced_top(sweep, (a, b), k, sink);
        }
        for j in pair.edge_to_edge.within(k, sink.reach().abs().max(deepest) + ring.moved) {
            let limit = sink.reach().abs().max(deepest);
            let (r, s) = pair.eroded_hole.edge(j);
            let apart = |axis: usize| {
                (a[axis].min(b[axis]) - r[axis].max(s[axis])).max(r[axis].min(s[axis]) - a[axis].max(b[axis]))
            };
            if apart(0) >= limit || apart(1) >= limit {
                continue;
            }
            if let Some(candidate) = edge_rim(sweep, (a, b), k, j, end)
                && candidate.value < sink.reach()
            {
                sink.take(candidate);
            }
        }
    }
}

/// An edge of a peg end that passes through the top face: how far to the nearest point of the
/// rim, or to lift its lower end. Overlap near the corners of the hole that [`edge_rim`]
/// does not see, and never more than that where it does.
fn pierced_top<S: Sink>(sweep: &FeatureSweep<'_>, (a, b): Segment, k: usize, sink: &mut S) {
    let pair = sweep.pair;
    let e = b - a;
    let through = a - e * (a.z / e.z);
    if pair.eroded_hole.contains(&through.xy().into()) {
        return;
    }
    let mut best = FeatureDistance::none();
    for j in 0..pair.eroded_hole.len() {
        let (r, s) = pair.eroded_hole.edge(j);
        let (r, s) = (lift(&r.coords, 0.0), lift(&s.coords, 0.0));
        let (point, on_rim) = nearest_points((a, b), (r, s));
        best = best.or_shallower(point, on_rim - point, Feature::EndEdgeRim { peg_edge: k, hole_edge: j });
    }
    let (lower, vertex) = if a.z < b.z { (a, k) } else { (b, (k + 1) % pair.eroded_peg.len()) };
    if lower.z > best.value {
        let feature = Feature::CornerTop { peg_vertex: vertex };
        best = FeatureDistance { value: lower.z, point: lower, normal: Vector3::z(), in_peg: false, feature };
    }
    if best.value < sink.reach() {
        sink.take(best);
    }
}

/// Rim edges that pass through an end face of the peg: the counterpart of
/// [`pierced_top`].
pub(super) fn pierced_end<S: Sink>(sweep: &FeatureSweep<'_>, end: f64, sink: &mut S) {
    let pair = sweep.pair;
    let inward: Vector3<f64> =
        if end > 0.0 { -sweep.rotation.column(2) } else { sweep.rotation.column(2).into_owned() };
    let to_peg = |p: &Vector3<f64>| sweep.rotation.tr_mul(p) + sweep.hole_in_peg;
    for j in 0..pair.eroded_hole.len() {
        let (r, s) = pair.eroded_hole.edge(j);
        let (r, s) = (lift(&r.coords, 0.0), lift(&s.coords, 0.0));
        let depth = |p: &Vector3<f64>| inward.dot(&(p - sweep.translation)) + if end > 0.0 { end } else { 0.0 };
        let (at_r, at_s) = (depth(&r), depth(&s));
        if at_r * at_s >= 0.0 {
            continue;
        }
        let through = to_peg(&(r + (s - r) * (at_r / (at_r - at_s))));
        if !pair.eroded_peg.contains(&through.xy().into()) {
            continue;
        }
        let mut best = FeatureDistance::none();
        for k in 0..pair.eroded_peg.len() {
            let (a, b) = pair.eroded_peg.edge(k);
            let place = |p: &Vector2<f64>| sweep.rotation * lift(p, end) + sweep.translation;
            let (point, on_rim) = nearest_points((place(&a.coords), place(&b.coords)), (r, s));
            best = best.or_shallower(point, on_rim - point, Feature::EndEdgeRim { peg_edge: k, hole_edge: j });
        }
        let (deeper, inside, vertex) =
            if at_r > at_s { (r, at_r, j) } else { (s, at_s, (j + 1) % pair.eroded_hole.len()) };
        if -inside > best.value {
            let feature = Feature::RimCornerEnd { hole_vertex: vertex };
            best = FeatureDistance {
                value: -inside,
                point: deeper - inward * inside,
                normal: inward,
                in_peg: false,
                feature,
            };
        }
        if best.value < sink.reach() {
            sink.take(best);
        }
    }
}

/// An edge of a peg end against a rim edge, if they are nearest at inner points and face each
/// other.
fn edge_rim(sweep: &FeatureSweep<'_>, (a, b): Segment, k: usize, j: usize, end: f64) -> Option<FeatureDistance> {
    let pair = sweep.pair;
    let (r, s) = pair.eroded_hole.edge(j);
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
    let into_cavity = lift(&-pair.eroded_hole.outward(j), 0.0);
    let cross = e.cross(&f);
    let towards_free = cross.dot(&(into_cavity + Vector3::z()));
    let normal = cross * (towards_free.signum() / cross.norm());
    let axis = if end > 0.0 { sweep.rotation.column(2).into_owned() } else { -sweep.rotation.column(2) };
    let side = sweep.rotation * lift(&pair.eroded_peg.outward(k), 0.0);
    if normal.z.min(normal.dot(&into_cavity)).min(-normal.dot(&axis)).min(-normal.dot(&side)) < -CONE_SLACK {
        return None;
    }
    let point = a + e * on_peg;
    let value = normal.dot(&(point - r));
    if value < 0.0 {
        // Overlap only if the edge passes from the cavity into the wall, and no deeper than its
        // end is in the wall.
        let (behind_a, behind_b) = (-into_cavity.dot(&(a - r)), -into_cavity.dot(&(b - r)));
        if behind_a.min(behind_b) > 0.0 {
            // In the wall with both ends: out over the rim, unless an end is sooner out by
            // itsweep.
            let sooner = behind_a.max(behind_b).min(-a.z.min(b.z));
            let feature = Feature::EndEdgeRim { peg_edge: k, hole_edge: j };
            return (-value < sooner).then_some(FeatureDistance { value, point, normal, in_peg: false, feature });
        }
        let (point, behind) = if behind_a > behind_b { (a, behind_a) } else { (b, behind_b) };
        if behind < -value {
            let vertex = if behind_a > behind_b { k } else { (k + 1) % pair.eroded_peg.len() };
            let feature = Feature::CornerWall { peg_vertex: vertex, hole_edge: j };
            return Some(FeatureDistance { value: -behind, point, normal: into_cavity, in_peg: false, feature });
        }
    }
    Some(FeatureDistance {
        value,
        point,
        normal,
        in_peg: false,
        feature: Feature::EndEdgeRim { peg_edge: k, hole_edge: j },
    })
}

/// Peg edges that pass through a wall and that the nearer tests may have missed because the peg
/// leans over or into the solid by more than an edge's width: how far to draw the edge's end
/// back out, or to slip it over the wall's convex borders, whichever is least.
pub(super) fn pierced_walls<S: Sink>(sweep: &FeatureSweep<'_>, sink: &mut S) {
    let pair = sweep.pair;
    let place = |p: &Vector2<f64>, z: f64| sweep.rotation * lift(p, z) + sweep.translation;
    for k in 0..pair.eroded_peg.len() {
        let (a, b) = pair.eroded_peg.edge(k);
        for end in [0.0, pair.eroded_length] {
            pierced_by(
                sweep,
                (place(&a.coords, end), place(&b.coords, end)),
                (k, (k + 1) % pair.eroded_peg.len()),
                sink,
            );
        }
        if pair.eroded_peg.is_convex_at(k) {
            pierced_by(sweep, (place(&a.coords, 0.0), place(&a.coords, pair.eroded_length)), (k, k), sink);
        }
    }
}

/// The peg edge from one vertex to another, or along the peg at one vertex.
fn pierced_by<S: Sink>(sweep: &FeatureSweep<'_>, (a, b): Segment, (from, to): (usize, usize), sink: &mut S) {
    let hole = &sweep.pair.eroded_hole;
    if a.z.min(b.z) >= 0.0 || is_beside_hole(sweep, (a, b)) {
        return;
    }
    for j in 0..hole.len() {
        if !pierces_wall(sweep, &a, &b, j) {
            continue;
        }
        let (r, s) = hole.edge(j);
        let into_wall = lift(&hole.outward(j), 0.0);
        let (behind_a, behind_b) =
            (into_wall.dot(&(a - lift(&r.coords, 0.0))), into_wall.dot(&(b - lift(&r.coords, 0.0))));
        let (end, behind, vertex) = if behind_a > behind_b { (a, behind_a, from) } else { (b, behind_b, to) };
        let feature = Feature::CornerWall { peg_vertex: vertex, hole_edge: j };
        let mut best = FeatureDistance::none().or_shallower(end, -into_wall * behind, feature);
        let feature = if from == to {
            Feature::SideEdgeRim { peg_vertex: from, hole_edge: j }
        } else {
            Feature::EndEdgeRim { peg_edge: from, hole_edge: j }
        };
        let (point, on_rim) = nearest_points((a, b), (lift(&r.coords, 0.0), lift(&s.coords, 0.0)));
        best = best.or_shallower(point, on_rim - point, feature);
        for u in [j, (j + 1) % hole.len()] {
            if !hole.is_convex_at(u) {
                let corner = hole.vertices()[u].coords;
                let (point, on_corner) = nearest_points((a, b), (lift(&corner, -sweep.pair.depth), lift(&corner, 0.0)));
                let feature = if from == to {
                    Feature::SideEdgeWallCorner { peg_vertex: from, hole_vertex: u }
                } else {
                    Feature::WallCornerEndEdge { hole_vertex: u, peg_edge: from }
                };
                best = best.or_shallower(point, on_corner - point, feature);
            }
        }
        if best.value < sink.reach() {
            sink.take(best);
        }
    }
}

/// The points of two segments nearest to each other (Ericson, *Real-Time Collision Detection*,
/// 2005, section 5.1.9).
fn nearest_points((a, b): Segment, (r, s): Segment) -> Segment {
    let (e, f, w) = (b - a, s - r, a - r);
    let (ee, ef, ff, ew, fw) = (e.dot(&e), e.dot(&f), f.dot(&f), e.dot(&w), f.dot(&w));
    let det = ee * ff - ef * ef;
    let first = if det > 1e-12 * ee * ff { ((ef * fw - ff * ew) / det).clamp(0.0, 1.0) } else { 0.0 };
    let second = ((ef * first + fw) / ff).clamp(0.0, 1.0);
    let first = ((ef * second - ew) / ee).clamp(0.0, 1.0);
    (a + e * first, r + f * second)
}

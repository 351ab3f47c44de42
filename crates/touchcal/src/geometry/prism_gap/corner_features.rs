//! Distances between corners or upright edges of one body and the outline of the other.

use super::feature::{Feature, FeatureDistance, Sink};
use super::feature_sweep::{FeatureSweep, lift};
use super::projected_polygon::{ClosestPoint, Offset, ProjectedPolygon, Query, TOUCHING, still};
use super::vertex_edge_bounds::{NearEdge, lesser};
use nalgebra::{Vector2, Vector3};

const UNLIMITED: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
/// Vertices whose bounds are compared at a time.
const CHUNK: usize = 64;

/// Corners of a peg end against walls, rim, top face and floor.
pub(super) fn corners<S: Sink>(sweep: &FeatureSweep<'_>, ring: &ProjectedPolygon, end: f64, sink: &mut S) {
    let pair = sweep.pair;
    let bound = |i: usize| {
        let aligned = pair.eroded_peg.vertices()[i].coords;
        let z = ring.height_of(&aligned);
        let moved = ring.linear * aligned + ring.offset - aligned;
        let walls = pair.peg_to_hole.bound(i, ring.moved, |near| near.away.dot(&moved));
        let walls = if pair.peg_clearance[i] > 0.0 { walls } else { -1.0 };
        let walls = pair.inner_radius.map_or(walls, |radius| walls.max(radius - (aligned + moved).norm()));
        walls.max(z).min(z + pair.depth)
    };
    promising(&pair.peg_corners, sink, bound, |i, free, sink| corner(sweep, (i, end), free, sink));
}

/// A corner of a peg end against walls, rim, top face and floor.
fn corner<S: Sink>(sweep: &FeatureSweep<'_>, (i, end): (usize, f64), free: bool, sink: &mut S) {
    let pair = sweep.pair;
    let mut walls = still(&pair.eroded_hole, &pair.peg_to_hole);
    let aligned = pair.eroded_peg.vertices()[i].coords;
    let corner = sweep.rotation * lift(&aligned, end) + sweep.translation;
    let xy = corner.xy();
    let z = corner.z;
    walls.moved = (xy - aligned).norm();
    let upright = |value: f64, feature: Feature| FeatureDistance {
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
        return;
    }
    let to_wall = |offset: &Offset| {
        let value = if z > 0.0 { (offset.value * offset.value + z * z).sqrt() } else { offset.value };
        let normal = if z > 0.0 { lift(&(offset.normal * offset.value), z) / value } else { lift(&offset.normal, 0.0) };
        let feature = Feature::CornerWall { peg_vertex: i, hole_edge: offset.edge };
        FeatureDistance { value, point: corner, normal, in_peg: false, feature }
    };
    let query = Query { vertex: i, x: xy, moved: xy - aligned, range: UNLIMITED, free: 1.0 };
    if free && z <= 0.0 {
        // The bound is that of the walls.
        return free_offsets(&walls, &query, None, sink, to_wall);
    }
    let (foot, _) = walls.nearest(&query, f64::INFINITY);
    if walls.encloses(&xy, &foot) {
        free_offsets(&walls, &query, Some(foot), sink, to_wall);
    } else if z > 0.0 || foot.distance > -z {
        if z < sink.reach() {
            sink.take(upright(z, Feature::CornerTop { peg_vertex: i }));
        }
    } else {
        deep_offsets(walls.beyond(&xy, &foot, 1.0), sink, to_wall);
    }
}

/// Corners of the rim against the peg's sides and ends.
pub(super) fn rim_corners<S: Sink>(sweep: &FeatureSweep<'_>, rim: &ProjectedPolygon, sink: &mut S) {
    let pair = sweep.pair;
    let bound = |u: usize| {
        if pair.hole_clearance[u] <= 0.0 {
            return -1.0;
        }
        let aligned = pair.eroded_hole.vertices()[u].coords;
        let moved = rim.linear * aligned + rim.offset - aligned;
        pair.hole_to_peg.bound(u, rim.moved, |near| near.away.dot(&moved))
    };
    promising(&pair.wall_corners, sink, bound, |u, free, sink| rim_corner(sweep, u, free, sink));
}

/// A corner of the rim against the peg's sides and ends.
fn rim_corner<S: Sink>(sweep: &FeatureSweep<'_>, u: usize, free: bool, sink: &mut S) {
    let pair = sweep.pair;
    let mut sides = still(&pair.eroded_peg, &pair.hole_to_peg);
    let aligned = pair.eroded_hole.vertices()[u].coords;
    let corner = sweep.rotation.tr_mul(&lift(&aligned, 0.0)) + sweep.hole_in_peg;
    let (xy, z) = (corner.xy(), corner.z);
    sides.moved = (xy - aligned).norm();
    // How far beyond the nearer end face, along the axis.
    let over = if z < 0.5 * pair.eroded_length { -z } else { z - pair.eroded_length };
    let outward = if z < 0.5 * pair.eroded_length { -1.0 } else { 1.0 };
    if over >= sink.reach() || pair.hole_clearance[u] - sides.moved >= sink.reach() {
        return;
    }
    let to_side = |offset: &Offset| {
        let from_peg =
            if over > 0.0 { lift(&(offset.normal * offset.value), outward * over) } else { lift(&offset.normal, 0.0) };
        let value = if over > 0.0 { (offset.value * offset.value + over * over).sqrt() } else { offset.value };
        let normal = if over > 0.0 { -from_peg / value } else { -from_peg };
        let feature = Feature::RimCornerSide { hole_vertex: u, peg_edge: offset.edge };
        FeatureDistance { value, point: corner + normal * value, normal, in_peg: true, feature }
    };
    let query = Query { vertex: u, x: xy, moved: xy - aligned, range: UNLIMITED, free: -1.0 };
    if free {
        return free_offsets(&sides, &query, None, sink, to_side);
    }
    let beside = beside_peg(sweep, &sides, &xy);
    if beside > 0.0 && beside.hypot(over.max(0.0)) >= sink.reach() {
        return;
    }
    let (foot, _) = sides.nearest(&query, f64::INFINITY);
    if !sides.encloses(&xy, &foot) {
        free_offsets(&sides, &query, Some(foot), sink, to_side);
    } else if over > 0.0 || foot.distance > -over {
        if over < sink.reach() {
            let normal = Vector3::z() * -outward;
            let feature = Feature::RimCornerEnd { hole_vertex: u };
            sink.take(FeatureDistance { value: over, point: corner + normal * over, normal, in_peg: true, feature });
        }
    } else {
        deep_offsets(sides.beyond(&xy, &foot, -1.0), sink, to_side);
    }
}

/// Wall corners against the edges of a peg end.
pub(super) fn wall_corners<S: Sink>(sweep: &FeatureSweep<'_>, ring: &ProjectedPolygon, end: f64, sink: &mut S) {
    let pair = sweep.pair;
    let bound = |u: usize| if pair.hole_clearance[u] > 0.0 { ring.bound(u) } else { -1.0 };
    promising(&pair.wall_corners, sink, bound, |u, free, sink| wall_corner(sweep, ring, (u, end), free, sink));
}

/// A wall corner against the edges of a peg end.
fn wall_corner<S: Sink>(
    sweep: &FeatureSweep<'_>,
    ring: &ProjectedPolygon,
    (u, end): (usize, f64),
    free: bool,
    sink: &mut S,
) {
    let pair = sweep.pair;
    let range = (-pair.depth, 0.0);
    if pair.hole_clearance[u] - ring.moved >= sink.reach() {
        return;
    }
    let xy = pair.eroded_hole.vertices()[u].coords;
    let to_edge = |offset: &Offset| {
        let foot = xy - offset.normal * offset.value;
        let point = lift(&foot, ring.height_at(offset.edge, offset.t));
        let feature = Feature::WallCornerEndEdge { hole_vertex: u, peg_edge: offset.edge };
        FeatureDistance { value: offset.value, point, normal: lift(&-offset.normal, 0.0), in_peg: false, feature }
    };
    let query = Query { vertex: u, x: xy, moved: Vector2::zeros(), range, free: -1.0 };
    if free {
        return free_offsets(ring, &query, None, sink, to_edge);
    }
    let over_end = sweep.rotation.column(2).dot(&(lift(&xy, 0.0) - sweep.translation)) - end;
    let beside = beside_peg(sweep, ring, &xy);
    if no_deeper(-over_end.abs(), sink) || (beside > 0.0 && beside >= sink.reach()) {
        return;
    }
    let (any, foot) = ring.nearest(&query, sink.reach());
    let pierce = -over_end / sweep.rotation[(2, 2)];
    if !(ring.encloses(&xy, &any) && range.0 < pierce && pierce < range.1) {
        if !ring.encloses(&xy, &any) {
            free_offsets(ring, &query, Some(foot), sink, to_edge);
        }
        return;
    }
    let (_, foot) = ring.nearest(&query, f64::INFINITY);
    if foot.distance <= over_end.abs() {
        deep_offsets(ring.beyond(&xy, &foot, -1.0), sink, to_edge);
    } else if foot.distance.is_finite() && -over_end.abs() < sink.reach() {
        // Shorter to move the end face off the top of this corner.
        let normal = sweep.rotation.column(2) * over_end.signum();
        let corner = lift(&xy, 0.0);
        let (value, feature) = (-over_end.abs(), Feature::RimCornerEnd { hole_vertex: u });
        sink.take(FeatureDistance { value, point: corner + normal * value, normal, in_peg: false, feature });
    }
}

/// How far a point at least is from an image of the peg's outline, if it is outside of it for
/// sure: a number above zero.
fn beside_peg(sweep: &FeatureSweep<'_>, outline: &ProjectedPolygon, x: &Vector2<f64>) -> f64 {
    (x - outline.offset).norm() - sweep.pair.peg_radius
}

/// Longitudinal edges of the peg against the rim.
pub(super) fn side_edges<S: Sink>(sweep: &FeatureSweep<'_>, rim: &ProjectedPolygon, sink: &mut S) {
    let pair = sweep.pair;
    // Seen along the peg's axis, circles are ellipses.
    let inner_radius = pair.inner_radius.map(|radius| sweep.rotation[(2, 2)].abs() * radius);
    let bound = |i: usize| {
        let bound = if pair.peg_clearance[i] > 0.0 { rim.bound(i) } else { -1.0 };
        let from_middle = || (pair.eroded_peg.vertices()[i].coords - rim.offset).norm();
        inner_radius.map_or(bound, |radius| bound.max(radius - from_middle()))
    };
    promising(&pair.peg_corners, sink, bound, |i, free, sink| side_edge(sweep, rim, i, free, sink));
}

/// A longitudinal edge of the peg against the rim.
fn side_edge<S: Sink>(sweep: &FeatureSweep<'_>, rim: &ProjectedPolygon, i: usize, free: bool, sink: &mut S) {
    let pair = sweep.pair;
    let range = (0.0, pair.eroded_length);
    if pair.peg_clearance[i] - rim.moved >= sink.reach() {
        return;
    }
    let xy = pair.eroded_peg.vertices()[i].coords;
    let to_rim = |offset: &Offset| {
        let point = lift(&xy, rim.height_at(offset.edge, offset.t));
        let feature = Feature::SideEdgeRim { peg_vertex: i, hole_edge: offset.edge };
        FeatureDistance { value: offset.value, point, normal: lift(&offset.normal, 0.0), in_peg: true, feature }
    };
    let query = Query { vertex: i, x: xy, moved: Vector2::zeros(), range, free: 1.0 };
    if free {
        return free_offsets(rim, &query, None, sink, to_rim);
    }
    let tip = sweep.rotation * lift(&xy, 0.0) + sweep.translation;
    let lower = if tip.z <= 0.0 { tip } else { tip + sweep.rotation.column(2) * pair.eroded_length };
    if no_deeper(lower.z, sink) {
        return;
    }
    let (any, foot) = rim.nearest(&query, sink.reach());
    let pierce = -tip.z / sweep.rotation[(2, 2)];
    if rim.encloses(&xy, &any) || pierce <= 0.0 || pierce >= pair.eroded_length {
        free_offsets(rim, &query, Some(foot), sink, to_rim);
        return;
    }
    let (_, foot) = rim.nearest(&query, f64::INFINITY);
    if foot.distance <= -lower.z {
        deep_offsets(rim.beyond(&xy, &foot, 1.0), sink, to_rim);
    } else if foot.distance.is_finite() && lower.z < sink.reach() {
        // Shorter to lift the edge's lower end out of the top face.
        let feature = Feature::CornerTop { peg_vertex: i };
        sink.take(FeatureDistance { value: lower.z, point: lower, normal: Vector3::z(), in_peg: false, feature });
    }
}

/// Whether an overlap that a way out of this depth (m, negative) ends is of no interest, nor any
/// distance.
fn no_deeper<S: Sink>(depth: f64, sink: &S) -> bool {
    sink.reach() <= depth.min(-TOUCHING)
}

/// Calls `visit` for the vertices whose distance can be below the sink's reach, the most promising
/// first; its argument says whether the bound is positive. `bound` is a lower bound of the distance
/// unless it is negative.
#[inline]
fn promising<S: Sink>(
    vertices: &[usize],
    sink: &mut S,
    bound: impl Fn(usize) -> f64,
    visit: impl Fn(usize, bool, &mut S),
) {
    let mut bounds = [0.0; CHUNK];
    for chunk in vertices.chunks(CHUNK) {
        let mut least = f64::INFINITY;
        for (place, &vertex) in bounds.iter_mut().zip(chunk) {
            *place = bound(vertex);
            least = lesser(*place, least);
        }
        if least >= sink.reach().max(0.0) {
            continue;
        }
        let first = bounds.iter().position(|&bound| bound == least).unwrap_or(0);
        visit(chunk[first], least > 0.0, sink);
        for (k, (&bound, &vertex)) in bounds.iter().zip(chunk).enumerate() {
            if k != first && bound < sink.reach().max(0.0) {
                visit(vertex, bound > 0.0, sink);
            }
        }
    }
}

/// Reports the nearest edge of a loop to a point on the free side; all edges within reach if the
/// sink wants them. `foot` is the nearest point that counts, if that is known.
#[inline]
fn free_offsets<S: Sink>(
    around: &ProjectedPolygon,
    query: &Query,
    foot: Option<ClosestPoint>,
    sink: &mut S,
    candidate: impl Fn(&Offset) -> FeatureDistance,
) {
    if !S::ALL {
        let foot = foot.unwrap_or_else(|| around.nearest(query, sink.reach()).1);
        if foot.distance < sink.reach() {
            let candidate = candidate(&around.foot_offset(&query.x, &foot, query.free));
            if candidate.value < sink.reach() {
                sink.take(candidate);
            }
        }
        return;
    }
    if foot.is_some_and(|foot| foot.distance >= sink.reach()) {
        return;
    }
    let parted = |near: &NearEdge| around.parted(near, &query.moved);
    around.near.scan(query.vertex, (sink.reach(), around.moved), parted, |edge| {
        let Some(offset) = around.edge_offset(&query.x, edge, query.free) else {
            return sink.reach();
        };
        if !(-TOUCHING..sink.reach()).contains(&offset.value) {
            return sink.reach();
        }
        let height = around.height_at(edge, offset.t);
        if query.range.0 <= height && height <= query.range.1 {
            let candidate = candidate(&offset);
            if candidate.value < sink.reach() {
                sink.take(candidate);
            }
        }
        sink.reach()
    });
}

/// Reports the offsets of a penetrating point.
fn deep_offsets<S: Sink>(offsets: [Option<Offset>; 3], sink: &mut S, candidate: impl Fn(&Offset) -> FeatureDistance) {
    for offset in offsets.into_iter().flatten() {
        if offset.value < sink.reach() {
            sink.take(candidate(&offset));
        }
    }
}

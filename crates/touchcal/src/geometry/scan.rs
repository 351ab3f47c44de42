//! One sweep over the features of a peg and a hole at a pose.

use super::extrusion::{Feature, PegAndHole};
use super::silhouette::{Foot, Loop, Offset, Query, displacement, still};
use crate::se3::Pose;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Beyond this depth (m) of a peg end below the top face, its edges are no longer compared with the rim from below: the
/// walls are nearer.
pub(super) const RIM_DEPTH: f64 = 1e-3;
/// Cosine of the tilt beyond which a peg edge can run right through a wall unseen by the nearer tests.
const LEANING: f64 = 0.99;

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

impl Candidate {
    /// This overlap, or the one ended by moving the peg's `point` by `out` (hole frame) if that is shorter.
    pub(super) fn or_shallower(self, point: Vector3<f64>, out: Vector3<f64>, feature: Feature) -> Self {
        let distance = out.norm();
        if self.value < 0.0 && distance >= -self.value {
            return self;
        }
        let normal = if distance > 0.0 { out / distance } else { Vector3::z() };
        Candidate { value: -distance, point, normal, in_peg: false, feature }
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

/// A peg and a hole at a pose.
pub(super) struct Scan<'a> {
    pub(super) pair: &'a PegAndHole,
    pub(super) rotation: Matrix3<f64>,
    pub(super) translation: Vector3<f64>,
    /// The hole's origin in the peg frame.
    pub(super) hole_in_peg: Vector3<f64>,
}

const UNLIMITED: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

pub(super) fn lift(v: &Vector2<f64>, z: f64) -> Vector3<f64> {
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
            if lowest < 0.0 && highest > 0.0 {
                self.pierced_end(end, sink);
            }
        }
        self.rim_corners(sink);
        self.side_edges(sink);
        self.crossing_corners(sink);
        if self.rotation[(2, 2)] < LEANING {
            self.pierced_walls(sink);
        }
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
                continue;
            }
            let (_, foot) = ring.nearest(&query, f64::INFINITY);
            if foot.distance <= over_end.abs() {
                deep_offsets(ring.beyond(&xy, &foot, -1.0), sink, to_edge);
            } else if foot.distance.is_finite() && -over_end.abs() < sink.reach() {
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
            let (_, foot) = rim.nearest(&query, f64::INFINITY);
            if foot.distance <= -lower.z {
                deep_offsets(rim.beyond(&xy, &foot, 1.0), sink, to_rim);
            } else if foot.distance.is_finite() && lower.z < sink.reach() {
                // Shorter to lift the edge's lower end out of the top face.
                let feature = Feature::CornerTop { peg_vertex: i };
                sink.take(Candidate { value: lower.z, point: lower, normal: Vector3::z(), in_peg: false, feature });
            }
        }
    }
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
        let candidate = candidate(&around.foot_offset(&query.x, foot, query.free));
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
        let offset = around.foot_offset(&query.x, &foot, query.free);
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
fn deep_offsets<S: Sink>(offsets: [Option<Offset>; 3], sink: &mut S, candidate: impl Fn(&Offset) -> Candidate) {
    for offset in offsets.into_iter().flatten() {
        if offset.value < sink.reach() {
            sink.take(candidate(&offset));
        }
    }
}

//! What of two bodies is near each other, found once for all poses nearby.

use std::cell::Cell;
use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::{Matrix3, Vector3};

use super::beside::Beside;

/// How far points may move until all is looked for anew, as a part of how far is looked.
const ROOM: f64 = 0.1;
/// Of what reaches farther than so many times what is asked for, what is near enough is taken out.
const TOO_FAR: f64 = 2.0;
/// More than what rounding adds to distances (m).
const ROUNDING: f64 = 1e-9;

/// A thing of one body, and one of the other.
pub(super) type Pair = (u32, u32);

/// What of a tool and a fixture is near each other at a pose, and at all poses where no point is far from where it is there.
#[derive(Clone, Debug)]
pub struct Nearby {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
    /// How far (m) points may be from there.
    room: f64,
    /// How far (m) was looked.
    farthest: f64,
    pub(super) tool: OnFaces,
    pub(super) fixture: OnFaces,
    /// Edges of the tool, and those of the fixture that they are near.
    pub(super) edges: Vec<Pair>,
}

/// What of a body is near the faces of another.
#[derive(Clone, Debug)]
pub(super) struct OnFaces {
    /// Edges, and faces that they may pierce.
    pub(super) edges: Vec<Pair>,
    /// Corners in their order, and faces.
    pub(super) corners: Vec<Pair>,
}

impl OnFaces {
    /// Among what is `known` to be near, if that was looked for before.
    fn new(body: &Beside<'_>, known: Option<&OnFaces>, (room, farthest): (f64, f64)) -> Self {
        let (own, others) = (body.own(), body.others());
        let mut edges = Vec::new();
        let known_edges = known.map(|known| known.edges.as_slice());
        body.near(known_edges, (&own.edge_tree, &others.face_tree), &Cell::new(room), |edge, face| {
            if others.faces[face as usize].may_be_pierced(body.ends(edge), room) {
                edges.push((edge, face));
            }
        });
        let mut corners = Vec::new();
        let known_corners = known.map(|known| known.corners.as_slice());
        body.near(known_corners, (&own.corner_tree, &others.face_tree), &Cell::new(farthest), |corner, face| {
            let point = body.vertex(own.corners[corner as usize].vertex);
            if others.faces[face as usize].may_be_near(&point, room, farthest) {
                corners.push((corner, face));
            }
        });
        corners.sort_unstable();
        edges.shrink_to_fit();
        corners.shrink_to_fit();
        OnFaces { edges, corners }
    }

    /// The faces that a corner is near.
    pub(super) fn of_corner(&self, corner: u32) -> impl Iterator<Item = u32> {
        let first = self.corners.partition_point(|&(other, _)| other < corner);
        self.corners[first..].iter().take_while(move |&&(other, _)| other == corner).map(|&(_, face)| face)
    }
}

impl Nearby {
    /// What is nearer than `reach` (m) at a pose, among more: what is kept in `recall`, if that will do.
    pub(super) fn at<'r>(recall: &'r mut Option<Box<Nearby>>, tool: &Beside<'_>, reach: f64) -> &'r Nearby {
        let reach = reach.max(0.0);
        let room = ROOM * reach;
        let nearby = match recall.take() {
            Some(before) if before.farthest <= TOO_FAR * reach && before.holds(tool, 0.0, reach) => before,
            before => {
                let known = before.filter(|before| before.holds(tool, room, reach + room));
                Box::new(Nearby::new(tool, known.as_deref(), (room, reach + room)))
            }
        };
        recall.insert(nearby)
    }

    /// All that is nearer than `farthest` (m), or may pierce within `room` (m); among what is `known`, if that was looked for before.
    fn new(tool: &Beside<'_>, known: Option<&Nearby>, (room, farthest): (f64, f64)) -> Self {
        let limits = (room + ROUNDING, farthest + ROUNDING);
        let (own, others) = (tool.own(), tool.others());
        let mut edges = Vec::new();
        let known_edges = known.map(|known| known.edges.as_slice());
        tool.near(known_edges, (&own.edge_tree, &others.edge_tree), &Cell::new(limits.1), |e, f| {
            if tool.lines(&own.edges[e as usize], &others.edges[f as usize]).are_nearer(limits.1) {
                edges.push((e, f));
            }
        });
        edges.shrink_to_fit();
        Nearby {
            rotation: tool.rotation,
            translation: tool.translation,
            room,
            farthest,
            tool: OnFaces::new(tool, known.map(|known| &known.tool), limits),
            fixture: OnFaces::new(&tool.turned_round(), known.map(|known| &known.fixture), limits),
            edges,
        }
    }

    /// Whether it has all that is nearer than `farthest` (m) beside a tool there, or may pierce within `room` (m).
    fn holds(&self, tool: &Beside<'_>, room: f64, farthest: f64) -> bool {
        let turned = tool.rotation - self.rotation;
        let (middle, radius) = tool.own().around;
        // A difference of rotations stretches nothing by more than its norm over √2.
        let moved =
            (turned * middle + tool.translation - self.translation).norm() + turned.norm() * FRAC_1_SQRT_2 * radius;
        moved + room <= self.room && moved + farthest <= self.farthest
    }
}

//! Trees of boxes, to find what of two bodies is near each other.
//!
//! A tree keeps its boxes while its body moves: a box is moved when it is looked at, and becomes a
//! somewhat larger one.

use std::cell::Cell;

use nalgebra::{Matrix3, Vector3};
use wide::f32x4;

/// Into how many parts an axis is divided to find where to halve things.
const BINS: usize = 16;
/// More than what rounding to single precision takes or adds, as a part of the number.
const ROUNDING: f64 = 1.2e-7;
/// More than what rounding adds when a box is moved, as a part of its largest coordinate.
const MOTION_ROUNDING: f32 = 1e-6;

/// A box along the axes, in single precision and rounded outwards: tests of boxes are most of the
/// work. The fourth coordinate is always zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box3 {
    /// The least corner.
    low: f32x4,
    /// The greatest corner, negated: rounded and compared like the least.
    negated_high: f32x4,
}

/// A little less than `p`, in single precision.
#[inline]
fn rounded_down(p: &Vector3<f64>) -> f32x4 {
    let down = |x: f64| (x - ROUNDING * x.abs()) as f32;
    f32x4::new([down(p.x), down(p.y), down(p.z), 0.0])
}

impl Box3 {
    const NONE: Box3 = Box3 { low: f32x4::splat(f32::INFINITY), negated_high: f32x4::splat(f32::INFINITY) };

    /// Around points.
    pub(super) fn around(points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        let at = |p: &Vector3<f64>| Box3 { low: rounded_down(p), negated_high: rounded_down(&-p) };
        points.into_iter().fold(Box3::NONE, |all, point| all.with(&at(&point)))
    }

    fn with(&self, other: &Box3) -> Self {
        Box3 { low: self.low.fast_min(other.low), negated_high: self.negated_high.fast_min(other.negated_high) }
    }

    fn size(&self) -> f32x4 {
        -self.negated_high - self.low
    }

    /// Half of the surface, and a little, so that flat boxes have some.
    fn surface(&self) -> f32 {
        let [x, y, z, _] = (self.size() + f32x4::splat(1e-6)).to_array();
        x * y + y * z + z * x
    }

    #[inline]
    fn middle(&self) -> f32x4 {
        (self.low - self.negated_high) * f32x4::HALF
    }

    /// The square of the distance between boxes.
    #[inline]
    fn square_to(&self, other: &Box3) -> f32 {
        let apart = (self.low + other.negated_high).fast_max(other.low + self.negated_high).fast_max(f32x4::ZERO);
        (apart * apart).reduce_add()
    }
}

/// Where a body is, for its boxes.
struct Motion {
    columns: [f32x4; 3],
    /// The same without signs.
    sizes: [f32x4; 3],
    translation: f32x4,
    /// More than rounding adds or takes.
    slack: f32x4,
}

impl Motion {
    /// Of boxes all of which are in `around`.
    fn new(rotation: &Matrix3<f64>, translation: &Vector3<f64>, around: &Box3) -> Self {
        let single = |v: &[f64]| f32x4::new([v[0] as f32, v[1] as f32, v[2] as f32, 0.0]);
        let translation = single(translation.as_slice());
        let [x, y, z, _] = (around.low.abs().fast_max(around.negated_high.abs()) + translation.abs()).to_array();
        let slack = f32x4::new([MOTION_ROUNDING * (x + y + z); 4]);
        let columns: [f32x4; 3] = std::array::from_fn(|k| single(rotation.column(k).as_slice()));
        Motion { columns, sizes: columns.map(f32x4::abs), translation, slack }
    }

    /// A box around a moved one.
    #[inline]
    fn of(&self, still: &Box3) -> Box3 {
        let (middle, half) = (still.middle().to_array(), (still.size() * f32x4::HALF).to_array());
        let (mut at, mut reach) = (self.translation, self.slack);
        for k in 0..3 {
            at += self.columns[k] * f32x4::splat(middle[k]);
            reach += self.sizes[k] * f32x4::splat(half[k]);
        }
        Box3 { low: at - reach, negated_high: -at - reach }
    }
}

/// How things are halved again and again. The root is the first node; children come after their
/// parents.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    /// Of each node.
    boxes: Vec<Box3>,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Thing(u32),
    Halves(u32, u32),
}

impl Tree {
    /// Of things in boxes.
    pub(super) fn new(things: &[Box3]) -> Self {
        let mut order: Vec<u32> = (0..things.len() as u32).collect();
        let mut tree = Tree { nodes: Vec::with_capacity(2 * things.len()), boxes: Vec::new() };
        if !order.is_empty() {
            tree.halve(&mut order, things);
        }
        tree.boxes = vec![Box3::NONE; tree.nodes.len()];
        for (k, node) in tree.nodes.iter().enumerate().rev() {
            tree.boxes[k] = match *node {
                Node::Thing(thing) => things[thing as usize],
                Node::Halves(left, right) => tree.boxes[left as usize].with(&tree.boxes[right as usize]),
            };
        }
        tree
    }

    /// Adds a node for things, and those below it.
    fn halve(&mut self, things: &mut [u32], boxes: &[Box3]) -> u32 {
        let node = self.nodes.len() as u32;
        self.nodes.push(Node::Thing(things[0]));
        if things.len() > 1 {
            let half = cheapest_halves(things, boxes);
            let (left, right) = things.split_at_mut(half);
            let (left, right) = (self.halve(left, boxes), self.halve(right, boxes));
            self.nodes[node as usize] = Node::Halves(left, right);
        }
        node
    }
}

/// Orders things so that those before the place returned and those after it have small boxes: of
/// [`BINS`] − 1 cuts across each axis, the one with the least sum of numbers times surfaces. In the
/// middle if all are at one place.
fn cheapest_halves(things: &mut [u32], boxes: &[Box3]) -> usize {
    let middle = |thing: u32| boxes[thing as usize].middle();
    let around = things
        .iter()
        .fold(Box3::NONE, |all, &thing| all.with(&Box3 { low: middle(thing), negated_high: -middle(thing) }));
    let (low, size) = (around.low.to_array(), around.size().to_array());
    let bin = |thing: u32, axis: usize| {
        let share = (middle(thing).to_array()[axis] - low[axis]) / size[axis];
        ((share * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0) {
        let mut bins = [(0, Box3::NONE); BINS];
        for &thing in things.iter() {
            let (count, around) = &mut bins[bin(thing, axis)];
            *count += 1;
            *around = around.with(&boxes[thing as usize]);
        }
        // Numbers times surfaces of the bins from the left up to each, then from the right.
        let grow = |side: &mut (usize, Box3), bin: &(usize, Box3)| {
            *side = (side.0 + bin.0, side.1.with(&bin.1));
            Some(if side.0 == 0 { 0.0 } else { side.0 as f32 * side.1.surface() })
        };
        let left: Vec<f32> = bins.iter().scan((0, Box3::NONE), grow).collect();
        let right: Vec<f32> = bins.iter().rev().scan((0, Box3::NONE), grow).collect();
        for cut in 1..BINS {
            let cost = left[cut - 1] + right[BINS - 1 - cut];
            let is_split = left[cut - 1] > 0.0 && right[BINS - 1 - cut] > 0.0;
            if is_split && best.is_none_or(|(least, _, _)| cost < least) {
                best = Some((cost, axis, cut));
            }
        }
    }
    let Some((_, axis, cut)) = best else { return things.len() / 2 };
    things.sort_by_key(|&thing| bin(thing, axis) >= cut);
    things.partition_point(|&thing| bin(thing, axis) < cut).clamp(1, things.len() - 1)
}

/// Calls `visit` for all things of two trees whose boxes come nearer than `reach`, which may be
/// lowered on the way; of the halves of two nodes, nearer ones first. The first tree's body is
/// turned and moved into the frame of the second.
pub(super) fn near_pairs(
    a: &Tree,
    (rotation, translation): (&Matrix3<f64>, &Vector3<f64>),
    b: &Tree,
    reach: &Cell<f64>,
    mut visit: impl FnMut(u32, u32),
) {
    let (Some(around_a), Some(around_b)) = (a.boxes.first(), b.boxes.first()) else { return };
    let motion = Motion::new(rotation, translation, around_a);
    let moved = |i: u32| motion.of(&a.boxes[i as usize]);
    let squared = |reach: f64| if reach < 0.0 { -1.0 } else { (reach * reach * (1.0 + 8.0 * ROUNDING)) as f32 };
    let mut farthest = squared(reach.get());
    let mut stack: Vec<(f32, u32, u32)> = Vec::with_capacity(64);
    let mut next = Some((motion.of(around_a).square_to(around_b), 0, 0));
    while let Some((square, i, j)) = next.or_else(|| stack.pop()) {
        next = None;
        if square > farthest {
            continue;
        }
        let mut go = |(i, around): (u32, Box3), j: u32| {
            let mut other = (around.square_to(&b.boxes[j as usize]), i, j);
            if other.0 > farthest {
                return;
            }
            match &mut next {
                Some(nearest) => {
                    if other.0 < nearest.0 {
                        std::mem::swap(nearest, &mut other);
                    }
                    stack.push(other);
                }
                None => next = Some(other),
            }
        };
        match (a.nodes[i as usize], b.nodes[j as usize]) {
            (Node::Thing(of_a), Node::Thing(of_b)) => {
                visit(of_a, of_b);
                farthest = squared(reach.get());
            }
            (Node::Halves(left, right), Node::Thing(_)) => {
                go((left, moved(left)), j);
                go((right, moved(right)), j);
            }
            (Node::Thing(_), Node::Halves(left, right)) => {
                let whole = (i, moved(i));
                go(whole, left);
                go(whole, right);
            }
            (Node::Halves(a_left, a_right), Node::Halves(b_left, b_right)) => {
                let (left, right) = ((a_left, moved(a_left)), (a_right, moved(a_right)));
                go(left, b_left);
                go(left, b_right);
                go(right, b_left);
                go(right, b_right);
            }
        }
    }
}

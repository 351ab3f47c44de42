//! Trees of boxes, to find what of two bodies is near each other.
//!
//! A tree keeps its shape while its boxes follow the things in them, so that things that move need no new tree.

use std::cell::Cell;

use nalgebra::Vector3;

/// Into how many parts an axis is divided to find where to halve things.
const BINS: usize = 16;

/// A box along the axes: its least and greatest corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Box3 {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Box3 {
    /// Around points.
    #[inline]
    pub(super) fn around<const N: usize>(points: [Vector3<f64>; N]) -> Self {
        let none = Box3 { low: Vector3::repeat(f64::INFINITY), high: Vector3::repeat(f64::NEG_INFINITY) };
        points.iter().fold(none, |all, point| all.with(&Box3 { low: *point, high: *point }))
    }

    #[inline]
    fn with(&self, other: &Box3) -> Self {
        // Written out: `f64::min` also looks for NaN.
        let least = |a: f64, b: f64| if a < b { a } else { b };
        let most = |a: f64, b: f64| if a > b { a } else { b };
        Box3 { low: self.low.zip_map(&other.low, least), high: self.high.zip_map(&other.high, most) }
    }

    /// Half of the surface, and a little, so that flat boxes have some.
    fn surface(&self) -> f64 {
        let size = (self.high - self.low).add_scalar(1e-6);
        size.x * size.y + size.y * size.z + size.z * size.x
    }

    #[inline]
    fn is_near(&self, other: &Box3, reach: f64) -> bool {
        // All at once: branches cost more than comparisons.
        let apart = |k: usize| (self.low[k] - reach > other.high[k]) | (other.low[k] - reach > self.high[k]);
        !(apart(0) | apart(1) | apart(2))
    }
}

/// How things are halved again and again. The root is the first node; children come after their parents.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Thing(u32),
    Halves(u32, u32),
}

impl Tree {
    /// Of things in boxes.
    pub(super) fn new(boxes: &[Box3]) -> Self {
        let mut things: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut tree = Tree { nodes: Vec::with_capacity(2 * boxes.len()) };
        if !things.is_empty() {
            tree.halve(&mut things, boxes);
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

    /// The box of each node, given those of the things.
    pub(super) fn boxes(&self, of: impl Fn(u32) -> Box3) -> Vec<Box3> {
        let mut boxes = vec![Box3::around([]); self.nodes.len()];
        for (k, node) in self.nodes.iter().enumerate().rev() {
            boxes[k] = match *node {
                Node::Thing(thing) => of(thing),
                Node::Halves(left, right) => boxes[left as usize].with(&boxes[right as usize]),
            };
        }
        boxes
    }
}

/// Orders things so that those before the place returned and those after it have small boxes: of [`BINS`] − 1 cuts across each axis, the one with the least sum of
/// numbers times surfaces. In the middle if all are at one place.
fn cheapest_halves(things: &mut [u32], boxes: &[Box3]) -> usize {
    let middle = |thing: u32| (boxes[thing as usize].low + boxes[thing as usize].high) * 0.5;
    let all = things.iter().fold(Box3::around([]), |all, &thing| all.with(&Box3::around([middle(thing)])));
    let size = all.high - all.low;
    let bin = |thing: u32, axis: usize| {
        let share = (middle(thing)[axis] - all.low[axis]) / size[axis];
        ((share * BINS as f64) as usize).min(BINS - 1)
    };
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0) {
        let mut bins = [(0, Box3::around([])); BINS];
        for &thing in things.iter() {
            let (count, around) = &mut bins[bin(thing, axis)];
            *count += 1;
            *around = around.with(&boxes[thing as usize]);
        }
        // Numbers times surfaces of the bins from the left up to each, then from the right.
        let grow = |side: &mut (usize, Box3), bin: &(usize, Box3)| {
            *side = (side.0 + bin.0, side.1.with(&bin.1));
            Some(if side.0 == 0 { 0.0 } else { side.0 as f64 * side.1.surface() })
        };
        let left: Vec<f64> = bins.iter().scan((0, Box3::around([])), grow).collect();
        let right: Vec<f64> = bins.iter().rev().scan((0, Box3::around([])), grow).collect();
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

/// Calls `visit` for all things of two trees whose boxes come nearer than `reach`, which may be lowered on the way.
pub(super) fn near_pairs(
    (a, a_boxes): (&Tree, &[Box3]),
    (b, b_boxes): (&Tree, &[Box3]),
    reach: &Cell<f64>,
    mut visit: impl FnMut(u32, u32),
) {
    let mut stack: Vec<(u32, u32)> = Vec::with_capacity(64);
    let is_near = |i: u32, j: u32| a_boxes[i as usize].is_near(&b_boxes[j as usize], reach.get());
    let mut next = (!a.nodes.is_empty() && !b.nodes.is_empty() && is_near(0, 0)).then_some((0, 0));
    while let Some((i, j)) = next.or_else(|| stack.pop()) {
        next = None;
        let mut go = |i: u32, j: u32| {
            if is_near(i, j)
                && let Some(before) = next.replace((i, j))
            {
                stack.push(before);
            }
        };
        match (a.nodes[i as usize], b.nodes[j as usize]) {
            (Node::Thing(of_a), Node::Thing(of_b)) => visit(of_a, of_b),
            (Node::Halves(left, right), Node::Thing(_)) => [left, right].into_iter().for_each(|half| go(half, j)),
            (Node::Thing(_), Node::Halves(left, right)) => [left, right].into_iter().for_each(|half| go(i, half)),
            (Node::Halves(a_left, a_right), Node::Halves(b_left, b_right)) => {
                for (i, j) in [(a_left, b_left), (a_left, b_right), (a_right, b_left), (a_right, b_right)] {
                    go(i, j);
                }
            }
        }
    }
}

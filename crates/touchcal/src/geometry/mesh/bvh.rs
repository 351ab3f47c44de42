//! Bounding volume hierarchies of axis-aligned boxes, to find the features of two bodies that are
//! near each other.
//!
//! A tree keeps its boxes while its body moves: a search moves each box that it visits, and bounds
//! the moved box by an axis-aligned one.
//!
//! parry3d 0.31 has a tree too. In its place calibrations with chamfered meshes take 1.3 to 1.5
//! times as long (`benches/meshes.rs`, in one run: T-slot 1.29 and 1.70 s, rounded 3.7 and 5.3 s,
//! cylinder 5.1 and 6.6 s): its nodes are in double precision, and visited in no order of distance.

use std::cell::Cell;

use nalgebra::{Matrix3, Vector3};
use wide::f32x4;

/// Bins of each axis among whose borders the surface area heuristic chooses.
const BINS: usize = 16;
/// More than what rounding to single precision takes or adds, as a part of the number.
const ROUNDING: f64 = 1.2e-7;
/// More than what rounding adds when a box is moved, as a part of its largest coordinate.
const MOTION_ROUNDING: f32 = 1e-6;

/// An axis-aligned bounding box, in single precision and rounded outwards: tests of boxes are most
/// of the work. The fourth coordinate is always zero.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
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

impl Aabb {
    const NONE: Aabb = Aabb { low: f32x4::splat(f32::INFINITY), negated_high: f32x4::splat(f32::INFINITY) };

    /// Around points.
    pub(crate) fn around(points: impl IntoIterator<Item = Vector3<f64>>) -> Self {
        let at = |p: &Vector3<f64>| Aabb { low: rounded_down(p), negated_high: rounded_down(&-p) };
        points.into_iter().fold(Aabb::NONE, |all, point| all.with(&at(&point)))
    }

    fn with(&self, other: &Aabb) -> Self {
        Aabb { low: self.low.fast_min(other.low), negated_high: self.negated_high.fast_min(other.negated_high) }
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
    fn square_to(&self, other: &Aabb) -> f32 {
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
    fn new(rotation: &Matrix3<f64>, translation: &Vector3<f64>, around: &Aabb) -> Self {
        let single = |v: &[f64]| f32x4::new([v[0] as f32, v[1] as f32, v[2] as f32, 0.0]);
        let translation = single(translation.as_slice());
        let [x, y, z, _] = (around.low.abs().fast_max(around.negated_high.abs()) + translation.abs()).to_array();
        let slack = f32x4::new([MOTION_ROUNDING * (x + y + z); 4]);
        let columns: [f32x4; 3] = std::array::from_fn(|k| single(rotation.column(k).as_slice()));
        Motion { columns, sizes: columns.map(f32x4::abs), translation, slack }
    }

    /// A box around a moved one.
    #[inline]
    fn of(&self, still: &Aabb) -> Aabb {
        let (middle, half) = (still.middle().to_array(), (still.size() * f32x4::HALF).to_array());
        let (mut at, mut reach) = (self.translation, self.slack);
        for k in 0..3 {
            at += self.columns[k] * f32x4::splat(middle[k]);
            reach += self.sizes[k] * f32x4::splat(half[k]);
        }
        Aabb { low: at - reach, negated_high: -at - reach }
    }
}

/// A leaf of one tree and one of another: indices of the boxes that the trees were built from.
pub(crate) type LeafPair = (u32, u32);

/// A binary bounding volume hierarchy over boxes. The root is the first node; children come after
/// their parents.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    /// Of each node.
    boxes: Vec<Aabb>,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Leaf(u32),
    Branch(u32, u32),
}

impl Bvh {
    /// The tree over these boxes (m, in the body's frame).
    pub(crate) fn new(leaves: &[Aabb]) -> Self {
        let mut order: Vec<u32> = (0..leaves.len() as u32).collect();
        let mut tree = Bvh { nodes: Vec::with_capacity(2 * leaves.len()), boxes: Vec::new() };
        if !order.is_empty() {
            tree.split(&mut order, leaves);
        }
        tree.boxes = vec![Aabb::NONE; tree.nodes.len()];
        for (k, node) in tree.nodes.iter().enumerate().rev() {
            tree.boxes[k] = match *node {
                Node::Leaf(leaf) => leaves[leaf as usize],
                Node::Branch(left, right) => tree.boxes[left as usize].with(&tree.boxes[right as usize]),
            };
        }
        tree
    }

    /// Adds a node for leaves, and those below it.
    fn split(&mut self, leaves: &mut [u32], boxes: &[Aabb]) -> u32 {
        let node = self.nodes.len() as u32;
        self.nodes.push(Node::Leaf(leaves[0]));
        if leaves.len() > 1 {
            let half = split_by_sah(leaves, boxes);
            let (left, right) = leaves.split_at_mut(half);
            let (left, right) = (self.split(left, boxes), self.split(right, boxes));
            self.nodes[node as usize] = Node::Branch(left, right);
        }
        node
    }
}

/// Orders leaves for a split at the index returned, by the binned surface area heuristic (Wald, *On
/// fast construction of SAH-based bounding volume hierarchies*, 2007): of [`BINS`] − 1 cuts across
/// each axis, the one with the least sum of counts times surface areas. In the middle if all boxes
/// have one centre.
fn split_by_sah(leaves: &mut [u32], boxes: &[Aabb]) -> usize {
    let middle = |leaf: u32| boxes[leaf as usize].middle();
    let around =
        leaves.iter().fold(Aabb::NONE, |all, &leaf| all.with(&Aabb { low: middle(leaf), negated_high: -middle(leaf) }));
    let (low, size) = (around.low.to_array(), around.size().to_array());
    let bin = |leaf: u32, axis: usize| {
        let share = (middle(leaf).to_array()[axis] - low[axis]) / size[axis];
        ((share * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|&axis| size[axis] > 0.0) {
        let mut bins = [(0, Aabb::NONE); BINS];
        for &leaf in leaves.iter() {
            let (count, around) = &mut bins[bin(leaf, axis)];
            *count += 1;
            *around = around.with(&boxes[leaf as usize]);
        }
        // Numbers times surfaces of the bins from the left up to each, then from the right.
        let grow = |side: &mut (usize, Aabb), bin: &(usize, Aabb)| {
            *side = (side.0 + bin.0, side.1.with(&bin.1));
            Some(if side.0 == 0 { 0.0 } else { side.0 as f32 * side.1.surface() })
        };
        let left: Vec<f32> = bins.iter().scan((0, Aabb::NONE), grow).collect();
        let right: Vec<f32> = bins.iter().rev().scan((0, Aabb::NONE), grow).collect();
        for cut in 1..BINS {
            let cost = left[cut - 1] + right[BINS - 1 - cut];
            let is_split = left[cut - 1] > 0.0 && right[BINS - 1 - cut] > 0.0;
            if is_split && best.is_none_or(|(least, _, _)| cost < least) {
                best = Some((cost, axis, cut));
            }
        }
    }
    let Some((_, axis, cut)) = best else { return leaves.len() / 2 };
    leaves.sort_by_key(|&leaf| bin(leaf, axis) >= cut);
    leaves.partition_point(|&leaf| bin(leaf, axis) < cut).clamp(1, leaves.len() - 1)
}

/// Calls `visit` for all pairs of leaves of two trees whose boxes are nearer than `reach` (m),
/// which `visit` may lower; nearer branches first. The first tree's body is rotated and translated
/// (m) into the frame of the second.
pub(crate) fn leaf_pairs(
    a: &Bvh,
    (rotation, translation): (&Matrix3<f64>, &Vector3<f64>),
    b: &Bvh,
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
        let mut go = |(i, around): (u32, Aabb), j: u32| {
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
            (Node::Leaf(of_a), Node::Leaf(of_b)) => {
                visit(of_a, of_b);
                farthest = squared(reach.get());
            }
            (Node::Branch(left, right), Node::Leaf(_)) => {
                go((left, moved(left)), j);
                go((right, moved(right)), j);
            }
            (Node::Leaf(_), Node::Branch(left, right)) => {
                let whole = (i, moved(i));
                go(whole, left);
                go(whole, right);
            }
            (Node::Branch(a_left, a_right), Node::Branch(b_left, b_right)) => {
                let (left, right) = ((a_left, moved(a_left)), (a_right, moved(a_right)));
                go(left, b_left);
                go(left, b_right);
                go(right, b_left);
                go(right, b_right);
            }
        }
    }
}

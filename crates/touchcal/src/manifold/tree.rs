//! Exact search among points of a torus: places on lines, angles on circles.

/// Points in a leaf: few enough to measure them all, enough to measure them together.
const WIDTH: usize = 8;
/// Dimensions from here on are circles.
const FIRST_ANGLE: usize = 3;

/// A point: three places, three turns, all in metres, as [`Metric::point`](super::coordinates::Metric::point) says.
pub(super) type Point = [f64; 6];

/// A balanced tree of boxes around points.
///
/// A box is as small as its points allow, so that a search from far away, where all points are nearly equally near, still passes over
/// most of them. Rounding cannot hide the nearest: a box's distance is computed by the same steps as a point's, each of which is monotone.
#[derive(Debug)]
pub(super) struct Tree {
    /// Length (m) of a full turn.
    circumference: f64,
    /// In preorder: a node's first child follows it.
    nodes: Vec<Node>,
    leaves: Vec<Leaf>,
}

#[derive(Debug)]
struct Node {
    least: Point,
    greatest: Point,
    below: Below,
}

#[derive(Clone, Copy, Debug)]
enum Below {
    /// Index of the second child.
    Second(usize),
    /// Index of the leaf.
    Leaf(usize),
}

/// Points by dimension, the last leaf filled up with points infinitely far away.
#[derive(Debug)]
struct Leaf {
    points: [[f64; WIDTH]; 6],
    index: [usize; WIDTH],
}

/// What a search collects.
pub(super) trait Collect {
    /// Squared distance (m²) beyond which nothing matters any more; finite.
    fn reach(&self) -> f64;

    /// A point and its squared distance (m²), at most [`Collect::reach`].
    fn take(&mut self, squared: f64, index: usize);
}

impl Tree {
    /// A tree of points whose turns lie within half a `circumference` (m) of zero.
    pub(super) fn new(points: &[Point], circumference: f64) -> Self {
        let mut index: Vec<usize> = (0..points.len()).collect();
        let leaves = points.len().div_ceil(WIDTH);
        let mut tree =
            Tree { circumference, nodes: Vec::with_capacity(2 * leaves), leaves: Vec::with_capacity(leaves) };
        if !index.is_empty() {
            tree.grow(points, &mut index);
        }
        tree
    }

    fn grow(&mut self, points: &[Point], index: &mut [usize]) {
        let (mut least, mut greatest) = ([f64::INFINITY; 6], [f64::NEG_INFINITY; 6]);
        for &i in index.iter() {
            for k in 0..6 {
                least[k] = least[k].min(points[i][k]);
                greatest[k] = greatest[k].max(points[i][k]);
            }
        }
        let node = self.nodes.len();
        self.nodes.push(Node { least, greatest, below: Below::Leaf(self.leaves.len()) });
        if index.len() <= WIDTH {
            self.leaves.push(Leaf::new(points, index));
            return;
        }
        let extent = |k: &usize| greatest[*k] - least[*k];
        let widest = (0..6).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        // Full leaves on the left.
        let half = index.len().div_ceil(WIDTH).div_ceil(2) * WIDTH;
        index.select_nth_unstable_by(half, |&a, &b| points[a][widest].total_cmp(&points[b][widest]).then(a.cmp(&b)));
        let (first, second) = index.split_at_mut(half);
        self.grow(points, first);
        self.nodes[node].below = Below::Second(self.nodes.len());
        self.grow(points, second);
    }

    /// Shows `found` every point that matters to it.
    pub(super) fn search(&self, query: &Point, found: &mut impl Collect) {
        if !self.nodes.is_empty() {
            self.descend(0, query, found);
        }
    }

    fn descend(&self, node: usize, query: &Point, found: &mut impl Collect) {
        match self.nodes[node].below {
            Below::Leaf(leaf) => {
                let Leaf { points, index } = &self.leaves[leaf];
                for (squared, &index) in self.to_points(points, query).into_iter().zip(index) {
                    if squared <= found.reach() {
                        found.take(squared, index);
                    }
                }
            }
            Below::Second(second) => {
                let first = node + 1;
                let (to_first, to_second) = (self.to_box(first, query), self.to_box(second, query));
                let turns = if to_first <= to_second {
                    [(to_first, first), (to_second, second)]
                } else {
                    [(to_second, second), (to_first, first)]
                };
                for (squared, child) in turns {
                    if squared <= found.reach() {
                        self.descend(child, query, found);
                    }
                }
            }
        }
    }

    /// Squared distances of a leaf's points.
    fn to_points(&self, points: &[[f64; WIDTH]; 6], query: &Point) -> [f64; WIDTH] {
        let mut squared = [0.0; WIDTH];
        for (k, (points, query)) in points.iter().zip(query).enumerate() {
            for (squared, point) in squared.iter_mut().zip(points) {
                let ahead = (point - query).abs();
                let apart = if k < FIRST_ANGLE { ahead } else { ahead.min(self.circumference - ahead) };
                *squared += apart * apart;
            }
        }
        squared
    }

    /// Squared distance of a box, zero within.
    fn to_box(&self, node: usize, query: &Point) -> f64 {
        let Node { least, greatest, .. } = &self.nodes[node];
        let mut squared = 0.0;
        for k in 0..6 {
            let outside = (least[k] - query[k]).max(query[k] - greatest[k]).max(0.0);
            let apart = if k < FIRST_ANGLE {
                outside
            } else {
                // The other way round, to the far side of the box.
                let farthest = (greatest[k] - query[k]).max(query[k] - least[k]);
                outside.min((self.circumference - farthest).max(0.0))
            };
            squared += apart * apart;
        }
        squared
    }
}

impl Leaf {
    fn new(points: &[Point], of: &[usize]) -> Self {
        let mut leaf = Leaf { points: [[f64::INFINITY; WIDTH]; 6], index: [usize::MAX; WIDTH] };
        for (slot, &i) in of.iter().enumerate() {
            leaf.index[slot] = i;
            for (row, value) in leaf.points.iter_mut().zip(points[i]) {
                row[slot] = value;
            }
        }
        leaf
    }
}

/// The nearest point, of equally near ones the first.
pub(super) struct Nearest {
    best: (f64, usize),
}

impl Nearest {
    pub(super) fn new() -> Self {
        Nearest { best: (f64::MAX, usize::MAX) }
    }

    /// Squared distance (m²) and index, if any point is at a finite distance.
    pub(super) fn found(&self) -> Option<(f64, usize)> {
        (self.best.1 != usize::MAX).then_some(self.best)
    }
}

impl Collect for Nearest {
    fn reach(&self) -> f64 {
        self.best.0
    }

    fn take(&mut self, squared: f64, index: usize) {
        if (squared, index) < self.best {
            self.best = (squared, index);
        }
    }
}

/// The nearest point outside a range of indices.
pub(super) struct NearestOutside {
    pub(super) nearest: Nearest,
    pub(super) excluded: std::ops::Range<usize>,
}

impl Collect for NearestOutside {
    fn reach(&self) -> f64 {
        self.nearest.reach()
    }

    fn take(&mut self, squared: f64, index: usize) {
        if !self.excluded.contains(&index) {
            self.nearest.take(squared, index);
        }
    }
}

/// The nearest few points by distance, of equally near ones the first.
pub(super) struct NearestFew {
    most: usize,
    /// Squared distances (m²) and indices, ascending.
    pub(super) best: Vec<(f64, usize)>,
}

impl NearestFew {
    pub(super) fn new(most: usize) -> Self {
        NearestFew { most, best: Vec::with_capacity(most + 1) }
    }
}

impl Collect for NearestFew {
    fn reach(&self) -> f64 {
        if self.best.len() < self.most { f64::MAX } else { self.best.last().map_or(f64::MAX, |worst| worst.0) }
    }

    fn take(&mut self, squared: f64, index: usize) {
        let at = self.best.partition_point(|&better| better < (squared, index));
        self.best.insert(at, (squared, index));
        self.best.truncate(self.most);
    }
}

/// All points nearer than a distance.
pub(super) struct Within {
    /// Squared distance (m²).
    pub(super) squared: f64,
    pub(super) found: Vec<usize>,
}

impl Collect for Within {
    fn reach(&self) -> f64 {
        self.squared
    }

    fn take(&mut self, squared: f64, index: usize) {
        if squared < self.squared {
            self.found.push(index);
        }
    }
}

//! Exact search among points of a torus, places on lines and angles on circles: an R*-tree of
//! `rstar`, asked again for the query's images beyond the seams where something nearer may lie
//! there.

use rstar::primitives::GeomWithData;
use rstar::{PointDistance, RTree};

/// A point: three places, three turns, all in metres, as
/// [`Metric::point`](super::coordinates::Metric::point) says.
pub(super) type Point = [f64; 6];

/// Dimensions from here on are circles.
const FIRST_ANGLE: usize = 3;

/// Squared distance (m²) and index of a point found; what is less is nearer, or first where equally
/// near.
pub(super) type Found = (f64, usize);

/// Points to search among.
#[derive(Debug)]
pub(super) struct Tree {
    points: RTree<GeomWithData<Point, usize>>,
    /// Length (m) of a full turn.
    circumference: f64,
    /// Greatest size (m) of any point's turns.
    reach: [f64; 3],
}

impl Tree {
    /// A tree of points, each with its index, whose turns lie within half a `circumference` (m) of
    /// zero.
    pub(super) fn new(points: impl IntoIterator<Item = (usize, Point)>, circumference: f64) -> Self {
        let points: Vec<_> = points.into_iter().map(|(index, point)| GeomWithData::new(point, index)).collect();
        let reach =
            std::array::from_fn(|k| points.iter().map(|point| point.geom()[FIRST_ANGLE + k].abs()).fold(0.0, f64::max));
        Tree { points: RTree::bulk_load(points), circumference, reach }
    }

    /// The nearest point, of equally near ones the first; none if the query is not finite.
    pub(super) fn nearest(&self, query: &Point) -> Option<Found> {
        let nearest = |query: &Point| {
            let equal = self.points.nearest_neighbors(query);
            equal.iter().map(|point| found(point, query)).min_by(order)
        };
        let at_once = query.iter().all(|value| value.is_finite()).then(|| nearest(query)).flatten()?;
        let beyond = self.images(query, at_once.0.sqrt()).filter_map(|image| nearest(&image));
        beyond.chain([at_once]).min_by(order)
    }

    /// The nearest `k` points, the nearest first; none if the query is not finite.
    pub(super) fn nearest_few(&self, query: &Point, k: usize) -> Vec<Found> {
        if k == 0 || query.iter().any(|value| !value.is_finite()) {
            return Vec::new();
        }
        let mut few = self.few(query, k);
        let within = if few.len() < k { f64::INFINITY } else { few[k - 1].0.sqrt() };
        for image in self.images(query, within) {
            few.extend(self.few(&image, k));
        }
        few.sort_by(order);
        // A point met in two images counts where it is nearer.
        let mut seen = std::collections::HashSet::new();
        few.retain(|(_, index)| seen.insert(*index));
        few.truncate(k);
        few
    }

    /// The nearest `k` points without looking beyond the seams, and all that are as near as the
    /// last.
    fn few(&self, query: &Point, k: usize) -> Vec<Found> {
        let mut few: Vec<Found> = Vec::with_capacity(k + 1);
        for point in self.points.nearest_neighbor_iter(*query) {
            let next = found(point, query);
            if few.len() >= k && few.last().is_some_and(|last| next.0 > last.0) {
                break;
            }
            few.push(next);
        }
        few
    }

    /// Indices of all points nearer than `distance` (m).
    pub(super) fn within(&self, query: &Point, distance: f64) -> Vec<usize> {
        let squared = distance * distance;
        let queries = std::iter::once(*query).chain(self.images(query, distance));
        let near = queries.flat_map(|query| {
            let points = self.points.locate_within_distance(query, squared);
            points.map(move |point| found(point, &query)).filter(|found| found.0 < squared).collect::<Vec<_>>()
        });
        near.map(|(_, index)| index).collect()
    }

    /// The query seen from beyond the seams, as far as points nearer than `distance` (m) may lie
    /// there.
    fn images(&self, query: &Point, distance: f64) -> impl Iterator<Item = Point> {
        let turns: [f64; 3] = std::array::from_fn(|k| query[FIRST_ANGLE + k]);
        let reachable: [bool; 3] =
            std::array::from_fn(|k| self.circumference - turns[k].abs() - self.reach[k] <= distance);
        let (query, circumference) = (*query, self.circumference);
        let sides = (1..8u8).map(|sides| std::array::from_fn::<bool, 3, _>(|k| sides & (1 << k) != 0));
        sides.filter(move |beyond| (0..3).all(|k| !beyond[k] || reachable[k])).map(move |beyond| {
            std::array::from_fn(|d| match d.checked_sub(FIRST_ANGLE) {
                Some(k) if beyond[k] => query[d] - circumference.copysign(query[d]),
                _ => query[d],
            })
        })
    }
}

fn found(point: &GeomWithData<Point, usize>, query: &Point) -> Found {
    (point.distance_2(query), point.data)
}

fn order(a: &Found, b: &Found) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

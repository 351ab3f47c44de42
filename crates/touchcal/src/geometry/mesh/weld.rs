//! Points that are nearly the same as one.

use std::collections::HashMap;

use nalgebra::Point3;

/// Distance (m) below which two points of a surface are merged into one by
/// [`TriangleMesh::new`](super::TriangleMesh::new): 10 nm.
pub const WELD_DISTANCE: f64 = 1e-8;

/// The distinct points among `points` (m), and for each point the index of its distinct one.
pub(super) fn weld(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<u32>) {
    let cell = |p: &Point3<f64>| [p.x, p.y, p.z].map(|c| (c / WELD_DISTANCE).round() as i64);
    let mut exact: HashMap<[u64; 3], u32> = HashMap::new();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut distinct: Vec<Point3<f64>> = Vec::new();
    let place = points.iter().map(|p| {
        // Adding zero makes −0 the same as 0.
        let bits = [p.x, p.y, p.z].map(|c| (c + 0.0).to_bits());
        *exact.entry(bits).or_insert_with(|| {
            let [x, y, z] = cell(p);
            let around = (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [i, j, k])));
            let near = around
                .filter_map(|[i, j, k]| cells.get(&[x.saturating_add(i), y.saturating_add(j), z.saturating_add(k)]))
                .flatten()
                .find(|&&other| (distinct[other as usize] - p).norm() < WELD_DISTANCE);
            if let Some(&same) = near {
                return same;
            }
            let index = distinct.len() as u32;
            distinct.push(*p);
            cells.entry([x, y, z]).or_default().push(index);
            index
        })
    });
    let place = place.collect();
    (distinct, place)
}

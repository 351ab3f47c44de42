//! A surface of triangles as flat convex polygons, of which there are fewer.

use std::collections::HashMap;
use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::Vector3;

use super::weld::WELD_DISTANCE;

/// Cosine of the angle by which sides bend at the least where parts are joined. With less, a point
/// beyond a side in a hollow corner would be beyond the line of the next side too, and be left to a
/// face that is farther from it.
const BENT: f64 = FRAC_1_SQRT_2;
/// Most sides of a polygon.
const MOST_SIDES: usize = 16;

/// A flat convex part of a surface.
pub(super) struct CoplanarFace {
    /// Its vertices, counter-clockwise seen from outside.
    pub(super) vertices: Vec<u32>,
    /// Unit normal.
    pub(super) normal: Vector3<f64>,
    /// `normal · p` of its points.
    pub(super) offset: f64,
}

impl CoplanarFace {
    /// In the plane that is in the middle of the vertices.
    fn new(vertices: Vec<u32>, at: &impl Fn(u32) -> Vector3<f64>) -> Self {
        let from_first = vertices.iter().map(|&vertex| at(vertex) - at(vertices[0]));
        let area: Vector3<f64> = from_first.clone().zip(from_first.clone().skip(1)).map(|(a, b)| a.cross(&b)).sum();
        let normal = area.normalize();
        let middle = from_first.map(|p| normal.dot(&p)).sum::<f64>() / vertices.len() as f64;
        CoplanarFace { offset: normal.dot(&at(vertices[0])) + middle, vertices, normal }
    }

    /// Whether the vertices are in the plane, within the tolerance at which points are distinct.
    fn is_flat(&self, at: &impl Fn(u32) -> Vector3<f64>) -> bool {
        self.vertices.iter().all(|&vertex| (self.normal.dot(&at(vertex)) - self.offset).abs() <= WELD_DISTANCE)
    }

    /// Its sides, from vertex to vertex.
    pub(super) fn sides(&self) -> impl Iterator<Item = (u32, u32)> + Clone {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next).map(|(&from, &to)| (from, to))
    }

    /// Whether the sides bend enough at a vertex.
    fn is_bent(&self, vertex: u32, at: &impl Fn(u32) -> Vector3<f64>) -> bool {
        let mut sides = self.sides();
        let before = sides.clone().find(|&(_, to)| to == vertex);
        let after = sides.find(|&(from, _)| from == vertex);
        let along = |side: Option<(u32, u32)>| side.map(|(from, to)| (at(to) - at(from)).normalize());
        let (Some(before), Some(after)) = (along(before), along(after)) else { return false };
        before.dot(&after) <= BENT && self.normal.dot(&before.cross(&after)) > 0.0
    }

    /// The vertices from one on, but for the last.
    fn from(&self, first: u32) -> impl Iterator<Item = u32> {
        let start = self.vertices.iter().position(|&vertex| vertex == first).unwrap_or(0);
        self.vertices.iter().copied().cycle().skip(start).take(self.vertices.len() - 1)
    }
}

/// The triangles of a closed surface, joined where what two parts make is flat and convex, along
/// the longest sides first.
pub(super) fn coplanar_faces(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Vec<CoplanarFace> {
    let at = |i: u32| vertices[i as usize];
    let mut polygons: Vec<Option<CoplanarFace>> =
        triangles.iter().map(|corners| Some(CoplanarFace::new(corners.to_vec(), &at))).collect();
    // From the directed side of a polygon to the polygon.
    let mut owner: HashMap<(u32, u32), usize> = HashMap::new();
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        owner.extend([(a, b), (b, c), (c, a)].map(|side| (side, t)));
    }
    let mut shared: Vec<(u32, u32)> = owner.keys().copied().filter(|(from, to)| from < to).collect();
    let length = |&(from, to): &(u32, u32)| (at(to) - at(from)).norm();
    shared.sort_unstable_by(|a, b| length(b).total_cmp(&length(a)).then(a.cmp(b)));
    for (from, to) in shared {
        let (Some(&one), Some(&other)) = (owner.get(&(from, to)), owner.get(&(to, from))) else { continue };
        let (Some(left), Some(right)) = (&polygons[one], &polygons[other]) else { continue };
        let sides = left.vertices.len() + right.vertices.len() - 2;
        if one == other || sides > MOST_SIDES || left.normal.dot(&right.normal) < 0.0 {
            continue;
        }
        let both = CoplanarFace::new(left.from(to).chain(right.from(from)).collect(), &at);
        if both.is_flat(&at) && [from, to].iter().all(|&end| both.is_bent(end, &at)) {
            owner.extend(right.from(from).zip(right.from(from).skip(1).chain([to])).map(|side| (side, one)));
            (polygons[one], polygons[other]) = (Some(both), None);
        }
    }
    polygons.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A prism of 20 mm over an outline (m) as polygons; its first vertex is lower by `lift` (m).
    fn of_prism(outline: &[[f64; 2]], caps: &[[u32; 3]], lift: f64) -> Vec<CoplanarFace> {
        let count = outline.len() as u32;
        let at = |z: f64| outline.iter().map(move |&[x, y]| Vector3::new(x, y, z));
        let mut vertices: Vec<Vector3<f64>> = at(0.0).chain(at(0.02)).collect();
        vertices[0].z -= lift;
        let sides = (0..count).flat_map(|k| {
            let (a, b) = (k, (k + 1) % count);
            [[a, b, b + count], [a, b + count, a + count]]
        });
        let bottom = caps.iter().map(|&[a, b, c]| [a, c, b]);
        let top = caps.iter().map(|corners| corners.map(|k| k + count));
        coplanar_faces(&vertices, &sides.chain(bottom).chain(top).collect::<Vec<_>>())
    }

    #[test]
    fn flat_sides_are_one_polygon_each() {
        let square = [[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]];
        let faces = of_prism(&square, &[[0, 1, 2], [0, 2, 3]], 0.0);
        assert_eq!(faces.iter().map(|face| face.vertices.len()).collect::<Vec<_>>(), [4; 6]);
        let middle = Vector3::new(5e-3, 5e-3, 1e-2);
        for face in &faces {
            assert!((face.normal.norm() - 1.0).abs() < 1e-15);
            let half = if face.normal.z == 0.0 { 5e-3 } else { 1e-2 };
            assert!((face.offset - face.normal.dot(&middle) - half).abs() < 1e-17, "outwards, through its vertices");
        }
        // A corner a micrometre off the plane is none of it.
        assert_eq!(of_prism(&square, &[[0, 1, 2], [0, 2, 3]], 1e-6).len(), 7);
        assert_eq!(of_prism(&square, &[[0, 1, 3], [1, 2, 3]], 1e-6).len(), 7);
    }

    #[test]
    fn polygons_are_convex() {
        let angle = [[0.0, 0.0], [0.02, 0.0], [0.02, 0.01], [0.01, 0.01], [0.01, 0.02], [0.0, 0.02]];
        let faces = of_prism(&angle, &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]], 0.0);
        // Both ends in two parts.
        assert_eq!(faces.len(), 6 + 4);
        let area = |face: &CoplanarFace| -> f64 {
            let [x, y]: [Vec<f64>; 2] =
                [0, 1].map(|axis| face.vertices.iter().map(|&k| angle[k as usize % 6][axis]).collect());
            (0..x.len()).map(|k| (k, (k + 1) % x.len())).map(|(k, l)| 0.5 * (x[k] * y[l] - x[l] * y[k])).sum()
        };
        let top: f64 = faces.iter().filter(|face| face.normal.z > 0.5).map(area).sum();
        assert!((top - 3e-4).abs() < 1e-15, "{top}");
    }
}

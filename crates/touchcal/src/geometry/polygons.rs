//! A surface of triangles as flat convex polygons: there are fewer, and fewer slivers among them.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::solid::WELD;

/// Sine of the angle up to which a straight line may bend inwards.
const STRAIGHT: f64 = 1e-9;

/// Most sides of a polygon: what joins more takes longer than it saves.
const MOST_SIDES: usize = 64;

/// A flat convex part of a surface.
pub(super) struct Polygon {
    /// Its vertices, counter-clockwise seen from outside.
    pub(super) vertices: Vec<u32>,
    /// Unit normal.
    pub(super) normal: Vector3<f64>,
    /// `normal · p` of its points.
    pub(super) offset: f64,
}

impl Polygon {
    /// Of vertices that are in a plane, as nearly as points are told apart.
    fn new(vertices: Vec<u32>, at: &impl Fn(u32) -> Vector3<f64>) -> Option<Self> {
        let from_first: Vec<Vector3<f64>> = vertices.iter().map(|&vertex| at(vertex) - at(vertices[0])).collect();
        let area: Vector3<f64> = from_first.windows(2).map(|pair| pair[0].cross(&pair[1])).sum();
        let normal = area.normalize();
        let heights = from_first.iter().map(|p| normal.dot(p));
        let middle = heights.clone().sum::<f64>() / vertices.len() as f64;
        let is_flat = heights.into_iter().all(|height| (height - middle).abs() <= WELD);
        is_flat.then(|| Polygon { offset: normal.dot(&at(vertices[0])) + middle, vertices, normal })
    }

    /// Its sides, from vertex to vertex.
    pub(super) fn sides(&self) -> impl Iterator<Item = (u32, u32)> {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next).map(|(&from, &to)| (from, to))
    }

    fn is_convex(&self, at: &impl Fn(u32) -> Vector3<f64>) -> bool {
        let count = self.vertices.len();
        (0..count).all(|k| {
            let [a, b, c] = [k, k + 1, k + 2].map(|k| at(self.vertices[k % count]));
            let (before, after) = ((b - a).normalize(), (c - b).normalize());
            let bend = self.normal.dot(&before.cross(&after));
            bend > STRAIGHT || (bend >= -STRAIGHT && before.dot(&after) > 0.0)
        })
    }

    /// The vertices from one on, but for the last.
    fn from(&self, first: u32) -> impl Iterator<Item = u32> {
        let start = self.vertices.iter().position(|&vertex| vertex == first).unwrap_or(0);
        self.vertices.iter().copied().cycle().skip(start).take(self.vertices.len() - 1)
    }
}

/// The triangles of a closed surface, joined as long as what two of them make is flat and convex; where they have the longest sides in common first.
pub(super) fn polygons(vertices: &[Vector3<f64>], triangles: &[[u32; 3]]) -> Vec<Polygon> {
    let at = |i: u32| vertices[i as usize];
    let mut polygons: Vec<Option<Polygon>> =
        triangles.iter().map(|corners| Polygon::new(corners.to_vec(), &at)).collect();
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
        let both = Polygon::new(left.from(to).chain(right.from(from)).collect(), &at);
        if let Some(both) = both.filter(|both| both.is_convex(&at)) {
            owner.extend(right.from(from).zip(right.from(from).skip(1).chain([to])).map(|side| (side, one)));
            (polygons[one], polygons[other]) = (Some(both), None);
        }
    }
    polygons.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sides of a prism over an outline (m), upside down and right, as polygons.
    fn of_prism(outline: &[[f64; 2]], caps: &[[u32; 3]], lift: f64) -> Vec<Polygon> {
        let count = outline.len() as u32;
        let at = |z: f64| outline.iter().map(move |&[x, y]| Vector3::new(x, y, z));
        let mut vertices: Vec<Vector3<f64>> = at(0.0).chain(at(0.02)).collect();
        // Off the plane of the others.
        vertices[0].z -= lift;
        let sides = (0..count).flat_map(|k| {
            let (a, b) = (k, (k + 1) % count);
            [[a, b, b + count], [a, b + count, a + count]]
        });
        let bottom = caps.iter().map(|&[a, b, c]| [a, c, b]);
        let top = caps.iter().map(|corners| corners.map(|k| k + count));
        polygons(&vertices, &sides.chain(bottom).chain(top).collect::<Vec<_>>())
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
        let area = |face: &Polygon| -> f64 {
            let [x, y]: [Vec<f64>; 2] =
                [0, 1].map(|axis| face.vertices.iter().map(|&k| angle[k as usize % 6][axis]).collect());
            (0..x.len()).map(|k| (k, (k + 1) % x.len())).map(|(k, l)| 0.5 * (x[k] * y[l] - x[l] * y[k])).sum()
        };
        let top: f64 = faces.iter().filter(|face| face.normal.z > 0.5).map(area).sum();
        assert!((top - 3e-4).abs() < 1e-15, "{top}");
    }

    #[test]
    fn round_ends_are_joined_without_end() {
        const COUNT: u32 = 2000;
        let circle: Vec<[f64; 2]> = (0..COUNT)
            .map(|k| (std::f64::consts::TAU * f64::from(k) / f64::from(COUNT)).sin_cos())
            .map(|(sine, cosine)| [0.05 * cosine, 0.05 * sine])
            .collect();
        let fan: Vec<[u32; 3]> = (1..COUNT - 1).map(|k| [0, k, k + 1]).collect();
        let faces = of_prism(&circle, &fan, 0.0);
        let most = faces.iter().map(|face| face.vertices.len()).max();
        assert_eq!(most, Some(MOST_SIDES));
        // Each side one, and each end about as many as it must have.
        let ends = faces.len() - COUNT as usize;
        assert!((64..160).contains(&ends), "{ends}");
    }
}

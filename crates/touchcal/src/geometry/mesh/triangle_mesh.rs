//! Bodies of any shape: closed surfaces of triangles.

use std::collections::{BTreeMap, HashMap};
use std::fmt;

use nalgebra::{Point2, Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use super::features::MeshFeatures;
use super::weld::weld;

/// Largest number of triangles that [`TriangleMesh::new`] accepts.
pub const MAX_TRIANGLES: usize = 20_000;
/// Height (m) of a triangle below which it has no direction.
const FLAT: f64 = 1e-9;

/// A point x, y, z in millimetres, in the body's frame, for messages: displayed as `(x, y, z) mm`
/// with four decimals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMm(pub Point3<f64>);

impl PointMm {
    fn from_metres(point: Point3<f64>) -> Self {
        PointMm(point * 1e3)
    }
}

impl fmt::Display for PointMm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({:.4}, {:.4}, {:.4}) mm", self.0.x, self.0.y, self.0.z)
    }
}

/// Why triangles are not the surface of a body. Checks run in the order of the variants; the first
/// that fails is reported.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TriangleMeshError {
    /// Fewer than 4 triangles, or more than [`MAX_TRIANGLES`]; those of coinciding corners count.
    #[error(
        "a solid has 4 to {MAX_TRIANGLES} triangles, found {found} (simplify a finer one; within 0.005 mm of the part it is accurate enough)"
    )]
    TriangleCount {
        /// Number of triangles given.
        found: usize,
    },
    /// A triangle has a vertex index that is out of range, or a corner with a coordinate that is
    /// NaN or infinite.
    #[error("triangle {triangle}: expected three vertices of finite coordinates")]
    Vertex {
        /// Index of the triangle, from 0.
        triangle: usize,
    },
    /// A triangle without area: its least height is below 1 nm.
    #[error("triangle {triangle} at {at}: expected three corners that are not on one line")]
    Flat {
        /// Index of the triangle, from 0.
        triangle: usize,
        /// Its first corner (mm, in the body's frame).
        at: PointMm,
    },
    /// An edge that does not have exactly two triangles.
    #[error(
        "expected a closed surface, of which each edge has two triangles; the edge from {from} to {to} has {found} (edges of that kind: {edges})"
    )]
    Open {
        /// One end of the first such edge (mm, in the body's frame).
        from: PointMm,
        /// The other end of that edge (mm, in the body's frame).
        to: PointMm,
        /// Number of triangles that have this edge: 1, or more than 2.
        found: usize,
        /// Number of edges without two triangles.
        edges: usize,
    },
    /// Two neighbouring triangles whose corners are listed in opposite directions seen from
    /// outside.
    #[error(
        "expected triangles whose corners all go the same way round seen from outside; those at the edge from {from} to {to} do not (edges of that kind: {edges})"
    )]
    InconsistentWinding {
        /// One end of the first edge between such triangles (mm, in the body's frame).
        from: PointMm,
        /// The other end of that edge (mm, in the body's frame).
        to: PointMm,
        /// Number of edges between such triangles.
        edges: usize,
    },
    /// The surface encloses less than 1 nm³ (10⁻²⁷ m³), or a volume that is not finite.
    #[error("expected a surface that encloses a volume, found {volume} m³")]
    NoVolume {
        /// The signed volume (m³), negative if the surface is inside out.
        volume: f64,
    },
}

/// A body bounded by a closed surface of triangles (m, in the body's frame).
///
/// Vertices nearer to each other than [`WELD_DISTANCE`](super::weld::WELD_DISTANCE) are merged into
/// the first of them. A surface that is inside out is reversed.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    surface: TriMesh,
    pub(crate) features: MeshFeatures,
    volume: f64,
}

fn to_parry(p: &Point3<f64>) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

fn from_parry(v: Vector) -> Point3<f64> {
    Point3::new(v.x, v.y, v.z)
}

impl TriangleMesh {
    /// A body from vertices (m, in the body's frame) and triangles: three indices into `vertices`
    /// each, from 0, counter-clockwise seen from outside. Triangles of which two corners coincide
    /// after merging are left out; vertices of no triangle are allowed.
    ///
    /// # Errors
    /// [`TriangleMeshError`] if there are fewer than 4 or more than [`MAX_TRIANGLES`] triangles, an
    /// index or a coordinate of a corner is invalid, a triangle is flat, the surface is not closed
    /// or not consistently oriented, or it encloses no volume. That it does not intersect itself is
    /// not checked.
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, TriangleMeshError> {
        if !(4..=MAX_TRIANGLES).contains(&triangles.len()) {
            return Err(TriangleMeshError::TriangleCount { found: triangles.len() });
        }
        let is_vertex = |&i: &u32| vertices.get(i as usize).is_some_and(|p| p.iter().all(|c| c.is_finite()));
        if let Some(triangle) = triangles.iter().position(|corners| !corners.iter().all(is_vertex)) {
            return Err(TriangleMeshError::Vertex { triangle });
        }
        let (vertices, place) = weld(vertices);
        let mut welded = Vec::with_capacity(triangles.len());
        for (triangle, corners) in triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|i| place[i as usize]);
            // Two corners that are one: nothing is lost without it.
            if a == b || b == c || c == a {
                continue;
            }
            let [p, q, r] = [a, b, c].map(|i| vertices[i as usize]);
            let longest = (q - p).norm().max((r - q).norm()).max((p - r).norm());
            if (q - p).cross(&(r - p)).norm() < FLAT * longest {
                return Err(TriangleMeshError::Flat { triangle, at: PointMm::from_metres(p) });
            }
            welded.push([a, b, c]);
        }
        check_closed(&vertices, &welded)?;
        let volume = volume(&vertices, &welded);
        if volume.abs() < FLAT * FLAT * FLAT || !volume.is_finite() {
            return Err(TriangleMeshError::NoVolume { volume });
        }
        if volume < 0.0 {
            welded.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let features = MeshFeatures::new(&vertices, &welded);
        let count = welded.len();
        let surface = TriMesh::with_flags(vertices.iter().map(to_parry).collect(), welded, TriMeshFlags::ORIENTED)
            .map_err(|_| TriangleMeshError::TriangleCount { found: count })?;
        Ok(TriangleMesh { surface, features, volume: volume.abs() })
    }

    /// Number of triangles, without those of which two corners coincided.
    pub fn triangle_count(&self) -> usize {
        self.surface.num_triangles()
    }

    /// Vertices (m, in the body's frame) after merging, in the order of their first appearance;
    /// those of no triangle too.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Point3<f64>> + '_ {
        self.surface.vertices().iter().map(|&v| from_parry(v))
    }

    /// Triangles in the order given to [`new`](TriangleMesh::new): three indices into
    /// [`vertices`](TriangleMesh::vertices) each, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.surface.indices()
    }

    /// Enclosed volume (m³), positive.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Number of connected surfaces whose signed volume is positive: surfaces around cavities do
    /// not count, bodies that share a vertex are one, and bodies that overlap are several.
    pub fn body_count(&self) -> usize {
        let vertices: Vec<Point3<f64>> = self.vertices().collect();
        let surfaces = connected(vertices.len(), self.triangles());
        surfaces.iter().filter(|triangles| volume(&vertices, triangles) > 0.0).count()
    }

    /// Distance (m) from a point to the surface, negative inside, and the nearest point of the
    /// surface; both points in the body's frame (m), the given one of finite coordinates.
    ///
    /// Inside and outside follow from pseudonormals (Bærentzen & Aanæs, *Signed distance
    /// computation using the angle weighted pseudonormal*, 2005).
    pub fn signed_distance(&self, point: &Point3<f64>) -> (f64, Point3<f64>) {
        let projection = self.surface.project_local_point(to_parry(point), false);
        let foot = from_parry(projection.point);
        let distance = (point - foot).norm();
        (if projection.is_inside { -distance } else { distance }, foot)
    }

    /// Vertices at which a convex edge of the body ends (m, in the body's frame), in the order of
    /// [`vertices`](TriangleMesh::vertices), without those that only divide a straight edge.
    pub fn corners(&self) -> Vec<Point3<f64>> {
        self.features.corners.iter().map(|corner| self.features.vertices[corner.vertex as usize].into()).collect()
    }

    /// Convex hull of the body projected along the z axis of its frame: x and y of the hull's
    /// vertices (m), at least three, counter-clockwise from the one of least x, without those on a
    /// straight line (the monotone chain of Andrew, 1979).
    pub fn shadow(&self) -> Vec<Point2<f64>> {
        let mut points: Vec<Point2<f64>> = self.vertices().map(|p| p.xy()).collect();
        points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        let mut hull: Vec<Point2<f64>> = Vec::new();
        // The lower side from left to right, then the upper one back.
        let back = points.clone().into_iter().rev();
        for side in [points.into_iter().collect::<Vec<_>>(), back.collect()] {
            let begin = hull.len();
            for p in side {
                while hull.len() >= begin + 2 {
                    let (a, b) = (hull[hull.len() - 2], hull[hull.len() - 1]);
                    if (b - a).perp(&(p - b)) > 0.0 {
                        break;
                    }
                    hull.pop();
                }
                hull.push(p);
            }
            hull.pop();
        }
        hull
    }
}

/// Whether each edge has one triangle on each side.
fn check_closed(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), TriangleMeshError> {
    // Of each edge, how many triangles go along it and how many against it.
    let mut uses: HashMap<[u32; 2], [usize; 2]> = HashMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            uses.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
        }
    }
    let at = |i: u32| PointMm::from_metres(vertices[i as usize]);
    // The first in the order of vertices, so that the same file is always answered the same.
    let first_of = |is_bad: &dyn Fn(&[usize; 2]) -> bool| {
        let bad = uses.iter().filter(|(_, uses)| is_bad(uses));
        (bad.clone().count(), bad.min_by_key(|(ends, _)| **ends))
    };
    if let (edges, Some((&[from, to], uses))) = first_of(&|[along, against]| along + against != 2) {
        return Err(TriangleMeshError::Open { from: at(from), to: at(to), found: uses[0] + uses[1], edges });
    }
    if let (edges, Some((&[from, to], _))) = first_of(&|[along, against]| along != against) {
        return Err(TriangleMeshError::InconsistentWinding { from: at(from), to: at(to), edges });
    }
    Ok(())
}

/// The triangles of each connected surface, by a disjoint-set forest of the vertices (Galler &
/// Fischer, *An improved equivalence algorithm*, 1964).
fn connected(vertices: usize, triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 3]>> {
    fn root(parents: &mut [u32], mut vertex: u32) -> u32 {
        while parents[vertex as usize] != vertex {
            // Halves the way for the next search.
            parents[vertex as usize] = parents[parents[vertex as usize] as usize];
            vertex = parents[vertex as usize];
        }
        vertex
    }
    let mut parents: Vec<u32> = (0..vertices as u32).collect();
    for &[a, b, c] in triangles {
        let [a, b, c] = [a, b, c].map(|corner| root(&mut parents, corner));
        parents[b as usize] = a;
        let c = root(&mut parents, c);
        parents[c as usize] = a;
    }
    let mut surfaces: BTreeMap<u32, Vec<[u32; 3]>> = BTreeMap::new();
    for &triangle in triangles {
        surfaces.entry(root(&mut parents, triangle[0])).or_default().push(triangle);
    }
    surfaces.into_values().collect()
}

fn volume(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    // Relative to one vertex, so that a far-away body keeps its digits.
    let origin = vertices.first().copied().unwrap_or_else(Point3::origin);
    let corner = |i: u32| -> Vector3<f64> { vertices[i as usize] - origin };
    triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c)))).sum::<f64>() / 6.0
}

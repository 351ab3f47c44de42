//! Bodies of any shape: closed surfaces of triangles.

use std::collections::HashMap;
use std::fmt;

use nalgebra::{Point2, Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};

use super::facets::Facets;

/// Most triangles of a solid.
pub const MAX_TRIANGLES: usize = 500_000;
/// Points (m) that are nearer to each other are one.
pub const WELD: f64 = 1e-8;
/// Height (m) of a triangle below which it has no direction.
const FLAT: f64 = 1e-9;

/// A point in millimetres, for messages.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot(pub Point3<f64>);

impl fmt::Display for Spot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mm = self.0 * 1e3;
        write!(f, "({:.4}, {:.4}, {:.4}) mm", mm.x, mm.y, mm.z)
    }
}

/// Why triangles are not the surface of a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidError {
    /// Too few or too many triangles.
    #[error("a solid has 4 to {MAX_TRIANGLES} triangles, found {found}")]
    TriangleCount {
        /// Number of triangles given.
        found: usize,
    },
    /// A coordinate is NaN or infinite, or a triangle names a vertex that is not there.
    #[error("triangle {triangle}: expected three vertices of finite coordinates")]
    Vertex {
        /// Which triangle, from 0.
        triangle: usize,
    },
    /// A triangle without area.
    #[error("triangle {triangle} at {at}: expected three corners that are not on one line")]
    Flat {
        /// Which triangle, from 0.
        triangle: usize,
        /// One of its corners.
        at: Spot,
    },
    /// An edge that does not have one triangle on each side.
    #[error(
        "expected a closed surface, of which each edge has two triangles; the edge from {from} to {to} has {found} (edges of that kind: {edges})"
    )]
    Open {
        /// One end.
        from: Spot,
        /// The other end.
        to: Spot,
        /// How many triangles have this edge.
        found: usize,
        /// How many edges are so.
        edges: usize,
    },
    /// Two triangles of which one is turned over.
    #[error(
        "expected triangles whose corners all go the same way round seen from outside; those at the edge from {from} to {to} do not (edges of that kind: {edges})"
    )]
    Turned {
        /// One end.
        from: Spot,
        /// The other end.
        to: Spot,
        /// How many edges are so.
        edges: usize,
    },
    /// The surface encloses nothing.
    #[error("expected a surface that encloses a volume, found {volume} m³")]
    NoVolume {
        /// The signed volume (m³).
        volume: f64,
    },
}

/// A body as the closed surface of triangles, in metres.
///
/// Vertices nearer to each other than [`WELD`] are one. A surface that is inside out is turned
/// over.
#[derive(Clone, Debug)]
pub struct Solid {
    surface: TriMesh,
    pub(super) facets: Facets,
    volume: f64,
}

fn to_parry(p: &Point3<f64>) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

fn from_parry(v: Vector) -> Point3<f64> {
    Point3::new(v.x, v.y, v.z)
}

impl Solid {
    /// A body from the corners of its triangles, counter-clockwise seen from outside.
    ///
    /// # Errors
    /// [`SolidError`] if the surface is not closed, and where.
    pub fn new(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<Self, SolidError> {
        if !(4..=MAX_TRIANGLES).contains(&triangles.len()) {
            return Err(SolidError::TriangleCount { found: triangles.len() });
        }
        let is_vertex = |&i: &u32| vertices.get(i as usize).is_some_and(|p| p.iter().all(|c| c.is_finite()));
        if let Some(triangle) = triangles.iter().position(|corners| !corners.iter().all(is_vertex)) {
            return Err(SolidError::Vertex { triangle });
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
                return Err(SolidError::Flat { triangle, at: Spot(p) });
            }
            welded.push([a, b, c]);
        }
        check_closed(&vertices, &welded)?;
        let volume = volume(&vertices, &welded);
        if volume.abs() < FLAT * FLAT * FLAT || !volume.is_finite() {
            return Err(SolidError::NoVolume { volume });
        }
        if volume < 0.0 {
            welded.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let facets = Facets::new(&vertices, &welded);
        let count = welded.len();
        let surface = TriMesh::with_flags(vertices.iter().map(to_parry).collect(), welded, TriMeshFlags::ORIENTED)
            .map_err(|_| SolidError::TriangleCount { found: count })?;
        Ok(Solid { surface, facets, volume: volume.abs() })
    }

    /// Number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.surface.num_triangles()
    }

    /// Vertices (m).
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Point3<f64>> + '_ {
        self.surface.vertices().iter().map(|&v| from_parry(v))
    }

    /// Vertices of each triangle, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        self.surface.indices()
    }

    /// Enclosed volume (m³).
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Distance (m) from a point to the surface, negative inside, and the nearest point of the
    /// surface.
    ///
    /// Inside and outside follow from pseudonormals (Bærentzen & Aanæs, *Signed distance
    /// computation using the angle weighted pseudonormal*, 2005).
    pub fn signed_distance(&self, point: &Point3<f64>) -> (f64, Point3<f64>) {
        let projection = self.surface.project_local_point(to_parry(point), false);
        let foot = from_parry(projection.point);
        let distance = (point - foot).norm();
        (if projection.is_inside { -distance } else { distance }, foot)
    }

    /// Corners (m): vertices where it sticks out.
    pub fn corners(&self) -> Vec<Point3<f64>> {
        self.facets.corners.iter().map(|corner| self.facets.vertices[corner.vertex as usize].into()).collect()
    }

    /// The hull of its shadow along z, counter-clockwise (m).
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

/// The distinct points among `points`, and which of them each is.
fn weld(points: &[Point3<f64>]) -> (Vec<Point3<f64>>, Vec<u32>) {
    let cell = |p: &Point3<f64>| [p.x, p.y, p.z].map(|c| (c / WELD).round() as i64);
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
                .find(|&&other| (distinct[other as usize] - p).norm() < WELD);
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

/// Whether each edge has one triangle on each side.
fn check_closed(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> Result<(), SolidError> {
    // Of each edge, how many triangles go along it and how many against it.
    let mut uses: HashMap<[u32; 2], [usize; 2]> = HashMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            uses.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
        }
    }
    let at = |i: u32| Spot(vertices[i as usize]);
    // The first in the order of vertices, so that the same file is always answered the same.
    let first_of = |is_bad: &dyn Fn(&[usize; 2]) -> bool| {
        let bad = uses.iter().filter(|(_, uses)| is_bad(uses));
        (bad.clone().count(), bad.min_by_key(|(ends, _)| **ends))
    };
    if let (edges, Some((&[from, to], uses))) = first_of(&|[along, against]| along + against != 2) {
        return Err(SolidError::Open { from: at(from), to: at(to), found: uses[0] + uses[1], edges });
    }
    if let (edges, Some((&[from, to], _))) = first_of(&|[along, against]| along != against) {
        return Err(SolidError::Turned { from: at(from), to: at(to), edges });
    }
    Ok(())
}

fn volume(vertices: &[Point3<f64>], triangles: &[[u32; 3]]) -> f64 {
    // Relative to one vertex, so that a far-away body keeps its digits.
    let origin = vertices.first().copied().unwrap_or_else(Point3::origin);
    let corner = |i: u32| -> Vector3<f64> { vertices[i as usize] - origin };
    triangles.iter().map(|&[a, b, c]| corner(a).dot(&corner(b).cross(&corner(c)))).sum::<f64>() / 6.0
}

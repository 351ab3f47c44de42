//! Contact manifolds as data, to send them to other processes.
//!
//! Outlines, meshes and samples are checked as by their constructors; all else is trusted as
//! [`serialize`] wrote it. The format must keep infinite numbers, as CBOR does and JSON does not.

use std::any::Any;
use std::sync::Arc;

use nalgebra::{Point2, Point3};
use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::ball_in_socket::BallInSocket;
use super::contact_manifold::ContactManifold;
use super::peg_in_hole::PegInHole;
use super::plane::Plane;
use super::projection::coordinates::{Coordinates, Metric};
#[cfg(feature = "learned")]
use super::projection::learned::LearnedProjection;
use super::projection::{NearestSample, PoseSamples, Projected, Projection};
use super::target::Target;
use super::unmodeled::Unmodeled;
use crate::geometry::{EdgeRadii, MeshPair, Polygon, PrismPair, TriangleMesh};

/// What a manifold of this crate is made of: making it again gives the same residuals, bit by bit.
#[derive(Serialize, Deserialize)]
enum ManifoldData {
    BallInSocket,
    Plane(Plane),
    Target(Target),
    /// Peg and hole as prisms, by outlines and lengths (m), and how deep the tip reaches (m).
    Prisms {
        peg: (Vec<Point2<f64>>, f64),
        hole: (Vec<Point2<f64>>, f64),
        edge_radii: EdgeRadii,
        depth: f64,
    },
    /// Peg and hole as meshes, and how deep the tip reaches (m).
    Meshes {
        peg: Surface,
        hole: Surface,
        depth: f64,
    },
    Nearest {
        samples: Vec<Coordinates>,
        metric: Metric,
        neighbours: usize,
    },
    #[cfg(feature = "learned")]
    Learned(LearnedProjection),
    Unmodeled,
}

/// Vertices (m) and triangles of a mesh.
#[derive(Serialize, Deserialize)]
struct Surface(Vec<Point3<f64>>, Vec<[u32; 3]>);

impl Surface {
    fn of(mesh: &TriangleMesh) -> Surface {
        Surface(mesh.vertices().collect(), mesh.triangles().to_vec())
    }
}

impl ManifoldData {
    /// Of a manifold; `None` of one that is not of this crate.
    fn of(manifold: &dyn ContactManifold) -> Option<ManifoldData> {
        let manifold: &dyn Any = manifold;
        if manifold.is::<BallInSocket>() {
            return Some(ManifoldData::BallInSocket);
        }
        if manifold.is::<Unmodeled>() {
            return Some(ManifoldData::Unmodeled);
        }
        if let Some(plane) = manifold.downcast_ref::<Plane>() {
            return Some(ManifoldData::Plane(plane.clone()));
        }
        if let Some(target) = manifold.downcast_ref::<Target>() {
            return Some(ManifoldData::Target(*target));
        }
        if let Some(manifold) = manifold.downcast_ref::<PegInHole<PrismPair>>() {
            let (shapes, depth) = (manifold.shapes(), manifold.depth());
            let [peg, hole] = [(shapes.peg(), shapes.length()), (shapes.hole(), shapes.depth())]
                .map(|(outline, length)| (outline.vertices().to_vec(), length));
            return Some(ManifoldData::Prisms { peg, hole, edge_radii: shapes.edge_radii(), depth });
        }
        if let Some(manifold) = manifold.downcast_ref::<PegInHole<MeshPair>>() {
            let [peg, hole] = [manifold.shapes().tool(), manifold.shapes().fixture()].map(Surface::of);
            return Some(ManifoldData::Meshes { peg, hole, depth: manifold.depth() });
        }
        ManifoldData::of_projection(manifold.downcast_ref::<Projected>()?.0.as_ref())
    }

    fn of_projection(projection: &dyn Projection) -> Option<ManifoldData> {
        let any: &dyn Any = projection;
        if let Some(nearest) = any.downcast_ref::<NearestSample>() {
            let (samples, metric) = (nearest.samples().coordinates().to_vec(), projection.metric());
            return Some(ManifoldData::Nearest { samples, metric, neighbours: nearest.neighbours() });
        }
        #[cfg(feature = "learned")]
        if let Some(learned) = any.downcast_ref::<LearnedProjection>() {
            return Some(ManifoldData::Learned(learned.clone()));
        }
        None
    }

    /// The manifold, or what its parts are refused for.
    fn manifold(self) -> Result<Arc<dyn ContactManifold>, String> {
        let mesh = |Surface(vertices, triangles): Surface| {
            TriangleMesh::new(&vertices, &triangles).map_err(|error| error.to_string())
        };
        let outline = |vertices| Polygon::new(vertices).map_err(|error| error.to_string());
        Ok(match self {
            ManifoldData::BallInSocket => Arc::new(BallInSocket),
            ManifoldData::Plane(plane) => Arc::new(plane),
            ManifoldData::Target(target) => Arc::new(target),
            ManifoldData::Prisms { peg, hole, edge_radii, depth } => {
                let shapes = PrismPair::new(outline(peg.0)?, peg.1, outline(hole.0)?, hole.1);
                let shapes = shapes.and_then(|shapes| shapes.with_edge_radii(edge_radii));
                Arc::new(PegInHole::with_depth(shapes.map_err(|error| error.to_string())?, depth))
            }
            ManifoldData::Meshes { peg, hole, depth } => {
                Arc::new(PegInHole::with_depth(MeshPair::new(mesh(peg)?, mesh(hole)?), depth))
            }
            ManifoldData::Nearest { samples, metric, neighbours } => {
                let samples = PoseSamples::new(samples).map_err(|error| error.to_string())?;
                let nearest = NearestSample::new(samples, metric).with_neighbours(neighbours);
                Arc::new(Projected(Arc::new(nearest)))
            }
            #[cfg(feature = "learned")]
            ManifoldData::Learned(projection) => Arc::new(Projected(Arc::new(projection))),
            ManifoldData::Unmodeled => Arc::new(Unmodeled),
        })
    }
}

/// Serializes what a manifold is made of, for serde's attribute `with`.
///
/// # Errors
/// If it is a manifold of one's own.
pub fn serialize<S: Serializer>(manifold: &Arc<dyn ContactManifold>, serializer: S) -> Result<S::Ok, S::Error> {
    let data = ManifoldData::of(manifold.as_ref());
    data.ok_or_else(|| S::Error::custom(format!("a manifold `{}` of one's own has no data", manifold.name())))?
        .serialize(serializer)
}

/// The manifold that [`serialize`] wrote.
///
/// # Errors
/// If its parts are refused: an outline, a mesh, sizes, or samples that are not finite or of which
/// fewer than two differ.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Arc<dyn ContactManifold>, D::Error> {
    ManifoldData::deserialize(deserializer)?.manifold().map_err(D::Error::custom)
}

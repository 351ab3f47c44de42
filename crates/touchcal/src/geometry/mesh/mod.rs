//! Closed surfaces of triangles.

mod bvh;
mod coplanar_faces;
mod features;
mod triangle_mesh;
mod weld;

pub(super) use bvh::{Aabb, Bvh, LeafPair, leaf_pairs};
pub(super) use features::{ConvexEdge, ConvexVertex, Face, MeshFeatures};
pub use triangle_mesh::{MAX_TRIANGLES, PointMm, TriangleMesh, TriangleMeshError};
pub use weld::WELD_DISTANCE;

//! Shapes of parts, and the exact signed gap between them.
//!
//! | part | shape | signed gap |
//! |---|---|---|
//! | straight peg and hole, edges sharp or round | [`Polygon`]s along z | [`PrismPair`] |
//! | bodies of any shape | [`TriangleMesh`]es | [`MeshPair`] |
//!
//! [`prisms_of`] recognizes meshes that are straight, [`AxialSymmetry`] is what is known of round
//! parts. Lengths are metres.

mod edge_faces;
mod gap;
mod mesh;
mod mesh_gap;
mod parts;
mod polygon;
mod prism_gap;
mod recognize;
mod softmin;

pub use edge_faces::EdgeFaces;
pub use gap::{GapQuery, SignedGap};
pub use mesh::{MAX_TRIANGLES, PointMm, TriangleMesh, TriangleMeshError, WELD_DISTANCE};
pub use mesh_gap::{MeshPair, NeighborList};
pub use parts::Parts;
pub use polygon::{MAX_POLYGON_VERTICES, Polygon, PolygonError};
pub use prism_gap::{
    EdgeRadii, Feature, PrismPair, PrismPairError, nearest_feature, visit_features_below, visit_features_within,
};
pub use recognize::{AxialSymmetry, is_surface_of_revolution, prisms_of, rotational_order};

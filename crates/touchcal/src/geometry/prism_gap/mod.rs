//! The signed gap between a straight peg and a straight hole.

mod blend_sink;
mod corner_features;
mod edge_features;
mod feature;
mod feature_sweep;
mod gap_query;
mod prism_pair;
mod projected_polygon;
mod vertex_edge_bounds;
mod visit_features;

pub use feature::Feature;
pub use gap_query::{nearest_feature, visit_features_below, visit_features_within};
pub use prism_pair::{EdgeRadii, PrismPair, PrismPairError};

//! The signed gap between two meshes.

mod edge_pair;
mod gap_sweep;
mod mesh_pair;
mod neighbor_list;
mod penetration;
mod posed_pair;
mod tolerances;

pub use mesh_pair::MeshPair;
pub use neighbor_list::NeighborList;

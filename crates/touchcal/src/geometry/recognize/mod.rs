//! Recognition of straight and of round parts.

mod extrusion;
mod revolution;

pub use extrusion::prisms_of;
pub(super) use revolution::is_circle;
pub use revolution::{AxialSymmetry, is_surface_of_revolution, rotational_order};

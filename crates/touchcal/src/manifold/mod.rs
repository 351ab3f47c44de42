//! Contact manifolds: the poses at which a tool can touch a fixture, and how far a pose is from
//! touching.
//!
//! | manifold | tool and fixture |
//! |---|---|
//! | [`PegInHole`] | a peg in a hole, of prisms or of meshes |
//! | [`BallInSocket`] | a ball in a socket, the centres coincide |
//! | [`Plane`] | a point, ball or tip face on a plane |
//! | [`Target`] | a point or ball at places that an instrument measures |
//! | [`Projected`] | parts known by poses recorded in contact |
//! | [`Unmodeled`] | parts of unknown shape |
//!
//! A manifold of one's own implements [`ContactManifold`].

mod ball_in_socket;
mod cache;
mod contact_manifold;
mod exact;
mod gate;
pub mod manifold_data;
mod peg_in_hole;
mod plane;
mod projection;
mod residual;
mod sketch;
mod target;
mod unmodeled;

pub use ball_in_socket::BallInSocket;
pub use cache::ContactCache;
pub use contact_manifold::{ContactManifold, Cotangent, ResidualKind, RotationalOrders, SurfaceCounts};
pub use exact::{FITTING, Misfit, check_fit, exact_manifold, peg_in_hole};
pub use gate::{AXIS_DIRECTIONS, Gate, axis_direction};
pub use peg_in_hole::{PegInHole, PegInHoleShapes};
pub use plane::Plane;
#[cfg(feature = "learned")]
pub use projection::learned::{self, LearnedProjection};
pub use projection::{
    Coverage, NearestSample, Neighbour, PoseSamples, Projected, Projection, Quantiles, SamplesError, TrainingPairs,
    coordinates,
};
pub use residual::{MAX_ROWS, Residual};
pub use sketch::{Shape, Sketch};
pub use target::Target;
pub use unmodeled::Unmodeled;

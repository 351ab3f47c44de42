//! A peg in a hole, straight or of any shape.

mod candidates;
mod hole;
#[expect(clippy::module_inception, reason = "the file is named for its type")]
mod peg_in_hole;
mod shapes;
mod surfaces;

pub use peg_in_hole::PegInHole;
pub use shapes::PegInHoleShapes;

//! What a problem is read from, together.

use crate::estimate::Problem;
use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place};
use crate::manifold::ResidualKind;

/// A problem, and what is needed to write its result.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The problem.
    pub problem: Problem,
    /// Text of the robot's URDF, to be rewritten with [`crate::io::robot::urdf::rewrite`].
    pub urdf: String,
    /// Every file that was read, in that order.
    pub inputs: Vec<Input>,
}

impl Loaded {
    /// The same, if all its fixtures can be calibrated with.
    ///
    /// # Errors
    /// If a fixture's shape is unknown.
    pub fn with_known_shapes(self) -> Result<Loaded, IoError> {
        let unknown =
            self.problem.fixtures.iter().find(|fixture| fixture.manifold.residual_kind() == ResidualKind::Unmodeled);
        let Some(fixture) = unknown else { return Ok(self) };
        let found = "`unknown`; record its contacts with a calibrated arm (`touchcal manifold`) and give them as `manifold = \"nearest\"`";
        Err(IoError::unexpected(Place::file(format!("fixture `{}`", fixture.name)), "a known manifold", found))
    }
}

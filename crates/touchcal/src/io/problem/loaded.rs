//! A calibration problem together with the files it was read from.

use serde::{Deserialize, Serialize};

use crate::estimate::Problem;
use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place};
use crate::io::problem::problem_file::Assumptions;
use crate::manifold::ResidualKind;

/// A calibration problem, and what is needed to write its result.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Loaded {
    /// The calibration problem, in SI units.
    pub problem: Problem,
    /// Whole text of the robot's URDF, into which [`urdf::rewrite`](crate::io::urdf::rewrite)
    /// writes the calibrated arm.
    pub urdf: String,
    /// Path and fingerprint of every file that was read, in the order of reading: problem file,
    /// URDF, shapes of the tool, those of each fixture, logs. A problem that was read from a text
    /// has no entry for it.
    pub inputs: Vec<Input>,
    /// The tables `[noise]` and `[estimate]` of a file that poses this problem, as
    /// [`Settings::read`](crate::io::problem_file::Settings::read) takes them; empty if there is no
    /// such file.
    pub settings: String,
    /// What is assumed of tool, fixtures and distances where the problem file declares nothing.
    pub assumptions: Assumptions,
}

impl Loaded {
    /// Returns the problem unchanged after checking that the contact manifold of every fixture is
    /// known.
    ///
    /// # Errors
    /// [`IoError::Unexpected`] if a fixture is [`Unmodeled`](crate::manifold::Unmodeled); the first
    /// is named.
    pub fn with_known_shapes(self) -> Result<Loaded, IoError> {
        let unknown =
            self.problem.fixtures.iter().find(|fixture| fixture.manifold.residual_kind() == ResidualKind::Unmodeled);
        let Some(fixture) = unknown else { return Ok(self) };
        let found = "`unknown`; record its contacts with a calibrated arm (`touchcal manifold`) and give them as `manifold = \"nearest\"`";
        Err(IoError::unexpected(Place::file(format!("fixture `{}`", fixture.name)), "a known manifold", found))
    }
}

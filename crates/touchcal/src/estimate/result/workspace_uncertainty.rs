//! How well the tool is known.

use serde::{Deserialize, Serialize};

/// Expected errors of the tool, root mean squares over joint positions spread evenly over the
/// workspace: standard deviations for the calibrated arm, and for the nominal one its distance from
/// the calibrated arm together with these. Harmonics of the encoders count as corrected in both.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WorkspaceUncertainty {
    /// Of the tool's position in base (m), all three components together.
    pub position: f64,
    /// Of the tool's rotation vector in base (rad), all three components together.
    pub angle: f64,
    /// Of the distance between two positions of the tool (m), which does not depend on where the
    /// base is.
    pub distance: f64,
    /// The same of the nominal arm's tool: position (m).
    pub nominal_position: f64,
    /// Rotation (rad) of the nominal arm's tool.
    pub nominal_angle: f64,
    /// Distance (m) between two positions of the nominal arm's tool.
    pub nominal_distance: f64,
}

//! How well the tool is known.

/// Standard deviations of the calibrated arm's tool, root mean squares over joint positions spread
/// evenly over the workspace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorkspaceUncertainty {
    /// Of the tool's position in base (m), all three components together.
    pub position: f64,
    /// Of the tool's rotation vector in base (rad), all three components together.
    pub angle: f64,
    /// Of the distance between two positions of the tool (m), which does not depend on where the
    /// base is.
    pub distance: f64,
}

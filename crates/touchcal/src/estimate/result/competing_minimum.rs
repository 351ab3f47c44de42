//! Another minimum that contacts do not rule out.

use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// A minimum in which a search from another start ended, and which contacts do not rule out: the
/// arm may as well be that one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CompetingMinimum {
    /// Parameter values there (SI), in the order of
    /// [`Estimate::parameters`](super::Estimate::parameters) and as many.
    pub values: DVector<f64>,
    /// Cost of the least gaps there over that at the result (1).
    pub cost_ratio: f64,
    /// Distance (m) between the tool's positions in base of the arm there and of the result's, root
    /// mean square over the poses of the task that is asked for, or else over joint positions
    /// spread evenly over the workspace.
    pub tool_distance: f64,
    /// Index of the parameter of arm or tool that differs most from the result, in units of its
    /// scale; 0 if there is none.
    pub parameter: usize,
}

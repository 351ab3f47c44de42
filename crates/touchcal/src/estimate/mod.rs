//! The estimator: from a problem to parameters, their covariance, and what the data cannot determine.

mod bound;
mod calibrate;
mod conclude;
mod doubt;
mod evaluate;
mod gradient_descent;
mod identifiability;
mod inspect;
mod knowledge;
mod learn;
mod levenberg_marquardt;
mod loss;
mod mistakes;
mod normal;
mod outcome;
mod poses;
mod problem;
mod rows;
mod score;
mod statistics;
mod sums;
mod system;
mod walls;
mod workspace;

pub use bound::cramer_rao;
pub use calibrate::calibrate;
pub use evaluate::{distances, evaluate, place};
pub use gradient_descent::{Descent, Optimiser};
pub use identifiability::{Identifiability, NullDirection};
pub use inspect::{Expected, Inspection, JointRange, inspect};
pub use loss::Loss;
pub use outcome::{
    ContactCount, Estimate, Estimated, Progress, Stage, Status, StopReason, Termination, Verdict, Warning,
};
pub use poses::contact_poses;
pub use problem::{Distance, Fixture, Freedom, Method, Noise, Problem, Tool};
pub use score::{Score, Spread};
pub use workspace::{ToolUncertainty, distance_uncertainty, tool_uncertainty, workspace_configurations};

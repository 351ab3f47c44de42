//! The estimator: from a problem to parameters, their covariance, and what the data cannot determine.

mod loss;
mod problem;

pub use loss::Loss;
pub use problem::{Distance, Fixture, Freedom, Noise, Problem, Tool};

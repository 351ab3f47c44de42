//! The parameters of a calibration: what may be wrong with arm, tool and fixtures, as numbers with
//! names, units and priors.

mod arm;
mod block;
mod definition;
mod nuisance;
mod of_block;
mod parameter_id;

pub use arm::{joint_backlash, joint_compliance, joint_offset, joint_origin, of_arm_and_tool, segment_strain, strain};
pub use block::Block;
pub use definition::{Parameter, Prior, Unit};
pub(crate) use nuisance::joint_walk_rest;
pub use nuisance::{
    DEFAULT_WALK_SIGMA, directional_gap_bias, distance_error, edge_radius, gap_bias, joint_drift, joint_gear_ratio,
    joint_harmonic, joint_harmonic_2, joint_trend, joint_trend_with_sigma, joint_walk, wrench_bias, wrench_scale,
};
pub use of_block::{encoder_errors, of_block};
pub use parameter_id::{DIRECTION_NAMES, ParameterId, TWIST_NAMES, kinematic_part};

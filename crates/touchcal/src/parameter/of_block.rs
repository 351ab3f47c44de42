//! The parameters of a block, and the errors of encoders by parameters' names.

use super::arm::{joint_backlash, joint_compliance, joint_offset, joint_origin, segment_strain, strain};
use super::block::Block;
use super::definition::Parameter;
use super::nuisance::{
    DEFAULT_WALK_SIGMA, joint_gear_ratio, joint_harmonic, joint_harmonic_2, joint_trend, joint_walk,
};
use super::parameter_id::ParameterId;
use crate::robot::{EncoderTerm, Robot};

/// The parameters of a `block` of the arm or of its encoders, with their usual priors. Empty where
/// the arm has no such joint, and for all other blocks, whose parameters depend on the log, the
/// tool or the fixtures: drifts of placements, tool, fixture, gap biases, edges, wrench, distances.
pub fn of_block(block: Block, robot: &Robot) -> Vec<Parameter> {
    match block {
        Block::Strain => vec![strain()],
        Block::SegmentStrain => segment_strain(robot),
        Block::JointOffset => joint_offset(robot),
        Block::JointOrigin => joint_origin(robot),
        Block::JointCompliance => joint_compliance(robot),
        Block::JointBacklash => joint_backlash(robot),
        Block::JointTrend => joint_trend(robot),
        Block::JointWalk => joint_walk(robot, DEFAULT_WALK_SIGMA),
        Block::JointHarmonic => joint_harmonic(robot),
        Block::JointHarmonic2 => joint_harmonic_2(robot),
        Block::JointGearRatio => joint_gear_ratio(robot),
        Block::JointDrift | Block::Tool | Block::Fixture | Block::GapBias => Vec::new(),
        Block::EdgeRadius | Block::WrenchBias | Block::WrenchScale | Block::Distance => Vec::new(),
    }
}

/// Errors of the encoders of `robot` that depend on the position, of which `value` knows the
/// amplitude (SI) by the parameter's name, such as `joint_harmonic.joint_a1.sin`: index of the
/// moving joint, base first, term, and amplitude.
pub fn encoder_errors(robot: &Robot, value: impl Fn(&str) -> Option<f64>) -> Vec<(usize, EncoderTerm, f64)> {
    let blocks = [Block::JointHarmonic, Block::JointHarmonic2, Block::JointGearRatio];
    let parameters = blocks.into_iter().flat_map(|block| of_block(block, robot));
    let error = |parameter: Parameter| match parameter.id {
        ParameterId::EncoderError(joint, term) => Some((joint, term, value(&parameter.name)?)),
        _ => None,
    };
    parameters.filter_map(error).collect()
}

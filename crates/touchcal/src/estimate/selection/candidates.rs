//! Which models are compared.

use crate::estimate::problem::Problem;
use crate::parameter::{
    Block, Parameter, joint_compliance, joint_gear_ratio, joint_harmonic, joint_harmonic_2, joint_offset, joint_origin,
    segment_strain, strain,
};

/// Blocks that a model may have, in the order in which they are named.
const POOL: [Block; 8] = [
    Block::Strain,
    Block::SegmentStrain,
    Block::JointOffset,
    Block::JointOrigin,
    Block::JointCompliance,
    Block::JointHarmonic,
    Block::JointHarmonic2,
    Block::JointGearRatio,
];

/// The models that are always compared, each within the next but for encoder offsets, which joint
/// origins contain.
const NESTED: [&[Block]; 5] = [
    &[],
    &[Block::JointOffset],
    &[Block::JointOrigin],
    &[Block::JointOrigin, Block::JointCompliance],
    &[Block::JointOrigin, Block::JointCompliance, Block::JointHarmonic],
];

/// The blocks of all models that are compared in any case: the nested ones, and the declared one.
pub(super) fn nested(problem: &Problem) -> Vec<Vec<Block>> {
    let is_possible = |blocks: &&&[Block]| blocks.iter().all(|block| !parameters(problem, *block).is_empty());
    let mut models: Vec<Vec<Block>> = NESTED.iter().filter(is_possible).map(|blocks| blocks.to_vec()).collect();
    let declared = declared(problem);
    if !models.contains(&declared) {
        models.push(declared);
    }
    models
}

/// The blocks of the models with one block more or less than `blocks`.
pub(super) fn neighbours(problem: &Problem, blocks: &[Block]) -> Vec<Vec<Block>> {
    let each = POOL.into_iter().filter_map(|changed| {
        let has = |block: Block| (block == changed) != blocks.contains(&block);
        let neighbour: Vec<Block> = POOL.into_iter().filter(|block| has(*block)).collect();
        let is_new = blocks.contains(&changed) || is_independent(changed, blocks);
        (is_new && !parameters(problem, changed).is_empty()).then_some(neighbour)
    });
    each.collect()
}

/// The problem with these blocks of parameters in place of those of the pool that it declares.
/// Priors are as declared, and the usual ones of blocks that are not.
pub(super) fn with_blocks(problem: &Problem, blocks: &[Block]) -> Problem {
    let others = problem.parameters.iter().filter(|parameter| !POOL.contains(&parameter.id.block())).cloned();
    let chosen = blocks.iter().flat_map(|block| parameters(problem, *block));
    let parameters = chosen.chain(others).collect();
    problem.clone().with_parameters(parameters)
}

/// The blocks of the pool that the problem declares.
fn declared(problem: &Problem) -> Vec<Block> {
    let is_declared = |block: &Block| problem.parameters.iter().any(|parameter| parameter.id.block() == *block);
    POOL.into_iter().filter(is_declared).collect()
}

/// Whether `block` is none that joint origins or segments' strains in `blocks` contain, and none
/// that contains one of them.
fn is_independent(block: Block, blocks: &[Block]) -> bool {
    let contains = |outer: Block, inner: Block| match outer {
        Block::JointOrigin => matches!(inner, Block::Strain | Block::SegmentStrain | Block::JointOffset),
        Block::SegmentStrain => inner == Block::Strain,
        _ => false,
    };
    blocks.iter().all(|other| !contains(*other, block) && !contains(block, *other))
}

/// The parameters of a block of the pool.
fn parameters(problem: &Problem, block: Block) -> Vec<Parameter> {
    let of_block = |parameter: &&Parameter| parameter.id.block() == block;
    let declared: Vec<Parameter> = problem.parameters.iter().filter(of_block).cloned().collect();
    if !declared.is_empty() {
        return declared;
    }
    let robot = &problem.robot;
    match block {
        Block::Strain => vec![strain()],
        Block::SegmentStrain => segment_strain(robot),
        Block::JointOffset => joint_offset(robot),
        Block::JointOrigin => joint_origin(robot),
        Block::JointCompliance => joint_compliance(robot),
        Block::JointHarmonic => joint_harmonic(robot),
        Block::JointHarmonic2 => joint_harmonic_2(robot),
        Block::JointGearRatio => joint_gear_ratio(robot),
        _ => Vec::new(),
    }
}

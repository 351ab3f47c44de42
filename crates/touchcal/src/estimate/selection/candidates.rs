//! Which models are compared.

use crate::estimate::problem::Problem;
use crate::parameter::{Block, Parameter, of_block};

/// Blocks that a model may have, in the order in which they are named; backlash where torques, and
/// so their signs, are measured.
const POOL: [Block; 9] = [
    Block::Strain,
    Block::SegmentStrain,
    Block::JointOffset,
    Block::JointOrigin,
    Block::JointCompliance,
    Block::JointBacklash,
    Block::JointHarmonic,
    Block::JointHarmonic2,
    Block::JointGearRatio,
];

/// The blocks of [`POOL`] that models of a problem may have.
fn pool(problem: &Problem) -> impl Iterator<Item = Block> {
    let is_measured = problem.contacts.has_joint_torques();
    POOL.into_iter().filter(move |block| *block != Block::JointBacklash || is_measured)
}

/// Least width of the priors of harmonics and gear ratios, over the declared or usual one; widths
/// are halved down to it. What these blocks are for is often an error of another kind that looks
/// alike where contacts are; how wide their priors may be shows at contacts elsewhere.
const LEAST_WIDTH: f64 = 0.25;

/// A model of an arm.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Model {
    /// Its blocks of the pool, in the order of the pool.
    pub blocks: Vec<Block>,
    /// Standard deviations of the priors of the encoders' blocks over the declared or usual ones
    /// (1); 1 without such blocks.
    pub width: f64,
}

impl Model {
    fn new(blocks: Vec<Block>, width: f64) -> Model {
        let has_errors = blocks.iter().any(|block| block.is_encoder_error());
        Model { blocks, width: if has_errors { width } else { 1.0 } }
    }

    /// Whether it has all blocks of `other`, and more, with priors of encoders as wide where both
    /// have such.
    pub fn is_richer_than(&self, other: &Model) -> bool {
        let has_errors = other.blocks.iter().any(|block| block.is_encoder_error());
        self.blocks.len() > other.blocks.len()
            && other.blocks.iter().all(|block| self.blocks.contains(block))
            && (self.width == other.width || !has_errors)
    }
}

/// The models that are always compared, each within the next but for encoder offsets, which joint
/// origins contain.
const NESTED: [&[Block]; 5] = [
    &[],
    &[Block::JointOffset],
    &[Block::JointOrigin],
    &[Block::JointOrigin, Block::JointCompliance],
    &[Block::JointOrigin, Block::JointCompliance, Block::JointHarmonic],
];

/// The models that are compared in any case: the nested ones, and the declared one.
pub(super) fn nested(problem: &Problem) -> Vec<Model> {
    let is_possible = |blocks: &&&[Block]| blocks.iter().all(|block| !parameters(problem, *block).is_empty());
    let possible = NESTED.iter().filter(is_possible);
    let mut models: Vec<Model> = possible.map(|blocks| Model::new(blocks.to_vec(), 1.0)).collect();
    let declared = Model::new(declared(problem), 1.0);
    if !models.contains(&declared) {
        models.push(declared);
    }
    models
}

/// The models with one block more or less than `model`, and those with its blocks and priors of
/// encoders of twice or half the width.
pub(super) fn neighbours(problem: &Problem, model: &Model) -> Vec<Model> {
    let Model { blocks, width } = model;
    let each = pool(problem).filter_map(|changed| {
        let has = |block: Block| (block == changed) != blocks.contains(&block);
        let neighbour: Vec<Block> = pool(problem).filter(|block| has(*block)).collect();
        let is_new = blocks.contains(&changed) || is_independent(changed, blocks);
        (is_new && !parameters(problem, changed).is_empty()).then_some(Model::new(neighbour, *width))
    });
    let widths = [0.5 * width, 2.0 * width].into_iter().filter(|width| (LEAST_WIDTH..=1.0).contains(width));
    let others = widths.map(|width| Model::new(blocks.clone(), width)).filter(|other| other != model);
    each.chain(others).collect()
}

/// The problem with the model's blocks of parameters in place of those of the pool that it
/// declares. Priors are as declared, and the usual ones of blocks that are not; those of encoders
/// have the model's width.
pub(super) fn with_model(problem: &Problem, model: &Model) -> Problem {
    let is_compared = |parameter: &&Parameter| pool(problem).any(|block| block == parameter.id.block());
    let others = problem.parameters.iter().filter(|parameter| !is_compared(parameter)).cloned();
    let scaled = |parameter: Parameter| match parameter.prior_sigma() {
        Some(sigma) if parameter.id.block().is_encoder_error() => {
            let prior = parameter.prior.with_sigma(model.width * sigma);
            parameter.with_prior(prior)
        }
        _ => parameter,
    };
    let chosen = model.blocks.iter().flat_map(|block| parameters(problem, *block)).map(scaled);
    let parameters = chosen.chain(others).collect();
    problem.clone().with_parameters(parameters)
}

/// The blocks of the pool that the problem declares.
fn declared(problem: &Problem) -> Vec<Block> {
    let is_declared = |block: &Block| problem.parameters.iter().any(|parameter| parameter.id.block() == *block);
    pool(problem).filter(is_declared).collect()
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

/// The parameters of a block as declared, or the usual ones.
fn parameters(problem: &Problem, block: Block) -> Vec<Parameter> {
    let is_of_block = |parameter: &&Parameter| parameter.id.block() == block;
    let declared: Vec<Parameter> = problem.parameters.iter().filter(is_of_block).cloned().collect();
    if declared.is_empty() { of_block(block, &problem.robot) } else { declared }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLog, Source};
    use crate::estimate::problem::{PlacePrior, Tool};
    use crate::io::urdf::{self, Ends};
    use crate::parameter::{joint_backlash, joint_origin};
    use crate::se3::Pose;

    /// Where torques are not measured, backlash that is declared is in all models.
    #[test]
    fn backlash_is_compared_where_torques_are_measured() {
        let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
        let parameters = [joint_origin(&robot), joint_backlash(&robot)].concat();
        let problem = |is_measured: bool| {
            let mut contacts = ContactLog::new(7);
            contacts.push(&[0.0; 7], 0, Source { file: 0, line: 1 });
            if is_measured {
                contacts.set_joint_torques(&[1.0; 7]);
            }
            let tool = Tool { tip_from_tool: Pose::identity(), prior: PlacePrior::Fixed };
            Problem::new(robot.clone(), tool, Vec::new(), contacts).with_parameters(parameters.clone())
        };
        let origins = Model::new(vec![Block::JointOrigin], 1.0);
        for is_measured in [false, true] {
            let problem = problem(is_measured);
            let is_neighbour = neighbours(&problem, &origins).iter().any(|m| m.blocks.contains(&Block::JointBacklash));
            assert_eq!(is_neighbour, is_measured);
            let mut left = with_model(&problem, &origins).parameters.into_iter().map(|p| p.id.block());
            assert_eq!(left.any(|block| block == Block::JointBacklash), !is_measured);
        }
    }
}

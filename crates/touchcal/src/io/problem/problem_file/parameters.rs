//! What to estimate, and how: the `[estimate]` table.

use toml::Spanned;

use super::context::{Allowed, Context, DEG, MM};
use super::schema::{EstimateToml, LossToml, Number, OptimiserToml, PriorToml, Text, UnseenEffectsToml};
use crate::estimate::{GradientDescent, Loss, Method, Optimizer, UnseenEffects};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::{did_you_mean, list};
use crate::parameter::{
    Block, DEFAULT_WALK_SIGMA, Parameter, Unit, joint_trend, joint_trend_with_sigma, joint_walk, of_block,
};
use crate::robot::Robot;

/// Blocks that may be listed.
const BLOCKS: [Block; 14] = [
    Block::Strain,
    Block::SegmentStrain,
    Block::JointOffset,
    Block::JointOrigin,
    Block::JointCompliance,
    Block::JointBacklash,
    Block::JointDrift,
    Block::JointTrend,
    Block::JointWalk,
    Block::JointHarmonic,
    Block::JointHarmonic2,
    Block::JointGearRatio,
    Block::Tool,
    Block::Fixture,
];
/// Ways to search.
const METHODS: [&str; 2] = ["levenberg_marquardt", "gradient_descent"];
/// Most steps, and contacts, of a gradient descent.
const MOST_STEPS: f64 = 1e7;
/// Scales of the losses where none is given, in standard deviations. Huber and Cauchy: 95 %
/// efficiency on Gaussian noise (Zhang 1997, table 1). Geman–McClure: a contact at 3σ keeps a
/// quarter of its weight.
const HUBER: f64 = 1.345;
const CAUCHY: f64 = 2.385;
const GEMAN_MCCLURE: f64 = 3.0;
/// Least scale of a loss: a contact within its noise has hardly any weight with a smaller one.
const MIN_LOSS_SCALE: f64 = 0.1;

/// What the table asks for.
#[derive(Debug)]
pub(super) struct Wanted {
    pub(super) parameters: Vec<Parameter>,
    /// The tool's place is to be estimated.
    pub(super) tool: bool,
    /// The place of every fixture is to be estimated.
    pub(super) fixtures: bool,
    /// Where the joints' compliance or backlash is asked for, and which.
    pub(super) deflection: Option<(Place, Block)>,
    /// The joints' zeros may differ from placement to placement.
    pub(super) joint_drift: bool,
    pub(super) method: Method,
    pub(super) loss: Loss,
    pub(super) unseen_effects: UnseenEffects,
}

/// Declared standard deviations (rad) of changes of the encoder offsets over the log.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drift {
    /// Of linear changes.
    pub(super) trend: Option<f64>,
    /// Of random walks.
    pub(super) walk: Option<f64>,
}

/// What the table asks for, with the declared `drift` of the encoders.
pub(super) fn wanted(
    estimate: &EstimateToml,
    drift: Drift,
    robot: &Robot,
    context: &Context<'_>,
) -> Result<Wanted, IoError> {
    let mut wanted = Wanted {
        parameters: Vec::new(),
        tool: false,
        fixtures: false,
        deflection: None,
        joint_drift: false,
        method: method(estimate, context)?,
        loss: loss(estimate, context)?,
        unseen_effects: match estimate.unseen_effects {
            UnseenEffectsToml::Widen => UnseenEffects::Widen,
            UnseenEffectsToml::Ignore => UnseenEffects::Ignore,
        },
    };
    let priors = Priors::of(&estimate.prior, context)?;
    let mut seen = Vec::new();
    for name in &estimate.parameters {
        let block = block(name, context)?;
        if seen.contains(&block) {
            let place = context.place(name.span(), "estimate, parameters");
            return Err(IoError::unexpected(place, "distinct blocks", format!("{} twice", quoted(name.get_ref()))));
        }
        let none = [(Block::JointTrend, drift.trend, "trend"), (Block::JointWalk, drift.walk, "walk")];
        if let Some((.., kind)) = none.into_iter().find(|(of, sigma, _)| *of == block && *sigma == Some(0.0)) {
            let place = context.place(name.span(), "estimate, parameters");
            let expected = format!("no `joint_{kind}`, as `encoder_{kind}_deg` is 0");
            return Err(IoError::unexpected(place, expected, quoted(name.get_ref())));
        }
        seen.push(block);
        let parameters = match block {
            Block::JointWalk => joint_walk(robot, drift.walk.unwrap_or(DEFAULT_WALK_SIGMA)),
            _ => of_block(block, robot),
        };
        if block.is_deflection() {
            wanted.deflection = Some((context.place(name.span(), "estimate, parameters"), block));
        }
        wanted.tool |= block == Block::Tool;
        wanted.joint_drift |= block == Block::JointDrift;
        wanted.fixtures |= block == Block::Fixture;
        wanted.parameters.extend(parameters.into_iter().map(|parameter| priors.on(parameter)));
    }
    wanted.add_trend(drift.trend, robot);
    if let Some(sigma) = drift.walk.filter(|sigma| *sigma > 0.0 && !seen.contains(&Block::JointWalk)) {
        wanted.parameters.extend(joint_walk(robot, sigma));
    }
    freeze(&mut wanted.parameters, &estimate.freeze, context)?;
    Ok(wanted)
}

impl Wanted {
    /// Adds the trends of encoder offsets over the log, with `sigma` (rad) as prior standard
    /// deviation: none if it is 0, an estimated one if it is not declared. Offsets that are not
    /// estimated, or are for each placement, have no trend unless it is asked for.
    fn add_trend(&mut self, sigma: Option<f64>, robot: &Robot) {
        let has = |block: Block| self.parameters.iter().any(|parameter| parameter.id.block() == block);
        let is_asked = has(Block::JointTrend);
        let has_offsets = has(Block::JointOffset) || has(Block::JointOrigin);
        let is_applicable = has_offsets && !self.joint_drift && self.method == Method::LevenbergMarquardt;
        match sigma {
            Some(0.0) => {}
            Some(sigma) => {
                self.parameters.retain(|parameter| parameter.id.block() != Block::JointTrend);
                self.parameters.extend(joint_trend_with_sigma(robot, sigma));
            }
            None if is_asked || !is_applicable => {}
            None => self.parameters.extend(joint_trend(robot)),
        }
    }
}

fn block(name: &Text, context: &Context<'_>) -> Result<Block, IoError> {
    let names = || BLOCKS.iter().map(|block| block.name());
    BLOCKS.iter().find(|block| block.name() == name.get_ref()).copied().ok_or_else(|| {
        let found = format!("{}{}", quoted(name.get_ref()), did_you_mean(name.get_ref(), names()));
        let place = context.place(name.span(), "estimate, parameters");
        IoError::unexpected(place, format!("a block of parameters ({})", list(names())), found)
    })
}

/// Takes out the named parameters; `joint_origin.joint_a1` names all that begin so.
fn freeze(parameters: &mut Vec<Parameter>, names: &[Text], context: &Context<'_>) -> Result<(), IoError> {
    let all: Vec<String> = parameters.iter().map(|parameter| parameter.name.clone()).collect();
    for name in names {
        let frozen = |known: &str| {
            known.strip_prefix(name.get_ref().as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        if !all.iter().any(|known| frozen(known)) {
            let known = all.iter().map(String::as_str);
            let found = format!("{}{}", quoted(name.get_ref()), did_you_mean(name.get_ref(), known.clone()));
            let expected = format!("a parameter of the arm that is estimated ({})", list(known));
            return Err(IoError::unexpected(context.place(name.span(), "estimate, freeze"), expected, found));
        }
        parameters.retain(|parameter| !frozen(&parameter.name));
    }
    Ok(())
}

fn loss(estimate: &EstimateToml, context: &Context<'_>) -> Result<Loss, IoError> {
    let field = "estimate, loss_scale";
    let scale = context.number(estimate.loss_scale.as_ref(), 1.0, Allowed::Positive, field)?;
    if let Some(written) = estimate.loss_scale.as_ref().filter(|_| scale.is_some_and(|scale| scale < MIN_LOSS_SCALE)) {
        let place = context.place(written.span(), field);
        let expected = format!("a number of at least {MIN_LOSS_SCALE}");
        return Err(IoError::unexpected(place, expected, format!("{:?}", written.get_ref())));
    }
    Ok(match estimate.loss {
        LossToml::Squared => match &estimate.loss_scale {
            None => Loss::Squared,
            Some(scale) => {
                let place = context.place(scale.span(), field);
                return Err(IoError::unexpected(
                    place,
                    "no scale, as `squared` has none",
                    format!("{}", scale.get_ref()),
                ));
            }
        },
        LossToml::Huber => Loss::Huber(scale.unwrap_or(HUBER)),
        LossToml::Cauchy => Loss::Cauchy(scale.unwrap_or(CAUCHY)),
        LossToml::GemanMcClure => Loss::GemanMcClure(scale.unwrap_or(GEMAN_MCCLURE)),
    })
}

fn method(estimate: &EstimateToml, context: &Context<'_>) -> Result<Method, IoError> {
    let name = estimate.method.as_ref().map_or(METHODS[0], |name| name.get_ref());
    if !METHODS.contains(&name) {
        let place = context.place(estimate.method.as_ref().map_or(0..0, Spanned::span), "estimate, method");
        let found = format!("{}{}", quoted(name), did_you_mean(name, METHODS));
        return Err(IoError::unexpected(place, list(METHODS), found));
    }
    if name == METHODS[0] {
        let Some(table) = &estimate.descent else { return Ok(Method::LevenbergMarquardt) };
        let place = context.place(table.span(), "estimate, descent");
        return Err(IoError::unexpected(place, format!("`method = \"{}\"`", METHODS[1]), quoted(name)));
    }
    let mut descent = GradientDescent::default();
    let Some(table) = &estimate.descent else { return Ok(Method::GradientDescent(descent)) };
    let table = table.get_ref();
    if let Some(optimiser) = table.optimiser {
        descent.optimizer = match optimiser {
            OptimiserToml::Adam => Optimizer::Adam,
            OptimiserToml::Plain => Optimizer::Plain,
        };
    }
    if let Some(rate) = context.number(table.rate.as_ref(), 1.0, Allowed::Positive, "estimate.descent, rate")? {
        descent.rate = rate;
    }
    if let Some(steps) = context.whole(table.steps.as_ref(), MOST_STEPS, "estimate.descent, steps")? {
        descent.steps = steps;
    }
    if let Some(contacts) = context.whole(table.contacts.as_ref(), MOST_STEPS, "estimate.descent, contacts")? {
        descent.contacts = contacts;
    }
    Ok(Method::GradientDescent(descent))
}

/// Standard deviations of the priors, in SI units.
struct Priors {
    strain: Option<f64>,
    segment_strain: Option<f64>,
    offset_angle: Option<f64>,
    offset_length: Option<f64>,
    origin_length: Option<f64>,
    origin_angle: Option<f64>,
    compliance: Option<f64>,
    backlash_angle: Option<f64>,
    backlash_length: Option<f64>,
    harmonic: Option<f64>,
    harmonic_2: Option<f64>,
    gear_ratio: Option<f64>,
}

impl Priors {
    fn of(prior: &PriorToml, context: &Context<'_>) -> Result<Priors, IoError> {
        let sigma = |number: &Option<Number>, unit, key: &str| {
            context.number(number.as_ref(), unit, Allowed::Positive, &format!("estimate.prior, {key}"))
        };
        Ok(Priors {
            strain: sigma(&prior.strain, 1.0, "strain")?,
            segment_strain: sigma(&prior.segment_strain, 1.0, "segment_strain")?,
            offset_angle: sigma(&prior.joint_offset_deg, DEG, "joint_offset_deg")?,
            offset_length: sigma(&prior.joint_offset_mm, MM, "joint_offset_mm")?,
            origin_length: sigma(&prior.joint_origin_mm, MM, "joint_origin_mm")?,
            origin_angle: sigma(&prior.joint_origin_deg, DEG, "joint_origin_deg")?,
            compliance: sigma(&prior.joint_compliance_rad_per_nm, 1.0, "joint_compliance_rad_per_nm")?,
            backlash_angle: sigma(&prior.joint_backlash_deg, DEG, "joint_backlash_deg")?,
            backlash_length: sigma(&prior.joint_backlash_mm, MM, "joint_backlash_mm")?,
            harmonic: sigma(&prior.joint_harmonic_deg, DEG, "joint_harmonic_deg")?,
            harmonic_2: sigma(&prior.joint_harmonic_2_deg, DEG, "joint_harmonic_2_deg")?,
            gear_ratio: sigma(&prior.joint_gear_ratio, 1.0, "joint_gear_ratio")?,
        })
    }

    fn on(&self, parameter: Parameter) -> Parameter {
        let sigma = match (parameter.id.block(), parameter.unit) {
            (Block::Strain, _) => self.strain,
            (Block::SegmentStrain, _) => self.segment_strain,
            (Block::JointOffset, Unit::Meter) => self.offset_length,
            (Block::JointOffset, _) => self.offset_angle,
            (Block::JointOrigin, Unit::Meter) => self.origin_length,
            (Block::JointOrigin, _) => self.origin_angle,
            (Block::JointCompliance, _) => self.compliance,
            (Block::JointBacklash, Unit::Meter) => self.backlash_length,
            (Block::JointBacklash, _) => self.backlash_angle,
            (Block::JointHarmonic, _) => self.harmonic,
            (Block::JointHarmonic2, _) => self.harmonic_2,
            (Block::JointGearRatio, _) => self.gear_ratio,
            _ => None,
        };
        match sigma {
            Some(sigma) => parameter.with_sigma(sigma),
            None => parameter,
        }
    }
}

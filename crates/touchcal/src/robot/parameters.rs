//! What may be wrong with an arm: the parameters, their names, units and priors.

use super::chain::{JointKind, Robot};
use super::segments::segments;

/// The unit of a parameter, always SI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Metres.
    Meter,
    /// Radians.
    Radian,
    /// Radians per newton metre.
    RadianPerNewtonMeter,
    /// A ratio.
    One,
}

impl Unit {
    /// The unit as written in files: `m`, `rad`, `rad/(N m)`, `1`.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Meter => "m",
            Unit::Radian => "rad",
            Unit::RadianPerNewtonMeter => "rad/(N m)",
            Unit::One => "1",
        }
    }
}

/// What a parameter changes; also the column of a Jacobian that belongs to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// `r`, common to all joint origins: `l = (1 + r)·l₀`.
    Strain,
    /// Strain of segment `k` of [`segments`].
    SegmentStrain(usize),
    /// Encoder bias of moving joint `i`: true position = measured − offset.
    JointOffset(usize),
    /// Passing bias of moving joint `i` in placement `p`, on top of its offset: a nuisance that is not part of the calibrated arm.
    JointDrift(usize, usize),
    /// Component `k` of the local twist on moving joint `i`'s origin: `origin · Exp(ξ)`.
    JointOrigin(usize, usize),
    /// Compliance of moving joint `i`, on top of what the arm declares: true angle = measured − offset + compliance · torque of gravity and load.
    JointCompliance(usize),
    /// Component `k` of the local twist on the tool's pose on the tip.
    Tool(usize),
    /// Component `k` of the local twist on fixture `f`'s pose in base.
    Fixture(usize, usize),
    /// How far from touching contacts with fixture `f` seem to be: the mean of the measured gap at contact, negative where they penetrate.
    Interference(usize),
    /// How much farther than that contacts with fixture `f` seem to be from walls that push in direction `k` of it: +x, −x, +y, −y, +z, −z.
    Wall(usize, usize),
}

/// A named group of parameters, as chosen in a problem file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Block {
    /// One common strain.
    Strain,
    /// A strain per segment.
    SegmentStrain,
    /// An encoder bias per joint.
    JointOffset,
    /// A bias per joint that changes from placement to placement, a nuisance.
    JointDrift,
    /// Six numbers per joint origin.
    JointOrigin,
    /// A compliance per turning joint.
    JointCompliance,
    /// Where the tool sits on the tip.
    Tool,
    /// Where a fixture stands in base.
    Fixture,
    /// Mean gap at contact, a nuisance.
    Interference,
}

impl Block {
    /// Name in files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Block::Strain => "strain",
            Block::SegmentStrain => "segment_strain",
            Block::JointOffset => "joint_offset",
            Block::JointDrift => "joint_drift",
            Block::JointOrigin => "joint_origin",
            Block::JointCompliance => "joint_compliance",
            Block::Tool => "tool",
            Block::Fixture => "fixture",
            Block::Interference => "interference",
        }
    }
}

impl Block {
    /// Whether the block is no part of the arm: tool, fixtures, and what passes.
    pub fn is_nuisance(self) -> bool {
        matches!(self, Block::Tool | Block::Fixture | Block::Interference | Block::JointDrift)
    }
}

impl Column {
    /// The block this column belongs to.
    pub fn block(self) -> Block {
        match self {
            Column::Strain => Block::Strain,
            Column::SegmentStrain(_) => Block::SegmentStrain,
            Column::JointOffset(_) => Block::JointOffset,
            Column::JointDrift(..) => Block::JointDrift,
            Column::JointOrigin(..) => Block::JointOrigin,
            Column::JointCompliance(_) => Block::JointCompliance,
            Column::Tool(_) => Block::Tool,
            Column::Fixture(..) => Block::Fixture,
            Column::Interference(_) | Column::Wall(..) => Block::Interference,
        }
    }
}

/// A prior whose standard deviation is learned: it starts at the parameter's `prior_sigma`, which counts as much as `strength`
/// observed values of that size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learned {
    /// Parameters of one group share their standard deviation.
    pub group: &'static str,
    /// Weight of the start, in number of values.
    pub strength: f64,
}

/// One number to estimate. It starts at zero, which is also the mean of its prior.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Unique name: `strain`, `joint_offset.joint_a1`, `joint_origin.joint_a1.rx`, `fixture.hole.z`.
    pub name: String,
    /// What it changes.
    pub column: Column,
    /// Its unit.
    pub unit: Unit,
    /// Standard deviation of its Gaussian prior; none: the data alone decide.
    pub prior_sigma: Option<f64>,
    /// Whether the standard deviation of the prior is itself learned from the data, together with the others of its group.
    pub learned: Option<Learned>,
    /// Size of a large but plausible value, in its unit: makes parameters of different units comparable.
    pub scale: f64,
}

/// Names of the components of a twist.
pub const TWIST_NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Names of the directions in which walls push.
const WALL_NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// Plausible sizes: 5 % strain, 5° of angle, 10 mm of length, a joint of 1e3 N m/rad.
const STRAIN_SCALE: f64 = 0.05;
pub(crate) const ANGLE_SCALE: f64 = 5.0 * std::f64::consts::PI / 180.0;
pub(crate) const LENGTH_SCALE: f64 = 0.01;
const COMPLIANCE_SCALE: f64 = 1e-3;

/// Priors of the full geometric model, see [`joint_origin`].
const ORIGIN_LENGTH_PRIOR: f64 = 0.5e-3;
const ORIGIN_ANGLE_PRIOR: f64 = 0.1 * std::f64::consts::PI / 180.0;
const ORIGIN_ZERO_PRIOR: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// Start of the learned prior of drifts.
const DRIFT_PRIOR: f64 = 0.05 * std::f64::consts::PI / 180.0;
/// Start of the learned prior of compliances: harmonic drives of an arm's size have about 1e4 N m/rad.
const COMPLIANCE_PRIOR: f64 = 1e-4;
/// Arms differ in stiffness by orders of magnitude, so that start counts little: a stiff arm's compliances must go to zero.
const COMPLIANCE_STRENGTH: f64 = 0.01;
/// A learned prior's start counts as one observed value.
const LEARNED_STRENGTH: f64 = 1.0;

impl Parameter {
    /// Component `k` of a twist, named `{prefix}.{x|y|z|rx|ry|rz}`.
    pub fn twist(prefix: &str, column: Column, k: usize) -> Self {
        let (unit, scale) = if k < 3 { (Unit::Meter, LENGTH_SCALE) } else { (Unit::Radian, ANGLE_SCALE) };
        let name = format!("{prefix}.{}", TWIST_NAMES[k.min(5)]);
        Parameter { name, column, unit, prior_sigma: None, learned: None, scale }
    }

    /// Mean gap (m) of contacts with fixture number `fixture`.
    pub fn interference(name: &str, fixture: usize) -> Self {
        let column = Column::Interference(fixture);
        Parameter {
            name: format!("interference.{name}"),
            column,
            unit: Unit::Meter,
            prior_sigma: None,
            learned: None,
            scale: LENGTH_SCALE,
        }
    }

    /// How much farther (m) the walls in direction `k` of fixture number `fixture` seem to be.
    pub fn wall(name: &str, fixture: usize, k: usize) -> Self {
        let column = Column::Wall(fixture, k);
        let name = format!("{name}.{}", WALL_NAMES[k.min(5)]);
        Parameter { column, ..Parameter::interference(&name, fixture) }
    }

    /// The parameter in words, for people: "offset of joint_a1", "hole's yaw".
    pub fn words(&self) -> String {
        const DIRECTIONS: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
        let rest = self.name.split_once('.').map_or(self.name.as_str(), |(_, rest)| rest);
        let owner = rest.rsplit_once('.').map_or(rest, |(owner, _)| owner);
        match self.column {
            Column::Strain => "the common strain".to_owned(),
            Column::SegmentStrain(_) => format!("the strain of segment {rest}"),
            Column::JointOffset(_) => format!("the offset of {rest}"),
            Column::JointDrift(..) => format!("the drift of {rest}"),
            Column::JointOrigin(_, k) => format!("the origin {} of {owner}", DIRECTIONS[k.min(5)]),
            Column::JointCompliance(_) => format!("the compliance of {rest}"),
            Column::Tool(k) => format!("the tool's {}", DIRECTIONS[k.min(5)]),
            Column::Fixture(_, k) => format!("the {} of fixture {owner}", DIRECTIONS[k.min(5)]),
            Column::Interference(_) => format!("the interference of fixture {rest}"),
            Column::Wall(_, k) => format!("the interference of fixture {owner} towards {}", WALL_NAMES[k.min(5)]),
        }
    }

    /// The same parameter with a Gaussian prior of this standard deviation about zero.
    pub fn with_prior(mut self, sigma: f64) -> Self {
        self.prior_sigma = Some(sigma);
        self.learned = None;
        self
    }

    /// The same parameter with a Gaussian prior whose standard deviation is learned, starting from `sigma`.
    pub fn with_learned_prior(mut self, sigma: f64, group: &'static str) -> Self {
        self.prior_sigma = Some(sigma);
        self.learned = Some(Learned { group, strength: LEARNED_STRENGTH });
        self
    }
}

/// The one common strain.
pub fn strain() -> Parameter {
    Parameter {
        name: "strain".to_owned(),
        column: Column::Strain,
        unit: Unit::One,
        prior_sigma: None,
        learned: None,
        scale: STRAIN_SCALE,
    }
}

/// A strain for each segment.
pub fn segment_strain(robot: &Robot) -> Vec<Parameter> {
    let each = segments(robot).into_iter().enumerate();
    each.map(|(k, segment)| Parameter {
        name: format!("segment_strain.{}", segment.name),
        column: Column::SegmentStrain(k),
        unit: Unit::One,
        prior_sigma: None,
        learned: None,
        scale: STRAIN_SCALE,
    })
    .collect()
}

/// An encoder bias for each moving joint.
pub fn joint_offset(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate();
    each.map(|(i, joint)| {
        let (unit, scale) = match joint.kind {
            JointKind::Prismatic => (Unit::Meter, LENGTH_SCALE),
            _ => (Unit::Radian, ANGLE_SCALE),
        };
        let name = format!("joint_offset.{}", joint.name);
        Parameter { name, column: Column::JointOffset(i), unit, prior_sigma: None, learned: None, scale }
    })
    .collect()
}

/// A drift for each moving joint in placement number `placement`, with a learned prior.
pub fn joint_drift(robot: &Robot, placement: usize, placement_name: &str) -> Vec<Parameter> {
    let turning = robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic);
    let each = turning.map(|(i, joint)| {
        Parameter {
            name: format!("joint_drift.{}.{placement_name}", joint.name),
            column: Column::JointDrift(placement, i),
            unit: Unit::Radian,
            prior_sigma: None,
            learned: None,
            scale: ANGLE_SCALE,
        }
        .with_learned_prior(DRIFT_PRIOR, "joint_drift")
    });
    each.collect()
}

/// Six numbers for each moving joint's origin: the full geometric model.
///
/// Their priors say what arms are like: links are made to about half a millimetre and a tenth of a degree, while the zero of
/// an encoder, the rotation about the joint's own axis, is off by about half a degree, how much being learned from the data. Without priors about half of
/// the directions would be undetermined: neighbouring origins can trade places.
pub fn joint_origin(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate();
    each.flat_map(|(i, joint)| {
        let prefix = format!("joint_origin.{}", joint.name);
        let along = |k: usize| if joint.kind == JointKind::Prismatic { 0.0 } else { joint.axis[k % 3].abs() };
        (0..6).map(move |k| {
            let parameter = Parameter::twist(&prefix, Column::JointOrigin(i, k), k);
            match k {
                0..3 => parameter.with_prior(ORIGIN_LENGTH_PRIOR),
                _ if along(k) > 0.5 => parameter.with_learned_prior(ORIGIN_ZERO_PRIOR, "joint_origin about the axis"),
                _ => parameter.with_prior(ORIGIN_ANGLE_PRIOR),
            }
        })
    })
    .collect()
}

/// A compliance for each turning joint, with a learned prior: gravity, and what presses on the tool, bend the arm beyond the encoders, which sit on the motors' side.
///
/// The true angle is `q − b + c τ(q)`, with `c` in rad/(N m) and `τ` the torque (N m) about the joint's axis of gravity on all that it carries, and of the contact's
/// [load](crate::contact::ContactLog::load) where that is known.
/// Masses are those of the links' [`Inertia`](super::Inertia)s if every moving joint carries one before the next; links beside the chain do
/// not count. Otherwise a kilogram in the middle of each moving link, between its joint's origin and the next, and one at the tip stand
/// in for them: then `c` carries the arm's unknown mass and is a compliance only together with these masses, not with a load.
pub fn joint_compliance(robot: &Robot) -> Vec<Parameter> {
    let turning = robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic);
    let each = turning.map(|(i, joint)| Parameter {
        name: format!("joint_compliance.{}", joint.name),
        column: Column::JointCompliance(i),
        unit: Unit::RadianPerNewtonMeter,
        prior_sigma: Some(COMPLIANCE_PRIOR),
        learned: Some(Learned { group: "joint_compliance", strength: COMPLIANCE_STRENGTH }),
        scale: COMPLIANCE_SCALE,
    });
    each.collect()
}

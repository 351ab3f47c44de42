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
    /// A ratio.
    One,
}

impl Unit {
    /// The unit as written in files: `m`, `rad`, `1`.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Meter => "m",
            Unit::Radian => "rad",
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
    /// Component `k` of the local twist on moving joint `i`'s origin: `origin · Exp(ξ)`.
    JointOrigin(usize, usize),
    /// Component `k` of the local twist on the tool's pose on the tip.
    Tool(usize),
    /// Component `k` of the local twist on fixture `f`'s pose in base.
    Fixture(usize, usize),
    /// How far contacts with fixture `f` seem to penetrate: the mean of the measured gap at contact.
    Interference(usize),
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
    /// Six numbers per joint origin.
    JointOrigin,
    /// Where the tool sits on the tip.
    Tool,
    /// Where a fixture stands in base.
    Fixture,
    /// Mean penetration at contact, a nuisance.
    Interference,
}

impl Block {
    /// Name in files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Block::Strain => "strain",
            Block::SegmentStrain => "segment_strain",
            Block::JointOffset => "joint_offset",
            Block::JointOrigin => "joint_origin",
            Block::Tool => "tool",
            Block::Fixture => "fixture",
            Block::Interference => "interference",
        }
    }
}

impl Column {
    /// The block this column belongs to.
    pub fn block(self) -> Block {
        match self {
            Column::Strain => Block::Strain,
            Column::SegmentStrain(_) => Block::SegmentStrain,
            Column::JointOffset(_) => Block::JointOffset,
            Column::JointOrigin(..) => Block::JointOrigin,
            Column::Tool(_) => Block::Tool,
            Column::Fixture(..) => Block::Fixture,
            Column::Interference(_) => Block::Interference,
        }
    }
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
    /// Size of a large but plausible value, in its unit: makes parameters of different units comparable.
    pub scale: f64,
}

/// Names of the components of a twist.
pub const TWIST_NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Plausible sizes: 5 % strain, 5° of angle, 10 mm of length.
const STRAIN_SCALE: f64 = 0.05;
pub(crate) const ANGLE_SCALE: f64 = 5.0 * std::f64::consts::PI / 180.0;
pub(crate) const LENGTH_SCALE: f64 = 0.01;

impl Parameter {
    /// Component `k` of a twist, named `{prefix}.{x|y|z|rx|ry|rz}`.
    pub fn twist(prefix: &str, column: Column, k: usize) -> Self {
        let (unit, scale) = if k < 3 {
            (Unit::Meter, LENGTH_SCALE)
        } else {
            (Unit::Radian, ANGLE_SCALE)
        };
        let name = format!("{prefix}.{}", TWIST_NAMES[k.min(5)]);
        Parameter {
            name,
            column,
            unit,
            prior_sigma: None,
            scale,
        }
    }

    /// Mean penetration (m) of contacts with fixture number `fixture`.
    pub fn interference(name: &str, fixture: usize) -> Self {
        let column = Column::Interference(fixture);
        Parameter {
            name: format!("interference.{name}"),
            column,
            unit: Unit::Meter,
            prior_sigma: None,
            scale: LENGTH_SCALE,
        }
    }

    /// The parameter in words, for people: "offset of joint_a1", "hole's yaw".
    pub fn words(&self) -> String {
        const DIRECTIONS: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
        let rest = self
            .name
            .split_once('.')
            .map_or(self.name.as_str(), |(_, rest)| rest);
        let owner = rest.rsplit_once('.').map_or(rest, |(owner, _)| owner);
        match self.column {
            Column::Strain => "the common strain".to_owned(),
            Column::SegmentStrain(_) => format!("the strain of segment {rest}"),
            Column::JointOffset(_) => format!("the offset of {rest}"),
            Column::JointOrigin(_, k) => format!("the origin {} of {owner}", DIRECTIONS[k.min(5)]),
            Column::Tool(k) => format!("the tool's {}", DIRECTIONS[k.min(5)]),
            Column::Fixture(_, k) => format!("the {} of fixture {owner}", DIRECTIONS[k.min(5)]),
            Column::Interference(_) => format!("the interference of fixture {rest}"),
        }
    }

    /// The same parameter with a Gaussian prior of this standard deviation about zero.
    pub fn with_prior(mut self, sigma: f64) -> Self {
        self.prior_sigma = Some(sigma);
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
        Parameter {
            name,
            column: Column::JointOffset(i),
            unit,
            prior_sigma: None,
            scale,
        }
    })
    .collect()
}

/// Six numbers for each moving joint's origin: the full geometric model.
pub fn joint_origin(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate();
    each.flat_map(|(i, joint)| {
        let prefix = format!("joint_origin.{}", joint.name);
        (0..6).map(move |k| Parameter::twist(&prefix, Column::JointOrigin(i, k), k))
    })
    .collect()
}

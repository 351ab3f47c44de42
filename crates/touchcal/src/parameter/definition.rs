//! One number to estimate, with its name, unit and prior.

use super::parameter_id::{DIRECTION_NAMES, ParameterId, TWIST_NAMES};
use crate::robot::KinematicParameter;

/// Plausible sizes of lengths (m) and angles (rad): 10 mm and 5°.
pub(super) const LENGTH_SCALE: f64 = 0.01;
pub(super) const ANGLE_SCALE: f64 = 5.0 * std::f64::consts::PI / 180.0;

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

/// Prior of a parameter about zero; standard deviations in the parameter's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// None: the data alone decide.
    Flat,
    /// Gaussian of known standard deviation.
    Gaussian {
        /// Standard deviation.
        sigma: f64,
    },
    /// Gaussian whose standard deviation is a variance component: estimated from the data, common
    /// to the parameters of one group.
    VarianceComponent {
        /// Present standard deviation; before the estimation, its start.
        sigma: f64,
        /// Name of the group.
        group: &'static str,
        /// Number of observed values of size `sigma` that the start counts as.
        strength: f64,
    },
}

impl Prior {
    /// Standard deviation; none for a flat prior.
    pub fn sigma(self) -> Option<f64> {
        match self {
            Prior::Flat => None,
            Prior::Gaussian { sigma } | Prior::VarianceComponent { sigma, .. } => Some(sigma),
        }
    }

    /// The same kind of prior with another standard deviation; a flat one stays flat.
    pub fn with_sigma(self, sigma: f64) -> Prior {
        match self {
            Prior::Flat => Prior::Flat,
            Prior::Gaussian { .. } => Prior::Gaussian { sigma },
            Prior::VarianceComponent { group, strength, .. } => Prior::VarianceComponent { sigma, group, strength },
        }
    }
}

/// One number to estimate. It starts at zero, which is also the mean of its prior.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Unique name: `strain`, `joint_offset.joint_a1`, `joint_origin.joint_a1.rx`,
    /// `fixture.hole.z`.
    pub name: String,
    /// What it changes.
    pub id: ParameterId,
    /// Its unit.
    pub unit: Unit,
    /// Its prior.
    pub prior: Prior,
    /// Size of a large but plausible value, in its unit: makes parameters of different units
    /// comparable.
    pub scale: f64,
}

impl Parameter {
    /// A length (m) without prior.
    pub(super) fn length(name: String, id: ParameterId) -> Self {
        Parameter { name, id, unit: Unit::Meter, prior: Prior::Flat, scale: LENGTH_SCALE }
    }

    /// An angle (rad) without prior.
    pub(super) fn angle(name: String, id: ParameterId) -> Self {
        Parameter { name, id, unit: Unit::Radian, prior: Prior::Flat, scale: ANGLE_SCALE }
    }

    /// Component `k` of a twist `[v; ω]` (m, rad), named `{prefix}.{x|y|z|rx|ry|rz}`, without
    /// prior.
    pub fn twist(prefix: &str, id: ParameterId, k: usize) -> Self {
        let name = format!("{prefix}.{}", TWIST_NAMES[k.min(5)]);
        if k < 3 { Parameter::length(name, id) } else { Parameter::angle(name, id) }
    }

    /// The same parameter with another prior.
    pub fn with_prior(self, prior: Prior) -> Self {
        Parameter { prior, ..self }
    }

    /// The same parameter with a Gaussian prior of this standard deviation, in its unit.
    pub fn with_sigma(self, sigma: f64) -> Self {
        self.with_prior(Prior::Gaussian { sigma })
    }

    /// Standard deviation of the prior, in its unit; none for a flat one.
    pub fn prior_sigma(&self) -> Option<f64> {
        self.prior.sigma()
    }

    /// The parameter in words: "the offset of joint_a1", "the yaw of fixture hole".
    pub fn description(&self) -> String {
        const COMPONENTS: [&str; 6] = ["x", "y", "z", "roll", "pitch", "yaw"];
        let rest = self.name.split_once('.').map_or(self.name.as_str(), |(_, rest)| rest);
        let owner = rest.rsplit_once('.').map_or(rest, |(owner, _)| owner);
        match self.id {
            ParameterId::Kinematic(parameter) => match parameter {
                KinematicParameter::Strain => "the common strain".to_owned(),
                KinematicParameter::SegmentStrain(_) => format!("the strain of segment {rest}"),
                KinematicParameter::JointOffset(_) => format!("the offset of {rest}"),
                KinematicParameter::JointOrigin(_, k) => format!("the origin {} of {owner}", COMPONENTS[k.min(5)]),
                KinematicParameter::JointCompliance(_) => format!("the compliance of {rest}"),
                KinematicParameter::Tool(k) => format!("the tool's {}", COMPONENTS[k.min(5)]),
            },
            ParameterId::JointDrift(..) => format!("the drift of {rest}"),
            ParameterId::Fixture(_, k) => format!("the {} of fixture {owner}", COMPONENTS[k.min(5)]),
            ParameterId::GapBias(_) => format!("the gap bias of fixture {rest}"),
            ParameterId::DirectionalGapBias(_, k) => {
                format!("the gap bias of fixture {owner} towards {}", DIRECTION_NAMES[k.min(5)])
            }
        }
    }
}

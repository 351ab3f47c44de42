//! One number to estimate, with its name, unit and prior.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize};

use super::parameter_id::{DIRECTION_NAMES, ParameterId, TWIST_NAMES};
use crate::robot::{EncoderTerm, KinematicParameter};

/// Plausible sizes of lengths (m) and angles (rad): 10 mm and 5°.
pub(super) const LENGTH_SCALE: f64 = 0.01;
pub(super) const ANGLE_SCALE: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// The unit of a parameter, always SI.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// Metres (m).
    Meter,
    /// Radians (rad).
    Radian,
    /// Radians per newton metre (rad/(N m)).
    RadianPerNewtonMeter,
    /// A dimensionless ratio (1).
    One,
    /// Newtons (N).
    Newton,
    /// Newton metres (N m).
    NewtonMeter,
}

impl Unit {
    /// All units.
    pub const ALL: [Unit; 6] =
        [Unit::Meter, Unit::Radian, Unit::RadianPerNewtonMeter, Unit::One, Unit::Newton, Unit::NewtonMeter];

    /// The unit with this [`symbol`](Unit::symbol).
    pub fn from_symbol(symbol: &str) -> Option<Unit> {
        Unit::ALL.into_iter().find(|unit| unit.symbol() == symbol)
    }

    /// Symbol of the unit in files: `m`, `rad`, `rad/(N m)`, `1`, `N`, `N m`.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Meter => "m",
            Unit::Radian => "rad",
            Unit::RadianPerNewtonMeter => "rad/(N m)",
            Unit::One => "1",
            Unit::Newton => "N",
            Unit::NewtonMeter => "N m",
        }
    }

    /// How values are shown to people: the factor from SI, its symbol, and decimals of a value.
    pub fn in_user_units(self) -> (f64, &'static str, usize) {
        match self {
            Unit::Meter => (1e3, "mm", 4),
            Unit::Radian => (1f64.to_degrees(), "deg", 4),
            Unit::RadianPerNewtonMeter => (1e6, "µrad/(N m)", 2),
            Unit::One => (1.0, "ratio", 6),
            Unit::Newton => (1.0, "N", 4),
            Unit::NewtonMeter => (1.0, "N m", 5),
        }
    }
}

/// Name of a group of parameters whose priors share one standard deviation. An alias, since serde
/// would borrow a `&str`.
pub type GroupName = &'static str;

/// The groups of this crate's parameters, which can be deserialized.
const GROUPS: [GroupName; 5] =
    ["joint_drift", "joint_trend", "joint_trend (m)", "joint_origin about the axis", "joint_compliance"];
pub(super) const DRIFT_GROUP: GroupName = GROUPS[0];
pub(super) const TREND_ANGLE_GROUP: GroupName = GROUPS[1];
pub(super) const TREND_LENGTH_GROUP: GroupName = GROUPS[2];
pub(super) const ORIGIN_ZERO_GROUP: GroupName = GROUPS[3];
pub(super) const COMPLIANCE_GROUP: GroupName = GROUPS[4];

/// The group of that name.
fn known_group<'de, D: Deserializer<'de>>(deserializer: D) -> Result<GroupName, D::Error> {
    let name = String::deserialize(deserializer)?;
    let found = GROUPS.into_iter().find(|group| *group == name);
    found.ok_or_else(|| D::Error::custom(format!("no group of priors is named {name:?}")))
}

/// Prior of a parameter, with mean zero; standard deviations are in the parameter's unit (SI).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Prior {
    /// No prior: the data alone determine the parameter.
    Flat,
    /// Gaussian of known standard deviation.
    Gaussian {
        /// Standard deviation, in the parameter's unit (> 0).
        sigma: f64,
    },
    /// Gaussian whose standard deviation is a variance component: estimated from the data, common
    /// to all parameters of one group.
    VarianceComponent {
        /// Standard deviation, in the parameter's unit (> 0): in a problem the initial one, in an
        /// estimate the estimated one.
        sigma: f64,
        /// Name of the group: parameters with the same name share one standard deviation.
        #[serde(deserialize_with = "known_group")]
        group: GroupName,
        /// Weight of the initial `sigma` in the estimate, as a number of observed values of that
        /// size (1, > 0).
        strength: f64,
    },
}

impl Prior {
    /// Standard deviation in the parameter's unit; `None` for a flat prior.
    pub fn sigma(self) -> Option<f64> {
        match self {
            Prior::Flat => None,
            Prior::Gaussian { sigma } | Prior::VarianceComponent { sigma, .. } => Some(sigma),
        }
    }

    /// The same kind of prior with standard deviation `sigma` (> 0, in the parameter's unit); a
    /// flat one stays flat.
    pub fn with_sigma(self, sigma: f64) -> Prior {
        match self {
            Prior::Flat => Prior::Flat,
            Prior::Gaussian { .. } => Prior::Gaussian { sigma },
            Prior::VarianceComponent { group, strength, .. } => Prior::VarianceComponent { sigma, group, strength },
        }
    }
}

/// One number to estimate. The estimation starts at zero, the nominal value, which is also the mean
/// of its prior.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Unique name: `strain`, `joint_offset.joint_a1`, `joint_origin.joint_a1.rx`,
    /// `fixture.hole.z`.
    pub name: String,
    /// The quantity of arm, tool, fixture or contacts that the parameter changes.
    pub id: ParameterId,
    /// Unit of the parameter's value, prior and scale.
    pub unit: Unit,
    /// Prior, with mean zero.
    pub prior: Prior,
    /// Size of a large but plausible value, in the parameter's unit (> 0): the size by which
    /// parameters of different units are compared where there is no prior.
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

    /// Component `k` (0 to 5; larger counts as 5) of a twist `[v; ω]`, named
    /// `{prefix}.{x|y|z|rx|ry|rz}`, without prior: a length (m) for `k` below 3, else an angle
    /// (rad). `id` is taken as it is.
    pub fn twist(prefix: &str, id: ParameterId, k: usize) -> Self {
        let name = format!("{prefix}.{}", TWIST_NAMES[k.min(5)]);
        if k < 3 { Parameter::length(name, id) } else { Parameter::angle(name, id) }
    }

    /// The same parameter with another prior.
    pub fn with_prior(self, prior: Prior) -> Self {
        Parameter { prior, ..self }
    }

    /// The same parameter with a Gaussian prior of standard deviation `sigma` (> 0, in its unit).
    pub fn with_sigma(self, sigma: f64) -> Self {
        self.with_prior(Prior::Gaussian { sigma })
    }

    /// Standard deviation of the prior, in the parameter's unit; `None` for a flat one.
    pub fn prior_sigma(&self) -> Option<f64> {
        self.prior.sigma()
    }

    /// The parameter in English words for messages, for example "the encoder offset of joint_a1" or
    /// "the rz of fixture hole". Joint and fixture are taken from the name, the rest from the id.
    pub fn description(&self) -> String {
        let rest = self.name.split_once('.').map_or(self.name.as_str(), |(_, rest)| rest);
        let owner = rest.rsplit_once('.').map_or(rest, |(owner, _)| owner);
        match self.id {
            ParameterId::Kinematic(parameter) => match parameter {
                KinematicParameter::Strain => "the link strain".to_owned(),
                KinematicParameter::SegmentStrain(_) => format!("the link strain of segment {rest}"),
                KinematicParameter::JointOffset(_) => format!("the encoder offset of {rest}"),
                KinematicParameter::JointOrigin(_, k) => format!("the origin {} of {owner}", TWIST_NAMES[k.min(5)]),
                KinematicParameter::JointCompliance(_) => format!("the compliance of {rest}"),
                KinematicParameter::JointBacklash(_) => format!("the backlash of {rest}"),
                KinematicParameter::Tool(k) => format!("the tool's {}", TWIST_NAMES[k.min(5)]),
            },
            ParameterId::JointDrift(..) => format!("the encoder drift of {rest}"),
            ParameterId::JointTrend(_) => format!("the encoder trend of {rest}"),
            ParameterId::JointWalk(..) => format!("the encoder walk of {owner}"),
            ParameterId::EncoderError(_, term) => match term {
                EncoderTerm::Sine | EncoderTerm::Cosine => format!("the encoder harmonic of {owner}"),
                EncoderTerm::SecondSine | EncoderTerm::SecondCosine => {
                    format!("the second encoder harmonic of {owner}")
                }
                EncoderTerm::GearRatio => format!("the gear ratio of {rest}"),
            },
            ParameterId::Fixture(_, k) => format!("the {} of fixture {owner}", TWIST_NAMES[k.min(5)]),
            ParameterId::GapBias(_) => format!("the gap bias of fixture {rest}"),
            ParameterId::DirectionalGapBias(_, k) => {
                format!("the gap bias of fixture {owner} towards {}", DIRECTION_NAMES[k.min(5)])
            }
            ParameterId::EdgeRadius(_) => format!("the radius of the edges of fixture {rest}"),
            ParameterId::WrenchBias(_) => format!("the bias of the wrench's {rest}"),
            ParameterId::WrenchScale => "the scale of the wrench".to_owned(),
            ParameterId::Distance(_) => format!("the distance {rest}"),
        }
    }
}

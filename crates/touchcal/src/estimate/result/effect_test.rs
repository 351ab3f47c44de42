//! Tests of effects that a model leaves out.

use serde::{Deserialize, Serialize};

use crate::parameter::Unit;
use crate::statistics::p_value_statement;

/// Share of the largest standard deviation in a unit up to which a parameter is not seen.
const LEAST_SEEN: f64 = 1e-4;

/// An effect that a model leaves out: fixed at what was declared, or not a parameter.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum OmittedEffect {
    /// Joints deflect under gravity and load.
    JointCompliance,
    /// Links are strained each by another amount.
    SegmentStrain,
    /// Joint origins are displaced and rotated.
    JointOrigin,
    /// Encoders have an error of once a turn.
    JointHarmonic,
    /// Encoder offsets change over the log.
    JointTrend,
    /// Encoder offsets change otherwise than linearly over the log.
    JointWalk,
    /// The tool is not at its exactly declared place.
    ToolPlace,
    /// A fixture is not at its exactly declared place.
    FixturePlace {
        /// Name of the fixture.
        fixture: String,
    },
    /// The measured wrench, declared exact, has a bias or another scale.
    Wrench,
    /// Outline, clearance or depth of a fixture, declared exact, are not as declared; no score
    /// test, see [`FreedEffect`].
    Shape {
        /// Name of the fixture.
        fixture: String,
    },
    /// Edges of the tool and a fixture, declared exact, are rounder or sharper than declared.
    EdgeRadius {
        /// Name of the fixture.
        fixture: String,
    },
    /// A distance between two fixtures that is declared exact, or nearly, is not so.
    Distance {
        /// Names of the fixtures.
        between: [String; 2],
    },
    /// Contacts scatter more than declared; no score test, see [`FreedEffect`].
    Noise,
}

impl OmittedEffect {
    /// Name in files: `joint_compliance`, `segment_strain`, `joint_origin`, `joint_harmonic`,
    /// `joint_trend`, `joint_walk`, `tool`, `fixture.{name}`, `wrench`, `gap_bias.{fixture}`,
    /// `edge_radius.{fixture}`, `distance.{a}.{b}`, `noise`.
    pub fn name(&self) -> String {
        match self {
            OmittedEffect::JointCompliance => "joint_compliance".to_owned(),
            OmittedEffect::SegmentStrain => "segment_strain".to_owned(),
            OmittedEffect::JointOrigin => "joint_origin".to_owned(),
            OmittedEffect::JointHarmonic => "joint_harmonic".to_owned(),
            OmittedEffect::JointTrend => "joint_trend".to_owned(),
            OmittedEffect::JointWalk => "joint_walk".to_owned(),
            OmittedEffect::ToolPlace => "tool".to_owned(),
            OmittedEffect::FixturePlace { fixture } => format!("fixture.{fixture}"),
            OmittedEffect::Wrench => "wrench".to_owned(),
            OmittedEffect::Shape { fixture } => format!("gap_bias.{fixture}"),
            OmittedEffect::EdgeRadius { fixture } => format!("edge_radius.{fixture}"),
            OmittedEffect::Distance { between: [a, b] } => format!("distance.{a}.{b}"),
            OmittedEffect::Noise => "noise".to_owned(),
        }
    }

    /// The effect in English words for messages, such as "the joints deflect under load".
    pub fn description(&self) -> String {
        match self {
            OmittedEffect::JointCompliance => "joints deflect under gravity and load".to_owned(),
            OmittedEffect::SegmentStrain => "links are strained differently".to_owned(),
            OmittedEffect::JointOrigin => "joint origins are displaced".to_owned(),
            OmittedEffect::JointHarmonic => "encoders have an error of once a turn".to_owned(),
            OmittedEffect::JointTrend => "encoder offsets change over the log".to_owned(),
            OmittedEffect::JointWalk => "encoder offsets walk at random over the log".to_owned(),
            OmittedEffect::ToolPlace => "the tool is not where it is declared".to_owned(),
            OmittedEffect::FixturePlace { fixture } => format!("fixture `{fixture}` is not where it is declared"),
            OmittedEffect::Wrench => "the measured wrench has a bias or another scale".to_owned(),
            OmittedEffect::Shape { fixture } => format!("the shape of fixture `{fixture}` is not as declared"),
            OmittedEffect::EdgeRadius { fixture } => {
                format!("the edges of fixture `{fixture}` and the tool there are not as declared")
            }
            OmittedEffect::Distance { between: [a, b] } => {
                format!("the distance of fixtures `{a}` and `{b}` is not as declared")
            }
            OmittedEffect::Noise => "contacts scatter more than declared".to_owned(),
        }
    }

    /// Whether it is an error of the arm, so that intervals allow for what tests would miss of it.
    pub(crate) fn is_arm_error(&self) -> bool {
        use OmittedEffect::{JointCompliance, JointHarmonic, JointOrigin, JointWalk, SegmentStrain};
        matches!(self, JointCompliance | SegmentStrain | JointOrigin | JointHarmonic | JointWalk)
    }

    /// What contacts show, with the corrected `p_value` (0 to 1) that it is chance and how far (m)
    /// it moves the tool; without a full stop.
    pub(super) fn message(&self, p_value: f64, displacement: f64) -> String {
        let (what, millimetres) = (self.description(), 1e3 * displacement);
        let p = p_value_statement(p_value);
        format!("contacts show that {what} ({p}), which moves the tool by {millimetres:.3} mm")
    }

    /// What to change in the problem so that the effect is estimated, without a full stop.
    pub fn remedy(&self) -> &'static str {
        match self {
            OmittedEffect::JointCompliance => "estimate `joint_compliance`, with the wrench of the log if it has one",
            OmittedEffect::SegmentStrain => "estimate `segment_strain` instead of `strain`",
            OmittedEffect::JointOrigin => "estimate `joint_origin`",
            OmittedEffect::JointHarmonic => {
                "estimate `joint_harmonic`, so that it does not bias the others; a URDF cannot correct it"
            }
            OmittedEffect::JointTrend => {
                "declare `encoder_trend_deg` above 0, or record a shorter log with the arm at one temperature"
            }
            OmittedEffect::JointWalk => {
                "declare `encoder_walk_deg` above 0, or record a shorter log with the arm at one temperature"
            }
            OmittedEffect::ToolPlace => "measure the tool's place again, or give it a standard deviation",
            OmittedEffect::FixturePlace { .. } => "measure the fixture's place again, or give it a standard deviation",
            OmittedEffect::Shape { .. } => {
                "measure outline, clearance and depth again, or give them a standard deviation"
            }
            OmittedEffect::EdgeRadius { .. } => {
                "measure the radius of the edges of peg and hole, or give it a standard deviation"
            }
            OmittedEffect::Distance { .. } => {
                "measure the distances again, or declare how uncertain they are (sigma_mm in [[distance]])"
            }
            OmittedEffect::Noise => "declare a larger noise, or leave out `[noise]` so that it is estimated",
            OmittedEffect::Wrench => "give bias and scale of the wrench a standard deviation",
        }
    }

    /// Key and table of a problem file (`problem.toml`) that leave the effect out, such as
    /// `parameters in [estimate]`.
    pub fn declared_in(&self) -> String {
        match self {
            OmittedEffect::JointTrend => "encoder_trend_deg in [noise]".to_owned(),
            OmittedEffect::JointWalk => "encoder_walk_deg in [noise]".to_owned(),
            OmittedEffect::Wrench | OmittedEffect::Noise => "[noise]".to_owned(),
            OmittedEffect::ToolPlace => "tip_from_tool in [tool]".to_owned(),
            OmittedEffect::Distance { .. } => "mm in [[distance]]".to_owned(),
            OmittedEffect::FixturePlace { fixture } => format!("base_from_fixture in [[fixture]] {fixture}"),
            OmittedEffect::EdgeRadius { fixture } => {
                format!("edge_radius_mm in [tool] and [[fixture]] {fixture}")
            }
            OmittedEffect::Shape { fixture } => format!("outline, depth_mm in [[fixture]] {fixture}"),
            _ => "parameters in [estimate]".to_owned(),
        }
    }
}

/// An effect that was estimated in addition because contacts contradict that it is zero: by a score
/// test without it; where there is none, by the Wald test of a calibration with all effects of the
/// arm; of shapes declared exact by the gaps at contact, of noise by the scatter found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FreedEffect {
    /// The effect.
    pub effect: OmittedEffect,
    /// Corrected probability (0 to 1) that what contacts show of it is chance.
    pub p_value: f64,
    /// What the contacts' log-likelihood gains by the effect (1): to second order, half of the
    /// statistic of the test; of noise, with its new standard deviation.
    pub gain: f64,
    /// [`PredictiveCheck::ratio`](super::PredictiveCheck::ratio) (1) without the effect, with all
    /// others that are freed; `None` where there is none.
    pub predictive_ratio: Option<f64>,
}

/// The value that one parameter of an omitted effect would take.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectValue {
    /// Name of the parameter, as it would be named if it were estimated.
    pub name: String,
    /// Unit of value and standard deviation.
    pub unit: Unit,
    /// One-step estimate (SI).
    pub value: f64,
    /// Standard deviation of that estimate (SI); 0, but for rounding, where contacts do not see the
    /// parameter.
    pub sigma: f64,
}

/// A score test of the hypothesis that an effect which the model leaves out is zero.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectTest {
    /// The effect.
    pub effect: OmittedEffect,
    /// Score statistic (1): chi-squared distributed if the effect is zero.
    pub statistic: f64,
    /// Number of directions that the contacts see at a plausible size of the effect.
    pub degrees_of_freedom: usize,
    /// Probability (0 to 1) of a statistic as large by chance, times the number of effects left
    /// out, at most 1 (Bonferroni).
    pub p_value: f64,
    /// Values that the effect's parameters would take.
    pub values: Vec<EffectValue>,
    /// Root mean square motion (m) of the tool if the effect were estimated: in the poses of the
    /// task that is asked for ([`Problem::acceptance`](crate::estimate::Problem::acceptance)), else
    /// over the workspace; in [`Problem::error_frame`](crate::estimate::Problem::error_frame).
    pub displacement: f64,
    /// Root mean square radius (m) of the tool's 95 % region in the same poses, as reported
    /// without the effect.
    pub radius: f64,
}

impl EffectTest {
    /// The values that contacts see, the one that is most standard deviations from zero first. Not
    /// seen is a parameter of which next to nothing is in the tested directions: its standard
    /// deviation is less than a ten-thousandth of the largest in the same unit.
    pub fn strongest_values(&self) -> Vec<&EffectValue> {
        let largest = |unit: Unit| {
            let alike = self.values.iter().filter(|entry| entry.unit == unit);
            alike.map(|entry| entry.sigma).fold(0.0, f64::max)
        };
        let is_seen = |entry: &&EffectValue| entry.sigma > LEAST_SEEN * largest(entry.unit);
        let mut values: Vec<&EffectValue> = self.values.iter().filter(is_seen).collect();
        let deviations = |entry: &EffectValue| (entry.value / entry.sigma).abs();
        values.sort_by(|a, b| deviations(b).total_cmp(&deviations(a)));
        values
    }
}

//! What a parameter changes.

use serde::{Deserialize, Serialize};

use super::block::Block;
use crate::robot::{EncoderTerm, KinematicParameter};

/// Names of the components of a twist `[v; ω]` in its order: `x`, `y`, `z` (m), then `rx`, `ry`,
/// `rz` (rad), as they end parameter names.
pub const TWIST_NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Names of the components of a wrench `[f; τ]` in its order (N, N m).
pub(super) const WRENCH_NAMES: [&str; 6] = ["fx", "fy", "fz", "tx", "ty", "tz"];

/// Names of the axis directions that contact normals are sorted into: `+x`, `-x`, `+y`, `-y`, `+z`,
/// `-z`, as they end names of directional gap biases.
pub const DIRECTION_NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// The quantity that a parameter changes. An index `i` counts the moving joints from the base, `p`
/// the placements in the order of their first fixture, `f` the fixtures of the problem, and `k` the
/// components of a twist `[v; ω]`, all from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ParameterId {
    /// A parameter of the arm or of the tool's pose on it.
    Kinematic(KinematicParameter),
    /// `(p, i)`: encoder offset of joint `i`, revolute or continuous, in placement `p` only (rad),
    /// on top of the joint's offset; no part of the calibrated arm.
    JointDrift(usize, usize),
    /// `(i)`: change of the encoder offset of joint `i` over the log or with temperature (rad, or m
    /// for a prismatic joint): on top of the joint's offset, minus this at the first contact or the
    /// lowest temperature and plus this at the last or highest, linear between, see
    /// [`TrendVariable`](crate::estimate::TrendVariable); no part of the calibrated arm.
    JointTrend(usize),
    /// `(i, k)`: amplitude (rad) of `k` half-waves of a cosine over the log in the encoder offset
    /// of joint `i`, revolute or continuous, on top of its trend: this at the first contact, and
    /// `cos kπ` times this at the last; no part of the calibrated arm.
    JointWalk(usize, usize),
    /// `(i, term)`: amplitude of a term of the error of joint `i`'s encoder (rad, or 1 for a gear
    /// ratio): the measured position `q` is too large by `amplitude · term.error(q)`.
    EncoderError(usize, EncoderTerm),
    /// `(f, k)`: component `k` of the local twist `ξ` on fixture `f`'s pose in base (m, rad):
    /// `base_from_fixture · Exp(ξ)`.
    Fixture(usize, usize),
    /// `(f)`: mean measured gap (m) at contacts with fixture `f`, negative where parts penetrate.
    GapBias(usize),
    /// `(f, k)`: gap bias (m), on top of [`ParameterId::GapBias`], of contacts whose normal, from
    /// the fixture into the tool, is nearest to axis direction `k` of fixture `f`: 0 to 5 for +x,
    /// −x, +y, −y, +z, −z.
    DirectionalGapBias(usize, usize),
    /// `(f)`: radius (m) of the edges of fixture `f`, and of the tool there, beyond the declared.
    /// An error that is allowed for and tested; it is not estimated.
    EdgeRadius(usize),
    /// `(k)`: bias `b` of component `k` of the measured wrench `[f; τ]` on the tool, in the tip
    /// frame (N, N m): measured = (1 + s) · true + b, the same for all contacts.
    WrenchBias(usize),
    /// Relative error `s` of the scale of the measured wrench (1), see [`ParameterId::WrenchBias`].
    WrenchScale,
    /// `(d)`: true less declared distance (m) number `d` of
    /// [`Problem::distances`](crate::estimate::Problem::distances).
    Distance(usize),
}

impl ParameterId {
    /// Component `k` (0 to 5, not checked) of the local twist `ξ = [v; ω]` (m, rad) on the tool's
    /// pose on the tip link: `tip_from_tool · Exp(ξ)`.
    pub fn tool(k: usize) -> ParameterId {
        ParameterId::Kinematic(KinematicParameter::Tool(k))
    }

    /// The block that the parameter belongs to.
    pub fn block(self) -> Block {
        match self {
            ParameterId::Kinematic(parameter) => match parameter {
                KinematicParameter::Strain => Block::Strain,
                KinematicParameter::SegmentStrain(_) => Block::SegmentStrain,
                KinematicParameter::JointOffset(_) => Block::JointOffset,
                KinematicParameter::JointOrigin(..) => Block::JointOrigin,
                KinematicParameter::JointCompliance(_) => Block::JointCompliance,
                KinematicParameter::JointBacklash(_) => Block::JointBacklash,
                KinematicParameter::Tool(_) => Block::Tool,
            },
            ParameterId::JointDrift(..) => Block::JointDrift,
            ParameterId::JointTrend(_) => Block::JointTrend,
            ParameterId::JointWalk(..) => Block::JointWalk,
            ParameterId::EncoderError(_, term) => match term {
                EncoderTerm::Sine | EncoderTerm::Cosine => Block::JointHarmonic,
                EncoderTerm::SecondSine | EncoderTerm::SecondCosine => Block::JointHarmonic2,
                EncoderTerm::GearRatio => Block::JointGearRatio,
            },
            ParameterId::Fixture(..) => Block::Fixture,
            ParameterId::GapBias(_) | ParameterId::DirectionalGapBias(..) => Block::GapBias,
            ParameterId::EdgeRadius(_) => Block::EdgeRadius,
            ParameterId::WrenchBias(_) => Block::WrenchBias,
            ParameterId::WrenchScale => Block::WrenchScale,
            ParameterId::Distance(_) => Block::Distance,
        }
    }

    /// The parameter of the kinematics of arm and tool; `None` for drifts, trends, walks, errors of
    /// encoders, fixtures, gap biases, edges, bias and scale of the wrench, and distances.
    pub fn kinematic(self) -> Option<KinematicParameter> {
        match self {
            ParameterId::Kinematic(parameter) => Some(parameter),
            _ => None,
        }
    }
}

impl From<KinematicParameter> for ParameterId {
    fn from(parameter: KinematicParameter) -> Self {
        ParameterId::Kinematic(parameter)
    }
}

/// The parameters of the kinematics of arm and tool among (parameter, value) pairs, and their
/// values (SI): two lists of equal length, in the order given; the other pairs are left out.
pub fn kinematic_part(values: impl IntoIterator<Item = (ParameterId, f64)>) -> (Vec<KinematicParameter>, Vec<f64>) {
    values.into_iter().filter_map(|(id, value)| Some((id.kinematic()?, value))).unzip()
}

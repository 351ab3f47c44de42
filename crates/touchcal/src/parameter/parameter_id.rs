//! What a parameter changes.

use super::block::Block;
use crate::robot::KinematicParameter;

/// Names of the components of a twist `[v; ω]`, as they end parameter names.
pub const TWIST_NAMES: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Names of the axis directions that contact normals are sorted into.
pub(super) const DIRECTION_NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

/// What a parameter changes. Indices count moving joints, placements and fixtures of the problem,
/// and components `k` of twists `[v; ω]`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParameterId {
    /// The arm or the tool on it.
    Kinematic(KinematicParameter),
    /// Encoder offset of joint `i` in placement `p` only (rad), on top of its offset; no part of
    /// the calibrated arm.
    JointDrift(usize, usize),
    /// Component `k` of the local twist on fixture `f`'s pose in base (m, rad).
    Fixture(usize, usize),
    /// Mean measured gap (m) at contacts with fixture `f`, negative where parts penetrate.
    GapBias(usize),
    /// What is added to it for contacts whose normal points in direction `k` of fixture `f` (m):
    /// +x, −x, +y, −y, +z, −z.
    DirectionalGapBias(usize, usize),
}

impl ParameterId {
    /// Component `k` of the twist on the tool's pose on the tip link.
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
                KinematicParameter::Tool(_) => Block::Tool,
            },
            ParameterId::JointDrift(..) => Block::JointDrift,
            ParameterId::Fixture(..) => Block::Fixture,
            ParameterId::GapBias(_) | ParameterId::DirectionalGapBias(..) => Block::GapBias,
        }
    }

    /// The parameter that kinematics know, if it is one.
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

/// The parameters of the kinematics among some, with their values.
pub fn kinematic_part(values: impl IntoIterator<Item = (ParameterId, f64)>) -> (Vec<KinematicParameter>, Vec<f64>) {
    values.into_iter().filter_map(|(id, value)| Some((id.kinematic()?, value))).unzip()
}

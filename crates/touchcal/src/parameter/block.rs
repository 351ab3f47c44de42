//! Named groups of parameters.

use serde::{Deserialize, Serialize};

/// A named group of parameters, as chosen in a problem file. A parameter's block is
/// [`ParameterId::block`](super::ParameterId::block).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Block {
    /// One strain common to all links (1).
    Strain,
    /// One strain for each segment of the arm (1).
    SegmentStrain,
    /// One encoder offset for each moving joint (rad, or m for a prismatic one).
    JointOffset,
    /// One encoder offset for each revolute or continuous joint and placement (rad), a nuisance.
    JointDrift,
    /// One linear change of the encoder offset over the log for each moving joint (rad, or m for a
    /// prismatic one), a nuisance.
    JointTrend,
    /// Amplitudes of slow cosines over the log in the encoder offset of each revolute or continuous
    /// joint, as random walks have them (rad), a nuisance.
    JointWalk,
    /// Two amplitudes of a harmonic of once a turn for the encoder of each revolute or continuous
    /// joint (rad).
    JointHarmonic,
    /// Two amplitudes of a harmonic of twice a turn for the encoder of each revolute or continuous
    /// joint (rad).
    JointHarmonic2,
    /// One relative error of the ratio between encoder and joint for each moving joint (1).
    JointGearRatio,
    /// Six components of a local twist `[v; ω]` on each moving joint's origin, in the joint's frame
    /// (m, rad): the full geometric model.
    JointOrigin,
    /// One compliance for each revolute or continuous joint (rad/(N m)).
    JointCompliance,
    /// Half of the play of each moving joint (rad, or m for a prismatic one).
    JointBacklash,
    /// Components of the local twist `[v; ω]` on the tool's pose on the tip link, in the tool frame
    /// (m, rad), a nuisance.
    Tool,
    /// Components of the local twist `[v; ω]` on a fixture's pose in base, in the fixture frame (m,
    /// rad), a nuisance.
    Fixture,
    /// Mean gaps at contact with a fixture (m): one common to all surfaces, and on top of it one
    /// for each of six directions; a nuisance.
    GapBias,
    /// Radius of the edges of tool and fixture beyond the declared (m), one for each hole; a
    /// nuisance that is not estimated.
    EdgeRadius,
    /// Bias of the measured wrench `[f; τ]` in the tip frame (N, N m), a nuisance.
    WrenchBias,
    /// Relative error of the scale of the measured wrench (1), a nuisance.
    WrenchScale,
    /// Errors of declared distances between fixtures (m), a nuisance.
    Distance,
}

impl Block {
    /// Name in files and reports: `strain`, `segment_strain`, `joint_offset`, `joint_drift`,
    /// `joint_trend`, `joint_walk`, `joint_harmonic`, `joint_harmonic_2`, `joint_gear_ratio`,
    /// `joint_origin`, `joint_compliance`, `joint_backlash`, `tool`, `fixture`, `gap_bias`,
    /// `edge_radius`, `wrench_bias`, `wrench_scale`, `distance`.
    pub fn name(self) -> &'static str {
        match self {
            Block::Strain => "strain",
            Block::SegmentStrain => "segment_strain",
            Block::JointOffset => "joint_offset",
            Block::JointDrift => "joint_drift",
            Block::JointTrend => "joint_trend",
            Block::JointWalk => "joint_walk",
            Block::JointHarmonic => "joint_harmonic",
            Block::JointHarmonic2 => "joint_harmonic_2",
            Block::JointGearRatio => "joint_gear_ratio",
            Block::JointOrigin => "joint_origin",
            Block::JointCompliance => "joint_compliance",
            Block::JointBacklash => "joint_backlash",
            Block::Tool => "tool",
            Block::Fixture => "fixture",
            Block::GapBias => "gap_bias",
            Block::EdgeRadius => "edge_radius",
            Block::WrenchBias => "wrench_bias",
            Block::WrenchScale => "wrench_scale",
            Block::Distance => "distance",
        }
    }

    /// Whether the block is of errors of encoders that depend on the measured position: true for
    /// harmonics and gear ratios.
    pub fn is_encoder_error(self) -> bool {
        matches!(self, Block::JointHarmonic | Block::JointHarmonic2 | Block::JointGearRatio)
    }

    /// Whether the block is of how joints deflect under torques: compliance and backlash.
    pub fn is_deflection(self) -> bool {
        matches!(self, Block::JointCompliance | Block::JointBacklash)
    }

    /// Whether the block is not part of the arm's description: true for tool, fixtures, drifts,
    /// trends, walks, harmonics, gear ratios, gap biases, edges, bias and scale of the wrench, and
    /// distances.
    pub fn is_nuisance(self) -> bool {
        let of_log = matches!(self, Block::JointDrift | Block::JointTrend | Block::JointWalk);
        let of_wrench = matches!(self, Block::WrenchBias | Block::WrenchScale);
        let of_parts = matches!(self, Block::GapBias | Block::EdgeRadius);
        of_log
            || self.is_encoder_error()
            || of_wrench
            || of_parts
            || matches!(self, Block::Tool | Block::Fixture | Block::Distance)
    }
}

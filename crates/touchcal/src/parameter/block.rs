//! Named groups of parameters.

/// A named group of parameters, as chosen in a problem file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Block {
    /// One strain common to all links.
    Strain,
    /// One strain a segment.
    SegmentStrain,
    /// One encoder offset a joint.
    JointOffset,
    /// One encoder offset a joint and placement, a nuisance.
    JointDrift,
    /// A twist on every joint origin: the full geometric model.
    JointOrigin,
    /// One compliance a revolute joint.
    JointCompliance,
    /// Pose of the tool on the tip link.
    Tool,
    /// Pose of a fixture in base.
    Fixture,
    /// Mean gap at contact, a nuisance.
    GapBias,
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
            Block::GapBias => "gap_bias",
        }
    }

    /// Whether the block is no part of the arm: tool, fixtures, drifts and gap biases.
    pub fn is_nuisance(self) -> bool {
        matches!(self, Block::Tool | Block::Fixture | Block::GapBias | Block::JointDrift)
    }
}

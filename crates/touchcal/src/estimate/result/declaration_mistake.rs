//! Declarations that are wrong in kind: a unit, an axis, an order, a sign, or the arm itself.

use serde::{Deserialize, Serialize};

/// Largest difference (1) of two ratios of lengths that count as the same.
const SAME_RATIO: f64 = 0.01;

/// What a problem declares wrong in kind, not just inaccurately.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum DeclarationMistake {
    /// Lengths are in another unit.
    LengthUnit {
        /// Which lengths.
        of: DeclaredLength,
        /// True over declared length (1): 1000 or 25.4 where metres or inches were given for
        /// millimetres, or the inverse.
        factor: f64,
    },
    /// The position of the tool on the tip link has the opposite sign.
    ToolOpposite,
    /// The tool's frame is turned about one of its own axes.
    ToolTurned {
        /// The axis, 0 to 2 for x, y, z.
        axis: usize,
        /// Number of quarter turns, 1 to 3, from the declared frame to the true one.
        quarters: u8,
    },
    /// The rotation of the tool on the tip link is in radians that were taken as degrees.
    ToolRotationInRadians,
    /// The rotation of a fixture in base is in radians that were taken as degrees.
    FixtureRotationInRadians {
        /// Name of the fixture.
        fixture: String,
    },
    /// The pose of the tip link in the tool's frame was declared as that of the tool on the tip.
    ToolInverted,
    /// Poses of base in the fixtures' frames were declared as those of the fixtures in base.
    FixturesInverted,
    /// Joint positions in the log are degrees that were taken as radians.
    DegreesAsRadians,
    /// Joint positions in the log are radians that were taken as degrees.
    RadiansAsDegrees,
    /// Contacts with two fixtures are declared as those of the other one.
    FixturesExchanged {
        /// Names of the two fixtures.
        fixtures: [String; 2],
        /// Other pairs of fixtures, of which one may be exchanged instead with the same effect, as
        /// of two blocks with two sockets each; often empty.
        or: Vec<[String; 2]>,
    },
    /// Two joints are exchanged in the log.
    JointsExchanged {
        /// Names of the two joints.
        joints: [String; 2],
    },
    /// The joints are in the opposite order in the log.
    JointsReversed,
    /// A joint has the opposite sign in the log.
    JointSign {
        /// Name of the joint.
        joint: String,
    },
    /// All joints have the opposite sign in the log.
    AllJointSigns,
    /// The log is of an arm of other lengths.
    ArmLengths {
        /// Names of the segments ([`Segment::name`](crate::robot::Segment::name)) with the lengths
        /// (m) that are described and those that the contacts show.
        segments: Vec<(String, f64, f64)>,
    },
    /// The log is of another arm.
    OtherArm {
        /// Name of that arm.
        name: String,
    },
}

/// Lengths that a problem declares.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum DeclaredLength {
    /// The position of the tool on the tip link.
    Tool,
    /// The position in base of the fixture of this name.
    Fixture(String),
    /// The positions in base of all fixtures.
    Fixtures,
    /// The distance of the two fixtures of these names.
    Distance([String; 2]),
    /// All distances of fixtures.
    Distances,
    /// The depth of the fixture of this name, a hole.
    Depth(String),
    /// All of these but depths.
    All,
}

/// How well contacts agree with a declaration: a coarse fit with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// Root mean square distance (m) of the contacts from their manifolds.
    pub distance: f64,
    /// Largest distance of a parameter or a known distance from what is declared, in prior standard
    /// deviations or, without prior, in plausible sizes (1).
    pub deviations: f64,
}

impl DeclarationMistake {
    /// Name in files: `length_unit`, `tool_opposite`, … (snake case).
    pub fn name(&self) -> &'static str {
        match self {
            DeclarationMistake::LengthUnit { .. } => "length_unit",
            DeclarationMistake::ToolOpposite => "tool_opposite",
            DeclarationMistake::ToolTurned { .. } => "tool_turned",
            DeclarationMistake::ToolRotationInRadians => "tool_rotation_in_radians",
            DeclarationMistake::FixtureRotationInRadians { .. } => "fixture_rotation_in_radians",
            DeclarationMistake::ToolInverted => "tool_inverted",
            DeclarationMistake::FixturesInverted => "fixtures_inverted",
            DeclarationMistake::DegreesAsRadians => "degrees_as_radians",
            DeclarationMistake::RadiansAsDegrees => "radians_as_degrees",
            DeclarationMistake::FixturesExchanged { .. } => "fixtures_exchanged",
            DeclarationMistake::JointsExchanged { .. } => "joints_exchanged",
            DeclarationMistake::JointsReversed => "joints_reversed",
            DeclarationMistake::JointSign { .. } => "joint_sign",
            DeclarationMistake::AllJointSigns => "all_joint_signs",
            DeclarationMistake::ArmLengths { .. } => "arm_lengths",
            DeclarationMistake::OtherArm { .. } => "other_arm",
        }
    }

    /// The mistake in English words, such as "joints `a1` and `a2` are exchanged in the log"; no
    /// full stop.
    pub fn description(&self) -> String {
        match self {
            DeclarationMistake::LengthUnit { of, factor } => {
                format!("{} in another unit: {}", of.description(), unit_description(*factor))
            }
            DeclarationMistake::ToolOpposite => "the tool's position has the opposite sign".to_owned(),
            DeclarationMistake::ToolTurned { axis, quarters } => {
                let (axis, angle) = (["x", "y", "z"][(*axis).min(2)], 90 * i32::from(*quarters));
                let angle = if angle > 180 { angle - 360 } else { angle };
                format!("the tool's frame, or that of the fixture, is turned by {angle}° about its {axis} axis")
            }
            DeclarationMistake::ToolRotationInRadians => {
                "the tool's rotation is in radians that were taken as degrees".to_owned()
            }
            DeclarationMistake::FixtureRotationInRadians { fixture } => {
                format!("the rotation of fixture `{fixture}` is in radians that were taken as degrees")
            }
            DeclarationMistake::ToolInverted => {
                "the tool's pose was declared the other way round, as that of the tip in the tool's frame".to_owned()
            }
            DeclarationMistake::FixturesInverted => {
                "poses of fixtures were declared the other way round, as those of base in their frames".to_owned()
            }
            DeclarationMistake::DegreesAsRadians => "degrees in the log were taken as radians".to_owned(),
            DeclarationMistake::RadiansAsDegrees => "radians in the log were taken as degrees".to_owned(),
            DeclarationMistake::FixturesExchanged { fixtures: [a, b], or } => {
                let or: String = or.iter().map(|[a, b]| format!(", or else those with `{a}` and `{b}`")).collect();
                format!("contacts with the fixtures `{a}` and `{b}` are exchanged{or}")
            }
            DeclarationMistake::JointsExchanged { joints: [a, b] } => {
                format!("joints `{a}` and `{b}` are exchanged in the log")
            }
            DeclarationMistake::JointsReversed => "the joints are in the opposite order in the log".to_owned(),
            DeclarationMistake::JointSign { joint } => format!("joint `{joint}` has the opposite sign in the log"),
            DeclarationMistake::AllJointSigns => "all joints have the opposite sign in the log".to_owned(),
            DeclarationMistake::ArmLengths { segments } => lengths_description(segments),
            DeclarationMistake::OtherArm { name } => format!("the log is of another arm: `{name}`"),
        }
    }

    /// What to change, without a full stop.
    pub fn remedy(&self) -> &'static str {
        match self {
            DeclarationMistake::LengthUnit { .. } => "declare these lengths in the unit that is asked for",
            DeclarationMistake::ToolOpposite => "measure from the tip link to the tool, along the axes of the tip link",
            DeclarationMistake::ToolTurned { .. } => {
                "check the rotation of the tool on the tip link, and that of the fixture in base"
            }
            DeclarationMistake::ToolRotationInRadians | DeclarationMistake::FixtureRotationInRadians { .. } => {
                "declare this rotation in degrees"
            }
            DeclarationMistake::ToolInverted => "declare the pose of the tool's frame in that of the tip link",
            DeclarationMistake::FixturesInverted => "declare the poses of the fixtures' frames in that of base",
            DeclarationMistake::DegreesAsRadians | DeclarationMistake::RadiansAsDegrees => {
                "declare the unit of the joint positions in the log"
            }
            DeclarationMistake::FixturesExchanged { .. } => {
                "check which log belongs to which of these fixtures, and exchange the names of the two in [[contacts]]"
            }
            DeclarationMistake::JointsExchanged { .. } | DeclarationMistake::JointsReversed => {
                "declare which column of the log belongs to which joint"
            }
            DeclarationMistake::JointSign { .. } | DeclarationMistake::AllJointSigns => {
                "check which way the joint turns: its axis in the robot description, and its sign in the log"
            }
            DeclarationMistake::ArmLengths { .. } | DeclarationMistake::OtherArm { .. } => {
                "use the robot description of the arm that was recorded"
            }
        }
    }

    /// The mistake with its evidence: how well contacts agree with the declarations as they are,
    /// and without the mistake; no full stop.
    pub(super) fn message(&self, declared: &Agreement, corrected: &Agreement) -> String {
        format!(
            "{}: without this contacts are {:.1} mm off and parameters within {:.1} standard deviations, with it {:.1} mm and {:.1}",
            self.description(),
            1e3 * corrected.distance,
            corrected.deviations,
            1e3 * declared.distance,
            declared.deviations
        )
    }
}

impl DeclaredLength {
    fn description(&self) -> String {
        match self {
            DeclaredLength::Tool => "the tool's position is".to_owned(),
            DeclaredLength::Fixture(name) => format!("the position of fixture `{name}` is"),
            DeclaredLength::Fixtures => "positions of fixtures are".to_owned(),
            DeclaredLength::Distance([a, b]) => format!("the distance of `{a}` and `{b}` is"),
            DeclaredLength::Distances => "distances of fixtures are".to_owned(),
            DeclaredLength::Depth(name) => format!("the depth of fixture `{name}` is"),
            DeclaredLength::All => "all declared lengths are".to_owned(),
        }
    }
}

/// By which unit a length is off whose true value is `factor` times the declared one.
fn unit_description(factor: f64) -> &'static str {
    match factor {
        _ if factor > 500.0 => "1000 times as long (metres for millimetres)",
        _ if factor > 1.0 => "25.4 times as long (inches for millimetres)",
        _ if factor > 0.01 => "1/25.4 times as long (millimetres for inches)",
        _ => "1/1000 times as long (millimetres for metres)",
    }
}

/// Lengths that differ from the described ones, or their common ratio.
fn lengths_description(segments: &[(String, f64, f64)]) -> String {
    let ratio = |(_, described, found): &(String, f64, f64)| found / described;
    let first = segments.first().map_or(1.0, ratio);
    if segments.iter().all(|segment| (ratio(segment) - first).abs() < SAME_RATIO) {
        return format!("the log is of an arm of another size: {first:.3} times the described lengths");
    }
    let differ = segments.iter().filter(|segment| (ratio(segment) - 1.0).abs() > SAME_RATIO);
    let each: Vec<String> = differ
        .map(|(name, described, found)| format!("{:.0} mm, not {:.0} mm, for `{name}`", 1e3 * found, 1e3 * described))
        .collect();
    format!("the log is of an arm of other lengths: {}", each.join(", "))
}

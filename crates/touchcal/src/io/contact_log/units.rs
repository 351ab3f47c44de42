//! Degrees where radians are declared.

use crate::io::error::{IoError, Place};
use crate::robot::{JointKind, Robot};

use super::AngleUnit;

/// How far beyond its limit an encoder with a wrong zero may read (rad): 20°.
const MARGIN: f64 = 0.35;
/// Within one turn (rad) either way nothing is noticed: arms are driven beyond the limits that
/// their URDF states (a gen3 lite log of the MUKCa set by 0.6 rad), while an arm in degrees has
/// some joint further than 6.28° from zero.
const TURN: f64 = std::f64::consts::TAU;
/// Share of rows beyond the limits from which the unit is wrong rather than a few rows.
const SHARE: f64 = 0.05;
/// A joint without limits is not turned further than this (rad), three turns.
const UNLIMITED: f64 = 20.0;
/// No joint position is so large (rad or m), in whatever unit.
const ABSURD: f64 = 1e4;

/// Watches joint positions for a wrong unit.
pub(super) struct UnitCheck {
    unit: AngleUnit,
    /// Name and range of every moving joint, none for one that slides.
    joints: Vec<(String, Option<(f64, f64)>)>,
    rows: u64,
    beyond: u64,
    /// The first position beyond its limit: line, joint, position.
    first: Option<(u64, usize, f64)>,
}

impl UnitCheck {
    pub(super) fn new(robot: &Robot, unit: AngleUnit) -> Self {
        let range = |joint: &crate::robot::Joint| match (joint.kind, joint.limits) {
            (JointKind::Prismatic, _) => None,
            (_, Some(limits)) => Some((limits.lower, limits.upper)),
            (_, None) => Some((-UNLIMITED, UNLIMITED)),
        };
        let joints = robot.moving().map(|joint| (joint.name.clone(), range(joint)));
        UnitCheck { unit, joints: joints.collect(), rows: 0, beyond: 0, first: None }
    }

    /// Takes the joint positions (rad or m) of a row; answers with the joint whose position is
    /// absurd, if one is.
    pub(super) fn row(&mut self, line: u64, q: &[f64]) -> Option<usize> {
        self.rows += 1;
        let outside = |(_, range): &(String, Option<(f64, f64)>), q: f64| {
            range.is_some_and(|(low, high)| q < (low - MARGIN).min(-TURN) || q > (high + MARGIN).max(TURN))
        };
        if let Some(joint) = self.joints.iter().zip(q).position(|(joint, &q)| outside(joint, q)) {
            self.beyond += 1;
            self.first.get_or_insert((line, joint, q[joint]));
        }
        q.iter().position(|q| q.abs() > ABSURD)
    }

    /// Whether the rows are too far beyond the limits for the unit.
    pub(super) fn doubtful(&self) -> bool {
        self.beyond as f64 > SHARE * self.rows as f64
    }

    /// The verdict over all rows.
    pub(super) fn finish(&self, file: &str, place: fn(&str, u64) -> Place) -> Result<(), IoError> {
        let Some((line, joint, q)) = self.first else { return Ok(()) };
        if !self.doubtful() {
            return Ok(());
        }
        let (name, range) = &self.joints[joint];
        let (low, high) = range.unwrap_or_default();
        let place = place(file, line).field(format!("joint `{name}`"));
        let (many, all) = (self.beyond, self.rows);
        let (expected, found) = match self.unit {
            AngleUnit::Radian | AngleUnit::Undeclared => (
                format!("radians within the joint limits [{low:.4}, {high:.4}]"),
                format!("{q}, and such in {many} of {all} rows: looks like degrees; declare unit = \"deg\""),
            ),
            AngleUnit::Degree => (
                format!("degrees within the joint limits [{:.1}, {:.1}]", low.to_degrees(), high.to_degrees()),
                format!("{}, and such in {many} of {all} rows: is this log of another robot?", q.to_degrees()),
            ),
        };
        Err(IoError::unexpected(place, expected, found))
    }
}

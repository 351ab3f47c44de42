//! The unit of joint positions, and its check against the joint limits.

use crate::robot::{JointKind, Robot};

/// Unit of the revolute joints' positions in a log; prismatic joints are in metres in any case.
/// [`read_file`](crate::io::contact_log::read_file) refuses a log of which more than 5 % of the
/// rows are beyond the joint limits in that unit (±20 rad for joints without limits): by more than
/// 20° and by more than a turn from zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AngleUnit {
    /// Not declared: radians, but degrees for a log of KUKA's recorder that does not fit the joint
    /// limits in radians and has angles beyond two turns; for such a recorder's log a note tells
    /// which.
    #[default]
    Undeclared,
    /// Radians (rad).
    Radian,
    /// Degrees (°), converted to radians on reading.
    Degree,
}

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

/// Joint positions that do not fit the joint limits in the declared unit.
pub(crate) struct UnitMismatch {
    /// First row with such a position.
    pub(crate) row: u64,
    /// Name of its joint.
    pub(crate) joint: String,
    /// What was expected, in words.
    pub(crate) expected: String,
    /// What was found, in words.
    pub(crate) found: String,
}

/// Counts joint positions beyond the joint limits, to detect a wrong unit.
pub(crate) struct UnitCheck {
    unit: AngleUnit,
    /// Name and range of every moving joint, none for one that slides.
    joints: Vec<(String, Option<(f64, f64)>)>,
    rows: u64,
    beyond: u64,
    /// The first position beyond its limit: row, joint, position.
    first: Option<(u64, usize, f64)>,
    /// Largest angle, either way.
    largest: f64,
}

impl UnitCheck {
    /// A check of positions declared in `unit`, against the joint limits of `robot`.
    pub(crate) fn new(robot: &Robot, unit: AngleUnit) -> Self {
        let range = |joint: &crate::robot::Joint| match (joint.kind, joint.limits) {
            (JointKind::Prismatic, _) => None,
            (_, Some(limits)) => Some((limits.lower, limits.upper)),
            (_, None) => Some((-UNLIMITED, UNLIMITED)),
        };
        let joints = robot.moving().map(|joint| (joint.name.clone(), range(joint)));
        UnitCheck { unit, joints: joints.collect(), rows: 0, beyond: 0, first: None, largest: 0.0 }
    }

    /// Counts the joint positions (rad or m) of a row; returns the joint whose position is absurd,
    /// if there is one.
    pub(crate) fn row(&mut self, row: u64, q: &[f64]) -> Option<usize> {
        self.rows += 1;
        let outside = |(_, range): &(String, Option<(f64, f64)>), q: f64| {
            range.is_some_and(|(low, high)| q < (low - MARGIN).min(-TURN) || q > (high + MARGIN).max(TURN))
        };
        if let Some(joint) = self.joints.iter().zip(q).position(|(joint, &q)| outside(joint, q)) {
            self.beyond += 1;
            self.first.get_or_insert((row, joint, q[joint]));
        }
        let angles = self.joints.iter().zip(q).filter(|((_, range), _)| range.is_some());
        self.largest = angles.fold(self.largest, |largest, (_, q)| largest.max(q.abs()));
        q.iter().position(|q| q.abs() > ABSURD)
    }

    /// Whether too many rows are beyond the limits for the unit.
    pub(crate) fn is_doubtful(&self) -> bool {
        self.beyond as f64 > SHARE * self.rows as f64
    }

    /// Whether angles are so small that those beyond the limits may be a turn too large: in degrees
    /// some joint of nearly every arm is further from zero.
    pub(crate) fn is_within_two_turns(&self) -> bool {
        self.largest < 2.0 * TURN
    }

    /// The mismatch over all rows, if the declared unit does not fit the joint limits.
    pub(crate) fn mismatch(&self) -> Option<UnitMismatch> {
        let (row, joint, q) = self.first?;
        if !self.is_doubtful() {
            return None;
        }
        let (name, range) = &self.joints[joint];
        let (low, high) = range.unwrap_or_default();
        let (many, all) = (self.beyond, self.rows);
        let (expected, found) = match self.unit {
            AngleUnit::Radian | AngleUnit::Undeclared => (
                format!("radians within the joint limits [{low:.4}, {high:.4}]"),
                if self.is_within_two_turns() {
                    format!(
                        "{q}, and such in {many} of {all} rows: too large by a turn, or degrees; bring angles into the limits by turns of 2π, or declare unit = \"deg\""
                    )
                } else {
                    format!("{q}, and such in {many} of {all} rows: looks like degrees; declare unit = \"deg\"")
                },
            ),
            AngleUnit::Degree => (
                format!("degrees within the joint limits [{:.1}, {:.1}]", low.to_degrees(), high.to_degrees()),
                format!("{}, and such in {many} of {all} rows: is this log of another robot?", q.to_degrees()),
            ),
        };
        Some(UnitMismatch { row, joint: name.clone(), expected, found })
    }
}

/// Positions of a log whose unit is not declared, taken as degrees.
pub(crate) struct UnitGuess {
    /// Factors from degrees (or m) to rad (or m).
    scale: Vec<f64>,
    /// A row in rad and m.
    q: Vec<f64>,
    units: UnitCheck,
}

impl UnitGuess {
    /// A guess for the moving joints of `robot`.
    pub(crate) fn new(robot: &Robot) -> Self {
        let scale = |kind| if kind == JointKind::Prismatic { 1.0 } else { std::f64::consts::PI / 180.0 };
        let scale: Vec<f64> = robot.moving().map(|joint| scale(joint.kind)).collect();
        UnitGuess { q: scale.clone(), scale, units: UnitCheck::new(robot, AngleUnit::Degree) }
    }

    /// Counts the joint positions of a row, as they are in the log.
    pub(crate) fn row(&mut self, row: u64, raw: &[f64]) {
        self.q.iter_mut().zip(raw).zip(&self.scale).for_each(|((q, raw), scale)| *q = raw * *scale);
        self.units.row(row, &self.q);
    }

    /// The mismatch, if the positions are not plausible in degrees either.
    pub(crate) fn mismatch(&self) -> Option<UnitMismatch> {
        self.units.mismatch()
    }

    /// For each joint, the factor from degrees (or m) to rad (or m).
    pub(crate) fn scale(&self) -> &[f64] {
        &self.scale
    }
}

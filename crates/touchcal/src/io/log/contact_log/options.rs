//! How to read a log.

use std::collections::BTreeMap;

use crate::contact::{AngleUnit, Detection, IngestOptions, Load, TorqueOf};

/// How to read a log: its columns and units, and which rows are contacts. By default all is found
/// from the log itself, and contacts are of fixture 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Index of the fixture that the contacts touch, from 0, into
    /// [`Problem::fixtures`](crate::estimate::Problem::fixtures).
    pub fixture: usize,
    /// Unit of the positions of revolute joints, in a bag too; those of prismatic joints are always
    /// in m.
    pub unit: AngleUnit,
    /// Column names of comma-separated values that have no header line, one per column; names of
    /// unused columns do not matter, another number of names is an error. `None`: the file has a
    /// header line, or its columns are the joints in order. Other formats have names of their own
    /// and ignore this.
    pub header: Option<Vec<String>>,
    /// Names of the moving joints in the order of the columns `q1` … `qn` and of a file without
    /// header: each exactly once, anything else is an error. `None`: the order of the kinematic
    /// chain, base first.
    pub joints: Option<Vec<String>>,
    /// Names that the file uses: from the usual name of a column (`q1`, a joint's name, `fx`,
    /// `contact`) to the name of the column or, in a bag, of the joint. A key that is no such name
    /// and a column that the file lacks are errors.
    pub columns: BTreeMap<String, String>,
    /// Name of the column of the arm's temperature (°C); `None`: it is not read. For a bag, which
    /// has none, a name is an error.
    pub temperature: Option<String>,
    /// Topic of a bag's joint states; `None`: the only topic of their type, of which two are an
    /// error. Without effect on other formats.
    pub joint_topic: Option<String>,
    /// Topic of a bag's wrenches. `None`: the only topic of their type, read only if `detection` or
    /// `load` needs wrenches. Without effect on other formats.
    pub wrench_topic: Option<String>,
    /// Contact detection by a force threshold, which needs columns `fx`, `fy`, `fz` (N), or
    /// wrenches in a bag; flags are then ignored. `None`: rows are contacts as flagged, or all if
    /// there are no flags.
    pub detection: Option<Detection>,
    /// Least motion (rad, or m for a prismatic joint; > 0) of some joint since the last contact for
    /// a row to be another contact; `None`: every row is one.
    pub apart: Option<f64>,
    /// Whether each row is a measurement of a target, and of what in it; `None`: rows touch the
    /// fixture itself, and columns of targets are not read. For a bag, which has none, an error.
    pub targets: Option<TargetColumns>,
    /// How the wrench, about the tip's origin, loads the arm and bends its joints; `None`: it is
    /// not taken into account. Needs columns `fx` to `tz` (N, N m), or wrenches in a bag.
    pub load: Option<Load>,
    /// Whose joint torques the log holds, which deflect joints in place of gravity on masses and a
    /// load; `None`: they are not read. Needs a column for each moving joint (N m, or N of a
    /// prismatic one), `tau_` and the joint's name or `tau_1` … `tau_n`, or efforts in a bag.
    pub joint_torques: Option<TorqueOf>,
    /// Whether columns of joint torques are read, as they are, where `joint_torques` is `None` and
    /// the log has one for each moving joint: what [`LogTable`](super::LogTable) keeps. Without
    /// effect on a bag.
    pub keeps_joint_torques: bool,
}

/// The columns of targets: a place in the frame of the fixture, `x_m`, `y_m`, `z_m` or `x_mm`,
/// `y_mm`, `z_mm`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetColumns {
    /// The place alone.
    Point,
    /// The place and the surface's normal there, of any length, `nx`, `ny`, `nz`, on the side of
    /// the tool.
    WithNormal,
}

impl Options {
    /// Whether columns of joint torques are looked for.
    pub(crate) fn finds_joint_torques(&self) -> bool {
        self.joint_torques.is_some() || self.keeps_joint_torques
    }

    /// Number of wrench components that rows must have: none, the force, or all six.
    pub(crate) fn wrench_parts(&self) -> usize {
        if self.load.is_some() {
            6
        } else if self.detection.is_some() {
            3
        } else {
            0
        }
    }

    /// What makes contacts of rows.
    pub(crate) fn ingest(&self) -> IngestOptions {
        let Options { fixture, detection, apart, load, joint_torques: torques, .. } = *self;
        IngestOptions { fixture, detection, apart, load, torques }
    }
}

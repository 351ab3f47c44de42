//! How to read a log.

use std::collections::BTreeMap;

use crate::contact::{AngleUnit, Detection, IngestOptions, Load};

/// How to read a log: its columns and units, and which rows are contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Index of the fixture that the contacts touch, from 0.
    pub fixture: usize,
    /// Unit of the columns of revolute joints; prismatic ones are always in m.
    pub unit: AngleUnit,
    /// Column names of a file that has no header line, one per column; names of unused columns do
    /// not matter. `None`: the file has a header line, or its columns are the joints in order.
    pub header: Option<Vec<String>>,
    /// Names of the moving joints in the order of the columns `q1` … `qn` and of a file without
    /// header; `None`: the order of the kinematic chain.
    pub joints: Option<Vec<String>>,
    /// Names that the file uses: from the usual name of a column (`q1`, a joint's name, `fx`,
    /// `contact`) to the name of the column or joint in the file.
    pub columns: BTreeMap<String, String>,
    /// Topic of a bag's joint states; `None`: the only topic of their type.
    pub joint_topic: Option<String>,
    /// Topic of a bag's wrenches; `None`: the only topic of their type.
    pub wrench_topic: Option<String>,
    /// Contact detection by a force threshold, which needs columns `fx`, `fy`, `fz` (N), or
    /// wrenches; `None`: rows are contacts as flagged, or all.
    pub detection: Option<Detection>,
    /// Least motion (rad or m) of some joint since the last contact for a row to be another
    /// contact; `None`: every row is one.
    pub apart: Option<f64>,
    /// How the wrench loads the arm and bends its joints; `None`: it is not taken into account.
    /// Needs columns `fx` to `tz` (N, N m), or wrenches.
    pub load: Option<Load>,
}

impl Options {
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
        let Options { fixture, detection, apart, load, .. } = *self;
        IngestOptions { fixture, detection, apart, load }
    }
}

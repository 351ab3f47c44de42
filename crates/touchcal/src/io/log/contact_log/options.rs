//! How to read a log.

use std::collections::BTreeMap;

use crate::contact::{AngleUnit, Detection, IngestOptions, Load};

/// How to read a log: its columns and units, and which rows are contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Index of the fixture that the contacts touch.
    pub fixture: usize,
    /// Unit of the revolute joints' columns.
    pub unit: AngleUnit,
    /// Names of the columns of a file that has no header line; the names of those that are not used
    /// do not matter.
    pub header: Option<Vec<String>>,
    /// Names of moving joints in the order of the columns `q1`…`qn` and of a file without header;
    /// none: the chain's order.
    pub joints: Option<Vec<String>>,
    /// By usual name (`q1`, a joint's name, `fx`, `contact`): the file's name for that column, or
    /// joint.
    pub columns: BTreeMap<String, String>,
    /// Topic of a bag's joint states; none: the only one of their type.
    pub joint_topic: Option<String>,
    /// Topic of a bag's wrenches; none: the only one of their type.
    pub wrench_topic: Option<String>,
    /// Contact detection by force; needs columns `fx`, `fy`, `fz`, or wrenches.
    pub detection: Option<Detection>,
    /// How far (rad or m) some joint must have moved since the last contact for a row to be another
    /// one; none: every row is.
    pub apart: Option<f64>,
    /// How the wrench is a load on the arm; none: it is not. Needs columns `fx` to `tz`, or
    /// wrenches.
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

//! The logs.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::value::{Number, Text};

#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) enum UnitToml {
    #[serde(rename = "rad")]
    Radian,
    #[serde(rename = "deg")]
    Degree,
}

/// What the wrench of a log is exerted on.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LoadOnToml {
    Tool,
    Fixture,
}

/// Along whose axes the wrench of a log is given.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LoadFrameToml {
    Tip,
    Base,
}

/// Whose torques the joint torques of a log are.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum TauJointToml {
    Load,
    Motor,
}

/// How logs are to be read.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct LogToml {
    /// Force above which a row is a contact. Without it: the column `contact` says so, else every
    /// row is one.
    /// Example: `force_threshold_n = 3`
    pub(crate) force_threshold_n: Option<Number>,
    /// Force below which a contact ends; at most `force_threshold_n`, which it needs. Without it:
    /// `force_threshold_n`.
    /// Example: `release_n = 2`
    pub(crate) release_n: Option<Number>,
    /// Number of rows that a change of contact must last before it counts, 1 to 1,000,000; needs
    /// `force_threshold_n`. Without it: 1.
    /// Example: `debounce = 3`
    pub(crate) debounce: Option<Spanned<i64>>,
    /// Motion of some joint since the last contact, below which a row is no further contact (a
    /// prismatic joint: the same angle at a metre). Without it: each row is a contact.
    /// Example: `apart_deg = 1`
    pub(crate) apart_deg: Option<Number>,
    /// The body on which the wrench of the log acts, which then is the load of the contact. Without
    /// it: the wrench only detects contact.
    /// Example: `load_on = "tool"`
    pub(crate) load_on: Option<LoadOnToml>,
    /// Along whose axes the wrench is given; needs `load_on`. Without it: tip.
    /// Example: `load_frame = "base"`
    pub(crate) load_frame: Option<Spanned<LoadFrameToml>>,
    /// Rows by which a first-order low-pass filter makes the wrench lag; needs `load_on`. Without
    /// it: 0.
    /// Example: `load_lag_rows = 2`
    pub(crate) load_lag_rows: Option<Number>,
    /// Whose torques the log has, in a column `tau_JOINT` or `tau_1` … for each joint (N m): those
    /// that gravity and contact exert about the joint, or those that the motor exerts. They deflect
    /// joints in place of gravity and `load_on`, with which this key is refused. Without it:
    /// torques follow from masses and loads.
    /// Example: `tau_joint = "load"`
    pub(crate) tau_joint: Option<Spanned<TauJointToml>>,
    /// Unit of angles in the log. Without it: rad; guessed in a KUKA recorder log.
    /// Example: `unit = "deg"`
    pub(crate) unit: Option<UnitToml>,
    /// Names of the columns of a CSV file without a header. Without it: the joints in order.
    /// Example: `header = ["t", "q1", "q2", "q3", "fz"]`
    pub(crate) header: Option<Vec<String>>,
    /// Name of the column of the arm's temperature (°C). Without it: none.
    /// Example: `temperature = "arm_c"`
    pub(crate) temperature: Option<String>,
    /// Topic of the joint states in a bag of several. Without it: the only one of its type.
    /// Example: `joint_topic = "/arm/joint_states"`
    pub(crate) joint_topic: Option<String>,
    /// Topic of the wrench in a bag of several. Without it: the only one of its type.
    /// Example: `wrench_topic = "/arm/wrench"`
    pub(crate) wrench_topic: Option<String>,
    /// The log's names of joints and columns, by touchcal's. Without it: the same names.
    /// Example: `columns = { joint_a1 = "shoulder" }`
    pub(crate) columns: Option<BTreeMap<String, String>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContactsToml {
    /// The log: CSV (plain or gzipped), Parquet, a ROS 2 bag (MCAP) or its folder, or a KUKA
    /// recorder log.
    /// Example: `file = "log.csv.gz"`
    pub(crate) file: Text,
    /// Name of the fixture that is touched.
    /// Example: `fixture = "hole"`
    pub(crate) fixture: Text,
    /// Whether contacts are not fitted, but test the result. Without it: false.
    /// Example: `held_out = true`
    #[serde(default)]
    pub(crate) held_out: bool,
    // Those of `[log]`, for this log.
    pub(crate) force_threshold_n: Option<Number>,
    pub(crate) release_n: Option<Number>,
    pub(crate) debounce: Option<Spanned<i64>>,
    pub(crate) apart_deg: Option<Number>,
    pub(crate) load_on: Option<LoadOnToml>,
    pub(crate) load_frame: Option<Spanned<LoadFrameToml>>,
    pub(crate) load_lag_rows: Option<Number>,
    pub(crate) tau_joint: Option<Spanned<TauJointToml>>,
    pub(crate) unit: Option<UnitToml>,
    pub(crate) header: Option<Vec<String>>,
    pub(crate) temperature: Option<String>,
    pub(crate) joint_topic: Option<String>,
    pub(crate) wrench_topic: Option<String>,
    pub(crate) columns: Option<BTreeMap<String, String>>,
}

impl ContactsToml {
    /// How this log is to be read: the keys that the table has, and those of `[log]` that it lacks.
    pub(crate) fn with(&self, log: &LogToml) -> LogToml {
        let (own, log) = (self, log.clone());
        LogToml {
            force_threshold_n: own.force_threshold_n.clone().or(log.force_threshold_n),
            release_n: own.release_n.clone().or(log.release_n),
            debounce: own.debounce.clone().or(log.debounce),
            apart_deg: own.apart_deg.clone().or(log.apart_deg),
            load_on: own.load_on.or(log.load_on),
            load_frame: own.load_frame.clone().or(log.load_frame),
            load_lag_rows: own.load_lag_rows.clone().or(log.load_lag_rows),
            tau_joint: own.tau_joint.clone().or(log.tau_joint),
            unit: own.unit.or(log.unit),
            header: own.header.clone().or(log.header),
            temperature: own.temperature.clone().or(log.temperature),
            joint_topic: own.joint_topic.clone().or(log.joint_topic),
            wrench_topic: own.wrench_topic.clone().or(log.wrench_topic),
            columns: own.columns.clone().or(log.columns),
        }
    }
}

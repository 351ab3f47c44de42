//! `estimate.json` of schema 1, as versions 0.1 wrote it, converted to schema 2.
//!
//! | schema 1 | schema 2 |
//! |---|---|
//! | block and names `interference…` | `gap_bias…` |
//! | `null_space[].words` | `null_space[].description` |
//! | `warnings[].words` | `warnings[].message` |
//! | | `warnings[].severity` |
//! | `warnings[].kind` | the names in [`KINDS`] |

use std::collections::BTreeMap;

use serde::Deserialize;

use super::estimate_entries::{
    ContactCounts, NullDirection, ParameterEntry, Residuals, Severity, Status, TerminationEntry, WarningEntry,
};
use crate::io::base::bytes::Input;

/// Kinds of warnings that were renamed: old, new.
const KINDS: [(&str, &str); 9] = [
    ("untouched", "fixture_without_contacts"),
    ("tool_aside", "origin_outside_tool"),
    ("held", "unobservable"),
    ("err_alike", "correlated_errors"),
    ("few_tell_walls", "few_informative_contacts"),
    ("ambiguous", "competing_minimum"),
    ("joint_hardly_moved", "little_joint_motion"),
    ("tool_only_in_estimate", "tool_not_in_robot"),
    ("compliance_needs_driver", "compliance_in_robot"),
];
/// The block of gap biases: old, new.
const GAP_BIAS: [&str; 2] = ["interference", "gap_bias"];
/// What ends the text of a warning that forbids the use of the result.
const FORBIDDEN: &str = "do not use the result";
/// The kind that forbids it without these words.
const TOO_FEW_CONTACTS: &str = "too_few_contacts";

/// A calibration's result in schema 1.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EstimateFile1 {
    #[serde(rename = "schema")]
    _schema: u32,
    pub(super) status: Status,
    pub(super) parameters: Vec<ParameterEntry>,
    pub(super) covariance: Vec<Vec<f64>>,
    pub(super) rank: usize,
    pub(super) condition: Option<f64>,
    pub(super) null_space: Vec<NullDirection1>,
    pub(super) residuals: Residuals,
    pub(super) contacts: ContactCounts,
    pub(super) termination: TerminationEntry,
    pub(super) warnings: Vec<WarningEntry1>,
    pub(super) inputs: Vec<Input>,
    pub(super) version: String,
    pub(super) seconds: f64,
}

/// A direction of the null space in schema 1.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NullDirection1 {
    words: String,
    direction: BTreeMap<String, f64>,
}

/// A warning in schema 1.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct WarningEntry1 {
    kind: String,
    words: String,
    advice: String,
}

impl From<NullDirection1> for NullDirection {
    fn from(old: NullDirection1) -> Self {
        let direction = old.direction.into_iter().map(|(name, part)| (renamed(name), part));
        NullDirection { description: old.words, remedy: None, direction: direction.collect() }
    }
}

impl From<WarningEntry1> for WarningEntry {
    fn from(WarningEntry1 { kind, words, advice }: WarningEntry1) -> Self {
        let is_unusable = words.contains(FORBIDDEN) || kind == TOO_FEW_CONTACTS;
        let new = KINDS.iter().find(|(old, _)| *old == kind).map(|(_, new)| (*new).to_owned());
        WarningEntry {
            kind: new.unwrap_or(kind),
            severity: if is_unusable { Severity::Unusable } else { Severity::Caution },
            message: words,
            advice,
        }
    }
}

/// A parameter under its new name.
pub(super) fn parameter(old: ParameterEntry) -> ParameterEntry {
    ParameterEntry { name: renamed(old.name), block: renamed(old.block), ..old }
}

/// The new name of a parameter or block.
fn renamed(name: String) -> String {
    let [old, new] = GAP_BIAS;
    match name.strip_prefix(old) {
        Some(rest) if rest.is_empty() || rest.starts_with('.') => format!("{new}{rest}"),
        _ => name,
    }
}

//! A warning in words.

use serde::{Serialize, Serializer};

use crate::estimate::Severity;

/// A warning as the page shows it, in plain text; see [`Warning`](crate::estimate::Warning).
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct WarningText {
    /// Its consequence: the page lists the gravest first, those of the same in the given order.
    #[serde(serialize_with = "name")]
    pub severity: Severity,
    /// The defect, in one sentence.
    pub message: String,
    /// A remedy, in one sentence.
    pub advice: String,
}

fn name<S: Serializer>(severity: &Severity, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(severity.name())
}

/// The gravest first.
pub(super) fn sorted(warnings: &[WarningText]) -> Vec<&WarningText> {
    let mut sorted: Vec<&WarningText> = warnings.iter().collect();
    sorted.sort_by_key(|warning| warning.severity);
    sorted
}

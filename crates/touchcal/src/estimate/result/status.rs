//! Whether a result may be used.

use serde::{Deserialize, Serialize};

/// Whether an estimate may be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Status {
    /// The minimization converged, and contacts do not contradict what was declared: use the
    /// estimate.
    Usable,
    /// The minimization converged, and a warning says what contacts contradict, or that they are
    /// few. Standard deviations allow for what is contradicted: use the estimate if they are small
    /// enough.
    Doubtful,
    /// The minimization did not converge, or a warning forbids the use: the data do not determine
    /// the arm or contradict what was declared. Do not use the estimate.
    NotUsable,
}

impl Status {
    /// Name in files: `usable`, `doubtful`, `not_usable`.
    pub fn name(self) -> &'static str {
        match self {
            Status::Usable => "usable",
            Status::Doubtful => "doubtful",
            Status::NotUsable => "not_usable",
        }
    }

    /// Whether the estimate may be used, with doubts or without.
    pub fn is_usable(self) -> bool {
        self != Status::NotUsable
    }
}

/// Consequence of a warning for the use of a result; the graver one is the lesser in their order,
/// so that it comes first when sorted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The result must not be used.
    Unusable,
    /// Contacts contradict something, or are few: the result is doubtful.
    Doubtful,
    /// Worth knowing where the result is used.
    Caution,
}

impl Severity {
    /// Name in files: `unusable`, `doubtful`, `caution`.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Unusable => "unusable",
            Severity::Doubtful => "doubtful",
            Severity::Caution => "caution",
        }
    }
}

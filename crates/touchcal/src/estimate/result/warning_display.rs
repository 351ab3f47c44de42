//! A warning as one text.

use std::fmt;

use super::warning::Warning;

impl fmt::Display for Warning {
    /// The message and the advice.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message(), self.advice())
    }
}

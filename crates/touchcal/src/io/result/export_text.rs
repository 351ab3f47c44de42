//! A calibrated arm in the format of another program.

/// A file for another program, and what of the calibration it lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportText {
    /// Content of the file.
    pub text: String,
    /// What of the calibration the file cannot hold, in words for the user.
    pub left_out: Vec<String>,
}

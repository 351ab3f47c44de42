//! The page that `evaluate --report` writes.

use jiff::Timestamp;
use touchcal::estimate::{self, Contradiction, Problem};
use touchcal::io;
use touchcal::io::estimate_file::Status;
use touchcal::report::{EvaluationReport, Input, WarningText};

use super::{Report, truth};
use crate::failure::Failure;

/// The text of the page; `status` is that of the calibration.
pub fn html(
    problem: &Problem,
    report: &Report<'_>,
    status: Option<Status>,
    inputs: &[io::Input],
) -> Result<String, Failure> {
    let input = |input: &io::Input| Input { path: input.path.clone(), sha256: input.sha256.clone() };
    let page = EvaluationReport {
        problem,
        evaluated: &report.urdf.display().to_string(),
        nominal: &report.nominal,
        evaluation: &report.evaluation,
        is_calibrated: report.is_calibrated,
        status: status.map(estimate::Status::from),
        created: Some(&Timestamp::now().to_string()),
        tool_errors: &report.tool_errors.as_ref().map_or_else(Vec::new, truth::rows),
        warnings: &report.evaluation.contradictions.iter().map(warning).collect::<Vec<_>>(),
        inputs: &inputs.iter().map(input).collect::<Vec<_>>(),
    };
    Ok(page.html()?)
}

fn warning(contradiction: &Contradiction) -> WarningText {
    WarningText {
        severity: contradiction.severity(),
        message: contradiction.message(),
        advice: contradiction.advice().to_owned(),
    }
}

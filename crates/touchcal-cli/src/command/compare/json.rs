//! What `compare --json` prints.

use serde::Serialize;
use touchcal::estimate::Comparison;
use touchcal::experiment::PoseErrors;
use touchcal::io::estimate_file::RobotEntry;
use touchcal::io::{CalibrationChanges, SavedCalibration};

use crate::command::rms_and_max::RmsAndMaxJson;
use crate::failure::Failure;

#[derive(Serialize)]
struct ComparisonJson<'a> {
    earlier: CalibrationJson<'a>,
    later: CalibrationJson<'a>,
    arm: ChangesJson<'a>,
    tool: Option<ChangesJson<'a>>,
    /// Motion of the tip at equal joint positions across the workspace.
    tip_motion: Option<MotionJson>,
    common_logs: &'a [String],
}

#[derive(Serialize)]
struct CalibrationJson<'a> {
    path: &'a str,
    created: Option<&'a str>,
    status: &'static str,
    robot: Option<&'a RobotEntry>,
}

/// Parameters in SI units.
#[derive(Serialize)]
struct ChangesJson<'a> {
    p_value: Option<f64>,
    statistic: f64,
    degrees_of_freedom: usize,
    only_in_one: &'a [String],
    parameters: Vec<ParameterJson<'a>>,
}

#[derive(Serialize)]
struct ParameterJson<'a> {
    name: &'a str,
    earlier: f64,
    later: f64,
    sigma_of_difference: f64,
    deviations: Option<f64>,
}

#[derive(Serialize)]
struct MotionJson {
    position_mm: RmsAndMaxJson,
    angle_deg: RmsAndMaxJson,
    distance_mm: RmsAndMaxJson,
}

/// The comparison as JSON.
pub fn of([earlier, later]: &[SavedCalibration; 2], changes: &CalibrationChanges) -> Result<String, Failure> {
    let json = ComparisonJson {
        earlier: calibration(earlier),
        later: calibration(later),
        arm: changes_json(&changes.arm),
        tool: changes.tool.as_ref().map(changes_json),
        tip_motion: changes.tip_motion.as_ref().map(motion),
        common_logs: &changes.common_logs,
    };
    Ok(serde_json::to_string_pretty(&json)? + "\n")
}

fn calibration(calibration: &SavedCalibration) -> CalibrationJson<'_> {
    CalibrationJson {
        path: &calibration.name,
        created: calibration.file.created.as_deref(),
        status: calibration.file.status.name(),
        robot: calibration.file.robot.as_ref(),
    }
}

fn changes_json(found: &Comparison) -> ChangesJson<'_> {
    let parameters = found.parameters.iter().map(|change| ParameterJson {
        name: &change.name,
        earlier: change.values[0],
        later: change.values[1],
        sigma_of_difference: change.sigma,
        deviations: change.deviations(),
    });
    ChangesJson {
        p_value: found.p_value,
        statistic: found.statistic,
        degrees_of_freedom: found.degrees_of_freedom,
        only_in_one: &found.only_in_one,
        parameters: parameters.collect(),
    }
}

fn motion(found: &PoseErrors) -> MotionJson {
    MotionJson {
        position_mm: RmsAndMaxJson::new(found.position, 1e3),
        angle_deg: RmsAndMaxJson::new(found.angle, 1f64.to_degrees()),
        distance_mm: RmsAndMaxJson::new(found.distance, 1e3),
    }
}

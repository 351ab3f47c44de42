//! What a problem file asks of its calibration.

use touchcal::estimate::Acceptance;
use touchcal::robot::Kinematics;

use super::problem_file::*;
use crate::support;

fn with(table: &str) -> Result<touchcal::io::Loaded, String> {
    read(&format!("{FULL}\n[accept]\n{table}\n"))
}

fn asked(table: &str) -> Acceptance {
    with(table).unwrap().problem.acceptance.unwrap()
}

#[test]
fn postures_are_a_task() {
    let asked = asked(
        "tolerance_mm = 0.2\ntolerance_deg = 0.1\nconfidence = 0.99\npostures_deg = [[0, 40, 0, -90, 0, 50, 0], [10, 40, 0, -90, 0, 50, 90]]",
    );
    assert!((asked.distance - 0.2e-3).abs() < 1e-15);
    assert!((asked.angle.unwrap() - 0.1f64.to_radians()).abs() < 1e-15);
    assert_eq!(asked.confidence, 0.99);
    assert_eq!(asked.positions.len(), 2);
    assert!((asked.positions[1][6] - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
}

#[test]
fn a_box_of_joints_is_a_task() {
    let asked =
        asked("tolerance_mm = 1\njoints_deg = [[-10, 10], [30, 50], [0, 0], [-100, -80], [0, 1], [40, 60], [-90, 90]]");
    assert_eq!((asked.angle, asked.confidence, asked.positions.len()), (None, 0.95, 100));
    let of_joint = |k: usize| asked.positions.iter().map(move |q| q[k].to_degrees());
    assert!(of_joint(1).all(|q| (30.0..=50.0).contains(&q)) && of_joint(2).all(|q| q == 0.0));
    let (least, most) = (of_joint(6).fold(f64::MAX, f64::min), of_joint(6).fold(f64::MIN, f64::max));
    assert!(least < -80.0 && most > 80.0, "{least} {most}");
}

#[test]
fn a_region_is_a_task() {
    let loaded = with("tolerance_mm = 1\nregion = { center_mm = [500, 0, 400], size_mm = [300, 200, 100] }").unwrap();
    let problem = loaded.problem;
    let kinematics = Kinematics::new(&problem.robot, &[], problem.tool.tip_from_tool);
    let positions = problem.acceptance.unwrap().positions;
    assert!(positions.len() >= 10);
    for q in &positions {
        let at = kinematics.pose(q).translation.vector;
        assert!((at.x - 0.5).abs() <= 0.15 && at.y.abs() <= 0.1 && (at.z - 0.4).abs() <= 0.05, "{at}");
    }
}

#[test]
fn what_is_no_task_is_refused() {
    let refused = |table: &str, parts: &[&str]| support::refused(with(table), parts);
    refused("tolerance_mm = 1", &["accept", "`postures_deg`, `joints_deg` or `region`", "found none"]);
    refused("postures_deg = [[0, 40, 0, -90, 0, 50, 0]]", &["accept, tolerance_mm", "a positive number"]);
    refused("tolerance_mm = 1\npostures_deg = [[0, 40]]", &["accept, postures_deg", "7 numbers", "found 2"]);
    refused("tolerance_mm = 1\npostures_deg = []", &["1 to 1000 postures", "found 0"]);
    refused("tolerance_mm = 1\npostures_deg = [[0, 40, 0, -90, nan, 50, 0]]", &["found NaN"]);
    refused("tolerance_mm = 1\njoints_deg = [[0, 1]]", &["accept, joints_deg", "7 pairs", "found 1"]);
    refused(
        "tolerance_mm = 1\nconfidence = 95\nregion = { center_mm = [0, 0, 0], size_mm = [1, 1, 1] }",
        &["accept, confidence", "found 95"],
    );
    refused(
        "tolerance_mm = 1\nregion = { center_mm = [9000, 0, 0], size_mm = [10, 10, 10] }",
        &["accept, region", "a region that the tool reaches", "found 0 of"],
    );
    refused("tolerance_mm = 1\ntolerance_degrees = 1", &["did you mean `tolerance_deg`?"]);
}

/// One or two poses can be moved to where they should be.
#[test]
fn few_postures_are_no_task_with_the_base_aligned() {
    use touchcal::estimate::ErrorFrame;
    let postures = |count: usize| {
        let postures: Vec<String> = (0..count).map(|k| format!("[{k}, 40, 0, -90, 0, 50, 0]")).collect();
        format!("tolerance_mm = 0.2\nframe = \"base_aligned\"\npostures_deg = [{}]", postures.join(", "))
    };
    assert_eq!(asked(&postures(3)).frame, ErrorFrame::BaseAligned);
    assert_eq!(asked("tolerance_mm = 0.2\npostures_deg = [[0, 40, 0, -90, 0, 50, 0]]").frame, ErrorFrame::Base);
    support::refused(
        with(&postures(2)).map(drop),
        &["accept", "at least 3 postures with frame = \"base_aligned\"", "found 2"],
    );
}

//! `dh.json`: the Denavit–Hartenberg form of a calibrated arm, in both conventions.

use serde_json::Value;

use crate::io::result::export_text::ExportText;
use crate::io::robot::urdf::roll_pitch_yaw;
use crate::robot::{DhLink, Joint, JointKind, NEARLY_PARALLEL, Robot, denavit_hartenberg};
use crate::se3::Pose;

/// Numbers (mm, degrees) are rounded to a multiple of one over this: 1e-13 m and 2e-12 rad.
const PER_UNIT: f64 = 1e10;
/// Formulas of the file.
const TEXTS: [(&str, &str); 5] = [
    (
        "standard_model",
        "base_from_tip = base_from_dh_base * [Rz(theta) Tz(d) Tx(a) Rx(alpha) Ry(beta) of each joint, base first] * dh_last_from_tip",
    ),
    (
        "modified_model",
        "base_from_tip = base_from_dh_base * [Tx(a) Rx(alpha) Ry(beta) Rz(theta) Tz(d) of each joint, base first] * dh_last_from_tip",
    ),
    (
        "joint_position",
        "revolute: theta = theta_offset + position, d = d_offset; prismatic: theta = theta_offset, d = d_offset + position",
    ),
    ("transforms", "T(xyz) Rz(yaw) Ry(pitch) Rx(roll), a_from_b maps coordinates in b to coordinates in a"),
    ("beta", "parameter of Hayati (1983) in place of the offset d between nearly_parallel_axes, 0 elsewhere"),
];

/// The Denavit–Hartenberg parameters ([`denavit_hartenberg`]) of `robot` as JSON: `standard`
/// (distal) and `modified` (proximal, Craig), a line for each moving joint, in mm and degrees, the
/// transforms before the first and after the last frame, and the formulas that they belong to.
pub fn of(robot: &Robot) -> ExportText {
    let left_out: Vec<String> = robot.is_compliant().then(|| "joint compliances".to_owned()).into_iter().collect();
    let form = denavit_hartenberg(robot);
    let joints: Vec<&Joint> = robot.moving().collect();
    let parallel = joints.windows(2).zip(&form.links).filter(|(_, link)| link.is_nearly_parallel);
    let parallel: Vec<Value> = parallel.map(|(pair, _)| Value::from(vec![&*pair[0].name, &*pair[1].name])).collect();
    let before = std::iter::once(DhLink::default()).chain(form.links.iter().copied());
    let standard = joints.iter().zip(&form.links).map(|(joint, link)| row(joint, link, link));
    let modified = joints.iter().zip(&form.links).zip(before).map(|((joint, link), before)| row(joint, link, &before));
    let not_here = left_out.iter().cloned().chain(["joint limits and masses".to_owned(), "the tool".to_owned()]);
    let mut entries: Vec<(&str, String)> = vec![
        ("robot", string(robot.name())),
        ("base", string(robot.base())),
        ("tip", string(robot.tip())),
        ("not_in_this_file", Value::from(not_here.collect::<Vec<_>>()).to_string()),
    ];
    entries.extend(TEXTS.map(|(key, text)| (key, string(text))));
    entries.extend([
        ("nearly_parallel_below_deg", number(NEARLY_PARALLEL.asin().to_degrees())),
        ("nearly_parallel_axes", Value::from(parallel).to_string()),
        ("base_from_dh_base", transform(&form.base_from_dh_base)),
        ("dh_last_from_tip", transform(&form.dh_last_from_tip)),
        ("standard", lines(standard)),
        ("modified", lines(modified)),
    ]);
    let entries: Vec<String> = entries.iter().map(|(key, value)| format!("  \"{key}\": {value}")).collect();
    ExportText { text: format!("{{\n{}\n}}\n", entries.join(",\n")), left_out }
}

/// A joint's line: `theta` and `d` of one link, and of one, the same or that before, the rest.
fn row(joint: &Joint, about_z: &DhLink, about_x: &DhLink) -> String {
    let kind = if joint.kind == JointKind::Prismatic { "prismatic" } else { "revolute" };
    format!(
        "{{\"joint\": {}, \"kind\": \"{kind}\", \"theta_offset_deg\": {}, \"d_offset_mm\": {}, \"a_mm\": {}, \"alpha_deg\": {}, \"beta_deg\": {}}}",
        string(&joint.name),
        degrees(about_z.theta),
        millimetres(about_z.d),
        millimetres(about_x.a),
        degrees(about_x.alpha),
        degrees(about_x.beta),
    )
}

fn transform(pose: &Pose) -> String {
    let xyz = <[f64; 3]>::from(pose.translation.vector).map(millimetres).join(", ");
    let angles = roll_pitch_yaw(&pose.rotation).map(degrees).join(", ");
    format!("{{\"xyz_mm\": [{xyz}], \"roll_pitch_yaw_deg\": [{angles}]}}")
}

fn lines(rows: impl Iterator<Item = String>) -> String {
    format!("[\n    {}\n  ]", rows.collect::<Vec<_>>().join(",\n    "))
}

fn string(text: &str) -> String {
    Value::from(text).to_string()
}

fn millimetres(metres: f64) -> String {
    number(1e3 * metres)
}

fn degrees(angle: f64) -> String {
    number(angle.to_degrees())
}

/// A number without digits that are rounding errors; adding zero turns -0 into 0.
fn number(value: f64) -> String {
    Value::from((value * PER_UNIT).round() / PER_UNIT + 0.0).to_string()
}

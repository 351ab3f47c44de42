//! Encoder offsets for an arm's driver: a flat YAML map from joint to offset.

use crate::robot::{JointKind, Robot};

/// Words that YAML takes for something else than text.
const RESERVED: [&str; 9] = ["true", "false", "yes", "no", "on", "off", "y", "n", "null"];

/// The YAML map from joint name to encoder offset for the moving joints of `robot`, base first,
/// with 12 decimals and a comment on its use before: `joint_a1: 0.012300000000  # rad`. `offsets`
/// has one entry per moving joint, `b` of `true = measured − b` (rad, or m for a prismatic joint);
/// joints beyond the entries are left out, surplus entries ignored.
pub fn text(robot: &Robot, offsets: &[f64]) -> String {
    let mut text = "# Encoder offsets: true position = measured position - offset.\n\
                    # For the URDF beside this file alone; any other one has them folded in, or belongs to another calibration.\n"
        .to_owned();
    for (joint, offset) in robot.moving().zip(offsets) {
        let unit = if joint.kind == JointKind::Prismatic { "m" } else { "rad" };
        // No exponent: YAML 1.1 reads 1e-5 as text. Adding zero turns -0 into 0.
        text.push_str(&format!("{}: {:.12}  # {unit}\n", key(&joint.name), (offset * 1e12).round() / 1e12 + 0.0));
    }
    text
}

/// A name as YAML's key: plain where nobody could take it for something else, quoted as in JSON
/// otherwise.
fn key(name: &str) -> String {
    let plain = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c))
        && !RESERVED.contains(&name.to_ascii_lowercase().as_str());
    if plain { name.to_owned() } else { serde_json::Value::from(name).to_string() }
}

//! What is asked of the calibration: the table `[accept]`.

use std::path::Path;

use nalgebra::Vector3;
use serde::Deserialize;
use toml::Spanned;

use super::context::{Allowed, Context, DEG, LARGEST, MAX_BYTES, MM};
use super::schema::{AcceptToml, ErrorFrameToml, RegionToml};
use crate::estimate::{Acceptance, ErrorFrame, Tool, configurations_within, workspace_configurations};
use crate::io::base::bytes;
use crate::io::base::error::{IoError, shown_number};
use crate::robot::{JointKind, Kinematics, Robot};

/// Poses of a task that is a box of joints or a region.
const POSES: usize = 100;
/// Configurations among which those with the tool in a region are looked for.
const CANDIDATES: usize = 200_000;
/// Fewest of them that make a task.
const LEAST_POSES: usize = 10;
/// Most postures in a list.
const MOST_POSTURES: usize = 1000;
const DEFAULT_CONFIDENCE: f64 = 0.95;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AcceptanceToml {
    accept: Spanned<AcceptToml>,
}

/// Reads the table `[accept]` of a problem file from a text that holds it alone, for a problem with
/// this arm and tool. `file` is its name for messages.
///
/// # Errors
/// [`IoError`] if the text is longer than [`MAX_BYTES`], is no TOML or has other tables or keys; a
/// number is out of range, or not for each moving joint; or the tool does not reach the region.
pub fn read_acceptance(text: &str, file: &str, (robot, tool): (&Robot, &Tool)) -> Result<Acceptance, IoError> {
    let context = Context { text, file, folder: Path::new("") };
    bytes::check_size(text.len() as u64, MAX_BYTES, file)?;
    let toml: AcceptanceToml = toml::from_str(text).map_err(|error| context.syntax(&error))?;
    acceptance(&toml.accept, (robot, tool), &context)
}

/// What a table asks of the calibration of this arm with this tool.
pub(super) fn acceptance(
    table: &Spanned<AcceptToml>,
    (robot, tool): (&Robot, &Tool),
    context: &Context<'_>,
) -> Result<Acceptance, IoError> {
    let toml = table.get_ref();
    let distance = context.required(toml.tolerance_mm.as_ref(), MM, table.span(), "accept, tolerance_mm")?;
    let angle = context.number(toml.tolerance_deg.as_ref(), DEG, Allowed::Positive, "accept, tolerance_deg")?;
    let frame = match toml.frame {
        None | Some(ErrorFrameToml::Base) => ErrorFrame::Base,
        Some(ErrorFrameToml::BaseAligned) => ErrorFrame::BaseAligned,
    };
    let confidence = confidence(toml, context)?;
    let positions = positions(table, (robot, tool), context)?;
    if frame == ErrorFrame::BaseAligned && positions.len() < Acceptance::MIN_ALIGNED {
        let expected = format!("at least {} postures with frame = \"base_aligned\"", Acceptance::MIN_ALIGNED);
        let place = context.place(table.span(), "accept");
        return Err(IoError::unexpected(place, expected, format!("{}", positions.len())));
    }
    Ok(Acceptance { distance, angle, confidence, frame, positions })
}

fn confidence(toml: &AcceptToml, context: &Context<'_>) -> Result<f64, IoError> {
    let Some(number) = &toml.confidence else { return Ok(DEFAULT_CONFIDENCE) };
    let value = *number.get_ref();
    if value > 0.5 && value <= 0.999 {
        return Ok(value);
    }
    let place = context.place(number.span(), "accept, confidence");
    Err(IoError::unexpected(place, "a number above 0.5, at most 0.999", shown_number(value)))
}

/// Joint positions (rad or m) of the task.
fn positions(
    table: &Spanned<AcceptToml>,
    (robot, tool): (&Robot, &Tool),
    context: &Context<'_>,
) -> Result<Vec<Vec<f64>>, IoError> {
    let toml = table.get_ref();
    match (&toml.postures_deg, &toml.joints_deg, &toml.region) {
        (Some(postures), None, None) => listed(postures, robot, context),
        (None, Some(joints), None) => Ok(configurations_within(&joint_box(joints, robot, context)?, POSES)),
        (None, joints, Some(region)) => {
            let limits = joints.as_ref().map(|joints| joint_box(joints, robot, context)).transpose()?;
            in_region(region, limits.as_deref(), (robot, tool), context)
        }
        (None, None, None) => {
            let expected = "`postures_deg`, `joints_deg` or `region`: where the tool works";
            Err(IoError::unexpected(context.place(table.span(), "accept"), expected, "none"))
        }
        (Some(postures), ..) => {
            let place = context.place(postures.span(), "accept, postures_deg");
            Err(IoError::unexpected(place, "postures alone", "`joints_deg` or `region` beside them"))
        }
    }
}

fn listed(postures: &Spanned<Vec<Vec<f64>>>, robot: &Robot, context: &Context<'_>) -> Result<Vec<Vec<f64>>, IoError> {
    let wrong = |expected: String, found: String| {
        IoError::unexpected(context.place(postures.span(), "accept, postures_deg"), expected, found)
    };
    let list = postures.get_ref();
    if !(1..=MOST_POSTURES).contains(&list.len()) {
        return Err(wrong(format!("1 to {MOST_POSTURES} postures"), format!("{}", list.len())));
    }
    if let Some(posture) = list.iter().find(|posture| posture.len() != robot.dof()) {
        let expected = format!("{} numbers in each posture, one for each moving joint", robot.dof());
        return Err(wrong(expected, format!("{}", posture.len())));
    }
    if let Some(bad) = list.iter().flatten().find(|value| !within_bounds(**value)) {
        return Err(wrong(format!("numbers within ±{LARGEST}"), shown_number(*bad)));
    }
    let in_si = |posture: &Vec<f64>| posture.iter().zip(units(robot)).map(|(value, unit)| value * unit).collect();
    Ok(list.iter().map(in_si).collect())
}

fn joint_box(
    joints: &Spanned<Vec<[f64; 2]>>,
    robot: &Robot,
    context: &Context<'_>,
) -> Result<Vec<(f64, f64)>, IoError> {
    let wrong = |expected: String, found: String| {
        IoError::unexpected(context.place(joints.span(), "accept, joints_deg"), expected, found)
    };
    let list = joints.get_ref();
    if list.len() != robot.dof() {
        let expected = format!("{} pairs of numbers, one for each moving joint", robot.dof());
        return Err(wrong(expected, format!("{}", list.len())));
    }
    if let Some(bad) =
        list.iter().find(|[lower, upper]| !within_bounds(*lower) || !within_bounds(*upper) || lower > upper)
    {
        return Err(wrong(format!("pairs [lower, upper] within ±{LARGEST}"), format!("{bad:?}")));
    }
    Ok(list.iter().zip(units(robot)).map(|([lower, upper], unit)| (lower * unit, upper * unit)).collect())
}

/// Joint positions, within these limits or those of the arm, that put the tool into the region.
fn in_region(
    region: &Spanned<RegionToml>,
    limits: Option<&[(f64, f64)]>,
    (robot, tool): (&Robot, &Tool),
    context: &Context<'_>,
) -> Result<Vec<Vec<f64>>, IoError> {
    let RegionToml { center_mm, size_mm } = region.get_ref();
    let center = MM * Vector3::from(context.vector(center_mm, "accept, region.center_mm")?);
    let size = MM * Vector3::from(context.vector(size_mm, "accept, region.size_mm")?);
    let kinematics = Kinematics::new(robot, &[], tool.tip_from_tool);
    let is_inside = |q: &Vec<f64>| {
        let off = kinematics.pose(q).translation.vector - center;
        (0..3).all(|k| 2.0 * off[k].abs() <= size[k])
    };
    let candidates = match limits {
        Some(limits) => configurations_within(limits, CANDIDATES),
        None => workspace_configurations(robot, CANDIDATES),
    };
    let inside: Vec<Vec<f64>> = candidates.into_iter().filter(is_inside).take(POSES).collect();
    if inside.len() >= LEAST_POSES {
        return Ok(inside);
    }
    let expected = "a region that the tool reaches, or `joints_deg` near the task beside it";
    let found = format!("{} of {CANDIDATES} configurations with the tool in it", inside.len());
    Err(IoError::unexpected(context.place(region.span(), "accept, region"), expected, found))
}

fn within_bounds(value: f64) -> bool {
    value.abs() <= LARGEST
}

/// A degree (rad), or a millimetre (m) for a prismatic joint.
fn units(robot: &Robot) -> impl Iterator<Item = f64> {
    robot.moving().map(|joint| if joint.kind == JointKind::Prismatic { MM } else { DEG })
}

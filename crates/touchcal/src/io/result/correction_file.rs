//! `correction.json`: what a URDF cannot say about the positions of a calibrated arm's joints.

use serde::Serialize;
use serde_json::Value;

use crate::estimate::Status;
use crate::io::base::error::{IoError, Place};
use crate::robot::{BACKLASH_TORQUE, EncoderTerm, Joint, JointCorrection, JointKind, LoadedLink, Robot, split_offsets};
use crate::se3::Pose;

/// Version of the format.
const SCHEMA: u32 = 1;
/// What the numbers mean.
const TEXTS: [(&str, &str); 4] = [
    (
        "use",
        "joint positions of calibrated.urdf are the true ones: measured positions are corrected before they are used with it, and positions that are planned with it before they are commanded; guide: Correcting joint positions",
    ),
    (
        "model",
        "true = measured - error(measured) + compliance_rad_per_nm * torque(true) + backlash * torque(true) / sqrt(torque(true)^2 + backlash_torque^2); error = -gear_ratio * measured + the sum over harmonics of sin * sin(order * measured) + cos * cos(order * measured); torque (N m) about the joint's axis, or force (N) along that of a prismatic joint, by \"torque\": of gravity on the masses that the joint carries and of a load on the tip (gravity_and_load), or that gravity and contact exert there, measured where the encoders are (measured)",
    ),
    (
        "offsets",
        "offset_in_urdf (measured - true) is part of the joint origins of calibrated.urdf and not of the model: subtract it nowhere; measured positions are those of the log, without any offset",
    ),
    (
        "chain",
        "parent_from_joint: of the moving joint before, or the base; the joint's frame at position zero; mass_kg and center_m: of all that moves with the joint but not with the next one, in its frame; units m, rad",
    ),
];

#[derive(Serialize)]
struct JointEntry<'a> {
    name: &'a str,
    kind: &'static str,
    offset_in_urdf: f64,
    gear_ratio: f64,
    harmonics: Vec<HarmonicEntry>,
    compliance_rad_per_nm: f64,
    backlash: f64,
    axis: [f64; 3],
    #[serde(flatten)]
    link: LinkEntry,
}

/// Amplitudes (rad) of a harmonic of an encoder.
#[derive(Serialize)]
struct HarmonicEntry {
    order: u32,
    sin: f64,
    cos: f64,
}

#[derive(Serialize)]
struct LinkEntry {
    parent_from_joint: PoseEntry,
    mass_kg: f64,
    center_m: [f64; 3],
}

#[derive(Serialize)]
struct PoseEntry {
    xyz_m: [f64; 3],
    quat_wxyz: [f64; 4],
}

/// The text of the file for the `calibrated` arm with these `errors` of its encoders (index of the
/// moving joint, term, amplitude); `None` if positions need no correction. That of a result that
/// must not be used says so at its beginning.
///
/// # Errors
/// [`IoError`] if the calibrated arm has other joints than the `nominal` one.
pub fn text(
    [calibrated, nominal]: [&Robot; 2],
    errors: &[(usize, EncoderTerm, f64)],
    status: Status,
) -> Result<Option<String>, IoError> {
    let correction = JointCorrection::new(calibrated, errors.iter().copied());
    if correction.is_identity() {
        return Ok(None);
    }
    let Some((_, offsets)) = split_offsets(calibrated, nominal) else {
        return Err(IoError::unexpected(Place::file(nominal.name()), "the joints of the nominal arm", "others"));
    };
    let links = correction.links();
    let joints = calibrated.moving().zip(&links).zip(&offsets).enumerate();
    let joints = joints.map(|(i, ((joint, link), offset))| line(&joint_entry(i, joint, link, *offset, errors)));
    let mut entries = vec![("schema", SCHEMA.to_string()), ("status", string(status.name()))];
    if status == Status::NotUsable {
        entries.push(("warning", string("NOT USABLE: do not use this calibration, see report.html")));
    }
    entries.extend([
        ("version", string(env!("CARGO_PKG_VERSION"))),
        ("robot", string(calibrated.name())),
        ("base", string(calibrated.base())),
        ("tip", string(calibrated.tip())),
        ("urdf", string("calibrated.urdf")),
    ]);
    entries.extend(TEXTS.map(|(key, words)| (key, string(words))));
    let tip = links.last().map(|link| line(&LinkEntry::of(link)));
    entries.extend([
        ("torque", string(if calibrated.has_measured_torques() { "measured" } else { "gravity_and_load" })),
        ("backlash_torque", line(&BACKLASH_TORQUE)),
        ("has_masses", calibrated.has_masses().to_string()),
        ("gravity_m_s2", line(&<[f64; 3]>::from(*calibrated.gravity()))),
        ("joints", format!("[\n    {}\n  ]", joints.collect::<Vec<_>>().join(",\n    "))),
        ("tip_link", tip.unwrap_or_default()),
    ]);
    let entries: Vec<String> = entries.iter().map(|(key, value)| format!("  \"{key}\": {value}")).collect();
    Ok(Some(format!("{{\n{}\n}}\n", entries.join(",\n"))))
}

fn joint_entry<'a>(
    i: usize,
    joint: &'a Joint,
    link: &LoadedLink,
    offset: f64,
    errors: &[(usize, EncoderTerm, f64)],
) -> JointEntry<'a> {
    let amplitude = |term: EncoderTerm| -> f64 {
        errors.iter().filter(|(of, of_term, _)| (*of, *of_term) == (i, term)).map(|(.., amplitude)| *amplitude).sum()
    };
    let harmonics = EncoderTerm::HARMONICS;
    let harmonics =
        harmonics.map(|(order, [sine, cosine])| HarmonicEntry { order, sin: amplitude(sine), cos: amplitude(cosine) });
    let turns = joint.kind != JointKind::Prismatic;
    JointEntry {
        name: &joint.name,
        kind: if turns { "revolute" } else { "prismatic" },
        offset_in_urdf: offset,
        gear_ratio: amplitude(EncoderTerm::GearRatio),
        harmonics: harmonics.into_iter().filter(|entry| (entry.sin, entry.cos) != (0.0, 0.0)).collect(),
        compliance_rad_per_nm: if turns { joint.compliance } else { 0.0 },
        backlash: joint.backlash,
        axis: joint.axis.into_inner().into(),
        link: LinkEntry::of(link),
    }
}

impl LinkEntry {
    fn of(link: &LoadedLink) -> LinkEntry {
        LinkEntry {
            parent_from_joint: PoseEntry::of(&link.parent_from_joint),
            mass_kg: link.mass,
            center_m: link.center.into(),
        }
    }
}

impl PoseEntry {
    fn of(pose: &Pose) -> PoseEntry {
        let [i, j, k, w]: [f64; 4] = pose.rotation.coords.into();
        PoseEntry { xyz_m: pose.translation.vector.into(), quat_wxyz: [w, i, j, k] }
    }
}

fn line(entry: &impl Serialize) -> String {
    serde_json::to_string(entry).unwrap_or_default()
}

fn string(text: &str) -> String {
    Value::from(text).to_string()
}

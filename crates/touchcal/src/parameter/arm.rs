//! Parameters of the arm, block by block.

use super::definition::{COMPLIANCE_GROUP, ORIGIN_ZERO_GROUP, Parameter, Prior, Unit};
use super::parameter_id::ParameterId;
use crate::robot::{JointKind, KinematicParameter, Robot, segments};

/// Plausible sizes: 5 % strain, a joint of 1e3 N m/rad.
const STRAIN_SCALE: f64 = 0.05;
const COMPLIANCE_SCALE: f64 = 1e-3;

/// Standard deviations of the full geometric model, see [`joint_origin`].
const ORIGIN_LENGTH_SIGMA: f64 = 0.5e-3;
const ORIGIN_ANGLE_SIGMA: f64 = 0.1 * std::f64::consts::PI / 180.0;
const ORIGIN_ZERO_SIGMA: f64 = 0.5 * std::f64::consts::PI / 180.0;
/// A variance component's start counts as one observed value.
pub(super) const VARIANCE_COMPONENT_STRENGTH: f64 = 1.0;
/// Start of the compliances' variance component: harmonic drives of an arm's size have about 1e4 N
/// m/rad.
const COMPLIANCE_SIGMA: f64 = 1e-4;
/// Arms differ in stiffness by orders of magnitude, so that start counts little: the compliances of
/// a stiff arm must go to zero.
const COMPLIANCE_STRENGTH: f64 = 0.01;

/// Prior standard deviations of half of a joint's play: of a gear with hardly any (rad), and of a
/// slide (m).
const BACKLASH_ANGLE_SIGMA: f64 = 0.01 * std::f64::consts::PI / 180.0;
const BACKLASH_LENGTH_SIGMA: f64 = 1e-5;

fn ratio(name: String, id: KinematicParameter) -> Parameter {
    Parameter { name, id: id.into(), unit: Unit::One, prior: Prior::Flat, scale: STRAIN_SCALE }
}

/// The strain `r` common to all links (1), named `strain`, without prior: lengths are
/// `l = (1 + r) l₀`.
pub fn strain() -> Parameter {
    ratio("strain".to_owned(), KinematicParameter::Strain)
}

/// A strain (1) for each of the arm's [`segments`](segments()), in their order, named
/// `segment_strain.{segment}`, on top of the common one, without prior. Empty for an arm without
/// lengths.
pub fn segment_strain(robot: &Robot) -> Vec<Parameter> {
    let each = segments(robot).into_iter().enumerate();
    each.map(|(k, segment)| ratio(format!("segment_strain.{}", segment.name), KinematicParameter::SegmentStrain(k)))
        .collect()
}

/// An encoder offset for each moving joint (rad, or m for a prismatic one), base first, named
/// `joint_offset.{joint}`, without prior: true position = measured − offset.
pub fn joint_offset(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate();
    each.map(|(i, joint)| {
        let name = format!("joint_offset.{}", joint.name);
        let id = KinematicParameter::JointOffset(i).into();
        match joint.kind {
            JointKind::Prismatic => Parameter::length(name, id),
            _ => Parameter::angle(name, id),
        }
    })
    .collect()
}

/// A local twist `ξ = [v; ω]` on each moving joint's origin, `origin · Exp(ξ)`, so in the joint's
/// frame: the full geometric model, six numbers `x, y, z` (m) and `rx, ry, rz` (rad) a joint, base
/// first, named `joint_origin.{joint}.{component}`.
///
/// The priors are typical of arms: links are made to about 0.5 mm and 0.1°; the zero of an encoder
/// is off by about 0.5°, a variance component estimated from the data. The zero is the rotation
/// about the axis of a revolute or continuous joint: the components `rx, ry, rz` for which the
/// axis, a unit vector in the joint's frame, has an entry above 0.5 in magnitude, one where it is
/// along x, y or z and up to three for an oblique axis. Without priors about half of the directions
/// would be undetermined: displacements of neighbouring origins compensate each other.
pub fn joint_origin(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate();
    each.flat_map(|(i, joint)| {
        let prefix = format!("joint_origin.{}", joint.name);
        let along = |k: usize| if joint.kind == JointKind::Prismatic { 0.0 } else { joint.axis[k % 3].abs() };
        (0..6).map(move |k| {
            let id = ParameterId::Kinematic(KinematicParameter::JointOrigin(i, k));
            let parameter = Parameter::twist(&prefix, id, k);
            match k {
                0..3 => parameter.with_sigma(ORIGIN_LENGTH_SIGMA),
                _ if along(k) > 0.5 => parameter.with_prior(Prior::VarianceComponent {
                    sigma: ORIGIN_ZERO_SIGMA,
                    group: ORIGIN_ZERO_GROUP,
                    strength: VARIANCE_COMPONENT_STRENGTH,
                }),
                _ => parameter.with_sigma(ORIGIN_ANGLE_SIGMA),
            }
        })
    })
    .collect()
}

/// A compliance `c` (rad/(N m)) for each revolute or continuous joint, base first, named
/// `joint_compliance.{joint}`, on top of what the arm declares; its prior is a variance component
/// that starts at 1e-4 rad/(N m). Gravity and the load on the tool deflect the joints on the far
/// side of their encoders.
///
/// The true angle is `q − b + c τ(q)`, with the measured angle `q` (rad), the encoder offset `b`
/// (rad) and the torque `τ` (N m) about the joint's axis: of gravity on all that the joint carries,
/// and of the contact's [load](crate::contact::ContactLog::load) where that is known. Masses are
/// those of the links' [`Inertia`](crate::robot::Inertia)s if every moving joint carries one before
/// the next; links beside the chain do not count. Otherwise a kilogram in the middle of each moving
/// link, between its joint's origin and the next, and one at the tip stand in for them: then `c`
/// carries the arm's unknown mass and is a compliance only together with these masses, not with a
/// load.
pub fn joint_compliance(robot: &Robot) -> Vec<Parameter> {
    let revolute = robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic);
    let each = revolute.map(|(i, joint)| Parameter {
        name: format!("joint_compliance.{}", joint.name),
        id: KinematicParameter::JointCompliance(i).into(),
        unit: Unit::RadianPerNewtonMeter,
        prior: Prior::VarianceComponent {
            sigma: COMPLIANCE_SIGMA,
            group: COMPLIANCE_GROUP,
            strength: COMPLIANCE_STRENGTH,
        },
        scale: COMPLIANCE_SCALE,
    });
    each.collect()
}

/// Half of the play `b` (rad, or m for a prismatic joint) of each moving joint, base first, named
/// `joint_backlash.{joint}`, on top of what the arm declares, with a prior of 0.01°, or 0.01 mm.
///
/// The true position is larger by `b s(τ)` on the far side of the encoder, with the torque `τ` as
/// of [`joint_compliance`], or the force along a prismatic joint, and its sign
/// `s(τ) = τ / √(τ² + τ₀²)`, which is smooth about 0
/// ([`BACKLASH_TORQUE`](crate::robot::BACKLASH_TORQUE)).
pub fn joint_backlash(robot: &Robot) -> Vec<Parameter> {
    let each = robot.moving().enumerate().map(|(i, joint)| {
        let name = format!("joint_backlash.{}", joint.name);
        let id = KinematicParameter::JointBacklash(i).into();
        match joint.kind {
            JointKind::Prismatic => Parameter::length(name, id).with_sigma(BACKLASH_LENGTH_SIGMA),
            _ => Parameter::angle(name, id).with_sigma(BACKLASH_ANGLE_SIGMA),
        }
    });
    each.collect()
}

/// Every parameter of the arm and the tool that the simulator draws, in the order: strain, segment
/// strains, encoder offsets, joint origins, compliances, backlashes, tool.
pub fn of_arm_and_tool(robot: &Robot) -> Vec<Parameter> {
    let mut all = vec![strain()];
    all.extend(segment_strain(robot));
    all.extend(joint_offset(robot));
    all.extend(joint_origin(robot));
    all.extend(joint_compliance(robot));
    all.extend(joint_backlash(robot));
    all.extend((0..6).map(|k| Parameter::twist("tool", ParameterId::tool(k), k)));
    all
}

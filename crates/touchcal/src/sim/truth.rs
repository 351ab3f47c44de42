//! The true errors of one trial, drawn from a scenario.

use nalgebra::Vector2;
use rand::RngExt;
use rand_pcg::Pcg64;

use super::recorder::{Recorder, WrenchErrors, normal};
use super::scenario::{ArmErrors, Distribution, PlaceError, Scenario, Touch};
use crate::geometry::{EdgeRadii, Parts};
use crate::parameter::{
    Parameter, ParameterId, edge_radius, joint_gear_ratio, joint_harmonic, joint_harmonic_2, joint_trend,
    kinematic_part, of_arm_and_tool, wrench_bias, wrench_scale,
};
use crate::robot::{EncoderTerm, JointKind, KinematicParameter, Robot, segments};
use crate::se3::{self, Pose, Twist};

/// True errors of an arm, its tool, the fixtures and the force sensor, the numbers that a
/// calibration estimates, and of what is declared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// Parameters that are not zero, each once, with their values (SI), in any order. True poses of
    /// tool and fixtures are `nominal · Exp(ξ)`, with `ξ` the components `Tool` or `Fixture`.
    /// Drifts of placements and gap biases have no effect.
    pub errors: Vec<(ParameterId, f64)>,
    /// How much wider each hole is than its nominal outline (m per side; negative for narrower),
    /// one number for each touch of the scenario; missing ones count as 0, those of other parts
    /// have no effect.
    pub clearance: Vec<f64>,
    /// How much deeper each hole is than its nominal depth (m; negative for shallower), likewise.
    pub depth: Vec<f64>,
    /// How much wider each hole is along x and y than by its clearance (m per side), likewise: a
    /// wall with the outward normal `n` is further out by `nₓ² x + n_y² y`.
    pub unequal_clearance: Vec<[f64; 2]>,
    /// Error of each of the scenario's measured distances: measured minus true (m); missing ones
    /// count as 0.
    pub distance_error: Vec<f64>,
}

impl Truth {
    /// Draws what `scenario` leaves to chance. Always in the same order: settings that draw nothing
    /// leave the rest as it is.
    pub(super) fn draw(scenario: &Scenario, chance: &mut Pcg64) -> Truth {
        let mut errors = arm_errors(&scenario.robot, &scenario.errors, chance);
        errors.extend(place_error(scenario.tool_error, chance, ParameterId::tool));
        let mut clearance = Vec::with_capacity(scenario.touches.len());
        let mut blocks: Vec<(&str, Pose)> = Vec::new();
        for (f, touch) in scenario.touches.iter().enumerate() {
            let drawn = place_error(touch.place_error, chance, |k| ParameterId::Fixture(f, k));
            // A block is moved by what its first fixture is; the others go with it.
            match blocks.iter().find(|(block, _)| *block == touch.block()) {
                Some((_, moved)) => {
                    let xi = se3::log(&(touch.base_from_fixture.inverse() * moved * touch.base_from_fixture));
                    errors.extend((0..6).map(|k| (ParameterId::Fixture(f, k), xi[k])));
                }
                None => {
                    let xi = sum(&drawn);
                    let moved = touch.base_from_fixture * se3::exp(&xi) * touch.base_from_fixture.inverse();
                    blocks.push((touch.block(), moved));
                    errors.extend(drawn);
                }
            }
            clearance.push(touch.clearance_sigma * normal(chance));
        }
        errors.extend(wrench_errors(&scenario.recorder, chance));
        let turning = turning_joints(&scenario.robot);
        errors.extend(turning.map(|i| (ParameterId::JointTrend(i), scenario.recorder.encoder_trend * normal(chance))));
        errors.retain(|(_, value)| *value != 0.0);
        let depth = scenario.touches.iter().map(|touch| touch.depth_sigma * normal(chance)).collect();
        let distance_error = scenario.distances.iter().map(|measured| measured.sigma * normal(chance)).collect();
        let unequal =
            |touch: &Touch, chance: &mut Pcg64| [(); 2].map(|()| touch.unequal_clearance_sigma * normal(chance));
        let unequal_clearance = scenario.touches.iter().map(|touch| unequal(touch, chance)).collect();
        for (f, touch) in scenario.touches.iter().enumerate().filter(|(_, touch)| touch.edge_radius_sigma > 0.0) {
            errors.push((ParameterId::EdgeRadius(f), (touch.edge_radius_sigma * normal(chance)).abs()));
        }
        errors.extend(encoder_errors(&scenario.robot, &scenario.errors, chance));
        Truth { errors, clearance, depth, unequal_clearance, distance_error }
    }

    /// Value (SI) of the parameter `column`; 0 if it is not among the errors.
    pub fn value(&self, column: ParameterId) -> f64 {
        self.errors.iter().filter(|(c, _)| *c == column).map(|(_, value)| value).sum()
    }

    /// Strain (1) of segment `k`, from 0, of the arm's [`segments`](segments()), the common one
    /// included.
    pub fn strain(&self, k: usize) -> f64 {
        self.value(KinematicParameter::Strain.into()) + self.value(KinematicParameter::SegmentStrain(k).into())
    }

    /// Erroneous parameters of the kinematics of the arm with its tool, and their values (SI): two
    /// lists of equal length, in the order of [`Truth::errors`].
    pub fn of_kinematics(&self) -> (Vec<KinematicParameter>, Vec<f64>) {
        kinematic_part(self.errors.iter().copied())
    }

    /// True pose of the fixture of touch `f` in base (m); `f` is an index into
    /// [`Scenario::touches`]. Panics if there is no such touch.
    pub fn base_from_fixture(&self, scenario: &Scenario, f: usize) -> Pose {
        let xi = Twist::from_fn(|k, _| self.value(ParameterId::Fixture(f, k)));
        scenario.touches[f].base_from_fixture * se3::exp(&xi)
    }

    /// True distance (m) of the two fixtures of the distance `k`, an index into
    /// [`Scenario::distances`]. Panics if there is no such distance, or it names a touch that there
    /// is not.
    pub fn distance(&self, scenario: &Scenario, k: usize) -> f64 {
        let (first, second) = scenario.distances[k].between;
        let origin = |f: usize| self.base_from_fixture(scenario, f).translation.vector;
        (origin(second) - origin(first)).norm()
    }

    /// The same distance (m) as it is measured: with its error. Panics as
    /// [`distance`](Truth::distance).
    pub fn measured_distance(&self, scenario: &Scenario, k: usize) -> f64 {
        self.distance(scenario, k) + self.distance_error.get(k).copied().unwrap_or(0.0)
    }

    /// True pose of the tool frame in the tip link's frame (m): that of `scenario` with the error
    /// of the tool.
    pub fn tip_from_tool(&self, scenario: &Scenario) -> Pose {
        scenario.tip_from_tool * se3::exp(&Twist::from_fn(|k, _| self.value(ParameterId::tool(k))))
    }

    /// Errors of the measured wrench.
    pub(super) fn wrench_errors(&self) -> WrenchErrors {
        let bias = std::array::from_fn(|k| self.value(ParameterId::WrenchBias(k)));
        WrenchErrors { bias, scale: self.value(ParameterId::WrenchScale) }
    }

    /// Trend of each moving joint's encoder offset, and the standard deviation of its random walk
    /// (rad).
    pub(super) fn encoder_changes(&self, scenario: &Scenario) -> Vec<(f64, f64)> {
        let mut changes = vec![(0.0, 0.0); scenario.robot.dof()];
        for i in turning_joints(&scenario.robot) {
            changes[i] = (self.value(ParameterId::JointTrend(i)), scenario.recorder.encoder_walk);
        }
        changes
    }

    /// Terms of the error of each moving joint's encoder that depend on the position, with their
    /// amplitudes (rad, or 1 for a gear ratio).
    pub(super) fn encoder_terms(&self, dof: usize) -> Vec<Vec<(EncoderTerm, f64)>> {
        let of_joint = |i: usize| {
            let each = EncoderTerm::ALL.map(|term| (term, self.value(ParameterId::EncoderError(i, term))));
            each.into_iter().filter(|(_, amplitude)| *amplitude != 0.0).collect()
        };
        (0..dof).map(of_joint).collect()
    }

    /// How much wider (m per side) and deeper (m) the hole of touch `f` is than it is nominally.
    pub(super) fn shape_errors(&self, f: usize) -> [f64; 2] {
        [&self.clearance, &self.depth].map(|errors| errors.get(f).copied().unwrap_or(0.0))
    }

    /// Radius (m) by which edges at fixture `f` are rounder than nominally.
    pub(super) fn edge_wear(&self, scenario: &Scenario, f: usize) -> f64 {
        scenario.touches[f].edge_wear + self.value(ParameterId::EdgeRadius(f))
    }

    /// What tool and fixture `f` truly are. None if the hole does not survive its change.
    pub(super) fn parts(&self, scenario: &Scenario, f: usize) -> Option<Parts> {
        let [wider, deeper] = self.shape_errors(f);
        let unequal = self.unequal_clearance.get(f).copied().unwrap_or_default();
        let wear = self.edge_wear(scenario, f);
        match &scenario.touches[f].parts {
            Parts::PegInHole(parts) if [wider, deeper, unequal[0], unequal[1], wear] != [0.0; 5] => {
                let further =
                    |normal: &Vector2<f64>| wider + unequal[0] * normal.x.powi(2) + unequal[1] * normal.y.powi(2);
                let hole = parts.hole().offset_mitred_by(further).ok()?;
                let EdgeRadii { peg, hole: rim } = parts.edge_radii();
                let parts = parts.with_hole(hole, parts.depth() + deeper).ok()?;
                let parts = parts.with_edge_radii(EdgeRadii { peg: peg + wear, hole: rim + wear }).ok()?;
                Some(Parts::PegInHole(Box::new(parts)))
            }
            parts => Some(parts.clone()),
        }
    }

    /// The erroneous parameters with names and units, and their values (SI), in the order: strain,
    /// segment strains, encoder offsets, joint origins, compliances, backlashes, tool, fixtures,
    /// edges, wrench, trends of encoder offsets, harmonics, gear ratios. Their priors are those of
    /// the parameters' constructors and say nothing about the truth. Drifts of placements and gap
    /// biases are left out.
    pub fn named(&self, scenario: &Scenario) -> Vec<(Parameter, f64)> {
        let robot = &scenario.robot;
        let mut known = of_arm_and_tool(robot);
        for (f, touch) in scenario.touches.iter().enumerate() {
            let prefix = format!("fixture.{}", touch.name);
            known.extend((0..6).map(|k| Parameter::twist(&prefix, ParameterId::Fixture(f, k), k)));
        }
        known.extend(scenario.touches.iter().enumerate().map(|(f, touch)| edge_radius(&touch.name, f)));
        known.extend((0..6).map(wrench_bias));
        known.push(wrench_scale());
        known.extend(joint_trend(robot));
        known.extend([joint_harmonic(robot), joint_harmonic_2(robot), joint_gear_ratio(robot)].concat());
        let given = |parameter: &Parameter| self.errors.iter().any(|(column, _)| *column == parameter.id);
        let value = |parameter: Parameter| {
            let value = self.value(parameter.id);
            (parameter, value)
        };
        known.into_iter().filter(given).map(value).collect()
    }
}

/// Indices of the moving joints that turn.
fn turning_joints(robot: &Robot) -> impl Iterator<Item = usize> {
    robot.moving().enumerate().filter(|(_, joint)| joint.kind != JointKind::Prismatic).map(|(i, _)| i)
}

fn draw(distribution: Distribution, size: f64, chance: &mut Pcg64) -> f64 {
    match distribution {
        Distribution::Sign => {
            if chance.random_bool(0.5) {
                size
            } else {
                -size
            }
        }
        Distribution::Uniform => size * chance.random_range(-1.0..=1.0),
        Distribution::Normal => size * normal(chance),
    }
}

/// A common strain counts as part of each segment's where segments differ.
fn arm_errors(robot: &Robot, sizes: &ArmErrors, chance: &mut Pcg64) -> Vec<(ParameterId, f64)> {
    let mut one = |size: f64| draw(sizes.distribution, size, chance);
    let common = one(sizes.strain);
    let own: Vec<f64> = segments(robot).iter().map(|_| one(sizes.segment_strain)).collect();
    let mut errors = Vec::new();
    if sizes.segment_strain == 0.0 {
        errors.push((KinematicParameter::Strain.into(), common));
    } else {
        errors
            .extend(own.iter().enumerate().map(|(k, own)| (KinematicParameter::SegmentStrain(k).into(), common + own)));
    }
    for (i, _) in robot.moving().enumerate() {
        errors.push((KinematicParameter::JointOffset(i).into(), one(sizes.joint_offset)));
    }
    for (i, joint) in robot.moving().enumerate() {
        let turns = joint.kind != JointKind::Prismatic;
        for k in 0..6 {
            let size = match k {
                0..3 => sizes.origin_length,
                _ if turns && joint.axis[k - 3].abs() > 0.5 => sizes.origin_zero,
                _ => sizes.origin_angle,
            };
            errors.push((KinematicParameter::JointOrigin(i, k).into(), one(size)));
        }
        let compliance = if turns { sizes.joint_compliance } else { 0.0 };
        errors.push((KinematicParameter::JointCompliance(i).into(), compliance));
        errors.push((KinematicParameter::JointBacklash(i).into(), sizes.joint_backlash));
    }
    errors
}

/// Harmonics and gear ratios of encoders; sizes of 0 draw nothing.
fn encoder_errors(robot: &Robot, sizes: &ArmErrors, chance: &mut Pcg64) -> Vec<(ParameterId, f64)> {
    let blocks = [
        (joint_harmonic(robot), sizes.joint_harmonic),
        (joint_harmonic_2(robot), sizes.joint_harmonic_2),
        (joint_gear_ratio(robot), sizes.joint_gear_ratio),
    ];
    let drawn = blocks
        .into_iter()
        .filter(|(_, size)| *size > 0.0)
        .flat_map(|(block, size)| block.into_iter().map(move |parameter| (parameter.id, size)));
    drawn.map(|(id, size)| (id, draw(sizes.distribution, size, chance))).collect()
}

/// Bias and relative error of the scale of the measured wrench.
fn wrench_errors(recorder: &Recorder, chance: &mut Pcg64) -> Vec<(ParameterId, f64)> {
    let sigma = |k: usize| if k < 3 { recorder.force_bias } else { recorder.torque_bias };
    let mut errors: Vec<_> = (0..6).map(|k| (ParameterId::WrenchBias(k), sigma(k) * normal(chance))).collect();
    errors.push((ParameterId::WrenchScale, recorder.wrench_scale * normal(chance)));
    errors
}

fn place_error(
    error: PlaceError,
    chance: &mut Pcg64,
    column: impl Fn(usize) -> ParameterId,
) -> Vec<(ParameterId, f64)> {
    (0..6).map(|k| (column(k), normal(chance) * if k < 3 { error.length } else { error.angle })).collect()
}

fn sum(errors: &[(ParameterId, f64)]) -> Twist {
    Twist::from_fn(|k, _| errors[k].1)
}

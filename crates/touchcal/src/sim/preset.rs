//! Scenarios by name.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};

use super::equilibrium::Stiffness;
use super::exploration::Exploration;
use super::recorder::Recorder;
use super::scenario::{ArmErrors, Distribution, PlaceError, Scenario, Thermal, Touch};
use crate::geometry::{Parts, Polygon, PolygonError, PrismPair, PrismPairError};
use crate::robot::Robot;
use crate::se3::Pose;

const DEG: f64 = std::f64::consts::PI / 180.0;
const MM: f64 = 1e-3;
/// Joint positions (rad) about which an iiwa 14 works.
const POSTURE: [f64; 7] = [0.0, 0.73, 0.26, -1.56, -0.23, 0.87, -0.02];
/// Coefficients of expansion (1/K) of an aluminium alloy and of a laminate of carbon fibre.
const ALUMINIUM: f64 = 23e-6;
const CFRP: f64 = 2e-6;
/// Coefficient of friction of machined metal on metal, lubricated.
const FRICTION: f64 = 0.1;
/// Distance of two sockets of a block (m).
const SPACING: f64 = 50.0 * MM;

/// Why the shapes of tool and fixture are not valid, see [`Preset::scenario`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PartsError {
    /// The outline of a peg or hole is not valid.
    #[error(transparent)]
    Polygon(#[from] PolygonError),
    /// Peg and hole do not form a valid pair.
    #[error(transparent)]
    Extrusion(#[from] PrismPairError),
}

/// A built-in scenario. All are of an iiwa 14, and differ in its possible errors and in what it
/// touches. Unless the preset says otherwise, a 25 mm T-slot extrusion explores a hole of 1.0 mm
/// clearance, 30 mm deep, until the log has 3000 contacts.
///
/// [`Preset::Paper`] alone is exact and without friction, recorded at 300 Hz. The others have
/// friction of 0.1. Those with a peg are recorded at 100 Hz, each trial along a path of its own on
/// which the peg leaves the hole by 8 mm between presses, and have form errors of 0.01 mm, a tool
/// mounted to 0.05 mm and 0.02°, a hole as wide and as deep as declared to 0.02 mm, along x and y
/// wider by another 0.01 mm each, edges worn by 0.05 mm, and a force sensor with a noise of 0.2 N
/// (standard deviations) and a filter with a time constant of 10 ms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// The experiment of Negi, Manyar & Gupta (2025, arXiv 2506.17458): strain ±0.05, encoder
    /// biases ±5°, of either sign with equal probability; parts and places exact.
    Paper,
    /// An aluminium arm in low Earth orbit, its temperature recorded: strain within ±0.003, ±0.001
    /// on top of it for each segment, encoder biases within ±0.1°, all uniform; the hole's pose
    /// known to 0.1 mm and 0.02° (standard deviations).
    LeoAluminium,
    /// An arm of carbon fibre in low Earth orbit, its temperature recorded: strain within ±2e-4,
    /// encoder biases within ±0.02°, both uniform; the hole's pose known to 0.1 mm and 0.02°
    /// (standard deviations).
    LeoCfrp,
    /// A cell in a hall: no strain, encoder biases within ±0.3°, uniform; the hole's pose known to
    /// 1 mm and 0.2° (standard deviations).
    Workcell,
    /// The set-up of the MUKCa project (arXiv 2503.12584): a ball in two sockets 50 mm apart, three
    /// placements of their block, poses unknown, 30 contacts with each socket at 2 Hz; joint
    /// origins off by 0.5 mm and 0.1°, encoder zeros by 0.5°, the ball's place by 2 mm (standard
    /// deviations).
    Mukca,
}

impl Preset {
    /// All presets, in the order of their definition.
    pub const ALL: [Preset; 5] =
        [Preset::Paper, Preset::LeoAluminium, Preset::LeoCfrp, Preset::Workcell, Preset::Mukca];

    /// Name in files and arguments: `paper`, `leo_aluminium`, `leo_cfrp`, `workcell`, `mukca`.
    pub fn name(self) -> &'static str {
        match self {
            Preset::Paper => "paper",
            Preset::LeoAluminium => "leo_aluminium",
            Preset::LeoCfrp => "leo_cfrp",
            Preset::Workcell => "workcell",
            Preset::Mukca => "mukca",
        }
    }

    /// The scenario with `robot` as its nominal arm, which must be an iiwa 14: the postures, of
    /// seven joint positions, are its own. This is not checked.
    ///
    /// # Errors
    /// If the parts are not valid, which does not happen for the built-in ones.
    pub fn scenario(self, robot: Robot) -> Result<Scenario, PartsError> {
        let mut scenario = in_hole(robot)?;
        let (uniform, none) = (Distribution::Uniform, ArmErrors::NONE);
        scenario.errors = match self {
            Preset::Paper => {
                ArmErrors { distribution: Distribution::Sign, strain: 0.05, joint_offset: 5.0 * DEG, ..none }
            }
            Preset::LeoAluminium => ArmErrors {
                distribution: uniform,
                strain: 0.003,
                segment_strain: 0.001,
                joint_offset: 0.1 * DEG,
                ..none
            },
            Preset::LeoCfrp => ArmErrors { distribution: uniform, strain: 2e-4, joint_offset: 0.02 * DEG, ..none },
            Preset::Workcell => ArmErrors { distribution: uniform, joint_offset: 0.3 * DEG, ..none },
            Preset::Mukca => ArmErrors {
                distribution: Distribution::Normal,
                origin_length: 0.5 * MM,
                origin_angle: 0.1 * DEG,
                origin_zero: 0.5 * DEG,
                ..none
            },
        };
        let thermal = |expansion| Some(Thermal { expansion, reference: 20.0, sensor_sigma: 0.1 });
        let surveyed = PlaceError { length: 0.1 * MM, angle: 0.02 * DEG };
        match self {
            Preset::Paper => return Ok(scenario),
            Preset::LeoAluminium => {
                scenario.thermal = thermal(ALUMINIUM);
                with_tolerances(&mut scenario, surveyed);
            }
            Preset::LeoCfrp => {
                scenario.thermal = thermal(CFRP);
                with_tolerances(&mut scenario, surveyed);
            }
            Preset::Workcell => with_tolerances(&mut scenario, PlaceError { length: 1.0 * MM, angle: 0.2 * DEG }),
            Preset::Mukca => in_sockets(&mut scenario),
        }
        scenario.friction = FRICTION;
        Ok(scenario)
    }
}

/// A 25 mm T-slot extrusion explores a hole of 1.0 mm clearance, 30 mm deep, at 300 Hz, contact
/// above 3 N, by an arm without errors.
fn in_hole(robot: Robot) -> Result<Scenario, PartsError> {
    let peg = Polygon::extrusion25();
    let hole = peg.offset_mitred(0.5 * MM)?;
    let turned = UnitQuaternion::from_quaternion(Quaternion::new(0.0, 0.0, 1.0, 0.0));
    let yaw = UnitQuaternion::from_euler_angles(0.0, 0.0, 20.0 * DEG);
    let known = PlaceError::default();
    Ok(Scenario {
        robot,
        errors: ArmErrors::NONE,
        tip_from_tool: Pose::from_parts(Translation3::new(0.0, 0.0, 150.0 * MM), turned),
        tool_error: known,
        touches: vec![Touch {
            name: "hole".to_owned(),
            base_from_fixture: Pose::from_parts(Translation3::new(600.0 * MM, 100.0 * MM, 150.0 * MM), yaw),
            place_error: known,
            free: false,
            parts: Parts::PegInHole(Box::new(PrismPair::new(peg, 40.0 * MM, hole, 30.0 * MM)?)),
            clearance_sigma: 0.0,
            depth_sigma: 0.0,
            unequal_clearance_sigma: 0.0,
            edge_wear: 0.0,
            edge_radius_sigma: 0.0,
            postures: vec![POSTURE.to_vec()],
            exploration: Exploration {
                radius: 4.0 * MM,
                tilt: 5.0 * DEG,
                press: 6.0 * MM,
                lift: 0.0,
                swing: 6.0 * DEG,
                pace: 1.0,
                random_phases: false,
            },
        }],
        distances: Vec::new(),
        contacts: 3000,
        // Forces of 5 to 20 N from a few mm and degrees of overlap.
        stiffness: Stiffness { translation: 3000.0, rotation: 50.0 },
        friction: 0.0,
        contact_sigma: 0.005 * MM,
        recorder: Recorder { encoder_sigma: 0.002 * DEG, ..Recorder::exact(300.0, 3.0) },
        thermal: None,
    })
}

/// Gives parts form errors, tool and hole tolerances, the hole's place this one, each trial its own
/// path, and the force sensor noise and a filter.
fn with_tolerances(scenario: &mut Scenario, place_error: PlaceError) {
    scenario.contact_sigma = 0.01 * MM;
    scenario.tool_error = PlaceError { length: 0.05 * MM, angle: 0.02 * DEG };
    for touch in &mut scenario.touches {
        touch.place_error = place_error;
        touch.clearance_sigma = 0.02 * MM;
        touch.depth_sigma = 0.02 * MM;
        touch.unequal_clearance_sigma = 0.01 * MM;
        touch.edge_radius_sigma = 0.05 * MM;
        touch.exploration.lift = 8.0 * MM;
        touch.exploration.random_phases = true;
    }
    scenario.recorder.rate = 100.0;
    scenario.recorder.force_sigma = 0.2;
    scenario.recorder.force_lag = 0.01;
}

/// A ball in two sockets, placed in front, to the left and to the right.
fn in_sockets(scenario: &mut Scenario) {
    let Some(hole) = scenario.touches.pop() else { return };
    let placements: [(&str, f64, f64, f64); 3] =
        [("front", 550.0, 0.0, 150.0), ("left", 400.0, 400.0, 250.0), ("right", 450.0, -350.0, 100.0)];
    for (name, x, y, z) in placements {
        for (number, along) in [(0, 0.0), (1, SPACING)] {
            let mut posture = POSTURE.to_vec();
            posture[0] += (y / x).atan();
            scenario.touches.push(Touch {
                name: format!("{name}/{number}"),
                base_from_fixture: Pose::translation(x * MM + along, y * MM, z * MM),
                free: true,
                parts: Parts::BallInSocket,
                postures: vec![posture],
                exploration: Exploration {
                    radius: 0.0,
                    tilt: 30.0 * DEG,
                    press: 10.0 * MM,
                    lift: 0.0,
                    swing: 20.0 * DEG,
                    pace: 1.0,
                    random_phases: false,
                },
                ..hole.clone()
            });
        }
    }
    scenario.tool_error = PlaceError { length: 2.0 * MM, angle: 0.0 };
    scenario.contacts = 30;
    scenario.contact_sigma = 0.05 * MM;
    scenario.recorder.rate = 2.0;
}

//! The simulated experiment: that of the paper, peg in hole with an arm of wrong lengths and encoder zeros.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use touchcal::geometry::extrusion::PegAndHole;
use touchcal::geometry::profile::Profile;
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::Column;
use touchcal::se3::Pose;
use touchcal::sim::{Compliance, Exploration, Insertion};

use crate::command::Failure;

/// True strain of the links.
pub const STRAIN: f64 = 0.05;
/// Size of every true encoder bias (rad).
const OFFSET: f64 = 5.0 * DEG;
const DEG: f64 = std::f64::consts::PI / 180.0;
const MM: f64 = 1e-3;
/// Joint positions about which the arm works (rad).
const POSTURE: [f64; 7] = [0.0, 0.73, 0.26, -1.56, -0.23, 0.87, -0.02];
/// Forces of 5 to 60 N from a few mm and degrees of overlap.
const COMPLIANCE: Compliance = Compliance { translation: 3000.0, rotation: 30.0, contact: 5e6 };
/// What form errors and deflection add to each contact (m).
const CONTACT_SIGMA: f64 = 0.005 * MM;
const EXPLORATION: Exploration = Exploration { radius: 2.0 * MM, tilt: 2.5 * DEG, swing: 6.0 * DEG, rate: 300.0 };

/// A simulation and its truth.
pub struct Experiment {
    /// What is simulated.
    pub insertion: Insertion,
    /// True encoder biases (rad).
    pub offsets: Vec<f64>,
    /// What the biases' signs and the noise come from.
    pub seed: u64,
}

impl Experiment {
    /// The experiment with encoder biases of ±5°, signs drawn from `seed`. The same numbers stand in `problem.toml`.
    pub fn new(seed: u64) -> Result<Self, Failure> {
        let robot = urdf::read_builtin("iiwa14", Ends::default())?.robot;
        let mut chance = Pcg64::seed_from_u64(seed);
        let offsets: Vec<f64> =
            robot.moving().map(|_| if chance.random_bool(0.5) { OFFSET } else { -OFFSET }).collect();
        let biases = offsets.iter().enumerate().map(|(i, &offset)| (Column::JointOffset(i), offset));
        let errors = std::iter::once((Column::Strain, STRAIN)).chain(biases).collect();
        let peg = Profile::extrusion25();
        let hole = peg.offset_mitred(0.5 * MM).map_err(|error| Failure::Setup(error.to_string()))?;
        let parts = PegAndHole::new(peg, 40.0 * MM, hole, 30.0 * MM);
        let turned = UnitQuaternion::from_quaternion(Quaternion::new(0.0, 0.0, 1.0, 0.0));
        let yaw = UnitQuaternion::from_euler_angles(0.0, 0.0, 20.0 * DEG);
        let insertion = Insertion {
            robot,
            errors,
            tip_from_peg: Pose::from_parts(Translation3::new(0.0, 0.0, 150.0 * MM), turned),
            base_from_hole: Pose::from_parts(Translation3::new(600.0 * MM, 100.0 * MM, 150.0 * MM), yaw),
            parts: parts.map_err(|error| Failure::Setup(error.to_string()))?,
            posture: POSTURE.to_vec(),
            compliance: COMPLIANCE,
            exploration: EXPLORATION,
            encoder_sigma: 0.002 * DEG,
            contact_sigma: CONTACT_SIGMA,
            force_threshold: 3.0,
        };
        Ok(Experiment { insertion, offsets, seed })
    }
}

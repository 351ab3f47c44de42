//! The experiment of Negi, Manyar & Gupta (2025, arXiv 2506.17458), simulated.

use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::geometry::extrusion::{ExtrusionError, PegAndHole};
use crate::geometry::profile::{Profile, ProfileError};
use crate::robot::{Column, Robot};
use crate::se3::Pose;
use crate::sim::{Compliance, Exploration, Insertion};

const DEG: f64 = std::f64::consts::PI / 180.0;
const MM: f64 = 1e-3;
/// Size of the true strain of the links.
pub const PAPER_STRAIN: f64 = 0.05;
/// Size of every true encoder bias (rad).
pub const PAPER_OFFSET: f64 = 5.0 * DEG;
/// Joint positions about which the arm works (rad).
const POSTURE: [f64; 7] = [0.0, 0.73, 0.26, -1.56, -0.23, 0.87, -0.02];
/// Forces of 5 to 60 N from a few mm and degrees of overlap.
const COMPLIANCE: Compliance = Compliance { translation: 3000.0, rotation: 30.0, contact: 5e6 };
/// What form errors and deflection add to each contact (m).
const CONTACT_SIGMA: f64 = 0.005 * MM;
const EXPLORATION: Exploration = Exploration { radius: 2.0 * MM, tilt: 2.5 * DEG, swing: 6.0 * DEG, rate: 300.0 };

/// Parts that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PartsError {
    /// An outline.
    #[error(transparent)]
    Profile(#[from] ProfileError),
    /// Peg and hole together.
    #[error(transparent)]
    Extrusion(#[from] ExtrusionError),
}

/// A 25 mm T-slot extrusion on an iiwa 14 (`robot`) that explores a hole of 1.0 mm clearance, 30 mm deep, at 300 Hz, contact above 3 N. All links
/// are strained by +[`PAPER_STRAIN`]; every encoder is off by [`PAPER_OFFSET`], its sign drawn from `seed`.
///
/// # Errors
/// If the parts cannot be made, which these can.
pub fn paper(robot: Robot, seed: u64) -> Result<Insertion, PartsError> {
    let mut chance = Pcg64::seed_from_u64(seed);
    let mut signed = |size: f64| if chance.random_bool(0.5) { size } else { -size };
    let biases = robot.moving().enumerate().map(|(i, _)| (Column::JointOffset(i), signed(PAPER_OFFSET)));
    let errors = std::iter::once((Column::Strain, PAPER_STRAIN)).chain(biases).collect();
    let peg = Profile::extrusion25();
    let hole = peg.offset_mitred(0.5 * MM)?;
    let turned = UnitQuaternion::from_quaternion(Quaternion::new(0.0, 0.0, 1.0, 0.0));
    let yaw = UnitQuaternion::from_euler_angles(0.0, 0.0, 20.0 * DEG);
    Ok(Insertion {
        robot,
        errors,
        tip_from_peg: Pose::from_parts(Translation3::new(0.0, 0.0, 150.0 * MM), turned),
        base_from_hole: Pose::from_parts(Translation3::new(600.0 * MM, 100.0 * MM, 150.0 * MM), yaw),
        parts: PegAndHole::new(peg, 40.0 * MM, hole, 30.0 * MM)?,
        posture: POSTURE.to_vec(),
        compliance: COMPLIANCE,
        exploration: EXPLORATION,
        encoder_sigma: 0.002 * DEG,
        contact_sigma: CONTACT_SIGMA,
        force_threshold: 3.0,
    })
}

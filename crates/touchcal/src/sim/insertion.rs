//! A contact-rich insertion: an arm with wrong kinematics explores a hole with a peg and logs what its encoders say.

use nalgebra::Translation3;
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use std::f64::consts::TAU;

use super::equilibrium::Compliance;
use super::inverse_kinematics::follow;
use crate::geometry::extrusion::PegAndHole;
use crate::robot::{Column, Kinematics, Robot};
use crate::se3::{self, Pose, Twist};

/// How the peg is commanded to move about the hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exploration {
    /// Radius of the spiral in x and y (m).
    pub radius: f64,
    /// Amplitude of the rotations about all three axes (rad).
    pub tilt: f64,
    /// Amplitude of the redundant swing of the arm about its posture (rad).
    pub swing: f64,
    /// Rows per second.
    pub rate: f64,
}

/// An insertion to simulate.
#[derive(Clone, Debug)]
pub struct Insertion {
    /// The arm as its maker drew it.
    pub robot: Robot,
    /// What is wrong with it.
    pub errors: Vec<(Column, f64)>,
    /// The peg's place on the tip.
    pub tip_from_peg: Pose,
    /// The hole's place in base.
    pub base_from_hole: Pose,
    /// Peg and hole.
    pub parts: PegAndHole,
    /// Joint positions (rad or m) near which to work.
    pub posture: Vec<f64>,
    /// How the arm yields.
    pub compliance: Compliance,
    /// How it explores.
    pub exploration: Exploration,
    /// Standard deviation of the encoders (rad).
    pub encoder_sigma: f64,
    /// Standard deviation of what the contact itself adds (m): the peg is logged so much off where it rests, along the contact's normal.
    pub contact_sigma: f64,
    /// Force above which a row counts as contact (N).
    pub force_threshold: f64,
}

/// What a simulated arm logged in contact.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InsertionLog {
    /// Seconds since the start, for each contact.
    pub time: Vec<f64>,
    /// Measured joint positions of each contact (rad or m).
    pub q: Vec<Vec<f64>>,
    /// Contact force (N).
    pub force: Vec<f64>,
}

/// Why a simulation cannot run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimulationError {
    /// The arm does not reach the hole.
    #[error(
        "the arm cannot reach the hole: no joint positions put the peg there from the posture given, {time:.2} s after the start"
    )]
    OutOfReach {
        /// Seconds since the start.
        time: f64,
    },
    /// The exploration hardly ever touches.
    #[error("expected contacts, found only {found} in {rows} rows: widen the exploration or lower the force threshold")]
    NoContact {
        /// Contacts found.
        found: usize,
        /// Rows simulated.
        rows: usize,
    },
}

/// Rows simulated for each contact wanted before giving up.
const PATIENCE: usize = 20;

impl Insertion {
    /// Simulates until `contacts` contacts are logged. The same seed gives the same log on any machine.
    ///
    /// # Errors
    /// If the arm cannot reach the hole, or touches too rarely.
    pub fn run(&self, contacts: usize, seed: u64) -> Result<InsertionLog, SimulationError> {
        let (columns, values): (Vec<Column>, Vec<f64>) = self.errors.iter().copied().unzip();
        // The kinematics of the true arm: driven by what its encoders say, as the real one is.
        let mut arm = Kinematics::new(&self.robot, &columns, self.tip_from_peg);
        arm.set(&values);
        let mut chance = Pcg64::seed_from_u64(seed);
        let mut log = InsertionLog::default();
        let mut hole_from_peg = Pose::translation(0.0, 0.0, 1e-3);
        let mut q = self.posture.clone();
        let mut row = 0;
        while log.q.len() < contacts {
            let time = row as f64 / self.exploration.rate;
            let (pose, force) = self.compliance.rest(&self.parts, &self.command(time), hole_from_peg);
            hole_from_peg = pose;
            let posture = self.swung(time);
            let standard: f64 = StandardNormal.sample(&mut chance);
            let off = self.parts.gap(&pose).normal_in_hole * (self.contact_sigma * standard);
            let logged = Translation3::from(off) * pose;
            q = follow(&arm, &(self.base_from_hole * logged), &q, &posture)
                .ok_or(SimulationError::OutOfReach { time })?;
            let noise: Vec<f64> = q.iter().map(|_| StandardNormal.sample(&mut chance)).collect();
            if force > self.force_threshold {
                log.time.push(time);
                log.q.push(q.iter().zip(noise).map(|(q, noise)| q + self.encoder_sigma * noise).collect());
                log.force.push(force);
            }
            row += 1;
            if row > PATIENCE * contacts.max(100) {
                return Err(SimulationError::NoContact { found: log.q.len(), rows: row });
            }
        }
        Ok(log)
    }

    /// The commanded pose: a spiral in x and y, three rotations out of step, and a press that goes in and out of the hole.
    fn command(&self, time: f64) -> Pose {
        let Exploration { radius, tilt, .. } = self.exploration;
        let wave = |hertz: f64, phase: f64| (TAU * (hertz * time + phase)).sin();
        let reach = radius * (0.6 + 0.4 * wave(0.31, 0.0));
        let depth = self.parts.depth() * (0.55 - 0.55 * wave(0.17, 0.25));
        let translation = Pose::translation(reach * wave(1.3, 0.25), reach * wave(1.3, 0.0), -depth);
        let rotation =
            Twist::new(0.0, 0.0, 0.0, tilt * wave(0.73, 0.1), tilt * wave(0.59, 0.4), tilt * wave(0.43, 0.7));
        translation * se3::exp(&rotation)
    }

    /// The posture, with every joint swung a little, neighbours in opposite directions.
    fn swung(&self, time: f64) -> Vec<f64> {
        let each = self.posture.iter().enumerate();
        each.map(|(i, &q)| {
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            q + sign * self.exploration.swing * (TAU * 0.11 * time).sin()
        })
        .collect()
    }
}

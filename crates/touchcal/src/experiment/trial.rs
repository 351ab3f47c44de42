//! A calibration with known true parameters.

use sha2::{Digest, Sha256};

use crate::contact::{ContactLog, Source};
use crate::estimate::{Fixture, Loss, Method, Noise, PlacePrior, Problem, ShapeTolerance, Tool};
use crate::manifold::ContactManifold;
use crate::parameter::{Block, ParameterId, joint_offset, kinematic_part, strain};
use crate::robot::{Robot, calibrated};
use crate::se3::Pose;
use crate::sim::{self, Scenario, SimulationError};

/// A calibration with known truth: contacts of a peg with a hole, both at known poses, by an arm
/// with known errors. Made by [`Trial::simulated`] or read by
/// [`trial_folder`](crate::io::trial_folder).
#[derive(Clone, Debug)]
pub struct Trial {
    /// Name, unique among trials that are compared.
    pub name: String,
    /// SHA-256, in hexadecimal, of the joint positions of the simulated contacts, or of the files
    /// that contacts and truth were read from.
    pub origin: String,
    /// The nominal arm, without the errors.
    pub robot: Robot,
    /// Pose of the peg's frame in the tip link's frame (m).
    pub tip_from_peg: Pose,
    /// Pose of the hole's frame in base (m).
    pub base_from_hole: Pose,
    /// The contacts, all with fixture index 0.
    pub contacts: ContactLog,
    /// True errors of the arm: parameters and their values (SI), each once; parameters that are not
    /// listed are 0. A calibration does not read them.
    pub truth: Vec<(ParameterId, f64)>,
}

/// Optimizer, declared noise and loss of a trial's calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Optimizer of the calibration ([`Problem::method`]).
    pub method: Method,
    /// Noise that the contacts are declared to have ([`Problem::noise`]).
    pub noise: Noise,
    /// Robust loss ([`Problem::loss`]), used by Levenberg–Marquardt only.
    pub loss: Loss,
}

/// Mean absolute errors of estimated strains and encoder offsets, from [`Trial::error`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrialError {
    /// Absolute error of the common strain (1); 0 if the strain is not listed in [`Trial::truth`].
    pub strain: f64,
    /// Mean absolute error of the encoder offsets (rad, or m for prismatic joints) that are listed
    /// in [`Trial::truth`]; 0 if none is.
    pub offset: f64,
}

/// SHA-256 of all joint positions, in hexadecimal.
fn fingerprint(contacts: &ContactLog) -> String {
    let mut hasher = Sha256::new();
    (0..contacts.len()).flat_map(|i| contacts.q(i)).for_each(|q| hasher.update(q.to_le_bytes()));
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Trial {
    /// Simulates `scenario` with `seed` and takes the rows recorded as contacts with its first
    /// fixture, which must be a hole: this is not checked. Peg and hole are where the scenario
    /// says, so neither should err there; loads are left out. The trial's name is `seed_{seed}`;
    /// without fixtures it has no contacts.
    ///
    /// # Errors
    /// If the scenario cannot be simulated, see [`simulate`](crate::sim::simulate()).
    pub fn simulated(scenario: &Scenario, seed: u64) -> Result<Trial, SimulationError> {
        let simulated = sim::simulate(scenario, seed)?;
        let mut contacts = ContactLog::new(scenario.robot.dof());
        if let Some(log) = simulated.logs.first() {
            log.contacts().for_each(|row| contacts.push(log.q(row), 0, Source { file: 0, line: row as u64 + 1 }));
        }
        Ok(Trial {
            name: format!("seed_{seed}"),
            origin: fingerprint(&contacts),
            robot: scenario.robot.clone(),
            tip_from_peg: scenario.tip_from_tool,
            base_from_hole: scenario.touches.first().map_or_else(Pose::identity, |touch| touch.base_from_fixture),
            contacts,
            truth: simulated.truth.errors,
        })
    }

    /// The problem of estimating the common strain and the encoder offsets, without priors, with
    /// known poses of peg and hole (fixture `hole`), the contact model `manifold`, and noise,
    /// optimizer and loss of `search`.
    pub fn problem(&self, manifold: Box<dyn ContactManifold>, search: Search) -> Problem {
        let mut parameters = vec![strain()];
        parameters.extend(joint_offset(&self.robot));
        let fixture = Fixture {
            name: "hole".to_owned(),
            manifold: manifold.into(),
            base_from_fixture: Some(self.base_from_hole),
            prior: PlacePrior::Fixed,
            tolerance: ShapeTolerance::EXACT,
            placement: String::new(),
        };
        let tool = Tool { tip_from_tool: self.tip_from_peg, prior: PlacePrior::Fixed };
        Problem {
            noise: search.noise,
            parameters,
            method: search.method,
            loss: search.loss,
            ..Problem::new(self.robot.clone(), tool, vec![fixture], self.contacts.clone())
        }
    }

    /// The nominal arm with the true errors applied, see [`calibrated`]; those of the tool are left
    /// out.
    pub fn true_robot(&self) -> Robot {
        let (parameters, values) = kinematic_part(self.truth.iter().copied());
        calibrated(&self.robot, &parameters, &values)
    }

    /// Mean absolute errors of strain and encoder offsets against the truth; `estimate(id)` is the
    /// estimated value of a parameter (SI), and `None` counts as 0. Parameters that the truth does
    /// not list, and those of other blocks, do not count.
    pub fn error(&self, estimate: impl Fn(ParameterId) -> Option<f64>) -> TrialError {
        let mut error = TrialError::default();
        let offsets = self.truth.iter().filter(|(id, _)| id.block() == Block::JointOffset).count();
        for &(id, truth) in &self.truth {
            let size = (estimate(id).unwrap_or(0.0) - truth).abs();
            match id.block() {
                Block::Strain => error.strain += size,
                Block::JointOffset => error.offset += size / offsets.max(1) as f64,
                _ => {}
            }
        }
        error
    }
}

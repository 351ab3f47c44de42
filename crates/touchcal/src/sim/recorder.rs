//! What writes a log: encoders, a force sensor, and what it takes for contact.

use nalgebra::Vector3;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::se3::Pose;

/// Temperature (°C) from which an arm warms up, and the time constants that a trial takes.
const COLD: f64 = 20.0;
const TIME_CONSTANTS: f64 = 3.0;

/// Encoders, force sensor and contact detection of a simulated recorder. Standard deviations are at
/// least 0, and 0 for none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recorder {
    /// Rows per second (Hz, > 0).
    pub rate: f64,
    /// Standard deviation of each encoder's noise in each row (rad, or m for a prismatic joint).
    pub encoder_sigma: f64,
    /// Quantisation step of the encoders (rad, or m for a prismatic joint; ≥ 0); 0 for none.
    pub encoder_step: f64,
    /// Standard deviation of the linear trend of each turning joint's encoder offset, drawn once a
    /// trial: minus the trend at the first contact, plus the trend at the last (rad). It is linear
    /// in the number of the contact, or in the temperature of an arm that warms up.
    pub encoder_trend: f64,
    /// Temperature (K, ≥ 0) by which the arm warms up from 20 °C over the contacts of a trial, with
    /// a time constant of a third of these. It is recorded if above 0.
    pub warm_up: f64,
    /// Standard deviation of the change of each turning joint's encoder offset from the first to
    /// the last contact by a random walk, whose mean over all contacts is zero (rad).
    pub encoder_walk: f64,
    /// Time constant (s, ≥ 0) of the force sensor's first-order low-pass filter, 0 for none. With
    /// it, rows just after the end of a contact count as contacts, and rows just after its
    /// beginning do not.
    pub force_lag: f64,
    /// Standard deviation of the noise of each component of the force in each row (N).
    pub force_sigma: f64,
    /// Standard deviation of the noise of each component of the torque in each row (N m).
    pub torque_sigma: f64,
    /// Standard deviation of the bias of each component of the force, drawn once a trial (N).
    pub force_bias: f64,
    /// Standard deviation of the bias of each component of the torque, drawn once a trial (N m).
    pub torque_bias: f64,
    /// Standard deviation of the relative error of the wrench's scale, drawn once a trial (1).
    pub wrench_scale: f64,
    /// Standard deviation of the noise of each joint's measured torque in each row (N m, or N of a
    /// prismatic joint). Joint torques are recorded if it is above 0.
    pub joint_torque_sigma: f64,
    /// Magnitude of the measured force above which a row counts as contact (N, > 0).
    pub force_threshold: f64,
    /// Share (0 to below 1) of the rows measured as contact, spurious ones aside, that are recorded
    /// as free: with a force below the threshold.
    pub missed: f64,
    /// Share (0 to below 1) of the rows measured as contact in whose place contacts are recorded
    /// that are none: free poses close to the fixture, with a force above the threshold.
    pub spurious: f64,
}

impl Recorder {
    /// A recorder without noise, bias, quantisation of encoders, missed and spurious contacts, at
    /// `rate` rows per second (Hz, > 0), with contact above `force_threshold` (N, > 0). Wrenches
    /// are still rounded to [`WRENCH_DIGITS`].
    pub const fn exact(rate: f64, force_threshold: f64) -> Recorder {
        Recorder {
            rate,
            encoder_sigma: 0.0,
            encoder_step: 0.0,
            encoder_trend: 0.0,
            warm_up: 0.0,
            encoder_walk: 0.0,
            force_lag: 0.0,
            force_sigma: 0.0,
            torque_sigma: 0.0,
            force_bias: 0.0,
            torque_bias: 0.0,
            wrench_scale: 0.0,
            joint_torque_sigma: 0.0,
            force_threshold,
            missed: 0.0,
            spurious: 0.0,
        }
    }

    /// Temperature of the arm (°C) at contact `i` of so many, to its last digit.
    pub(super) fn temperature(&self, i: usize, contacts: usize) -> f64 {
        let warmth = 0.5 * (1.0 + self.trend_position(i.min(contacts.saturating_sub(1)), contacts));
        ((COLD + self.warm_up * warmth) * 1e3).round() / 1e3
    }

    /// How far trends are at contact `i` of so many: −1 at the first, 1 at the last.
    pub(super) fn trend_position(&self, i: usize, contacts: usize) -> f64 {
        let steps = contacts.saturating_sub(1).max(1) as f64;
        if self.warm_up == 0.0 {
            return 2.0 * i as f64 / steps - 1.0;
        }
        2.0 * (-TIME_CONSTANTS * i as f64 / steps).exp_m1() / (-TIME_CONSTANTS).exp_m1() - 1.0
    }

    /// A true joint position as its encoder counts it.
    pub(super) fn encoder(&self, q: f64, chance: &mut Pcg64) -> f64 {
        let read = q + self.encoder_sigma * normal(chance);
        if self.encoder_step > 0.0 { (read / self.encoder_step).round() * self.encoder_step } else { read }
    }

    /// Lag of the force sensor's filter (rows): what the filtered wrench lacks to the true one over
    /// its change since the row before.
    pub fn lag(&self) -> f64 {
        if self.force_lag > 0.0 { (self.rate * self.force_lag).recip().exp_m1().recip() } else { 0.0 }
    }

    /// One step of the sensor's filter: the filtered wrench of this row, from that of the row
    /// `before` and the true `wrench` of this row.
    pub(super) fn filtered(&self, before: [f64; 6], wrench: [f64; 6]) -> [f64; 6] {
        if self.force_lag == 0.0 {
            return wrench;
        }
        let share = -(-1.0 / (self.rate * self.force_lag)).exp_m1();
        std::array::from_fn(|k| before[k] + share * (wrench[k] - before[k]))
    }

    /// A true wrench as the sensor shows it, to its last digit.
    pub(super) fn wrench(&self, wrench: [f64; 6], errors: &WrenchErrors, chance: &mut Pcg64) -> [f64; 6] {
        std::array::from_fn(|k| {
            let sigma = if k < 3 { self.force_sigma } else { self.torque_sigma };
            to_last_digit((1.0 + errors.scale) * wrench[k] + errors.bias[k] + sigma * normal(chance))
        })
    }

    /// A true joint torque as it is measured, to its last digit.
    pub(super) fn joint_torque(&self, torque: f64, chance: &mut Pcg64) -> f64 {
        to_last_digit(torque + self.joint_torque_sigma * normal(chance))
    }

    /// Scales the force to one that detection takes for no contact, or for one: what a missed or a
    /// spurious contact looks like.
    pub(super) fn pretend(&self, touching: bool, mut wrench: [f64; 6], chance: &mut Pcg64) -> [f64; 6] {
        let size = force(&wrench);
        let share: f64 = chance.random();
        let wanted = self.force_threshold * if touching { 1.0 + share } else { 0.9 * share };
        if size > 0.0 {
            wrench.iter_mut().for_each(|part| *part = to_last_digit(*part * wanted / size));
        } else {
            wrench[2] = to_last_digit(wanted);
        }
        wrench
    }
}

/// Changes of the encoder offsets over a trial.
pub(super) struct EncoderChanges {
    dof: usize,
    /// For each contact one change of each joint's offset (rad); empty where offsets do not change.
    changes: Vec<f64>,
}

impl EncoderChanges {
    /// Of a trial of so many contacts: of each joint its trend, and a random walk of this standard
    /// deviation (rad), 0 for joints that have neither. `position` of a contact is how far trends
    /// are there, −1 to 1.
    pub(super) fn new(
        contacts: usize,
        joints: &[(f64, f64)],
        position: impl Fn(usize) -> f64,
        chance: &mut Pcg64,
    ) -> EncoderChanges {
        let dof = joints.len();
        if joints.iter().all(|joint| *joint == (0.0, 0.0)) {
            return EncoderChanges { dof, changes: Vec::new() };
        }
        let mut changes = vec![0.0; contacts * dof];
        for (j, &(trend, walk)) in joints.iter().enumerate() {
            for (i, walked) in random_walk(contacts, walk, chance).into_iter().enumerate() {
                changes[i * dof + j] = trend * position(i) + walked;
            }
        }
        EncoderChanges { dof, changes }
    }

    /// Change of joint `j`'s offset (rad) at contact `i`, or at the last one where there are fewer.
    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        let Some(last) = (self.changes.len() / self.dof.max(1)).checked_sub(1) else { return 0.0 };
        self.changes[i.min(last) * self.dof + j]
    }
}

/// A Gaussian random walk of `n` points, less its mean; `sigma` is the standard deviation of its
/// change from the first point to the last.
pub(crate) fn random_walk(n: usize, sigma: f64, chance: &mut Pcg64) -> Vec<f64> {
    let step = sigma / (n.saturating_sub(1).max(1) as f64).sqrt();
    let mut path: Vec<f64> = Vec::with_capacity(n);
    for _ in 0..n {
        let walked = path.last().copied().unwrap_or(0.0);
        path.push(walked + step * normal(chance));
    }
    let mean = path.iter().sum::<f64>() / n.max(1) as f64;
    path.iter_mut().for_each(|point| *point -= mean);
    path
}

/// Errors of the force sensor that are the same throughout a trial.
pub(super) struct WrenchErrors {
    /// What the sensor shows when nothing presses (N, N m).
    pub bias: [f64; 6],
    /// Relative error of the scale (1).
    pub scale: f64,
}

/// Number of decimal places to which the recorder rounds forces (N) and torques (N m) of
/// [`Log::wrench`](crate::sim::Log::wrench), enough to write its logs without loss.
pub const WRENCH_DIGITS: usize = 4;

fn to_last_digit(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// Size of a wrench's force (N).
pub(super) fn force(wrench: &[f64; 6]) -> f64 {
    Vector3::new(wrench[0], wrench[1], wrench[2]).norm()
}

/// The wrench `[f; τ]` of the tool frame about its origin, in the tip frame about the tip's.
pub(super) fn at_tip(tip_from_tool: &Pose, wrench: &crate::se3::Twist) -> [f64; 6] {
    let force = tip_from_tool.rotation * crate::se3::linear(wrench);
    let torque = tip_from_tool.rotation * crate::se3::angular(wrench) + tip_from_tool.translation.vector.cross(&force);
    [force.x, force.y, force.z, torque.x, torque.y, torque.z]
}

/// A standard normal number.
pub(super) fn normal(chance: &mut Pcg64) -> f64 {
    StandardNormal.sample(chance)
}

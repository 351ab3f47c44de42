//! How the tool is commanded to move about a fixture.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_pcg::Pcg64;

use crate::se3::{self, Pose, Twist};

/// Frequency of the press at a pace of 1 (Hz).
const PRESS_HERTZ: f64 = 0.17;

/// An exploration command, the pose of the tool in the fixture's frame that the arm is told to
/// take: a spiral in x and y, rotations out of step about all axes, and a press in and out along z.
/// The joints swing about their posture meanwhile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exploration {
    /// Largest radius of the spiral in x and y (m, ≥ 0); its smallest is a fifth of that.
    pub radius: f64,
    /// Amplitude of each component of the rotation vector, x, y and z (rad, ≥ 0).
    pub tilt: f64,
    /// Distance of the command beyond the deepest pose that the fixture allows (m, ≥ 0).
    pub press: f64,
    /// Height of the command's upper end above the pose in which an upright tool first touches
    /// (m, ≥ 0). Above 0 the tool leaves the fixture between presses.
    pub lift: f64,
    /// Amplitude of the swing of each joint about its posture (rad, or m for a prismatic joint;
    /// ≥ 0), neighbours in opposite directions. Only redundant joints follow it.
    pub swing: f64,
    /// Frequency of the motion over that of the built-in one (1, > 0): at 1 the spiral turns at
    /// 1.3 Hz, the press repeats at 0.17 Hz and the swing at 0.11 Hz.
    pub pace: f64,
    /// Whether spiral, rotations and swing have random phases, drawn in each trial: no two trials
    /// then follow the same path. Spiral and rotations grow from nothing during the first press, so
    /// that the tool enters whatever their phases. If not, all trials follow the same path, and
    /// share the errors that friction causes along it.
    pub random_phases: bool,
}

/// Phases of an exploration's motions (periods, 0 to 1), added to built-in ones.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Phases {
    /// Of the spiral's radius, and of its turns.
    reach: f64,
    turn: f64,
    /// Of the rotations about x, y and z.
    rotation: [f64; 3],
    /// Of the joints' swing.
    swing: f64,
}

impl Exploration {
    /// The phases of a trial.
    pub(super) fn phases(&self, chance: &mut Pcg64) -> Phases {
        if !self.random_phases {
            return Phases::default();
        }
        let mut drawn = || chance.random();
        Phases { reach: drawn(), turn: drawn(), rotation: [drawn(), drawn(), drawn()], swing: drawn() }
    }

    /// The commanded pose, `time` seconds after the start, over a fixture that is first touched at
    /// one height and goes down to another (m).
    pub(super) fn command(&self, phases: &Phases, time: f64, (top, bottom): (f64, f64)) -> Pose {
        let Exploration { press, lift, .. } = *self;
        let grown = if self.random_phases { (PRESS_HERTZ * self.pace * time).min(1.0) } else { 1.0 };
        let (radius, tilt) = (grown * self.radius, grown * self.tilt);
        let wave = |hertz: f64, phase: f64| self.wave(time, hertz, phase);
        let reach = radius * (0.6 + 0.4 * wave(0.31, phases.reach));
        let upper = top + lift;
        let below = (upper - bottom + press) * (0.5 - 0.5 * wave(PRESS_HERTZ, 0.25));
        let (x, y) = (wave(1.3, phases.turn + 0.25), wave(1.3, phases.turn));
        let translation = Pose::translation(reach * x, reach * y, upper - below);
        let [rx, ry, rz] = phases.rotation;
        let (rx, ry, rz) = (wave(0.73, rx + 0.1), wave(0.59, ry + 0.4), wave(0.43, rz + 0.7));
        let rotation = Twist::new(0.0, 0.0, 0.0, tilt * rx, tilt * ry, tilt * rz);
        translation * se3::exp(&rotation)
    }

    /// The posture, with every joint swung a little, neighbours in opposite directions.
    pub(super) fn swung(&self, phases: &Phases, posture: &[f64], time: f64, into: &mut [f64]) {
        let swing = self.swing * self.wave(time, 0.11, phases.swing);
        for (i, (joint, q)) in into.iter_mut().zip(posture).enumerate() {
            *joint = if i % 2 == 0 { q + swing } else { q - swing };
        }
    }

    fn wave(&self, time: f64, hertz: f64, phase: f64) -> f64 {
        (TAU * (hertz * self.pace * time + phase)).sin()
    }
}

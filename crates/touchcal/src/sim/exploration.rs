//! How the tool is commanded to move about a fixture.

use std::f64::consts::TAU;

use crate::se3::{self, Pose, Twist};

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
}

impl Exploration {
    /// The commanded pose, `time` seconds after the start, over a fixture that is first touched at
    /// one height and goes down to another (m).
    pub(super) fn command(&self, time: f64, (top, bottom): (f64, f64)) -> Pose {
        let Exploration { radius, tilt, press, lift, .. } = *self;
        let wave = |hertz: f64, phase: f64| self.wave(time, hertz, phase);
        let reach = radius * (0.6 + 0.4 * wave(0.31, 0.0));
        let upper = top + lift;
        let below = (upper - bottom + press) * (0.5 - 0.5 * wave(0.17, 0.25));
        let translation = Pose::translation(reach * wave(1.3, 0.25), reach * wave(1.3, 0.0), upper - below);
        let rotation =
            Twist::new(0.0, 0.0, 0.0, tilt * wave(0.73, 0.1), tilt * wave(0.59, 0.4), tilt * wave(0.43, 0.7));
        translation * se3::exp(&rotation)
    }

    /// The posture, with every joint swung a little, neighbours in opposite directions.
    pub(super) fn swung(&self, posture: &[f64], time: f64, into: &mut [f64]) {
        let swing = self.swing * self.wave(time, 0.11, 0.0);
        for (i, (joint, q)) in into.iter_mut().zip(posture).enumerate() {
            *joint = if i % 2 == 0 { q + swing } else { q - swing };
        }
    }

    fn wave(&self, time: f64, hertz: f64, phase: f64) -> f64 {
        (TAU * (hertz * self.pace * time + phase)).sin()
    }
}

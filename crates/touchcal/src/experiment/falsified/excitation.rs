//! How the arm moves in the trials.

use crate::robot::Robot;
use crate::sim::{PartsError, Preset, Scenario};

/// Amplitude (rad) of the elbow's swing in rich excitation.
const RICH_SWING: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// What is added to the third and the fifth joint's position (rad) for its postures: the elbow
/// turns about the line from shoulder to wrist.
const ELBOW: [f64; 4] = [-0.5, -0.15, 0.2, 0.5];
/// Contacts of a peg with its hole for which there is one with each socket.
const PEG_PER_SOCKET: usize = 100;
/// Least number of contacts with each socket.
const LEAST_PER_SOCKET: usize = 10;

/// How a simulated arm moves, and what it touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Excitation {
    /// [`Preset::Paper`]: a peg in a hole, one posture with little motion of the elbow.
    Paper,
    /// The same parts and errors with four elbow positions, and the elbow swinging by 20° about
    /// each.
    Rich,
    /// [`Preset::Mukca`] without friction: a ball in pairs of sockets at a known distance, three
    /// placements.
    Sockets,
}

impl Excitation {
    /// Name in files: `paper`, `rich`, `sockets`.
    pub fn name(self) -> &'static str {
        match self {
            Excitation::Paper => "paper",
            Excitation::Rich => "rich",
            Excitation::Sockets => "sockets",
        }
    }

    /// The scenario with `robot` as its nominal arm, which must be an iiwa 14 (not checked), with
    /// `contacts` contacts of a peg, or a hundredth of that (at least 10) with each socket.
    ///
    /// # Errors
    /// As of [`Preset::scenario`].
    pub fn scenario(self, robot: Robot, contacts: usize) -> Result<Scenario, PartsError> {
        let preset = if self == Excitation::Sockets { Preset::Mukca } else { Preset::Paper };
        let mut scenario = preset.scenario(robot)?;
        scenario.contacts = contacts;
        scenario.friction = 0.0;
        match self {
            Excitation::Paper => {}
            Excitation::Rich => {
                for touch in &mut scenario.touches {
                    touch.exploration.swing = RICH_SWING;
                    touch.postures = touch.postures.iter().flat_map(|posture| turned(posture)).collect();
                }
            }
            Excitation::Sockets => scenario.contacts = (contacts / PEG_PER_SOCKET).max(LEAST_PER_SOCKET),
        }
        Ok(scenario)
    }
}

/// The posture with the elbow at each of its positions.
fn turned(posture: &[f64]) -> impl Iterator<Item = Vec<f64>> {
    ELBOW.into_iter().map(|angle| {
        let mut turned = posture.to_vec();
        for (joint, q) in turned.iter_mut().enumerate() {
            match joint {
                2 => *q += angle,
                4 => *q -= angle,
                _ => {}
            }
        }
        turned
    })
}

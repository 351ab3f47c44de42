//! A ball held in sockets by an arm with known errors, whatever its joints bear.

use std::sync::Arc;

use nalgebra::{UnitQuaternion, Vector3};
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::{Fixture, PlacePrior, Problem, ShapeTolerance, Tool};
use touchcal::io::urdf::{self, Ends};
use touchcal::manifold::BallInSocket;
use touchcal::robot::{KinematicParameter, Kinematics};
use touchcal::se3::{Pose, Wrench};
use touchcal::sim::follow;

use crate::support::uniform;

/// Places of sockets in base (m).
pub const SOCKETS: [[f64; 3]; 4] = [[0.5, 0.2, 0.1], [0.45, -0.25, 0.2], [0.35, 0.3, 0.45], [0.6, 0.0, 0.35]];

/// A problem without parameters, with 60 contacts of an iiwa 14 of these errors in each of
/// `sockets`, whose places are exact. `record` makes the measured joint positions, and the measured
/// wrench if there is one, of the true arm, the socket, a seed and the true joint positions without
/// load.
pub fn ball_in_sockets(
    errors: &[(KinematicParameter, f64)],
    sockets: &[[f64; 3]],
    record: impl Fn(&Kinematics, &[f64; 3], u64, &[f64]) -> (Vec<f64>, Option<Wrench>),
) -> Problem {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let (columns, theta): (Vec<KinematicParameter>, Vec<f64>) = errors.iter().copied().unzip();
    let tip_from_tool = Pose::translation(0.02, -0.03, 0.1);
    let mut arm = Kinematics::new(&robot, &columns, tip_from_tool);
    arm.set(&theta);
    let posture = [0.1, 0.7, 0.2, -1.5, -0.2, 0.9, 0.1];
    let down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let mut contacts = ContactLog::new(7);
    for (f, socket) in sockets.iter().enumerate() {
        let mut q = posture.to_vec();
        for i in 0..60u64 {
            let seed = 1000 * f as u64 + i;
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from_row_slice(&uniform(3, 10_000 + seed)) * 0.6);
            let bend: Vec<f64> = posture.iter().zip(uniform(7, 20_000 + seed)).map(|(q, d)| q + 0.5 * d).collect();
            q = follow(&arm, &Pose::from_parts((*socket).into(), turn * down), &q, &bend).expect("within reach");
            let (measured, wrench) = record(&arm, socket, seed, &q);
            contacts.push(&measured, f, Source { file: 0, line: i + 1 });
            if let Some(wrench) = wrench {
                contacts.set_load(wrench);
            }
        }
    }
    let fixture = |(f, socket): (usize, &[f64; 3])| Fixture {
        name: format!("socket/{f}"),
        manifold: Arc::new(BallInSocket),
        base_from_fixture: Some(Pose::translation(socket[0], socket[1], socket[2])),
        prior: PlacePrior::Fixed,
        tolerance: ShapeTolerance::EXACT,
        placement: String::new(),
    };
    let tool = Tool { tip_from_tool, prior: PlacePrior::Fixed };
    Problem::new(robot, tool, sockets.iter().enumerate().map(fixture).collect(), contacts)
}

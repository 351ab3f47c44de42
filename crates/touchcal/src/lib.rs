//! Calibrate a robot arm by touch: a robot's description, a log of joint positions in contact, and what was touched go in;
//! a calibrated description, the uncertainty of every number, and what the data cannot determine come out.
//!
//! When a tool touches a part of known shape, its pose lies on that part's *contact manifold* `M`. Wrong kinematics put the
//! computed poses off `M`; calibration finds the parameters `θ` that put them back:
//!
//! ```text
//! robot(θ) + contact log → contact poses → distance to M → θ̂, its covariance, what is not identifiable → calibrated robot
//! ```
//!
//! The modules follow that line:
//!
//! | module | holds |
//! |---|---|
//! | [`se3`] | rigid motions and their derivatives |
//! | [`robot`] | the arm, the parameters that may be wrong in it, kinematics with derivatives |
//! | [`contact`] | joint positions in contact, and contact from force |
//! | [`geometry`] | shapes of parts and the exact gap between them |
//! | [`manifold`] | contact manifolds: peg in hole, ball in socket, tool on plane, or your own |
//! | [`estimate`] | the estimator, covariance, identifiability, outcomes |
//! | [`sim`] | simulated touching, for demonstrations and tests |
//! | [`experiment`] | calibrations of which the truth is known |
//! | [`io`] | files, to and from these types |
//!
//! # Example
//! Simulate an arm with a strain of 1 % and a base encoder off by 2° that explores a square hole, and find both again.
//!
//! ```
//! use std::ops::ControlFlow;
//! use touchcal::estimate::{Fixture, Freedom, Loss, Method, Noise, Problem, Status, Tool, calibrate};
//! use touchcal::contact::{ContactLog, Source};
//! use touchcal::geometry::{extrusion::PegAndHole, profile::Profile};
//! use touchcal::io::urdf::{self, Ends};
//! use touchcal::manifold::PegInHole;
//! use touchcal::robot::{Column, joint_offset, strain};
//! use touchcal::se3::Pose;
//! use touchcal::sim::{Compliance, Exploration, Insertion};
//! use nalgebra::{Point2, Quaternion, UnitQuaternion};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let robot = urdf::read_builtin("iiwa14", Ends::default())?.robot;
//! let corners = [[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]];
//! let peg = Profile::new(corners.map(Point2::from).to_vec())?;
//! let hole = peg.offset_mitred(0.0005)?;
//! let parts = PegAndHole::new(peg, 0.04, hole, 0.03)?;
//! let turned = UnitQuaternion::new_normalize(Quaternion::new(0.0, 0.0, 1.0, 0.0));
//! let tip_from_peg = Pose::from_parts([0.0, 0.0, 0.15].into(), turned);
//! let base_from_hole = Pose::translation(0.6, 0.1, 0.15);
//!
//! let log = Insertion {
//!     robot: robot.clone(),
//!     errors: vec![(Column::Strain, 0.01), (Column::JointOffset(0), 0.035)],
//!     tip_from_peg,
//!     base_from_hole,
//!     parts: parts.clone(),
//!     posture: vec![0.0, 0.73, 0.26, -1.56, -0.23, 0.87, -0.02],
//!     compliance: Compliance { translation: 3000.0, rotation: 30.0, contact: 5e6 },
//!     exploration: Exploration { radius: 2e-3, tilt: 0.04, swing: 0.1, rate: 300.0 },
//!     encoder_sigma: 3.5e-5,
//!     contact_sigma: 1e-5,
//!     force_threshold: 3.0,
//! }
//! .run(1000, 1)?;
//!
//! let mut contacts = ContactLog::new(7);
//! for (row, q) in log.q.iter().enumerate() {
//!     contacts.push(q, 0, Source { file: 0, line: row as u64 + 1 });
//! }
//! let mut parameters = vec![strain()];
//! parameters.extend(joint_offset(&robot));
//! let problem = Problem {
//!     robot,
//!     tool: Tool { tip_from_tool: tip_from_peg, freedom: Freedom::Known },
//!     fixtures: vec![Fixture {
//!         name: "hole".to_owned(),
//!         manifold: Box::new(PegInHole::new(parts)),
//!         base_from_fixture: Some(base_from_hole),
//!         freedom: Freedom::Known,
//!         placement: String::new(),
//!     }],
//!     distances: Vec::new(),
//!     contacts,
//!     noise: Noise { encoder: 3.5e-5, contact: 1e-5, learned: false },
//!     parameters,
//!     joint_drift: false,
//!     method: Method::LevenbergMarquardt,
//!     loss: Loss::GemanMcClure(3.0),
//! };
//! let estimate = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
//!
//! assert_eq!(estimate.status, Status::Converged);
//! let strain = estimate.parameter("strain").ok_or("no strain")?;
//! assert!((strain.value - 0.01).abs() < 1e-3);
//! let base = estimate.parameter("joint_offset.joint_a1").ok_or("no offset")?;
//! assert!((base.value - 0.035).abs() < 0.001);
//! # Ok(())
//! # }
//! ```

pub mod contact;
pub mod estimate;
pub mod experiment;
pub mod geometry;
pub mod io;
pub mod manifold;
pub mod robot;
pub mod se3;
pub mod sim;

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
//! | [`report`] | a result as a page to look at |
//! | [`io`] | files, to and from these types |
//!
//! # Example
//! Simulate an arm with a strain of 1 % and a base encoder off by 2° that explores a square hole, and find both again.
//!
//! ```
//! use std::ops::ControlFlow;
//! use std::sync::Arc;
//! use touchcal::contact::{ContactLog, Source};
//! use touchcal::estimate::{Fixture, Freedom, Loss, Method, Noise, Problem, Status, Tool, calibrate};
//! use touchcal::geometry::{extrusion::PegAndHole, profile::Profile};
//! use touchcal::io::urdf::{self, Ends};
//! use touchcal::manifold::PegInHole;
//! use touchcal::robot::{Column, joint_offset, strain};
//! use touchcal::sim::{Parts, Preset, Truth};
//! use nalgebra::Point2;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let robot = urdf::read_builtin("iiwa14", Ends::default())?.robot;
//! let corners = [[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]];
//! let peg = Profile::new(corners.map(Point2::from).to_vec())?;
//! let hole = peg.offset_mitred(0.0005)?;
//! let parts = PegAndHole::new(peg, 0.04, hole, 0.03)?;
//!
//! let mut scenario = Preset::Paper.scenario(robot.clone())?;
//! scenario.contacts = 1000;
//! scenario.touches[0].parts = Parts::PegInHole(Box::new(parts.clone()));
//! let errors = vec![(Column::Strain, 0.01), (Column::JointOffset(0), 0.035)];
//! let truth = Truth { errors, ..Truth::default() };
//! let log = &scenario.run(&truth, 1, &mut |_| ControlFlow::Continue(()))?[0];
//!
//! let mut contacts = ContactLog::new(7);
//! for row in log.contacts() {
//!     contacts.push(log.q(row), 0, Source { file: 0, line: row as u64 + 1 });
//! }
//! let mut parameters = vec![strain()];
//! parameters.extend(joint_offset(&robot));
//! let problem = Problem {
//!     robot,
//!     tool: Tool { tip_from_tool: scenario.tip_from_tool, freedom: Freedom::Known },
//!     fixtures: vec![Fixture {
//!         name: "hole".to_owned(),
//!         manifold: Arc::new(PegInHole::new(parts)),
//!         base_from_fixture: Some(scenario.touches[0].base_from_fixture),
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
pub mod report;
pub mod robot;
pub mod se3;
pub mod sim;

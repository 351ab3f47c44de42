//! Calibrate a robot arm by touch: a robot's description, a log of joint positions in contact, and
//! what was touched go in; a calibrated description, the uncertainty of every number, and what the
//! data cannot determine come out.
//!
//! When a tool touches a part of known shape, its pose lies on that part's *contact manifold* `M`.
//! Wrong kinematics put the computed poses off `M`; calibration finds the parameters `θ` that put
//! them back. It minimizes
//!
//! ```text
//! F(θ) = Σᵢ ρ(‖W · M(T_fb · T_bt(qᵢ; θ))‖²)     contacts, two-sided
//!      − 2 Σᵢ ln L(M(T_fb · T_bt(qᵢ; θ)))        contacts, one-sided: active set latent
//!      + Σₖ (θₖ / σₖ)²                           priors
//!      + Σ ((d − d̂) / σ_d)²                      known distances between fixtures
//! ```
//!
//! over contacts `i` with measured joint positions `qᵢ` and parameters `k`: `T_bt` is the pose
//! `base_from_tool`, `T_fb` the pose `fixture_from_base`, `W` (1/m) whitens residuals (m), `ρ` is
//! a robust loss, `L` a likelihood, `σₖ` the standard deviation of the prior of `θₖ`, and
//! `d̂ ± σ_d` (m) the declared value of a distance `d`.
//!
//! The symbols are the modules, in the order of the data flow:
//!
//! | symbol | module | holds |
//! |---|---|---|
//! | `T`, `Exp` | [`se3`] | rigid motions and their derivatives |
//! | `ρ`, `argmin F` | [`solver`] | nonlinear least squares, robust losses |
//! | `T_bt(q; θ)` | [`robot`] | the arm, its kinematics `base_from_tool` with derivatives |
//! | `θ`, `σ` | [`parameter`] | what may be wrong: names, units, priors |
//! | `qᵢ` | [`contact`] | joint positions in contact, and contact from force |
//! | gap | [`geometry`] | shapes of parts and the exact signed distance between them |
//! | `M` | [`manifold`] | contact manifolds: peg in hole, ball in socket, tool on plane, or your own |
//! | `W`, `L`, `F` | [`estimate`] | the estimator, covariance, identifiability, warnings |
//! | | [`sim`] | simulated touching, for demonstrations and tests |
//! | | [`experiment`] | calibrations with known truth |
//! | | [`report`] | a result as an HTML page |
//! | | [`io`] | files, to and from these types |
//!
//! # Example
//! Simulate an arm with a strain of 1 % and a base encoder off by 2° that explores a square hole,
//! and find both again.
//!
//! ```
//! use std::ops::ControlFlow;
//! use std::sync::Arc;
//! use touchcal::contact::{ContactLog, Source};
//! use touchcal::estimate::{Fixture, Noise, PlacePrior, Problem, ShapeTolerance, Status, Tool};
//! use touchcal::estimate::calibrate;
//! use touchcal::geometry::{Parts, Polygon, PrismPair};
//! use touchcal::io::urdf::{self, Ends};
//! use touchcal::manifold::PegInHole;
//! use touchcal::parameter::{joint_offset, strain};
//! use touchcal::robot::KinematicParameter::{JointOffset, Strain};
//! use touchcal::sim::{self, Preset, Truth};
//! use nalgebra::Point2;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let robot = urdf::read_builtin("iiwa14", Ends::default())?.robot;
//! let corners = [[-0.01, -0.01], [0.01, -0.01], [0.01, 0.01], [-0.01, 0.01]];
//! let peg = Polygon::new(corners.map(Point2::from).to_vec())?;
//! let hole = peg.offset_mitred(0.0005)?;
//! let parts = PrismPair::new(peg, 0.04, hole, 0.03)?;
//!
//! let mut scenario = Preset::Paper.scenario(robot.clone())?;
//! scenario.contacts = 1000;
//! scenario.touches[0].parts = Parts::PegInHole(Box::new(parts.clone()));
//! let errors = vec![(Strain.into(), 0.01), (JointOffset(0).into(), 0.035)];
//! let truth = Truth { errors, ..Truth::default() };
//! let log = &sim::run(&scenario, &truth, 1, &mut |_| ControlFlow::Continue(()))?[0];
//!
//! let mut contacts = ContactLog::new(7);
//! for row in log.contacts() {
//!     contacts.push(log.q(row), 0, Source { file: 0, line: row as u64 + 1 });
//! }
//! let mut parameters = vec![strain()];
//! parameters.extend(joint_offset(&robot));
//! let tool = Tool { tip_from_tool: scenario.tip_from_tool, prior: PlacePrior::Fixed };
//! let hole = Fixture {
//!     name: "hole".to_owned(),
//!     manifold: Arc::new(PegInHole::new(parts)),
//!     base_from_fixture: Some(scenario.touches[0].base_from_fixture),
//!     prior: PlacePrior::Fixed,
//!     tolerance: ShapeTolerance::EXACT,
//!     placement: String::new(),
//! };
//! let noise = Noise { encoder: 3.5e-5, contact: 1e-5, is_estimated: false };
//! let problem = Problem::new(robot, tool, vec![hole], contacts)
//!     .with_parameters(parameters)
//!     .with_noise(noise);
//! let estimate = calibrate(&problem, &mut |_| ControlFlow::Continue(()));
//!
//! assert_eq!(estimate.status, Status::Usable);
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
pub mod parameter;
pub mod report;
pub mod robot;
pub mod se3;
pub mod sim;
pub mod solver;
pub mod statistics;

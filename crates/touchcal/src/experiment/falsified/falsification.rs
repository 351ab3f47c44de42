//! What is false: of the simulated world, or of the problem that is posed of it.

use nalgebra::{UnitQuaternion, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::declare::{change_parts, change_positions, encoder_drift, move_fixtures, move_tool, with_hole};
use super::draw::{draw, gaussian_twist, normal};
use super::quantity::Quantity::{self, Distances, FixturePlaces, Shapes, ToolPlace, Trends, UnseenEffects};
use crate::estimate::{Problem, ShapeTolerance};
use crate::geometry::{Parts, Polygon, PrismPair};
use crate::parameter::{Block, ParameterId};
use crate::robot::{JointKind, KinematicParameter, calibrated};
use crate::se3::{self, Twist};
use crate::sim::{PartsError, Scenario, Truth, random_walk};

/// Makes chance of what is false another than that of the simulation with the same seed.
const PURPOSE: u64 = 0x5EED_FA15_E000_0001;

/// Compliance (rad/(N m)) of joints where the wrench is false: of good harmonic drives.
const WRENCH_COMPLIANCE: f64 = 1e-4;

/// Height (m) above a fixture to which a tool is lifted where rows just after contacts matter.
const LIFT: f64 = 10e-3;

/// Standard deviation (rad) of joints that are away from contact.
const AWAY: f64 = 0.3 * std::f64::consts::PI / 180.0;
/// Size (rad) by which each joint is off where another object is touched.
const OTHER_OBJECT: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// By how much a pose is declared wrong: norms of the local twist `ξ = [v; ω]` of `true = declared
/// · Exp(ξ)`, whose directions are uniformly distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// Norm of the translation part (m, ≥ 0).
    pub length: f64,
    /// Norm of the rotation part (rad, ≥ 0).
    pub angle: f64,
}

/// A false declaration, with its size. Joints and directions that are not said are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Falsification {
    /// Nothing is false.
    Nothing,
    /// This quantity is off by Gaussian draws with the default's standard deviations, independent
    /// of each other. Of [`Quantity::UnseenEffects`] only encoder harmonics are drawn; nothing is
    /// drawn of [`Quantity::Wrench`], whose errors are the simulation's:
    /// [`Falsification::WrenchBias`].
    Drawn(Quantity),
    /// Off by draws, each as [`Falsification::Drawn`]: places, shapes, distances, trends and
    /// encoder harmonics.
    AllDrawn,
    /// Poses of all fixtures in base are off.
    FixturesMoved(Displacement),
    /// The pose of the tool on the tip link is off.
    ToolMoved(Displacement),
    /// The tool's position on the tip link, in metres where millimetres were meant: a thousandth
    /// of the true one.
    ToolInMetres,
    /// The hole is declared wider than it is by this much (m a side, negative for narrower).
    Clearance(f64),
    /// The hole is declared deeper than it is by this much (m).
    Depth(f64),
    /// Outlines of peg and hole are declared larger by this share of themselves (1).
    Outline(f64),
    /// Friction with this coefficient (1, ≥ 0) between tool and fixture, which no model has.
    Friction(f64),
    /// The hole is wider or narrower along x of the fixture's frame, and along y, by draws of this
    /// standard deviation (m a side).
    UnequalClearance(f64),
    /// Edges of peg and hole are round with this radius (m), and declared sharp.
    EdgeWear(f64),
    /// The tool leaves the fixture between presses, and the force sensor has a low-pass filter of
    /// this time constant (s, ≥ 0): rows just after a contact count as contacts.
    ForceLag(f64),
    /// Joints that give way to the contact's load by this compliance (rad/(N m)), undeclared.
    JointCompliance(f64),
    /// One encoder's offset changes linearly by this much (rad) from the first to the last contact;
    /// its mean is the true offset.
    EncoderDrift(f64),
    /// One encoder's offset walks at random, by this standard deviation (rad) from the first to the
    /// last contact; its mean is the true offset.
    EncoderWalk(f64),
    /// One encoder reads too much by this amplitude (rad) times the sine of its position plus a
    /// phase.
    EncoderHarmonic(f64),
    /// Encoders have noise of this factor (1, > 0) times the declared standard deviation.
    EncoderNoise(f64),
    /// Contacts that are none.
    FalseContacts {
        /// Their share (0 to 1) of all.
        share: f64,
        /// Standard deviation (rad) by which each joint is away from contact.
        deviation: f64,
    },
    /// This share of the rows is no contact, of three kinds alike: in free air, halfway between two
    /// successive contacts; joints away from contact by 0.3° at random; and contacts with another
    /// object, all joints off by the same 0.5° to one side or the other.
    FalseContactsOfAllKinds(f64),
    /// The hole is narrower by this much (m a side), and is declared so.
    TightHole(f64),
    /// No more contacts than this with each fixture.
    FewContacts(usize),
    /// Columns of two neighbouring joints are exchanged in the log.
    JointsExchanged,
    /// Distances between fixtures are declared larger by this share of themselves (1).
    Spacing(f64),
    /// The measured wrench, with which compliances of 1e-4 rad/(N m) are estimated, has a bias that
    /// is drawn.
    WrenchBias {
        /// Standard deviation of each component of the force's bias (N).
        force: f64,
        /// Standard deviation of each component of the moment's bias (N m).
        torque: f64,
    },
    /// The tool's frame is turned by half a turn about its own x axis.
    ToolTurned,
    /// The tool's position on the tip link has the opposite sign.
    ToolOpposite,
    /// Positions of all fixtures in base, in metres where millimetres were meant: a thousandth of
    /// the true ones.
    FixtureInMetres,
    /// The hole's depth, in metres where millimetres were meant: a thousandth of the true one.
    DepthInMetres,
    /// Columns of all joints are in the opposite order in the log.
    JointsReversed,
    /// Positions of turning joints are degrees that are taken as radians.
    JointsInDegrees,
    /// One joint of the log counts in the opposite direction.
    JointSign,
    /// All lengths of the described arm are this factor (1, > 0) times the true arm's nominal ones.
    ArmSize(f64),
}

impl Falsification {
    /// Whether the problem alone is false: [`Falsification::falsify_scenario`] changes nothing, so
    /// that it can be tried with recorded contacts.
    pub fn is_of_problem(&self) -> bool {
        !matches!(
            self,
            Falsification::Friction(_)
                | Falsification::UnequalClearance(_)
                | Falsification::EdgeWear(_)
                | Falsification::ForceLag(_)
                | Falsification::JointCompliance(_)
                | Falsification::EncoderNoise(_)
                | Falsification::FewContacts(_)
                | Falsification::TightHole(_)
                | Falsification::WrenchBias { .. }
        )
    }

    /// Makes `scenario` the one whose declarations are the problem's: of an arm with compliant
    /// joints where the wrench is false, of other parts where they are tight.
    ///
    /// # Errors
    /// If the parts are not valid.
    pub fn prepare_scenario(&self, scenario: &mut Scenario) -> Result<(), PartsError> {
        match *self {
            Falsification::WrenchBias { .. } => scenario.errors.joint_compliance = WRENCH_COMPLIANCE,
            Falsification::TightHole(narrower) => {
                for touch in &mut scenario.touches {
                    if let Parts::PegInHole(parts) = &touch.parts {
                        touch.parts = with_hole(parts, -narrower, 0.0)?;
                    }
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Makes `scenario`, whose declarations are the problem's, the scenario that is simulated.
    pub fn falsify_scenario(&self, scenario: &mut Scenario) {
        match *self {
            Falsification::Friction(coefficient) => scenario.friction = coefficient,
            Falsification::UnequalClearance(sigma) => {
                scenario.touches.iter_mut().for_each(|touch| touch.unequal_clearance_sigma = sigma);
            }
            Falsification::Drawn(Shapes) | Falsification::AllDrawn => {
                let sigma = ShapeTolerance::DEFAULT.edge_radius;
                scenario.touches.iter_mut().for_each(|touch| touch.edge_radius_sigma = sigma);
            }
            Falsification::EdgeWear(radius) => scenario.touches.iter_mut().for_each(|touch| touch.edge_wear = radius),
            Falsification::ForceLag(lag) => {
                scenario.recorder.force_lag = lag;
                scenario.touches.iter_mut().for_each(|touch| touch.exploration.lift = LIFT);
            }
            Falsification::JointCompliance(compliance) => scenario.errors.joint_compliance = compliance,
            Falsification::EncoderNoise(factor) => scenario.recorder.encoder_sigma *= factor,
            Falsification::FewContacts(contacts) => scenario.contacts = scenario.contacts.min(contacts),
            Falsification::WrenchBias { force, torque } => {
                (scenario.recorder.force_bias, scenario.recorder.torque_bias) = (force, torque);
            }
            _ => {}
        }
    }

    /// Makes `problem`, posed of a simulation of `scenario`, declare what is false, or changes its
    /// contacts; the same for the same `seed`. Fixtures of the problem are the scenario's touches,
    /// in their order.
    ///
    /// # Errors
    /// If shapes that are to be declared are not valid.
    pub fn falsify_problem(&self, problem: &mut Problem, scenario: &Scenario, seed: u64) -> Result<(), PartsError> {
        let random = &mut Pcg64::seed_from_u64(seed ^ PURPOSE);
        match *self {
            Falsification::Drawn(quantity) => draw(problem, scenario, quantity, random)?,
            Falsification::AllDrawn => {
                let all = [FixturePlaces, ToolPlace, Shapes, Distances, Trends, UnseenEffects];
                all.into_iter().try_for_each(|quantity| draw(problem, scenario, quantity, random))?;
            }
            Falsification::FixturesMoved(by) => move_fixtures(problem, || by.twist(random)),
            Falsification::ToolMoved(by) => move_tool(problem, &by.twist(random)),
            Falsification::ToolInMetres => problem.tool.tip_from_tool.translation.vector *= 1e-3,
            Falsification::Clearance(wider) => {
                change_parts(problem, scenario, |parts| with_hole(parts, wider, 0.0))?;
            }
            Falsification::Depth(deeper) => {
                change_parts(problem, scenario, |parts| with_hole(parts, 0.0, deeper))?;
            }
            Falsification::DepthInMetres => {
                change_parts(problem, scenario, |parts| with_hole(parts, 0.0, -0.999 * parts.depth()))?;
            }
            Falsification::Outline(share) => change_parts(problem, scenario, |parts| scaled(parts, 1.0 + share))?,
            Falsification::ToolTurned => problem.tool.tip_from_tool.rotation *= half_turn(),
            Falsification::ToolOpposite => problem.tool.tip_from_tool.translation.vector.neg_mut(),
            Falsification::FixtureInMetres => {
                for pose in problem.fixtures.iter_mut().filter_map(|fixture| fixture.base_from_fixture.as_mut()) {
                    pose.translation.vector *= 1e-3;
                }
            }
            Falsification::ArmSize(factor) => {
                problem.robot = calibrated(&problem.robot, &[KinematicParameter::Strain], &[factor - 1.0]);
            }
            Falsification::Spacing(share) => {
                problem.distances.iter_mut().for_each(|known| known.distance *= 1.0 + share);
            }
            _ => self.falsify_contacts(problem, random),
        }
        Ok(())
    }

    /// The truth of a simulation as errors of the arm that the problem describes: strains are of
    /// its lengths. Joint origins are left as they are.
    pub(super) fn relative_truth(&self, truth: &Truth) -> Truth {
        let mut relative = truth.clone();
        if let Falsification::ArmSize(factor) = *self {
            let is_strain = |id: ParameterId| matches!(id.block(), Block::Strain | Block::SegmentStrain);
            let strains = relative.errors.iter_mut().filter(|(id, _)| is_strain(*id));
            strains.for_each(|(_, strain)| *strain = (1.0 + *strain) / factor - 1.0);
        }
        relative
    }

    /// Changes the joint positions of the contacts.
    fn falsify_contacts(&self, problem: &mut Problem, random: &mut Pcg64) {
        let dof = problem.contacts.dof();
        if dof < 2 {
            return;
        }
        match *self {
            Falsification::EncoderDrift(change) => {
                let joint = random.random_range(0..dof);
                encoder_drift(problem, joint, change);
            }
            Falsification::EncoderWalk(change) => {
                let joint = random.random_range(0..dof);
                let walk = random_walk(problem.contacts.len(), change, random);
                change_positions(problem, |i, q| q[joint] += walk[i]);
            }
            Falsification::EncoderHarmonic(amplitude) => {
                let joint = random.random_range(0..dof);
                let phase = random.random_range(0.0..std::f64::consts::TAU);
                change_positions(problem, |_, q| q[joint] += amplitude * (q[joint] + phase).sin());
            }
            Falsification::FalseContacts { share, deviation } => change_positions(problem, |_, q| {
                if random.random_bool(share) {
                    q.iter_mut().for_each(|q| *q += deviation * normal(random));
                }
            }),
            Falsification::FalseContactsOfAllKinds(share) => false_contacts(problem, share, random),
            Falsification::JointsExchanged => {
                let joint = random.random_range(0..dof - 1);
                change_positions(problem, |_, q| q.swap(joint, joint + 1));
            }
            Falsification::JointsReversed => change_positions(problem, |_, q| q.reverse()),
            Falsification::JointsInDegrees => {
                let turns: Vec<bool> = problem.robot.moving().map(|joint| joint.kind != JointKind::Prismatic).collect();
                let in_degrees = |(q, &turns): (&mut f64, &bool)| *q = if turns { q.to_degrees() } else { *q };
                change_positions(problem, |_, q| q.iter_mut().zip(&turns).for_each(in_degrees));
            }
            Falsification::JointSign => {
                let joint = random.random_range(0..dof);
                change_positions(problem, |_, q| q[joint] = -q[joint]);
            }
            _ => {}
        }
    }
}

impl Displacement {
    fn twist(self, random: &mut Pcg64) -> Twist {
        let direction = gaussian_twist(1.0, 1.0, random);
        let (v, w) = (se3::linear(&direction).normalize(), se3::angular(&direction).normalize());
        se3::twist(&(v * self.length), &(w * self.angle))
    }
}

/// Replaces a `share` of the contacts by rows that are no contacts, each of one of three kinds.
fn false_contacts(problem: &mut Problem, share: f64, random: &mut Pcg64) {
    let contacts = problem.contacts.clone();
    let dof = contacts.dof();
    let other_object: Vec<f64> =
        (0..dof).map(|_| if random.random_bool(0.5) { OTHER_OBJECT } else { -OTHER_OBJECT }).collect();
    change_positions(problem, |i, q| {
        if !random.random_bool(share) {
            return;
        }
        match random.random_range(0..3) {
            0 => {
                let next = contacts.q((i + 1).min(contacts.len() - 1));
                q.iter_mut().zip(next).for_each(|(q, next)| *q = 0.5 * (*q + next));
            }
            1 => q.iter_mut().for_each(|q| *q += AWAY * normal(random)),
            _ => q.iter_mut().zip(&other_object).for_each(|(q, off)| *q += off),
        }
    });
}

fn half_turn() -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
}

/// Outlines of peg and hole times `factor`, lengths as they are.
fn scaled(parts: &PrismPair, factor: f64) -> Result<Parts, PartsError> {
    let outline = |of: &Polygon| Polygon::new(of.vertices().iter().map(|vertex| vertex * factor).collect());
    let pair = PrismPair::new(outline(parts.peg())?, parts.length(), outline(parts.hole())?, parts.depth())?;
    let pair = pair.with_edge_radii(parts.edge_radii())?;
    Ok(Parts::PegInHole(Box::new(pair)))
}

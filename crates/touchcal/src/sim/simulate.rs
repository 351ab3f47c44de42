//! A scenario run: the truth drawn, each fixture explored, what the recorder writes.

use std::ops::ControlFlow;

use nalgebra::Translation3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::arm_motion::ArmMotion;
use super::equilibrium::{Equilibrium, Rest};
use super::exploration::Phases;
use super::parts::NearPairs;
use super::recorder::{EncoderChanges, WrenchErrors, at_tip, force, normal};
use super::scenario::{Scenario, Thermal, Touch};
use super::simulation_error::SimulationError;
use super::truth::Truth;
use crate::geometry::{GapQuery, Parts};
use crate::robot::{EncoderTerm, KinematicParameter, Kinematics, measured_position, segments};
use crate::se3::{self, Pose, Twist};

/// One simulated trial: true errors and logs.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedTrial {
    /// True errors of arm, tool, fixtures and measured distances; a calibration does not read them.
    pub truth: Truth,
    /// One log for each touch of the scenario, in its order.
    pub logs: Vec<Log>,
}

/// Seeds of a simulation's random numbers, for [`draw_truth`] and [`run`]; made from one number by
/// `From<u64>`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seeds {
    /// Seed of [`draw_truth`]: of the true errors of arm, tool, fixtures, force sensor and measured
    /// distances.
    pub errors: u64,
    /// Seed of [`run`]: of noise, form errors, missed and spurious contacts, and of random phases.
    pub noise: u64,
}

/// The same seed for errors and noise.
impl From<u64> for Seeds {
    fn from(seed: u64) -> Seeds {
        Seeds { errors: seed, noise: seed }
    }
}

/// Recording at one fixture, through all its postures in turn: parallel lists with one entry for
/// each row, in contact or not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Number of moving joints of the arm.
    pub dof: usize,
    /// Time of each row (s) since the start of this log, so 0 in the first row; rows are `1/rate`
    /// apart.
    pub time: Vec<f64>,
    /// Measured joint positions (rad, or m for a prismatic joint), row by row: `dof` numbers for
    /// each row, base first.
    pub q: Vec<f64>,
    /// Measured wrench `[f; τ]` (N, N m) of the fixture on the tool in each row, about the tip's
    /// origin, in the tip frame; rounded to [`WRENCH_DIGITS`](super::WRENCH_DIGITS).
    pub wrench: Vec<[f64; 6]>,
    /// Measured torque about each moving joint (N m), or force along a prismatic one (N), that
    /// gravity and contact exert on what the joint carries, row by row: `dof` numbers for each row,
    /// base first, rounded like wrenches. Empty where they are not recorded
    /// ([`Recorder::joint_torque_sigma`](super::Recorder::joint_torque_sigma)).
    pub joint_torque: Vec<f64>,
    /// Measured temperature (°C) of each of the arm's [`segments`](crate::robot::segments()), row
    /// by row: one number for each segment, in their order, for each row. Empty where temperatures
    /// are not recorded ([`Scenario::thermal`] is `None`).
    pub temperature: Vec<f64>,
    /// Temperature of the arm in each row (°C), to a thousandth. Empty unless it warms up
    /// ([`Recorder::warm_up`](super::Recorder::warm_up)).
    pub arm_temperature: Vec<f64>,
    /// Whether the recorder counts each row as a contact: a measured force above
    /// [`Recorder::force_threshold`](super::Recorder::force_threshold).
    pub contact: Vec<bool>,
    /// True pose, force and contact of each row; not part of the recording.
    pub truth: Vec<TrueRow>,
}

/// True pose, force and contact of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrueRow {
    /// Pose of the tool in the fixture's frame (m): at rest, where parts overlap by less than 1 µm,
    /// but for their form errors; in a spurious contact a free pose.
    pub fixture_from_tool: Pose,
    /// Magnitude of the force of the fixture on the tool (N), without noise and bias; 0 in a
    /// spurious contact.
    pub force: f64,
    /// Whether the tool touches the fixture; false in a spurious contact.
    pub touching: bool,
}

impl Log {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether the log has no rows.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Measured joint positions of row `i` < [`Log::len`] (rad, or m for a prismatic joint), `dof`
    /// of them, base first. Panics if there is no such row.
    pub fn q(&self, i: usize) -> &[f64] {
        &self.q[i * self.dof..(i + 1) * self.dof]
    }

    /// Measured joint torques of row `i`; `None` if there is no such row, or they are not recorded.
    pub fn joint_torque(&self, i: usize) -> Option<&[f64]> {
        self.joint_torque.get(i * self.dof..(i + 1) * self.dof)
    }

    /// Indices of the rows that the recorder counts as contacts, ascending from 0.
    pub fn contacts(&self) -> impl Iterator<Item = usize> {
        (0..self.len()).filter(|&i| self.contact[i])
    }
}

/// Rows simulated for each contact wanted before giving up.
const PATIENCE: usize = 20;
/// Height (m) above a fixture at which a tool starts.
const START: f64 = 1e-3;

/// Chance for one purpose. No purpose disturbs another: more rows leave the truth and the other
/// fixtures as they are.
fn chance(seed: u64, purpose: u64) -> Pcg64 {
    Pcg64::seed_from_u64(seed ^ purpose.wrapping_mul(0x9E37_79B9_7F4A_7C15))
}

/// Draws the truth of `scenario` from `seed`, as [`draw_truth`], and runs it with noise of the same
/// seed. The same seed gives the same trial, to the last bit where sine and cosine are the same.
///
/// # Errors
/// As [`run`], but for [`SimulationError::Interrupted`].
pub fn simulate(scenario: &Scenario, seed: u64) -> Result<SimulatedTrial, SimulationError> {
    let truth = draw_truth(scenario, seed);
    let logs = run(scenario, &truth, seed, &mut |_| ControlFlow::Continue(()))?;
    Ok(SimulatedTrial { truth, logs })
}

/// Draws the true errors of arm, tool, fixtures, force sensor and measured distances of `scenario`;
/// the same for the same `seed`, whatever the numbers of contacts.
pub fn draw_truth(scenario: &Scenario, seed: u64) -> Truth {
    Truth::draw(scenario, &mut chance(seed, 0))
}

/// Runs `scenario` with the errors of `truth` and the noise of `seed`: one log for each touch, in
/// the scenario's order. `watch` receives the number of contacts so far, with all fixtures, after
/// each contact; if it breaks, the run ends with [`SimulationError::Interrupted`].
///
/// Joints that turn further than once take the turn that is nearest to the row before, within their
/// limits. Joints deflect under gravity and the contact's load by the compliances and backlashes of
/// arm and `truth` together. Panics if `truth` names a joint that the arm does not have, a distance
/// a touch that there is not, or a posture has fewer positions than the arm has moving joints.
///
/// # Errors
/// If the arm cannot reach a fixture, touches too rarely, or finds no rest; if a hole cannot be as
/// wide as drawn, or a distance is measured as 0 or less; and if `watch` ends the run. The logs so
/// far are then lost.
pub fn run(
    scenario: &Scenario,
    truth: &Truth,
    seed: u64,
    watch: &mut dyn FnMut(usize) -> ControlFlow<()>,
) -> Result<Vec<Log>, SimulationError> {
    check_distances(scenario, truth)?;
    let (mut parameters, mut values) = truth.of_kinematics();
    if scenario.recorder.joint_torque_sigma > 0.0 {
        // Stiff joints bear torques too.
        parameters.push(KinematicParameter::JointCompliance(0));
        values.push(truth.value(KinematicParameter::JointCompliance(0).into()));
    }
    // The kinematics of the true arm: driven by what its encoders say, as the real one is.
    let mut arm = Kinematics::new(&scenario.robot, &parameters, scenario.tip_from_tool);
    arm.set(&values);
    let temperature = |thermal: Thermal, k| thermal.reference + truth.strain(k) / thermal.expansion;
    let temperatures: Vec<f64> = match scenario.thermal {
        Some(thermal) => (0..segments(&scenario.robot).len()).map(|k| temperature(thermal, k)).collect(),
        None => Vec::new(),
    };
    let touches = scenario.touches.len();
    let contacts = scenario.contacts * touches;
    let encoder_changes = EncoderChanges::new(
        contacts,
        &truth.encoder_changes(scenario),
        |i| scenario.recorder.trend_position(i, contacts),
        &mut chance(seed, 1 + touches as u64),
    );
    let mut logs: Vec<Log> = Vec::with_capacity(touches);
    for (f, touch) in scenario.touches.iter().enumerate() {
        let parts = truth.parts(scenario, f).ok_or_else(|| {
            let [wider_mm, deeper_mm] = truth.shape_errors(f).map(|error| 1e3 * error);
            let worn_mm = 1e3 * truth.edge_wear(scenario, f);
            SimulationError::Shape { fixture: touch.name.clone(), wider_mm, deeper_mm, worn_mm }
        })?;
        let phases = touch.exploration.phases(&mut chance(seed, 2 + (touches + f) as u64));
        let mut chance = chance(seed, 1 + f as u64);
        // Six numbers go unused, so that the log of a seed stays what it was when biases were drawn
        // here.
        for _ in 0..6 {
            normal(&mut chance);
        }
        let before: usize = logs.iter().map(|log| log.contacts().count()).sum();
        let mut exploration = Run {
            scenario,
            touch,
            parts: &parts,
            base_from_fixture: truth.base_from_fixture(scenario, f),
            tip_from_tool: truth.tip_from_tool(scenario),
            phases,
            motion: ArmMotion::new(&arm, &scenario.robot),
            arm: &arm,
            temperatures: &temperatures,
            chance,
            wrench_errors: truth.wrench_errors(),
            filtered_wrench: [0.0; 6],
            encoder_changes: &encoder_changes,
            encoder_terms: truth.encoder_terms(scenario.robot.dof()),
            before,
            log: Log { dof: scenario.robot.dof(), ..Log::default() },
        };
        exploration.explore(&mut |found| watch(before + found))?;
        logs.push(exploration.log);
    }
    Ok(logs)
}

fn check_distances(scenario: &Scenario, truth: &Truth) -> Result<(), SimulationError> {
    for (k, distance) in scenario.distances.iter().enumerate() {
        let measured = truth.measured_distance(scenario, k);
        if measured <= 0.0 {
            let name = |fixture: usize| scenario.touches[fixture].name.clone();
            let (first, second) = (name(distance.between.0), name(distance.between.1));
            return Err(SimulationError::Distance { first, second, measured_mm: 1e3 * measured });
        }
    }
    Ok(())
}

/// One fixture being explored.
struct Run<'a> {
    scenario: &'a Scenario,
    touch: &'a Touch,
    parts: &'a Parts,
    base_from_fixture: Pose,
    tip_from_tool: Pose,
    phases: Phases,
    motion: ArmMotion<'a>,
    arm: &'a Kinematics,
    /// True temperature of each segment (°C).
    temperatures: &'a [f64],
    chance: Pcg64,
    wrench_errors: WrenchErrors,
    /// Low-pass filtered true wrench at the tip (N, N m), before bias, scale and noise.
    filtered_wrench: [f64; 6],
    encoder_changes: &'a EncoderChanges,
    /// Terms of the error of each joint's encoder that depend on the position, with amplitudes.
    encoder_terms: Vec<Vec<(EncoderTerm, f64)>>,
    /// Contacts with earlier fixtures.
    before: usize,
    log: Log,
}

impl Run<'_> {
    fn explore(&mut self, watch: &mut dyn FnMut(usize) -> ControlFlow<()>) -> Result<(), SimulationError> {
        let (touch, recorder) = (self.touch, &self.scenario.recorder);
        let most = PATIENCE * self.scenario.contacts.max(100);
        let mut found = 0;
        for (k, posture) in touch.postures.iter().enumerate() {
            let wanted = self.scenario.contacts * (k + 1) / touch.postures.len();
            let heights = self.parts.heights();
            let start = Pose::translation(0.0, 0.0, heights.0 + START);
            self.filtered_wrench = [0.0; 6];
            let mut tool = Equilibrium::new(self.parts, self.scenario.stiffness, self.scenario.friction, start);
            let mut joints = posture.clone();
            let mut swung = posture.clone();
            while found < wanted {
                let time = self.log.len() as f64 / recorder.rate;
                let command = touch.exploration.command(&self.phases, time, heights);
                let fixture = || touch.name.clone();
                let no_rest = || SimulationError::NoRest { fixture: fixture(), time };
                let rest = tool.settle(&command).ok_or_else(no_rest)?;
                let form = || self.scenario.contact_sigma * normal(&mut self.chance);
                let placed = if rest.touching {
                    tool.on_forms(&rest, form).ok_or_else(no_rest)?
                } else {
                    rest.fixture_from_tool
                };
                touch.exploration.swung(&self.phases, posture, time, &mut swung);
                if !self.record((time, found), (&rest, placed), &mut joints, &swung) {
                    return Err(SimulationError::OutOfReach { fixture: fixture(), time });
                }
                if self.log.contact.last() == Some(&true) {
                    found += 1;
                    if watch(found).is_break() {
                        return Err(SimulationError::Interrupted);
                    }
                }
                if self.log.len() > most {
                    return Err(SimulationError::NoContact { fixture: fixture(), found, rows: self.log.len() });
                }
            }
        }
        Ok(())
    }

    /// Writes a row at this time, after so many contacts; false if the arm does not reach it, or
    /// its encoders measure no position there.
    fn record(
        &mut self,
        (time, found): (f64, usize),
        (rest, placed): (&Rest, Pose),
        joints: &mut [f64],
        posture: &[f64],
    ) -> bool {
        let recorder = &self.scenario.recorder;
        let mut truth =
            TrueRow { fixture_from_tool: placed, force: se3::linear(&rest.wrench).norm(), touching: rest.touching };
        let mut load = at_tip(&self.tip_from_tool, &rest.wrench);
        let [missed, spurious]: [f64; 2] = std::array::from_fn(|_| self.chance.random());
        self.filtered_wrench = recorder.filtered(self.filtered_wrench, load);
        let mut wrench = recorder.wrench(self.filtered_wrench, &self.wrench_errors, &mut self.chance);
        let seen = force(&wrench) > recorder.force_threshold;
        if seen && spurious < recorder.spurious {
            load = [0.0; 6];
            truth = TrueRow { fixture_from_tool: self.free_pose(&rest.fixture_from_tool), force: 0.0, touching: false };
            wrench = recorder.pretend(true, wrench, &mut self.chance);
        } else if seen && missed < recorder.missed {
            wrench = recorder.pretend(false, wrench, &mut self.chance);
        }
        let target = self.base_from_fixture * truth.fixture_from_tool;
        // Encoders are on the motor's side of joints that deflect under gravity and load.
        if !self.motion.reach((&target, &load), joints, posture) {
            return false;
        }
        let measured = joints
            .iter()
            .zip(&self.encoder_terms)
            .enumerate()
            .map(|(i, (q, terms))| measured_position(terms, q + self.encoder_changes.at(self.before + found, i)));
        let Some(measured) = measured.collect::<Option<Vec<f64>>>() else { return false };
        for q in measured {
            self.log.q.push(recorder.encoder(q, &mut self.chance));
        }
        if let Some(thermal) = self.scenario.thermal {
            let noise = |_: &f64| thermal.sensor_sigma * normal(&mut self.chance);
            let noise: Vec<f64> = self.temperatures.iter().map(noise).collect();
            self.log.temperature.extend(self.temperatures.iter().zip(noise).map(|(celsius, noise)| celsius + noise));
        }
        if recorder.joint_torque_sigma > 0.0 {
            let torques = self.arm.torques(joints, &load);
            let measured = torques.into_iter().map(|torque| recorder.joint_torque(torque, &mut self.chance));
            self.log.joint_torque.extend(measured);
        }
        if recorder.warm_up > 0.0 {
            let contacts = self.scenario.contacts * self.scenario.touches.len();
            self.log.arm_temperature.push(recorder.temperature(self.before + found, contacts));
        }
        self.log.time.push(time);
        self.log.wrench.push(wrench);
        self.log.contact.push(force(&wrench) > recorder.force_threshold);
        self.log.truth.push(truth);
        true
    }

    /// A pose close to the fixture that does not touch it: inside of a hole, above anything else.
    fn free_pose(&mut self, near: &Pose) -> Pose {
        let mut even = |size: f64| size * self.chance.random_range(-1.0..=1.0);
        let Parts::PegInHole(parts) = self.parts else {
            return Translation3::new(0.0, 0.0, 3e-3 + even(2e-3)) * near;
        };
        let depth = parts.depth();
        let mut wide = 1.0;
        loop {
            let place = Pose::translation(wide * even(1e-3), wide * even(1e-3), depth * (-0.5 + even(0.5)));
            let [x, y, z] = std::array::from_fn(|_| wide * even(0.03));
            let pose = place * se3::exp(&Twist::new(0.0, 0.0, 0.0, x, y, z));
            // Tighter and tighter: the middle of the hole is free, if anything is.
            if parts.gap(&pose).value > 0.05e-3 || wide < 1e-3 {
                return pose;
            }
            wide *= 0.9;
        }
    }
}

//! The calibration problem of a simulated scenario, with the scenario's nominal values.

use crate::contact::{ContactLog, Load, LoadFrame, LoadOn, RowsLeftOut, Source};
use crate::estimate::{
    Distance, EXACT_DISTANCE_SIGMA, EstimatorOptions, Fixture, Loss, Noise, PlacePrior, Problem, ShapeTolerance, Tool,
    TrendVariable, UnseenEffects, WrenchTolerance,
};
use crate::geometry::Parts;
use crate::manifold::exact_manifold;
use crate::parameter::{Block, Parameter, joint_trend_with_sigma, joint_walk, of_block};
use crate::sim::{PlaceError, Recorder, Scenario, SimulatedTrial, Touch, Truth};

/// Smallest declared noise (rad, m): weights need some.
const LEAST_ENCODER: f64 = 2e-7;
const LEAST_CONTACT: f64 = 1e-6;
/// Declared standard deviation of the distance of fixtures on one block (m).
const SPACING_SIGMA: f64 = 1e-5;

/// The calibration problem of a simulated trial of `scenario`: its contacts, the scenario's nominal
/// arm and poses, and a fixture for each touch, in their order. `simulated` has a log for each
/// touch; of its truth only the measured distances are used.
///
/// The parameters are those that the scenario draws, encoder offsets if it draws none; poses have
/// Gaussian priors as wide as they are drawn, are fixed where they do not err, and have no prior
/// where a fixture is free. The declared noise is that of the encoders with quantisation, at least
/// 2e-7 rad, and the form errors, at least 1e-6 m. Distances are declared as they are measured,
/// with the standard deviations of their errors, at least [`EXACT_DISTANCE_SIGMA`]; those of other
/// fixtures that follow each other on one block with 1e-5 m. Contacts have their measured loads
/// without the lag of the force sensor where they are [used](uses_loads); bias, scale and noise of
/// the wrench, and trends of encoder offsets have the standard deviations from which they
/// are drawn. The arm has no errors but the estimated ones ([`UnseenEffects::Ignore`]). The loss is
/// Geman–McClure's of scale 3. Placements are the fixtures' names up to the first `/`.
pub fn problem(scenario: &Scenario, simulated: &SimulatedTrial) -> Problem {
    posed(scenario, simulated, uses_loads(scenario))
}

/// Whether the [`problem`] of a trial of `scenario` has the measured loads of its contacts: they
/// deflect joints, or tell with friction what a peg rests on. Measured joint torques take their
/// place.
pub fn uses_loads(scenario: &Scenario) -> bool {
    if scenario.recorder.joint_torque_sigma > 0.0 {
        return false;
    }
    let has_peg = || scenario.touches.iter().any(|touch| matches!(touch.parts, Parts::PegInHole(_)));
    scenario.errors.deflect_joints() || scenario.friction > 0.0 && has_peg()
}

/// The [`problem`], with the measured loads of its contacts if it `has_loads`.
pub(super) fn posed(scenario: &Scenario, simulated: &SimulatedTrial, has_loads: bool) -> Problem {
    let robot = &scenario.robot;
    let load = Load { on: LoadOn::Tool, frame: LoadFrame::Tip, lag: scenario.recorder.lag() };
    let mut contacts = ContactLog::new(robot.dof());
    for (fixture, (touch, log)) in scenario.touches.iter().zip(&simulated.logs).enumerate() {
        let file = contacts.add_file(&touch.name);
        contacts.count_rows(log.len() as u64);
        let out_of_contact = (log.len() - log.contacts().count()) as u64;
        contacts.count_left_out(RowsLeftOut { out_of_contact, ..RowsLeftOut::default() });
        contacts.set_load_lag(file, load.lag);
        for row in log.contacts() {
            contacts.push(log.q(row), fixture, Source { file, line: row as u64 + 1 });
            if has_loads {
                let before = row.checked_sub(1).map(|before| log.wrench[before]);
                contacts.set_load(load.without_lag(log.wrench[row], before));
            }
            if let Some(torques) = log.joint_torque(row) {
                contacts.set_joint_torques(torques);
            }
            if let Some(celsius) = log.arm_temperature.get(row) {
                contacts.set_temperature(*celsius);
            }
        }
    }
    let tool = Tool { tip_from_tool: scenario.tip_from_tool, prior: place_prior(scenario.tool_error) };
    let fixtures = scenario.touches.iter().map(fixture).collect();
    let mut parameters: Vec<Parameter> =
        blocks(scenario).into_iter().flat_map(|block| of_block(block, robot)).collect();
    let trend = encoder_trend(&scenario.recorder);
    if trend > 0.0 {
        parameters.extend(joint_trend_with_sigma(robot, trend));
    }
    let walk = scenario.recorder.encoder_walk;
    if walk > 0.0 {
        parameters.extend(joint_walk(robot, walk));
    }
    Problem {
        distances: distances(scenario, &simulated.truth),
        noise: noise(scenario),
        wrench: wrench(&scenario.recorder),
        trend_variable: if scenario.recorder.warm_up > 0.0 { TrendVariable::Temperature } else { TrendVariable::Log },
        parameters,
        loss: Loss::GemanMcClure(LOSS_SCALE),
        options: EstimatorOptions { unseen_effects: UnseenEffects::Ignore, ..EstimatorOptions::default() },
        ..Problem::new(robot.clone(), tool, fixtures, contacts)
    }
}

/// Scale of the robust loss (standard deviations).
pub(crate) const LOSS_SCALE: f64 = 3.0;

/// Blocks of the arm's parameters that the scenario draws, and so are estimated.
pub(crate) fn blocks(scenario: &Scenario) -> Vec<Block> {
    let errors = &scenario.errors;
    let strain = if errors.segment_strain > 0.0 { Block::SegmentStrain } else { Block::Strain };
    let origin = errors.origin_length > 0.0 || errors.origin_angle > 0.0 || errors.origin_zero > 0.0;
    let wanted = [
        (errors.strain > 0.0 || errors.segment_strain > 0.0, strain),
        (errors.joint_offset > 0.0, Block::JointOffset),
        (origin, Block::JointOrigin),
        (errors.joint_compliance > 0.0, Block::JointCompliance),
        (errors.joint_backlash > 0.0, Block::JointBacklash),
        (errors.joint_harmonic > 0.0, Block::JointHarmonic),
        (errors.joint_harmonic_2 > 0.0, Block::JointHarmonic2),
        (errors.joint_gear_ratio > 0.0, Block::JointGearRatio),
    ];
    let mut blocks: Vec<Block> = wanted.into_iter().filter(|(wanted, _)| *wanted).map(|(_, block)| block).collect();
    if blocks.is_empty() {
        blocks.push(Block::JointOffset);
    }
    blocks
}

/// The recorder's noise, including quantisation.
pub(crate) fn noise(scenario: &Scenario) -> Noise {
    let rounding = scenario.recorder.encoder_step / 12f64.sqrt();
    Noise {
        encoder: scenario.recorder.encoder_sigma.hypot(rounding).max(LEAST_ENCODER),
        contact: scenario.contact_sigma.max(LEAST_CONTACT),
        is_estimated: false,
    }
}

/// Standard deviation of the linear trend of an encoder offset (rad), that of a random walk
/// included: half of the least-squares slope of Brownian motion over a unit of time has a variance
/// of 3/10.
pub(crate) fn encoder_trend(recorder: &Recorder) -> f64 {
    recorder.encoder_trend.hypot(0.3f64.sqrt() * recorder.encoder_walk)
}

/// The standard deviations from which bias, scale and noise of the wrench are drawn.
pub(crate) fn wrench(recorder: &Recorder) -> WrenchTolerance {
    WrenchTolerance {
        force: recorder.force_bias,
        torque: recorder.torque_bias,
        scale: recorder.wrench_scale,
        force_noise: recorder.force_sigma,
        torque_noise: recorder.torque_sigma,
    }
}

/// Distances of fixtures that follow each other on one block, unless they are measured, and
/// distances that are measured.
pub(crate) fn distances(scenario: &Scenario, truth: &Truth) -> Vec<Distance> {
    let place = |touch: &Touch| touch.base_from_fixture.translation.vector;
    let is_measured =
        |a: usize, b: usize| scenario.distances.iter().any(|d| d.between == (a, b) || d.between == (b, a));
    let pairs = scenario.touches.windows(2).enumerate();
    let on_one_block = pairs.filter(|(f, pair)| pair[0].block() == pair[1].block() && !is_measured(*f, f + 1));
    let on_one_block = on_one_block.map(|(first, pair)| Distance {
        between: (first, first + 1),
        distance: (place(&pair[1]) - place(&pair[0])).norm(),
        sigma: SPACING_SIGMA,
    });
    let measured = scenario.distances.iter().enumerate().map(|(k, measured)| Distance {
        between: measured.between,
        distance: truth.measured_distance(scenario, k),
        sigma: measured.sigma.max(EXACT_DISTANCE_SIGMA),
    });
    on_one_block.chain(measured).collect()
}

fn fixture(touch: &Touch) -> Fixture {
    Fixture {
        name: touch.name.clone(),
        manifold: exact_manifold(&touch.parts).into(),
        base_from_fixture: (!touch.free).then_some(touch.base_from_fixture),
        prior: if touch.free { PlacePrior::Flat } else { place_prior(touch.place_error) },
        tolerance: ShapeTolerance {
            clearance: touch.clearance_sigma,
            depth: touch.depth_sigma,
            edge_radius: touch.edge_radius_sigma,
        },
        placement: touch.name.split('/').next().unwrap_or_default().to_owned(),
    }
}

fn place_prior(PlaceError { length, angle }: PlaceError) -> PlacePrior {
    if length > 0.0 || angle > 0.0 {
        PlacePrior::Gaussian { sigma: length, sigma_angle: angle }
    } else {
        PlacePrior::Fixed
    }
}

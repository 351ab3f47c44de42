//! The choice of a model by prediction: simulated arms that bend, and that do not.

use std::ops::ControlFlow;

use touchcal::estimate::{GroupKind, ModelChoice, Noise, Problem, SelectionError, select};
use touchcal::parameter::{Block, Unit, joint_origin};
use touchcal::robot::KinematicParameter;

use super::ball_in_sockets::{SOCKETS, ball_in_sockets};
use crate::support::{report, solve, uniform};

/// Standard deviation of the measured joint positions (rad).
const ENCODER: f64 = 5e-5;

fn choice(problem: &Problem) -> ModelChoice {
    select(problem, &|_| ControlFlow::Continue(())).expect("a choice")
}

/// A ball in four sockets, 12 contacts each, by an arm with errors of 0.3 mm and 0.1° in its joint
/// origins, and compliances of about `compliance` (rad/(N m)).
fn touching(compliance: f64, seed: u64) -> Problem {
    let robot = ball_in_sockets(&[], &[], |_, _, _, q| (q.to_vec(), None)).robot;
    let parameters = joint_origin(&robot);
    let geometry = parameters.iter().zip(uniform(parameters.len(), 100 + seed)).map(|(parameter, draw)| {
        let size = if parameter.unit == Unit::Meter { 3e-4 } else { 2e-3 };
        (parameter.id.kinematic().expect("of the arm"), size * draw)
    });
    let softness = uniform(7, 200 + seed).into_iter().enumerate();
    let softness = softness.map(|(i, draw)| (KinematicParameter::JointCompliance(i), compliance * (1.0 + 0.5 * draw)));
    let errors: Vec<(KinematicParameter, f64)> = geometry.chain(softness).collect();
    let problem = ball_in_sockets(&errors, &SOCKETS, |_, _, i, q| {
        let noise = uniform(7, 1_000_000 * seed + i).into_iter().map(|draw| 3f64.sqrt() * ENCODER * draw);
        (q.iter().zip(noise).map(|(q, noise)| q + noise).collect(), None)
    });
    let contacts = problem.contacts.filtered(|i| i % 5 == 0);
    let noise = Noise { encoder: ENCODER, contact: 1e-6, is_estimated: false };
    Problem { contacts, parameters, noise, ..problem }
}

#[test]
fn compliance_is_chosen_where_joints_bend_and_only_there() {
    for seed in 1..=2 {
        for (compliance, bends) in [(1e-4, true), (0.0, false)] {
            let choice = choice(&touching(compliance, seed));
            let model = &choice.models[choice.chosen];
            let gain = choice.gains.iter().find(|gain| gain.block == Block::JointCompliance).expect("compared");
            report(
                &format!("{}, seed {seed}", if bends { "joints that bend" } else { "stiff joints" }),
                &[("held out (mm)", 1e3 * model.held_out.mean), ("gain of compliance (mm)", 1e3 * gain.gain.mean)],
            );
            let expected = [Block::JointOrigin, Block::JointCompliance];
            assert_eq!(model.blocks, expected[..1 + usize::from(bends)], "seed {seed}");
            assert_eq!(gain.is_chosen, bends);
            assert_eq!((choice.group_kind, choice.groups.len()), (GroupKind::Fixtures, SOCKETS.len()));
            // The problem is that of the chosen model, and says so.
            assert_eq!(solve(&choice.problem).robot.is_compliant(), bends);
            let notes = choice.problem.contacts.notes().join("\n");
            let name = model.name();
            assert!(notes.contains(&format!("model: {name}; 4 fixtures, each left out")), "{notes}");
        }
    }
}

/// Contacts of two sockets are divided into regions; those of one are too few.
#[test]
fn contacts_of_two_fixtures_are_divided_into_regions() {
    let problem = touching(0.0, 1);
    let of_two = |fixtures: usize| problem.contacts.filtered(|i| problem.contacts.fixture(i) < fixtures);
    let few = Problem { contacts: of_two(1), ..problem.clone() };
    let refused = select(&few, &|_| ControlFlow::Continue(())).expect_err("too few");
    assert_eq!(refused, SelectionError::TooFewContacts { contacts: 12 });
    let two = Problem { contacts: of_two(2), parameters: Vec::new(), ..problem.clone() };
    let regions = choice(&two);
    assert_eq!((regions.group_kind, regions.groups.len()), (GroupKind::Regions, 4));
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let again = one_core.install(|| choice(&two));
    assert_eq!((again.models, again.chosen), (regions.models, regions.chosen));
    let ended = select(&problem, &|_| ControlFlow::Break(())).expect_err("ended");
    assert_eq!(ended, SelectionError::Interrupted);
}

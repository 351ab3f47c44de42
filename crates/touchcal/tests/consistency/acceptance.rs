//! Decisions at a tolerance: how often they are right, and how often there is one.

use rayon::prelude::*;
use touchcal::estimate::{Acceptance, Decision, ErrorFrame, acceptance, workspace_configurations};
use touchcal::experiment::{pose_errors, problem};
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::{Kinematics, Robot, calibrated};
use touchcal::se3::Pose;
use touchcal::sim::{self, ArmErrors, Preset};

use crate::support::{report, solve};

const FACTORS: [f64; 5] = [0.3, 1.0, 2.0, 3.0, 4.0];
/// Scenarios of the arms: what contacts leave uncertain differs from one to the next.
const PRESETS: [Preset; 4] = [Preset::Paper, Preset::LeoAluminium, Preset::LeoCfrp, Preset::Workcell];

/// Largest distance (m) of the tool from where the calibrated arm has it, over the poses of the
/// task, and the decision for each tolerance (m).
struct Arm {
    error: f64,
    decisions: Box<dyn Fn(f64) -> Decision + Send>,
}

fn arm(preset: Preset, seed: u64) -> Arm {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let scenario = preset.scenario(robot).expect("a scenario");
    let simulated = sim::simulate(&scenario, seed).expect("contacts");
    let problem = problem(&scenario, &simulated);
    let estimate = solve(&problem);
    let task = workspace_configurations(&scenario.robot, 30);
    let (columns, values) = simulated.truth.of_kinematics();
    let truth =
        Kinematics::new(&calibrated(&scenario.robot, &columns, &values), &[], simulated.truth.tip_from_tool(&scenario));
    let tip_from_tool = scenario.tip_from_tool * estimate.tool_motion().unwrap_or_default();
    let found = Kinematics::new(&estimate.robot, &[], tip_from_tool);
    let distance = |q: &Vec<f64>| (truth.pose(q).translation.vector - found.pose(q).translation.vector).norm();
    let error = task.iter().map(distance).fold(0.0, f64::max);
    let decisions = move |tolerance: f64| {
        let asked = Acceptance {
            distance: tolerance,
            angle: None,
            confidence: 0.95,
            frame: ErrorFrame::Base,
            positions: task.clone(),
        };
        acceptance(&asked, &problem, &estimate).decision
    };
    Arm { error, decisions: Box::new(decisions) }
}

/// Of `count` arms of each scenario at tolerances around the median error of the scenario.
fn decisions_are_right(count: usize) {
    let arms: Vec<Arm> =
        (0..PRESETS.len() * count).into_par_iter().map(|k| arm(PRESETS[k / count], k as u64)).collect();
    let medians = arms.chunks(count).map(|arms| {
        let mut errors: Vec<f64> = arms.iter().map(|arm| arm.error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        errors[count / 2]
    });
    let medians: Vec<f64> = medians.collect();
    let [mut passes, mut wrong_passes, mut fails, mut wrong_fails] = [0.0; 4];
    for factor in FACTORS {
        let (mut passed, mut failed) = (0.0, 0.0);
        for (k, arm) in arms.iter().enumerate() {
            let tolerance = factor * medians[k / count];
            match (arm.decisions)(tolerance) {
                Decision::Pass => {
                    passed += 1.0;
                    wrong_passes += f64::from(arm.error > tolerance);
                }
                Decision::Fail => {
                    failed += 1.0;
                    wrong_fails += f64::from(arm.error <= tolerance);
                }
                Decision::Undecided => {}
            }
        }
        (passes, fails) = (passes + passed, fails + failed);
        let all = arms.len() as f64;
        let shares = [("passed", passed / all), ("failed", failed / all)];
        report(&format!("tolerance of {factor} times the median error"), &shares);
        assert!(factor < 3.0 || passed >= 0.6 * all, "{factor}: {passed} of {all} pass");
        assert!(factor > 0.3 || failed >= 0.6 * all, "{factor}: {failed} of {all} fail");
    }
    report("wrong decisions", &[("passes", wrong_passes / passes), ("fails", wrong_fails / fails)]);
    for (wrong, of) in [(wrong_passes, passes), (wrong_fails, fails)] {
        // At most 5 %, and two standard errors.
        let most: f64 = 0.05 + 2.0 * (0.05 * 0.95 / of).sqrt();
        assert!(wrong <= most * of, "{wrong} of {of} are wrong");
    }
}

#[test]
fn without_parameters_of_the_arm_nothing_is_decided() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Workcell.scenario(robot).expect("a scenario");
    scenario.contacts = 300;
    scenario.errors = ArmErrors::NONE;
    let simulated = sim::simulate(&scenario, 1).expect("contacts");
    let task = workspace_configurations(&scenario.robot, 30);
    let asked = Acceptance { distance: 1.0, angle: None, confidence: 0.95, frame: ErrorFrame::Base, positions: task };
    let problem = problem(&scenario, &simulated).with_parameters(Vec::new());
    let decision = acceptance(&asked, &problem, &solve(&problem));
    assert_eq!((decision.decision, decision.errors), (Decision::Undecided, None));
}

/// In sockets of unknown place nothing is decided in base, and with the base aligned as often right
/// as elsewhere.
#[test]
fn in_sockets_of_unknown_place_the_base_is_aligned() {
    let robot = urdf::read_builtin("iiwa14", Ends::default()).expect("built in").robot;
    let mut scenario = Preset::Mukca.scenario(robot).expect("a scenario");
    scenario.contacts = 30;
    let (mut within, mut passes, mut wrong) = (0, 0, 0);
    for seed in 0..6 {
        let simulated = sim::simulate(&scenario, seed).expect("contacts");
        let problem = problem(&scenario, &simulated);
        let task = workspace_configurations(&scenario.robot, 30);
        let asked =
            |frame| Acceptance { distance: 6e-3, angle: None, confidence: 0.95, frame, positions: task.clone() };
        let estimate = solve(&problem);
        let [in_base, aligned] =
            [ErrorFrame::Base, ErrorFrame::BaseAligned].map(|frame| acceptance(&asked(frame), &problem, &estimate));
        let advice = in_base.advice(&asked(ErrorFrame::Base));
        assert_ne!(in_base.decision, Decision::Pass);
        let (of_base, of_aligned) = (in_base.errors.expect("errors"), aligned.errors.expect("errors"));
        assert_eq!(of_base.aligned_probability, Some(of_aligned.probability));
        let probability = format!("with the base aligned the probability is {:.1} %", 100.0 * of_aligned.probability);
        assert!(advice.starts_with("no fixture has a place in base") && advice.ends_with(&probability), "{advice}");

        let (columns, values) = simulated.truth.of_kinematics();
        let truth = calibrated(&scenario.robot, &columns, &values);
        let tip_from_tool = scenario.tip_from_tool * estimate.tool_motion().unwrap_or_default();
        let pose = |arm: &Robot, tool: Pose| {
            let kinematics = Kinematics::new(arm, &[], tool);
            task.iter().map(|q| kinematics.pose(q)).collect::<Vec<Pose>>()
        };
        let errors =
            pose_errors(&pose(&truth, simulated.truth.tip_from_tool(&scenario)), &pose(&estimate.robot, tip_from_tool));
        let error = errors.aligned_position.max;
        passes += u32::from(aligned.decision == Decision::Pass);
        wrong += u32::from(aligned.decision == Decision::Pass && error > 6e-3);
        within += u32::from(error <= of_aligned.distance);
    }
    let shares = [("passes", passes), ("wrong", wrong), ("within the bound", within)];
    report("six arms in sockets, base aligned", &shares.map(|(name, count)| (name, f64::from(count))));
    // 95 % of six, and three standard errors.
    assert!(within >= 4 && passes > 0 && wrong == 0, "{shares:?}");
}

#[test]
fn passes_and_fails_are_right() {
    decisions_are_right(16);
}

#[test]
#[ignore = "long form: scripts/test long"]
fn passes_and_fails_of_many_arms_are_right() {
    decisions_are_right(250);
}

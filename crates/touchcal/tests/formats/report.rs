//! The report: whole, harmless, small, and true to the calibration. What a browser makes of it is
//! tested by scripts/check_report.py.

use std::ops::ControlFlow;

use crate::support::{data, mujoco_trial};
use nalgebra::{Cholesky, DMatrix, DVector};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use serde_json::Value;
use touchcal::contact::{ContactLog, Source};
use touchcal::estimate::{
    CompetingMinimum, Estimate, PlacePrior, Problem, Progress, UnseenEffects, calibrate, distance_uncertainty,
    evaluate, evaluate_held_out, tool_uncertainty, workspace_configurations,
};
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::parameter::{ParameterId, joint_offset, kinematic_part};
use touchcal::report::{EvaluationReport, Input, MOST_DRAWN, Report, WarningText};
use touchcal::robot::{Kinematics, Robot};

const MOST_BYTES: usize = 6_000_000;

pub(super) fn sockets() -> Problem {
    let folder = data().join("mukca");
    let file = urdf::read_file(&folder.join("iiwa14.urdf"), Ends::default()).expect("a URDF");
    mukca::read(&folder.join("kuka_14"), file, &MukcaOptions::default()).expect("contacts").problem
}

/// The same contacts over and over.
fn repeated(problem: &mut Problem, times: usize) {
    let log = &problem.contacts;
    let mut longer = ContactLog::new(log.dof());
    log.files().iter().for_each(|name| {
        longer.add_file(name.clone());
    });
    for _ in 0..times {
        (0..log.len()).for_each(|i| longer.push(log.q(i), log.fixture(i), log.source(i)));
    }
    problem.contacts = longer;
}

pub(super) fn solve(problem: &Problem) -> (Estimate, Vec<Progress>) {
    let mut steps = Vec::new();
    let estimate = calibrate(problem, &mut |progress| {
        steps.push(*progress);
        ControlFlow::Continue(())
    });
    (estimate, steps)
}

pub(super) fn page(problem: &Problem, estimate: &Estimate, steps: &[Progress]) -> String {
    let warnings = estimate.warnings.iter();
    let warnings: Vec<WarningText> = warnings
        .map(|w| WarningText { severity: w.severity(), message: w.message(), advice: w.advice().to_owned() })
        .collect();
    let inputs = [Input { path: problem.contacts.files()[0].clone(), sha256: "0".repeat(64) }];
    let prefit = &evaluate(problem);
    let created = Some("2026-01-02T03:04:05Z");
    Report { problem, estimate, prefit, steps, created, warnings: &warnings, inputs: &inputs }.html().expect("a page")
}

/// The page of an evaluation of the nominal arm.
fn evaluation_page(problem: &Problem, evaluated: &str) -> String {
    let report = EvaluationReport {
        problem,
        evaluated,
        nominal: &evaluate(problem),
        evaluation: &evaluate_held_out(problem, problem, None),
        is_calibrated: false,
        status: None,
        created: None,
        tool_errors: &[],
        warnings: &[],
        inputs: &[],
    };
    report.html().expect("a page")
}

/// The data of the page.
pub(super) fn content(page: &str) -> Value {
    let data = page.split("id=\"data\">").nth(1).and_then(|rest| rest.split("</script").next()).expect("data");
    serde_json::from_str(data).expect("JSON")
}

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn the_page_is_whole_and_loads_nothing() {
    let problem = sockets();
    let (estimate, steps) = solve(&problem);
    let page = page(&problem, &estimate, &steps);
    assert!(page.starts_with("<!doctype html>") && page.trim_end().ends_with("</html>"));
    assert!(page.contains(
        "content=\"default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:\""
    ));
    for mark in [
        "/*data*/",
        "/*page.css*/",
        "/*elements.js*/",
        "/*text.js*/",
        "/*charts.js*/",
        "/*arm.js*/",
        "/*plot.js*/",
        "/*three.js*/",
    ] {
        assert!(!page.contains(mark), "{mark} was not filled in");
    }
    for loads in [" src=", " href=", "<link", "<iframe", "@import", "url("] {
        let mark = |part: &str| part.contains(loads);
        let skeleton = page.split("<script").filter_map(|part| part.split_once("</script>")).map(|(_, after)| after);
        assert!(!skeleton.chain(page.split("<script").take(1)).any(mark), "{loads}");
    }
    // Names of namespaces and of a licence; nothing else looks like an address.
    for address in page.split("http").skip(1).filter(|rest| rest.starts_with("://") || rest.starts_with("s://")) {
        let host = address.trim_start_matches('s').trim_start_matches("://").split('/').next().unwrap_or("");
        assert!(["www.w3.org", "www.apache.org"].contains(&host), "{host}");
    }
}

#[test]
fn hostile_names_are_harmless() {
    let tame = sockets();
    let (estimate, steps) = solve(&tame);
    let usual = page(&tame, &estimate, &steps).matches("</script").count();

    let nasty = "</script><script>alert(1)</script><!--<script>&amp;\"'\\u003c\u{2028}`${x}/*data*/";
    let mut problem = sockets();
    let mut joints = problem.robot.joints().to_vec();
    for (i, joint) in joints.iter_mut().enumerate() {
        joint.name = format!("{i}{nasty}");
    }
    problem.robot = Robot::new(nasty, nasty, joints).expect("a robot");
    problem.parameters = joint_offset(&problem.robot);
    for (f, fixture) in problem.fixtures.iter_mut().enumerate() {
        fixture.name = format!("{f}{nasty}");
    }
    let mut log = ContactLog::new(problem.contacts.dof());
    log.add_file(nasty);
    for i in 0..problem.contacts.len() {
        log.push(problem.contacts.q(i), problem.contacts.fixture(i), Source { file: 0, line: i as u64 + 1 });
    }
    problem.contacts = log;
    let (estimate, steps) = solve(&problem);
    let page = page(&problem, &estimate, &steps);
    assert_eq!(page.matches("</script").count(), usual, "no name ends a script");
    assert_eq!(page.matches("<!--").count(), 0, "nor begins a comment");
    let content = content(&page);
    assert_eq!(content["robot"]["name"], nasty);
    assert_eq!(content["fixtures"][1]["name"], format!("1{nasty}"));
    assert_eq!(content["contacts"]["files"][0], nasty);
    assert_eq!(content["inputs"][0]["path"], nasty);
    assert!(content["parameters"]["each"][0]["name"].as_str().unwrap().ends_with(nasty));

    let usual = evaluation_page(&tame, "arm.urdf").matches("</script").count();
    let page = evaluation_page(&problem, nasty);
    assert_eq!(page.matches("</script").count(), usual, "no name ends a script");
    assert_eq!(page.matches("<!--").count(), 0, "nor begins a comment");
    assert_eq!(self::content(&page)["evaluated"], nasty);
    assert_eq!(self::content(&page)["fixtures"][1]["name"], format!("1{nasty}"));
}

#[test]
fn the_page_contains_the_estimate() {
    let (mut problem, _) = mujoco_trial("extrusion/paper/trial_00");
    problem.fixtures[0].prior = PlacePrior::Flat;
    let (estimate, steps) = solve(&problem);
    let content = content(&page(&problem, &estimate, &steps));
    assert_eq!(content["status"], estimate.status.name());
    assert_eq!(content["contacts"]["used"], estimate.contacts.used);
    assert_eq!(content["all"]["after"]["rms"].as_f64(), Some(estimate.postfit.all.rms));
    let bars = content["contacts"]["histogram"].as_array().unwrap();
    for key in ["before", "after"] {
        let sum: u64 = bars.iter().map(|bar| bar[key].as_u64().unwrap()).sum();
        assert_eq!(sum, problem.contacts.len() as u64, "{key}: every contact is in one bar");
    }
    // All contacts of this log are drawn, so their distances make the scores.
    let after = floats(&content["contacts"]["drawn"]["after"]);
    assert_eq!(after.len(), problem.contacts.len());
    let rms = (after.iter().map(|d| d * d).sum::<f64>() / after.len() as f64).sqrt();
    assert!((rms / estimate.postfit.all.rms - 1.0).abs() < 1e-6);
    // Each distance is the norm of its residual, which has one row for a hole.
    let residuals = content["contacts"]["drawn"]["residual"].as_array().unwrap();
    for (distance, residual) in after.iter().zip(residuals) {
        let rows = floats(residual);
        assert!((rows[0].abs() - distance).abs() < 1e-9 && rows[1..] == [0.0, 0.0], "{distance} m, {rows:?}");
    }
    assert_eq!(content["fixtures"][0]["residual"], "gap");
    assert_eq!(content["created"], "2026-01-02T03:04:05Z");
    let noise = &content["settings"]["found"];
    assert_eq!(noise["contact"].as_f64(), Some(estimate.noise.contact));
    // The tool's places over the workspace are those of the calibrated arm.
    let tool = problem.tool.tip_from_tool * estimate.tool_motion().unwrap_or_else(touchcal::se3::Pose::identity);
    let kinematics = Kinematics::new(&estimate.robot, &[], tool);
    let places = content["uncertainty"]["workspace"].as_array().unwrap();
    for (q, place) in workspace_configurations(&problem.robot, places.len()).iter().zip(places) {
        let expected = kinematics.pose(q).translation.vector;
        let [radius, height] = ["radius", "height"].map(|key| place[key].as_f64().unwrap());
        assert!((radius - expected.xy().norm()).abs() < 1e-6 && (height - expected.z).abs() < 1e-6);
    }
    let before = floats(&content["contacts"]["drawn"]["before"]);
    let mean = before.iter().sum::<f64>() / before.len() as f64;
    assert!((mean / evaluate(&problem).all.mean - 1.0).abs() < 1e-6);
    let outlier = &content["contacts"]["outliers"][0];
    let i = outlier["index"].as_u64().unwrap() as usize;
    assert_eq!(outlier["line"], problem.contacts.source(i).line);
    assert!((outlier["after"].as_f64().unwrap() / after[i] - 1.0).abs() < 1e-6);

    let of = |name: &str| {
        let each = content["parameters"]["each"].as_array().unwrap();
        each.iter().find(|entry| entry["name"] == name).unwrap().clone()
    };
    let held = of("joint_offset.joint_a1")["undetermined"].as_str().unwrap().to_owned();
    assert!(held.starts_with("fixed at zero: the encoder offset of joint_a1 cannot be told from"), "{held}");
    assert!(of("joint_offset.joint_a2")["undetermined"].is_null());
    let correlation = content["parameters"]["correlation"].as_array().unwrap();
    assert!(correlation.iter().enumerate().all(|(i, row)| floats(row).len() == i));
    assert!(correlation.iter().flat_map(floats).all(|value| value.abs() <= 1.0));
    let steps_told: usize =
        content["pieces"].as_array().unwrap().iter().map(|p| p["steps"].as_array().unwrap().len()).sum();
    assert_eq!(steps_told, steps.len());
}

/// A hole half a millimetre beside the place that is declared exact, with notes of the reader.
#[test]
fn the_page_says_what_contacts_contradict_and_what_is_assumed() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_01");
    let right = solve(&problem).0;
    let effects = |estimate: &Estimate, problem: &Problem| {
        content(&page(problem, estimate, &[]))["declarations"]["effects"].as_array().unwrap().clone()
    };
    assert!(effects(&right, &problem).iter().all(|effect| effect["is_significant"] == false));
    assert_eq!(effects(&right, &problem).len(), 9);
    let declared = content(&page(&problem, &right, &[]))["declarations"]["declared"].as_array().unwrap().clone();
    let names: Vec<&str> = declared.iter().filter_map(|test| test["name"].as_str()).collect();
    assert_eq!(names.len(), right.prior_tests.len());
    assert!(names.contains(&"gap_bias.hole") && declared.iter().all(|test| test["is_significant"] == false));
    assert!(declared.iter().all(|test| test["radius"].is_null()));

    let place = problem.fixtures[0].base_from_fixture.as_mut().unwrap();
    *place *= touchcal::se3::Pose::translation(0.3e-3, -0.3e-3, 0.3e-3);
    problem.contacts.note("assumed: the angles are in degrees");
    let (mut estimate, _) = solve(&problem);
    let values = estimate.values() + DVector::repeat(estimate.parameters.len(), 0.5e-3);
    let parameter = 3;
    estimate.competing_minima = vec![CompetingMinimum { values, cost_ratio: 1.1, tool_distance: 12.5e-3, parameter }];
    let shown = effects(&estimate, &problem);
    let of_hole = shown.iter().find(|effect| effect["name"] == "fixture.hole").unwrap();
    let test = estimate.effect_tests.iter().find(|test| test.effect.name() == "fixture.hole").unwrap();
    assert_eq!(of_hole["is_significant"], true);
    assert_eq!(of_hole["p_value"], format!("{:.0e}", test.p_value));
    assert_eq!(of_hole["description"], "fixture `hole` is not where it is declared");
    assert_eq!(of_hole["declared_in"], "base_from_fixture in [[fixture]] hole");
    assert_eq!(of_hole["displacement"].as_f64(), Some(test.displacement));
    // Gravity makes no torque about the first joint's axis.
    let compliances = shown.iter().find(|effect| effect["name"] == "joint_compliance").unwrap()["values"].clone();
    let names: Vec<&str> = compliances.as_array().unwrap().iter().filter_map(|value| value["name"].as_str()).collect();
    assert!(names.contains(&"joint_compliance.joint_a4") && !names.contains(&"joint_compliance.joint_a1"), "{names:?}");
    let values = of_hole["values"].as_array().unwrap();
    let deviations = |value: &Value| (value["value"].as_f64().unwrap() / value["sigma"].as_f64().unwrap()).abs();
    assert!(values.windows(2).all(|pair| deviations(&pair[0]) >= deviations(&pair[1])) && values.len() == 6);
    let x = values.iter().find(|value| value["name"] == "fixture.hole.x").unwrap();
    assert_eq!((x["unit"].as_str(), x["value"].as_f64()), (Some("m"), Some(test.values[0].value)));
    let content = content(&page(&problem, &estimate, &[]));
    assert_eq!(
        content["declarations"]["notes"].as_array().unwrap().last().unwrap(),
        "assumed: the angles are in degrees"
    );
    let other = &content["declarations"]["minima"][0];
    assert_eq!((other["tool_distance"].as_f64(), other["cost_ratio"].as_f64()), (Some(12.5e-3), Some(1.1)));
    let entry = &estimate.parameters[parameter];
    assert_eq!((other["parameter"].as_str(), other["unit"].as_str()), (Some(&*entry.parameter.name), Some("rad")));
    assert_eq!(other["here"].as_f64(), Some(entry.value));
    assert_eq!(other["there"].as_f64(), Some(entry.value + 0.5e-3));
}

#[test]
fn many_contacts_make_no_large_page() {
    let mut problem = sockets();
    let (estimate, steps) = solve(&problem);
    // The page of many contacts needs their estimate only for its verdicts.
    let long = |problem: &mut Problem, times: usize| {
        repeated(problem, times);
        let estimate = Estimate { verdicts: estimate.verdicts.repeat(times), ..estimate.clone() };
        page(problem, &estimate, &steps)
    };
    let page = long(&mut problem, 81);
    println!("{} contacts: {:.2} MB", problem.contacts.len(), page.len() as f64 / 1e6);
    assert!(problem.contacts.len() > 10_000 && page.len() < MOST_BYTES);
    let page_of_10000 = page.len();

    let mut problem = sockets();
    let page = long(&mut problem, 2000);
    println!("{} contacts: {:.2} MB", problem.contacts.len(), page.len() as f64 / 1e6);
    assert!(page.len() < page_of_10000 * 11 / 10);
    let content = content(&page);
    let drawn = floats(&content["contacts"]["drawn"]["index"]);
    assert!(drawn.len() <= MOST_DRAWN && drawn.len() > MOST_DRAWN / 2, "{}", drawn.len());
    assert!(drawn.windows(2).all(|pair| pair[0] < pair[1]));
    let most = floats(&content["contacts"]["drawn"]["after"]).into_iter().fold(0.0, f64::max);
    assert!((most / estimate.postfit.all.max - 1.0).abs() < 1e-6, "the farthest is among them");
    let bars = content["contacts"]["histogram"].as_array().unwrap();
    let counted: u64 = bars.iter().map(|bar| bar["after"].as_u64().unwrap()).sum();
    assert_eq!(counted, problem.contacts.len() as u64, "counted are all");
    assert_eq!(page, long(&mut sockets(), 2000), "the same bytes again");
}

#[test]
fn a_problem_without_contacts_has_a_page() {
    let mut problem = sockets();
    problem.contacts = problem.contacts.filtered(|_| false);
    let (estimate, steps) = solve(&problem);
    let content = content(&page(&problem, &estimate, &steps));
    assert_eq!(content["status"], "not_usable");
    assert_eq!(content["contacts"]["drawn"]["index"].as_array().map(Vec::len), Some(0));
}

/// What was held is not known: with nothing in reach of the base joint's zero, the arm turns by
/// five degrees as a whole, and distances stay.
#[test]
fn uncertainty_of_the_tool_includes_fixed_parameters() {
    let (mut problem, _) = mujoco_trial("extrusion/rich/trial_00");
    problem.fixtures[0].prior = PlacePrior::Flat;
    problem.options.unseen_effects = UnseenEffects::Ignore;
    let (estimate, _) = solve(&problem);
    assert_eq!(estimate.parameter("joint_offset.joint_a1").map(|entry| entry.value), Some(0.0), "held");
    let poses = workspace_configurations(&problem.robot, 50);
    let places = tool_uncertainty(&problem, &estimate, poses.iter().map(Vec::as_slice)).expect("an uncertainty");
    let kinematics = Kinematics::new(&estimate.robot, &[], problem.tool.tip_from_tool);
    for (q, found) in poses.iter().zip(&places) {
        let reach = kinematics.pose(q).translation.vector.xy().norm();
        let turned = reach * 5f64.to_radians();
        assert!(found.position >= 0.999 * turned, "{} m at a reach of {reach} m", found.position);
        assert!(found.angle >= 0.999 * 5f64.to_radians());
    }
    let distances = distance_uncertainty(&problem, &estimate, &poses).expect("an uncertainty");
    assert!(distances.iter().all(|sigma| *sigma < 1e-3), "{distances:?}");
}

/// Against parameters drawn from the covariance and put into the arm.
#[test]
fn uncertainty_of_the_tool_is_the_scatter_of_drawn_arms() {
    const DRAWS: usize = 4000;
    let problem = sockets();
    let (estimate, _) = solve(&problem);
    let poses = workspace_configurations(&problem.robot, 4);
    let found = tool_uncertainty(&problem, &estimate, poses.iter().map(Vec::as_slice)).expect("an uncertainty");
    let distances = distance_uncertainty(&problem, &estimate, &poses).expect("an uncertainty");

    let columns: Vec<ParameterId> = estimate.parameters.iter().map(|entry| entry.parameter.id).collect();
    let of_kinematics = |theta: &DVector<f64>| kinematic_part(columns.iter().copied().zip(theta.iter().copied()));
    let (parameters, values) = of_kinematics(&estimate.values());
    let mut kinematics = Kinematics::new(&problem.robot, &parameters, problem.tool.tip_from_tool);
    let scale =
        DVector::from_iterator(columns.len(), estimate.covariance.diagonal().iter().map(|v| v.sqrt().max(1e-12)));
    let scaled = DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
        estimate.covariance[(i, j)] / (scale[i] * scale[j]) + if i == j { 1e-9 } else { 0.0 }
    });
    let factor = Cholesky::new(scaled).expect("a covariance").l();
    let mut chance = Pcg64::seed_from_u64(1);
    kinematics.set(&values);
    let middle: Vec<_> = poses.iter().map(|q| kinematics.pose(q)).collect();
    let (mut place, mut angle, mut between) = (vec![0.0; 4], vec![0.0; 4], vec![0.0; 3]);
    for _ in 0..DRAWS {
        let normal = DVector::from_fn(columns.len(), |_, _| StandardNormal.sample(&mut chance));
        let theta = estimate.values() + (&factor * normal).component_mul(&scale);
        kinematics.set(&of_kinematics(&theta).1);
        let drawn: Vec<_> = poses.iter().map(|q| kinematics.pose(q)).collect();
        for k in 0..4 {
            place[k] += (drawn[k].translation.vector - middle[k].translation.vector).norm_squared();
            angle[k] += middle[k].rotation.angle_to(&drawn[k].rotation).powi(2);
        }
        for k in 0..3 {
            let apart = |of: &[touchcal::se3::Pose]| (of[k + 1].translation.vector - of[k].translation.vector).norm();
            between[k] += (apart(&drawn) - apart(&middle)).powi(2);
        }
    }
    let close = |sum: f64, sigma: f64| {
        let ratio = (sum / DRAWS as f64).sqrt() / sigma;
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    };
    for k in 0..4 {
        close(place[k], found[k].position);
        close(angle[k], found[k].angle);
    }
    (0..3).for_each(|k| close(between[k], distances[k]));
}

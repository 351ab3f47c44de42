//! Real arms: contacts of a ball in sockets, scored on placements that the fit never saw.

use crate::support::{data, report, solve};
use touchcal::estimate::evaluate;
use touchcal::io::Loaded;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::urdf::{self, Ends};
use touchcal::robot::Robot;

/// An arm's folder and URDF, and whether its joints are taken to bend.
#[derive(Clone, Copy)]
struct Arm {
    folder: &'static str,
    urdf: &'static str,
    bends: bool,
}

const KUKA_14: Arm = Arm { folder: "kuka_14", urdf: "iiwa14.urdf", bends: false };
const PANDA_1: Arm = Arm { folder: "panda_1", urdf: "panda.urdf", bends: false };
const PANDA_3: Arm = Arm { folder: "panda_3", urdf: "panda.urdf", bends: false };
const DINOVA_2: Arm = Arm { folder: "dinova_2", urdf: "gen3lite.urdf", bends: false };

impl Arm {
    fn bending(self) -> Arm {
        Arm { bends: true, ..self }
    }

    fn load(self, only: &[&str]) -> Loaded {
        let folder = data().join("mukca");
        let file = urdf::read_file(&folder.join(self.urdf), Ends::default()).expect("a URDF");
        let only = only.iter().map(|name| (*name).to_owned()).collect();
        let options = MukcaOptions { only, joint_compliance: self.bends, ..MukcaOptions::default() };
        mukca::read(&folder.join(self.folder), file, &options).expect("placements")
    }

    fn placements(self) -> Vec<String> {
        mukca::placement_names(&data().join("mukca").join(self.folder)).expect("placements")
    }

    /// The arm fitted to these placements, with the place of its ball.
    fn fitted(self, train: &[&str]) -> Robot {
        let estimate = solve(&self.load(train).problem);
        assert!(estimate.status.is_usable(), "{} {train:?}: {:?}", self.folder, estimate.warnings);
        let motion = estimate.tool_motion().expect("the ball's place");
        estimate.robot.with_tip_moved(&motion).expect("a fixed tip")
    }

    /// Mean distance (mm) from the sockets' means of one placement, by the nominal arm and by
    /// `fitted`.
    fn score(self, fitted: &Robot, test: &str) -> (f64, f64) {
        let mut problem = self.load(&[test]).problem;
        let nominal = evaluate(&problem).all.mean * 1e3;
        problem.robot = fitted.clone();
        (nominal, evaluate(&problem).all.mean * 1e3)
    }

    /// The score of one placement, by the nominal arm and by one fitted to `train`.
    fn held_out(self, train: &[&str], test: &str) -> (f64, f64) {
        self.score(&self.fitted(train), test)
    }

    /// Mean over placements of the score held out, each placement fitted without: at most `limit`
    /// (mm).
    fn leave_one_out(self, limit: f64) -> f64 {
        let Arm { folder, bends, .. } = self;
        let names = self.placements();
        let mut before = 0.0;
        let each = names.iter().map(|test| {
            let train: Vec<&str> = names.iter().filter(|name| *name != test).map(String::as_str).collect();
            let (nominal, calibrated) = self.held_out(&train, test);
            println!("{folder} without {test}, bends {bends}: {nominal:.3} mm nominal, {calibrated:.4} mm held out");
            assert!(calibrated < nominal, "{folder} without {test}: {calibrated} mm, nominal {nominal} mm");
            before += nominal / names.len() as f64;
            calibrated
        });
        let each: Vec<f64> = each.collect();
        let mean = each.iter().sum::<f64>() / names.len() as f64;
        let max = each.iter().copied().fold(0.0, f64::max);
        let figures = [("nominal", before), ("calibrated", mean), ("max", max), ("limit", limit)];
        report(&format!("{folder}, each placement left out{}", if bends { ", bending" } else { "" }), &figures);
        assert!(mean <= limit, "{folder}, bends {bends}: {mean} mm");
        mean
    }
}

#[test]
fn kuka_14_fitted_in_front_reaches_the_left_back() {
    let (nominal, calibrated) = KUKA_14.held_out(&["front"], "left_back");
    let what = "kuka_14, fitted on front, scored on left_back";
    report(what, &[("nominal", nominal), ("calibrated", calibrated), ("max", calibrated), ("limit", 0.15)]);
    assert!(calibrated <= 0.15, "{calibrated} mm");
    let (_, bending) = KUKA_14.bending().held_out(&["front"], "left_back");
    let figures = [("nominal", nominal), ("calibrated", bending), ("max", bending), ("limit", calibrated)];
    report(&format!("{what}, bending"), &figures);
    assert!(bending <= calibrated, "{bending} mm");
}

#[test]
fn kuka_14_leave_one_placement_out() {
    let rigid = KUKA_14.leave_one_out(0.15);
    KUKA_14.bending().leave_one_out(rigid);
}

#[test]
fn panda_1_leave_one_placement_out() {
    let rigid = PANDA_1.leave_one_out(0.70);
    PANDA_1.bending().leave_one_out(rigid);
}

/// 0.1962 mm is what a purely geometric model reaches; fitted to all placements it leaves 0.188 mm,
/// because the arm bends.
#[test]
fn panda_3_leave_one_placement_out() {
    PANDA_3.leave_one_out(0.1965);
    PANDA_3.bending().leave_one_out(0.195);
}

/// The gen3 lite has backlash, so full models overfit easily.
#[test]
fn dinova_2_leave_one_placement_out() {
    for arm in [DINOVA_2, DINOVA_2.bending()] {
        arm.leave_one_out(3.1);
    }
}

/// A fit to a single placement must not make other places worse.
#[test]
fn one_placement_does_not_spoil_the_others() {
    for arm in [KUKA_14, PANDA_1, PANDA_3].into_iter().flat_map(|arm| [arm, arm.bending()]) {
        let Arm { folder, bends, .. } = arm;
        let names = arm.placements();
        for train in &names {
            let fitted = arm.fitted(&[train.as_str()]);
            for test in names.iter().filter(|name| *name != train) {
                let (nominal, calibrated) = arm.score(&fitted, test);
                println!("{folder} {train} → {test}, bends {bends}: {calibrated:.3} mm, nominal {nominal:.3} mm");
                assert!(calibrated < nominal, "{folder} {train} → {test}: {calibrated} mm, nominal {nominal} mm");
            }
        }
    }
}

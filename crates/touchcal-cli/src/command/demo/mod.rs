//! `touchcal demo`: the whole way, without input.

mod comparison;

use std::path::Path;

use serde::Serialize;
use touchcal::experiment;
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{atomic, problem_file};
use touchcal::robot::{Block, Column};
use touchcal::sim::{Insertion, InsertionLog};

use super::{Failure, Outcome, Solved, calibrate};
use crate::args::DemoArgs;
use crate::output;
use crate::progress::{Spinner, interrupted};
use crate::summary;

/// The experiment as a user would describe it.
const PROBLEM: &str = include_str!("problem.toml");
/// Name of the problem file.
const PROBLEM_FILE: &str = "problem.toml";
/// Name of the log; the problem file refers to it.
const CONTACTS_FILE: &str = "contacts.csv";
/// Name of the file that marks a folder as a demonstration's.
const TRUTH_FILE: &str = "truth.json";

/// Simulates, writes the example, calibrates it as `touchcal calibrate` would, compares with the truth.
pub fn run(args: &DemoArgs) -> Result<Outcome, Failure> {
    spare_foreign_files(&args.out)?;
    let insertion = experiment::paper(urdf::read_builtin("iiwa14", Ends::default())?.robot, args.seed)?;
    let log = simulate(&insertion, args)?;
    let problem = args.out.join(PROBLEM_FILE);
    write_example(args, &insertion, &log)?;
    let loaded = problem_file::read_file(&problem)?;
    let solved = super::calibrate(&loaded)?;
    let Solved { estimate, prefit, .. } = &solved;
    let file = output::estimate_file(&loaded, &solved);
    output::write(&args.out, &loaded, estimate, &file)?;
    let text = [
        comparison::text(&insertion, args.seed, &loaded.problem, estimate),
        "Distance from touching (mm)\n".to_owned(),
        summary::residuals(&loaded.problem.fixtures, &[("before", prefit), ("after", &estimate.postfit)]),
        next(&args.out),
    ];
    output::print(&text.concat())?;
    Ok(calibrate::outcome(estimate.status))
}

/// An earlier demonstration may be overwritten, a user's own problem not.
fn spare_foreign_files(folder: &Path) -> Result<(), Failure> {
    let own = [PROBLEM_FILE, CONTACTS_FILE].map(|name| folder.join(name)).into_iter().find(|path| path.exists());
    match own.filter(|_| !folder.join(TRUTH_FILE).exists()) {
        Some(path) => {
            Err(Failure::Setup(format!("{} is there and not from a demo; choose another --out", path.display())))
        }
        None => Ok(()),
    }
}

fn simulate(insertion: &Insertion, args: &DemoArgs) -> Result<InsertionLog, Failure> {
    let spinner = Spinner::new("Simulating contacts");
    spinner.run();
    let log = insertion.run(args.contacts as usize, args.seed)?;
    if interrupted() { Err(Failure::Interrupted) } else { Ok(log) }
}

/// What is wrong with the simulated arm, for comparison only.
#[derive(Serialize)]
struct Truth {
    note: &'static str,
    seed: u64,
    strain: f64,
    joint_offset_rad: Vec<f64>,
}

fn write_example(args: &DemoArgs, insertion: &Insertion, log: &InsertionLog) -> Result<(), Failure> {
    let value =
        |wanted: fn(&Column) -> bool| insertion.errors.iter().filter(move |(column, _)| wanted(column)).map(|e| e.1);
    let folder = &args.out;
    let truth = Truth {
        note: "what the simulation was made with; calibrate does not read this file",
        seed: args.seed,
        strain: value(|column| *column == Column::Strain).sum(),
        joint_offset_rad: value(|column| column.block() == Block::JointOffset).collect(),
    };
    atomic::write(&folder.join(TRUTH_FILE), (serde_json::to_string_pretty(&truth)? + "\n").as_bytes())?;
    atomic::write(&folder.join(CONTACTS_FILE), csv(insertion, log).as_bytes())?;
    atomic::write(&folder.join(PROBLEM_FILE), PROBLEM.as_bytes())?;
    Ok(())
}

/// The log as an arm's recorder would write it: seconds, joint positions (rad), contact force (N).
fn csv(insertion: &Insertion, log: &InsertionLog) -> String {
    let names: Vec<&str> = insertion.robot.moving().map(|joint| joint.name.as_str()).collect();
    let mut text = format!("t,{},force_n\n", names.join(","));
    for ((time, q), force) in log.time.iter().zip(&log.q).zip(&log.force) {
        let q: Vec<String> = q.iter().map(|q| format!("{q:.9}")).collect();
        text.push_str(&format!("{time:.4},{},{force:.3}\n", q.join(",")));
    }
    text
}

fn next(folder: &Path) -> String {
    let folder = folder.display();
    [
        format!("Written to {folder}: problem.toml and contacts.csv (an example to start from), truth.json,\n"),
        "calibrated.urdf and estimate.json.\n\n".to_owned(),
        "Try next\n".to_owned(),
        format!("  touchcal inspect {folder}/problem.toml\n"),
        format!("  touchcal calibrate {folder}/problem.toml --out {folder}/again\n"),
        format!("  touchcal evaluate {folder}/problem.toml --urdf {folder}/calibrated.urdf\n"),
    ]
    .concat()
}

//! `touchcal new`: a template problem, and instructions for recording.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use touchcal::io::atomic;
use touchcal::io::mukca::{self, MukcaOptions};
use touchcal::io::socket_logs::{self, SocketLog};
use touchcal::io::urdf::{self, Ends};

use crate::args::{NewArgs, Start};
use crate::failure::{Failure, Outcome};
use crate::output;
use crate::summary::wrapped;

/// The files of a new problem, by name.
fn files(start: Start) -> [(&'static str, &'static str); 2] {
    let (problem, readme) = match start {
        Start::PegInHole => (include_str!("peg_in_hole.toml"), include_str!("peg_in_hole.md")),
        Start::Sockets => (include_str!("sockets.toml"), include_str!("sockets.md")),
        Start::Planes => (include_str!("planes.toml"), include_str!("planes.md")),
    };
    [("README.md", readme), ("problem.toml", problem)]
}

/// Writes the complete problem of recorded logs, unless it is there.
fn from_logs(args: &NewArgs, urdf: &Path) -> Result<Outcome, Failure> {
    if args.kind != Start::Sockets {
        return Err(Failure::Usage(
            "--from reads logs of sockets: touchcal new sockets --from DIR --urdf FILE".to_owned(),
        ));
    }
    let folder = args.out.clone().unwrap_or_else(|| args.kind.name().into());
    let path = folder.join("problem.toml");
    atomic::remove_left_over(&folder);
    if path.exists() {
        return Err(Failure::Setup(format!("{} is there already; choose another --out", path.display())));
    }
    let tip = args.tip.as_deref();
    urdf::read_file(urdf, Ends { base: None, tip })?;
    let options = MukcaOptions {
        spacing: args.spacing_mm * 1e-3,
        joint_compliance: args.joint_compliance,
        ball_in_tip: Vector3::from_iterator(args.ball_mm.iter().map(|mm| mm * 1e-3)),
        ..MukcaOptions::default()
    };
    let logs = socket_logs::find(&args.from)?;
    output::notes(&notes(&args.from, &logs)?);
    let text = mukca::problem_text(&folder, &logs, (urdf, tip), &options)?;
    atomic::write(&path, text.as_bytes())?;
    let (path, distances) = (path.display(), distances(&logs, args.spacing_mm));
    output::print(&format!(
        "Written   {path}: the arm, the sockets and their logs\n{distances}\nTry next\n  touchcal inspect {path}\n"
    ))?;
    Ok(Outcome::Done)
}

/// What is done with files that may or may not be logs.
fn notes(names: &[PathBuf], logs: &[SocketLog]) -> Result<Vec<String>, Failure> {
    let taken = socket_logs::texts(logs).map(|SocketLog { socket, path }| {
        format!("{}: taken as the log of socket `{socket}`; if it is no log, move it elsewhere", path.display())
    });
    let not_taken = socket_logs::not_taken(names, logs)?;
    let left = not_taken.iter().map(|path| {
        format!("{}: not taken, since other logs are PLACEMENT/hole_N.csv; with its name: SOCKET=FILE", path.display())
    });
    Ok(taken.chain(left).collect())
}

/// Which distances are declared, to be checked.
fn distances(logs: &[SocketLog], spacing_mm: f64) -> String {
    let pairs: Vec<String> = mukca::neighbours(logs).map(|[a, b]| format!("{} – {}", a.socket, b.socket)).collect();
    match pairs.as_slice() {
        [] => format!(
            "Distances {}\n",
            wrapped(
                "none, because no two logs are of sockets N and N + 1 of a placement: declare those that you know as [[distance]]"
            )
        ),
        pairs => format!(
            "Distances {}\n",
            wrapped(&format!("{spacing_mm} mm of neighbours, by their numbers: {}", pairs.join(", ")))
        ),
    }
}

/// Whether a run that was ended wrote this file, the first of two, as it is.
fn is_left_over(path: &Path, text: &str) -> bool {
    !path.with_file_name("problem.toml").exists() && std::fs::read(path).is_ok_and(|found| found == text.as_bytes())
}

/// Writes the files, unless one of them is there.
pub fn run(args: &NewArgs) -> Result<Outcome, Failure> {
    if let (false, Some(urdf)) = (args.from.is_empty(), &args.urdf) {
        return from_logs(args, urdf);
    }
    let folder = args.out.clone().unwrap_or_else(|| args.kind.name().into());
    let files = files(args.kind).map(|(name, text)| (folder.join(name), text));
    atomic::remove_left_over(&folder);
    // The problem first: it is what was filled in.
    if let Some((existing, _)) = files.iter().rfind(|(path, text)| path.exists() && !is_left_over(path, text)) {
        return Err(Failure::Setup(format!("{} exists already; choose another --out", existing.display())));
    }
    for (path, text) in &files {
        atomic::write(path, text.as_bytes())?;
    }
    let folder = folder.display();
    output::print(&format!(
        "Written   {folder}/problem.toml: a template, to be filled in\n          \
         {folder}/README.md: what to record, and how to move the arm\n\n\
         Next, with the URDF and the logs in place\n  touchcal inspect {folder}/problem.toml\n"
    ))?;
    Ok(Outcome::Done)
}

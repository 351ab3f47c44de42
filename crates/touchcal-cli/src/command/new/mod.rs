//! `touchcal new`: a problem to fill in, and what to record for it.

use super::{Failure, Outcome};
use crate::args::{NewArgs, Start};
use crate::output;
use touchcal::io::atomic;

/// The files of a new problem, by name.
fn files(start: Start) -> [(&'static str, &'static str); 2] {
    let (problem, readme) = match start {
        Start::PegInHole => (include_str!("peg_in_hole.toml"), include_str!("peg_in_hole.md")),
        Start::Sockets => (include_str!("sockets.toml"), include_str!("sockets.md")),
        Start::Planes => (include_str!("planes.toml"), include_str!("planes.md")),
    };
    [("README.md", readme), ("problem.toml", problem)]
}

/// Writes the files, unless one of them is there.
pub fn run(args: &NewArgs) -> Result<Outcome, Failure> {
    let folder = args.out.clone().unwrap_or_else(|| args.kind.name().into());
    let files = files(args.kind).map(|(name, text)| (folder.join(name), text));
    // The problem first: it is what was filled in.
    if let Some((there, _)) = files.iter().rfind(|(path, _)| path.exists()) {
        return Err(Failure::Setup(format!("{} is there already; choose another --out", there.display())));
    }
    for (path, text) in &files {
        atomic::write(path, text.as_bytes())?;
    }
    let folder = folder.display();
    output::print(&format!(
        "Written   {folder}/problem.toml: what touches what, with places to fill in\n          \
         {folder}/README.md: what to record, and how to move\n\n\
         Try next, when the URDF and the logs are there\n  touchcal inspect {folder}/problem.toml\n"
    ))?;
    Ok(Outcome::Done)
}

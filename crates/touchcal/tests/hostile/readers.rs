//! Every reader of files, by the name of its corpus in `fuzz/corpus`. A new one is one line here,
//! and a folder with a file or two there.

use std::path::{Path, PathBuf};

use touchcal::contact::ContactLog;
use touchcal::contact::{AngleUnit, Detection};
use touchcal::geometry::MeshPair;
use touchcal::io::contact_log::{self, LogTable, Options};
use touchcal::io::outline::{self, Choice};
use touchcal::io::urdf::{self, Ends};
use touchcal::io::{
    IoError, checkpoint_file, estimate_file, manifold_file, mesh, problem_file, scenario_file, weights_file,
};
use touchcal::manifold;
use touchcal::robot::Robot;

/// Reads a file, whatever is in it.
pub type Reader = fn(&Path) -> Result<(), IoError>;

pub const READERS: &[(&str, Reader)] = &[
    ("urdf", |path| urdf::read_file(path, Ends::default()).map(drop)),
    ("problem", |path| problem_file::read_file(with(path, "hole.csv", LOG)).map(drop)),
    ("scenario", |path| scenario_file::read_file(path).map(drop)),
    ("contact_csv", read_log),
    ("contact_kuka", read_log),
    ("contact_parquet", read_log),
    ("contact_mcap", read_log),
    ("poses", |path| manifold_file::read_samples(path).map(drop)),
    ("outline", |path| {
        renamed(with(path, "hole.csv", LOG), "outline.csv");
        problem_file::read(OUTLINE, "problem.toml", folder(path)).map(drop)
    }),
    ("outline_svg", |path| outline::read_file(&renamed(path, "part.svg"), MILLIMETRES).map(drop)),
    ("outline_dxf", |path| outline::read_file(&renamed(path, "part.dxf"), MILLIMETRES).map(drop)),
    ("mesh_stl", |path| read_mesh(&renamed(path, "part.stl"))),
    ("mesh_obj", |path| read_mesh(&renamed(path, "part.obj"))),
    ("estimate", |path| estimate_file::EstimateFile::read_file(path).map(drop)),
    ("manifold", |path| manifold_file::ManifoldFile::read_file(path).map(drop)),
    ("weights", |path| weights_file::WeightsFile::read_file(path).map(drop)),
    ("checkpoint", |path| checkpoint_file::read_file(path).map(drop)),
];

/// A log, of whatever format: its contacts by force, in radians, and all its rows, in degrees, with
/// everything else that may be declared.
fn read_log(path: &Path) -> Result<(), IoError> {
    let detection = Some(Detection { threshold: 3.0, release: 2.0, debounce: 2 });
    let by_force = Options { detection, ..Options::default() };
    let contacts = contact_log::read_file(path, &arm(), &by_force, &mut ContactLog::new(2));
    let columns = [("q1", "first"), ("fx", "force")].map(|(usual, name)| (usual.to_owned(), name.to_owned()));
    let wrench_topic = Some("/wrench".to_owned());
    let declared = Options { unit: AngleUnit::Degree, columns: columns.into(), wrench_topic, ..Options::default() };
    let renamed = LogTable::read_file(path, &arm(), &declared);
    let plain = LogTable::read_file(path, &arm(), &Options::default());
    contacts?;
    renamed?;
    plain.map(drop)
}

/// A mesh, as a peg and as the body around a hole.
fn read_mesh(path: &Path) -> Result<(), IoError> {
    let (solid, _) = mesh::read_file(path, 1e-3)?;
    let peg = mesh::read(PEG, "peg.obj", 1e-3)?;
    drop(manifold::peg_in_hole(MeshPair::new(peg, solid.clone()), 0.03));
    drop(manifold::peg_in_hole(MeshPair::new(solid.clone(), solid), 0.03));
    Ok(())
}

fn arm() -> Robot {
    const ARM: &str = "<robot><link name='b'/><link name='l'/><link name='t'/>\
      <joint name='q1' type='revolute'><parent link='b'/><child link='l'/><limit lower='-2' upper='2'/></joint>\
      <joint name='q2' type='revolute'><parent link='l'/><child link='t'/><limit lower='-2' upper='2'/></joint></robot>";
    urdf::read(ARM, "arm.urdf", Ends::default()).expect("a URDF")
}

/// Any part of a drawing, in millimetres if it does not say.
const MILLIMETRES: Choice<'static> = Choice { name: None, unit: Some(1e-3) };

/// A problem whose peg's outline is beside it.
const OUTLINE: &str = "robot.builtin = 'iiwa14'\ntool = { kind = 'peg', outline = 'outline.csv', length_mm = 40 }\n\
  contacts = [{ file = 'hole.csv', fixture = 'hole' }]\nestimate.parameters = ['strain']\n\
  fixture = [{ name = 'hole', kind = 'hole', outline_offset_mm = 0.5, depth_mm = 30, base_from_fixture = { xyz_mm = [600, 0, 0] } }]\n";

/// A straight peg.
const PEG: &[u8] =
    b"v -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\nv -10 -10 40\nv 10 -10 40\nv 10 10 40\nv -10 10 40\n\
  f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The log that a problem names.
const LOG: &[u8] = b"q1,q2,q3,q4,q5,q6,q7,fx,fy,fz\n0,0.8,0.3,-1.4,-0.2,1,0,0,1,-4\n0,0.8,0.2,-1.4,-0.2,1,0,0,1,-5\n";

/// `path`, beside which there is another file now.
fn with<'p>(path: &'p Path, name: &str, content: &[u8]) -> &'p Path {
    std::fs::write(path.with_file_name(name), content).expect("a file");
    path
}

/// A copy of `path` beside it, under another name.
fn renamed(path: &Path, name: &str) -> PathBuf {
    let copy = folder(path).join(name);
    // Not `fs::copy`, which a fuzzer's alarm may interrupt.
    std::fs::write(&copy, std::fs::read(path).expect("a file")).expect("a copy");
    copy
}

fn folder(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("."))
}

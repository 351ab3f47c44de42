//! Folders of ball-in-socket logs in the layout of the MUKCa project: `DIR/PLACEMENT/hole_N.csv`.
//!
//! Each file holds joint positions (rad, a row per contact, no header) of an arm whose ball sits in
//! socket N of a tool at an unknown place; neighbouring sockets (N and N + 1) of one placement are
//! a known distance apart.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::{Translation3, Vector3};

use crate::contact::ContactLog;
use crate::estimate::{Distance, Fixture, Loss, Noise, PlacePrior, Problem, ShapeTolerance, Tool};
use crate::io::base::bytes::Input;
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::paths::relative;
use crate::io::base::suggest::{did_you_mean, list};
use crate::io::base::toml_text::{number, quoted as toml_quoted};
use crate::io::log::contact_log;
use crate::io::problem::loaded::Loaded;
use crate::io::problem::problem_file::Assumptions;
use crate::io::problem::socket_logs::{SocketLog, entries, hole_number};
use crate::io::robot::urdf::{self, UrdfFile};
use crate::manifold::BallInSocket;
use crate::parameter::{joint_compliance, joint_origin};
use crate::robot::Robot;

/// Scale of the loss in standard deviations: misfits of real arms are no outliers, a ball out of
/// its socket is.
const LOSS_SCALE: f64 = 8.0;
/// How far the ball may sit from where the URDF draws it (m).
const BALL_SIGMA: f64 = 2e-3;
/// The table of what holds for all logs, up to its first value.
const LOG_HEAD: &str = "\n# [log]                           # what holds for all logs\n# unit";

/// Which placements are read, and what is known of sockets, noise and joints.
#[derive(Clone, Debug, PartialEq)]
pub struct MukcaOptions {
    /// Names of the placements to read; empty: all. A name that the folder lacks is an error.
    pub only: Vec<String>,
    /// Names of placements to leave out, also of those in `only`. A name that the folder lacks is
    /// an error.
    pub except: Vec<String>,
    /// Distance between the centres of neighbouring sockets (m, > 0).
    pub spacing: f64,
    /// Standard deviation of that distance (m, > 0).
    pub spacing_sigma: f64,
    /// Noise of encoders (rad) and contacts (m), declared or initial; not both 0.
    pub noise: Noise,
    /// Whether the compliance of the joints under gravity is estimated too.
    pub joint_compliance: bool,
    /// The ball's centre (m) in the frame of the tip link.
    pub ball_in_tip: Vector3<f64>,
}

impl Default for MukcaOptions {
    /// All placements, 50 ± 0.05 mm as the tool is printed, no encoder noise, an initial 0.2 mm of
    /// contact noise, about what a fitted arm leaves, an arm that does not bend, and a tip link
    /// that is the ball.
    fn default() -> Self {
        MukcaOptions {
            only: Vec::new(),
            except: Vec::new(),
            spacing: 50e-3,
            spacing_sigma: 0.05e-3,
            noise: Noise { encoder: 0.0, contact: 0.2e-3, is_estimated: true },
            joint_compliance: false,
            ball_in_tip: Vector3::zeros(),
        }
    }
}

/// Reads a folder of logs as a calibration problem for the arm of `urdf`, whose tip link carries
/// the ball. Estimated are the place of the ball in the tip link (standard deviation 2 mm), the
/// place of every socket, the parameters of the full geometric model ([`joint_origin`]) with joint
/// drift between placements, and compliances ([`joint_compliance`]) if asked for; the loss is
/// Geman–McClure at 8 standard deviations. Fixtures are named `PLACEMENT/N` and sorted by placement
/// and N; N is written without leading zeros. Sockets N and N + 1 of one placement get a known
/// distance.
///
/// # Errors
/// [`IoError`] if the folder cannot be read or has no such files, a folder has more than 10 000
/// entries, a placement of `options` is missing or none is left, the spacing or its standard
/// deviation is not positive and finite, or a file is no log of this arm.
pub fn read(folder: &Path, urdf: UrdfFile, options: &MukcaOptions) -> Result<Loaded, IoError> {
    let UrdfFile { robot, text, input } = urdf;
    check(options, folder)?;
    let placements = chosen(placements(folder)?, options, folder)?;
    let mut inputs = vec![input];
    let mut fixtures: Vec<Fixture> = Vec::new();
    let mut distances = Vec::new();
    let mut contacts = ContactLog::new(robot.dof());
    for placement in &placements {
        let mut before: Option<u32> = None;
        for (number, path) in &placement.holes {
            let index = fixtures.len();
            fixtures.push(socket(&placement.name, *number));
            inputs.push(read_hole(path, index, &robot, &mut contacts)?);
            if before.is_some_and(|before| before.checked_add(1) == Some(*number)) {
                let (distance, sigma) = (options.spacing, options.spacing_sigma);
                distances.push(Distance { between: (index - 1, index), distance, sigma });
            }
            before = Some(*number);
        }
    }
    let tool = Tool {
        tip_from_tool: Translation3::from(options.ball_in_tip).into(),
        prior: PlacePrior::Gaussian { sigma: BALL_SIGMA, sigma_angle: 0.0 },
    };
    let mut parameters = joint_origin(&robot);
    if options.joint_compliance {
        parameters.extend(joint_compliance(&robot));
    }
    let problem = Problem {
        distances,
        noise: options.noise,
        parameters,
        joint_drift: true,
        loss: Loss::GemanMcClure(LOSS_SCALE),
        other_arms: urdf::builtin_arms(),
        ..Problem::new(robot, tool, fixtures, contacts)
    };
    let settings = settings_text(options);
    Ok(Loaded { problem, urdf: text, inputs, settings, assumptions: Assumptions::default() })
}

/// The text of a `problem.toml` in `folder`, which need not exist, that poses the same problem as
/// [`read`] with these logs: the arm of the URDF file `urdf`, whose link `tip` (`None`: the only
/// leaf) carries the ball. Sockets N and N + 1 of one placement get a known distance. Paths in the
/// text are relative to `folder`. Nothing is written, and neither the URDF nor the logs are read;
/// placements are not chosen by `options`.
///
/// # Errors
/// [`IoError`] if the spacing or its standard deviation is not positive and finite, or a path does
/// not exist.
pub fn problem_text(
    folder: &Path,
    logs: &[SocketLog],
    (urdf, tip): (&Path, Option<&str>),
    options: &MukcaOptions,
) -> Result<String, IoError> {
    check(options, folder)?;
    let path = |file: &Path| Ok::<_, IoError>(toml_quoted(&relative(folder, file)?));
    let mut text = String::from(
        "# A ball is held in sockets while the arm moves around it; from the joint positions the arm's errors are\n\
         # estimated. Nothing is known but how far apart neighbouring sockets are, and where the ball is on the arm.\n\
         # Paths are relative to this file. Lengths are in mm, angles in degrees, as the keys say.\n\n[robot]\n",
    );
    let mut line = |key: &str, value: &str| text.push_str(&format!("{key} = {value}\n"));
    line("urdf", &path(urdf)?);
    if let Some(tip) = tip {
        line("tip", &toml_quoted(tip));
    }
    line("\n[tool]\nkind", "\"ball\"");
    let ball = options.ball_in_tip.map(|metres| number(1e3 * metres));
    line(
        "tip_from_tool",
        &format!("{{ xyz_mm = [{}, {}, {}] }}   # centre of the ball in the tip link", ball.x, ball.y, ball.z),
    );
    line("sigma_mm", &number(1e3 * BALL_SIGMA));
    for log in logs {
        line("\n[[fixture]]\nname", &toml_quoted(&log.socket));
        line("kind", "\"socket\"");
        line("free", "true");
    }
    for pair in neighbours(logs) {
        let names = pair.map(|log| toml_quoted(&log.socket));
        line("\n[[distance]]\nbetween", &format!("[{}]", names.join(", ")));
        line("mm", &number(1e3 * options.spacing));
        line("sigma_mm", &number(1e3 * options.spacing_sigma));
    }
    line(LOG_HEAD, "\"deg\"                    # if joint angles are not in radians");
    line("# apart_deg", "1                   # rows count once some joint has moved so far, if the arm rests");
    line("# force_threshold_n", "3.0         # if the logs have forces, and rows where nothing touches");
    line("# columns", "{ joint_a1 = \"axis_1\" }   # if the logs call a joint otherwise than the URDF");
    for log in logs {
        line("\n[[contacts]]\nfile", &path(&log.path)?);
        line("fixture", &toml_quoted(&log.socket));
    }
    Ok(text + "\n" + &settings_text(options))
}

/// The tables `[noise]` and `[estimate]` of a problem file.
fn settings_text(options: &MukcaOptions) -> String {
    let mut text = String::new();
    let mut line = |key: &str, value: &str| text.push_str(&format!("{key} = {value}\n"));
    line("[noise]\nencoder_deg", &number(options.noise.encoder.to_degrees()));
    line("contact_mm", &number(1e3 * options.noise.contact));
    line("estimated", &options.noise.is_estimated.to_string());
    let compliance = if options.joint_compliance { ", \"joint_compliance\"" } else { "" };
    line("\n[estimate]\nparameters", &format!("[\"joint_origin\"{compliance}, \"joint_drift\"]"));
    line("loss", "\"geman_mcclure\"");
    line("loss_scale", &number(LOSS_SCALE));
    text
}

/// Logs of sockets N and N + 1 of one placement, of logs that are sorted.
pub fn neighbours(logs: &[SocketLog]) -> impl Iterator<Item = [&SocketLog; 2]> {
    let successor = |log: &SocketLog| log.number().and_then(|number| number.checked_add(1));
    let pairs = logs.windows(2).map(|pair| [&pair[0], &pair[1]]);
    pairs.filter(move |[a, b]| a.placement() == b.placement() && successor(a).is_some() && successor(a) == b.number())
}

/// Names of the placements that a folder holds, sorted: its subfolders with files `hole_N.csv`.
///
/// # Errors
/// [`IoError`] if the folder cannot be read, holds no placement, or a folder has more than 10 000
/// entries.
pub fn placement_names(folder: &Path) -> Result<Vec<String>, IoError> {
    Ok(placements(folder)?.into_iter().map(|placement| placement.name).collect())
}

struct Placement {
    name: String,
    /// Number and path of each file, sorted.
    holes: Vec<(u32, PathBuf)>,
}

fn check(options: &MukcaOptions, folder: &Path) -> Result<(), IoError> {
    let positive = |value: f64| value > 0.0 && value.is_finite();
    for (value, name) in [(options.spacing, "spacing"), (options.spacing_sigma, "sigma of the spacing")] {
        if !positive(value) {
            let place = Place::file(folder.display().to_string()).field(name);
            return Err(IoError::unexpected(place, "a positive length", format!("{value} m")));
        }
    }
    Ok(())
}

fn socket(placement: &str, number: u32) -> Fixture {
    Fixture {
        name: format!("{placement}/{number}"),
        manifold: Arc::new(BallInSocket),
        base_from_fixture: None,
        prior: PlacePrior::Flat,
        tolerance: ShapeTolerance::EXACT,
        placement: placement.to_owned(),
    }
}

fn read_hole(path: &Path, fixture: usize, robot: &Robot, log: &mut ContactLog) -> Result<Input, IoError> {
    let options = contact_log::Options { fixture, ..contact_log::Options::default() };
    contact_log::read_file(path, robot, &options, log)
}

/// All subfolders that hold files `hole_N.csv`, sorted by name.
fn placements(folder: &Path) -> Result<Vec<Placement>, IoError> {
    let mut placements = Vec::new();
    for path in entries(folder)? {
        let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|_| path.is_dir()) else { continue };
        let mut holes: Vec<(u32, PathBuf)> =
            entries(&path)?.into_iter().filter_map(|file| Some((hole_number(&file)?, file))).collect();
        holes.sort();
        if !holes.is_empty() {
            placements.push(Placement { name: name.to_owned(), holes });
        }
    }
    if placements.is_empty() {
        let place = Place::file(folder.display().to_string());
        return Err(IoError::unexpected(place, "subfolders with files hole_0.csv, hole_1.csv, …", "none"));
    }
    Ok(placements)
}

fn chosen(all: Vec<Placement>, options: &MukcaOptions, folder: &Path) -> Result<Vec<Placement>, IoError> {
    let known: Vec<&str> = all.iter().map(|placement| placement.name.as_str()).collect();
    let place = || Place::file(folder.display().to_string());
    if let Some(name) = options.only.iter().chain(&options.except).find(|name| !known.contains(&name.as_str())) {
        let found = format!("{}{}", quoted(name), did_you_mean(name, known.iter().copied()));
        return Err(IoError::unexpected(place(), format!("a placement ({})", list(known)), found));
    }
    let wanted =
        |name: &String| (options.only.is_empty() || options.only.contains(name)) && !options.except.contains(name);
    let chosen: Vec<Placement> = all.into_iter().filter(|placement| wanted(&placement.name)).collect();
    if chosen.is_empty() {
        return Err(IoError::unexpected(place(), "at least one placement to be left", "none"));
    }
    Ok(chosen)
}

//! `problem.toml`: a calibration problem — robot, tool, fixtures, contact logs and what to
//! estimate.
//!
//! Lengths in the file are millimetres and angles degrees, as its keys say; paths are relative to
//! its folder. Every unknown key, every name that does not resolve and every number out of range is
//! an error with line and column.

mod accept;
mod assumptions;
pub(crate) mod context;
mod declared;
mod log;
mod parameters;
mod projected;
pub(crate) mod schema;
pub(crate) mod selection;
mod settings;
mod source;
pub(crate) mod tolerance;
pub(crate) mod touch;

use std::collections::HashMap;
use std::path::Path;

use toml::Spanned;

use crate::contact::{ContactLog, KnownRows, note_repetition};
use crate::estimate::{DEFAULT_DISTANCE_SIGMA, Distance, Problem, parameter_count};
use crate::io::base::bytes::{self, Input};
use crate::io::base::error::{IoError, Place, quoted};
use crate::io::base::suggest::{did_you_mean, list};
use crate::io::log::contact_log::{self, Options, TargetColumns};
use crate::io::problem::loaded::Loaded;
use crate::io::robot::urdf::{self, Ends, UrdfFile};
use crate::robot::Robot;
use accept::acceptance;
use context::Context;
use declared::{distance, fixture, tool};
use schema::{ContactsToml, FixtureKind, FixtureToml, ProblemToml, RobotToml};
use selection::{fixture_index, selected};
use touch::{Shape, target_columns};

pub use accept::read_acceptance;
pub use assumptions::Assumptions;
pub use context::MAX_BYTES;
pub use declared::missing_place;
pub use selection::{Selection, placement};
pub use settings::{DEFAULT_CONTACT, DEFAULT_ENCODER, Settings, check_joint_torques};
pub use tolerance::DeclaredPrior;

/// JSON Schema (draft 2020-12) of a problem file, for editors.
pub const JSON_SCHEMA: &str = include_str!("../problem.schema.json");

/// Keys that declare what is assumed without them.
pub const KEYS: &str = "sigma_mm, sigma_deg, clearance_sigma_mm, depth_sigma_mm, edge_radius_sigma_mm, or exact = true";
/// Most fixtures of a problem, and most parameters: memory grows with their square, time with their
/// cube, to seconds for each step of the search.
const MAX_FIXTURES: usize = 1000;
const MAX_PARAMETERS: usize = 1000;

/// Reads a problem from its text, and all files it refers to. `file` is its name for messages;
/// relative paths begin at `folder`. Lengths and angles are converted to m and rad.
///
/// # Errors
/// [`IoError`] if the text is longer than [`MAX_BYTES`], no TOML, of another schema than 1, has an
/// unknown key, a name that does not resolve or has control characters, a number out of range, no
/// fixture or log, or more than 1000 fixtures or parameters; a file it refers to cannot be read;
/// parts do not fit; or compliances are to be estimated that nothing determines, see
/// [`Settings::problem`].
pub fn read(text: &str, file: &str, folder: &Path) -> Result<Loaded, IoError> {
    let context = Context { text, file, folder };
    bytes::check_size(text.len() as u64, MAX_BYTES, file)?;
    let toml: ProblemToml = toml::from_str(text).map_err(|error| context.syntax(&error))?;
    build(&toml, &Selection::default(), &context)
}

/// Reads a problem file and all that it refers to, with paths relative to the file's folder.
///
/// # Errors
/// As [`read`], and if the file itself cannot be read.
pub fn read_file(path: &Path) -> Result<Loaded, IoError> {
    read_selected(path, &Selection::default())
}

/// Reads the selected placements of a problem file: their fixtures, the logs of these, and the
/// known distances between these, each in the order of the file. The files of what is left out are
/// not read, nor are the shapes and poses of its fixtures checked.
///
/// # Errors
/// As [`read_file`], and if a placement of `selection` is missing, or none is left.
pub fn read_selected(path: &Path, selection: &Selection) -> Result<Loaded, IoError> {
    let inside = path.join("problem.toml");
    if inside.is_file() {
        let found = format!("a folder; did you mean `{}`?", inside.display());
        return Err(IoError::unexpected(Place::file(path.display().to_string()), "a problem file", found));
    }
    let (text, input) = bytes::read_text(path, MAX_BYTES)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let context = Context { text: &text, file: &input.path, folder };
    let toml: ProblemToml = toml::from_str(&text).map_err(|error| context.syntax(&error))?;
    let mut loaded = build(&toml, selection, &context)?;
    loaded.inputs.insert(0, input);
    Ok(loaded)
}

fn build(toml: &ProblemToml, selection: &Selection, context: &Context<'_>) -> Result<Loaded, IoError> {
    if let Some(schema) = toml.schema.as_ref().filter(|schema| *schema.get_ref() != 1) {
        let place = context.place(schema.span(), "schema");
        return Err(IoError::unexpected(place, "schema 1", format!("{}", schema.get_ref())));
    }
    let UrdfFile { robot, text: urdf, input } = robot(&toml.robot, context)?;
    let mut inputs = vec![input];
    let settings = Settings::of(&toml.noise, &toml.estimate, &robot, context)?;
    let mut assumptions = Assumptions::default();
    let shape = Shape::of(&toml.tool, context, (&mut inputs, &mut assumptions))?;
    let tool = tool(&toml.tool, &settings, context, &mut assumptions)?;
    let names = fixture_names(&toml.fixture, context)?;
    let selected = selected(&toml.fixture, selection, context)?;
    let mut fixtures = Vec::with_capacity(toml.fixture.len());
    for (table, _) in toml.fixture.iter().zip(&selected).filter(|(_, selected)| selected.is_some()) {
        fixtures.push(fixture(table, (&settings, &shape), context, (&mut inputs, &mut assumptions))?);
    }
    let mut distances = Vec::new();
    for table in &toml.distance {
        let distance = distance(table, &names, context)?;
        if let (Some(first), Some(second)) = (selected[distance.between.0], selected[distance.between.1]) {
            let between = table.get_ref().between.each_ref().map(|name| name.get_ref().as_str());
            let declared = table.get_ref().sigma_mm.as_ref().map(|sigma| *sigma.get_ref());
            let declared = declared.filter(|sigma| *sigma > 0.0 || table.get_ref().exact.is_none());
            if declared.is_some() || distance.sigma == DEFAULT_DISTANCE_SIGMA {
                assumptions.distance(between, declared, distance.sigma);
            }
            distances.push(Distance { between: (first, second), ..distance });
        }
    }
    let (mut contacts, mut held_out) = (ContactLog::new(robot.dof()), ContactLog::new(robot.dof()));
    let mut known = KnownRows::default();
    check_fitted(&toml.contacts, context)?;
    let joints = toml.robot.get_ref().joints.as_ref();
    check_joints(joints, &robot, context)?;
    for table in &toml.contacts {
        let joints = joints.map(|joints| joints.get_ref().clone());
        let fixture = fixture_index(&table.get_ref().fixture, &names, context, "contacts, fixture")?;
        let options = log::options(table.get_ref(), &toml.log, context)?;
        let targets = targets(table, toml.fixture[fixture].get_ref(), context)?;
        let Some(fixture) = selected[fixture] else { continue };
        let options = Options { joints, fixture, targets, ..options };
        let log = if table.get_ref().held_out { &mut held_out } else { &mut contacts };
        inputs.push(read_contacts(table, &robot, &options, context, (log, &mut known))?);
    }
    held_out.notes().iter().for_each(|note| contacts.note(note));
    contacts.merge_notes(inputs.iter().map(|input| input.path.as_str()));
    note_repetition(&mut contacts, &held_out);
    assumptions.notes(KEYS).iter().for_each(|note| contacts.note(note));
    let acceptance = toml.accept.as_ref().map(|table| acceptance(table, (&robot, &tool), context)).transpose()?;
    let mut problem = settings.problem(robot, (tool, fixtures, distances), contacts)?;
    problem.acceptance = acceptance;
    check_joint_torques(&problem.robot, &held_out, problem.contacts.has_joint_torques())?;
    problem.held_out = held_out;
    check_size(&problem, context)?;
    Ok(Loaded { problem, urdf, inputs, settings: settings_text(context)?, assumptions })
}

/// The tables of the file that [`Settings::read`] takes.
fn settings_text(context: &Context<'_>) -> Result<String, IoError> {
    let mut tables: toml::Table = toml::from_str(context.text).map_err(|error| context.syntax(&error))?;
    tables.retain(|name, _| ["noise", "estimate"].contains(&name));
    Ok(tables.to_string())
}

/// Which columns of targets a log has that `touched` the fixture; `None` if it has none.
fn targets(
    table: &Spanned<ContactsToml>,
    touched: &FixtureToml,
    context: &Context<'_>,
) -> Result<Option<TargetColumns>, IoError> {
    if touched.kind != FixtureKind::Target {
        return Ok(None);
    }
    if table.get_ref().held_out && touched.base_from_fixture.is_none() {
        let expected = "`base_from_fixture` of their frame, by which contacts with targets can be predicted, \
                        or another [[fixture]] with logs of its own and `--except`";
        return Err(IoError::unexpected(context.place(table.span(), "contacts, held_out"), expected, "none"));
    }
    Ok(Some(target_columns(touched)))
}

/// Refuses more parameters than can be estimated.
fn check_size(problem: &Problem, context: &Context<'_>) -> Result<(), IoError> {
    let parameters = parameter_count(problem);
    if parameters > MAX_PARAMETERS {
        let found = format!("{parameters}: declare fewer joints, fixtures or blocks of parameters");
        return Err(IoError::unexpected(
            Place::file(context.file),
            format!("at most {MAX_PARAMETERS} parameters to estimate"),
            found,
        ));
    }
    Ok(())
}

/// The robot that a table names, under the gravity it states.
pub(crate) fn robot(table: &Spanned<RobotToml>, context: &Context<'_>) -> Result<UrdfFile, IoError> {
    let RobotToml { urdf, builtin, base, tip, gravity, .. } = table.get_ref();
    let ends = Ends { base: base.as_deref(), tip: tip.as_deref() };
    let mut file = match (urdf, builtin) {
        (Some(file), None) => urdf::read_file(&context.path(file, "robot, urdf")?, ends),
        (None, Some(name)) => urdf::read_builtin(name.get_ref(), ends).map_err(|error| match error {
            IoError::Unexpected { place, expected, found } if place.file == "builtin" => {
                IoError::unexpected(context.place(name.span(), "robot, builtin"), expected, found)
            }
            error => error,
        }),
        (urdf, _) => {
            let found = if urdf.is_some() { "both" } else { "neither" };
            Err(IoError::unexpected(context.place(table.span(), "robot"), "`urdf` or `builtin`", found))
        }
    }?;
    if let Some(gravity) = gravity {
        file.robot = file.robot.with_gravity(context.vector(gravity, "robot, gravity")?.into());
    }
    Ok(file)
}

/// Here, where the line is known; reading a log checks again.
fn check_joints(joints: Option<&Spanned<Vec<String>>>, robot: &Robot, context: &Context<'_>) -> Result<(), IoError> {
    let Some(joints) = joints else { return Ok(()) };
    let mut given: Vec<&str> = joints.get_ref().iter().map(String::as_str).collect();
    let mut known: Vec<&str> = robot.moving().map(|joint| joint.name.as_str()).collect();
    let expected = format!("the moving joints in the order of the columns ({})", list(known.iter().copied()));
    given.sort_unstable();
    known.sort_unstable();
    if given == known {
        return Ok(());
    }
    let unknown = given.iter().find(|name| !known.contains(name));
    let found = match unknown {
        Some(name) => format!("{}{}", quoted(name), did_you_mean(name, known.iter().copied())),
        None => list(joints.get_ref().iter().map(String::as_str)),
    };
    Err(IoError::unexpected(context.place(joints.span(), "robot, joints"), expected, found))
}

fn fixture_names<'t>(
    tables: &'t [Spanned<FixtureToml>],
    context: &Context<'_>,
) -> Result<HashMap<&'t str, usize>, IoError> {
    if tables.is_empty() {
        return Err(IoError::unexpected(Place::file(context.file), "at least one [[fixture]] table", "none"));
    }
    if let Some(table) = tables.get(MAX_FIXTURES) {
        let found = format!("{}", tables.len());
        let place = context.place(table.span(), "fixture");
        return Err(IoError::unexpected(place, format!("at most {MAX_FIXTURES} [[fixture]] tables"), found));
    }
    let mut names = HashMap::new();
    for (index, table) in tables.iter().enumerate() {
        let name = &table.get_ref().name;
        if let Some(control) = name.get_ref().chars().find(|c| c.is_control()) {
            let place = context.place(name.span(), "fixture, name");
            return Err(IoError::unexpected(place, "a name without control characters", format!("{control:?}")));
        }
        if names.insert(name.get_ref().as_str(), index).is_some() {
            let found = format!("{} twice", quoted(name.get_ref()));
            return Err(IoError::unexpected(context.place(name.span(), "fixture, name"), "distinct names", found));
        }
    }
    Ok(names)
}

/// Checks that there are logs to fit.
fn check_fitted(contacts: &[Spanned<ContactsToml>], context: &Context<'_>) -> Result<(), IoError> {
    if !contacts.iter().all(|table| table.get_ref().held_out) {
        return Ok(());
    }
    let [with, found] = match contacts.is_empty() {
        true => [", with the `file` of a log and its `fixture` ([log] says only how logs are read)", "none"],
        false => ["", "`held_out` in all of them"],
    };
    let expected = format!("at least one [[contacts]] table{with}");
    Err(IoError::unexpected(Place::file(context.file), expected, found))
}

fn read_contacts(
    table: &Spanned<ContactsToml>,
    robot: &Robot,
    options: &Options,
    context: &Context<'_>,
    into: (&mut ContactLog, &mut KnownRows),
) -> Result<Input, IoError> {
    let path = context.path(&table.get_ref().file, "contacts, file")?;
    contact_log::read_new(&path, robot, options, into)
}

//! A problem that was read or simulated, with other arguments.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use touchcal::contact::{ContactLog, note_repetition};
use touchcal::estimate::{self, Fixture, Problem};
use touchcal::io::problem_file::{self, Assumptions};
use touchcal::io::{Input, Loaded};

use crate::error::{argument, io, mapping_argument, refused, unexpected, wrong_argument};
use crate::list_of::ListOf;
use crate::parts::Tool;
use crate::problem_arguments::{FixtureNames, JoinedLogs, KEYS, acceptance, settings, without_lines};
use crate::toml_value::as_table;

/// Arguments that can be changed.
const CHANGEABLE: [&str; 7] = ["tool", "contacts", "held_out", "parameters", "noise", "estimate", "accept"];
/// Arguments that cannot.
const FIXED: [&str; 3] = ["robot", "fixtures", "distances"];

/// The problem with these changes, which are arguments of `Problem` by name, and which of its notes
/// it did not have before.
pub fn changed(loaded: &Loaded, changes: &Bound<'_, PyDict>) -> PyResult<(Loaded, Vec<String>)> {
    check_names(changes)?;
    let old = &loaded.problem;
    let a_tool =
        |tool: Bound<'_, PyAny>| tool.extract::<Py<Tool>>().map_err(|_| wrong_argument("tool", "a Tool", &tool));
    let tool = changes.get_item("tool")?.map(a_tool).transpose()?;
    let text = settings_text(loaded, changes, tool.is_some())?;
    let mut assumptions = loaded.assumptions.clone();
    let tool_is_new = tool.is_some();
    let tool = match &tool {
        None => old.tool.clone(),
        Some(tool) => new_tool(tool.get(), old, &text, &mut assumptions)?,
    };
    let Logs { mut contacts, held_out, inputs } = logs(loaded, changes)?;
    check_targets(&old.fixtures, [&contacts, &held_out])?;
    for log in [&contacts, &held_out] {
        problem_file::check_joint_torques(&old.robot, log, old.contacts.has_joint_torques()).map_err(io)?;
    }
    if tool_is_new && old.acceptance.is_some() && !changes.contains("accept")? {
        let expected = "accept too, or None: its task may be a region, which another tool reaches otherwise";
        return Err(unexpected("with_", expected, "tool alone"));
    }
    if changes.contains("tool")? || changes.contains("contacts")? {
        assumptions.notes(KEYS).iter().for_each(|note| contacts.note(note));
    }
    let problem = if text.is_empty() {
        Problem { tool, contacts, held_out, ..old.clone() }
    } else {
        let parts = (tool, old.fixtures.clone(), old.distances.clone());
        let problem = settings(&text, &old.robot)?.problem(old.robot.clone(), parts, contacts);
        let problem = problem.map_err(|error| io(without_lines(error)))?;
        let (acceptance, other_arms) = (old.acceptance.clone(), old.other_arms.clone());
        Problem { held_out, acceptance, other_arms, ..problem }
    };
    let problem = match changes.get_item("accept")? {
        None => problem,
        Some(accept) if accept.is_none() => Problem { acceptance: None, ..problem },
        Some(accept) => {
            let accept = acceptance(mapping_argument(&accept, "accept")?, (&problem.robot, &problem.tool))?;
            Problem { acceptance: Some(accept), ..problem }
        }
    };
    let is_new = |note: &&String| !old.contacts.notes().contains(note);
    let notes = problem.contacts.notes().iter().filter(is_new).cloned().collect();
    Ok((Loaded { problem, urdf: loaded.urdf.clone(), inputs, settings: text, assumptions }, notes))
}

fn check_names(changes: &Bound<'_, PyDict>) -> PyResult<()> {
    for name in changes.keys() {
        let name: String = name.extract()?;
        if FIXED.contains(&name.as_str()) {
            let expected = format!("{} of a problem that was read or simulated", CHANGEABLE.join(", "));
            let found = format!("{name}; change the file and read it again, or make the problem by Problem(…)");
            return Err(unexpected("with_", expected, found));
        }
        if !CHANGEABLE.contains(&name.as_str()) {
            let message = format!("Problem.with_() got an unexpected keyword argument '{name}'");
            return Err(PyTypeError::new_err(message));
        }
    }
    Ok(())
}

/// The tables `[noise]` and `[estimate]` with the changes; empty where they are not known.
fn settings_text(loaded: &Loaded, changes: &Bound<'_, PyDict>, has_new_tool: bool) -> PyResult<String> {
    let given = |name: &str| changes.get_item(name);
    let (noise, estimate, parameters) = (given("noise")?, given("estimate")?, given("parameters")?);
    if loaded.settings.is_empty() {
        let has_changes = noise.is_some() || estimate.is_some() || parameters.is_some();
        let expected = "no other parameters, noise and estimate of a problem that free_suspects or select extended";
        let found = "some; change the problem before that";
        return if has_changes { Err(unexpected("with_", expected, found)) } else { Ok(String::new()) };
    }
    let mut tables: toml::Table = loaded.settings.parse().map_err(|error| refused("with_", error))?;
    let table = |value: &Bound<'_, PyAny>, name: &str| match value.is_none() {
        true => Ok(toml::Table::new()),
        false => as_table(mapping_argument(value, name)?),
    };
    if let Some(noise) = noise {
        tables.insert("noise".to_owned(), table(&noise, "noise")?.into());
    }
    let Some(toml::Value::Table(before)) = tables.remove("estimate") else { return Ok(tables.to_string()) };
    let mut after = estimate.map_or_else(|| Ok(before.clone()), |estimate| table(&estimate, "estimate"))?;
    let parameters = match parameters {
        None if after.contains_key("parameters") => after.get("parameters").cloned(),
        Some(parameters) => Some(toml::Value::from(argument::<ListOf<String>>(&parameters, "parameters")?.0)),
        None => before.get("parameters").cloned(),
    };
    after.extend(parameters.map(|parameters| ("parameters".to_owned(), parameters)));
    for (block, is_kept) in [("tool", !has_new_tool), ("fixture", true)] {
        let [is_listed_before, is_listed] = [&before, &after].map(|table| lists(table, block));
        if is_kept && is_listed_before != is_listed {
            let with = |is_listed: bool| if is_listed { "with" } else { "without" };
            let other = if block == "tool" { ", or another tool: this one keeps its prior" } else { "" };
            let expected = format!("parameters {} {block:?} as before{other}", with(is_listed_before));
            return Err(unexpected("with_", expected, format!("parameters {} it", with(is_listed))));
        }
    }
    tables.insert("estimate".to_owned(), after.into());
    Ok(tables.to_string())
}

/// Refuses contacts of fixtures that have targets, without theirs: only files are read with them.
fn check_targets(fixtures: &[Fixture], logs: [&ContactLog; 2]) -> PyResult<()> {
    let is_without = |log: &ContactLog, i: usize| {
        fixtures[log.fixture(i)].manifold.tool_at_target().is_some() && log.target(i).is_none()
    };
    let without = |log: &&ContactLog| (0..log.len()).any(|i| is_without(log, i));
    match logs.iter().any(without) {
        false => Ok(()),
        true => {
            let expected = "logs with targets for a fixture of kind \"target\": name them in its problem.toml";
            Err(unexpected("with_", expected, "a ContactLog, which has none"))
        }
    }
}

/// Whether a table `[estimate]` lists a block of parameters.
fn lists(estimate: &toml::Table, block: &str) -> bool {
    let listed = estimate.get("parameters").and_then(toml::Value::as_array);
    listed.is_some_and(|listed| listed.iter().any(|name| name.as_str() == Some(block)))
}

/// The tool in place of that of a problem, with settings in a text, empty where they are not known.
fn new_tool(tool: &Tool, old: &Problem, text: &str, assumptions: &mut Assumptions) -> PyResult<estimate::Tool> {
    assumptions.forget_place("tool");
    let text = if text.is_empty() { "[estimate]\nparameters = []" } else { text };
    let manifolds = old.fixtures.iter().map(|fixture| fixture.manifold.as_ref());
    Ok(tool.nominal(&settings(text, &old.robot)?, manifolds, assumptions))
}

/// The logs of a problem, without notes on its settings.
struct Logs {
    contacts: ContactLog,
    held_out: ContactLog,
    /// All files of the problem.
    inputs: Vec<Input>,
}

fn logs<'a>(loaded: &'a Loaded, changes: &Bound<'_, PyDict>) -> PyResult<Logs> {
    let old = &loaded.problem;
    let names = FixtureNames::new(old.fixtures.iter().map(|fixture| fixture.name.clone()))?;
    let mut inputs = loaded.inputs.clone();
    let mut joined = JoinedLogs::default();
    // Files of a simulation have none.
    let sha256 = |file: &'a str| {
        let input = loaded.inputs.iter().find(|input| input.path == file);
        input.map_or(file, |input| input.sha256.as_str())
    };
    let mut log = |old_log: &'a ContactLog, name: &str| match changes.get_item(name)? {
        None => Ok(joined.new_rows(old_log, sha256)),
        Some(logs) => {
            inputs.retain(|input| !input.is_log || !old_log.files().contains(&input.path));
            if logs.is_none() && name == "held_out" {
                return Ok(ContactLog::default());
            }
            joined.log(mapping_argument(&logs, name)?, name, &names, old.robot.dof())
        }
    };
    let mut contacts = log(&old.contacts, "contacts")?;
    let held_out = log(&old.held_out, "held_out")?;
    inputs.append(&mut joined.inputs);
    if changes.contains("contacts")? {
        joined.notes.iter().for_each(|note| contacts.note(note));
        note_repetition(&mut contacts, &held_out);
    } else {
        let mut stale = notes_of_settings(loaded)?;
        if changes.contains("tool")? {
            stale.extend([problem_file::KEYS, KEYS].iter().flat_map(|keys| loaded.assumptions.notes(keys)));
        }
        contacts.retain_notes(|note| !stale.iter().any(|stale| stale == note));
    }
    Ok(Logs { contacts, held_out, inputs })
}

/// The notes that the settings of a problem add to those of its logs and parts.
fn notes_of_settings(loaded: &Loaded) -> PyResult<Vec<String>> {
    if loaded.settings.is_empty() {
        return Ok(Vec::new());
    }
    let Problem { robot, tool, fixtures, distances, contacts, .. } = loaded.problem.clone();
    let mut without = contacts;
    without.retain_notes(|_| false);
    let problem = settings(&loaded.settings, &robot)?.problem(robot, (tool, fixtures, distances), without);
    Ok(problem.map_err(|error| io(without_lines(error)))?.contacts.notes().to_vec())
}

//! `touchcal completions`, `touchcal man` and the guide's reference, generated from the definition
//! of the arguments, and `touchcal schema`.

use std::fmt::Write;
use std::io::IsTerminal;

use clap::{Command, CommandFactory};
use clap_mangen::Man;
use touchcal::io::{atomic, problem_file, scenario_file};

use crate::args::{Args, CompletionsArgs, ManArgs, SchemaArgs, SchemaName};
use crate::failure::{Failure, Outcome};
use crate::output;

/// In place of a page on a terminal, which cannot show one.
const HOW_TO_READ: &str =
    "The page is for the program man: touchcal man | man -l -   (all pages into a folder: touchcal man --out man1)\n";

/// Columns of the reference's lines.
const WIDTH: usize = 100;

/// Prints the script for a shell.
pub fn completions(args: &CompletionsArgs) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Args::command(), "touchcal", &mut script);
    output::print(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}

/// Prints the page of `touchcal`, or writes the pages of all commands.
pub fn pages(args: &ManArgs) -> Result<Outcome, Failure> {
    let Some(folder) = &args.out else {
        if std::io::stdout().is_terminal() {
            output::print(HOW_TO_READ)?;
            return Ok(Outcome::Done);
        }
        output::print(&page(&built())?)?;
        return Ok(Outcome::Done);
    };
    atomic::remove_left_over(folder);
    for command in all(&built()) {
        let name = command.get_display_name().unwrap_or(command.get_name());
        atomic::write(&folder.join(format!("{name}.1")), page(&command)?.as_bytes())?;
    }
    Ok(Outcome::Done)
}

/// A page: groups of options are parts of OPTIONS, and each section at the end of the help, such as
/// that of the examples, is one of the page.
fn page(command: &Command) -> Result<String, Failure> {
    let man = Man::new(command.clone());
    let [mut before, mut options, mut commands] = [const { Vec::new() }; 3];
    man.render_title(&mut before).map_err(Failure::Stdout)?;
    man.render_name_section(&mut before).map_err(Failure::Stdout)?;
    man.render_synopsis_section(&mut before).map_err(Failure::Stdout)?;
    man.render_description_section(&mut before).map_err(Failure::Stdout)?;
    man.render_options_section(&mut options).map_err(Failure::Stdout)?;
    if command.has_subcommands() {
        man.render_subcommands_section(&mut commands).map_err(Failure::Stdout)?;
    }
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    let sections: String = help.split("\n\n").filter_map(|section| section.split_once(":\n")).map(section).collect();
    let options = text(&options).replace("\n.SH ", "\n.SS ").replacen(".SS OPTIONS", ".SH OPTIONS", 1);
    Ok(text(&before) + &options + &text(&commands) + &sections)
}

/// A section of a page whose lines stay as they are.
fn section((title, body): (&str, &str)) -> String {
    let body = body.replace('\\', "\\e").replace('-', "\\-");
    format!(".SH {}\n.nf\n{body}\n.fi\n", title.to_uppercase())
}

/// Prints the JSON Schema of a file.
pub fn schema(args: &SchemaArgs) -> Result<Outcome, Failure> {
    output::print(match args.file {
        SchemaName::Problem => problem_file::JSON_SCHEMA,
        SchemaName::Scenario => scenario_file::JSON_SCHEMA,
    })?;
    Ok(Outcome::Done)
}

/// Prints the reference.
pub fn reference() -> Result<Outcome, Failure> {
    let mut text =
        "# Command-line reference\n\nThe output of `touchcal COMMAND --help` for every command.\n".to_owned();
    for command in all(&built()) {
        let help = command.clone().term_width(WIDTH).render_long_help();
        let name = command.get_bin_name().unwrap_or(command.get_name());
        // Writing to a String cannot fail.
        let written = write!(text, "\n## {}\n\n```text\n{}\n```\n", name, help.to_string().trim_end());
        debug_assert!(written.is_ok());
    }
    output::print(&text)?;
    Ok(Outcome::Done)
}

/// The definition with all that clap adds to it, but for its command `help`.
fn built() -> Command {
    let mut command = Args::command().disable_help_subcommand(true);
    command.build();
    command
}

/// The command and all below it that are shown, in the order of `--help`.
fn all(command: &Command) -> Vec<Command> {
    let below = command.get_subcommands().filter(|below| !below.is_hide_set());
    std::iter::once(command.clone()).chain(below.flat_map(all)).collect()
}

//! What the help of several commands has in common: headings of options, and examples.

/// Heading of options on what is written and printed.
pub const OUTPUT: &str = "Output";
/// Heading of options on which contacts are used.
pub const CONTACTS: &str = "Contacts";
/// Heading of options on what is estimated, and how.
pub const ESTIMATION: &str = "Estimation";
/// Heading of options on the arm.
pub const ARM: &str = "Arm";
/// Heading of options on the simulated scenario.
pub const SCENARIO: &str = "Scenario";
/// Heading of options on the trials of an experiment.
pub const TRIALS: &str = "Trials";
/// Heading of options on the machine that computes.
pub const MACHINE: &str = "Machine";

/// The section of examples at the end of a command's help: what each does, and the command, whose
/// lines have at most 74 columns, so that they are not wrapped.
pub fn examples(examples: &[(&str, &str)]) -> String {
    let lines = |command: &str| command.replace('\n', "\n      ");
    let example = |(purpose, command): &(&str, &str)| format!("\n  {purpose}:\n    {}", lines(command));
    "Examples:".to_owned() + &examples.iter().map(example).collect::<String>()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use clap::{Command, CommandFactory, Parser};

    use crate::args::Args;

    /// The command and all below it that are shown.
    fn all(command: &Command) -> Vec<Command> {
        let below = command.get_subcommands().filter(|below| !below.is_hide_set());
        std::iter::once(command.clone()).chain(below.flat_map(all)).collect()
    }

    /// Commands of the examples at the end of a command's help, each on one line.
    fn commands(command: &Command) -> Vec<String> {
        let help = command.get_after_help().unwrap().to_string();
        let joined = help.replace("\\\n      ", "");
        let lines = joined.lines().filter_map(|line| line.strip_prefix("    "));
        lines.filter(|line| line.starts_with("touchcal ")).map(str::to_owned).collect()
    }

    /// Every command has one to three examples, which the command line takes, on lines that are not
    /// wrapped, and which show that command.
    #[test]
    fn examples_are_commands() {
        for command in all(&Args::command()) {
            let name = command.get_name();
            let commands = commands(&command);
            assert!((1..=3).contains(&commands.len()), "{name}: {commands:?}");
            let help = command.get_after_help().unwrap().to_string();
            assert!(help.lines().all(|line| line.chars().count() <= 78), "{help}");
            for line in commands {
                let words = line.split_whitespace().take_while(|word| !matches!(*word, "|" | ">"));
                let taken = Args::try_parse_from(words);
                assert!(taken.is_ok(), "{line}: {}", taken.unwrap_err());
                assert!(name == "touchcal" || line.split_whitespace().any(|word| word == name), "{name}: {line}");
            }
        }
    }

    /// Commands with more options than can be seen at a glance have them in groups.
    #[test]
    fn many_options_are_in_groups() {
        for command in all(&Args::command()) {
            let options: Vec<_> =
                command.get_arguments().filter(|arg| !arg.is_hide_set() && !arg.is_positional()).collect();
            let without = options.iter().filter(|option| option.get_help_heading().is_none()).count();
            assert!(options.len() <= 6 || without <= 2, "{}: {without} options without a group", command.get_name());
        }
    }
}

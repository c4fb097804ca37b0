//! Arguments that cannot be: clap's paragraphs in one line, and numbers below zero as values.

use clap::error::ErrorKind;
use clap::{Command, Error};

/// What is wrong and, where clap knows, what to write instead.
pub struct Complaint {
    pub what: String,
    pub tip: Option<String>,
}

/// `None` for what is no complaint: help that was asked for, a version, help in place of a command that is missing.
pub fn complaint(error: &Error) -> Option<Complaint> {
    use ErrorKind::{DisplayHelp, DisplayHelpOnMissingArgumentOrSubcommand, DisplayVersion};
    if let DisplayHelp | DisplayVersion | DisplayHelpOnMissingArgumentOrSubcommand = error.kind() {
        return None;
    }
    let text = error.to_string();
    // What is missing, or possible, stands on lines of its own.
    let first = text.lines().take_while(|line| !line.is_empty()).map(str::trim).collect::<Vec<_>>().join(" ");
    let mut tips = text.lines().filter_map(|line| line.trim().strip_prefix("tip: "));
    // A flag as a value is nobody's wish.
    let tip = tips.find(|tip| !tip.starts_with("to pass")).map(str::to_owned);
    // What the standard library's parsers say is for programmers.
    let what = first
        .trim_start_matches("error: ")
        .replace("invalid digit found in string", "must be a whole number, not below 0")
        .replace("cannot parse integer from empty string", "must be a whole number, not below 0")
        .replace("invalid float literal", "must be a number");
    Some(Complaint { what, tip })
}

impl Complaint {
    /// One line. `arguments` are those of the process, of which the first words may name a command.
    pub fn line(self, root: &Command, arguments: impl Iterator<Item = String>) -> String {
        let help = || {
            let mut path = vec![root.get_name().to_owned()];
            let mut at = root;
            for word in arguments {
                let Some(next) = at.find_subcommand(&word) else { break };
                path.push(word);
                at = next;
            }
            format!("`{} --help` says what there is", path.join(" "))
        };
        format!("{}; {}", self.what, self.tip.unwrap_or_else(help))
    }
}

/// Every option that takes a value takes one below zero, too: then what is wrong with it is said, not that there is no flag `-1`.
pub fn with_negative_numbers(command: Command) -> Command {
    command
        .mut_args(|arg| {
            let takes = arg.get_action().takes_values();
            arg.allow_negative_numbers(takes)
        })
        .mut_subcommands(with_negative_numbers)
}

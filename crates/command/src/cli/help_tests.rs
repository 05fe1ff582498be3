//! The command line accepts every call of the command in `--help` and in the documentation.

use super::{Arguments, help};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use command_lines::CommandLine;

#[path = "../../../../tests/documents/guide/command_lines.rs"]
mod command_lines;

/// Parses a call. A call quoted in a sentence may lack arguments.
fn check(call: &CommandLine) {
    let line = std::iter::once("foldwing").chain(call.words.iter().map(String::as_str));
    let Err(error) = Arguments::try_parse_from(line) else { return };
    #[expect(clippy::wildcard_enum_match_arm, reason = "a foreign enum that may grow: what it may add is an error")]
    let legal = match error.kind() {
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => true,
        ErrorKind::MissingRequiredArgument => !call.whole,
        // the sentence names an option without its value
        ErrorKind::InvalidValue => !call.whole && call.words.last().is_some_and(|word| word.starts_with("--")),
        _ => false,
    };
    assert!(legal, "{}\n{error}", call.place);
}

/// Text below the options in the `--help` of a command. Wider lines would be wrapped if the width of the terminal is unknown.
fn examples(command: &clap::Command) -> String {
    let text = command.get_after_long_help().map(ToString::to_string).unwrap_or_default();
    let widest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
    assert!(widest <= 100, "foldwing {} --help is {widest} letters wide", command.get_name());
    text
}

/// F-240. The examples of `--help` are valid calls, and every command has at least one.
#[test]
fn f240_examples_of_the_help_parse() {
    let command = Arguments::command();
    let own = examples(&command);
    let top = command_lines::of_lines("foldwing --help", &own);
    assert!(top.len() >= 8, "the order of work has its lines: {own}");
    top.iter().for_each(check);
    for command in command.get_subcommands().filter(|command| command.get_name() != "help") {
        let (name, text) = (command.get_name(), examples(command));
        let calls = command_lines::of_lines(name, &text);
        assert!(calls.iter().any(|call| call.words[0] == name), "foldwing {name} --help has no example:\n{text}");
        calls.iter().for_each(check);
    }
}

/// F-241. Every call of the command in the documentation, on a line of its own or as code in a sentence, is valid.
#[test]
fn f241_command_lines_of_the_documents_parse() {
    let mut count = 0;
    for page in command_lines::pages() {
        let calls = command_lines::of_page(&page);
        count += calls.iter().filter(|call| call.whole).count();
        calls.iter().for_each(check);
    }
    assert!(count > 40, "{count} lines were found");
}

/// The check finds invalid calls, also a wrong option in a sentence.
#[test]
fn a_wrong_call_is_seen() {
    let refused = |text: &str| {
        let calls = command_lines::of_lines("x", text);
        assert_eq!(calls.len(), 1, "{text}");
        std::panic::catch_unwind(|| check(&calls[0])).is_err()
    };
    assert!(refused("foldwing simulate wing.toml --cvs out.csv"));
    assert!(refused("target/release/foldwing simulate"));
    assert!(refused("foldwing simulat wing.toml --csv out.csv"));
    assert!(!refused("foldwing simulate wing.toml --csv out.csv   # a remark"));
    assert!(!refused("foldwing run X.fmu --csv - --set \"a b=1 deg\" | head"));
}

/// Both help texts contain the exit codes.
#[test]
fn exit_codes_stand_below_both_helps() {
    for code in 0..=4 {
        for text in [help::EXIT_CODES, help::ORDER_OF_WORK] {
            assert!(text.contains(&format!("\n  {code}  ")), "exit code {code}");
        }
    }
}

/// Every command prints JSON with `--json` and has `--quiet`, except those that print another file format or serve a page.
#[test]
fn commands_have_json_and_quiet() {
    let command = Arguments::command();
    for command in command.get_subcommands() {
        let other = ["help", "live", "schema", "completions"].contains(&command.get_name());
        for name in ["json", "quiet"] {
            let found = command.get_arguments().any(|argument| argument.get_long() == Some(name));
            assert_eq!(found, !other, "foldwing {} and --{name}", command.get_name());
        }
    }
}

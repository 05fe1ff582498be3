//! Messages on standard error: errors with the line in question and a caret below it, warnings, notes.
//!
//! Colours are used if standard error is a terminal; `NO_COLOR`, `CLICOLOR` and `CLICOLOR_FORCE` are respected. The first line of an error
//! can be parsed by editors and scripts: `error: FILE:LINE: cause`.

use crate::cli::{Failure, renamed};
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use anstyle::AnsiColor;
use foldwing_file::{ConfigError, Fault, Problem, Warning};
use std::ops::Range;

/// Maximum number of problems of a file that are shown with their source line; the others take one line each.
const MAXIMUM_EXCERPTS: usize = 20;
/// Maximum number of bytes of a line shown around the caret.
const MAXIMUM_BYTES: usize = 160;
/// Maximum size in bytes of a file whose lines are shown.
const LARGEST_FILE: u64 = 1 << 24;

/// Excerpt of a text: a line, its number, and the part marked by the caret.
struct Excerpt<'t> {
    line: usize,
    text: &'t str,
    span: Range<usize>,
}

/// Prints the failure of a command.
pub(super) fn failure(failure: &Failure) {
    match failure {
        Failure::Closed => {}
        Failure::Model { text, error } => problems(text, error),
        Failure::Usage(message) => {
            say(Level::ERROR, message, None, "", None);
            let line = CommandLine::of_process();
            line.naming(message).inspect(pointed);
        }
        Failure::Refused(message) => refused(message),
        Failure::Simulation(_) | Failure::Statics(_) | Failure::Files(_) | Failure::Differ(..) => {
            say(Level::ERROR, &failure.to_string(), None, "", None)
        }
    }
}

/// Prints a warning, which does not stop the command.
pub(super) fn warning(message: &str) {
    say(Level::WARNING, message, None, "", None);
}

/// Prints a note.
pub(super) fn note(message: &str) {
    say(Level::NOTE, message, None, "", None);
}

/// Prints a warning about a valid model file.
pub(super) fn warning_about_key(file: &str, text: &str, warning: &Warning) {
    let title = format!("{file}:{}: key '{}': {}", warning.line, warning.key, warning.reason);
    say(Level::WARNING, &title, line_at(text, &warning.span), &warning.advice, None);
}

/// Prints an error of clap: its message, then the location.
pub(super) fn parse_error(error: &clap::Error) {
    let _ = error.print(); // there is no other channel to report a failure
    if !error.use_stderr() {
        return;
    }
    use clap::error::{ContextKind, ContextValue, ErrorKind};
    if let (ErrorKind::UnknownArgument, Some(ContextValue::String(unknown))) =
        (error.kind(), error.get(ContextKind::InvalidArg))
        && let Some(new) = renamed::option(unknown)
    {
        anstream::eprintln!("\n  {unknown} has a new name: {new}");
    }
    let line = CommandLine::of_process();
    let named = [ContextKind::InvalidValue, ContextKind::InvalidSubcommand, ContextKind::InvalidArg].into_iter();
    let found = named.filter_map(|kind| match error.get(kind) {
        Some(ContextValue::String(text)) => line.find(text.split(' ').next().unwrap_or(text)),
        _ => None,
    });
    if let Some(excerpt) = found.into_iter().next() {
        anstream::eprintln!();
        pointed(&excerpt);
    }
}

/// Prints every problem of a model file.
fn problems(text: &str, error: &ConfigError) {
    let ConfigError::Refused { file, problems } = error else {
        return say(Level::ERROR, &error.to_string(), None, "", None);
    };
    for (n, problem) in problems.iter().enumerate() {
        if n >= MAXIMUM_EXCERPTS || matches!(problem.fault, Fault::Further { .. }) {
            say(Level::ERROR, &format!("{file}:{problem}"), None, "", None);
            continue;
        }
        let (wrong, cure, help) = parts(problem);
        say(Level::ERROR, &format!("{file}:{}: {wrong}", problem.line), line_at(text, &problem.span), &cure, help);
    }
}

/// Returns the message of a problem, the text at the caret, and the allowed values.
fn parts(problem: &Problem) -> (String, String, Option<String>) {
    let key = &problem.key;
    match &problem.fault {
        Fault::UnknownKey { suggestion, allowed } => (
            format!("key '{key}' is unknown"),
            suggestion.clone().unwrap_or_default(),
            Some(format!("allowed keys: {}", allowed.join(", "))),
        ),
        Fault::RenamedKey { new } => (format!("key '{key}' has a new name"), format!("now called '{new}'"), None),
        Fault::MissingKey { allowed } => (format!("key '{key}' is missing"), format!("add it: {allowed}"), None),
        Fault::NotAllowed { value, allowed } => {
            (format!("key '{key}': {value} is not allowed"), format!("allowed: {allowed}"), None)
        }
        Fault::Syntax { message } => (format!("not valid TOML: {message}"), String::new(), None),
        Fault::Further { .. } => (problem.to_string(), String::new(), None),
    }
}

/// Prints an error in a file, with the source line if the message names one.
fn refused(message: &str) {
    let place = message.split_once(": ").and_then(|(place, cause)| {
        let (file, line) = place.rsplit_once(':')?;
        Some((file, line.parse::<usize>().ok()?, cause))
    });
    let small = |file: &str| std::fs::metadata(file).is_ok_and(|found| found.is_file() && found.len() <= LARGEST_FILE);
    let text = place.filter(|(file, ..)| small(file)).and_then(|(file, ..)| std::fs::read_to_string(file).ok());
    let (Some((_, number, cause)), Some(text)) = (place, &text) else {
        return say(Level::ERROR, message, None, "", None);
    };
    let begin = text.split_inclusive('\n').take(number.saturating_sub(1)).map(str::len).sum::<usize>();
    let line = text[begin..].lines().next().unwrap_or_default();
    // mark the quoted parts of the message if the line contains them
    let quoted = cause.split('`').skip(1).step_by(2).filter(|quoted| !quoted.is_empty());
    let at = quoted.filter_map(|quoted| line.find(quoted).map(|at| at..at + quoted.len())).next();
    let span = at.unwrap_or(0..line.len());
    say(Level::ERROR, message, line_at(text, &(begin + span.start..begin + span.end)), "", None);
}

/// Returns the line in which a span starts, shortened to the surroundings of the span.
fn line_at<'t>(text: &'t str, span: &Range<usize>) -> Option<Excerpt<'t>> {
    let start = span.start.min(text.len());
    let before = text.get(..start)?;
    let begin = before.rfind('\n').map_or(0, |at| at + 1);
    let end = text[start..].find('\n').map_or(text.len(), |at| start + at);
    let line = before.matches('\n').count() + 1;
    let near = |at: usize| (at..=text.len()).find(|at| text.is_char_boundary(*at)).unwrap_or(text.len());
    let from = near(begin.max(start.saturating_sub(MAXIMUM_BYTES / 2)));
    let to = near(end.min(from + MAXIMUM_BYTES)).min(end).max(from);
    let span = start.max(from) - from..span.end.clamp(start, to.max(start)) - from;
    let shown = text[from..to].trim_end();
    Some(Excerpt { line, span: span.start.min(shown.len())..span.end.min(shown.len()), text: shown })
}

/// The command line as typed, as far as it can be reconstructed, to show carets below it.
struct CommandLine {
    text: String,
    /// Words without the name of the program, with their positions.
    words: Vec<(String, Range<usize>)>,
}

impl CommandLine {
    fn of_process() -> Self {
        Self::new(std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()))
    }

    fn new(words: impl Iterator<Item = String>) -> Self {
        let mut line = Self { text: "foldwing".to_owned(), words: Vec::new() };
        for word in words {
            line.text.push(' ');
            let plain = !word.is_empty()
                && !word.contains(|letter: char| letter.is_whitespace() || "\"'*;&$()".contains(letter));
            let shown = if plain { word.clone() } else { format!("\"{}\"", word.escape_debug()) };
            let begin = line.text.len();
            line.text.push_str(&shown);
            line.words.push((word, begin..line.text.len()));
        }
        line
    }

    /// Returns the word that equals or starts with `text`.
    fn find(&self, text: &str) -> Option<Excerpt<'_>> {
        let whole = self.words.iter().rfind(|(word, _)| word == text);
        let part = || self.words.iter().rfind(|(word, _)| word.contains(text) && !text.is_empty());
        whole.or_else(part).map(|(_, span)| self.excerpt(span.clone()))
    }

    /// Returns the longest word, or part of it after `=` or between commas, that a message contains.
    fn naming(&self, message: &str) -> Option<Excerpt<'_>> {
        let mut best: Option<Range<usize>> = None;
        for (word, span) in self.words.iter().skip(1) {
            let shown = &self.text[span.clone()];
            let parts = std::iter::once(word.as_str()).chain(word.split(['=', ',']));
            let names = |part: &&str| {
                let option = part.starts_with('-') && part.parse::<f64>().is_err();
                part.len() > 1 && !option && message.contains(*part) || *part == "-" && message.contains("-: ")
            };
            for part in parts.filter(names) {
                let Some(at) = shown.find(part) else { continue };
                if best.as_ref().is_none_or(|best| best.len() < part.len()) {
                    best = Some(span.start + at..span.start + at + part.len());
                }
            }
        }
        // otherwise mark an option that the message names
        let option = || {
            let named = self.words.iter().filter(|(word, _)| word.starts_with("--") && message.contains(word.as_str()));
            named.map(|(_, span)| span.clone()).next()
        };
        best.or_else(option).map(|span| self.excerpt(span))
    }

    /// Returns the command line, shortened to the surroundings of a span.
    fn excerpt(&self, span: Range<usize>) -> Excerpt<'_> {
        line_at(&self.text, &span).unwrap_or(Excerpt { line: 1, text: &self.text, span })
    }
}

/// Prints the command line with carets below a part of it, without a line number.
fn pointed(excerpt: &Excerpt) {
    let before = excerpt.text[..excerpt.span.start].chars().count();
    let carets = excerpt.text[excerpt.span.clone()].chars().count().max(1);
    let (bar, caret) = (AnsiColor::BrightBlue.on_default().bold(), AnsiColor::BrightRed.on_default().bold());
    anstream::eprintln!("  {bar}|{bar:#} {}", excerpt.text);
    anstream::eprintln!("  {bar}|{bar:#} {:before$}{caret}{}{caret:#}", "", "^".repeat(carets));
}

/// Prints one message.
fn say(level: Level, title: &str, excerpt: Option<Excerpt>, cure: &str, help: Option<String>) {
    let title = level.primary_title(title.to_owned());
    let mut group = match &excerpt {
        Some(excerpt) => snippet(title, excerpt, cure),
        None => Group::with_title(title),
    };
    if excerpt.is_none() && !cure.is_empty() {
        group = group.element(Level::HELP.message(cure.to_owned()));
    }
    if let Some(help) = help {
        group = group.element(Level::HELP.message(help));
    }
    anstream::eprintln!("{}", rendered(&[group]));
}

/// Combines a title with a line and its caret.
fn snippet<'a>(title: annotate_snippets::Title<'a>, excerpt: &Excerpt<'a>, label: &str) -> Group<'a> {
    let caret = AnnotationKind::Primary.span(excerpt.span.clone());
    let caret = if label.is_empty() { caret } else { caret.label(label.to_owned()) };
    title.element(Snippet::source(excerpt.text).line_start(excerpt.line).annotation(caret))
}

/// Renders text with terminal colours; `anstream` removes them if they are not supported.
fn rendered(groups: &[Group]) -> String {
    Renderer::styled().render(groups)
}

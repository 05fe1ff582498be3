//! Selection of variables by names, lists with commas, patterns and prefixes, as for `--variables`, with the error messages of
//! the command.

use crate::cli::Failure;
use crate::report::Channel;
use crate::report::inputs::{name_message, unknown_name};
use foldwing_study::names::choose;

/// Returns the variables selected by the names, each once, in the order of the names.
///
/// # Errors
/// Names and patterns without a match, with suggestions; `what` describes the variables in the message.
pub fn chosen<'a, C: Channel>(names: &[String], rows: &[&'a C], what: &'static str) -> Result<Vec<&'a C>, Failure> {
    choose(names, rows, C::name, what).map_err(|error| Failure::Usage(name_message::<C>(&error)))
}

/// Error for an unknown variable name.
pub fn unknown<'a, C: Channel + 'a>(name: &str, what: &'static str, rows: impl IntoIterator<Item = &'a C>) -> Failure {
    Failure::Usage(unknown_name(name, what, rows.into_iter()))
}

//! `--variables` and its like: variables chosen by names, lists with commas, patterns and prefixes, in the words of the command.

use crate::cli::Failure;
use crate::report::Channel;
use crate::report::inputs::name_message;
use foldwing_study::names::choose;

/// The rows that the names choose, each once, in the order in which they are named.
///
/// # Errors
/// Names and patterns that no row has, with what may be meant; `what` is what the rows are.
pub(super) fn chosen<'a, C: Channel>(
    names: &[String],
    rows: &[&'a C],
    what: &'static str,
) -> Result<Vec<&'a C>, Failure> {
    choose(names, rows, C::name, what).map_err(|error| Failure::Usage(name_message::<C>(&error)))
}

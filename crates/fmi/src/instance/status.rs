//! Status of calls.

/// Outcome of a call: the statuses common to both versions of the standard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// The call succeeded.
    Ok,
    /// The call succeeded, with a warning.
    Warning,
    /// A value was rejected; nothing changed.
    Discard,
    /// The call is illegal or failed.
    Error,
    /// The instance can no longer be used.
    Fatal,
}

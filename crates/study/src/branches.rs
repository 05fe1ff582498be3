//! Modes that are tracked over a quantity.

/// Number of modes to look for where `count` are to be tracked: real ones and heavily damped ones come in between on the way.
pub fn pool(count: usize) -> usize {
    2 * count + 4
}

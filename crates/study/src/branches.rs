//! Modes that are tracked over a parameter, such as a speed.

/// Number of modes to compute if `count` are to be tracked: real ones and heavily damped ones can appear between them.
pub fn pool(count: usize) -> usize {
    2 * count + 4
}

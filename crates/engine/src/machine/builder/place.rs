//! Places of settings in error messages.

/// Place of a setting of an aerodynamic model in error messages; a single model has no name.
pub(in crate::machine) fn air_place<'a>(part: &'a str, key: &'a str) -> Vec<&'a str> {
    match part {
        "" => vec!["air", key],
        part => vec!["air", part, key],
    }
}

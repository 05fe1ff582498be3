//! The GUID, which connects a model description with the model file and the library that reads it.

use crate::interface::Variable;
use sha2::{Digest, Sha256};

/// GUID of a model: a hash of the model file and of the variable table, `{8-4-4-4-12}` hexadecimal digits.
///
/// The table is included because value references are positions in it: a library whose table differs must reject a description written by
/// another.
pub fn guid(model_text: &str, variables: &[Variable]) -> String {
    let mut hash = Sha256::new();
    hash.update(b"foldwing model\0");
    hash.update(model_text.as_bytes());
    for variable in variables {
        hash.update(row(variable).as_bytes());
    }
    form(&hash.finalize())
}

/// The first 16 bytes of a digest as `{8-4-4-4-12}` hexadecimal digits.
pub(super) fn form(digest: &[u8]) -> String {
    let hex: String = digest.iter().take(16).map(|byte| format!("{byte:02x}")).collect();
    format!("{{{}-{}-{}-{}-{}}}", &hex[0..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..32])
}

/// Properties in which rows must agree to be compatible: reference, name, type, causality, variability, unit.
fn row(variable: &Variable) -> String {
    format!(
        "\0{} {} {} {:?} {:?} {:?}",
        variable.value_reference,
        variable.name,
        variable.value.kind().name(),
        variable.causality,
        variable.variability,
        variable.declared_type
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn guid_has_the_standard_form_and_follows_the_model() {
        let first = guid("a", &[]);
        assert_eq!(first.len(), 38);
        assert!(first.starts_with('{') && first.ends_with('}'));
        let dashes: Vec<_> = first.match_indices('-').map(|(at, _)| at).collect();
        assert_eq!(dashes, [9, 14, 19, 24]);
        assert_eq!(first, guid("a", &[]));
        assert_ne!(first, guid("b", &[]));
    }
}

//! Base64 encoding of RFC 4648, section 4, for binary data in a model file.

/// Letters of the encoding in the order of their values.
const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Encodes bytes as padded base64.
pub(super) fn encoded(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let whole = chunk.iter().fold(0u32, |whole, byte| whole << 8 | u32::from(*byte)) << (8 * (3 - chunk.len()));
        for place in 0..4 {
            let letter = LETTERS[(whole >> (18 - 6 * place)) as usize & 63];
            text.push(if place <= chunk.len() { char::from(letter) } else { '=' });
        }
    }
    text
}

/// Decodes a base64 text; `None` if it is invalid.
pub(super) fn decoded(text: &str) -> Option<Vec<u8>> {
    let mut values = [u8::MAX; 256];
    for (value, letter) in LETTERS.iter().enumerate() {
        values[usize::from(*letter)] = value as u8;
    }
    let code = text.trim_end_matches('=').as_bytes();
    if !text.len().is_multiple_of(4) || text.len() - code.len() > 2 {
        return None;
    }
    let mut bytes = Vec::with_capacity(code.len() / 4 * 3 + 2);
    for chunk in code.chunks(4) {
        let mut whole = 0u32;
        for letter in chunk {
            let value = values[usize::from(*letter)];
            if value == u8::MAX {
                return None;
            }
            whole = whole << 6 | u32::from(value);
        }
        whole <<= 6 * (4 - chunk.len());
        bytes.extend(whole.to_be_bytes()[1..chunk.len()].iter());
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 4648, section 10, and all byte values are encoded and decoded.
    #[test]
    fn both_ways() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(encoded(bytes.as_bytes()), text);
            assert_eq!(decoded(text).as_deref(), Some(bytes.as_bytes()));
        }
        let all: Vec<u8> = (0..=255).collect();
        assert_eq!(decoded(&encoded(&all)), Some(all));
        for bad in ["Z", "Zg=", "Zg", "Z===", "Zm9*", "Zm 9v==="] {
            assert_eq!(decoded(bad), None, "{bad}");
        }
    }
}

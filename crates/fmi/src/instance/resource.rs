//! Location of the model file: the resource location, a URI in one of several forms.

use std::path::PathBuf;

/// Name of the model file in the resource folder.
pub const MODEL_FILE: &str = "model.toml";

/// Error in the resource location.
#[derive(Debug, thiserror::Error)]
pub enum ResourceError {
    /// Null or empty.
    #[error("no resource location was given: the model file cannot be found")]
    Missing,
    /// Another scheme than `file`.
    #[error("the resource location {location:?} is not a file URI or a path")]
    Scheme {
        /// The given location.
        location: String,
    },
    /// Invalid percent-encoding.
    #[error("the resource location {location:?} is not properly percent-encoded UTF-8")]
    Encoding {
        /// The given location.
        location: String,
    },
    /// The file cannot be read.
    #[error("the model file {path:?} cannot be read: {source}")]
    Read {
        /// Expected path.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
}

/// Reads the model file in the resource folder; returns text and path.
pub fn read_model(location: Option<&str>) -> Result<(String, PathBuf), ResourceError> {
    let path = resource_path(location)?.join(MODEL_FILE);
    match std::fs::read_to_string(&path) {
        Ok(text) => Ok((text, path)),
        Err(source) => Err(ResourceError::Read { path, source }),
    }
}

/// Folder of a resource location: `file:///`, `file:/`, `file://localhost/`, with drive letter or host, or a plain path. Only URIs are
/// percent-decoded.
pub fn resource_path(location: Option<&str>) -> Result<PathBuf, ResourceError> {
    let location = location.filter(|location| !location.is_empty()).ok_or(ResourceError::Missing)?;
    match scheme(location) {
        None => Ok(PathBuf::from(location)),
        Some((scheme, rest)) if scheme.eq_ignore_ascii_case("file") => {
            let decoded =
                percent_decode(rest).ok_or_else(|| ResourceError::Encoding { location: location.to_owned() })?;
            Ok(PathBuf::from(local_part(&decoded)))
        }
        Some(_) => Err(ResourceError::Scheme { location: location.to_owned() }),
    }
}

/// Splits off a scheme; a single letter is a drive, not a scheme.
fn scheme(location: &str) -> Option<(&str, &str)> {
    let (scheme, rest) = location.split_once(':')?;
    let is_scheme = scheme.len() > 1
        && scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
    is_scheme.then_some((scheme, rest))
}

/// Decoded path from the part of a file URI after `file:`.
fn local_part(part: &str) -> String {
    let path = match part.strip_prefix("//") {
        Some(authority_and_path) => match authority_and_path.split_once('/') {
            Some(("", path)) => format!("/{path}"),
            Some((host, path)) if host.eq_ignore_ascii_case("localhost") => format!("/{path}"),
            Some((host, _)) if is_drive(host) => authority_and_path.to_owned(),
            _ => format!("//{authority_and_path}"), // another host: a network share
        },
        None => part.to_owned(),
    };
    match path.strip_prefix('/') {
        Some(rest) if is_drive(rest.split('/').next().unwrap_or("")) => rest.to_owned(),
        _ => path,
    }
}

fn is_drive(text: &str) -> bool {
    matches!(text.as_bytes(), [letter, b':'] if letter.is_ascii_alphabetic())
}

fn percent_decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(match byte {
            b'%' => {
                let (high, low) = (char::from(rest.next()?).to_digit(16)?, char::from(rest.next()?).to_digit(16)?);
                u8::try_from(16 * high + low).ok()?
            }
            byte => byte,
        });
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(location: &str) -> String {
        resource_path(Some(location)).expect(location).to_string_lossy().into_owned()
    }

    #[test]
    fn every_spelling_of_a_local_folder_is_understood() {
        for location in ["file:///a/resources", "file:/a/resources", "file://localhost/a/resources", "/a/resources"] {
            assert_eq!(path(location), "/a/resources", "{location}");
        }
        assert_eq!(path("FILE:///a/resources/"), "/a/resources/");
        assert_eq!(path("a/resources"), "a/resources");
    }

    #[test]
    fn drive_letters_lose_the_slash_before_them() {
        for location in ["file:///C:/a/r", "file:/C:/a/r", "file://localhost/C:/a/r", "file://C:/a/r", "C:/a/r"] {
            assert_eq!(path(location), "C:/a/r", "{location}");
        }
        assert_eq!(path(r"C:\a\r"), r"C:\a\r");
        assert_eq!(path("file:///c%3A/a/r"), "c:/a/r");
        assert_eq!(path("file://server/share/r"), "//server/share/r");
    }

    #[test]
    fn uris_are_percent_decoded_and_paths_are_not() {
        assert_eq!(path("file:///a%20b/%C3%A4/100%25"), "/a b/ä/100%");
        assert_eq!(path("/a%20b"), "/a%20b");
    }

    #[test]
    fn what_is_no_folder_is_refused_with_a_reason() {
        let refused = |location: Option<&str>| resource_path(location).expect_err("refused").to_string();
        assert!(refused(None).contains("no resource location"));
        assert!(refused(Some("")).contains("no resource location"));
        assert!(refused(Some("http://a/r")).contains("\"http://a/r\" is not a file URI"));
        for broken in ["file:///a%2", "file:///a%zz", "file:///a%ff"] {
            assert!(refused(Some(broken)).contains("percent-encoded"), "{broken}");
        }
    }

    #[test]
    fn a_missing_file_is_named() {
        let error = read_model(Some("file:///no/such/folder")).expect_err("missing").to_string();
        assert!(error.contains("/no/such/folder") && error.contains("model.toml"), "{error}");
    }
}

//! Check for truncated shared libraries: the loader maps the sections listed in the headers, and an access beyond the end of the file
//! would end the process.

use object::{Object, ObjectSection, ObjectSegment};
use std::fs;
use std::path::Path;

/// Checks every library in a folder, since one may load another.
///
/// # Errors
/// Path of the first truncated library, and the missing part.
pub(super) fn check_images(folder: &Path) -> Result<(), (String, String)> {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let bytes = if path.is_file() { fs::read(&path) } else { continue };
        let checked = bytes.map_err(|error| error.to_string()).and_then(|bytes| check(&bytes));
        checked.map_err(|cause| (path.display().to_string(), cause))?;
    }
    Ok(())
}

/// Compares the sections of an image with the length of its file. Files of other formats are left to the loader.
fn check(bytes: &[u8]) -> Result<(), String> {
    if !matches!(bytes, [0x7f, b'E', b'L', b'F', ..] | [b'M', b'Z', ..] | [0xcf, 0xfa, 0xed, 0xfe, ..]) {
        return Ok(());
    }
    let image = object::File::parse(bytes).map_err(|error| format!("the library is cut off or damaged: {error}"))?;
    let segments = image.segments().map(|segment| segment.file_range());
    let sections = image.sections().filter_map(|section| section.file_range());
    let end = segments.chain(sections).map(|(begin, size)| begin.saturating_add(size)).max().unwrap_or(0);
    let length = bytes.len() as u64;
    if end > length {
        return Err(format!("the library is cut off: it has {length} bytes, and its headers name {end}"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// This executable is accepted; truncated to any length it is rejected, and other files are ignored.
    #[test]
    fn a_library_that_ends_too_early_is_found_out() {
        let whole = fs::read(std::env::current_exe().unwrap()).unwrap();
        check(&whole).unwrap();
        for share in [1, 10, 50, 90, 99] {
            let error = check(&whole[..whole.len() * share / 100]).unwrap_err();
            assert!(error.contains("cut off"), "{error}");
        }
        check(b"#!/bin/sh").unwrap();
    }
}

//! The FMU archive: the same model, library and version give the same bytes.

use crate::config::Machine;
use crate::packaging::MODEL_IDENTIFIER;
use crate::packaging::contents::{Extras, contents};
use std::collections::BTreeMap;
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Why no archive was written.
#[derive(Debug, thiserror::Error)]
pub enum PackageError {
    /// The library cannot be read.
    #[error("{path}: cannot read the library: {source}")]
    Library {
        /// File that was asked for.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The library is no Foldwing library, or one for a platform that FMI 2.0 does not name.
    #[error("{path}: {cause}")]
    NotALibrary {
        /// File that was read.
        path: PathBuf,
        /// What is wrong with it.
        cause: &'static str,
    },
    /// The archive cannot be written.
    #[error("{path}: cannot write the FMU: {source}")]
    Write {
        /// File that was to be written.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// Writes the FMU of a model to `fmu`, whole or not at all.
///
/// `model_text` is the file that `machine` was read from; it travels in the archive. `library` is a shared
/// library of this package for any platform of FMI 2.0. `extras` is what the archive holds beyond the necessary.
pub fn package(
    machine: &Machine,
    model_text: &str,
    extras: &Extras,
    library: &Path,
    fmu: &Path,
) -> Result<(), PackageError> {
    let binary = std::fs::read(library).map_err(|source| PackageError::Library { path: library.to_owned(), source })?;
    let platform = platform(&binary).map_err(|cause| PackageError::NotALibrary { path: library.to_owned(), cause })?;
    let mut entries: BTreeMap<String, Entry> = contents(machine, model_text, extras)
        .into_iter()
        .map(|(path, bytes)| (path, Entry { bytes, permissions: 0o644 }))
        .collect();
    let library = format!("binaries/{}/{MODEL_IDENTIFIER}.{}", platform.folder, platform.extension);
    entries.insert(library, Entry { bytes: binary, permissions: 0o755 });
    let bytes = archive(&entries);
    replace(fmu, &bytes).map_err(|source| PackageError::Write { path: fmu.to_owned(), source })
}

/// FMI 2.0 folder and file extension of a platform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Platform {
    folder: &'static str,
    extension: &'static str,
}

/// Platform of a library by its first bytes, and whether it exports what an FMU must.
fn platform(binary: &[u8]) -> Result<Platform, &'static str> {
    const X86_64_ELF: [u8; 2] = [0x3e, 0];
    let found = if binary.starts_with(b"\x7fELF\x02") {
        if binary.get(18..20) != Some(&X86_64_ELF) {
            return Err("the library is for a Linux processor other than x86-64, which FMI 2.0 does not name");
        }
        Platform { folder: "linux64", extension: "so" }
    } else if binary.starts_with(b"MZ") {
        Platform { folder: "win64", extension: "dll" }
    } else if binary.starts_with(&[0xcf, 0xfa, 0xed, 0xfe]) || binary.starts_with(&[0xca, 0xfe, 0xba, 0xbe]) {
        Platform { folder: "darwin64", extension: "dylib" }
    } else {
        return Err("not a 64-bit shared library (ELF, PE or Mach-O)");
    };
    let symbol = b"fmi2Instantiate";
    if !binary.windows(symbol.len()).any(|window| window == symbol) {
        return Err("not a Foldwing library: it does not export fmi2Instantiate");
    }
    Ok(found)
}

/// One file of the archive; the map that holds them keeps them sorted by path.
struct Entry {
    bytes: Vec<u8>,
    permissions: u32,
}

/// A zip of the entries: deflate only, one fixed date, so that nothing but the contents decides the bytes.
fn archive(entries: &BTreeMap<String, Entry>) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, entry) in entries {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default())
            .unix_permissions(entry.permissions);
        zip.start_file(path.as_str(), options).expect("entry names are unique and valid");
        zip.write_all(&entry.bytes).expect("writing to memory does not fail");
    }
    zip.finish().expect("writing to memory does not fail").into_inner()
}

/// Writes beside the target, then renames: readers see the old file or the new one, never half of it.
fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new().prefix(".foldwing-").permissions(readable()).tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// Permissions of a finished FMU: readable for all, as an ordinary file (temporary files are private).
#[cfg(unix)]
fn readable() -> std::fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(0o644)
}

#[cfg(not(unix))]
fn readable() -> std::fs::Permissions {
    std::fs::metadata(".").map(|meta| meta.permissions()).expect("the working directory exists")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn elf(machine: u8) -> Vec<u8> {
        let mut bytes = b"\x7fELF\x02".to_vec();
        bytes.resize(18, 0);
        bytes.extend([machine, 0]);
        bytes.extend(b"..fmi2Instantiate..");
        bytes
    }

    /// The platform comes from the library's own header, not from the machine that packages.
    #[test]
    fn platform_is_read_from_the_library() {
        assert_eq!(platform(&elf(0x3e)).unwrap().folder, "linux64");
        assert_eq!(platform(b"MZ...fmi2Instantiate").unwrap().folder, "win64");
        assert!(platform(&elf(0xb7)).unwrap_err().contains("x86-64"));
        assert!(platform(b"#!/bin/sh").unwrap_err().contains("shared library"));
        assert!(platform(b"MZ nothing").unwrap_err().contains("fmi2Instantiate"));
    }

    /// Entries are sorted, deflated, dated alike, and come back with their bytes and permissions.
    #[test]
    fn archive_is_reproducible_and_readable() {
        let entries = BTreeMap::from([
            ("b.txt".to_owned(), Entry { bytes: b"second".to_vec(), permissions: 0o644 }),
            ("a/library.so".to_owned(), Entry { bytes: vec![7; 10_000], permissions: 0o755 }),
        ]);
        let bytes = archive(&entries);
        assert_eq!(bytes, archive(&entries));

        let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let names: Vec<_> = (0..zip.len()).map(|i| zip.by_index(i).unwrap().name().unwrap().into_owned()).collect();
        assert_eq!(names, ["a/library.so", "b.txt"]);
        let mut library = zip.by_name("a/library.so").unwrap();
        assert_eq!(library.compression(), CompressionMethod::Deflated);
        assert_eq!(library.unix_mode().unwrap() & 0o777, 0o755);
        let mut back = Vec::new();
        library.read_to_end(&mut back).unwrap();
        assert_eq!(back, vec![7; 10_000]);
    }

    /// A target folder that does not exist is an error, and leaves nothing behind.
    #[test]
    fn replace_leaves_nothing_behind_on_failure() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("wing.fmu");
        replace(&target, b"one").unwrap();
        replace(&target, b"two").unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), b"two");
        assert!(replace(&folder.path().join("missing/wing.fmu"), b"three").is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

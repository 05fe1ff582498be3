//! The FMU archive, which is reproducible: the same model, library and version give the same bytes.

use crate::packaging::contents::contents;
use crate::packaging::extras::Extras;
pub use crate::packaging::library::PackageError;
use crate::packaging::{Library, Platform};
use foldwing_engine::machine::Machine;
use foldwing_fmi::instance::Version;
use std::collections::BTreeMap;
use std::io::{Cursor, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Returns the bytes of the FMU of a model.
///
/// `model_text` is the file from which `machine` was read; it is included in the archive. `libraries` are shared libraries of this package,
/// one for each platform of the FMU. `extras` are the optional contents.
pub fn package(
    machine: &Machine,
    model_text: &str,
    extras: &Extras,
    libraries: &[Library],
) -> Result<Vec<u8>, PackageError> {
    let mut entries: BTreeMap<String, Entry> =
        contents(machine, model_text, extras).into_iter().map(|(path, bytes)| (path, Entry::data(bytes))).collect();
    entries.extend(binaries(&machine.name, libraries, extras.kinds.version)?);
    Ok(archive(&entries))
}

/// Libraries by their paths in the archive. Their name is the standard's `modelIdentifier`: that of the model, because some importers keep one
/// library for each identifier, and would run the first model for all others.
fn binaries(
    identifier: &str,
    libraries: &[Library],
    version: Version,
) -> Result<BTreeMap<String, Entry>, PackageError> {
    for (i, library) in libraries.iter().enumerate() {
        if let Some(first) = libraries[..i].iter().find(|first| first.platform == library.platform) {
            let (path, first) = (library.path.clone(), first.path.clone());
            return Err(PackageError::Twice { path, first, platform: library.platform });
        }
    }
    let entry = |library: &Library| {
        let Platform { extension, .. } = library.platform;
        let folder = library.platform.folder_of(version);
        let path = format!("binaries/{folder}/{identifier}.{extension}");
        (path, Entry { bytes: library.bytes.clone(), permissions: 0o755 })
    };
    Ok(libraries.iter().map(entry).collect())
}

/// File of the archive; the map that contains them sorts them by path.
pub(super) struct Entry {
    bytes: Vec<u8>,
    permissions: u32,
}

impl Entry {
    /// A file that is not executed.
    pub(super) fn data(bytes: Vec<u8>) -> Self {
        Self { bytes, permissions: 0o644 }
    }
}

/// Creates a zip archive of the entries, all compressed with deflate and with a fixed date, so that the bytes depend only on the contents.
pub(super) fn archive(entries: &BTreeMap<String, Entry>) -> Vec<u8> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    /// Each library is in the folder of its platform; two for one platform are an error that names both.
    #[test]
    fn libraries_go_into_the_folders_of_their_platforms() {
        let library = |path: &str, platform: &str| Library {
            path: path.into(),
            platform: Platform::named(platform).unwrap(),
            bytes: path.as_bytes().to_vec(),
        };
        let found = binaries(
            "Wing",
            &[library("w", "win64"), library("l", "linux64"), library("m", "aarch64-darwin")],
            Version::Fmi2,
        )
        .unwrap();
        let found: Vec<_> = found.iter().map(|(path, entry)| (path.as_str(), entry.bytes.as_slice())).collect();
        let expected = [
            ("binaries/aarch64-darwin/Wing.dylib", b"m".as_slice()),
            ("binaries/linux64/Wing.so", b"l"),
            ("binaries/win64/Wing.dll", b"w"),
        ];
        assert_eq!(found, expected);

        let twice = binaries("Wing", &[library("a.so", "linux64"), library("b.so", "linux64")], Version::Fmi3)
            .err()
            .unwrap()
            .to_string();
        assert_eq!(twice, "b.so: a second library for linux64; the first is a.so");
    }

    /// Entries are sorted, deflated, have the same date, and are read back with their bytes and permissions.
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
}

//! Licences inside the archive: those of Foldwing and of the code linked into the library.

/// Folder inside the archive, as in FMI 2.0.4; `license.txt` is the entry point.
pub const FOLDER: &str = "documentation/licenses";

/// Files in the folder.
pub const FILES: [(&str, &str); 4] = [
    ("license.txt", include_str!("../../shipped/license.txt")),
    ("LICENSE-APACHE.txt", include_str!("../../shipped/LICENSE-APACHE")),
    ("LICENSE-MIT.txt", include_str!("../../shipped/LICENSE-MIT")),
    ("THIRD_PARTY.txt", include_str!("../../shipped/THIRD_PARTY.txt")),
];

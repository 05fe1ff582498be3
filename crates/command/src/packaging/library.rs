//! Shared libraries of an archive, and their platforms.

use foldwing_fmi::fmi2;
use foldwing_fmi::fmi3;
use foldwing_fmi::instance::Version;
use object::read::NameOrOrdinal;
use object::read::macho::{FatArch, MachOFatFile32, MachOFatFile64};
use object::{Architecture, BinaryFormat, FileKind, Object, ObjectKind};
use std::path::{Path, PathBuf};
use std::{fmt, io};

/// Error of writing an archive.
#[derive(Debug, thiserror::Error)]
pub enum PackageError {
    /// The library cannot be read.
    #[error("{path}: cannot read the library: {source}")]
    Library {
        /// Requested file.
        path: PathBuf,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The file is not a Foldwing library, or its platform is not the requested one or has no name in FMI.
    #[error("{path}: {cause}")]
    NotALibrary {
        /// The file.
        path: PathBuf,
        /// The cause.
        cause: String,
    },
    /// Two libraries for the same platform.
    #[error("{path}: a second library for {platform}; the first is {first}")]
    Twice {
        /// The second one.
        path: PathBuf,
        /// The first one.
        first: PathBuf,
        /// Platform of both libraries.
        platform: Platform,
    },
}

/// Folder below `binaries/` and file extension of a platform.
///
/// FMI 2.0.4, section 2.3: `win32`, `win64`, `linux32`, `linux64`, `darwin32`, `darwin64` are x86 platforms; any other platform is
/// named by its platform tuple of FMI 3.0, section 2.5.1.4.1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Platform {
    /// Name of the folder.
    pub folder: &'static str,
    /// Extension of the library, without the dot.
    pub extension: &'static str,
}

impl fmt::Display for Platform {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(self.folder)
    }
}

/// Supported platforms: folder, file extension, and the format and architecture in the header of the library.
const PLATFORMS: &[(&str, &str, BinaryFormat, Architecture)] = &[
    ("linux64", "so", BinaryFormat::Elf, Architecture::X86_64),
    ("linux32", "so", BinaryFormat::Elf, Architecture::I386),
    ("aarch64-linux", "so", BinaryFormat::Elf, Architecture::Aarch64),
    ("aarch32-linux", "so", BinaryFormat::Elf, Architecture::Arm),
    ("riscv64-linux", "so", BinaryFormat::Elf, Architecture::Riscv64),
    ("win64", "dll", BinaryFormat::Pe, Architecture::X86_64),
    ("win32", "dll", BinaryFormat::Pe, Architecture::I386),
    ("aarch64-windows", "dll", BinaryFormat::Pe, Architecture::Aarch64),
    ("darwin64", "dylib", BinaryFormat::MachO, Architecture::X86_64),
    ("darwin32", "dylib", BinaryFormat::MachO, Architecture::I386),
    ("aarch64-darwin", "dylib", BinaryFormat::MachO, Architecture::Aarch64),
];

impl Platform {
    /// Returns the platform with a name; the error for an unknown name lists all names.
    pub fn named(name: &str) -> Result<Self, String> {
        Self::find(|row| row.0 == name).ok_or_else(|| {
            let allowed: Vec<&str> = PLATFORMS.iter().map(|row| row.0).collect();
            format!("platform '{name}' is unknown; allowed: {}", allowed.join(", "))
        })
    }

    /// Folder below `binaries/` for a version of FMI: FMI 3.0 uses platform tuples only.
    pub fn folder_of(self, version: Version) -> &'static str {
        match (version, self.folder) {
            (Version::Fmi3, "linux64") => "x86_64-linux",
            (Version::Fmi3, "linux32") => "x86-linux",
            (Version::Fmi3, "win64") => "x86_64-windows",
            (Version::Fmi3, "win32") => "x86-windows",
            (Version::Fmi3, "darwin64") => "x86_64-darwin",
            (Version::Fmi3, "darwin32") => "x86-darwin",
            (_, folder) => folder,
        }
    }

    fn find(matches: impl Fn(&(&str, &str, BinaryFormat, Architecture)) -> bool) -> Option<Self> {
        let row = PLATFORMS.iter().find(|row| matches(row))?;
        Some(Self { folder: row.0, extension: row.1 })
    }
}

/// Shared library of this package that has been checked, with its platform.
#[derive(Debug, Clone)]
pub struct Library {
    /// Path of the file.
    pub path: PathBuf,
    /// Platform, which determines the folder.
    pub platform: Platform,
    /// Contents of the file.
    pub bytes: Vec<u8>,
}

impl Library {
    /// Reads a library and determines its platform from its header rather than its name; a macOS library for several architectures
    /// gives one entry for each.
    ///
    /// With `wanted`, the library must support this platform and is used for it only.
    pub fn read(path: &Path, wanted: Option<Platform>) -> Result<Vec<Self>, PackageError> {
        let bytes = std::fs::read(path).map_err(|source| PackageError::Library { path: path.to_owned(), source })?;
        let refuse = |cause| PackageError::NotALibrary { path: path.to_owned(), cause };
        let mut platforms = platforms(&bytes).map_err(refuse)?;
        if let Some(wanted) = wanted {
            if !platforms.contains(&wanted) {
                let found: Vec<&str> = platforms.iter().map(|platform| platform.folder).collect();
                return Err(refuse(format!("the library is for {}, not for {wanted}", found.join(" and "))));
            }
            platforms = vec![wanted];
        }
        let library = |platform| Self { path: path.to_owned(), platform, bytes: bytes.clone() };
        Ok(platforms.into_iter().map(library).collect())
    }
}

/// Platforms of a library; each image is checked to export all functions required of an FMU.
fn platforms(bytes: &[u8]) -> Result<Vec<Platform>, String> {
    let mut platforms = Vec::new();
    for image in images(bytes)? {
        let file = object::File::parse(image).map_err(|error| format!("not a shared library: {error}"))?;
        platforms.push(platform(&file)?);
        complete(&file)?;
    }
    Ok(platforms)
}

/// Images in a file: one, except in macOS libraries for several architectures.
fn images(bytes: &[u8]) -> Result<Vec<&[u8]>, String> {
    fn parts<'data, Fat: FatArch>(arches: &[Fat], bytes: &'data [u8]) -> object::read::Result<Vec<&'data [u8]>> {
        arches.iter().map(|arch| arch.data(bytes)).collect()
    }
    let images = match FileKind::parse(bytes) {
        Ok(FileKind::MachOFat32) => MachOFatFile32::parse(bytes).and_then(|fat| parts(fat.arches(), bytes)),
        Ok(FileKind::MachOFat64) => MachOFatFile64::parse(bytes).and_then(|fat| parts(fat.arches(), bytes)),
        Ok(_) => Ok(vec![bytes]),
        Err(_) => return Err("not a shared library (ELF, PE or Mach-O)".to_owned()),
    };
    match images {
        Ok(images) if images.is_empty() => Err("the macOS library contains no architecture".to_owned()),
        images => images.map_err(|error| format!("a damaged macOS library for several architectures: {error}")),
    }
}

/// Platform of one image.
fn platform(file: &object::File) -> Result<Platform, String> {
    let (format, architecture) = (file.format(), file.architecture());
    if file.kind() != ObjectKind::Dynamic {
        return Err(format!("not a shared library, but {format:?} of another kind ({:?})", file.kind()));
    }
    Platform::find(|row| (row.2, row.3) == (format, architecture)).ok_or_else(|| {
        let known = PLATFORMS.iter().map(|row| format!("{:?} {:?}", row.2, row.3));
        format!(
            "{format:?} libraries for {architecture:?} are not supported in an FMU; supported: {}",
            known.collect::<Vec<_>>().join(", ")
        )
    })
}

/// Checks that an image exports all functions of the standard.
fn complete(file: &object::File) -> Result<(), String> {
    let exports: object::read::Result<Vec<_>> = file.exports().and_then(Iterator::collect);
    let exports = exports.map_err(|error| format!("not a Foldwing library: its export table is damaged: {error}"))?;
    let prefix: &[u8] = if file.format() == BinaryFormat::MachO { b"_" } else { b"" }; // prefix of C names on macOS
    let names: Vec<&[u8]> = exports
        .iter()
        .filter_map(|export| match export.name() {
            NameOrOrdinal::Name(name) => name.strip_prefix(prefix),
            NameOrOrdinal::Ordinal(_) => None,
        })
        .collect();
    let missing: Vec<&str> = functions().filter(|function| !names.contains(&function.as_bytes())).collect();
    match missing.as_slice() {
        [] => Ok(()),
        [one] => Err(format!("not a Foldwing library: it does not export {one}")),
        [first, rest @ ..] => {
            Err(format!("not a Foldwing library: it does not export {first} and {} more functions", rest.len()))
        }
    }
}

/// Functions of both FMI versions.
fn functions() -> impl Iterator<Item = &'static str> {
    fmi2::FUNCTIONS.iter().chain(fmi3::FUNCTIONS).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beginning of an ELF shared library for a processor.
    fn elf(class: u8, machine: u8) -> Vec<u8> {
        let mut bytes = b"\x7fELF".to_vec();
        bytes.extend([class, 1, 1]);
        bytes.resize(16, 0);
        bytes.extend([3, 0, machine, 0, 1, 0, 0, 0]);
        bytes.resize(64, 0);
        bytes
    }

    /// Beginning of a PE file for a processor; the bit 0x2000 of `characteristics` marks a DLL.
    fn pe(machine: u16, magic: u16, characteristics: u16) -> Vec<u8> {
        let mut bytes = b"MZ".to_vec();
        bytes.resize(0x3c, 0);
        bytes.extend(0x40_u32.to_le_bytes());
        bytes.extend(b"PE\0\0");
        bytes.extend(machine.to_le_bytes());
        bytes.resize(0x40 + 20, 0); // no sections, no symbols
        let optional: u16 = if magic == 0x20b { 112 } else { 96 };
        bytes.extend(optional.to_le_bytes());
        bytes.extend(characteristics.to_le_bytes());
        bytes.extend(magic.to_le_bytes());
        bytes.resize(0x40 + 24 + usize::from(optional), 0);
        bytes
    }

    /// Mach-O image without contents; file type 6 is a shared library, 2 an executable.
    fn macho(cpu: u32, file_type: u32) -> Vec<u8> {
        let words = [0xfeed_facf_u32, cpu, 3, file_type, 0, 0, 0, 0];
        words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// Several Mach-O images in one file.
    fn fat(images: &[(u32, Vec<u8>)]) -> Vec<u8> {
        let (mut bytes, mut offset) = (Vec::new(), 4096_u32);
        let mut put = |word: u32| bytes.extend(word.to_be_bytes());
        put(0xcafe_babe);
        put(u32::try_from(images.len()).unwrap());
        for (cpu, image) in images {
            let size = u32::try_from(image.len()).unwrap();
            [*cpu, 3, offset, size, 12].into_iter().for_each(&mut put);
            offset += 4096;
        }
        for (i, (_, image)) in images.iter().enumerate() {
            bytes.resize(4096 * (i + 1), 0);
            bytes.extend(image);
        }
        bytes
    }

    const X86_64: u32 = 0x0100_0007;
    const ARM64: u32 = 0x0100_000c;

    fn folder(bytes: &[u8]) -> Result<&'static str, String> {
        platform(&object::File::parse(bytes).expect("a file that can be read")).map(|platform| platform.folder)
    }

    /// The folder is determined by format and architecture in the library's header, and has the name defined in FMI 2.0.4.
    #[test]
    fn platform_is_read_from_the_library() {
        assert_eq!(folder(&elf(2, 0x3e)).unwrap(), "linux64");
        assert_eq!(folder(&elf(1, 3)).unwrap(), "linux32");
        assert_eq!(folder(&elf(2, 0xb7)).unwrap(), "aarch64-linux");
        assert_eq!(folder(&pe(0x8664, 0x20b, 0x2000)).unwrap(), "win64");
        assert_eq!(folder(&pe(0x14c, 0x10b, 0x2000)).unwrap(), "win32");
        assert_eq!(folder(&pe(0xaa64, 0x20b, 0x2000)).unwrap(), "aarch64-windows");
        assert_eq!(folder(&macho(X86_64, 6)).unwrap(), "darwin64");
        assert_eq!(folder(&macho(ARM64, 6)).unwrap(), "aarch64-darwin");
    }

    /// A file that no platform of the standard can load is an error that states its type.
    #[test]
    fn other_files_are_refused_with_what_they_are() {
        let sparc = folder(&elf(2, 0x2b)).unwrap_err();
        assert!(sparc.contains("Elf libraries for Sparc64") && sparc.contains("Elf X86_64, "), "{sparc}");
        for executable in [pe(0x8664, 0x20b, 0), macho(X86_64, 2)] {
            let error = folder(&executable).unwrap_err();
            assert!(error.contains("not a shared library") && error.contains("Executable"), "{error}");
        }
        assert!(platforms(b"#!/bin/sh, a script").unwrap_err().contains("not a shared library (ELF, PE or Mach-O)"));
        assert!(platforms(b"").unwrap_err().contains("not a shared library (ELF, PE or Mach-O)"));
        assert!(platforms(b"MZ, but nothing behind it").unwrap_err().contains("not a shared library"));
    }

    /// A shared library without the functions of the standard is not a Foldwing library.
    #[test]
    fn libraries_without_the_functions_are_refused() {
        let error = platforms(&pe(0x8664, 0x20b, 0x2000)).unwrap_err();
        let rest = format!("does not export fmi2GetTypesPlatform and {} more functions", functions().count() - 1);
        assert!(error.contains(&rest), "{error}");
    }

    /// A macOS library for two architectures is split into both; one without an architecture, or a truncated one, is an error.
    #[test]
    fn macos_libraries_for_several_processors_serve_each() {
        let both = fat(&[(X86_64, macho(X86_64, 6)), (ARM64, macho(ARM64, 6))]);
        let found: Vec<_> = images(&both).unwrap().into_iter().map(|image| folder(image).unwrap()).collect();
        assert_eq!(found, ["darwin64", "aarch64-darwin"]);
        assert!(images(&both[..5000]).unwrap_err().contains("damaged macOS library"));
        let none = [fat(&[]), vec![0; 16]].concat();
        assert!(images(&none).unwrap_err().contains("no architecture"));
    }

    /// The error for an unknown platform lists the names.
    #[test]
    fn platforms_have_the_names_of_the_standard() {
        assert_eq!(Platform::named("win64").unwrap(), Platform { folder: "win64", extension: "dll" });
        let error = Platform::named("windows64").unwrap_err();
        assert!(error.contains("'windows64' is unknown") && error.contains("linux64, linux32"), "{error}");
    }
}

//! Marks by which results of Foldwing are recognised before they are overwritten.

use crate::report::film::{Gif, Mp4};
use std::fs::File;
use std::io::Read;
use std::path::Path;
use zip::ZipArchive;

/// Number of bytes at the beginning of a file that contain its mark.
const HEAD: u64 = 4096;

/// As [`HEAD`], for a member of an archive: the model description precedes the mark.
const MEMBER_HEAD: u64 = 1 << 16;

/// Mark of a type of result, found in its content, not its name.
#[derive(Clone)]
pub enum Mark {
    /// Never recognised, because users edit such files.
    Never,
    /// A table, recognised by its first line, which equals the one to be written.
    Table(Vec<u8>),
    /// Recognised by its first bytes and a text near the beginning.
    Head {
        /// Name of the type, for messages.
        name: &'static str,
        /// The first bytes.
        begins: &'static [u8],
        /// Text near the beginning.
        has: &'static [u8],
    },
    /// A zip archive, recognised by the names of its members and a text in the first of them.
    Archive {
        /// Name of the type, for messages.
        name: &'static str,
        /// Required members.
        members: &'static [&'static str],
        /// Text in the first member.
        has: &'static [u8],
    },
}

const fn head(name: &'static str, begins: &'static [u8], has: &'static [u8]) -> Mark {
    Mark::Head { name, begins, has }
}

impl Mark {
    /// An FMU written by Foldwing.
    pub const FMU: Self = Self::Archive {
        name: "an FMU of foldwing",
        members: &["modelDescription.xml", "resources/model.toml"],
        has: b"generationTool=\"foldwing ",
    };
    /// A system of one FMU.
    pub const SSP: Self = Self::Archive {
        name: "an SSP of foldwing",
        members: &["SystemStructure.ssd", "resources/model.fmu"],
        has: b"generationTool=\"foldwing ",
    };
    /// A linear model for NumPy.
    pub const NPZ: Self = Self::Archive {
        name: "a linear model of foldwing",
        members: &["A.npy", "B.npy", "C.npy", "D.npy", "x0.npy", "u0.npy", "y0.npy", "state_names.npy"],
        has: b"\x93NUMPY",
    };
    /// A linear model for MATLAB.
    pub const MAT: Self =
        head("a linear model of foldwing", b"MATLAB 5.0 MAT-file, a linear model written by foldwing", b"");
    /// A linear model as JSON.
    pub const LINEAR_JSON: Self =
        head("a linear model of foldwing", b"{\n  \"written_by\": \"foldwing linearize\"", b"");
    /// Computing costs of a run.
    pub const TIMING: Self = head("costs of a run", b"{\n  \"simulated_s\": ", b"\"factorizations\": ");
    /// Vortex lattices.
    pub const LATTICE: Self = head("lattices of a run", b"[{\"time_s\":", b",\"surfaces\":[");
    /// HTML page with an animation.
    pub const PAGE: Self =
        head("a page of foldwing", b"<!doctype html>", b"<meta name=\"generator\" content=\"foldwing\">");
    /// A figure or drawing as SVG.
    pub const SVG: Self = head("a picture of foldwing", b"<", b"<!-- drawn by foldwing -->");
    /// A figure as PNG.
    pub const PNG: Self = head("a picture of foldwing", b"\x89PNG\r\n\x1a\n", b"tEXtSoftware\0foldwing");
    /// A figure as PDF.
    pub const PDF: Self = head("a picture of foldwing", b"%PDF-1.", b"/Producer (foldwing)");
    /// A video as MP4.
    pub const MP4: Self = head("a video of foldwing", Mp4::BEGINS, Mp4::MARK);
    /// A video as GIF.
    pub const GIF: Self = head("a video of foldwing", Gif::BEGINS, Gif::MARK);
    /// A file for ParaView.
    pub const VTK: Self = head("a VTK file of foldwing", b"<?xml version=\"1.0\"?>\n<!-- written by foldwing -->", b"");
    /// The schema of model files.
    pub const SCHEMA: Self = head("the schema of foldwing", b"{", b"\"Model name; names the FMU.\"");

    /// Mark of a table with this header.
    pub fn table<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(names).expect("writing to memory does not fail");
        Self::Table(writer.into_inner().expect("writing to memory does not fail"))
    }

    /// Mark of a file with this first line.
    pub fn first_line(text: &[u8]) -> Self {
        Self::Table(text.split_inclusive(|byte| *byte == b'\n').next().unwrap_or_default().to_vec())
    }

    /// Name of the type, for messages.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Never => "a result",
            Self::Table(_) => "a table with the columns that are to be written",
            Self::Head { name, .. } | Self::Archive { name, .. } => name,
        }
    }

    /// Returns whether a file has the mark. An empty file has every mark; an unreadable one has none.
    pub fn is_on(&self, file: &Path) -> bool {
        let Ok(mut opened) = File::open(file) else { return false };
        if !matches!(self, Self::Never) && opened.metadata().is_ok_and(|found| found.len() == 0) {
            return true;
        }
        match self {
            Self::Never => false,
            Self::Table(line) => {
                let mut begin = vec![0; line.len()];
                opened.read_exact(&mut begin).is_ok() && begin == *line
            }
            Self::Head { begins, has, .. } => {
                let mut head = Vec::new();
                opened.take(HEAD).read_to_end(&mut head).is_ok() && head.starts_with(begins) && contains(&head, has)
            }
            Self::Archive { members, has, .. } => is_archive(opened, members, has),
        }
    }
}

fn is_archive(file: File, members: &[&str], has: &[u8]) -> bool {
    let Ok(mut archive) = ZipArchive::new(file) else { return false };
    if !members.iter().all(|name| archive.by_name(name).is_ok()) {
        return false;
    }
    let mut head = Vec::new();
    archive.by_name(members[0]).is_ok_and(|member| member.take(MEMBER_HEAD).read_to_end(&mut head).is_ok())
        && contains(&head, has)
}

fn contains(bytes: &[u8], part: &[u8]) -> bool {
    part.is_empty() || bytes.windows(part.len()).any(|window| window == part)
}

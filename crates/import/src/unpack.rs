//! Unpacking of a possibly malicious archive: no file is written outside the folder, and the size is limited.

use crate::error::{ImportError, of_archive};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;
use zip::ZipArchive;
use zip::read::ZipFile;

/// Maximum unpacked size in bytes below which the ratio is not checked.
const MAXIMUM_BYTES: u64 = 1 << 30;
/// Maximum ratio of unpacked to packed size above [`MAXIMUM_BYTES`]: a large FMU may unpack to more, but a small one that does
/// is an attack.
const MAXIMUM_RATIO: u64 = 20;
/// Maximum number of members of an FMU.
const MAXIMUM_MEMBERS: usize = 100_000;

/// Unpacks all members into a folder.
///
/// # Errors
/// A member whose path leaves the folder or that is a link, more than the limits allow, or a failed write.
pub(super) fn unpack(fmu: &Path, archive: &mut ZipArchive<File>, folder: &Path) -> Result<(), ImportError> {
    let failed = |source: io::Error| ImportError::File { path: fmu.to_owned(), source };
    let refused = |cause: String| ImportError::NotAnFmu { path: fmu.to_owned(), cause };
    let packed = fs::metadata(fmu).map_err(failed)?.len();
    let most = MAXIMUM_BYTES.max(packed.saturating_mul(MAXIMUM_RATIO));
    if archive.len() > MAXIMUM_MEMBERS {
        return Err(refused(format!("{} members; at most {MAXIMUM_MEMBERS} are unpacked", archive.len())));
    }
    let mut left = most;
    for index in 0..archive.len() {
        let mut member = archive.by_index(index).map_err(|error| of_archive(fmu, error))?;
        let target = folder.join(inside(&member).map_err(refused)?);
        if member.is_dir() {
            fs::create_dir_all(&target).map_err(failed)?;
            continue;
        }
        fs::create_dir_all(target.parent().unwrap_or(folder)).map_err(failed)?;
        let mut file = File::create(&target).map_err(failed)?;
        // the size stated in the archive may be wrong
        let written = io::copy(&mut member.by_ref().take(left + 1), &mut file).map_err(failed)?;
        if written > left {
            return Err(refused(format!("more than {most} bytes unpacked, from {packed}; unpacking stopped")));
        }
        left -= written;
    }
    Ok(())
}

/// Path of a member below the folder.
fn inside<R: Read>(member: &ZipFile<'_, R>) -> Result<std::path::PathBuf, String> {
    let name = member.name().map_err(|error| error.to_string())?;
    let leaves = name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..");
    if leaves || member.is_symlink() {
        let what = if leaves { "leaves the folder of the FMU" } else { "is a link" };
        return Err(format!("the member {:?} {what}; nothing of it is run", shown(&name)));
    }
    member.enclosed_name().ok_or_else(|| format!("the member {:?} has no usable path", shown(&name)))
}

/// Beginning of a member name, for messages.
fn shown(name: &str) -> String {
    name.chars().take(60).collect()
}

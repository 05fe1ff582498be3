//! Stamps the git commit (where there is one) and the target into the command, and puts the examples into it. No date: builds are
//! reproducible.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder with files of the repository that the command contains: links, which `cargo package` replaces by the files.
const SHIPPED: &str = "shipped/examples";
/// Endings of examples. Notebooks with their pictures would be four fifths of the size.
const ENDINGS: [&str; 6] = ["toml", "csv", "py", "md", "rs", "diff"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=FOLDWING_TARGET={}", std::env::var("TARGET").expect("cargo sets TARGET"));
    let commit = git(&["rev-parse", "--short=10", "HEAD"]).unwrap_or_default();
    println!("cargo::rustc-env=FOLDWING_COMMIT={commit}");

    // The log of HEAD grows with every commit and checkout; a file that does not exist would rebuild every time.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
    examples();
}

/// Writes `examples.rs`: a table of the examples, names below their folder and contents, in the order of the names.
fn examples() {
    let own = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let link = own.join(SHIPPED);
    // a checkout without links (Windows) has a file with the path instead
    let folder = match fs::read_to_string(&link) {
        Ok(path) => link.with_file_name("").join(path.trim()),
        Err(_) => link,
    };
    let mut files = Vec::new();
    collect(&folder, &mut files);
    files.sort();
    assert!(files.len() > 30, "{}: the examples are missing", folder.display());
    let mut table = String::from("&[\n");
    for file in &files {
        let name: Vec<_> =
            file.strip_prefix(&folder).expect("it is below").iter().map(|part| part.to_string_lossy()).collect();
        println!("cargo::rerun-if-changed={}", file.display());
        writeln!(table, "    ({:?}, include_str!({:?})),", name.join("/"), file.display().to_string())
            .expect("a text grows");
    }
    table.push_str("]\n");
    let target = PathBuf::from(std::env::var("OUT_DIR").expect("cargo sets OUT_DIR")).join("examples.rs");
    fs::write(target, table).expect("OUT_DIR is writable");
}

/// Files of the known endings below a folder, and the folders to watch.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    println!("cargo::rerun-if-changed={}", folder.display()); // a new file
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("readable").path();
        let ending = path.extension().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && path.file_name().is_none_or(|name| name != "__pycache__" && name != ".ipynb_checkpoints") {
            collect(&path, files);
        } else if path.is_file() && ENDINGS.contains(&ending.as_str()) {
            files.push(path);
        }
    }
}

/// Output of a git command run on Foldwing's own repository, two folders above `crates/command`; `None` without git or
/// outside a repository.
fn git(arguments: &[&str]) -> Option<String> {
    let run = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let root = run(&["rev-parse", "--show-toplevel"])?;
    let own = Path::new(&std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR")).join("../..");
    let same = Path::new(&root).canonicalize().ok()? == own.canonicalize().ok()?;
    if same { run(arguments) } else { None } // unpacked inside someone else's repository
}

//! Embeds the git commit (in a repository), the target and the examples in the command. No date is embedded, so that builds are
//! reproducible.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder of the repository files that the command embeds: symbolic links, which `cargo package` replaces by the files.
const SHIPPED: &str = "shipped/examples";
/// File extensions of the examples. Notebooks with their pictures would be four fifths of the size and are left out.
const ENDINGS: [&str; 6] = ["toml", "csv", "py", "md", "rs", "diff"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-env=FOLDWING_TARGET={}", std::env::var("TARGET").expect("cargo sets TARGET"));
    let commit = git(&["rev-parse", "--short=10", "HEAD"]).unwrap_or_default();
    println!("cargo::rustc-env=FOLDWING_COMMIT={commit}");

    // Watch the log of HEAD, which grows with every commit and checkout; watching a file that does not exist would rebuild every
    // time.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
    examples();
}

/// Writes `examples.rs`: a table of the examples, each with its path below the folder and its contents, sorted by path.
fn examples() {
    let own = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let link = own.join(SHIPPED);
    // in a checkout without symbolic links (Windows), the link is a file that contains the path
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

/// Collects the files with these extensions below a folder, and tells Cargo to watch the folders.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    println!("cargo::rerun-if-changed={}", folder.display()); // reruns when a file is added
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

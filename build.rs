//! Stamps the git commit (where there is one) and the target into the binaries. No date: builds are reproducible.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=../../build.rs");
    println!("cargo::rustc-env=FOLDWING_TARGET={}", std::env::var("TARGET").expect("cargo sets TARGET"));
    let commit = git(&["rev-parse", "--short=10", "HEAD"]).unwrap_or_default();
    println!("cargo::rustc-env=FOLDWING_COMMIT={commit}");

    // The log of HEAD grows with every commit and checkout; a file that does not exist would rebuild every time.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
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

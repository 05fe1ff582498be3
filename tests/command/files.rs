//! Files of a user are safe: input files of a command are never overwritten, nor files of other origin, and an interruption or a full disk
//! leaves existing files unchanged. `docs/decisions/0006-files-of-the-user.md`.

use crate::library;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const INPUTS: &str = "time,fold.angle_command\n0,0\n0.4,0.1\n";
const FOREIGN: &[u8] = b"three weeks of measurements\n";

/// A folder with a model, its inputs, and a file of measurements.
struct Bench {
    folder: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models");
        for (shipped, name) in [("folding_wing_in_tunnel.toml", "wing.toml"), ("folding_wing.toml", "still.toml")] {
            std::fs::copy(models.join(shipped), folder.path().join(name)).unwrap();
        }
        std::fs::write(folder.path().join("in.csv"), INPUTS).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_foldwing"));
        command.args(arguments).current_dir(self.folder.path()).stdin(Stdio::null());
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the command runs")
    }

    /// Names in the folder.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// Arguments of a command up to its output option, and a file name that the output may have.
type Case = (&'static [&'static str], &'static str);

/// Every option that names one file to write, of every command.
const CASES: &[Case] = &[
    (&["simulate", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "-q", "--csv"], "x.csv"),
    (&["simulate", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "-q", "--view"], "x.html"),
    (&["simulate", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "-q", "--strains"], "x.csv"),
    (&["simulate", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "-q", "--profile"], "x.json"),
    (
        &["simulate", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "-q", "--lattice-at", "0", "--lattice"],
        "x.json",
    ),
    (&["package", "still.toml", "--no-reference", "--library", "library.so", "-o"], "x.fmu"),
    (&["check", "wing.toml", "--draw"], "x.svg"),
    (&["modes", "still.toml", "--count", "2", "--view"], "x.html"),
    (&["render", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "--size", "64x64", "-q", "--video"], "x.mp4"),
    (&["render", "wing.toml", "--inputs", "in.csv", "--stop", "1e-3", "--size", "64x64", "-q", "--video"], "x.gif"),
    (
        &[
            "linearize",
            "wing.toml",
            "--state",
            "start",
            "--inputs",
            "fold.external_torque",
            "--outputs",
            "fold.angle",
            "-o",
        ],
        "x.npz",
    ),
    (
        &[
            "linearize",
            "wing.toml",
            "--state",
            "start",
            "--inputs",
            "fold.external_torque",
            "--outputs",
            "fold.angle",
            "-o",
        ],
        "x.mat",
    ),
    (
        &[
            "linearize",
            "wing.toml",
            "--state",
            "start",
            "--inputs",
            "fold.external_torque",
            "--outputs",
            "fold.angle",
            "-o",
        ],
        "x.json",
    ),
    (
        &[
            "sweep",
            "wing.toml",
            "--inputs",
            "in.csv",
            "--stop",
            "1e-3",
            "-q",
            "--vary",
            "fold.external_torque=0,1",
            "--output",
        ],
        "x.csv",
    ),
];

/// The model, its inputs and the library, by their names, by other paths and by links: rejected, with or without `--force`, and unchanged.
/// `simulate wing.toml --csv wing.toml` used to end with exit code 0 and a model that was a table.
#[test]
fn no_command_overwrites_what_it_reads() {
    let bench = Bench::new();
    std::fs::copy(library(), bench.path("library.so")).unwrap();
    std::fs::create_dir(bench.path("sub")).unwrap();
    let read = ["wing.toml", "still.toml", "in.csv", "library.so"];
    let before = read.map(|name| bench.read(name));
    for (command, output) in CASES {
        for source in read.into_iter().filter(|name| command.contains(name)) {
            let link = format!("link-{output}");
            let (hard, soft) = (format!("hard-{link}"), format!("soft-{link}"));
            for name in [&hard, &soft] {
                let _ = std::fs::remove_file(bench.path(name));
            }
            std::fs::hard_link(bench.path(source), bench.path(&hard)).unwrap();
            #[cfg(unix)]
            std::os::unix::fs::symlink(source, bench.path(&soft)).unwrap();
            let detour = format!("sub/../{source}");
            for path in [source, detour.as_str(), hard.as_str(), soft.as_str()] {
                for force in [false, true] {
                    let force = force && !command.contains(&"sweep");
                    let mut arguments = [*command, &[path][..]].concat();
                    if force {
                        arguments.push("--force");
                    }
                    let refused = bench.run(&arguments);
                    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
                    assert!(matches!(refused.status.code(), Some(2 | 4)), "{arguments:?}: {message}");
                    let named = path == hard || path == soft;
                    assert!(!force || !named || message.contains("refusing to overwrite"), "{arguments:?}: {message}");
                    assert_eq!(read.map(|name| bench.read(name)), before, "{arguments:?}");
                }
            }
        }
    }
}

/// A file of other origin is kept unless `--force` is given; one written by the same kind of command is replaced without it; missing
/// folders are created.
#[test]
fn only_results_of_the_same_kind_are_replaced() {
    let bench = Bench::new();
    std::fs::copy(library(), bench.path("library.so")).unwrap();
    for (number, (command, output)) in CASES.iter().enumerate() {
        let output = format!("made/{number}/{output}");
        let arguments = [*command, &[output.as_str()][..]].concat();
        let forced = [&arguments[..], &["--force"]].concat();
        let succeeds = |arguments: &[&str]| {
            let run = bench.run(arguments);
            assert!(run.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
        };
        succeeds(&arguments);
        let first = bench.read(&output);
        succeeds(&arguments); // a result of the same command
        std::fs::write(bench.path(&output), FOREIGN).unwrap();
        let refused = bench.run(&arguments);
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert_eq!(refused.status.code(), Some(4), "{arguments:?}: {message}");
        assert!(message.contains("exists and is not recognised as") && message.contains(&output), "{message}");
        assert_eq!(bench.read(&output), FOREIGN, "{arguments:?}");
        if !command.contains(&"sweep") {
            succeeds(&forced);
            assert_eq!(bench.read(&output).len() / 100, first.len() / 100, "{arguments:?}");
        }
        let left = std::fs::read_dir(bench.path(&format!("made/{number}"))).unwrap().count();
        assert_eq!(left, if command.contains(&"sweep") { 2 } else { 1 }, "nothing else is left behind");
    }
}

/// The same inside the folders of `--plot`, `--vtk` and `--cross-check`: rejected before the run, with the file name.
#[test]
fn folders_of_results_are_looked_into() {
    let bench = Bench::new();
    std::fs::copy(library(), bench.path("library.so")).unwrap();
    let cases: [(&[&str], &str); 4] = [
        (&["simulate", "wing.toml", "--stop", "1e-3", "-q", "--plot", "f"], "f/fold_angles.svg"),
        (
            &["simulate", "wing.toml", "--stop", "1e-3", "-q", "--plot", "p", "--plot-format", "pdf"],
            "p/fold_angles.pdf",
        ),
        (&["simulate", "wing.toml", "--stop", "1e-3", "-q", "--vtk", "v"], "v/wing_0000.vtu"),
        (
            &["package", "still.toml", "--library", "library.so", "-o", "x.fmu", "--cross-check", "c"],
            concat!("c/fmus/2.0/cs/linux64/Foldwing/", env!("CARGO_PKG_VERSION"), "/x/x_ref.csv"),
        ),
    ];
    for (arguments, file) in cases {
        for _ in 0..2 {
            let run = bench.run(arguments);
            assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        }
        std::fs::write(bench.path(file), FOREIGN).unwrap();
        let refused = bench.run(arguments);
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(4) && message.contains(file), "{message}");
        assert_eq!(bench.read(file), FOREIGN);
    }
}

/// A table of only the inputs of a model could be the user's own: it is not recognised as a result.
#[test]
fn tables_of_inputs_are_not_results() {
    let bench = Bench::new();
    let run = ["simulate", "wing.toml", "--stop", "1e-3", "-q", "--variables", "fold.angle_command", "--csv", "in.csv"];
    assert_eq!(bench.run(&run).status.code(), Some(4));
    assert_eq!(bench.read("in.csv"), INPUTS.as_bytes());
    let twice = bench.run(&["simulate", "wing.toml", "--stop", "1e-3", "--csv", "x.csv", "--profile", "./x.csv"]);
    assert!(twice.status.code() == Some(2) && String::from_utf8_lossy(&twice.stderr).contains("two results"));
    assert!(!bench.path("x.csv").exists());
    let bare = bench.run(&["package", "wing.toml", "-o", "Wing"]);
    assert!(bare.status.code() == Some(2) && String::from_utf8_lossy(&bare.stderr).contains("write Wing.fmu"));
    assert!(!bench.path("Wing").exists());
}

/// A file size limit represents a full disk: exit code 4, unchanged old results, no other file. `/dev/full` does the same for a stream.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_leaves_the_old_results() {
    let bench = Bench::new();
    let run = "simulate wing.toml --stop 0.02 -q --csv x.csv";
    assert!(bench.run(&run.split(' ').collect::<Vec<_>>()).status.success());
    let before = bench.read("x.csv");
    let limited = Command::new("sh")
        .args(["-c", &format!("ulimit -f 8; exec {} {run}", env!("CARGO_BIN_EXE_foldwing"))])
        .current_dir(bench.folder.path())
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&limited.stderr).into_owned();
    assert_eq!(limited.status.code(), Some(4), "{message}");
    assert!(message.contains("x.csv: cannot be written"), "{message}");
    assert_eq!(bench.read("x.csv"), before);
    assert_eq!(bench.names(), ["in.csv", "still.toml", "wing.toml", "x.csv"]);
    let full = bench.run(&["simulate", "wing.toml", "--stop", "0.02", "-q", "--csv", "/dev/full"]);
    assert!(full.status.code() == Some(4), "{}", String::from_utf8_lossy(&full.stderr));
}

/// A command that can be interrupted however the tests were started: `nohup make test &` ignores SIGINT, and child processes inherit this.
#[cfg(unix)]
fn interruptible(command: &mut Command) -> &mut Command {
    use std::os::unix::process::CommandExt;
    const SIGINT: i32 = 2;
    const DEFAULT: usize = 0;
    unsafe extern "C" {
        fn signal(number: i32, handler: usize) -> usize;
    }
    let restore = || {
        // SAFETY: allowed between fork and exec, touches no memory
        unsafe { signal(SIGINT, DEFAULT) };
        Ok(())
    };
    // SAFETY: as above
    unsafe { command.pre_exec(restore) }
}

/// Ctrl-C and `kill -9` in the middle of a run leave the old results unchanged. Ctrl-C leaves no other files next to them.
#[test]
#[cfg(unix)]
fn an_interruption_leaves_the_old_results() {
    use std::os::unix::process::ExitStatusExt;
    let bench = Bench::new();
    assert!(bench.run(&["simulate", "wing.toml", "--stop", "1e-2", "-q", "--csv", "x.csv"]).status.success());
    let before = bench.read("x.csv");
    for (signal, number) in [("-INT", 2), ("-KILL", 9)] {
        let mut run =
            bench.command(&["simulate", "wing.toml", "--stop", "1000", "--step", "1e-3", "-q", "--csv", "x.csv"]);
        let mut child = interruptible(&mut run).spawn().unwrap();
        let unfinished = || {
            let entries = std::fs::read_dir(bench.folder.path()).unwrap().flatten();
            entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(".foldwing-")).collect::<Vec<_>>()
        };
        while !unfinished().iter().any(|file| file.metadata().is_ok_and(|found| found.len() > 0)) {
            assert!(child.try_wait().unwrap().is_none(), "ended before rows had reached the disk");
            std::thread::sleep(Duration::from_millis(10));
        }
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(child.wait().unwrap().signal(), Some(number));
        assert_eq!(bench.read("x.csv"), before, "{signal}");
        assert_eq!(unfinished().len(), usize::from(number == 9), "{signal}");
    }
}

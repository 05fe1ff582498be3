//! `foldwing sweep` in scripts: rows, errors, threads, and an interrupted run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn model(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/models").join(name);
    path.to_str().unwrap().to_owned()
}

fn foldwing() -> Command {
    Command::new(env!("CARGO_BIN_EXE_foldwing"))
}

/// `foldwing sweep` on the shipped wing.
fn sweep(out: &Path, arguments: &[&str]) -> Command {
    let mut command = foldwing();
    command.arg("sweep").arg(model("folding_wing.toml")).arg("--output").arg(out).args(arguments);
    command
}

#[track_caller]
fn succeeds(command: &mut Command) -> String {
    let output = command.output().expect("the command runs");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{stderr}");
    stderr
}

#[track_caller]
fn refuses(command: &mut Command, code: i32, messages: &[&str]) {
    let Output { status, stderr, .. } = command.output().expect("the command runs");
    let stderr = String::from_utf8_lossy(&stderr);
    assert_eq!(status.code(), Some(code), "{stderr}");
    for message in messages {
        assert!(stderr.contains(message), "`{message}` is not in\n{stderr}");
    }
    assert!(!stderr.contains("panicked"), "{stderr}");
}

/// Cells of a column, by its name.
#[track_caller]
fn column(csv: &str, name: &str) -> Vec<String> {
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let place = reader.headers().unwrap().iter().position(|header| header == name).expect(name);
    reader.records().map(|record| record.unwrap()[place].to_owned()).collect()
}

fn record_of(out: &Path) -> PathBuf {
    PathBuf::from(format!("{}.sweep", out.display()))
}

const SHORT: [&str; 4] = ["--stop", "0.2", "--step", "2e-3"];

/// K-01. A row of a sweep is bit-identical to the last row of `simulate` with the same settings: same binary, same calls. The peak is the
/// largest magnitude of the column, and the first latch time is its last value, because it latches once.
#[test]
fn k01_rows_are_the_ends_of_simulations() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results.csv");
    let vary = ["--vary", "fold.start_angle=1.5,2.5", "--vary", "fold.release=0,1", "--variables", "tip.position.z"];
    succeeds(&mut sweep(&out, &[&vary[..], &SHORT].concat()));
    let results = fs::read_to_string(&out).unwrap();
    assert_eq!(column(&results, "variant"), ["0", "1", "2", "3"]);
    assert_eq!(column(&results, "fold.start_angle"), ["1.5", "1.5", "2.5", "2.5"]);
    assert_eq!(column(&results, "fold.release"), ["0", "1", "0", "1"]);
    assert_eq!(column(&results, "status"), ["done"; 4]);
    assert_eq!(column(&results, "message"), [""; 4]);

    for index in 0..4 {
        let settings: Vec<String> = ["fold.start_angle", "fold.release"]
            .map(|key| format!("--set={key}={}", column(&results, key)[index]))
            .to_vec();
        let mut simulate = foldwing();
        simulate.args(["simulate", &model("folding_wing.toml"), "--csv", "-", "--quiet"]).args(SHORT).args(settings);
        let Output { stdout, status, .. } = simulate.output().unwrap();
        assert!(status.success());
        let single = String::from_utf8(stdout).unwrap();
        let last = |name: &str| column(&single, name).pop().unwrap();
        assert_eq!(column(&results, "tip.position.z")[index], last("tip.position.z"));
        assert_eq!(column(&results, "fold.first_latch_time")[index], last("fold.latch_time"));
        assert_eq!(column(&results, "end_time")[index], last("time"));
        let strains = column(&single, "gauge.root.strain").into_iter().map(|text| text.parse::<f64>().unwrap().abs());
        let peak: f64 = column(&results, "gauge.root.strain.peak")[index].parse().unwrap();
        assert_eq!(peak.to_bits(), strains.fold(0.0, f64::max).to_bits());
    }
    let latched = column(&results, "fold.first_latch_time");
    assert!(
        latched[0] == "-1.0" && latched[1] != "-1.0",
        "the held wing does not latch, the released does: {latched:?}"
    );
}

/// K-02. Keys of the model file are varied in the file: the row is bit-identical to that of a file that contains the value.
#[test]
fn k02_keys_of_the_file_equal_a_changed_file() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results.csv");
    let chosen = ["--variables", "tip.position.x"];
    let vary = ["--vary", "file:body.inner.elements=2:4:2", "--vary", "file:solver.method=esdirk3,tr_bdf2"];
    succeeds(&mut sweep(&out, &[&vary[..], &chosen, &SHORT].concat()));
    let results = fs::read_to_string(&out).unwrap();
    assert_eq!(column(&results, "file:body.inner.elements"), ["2", "2", "4", "4"]);
    let mut tips = column(&results, "tip.position.x");

    let text = fs::read_to_string(model("folding_wing.toml")).unwrap();
    let changed = text.replacen("elements = 4", "elements = 2", 1) + "\n[solver]\nmethod = \"tr_bdf2\"\n";
    let file = folder.path().join("changed.toml");
    fs::write(&file, changed).unwrap();
    let mut simulate = foldwing();
    simulate.args(["simulate", file.to_str().unwrap(), "--csv", "-", "--quiet"]).args(SHORT).args(chosen);
    let single = String::from_utf8(simulate.output().unwrap().stdout).unwrap();
    assert_eq!(tips[1], column(&single, "tip.position.x").pop().unwrap());
    tips.sort();
    tips.dedup();
    assert_eq!(tips.len(), 4, "each variant has its own result: {tips:?}");
}

/// K-03. The number of threads changes no byte: each variant is computed by one thread, and rows are sorted.
#[test]
fn k03_threads_change_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    let of = |threads: &str| {
        let out = folder.path().join(format!("{threads}.csv"));
        let vary = ["--vary", "fold.start_angle=0.5:2.9:9", "--variables", "tip.position.z", "--threads", threads];
        succeeds(&mut sweep(&out, &[&vary[..], &SHORT].concat()));
        fs::read_to_string(out).unwrap()
    };
    let one = of("1");
    assert_eq!(column(&one, "variant").len(), 9);
    for threads in ["2", "4"] {
        assert_eq!(one, of(threads), "{threads} threads");
    }
}

/// K-04. A sweep killed in the middle (SIGKILL: nothing is cleaned up) continues where it stopped: existing rows are not computed again, a
/// half-written row is, and the results have the same bytes as an uninterrupted run.
#[test]
fn k04_a_killed_sweep_goes_on() {
    const VARIANTS: usize = 60;
    let folder = tempfile::tempdir().unwrap();
    let (whole, killed) = (folder.path().join("whole.csv"), folder.path().join("killed.csv"));
    let vary = [
        "--vary",
        "fold.start_angle=0.5:2.9:60",
        "--variables",
        "tip.position.z",
        "--stop",
        "0.4",
        "--step",
        "1e-3",
        "--threads",
        "2",
    ];
    succeeds(&mut sweep(&whole, &vary));

    let mut running = sweep(&killed, &vary).stderr(Stdio::null()).spawn().unwrap();
    let record = record_of(&killed);
    let rows = || fs::read(&record).map_or(0, |bytes| bytes.iter().filter(|byte| **byte == b'\n').count().max(1) - 1);
    while rows() < 5 {
        assert!(running.try_wait().unwrap().is_none(), "ended before five rows were there");
        std::thread::sleep(Duration::from_millis(1));
    }
    running.kill().unwrap();
    running.wait().unwrap();
    assert!(!killed.exists(), "results appear when all rows are there");
    let survived = rows();
    assert!((5..VARIANTS).contains(&survived), "{survived} rows: the kill was to be in the middle");

    // a truncated line, as after a full disk or a crash
    let mut bytes = fs::read(&record).unwrap();
    let end = bytes.iter().rposition(|byte| *byte == b'\n').unwrap();
    bytes.truncate(end - 20);
    fs::write(&record, &bytes).unwrap();

    let summary = succeeds(&mut sweep(&killed, &vary));
    assert!(summary.contains(&format!("{} resumed)", survived - 1)), "{survived} survived: {summary}");
    assert_eq!(fs::read_to_string(&killed).unwrap(), fs::read_to_string(&whole).unwrap());
    assert_eq!(rows(), VARIANTS, "no variant has two rows");

    // starting a finished sweep again runs nothing, and gives the same output
    let again = succeeds(&mut sweep(&killed, &vary));
    assert!(again.contains("(0 failed, 60 resumed)"), "{again}");
    assert_eq!(fs::read_to_string(&killed).unwrap(), fs::read_to_string(&whole).unwrap());
}

/// K-05. A changed digit in a stored row is detected by its checksum: this row and those after it are computed again.
#[test]
fn k05_a_damaged_record_is_computed_again() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results.csv");
    let vary = ["--vary", "fold.start_angle=1:2:6", "--threads", "1", "--stop", "0.01"];
    succeeds(&mut sweep(&out, &vary));
    let results = fs::read_to_string(&out).unwrap();
    let damaged = fs::read_to_string(record_of(&out)).unwrap().replacen(" 3,1.6,done", " 3,1.7,done", 1);
    assert!(damaged.contains(" 3,1.7,done"), "{damaged}");
    fs::write(record_of(&out), damaged).unwrap();
    let summary = succeeds(&mut sweep(&out, &vary));
    assert!(summary.contains(" 3 resumed)"), "{summary}");
    assert_eq!(fs::read_to_string(&out).unwrap(), results);
}

/// K-06. A changed sweep is not combined with the rows of the old one: it is an error that lists the differences; results without a record
/// are not overwritten.
#[test]
fn k06_a_changed_sweep_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results.csv");
    let short = ["--stop", "0.01"];
    let with = |vary: &[&str]| sweep(&out, &[vary, &short[..]].concat());
    succeeds(&mut with(&["--vary", "fold.start_angle=1,2"]));
    let results = fs::read_to_string(&out).unwrap();
    refuses(
        &mut with(&["--vary", "fold.start_angle=1,2.5"]),
        2,
        &[
            "results.csv.sweep: belongs to another sweep, which differs in: values of the keys;",
            "name another --output",
        ],
    );
    refuses(&mut with(&["--vary", "fold.start_angle=1,2", "--step", "1e-3"]), 2, &["--start, --stop, --step"]);
    refuses(
        &mut with(&["--vary", "fold.start_angle=1,2", "--set", "fold.release=0"]),
        2,
        &["which differs in: --set;"],
    );
    assert_eq!(fs::read_to_string(&out).unwrap(), results, "a refusal touches nothing");
    fs::remove_file(record_of(&out)).unwrap();
    refuses(&mut with(&["--vary", "fold.start_angle=1,2"]), 2, &["results.csv: exists without the record"]);
    fs::write(record_of(&out), "something else\n").unwrap();
    refuses(&mut with(&["--vary", "fold.start_angle=1,2"]), 2, &["is not a record of a sweep"]);
    assert_eq!(fs::read_to_string(record_of(&out)).unwrap(), "something else\n");
}

/// K-07. Invalid options and tables are rejected before any run, with the key, the value and the allowed values.
#[test]
fn k07_slips_are_refused_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results.csv");
    let cases: &[(&[&str], &[&str])] = &[
        (&["--vary", "fold.start_angel=1,2"], &["--vary: ", "did you mean `fold.start_angle`", "begin with file:"]),
        (&["--vary", "fold.start_angle=1,x"], &["--vary fold.start_angle=x: `x` is not a number"]),
        (&["--vary", "fold.start_angle=1,99"], &["--vary fold.start_angle=99", "it must be from"]),
        (&["--vary", "fold.release=0,2"], &["`2` is not a Boolean; allowed are 0, 1, false and true"]),
        (&["--vary", "fold.angle=1,2"], &["fold.angle", "only inputs and parameters can"]),
        (&["--vary", "fold.start_angle"], &["must be KEY=FROM:TO:COUNT or KEY=A,B"]),
        (&["--vary", "fold.start_angle=1:2"], &["ranges are FROM:TO:COUNT"]),
        (&["--vary", "fold.start_angle=1:2:1"], &["allowed is 2 to 1000000"]),
        (
            &["--vary", "fold.start_angle=1:2:2000", "--vary", "fold.motor_stiffness=1:2:2000"],
            &["1000000 variants allowed"],
        ),
        (&["--vary", "fold.start_angle=1,2", "--vary", "fold.start_angle=1,2"], &["fold.start_angle is given twice"]),
        (&["--vary", "file:body.inner.lenght_m=1,2"], &["'body.inner.lenght_m' is unknown", "length_m"]),
        (&["--vary", "file:body.inner.elements=4,0"], &["file:body.inner.elements=0", "not allowed; allowed: "]),
        (&["--vary", "file:name.x=1"], &["--vary file:name.x=1: name is not a table"]),
        (&["--vary", "fold.start_angle=1,2", "--variables", "tip.q"], &["tip.q"]),
        (&["--vary", "fold.start_angle=1,2", "--variables", "fold.start_angle"], &["this column exists already"]),
        (&["--vary", "fold.start_angle=1,2", "--threads", "0"], &["--threads"]),
        (&[], &["--vary", "--samples"]),
    ];
    for (arguments, messages) in cases {
        refuses(&mut sweep(&out, arguments), 2, messages);
    }
    let samples = folder.path().join("samples.csv");
    let path = samples.to_str().unwrap();
    for (text, code, messages) in [
        ("fold.start_angle,fold.release\n1,1\n2\n", 1, &["samples.csv"][..]),
        ("fold.start_angle,fold.release\n1,\n", 1, &["samples.csv:2: column 2 (fold.release): must be a value"]),
        ("fold.start_angle\n", 1, &["no rows below the header"]),
        ("fold.start_angle\n1\nx\n", 2, &["samples.csv: variant 1: fold.start_angle=x: `x` is not a number"]),
        ("fold.q\n1\n", 2, &["samples.csv:1: "]),
    ] {
        fs::write(&samples, text).unwrap();
        refuses(&mut sweep(&out, &["--samples", path]), code, messages);
    }
    refuses(&mut sweep(&out, &["--samples", "no/such.csv"]), 4, &["no/such.csv"]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "only the samples: nothing was begun");
}

/// K-08. A failed variant is a row with its message, and the others run: values that the file rejects only in combination, and a simulation
/// that cannot continue.
#[test]
fn k08_failures_are_rows() {
    let folder = tempfile::tempdir().unwrap();
    let (out, samples) = (folder.path().join("results.csv"), folder.path().join("samples.csv"));
    fs::write(
        &samples,
        "# limits of the step\nfile:solver.min_step_s,file:solver.max_step_s\n1e-9,1e-2\n1e-3,1e-1\n1e-3,1e-2\n1e-9,1e-4\n\
         1e-3,1e-4\n",
    )
    .unwrap();
    let arguments = ["--samples", samples.to_str().unwrap(), "--variables", "fold.angle", "--stop", "0.02"];
    let summary = succeeds(&mut sweep(&out, &arguments));
    let results = fs::read_to_string(&out).unwrap();
    let (status, messages) = (column(&results, "status"), column(&results, "message"));
    assert_eq!(status[4], "failed", "{results}");
    assert!(messages[4].contains("min_step_s") && !messages[4].contains('\n'), "{}", messages[4]);
    assert_eq!(column(&results, "fold.angle")[4], "");
    assert_eq!((status[0].as_str(), status[3].as_str()), ("done", "done"), "{results}");
    let failed = status.iter().filter(|status| *status == "failed").count();
    assert!(summary.contains(&format!("({failed} failed, 0 resumed)")), "{summary}");
}

/// K-09. Two processes cannot run the same sweep at once: the second one fails while the first holds the record.
#[test]
fn k09_one_process_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("results.csv");
    let record = fs::File::create(record_of(&out)).unwrap();
    record.lock().unwrap();
    let arguments = ["--vary", "fold.start_angle=1,2", "--stop", "0.01"];
    refuses(&mut sweep(&out, &arguments), 4, &["another process is running this sweep"]);
    drop(record);
    succeeds(&mut sweep(&out, &arguments));
}

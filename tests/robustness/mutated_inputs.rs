//! Corrupted model files and folders: rejected with a message or simulated, without a panic, a hang or exhausted memory.
//!
//! `FOLDWING_MUTATIONS` sets how many files are derived from the shipped ones, `FOLDWING_SEED` runs a single one.

use crate::fmu::{Attempt, Fmu, Resources, WING, guid_of};
use crate::share::share;
use fastrand::Rng;
use foldwing::aero::AirOptions;
use foldwing::config::{self, ConfigError};
use foldwing::interface::{Interface, guid};
use foldwing::machine::Machine;
use foldwing_fmu::functions::*;
use foldwing_fmu::types::*;
use std::collections::BTreeMap;
use std::process::Command;

/// Number of files in a plain `cargo test`.
const SHARE: usize = 1_500;
/// One of this many files is also run through the command line.
const COMMAND_LINE: usize = 50;
/// Larger models are only read: a simulation would take minutes, as intended by their authors.
const MAXIMUM_ELEMENTS: usize = 300;
const MAXIMUM_STATIONS: usize = 100;
const MAXIMUM_PANELS: usize = 200;
const MAXIMUM_WAKE_ROWS: usize = 100;
const MINIMUM_AIR_STEP_S: f64 = 1e-5;

/// Values that replace others.
const VALUES: [&str; 40] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "1000",
    "1001",
    "1000000000",
    "9223372036854775807",
    "9223372036854775808",
    "1e9",
    "1e30",
    "1.1e30",
    "1e-30",
    "5e-324",
    "1e308",
    "1e999",
    "-1e200",
    "nan",
    "inf",
    "-inf",
    "true",
    "false",
    "\"\"",
    "\"root\"",
    "\"a%s%n\"",
    "\"\\u0000\"",
    "[]",
    "[0.0, 0.0, 0.0]",
    "[1e200, nan, 0.0]",
    "[[1.0, 2.0]]",
    "{}",
    "{ a = 1 }",
    "1979-05-27",
    "0x10",
    "'''\n'''",
    "\"constant\"",
    "\"ball\"",
    "\"equilibrium\"",
    "\"strip\"",
];

/// Tokens that break the syntax of a line.
const TOKENS: [&str; 14] = ["[", "]", "[[", "=", "\"", "'", "#", "\n", ".", "{", "}", "\u{0}", "\u{feff}", "é\u{202e}"];

fn models() -> Vec<String> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/models");
    let mut paths: Vec<_> =
        std::fs::read_dir(folder).expect("the models").map(|entry| entry.expect("readable").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    paths.sort();
    let models: Vec<String> = paths.iter().map(|path| std::fs::read_to_string(path).expect("readable")).collect();
    assert!(models.len() >= 11, "the shipped models");
    models
}

/// A line whose first number after the equals sign is replaced by another one, which may be valid.
fn scaled(rng: &mut Rng, line: &str) -> Option<String> {
    let begin = line.find(" = ")? + 3;
    let begin = begin + line[begin..].find(|letter: char| letter.is_ascii_digit())?;
    let end = line[begin..].find(|letter: char| !"0123456789.e-".contains(letter)).map_or(line.len(), |at| begin + at);
    let number: f64 = line[begin..end].parse().ok()?;
    let new = number * [0.0, 1e-9, 1e-3, 0.5, 1.0 + 1e-9, 2.0, 10.0, 1e3, 1e6][rng.usize(..9)];
    let new = if line[begin..end].contains(['.', 'e']) { format!("{new:?}") } else { format!("{}", new as i64) };
    Some(format!("{}{new}{}", &line[..begin], &line[end..]))
}

/// A model file with random modifications.
fn mutated(rng: &mut Rng, models: &[String]) -> Vec<u8> {
    let one = |rng: &mut Rng| rng.usize(..models.len());
    let mut lines: Vec<String> =
        models[one(rng)].lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect();
    for _ in 0..rng.usize(1..4) {
        let at = rng.usize(..lines.len());
        match rng.u8(..14) {
            0..=7 => {
                // the value of a key
                let places: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].contains(" = ")).collect();
                if let Some(&at) = places.get(rng.usize(..places.len().max(1))) {
                    let key = lines[at].split(" = ").next().unwrap_or_default().to_owned();
                    let value = VALUES[rng.usize(..VALUES.len())];
                    lines[at] = match rng.bool().then(|| scaled(rng, &lines[at])).flatten() {
                        Some(line) => line,
                        None => format!("{key} = {value}"),
                    };
                }
            }
            8 => _ = lines.remove(at),
            9 => {
                let other = rng.usize(..lines.len());
                lines.swap(at, other);
            }
            10 => {
                let line = lines[at].clone();
                lines.insert(at, line);
            }
            11 => {
                let donor: Vec<&str> = models[one(rng)].lines().collect();
                lines.insert(at, donor[rng.usize(..donor.len())].to_owned());
            }
            12 => {
                let token = TOKENS[rng.usize(..TOKENS.len())];
                let line = &mut lines[at];
                let places: Vec<usize> = line.char_indices().map(|(i, _)| i).chain([line.len()]).collect();
                line.insert_str(places[rng.usize(..places.len())], token);
            }
            _ => {
                // a letter of a key or a name
                let mut letters: Vec<char> = lines[at].chars().collect();
                if !letters.is_empty() {
                    let place = rng.usize(..letters.len());
                    letters[place] = rng.char(' '..='~');
                    lines[at] = letters.into_iter().collect();
                }
            }
        }
        if lines.is_empty() {
            lines.push(String::new());
        }
    }
    let mut bytes = lines.join("\n").into_bytes();
    match rng.u8(..20) {
        0 => bytes.truncate(rng.usize(..=bytes.len())),
        1 if !bytes.is_empty() => {
            let at = rng.usize(..bytes.len());
            bytes[at] ^= 1 << rng.u8(..8);
        }
        _ => {}
    }
    bytes
}

/// Returns whether a simulation of a machine takes long.
fn is_large(machine: &Machine) -> bool {
    let elements: usize = machine.bodies.iter().map(|body| body.elements).sum();
    let air = machine.air.as_ref().is_some_and(|air| {
        let panels = air.surfaces.iter().map(|surface| (surface.positions_m.len() - 1) * surface.chord_panels);
        let rows = match &air.parts[0].options {
            AirOptions::Lattice(options) => options.wake_rows,
            AirOptions::Strips(_) | AirOptions::Rotor(_) | AirOptions::SlenderBody(_) => 0,
        };
        panels.sum::<usize>() > MAXIMUM_PANELS || rows > MAXIMUM_WAKE_ROWS || air.step_s < MINIMUM_AIR_STEP_S
    });
    let stations: usize = machine.bodies.iter().map(|body| body.station_positions_m.len()).sum();
    elements > MAXIMUM_ELEMENTS || stations > MAXIMUM_STATIONS || air
}

/// Checks that an error message gives a line in the file and is of limited length.
fn check_refusal(error: &ConfigError, lines: usize) -> Result<(), String> {
    let text = error.to_string();
    let points = error.problems().iter().all(|problem| (1..=lines.max(1)).contains(&problem.line));
    let starts = text.lines().all(|line| line.starts_with("model.toml:"));
    if error.problems().is_empty() || !points || !starts || text.len() > 100_000 {
        return Err(format!("a refusal without place: {text}"));
    }
    Ok(())
}

/// Runs a valid model like an importer; returns the statuses of the calls.
fn run(text: &str) -> Result<&'static str, String> {
    let fmu = Fmu::new(text);
    let c = fmu.component;
    let [started, stepped] = unsafe {
        assert_eq!(fmi2EnterInitializationMode(c), fmi2OK);
        let started = fmi2ExitInitializationMode(c);
        let time_s = fmu.table.variables()[0].value_reference;
        let mut now_s = 0.0;
        let stepped = match started {
            fmi2_ok if fmi2_ok == fmi2OK => {
                assert_eq!(fmi2GetReal(c, &time_s, 1, &mut now_s), fmi2OK);
                fmi2DoStep(c, now_s, 1e-4, fmi2True)
            }
            _ => fmi2Error,
        };
        [started, stepped]
    };
    if started == fmi2OK && stepped == fmi2OK {
        return match fmu.bits().into_iter().all(|bits| f64::from_bits(bits).is_finite()) {
            true => Ok("runs"),
            false => Err("a step gave a value that is not finite".to_owned()),
        };
    }
    let messages = fmu.messages.borrow();
    let told = messages.last().map(|message| message.text.clone()).unwrap_or_default();
    let sound = [started, stepped].iter().all(|status| *status == fmi2OK || *status == fmi2Error);
    if sound && (told.contains(" t = ") || told.contains("solver.min_step")) {
        Ok("gives up with a message")
    } else {
        Err(format!("statuses {started}, {stepped}: {told}"))
    }
}

fn number(name: &str) -> Option<usize> {
    std::env::var(name).ok().map(|text| text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")))
}

/// M-01. Mutations of the shipped models: rejected with file and line by the reader and by `fmi2Instantiate`, or valid; then they start and
/// step, or the error gives the time of the failure. Some are run through `foldwing check` and `foldwing package`.
#[test]
fn m01_mutated_models() {
    let models = models();
    let guard = crate::watchdog::watch(number("FOLDWING_WATCHDOG").unwrap_or(120) as u64);
    let mut tally: BTreeMap<&str, usize> = BTreeMap::new();
    let seeds = match number("FOLDWING_SEED") {
        Some(seed) => seed..seed + 1,
        None => 0..number("FOLDWING_MUTATIONS").unwrap_or(SHARE.div_ceil(share())),
    };
    for seed in seeds {
        guard.note(|| format!("FOLDWING_SEED={seed}"));
        let bytes = mutated(&mut Rng::with_seed(seed as u64), &models);
        let outcome = std::panic::catch_unwind(|| try_out(&bytes, seed));
        let result = outcome.unwrap_or_else(|_| Err("a panic".to_owned()));
        let kind = result.unwrap_or_else(|complaint| {
            let text = String::from_utf8_lossy(&bytes);
            panic!("FOLDWING_SEED={seed}: {complaint}\n{text}")
        });
        *tally.entry(kind).or_default() += 1;
    }
    println!("{} mutated models: {tally:?}", tally.values().sum::<usize>());
}

fn try_out(bytes: &[u8], seed: usize) -> Result<&'static str, String> {
    if seed.is_multiple_of(COMMAND_LINE) {
        command_line(bytes)?;
    }
    let Ok(text) = std::str::from_utf8(bytes) else {
        let resources = Resources::with("");
        std::fs::write(resources.folder.join("model.toml"), bytes).expect("writable");
        let message = Attempt { guid: Some(String::new()), ..Attempt::of(WING, &resources) }.refusal();
        return if message.contains("model.toml") { Ok("refused as no text") } else { Err(message) };
    };
    let machine = match config::parse(text, "model.toml") {
        Ok(machine) => machine,
        Err(error) => {
            check_refusal(&error, text.split('\n').count())?;
            if seed.is_multiple_of(10) {
                let message = Attempt::of(WING, &Resources::with(text)).refusal();
                if !message.contains("model.toml:") {
                    return Err(message);
                }
            }
            return Ok("refused");
        }
    };
    if is_large(&machine) {
        return Ok("valid and large");
    }
    run(text)
}

/// Checks that the command ends with a documented exit code and a cause, without a panic.
fn command_line(bytes: &[u8]) -> Result<(), String> {
    let folder = Resources::empty("command");
    let path = folder.folder.join("model.toml");
    std::fs::write(&path, bytes).expect("writable");
    let runs: [&[&str]; 2] = [&["check"], &["package", "--description-only"]];
    for arguments in runs {
        let output = Command::new(env!("CARGO_BIN_EXE_foldwing")).args(arguments).arg(&path).output().expect("starts");
        let told = String::from_utf8_lossy(&output.stderr);
        match output.status.code() {
            Some(0) => {}
            Some(1 | 4) if told.contains("model.toml") && !told.contains("panicked") => {}
            other => return Err(format!("foldwing {arguments:?}: {other:?}: {told}")),
        }
    }
    Ok(())
}

/// M-02. Models valid apart from their size are rejected; they used to exhaust the memory.
#[test]
fn m02_models_of_absurd_size() {
    let tunnel = include_str!("../../examples/models/folding_wing_in_tunnel.toml");
    let elements = |n: &str| WING.replacen("elements = 4", &format!("elements = {n}"), 1);
    let bodies: String = (0..25)
        .map(|i| {
            format!(
                "[body.b{i}]\nlength_m = 1.0\nsection = \"plate\"\nelements = 1000\nload_stations = 100\n\
                 [joint.j{i}]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"b{i}\"\n"
            )
        })
        .collect();
    let many = format!(
        "name = \"Many\"\n[section.plate]\nshape = \"rectangle\"\nwidth_m = 0.1\nheight_m = 0.01\ndensity_kg_m3 = 1000.0\n\
         youngs_modulus_Pa = 1e9\npoisson_ratio = 0.3\n{bodies}"
    );
    let cases = [
        (elements("1000000000"), "elements': 1000000000 is not allowed; allowed: a whole number from 1 to 1000"),
        (many.clone(), "key 'body': 25000 elements is not allowed; allowed: at most 20000 on all bodies together"),
        (many, "key 'body': 2500 load stations is not allowed; allowed: at most 2000 on all bodies together"),
        (
            tunnel.replace("strips = 10", "strips = 1000").replace("chord_panels = 4", "chord_panels = 1000"),
            "key 'surface': a lattice of 2000000 panels is not allowed; allowed: at most 5000 panels",
        ),
        (
            tunnel.replace("strips = 10", "strips = 100").replace("wake_rows = 30", "wake_rows = 10000"),
            "key 'aerodynamics.wake_rows': a wake of 2000000 panels is not allowed; allowed: at most 200000 panels",
        ),
    ];
    for (text, expected) in cases {
        let message = config::parse(&text, "model.toml").expect_err(expected).to_string();
        assert!(message.contains(expected), "{message}");
        let message = Attempt { guid: Some(String::new()), ..Attempt::of(WING, &Resources::with(&text)) }.refusal();
        assert!(message.contains(expected), "{message}");
    }
}

/// M-03. Invalid folders and files: an instance is rejected with the path and the cause.
#[test]
fn m03_hostile_resources() {
    let refused = |resources: &Resources, part: &str| {
        let message = Attempt::of(WING, resources).refusal();
        assert!(message.contains("model.toml") && message.contains(part), "{part}: {message}");
        assert!(message.len() < 100_000, "{part}: a message of {} bytes", message.len());
    };
    let with = |bytes: &[u8]| {
        let resources = Resources::empty("hostile");
        std::fs::write(resources.folder.join("model.toml"), bytes).expect("writable");
        resources
    };
    refused(&with(b""), "missing");
    refused(&with(b"\xff\xfe\x00"), "UTF-8");
    refused(&with(&[0; 1000]), "not valid TOML");
    refused(&with("a = ".repeat(100_000).as_bytes()), "not valid TOML");
    // nesting that overflowed the stack would crash the importer
    for (open, close) in [("[", "]"), ("{a=", "}")] {
        let deep = format!("x = {}1{}", open.repeat(100_000), close.repeat(100_000));
        refused(&with(deep.as_bytes()), "");
        refused(&with(format!("x = {}", open.repeat(100_000)).as_bytes()), "");
    }
    refused(&with(format!("{} = 1", vec!["a"; 50_000].join(".")).as_bytes()), "");
    refused(&with(format!("[{}]", vec!["a"; 50_000].join(".")).as_bytes()), "");
    refused(&with(&WING.repeat(2).into_bytes()), "");
    refused(
        &with(format!("{WING}\n# {}", "x".repeat(20_000_000)).replace("length_m", "lenght_m").as_bytes()),
        "lenght_m",
    );

    let folder = Resources::empty("hostile");
    std::fs::create_dir(folder.folder.join("model.toml")).expect("writable");
    refused(&folder, "cannot be read");
    #[cfg(unix)]
    {
        let looped = Resources::empty("hostile");
        std::os::unix::fs::symlink("model.toml", looped.folder.join("model.toml")).expect("writable");
        refused(&looped, "cannot be read");
    }
    // a model that is not the one that was packaged
    let exchanged = Resources::with(&WING.replace("elements = 4", "elements = 5"));
    let message = Attempt::of(WING, &exchanged).refusal();
    assert!(message.contains(&guid_of(WING)) && message.contains("package the model again"), "{message}");
    // a file with one more comment is different, and is reported as such
    let machine = config::parse(WING, "model.toml").expect("valid");
    assert_ne!(guid(&format!("{WING}#"), Interface::new(&machine).variables()), guid_of(WING));
}

//! Every kind of error in a model file: the whole message, with line, key, value and the allowed values.
//!
//! A case is the small model below with one text replaced. Each message is written here in full, so that a change of wording is noticed.

use crate::share::share;
use foldwing::config::{self, ConfigError, Fault};
use std::path::PathBuf;

/// The model that the cases modify; its lines are numbered in the messages.
pub const MODEL: &str = r#"name = "Wing"
gravity_m_s2 = [0.0, 0.0, -9.81]
[section.plate]
shape = "rectangle"
width_m = 0.05
height_m = 0.002
density_kg_m3 = 1425.0
youngs_modulus_Pa = 2.83e9
poisson_ratio = 0.3
[section.spar]
shape = "explicit"
stiffness_SI = [[1e5, 0, 0, 0], [0, 2, 0.5, 0], [0, 0.5, 3, 0], [0, 0, 0, 9]]
mass_kg_m = 0.3
second_moments_kg_m = [1e-4, 0, 1e-6]
[body.inner]
length_m = 0.15
section = "plate"
elements = 2
load_stations = 4
[body.outer]
length_m = 0.1
section = "spar"
elements = 2
[joint.mount]
type = "clamped"
parent = "root"
child = "inner"
[joint.fold]
type = "revolute"
parent = "inner"
child = "outer"
axis = [0, 2, 0]
start_angle_deg = 170
[joint.fold.motor]
stiffness_N_m_rad = 0.026
[joint.fold.latch]
stiffness_ratio = 1e4
[mass.actuator]
body = "inner"
position_m = 0.15
mass_kg = 0.02
inertia_kg_m2 = [1e-6, 1e-6, 1e-6, 0, 0, 0]
[gauge.root]
body = "inner"
position_m = 0.02
z_m = 0.001
[solver]
tolerance = 1e-4
max_step_s = 5e-3
min_step_s = 1e-9
rho_infinity = 0.8
[simulation]
start_time_s = 0
stop_time_s = 0.4
step_s = 5e-4
"#;

/// [`MODEL`] with one text replaced.
pub fn with(old: &str, new: &str) -> String {
    assert!(MODEL.contains(old), "the model has no {old:?}");
    MODEL.replacen(old, new, 1)
}

/// Messages for [`MODEL`] with one text replaced, one problem per line.
pub fn message(old: &str, new: &str) -> String {
    message_of(&with(old, new))
}

/// Messages for a text.
pub fn message_of(text: &str) -> String {
    config::parse(text, "wing.toml").map_or_else(|error| error.to_string(), |_| "accepted".to_owned())
}

pub fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// The shipped models, by path.
pub fn shipped_models() -> Vec<PathBuf> {
    let folder = repository().join("examples/models");
    let mut models: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    models.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
    models.sort();
    models
}

#[test]
fn shipped_models_are_accepted() {
    let models = shipped_models();
    assert_eq!(models.len(), 14, "a model that is added or lost changes this number too: {models:?}");
    for model in models {
        let (machine, text) = config::read(&model).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(text, std::fs::read_to_string(&model).unwrap());
        assert!(!machine.description.is_empty());
        assert!(text.starts_with("#:schema ./foldwing.schema.json\n"), "editors complete {}", model.display());
        let row = format!("`{}`", model.file_name().unwrap().to_string_lossy());
        assert!(config::reference().contains(&row), "docs/MODEL_FILE.md lists the models; {row} is missing");
    }
}

#[test]
fn an_unreadable_file_is_named() {
    let error = config::read("no/such/wing.toml").unwrap_err();
    assert!(matches!(error, ConfigError::Read { .. }));
    assert!(error.to_string().starts_with("no/such/wing.toml: cannot be read: "), "{error}");
}

#[test]
fn all_problems_are_reported_at_once_in_the_order_of_the_file() {
    let text = with("position_m = 0.02", "position_m = 1").replace("axis = [0, 2, 0]", "axis = [0, 0, 0]");
    let error = config::parse(&text, "wing.toml").unwrap_err();
    let found: Vec<(usize, &str)> =
        error.problems().iter().map(|problem| (problem.line, problem.key.as_str())).collect();
    assert_eq!(found, [(32, "joint.fold.axis"), (45, "gauge.root.position_m")]);
    assert!(error.problems().iter().all(|problem| matches!(problem.fault, Fault::NotAllowed { .. })));
    assert_eq!(error.to_string().lines().count(), 2);
}

/// An empty text is not a model: the required tables are missing.
#[test]
fn an_empty_file_lacks_everything() {
    assert_eq!(
        message_of(""),
        "wing.toml:1: key 'name' is missing; allowed: an identifier: letters, digits and _, no digit first\n\
         wing.toml:1: key 'section' is missing; allowed: at least one table [section.<name>]\n\
         wing.toml:1: key 'body' is missing; allowed: at least one table [body.<name>]\n\
         wing.toml:1: key 'joint' is missing; allowed: at least one table [joint.<name>]"
    );
}

/// Files made from the schema are up to date. `FOLDWING_BLESS=1` writes them again.
#[test]
fn files_made_from_the_schema_are_current() {
    let made =
        [("examples/models/foldwing.schema.json", config::schema()), ("docs/MODEL_FILE.md", config::reference())];
    for (file, text) in made {
        let path = repository().join(file);
        if std::env::var_os("FOLDWING_BLESS").is_some() {
            std::fs::write(&path, &text).unwrap();
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default().replace("\r\n", "\n");
        assert!(found == text, "{file} is stale: run this test with FOLDWING_BLESS=1");
    }
}

/// Xorshift: the same mutations on every computer.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }
}

/// Parses a text: the result is either a machine of finite numbers or an error that gives a line.
fn survives(text: &str) {
    match config::parse(text, "wing.toml") {
        Ok(machine) => {
            let printed = format!("{machine:?}");
            let finite = ["NaN", " inf", "-inf", "[inf"].iter().all(|word| !printed.contains(word));
            assert!(finite, "not finite: {text}\n{printed}");
        }
        Err(error) => {
            let lines = text.matches('\n').count() + 1;
            assert!(!error.problems().is_empty(), "nothing said about {text}");
            assert!(error.problems().iter().all(|problem| (1..=lines).contains(&problem.line)), "{error}\n{text}");
        }
    }
}

#[test]
fn mutated_bytes_never_panic() {
    const BYTES: &[u8] = b"0129.-+e\"'[]{}=#,_ \n\r\t\0\xffxm";
    let mut random = Random(0x5EED_F01D);
    for model in shipped_models() {
        let original = std::fs::read(model).unwrap();
        for _ in 0..2000usize.div_ceil(share()) {
            let mut bytes = original.clone();
            for _ in 0..=random.below(4) {
                let at = random.below(bytes.len());
                let end = (at + 1 + random.below(20)).min(bytes.len());
                match random.below(3) {
                    0 => bytes[at] = BYTES[random.below(BYTES.len())],
                    1 if end - at < bytes.len() => drop(bytes.drain(at..end)),
                    _ => bytes.insert(at, random.below(256) as u8),
                }
            }
            survives(&String::from_utf8_lossy(&bytes));
        }
    }
}

/// Every value of every shipped model replaced by values that are difficult for parsers and arithmetic.
#[test]
fn nasty_values_never_panic() {
    const VALUES: &str = "0 -1 -0.0 1 2 1e-320 1e-30 1e29 1e30 -1e30 1e308 1e999 nan -inf true \"\" \"root\" \"inner\" \
         \"outer\" \"wing\" [] [[]] {} {x=1} [{}] [0,0,0] [1e30,1e30,1e30] [1e-320,0,0] [[0,0],[1e-320,1e30]] \
         1979-05-27 99999999999999999999 0xff \"\\u0000\" '''x'''";
    for model in shipped_models() {
        let text = std::fs::read_to_string(model).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        for (number, line) in lines.iter().enumerate().filter(|(_, line)| !line.starts_with('#')) {
            let Some((key, _)) = line.split_once(" = ") else { continue };
            // with a share, other values in each line
            let others = number % share();
            for value in VALUES.split_whitespace().skip(others).step_by(share()) {
                let replaced = format!("{key} = {value}");
                let mut mutated = lines.clone();
                mutated[number] = &replaced;
                survives(&mutated.join("\n"));
            }
        }
    }
}

/// Deep nesting overflows the stack of parsers that recurse without a limit.
#[test]
fn deep_nesting_never_overflows_the_stack() {
    survives(&format!("name = {}", "[".repeat(100_000)));
    survives(&format!("{}name = 1", "a.".repeat(10_000)));
    survives(&format!("name = {}1{}", "{a = ".repeat(10_000), "}".repeat(10_000)));
}

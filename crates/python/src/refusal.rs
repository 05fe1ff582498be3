//! Errors as exceptions of `foldwing.errors`, with the messages of the command and the keywords of Python instead of the
//! command's options.

use foldwing_command::cli::Failure;
use foldwing_engine::plant::PlantError;
use foldwing_file::ConfigError;
use foldwing_fmi::interface::AccessError;
use foldwing_study::campbell::CampbellError;
use foldwing_study::flutter::FlutterError;
use foldwing_study::names::NameError;
use foldwing_study::operating_points::PointsError;
use foldwing_study::periodic::PeriodicError;
use foldwing_study::trim::TrimError;
use foldwing_study::values::SettingError;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Options of the command whose keyword in Python is not the option's name followed by `=`.
const KEYWORDS: [(&str, &str); 14] = [
    ("--video", "output="),
    ("--from", "start="),
    ("--to", "stop="),
    ("--set", "settings="),
    ("--variables", "outputs="),
    ("--library", "libraries="),
    ("--max-frequency", "max_frequency_Hz="),
    ("--no-reference", "reference=False"),
    ("--force", "force=True"),
    ("--scalars", "scalars=True"),
    ("--accounts", "accounts=True"),
    ("--lattice", "lattice=True"),
    ("--paired", "paired=True"),
    ("`foldwing check` lists the names", "Model.variables has the names"),
];

/// Replaces options of the command in a message by the keywords of Python: `--stop -1: must …` becomes `stop=-1: must …`.
fn in_keywords(message: &str) -> String {
    let mut text = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(at) = rest.find("--").into_iter().chain(rest.find("`foldwing check`")).min() {
        let (before, from) = rest.split_at(at);
        text.push_str(before);
        let word = from.find(|letter: char| !(letter.is_ascii_lowercase() || letter == '-')).unwrap_or(from.len());
        let known = KEYWORDS.iter().find(|(option, _)| from.starts_with(option) && word <= option.len());
        rest = match known {
            Some((option, keyword)) => {
                text.push_str(keyword);
                &from[option.len()..]
            }
            None if word > 2 => {
                text.push_str(&from[2..word].replace('-', "_"));
                text.push('=');
                &from[word..]
            }
            // other dashes, or a name in quotes
            None => {
                let first = from.chars().next().map_or(from.len(), char::len_utf8);
                text.push_str(&from[..first]);
                &from[first..]
            }
        };
        // at the beginning of a message the option is followed by its value; elsewhere only a number counts as its value
        let is_value = |rest: &str| {
            rest.strip_prefix(' ').is_some_and(|rest| rest.starts_with(|first: char| first.is_ascii_digit()))
        };
        if text.ends_with('=') && (before.is_empty() && !rest.starts_with(" and ") || is_value(rest)) {
            rest = rest.strip_prefix(' ').unwrap_or(rest);
        }
    }
    text.push_str(rest);
    text
}

/// An exception of the class `name` of `foldwing.errors`.
fn of_class(name: &str, message: &str) -> PyErr {
    let message = in_keywords(message);
    Python::attach(|py| {
        let raised = || py.import("foldwing.errors")?.getattr(name)?.call1((message,));
        raised().map_or_else(|error| error, PyErr::from_value)
    })
}

/// Exception for an unknown name or a value that is not allowed.
pub fn usage(message: impl AsRef<str>) -> PyErr {
    of_class("UsageError", message.as_ref())
}

/// Exception for a simulation that failed.
pub fn simulation(error: &PlantError) -> PyErr {
    of_class("SimulationError", &error.to_string())
}

/// Exception for a static, modal or linear analysis that failed.
pub fn statics(error: &PlantError) -> PyErr {
    of_class("StaticsError", &error.to_string())
}

/// Exception for a linear model that cannot be reduced or sampled.
pub fn no_linear_model(message: String) -> PyErr {
    of_class("StaticsError", &message)
}

/// Exception for a row that cannot be read or set.
pub fn access(error: &AccessError) -> PyErr {
    usage(error.to_string())
}

/// Exception for a flutter sweep that cannot be made.
pub fn flutter(error: &FlutterError) -> PyErr {
    match error {
        FlutterError::FirstSpeed { .. } | FlutterError::Stopped => of_class("StaticsError", &error.to_string()),
        FlutterError::NoWind { machine } => usage(format!(
            "{machine}: the model has no wind, so its direction is undefined; set aerodynamics.wind_m_s, or \
             settings={{\"wind.velocity.y\": -1.0}}"
        )),
        FlutterError::Speeds
        | FlutterError::TooManySpeeds { .. }
        | FlutterError::Count { .. }
        | FlutterError::NoAir { .. }
        | FlutterError::Rotor { .. }
        | FlutterError::UnsteadyStart { .. } => usage(error.to_string()),
    }
}

/// Exception for a trim that is not found.
pub fn trim(error: &TrimError) -> PyErr {
    let text = error.to_string();
    match error {
        TrimError::Name(error) => name(error),
        TrimError::SolveFor { unknown, error } => usage(format!("solve_for={unknown}: {error}")),
        TrimError::Target { output, value, error } => usage(format!("target={{{output:?}: {value}}}: {error}")),
        TrimError::NotFinite { turn, value } => {
            usage(format!("settings={{{:?}: {value}}}: the value is not a finite number", turn.name()))
        }
        TrimError::Turn { turn, error } => usage(format!("settings: {}: {error}", turn.name())),
        TrimError::Count { .. } => usage(format!("solve_for= and target=: {text}")),
        TrimError::NothingFree => usage(format!("trim: {text}")),
        TrimError::Refused { name, value, error } => usage(format!("solve_for={name}: {value:?}: {error}")),
        TrimError::NoEquilibrium(_) | TrimError::Stopped => of_class("StaticsError", &text),
        TrimError::NotConverged { .. } => of_class(
            "StaticsError",
            &text.replace("use other initial guesses, or", "use other initial guesses (settings=), or"),
        ),
    }
}

/// Exception for a table of operating points that cannot be computed.
pub fn operating_points(error: &PointsError) -> PyErr {
    let text = error.to_string();
    match error {
        PointsError::Point(_) | PointsError::Stopped => of_class("StaticsError", &text),
        PointsError::Name(error) | PointsError::Setting(SettingError::Name(error)) => name(error),
        PointsError::Range { unknown } => {
            let [from, to] = unknown.range();
            usage(format!("solve_for=({:?}, {from}, {to}): must be two different finite numbers", unknown.name()))
        }
        PointsError::TargetNotFinite { target } => {
            usage(format!("target=({:?}, {}): must be a finite number in SI units", target.output, target.value))
        }
        PointsError::NotAnOutput { target } => {
            usage(format!("target=({:?}, {}): is not a real output", target.output, target.value))
        }
        PointsError::SoughtAndGiven { unknown } => usage(format!("solve_for=: {text}: {}=", unknown.name())),
        PointsError::NoWind { machine } => usage(format!(
            "{machine}: the model has no wind, so its direction is undefined; set aerodynamics.wind_m_s, or \
             settings={{\"wind.velocity.x\": 1.0}}"
        )),
        PointsError::Empty { .. }
        | PointsError::NotFinite { .. }
        | PointsError::NegativeWind { .. }
        | PointsError::TipSpeedRatio { .. }
        | PointsError::SeveralSpeeds
        | PointsError::NoRadius
        | PointsError::TooMany { .. }
        | PointsError::Unpaired { .. }
        | PointsError::Tolerance { .. }
        | PointsError::NoAir { .. }
        | PointsError::NoPitchJoints { .. }
        | PointsError::PitchJoint { .. }
        | PointsError::LoosePitch { .. }
        | PointsError::Setting(SettingError::Value(_)) => usage(text),
    }
}

/// Exception for a periodic motion that is not found.
pub fn periodic(error: &PeriodicError) -> PyErr {
    let text = error.to_string();
    match error {
        PeriodicError::Harmonics { .. } => usage(text.replacen("harmonics ", "harmonics=", 1)),
        PeriodicError::Tolerance { .. } => usage(text.replacen("tolerance ", "tolerance=", 1)),
        PeriodicError::NoPerturbations => usage("perturbations=0: modes need at least 1; count=0 omits the modes"),
        PeriodicError::Name(error) | PeriodicError::Setting(SettingError::Name(error)) => name(error),
        PeriodicError::Setting(SettingError::Value(_)) => usage(text),
        PeriodicError::NoTurn { .. } | PeriodicError::Plant(_) | PeriodicError::Stopped => {
            of_class("StaticsError", &text)
        }
    }
}

/// Exception for a Campbell diagram that cannot be computed.
pub fn campbell(error: &CampbellError) -> PyErr {
    let text = error.to_string();
    match error {
        CampbellError::Setting(SettingError::Name(error)) => name(error),
        CampbellError::Speeds | CampbellError::Setting(SettingError::Value(_)) => usage(text),
        CampbellError::Plant(_)
        | CampbellError::NoTurn { .. }
        | CampbellError::FirstSpeed { .. }
        | CampbellError::Stopped => of_class("StaticsError", &text),
    }
}

/// Exception for a name that no variable has.
pub fn name(error: &NameError) -> PyErr {
    match error {
        NameError::Unknown { nearest: None, .. } => usage(format!("{error}; Model.variables has the names")),
        NameError::Unknown { .. } | NameError::NoMatch { .. } => usage(error.to_string()),
    }
}

/// Exception for a failure of the command, by its type.
pub fn command(failure: &Failure) -> PyErr {
    let message = failure.to_string();
    match failure {
        Failure::Model { error, .. } => model(error),
        Failure::Refused(_) => of_class("ModelError", &message),
        Failure::Usage(_) => usage(message),
        Failure::Simulation(_) => of_class("SimulationError", &message),
        Failure::Statics(_) => of_class("StaticsError", &message),
        Failure::Files(_) => of_class("FilesError", &message),
        Failure::Closed | Failure::Differ(..) => PyRuntimeError::new_err(message),
    }
}

/// Exception for an invalid model file: the message, and its problems as `(line, key, text)`.
pub fn model(error: &ConfigError) -> PyErr {
    let refused = of_class(
        if matches!(error, ConfigError::Read { .. }) { "FilesError" } else { "ModelError" },
        &error.to_string(),
    );
    let problems: Vec<(usize, String, String)> = error
        .problems()
        .iter()
        .map(|problem| {
            let text = problem.to_string();
            let text = text.split_once(": ").map_or(text.clone(), |(_, rest)| rest.to_owned());
            (problem.line, problem.key.clone(), text)
        })
        .collect();
    let set = Python::attach(|py| refused.value(py).setattr("problems", problems));
    set.err().unwrap_or(refused)
}

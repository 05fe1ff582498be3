//! `foldwing live`: an interactive simulation in real time in the browser.

use crate::cli::settings::plant_with;
use crate::cli::{Failure, read_model, tell};
use crate::live::{Ended, MOST_MACHINES, Server, Session, Summary};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::{Plant, PlantError, Snapshot};
use foldwing_fmi::interface::{Interface, guid};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::LIVE)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Port of the loopback interface [default: any free port]
    #[arg(long, default_value_t = 0, hide_default_value = true)]
    port: u16,
    /// Print the address without starting a browser
    #[arg(long)]
    no_browser: bool,
    /// Simulated seconds per second; the page can change it
    #[arg(long, default_value_t = 1.0, value_name = "X", value_parser = speed, allow_negative_numbers = true)]
    speed: f64,
    /// Another model, simulated in step with the first: one clock, drawn together; sliders, buttons and pulls of the mouse act on all models or on
    /// the one selected above them; may be repeated
    #[arg(long = "compare", value_name = "MODEL")]
    others: Vec<PathBuf>,
    /// Start value of an input or parameter of the first model; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// File with the state to start from: the bytes of `State.to_bytes` of the Python package; with --compare once per model, in order
    #[arg(long = "state", value_name = "FILE", conflicts_with = "settings")]
    states: Vec<PathBuf>,
}

/// Parses a speed within the limits of the page.
fn speed(text: &str) -> Result<f64, String> {
    let [least, most] = crate::live::SPEEDS;
    let value: f64 = text.parse().map_err(|_| "is not a number".to_owned())?;
    if (least..=most).contains(&value) { Ok(value) } else { Err(format!("must be from {least} to {most}")) }
}

/// Serves the page until it is closed.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let machines = machines(arguments)?;
    let interrupted = Arc::new(AtomicBool::new(false));
    heed_signals(&interrupted);
    let port = arguments.port;
    let server = Server::bind(port).map_err(|error| {
        Failure::Files(format!(
            "--port {port}: cannot be opened on 127.0.0.1: {error}; choose another port, or 0 for any free port"
        ))
    })?;
    let mut session = Session::of_machines(machines, arguments.speed);
    announce(&server, &session, arguments.no_browser)?;
    let ended = server
        .run(&mut session, &interrupted)
        .map_err(|error| Failure::Files(format!("the server failed: {error}")))?;
    tell::note(&summary_text(ended, &session.summary()));
    Ok(())
}

/// Reads the models and starts them, with their names in the legend.
fn machines(arguments: &Arguments) -> Result<Vec<(String, Plant, Interface)>, Failure> {
    let paths: Vec<&PathBuf> = [&arguments.model].into_iter().chain(&arguments.others).collect();
    let refused = |path: &Path, cause: String| Failure::Usage(format!("--compare {}: {cause}", path.display()));
    for path in &arguments.others {
        if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
            let cause = "must be a model file (.toml): runs and tables are compared by `simulate --view --compare`";
            return Err(refused(path, cause.to_owned()));
        }
    }
    if let Some(path) = paths.get(MOST_MACHINES) {
        return Err(refused(path, format!("there can be at most {} models besides the first", MOST_MACHINES - 1)));
    }
    if !arguments.states.is_empty() && arguments.states.len() != paths.len() {
        let (states, models) = (arguments.states.len(), paths.len());
        return Err(Failure::Usage(format!(
            "--state: {states} states cannot start {models} models; give one state for each, in their order"
        )));
    }
    let mut found: Vec<(String, Plant, Interface)> = Vec::new();
    for (i, path) in paths.iter().enumerate() {
        let (machine, text) = read_model(path)?;
        let (interface, name) = (Interface::new(&machine), machine.name.clone());
        let plant = match arguments.states.get(i) {
            None => {
                let settings = if i == 0 { arguments.settings.as_slice() } else { &[] };
                let mut plant = plant_with(machine, &interface, settings)?;
                let start_s = plant.machine().experiment.start_time_s;
                let failed = |error: PlantError| match i {
                    0 => error.to_string(),
                    _ => format!("--compare {}: {error}", path.display()),
                };
                plant.initialize(start_s).map_err(|error| Failure::Simulation(failed(error)))?;
                plant
            }
            Some(state) => restored(Plant::new(Arc::new(machine)), &interface, &text, state)?,
        };
        if let Some((_, first, _)) = found.first()
            && first.time_s() != plant.time_s()
        {
            let (first_s, own_s) = (first.time_s(), plant.time_s());
            let cure = if arguments.states.is_empty() {
                "set the same start_time_s in [simulation]"
            } else {
                "save states of the same time"
            };
            return Err(refused(
                path,
                format!("starts at {own_s} s and the first model at {first_s} s, but they have one clock; {cure}"),
            ));
        }
        found.push((name, plant, interface));
    }
    let labels = labels(&found.iter().map(|(name, ..)| name.as_str()).collect::<Vec<_>>(), &paths);
    Ok(found.into_iter().zip(labels).map(|((_, plant, interface), label)| (label, plant, interface)).collect())
}

/// Names for the legend: those of the machines; of the files if machines have equal names; numbered if both are equal.
fn labels(names: &[&str], paths: &[&PathBuf]) -> Vec<String> {
    let files: Vec<_> = paths.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy()).collect();
    let alone = |list: &[&str], one: &str| list.iter().filter(|other| **other == one).count() == 1;
    let of_files: Vec<&str> = files.iter().map(AsRef::as_ref).collect();
    let label = |(i, (name, file)): (usize, (&&str, &&str))| match (alone(names, name), alone(&of_files, file)) {
        (true, _) => (*name).to_owned(),
        (false, true) => (*file).to_owned(),
        (false, false) => format!("{name} {}", i + 1),
    };
    names.iter().zip(&of_files).enumerate().map(label).collect()
}

/// Restores a plant from a saved state of its model.
fn restored(mut plant: Plant, interface: &Interface, text: &str, path: &Path) -> Result<Plant, Failure> {
    let shown = path.display();
    let refused = |cause: String| {
        Failure::Refused(format!("{shown}: {cause}; save the state again with this version and this model"))
    };
    let bytes = std::fs::read(path).map_err(|error| Failure::Files(format!("{shown}: cannot be read: {error}")))?;
    let (owner, snapshot): (String, Snapshot) =
        postcard::from_bytes(&bytes).map_err(|_| refused("is not a saved state".to_owned()))?;
    if owner != guid(text, interface.variables()) {
        return Err(refused("is the state of another model".to_owned()));
    }
    plant.restore(&snapshot).map_err(|error| refused(error.to_string()))?;
    Ok(plant)
}

/// Prints the address on standard output, and how to reach it from elsewhere; starts a browser where there is a display.
fn announce(server: &Server, session: &Session, no_browser: bool) -> Result<(), Failure> {
    let (address, port) = (server.address(), server.port());
    crate::cli::print(&address)?;
    tell::note(&format!(
        "{} is live at the address above, in steps of {} s; it ends when its page is closed, or with Ctrl-C",
        session.name(),
        session.step_s()
    ));
    if no_browser {
        return Ok(());
    }
    let elsewhere = format!(
        "open the address in a browser of this computer; from another one, first `ssh -L {port}:127.0.0.1:{port} THIS-COMPUTER`, \
         then the same address there"
    );
    if !has_display() {
        tell::note(&format!("there is no display here: {elsewhere}"));
    } else if let Err(error) = open::that_detached(&address) {
        tell::note(&format!("no browser could be started ({error}): {elsewhere}"));
    }
    Ok(())
}

/// Returns whether there is a display for a browser.
fn has_display() -> bool {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    cfg!(any(windows, target_os = "macos")) && !set("SSH_CONNECTION") || set("DISPLAY") || set("WAYLAND_DISPLAY")
}

/// Returns the statistics of the simulation as text.
fn summary_text(ended: Ended, summary: &Summary) -> String {
    let Summary { simulated_s, ran_s, lost_s, latest_s, slowest_s, steps, frames } = *summary;
    let why = match ended {
        Ended::Left => "the page was closed",
        Ended::Interrupted => "interrupted",
    };
    format!(
        "{why}: {simulated_s:.3} s simulated in {ran_s:.3} s, {lost_s:.3} s lost, at most {latest_s:.4} s late; {steps} steps, the \
         slowest {:.2} ms; {frames} frames",
        1e3 * slowest_s
    )
}

/// Registers the signals that stop the server.
#[cfg(unix)]
fn heed_signals(interrupted: &Arc<AtomicBool>) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // if this fails, the signal ends the process directly
        let _ = signal_hook::flag::register(signal, Arc::clone(interrupted));
    }
}

/// On systems without these signals, Ctrl-C ends the process directly.
#[cfg(not(unix))]
fn heed_signals(_: &Arc<AtomicBool>) {}

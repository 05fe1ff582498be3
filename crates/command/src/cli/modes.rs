//! `foldwing modes`: natural frequencies and shapes.

use crate::cli::settings::read_plant;
use crate::cli::statics::BranchOption;
use crate::cli::{Failure, print, stability};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::{Holding, ModeShape, NodeMotion, Plant, Search};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::MODES)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// State: without loads, gravity and root motion, or at rest under those that act
    #[arg(long, value_enum, default_value = "equilibrium")]
    about: About,
    /// Which equilibrium to use if the one on the load path is unstable
    #[arg(long, value_enum, default_value = "path")]
    branch: BranchOption,
    /// Number of modes
    #[arg(long, default_value_t = 10)]
    count: usize,
    /// Start value of an input or parameter, e.g. `root.angular_velocity.z=20`, `fold.release=0`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Print JSON with mode shapes for programs
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum About {
    /// No loads, gravity or root motion; joints at their start angles
    Undeformed,
    /// At rest under the loads
    Equilibrium,
}

/// Names of [`ModeShape::shares`].
const SHARES: [&str; 5] = ["stretch", "twist", "flap", "lag", "joints"];

/// Prints the modes of lowest frequency.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut plant = read_plant(&arguments.model, &arguments.settings)?;
    let time_s = plant.machine().experiment.start_time_s;
    let failed = |error: foldwing_engine::plant::PlantError| Failure::Statics(error.to_string());
    let mut departure = None;
    match arguments.about {
        About::Undeformed => plant.study().undeformed(time_s).map_err(failed)?,
        About::Equilibrium => {
            let search = Search { branch: arguments.branch.choice(), ..Search::default() };
            departure = plant.study().rest(time_s, Holding::AsReleased, search).map_err(failed)?.departure;
        }
    }
    let stability = match arguments.about {
        About::Undeformed => None,
        About::Equilibrium => Some(plant.study().stability().map_err(failed)?),
    };
    let modes = plant.study().modes(arguments.count).map_err(failed)?;
    if arguments.json {
        let mut value = as_json(&plant, &modes);
        if let Some(stability) = &stability {
            value["stability"] = stability::as_json(&plant, stability, departure);
        }
        return print(&format!("{value:#}"));
    }
    let mut text = format!(
        "{} about its {} state{}\n{:>4} {:>14} {:>10}  elastic energy\n",
        plant.machine().name,
        if arguments.about == About::Undeformed { "undeformed" } else { "equilibrium" },
        if plant.machine().air.is_some() { ", without air: its loads are held" } else { "" },
        "mode",
        "frequency Hz",
        "damping"
    );
    for (i, mode) in modes.iter().enumerate() {
        let _ = writeln!(text, "{:4} {}  {}", i + 1, frequency(mode), shares(mode));
    }
    if let Some(stability) = &stability {
        text.push_str(&stability::text(&plant, stability, departure));
    }
    print(&text)
}

/// Frequency in Hz and damping ratio; of a real pole its rate in 1/s, as it has neither. Growth is marked.
fn frequency(mode: &ModeShape) -> String {
    let mark = if mode.grows() { " UNSTABLE" } else { "" };
    if mode.is_real() && !mode.is_free() {
        return format!("{:>+14.6} 1/s, real{mark}", mode.eigenvalue_1_s.re);
    }
    let damping = if mode.damping_ratio.abs() < 5e-7 { 0.0 } else { mode.damping_ratio };
    format!("{:14.6} {damping:10.6}{mark}", mode.frequency_hz)
}

/// What bends, largest share first.
fn shares(mode: &ModeShape) -> String {
    let mut list: Vec<(f64, &str)> =
        mode.shares.iter().copied().zip(SHARES).filter(|(share, _)| *share > 5e-3).collect();
    if list.is_empty() {
        return "free motion".to_owned();
    }
    list.sort_by(|a, b| b.0.total_cmp(&a.0));
    list.iter().map(|(share, name)| format!("{name} {:.0} %", 100.0 * share)).collect::<Vec<_>>().join(", ")
}

pub(super) fn as_json(plant: &Plant, modes: &[ModeShape]) -> Value {
    let names: Vec<&str> = plant.machine().bodies.iter().map(|body| body.name.as_str()).collect();
    let bodies: Vec<Value> = names
        .iter()
        .zip(plant.shape())
        .map(|(name, sections)| {
            let sections: Vec<Value> = sections
                .iter()
                .map(|section| json!({ "place_m": section.place_m, "position_m": section.position_m.as_slice() }))
                .collect();
            json!({ "name": name, "sections": sections })
        })
        .collect();
    let nodes = |part: &Vec<Vec<NodeMotion>>| -> Vec<Value> {
        let node = |node: &NodeMotion| {
            json!({
                "displacement_m": node.displacement_m.as_slice(),
                "rotation_rad": node.rotation_rad.as_slice(),
            })
        };
        names
            .iter()
            .zip(part)
            .map(|(name, body)| json!({ "name": name, "sections": body.iter().map(node).collect::<Vec<_>>() }))
            .collect()
    };
    let modes: Vec<Value> = modes
        .iter()
        .map(|mode| {
            let shares: serde_json::Map<String, Value> =
                SHARES.iter().zip(mode.shares).map(|(name, share)| ((*name).to_owned(), share.into())).collect();
            // a real pole has neither frequency nor damping ratio
            let oscillates = |value: f64| if mode.is_real() && !mode.is_free() { Value::Null } else { value.into() };
            json!({
                "frequency_Hz": oscillates(mode.frequency_hz),
                "damping_ratio": oscillates(mode.damping_ratio),
                "grows": mode.grows(),
                "eigenvalue_1_s": [mode.eigenvalue_1_s.re, mode.eigenvalue_1_s.im],
                "energy_shares": shares,
                "shape": nodes(&mode.real),
                "shape_imaginary": nodes(&mode.imaginary),
            })
        })
        .collect();
    let without_air = plant.machine().air.is_some();
    json!({ "name": plant.machine().name, "without_air": without_air, "bodies": bodies, "modes": modes })
}

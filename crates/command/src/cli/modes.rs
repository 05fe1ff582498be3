//! `foldwing modes`: natural frequencies and mode shapes.

use crate::cli::branches::{BranchArguments, BranchTable, Varied, csv_text, write_figures};
use crate::cli::outlets::{Force, Mark, Outlets, Quiet};
use crate::cli::progress::Progress;
use crate::cli::settings::read_plant;
use crate::cli::shapes::shares;
use crate::cli::statics::BranchOption;
use crate::cli::{Failure, campbell, print, shapes, stability};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::plant::{
    Branches, Holding, JUDGED_MODES, ModeShape, NodeMotion, Plant, PlantError, Rest, SHEAR_SHARE, Search, Stability,
    energy_share_names,
};
use foldwing_study::branches::pool;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::MODES)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// State about which the modes are computed
    #[arg(long = "state", value_enum, default_value = "equilibrium")]
    about: About,
    /// Equilibrium to use if the one on the load path is unstable
    #[arg(long, value_enum, default_value = "path")]
    branch: BranchOption,
    /// Include the vortex lattice; without this option its loads are held constant
    #[arg(long, conflicts_with = "over")]
    lattice: bool,
    /// Number of modes
    #[arg(long, default_value_t = 10)]
    count: usize,
    /// Start value of an input or parameter, e.g. `root.angular_velocity.z=20`, `fold.release=0`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Track the modes over a start value, a parameter or a key of the model file (`file:…`): KEY=FROM:TO:COUNT or KEY=A,B,…;
    /// rotor_speed_rpm gives the Campbell diagram of a rotor, with frequencies in the fixed frame
    #[arg(long = "vary", value_name = "KEY=VALUES", value_parser = NonEmptyStringValueParser::new())]
    over: Option<String>,
    /// Joint that is the rotor's shaft, for --vary rotor_speed_rpm [default: the only joint that can rotate without limit and carries
    /// a hub]
    #[arg(long, value_name = "JOINT", requires = "over", value_parser = NonEmptyStringValueParser::new())]
    shaft: Option<String>,
    #[command(flatten)]
    branches: BranchArguments,
    /// HTML page with the animated mode shapes about the state: one file, no network needed
    #[arg(long, value_name = "OUT.html", conflicts_with = "over")]
    view: Option<PathBuf>,
    /// Folder for VTK files, for ParaView: a cycle of each mode in a folder of its own; open `mode_1/run.pvd`
    #[arg(long, value_name = "DIR", conflicts_with = "over")]
    vtk: Option<PathBuf>,
    /// Print JSON for programs: mode shapes, or with --vary the eigenvalues over the varied quantity
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    force: Force,
    #[command(flatten)]
    quiet: Quiet,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum About {
    /// Without loads, gravity and root motion; joints at their start angles
    Undeformed,
    /// Static equilibrium under the loads
    Equilibrium,
}

/// Prints the modes of lowest frequency.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(over) = &arguments.over {
        return run_over(arguments, over);
    }
    if arguments.branches.csv.is_some() || arguments.branches.plot.is_some() {
        return Err(Failure::Usage("--csv and --plot need --vary, which tracks modes over a quantity".to_owned()));
    }
    if arguments.lattice && arguments.about == About::Undeformed {
        return Err(Failure::Usage(
            "--lattice: the undeformed state has no loads and no aerodynamics; use --state equilibrium, or omit --lattice"
                .to_owned(),
        ));
    }
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    let view = outlets.place_if(arguments.view.as_deref(), Mark::PAGE)?;
    if let Some(folder) = &arguments.vtk {
        shapes::check_vtk(folder, arguments.count, &outlets)?;
    }
    let mut plant = read_plant(&arguments.model, &arguments.settings)?;
    let time_s = plant.machine().experiment.start_time_s;
    let failed = |error: foldwing_engine::plant::PlantError| Failure::Statics(error.to_string());
    let progress = Progress::phase("modes");
    let mut rest = None;
    match arguments.about {
        About::Undeformed => plant.study().undeformed(time_s).map_err(failed)?,
        About::Equilibrium => {
            let search = Search { branch: arguments.branch.choice(), ..Search::default() };
            rest = Some(plant.study().rest(time_s, Holding::AsReleased, search).map_err(failed)?);
        }
    }
    let bare = arguments.about == About::Undeformed;
    let (modes, stability) = match arguments.about {
        About::Undeformed => (plant.study().bare_modes(arguments.count).map_err(failed)?, None),
        About::Equilibrium => judged_modes(&mut plant, rest.as_ref(), arguments.count, arguments.lattice)
            .map(|(modes, stability)| (modes, Some(stability)))
            .map_err(failed)?,
    };
    drop(progress);
    let departure = rest.and_then(|rest| rest.departure);
    let in_lattice = arguments.lattice && !bare;
    if arguments.view.is_some() || arguments.vtk.is_some() {
        let title = title(&plant, bare, in_lattice);
        let drawn = shapes::of_modes(&plant, &modes, format!("modes {title}"));
        if arguments.view.is_some() {
            view.fill(shapes::page(&drawn)?.as_bytes())?;
        }
        if let Some(folder) = &arguments.vtk {
            shapes::write_vtk(&drawn, folder, &mut outlets)?;
        }
    }
    if arguments.json {
        let mut value = as_json(&plant, &modes, bare);
        if in_lattice {
            value["without_air"] = false.into();
        }
        if let Some(stability) = &stability {
            value["stability"] = stability::as_json(&plant, stability, departure);
        }
        return print(&format!("{value:#}"));
    }
    let mut text = format!(
        "{} {}\n{:>4} {:>14} {:>10}  elastic energy\n",
        plant.machine().name,
        title(&plant, bare, in_lattice),
        "mode",
        "frequency Hz",
        "damping"
    );
    for (i, mode) in modes.iter().enumerate() {
        let name = mode.flight.map_or(String::new(), |flight| format!("{flight}: "));
        let _ = writeln!(text, "{:4} {}  {name}{}", i + 1, frequency(mode), shares(mode));
    }
    if let Some(stability) = &stability {
        text.push_str(&stability::text(&plant, stability, departure));
    }
    print(&text)
}

/// Computes modes about an equilibrium, with the vortex lattice or with constant loads, and the stability of the equilibrium. With constant
/// loads of a lattice, stability is not evaluated.
pub(super) fn judged_modes(
    plant: &mut Plant,
    rest: Option<&Rest>,
    count: usize,
    lattice: bool,
) -> Result<(Vec<ModeShape>, Stability), PlantError> {
    if lattice {
        let (mut modes, _) = plant.study().lattice_modes_and_rest(count.max(JUDGED_MODES))?;
        let stability = plant.study().stability_in_lattice(&modes);
        modes.truncate(count);
        return Ok((modes, stability));
    }
    let stability = match rest.and_then(|rest| rest.stability.clone()) {
        Some(stability) => stability,
        None if plant.has_linear_lattice() && plant.machine().air.is_some() => Stability {
            not_judged: Some(
                "the loads of the lattice are held constant in these modes; --lattice includes their changes"
                    .to_owned(),
            ),
            ..Stability::default()
        },
        None => plant.study().stability()?,
    };
    Ok((plant.study().modes(count)?, stability))
}

/// Tracks the modes over a parameter.
fn run_over(arguments: &Arguments, over: &String) -> Result<(), Failure> {
    let mut outlets = Outlets::new(arguments.force.force, [arguments.model.as_path()]);
    if let Some(("", values)) = over.strip_prefix(campbell::KEY).and_then(|rest| rest.split_once('=')) {
        let asked = campbell::Asked {
            model: &arguments.model,
            settings: &arguments.settings,
            values,
            shaft: arguments.shaft.as_deref(),
            bare: arguments.about == About::Undeformed,
            count: arguments.count,
            branches: &arguments.branches,
            json: arguments.json,
            quiet: arguments.quiet,
        };
        return campbell::run(&asked, &mut outlets);
    }
    if arguments.shaft.is_some() {
        return Err(Failure::Usage(format!("--shaft can be used only with --vary {}=…", campbell::KEY)));
    }
    arguments.branches.check(&outlets)?;
    let varied = Varied::new(&arguments.model, &arguments.settings, Some(over))?;
    let numbers = varied.numbers()?;
    let failed = |error: foldwing_engine::plant::PlantError| Failure::Statics(error.to_string());
    let mut progress = Progress::of("values", numbers.len() as u64);
    let rises = numbers[0] < numbers[1];
    let mut done = 0;
    let mut modes_at = |value: f64| -> Result<Vec<ModeShape>, Failure> {
        // write whole numbers without decimals, for keys that need integers
        let text = if value.fract() == 0.0 && value.abs() < 1e9 { format!("{value:.0}") } else { format!("{value:?}") };
        let mut plant = varied.plant(&text)?;
        let time_s = plant.machine().experiment.start_time_s;
        match arguments.about {
            About::Undeformed => plant.study().undeformed(time_s).map_err(failed)?,
            About::Equilibrium => {
                let search = Search { branch: arguments.branch.choice(), ..Search::default() };
                plant.study().rest(time_s, Holding::AsReleased, search).map_err(failed)?;
            }
        }
        let count = pool(arguments.count);
        let modes = match arguments.about {
            About::Undeformed => plant.study().bare_modes(count).map_err(failed),
            About::Equilibrium => plant.study().modes(count).map_err(failed),
        };
        // values that are inserted for the tracking do not count as progress
        done = done.max(numbers.iter().filter(|own| if rises { **own <= value } else { **own >= value }).count());
        progress.at(done as u64);
        modes
    };
    let (mut branches, ended) = Branches::follow(&numbers, &mut modes_at);
    drop(progress);
    if let (true, Some((_, error))) = (branches.places.is_empty(), &ended) {
        return Err(Failure::Statics(format!("--vary {over}: {error}")));
    }
    branches.keep(arguments.count, &mut []);
    let name = &varied.machine().name;
    let table = BranchTable { quantity: varied.key(), unit: "", branches: &branches };
    if let Some(path) = &arguments.branches.csv {
        let text = csv_text(&table.header(None), &table.rows(None));
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    write_figures(&arguments.branches, table.figures(name, &[]), &mut outlets)?;
    let ended = ended.map(|(value, error)| (value, error.to_string()));
    if arguments.json {
        return arguments.quiet.print(&format!("{:#}", table.json(name, ended)), &outlets);
    }
    if let Some((value, error)) = ended {
        arguments.quiet.note(&format!("mode tracking ends before {} = {value}: {error}", varied.key()));
    }
    arguments.quiet.print(&format!("{name}: modes over {}\n{}", varied.key(), table.text()), &outlets)
}

/// Names the state and the aerodynamics of the modes.
pub(super) fn title(plant: &Plant, bare: bool, in_lattice: bool) -> String {
    let state = if bare { "undeformed" } else { "equilibrium" };
    let air = if in_lattice { ", with its vortex lattice" } else { air_in_words(plant, bare) };
    format!("about its {state} state{air}")
}

/// Describes the aerodynamics included in the modes; empty without aerodynamics.
pub(super) fn air_in_words(plant: &Plant, bare: bool) -> &'static str {
    match &plant.machine().air {
        None => "",
        Some(_) if bare => ", without aerodynamics",
        Some(_) if plant.air_is_linearised() => ", with aerodynamics",
        Some(_) => ", with constant aerodynamic loads",
    }
}

/// Frequency in Hz and damping ratio; for a real pole, which has neither, its rate in 1/s. Unstable modes are marked.
fn frequency(mode: &ModeShape) -> String {
    let mark = if mode.grows() { " UNSTABLE" } else { "" };
    if mode.is_real() && !mode.is_free() {
        return format!("{:>+14.6} 1/s, real{mark}", mode.eigenvalue_1_s.re);
    }
    let damping = if mode.damping_ratio.abs() < 5e-7 { 0.0 } else { mode.damping_ratio };
    format!("{:14.6} {damping:10.6}{mark}", mode.frequency_hz)
}

pub(super) fn as_json(plant: &Plant, modes: &[ModeShape], bare: bool) -> Value {
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
            let shares: serde_json::Map<String, Value> = energy_share_names()
                .into_iter()
                .zip(mode.shares)
                .enumerate()
                // shear participation is listed only for bodies with shear deformation
                .filter(|(part, (_, share))| *part != SHEAR_SHARE || *share != 0.0)
                .map(|(_, (name, share))| (name.to_owned(), share.into()))
                .collect();
            // a real pole has neither frequency nor damping ratio
            let oscillates = |value: f64| if mode.is_real() && !mode.is_free() { Value::Null } else { value.into() };
            json!({
                "frequency_Hz": oscillates(mode.frequency_hz),
                "damping_ratio": oscillates(mode.damping_ratio),
                "grows": mode.grows(),
                "eigenvalue_1_s": [mode.eigenvalue_1_s.re, mode.eigenvalue_1_s.im],
                "energy_shares": shares,
                "flight_mode": mode.flight.map(|flight| flight.to_string()),
                "shape": nodes(&mode.real),
                "shape_imaginary": nodes(&mode.imaginary),
            })
        })
        .collect();
    let without_air = plant.machine().air.is_some() && (bare || !plant.air_is_linearised());
    json!({ "name": plant.machine().name, "without_air": without_air, "bodies": bodies, "modes": modes })
}

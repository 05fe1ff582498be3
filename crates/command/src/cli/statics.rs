//! `foldwing static`: static equilibrium of the model under its loads.

use crate::cli::number::six;
use crate::cli::outlets::Quiet;
use crate::cli::progress::Progress;
use crate::cli::settings::read_plant;
use crate::cli::{Failure, print, stability};
use clap::builder::NonEmptyStringValueParser;
use foldwing_engine::machine::{Machine, Travel};
use foldwing_engine::plant::{
    Branch, Holding, JointOutputs, LoadPath, Plant, PlantError, Rest, Search, SectionShape, Stability, StaticEffort,
};
use foldwing_study::warnings::{self, Warning};
use nalgebra::Vector3;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(after_long_help = crate::cli::help::STATIC)]
pub struct Arguments {
    /// Model file
    model: PathBuf,
    /// Start value of an input or parameter, e.g. a load, gravity, `fold.release=0`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = NonEmptyStringValueParser::new())]
    settings: Vec<String>,
    /// Application of the loads
    #[arg(long, value_enum, default_value = "load")]
    path: PathOption,
    /// Equilibrium to print if the one on the load path is unstable
    #[arg(long, value_enum, default_value = "stable")]
    branch: BranchOption,
    /// Print JSON for programs
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    quiet: Quiet,
}

/// Application of the loads.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum PathOption {
    /// The whole load at once, in steps if that fails
    Load,
    /// Along the path of equilibria, through limit points; prints the points of the path
    ArcLength,
}

/// Selected equilibrium.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub enum BranchOption {
    /// A stable equilibrium, found by descent from the unstable one, with the aerodynamics included in the check of stability
    Stable,
    /// The equilibrium on the load path, stable or not; with a vortex lattice its stability is not evaluated
    Path,
}

impl BranchOption {
    /// Returns the corresponding branch of the engine.
    pub fn choice(self) -> Branch {
        match self {
            Self::Stable => Branch::Stable,
            Self::Path => Branch::Path,
        }
    }
}

/// Computes the equilibrium and prints it. Joints are locked or free according to their release inputs.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut plant = read_plant(&arguments.model, &arguments.settings)?;
    let time_s = plant.machine().experiment.start_time_s;
    let path = match arguments.path {
        PathOption::Load => LoadPath::Load,
        PathOption::ArcLength => LoadPath::ArcLength,
    };
    let search = Search { path, branch: arguments.branch.choice() };
    let failed = |error: PlantError| Failure::Statics(error.to_string());
    let progress = Progress::phase("equilibrium");
    let rest = plant.study().rest(time_s, Holding::AsReleased, search).map_err(failed)?;
    warnings_at(&plant).iter().for_each(|warning| arguments.quiet.warning(&warning.to_string()));
    if arguments.json {
        let value = rest_json(&mut plant, &rest).map_err(failed)?;
        drop(progress);
        return print(&format!("{value:#}"));
    }
    let stability = judged(&mut plant, &rest).map_err(failed)?;
    let coarseness = plant.study().coarseness();
    let mut text = as_text(&plant, rest.effort);
    text.push_str(&stability::text(&plant, &stability, rest.departure));
    if let Some(hint) = stability::coarse_hint(&plant, &coarseness) {
        let _ = writeln!(text, "{hint}");
    }
    text.push_str(&stability::path_text(&mut plant, &rest));
    drop(progress);
    print(&text)
}

/// Assumptions of the aerodynamic model that an equilibrium does not meet, and joints whose position may not be the intended one.
fn warnings_at(plant: &Plant) -> Vec<Warning> {
    warnings::air_at(plant).into_iter().chain(warnings::stall_at(plant)).chain(warnings::joints_at(plant)).collect()
}

/// Stability of an equilibrium, with aerodynamics; with a lattice, whose stability takes longer to compute than the equilibrium, only if
/// the search has evaluated it.
pub(super) fn judged(plant: &mut Plant, rest: &Rest) -> Result<Stability, PlantError> {
    if let Some(stability) = &rest.stability {
        return Ok(stability.clone());
    }
    if plant.has_linear_lattice() {
        let cause = "with a vortex lattice the branch \"path\" does not evaluate stability; use the branch \"stable\"";
        return Ok(Stability { not_judged: Some(cause.to_owned()), ..Stability::default() });
    }
    plant.study().stability()
}

/// Current equilibrium of the plant as JSON.
pub(super) fn rest_json(plant: &mut Plant, rest: &Rest) -> Result<Value, PlantError> {
    let stability = judged(plant, rest)?;
    let coarseness = plant.study().coarseness();
    let mut value = as_json(plant, rest.effort);
    value["stability"] = stability::as_json(plant, &stability, rest.departure);
    value["mesh"] = json!({
        "largest_change_of_turn_rad": coarseness.turn_rad,
        "body": plant.machine().bodies[coarseness.body].name,
        "place_m": coarseness.place_m,
        "coarse": coarseness.is_coarse(),
    });
    value["warnings"] = json!(warnings_at(plant));
    if !rest.path.is_empty() {
        value["path"] = stability::path_json(plant, rest).into();
    }
    Ok(value)
}

fn array(vector: &Vector3<f64>) -> [f64; 3] {
    [vector.x, vector.y, vector.z]
}

fn as_json(plant: &Plant, effort: StaticEffort) -> Value {
    let (machine, outputs) = (plant.machine(), plant.outputs());
    let section = |section: &SectionShape| {
        json!({
            "place_m": section.place_m,
            "position_m": array(&section.position_m),
            "rotation_rad": array(&section.rotation_vector_rad()),
            "strain": section.strain.as_slice(),
        })
    };
    let bodies: Vec<Value> = machine
        .bodies
        .iter()
        .zip(plant.shape())
        .map(|(body, sections)| json!({ "name": body.name, "sections": sections.iter().map(section).collect::<Vec<_>>() }))
        .collect();
    let joints: Vec<Value> = joints(plant)
        .map(|(travel, name, joint, latched)| {
            json!({
                "name": name,
                (travel.words("angle_rad")): joint.angle_rad,
                (travel.words("applied_torque_N_m")): joint.torque_applied_n_m,
                (travel.words("latch_torque_N_m")): joint.latch_torque_n_m,
                "latched": latched,
            })
        })
        .collect();
    let gauges: Vec<Value> = machine
        .gauges
        .iter()
        .zip(outputs.gauges())
        .map(|(gauge, strain)| json!({ "name": gauge.name, "strain": strain }))
        .collect();
    let internal_loads: Vec<Value> = machine
        .internal_loads
        .iter()
        .zip(outputs.internal_loads())
        .map(|(place, load)| {
            json!({ "name": place.name, "force_N": array(&load.force_n), "moment_N_m": array(&load.moment_n_m) })
        })
        .collect();
    let loops: Vec<Value> = machine
        .closures
        .iter()
        .zip(outputs.loops())
        .map(|(closure, output)| {
            json!({ "name": closure.name, "gap_m": array(&output.gap_m), "force_N": array(&output.force_n) })
        })
        .collect();
    let tips: Vec<Value> =
        tips(machine, plant).map(|(name, position)| json!({ "body": name, "position_m": array(&position) })).collect();
    json!({
        "name": machine.name,
        "time_s": outputs.time_s,
        "load_steps": effort.load_steps,
        "iterations": effort.iterations,
        "bodies": bodies,
        "joints": joints,
        "gauges": gauges,
        "internal_loads": internal_loads,
        "loops": loops,
        "tips": tips,
        "root": { "force_N": array(&outputs.root().force_n), "moment_N_m": array(&outputs.root().moment_n_m) },
        "energy_J": { "elastic": outputs.energy().elastic, "gravity": outputs.energy().gravity, "motor": outputs.energy().motor },
    })
}

/// Revolute and prismatic joints: type of motion, name, outputs, and whether a latch is closed.
fn joints(plant: &Plant) -> impl Iterator<Item = (Travel, &str, &JointOutputs, bool)> {
    let described = plant.machine().bodies.iter().filter_map(|body| {
        let (travel, _) = body.joint.kind.one_freedom()?;
        Some((travel, body.joint.name.as_str()))
    });
    let outputs = plant.outputs().joints().iter().zip(plant.outputs().latches());
    described.zip(outputs).map(|((travel, name), (joint, latch))| (travel, name, joint, latch.closed.is_on()))
}

fn tips<'a>(machine: &'a Machine, plant: &'a Plant) -> impl Iterator<Item = (&'a str, Vector3<f64>)> {
    let name = |&body: &usize| machine.bodies[body].name.as_str();
    plant.tip_bodies().iter().map(name).zip(plant.outputs().tips().iter().map(|tip| tip.position_m))
}

fn as_text(plant: &Plant, effort: StaticEffort) -> String {
    let (machine, outputs) = (plant.machine(), plant.outputs());
    let mut text = format!(
        "{}: static equilibrium ({} load steps, {} iterations)\n",
        machine.name, effort.load_steps, effort.iterations
    );
    for (body, sections) in machine.bodies.iter().zip(plant.shape()) {
        let _ = write!(
            text,
            "\n{}\n{:>9} {:>11} {:>11} {:>11} {:>10} {:>10} {:>10} {:>11} {:>11} {:>11} {:>11}\n",
            body.name,
            "s m",
            "x m",
            "y m",
            "z m",
            "rot x deg",
            "rot y deg",
            "rot z deg",
            "strain x",
            "kappa x 1/m",
            "kappa y 1/m",
            "kappa z 1/m"
        );
        for section in &sections {
            let (r, turn, e) = (section.position_m, section.rotation_vector_rad().map(f64::to_degrees), section.strain);
            let _ = writeln!(
                text,
                "{:9.4} {:11.6} {:11.6} {:11.6} {:10.4} {:10.4} {:10.4} {:11.3e} {:11.3e} {:11.3e} {:11.3e}",
                section.place_m,
                tidy(r.x),
                tidy(r.y),
                tidy(r.z),
                tidy(turn.x),
                tidy(turn.y),
                tidy(turn.z),
                e[0],
                e[1],
                e[2],
                e[3]
            );
        }
    }
    text.push('\n');
    for (travel, name, joint, latched) in joints(plant) {
        let (coordinate, shown_unit, unit) =
            (travel.coordinate(), travel.shown_unit(), travel.effort_unit().replace('.', "·"));
        let _ = writeln!(
            text,
            "{name}: {coordinate} {:.6} {shown_unit}, total {} {unit}, latch {} {unit}{}",
            travel.shown(joint.angle_rad),
            six(joint.torque_applied_n_m),
            six(joint.latch_torque_n_m),
            if latched { ", latched" } else { "" }
        );
    }
    for (gauge, strain) in machine.gauges.iter().zip(outputs.gauges()) {
        let _ = writeln!(text, "gauge {}: {}", gauge.name, six(*strain));
    }
    for (place, load) in machine.internal_loads.iter().zip(outputs.internal_loads()) {
        let (force, moment) = (load.force_n, load.moment_n_m);
        let _ = writeln!(
            text,
            "internal load {}: force ({}) N, moment ({}) N·m",
            place.name,
            vector(force),
            vector(moment)
        );
    }
    for (closure, output) in machine.closures.iter().zip(outputs.loops()) {
        let (gap, force) = (vector(output.gap_m), vector(output.force_n));
        let _ = writeln!(text, "loop {}: gap ({gap}) m, force ({force}) N", closure.name);
    }
    for (name, tip) in tips(machine, plant) {
        let _ = writeln!(text, "tip of {name}: {:.6} {:.6} {:.6} m", tidy(tip.x), tidy(tip.y), tidy(tip.z));
    }
    let (force, moment) = (vector(outputs.root().force_n), vector(outputs.root().moment_n_m));
    let _ = writeln!(text, "reaction on root: force ({force}) N, moment ({moment}) N·m");
    text
}

/// Formats a vector as `x, y, z`.
fn vector(v: Vector3<f64>) -> String {
    format!("{}, {}, {}", six(v.x), six(v.y), six(v.z))
}

/// Removes the sign of zeros and of values that round to zero.
fn tidy(value: f64) -> f64 {
    if value.abs() < 5e-8 { 0.0 } else { value }
}

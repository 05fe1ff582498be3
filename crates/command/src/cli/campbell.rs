//! `foldwing modes --over rotor_speed_rpm=…`: the Campbell diagram of a rotor, with its whirls named.

use crate::cli::branches::{BranchArguments, BranchTable, csv_text, numbers, pool, write_figures};
use crate::cli::outlets::{Mark, Outlets};
use crate::cli::settings::read_plant;
use crate::cli::sweep::axis;
use crate::cli::{Failure, print, tell};
use crate::report::figure::{Curve, Figure, Look};
use foldwing_engine::plant::{Branches, ModeShape, Plant, PlantError};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

/// What `--over` calls the speed of a rotor.
pub(super) const KEY: &str = "rotor_speed_rpm";
/// Multiples of the rotor's frequency in the diagram, in numbers of blades: what turns with one blade, and with all.
const PER_BLADES: [usize; 2] = [1, 2];
/// Colour of their lines.
const FAINT: [u8; 3] = [110, 122, 134];

/// What is asked for.
pub(super) struct Asked<'a> {
    /// Model file.
    pub model: &'a Path,
    /// `--set`.
    pub settings: &'a [String],
    /// Values behind the key.
    pub values: &'a str,
    /// Joint that is the shaft, if it is named.
    pub shaft: Option<&'a str>,
    /// Whether loads, gravity, root motion and air are left out; otherwise none may act.
    pub bare: bool,
    /// Number of modes.
    pub count: usize,
    /// Where they go.
    pub branches: &'a BranchArguments,
}

/// Follows the modes of the machine over the speed of its rotor, and prints them.
pub(super) fn run(asked: &Asked, outlets: &mut Outlets) -> Result<(), Failure> {
    asked.branches.check(outlets)?;
    let values =
        axis(asked.values).map_err(|cause| Failure::Usage(format!("--over {KEY}={}: {cause}", asked.values)))?;
    let speeds_rpm = numbers(KEY, &values)?;
    let mut plant = read_plant(asked.model, asked.settings)?;
    if !asked.bare {
        check_loads(&plant)?;
    }
    let time_s = plant.machine().experiment.start_time_s;
    let failed = |error: PlantError| Failure::Statics(error.to_string());
    let rotor = plant.study().rotor(time_s, asked.shaft).map_err(failed)?;
    let mut modes_at = |speed_rpm: f64| -> Result<Vec<ModeShape>, Failure> {
        plant.study().whirl_modes(time_s, &rotor, speed_rpm * PI / 30.0, pool(asked.count)).map_err(failed)
    };
    let (mut branches, ended) = Branches::follow(&speeds_rpm, &mut modes_at);
    if let (true, Some((value, error))) = (branches.places.is_empty(), &ended) {
        return Err(Failure::Statics(format!("--over {KEY}, at {value}: {error}")));
    }
    branches.keep(asked.count, &mut []);
    let name = plant.machine().name.clone();
    let table = BranchTable { quantity: KEY, unit: "", branches: &branches };
    if let Some(path) = &asked.branches.csv {
        let text = csv_text(&table.header(None), &table.rows(None));
        outlets.place(path, Mark::first_line(&text))?.fill(&text)?;
    }
    let mut figures = table.figures(&name, &[]);
    if let Some((_, mut diagram)) = figures.iter().position(|(stem, _)| *stem == "frequency").map(|i| figures.remove(i))
    {
        add_multiples(&mut diagram, rotor.blades(), &speeds_rpm);
        diagram.title = format!("{name}: Campbell diagram");
        diagram.x_label = "rotor speed (rpm)".to_owned();
        figures.push(("campbell", diagram));
    }
    write_figures(asked.branches, figures, outlets)?;
    if let Some((value, error)) = ended {
        tell::note(&format!("the modes end before {KEY} = {value}: {error}"));
    }
    let mut text =
        format!("{name}: modes over the speed of its rotor, as the ground sees them, without air\n{}", table.text());
    for branch in 0..branches.places.first().map_or(0, |place| place.modes.len()) {
        let list = table.motions(branch);
        let words: Vec<String> = match &list[..] {
            [(_, only)] => vec![only.clone()],
            _ => list.iter().map(|(at, name)| format!("from {at} rpm {name}")).collect(),
        };
        let _ = writeln!(text, "mode {}: {}", branch + 1, words.join(", "));
    }
    print(&text)
}

/// Lines of the rotor's own frequency and of its multiples in a Campbell diagram.
fn add_multiples(diagram: &mut Figure, blades: usize, speeds_rpm: &[f64]) {
    let highest = diagram.curves.iter().flat_map(|curve| &curve.points).map(|point| point[1]).fold(0.0, f64::max);
    let last = speeds_rpm.iter().fold(0.0f64, |last, speed| last.max(speed.abs()));
    for multiple in std::iter::once(1).chain(PER_BLADES.map(|times| times * blades)) {
        let per_rpm = multiple as f64 / 60.0;
        // lines end where they leave what the modes need
        let end = if per_rpm * last > highest { highest / per_rpm } else { last };
        let first = speeds_rpm.iter().fold(f64::INFINITY, |first, speed| first.min(speed.abs()));
        if end > first {
            let points = vec![[first, per_rpm * first], [end, per_rpm * end]];
            diagram.curves.insert(0, Curve { name: format!("{multiple}P"), colour: FAINT, look: Look::Dashed, points });
        }
    }
}

/// Refuses what keeps a rotor that turns from being steady: gravity, the root's motion, loads, air.
fn check_loads(plant: &Plant) -> Result<(), Failure> {
    let refused = |what: String| {
        Err(Failure::Statics(format!(
            "--over {KEY}: {what}: a rotor that turns is then never steady; --about undeformed leaves gravity, root motion, loads and air out"
        )))
    };
    if plant.machine().air.is_some() {
        return refused("the model has [aerodynamics], whose loads on a rotor are not linearised".to_owned());
    }
    let root = plant.inputs().root();
    let vectors = [
        ("gravity", root.gravity_m_s2, "m/s²"),
        ("root.acceleration", root.acceleration_m_s2, "m/s²"),
        ("root.angular_velocity", root.angular_velocity_rad_s, "rad/s"),
        ("root.angular_acceleration", root.angular_acceleration_rad_s2, "rad/s²"),
    ];
    for (name, vector, unit) in vectors {
        for (axis, value) in ["x", "y", "z"].iter().zip(vector.iter()) {
            if *value != 0.0 {
                return refused(format!("{name}.{axis} is {value} {unit}"));
            }
        }
    }
    if plant.inputs().stations().iter().any(|load| load.force_n.norm() + load.moment_n_m.norm() != 0.0) {
        return refused("a load station carries a load".to_owned());
    }
    Ok(())
}

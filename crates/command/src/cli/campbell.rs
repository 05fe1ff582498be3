//! `foldwing modes --vary rotor_speed_rpm=…`: the Campbell diagram of a rotor, with its whirls named.

use crate::cli::branches::{BranchArguments, BranchTable, csv_text, numbers, write_figures};
use crate::cli::outlets::{Mark, Outlets};
use crate::cli::settings::{plant_with, read_plant};
use crate::cli::sweep::axis;
use crate::cli::{Failure, print, tell};
use crate::report::figure::{Curve, Figure, Look};
use foldwing_engine::plant::{Branches, ModeShape, OutputSet, Plant, PlantError, Rotor, Settled, Turn};
use foldwing_fmi::interface::Interface;
use foldwing_study::branches::pool;
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

/// What `--vary` calls the speed of a rotor.
pub(super) const KEY: &str = "rotor_speed_rpm";
/// Multiples of the rotor's frequency in the diagram, in numbers of blades: what turns with one blade, and with all.
const PER_BLADES: [usize; 2] = [1, 2];
/// Colour of their lines.
const FAINT: [u8; 3] = [110, 122, 134];

/// What the transformation to the ground says where coefficients change with the azimuth.
const ANISOTROPIC: &str = "the rotor is not isotropic";
/// Steps of a turn, of which those of the fourth order leave 4e-6 of a frequency with 24 of them in a period.
const STEPS: usize = 720;
/// Distance of the ends of a turn at which it is closed: modes are found by differences of 1e-4.
const ACCURACY: f64 = 1e-8;
/// Maximum number of directions of the modes.
const DIRECTIONS: usize = 120;

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
    /// Whether loads, gravity, root motion and air are left out; otherwise, where any acts, the state is a periodic motion.
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
        axis(asked.values).map_err(|cause| Failure::Usage(format!("--vary {KEY}={}: {cause}", asked.values)))?;
    let speeds_rpm = numbers(KEY, &values)?;
    let mut plant = read_plant(asked.model, asked.settings)?;
    let time_s = plant.machine().experiment.start_time_s;
    let failed = |error: PlantError| Failure::Statics(error.to_string());
    let disturbed = if asked.bare { None } else { disturbance(&plant) };
    let rotor = plant.study().rotor(time_s, asked.shaft);
    let blades = rotor.as_ref().map_or(1, Rotor::blades);
    let mut reason = disturbed;
    let (mut branches, ended) = loop {
        if reason.is_some() {
            break Branches::follow(&speeds_rpm, &mut |speed_rpm| beside_motion(&plant, asked, speed_rpm));
        }
        let rotor = rotor.as_ref().map_err(|error| Failure::Statics(error.to_string()))?;
        let mut modes_at = |speed_rpm: f64| -> Result<Vec<ModeShape>, Failure> {
            plant.study().whirl_modes(time_s, rotor, speed_rpm * PI / 30.0, pool(asked.count)).map_err(failed)
        };
        let (branches, ended) = Branches::follow(&speeds_rpm, &mut modes_at);
        match &ended {
            // the equations have coefficients that change with the azimuth
            Some((_, error))
                if !asked.bare && branches.places.is_empty() && error.to_string().contains(ANISOTROPIC) =>
            {
                reason = Some("the rotor is not isotropic".to_owned());
            }
            _ => break (branches, ended),
        }
    };
    if let (true, Some((value, error))) = (branches.places.is_empty(), &ended) {
        return Err(Failure::Statics(format!("--vary {KEY}, at {value}: {error}")));
    }
    if let Some(reason) = &reason {
        tell::note(&format!(
            "{reason}: the state is a motion that every turn repeats, and the modes are those beside it, by Floquet's theory, with the shaft \
             held at its speed"
        ));
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
        add_multiples(&mut diagram, blades, &speeds_rpm);
        diagram.title = format!("{name}: Campbell diagram");
        diagram.x_label = "rotor speed (rpm)".to_owned();
        figures.push(("campbell", diagram));
    }
    write_figures(asked.branches, figures, outlets)?;
    if let Some((value, error)) = ended {
        tell::note(&format!("the modes end before {KEY} = {value}: {error}"));
    }
    let how = match (&reason, &plant.machine().air) {
        (None, _) => "without air",
        (Some(_), None) => "beside the motion that every turn repeats",
        (Some(_), Some(_)) => "beside the motion that every turn repeats, in air",
    };
    let mut text =
        format!("{name}: modes over the speed of its rotor, as the ground sees them, {how}\n{}", table.text());
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

/// Modes beside the motion that every turn repeats, NOTATION eqs. (L32) to (L35), as the ground sees them.
fn beside_motion(plant: &Plant, asked: &Asked, speed_rpm: f64) -> Result<Vec<ModeShape>, Failure> {
    let failed = |error: PlantError| Failure::Statics(error.to_string());
    let (machine, turn) = Turn::of(plant.machine(), asked.shaft, Some(speed_rpm * PI / 30.0), STEPS)
        .map_err(|cause| Failure::Statics(format!("no periodic motion: {cause}")))?;
    let interface = Interface::new(&machine);
    let mut turning = plant_with(machine, &interface, asked.settings)?;
    turning.watch(OutputSet::NONE);
    turning.initialize(plant.machine().experiment.start_time_s).map_err(failed)?;
    let motion = match turning.settle(&turn, ACCURACY).map_err(failed)? {
        Settled::Periodic(motion) => motion,
        // such a state is a motion too
        Settled::Steady => turning.periodic(&turn, ACCURACY).map_err(failed)?,
    };
    let floquet = turning.floquet(&turn, &motion, DIRECTIONS).map_err(failed)?;
    let mut list: Vec<ModeShape> = floquet.modes.into_iter().map(ModeShape::of_floquet).collect();
    list.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    list.truncate(pool(asked.count));
    Ok(list)
}

/// What keeps a rotor that turns from being steady: gravity, the root's motion, loads, air.
fn disturbance(plant: &Plant) -> Option<String> {
    if plant.machine().air.is_some() {
        return Some("the model has [aerodynamics]".to_owned());
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
                return Some(format!("{name}.{axis} is {value} {unit}"));
            }
        }
    }
    let loaded = plant.inputs().stations().iter().any(|load| load.force_n.norm() + load.moment_n_m.norm() != 0.0);
    loaded.then(|| "a load station carries a load".to_owned())
}

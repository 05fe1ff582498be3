//! `--view` and `--vtk` of modes: pictures of mode shapes about an equilibrium, over a range of wind speeds and about a periodic motion.

use crate::cli::Failure;
use crate::cli::outlets::{Mark, Outlets};
use crate::report::recording::{Frame, Scene};
use crate::report::shapes::{DrawnMode, DrawnState, Shapes, changes_of, displaced, state_of};
use crate::report::viewer::{PackedModes, page_of_modes};
use crate::report::vtk;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{
    FloquetMode, ModeShape, OutputSet, Plant, PlantError, SAMPLES, Snapshot, Turn, energy_share_names,
};
use foldwing_fmi::interface::Interface;
use foldwing_study::flutter::{self, Flutter, FlutterError, sweep_with};
use foldwing_study::periodic::{self, Periodic};
use foldwing_study::values::plant_with;
use foldwing_study::watch::Watch;
use nalgebra::Complex;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

/// Frames per cycle in the VTK files of a mode.
pub(super) const CYCLE: usize = 24;

/// Converts a mode about the current state of a plant to drawable form, at amplitude 1.
fn drawn(number: usize, mode: &ModeShape, plant: &Plant, (scene, frame): (&Scene, &Frame)) -> DrawnMode {
    let name = mode.flight.map_or(String::new(), |flight| format!("{flight}: "));
    let raw = DrawnMode {
        number,
        eigenvalue_1_s: mode.eigenvalue_1_s,
        exponent_1_s: mode.eigenvalue_1_s,
        grows: mode.grows(),
        words: name + &shares(mode),
        changes: vec![changes_of(scene, plant, &mode.coordinates)],
        largest_m: 0.0,
        largest_rad: 0.0,
    };
    raw.scaled(scene, std::slice::from_ref(frame))
}

/// Shapes of modes about the current state of a plant.
pub(super) fn of_modes(plant: &Plant, modes: &[ModeShape], title: String) -> Shapes {
    let scene = Scene::of(plant);
    let frame = state_of(&scene, plant);
    let modes = modes.iter().enumerate();
    let modes = modes.map(|(i, mode)| Some(drawn(i + 1, mode, plant, (&scene, &frame)))).collect();
    let state = DrawnState { value: 0.0, words: String::new(), frames: vec![frame], period_s: None, modes };
    Shapes { scene, title, quantity: None, states: vec![state] }
}

/// Result of a sweep over the wind speed, with the states at its speeds.
pub(super) struct Seen {
    /// Flutter and divergence of the sweep.
    pub found: Flutter,
    /// States; the key is the bit pattern of the speed in m/s.
    states: BTreeMap<u64, Snapshot>,
}

/// Sweeps over the wind speed and stores the states.
pub(super) fn sweep_seen(
    plant: Plant,
    options: &flutter::Options,
    watch: &mut Watch<'_>,
) -> Result<Seen, FlutterError> {
    let mut states = BTreeMap::new();
    let mut seen = |wind_m_s: f64, plant: &Plant| {
        states.insert(wind_m_s.to_bits(), plant.snapshot());
    };
    let found = sweep_with(plant, options, &mut seen, watch)?;
    Ok(Seen { found, states })
}

/// Modes versus wind speed: all modes at the speeds of the table, and the modes that become unstable or stable at their crossing speeds.
/// `plant` is another plant of the same model.
pub(super) fn of_flutter(mut plant: Plant, seen: &Seen) -> Result<Shapes, PlantError> {
    let Flutter { branches, crossings, .. } = &seen.found;
    let scene = Scene::of(&plant);
    let mut states = Vec::new();
    let mut add = |wind_m_s: f64, words: String, modes: Vec<Option<&ModeShape>>| -> Result<(), PlantError> {
        let Some(snapshot) = seen.states.get(&wind_m_s.to_bits()) else { return Ok(()) };
        if modes.iter().all(Option::is_none) {
            return Ok(());
        }
        plant.restore(snapshot)?;
        let frame = state_of(&scene, &plant);
        let one = |(i, mode): (usize, Option<&ModeShape>)| Some(drawn(i + 1, mode?, &plant, (&scene, &frame)));
        let modes = modes.into_iter().enumerate().map(one).collect();
        states.push(DrawnState { value: wind_m_s, words, frames: vec![frame], period_s: None, modes });
        Ok(())
    };
    for place in &branches.places {
        add(place.at, String::new(), place.modes.iter().map(Option::as_ref).collect())?;
    }
    let tracked = seen.found.modes_tracked();
    for crossing in crossings.iter().filter(|crossing| !crossing.mode.is_real()) {
        let modes = (0..tracked).map(|i| (i == crossing.branch).then_some(&crossing.mode)).collect();
        let what = if crossing.begins { "flutter of" } else { "no flutter beyond of" };
        add(crossing.at, format!("{what} mode {}", crossing.branch + 1), modes)?;
    }
    states.sort_by(|a, b| a.value.total_cmp(&b.value));
    let title = "aeroelastic modes versus wind speed, about the equilibrium at each speed".to_owned();
    Ok(Shapes { scene, title, quantity: Some(["wind speed", "m/s"]), states })
}

/// Floquet modes about a periodic motion, computed with these options, over one revolution.
pub(super) fn of_periodic(machine: &Machine, options: &periodic::Options, found: &Periodic) -> Result<Shapes, Failure> {
    let failed = |error: PlantError| Failure::Statics(error.to_string());
    let speed_rad_s = Some(found.turn.speed_rad_s);
    let (machine, turn) =
        Turn::of(machine, options.shaft.as_deref(), speed_rad_s, options.steps).map_err(Failure::Statics)?;
    let interface = Interface::new(&machine);
    let mut plant =
        plant_with(machine, &interface, &options.settings).map_err(|error| Failure::Statics(error.to_string()))?;
    plant.watch(OutputSet::NONE);
    plant.initialize(plant.machine().experiment.start_time_s).map_err(failed)?;
    let scene = Scene::of(&plant);
    let floquet = found.floquet.iter().flat_map(|floquet| &floquet.modes).take(options.count);
    let floquet: Vec<&FloquetMode> = floquet.collect();
    let mut frames = Vec::new();
    let mut changes = vec![Vec::new(); floquet.len()];
    let mut seen = |sample: usize, plant: &mut Plant| {
        plant.provide(OutputSet::ALL);
        frames.push(state_of(&scene, plant));
        if sample < SAMPLES {
            for (mode, changes) in floquet.iter().zip(&mut changes) {
                changes.push(changes_of(&scene, plant, mode.motion[sample].as_slice()));
            }
        }
        Ok(())
    };
    plant.trace(&turn, &found.motion, &mut seen).map_err(failed)?;
    let modes = floquet.iter().zip(changes).enumerate().map(|(i, (mode, changes))| {
        let shown = mode.parts.iter().take(3).filter(|part| part.share > 5e-3);
        let parts: Vec<String> = shown.map(|part| format!("{part} {:.0} %", 100.0 * part.share)).collect();
        let raw = DrawnMode {
            number: i + 1,
            eigenvalue_1_s: mode.exponent_1_s,
            exponent_1_s: mode.principal_1_s,
            grows: mode.is_growing(),
            words: parts.join(", "),
            changes,
            largest_m: 0.0,
            largest_rad: 0.0,
        };
        Some(raw.scaled(&scene, &frames))
    });
    let modes = modes.collect();
    let title = format!("Floquet modes about the periodic motion at {} rpm", (1e6 * found.speed_rpm()).round() / 1e6);
    let state = DrawnState { value: 0.0, words: String::new(), frames, period_s: Some(turn.period_s()), modes };
    Ok(Shapes { scene, title, quantity: None, states: vec![state] })
}

/// Returns the page of modes as HTML.
///
/// # Errors
/// A model without modes.
pub(super) fn page(shapes: &Shapes) -> Result<String, Failure> {
    if shapes.states.iter().all(|state| state.modes.iter().all(Option::is_none)) {
        return Err(none(&shapes.scene.name));
    }
    Ok(page_of_modes(&shapes.scene.name, &PackedModes::new(shapes)))
}

/// Error for a model without modes.
pub(super) fn none(name: &str) -> Failure {
    Failure::Statics(format!(
        "{name}: no modes to draw: no part can move, or --count is 0; release a joint, add elements, or raise --count"
    ))
}

/// Name of the folder of a mode for its VTK files.
fn folder_of(number: usize) -> String {
    format!("mode_{number}")
}

/// Fails before any computation if a VTK file of the first `count` modes exists that Foldwing did not write.
pub(super) fn check_vtk(folder: &Path, count: usize, outlets: &Outlets) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| Failure::writing(&folder.display().to_string(), &error))?;
    for number in 1..=count {
        let own = folder.join(folder_of(number));
        if !own.exists() {
            continue;
        }
        outlets.check(&own.join("run.pvd"), &Mark::VTK)?;
        for name in vtk::SERIES {
            outlets.check(&own.join(format!("{name}.pvd")), &Mark::VTK)?;
            outlets.check(&own.join(format!("{name}_0000.vtu")), &Mark::VTK)?;
        }
    }
    Ok(())
}

/// Writes one cycle of each mode of the first state as VTK files, at amplitude 1, in a separate folder for each mode.
pub(super) fn write_vtk(shapes: &Shapes, folder: &Path, outlets: &mut Outlets) -> Result<(), Failure> {
    let Some(state) = shapes.states.first() else { return Ok(()) };
    let modes: Vec<&DrawnMode> = state.modes.iter().flatten().collect();
    if modes.is_empty() {
        return Err(none(&shapes.scene.name));
    }
    let base = &state.frames[0];
    for mode in modes {
        let frames = cycle(&shapes.scene, base, mode);
        let own = folder.join(folder_of(mode.number));
        vtk::files_about(&shapes.scene, &frames, base, |name, text| {
            outlets.place(&own.join(name), Mark::VTK)?.fill(text.as_bytes())
        })?;
    }
    Ok(())
}

/// One cycle of a mode with constant amplitude; a mode that does not oscillate is shown as an oscillation with a period of 1 s.
fn cycle(scene: &Scene, base: &Frame, mode: &DrawnMode) -> Vec<Frame> {
    let rate_rad_s = mode.exponent_1_s.im.abs();
    let rate_rad_s = if rate_rad_s > 0.0 { rate_rad_s } else { TAU };
    let frame = |k: usize| {
        let phase_rad = TAU * k as f64 / CYCLE as f64;
        let factor = Complex::from_polar(1.0, phase_rad);
        let mut frame = displaced(scene, base, &mode.changes[0], factor, Complex::new(0.0, rate_rad_s));
        frame.time_s = phase_rad / rate_rad_s;
        frame
    };
    (0..CYCLE).map(frame).collect()
}

/// Types of deformation, largest participation first.
pub(super) fn shares(mode: &ModeShape) -> String {
    let mut list: Vec<(f64, &str)> =
        mode.shares.iter().copied().zip(energy_share_names()).filter(|(share, _)| *share > 5e-3).collect();
    if list.is_empty() {
        return "free motion".to_owned();
    }
    list.sort_by(|a, b| b.0.total_cmp(&a.0));
    list.iter().map(|(share, name)| format!("{name} {:.0} %", 100.0 * share)).collect::<Vec<_>>().join(", ")
}

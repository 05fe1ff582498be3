//! Gradients of runs with rotors, against each other and against differences of runs with the same steps.

use super::modal::plate;
use super::*;
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::rotor::bem::RotorFeatures;
use crate::aero::rotor::options::PitchRate;
use crate::aero::rotor::turbulence_box::TurbulenceBox;
use crate::aero::rotor::wind::{Source, WindField};
use crate::machine::Coupling;
use crate::machine::builder::RotorSettings;
use crate::machine::failure::FrictionBrake;
use crate::system::RotorLoads;
use nalgebra::{Matrix3, Vector3};
use std::mem::offset_of;

/// Numbers of a rotor of two blades.
#[derive(Clone, Copy)]
struct Turning {
    wind: f64,
    across: f64,
    density: f64,
    chord: f64,
    pitch: f64,
    command: f64,
    speed: f64,
    inertia: f64,
    damping: f64,
    length: f64,
    thickness: f64,
    fail_s: f64,
    brake: f64,
    catch: f64,
}

/// A number and its place.
type TurningPlace = (&'static str, fn(&mut Turning) -> &mut f64);

const WIND: TurningPlace = ("wind", |n| &mut n.wind);
const DENSITY: TurningPlace = ("density", |n| &mut n.density);
const CHORD: TurningPlace = ("chord", |n| &mut n.chord);
const PITCH: TurningPlace = ("pitch", |n| &mut n.pitch);
const COMMAND: TurningPlace = ("command", |n| &mut n.command);
const SPEED: TurningPlace = ("speed", |n| &mut n.speed);
const INERTIA: TurningPlace = ("inertia", |n| &mut n.inertia);
const DAMPING: TurningPlace = ("damping", |n| &mut n.damping);
const LENGTH: TurningPlace = ("length", |n| &mut n.length);
const THICKNESS: TurningPlace = ("thickness", |n| &mut n.thickness);
const FAIL_S: TurningPlace = ("fail_s", |n| &mut n.fail_s);
const BRAKE: TurningPlace = ("brake", |n| &mut n.brake);
const CATCH: TurningPlace = ("catch", |n| &mut n.catch);

/// Parts of the machine.
#[derive(Clone, Default)]
struct Has {
    flexible: bool,
    /// Blades in mode shapes instead of beams, if they are flexible.
    modal: bool,
    /// Blades on pitch bearings with motors, the first with a latch.
    pitching: bool,
    /// A brake that is applied on the shaft within an aerodynamic step.
    brake: bool,
    /// Three blades on flapping hinges.
    flapping: bool,
    /// A symmetric section.
    symmetric: bool,
    /// The staggered coupling.
    staggered: bool,
    /// All results, not only some of each kind.
    all_results: bool,
    /// Factors of the winds along the shaft and across it, without vertical wind.
    wind: Option<[f64; 2]>,
    features: Option<fn(&mut RotorFeatures)>,
    /// Angle in degrees between the rows of the polar.
    rows_deg: i32,
}

/// A section that stalls at 14°.
fn polar(rows_deg: i32, symmetric: bool) -> Polar {
    let no_lift_rad = if symmetric { 0.0 } else { -0.05 };
    let row = |index: i32| {
        let angle_rad = f64::from(rows_deg * index).to_radians();
        let attached = 1.0 / (1.0 + ((angle_rad.abs() - 0.24) / 0.04).exp());
        PolarRow {
            angle_rad,
            lift: attached * 2.0 * PI * (angle_rad - no_lift_rad).sin()
                + (1.0 - attached) * 1.1 * (2.0 * angle_rad).sin(),
            drag: 0.01 + 1.3 * angle_rad.sin().powi(2),
            moment: -0.05 * attached,
        }
    };
    Polar { rows: (-180 / rows_deg..=180 / rows_deg).map(row).collect() }
}

impl Turning {
    const USUAL: Self = Self {
        wind: 9.0,
        across: 1.5,
        density: 1.2,
        chord: 0.5,
        pitch: -2.0,
        command: 0.06,
        speed: 8.0,
        inertia: 30.0,
        damping: 60.0,
        length: 5.4,
        thickness: 0.06,
        fail_s: 0.0613,
        brake: 400.0,
        catch: 0.021,
    };

    fn machine(self, has: &Has) -> Result<Machine, String> {
        let mut settings = RotorSettings::on("hub", 0.6);
        settings.polars = vec![("foil".to_owned(), polar(has.rows_deg, has.symmetric))];
        if let Some(set) = has.features {
            set(&mut settings.features);
        }
        let ([along, across], vertical_m_s) = has.wind.map_or(([1.0; 2], 0.3), |wind| (wind, 0.0));
        let air = Air::rotor(settings)
            .density_kg_m3(self.density)
            .wind_m_s([along * self.wind, across * self.across, vertical_m_s])
            .step_s(8e-3)
            .coupling(match has.staggered {
                true => Coupling::Staggered,
                false => Coupling::Iterated { tolerance: 1e-12, most_iterations: 200 },
            });
        let drag = Motor { damping_n_m_s_rad: self.damping, ..Motor::default() };
        let hub = Body::rigid("hub").inertia(50.0, [0.0; 3], Matrix3::from_diagonal_element(self.inertia));
        let shaft = Joint::revolute("shaft", [1.0, 0.0, 0.0]).motor(drag).start_rate_rad_s(self.speed);
        let mut builder =
            Machine::builder("Turning").gravity_m_s2([0.0, 0.0, -9.81]).air(air).body(hub, shaft).solver(solver());
        if has.flexible && !has.modal {
            builder = builder.gauge(Gauge::on("root", "blade0", 0.3).z_m(0.02));
        }
        let blades = if has.flapping { 3 } else { 2 };
        for blade in 0..blades {
            let angle = 2.0 * PI * f64::from(blade) / f64::from(blades);
            let name = format!("blade{blade}");
            let along = Vector3::new(0.04, -angle.sin(), angle.cos()).normalize();
            let ahead = Vector3::x().cross(&along).normalize();
            let mount = Matrix3::from_columns(&[along, ahead, along.cross(&ahead)]);
            let body = match has.flexible {
                true if has.modal => Body::modal(&name, plate(self.length, [0.3, self.thickness], 600.0, 0.01)),
                true => {
                    let material = Material { youngs_modulus_pa: 4e9, shear_modulus_pa: 1.5e9, density_kg_m3: 600.0 };
                    Body::beam(&name, self.length, Solid::rectangle(0.3, self.thickness, material))
                        .elements(2)
                        .stiffness_damping_s(1e-3)
                }
                false => Body::rigid(&name).inertia(
                    40.0,
                    [0.45 * self.length, 0.0, 0.0],
                    Matrix3::from_diagonal(&Vector3::new(1.0, 90.0, 91.0)),
                ),
            };
            let joint = match has.pitching {
                true => {
                    let motor = Motor {
                        stiffness_n_m_rad: 900.0,
                        damping_n_m_s_rad: 20.0,
                        command_rad: self.command,
                        inertia_kg_m2: 0.4,
                        ..Motor::default()
                    };
                    let bearing = Joint::revolute(format!("pitch{blade}"), [1.0, 0.0, 0.0]).motor(motor);
                    if blade == 0 {
                        bearing.latch(Latch::with_stiffness_n_m_rad(4e3).angle_rad(self.catch).capture_rad(0.004))
                    } else {
                        bearing
                    }
                }
                false if has.flapping => {
                    let hinge = Motor { stiffness_n_m_rad: 2e4, damping_n_m_s_rad: 100.0, ..Motor::default() };
                    Joint::revolute(format!("flap{blade}"), [0.0, 1.0, 0.0]).motor(hinge)
                }
                false => Joint::clamped(format!("root{blade}")),
            };
            let stations_m = [0.0, 0.28, 0.55, 0.8, 1.0].map(|share| share * self.length).to_vec();
            let surface = LiftingSurface::on(&name, 4)
                .blade(stations_m, vec!["foil".to_owned(); 5])
                .chord_m(Along::constant(self.chord))
                .elastic_axis_fraction(0.3)
                .incidence_deg(Along::constant(self.pitch));
            let surface = if has.flexible { surface } else { surface.length_m(self.length) };
            builder = builder.body(body, joint.on("hub").offset_m(along * 0.6).mount(mount)).surface(surface);
        }
        let mut machine = builder.build().map_err(|refused| refused.to_string())?;
        if has.brake {
            let brake = FrictionBrake { torque_n_m: self.brake, ramp_s: 0.02, slip_rad_s: 0.3 };
            let (effect, at_time_s) = (Effect::BrakeApplied { body: 0, brake }, Some(self.fail_s));
            let name = "stops".to_owned();
            machine.failures.push(Failure { name, effect, at_time_s, after: None, when: None, delay_s: 0.0 });
        }
        Ok(machine)
    }

    fn beside((_, place): TurningPlace, shift: f64) -> Self {
        let mut numbers = Self::USUAL;
        *place(&mut numbers) += shift;
        numbers
    }
}

fn size_of(place: TurningPlace) -> f64 {
    (*(place.1)(&mut { Turning::USUAL })).abs()
}

/// Speed and angle of the shaft, gauge and tip of the first blade, energy, force of the air, reaction of the root, power coefficient and thrust
/// of the rotor; at both times. With all results: all loads and coefficients, both energy accounts, means of its power and the reaction, and a
/// mean square of its torque.
fn turning_results(plant: &Plant, has: &Has) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let mut indices = vec![
        layout.joints.place(0, 0),
        layout.joints.place(0, 0) + 1,
        layout.energy.place(0, 0),
        layout.air_total.place(0, 0),
        layout.air_total.place(0, 0) + 3,
        layout.root.place(0, 0) + 3,
    ];
    if has.flexible {
        indices.extend((!has.modal).then(|| layout.gauges.place(0, 0)));
        indices.push(layout.tips.place(1, 0));
    }
    if has.pitching {
        indices.push(layout.joints.place(1, 0));
    }
    let rotor = |offset: usize| layout.rotor.place(0, offset);
    if !has.all_results {
        indices.extend([offset_of!(RotorLoads, power_coefficient), offset_of!(RotorLoads, thrust_n)].map(rotor));
    }
    let outputs = (0..2).flat_map(|time| indices.iter().map(move |index| RunResult::Output { index: *index, time }));
    let outputs: Vec<RunResult> = outputs.collect();
    if !has.all_results {
        return outputs;
    }
    let mean = |index: usize, time: usize, square: bool| RunResult::Mean { index, time, square };
    let means = [
        mean(rotor(offset_of!(RotorLoads, power_w)), 0, false),
        mean(rotor(offset_of!(RotorLoads, torque_n_m)), 1, true),
        mean(layout.root.place(0, 0) + 3, 1, false),
    ];
    let last = layout.rotor.range().chain(layout.accounts()).map(|index| RunResult::Output { index, time: 1 });
    outputs.into_iter().chain(last).chain(means).collect()
}

/// Disagreement of forward and adjoint, and of forward and differences.
fn compare_turning(has: &Has, times_s: &[f64], places: &[TurningPlace]) -> (f64, f64, usize) {
    let machine = |numbers: Turning| numbers.machine(has).unwrap_or_else(|error| panic!("{error}"));
    let mut plant = started(machine(Turning::USUAL));
    let tape = plant.run_on_tape(times_s).unwrap_or_else(|error| panic!("{error}"));
    let events = tape.crossings_s().count();
    let mut results = turning_results(&plant, has);
    if events > 0 {
        results.push(RunResult::LatchTime { joint: 1 });
    }
    let parameter = |place: &TurningPlace| {
        let machine = |shift: f64| plant_of(Turning::beside(*place, shift).machine(has));
        Parameter::new(place.0, 0.0, 1e-3 * size_of(*place), machine).unwrap_or_else(|error| panic!("{error}"))
    };
    let parameters = places.iter().map(parameter).collect();
    let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let adjoint: Vec<Vec<f64>> =
        results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();
    let own = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    let run = |numbers: Turning| {
        let mut plant = started(machine(numbers));
        let mut copy = plant.run_along(&tape, &InputRows::default()).unwrap_or_else(|error| panic!("{error}"));
        for time_s in times_s {
            plant.request(&mut copy, *time_s).unwrap_or_else(|error| panic!("{error}"));
        }
        let pieces = plant.pieces_on_tape(&copy);
        let mut gradient = Gradient::new(&mut plant, &copy, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
        (gradient.values(&results).unwrap_or_else(|error| panic!("{error}")), pieces)
    };
    let (same, pieces) = run(Turning::USUAL);
    same_values(&own, &same);
    let mut known = vec![vec![0.0; places.len()]; results.len()];
    for (column, place) in places.iter().enumerate() {
        // small enough that no section passes a row of its polar
        let found = [1e-3, 3e-4, 1e-4, 3e-5, 1e-5].into_iter().find(|share| {
            let step = share * size_of(*place);
            known.iter_mut().for_each(|row| row[column] = 0.0);
            [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)].into_iter().all(|(steps, weight)| {
                let (values, there) = run(Turning::beside(*place, steps * step));
                for (row, value) in known.iter_mut().zip(values) {
                    row[column] += weight / (12.0 * step) * value;
                }
                there == pieces
            })
        });
        assert!(found.is_some(), "{}: no difference on the same pieces", place.0);
    }
    let places: Vec<(&str, f64)> = places.iter().map(|place| (place.0, size_of(*place))).collect();
    let [both, differences] = disagreements((&results, &own), &places, [&forward, &adjoint, &known]);
    (both, differences, events)
}

fn agree(words: &str, has: &Has, places: &[TurningPlace], has_events: bool) {
    let (both, differences, events) = compare_turning(has, &[0.0583, 0.1213], places);
    println!("{words}: {both:.1e} {differences:.1e}");
    assert_eq!(events > 0, has_events, "{words}: {events} events");
    assert!(both < 1e-10, "{words}: {both:.1e}");
    assert!(differences < 1e-6, "{words}: {differences:.1e}");
}

/// All numbers of a rotor with rigid blades.
const RIGID: [TurningPlace; 8] = [WIND, DENSITY, CHORD, PITCH, SPEED, INERTIA, DAMPING, LENGTH];

/// GR-88: rigid blades in oblique wind, by wind, density, chord, pitch, start, inertia, damping and radius, with polars of long rows: the
/// induced velocity follows the balance at once, with its wake skewed as well.
#[test]
fn gradients_of_a_rigid_rotor() {
    let has = Has { rows_deg: 30, ..Has::default() };
    agree("GR-88 straight wake", &has, &RIGID, false);
    let has = Has { features: Some(|features| features.skewed_wake = true), all_results: true, ..has };
    agree("GR-88 skewed wake", &has, &RIGID, false);
}

/// GR-89: the same with rows every 4°, of which sections pass some along the run and along the differences.
#[test]
fn gradients_pass_rows_of_polars() {
    let has = Has { rows_deg: 4, ..Has::default() };
    agree("GR-89", &has, &RIGID, false);
}

fn with_inflow(features: &mut RotorFeatures) {
    (features.dynamic_inflow, features.skewed_wake) = (true, true);
}

fn with_stall(features: &mut RotorFeatures) {
    with_inflow(features);
    features.dynamic_stall = true;
}

/// GR-90: dynamic inflow by both models, and with dynamic stall.
#[test]
fn gradients_with_dynamic_inflow_and_stall() {
    let has =
        |rows_deg: i32, features: fn(&mut RotorFeatures)| Has { rows_deg, features: Some(features), ..Has::default() };
    agree("GR-90 two lags", &has(4, with_inflow), &RIGID, false);
    let one_lag = |features: &mut RotorFeatures| {
        (features.inflow_lag_s, features.pitch_rate) = (Some(0.3), PitchRate::Air);
    };
    agree("GR-90 one lag", &has(4, one_lag), &RIGID, false);
    agree("GR-90 stall", &has(4, with_stall), &RIGID, false);
}

/// GR-91: blades of beams with all effects in time, by wind, density, pitch, start and thickness.
#[test]
fn gradients_of_a_flexible_rotor() {
    let places = [WIND, DENSITY, CHORD, PITCH, SPEED, THICKNESS, LENGTH];
    let has = Has { flexible: true, rows_deg: 4, features: Some(with_stall), ..Has::default() };
    agree("GR-91", &has, &places, false);
}

/// GR-93: blades that flap, in hover and in a wind almost in the plane of the disc: the angles of the flow at heavily loaded annuli pass zero,
/// where differences of long steps err.
#[test]
fn gradients_at_small_angles_of_the_flow() {
    let hover = Has { flapping: true, wind: Some([0.0; 2]), rows_deg: 4, ..Has::default() };
    agree("GR-93 hover", &hover, &RIGID[1..], false);
    let edgewise = Has { symmetric: true, wind: Some([0.045, 5.3]), rows_deg: 1, ..hover };
    agree("GR-93 edgewise", &edgewise, &RIGID, false);
}

/// Turbulence of ±2 m/s on a grid of 3 m and 0.03 s, whose plane is oblique to the shaft; its end comes within the run.
fn turbulence(periodic: bool) -> WindField {
    let mut random = fastrand::Rng::with_seed(11);
    let (across, upward, planes) = (5, 5, 4);
    let mut draw = || 4.0 * random.f32() - 2.0;
    let grid = TurbulenceBox {
        across,
        upward,
        planes,
        across_m: 3.1,
        upward_m: 2.9,
        plane_interval_s: 0.031,
        bottom_m: 1.3,
        carried_m_s: 11.0,
        periodic,
        velocity_m_s: (0..across * upward * planes).map(|_| [draw(), draw(), draw()]).collect(),
    };
    WindField {
        source: Source::Box(Box::new(grid)),
        ground_m: Vector3::new(0.07, 0.2, -7.0),
        up: Vector3::z(),
        downwind: Vector3::new(0.28f64.cos(), 0.28f64.sin(), 0.0),
        reference_height_m: 7.0,
    }
}

/// GR-97: turbulence on a grid, periodic or held at its end, whose cells sections leave along the run and along the differences.
#[test]
fn gradients_in_turbulence() {
    let places = [WIND, CHORD, PITCH, SPEED, LENGTH];
    let has = Has { rows_deg: 4, features: Some(|features| features.field = Some(turbulence(true))), ..Has::default() };
    agree("GR-97 rigid", &has, &places, false);
    let features = |features: &mut RotorFeatures| {
        with_inflow(features);
        features.field = Some(turbulence(false));
    };
    let has = Has { flexible: true, features: Some(features), ..has };
    agree("GR-97 flexible", &has, &places, false);
}

/// GR-97: planes of turbulence that arrive at the ends of aerodynamic steps everywhere are an error by name.
#[test]
fn a_section_at_a_point_of_the_grid_is_an_error() {
    let features = |features: &mut RotorFeatures| {
        let mut field = turbulence(true);
        if let Source::Box(grid) = &mut field.source {
            (grid.carried_m_s, grid.plane_interval_s) = (1e15, 8e-3);
        }
        features.field = Some(field);
    };
    let has = Has { rows_deg: 4, features: Some(features), ..Has::default() };
    let mut plant = started(Turning::USUAL.machine(&has).unwrap_or_else(|error| panic!("{error}")));
    let tape = plant.run_on_tape(&[0.03]).unwrap_or_else(|error| panic!("{error}"));
    let results = turning_results(&plant, &has)[..1].to_vec();
    let mut gradient = Gradient::new(&mut plant, &tape, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
    let text = gradient.forward(&results).expect_err("at a plane").to_string();
    assert!(text.starts_with("blade0, at 0.008 s: a section is exactly at a point of the turbulence grid"), "{text}");
}

/// GR-107: modal blades with all effects in time, through a latch of a pitch bearing, in both couplings.
#[test]
fn gradients_of_a_rotor_with_modal_blades() {
    for staggered in [false, true] {
        let has = Has { modal: true, staggered, ..Has::default() };
        let has = Has { pitching: true, flexible: true, rows_deg: 4, features: Some(with_stall), ..has };
        agree("GR-107", &has, &[WIND, PITCH, SPEED, COMMAND, CATCH, THICKNESS, LENGTH], true);
    }
}

/// GR-106: with the staggered coupling, flexible blades through a latch of a pitch bearing and rigid ones in turbulence.
#[test]
fn gradients_of_rotors_in_the_staggered_coupling() {
    let has = Has {
        pitching: true,
        flexible: true,
        rows_deg: 4,
        features: Some(with_stall),
        staggered: true,
        ..Has::default()
    };
    agree("GR-106 latch", &has, &[WIND, PITCH, SPEED, COMMAND, CATCH, THICKNESS], true);
    let features = |features: &mut RotorFeatures| {
        with_inflow(features);
        features.field = Some(turbulence(true));
    };
    let has = Has { rows_deg: 4, features: Some(features), staggered: true, ..Has::default() };
    agree("GR-106 turbulence", &has, &RIGID, false);
}

/// GR-92: through a brake that is applied within an aerodynamic step, and through a latch of a pitch bearing.
#[test]
fn gradients_of_rotors_pass_through_events() {
    let has = Has { brake: true, rows_deg: 4, features: Some(with_inflow), ..Has::default() };
    agree("GR-92 brake", &has, &[WIND, PITCH, SPEED, FAIL_S, BRAKE], false);
    let has = Has { pitching: true, flexible: true, all_results: true, ..Has::default() };
    let has = Has { rows_deg: 4, features: Some(with_stall), ..has };
    agree("GR-92 latch", &has, &[WIND, PITCH, SPEED, COMMAND, CATCH, THICKNESS], true);
}

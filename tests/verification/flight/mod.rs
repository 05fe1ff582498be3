//! FD-01 to FD-05: a free aircraft with folding tips in steady flight: its trim, its release, its modes.

mod lattice;
mod rigid;

use foldwing::config;
use foldwing::machine::Machine;
use foldwing::plant::{FlightLoad, FlightMode, Holding, ModeShape, Plant, PlantError};
use nalgebra::{Complex, DMatrix, DVector, Matrix3, Rotation3, Vector3};
use rigid::{Flight, Rigid};
use std::sync::Arc;

/// Weight of the aircraft in N, to scale forces, and its length in m.
const WEIGHT_N: f64 = 4.652 * 9.81;
const LENGTH_M: f64 = 1.0;

/// The shipped aircraft with lines of its file replaced and tips at an angle in degrees.
fn machine(fold_deg: f64, replaced: &[(&str, &str)]) -> Machine {
    let mut text = include_str!("../../../examples/flight/folding_aircraft.toml").to_owned();
    let angle = format!("start_angle_deg = {fold_deg:?}");
    for (from, to) in [("start_angle_deg = 0.0", angle.as_str())].iter().chain(replaced) {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    config::parse(&text, "aircraft.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Control of the pitching moment.
#[derive(Clone, Copy, PartialEq)]
enum Nose {
    /// Both elevators, in rad.
    Elevators,
    /// A moment on the fuselage, in N·m, nose down.
    Moment,
}

/// Sets pitch in rad, thrust in N and the control of the pitching moment.
fn set(plant: &mut Plant, nose: Nose, values: &Vector3<f64>) {
    let machine = plant.machine();
    let (gravity_m_s2, wind_m_s) = (machine.gravity_m_s2, machine.air.as_ref().expect("air").wind_m_s);
    let attitude = Rotation3::from_scaled_axis(Vector3::new(0.0, -values[0], 0.0)).inverse();
    let inputs = plant.inputs_mut();
    inputs.root_mut().gravity_m_s2 = attitude * gravity_m_s2;
    *inputs.wind_m_s_mut() = attitude * wind_m_s;
    inputs.stations_mut()[0].force_n.x = values[1];
    match nose {
        Nose::Elevators => inputs.flaps_mut()[..2].iter_mut().for_each(|flap| flap.command_rad = values[2]),
        Nose::Moment => inputs.stations_mut()[0].moment_n_m.y = values[2],
    }
}

fn held(plant: &mut Plant) -> FlightLoad {
    let loads = plant.study().rest_held_in_flight(0.0).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(loads.len(), 1);
    loads[0]
}

/// The aircraft in level flight, and its pitch, thrust and control, by Newton's iteration.
fn trimmed(machine: Machine, nose: Nose) -> (Plant, Vector3<f64>) {
    let mut plant = Plant::new(Arc::new(machine));
    let mut values = Vector3::zeros();
    let mut left = |values: &Vector3<f64>| {
        set(&mut plant, nose, values);
        let load = held(&mut plant);
        Vector3::new(load.force_n.x, load.force_n.z, load.moment_n_m.y)
    };
    for _ in 0..6 {
        let now = left(&values);
        let columns = [1e-4, 1e-2, 1e-4].map(|step: f64| step);
        let mut slope = |k: usize| {
            let mut beside = [values, values];
            beside[0][k] += columns[k];
            beside[1][k] -= columns[k];
            (left(&beside[0]) - left(&beside[1])) / (2.0 * columns[k])
        };
        let slopes = Matrix3::from_columns(&[slope(0), slope(1), slope(2)]);
        values -= slopes.lu().solve(&now).expect("slopes");
    }
    set(&mut plant, nose, &values);
    (plant, values)
}

/// FD-01: the residuals of the six equations of balance vanish to 1e-9 of the weight, with strips and with a lattice, with the tips in line
/// and folded; the folded aircraft flies more nose-up, because its tips carry less lift.
#[test]
fn the_aircraft_is_trimmed_deployed_and_folded() {
    let lattice = [("model = \"strip\"", "model = \"uvlm\""), ("drag_coefficient = 0.01\n", "chord_panels = 2\n")];
    let lattice = [
        lattice[0],
        lattice[1],
        ("hinge_fraction = 0.7\n", "hinge_fraction = 0.5\n"),
        ("hinge_fraction = 0.75", "hinge_fraction = 0.5"),
    ];
    for (air, replaced) in [("strips", &[][..]), ("lattice", &lattice[..])] {
        let mut pitches = Vec::new();
        for fold_deg in [0.0, 60.0] {
            let (mut plant, values) = trimmed(machine(fold_deg, replaced), Nose::Elevators);
            let FlightLoad { force_n, moment_n_m, .. } = held(&mut plant);
            let left = [force_n.norm() / WEIGHT_N, moment_n_m.norm() / (WEIGHT_N * LENGTH_M)];
            println!("{air}, {fold_deg} deg: {values:?}, left {left:?}");
            assert!(left[0] < 1e-9 && left[1] < 1e-9, "{air}, {fold_deg} deg: {left:?}");
            // the analysis accepts this state as an equilibrium
            plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
            pitches.push(values[0]);
        }
        assert!(pitches[1] > pitches[0] + 0.01, "{air}: {pitches:?}");
    }
}

/// FD-02: released from its trim, the aircraft stays in place to 1e-6 m over 5 s. Its only growing mode, the spiral with the tips in line,
/// amplifies the residual of the trim by less than a tenth in that time.
#[test]
fn it_flies_on_when_it_is_released() {
    for fold_deg in [0.0, 60.0] {
        let tight = [
            ("model = \"strip\"", "model = \"strip\"\ncoupling_tolerance = 1e-10"),
            ("[simulation]", "[solver]\ntolerance = 1e-8\n[simulation]"),
        ];
        let (mut plant, _) = trimmed(machine(fold_deg, &tight), Nose::Elevators);
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        let start = plant.outputs().stations()[0].position_m;
        plant.step(5.0).unwrap_or_else(|error| panic!("{error}"));
        let way_m = (plant.outputs().stations()[0].position_m - start).norm();
        println!("{fold_deg} deg: {way_m:.1e} m in 5 s");
        assert!(way_m < 1e-6, "{fold_deg} deg: {way_m:.1e} m");
    }
}

/// The five named modes.
fn named(modes: &[ModeShape]) -> Vec<(FlightMode, Complex<f64>)> {
    modes.iter().filter_map(|mode| Some((mode.flight?, mode.eigenvalue_1_s))).collect()
}

/// FD-03: with stiff beams and quasi-steady strips, the aircraft has the five modes of a rigid one: each eigenvalue is within 1e-4 of that
/// of an independent rigid-body model with the same strips, the five modes are identified, and the trims agree.
#[test]
fn a_stiff_aircraft_has_the_modes_of_a_rigid_one() {
    let stiff = [
        ("youngs_modulus_Pa = 70e9", "youngs_modulus_Pa = 70e14"),
        ("model = \"strip\"", "model = \"strip\"\nquasi_steady = true\napparent_mass = false"),
    ];
    for fold_deg in [0.0f64, 60.0] {
        let (mut plant, values) = trimmed(machine(fold_deg, &stiff), Nose::Moment);
        held(&mut plant);
        let rigid = Rigid::new(fold_deg.to_radians());
        let attitude = Rotation3::from_scaled_axis(Vector3::new(0.0, -values[0], 0.0)).inverse();
        let flight = Flight {
            wind_m_s: attitude * Vector3::new(-18.0, 0.0, 0.0),
            gravity_m_s2: attitude * Vector3::new(0.0, 0.0, -9.81),
            thrust_n: values[1],
            moment_n_m: values[2],
        };
        let left = rigid.left(&flight).norm() / WEIGHT_N;
        println!("{fold_deg} deg: {values:?}; the rigid aircraft leaves {left:.1e} of the weight");
        // the wings still bend by about 1e-6 of their length
        assert!(left < 2e-6, "{fold_deg} deg: {left:.1e}");
        let expected = rigid.eigenvalues_1_s(&flight);
        let modes = plant.study().modes(9).unwrap_or_else(|error| panic!("{error}"));
        let found = named(&modes);
        println!("{expected:?}\n{found:?}");
        assert_eq!(found.len(), 5, "{fold_deg} deg: {found:?}");
        let theirs = rigid_names(&expected);
        for (name, value) in &found {
            let other = theirs.iter().find(|(own, _)| own == name).expect("a mode of the rigid aircraft").1;
            let off = (other - value).norm() / value.norm();
            println!("{fold_deg} deg, {name}: {value:.6}, off by {off:.1e}");
            assert!(off < 1e-4, "{fold_deg} deg, {name}: {value}, expected {other}");
        }
        let mut names: Vec<String> = found.iter().map(|(name, _)| name.to_string()).collect();
        names.sort();
        assert_eq!(names, ["dutch roll", "phugoid", "roll subsidence", "short period", "spiral"]);
        if fold_deg == 0.0 {
            closed_forms(&rigid, &flight, &found);
        }
    }
}

/// Names of the rigid aircraft's eigenvalues, assigned without mode shapes: of the complex pairs, the slowest is the phugoid, the most
/// damped the short period, the third the dutch roll; of the real ones, apart from the zeros of position and heading, the slowest is the
/// spiral, the fastest the roll subsidence.
fn rigid_names(eigenvalues_1_s: &[Complex<f64>]) -> [(FlightMode, Complex<f64>); 5] {
    let moving = eigenvalues_1_s.iter().copied().filter(|value| value.norm() > 1e-4);
    let (mut pairs, mut real): (Vec<_>, Vec<_>) =
        moving.filter(|value| value.im >= 0.0).partition(|value| value.im > 0.0);
    assert!(pairs.len() == 3 && real.len() == 2, "{eigenvalues_1_s:?}");
    pairs.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    pairs[1..].sort_by(|a, b| (a.re / a.norm()).total_cmp(&(b.re / b.norm())));
    real.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    [
        (FlightMode::Phugoid, pairs[0]),
        (FlightMode::ShortPeriod, pairs[1]),
        (FlightMode::DutchRoll, pairs[2]),
        (FlightMode::Spiral, real[0]),
        (FlightMode::RollSubsidence, real[1]),
    ]
}

/// Textbook approximations of the modes; the tolerance of each covers the terms it neglects.
fn closed_forms(rigid: &Rigid, flight: &Flight, found: &[(FlightMode, Complex<f64>)]) {
    let value = |name: FlightMode| found.iter().find(|(own, _)| *own == name).expect("a mode").1;
    let speed = flight.wind_m_s.norm();
    let [turn, velocity, spin] = rigid.slopes(flight);
    let mass_kg = rigid.mass[(0, 0)];
    // about the centre of mass
    let centre_m = Vector3::new(rigid.mass[(1, 5)], 0.0, rigid.mass[(0, 4)]) / mass_kg;
    let pitching = rigid.mass[(4, 4)] - mass_kg * centre_m.norm_squared();
    let about_centre = |column: nalgebra::Vector6<f64>| column[4] + centre_m.x * column[2] - centre_m.z * column[0];
    // with respect to the angle of attack: a sink rate of V alpha
    let attack = velocity.column(2).into_owned() * -speed;
    let pitch_rate = -(spin.column(1).into_owned() + velocity.column(2) * centre_m.x - velocity.column(0) * centre_m.z);
    let (lift, stiffness, damping) =
        (attack[2] / (mass_kg * speed), -about_centre(attack) / pitching, -about_centre(pitch_rate) / pitching);
    // short period: w² = Z_alpha M_q − M_alpha (1 + Z_q), 2 ζ w = −(Z_alpha + M_q), with Z divided by m V and M by I; speed is constant
    let short = value(FlightMode::ShortPeriod);
    let square = -stiffness * (1.0 - pitch_rate[2] / (mass_kg * speed)) - lift * damping;
    println!("short period: {short}, closed form |.|² {square:.4}, sum {:.4}", lift - damping);
    assert!((short.norm_sqr() / square - 1.0).abs() < 0.02, "{short} {square}");
    assert!((-2.0 * short.re / (lift - damping) - 1.0).abs() < 0.02, "{short}");
    // phugoid: exchange of speed and height, with the moments in balance
    let phugoid = value(FlightMode::Phugoid);
    let ahead = velocity.column(0).into_owned();
    let (lift_by_speed, moment_by_speed) = (ahead[2] / mass_kg, -about_centre(ahead) / pitching);
    let path = lift_by_speed - lift * speed * moment_by_speed / stiffness;
    let square = 9.81 * path / (speed - pitch_rate[2] / mass_kg + lift * speed * damping / stiffness);
    println!("phugoid: {phugoid}, closed form |.|² {square:.5}");
    assert!((phugoid.norm_sqr() / square - 1.0).abs() < 0.02);
    // roll: L_p / I_xx
    let rolling = spin[(3, 0)] / rigid.mass[(3, 3)];
    let roll = value(FlightMode::RollSubsidence);
    println!("roll subsidence: {:.4}, closed form {rolling:.4}; turn {:?}", roll.re, turn[(3, 0)]);
    assert!((roll.re / rolling - 1.0).abs() < 0.05);
}

/// Distance from a number to the nearest eigenvalue of a matrix, by inverse iteration.
fn to_nearest(a: &DMatrix<f64>, value: Complex<f64>) -> f64 {
    let shifted = DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| {
        Complex::new(a[(i, j)], 0.0) - if i == j { value } else { Complex::new(0.0, 0.0) }
    });
    let factors = shifted.lu();
    let mut x = DVector::from_fn(a.nrows(), |i, _| Complex::new(1.0 + (i as f64).sin(), (i as f64).cos()));
    let mut distance = f64::INFINITY;
    for _ in 0..6 {
        x.unscale_mut(x.norm());
        let next = factors.solve(&x).expect("a value beside the eigenvalues");
        distance = 1.0 / x.dotc(&next).norm();
        x = next;
    }
    distance
}

/// FD-04: the modes of lowest frequency are eigenvalues of the full linear model, whatever number is requested.
#[test]
fn slow_modes_are_those_of_the_whole_model() {
    let (mut plant, _) = trimmed(machine(0.0, &[]), Nose::Elevators);
    held(&mut plant);
    let space = plant.study().state_space(&[], &|_| DVector::zeros(0)).unwrap_or_else(|error| panic!("{error}"));
    for count in [4, 6, 10, 16] {
        let modes = plant.study().modes(count).unwrap_or_else(|error| panic!("{error}"));
        let free = modes.iter().filter(|mode| mode.is_free()).count();
        assert_eq!((modes.len(), free), (count, 3), "{count} modes: places along three axes are free");
        for mode in modes.iter().filter(|mode| !mode.is_free()) {
            let value = mode.eigenvalue_1_s;
            let off = to_nearest(&space.a, value) / value.norm();
            assert!(off < 1e-5, "{count} modes: {value} is off by {off:.1e}");
        }
    }
}

/// Each name is given to one mode at most, and elastic modes have none, however many modes are requested. With the tips folded by 60°, the
/// slow, non-oscillating lateral mode is the spiral, whether found alone or with the roll subsidence.
#[test]
fn elastic_modes_have_no_names_of_flight() {
    for (fold_deg, spiral_1_s) in [(0.0, None), (60.0, Some(-0.604))] {
        let (mut plant, _) = trimmed(machine(fold_deg, &[]), Nose::Elevators);
        held(&mut plant);
        for count in [6, 8, 10, 16, 24] {
            let modes = plant.study().modes(count).unwrap_or_else(|error| panic!("{error}"));
            let found = named(&modes);
            println!("{fold_deg} deg, {count}: {found:?}");
            let mut names: Vec<String> = found.iter().map(|(name, _)| name.to_string()).collect();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), found.len(), "{fold_deg} deg: {found:?}");
            // the slowest elastic mode of the structure, tips and inner wings in flap, is faster than 5 Hz
            assert!(found.iter().all(|(_, value)| value.im.abs() < 31.0), "{fold_deg} deg: {found:?}");
            if let Some(expected) = spiral_1_s {
                let spiral = found.iter().find(|(name, _)| *name == FlightMode::Spiral).expect("a spiral").1;
                assert!((spiral.re - expected).abs() < 1e-3 && spiral.im == 0.0, "{spiral}");
            }
        }
    }
}

/// With the lattice loads held constant, no mode is named as a flight mode.
#[test]
fn modes_under_held_loads_have_no_names_of_flight() {
    let lattice = [
        ("model = \"strip\"", "model = \"uvlm\""),
        ("drag_coefficient = 0.01\n", "chord_panels = 2\n"),
        ("hinge_fraction = 0.7\n", "hinge_fraction = 0.5\n"),
        ("hinge_fraction = 0.75", "hinge_fraction = 0.5"),
    ];
    let (mut plant, _) = trimmed(machine(0.0, &lattice), Nose::Elevators);
    held(&mut plant);
    let modes = plant.study().modes(9).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(named(&modes), []);
}

/// FD-05: an aircraft out of trim is rejected with the name of its joint and the remaining load.
#[test]
fn an_unbalanced_flight_is_refused() {
    let mut plant = Plant::new(Arc::new(machine(0.0, &[])));
    let refused = plant.study().equilibrium(0.0, Holding::AsReleased).expect_err("no trim");
    let PlantError::Flight { joint, force_n, .. } = &refused else { panic!("{refused}") };
    assert!(joint == "flight" && *force_n > 10.0, "{refused}");
}

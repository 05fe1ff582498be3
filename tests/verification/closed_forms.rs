//! Single functions against their closed forms. Each of these terms is secondary and has no visible effect in the simulations;
//! `tests/mutants/faults.toml` contains the fault that removes it.

use crate::plant::machines::{balance_j, coast, start};
use foldwing::aero::continuous_turbulence::{Component, ContinuousTurbulence, Spectrum};
use foldwing::aero::flow::{AirPath, Flow};
use foldwing::aero::polar::{Polar, PolarRow};
use foldwing::aero::rotor::dynamic_stall::{SplitPolar, StallInflow, StallState};
use foldwing::aero::rotor::turbulence::{coherence, kaimal_m2_s};
use foldwing::aero::strip::section::bias;
use foldwing::beam::law::{SectionLaw, SectionStation};
use foldwing::beam::section::{Material, Section, Solid};
use foldwing::config;
use foldwing::machine::{Body, Joint, Machine, Motor};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::joint::parameters::JointPose;
use foldwing::solve::modes::modes;
use foldwing::solve::tracking::{Branches, Followed};
use nalgebra::{Complex, DMatrix, Matrix3, Vector3};
use std::f64::consts::{PI, TAU};

/// `E = 2 G (1 + ν)`, NOTATION eq. (R5).
#[test]
fn shear_modulus_and_poissons_ratio() {
    let material = Material::isotropic(2.6, 0.3, 1.0);
    assert!((material.shear_modulus_pa - 1.0).abs() < 1e-15, "{}", material.shear_modulus_pa);
    assert!((material.poisson_ratio().expect("a ratio") - 0.3).abs() < 1e-15);
}

/// A given torsional rigidity scales along the taper like the torsion constant of the outline, eqs. (S3), (S5): for an ellipse `a³b³/(a² +
/// b²)`.
#[test]
fn given_torsional_rigidity_of_a_tapered_ellipse() {
    let solid = Solid::ellipse(0.2, 0.05, Material::isotropic(1e9, 0.3, 1e3)).with_torsional_rigidity_n_m2(7.0);
    let constant = |a: f64, b: f64| (a * b).powi(3) / (a * a + b * b);
    let expected = 7.0 * constant(0.2 * 0.5, 0.05 * 1.2) / constant(0.2, 0.05);
    let found = solid.stretched(0.5, 1.2).section().stiffness[(1, 1)];
    assert!((found / expected - 1.0).abs() < 1e-14, "{found} {expected}");
}

/// Sections between rows of a table are linear in every entry, and constant beyond the first and last row, eqs. (S4), (S6).
#[test]
fn sections_of_a_table() {
    let plate = Solid::rectangle(0.1, 0.01, Material::isotropic(1e9, 0.3, 1e3)).section();
    let off = Section { first_moment_kg: [0.3, -0.2], ..plate.scaled(1.0, 3.0) };
    let station = |position_m: f64, section: &Section| SectionStation { position_m, section: section.clone() };
    let law = SectionLaw::Table(vec![station(1.0, &plate), station(2.0, &off)]);
    let middle = law.at(1.25);
    assert!((middle.first_moment_kg[0] - 0.075).abs() < 1e-15 && (middle.first_moment_kg[1] + 0.05).abs() < 1e-15);
    assert!((middle.stiffness - plate.stiffness * 1.5).norm() < 1e-12 * plate.stiffness.norm());
    assert_eq!((law.at(0.5), law.at(7.0)), (plate, off));
}

/// Angular acceleration of Euler parameters whose length also changes, eq. (J3): the time derivative of the angular velocity (J2), by a
/// central difference with an error of second order in 1e-5.
#[test]
fn angular_acceleration_of_euler_parameters_of_any_length() {
    let at = |t: f64| {
        let zeta = [0.9 + 0.3 * t, 0.2 - t * t, -0.4 + 0.5 * t, 0.1 + 0.7 * t * t];
        let rate = [0.3, -2.0 * t, 0.5, 1.4 * t];
        (zeta, rate, [0.0, -2.0, 0.0, 1.4])
    };
    let spin = |t: f64| {
        let (zeta, rate, second) = at(t);
        JointPose::new(&JointKind::Ball, &zeta).spin(&JointKind::Ball, &rate, &second)
    };
    let h = 1e-5;
    let expected = (spin(0.3 + h).0 - spin(0.3 - h).0) / (2.0 * h);
    let found = spin(0.3).1;
    assert!((found - expected).norm() < 1e-8 * expected.norm(), "{found} {expected}");
}

/// The rotation required by the last constraint of a universal joint, eq. (J5): with axes at any angle, `p·(R s)` changes by the right-hand
/// side.
#[test]
fn inclined_axes_of_a_universal_joint() {
    let (parent_axis, body_axis) = (Vector3::x(), Vector3::new(0.6, 0.8, 0.0));
    let mount = Matrix3::identity();
    let kind = JointKind::Universal { parent_axis, body_axis, cosine: parent_axis.dot(&(mount * body_axis)) };
    let eta = kind.parameters_of(&mount);
    let pose = JointPose::new(&kind, &eta);
    let mut right = [0.0; 7];
    right[6] = 0.01;
    let turn = pose.constraint_axis * pose.constraint_turn(&kind, &right);
    let change = pose.parameter_change(&kind, &turn, &right);
    let moved = Matrix3::from_column_slice(&change) * body_axis;
    assert!((parent_axis.dot(&moved) - 0.01).abs() < 1e-15, "{moved}");
}

/// Dampers of a ball joint dissipate exactly the energy lost, and those of a universal joint with inclined axes act on the rates about
/// these axes, eq. (A5). The tolerance of 1e-9 in a few hundred steps.
#[test]
fn dampers_of_joints_with_several_degrees_of_freedom() {
    let top = || Body::rigid("top").inertia(2.0, [0.3, 0.0, 0.0], Matrix3::from_diagonal(&Vector3::new(0.1, 0.2, 0.3)));
    let damper = Motor { damping_n_m_s_rad: 0.8, ..Motor::default() };
    let ball = Joint::ball("ball").motor(damper.clone()).start_angular_velocity_rad_s([1.0, -2.0, 0.5]);
    let machine = Machine::builder("top").body(top(), ball).build().expect("a machine");
    let mut plant = start(machine);
    let before_j = balance_j(plant.outputs());
    coast(&mut plant, 0.5);
    let drift = (balance_j(plant.outputs()) / before_j - 1.0).abs();
    assert!(drift < 1e-6 && plant.outputs().energy().dissipated > 0.3 * before_j, "{drift:e}");

    let (parent_axis, body_axis) = (Vector3::z(), Vector3::new(0.6, 0.0, 0.8));
    let [about_parent, about_body] = [1.5, -0.7];
    let spin = parent_axis * about_parent + body_axis * about_body;
    let universal =
        Joint::universal("universal", parent_axis, body_axis).motor(damper).start_angular_velocity_rad_s(spin);
    let machine = Machine::builder("top").body(top(), universal).build().expect("a machine");
    let mut plant = start(machine);
    let step_s = 1e-5;
    plant.step(step_s).expect("a step");
    let power_w = plant.outputs().energy().dissipated / step_s;
    let expected_w = 0.8 * (about_parent.powi(2) + about_body.powi(2));
    // damping and inertia reduce the rates by 0.8/0.2 1/s, over half of the step
    assert!((power_w / expected_w - 1.0).abs() < 1e-3, "{power_w} {expected_w}");
}

/// The moment at the root of a body away from the origin, eq. (D9).
#[test]
fn moment_at_the_root_of_a_body_beside_it() {
    let place_m = Vector3::new(0.4, -1.0, 0.2);
    let body = Body::rigid("mass").inertia(3.0, [0.1, 0.2, 0.3], Matrix3::identity());
    let machine =
        Machine::builder("beside").gravity_m_s2([0.0, 0.5, -9.8]).body(body, Joint::clamped("mount").at_root(place_m));
    let plant = start(machine.build().expect("a machine"));
    let weight_n = Vector3::new(0.0, 0.5, -9.8) * 3.0;
    let root = plant.outputs().root();
    let expected_n_m = (place_m + Vector3::new(0.1, 0.2, 0.3)).cross(&weight_n);
    assert!((root.force_n - weight_n).norm() < 1e-13, "{}", root.force_n);
    assert!((root.moment_n_m - expected_n_m).norm() < 1e-13, "{}", root.moment_n_m);
}

/// The displacement of the air over two steps equals that over one step of twice the length, in frames rotating slowly and fast, eq. (U5).
#[test]
fn path_of_the_air_in_a_turning_frame() {
    for spin in [0.3, 40.0] {
        let spin_rad_s = Vector3::new(0.6, 0.0, -0.8) * spin;
        let flow =
            Flow { time_s: 0.0, density_kg_m3: 1.0, wind_m_s: Vector3::new(1.0, -3.0, 2.0), spin_rad_s, gusts: &[] };
        let (one, two) = (AirPath::new(&flow, 1e-3), AirPath::new(&flow, 2e-3));
        let place_m = Vector3::new(0.2, 0.5, -0.1);
        let (found, expected) = (two.end_m(&place_m), one.end_m(&one.end_m(&place_m)));
        assert!((found - expected).norm() < 1e-15, "{spin} rad/s: {}", found - expected);
    }
}

/// Position of the upstream edge, eq. (W4): `V/√(V² + W² + (D/4)²)`.
#[test]
fn bias_of_a_strip() {
    assert_eq!(bias(3.0, 0.0, 16.0), 0.6);
    assert_eq!(bias(-3.0, 4.0, 0.0), -0.6);
    assert_eq!(bias(0.0, 0.0, 0.0), 0.0);
}

/// Kaimal's spectrum and the coherence against hand-calculated values, eqs. (B21), (B22).
#[test]
fn kaimals_spectrum_and_coherence() {
    // Λ = 42 m at 90 m, L1 = 340.2 m; at 6 f L/U = 7 the power 5/3 of 8 is 32
    let (mean_m_s, height_m) = (10.0, 90.0);
    let frequency_hz = 7.0 * mean_m_s / (6.0 * 340.2);
    let found = kaimal_m2_s(0, frequency_hz, 1.5, mean_m_s, height_m);
    assert!((found / (4.0 * 2.25 * 34.02 / 32.0) - 1.0).abs() < 1e-12, "{found}");
    // at zero frequency only the term with the length scale remains; for a large one the exponent is 12 d f/U combined with it at right
    // angles
    let still = coherence(50.0, 0.0, mean_m_s, height_m);
    assert!((still.ln() + 12.0 * 50.0 * 0.12 / 340.2).abs() < 1e-12, "{still}");
    let moving = coherence(50.0, 0.01, mean_m_s, height_m);
    assert!((moving.ln() + 600.0 * (1e-6f64 + (0.12f64 / 340.2).powi(2)).sqrt()).abs() < 1e-12, "{moving}");
}

/// Mean square of turbulence over 96 seeds, against the sum of the spectrum over its waves, eq. (U14). The standard deviation of the square
/// of one wave equals its mean: with several hundred relevant waves in all series, the mean deviates by half a per cent.
#[test]
fn variance_of_turbulence_is_the_sum_of_its_spectrum() {
    let (scale_m, length_m, count) = (10.0, 4096.0, 2048);
    let (mut sum, seeds) = (0.0, 96);
    for seed in 0..seeds {
        let asked = ContinuousTurbulence {
            spectrum: Spectrum::Dryden,
            component: Component::Transverse,
            scale_m,
            seed,
            length_m: Some(length_m),
            resolution_m: Some(length_m / f64::from(count)),
        };
        let series = asked.series().expect("a series");
        sum += series.values.iter().map(|value| value * value).sum::<f64>() / series.values.len() as f64 / seeds as f64;
    }
    let step = TAU / length_m;
    let density = |m: i32| Spectrum::Dryden.density_m(Component::Transverse, scale_m, f64::from(m) * step);
    let expected: f64 = (1..=count / 4).map(|m| density(m) * step).sum();
    println!("variance {sum:.4}, waves {expected:.4}");
    assert!((sum / expected - 1.0).abs() < 0.02, "{sum} {expected}");
}

/// Dynamic stall, eqs. (B12), (B13): at a fifth of the attached lift the flow is fully separated, and a steady state persists, also while
/// the section rotates.
#[test]
fn split_of_a_polar_and_steady_dynamic_stall() {
    let row = |degrees: f64, lift: f64| PolarRow { angle_rad: degrees.to_radians(), lift, drag: 0.01, moment: 0.0 };
    let slope = TAU * 10f64.to_radians() / 10.0; // per degree
    let rows = vec![
        row(-180.0, 0.0),
        row(-20.0, -4.0 * slope),
        row(-10.0, -10.0 * slope),
        row(0.0, 0.0),
        row(10.0, 10.0 * slope),
    ];
    let rows = [rows, vec![row(20.0, 4.0 * slope), row(30.0, 12.0 * slope), row(180.0, 0.0)]].concat();
    let split = SplitPolar::new(Polar { rows }).expect("a polar with lift");
    let met = |degrees: f64, pitch_rate_rad_s: f64| StallInflow {
        speed_m_s: 20.0,
        attack_rad: degrees.to_radians(),
        pitch_rate_rad_s,
        chord_m: 0.5,
    };
    // Kirchhoff: the lift is that of the attached line times ((1 + √f)/2)², and f is 0 where less than a quarter of the attached lift
    // remains
    for (degrees, attached) in [(20.0, 0.0), (30.0, (2.0 * 0.4f64.sqrt() - 1.0).powi(2))] {
        approx::assert_relative_eq!(
            StallState::steady(met(degrees, 0.0), &split).attached,
            attached,
            max_relative = 1e-12
        );
    }
    let steady = StallState::steady(met(4.0, 3.0), &split);
    let later = steady.after(met(4.0, 3.0), 0.2, &split);
    let changes = [
        later.wake_rad[0] - steady.wake_rad[0],
        later.wake_rad[1] - steady.wake_rad[1],
        later.lagged_lift - steady.lagged_lift,
    ];
    assert!(changes.iter().all(|change| change.abs() < 1e-14 * PI), "{changes:?}");
}

/// The second mass moments of a section in a file are about its centre of mass, eq. (D1): the terms `m y z` are added to them.
#[test]
fn second_moments_of_a_section_in_a_file() {
    let model = include_str!("../../examples/models/goland_wing.toml").replacen(
        "centre_of_mass_m = [-0.18288, 0.0]",
        "centre_of_mass_m = [-0.2, 0.05]",
        1,
    );
    let section =
        |text: &str| config::parse(text, "wing").unwrap_or_else(|error| panic!("{error}")).bodies[0].section.at(0.0);
    let (off, plain) = (section(&model), section(&model.replacen("[-0.2, 0.05]", "[0.0, 0.0]", 1)));
    let added: Vec<f64> = (0..3).map(|i| off.second_moment_kg_m[i] - plain.second_moment_kg_m[i]).collect();
    for (found, expected) in added.iter().zip([0.04, -0.01, 0.0025]) {
        assert!((found - expected * off.mass_kg_m).abs() < 1e-12 * off.mass_kg_m, "{added:?}");
    }
}

/// The aerodynamic loads at stations add up to their total: each strip contributes its whole load, including the one at the tip.
#[test]
fn loads_of_the_air_at_stations_add_up() {
    let shipped = include_str!("../../examples/models/folding_wing_in_tunnel.toml");
    let machine = config::parse(shipped, "wing").unwrap_or_else(|error| panic!("{error}"));
    let mut plant = start(machine);
    plant.step(5e-3).expect("a step");
    let outputs = plant.outputs();
    let sum: Vector3<f64> = outputs.air_stations().iter().map(|load| load.force_n).sum();
    let total = outputs.air_total().force_n;
    assert!(total.norm() > 1e-3 && (sum - total).norm() < 1e-13 * total.norm(), "{sum} {total}");
}

/// The work of varying gravity, eq. (A4), and the effect of a rotating root on the rotor of a geared drive whose carrier rotates, eq.
/// (D17): the energy balance closes. The tolerance of 1e-9 in a few hundred steps.
#[test]
fn work_of_a_changing_field_and_of_a_turning_root() {
    let arm = |name: &str| Body::rigid(name).inertia(1.0, [0.4, 0.0, 0.1], Matrix3::identity() * 0.05);
    let first = Joint::revolute("first", [0.0, 1.0, 0.0]).start_rate_rad_s(1.0);
    let drive = Motor { inertia_kg_m2: 0.2, gear_ratio: Some(5.0), ..Motor::default() };
    let second = Joint::revolute("second", [0.0, 0.6, 0.8]).on("inner").motor(drive).start_rate_rad_s(-2.0);
    let machine = Machine::builder("arms").body(arm("inner"), first).body(arm("outer"), second).build();
    for turns in [false, true] {
        let mut plant = start(machine.clone().expect("a machine"));
        if turns {
            plant.inputs_mut().root_mut().angular_velocity_rad_s = Vector3::new(0.5, -1.0, 2.0);
            plant.step(1e-3).expect("a step"); // prescribed from here on
        } else {
            plant.input_rates_mut().root_mut().gravity_m_s2 = Vector3::new(3.0, 0.0, -20.0);
        }
        let before_j = balance_j(plant.outputs());
        plant.step(0.3).expect("a step");
        let drift_j = balance_j(plant.outputs()) - before_j;
        let work_j = plant.outputs().energy().work;
        println!("turns {turns}: drift {drift_j:.1e} J, work {work_j:.3e} J");
        assert!(drift_j.abs() < 1e-6 * plant.outputs().energy().kinetic, "{turns}: {drift_j:e}");
        assert!(work_j.abs() > 1e-4, "something does work: {work_j}");
    }
}

/// A mode of many coordinates with a damper on one of them, eq. (L11): the undamped modes of lowest frequency give a first value, and
/// iteration gives the eigenvalue of the whole system; the residual of its shape is round-off.
#[test]
fn damped_modes_are_corrected_over_all_coordinates() {
    let n = 60;
    let mass = DMatrix::identity(n, n);
    let stiffness = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 if i + 1 == n => 100.0,
        0 => 200.0,
        1 => -100.0,
        _ => 0.0,
    });
    let mut damping = DMatrix::zeros(n, n);
    damping[(n - 1, n - 1)] = 6.0;
    let found = modes(&mass, &damping, &stiffness, 1).expect("modes");
    let (value, shape) = (found[0].eigenvalue_1_s, &found[0].shape);
    let whole = DMatrix::from_fn(n, n, |i, j| {
        value * value * mass[(i, j)] + value * damping[(i, j)] + Complex::from(stiffness[(i, j)])
    });
    let left = (whole * shape).iter().map(|entry| entry.norm()).fold(0.0, f64::max);
    println!("{value:.6}: residual {left:.1e}");
    assert!(value.re < -0.02 * value.im && left < 1e-9 * 400.0, "{value}: {left:e}");
}

#[derive(Clone, Debug)]
struct Mode(Complex<f64>, usize);

impl Followed for Mode {
    fn eigenvalue_1_s(&self) -> Complex<f64> {
        self.0
    }

    fn likeness(&self, other: &Self) -> f64 {
        if self.1 == other.1 || self.1 > 1 && other.1 > 1 { 1.0 } else { 0.0 }
    }

    fn product(&self, other: &Self) -> Option<Complex<f64>> {
        Some(Complex::from(self.likeness(other)))
    }
}

/// Branches of modes, eq. (L24): frequencies that approach and separate again are continued by their shapes, although straight lines would
/// cross; modes of equal shape are continued along straight lines over steps of any length.
#[test]
fn branches_follow_shapes_and_straight_lines() {
    let value = |re: f64, shape: usize| Mode(Complex::new(0.0, re), shape);
    let mut bounce = |x: f64| -> Result<Vec<Mode>, ()> {
        let way = (x - 0.5).abs();
        Ok(vec![value(10.0 - way, 0), value(10.0 + way, 1)])
    };
    let places: Vec<f64> = (0..=10).map(|i| 0.1 * f64::from(i)).collect();
    let (branches, failed) = Branches::follow(&places, &mut bounce);
    assert!(failed.is_none());
    for place in &branches.places {
        assert_eq!(place.modes[0].as_ref().map(|mode| mode.1), Some(0), "at {}", place.at);
    }
    let mut cross = |x: f64| -> Result<Vec<Mode>, ()> { Ok(vec![value(1.0 + x, 2), value(1.2 - x, 3)]) };
    let (branches, _) = Branches::follow(&[0.0, 0.02, 0.2], &mut cross);
    assert_eq!(branches.places[2].modes[0].as_ref().map(|mode| mode.1), Some(2), "{:?}", branches.places[2]);
}

//! the wing in steady flow, and its divergence.
//!
//! Strip theory on a uniform straight wing, clamped at the root, with its aerodynamic centre `e` ahead of the elastic
//! axis and incidence `α₀`: `θ(x) = α₀ (tan λL sin λx + cos λx − 1)` with `λ² = 2π q c e/GJ`; the wing diverges where
//! `λL = π/2` (Bisplinghoff, Ashley and Halfman, Aeroelasticity, 1955, section 8-3).

use crate::coupling::goland::Goland;
use crate::coupling::wings::start;
use foldwing::machine::Machine;
use std::f64::consts::{FRAC_PI_2, TAU};

const LENGTH_M: f64 = 6.096;
const RIGIDITY_N_M2: f64 = 0.987e6;

/// Goland's wing with the mass on the elastic axis, so that it does not flutter, and heavy damping, at an incidence so small that its cube
/// is negligible even close to divergence.
fn case(strips: usize) -> Goland {
    Goland { strips, step_chords: 0.5, incidence_deg: 1e-5, gust_m_s: 0.0, ..Goland::strips() }
}

fn machine(strips: usize, speed_m_s: f64) -> Machine {
    let mut machine = case(strips).machine(speed_m_s, |structure| {
        let changed = structure.replace("[-0.18288, 0.0]", "[0.0, 0.0]").replace("7.445675679", "8.64");
        assert_ne!(changed, structure);
        changed
    });
    machine.bodies[0].mass_damping_1_s = 60.0;
    machine
}

/// `λL` of strip theory as a function of the speed.
fn slenderness(speed_m_s: f64) -> f64 {
    let pressure_pa = 0.5 * 1.225 * speed_m_s * speed_m_s;
    let arm_m = (0.33 - 0.25) * Goland::CHORD_M;
    LENGTH_M * (TAU * pressure_pa * Goland::CHORD_M * arm_m / RIGIDITY_N_M2).sqrt()
}

/// Static twist of the wing, at its stations and its tip, in wind of 0.4 to 0.8 of the divergence speed.
#[test]
fn q30_wing_twists_by_the_closed_form() {
    let diverges_m_s = FRAC_PI_2 / slenderness(1.0);
    for share in [0.4, 0.6, 0.8] {
        let speed_m_s = share * diverges_m_s;
        let theory = |place: f64| {
            let all = slenderness(speed_m_s);
            all.tan() * (all * place).sin() + (all * place).cos() - 1.0
        };
        let errors = [8, 16, 32].map(|strips| {
            let mut plant = start(machine(strips, speed_m_s));
            plant.step(3.0).unwrap_or_else(|error| panic!("{error}"));
            let outputs = plant.outputs();
            let twist = |rotation: &nalgebra::UnitQuaternion<f64>| {
                rotation.scaled_axis().x / case(strips).incidence_deg.to_radians()
            };
            let places = [0.125, 0.375, 0.625, 0.875, 1.0];
            let points = outputs.stations().iter().chain(outputs.tips());
            let worst = points.zip(places).map(|(point, place)| twist(&point.rotation) - theory(place));
            worst.map(f64::abs).fold(0.0, f64::max) / theory(1.0)
        });
        println!("Q-30 {speed_m_s:.1} m/s: tip {:.4} of the incidence, off by {errors:.6?} of it", theory(1.0));
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.3, "order {order}");
        }
        // extrapolated to zero strip width: the remaining error is that of the order
        let limit = (4.0 * errors[2] - errors[1]) / 3.0;
        assert!(errors[2] < 2e-3 && limit.abs() < 2e-4, "{limit}");
    }
}

/// Divergence: the twist settles below the speed of the closed form and grows without bound above it; its rate, taken from three late
/// times and interpolated between 2 % below and 2 % above, vanishes at that speed.
#[test]
fn q31_wing_diverges_at_the_closed_form_speed() {
    let diverges_m_s = FRAC_PI_2 / slenderness(1.0);
    let rate_1_s = |share: f64| {
        let mut plant = start(machine(32, share * diverges_m_s));
        let twist = [1.2, 1.6, 2.0].map(|time_s| {
            plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
            plant.outputs().tips()[0].rotation.scaled_axis().x
        });
        println!("Q-31 {share}: {twist:?}");
        ((twist[2] - twist[1]) / (twist[1] - twist[0])).ln() / 0.4
    };
    let (below, above) = (rate_1_s(0.98), rate_1_s(1.02));
    let vanishes = 0.98 - below * 0.04 / (above - below);
    println!("Q-31 {diverges_m_s:.3} m/s; rates {below:.3} and {above:.3} 1/s, zero at {vanishes:.5} of it");
    assert!(below < 0.0 && above > 0.0);
    assert!((vanishes - 1.0).abs() < 1e-3, "{vanishes}");
}

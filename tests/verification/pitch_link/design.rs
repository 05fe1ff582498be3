//! The design question: effect of the inertia of the gears that remain connected, with the engine's own aerodynamics.

use super::in_wind::{blade_in_wind, roots, series};
use super::joint_of;
use crate::plant::machines::start;
use foldwing::machine::{AirOptions, JointMotion, Machine, Motion};

/// Angle of attack in degrees at 70 % of the radius without induction, from a row of the series.
fn attack_deg(row: &[f64; 7]) -> f64 {
    let (r, twist_deg) = (0.7 * 22.5, 10.0 - 7.0);
    let across = 13.0 * row[2].cos() - r * row[5];
    let along = r * row[2].cos() * row[4];
    row[3].to_degrees() - twist_deg + across.atan2(along).to_degrees()
}

/// PL-09. The features of the paper's Fig. 1: flap and pitch depart rapidly from their initial values, the coupled oscillation grows for
/// two cycles and is then limited by negative stall, the rotor speed falls, and the blade drifts to feather; without stall in the polar the
/// oscillation continues to grow.
#[test]
fn pl09_what_the_papers_figure_shows() {
    let rows = series(blade_in_wind(0.0), 8.0);
    let swing = |from_s: f64, to_s: f64, column: usize| {
        let within = rows.iter().filter(|row| (from_s..to_s).contains(&row[0])).map(|row| row[column].to_degrees());
        within.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let widths = [0.0, 0.8, 1.6, 2.4].map(|from_s| {
        let [low, high] = swing(from_s, from_s + 0.8, 3);
        high - low
    });
    let flaps = [0.0, 0.8, 1.6].map(|from_s| {
        let [low, high] = swing(from_s, from_s + 0.8, 2);
        high - low
    });
    println!("pitch swings through {widths:.1?} degrees, flap through {flaps:.2?}");
    assert!(widths[0] > 20.0 && widths[1] > widths[0] + 5.0, "it grows for two cycles: {widths:?}");
    assert!(flaps[1] > 1.1 * flaps[0], "flap grows with it: {flaps:?}");
    // growth per cycle falls from one half to a tenth, and back
    assert!(widths[2] < 1.2 * widths[1] && widths[3] < widths[1], "and hardly more then: {widths:?}");
    assert!(flaps[2] < 1.2 * flaps[1], "nor does flap: {flaps:?}");
    // each of the first cycles enters the negative stall, at -10 degrees
    for cycle in 0..4 {
        let from_s = 0.8 * f64::from(cycle);
        let within = rows.iter().filter(|row| (from_s..from_s + 0.8).contains(&row[0]));
        let least_deg = within.map(attack_deg).fold(f64::INFINITY, f64::min);
        assert!(least_deg < -10.0, "cycle {cycle}: {least_deg} degrees");
    }
    let at = |time_s: f64| rows.iter().find(|row| row[0] >= time_s - 1e-9).expect("a row");
    assert!(at(4.0)[4] < 2.6 && at(6.0)[4] < 1.6, "the rotor slows: {} and {}", at(4.0)[4], at(6.0)[4]);
    let mean_deg = |from_s: f64| 0.5 * swing(from_s, from_s + 0.8, 3).iter().sum::<f64>();
    assert!(mean_deg(5.2) < mean_deg(2.4) - 20.0 && mean_deg(2.4) < mean_deg(0.0), "it drifts to feather");
    // without stall: lift and moment of the attached flow at all angles up to 60 degrees
    let mut attached = blade_in_wind(0.0);
    without_stall(&mut attached);
    let mut plant = start(attached);
    let mut largest_deg = [0.0f64; 2];
    for i in 1..=160 {
        let time_s = 0.01 * f64::from(i);
        if plant.step(time_s).is_err() {
            largest_deg[1] = f64::INFINITY;
            break;
        }
        let pitch_deg = plant.outputs().joints()[2].angle_rad.to_degrees().abs();
        let half = usize::from(time_s > 0.8);
        largest_deg[half] = largest_deg[half].max(pitch_deg);
    }
    println!(
        "without stall to {largest_deg:.1?} degrees in the first two cycles, with it to {:.1}",
        -swing(0.8, 1.6, 3)[0]
    );
    assert!(largest_deg[1] > 1.3 * -swing(0.8, 1.6, 3)[0], "stall is the limit: {largest_deg:?}");
}

/// Replaces the polar by that of attached flow.
fn without_stall(machine: &mut Machine) {
    let air = machine.air.as_mut().expect("air");
    let AirOptions::Rotor(rotor) = &mut air.parts[0].options else { panic!("a rotor") };
    for polar in &mut rotor.polars {
        for row in &mut polar.rows {
            let angle_rad = row.angle_rad.clamp(-1.0, 1.0);
            row.lift = 6.0 * (angle_rad + 4f64.to_radians());
            row.drag = 0.008 + 0.01 * row.lift * row.lift;
            row.moment = -0.05;
        }
    }
}

/// PL-10. The growth rate of the flutter root falls with the inertia, to zero at 105.7 kg·m²; a small oscillation in a simulation grows at
/// the rate of the root.
#[test]
fn pl10_growth_over_the_inertia_and_in_time() {
    let inertias = [0.0, 20.0, 50.0, 100.0, 150.0];
    // the flutter root is the one of higher frequency
    let flutter = |pitch_kg_m2: f64| {
        let of = roots(blade_in_wind(pitch_kg_m2), 4.0, true);
        let flutter = *of.iter().max_by(|a, b| a.1.total_cmp(&b.1)).expect("a root");
        (flutter.0, of.iter().filter(|root| **root != flutter).map(|root| root.0).fold(f64::NEG_INFINITY, f64::max))
    };
    let growths = inertias.map(|pitch_kg_m2| flutter(pitch_kg_m2).0);
    assert!(growths.windows(2).all(|pair| pair[1] < pair[0] - 0.1), "{growths:?}");
    let (mut low, mut high) = (100.0, 150.0);
    while high - low > 0.05 {
        let middle = 0.5 * (low + high);
        if flutter(middle).0 > 0.0 { low = middle } else { high = middle }
    }
    println!("neutral at {low:.2} kg·m²");
    assert!((low - 105.7).abs() < 5.0, "{low}");
    for (pitch_kg_m2, growth) in inertias.into_iter().zip(growths) {
        // until the other oscillation has decayed to e^-7 relative to it
        let measured = growth_in_time(pitch_kg_m2, 7.0 / (growth - flutter(pitch_kg_m2).1));
        println!("{pitch_kg_m2} kg·m²: {measured:+.4} 1/s in time, root {growth:+.4}");
        // aerodynamic steps of 2.5 ms: a relative frequency error of (7 · 0.0025)²/12, 2e-4 1/s
        assert!((measured - growth).abs() < 5e-3, "{measured} {growth}");
    }
}

/// Growth rate in 1/s of a small oscillation about the steady rotation, from its peaks in the three seconds after a given time.
fn growth_in_time(pitch_kg_m2: f64, from_s: f64) -> f64 {
    let mut machine = blade_in_wind(pitch_kg_m2);
    machine.failures.clear();
    machine.solver.tolerance = 1e-10;
    let shaft = joint_of(&mut machine, "shaft");
    (shaft.motion, shaft.start_rate_rad_s) = (JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 4.0])), 0.0);
    let mut held = start(machine.clone());
    for i in 1..=100 {
        held.step(0.1 * f64::from(i)).expect("runs");
    }
    let joints = held.outputs().joints();
    let (flap_rad, holding_n_m) = (joints[1].angle_rad, joints[2].holding_torque_n_m);
    let pitch = joint_of(&mut machine, "pitch");
    pitch.release = true;
    pitch.start_angle_rad += 1e-3f64.to_radians();
    pitch.motor.constant_torque_n_m = -holding_n_m;
    joint_of(&mut machine, "flap").start_angle_rad = flap_rad;
    let mut plant = start(machine);
    let swing = |plant: &foldwing::plant::Plant| plant.outputs().joints()[2].angle_rad + 2f64.to_radians();
    let mut values = vec![swing(&plant)];
    let first = (from_s / 5e-3) as usize;
    for i in 1..=first + 600 {
        plant.step(5e-3 * i as f64).expect("runs");
        values.push(swing(&plant));
    }
    let mut peaks: Vec<(f64, f64)> = Vec::new();
    for i in first.max(1)..values.len() - 1 {
        let [a, b, c] = [values[i - 1], values[i], values[i + 1]].map(f64::abs);
        if b >= a && b > c {
            peaks.push((5e-3 * i as f64, (b + (a - c).powi(2) / (8.0 * (2.0 * b - a - c))).ln()));
        }
    }
    let count = peaks.len() as f64;
    let mean = peaks.iter().fold((0.0, 0.0), |sum, peak| (sum.0 + peak.0 / count, sum.1 + peak.1 / count));
    let (over, under) = peaks.iter().fold((0.0, 0.0), |(over, under), peak| {
        (over + (peak.0 - mean.0) * (peak.1 - mean.1), under + (peak.0 - mean.0).powi(2))
    });
    assert!(peaks.len() > 4, "{} peaks", peaks.len());
    over / under
}

/// PL-11. The scenario table: peaks and time to half speed for each inertia, against the independent solution.
#[test]
fn pl11_the_scenario_table() {
    for (pitch_kg_m2, half_s) in [(0.0, 4.65), (30.0, 4.75), (300.0, 4.25)] {
        let rows = series(blade_in_wind(pitch_kg_m2), 8.0);
        let half = rows.iter().find(|row| row[4] <= 2.0).expect("it slows")[0];
        let peak = |column: usize| rows.iter().map(|row| row[column].to_degrees()).fold(f64::NEG_INFINITY, f64::max);
        println!(
            "{pitch_kg_m2} kg·m²: half speed after {half:.2} s, pitch to {:.2}, flap to {:.3} degrees",
            peak(3),
            peak(2)
        );
        // rows every 50 ms
        assert!((half - half_s).abs() < 0.051, "{half} s");
    }
}

//! Cost of the vortex lattice in the case of `studies/ptera_uvlm.py`: flat wing of aspect ratio 6, 8 × 20 panels, sudden
//! start at 5°, 10 m/s, steps of an eighth of a chord, 100 steps, all wake kept.
//!
//! Before that it prints the cost of one step of a bending wing, split into the work done once per step and the work that a
//! coupling iteration repeats.
//!
//! `cargo bench -p foldwing-benches --bench lattice`; with `-- FOLDER` the histories of the lift coefficient are written
//! there as CSV.

use foldwing::aero::AirLoads;
use foldwing::aero::established::Established;
use foldwing::aero::flow::Flow;
use foldwing::aero::lattice::{LatticeOptions, LoadRule, VortexLattice, WakeModel};
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::load::SectionMotion;
use nalgebra::{Matrix3, Vector3};
use std::fmt::Write;
use std::time::Instant;

const CHORD_PANELS: usize = 8;
const STRIPS: usize = 20;
const SPAN_M: f64 = 6.0;
const SPEED_M_S: f64 = 10.0;
const STEPS: usize = 100;

/// Time in s of all steps including construction, and lift coefficients from the start.
fn run(wake: WakeModel, threads: usize) -> (f64, Vec<f64>) {
    let chord = ChordLine { leading_m: Vector3::y() * 0.25, trailing_m: Vector3::y() * -0.75 };
    let sections = STRIPS + 1;
    let surface = Surface {
        sections: 0..sections,
        chords: vec![chord; sections],
        chord_panels: CHORD_PANELS,
        profile: Profile::THIN,
    };
    let section = |i: usize| SectionMotion {
        rotation: Matrix3::identity(),
        position_m: Vector3::x() * (SPAN_M * i as f64 / STRIPS as f64),
        velocity_m_s: Vector3::zeros(),
        spin_rad_s: Vector3::zeros(),
    };
    let motions: Vec<_> = (0..sections).map(section).collect();
    let angle_rad = 5f64.to_radians();
    let wind_m_s = Vector3::new(0.0, -angle_rad.cos(), angle_rad.sin()) * SPEED_M_S;
    let flow = Flow { time_s: 0.0, density_kg_m3: 1.225, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] };
    let step_s = 1.0 / CHORD_PANELS as f64 / SPEED_M_S;
    let lift_direction = Vector3::new(0.0, angle_rad.sin(), angle_rad.cos());
    let scale_n = 0.5 * 1.225 * SPEED_M_S * SPEED_M_S * SPAN_M;

    let begin = Instant::now();
    let options = LatticeOptions {
        wake,
        wake_rows: STEPS,
        core_radius_m: 1e-3,
        load_rule: LoadRule::KuttaJoukowski,
        mirror_normal: None,
        ground: None,
        speed_of_sound_m_s: None,
        threads,
    };
    let mut lattice = VortexLattice::new(vec![surface], options);
    let (mut from, mut to, mut loads) = (lattice.blank_state(), lattice.blank_state(), AirLoads::still(sections));
    lattice.start(&motions, &flow, None, &mut from, &mut loads).expect("regular");
    let mut lift = Vec::with_capacity(STEPS);
    for _ in 0..STEPS {
        lattice.convect(&from, &flow, step_s, &mut to);
        lattice.solve(&from, &motions, &flow, step_s, &mut to, &mut loads).expect("regular");
        std::mem::swap(&mut from, &mut to);
        let sum: Vector3<f64> = loads.circulatory.iter().chain(&loads.impulsive).map(|load| load.force_n).sum();
        lift.push(sum.dot(&lift_direction) / scale_n);
    }
    (begin.elapsed().as_secs_f64(), lift)
}

/// Times in ms of moving the wake, and of one solution for a bending wing, which a strong coupling repeats: geometry,
/// influence matrix, factorisation, near wake and pressure on the panels; with `wake_rows` rows of wake, most of them far
/// away.
fn bending(wake_rows: usize) -> (f64, f64) {
    let chord = ChordLine { leading_m: Vector3::y() * 0.25, trailing_m: Vector3::y() * -0.75 };
    let sections = STRIPS + 1;
    let surface = Surface {
        sections: 0..sections,
        chords: vec![chord; sections],
        chord_panels: CHORD_PANELS,
        profile: Profile::THIN,
    };
    let bent = |time_s: f64| -> Vec<SectionMotion> {
        let section = |i: usize| SectionMotion {
            rotation: Matrix3::identity(),
            position_m: Vector3::new(SPAN_M * i as f64 / STRIPS as f64, 0.0, 0.001 * (i * i) as f64 * time_s.sin()),
            velocity_m_s: Vector3::z() * 0.001 * (i * i) as f64 * time_s.cos(),
            spin_rad_s: Vector3::zeros(),
        };
        (0..sections).map(section).collect()
    };
    let wind_m_s = Vector3::y() * -SPEED_M_S;
    let flow = Flow { time_s: 0.0, density_kg_m3: 1.225, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] };
    let options = LatticeOptions {
        wake: WakeModel::Prescribed,
        wake_rows,
        core_radius_m: 1e-3,
        load_rule: LoadRule::Bernoulli,
        mirror_normal: None,
        ground: None,
        speed_of_sound_m_s: None,
        threads: 1,
    };
    let mut lattice = VortexLattice::new(vec![surface], options);
    let (mut from, mut to, mut loads) = (lattice.blank_state(), lattice.blank_state(), AirLoads::still(sections));
    lattice.start(&bent(0.0), &flow, Some(Established::straight(0.0125)), &mut from, &mut loads).expect("regular");
    let (mut convecting_s, mut solving_s, mut solutions) = (0.0, 0.0, 0);
    for step in 1..=20 {
        let begin = Instant::now();
        lattice.convect(&from, &flow, 0.0125, &mut to);
        convecting_s += begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        for iteration in 0..3 {
            let motions = bent(0.0125 * (f64::from(step) - 0.1 * f64::from(2 - iteration)));
            lattice.solve(&from, &motions, &flow, 0.0125, &mut to, &mut loads).expect("regular");
            solutions += 1;
        }
        solving_s += begin.elapsed().as_secs_f64();
        std::mem::swap(&mut from, &mut to);
    }
    (1e3 * convecting_s / 20.0, 1e3 * solving_s / f64::from(solutions))
}

fn main() {
    for rows in [8, 100] {
        let (convecting_ms, solving_ms) = bending(rows);
        println!("bending wing, {rows} rows of wake: wake {convecting_ms:.3} ms, one solution {solving_ms:.3} ms");
    }
    let folder = std::env::args().nth(1).filter(|argument| !argument.starts_with("--"));
    for (wake, name) in [(WakeModel::Prescribed, "prescribed"), (WakeModel::Free, "free")] {
        for threads in [1, 2] {
            let best = (0..3).map(|_| run(wake, threads)).min_by(|a, b| a.0.total_cmp(&b.0)).expect("three runs");
            let (seconds, lift) = best;
            let step_ms = 1e3 * seconds / STEPS as f64;
            let panel_us = 1e3 * step_ms / (CHORD_PANELS * STRIPS) as f64;
            println!(
                "wake={name} threads={threads} seconds={seconds:.4} per step {step_ms:.3} ms, per panel {panel_us:.2} us, \
                 CL after 1, 50, 100 steps {:.5} {:.5} {:.5}",
                lift[0],
                lift[STEPS / 2 - 1],
                lift[STEPS - 1]
            );
            if let Some(folder) = folder.as_ref().filter(|_| threads == 1) {
                let mut text = String::from("t_V_over_c,CL\n");
                for (step, lift) in lift.iter().enumerate() {
                    writeln!(text, "{:.6},{lift:.8}", (step + 1) as f64 / CHORD_PANELS as f64).expect("memory");
                }
                std::fs::write(format!("{folder}/lattice_{name}.csv"), text).expect("a writable folder");
            }
        }
    }
}

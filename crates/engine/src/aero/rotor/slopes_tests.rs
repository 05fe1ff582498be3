//! Derivatives of a step of a rotor against differences of whole steps on the same pieces.

use super::*;
use crate::aero::pieces::Holding;
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::rotor::options::{PitchRate, RotorFeatures, RotorOptions, Spread};
use crate::aero::surface::{ChordLine, Profile, Surface};
use crate::math::difference::SIXTH_ORDER;
use nalgebra::{Matrix3, Rotation3};
use std::f64::consts::PI;

const POSITIONS_M: [f64; 4] = [0.0, 3.0, 6.5, 9.0];
const STEP_S: f64 = 0.05;

fn rotor(features: RotorFeatures) -> Rotor {
    let row = |i: i32| {
        let angle_rad = PI * f64::from(i) / 45.0;
        let attached = 1.0 / (1.0 + ((angle_rad.abs() - 0.24) / 0.04).exp());
        let lift = attached * 2.0 * PI * (angle_rad + 0.05).sin() + (1.0 - attached) * 1.1 * (2.0 * angle_rad).sin();
        PolarRow { angle_rad, lift, drag: 0.01 + 1.3 * angle_rad.sin().powi(2), moment: -0.05 * attached }
    };
    let chord = ChordLine { leading_m: Vector3::y() * 0.2, trailing_m: Vector3::y() * -0.6 };
    let surface = |sections: std::ops::Range<usize>| Surface {
        sections,
        chords: vec![chord; 4],
        chord_panels: 1,
        profile: Profile::THIN,
    };
    let options = RotorOptions {
        hub_body: 0,
        shaft_axis: Vector3::x(),
        polars: vec![Polar { rows: (-45..=45).map(row).collect() }],
        sections: vec![vec![0; 4]; 2],
        positions_m: vec![POSITIONS_M.to_vec(); 2],
        lengths_m: vec![9.0; 2],
        sections_turn: vec![true, false],
        features,
    };
    Rotor::new(&[surface(0..4), surface(4..8)], &options)
}

/// Sections of two bent blades, then the hub.
fn motions(time_s: f64) -> Vec<SectionMotion> {
    let spin_rad_s = Vector3::new(2.0, 0.05, -0.03);
    let section = |blade: usize, index: usize| {
        let angle = 2.9 * blade as f64 + 2.0 * time_s;
        let along = Vector3::new(0.05, -angle.sin(), angle.cos()).normalize();
        let ahead = Vector3::x().cross(&along).normalize();
        let level = Matrix3::from_columns(&[along, ahead, along.cross(&ahead)]);
        let share = index as f64 / 3.0;
        let bent = Rotation3::new(Vector3::new(-0.06 + 0.1 * share, -0.05 * share * share, 0.02 * share)).into_inner();
        let place_m = along * (1.0 + POSITIONS_M[index]) + Vector3::x() * (0.2 * share * share);
        let velocity_m_s = spin_rad_s.cross(&place_m) + Vector3::new(0.3 * share, 0.1, 0.0);
        SectionMotion {
            rotation: level * bent,
            position_m: place_m,
            velocity_m_s,
            spin_rad_s: spin_rad_s * (1.0 + 0.02 * share),
        }
    };
    let hub = SectionMotion {
        rotation: Rotation3::new(Vector3::new(2.0 * time_s, 0.02, 0.03)).into_inner(),
        position_m: Vector3::new(0.0, 0.01, 0.0),
        velocity_m_s: Vector3::new(0.1, 0.0, 0.05),
        spin_rad_s,
    };
    (0..2).flat_map(|blade| (0..4).map(move |index| section(blade, index))).chain([hub]).collect()
}

fn cases() -> Vec<(&'static str, RotorFeatures)> {
    let usual = || RotorFeatures { skewed_wake: true, ..RotorFeatures::of(1.0) };
    vec![
        ("at once", usual()),
        ("two lags", RotorFeatures { dynamic_inflow: true, ..usual() }),
        ("stall", RotorFeatures { dynamic_inflow: true, dynamic_stall: true, ..usual() }),
        ("one lag", RotorFeatures { inflow_lag_s: Some(0.4), pitch_rate: PitchRate::Hub, ..usual() }),
        ("cells", RotorFeatures { spread: Spread::Cells, losses: [false; 2], ..usual() }),
        ("as AeroDyn", RotorFeatures { dynamic_inflow: true, aerodyn_compatible: true, ..usual() }),
    ]
}

/// GR-87: products of the derivatives with 20 random directions of motions and state, against sixth-order differences of whole steps on the
/// same pieces, relative to the largest entry; forward and reverse as transposes. In a flow that has developed for some steps.
#[test]
fn steps_have_their_slopes() {
    for (words, features) in cases() {
        let mut rotor = rotor(features);
        let flow = Flow {
            time_s: 0.0,
            density_kg_m3: 1.2,
            wind_m_s: Vector3::new(8.0, 1.5, 0.4),
            spin_rad_s: Vector3::new(0.0, 0.01, 0.02),
            gusts: &[],
        };
        let mut from = rotor.blank_state();
        let mut loads = AirLoads::still(9);
        rotor.start(&motions(-0.5), &flow, true, &mut from, &mut loads);
        for step in -9..0 {
            let mut to = rotor.blank_state();
            rotor.solve(&from, &motions(STEP_S * f64::from(step)), &flow, STEP_S, &mut to, &mut loads);
            from = to;
        }
        let largest_n = loads.circulatory.iter().fold(0.0f64, |most, load| most.max(load.force_n.amax()));
        let now = motions(0.0);
        rotor.holding = Holding::Record(RotorPieces::default());
        rotor.solve(&from, &now, &flow, STEP_S, &mut rotor.blank_state(), &mut loads);
        let pieces = rotor.holding.recorded().expect("recorded");
        let step = rotor.step_slopes(&from, &now, &flow, STEP_S, &pieces).unwrap_or_else(|error| panic!("{error:?}"));
        rotor.holding = Holding::Keep(pieces);
        let has_inflow = rotor.options.features.dynamic_inflow || rotor.options.features.inflow_lag_s.is_some();
        let sizes: Vec<f64> = from.clone().numbers().map(|number| number.abs()).collect();
        let mut random = fastrand::Rng::with_seed(7);
        let (mut worst, mut transposed) = (0.0f64, 0.0f64);
        for direction in 0..20 {
            let mut draw = || 2.0 * random.f64() - 1.0;
            // all of the state, all motions, and single entries
            let state: Vec<f64> =
                sizes.iter().map(|size| if direction % 3 == 1 { 0.0 } else { size * draw() }).collect();
            let moves: Vec<f64> = (0..MOTION * now.len())
                .map(|entry| if direction % 3 == 0 { 0.0 } else { draw() * [0.3, 0.05, 1.0, 0.3][entry % MOTION / 3] })
                .collect();
            let mut run = |amount: f64| {
                let mut begin = from.clone();
                begin.numbers().zip(&state).for_each(|(number, change)| *number += amount * change);
                let mut there = now.clone();
                for (motion, moves) in there.iter_mut().zip(moves.chunks_exact(MOTION)) {
                    let turn = Vector3::from_column_slice(&moves[3..6]) * amount;
                    motion.rotation = Rotation3::new(turn).into_inner() * motion.rotation;
                    motion.position_m += Vector3::from_column_slice(&moves[..3]) * amount;
                    motion.velocity_m_s += Vector3::from_column_slice(&moves[6..9]) * amount;
                    motion.spin_rad_s += Vector3::from_column_slice(&moves[9..]) * amount;
                }
                let (mut to, mut loads) = (rotor.blank_state(), AirLoads::still(9));
                rotor.solve(&begin, &there, &flow, STEP_S, &mut to, &mut loads);
                let loads = loads
                    .circulatory
                    .iter()
                    .flat_map(|load| load.force_n.iter().chain(load.moment_n_m.iter()).copied().collect::<Vec<f64>>());
                let after: Vec<f64> = to.numbers().map(|number| *number).collect();
                (after, loads.collect::<Vec<f64>>())
            };
            let size = 2e-3;
            let (mut after, mut loads) = (vec![0.0; sizes.len()], vec![0.0; LOADS * now.len()]);
            for (steps, weight) in (1..).map(f64::from).zip(SIXTH_ORDER) {
                for sign in [1.0, -1.0] {
                    let found = run(sign * steps * size);
                    let share = sign * weight / (60.0 * size);
                    after.iter_mut().zip(&found.0).for_each(|(sum, entry)| *sum += share * entry);
                    loads.iter_mut().zip(&found.1).for_each(|(sum, entry)| *sum += share * entry);
                }
            }
            let (own_after, own_loads) = step.forward(&state, &moves);
            let of_loads = step.place_of_loads();
            let kinds = |index: usize| (index < of_loads).then_some(index % STATE);
            // states that have an effect, kind by kind
            for kind in 0..STATE {
                let of = |values: &[f64]| -> Vec<f64> {
                    values
                        .iter()
                        .enumerate()
                        .filter(|(index, _)| kinds(*index) == Some(kind))
                        .map(|(_, value)| *value)
                        .collect()
                };
                if kind < 8 && !has_inflow {
                    continue;
                }
                let (own, known) = (of(&own_after), of(&after));
                let scale = known.iter().chain(&of(&sizes)).fold(1e-9f64, |most, entry| most.max(entry.abs()));
                worst =
                    own.iter().zip(&known).fold(worst, |worst, (own, known)| worst.max((own - known).abs() / scale));
            }
            for (place, size) in sizes.iter().enumerate().skip(of_loads) {
                let scale = size.max(after[place].abs());
                worst = worst.max((own_after[place] - after[place]).abs() / scale);
            }
            let scale = loads.iter().fold(largest_n, |most, entry| most.max(entry.abs()));
            worst =
                own_loads.iter().zip(&loads).fold(worst, |worst, (own, known)| worst.max((own - known).abs() / scale));
            let (on_after, on_loads): (Vec<f64>, Vec<f64>) =
                (own_after.iter().map(|_| draw()).collect(), own_loads.iter().map(|_| draw()).collect());
            let (on_state, on_moves) = step.reverse(&on_after, &on_loads);
            let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
            let there = [product(&on_after, &own_after), product(&on_loads, &own_loads)].concat();
            let back = [product(&on_state, &state), product(&on_moves, &moves)].concat();
            let scale: f64 = there.iter().chain(&back).map(|term| term.abs()).sum();
            transposed = transposed.max((there.iter().sum::<f64>() - back.iter().sum::<f64>()).abs() / scale);
        }
        println!("GR-87 {words}: {worst:.1e} {transposed:.1e}");
        assert!(worst < 1e-9, "{words}: {worst:.1e}");
        assert!(transposed < 1e-13, "{words}: {transposed:.1e}");
    }
}

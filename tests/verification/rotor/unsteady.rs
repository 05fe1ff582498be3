//! Dynamic stall against OpenFAST's driver for unsteady airfoils.

use super::{number, polar, reference, table};
use foldwing::aero::rotor::dynamic_stall::{SplitPolar, StallInflow, StallState};
use std::f64::consts::{PI, TAU};

/// RT-03: DU21-A17 pitching about mid-chord by 5° about 5°, 10° and 15°, OpenFAST's `UA_Mod` 4 (the same four equations).
///
/// 2 % of the loop's range for lift and drag, 2 % for the moment: ours takes the slope of attached lift from the polar at
/// the angle of zero lift, OpenFAST from its own rule.
#[test]
fn dynamic_stall_loops_are_openfasts() {
    let split = SplitPolar::new(polar("du21_a17")).unwrap();
    let rows = table(&reference("openfast_ua_loops.csv"));
    let (chord_m, wind_m_s, steps) = (3.5, 40.0, 400);
    for mean_deg in [5.0, 10.0, 15.0] {
        for frequency_hz in [0.2, 0.5] {
            let met = |step: usize| {
                let phase = TAU * step as f64 / steps as f64;
                let angle_rad = f64::to_radians(mean_deg + 5.0 * phase.sin());
                let pitch_rate_rad_s = 5f64.to_radians() * TAU * frequency_hz * phase.cos();
                // the quarter chord is a quarter of a chord ahead of the axis: it rises where the section pitches up
                let across_m_s = wind_m_s * angle_rad.sin() - 0.25 * chord_m * pitch_rate_rad_s;
                let along_m_s = wind_m_s * angle_rad.cos();
                StallInflow {
                    speed_m_s: across_m_s.hypot(along_m_s),
                    attack_rad: across_m_s.atan2(along_m_s),
                    pitch_rate_rad_s,
                    chord_m,
                }
            };
            let step_s = 1.0 / frequency_hz / steps as f64;
            let mut state = StallState::steady(met(0), &split);
            let expected: Vec<_> = rows
                .iter()
                .filter(|row| {
                    row["ua_mod"] == "4"
                        && number(row, "mean_deg") == mean_deg
                        && number(row, "freq_Hz") == frequency_hz
                })
                .collect();
            assert_eq!(expected.len(), 40);
            let mut worst = [0.0f64; 4];
            let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
            for step in 0..4 * steps {
                if step >= 3 * steps && step % 10 == 0 {
                    let row = expected[(step - 3 * steps) / 10];
                    let got = state.coefficients(&split);
                    let attack_deg = state.met.attack_rad * 180.0 / PI;
                    worst[3] = worst[3].max((attack_deg - number(row, "alpha_deg")).abs());
                    for (i, (value, column)) in
                        [(got.lift, "Cl"), (got.drag, "Cd"), (got.moment, "Cm")].into_iter().enumerate()
                    {
                        let expected = number(row, column);
                        worst[i] = worst[i].max((value - expected).abs());
                        range[i] = [range[i][0].min(expected), range[i][1].max(expected)];
                    }
                }
                state = state.after(met(step + 1), step_s, &split);
            }
            let share: Vec<f64> = (0..3).map(|i| worst[i] / (range[i][1] - range[i][0])).collect();
            println!("{mean_deg} deg, {frequency_hz} Hz: of range {share:.5?}, worst {worst:.5?}");
            assert!(worst[3] < 2e-4, "the angle of attack itself: {worst:?}");
            assert!(share.iter().all(|share| *share < 0.02), "{mean_deg} deg {frequency_hz} Hz: {share:?}");
        }
    }
}

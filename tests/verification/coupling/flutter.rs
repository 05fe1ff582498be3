//! flutter of Goland's wing from simulations in time.

use crate::coupling::goland::{Goland, LATTICE_WITH_SUCTION, reference};
use crate::whole::is_whole;

/// Flutter speed in m/s and frequency in rad/s of the continuous wing with the strip model's fit to Wagner's function, by transfer
/// matrices: W-32 of the crate "strips", which shares only that fit with the product.
const FITTED: [f64; 2] = [137.335, 69.346];

/// Relative differences from the reference.
fn off(ours: [f64; 2], reference: [f64; 2]) -> [f64; 2] {
    [ours[0] / reference[0] - 1.0, ours[1] / reference[1] - 1.0]
}

/// Strips: flutter speed and frequency, and their convergence with strips, aerodynamic step and elements.
///
/// Loads are linear over a step and along a strip: second order in both. Elements are of fourth order; two pairs suffice. Extrapolated to
/// zero strip width and step, the results differ from the reference by the remaining higher-order terms, a tenth of a per cent; the finest
/// runs differ by half of that. Short studies: only the wing of the shipped mesh.
#[test]
fn q22_strips_flutter_where_the_continuous_wing_does() {
    let base = Goland::strips();
    let run = |case: Goland| case.flutter(137.0, 0.036);
    let middle = run(base);
    println!("Q-22 as run {:+.6?}", off(middle, FITTED));
    assert!(off(middle, FITTED).iter().all(|off| off.abs() < 1e-3), "{middle:?}");
    if !is_whole() {
        return;
    }
    let strips = [run(Goland { strips: 8, ..base }), middle, run(Goland { strips: 32, ..base })];
    let steps = [run(Goland { step_chords: 0.15, ..base }), middle, run(Goland { step_chords: 0.0375, ..base })];
    let pairs = run(Goland { pairs: 8, ..base });
    println!("Q-22 8, 16, 32 strips: {strips:.3?} (m/s, rad/s)");
    println!("Q-22 steps of 0.15, 0.075, 0.0375 chords: {steps:.3?}");
    println!("Q-22 four, eight pairs: {middle:.3?}, {pairs:.3?}");
    let order = |of: [[f64; 2]; 3]| ((of[0][0] - of[1][0]) / (of[1][0] - of[2][0])).log2();
    println!("Q-22 orders of the speed: strips {:.2}, step {:.2}", order(strips), order(steps));
    assert!((order(strips) - 2.0).abs() < 0.3 && (order(steps) - 2.0).abs() < 0.3);
    let limit: [f64; 2] =
        std::array::from_fn(|i| middle[i] + (strips[2][i] - middle[i] + steps[2][i] - middle[i]) * 4.0 / 3.0);
    println!("Q-22 carried on {limit:.3?}: {:+.6?}", off(limit, FITTED));
    assert!(off(limit, FITTED).iter().all(|off| off.abs() < 2e-4), "{limit:?}");
    assert!((pairs[0] / middle[0] - 1.0).abs() < 1e-4, "{pairs:?}");
}

/// In denser air the wing flutters at lower speed, in thinner air at higher speed, by the ratio from W-32's determinant with
/// Theodorsen's theory (136.950 to 146.70 m/s from 1.225 to 1.02 kg/m³, 7.12 %); the fit changes that ratio by less than a tenth.
#[test]
fn q23_thinner_air_lets_it_flutter_later() {
    let thick = Goland::strips().flutter(137.0, 0.036);
    let thin = Goland { density_kg_m3: 1.02, ..Goland::strips() }.flutter(147.0, 0.036);
    let ratio = thin[0] / thick[0] - 1.0;
    println!("Q-23 1.225 and 1.02 kg/m3: {thick:.3?}, {thin:.3?}, {:.2} %", 100.0 * ratio);
    assert!((ratio / (146.70 / 136.950 - 1.0) - 1.0).abs() < 0.1, "{ratio}");
}

/// A coarse lattice: flutter at a higher speed than with strips, which have no tip loss; the load formula and the wake beyond ten
/// chords do not matter; prints the effect of strips and panels. Q-25 covers the published lattice. Short studies: without other wakes,
/// load formulas and finer strips.
#[test]
fn q24_lattice_flutters_later_than_strips() {
    let base = Goland::lattice(4, 8);
    let run = |case: Goland| case.flutter(176.0, 0.04);
    let coarse = run(base);
    let by_strips = Goland { density_kg_m3: 1.02, ..Goland::strips() }.flutter(147.0, 0.036);
    // at aspect ratio 6.67 the lift slope is 0.73 of strip theory's, and the speed varies with 1/√(slope): 1.17
    assert!(coarse[0] > 1.1 * by_strips[0], "{coarse:?}, {by_strips:?}");
    if !is_whole() {
        return;
    }
    let suction = run(Goland { air: LATTICE_WITH_SUCTION, ..base });
    let [short, long] = [5, 20].map(|chords| run(Goland { wake_rows: chords * 4, ..base }));
    let strips = run(Goland::lattice(4, 16));
    println!("Q-24 4 x 8 panels: {coarse:.3?} (m/s, rad/s); 16 strips {strips:.3?}");
    println!("Q-24 wake of 5, 20 chords: {short:.3?}, {long:.3?}; Kutta-Joukowski: {suction:.3?}");
    // loads of small motions are equal by both formulas; squares of the motion are 1e-8 of it
    assert!((suction[0] / coarse[0] - 1.0).abs() < 1e-6, "{suction:?}");
    // a wave of the wake is 8.7 chords long, and its vortices alternate; truncation at 5 and 10 chords changes the lift by 1.1 % and 0.34 %
    // (U-16)
    assert!((long[0] / coarse[0] - 1.0).abs() < 3.4e-3 && (short[0] / coarse[0] - 1.0).abs() < 1.1e-2);
}

/// Flutter speed in m/s in the reference file for a lattice of 16 panels along the chord at 1.02 kg/m³.
fn published_lattice() -> f64 {
    reference()["vortex_lattice"][0]["flutter_speed_m_s"].as_f64().expect("a number")
}

/// The published lattice with its panels and its wake: 16 along the chord and 16 along each half wing.
///
/// Its rings begin at the leading edge of each panel, ours at a quarter of it. Both flows are those of the same plates a quarter of a panel
/// apart, so our lattice corresponds to the published one if the elastic axis lies a quarter of a panel further aft. With more panels both
/// converge to the same value.
#[test]
#[ignore = "minutes: make validate"]
fn q25_flutter_of_the_published_lattice() {
    let aft = |case: Goland| Goland {
        elastic_axis_fraction: case.elastic_axis_fraction + 0.25 / case.chord_panels as f64,
        ..case
    };
    for panels in [8, 16] {
        let case = Goland::lattice(panels, 8);
        let [ours, theirs] = [case.flutter(174.0, 0.03), aft(case).flutter(166.0, 0.03)];
        println!("Q-25 {panels} x 8: {ours:.2?}; with rings from the panels' edges {theirs:.2?} (m/s, rad/s)");
        assert!(theirs[0] < published_lattice() * 1.03 && theirs[0] < ours[0], "{ours:?}, {theirs:?}");
    }
    let theirs = aft(Goland::lattice(16, 16)).flutter(166.0, 0.03);
    let off = theirs[0] / published_lattice() - 1.0;
    println!("Q-25 16 x 16 with rings from the panels' edges: {theirs:.2?}, {:+.2} %", 100.0 * off);
    // required agreement with published values
    assert!(off.abs() < 0.03, "{theirs:?}");
}

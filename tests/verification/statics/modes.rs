//! S-30 to S-38: natural frequencies against closed forms, an exact dynamic stiffness and Ritz's method.

use crate::reference::{case, numbers};
use crate::statics::machines::{Cantilever, assert_order, machine, plant};
use crate::statics::ritz::frequencies;
use foldwing::machine::{JointKind, Spatial, SpatialFreedom};
use foldwing::plant::{Holding, ModeShape, Plant};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Beam of unit length, mass and `EI_y`, stiff in all other deformations.
fn flap(element: &'static str, elements: usize) -> Cantilever {
    Cantilever { element, elements, stiffness: [1e8, 1e6, 1.0, 1e6], ..Default::default() }
}

fn bare_modes(text: &str, count: usize) -> Vec<ModeShape> {
    let mut plant = plant(text);
    plant.study().undeformed(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant.study().modes(count).unwrap_or_else(|error| panic!("{error}"))
}

fn betas(key: &str) -> Vec<f64> {
    numbers(&case("modal.betaL")["expected"][key])
}

/// S-30. Clamped-free beam: constant elements within `(βL/n)²/15` per mode, order 2; ten pairs within 1e-6, 5e-5 and 5e-4.
#[test]
fn s30_clamped_free() {
    let exact = betas("clamped_free_betaL");
    let errors = |element, elements, mode: usize| {
        let list = bare_modes(&flap(element, elements).text(), 3);
        list[mode].frequency_hz * TAU / exact[mode].powi(2) - 1.0
    };
    for mode in 0..3 {
        let constant: Vec<f64> = [10, 20, 40].iter().map(|&n| errors("constant", n, mode).abs()).collect();
        assert_order(&format!("S-30 constant, mode {}", mode + 1), &constant, 1.9, 2.1);
        for (error, elements) in constant.iter().zip([10.0, 20.0, 40.0]) {
            let bound = (exact[mode] / elements).powi(2) / 15.0;
            assert!(*error <= bound, "{elements} elements, mode {}: {error:.2e} over {bound:.2e}", mode + 1);
        }
        let pairs: Vec<f64> = [5, 10].iter().map(|&n| errors("linear", n, mode).abs()).collect();
        assert_order(&format!("S-30 pairs, mode {}", mode + 1), &pairs, 3.3, 4.6);
        let bound = [1e-6, 5e-5, 5e-4][mode];
        assert!(pairs[1] <= bound, "10 pairs, mode {}: {:.2e} over {bound:.0e}", mode + 1, pairs[1]);
    }
}

/// S-31. The shape of the first mode: flap, largest at the tip; the ratio of rotation to displacement at the tip is that of the closed
/// form, `1.376 506/L`.
#[test]
fn s31_shape_of_the_first_mode() {
    let list = bare_modes(&flap("linear", 10).text(), 1);
    let mode = &list[0];
    assert!(mode.shares[2] > 0.999_999, "{:?}", mode.shares);
    let tip = mode.real[0].last().unwrap();
    let ratio = tip.rotation_rad.y / -tip.displacement_m.z;
    assert!((ratio - 1.376_505_6).abs() < 1e-5, "{ratio}");
    assert_eq!(mode.real[0].len(), 11, "one entry per mesh boundary");
    assert_eq!(mode.real[0][0].displacement_m, Vector3::zeros());
}

/// Errors of some elastic modes, after those of zero frequency, on successively doubled meshes.
fn errors_on<const N: usize>(
    meshes: [usize; N],
    modes: impl Fn(usize) -> Vec<ModeShape>,
    exact: &[f64],
) -> Vec<Vec<f64>> {
    let lists = meshes.map(modes);
    let error = |list: &[ModeShape], i: usize| (list[i].frequency_hz * TAU / exact[i] - 1.0).abs();
    (0..exact.len()).map(|i| lists.iter().map(|list| error(list, i)).collect()).collect()
}

/// Constant elements within `(βL/n)²/15` and of order 2, pairs of order 4 with a limit for ten of them, per mode.
fn assert_beam(what: &str, modes: impl Fn(&'static str, usize) -> Vec<ModeShape>, betas: &[f64], ten_pairs: f64) {
    let exact: Vec<f64> = betas.iter().map(|beta| beta * beta).collect();
    let constant = errors_on([10, 20, 40], |elements| modes("constant", elements), &exact);
    let pairs = errors_on([5, 10, 20], |elements| modes("linear", elements), &exact);
    for (i, beta) in betas.iter().enumerate() {
        assert_order(&format!("{what} constant, mode {}", i + 1), &constant[i], 1.9, 2.1);
        for (error, elements) in constant[i].iter().zip([10.0, 20.0, 40.0]) {
            let bound = (beta / elements).powi(2) / 15.0;
            assert!(*error <= bound, "{what} {elements} elements, mode {}: {error:.2e} over {bound:.2e}", i + 1);
        }
        assert_order(&format!("{what} pairs, mode {}", i + 1), &pairs[i], 3.3, 4.6);
        assert!(pairs[i][1] < ten_pairs, "{what} 10 pairs, mode {}: {:.1e}", i + 1, pairs[i][1]);
    }
}

/// S-32. A hinge without spring at the root: one mode of zero frequency, then the pinned-free beam. Ten pairs are within 1e-4 for two
/// modes.
#[test]
fn s32_pinned_free() {
    let elastic = |element, elements| {
        let beam = Cantilever { joint: "type = 'revolute'\naxis = [0.0, 1.0, 0.0]", ..flap(element, elements) };
        let mut list = bare_modes(&beam.text(), 3);
        assert!(list[0].frequency_hz * TAU < 1e-3, "{}", list[0].frequency_hz);
        list.split_off(1)
    };
    assert_beam("S-32", elastic, &betas("pinned_free_betaL")[..2], 1e-4);
}

/// S-33. A free joint: six modes of zero frequency, then the free-free beam. Ten pairs are within 5e-4 for two modes. A small rotary
/// inertia avoids a massless motion about the axis; it changes the frequencies by 1e-7.
#[test]
fn s33_free_free() {
    let elastic = |element, elements| {
        let beam = Cantilever { inertia: [1.0, 1e-9, 1e-9], ..flap(element, elements) };
        let mut machine = machine(&beam.text());
        machine.bodies[0].joint.kind = JointKind::Spatial(Box::new(Spatial {
            freedom: SpatialFreedom::Free,
            stiffness_n_m_rad: 0.0,
            damping_n_m_s_rad: 0.0,
            start_angular_velocity_rad_s: Vector3::zeros(),
            start_velocity_m_s: Vector3::zeros(),
        }));
        let mut plant = Plant::new(Arc::new(machine));
        plant.study().undeformed(0.0).unwrap();
        let mut list = plant.study().modes(8).unwrap_or_else(|error| panic!("{error}"));
        for mode in &list[..6] {
            assert!(mode.frequency_hz * TAU < 0.1, "{}", mode.frequency_hz);
        }
        list.split_off(6)
    };
    assert_beam("S-33", elastic, &betas("free_free_betaL")[..2], 5e-4);
}

/// S-34. The plates of \[O\] Table 5 as a frame, fold held at 0° and 90°: flap modes against the exact dynamic stiffness. 8 pairs per body:
/// four frequencies, each within 1e-4; order 2 with constant elements, 4 with pairs, from two pairs on, above the round-off of the
/// eigenvalues. The hinge is locked.
#[test]
fn s34_folded_frames() {
    let reference = case("modal.wing_table5_frames");
    let value = |key: &str| reference["inputs"][key].as_f64().expect("a number");
    for (fold, key) in [(0.0, "fold0"), (90.0, "fold90")] {
        let modes = |element: &str, elements: usize| {
            let plate = format!("length_m = 0.15\nsection = 's'\nelement = '{element}'\nelements = {elements}");
            let text = format!(
                "name = 'F'\n[section.s]\nshape = 'explicit'\naxial_stiffness_N = {:?}\ntorsional_rigidity_N_m2 = 1e4\n\
                 flap_stiffness_N_m2 = {:?}\nedge_stiffness_N_m2 = 1e4\nmass_kg_m = {:?}\n\
                 second_moments_kg_m = [1e-9, 0.0, 0.0]\n[body.a]\n{plate}\n[body.b]\n{plate}\n\
                 [joint.mount]\ntype = 'clamped'\nparent = 'root'\nchild = 'a'\n\
                 [joint.fold]\ntype = 'revolute'\nparent = 'a'\nchild = 'b'\naxis = [0.0, 1.0, 0.0]\n\
                 start_angle_deg = {fold:?}\nrelease = false\n",
                value("EA"),
                value("EI"),
                value("m")
            );
            bare_modes(&text, 4)
        };
        let exact: Vec<f64> =
            numbers(&reference["expected"]["Lframe_inplane_Hz"][key])[..4].iter().map(|hz| hz * TAU).collect();
        let constant = errors_on([8, 16, 32], |elements| modes("constant", elements), &exact);
        let pairs = errors_on([2, 4, 8], |elements| modes("linear", elements), &exact);
        for (i, (constant, pairs)) in constant.iter().zip(&pairs).enumerate() {
            assert_order(&format!("S-34 fold {fold}, constant, mode {}", i + 1), constant, 1.9, 2.1);
            assert_order(&format!("S-34 fold {fold}, pairs, mode {}", i + 1), pairs, 3.3, 4.6);
            assert!(pairs[2] < 1e-4, "fold {fold}, mode {}: off by {:.1e}", i + 1, pairs[2]);
        }
    }
}

/// S-35. A beam on a root that rotates about `z` at `Ω = 3` and 12 (unit `√(EI/ρA)/L²`): flap is stiffened by the centrifugal force, lag by
/// the same minus `Ω²`; against Ritz's method and, for `Ω = 12`, the published flap frequencies 13.1702, 37.6031 and 79.6145 of Wright et
/// al. (1982). Ten pairs: 1e-4, 2e-4, 5e-4 (the root bends within one pair at `Ω = 12`).
#[test]
fn s35_spinning_beam_is_stiffened() {
    for omega in [3.0f64, 12.0] {
        let tension = |s: f64| 0.5 * omega * omega * (1.0 - s * s);
        let squares = [frequencies(tension, 0.0), frequencies(tension, omega * omega)];
        if omega == 12.0 {
            for (square, published) in squares[0].iter().zip([13.1702, 37.6031, 79.6145]) {
                assert!((square.sqrt() - published).abs() < 1e-4, "{} against {published}", square.sqrt());
            }
        }
        for (stiffness, exact, share) in
            [([1e8, 1e6, 1.0, 1e6], &squares[0], 2), ([1e8, 1e6, 1e6, 1.0], &squares[1], 3)]
        {
            let beam = Cantilever { stiffness, elements: 10, ..Default::default() };
            let mut plant = plant(&beam.text());
            plant.inputs_mut().root_mut().angular_velocity_rad_s = Vector3::new(0.0, 0.0, omega);
            plant.study().equilibrium(0.0, Holding::AsReleased).unwrap();
            let list = plant.study().modes(3).unwrap_or_else(|error| panic!("{error}"));
            for (i, (mode, square)) in list.iter().zip(exact).enumerate() {
                // lag is the small difference of two large terms: its error is relative to the larger one
                let softening = if share == 3 { omega * omega } else { 0.0 };
                let error = ((mode.frequency_hz * TAU).powi(2) - square) / (2.0 * (square + softening));
                println!(
                    "S-35 Ω = {omega}, share {share}, mode {}: {:.6} rad/s, {error:.1e}",
                    i + 1,
                    mode.frequency_hz * TAU
                );
                assert!(error.abs() < [1e-4, 2e-4, 5e-4][i], "Ω = {omega}, mode {}: {error:.1e}", i + 1);
                assert!(mode.shares[share] > 0.99 && mode.damping_ratio.abs() < 1e-9, "{mode:?}");
            }
        }
    }
}

/// S-36. A hanging and a standing beam under their weight `ρgL³/EI = 5`: tension `±5(1 − s)`; the hanging one has higher frequencies. A
/// standing beam with more than 7.84 buckles: an unstable mode. Against Ritz's method, ten pairs.
#[test]
fn s36_hanging_and_standing_beam() {
    let modes_under = |gravity: f64| {
        let beam = Cantilever { gravity: [gravity, 0.0, 0.0], ..flap("linear", 10) };
        let mut plant = plant(&beam.text());
        plant.study().equilibrium(0.0, Holding::AsReleased).unwrap();
        plant.study().modes(3).unwrap_or_else(|error| panic!("{error}"))
    };
    for gravity in [5.0, -5.0] {
        let exact = frequencies(|s| gravity * (1.0 - s), 0.0);
        for (i, (mode, square)) in modes_under(gravity).iter().zip(exact).enumerate() {
            let error = mode.frequency_hz * TAU / square.sqrt() - 1.0;
            println!("S-36 gravity {gravity}, mode {}: {error:.1e}", i + 1);
            assert!(error.abs() < [5e-6, 1e-4, 1e-3][i], "gravity {gravity}, mode {}: {error:.1e}", i + 1);
        }
    }
    let falling = &modes_under(-9.0)[0];
    let exact = frequencies(|s| -9.0 * (1.0 - s), 0.0)[0];
    assert!(exact < 0.0 && falling.damping_ratio == -1.0, "{falling:?}");
    assert!((falling.eigenvalue_1_s.re / (-exact).sqrt() - 1.0).abs() < 1e-3, "{falling:?}");
}

/// S-37. Damping of the beams: `ζ = α/(2ω) + βω/2` for every mode, 1e-9.
#[test]
fn s37_damping_ratios() {
    let body = "mass_damping_1_s = 0.4\nstiffness_damping_s = 2e-4";
    for mode in bare_modes(&Cantilever { body, ..flap("linear", 6) }.text(), 4) {
        let omega = mode.frequency_hz * TAU;
        let exact = 0.2 / omega + 1e-4 * omega;
        assert!((mode.damping_ratio - exact).abs() < 1e-9, "{} against {exact}", mode.damping_ratio);
    }
}

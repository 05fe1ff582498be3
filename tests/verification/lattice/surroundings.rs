//! Compressibility and the ground in the lattice, against closed forms and against equivalent wings without either.

use crate::lattice::wing::{SPEED_M_S, Wing, inset, options};
use foldwing::aero::established::Established;
use foldwing::aero::images::Plane;
use foldwing::aero::lattice::{LatticeOptions, LoadRule, VortexLattice};
use foldwing::aero::near_sheets::NoCirculation;
use foldwing::aero::surface::{ChordLine, Profile, Surface};
use foldwing::aero::{AirLoads, flow::Flow};
use foldwing::load::SectionMotion;
use nalgebra::{Matrix3, Vector3};

/// Incidence in rad: the neglected terms grow with its square.
const INCIDENCE_RAD: f64 = 1e-4;

/// U-47. Prandtl and Glauert: a wing of span `b` at Mach `M` has the lift of one of span `βb` in incompressible flow divided by `β²`
/// (Göthert's rule), and a very wide wing that of plane flow divided by `β`. With pressure and with suction loads; the straight wakes end
/// at different positions, an effect of 1e-5.
#[test]
fn u47_compressible_wings_are_longer_ones() {
    let lift_n = |span_m: f64, mach: f64, load_rule: LoadRule| {
        let sound = (mach > 0.0).then(|| SPEED_M_S / mach);
        let rule = LatticeOptions { load_rule, speed_of_sound_m_s: sound, core_radius_m: 1e-7, ..options() };
        let mut wing = Wing::new(&inset(span_m, 12), |_| 1.0, 4, rule).with_incidence(INCIDENCE_RAD);
        wing.start(true);
        wing.circulatory_n().z
    };
    for load_rule in [LoadRule::Bernoulli, LoadRule::KuttaJoukowski] {
        for mach in [0.3, 0.6, 0.8] {
            let beta = (1.0_f64 - mach * mach).sqrt();
            for (span_m, exact) in
                [(6.0, lift_n(6.0 * beta, 0.0, load_rule) / (beta * beta)), (1e5, lift_n(1e5, 0.0, load_rule) / beta)]
            {
                let found = lift_n(span_m, mach, load_rule);
                println!(
                    "U-47 {load_rule:?} Mach {mach} span {span_m}: {found} against {exact}, off {:.1e}",
                    found / exact - 1.0
                );
                // the wide wing has finite ends: their effect, 1e-4 of a chord relative to the span, differs
                approx::assert_relative_eq!(found, exact, max_relative = 3e-5);
            }
        }
    }
}

/// U-48. The lattice rejects Mach numbers of 1 and more, and a surface that extends below the ground.
#[test]
fn u48_mach_one_and_the_underground_are_refused() {
    let start = |rule: LatticeOptions| {
        let mut wing = Wing::new(&inset(6.0, 4), |_| 1.0, 2, rule);
        let flow =
            Flow { time_s: 0.0, density_kg_m3: 1.2, wind_m_s: wing.wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] };
        let (motions, mut state, mut loads) = (wing.motions.clone(), wing.from.clone(), wing.loads.clone());
        wing.lattice.start(&motions, &flow, Some(Established::straight(0.03)), &mut state, &mut loads)
    };
    for (sound_m_s, fine) in [(SPEED_M_S * 1.001, true), (SPEED_M_S, false), (0.01 * SPEED_M_S, false)] {
        let found = start(LatticeOptions { speed_of_sound_m_s: Some(sound_m_s), ..options() });
        assert_eq!(found.is_ok(), fine, "{sound_m_s}: {found:?}");
        assert!(fine || matches!(found, Err(NoCirculation::Sonic(sonic)) if sonic.mach >= 1.0));
    }
    for (distance_m, fine) in [(0.5, true), (0.0, false), (-1.0, false)] {
        let ground = Some(Plane { normal: Vector3::z(), distance_m });
        let found = start(LatticeOptions { ground, ..options() });
        assert_eq!(found.is_ok(), fine, "{distance_m}: {found:?}");
    }
}

/// U-49. Ground effect in closed form: a plate with one panel along its chord `c` at the height `h`, in plane flow, has `Γ/Γ∞ = 1 +
/// (c/4h)²`: its image, `2h` below its quarter chord, induces `−Γ (c/2)/(2π ((c/2)² + 4h²))` at three quarters of the chord.
#[test]
fn u49_a_plate_above_the_ground_has_its_closed_form() {
    let circulation = |height_m: Option<f64>| {
        let ground = height_m.map(|distance_m| Plane { normal: Vector3::z(), distance_m });
        let rule = LatticeOptions { ground, core_radius_m: 1e-7, ..options() };
        let places_m = [-2e5, -1e5, -0.5, 0.5, 1e5, 2e5];
        let mut wing = Wing::new(&places_m, |_| 1.0, 1, rule).with_incidence(1e-8);
        wing.start(true);
        wing.lattice.strip_circulation(&wing.from, 0, 2)
    };
    let free = circulation(None);
    for height_m in [0.2, 0.5, 1.0, 3.0] {
        let ratio = circulation(Some(height_m)) / free;
        let exact = 1.0 + (0.25_f64 / height_m).powi(2);
        println!("U-49 height {height_m}: {ratio} against {exact}");
        // the effect of the ends of the wing and of its straight wake, which rises by the incidence, is 3e-6
        approx::assert_relative_eq!(ratio, exact, max_relative = 1e-5);
    }
}

/// U-50. A ground plane, and a ground with a mirror plane, give the same results as the wing with explicit image wings, to round-off; also
/// in steps that shed a wake.
#[test]
fn u50_ground_is_a_second_wing() {
    let (height_m, chord_panels) = (0.4, 3);
    let halves_m = [0.0, 0.5, 1.1, 1.6];
    let chord = ChordLine { leading_m: Vector3::new(0.0, 0.25, 0.03), trailing_m: Vector3::new(0.0, -0.75, -0.05) };
    let low = ChordLine { leading_m: Vector3::new(0.0, 0.25, -0.03), trailing_m: Vector3::new(0.0, -0.75, 0.05) };
    let surface = |sections: std::ops::Range<usize>, chord: ChordLine| Surface {
        chords: vec![chord; sections.len()],
        sections,
        chord_panels,
        profile: Profile::THIN,
    };
    let section = |x: f64, z: f64| SectionMotion {
        rotation: Matrix3::identity(),
        position_m: Vector3::new(x, 0.0, z),
        velocity_m_s: Vector3::zeros(),
        spin_rad_s: Vector3::zeros(),
    };
    let run = |surfaces: Vec<Surface>, motions: Vec<SectionMotion>, rule: LatticeOptions| {
        let mut lattice = VortexLattice::new(surfaces, rule);
        let (mut from, mut to) = (lattice.blank_state(), lattice.blank_state());
        let mut loads = AirLoads::still(motions.len());
        let flow = |time_s: f64| Flow {
            time_s,
            density_kg_m3: 1.2,
            wind_m_s: Vector3::y() * -SPEED_M_S,
            spin_rad_s: Vector3::zeros(),
            gusts: &[],
        };
        lattice.start(&motions, &flow(0.0), None, &mut from, &mut loads).expect("regular");
        for step in 1..=6 {
            lattice.convect(&from, &flow(0.0), 0.03, &mut to);
            lattice.solve(&from, &motions, &flow(0.03 * f64::from(step)), 0.03, &mut to, &mut loads).expect("regular");
            std::mem::swap(&mut from, &mut to);
        }
        (0..3).map(|strip| lattice.strip_circulation(&from, 0, strip)).collect::<Vec<_>>()
    };
    let plain = LatticeOptions { core_radius_m: 1e-4, wake_rows: 20, ..options() };
    let ground = Some(Plane { normal: Vector3::z(), distance_m: height_m });
    let upper: Vec<_> = halves_m.iter().map(|x| section(*x, 0.0)).collect();
    let lower: Vec<_> = halves_m.iter().map(|x| section(*x, -2.0 * height_m)).collect();
    for mirror_normal in [None, Some(Vector3::x())] {
        let imaged =
            run(vec![surface(0..4, chord)], upper.clone(), LatticeOptions { ground, mirror_normal, ..plain.clone() });
        let both = run(
            vec![surface(0..4, chord), surface(4..8, low)],
            upper.iter().chain(&lower).copied().collect(),
            LatticeOptions { mirror_normal, ..plain.clone() },
        );
        println!("U-50 mirror {mirror_normal:?}: {imaged:?} against {both:?}");
        for (imaged, both) in imaged.iter().zip(&both) {
            approx::assert_relative_eq!(imaged, both, max_relative = 1e-10);
        }
    }
}

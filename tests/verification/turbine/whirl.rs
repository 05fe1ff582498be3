//! Modes of rotors in rotation, in the fixed frame: compared with closed forms and OpenFAST; errors.

use crate::turbine::machine::*;
use crate::turbine::resonance::Resonance;
use foldwing::config;
use foldwing::machine::{JointMotion, Machine};
use foldwing::plant::{Branches, ModeShape, Plant, PlantError, Whirl};
use nalgebra::Complex;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;
use std::sync::Arc;

const RPM: f64 = PI / 30.0;

/// The modes of a machine whose rotor rotates.
fn whirls(
    machine: &Machine,
    shaft: Option<&str>,
    speed_rad_s: f64,
    count: usize,
) -> Result<Vec<ModeShape>, PlantError> {
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let rotor = plant.study().rotor(0.0, shaft)?;
    plant.study().whirl_modes(0.0, &rotor, speed_rad_s, count)
}

/// The rotor of the example on a rigid stand, without cone and tilt, its shaft at a given speed.
fn rotor_on_a_stand() -> Machine {
    let text = on_a_stand(TEXT);
    let mut machine = config::parse(&text, "stand.toml").unwrap_or_else(|refused| panic!("{refused}"));
    hinge_mut(&mut machine, "shaft").motion = JointMotion::Locked;
    hinge_mut(&mut machine, "drive_train").motion = JointMotion::Locked;
    machine
}

/// Participation of a whirl in a mode.
fn share(mode: &ModeShape, whirl: Whirl) -> f64 {
    mode.whirl.iter().filter(|part| part.whirl == Some(whirl)).map(|part| part.share).sum()
}

/// WT-17. Blades on a rigid hub are uncoupled: in the fixed frame each of OpenFAST's modes of one blade, `λ`, becomes a collective mode,
/// and whirls of `λ ± iΩ`. Bounds as in WT-02, relative to the magnitude of `λ`; modes must be pure whirls to round-off of the closest
/// pair, 1e-6.
#[test]
fn wt17_blades_on_a_stand_whirl_with_the_speed() {
    let machine = rotor_on_a_stand();
    let (_, rows) = table(include_str!("../../reference/turbine/openfast_fan_plot.csv"));
    let mut worst = 0.0f64;
    for row in rows {
        let speed_rad_s = row[0] * RPM;
        let modes = whirls(&machine, None, speed_rad_s, 9).expect("modes");
        assert_eq!(modes.len(), 9);
        for k in 0..3 {
            let (size, zeta) = (TAU * row[1 + k], row[4 + k]);
            let blade = Complex::new(-zeta * size, size * (1.0 - zeta * zeta).sqrt());
            for (whirl, sign) in [(Whirl::Collective, 0.0), (Whirl::Forward(1), 1.0), (Whirl::Backward(1), -1.0)] {
                let expected = blade + Complex::new(0.0, sign * speed_rad_s);
                // at standstill all three are the same, and any combination of them is a mode
                let pure = |mode: &&ModeShape| speed_rad_s == 0.0 || share(mode, whirl) > 1.0 - 1e-6;
                let of_kind = modes.iter().filter(pure);
                let nearest =
                    of_kind.map(|mode| (mode.eigenvalue_1_s - expected).norm() / size).fold(f64::MAX, f64::min);
                worst = worst.max(nearest);
            }
        }
    }
    println!("WT-17: eigenvalues {worst:.1e}");
    assert!(worst < 2e-5, "off by {worst:.1e}");
}

/// WT-18. The example at standstill: the modes in the fixed frame equal those of the machine, computed without any transformation, to
/// round-off of fourteen digits after two more matrix products. Unlike OpenFAST's modes at standstill they exclude gravity, which softens
/// the tower under the nacelle: 2 % is allowed, 1.8 % of the tower's frequency is observed. Motions have the names of NREL/TP-500-38060,
/// Table 9-1.
#[test]
fn wt18_modes_at_standstill_have_their_names() {
    let mut machine = turbine();
    hinge_mut(&mut machine, "shaft").motion = JointMotion::Locked;
    let modes = whirls(&machine, None, 0.0, 15).expect("modes");
    let mut plant = Plant::new(Arc::new(machine));
    plant.study().undeformed(0.0).expect("a start");
    let plain = plant.study().bare_modes(15).expect("modes");
    let (_, rows) = table(include_str!("../../reference/turbine/openfast_standstill_modes.csv"));
    let mut worst = [0.0f64; 2];
    for ((mode, plain), row) in modes.iter().zip(&plain).zip(&rows) {
        println!("{:9.6} Hz ({:9.6}) {} {:.3}", mode.frequency_hz, row[1], mode.whirl[0], mode.whirl[0].share);
        worst[0] = worst[0].max((mode.eigenvalue_1_s / plain.eigenvalue_1_s - 1.0).norm());
        worst[1] = worst[1].max((mode.frequency_hz / row[1] - 1.0).abs());
    }
    println!("WT-18: eigenvalues {:.1e}, beside gravity {:.1e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-8 && worst[1] < 2e-2, "off by {worst:?}");
    let names: Vec<String> = modes.iter().map(|mode| mode.whirl[0].part.clone()).collect();
    assert_eq!(names[..2], ["tower edge 1", "tower flap 1"]);
    assert!(names[3..6].iter().all(|name| name == "blade flap 1"), "{names:?}");
    assert!(names[6..8].iter().all(|name| name == "blade edge 1"), "{names:?}");
    let whirls: Vec<Option<Whirl>> = modes[3..8].iter().map(|mode| mode.whirl[0].whirl).collect();
    let standing = Some(Whirl::Standing(1));
    assert_eq!(whirls, [standing, standing, Some(Whirl::Collective), standing, standing]);
}

/// WT-19. Ground resonance: the isotropic rotor on a symmetric support has the roots of a quartic, real except in a range of speeds in
/// which the lag motion of the blades and the support excite each other; the growth rate there agrees too. Three, four and five blades.
#[test]
fn wt19_ground_resonance_is_colemans() {
    let (mut worst, mut growing) = (0.0f64, 0);
    for blades in [3, 4, 5] {
        let rotor = Resonance::of(blades);
        let machine = rotor.machine();
        for speed_rad_s in [1.0, 8.0, 15.0, 19.0, 21.0, 22.0, 23.0, 25.0, 30.0, 60.0, -15.0] {
            let modes = whirls(&machine, None, speed_rad_s, 2 * blades + 3).expect("modes");
            for root in rotor.closed_form(speed_rad_s) {
                // e^{iωt} in the plane: λ = iω, or its conjugate for backward whirl
                let value = Complex::new(0.0, 1.0) * root;
                let expected = if value.im < 0.0 { value.conj() } else { value };
                let near = |mode: &&ModeShape| (mode.eigenvalue_1_s - expected).norm();
                let mode = modes.iter().min_by(|a, b| near(a).total_cmp(&near(b))).expect("a mode");
                worst = worst.max(near(&mode) / expected.norm());
                growing += usize::from(expected.re > 1e-3);
                let whirl = if root.re * speed_rad_s.signum() > 0.0 { Whirl::Forward(1) } else { Whirl::Backward(1) };
                let named = mode.whirl.iter().find(|part| part.whirl.is_some()).expect("blades take part");
                assert_eq!(named.whirl, Some(whirl), "{blades} blades at {speed_rad_s} rad/s: {root} {:?}", mode.whirl);
            }
        }
    }
    println!("WT-19: eigenvalues {worst:.1e}, {growing} grow");
    // where two roots meet, at the edge of that range, an error e in the equations moves them by √e; the speeds avoid that edge
    assert!(worst < 1e-8, "off by {worst:.1e}");
    assert!(growing >= 3, "{growing} roots grow: the band is missed");
}

/// WT-28. Thin uniform rods on hinges at the fraction `e` of the radius, without springs: flap `ν² = 1 + 3/2 e/(1 − e)`, lag `ν² = 3/2 e/(1
/// − e)` per revolution (the closed forms of helicopter books, e.g. Johnson, Helicopter Theory, section 5); the rod's inertia about its
/// axis, 1e-9 kg m², changes them by a relative 1e-11.
#[test]
fn wt28_hinges_at_an_offset() {
    let (radius_m, speed_rad_s) = (10.0, 20.0);
    let mut worst = 0.0f64;
    for offset in [0.02, 0.1, 0.4] {
        for (flaps, own) in [(true, 1.0), (false, 0.0)] {
            let length_m = (1.0 - offset) * radius_m;
            let across = 30.0 * length_m * length_m / 12.0;
            let mut text = "name = \"hinged\"\ngravity_m_s2 = [0, 0, 0]\n[rigid_body.hub]\nmass_kg = 100.0\ninertia_kg_m2 = [20.0, 20.0, 20.0, 0, 0, 0]\n\
                 [joint.shaft]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"hub\"\naxis = [1, 0, 0]\nmotion = \"locked\"\n"
                .to_owned();
            for k in 0..3 {
                let (sine, cosine) = (TAU * f64::from(k) / 3.0).sin_cos();
                let axis = if flaps { [0.0, -sine, cosine] } else { [1.0, 0.0, 0.0] };
                write!(
                    text,
                    "[rigid_body.blade{k}]\nmass_kg = 30.0\ncentre_of_mass_m = [0, {:?}, 0]\ninertia_kg_m2 = [{across:?}, 1e-9, {across:?}, 0, 0, 0]\n\
                     [joint.hinge{k}]\ntype = \"revolute\"\nparent = \"hub\"\nchild = \"blade{k}\"\naxis = {axis:?}\n\
                     mount_rotation_deg = [{:?}, 0, 0]\nparent_offset_m = [0, {:?}, {:?}]\n",
                    0.5 * length_m,
                    120.0 * f64::from(k),
                    offset * radius_m * cosine,
                    offset * radius_m * sine
                )
                .expect("text");
            }
            text += "[simulation]\nstop_time_s = 1.0\nstep_s = 0.01\n";
            let machine = config::parse(&text, "hinged.toml").unwrap_or_else(|refused| panic!("{refused}"));
            let modes = whirls(&machine, None, speed_rad_s, 3).expect("modes");
            let per_turn = (own + 1.5 * offset / (1.0 - offset)).sqrt();
            let collective =
                modes.iter().find(|mode| share(mode, Whirl::Collective) > 0.99).expect("a collective mode");
            let found = collective.eigenvalue_1_s;
            worst = worst.max((found.im / (per_turn * speed_rad_s) - 1.0).abs()).max(found.re.abs() / speed_rad_s);
        }
    }
    println!("WT-28: {worst:.1e}");
    assert!(worst < 1e-10, "off by {worst:.1e}");
}

/// A text with one change.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "the rotor has {from:?}");
    text.replacen(from, to, 1)
}

fn refusal(found: Result<Vec<ModeShape>, PlantError>, words: &[&str]) {
    let told = found.expect_err("refused").to_string();
    for word in words {
        assert!(told.contains(word), "{word:?} is missing in {told}");
    }
}

/// WT-20. Machines without modes in the fixed frame are rejected with the cause: unequal blades, a missing blade, a flexible support with
/// two blades, no rotor.
#[test]
fn wt20_rotors_that_are_not_isotropic_are_refused() {
    let three = Resonance::of(3);
    let parse = |text: &str| config::parse(text, "rotor.toml").unwrap_or_else(|refused| panic!("{refused}"));
    // a blade lighter by a hundredth
    let lighter = changed(&three.text(), "mass_kg = 50.0", "mass_kg = 49.5");
    refusal(whirls(&parse(&lighter), None, 10.0, 6), &["not isotropic", "inertia", "equal blades"]);
    // a softer hinge
    let softer = changed(&three.text(), "stiffness_N_m_rad = 2000.0", "stiffness_N_m_rad = 1990.0");
    refusal(whirls(&parse(&softer), None, 10.0, 6), &["not isotropic", "stiffness", "lag"]);
    // one blade at a wrong azimuth
    let off = changed(&three.text(), "mount_rotation_deg = [120", "mount_rotation_deg = [121");
    refusal(whirls(&parse(&off), None, 10.0, 6), &["blade1 is 121", "blade0", "evenly spaced"]);
    // one blade of four missing
    let four = Resonance::of(4).text();
    let (kept, _) = four.split_once("[rigid_body.blade3]").expect("a fourth blade");
    let missing = format!("{kept}[simulation]\nstop_time_s = 1.0\nstep_s = 0.01\n");
    refusal(whirls(&parse(&missing), None, 10.0, 6), &["blade1 is 90.0000 deg", "3 blades", "is one missing?"]);
    // two blades: on this support their modes change with the azimuth, on a stiff stand they do not
    let two = Resonance::of(2);
    refusal(whirls(&two.machine(), None, 10.0, 6), &["not isotropic", "two on a support that does not move"]);
    let mut held = two.machine();
    for joint in ["rail", "seat"] {
        slide_mut(&mut held, joint).motion = JointMotion::Locked;
    }
    let modes = whirls(&held, None, 10.0, 3).expect("modes of two blades on a stand");
    assert!(modes.iter().any(|mode| share(mode, Whirl::Differential) > 0.99), "{:?}", modes[0].whirl);
    // a support with two stiffnesses does not affect the rotor's isotropy: three blades do not depend on their azimuth
    let uneven = Resonance { support_n_m: [2e5, 3e5], ..Resonance::of(3) };
    assert_eq!(whirls(&uneven.machine(), None, 10.0, 6).expect("modes").len(), 6);
    // no rotor, an unknown joint, a joint that is not a shaft
    let bare = parse(
        &kept
            .split_once("[rigid_body.blade1]")
            .map(|(kept, _)| kept.to_owned() + "[simulation]\nstop_time_s = 1.0\nstep_s = 0.01\n")
            .expect("a blade"),
    );
    refusal(whirls(&bare, None, 10.0, 6), &["no rotor", "name the joint of the shaft"]);
    refusal(whirls(&three.machine(), Some("shafts"), 10.0, 6), &["shaft shafts", "no joint"]);
    refusal(whirls(&three.machine(), Some("rail"), 10.0, 6), &["shaft rail", "not revolute"]);
    refusal(whirls(&three.machine(), Some("lag1"), 10.0, 6), &["lag1", "no hub"]);
    for speed_rad_s in [f64::NAN, f64::INFINITY] {
        refusal(whirls(&three.machine(), None, speed_rad_s, 6), &["not a finite number"]);
    }
}

/// WT-20. Reverse rotation transposes the equations: mass and stiffness are symmetric, gyroscopic terms skew, so eigenvalues are unchanged,
/// up to the asymmetric part of the damping (M6), 1e-6 of them, of which ten times is allowed. At ten times its speed the machine has all
/// its modes; at a thousand times it has all of them or no steady state; far beyond it has none, and the error gives the speed and the
/// remedy.
#[test]
fn wt20_speeds_beyond_reason_have_an_answer() {
    let modes = |speed_rpm: f64| whirls(&turbine(), None, speed_rpm * RPM, 12);
    let [ahead, back] = [12.1, -12.1].map(|speed_rpm| modes(speed_rpm).expect("modes"));
    assert_eq!((ahead.len(), back.len()), (12, 12));
    let mut worst = 0.0f64;
    for (one, other) in ahead.iter().zip(&back) {
        let size = one.eigenvalue_1_s.norm().max(other.eigenvalue_1_s.norm());
        worst = worst.max((one.eigenvalue_1_s - other.eigenvalue_1_s).norm() / size.max(f64::MIN_POSITIVE));
    }
    println!("WT-20: turning back {worst:.1e}");
    assert!(worst < 1e-5, "turning back moves eigenvalues by {worst:.1e}");
    for (speed_rpm, answer, refused) in [(121.0, true, false), (12_100.0, true, true), (1e9, false, true)] {
        match modes(speed_rpm) {
            Ok(modes) => {
                let list: Vec<f64> = modes.iter().map(|mode| mode.frequency_hz).collect();
                assert!(
                    answer && list.len() == 12 && list.iter().all(|hz| hz.is_finite()),
                    "{speed_rpm} rpm: {list:?}"
                );
                assert!(list.windows(2).all(|pair| pair[0] <= pair[1]), "{speed_rpm} rpm: {list:?}");
            }
            Err(error) => {
                let text = error.to_string();
                let words = [&format!("no steady state at {} rad/s", speed_rpm * RPM), "lower the speed of the rotor"];
                assert!(refused && words.iter().all(|word| text.contains(*word)), "{speed_rpm} rpm: {text}");
            }
        }
    }
}

/// WT-85. Modes as functions of the rotor speed, from standstill, where the modes of equal blades have one frequency and any combination of
/// them is a mode: none is lost up to 12 rpm and back, in steps of 1 to 12 rpm, on stands of several stiffnesses. At each speed there are
/// as many modes as at 3 rpm, and on a stiff stand each motion of the blades occurs once.
#[test]
fn wt85_no_mode_is_lost_from_standstill() {
    let on_tower = |factor: f64| {
        let mut machine = turbine();
        hinge_mut(&mut machine, "shaft").motion = JointMotion::Locked;
        law_mut(&mut machine, "tower").stiffness_factor = factor;
        machine
    };
    let mut sprung = rotor_on_a_stand();
    hinge_mut(&mut sprung, "drive_train").motion = JointMotion::Free;
    let stands = [
        ("stand", rotor_on_a_stand(), 9),
        ("stand, drive train", sprung, 10),
        ("tower", on_tower(1.0), 12),
        ("tower, 100 times as stiff", on_tower(100.0), 12),
        ("tower, 1e6 times as stiff", on_tower(1e6), 12),
    ];
    for (name, machine, count) in stands {
        let mut plant = Plant::new(Arc::new(machine));
        let rotor = plant.study().rotor(0.0, None).expect("a rotor");
        let mut modes_at = |speed_rpm: f64| plant.study().whirl_modes(0.0, &rotor, speed_rpm * RPM, 2 * count + 4);
        let ramp: Vec<f64> = (0..=12).map(f64::from).collect();
        let sweeps = [
            ramp.clone(),
            ramp.into_iter().rev().collect(),
            vec![0.0, 6.0, 12.0],
            vec![0.0, 12.0],
            vec![12.0, 3.0, 0.0],
        ];
        let (mut from_three, ended) = Branches::follow(&[3.0, 6.0, 12.0], &mut modes_at);
        assert!(ended.is_none());
        from_three.keep(count, &mut []);
        let there = |branches: &Branches<ModeShape>| -> Vec<usize> {
            branches.places.iter().map(|place| place.modes.iter().flatten().count()).collect()
        };
        let expected = there(&from_three)[0];
        assert_eq!(expected, count, "{name}");
        for speeds_rpm in sweeps {
            let (mut branches, ended) = Branches::follow(&speeds_rpm, &mut modes_at);
            assert!(ended.is_none());
            branches.keep(count, &mut []);
            assert_eq!(there(&branches), vec![expected; speeds_rpm.len()], "{name}, {speeds_rpm:?}");
            if name != "stand" {
                continue;
            }
            for place in branches.places.iter().filter(|place| place.at != 0.0) {
                for whirl in [Whirl::Collective, Whirl::Forward(1), Whirl::Backward(1)] {
                    let pure = place.modes.iter().flatten().filter(|mode| share(mode, whirl) > 1.0 - 1e-6);
                    assert_eq!(pure.count(), 3, "{whirl:?} at {} rpm of {speeds_rpm:?}", place.at);
                }
            }
        }
    }
}

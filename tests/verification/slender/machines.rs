//! Slender bodies on machines: SB-09 and following.

use crate::counting_allocator::allocations;
use crate::rotor::several::{machine, run, started};
use crate::slender::{POINTED, moment};
use foldwing::plant::{Holding, Plant};
use nalgebra::Vector3;

const TWIN: &str = include_str!("../../../examples/airs/twin_rotor.toml");
pub(crate) const GLIDER: &str = include_str!("../../../examples/airs/wing_with_fuselage.toml");

/// Mass of the pointed body of the tests in kg in air of 1 kg/m³.
pub(super) fn apparent_kg() -> f64 {
    moment(&POINTED, 0)
}

fn rows() -> String {
    format!("{POINTED:?}")
}

/// A pointed rigid body of `mass_kg` on a joint, in air of 1 kg/m³.
pub(super) fn pointed(joint: &str, mass_kg: f64, air: &str, more: &str) -> String {
    format!(
        "name = \"Pointed\"\n[rigid_body.pod]\nmass_kg = {mass_kg:?}\ncentre_of_mass_m = [0.2, 0.0, 0.0]\n\
         inertia_kg_m2 = [{0:?}, {1:?}, {1:?}, 0.0, 0.0, 0.0]\n[joint.mount]\nparent = \"root\"\nchild = \"pod\"\n{joint}\n\
         [aerodynamics]\ndensity_kg_m3 = 1.0\ncoupling_tolerance = 1e-10\ncoupling_iterations = 200\n{air}\n\
         [aerodynamics.pod]\nmodel = \"slender_body\"\nbody = \"pod\"\nradius_m = {2}\nsegments = 4\n{more}\n\
         [solver]\nmethod = \"esdirk4\"\nfixed_step_s = 0.005\ntolerance = 1e-12\n",
        0.02 * mass_kg,
        0.4 * mass_kg,
        rows()
    )
}

/// SB-09. A body on a slide across its axis, pushed by gravity in still air, accelerates as its mass with the apparent mass `ρ V`: for bodies
/// of ten times to a twentieth of the apparent mass. Velocity after 1 s; the run starts with the acceleration without air, and the averages
/// of (Q4) forget that the more slowly the lighter the body is.
#[test]
fn sb09_apparent_mass_on_a_slide() {
    for (ratio, bound) in [(10.0, 1e-10), (1.0, 1e-10), (0.2, 1e-6), (0.05, 5e-4)] {
        let mass_kg = ratio * apparent_kg();
        let text = pointed("type = \"prismatic\"\naxis = [0.0, 0.0, 1.0]", mass_kg, "step_s = 0.01", "")
            .replace("name = \"Pointed\"", "name = \"Pointed\"\ngravity_m_s2 = [0.0, 0.0, 2.0]");
        let mut plant = started(&text);
        plant.step(1.0).unwrap_or_else(|error| panic!("ratio {ratio}: {error}"));
        let due_m_s = 2.0 * ratio / (ratio + 1.0);
        let error = (plant.outputs().joints()[0].rate_rad_s / due_m_s - 1.0).abs();
        let solutions = plant.statistics().air_solutions as f64 / 100.0;
        println!("SB-09: mass / apparent mass {ratio}: {error:.1e}; {solutions:.1} solutions per step");
        assert!(error < bound, "{ratio}: {error:e}");
    }
}

/// Momentum along the axes of the root and energy of the body with the air around it, and the momentum of the body alone.
fn conserved(plant: &Plant, mass_kg: f64) -> (Vector3<f64>, f64, f64) {
    let body = &plant.sections(0, &[0.0])[0];
    let attitude = body.rotation;
    let (spin_rad_s, velocity_m_s) = (body.angular_velocity_rad_s, body.velocity_m_s);
    let along: Vector3<f64> = attitude.column(0).into();
    let across = |v: Vector3<f64>| v - along * v.dot(&along);
    let centre_m_s = velocity_m_s + spin_rad_s.cross(&(along * 0.2));
    // momentum of the apparent mass: linear in the position
    let [v, m1, m2] = [0, 1, 2].map(|power| moment(&POINTED, power));
    let (w0, w1) = (across(velocity_m_s), across(spin_rad_s.cross(&along)));
    let momentum = centre_m_s * mass_kg + w0 * v + w1 * m1;
    let air_j = 0.5 * (w0.norm_squared() * v + 2.0 * w0.dot(&w1) * m1 + w1.norm_squared() * m2);
    let own = attitude.transpose() * spin_rad_s;
    let inertia = Vector3::new(0.02, 0.4, 0.4) * mass_kg;
    let body_j = 0.5 * mass_kg * centre_m_s.norm_squared() + 0.5 * own.component_mul(&own).dot(&inertia);
    (momentum, body_j + air_j, body_j)
}

/// SB-10. A free body in still air, thrown obliquely and turning: momentum and energy of body and air together are conserved (Kirchhoff's
/// equations), while those of the body alone change; the error falls with the square of the aerodynamic step.
#[test]
fn sb10_free_body_conserves_momentum_and_energy_with_the_air() {
    let mass_kg = 1.5 * apparent_kg();
    let thrown =
        "type = \"free\"\nstart_velocity_m_s = [2.0, 0.3, -0.4]\nstart_angular_velocity_deg_s = [20.0, 60.0, -40.0]";
    let errors = [0.02, 0.01].map(|step_s| {
        let air = format!("step_s = {step_s:?}");
        let text = pointed(thrown, mass_kg, &air, "")
            .replace("fixed_step_s = 0.005", &format!("fixed_step_s = {:?}", 0.5 * step_s));
        let mut plant = started(&text);
        // the first steps start without accelerations
        plant.step(0.2).unwrap_or_else(|error| panic!("{error}"));
        let (momentum, energy_j, alone_j) = conserved(&plant, mass_kg);
        plant.step(1.2).unwrap_or_else(|error| panic!("{error}"));
        let (later, later_j, later_alone_j) = conserved(&plant, mass_kg);
        let exchanged = (later_alone_j - alone_j).abs() / energy_j;
        println!(
            "SB-10: step {step_s}: momentum {:.2e}, energy {:.2e}; exchanged with the air {exchanged:.2}",
            (later - momentum).norm() / momentum.norm(),
            later_j / energy_j - 1.0
        );
        assert!(exchanged > 0.02, "{exchanged}");
        [(later - momentum).norm() / momentum.norm(), (later_j / energy_j - 1.0).abs()]
    });
    for kind in 0..2 {
        let ratio = errors[0][kind] / errors[1][kind];
        assert!(errors[1][kind] < 1e-3 && ratio > 3.0, "{kind}: {errors:?}");
    }
}

/// The glider without gust, in steps that both sides share.
fn calm() -> String {
    let (before, rest) = GLIDER.split_once("[gust.side]").unwrap();
    before.replace("step_s = 0.0025\n", "step_s = 0.0025\ncoupling_tolerance = 1e-9\ncoupling_iterations = 200\n")
        + rest.split_once("\n\n").unwrap().1
}

/// The glider's text without its fuselage's air.
fn without_slender_body(text: &str) -> String {
    let (before, rest) = text.split_once("[aerodynamics.fuselage]").unwrap();
    before.to_owned() + &rest[rest.find("\n[").unwrap()..]
}

/// SB-11. The glider flies: it is symmetric without a gust; strips have the same loads to the bit at the start with and without the slender
/// body; the total is the sum of both; with the gust it leaves its plane of symmetry.
#[test]
fn sb11_wing_with_fuselage() {
    let text = calm();
    let outputs = run(&text, 0.01, 50);
    let last = &outputs[outputs.len() - 1];
    let machine = machine(&text);
    let body = |name: &str| machine.bodies.iter().position(|body| body.name == name).unwrap();
    let mut largest = 0.0_f64;
    for outputs in &outputs[1..] {
        for [right, left] in [["right_wing", "left_wing"], ["right_tail", "left_tail"]] {
            let [right, left] = [right, left].map(|name| outputs.joint_reactions()[body(name)]);
            // in the frames of the bodies, whose x axes point outward
            largest = largest.max((right.force_n.norm() / left.force_n.norm() - 1.0).abs());
        }
        let total = outputs.air_total().force_n;
        largest = largest.max((total.y / total.z).abs());
    }
    let lift_n = last.air_total().force_n.z;
    let weight_n = 9.80665
        * machine.bodies.iter().map(|body| body.masses.iter().map(|mass| mass.mass_kg).sum::<f64>()).sum::<f64>();
    let plant = started(&text);
    let bare = started(&without_slender_body(&text));
    assert_eq!(plant.surface_forces_n(), bare.surface_forces_n());
    let sum: Vector3<f64> = plant.surface_forces_n().iter().flatten().sum();
    let total = plant.outputs().air_total().force_n;
    let drag_n = 0.5 * 1.225 * 400.0 * std::f64::consts::PI * 0.115_f64.powi(2) * 0.08;
    println!(
        "SB-11: asymmetry {largest:.1e}; lift {lift_n:.1} N, payload {weight_n:.1} N; fuselage {:.3?} N",
        total - sum
    );
    approx::assert_relative_eq!((total - sum).x, drag_n, max_relative = 1e-6);
    assert!(largest < 1e-6 && lift_n > 50.0, "{largest:e} {lift_n}");
    // loads at the stations of the fuselage add up to its own
    let stations: Vector3<f64> = plant.outputs().air_stations()[..3].iter().map(|load| load.force_n).sum();
    approx::assert_relative_eq!(stations, total - sum, epsilon = 1e-9);
    let gusty = run(GLIDER, 0.01, 100);
    let aside = gusty[100].air_total().force_n;
    assert!(aside.y.abs() > 0.01, "{aside:?}");
}

/// SB-12. Steps with strips and a slender body allocate nothing.
#[test]
fn sb12_steps_do_not_allocate() {
    let mut plant = started(GLIDER);
    plant.step(0.02).unwrap();
    let before = allocations();
    assert!(before > 0, "the counter counts");
    plant.step(0.05).unwrap();
    assert_eq!(allocations(), before);
}

/// SB-13. Equilibrium of a body on a pivot with a spring: Munk's moment turns it further than the spring alone would, in balance with it; its
/// equilibrium is stable. Beyond a wind at which the moment grows faster than that of the spring, the body turns across the flow.
#[test]
fn sb13_pivot_in_the_wind() {
    let spring = |wind: f64| {
        let joint = "type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nstart_angle_deg = 5.0\n[joint.mount.motor]\nstiffness_N_m_rad = 40.0\n\
                     command_deg = 5.0\ndamping_N_m_s_rad = 4.0";
        pointed(joint, 2.0, &format!("wind_m_s = [{wind:?}, 0.0, 0.0]\nstep_s = 0.01"), "")
    };
    // no gravity
    let mut plant = started(&spring(7.0));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let angle = plant.outputs().joints()[0].angle_rad;
    let munk_n_m = apparent_kg() * 49.0 * angle.sin() * angle.cos();
    println!("SB-13: {:.4} deg", angle.to_degrees());
    approx::assert_relative_eq!(40.0 * (angle - 5f64.to_radians()), munk_n_m, max_relative = 1e-6);
    let stability = plant.study().stability().unwrap();
    assert!(stability.is_stable(), "{stability:?}");
    let mut plant = started(&spring(30.0));
    plant.step(3.0).unwrap_or_else(|error| panic!("{error}"));
    let across = plant.outputs().joints()[0].angle_rad;
    assert!((0.5..1.8).contains(&across), "{across}");
}

/// SB-14. What has no form for slender bodies is refused by name.
#[test]
fn sb14_studies_are_refused_by_name() {
    let alone =
        pointed("type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nstart_rate_deg_s = 90.0", 2.0, "step_s = 0.01", "");
    let turn =
        foldwing::plant::Turn::of(&machine(&alone), Some("mount"), Some(8.0), 64).expect_err("no turn").to_string();
    assert!(turn.contains("slender bodies"), "{turn}");
}

/// SB-15. Faulty slender bodies are rejected with key and line.
#[test]
fn sb15_faulty_slender_bodies_are_refused_by_key() {
    let rows = GLIDER.lines().find(|line| line.starts_with("radius_m")).unwrap();
    let with = |other: &str| GLIDER.replace(rows, other);
    let second =
        "[aerodynamics.other]\nmodel = \"slender_body\"\nbody = \"fuselage\"\nradius_m = [[0.0, 0.0], [3.0, 0.1]]\n";
    let cases: Vec<(String, &[&str])> = vec![
        (GLIDER.replace("body = \"fuselage\"\nradius_m", "radius_m"), &["aerodynamics.fuselage.body"]),
        (
            GLIDER.replace("body = \"fuselage\"\nradius_m", "body = \"fuselag\"\nradius_m"),
            &["aerodynamics.fuselage.body", "fuselage"],
        ),
        (
            with("radius_m = [[0.0, 0.0], [0.3, 0.1]]")
                .replace("body = \"fuselage\"\nradius_m", "body = \"fin\"\nradius_m"),
            &["without a lifting surface"],
        ),
        (with(""), &["aerodynamics.fuselage.radius_m", "position in m, radius in m"]),
        (with("radius_m = [[0.0, 0.1]]"), &["aerodynamics.fuselage.radius_m"]),
        (with("radius_m = [[0.0, 0.1], [0.0, 0.2]]"), &["aerodynamics.fuselage.radius_m", "ascending"]),
        (with("radius_m = [[0.0, 0.0], [1.0, 0.0]]"), &["aerodynamics.fuselage.radius_m", "not all 0"]),
        (with("radius_m = [[0.0, 0.1], [1.0, -0.1]]"), &["aerodynamics.fuselage.radius_m"]),
        (with("radius_m = [[0.0, 0.1], [3.5, 0.1]]"), &["aerodynamics.fuselage.radius_m", "3"]),
        (with("radius_m = [[-0.5, 0.1], [2.5, 0.1]]"), &["aerodynamics.fuselage.radius_m", "from 0 to 3"]),
        (GLIDER.replace("segments = 12", "segments = 3"), &["aerodynamics.fuselage.segments", "at least 7"]),
        (GLIDER.replace("segments = 12", "segments = 0"), &["aerodynamics.fuselage.segments"]),
        (
            GLIDER.replace("cross_flow_drag_coefficient = 1.2", "cross_flow_drag_coefficient = -1.0"),
            &["cross_flow_drag_coefficient"],
        ),
        (GLIDER.replace("segments = 12", "quasi_steady = true"), &["aerodynamics.fuselage.quasi_steady", "strip"]),
        (GLIDER.replace("segments = 12", "hub = \"fin\""), &["aerodynamics.fuselage.hub", "bem"]),
        (
            GLIDER.replace("model = \"strip\"", "model = \"strip\"\nsegments = 4"),
            &["aerodynamics.surfaces.segments", "slender_body"],
        ),
        (
            GLIDER.replace("[aerodynamics.surfaces]\nmodel = \"strip\"\n", ""),
            &["surface.", "a surface that belongs to no part"],
        ),
        (GLIDER.to_owned() + second, &["aerodynamics.other.body", "one slender body per body"]),
        (
            TWIN.to_owned() + &second.replace("\"fuselage\"", "\"tower\""),
            &["wind", "strips and slender bodies do not use the wind field"],
        ),
        (
            pointed("type = \"revolute\"\naxis = [0.0, 1.0, 0.0]", 2.0, "wind_m_s = [5.0, 0.0, 0.0]", ""),
            &["aerodynamics.step_s", "no default without a surface"],
        ),
    ];
    for (text, words) in cases {
        assert!(text != GLIDER, "{words:?}");
        let told = foldwing::config::parse(&text, "slender.toml").expect_err(words[0]).to_string();
        for word in words {
            assert!(told.contains(word), "{word:?} is missing in {told}");
        }
        assert!(told.contains("slender.toml:"), "{told}");
    }
    // the longest intervals are divided
    let parted = machine(GLIDER);
    let (_, body) = parted.air.as_ref().unwrap().slender_bodies().next().unwrap();
    let longest_m = body.positions_m.windows(2).map(|ends_m| ends_m[1] - ends_m[0]).fold(0.0, f64::max);
    assert!(body.positions_m.len() == 13 && (longest_m - 0.3).abs() < 1e-12, "{:?}", body.positions_m);
    // a machine that was changed directly
    let mut changed = machine(GLIDER);
    let air = changed.air.as_mut().unwrap();
    let foldwing::machine::AirOptions::SlenderBody(body) = &mut air.parts[1].options else { panic!("a slender body") };
    body.radii_m.pop();
    body.rigid = true;
    air.parts[1].surfaces = vec![0];
    let faults = changed.validate();
    for allowed in
        ["a finite radius >= 0 m at every position", "on a rigid body, and only there", "no surface in a part"]
    {
        assert!(faults.iter().any(|fault| fault.allowed.contains(allowed)), "{allowed}: {faults:?}");
    }
}

//! Slender bodies in continuous time and in linear models: SB-17 and following, eqs. (W21) and (W22).

use crate::counting_allocator::allocations;
use crate::rotor::several::{machine, started};
use crate::slender::machines::{GLIDER, apparent_kg, pointed};
use crate::slender::{DENSITY_KG_M3, POINTED, body, moment};
use foldwing::aero::AirLoads;
use foldwing::aero::flow::Flow;
use foldwing::aero::slender::SlenderBody;
use foldwing::aero::strip::instant::Instant;
use foldwing::interface::{Interface, LinearModel};
use foldwing::load::SectionMotion;
use foldwing::plant::{Holding, Hybrid, Plant};
use foldwing::study::flutter;
use nalgebra::{Complex, Rotation3, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;

/// SB-17. Loads at an instant are the limit of those of steps: a body that moves and turns, and bends if it is flexible, in a wind on a root
/// that turns. The rate of the momentum over a step is that in its middle: errors of two step lengths fall in proportion to them.
#[test]
fn sb17_instants_are_the_limit_of_steps() {
    for rigid in [true, false] {
        let options = body(&POINTED, rigid);
        let flow = Flow {
            time_s: 0.0,
            density_kg_m3: DENSITY_KG_M3,
            wind_m_s: Vector3::new(9.0, -2.0, 1.5),
            spin_rad_s: Vector3::new(0.3, -0.5, 0.4),
            gusts: &[],
        };
        let spin_rad_s = Vector3::new(0.7, 0.9, -1.1);
        let start = Rotation3::new(Vector3::new(0.2, -0.3, 0.4));
        // a constant angular velocity in the root frame; a flexible body also bends
        let at = |time_s: f64| -> (Vec<SectionMotion>, Vec<[Vector3<f64>; 2]>) {
            let attitude = Rotation3::new(spin_rad_s * time_s) * start;
            let speed_m_s = Vector3::new(1.0, 0.5, -0.8);
            let pulled_m_s2 = Vector3::new(-3.0, 4.0, 2.0);
            let origin_m = Vector3::new(0.4, 0.1, -0.2) + speed_m_s * time_s + pulled_m_s2 * (0.5 * time_s * time_s);
            let section = |s: &f64| {
                let bend = if rigid { 0.0 } else { 0.1 * s * s };
                let (shift_m, shift_m_s, shift_m_s2) = (
                    bend * (3.0 * time_s).sin(),
                    3.0 * bend * (3.0 * time_s).cos(),
                    -9.0 * bend * (3.0 * time_s).sin(),
                );
                let reach_m = if rigid { 0.0 } else { *s };
                let own = Vector3::new(reach_m, 0.0, shift_m);
                let place_m = attitude * own;
                let [moved_m_s, pulled] = [shift_m_s, shift_m_s2].map(|own| attitude * Vector3::new(0.0, 0.0, own));
                let swing_m_s = spin_rad_s.cross(&place_m);
                let motion = SectionMotion {
                    rotation: attitude.into_inner(),
                    position_m: origin_m + place_m,
                    velocity_m_s: speed_m_s + pulled_m_s2 * time_s + swing_m_s + moved_m_s,
                    spin_rad_s,
                };
                let second_m_s2 =
                    pulled_m_s2 + spin_rad_s.cross(&swing_m_s) + 2.0 * spin_rad_s.cross(&moved_m_s) + pulled;
                (motion, [second_m_s2, Vector3::zeros()])
            };
            options.positions_m.iter().map(section).unzip()
        };
        let time_s = 0.3;
        let (motions, accelerations) = at(time_s);
        let instant = Instant {
            motions: motions.as_slice().into(),
            accelerations: accelerations.into(),
            flow,
            gust_m_s: Vector3::zeros(),
            lags: Vec::new().into(),
            flaps: Vec::new().into(),
            flap_rad_s2: Vec::new().into(),
        };
        let mut model = SlenderBody::new(&options);
        let mut answer = vec![0.0; 6 * motions.len()];
        model.respond(&instant, &mut answer);
        let errors = [2e-4, 1e-4].map(|step_s| {
            let (mut from, mut to) = (model.blank_state(), model.blank_state());
            let mut loads = AirLoads::still(motions.len());
            model.start(&at(time_s - step_s).0, &flow, &mut from, &mut loads);
            model.solve(&from, &motions, &flow, step_s, &mut to, &mut loads);
            let (mut largest, mut size) = (0.0_f64, 0.0_f64);
            for (section, motion) in motions.iter().enumerate() {
                let force_n = loads.circulatory[section].force_n + loads.impulsive[section].force_n;
                let moment_n_m = loads.circulatory[section].moment_n_m + loads.impulsive[section].moment_n_m;
                for (part, vector) in [force_n, moment_n_m].into_iter().enumerate() {
                    let own = Vector3::from_column_slice(&answer[6 * section + 3 * part..][..3]);
                    largest = largest.max((motion.rotation * own - vector).norm());
                    size = size.max(vector.norm());
                }
            }
            largest / size
        });
        println!("SB-17: rigid {rigid}: {:.1e} {:.1e}", errors[0], errors[1]);
        let order = (errors[0] / errors[1]).log2();
        assert!(errors[1] < 1e-3 && (0.9..1.1).contains(&order), "{errors:?}, order {order}");
    }
}

/// Linear model about the equilibrium with the outputs of some names.
fn linear(text: &str, inputs: &[&str], outputs: &[&str]) -> (Plant, LinearModel) {
    let mut plant = Plant::new(Arc::new(machine(text)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::new(plant.machine());
    let rows = |names: &[&str]| names.iter().map(|name| interface.find(name).expect("a row")).collect::<Vec<_>>();
    let model = interface.linearize(&mut plant, &rows(inputs), &rows(outputs));
    (plant, model.unwrap_or_else(|error| panic!("{error}")))
}

/// SB-18. A rigid body on a torsion spring in a stream along its axis, closed or with an open base of area `A` at `L` behind the pivot:
/// `(J + ρ∫A s² ds) α̈ + (c + ρ U A L²) α̇ + (k + ρ U² (A L − V)) α = 0`. The moment of Munk opposes the spring, the base alone damps; drag
/// across and along the body has no linear effect. Coefficients, eigenvalues of the modes, the verdict on stability, and the speed of
/// divergence `√(k/ρV)` of the closed body.
#[test]
fn sb18_body_on_a_torsion_spring() {
    let (mass_kg, spring_n_m, damping_n_m_s) = (2.0, 40.0, 0.7);
    let volume_m3 = moment(&POINTED, 0);
    let open = POINTED.map(|[s, r]| if s == 1.6 { [s, 0.08] } else { [s, r] });
    let text = |rows: &[[f64; 2]], wind_m_s: f64| {
        let joint = format!(
            "type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\n[joint.mount.motor]\nstiffness_N_m_rad = {spring_n_m:?}\n\
             damping_N_m_s_rad = {damping_n_m_s:?}"
        );
        let drag = "cross_flow_drag_coefficient = 1.2\naxial_drag_coefficient = 0.1";
        pointed(&joint, mass_kg, &format!("wind_m_s = [{wind_m_s:?}, 0.0, 0.0]\nstep_s = 0.01"), drag)
            .replace(&format!("{POINTED:?}"), &format!("{rows:?}"))
    };
    let divergence_m_s = (spring_n_m / volume_m3).sqrt();
    for (rows, speed_m_s) in
        [(POINTED, 0.6), (POINTED, 1.2), (open, 0.6), (open, 1.2)].map(|(rows, share)| (rows, share * divergence_m_s))
    {
        let base_m2 = PI * rows[4][1] * rows[4][1];
        let inertia = 0.4 * mass_kg + mass_kg * 0.04 + moment(&rows, 2);
        let damping = damping_n_m_s + speed_m_s * base_m2 * 1.6 * 1.6;
        let stiffness = spring_n_m + speed_m_s * speed_m_s * (base_m2 * 1.6 - moment(&rows, 0));
        let (mut plant, model) = linear(&text(&rows, speed_m_s), &["wind.velocity.z"], &["mount.angle"]);
        let a = &model.matrices.a;
        assert_eq!(a.nrows(), 2);
        println!(
            "SB-18: {:.3} of {:.3} and {:.4} of {:.4}",
            a[(1, 0)],
            -stiffness / inertia,
            a[(1, 1)],
            -damping / inertia
        );
        approx::assert_relative_eq!(a[(1, 0)], -stiffness / inertia, max_relative = 1e-9);
        approx::assert_relative_eq!(a[(1, 1)], -damping / inertia, max_relative = 1e-9);
        let (half, square) = (0.5 * damping / inertia, stiffness / inertia);
        let modes = plant.study().modes(2).unwrap_or_else(|error| panic!("{error}"));
        let stability = plant.study().stability().unwrap_or_else(|error| panic!("{error}"));
        let fastest = modes.iter().map(|mode| mode.eigenvalue_1_s.re).fold(f64::NEG_INFINITY, f64::max);
        let due = if square > half * half { -half } else { -half + (half * half - square).sqrt() };
        approx::assert_relative_eq!(fastest, due, max_relative = 1e-9);
        assert!(stability.not_judged.is_none() && stability.is_stable() == (stiffness > 0.0), "{stability:?}");
    }
    let speeds: Vec<f64> = (1..=8).map(|i| 0.2 * f64::from(i) * divergence_m_s).collect();
    let plant = Plant::new(Arc::new(machine(&text(&POINTED, 1.0))));
    let found = flutter::sweep(plant, &flutter::Options { wind_m_s: speeds, count: 1 });
    let found = found.unwrap_or_else(|error| panic!("{error}"));
    println!("SB-18: divergence at {:?} m/s of {divergence_m_s:.6}", found.divergence_m_s);
    assert_eq!(found.divergence_m_s.len(), 1);
    approx::assert_relative_eq!(found.divergence_m_s[0], divergence_m_s, max_relative = 1e-9);
}

/// A stiff wing of chord 0.5 m and span 2 m on a rigid pod that pitches on a spring, with the slender body or without.
fn winged_pod(with_body: bool) -> String {
    let hull = format!(
        "[aerodynamics.pod]\nmodel = \"slender_body\"\nbody = \"pod\"\nradius_m = {POINTED:?}\napparent_mass = false\n"
    );
    format!(
        "name = \"Winged\"\n[rigid_body.pod]\nmass_kg = 5.0\ninertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]\n\
         [joint.pitch]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"pod\"\naxis = [0.0, 1.0, 0.0]\n\
         [joint.pitch.motor]\nstiffness_N_m_rad = 1e4\n[section.stiff]\nshape = \"explicit\"\naxial_stiffness_N = 1e8\n\
         torsional_rigidity_N_m2 = 1e6\nflap_stiffness_N_m2 = 1e6\nedge_stiffness_N_m2 = 1e6\nmass_kg_m = 0.5\n\
         second_moments_kg_m = [0.01, 0.0, 0.01]\nhalf_width_m = 0.1\nhalf_height_m = 0.1\n[body.wing]\nsection = \"stiff\"\n\
         length_m = 2.0\nelements = 1\n[joint.mount]\ntype = \"clamped\"\nparent = \"pod\"\n\
         parent_offset_m = [0.1, 0.0, 0.0]\nchild = \"wing\"\nmount_rotation_deg = [0.0, 0.0, 90.0]\n\
         [surface.wing]\nbody = \"wing\"\nchord_m = 0.5\nelastic_axis_fraction = 0.25\nleading_edge = \"+y\"\n\
         strips = 4\n[aerodynamics]\ndensity_kg_m3 = 1.0\nwind_m_s = [15.0, 0.0, 0.0]\nstep_s = 0.01\n\
         [aerodynamics.wing]\nmodel = \"strip\"\nquasi_steady = true\napparent_mass = false\ntip_loss = \"none\"\n{}",
        if with_body { hull } else { String::new() }
    )
}

/// SB-24. The linear model of a body on a spring along z, across the wind, in a wind along z that varies: the apparent mass `M = ρV` follows
/// the difference of the velocities, `(m + M) z̈ + k z = M ẇ`, so that `ż/w = M s²/((m + M) s² + k)`, below and above the natural frequency.
#[test]
fn sb24_a_wind_that_varies_moves_a_body_on_a_slide() {
    let (mass_kg, spring_n_m) = (0.3, 40.0);
    let joint =
        format!("type = \"prismatic\"\naxis = [0.0, 0.0, 1.0]\n[joint.mount.spring]\nstiffness_N_m = {spring_n_m:?}");
    let text = pointed(&joint, mass_kg, "wind_m_s = [6.0, 0.0, 0.0]\nstep_s = 0.01", "");
    let (_, model) = linear(&text, &["wind.velocity.z"], &["mount.velocity"]);
    let [a, b, c, d] =
        [&model.matrices.a, &model.matrices.b, &model.matrices.c, &model.matrices.d].map(|m| m.map(Complex::from));
    let apparent_kg = apparent_kg();
    for rate_rad_s in [2.0, 9.0, 40.0] {
        let s = Complex::new(0.0, rate_rad_s);
        let states = (nalgebra::DMatrix::identity(a.nrows(), a.nrows()) * s - &a).lu().solve(&b).expect("no pole");
        let found = (&c * states + &d)[(0, 0)];
        let due = s * s * apparent_kg / (s * s * (mass_kg + apparent_kg) + spring_n_m);
        println!("SB-24: {rate_rad_s} rad/s: {found:.6} of {due:.6}");
        assert!((found - due).norm() < 1e-9 * due.norm(), "{found} of {due}");
    }
}

/// SB-19. A closed body under a wing moves the neutral point forward by `2V/(S a)`: the moment of Munk over the lift of the wing, of slope
/// `a = 2π` by strips (Multhopp's first term). From the gains of force and moment in the linear model.
#[test]
fn sb19_a_fuselage_moves_the_neutral_point() {
    let behind_m = |with_body: bool| {
        let outputs = ["aero.force.z", "aero.moment.y"];
        let (_, model) = linear(&winged_pod(with_body), &["wind.velocity.z"], &outputs);
        let d = &model.matrices.d;
        (-d[(1, 0)] / d[(0, 0)], d[(0, 0)])
    };
    let [(alone_m, lift), (both_m, lift_of_both)] = [false, true].map(behind_m);
    let shift_m = 2.0 * moment(&POINTED, 0) / (1.0 * 2.0 * PI);
    println!(
        "SB-19: neutral point {alone_m:.6} m, with the body {both_m:.6} m; {:.6} of {shift_m:.6}",
        alone_m - both_m
    );
    approx::assert_relative_eq!(lift, lift_of_both, max_relative = 1e-9);
    // the quarter chord line
    approx::assert_relative_eq!(alone_m, 0.1, max_relative = 1e-9);
    approx::assert_relative_eq!(alone_m - both_m, shift_m, max_relative = 1e-9);
}

/// Angle of the body of SB-18, released at 0.01°, after a time.
fn oscillation(speed_m_s: f64, end_s: f64) -> f64 {
    let inertia = 0.88 + moment(&POINTED, 2);
    let stiffness = 40.0 - apparent_kg() * speed_m_s * speed_m_s;
    let half = 0.35 / inertia;
    let turning = (stiffness / inertia - half * half).sqrt();
    let (sine, cosine) = (turning * end_s).sin_cos();
    0.01_f64.to_radians() * (-half * end_s).exp() * (cosine + half / turning * sine)
}

/// SB-20. In a run the body on the torsion spring oscillates as its eigenvalue says: frequency and decay over two periods, with steps of
/// the air that are halved; the error falls with the square of the step.
#[test]
fn sb20_runs_follow_the_linear_model() {
    let joint = "type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nstart_angle_deg = 0.01\n[joint.mount.motor]\nstiffness_N_m_rad = 40.0\n\
                 damping_N_m_s_rad = 0.7";
    let (speed_m_s, end_s) = (8.0, 1.0);
    let due = oscillation(speed_m_s, end_s);
    let errors = [0.01, 0.005].map(|step_s| {
        let text = pointed(joint, 2.0, &format!("wind_m_s = [{speed_m_s:?}, 0.0, 0.0]\nstep_s = {step_s:?}"), "");
        let mut plant = started(&text);
        plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
        (plant.outputs().joints()[0].angle_rad - due) / 0.01_f64.to_radians()
    });
    println!("SB-20: {:.2e} {:.2e}", errors[0], errors[1]);
    let ratio = errors[0] / errors[1];
    assert!(errors[1].abs() < 2e-3 && (3.5..4.5).contains(&ratio), "{errors:?}");
}

/// A classical Runge–Kutta step of a machine as a hybrid system.
fn outside_step(hybrid: &mut Hybrid, states: &mut Vec<f64>, step_s: f64) {
    let (begin_s, begin) = (hybrid.time_s(), states.clone());
    let (mut slope, mut end) = (vec![0.0; begin.len()], begin.clone());
    for (place, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
        let at: Vec<f64> = begin.iter().zip(&slope).map(|(x, slope)| x + place * step_s * slope).collect();
        hybrid.set(begin_s + place * step_s, &at);
        hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
        end.iter_mut().zip(&slope).for_each(|(x, slope)| *x += weight / 6.0 * step_s * slope);
    }
    hybrid.set(begin_s + step_s, &end);
    hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
    hybrid.complete();
    *states = end;
}

/// SB-21. An external integrator: the body on the torsion spring oscillates by its equation, without steps of the air. What is left is the
/// square of the angle and the error of the Runge–Kutta rule.
#[test]
fn sb21_an_integrator_from_outside() {
    let joint = "type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nstart_angle_deg = 0.01\n[joint.mount.motor]\nstiffness_N_m_rad = 40.0\n\
                 damping_N_m_s_rad = 0.7";
    let speed_m_s = 8.0_f64;
    let mut plant = started(&pointed(joint, 2.0, &format!("wind_m_s = [{speed_m_s:?}, 0.0, 0.0]\nstep_s = 0.01"), ""));
    let mut hybrid = plant.hybrid().unwrap_or_else(|refused| panic!("{refused}"));
    let mut states = vec![0.0; hybrid.states()];
    hybrid.read(&mut states);
    assert_eq!(states.len(), 2);
    for _ in 0..1000 {
        outside_step(&mut hybrid, &mut states, 1e-3);
    }
    let due = oscillation(speed_m_s, 1.0);
    let start = 0.01_f64.to_radians();
    println!("SB-21: {:.6} of {:.6}", states[0] / start, due / start);
    assert!((states[0] - due).abs() < 1e-7 * start, "{} for {due}", states[0]);
}

/// SB-22. Derivatives of strips with a slender body allocate nothing. The internal integrator continues from states that were set: the body
/// on the torsion spring, at rest until it is set into motion, keeps its velocity, with the momentum that the air then has.
#[test]
fn sb22_steps_continue_from_an_integrator_outside() {
    let mut plant = started(GLIDER);
    plant.step(0.02).unwrap_or_else(|error| panic!("{error}"));
    let mut hybrid = plant.hybrid().unwrap_or_else(|refused| panic!("{refused}"));
    let (mut states, mut slope) = (vec![0.0; hybrid.states()], vec![0.0; hybrid.states()]);
    hybrid.read(&mut states);
    let time_s = hybrid.time_s();
    let mut evaluate = |shift: f64| {
        states.iter_mut().for_each(|state| *state += shift);
        hybrid.set(time_s, &states);
        hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
    };
    evaluate(1e-7);
    let before = allocations();
    assert!(before > 0, "the counter counts");
    (0..5).for_each(|_| evaluate(1e-7));
    assert_eq!(allocations(), before);
    let joint = "type = \"revolute\"\naxis = [0.0, 1.0, 0.0]\n[joint.mount.motor]\nstiffness_N_m_rad = 40.0";
    let mut plant = started(&pointed(joint, 2.0, "wind_m_s = [8.0, 0.0, 0.0]\nstep_s = 0.001", ""));
    let mut hybrid = plant.hybrid().unwrap_or_else(|refused| panic!("{refused}"));
    hybrid.set(0.0, &[0.0, 0.1]);
    hybrid.derivatives(&mut [0.0; 2]).unwrap_or_else(|error| panic!("{error}"));
    hybrid.complete();
    plant.step(0.01).unwrap_or_else(|error| panic!("{error}"));
    let stiffness = 40.0 - apparent_kg() * 64.0;
    let due = 0.1 * (0.01 * (stiffness / (0.88 + moment(&POINTED, 2))).sqrt()).cos();
    let rate = plant.outputs().joints()[0].rate_rad_s;
    println!("SB-22: {rate:.6} of {due:.6}");
    approx::assert_relative_eq!(rate, due, max_relative = 1e-3);
}

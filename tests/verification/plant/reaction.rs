//! Root force and moment against weight, loads and the rate of momentum.

use crate::plant::machines::*;
use foldwing::load::{LoadFrame, Wrench};
use foldwing::machine::{AttachedMass, ElementKind, Machine, Method};
use foldwing::plant::{Inputs, Outputs};
use nalgebra::{Matrix3, Vector3};

/// P-60. Reaction of a wing in equilibrium to its weight: force `m g`, moment `Σ r × m g`, offset mass included.
///
/// 1e4 times as stiff: deflections of 1e-6 of the length remain. The motion decays at 30 1/s: e⁻⁶⁰ at 2 s.
#[test]
fn p60_reaction_of_a_wing_at_rest_is_its_weight() {
    let mut section = wing_section();
    section.stiffness *= 1e4;
    let wing = body("wing", 0.3, &section, ElementKind::Linear, 3).mass_damping_1_s(60.0).stiffness_damping_s(1e-4);
    let mut machine = machine([(wing, clamped())]);
    let offset_m = Vector3::new(0.01, 0.04, -0.02);
    machine.bodies[0].masses = vec![AttachedMass { offset_m, ..AttachedMass::point("offset", 0.2, 0.05) }];
    let gravity = Vector3::new(2.0, -3.0, -9.0);
    machine.gravity_m_s2 = gravity;
    let mut plant = start(machine);
    coast(&mut plant, 2.0);
    let beam_kg = section.mass_kg_m * 0.3;
    assert!((plant.mass_kg() - beam_kg - 0.05).abs() < 1e-14, "mass {} kg", plant.mass_kg());
    let force_n = gravity * (beam_kg + 0.05);
    let moment_n_m = (Vector3::new(0.15, 0.0, 0.0) * beam_kg + Vector3::new(0.21, 0.04, -0.02) * 0.05).cross(&gravity);
    let root = plant.outputs().root();
    let (force_error_n, moment_error_n_m) = ((root.force_n - force_n).norm(), (root.moment_n_m - moment_n_m).norm());
    println!("force misses by {force_error_n:.1e} N, moment by {moment_error_n_m:.1e} N·m");
    assert!(force_error_n < 1e-9 * force_n.norm(), "force misses by {force_error_n:.1e} N");
    assert!(moment_error_n_m < 1e-4 * moment_n_m.norm(), "moment misses by {moment_error_n_m:.1e} N·m");
}

/// Abscissae and weights of three Gauss points on `[0, 1]`.
const GAUSS_3: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// The wing on a skew hinge without latch and damping, stations at three Gauss points of every half of a pair.
fn observed_wing(pairs: usize) -> Machine {
    let mut machine = wing(ElementKind::Linear, pairs, Method::Esdirk4, 1e-9);
    let hinge = hinge_of(&mut machine, 1);
    (hinge.axis, hinge.latch) = (Vector3::new(0.2, 0.95, 0.1).normalize(), None);
    let half_m = 0.15 / (2 * pairs) as f64;
    for body in &mut machine.bodies {
        (body.mass_damping_1_s, body.stiffness_damping_s) = (0.0, 2e-5);
        body.station_positions_m = (0..2 * pairs).flat_map(|i| GAUSS_3.map(|(s, _)| (i as f64 + s) * half_m)).collect();
    }
    machine.bodies[1].load_frame = LoadFrame::Section;
    machine
}

/// First moment of mass (kg·m), momentum (kg·m/s) and angular momentum about the origin (kg·m²/s), for the velocities relative to the root
/// frame plus a spin, by quadrature over the stations.
struct Momentum {
    first_moment: Vector3<f64>,
    linear: Vector3<f64>,
    angular: Vector3<f64>,
}

fn momentum(machine: &Machine, outputs: &Outputs, own: f64, spin: Vector3<f64>) -> Momentum {
    let section = wing_section();
    let stations_per_body = outputs.stations().len() / 2;
    let spacing_m = 0.15 / (stations_per_body / 3) as f64;
    let [yy, _, zz] = section.second_moment_kg_m;
    let inertia = Matrix3::from_diagonal(&Vector3::new(yy + zz, zz, yy));
    let zero = Vector3::zeros();
    let mut sum = Momentum { first_moment: zero, linear: zero, angular: zero };
    let mut add = |mass_kg: f64, position: Vector3<f64>, velocity: Vector3<f64>| {
        sum.first_moment += position * mass_kg;
        sum.linear += velocity * mass_kg;
        sum.angular += position.cross(&velocity) * mass_kg;
    };
    let mut rotary = zero;
    for (i, point) in outputs.stations().iter().enumerate() {
        let length_m = GAUSS_3[i % 3].1 * spacing_m;
        let r = point.position_m;
        add(section.mass_kg_m * length_m, r, point.velocity_m_s * own + spin.cross(&r));
        let rotation = point.rotation.to_rotation_matrix().into_inner();
        let turning = point.angular_velocity_rad_s * own + spin;
        rotary += rotation * inertia * rotation.transpose() * turning * length_m;
    }
    // the actuator at the end of the inner body: its position and velocity by extrapolation from the last three stations
    let last: [usize; 3] = std::array::from_fn(|k| stations_per_body - 3 + k);
    let weights = [0, 1, 2].map(|k| {
        (0..3).filter(|&j| j != k).map(|j| (1.0 - GAUSS_3[j].0) / (GAUSS_3[k].0 - GAUSS_3[j].0)).product::<f64>()
    });
    let blend =
        |value: &dyn Fn(usize) -> Vector3<f64>| (0..3).map(|k| value(last[k]) * weights[k]).sum::<Vector3<f64>>();
    let r = blend(&|i| outputs.stations()[i].position_m);
    let v = blend(&|i| outputs.stations()[i].velocity_m_s);
    add(machine.bodies[0].masses[0].mass_kg, r, v * own + spin.cross(&r));
    sum.angular += rotary;
    sum
}

/// Force and moment about the origin, in the root frame, of the loads at the stations of the wing.
fn loads(outputs: &Outputs, inputs: &Inputs) -> Wrench {
    let inner = outputs.stations().len() / 2;
    let mut sum = Wrench::default();
    for (i, (point, load)) in outputs.stations().iter().zip(inputs.stations()).enumerate() {
        let turn = |vector: Vector3<f64>| if i < inner { vector } else { point.rotation * vector };
        sum.force_n += turn(load.force_n);
        sum.moment_n_m += turn(load.moment_n_m) + point.position_m.cross(&turn(load.force_n));
    }
    sum
}

/// P-61. `root = weight + loads − rate of momentum`, force and moment, on a root that accelerates and rotates.
///
/// Momentum by quadrature over stations, its rate by central differences of 2e-5 s: the engine's inertia is not used. The difference falls
/// with mesh refinement: kinematics between nodes follow the strain field here and ANCF shape functions in the inertia. The tolerance of
/// 1e-9 makes rates between the ends of steps accurate enough. Limit: 1e-4 of the largest inertia force with 8 pairs, and a fifth of the
/// error of 4 pairs. Stiffness-proportional damping is internal and only damps modes that differences over 2e-5 s do not resolve.
#[test]
fn p61_reaction_balances_momentum() {
    let errors = [2, 4, 8].map(|pairs| {
        let machine = observed_wing(pairs);
        let mut plant = start(machine.clone());
        let inner = plant.inputs().stations().len() / 2;
        let inputs = plant.inputs_mut();
        inputs.stations_mut()[2].force_n = Vector3::new(0.02, 0.03, -0.05);
        inputs.stations_mut()[inner + 3].force_n = Vector3::new(0.0, 0.03, 0.05);
        inputs.stations_mut()[inner + 4].moment_n_m = Vector3::new(0.002, 0.001, 0.0);
        inputs.root_mut().acceleration_m_s2 = Vector3::new(1.0, 2.0, -3.0);
        inputs.root_mut().angular_velocity_rad_s = Vector3::new(2.0, -3.0, 1.0);
        inputs.root_mut().angular_acceleration_rad_s2 = Vector3::new(-20.0, 10.0, 30.0);
        let inputs = plant.inputs().clone();
        let root = inputs.root();
        let (spin, field) = (root.angular_velocity_rad_s, root.gravity_m_s2 - root.acceleration_m_s2);
        let (mut force_error, mut moment_error, mut force_scale, mut moment_scale) = (0f64, 0f64, 0f64, 0f64);
        const DIFFERENCE_S: f64 = 1e-5;
        for time_s in [0.03, 0.05, 0.07, 0.09] {
            let mut at = |time_s: f64| {
                coast(&mut plant, time_s);
                plant.outputs().clone()
            };
            let outputs = [at(time_s - DIFFERENCE_S), at(time_s), at(time_s + DIFFERENCE_S)];
            let [before, now, after] = outputs.each_ref().map(|outputs| momentum(&machine, outputs, 1.0, spin));
            let euler = momentum(&machine, &outputs[1], 0.0, root.angular_acceleration_rad_s2);
            let rate = |before: Vector3<f64>, now: Vector3<f64>, after: Vector3<f64>, euler: Vector3<f64>| {
                (after - before) / (2.0 * DIFFERENCE_S) + spin.cross(&now) + euler
            };
            let loads = loads(&outputs[1], &inputs);
            let linear = rate(before.linear, now.linear, after.linear, euler.linear);
            let angular = rate(before.angular, now.angular, after.angular, euler.angular);
            let force_n = field * plant.mass_kg() + loads.force_n - linear;
            let moment_n_m = now.first_moment.cross(&field) + loads.moment_n_m - angular;
            let own = outputs[1].root();
            force_error = force_error.max((own.force_n - force_n).norm());
            moment_error = moment_error.max((own.moment_n_m - moment_n_m).norm());
            force_scale = force_scale.max(linear.norm());
            moment_scale = moment_scale.max(angular.norm());
        }
        println!("{pairs} pairs: force {force_error:.1e} of {force_scale:.2} N, moment {moment_error:.1e} of {moment_scale:.3} N·m");
        [force_error / force_scale, moment_error / moment_scale]
    });
    let [_, middle, fine] = errors;
    assert!(fine[0] < 1e-4 && fine[1] < 1e-4, "relative errors {fine:?} with 8 pairs");
    assert!(fine[0] < 0.25 * middle[0] && fine[1] < 0.25 * middle[1], "relative errors {errors:?} do not fall");
}

//! Internal loads, joint reactions and accelerations at every position: against theory, balances and differences.

use crate::plant::machines::*;
use foldwing::beam::section::Section;
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::machine::*;
use foldwing::plant::{Outputs, Plant, PointOutputs};
use nalgebra::{Matrix3, Vector3};

fn place(name: &str, body: usize, position_m: f64, side: SectionSide) -> InternalLoad {
    InternalLoad { name: name.into(), body, position_m, side }
}

fn inboard(body: usize, position_m: f64) -> InternalLoad {
    place("place", body, position_m, SectionSide::Inboard)
}

/// The wing's section, so stiff that the shape of the wing changes by only 1e-6 of its length.
fn stiff_section() -> Section {
    let mut section = wing_section();
    section.stiffness *= 1e6;
    section
}

/// The wing's section with shear flexibility along `y` and `z`: a hundredth of the axial stiffness, coupled with twist and bending.
fn soft_in_shear() -> Section {
    let mut section = wing_section();
    let mut whole = nalgebra::Matrix6::zeros();
    whole.fixed_view_mut::<4, 4>(0, 0).copy_from(&section.stiffness);
    let shear_n = 0.01 * section.stiffness[(0, 0)];
    for (shear, strain) in [(4, 1), (5, 2)] {
        whole[(shear, shear)] = shear_n;
        let coupling = 0.3 * (shear_n * whole[(strain, strain)]).sqrt();
        (whole[(shear, strain)], whole[(strain, shear)]) = (coupling, coupling);
    }
    section.stiffness = foldwing::beam::section::condensed(&whole).expect("positive definite");
    section.shear = Some(whole);
    section
}

const BEAM_M: f64 = 0.6;

/// A clamped beam that starts in equilibrium, with loads at two stations and two masses, and internal loads at `places_m`.
fn cantilever(kind: ElementKind, count: usize, places_m: &[f64]) -> Machine {
    let beam = body("wing", BEAM_M, &stiff_section(), kind, count)
        .load_station_positions_m([0.25, 0.6])
        .load_frame(LoadFrame::Section);
    let mut machine = machine([(beam, clamped())]);
    let offset_m = Vector3::new(0.0, 0.02, -0.03);
    let aside = AttachedMass { offset_m, ..AttachedMass::point("aside", 0.45, 0.05) };
    machine.bodies[0].masses = vec![aside, AttachedMass::point("tip", BEAM_M, 0.02)];
    machine.internal_loads = places_m.iter().map(|position_m| inboard(0, *position_m)).collect();
    machine.experiment.start = StartState::Equilibrium;
    machine
}

/// Positions on mesh boundaries, inside elements, and at attachments.
const PLACES_M: [f64; 9] = [0.0, 0.017, 0.1, 0.2499, 0.25, 0.31, 0.45, 0.52, 0.6];

/// P-140. A cantilever under its weight, with loads at stations inside elements and masses off its axis: shear, axial force, bending and
/// torsion of nine sections follow from statics, for both kinds of elements and any mesh.
///
/// The beam bends by less than 1e-6, so the difference from the closed form is of that order.
#[test]
fn p140_section_loads_of_a_cantilever_are_those_of_statics() {
    let gravity = Vector3::new(1.0, -2.0, -9.8);
    let loads = [
        (0.25, Wrench { force_n: Vector3::new(0.3, 0.7, -1.1), moment_n_m: Vector3::new(0.05, -0.02, 0.01) }),
        (0.6, Wrench { force_n: Vector3::new(2.0, -0.4, 1.3), moment_n_m: Vector3::new(0.03, 0.04, -0.06) }),
    ];
    for (kind, count) in [(ElementKind::Linear, 3), (ElementKind::Linear, 1), (ElementKind::Constant, 7)] {
        let mut machine = cantilever(kind, count, &PLACES_M);
        machine.gravity_m_s2 = gravity;
        machine.bodies[0].station_loads = loads.iter().map(|(_, load)| *load).collect();
        let plant = start(machine);
        let density_kg_m = wing_section().mass_kg_m;
        let mut worst = 0.0f64;
        for (position_m, found) in PLACES_M.iter().zip(plant.outputs().internal_loads()) {
            let rest_m = BEAM_M - position_m;
            let mut expected = Wrench::default();
            let mut add = |at: Vector3<f64>, force_n: Vector3<f64>, moment_n_m: Vector3<f64>| {
                expected.force_n += force_n;
                expected.moment_n_m += moment_n_m + (at - Vector3::x() * *position_m).cross(&force_n);
            };
            let centre = Vector3::x() * (position_m + 0.5 * rest_m);
            add(centre, gravity * (density_kg_m * rest_m), Vector3::zeros());
            if *position_m <= 0.45 {
                add(Vector3::new(0.45, 0.02, -0.03), gravity * 0.05, Vector3::zeros());
            }
            add(Vector3::x() * BEAM_M, gravity * 0.02, Vector3::zeros());
            for (at_m, load) in loads.iter().filter(|(at_m, _)| at_m >= position_m) {
                add(Vector3::x() * *at_m, load.force_n, load.moment_n_m);
            }
            let force = (found.force_n - expected.force_n).norm() / 4.0;
            let moment = (found.moment_n_m - expected.moment_n_m).norm() / 1.0;
            worst = worst.max(force).max(moment);
            assert!(
                force < 3e-6,
                "{kind:?} {count} at {position_m} m: {} N, right is {}",
                found.force_n,
                expected.force_n
            );
            assert!(
                moment < 3e-6,
                "{kind:?} {count} at {position_m} m: {} N·m, right is {}",
                found.moment_n_m,
                expected.moment_n_m
            );
        }
        println!("P-140 {kind:?}, {count}: {worst:.1e} of 4 N and 1 N·m");
    }
}

/// P-141. A beam in steady rotation about its root: `N(s) = ∫ ρA Ω² r dr` plus the contribution of the tip mass, at any position, even with
/// one linear element. The cubic of the axis represents the linear acceleration exactly; stretch is 1e-8.
#[test]
fn p141_axial_force_of_a_turning_beam() {
    let rate_rad_s = 20.0;
    for (kind, count) in [(ElementKind::Linear, 1), (ElementKind::Linear, 3), (ElementKind::Constant, 5)] {
        let mut machine = cantilever(kind, count, &PLACES_M);
        machine.bodies[0].masses.remove(0);
        let mut plant = Plant::new(std::sync::Arc::new(machine));
        plant.inputs_mut().root_mut().angular_velocity_rad_s = Vector3::z() * rate_rad_s;
        plant.initialize(0.0).expect("an equilibrium");
        let density_kg_m = wing_section().mass_kg_m;
        let mut worst = 0.0f64;
        for (position_m, found) in PLACES_M.iter().zip(plant.outputs().internal_loads()) {
            let square = BEAM_M * BEAM_M - position_m * position_m;
            let expected_n = rate_rad_s * rate_rad_s * (0.5 * density_kg_m * square + 0.02 * BEAM_M);
            let error = (found.force_n - Vector3::x() * expected_n).norm() / expected_n;
            worst = worst.max(error).max(found.moment_n_m.norm());
            assert!(error < 1e-6, "{kind:?} {count} at {position_m} m: {} N, right is {expected_n}", found.force_n);
            assert!(found.moment_n_m.norm() < 1e-9, "{kind:?} {count} at {position_m} m: {} N·m", found.moment_n_m);
        }
        println!("P-141 {kind:?}, {count}: {worst:.1e}");
    }
}

/// The deploying wing with a skew hinge on a moving root, loads at stations inside elements, an appendage on the inner body, at 0.05 s:
/// everything is in motion, and no term is small.
fn moving_wing(kind: ElementKind, count: usize, internal_loads: Vec<InternalLoad>) -> Machine {
    let mut machine = wing(kind, count, Method::Esdirk4, 1e-8);
    let hinge = hinge_of(&mut machine, 1);
    (hinge.axis, hinge.latch) = (Vector3::new(0.2, 0.95, 0.1).normalize(), None);
    for body in &mut machine.bodies {
        (body.mass_damping_1_s, body.stiffness_damping_s) = (0.7, 1e-4);
        body.station_positions_m = vec![0.04, 0.1];
        body.station_loads = vec![Wrench::default(); 2];
    }
    machine.bodies[1].load_frame = LoadFrame::Section;
    machine.internal_loads = internal_loads;
    machine
}

const ROOT: RootMotion = RootMotion {
    gravity_m_s2: Vector3::new(-9.8, 0.0, 0.0),
    acceleration_m_s2: Vector3::new(1.0, 2.0, -3.0),
    angular_velocity_rad_s: Vector3::new(2.0, -3.0, 1.0),
    angular_acceleration_rad_s2: Vector3::new(-20.0, 10.0, 30.0),
};

fn moved(machine: Machine, end_s: f64) -> Plant {
    let mut plant = start(machine);
    let inputs = plant.inputs_mut();
    *inputs.root_mut() = ROOT;
    for (i, load) in inputs.stations_mut().iter_mut().enumerate() {
        let i = i as f64;
        load.force_n = Vector3::new(0.02 * i - 0.03, 0.03, 0.05 - 0.02 * i);
        load.moment_n_m = Vector3::new(0.001, -0.002 * i, 0.002);
    }
    coast(&mut plant, end_s);
    plant
}

fn rotation(point: &PointOutputs) -> Matrix3<f64> {
    point.rotation.to_rotation_matrix().into_inner()
}

/// P-142. Internal loads jump by exactly the load at an attachment: the load of a station inside an element (root frame on the inner body,
/// section frame on the outer), and the reaction of a child's joint. At the root of a body they are its joint's reaction in the frame of
/// the section, with the opposite sign; at the free end they are zero. Case: a moving wing on a moving root.
#[test]
fn p142_section_loads_jump_by_what_is_attached() {
    use SectionSide::{Inboard, Outboard};
    for (kind, count) in [(ElementKind::Linear, 2), (ElementKind::Constant, 4)] {
        let mut cuts = Vec::new();
        for body in [0, 1] {
            cuts.extend([0.04, 0.1].map(|at| [Inboard, Outboard].map(|side| place("cut", body, at, side))).concat());
            cuts.push(inboard(body, 0.0));
            cuts.push(inboard(body, 0.15));
        }
        let plant = moved(moving_wing(kind, count, cuts), 0.05);
        let outputs = plant.outputs();
        let mut worst = 0.0f64;
        for body in [0, 1] {
            let found = &outputs.internal_loads()[6 * body..6 * body + 6];
            for station in [0, 1] {
                let index = 2 * body + station;
                let load = plant.inputs().stations()[index];
                let turn =
                    if body == 0 { rotation(&outputs.stations()[index]).transpose() } else { Matrix3::identity() };
                let jump = found[2 * station].force_n - found[2 * station + 1].force_n;
                let turned = found[2 * station].moment_n_m - found[2 * station + 1].moment_n_m;
                worst = worst.max((jump - turn * load.force_n).norm());
                worst = worst.max((turned - turn * load.moment_n_m).norm());
            }
            let joint = outputs.joint_reactions()[body];
            worst = worst.max((found[4].force_n.norm() - joint.force_n.norm()).abs());
            // about the hinge the joint outputs its torque, whereas the internal load follows from accelerations interpolated between two
            // steps
            let hinge = (found[4].moment_n_m.norm() - joint.moment_n_m.norm()).abs();
            assert!(hinge < 1e-9, "{kind:?}, body {body}: {hinge:.1e} N·m between joint and section");
        }
        // the inner body is clamped in the root frame
        let root = outputs.internal_loads()[4];
        worst = worst.max((root.force_n - outputs.root().force_n).norm());
        worst = worst.max((root.moment_n_m - outputs.root().moment_n_m).norm());
        let tip = outputs.internal_loads()[11];
        worst = worst.max(tip.force_n.norm()).max(tip.moment_n_m.norm());
        let largest = root.force_n.norm();
        println!("P-142 {kind:?}: {worst:.1e} of {largest:.2} N");
        assert!(largest > 0.1 && worst < 1e-12, "{kind:?}: off by {worst:.1e}, root carries {largest} N");
    }
}

/// P-143. Internal loads are continuous at the nodes, and between two positions they change by weight, loads and rate of momentum of the
/// piece between, computed by Simpson's rule from the accelerations of stations, without the engine's inertia terms.
///
/// Eight pieces between the ends of one pair of the outer body; the error of the rule is 1e-6 there. The remaining difference, between the
/// acceleration field of the elements and the cubic used for internal loads, falls with mesh refinement.
#[test]
fn p143_section_loads_balance_the_piece_between() {
    for sheared in [false, true] {
        section_loads_balance(sheared);
    }
}

fn section_loads_balance(sheared: bool) {
    let mut errors = Vec::new();
    for count in [2, 4, 8] {
        let near = 1e-9;
        let node_m = 0.075;
        let [from_m, to_m] = [0.031, 0.097];
        let mut cuts = vec![inboard(1, node_m - near), inboard(1, node_m + near), inboard(1, from_m), inboard(1, to_m)];
        cuts.push(place("node", 1, node_m, SectionSide::Outboard));
        let mut machine = moving_wing(ElementKind::Linear, count, cuts);
        let pieces = 32;
        if sheared {
            machine.bodies.iter_mut().for_each(|body| body.section = soft_in_shear().into());
        }
        machine.bodies[1].station_positions_m =
            (0..=pieces).map(|i| from_m + (to_m - from_m) * f64::from(i) / f64::from(pieces)).collect();
        machine.bodies[1].station_loads = vec![Wrench::default(); pieces as usize + 1];
        let mut plant = start(machine);
        *plant.inputs_mut().root_mut() = ROOT;
        coast(&mut plant, 0.05);
        let outputs = plant.outputs();
        let loads = outputs.internal_loads();
        let step = [0, 1]
            .map(|i| (loads[i].force_n - loads[4].force_n).norm() + (loads[i].moment_n_m - loads[4].moment_n_m).norm());
        assert!(step.iter().all(|step| *step < 1e-7), "a step of {step:?} at a node");

        let section = wing_section();
        let [yy, _, zz] = section.second_moment_kg_m;
        let inertia = Matrix3::from_diagonal(&Vector3::new(yy + zz, zz, yy));
        let points = &outputs.stations()[2..];
        let (first, last) = (&points[0], &points[pieces as usize]);
        let [near_n, far_n] = [(2, first), (3, last)].map(|(i, point)| Wrench {
            force_n: rotation(point) * loads[i].force_n,
            moment_n_m: rotation(point) * loads[i].moment_n_m,
        });
        let mut inert = Wrench::default();
        for (i, point) in points.iter().enumerate() {
            let weight = if i == 0 || i == pieces as usize {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
            let length_m = weight * (to_m - from_m) / (3.0 * f64::from(pieces));
            // mass damping of 0.7 1/s acts on velocities relative to the root frame
            let pull = ROOT.gravity_m_s2 - point.acceleration_m_s2 - point.velocity_m_s * 0.7;
            let turn = rotation(point);
            let inertia = turn * inertia * turn.transpose() * length_m;
            let spin = point.angular_velocity_rad_s + ROOT.angular_velocity_rad_s;
            let gyro = spin.cross(&(inertia * spin));
            inert.force_n += pull * (section.mass_kg_m * length_m);
            inert.moment_n_m += (point.position_m - first.position_m).cross(&(pull * (section.mass_kg_m * length_m)))
                - inertia * point.angular_acceleration_rad_s2
                - gyro
                - inertia * point.angular_velocity_rad_s * 0.7;
        }
        let arm = last.position_m - first.position_m;
        let force = (near_n.force_n - far_n.force_n - inert.force_n).norm() / inert.force_n.norm();
        let moment = near_n.moment_n_m - far_n.moment_n_m - arm.cross(&far_n.force_n) - inert.moment_n_m;
        let moment = moment.norm() / inert.moment_n_m.norm();
        println!(
            "P-143 shear {sheared}, {count} pairs: {force:.1e} of {:.2e} N, {moment:.1e} of {:.2e} N·m",
            inert.force_n.norm(),
            inert.moment_n_m.norm()
        );
        errors.push([force, moment]);
    }
    let [coarse, _, fine] = errors[..] else { panic!("three meshes") };
    for i in [0, 1] {
        assert!(fine[i] < 1e-3 && fine[i] < 0.25 * coarse[i], "{errors:?}");
    }
}

/// Inertial acceleration and angular acceleration of a point from the rates of its velocities relative to a rotating root.
fn inertial(point: &PointOutputs, rates: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let spin = ROOT.angular_velocity_rad_s;
    let carried = spin.cross(&(point.velocity_m_s * 2.0 + spin.cross(&point.position_m)));
    let euler = ROOT.angular_acceleration_rad_s2.cross(&point.position_m);
    [
        rates[0] + carried + euler + ROOT.acceleration_m_s2,
        rates[1] + ROOT.angular_acceleration_rad_s2 + spin.cross(&point.angular_velocity_rad_s),
    ]
}

/// P-144. Accelerations and angular accelerations of tip and stations are the rates of their velocities and angular velocities: central
/// differences over ±0.4, 0.2 and 0.1 ms converge with second order, on a moving root. At a tolerance of 1e-9 the values between the ends
/// of steps are smooth enough for that.
#[test]
fn p144_accelerations_are_rates_of_velocities() {
    let mut machine = moving_wing(ElementKind::Linear, 2, Vec::new());
    machine.solver.tolerance = 1e-9;
    // smooth enough for differences over 0.1 ms
    machine.bodies.iter_mut().for_each(|body| body.stiffness_damping_s = 5e-3);
    let time_s = 0.05;
    let points = |outputs: &Outputs| [outputs.stations(), outputs.tips()].concat();
    let mut errors = Vec::new();
    for side_s in [4e-4, 2e-4, 1e-4] {
        let mut plant = moved(machine.clone(), time_s - side_s);
        let before = points(plant.outputs());
        coast(&mut plant, time_s);
        let now = points(plant.outputs());
        coast(&mut plant, time_s + side_s);
        let after = points(plant.outputs());
        let (mut worst, mut largest) = ([0.0f64; 2], [0.0f64; 2]);
        for i in 0..now.len() {
            let linear = (after[i].velocity_m_s - before[i].velocity_m_s) / (2.0 * side_s);
            let turning = (after[i].angular_velocity_rad_s - before[i].angular_velocity_rad_s) / (2.0 * side_s);
            let expected = inertial(&now[i], [linear, turning]);
            let found = [now[i].acceleration_m_s2, now[i].angular_acceleration_rad_s2];
            for k in [0, 1] {
                worst[k] = worst[k].max((found[k] - expected[k]).norm());
                largest[k] = largest[k].max(found[k].norm());
            }
        }
        println!("P-144 ±{side_s:.0e} s: {:.1e}, {:.1e} of {largest:?}", worst[0] / largest[0], worst[1] / largest[1]);
        errors.push([worst[0] / largest[0], worst[1] / largest[1]]);
    }
    for k in [0, 1] {
        let order = (errors[0][k] / errors[2][k]).log2() / 2.0;
        assert!((1.8..2.2).contains(&order), "order {order:.2}, errors {errors:?}");
        assert!(errors[2][k] < 1e-4, "errors {errors:?}");
    }
}

/// P-145. A free beam with a child on a clamp falls: its stations accelerate with gravity, internal loads and reactions are zero, and there
/// is no angular acceleration.
#[test]
fn p145_a_falling_machine_carries_nothing() {
    let beam = body("keel", 0.4, &wing_section(), ElementKind::Linear, 2).load_stations(2);
    let fin = body("fin", 0.2, &wing_section(), ElementKind::Constant, 2).load_stations(1);
    let mut machine = machine([
        (beam, Joint::free("flight")),
        (fin, Joint::clamped("weld").on_at("keel", 0.3).mount_rotation_rad([0.3, -1.0, 0.4])),
    ]);
    machine.gravity_m_s2 = Vector3::new(1.0, -2.0, -9.8);
    machine.internal_loads =
        vec![inboard(0, 0.0), inboard(0, 0.23), inboard(0, 0.3), inboard(1, 0.0), inboard(1, 0.03)];
    let mut plant = start(machine);
    coast(&mut plant, 0.3);
    let outputs = plant.outputs();
    for point in outputs.stations().iter().chain(outputs.tips()) {
        let off = (point.acceleration_m_s2 - Vector3::new(1.0, -2.0, -9.8)).norm();
        let turning = point.angular_acceleration_rad_s2.norm();
        assert!(off < 1e-9 && turning < 1e-7, "off by {off:.1e} m/s², {turning:.1e} rad/s²");
        let reading_m_s2 = point.specific_force_m_s2.norm();
        assert!(reading_m_s2 < 1e-9, "specific force of {reading_m_s2:.1e} m/s² in free fall");
    }
    let carried = outputs.internal_loads().iter().chain(&outputs.joint_reactions()[1..]);
    let largest = carried.map(|wrench| wrench.force_n.norm() + wrench.moment_n_m.norm()).fold(0.0, f64::max);
    println!("P-145: carries {largest:.1e} N");
    assert!(largest < 1e-9, "carries {largest:.1e} N of a weight of {} N", plant.mass_kg() * 9.8);
}

/// P-146. Rigid pendulum with a point mass: the hinge force is `m (g cos θ + L ω²)` along the rod and `m (g sin θ + L θ̈)` across it, `θ̈ =
/// −(g/L) sin θ`, through two swings from 120°; no moment about the hinge. An accelerometer in the hinge, fixed to the rod, reads `g` upward in
/// the rod's axes, eq. (G8). Exact at every communication point for the angle and rate read
/// there; P-67 and RB-01 check the accuracy of the motion itself.
#[test]
fn p146_hinge_force_of_a_rigid_pendulum() {
    let (mass_kg, length_m, gravity_m_s2) = (0.7, 0.9, 9.8);
    let bob = Body::rigid("bob").inertia(mass_kg, [length_m, 0.0, 0.0], Matrix3::zeros());
    // `x` rotates towards `−z`: hanging down is 90° at the hinge
    let down_rad = std::f64::consts::FRAC_PI_2;
    let hinge = Revolute { start_rate_rad_s: 0.5, ..free_hinge(down_rad + 120f64.to_radians()) };
    let mut machine = machine([(bob, hinged_to_root(hinge))]);
    machine.gravity_m_s2 = Vector3::new(0.0, 0.0, -gravity_m_s2);
    machine.solver = solver(Method::Esdirk4, 1e-9);
    let mut plant = start(machine);
    let (mut worst, mut largest, mut misread) = (0.0f64, 0.0f64, 0.0f64);
    run(
        &mut plant,
        4.0,
        400,
        |_| {},
        |outputs| {
            let (angle, rate) = (outputs.joints()[0].angle_rad, outputs.joints()[0].rate_rad_s);
            let theta = angle - down_rad;
            let along = Vector3::new(angle.cos(), 0.0, -angle.sin());
            let across = Vector3::new(-angle.sin(), 0.0, -angle.cos());
            let pull_n = mass_kg * (gravity_m_s2 * theta.cos() + length_m * rate * rate);
            let second_1_s2 = -gravity_m_s2 / length_m * theta.sin();
            let shear_n = mass_kg * (gravity_m_s2 * theta.sin() + length_m * second_1_s2);
            let expected = -along * pull_n + across * shear_n;
            let joint = &outputs.joint_reactions()[0];
            worst = worst.max((joint.force_n - expected).norm()).max(joint.moment_n_m.norm());
            let upward_m_s2 = Vector3::new(-angle.sin(), 0.0, angle.cos()) * gravity_m_s2;
            misread = misread.max((outputs.stations()[0].specific_force_m_s2 - upward_m_s2).norm());
            largest = largest.max(joint.force_n.norm());
        },
    );
    println!("P-146: {worst:.1e} of {largest:.1} N, specific force {misread:.1e} m/s²");
    assert!(misread < 1e-12 * gravity_m_s2, "specific force off by {misread:.1e} m/s²");
    assert!(worst < 1e-6 * largest, "off by {worst:.1e} of {largest:.1} N");
}

/// One rigid link with its centre of mass away from the origin of its frame, and a full inertia tensor.
fn link(name: &str, mass_kg: f64) -> builder::BodyBuilder {
    let tensor = Matrix3::new(3.0, 0.2, -0.1, 0.2, 2.0, 0.3, -0.1, 0.3, 4.0) * (0.01 * mass_kg);
    Body::rigid(name).inertia(mass_kg, CENTRE_M, tensor)
}

const CENTRE_M: [f64; 3] = [0.1, 0.05, -0.04];

/// P-147. Newton–Euler equations for every body of a mechanism of rigid bodies, none of which has an element: forces and moments of its
/// joint and of its children's joints (revolute with drive and spring, universal, ball, clamped, locked, prescribed, in a closed loop) plus
/// gravity equal `m a` and `J α + ω × J ω` for its centre of mass, computed only from the accelerations of its load station, on a moving
/// root. Moments about hinges are the torque outputs of the joint.
///
/// Forces follow from the accelerations, to round-off; the loads that a joint transmits along its degrees of freedom follow from its
/// torques, to the error of the values between steps, at a tolerance of 1e-9.
#[test]
fn p147_newton_and_euler_for_every_rigid_body() {
    let drive = Motor { stiffness_n_m_rad: 0.4, damping_n_m_s_rad: 0.02, inertia_kg_m2: 0.003, ..Motor::default() };
    let hinge = |axis: [f64; 3], rate: f64| Revolute {
        start_rate_rad_s: rate,
        ..Revolute::about(Vector3::from(axis).normalize())
    };
    let elbow = Revolute {
        motor: drive,
        spring: Some(Spring { stiffness_n_m_rad: 0.5, damping_n_m_s_rad: 0.01, rest_angle_rad: 0.2 }),
        ..hinge([0.1, 1.0, 0.3], 2.0)
    };
    let crank = Revolute {
        motion: JointMotion::Prescribed(Motion::Polynomial(vec![0.0, 3.0, 2.0])),
        ..hinge([0.0, 1.0, 0.0], 0.0)
    };
    let arm = [0.2, 0.0, 0.0];
    let built = Machine::builder("mechanism")
        .gravity_m_s2([0.0, 0.0, -9.8])
        .body(link("crank", 0.4), Joint::hinge("crank_hinge", crank))
        .body(link("coupler", 0.5), Joint::hinge("elbow", elbow).on("crank").offset_m(arm))
        .body(link("weld", 0.2), Joint::clamped("weld_joint").on("coupler").offset_m([0.0, 0.1, 0.0]))
        .body(link("held", 0.1), Joint::hinge("lock", hinge([1.0, 0.0, 0.0], 0.0)).locked().on("weld").offset_m(arm))
        .body(link("rocker", 0.3), Joint::ball("rocker_ball").at_root([0.4, 0.0, 0.0]))
        .body(
            link("cross", 0.2),
            Joint::universal("cross_joint", [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).on("held").offset_m(arm),
        )
        .closure(Closure::between("pin", ["coupler", "rocker"], 200.0).offsets_m([arm, [0.0; 3]]).damping_n_s_m(1.0))
        .solver(solver(Method::Esdirk4, 1e-9))
        .stop_time_s(1.0)
        .step_s(1e-3)
        .build();
    let mut plant = start(built.unwrap_or_else(|refused| panic!("{refused}")));
    *plant.inputs_mut().root_mut() = RootMotion { gravity_m_s2: Vector3::new(0.0, 0.0, -9.8), ..ROOT };
    let machine = plant.machine().clone();
    let masses_kg = [0.4, 0.5, 0.2, 0.1, 0.3, 0.2];
    let (mut force_error, mut moment_error, mut along_error, mut largest) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    run(
        &mut plant,
        0.2,
        57,
        |_| {},
        |outputs| {
            let spin_of = |i: usize| outputs.stations()[i].angular_velocity_rad_s + ROOT.angular_velocity_rad_s;
            for (i, point) in outputs.stations().iter().enumerate() {
                let turn = rotation(point);
                let centre = point.position_m + turn * Vector3::from(CENTRE_M);
                let (alpha, omega) = (point.angular_acceleration_rad_s2, spin_of(i));
                let arm = turn * Vector3::from(CENTRE_M);
                let acceleration = point.acceleration_m_s2 + alpha.cross(&arm) + omega.cross(&omega.cross(&arm));
                let tensor = Matrix3::new(3.0, 0.2, -0.1, 0.2, 2.0, 0.3, -0.1, 0.3, 4.0) * (0.01 * masses_kg[i]);
                let tensor = turn * tensor * turn.transpose();
                let mut force = Vector3::new(0.0, 0.0, -9.8) * masses_kg[i];
                let mut moment = Vector3::zeros();
                let mut add = |at: Vector3<f64>, force_n: Vector3<f64>, moment_n_m: Vector3<f64>| {
                    force += force_n;
                    moment += moment_n_m + (at - centre).cross(&force_n);
                };
                let joint = outputs.joint_reactions()[i];
                add(point.position_m, joint.force_n, joint.moment_n_m);
                for (child, body) in machine.bodies.iter().enumerate() {
                    if matches!(body.joint.parent, Parent::Body { index, .. } if index == i) {
                        let joint = outputs.joint_reactions()[child];
                        add(outputs.stations()[child].position_m, -joint.force_n, -joint.moment_n_m);
                    }
                }
                let pin = outputs.loops()[0];
                match machine.bodies[i].name.as_str() {
                    "coupler" => {
                        add(point.position_m + turn * Vector3::new(0.2, 0.0, 0.0), pin.force_n, Vector3::zeros())
                    }
                    "rocker" => add(point.position_m, -pin.force_n, Vector3::zeros()),
                    _ => {}
                }
                force_error = force_error.max((force - acceleration * masses_kg[i]).norm());
                moment_error = moment_error.max((moment - tensor * alpha - omega.cross(&(tensor * omega))).norm());
                largest = largest.max(joint.force_n.norm());
            }
            // the hinge of the coupler: its axis is fixed to the crank
            let axis = rotation(&outputs.stations()[0]) * Vector3::new(0.1, 1.0, 0.3).normalize();
            let turning = axis.dot(&outputs.joint_reactions()[1].moment_n_m);
            let along = |i: usize| axis.dot(&(outputs.stations()[i].angular_acceleration_rad_s2));
            // second derivative of the angle: the rotation of the axis contributes the term with `ω × axis`
            let second = along(1) - along(0) - axis.dot(&spin_of(0).cross(&(spin_of(1) - spin_of(0))));
            let inert = 0.003 * second;
            along_error = along_error.max((turning - outputs.joints()[1].torque_applied_n_m + inert).abs());
            // the moment about the hinge at lock and crank holds them
            let axis = rotation(&outputs.stations()[2]) * Vector3::x();
            let held = axis.dot(&outputs.joint_reactions()[3].moment_n_m) - outputs.joints()[2].holding_torque_n_m;
            let driven = outputs.joint_reactions()[0].moment_n_m.y - outputs.joints()[0].holding_torque_n_m;
            along_error = along_error.max(held.abs()).max(driven.abs());
        },
    );
    println!(
        "P-147: {force_error:.1e} N, {moment_error:.1e} N·m, about hinges {along_error:.1e} N·m, joints carry {largest:.1} N"
    );
    assert!(force_error < 1e-12 * largest && largest > 5.0, "forces off by {force_error:.1e} N of {largest} N");
    assert!(moment_error < 1e-5, "moments off by {moment_error:.1e} N·m");
    assert!(along_error < 1e-12, "about hinges off by {along_error:.1e} N·m");
}

/// P-148. Internal loads and accelerations between the ends of steps converge to those at a tolerance of 1e-10 as the tolerance falls, and
/// at 1e-8 they have the accuracy that a slowly moving wing permits.
#[test]
fn p148_section_loads_converge_with_the_tolerance() {
    let at = |tolerance: f64| {
        let cuts = vec![inboard(0, 0.05), inboard(1, 0.0), inboard(1, 0.063)];
        let mut machine = moving_wing(ElementKind::Linear, 2, cuts);
        machine.bodies.iter_mut().for_each(|body| body.stiffness_damping_s = 5e-3);
        machine.solver.tolerance = tolerance;
        let mut plant = start(machine);
        *plant.inputs_mut().root_mut() = ROOT;
        let mut course = Vec::new();
        run(
            &mut plant,
            0.12,
            60,
            |_| {},
            |outputs| {
                let loads = outputs.internal_loads().iter().flat_map(|load| [load.force_n, load.moment_n_m * 10.0]);
                let points = outputs.stations().iter();
                let accelerations = points.map(|point| point.acceleration_m_s2 * 0.01);
                course.push(loads.chain(accelerations).collect::<Vec<_>>());
            },
        );
        course
    };
    let exact = at(1e-10);
    let errors = [1e-4, 1e-6, 1e-8].map(|tolerance| {
        let course = at(tolerance);
        let pairs = course.iter().flatten().zip(exact.iter().flatten());
        pairs.map(|(found, right)| (found - right).norm()).fold(0.0, f64::max)
    });
    println!("P-148: {errors:?}");
    assert!(errors[1] < 0.3 * errors[0] && errors[2] < 0.3 * errors[1] && errors[2] < 1e-3, "{errors:?}");
}

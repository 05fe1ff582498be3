//! V-10 to V-16: identities of mechanics at random states.

use crate::oracle::Oracle;
use crate::recursion::engine_residual;
use crate::trees::{Case, Named, Random, State, all_trees, two_bodies};
use foldwing::beam::element::ElementKind;
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::multibody::dynamics::Damping;
use foldwing::multibody::factor::{FreedomTangent, Weights, factorize, solve};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::{Motion, sweep_motion};
use foldwing::multibody::model::Attachment;
use foldwing::multibody::{Workspace, energy, station};
use nalgebra::{DVector, Vector3};

/// A state without loads, damping, root motion and accelerations.
fn quiet(case: &Case, seed: u64, link_angle_rad: f64) -> State {
    let mut state = State::random(case, seed, link_angle_rad);
    state.root = RootMotion::default();
    state.damping.fill(Damping::default());
    state.loads.fill(Wrench::default());
    state.a.fill(0.0);
    state
}

fn dot(a: &[f64], b: &DVector<f64>) -> f64 {
    a.iter().zip(b.iter()).map(|(a, b)| a * b).sum()
}

/// V-10. Kinetic energy from the recursion = `½ q̇ᵀ BᵀMB q̇` = `½ ėᵀMė` of the dense form; the values of bodies and attached masses add up
/// to it. Round-off of positive sums.
#[test]
fn v10_kinetic_energy_is_the_quadratic_form() {
    for Named { name, case, link_angle_rad } in all_trees(11) {
        let state = State::random(&case, 12, link_angle_rad);
        let mut work = Workspace::new(&case.model);
        sweep_motion(&case.model, &mut work, Motion { q: &state.q, v: &state.v, a: &state.a });
        let mut beams = 0.0;
        let engine = energy::kinetic(&case.model, &work, |_, energy| beams += energy);
        let oracle = Oracle::new(&case);
        let v = DVector::from_column_slice(&state.v);
        let form = 0.5 * v.dot(&(oracle.mass_matrix(&state.q) * &v));
        let direct = oracle.kinetic_energy_j(&state.q, &state.v);
        assert!((engine - form).abs() < 1e-13 * form, "{name}: {engine} J against quadratic form {form} J");
        assert!((engine - direct).abs() < 1e-13 * form, "{name}: {engine} J against ė form {direct} J");
        assert!(beams <= engine * (1.0 + 1e-14), "{name}: beams hold {beams} J of {engine} J");
        if case.clouds.is_empty() {
            assert!((beams - engine).abs() < 1e-14 * engine, "{name}: bodies add up to {beams} J of {engine} J");
        }
    }
}

/// V-11. Power of the station loads (force · velocity + moment · spin) = power on `q` (their contribution to the residual times `q̇`), dead
/// and follower, constant elements and pairs, in each frame. Round-off.
#[test]
fn v11_station_power_is_conserved() {
    for Named { name, case, link_angle_rad } in all_trees(13) {
        let loaded = State::random(&case, 14, link_angle_rad);
        let mut free = State::random(&case, 14, link_angle_rad);
        free.loads.fill(Wrench::default());
        let mut work = Workspace::new(&case.model);
        let without = engine_residual(&case, &mut work, &free);
        let on_q = dot(&loaded.v, &(without - engine_residual(&case, &mut work, &loaded)));
        let motion = Motion { q: &loaded.q, v: &loaded.v, a: &loaded.a };
        let (mut on_stations, mut size) = (0.0, 0.0);
        for (point, load) in case.model.stations.iter().zip(&loaded.loads) {
            let at = station::motion(&case.model, &work, motion, point);
            let (force, moment) = match point.frame {
                LoadFrame::Root => (load.force_n, load.moment_n_m),
                LoadFrame::Section => (at.rotation * load.force_n, at.rotation * load.moment_n_m),
            };
            on_stations += force.dot(&at.velocity_m_s) + moment.dot(&at.spin_rad_s);
            size += force.norm() * at.velocity_m_s.norm() + moment.norm() * at.spin_rad_s.norm();
        }
        // the residual's other terms, EA ε among them, determine the round-off of the difference
        let work_size: f64 =
            loaded.v.iter().zip(engine_residual(&case, &mut work, &free).iter()).map(|(v, r)| (v * r).abs()).sum();
        let bound = 1e-13 * (size + work_size);
        assert!((on_q - on_stations).abs() < bound, "{name}: {on_q} W on q, {on_stations} W on stations");
    }
}

/// V-12. At zero rates the residual is the gradient of the strain energy and of gravity's potential `−g · ∫ r dm`.
///
/// Gradient by a five-point difference of step 1e-3 in units where strains change by 1e-3: truncation 1e-12,
/// cancellation 1e-12; 1e-9 leaves room for third derivatives of the geometry.
#[test]
fn v12_potentials_have_the_residual_as_gradient() {
    for Named { name, case, link_angle_rad } in all_trees(15).into_iter().filter(|tree| !tree.name.contains("1e12")) {
        let mut state = quiet(&case, 16, link_angle_rad);
        state.v.fill(0.0);
        state.root.gravity_m_s2 = Vector3::new(3.0, -5.0, 7.0);
        state.root.acceleration_m_s2 = Vector3::new(-1.0, 0.5, 2.0);
        let field = state.root.gravity_m_s2 - state.root.acceleration_m_s2;
        let model = &case.model;
        let mut work = Workspace::new(model);
        let gradient = engine_residual(&case, &mut work, &state);
        let mut potential = |q: &[f64]| {
            sweep_motion(model, &mut work, Motion { q, v: &state.v, a: &state.a });
            energy::elastic(model, q) - field.dot(&energy::first_moment_kg_m(model, &work))
        };
        let scale = gradient.amax();
        for i in 0..model.coordinates {
            let mut at = |shift: f64| {
                let mut q = state.q.clone();
                q[i] += shift;
                potential(&q)
            };
            let h = 1e-3;
            let slope = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            let error = (slope - gradient[i]).abs() / scale;
            assert!(error < 1e-9, "{name}, coordinate {i}: slope {slope} against residual {}", gradient[i]);
        }
    }
}

/// V-13. The mass of the tree is that of sections and attachments: `Σ ρA ℓ + Σ m`, round-off.
#[test]
fn v13_mass_adds_up() {
    for Named { name, case, .. } in all_trees(17) {
        let beams: f64 = case.descriptions.iter().map(|body| body.section.mass_kg(body.length_m)).sum();
        let attached: f64 = case.clouds.iter().flat_map(|(_, _, cloud)| cloud.iter().map(|(mass, _)| mass)).sum();
        let engine = energy::mass_kg(&case.model);
        assert!((engine - beams - attached).abs() < 1e-13 * engine, "{name}: {engine} kg");
    }
}

/// V-14. Rotating mounts, root positions, gravity, root motion and dead loads together does not change the residual in `q` and rotates root
/// force and moment; follower loads need no rotation. Round-off of the residual's terms.
#[test]
fn v14_frame_invariance() {
    for Named { name, case, link_angle_rad } in all_trees(18) {
        let mut random = Random::new(19);
        let turn = random.rotation();
        let mut bodies = case.descriptions.clone();
        for body in &mut bodies {
            body.masses.clear();
            if let Attachment::Root(position) = body.parent {
                body.parent = Attachment::Root(turn * position);
                body.mount = turn * body.mount;
                if let JointKind::Revolute { axis } | JointKind::Prismatic { axis } = &mut body.joint {
                    *axis = turn * *axis;
                }
            }
        }
        let turned_case = Case::new(bodies, case.clouds.clone());
        let state = State::random(&case, 20, link_angle_rad);
        let mut turned = State::random(&case, 20, link_angle_rad);
        let root = &mut turned.root;
        for vector in [
            &mut root.gravity_m_s2,
            &mut root.acceleration_m_s2,
            &mut root.angular_velocity_rad_s,
            &mut root.angular_acceleration_rad_s2,
        ] {
            *vector = turn * *vector;
        }
        for (load, point) in turned.loads.iter_mut().zip(&case.model.stations) {
            if point.frame == LoadFrame::Root {
                load.force_n = turn * load.force_n;
                load.moment_n_m = turn * load.moment_n_m;
            }
        }
        let (mut work, mut turned_work) = (Workspace::new(&case.model), Workspace::new(&case.model));
        let here = engine_residual(&case, &mut work, &state);
        let there = engine_residual(&turned_case, &mut turned_work, &turned);
        let scale =
            Oracle::new(&case).residual((&state.q, &state.v, &state.a), &state.root, &state.damping, &state.loads);
        for i in 0..here.len() {
            let error = (here[i] - there[i]).abs() / scale.magnitude[i];
            assert!(error < 1e-13, "{name}, coordinate {i}: residual changes by {error:.1e} of its terms");
        }
        let force = (turn * work.root_force - turned_work.root_force).norm() / scale.root_magnitude[0];
        let moment = (turn * work.root_moment - turned_work.root_moment).norm() / scale.root_magnitude[1];
        assert!(force < 1e-13 && moment < 1e-13, "{name}: root wrench off by {force:.1e}, {moment:.1e} of its terms");
        let tip = case.model.nodes.len() - 1;
        let gap_m = (turn * work.nodes[tip].position - turned_work.nodes[tip].position).norm();
        assert!(gap_m < 1e-13, "{name}: tip off by {gap_m:.1e} m");
    }
}

/// V-15. A uniform acceleration of the root is equivalent to the opposite gravity, bit-identical: only their difference enters.
#[test]
fn v15_root_acceleration_is_gravity_reversed() {
    let case = two_bodies(21, [ElementKind::Linear, ElementKind::Constant], 3);
    let mut state = State::random(&case, 22, 0.5);
    let field = state.root.gravity_m_s2;
    state.root.acceleration_m_s2 = Vector3::zeros();
    let mut work = Workspace::new(&case.model);
    let by_gravity = engine_residual(&case, &mut work, &state);
    state.root.gravity_m_s2 = Vector3::zeros();
    state.root.acceleration_m_s2 = -field;
    assert_eq!(by_gravity, engine_residual(&case, &mut work, &state));
}

/// V-16. Power balance along a motion that satisfies the equations: `d(T + V)/dt` = loads + uniform field + rotating frame − damping, with
/// accelerations from the articulated-body solution.
///
/// `d/dt` by a five-point difference along `q + vt + ½at²`, step 1e-3 of a time unit in which strains change by their own magnitude:
/// truncation 1e-11 of the terms, cancellation 1e-13; asserted 1e-8.
#[test]
fn v16_power_balance_along_a_motion() {
    let mut worst = 0.0f64;
    for Named { name, case, link_angle_rad } in all_trees(23).into_iter().filter(|tree| !tree.name.contains("EA")) {
        let model = &case.model;
        let mut state = State::random(&case, 24, link_angle_rad);
        state.a.fill(0.0);
        let mut work = Workspace::new(model);
        let mut a: Vec<f64> = (-engine_residual(&case, &mut work, &state)).as_slice().to_vec();
        let mass = Weights { mass: 1.0, damping: 0.0, stiffness: 0.0 };
        let free = FreedomTangent { free: true, stiffness: 0.0, damping: 0.0 };
        factorize(model, &mut work, mass, &state.damping, &vec![free; model.bodies.len()]).expect("positive definite");
        solve(model, &mut work, &mut a);
        state.a = a;

        let rest = engine_residual(&case, &mut work, &state);
        let motion = Motion { q: &state.q, v: &state.v, a: &state.a };
        let mut power = energy::frame_power(model, &work, &state.root);
        let mut size = power.abs();
        let mut damped = energy::stiffness_damping_power(model, &state.v, &state.damping);
        energy::kinetic(model, &work, |body, beam| damped += 2.0 * state.damping[body].mass_1_s * beam);
        power -= damped;
        size += damped;
        for (point, load) in model.stations.iter().zip(&state.loads) {
            let at = station::motion(model, &work, motion, point);
            let axes = if point.frame == LoadFrame::Root { nalgebra::Matrix3::identity() } else { at.rotation };
            let part = (axes * load.force_n).dot(&at.velocity_m_s) + (axes * load.moment_n_m).dot(&at.spin_rad_s);
            power += part;
            size += part.abs();
        }
        let field = state.root.gravity_m_s2 - state.root.acceleration_m_s2;
        let (mut v, mut q) = (vec![0.0; model.coordinates], vec![0.0; model.coordinates]);
        // time in which the fastest rate changes by its own magnitude
        let fastest = state.a.iter().fold(1.0f64, |m, a| m.max(a.abs()));
        let h = 2e-3 / fastest.sqrt().max(1.0);
        let mut energy_at = |t: f64| {
            for i in 0..q.len() {
                v[i] = state.v[i] + t * state.a[i];
                q[i] = state.q[i] + t * (state.v[i] + 0.5 * t * state.a[i]);
            }
            sweep_motion(model, &mut work, Motion { q: &q, v: &v, a: &state.a });
            energy::kinetic(model, &work, |_, _| {}) + energy::elastic(model, &q)
                - field.dot(&energy::first_moment_kg_m(model, &work))
        };
        let (total, slope) = (
            energy_at(0.0).abs(),
            (8.0 * (energy_at(h) - energy_at(-h)) - (energy_at(2.0 * h) - energy_at(-2.0 * h))) / (12.0 * h),
        );
        // the residual of the equations also does work: round-off of a large acceleration
        let left: f64 = state.v.iter().zip(rest.iter()).map(|(v, r)| (v * r).abs()).sum();
        let error = (slope - power).abs() / (size + slope.abs());
        println!(
            "{name}: {slope:.6} W against {power:.6} W, error {error:.1e}, left {left:.1e} W, energy {total:.1e} J, h {h:.1e} s"
        );
        worst = worst.max(error);
        assert!(error < 1e-8, "{name}: energy changes by {slope} W, powers add up to {power} W");
    }
    println!("worst {worst:.1e}");
}

/// V-17. One motion in two descriptions: a wing clamped to a rotating root, and the same wing on a hinge at the origin of a fixed root,
/// rotated by its coordinate. Strain residuals, and the moment about the axis, agree to round-off.
///
/// Gravity and dead loads are resolved in the root frame, so both are compared at hinge angle zero; no mass damping, which acts on velocity
/// relative to the root.
#[test]
fn v17_turning_root_equals_turning_hinge() {
    for kinds in [[ElementKind::Constant, ElementKind::Linear], [ElementKind::Linear, ElementKind::Constant]] {
        let mut clamped = two_bodies(26, kinds, 3);
        clamped.descriptions[0].parent = Attachment::Root(Vector3::zeros());
        let mut hinged = clamped.descriptions.clone();
        let axis = Random::new(27).direction();
        hinged[0].joint = JointKind::Revolute { axis };
        let (clamped, hinged) = (Case::new(clamped.descriptions.clone(), Vec::new()), Case::new(hinged, Vec::new()));
        let (rate, pull) = (1.7, -2.3);

        let mut turning = State::random(&clamped, 28, 0.5);
        turning.root.acceleration_m_s2 = Vector3::zeros();
        turning.root.angular_velocity_rad_s = axis * rate;
        turning.root.angular_acceleration_rad_s2 = axis * pull;
        turning.damping.iter_mut().for_each(|damping| damping.mass_1_s = 0.0);
        let mut still = State::random(&hinged, 28, 0.5);
        still.root = RootMotion { gravity_m_s2: turning.root.gravity_m_s2, ..RootMotion::default() };
        still.damping.clone_from(&turning.damping);
        still.loads.clone_from(&turning.loads);
        for (target, source, first) in
            [(&mut still.q, &turning.q, 0.0), (&mut still.v, &turning.v, rate), (&mut still.a, &turning.a, pull)]
        {
            target[0] = first;
            target[1..].copy_from_slice(source);
        }

        let (mut turning_work, mut still_work) = (Workspace::new(&clamped.model), Workspace::new(&hinged.model));
        let one = engine_residual(&clamped, &mut turning_work, &turning);
        let other = engine_residual(&hinged, &mut still_work, &still);
        let scale =
            Oracle::new(&hinged).residual((&still.q, &still.v, &still.a), &still.root, &still.damping, &still.loads);
        for i in 0..one.len() {
            let error = (one[i] - other[i + 1]).abs() / scale.magnitude[i + 1];
            assert!(error < 1e-13, "{kinds:?}, coordinate {i}: off by {error:.1e} of its terms");
        }
        let error = (axis.dot(&turning_work.root_moment) - other[0]).abs() / scale.magnitude[0];
        assert!(error < 1e-13, "{kinds:?}: moment on the axis off by {error:.1e} of its terms");
    }
}

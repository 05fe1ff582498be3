//! V-30 to V-36: strain recovery from the section wrench.

use crate::modes::mode_shape;
use crate::oracle::Oracle;
use crate::rod::Rod;
use crate::statics::{Loading, assert_order, cantilever, equilibrium, plain_section};
use crate::trees::{Case, Cloud, Random, State, branching_tree, random_body};
use foldwing::beam::element::ElementKind::{self, Constant, Linear};
use foldwing::load::{LoadFrame, RootMotion, Wrench};
use foldwing::multibody::dynamics::{Damping, Environment, residual};
use foldwing::multibody::gauge::{GaugePoint, section_strain, section_wrench};
use foldwing::multibody::kinematics::Motion;
use foldwing::multibody::model::Attachment;
use foldwing::multibody::{Model, Workspace};
use nalgebra::{Matrix4, Vector3, Vector4};

fn recovered(model: &Model, work: &Workspace, q: &[f64], position_m: f64) -> Vector4<f64> {
    let zero = vec![0.0; q.len()];
    let damping = vec![Damping::default(); model.bodies.len()];
    section_strain(model, work, Motion { q, v: &zero, a: &zero }, &damping, 0, position_m)
}

/// Axial stiffness soft enough that `εx` reaches a few per cent.
const SOFT: [f64; 4] = [40.0, 1.2, 1.0, 2.5];

/// Strain error at places along a rod, each mesh in turn; `spread` loads sit on two Gauss stations per element.
fn rod_errors(kind: ElementKind, mesh: &[usize], rod: &Rod, places: &[usize], count: usize) -> Vec<Vec<f64>> {
    let (exact, ..) = rod.solve(count);
    let largest = exact.iter().map(|section| section.strain.amax()).fold(0.0, f64::max);
    let mut errors = vec![Vec::new(); places.len()];
    for &elements in mesh {
        let section = foldwing::beam::section::Section { stiffness: rod.stiffness, ..plain_section(SOFT) };
        let mut body = cantilever(1.0, section, kind, elements, LoadFrame::Section);
        body.natural_strain = rod.natural_strain.into();
        let mut loads = vec![Wrench { force_n: rod.tip[0], moment_n_m: rod.tip[1] }];
        let h = 1.0 / elements as f64;
        for i in 0..elements {
            for point in [0.211_324_865_405_187_1, 0.788_675_134_594_812_9] {
                let s = h * (i as f64 + point);
                body.stations_m.push(s);
                let [force, moment] = (rod.spread)(s);
                loads.push(Wrench { force_n: force * (0.5 * h), moment_n_m: moment * (0.5 * h) });
            }
        }
        let model = Model::new(&[body]);
        let mut work = Workspace::new(&model);
        let q = equilibrium(&model, &mut work, &model.natural_coordinates(), &Loading::stations(loads), 5);
        for (errors, &place) in errors.iter_mut().zip(places) {
            let strain = recovered(&model, &work, &q, place as f64 / count as f64);
            errors.push((strain - exact[place].strain).amax() / largest);
        }
    }
    errors
}

fn tip_loaded() -> Rod {
    Rod {
        length_m: 1.0,
        stiffness: Matrix4::from_diagonal(&Vector4::from(SOFT)),
        natural_strain: Vector4::new(0.0, 0.4, -0.3, 0.2),
        tip: [Vector3::new(2.0, -0.7, 1.6), Vector3::new(0.4, 0.3, -0.5)],
        spread: |_| [Vector3::zeros(); 2],
    }
}

/// V-30. Strain under follower force and moment at the tip, against the independent rod solver: all four components
/// (torsion, bendings and axial) are fourth order at the root, at a pair boundary, inside pairs and at the loaded
/// tip, where the raw linear field is second order.
#[test]
fn v30_recovered_strain_is_fourth_order() {
    let places = [0, 8, 12, 16, 27, 31, 32];
    let errors = rod_errors(Linear, &[4, 8, 16], &tip_loaded(), &places, 32);
    for (errors, place) in errors.iter().zip(places) {
        if errors[2] < 1e-10 {
            println!("V-30 at {place}/32 L: exact, {:.1e}", errors[2]);
            continue;
        }
        assert_order(&format!("V-30 at {place}/32 L"), errors, 3.5, 5.2);
        assert!(errors[2] < 1e-5, "at {place}/32 L: strain off by {:.1e} of the largest", errors[2]);
    }
}

/// V-31. The same with distributed follower forces and moments on Gauss stations. The section wrench at pair ends holds
/// their sum, so order 4 stays at pair ends; inside, the cubic joins it to the Gauss values.
#[test]
fn v31_recovered_strain_under_distributed_loads() {
    let mut rod = tip_loaded();
    rod.spread = |s| [Vector3::new(1.0, 0.8 - 0.5 * s, 1.5 + s * s), Vector3::new(0.4 * s, -0.2, 0.1)];
    rod.tip = [Vector3::zeros(); 2];
    let places = [0, 8, 12, 27];
    for (errors, place) in rod_errors(Linear, &[4, 8, 16], &rod, &places, 32).iter().zip(places) {
        assert_order(&format!("V-31 at {place}/32 L"), errors, 3.4, 5.2);
        assert!(errors[2] < 2e-5, "at {place}/32 L: strain off by {:.1e} of the largest", errors[2]);
    }
}

/// V-32. Constant elements interpolate between their centres: second order inside and at the root.
#[test]
fn v32_constant_elements_are_second_order() {
    let places = [0, 12, 20];
    for (errors, place) in rod_errors(Constant, &[8, 16, 32], &tip_loaded(), &places, 32).iter().zip(places) {
        assert_order(&format!("V-32 at {place}/32 L"), errors, 1.7, 2.4);
    }
}

/// V-33. Gauge point: `εx + z κy − y κz` of the section's strain, as design section 1 states it.
#[test]
fn v33_gauge_reads_the_point_of_the_section() {
    let body = cantilever(1.0, plain_section(SOFT), Linear, 3, LoadFrame::Root);
    let model = Model::new(&[body]);
    let mut work = Workspace::new(&model);
    let load = Wrench { force_n: Vector3::new(1.0, 0.5, 0.7), moment_n_m: Vector3::zeros() };
    let q = equilibrium(&model, &mut work, &model.natural_coordinates(), &Loading::stations(vec![load]), 2);
    let zero = vec![0.0; q.len()];
    let motion = Motion { q: &q, v: &zero, a: &zero };
    let gauge = GaugePoint { body: 0, position_m: 0.3, y_m: 0.04, z_m: -0.01 };
    let s = recovered(&model, &work, &q, 0.3);
    let expected = s[0] - 0.01 * s[2] - 0.04 * s[3];
    assert_eq!(gauge.strain(&model, &work, motion, &[Damping::default()]), expected);
    // tension pulls, force along +z bends the face z > 0 into compression at the root: κy < 0
    assert!(s[0] > 0.0 && s[2] < 0.0 && s[3] > 0.0, "signs of {s:?}");
}

/// V-34. Section wrench at every pair end and on both sides of an attached rigid body, a child body and a load =
/// root wrench of the outboard part alone, cut off and held where it is (static, gravity and station loads).
/// Round-off of the terms.
#[test]
fn v34_section_wrench_is_that_of_the_outboard_part() {
    for kind in [Constant, Linear] {
        let mut random = Random::new(41);
        let mut parent = random_body(&mut random, 1.0, kind, 4);
        parent.stations_m = vec![0.3, 0.5, 0.6, 1.0];
        parent.load_frame = LoadFrame::Section;
        let mut child = random_body(&mut random, 0.4, kind, 1);
        child.parent = Attachment::Body { index: 0, position_m: 0.5 };
        child.mount = random.rotation();
        let cloud: Cloud = (0..4).map(|_| (0.3, random.vector() * 0.2)).collect();
        let case = Case::new(vec![parent.clone(), child.clone()], vec![(0, 0.75, cloud.clone()), (0, 0.25, cloud.clone())]);
        let mut state = State::random(&case, 42, 0.3);
        state.v.fill(0.0);
        state.a.fill(0.0);
        state.root = RootMotion { gravity_m_s2: Vector3::new(2.0, -3.0, 9.0), ..RootMotion::default() };
        let mut work = Workspace::new(&case.model);
        crate::recursion::engine_residual(&case, &mut work, &state);
        let stride = if kind == Linear { 2 } else { 1 };
        for cut in 0..4 {
            let cut_m = 0.25 * f64::from(cut);
            let node = cut as usize * stride;
            let mut outboard = parent.clone();
            outboard.length_m = 1.0 - cut_m;
            outboard.elements = 4 - cut as usize;
            outboard.mount = work.nodes[node].rotation;
            outboard.parent = Attachment::Root(work.nodes[node].position);
            for inboard_side in [true, false] {
                // what sits on the cut belongs to the outboard part only on its inboard side
                let keeps = |s: f64| if inboard_side { s > cut_m - 1e-9 } else { s > cut_m + 1e-9 };
                if inboard_side && cut == 0 {
                    continue;
                }
                let mut bodies = vec![outboard.clone()];
                bodies[0].stations_m = parent.stations_m.iter().filter(|s| keeps(**s)).map(|s| s - cut_m).collect();
                if keeps(0.5) {
                    let mut child = child.clone();
                    child.parent = Attachment::Body { index: 0, position_m: 0.5 - cut_m };
                    bodies.push(child);
                }
                let clouds = [0.75, 0.25].iter().filter(|s| keeps(**s)).map(|s| (0, s - cut_m, cloud.clone())).collect();
                let part = Case::new(bodies, clouds);
                let mut q = state.q[4 * node..16 * stride / stride * stride].to_vec();
                q.truncate(4 * stride * (4 - cut as usize));
                if keeps(0.5) {
                    q.extend_from_slice(&state.q[16 * stride..]);
                }
                let loads: Vec<Wrench> = parent
                    .stations_m
                    .iter()
                    .zip(&state.loads)
                    .filter(|(s, _)| keeps(**s))
                    .map(|(_, load)| *load)
                    .collect();
                let zero = vec![0.0; q.len()];
                let exact = Oracle::new(&part).residual((&q, &zero, &zero), &state.root, &[Damping::default(); 2][..part.model.bodies.len()], &loads);
                let expected_moment = exact.root_moment - work.nodes[node].position.cross(&exact.root_force);
                let (force, moment) = section_wrench(&case.model, &work, 0, node, !inboard_side);
                let what = format!("{kind:?}, cut at {cut_m} L, inboard side {inboard_side}");
                let gap = (force - exact.root_force).norm() / exact.root_magnitude[0];
                assert!(gap < 1e-14, "{what}: force off by {gap:.1e} of its terms");
                let gap = (moment - expected_moment).norm() / exact.root_magnitude[1];
                assert!(gap < 1e-14, "{what}: moment off by {gap:.1e} of its terms");
            }
        }
    }
}

/// V-35. In free vibration the curvature of a clamped-free beam follows from its tip's amplitude: `κ = w'' ` of the
/// mode (closed form). Root and an interior point, modes 1 and 2, order 4: the wrench carries the inertia.
#[test]
fn v35_dynamic_recovery_in_free_vibration() {
    for (mode, finest) in [(0, 1e-6), (1, 5e-5)] {
        for place in [0.0, 0.37, 0.75] {
            let errors: Vec<f64> = [4, 8, 16]
                .iter()
                .map(|&elements| {
                    let mut section = plain_section([1e6, 1e3, 1.0, 1e3]);
                    section.second_moment_kg_m = [0.0; 3];
                    let mut body = cantilever(1.0, section, Linear, elements, LoadFrame::Root);
                    body.stations_m.clear();
                    let case = Case::new(vec![body], Vec::new());
                    let model = &case.model;
                    let (frequency, shape) = crate::modes::modes(&case, &[])[mode].clone();
                    // 1e-5 L at the tip: second-order terms of 1e-10
                    let mut work = Workspace::new(model);
                    let tip = model.nodes.len() - 1;
                    let at_rest = vec![0.0; model.coordinates];
                    let trial: Vec<f64> = shape.iter().map(|x| x * 1e-6 / shape.amax()).collect();
                    let environment =
                        Environment { root: &RootMotion::default(), damping: &[Damping::default()], stations: &[] };
                    let pull: Vec<f64> = trial.iter().map(|x| -x * frequency * frequency).collect();
                    let mut rest = vec![0.0; model.coordinates];
                    let motion = Motion { q: &trial, v: &at_rest, a: &pull };
                    residual(model, &mut work, motion, environment, &mut rest);
                    let strain = recovered(model, &work, &trial, place);
                    let expected = -mode_shape(mode, place) * work.nodes[tip].position.z;
                    (strain[2] - expected).abs() / mode_shape(mode, 0.0).abs() / work.nodes[tip].position.z.abs()
                })
                .collect();
            assert_order(&format!("V-35 mode {}, at {place} L", mode + 1), &errors, 3.3, 5.5);
            assert!(errors[2] < finest, "mode {}, at {place} L: curvature off by {:.1e}", mode + 1, errors[2]);
        }
    }
}

/// V-36. Damping: with `β` the recovered strain takes off `β ε̇`, so that a state moved at `ε̇` under the wrench of
/// its full stress reads the same elastic strain. Identity at the root: `K (ε − ε₀ + β ε̇) = −W`, round-off.
#[test]
fn v36_recovery_takes_off_the_viscous_part() {
    let case = branching_tree(43, [Linear; 4]);
    let state = State::random(&case, 44, 0.3);
    let mut work = Workspace::new(&case.model);
    crate::recursion::engine_residual(&case, &mut work, &state);
    let motion = Motion { q: &state.q, v: &state.v, a: &state.a };
    let strain = section_strain(&case.model, &work, motion, &state.damping, 0, 0.0);
    let element = &case.model.elements[0];
    // the pair's field at its inner end, (5A − B)/4
    let rate = Vector4::from_fn(|i, _| 1.25 * state.v[i] - 0.25 * state.v[4 + i]);
    let stress = element.section_stiffness * (strain - element.natural_strain + rate * state.damping[0].stiffness_s);
    let axes = work.nodes[0].rotation.transpose();
    let (force, moment) = (axes * work.nodes[0].force, axes * work.nodes[0].moment);
    let gap = (stress + Vector4::new(force.x, moment.x, moment.y, moment.z)).amax() / stress.amax();
    assert!(gap < 1e-13, "stress and wrench differ by {gap:.1e}");
}

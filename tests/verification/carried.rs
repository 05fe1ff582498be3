//! V-37 and V-38: mass-proportional damping of a tree on a free joint acts relative to the joint's first node.

use crate::oracle::Oracle;
use crate::recursion::engine_residual;
use crate::trees::{Case, Random, State, branching_tree, two_bodies, with_shear};
use foldwing::beam::element::ElementKind::{Constant, Linear};
use foldwing::load::{RootMotion, Wrench};
use foldwing::multibody::joint::JointKind;
use foldwing::multibody::kinematics::{Motion, sweep_motion};
use foldwing::multibody::model::Attachment;
use foldwing::multibody::{Workspace, energy};
use nalgebra::{DVector, UnitQuaternion, Vector3};

/// A tree clamped to the root, the same tree on a free joint, and the offset of its coordinates in the second model.
fn pair(case: Case) -> (Case, Case, usize) {
    let mut free = case.descriptions.clone();
    free.iter_mut().for_each(|body| body.masses.clear());
    free[0].joint = JointKind::Free;
    free[0].parent = Attachment::Root(Vector3::zeros());
    (Case::new(free, case.clouds.clone()), case, 7)
}

/// State of the free tree with some attitude and motion; its strains and angles have the values and rates of the clamped tree.
fn flying(free: &Case, clamped: &Case, state: &State) -> State {
    let mut random = Random::new(91);
    let mut flying = State::random(free, 92, 0.3);
    let attitude = UnitQuaternion::from_matrix(&clamped.descriptions[0].mount);
    let place = match clamped.descriptions[0].parent {
        Attachment::Root(place) => place,
        Attachment::Body { .. } | Attachment::Axis { .. } => Vector3::zeros(),
    };
    flying.q[..3].copy_from_slice(place.as_slice());
    flying.q[3..7].copy_from_slice(&[attitude.w, attitude.i, attitude.j, attitude.k]);
    let joint = free.model.bodies[0].joint;
    let rates = joint.kind.parameter_rates(&flying.q[..7], &(random.vector() * 3.0));
    flying.v[..7].copy_from_slice(&rates[..7]);
    flying.v[..3].copy_from_slice((random.vector() * 20.0).as_slice());
    flying.q[7..].copy_from_slice(&state.q);
    flying.v[7..].copy_from_slice(&state.v);
    flying.damping.clone_from(&state.damping);
    flying
}

/// V-37. Contribution of damping to the residual of a flying, spinning tree: on strains and angles it is the dense form's `α BᵀM_beam B q̇`
/// of the same tree clamped, whatever the flight; on the six degrees of freedom of the free joint it is zero. Round-off of the residual's
/// terms. (It used to decelerate the flight.)
#[test]
fn v37_damping_of_a_flying_tree_is_that_of_the_clamped_one() {
    let trees = [
        two_bodies(81, [Linear, Constant], 3),
        two_bodies(82, [Constant, Linear], 4),
        branching_tree(83, [Linear, Constant, Linear, Linear]),
        with_shear(87, &branching_tree(83, [Linear, Constant, Linear, Linear]), 2),
        with_shear(88, &two_bodies(82, [Constant, Linear], 4), 1),
    ];
    for tree in trees {
        // the second tree of the branching machine is attached to the root: in both, its damping is relative to the root
        let (free, clamped, shift) = pair(tree);
        let mut still = State::random(&clamped, 84, 0.4);
        still.damping.iter_mut().for_each(|damping| damping.stiffness_s = 0.0);
        let mut moving = flying(&free, &clamped, &still);
        let mut work = Workspace::new(&free.model);
        let damped = engine_residual(&free, &mut work, &moving);
        let power = {
            let mut power = 0.0;
            energy::mass_damping_power(&free.model, &work, &moving.damping, |beam| power += beam);
            power
        };
        moving.damping.iter_mut().for_each(|damping| damping.mass_1_s = 0.0);
        let added = &damped - engine_residual(&free, &mut work, &moving);

        // dense: residual of the clamped tree at zero acceleration, with damping minus without
        let (quiet, loads) = (RootMotion::default(), vec![Wrench::default(); clamped.model.stations.len()]);
        let oracle = Oracle::new(&clamped);
        let none = vec![Default::default(); still.damping.len()];
        let motion = (&still.q[..], &still.v[..], &vec![0.0; still.q.len()][..]);
        let with = oracle.residual(motion, &quiet, &still.damping, &loads);
        let right = with.value - oracle.residual(motion, &quiet, &none, &loads).value;
        let scale = damped.amax().max(right.amax());
        for i in 0..6 {
            assert!(added[i].abs() < 1e-11 * scale, "freedom {i} of the flight is braked by {} of {scale}", added[i]);
        }
        for i in 0..right.len() {
            let error = (added[i + shift] - right[i]).abs() / scale;
            assert!(error < 1e-11, "coordinate {i}: {} against {}", added[i + shift], right[i]);
        }
        let v = DVector::from_column_slice(&still.v);
        assert!(
            (power - v.dot(&right)).abs() < 1e-12 * power,
            "{power} W taken, {} W by the dense form",
            v.dot(&right)
        );
    }
}

/// V-38. The damping power of a tree attached to the root is unchanged: `2 α T` of each beam, to the last bit.
#[test]
fn v38_damping_power_on_the_root_is_twice_the_kinetic_energy() {
    let case = branching_tree(85, [Constant, Linear, Linear, Constant]);
    let state = State::random(&case, 86, 0.4);
    let mut work = Workspace::new(&case.model);
    sweep_motion(&case.model, &mut work, Motion { q: &state.q, v: &state.v, a: &state.a });
    let (mut power, mut right) = (0.0, 0.0);
    energy::mass_damping_power(&case.model, &work, &state.damping, |beam| power += beam);
    energy::kinetic(&case.model, &work, |body, beam| right += 2.0 * state.damping[body].mass_1_s * beam);
    assert_eq!(power, right);
}

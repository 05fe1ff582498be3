//! C-01, C-02: consistency of the dense model.

use crate::conventional::assembly::{Assembly, Body};
use crate::conventional::link::{Axis, Joint};
use crate::conventional::pendulum::{Between, body, gravity, index_1_dae, joint_parameters};
use nalgebra::{DVector, Matrix3};

/// A pseudo-random number in (−1, 1).
fn scatter(i: usize) -> f64 {
    (12.9898 * i as f64 + 0.7).sin() * 0.9
}

/// Chains with every kind of joint variable, bent and moving.
fn chains() -> Vec<(&'static str, Assembly)> {
    let identity = Matrix3::identity();
    let mount = crate::conventional::link::turn(Axis::Z, 0.4)[0] * crate::conventional::link::turn(Axis::X, -0.8)[0];
    let of = |joint: Joint, mount| {
        let bodies: Vec<Body> = vec![body(None, Joint::Ball, identity, 2), body(Some(0), joint, mount, 2)];
        Assembly::new(bodies, vec![], vec![], gravity())
    };
    vec![
        ("revolute", of(Joint::Revolute(Axis::Y), mount)),
        ("universal", of(Joint::Universal, mount)),
        ("ball", of(Joint::Ball, mount)),
        ("ball, eq. (20)", of(Joint::BallInRoot, identity)),
        ("angles", of(Joint::Angles([Axis::X, Axis::Y, Axis::Z]), mount)),
        ("free", Assembly::new(vec![body(None, Joint::Free, mount, 2)], vec![], vec![], gravity())),
        ("DAE", index_1_dae(Between::Revolute, 2).0),
    ]
}

/// C-01. `B` and `Ḃq̇` equal differences of the nodes along the motion.
///
/// Central differences with step 1e-5 leave 1e-10 of truncation and, for the second, 1e-6 of round-off.
#[test]
fn c01_velocity_transformation_is_the_derivative_of_the_nodes() {
    for (name, system) in chains() {
        let n = system.coordinates();
        let q = DVector::from_fn(n, |i, _| scatter(i));
        let v = DVector::from_fn(n, |i, _| scatter(i + 100));
        let h = 1e-5;
        let motion = system.motion(&q, &v);
        let (ahead, behind) = (system.motion(&(&q + &v * h), &v), system.motion(&(&q - &v * h), &v));
        for (body, moving) in motion.iter().enumerate() {
            for (i, node) in moving.nodes.iter().enumerate() {
                let [a, b] = [&ahead[body].nodes[i], &behind[body].nodes[i]];
                let product = node
                    .columns
                    .iter()
                    .zip(&moving.active)
                    .map(|(c, &j)| c * v[j])
                    .sum::<crate::conventional::link::Node>();
                let first = ((a.h - b.h) / (2.0 * h) - node.rate).amax();
                let second = ((a.rate - b.rate) / (2.0 * h) - node.bias).amax();
                let columns = (product - node.rate).amax();
                assert!(first < 1e-7, "{name}, body {body}, node {i}: ḣ off by {first:.1e} m/s");
                assert!(second < 1e-6, "{name}, body {body}, node {i}: Ḃq̇ off by {second:.1e} m/s²");
                assert!(columns < 1e-12, "{name}, body {body}, node {i}: Bq̇ and ḣ differ by {columns:.1e} m/s");
            }
        }
        let residual = |q: &DVector<f64>| system.residual(q, &v);
        let (equations, _) = system.equations(&q, &v);
        let rate = (residual(&(&q + &v * h)) - residual(&(&q - &v * h))) / (2.0 * h);
        let second = (residual(&(&q + &v * h)) - residual(&q) * 2.0 + residual(&(&q - &v * h))) / (h * h);
        let error = (rate - &equations.jacobian * &v).amax();
        let bias = (second + &equations.gamma).amax();
        assert!(error < 1e-7, "{name}: Ψ_q off by {error:.1e}");
        assert!(bias < 1e-3, "{name}: γ off by {bias:.1e} (second difference: 1e-5 of round-off)");
    }
}

/// C-02. The energy of a free motion is constant to first order in time: `Ṫ + U̇ + V̇ = 0`, for each method on its constraint manifold.
/// Central differences over 2e-8 s leave round-off of 1e-15 of the energy: 1e-7 of a power that would change it in 1 ms.
#[test]
fn c02_power_balances_on_the_constraints() {
    for between in Between::ALL {
        for (name, (system, start)) in
            [("joint parameters", joint_parameters(between, 2)), ("DAE", index_1_dae(between, 2))]
        {
            let n = system.coordinates();
            let mut q = start.clone();
            for i in 0..n {
                // perturbs strains only: the start satisfies the constraints, straight or not
                let strain = (0..2).any(|b| (system.strain(b, 0)..system.first[b + 1]).contains(&i));
                if strain && system.bodies[0].joint != Joint::Nodal {
                    q[i] += 0.01 * scatter(i);
                }
            }
            let (equations, _) = system.equations(&q, &DVector::zeros(n));
            // velocities in the null space of the constraints
            let guess = DVector::from_fn(n, |i, _| scatter(i + 7));
            let svd = equations.jacobian.clone().svd(true, true);
            let correction = svd.solve(&(&equations.jacobian * &guess), 1e-12).expect("least squares");
            let v = guess - correction;
            let (a, _) = system.accelerations(&q, &v);
            let h = 1e-8; // the phase of the highest mode changes by 1e-4 rad in it
            let energy = |s: f64| system.energies(&(&q + &v * s + &a * (s * s / 2.0)), &(&v + &a * s)).total();
            let power = (energy(h) - energy(-h)) / (2.0 * h);
            let scale = system.energies(&q, &v).kinetic / 1e-3;
            assert!(power.abs() < 1e-6 * scale, "{between:?}, {name}: power {power:.1e} W of {scale:.1e} W");
        }
    }
}

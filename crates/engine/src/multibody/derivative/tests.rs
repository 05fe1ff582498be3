//! Derivatives in comparison with finite differences of the residual, and with each other.

use super::random_case::{Case, Extra};
use super::*;
use crate::load::RootMotion;
use crate::multibody::dynamics::residual;
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}

/// The derivative along random directions equals sixth-order differences of the residual, for 120 random machines, to 1e-9 of the largest
/// entry: the truncation error of the differences at this step is 1e-12, their round-off is 1e-16/3e-3 of residuals that are a hundred
/// times the derivative's smallest entries.
#[test]
fn forward_is_the_derivative_of_the_residual() {
    let mut worst = 0.0f64;
    for seed in 0..120 {
        let mut case = Case::with(seed, Extra::of(seed));
        let direction = [case.random(1.0), case.random(2.0), case.random(5.0)];
        let mut work = Workspace::new(&case.model);
        let step = 3e-3;
        let mut known = vec![0.0; case.model.coordinates];
        for (i, weight) in [(1.0, 45.0), (2.0, -9.0), (3.0, 1.0)] {
            for sign in [1.0, -1.0] {
                let there = case.residual_at(&mut work, &direction, sign * i * step);
                known.iter_mut().zip(&there).for_each(|(sum, r)| *sum += sign * weight * r / (60.0 * step));
            }
        }
        let found = case.forward(&direction);
        let miss: Vec<f64> = found.iter().zip(&known).map(|(a, b)| a - b).collect();
        worst = worst.max(largest(&miss) / largest(&known));
    }
    assert!(worst < 1e-9, "{worst:.1e}");
}

/// Forward and reverse products are transposes of each other: `⟨w, J δ⟩ = ⟨Jᵀ w, δ⟩` to round-off, for 120 random machines, to 1e-12 of the
/// sum of the terms' magnitudes.
#[test]
fn reverse_is_the_transpose_of_forward() {
    for seed in 0..120 {
        let mut case = Case::with(seed, Extra::of(seed));
        let direction = [case.random(1.0), case.random(2.0), case.random(5.0)];
        let w = case.random(1.0);
        let found = case.forward(&direction);
        let back = case.reverse(&w);
        let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f64>>();
        let left: f64 = pairs(&w, &found).iter().sum();
        let terms: Vec<f64> = back.iter().zip(&direction).flat_map(|(back, along)| pairs(back, along)).collect();
        let (right, size): (f64, f64) = (terms.iter().sum(), terms.iter().map(|term| term.abs()).sum());
        assert!((left - right).abs() < 1e-12 * size, "{seed}: {left} and {right} of {size}");
    }
}

/// GR-70: the factors with all terms of the tree solve `(M + g C + g² K) x = right` and its transpose for 20 random trees with branches, pairs,
/// masses with and without damping, free and held joints: known unknowns come back from their products, to 1e-9 of the largest
/// unknown.
#[test]
fn factors_solve_the_stage_and_its_transpose() {
    let (gain_s, mut worst) = (1e-3, 0.0f64);
    for seed in 0..20 {
        let mut case = Case::new(seed);
        case.model.closures.clear();
        case.loads.clear();
        case.root = RootMotion { gravity_m_s2: case.root.gravity_m_s2, ..RootMotion::default() };
        assert!(Derivative::has_factors(&case.model));
        let held = (seed % 2 == 0)
            .then(|| case.model.bodies.iter().position(|body| body.joint.kind.freedoms() == 1))
            .flatten();
        let pivots = [0.3, 0.02];
        let joints: Vec<(usize, usize)> = case
            .model
            .bodies
            .iter()
            .enumerate()
            .filter(|(_, body)| body.joint.kind.freedoms() == 1)
            .map(|(index, body)| (index, body.joint.coordinate))
            .collect();
        let pivot = |body: usize| (Some(body) != held).then(|| pivots[body % 2]);
        let held = held.map(|body| case.model.bodies[body].joint.coordinate);
        let mut known = case.random(1.0);
        held.into_iter().for_each(|c| known[c] = 0.0);
        let along = [gain_s * gain_s, gain_s, 1.0].map(|factor| known.iter().map(|x| factor * x).collect::<Vec<f64>>());
        let mut image = case.forward(&along);
        let [by_q, by_v, by_a] = case.reverse(&known);
        let mut image_transposed: Vec<f64> =
            (0..known.len()).map(|i| by_a[i] + gain_s * (by_v[i] + gain_s * by_q[i])).collect();
        for &(body, c) in &joints {
            if let Some(pivot) = pivot(body) {
                image[c] += pivot * known[c];
                image_transposed[c] += pivot * known[c];
            }
        }
        let motion = Motion { q: &case.motion[0], v: &case.motion[1], a: &case.motion[2] };
        let mut derivative = case.prepared(motion);
        derivative.factorize(&case.model, gain_s, &case.damping, pivot).expect("positive pivots");
        for image in [&mut image, &mut image_transposed] {
            held.into_iter().for_each(|c| image[c] = 3.0);
        }
        derivative.solve(&case.model, &mut image);
        derivative.solve_transposed(&case.model, &mut image_transposed);
        for found in [&image, &image_transposed] {
            let miss: Vec<f64> = found.iter().zip(&known).map(|(a, b)| a - b).collect();
            worst = worst.max(largest(&miss) / largest(&known));
        }
    }
    assert!(worst < 1e-9, "{worst:.1e}");
}

/// GR-71: products and solutions for four directions side by side are those of each direction alone, to 1e-12 of the largest entry of a
/// product and 1e-9 of the largest unknown, for 20 random trees.
#[test]
fn directions_side_by_side_are_those_alone() {
    let (gain_s, mut worst) = (1e-3, [0.0f64; 2]);
    for seed in 0..20 {
        let mut case = Case::new(seed);
        case.model.closures.clear();
        case.loads.clear();
        case.root = RootMotion { gravity_m_s2: case.root.gravity_m_s2, ..RootMotion::default() };
        let n = case.model.coordinates;
        let directions: [[Vec<f64>; 3]; 4] =
            std::array::from_fn(|_| [case.random(1.0), case.random(2.0), case.random(5.0)]);
        let row = |kind: usize| (0..n).map(|i| std::array::from_fn(|lane| directions[lane][kind][i])).collect();
        let [q, v, a]: [Vec<[f64; 4]>; 3] = std::array::from_fn(row);
        let motion = Motion { q: &case.motion[0], v: &case.motion[1], a: &case.motion[2] };
        let mut derivative = case.prepared(motion);
        assert!(derivative.has_lanes());
        let mut products = vec![[0.0; 4]; n];
        let mut lanes = Lanes::new(&case.model);
        derivative.forward_lanes((&case.model, &case.damping), &mut lanes, [&q, &v, &a], &mut products);
        derivative.factorize(&case.model, gain_s, &case.damping, |_| Some(0.1)).expect("positive pivots");
        let (mut solved, mut sweep) = (products.clone(), Sweep::new(&case.model));
        derivative.solve_lanes(&case.model, &mut sweep, &mut solved);
        for (lane, direction) in directions.iter().enumerate() {
            let mut known = case.forward(direction);
            for (worst, found) in worst.iter_mut().zip([&products, &solved]) {
                let miss: Vec<f64> = found.iter().zip(&known).map(|(row, known)| row[lane] - known).collect();
                *worst = worst.max(largest(&miss) / largest(&known));
                derivative.solve(&case.model, &mut known);
            }
        }
    }
    assert!(worst[0] < 1e-12 && worst[1] < 1e-9, "{:.1e} {:.1e}", worst[0], worst[1]);
}

/// Round-off of residuals in their central differences over a step of 1/8, as a share of the residual.
const ROUND_OFF: f64 = 1e-14;

/// A machine for derivatives by blocks and damping: with loops for seeds below 10, else without; every second has joints with several
/// degrees of freedom.
fn without_loads(seed: u64) -> Case {
    let mut case = Case::with(seed, if seed % 2 == 1 { Extra::Spatial } else { Extra::None });
    case.loads.clear();
    if seed >= 10 {
        case.model.closures.clear();
    }
    case
}

/// The residual with derivatives in place of the blocks is the derivative of the residual, which is linear in all blocks: central
/// differences over a step of 1/8 are exact, to 1e-12 of the largest entry and round-off of the residual. Stiffness and masses change, or
/// one of them; the masses of the first body stay. A mesh with another length has no such derivative.
#[test]
fn block_slopes_are_the_slope_of_the_residual() {
    use crate::multibody::block_slopes::BlockSlopes;
    for seed in 0..34 {
        let mut case = without_loads(seed);
        let [stiffens, weighs] = [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]][(seed % 3) as usize];
        for body in &mut case.model.bodies {
            body.joint.drive_inertia = 0.2;
        }
        let changed = |share: f64| {
            let mut model = case.model.clone();
            for (i, element) in model.elements.iter_mut().enumerate() {
                let by = 1.0 + stiffens * share * (1.0 + i as f64);
                element.elastic.stiffness *= by;
                element.elastic.coupling *= by;
                if i >= model.bodies[1].first_element {
                    element.cross_mass *= 1.0 + 2.0 * weighs * share;
                }
            }
            for node in &mut model.nodes[model.bodies[1].first_node..] {
                node.beam *= 1.0 + 2.0 * weighs * share;
                if let Some(attached) = &mut node.attached {
                    *attached *= 1.0 - weighs * share;
                }
            }
            for body in &mut model.bodies {
                body.joint.drive_inertia += share;
            }
            for closure in &mut model.closures {
                closure.penalty.inertia_kg += share;
                closure.penalty.damping_n_s_m -= 2.0 * share;
                closure.penalty.stiffness_n_m += 3.0 * share;
            }
            model
        };
        let step = 0.125;
        let models = [changed(step), changed(-step)];
        let weights = [0.5 / step, -0.5 / step];
        let slopes = BlockSlopes::new(&case.model, weights.into_iter().zip(&models));
        let motion = Motion { q: &case.motion[0], v: &case.motion[1], a: &case.motion[2] };
        let mut found = vec![0.0; case.model.coordinates];
        let mut swept = Workspace::new(&case.model);
        residual(&case.model, &mut swept, motion, case.environment(), &mut found);
        let at = (&swept, &case.prepared(motion));
        slopes.expect("equal meshes").residual(at, (&case.root, &case.damping), motion, &mut found);
        let (mut known, mut whole) = (vec![0.0; case.model.coordinates], 0.0f64);
        for (weight, model) in weights.into_iter().zip(&models) {
            let mut one = vec![0.0; case.model.coordinates];
            residual(model, &mut Workspace::new(model), motion, case.environment(), &mut one);
            whole = whole.max(largest(&one));
            known.iter_mut().zip(&one).for_each(|(sum, one)| *sum += weight * one);
        }
        let miss: Vec<f64> = found.iter().zip(&known).map(|(a, b)| a - b).collect();
        let allowed = 1e-12 * largest(&known) + ROUND_OFF * whole;
        assert!(largest(&miss) < allowed, "{seed}: {:.1e}", largest(&miss) / allowed);

        let mut longer = case.model.clone();
        longer.elements[0].length_m *= 1.1;
        assert!(BlockSlopes::new(&case.model, [(1.0, &longer)].into_iter()).is_none());
    }
}

/// GR-49: the derivative of the residual with respect to damping, which enters it linearly: central differences over a step of 1/8 are
/// exact, to 1e-12 of the largest entry and round-off of the residual.
#[test]
fn damping_slopes_are_the_slope_of_the_residual() {
    use crate::multibody::block_slopes::DampingSlope;
    for seed in 0..34 {
        let mut case = without_loads(seed);
        let own = case.damping.clone();
        // damping by masses and by stiffness, or one of them
        let [by_mass, by_stiffness] = [[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]][(seed % 3) as usize];
        let changed = |share: f64| {
            let by = |(i, own): (usize, &Damping)| Damping {
                mass_1_s: own.mass_1_s + by_mass * share * i as f64,
                stiffness_s: own.stiffness_s - 0.01 * by_stiffness * share,
                strain_inertia_s2: own.strain_inertia_s2 + 1e-5 * by_stiffness * share,
            };
            own.iter().enumerate().map(by).collect::<Vec<Damping>>()
        };
        let step = 0.125;
        let others = [changed(step), changed(-step)];
        let weights = [0.5 / step, -0.5 / step];
        let weighted = || weights.into_iter().zip(others.iter().map(Vec::as_slice));
        let motion = case.motion.clone();
        let motion = Motion { q: &motion[0], v: &motion[1], a: &motion[2] };
        let (mut known, mut whole) = (vec![0.0; case.model.coordinates], 0.0f64);
        for (weight, damping) in weighted() {
            let mut one = vec![0.0; case.model.coordinates];
            case.damping = damping.to_vec();
            residual(&case.model, &mut Workspace::new(&case.model), motion, case.environment(), &mut one);
            whole = whole.max(largest(&one));
            known.iter_mut().zip(&one).for_each(|(sum, one)| *sum += weight * one);
        }
        case.damping = own.clone();
        let mut swept = Workspace::new(&case.model);
        let mut found = vec![0.0; case.model.coordinates];
        residual(&case.model, &mut swept, motion, case.environment(), &mut found);
        found.fill(0.0);
        let mut slope = DampingSlope::new(&case.model, &own, weighted()).expect("other damping");
        slope.add_residual((&case.model, &swept, &case.prepared(motion)), &case.root, motion, &mut found);
        let miss: Vec<f64> = found.iter().zip(&known).map(|(a, b)| a - b).collect();
        let allowed = 1e-12 * largest(&known) + ROUND_OFF * whole;
        assert!(largest(&miss) < allowed, "{seed}: {:.1e}", largest(&miss) / allowed);
        let same = [(1.0, own.as_slice())].into_iter();
        assert!(DampingSlope::new(&case.model, &own, same).is_none());
    }
}

/// Without motion, the derivative with respect to the coordinates is the exact static tangent under the same loads, `K` without the damping
/// of the strains, also in a rotating root frame, to round-off: 1e-12 of the largest entry.
#[test]
fn static_limit_is_the_exact_tangent() {
    use crate::multibody::tangent::{JointTangent, Surroundings, Tangent};
    for seed in 0..10 {
        let mut case = Case::new(seed);
        case.motion[1].fill(0.0);
        case.motion[2].fill(0.0);
        let n = case.model.coordinates;
        let direction = [case.random(1.0), vec![0.0; n], vec![0.0; n]];
        let mut work = Workspace::new(&case.model);
        case.residual_at(&mut work, &direction, 0.0);
        let joints = vec![JointTangent::one_freedom(0.0); case.model.bodies.len()];
        let mut tangent = Tangent::new(&case.model);
        let surroundings = Surroundings { root: &case.root, stations: &case.loads, joints: &joints };
        tangent.linearize(&case.model, &work, &case.motion[0], surroundings);
        let mut known = vec![0.0; n];
        tangent.apply(&case.model, &direction[0], &mut known);
        let miss: Vec<f64> = case.forward(&direction).iter().zip(&known).map(|(a, b)| a - b).collect();
        let miss = largest(&miss) / largest(&known);
        assert!(miss < 1e-12, "{seed}: {miss:.1e}");
    }
}

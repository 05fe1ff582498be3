//! Directional and adjoint derivatives of FMI 3.0 against differences between events, in every phase of the wing's motion.

use crate::fmi3::{EVENTS, FLYING, STEP_S, TWO_FOLDS};
use crate::fmu::WING;
use crate::fmu3::Fmu3;
use foldwing::interface::{Causality, Kind};
use foldwing_fmu::fmi3::derivatives::*;
use foldwing_fmu::fmi3::exchange::*;
use foldwing_fmu::fmi3::functions::*;
use foldwing_fmu::fmi3::states::*;
use foldwing_fmu::fmi3::values::fmi3GetFloat64;

const FOUR_BAR: &str = include_str!("../../examples/models/four_bar.toml");
const PENDULUM: &str = include_str!("../../examples/models/double_pendulum.toml");

/// Arrays of Reals of a causality, with the total number of their elements.
fn reals(fmu: &Fmu3, causality: Causality) -> (Vec<u32>, usize) {
    let table = &fmu.table;
    let fits = |array: &&foldwing::interface::Array| {
        table.head(array).causality == causality && table.head(array).value.kind() == Kind::Real
    };
    let found = table.arrays().iter().filter(fits);
    let count = found.clone().map(|array| array.rows.len()).sum();
    (found.map(|array| fmu.reference(&array.name)).collect(), count)
}

fn directional(fmu: &Fmu3, (unknowns, rows): &(Vec<u32>, usize), knowns: &[u32], seed: &[f64]) -> Vec<f64> {
    let mut found = vec![f64::NAN; *rows];
    fmu.ok(unsafe {
        fmi3GetDirectionalDerivative(
            fmu.instance,
            unknowns.as_ptr(),
            unknowns.len(),
            knowns.as_ptr(),
            knowns.len(),
            seed.as_ptr(),
            seed.len(),
            found.as_mut_ptr(),
            found.len(),
        )
    });
    found
}

fn adjoint(fmu: &Fmu3, unknowns: &[u32], seed: &[f64], (knowns, columns): &(Vec<u32>, usize)) -> Vec<f64> {
    let mut found = vec![f64::NAN; *columns];
    fmu.ok(unsafe {
        fmi3GetAdjointDerivative(
            fmu.instance,
            unknowns.as_ptr(),
            unknowns.len(),
            knowns.as_ptr(),
            knowns.len(),
            seed.as_ptr(),
            seed.len(),
            found.as_mut_ptr(),
            found.len(),
        )
    });
    found
}

fn values(fmu: &Fmu3, (references, count): &(Vec<u32>, usize)) -> Vec<f64> {
    let mut values = vec![f64::NAN; *count];
    fmu.ok(unsafe {
        fmi3GetFloat64(fmu.instance, references.as_ptr(), references.len(), values.as_mut_ptr(), values.len())
    });
    values
}

/// All outputs after an event in which an input has another value; the instance is restored afterwards.
fn outputs_at(fmu: &Fmu3, outputs: &(Vec<u32>, usize), name: &str, given: &[f64]) -> Vec<f64> {
    let mut before = fmu.save();
    fmu.ok(unsafe { fmi3EnterEventMode(fmu.instance) });
    fmu.set(name, given);
    fmu.update();
    let found = values(fmu, outputs);
    fmu.ok(unsafe { fmi3SetFMUState(fmu.instance, before) });
    fmu.ok(unsafe { fmi3FreeFMUState(fmu.instance, &mut before) });
    found
}

/// Continues to a time in s, through the events in between.
fn go_to(fmu: &Fmu3, mut time_s: f64, end_s: f64) {
    while time_s < end_s - 1e-12 {
        let answer = fmu.step(time_s, STEP_S.min(end_s - time_s));
        time_s = answer.last_s;
        if answer.event {
            fmu.ok(unsafe { fmi3EnterEventMode(fmu.instance) });
            fmu.update();
            fmu.ok(unsafe { crate::fmi3::enter_step(fmu.instance) });
        }
    }
}

/// Largest derivative of a vector.
fn steepest(derivatives: &[f64], of: &std::ops::Range<usize>) -> f64 {
    derivatives[of.clone()].iter().fold(0.0, |largest: f64, derivative| largest.max(derivative.abs()))
}

/// Compares at the current state; returns the largest relative error of a nonzero derivative, and the number of these.
fn compare(fmu: &Fmu3, place: &str) -> (f64, usize) {
    let (outputs, inputs) = (reals(fmu, Causality::Output), reals(fmu, Causality::Input));
    let mut present: Vec<f64> = Vec::new();
    let (mut worst, mut found_some) = (0.0_f64, 0);
    let mut neighbours: Vec<std::ops::Range<usize>> = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for &output in &outputs.0 {
        let array = &fmu.table.arrays()[output as usize];
        names.extend((0..array.rows.len()).map(|element| format!("{}[{element}]", array.name)));
        let (begin, length) = (neighbours.len(), fmu.table.arrays()[output as usize].rows.len());
        neighbours.extend(std::iter::repeat_n(begin..begin + length, length));
    }
    for &known in &inputs.0 {
        let name = fmu.table.arrays()[known as usize].name.clone();
        let value = fmu.get(&name);
        for element in 0..value.len() {
            let mut seed = vec![0.0; value.len()];
            seed[element] = 1.0;
            let given = directional(fmu, &outputs, &[known], &seed);
            // at a fixed state outputs are polynomials of second degree in the inputs, except at motor limits
            let size = if name.starts_with("fold") { 1e-4 } else { 0.5 };
            if present.is_empty() {
                present = outputs_at(fmu, &outputs, &name, &value);
            }
            let mut differences = |size: f64| -> Vec<f64> {
                let [above, below] = [size, -size].map(|step| {
                    let mut beside = value.clone();
                    beside[element] += step;
                    outputs_at(fmu, &outputs, &name, &beside)
                });
                above.iter().zip(&below).map(|(above, below)| (above - below) / (2.0 * size)).collect()
            };
            let [whole, half] = [size, 0.5 * size].map(&mut differences);
            for (row, (&derivative, &difference)) in given.iter().zip(&whole).enumerate() {
                // Allowed in addition to the required 1e-6: the round-off of the differences, ten times that of all components of the
                // vector. Both differences are exact for polynomials of second degree, so they differ only by round-off. Components come
                // from one solution, so each has a round-off relative to the largest derivative of the vector, and to its largest value
                // divided by the step, for which 2.2e-11 was found.
                let spread = neighbours[row]
                    .clone()
                    .fold(0.0, |largest: f64, other| largest.max((whole[other] - half[other]).abs()));
                let largest =
                    neighbours[row].clone().fold(1e-2, |largest: f64, other| largest.max(present[other].abs()));
                let round_off = 10.0 * spread + 1e-8 * steepest(&given, &neighbours[row]) + 1e-10 * largest / size;
                let error = (derivative - difference).abs();
                assert!(
                    error <= 1e-6 * derivative.abs() + round_off,
                    "{place}: {} by {name}[{element}]: {derivative:e} against {difference:e}, round-off {round_off:e}",
                    names[row]
                );
                if derivative.abs() > 1e3 * round_off {
                    worst = worst.max(error / derivative.abs());
                    found_some += 1;
                }
            }
        }
    }
    // the adjoint is the transpose: ⟨y, J u⟩ = ⟨Jᵀ y, u⟩, to the round-off of sums that cancel
    let mut random = fastrand::Rng::with_seed(7);
    for _ in 0..3 {
        let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| random.f64() - 0.5).collect() };
        let (u, y) = (draw(inputs.1), draw(outputs.1));
        let forward = directional(fmu, &outputs, &inputs.0, &u);
        let backward = adjoint(fmu, &outputs.0, &y, &inputs);
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let scale: f64 = backward.iter().zip(&u).map(|(a, b)| (a * b).abs()).sum::<f64>()
            + forward.iter().zip(&y).map(|(a, b)| (a * b).abs()).sum::<f64>();
        let (left, right) = (dot(&y, &forward), dot(&backward, &u));
        assert!((left - right).abs() <= 1e-12 * scale, "{place}: {left} against {right}");
    }
    (worst, found_some)
}

/// F3-14. Co-simulation of FMI 3.0 with Event Mode, five machines: the derivatives of all outputs with respect to all elements of all
/// inputs equal differences between events to 1e-6, folded, while unfolding and latched; the adjoint is the transpose to round-off. The
/// differences are taken outside the library, from events with another input.
#[test]
fn f314_derivatives_are_the_differences_between_events() {
    for (name, text, times_s, latched) in [
        ("folding_wing", WING, [0.0, 0.06, 0.2].as_slice(), Some("fold.latched")),
        ("three_bodies", TWO_FOLDS, &[0.0, 0.5], Some("fold_inner.latched")),
        ("flying_wing", FLYING, &[0.0, 0.02], None),
        ("double_pendulum", PENDULUM, &[0.0, 0.05], None),
        ("four_bar", FOUR_BAR, &[0.0, 0.05], None),
    ] {
        let fmu = Fmu3::new(text, EVENTS);
        fmu.start();
        fmu.update();
        fmu.ok(unsafe { crate::fmi3::enter_step(fmu.instance) });
        let mut time_s = 0.0;
        for &until_s in times_s {
            go_to(&fmu, time_s, until_s);
            time_s = until_s;
            let (worst, count) = compare(&fmu, &format!("{name} at {time_s} s"));
            println!(
                "F3-14 {name} at {time_s} s: {count} derivatives that are not zero, worst relative error {worst:.1e}"
            );
            assert!(count > 30, "{name} at {time_s} s: {count}");
        }
        assert!(latched.is_none_or(|latched| fmu.get_boolean(latched)), "{name} must have latched on the way");
    }
}

/// F3-15. In Initialization Mode, with respect to inputs and parameters: the adjoint is the transpose of the directional derivative to
/// round-off.
#[test]
fn f315_the_adjoint_is_the_transpose_in_initialization_mode() {
    for text in [WING, FLYING] {
        let fmu = Fmu3::new(text, EVENTS);
        fmu.ok(unsafe { fmi3EnterInitializationMode(fmu.instance, false, 0.0, 0.0, false, 0.0) });
        let outputs = reals(&fmu, Causality::Output);
        let (mut knowns, mut columns) = reals(&fmu, Causality::Input);
        let parameters = reals(&fmu, Causality::Parameter).0;
        let fits = |reference: &&u32| !fmu.table.arrays()[**reference as usize].name.starts_with("solver.");
        for &parameter in parameters.iter().filter(fits) {
            knowns.push(parameter);
            columns += fmu.table.arrays()[parameter as usize].rows.len();
        }
        let knowns = (knowns, columns);
        let mut random = fastrand::Rng::with_seed(11);
        let mut draw = |count: usize| -> Vec<f64> { (0..count).map(|_| random.f64() - 0.5).collect() };
        let (u, y) = (draw(knowns.1), draw(outputs.1));
        let forward = directional(&fmu, &outputs, &knowns.0, &u);
        let backward = adjoint(&fmu, &outputs.0, &y, &knowns);
        let terms = |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a * b).collect() };
        let (left, right) = (terms(&y, &forward), terms(&backward, &u));
        let scale: f64 = left.iter().chain(&right).map(|term| term.abs()).sum();
        let difference = left.iter().sum::<f64>() - right.iter().sum::<f64>();
        assert!(difference.abs() <= 1e-12 * scale, "{difference} of {scale}");
        assert!(forward.iter().filter(|entry| **entry != 0.0).count() > 20);
    }
}

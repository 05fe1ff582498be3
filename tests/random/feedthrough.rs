//! Directional derivatives of co-simulation FMUs of random machines. X-21.

use crate::Verdict;
use crate::machine;
use crate::machines::{Model, View};
use foldwing::instance::{Instance, Manner, Request, Setup, Version};
use foldwing::interface::{Causality, Interface, Kind, Variability, guid};

/// Changes of an input over its value, or over one unit, in the differences of the shown outputs, which are of second degree in the inputs:
/// large ones have less round-off, small ones meet fewer limits of motors. With each the allowed difference over the derivative.
const CHANGES: [(f64, f64); 4] = [(0.3, 1e-7), (1e-2, 1e-7), (1e-4, 1e-5), (1e-6, 1e-5)];
/// Round-off of a shown output over its value, or over one unit: accelerations of stiff beams are differences of large numbers (found: 3e-11).
const ROUND_OFF: f64 = 1e-10;
/// Allowed difference over the largest derivative by the same input.
const ALLOWED: f64 = 1e-8;

/// An instance for co-simulation with its table, in initialisation mode; `None` for machines that have none, and in air, where derivatives
/// would hold the loads of the air and are an error.
fn starting(model: &Model) -> Option<(Instance, Interface)> {
    let text = model.text(&View::plain());
    let parsed = machine(model, &View::plain()).ok().filter(|parsed| parsed.air.is_none())?;
    let table = Interface::new(&parsed);
    let token = guid(&text, table.variables());
    let request = Request {
        version: Version::Fmi2,
        name: Some("random"),
        fmu_type: 1,
        guid: Some(&token),
        resource_location: None,
        manner: Manner::default(),
    };
    let mut instance = Instance::of_text(&request, &text, "model.toml").ok()?;
    let start_s = parsed.experiment.start_time_s;
    instance.setup_experiment(Setup { tolerance: None, start_s, stop_s: None }).ok()?;
    instance.enter_initialization();
    Some((instance, table))
}

/// Real outputs, and continuous inputs.
fn rows(table: &Interface) -> [Vec<u32>; 2] {
    let real = || table.variables().iter().filter(|row| row.value.kind() == Kind::Real);
    let is_input = |row: &&foldwing::interface::Variable| {
        row.causality == Causality::Input && row.variability == Variability::Continuous
    };
    let outputs = real().filter(|row| row.causality == Causality::Output);
    [outputs.map(|row| row.value_reference).collect(), real().filter(is_input).map(|row| row.value_reference).collect()]
}

/// Differences of the shown outputs of fourth order, by an input, and the allowed difference; `None` if a value is out of range.
fn differences(
    instance: &mut Instance,
    outputs: &[u32],
    input: u32,
    (change, same): (f64, f64),
) -> Option<[Vec<f64>; 2]> {
    let mut present = [0.0];
    instance.get(&[input][..], &mut present).ok()?;
    let change = change * present[0].abs().max(1.0);
    let (mut slope, mut size) = (vec![0.0; outputs.len()], vec![0.0f64; outputs.len()]);
    let mut values = slope.clone();
    for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
        instance.set(&[input][..], &[present[0] + steps * change]).ok()?;
        instance.get(outputs, &mut values).ok()?;
        for ((slope, size), value) in slope.iter_mut().zip(&mut size).zip(&values) {
            *slope += weight / (12.0 * change) * value;
            *size = size.max(value.abs());
        }
    }
    instance.set(&[input][..], &present).ok()?;
    let allowed = |(slope, size): (&f64, &f64)| same * slope.abs() + ROUND_OFF * size.max(1.0) / CHANGES[0].0;
    let allowed = slope.iter().zip(&size).map(allowed).collect();
    Some([slope, allowed])
}

/// At a communication point, derivatives are the differences of the outputs that the FMU shows when an input is set.
pub fn shown(model: &Model) -> Verdict {
    let Some((mut instance, table)) = starting(model) else { return Verdict::Silent };
    let [outputs, inputs] = rows(&table);
    if instance.exit_initialization().is_err() {
        return Verdict::Silent;
    }
    let name = |row: u32| &table.variables()[row as usize].name;
    let mut at_s = machine(model, &View::plain()).expect("an instance has it").experiment.start_time_s;
    for _ in 0..2 {
        if instance.do_step(at_s, 0.0137).is_err() {
            return Verdict::Silent;
        }
        at_s += 0.0137;
    }
    let mut column = vec![0.0; outputs.len()];
    for &input in &inputs {
        if let Err(error) = instance.directional_derivative((&outputs, &mut column), (&[input], &[1.0])) {
            return Verdict::Broken(format!("derivative by {}: {error}", name(input)));
        }
        let known: Vec<_> =
            CHANGES.iter().filter_map(|change| differences(&mut instance, &outputs, input, *change)).collect();
        let largest = known.iter().flat_map(|[slopes, _]| slopes).fold(0.0f64, |most, slope| most.max(slope.abs()));
        for (place, (&output, own)) in outputs.iter().zip(&column).enumerate() {
            let is_shown =
                |[slopes, allowed]: &[Vec<f64>; 2]| (own - slopes[place]).abs() <= ALLOWED * largest + allowed[place];
            if !known.is_empty() && !known.iter().any(is_shown) {
                let shown: Vec<f64> = known.iter().map(|[slopes, _]| slopes[place]).collect();
                return Verdict::Broken(format!("d {} / d {} = {own:e}, shown {shown:?}", name(output), name(input)));
            }
        }
    }
    Verdict::Holds
}

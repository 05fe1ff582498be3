//! After the first step no memory is allocated, neither in `fmi2DoStep` nor in getting and setting values.

use crate::counting_allocator::allocations;
use crate::fmu::Fmu;
use foldwing::interface::{Causality, Value};
use foldwing_fmu::derivatives::fmi2SetRealInputDerivatives;
use foldwing_fmu::functions::*;

/// Value references and values of the Reals of a causality.
fn reals(fmu: &Fmu, causality: Causality) -> (Vec<u32>, Vec<f64>) {
    let rows = fmu.table.variables().iter().filter(|row| row.causality == causality);
    rows.filter_map(|row| match row.value {
        Value::Real(value) => Some((row.value_reference, value)),
        _ => None,
    })
    .unzip()
}

#[test]
fn a_step_with_its_inputs_and_outputs_allocates_nothing() {
    let fmu = Fmu::stepping();
    let (inputs, mut commands) = reals(&fmu, Causality::Input);
    let (outputs, mut values) = reals(&fmu, Causality::Output);
    let exchange = |i: usize, commands: &mut [f64], values: &mut [f64]| unsafe {
        commands[1] = 1e-4 * i as f64; // fold.torque: the input jumps at every step
        assert_eq!(fmi2SetReal(fmu.component, inputs.as_ptr(), inputs.len(), commands.as_ptr()), 0);
        // also between steps, with the inputs as set
        assert_eq!(fmi2GetReal(fmu.component, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), 0);
        // every other step has input derivatives
        assert_eq!(fmi2SetRealInputDerivatives(fmu.component, &inputs[1], i % 2, &1, &1e-3), 0);
        assert_eq!(fmi2DoStep(fmu.component, 1e-3 * i as f64, 1e-3, 1), 0);
        assert_eq!(fmi2GetReal(fmu.component, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), 0);
    };
    exchange(0, &mut commands, &mut values);
    let before = allocations();
    for i in 1..200 {
        exchange(i, &mut commands, &mut values);
    }
    assert_eq!(allocations() - before, 0, "allocations in 199 steps through the latch");
    assert!(fmu.get_boolean("fold.latched"), "the latch must have closed on the way");
}

//! After the first step nothing is allocated: neither in `fmi2DoStep` nor in getting and setting values.

mod fmu;

use fmu::Fmu;
use foldwing::interface::{Causality, Value};
use foldwing_fmu::derivatives::fmi2SetRealInputDerivatives;
use foldwing_fmu::functions::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

/// The system's allocator, counting per thread.
struct Counting;

// SAFETY: forwards everything to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let _ = ALLOCATIONS.try_with(|count| count.set(count.get() + 1));
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

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
        commands[1] = 1e-4 * i as f64; // fold.torque: every step is a jump
        assert_eq!(fmi2SetReal(fmu.component, inputs.as_ptr(), inputs.len(), commands.as_ptr()), 0);
        // every other step runs with derivatives
        assert_eq!(fmi2SetRealInputDerivatives(fmu.component, &inputs[1], i % 2, &1, &1e-3), 0);
        assert_eq!(fmi2DoStep(fmu.component, 1e-3 * i as f64, 1e-3, 1), 0);
        assert_eq!(fmi2GetReal(fmu.component, outputs.as_ptr(), outputs.len(), values.as_mut_ptr()), 0);
    };
    exchange(0, &mut commands, &mut values);
    let before = ALLOCATIONS.get();
    for i in 1..200 {
        exchange(i, &mut commands, &mut values);
    }
    assert_eq!(ALLOCATIONS.get() - before, 0, "allocations in 199 steps through the latch");
    assert!(fmu.get_boolean("fold.latched"), "the latch must have closed on the way");
}

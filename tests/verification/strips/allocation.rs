//! W-28: nothing allocates between the start and the end of a run.

use foldwing::aero::AirLoads;
use foldwing::aero::flow::Flow;
use foldwing::aero::strip::Strips;
use nalgebra::Vector3;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use crate::plate::{Motion, Plate};

/// The system's allocator, which counts per thread.
struct Counting;

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is forwarded unchanged to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // during a thread's teardown there is no counter any more
        let _ = ALLOCATIONS.try_with(|allocations| allocations.set(allocations.get() + 1));
        // SAFETY: forwarded from the caller.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: forwarded from the caller.
        unsafe { System.dealloc(block, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// W-28. `start`, `convect`, `solve` and `copy_from` allocate nothing.
#[test]
fn w28_steps_do_not_allocate() {
    let mut strips = Strips::new(vec![Plate::default().surface()], Plate::default().options);
    let (mut from, mut to) = (strips.blank_state(), strips.blank_state());
    let mut loads = AirLoads::still(2);
    let motions = Plate::sections(Motion { pitch_rad: 0.1, ..Default::default() });
    let wind_m_s = -Vector3::y() * 10.0;
    let flow = Flow { time_s: 0.0, density_kg_m3: 1.2, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] };
    let before = ALLOCATIONS.with(Cell::get);
    assert!(before > 0, "the counter counts");
    strips.start(&motions, &flow, false, &mut from, &mut loads);
    for _ in 0..10 {
        strips.convect(&from, &flow, 0.01, &mut to);
        strips.solve(&from, &motions, &flow, 0.01, &mut to, &mut loads);
        from.copy_from(&to);
    }
    assert_eq!(ALLOCATIONS.with(Cell::get), before);
}

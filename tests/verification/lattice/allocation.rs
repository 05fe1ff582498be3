//! U-28: nothing allocates between the start and the end of a run.

use foldwing::aero::lattice::{LatticeOptions, LoadRule, WakeModel};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use crate::wing::{Wing, inset, options};

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

/// U-28. `start`, `convect`, `solve` and `copy_from` allocate nothing on one thread, with a full wake or not.
#[test]
fn u28_steps_do_not_allocate() {
    let rule = LatticeOptions { wake: WakeModel::Free, load_rule: LoadRule::KuttaJoukowski, wake_rows: 4, ..options() };
    let mut wing = Wing::new(&inset(6.0, 6), |_| 1.0, 3, rule).with_incidence(0.1);
    wing.start(false);
    let before = ALLOCATIONS.get();
    wing.start(true);
    wing.start(false);
    for step in 0..8 {
        wing.motions[3].position_m.z = 0.01 * f64::from(step);
        wing.step(0.02);
    }
    wing.to.copy_from(&wing.from);
    assert_eq!(ALLOCATIONS.get(), before);
}

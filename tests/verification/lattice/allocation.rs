//! U-28: no memory is allocated between the start and the end of a run.

use foldwing::aero::lattice::{LatticeOptions, LoadRule, WakeModel};

use crate::counting_allocator::allocations;
use crate::lattice::wing::{Wing, inset, options};

/// U-28. `start`, `convect`, `solve` and `copy_from` allocate no memory on one thread, with a full or a growing wake.
#[test]
fn u28_steps_do_not_allocate() {
    let rule = LatticeOptions { wake: WakeModel::Free, load_rule: LoadRule::KuttaJoukowski, wake_rows: 4, ..options() };
    let mut wing = Wing::new(&inset(6.0, 6), |_| 1.0, 3, rule).with_incidence(0.1);
    wing.start(false);
    let before = allocations();
    wing.start(true);
    wing.start(false);
    for step in 0..8 {
        wing.motions[3].position_m.z = 0.01 * f64::from(step);
        wing.step(0.02);
    }
    wing.to.copy_from(&wing.from);
    assert_eq!(allocations(), before);
}

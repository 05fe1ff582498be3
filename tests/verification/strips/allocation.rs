//! W-28: no memory is allocated between the start and the end of a run.

use foldwing::aero::AirLoads;
use foldwing::aero::flap::{Deflection, Flap};
use foldwing::aero::flow::Flow;
use foldwing::aero::strip::Strips;
use nalgebra::Vector3;

use crate::counting_allocator::allocations;
use crate::strips::plate::{Motion, Plate};

/// W-28. `start`, `deflect`, `convect`, `solve` and `copy_from` allocate no memory, with a control surface.
#[test]
fn w28_steps_do_not_allocate() {
    let mut strips = Strips::new(vec![Plate::default().surface()], Plate::default().options);
    strips.add_flaps(&[Flap {
        name: "flap".into(),
        surface: 0,
        strips: 0..1,
        hinge_fraction: 0.75,
        lower_rad: -1.0,
        upper_rad: 1.0,
        command_rad: 0.0,
        downward: 1.0,
    }]);
    let (mut from, mut to) = (strips.blank_state(), strips.blank_state());
    let mut loads = AirLoads::still(2);
    let motions = Plate::sections(Motion { pitch_rad: 0.1, ..Default::default() });
    let wind_m_s = -Vector3::y() * 10.0;
    let flow = Flow { time_s: 0.0, density_kg_m3: 1.2, wind_m_s, spin_rad_s: Vector3::zeros(), gusts: &[] };
    let before = allocations();
    assert!(before > 0, "the counter counts");
    strips.start(&motions, &flow, false, &mut from, &mut loads);
    for _ in 0..10 {
        strips.deflect(&[Deflection { angle_rad: 0.1, rate_rad_s: 1.0 }]);
        strips.convect(&from, &flow, 0.01, &mut to);
        strips.solve(&from, &motions, &flow, 0.01, &mut to, &mut loads);
        from.copy_from(&to);
    }
    assert_eq!(allocations(), before);
}

//! A wing with a lattice, for unit tests of its linear model.

use crate::aero::AirState;
use crate::aero::lattice_state::LatticeState;
use crate::beam::profile::Profile as Along;
use crate::beam::section::{Material, Solid};
use crate::machine::builder::FlapBuilder;
use crate::machine::{Air, Body, Coupling, ElementKind, Joint, LiftingSurface, Machine, Motor, Solver};
use crate::system::state::State;

/// Aerodynamic step in s.
pub(crate) const STEP_S: f64 = 2.5e-3;
/// Structural steps per aerodynamic step: the phase of the fastest mode advances by 0.02 rad in each.
const SUBSTEPS: usize = 128;
pub(crate) const WAKE_ROWS: usize = 5;
pub(crate) const STRIPS: usize = 3;
const CHORD_PANELS: usize = 2;
pub(crate) const PANELS: usize = STRIPS * CHORD_PANELS;

/// A soft wing with a control surface on a hinge with a spring, at an airspeed with lift.
pub(crate) fn wing() -> Machine {
    let foam = Material { youngs_modulus_pa: 7e6, shear_modulus_pa: 3e6, density_kg_m3: 140.0 };
    let drive = Motor { stiffness_n_m_rad: 60.0, damping_n_m_s_rad: 0.3, ..Motor::default() };
    Machine::builder("Soft")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(
            Body::beam("wing", 0.5, Solid::rectangle(0.2, 0.05, foam))
                .elements(1)
                .element(ElementKind::Constant)
                .load_stations(1),
            Joint::revolute("fold", [0.2, 1.0, 0.1]).motor(drive).start_angle_rad(0.1),
        )
        .air(
            Air::lattice()
                .density_kg_m3(1.2)
                .wind_m_s([1.0, -24.0, 1.5])
                .step_s(STEP_S)
                .wake_rows(WAKE_ROWS)
                .coupling(Coupling::Iterated { tolerance: 1e-12, most_iterations: 50 }),
        )
        .surface(LiftingSurface::on("wing", STRIPS).chord_panels(CHORD_PANELS).chord_m(Along::constant(0.2)))
        .flap(FlapBuilder::new("flap", "wing", [0.0, 0.5], 0.5).command_rad(0.05))
        .solver(Solver { tolerance: 1e-10, fixed_step_s: Some(STEP_S / SUBSTEPS as f64), ..Solver::default() })
        .step_s(STEP_S)
        .build()
        .unwrap_or_else(|refused| panic!("{refused}"))
}

/// The lattice of a state at the end of its aerodynamic step.
pub(crate) fn lattice(state: &mut State) -> &mut LatticeState {
    match state.air.as_mut().expect("air").after.only_mut() {
        Some(AirState::Lattice(state)) => state,
        Some(AirState::Strips(_) | AirState::Rotor(_) | AirState::SlenderBody(_)) | None => panic!("a lattice"),
    }
}

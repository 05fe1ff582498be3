//! Models with aerodynamics: dependencies of control surfaces, derivatives of initial values.

use super::*;
use foldwing_engine::plant::PlantError;

/// A wing with a flap on strips with drag, so that its loads are not polynomials of the motion.
fn machine_in_air() -> Machine {
    machine(&format!(
        "{}\n[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0, -0.5, 0.05]\n\n[surface.inner]\nbody = \"inner\"\nstrips = 4\ndrag_coefficient = 0.5\n\n\
         [control_surface.tab]\nbody = \"inner\"\nfrom_m = 0.05\nto_m = 0.1\nhinge_fraction = 0.75\n",
        WING.replace("elements = 4", "elements = 2")
    ))
}

/// A plant in its initial state with some of the inputs set.
fn started(machine: &Machine, interface: &Interface, inputs: &[(&str, f64)]) -> Result<Plant, PlantError> {
    let mut plant = Plant::new(Arc::new(machine.clone()));
    for (name, value) in inputs {
        let row = interface.find(name).expect("an input").value_reference;
        interface.set(&mut plant, row, Value::Real(*value)).expect("in range");
    }
    plant.initialize(0.0).map(|()| plant)
}

/// The angle of a control surface depends on its own command only, its rate on the commanded rate: at communication points and at the
/// start, as declared and as found with the plant.
#[test]
fn flaps_depend_on_their_commands() {
    let machine = machine_in_air();
    let interface = Interface::new(&machine);
    let dependencies = interface.dependencies(&machine);
    let [command, command_rate] =
        ["aero.control_surface.tab.angle_command", "aero.control_surface.tab.angle_command_rate"];
    for (output, input) in
        [("aero.control_surface.tab.angle", command), ("aero.control_surface.tab.rate", command_rate)]
    {
        let [of, by] = [output, input].map(|name| interface.find(name).expect(name).value_reference);
        let own = &dependencies[of as usize];
        for list in [&own.running, &own.initial] {
            assert_eq!(list.iter().map(|(known, _)| *known).collect::<Vec<_>>(), [by], "{output}");
        }
        for (other, expected) in [(command, input == command), (command_rate, input == command_rate)] {
            let plant = started(&machine, &interface, &[(other, 0.1)]).expect("start values");
            let value = interface.get(&plant, plant.outputs(), of);
            assert_eq!(value, Some(Value::Real(if expected { 0.1 } else { 0.0 })), "{output} by {other}");
        }
    }
}

/// With aerodynamics the initial loads are not polynomials of the root's angular velocity, unlike without: the derivative is the limit of
/// differences. Tolerance: the error of the fourth-order differences used here, 1e-8 of the derivative.
#[test]
fn derivatives_by_the_root_s_spin_in_air_are_limits() {
    const STEP_RAD_S: f64 = 1e-2;
    let machine = machine_in_air();
    let interface = Interface::new(&machine);
    let [of, by] =
        ["aero.force.z", "root.angular_velocity.y"].map(|name| interface.find(name).expect(name).value_reference);
    let force_n = |spin_rad_s: f64| {
        let plant = started(&machine, &interface, &[("root.angular_velocity.y", spin_rad_s)]).expect("start values");
        match interface.get(&plant, plant.outputs(), of) {
            Some(Value::Real(value)) => value,
            other => panic!("{other:?}"),
        }
    };
    let difference = |steps: f64| force_n(steps * STEP_RAD_S) - force_n(-steps * STEP_RAD_S);
    let expected = (8.0 * difference(1.0) - difference(2.0)) / (12.0 * STEP_RAD_S);
    let mut plant = started(&machine, &interface, &[]).expect("start values");
    let mut found = [0.0];
    let seeds = (&[by][..], &[1.0][..]);
    interface.directional_derivative(&mut plant, (Stage::Starting, 0.0), (&[of], &mut found), seeds).expect("one");
    assert!((found[0] / expected - 1.0).abs() < 1e-7, "{} {expected}", found[0]);
}

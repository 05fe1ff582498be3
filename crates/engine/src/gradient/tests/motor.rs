//! Gradients of motors with a torque limit.

use super::*;

/// The torque of a motor at 0.98 of its limit, beyond which the differences of outputs would lead, by the start angle of an arm on it:
/// `−k θ − c θ̇` of the free vibration; 1e-7, the tolerance of the run.
#[test]
fn a_motor_near_its_limit_has_the_slope_of_its_spring() {
    let (stiffness, damping, start, time_s) = (3.0, 0.2, 0.5, 0.02);
    let plant = |start_angle: f64| -> Result<Plant, String> {
        // differences by 1 rad/s lead past the limit
        let (stiffness_n_m_rad, damping_n_m_s_rad) = (stiffness, damping);
        let torque_limit_n_m = 1.02 * stiffness * start;
        let motor = Motor { stiffness_n_m_rad, damping_n_m_s_rad, torque_limit_n_m, ..Motor::default() };
        let mass =
            AttachedMass { inertia_kg_m2: nalgebra::Matrix3::identity(), ..AttachedMass::point("mass", 0.0, 1.0) };
        let hinge = Joint::revolute("hinge", [0.0, 0.0, 1.0]).motor(motor).start_angle_rad(start_angle);
        let machine: Machine = Machine::builder("Arm")
            .gravity_m_s2([0.0; 3])
            .body(Body::rigid("arm"), hinge)
            .mass("arm", mass)
            .solver(Solver { tolerance: 1e-10, ..Solver::default() })
            .build()
            .map_err(|refused| refused.to_string())?;
        Ok(Plant::new(Arc::new(machine)))
    };
    let mut own = plant(start).unwrap();
    own.initialize(0.0).unwrap();
    let tape = own.run_on_tape(&[time_s]).unwrap();
    let offset = std::mem::offset_of!(crate::system::JointOutputs, motor_torque_n_m);
    let result = RunResult::Output { index: own.outputs().layout().joints.place(0, offset), time: 0 };
    let parameter = Parameter::new("start", start, 1e-4, plant).unwrap();
    let mut gradient = Gradient::new(&mut own, &tape, vec![parameter]).unwrap();
    // of a moment of inertia of 1 kg m²
    let (decay, rate) = (0.5 * damping, (stiffness - 0.25 * damping * damping).sqrt());
    let (sin, cos) = (rate * time_s).sin_cos();
    let envelope = (-decay * time_s).exp();
    let (angle, speed) = (envelope * (cos + decay / rate * sin), -envelope * stiffness / rate * sin);
    let known = -stiffness * angle - damping * speed;
    for found in [gradient.forward(&[result]).unwrap()[0][0], gradient.adjoint(result).unwrap()[0]] {
        assert!((found - known).abs() < 1e-7 * known.abs(), "{found} and {known}");
    }
}

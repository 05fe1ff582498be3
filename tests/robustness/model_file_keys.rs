//! Errors in single keys: syntax, names, types, ranges.

use crate::model_file::message;

/// A text that is not TOML is rejected with the parser's message and the line; one problem at a time.
#[test]
fn syntax_errors() {
    assert_eq!(
        message("elements = 2\nload", "elements = = 2\nload"),
        "wing.toml:18: not valid TOML: extra `=`, expected nothing"
    );
    assert_eq!(
        message("width_m = 0.05", "width_m = 0.05 0.06"),
        "wing.toml:5: not valid TOML: string values must be quoted, expected literal string"
    );
    assert_eq!(
        message("[section.spar]", "[section.plate]"),
        "wing.toml:10: not valid TOML: duplicate key: [section.plate], already on line 3"
    );
    assert_eq!(
        message("shape = \"rectangle\"", "shape = \"rectangle"),
        "wing.toml:4: not valid TOML: invalid basic string, expected `\"`"
    );
}

/// For an unknown key the message suggests the intended one. A key without its unit used to be two problems: unknown and missing.
#[test]
fn unknown_keys() {
    assert_eq!(
        message("length_m = 0.15", "length = 0.15"),
        "wing.toml:16: key 'body.inner.length' is unknown; write length_m (m); allowed keys: count, length_m, section, \
         outer_section, width_taper, height_taper, shear, element, elements, natural_curvature_1_m, twist_1_m, \
         curvature_y_1_m, curvature_z_1_m, axis, axis_file, mass_damping_1_s, damp_attached_masses, stiffness_damping_s, stiffness_damping_factors, shear_damping_factors, modal_damping_ratios, load_stations, \
         load_station_positions_m, load_frame"
    );
    assert_eq!(
        message("length_m = 0.15", "length_mm = 150"),
        "wing.toml:16: key 'body.inner.length_mm' is unknown; write length_m (m); allowed keys: count, length_m, \
         section, outer_section, width_taper, height_taper, shear, element, elements, natural_curvature_1_m, twist_1_m, \
         curvature_y_1_m, curvature_z_1_m, axis, axis_file, mass_damping_1_s, damp_attached_masses, stiffness_damping_s, stiffness_damping_factors, shear_damping_factors, modal_damping_ratios, load_stations, \
         load_station_positions_m, load_frame"
    );
    assert_eq!(
        message("elements = 2\nload", "lenght_m = 1\nelements = 2\nload"),
        "wing.toml:18: key 'body.inner.lenght_m' is unknown; perhaps length_m is meant; allowed keys: count, length_m, \
         section, outer_section, width_taper, height_taper, shear, element, elements, natural_curvature_1_m, twist_1_m, \
         curvature_y_1_m, curvature_z_1_m, axis, axis_file, mass_damping_1_s, damp_attached_masses, stiffness_damping_s, stiffness_damping_factors, shear_damping_factors, modal_damping_ratios, load_stations, \
         load_station_positions_m, load_frame"
    );
    assert_eq!(
        message("[solver]", "[solver]\ncolour = \"red\""),
        "wing.toml:48: key 'solver.colour' is unknown; allowed keys: method, tolerance, max_step_s, min_step_s, \
         fixed_step_s, rho_infinity, mode, max_iterations"
    );
    assert_eq!(
        message("[solver]", "[solvers]"),
        "wing.toml:47: key 'solvers' is unknown; perhaps solver is meant; allowed keys: name, description, \
         gravity_m_s2, material, section, body, rigid_body, modal_body, joint, loop, skate, wheel, mass, load, gauge, internal_load, failure, aerodynamics, surface, control_surface, gust, polar, wind, tower, solver, simulation"
    );
    assert_eq!(
        message("stiffness_N_m_rad", "stiffness"),
        "wing.toml:35: key 'joint.fold.motor.stiffness' is unknown; write stiffness_N_m_rad (N·m/rad); allowed \
         keys: stiffness_N_m_rad, damping_N_m_s_rad, constant_torque_N_m, torque_limit_N_m, rate_limit_deg_s, \
         inertia_kg_m2, gear_ratio, command_deg, stiffness_N_m, damping_N_s_m, constant_force_N, force_limit_N, rate_limit_m_s, \
         mass_kg, command_m"
    );
}

/// A missing key is reported at the line of its table.
#[test]
fn missing_keys() {
    assert_eq!(
        message("length_m = 0.15\n", ""),
        "wing.toml:15: key 'body.inner.length_m' is missing; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message("name = \"Wing\"\n", ""),
        "wing.toml:1: key 'name' is missing; allowed: an identifier: letters, digits and _, no digit first"
    );
    assert_eq!(
        message("shape = \"rectangle\"\n", ""),
        "wing.toml:3: key 'section.plate.shape' is missing; allowed: \
         \"rectangle\" or \"ellipse\" or \"tube\" or \"box\" or \"I\" or \"C\" or \"angle\" or \"profile\" or \"laminate\" or \"explicit\" or \"table\""
    );
    assert_eq!(
        message("axis = [0, 2, 0]\n", ""),
        "wing.toml:28: key 'joint.fold.axis' is missing; allowed: an array of 3 finite numbers, not all 0"
    );
    assert_eq!(
        message("mass_kg = 0.02\n", ""),
        "wing.toml:38: key 'mass.actuator.mass_kg' is missing; allowed: a finite mass > 0 kg"
    );
}

/// Values of the wrong type.
#[test]
fn wrong_types() {
    assert_eq!(
        message("0.15", "\"0.15\""),
        "wing.toml:16: key 'body.inner.length_m': \"0.15\" is not allowed; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message("elements = 2", "elements = 2.5"),
        "wing.toml:18: key 'body.inner.elements': 2.5 is not allowed; allowed: a whole number from 1 to 1000"
    );
    assert_eq!(
        message("elements = 2", "elements = 99999999999999999999"),
        "wing.toml:18: key 'body.inner.elements': 99999999999999999999 is not allowed; allowed: a whole number \
         from 1 to 1000"
    );
    assert_eq!(
        message("[0.0, 0.0, -9.81]", "-9.81"),
        "wing.toml:2: key 'gravity_m_s2': -9.81 is not allowed; allowed: an array of 3 finite accelerations in \
         m/s²"
    );
    assert_eq!(
        message("[0.0, 0.0, -9.81]", "[0.0, -9.81]"),
        "wing.toml:2: key 'gravity_m_s2': [0.0, -9.81] is not allowed; allowed: an array of 3 finite \
         accelerations in m/s²"
    );
    assert_eq!(
        message("[0.0, 0.0, -9.81]", "[0.0,\n\"x\",\n0.0]"),
        "wing.toml:3: key 'gravity_m_s2': [0.0, \"x\", 0.0] is not allowed; allowed: an array of 3 finite \
         accelerations in m/s²"
    );
    assert_eq!(
        message("name = \"Wing\"", "name = 5"),
        "wing.toml:1: key 'name': 5 is not allowed; allowed: an identifier: letters, digits and _, no digit first"
    );
    assert_eq!(
        message("[body.inner]", "[[body.inner]]"),
        "wing.toml:15: key 'body.inner': an array of tables is not allowed; allowed: a table"
    );
    assert_eq!(
        message("[joint.fold.motor]\nstiffness_N_m_rad = 0.026", "motor = 5"),
        "wing.toml:34: key 'joint.fold.motor': 5 is not allowed; allowed: a table"
    );
    assert_eq!(
        message("start_angle_deg = 170", "release = \"yes\""),
        "wing.toml:33: key 'joint.fold.release': \"yes\" is not allowed; allowed: true or false"
    );
    assert_eq!(
        message("start_angle_deg = 170", "start_angle_deg = 1979-05-27"),
        "wing.toml:33: key 'joint.fold.start_angle_deg': 1979-05-27 is not allowed; allowed: a finite angle from \
         -360 to 360 deg"
    );
}

/// Words that are not among the allowed values.
#[test]
fn choices() {
    assert_eq!(
        message("\"rectangle\"", "\"rectangel\""),
        "wing.toml:4: key 'section.plate.shape': \"rectangel\" is not allowed; allowed: \
         \"rectangle\" or \"ellipse\" or \"tube\" or \"box\" or \"I\" or \"C\" or \"angle\" or \"profile\" or \"laminate\" or \"explicit\" or \"table\" (did you mean \"rectangle\"?)"
    );
    assert_eq!(
        message("\"clamped\"", "\"welded\""),
        "wing.toml:25: key 'joint.mount.type': \"welded\" is not allowed; allowed: \"clamped\" or \"revolute\" or \
         \"prismatic\" or \"sliding\" or \"universal\" or \"ball\" or \"free\" or \"cylindrical\""
    );
    assert_eq!(
        message("[solver]", "[solver]\nmethod = \"euler\""),
        "wing.toml:48: key 'solver.method': \"euler\" is not allowed; allowed: \"generalized_alpha\" or \
         \"tr_bdf2\" or \"sdirk2\" or \"esdirk3\" or \"esdirk4\" or \"rk4\""
    );
    assert_eq!(
        message("load_stations = 4", "element = \"quadratic\""),
        "wing.toml:19: key 'body.inner.element': \"quadratic\" is not allowed; allowed: \"linear\" or \
         \"constant\""
    );
    assert_eq!(
        message("load_stations = 4", "load_frame = \"body\""),
        "wing.toml:19: key 'body.inner.load_frame': \"body\" is not allowed; allowed: \"root\" or \"section\""
    );
    assert_eq!(
        message("start_angle_deg = 170", "motion = \"fixed\""),
        "wing.toml:33: key 'joint.fold.motion': \"fixed\" is not allowed; allowed: \"free\" or \"locked\" or \
         \"prescribed\""
    );
}

/// Numbers outside the range of their key.
#[test]
fn negative_and_zero() {
    assert_eq!(
        message("length_m = 0.15", "length_m = -0.15"),
        "wing.toml:16: key 'body.inner.length_m': -0.15 is not allowed; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message("length_m = 0.15", "length_m = 0"),
        "wing.toml:16: key 'body.inner.length_m': 0 is not allowed; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message("mass_kg = 0.02", "mass_kg = 0"),
        "wing.toml:41: key 'mass.actuator.mass_kg': 0 is not allowed; allowed: a finite mass > 0 kg"
    );
    assert_eq!(
        message("youngs_modulus_Pa = 2.83e9", "youngs_modulus_Pa = -1"),
        "wing.toml:8: key 'section.plate.youngs_modulus_Pa': -1 is not allowed; allowed: a finite modulus > 0 Pa"
    );
    assert_eq!(
        message("stiffness_N_m_rad = 0.026", "stiffness_N_m_rad = -0.1"),
        "wing.toml:35: key 'joint.fold.motor.stiffness_N_m_rad': -0.1 is not allowed; allowed: a finite stiffness \
         >= 0 N·m/rad"
    );
    assert_eq!(
        message("poisson_ratio = 0.3", "poisson_ratio = 0.6"),
        "wing.toml:9: key 'section.plate.poisson_ratio': 0.6 is not allowed; allowed: a finite number > -1 and <= \
         0.5"
    );
    assert_eq!(
        message("mass_kg_m = 0.3", "mass_kg_m = 0"),
        "wing.toml:13: key 'section.spar.mass_kg_m': 0 is not allowed; allowed: a finite mass per length > 0 kg/m"
    );
    assert_eq!(
        message("load_stations = 4", "mass_damping_1_s = -1"),
        "wing.toml:19: key 'body.inner.mass_damping_1_s': -1 is not allowed; allowed: a finite damping >= 0 (1/s)"
    );
}

/// NaN, infinity and values that would overflow.
#[test]
fn not_finite() {
    assert_eq!(
        message("length_m = 0.15", "length_m = nan"),
        "wing.toml:16: key 'body.inner.length_m': nan is not allowed; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message("length_m = 0.15", "length_m = inf"),
        "wing.toml:16: key 'body.inner.length_m': inf is not allowed; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message("length_m = 0.15", "length_m = 1e999"),
        "wing.toml:16: key 'body.inner.length_m': 1e999 is not allowed; allowed: a finite length > 0 m"
    );
    assert_eq!(
        message("length_m = 0.15", "length_m = 1e31"),
        "wing.toml:16: key 'body.inner.length_m': 1e31 is not allowed; allowed: a finite length > 0 m, at most \
         1e30 in magnitude"
    );
    assert_eq!(
        message("-9.81", "-inf"),
        "wing.toml:2: key 'gravity_m_s2': [0.0, 0.0, -inf] is not allowed; allowed: an array of 3 finite \
         accelerations in m/s²"
    );
}

/// Names that are not identifiers.
#[test]
fn names() {
    assert_eq!(
        message("name = \"Wing\"", "name = \"my wing\""),
        "wing.toml:1: key 'name': \"my wing\" is not allowed; allowed: an identifier: letters, digits and _, no \
         digit first; perhaps \"my_wing\""
    );
    assert_eq!(
        message("[body.outer]", "[body.\"the outer\"]"),
        "wing.toml:20: key 'body.\"the outer\"': the name \"the outer\" is not allowed; allowed: an identifier: \
         letters, digits and _, no digit first; perhaps \"the_outer\""
    );
    assert_eq!(
        message("[gauge.root]", "[gauge.1st]"),
        "wing.toml:43: key 'gauge.1st': the name \"1st\" is not allowed; allowed: an identifier: letters, digits \
         and _, no digit first; perhaps \"_1st\""
    );
    assert!(!message("name = \"Wing\"", "name = \"翼\"").contains("perhaps"), "nothing is left of it");
    assert_eq!(
        message("[body.outer]", "[body.root]"),
        "wing.toml:20: key 'body.root': the name \"root\" is not allowed; allowed: another name: \"root\" is reserved \
         for the frame that carries the wing\nwing.toml:31: key 'joint.fold.child': \"outer\" is not allowed; allowed: a body: \
         \"inner\" or \"root\""
    );
}

/// Directions given by the name of an axis.
#[test]
fn axes_by_name() {
    for (word, meant) in [("y", "[0.0, 1.0, 0.0]"), ("-Z", "[0.0, 0.0, -1.0]")] {
        let told = message("axis = [0, 2, 0]", &format!("axis = {word:?}"));
        assert!(told.ends_with(&format!("an array of 3 finite numbers; perhaps {meant}")), "{told}");
    }
    assert!(!message("axis = [0, 2, 0]", "axis = \"up\"").contains("perhaps"));
}

/// A model without bodies.
#[test]
fn no_bodies() {
    assert_eq!(
        message(
            "[body.inner]\nlength_m = 0.15\nsection = \"plate\"\nelements = 2\nload_stations = \
                     4\n[body.outer]\nlength_m = 0.1\nsection = \"spar\"\nelements = 2\n",
            "[body]\n"
        ),
        "wing.toml:15: key 'body': an empty table is not allowed; allowed: at least one table [body.<name>]"
    );
}

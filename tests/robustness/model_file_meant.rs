//! Suggestions for a misspelt or misplaced word: whole messages.

use crate::model_file::message;

const TOP: &str = "name, description, gravity_m_s2, material, section, body, rigid_body, modal_body, joint, loop, skate, wheel, mass, load, gauge, internal_load, \
                   failure, aerodynamics, surface, control_surface, gust, polar, wind, tower, solver, simulation";
const BODY: &str = "count, length_m, section, outer_section, width_taper, height_taper, shear, element, elements, \
                    natural_curvature_1_m, twist_1_m, curvature_y_1_m, curvature_z_1_m, axis, axis_file, mass_damping_1_s, \
                    damp_attached_masses, stiffness_damping_s, stiffness_damping_factors, shear_damping_factors, modal_damping_ratios, load_stations, load_station_positions_m, load_frame";

/// Tables: swapped letters, plurals, truncated names.
#[test]
fn tables() {
    for (written, meant) in [("[gague.root]", "gauge"), ("[gauges.root]", "gauge"), ("[gage.root]", "gauge")] {
        let key = written.trim_matches(['[', ']']).split('.').next().unwrap();
        let unknown = format!("wing.toml:43: key '{key}' is unknown; perhaps {meant} is meant; allowed keys: {TOP}");
        assert_eq!(message("[gauge.root]", written), unknown);
    }
    assert_eq!(
        message("[solver]", "[aero]\nmodel = \"strip\"\n[solver]"),
        format!("wing.toml:47: key 'aero' is unknown; perhaps aerodynamics is meant; allowed keys: {TOP}")
    );
}

/// A misspelt required table is reported as one error, not two.
#[test]
fn required_tables() {
    assert_eq!(
        message("[joint.mount]", "[joints.mount]").lines().next().unwrap(),
        format!("wing.toml:24: key 'joints' is unknown; perhaps joint is meant; allowed keys: {TOP}")
    );
    let bodies = message("[body.inner]", "[bodies.inner]");
    assert_eq!(bodies, format!("wing.toml:15: key 'bodies' is unknown; perhaps body is meant; allowed keys: {TOP}"));
}

/// Keys of another table: the message names it.
#[test]
fn misplaced_keys() {
    assert_eq!(
        message("[joint.fold.motor]\n", ""),
        "wing.toml:34: key 'joint.fold.stiffness_N_m_rad' is unknown; it belongs to [joint.<name>.motor] or \
         [joint.<name>.spring] or [joint.<name>.latch] or [joint.<name>.end_stops]; allowed keys: type, parent, child, parent_position_m, parent_frame, parent_offset_m, root_position_m, \
         mount_rotation_deg, axis, body_axis, start_angular_velocity_deg_s, start_velocity_m_s, start_angle_deg, \
         start_rate_deg_s, attitude, start_position_m, start_rate_m_s, release, motion, polynomial_deg, table_s_deg, \
         polynomial_m, table_s_m, table_ends, motor, spring, generator, dc_motor, latch, end_stops, rotation, translation"
    );
    assert_eq!(
        message("load_stations = 4", "gravity_m_s2 = [0, 0, 0]"),
        format!(
            "wing.toml:19: key 'body.inner.gravity_m_s2' is unknown; it belongs to the top of the file, before the first \
             table; allowed keys: {BODY}"
        )
    );
    assert_eq!(
        message("mass_kg_m = 0.3", "mass_kg_m = 0.3\ndensity_kg_m3 = 1600").split("; allowed keys").next().unwrap(),
        "wing.toml:14: key 'section.spar.density_kg_m3' is unknown; it belongs to [material.<name>] or [section.<name>] with shape = \
         \"rectangle\" or [section.<name>] with shape = \"ellipse\" or [aerodynamics]"
    );
    assert_eq!(
        message("[joint.fold.latch]", "[latch]"),
        format!("wing.toml:36: key 'latch' is unknown; it belongs to [joint.<name>]; allowed keys: {TOP}")
    );
}

/// The key that selects the shape of a section, misspelt.
#[test]
fn a_misspelt_shape() {
    assert_eq!(
        message("shape = \"rectangle\"", "shpae = \"rectangle\""),
        "wing.toml:3: key 'section.plate.shape' is missing; allowed: \
         \"rectangle\" or \"ellipse\" or \"tube\" or \"box\" or \"I\" or \"C\" or \"angle\" or \"profile\" or \"laminate\" or \"explicit\" or \"table\"; \
         perhaps shpae is shape misspelt"
    );
}

/// Words close to an allowed value, in every key with a set of allowed values.
#[test]
fn choices() {
    for (old, new, said) in [
        (
            "\"clamped\"",
            "\"clamp\"",
            "wing.toml:25: key 'joint.mount.type': \"clamp\" is not allowed; allowed: \"clamped\" or \"revolute\" or \
             \"prismatic\" or \"sliding\" or \"universal\" or \"ball\" or \"free\" or \"cylindrical\" (did you mean \"clamped\"?)",
        ),
        (
            "\"revolute\"",
            "\"Revolut\"",
            "wing.toml:29: key 'joint.fold.type': \"Revolut\" is not allowed; allowed: \"clamped\" or \"revolute\" or \
             \"prismatic\" or \"sliding\" or \"universal\" or \"ball\" or \"free\" or \"cylindrical\" (did you mean \"revolute\"?)",
        ),
        (
            "\"explicit\"",
            "\"explict\"",
            "wing.toml:11: key 'section.spar.shape': \"explict\" is not allowed; allowed: \
         \"rectangle\" or \"ellipse\" or \"tube\" or \"box\" or \"I\" or \"C\" or \"angle\" or \"profile\" or \"laminate\" or \"explicit\" or \"table\" (did you mean \"explicit\"?)",
        ),
        (
            "load_stations = 4",
            "element = \"Linear\"",
            "wing.toml:19: key 'body.inner.element': \"Linear\" is not allowed; allowed: \"linear\" or \"constant\" \
             (did you mean \"linear\"?)",
        ),
        (
            "start_angle_deg = 170",
            "motion = \"lock\"",
            "wing.toml:33: key 'joint.fold.motion': \"lock\" is not allowed; allowed: \"free\" or \"locked\" or \
             \"prescribed\" (did you mean \"locked\"?)",
        ),
        (
            "[solver]",
            "[solver]\nmethod = \"esdirk_4\"",
            "wing.toml:48: key 'solver.method': \"esdirk_4\" is not allowed; allowed: \"generalized_alpha\" or \
             \"tr_bdf2\" or \"sdirk2\" or \"esdirk3\" or \"esdirk4\" or \"rk4\" (did you mean \"esdirk4\"?)",
        ),
        (
            "[solver]",
            "[aerodynamics]\nmodel = \"strips\"\n[solver]",
            "wing.toml:48: key 'aerodynamics.model': \"strips\" is not allowed; allowed: \"uvlm\" or \"strip\" or \"bem\" or \
             \"none\" (did you mean \"strip\"?)",
        ),
    ] {
        assert_eq!(message(old, new), said);
    }
}

/// References close to an existing name, in every kind of table that refers to another.
#[test]
fn references() {
    for (old, new, said) in [
        (
            "parent = \"root\"",
            "parent = \"Root\"",
            "wing.toml:26: key 'joint.mount.parent': \"Root\" is not allowed; allowed: the root or a body: \"root\" or \
             \"inner\" or \"outer\" (did you mean \"root\"?)",
        ),
        (
            "child = \"outer\"",
            "child = \"ouetr\"",
            "wing.toml:31: key 'joint.fold.child': \"ouetr\" is not allowed; allowed: a body: \"inner\" or \"outer\" \
             (did you mean \"outer\"?)",
        ),
        (
            "body = \"inner\"\nposition_m = 0.02",
            "body = \"inne\"\nposition_m = 0.02",
            "wing.toml:44: key 'gauge.root.body': \"inne\" is not allowed; allowed: a body: \"inner\" or \"outer\" \
             (did you mean \"inner\"?)",
        ),
        (
            "[solver]",
            "[load.tip]\nbody = \"outter\"\nstation = 1\n[solver]",
            "wing.toml:48: key 'load.tip.body': \"outter\" is not allowed; allowed: a body: \"inner\" or \"outer\" \
             (did you mean \"outer\"?)",
        ),
        (
            "load_stations = 4",
            "outer_section = \"spra\"",
            "wing.toml:19: key 'body.inner.outer_section': \"spra\" is not allowed; allowed: a section: \"plate\" or \
             \"spar\" (did you mean \"spar\"?)",
        ),
        (
            "[solver]",
            "[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0, -9, 0]\nstep_s = 1e-3\n[surface.inner]\nbody = \
             \"iner\"\nstrips = 3\n[solver]",
            "wing.toml:52: key 'surface.inner.body': \"iner\" is not allowed; allowed: a body: \"inner\" or \"outer\" \
             (did you mean \"inner\"?)",
        ),
        (
            "[solver]",
            "[loop.pin]\nbodies = [\"inner\", \"outr\"]\nstiffness_N_m = 1e6\n[solver]",
            "wing.toml:48: key 'loop.pin.bodies': [\"inner\", \"outr\"] is not allowed; allowed: names of bodies: \
             \"inner\" or \"outer\" (did you mean \"outer\"?)",
        ),
    ] {
        assert_eq!(message(old, new), said);
    }
}

/// A joint's name in place of the body that it holds.
#[test]
fn a_joint_for_a_body() {
    assert_eq!(
        message("parent = \"inner\"", "parent = \"mount\""),
        "wing.toml:30: key 'joint.fold.parent': \"mount\" is not allowed; allowed: the root or a body, not a joint \
         (joint \"mount\" has the child \"inner\"): \"root\" or \"inner\" or \"outer\""
    );
}

//! Errors in combinations of keys.

use crate::model_file::{message, message_of, with};
use foldwing::config;

/// Dimensions that are valid by themselves, but whose products overflow.
#[test]
fn overflowing_dimensions() {
    assert_eq!(
        message("width_m = 0.05", "width_m = 1e25"),
        "wing.toml:3: key 'section.plate': a section of such dimensions is not allowed; allowed: dimensions and \
         material whose mass, inertia and stiffness are positive, finite numbers in SI"
    );
    assert_eq!(
        message("height_m = 0.002", "height_m = 1e-200"),
        "wing.toml:3: key 'section.plate': a section of such dimensions is not allowed; allowed: dimensions and \
         material whose mass, inertia and stiffness are positive, finite numbers in SI"
    );
}

/// Joint names that clash with groups of the FMU's variables.
#[test]
fn joint_names_that_clash() {
    assert_eq!(
        message("[joint.mount]", "[joint.load]"),
        "wing.toml:24: key 'joint.load': the name \"load\" is not allowed; allowed: a name that is not one of \
         load, gravity, root, wind, gauge, internal_load, loop, tip, station, aero, energy, \
         failure, solver, body, time, der"
    );
}

/// Positions of internal loads: on a body with sections, with a body on the requested side.
#[test]
fn internal_loads() {
    let cut = |table: &str| message_of(&format!("{}\n[internal_load.cut]\n{table}\n", with("", "")));
    assert_eq!(
        cut("body = \"outer\"\nposition_m = 0.1\nside = \"outboard\""),
        "wing.toml:60: key 'internal_load.cut.side': \"outboard\" is not allowed; allowed: \"inboard\" at the outer end of the body: there is no part outboard of it"
    );
    let stone = "[rigid_body.stone]\nmass_kg = 1.0\ninertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]\n\
                 [joint.held]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"stone\"\n";
    assert_eq!(
        message_of(&format!("{}\n{stone}[internal_load.cut]\nbody = \"stone\"\nposition_m = 0.0\n", with("", ""))),
        "wing.toml:65: key 'internal_load.cut.body': \"stone\" is not allowed; allowed: a flexible body; this one is rigid and has no sections: the force and moment of its joint are outputs"
    );
}

/// The tree of bodies: one joint per body, no body attached to itself, no cycle.
#[test]
fn tree() {
    assert_eq!(
        message("parent = \"inner\"\nchild = \"outer\"", "parent = \"root\"\nchild = \"inner\""),
        "wing.toml:31: key 'joint.fold.child': \"inner\" is not allowed; allowed: a body that is not yet the child of \
         another joint; this one is the child of \"mount\""
    );
    assert_eq!(
        message("child = \"outer\"", "child = \"inner\""),
        "wing.toml:31: key 'joint.fold.child': \"inner\" is not allowed; allowed: a body other than the parent"
    );
    assert_eq!(
        message("parent = \"inner\"", "parent = \"outer\""),
        "wing.toml:31: key 'joint.fold.child': \"outer\" is not allowed; allowed: a body other than the parent"
    );
    assert_eq!(
        message("parent = \"root\"", "parent = \"outer\""),
        "wing.toml:26: key 'joint.mount.parent': \"outer\" is not allowed; allowed: a chain of parents that ends at \
         the root; here the parents form a cycle: inner -> outer -> inner"
    );
    assert_eq!(
        message("[solver]", "[body.winglet]\nlength_m = 1\nsection = \"plate\"\nelements = 1\n[solver]"),
        "wing.toml:47: key 'body.winglet': a body without a joint is not allowed; allowed: exactly one joint with \
         child = \"winglet\""
    );
}

/// References to names that do not exist.
#[test]
fn references() {
    assert_eq!(
        message("parent = \"inner\"", "parent = \"iner\""),
        "wing.toml:30: key 'joint.fold.parent': \"iner\" is not allowed; allowed: the root or a body: \"root\" or \
         \"inner\" or \"outer\" (did you mean \"inner\"?)"
    );
    assert_eq!(
        message("child = \"outer\"", "child = \"wing\""),
        "wing.toml:31: key 'joint.fold.child': \"wing\" is not allowed; allowed: a body: \"inner\" or \"outer\""
    );
    assert_eq!(
        message("section = \"plate\"", "section = \"plat\""),
        "wing.toml:17: key 'body.inner.section': \"plat\" is not allowed; allowed: a section: \"plate\" or \
         \"spar\" (did you mean \"plate\"?)"
    );
    assert_eq!(
        message("body = \"inner\"\nposition_m = 0.15", "body = \"innner\"\nposition_m = 0.15"),
        "wing.toml:39: key 'mass.actuator.body': \"innner\" is not allowed; allowed: a body: \"inner\" or \
         \"outer\" (did you mean \"inner\"?)"
    );
    assert_eq!(
        message("body = \"inner\"\nposition_m = 0.02", "body = \"x\"\nposition_m = 0.02"),
        "wing.toml:44: key 'gauge.root.body': \"x\" is not allowed; allowed: a body: \"inner\" or \"outer\""
    );
}

/// Positions beyond the body, points outside the section.
#[test]
fn positions() {
    assert_eq!(
        message("position_m = 0.02", "position_m = 0.2"),
        "wing.toml:45: key 'gauge.root.position_m': 0.2 is not allowed; allowed: a length from 0 to 0.15 m, the \
         length of the body"
    );
    assert_eq!(
        message("position_m = 0.15", "position_m = 0.1501"),
        "wing.toml:40: key 'mass.actuator.position_m': 0.1501 is not allowed; allowed: a length from 0 to 0.15 m, \
         the length of the body"
    );
    assert_eq!(
        message("position_m = 0.15", "position_m = -0.1"),
        "wing.toml:40: key 'mass.actuator.position_m': -0.1 is not allowed; allowed: a finite length >= 0 m"
    );
    assert_eq!(
        message("z_m = 0.001", "z_m = 0.01"),
        "wing.toml:46: key 'gauge.root.z_m': 0.01 is not allowed; allowed: a point on the section: |y| <= 0.025 \
         m, |z| <= 0.001 m"
    );
    assert_eq!(
        message("z_m = 0.001", "y_m = -0.03"),
        "wing.toml:46: key 'gauge.root.y_m': -0.03 is not allowed; allowed: a point on the section: |y| <= 0.025 \
         m, |z| <= 0.001 m"
    );
    assert_eq!(
        message("start_angle_deg = 170", "parent_position_m = 0.2"),
        "wing.toml:33: key 'joint.fold.parent_position_m': 0.2 is not allowed; allowed: a length from 0 to 0.15 \
         m, the length of the body"
    );
}

/// A gauge needs an outline, and an ellipse has no corners.
#[test]
fn gauge_outlines() {
    assert_eq!(
        message("body = \"inner\"\nposition_m = 0.02", "body = \"outer\"\nposition_m = 0.02"),
        "wing.toml:44: key 'gauge.root.body': \"outer\" is not allowed; allowed: a body whose section has half_width_m \
         and half_height_m"
    );
    assert_eq!(
        message_of(&with("shape = \"rectangle\"", "shape = \"ellipse\"").replacen(
            "z_m = 0.001",
            "y_m = 0.02\nz_m = 0.0009",
            1
        )),
        "wing.toml:46: key 'gauge.root.y_m': 0.02 is not allowed; allowed: a point on the section: (y/0.025)² + \
         (z/0.001)² <= 1, in m"
    );
}

/// Load stations.
#[test]
fn stations() {
    assert_eq!(
        message("load_stations = 4", "load_stations = -1"),
        "wing.toml:19: key 'body.inner.load_stations': -1 is not allowed; allowed: a whole number from 0 to 1000"
    );
    assert_eq!(
        message("load_stations = 4", "load_station_positions_m = [0.1, 0.05]"),
        "wing.toml:19: key 'body.inner.load_station_positions_m': [0.1, 0.05] is not allowed; allowed: ascending \
         lengths from 0 to 0.15 m, the length of the body"
    );
    assert_eq!(
        message("load_stations = 4", "load_station_positions_m = [0.1, 0.2]"),
        "wing.toml:19: key 'body.inner.load_station_positions_m': [0.1, 0.2] is not allowed; allowed: ascending \
         lengths from 0 to 0.15 m, the length of the body"
    );
    assert_eq!(
        message("load_stations = 4", "load_stations = 4\nload_station_positions_m = [0.1]"),
        "wing.toml:20: key 'body.inner.load_station_positions_m': [0.1] is not allowed; allowed: either \
         load_stations or load_station_positions_m, not both"
    );
}

/// Meshes.
#[test]
fn elements() {
    assert_eq!(
        message("elements = 2", "elements = 0"),
        "wing.toml:18: key 'body.inner.elements': 0 is not allowed; allowed: a whole number from 1 to 1000"
    );
    assert_eq!(
        message("elements = 2", "elements = 1001"),
        "wing.toml:18: key 'body.inner.elements': 1001 is not allowed; allowed: a whole number from 1 to 1000"
    );
    assert_eq!(
        message("load_stations = 4", "natural_curvature_1_m = [0, 50, 0]"),
        "wing.toml:19: key 'body.inner.natural_curvature_1_m': [0, 50, 0] is not allowed; allowed: curvatures of a \
         magnitude < 41.8879 1/m, which is half a revolution per element"
    );
}

/// Hinge axes.
#[test]
fn axes() {
    assert_eq!(
        message("axis = [0, 2, 0]", "axis = [0, 0.0, -0.0]"),
        "wing.toml:32: key 'joint.fold.axis': [0, 0.0, -0.0] is not allowed; allowed: an array of 3 finite \
         numbers, not all 0"
    );
    assert_eq!(
        message("type = \"clamped\"", "type = \"clamped\"\naxis = [0, 1, 0]"),
        "wing.toml:26: key 'joint.mount.axis': [0, 1, 0] is not allowed; allowed: this key only with type = \
         \"revolute\" or \"prismatic\" or \"universal\" or \"cylindrical\""
    );
}

/// Shear of bodies and sections.
#[test]
fn shear() {
    assert_eq!(
        message("section = \"spar\"", "section = \"spar\"\nshear = true"),
        "wing.toml:23: key 'body.outer.shear': true with section \"spar\" is not allowed; allowed: sections with a shear stiffness: \
         solid ones and shapes whose shear modulus is known, shear_stiffness_N, stiffness_with_shear_SI, tables with \
         shear_stiffness_y_N and shear_stiffness_z_N, files with 6×6 matrices"
    );
    assert_eq!(
        message("section = \"spar\"", "section = \"spar\"\nshear_damping_factors = [1, 2]"),
        "wing.toml:23: key 'body.outer.shear_damping_factors': [1, 2] is not allowed; allowed: this key only on a body \
         with shear = true"
    );
    assert_eq!(
        message("mass_kg_m = 0.3", "mass_kg_m = 0.3\nshear_stiffness_N = [1, -1]"),
        "wing.toml:14: key 'section.spar.shear_stiffness_N': [1, -1] is not allowed; allowed: two finite stiffnesses > 0 N"
    );
    let full = "[[9, 0, 0, 0, 0, 0], [0, 8, 0, 0, 0, 0], [0, 0, 7, 0, 0, 0], [0, 0, 0, 3, 0, 0], [0, 0, 0, 0, 2, 0], [0, 0, 0, 0, 0, 1]]";
    assert_eq!(
        message("mass_kg_m = 0.3", &format!("mass_kg_m = 0.3\nstiffness_with_shear_SI = {full}")),
        "wing.toml:12: key 'section.spar.stiffness_SI': [[1e5, 0, 0, 0], [0, 2, 0.5, 0], [0, 0.5, 3, 0], [0, 0, 0, 9… is not \
         allowed; allowed: either stiffness_with_shear_SI or other stiffnesses, not both"
    );
    let own = "stiffness_SI = [[1e5, 0, 0, 0], [0, 2, 0.5, 0], [0, 0.5, 3, 0], [0, 0, 0, 9]]";
    let bent = full.replace("[0, 8, 0, 0, 0, 0]", "[0, 8, 0, 0, 1, 0]");
    assert_eq!(
        message(own, &format!("stiffness_with_shear_SI = {bent}")),
        "wing.toml:12: key 'section.spar.stiffness_with_shear_SI': 0 in row 5, column 2 and 1 in row 2, column 5 is not allowed; \
         allowed: a symmetric matrix"
    );
    assert_eq!(
        message(own, &format!("stiffness_with_shear_SI = {}", full.replace("8", "-8"))),
        "wing.toml:12: key 'section.spar.stiffness_with_shear_SI': a matrix that is not positive definite is not allowed; \
         allowed: a symmetric positive definite matrix"
    );
    let inner = with("section = \"plate\"", "section = \"plate\"\nshear = true");
    assert_eq!(
        message_of(&inner.replace("z_m = 0.001", "z_m = 0.001\ndirection = [0.6, 0.8, 0]")),
        "wing.toml:48: key 'gauge.root.direction': [0.6, 0.8, 0] is not allowed; allowed: the axis, [1, 0, 0], on a body with shear"
    );
    let file = with(own, &format!("stiffness_with_shear_SI = {full}"))
        .replace("section = \"spar\"", "section = \"spar\"\nshear = true");
    let machine = config::parse(&file, "wing.toml").unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(machine.bodies.iter().map(|body| body.has_shear()).collect::<Vec<_>>(), [false, true]);
}

/// Section stiffness.
#[test]
fn stiffness_matrices() {
    assert_eq!(
        message("[0, 0.5, 3, 0]", "[0, 0.6, 3, 0]"),
        "wing.toml:12: key 'section.spar.stiffness_SI': 0.6 in row 3, column 2 and 0.5 in row 2, column 3 is not \
         allowed; allowed: a symmetric matrix"
    );
    assert_eq!(
        message("[0, 2, 0.5, 0], [0, 0.5, 3, 0]", "[0, 2, 5, 0], [0, 5, 3, 0]"),
        "wing.toml:12: key 'section.spar.stiffness_SI': a matrix that is not positive definite is not allowed; \
         allowed: a symmetric positive definite matrix"
    );
    assert_eq!(
        message("[1e5, 0, 0, 0]", "[-1e5, 0, 0, 0]"),
        "wing.toml:12: key 'section.spar.stiffness_SI': a matrix that is not positive definite is not allowed; \
         allowed: a symmetric positive definite matrix"
    );
    assert_eq!(
        message("[[1e5, 0, 0, 0], ", "["),
        "wing.toml:12: key 'section.spar.stiffness_SI': [[0, 2, 0.5, 0], [0, 0.5, 3, 0], [0, 0, 0, 9]] is not \
         allowed; allowed: a 4 x 4 matrix of finite numbers in N, N·m and N·m²"
    );
    assert_eq!(
        message("[1e5, 0, 0, 0]", "[1e5, 0, 0]"),
        "wing.toml:12: key 'section.spar.stiffness_SI': [[1e5, 0, 0], [0, 2, 0.5, 0], [0, 0.5, 3, 0], [0, 0, 0, \
         9]] is not allowed; allowed: a 4 x 4 matrix of finite numbers in N, N·m and N·m²"
    );
    assert_eq!(
        message("mass_kg_m = 0.3", "mass_kg_m = 0.3\nflap_stiffness_N_m2 = 1"),
        "wing.toml:14: key 'section.spar.flap_stiffness_N_m2': 1 is not allowed; allowed: either stiffness_SI or \
         the stiffnesses one by one, not both"
    );
    assert_eq!(
        message(
            "stiffness_SI = [[1e5, 0, 0, 0], [0, 2, 0.5, 0], [0, 0.5, 3, 0], [0, 0, 0, 9]]",
            "axial_stiffness_N = 1e5\nedge_stiffness_N_m2 = 1"
        ),
        "wing.toml:10: key 'section.spar.torsional_rigidity_N_m2' is missing; allowed: a finite stiffness > 0, or \
         the whole matrix stiffness_SI instead\nwing.toml:10: key 'section.spar.flap_stiffness_N_m2' is missing; \
         allowed: a finite stiffness > 0, or the whole matrix stiffness_SI instead"
    );
    assert_eq!(
        message(
            "stiffness_SI = [[1e5, 0, 0, 0], [0, 2, 0.5, 0], [0, 0.5, 3, 0], [0, 0, 0, 9]]",
            "axial_stiffness_N = 1e5\nedge_stiffness_N_m2 = 1\nflap_stiffness_N_m2 = \
                     1\ntorsional_rigidity_N_m2 = 1\ncoupling_twist_flap_N_m2 = 1"
        ),
        "wing.toml:16: key 'section.spar.coupling_twist_flap_N_m2': 1 is not allowed; allowed: couplings that \
         leave the stiffness matrix positive definite"
    );
}

/// Inertia of explicit sections.
#[test]
fn section_inertia() {
    assert_eq!(
        message("[1e-4, 0, 1e-6]", "[1e-4, 1e-4, 1e-6]"),
        "wing.toml:14: key 'section.spar.second_moments_kg_m': [1e-4, 1e-4, 1e-6] is not allowed; allowed: [yy, \
         yz, zz] in kg·m with yy >= 0, zz >= 0, yy + zz > 0 and yz² <= yy zz"
    );
    assert_eq!(
        message("[1e-4, 0, 1e-6]", "[0, 0, 0]"),
        "wing.toml:14: key 'section.spar.second_moments_kg_m': [0, 0, 0] is not allowed; allowed: [yy, yz, zz] in \
         kg·m with yy >= 0, zz >= 0, yy + zz > 0 and yz² <= yy zz"
    );
    assert_eq!(
        message("mass_kg_m = 0.3", "mass_kg_m = 0.3\nhalf_width_m = 0.1"),
        "wing.toml:10: key 'section.spar.half_height_m' is missing; allowed: half_width_m and half_height_m \
         together, or neither"
    );
}

/// Inertia impossible for a rigid body.
#[test]
fn rigid_body_inertia() {
    assert_eq!(
        message("[1e-6, 1e-6, 1e-6, 0, 0, 0]", "[-1e-6, 1e-6, 1e-6, 0, 0, 0]"),
        "wing.toml:42: key 'mass.actuator.inertia_kg_m2': [-1e-6, 1e-6, 1e-6, 0, 0, 0] is not allowed; allowed: \
         [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] in kg·m² with principal moments >= 0, none larger than the sum of the \
         other two"
    );
    assert_eq!(
        message("[1e-6, 1e-6, 1e-6, 0, 0, 0]", "[1e-6, 1e-6, 3e-6, 0, 0, 0]"),
        "wing.toml:42: key 'mass.actuator.inertia_kg_m2': [1e-6, 1e-6, 3e-6, 0, 0, 0] is not allowed; allowed: \
         [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] in kg·m² with principal moments >= 0, none larger than the sum of the \
         other two"
    );
    assert_eq!(
        message("[1e-6, 1e-6, 1e-6, 0, 0, 0]", "[1e-6, 1e-6, 1e-6, 2e-6, 0, 0]"),
        "wing.toml:42: key 'mass.actuator.inertia_kg_m2': [1e-6, 1e-6, 1e-6, 2e-6, 0, 0] is not allowed; allowed: \
         [Ixx, Iyy, Izz, Ixy, Ixz, Iyz] in kg·m² with principal moments >= 0, none larger than the sum of the \
         other two"
    );
}

/// Latches.
#[test]
fn latches() {
    assert_eq!(
        message("stiffness_N_m_rad = 0.026", "stiffness_N_m_rad = 0"),
        "wing.toml:37: key 'joint.fold.latch.stiffness_ratio': 1e4 is not allowed; allowed: a ratio only with a motor \
         or a spring of stiffness > 0; write stiffness_N_m_rad (N·m/rad) instead"
    );
    assert_eq!(
        message("stiffness_ratio = 1e4", "stiffness_ratio = 1"),
        "wing.toml:37: key 'joint.fold.latch.stiffness_ratio': 1 is not allowed; allowed: a finite number > 1"
    );
    assert_eq!(
        message("stiffness_ratio = 1e4", "capture_deg = 1"),
        "wing.toml:36: key 'joint.fold.latch.stiffness_ratio' is missing; allowed: a finite number > 1, or \
         stiffness_N_m_rad instead, or kind = \"rigid\""
    );
    assert_eq!(
        message("stiffness_ratio = 1e4", "stiffness_ratio = 1e4\nstiffness_N_m_rad = 100"),
        "wing.toml:37: key 'joint.fold.latch.stiffness_ratio': 1e4 is not allowed; allowed: either \
         stiffness_ratio or stiffness_N_m_rad, not both"
    );
    let stops =
        |keys: &str| message("[joint.fold.latch]", &format!("[joint.fold.end_stops]\n{keys}\n[joint.fold.latch]"));
    assert_eq!(
        stops("stiffness_N_m_rad = 3"),
        "wing.toml:36: key 'joint.fold.end_stops': end stops without an end is not allowed; allowed: lower_deg or upper_deg, or both"
    );
    assert_eq!(
        stops("stiffness_N_m_rad = 3\nlower_deg = 20\nupper_deg = 10"),
        "wing.toml:39: key 'joint.fold.end_stops.upper_deg': 10 is not allowed; allowed: an angle above lower_deg"
    );
    assert_eq!(
        message("start_angle_deg = 170", "motion = \"locked\"\nend_stops = { upper_deg = 9, stiffness_N_m_rad = 3 }"),
        "wing.toml:34: key 'joint.fold.end_stops': end stops of a joint that does not move freely is not allowed; allowed: end stops \
         only with motion = \"free\"\nwing.toml:37: key 'joint.fold.latch': a latch on a joint that does not move freely is \
         not allowed; allowed: a latch only with motion = \"free\""
    );
    assert_eq!(
        message("start_angle_deg = 170", "motion = \"locked\""),
        "wing.toml:36: key 'joint.fold.latch': a latch on a joint that does not move freely is not allowed; \
         allowed: a latch only with motion = \"free\""
    );
    assert_eq!(
        message("stiffness_ratio = 1e4", "stiffness_ratio = 1e4\ninitially_closed = true\nenable = false"),
        "wing.toml:38: key 'joint.fold.latch.initially_closed': true is not allowed; allowed: true only with enable = \
         true: a latch that is not enabled is open"
    );
}

/// Rigid latches: no keys of a spring; closed at the start only within their window, and then without a start rate.
#[test]
fn rigid_latches() {
    for (key, value) in [("stiffness_ratio", "1e4"), ("stiffness_N_m_rad", "100.0")] {
        assert_eq!(
            message("stiffness_ratio = 1e4", &format!("kind = \"rigid\"\n{key} = {value}")),
            format!(
                "wing.toml:38: key 'joint.fold.latch.{key}': {value} is not allowed; allowed: this key only with kind = \
                 \"elastic\": a rigid latch has no spring"
            )
        );
    }
    assert_eq!(
        message("stiffness_ratio = 1e4", "kind = \"rigid\"\ninitially_closed = true"),
        "wing.toml:38: key 'joint.fold.latch.initially_closed': true is not allowed; allowed: true only with kind = \
         \"elastic\": a rigid latch is closed at the start if it is enabled and start_angle_deg lies within \
         capture_deg of angle_deg"
    );
    assert_eq!(
        message("stiffness_ratio = 1e4", "kind = \"stiff\""),
        "wing.toml:37: key 'joint.fold.latch.kind': \"stiff\" is not allowed; allowed: \"elastic\" or \"rigid\""
    );
    let turning = with("start_angle_deg = 170", "start_angle_deg = 170\nstart_rate_deg_s = 5");
    let caught = turning.replace("stiffness_ratio = 1e4", "kind = \"rigid\"\nangle_deg = 170");
    assert_eq!(
        message_of(&caught),
        "wing.toml:34: key 'joint.fold.start_rate_deg_s': 5 is not allowed; allowed: a rate of 0 deg/s if a rigid \
         latch is closed at the start; start outside its capture range, or write enable = false"
    );
    for accepted in ["enable = false", "capture_deg = 0"] {
        let angle = if accepted.starts_with("enable") { 170.0 } else { 170.000_001 };
        let text = caught.replace("\nangle_deg = 170\n", &format!("\nangle_deg = {angle}\n{accepted}\n"));
        assert!(config::parse(&text, "wing.toml").is_ok(), "{text}");
    }
}

/// Keys that exclude one another.
#[test]
fn alternatives() {
    assert_eq!(
        message("poisson_ratio = 0.3", "poisson_ratio = 0.3\nshear_modulus_Pa = 1e9"),
        "wing.toml:9: key 'section.plate.poisson_ratio': 0.3 is not allowed; allowed: either shear_modulus_Pa or \
         poisson_ratio, not both"
    );
    assert_eq!(
        message("poisson_ratio = 0.3\n", ""),
        "wing.toml:3: key 'section.plate.shear_modulus_Pa' is missing; allowed: a finite modulus > 0 Pa, or \
         poisson_ratio, or torsional_rigidity_N_m2 instead"
    );
    assert_eq!(
        message("parent = \"root\"", "parent = \"root\"\nparent_position_m = 0.1"),
        "wing.toml:27: key 'joint.mount.parent_position_m': 0.1 is not allowed; allowed: this key only with a body as \
         parent; on the root write root_position_m = [x, y, z] (m)"
    );
    assert_eq!(
        message("parent = \"inner\"", "parent = \"inner\"\nroot_position_m = [0, 0, 0]"),
        "wing.toml:31: key 'joint.fold.root_position_m': [0, 0, 0] is not allowed; allowed: this key only with parent \
         = \"root\"; on a body write parent_position_m (m), the distance along it"
    );
}

/// A joint that does not move freely has no start rate.
#[test]
fn start_rates() {
    assert_eq!(
        message("start_angle_deg = 170", "release = false\nstart_rate_deg_s = 5"),
        "wing.toml:34: key 'joint.fold.start_rate_deg_s': 5 is not allowed; allowed: a rate of 0 deg/s if the joint is \
         locked, prescribed or not released at the start"
    );
}

/// Prescribed joints need exactly one motion.
#[test]
fn prescribed_motion() {
    assert_eq!(
        message(
            "start_angle_deg = 170\n[joint.fold.motor]\nstiffness_N_m_rad = \
                     0.026\n[joint.fold.latch]\nstiffness_ratio = 1e4",
            "motion = \"prescribed\""
        ),
        "wing.toml:33: key 'joint.fold.motion': \"prescribed\" is not allowed; allowed: this motion with \
         polynomial_deg or table_s_deg"
    );
    assert_eq!(
        message(
            "start_angle_deg = 170\n[joint.fold.motor]\nstiffness_N_m_rad = \
                     0.026\n[joint.fold.latch]\nstiffness_ratio = 1e4",
            "motion = \"prescribed\"\ntable_s_deg = [[0, 0]]"
        ),
        "wing.toml:34: key 'joint.fold.table_s_deg': [[0, 0]] is not allowed; allowed: at least 2 pairs [time in \
         s, angle in deg] of finite numbers"
    );
    assert_eq!(
        message(
            "start_angle_deg = 170\n[joint.fold.motor]\nstiffness_N_m_rad = \
                     0.026\n[joint.fold.latch]\nstiffness_ratio = 1e4",
            "motion = \"prescribed\"\ntable_s_deg = [[0, 0], [1, 5], [1, 6]]"
        ),
        "wing.toml:34: key 'joint.fold.table_s_deg': [[0, 0], [1, 5], [1, 6]] is not allowed; allowed: pairs \
         [time in s, angle in deg] with ascending times"
    );
    assert_eq!(
        message(
            "start_angle_deg = 170\n[joint.fold.motor]\nstiffness_N_m_rad = \
                     0.026\n[joint.fold.latch]\nstiffness_ratio = 1e4",
            "motion = \"prescribed\"\npolynomial_deg = [1]\ntable_s_deg = [[0, 0], [1, 5]]"
        ),
        "wing.toml:35: key 'joint.fold.table_s_deg': [[0, 0], [1, 5]] is not allowed; allowed: either \
         polynomial_deg or table_s_deg, not both"
    );
    assert_eq!(
        message(
            "start_angle_deg = 170\n[joint.fold.motor]\nstiffness_N_m_rad = \
                     0.026\n[joint.fold.latch]\nstiffness_ratio = 1e4",
            "motion = \"prescribed\"\nstart_angle_deg = 3\npolynomial_deg = [1]"
        ),
        "wing.toml:34: key 'joint.fold.start_angle_deg': 3 is not allowed; allowed: no start angle with motion \
         = \"prescribed\", which determines it"
    );
    assert_eq!(
        message("start_angle_deg = 170", "polynomial_deg = [1]"),
        "wing.toml:33: key 'joint.fold.polynomial_deg': [1] is not allowed; allowed: this key only with motion = \
         \"prescribed\""
    );
}

/// Solver settings.
#[test]
fn solver_settings() {
    assert_eq!(
        message("tolerance = 1e-4", "tolerance = 0.2"),
        "wing.toml:48: key 'solver.tolerance': 0.2 is not allowed; allowed: a finite number from 1e-12 to 0.1"
    );
    assert_eq!(
        message("tolerance = 1e-4", "tolerance = 1e-13"),
        "wing.toml:48: key 'solver.tolerance': 1e-13 is not allowed; allowed: a finite number from 1e-12 to 0.1"
    );
    assert_eq!(
        message("min_step_s = 1e-9", "min_step_s = 0.01"),
        "wing.toml:50: key 'solver.min_step_s': 0.01 is not allowed; allowed: a finite time < max_step_s = 0.005 \
         s"
    );
    assert_eq!(
        message("max_step_s = 5e-3\nmin_step_s = 1e-9", "max_step_s = 1e-9"),
        "wing.toml:49: key 'solver.max_step_s': 1e-9 is not allowed; allowed: a finite time > min_step_s = 1e-9 s"
    );
    assert_eq!(
        message("rho_infinity = 0.8", "rho_infinity = 1.1"),
        "wing.toml:51: key 'solver.rho_infinity': 1.1 is not allowed; allowed: a finite number from 0 to 1"
    );
    assert_eq!(
        message("rho_infinity = 0.8", "fixed_step_s = 0"),
        "wing.toml:51: key 'solver.fixed_step_s': 0 is not allowed; allowed: a finite time > 0 s"
    );
}

/// Experiments.
#[test]
fn experiments() {
    assert_eq!(
        message("stop_time_s = 0.4", "stop_time_s = 0"),
        "wing.toml:54: key 'simulation.stop_time_s': 0 is not allowed; allowed: a finite time > start_time_s = 0 \
         s"
    );
    assert_eq!(
        message("start_time_s = 0\nstop_time_s = 0.4", "start_time_s = 0.5"),
        "wing.toml:53: key 'simulation.start_time_s': 0.5 is not allowed; allowed: a finite time < stop_time_s = \
         0.4 s"
    );
    assert_eq!(
        message("step_s = 5e-4", "step_s = 0"),
        "wing.toml:55: key 'simulation.step_s': 0 is not allowed; allowed: a finite time > 0 s"
    );
    assert_eq!(
        message("step_s = 5e-4", "step_s = 0.5"),
        "wing.toml:55: key 'simulation.step_s': 0.5 is not allowed; allowed: a finite time > 0 s and <= 0.4 s, \
         the duration of the simulation"
    );
}

/// Loads name a body and one of its stations.
#[test]
fn loads() {
    let load = |lines: &str| message("[mass.actuator]", &format!("[load.a]\n{lines}\n[mass.actuator]"));
    assert_eq!(
        load("body = \"innr\"\nstation = 1"),
        "wing.toml:39: key 'load.a.body': \"innr\" is not allowed; allowed: a body: \"inner\" or \"outer\" (did you mean \
         \"inner\"?)"
    );
    assert_eq!(
        load("body = \"inner\"\nstation = 5"),
        "wing.toml:40: key 'load.a.station': 5 is not allowed; allowed: a whole number from 1 to 4, the number of load \
         stations of \
         \"inner\""
    );
    assert_eq!(
        load("body = \"inner\"\nstation = 1\nforce_N = [0, 1]"),
        "wing.toml:41: key 'load.a.force_N': [0, 1] is not allowed; allowed: an array of 3 finite forces in N"
    );
}

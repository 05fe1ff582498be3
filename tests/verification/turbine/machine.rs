//! The machine of the example, and access to its parts by name.

use foldwing::config;
use foldwing::machine::*;
use foldwing::plant::Plant;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::PI;
use std::sync::Arc;

/// The text of the example.
pub const TEXT: &str = include_str!("../../../examples/turbine/nrel_5mw.toml");

/// The text of the example in wind.
pub const WIND_TEXT: &str = include_str!("../../../examples/turbine/nrel_5mw_wind.toml");

/// A text derived from the example in wind, with the polars in their files.
pub fn with_polars(text: &str) -> String {
    let folder = format!("{}/examples/turbine", env!("CARGO_MANIFEST_DIR"));
    config::with_files(text.to_owned(), folder.as_ref(), "nrel_5mw_wind.toml").expect("polars")
}

/// The machine of such a text.
pub fn windy(text: &str) -> Machine {
    config::parse(&with_polars(text), "nrel_5mw_wind.toml").unwrap_or_else(|refused| panic!("{refused}"))
}

/// The machine of the example.
pub fn turbine() -> Machine {
    config::parse(TEXT, "nrel_5mw.toml").unwrap_or_else(|refused| panic!("{refused}"))
}

/// Modal law of a body.
pub fn law(body: &Body) -> &ModalLaw {
    body.section.modal().unwrap_or_else(|| panic!("{} is no modal body", body.name))
}

/// Mutable modal law of a body.
pub fn law_mut<'m>(machine: &'m mut Machine, name: &str) -> &'m mut ModalLaw {
    let body = machine.bodies.iter_mut().find(|body| body.name == name).expect("a body of this name");
    match &mut body.section {
        SectionLaw::Modal(law) => law,
        _ => panic!("{name} is no modal body"),
    }
}

/// Mutable revolute joint.
pub fn hinge_mut<'m>(machine: &'m mut Machine, name: &str) -> &'m mut OneFreedom {
    let body = machine.bodies.iter_mut().find(|body| body.joint.name == name).expect("a joint of this name");
    match &mut body.joint.kind {
        JointKind::Revolute(hinge) => hinge,
        _ => panic!("{name} is not revolute"),
    }
}

/// Mutable prismatic joint.
pub fn slide_mut<'m>(machine: &'m mut Machine, name: &str) -> &'m mut OneFreedom {
    let body = machine.bodies.iter_mut().find(|body| body.joint.name == name).expect("a joint of this name");
    match &mut body.joint.kind {
        JointKind::Prismatic(slide) => slide,
        _ => panic!("{name} is not prismatic"),
    }
}

/// An example's text with its rotor on a rigid stand, without tower, yaw, tilt and cone: the conditions of OpenFAST's map of operating
/// points.
pub fn on_a_stand(text: &str) -> String {
    let (before, rest) = text.split_once("# Tower: ").expect("a tower");
    let (_, rest) = rest.split_once("# Nacelle: ").expect("a nacelle");
    let (nacelle, rest) = rest.split_once("[joint.yaw]").expect("a yaw joint");
    let (_, rest) = rest.split_once("# The shaft's end").expect("a generator");
    let yaw = "[joint.yaw]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"nacelle\"\n";
    let mut text = format!("{before}# {nacelle}{yaw}\n# {rest}").replace("rotation_deg = [0.0, 5.0, 0.0]", "");
    for (key, value) in [
        ("gravity_m_s2", "gravity_m_s2 = [0.0, 0.0, 0.0]"),
        ("parent_offset_m = [-0.0654", "parent_offset_m = [0.0, 0.0, 1.5]"),
        ("axis = [0.0436", "axis = [0.0, 0.0, -1.0]"),
        ("mount_rotation_deg = [124.4", "mount_rotation_deg = [127.27922061357854, 0.0, 127.27922061357854]"),
    ] {
        let start = text.find(key).unwrap_or_else(|| panic!("{key}"));
        let end = start + text[start..].find('\n').expect("a line");
        text.replace_range(start..end, value);
    }
    text
}

/// The first blade alone, clamped 1.5 m from the origin, without gravity: on a root that rotates about `x` it is a rotor blade without cone
/// and tilt.
pub fn blade_alone() -> Machine {
    let mut machine = turbine();
    machine.bodies.retain(|body| body.name == "blade1");
    let joint = &mut machine.bodies[0].joint;
    joint.parent = Parent::Root { position_m: Vector3::new(0.0, 0.0, 1.5) };
    joint.offset_m = Vector3::zeros();
    joint.mount = Rotation3::new(Vector3::new(1.0, 0.0, 1.0).normalize() * PI).into_inner();
    joint.kind = JointKind::Clamped;
    machine.gravity_m_s2 = Vector3::zeros();
    machine
}

/// An initialised plant on a root that rotates about `x`.
pub fn spinning(machine: Machine, speed_rpm: f64) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.inputs_mut().root_mut().angular_velocity_rad_s = Vector3::new(speed_rpm * PI / 30.0, 0.0, 0.0);
    plant.initialize(0.0).expect("a start");
    plant
}

/// A table of `tests/reference/turbine`: names of the columns, and rows.
pub fn table(text: &str) -> (Vec<&str>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let names = lines.next().expect("a header").split(',').collect();
    let row = |line: &str| line.split(',').map(|value| value.parse().expect("a number")).collect();
    (names, lines.map(row).collect())
}

/// Index of a degree of freedom among [`foldwing::plant::Plant::free_state`].
pub fn place(plant: &Plant, name: &str) -> usize {
    let freedoms = plant.freedoms();
    freedoms.iter().position(|freedom| freedom.name == name).unwrap_or_else(|| panic!("no freedom {name}"))
}

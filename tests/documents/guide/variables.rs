//! `docs/guide/variables.md`: every variable that an FMU can have, generated from the table in `crates/fmi/src/interface`.

use crate::guide::{assert_current, in_package};
use foldwing::config;
use foldwing::interface::{Causality, Interface, Value, Variability, Variable};
use foldwing::machine::Machine;
use std::collections::BTreeSet;

/// One of every part that has variables. Its names are those that the page replaces by placeholders.
const EVERYTHING: &str = r#"
name = "Everything"
[section.plate]
shape = "rectangle"
width_m = 0.05
height_m = 0.002
density_kg_m3 = 1425.0
youngs_modulus_Pa = 2.83e9
poisson_ratio = 0.3
[body.bodyname]
length_m = 0.2
section = "plate"
elements = 1
load_stations = 1
[body.bodynamea]
length_m = 0.1
section = "plate"
elements = 1
load_stations = 1
[body.bodynameb]
length_m = 0.1
section = "plate"
elements = 1
load_stations = 0
[joint.jointname]
type = "revolute"
parent = "root"
child = "bodyname"
axis = [0, 1, 0]
motor = { stiffness_N_m_rad = 1.0 }
spring = { stiffness_N_m_rad = 0.1 }
latch = { stiffness_ratio = 1e4 }
[joint.jointnamea]
type = "ball"
parent = "bodyname"
child = "bodynamea"
[joint.jointnameb]
type = "clamped"
parent = "bodyname"
child = "bodynameb"
[loop.loopname]
bodies = ["bodynamea", "bodynameb"]
stiffness_N_m = 1e4
[skate.skatename]
body = "bodyname"
[wheel.wheelname]
body = "bodyname"
radius_m = 0.1
plane_point_m = [0.0, 0.0, -0.1]
[gauge.gaugename]
body = "bodyname"
position_m = 0.01
[internal_load.sectionname]
body = "bodyname"
position_m = 0.05
[failure.failurename]
kind = "loop_break"
loop = "loopname"
[aerodynamics]
model = "strip"
wind_m_s = [0, -10, 0]
report_circulation = true
[surface.surfacename]
body = "bodyname"
strips = 1
[control_surface.flapname]
body = "bodyname"
from_m = 0.0
to_m = 0.2
hinge_fraction = 0.75
"#;

/// A rotor with a generator, a DC motor and a modal blade.
pub const ROTOR: &str = r#"
name = "Rotor"
[rigid_body.bodynamea]
mass_kg = 10.0
inertia_kg_m2 = [1.0, 1.0, 1.0, 0, 0, 0]
[joint.jointname]
type = "revolute"
parent = "root"
child = "bodynamea"
axis = [1, 0, 0]
motor = { gear_ratio = 97.0 }
generator = { table_rpm_N_m = [[1000.0, 10.0]] }
dc_motor = { resistance_ohm = 1.0, inductance_H = 1e-3, torque_constant_N_m_A = 0.1 }
[modal_body.bodyname]
length_m = 10.0
nodes = 5
stations = [0, 1]
mass_kg_m = [10, 10]
flap_stiffness_N_m2 = [1e6, 1e6]
edge_stiffness_N_m2 = [2e6, 2e6]
flap_shapes = [[1.0]]
[joint.jointnameb]
type = "clamped"
parent = "bodynamea"
child = "bodyname"
parent_offset_m = [0.0, 0.0, 0.5]
mount_rotation_deg = [0, -90, 0]
[aerodynamics]
model = "bem"
hub = "bodynamea"
hub_radius_m = 0.5
wind_m_s = [8.0, 0.0, 0.0]
step_s = 0.02
[surface.surfacename]
body = "bodyname"
elastic_axis_fraction = 0.25
stations_m = [0.0, 10.0]
polars = ["plate", "plate"]
chord_m = 0.4
[polar.plate]
rows = [[-180, 0, 0.5, 0], [180, 0, 0.5, 0]]
"#;

const HEAD: &str = "\
# All variables of the FMU

This page is generated from the program's table of variables; a test keeps it current. `<joint>`, `<body>`, `<gauge>`,
`<section>`, `<loop>`, `<skate>`, `<wheel>` and `<name>` (of a failure or a control surface) are placeholders for names in the model file, `[i]` is an index from 1.
`{x,y,z}` abbreviates three variables: `gravity.{x,y,z}` are `gravity.x`, `gravity.y` and `gravity.z`.
`foldwing check MODEL.toml --list-variables` lists the variables of a model with their start values, and
`documentation/index.html` inside the FMU contains the same table.

- Vectors are resolved in the root frame unless the row specifies another; units are SI. Angles are in rad, with degrees as display
  unit. A quaternion `{w,x,y,z}` transforms section components into root components; its sign is continuous.
- Variables are Reals unless the row specifies another type. Setting a value outside its range, or one that is not finite, returns
  `fmi2Discard` and has no effect.
- Inputs are constant during a step, or linear in time if `fmi2SetRealInputDerivatives` sets their rates (FMI 2.0). Outputs are evaluated
  at the current time with the current inputs: a force set between steps affects accelerations and reactions that are read before the
  next step. Aerodynamic loads, locks and latches are updated only in the step.
- **fixed** parameters can be set before the end of the initialisation, **tunable** ones at any time.
";

/// One of each prismatic joint: with everything, and with a rigid latch.
const SLIDES: &str = r#"
[joint.jointname]
type = "prismatic"
parent = "root"
child = "bodyname"
axis = [0, 1, 0]
motor = { stiffness_N_m = 1.0 }
spring = { stiffness_N_m = 0.1 }
latch = { stiffness_ratio = 1e4 }
"#;

/// Condition for variables whose name begins with this text.
const WHERE: &[(&str, &str)] = &[
    ("<joint>.generator", "revolute joints with a generator"),
    ("<joint>.voltage", DC_MOTOR),
    ("<joint>.current", DC_MOTOR),
    ("<joint>.dc_motor", "revolute joints with a `dc_motor`; prismatic ones have dc_motor_force in N"),
    ("<joint>.electrical_power", DC_MOTOR),
    ("rotor.", "with `aerodynamics.model = \"bem\"`"),
    ("failure.", "each failure"),
    ("aero.control_surface.", "each control surface"),
    ("body.<body>.deflection", MODAL),
    ("body.<body>.root_", MODAL),
    ("<joint>.latch_impulse", "revolute joints with a rigid latch"),
    ("<joint>.latch_stiffness", "revolute joints with an elastic latch"),
    ("<joint>.latch", "revolute joints with a latch and `motion = \"free\"`"),
    ("<joint>.angle_command", "revolute joints with `motion = \"free\"`"),
    ("<joint>.angle", REVOLUTE),
    ("<joint>.angular_velocity.{", "universal, ball and free joints"),
    ("<joint>.angular_velocity", REVOLUTE),
    ("<joint>.holding_torque.", REVOLUTE),
    ("<joint>.reaction_force", BOUND),
    ("<joint>.reaction_moment", BOUND),
    ("<joint>.spring_", SPRING),
    ("<joint>.rest_angle.", SPRING),
    ("<joint>.rotation", "universal, ball and free joints"),
    ("<joint>.start_angle", NOT_PRESCRIBED),
    ("<joint>.", "revolute joints with `motion = \"free\"`"),
    ("load.", "each load station"),
    ("station.", "each load station"),
    ("wind.", "with aerodynamics"),
    ("aero.circulation", "with `aerodynamics.report_circulation`"),
    ("aero.load", "load stations of bodies with a surface or a slender body"),
    ("aero.", "with aerodynamics"),
    ("gauge.", "each gauge"),
    ("internal_load.", "each `internal_load`"),
    ("loop.", "each closed loop"),
    ("skate.<skate>.normal_force", "each skate with `hold_normal`"),
    ("skate.", "each skate"),
    ("wheel.<wheel>.normal_force", "each wheel with `hold_normal`"),
    ("wheel.<wheel>.rolling_force", "each wheel with `rolling`"),
    ("wheel.", "each wheel"),
    ("tip.<body>", "each free end; `tip` where there is only one"),
    ("body.", "each body"),
];

/// Electrical motors.
const DC_MOTOR: &str = "revolute and prismatic joints with a `dc_motor`";

/// Modal bodies.
const MODAL: &str = "each modal body";

/// All revolute joints.
const REVOLUTE: &str = "revolute joints";
const SPRING: &str = "revolute joints with a `spring` and `motion = \"free\"`";

/// Joints that constrain a body.
const BOUND: &str = "all joints except free ones";

/// Revolute joints whose motion is not prescribed.
const NOT_PRESCRIBED: &str = "revolute joints except prescribed ones";

/// Condition for a variable.
fn place(variable: &Variable, pattern: &str, slides: bool) -> String {
    let name = format!("{pattern}.");
    let name = if slides && !name.contains("reaction") {
        name.replace("position", "angle").replace("force", "torque").replace("velocity", "angular_velocity")
    } else {
        name
    };
    match WHERE.iter().find(|(beginning, _)| name.starts_with(beginning)) {
        // variables that only the ball joint has
        Some((_, place)) if variable.name.starts_with("jointnamea.") && place.starts_with("revolute") => {
            "universal and ball joints".to_owned()
        }
        Some((_, place)) if slides => place.replace("revolute", "prismatic"),
        Some((_, place)) => (*place).to_owned(),
        None => "always".to_owned(),
    }
}

/// The table of [`EVERYTHING`].
pub fn everything() -> Interface {
    table(EVERYTHING)
}

/// The table of [`ROTOR`].
pub fn rotor() -> Interface {
    table(ROTOR)
}

/// The table of [`EVERYTHING`] in real-time mode, without aerodynamics.
pub fn in_real_time() -> Interface {
    let (still, _) = EVERYTHING.split_once("[aerodynamics]").unwrap();
    table(&format!("{still}[solver]\nmode = \"real_time\"\n"))
}

/// The table of [`EVERYTHING`] with a prismatic joint instead of the revolute one, with a rigid or an elastic latch.
pub fn sliding(rigid: bool) -> Interface {
    let (begin, rest) = EVERYTHING.split_once("[joint.jointname]").unwrap();
    let (_, end) = rest.split_once("[joint.jointnamea]").unwrap();
    let slides = if rigid { SLIDES.replace("stiffness_ratio = 1e4", "kind = \"rigid\"") } else { SLIDES.to_owned() };
    table(&format!("{begin}{slides}[joint.jointnamea]{end}"))
}

/// The table of [`EVERYTHING`] with a rigid latch.
pub fn with_rigid_latch() -> Interface {
    table(&EVERYTHING.replace("stiffness_ratio = 1e4", "kind = \"rigid\""))
}

fn table(model: &str) -> Interface {
    Interface::new(&config::parse(model, "everything.toml").unwrap_or_else(|error| panic!("{error}")))
}

/// Names of the model file as placeholders. Longer names first: they contain the shorter ones.
fn generic(text: &str) -> String {
    ["body", "joint", "gauge", "loop", "skate", "wheel", "section", "surface"].iter().fold(
        text.to_owned(),
        |text, kind| {
            ["a", "b", ""]
                .iter()
                .fold(text, |text, suffix| text.replace(&format!("{kind}name{suffix}"), &format!("<{kind}>")))
                .replace("failurename", "<name>")
                .replace("flapname", "<name>")
        },
    )
}

/// Name with the components of a vector or quaternion combined, and the component.
pub fn pattern(name: &str) -> (String, Option<&str>) {
    let (stem, last) = name.rsplit_once('.').unwrap_or(("", name));
    let components = if stem.ends_with(".rotation") { "{w,x,y,z}" } else { "{x,y,z}" };
    let component = ["w", "x", "y", "z"].contains(&last).then_some(last);
    let name = component.map_or(name.to_owned(), |_| format!("{stem}.{components}"));
    (generic(&name).replace("[1]", "[i]"), component)
}

/// The description of a variable, without its particular component, station or position.
fn meaning(variable: &Variable, component: Option<&str>) -> String {
    // the component is a separate part between commas, not the beginning of a word
    let parts = variable.description.split(", ").filter(|part| Some(*part) != component);
    let text =
        generic(&parts.collect::<Vec<_>>().join(", ")).replace("station 1", "station i").replace("strip 1", "strip i");
    match variable.name.split_once('.') {
        Some(("gauge", _)) => "strain at the gauge, along the axis or its `direction`".to_owned(),
        Some(("internal_load", _)) => text.replace(" at 0.05 m", " at its position"),
        _ => text,
    }
}

fn range(variable: &Variable) -> String {
    let Some((least, most)) = variable.range else { return String::new() };
    // the table's smallest positive number and its largest number mean that there is no bound
    match (least <= 0.0 || least > 1e-20, most < 1e30) {
        (false, false) => "> 0".to_owned(),
        (true, false) => format!("≥ {least}"),
        _ => format!("{} to {}", shortest(least), shortest(most)),
    }
}

fn shortest(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    if value != 0.0 && !(1e-3..1e4).contains(&value.abs()) { format!("{value:e}") } else { format!("{rounded}") }
}

/// The variables of one causality; each pattern once.
fn rows(interfaces: &[Interface; 6], causality: Causality) -> String {
    let [ordinary, in_real_time, rigid, sliding, sliding_rigid, rotor] = interfaces;
    let mut seen = BTreeSet::new();
    let mut text = String::new();
    let all = [
        (ordinary, false),
        (in_real_time, false),
        (rigid, false),
        (sliding, true),
        (sliding_rigid, true),
        (rotor, false),
    ];
    let all =
        all.into_iter().flat_map(|(interface, slides)| interface.variables().iter().map(move |row| (row, slides)));
    for (variable, slides) in all.filter(|(variable, _)| variable.causality == causality) {
        let (name, component) = pattern(&variable.name);
        let slides = slides && variable.name.starts_with("jointname.");
        let elsewhere = [ordinary, rigid, sliding, sliding_rigid, rotor];
        let only_in_real_time = elsewhere.iter().all(|interface| interface.find(&variable.name).is_none());
        let (place, meaning) = (place(variable, &name, slides), meaning(variable, component).replace('<', "\\<"));
        if !seen.insert((name.clone(), meaning.clone())) {
            continue;
        }
        let place = if only_in_real_time { "in real-time mode".to_owned() } else { place };
        let kind = match (variable.value, variable.variability) {
            (Value::Boolean(_), _) => "Boolean",
            (Value::Integer(_), _) => "Integer",
            (_, Variability::Fixed) => "fixed",
            (_, Variability::Tunable) => "tunable",
            _ => "",
        };
        let unit = if variable.unit().is_empty() { "" } else { variable.unit() };
        text += &format!("| `{name}` | {unit} | {kind} | {} | {meaning} | {place} |\n", range(variable))
            .replace("  |", " |");
    }
    text
}

/// The text of the page.
fn page() -> String {
    let interfaces = [everything(), in_real_time(), with_rigid_latch(), sliding(false), sliding(true), rotor()];
    let parts = [
        (
            Causality::Input,
            "Inputs",
            "Start values come from the model file: loads from `[load.<name>]`, gravity from `gravity_m_s2`, wind from `aerodynamics.wind_m_s`; they are 0 by default. `<joint>.release` and `<joint>.latch_enable` start as true unless the model file sets them, so that the wing unfolds with default values.",
        ),
        (
            Causality::Output,
            "Outputs",
            "`energy.total - energy.work + energy.dissipated` is constant up to the integration error. Outputs of a rotor in a table `[aerodynamics.<name>]` have this name in the second place, as in rotor.right.thrust.",
        ),
        (Causality::Parameter, "Parameters", "Start values come from the model file."),
        (
            Causality::Local,
            "Counters",
            "Local variables on the cost of a run. All are reset to 0 at initialisation; durations are wall time.",
        ),
        (Causality::Independent, "Time", ""),
    ];
    let mut page = HEAD.to_owned();
    for (causality, title, remark) in parts {
        page += &format!("\n## {title}\n\n");
        if !remark.is_empty() {
            page += &format!("{remark}\n\n");
        }
        page += "| name | unit | kind | allowed | meaning | exists for |\n|---|---|---|---|---|---|\n";
        page += &rows(&interfaces, causality);
    }
    page
}

/// F-242. The page of variables is current.
#[test]
fn f242_the_page_of_variables_is_current() {
    assert_current("docs/guide/variables.md", &page());
}

/// F-243. Every variable of every shipped model is on the page, under the pattern of its name.
#[test]
fn f243_every_variable_of_every_shipped_model_is_on_the_page() {
    let page = page();
    let mut models = 0;
    for entry in std::fs::read_dir(in_package("examples/models")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        models += 1;
        let (machine, _) = config::read(&path).unwrap_or_else(|error| panic!("{error}"));
        for variable in Interface::new(&machine).variables() {
            let name = named(&machine, &variable.name);
            assert!(
                page.contains(&format!("| `{name}` | {}", variable.unit())),
                "{}: {} as {name}",
                path.display(),
                variable.name
            );
        }
    }
    assert!(models >= 11, "{models} models");
}

/// F-245. Locked and prescribed joints have exactly the variables given on the page. They have no latch.
#[test]
fn f245_the_page_says_which_joints_have_a_row() {
    let free = everything();
    for (motion, places) in [
        ("motion = \"locked\"", &[REVOLUTE, BOUND, NOT_PRESCRIBED][..]),
        ("motion = \"prescribed\"\npolynomial_deg = [0]", &[REVOLUTE, BOUND]),
    ] {
        let text = EVERYTHING.replace("child = \"bodyname\"\n", &format!("child = \"bodyname\"\n{motion}\n"));
        let text = text.replace("latch = { stiffness_ratio = 1e4 }\n", "");
        let machine = config::parse(&text, "everything.toml").unwrap_or_else(|error| panic!("{error}"));
        let of_joint = |interface: &Interface| -> Vec<String> {
            let rows = interface.variables().iter().filter(|row| row.name.starts_with("jointname."));
            rows.map(|row| row.name.clone()).collect()
        };
        let rows = free.variables().iter().filter(|row| row.name.starts_with("jointname."));
        let expected = rows.filter(|row| places.contains(&place(row, &pattern(&row.name).0, false).as_str()));
        let expected: Vec<String> = expected.map(|row| row.name.clone()).collect();
        assert_eq!(of_joint(&Interface::new(&machine)), expected, "{motion}");
    }
}

/// The pattern of a machine's variable.
pub fn named(machine: &Machine, name: &str) -> String {
    let (pattern, _) = pattern(name);
    let mut parts: Vec<String> = pattern.split('.').map(str::to_owned).collect();
    let count = parts.len();
    let index = |part: &str| part.split_once('[').map(|(body, _)| format!("{body}[i]"));
    let body = |part: &str| machine.bodies.iter().any(|body| body.name == part);
    match parts[0].as_str() {
        "load" | "station" => parts[1] = "<body>[i]".to_owned(),
        "aero" if count > 2 && index(&parts[2]).is_some() => parts[2] = "<body>[i]".to_owned(),
        "body" => parts[1] = "<body>".to_owned(),
        "gauge" => parts[1] = "<gauge>".to_owned(),
        "internal_load" => parts[1] = "<section>".to_owned(),
        "loop" => parts[1] = "<loop>".to_owned(),
        "tip" if count > 2 && body(&parts[1]) => parts[1] = "<body>".to_owned(),
        "tip" => parts.insert(1, "<body>".to_owned()),
        first if machine.bodies.iter().any(|body| body.joint.name == first) => parts[0] = "<joint>".to_owned(),
        _ => {}
    }
    parts.join(".")
}

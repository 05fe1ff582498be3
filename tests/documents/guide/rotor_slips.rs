//! Mistakes with rotors: models and lines of `modes --vary rotor_speed_rpm`, and errors in parts of a rotor.

/// Lines in a folder with the files of [`files`] and `wing.toml`.
pub const LINES: &[&str] = &[
    "modes turbine.toml --vary rotor_speed_rpm=0:10:2",
    "modes wing.toml --state undeformed --vary rotor_speed_rpm=0:10:2 --shaft none",
    "modes wing.toml --shaft fold --vary fold.angle_command=0:1:2",
    "modes turbine.toml --state undeformed --vary rotor_speed_rpm=0:10:2 --shaft base",
    "modes turbine.toml --state undeformed --vary rotor_speed_rpm=0:10:2 --shaft pitch1",
    "modes still.toml --vary rotor_speed_rpm=0:10:2",
    "modes twin.toml --vary rotor_speed_rpm=0:10:2",
    "modes unlike.toml --state undeformed --vary rotor_speed_rpm=1:10:2",
    "modes gap.toml --vary rotor_speed_rpm=0:10:2",
    "modes tilted.toml --vary rotor_speed_rpm=0:10:2",
    "modes clamped.toml --vary rotor_speed_rpm=0:10:2",
    "modes loose.toml --vary rotor_speed_rpm=0:10:2",
    "modes rotor.toml --vary rotor_speed_rpm=inf,1",
    "periodic rotor.toml",
    "periodic rotor.toml --speed-rpm 0",
    "periodic rotor.toml --speed-rpm 10 --steps 0",
    "periodic rotor.toml --speed-rpm 10 --harmonics 80",
    "periodic rotor.toml --speed-rpm 10 --tolerance 0",
    "periodic rotor.toml --speed-rpm 10 --perturbations 0",
    "periodic loose.toml --speed-rpm 10 --steps 144 --set gravity.z=-9.81",
    "periodic stops.toml --speed-rpm 10 --set gravity.z=-9.81",
    "operating-points wing.toml --wind-m-s 8",
    "operating-points windmill.toml --wind-m-s 8 --shaft jointname --speed-rpm 0",
    "operating-points windmill.toml --wind-m-s 8 --shaft jointname --pitch-deg 3",
    "operating-points windmill.toml --wind-m-s 8 --shaft jointname --pitch-joints jointnameb",
    "operating-points windmill.toml --wind-m-s 8,x",
    "operating-points windmill.toml --wind-m-s=-8 --shaft jointname",
    "operating-points windmill.toml --wind-m-s 8 --speed-rpm 1,2 --tip-speed-ratio 7",
    "operating-points windmill.toml --wind-m-s 8 --tip-speed-ratio=0",
    "operating-points windmill.toml --wind-m-s 5,6,7 --speed-rpm 1,2 --paired",
    "operating-points windmill.toml --wind-m-s 5:25:1000 --speed-rpm 1:20:1000",
    "operating-points windmill.toml --wind-m-s 8 --tolerance 0",
    "operating-points windmill.toml --wind-m-s 8 --solve-for pitch=0:9 --target rotor.power=1",
    "operating-points windmill.toml --wind-m-s 8 --solve-for speed_rpm=1:9 --target rotor.power",
    "operating-points windmill.toml --wind-m-s 8 --speed-rpm 3 --solve-for speed_rpm=1:9 --target rotor.power=1",
    "operating-points windmill.toml --wind-m-s 8 --shaft jointname --solve-for speed_rpm=1:9 --target wind.velocity.x=1",
    "operating-points windmill.toml --wind-m-s 8 --shaft jointname --solve-for speed_rpm=10:19 --target rotor.power=-1e9",
    "operating-points windmill.toml --wind-m-s 8 --shaft jointname --speed-rpm 10 --set wind.velocity.x=0",
    "flutter windmill.toml --wind-m-s 5:10:6",
    "linearize jump.toml --state start -o x.json",
    "check windy.toml",
    "check bare.toml",
];

const HEAD: &str = "name = \"rotor\"\ngravity_m_s2 = [0, 0, 0]\n";
const TAIL: &str = "[simulation]\nstop_time_s = 1.0\nstep_s = 0.01\n";

fn hub(joint: &str, axis: &str) -> String {
    format!(
        "[rigid_body.hub{joint}]\nmass_kg = 1.0\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\n\
         [joint.{joint}]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"hub{joint}\"\naxis = {axis}\n"
    )
}

fn blade(joint: &str, number: u32, turn: &str, mass_kg: f64, kind: &str) -> String {
    format!(
        "[rigid_body.blade{joint}{number}]\nmass_kg = {mass_kg:?}\ncentre_of_mass_m = [0, 1, 0]\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\n\
         [joint.lag{joint}{number}]\nparent = \"hub{joint}\"\nchild = \"blade{joint}{number}\"\nmount_rotation_deg = {turn}\n{kind}\n"
    )
}

const HINGE: &str = "type = \"revolute\"\naxis = [1, 0, 0]\nspring = { stiffness_N_m_rad = 10.0 }";

/// Models by name.
pub fn files() -> Vec<(&'static str, String)> {
    let one = |turns: [&str; 3], mass_kg: f64, kind: &str| {
        let shaft = hub("shaft", "[1, 0, 0]");
        let rest = blade("shaft", 1, turns[0], 1.0, HINGE) + &blade("shaft", 2, turns[1], 1.0, HINGE);
        format!("{HEAD}{shaft}{rest}{}{TAIL}", blade("shaft", 3, turns[2], mass_kg, kind))
    };
    let even = ["[0, 0, 0]", "[120, 0, 0]", "[240, 0, 0]"];
    let alone = hub("shaft", "[1, 0, 0]");
    let pair = |joint: &str| {
        hub(joint, "[1, 0, 0]")
            + &blade(joint, 1, "[0, 0, 0]", 1.0, HINGE)
            + &blade(joint, 2, "[180, 0, 0]", 1.0, HINGE)
    };
    let blown = crate::guide::variables::ROTOR;
    let loose = "type = \"revolute\"\naxis = [1, 0, 0]";
    let unsprung = one(even, 1.0, HINGE).replace(HINGE, loose);
    vec![
        ("turbine.toml", include_str!("../../../examples/turbine/nrel_5mw.toml").to_owned()),
        ("rotor.toml", one(even, 1.0, HINGE)),
        ("unlike.toml", one(even, 1.5, HINGE)),
        ("gap.toml", one(["[0, 0, 0]", "[90, 0, 0]", "[180, 0, 0]"], 1.0, HINGE)),
        ("tilted.toml", one(["[0, 0, 0]", "[120, 0, 0]", "[240, 10, 0]"], 1.0, HINGE)),
        ("clamped.toml", one(even, 1.0, "type = \"clamped\"")),
        ("loose.toml", unsprung),
        (
            "stops.toml",
            one(even, 1.0, &format!("{HINGE}\nend_stops = {{ upper_deg = 5.0, stiffness_N_m_rad = 1000.0 }}")),
        ),
        ("still.toml", format!("{HEAD}{alone}{TAIL}")),
        ("twin.toml", format!("{HEAD}{}{}{TAIL}", pair("left"), pair("right"))),
        ("windmill.toml", format!("{blown}{TAIL}")),
        ("windy.toml", format!("{blown}[wind]\nreference_height_m = 20.0\nfield_file = \"short.bts\"\n{TAIL}")),
        ("jump.toml", JUMP.to_owned()),
        ("short.bts", "short".to_owned()),
        ("bare.toml", format!("{}{TAIL}", blown.replace(POLAR, "file = \"bare.csv\""))),
        ("bare.csv", "alpha_deg,cl,cd,cm\n".to_owned()),
    ]
}

/// At `V_x = V_y √(σ c_n/2)`, eq. (B6), with `σ = 3 · 0.5/(2π · 5.5)` and `V_y = 5.5 m · 240°/s`.
const JUMP: &str = r#"name = "rotor"
[rigid_body.hub]
mass_kg = 10.0
inertia_kg_m2 = [1, 1, 1, 0, 0, 0]
[joint.shaft]
type = "revolute"
parent = "root"
child = "hub"
axis = [1, 0, 0]
start_rate_deg_s = 240.0
[rigid_body.blade]
mass_kg = 20.0
centre_of_mass_m = [4, 0, 0]
inertia_kg_m2 = [1, 100, 100, 0, 0, 0]
[joint.mount]
type = "clamped"
parent = "hub"
child = "blade"
parent_offset_m = [0, 0, 0.5]
mount_rotation_deg = [127.27922061357854, 0.0, 127.27922061357854]
[aerodynamics]
model = "bem"
hub = "hub"
hub_radius_m = 0.5
blades = 3
wind_m_s = [3.394, 0.0, 0.0]
step_s = 0.02
dynamic_inflow = true
[surface.blade]
body = "blade"
length_m = 9.5
elastic_axis_fraction = 0.25
stations_m = [0.0, 5.0, 9.5]
polars = ["p", "p", "p"]
chord_m = 0.5
[polar.p]
rows = [[-180, 1.0, 0.0, 0.0], [180, 1.0, 0.0, 0.0]]
"#;

const POLAR: &str = "rows = [[-180, 0, 0.5, 0], [180, 0, 0.5, 0]]";

/// Messages for invalid rotors and generators.
pub fn refused() -> Vec<String> {
    let rotor = crate::guide::variables::ROTOR;
    let second = |mount: &str| {
        format!(
            "[modal_body.second]\nlength_m = 10.0\nnodes = 5\nstations = [0, 1]\nmass_kg_m = [10, 10]\nflap_stiffness_N_m2 = [1e6, 1e6]\n\
             edge_stiffness_N_m2 = [2e6, 2e6]\nflap_shapes = [[1.0]]\n[joint.second]\ntype = \"clamped\"\nparent = \"bodynamea\"\n\
             child = \"second\"\nmount_rotation_deg = {mount}\n"
        )
    };
    let surface = "[surface.second]\nbody = \"second\"\nelastic_axis_fraction = 0.25\nstations_m = [0.0, 10.0]\npolars = [\"plate\", \"plate\"]\nchord_m = 0.4\n";
    let power = rotor.replace("[[1000.0, 10.0]]", "[[-10.0, 10.0]], above_table = \"constant_power\"");
    let alone = rotor.replace(POLAR, "file = \"plate.csv\"");
    let texts = [
        format!("{rotor}{}", second("[0, -90, 0]")),
        format!("{rotor}{}{surface}", second("[0, -90, 0]")),
        // a wing in addition to the rotor
        format!("{rotor}{}{surface}", second("[0, 0, 0]").replace("parent = \"bodynamea\"", "parent = \"root\"")),
        power,
        alone,
    ];
    let said = |text: &String| foldwing::config::parse(text, "rotor.toml").expect_err(text).to_string();
    texts.iter().chain(&airs()).chain(&slender_bodies()).map(said).chain(studies_of_airs()).collect()
}

const TWIN: &str = include_str!("../../../examples/airs/twin_rotor.toml");
const PROPELLERS: &str = include_str!("../../../examples/airs/wing_with_propellers.toml");
const GLIDER: &str = include_str!("../../../examples/airs/wing_with_fuselage.toml");

/// Invalid slender bodies.
fn slender_bodies() -> Vec<String> {
    let rows = GLIDER.lines().find(|line| line.starts_with("radius_m")).expect("rows");
    let second =
        "[aerodynamics.other]\nmodel = \"slender_body\"\nbody = \"fuselage\"\nradius_m = [[0.0, 0.0], [3.0, 0.1]]\n";
    let (before, after) = GLIDER.split_once("[surface.").expect("surfaces");
    let alone = before.to_owned() + &after[after.find("[aerodynamics]").expect("air")..];
    vec![
        GLIDER.replace("body = \"fuselage\"\nradius_m", "radius_m"),
        GLIDER
            .replace(rows, "radius_m = [[0.0, 0.0], [0.3, 0.1]]")
            .replace("body = \"fuselage\"\nradius_m", "body = \"fin\"\nradius_m"),
        GLIDER.replace(rows, ""),
        GLIDER.replace(rows, "radius_m = [[0.0, 0.1], [0.0, 0.2]]"),
        GLIDER.replace(rows, "radius_m = [[0.0, 0.1], [3.5, 0.2]]"),
        GLIDER.replace(rows, "radius_m = [[0.0, 0.0], [3.0, 0.0]]"),
        GLIDER.replace("segments = 12", "segments = 3"),
        GLIDER.replace("model = \"strip\"", "model = \"strip\"\nsegments = 3"),
        GLIDER.to_owned() + second,
        alone.replace("step_s = 0.0025\n", "").replace("[aerodynamics.surfaces]\nmodel = \"strip\"\n", ""),
    ]
}

/// Invalid files with several aerodynamic models.
fn airs() -> Vec<String> {
    let part = "[aerodynamics.other]\nmodel = \"strip\"\n";
    let field = "[wind]\nreference_height_m = 10.0\nshear_exponent = 0.1\n";
    vec![
        TWIN.replace("[aerodynamics]\n", "[aerodynamics]\nmodel = \"strip\"\nhub = \"port_hub\"\n"),
        TWIN.replace("hub = \"starboard_hub\"", "hub = \"port_hub\""),
        TWIN.replace("[wind]\nreference_height_m = 20.0\nshear_exponent = 0.14\n", "") + part,
        PROPELLERS.to_owned() + part,
        PROPELLERS.to_owned() + field,
        PROPELLERS.replace("[aerodynamics.wing]\nmodel = \"strip\"\n", ""),
        PROPELLERS.replace(
            "[aerodynamics.left]\nmodel = \"bem\"\nhub = \"left_hub\"",
            "[aerodynamics.left]\nmodel = \"bem\"\nhub = \"left_blade1\"",
        ),
        PROPELLERS.replacen("length_m = 0.48", "length_m = 0.48\nstrips = 3", 1),
        PROPELLERS.replacen("strips = 8", "strips = 8\nlength_m = 4.0", 1),
    ]
}

/// Refusals of studies, and of machines described in code, with several aerodynamic models.
fn studies_of_airs() -> Vec<String> {
    use foldwing::machine::Air;
    let twin = foldwing::config::parse(TWIN, "twin.toml").expect("a machine");
    let turn = foldwing::plant::Turn::of(&twin, Some("port_shaft"), Some(8.0), 64).expect_err("several models");
    let mut divided = twin.clone();
    divided.air.as_mut().expect("air").parts[0].surfaces = vec![1, 0];
    let faults = divided.validate().into_iter().map(|fault| format!("{}; allowed: {}", fault.value, fault.allowed));
    let part = |air: foldwing::machine::builder::AirBuilder| {
        let material =
            foldwing::beam::section::Material { youngs_modulus_pa: 7e9, shear_modulus_pa: 3e9, density_kg_m3: 1400.0 };
        let body =
            foldwing::machine::Body::beam("wing", 1.0, foldwing::beam::section::Solid::rectangle(0.2, 0.01, material));
        let machine =
            foldwing::machine::Machine::builder("Parts").body(body, foldwing::machine::Joint::clamped("root"));
        let surface = foldwing::machine::LiftingSurface::on("wing", 2);
        machine.air(air).surface(surface).build().expect_err("a faulty part").to_string()
    };
    let built =
        [Air::parts(), Air::parts().part("a", Air::lattice()), Air::parts().part("a", Air::strips().step_s(0.1))]
            .map(part);
    faults.chain([turn]).chain(built).collect()
}

//! `docs/guide/messages.md`: every quoted message occurs in the program, and no message of the program is missing.
//!
//! Three sources. *Produced here*: messages of the command in the cases below. *Produced elsewhere*: the complete messages that
//! `tests/robustness` expects from the program. *Source*: texts of the program produced in neither of the two.

use crate::guide::commands::foldwing;
use crate::guide::in_package;
use crate::guide::rotor_slips;
use foldwing::machine::builder::JointBuilder;
use foldwing::machine::{Body, DcMotor, Joint, Machine};
use std::fs;
use std::path::Path;

/// The messages of a row, as consecutive pieces.
struct Quote {
    section: String,
    text: String,
    pieces: Vec<String>,
}

impl Quote {
    fn new(section: &str, text: &str) -> Self {
        let pieces = text.split('…').map(str::to_owned).filter(|piece| !piece.trim().is_empty()).collect();
        Self { section: section.to_owned(), text: text.to_owned(), pieces }
    }

    /// Returns whether the pieces occur in `text` in this order.
    fn is_in(&self, text: &str) -> bool {
        let mut rest = text;
        !self.pieces.is_empty()
            && self.pieces.iter().all(|piece| match rest.find(piece.as_str()) {
                Some(at) => {
                    rest = &rest[at + piece.len()..];
                    true
                }
                None => false,
            })
    }
}

/// Messages in the first column of the page's tables.
fn quotes() -> Vec<Quote> {
    let page = fs::read_to_string(in_package("docs/guide/messages.md")).unwrap();
    let mut section = String::new();
    let mut quotes = Vec::new();
    for line in page.lines() {
        if let Some(title) = line.strip_prefix("## ") {
            section = title.to_owned();
        }
        if !line.starts_with("| `") {
            continue;
        }
        let first = line.trim_start_matches("| ").split(" | ").next().unwrap();
        quotes.extend(first.split('`').skip(1).step_by(2).map(|text| Quote::new(&section, text)));
        assert_eq!(line.matches(" | ").count(), 2, "three columns: {line}");
    }
    quotes
}

/// String literals of Rust source, with `{…}` as `…`, except those of tests in the same file.
fn literals(text: &str) -> Vec<String> {
    let end = ["mod tests {", "pub(super) mod tests {"].map(|module| text.find(&format!("#[cfg(test)]\n{module}")));
    let code = &text[..end.into_iter().flatten().min().unwrap_or(text.len())];
    let mut letters = code.chars().peekable();
    let mut found = Vec::new();
    while let Some(letter) = letters.next() {
        match letter {
            '/' if letters.peek() == Some(&'/') => letters.by_ref().take_while(|c| *c != '\n').for_each(drop),
            // a character literal; lifetimes have no second quote this close
            '\'' => {
                let next: String = letters.clone().take(3).collect();
                let skipped = if next.starts_with('\\') { 3 } else { 2 };
                if next.chars().nth(skipped - 1) == Some('\'') {
                    letters.by_ref().take(skipped).for_each(drop);
                }
            }
            '"' => {
                let mut literal = String::new();
                while let Some(letter) = letters.next().filter(|c| *c != '"') {
                    match (letter, letters.peek()) {
                        ('\\', Some('\n')) => while letters.next_if(|c| c.is_whitespace()).is_some() {},
                        ('\\', Some(_)) => literal.extend(letters.next().map(|c| if c == 'n' { '\n' } else { c })),
                        _ => literal.push(letter),
                    }
                }
                found.push(without_fields(&literal));
            }
            _ => {}
        }
    }
    found
}

/// A format string with its fields as `…`.
fn without_fields(format: &str) -> String {
    let mut text = String::new();
    let mut rest = format;
    while let Some(at) = rest.find('{') {
        text += &rest[..at];
        let doubled = rest[at..].starts_with("{{");
        let end = if doubled { at + 2 } else { rest[at..].find('}').map_or(rest.len(), |end| at + end + 1) };
        text += if doubled { "{" } else { "…" };
        rest = &rest[end..];
    }
    (text + rest).replace("}}", "}")
}

/// Rust files below a folder.
fn sources(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") && !path.ends_with("tests.rs") {
            found.push(fs::read_to_string(path).unwrap());
        }
    }
}

fn literals_below(folder: &str) -> Vec<String> {
    let mut files = Vec::new();
    sources(&in_package(folder), &mut files);
    literals_of(&files)
}

fn literals_of(files: &[String]) -> Vec<String> {
    files.iter().flat_map(|file| literals(file)).collect()
}

/// Complete messages expected by tests: for model files, and for the C functions.
fn asserted() -> (Vec<String>, Vec<String>) {
    let literals = literals_below("tests/robustness");
    let lines = literals.iter().flat_map(|text| text.lines().map(str::to_owned));
    let model_file = lines.filter(|line| line.starts_with("wing.toml:")).collect();
    let calls = ["failures.rs", "fmi3.rs"].map(|file| in_package("tests/robustness").join(file));
    let calls = literals_of(&calls.map(|file| fs::read_to_string(file).unwrap()));
    (model_file, calls.into_iter().filter(|text| text.len() > 30 && text.contains(' ')).collect())
}

/// Files for the cases.
const FILES: &[(&str, &[u8])] = &[
    ("binary.toml", b"name = \"\xff\"\n"),
    ("library.so", b"not a library"),
    ("push.csv", b"time,fold.external_torque\n0,0\n0.1,0\n0.1,0\n"),
    ("rows.csv", b"time,fold.angle_command\n"),
    ("time.csv", b"time,fold.angle_command\n1,0\n0,1\n"),
    ("jump.csv", b"time,fold.angle_command\n0,0\n0,1\n0,2\n"),
    ("first.csv", b"fold.angle_command,time\n0,0\n"),
    ("twice.csv", b"time,fold.angle_command,fold.angle_command\n0,0,0\n"),
    ("output.csv", b"time,fold.angle\n0,0\n"),
    ("number.csv", b"time,fold.angle_command\n0,inf\n"),
    ("columns.csv", b"time,fold.angle_command\n0,0,0\n"),
    ("semicolon.csv", b"time;fold.angle_command\n0;0\n"),
    ("letters.toml", b"name = \"X\"\ndescription = \"a\\u0001b\"\n"),
    ("word.toml", b"name = Folding\n"),
    ("comma.toml", b"name = \"X\"\nheight_m = 0,004\n"),
    ("repeated.toml", b"name = \"X\"\n[gauge.a]\n[gauge.a]\n"),
    ("taken.csv", b"something\n"),
    ("page.html", b"<!doctype html>\n"),
    (
        "older.html",
        b"<meta name=\"generator\" content=\"foldwing\"><script type=\"application/json\" class=\"run\">{\"format\":1}</script>\
        <script type=\"text/plain\" class=\"numbers\"></script>",
    ),
    (
        "shapes.html",
        b"<meta name=\"generator\" content=\"foldwing\"><script type=\"application/json\" class=\"run\">{\"format\":1}</script>\
        <script type=\"text/plain\" class=\"numbers\"></script><script type=\"application/json\" class=\"modes\"></script>",
    ),
    ("timeless.csv", b"t,a\n0,1\n"),
    ("alone.csv", b"time\n0\n"),
    ("pair.csv", b"time,a,a\n0,1,2\n"),
    ("word.csv", b"time,a\n0,one\n"),
    ("back.csv", b"time,a\n1,1\n0,1\n"),
    ("empty.csv", b"time,a\n"),
    ("one.csv", b"time,a\n0,1\n1,1\n"),
    ("two.csv", b"time,a\n0,2\n1,2\n"),
    ("other_columns.csv", b"time,b\n0,2\n1,2\n"),
    ("later.csv", b"time,a\n5,2\n6,2\n"),
    ("wide.csv", b"time,a\n5.2,2\n5.8,2\n"),
    ("other.csv.sweep", b"something\n"),
];

/// Mistakes on the command line, in a folder with [`FILES`] and the shipped models; `LIBRARY` and `COMMAND` stand for the built ones.
const SLIPS: &[&str] = &[
    "new wing.toml",
    "new wing",
    "new ..",
    "check missing.toml",
    "check binary.toml",
    "check letters.toml",
    "check comma.toml",
    "check repeated.toml",
    "check word.toml",
    "simulate wing.fmu",
    "simulate wing.toml --inputs semicolon.csv",
    "simulate wing.toml --set fold.start_angle=90+kg",
    "simulate wing.toml --set file:solver.tolerance=1e-5",
    "simulate wing.toml --csv wing.toml/x.csv",
    "simulate wing.toml --csv wing.toml",
    "simulate wing.toml --csv taken.csv",
    "simulate wing.toml --csv x.csv --profile x.csv",
    "simulate wing.toml --csv ..",
    "package wing.toml -o Wing",
    "package wing.toml -o x.fmu --ssp x.zip",
    "package wing.toml -o x.fmu --fmi 3 --ssp x.ssp",
    "simulate wing.toml --csv - --variables fold.angel",
    "simulate wing.toml --csv - --variables zzzzzzzzzzzz",
    "simulate wing.toml --csv - --set fold.angle_command",
    "simulate wing.toml --csv - --set fold.angle_command=x",
    "simulate wing.toml --csv - --set fold.release=x",
    "simulate wing.toml --csv - --set fold.angle=1",
    "simulate wing.toml --csv - --set fold.motor_damping=-1",
    "simulate wing.toml --csv - --set fold.motor_damping=inf",
    "simulate wing.toml --csv - --step 0",
    "simulate wing.toml --csv - --step 1e-12",
    "simulate wing.toml --csv - --stop -1",
    "simulate wing.toml --csv - --stop 0.01 --lattice l.json --lattice-at 0",
    "simulate wing.toml --view x.html --compare wing.fmu",
    "simulate wing.toml --view x.html --compare page.html",
    "simulate wing.toml --view x.html --compare older.html",
    "simulate wing.toml --view x.html --compare shapes.html",
    "modes wing.toml --count 0 --view x.html",
    "periodic wing.toml --count 0 --view x.html",
    "simulate wing.toml --view x.html --compare timeless.csv",
    "simulate wing.toml --view x.html --compare alone.csv",
    "simulate wing.toml --view x.html --compare pair.csv",
    "simulate wing.toml --view x.html --compare word.csv",
    "simulate wing.toml --view x.html --compare back.csv",
    "simulate wing.toml --view x.html --compare empty.csv",
    "simulate wing.toml --csv - --inputs rows.csv",
    "simulate wing.toml --csv - --inputs time.csv",
    "simulate wing.toml --csv - --inputs jump.csv",
    "simulate wing.toml --csv - --inputs first.csv",
    "simulate wing.toml --csv - --inputs twice.csv",
    "simulate wing.toml --csv - --inputs output.csv",
    "simulate wing.toml --csv - --inputs number.csv",
    "simulate wing.toml --csv - --inputs columns.csv",
    "simulate wing.toml --csv - --set solver.min_step=0.01 --set solver.max_step=0.02 --set solver.tolerance=1e-9",
    "simulate wing.toml --csv - --set solver.min_step=1e-4 --set solver.tolerance=1e-6",
    "simulate wing.toml --csv - --set solver.min_step=1",
    "simulate wing.toml --csv - --set fold.external_torque=1e25",
    "simulate wing.toml --csv - --set gravity.z=-1e300",
    "simulate wing.toml --csv - --start 1e17 --stop 1.1e17 --step 1e15",
    "linearize wing.toml -o x.csv",
    "linearize wing.toml --state never -o x.npz",
    "linearize pendulum.toml --state 0.01 -o x.npz",
    "static wing.toml --set fold.motor_stiffness=0 --set gravity.x=0 --set fold.latch_enable=0",
    "latency wing.toml --steps 1 --step 0",
    "latency wing.toml --steps 1 --turbulence -1",
    "simulate wing.toml --variables fould.*",
    "simulate wing.toml --compare one.csv",
    "simulate wing.toml --plot figures --compare wing.toml",
    "simulate - --inputs -",
    "simulate wing.toml --json --csv -",
    "static wing.toml --set gravity=0,-9.81",
    "static wing.toml --set gravity=0,0,down",
    "examples golan_wing.toml",
    "sweep wing.toml --samples - --output x.csv",
    "view page.html",
    "view missing.html",
    "view timeless.csv",
    "compare timeless.csv timeless.csv",
    "compare word.csv word.csv",
    "compare one.csv other_columns.csv",
    "compare one.csv later.csv",
    "compare later.csv wide.csv",
    "compare one.csv two.csv",
    "compare one.csv two.csv --rtol -1",
    "compare one.csv two.csv --tolerance a",
    "static four_bar.toml",
    "static pendulum.toml",
    "sweep wing.toml --vary fold.angle_command --output x.csv",
    "sweep wing.toml --vary fold.angle_command=1:2 --output x.csv",
    "sweep wing.toml --vary fold.angle_command=1,2 --output taken.csv",
    "sweep wing.toml --vary fold.angle_command=1,2 --output other.csv",
    "package wing.toml -o x.fmu --no-reference --library library.so",
    "package wing.toml -o x.fmu --no-reference --library linux128=library.so",
    "package wing.toml -o x.fmu --library none.so",
    "package wing.toml -o x.fmu --no-reference --library LIBRARY --library LIBRARY",
    "package wing.toml -o x.fmu --no-reference --library win64=LIBRARY",
    "package wing.toml -o x.fmu --no-reference --library COMMAND",
];

/// Mistakes with FMUs, if the build can run them. A `+` is a space inside a word.
const SLIPS_WITH_FMUS: &[&str] = if cfg!(feature = "import") {
    &[
        "run wing.toml --csv -",
        "run wing.fmu --csv - --tolerance 0",
        "run wing.fmu --csv - --set fold.angle=1",
        "run wing.fmu --csv - --set fold.start_angle=90+kg",
    ]
} else {
    &["run wing.fmu --csv -"]
};

/// A modal body, whose mass lies on its axis, on a hinge along that axis.
const SPINS: &str = r#"
name = "m"
[section.s]
shape = "ellipse"
width_m = 0.045
height_m = 0.0059
density_kg_m3 = 2300.0
youngs_modulus_Pa = 5.2e9
poisson_ratio = 0.3
[body.arm]
length_m = 0.57
section = "s"
elements = 1
[joint.mount]
type = "clamped"
parent = "root"
child = "arm"
[modal_body.blade]
length_m = 0.54
nodes = 5
stations = [0.0, 1.0]
mass_kg_m = [0.27, 0.17]
flap_stiffness_N_m2 = [5.5, 2.75]
edge_stiffness_N_m2 = [80.0, 80.0]
flap_shapes = [[1.5, -0.5]]
flap_damping_ratios = [0.03]
edge_shapes = [[1.5, -0.5]]
edge_damping_ratios = [0.03]
[joint.bearing]
type = "revolute"
axis = [1.0, 0.0, 0.0]
parent = "arm"
child = "blade"
"#;

/// Messages of the command for mistakes.
fn produced() -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &[u8]| fs::write(folder.path().join(name), text).unwrap();
    let shipped = |name: &str| fs::read_to_string(in_package("examples/models").join(name)).unwrap();
    let model = shipped("folding_wing.toml");
    write("wing.toml", model.as_bytes());
    let goland = shipped("goland_wing.toml");
    write(
        "sudden.toml",
        goland.replace("model = \"strip\"", "model = \"strip\"\nsteady_initial_flow = false").as_bytes(),
    );
    write("goland.toml", goland.as_bytes());
    write("tunnel.toml", shipped("folding_wing_in_tunnel.toml").as_bytes());
    let free = shipped("folding_wing_in_tunnel.toml").replace("model = \"uvlm\"", "model = \"uvlm\"\nfree_wake = true");
    write("free.toml", free.as_bytes());
    write("long.toml", shipped("folding_wing_in_tunnel.toml").replace("wake_rows = 30", "wake_rows = 3000").as_bytes());
    let gust = "\n[gust.early]\nshape = \"sharp_edge\"\nvelocity_m_s = [0.0, 0.0, 0.1]\norigin_m = [0.0, 0.0, 0.0]\n";
    write("blown.toml", (shipped("folding_wing_in_tunnel.toml") + gust).as_bytes());
    let aircraft = include_str!("../../../examples/flight/folding_aircraft.toml");
    write("aircraft.toml", aircraft.as_bytes());
    write("one_side.toml", include_bytes!("../../../examples/failures/one_side_unfolds.toml"));
    write("two_body.toml", include_bytes!("../../../examples/two_body.toml"));
    write("four_bar.toml", shipped("four_bar.toml").as_bytes());
    write("pendulum.toml", shipped("double_pendulum.toml").as_bytes());
    FILES.iter().for_each(|(name, text)| write(name, text));
    rotor_slips::files().iter().for_each(|(name, text)| write(name, text.as_bytes()));
    // a flap beyond its limits, a wing beyond the speed of sound, one below the ground
    let aileron = fs::read_to_string(in_package("examples/aileron/folding_aileron.toml")).unwrap();
    write("aileron.toml", aileron.as_bytes());
    let keys = |keys: &str| aileron.replace("indicial = \"fine\"", keys);
    write("fast.toml", keys("speed_of_sound_m_s = 10.0").as_bytes());
    let ground = "ground_normal = [0.0, 0.0, 1.0]\nground_distance_m = -1.0";
    write("low.toml", keys(ground).replace("\"strip\"", "\"uvlm\"").as_bytes());
    // profiles that are invalid for a lattice
    let polar = "[surface.inner]\npolar = [[-10.0, -1.0, 0.01, 0.0], [10.0, 1.0, 0.01, 0.0]]";
    let tunnel = shipped("folding_wing_in_tunnel.toml");
    write("no_suction.toml", tunnel.replace("[surface.inner]", polar).as_bytes());
    let drag = "speed_of_sound_m_s = 340.0\n\n[surface.inner]\ndrag_coefficient = 0.01";
    write("mach.toml", tunnel.replace("[surface.inner]", drag).as_bytes());
    // strips beyond stall, a wing beyond divergence, a body without inertia about the axis of its joint
    let stalls = "polar = [[-90.0, 0.0, 1.5, 0.0], [-12.0, -1.2, 0.02, 0.0], [12.0, 1.2, 0.02, 0.0], [20.0, 0.6, 0.2, 0.0], [90.0, 0.0, 1.5, 0.0]]";
    let incident = format!("{stalls}\nincidence_deg = 17.0\n");
    let stalled = ["[surface.inner]\n", "[surface.outer]\n"].iter().fold(tunnel.clone(), |text, surface| {
        assert!(text.contains(surface));
        text.replace(surface, &format!("{surface}{incident}"))
    });
    write("stalled.toml", stalled.replace("\nwake_rows", "\nleading_edge_suction = true\nwake_rows").as_bytes());
    write("diverges.toml", goland.replace("elastic_axis_fraction = 0.33", "elastic_axis_fraction = 0.5").as_bytes());
    write("spins.toml", SPINS.as_bytes());
    // a model whose own experiment fails, and one with a load at a position without a station
    let failing = model.replace("[simulation]", "[solver]\nmin_step_s = 1e-3\ntolerance = 1e-9\n[simulation]");
    write("failing.toml", failing.as_bytes());
    let brake = "[failure.x]\nkind = \"brake_applied\"\njoint = \"fold\"\ntorque_N_m = 1.0\n";
    let braked = format!("{brake}[solver]\nmethod = \"rk4\"\nfixed_step_s = 1e-4\n[simulation]");
    write("braked.toml", model.replace("[simulation]", &braked).as_bytes());
    let station = "[load.tip]\nbody = \"outer\"\nstation = 1\n[body.outer]\nload_stations = 0";
    write("loaded.toml", model.replace("[body.outer]", station).as_bytes());
    // more stations than the maximum for all bodies, and two arms that latch at the same instant
    let many = model.replace("elements = 4", "elements = 4\nload_stations = 1000");
    let third = "\n[body.third]\nlength_m = 0.1\nsection = \"plate\"\nelements = 1\nload_stations = 1000\n\
                 [joint.third]\ntype = \"clamped\"\nparent = \"outer\"\nchild = \"third\"\n";
    write("many.toml", (many + third).as_bytes());
    let twin = |body: &str, joint: &str| {
        format!(
            "[rigid_body.{body}]\nmass_kg = 1.0\ninertia_kg_m2 = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]\n\
             [joint.{joint}]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"{body}\"\naxis = [0.0, 0.0, 1.0]\n\
             start_angle_deg = 60.0\nmotor.constant_torque_N_m = 20.0\n\
             latch = {{ angle_deg = 0.0, stiffness_N_m_rad = 400.0 }}\n"
        )
    };
    let twins = format!("name = \"Twins\"\n{}{}[simulation]\n", twin("left", "port"), twin("right", "starboard"));
    write("twins.toml", format!("{twins}stop_time_s = 1.0\nstep_s = 0.01\n").as_bytes());

    // a linkage closed by constraint forces
    let penalty = "stiffness_N_m = 5e5\ndamping_N_s_m = 50.0\n";
    let bars = |closure: &str| {
        let text = shipped("four_bar.toml");
        assert_eq!(text.matches(penalty).count(), 2);
        text.replace(penalty, closure)
    };
    write("rigid_bars.toml", bars("rigid = true\n").as_bytes());
    write("open_bars.toml", bars("damping_N_s_m = 50.0\n").as_bytes());
    write("two_ways.toml", bars("rigid = true\nstiffness_N_m = 5e5\n").as_bytes());
    let weak = "[failure.pin]\nkind = \"loop_break\"\nloop = \"front\"\nat_time_s = 1.0\n\n[simulation]";
    write("weak_bars.toml", bars("rigid = true\n").replace("[simulation]", weak).as_bytes());

    // a castoring wheel, and starts and motions that contradict it
    let gear = include_str!("../../../examples/gear/castor.toml");
    write("gear.toml", gear.as_bytes());
    let (on_plane, at_rest) = ("radius_m = 0.125\naxis = [0.0, 0.0, 1.0]", "step_s = 2e-3\nstart = \"equilibrium\"");
    write("gear_off_plane.toml", gear.replace("radius_m = 0.125", "radius_m = 0.1").as_bytes());
    write("gear_flat.toml", gear.replace("radius_m = 0.125", on_plane).as_bytes());
    write("gear_at_rest.toml", gear.replace("step_s = 2e-3", at_rest).as_bytes());
    let slips = "name = \"Slips\"\n[rigid_body.block]\nmass_kg = 1.0\n[joint.rail]\ntype = \"prismatic\"\nparent = \"root\"\n\
                 child = \"block\"\naxis = [0, 1, 0]\nmotion = \"prescribed\"\npolynomial_m = [0.0, 0.5]\n\
                 [skate.blade]\nbody = \"block\"\n";
    write("gear_slips.toml", slips.as_bytes());

    let strut = include_str!("../../verification/plant/cylindrical.toml");
    let of_both = "parent_offset_m = [0.1, 0.2, 0.3]\nspring.stiffness_N_m = 3.0";
    write("strut.toml", strut.replace("parent_offset_m = [0.1, 0.2, 0.3]", of_both).as_bytes());

    // a body that slides along a beam, with parts that exclude it
    let rail = include_str!("../../verification/plant/sliding.toml");
    let reaches = |old: &str, new: &str| {
        assert!(rail.contains(old), "{old}");
        rail.replace(old, new)
    };
    write("rail.toml", rail.as_bytes());
    write("rail_on_root.toml", reaches("parent = \"beam\"", "parent = \"root\"").as_bytes());
    let second = "[rigid_body.second]\n[joint.second]\ntype = \"sliding\"\nparent = \"bead\"\nchild = \"second\"\n\
                  start_position_m = 0.0\n[gauge.root]\nbody = \"beam\"\nposition_m = 0.1\n[solver]";
    write("rail_on_bead.toml", reaches("[solver]", second).as_bytes());
    let outside = "parent_position_m = 0.5\nstart_position_m = 1.5";
    write("rail_outside.toml", reaches("start_position_m = 0.25", outside).as_bytes());
    write(
        "rail_turned.toml",
        reaches("start_position_m = 0.25", "start_position_m = 0.25\nstart_angle_deg = 3.0").as_bytes(),
    );
    write("rail_fine.toml", reaches("elements = 4", "elements = 200").as_bytes());
    let free = |text: &str| {
        text.replace("type = \"sliding\"", "type = \"clamped\"")
            .replace("start_position_m = 0.25", "parent_position_m = 1.0")
    };
    write("rail_clamped.toml", free(&reaches("load_stations = 0", "modal_damping_ratios = [0.1, 0.2]")).as_bytes());
    let bead = "\n[rigid_body.bead]\nmass_kg = 0.1\ninertia_kg_m2 = [1e-4, 1e-4, 1e-4, 0.0, 0.0, 0.0]\n[joint.rail]\ntype = \"sliding\"\n\
                parent = \"right_wing\"\nchild = \"bead\"\nstart_position_m = 0.5\n";
    let propellers = include_str!("../../../examples/airs/wing_with_propellers.toml");
    write("rail_rotor.toml", (propellers.to_owned() + bead).as_bytes());
    write("rail_damped.toml", reaches("load_stations = 0", "modal_damping_ratios = [0.1, -0.1]").as_bytes());
    write("rail_with_ratios.toml", reaches("load_stations = 0", "modal_damping_ratios = [0.1, 0.2]").as_bytes());
    // more ratios than a body has strains
    let ratios = format!("elements = 1\nmodal_damping_ratios = {:?}", [0.1; 12]);
    write("ratios.toml", model.replace("elements = 4", &ratios).as_bytes());

    let library = crate::guide::commands::library().to_str().unwrap().to_owned();
    let call = |line: &str| {
        let line = line.replace("LIBRARY", &library).replace("COMMAND", env!("CARGO_BIN_EXE_foldwing"));
        let words: Vec<String> = line.split(' ').map(|word| word.replace('+', " ")).collect();
        foldwing(folder.path(), &words)
    };
    // an FMU, and results of a sweep that another sweep would overwrite
    for line in [
        "package wing.toml -o wing.fmu --no-reference --library LIBRARY",
        "sweep wing.toml --vary fold.angle_command=1,2 --stop 0.001 --output done.csv",
    ] {
        assert!(call(line).status.success(), "{line}");
    }
    let more = [
        "static aircraft.toml",
        "check open_bars.toml",
        "check two_ways.toml",
        "check weak_bars.toml",
        "modes rigid_bars.toml",
        "linearize rigid_bars.toml --state start -o x.npz",
        "check rail_with_ratios.toml",
        "check ratios.toml",
        "package rigid_bars.toml --interface me -o x.fmu",
        "modes gear.toml",
        "package gear.toml --interface me -o x.fmu",
        "check gear_off_plane.toml",
        "check gear_flat.toml",
        "check gear_at_rest.toml",
        "simulate gear_slips.toml",
        "check rail_rotor.toml",
        "check rail_on_root.toml",
        "check rail_on_bead.toml",
        "check rail_outside.toml",
        "check rail_turned.toml",
        "check strut.toml",
        "check rail_damped.toml",
        "check rail_clamped.toml",
        "static rail_fine.toml",
        "simulate rail.toml --set slide.start_position=0.5 --stop 10",
        "package rail.toml --interface me -o rail.fmu",
        "linearize stalled.toml --lattice -o x.json",
        "static diverges.toml --set wind.velocity.y=-200",
        "static spins.toml",
        "check no_suction.toml",
        "check mach.toml",
        "check braked.toml",
        "flutter goland.toml --wind-m-s 5",
        "flutter goland.toml --wind-m-s a,b",
        "flutter goland.toml --wind-m-s 0:1:2",
        "flutter goland.toml --wind-m-s 1:1e9:100000",
        "flutter wing.toml --wind-m-s 1:2:2",
        "linearize tunnel.toml --lattice --state 0.01 -o x.json",
        "linearize wing.toml --lattice -o x.json",
        "linearize tunnel.toml --lattice --set root.angular_velocity.z=1 -o x.json",
        "linearize tunnel.toml --lattice --set wind.velocity.y=-0.01 -o x.json",
        "linearize tunnel.toml --lattice --modes 4 -o x.json",
        "linearize free.toml --lattice -o x.json",
        "linearize long.toml --lattice -o x.json",
        "linearize blown.toml --lattice -o x.json",
        "modes tunnel.toml --lattice --state undeformed",
        "flutter sudden.toml --wind-m-s 1:2:2",
        "flutter goland.toml --wind-m-s 1:2:2 --set wind.velocity.y=0",
        "modes wing.toml --vary file:solver.method=esdirk3,esdirk4",
        "modes wing.toml --vary fold.angle_command=1",
        "trim wing.toml --solve-for fold.angle_command,-fold.angle_command --target tip.position.z=0",
        "trim wing.toml --solve-for fold.angle_command --solve-for fold.external_torque --target tip.position.z=0 --target tip.position.z=1",
        "trim wing.toml --solve-for fold.angle_command --target tip.position.z",
        "trim wing.toml --solve-for fold.angle_command --target fold.angle_command=1",
        "trim wing.toml --solve-for fold.angle_command --target tip.position.z=x",
        "trim wing.toml --solve-for fold.angle_command --solve-for fold.external_torque --target tip.position.z=0",
        "trim wing.toml --solve-for fold.release --target tip.position.z=0",
        "trim wing.toml --solve-for fold.angle_command --target energy.kinetic=1",
        "trim wing.toml --solve-for attitude.pitch --target tip.position.z=0",
        "trim wing.toml --solve-for fold.angle_command,fold.external_torque --target tip.position.z=0",
        "trim tunnel.toml --solve-for turn.rate --target tip.position.z=0",
        "linearize tunnel.toml --lattice --inputs wind.velocity.z --outputs gauge. --reduce 4 --max-frequency 0 -o x.json",
        "modes wing.toml --csv x.csv",
        "live wing.toml --speed 0",
        "live wing.toml --state goland.toml",
        "gradient tunnel.toml --of tip.position.z --by aero.density",
        "gradient wing.toml --of fold.angle@x --by fold.motor_damping",
        "gradient wing.toml --of fold.angle@1 --by fold.motor_damping",
        "gradient wing.toml --of , --by fold.motor_damping",
        "gradient wing.toml --of fold.angle --by fold.motor_damping,fold.motor_damping",
        "gradient wing.toml --of fold.angle --by fold.release",
        "gradient wing.toml --of fold.angle --by solver.tolerance",
        "gradient wing.toml --of fold.angle --by file:simulation.stop_time_s",
        "gradient wing.toml --of fold.angle --by file:aerodynamics.coupling_tolerance",
        "gradient wing.toml --of fold.angle --by file:body.inner",
        "gradient wing.toml --of fold.angle --by file:body.inner.colour",
        "gradient wing.toml --of fold.angle --by file:gravity_m_s2",
        "gradient wing.toml --of fold.angle --by file:gravity_m_s2.3",
        "gradient wing.toml --of fold.angle --by file:name",
        "gradient wing.toml --of fold.latch_time --by fold.motor_damping --stop 0.1",
        "gradient wing.toml --of fold.angle --by fold.external_torque --inputs push.csv",
        "gradient wing.toml --of fold.angle --by fold.external_torque@0.1 --inputs push.csv",
        "gradient wing.toml --of fold.angle --by fold.external_torque@0.1-,fold.external_torque@* --inputs push.csv",
        "gradient wing.toml --of fold.angle --by fold.external_torque@0.2 --inputs push.csv",
        "gradient wing.toml --of fold.angle --by fold.external_torque@0- --inputs push.csv",
        "gradient wing.toml --of fold.angle --by fold.external_torque@now --inputs push.csv",
        "gradient wing.toml --of fold.angle --by fold.damping@0 --inputs push.csv",
        "gradient wing.toml --of fold.angle --by fold.external_torque@0",
        "gradient wing.toml --of fold.angle --by file:body.inner.length_m",
        "gradient twins.toml --of port.latch_time --by port.motor_damping",
        "check many.toml",
        "sweep wing.toml --vary file:gravity_m_s2.3=1 --output y.csv",
        "sweep wing.toml --vary file:name.first=1 --output y.csv",
        "static aileron.toml --set aero.control_surface.aileron.angle_command=1",
        "static fast.toml",
        "static low.toml",
        "linearize tunnel.toml --inputs wind.velocity.z -o x.json",
        "linearize wing.toml --inputs gust.z -o x.json",
        "linearize goland.toml --reduce 9999 -o x.json",
        "sweep wing.toml --vary fold.angle_command=1,3 --stop 0.001 --output done.csv",
        "check loaded.toml",
        "package tunnel.toml --interface me -o x.fmu --library LIBRARY",
        "package failing.toml -o x.fmu --library LIBRARY",
    ];
    let slips = SLIPS.iter().chain(SLIPS_WITH_FMUS).chain(&more).chain(rotor_slips::LINES);
    // the command shows the parts of a file's error separately; importers log it as a line
    let whole = FILES.iter().filter(|(name, _)| name.ends_with(".toml")).filter_map(|(name, text)| {
        Some(foldwing::config::parse(std::str::from_utf8(text).ok()?, name).err()?.to_string())
    });
    let said = slips.map(|line| {
        let output = call(line);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && stderr.starts_with("error: "), "{line} succeeds\n{stderr}");
        stderr
    });
    // warnings and verdicts of runs that succeed
    let lines = [
        "static stalled.toml",
        "static one_side.toml",
        "static two_body.toml",
        "simulate stalled.toml --stop 0.02",
        "linearize wing.toml --state 0.45 -o x.npz",
        "linearize wing.toml --reduce 2 -o x.json",
        "linearize wing.toml --inputs fold.external_torque --outputs gauge.root.strain,tip.position.z --reduce 2 --max-frequency 40 -o x2.json",
    ];
    let warned = lines.map(|line| {
        let output = call(line);
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
        format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
    });
    // polars that cannot be extended
    let polars = [
        "[-10, -0.5, 0.1, 0], [100, 0.5, 0.5, 0]",
        "[-100, 0, 0.5, 0], [20, 1, 0.2, 0]",
        "[-20, 0, 0.1, 0], [20, 1, 3.2, 0]",
        "",
    ];
    let extended = polars.iter().map(|rows| {
        let text = crate::guide::variables::ROTOR
            .replace("[-180, 0, 0.5, 0], [180, 0, 0.5, 0]]", &format!("{rows}]\naspect_ratio = 10"));
        foldwing::config::parse(&text, "rotor.toml").expect_err(rows).to_string()
    });
    // errors that only programs can cause
    let motor = |inductance_h: f64, gear_ratio: f64| DcMotor {
        resistance_ohm: 1.0,
        inductance_h,
        torque_constant_n_m_a: 0.1,
        gear_ratio,
        voltage_v: 0.0,
        start_current_a: 0.0,
    };
    let built = |joint: JointBuilder| {
        let arm = Body::rigid("arm").inertia(1.0, [0.1, 0.0, 0.0], nalgebra::Matrix3::identity());
        Machine::builder("motor").body(arm, joint).build().expect_err("a motor").to_string()
    };
    let motors = [
        built(Joint::revolute("hinge", [0.0, 1.0, 0.0]).dc_motor(motor(0.0, 1.0))),
        built(Joint::prismatic("slide", [1.0, 0.0, 0.0]).dc_motor(motor(1e-3, 2.0))),
    ];
    let one = || nalgebra::DMatrix::from_element(1, 1, -1.0);
    let model = foldwing::plant::StateSpace { a: one(), b: one(), c: one(), d: one() };
    let modal = foldwing::plant::reduce(&model, 1, foldwing::plant::Keep::Modes, Some(50.0)).expect_err("a band");
    said.chain(warned)
        .chain(whole)
        .chain(extended)
        .chain(rotor_slips::refused())
        .chain([modal.to_string()])
        .chain(motors)
        .collect()
}

/// F-247. Every message quoted by the page is one of the program's: most are produced, the others are found in the source.
#[test]
fn f247_quoted_messages_are_the_programs() {
    let (model_file, calls) = asserted();
    assert!(model_file.len() > 100 && calls.len() > 40, "{} and {}", model_file.len(), calls.len());
    let said: Vec<String> = produced().into_iter().chain(model_file).chain(calls).collect();
    let source = literals_below("crates");
    let (mut seen, mut read, mut unknown) = (0, Vec::new(), Vec::new());
    for quote in quotes() {
        let from_function = quote.text.split_once(": ").filter(|(function, _)| function.starts_with("fmi2"));
        let text = Quote::new("", from_function.map_or(quote.text.as_str(), |(_, text)| text));
        // tests of instances compare the text after the function's name
        if said.iter().any(|message| quote.is_in(message) || text.is_in(message)) {
            seen += 1;
        } else if source.iter().any(|literal| text.is_in(literal)) {
            read.push(quote.text);
        } else {
            unknown.push(format!("{} ({})", quote.text, quote.section));
        }
    }
    assert!(unknown.is_empty(), "nothing says\n{}", unknown.join("\n"));
    println!("{seen} quoted messages were produced, {} stand in the source:\n{}", read.len(), read.join("\n"));
    assert!(seen > 5 * read.len(), "{seen} were produced, {} stand in the source", read.len());
}

/// Whether the pieces of a formatted text occur in this order.
fn in_order(pieces: &[&str], text: &str) -> bool {
    let mut rest = text;
    for piece in pieces {
        let Some(place) = rest.find(piece) else { return false };
        rest = &rest[place + piece.len()..];
    }
    true
}

/// F-248. The same pieces in another order are a different message.
#[test]
fn f248_a_quote_is_the_message_itself() {
    assert!(in_order(&["the mass of ", " is not positive"], "the mass of body 'a' is not positive"));
    assert!(!in_order(&[" is not positive", "the mass of "], "the mass of body 'a' is not positive"));
    assert!(!in_order(&["mass of ", "mass of "], "the mass of body 'a' is not positive"));
}

/// F-248. No message is missing: each error in a model file known to the tests, and each text of an error type.
#[test]
fn f248_every_message_of_the_program_is_quoted() {
    let quotes = quotes();
    let (model_file, _) = asserted();
    let mut missing = Vec::new();
    for message in model_file {
        let general = |quote: &&Quote| quote.text.contains("key '…'");
        let quoted = match message.split_once("allowed: ") {
            Some((_, allowed)) => quotes.iter().filter(|quote| !general(quote)).any(|quote| quote.is_in(allowed)),
            None => quotes.iter().any(|quote| quote.is_in(&message)),
        };
        if !quoted {
            missing.push(message);
        }
    }
    let mut files = Vec::new();
    for folder in fs::read_dir(in_package("crates")).unwrap() {
        let folder = folder.unwrap().path();
        // errors of studies name fields of their options; the page uses the command's words for them
        if !folder.ends_with("study") {
            sources(&folder, &mut files);
        }
    }
    let mut count = 0;
    for attribute in files.iter().flat_map(|file| file.split("#[error(").skip(1)) {
        let Some(text) = literals(attribute.split(")]").next().unwrap()).into_iter().next() else { continue };
        // a text that only passes on another one
        let own = text.chars().filter(|c| c.is_alphabetic()).count() > 3;
        if !own || INTERNAL.iter().any(|internal| text.starts_with(internal)) {
            continue;
        }
        count += 1;
        let words: Vec<&str> = text.split('…').collect();
        let quoted = quotes.iter().any(|quote| {
            let quote = Quote::new(
                "",
                quote
                    .text
                    .split_once(": ")
                    .filter(|(f, _)| f.starts_with("fmi2"))
                    .map_or(&quote.text, |(_, text)| text),
            );
            // either may be shorter: the page fills in fields of the format, or omits its end
            quote.is_in(&text) || in_order(&words, &quote.text)
        });
        if !quoted {
            missing.push(text);
        }
    }
    assert!(count > 50, "{count} texts of errors");
    assert!(missing.is_empty(), "docs/guide/messages.md does not know\n{}", missing.join("\n"));
}

/// Texts that are never shown to users unchanged: they are parts of other messages, or end a command silently.
const INTERNAL: &[&str] = &[
    "standard output was closed",
    "figure `…`",
    // the page quotes it with each of its causes
    "…:…: column …",
    "the pivot of coordinate",
    "the static tangent is singular",
    // its cause and location become a message with the joint's name
    "no stiffness in coordinate",
    "no convergence in … iterations, last correction",
    "the residual is not finite in iteration",
    "no equilibrium beyond the load factor …",
    // the times come from names of results, which are checked before
    "the requested times must increase from the current time",
];

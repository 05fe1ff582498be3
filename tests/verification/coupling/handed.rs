//! Surfaces as defined in model files: wings and their mirror images, edges along flared hinges.

use crate::coupling::wings::start;
use foldwing::config;
use foldwing::machine::Machine;
use nalgebra::{Rotation3, Unit, Vector3};

const SPAR: &str = "name = \"Wing\"\n[section.spar]\nshape = \"explicit\"\naxial_stiffness_N = 1e8\ntorsional_rigidity_N_m2 = 1e4\n\
    flap_stiffness_N_m2 = 1e4\nedge_stiffness_N_m2 = 1e5\nmass_kg_m = 1.0\nsecond_moments_kg_m = [1e-4, 0.0, 1e-4]\n\
    [simulation]\nstop_time_s = 0.1\nstep_s = 0.01\nstart = \"unstrained\"\n";

fn machine(text: &str) -> Machine {
    config::parse(text, "wing.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Force and moment at the root in N and N·m of a half wing after three steps with aerodynamics, or of its mirror image on the other side.
fn half(air: &str, profile: &str, mirrored: bool) -> [f64; 6] {
    let (turn, side) = if mirrored { ("[0, 0, 180]", "-y") } else { ("[0, 0, 0]", "+y") };
    let text = format!(
        "{SPAR}[body.wing]\nlength_m = 2.0\nsection = \"spar\"\nelements = 2\n[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\n\
         child = \"wing\"\nmount_rotation_deg = {turn}\n[aerodynamics]\n{air}\nwind_m_s = [0, -20, 1]\n[surface.wing]\nbody = \"wing\"\n\
         chord_m = 0.5\nelastic_axis_fraction = 0.3\nstrips = 6\nincidence_deg = 2\nleading_edge = \"{side}\"\n{profile}\n"
    );
    let mut plant = start(machine(&text));
    plant.step(0.03).unwrap_or_else(|error| panic!("{error}"));
    let root = plant.outputs().root();
    let (force, moment) = (root.force_n, root.moment_n_m);
    [force.x, force.y, force.z, moment.x, moment.y, moment.z]
}

/// U-65. A wing and its mirror image, whose leading edge is on the side of `-y`, have the same forces and moments, mirrored. Profiles with
/// camber, moment or a polar used to be upside down on one of the two.
#[test]
fn u65_mirror_images_carry_alike() {
    let polar = "polar = [[-20.0, -1.2, 0.05, -0.02], [-4.0, 0.0, 0.01, -0.05], [10.0, 1.3, 0.02, -0.06], [20.0, 1.0, 0.2, -0.1]]";
    let cambered = "zero_lift_angle_deg = -4\nmoment_coefficient = -0.08\ndrag_coefficient = 0.02";
    for (air, profile) in [
        ("model = \"strip\"", ""),
        ("model = \"strip\"", cambered),
        ("model = \"strip\"", polar),
        ("model = \"strip\"\ntip_loss = \"lifting_line\"", cambered),
        ("model = \"uvlm\"\nleading_edge_suction = true", ""),
        ("model = \"uvlm\"\nleading_edge_suction = true", cambered),
        ("model = \"uvlm\"\nleading_edge_suction = true", polar),
    ] {
        let [own, image] = [false, true].map(|mirrored| half(air, profile, mirrored));
        let signs = [-1.0, 1.0, 1.0, 1.0, -1.0, -1.0];
        let largest = own.iter().fold(0.0f64, |largest, value| largest.max(value.abs()));
        let error = own.iter().zip(&image).zip(signs).map(|((a, b), sign)| (a - sign * b).abs()).fold(0.0, f64::max);
        println!("U-65 {air:?} {profile:?}: lift {:.3} N, difference {:.1e}", own[2], error / largest);
        // the implicit steps of the two end with different round-off
        assert!(error < 1e-9 * largest, "{air} {profile}: {own:?} {image:?}");
    }
}

/// A wing with a tip on a hinge flared by 20 deg and held at an angle; `flare` are the lines added to the surfaces, `more` is the factor on
/// the number of strips.
fn flared(fold_deg: f64, [inner, tip]: [&str; 2], more: usize, air: &str) -> Machine {
    let axis = [20f64.to_radians().sin(), 20f64.to_radians().cos()];
    let spar = SPAR.replace("unstrained", "equilibrium");
    machine(&format!(
        "{spar}[body.inner]\nlength_m = 0.36\nsection = \"spar\"\nelements = 1\n[body.tip]\nlength_m = 0.14\nsection = \"spar\"\n\
         elements = 1\n[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"inner\"\nmount_rotation_deg = [10, 0, 0]\n\
         [joint.fold]\ntype = \"revolute\"\nparent = \"inner\"\nchild = \"tip\"\naxis = [{}, {}, 0]\nmotion = \"locked\"\n\
         start_angle_deg = {fold_deg}\n[aerodynamics]\n{air}\nwind_m_s = [0, -18, 0]\n\
         [surface.inner]\nbody = \"inner\"\nchord_m = 0.08\nelastic_axis_fraction = 0.25\nstrips = {}\n{inner}\n\
         [surface.tip]\nbody = \"tip\"\nchord_m = 0.08\nelastic_axis_fraction = 0.25\nstrips = {}\n{tip}\n",
        axis[0],
        axis[1],
        9 * more,
        4 * more
    ))
}

const ALONG_THE_HINGE: [&str; 2] = [
    "flare_deg = { table = [[0.0, 0.0], [0.22, 0.0], [0.36, 20.0]] }",
    "flare_deg = { table = [[0.0, 20.0], [0.14, 0.0]] }",
];
const LATTICE: &str = "model = \"uvlm\"\nmirror_normal = [1, 0, 0]";

/// U-64. Edges normal to the bodies separate as a flared hinge folds, and a lattice with narrower strips resolves a wider gap: the hinge
/// torque does not converge. With `flare_deg` both edges lie on the hinge at every angle, and the torque converges.
#[test]
fn u64_edges_along_a_flared_hinge_stay_together() {
    let air = flared(0.0, ALONG_THE_HINGE, 1, LATTICE).air.expect("air");
    let (last, first) = (air.surfaces[0].chords.last().expect("chords"), &air.surfaces[1].chords[0]);
    let axis = Unit::new_normalize(Vector3::new(20f64.to_radians().sin(), 20f64.to_radians().cos(), 0.0));
    for fold_deg in [-90.0f64, -30.0, 10.0, 60.0, 120.0] {
        let fold = Rotation3::from_axis_angle(&axis, fold_deg.to_radians());
        for (inner_m, tip_m) in [(last.leading_m, first.leading_m), (last.trailing_m, first.trailing_m)] {
            assert!((inner_m - fold * tip_m).norm() < 1e-15, "{fold_deg} deg");
        }
        // the component of the chord across the body is unchanged
        assert!((last.leading_m.y - last.trailing_m.y - 0.08).abs() < 1e-15);
    }
    // torque about the hinge in mN m, lift in N
    let held = |fold_deg: f64, edges: [&str; 2], more: usize| {
        let plant = start(flared(fold_deg, edges, more, LATTICE));
        [1e3 * plant.outputs().joints()[0].holding_torque_n_m, plant.outputs().root().force_n.z]
    };
    for fold_deg in [0.0, -40.0] {
        let [along, across] =
            [ALONG_THE_HINGE, ["", ""]].map(|edges| [1, 2, 4].map(|more| held(fold_deg, edges, more)));
        let change = |held: [[f64; 2]; 3], from: usize| (held[from + 1][0] - held[from][0]).abs();
        println!("U-64 fold {fold_deg}: along the hinge {along:.4?}, across the bodies {across:.4?}");
        // converges with first order or better
        assert!(change(along, 0) > 1.5 * change(along, 1), "{fold_deg}: {along:?}");
        if fold_deg == 0.0 {
            // one planar wing, divided in two ways; slanted panels differ because there are only four along the chord
            assert!((along[2][1] / across[2][1] - 1.0).abs() < 5e-3, "{along:?} {across:?}");
        } else {
            assert!(change(across, 1) > 3.0 * change(along, 1), "the gap makes no difference: {across:?}");
        }
    }
    let strips = "model = \"strip\"";
    let [along, across] =
        [ALONG_THE_HINGE, ["", ""]].map(|edges| flared(-40.0, edges, 1, strips).air.expect("air").surfaces);
    assert_eq!(along, across, "strips lie across the bodies");
}

/// Chordwise lines that would intersect are rejected, with the location of the intersection.
#[test]
fn flare_that_crosses_lines_is_refused() {
    let text = format!(
        "{SPAR}[body.wing]\nlength_m = 1.0\nsection = \"spar\"\nelements = 1\n[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\n\
         child = \"wing\"\n[aerodynamics]\nmodel = \"uvlm\"\nwind_m_s = [0, -18, 0]\n[surface.wing]\nbody = \"wing\"\nchord_m = 0.4\n\
         strips = 10\n"
    );
    for (flare, told) in [
        (
            "{ table = [[0.0, 0.0], [0.8, 0.0], [1.0, 60.0]] }",
            "key 'surface.wing.flare_deg': chord lines that meet between ",
        ),
        ("{ table = [[0.0, 0.0], [1.0, 80.0]] }", "key 'surface.wing.flare_deg': angles from 0 to 80 on the body"),
        ("-76", "key 'surface.wing.flare_deg': -76 is not allowed; allowed: "),
    ] {
        let error = config::parse(&format!("{text}flare_deg = {flare}\n"), "wing.toml").expect_err(flare).to_string();
        assert!(error.contains(told), "{error}");
    }
    machine(&format!("{text}flare_deg = 45\n"));
}

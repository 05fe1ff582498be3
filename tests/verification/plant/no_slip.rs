//! Skates and wheels: velocity-dependent joints against closed forms, with energy accounts, rollback and refusals.

use crate::counting_allocator::allocations;
use foldwing::config;
use foldwing::machine::{Machine, NoSlip, Runner, StartState};
use foldwing::plant::{Holding, NotHybrid, Plant};
use nalgebra::{Rotation3, Vector3};
use std::sync::Arc;

fn machine(text: &str) -> Machine {
    config::parse(text, "no_slip.toml").unwrap_or_else(|error| panic!("{error}"))
}

fn started(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.initialize(plant.machine().experiment.start_time_s).unwrap_or_else(|error| panic!("{error}"));
    plant
}

fn step(plant: &mut Plant, time_s: f64) {
    plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
}

fn array(values: Vector3<f64>) -> String {
    format!("[{:?}, {:?}, {:?}]", values.x, values.y, values.z)
}

const CASTOR: &str = include_str!("../../../examples/gear/castor.toml");
const GRAVITY: [f64; 3] = [1.7, 0.0, -9.5];
const MASS_KG: f64 = 2.0;
const SPIN_RAD_S: f64 = 2.0;

/// A skate under the centre of mass of a rigid body on a slope whose downhill direction is `x`; the heading turns uniformly.
fn sleigh(solver: &str) -> Machine {
    machine(&format!(
        r#"
name = "Sleigh"
gravity_m_s2 = [{}, {}, {}]

[rigid_body.sleigh]
mass_kg = {MASS_KG}
inertia_kg_m2 = [0.1, 0.15, 0.2, 0.0, 0.0, 0.0]

[joint.free]
type = "free"
parent = "root"
child = "sleigh"
start_angular_velocity_deg_s = [0.0, 0.0, {:?}]

[skate.blade]
body = "sleigh"

[solver]
{solver}

[simulation]
stop_time_s = 2.0
step_s = 0.1
"#,
        GRAVITY[0],
        GRAVITY[1],
        GRAVITY[2],
        SPIN_RAD_S.to_degrees()
    ))
}

/// Error of the skate on a slope at 2 s: position in m, force relative to the weight; and the largest slip and height on the way.
fn sleigh_errors(solver: &str) -> [f64; 4] {
    let mut plant = started(sleigh(solver));
    let mut worst = [0.0f64; 4];
    for index in 1..=20 {
        let time_s = 0.1 * f64::from(index);
        step(&mut plant, time_s);
        let (w, g) = (SPIN_RAD_S, GRAVITY[0]);
        let angle = w * time_s;
        let reach_m = g / (2.0 * w * w);
        let exact_m = Vector3::new(reach_m * angle.sin().powi(2), reach_m * (angle - (2.0 * angle).sin() / 2.0), 0.0);
        let own = plant.outputs().no_slips()[0];
        let side_n = 2.0 * MASS_KG * g * angle.sin();
        worst[0] = worst[0].max((plant.outputs().tips()[0].position_m - exact_m).norm());
        let miss_n = (own.side_force_n - side_n).abs().max((own.normal_force_n + MASS_KG * GRAVITY[2]).abs());
        worst[1] = worst[1].max(miss_n / (MASS_KG * g));
        worst[2] = worst[2].max(own.slip_m_s);
        worst[3] = worst[3].max(own.height_m.abs());
    }
    worst
}

/// WH-01. A skate on a slope with a uniformly turning heading: `x = g'/(2w²) sin² wt`, `y = g'/(2w²)(wt − sin(2wt)/2)` to 1e-8 m, the side
/// force `2 m g' sin wt`; each method converges with its order over the steps; neither slip nor height.
#[test]
fn wh01_skate_on_a_slope() {
    for (method, least) in
        [("esdirk4", 3.7), ("rk4", 3.7), ("esdirk3", 2.7), ("tr_bdf2", 1.8), ("generalized_alpha", 1.8)]
    {
        let errors: Vec<[f64; 4]> = [0.05, 0.025, 0.0125]
            .iter()
            .map(|step_s| sleigh_errors(&format!("method = \"{method}\"\ntolerance = 1e-12\nfixed_step_s = {step_s}")))
            .collect();
        let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0][0] / pair[1][0]).log2()).collect();
        println!("WH-01 {method}: {errors:?}, orders {orders:.2?}");
        assert!(orders.iter().all(|order| *order > least), "{method}: orders {orders:?}, errors {errors:?}");
        assert!(errors.iter().all(|own| own[2] < 1e-14 && own[3] < 1e-14), "{method}: {errors:?}");
    }
    let fine = sleigh_errors("tolerance = 1e-10");
    println!("WH-01 at tolerance 1e-10: {fine:?}");
    assert!(fine[0] < 1e-8 && fine[1] < 1e-6, "{fine:?}");
}

/// Disc on a plane with a free joint: mass, radius, moments about axis and diameter.
const DISC: (f64, f64, f64, f64) = (3.0, 0.25, 0.11, 0.06);

/// The disc of [`DISC`] with its axis inclined by `lean_rad` and its centre at a height such that it touches the plane; everything rotated by
/// `turn`.
fn disc(gravity: [f64; 3], lean_rad: f64, [spin, velocity]: [Vector3<f64>; 2], turn: Rotation3<f64>) -> Machine {
    let (mass_kg, radius_m, axial, lateral) = DISC;
    let mount = turn * Rotation3::from_axis_angle(&Vector3::x_axis(), -lean_rad);
    let from_m = Vector3::new(0.3, -0.2, 0.15);
    machine(&format!(
        r#"
name = "Disc"
gravity_m_s2 = {}

[rigid_body.disc]
mass_kg = {mass_kg}
inertia_kg_m2 = [{lateral}, {axial}, {lateral}, 0.0, 0.0, 0.0]

[joint.free]
type = "free"
parent = "root"
child = "disc"
root_position_m = {}
mount_rotation_deg = {}
start_angular_velocity_deg_s = {}
start_velocity_m_s = {}

[wheel.tyre]
body = "disc"
radius_m = {radius_m}
plane_normal = {}
plane_point_m = {}

[solver]
tolerance = 1e-10

[simulation]
stop_time_s = 3.0
step_s = 0.1
"#,
        array(turn * Vector3::from(gravity)),
        array(turn * (from_m + Vector3::z() * (radius_m * lean_rad.cos()))),
        array(mount.scaled_axis().map(f64::to_degrees)),
        array((turn * spin).map(f64::to_degrees)),
        array(turn * velocity),
        array(turn * Vector3::z()),
        array(turn * from_m),
    ))
}

/// WH-02. An upright disc rolls down a slope with the acceleration `g sin α / (1 + I/(m r²))`; the rolling force is `−I a/r²`.
#[test]
fn wh02_disc_rolls_down_a_slope() {
    let (mass_kg, radius_m, axial, _) = DISC;
    let mut plant = started(disc([2.0, 0.0, -9.0], 0.0, [Vector3::zeros(); 2], Rotation3::identity()));
    let begin_m = plant.outputs().tips()[0].position_m;
    let rate = 2.0 / (1.0 + axial / (mass_kg * radius_m * radius_m));
    step(&mut plant, 1.5);
    let way_m = plant.outputs().tips()[0].position_m - begin_m;
    let spin = plant.outputs().tips()[0].angular_velocity_rad_s;
    let own = plant.outputs().no_slips()[0];
    let miss_m = (way_m - Vector3::x() * (0.5 * rate * 1.5 * 1.5)).norm();
    println!("WH-02 off by {miss_m:.1e} m, {own:?}");
    assert!(miss_m < 1e-9, "{miss_m:.1e} m");
    assert!((spin - Vector3::y() * (rate * 1.5 / radius_m)).norm() < 1e-8, "{spin}");
    assert!((own.rolling_force_n + axial * rate / radius_m.powi(2)).abs() < 1e-7, "{own:?}");
    assert!((own.normal_force_n - 9.0 * mass_kg).abs() < 1e-7 && own.side_force_n.abs() < 1e-7, "{own:?}");
}

/// Spin about the axis relative to the plane, angular velocity and velocity of the centre of a disc of [`DISC`] that leans by `lean_rad` and
/// rolls steadily in a circle with `turn_rad_s`.
fn steady(lean_rad: f64, turn_rad_s: f64) -> (f64, [Vector3<f64>; 2]) {
    let (mass_kg, radius_m, axial, lateral) = DISC;
    let push = mass_kg * 9.81 * radius_m * lean_rad.tan() / turn_rad_s - lateral * turn_rad_s * lean_rad.sin();
    let own = push / (axial + mass_kg * radius_m * radius_m);
    let axis = Vector3::new(0.0, lean_rad.cos(), -lean_rad.sin());
    let spin = Vector3::z() * turn_rad_s + axis * (own + turn_rad_s * lean_rad.sin());
    (own, [spin, Vector3::x() * (radius_m * own)])
}

/// WH-03. A leaning disc rolls in a circle, with the spin of the closed form: it keeps its lean, its centre follows the circle, and the side
/// force is the centripetal one. In a rotated frame it moves alike to round-off of the steps.
#[test]
fn wh03_leaning_disc_rolls_in_a_circle() {
    let (mass_kg, radius_m, ..) = DISC;
    let (lean_rad, turn_rad_s) = (0.3, 1.4);
    let (own, start) = steady(lean_rad, turn_rad_s);
    let turn = Rotation3::from_euler_angles(0.4, -1.1, 2.3);
    let gravity = [0.0, 0.0, -9.81];
    let mut plants = [Rotation3::identity(), turn].map(|turn| started(disc(gravity, lean_rad, start, turn)));
    let begin_m = [0, 1].map(|i| plants[i].outputs().tips()[0].position_m);
    let (mut off_m, mut force, mut apart_m) = (0.0f64, 0.0f64, 0.0f64);
    for index in 1..=30 {
        let time_s = 0.1 * f64::from(index);
        plants.iter_mut().for_each(|plant| step(plant, time_s));
        let ways_m = [0, 1].map(|i| plants[i].outputs().tips()[0].position_m - begin_m[i]);
        let angle = turn_rad_s * time_s;
        let circle_m = radius_m * own / turn_rad_s;
        off_m = off_m.max((ways_m[0] - Vector3::new(angle.sin(), 1.0 - angle.cos(), 0.0) * circle_m).norm());
        let held = plants[0].outputs().no_slips()[0];
        let side_n = mass_kg * turn_rad_s * radius_m * own;
        force = force.max((held.side_force_n - side_n).abs()).max((held.normal_force_n - mass_kg * 9.81).abs());
        force = force.max(held.rolling_force_n.abs());
        apart_m = apart_m.max((turn * ways_m[0] - ways_m[1]).norm());
        assert!(held.slip_m_s < 1e-13 && held.height_m.abs() < 1e-13, "{held:?}");
    }
    println!("WH-03 off by {off_m:.1e} m, forces by {force:.1e} N, rotated {apart_m:.1e} m");
    assert!(off_m < 1e-7 && force < 1e-5 && apart_m < 1e-7, "{off_m:.1e} m, {force:.1e} N, {apart_m:.1e} m");
}

/// WH-04. Chaplygin's sleigh: the skate is behind the centre of mass, and the sleigh turns into its direction of travel. Velocity, yaw rate
/// and heading are those of the closed form, with `tanh` and the function of Gudermann.
#[test]
fn wh04_chaplygin_sleigh() {
    let (mass_kg, arm_m, about) = (2.0, 0.3, 0.09);
    let (turn_rad_s, speed_m_s): (f64, f64) = (3.0, -1.2);
    let text = |solver: &str| {
        format!(
            r#"
name = "Sleigh"

[rigid_body.sleigh]
mass_kg = {mass_kg}
centre_of_mass_m = [{arm_m}, 0.0, 0.0]
inertia_kg_m2 = [0.1, 0.15, {about}, 0.0, 0.0, 0.0]

[joint.free]
type = "free"
parent = "root"
child = "sleigh"
start_angular_velocity_deg_s = [0.0, 0.0, {:?}]
start_velocity_m_s = [{speed_m_s}, 0.0, 0.0]

[skate.blade]
body = "sleigh"

[solver]
{solver}

[simulation]
stop_time_s = 2.0
step_s = 0.1
"#,
            turn_rad_s.to_degrees()
        )
    };
    let errors = |solver: &str| {
        let mut plant = started(machine(&text(solver)));
        let inertia = about + mass_kg * arm_m * arm_m;
        let limit_m_s = (speed_m_s.powi(2) + inertia * turn_rad_s.powi(2) / mass_kg).sqrt();
        let pace = arm_m * mass_kg * limit_m_s / inertia;
        let begin = (speed_m_s / limit_m_s).atanh();
        let gudermann = |x: f64| 2.0 * (0.5 * x).tanh().atan();
        let mut worst = 0.0f64;
        for index in 1..=20 {
            let time_s = 0.1 * f64::from(index);
            step(&mut plant, time_s);
            let now = begin + pace * time_s;
            let heading = (inertia / mass_kg).sqrt() / arm_m * (gudermann(now) - gudermann(begin));
            let ahead = Vector3::new(heading.cos(), heading.sin(), 0.0);
            let tip = &plant.outputs().tips()[0];
            let rate = limit_m_s * (mass_kg / inertia).sqrt() / now.cosh();
            worst = worst.max((tip.velocity_m_s - ahead * (limit_m_s * now.tanh())).norm());
            worst = worst.max((tip.angular_velocity_rad_s.z - rate).abs());
        }
        worst
    };
    let fixed: Vec<f64> =
        [0.025, 0.0125, 0.00625].iter().map(|h| errors(&format!("tolerance = 1e-12\nfixed_step_s = {h}"))).collect();
    let fine = errors("tolerance = 1e-10");
    let orders: Vec<f64> = fixed.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    println!("WH-04 {fixed:?}, orders {orders:.2?}, at tolerance 1e-10 {fine:.1e}");
    assert!(orders.iter().all(|order| *order > 3.6) && fine < 1e-8, "{fixed:?} {fine:.1e}");
}

/// A beam on a sledge with a skate below its tip, and a castor: a wheel that trails behind a vertical hinge at the sledge.
fn trolley(solver: &str) -> String {
    format!(
        r#"
name = "Trolley"
gravity_m_s2 = [0.9, 0.3, -9.7]

[section.rod]
shape = "rectangle"
width_m = 0.03
height_m = 0.012
youngs_modulus_Pa = 2e10
poisson_ratio = 0.3
density_kg_m3 = 1500.0

[rigid_body.sledge]
mass_kg = 4.0
centre_of_mass_m = [0.1, 0.0, 0.02]
inertia_kg_m2 = [0.05, 0.08, 0.1, 0.0, 0.0, 0.0]

[body.boom]
section = "rod"
length_m = 0.8
elements = 3

[rigid_body.fork]
mass_kg = 0.4
centre_of_mass_m = [-0.03, 0.0, -0.05]
inertia_kg_m2 = [0.002, 0.002, 0.002, 0.0, 0.0, 0.0]

[rigid_body.castor]
mass_kg = 0.6
inertia_kg_m2 = [0.002, 0.0035, 0.002, 0.0, 0.0, 0.0]

[joint.free]
type = "free"
parent = "root"
child = "sledge"
root_position_m = [0.0, 0.0, 0.2]
start_angular_velocity_deg_s = [0.0, 0.0, 40.0]
start_velocity_m_s = [0.7, 0.0, 0.0]

[joint.clamp]
type = "clamped"
parent = "sledge"
child = "boom"

[joint.swivel]
type = "revolute"
parent = "sledge"
child = "fork"
axis = [0.0, 0.0, 1.0]
parent_offset_m = [-0.2, 0.1, 0.0]
start_angle_deg = 50.0

[joint.axle]
type = "revolute"
parent = "fork"
child = "castor"
axis = [0.0, 1.0, 0.0]
parent_offset_m = [-0.06, 0.0, -0.12]

[skate.tip]
body = "boom"
offset_m = [0.0, 0.0, -0.2]
direction = [1.0, 0.1, 0.0]

[skate.side]
body = "sledge"
offset_m = [-0.1, -0.2, -0.2]
direction = [1.0, 0.0, 0.0]
hold_normal = true

[wheel.castor]
body = "castor"
radius_m = 0.08

[solver]
{solver}

[simulation]
stop_time_s = 1.0
step_s = 0.02
"#
    )
}

fn balance_j(plant: &Plant) -> f64 {
    let energy = plant.outputs().energy();
    energy.total + energy.dissipated - energy.work
}

/// WH-05. The constraints do no work: the energy of a flexible boom with a skate at its tip, a second skate and a castor changes by less
/// than 1e-9 of its kinetic energy; nothing slips, although boom and castor swing.
#[test]
fn wh05_constraints_do_no_work() {
    let mut plant = started(machine(&trolley("tolerance = 1e-11\nmax_step_s = 2e-3")));
    let begin_j = balance_j(&plant);
    let (mut drift_j, mut kinetic_j, mut slip, mut height_m) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    let swivel = plant.outputs().joints()[0].angle_rad;
    for index in 1..=50 {
        step(&mut plant, 0.02 * f64::from(index));
        drift_j = drift_j.max((balance_j(&plant) - begin_j).abs());
        kinetic_j = kinetic_j.max(plant.outputs().energy().kinetic);
        for own in plant.outputs().no_slips() {
            (slip, height_m) = (slip.max(own.slip_m_s), height_m.max(own.height_m.abs()));
        }
    }
    let turned = plant.outputs().joints()[0].angle_rad - swivel;
    println!(
        "WH-05 drift {:.1e} of {kinetic_j:.2} J, slip {slip:.1e} m/s, height {height_m:.1e} m, swivel {turned:.2}",
        drift_j / kinetic_j
    );
    assert!(
        drift_j < 1e-9 * kinetic_j && slip < 1e-12 && height_m < 1e-12,
        "{drift_j:.1e} J, {slip:.1e}, {height_m:.1e}"
    );
    assert!(turned.abs() > 0.1, "the castor swings by {turned:.2} rad");
}

/// WH-06. Steps repeated from a snapshot are identical bit by bit; the communication step changes the state by no more than the tolerance
/// permits; steps allocate no memory.
#[test]
fn wh06_rollback_communication_steps_and_memory() {
    let mut plant = started(machine(&trolley("tolerance = 1e-8")));
    step(&mut plant, 0.2013);
    let kept = plant.snapshot();
    let ends: Vec<Vec<f64>> = (0..2)
        .map(|_| {
            plant.restore(&kept).expect("own snapshot");
            let run = 1..=40;
            run.flat_map(|index| {
                step(&mut plant, 0.2013 + 3e-3 * f64::from(index));
                plant.outputs().values().to_vec()
            })
            .collect()
        })
        .collect();
    assert!(ends[0].iter().zip(&ends[1]).all(|(a, b)| a.to_bits() == b.to_bits()));

    let places: Vec<[Vector3<f64>; 2]> = [1, 3, 50]
        .map(|steps| {
            let mut plant = started(machine(&trolley("tolerance = 1e-8")));
            (1..=steps).for_each(|index| step(&mut plant, 0.5 * f64::from(index) / f64::from(steps)));
            [0, 1].map(|tip| plant.outputs().tips()[tip].position_m)
        })
        .to_vec();
    let apart =
        |a: &[Vector3<f64>; 2], b: &[Vector3<f64>; 2]| a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
    let apart_m = [1, 2].map(|i| apart(&places[0], &places[i]));
    println!("WH-06 communication steps {apart_m:?} m");
    assert!(apart_m.iter().all(|apart_m| *apart_m < 1e-12), "{apart_m:?}");

    let mut plant = started(machine(&trolley("tolerance = 1e-6")));
    step(&mut plant, 0.05);
    let before = allocations();
    (51..=200).for_each(|index| step(&mut plant, 1e-3 * f64::from(index)));
    assert_eq!(allocations() - before, 0);
}

/// WH-07. What skates and wheels do not permit is refused by their names: linear models, modes, equilibria, external integrators,
/// a start at equilibrium, prescribed motions that contradict them, places off the plane, directions along the normal.
#[test]
fn wh07_refusals_name_the_constraint() {
    let mut plant = started(sleigh("tolerance = 1e-8"));
    assert_eq!(plant.hybrid().err(), Some(NotHybrid::NoSlip));
    for refused in [
        plant.study().second_order().map(|_| ()),
        plant.study().modes(2).map(|_| ()),
        plant.study().stability().map(|_| ()),
        plant.study().rotor(0.0, None).map(|_| ()),
        plant.study().equilibrium(0.0, Holding::AsReleased).map(|_| ()),
    ] {
        let text = refused.expect_err("refused").to_string();
        assert!(text.contains("the skate \"blade\" constrains velocities") && text.contains("[skate.blade]"), "{text}");
    }

    let text = trolley("tolerance = 1e-6");
    let cases = [
        (
            text.replace("step_s = 0.02", "step_s = 0.02\nstart = \"equilibrium\""),
            "there is no static equilibrium with the skate \"tip\"",
        ),
        (text.replace("direction = [1.0, 0.1, 0.0]", "direction = [0.001, 0.0, 1.0]"), "to the normal"),
        (text.replace("direction = [1.0, 0.1, 0.0]", "direction = [0.0, 0.0, 0.0]"), "not all 0"),
        (text.replace("radius_m = 0.08", "radius_m = 0.05"), "0.030000 m from the plane"),
        (text.replace("radius_m = 0.08", "radius_m = 0.0"), "radius"),
        (text.replace("body = \"castor\"", "body = \"caster\""), "castor"),
        (text.replace("offset_m = [0.0, 0.0, -0.2]", "position_m = 0.9"), "0.8"),
    ];
    for (text, expected) in cases {
        let refused = config::parse(&text, "no_slip.toml").expect_err(expected).to_string();
        assert!(refused.contains(expected), "{refused}");
    }
    let mut built = sleigh("tolerance = 1e-8");
    built.experiment.start = StartState::Equilibrium;
    assert!(built.validate().iter().any(|fault| fault.to_string().contains("no static equilibrium")));
    built = sleigh("tolerance = 1e-8");
    let blade: NoSlip = built.no_slips[0].clone();
    built.no_slips.push(blade);
    assert!(!built.validate().is_empty(), "two skates of one name");

    // a prescribed motion across the blade
    let slipping = machine(
        r#"
name = "Slider"

[rigid_body.block]
mass_kg = 1.0

[joint.rail]
type = "prismatic"
parent = "root"
child = "block"
axis = [0.0, 1.0, 0.0]
motion = "prescribed"
polynomial_m = [0.0, 0.5]

[skate.blade]
body = "block"

[simulation]
stop_time_s = 1.0
step_s = 0.1
"#,
    );
    let mut plant = Plant::new(Arc::new(slipping));
    let refused = plant.initialize(0.0).and_then(|()| plant.step(0.1)).expect_err("a contradiction").to_string();
    assert!(refused.contains("a skate or a wheel slips") && refused.contains("release a joint"), "{refused}");
}

/// WH-08. Without `rolling` a wheel slides along its heading without friction, without `hold_normal` it leaves the plane; the forces of rows
/// that are not constrained are zero, and a wheel that starts with a slip is brought to roll at the start.
#[test]
fn wh08_rows_that_are_not_constrained() {
    let start = [Vector3::y() * 3.0, Vector3::x() * 0.5];
    let mut sliding = disc([2.0, 0.0, -9.0], 0.0, start, Rotation3::identity());
    for own in &mut sliding.no_slips {
        if let Runner::Wheel { rolling, .. } = &mut own.runner {
            *rolling = false;
        }
    }
    let mut lifted = disc([2.0, 0.0, 1.0], 0.0, start, Rotation3::identity());
    lifted.no_slips[0].hold_normal = false;
    let rolled = disc([0.0, 0.0, -9.0], 0.0, start, Rotation3::identity());
    let [mut sliding, mut lifted, mut rolled] = [sliding, lifted, rolled].map(started);
    let begin_m = sliding.outputs().tips()[0].position_m;
    [&mut sliding, &mut lifted, &mut rolled].into_iter().for_each(|plant| step(plant, 0.6));
    let tip = &sliding.outputs().tips()[0];
    let (way_m, own) = (tip.position_m - begin_m, sliding.outputs().no_slips()[0]);
    assert!((way_m - Vector3::x() * (0.5 * 0.6 + 0.36)).norm() < 1e-9, "{way_m}");
    assert!((tip.angular_velocity_rad_s - Vector3::y() * 3.0).norm() < 1e-8 && own.rolling_force_n == 0.0);
    let own = lifted.outputs().no_slips()[0];
    assert!(own.normal_force_n == 0.0 && (own.height_m - 0.18).abs() < 1e-6, "{own:?}");
    assert!(own.slip_m_s < 1e-13, "{own:?}");
    // the momentum about the point of contact is kept
    let (mass_kg, radius_m, axial, _) = DISC;
    let spin = (axial * 3.0 + mass_kg * radius_m * 0.5) / (axial + mass_kg * radius_m * radius_m);
    let tip = &rolled.outputs().tips()[0];
    let miss = (tip.angular_velocity_rad_s - Vector3::y() * spin).norm();
    println!("WH-08 spin off by {miss:.1e} rad/s");
    assert!(miss < 1e-9, "{miss:.1e}");
}

/// WH-09. A rigid loop between two points of the axis of the axle restrains nothing: forces of skates and wheels and the motion are those
/// without it, to the tolerance.
#[test]
fn wh09_wheels_beside_a_rigid_loop() {
    let without = trolley("tolerance = 1e-9");
    let idle = "[loop.idle]\nbodies = [\"fork\", \"castor\"]\noffsets_m = [[-0.06, 0.2, -0.12], [0.0, 0.2, 0.0]]\nrigid = true\n\n[solver]";
    let with = without.replace("[solver]", idle);
    let mut plants = [without, with].map(|text| started(machine(&text)));
    let (mut apart_n, mut apart_m, mut side_n) = (0.0f64, 0.0f64, 0.0f64);
    for index in 1..=20 {
        plants.iter_mut().for_each(|plant| step(plant, 0.02 * f64::from(index)));
        let [one, other] = [0, 1].map(|i| plants[i].outputs());
        for (a, b) in one.no_slips().iter().zip(other.no_slips()) {
            apart_n =
                apart_n.max((a.side_force_n - b.side_force_n).abs()).max((a.normal_force_n - b.normal_force_n).abs());
            side_n = side_n.max(a.side_force_n.abs());
        }
        for (a, b) in one.tips().iter().zip(other.tips()) {
            apart_m = apart_m.max((a.position_m - b.position_m).norm());
        }
    }
    println!("WH-09 forces {apart_n:.1e} N apart of {side_n:.1} N, places {apart_m:.1e} m");
    assert!(apart_n < 1e-4 * side_n && apart_m < 1e-7, "{apart_n:.1e} N, {apart_m:.1e} m");
}

/// WH-10. The landing-gear leg of `examples/gear`: the wheel swings the fork into the direction of travel, the leg bends sideways on the way,
/// the energy balance closes to the tolerance of the model, and the tyre carries the weight on average.
#[test]
fn wh10_castoring_landing_gear_wheel() {
    let mut plant = started(machine(CASTOR));
    let begin_j = balance_j(&plant);
    let kinetic_j = plant.outputs().energy().kinetic;
    let (mut drift_j, mut side_n, mut normal_n) = (0.0f64, 0.0f64, 0.0f64);
    for index in 1..=500 {
        step(&mut plant, 2e-3 * f64::from(index));
        let own = plant.outputs().no_slips()[0];
        side_n = side_n.max(own.side_force_n.abs());
        normal_n += own.normal_force_n / 500.0;
        drift_j = drift_j.max((balance_j(&plant) - begin_j).abs());
        assert!(own.slip_m_s < 1e-11 && own.height_m.abs() < 1e-12, "{own:?}");
    }
    let swivel = plant.outputs().joints()[2];
    let weight_n = plant.mass_kg() * 9.81;
    println!(
        "WH-10 swivel {:.3} deg, side force up to {side_n:.1} N, mean normal force {:.4} of the weight, drift {:.1e} of {kinetic_j:.0} J",
        swivel.angle_rad.to_degrees(),
        normal_n / weight_n,
        drift_j / kinetic_j
    );
    // the swivel has come to rest; the carriage still bounces on the leg; the drift is that of the default tolerance
    assert!(swivel.angle_rad.abs() < 1e-4 && side_n > 50.0, "{swivel:?}");
    assert!((normal_n / weight_n - 1.0).abs() < 0.01 && drift_j < 2e-5 * kinetic_j);
}

//! M-05: every kind of error in a model built through the Rust API, without a model file: location, value, allowed values.
//!
//! A case introduces one error into a valid machine and gives the location and a part of the message. No other error may be reported.

use foldwing::aero::AirOptions;
use foldwing::aero::continuous_turbulence::Series;
use foldwing::aero::flow::GustShape;
use foldwing::aero::polar::{Polar, PolarRow};
use foldwing::beam::law::SectionLaw;
use foldwing::beam::profile::Profile;
use foldwing::beam::section::{Material, Section, Solid};
use foldwing::load::Wrench;
use foldwing::machine::builder::{GustBuilder, MachineBuilder};
use foldwing::machine::*;
use nalgebra::{Matrix3, Vector3};

fn on(index: usize, position_m: f64) -> LoopEnd {
    LoopEnd::Body { index, position_m }
}

fn plate() -> Solid {
    Solid::rectangle(0.05, 0.002, Material::isotropic(2.83e9, 0.3, 1425.0))
}

fn plate_by_numbers() -> Section {
    plate().section()
}

/// A gust given by a table of turbulence.
fn turbulence(spacing_m: f64, values: &[f64]) -> GustShape {
    GustShape::Turbulence(Series { spacing_m, begin_m: 0.0, values: values.into() })
}

/// Bodies with every kind of joint, a loop, a gauge, a mass, a load; with strips or a lattice.
fn parts(air: builder::AirBuilder) -> MachineBuilder {
    let beam = |name| Body::beam(name, 0.15, plate()).elements(2);
    let fold = Joint::revolute("fold", [0.0, 1.0, 0.0])
        .on("inner")
        .motor(Motor { stiffness_n_m_rad: 0.026, ..Motor::default() })
        .spring(Spring { stiffness_n_m_rad: 0.01, damping_n_m_s_rad: 0.0, rest_angle_rad: 0.0 })
        .latch(Latch::with_ratio(1e4));
    let crank = Joint::revolute("crank", [0.0, 1.0, 0.0]).prescribed(Motion::Table(vec![(0.0, 0.0), (1.0, 0.5)]));
    Machine::builder("wing")
        .gravity_m_s2([0.0, 0.0, -9.81])
        .body(beam("inner"), Joint::clamped("mount"))
        .body(beam("outer"), fold)
        .body(beam("tail"), Joint::universal("gimbal", [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]).on("inner"))
        .body(beam("arm"), crank)
        .body(beam("kite"), Joint::free("flight").at_root([1.0, 0.0, 0.0]))
        .body(Body::beam("rod", 0.15, plate_by_numbers()).elements(2), Joint::ball("hip").at_root([0.0, 1.0, 0.0]))
        .mass("inner", AttachedMass::point("actuator", 0.15, 0.02))
        .load("weight", "inner", 1, Wrench { force_n: Vector3::z(), ..Wrench::default() })
        .gauge(Gauge::on("root", "inner", 0.02))
        .closure(Closure::between("pin", ["inner", "outer"], 1e5).positions_m([0.15, 0.0]))
        .air(air.wind_m_s([0.0, -10.0, 0.0]))
        .surface(LiftingSurface::on("inner", 4))
        .gust(GustBuilder::new("up", GustShape::OneMinusCosine { length_m: 0.5 }, [0.0, 0.0, 1.0]))
}

fn sound(air: builder::AirBuilder) -> Machine {
    parts(air).build().unwrap_or_else(|refused| panic!("{refused}"))
}

fn fold(machine: &mut Machine) -> &mut Revolute {
    match &mut machine.bodies[1].joint.kind {
        JointKind::Revolute(revolute) => revolute,
        _ => unreachable!("the fold is a hinge"),
    }
}

fn spatial(machine: &mut Machine, body: usize) -> &mut Spatial {
    match &mut machine.bodies[body].joint.kind {
        JointKind::Spatial(spatial) => spatial,
        _ => unreachable!("a universal, ball or free joint"),
    }
}

fn air(machine: &mut Machine) -> &mut Air {
    machine.air.as_mut().expect("air")
}

fn lattice(machine: &mut Machine) -> &mut foldwing::aero::lattice::LatticeOptions {
    match &mut air(machine).parts[0].options {
        AirOptions::Lattice(options) => options,
        AirOptions::Strips(_) | AirOptions::Rotor(_) | AirOptions::SlenderBody(_) => unreachable!("a lattice"),
    }
}

type Case = (fn(&mut Machine), &'static str, &'static str);

/// Introduces each error and checks the message.
#[track_caller]
fn check(make: impl Fn() -> Machine, cases: &[Case]) {
    assert_eq!(make().validate(), [], "the machine without a fault is sound");
    for (plant, place, allowed) in cases {
        let mut machine = make();
        plant(&mut machine);
        let faults = machine.validate();
        let told: Vec<String> = faults.iter().map(ToString::to_string).collect();
        assert_eq!(faults.len(), 1, "{place} ({allowed}): {told:?}");
        assert_eq!(faults[0].place.to_string(), *place, "{told:?}");
        assert!(told[0].contains(allowed), "{place}: {allowed:?} is not in {told:?}");
        assert!(told[0].contains(" is not allowed; allowed: "), "{told:?}");
        assert!(!faults[0].value.is_empty() && !faults[0].allowed.is_empty(), "{told:?}");
    }
}

const NAN: f64 = f64::NAN;

#[test]
fn names_and_tree() {
    check(
        || sound(Air::strips()),
        &[
            (|m| m.name = "1x".into(), "name", "an identifier"),
            (|m| m.gravity_m_s2.x = NAN, "gravity_m_s2", "an array of 3 finite accelerations in m/s²"),
            (|m| m.bodies[0].name = "inner wing".into(), "body \"inner wing\"", "an identifier"),
            (|m| m.bodies[1].name = "inner".into(), "body \"inner\"", "a name that no other body has"),
            (|m| m.bodies[1].name = "root".into(), "body \"root\"", "reserved for the frame"),
            (|m| m.bodies[1].joint.name = "mount".into(), "joint \"mount\"", "a name that no other joint has"),
            (|m| m.bodies[1].joint.name = "energy".into(), "joint \"energy\"", "is not one of load, gravity"),
            (|m| m.bodies[1].joint.name = "tip".into(), "joint \"tip\"", "a name that is not one of"),
            (
                |m| m.bodies[1].joint.parent = Parent::Body { index: 1, position_m: 0.0 },
                "joint \"fold\", parent",
                "a body earlier in the list",
            ),
            (
                |m| m.bodies[1].joint.parent = Parent::Body { index: 99, position_m: 0.0 },
                "joint \"fold\", parent",
                "body 99 of 6",
            ),
            (
                |m| m.bodies[1].joint.parent = Parent::Body { index: 0, position_m: 0.16 },
                "joint \"fold\", parent_position_m",
                "a length from 0 to 0.15 m",
            ),
            (
                |m| m.bodies[0].joint.parent = Parent::Root { position_m: Vector3::new(NAN, 0.0, 0.0) },
                "joint \"mount\", root_position_m",
                "3 finite lengths",
            ),
            (|m| m.bodies[0].joint.mount *= 2.0, "joint \"mount\", mount", "a rotation matrix"),
            (|m| m.bodies[0].joint.mount[(0, 0)] = NAN, "joint \"mount\", mount", "a rotation matrix"),
            (|m| m.bodies[0].joint.mount[(2, 2)] = -1.0, "joint \"mount\", mount", "a rotation matrix"),
        ],
    );
    let mut empty = sound(Air::strips());
    (empty.bodies, empty.gauges, empty.closures, empty.air) = (Vec::new(), Vec::new(), Vec::new(), None);
    assert_eq!(
        empty.validate()[0].to_string(),
        "body: a model without bodies is not allowed; allowed: at least one body"
    );
}

#[test]
fn bodies() {
    check(
        || sound(Air::strips()),
        &[
            (|m| m.bodies[4].length_m = 0.0, "body \"kite\", length_m", "a finite length > 0 m"),
            (|m| m.bodies[4].length_m = NAN, "body \"kite\", length_m", "a finite length > 0 m"),
            (|m| m.bodies[0].elements = 0, "body \"inner\", elements", "a whole number from 1 to 1000"),
            (|m| m.bodies[0].elements = 1001, "body \"inner\", elements", "a whole number from 1 to 1000"),
            (|m| m.bodies[0].mass_damping_1_s = -1.0, "body \"inner\", mass_damping_1_s", ">= 0"),
            (|m| m.bodies[0].stiffness_damping_s = NAN, "body \"inner\", stiffness_damping_s", ">= 0 s"),
            (|m| m.bodies[0].station_positions_m[1] = 0.0, "body \"inner\", station_positions_m", "ascending lengths"),
            (|m| m.bodies[0].station_positions_m[3] = 0.2, "body \"inner\", station_positions_m", "ascending lengths"),
            (
                |m| m.bodies[0].station_positions_m = (0..1001).map(|i| 1e-4 * f64::from(i)).collect(),
                "body \"inner\", station_positions_m",
                "at most 1000 load stations",
            ),
            (
                |m| m.bodies[0].station_loads.resize(5, Wrench::default()),
                "body \"inner\", station_loads",
                "at most 4, one per load station",
            ),
            (
                |m| m.bodies[0].station_loads[0].force_n.x = NAN,
                "body \"inner\", station_loads, force_n",
                "3 finite forces in N",
            ),
            (
                |m| m.bodies[0].station_loads[0].moment_n_m.x = NAN,
                "body \"inner\", station_loads, moment_n_m",
                "3 finite torques in N·m",
            ),
            (
                |m| m.bodies[0].natural_strain = [0.0, 0.0, 50.0, 0.0].into(),
                "body \"inner\", natural_strain",
                "half a revolution per element",
            ),
            (
                |m| m.bodies[0].natural_strain.0[2] = Profile::linear(0.0, 50.0, 0.15),
                "body \"inner\", natural_strain",
                "a curvature of 50.0000 1/m at 0.15 m",
            ),
            (
                |m| m.bodies[0].natural_strain.0[0] = Profile::constant(-1.0),
                "body \"inner\", stretch",
                "a stretch > -1",
            ),
            (
                |m| m.bodies[0].natural_strain.0[1] = Profile::Polynomial(vec![]),
                "body \"inner\", twist_1_m, polynomial",
                "1 to 100 finite numbers",
            ),
            (
                |m| m.bodies[0].natural_strain.0[3] = Profile::Table(vec![[0.1, 0.0], [0.05, 0.0]]),
                "body \"inner\", curvature_z_1_m, table",
                "s ascending from 0 to at most 0.15 m",
            ),
        ],
    );
    let many = || {
        let body = |name: &str| Body::beam(name, 1.0, plate()).elements(1000).load_stations(0);
        let names: Vec<String> = (0..20).map(|i| format!("b{i}")).collect();
        let all = names.iter().fold(Machine::builder("chain"), |machine, name| {
            machine.body(body(name), Joint::clamped(format!("j{name}")))
        });
        all.build().unwrap_or_else(|refused| panic!("{refused}"))
    };
    let stations = |m: &mut Machine| {
        for body in &mut m.bodies[..3] {
            body.station_positions_m = (0..700).map(|i| 1e-3 * f64::from(i)).collect();
        }
    };
    let elements = |m: &mut Machine| {
        let mut further = m.bodies[0].clone();
        (further.name, further.joint.name) = ("further".into(), "further".into());
        m.bodies.push(further);
    };
    check(many, &[(stations, "body", "2100 load stations"), (elements, "body", "21000 elements")]);
}

#[test]
fn sections_and_masses() {
    fn rod(machine: &mut Machine) -> &mut Section {
        match &mut machine.bodies[5].section {
            SectionLaw::Uniform(section) => section,
            _ => unreachable!("the rod's section is given by numbers"),
        }
    }
    fn solid(machine: &mut Machine, width: Profile, height: Profile) {
        machine.bodies[4].section = SectionLaw::Tapered { solid: plate(), width, height };
    }
    check(
        || sound(Air::strips()),
        &[
            (
                |m| rod(m).stiffness[(1, 2)] = 1e-3,
                "body \"rod\", section, stiffness",
                "0 in row 3, column 2 and 0.001 in row 2, column 3",
            ),
            (|m| rod(m).stiffness[(1, 1)] = -1.0, "body \"rod\", section", "positive, finite numbers in SI"),
            (|m| rod(m).mass_kg_m = NAN, "body \"rod\", section", "positive, finite numbers in SI"),
            (
                |m| (rod(m).stiffness[(1, 2)], rod(m).stiffness[(2, 1)]) = (1.0, 1.0),
                "body \"rod\", section, stiffness",
                "a symmetric positive definite matrix",
            ),
            (
                |m| rod(m).second_moment_kg_m[1] = 1.0,
                "body \"rod\", section, second_moment_kg_m",
                "about the centre of mass",
            ),
            (|m| rod(m).half_width_m = -1.0, "body \"rod\", section, half_width_m", "0 where the outline is not known"),
            (
                |m| {
                    let section = plate_by_numbers();
                    m.bodies[4].section = SectionLaw::between(section.clone(), section, 0.2);
                },
                "body \"kite\", section, position_m",
                "2 to 1000 positions that ascend from 0 to 0.15 m, the length of the body",
            ),
            (
                |m| {
                    let (inner, mut outer) = (plate_by_numbers(), plate_by_numbers());
                    outer.mass_kg_m = 0.0;
                    m.bodies[4].section = SectionLaw::between(inner, outer, 0.15);
                },
                "body \"kite\", outer_section",
                "positive, finite numbers in SI",
            ),
            (
                |m| solid(m, Profile::linear(1.0, -1.0, 0.15), Profile::constant(1.0)),
                "body \"kite\", width_taper",
                "a factor > 0 all along the body",
            ),
            (
                |m| solid(m, Profile::constant(1.0), Profile::Table(vec![[0.0, NAN]])),
                "body \"kite\", height_taper, table",
                "rows [s, value]",
            ),
            (
                |m| solid(m, Profile::constant(1e25), Profile::constant(1.0)),
                "body \"kite\", section",
                "factors that leave mass, inertia and stiffness positive",
            ),
            (|m| m.bodies[0].masses[0].mass_kg = 0.0, "mass \"actuator\", mass_kg", "a finite mass > 0 kg"),
            (|m| m.bodies[0].masses[0].position_m = 0.2, "mass \"actuator\", position_m", "a length from 0 to 0.15 m"),
            (|m| m.bodies[0].masses[0].offset_m.x = NAN, "mass \"actuator\", offset_m", "3 finite lengths"),
            (
                |m| m.bodies[0].masses[0].inertia_kg_m2 = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 3.0)),
                "mass \"actuator\", inertia_kg_m2",
                "none larger than the sum of the other two",
            ),
            (
                |m| m.bodies[0].masses[0].inertia_kg_m2[(0, 1)] = 1.0,
                "mass \"actuator\", inertia_kg_m2",
                "principal moments",
            ),
            (
                |m| m.bodies[0].masses[0].inertia_kg_m2[(0, 0)] = NAN,
                "mass \"actuator\", inertia_kg_m2",
                "principal moments",
            ),
            (|m| m.bodies[0].masses[0].name = "a b".into(), "mass \"a b\"", "an identifier"),
        ],
    );
}

#[test]
fn joints() {
    check(
        || sound(Air::strips()),
        &[
            (|m| fold(m).axis = Vector3::zeros(), "joint \"fold\", axis", "not all 0"),
            (|m| fold(m).axis.x = NAN, "joint \"fold\", axis", "3 finite numbers"),
            (|m| fold(m).start_angle_rad = 7.0, "joint \"fold\", start_angle_rad", "a finite angle from -6.28"),
            (|m| fold(m).start_rate_rad_s = NAN, "joint \"fold\", start_rate_rad_s", "a finite rate in rad/s"),
            (
                |m| (fold(m).start_rate_rad_s, fold(m).release) = (1.0, false),
                "joint \"fold\", start_rate_rad_s",
                "a rate of 0 rad/s if the joint is locked",
            ),
            (
                |m| (fold(m).motion, fold(m).latch) = (JointMotion::Prescribed(Motion::Polynomial(vec![])), None),
                "joint \"fold\", motion",
                "1 to 100 finite coefficients in rad and s",
            ),
            (
                |m| (fold(m).motion, fold(m).latch) = (JointMotion::Prescribed(Motion::Onward(vec![(0.0, 0.0)])), None),
                "joint \"fold\", motion",
                "at least 2 pairs",
            ),
            (|m| fold(m).motor.stiffness_n_m_rad = -1.0, "joint \"fold\", motor, stiffness_n_m_rad", ">= 0 N·m/rad"),
            (|m| fold(m).motor.damping_n_m_s_rad = -1.0, "joint \"fold\", motor, damping_n_m_s_rad", ">= 0 N·m·s/rad"),
            (|m| fold(m).motor.torque_limit_n_m = -1.0, "joint \"fold\", motor, torque_limit_n_m", ">= 0 N·m"),
            (|m| fold(m).motor.rate_limit_rad_s = -1.0, "joint \"fold\", motor, rate_limit_rad_s", ">= 0 rad/s"),
            (|m| fold(m).motor.inertia_kg_m2 = -1.0, "joint \"fold\", motor, inertia_kg_m2", ">= 0 kg·m²"),
            (|m| fold(m).motor.constant_torque_n_m = NAN, "joint \"fold\", motor, constant_torque_n_m", "in N·m"),
            (|m| fold(m).motor.command_rad = 9.0, "joint \"fold\", motor, command_rad", "rad"),
            (
                |m| fold(m).spring.as_mut().unwrap().stiffness_n_m_rad = -1.0,
                "joint \"fold\", spring, stiffness_n_m_rad",
                ">= 0 N·m/rad",
            ),
            (
                |m| fold(m).spring.as_mut().unwrap().damping_n_m_s_rad = NAN,
                "joint \"fold\", spring, damping_n_m_s_rad",
                ">= 0 N·m·s/rad",
            ),
            (
                |m| fold(m).spring.as_mut().unwrap().rest_angle_rad = 9.0,
                "joint \"fold\", spring, rest_angle_rad",
                "a finite angle",
            ),
            (|m| fold(m).motion = JointMotion::Locked, "joint \"fold\", latch", "a latch only with motion = \"free\""),
            (
                |m| {
                    let latch = fold(m).latch.as_mut().unwrap();
                    (latch.initially_closed, latch.enable) = (true, false);
                },
                "joint \"fold\", latch, initially_closed",
                "a latch that is not enabled is open",
            ),
            (|m| fold(m).latch.as_mut().unwrap().angle_rad = 9.0, "joint \"fold\", latch, angle_rad", "a finite angle"),
            (
                |m| fold(m).latch.as_mut().unwrap().capture_rad = -1.0,
                "joint \"fold\", latch, capture_rad",
                "a finite angle from 0 to",
            ),
            (
                |m| fold(m).latch.as_mut().unwrap().stiffness_n_m_rad = 0.0,
                "joint \"fold\", latch, stiffness_n_m_rad",
                "> 0 N·m/rad",
            ),
            (|m| spatial(m, 5).stiffness_n_m_rad = -1.0, "joint \"hip\", stiffness_n_m_rad", ">= 0"),
            (|m| spatial(m, 5).damping_n_m_s_rad = NAN, "joint \"hip\", damping_n_m_s_rad", ">= 0"),
            (
                |m| spatial(m, 5).start_angular_velocity_rad_s.x = NAN,
                "joint \"hip\", start_angular_velocity_rad_s",
                "3 finite rates in rad/s",
            ),
            (
                |m| spatial(m, 4).start_velocity_m_s.x = f64::INFINITY,
                "joint \"flight\", start_velocity_m_s",
                "3 finite velocities in m/s",
            ),
            (|m| spatial(m, 5).start_velocity_m_s.x = 1.0, "joint \"hip\", start_velocity_m_s", "not free"),
            (|m| spatial(m, 4).stiffness_n_m_rad = 1.0, "joint \"flight\", stiffness_n_m_rad", "no spring or damper"),
            (
                |m| m.bodies[4].joint.parent = Parent::Body { index: 0, position_m: 0.0 },
                "joint \"flight\", parent",
                "\"root\" (a free joint",
            ),
            (
                |m| spatial(m, 2).start_angular_velocity_rad_s = Vector3::x(),
                "joint \"gimbal\", start_angular_velocity_rad_s",
                "zero along [1, 0, 0]",
            ),
            (
                |m| {
                    spatial(m, 2).freedom =
                        SpatialFreedom::Universal { parent_axis: Vector3::y(), body_axis: Vector3::y() }
                },
                "joint \"gimbal\", body_axis",
                "not parallel to axis",
            ),
            (
                |m| {
                    spatial(m, 2).freedom =
                        SpatialFreedom::Universal { parent_axis: Vector3::zeros(), body_axis: Vector3::y() }
                },
                "joint \"gimbal\", axis",
                "not all 0",
            ),
        ],
    );
}

/// Adds an output of internal loads outboard of a position.
fn cut(machine: &mut Machine, body: usize, position_m: f64) {
    let (name, side) = ("cut".into(), SectionSide::Outboard);
    machine.internal_loads = vec![InternalLoad { name, body, position_m, side }];
}

#[test]
fn gauges_and_loops() {
    check(
        || sound(Air::strips()),
        &[
            (|m| m.gauges[0].body = 6, "gauge \"root\", body", "one of the 6 bodies"),
            (|m| m.gauges[0].position_m = 0.2, "gauge \"root\", position_m", "a length from 0 to 0.15 m"),
            (|m| m.gauges[0].z_m = 0.01, "gauge \"root\", z_m", "a point on the section"),
            (|m| m.gauges[0].y_m = NAN, "gauge \"root\", y_m", "a point on the section"),
            (|m| m.gauges[0].direction *= 2.0, "gauge \"root\", direction", "not all 0"),
            (
                |m| (m.gauges[0].body, m.gauges[0].direction) = (5, Vector3::y()),
                "gauge \"root\", direction",
                "the axis",
            ),
            (
                |m| {
                    let mut section = plate_by_numbers();
                    (section.half_width_m, section.half_height_m) = (0.0, 0.0);
                    (m.bodies[5].section, m.gauges[0].body) = (section.into(), 5);
                },
                "gauge \"root\", body",
                "half_width_m and half_height_m",
            ),
            (|m| cut(m, 6, 0.0), "internal_load \"cut\", body", "one of the 6 bodies"),
            (|m| cut(m, 0, 0.2), "internal_load \"cut\", position_m", "a length from 0 to 0.15 m"),
            (|m| cut(m, 0, -1e-3), "internal_load \"cut\", position_m", "a length from 0 to 0.15 m"),
            (|m| cut(m, 0, NAN), "internal_load \"cut\", position_m", "a length from 0 to 0.15 m"),
            (|m| cut(m, 0, 0.15), "internal_load \"cut\", side", "there is no part outboard of it"),
            (|m| m.closures[0].ends[1] = on(9, 0.0), "loop \"pin\", bodies", "one of the 6 bodies"),
            (|m| m.closures[0].ends[1] = on(1, 0.2), "loop \"pin\", positions_m", "\"outer\" is 0.15 m long"),
            (|m| m.closures[0].ends = [on(0, 0.1); 2], "loop \"pin\", positions_m", "one is joined to itself"),
            (|m| m.closures[0].ends = [LoopEnd::Root; 2], "loop \"pin\", bodies", "both points are on the root"),
            (|m| m.closures[0].ends[1] = LoopEnd::Root, "loop \"pin\"", "points that coincide"),
            (|m| m.closures[0].ends[1] = on(1, 0.01), "loop \"pin\"", "points that coincide"),
            (|m| m.bodies[0].modal_damping_ratios = vec![-0.1], "body \"inner\", modal_damping_ratios", "ratios >= 0"),
            (|m| m.bodies[0].modal_damping_ratios = vec![NAN], "body \"inner\", modal_damping_ratios", "ratios >= 0"),
            (|m| m.bodies[0].modal_damping_ratios = vec![0.1; 13], "body \"inner\", modal_damping_ratios", "up to"),
            (|m| m.closures[0].offsets_m[0].x = NAN, "loop \"pin\", offsets_m", "6 finite lengths"),
            (|m| m.closures[0].stiffness_n_m = 0.0, "loop \"pin\", stiffness_n_m", "a finite stiffness > 0 N/m"),
            (|m| m.closures[0].damping_n_s_m = -1.0, "loop \"pin\", damping_n_s_m", ">= 0 N·s/m"),
            (|m| m.closures[0].inertia_kg = -1.0, "loop \"pin\", inertia_kg", ">= 0 kg"),
        ],
    );
}

#[test]
fn air_around_it() {
    fn polar(angles_rad: &[f64]) -> Option<Polar> {
        let row = |angle_rad: &f64| PolarRow { angle_rad: *angle_rad, lift: 0.0, drag: 0.0, moment: 0.0 };
        Some(Polar { rows: angles_rad.iter().map(row).collect() })
    }
    check(
        || sound(Air::strips()),
        &[
            (|m| air(m).density_kg_m3 = 0.0, "air, density_kg_m3", "> 0 kg/m³"),
            (|m| air(m).wind_m_s.x = NAN, "air, wind_m_s", "3 finite velocities"),
            (|m| air(m).step_s = 0.0, "air, step_s", "a finite time > 0 s"),
            (
                |m| air(m).coupling = Coupling::Iterated { tolerance: 1.0, most_iterations: 50 },
                "air, coupling_tolerance",
                "from 1e-12 to 0.1",
            ),
            (
                |m| air(m).coupling = Coupling::Iterated { tolerance: 1e-4, most_iterations: 0 },
                "air, coupling_iterations",
                "from 1 to 1000",
            ),
            (|m| air(m).surfaces.clear(), "air, model", "at least one surface"),
            (|m| air(m).surfaces[0].body = 9, "surface", "a surface on body 9"),
            (
                |m| {
                    let again = air(m).surfaces[0].clone();
                    air(m).surfaces.push(again);
                    let last = air(m).surfaces.len() - 1;
                    air(m).parts[0].surfaces.push(last);
                },
                "surface \"inner\", body",
                "a body without a surface",
            ),
            (
                |m| {
                    let mut other = air(m).surfaces[0].clone();
                    other.body = 1;
                    air(m).surfaces.insert(0, other);
                    let last = air(m).surfaces.len() - 1;
                    air(m).parts[0].surfaces.push(last);
                },
                "surface \"inner\"",
                "in the order of their bodies",
            ),
            (|m| air(m).surfaces[0].other_half = Some(3), "surface \"inner\", other_half", "a body with a surface"),
            (
                |m| (air(m).surfaces[0].positions_m, air(m).surfaces[0].chords) = (Vec::new(), Vec::new()),
                "surface \"inner\", strips",
                "from 1 to 1000",
            ),
            (|m| air(m).surfaces[0].chord_panels = 0, "surface \"inner\", chord_panels", "from 1 to 1000"),
            (|m| air(m).surfaces[0].positions_m[1] = 0.0, "surface \"inner\", positions_m", "ascending lengths"),
            (|m| air(m).surfaces[0].chords[1].leading_m.x = NAN, "surface \"inner\", chords", "finite length > 0 m"),
            (
                |m| {
                    air(m).surfaces[0].chords.pop();
                },
                "surface \"inner\", chords",
                "at every edge",
            ),
            (|m| air(m).surfaces[0].profile.lift_slope_1_rad = -1.0, "surface \"inner\", lift_slope_1_rad", ">= 0"),
            (|m| air(m).surfaces[0].profile.drag_coefficient = -1.0, "surface \"inner\", drag_coefficient", ">= 0"),
            (
                |m| air(m).surfaces[0].profile.moment_coefficient = NAN,
                "surface \"inner\", moment_coefficient",
                "finite",
            ),
            (|m| air(m).surfaces[0].profile.zero_lift_angle_rad = NAN, "surface \"inner\", zero_lift_angle_rad", "rad"),
            (|m| air(m).surfaces[0].profile.polar = polar(&[]), "surface \"inner\", polar", "1 to 1000 rows"),
            (|m| air(m).surfaces[0].profile.polar = polar(&[0.1, 0.0]), "surface \"inner\", polar", "ascending"),
            (|m| air(m).surfaces[0].profile.polar = polar(&[0.0, 4.0]), "surface \"inner\", polar", "from -pi to pi"),
            (|m| air(m).gusts[0].name = "a b".into(), "gust \"a b\"", "an identifier"),
            (|m| air(m).gusts[0].direction = Vector3::zeros(), "gust \"up\", direction", "not all 0"),
            (|m| air(m).gusts[0].velocity_m_s.x = NAN, "gust \"up\", velocity_m_s", "3 finite velocities"),
            (|m| air(m).gusts[0].origin_m.x = NAN, "gust \"up\", origin_m", "3 finite lengths"),
            (|m| air(m).gusts[0].start_s = NAN, "gust \"up\", start_s", "a finite time in s"),
            (|m| air(m).gusts[0].speed_m_s = 0.0, "gust \"up\", speed_m_s", "> 0 m/s"),
            (
                |m| air(m).gusts[0].shape = GustShape::OneMinusCosine { length_m: 0.0 },
                "gust \"up\", length_m",
                "a finite length > 0 m",
            ),
            (
                |m| air(m).gusts[0].shape = GustShape::Table([[1.0, 0.0], [1.0, 1.0]].into()),
                "gust \"up\", table",
                "ascending distances",
            ),
            (
                |m| air(m).gusts[0].shape = GustShape::Table([[1.0, NAN]].into()),
                "gust \"up\", table",
                "of finite numbers",
            ),
            (
                |m| air(m).gusts[0].shape = turbulence(0.0, &[0.0; 4]),
                "gust \"up\", resolution_m",
                "a finite length > 0 m",
            ),
            (|m| air(m).gusts[0].shape = turbulence(1.0, &[0.0; 3]), "gust \"up\", values", "at least 4"),
            (|m| air(m).gusts[0].shape = turbulence(1.0, &[NAN; 4]), "gust \"up\", values", "finite numbers"),
        ],
    );
    check(
        || sound(Air::lattice()),
        &[
            (|m| lattice(m).wake_rows = 0, "air, wake_rows", "from 1 to 10000"),
            (|m| lattice(m).threads = 0, "air, threads", "from 1 to 256"),
            (|m| lattice(m).core_radius_m = 0.0, "air, core_radius_m", "a finite length > 0 m"),
            (|m| lattice(m).mirror_normal = Some(Vector3::zeros()), "air, mirror_normal", "not all 0"),
        ],
    );
    let taken = parts(Air::lattice()).surface(LiftingSurface::on("tail", 2).chord_panels(1000)).build();
    assert_eq!(taken.map(|_| ()), Ok(()), "2000 and 16 panels");
    let large = parts(Air::lattice()).surface(LiftingSurface::on("tail", 6).chord_panels(1000)).build().unwrap_err();
    assert_eq!(
        large.to_string(),
        "surface: a lattice of 6016 panels is not allowed; allowed: at most 5000 panels: strips times chord_panels, of all \
         surfaces together"
    );
    let long = parts(Air::lattice().wake_rows(10_000)).surface(LiftingSurface::on("tail", 20)).build().unwrap_err();
    assert!(long.to_string().contains("air, wake_rows: a wake of 240000 panels"), "{long}");
}

#[test]
fn solver_and_experiment() {
    check(
        || sound(Air::strips()),
        &[
            (|m| m.solver.tolerance = 1.0, "solver, tolerance", "from 1e-12 to 0.1"),
            (|m| m.solver.rho_infinity = NAN, "solver, rho_infinity", "from 0 to 1"),
            (|m| m.solver.max_step_s = NAN, "solver, max_step_s", "a finite time > 0 s"),
            (|m| m.solver.min_step_s = 0.0, "solver, min_step_s", "a finite time > 0 s"),
            (|m| m.solver.min_step_s = 1.0, "solver, min_step_s", "< max_step_s = 0.005 s"),
            (|m| m.solver.max_step_s = 1e-9, "solver, max_step_s", "> min_step_s = 1e-9 s"),
            (|m| m.solver.fixed_step_s = Some(0.0), "solver, fixed_step_s", "a finite time > 0 s"),
            (|m| m.solver.method = Method::Rk4, "solver, fixed_step_s", "no error estimate"),
            (
                |m| {
                    (m.solver.method, m.solver.most_iterations) = (Method::Sdirk2, Some(4));
                    m.solver.fixed_step_s = Some(1e-3);
                },
                "solver, mode",
                "or coupling =",
            ),
            (|m| m.experiment.start_time_s = NAN, "simulation, start_time_s", "a finite time in s"),
            (|m| m.experiment.stop_time_s = NAN, "simulation, stop_time_s", "a finite time in s"),
            (|m| m.experiment.step_s = 0.0, "simulation, step_s", "a finite time > 0 s"),
            (|m| m.experiment.step_s = 0.5, "simulation, step_s", "<= 0.4 s, the duration of the simulation"),
            (|m| m.experiment.stop_time_s = 0.0, "simulation, stop_time_s", "> start_time_s = 0 s"),
            (|m| m.experiment.start_time_s = 1.0, "simulation, start_time_s", "< stop_time_s = 0.4 s"),
        ],
    );
    let real_time = || {
        let mut machine = sound(Air::strips());
        let fixed_step_s = Some(1e-3);
        machine.air = None;
        machine.solver = Solver { method: Method::Sdirk2, fixed_step_s, most_iterations: Some(4), ..Solver::default() };
        machine
    };
    check(
        real_time,
        &[
            (|m| m.solver.most_iterations = Some(11), "solver, most_iterations", "from 1 to 10"),
            (|m| m.solver.method = Method::Esdirk4, "solver, method", "\"sdirk2\""),
            (|m| m.solver.fixed_step_s = None, "solver, fixed_step_s", "real-time mode have a fixed length"),
        ],
    );
}

/// Errors that only the builder can detect, when it resolves names.
#[test]
fn parts_by_name() {
    let beam = |name| Body::beam(name, 0.15, plate()).elements(2);
    let inner = || Machine::builder("wing").body(beam("inner"), Joint::clamped("mount"));
    let fold = || Joint::revolute("fold", [0.0, 1.0, 0.0]);
    let cases: Vec<(MachineBuilder, &str)> = vec![
        (Machine::builder("wing"), "body: a model without bodies"),
        (
            inner().body(beam("outer"), fold().on("iner")),
            "joint \"fold\", parent: \"iner\" is not allowed; allowed: the root or a body: \"root\" or \"inner\" or \"outer\"",
        ),
        (
            inner().body(beam("outer"), fold().on("mount")),
            "a body, not a joint (joint \"mount\" has the child \"inner\")",
        ),
        (
            inner().body(beam("outer"), fold().on("outer")),
            "joint \"fold\", parent: \"outer\" is not allowed; allowed: a chain of parents that ends at the root; here \
             the parents form a cycle: outer -> outer",
        ),
        (
            inner().body(beam("a"), Joint::ball("ja").on("b")).body(beam("b"), Joint::ball("jb").on("a")),
            "joint \"ja\", parent: \"b\" is not allowed; allowed: a chain of parents that ends at the root; here the \
             parents form a cycle: a -> b -> a",
        ),
        (inner().body(beam("inner"), fold()), "body \"inner\": the name \"inner\" is not allowed"),
        (inner().body(beam("outer"), fold().on_at("inner", 0.2)), "joint \"fold\", parent_position_m: 0.2"),
        (inner().body(beam("outer"), Joint::revolute("fold", [0.0; 3])), "joint \"fold\", axis: [0, 0, 0]"),
        (inner().body(beam("outer"), Joint::universal("u", [0.0; 3], [1.0, 0.0, 0.0])), "joint \"u\", axis: [0, 0, 0]"),
        (
            inner().body(beam("outer"), Joint::ball("b").latch(Latch::with_ratio(2.0))),
            "joint \"b\", latch: a latch is not allowed; allowed: this key only with type = \"revolute\" or \"prismatic\" or \"sliding\"",
        ),
        (inner().body(beam("outer"), Joint::clamped("c").start_angle_rad(1.0)), "joint \"c\", start_angle_rad: 1"),
        (inner().body(beam("outer"), Joint::clamped("c").start_rate_rad_s(1.0)), "joint \"c\", start_rate_rad_s: 1"),
        (inner().body(beam("outer"), Joint::clamped("c").release(false)), "joint \"c\", release: false"),
        (inner().body(beam("outer"), Joint::clamped("c").locked()), "joint \"c\", motion: Locked"),
        (inner().body(beam("outer"), Joint::free("f").motor(Motor::default())), "joint \"f\", motor: a motor"),
        (inner().body(beam("outer"), Joint::ball("b").spring(Spring::default())), "joint \"b\", spring: a spring"),
        (
            inner().body(beam("outer"), Joint::ball("b").start_velocity_m_s([1.0, 0.0, 0.0])),
            "joint \"b\", start_velocity_m_s: [1, 0, 0]",
        ),
        (
            inner().body(beam("outer"), fold().start_angular_velocity_rad_s([1.0, 0.0, 0.0])),
            "joint \"fold\", start_angular_velocity_rad_s: [1, 0, 0]",
        ),
        (
            inner().body(beam("outer"), Joint::ball("b").motor(Motor { inertia_kg_m2: 1.0, ..Motor::default() })),
            "joint \"b\", motor, inertia_kg_m2: 1",
        ),
        (
            inner().body(beam("outer"), fold().latch(Latch::with_ratio(2.0))),
            "joint \"fold\", latch, stiffness_ratio: 2 is not allowed; allowed: a ratio only with a motor or a spring of stiffness > 0",
        ),
        (
            inner().body(beam("outer"), fold().latch(Latch::with_ratio(1.0))),
            "joint \"fold\", latch, stiffness_ratio: 1 is not allowed; allowed: a finite number > 1",
        ),
        (
            inner().body(
                beam("outer"),
                fold().motor(Motor { stiffness_n_m_rad: 1e29, ..Motor::default() }).latch(Latch::with_ratio(1e9)),
            ),
            "a ratio that gives a finite stiffness > 0 N·m/rad",
        ),
        (
            inner().body(beam("outer"), fold().start_angle_rad(1.0).prescribed(Motion::Polynomial(vec![0.0]))),
            "no start angle with motion = \"prescribed\"",
        ),
        (inner().body(beam("outer").load_stations(usize::MAX), fold()), "body \"outer\", load_stations"),
        (inner().body(Body::beam("outer", 1.0, plate()), fold()), "body \"outer\", elements: 0 is not allowed"),
        (
            inner().mass("x", AttachedMass::point("m", 0.0, 1.0)),
            "mass \"m\", body: \"x\" is not allowed; allowed: a body: \"inner\"",
        ),
        (inner().load("l", "x", 1, Wrench::default()), "load \"l\", body: \"x\""),
        (
            inner().load("l", "inner", 0, Wrench::default()),
            "load \"l\", station: 0 is not allowed; allowed: a whole number from 1 to 4",
        ),
        (
            inner().load("l", "inner", 1, Wrench::default()).load("l", "inner", 1, Wrench::default()),
            "a name that no other load has",
        ),
        (
            inner().body(beam("outer").load_stations(0), fold()).load("l", "outer", 1, Wrench::default()),
            "\"outer\" has none",
        ),
        (inner().gauge(Gauge::on("g", "x", 0.0)), "gauge \"g\", body: \"x\""),
        (inner().gauge(Gauge::on("g", "inner", 0.0).direction([0.0; 3])), "gauge \"g\", direction: [0, 0, 0]"),
        (inner().closure(Closure::between("pin", ["inner", "x"], 1.0)), "loop \"pin\", bodies: \"x\""),
        (
            inner().closure(Closure::between("pin", ["root", "inner"], 1.0).positions_m([0.1, 0.1])),
            "loop \"pin\", positions_m: [0.1, 0.1]",
        ),
        (
            inner().surface(LiftingSurface::on("inner", 4)),
            "surface \"inner\": a surface, gust or control surface without aerodynamics",
        ),
        (inner().air(Air::strips()), "air, model: aerodynamics without a surface"),
        (inner().air(Air::strips()).surface(LiftingSurface::on("x", 4)), "surface \"x\", body: \"x\""),
        (
            inner().air(Air::strips()).surface(LiftingSurface::on("inner", 4)),
            "air, step_s: none is not allowed; allowed: a finite time > 0 s: it has no default",
        ),
        (inner().air(Air::none()).surface(LiftingSurface::on("inner", usize::MAX)), "surface \"inner\", strips"),
        (
            inner().air(Air::none()).surface(LiftingSurface::on("inner", 4).elastic_axis_fraction(11.0)),
            "surface \"inner\", elastic_axis_fraction",
        ),
        (
            inner().air(Air::none()).surface(LiftingSurface::on("inner", 4).chord_m(Profile::constant(0.0))),
            "a chord that falls to 0 m",
        ),
        (
            inner().air(Air::none()).surface(LiftingSurface::on("inner", 4).incidence_deg(Profile::constant(NAN))),
            "surface \"inner\", incidence_deg, polynomial",
        ),
        (
            inner().body(Body::rigid("stone"), Joint::clamped("glue").offset_m([1.0, 0.0, 0.0])),
            "joint \"glue\", offset_m: [1, 0, 0] is not allowed; allowed: no offset from the root",
        ),
        (
            inner().body(Body::rigid("stone").mass_damping_1_s(2.0), Joint::clamped("glue").on("inner")),
            "body \"stone\", mass_damping_1_s: 2 is not allowed; allowed: 0 on a rigid body",
        ),
        (
            inner()
                .body(Body::rigid("stone"), Joint::clamped("glue").on("inner"))
                .internal_load(InternalLoad::on("s", "stone", 0.0)),
            "internal_load \"s\", body: \"stone\" is not allowed; allowed: a flexible body; this one is rigid and has no sections",
        ),
        (
            inner()
                .internal_load(InternalLoad::on("s", "inner", 0.0))
                .internal_load(InternalLoad::on("s", "inner", 0.1)),
            "internal_load \"s\"",
        ),
        (inner().internal_load(InternalLoad::on("s", "x", 0.0)), "internal_load \"s\", body: \"x\""),
        (
            inner().body(Body::rigid("stone"), Joint::clamped("glue").on("inner")).gauge(Gauge::on("g", "stone", 0.0)),
            "gauge \"g\", body: \"stone\" is not allowed; allowed: a flexible body",
        ),
        (
            inner()
                .body(Body::rigid("stone"), Joint::clamped("glue").on("inner"))
                .air(Air::none())
                .surface(LiftingSurface::on("stone", 4)),
            "surface \"stone\", body: \"stone\" is not allowed; allowed: a flexible body",
        ),
        (
            inner().air(Air::none()).gust(GustBuilder::new("g", GustShape::SharpEdge, [1.0, 0.0, 0.0])),
            "gust \"g\", direction: [0, 0, 0]",
        ),
        (
            inner()
                .air(Air::none())
                .gust(GustBuilder::new("g", GustShape::SharpEdge, [1.0, 0.0, 0.0]).direction([1.0, 0.0, 0.0])),
            "gust \"g\", speed_m_s: 0",
        ),
        (
            inner()
                .body(Body::beam("rod", 1.0, plate_by_numbers()).elements(2), Joint::ball("hip"))
                .air(Air::none())
                .surface(LiftingSurface::on("rod", 4)),
            "surface \"rod\", chord_m: none is not allowed; allowed: a finite length > 0 m: the body's section has no width",
        ),
        (
            inner().air(Air::lattice().mirror_normal([0.0; 3])).surface(LiftingSurface::on("inner", 4)),
            "air, mirror_normal: [0, 0, 0]",
        ),
        (
            inner().air(Air::strips().mirror_normal([1.0, 0.0, 0.0])).surface(LiftingSurface::on("inner", 4)),
            "air, mirror_normal: a mirror plane with strips is not allowed; allowed: a mirror plane with a lattice",
        ),
    ];
    for (builder, expected) in cases {
        let refused = match builder.build() {
            Err(refused) => refused,
            Ok(_) => panic!("{expected}: accepted"),
        };
        assert_eq!(refused.faults.len(), 1, "{expected}: {refused}");
        assert!(refused.to_string().contains(expected), "{expected:?} is not in {refused}");
    }
}

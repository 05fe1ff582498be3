//! Consistency of the table with itself and with the plant.

mod air;
mod looped;
mod spatial;

use super::*;
use foldwing_engine::machine::{Beyond, GeneratorLaw, JointKind, JointMotion, Motion, Parent, Revolute, Spring};
use foldwing_file as config;
use spatial::{SPATIAL, with_spins};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

const WING: &str = include_str!("../../../../examples/models/folding_wing.toml");
const THREE: &str = include_str!("../../../../examples/models/three_bodies.toml");
const BRANCHED: &str = include_str!("../../../../examples/models/branched.toml");

fn machine(text: &str) -> Machine {
    config::parse(text, "model.toml").expect("valid")
}

/// Changes every fold joint, after tilting its hinge so that no two are parallel.
fn with_joints(text: &str, change: impl Fn(usize, &mut Revolute)) -> Machine {
    let mut machine = machine(text);
    for (index, body) in machine.bodies.iter_mut().enumerate() {
        if let JointKind::Revolute(revolute) = &mut body.joint.kind {
            let tilt = nalgebra::Vector3::new(0.1, 0.0, 0.2) * index as f64;
            revolute.axis = (revolute.axis + tilt).normalize();
            change(index, revolute);
        }
    }
    machine
}

/// Three bodies, the last on a prismatic joint with a rate in m/s and a spring.
fn with_slides(rate_m_s: f64) -> Machine {
    let mut machine = with_joints(THREE, |_, revolute| {
        revolute.start_rate_rad_s = rate_m_s;
        let spring = Spring { stiffness_n_m_rad: 0.1, damping_n_m_s_rad: 0.01, rest_angle_rad: 0.3 };
        revolute.spring = Some(spring);
    });
    let joint = &mut machine.bodies[2].joint.kind;
    if let JointKind::Revolute(own) = joint {
        *joint = JointKind::Prismatic(own.clone());
    }
    machine
}

/// Shipped models and variants that together exercise every branch of the code; with two pairs of elements, since with four the effect of
/// the root's jerk on the tip is too small.
fn machines() -> Vec<(&'static str, Machine)> {
    let last_prescribed = |index: usize, revolute: &mut Revolute| {
        if index > 1 {
            revolute.motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.3, 0.5, 1.5]));
        }
    };
    let trees = vec![
        ("wing", machine(&WING.replace("elements = 4", "elements = 2"))),
        ("three bodies", with_joints(THREE, |_, _| ())),
        ("branched", machine(BRANCHED)),
        (
            "with a generator",
            with_joints(THREE, |index, revolute| {
                if index == 1 {
                    revolute.start_rate_rad_s = 0.7;
                    revolute.generator = Some(GeneratorLaw {
                        gear_ratio: 3.0,
                        rows: vec![[1.0, 0.02], [4.0, 0.05]],
                        square_gain_n_m_s2: None,
                        beyond: Beyond::Torque,
                        efficiency: 0.9,
                        connected: true,
                    });
                }
            }),
        ),
        ("turning at the start", with_joints(THREE, |_, revolute| revolute.start_rate_rad_s = 0.7)),
        (
            "latched at the start",
            with_joints(THREE, |_, revolute| {
                if let Some(latch) = &mut revolute.latch {
                    latch.initially_closed = true;
                }
            }),
        ),
        (
            "caught at the start",
            with_joints(THREE, |_, revolute| {
                revolute.start_angle_rad = 0.5;
                if let Some(latch) = &mut revolute.latch {
                    (latch.angle_rad, latch.capture_rad) = (0.5, 0.2);
                }
            }),
        ),
        (
            "with springs of their own",
            with_joints(THREE, |_, revolute| {
                let spring = Spring { stiffness_n_m_rad: 0.1, damping_n_m_s_rad: 0.01, rest_angle_rad: 0.3 };
                (revolute.spring, revolute.start_rate_rad_s) = (Some(spring), 0.7);
            }),
        ),
        ("prescribed", with_joints(THREE, last_prescribed)),
        ("sliding", with_slides(0.0)),
        ("sliding at the start", with_slides(0.7)),
        ("locked", with_joints(BRANCHED, |_, revolute| revolute.motion = JointMotion::Locked)),
        ("spatial", machine(SPATIAL)),
        ("spatial, spinning", with_spins(&["cross", "ball", "flight"])),
        ("spatial, outer ones spinning", with_spins(&["ball", "tail"])),
        ("spatial, drifting", with_spins(&["drift"])),
        ("spatial, drifting and spinning", with_spins(&["drift", "tail"])),
        ("spatial, prescribed", {
            let mut machine = with_spins(&["ball"]);
            if let JointKind::Revolute(revolute) = &mut machine.bodies[0].joint.kind {
                revolute.motion = JointMotion::Prescribed(Motion::Polynomial(vec![0.3, 0.5, 1.5]));
            }
            machine
        }),
        ("nothing but free bodies", {
            let mut machine = machine(SPATIAL);
            machine.bodies.drain(..3);
            machine.gauges.remove(0);
            machine.gauges[0].body -= 3;
            for body in &mut machine.bodies {
                if let Parent::Body { index, .. } = &mut body.joint.parent {
                    *index -= 3;
                }
            }
            machine
        }),
    ];
    trees.into_iter().chain(looped::machines()).collect()
}

#[test]
fn the_shipped_model_has_the_promised_names() {
    let interface = Interface::new(&machine(WING));
    let names = "time fold.angle_command fold.external_torque fold.release fold.latch_enable load.inner[1].force.x \
        load.outer[4].moment.z gravity.x root.acceleration.y root.angular_velocity.z root.angular_acceleration.x \
        fold.angle fold.angular_velocity fold.holding_torque fold.total_torque fold.motor_torque \
        fold.latch_torque fold.latched fold.latch_time fold.latch_count \
        mount.reaction_force.x fold.reaction_force.y fold.reaction_moment.z tip.angular_velocity.x tip.angular_acceleration.y \
        station.inner[1].acceleration.x station.outer[4].angular_acceleration.z \
        gauge.root.strain root.force.x root.moment.z tip.position.x tip.velocity.y tip.acceleration.z tip.rotation.w \
        station.inner[1].position.x station.outer[4].velocity.y station.outer[4].angular_velocity.z \
        station.inner[2].rotation.z energy.kinetic energy.elastic energy.gravity energy.motor energy.work \
        energy.dissipated energy.total fold.start_angle fold.motor_stiffness fold.motor_damping fold.motor_constant_torque \
        fold.motor_torque_limit fold.motor_rate_limit fold.latch_stiffness body.inner.mass_factor body.outer.stiffness_factor \
        body.inner.mass_damping body.outer.stiffness_damping solver.tolerance solver.max_step solver.min_step \
        solver.steps solver.rejections solver.failures solver.iterations solver.factorizations solver.events";
    for name in names.split_whitespace() {
        assert!(interface.find(name).is_some(), "{name} is missing");
    }
    let count = |causality| interface.variables().iter().filter(|row| row.causality == causality).count();
    assert_eq!((count(Causality::Input), count(Causality::Output)), (64, 234));
}

#[test]
fn rows_are_well_formed() {
    for (label, machine) in machines() {
        let interface = Interface::new(&machine);
        let dependencies = interface.dependencies(&machine);
        let mut names = BTreeSet::new();
        for (position, row) in interface.variables().iter().enumerate() {
            let name = &row.name;
            assert_eq!(row.value_reference as usize, position, "{label}: {name}");
            assert!(names.insert(name.clone()), "{label}: {name} twice");
            assert!(!row.description.is_empty() && !row.description.contains("  "), "{label}: {name}");
            let is_real = matches!(row.value, Value::Real(_));
            assert_eq!(row.declared_type.is_some(), is_real, "{label}: {name}");
            assert!(
                row.declared_type.is_none_or(|declared| TYPES.iter().any(|known| known.name == declared)),
                "{name}"
            );
            let expected = match row.causality {
                Causality::Input | Causality::Independent => None,
                Causality::Parameter => Some(Initial::Exact),
                Causality::Output | Causality::Local => Some(Initial::Calculated),
            };
            assert_eq!(row.initial, expected, "{label}: {name}");
            if row.variability == Variability::Continuous {
                assert!(is_real, "{label}: {name} is continuous but no Real");
            }
            if let (Value::Real(start), Some((min, max))) = (row.value, row.range) {
                assert!(
                    min.is_finite() && max.is_finite() && min <= start && start <= max,
                    "{label}: {name} = {start}"
                );
            }
            if row.causality != Causality::Output {
                let none = Dependencies::default();
                assert_eq!(dependencies[row.value_reference as usize], none, "{label}: {name}");
            }
        }
    }
}

#[test]
fn start_values_and_order_are_the_plant_s() {
    for (label, machine) in machines() {
        let interface = Interface::new(&machine);
        let topology = topology::Topology::new(&machine);
        let plant = Plant::new(Arc::new(machine.clone()));
        assert_eq!(plant.revolute_joints(), topology.revolutes, "{label}");
        assert_eq!(plant.spatial_joints(), topology.spatials, "{label}");
        assert_eq!(plant.tip_bodies(), topology.tips, "{label}");
        for row in interface.variables() {
            if matches!(row.causality, Causality::Input | Causality::Parameter) {
                let value = interface.get(&plant, plant.outputs(), row.value_reference);
                assert_eq!(value, Some(row.value), "{label}: {}", row.name);
            }
        }
    }
}

#[test]
fn what_is_set_is_read_back_and_nothing_else_changes() {
    let machine = machine(THREE);
    let interface = Interface::new(&machine);
    let mut plant = Plant::new(Arc::new(machine));
    let known = |row: &&Variable| matches!(row.causality, Causality::Input | Causality::Parameter);
    let read = |plant: &Plant| -> Vec<Option<Value>> {
        let rows = interface.variables().iter().filter(known);
        rows.map(|row| interface.get(plant, plant.outputs(), row.value_reference)).collect()
    };
    for (position, row) in interface.variables().iter().filter(known).enumerate() {
        let mut expected = read(&plant);
        let value = other(row, row.value);
        interface.set(&mut plant, row.value_reference, value).expect("settable");
        expected[position] = Some(value);
        assert_eq!(read(&plant), expected, "{}", row.name);
    }
}

/// Another value that the row allows, different enough to have a visible effect on dependent outputs.
fn other(row: &Variable, value: Value) -> Value {
    match value {
        Value::Boolean(value) => Value::Boolean(!value),
        // Below any torque or rate that a motor requires, so that the limit is active.
        Value::Real(_) if row.name.ends_with("_limit") => Value::Real(1e-5),
        Value::Real(value) if row.range.is_some_and(|(min, _)| min >= 0.0) => Value::Real(1.5 * value + 1e-3),
        Value::Real(value) => Value::Real(value + 0.37),
        Value::Integer(value) => Value::Integer(value + 1),
    }
}

/// A plant without symmetries: all inputs and start angles differ from zero and from each other.
fn generic(machine: &Machine, interface: &Interface) -> Plant {
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    for row in interface.variables() {
        let value = match (row.causality, row.value) {
            (Causality::Input, Value::Real(value)) => value + random(),
            (Causality::Parameter, Value::Real(value))
                if row.name.ends_with(".start_angle") || row.name.ends_with(".start_position") =>
            {
                0.8 * value + 0.1 * random()
            }
            (Causality::Parameter, Value::Real(value)) if row.name.ends_with("damping") => value + 0.1,
            // A limit would prevent the command from acting instantaneously.
            (Causality::Parameter, Value::Real(_)) if row.name.ends_with("_limit") => 1e30,
            _ => continue,
        };
        interface.set(&mut plant, row.value_reference, Value::Real(value)).expect("in range");
    }
    plant
}

/// Values of all outputs by reference.
fn outputs(interface: &Interface, plant: &Plant) -> BTreeMap<u32, f64> {
    let rows = interface.variables().iter().filter(|row| row.causality == Causality::Output);
    rows.map(|row| {
        let value = match interface.get(plant, plant.outputs(), row.value_reference) {
            // Strains are small: in millionths they are comparable with the rest.
            Some(Value::Real(value)) if row.declared_type == Some("Strain") => 1e6 * value,
            Some(Value::Real(value)) => value,
            Some(Value::Integer(value)) => f64::from(value),
            Some(Value::Boolean(value)) => f64::from(u8::from(value)),
            None => panic!("{} cannot be read", row.name),
        };
        (row.value_reference, value)
    })
    .collect()
}

/// Pairs of output and known for which a test has found a dependence.
struct Seen {
    /// Relative change above which an output counts as dependent.
    sure: f64,
    /// Changes above any round-off: these dependences must be declared.
    surely: Pairs,
    /// Changes so small that they may be a weak dependence or round-off: these may be declared.
    perhaps: Pairs,
}

impl Seen {
    /// Relative change that may be round-off.
    const PERHAPS: f64 = 1e-13;

    fn beyond(sure: f64) -> Self {
        Self { sure, surely: Pairs::new(), perhaps: Pairs::new() }
    }

    fn add(
        &mut self,
        interface: &Interface,
        known: &Variable,
        before: &BTreeMap<u32, f64>,
        after: &BTreeMap<u32, f64>,
    ) {
        for (row, (a, b)) in before.iter().map(|(row, a)| (row, (*a, after[row]))) {
            let change = (a - b).abs() / a.abs().max(b.abs()).max(1e-3);
            let pair = || (interface.variables()[*row as usize].name.clone(), known.name.clone());
            if change > self.sure {
                self.surely.insert(pair());
            }
            if change > Self::PERHAPS {
                self.perhaps.insert(pair());
            }
        }
    }
}

/// Name without component and station.
fn group(name: &str) -> String {
    let name = ["x", "y", "z", "w"].iter().find_map(|axis| name.strip_suffix(&format!(".{axis}"))).unwrap_or(name);
    name.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// Pairs of output and known.
type Pairs = BTreeSet<(String, String)>;

/// Every dependence found must be declared, row by row. Every declared one must be found for at least one component of the two vectors: a
/// straight wing happens to decouple some components.
fn compare(label: &str, declared: &Pairs, seen: &Seen) -> Vec<String> {
    let groups =
        |pairs: &Pairs| -> Pairs { pairs.iter().map(|(output, known)| (group(output), group(known))).collect() };
    let missing =
        seen.surely.difference(declared).map(|(output, known)| format!("{label}: {output} depends on {known} unsaid"));
    let (declared, seen) = (groups(declared), groups(&seen.perhaps));
    // the load of a lock is zero while the joint rotates freely, as in most of the models
    let idle = declared
        .difference(&seen)
        .filter(|(output, _)| !output.ends_with(".holding_torque") && !output.ends_with(".holding_force"))
        .map(|(output, known)| format!("{label}: {output} does not depend on {known}"));
    missing.chain(idle).collect()
}

/// Declared pairs whose known is varied by the test.
fn declared(
    (machine, interface): (&Machine, &Interface),
    of: impl Fn(&Dependencies) -> &[(u32, DependencyKind)],
    varied: impl Fn(&Variable) -> bool,
) -> Pairs {
    let (rows, dependencies) = (interface.variables(), interface.dependencies(machine));
    rows.iter()
        .zip(&dependencies)
        .flat_map(|(row, dependencies)| of(dependencies).iter().map(move |(known, _)| (row, &rows[*known as usize])))
        .filter(|(_, known)| varied(known))
        .map(|(row, known)| (row.name.clone(), known.name.clone()))
        .collect()
}

#[test]
fn initial_dependencies_are_what_the_plant_shows() {
    let mut wrong = Vec::new();
    for (label, machine) in machines() {
        let interface = Interface::new(&machine);
        let mut plant = generic(&machine, &interface);
        plant.initialize(0.2).expect("start values");
        let before = outputs(&interface, &plant);
        // above any round-off, even of forces in a freely falling body
        let mut seen = Seen::beyond(1e-9);
        for known in interface.variables() {
            let mut plant = generic(&machine, &interface);
            let mut start_s = 0.2;
            match known.causality {
                Causality::Independent => start_s = 0.4,
                Causality::Input | Causality::Parameter => {
                    let value = interface.get(&plant, plant.outputs(), known.value_reference).expect("a value");
                    interface.set(&mut plant, known.value_reference, other(known, value)).expect("in range");
                }
                Causality::Output | Causality::Local => continue,
            }
            plant.initialize(start_s).expect("start values");
            seen.add(&interface, known, &before, &outputs(&interface, &plant));
        }
        let declared = declared((&machine, &interface), |of| &of.initial, |_| true);
        wrong.extend(compare(label, &declared, &seen));
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// In a start from equilibrium, no undeclared dependence is found; the dependences on stiffness and loads are found.
#[test]
fn initial_dependencies_of_an_equilibrium_are_declared() {
    let mut machine = with_joints(THREE, |_, revolute| {
        if let Some(latch) = &mut revolute.latch {
            latch.initially_closed = true;
        }
    });
    machine.experiment.start = foldwing_engine::machine::StartState::Equilibrium;
    let interface = Interface::new(&machine);
    let mut plant = generic(&machine, &interface);
    plant.initialize(0.2).expect("an equilibrium");
    let before = outputs(&interface, &plant);
    let declared = declared((&machine, &interface), |of| &of.initial, |_| true);
    let mut seen = Seen::beyond(1e-9);
    let varied = |row: &&Variable| matches!(row.causality, Causality::Input | Causality::Parameter);
    for known in interface.variables().iter().filter(varied) {
        let mut plant = generic(&machine, &interface);
        let value = interface.get(&plant, plant.outputs(), known.value_reference).expect("a value");
        interface.set(&mut plant, known.value_reference, other(known, value)).expect("in range");
        plant.initialize(0.2).expect("an equilibrium");
        seen.add(&interface, known, &before, &outputs(&interface, &plant));
    }
    let undeclared: Vec<_> = seen.surely.difference(&declared).collect();
    assert!(undeclared.is_empty(), "{undeclared:?}");
    let body = &machine.bodies[0].name;
    for known in ["gravity.z".to_owned(), format!("body.{body}.stiffness_factor"), format!("load.{body}[1].force.z")] {
        let pair = ("tip.position.z".to_owned(), known);
        assert!(seen.surely.contains(&pair), "{pair:?}");
    }
}

/// A step of 1e-15 s leaves the state unchanged, so an output that changes with an input depends on it directly.
#[test]
fn dependencies_at_a_communication_point_are_what_the_plant_shows() {
    const INSTANT_S: f64 = 1e-15;
    const CUT_S: f64 = 0.21 + 1e-12;
    let mut wrong = Vec::new();
    for (label, machine) in machines() {
        let interface = Interface::new(&machine);
        let mut start = generic(&machine, &interface);
        start.initialize(0.2).expect("start values");
        start.step(0.21).expect("a step");
        // A changed input interrupts the integrator's step: later steps start from the state itself, not from interpolation.
        start.inputs_mut().root_mut().gravity_m_s2.x += 1e-3;
        start.step(CUT_S).expect("a step");
        let begin = start.snapshot();
        let mut run = |known: Option<&Variable>| {
            start.restore(&begin).expect("own snapshot");
            if let Some(known) = known {
                let value = interface.get(&start, start.outputs(), known.value_reference).expect("a value");
                interface.set(&mut start, known.value_reference, other(known, value)).expect("in range");
            }
            start.step(CUT_S + INSTANT_S).expect("a step");
            outputs(&interface, &start)
        };
        let before = run(None);
        // Switches act through events, which change the state; time advances in every step.
        let varied = |row: &Variable| row.causality == Causality::Input && matches!(row.value, Value::Real(_));
        // larger than the change of a velocity by an acceleration within the step
        let mut seen = Seen::beyond(1e-6);
        for known in interface.variables().iter().filter(|row| varied(row)) {
            seen.add(&interface, known, &before, &run(Some(known)));
        }
        wrong.extend(compare(label, &declared((&machine, &interface), |of| &of.running, varied), &seen));
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

/// Every row belongs to one signal, in order, and reads the component given by its name.
#[test]
fn signals_cover_all_rows_with_their_components() {
    for (name, machine) in machines() {
        let interface = Interface::new(&machine);
        let mut next = 0;
        for signal in interface.signals() {
            assert_eq!(signal.first_reference, next, "{name}: {}", signal.name);
            for (i, component) in signal.shape.components().iter().enumerate() {
                let row = &interface.variables()[next as usize + i];
                let expected = match signal.shape {
                    Shape::Scalar => signal.name.clone(),
                    Shape::Vector | Shape::Quaternion => format!("{}.{component}", signal.name),
                };
                assert_eq!((&row.name, row.causality), (&expected, signal.causality), "{name}");
            }
            next += u32::try_from(signal.shape.components().len()).expect("few");
        }
        assert_eq!(next as usize, interface.variables().len(), "{name}");
        // no number of the flat inputs is read by two rows, and no row reads beyond them
        let mut plant = Plant::new(Arc::new(machine));
        let inputs = interface.variables().iter().filter(|row| row.causality == Causality::Input);
        for (i, row) in inputs.enumerate() {
            let value = match row.value {
                Value::Boolean(on) => Value::Boolean(!on),
                Value::Real(_) | Value::Integer(_) => Value::Real(1e3 + i as f64),
            };
            let before = plant.inputs().values().to_vec();
            interface.set(&mut plant, row.value_reference, value).expect("an input");
            let changed = plant.inputs().values().iter().zip(&before).filter(|(new, old)| new != old).count();
            assert_eq!(changed, 1, "{name}: {}", row.name);
            assert_eq!(interface.get(&plant, plant.outputs(), row.value_reference), Some(value), "{}", row.name);
        }
    }
}

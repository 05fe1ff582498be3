//! Loads and events of the model: loads, reactions, wind, gravity at one time; latches, releases, gusts over time.

use crate::recording::Frame;
use foldwing_engine::load::LoadFrame;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{JointStatus, Plant};
use nalgebra::Vector3;

/// A drawn joint: type, and axis in the first frame of its body.
#[derive(Debug, Clone, PartialEq)]
pub struct HingeScene {
    /// Name.
    pub name: String,
    /// Index of its body.
    pub body: usize,
    /// `revolute`, `prismatic` or `spatial`.
    pub kind: &'static str,
    /// Unit axis in the body's first frame; zero for a joint with several degrees of freedom.
    pub axis: Vector3<f64>,
    /// Index among the joints with one degree of freedom.
    pub freedom: Option<usize>,
    /// The joint has a latch.
    pub has_latch: bool,
}

/// A point mass on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct MassScene {
    /// Name.
    pub name: String,
    /// Index into the model's bodies.
    pub body: usize,
    /// Distance from the inner end in m.
    pub place_m: f64,
    /// Centre of gravity from the axis, section frame, m.
    pub offset_m: Vector3<f64>,
    /// Mass in kg.
    pub mass_kg: f64,
}

/// A load station, with the name of its input: `load.<body>[<number>]`.
#[derive(Debug, Clone, PartialEq)]
pub struct StationScene {
    /// Name.
    pub name: String,
    /// Index into the model's bodies.
    pub body: usize,
}

/// Loads at one time; root frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Acting {
    /// Positions of the load stations in m.
    pub stations_m: Vec<Vector3<f64>>,
    /// Force of the inputs per station in N.
    pub forces_n: Vec<Vector3<f64>>,
    /// Moment of the inputs per station in N·m.
    pub moments_n_m: Vec<Vector3<f64>>,
    /// Aerodynamic force per station in N; zero without aerodynamics.
    pub air_n: Vec<Vector3<f64>>,
    /// Force in N and moment in N·m of the joint on the inner end of every body.
    pub reactions: Vec<[Vector3<f64>; 2]>,
    /// Gravity minus the root's acceleration in m/s².
    pub gravity_m_s2: Vector3<f64>,
    /// Undisturbed wind velocity at the middle of every body in m/s; empty without aerodynamics.
    pub wind_m_s: Vec<Vector3<f64>>,
    /// Circulation per strip in m²/s, surface by surface; empty if it is not available.
    pub circulation_m2_s: Vec<f64>,
}

impl Acting {
    /// Loads at the plant's current time; `frame` contains the sections.
    pub fn of(plant: &Plant, frame: &Frame) -> Self {
        let (outputs, inputs, machine) = (plant.outputs(), plant.inputs(), plant.machine());
        let frames = machine.bodies.iter().flat_map(|body| body.station_positions_m.iter().map(|_| body.load_frame));
        let loads = inputs.stations().iter().zip(outputs.stations()).zip(frames).map(|((load, station), frame)| {
            let turned = |vector: Vector3<f64>| match frame {
                LoadFrame::Root => vector,
                LoadFrame::Section => station.rotation * vector,
            };
            (turned(load.force_n), turned(load.moment_n_m))
        });
        let (forces_n, moments_n_m) = loads.unzip();
        let air = |i: usize| outputs.air_stations().get(i).map_or_else(Vector3::zeros, |wrench| wrench.force_n);
        Self {
            stations_m: outputs.stations().iter().map(|station| station.position_m).collect(),
            forces_n,
            moments_n_m,
            air_n: (0..outputs.stations().len()).map(air).collect(),
            reactions: outputs.joint_reactions().iter().map(|wrench| [wrench.force_n, wrench.moment_n_m]).collect(),
            gravity_m_s2: inputs.root().apparent_gravity_m_s2(),
            wind_m_s: wind_m_s(plant, frame),
            circulation_m2_s: circulation_m2_s(plant, frame),
        }
    }
}

fn wind_m_s(plant: &Plant, frame: &Frame) -> Vec<Vector3<f64>> {
    let Some(air) = &plant.machine().air else { return Vec::new() };
    let inputs = plant.inputs();
    let at = |sections: &Vec<foldwing_engine::plant::SectionState>| {
        let place_m = sections[sections.len() / 2].position_m;
        let gusts: Vector3<f64> = air.gusts.iter().map(|gust| gust.velocity_m_s(frame.time_s, &place_m)).sum();
        inputs.wind_m_s() - inputs.root().angular_velocity_rad_s.cross(&place_m) + gusts
    };
    frame.sections.iter().map(at).collect()
}

fn circulation_m2_s(plant: &Plant, frame: &Frame) -> Vec<f64> {
    if !frame.lattice.is_empty() {
        return frame.lattice.iter().flat_map(|surface| surface.circulation_m2_s.iter().copied()).collect();
    }
    let strips: usize = frame.edges_m.iter().map(|edges| edges.len() - 1).sum();
    let reported = plant.outputs().circulation_m2_s();
    if reported.len() == strips { reported.to_vec() } else { Vec::new() }
}

/// All joints that are not clamped.
pub(crate) fn hinges(machine: &Machine) -> Vec<HingeScene> {
    let mut freedoms = 0;
    let mut found = Vec::new();
    for (body, description) in machine.bodies.iter().enumerate() {
        let joint = &description.joint;
        let one = joint.kind.one_freedom();
        if joint.kind.is_clamped() {
            continue;
        }
        let kind = one.map_or("spatial", |(travel, _)| travel.joint_type());
        found.push(HingeScene {
            name: joint.name.clone(),
            body,
            kind,
            axis: one.map_or_else(Vector3::zeros, |(_, own)| joint.mount.transpose() * own.axis.normalize()),
            freedom: one.map(|_| freedoms),
            has_latch: one.is_some_and(|(_, own)| own.latch.is_some()),
        });
        freedoms += usize::from(one.is_some());
    }
    found
}

/// Point masses of all bodies.
pub(crate) fn masses(machine: &Machine) -> Vec<MassScene> {
    let of = |(body, description): (usize, &foldwing_engine::machine::Body)| {
        let own = |mass: &foldwing_engine::machine::AttachedMass| MassScene {
            name: mass.name.clone(),
            body,
            place_m: mass.position_m,
            offset_m: mass.offset_m,
            mass_kg: mass.mass_kg,
        };
        description.masses.iter().map(own).collect::<Vec<_>>()
    };
    machine.bodies.iter().enumerate().flat_map(of).collect()
}

/// Load stations of all bodies.
pub(crate) fn stations(machine: &Machine) -> Vec<StationScene> {
    let of = |(body, with): (usize, &foldwing_engine::machine::Body)| {
        let name = |number: usize| StationScene { name: format!("load.{}[{number}]", with.name), body };
        (1..=with.station_positions_m.len()).map(name).collect::<Vec<_>>()
    };
    machine.bodies.iter().enumerate().flat_map(of).collect()
}

/// An event of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Time in s.
    pub time_s: f64,
    /// Text of the event, such as `fold latched`.
    pub text: String,
    /// `latch`, `open`, `release`, `hold` or `gust`.
    pub kind: &'static str,
}

/// Detects events of joints from one communication point to the next.
#[derive(Debug, Clone, Default)]
pub struct Watch {
    /// Time in s and the joints at the previous point.
    last: Option<(f64, Vec<JointStatus>)>,
    /// Events so far.
    pub events: Vec<Event>,
}

impl Watch {
    /// Starts the detection; gusts are known from the start.
    pub fn new(machine: &Machine) -> Self {
        let gusts = machine.air.iter().flat_map(|air| &air.gusts);
        let events = gusts
            .map(|gust| Event { time_s: gust.start_s, text: format!("gust {}", gust.name), kind: "gust" })
            .collect();
        Self { last: None, events }
    }

    /// Evaluates the plant's current state. Inputs change at the start of a communication step: releases and openings that they cause
    /// belong to the previous point.
    pub fn include(&mut self, plant: &Plant, joints: &[(String, usize)]) {
        let now: Vec<JointStatus> = plant.joint_statuses().collect();
        if let Some((before_s, last)) = &self.last {
            for (i, (was, is)) in last.iter().zip(&now).enumerate() {
                let name = &joints[i].0;
                let mut add = |time_s: f64, what: &str, kind: &'static str| {
                    self.events.push(Event { time_s, text: format!("{name} {what}"), kind });
                };
                if is.released != was.released {
                    if is.released { add(*before_s, "released", "release") } else { add(*before_s, "held", "hold") }
                }
                if is.latch_count > was.latch_count {
                    add(is.latch_time_s, "latched", "latch");
                } else if was.latched && !is.latched {
                    add(*before_s, "latch opened", "open");
                }
            }
        }
        self.last = Some((plant.time_s(), now));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Recording;
    use crate::recording::tests::{recorded, shipped};
    use foldwing_engine::machine::{InternalLoad, SectionSide};
    use std::sync::Arc;

    /// The shipped wing latches once, at the time given by the latch time output.
    #[test]
    fn a_latch_is_an_event_at_its_own_time() {
        let recording = recorded(shipped("folding_wing"), 150);
        let [event] = recording.watch.events.as_slice() else { panic!("{:?}", recording.watch.events) };
        assert_eq!((event.text.as_str(), event.kind), ("fold latched", "latch"));
        assert_eq!(vec![event.time_s], recording.history.latches_s[0]);
        assert!(!recording.frames[0].latched[0] && recording.frames[150].latched[0]);
    }

    /// Releases and locks by inputs belong to the start of the step; a gust is an event before the run.
    #[test]
    fn releases_are_events_at_the_start_of_their_step() {
        let mut plant = Plant::new(Arc::new(shipped("folding_wing")));
        plant.inputs_mut().joints_mut()[0].release = false.into();
        plant.initialize(0.0).unwrap();
        let mut recording = Recording::new(&plant, 20, 20);
        recording.include(&plant);
        for step in 1..=20 {
            plant.inputs_mut().joints_mut()[0].release = (6..16).contains(&step).into();
            plant.step(f64::from(step) * 1e-3).unwrap();
            recording.include(&plant);
        }
        let events: Vec<_> = recording.watch.events.iter().map(|event| (event.kind, event.time_s)).collect();
        assert_eq!(events, [("release", 5e-3), ("hold", 15e-3)]);
    }

    /// Reactions, gravity and circulation of a frame equal those of the plant; a follower load rotates with its section.
    #[test]
    fn what_acts_is_told_in_the_root_frame() {
        let mut machine = shipped("folding_wing");
        machine.bodies[1].load_frame = LoadFrame::Section;
        let mut plant = Plant::new(Arc::new(machine));
        let first = plant.machine().bodies[0].station_positions_m.len();
        plant.inputs_mut().stations_mut()[first].force_n = Vector3::new(0.0, 0.0, 2.0);
        plant.initialize(0.0).unwrap();
        let mut recording = Recording::new(&plant, 1, 1);
        recording.include(&plant);
        let acting = &recording.frames[0].acting;
        let turned = plant.outputs().stations()[first].rotation * Vector3::new(0.0, 0.0, 2.0);
        assert_eq!(acting.forces_n[first], turned);
        assert!(turned.z < 0.0, "the wing starts folded over: {turned}");
        assert_eq!(acting.reactions[0][0], plant.outputs().joint_reactions()[0].force_n);
        assert_eq!(acting.gravity_m_s2, plant.machine().gravity_m_s2);
        assert_eq!((acting.wind_m_s.len(), acting.circulation_m2_s.len()), (0, 0));
    }

    /// Internal loads along the beams are the outputs at the same positions and sides; forces at the edges of the strips sum to the
    /// aerodynamic force; those of the panels, once the flow is steady, to its component normal to the flat wing.
    #[test]
    fn loads_along_the_bodies_are_those_of_the_outputs() {
        let mut machine = shipped("folding_wing_in_tunnel");
        let places =
            [(0, 0.0, SectionSide::Outboard), (0, 0.028_125, SectionSide::Inboard), (1, 0.15, SectionSide::Inboard)];
        machine.internal_loads = places
            .map(|(body, position_m, side)| InternalLoad {
                name: format!("{body} {position_m}"),
                body,
                position_m,
                side,
            })
            .to_vec();
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap();
        let mut recording = Recording::new(&plant, 40, 40);
        for step in 1..=40 {
            plant.step(f64::from(step) * 1e-3).unwrap();
            recording.include(&plant);
            let (frame, outputs) = (&recording.frames[recording.frames.len() - 1], plant.outputs());
            for ((body, position_m, _), output) in places.iter().zip(outputs.internal_loads()) {
                let own = &recording.scene.bodies[*body].places_m;
                let index = own.iter().position(|place_m| (place_m - position_m).abs() < 1e-12).expect("a section");
                // the same expressions at positions that differ by round-off
                let loads = [frame.loads[*body][index], *output].map(|load| (load.force_n, load.moment_n_m));
                let off = (loads[0].0 - loads[1].0).norm() + (loads[0].1 - loads[1].1).norm();
                assert!(off < 1e-12 * (loads[1].0.norm() + 1e-3), "{body} {position_m} m at step {step}: {off:e}");
            }
            let total: Vector3<f64> = frame.edge_forces_n.iter().flatten().sum();
            let air = outputs.air_total().force_n;
            assert!((total - air).norm() < 1e-12 * air.norm().max(1.0), "{total} {air}");
            let panels = &frame.lattice[1].panel_force_n;
            assert_eq!((panels.len(), panels[0].len()), (4, 10));
        }
    }
}

//! Recording of a run for pictures: histories of scalars, and frames with the whole wing.

use crate::acting::{Acting, HingeScene, MassScene, StationScene, Watch, hinges, masses, stations};
use crate::outlines::{self, AerofoilScene, aerofoils};
use crate::turbine::{SolidScene, Turbine};
use foldwing_engine::beam::section::Outline;
use foldwing_engine::load::Wrench;
use foldwing_engine::machine::{Parent, Travel};
use foldwing_engine::math::strain::STRAINS;
use foldwing_engine::plant::{EnergyOutputs, Plant, SectionPlace, SectionState, SurfaceLattice};
use nalgebra::Vector3;

/// Default number of frames of a recording.
pub const FRAMES: u64 = 600;

/// Maximum number of points of a history.
pub const MAXIMUM_POINTS: u64 = 200_000;

/// Minimum number of intervals along a body: enough for smooth surfaces.
const INTERVALS: usize = 16;

/// Half width and height of a section drawn without outline, relative to the body's length.
const ROD: f64 = 0.004;

/// Selection of the `steps + 1` points of a run: at equal intervals, including the first and the last.
#[derive(Debug, Clone, PartialEq)]
pub struct Thinning {
    steps: u64,
    stride: u64,
    seen: u64,
}

impl Thinning {
    /// Selection with at most `most` intervals.
    pub fn new(steps: u64, most: u64) -> Self {
        Self { steps, stride: steps.div_ceil(most).max(1), seen: 0 }
    }

    /// Returns whether the next point is kept.
    pub fn keeps(&mut self) -> bool {
        let keeps = self.seen.is_multiple_of(self.stride) || self.seen == self.steps;
        self.seen += 1;
        keeps
    }
}

/// Geometry of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyScene {
    /// Name.
    pub name: String,
    /// Name of the joint at its inner end.
    pub joint: String,
    /// Distances of the sections from the inner end in m: the mesh boundaries, and positions between them.
    pub places_m: Vec<f64>,
    /// Points `[y, z]` around each section in m.
    pub rims_m: Vec<Vec<[f64; 2]>>,
    /// Stiffness of `(εx, κx, κy, κz)` per section, row by row, with the start value of the body's factor.
    pub stiffness: Vec<[f64; STRAINS * STRAINS]>,
    /// The body has no elements.
    pub is_rigid: bool,
    /// The model gives its outline; otherwise it is drawn as a rod.
    pub has_outline: bool,
    /// Index of the body that carries it, which precedes it, and the distance from that body's inner end in m; `None` on the root.
    pub carrier: Option<(usize, f64)>,
}

/// A lifting surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceScene {
    /// Index into the model's bodies.
    pub body: usize,
    /// Panels along the chord; 0 for strips.
    pub chord_panels: usize,
    /// Distances of the edges of its strips from the body's inner end in m.
    pub places_m: Vec<f64>,
}

/// A gauge and its position.
#[derive(Debug, Clone, PartialEq)]
pub struct GaugeScene {
    /// Name.
    pub name: String,
    /// Index into the model's bodies.
    pub body: usize,
    /// Distance from the inner end in m.
    pub place_m: f64,
    /// Point `[y, z]` of the section in m.
    pub point_m: [f64; 2],
}

/// Parts that are constant during a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Name of the model.
    pub name: String,
    /// Its description.
    pub description: String,
    /// Bodies, in the model's order.
    pub bodies: Vec<BodyScene>,
    /// Names of the fold and prismatic joints, in the order of `Plant::revolute_joints`, each with the index of its outer
    /// body.
    pub joints: Vec<(String, usize)>,
    /// Type of motion of each of them.
    pub travels: Vec<Travel>,
    /// Names of the bodies with free ends.
    pub tips: Vec<String>,
    /// Gauges.
    pub gauges: Vec<GaugeScene>,
    /// Joints of all bodies that are not clamped.
    pub hinges: Vec<HingeScene>,
    /// Masses on the bodies.
    pub masses: Vec<MassScene>,
    /// Load stations, in the order of the inputs.
    pub stations: Vec<StationScene>,
    /// Lifting surfaces, in the order of [`Frame::edges_m`].
    pub surfaces: Vec<SurfaceScene>,
    /// Positions of the internal loads per body, at [`BodyScene::places_m`]; none on rigid and modal bodies.
    pub load_places: Vec<Vec<SectionPlace>>,
    /// The aerodynamics are those of a rotor.
    pub is_rotor: bool,
    /// Aerofoil of each lifting surface; `None` for plates.
    pub aerofoils: Vec<Option<AerofoilScene>>,
    /// Nacelle and hub of a turbine.
    pub solids: Vec<SolidScene>,
    /// Sentences that name the drawn dimensions that are not in the model.
    pub notes: Vec<String>,
}

/// Scalars over time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct History {
    /// Times in s.
    pub time_s: Vec<f64>,
    /// Angles in rad per fold joint, positions in m per prismatic one.
    pub angles_rad: Vec<Vec<f64>>,
    /// Torque of motor, spring and input in N·m per fold joint, force in N per prismatic one.
    pub torques_n_m: Vec<Vec<f64>>,
    /// Times in s at which a latch closed, per fold joint.
    pub latches_s: Vec<Vec<f64>>,
    /// Strains per gauge.
    pub gauges: Vec<Vec<f64>>,
    /// Positions in m per free end, root frame.
    pub tips_m: Vec<Vec<Vector3<f64>>>,
    /// Moment in N·m that the model exerts on the root, about its origin, root frame.
    pub root_n_m: Vec<Vector3<f64>>,
    /// Total aerodynamic force in N at the load stations, root frame; zero without aerodynamics.
    pub air_n: Vec<Vector3<f64>>,
    /// Energies.
    pub energies: Vec<EnergyOutputs>,
}

/// The whole wing at one time; positions in the root frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Time in s.
    pub time_s: f64,
    /// Sections per body, at the positions of [`BodyScene::places_m`].
    pub sections: Vec<Vec<SectionState>>,
    /// Force in N and moment in N·m of the part outboard of a section on the part inboard, section frame, per body with
    /// [`Scene::load_places`].
    pub loads: Vec<Vec<Wrench>>,
    /// Aerodynamic force in N at every edge of the strips, per lifting surface.
    pub edge_forces_n: Vec<Vec<Vector3<f64>>>,
    /// Leading and trailing edge in m per lifting surface, from the inner to the outer strip edge.
    pub edges_m: Vec<Vec<[Vector3<f64>; 2]>>,
    /// Positions of the gauges in m.
    pub gauges_m: Vec<Vector3<f64>>,
    /// Angles in rad per fold joint, positions in m per prismatic one.
    pub angles_rad: Vec<f64>,
    /// Strains per gauge.
    pub strains: Vec<f64>,
    /// Energies.
    pub energy: EnergyOutputs,
    /// Lattice and wake at the end of the aerodynamic step that contains the time; empty without a lattice.
    pub lattice: Vec<SurfaceLattice>,
    /// Latches closed, per fold joint.
    pub latched: Vec<bool>,
    /// Loads.
    pub acting: Acting,
}

/// A run up to the current time.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Parts that are constant during the run.
    pub scene: Scene,
    /// Scalars over time.
    pub history: History,
    /// Frames in order of time.
    pub frames: Vec<Frame>,
    /// Events.
    pub watch: Watch,
    /// Communication points so far.
    pub seen: u64,
    points: Thinning,
    kept_frames: Thinning,
}

impl Recording {
    /// An empty recording of a run of `steps` steps. Short runs are kept completely; long ones are thinned at equal intervals, separately
    /// for points and frames, and always keep the last. `frames` is the maximum number of frames after the first.
    pub fn new(plant: &Plant, steps: u64, frames: u64) -> Self {
        let scene = Scene::of(plant);
        let history = History {
            angles_rad: vec![Vec::new(); scene.joints.len()],
            torques_n_m: vec![Vec::new(); scene.joints.len()],
            latches_s: vec![Vec::new(); scene.joints.len()],
            gauges: vec![Vec::new(); scene.gauges.len()],
            tips_m: vec![Vec::new(); scene.tips.len()],
            ..History::default()
        };
        Self {
            scene,
            history,
            frames: Vec::new(),
            watch: Watch::new(plant.machine()),
            seen: 0,
            points: Thinning::new(steps, MAXIMUM_POINTS),
            kept_frames: Thinning::new(steps, frames),
        }
    }

    /// Records the plant's current state.
    pub fn include(&mut self, plant: &Plant) {
        self.seen += 1;
        self.watch.include(plant, &self.scene.joints);
        self.include_latches(plant);
        if self.points.keeps() {
            self.include_point(plant);
        }
        if self.kept_frames.keeps() {
            self.frames.push(Frame::of(&self.scene, plant));
        }
    }

    fn include_latches(&mut self, plant: &Plant) {
        for (times, latch) in self.history.latches_s.iter_mut().zip(plant.outputs().latches()) {
            if latch.count.get() > 0 && times.last() != Some(&latch.time_s) {
                times.push(latch.time_s);
            }
        }
    }

    fn include_point(&mut self, plant: &Plant) {
        let (history, outputs) = (&mut self.history, plant.outputs());
        history.time_s.push(outputs.time_s);
        history.angles_rad.iter_mut().zip(outputs.joints()).for_each(|(curve, joint)| curve.push(joint.angle_rad));
        let torques = outputs.joints().iter().map(|joint| joint.torque_applied_n_m);
        history.torques_n_m.iter_mut().zip(torques).for_each(|(curve, torque)| curve.push(torque));
        history.root_n_m.push(outputs.root().moment_n_m);
        history.air_n.push(outputs.air_stations().iter().map(|wrench| wrench.force_n).sum());
        history.gauges.iter_mut().zip(outputs.gauges()).for_each(|(curve, strain)| curve.push(*strain));
        history.tips_m.iter_mut().zip(outputs.tips()).for_each(|(curve, tip)| curve.push(tip.position_m));
        history.energies.push(*outputs.energy());
    }
}

impl Frame {
    /// The frame of a plant's current state, for a scene.
    pub fn of(scene: &Scene, plant: &Plant) -> Self {
        let outputs = plant.outputs();
        let sections = scene.bodies.iter().enumerate().map(|(i, body)| plant.sections(i, &body.places_m)).collect();
        let gauge = |gauge: &GaugeScene| plant.sections(gauge.body, &[gauge.place_m])[0].point(gauge.point_m).0;
        let mut frame = Self {
            time_s: outputs.time_s,
            sections,
            loads: scene.load_places.iter().map(|places| plant.internal_loads(places)).collect(),
            edge_forces_n: plant.surface_forces_n(),
            edges_m: edges_m(plant),
            gauges_m: scene.gauges.iter().map(gauge).collect(),
            angles_rad: outputs.joints().iter().map(|joint| joint.angle_rad).collect(),
            strains: outputs.gauges().to_vec(),
            energy: *outputs.energy(),
            lattice: plant.lattice().map_or_else(Vec::new, |(_, surfaces)| surfaces),
            latched: plant.joint_statuses().map(|joint| joint.latched).collect(),
            acting: Acting::default(),
        };
        frame.acting = Acting::of(plant, &frame);
        frame
    }
}

/// Leading and trailing edges of the lifting surfaces in the current shape.
fn edges_m(plant: &Plant) -> Vec<Vec<[Vector3<f64>; 2]>> {
    let surfaces = plant.machine().air.iter().flat_map(|air| &air.surfaces);
    let edges = surfaces.map(|surface| {
        let sections = plant.sections(surface.body, &surface.positions_m);
        let ends = |(section, fraction): (&SectionState, [Vector3<f64>; 2])| {
            fraction.map(|offset_m| section.position_m + section.rotation * offset_m)
        };
        let chords = surface.chords.iter().map(|chord| [chord.leading_m, chord.trailing_m]);
        sections.iter().zip(chords).map(ends).collect()
    });
    edges.collect()
}

impl Scene {
    /// The constant parts of a plant's model.
    pub fn of(plant: &Plant) -> Self {
        let machine = plant.machine();
        let name = |body: &usize| machine.bodies[*body].name.clone();
        let turbine = Turbine::of(plant);
        let bodies: Vec<_> = (0..machine.bodies.len()).map(|body| body_scene(plant, turbine.as_ref(), body)).collect();
        let aerofoils = aerofoils(machine);
        Self {
            name: machine.name.clone(),
            description: machine.description.clone(),
            load_places: bodies.iter().enumerate().map(|(i, body)| plant.load_places(i, &body.places_m)).collect(),
            is_rotor: machine.air.as_ref().is_some_and(|air| air.is_rotor()),
            bodies,
            joints: plant.revolute_joints().iter().map(|&i| (machine.bodies[i].joint.name.clone(), i)).collect(),
            travels: machine.bodies.iter().filter_map(|body| Some(body.joint.kind.one_freedom()?.0)).collect(),
            tips: plant.tip_bodies().iter().map(name).collect(),
            gauges: machine
                .gauges
                .iter()
                .map(|gauge| GaugeScene {
                    name: gauge.name.clone(),
                    body: gauge.body,
                    place_m: gauge.position_m,
                    point_m: [gauge.y_m, gauge.z_m],
                })
                .collect(),
            hinges: hinges(machine),
            masses: masses(machine),
            stations: stations(machine),
            surfaces: surfaces(plant),
            notes: turbine.iter().map(Turbine::note).chain(outlines::note(machine, &aerofoils)).collect(),
            aerofoils,
            solids: turbine.map_or_else(Vec::new, |turbine| turbine.solids(plant)),
        }
    }
}

fn surfaces(plant: &Plant) -> Vec<SurfaceScene> {
    let has_panels = plant.lattice().is_some();
    let surfaces = plant.machine().air.iter().flat_map(|air| &air.surfaces);
    surfaces
        .map(|surface| SurfaceScene {
            body: surface.body,
            chord_panels: if has_panels { surface.chord_panels } else { 0 },
            places_m: surface.positions_m.clone(),
        })
        .collect()
}

fn body_scene(plant: &Plant, turbine: Option<&Turbine>, index: usize) -> BodyScene {
    let machine = plant.machine();
    let body = &machine.bodies[index];
    let mesh_m = plant.mesh_m(index);
    let parts = INTERVALS.div_ceil(mesh_m.len().saturating_sub(1).max(1));
    let inside = |pair: &[f64]| -> Vec<f64> {
        let (start, length) = (pair[0], pair[1] - pair[0]);
        (0..parts).map(|i| start + length * i as f64 / parts as f64).collect()
    };
    let places_m: Vec<f64> = mesh_m.windows(2).flat_map(inside).chain(mesh_m.last().copied()).collect();
    let rim = |place_m: &f64| {
        if body.is_rigid() {
            return rim(Outline::Rectangle, 0.0, 0.0); // a point
        }
        if let Some(turbine) = turbine.filter(|turbine| turbine.tower == Some(index)) {
            let radius_m = turbine.tower_radius_m(machine, *place_m);
            return rim(Outline::Ellipse, radius_m, radius_m);
        }
        let section = body.section.at(*place_m);
        let outline = body.section.solid_at(*place_m).map_or(Outline::Rectangle, |solid| solid.outline);
        let half = |given_m: f64| if given_m > 0.0 { given_m } else { ROD * body.length_m };
        rim(outline, half(section.half_width_m), half(section.half_height_m))
    };
    let rims_m = places_m.iter().map(rim).collect();
    let joint = if body.joint.kind.is_clamped() { String::new() } else { body.joint.name.clone() };
    let factor = plant.parameters().bodies()[index].stiffness_factor;
    let stiffness = |place_m: &f64| -> [f64; STRAINS * STRAINS] {
        let whole = body.section.at(*place_m).stiffness * factor;
        std::array::from_fn(|i| whole[(i / STRAINS, i % STRAINS)])
    };
    let stiffness =
        if body.is_rigid() { vec![[0.0; STRAINS * STRAINS]] } else { places_m.iter().map(stiffness).collect() };
    let has_outline = !body.is_rigid() && body.section.at(0.0).half_width_m > 0.0;
    let carrier = match body.joint.parent {
        Parent::Root { .. } => None,
        Parent::Body { index, position_m } => Some((index, position_m)),
    };
    let (name, is_rigid) = (body.name.clone(), body.is_rigid());
    BodyScene { name, joint, places_m, rims_m, stiffness, is_rigid, has_outline, carrier }
}

/// Points around a section, from `+y` towards `+z`.
fn rim(outline: Outline, half_width_m: f64, half_height_m: f64) -> Vec<[f64; 2]> {
    match outline {
        Outline::Rectangle => [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]]
            .map(|[y, z]| [y * half_width_m, z * half_height_m])
            .into(),
        Outline::Ellipse => {
            let point = |i: u32| {
                let (sine, cosine) = (f64::from(i) * std::f64::consts::TAU / 12.0).sin_cos();
                [cosine * half_width_m, sine * half_height_m]
            };
            (0..12).map(point).collect()
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use foldwing_engine::machine::Machine;
    use foldwing_file as config;
    use std::sync::Arc;

    /// A shipped model.
    pub fn shipped(name: &str) -> Machine {
        let path = format!("{}/../../examples/models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        config::parse(&std::fs::read_to_string(path).unwrap(), name).unwrap()
    }

    pub fn started(machine: Machine) -> Plant {
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap();
        plant
    }

    /// A recording of `steps` steps of 1 ms.
    pub fn recorded(machine: Machine, steps: u64) -> Recording {
        let mut plant = started(machine);
        let mut recording = Recording::new(&plant, steps, FRAMES);
        recording.include(&plant);
        for step in 1..=steps {
            plant.step(step as f64 * 1e-3).unwrap();
            recording.include(&plant);
        }
        recording
    }

    /// The first and the last point are kept, those in between at equal intervals, and never more than requested.
    #[test]
    fn thinning_keeps_both_ends() {
        for (steps, most) in [(1, 1), (5, 10), (10, 10), (11, 10), (101, 10), (100_000, 7)] {
            let mut thinning = Thinning::new(steps, most);
            let kept: Vec<u64> = (0..=steps).filter(|_| thinning.keeps()).collect();
            assert_eq!((kept[0], kept[kept.len() - 1]), (0, steps));
            assert!(kept.len() as u64 <= most + 1, "{} of {steps} steps", kept.len());
            let strides: Vec<u64> = kept.windows(2).map(|pair| pair[1] - pair[0]).collect();
            assert!(strides[..strides.len() - 1].iter().all(|stride| *stride == strides[0]), "{strides:?}");
        }
    }

    /// Sections anywhere on a moving, curved, twisted or branched body agree with those of the mesh and of the load stations: the sums
    /// are the same in another order, so the tolerance is round-off of the largest length (90 m) and velocity.
    #[test]
    fn sections_are_those_of_mesh_and_stations() {
        for name in ["curved_blade", "branched", "folding_wing_constant"] {
            let mut plant = started(shipped(name));
            plant.step(0.05).unwrap();
            for (body, mesh) in plant.shape().iter().enumerate() {
                let places_m = plant.mesh_m(body);
                assert_eq!(places_m.len(), mesh.len(), "{name}");
                for (section, node) in plant.sections(body, &places_m).iter().zip(mesh) {
                    let off_m = (section.position_m - node.position_m).norm();
                    assert!(off_m < 1e-12 && (section.rotation - node.rotation).norm() < 1e-12, "{name}: {off_m:e} m");
                }
            }
            let bodies = plant.machine().bodies.iter().enumerate();
            let places =
                bodies.flat_map(|(body, with)| with.station_positions_m.iter().map(move |place_m| (body, *place_m)));
            for ((body, place_m), station) in places.zip(plant.outputs().stations()) {
                let section = plant.sections(body, &[place_m])[0];
                assert!((section.position_m - station.position_m).norm() < 1e-12, "{name}: station at {place_m} m");
                assert!((section.velocity_m_s - station.velocity_m_s).norm() < 1e-12, "{name}: station at {place_m} m");
            }
        }
    }

    /// Bodies are drawn unstrained at the start, although the recovered strain (NOTATION eq. (G2)) next to the hinge exceeds 10⁻³: the
    /// motor's torque acts instantaneously, the strain does not.
    #[test]
    fn an_unstrained_wing_is_shown_unstrained() {
        let plant = started(shipped("folding_wing"));
        assert_eq!(plant.outputs().energy().elastic, 0.0);
        let recovered = plant.section_strains().iter().map(|strain| strain.largest.abs()).fold(0.0, f64::max);
        assert!(recovered > 1e-3, "{recovered:e}");
        let recording = recorded(shipped("folding_wing"), 1);
        let sections = recording.frames[0].sections.iter().flatten();
        let shown = sections.map(|section| section.measures.amax()).fold(0.0, f64::max);
        assert_eq!(shown, 0.0);
    }

    /// On constant-strain elements a gauge measures the longitudinal strain drawn at its point.
    #[test]
    fn axial_strain_is_what_a_gauge_reads() {
        let recording = recorded(shipped("folding_wing_constant"), 40);
        let gauge = &recording.scene.gauges[0];
        let mut plant = started(shipped("folding_wing_constant"));
        plant.step(0.04).unwrap();
        let section = plant.sections(gauge.body, &[gauge.place_m])[0];
        let (read, found) = (plant.outputs().gauges()[0], section.axial_strain(gauge.point_m));
        assert!(read.abs() > 1e-5 && (read - found).abs() < 1e-15, "{read} and {found}");
    }
}

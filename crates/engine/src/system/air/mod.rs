//! Aerodynamics of the model: loads over time, state and outputs.

pub(crate) mod continuous;
pub(crate) mod controls;
pub(crate) mod gaps;
mod history;
mod instant;
pub(crate) mod instant_workspace;
mod lattice_slopes;
pub(crate) mod memory;
mod model_slopes;
pub(crate) mod pieces;
pub(crate) mod sections;
pub(crate) mod slopes;
pub(crate) mod start;
mod step_loads;
pub(crate) mod step_slopes;
mod view;

pub(crate) use crate::aero::lattice_linear::{LatticeSlopes, SECTION_PARTS};
pub use gaps::{CLOSED_PANELS, SurfaceGap};
pub(crate) use history::AirHistory;
pub(crate) use step_loads::{Gain, Sample, StepLoads, VELOCITY_WEIGHTS};
pub use view::SurfaceLattice;

use crate::aero::flap::Deflection;
use crate::aero::surface::{Edge, Surface};
use crate::aero::{AirLoads, AirModels};
use crate::load::{SectionMotion, Wrench};
use crate::machine::{self, Parent};
use crate::multibody::motion::Motion;
use crate::multibody::station;
use crate::solve::acceleration::Anderson;
use crate::solve::point::Point;
use crate::system::air::instant_workspace::ContinuousAir;
use crate::system::equations::Equations;
use crate::system::outputs::Outputs;
use nalgebra::Vector3;

/// Number of entries of a wrench in a vector of unknown loads.
const ENTRIES: usize = 6;
/// Difference of two positions, relative to the body's length, below which they coincide.
const NEAR: f64 = 1e-9;
/// Round-off of a section's motion within a step, in chords: about fifty units in the last place.
const ROUND_OFF: f64 = 1e-14;

/// Aerodynamic models with their coupling to the structure; a workspace, except for the settings of the models.
pub(crate) struct AirCoupling {
    pub model: AirModels,
    pub settings: machine::Air,
    pub motions: Vec<SectionMotion>,
    /// Angles of the control surfaces.
    pub deflections: Vec<Deflection>,
    pub loads: AirLoads,
    pub guess: Vec<f64>,
    pub residual: Vec<f64>,
    pub acceleration: Anderson,
    /// Loads of all models at an instant, for external integrators; `None` with a lattice.
    pub continuous: Option<ContinuousAir>,
    /// Longest chord, or largest diameter of a slender body, in m.
    pub length_m: f64,
    /// Widest strip, or longest part of a slender body, in m.
    pub strip_m: f64,
    /// Load station, section and weight, for reporting the loads of the sections at the load stations.
    pub shares: Vec<(usize, usize, f64)>,
    /// Empty history with the sizes of this model.
    pub blank: AirHistory,
}

impl AirCoupling {
    /// Aerodynamics of a model; `None` if it has none.
    pub fn new(machine: &machine::Machine) -> Option<Self> {
        let settings = machine.air.clone()?;
        let mut sections = 0;
        let surfaces: Vec<Surface> = settings
            .surfaces
            .iter()
            .map(|surface| {
                let first = sections;
                sections += surface.positions_m.len();
                Surface {
                    sections: first..sections,
                    chords: surface.chords.clone(),
                    chord_panels: surface.chord_panels,
                    profile: surface.profile.clone(),
                }
            })
            .collect();
        let chords = surfaces.iter().flat_map(|surface| &surface.chords).map(|chord| chord.length_m());
        let slender = || settings.slender_bodies().map(|(_, body)| body);
        let length_m = chords.chain(slender().map(|body| 2.0 * body.largest_m())).fold(0.0, f64::max);
        let lines = settings.surfaces.iter().map(|surface| &surface.positions_m);
        let strips = lines.chain(slender().map(|body| &body.positions_m)).flat_map(|line| line.windows(2));
        let strip_m = strips.map(|edges| edges[1] - edges[0]).fold(0.0, f64::max);
        let still = SectionMotion {
            rotation: nalgebra::Matrix3::identity(),
            position_m: Vector3::zeros(),
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
        };
        let mut model = AirModels::new(&surfaces, &settings.flaps, &settings.parts, still);
        let sections = model.sections();
        let unknowns = 2 * ENTRIES * sections;
        joined_edges(machine, &settings.surfaces).into_iter().for_each(|edges| model.join(edges));
        let at_mirror = |(surface, described): (usize, &machine::LiftingSurface)| {
            described.at_mirror.then_some(Edge { surface, outer: false })
        };
        settings.surfaces.iter().enumerate().filter_map(at_mirror).for_each(|edge| model.join_image(edge));
        let none = vec![Wrench::default(); sections];
        let blank = AirHistory {
            start_s: 0.0,
            steps: 0,
            before: model.blank_state(),
            after: model.blank_state(),
            begin: vec![Sample::steady(&still); sections],
            end: vec![Sample::steady(&still); sections],
            loads: StepLoads::none(sections),
            at_begin: none,
            carried_m: Vector3::zeros(),
            gain: Gain::default(),
            scale_n: 0.0,
            motion_tolerance: f64::INFINITY,
            structure_step_s: 0.0,
            after_jump_s: 0.0,
            strayed: 0,
        };
        let gusts = !settings.gusts.is_empty();
        Some(Self {
            continuous: if settings.is_continuous() {
                ContinuousAir::new(&model, settings.flaps.len(), gusts)
            } else {
                None
            },
            model,
            shares: shares(machine, &settings),
            blank,
            deflections: vec![Deflection::default(); settings.flaps.len()],
            settings,
            motions: vec![still; sections],
            loads: AirLoads::still(sections),
            guess: vec![0.0; unknowns],
            residual: vec![0.0; unknowns],
            acceleration: Anderson::new(unknowns),
            length_m,
            strip_m,
        })
    }

    /// Whether the downwash of gusts has lag states: for the gusts of the machine, and for gusts that are inputs of a linear model
    /// (`as_inputs`).
    pub fn has_gust_lags(&self, as_inputs: bool) -> bool {
        as_inputs || !self.settings.gusts.is_empty()
    }

    /// Fills the outputs; the nodes of the equations and the poses of the load stations in `outputs` must be current.
    pub fn report(&mut self, equations: &Equations, history: &AirHistory, now: &Point, outputs: &mut Outputs) {
        self.observe(equations, now);
        let total = outputs.air_total_mut();
        *total = Wrench::default();
        let loads = &equations.stations[equations.load_stations..];
        for (motion, load) in self.motions.iter().zip(loads) {
            total.add_force_at(&motion.position_m, &(motion.rotation * load.force_n));
            total.moment_n_m += motion.rotation * load.moment_n_m;
        }
        outputs.air_stations_mut().fill(Wrench::default());
        for &(station, section, share) in &self.shares {
            let (motion, load) = (&self.motions[section], &loads[section]);
            let arm_m = motion.position_m - outputs.stations()[station].position_m;
            let sum = &mut outputs.air_stations_mut()[station];
            sum.add_force_at(&arm_m, &(motion.rotation * load.force_n * share));
            sum.moment_n_m += motion.rotation * load.moment_n_m * share;
        }
        let step_s = self.settings.step_s;
        let share = match history.steps {
            0 => 1.0,
            _ => 1.0 - (history.loads.end_s - now.time_s) / step_s,
        };
        let strips = self.settings.surfaces.iter().enumerate();
        let strips =
            strips.flat_map(|(index, surface)| (0..surface.positions_m.len() - 1).map(move |strip| (index, strip)));
        for (circulation, (surface, strip)) in outputs.circulation_m2_s_mut().iter_mut().zip(strips) {
            let [before, after] =
                [&history.before, &history.after].map(|air| self.model.strip_circulation_m2_s(air, surface, strip));
            *circulation = before + (after - before) * share;
        }
        self.report_flaps(equations, [&history.before, &history.after], (now.time_s, share), outputs);
        let ends = history.before.rotor_loads().zip(history.after.rotor_loads());
        for (rotor, (before, after)) in outputs.rotor_mut().iter_mut().zip(ends) {
            *rotor = before.between(after, share);
        }
    }

    /// Force in N of the air per section, root frame; the sections must have been observed, as by [`Self::report`].
    pub fn section_forces_n(&self, equations: &Equations) -> Vec<Vector3<f64>> {
        let loads = &equations.stations[equations.load_stations..];
        self.motions.iter().zip(loads).map(|(motion, load)| motion.rotation * load.force_n).collect()
    }

    /// Copies the motion of the sections from the equations, whose nodes must be current.
    pub fn observe(&mut self, equations: &Equations, point: &Point) {
        let motion = Motion { q: &point.q, v: &point.v, a: &point.a };
        let places = &equations.model.stations[equations.load_stations..];
        for (observed, place) in self.motions.iter_mut().zip(places) {
            *observed = station::motion(&equations.model, &equations.work, motion, place);
        }
    }

    /// Writes the difference between the loads just computed and the guess to the residual: `new − guess`, in section frames.
    ///
    /// Returns the size of the change and of the loads in N; moments are divided by the longest chord.
    pub fn compare(&mut self) -> (f64, f64) {
        let (mut change_n, mut size_n) = (0.0_f64, 0.0_f64);
        let sections = self.motions.len();
        for (section, motion) in self.motions.iter().enumerate() {
            let turned = motion.rotation.transpose();
            for (part, loads) in [&self.loads.circulatory, &self.loads.impulsive].into_iter().enumerate() {
                let (force_n, moment_n_m) = (turned * loads[section].force_n, turned * loads[section].moment_n_m);
                let first = ENTRIES * (part * sections + section);
                for i in 0..3 {
                    self.residual[first + i] = force_n[i] - self.guess[first + i];
                    self.residual[first + 3 + i] = moment_n_m[i] - self.guess[first + 3 + i];
                    size_n = size_n.max(force_n[i].abs()).max(moment_n_m[i].abs() / self.length_m);
                    change_n = change_n
                        .max(self.residual[first + i].abs())
                        .max(self.residual[first + 3 + i].abs() / self.length_m);
                }
            }
        }
        // `max` drops NaN: return it explicitly
        let sound = self.residual.iter().all(|entry| entry.is_finite());
        (if sound { change_n } else { f64::NAN }, size_n)
    }

    /// Round-off level of the loads in N: loads due to motions of [`ROUND_OFF`] chords within a step. A wing that is not loaded by the wind
    /// has no larger loads, so that a relative threshold could not be met.
    pub fn round_off_n(&self, density_kg_m3: f64) -> f64 {
        let velocity_m_s = self.length_m / self.settings.step_s;
        ROUND_OFF * density_kg_m3 * (velocity_m_s * self.length_m).powi(2)
    }

    /// Displacement in m of a section within an aerodynamic step that changes its load by `change_n`: the inertia of the air around a
    /// strip, in a layer as thick as the chord, accelerated within the step to the velocity of that displacement.
    pub fn unnoticed_m(&self, change_n: f64, density_kg_m3: f64) -> f64 {
        change_n * self.settings.step_s.powi(2) / (density_kg_m3 * self.length_m.powi(2) * self.strip_m)
    }

    /// Adds the residual to the guess.
    pub fn accept(&mut self) {
        self.guess.iter_mut().zip(&self.residual).for_each(|(guess, residual)| *guess += residual);
    }

    /// Reads the guess from the loads of a step.
    pub fn read(&mut self, loads: &StepLoads) {
        let entries =
            loads.to.iter().chain(&loads.impulsive).flat_map(|load| load.force_n.iter().chain(load.moment_n_m.iter()));
        self.guess.iter_mut().zip(entries).for_each(|(guess, entry)| *guess = *entry);
    }

    /// Writes the guess to the loads of a step.
    pub fn write(&self, loads: &mut StepLoads) {
        let loads = loads.to.iter_mut().chain(&mut loads.impulsive);
        for (load, entries) in loads.zip(self.guess.chunks_exact(ENTRIES)) {
            load.force_n.copy_from_slice(&entries[..3]);
            load.moment_n_m.copy_from_slice(&entries[3..]);
        }
    }
}

/// Common edges of surfaces: the outer edge of a surface with the inner edge of the surface on the body at its end, or the inner edges of
/// two halves.
fn joined_edges(machine: &machine::Machine, surfaces: &[machine::LiftingSurface]) -> Vec<[Edge; 2]> {
    let mut pairs = Vec::new();
    for (inner, parent) in surfaces.iter().enumerate() {
        let length_m = machine.bodies[parent.body].length_m;
        let follows = |child: &machine::LiftingSurface| match machine.bodies[child.body].joint.parent {
            Parent::Body { index, position_m } => index == parent.body && position_m >= length_m * (1.0 - NEAR),
            Parent::Root { .. } => false,
        };
        // with several bodies on one end, the first continues the surface
        if let Some(outer) = surfaces.iter().position(follows) {
            pairs.push([Edge { surface: inner, outer: true }, Edge { surface: outer, outer: false }]);
        }
        let half = |other: &machine::LiftingSurface| {
            parent.other_half == Some(other.body) && other.other_half == Some(parent.body)
        };
        if let Some(other) = surfaces.iter().position(half).filter(|&other| other > inner) {
            pairs.push([inner, other].map(|surface| Edge { surface, outer: false }));
        }
    }
    pairs
}

/// Load stations at which the loads of each section are reported, with weights, for surfaces and slender bodies.
fn shares(machine: &machine::Machine, air: &machine::Air) -> Vec<(usize, usize, f64)> {
    let (mut shares, mut first_section) = (Vec::new(), 0);
    for surface in &air.surfaces {
        add_shares(machine, surface.body, &surface.positions_m, first_section, &mut shares);
        first_section += surface.positions_m.len();
    }
    for part in &air.parts {
        first_section += usize::from(part.options.is_rotor());
        if let Some(body) = part.options.slender_body() {
            add_shares(machine, body.body, &body.positions_m, first_section, &mut shares);
            first_section += body.positions_m.len();
        }
    }
    shares
}

/// Adds the shares of sections at `edges` in m along a body, the first of which is `first_section` among all: the load of a strip is assigned
/// to the station nearest to its middle.
fn add_shares(
    machine: &machine::Machine,
    body: usize,
    edges: &[f64],
    first_section: usize,
    shares: &mut Vec<(usize, usize, f64)>,
) {
    let first_station: usize = machine.bodies[..body].iter().map(|body| body.station_positions_m.len()).sum();
    let stations = &machine.bodies[body].station_positions_m;
    for strip in 0..edges.len() - 1 {
        let middle_m = 0.5 * (edges[strip] + edges[strip + 1]);
        let distance_m = |station: &f64| (station - middle_m).abs();
        let Some(nearest_m) = stations.iter().map(distance_m).min_by(f64::total_cmp) else { break };
        // the load of a strip halfway between two stations is divided between both
        let near = NEAR * edges[edges.len() - 1].abs().max(edges[0].abs());
        let takers: Vec<usize> =
            (0..stations.len()).filter(|&i| distance_m(&stations[i]) <= nearest_m + near).collect();
        for section in [strip, strip + 1] {
            let neighbours = if section == 0 || section == edges.len() - 1 { 1.0 } else { 2.0 };
            for &station in &takers {
                let share = 1.0 / (neighbours * takers.len() as f64);
                shares.push((first_station + station, first_section + section, share));
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod test_wing;

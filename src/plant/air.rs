//! Air and structure: loads that agree with the motion at the end of every aerodynamic step.
//!
//! Aerodynamic steps have a fixed length from the start on, whatever the caller's steps are. Within one the loads are
//! given functions of time, NOTATION eq. (Q1): circulatory ones run linearly from their value at its begin to that at
//! its end, fixed to the sections; the rate of the fluid's impulse is constant. The value at the end follows from
//! trial marches of the structure to it, eq. (Q2), after which the structure goes back and marches for good.

use crate::aero::flow::Flow;
use crate::aero::surface::Surface;
use crate::aero::{AirLoads, AirModel, AirState};
use crate::config::machine::{self, Coupling};
use crate::load::{LoadFrame, SectionMotion, Wrench};
use crate::multibody::kinematics::Motion;
use crate::multibody::{Model, station};
use crate::plant::Plant;
use crate::plant::equations::Equations;
use crate::plant::face::{AirOutputs, Outputs, PlantError, Statistics};
use crate::plant::state::{JointState, State};
use crate::solve::EquationsOfMotion;
use crate::solve::acceleration::Anderson;
use crate::solve::point::Point;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Entries of a wrench in a vector of unknown loads.
const ENTRIES: usize = 6;
/// Difference of two places over the body's length below which they are the same.
const NEAR: f64 = 1e-9;
/// Share of an aerodynamic step below which the rest of it is round-off of the caller's clock.
const SLIVER: f64 = 1e-9;

/// Loads of the air as given functions of time, per section and in its frame.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Ramp {
    /// Time of `from` in s.
    pub begin_s: f64,
    /// Time of `to` in s.
    pub end_s: f64,
    /// Circulatory loads at the begin.
    pub from: Vec<Wrench>,
    /// Circulatory loads at the end.
    pub to: Vec<Wrench>,
    /// Impulsive loads.
    pub mean: Vec<Wrench>,
}

impl Ramp {
    /// No loads on `sections` sections.
    pub fn none(sections: usize) -> Self {
        let none = vec![Wrench::default(); sections];
        Self { begin_s: 0.0, end_s: 0.0, from: none.clone(), to: none.clone(), mean: none }
    }

    /// Copies without allocating.
    pub fn copy_from(&mut self, other: &Self) {
        (self.begin_s, self.end_s) = (other.begin_s, other.end_s);
        self.from.copy_from_slice(&other.from);
        self.to.copy_from_slice(&other.to);
        self.mean.copy_from_slice(&other.mean);
    }

    /// Takes all loads away.
    pub fn clear(&mut self) {
        self.scale(&[], 0.0);
    }

    /// Constant loads: the circulatory ones of `target`'s end times a factor.
    pub fn scale(&mut self, target: &[Wrench], factor: f64) {
        (self.begin_s, self.end_s) = (0.0, 0.0);
        self.mean.fill(Wrench::default());
        for (i, load) in self.from.iter_mut().enumerate() {
            let target = target.get(i).copied().unwrap_or_default();
            *load = Wrench { force_n: target.force_n * factor, moment_n_m: target.moment_n_m * factor };
        }
        self.to.copy_from_slice(&self.from);
    }

    /// Share of the way from `from` to `to`.
    fn share(&self, time_s: f64) -> f64 {
        let length_s = self.end_s - self.begin_s;
        if length_s > 0.0 { (time_s - self.begin_s) / length_s } else { 0.0 }
    }

    /// Circulatory load of a section.
    fn circulatory(&self, section: usize, share: f64) -> Wrench {
        let (from, to) = (&self.from[section], &self.to[section]);
        Wrench {
            force_n: from.force_n + (to.force_n - from.force_n) * share,
            moment_n_m: from.moment_n_m + (to.moment_n_m - from.moment_n_m) * share,
        }
    }

    /// Writes the loads at a time, NOTATION eq. (Q1).
    pub fn write(&self, time_s: f64, loads: &mut [Wrench]) {
        let share = self.share(time_s);
        for (section, load) in loads.iter_mut().enumerate() {
            let (circulatory, mean) = (self.circulatory(section, share), &self.mean[section]);
            load.force_n = circulatory.force_n + mean.force_n;
            load.moment_n_m = circulatory.moment_n_m + mean.moment_n_m;
        }
    }
}

/// What the plant's state remembers of the air.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct AirHistory {
    /// Time at which the steps began, in s.
    pub start_s: f64,
    /// Aerodynamic steps begun since.
    pub steps: u64,
    /// Air at the begin of the present step.
    pub before: AirState,
    /// Air at its end.
    pub after: AirState,
    /// Loads of the present step.
    pub ramp: Ramp,
    /// Circulatory loads at the begin of the present step; the ramp may begin later.
    pub at_begin: Vec<Wrench>,
    /// Way of the wind from the begin of the step to that of the ramp, in m.
    pub carried_m: Vector3<f64>,
    /// Largest force so far, in N.
    pub scale_n: f64,
    /// Step of the structure within the present aerodynamic step in s: the smallest that the error estimate asked for in
    /// the first trial march. With steps that changed from one trial to the next, the loads at the end would jump with
    /// them by the error that the tolerance allows, and no iteration would end.
    pub structure_step_s: f64,
}

impl AirHistory {
    /// Moves everything in time by the round-off of the caller's clock.
    pub fn shift(&mut self, shift_s: f64) {
        self.start_s += shift_s;
        self.ramp.begin_s += shift_s;
        self.ramp.end_s += shift_s;
    }

    /// Whether a history has the sizes of this one.
    pub fn fits(&self, other: &Self) -> bool {
        let sections = self.at_begin.len();
        self.before.fits(&other.before)
            && self.before.fits(&other.after)
            && [&other.at_begin, &other.ramp.from, &other.ramp.to, &other.ramp.mean]
                .iter()
                .all(|loads| loads.len() == sections)
    }
}

/// The model of the air with what couples it to the structure; scratch, but for the model's settings.
pub(super) struct AirCoupling {
    model: AirModel,
    settings: machine::Air,
    motions: Vec<SectionMotion>,
    loads: AirLoads,
    guess: Vec<f64>,
    residual: Vec<f64>,
    acceleration: Anderson,
    length_m: f64,
    trial: Trial,
    /// Load station, section and share: how the sections' loads are reported at the load stations.
    shares: Vec<(usize, usize, f64)>,
    /// A history of the right sizes.
    pub blank: AirHistory,
}

/// Where a trial march starts, to go back to.
struct Trial {
    start: Point,
    step_s: f64,
    joints: Vec<JointState>,
    statistics: Statistics,
    ramp: Ramp,
}

impl AirCoupling {
    /// Air of a machine, if it has any.
    pub fn new(machine: &machine::Machine, coordinates: usize) -> Option<Self> {
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
        let chords = surfaces.iter().flat_map(|surface| &surface.chords);
        let length_m = chords.map(|chord| chord.length_m()).fold(0.0, f64::max);
        let still = SectionMotion {
            rotation: nalgebra::Matrix3::identity(),
            position_m: Vector3::zeros(),
            velocity_m_s: Vector3::zeros(),
            spin_rad_s: Vector3::zeros(),
        };
        let unknowns = 2 * ENTRIES * sections;
        let model = AirModel::new(surfaces, &settings.options);
        let none = vec![Wrench::default(); sections];
        let blank = AirHistory {
            start_s: 0.0,
            steps: 0,
            before: model.blank_state(),
            after: model.blank_state(),
            ramp: Ramp::none(sections),
            at_begin: none,
            carried_m: Vector3::zeros(),
            scale_n: 0.0,
            structure_step_s: 0.0,
        };
        Some(Self {
            model,
            shares: shares(machine, &settings.surfaces),
            blank,
            settings,
            motions: vec![still; sections],
            loads: AirLoads::still(sections),
            guess: vec![0.0; unknowns],
            residual: vec![0.0; unknowns],
            acceleration: Anderson::new(unknowns),
            length_m,
            trial: Trial {
                start: Point::zeros(coordinates),
                step_s: 0.0,
                joints: Vec::with_capacity(machine.bodies.len()),
                statistics: Statistics::default(),
                ramp: Ramp::none(sections),
            },
        })
    }

    /// Outputs of the right sizes.
    pub fn blank_outputs(&self, load_stations: usize) -> AirOutputs {
        let strips = self.settings.surfaces.iter().map(|surface| surface.positions_m.len() - 1).sum();
        AirOutputs {
            total: Wrench::default(),
            stations: vec![Wrench::default(); load_stations],
            circulation_m2_s: vec![0.0; strips],
        }
    }

    /// Fills the outputs; the nodes of the equations and the poses of the load stations in `outputs` must be current.
    pub fn report(&mut self, equations: &Equations, history: &AirHistory, now: &Point, outputs: &mut Outputs) {
        self.observe(equations, now);
        outputs.air.total = Wrench::default();
        let loads = &equations.stations[equations.load_stations..];
        for (motion, load) in self.motions.iter().zip(loads) {
            outputs.air.total.add_force_at(&motion.position_m, &(motion.rotation * load.force_n));
            outputs.air.total.moment_n_m += motion.rotation * load.moment_n_m;
        }
        outputs.air.stations.fill(Wrench::default());
        for &(station, section, share) in &self.shares {
            let (motion, load) = (&self.motions[section], &loads[section]);
            let arm_m = motion.position_m - outputs.stations[station].position_m;
            let sum = &mut outputs.air.stations[station];
            sum.add_force_at(&arm_m, &(motion.rotation * load.force_n * share));
            sum.moment_n_m += motion.rotation * load.moment_n_m * share;
        }
        let step_s = self.settings.step_s;
        let share = match history.steps {
            0 => 1.0,
            _ => 1.0 - (history.ramp.end_s - now.time_s) / step_s,
        };
        let strips = self.settings.surfaces.iter().enumerate();
        let strips =
            strips.flat_map(|(index, surface)| (0..surface.positions_m.len() - 1).map(move |strip| (index, strip)));
        for (circulation, (surface, strip)) in outputs.air.circulation_m2_s.iter_mut().zip(strips) {
            let [before, after] =
                [&history.before, &history.after].map(|air| self.model.strip_circulation_m2_s(air, surface, strip));
            *circulation = before + (after - before) * share;
        }
    }

    /// Adds the sections of the surfaces behind the load stations of a model.
    pub fn add_sections(machine: &machine::Machine, model: &mut Model) {
        for surface in machine.air.iter().flat_map(|air| &air.surfaces) {
            model.add_stations(surface.body, &surface.positions_m, LoadFrame::Section);
        }
    }

    /// Takes the motion of the sections from the equations, whose nodes must be current.
    fn observe(&mut self, equations: &Equations, point: &Point) {
        let motion = Motion { q: &point.q, v: &point.v, a: &point.a };
        let places = &equations.model.stations[equations.load_stations..];
        for (observed, place) in self.motions.iter_mut().zip(places) {
            *observed = station::motion(&equations.model, &equations.work, motion, place);
        }
    }

    /// Puts the loads just computed into the residual of the guess: `new − guess`, in section frames.
    ///
    /// Returns the size of the change and of the loads in N; moments count by the longest chord.
    fn compare(&mut self) -> (f64, f64) {
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
        // `max` drops NaN: say it loudly
        let sound = self.residual.iter().all(|entry| entry.is_finite());
        (if sound { change_n } else { f64::NAN }, size_n)
    }

    /// Adds the residual to the guess.
    fn accept(&mut self) {
        self.guess.iter_mut().zip(&self.residual).for_each(|(guess, residual)| *guess += residual);
    }

    /// Reads the guess from a ramp's end.
    fn read(&mut self, ramp: &Ramp) {
        let entries =
            ramp.to.iter().chain(&ramp.mean).flat_map(|load| load.force_n.iter().chain(load.moment_n_m.iter()));
        self.guess.iter_mut().zip(entries).for_each(|(guess, entry)| *guess = *entry);
    }

    /// Writes the guess to a ramp's end.
    fn write(&self, ramp: &mut Ramp) {
        let loads = ramp.to.iter_mut().chain(&mut ramp.mean);
        for (load, entries) in loads.zip(self.guess.chunks_exact(ENTRIES)) {
            load.force_n.copy_from_slice(&entries[..3]);
            load.moment_n_m.copy_from_slice(&entries[3..]);
        }
    }
}

/// Which load station reports how much of each section's load: strips go to the station nearest to their middle.
fn shares(machine: &machine::Machine, surfaces: &[machine::LiftingSurface]) -> Vec<(usize, usize, f64)> {
    let mut shares = Vec::new();
    let mut first_section = 0;
    for surface in surfaces {
        let bodies = &machine.bodies[..surface.body];
        let first_station: usize = bodies.iter().map(|body| body.station_positions_m.len()).sum();
        let stations = &machine.bodies[surface.body].station_positions_m;
        let edges = &surface.positions_m;
        for strip in 0..edges.len() - 1 {
            let middle_m = 0.5 * (edges[strip] + edges[strip + 1]);
            let distance_m = |station: &f64| (station - middle_m).abs();
            let Some(nearest_m) = stations.iter().map(distance_m).min_by(f64::total_cmp) else { break };
            // a strip half way between two stations belongs to both
            let near = NEAR * edges[edges.len() - 1];
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
        first_section += edges.len();
    }
    shares
}

/// The flow at a time with a given wind.
fn flow<'a>(settings: &'a machine::Air, state: &State, time_s: f64, wind_m_s: Vector3<f64>) -> Flow<'a> {
    Flow {
        time_s,
        density_kg_m3: state.applied_parameters.air_density_kg_m3,
        wind_m_s,
        spin_rad_s: state.applied_inputs.root.angular_velocity_rad_s,
        gusts: &settings.gusts,
    }
}

/// The air has no solution.
fn refusal(time_s: f64, cause: impl std::fmt::Display) -> PlantError {
    PlantError::Air { time_s, cause: cause.to_string() }
}

impl Plant {
    /// Air at the start of the run, with its loads on the present motion.
    pub(super) fn start_air(&mut self, time_s: f64) -> Result<(), PlantError> {
        let Some(air) = &mut self.air else { return Ok(()) };
        let now = &self.state.now;
        self.equations.residual(time_s, &now.q, &now.v, &now.a, &mut self.scratch[0]);
        air.observe(&self.equations, now);
        let mut history = air.blank.clone();
        let AirCoupling { model, settings, motions, loads, .. } = &mut **air;
        let flow = flow(settings, &self.state, time_s, self.state.applied_inputs.wind_m_s);
        model
            .start(motions, &flow, settings.established, &mut history.after, loads)
            .map_err(|error| refusal(time_s, error))?;
        air.read(&history.ramp);
        let (change_n, size_n) = air.compare();
        if !change_n.is_finite() {
            return Err(refusal(time_s, "its loads are not finite"));
        }
        air.accept();
        history.start_s = time_s;
        history.scale_n = size_n;
        (history.ramp.begin_s, history.ramp.end_s) = (time_s, time_s);
        air.write(&mut history.ramp);
        history.ramp.from.clone_from(&history.ramp.to);
        history.at_begin.clone_from(&history.ramp.to);
        history.before.copy_from(&history.after);
        self.state.air = Some(history);
        self.configure();
        Ok(())
    }

    /// Begins the next aerodynamic step where the present one is over.
    pub(super) fn begin_air_step(&mut self) -> Result<(), PlantError> {
        let (Some(history), Some(air)) = (&mut self.state.air, &self.air) else { return Ok(()) };
        let step_s = air.settings.step_s;
        if self.state.start.time_s < history.ramp.end_s - SLIVER * step_s {
            return Ok(());
        }
        history.before.copy_from(&history.after);
        let AirHistory { ramp, at_begin, .. } = history;
        for (earlier, (from, to)) in at_begin.iter_mut().zip(ramp.from.iter_mut().zip(&mut ramp.to)) {
            *from = *to;
            if history.steps > 0 {
                to.force_n += to.force_n - earlier.force_n;
                to.moment_n_m += to.moment_n_m - earlier.moment_n_m;
            }
            *earlier = *from;
        }
        history.steps += 1;
        history.carried_m = Vector3::zeros();
        ramp.begin_s = self.state.start.time_s;
        ramp.end_s = history.start_s + history.steps as f64 * step_s;
        self.agree_on_loads()
    }

    /// Lets the loads of the present step run on from the present time, at which the inputs change.
    pub(super) fn cut_ramp(&mut self) {
        let wind_m_s = self.state.applied_inputs.wind_m_s;
        let time_s = self.state.now.time_s;
        let Some(AirHistory { ramp, carried_m, .. }) = &mut self.state.air else { return };
        if time_s <= ramp.begin_s || time_s >= ramp.end_s {
            return;
        }
        let share = ramp.share(time_s);
        for section in 0..ramp.from.len() {
            ramp.from[section] = ramp.circulatory(section, share);
        }
        *carried_m += wind_m_s * (time_s - ramp.begin_s);
        ramp.begin_s = time_s;
    }

    /// Finds the loads for the rest of the present step anew, after the inputs have changed inside it.
    pub(super) fn renew_air(&mut self) -> Result<(), PlantError> {
        match (&self.state.air, &self.air) {
            (Some(history), Some(air))
                if self.state.start.time_s < history.ramp.end_s - SLIVER * air.settings.step_s =>
            {
                self.agree_on_loads()
            }
            _ => Ok(()),
        }
    }

    /// Loads at the end of the present aerodynamic step that agree with the motion there, NOTATION eq. (Q2).
    /// Leaves the structure at `start`, with accelerations under these loads.
    fn agree_on_loads(&mut self) -> Result<(), PlantError> {
        let Some(mut air) = self.air.take() else { return Ok(()) };
        let outcome = self.iterate(&mut air);
        self.air = Some(air);
        outcome
    }

    fn iterate(&mut self, air: &mut AirCoupling) -> Result<(), PlantError> {
        let step_s = air.settings.step_s;
        let wind_m_s = self.state.applied_inputs.wind_m_s;
        air.trial.save(&self.state, self.equations.ramp.as_ref());
        let Some(mut history) = self.state.air.take() else { return Ok(()) };
        let (begin_s, end_s) = (history.ramp.begin_s, history.ramp.end_s);
        let mean_wind_m_s = (history.carried_m + wind_m_s * (end_s - begin_s)) / step_s;
        let carrying = flow(&air.settings, &self.state, end_s, mean_wind_m_s);
        air.model.convect(&history.before, &carrying, step_s, &mut history.after);
        air.read(&history.ramp);
        air.acceleration.restart();
        let (tolerance, most) = match air.settings.coupling {
            Coupling::Staggered => (f64::INFINITY, 1),
            Coupling::Iterated { tolerance, most_iterations } => (tolerance, most_iterations),
        };
        let mut outcome = Err(0.0);
        for trial in 0..most {
            self.state.air = Some(history);
            let marched = self.march_on_trial(end_s, trial == 0);
            let (wanted_s, next_s) = (self.smallest_step_s, self.state.step_s);
            let ahead = &self.state.ahead;
            if marched.is_ok() {
                self.equations.residual(end_s, &ahead.q, &ahead.v, &ahead.a, &mut self.scratch[0]);
                air.observe(&self.equations, ahead);
            }
            history = self.go_back(&air.trial);
            if trial == 0 {
                history.structure_step_s = (end_s - begin_s) / ((end_s - begin_s) / wanted_s - SLIVER).ceil().max(1.0);
                air.trial.step_s = next_s;
            }
            self.state.step_s = air.trial.step_s;
            if let Err(error) = marched {
                self.state.air = Some(history);
                return Err(error);
            }
            let AirCoupling { model, settings, motions, loads, .. } = &mut *air;
            let flow = flow(settings, &self.state, end_s, wind_m_s);
            self.state.statistics.air_solutions += 1;
            if let Err(error) = model.solve(&history.before, motions, &flow, step_s, &mut history.after, loads) {
                self.state.air = Some(history);
                return Err(refusal(begin_s, error));
            }
            let (change_n, size_n) = air.compare();
            if !change_n.is_finite() {
                self.state.air = Some(history);
                return Err(refusal(begin_s, "its loads are not finite"));
            }
            history.scale_n = history.scale_n.max(size_n);
            if change_n <= tolerance * history.scale_n {
                air.accept();
                outcome = Ok(());
            } else {
                outcome = Err(change_n / history.scale_n);
                let AirCoupling { acceleration, guess, residual, .. } = &mut *air;
                acceleration.next(guess, residual);
            }
            air.write(&mut history.ramp);
            if outcome.is_ok() {
                break;
            }
        }
        self.state.air = Some(history);
        outcome.map_err(|change| {
            refusal(begin_s, format!("{most} iterations leave a change of the loads of {change:.1e} of the largest"))
        })?;
        self.discontinuity(|_, _| 0.0).map(|_| ())
    }

    /// Marches the structure to the end of the aerodynamic step under the present guess of the loads; `first`: with steps
    /// by the error estimate.
    fn march_on_trial(&mut self, end_s: f64, first: bool) -> Result<(), PlantError> {
        self.discontinuity(|_, _| 0.0)?;
        self.smallest_step_s = f64::INFINITY;
        while self.state.ahead.time_s < end_s {
            let State { start, ahead, .. } = &mut self.state;
            start.copy_from(ahead);
            self.apply_events()?;
            match self.machine.solver.fixed_step_s.or_else(|| self.structure_step_s().filter(|_| !first)) {
                Some(step_s) => self.advance_fixed(step_s, end_s)?,
                None => self.advance(end_s)?,
            }
        }
        Ok(())
    }

    /// Step of the structure that the present aerodynamic step is marched with, in s; `None` without air.
    pub(super) fn structure_step_s(&self) -> Option<f64> {
        self.state.air.as_ref().map(|history| history.structure_step_s)
    }

    /// Undoes a trial march; takes the history out, so that its air can be changed.
    fn go_back(&mut self, trial: &Trial) -> AirHistory {
        let solutions = self.state.statistics.air_solutions;
        let State { start, ahead, joints, .. } = &mut self.state;
        start.copy_from(&trial.start);
        ahead.copy_from(&trial.start);
        joints.copy_from_slice(&trial.joints);
        self.state.statistics = trial.statistics;
        self.state.statistics.air_solutions = solutions;
        self.configure();
        if let Some(ramp) = &mut self.equations.ramp {
            ramp.copy_from(&trial.ramp);
        }
        self.state.air.take().expect("a machine in air has a history")
    }
}

impl Trial {
    /// Remembers where a trial march starts. `ramp`: the loads that its accelerations belong to.
    fn save(&mut self, state: &State, ramp: Option<&Ramp>) {
        self.start.copy_from(&state.start);
        self.joints.clone_from(&state.joints);
        (self.step_s, self.statistics) = (state.step_s, state.statistics);
        if let Some(ramp) = ramp {
            self.ramp.copy_from(ramp);
        }
    }
}

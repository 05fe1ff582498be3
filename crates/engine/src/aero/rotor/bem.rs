//! A rotor whose blades are surfaces of bodies: blade-element momentum theory on their sections as they move.
//!
//! The sections of all blades come first, blade by blade; one section of the hub follows, whose point is the rotor's
//! apex. Each annulus is normal to its blade as bent out of the plane, without the twist, the pitch and the bending in
//! the plane, as in AeroDyn. Loads are linear between sections.

use crate::aero::AirLoads;
use crate::aero::flow::Flow;
use crate::aero::polar::Polar;
use crate::aero::rotor::dynamic_inflow::{InflowState, time_constant_s};
use crate::aero::rotor::dynamic_stall::{SplitPolar, StallInflow, StallState};
use crate::aero::rotor::induction::{Annulus, Approach, EndRule, SectionState, aerodyn_balance, balance};
use crate::aero::rotor::skew::Skew;
use crate::aero::rotor::steady::induction_share;
use crate::aero::rotor::tower::Tower;
use crate::aero::rotor::wind::WindField;
use crate::aero::surface::{ChordLine, Surface};
use crate::load::SectionMotion;
use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// What the air of a rotor takes into account: stated by whoever builds the machine, used as it is by the model.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorFeatures {
    /// Whether the rotor turns about its shaft axis by the right hand: clockwise for who looks downwind.
    pub clockwise: bool,
    /// Radius in m at which the blades begin, for the hub loss.
    pub hub_radius_m: f64,
    /// Prandtl's losses at tip and hub.
    pub losses: [bool; 2],
    /// Loads where the loss is complete.
    pub end_rule: EndRule,
    /// Whether the wake leans with the wind, eq. (B15).
    pub skewed_wake: bool,
    /// Whether the induced velocity lags behind the momentum balance as the wake does, eqs. (B9) and (B10).
    pub dynamic_inflow: bool,
    /// Whether sections have dynamic stall, eqs. (B12)–(B14).
    pub dynamic_stall: bool,
    /// Angle of attack of blades that bend both ways and state of heavily loaded annuli as AeroDyn has them, eq. (B23).
    pub as_aerodyn: bool,
    /// Tower that the wind goes around.
    pub tower: Option<Tower>,
    /// Field of the wind; without it the input's wind is everywhere.
    pub field: Option<WindField>,
}

impl RotorFeatures {
    /// A rotor that turns clockwise, whose blades begin at a radius in m; both losses, no load at the ends, no wake that leans or
    /// lags, no dynamic stall, neither tower nor field.
    pub fn of(hub_radius_m: f64) -> Self {
        Self {
            clockwise: true,
            hub_radius_m,
            losses: [true; 2],
            end_rule: EndRule::ZeroLoad,
            skewed_wake: false,
            dynamic_inflow: false,
            dynamic_stall: false,
            as_aerodyn: false,
            tower: None,
            field: None,
        }
    }
}

/// Settings of a rotor's air.
#[derive(Debug, Clone, PartialEq)]
pub struct RotorOptions {
    /// Index into the machine's bodies of the one that turns with the blades.
    pub hub_body: usize,
    /// Unit vector along the shaft in the hub's frame, pointing downwind.
    pub shaft_axis: Vector3<f64>,
    /// Polars, −180° to 180°.
    pub polars: Vec<Polar>,
    /// Index of the polar of each section, surface by surface.
    pub sections: Vec<Vec<usize>>,
    /// Distances of the sections from the root of the blade in m, surface by surface.
    pub positions_m: Vec<Vec<f64>>,
    /// What code and file say alike.
    pub features: RotorFeatures,
}

/// Loads and coefficients of the rotor.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable, Serialize, Deserialize)]
#[repr(C)]
pub struct RotorLoads {
    /// Force of the air along the shaft, downwind positive, in N.
    pub thrust_n: f64,
    /// Torque of the air about the shaft, positive where it drives the rotor, in N·m.
    pub torque_n_m: f64,
    /// Power of the air on the turning hub in W: torque times speed.
    pub power_w: f64,
    /// Speed of the hub about its shaft in rad/s, positive in the rotor's own sense of rotation.
    pub speed_rad_s: f64,
    /// Mean wind along the shaft over the sections of all blades, relative to them, in m/s.
    pub wind_m_s: f64,
    /// Power over `½ρπR²U³`, with the present radius of the outermost section; 0 without wind.
    pub power_coefficient: f64,
    /// Thrust over `½ρπR²U²`; 0 without wind.
    pub thrust_coefficient: f64,
    /// Speed of the outermost section over the wind; 0 without wind.
    pub tip_speed_ratio: f64,
    /// Mean axial induction factor over the annuli; 0 without wind.
    pub induction: f64,
}

impl RotorLoads {
    /// Linear interpolation: these loads at a `share` of 0, the `other` ones at 1.
    pub fn between(&self, other: &Self, share: f64) -> Self {
        let mut mixed = *self;
        let (numbers, ends): (&mut [f64], &[f64]) = (
            bytemuck::cast_slice_mut(std::slice::from_mut(&mut mixed)),
            bytemuck::cast_slice(std::slice::from_ref(other)),
        );
        numbers.iter_mut().zip(ends).for_each(|(number, end)| *number += (end - *number) * share);
        mixed
    }
}

/// Memory of one section.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SectionMemory {
    /// Of the wake.
    pub inflow: InflowState,
    /// Of the section.
    pub stall: StallState,
}

/// All that a rotor's air remembers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RotorState {
    /// Section by section of the blades.
    pub sections: Vec<SectionMemory>,
    /// Loads of the rotor at this time.
    pub loads: RotorLoads,
}

impl RotorState {
    /// Copies without allocating; both must belong to the same model.
    pub fn copy_from(&mut self, other: &Self) {
        self.sections.copy_from_slice(&other.sections);
        self.loads = other.loads;
    }

    /// Whether a state has the sizes of this one.
    pub fn fits(&self, other: &Self) -> bool {
        self.sections.len() == other.sections.len()
    }
}

/// Constant data of a section.
struct Section {
    chord: ChordLine,
    chord_m: f64,
    polar: usize,
    /// `B (R − r)/(2 r)` and `B (r − r_h)/(2 r_h)` of the straight blade.
    exponents: [f64; 2],
}

/// A section at one instant, before induction.
#[derive(Clone, Copy)]
struct Cut {
    arm_m: Vector3<f64>,
    relative_m_s: Vector3<f64>,
    radial_m: Vector3<f64>,
    from_apex_m: Vector3<f64>,
    line_n_m: Vector3<f64>,
    moment_n: Vector3<f64>,
}

const NO_CUT: Cut = Cut {
    arm_m: Vector3::new(0.0, 0.0, 0.0),
    relative_m_s: Vector3::new(0.0, 0.0, 0.0),
    radial_m: Vector3::new(0.0, 0.0, 0.0),
    from_apex_m: Vector3::new(0.0, 0.0, 0.0),
    line_n_m: Vector3::new(0.0, 0.0, 0.0),
    moment_n: Vector3::new(0.0, 0.0, 0.0),
};

/// Blade-element momentum theory on moving blades.
pub struct Rotor {
    options: RotorOptions,
    blades: Vec<std::ops::Range<usize>>,
    sections: Vec<Section>,
    splits: Vec<Option<SplitPolar>>,
    cuts: Vec<Cut>,
}

/// The disc at one instant.
struct Disc {
    normal: Vector3<f64>,
    turn: f64,
    share: f64,
    radius_m: f64,
    skew: Option<Skew>,
    loads: RotorLoads,
}

impl Rotor {
    /// A rotor on these surfaces, one per blade.
    pub fn new(surfaces: &[Surface], options: &RotorOptions) -> Self {
        let half = 0.5 * surfaces.len() as f64;
        let mut sections = Vec::new();
        for (blade, surface) in surfaces.iter().enumerate() {
            let positions_m = &options.positions_m[blade];
            let hub_m = options.features.hub_radius_m;
            let tip_m = hub_m + positions_m[positions_m.len() - 1];
            for (section, chord) in surface.chords.iter().enumerate() {
                let radius_m = hub_m + positions_m[section];
                let [tip, hub] = options.features.losses;
                sections.push(Section {
                    chord: *chord,
                    chord_m: chord.length_m(),
                    polar: options.sections[blade][section],
                    exponents: [
                        if tip { half * (tip_m - radius_m) / radius_m } else { f64::INFINITY },
                        if hub && hub_m > 0.0 { half * (radius_m - hub_m) / hub_m } else { f64::INFINITY },
                    ],
                });
            }
        }
        let splits = options.polars.iter().map(|polar| SplitPolar::new(polar.clone()));
        Self {
            blades: surfaces.iter().map(|surface| surface.sections.clone()).collect(),
            cuts: vec![NO_CUT; sections.len()],
            splits: splits.map(|split| split.filter(|_| options.features.dynamic_stall)).collect(),
            sections,
            options: options.clone(),
        }
    }

    /// Index of a blade whose axis lies along the shaft, so that it is not in the disc; such a blade carries no load.
    pub fn blade_along_shaft(&self, motions: &[SectionMotion]) -> Option<usize> {
        let normal = motions[self.sections.len()].rotation * self.options.shaft_axis;
        self.blades.iter().position(|range| {
            let along = motions[range.start].rotation.column(0).into_owned();
            (along - normal * along.dot(&normal)).norm() < 1e-6
        })
    }

    /// A state of the right size, without air.
    pub fn blank_state(&self) -> RotorState {
        RotorState { sections: vec![SectionMemory::default(); self.sections.len()], loads: RotorLoads::default() }
    }

    /// State and loads at the start; in an `established` flow the wake is fully developed.
    pub fn start(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        established: bool,
        state: &mut RotorState,
        loads: &mut AirLoads,
    ) {
        self.look(motions, flow, if established { Past::Settled } else { Past::Still }, state, loads);
    }

    /// State and loads at the end of a step of `step_s` from `from`, for motions and flow there.
    pub fn solve(
        &mut self,
        from: &RotorState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        to: &mut RotorState,
        loads: &mut AirLoads,
    ) {
        self.look(motions, flow, Past::Known { from, step_s }, to, loads);
    }

    fn look(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        past: Past,
        state: &mut RotorState,
        loads: &mut AirLoads,
    ) {
        loads.clear();
        let mut disc = self.meet(motions, flow);
        let first_s = match past {
            Past::Known { from, .. } => time_constant_s(disc.radius_m, from.loads.induction, disc.loads.wind_m_s),
            _ => 0.0,
        };
        let (mut induction, mut area) = (0.0, 0.0);
        for blade in 0..self.blades.len() {
            let range = self.blades[blade].clone();
            // direction of the blade in the disc, taken at its root: bending in the plane does not turn the annuli
            let root = motions[range.start].rotation.column(0).into_owned();
            let along = root - disc.normal * root.dot(&disc.normal);
            let Some(along) = along.try_normalize(1e-9) else { continue };
            let ahead = disc.normal.cross(&along) * disc.turn;
            for index in range {
                let memory = &mut state.sections[index];
                let a = self.section(index, &motions[index], &disc, &ahead, flow, &past, first_s, memory);
                let weight = self.cuts[index].radial_m.norm();
                if let Some(a) = a {
                    induction += weight * a;
                    area += weight;
                }
            }
        }
        self.spread(loads, &mut disc);
        let RotorLoads { thrust_n, power_w, wind_m_s, .. } = disc.loads;
        let pressure_n = 0.5 * flow.density_kg_m3 * PI * disc.radius_m.powi(2) * wind_m_s.powi(2);
        if pressure_n > 0.0 {
            disc.loads.thrust_coefficient = thrust_n / pressure_n;
            disc.loads.power_coefficient = power_w / (pressure_n * wind_m_s.abs());
        }
        if area > 0.0 {
            disc.loads.induction = induction / area;
        }
        state.loads = disc.loads;
    }

    /// Inflow of all sections into the scratch memory, and the disc.
    fn meet(&mut self, motions: &[SectionMotion], flow: &Flow) -> Disc {
        let hub = &motions[self.sections.len()];
        let normal = hub.rotation * self.options.shaft_axis;
        let turn = if self.options.features.clockwise { 1.0 } else { -1.0 };
        let (mut mean_m_s, mut radius_m) = (Vector3::zeros(), 0.0f64);
        for ((cut, section), motion) in self.cuts.iter_mut().zip(&self.sections).zip(motions) {
            let arm_m = motion.rotation * section.chord.at(0.25);
            let point_m = motion.position_m + arm_m;
            let air_m_s = undisturbed_m_s(&self.options, flow, &point_m);
            let tower = self.options.features.tower.as_ref();
            let added_m_s = tower.map_or_else(Vector3::zeros, |tower| tower.added_m_s(&point_m, &air_m_s));
            let from_apex_m = point_m - hub.position_m;
            let radial_m = from_apex_m - normal * from_apex_m.dot(&normal);
            radius_m = radius_m.max(radial_m.norm());
            let velocity_m_s = motion.velocity_m_s + motion.spin_rad_s.cross(&arm_m);
            mean_m_s += air_m_s - velocity_m_s;
            *cut = Cut { arm_m, relative_m_s: air_m_s + added_m_s - velocity_m_s, radial_m, from_apex_m, ..NO_CUT };
        }
        let met_m_s = mean_m_s / self.sections.len() as f64;
        let speed_rad_s = turn * (hub.spin_rad_s + flow.spin_rad_s).dot(&normal);
        let tip_m_s = (speed_rad_s * radius_m).abs();
        // in still air the motions of the sections cancel but for round-off
        let wind_m_s = Some(met_m_s.dot(&normal)).filter(|wind| wind.abs() > 1e-12 * tip_m_s).unwrap_or(0.0);
        let share = if wind_m_s == 0.0 && tip_m_s > 0.0 { 1.0 } else { induction_share(tip_m_s / wind_m_s.abs()) };
        let tip_speed_ratio = if wind_m_s == 0.0 { 0.0 } else { tip_m_s / wind_m_s.abs() };
        Disc {
            normal,
            turn,
            share: if share.is_nan() { 0.0 } else { share },
            radius_m,
            skew: self.options.features.skewed_wake.then(|| Skew::of(&met_m_s, &normal)),
            loads: RotorLoads { speed_rad_s, wind_m_s, tip_speed_ratio, ..RotorLoads::default() },
        }
    }

    /// Line load and moment of one section into the scratch memory; returns its axial induction factor where the
    /// momentum balance has a solution.
    #[allow(clippy::too_many_arguments)] // one call, split off for its length
    fn section(
        &mut self,
        index: usize,
        motion: &SectionMotion,
        disc: &Disc,
        ahead: &Vector3<f64>,
        flow: &Flow,
        past: &Past,
        first_s: f64,
        memory: &mut SectionMemory,
    ) -> Option<f64> {
        let section = &self.sections[index];
        let cut = &mut self.cuts[index];
        let axis = motion.rotation.column(0).into_owned();
        let tangent = (axis - ahead * axis.dot(ahead)).try_normalize(1e-9)?;
        let normal = tangent.cross(ahead);
        let normal = if normal.dot(&disc.normal) < 0.0 { -normal } else { normal };
        let radius_m = cut.radial_m.norm();
        let annulus = Annulus {
            solidity: 0.5 * self.blades.len() as f64 * section.chord_m / (PI * radius_m.max(1e-9)),
            tip_exponent: section.exponents[0],
            hub_exponent: section.exponents[1],
        };
        let chord = motion.rotation * (section.chord.leading_m - section.chord.trailing_m);
        let chord_angle_rad = if self.options.features.as_aerodyn {
            // from where the chord would lie in the disc, about the section's own axis
            let level = (disc.normal.cross(&axis) * disc.turn).try_normalize(1e-9)?;
            (-chord.dot(&(axis.cross(&level) * disc.turn))).atan2(chord.dot(&level))
        } else {
            (-chord.dot(&normal)).atan2(chord.dot(ahead))
        };
        let approach = Approach {
            axial_m_s: cut.relative_m_s.dot(&normal),
            tangential_m_s: -cut.relative_m_s.dot(ahead),
            chord_angle_rad,
        };
        let polar = &self.options.polars[section.polar];
        let induced_m_s = match (annulus.is_end(), self.options.features.end_rule) {
            (true, EndRule::ZeroLoad) => return None,
            (true, EndRule::Stopped) => [approach.axial_m_s, 0.0],
            (false, _) => {
                let free = match self.options.features.as_aerodyn {
                    true => aerodyn_balance(&annulus, polar, &approach),
                    false => balance(&annulus, polar, &approach),
                };
                let balanced_m_s = [free.axial_loss_m_s, free.swirl_m_s];
                memory.inflow = match past {
                    Past::Known { from, step_s } if self.options.features.dynamic_inflow => {
                        let span = radius_m / disc.radius_m;
                        from.sections[index].inflow.after(balanced_m_s, *step_s, first_s, span)
                    }
                    Past::Still if self.options.features.dynamic_inflow => {
                        InflowState { balanced_m_s, ..InflowState::default() }
                    }
                    _ => InflowState::established(balanced_m_s),
                };
                let [axial_m_s, swirl_m_s] = memory.inflow.acting_m_s;
                let factor = match &disc.skew {
                    Some(skew) if approach.axial_m_s != 0.0 => {
                        skew.factor(&(cut.radial_m / disc.radius_m), axial_m_s / approach.axial_m_s)
                    }
                    _ => 1.0,
                };
                [axial_m_s * factor, swirl_m_s]
            }
        }
        .map(|velocity_m_s| disc.share * velocity_m_s);
        let met_m_s = [approach.axial_m_s - induced_m_s[0], approach.tangential_m_s + induced_m_s[1]];
        let mut state = SectionState::of(met_m_s[0], met_m_s[1], approach.chord_angle_rad, polar);
        if let Some(split) = &self.splits[section.polar] {
            let met = StallInflow {
                speed_m_s: state.speed_m_s,
                attack_rad: state.attack_rad,
                pitch_rate_rad_s: (motion.spin_rad_s + flow.spin_rad_s).dot(&ahead.cross(&normal)),
                chord_m: section.chord_m,
            };
            memory.stall = match past {
                Past::Known { from, step_s } => from.sections[index].stall.after(met, *step_s, split),
                _ => StallState::steady(met, split),
            };
            let dynamic = memory.stall.coefficients(split);
            (state.row.lift, state.row.drag, state.row.moment) = (dynamic.lift, dynamic.drag, dynamic.moment);
        }
        let [along, drive] = state.force_m3_s2(section.chord_m);
        cut.line_n_m = (normal * along + ahead * drive) * flow.density_kg_m3;
        let moment = 0.5 * flow.density_kg_m3 * (section.chord_m * state.speed_m_s).powi(2) * state.row.moment;
        cut.moment_n = ahead.cross(&normal) * moment;
        let wind_m_s = disc.loads.wind_m_s;
        (!annulus.is_end() && wind_m_s != 0.0)
            .then(|| memory.inflow.acting_m_s[0] / approach.axial_m_s)
            .filter(|a| a.is_finite())
    }

    /// Spreads the line loads over the sections, eq. (B8), and sums thrust and torque.
    fn spread(&mut self, loads: &mut AirLoads, disc: &mut Disc) {
        let Self { blades, cuts, options, .. } = self;
        for (blade, range) in blades.iter().enumerate() {
            let (cuts, loads) = (&cuts[range.clone()], &mut loads.circulatory[range.clone()]);
            for (inner, places_m) in options.positions_m[blade].windows(2).enumerate() {
                let ends = [inner, inner + 1];
                let length_m = places_m[1] - places_m[0];
                let way = cuts[ends[1]].from_apex_m - cuts[ends[0]].from_apex_m;
                let along = way.try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
                for (own, other, sign) in [(ends[0], ends[1], 1.0), (ends[1], ends[0], -1.0)] {
                    let (near, far) = (&cuts[own], &cuts[other]);
                    let force_n = (near.line_n_m * 7.0 + far.line_n_m * 3.0) * (length_m / 20.0);
                    let lever_n_m = (near.line_n_m * 3.0 + far.line_n_m * 2.0) * (sign * length_m * length_m / 60.0);
                    let moment_n_m = (near.moment_n * 2.0 + far.moment_n) * (length_m / 6.0) + along.cross(&lever_n_m);
                    loads[own].add_force_at(&near.arm_m, &force_n);
                    loads[own].moment_n_m += moment_n_m;
                    disc.loads.thrust_n += force_n.dot(&disc.normal);
                    let about_apex_n_m = near.from_apex_m.cross(&force_n) + moment_n_m;
                    disc.loads.torque_n_m += disc.turn * about_apex_n_m.dot(&disc.normal);
                }
            }
        }
        disc.loads.power_w = disc.loads.torque_n_m * disc.loads.speed_rad_s;
    }
}

/// Where a step starts from.
enum Past<'a> {
    /// Flow and wake are fully developed.
    Settled,
    /// The flow sets in: with dynamic inflow the wake has no induced velocity yet.
    Still,
    /// From the state at the end of the step before.
    Known { from: &'a RotorState, step_s: f64 },
}

/// Velocity of the air without rotor and tower as seen from the root frame, in m/s.
fn undisturbed_m_s(options: &RotorOptions, flow: &Flow, point_m: &Vector3<f64>) -> Vector3<f64> {
    let plain_m_s = flow.velocity_m_s(point_m);
    match &options.features.field {
        Some(field) => plain_m_s - flow.wind_m_s + field.velocity_m_s(flow.time_s, point_m, &flow.wind_m_s),
        None => plain_m_s,
    }
}

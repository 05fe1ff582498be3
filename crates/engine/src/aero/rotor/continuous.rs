//! Blades in continuous time: loads and rates of the lag states at one instant, and their derivatives with respect to the motion of the
//! sections and to the air, NOTATION eqs. (B27) and (B31).

use crate::aero::flow::Flow;
use crate::aero::rotor::bem::{Past, Rotor, RotorState, SectionMemory};
use crate::aero::rotor::dynamic_inflow::time_constant_s;
use crate::aero::rotor::dynamic_stall::SEPARATED;
use crate::aero::rotor::loads::RotorLoads;
use crate::aero::rotor::states::RotorLag;
use crate::aero::strip::continuous::{Answer, LOAD_ROWS, Variable, displace, kinds_of_loads};
use crate::aero::strip::instant::Instant;
use crate::load::SectionMotion;
use crate::math::corners::{STEPS, slope_off_corners};
use std::mem::offset_of;

/// Difference step relative to the scale of the sections. The steps span 0.03° of angle of attack, so that few of them cross a row of a
/// polar. The root of the momentum balance is exact to 1e-14, hence derivatives to 1e-10.
const STEP: f64 = 1e-4;
/// Difference step of the degree of attachment of a separated section.
const SEPARATED_STEP: f64 = 0.1 * SEPARATED;
/// Number of rows of an answer that belong to the rotor as a whole: its loads and coefficients.
const OWN: usize = size_of::<RotorLoads>() / size_of::<f64>();
/// Smallest speed in m/s used to scale the difference steps: without any motion there are no loads.
const MINIMUM_SPEED_M_S: f64 = 1e-3;
/// Change of the balance between the two sides of the last step, relative to the speed of the section, beyond which it is tested for a
/// jump. Derivatives of the balance are about 1, which gives 5e-4.
const JUMP: f64 = 1.5e-3;
/// Fraction of that change that is not explained by the change between the two sides of the first step: 1 or 1.6 for a jump, 1e-3 for a
/// smooth curve.
const CROOKED: f64 = 0.5;

impl Rotor {
    /// Writes the loads of all sections in their own frames, the rates of the lag states ([`Rotor::lags`]) in their units per s, and then
    /// the loads and coefficients of the rotor ([`RotorLoads`]), the limit of the steps of [`Rotor::solve`] as they shrink, eq. (W24).
    /// Allocates nothing.
    pub fn respond(&mut self, at: &Instant, answer: &mut [f64]) {
        self.respond_as(at, false, answer);
    }

    /// The same; `unwrapped` as in [`StallState::rates_1_s`](super::dynamic_stall::StallState::rates_1_s).
    fn respond_as(&mut self, at: &Instant, unwrapped: bool, answer: &mut [f64]) {
        let (mut state, mut loads) = std::mem::take(&mut self.instant);
        let flow = Flow { wind_m_s: at.flow.wind_m_s + at.gust_m_s, ..at.flow };
        state.sections.fill(SectionMemory::default());
        self.give(&at.lags, &mut state.sections);
        self.look(&at.motions, &flow, Past::Given, &mut state, &mut loads);
        let (of_sections, rest) = answer.split_at_mut(LOAD_ROWS * at.motions.len());
        let (rates, own) = rest.split_at_mut(self.lags.len());
        for ((rows, load), motion) in
            of_sections.chunks_exact_mut(LOAD_ROWS).zip(&loads.circulatory).zip(at.motions.iter())
        {
            let turned = motion.rotation.transpose();
            rows[..3].copy_from_slice((turned * load.force_n).as_slice());
            rows[3..].copy_from_slice((turned * load.moment_n_m).as_slice());
        }
        self.write_rates(&state, unwrapped, rates);
        own.copy_from_slice(bytemuck::cast_slice(std::slice::from_ref(&state.loads)));
        self.instant = (state, loads);
    }

    /// Writes the rates of the lag states in their units per s.
    fn write_rates(&self, state: &RotorState, unwrapped: bool, rates: &mut [f64]) {
        let rotor_m = self.rotor_radius_m();
        let first_s = time_constant_s(rotor_m, state.loads.induction, state.loads.wind_m_s);
        let lag_s = self.options.features.inflow_lag_s.unwrap_or(f64::INFINITY);
        let (mut present, mut inflow, mut stall) = (None, [[0.0; 2]; 2], [0.0; 4]);
        for ((section, lag), rate) in self.lags.iter().zip(rates) {
            let memory = &state.sections[*section];
            if present != Some(section) {
                present = Some(section);
                inflow = memory.inflow.rates_m_s2(first_s, self.cuts[*section].radial_m.norm() / rotor_m);
                let split = self.splits[self.sections[*section].polar].as_ref();
                stall = split.map_or([0.0; 4], |split| memory.stall.rates_1_s(split, unwrapped));
            }
            *rate = match *lag {
                RotorLag::Induced => (memory.inflow.balanced_m_s[0] - memory.inflow.acting_m_s[0]) / lag_s,
                RotorLag::Reduced(axis) => inflow[0][axis],
                RotorLag::Acting(axis) => inflow[1][axis],
                RotorLag::Wake(term) => stall[term],
                RotorLag::Lift => stall[2],
                RotorLag::Attached => stall[3],
            };
        }
    }

    /// Stores the instant of the last [`Rotor::respond`] in a state, with its lag states and loads: steps can continue from there.
    pub fn remember(&self, state: &mut RotorState) {
        state.copy_from(&self.instant.0);
    }

    /// Length of a response to an instant.
    fn rows(&self, sections: usize) -> usize {
        LOAD_ROWS * sections + self.lags.len() + OWN
    }

    /// Derivative of [`Rotor::respond`] by sixth-order central differences that avoid the kinks of polars, as for strips. The model has no
    /// apparent mass: accelerations and rates of the wind have no effect. There is no derivative if the momentum balance jumps, see
    /// [`Rotor::jump`].
    pub fn slope(&mut self, at: &Instant, variable: Variable) -> Answer {
        let mut at = at.clone();
        let step = self.difference(&mut at, variable);
        let mut present = vec![0.0; self.rows(at.motions.len())];
        let Some(step) = step else { return present };
        self.respond_as(&at, true, &mut present);
        let mut beside_m_s: Vec<Vec<[f64; 2]>> = Vec::new();
        let kinds = self.kinds(&at);
        // on the side of the current direction of rotation; the mean of both sides if the rotor does not turn
        let sign = |speed_rad_s: f64| if speed_rad_s == 0.0 { 0.0 } else { speed_rad_s.signum() };
        let turning = sign(self.instant.0.loads.speed_rad_s);
        let ratio = present.len() - OWN + offset_of!(RotorLoads, tip_speed_ratio) / size_of::<f64>();
        present[ratio] *= turning * turning;
        let slope = slope_off_corners(step, &kinds, &present, |shift, side| {
            let mut beside = at.clone();
            displace(&mut beside, variable, shift);
            self.respond_as(&beside, true, side);
            let state = &self.instant.0;
            side[ratio] *= turning * sign(state.loads.speed_rad_s);
            // only of the first attempt: the limits of the jump test are for unshortened steps
            if beside_m_s.len() < 2 * STEPS.len() {
                beside_m_s.push(state.sections.iter().map(|section| section.inflow.balanced_m_s).collect());
            }
        });
        let change_m_s = |i: usize| -> Vec<[f64; 2]> {
            let ends = beside_m_s[2 * i].iter().zip(&beside_m_s[2 * i + 1]);
            ends.map(|(one, other)| [0, 1].map(|axis| one[axis] - other[axis])).collect()
        };
        self.look_for_a_jump(&at, &change_m_s(0), &change_m_s(STEPS.len() - 1));
        slope
    }

    /// Kinds of the rows of an answer: forces, moments, lag states by type, and each load and coefficient of the rotor.
    fn kinds(&self, at: &Instant) -> Vec<usize> {
        let mut kinds = kinds_of_loads(at.motions.len());
        kinds.extend(self.lags.iter().map(|(_, lag)| match lag {
            RotorLag::Induced | RotorLag::Reduced(_) => 2,
            RotorLag::Acting(_) => 3,
            RotorLag::Wake(_) => 4,
            RotorLag::Lift => 5,
            RotorLag::Attached => 6,
        }));
        kinds.extend(7..7 + OWN);
        kinds
    }

    /// Stores a section whose balance changes discontinuously between the two sides of a variable: `near` is for the first step, `far` for
    /// the last.
    fn look_for_a_jump(&mut self, at: &Instant, near_m_s: &[[f64; 2]], far_m_s: &[[f64; 2]]) {
        let [.., last] = STEPS;
        for (section, (near, far)) in near_m_s.iter().zip(far_m_s).enumerate() {
            let size_m_s = far[0].hypot(far[1]);
            let crooked_m_s = (far[0] - last * near[0]).hypot(far[1] - last * near[1]);
            let seen = size_m_s > JUMP * self.met_m_s(section, at).max(MINIMUM_SPEED_M_S);
            if seen && crooked_m_s > CROOKED * size_m_s {
                self.jump.get_or_insert(section);
            }
        }
    }

    /// Takes the section whose momentum balance jumped between the two sides of a derivative since the last call.
    pub fn jump(&mut self) -> Option<usize> {
        self.jump.take()
    }

    /// Difference step; `None` if nothing depends on the variable. Sets a degree of attachment close to 0 to a value below 0 by more than the
    /// steps: there its square root, whose slope is infinite at 0, is 0, and the response is linear in it.
    fn difference(&self, at: &mut Instant, variable: Variable) -> Option<f64> {
        if let Variable::Lag(lag) = variable {
            let (section, kind) = self.lags[lag];
            let value = &mut at.lags.to_mut()[lag];
            return Some(match kind {
                RotorLag::Attached if *value < SEPARATED => {
                    *value = -SEPARATED;
                    SEPARATED_STEP
                }
                RotorLag::Attached => STEP * value.min(1.0),
                RotorLag::Wake(_) | RotorLag::Lift => STEP,
                RotorLag::Induced | RotorLag::Reduced(_) | RotorLag::Acting(_) => {
                    STEP * self.met_m_s(section, at).max(MINIMUM_SPEED_M_S)
                }
            });
        }

        let at = &*at;
        let motion = |section: usize| &at.motions[section.min(at.motions.len() - 1)];
        let speed_m_s = |section: usize| (self.air_m_s(motion(section), at) - motion(section).velocity_m_s).norm();
        let slowest_m_s = (0..self.cuts.len()).map(|section| self.met_m_s(section, at)).fold(f64::INFINITY, f64::min);
        let slowest_m_s = slowest_m_s.max(MINIMUM_SPEED_M_S);
        let of = |section: usize| match section < self.cuts.len() {
            true => (self.met_m_s(section, at).max(MINIMUM_SPEED_M_S), self.arm_m(section)),
            false => (slowest_m_s.min(speed_m_s(section).max(MINIMUM_SPEED_M_S)), self.arm_m(0)),
        };
        match variable {
            Variable::Motion { section, component } => {
                let (speed_m_s, arm_m) = of(section);
                match component {
                    0..3 => Some(STEP * arm_m),
                    3..6 => Some(STEP),
                    6..9 => Some(STEP * speed_m_s),
                    9..12 => Some(STEP * speed_m_s / arm_m),
                    _ => None,
                }
            }
            Variable::Air(component) => match component {
                3..6 => {
                    let reach_m = at.motions.iter().map(|motion| motion.position_m.norm());
                    Some(STEP * slowest_m_s / reach_m.fold(self.arm_m(0), f64::max))
                }
                _ => Some(STEP * slowest_m_s),
            },
            Variable::Lag(_)
            | Variable::AirRate(_)
            | Variable::FlapAngle(_)
            | Variable::FlapRate(_)
            | Variable::FlapAcceleration(_) => None,
        }
    }

    /// Velocity of the undisturbed air at a section's frame, in m/s.
    fn air_m_s(&self, motion: &SectionMotion, at: &Instant) -> nalgebra::Vector3<f64> {
        at.flow.velocity_m_s(&motion.position_m) + at.gust_m_s
    }

    /// Speed of the air relative to the quarter chord of a section, in m/s.
    fn met_m_s(&self, section: usize, at: &Instant) -> f64 {
        let motion = &at.motions[section];
        let arm_m = motion.rotation * self.quarter_m(section);
        (self.air_m_s(motion, at) - motion.velocity_m_s - motion.spin_rad_s.cross(&arm_m)).norm()
    }

    /// Larger of the chord and the distance from the section's frame to its quarter chord, in m.
    fn arm_m(&self, section: usize) -> f64 {
        self.chord_m(section).max(self.quarter_m(section).norm())
    }
}

//! Blades in continuous time: loads and rates of the induced velocities at one instant, and their derivatives by the motion of the
//! sections and by the air, NOTATION eq. (B27). Only with an induced velocity that lags, eq. (B24), and without dynamic stall.

use crate::aero::AirLoads;
use crate::aero::flow::Flow;
use crate::aero::rotor::bem::{Past, Rotor};
use crate::aero::strip::continuous::{Answer, Instant, LOAD_ROWS, Variable, displace};
use crate::load::SectionMotion;

/// Step of a difference over the scale of the sections.
const STEP: f64 = 1e-3;
/// Sixth-order central difference: weights of the steps 1, 2, 3 over 60 steps.
const WEIGHTS: [f64; 3] = [45.0, -9.0, 1.0];
/// Smallest speed in m/s on which steps are based: with nothing moving nothing acts.
const MINIMUM_SPEED_M_S: f64 = 1e-3;

impl Rotor {
    /// Whether the air of the rotor has linear models.
    pub fn is_linearised(&self) -> bool {
        self.options.features.is_linearised()
    }

    /// Number of induced velocities that lag: one of each section of each blade.
    pub fn lags(&self) -> usize {
        if self.is_linearised() { self.cuts.len() } else { 0 }
    }

    /// Loads of all sections in their own frames, rates of the induced velocities in m/s², then zeros in place of circulations.
    pub fn answer(&mut self, at: &Instant) -> Answer {
        let (sections, lags) = (at.motions.len(), self.lags());
        let strips: usize = self.blades.iter().map(|blade| blade.len() - 1).sum();
        let mut answer = vec![0.0; LOAD_ROWS * sections + lags + strips];
        let mut state = self.blank_state();
        let mut loads = AirLoads::still(sections);
        let flow = Flow { wind_m_s: at.flow.wind_m_s + at.gust_m_s, ..at.flow };
        self.look(&at.motions, &flow, Past::Given(&at.lags_m_s), &mut state, &mut loads);
        let (rows, rates) = answer.split_at_mut(LOAD_ROWS * sections);
        for ((rows, load), motion) in rows.chunks_exact_mut(LOAD_ROWS).zip(&loads.circulatory).zip(at.motions.iter()) {
            let turned = motion.rotation.transpose();
            rows[..3].copy_from_slice((turned * load.force_n).as_slice());
            rows[3..].copy_from_slice((turned * load.moment_n_m).as_slice());
        }
        let time_s = self.options.features.inflow_lag_s.unwrap_or(f64::INFINITY);
        for (rate, memory) in rates.iter_mut().zip(&state.sections) {
            *rate = (memory.inflow.balanced_m_s[0] - memory.inflow.acting_m_s[0]) / time_s;
        }
        answer
    }

    /// Derivative of [`Rotor::answer`]: sixth-order central differences. The air has no mass: accelerations and rates of the wind
    /// change nothing.
    pub fn slope(&mut self, at: &Instant, variable: Variable) -> Answer {
        let step = self.difference(at, variable);
        let mut slope: Option<Answer> = None;
        for (i, weight) in WEIGHTS.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let mut beside = at.clone();
                if let Some(step) = step {
                    displace(&mut beside, variable, sign * (i + 1) as f64 * step);
                }
                let side = self.answer(&beside);
                let share = step.map_or(0.0, |step| sign * weight / (60.0 * step));
                let sum = slope.get_or_insert_with(|| vec![0.0; side.len()]);
                sum.iter_mut().zip(&side).for_each(|(slope, side)| *slope += share * side);
            }
        }
        slope.unwrap_or_default()
    }

    /// Step of the difference; `None` where nothing depends on the variable.
    fn difference(&self, at: &Instant, variable: Variable) -> Option<f64> {
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
            Variable::Lag(lag) => Some(STEP * of(lag).0),
            Variable::Air(component) => match component {
                3..6 => {
                    let reach_m = at.motions.iter().map(|motion| motion.position_m.norm());
                    Some(STEP * slowest_m_s / reach_m.fold(self.arm_m(0), f64::max))
                }
                _ => Some(STEP * slowest_m_s),
            },
            Variable::AirRate(_) | Variable::FlapAngle(_) | Variable::FlapRate(_) | Variable::FlapAcceleration(_) => {
                None
            }
        }
    }

    /// Undisturbed air at a section's frame, in m/s.
    fn air_m_s(&self, motion: &SectionMotion, at: &Instant) -> nalgebra::Vector3<f64> {
        at.flow.velocity_m_s(&motion.position_m) + at.gust_m_s
    }

    /// Speed of the air against the quarter chord of a section, in m/s.
    fn met_m_s(&self, section: usize, at: &Instant) -> f64 {
        let motion = &at.motions[section];
        let arm_m = motion.rotation * self.quarter_m(section);
        (self.air_m_s(motion, at) - motion.velocity_m_s - motion.spin_rad_s.cross(&arm_m)).norm()
    }

    /// Largest of chord and distance from the section's frame to its quarter chord, in m.
    fn arm_m(&self, section: usize) -> f64 {
        self.chord_m(section).max(self.quarter_m(section).norm())
    }
}

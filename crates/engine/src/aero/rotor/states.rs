//! States of the rotor aerodynamics, section by section, and the lag states in linearised models.

use crate::aero::memory::Measure;
use crate::aero::rotor::bem::{Rotor, Section};
use crate::aero::rotor::dynamic_inflow::InflowState;
use crate::aero::rotor::dynamic_stall::StallState;
use crate::aero::rotor::induction::{Annulus, EndRule};
use crate::aero::rotor::loads::RotorLoads;
use serde::{Deserialize, Serialize};

/// State of one section.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct SectionMemory {
    /// State of the wake.
    pub inflow: InflowState,
    /// State of dynamic stall.
    pub stall: StallState,
}

/// State of the rotor aerodynamics.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RotorState {
    /// States of the blade sections, blade by blade.
    pub sections: Vec<SectionMemory>,
    /// Loads of the rotor at the time of this state.
    pub loads: RotorLoads,
}

impl RotorState {
    /// Copies another state of the same model without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.sections.copy_from_slice(&other.sections);
        self.loads = other.loads;
    }

    /// Whether another state has the same sizes.
    pub fn fits(&self, other: &Self) -> bool {
        self.sections.len() == other.sections.len()
    }
}

/// A lag state of a section at an instant, for linearised models and external integrators, eq. (B27).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RotorLag {
    /// Induced velocity along the shaft with one lag, eq. (B24), m/s.
    Induced,
    /// Induced velocity after the first lag minus the direct fraction of the balance, eq. (B31), m/s: axial (0) or tangential (1).
    Reduced(usize),
    /// Induced velocity after both lags, eq. (B10), m/s: axial (0) or tangential (1).
    Acting(usize),
    /// Lagged term of the downwash due to the section's wake, eq. (B13), rad.
    Wake(usize),
    /// Lift coefficient of attached flow after the pressure lag, eq. (B13).
    Lift,
    /// Degree of attachment, eq. (B13).
    Attached,
}

impl RotorLag {
    /// Suffix of the state's name, after the name of the station.
    pub fn name(self) -> &'static str {
        match self {
            Self::Induced => "induced",
            Self::Reduced(axis) => ["inflow_axial", "inflow_tangential"][axis],
            Self::Acting(axis) => ["induced_axial", "induced_tangential"][axis],
            Self::Wake(term) => ["wake[1]", "wake[2]"][term],
            Self::Lift => "attached_lift",
            Self::Attached => "attachment",
        }
    }

    /// Unit of the state.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Induced | Self::Reduced(_) | Self::Acting(_) => "m/s",
            Self::Wake(_) => "rad",
            Self::Lift | Self::Attached => "1",
        }
    }

    /// The entry of a section's memory that holds this state, with the direct fraction of the balance in place of its reduced velocity.
    fn of(self, memory: &mut SectionMemory) -> &mut f64 {
        match self {
            Self::Induced => &mut memory.inflow.acting_m_s[0],
            Self::Reduced(axis) => &mut memory.inflow.middle_m_s[axis],
            Self::Acting(axis) => &mut memory.inflow.acting_m_s[axis],
            Self::Wake(term) => &mut memory.stall.wake_rad[term],
            Self::Lift => &mut memory.stall.lagged_lift,
            Self::Attached => &mut memory.stall.attached,
        }
    }
}

impl Rotor {
    /// Returns an empty state of the right size.
    pub fn blank_state(&self) -> RotorState {
        RotorState { sections: vec![SectionMemory::default(); self.sections.len()], loads: RotorLoads::default() }
    }

    /// Lists the lag states section by section for the features in use: induced velocities, then dynamic stall. Annuli with complete loss
    /// have no balance and hence no lag; sections without load have no dynamic stall.
    pub(crate) fn memories<'s>(&self, state: &'s mut RotorState, list: &mut Vec<(Measure, &'s mut f64)>) {
        for (section, SectionMemory { inflow, stall }) in self.sections.iter().zip(&mut state.sections) {
            let [one_lag, two_lags, stalls] = self.moved(section);
            let InflowState { balanced_m_s: _, middle_m_s, acting_m_s, lags_s: _ } = inflow;
            if one_lag {
                list.push((Measure::Velocity, &mut acting_m_s[0]));
            } else if two_lags {
                list.extend(middle_m_s.iter_mut().chain(acting_m_s).map(|lag| (Measure::Velocity, lag)));
            }
            if stalls {
                let StallState { wake_rad, lagged_lift, attached, met: _ } = stall;
                list.extend(wake_rad.iter_mut().chain([lagged_lift, attached]).map(|lag| (Measure::Number, lag)));
            }
        }
    }

    /// Whether a section has the single lag of eq. (B24), the two lags of eq. (B10), and dynamic stall.
    pub(super) fn moved(&self, section: &Section) -> [bool; 3] {
        let features = &self.options.features;
        let [tip_exponent, hub_exponent] = section.exponents;
        let is_end = Annulus { solidity: 0.0, tip_exponent, hub_exponent }.is_end();
        let one_lag = features.inflow_lag_s.is_some();
        let is_loaded = one_lag || !is_end || features.end_loads != EndRule::ZeroLoad;
        let stalls = is_loaded && self.splits[section.polar].is_some();
        [one_lag, !one_lag && features.dynamic_inflow && !is_end, stalls]
    }

    /// Lists the lag states at an instant with their sections, section by section: first of the inflow, then of dynamic stall.
    pub(super) fn list_lags(&self) -> Vec<(usize, RotorLag)> {
        let mut list = Vec::new();
        for (index, section) in self.sections.iter().enumerate() {
            let [one_lag, two_lags, stalls] = self.moved(section);
            let mut add = |has: bool, lags: &[RotorLag]| {
                list.extend(lags.iter().filter(|_| has).map(|lag| (index, *lag)));
            };
            add(one_lag, &[RotorLag::Induced]);
            add(two_lags, &[0, 1].map(RotorLag::Reduced));
            add(two_lags, &[0, 1].map(RotorLag::Acting));
            add(stalls, &[RotorLag::Wake(0), RotorLag::Wake(1), RotorLag::Lift, RotorLag::Attached]);
        }
        list
    }

    /// Lag states at an instant with their sections, section by section: first of the inflow, then of dynamic stall.
    pub fn lags(&self) -> &[(usize, RotorLag)] {
        &self.lags
    }

    /// Value of one of the lag states [`Rotor::lags`] in a state, in its unit.
    pub fn lag_value(&self, state: &RotorState, lag: usize) -> f64 {
        let (section, lag) = self.lags[lag];
        let SectionMemory { inflow, stall } = &state.sections[section];
        *lag.of(&mut SectionMemory { inflow: inflow.reduced(), stall: *stall })
    }

    /// Values of the lag states [`Rotor::lags`] in a state.
    pub fn lag_values(&self, state: &RotorState) -> Vec<f64> {
        (0..self.lags.len()).map(|lag| self.lag_value(state, lag)).collect()
    }

    /// Stores lag states in a state, with its momentum balances.
    pub fn set_lags(&self, lags: &[f64], state: &mut RotorState) {
        self.give(lags, &mut state.sections);
        for (section, lag) in &self.lags {
            let inflow = &mut state.sections[*section].inflow;
            if let RotorLag::Reduced(axis) = lag {
                inflow.middle_m_s[*axis] += inflow.direct_m_s(*axis);
            }
        }
    }

    /// Writes lag states to section memories, for [`Past::Given`](super::bem::Past).
    pub(super) fn give(&self, lags: &[f64], memories: &mut [SectionMemory]) {
        for ((section, lag), value) in self.lags.iter().zip(lags) {
            *lag.of(&mut memories[*section]) = *value;
        }
    }
}

//! Start and steps of the lattice: circulation and loads for the motions of the sections, from the parts of its computation.

use crate::aero::established::Established;
use crate::aero::flap::HingeMoment;
use crate::aero::flow::Flow;
use crate::aero::lattice::{Factors, VortexLattice};
use crate::aero::lattice_far::mean_relative_m_s;
use crate::aero::lattice_state::LatticeState;
use crate::aero::near_sheets::NoCirculation;
use crate::aero::wake::NEAR_ROWS;
use crate::aero::{AirLoads, lattice_loads};
use crate::load::SectionMotion;
use nalgebra::Vector3;

impl VortexLattice {
    /// Sets the initial state.
    ///
    /// Impulsive start: the circulation is that of the first instant, without a wake; the starting impulse acts before the first step and
    /// is not one of its loads. Established flow: steady circulation and the corresponding wake, straight along the relative flow at the
    /// trailing edge, eq. (U10), or curved in a steady turn, eq. (U30). It starts at the last corners of a step, eq. (U9), so that the flow
    /// does not change for fixed sections. There is no wake if edge and air have no relative motion.
    ///
    /// If strips with polars have several steady circulations, eq. (U32), the one nearest to the velocities through the strips in `state`
    /// is chosen: attached flow for a [blank state](Self::blank_state), or the flow of an earlier start if the motions have changed little
    /// since.
    ///
    /// # Errors
    /// If the lattice is singular or two sheets are closed.
    pub fn start(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        established: Option<Established>,
        state: &mut LatticeState,
        loads: &mut AirLoads,
    ) -> Result<(), NoCirculation> {
        (state.wake_rows, state.established, state.turning, state.sheds) = (0, false, false, true);
        state.left_m.fill(Vector3::zeros());
        state.far_wake_m_s.fill(Vector3::zeros());
        state.wake_circulation_m2_s.fill(0.0);
        state.wake_node_m.fill(Vector3::zeros());
        state.induced_m_s.fill(Vector3::zeros());
        state.unshed_steps = 0;
        state.lags = false;
        state.relative_m_s = mean_relative_m_s(motions, flow);
        self.compress(motions, flow, state)?;
        let established = self.place_at_start(motions, flow, established, state);
        self.turn_flaps(motions, state);
        self.above_ground(state)?;
        self.look_from_panels(state);
        self.factors = Factors::Due;
        self.influence(state, established)?;
        self.relative_velocity(flow, state, 0..0);
        self.circulate(motions, flow, state)?;
        if established {
            for row in 0..state.wake_rows {
                self.shed_into(row, state);
            }
            // the tangential velocity at the panels includes that of the wake
            self.relative_velocity(flow, state, 0..state.wake_rows);
            // the factors include the wake
            self.factored = false;
        }
        loads.clear();
        state.hinges.fill(HingeMoment::default());
        lattice_loads::circulatory(self, motions, flow, state, loads);
        Ok(())
    }

    /// Computes circulation and loads at the end of a step, for the motions of the sections at that instant.
    ///
    /// `to` comes from [`convect`](Self::convect) with the same `from`. May be called repeatedly with other motions: the result depends
    /// only on the motions, to the round-off of the factors, which belong to the first motion.
    ///
    /// # Errors
    /// If the lattice is singular or two sheets are closed.
    pub fn solve(
        &mut self,
        from: &LatticeState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        to: &mut LatticeState,
        loads: &mut AirLoads,
    ) -> Result<(), NoCirculation> {
        to.relative_m_s = mean_relative_m_s(motions, flow);
        self.compress(motions, flow, to)?;
        self.place(motions, Some((flow, step_s)), to);
        self.turn_flaps(motions, to);
        self.above_ground(to)?;
        self.look_from_panels(to);
        self.influence(to, false)?;
        self.relative_velocity(flow, to, 0..to.wake_rows.min(NEAR_ROWS));
        // polars may have several solutions: the one nearest to that of the previous step is chosen
        to.profile_m_s.copy_from_slice(&from.profile_m_s);
        to.lags = from.lags;
        self.profiles.step_s = Some(step_s);
        let circulated = self.circulate(motions, flow, to);
        self.profiles.step_s = None;
        circulated?;
        loads.clear();
        to.hinges.fill(HingeMoment::default());
        lattice_loads::circulatory(self, motions, flow, to, loads);
        let mut panel_forces = std::mem::take(&mut self.panel_forces);
        lattice_loads::impulsive(self, motions, flow, step_s, (from, to), loads, Some(&mut panel_forces));
        self.panel_forces = panel_forces;
        Ok(())
    }
}

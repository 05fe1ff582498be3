//! Flow that has been established for a long time, with its wake: straight, or curved in a steady turn.

use crate::aero::biot_savart::Sheet;
use crate::aero::flow::{AirPath, Flow};
use crate::aero::lattice::VortexLattice;
use crate::aero::lattice_state::LatticeState;
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// Speed of the air relative to the edge, divided by the sum of their speeds, below which both count as moving together.
const REST_SHARE: f64 = 1e-9;

/// Length of the wake at the start of established flow, divided by the diameter of the lattice: the legs beyond contribute `1/(4·200²)` of
/// the near part.
const ESTABLISHED_DIAMETERS: f64 = 200.0;

/// Largest angle in rad over which the wake of a steady turn is curved; beyond it is straight. The wake of a full circle would reach the
/// wing again, whereas in reality it has sunk and decayed.
const LARGEST_TURN_RAD: f64 = std::f64::consts::FRAC_PI_2;

/// A flow that has been established for a long time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Established {
    /// Length in s of the steps that follow: it determines where the wake starts, eq. (U9).
    pub step_s: f64,
    /// Whether the root frame has rotated at its current rate for a long time, with the sections fixed in it: a steady turn, eq. (U30).
    pub turning: bool,
}

impl Established {
    /// Established flow without a turn.
    pub fn straight(step_s: f64) -> Self {
        Self { step_s, turning: false }
    }
}

impl VortexLattice {
    /// Places the corners at the start, with the wake of an established flow if there is one; returns whether there is.
    pub(super) fn place_at_start(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        established: Option<Established>,
        state: &mut LatticeState,
    ) -> bool {
        if let Some(Established { step_s, turning }) = established {
            // the last corners lie behind the edge only if there is a wake
            state.wake_rows = 1;
            self.place(motions, Some((flow, step_s)), state);
            if self.lay_straight_wake(flow, state) {
                if turning {
                    self.bend_wake(flow, step_s, state);
                }
                return true;
            }
            state.wake_rows = 0;
        }
        self.place(motions, None, state);
        false
    }

    /// Lays a straight wake along the relative flow from every point of the trailing edge, eq. (U10): one row of very long rings,
    /// proportionally shorter where the flow is slower. Returns false if no point of the edge has relative flow.
    pub(super) fn lay_straight_wake(&mut self, flow: &Flow, state: &mut LatticeState) -> bool {
        let relative_m_s = |column: usize| flow.convection_m_s(&state.edge_m[column]) - state.edge_m_s[column];
        let (mut fastest_m_s, mut frame_m_s) = (0.0_f64, 0.0_f64);
        for (column, (edge_m, edge_m_s)) in state.edge_m.iter().zip(&state.edge_m_s).enumerate() {
            fastest_m_s = fastest_m_s.max(relative_m_s(column).norm());
            frame_m_s = frame_m_s.max(flow.convection_m_s(edge_m).norm() + edge_m_s.norm());
        }
        if fastest_m_s <= REST_SHARE * frame_m_s || self.options.wake_rows == 0 {
            return false;
        }
        let length_m = self.established_length_m(state);
        for (sheet, wake) in self.bound.iter().zip(&mut self.wake) {
            wake.rows = 1;
            for column in 0..=sheet.strips {
                let edge_m = state.wake_node_m[wake.node(0, column)];
                let along = relative_m_s(wake.node(0, column)) / fastest_m_s;
                state.wake_node_m[wake.node(1, column)] = edge_m + along * length_m;
            }
        }
        (state.wake_rows, state.established) = (1, true);
        true
    }

    /// Length in m of the established wake where the relative speed is highest.
    fn established_length_m(&self, state: &LatticeState) -> f64 {
        let origin = state.corner_m[0];
        let diameter_m = 2.0 * state.corner_m.iter().map(|corner| (corner - origin).norm()).fold(0.0, f64::max);
        ESTABLISHED_DIAMETERS * diameter_m
    }

    /// Lays the wake of a steady turn, eq. (U30): rows of the length of a step along the path of the air in the root frame since it left
    /// the edge, followed by a straight row.
    fn bend_wake(&mut self, flow: &Flow, step_s: f64, state: &mut LatticeState) {
        let turn_rad = flow.spin_rad_s.norm() * step_s;
        if turn_rad == 0.0 {
            return;
        }
        // the quotient is at least 0, and the conversion of large values saturates
        let rows = ((LARGEST_TURN_RAD / turn_rad) as usize).clamp(1, self.options.wake_rows);
        let (columns, path) = (self.wake_columns, AirPath::new(flow, step_s));
        for row in 0..rows {
            for column in 0..columns {
                state.wake_node_m[(row + 1) * columns + column] =
                    path.end_m(&state.wake_node_m[row * columns + column]);
            }
        }
        let length_m = self.established_length_m(state);
        let fastest_m_s = |nodes_m: &[Vector3<f64>]| {
            nodes_m.iter().map(|node_m| flow.convection_m_s(node_m).norm()).fold(0.0, f64::max)
        };
        let share = length_m / fastest_m_s(&state.wake_node_m[rows * columns..(rows + 1) * columns]);
        for column in 0..columns {
            let node_m = state.wake_node_m[rows * columns + column];
            state.wake_node_m[(rows + 1) * columns + column] = node_m + flow.convection_m_s(&node_m) * share;
        }
        self.wake.iter_mut().for_each(|wake: &mut Sheet| wake.rows = rows + 1);
        (state.wake_rows, state.turning) = (rows + 1, true);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::surface::{Profile, Surface};
    use crate::aero::test_lattices::{chord, flow, options, section};

    /// The wake of a wing in steady roll consists of straight lines, each along the relative flow at its point of the edge: wind minus the
    /// velocity of the edge, which grows along the span. Their lengths are proportional to the relative speed.
    #[test]
    fn the_wake_of_a_wing_that_rolls_goes_along_the_air_of_each_section() {
        let (wind_m_s, roll_rad_s) = (Vector3::y() * -12.0, Vector3::y() * 0.8);
        let sections = 4;
        let surface =
            Surface { sections: 0..sections, chords: vec![chord(); sections], chord_panels: 2, profile: Profile::THIN };
        let mut lattice = VortexLattice::new(vec![surface], options());
        let motion = |number: usize| {
            let still = section(Vector3::new(0.5 + 1.5 * number as f64, 0.0, 0.0), -0.05);
            SectionMotion { velocity_m_s: roll_rad_s.cross(&still.position_m), spin_rad_s: roll_rad_s, ..still }
        };
        let motions: Vec<SectionMotion> = (0..sections).map(motion).collect();
        let mut state = lattice.blank_state();
        assert!(lattice.place_at_start(&motions, &flow(wind_m_s), Some(Established::straight(0.02)), &mut state));
        let met_m_s = |number: usize| {
            let edge_m = motions[number].point_m(&chord().trailing_m);
            wind_m_s - roll_rad_s.cross(&edge_m)
        };
        let displacement_m = |column: usize| state.wake_node_m[sections + column] - state.wake_node_m[column];
        let time_s = displacement_m(sections - 1).norm() / met_m_s(sections - 1).norm();
        for column in 0..sections {
            let expected_m = met_m_s(column) * time_s;
            let off_m = (displacement_m(column) - expected_m).norm();
            assert!(off_m < 1e-12 * expected_m.norm(), "column {column}: {} for {expected_m}", displacement_m(column)); // round-off
        }
        assert!(
            (displacement_m(0).normalize() - displacement_m(3).normalize()).norm() > 0.2,
            "the sections meet different air"
        );
    }
}

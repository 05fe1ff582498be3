//! Turbulence on a grid normal to the wind, convected by the mean wind (Taylor's frozen turbulence).

use crate::aero::pieces::Pieces;

/// Velocities on a grid over time, with linear interpolation between its points; beyond the edges the values at the edge hold.
#[derive(Debug, Clone, PartialEq)]
pub struct TurbulenceBox {
    /// Number of lateral points, from starboard to port (towards increasing `y`, left when looking downwind).
    pub across: usize,
    /// Number of vertical points, from the bottom.
    pub upward: usize,
    /// Number of planes over time.
    pub planes: usize,
    /// Lateral spacing of the points in m.
    pub across_m: f64,
    /// Vertical spacing of the points in m.
    pub upward_m: f64,
    /// Time between planes in s.
    pub plane_interval_s: f64,
    /// Height of the lowest points above the ground in m.
    pub bottom_m: f64,
    /// Speed in m/s at which the planes are convected.
    pub carried_m_s: f64,
    /// Whether the planes are periodic: the first follows the last.
    pub periodic: bool,
    /// Velocities in m/s, downwind, to port and upward: plane by plane from the first, row by row from the bottom, point by point from
    /// starboard.
    pub velocity_m_s: Vec<[f32; 3]>,
}

impl TurbulenceBox {
    /// Time in s that the planes cover.
    pub fn duration_s(&self) -> f64 {
        let gaps = if self.periodic { self.planes } else { self.planes - 1 };
        gaps as f64 * self.plane_interval_s
    }

    /// Velocity in m/s, downwind, to port and upward, at a position: metres downwind of the reference point, to port, and above the ground;
    /// eq. (B20). A box that is not periodic holds its first and its last plane. `pieces`: cell of the grid, beyond which it is continued.
    pub fn at(&self, time_s: f64, [downwind_m, port_m, height_m]: [f64; 3], pieces: &mut Pieces) -> [f64; 3] {
        let plane = (time_s - downwind_m / self.carried_m_s) / self.plane_interval_s;
        let (before, after, share) = if self.periodic {
            let planes = self.planes as f64;
            let around = plane.rem_euclid(planes);
            let own = (around.floor() as usize).min(self.planes - 1);
            pieces.note_node(around);
            let first = pieces.choice(own);
            let share = around - first as f64;
            // on another cell, the place may be across the end of the box
            let turns = if first == own { 0.0 } else { (share / planes).round() };
            (first, (first + 1) % self.planes, share - planes * turns)
        } else {
            between(plane, self.planes, pieces)
        };
        let place = port_m / self.across_m + 0.5 * (self.across - 1) as f64;
        let (left, right, across) = between(place, self.across, pieces);
        let (low, high, upward) = between((height_m - self.bottom_m) / self.upward_m, self.upward, pieces);
        let mut sum = [0.0; 3];
        for (plane, a) in [(before, 1.0 - share), (after, share)] {
            for (row, b) in [(low, 1.0 - upward), (high, upward)] {
                for (point, c) in [(left, 1.0 - across), (right, across)] {
                    let weight = a * b * c;
                    let value = self.velocity_m_s[(plane * self.upward + row) * self.across + point];
                    for (sum, value) in sum.iter_mut().zip(value) {
                        *sum += weight * f64::from(value);
                    }
                }
            }
        }
        sum
    }
}

/// Indices of the points on both sides of a position on a line, and the weight of the upper one; beyond an end, the end point twice.
fn between(place: f64, points: usize, pieces: &mut Pieces) -> (usize, usize, f64) {
    let last = points - 1;
    // 0 before the first point, `points` from the last one on; a position that is no number is turned into 0 by the cast
    let own = if place < 0.0 { 0 } else { (place.floor() as usize).min(last) + 1 };
    if (0.0..=last as f64).contains(&place.round()) {
        pieces.note_node(place);
    }
    match pieces.choice(own) {
        0 => (0, 0, 0.0),
        end if end > last => (last, last, 0.0),
        upper => (upper - 1, upper, place - (upper - 1) as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::pieces::PieceList;

    fn at(grid: &TurbulenceBox, time_s: f64, downwind_m: f64, port_m: f64, height_m: f64) -> [f64; 3] {
        grid.at(time_s, [downwind_m, port_m, height_m], &mut Pieces::Free)
    }

    /// Velocities that are linear in time, lateral position and height, so that interpolation must be exact.
    fn linear(periodic: bool) -> TurbulenceBox {
        let (across, upward, planes) = (3, 4, 5);
        let mut velocity_m_s = Vec::new();
        for plane in 0..planes {
            for row in 0..upward {
                for point in 0..across {
                    let (t, z, y) = (plane as f32 * 0.5, 10.0 + row as f32 * 4.0, (point as f32 - 1.0) * 6.0);
                    velocity_m_s.push([t + 2.0 * z - y, 3.0 * y, z - t]);
                }
            }
        }
        TurbulenceBox {
            across,
            upward,
            planes,
            across_m: 6.0,
            upward_m: 4.0,
            plane_interval_s: 0.5,
            bottom_m: 10.0,
            carried_m_s: 8.0,
            periodic,
            velocity_m_s,
        }
    }

    #[test]
    fn velocities_between_the_points_are_straight_lines() {
        for periodic in [false, true] {
            let grid = linear(periodic);
            let (time_s, downwind_m, port_m, height_m) = (1.7, 4.0, -2.5, 17.3);
            let t = time_s - downwind_m / 8.0;
            let [u, v, w] = at(&grid, time_s, downwind_m, port_m, height_m);
            approx::assert_relative_eq!(u, t + 2.0 * height_m - port_m, max_relative = 1e-6);
            approx::assert_relative_eq!(v, 3.0 * port_m, max_relative = 1e-6);
            approx::assert_relative_eq!(w, height_m - t, max_relative = 1e-6);
        }
    }

    #[test]
    fn edges_hold_and_a_periodic_box_goes_round() {
        let grid = linear(false);
        assert_eq!(grid.duration_s(), 2.0);
        assert_eq!(at(&grid, 1.0, 0.0, 99.0, 99.0), at(&grid, 1.0, 0.0, 6.0, 22.0));
        assert_eq!(at(&grid, -1.0, 0.0, 0.0, 15.0), at(&grid, 0.0, 0.0, 0.0, 15.0));
        assert_eq!(at(&grid, 9.0, 0.0, 0.0, 15.0), at(&grid, 2.0, 0.0, 0.0, 15.0));
        let round = linear(true);
        assert_eq!(round.duration_s(), 2.5);
        assert_eq!(
            at(&round, 0.7 + 2.5, 0.0, 1.0, 15.0).map(|x| (1e9 * x).round()),
            at(&round, 0.7, 0.0, 1.0, 15.0).map(|x| (1e9 * x).round())
        );
        let [last, _, _] = at(&round, 2.25, 0.0, 0.0, 10.0);
        approx::assert_relative_eq!(last, 0.5 * (2.0 + 20.0 + 20.0), max_relative = 1e-6);
    }

    /// A known cell is continued beyond its sides and across the end of a periodic box; an end that holds its value keeps it.
    #[test]
    fn cells_are_continued() {
        for periodic in [false, true] {
            let grid = linear(periodic);
            let mut list = PieceList::default();
            let inside = |pieces: &mut Pieces| grid.at(1.9, [0.0, 5.5, 21.5], pieces);
            assert_eq!(inside(&mut Pieces::Record(&mut list)), inside(&mut Pieces::Free));
            assert_eq!(inside(&mut Pieces::keep(&list)), inside(&mut Pieces::Free));
            let [u, v, w] = grid.at(2.1, [0.0, 7.0, 23.0], &mut Pieces::keep(&list));
            approx::assert_relative_eq!(u, 2.1 + 2.0 * 23.0 - 7.0, max_relative = 1e-6);
            approx::assert_relative_eq!(v, 21.0, max_relative = 1e-6);
            approx::assert_relative_eq!(w, 23.0 - 2.1, max_relative = 1e-6);
        }
        let grid = linear(true);
        let mut list = PieceList::default();
        // the last cell, between the last plane and the first
        let last = grid.at(2.45, [0.0, 0.0, 10.0], &mut Pieces::Record(&mut list));
        let beyond = grid.at(2.55, [0.0, 0.0, 10.0], &mut Pieces::keep(&list));
        approx::assert_relative_eq!(beyond[0] - last[0], -2.0 * 0.1 / 0.5, max_relative = 1e-5);
        let grid = linear(false);
        let mut list = PieceList::default();
        let below = grid.at(-0.1, [0.0, 0.0, 9.0], &mut Pieces::Record(&mut list));
        assert_eq!(grid.at(0.3, [0.0, 0.0, 11.0], &mut Pieces::keep(&list)), below);
    }
}

//! Slender bodies in code: equivalents of the tables `[aerodynamics.<name>]` with `model = "slender_body"`.

use crate::aero::slender::SlenderBodyOptions;
use crate::machine::Body;
use crate::machine::builder::place::air_place;
use crate::machine::fault::{Checker, Range, array_text};
use crate::machine::units::shortest;
use crate::machine::validate::slender::MAXIMUM_SEGMENTS;

/// Default number of parts along a slender body.
const SEGMENTS: usize = 8;

/// Settings of a slender body, for [`Air::slender_body`](crate::machine::Air::slender_body).
#[derive(Debug, Clone, PartialEq)]
pub struct SlenderBodySettings {
    /// Name of the body that carries it, which has no lifting surface.
    pub body: String,
    /// Rows of position along the body's x axis and radius, both in m, with ascending positions; linear between rows. A rigid body may have
    /// any positions, relative to its frame; others have positions from 0 to their length.
    pub radius_m: Vec<[f64; 2]>,
    /// Number of parts along the body; `None`: 8, or one for each interval of `radius_m` if these are more.
    pub segments: Option<usize>,
    /// Drag coefficient in the flow across the body, referred to its diameter.
    pub cross_flow_drag_coefficient: f64,
    /// Drag coefficient in the flow along the body, referred to its largest cross-section.
    pub axial_drag_coefficient: f64,
}

impl SlenderBodySettings {
    /// A slender body on the named body, without drag.
    pub fn on(body: impl Into<String>, radius_m: Vec<[f64; 2]>) -> Self {
        Self {
            body: body.into(),
            radius_m,
            segments: None,
            cross_flow_drag_coefficient: 0.0,
            axial_drag_coefficient: 0.0,
        }
    }

    /// Options of the aerodynamic model; `part`: its name, empty for the single model of a machine. `None` after an error.
    pub(super) fn options(
        &self,
        part: &str,
        apparent_mass: bool,
        bodies: &[Body],
        checker: &mut Checker,
    ) -> Option<SlenderBodyOptions> {
        let Some(body) = bodies.iter().position(|body| body.name == self.body) else {
            let known = bodies.iter().map(|body| body.name.as_str());
            checker.unknown_name(&air_place(part, "body"), &self.body, "a body", known);
            return None;
        };
        let rows = &self.radius_m;
        let ascending = rows.len() >= 2 && rows.windows(2).all(|pair| pair[0][0] < pair[1][0]);
        let fat = rows.iter().any(|row| row[1] > 0.0);
        let sound = rows.iter().all(|[at_m, radius_m]| at_m.is_finite() && *radius_m >= 0.0 && radius_m.is_finite());
        if !(ascending && fat && sound) {
            let allowed =
                "at least 2 rows [position in m, radius in m] with ascending positions and radii >= 0, not all 0";
            let found: Vec<f64> = rows.iter().flatten().copied().collect();
            checker.refuse(&air_place(part, "radius_m"), array_text(&found), allowed);
            return None;
        }
        let parts = rows.len() - 1;
        let segments = self.segments.unwrap_or_else(|| SEGMENTS.max(parts));
        if !checker.count(&air_place(part, "segments"), segments, 1, MAXIMUM_SEGMENTS) {
            return None;
        }
        if segments < parts {
            let allowed = format!("at least {parts}, the number of intervals of radius_m");
            checker.refuse(&air_place(part, "segments"), segments.to_string(), allowed);
            return None;
        }
        let drags = checker.number(
            &air_place(part, "cross_flow_drag_coefficient"),
            self.cross_flow_drag_coefficient,
            Range::AtLeast(0.0),
        ) & checker.number(
            &air_place(part, "axial_drag_coefficient"),
            self.axial_drag_coefficient,
            Range::AtLeast(0.0),
        );
        let (positions_m, radii_m) = divided(rows, segments);
        let rigid = bodies[body].is_rigid();
        let length_m = bodies[body].length_m;
        let [from_m, to_m] = [rows[0][0], rows[parts][0]];
        if !rigid && (from_m < 0.0 || to_m > length_m * (1.0 + 1e-12)) {
            let found = format!("positions from {} to {} m", shortest(from_m), shortest(to_m));
            let allowed = format!("positions from 0 to {} m, the length of the body", shortest(length_m));
            checker.refuse_state(&air_place(part, "radius_m"), found, allowed);
            return None;
        }
        drags.then_some(SlenderBodyOptions {
            body,
            rigid,
            positions_m,
            radii_m,
            apparent_mass,
            cross_flow_drag_coefficient: self.cross_flow_drag_coefficient,
            axial_drag_coefficient: self.axial_drag_coefficient,
        })
    }
}

/// Positions and radii of `segments` parts: the intervals of the rows, each divided evenly, the longest parts first.
fn divided(rows: &[[f64; 2]], segments: usize) -> (Vec<f64>, Vec<f64>) {
    let mut counts = vec![1; rows.len() - 1];
    let part_m = |interval: usize, count: usize| (rows[interval + 1][0] - rows[interval][0]) / count as f64;
    for _ in counts.len()..segments {
        let longest = (0..counts.len()).fold(0, |longest, other| {
            if part_m(other, counts[other]) > part_m(longest, counts[longest]) { other } else { longest }
        });
        counts[longest] += 1;
    }
    let mut sections = vec![rows[0]];
    for (pair, count) in rows.windows(2).zip(counts) {
        sections.extend((1..count).map(|part| {
            let share = part as f64 / count as f64;
            [pair[0][0] + (pair[1][0] - pair[0][0]) * share, pair[0][1] + (pair[1][1] - pair[0][1]) * share]
        }));
        sections.push(pair[1]);
    }
    sections.into_iter().map(|[position_m, radius_m]| (position_m, radius_m)).unzip()
}

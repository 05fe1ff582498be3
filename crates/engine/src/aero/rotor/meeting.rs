//! Evaluation of the inflow of the sections of a rotor and of the state of its disc, before induction.

use crate::aero::flow::Flow;
use crate::aero::pieces::{Holding, PieceList, Pieces};
use crate::aero::rotor::bem::Rotor;
use crate::aero::rotor::disc::{Cut, Disc, NO_CUT, downwind};
use crate::aero::rotor::loads::RotorLoads;
use crate::aero::rotor::options::RotorOptions;
use crate::aero::rotor::pieces::RotorPieces;
use crate::aero::rotor::skew::Skew;
use crate::aero::rotor::steady::induction_share_on;
use crate::load::SectionMotion;
use nalgebra::Vector3;

/// Ratio of the wind along the shaft to the relative speed of the tips below which the coefficients are undefined.
const LEAST_WIND: f64 = 0.01;

impl Rotor {
    /// Evaluates the inflow of all sections into the scratch, and the disc.
    pub(super) fn meet(&mut self, motions: &[SectionMotion], flow: &Flow, holding: &mut Holding<RotorPieces>) -> Disc {
        let hub = &motions[self.sections.len()];
        let normal = hub.rotation * self.options.shaft_axis;
        if let Holding::Record(pieces) = holding {
            pieces.winds = vec![PieceList::default(); self.sections.len()];
        }
        let mut mean_m_s = Vector3::zeros();
        for (index, motion) in motions[..self.sections.len()].iter().enumerate() {
            let wind = &mut holding.pieces(|pieces| &mut pieces.winds[index]);
            let (cut, met_m_s) = self.cut(index, motion, (hub, &normal), flow, wind);
            mean_m_s += met_m_s;
            self.cuts[index] = cut;
        }
        let met_m_s = mean_m_s / self.sections.len() as f64;
        let radius_m = self.rotor_radius_m();
        let mut pieces = match holding {
            Holding::Free => Pieces::Free,
            Holding::Record(pieces) => {
                pieces.disc = PieceList::default();
                Pieces::Record(&mut pieces.disc)
            }
            Holding::Keep(pieces) => Pieces::keep(&pieces.disc),
        };
        self.disc((hub, &normal), (&met_m_s, radius_m), flow, &mut pieces)
    }

    /// Geometry and inflow of a section, and the velocity in m/s of the air without the influence of the tower relative to it.
    pub(super) fn cut(
        &self,
        index: usize,
        motion: &SectionMotion,
        (hub, normal): (&SectionMotion, &Vector3<f64>),
        flow: &Flow,
        pieces: &mut Pieces,
    ) -> (Cut, Vector3<f64>) {
        let arm_m = motion.rotation * self.quarter_m(index);
        let point_m = motion.position_m + arm_m;
        let air_m_s = undisturbed_m_s(&self.options, flow, &point_m, pieces);
        let tower = self.options.features.tower.as_ref();
        let added_m_s = tower.map_or_else(Vector3::zeros, |tower| tower.added_m_s(&point_m, &air_m_s));
        let from_apex_m = point_m - hub.position_m;
        let radial_m = from_apex_m - normal * from_apex_m.dot(normal);
        let velocity_m_s = motion.velocity_m_s + motion.spin_rad_s.cross(&arm_m);
        let relative_m_s = air_m_s + added_m_s - velocity_m_s;
        let wind_m_s = (air_m_s - hub.velocity_m_s).dot(normal);
        (Cut { arm_m, relative_m_s, wind_m_s, radial_m, from_apex_m, ..NO_CUT }, air_m_s - velocity_m_s)
    }

    /// The disc, from the mean velocity of the air relative to the sections and the radius of the rotor.
    pub(super) fn disc(
        &self,
        (hub, normal): (&SectionMotion, &Vector3<f64>),
        (met_m_s, radius_m): (&Vector3<f64>, f64),
        flow: &Flow,
        pieces: &mut Pieces,
    ) -> Disc {
        let turn = if self.options.features.clockwise { 1.0 } else { -1.0 };
        let speed_rad_s = turn * (hub.spin_rad_s + flow.spin_rad_s).dot(normal);
        let tip_m_s = (speed_rad_s * radius_m).abs();
        // in still air the mean of the section velocities vanishes only to round-off
        let wind_m_s = Some(met_m_s.dot(normal)).filter(|wind| wind.abs() > 1e-12 * tip_m_s).unwrap_or(0.0);
        let hovers = pieces.holds(wind_m_s == 0.0 && tip_m_s > 0.0);
        let share = if hovers { 1.0 } else { induction_share_on(tip_m_s / wind_m_s.abs(), pieces) };
        let has_wind = pieces.holds(wind_m_s.abs() > LEAST_WIND * tip_m_s.hypot(met_m_s.norm()));
        let tip_speed_ratio = if has_wind { tip_m_s / wind_m_s.abs() } else { 0.0 };
        Disc {
            normal: *normal,
            turn,
            share: if share.is_nan() { 0.0 } else { share },
            radius_m,
            hub_rad_s: hub.spin_rad_s,
            shaft_spin_rad_s: match self.options.features.aerodyn_compatible {
                true => Vector3::zeros(),
                false => normal * (turn * speed_rad_s),
            },
            skew: self.options.features.skewed_wake.then(|| Skew::of(met_m_s, normal)),
            has_wind,
            loads: RotorLoads { speed_rad_s, wind_m_s, tip_speed_ratio, ..RotorLoads::default() },
        }
    }

    /// Mean over the blades of the current radius of their outermost sections, in m. Their maximum would not be differentiable for equal
    /// blades.
    pub(super) fn rotor_radius_m(&self) -> f64 {
        let of_blade = |range: &std::ops::Range<usize>| {
            self.cuts[range.clone()].iter().map(|cut| cut.radial_m.norm()).fold(0.0, f64::max)
        };
        self.blades.iter().map(of_blade).sum::<f64>() / self.blades.len() as f64
    }

    /// Direction ahead of a blade in the disc, from its axis at its root, and the normal of its root to both; `None` for a blade along the
    /// shaft. In-plane bending does not rotate the annuli.
    pub(super) fn directions(disc: &Disc, root: &Vector3<f64>) -> Option<[Vector3<f64>; 2]> {
        let along = root - disc.normal * root.dot(&disc.normal);
        let along = along.try_normalize(1e-9)?;
        let ahead = disc.normal.cross(&along) * disc.turn;
        Some([ahead, downwind(root.cross(&ahead), &disc.normal)])
    }
}

/// Velocity of the air, without the influence of rotor and tower, relative to the root frame, in m/s.
fn undisturbed_m_s(options: &RotorOptions, flow: &Flow, point_m: &Vector3<f64>, pieces: &mut Pieces) -> Vector3<f64> {
    let plain_m_s = flow.velocity_m_s(point_m);
    match &options.features.field {
        Some(field) => plain_m_s - flow.wind_m_s + field.velocity_m_s(flow.time_s, point_m, &flow.wind_m_s, pieces),
        None => plain_m_s,
    }
}

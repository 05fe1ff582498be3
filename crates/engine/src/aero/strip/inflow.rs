//! Inflow of a strip at one instant, and the loads of its section, NOTATION eqs. (W2), (W4), (W7) and (W9).

use crate::aero::flow::Flow;
use crate::aero::pieces::Pieces;
use crate::aero::strip::StripHistory;
use crate::aero::strip::flap::{FlapInflow, StripFlap};
use crate::aero::strip::indicial::Lag;
use crate::aero::strip::section::{Cut, Strip, bias};
use crate::aero::surface::Profile;
use crate::load::SectionMotion;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Loads of a section per span and the point where they act.
pub(super) struct InternalLoads {
    pub(super) circulation_m2_s: f64,
    /// Force per span in N/m.
    pub(super) force_n_m: Vector3<f64>,
    /// Fraction of the chord at which the force acts.
    pub(super) fraction: f64,
    /// Nose-up moment per span in N.
    pub(super) moment_n: f64,
}

/// Inflow of a strip at one instant, along and normal to the zero-lift line: eqs. (W2) and (W4).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Inflow {
    pub(super) cut: Cut,
    /// Unit vector along the zero-lift line, towards the trailing edge.
    pub(super) aft: Vector3<f64>,
    /// Unit vector normal to it, upward.
    pub(super) up: Vector3<f64>,
    /// Gust velocity at the upstream edge in m/s.
    pub(super) gust_m_s: Vector3<f64>,
    /// Velocity along the zero-lift line in m/s, positive from the leading edge.
    pub(super) along_m_s: f64,
    /// Relative speed in the plane of the section at half chord in m/s.
    pub(super) speed_m_s: f64,
    /// Flow direction `γ`, from 1 (leading edge upstream) to −1.
    pub(super) bias: f64,
    /// Upward velocity at the control point, without gusts but with the increment of the control surface, in m/s.
    pub(super) downwash_m_s: f64,
    /// Upward velocity due to the gust and the lifting line in m/s.
    pub(super) gust_downwash_m_s: f64,
    /// Upward velocity, without gusts, at the trailing edge minus that at the leading edge in m/s.
    pub(super) difference_m_s: f64,
    /// The strip's control surface, if any.
    pub(super) flap: Option<FlapInflow>,
    /// Ratio of pressures to those of incompressible air, eq. (U22).
    pub(super) compression: f64,
}

impl Inflow {
    pub(super) fn of(
        strip: &Strip,
        profile: &Profile,
        flap: Option<StripFlap>,
        motions: &[SectionMotion],
        flow: &Flow,
    ) -> Self {
        Self::with_gusts((strip, profile, flap), motions, flow, |place_m| flow.gust_m_s(place_m))
    }

    /// Evaluates the inflow with the gust velocity of the given function instead of the flow's gusts.
    pub(super) fn with_gusts(
        (strip, profile, flap): (&Strip, &Profile, Option<StripFlap>),
        motions: &[SectionMotion],
        flow: &Flow,
        gust_at_m_s: impl FnOnce(&Vector3<f64>) -> Vector3<f64>,
    ) -> Self {
        let cut = strip.cut(motions, flow);
        let (sine, cosine) = profile.zero_lift_angle_rad.sin_cos();
        let aft = cut.aft * cosine + cut.up * sine;
        let up = cut.up * cosine - cut.aft * sine;
        let calm_m_s = cut.air_m_s(0.5);
        // spanwise flow over a twisted strip has a normal component that grows along the chord, starting at the quarter chord
        let turning_m_s = -calm_m_s.dot(&cut.along()) * cut.twist(&up);
        let difference_m_s = (cut.trailing_air_m_s - cut.leading_air_m_s).dot(&up) + turning_m_s;
        let calm_bias = bias(calm_m_s.dot(&aft), calm_m_s.dot(&up), difference_m_s);
        let gust_m_s = gust_at_m_s(&cut.point_m(0.5 - 0.5 * calm_bias));
        let middle_m_s = calm_m_s + gust_m_s;
        let (along_m_s, across_m_s) = (middle_m_s.dot(&aft), middle_m_s.dot(&up));
        let bias = bias(along_m_s, across_m_s, difference_m_s);
        let flap = flap.map(|flap| {
            let flap = flap.in_cut(strip, &cut, motions);
            FlapInflow { downwash_m_s: flap.circulating_m_s(cut.chord_m, along_m_s, bias), ..flap }
        });
        let own_m_s = flap.map_or(0.0, |flap| flap.downwash_m_s);
        Self {
            aft,
            up,
            gust_m_s,
            along_m_s,
            speed_m_s: along_m_s.hypot(across_m_s),
            bias,
            downwash_m_s: cut.air_m_s(0.5 + 0.25 * bias).dot(&up) + turning_m_s * (0.25 + 0.25 * bias) + own_m_s,
            gust_downwash_m_s: gust_m_s.dot(&up),
            difference_m_s,
            flap,
            compression: compression(along_m_s.hypot(across_m_s) / strip.speed_of_sound_m_s),
            cut,
        }
    }

    /// State for the next step.
    pub(super) fn history(&self, motion: Lag, gust: Lag) -> StripHistory {
        StripHistory {
            motion,
            gust,
            speed_m_s: self.speed_m_s,
            middle_m_s: self.cut.air_m_s(0.5).dot(&self.cut.up),
            difference_m_s: (self.cut.trailing_air_m_s - self.cut.leading_air_m_s).dot(&self.cut.up),
            up: self.cut.up,
            circulation_m2_s: 0.0,
            flap_rate_rad_s: self.flap.map_or(0.0, |flap| flap.rate_rad_s),
        }
    }

    /// Loads per span for the effective downwash: eqs. (W7) and (W9).
    pub(super) fn section_loads(
        &self,
        strip: &Strip,
        profile: &Profile,
        suction: bool,
        effective_m_s: f64,
        density_kg_m3: f64,
        pieces: &mut Pieces,
    ) -> InternalLoads {
        let chord_m = self.cut.chord_m;
        let curvature_n = -PI / 16.0
            * density_kg_m3
            * chord_m.powi(2)
            * self.along_m_s
            * self.bias
            * self.difference_m_s
            * self.compression;
        let (circulation_m2_s, force_n_m, fraction, moment_n) = match &profile.polar {
            None => {
                let half_slope_m = 0.5 * chord_m * strip.lift_slope_1_rad * self.compression;
                let circulation_m2_s = half_slope_m * effective_m_s;
                let edge_m_s = effective_m_s - self.bias * (0.25 * self.difference_m_s + self.flap_edge_m_s());
                let suction_n_m = if suction { half_slope_m * edge_m_s.powi(2) * self.bias } else { 0.0 };
                let fraction = 0.5 - 0.25 * self.bias;
                let force_n_m = self.up * (self.along_m_s.abs() * circulation_m2_s) - self.aft * suction_n_m;
                let moment_n = 0.5 * (chord_m * self.along_m_s).powi(2) * profile.moment_coefficient * self.compression;
                (circulation_m2_s, force_n_m + self.drag_m3_s2(fraction, profile.drag_coefficient), fraction, moment_n)
            }
            Some(polar) => {
                let angle_rad = pieces.near(effective_m_s.atan2(self.along_m_s));
                let row = pieces.row(polar, profile.zero_lift_angle_rad + angle_rad);
                let (speed_m_s, lift_m3_s2) = self.lift_m3_s2(0.25, row.lift);
                let moment_n = 0.5 * (chord_m * speed_m_s).powi(2) * row.moment;
                (0.5 * chord_m * speed_m_s * row.lift, lift_m3_s2 + self.drag_m3_s2(0.25, row.drag), 0.25, moment_n)
            }
        };
        InternalLoads {
            circulation_m2_s,
            force_n_m: force_n_m * density_kg_m3,
            fraction,
            moment_n: moment_n * density_kg_m3 + curvature_n,
        }
    }

    /// Relative velocity in the plane of the section at a fraction of the chord: components along and normal to the zero-lift line.
    pub(super) fn plane_m_s(&self, fraction: f64) -> (f64, f64) {
        let air_m_s = self.cut.air_m_s(fraction) + self.gust_m_s;
        (air_m_s.dot(&self.aft), air_m_s.dot(&self.up))
    }

    /// Relative speed, and lift per span and density for a lift coefficient, normal to the relative velocity.
    pub(super) fn lift_m3_s2(&self, fraction: f64, coefficient: f64) -> (f64, Vector3<f64>) {
        let (along_m_s, up_m_s) = self.plane_m_s(fraction);
        let speed_m_s = along_m_s.hypot(up_m_s);
        let across_m_s = self.up * along_m_s - self.aft * up_m_s;
        (speed_m_s, across_m_s * (0.5 * self.cut.chord_m * coefficient * speed_m_s))
    }

    /// Drag per span and density for a drag coefficient, along the relative velocity.
    pub(super) fn drag_m3_s2(&self, fraction: f64, coefficient: f64) -> Vector3<f64> {
        let (along_m_s, up_m_s) = self.plane_m_s(fraction);
        let air_m_s = self.aft * along_m_s + self.up * up_m_s;
        air_m_s * (0.5 * self.cut.chord_m * coefficient * air_m_s.norm())
    }
}

/// Prandtl-Glauert factor on pressures at a Mach number, eq. (U22); kept finite from Mach 1 on, which [`Strips::validity`](super::Strips::validity)
/// reports.
fn compression(mach: f64) -> f64 {
    1.0 / (1.0 - mach * mach).max(1e-6).sqrt()
}

//! Control surfaces on strips: increments of lift, moment and hinge moment by thin-aerofoil theory, quasi-steady and due to the rates of
//! the control surface, NOTATION eqs. (U15) to (U19).
//!
//! The circulatory part is added to the downwash that determines the lift, with its lag; the rest has no lag.

use crate::aero::flap::{Deflection, Flap};
use crate::aero::strip::section::{Cut, Strip};
use crate::aero::strip::{Inflow, Strips};
use crate::load::{SectionMotion, Wrench};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::ops::Range;

/// Theodorsen's constants of a hinge (NACA Report 496, pages 5 and 6), referred to half chord: eq. (U15).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hinge {
    /// Hinge position from the leading edge as a fraction of the chord.
    pub fraction: f64,
    /// Hinge position aft of half chord in semi-chords.
    pub c: f64,
    /// `√(1 − c²)`.
    pub sine: f64,
    /// `arccos c`.
    pub arc_rad: f64,
    /// `T₁`.
    pub t1: f64,
    /// `T₃`.
    pub t3: f64,
    /// `T₄`.
    pub t4: f64,
    /// `T₅`.
    pub t5: f64,
    /// `T₇`.
    pub t7: f64,
    /// `T₈`.
    pub t8: f64,
    /// `T₉` referred to half chord.
    pub t9: f64,
    /// `T₁₀`.
    pub t10: f64,
    /// `T₁₁`.
    pub t11: f64,
    /// `T₁₂`.
    pub t12: f64,
}

impl Hinge {
    /// Constants for a hinge at a fraction of the chord, between 0 and 1.
    pub fn at(fraction: f64) -> Self {
        let c = 2.0 * fraction - 1.0;
        let (sine, arc) = ((1.0 - c * c).sqrt(), c.acos());
        Self {
            fraction,
            c,
            sine,
            arc_rad: arc,
            t1: -sine * (2.0 + c * c) / 3.0 + c * arc,
            t3: -(0.125 + c * c) * arc * arc + 0.25 * c * sine * arc * (7.0 + 2.0 * c * c)
                - 0.125 * sine * sine * (5.0 * c * c + 4.0),
            t4: -arc + c * sine,
            t5: -sine * sine - arc * arc + 2.0 * c * sine * arc,
            t7: -(0.125 + c * c) * arc + 0.125 * c * sine * (7.0 + 2.0 * c * c),
            t8: -sine * (2.0 * c * c + 1.0) / 3.0 + c * arc,
            t9: sine.powi(3) / 6.0,
            t10: sine + arc,
            t11: arc * (1.0 - 2.0 * c) + sine * (2.0 - c),
            t12: sine * (2.0 + c) - arc * (2.0 * c + 1.0),
        }
    }
}

/// Control surfaces of the strips, with their current deflections.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Controls {
    /// Control surfaces.
    pub flaps: Vec<Flap>,
    /// Constants of the hinges.
    hinges: Vec<Hinge>,
    /// Deflection angles and rates.
    deflections: Vec<Deflection>,
    /// Index of the control surface of each strip; empty without control surfaces.
    of_strip: Vec<Option<usize>>,
}

impl Controls {
    /// The control surface of a strip.
    pub fn on(&self, strip: usize) -> Option<StripFlap<'_>> {
        let flap = (*self.of_strip.get(strip)?)?;
        let (hinge, deflection) = (&self.hinges[flap], self.deflections[flap]);
        Some(StripFlap { hinge, flap, downward: self.flaps[flap].downward, deflection })
    }
}

impl Strips {
    /// Adds control surfaces to the strips, with zero deflection and rate; to be called before any state is made.
    pub fn add_flaps(&mut self, flaps: &[Flap]) {
        let mut of_strip = vec![None; self.strips.len()];
        for (index, flap) in flaps.iter().enumerate() {
            of_strip[self.first[flap.surface]..][flap.strips.clone()].fill(Some(index));
        }
        self.controls = Controls {
            hinges: flaps.iter().map(|flap| Hinge::at(flap.hinge_fraction)).collect(),
            deflections: vec![Deflection::default(); flaps.len()],
            of_strip: if flaps.is_empty() { Vec::new() } else { of_strip },
            flaps: flaps.to_vec(),
        };
    }

    /// Number of control surfaces.
    pub fn flap_count(&self) -> usize {
        self.controls.flaps.len()
    }

    /// Range of the strips of a control surface among all strips.
    pub(super) fn flap_strips(&self, flap: usize) -> Range<usize> {
        let Flap { surface, strips, .. } = &self.controls.flaps[flap];
        self.first[*surface] + strips.start..self.first[*surface] + strips.end
    }

    /// Sets the deflections of the control surfaces for the instant of [`Strips::start`] and [`Strips::solve`].
    pub fn deflect(&mut self, deflections: &[Deflection]) {
        self.controls.deflections.copy_from_slice(deflections);
    }
}

/// A control surface in the flow of its strip; the angle is measured in the section's cut, positive against the normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FlapInflow {
    /// Constants of the hinge.
    pub hinge: Hinge,
    /// Index of the control surface.
    pub flap: usize,
    /// Deflection angle in the cut in rad.
    pub angle_rad: f64,
    /// Deflection rate in the cut in rad/s.
    pub rate_rad_s: f64,
    /// Ratio of the angle in the cut to the deflection: cosine between the hinge and the quarter-chord line, with the sign of
    /// [`crate::aero::flap::Flap::downward`].
    pub share: f64,
    /// Increment of the downwash in m/s, eq. (U16).
    pub downwash_m_s: f64,
}

/// Increments of the loads of a section due to its control surface, per span.
struct FlapLoads {
    /// Force at half chord, normal to the zero-lift line, in N/m.
    middle_n_m: f64,
    /// Nose-up moment in N.
    moment_n: f64,
    /// Force at the hinge in N/m that makes the force of the control surface normal to it.
    tilt_n_m: Vector3<f64>,
    /// Hinge moment per span, positive in the direction of the angle in the cut, in N.
    hinge_n: f64,
}

/// A control surface of a strip with its current deflection.
#[derive(Debug, Clone, Copy)]
pub(super) struct StripFlap<'a> {
    /// Constants of the hinge.
    pub hinge: &'a Hinge,
    /// Index of the control surface.
    pub flap: usize,
    /// Sign of the deflection in the cut.
    pub downward: f64,
    /// Deflection angle and rate.
    pub deflection: Deflection,
}

impl StripFlap<'_> {
    /// Inflow of the control surface in the cut of the strip, with its own downwash still zero.
    pub fn in_cut(&self, strip: &Strip, cut: &Cut, motions: &[SectionMotion]) -> FlapInflow {
        let hinge_m = |end: usize| {
            let [leading_m, trailing_m] = cut.arms_m[end];
            motions[strip.sections[end]].position_m + leading_m + (trailing_m - leading_m) * self.hinge.fraction
        };
        let along_m = hinge_m(1) - hinge_m(0);
        let share = self.downward * cut.up.cross(&cut.aft).dot(&along_m) / along_m.norm();
        FlapInflow {
            hinge: *self.hinge,
            flap: self.flap,
            angle_rad: share * self.deflection.angle_rad,
            rate_rad_s: share * self.deflection.rate_rad_s,
            share,
            downwash_m_s: 0.0,
        }
    }
}

impl FlapInflow {
    /// Downwash in m/s for the circulation due to the control surface, eq. (U16): from the Kutta condition at the trailing edge, or at the
    /// leading edge in reversed flow.
    pub fn circulating_m_s(&self, chord_m: f64, along_m_s: f64, bias: f64) -> f64 {
        let Hinge { sine, arc_rad, t10, t11, t12, .. } = self.hinge;
        let (turning_m_s, rising_m_s) = (along_m_s * self.angle_rad, 0.25 * chord_m * self.rate_rad_s);
        let from_front_m_s = t10 * turning_m_s + t11 * rising_m_s;
        let from_behind_m_s = (arc_rad - sine) * turning_m_s + t12 * rising_m_s;
        (0.5 * (1.0 + bias) * from_front_m_s + 0.5 * (1.0 - bias) * from_behind_m_s) / PI
    }

    /// Reduction in m/s of the leading-edge singularity by the control surface, in addition to the effect of its downwash, eq. (U18).
    pub fn edge_m_s(&self, chord_m: f64, along_m_s: f64) -> f64 {
        let Hinge { sine, t4, .. } = self.hinge;
        (sine * along_m_s * self.angle_rad - 0.25 * t4 * chord_m * self.rate_rad_s) / PI
    }
}

impl Inflow {
    /// Reduction in m/s of the singularity at the upstream edge by the control surface, in addition to the effect of its downwash.
    pub(super) fn flap_edge_m_s(&self) -> f64 {
        self.flap.map_or(0.0, |flap| flap.edge_m_s(self.cut.chord_m, self.along_m_s))
    }

    /// Loads of the control surface per span, in addition to those due to its downwash, eqs. (U17) to (U19).
    ///
    /// `plate`: the profile is a flat plate, whose pressure forces are normal to each of its two parts; the drag of polars includes this
    /// effect.
    fn flap_loads(&self, flap: &FlapInflow, circulation_m2_s: f64, density_kg_m3: f64, plate: bool) -> FlapLoads {
        let Hinge { c, sine, arc_rad, t1, t4, t5, t8, t9, t12, t11, .. } = flap.hinge;
        let b_m = 0.5 * self.cut.chord_m;
        let (v_m_s, bias, difference_m_s) = (self.along_m_s, self.bias, self.difference_m_s);
        let (angle_rad, rate_rad_s) = (flap.angle_rad, flap.rate_rad_s);
        let blend = |front: f64, behind: f64| 0.5 * (1.0 + bias) * front + 0.5 * (1.0 - bias) * behind;
        // downwash of a plate with this (lagged) circulation
        let lagged_m_s = circulation_m2_s / (PI * self.cut.chord_m);
        let own_m_s = flap.downwash_m_s;
        // terms without lag, for compressible air; the lagged ones contain the factor in their circulation
        let compression = self.compression;
        let couple_m2_s2 = compression
            * (PI * v_m_s * own_m_s + t4 * v_m_s.powi(2) * angle_rad + (t1 - t8 - c * t4) * v_m_s * b_m * rate_rad_s);
        let hinge_m2_s2 = v_m_s.abs() * lagged_m_s * blend(t12, t11)
            + compression
                * (t5 / PI * v_m_s.powi(2) * angle_rad
                    - v_m_s * t4 * (0.25 * bias * difference_m_s + own_m_s)
                    - t9 * v_m_s * difference_m_s);
        // force of the control surface normal to the chord: integral of its pressure without accelerations
        let own_m2_s2 = v_m_s.abs() * lagged_m_s * blend(arc_rad - sine, arc_rad + sine)
            + compression
                * (v_m_s * sine * (0.25 * (bias - c) * difference_m_s + own_m_s)
                    - v_m_s * sine / PI
                        * (v_m_s * angle_rad * arc_rad + 0.5 * b_m * rate_rad_s * (sine - arc_rad * c)));
        let own_n_m = if plate { 2.0 * density_kg_m3 * b_m * own_m2_s2 } else { 0.0 };
        FlapLoads {
            middle_n_m: -density_kg_m3 * b_m.powi(2) * t4 * v_m_s * rate_rad_s,
            moment_n: -density_kg_m3 * b_m.powi(2) * couple_m2_s2,
            tilt_n_m: (self.aft * angle_rad.sin() + self.up * (angle_rad.cos() - 1.0)) * own_n_m,
            hinge_n: -density_kg_m3 * b_m.powi(2) * hinge_m2_s2,
        }
    }

    /// Adds the loads of the strip's control surface, in addition to those due to its downwash; returns its hinge moment in N·m.
    pub(super) fn add_flap(
        &self,
        strip: &Strip,
        circulation_m2_s: f64,
        density_kg_m3: f64,
        plate: bool,
        loads: &mut [Wrench],
    ) -> f64 {
        let Some(flap) = &self.flap else { return 0.0 };
        let span_m = self.cut.span_m;
        let own = self.flap_loads(flap, circulation_m2_s, density_kg_m3, plate);
        strip.add_force(loads, &self.cut, 0.5, &(self.up * (own.middle_n_m * span_m)));
        strip.add_force(loads, &self.cut, flap.hinge.fraction, &(own.tilt_n_m * span_m));
        strip.add_moment(loads, &self.cut, own.moment_n * span_m);
        flap.share * own.hinge_n * span_m
    }

    /// Adds the apparent-mass loads due to the acceleration of the control surface in the cut, along a normal; returns the hinge moment in
    /// N·m of this acceleration and of the section's motion, eq. (U19).
    pub(super) fn add_flap_mass(
        &self,
        strip: &Strip,
        density_kg_m3: f64,
        up: &Vector3<f64>,
        rates: &MassRates,
        loads: &mut [Wrench],
    ) -> f64 {
        let Some(flap) = &self.flap else { return 0.0 };
        let Hinge { c, t1, t3, t7, .. } = flap.hinge;
        let (b_m, span_m) = (0.5 * self.cut.chord_m, self.cut.span_m);
        let MassRates { middle_m_s2, difference_m_s2, flap_rad_s2 } = *rates;
        let force_n = -density_kg_m3 * b_m.powi(3) * t1 * flap_rad_s2 * span_m;
        let moment_n_m = density_kg_m3 * b_m.powi(4) * (t7 + c * t1) * flap_rad_s2 * span_m;
        strip.add_force(loads, &self.cut, 0.5, &(up * force_n));
        strip.add_moment(loads, &self.cut, moment_n_m);
        let hinge_m2_s2 =
            -t1 * b_m * middle_m_s2 - 0.5 * (t7 + c * t1) * b_m * difference_m_s2 - t3 / PI * b_m.powi(2) * flap_rad_s2;
        -flap.share * density_kg_m3 * b_m.powi(2) * hinge_m2_s2 * span_m
    }
}

/// Accelerations for the apparent mass of a strip with a control surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MassRates {
    /// Rate of the upward velocity at half chord in m/s².
    pub middle_m_s2: f64,
    /// Rate of the difference of upward velocities, trailing edge minus leading edge, in m/s².
    pub difference_m_s2: f64,
    /// Angular acceleration of the control surface in the cut in rad/s².
    pub flap_rad_s2: f64,
}

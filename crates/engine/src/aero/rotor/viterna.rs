//! Polars on the full circle: Viterna and Corrigan's extension beyond stall.
//!
//! Source: Viterna and Corrigan, *Fixed pitch rotor performance of large horizontal axis wind turbines*, NASA CP-2230
//! (1981). Reversed and negative angles follow the practice of AirfoilPrep (NREL): reflection with 0.7 of the lift.

use crate::aero::polar::{Polar, PolarRow};
use std::f64::consts::{FRAC_PI_2, PI};

/// Fraction of the lift that a section keeps when its rear edge leads or its suction side is the flat one.
const REFLECTED_LIFT: f64 = 0.7;
/// Spacing of the added rows in rad: linear interpolation between them differs from the formulas by less than 0.002.
const SPACING_RAD: f64 = 2.5 * PI / 180.0;
/// Smallest drag coefficient of the extension: the formulas fall below zero near ±180°.
const MINIMUM_DRAG: f64 = 1e-4;

/// Why a polar cannot be extended.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoExtension {
    /// There are no rows.
    #[error("a polar without rows")]
    Empty,
    /// The last row is not at stall below 90°.
    #[error(
        "the last angle is {0:.3} deg; Viterna's extension begins at stall, between 0 and 90 deg and above every other angle \
         in magnitude reached by a positive lift"
    )]
    NotStalled(f64),
    /// The first row lies beyond the reflected range.
    #[error("the first angle is {0:.3} deg; an extended polar begins between -90 deg and the last angle")]
    FirstAngle(f64),
    /// The largest drag coefficient is not one that a plate across the flow can have.
    #[error("a largest drag coefficient of {0}; a plate across the flow has more than the last row, at most 3")]
    Drag(f64),
}

/// Largest drag coefficient, at 90°, of a blade of an aspect ratio, eq. (B1): 1.11 + 0.018 AR, 2.01 beyond 50.
pub fn drag_across(aspect_ratio: f64) -> f64 {
    1.11 + 0.018 * aspect_ratio.min(50.0)
}

/// Whether the rows cover the full circle, from −180° to 180°.
pub fn is_full_circle(rows: &[PolarRow]) -> bool {
    let near = |row: Option<&PolarRow>, angle_rad: f64| row.is_some_and(|row| (row.angle_rad - angle_rad).abs() < 1e-6);
    near(rows.first(), -PI) && near(rows.last(), PI)
}

/// Rows from −180° to 180°: the given ones in their range, eq. (B1) elsewhere. `drag_across` is the drag coefficient at
/// 90°.
///
/// Moments follow from a centre of pressure that moves linearly from its place at the first and last row to half chord
/// at ±90° and to three quarters at ±180°; Viterna and Corrigan do not treat them.
///
/// # Errors
/// If the polar does not end at stall with positive lift between 0° and 90°, or begins below −90°.
pub fn extend(rows: &[PolarRow], drag_across: f64) -> Result<Polar, NoExtension> {
    let (Some(low), Some(high)) = (rows.first(), rows.last()) else { return Err(NoExtension::Empty) };
    let stall_rad = high.angle_rad;
    if !(stall_rad > 0.0 && stall_rad < FRAC_PI_2 && high.lift > 0.0) {
        return Err(NoExtension::NotStalled(stall_rad.to_degrees()));
    }
    if !(low.angle_rad >= -FRAC_PI_2 && low.angle_rad <= stall_rad) {
        return Err(NoExtension::FirstAngle(low.angle_rad.to_degrees()));
    }
    if !(drag_across > high.drag && drag_across <= 3.0) {
        return Err(NoExtension::Drag(drag_across));
    }
    let law = Law::new(high, low, drag_across);
    let mut extended = Vec::new();
    law.fill(-PI, low.angle_rad, &mut extended);
    extended.extend_from_slice(rows);
    let below = extended.len();
    law.fill(stall_rad, PI, &mut extended);
    extended.remove(below); // the last given row itself
    Ok(Polar { rows: extended })
}

/// Coefficients of eq. (B1) with the rows that they continue.
struct Law {
    stall_rad: f64,
    stall_lift: f64,
    drag_across: f64,
    lift_share: f64,
    drag_share: f64,
    /// First given row: below it the lift is linear to the reflected stall.
    low: PolarRow,
    /// Centre of pressure behind the quarter chord, in chords, at the last and the first row.
    arm: [f64; 2],
}

impl Law {
    fn new(high: &PolarRow, low: &PolarRow, drag_across: f64) -> Self {
        let (sine, cosine) = high.angle_rad.sin_cos();
        let arm = |row: &PolarRow| {
            let normal = row.lift * row.angle_rad.cos() + row.drag * row.angle_rad.sin();
            if normal.abs() > 0.05 { (-row.moment / normal).clamp(-0.5, 0.75) } else { 0.0 }
        };
        Self {
            stall_rad: high.angle_rad,
            stall_lift: high.lift,
            drag_across,
            lift_share: (high.lift - drag_across * sine * cosine) * sine / (cosine * cosine),
            drag_share: (high.drag - drag_across * sine * sine) / cosine,
            low: *low,
            arm: [arm(high), arm(low)],
        }
    }

    /// Rows from one angle to another, the last excluded.
    fn fill(&self, from_rad: f64, to_rad: f64, rows: &mut Vec<PolarRow>) {
        let count = ((to_rad - from_rad) / SPACING_RAD).ceil().max(0.0);
        for step in 0..count as usize {
            rows.push(self.at(from_rad + (to_rad - from_rad) * step as f64 / count));
        }
        if to_rad == PI {
            rows.push(self.at(PI));
        }
    }

    /// Lift and drag between stall and 90°.
    fn stalled(&self, angle_rad: f64) -> (f64, f64) {
        let (sine, cosine) = angle_rad.sin_cos();
        let lift = self.drag_across * sine * cosine + self.lift_share * cosine * cosine / sine;
        (lift, self.drag_across * sine * sine + self.drag_share * cosine)
    }

    /// Coefficients at an angle outside the given rows.
    fn at(&self, angle_rad: f64) -> PolarRow {
        let size_rad = angle_rad.abs();
        let from_line_rad = size_rad.min(PI - size_rad); // from the chord line, whichever edge leads
        let reversed = size_rad > FRAC_PI_2;
        let negative = angle_rad < 0.0;
        let (lift, drag) = if from_line_rad >= self.stall_rad {
            let (lift, drag) = self.stalled(from_line_rad);
            let sign = if reversed == negative { 1.0 } else { -1.0 };
            (if reversed || negative { sign * REFLECTED_LIFT * lift } else { lift }, drag)
        } else if reversed {
            // attached from behind: linear to zero at ±180°
            let share = from_line_rad / self.stall_rad;
            let lift = REFLECTED_LIFT * self.stall_lift * share * if negative { 1.0 } else { -1.0 };
            (lift, self.stalled(self.stall_rad).1 * share * share + MINIMUM_DRAG)
        } else {
            // between the reflected stall and the first row
            let (lift, drag) = self.stalled(self.stall_rad);
            let share = (angle_rad + self.stall_rad) / (self.low.angle_rad + self.stall_rad);
            let start = -REFLECTED_LIFT * lift;
            (start + (self.low.lift - start) * share, drag + (self.low.drag - drag) * share)
        };
        let drag = drag.max(MINIMUM_DRAG);
        let normal = lift * angle_rad.cos() + drag * angle_rad.sin();
        PolarRow { angle_rad, lift, drag, moment: -self.arm_at(angle_rad) * normal }
    }

    /// Centre of pressure behind the quarter chord, in chords.
    fn arm_at(&self, angle_rad: f64) -> f64 {
        let size_rad = angle_rad.abs();
        if size_rad >= FRAC_PI_2 {
            return 0.25 + 0.25 * (size_rad - FRAC_PI_2) / FRAC_PI_2;
        }
        let (edge_rad, arm) = if angle_rad > 0.0 {
            (self.stall_rad, self.arm[0])
        } else {
            (self.low.angle_rad.min(0.0).abs(), self.arm[1])
        };
        let room_rad = FRAC_PI_2 - edge_rad;
        if room_rad <= 0.0 { 0.25 } else { arm + (0.25 - arm) * (size_rad - edge_rad) / room_rad }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(angle_deg: f64, lift: f64, drag: f64) -> PolarRow {
        PolarRow { angle_rad: angle_deg.to_radians(), lift, drag, moment: -0.05 }
    }

    fn sample() -> Polar {
        extend(&[row(-10.0, -0.8, 0.02), row(0.0, 0.3, 0.008), row(15.0, 1.4, 0.05)], drag_across(15.0)).unwrap()
    }

    /// The formulas of the paper by hand: AR 15, stall at 15° with 1.4 and 0.05.
    #[test]
    fn extension_is_viternas_formula_beyond_stall() {
        let polar = sample();
        assert!(is_full_circle(&polar.rows));
        let across = 1.11 + 0.018 * 15.0;
        let (sine, cosine) = 15f64.to_radians().sin_cos();
        let lift_share = (1.4 - across * sine * cosine) * sine / cosine.powi(2);
        let drag_share = (0.05 - across * sine * sine) / cosine;
        let on_row = polar.rows.iter().find(|row| row.angle_rad > 40f64.to_radians()).unwrap();
        let (s, c) = on_row.angle_rad.sin_cos();
        approx::assert_relative_eq!(
            on_row.lift,
            0.5 * across * (2.0 * s * c) + lift_share * c * c / s,
            max_relative = 1e-12
        );
        approx::assert_relative_eq!(on_row.drag, across * s * s + drag_share * c, max_relative = 1e-12);
        approx::assert_relative_eq!(polar.at(FRAC_PI_2).drag, across, max_relative = 2e-3);
        assert!(polar.at(FRAC_PI_2).lift.abs() < 1e-3 && polar.at(PI).lift.abs() < 1e-12);
    }

    #[test]
    fn extension_has_no_jumps_keeps_its_rows_and_closes() {
        let polar = sample();
        assert!(polar.rows.windows(2).all(|pair| pair[0].angle_rad < pair[1].angle_rad));
        assert_eq!(polar.at(0.0), row(0.0, 0.3, 0.008));
        for pair in polar.rows.windows(2) {
            let gap = (pair[1].angle_rad - pair[0].angle_rad).to_degrees();
            let given = pair[0].angle_rad >= -0.1746 && pair[1].angle_rad <= 0.262;
            assert!(given || (pair[1].lift - pair[0].lift).abs() < 0.11 * gap, "{pair:?}");
            assert!(given || (pair[1].drag - pair[0].drag).abs() < 0.05 * gap, "{pair:?}");
            assert!(given || (pair[1].moment - pair[0].moment).abs() < 0.05 * gap, "{pair:?}");
        }
        let (first, last) = (polar.rows[0], polar.rows[polar.rows.len() - 1]);
        assert!((first.lift - last.lift).abs() < 1e-12 && (first.drag - last.drag).abs() < 1e-12);
        assert!((first.moment - last.moment).abs() < 1e-12);
    }

    #[test]
    fn polars_that_do_not_end_at_stall_are_refused() {
        assert_eq!(extend(&[], 1.3), Err(NoExtension::Empty));
        assert!(matches!(extend(&[row(0.0, 0.1, 0.01)], 1.3), Err(NoExtension::NotStalled(_))));
        assert!(matches!(extend(&[row(100.0, 0.1, 0.01)], 1.3), Err(NoExtension::NotStalled(_))));
        assert!(matches!(extend(&[row(-95.0, 0.1, 0.01), row(15.0, 1.0, 0.1)], 1.3), Err(NoExtension::FirstAngle(_))));
        assert!(matches!(extend(&[row(15.0, 1.0, 0.1)], f64::NAN), Err(NoExtension::Drag(_))));
    }
}

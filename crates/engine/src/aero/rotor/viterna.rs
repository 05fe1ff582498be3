//! Polars over the full circle: the extension beyond stall by Viterna and Corrigan.
//!
//! Source: Viterna and Corrigan, *Fixed pitch rotor performance of large horizontal axis wind turbines*, NASA CP-2230 (1981). Reversed flow
//! and negative angles follow AirfoilPrep (NREL): reflection with 0.7 of the lift.

use crate::aero::polar::{Polar, PolarRow};
use std::f64::consts::{FRAC_PI_2, PI};

/// Factor on the lift of a section in reversed flow, or with its pressure side as suction side.
const REFLECTED_LIFT: f64 = 0.7;
/// Spacing of the added rows in rad: linear interpolation between them differs from the formulas by less than 0.002.
const SPACING_RAD: f64 = 2.5 * PI / 180.0;
/// Spacing in rad of the added rows of a polar with both stalls: linear interpolation has an error below 2e-4.
const FINE_RAD: f64 = 0.25 * PI / 180.0;
/// Smallest drag coefficient of the extension: the formulas become negative near ±180°.
const MINIMUM_DRAG: f64 = 1e-4;

/// Reason why a polar cannot be extended.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoExtension {
    /// There are no rows.
    #[error("a polar without rows")]
    Empty,
    /// The last row is not a stall point between 0° and 90°.
    #[error(
        "the last angle is {0:.3} deg; Viterna's extrapolation starts at stall: the last row must be between 0 and 90 \
         deg with a positive lift coefficient"
    )]
    NotStalled(f64),
    /// The first row is not a negative stall point between −90° and 0°.
    #[error(
        "the first angle is {0:.3} deg; a polar from negative to positive stall must begin between -90 and 0 deg with \
         a negative lift coefficient"
    )]
    NotStalledBelow(f64),
    /// The first row is outside the reflected range.
    #[error(
        "the first angle is {0:.3} deg; the rows of a polar with aspect_ratio must begin between -90 deg and the last angle"
    )]
    FirstAngle(f64),
    /// The drag coefficient is not that of a plate normal to the flow.
    #[error(
        "the drag coefficient at 90 deg would be {0}; it must be larger than at the ends of the rows, and at most 3"
    )]
    Drag(f64),
}

/// Largest drag coefficient, at 90°, of a blade with a given aspect ratio, eq. (B1): 1.11 + 0.018 AR, and 2.01 beyond 50.
pub fn drag_across(aspect_ratio: f64) -> f64 {
    1.11 + 0.018 * aspect_ratio.min(50.0)
}

/// Whether the rows cover the full circle, from −180° to 180°.
pub fn is_full_circle(rows: &[PolarRow]) -> bool {
    let near = |row: Option<&PolarRow>, angle_rad: f64| row.is_some_and(|row| (row.angle_rad - angle_rad).abs() < 1e-6);
    near(rows.first(), -PI) && near(rows.last(), PI)
}

/// Returns rows from −180° to 180°: the given ones in their range, eq. (B1) elsewhere. `drag_across` is the drag coefficient at 90°.
///
/// Moments follow from a centre of pressure that moves linearly from its position at the first and the last row to half chord at ±90° and
/// to three quarters at ±180°; Viterna and Corrigan do not treat moments.
///
/// # Errors
/// If the polar does not end at stall with positive lift between 0° and 90°, or starts below −90°.
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

/// Returns rows from −180° to 180° for a polar from negative to positive stall: the formulas of eq. (B1) from either stall to ±90°, beyond
/// that the drag of a plate normal to the flow without lift, eq. (B28). Beyond either stall the moment coefficient changes over `shift_rad`
/// from its value at stall to that of a centre of pressure at half chord.
///
/// # Errors
/// If the rows do not extend from a negative lift between −90° and 0° to a positive lift between 0° and 90°.
pub fn extend_both(rows: &[PolarRow], drag_across: f64, shift_rad: f64) -> Result<Polar, NoExtension> {
    let (Some(low), Some(high)) = (rows.first(), rows.last()) else { return Err(NoExtension::Empty) };
    let stalls = [(1.0, high), (-1.0, low)].map(|(sign, row)| PolarRow {
        angle_rad: sign * row.angle_rad,
        lift: sign * row.lift,
        ..*row
    });
    let stalled = |row: &PolarRow| row.angle_rad > 0.0 && row.angle_rad < FRAC_PI_2 && row.lift > 0.0;
    if !stalled(&stalls[0]) {
        return Err(NoExtension::NotStalled(high.angle_rad.to_degrees()));
    }
    if !stalled(&stalls[1]) {
        return Err(NoExtension::NotStalledBelow(low.angle_rad.to_degrees()));
    }
    if !(drag_across > high.drag.max(low.drag) && drag_across <= 3.0) {
        return Err(NoExtension::Drag(drag_across));
    }
    let side = |sign: f64, stall: &PolarRow| {
        let law = Law::new(stall, stall, drag_across);
        let at = move |size_rad: f64| {
            let (lift, drag) = if size_rad < FRAC_PI_2 { law.stalled(size_rad) } else { (0.0, drag_across) };
            let gone = ((size_rad - stall.angle_rad) / shift_rad).min(1.0);
            let normal = sign * (lift * size_rad.cos() + drag * size_rad.sin());
            let moment = stall.moment * (1.0 - gone) - 0.25 * gone * normal;
            PolarRow { angle_rad: sign * size_rad, lift: sign * lift, drag: drag.max(MINIMUM_DRAG), moment }
        };
        let mut ends = vec![stall.angle_rad, stall.angle_rad + shift_rad, FRAC_PI_2, PI];
        ends.retain(|end| *end <= PI);
        ends.sort_by(f64::total_cmp);
        ends.dedup();
        let mut angles = Vec::new();
        for pair in ends.windows(2) {
            let count = ((pair[1] - pair[0]) / FINE_RAD).ceil().max(1.0);
            angles.extend((1..count as usize).map(|step| pair[0] + (pair[1] - pair[0]) * step as f64 / count));
            angles.push(pair[1]);
        }
        angles.into_iter().map(at).collect::<Vec<_>>()
    };
    let mut extended = side(-1.0, &stalls[1]);
    extended.reverse();
    extended.extend_from_slice(rows);
    extended.extend(side(1.0, &stalls[0]));
    Ok(Polar { rows: extended })
}

/// Coefficients of eq. (B1) and the given rows from which they continue.
struct Law {
    stall_rad: f64,
    stall_lift: f64,
    drag_across: f64,
    lift_share: f64,
    drag_share: f64,
    /// First given row: below it the lift is linear to the reflected stall.
    low: PolarRow,
    /// Distances of the centre of pressure aft of the quarter chord, in chords, at the last and the first row.
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

    /// Appends rows from one angle to another, the last excluded.
    fn fill(&self, from_rad: f64, to_rad: f64, rows: &mut Vec<PolarRow>) {
        let count = ((to_rad - from_rad) / SPACING_RAD).ceil().max(0.0);
        for step in 0..count as usize {
            rows.push(self.at(from_rad + (to_rad - from_rad) * step as f64 / count));
        }
        if to_rad == PI {
            rows.push(self.at(PI));
        }
    }

    /// Lift and drag coefficients between stall and 90°.
    fn stalled(&self, angle_rad: f64) -> (f64, f64) {
        let (sine, cosine) = angle_rad.sin_cos();
        let lift = self.drag_across * sine * cosine + self.lift_share * cosine * cosine / sine;
        (lift, self.drag_across * sine * sine + self.drag_share * cosine)
    }

    /// Coefficients at an angle outside the given rows.
    fn at(&self, angle_rad: f64) -> PolarRow {
        let size_rad = angle_rad.abs();
        let from_line_rad = size_rad.min(PI - size_rad); // angle from the chord line, for either leading edge
        let reversed = size_rad > FRAC_PI_2;
        let negative = angle_rad < 0.0;
        let (lift, drag) = if from_line_rad >= self.stall_rad {
            let (lift, drag) = self.stalled(from_line_rad);
            let sign = if reversed == negative { 1.0 } else { -1.0 };
            (if reversed || negative { sign * REFLECTED_LIFT * lift } else { lift }, drag)
        } else if reversed {
            // attached reversed flow: linear to zero at ±180°
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

    /// Distance of the centre of pressure aft of the quarter chord, in chords.
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

    /// The formulas of the paper evaluated by hand: AR 15, stall at 15° with 1.4 and 0.05.
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

    /// Moments of the extended polar follow from the lever arm of the normal force about the quarter chord. It is linear from its values at
    /// the ends, 0.05 divided by their normal forces, to a quarter of the chord at ±90° and to half of it at ±180°. Checked at rows of the
    /// extension.
    #[test]
    fn moments_have_the_arm_of_the_centre_of_pressure() {
        let polar = sample();
        let given = 15f64.to_radians();
        let mut met = [0; 4];
        for found in
            polar.rows.iter().filter(|row| row.angle_rad > given + 1e-9 || row.angle_rad < -1e-9 - 10f64.to_radians())
        {
            let (size_deg, negative) = (found.angle_rad.abs().to_degrees(), found.angle_rad < 0.0);
            let normal = |angle_rad: f64, lift: f64, drag: f64| lift * angle_rad.cos() + drag * angle_rad.sin();
            let (edge_deg, force) = match negative {
                true => (10.0, normal(-10f64.to_radians(), -0.8, 0.02)),
                false => (15.0, normal(given, 1.4, 0.05)),
            };
            let arm = match size_deg {
                beyond if beyond >= 90.0 => 0.25 + 0.25 * (beyond - 90.0) / 90.0,
                _ => 0.05 / force + (0.25 - 0.05 / force) * (size_deg - edge_deg) / (90.0 - edge_deg),
            };
            met[usize::from(negative) + 2 * usize::from(size_deg > 90.0)] += 1;
            let expected = -arm * normal(found.angle_rad, found.lift, found.drag);
            approx::assert_relative_eq!(found.moment, expected, epsilon = 1e-12, max_relative = 1e-9);
        }
        assert!(met.iter().all(|&rows| rows > 20), "{met:?}");
    }

    /// Both sides follow the formulas, the moment changes over the shift, a plate applies beyond 90°; given rows are kept, without jumps.
    #[test]
    fn both_stalls_are_extended() {
        let given = [row(-10.0, -0.6, 0.03), row(0.0, 0.4, 0.008), row(12.0, 1.6, 0.05)];
        let (across, shift_rad) = (drag_across(15.0), 10f64.to_radians());
        let polar = extend_both(&given, across, shift_rad).unwrap();
        assert!(is_full_circle(&polar.rows) && polar.at(0.0) == given[1]);
        assert!(polar.rows.windows(2).all(|pair| pair[0].angle_rad < pair[1].angle_rad));
        for (sign, stall) in [(1.0, &given[2]), (-1.0, &given[0])] {
            let (s, c) = stall.angle_rad.abs().sin_cos();
            let on = (sign * 40f64).to_radians();
            let (sine, cosine) = on.abs().sin_cos();
            let lift =
                across * sine * cosine + (sign * stall.lift - across * s * c) * s / (c * c) * cosine * cosine / sine;
            let drag = across * sine * sine + (stall.drag - across * s * s) / c * cosine;
            let found = polar.at(on);
            // linear interpolation between rows 0.25 degrees apart
            approx::assert_relative_eq!(found.lift, sign * lift, max_relative = 2e-4);
            approx::assert_relative_eq!(found.drag, drag, max_relative = 2e-4);
            approx::assert_relative_eq!(
                found.moment,
                -0.25 * sign * (lift * cosine + drag * sine),
                max_relative = 2e-4
            );
            let half = polar.at(stall.angle_rad + sign * 0.5 * shift_rad);
            let normal = half.lift * half.angle_rad.cos() + half.drag * half.angle_rad.sin();
            approx::assert_relative_eq!(half.moment, 0.5 * stall.moment - 0.125 * normal, max_relative = 2e-4);
            let beyond = polar.at(sign * 120f64.to_radians());
            approx::assert_relative_eq!(beyond.drag, across, max_relative = 1e-12);
            assert_eq!(beyond.lift, 0.0);
        }
        for pair in polar.rows.windows(2).filter(|pair| pair[0].angle_rad.abs() > 0.25) {
            let gap = pair[1].angle_rad - pair[0].angle_rad;
            assert!(
                (pair[1].lift - pair[0].lift).abs() < 6.0 * gap && (pair[1].moment - pair[0].moment).abs() < 4.0 * gap
            );
        }
        let reversed = [row(2.0, 0.4, 0.01), row(12.0, 1.6, 0.05)];
        assert!(matches!(extend_both(&reversed, across, shift_rad), Err(NoExtension::NotStalledBelow(_))));
        assert!(matches!(extend_both(&given[..2], across, shift_rad), Err(NoExtension::NotStalled(_))));
        assert!(matches!(extend_both(&given, 0.01, shift_rad), Err(NoExtension::Drag(_))));
        assert!(matches!(extend_both(&[], across, shift_rad), Err(NoExtension::Empty)));
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

//! End of the last ring: position of the vorticity that leaves the trailing edge during a step.

use nalgebra::Vector3;

/// Displacement of the trailing edge relative to the air, in panel chords, after which the wake gets a new row.
///
/// An edge without motion relative to the air sheds no row, because the rings would accumulate there. If steps are shorter than this, the
/// foremost row grows until it is long enough.
pub(super) const SHED_PANELS: f64 = 0.05;

/// Pairs of the displacement of the air in a step and the position of the youngest vortex behind the trailing edge, in panel chords.
const PLACES: [(f64, f64); 11] = [
    (0.05, -0.103_56),
    (0.1, -0.080_62),
    (0.2, -0.037_76),
    (0.3, 0.002_29),
    (0.5, 0.077_27),
    (0.75, 0.165_41),
    (1.0, 0.25),
    (1.5, 0.413_33),
    (2.0, 0.572_36),
    (4.0, 1.192_35),
    (8.0, 2.412_20),
];

/// Position `σ` of the last corners behind the trailing edge in panel chords, for a displacement `δ` of the air in a step, eq. (U9).
///
/// The response of a lattice to a vortex at `s` panel chords behind its edge is `Γ(s + ¼)/Γ(s + ¾)`, that of the continuous plate `1/√s`
/// (Cauchy's determinant for a half-plane). The position `σ` makes the responses to a uniform wake in steps of `δ` equal. At other
/// positions, such as the usual quarter panel, the circulation lags by an error that decreases only with the square root of the panel size
/// unless `δ = 1`, where `σ = ¼`.
fn rear_panels(displacement_panels: f64) -> f64 {
    let displacement = displacement_panels.max(SHED_PANELS);
    let after = PLACES.iter().position(|(place, _)| *place > displacement).unwrap_or(PLACES.len() - 1).max(1);
    let ((w0, s0), (w1, s1)) = (PLACES[after - 1], PLACES[after]);
    s0 + (s1 - s0) * (displacement - w0) / (w1 - w0)
}

/// Largest ratio of the displacement of the air normal to the chord to that along it which is fully included if the last corners are in
/// front of the edge: 63° of sideslip or incidence.
const LARGEST_SLANT: f64 = 2.0;

/// Position in m of the last corners behind the trailing edge, for the displacement of the air past the edge in a step and the chord vector
/// of a panel, both in m, eq. (U9).
///
/// Along the chord it is `σ` panel chords. Normal to the chord the vorticity moves with the air: the line from the edge continues into the
/// wake, and steady flow does not depend on the step. If `σ` is negative, the wake passes through the edge along the same line. For an edge
/// that moves broadside, with almost no displacement of the air along the chord, the corner is never ahead of its motion.
pub fn rear_corner_m(displacement_m: &Vector3<f64>, panel_m: &Vector3<f64>) -> Vector3<f64> {
    let displacement = displacement_m.dot(panel_m) / panel_m.norm_squared();
    let place = rear_panels(displacement);
    if displacement <= 0.0 {
        return place * panel_m;
    }
    let across_m = displacement_m / displacement - panel_m;
    let slant = across_m.norm() / panel_m.norm();
    let share = if place < 0.0 && slant > LARGEST_SLANT { (LARGEST_SLANT / slant).powi(2) } else { 1.0 };
    place * (panel_m + share * across_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Γ(s + ¼)/Γ(s + ¾)`, from its asymptotic expansion and the recurrence of the gamma function.
    fn answer(s: f64) -> f64 {
        let (mut factor, mut s) = (1.0, s);
        while s < 20.0 {
            factor *= (s + 0.75) / (s + 0.25);
            s += 1.0;
        }
        // the next term is below 1e-7
        factor * (1.0 - 1.0 / (64.0 * s * s)) / s.sqrt()
    }

    /// At a quarter the ratio is `Γ(½)/Γ(1) = √π`.
    #[test]
    fn answer_is_the_ratio_of_gamma_functions() {
        approx::assert_relative_eq!(answer(0.25), std::f64::consts::PI.sqrt(), max_relative = 1e-6);
    }

    /// The defining sum over 4000 vortices equals `2√x` up to the midpoint behind the last one. The table has five digits; linear
    /// interpolation between its rows has an error below 0.004.
    #[test]
    fn uniform_wake_acts_like_a_continuous_one() {
        let excess = |displacement: f64, place: f64| {
            let sum: f64 = (0..4000).map(|n| displacement * answer(place + f64::from(n) * displacement)).sum();
            sum - 2.0 * (4000.0 * displacement + place - 0.5 * displacement).sqrt()
        };
        for (displacement, place) in PLACES {
            // the excess decreases as the vortices move aft
            assert!(
                excess(displacement, place - 2e-4) > 0.0 && excess(displacement, place + 2e-4) < 0.0,
                "{displacement}: {place}"
            );
        }
        for displacement in [0.07, 0.15, 0.4, 0.6, 0.9, 1.2, 3.0] {
            let place = rear_panels(displacement);
            assert!(
                excess(displacement, place - 4e-3) > 0.0 && excess(displacement, place + 4e-3) < 0.0,
                "{displacement}: {place}"
            );
        }
    }

    /// The last corner is on the path of the air, in front of or behind the edge; its chordwise position does not depend on the
    /// displacement normal to the chord. For an edge that moves broadside it is in the plane of the plate.
    #[test]
    fn corner_lies_on_the_way_of_the_air() {
        let panel_m = Vector3::new(0.0, -0.3, 0.0);
        for displacement in [0.1, 0.29, 1.0, 4.0] {
            let displacement_m = displacement * Vector3::new(0.2, -0.3, 0.05);
            let corner_m = rear_corner_m(&displacement_m, &panel_m);
            assert!(corner_m.cross(&displacement_m).norm() < 1e-15, "{displacement}: {corner_m}");
            assert_eq!(corner_m.y, rear_panels(displacement) * -0.3, "{displacement}");
        }
        for along_m in [-1e-3, 0.0, 1e-3] {
            let broadside_m = rear_corner_m(&Vector3::new(0.0, along_m, 0.6), &panel_m);
            assert!(broadside_m.z.abs() < 1e-3 * 0.3, "{broadside_m}");
        }
    }
}

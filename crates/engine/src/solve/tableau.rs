//! Butcher tableaux of the diagonally implicit methods.

/// An ESDIRK method: explicit first stage, constant diagonal `γ`, stiffly accurate (its last row is `b`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tableau<'a> {
    /// Name of the method.
    pub name: &'a str,
    /// Rows below the diagonal of stages 2, 3, …; row `i` has `i + 1` entries.
    pub rows: &'a [&'a [f64]],
    /// Diagonal coefficient `γ`.
    pub gamma: f64,
    /// `b − b̂`: weights of the error estimate.
    pub error: &'a [f64],
    /// Order of the method.
    pub order: u32,
    /// Order of the error estimate: it is proportional to this power of the step size.
    pub error_order: u32,
}

impl Tableau<'_> {
    /// Number of stages, including the explicit one.
    pub fn stages(&self) -> usize {
        self.rows.len() + 1
    }

    /// Abscissa `c` of a stage.
    pub fn abscissa(&self, stage: usize) -> f64 {
        if stage == 0 { 0.0 } else { self.rows[stage - 1].iter().sum::<f64>() + self.gamma }
    }

    /// Predictor of a stage's accelerations: two previous stages with their weights, NOTATION eq. (T9).
    ///
    /// Extrapolates linearly in time from the two nearest abscissae; for the first implicit stage it is the value at the step's start. A
    /// parabola through three stages takes more iterations: it amplifies the residual error of stiff modes.
    pub fn predictor(&self, stage: usize) -> [(usize, f64); 2] {
        let at = self.abscissa(stage);
        let distance = |other: usize| (self.abscissa(other) - at).abs();
        let nearest = |except: Option<usize>| {
            (0..stage).filter(|&other| Some(other) != except).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
        };
        let first = nearest(None).unwrap_or(0);
        let Some(second) = nearest(Some(first)) else { return [(first, 1.0), (first, 0.0)] };
        let share = (at - self.abscissa(first)) / (self.abscissa(second) - self.abscissa(first));
        [(first, 1.0 - share), (second, share)]
    }
}

/// Maximum number of stages of the methods in this file.
pub const MAX_STAGES: usize = 6;

const ROOT_2: f64 = std::f64::consts::SQRT_2;

/// TR-BDF2 as a three-stage ESDIRK, order 2 with an error estimate of order 3 (Hosea and Shampine 1996).
pub const TR_BDF2: Tableau = {
    const GAMMA: f64 = 1.0 - ROOT_2 / 2.0;
    const W: f64 = ROOT_2 / 4.0;
    Tableau {
        name: "tr_bdf2",
        rows: &[&[GAMMA], &[W, W]],
        gamma: GAMMA,
        error: &[W - (1.0 - W) / 3.0, W - (3.0 * W + 1.0) / 3.0, GAMMA - GAMMA / 3.0],
        order: 2,
        error_order: 3,
    }
};

/// Two-stage SDIRK, order 2, L-stable (Alexander 1977), NOTATION eq. (T10): its explicit first stage has zero weight, so that a jump of the
/// accelerations at the step's start does not excite stiff modes.
pub const SDIRK2: Tableau = {
    const GAMMA: f64 = 1.0 - ROOT_2 / 2.0;
    Tableau {
        name: "sdirk2",
        rows: &[&[0.0], &[0.0, 1.0 - GAMMA]],
        gamma: GAMMA,
        error: &[0.0, -GAMMA, GAMMA],
        order: 2,
        error_order: 2,
    }
};

/// Implicit part of `ARK3(2)4L[2]SA` (Kennedy and Carpenter 2003): order 3, L-stable.
pub const ESDIRK3: Tableau = {
    const GAMMA: f64 = 1767732205903.0 / 4055673282236.0;
    const B: [f64; 3] =
        [1471266399579.0 / 7840856788654.0, -4482444167858.0 / 7529755066697.0, 11266239266428.0 / 11593286722821.0];
    Tableau {
        name: "esdirk3",
        rows: &[&[GAMMA], &[2746238789719.0 / 10658868560708.0, -640167445237.0 / 6845629431997.0], &B],
        gamma: GAMMA,
        error: &[
            B[0] - 2756255671327.0 / 12835298489170.0,
            B[1] + 10771552573575.0 / 22201958757719.0,
            B[2] - 9247589265047.0 / 10645013368117.0,
            GAMMA - 2193209047091.0 / 5459859503100.0,
        ],
        order: 3,
        error_order: 3,
    }
};

/// Implicit part of `ARK4(3)6L[2]SA` (Kennedy and Carpenter 2003): order 4, L-stable.
pub const ESDIRK4: Tableau = {
    const B: [f64; 5] = [82889.0 / 524892.0, 0.0, 15625.0 / 83664.0, 69875.0 / 102672.0, -2260.0 / 8211.0];
    Tableau {
        name: "esdirk4",
        rows: &[
            &[1.0 / 4.0],
            &[8611.0 / 62500.0, -1743.0 / 31250.0],
            &[5012029.0 / 34652500.0, -654441.0 / 2922500.0, 174375.0 / 388108.0],
            &[
                15267082809.0 / 155376265600.0,
                -71443401.0 / 120774400.0,
                730878875.0 / 902184768.0,
                2285395.0 / 8070912.0,
            ],
            &B,
        ],
        gamma: 1.0 / 4.0,
        error: &[
            B[0] - 4586570599.0 / 29645900160.0,
            B[1],
            B[2] - 178811875.0 / 945068544.0,
            B[3] - 814220225.0 / 1159782912.0,
            B[4] + 3700637.0 / 11593932.0,
            1.0 / 4.0 - 61727.0 / 225920.0,
        ],
        order: 4,
        error_order: 4,
    }
};

#[cfg(test)]
mod tests {
    use super::*;

    struct Full {
        a: Vec<Vec<f64>>,
        b: Vec<f64>,
        c: Vec<f64>,
        embedded: Vec<f64>,
    }

    fn full(tableau: &Tableau) -> Full {
        let stages = tableau.stages();
        let mut a = vec![vec![0.0; stages]; stages];
        for (i, row) in tableau.rows.iter().enumerate() {
            a[i + 1][..row.len()].copy_from_slice(row);
            a[i + 1][i + 1] = tableau.gamma;
        }
        let b = a[stages - 1].clone();
        let embedded = b.iter().zip(tableau.error).map(|(b, e)| b - e).collect();
        Full { c: (0..stages).map(|i| tableau.abscissa(i)).collect(), a, b, embedded }
    }

    /// Eq. (T9): accelerations that are linear in time are predicted exactly from two earlier stages; the first implicit stage starts from
    /// the acceleration at the start of the step.
    #[test]
    fn predictors_are_exact_for_linear_accelerations() {
        for tableau in [TR_BDF2, SDIRK2, ESDIRK3, ESDIRK4] {
            assert_eq!(tableau.predictor(1), [(0, 1.0), (0, 0.0)], "{}", tableau.name);
            for stage in 2..tableau.stages() {
                let linear = |stage: usize| 3.0 - 2.0 * tableau.abscissa(stage);
                let [(j, first), (k, second)] = tableau.predictor(stage);
                assert!(j < stage && k < stage && j != k, "{} {stage}: {j} {k}", tableau.name);
                let predicted = first * linear(j) + second * linear(k);
                approx::assert_relative_eq!(predicted, linear(stage), epsilon = 1e-14);
            }
        }
    }

    /// Residuals of the order conditions of all rooted trees up to order four, by order.
    fn conditions(a: &[Vec<f64>], b: &[f64], c: &[f64]) -> [f64; 4] {
        let times =
            |x: &[f64]| -> Vec<f64> { a.iter().map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum()).collect() };
        let dot = |x: &[f64]| -> f64 { b.iter().zip(x).map(|(b, x)| b * x).sum() };
        let product = |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x * y).collect() };
        let one = vec![1.0; b.len()];
        let (c2, ac) = (product(c, c), times(c));
        [
            (dot(&one) - 1.0).abs(),
            (dot(c) - 0.5).abs(),
            (dot(&c2) - 1.0 / 3.0).abs().max((dot(&ac) - 1.0 / 6.0).abs()),
            [
                dot(&product(&c2, c)) - 0.25,
                dot(&product(c, &ac)) - 0.125,
                dot(&times(&c2)) - 1.0 / 12.0,
                dot(&times(&ac)) - 1.0 / 24.0,
            ]
            .iter()
            .fold(0.0, |worst, x| worst.max(x.abs())),
        ]
    }

    /// Order conditions hold to round-off (the published fractions have 13 digits) up to the stated order and fail beyond; the embedded
    /// method has one order less, or one more for TR-BDF2.
    #[test]
    fn tableaux_have_their_orders() {
        for (tableau, embedded_order) in [(TR_BDF2, 3), (SDIRK2, 1), (ESDIRK3, 2), (ESDIRK4, 3)] {
            let full = full(&tableau);
            for (name, weights, order) in
                [("b", &full.b, tableau.order), ("embedded b", &full.embedded, embedded_order)]
            {
                let residuals = conditions(&full.a, weights, &full.c);
                for (i, residual) in residuals.iter().enumerate() {
                    let holds = *residual < 1e-12;
                    assert_eq!(holds, i < order as usize, "{} {name}: order {}: {residual:.1e}", tableau.name, i + 1);
                }
            }
        }
    }

    /// L-stability: `|R(iy)| ≤ 1` on the imaginary axis and `R(∞) = 0`, with `R(z) = 1 + z bᵀ(I − zA)⁻¹ 1`.
    #[test]
    fn tableaux_are_l_stable() {
        for tableau in [TR_BDF2, SDIRK2, ESDIRK3, ESDIRK4] {
            let full = full(&tableau);
            let amplification = |y: f64| {
                // forward substitution of (I − zA) k = 1 with z = iy, as pairs (re, im)
                let mut k: Vec<(f64, f64)> = Vec::new();
                for (i, row) in full.a.iter().enumerate() {
                    let (mut re, mut im) = (1.0, 0.0);
                    for (j, k) in k.iter().enumerate() {
                        re -= y * row[j] * k.1;
                        im += y * row[j] * k.0;
                    }
                    let (dr, di) = (1.0, -y * row[i]);
                    let scale = dr * dr + di * di;
                    k.push(((re * dr + im * di) / scale, (im * dr - re * di) / scale));
                }
                k.last().map_or(0.0, |last| last.0.hypot(last.1))
            };
            for exponent in -30..=60 {
                let y = 10f64.powf(f64::from(exponent) / 10.0);
                assert!(amplification(y) <= 1.0 + 1e-12, "{}: |R(i{y})| = {}", tableau.name, amplification(y));
            }
            assert!(amplification(1e8) < 1e-6, "{}: R(∞) ≠ 0", tableau.name);
        }
    }
}

//! First-order lag over a step, exact for an input that changes linearly.

/// State of `x' = (u − x)/τ` at the end of a step of `ratio` time constants, with an input that changes linearly from
/// `from` to `to`, eq. (B11).
pub fn lag(state: f64, from: f64, to: f64, ratio: f64) -> f64 {
    let gone = -(-ratio).exp_m1();
    // 1 − (1 − e^-z)/z; for small z the series avoids the cancellation
    let share = if ratio < 1e-3 { ratio * (0.5 - ratio * (1.0 / 6.0 - ratio / 24.0)) } else { 1.0 - gone / ratio };
    state + (from - state) * gone + (to - from) * share
}

#[cfg(test)]
mod tests {
    use super::lag;

    #[test]
    fn lag_solves_its_equation_for_any_step() {
        for ratio in [1e-9f64, 1e-4, 0.9e-3, 1.1e-3, 0.3, 5.0, 400.0] {
            // x = u0 + s (t − τ) + (x0 − u0 + s τ) e^(−t/τ), with τ = 1 and u = u0 + s t
            let (start, from, to) = (0.3, 1.0, 3.0);
            let slope = (to - from) / ratio;
            let exact = if ratio < 1e-2 {
                // the closed form loses digits here: four Runge-Kutta steps are exact to round-off
                let (h, rate) = (0.25 * ratio, |t: f64, x: f64| from + slope * t - x);
                (0..4).fold(start, |x, step| {
                    let t = f64::from(step) * h;
                    let k1 = rate(t, x);
                    let k2 = rate(t + 0.5 * h, x + 0.5 * h * k1);
                    let k3 = rate(t + 0.5 * h, x + 0.5 * h * k2);
                    x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(t + h, x + h * k3))
                })
            } else {
                from + slope * (ratio - 1.0) + (start - from + slope) * (-ratio).exp()
            };
            approx::assert_relative_eq!(lag(start, from, to, ratio), exact, max_relative = 1e-9);
        }
        assert_eq!(lag(0.3, 1.0, 3.0, 0.0), 0.3);
    }
}

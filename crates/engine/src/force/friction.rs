//! Slipping brake: a torque opposite to the rate of its joint that grows over a ramp, NOTATION eq. (A9).

use crate::force::{Here, Push};
use crate::solve::Powers;

/// Parameters of a friction brake, NOTATION eq. (A9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionBrake {
    /// Torque in N·m, or force in N, once the brake is fully on.
    pub torque_n_m: f64,
    /// Time in s over which the torque grows from 0.
    pub ramp_s: f64,
    /// Rate in rad/s or m/s above which the brake slips: below it the torque decreases with the rate.
    pub slip_rad_s: f64,
}

/// Friction brake applied by a failure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlippingBrake {
    /// Parameters of the brake.
    pub brake: FrictionBrake,
    /// Index of the failure.
    pub failure: usize,
    /// Time in s from which the torque grows; infinite before the failure.
    pub from_s: f64,
    /// Rate in rad/s about which linear models linearise the torque; `None` for the nonlinear torque.
    pub about_rad_s: Option<f64>,
    /// Whether the torque grows, for derivatives with respect to parameters, eq. (X34); `None` if that follows from the time.
    pub held: Option<bool>,
}

impl SlippingBrake {
    /// A brake that has not been applied.
    pub fn off(brake: FrictionBrake, failure: usize) -> Self {
        Self { brake, failure, from_s: f64::INFINITY, about_rad_s: None, held: None }
    }

    /// Magnitude of the torque in N·m when the brake slips.
    fn reach_n_m(&self, time_s: f64) -> f64 {
        let on_s = time_s - self.from_s;
        match self.held {
            Some(true) => self.brake.torque_n_m * (on_s / self.brake.ramp_s),
            None if on_s < self.brake.ramp_s => self.brake.torque_n_m * (on_s / self.brake.ramp_s).max(0.0),
            Some(false) | None => self.brake.torque_n_m,
        }
    }

    /// Whether the torque grows at a time.
    pub fn grows_at(&self, time_s: f64) -> bool {
        self.from_s <= time_s && time_s < self.end_s()
    }

    /// Keeps the part of the ramp at a time.
    pub fn hold(&mut self, branch_s: f64) {
        self.held = self.from_s.is_finite().then_some(self.grows_at(branch_s));
    }

    /// Torque on the outer body about `+θ` in N·m.
    pub fn torque_n_m(&self, time_s: f64, rate_rad_s: f64) -> f64 {
        self.torque_and_damping(time_s, rate_rad_s).0
    }

    /// Torque on the outer body about `+θ` in N·m, and its damping in N·m·s/rad.
    fn torque_and_damping(&self, time_s: f64, rate_rad_s: f64) -> (f64, f64) {
        let about_rad_s = self.about_rad_s.unwrap_or(rate_rad_s);
        let slip = (about_rad_s / self.brake.slip_rad_s).tanh();
        let reach_n_m = self.reach_n_m(time_s);
        let damping_n_m_s = reach_n_m * (1.0 - slip * slip) / self.brake.slip_rad_s;
        (-reach_n_m * slip - damping_n_m_s * (rate_rad_s - about_rad_s), damping_n_m_s)
    }

    /// Linearises the torque about a rate of the joint.
    pub fn linearize(&mut self, rate_rad_s: f64) {
        self.about_rad_s = Some(rate_rad_s);
    }

    /// Adds the torque and its tangent.
    pub fn push(&self, here: &Here, sum: &mut Push) {
        if self.from_s.is_infinite() {
            return;
        }
        let (torque_n_m, damping_n_m_s) = self.torque_and_damping(here.time_s, here.rate_rad_s);
        sum.torque_n_m += torque_n_m;
        sum.tangent.damping += damping_n_m_s;
    }

    /// Adds the dissipated power.
    pub fn add_powers(&self, here: &Here, powers: &mut Powers) {
        if self.from_s.is_finite() {
            powers.dissipated -= self.torque_n_m(here.time_s, here.rate_rad_s) * here.rate_rad_s;
        }
    }

    /// End of the ramp in s; infinite before the failure.
    pub fn end_s(&self) -> f64 {
        self.from_s + self.brake.ramp_s
    }

    /// End of the ramp in s if it is after `time_s`.
    pub fn next_kink_s(&self, time_s: f64) -> f64 {
        let end_s = self.end_s();
        if end_s > time_s { end_s } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_grows_over_the_ramp_and_opposes_the_motion() {
        let brake = FrictionBrake { torque_n_m: 8.0, ramp_s: 2.0, slip_rad_s: 0.01 };
        let off = SlippingBrake::off(brake, 0);
        assert_eq!((off.torque_n_m(5.0, 1.0), off.next_kink_s(0.0)), (-0.0, f64::INFINITY));
        let on = SlippingBrake { from_s: 1.0, ..off };
        assert_eq!([1.0, 1.5, 3.0, 9.0].map(|t| on.torque_n_m(t, 1.0)), [-0.0, -2.0, -8.0, -8.0]);
        assert_eq!(on.torque_n_m(9.0, -1.0), 8.0);
        assert_eq!((on.next_kink_s(1.0), on.next_kink_s(3.0)), (3.0, f64::INFINITY));
        let at_once = SlippingBrake { brake: FrictionBrake { ramp_s: 0.0, ..brake }, ..on };
        assert_eq!(at_once.torque_n_m(1.0, 1.0), -8.0);
    }

    /// The tangent is the derivative of the torque over the whole range of slip and beyond; the linearised torque is the same line.
    #[test]
    fn tangent_is_the_derivative_of_the_torque() {
        let brake = FrictionBrake { torque_n_m: 8.0, ramp_s: 2.0, slip_rad_s: 0.01 };
        let on = SlippingBrake { from_s: 1.0, ..SlippingBrake::off(brake, 0) };
        for rate_rad_s in [-0.03, -0.004, 0.0, 0.002, 0.007, 0.012, 0.05] {
            let (torque_n_m, damping_n_m_s) = on.torque_and_damping(2.0, rate_rad_s);
            let at = |shift: f64| on.torque_n_m(2.0, rate_rad_s + shift);
            // Richardson extrapolation: steps of 1e-3 of the slip rate have an error of 1e-12
            let slope = |step: f64| (at(step) - at(-step)) / (2.0 * step);
            let difference = (4.0 * slope(5e-6) - slope(1e-5)) / 3.0;
            approx::assert_relative_eq!(damping_n_m_s, -difference, max_relative = 1e-7, epsilon = 1e-8);
            let mut line = on;
            line.linearize(rate_rad_s);
            assert_eq!(line.torque_n_m(2.0, rate_rad_s), torque_n_m);
            approx::assert_relative_eq!(
                line.torque_n_m(2.0, rate_rad_s + 0.5),
                torque_n_m - 0.5 * damping_n_m_s,
                max_relative = 1e-12
            );
        }
    }
}

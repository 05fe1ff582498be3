//! Forces of joints in the search for static equilibrium: latches and stops that are reached, and the load path.

use crate::force::Force;
use crate::force::memory::JointMemory;

impl Force {
    /// Whether the force acts on a joint that moves from rest at `from_rad` to rest at `to_rad` differently than the search for static
    /// equilibrium assumed; the search then restarts from `from_rad`.
    pub fn stops_at_rest(&self, from_rad: &mut f64, to_rad: f64, memory: &mut JointMemory) -> bool {
        match self {
            Self::Latch(latch) => latch.stops_at_rest(from_rad, to_rad, memory),
            Self::EndStops(stops) => stops.stops_at_rest(to_rad, memory),
            each!(
                Motor
                    | Spring
                    | External
                    | Generator
                    | Brake
                    | Prescribed
                    | Lock
                    | Attitude
                    | Slipping
                    | Watch
                    | Borders
            ) => false,
        }
    }

    /// Coordinate at which this force would stop a joint that moves slowly from `from_rad` in a direction, 1 or -1: an enabled latch or an
    /// end stop.
    pub fn ahead_rad(&self, from_rad: f64, direction: f64, memory: &JointMemory) -> Option<f64> {
        match self {
            Self::Latch(latch) => latch.ahead_rad(from_rad, direction, memory),
            Self::EndStops(stops) => stops.ahead_rad(from_rad, direction, memory),
            each!(
                Motor
                    | Spring
                    | External
                    | Generator
                    | Brake
                    | Prescribed
                    | Lock
                    | Attitude
                    | Slipping
                    | Watch
                    | Borders
            ) => None,
        }
    }

    /// Scales the force to a fraction `factor` of `whole`, for a joint that starts at `start_rad`, eq. (L8).
    pub fn scale(&mut self, whole: &Self, start_rad: f64, factor: f64, time_s: f64) {
        let between = |end: f64| start_rad + factor * (end - start_rad);
        match (self, whole) {
            (Self::Motor(motor), Self::Motor(whole)) => {
                motor.scale(whole, between(whole.slew.at(time_s).0), factor);
            }
            (Self::Spring(spring), Self::Spring(whole)) => spring.rest_angle_rad = between(whole.rest_angle_rad),
            (Self::External(external), Self::External(whole)) => external.torque_n_m = factor * whole.torque_n_m,
            (Self::Latch(latch), Self::Latch(whole)) => latch.latch.angle_rad = between(whole.latch.angle_rad),
            (Self::EndStops(stops), Self::EndStops(whole)) => {
                stops.stops.lower_rad = whole.stops.lower_rad.map(between);
                stops.stops.upper_rad = whole.stops.upper_rad.map(between);
            }
            (each!(), _) => {}
        }
    }
}

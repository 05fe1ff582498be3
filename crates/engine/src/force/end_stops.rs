//! Two-sided stops of a joint: a stiff spring and damper beyond each end, which can push but not pull.

use crate::force::latch::CROSSING_S;
pub use crate::force::memory::{Contact, Side};
use crate::force::memory::{JointMemory, Told};
use crate::force::{Here, Moving, Outcome, Place, Push};
use crate::solve::Powers;

/// Parameters of end stops, NOTATION eq. (A8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EndStops {
    /// Lower end of travel in rad; `None` without one.
    pub lower_rad: Option<f64>,
    /// Upper end of travel in rad; `None` without one.
    pub upper_rad: Option<f64>,
    /// Contact stiffness in N·m/rad.
    pub stiffness_n_m_rad: f64,
    /// Contact damping in N·m·s/rad.
    pub damping_n_m_s_rad: f64,
}

/// Depth and speed beyond an end.
#[derive(Debug, Clone, Copy)]
struct Beyond {
    depth_rad: f64,
    rate_rad_s: f64,
}

impl Side {
    /// Sides in the order of their indicators.
    const ALL: [Self; 2] = [Self::Lower, Self::Upper];

    /// Direction of the angle beyond this end.
    fn sign(self) -> f64 {
        match self {
            Self::Lower => -1.0,
            Self::Upper => 1.0,
        }
    }
}

impl Contact {
    fn side(self) -> Option<Side> {
        match self {
            Self::Apart => None,
            Self::Pressed(side) | Self::Leaving(side) => Some(side),
        }
    }
}

impl EndStops {
    /// Depth and speed beyond an end; `None` without one.
    fn beyond(&self, side: Side, angle_rad: f64, rate_rad_s: f64) -> Option<Beyond> {
        let end_rad = match side {
            Side::Lower => self.lower_rad,
            Side::Upper => self.upper_rad,
        }?;
        Some(Beyond { depth_rad: side.sign() * (angle_rad - end_rad), rate_rad_s: side.sign() * rate_rad_s })
    }

    /// Torque of spring and damper divided by the stiffness, rad: positive if they push back.
    fn pressure_rad(&self, beyond: &Beyond) -> f64 {
        beyond.depth_rad + self.damping_n_m_s_rad / self.stiffness_n_m_rad * beyond.rate_rad_s
    }

    /// Contact state for a state of motion.
    fn contact_at(&self, angle_rad: f64, rate_rad_s: f64) -> Contact {
        for side in Side::ALL {
            let Some(beyond) = self.beyond(side, angle_rad, rate_rad_s) else { continue };
            if beyond.depth_rad > 0.0 {
                let pressed = self.pressure_rad(&beyond) > 0.0;
                return if pressed { Contact::Pressed(side) } else { Contact::Leaving(side) };
            }
            if beyond.depth_rad == 0.0 && beyond.rate_rad_s > 0.0 {
                return Contact::Pressed(side);
            }
        }
        Contact::Apart
    }
}

/// End stops with their current contact state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoSidedStops {
    /// Parameters of the stops.
    pub stops: EndStops,
    /// Current contact state.
    pub contact: Contact,
}

impl TwoSidedStops {
    /// Adds torque and tangent of the stop with which the joint is in contact.
    pub fn push(&self, here: &Here, sum: &mut Push) {
        let Contact::Pressed(side) = self.contact else { return };
        let Some(beyond) = self.stops.beyond(side, here.angle_rad, here.rate_rad_s) else { return };
        let EndStops { stiffness_n_m_rad, damping_n_m_s_rad, .. } = self.stops;
        sum.torque_n_m -= side.sign() * (stiffness_n_m_rad * beyond.depth_rad + damping_n_m_s_rad * beyond.rate_rad_s);
        sum.tangent.stiffness += stiffness_n_m_rad;
        sum.tangent.damping += damping_n_m_s_rad;
    }

    /// Energy in J stored in the stop beyond which the joint is.
    pub fn stored_j(&self, angle_rad: f64) -> f64 {
        let beyond = self.contact.side().and_then(|side| self.stops.beyond(side, angle_rad, 0.0));
        beyond.map_or(0.0, |beyond| 0.5 * self.stops.stiffness_n_m_rad * beyond.depth_rad * beyond.depth_rad)
    }

    /// Adds the power dissipated by the damper, and the loss of spring energy if the joint recedes faster than the stop follows.
    pub fn add_powers(&self, here: &Here, powers: &mut Powers) {
        let beyond = self.contact.side().and_then(|side| self.stops.beyond(side, here.angle_rad, here.rate_rad_s));
        let Some(Beyond { depth_rad, rate_rad_s }) = beyond else { return };
        powers.dissipated += match self.contact {
            Contact::Pressed(_) => self.stops.damping_n_m_s_rad * rate_rad_s * rate_rad_s,
            Contact::Apart | Contact::Leaving(_) => -self.stops.stiffness_n_m_rad * depth_rad * rate_rad_s,
        };
    }

    /// Sets the contact state at the start.
    pub fn begin(&self, start: &Moving, memory: &mut JointMemory) {
        memory.contact = self.stops.contact_at(start.angle_rad, start.rate_rad_s);
    }

    /// Distance to a change of the contact with an end, in rad: to the end without contact, to zero torque in contact, to the nearer of
    /// both while receding.
    pub fn distance_rad(&self, indicator: usize, place: &impl Place, memory: &JointMemory) -> f64 {
        let side = Side::ALL[indicator];
        let rate_rad_s = if memory.contact.side() == Some(side) { place.rate_rad_s() } else { 0.0 };
        let Some(beyond) = self.stops.beyond(side, place.angle_rad(), rate_rad_s) else { return f64::INFINITY };
        match memory.contact {
            Contact::Pressed(on) if on == side => self.stops.pressure_rad(&beyond),
            Contact::Leaving(from) if from == side => beyond.depth_rad.min(-self.stops.pressure_rad(&beyond)),
            Contact::Apart | Contact::Pressed(_) | Contact::Leaving(_) => -beyond.depth_rad,
        }
    }

    /// Rate at which that distance decreases, in rad/s.
    pub fn closing_rad_s(&self, indicator: usize, at: &Moving, memory: &JointMemory) -> f64 {
        let side = Side::ALL[indicator];
        let Some(beyond) = self.stops.beyond(side, at.angle_rad, at.rate_rad_s) else { return 0.0 };
        let of_pressure = Beyond { depth_rad: at.rate_rad_s, rate_rad_s: at.acceleration_rad_s2 };
        let by_pressure = match memory.contact {
            Contact::Pressed(on) => on == side,
            Contact::Leaving(from) => from == side && -self.stops.pressure_rad(&beyond) < beyond.depth_rad,
            Contact::Apart => false,
        };
        if by_pressure { self.stops.pressure_rad(&of_pressure).abs() } else { at.rate_rad_s.abs() }
    }

    /// Whether the contact state contradicts the motion by more than the accuracy of locating crossings.
    pub fn is_overdue(&self, indicator: usize, at: &Moving, memory: &JointMemory) -> bool {
        let closing_rad_s = self.closing_rad_s(indicator, at, memory);
        self.distance_rad(indicator, at, memory) < -2.0 * CROSSING_S * closing_rad_s
    }

    /// Changes the contact state at an end.
    pub fn transition(&self, indicator: usize, at: &Moving, memory: &mut JointMemory) -> Outcome {
        let side = Side::ALL[indicator];
        let Some(beyond) = self.stops.beyond(side, at.angle_rad, at.rate_rad_s) else { return Outcome::default() };
        let pressure_rad = self.stops.pressure_rad(&beyond);
        let located_rad = 2.0 * CROSSING_S * beyond.rate_rad_s.abs();
        memory.contact = match memory.contact {
            Contact::Pressed(on) if on == side => {
                if beyond.depth_rad > located_rad {
                    Contact::Leaving(side)
                } else {
                    Contact::Apart
                }
            }
            Contact::Leaving(from) if from == side => {
                if beyond.depth_rad < -pressure_rad {
                    Contact::Apart
                } else {
                    Contact::Pressed(side)
                }
            }
            _ if beyond.depth_rad > located_rad && pressure_rad <= 0.0 => Contact::Leaving(side),
            Contact::Apart | Contact::Pressed(_) | Contact::Leaving(_) => Contact::Pressed(side),
        };
        Outcome { events: 1, ..Outcome::default() }
    }

    /// Performs the transitions due at the end of the current step, if the step ends now.
    pub fn take_inputs(&self, told: &Told, now: &Moving, crossed: u32, memory: &mut JointMemory) -> Outcome {
        let mut outcome = Outcome::default();
        for indicator in (0..2).filter(|i| told.at_end && crossed & (1 << i) != 0) {
            outcome.add(self.transition(indicator, now, memory));
        }
        outcome
    }

    /// End that a joint reaches from `from_rad` in a direction, 1 or -1, unless it is in contact with it.
    pub fn ahead_rad(&self, from_rad: f64, direction: f64, memory: &JointMemory) -> Option<f64> {
        let side = if direction > 0.0 { Side::Upper } else { Side::Lower };
        let beyond = self.stops.beyond(side, from_rad, 0.0)?;
        (memory.contact.side() != Some(side) && beyond.depth_rad <= 0.0)
            .then_some(from_rad - side.sign() * beyond.depth_rad)
    }

    /// Sets the contact state for a static equilibrium at `to_rad`; returns whether it differs from the assumed one.
    pub fn stops_at_rest(&self, to_rad: f64, memory: &mut JointMemory) -> bool {
        let contact = self.stops.contact_at(to_rad, 0.0);
        std::mem::replace(&mut memory.contact, contact) != contact
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::drive::Slew;
    use crate::force::memory::LatchState;

    const STOPS: EndStops =
        EndStops { lower_rad: Some(-1.0), upper_rad: Some(2.0), stiffness_n_m_rad: 50.0, damping_n_m_s_rad: 5.0 };

    fn memory(contact: Contact) -> JointMemory {
        let latch = LatchState { closed: false, enabled: false, time_s: -1.0, count: 0, impulse_n_m_s: 0.0 };
        JointMemory { released: true, latch, crossed: 0, tripped: 0, element: 0, slew: Slew::default(), contact }
    }

    fn moving(angle_rad: f64, rate_rad_s: f64) -> Moving {
        Moving { angle_rad, rate_rad_s, acceleration_rad_s2: 0.0 }
    }

    #[test]
    fn indicators_are_positive_where_the_contact_belongs_to_the_motion() {
        for (angle, rate) in [(0.0, 3.0), (2.1, 1.0), (2.1, -0.5), (2.1, -3.0), (-1.2, -1.0), (-1.2, 1.0), (-1.2, 4.0)]
        {
            let contact = STOPS.contact_at(angle, rate);
            let stops = TwoSidedStops { stops: STOPS, contact };
            for indicator in 0..2 {
                let distance = stops.distance_rad(indicator, &moving(angle, rate), &memory(contact));
                assert!(distance > 0.0, "{contact:?} at {angle} rad, {rate} rad/s: {distance}");
                assert!(!stops.is_overdue(indicator, &moving(angle, rate), &memory(contact)));
            }
        }
    }

    #[test]
    fn contact_follows_the_motion() {
        let stops = TwoSidedStops { stops: STOPS, contact: Contact::Apart };
        let passes = |from: Contact, indicator, at| {
            let mut memory = memory(from);
            assert_eq!(stops.transition(indicator, &at, &mut memory).events, 1);
            memory.contact
        };
        use Side::{Lower, Upper};
        assert_eq!(passes(Contact::Apart, 1, moving(2.0, 3.0)), Contact::Pressed(Upper));
        assert_eq!(passes(Contact::Apart, 0, moving(-1.0, -3.0)), Contact::Pressed(Lower));
        assert_eq!(passes(Contact::Pressed(Upper), 1, moving(2.1, -1.0)), Contact::Leaving(Upper));
        assert_eq!(passes(Contact::Leaving(Upper), 1, moving(2.0, -1.0)), Contact::Apart);
        assert_eq!(passes(Contact::Leaving(Upper), 1, moving(2.1, -1.0)), Contact::Pressed(Upper));
        assert_eq!(passes(Contact::Pressed(Lower), 0, moving(-1.0, 1.0)), Contact::Apart);
        assert_eq!(passes(Contact::Apart, 1, moving(2.1, -9.0)), Contact::Leaving(Upper));
    }

    /// A joint that recedes faster than the stop follows ends this state in two ways: it loses contact, or it slows down until the stop
    /// pushes again.
    #[test]
    fn leaving_ends_where_the_stop_presses_again() {
        let leaving = Contact::Leaving(Side::Upper);
        let stops = TwoSidedStops { stops: STOPS, contact: leaving };
        // 0.1 rad beyond the end; damping divided by stiffness is 0.1 s, so that the stop pushes at rates above -1 rad/s
        let distance = |rate| stops.distance_rad(1, &moving(2.1, rate), &memory(leaving));
        assert!((distance(-3.0) - 0.1).abs() < 1e-15, "to the end: {}", distance(-3.0));
        assert!((distance(-1.5) - 0.05).abs() < 1e-15, "to pressing: {}", distance(-1.5));
        assert!(distance(-1.001) > 0.0 && distance(-0.999) < 0.0, "{} {}", distance(-1.001), distance(-0.999));
        assert!(stops.is_overdue(1, &moving(2.1, -0.9), &memory(leaving)));
    }
}

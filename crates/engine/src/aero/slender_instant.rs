//! Slender bodies in continuous time: loads at one instant, and their derivatives with respect to the motion of the sections and to the
//! air, NOTATION eqs. (W21) and (W22).
//!
//! The limit of the steps of [`SlenderBody::solve`] as they shrink: the momentum of the apparent mass has the rate of the accelerations of the
//! sections at the instant. There are no states.

use crate::aero::flow::Flow;
use crate::aero::slender::{DragPoint, SlenderBody, SlenderBodyState};
use crate::aero::strip::continuous::{Answer, LOAD_ROWS, Variable, displace, kinds_of_loads};
use crate::aero::strip::instant::Instant;
use crate::load::SectionMotion;
use crate::math::corners::slope_off_corners;
use nalgebra::Vector3;
use std::borrow::Cow;

/// Step of a difference relative to the length of a part, a radian, and the speed.
const STEP: f64 = 1e-3;

impl SlenderBody {
    /// Loads of the sections in their own frames at an instant, six rows each, eq. (W21). Without a uniform gust it allocates nothing.
    pub fn respond(&mut self, at: &Instant, answer: &mut [f64]) {
        self.respond_about(at, &[], answer);
    }

    /// Stores the momenta of the last [`SlenderBody::respond`] in a state: steps can continue from there.
    pub fn remember(&self, state: &mut SlenderBodyState) {
        state.copy_from(&self.present);
    }

    /// The same, with the drag linear in the velocities about some points.
    fn respond_about(&mut self, at: &Instant, about: &[[DragPoint; 2]], answer: &mut [f64]) {
        let gusts = at.gusts();
        let flow = Flow { gusts: &gusts, ..at.flow };
        let (mut loads, mut present) = (std::mem::take(&mut self.loads), std::mem::take(&mut self.present));
        loads.clear();
        self.add_flow_loads(&at.motions, &flow, about, &mut present, &mut loads);
        if self.options.apparent_mass {
            self.add_momentum_rates(at, &flow, &mut loads.circulatory);
        }
        for ((load, motion), rows) in
            loads.circulatory.iter().zip(at.motions.iter()).zip(answer.chunks_exact_mut(LOAD_ROWS))
        {
            let turned = motion.rotation.transpose();
            rows[..3].copy_from_slice((turned * load.force_n).as_slice());
            rows[3..].copy_from_slice((turned * load.moment_n_m).as_slice());
        }
        (self.loads, self.present) = (loads, present);
    }

    /// Adds the forces `−ṗ` at the sections, eq. (W21), for a constant wind and a constant angular velocity of the root frame.
    fn add_momentum_rates(&self, at: &Instant, flow: &Flow, loads: &mut [crate::load::Wrench]) {
        let spin_rad_s = flow.spin_rad_s;
        for (inner, frustum) in self.frustums.iter().enumerate() {
            let sections = [inner, inner + 1];
            let (centres_m, along, length_m) = self.axis(inner, &at.motions);
            // velocities and accelerations of the centres relative to the root frame
            let moving = sections.map(|section| {
                let (motion, [acceleration_m_s2, spin_rate]) = (&at.motions[section], &at.accelerations[section]);
                let arm_m = self.arm_m(section, &at.motions);
                let swing_m_s = motion.spin_rad_s.cross(&arm_m);
                let second_m_s2 = acceleration_m_s2 + spin_rate.cross(&arm_m) + motion.spin_rad_s.cross(&swing_m_s);
                (motion.velocity_m_s + swing_m_s, second_m_s2)
            });
            let apart_m_s = moving[1].0 - moving[0].0;
            let along_rate = (apart_m_s - along * along.dot(&apart_m_s)) / length_m;
            let rates_m_s2 = [0, 1].map(|end| {
                let (velocity_m_s, second_m_s2) = moving[end];
                // relative to the air, and the rate of that
                let air_m_s = velocity_m_s - flow.convection_m_s(&centres_m[end]);
                let rate_m_s2 = second_m_s2 + spin_rad_s.cross(&velocity_m_s);
                let part_m_s = along.dot(&air_m_s);
                let across_m_s = air_m_s - along * part_m_s;
                let across_rate_m_s2 =
                    rate_m_s2 - along_rate * part_m_s - along * (along_rate.dot(&air_m_s) + along.dot(&rate_m_s2));
                across_rate_m_s2 + spin_rad_s.cross(&across_m_s)
            });
            let [inner_m3, both_m3, outer_m3] = frustum.volumes_m3;
            let [first, second] = rates_m_s2;
            let rates_m4_s2 = [first * inner_m3 + second * both_m3, first * both_m3 + second * outer_m3];
            for (section, rate_m4_s2) in sections.into_iter().zip(rates_m4_s2) {
                let force_n = rate_m4_s2 * -flow.density_kg_m3;
                loads[section].add_force_at(&self.arm_m(section, &at.motions), &force_n);
            }
        }
    }

    /// Derivative of the loads of [`SlenderBody::respond`], eq. (W22): sixth-order central differences on the scale of the body; exact for
    /// accelerations and rates of the air. The drag is replaced by its tangent, because its second derivative jumps in flow along the axis.
    pub fn slope(&mut self, at: &Instant, variable: Variable) -> Answer {
        let rows = LOAD_ROWS * at.motions.len();
        let Some(step) = self.step(at, variable) else { return vec![0.0; rows] };
        let is_rate = matches!(variable, Variable::AirRate(_) | Variable::Motion { component: 12.., .. });
        let at = if is_rate { Cow::Owned(at.still()) } else { Cow::Borrowed(at) };
        let about = self.drag_points(&at);
        let mut respond = |shift: f64, side: &mut [f64]| {
            let mut beside = at.clone().into_owned();
            match variable {
                Variable::AirRate(component) => pass_on_air_rate(&mut beside, component, shift),
                Variable::Motion { .. }
                | Variable::Lag(_)
                | Variable::Air(_)
                | Variable::FlapAngle(_)
                | Variable::FlapRate(_)
                | Variable::FlapAcceleration(_) => displace(&mut beside, variable, shift),
            }
            self.respond_about(&beside, &about, side);
        };
        if is_rate {
            let mut sides = [(); 2].map(|()| vec![0.0; rows]);
            let [above, below] = &mut sides;
            respond(step, above);
            respond(-step, below);
            return above.iter().zip(below).map(|(above, below)| (above - *below) / (2.0 * step)).collect();
        }
        let mut present = vec![0.0; rows];
        respond(0.0, &mut present);
        slope_off_corners(step, &kinds_of_loads(at.motions.len()), &present, respond)
    }

    /// Velocities of the air relative to the sections of each part, about which the drag is linear.
    fn drag_points(&self, at: &Instant) -> Vec<[DragPoint; 2]> {
        let gusts = at.gusts();
        let flow = Flow { gusts: &gusts, ..at.flow };
        self.drag_points_in(&at.motions, &flow)
    }

    /// The same in a flow.
    pub(super) fn drag_points_in(&self, motions: &[SectionMotion], flow: &Flow) -> Vec<[DragPoint; 2]> {
        let of = |inner: usize| {
            let (_, along, _) = self.axis(inner, motions);
            [inner, inner + 1].map(|section| self.meet(section, &along, motions, flow).drag_point())
        };
        (0..self.frustums.len()).map(of).collect()
    }

    /// Step of the difference. `None` if no air moves, where loads of velocities are of second degree, or if nothing depends on the variable.
    fn step(&self, at: &Instant, variable: Variable) -> Option<f64> {
        let speed_m_s = (0..at.motions.len()).map(|section| {
            let motion = &at.motions[section];
            let arm_m = self.arm_m(section, &at.motions);
            let air_m_s = at.flow.velocity_m_s(&(motion.position_m + arm_m)) + at.gust_m_s;
            (air_m_s - motion.velocity_m_s - motion.spin_rad_s.cross(&arm_m)).norm()
        });
        let speed_m_s = speed_m_s.fold(0.0, f64::max);
        let moving = |step: f64| (speed_m_s > 0.0).then_some(step);
        let body_m: f64 = self.lengths_m.iter().sum();
        match variable {
            Variable::Motion { section, component } => {
                let beside = &self.lengths_m[section.saturating_sub(1)..(section + 1).min(self.lengths_m.len())];
                let part_m = beside.iter().copied().fold(f64::INFINITY, f64::min);
                match component {
                    0..3 => Some(STEP * part_m),
                    3..6 => Some(STEP * part_m / self.arm_m(section, &at.motions).norm().max(part_m)),
                    6..9 => moving(STEP * speed_m_s),
                    9..12 => moving(STEP * speed_m_s / body_m),
                    _ => Some(1.0),
                }
            }
            Variable::Air(component) => match component {
                0..3 | 6..9 => moving(STEP * speed_m_s),
                _ => {
                    let reach_m = at.motions.iter().map(|motion| motion.position_m.norm());
                    moving(STEP * speed_m_s / reach_m.fold(body_m, f64::max))
                }
            },
            Variable::AirRate(_) => Some(1.0),
            Variable::Lag(_) | Variable::FlapAngle(_) | Variable::FlapRate(_) | Variable::FlapAcceleration(_) => None,
        }
    }
}

/// Sets accelerations of the sections that change their velocities relative to the air like a rate of the wind or of the angular velocity of
/// the root frame.
fn pass_on_air_rate(at: &mut Instant, component: usize, rate: f64) {
    let mut axis = Vector3::zeros();
    axis[component % 3] = rate;
    let motions = at.motions.clone();
    for (motion, acceleration) in motions.iter().zip(at.accelerations.to_mut()) {
        *acceleration = match component / 3 {
            0 => [-axis, Vector3::zeros()],
            _ => [axis.cross(&motion.position_m), axis],
        };
    }
}

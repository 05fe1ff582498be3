//! Derivatives of the outputs in time, and with respect to inputs with the state frozen.

use crate::force::drive::Slew;
use crate::force::joint::JointForces;
use crate::math::difference::SIXTH_ORDER;
use crate::signal::{Inputs, Parameters};
use crate::solve::EquationsOfMotion;
use crate::solve::continuation::Taken;
use crate::solve::point::Point;
use crate::study::Study;
use crate::system::PlantError;
use crate::system::equations::Equations;
use crate::system::outputs::Outputs;
use crate::system::state::State;

/// Difference step along the motion: rotation in rad, or displacement divided by the model's length.
const STEP: f64 = 2e-3;
/// Spacing of the five times at which outputs are read for their time derivatives, relative to the internal step.
const SLOPE_SPACING: f64 = 1.0 / 64.0;
/// Step in s of differences in time, on which loads and inputs depend linearly: any step is exact.
const TIME_STEP_S: f64 = 1e-3;

impl Study<'_> {
    /// Rates of all outputs per second at the current time, NOTATION eq. (L13); attitudes contain the rates of their four components.
    ///
    /// They are the time derivatives of the outputs along the current internal step, (T6), with its inputs, limits, latches and aerodynamic
    /// loads. At its end, if a latch closes or inputs jump there, they are the left-sided derivatives; aerodynamic loads are those within
    /// the aerodynamic step, (Q1). At the start of the simulation and right after an event at the current time there is no such step: they
    /// then follow from rates and accelerations, by sixth-order differences along the motion, accurate to 1e-12 of the outputs' scale, and
    /// accelerations are constant.
    pub fn output_rates(&mut self) -> Outputs {
        let rates = if self.system.state.present_step().is_some() {
            self.slopes()
        } else {
            let mut rates = self.system.outputs.no_change();
            let now = &self.system.state.now;
            self.system.equations.forces.linearize(now.time_s, &now.q, &now.v);
            self.add_motion(&mut rates);
            self.system.equations.forces.drop_tangents();
            self.add_time(&mut rates);
            self.add_drives(&mut rates);
            rates
        };
        self.system.show_set_inputs();
        rates
    }

    /// Time derivatives of the outputs along the current internal step, NOTATION eq. (T6): those of the quartics through five times of the
    /// step around the current time.
    fn slopes(&mut self) -> Outputs {
        let mut sum = self.system.outputs.no_change();
        let Some([start, end]) = self.system.state.present_step() else { return sum };
        let now = &self.system.state.now;
        let spacing_s = SLOPE_SPACING * (end.time_s - start.time_s);
        let first_s = (now.time_s - 2.0 * spacing_s).clamp(start.time_s, end.time_s - 4.0 * spacing_s);
        let place = (now.time_s - first_s) / spacing_s;
        let mut there = now.clone();
        for (i, weight) in slopes_of_quartic(place).into_iter().enumerate() {
            let Some([start, end]) = self.system.state.present_step() else { break };
            let stages = &self.system.state.stages;
            let taken = Taken { start, stages, end, continuation: &self.system.continuation };
            taken.fill(&mut there, first_s + i as f64 * spacing_s);
            let beside = self.beside(|state| state.now.copy_from(&there));
            sum.add(&beside, weight / spacing_s);
        }
        self.system.evaluate();
        sum
    }

    /// Adds the change with the coordinates along their rates, and with the rates along the accelerations.
    fn add_motion(&mut self, sum: &mut Outputs) {
        let Point { time_s, q, v, a, .. } = self.system.state.now.clone();
        self.system.equations.residual(time_s, &q, &v, &a, &mut self.system.scratch[0]);
        let (speed_1_s, pull_1_s2) = (self.system.equations.norm(&v), self.system.equations.norm(&a));
        if speed_1_s > 0.0 {
            let step_s = STEP / speed_1_s;
            for (i, weight) in (1..).zip(SIXTH_ORDER) {
                for sign in [1.0, -1.0] {
                    let shift_s = sign * f64::from(i) * step_s;
                    let beside = self.beside(|state| move_along(&mut state.now.q, &v, shift_s));
                    sum.add(&beside, sign * weight / (60.0 * step_s));
                }
            }
        }
        if pull_1_s2 > 0.0 {
            // with linearised forces, outputs are quadratic in the rates: any step is exact
            let step_s = speed_1_s.max(1.0) / pull_1_s2;
            for sign in [1.0, -1.0] {
                let beside = self.beside(|state| move_along(&mut state.now.v, &a, sign * step_s));
                sum.add(&beside, sign * 0.5 / step_s);
            }
        }
        self.system.evaluate();
    }

    /// Adds the change with time itself: aerodynamic loads and time-dependent inputs. Drives are left to [`Self::add_drives`].
    fn add_time(&mut self, sum: &mut Outputs) {
        let now_s = self.system.state.now.time_s;
        for motor in self.system.equations.forces.joints_mut().iter_mut().filter_map(JointForces::motor_mut) {
            let (neutral_rad, before_s) = (motor.slew.at(now_s).0, now_s - 2.0 * TIME_STEP_S);
            motor.slew = Slew { from_rad: neutral_rad, target_rad: neutral_rad, start_s: before_s, ..Slew::default() };
        }
        for sign in [1.0, -1.0] {
            let beside = self.beside(|state| state.now.time_s += sign * TIME_STEP_S);
            sum.add(&beside, sign * 0.5 / TIME_STEP_S);
        }
        self.system.configure();
        self.system.evaluate();
    }

    /// Adds the terms with kinks at limits and at the ends of slews, on the current branch, and the energy accounts.
    fn add_drives(&mut self, sum: &mut Outputs) {
        let now = &self.system.state.now;
        for (i, joint) in self.system.equations.forces.joints().iter().enumerate() {
            let Some(motor) = joint.motor() else { continue };
            let (angle, rate, acceleration) =
                (now.q[joint.coordinate], now.v[joint.coordinate], now.a[joint.coordinate]);
            let (neutral, slew_rate) = motor.slew.at(now.time_s);
            let external_n_m_s = self.system.equations.course.rates.joints()[i].torque_n_m;
            let others_n_m_s = [external_n_m_s, joint.armature_torque_n_m(&now.a)];
            sum.joints_mut()[i].add_drive(joint, now.time_s, [angle, rate, acceleration], others_n_m_s);
            let power_w = motor.drive.slew_power_w(angle, neutral, slew_rate);
            let energy = sum.energy_mut();
            energy.motor += power_w;
            energy.total += power_w;
        }
        let powers = self.system.equations.powers(now.time_s, &now.q, &now.v, &now.a);
        let energy = sum.energy_mut();
        (energy.work, energy.dissipated) = (powers.work, powers.dissipated);
    }

    /// Outputs at a changed state; the state is restored afterwards, the outputs are not.
    fn beside(&mut self, change: impl FnOnce(&mut State)) -> Outputs {
        let kept = self.system.state.now.clone();
        change(&mut self.system.state);
        self.system.evaluate();
        self.system.state.now = kept;
        self.system.outputs.clone()
    }

    /// Derivatives of all outputs with respect to an input at the communication point, NOTATION eq. (L14), about the set inputs and
    /// parameters. `add` adds an amount to the input.
    ///
    /// Coordinates, rates, locks, latches, neutral angles after a rate limit, and aerodynamic loads are constant; accelerations change.
    /// Exact: with the state frozen, all outputs are polynomials of second degree in the inputs, for which central differences have only
    /// round-off. A motor at its limit stays there.
    pub fn output_response(&mut self, add: &dyn Fn(&mut Inputs, f64)) -> Result<Outputs, PlantError> {
        let Point { time_s, q, v, a, .. } = self.system.state.now.clone();
        let mut present = vec![0.0; q.len()];
        self.system.equations.branch_s = time_s;
        self.system.equations.residual(time_s, &q, &v, &a, &mut present);
        let mut slope = self.system.outputs.no_change();
        let mut outcome = Ok(());
        for sign in [1.0, -1.0] {
            let set = self.system.state.inputs.clone();
            self.impose(&set);
            self.system.equations.forces.linearize(time_s, &q, &v);
            let mut varied = set;
            add(&mut varied, sign);
            self.impose(&varied);
            let mut jump = vec![0.0; q.len()];
            self.system.equations.residual(time_s, &q, &v, &a, &mut jump);
            jump.iter_mut().zip(&present).for_each(|(jump, present)| *jump -= present);
            match self.system.equations.factorize(1.0, 0.0, 0.0) {
                Ok(()) => _ = self.system.equations.solve(&mut jump),
                Err(singular) => {
                    outcome = Err(PlantError::Linearization { time_s, cause: singular.to_string() });
                    break;
                }
            }
            let mut beside = self.beside(|state| move_along(&mut state.now.a, &jump, -1.0));
            let energy = beside.energy_mut();
            // a jump of a potential is booked as work of the input
            energy.work += energy.gravity + energy.motor;
            slope.add(&beside, sign * 0.5);
        }
        self.system.equations.forces.drop_tangents();
        self.system.configure();
        self.system.evaluate();
        self.system.show_set_inputs();
        outcome.map(|()| slope)
    }

    /// Sets the equations to the current time with other inputs and the set parameters; neutral angles jump with their commands unless a
    /// rate limit is active.
    fn impose(&mut self, inputs: &Inputs) {
        let State { applied_inputs, applied_parameters, applied_from_s, now, .. } = &self.system.state;
        let kept = (applied_inputs.clone(), applied_parameters.clone(), *applied_from_s);
        let time_s = now.time_s;
        self.system.state.applied_inputs.clone_from(inputs);
        self.system.state.applied_parameters.clone_from(&self.system.state.parameters);
        self.system.state.applied_from_s = time_s;
        self.system.configure();
        (self.system.state.applied_inputs, self.system.state.applied_parameters, self.system.state.applied_from_s) =
            kept;
        self.system.equations.command(time_s, inputs, &self.system.state.parameters);
    }
}

impl Equations {
    /// Sets neutral angles to their commands unless a rate limit is active.
    pub(crate) fn command(&mut self, time_s: f64, inputs: &Inputs, parameters: &Parameters) {
        let limits = parameters.joints().iter().map(|joint| joint.rate_limit_rad_s);
        for ((joint, inputs), rate_limit_rad_s) in self.forces.joints_mut().iter_mut().zip(inputs.joints()).zip(limits)
        {
            let Some(motor) = joint.motor_mut().filter(|motor| !motor.deaf) else { continue };
            motor.slew.redirect(time_s, inputs.command_rad, 0.0, rate_limit_rad_s);
            if motor.slew.follows_at_once() {
                motor.slew.from_rad = inputs.command_rad;
            } else {
                motor.slew.target_rad = motor.slew.from_rad;
            }
        }
    }
}

/// Weights of the values at 0, 1, 2, 3, 4 for the derivative at `x` of the quartic through them.
fn slopes_of_quartic(x: f64) -> [f64; 5] {
    std::array::from_fn(|i| {
        let others = || (0..5).filter(move |&j| j != i);
        let scale: f64 = others().map(|j| i as f64 - j as f64).product();
        let slope = |left: usize| -> f64 { others().filter(|&j| j != left).map(|j| x - j as f64).product() };
        others().map(slope).sum::<f64>() / scale
    })
}

/// `x += amount · direction`.
fn move_along(x: &mut [f64], direction: &[f64], amount: f64) {
    x.iter_mut().zip(direction).for_each(|(x, direction)| *x += amount * direction);
}

#[cfg(test)]
mod tests {
    use crate::machine::{Body, Joint, Machine};
    use crate::run::Plant;
    use nalgebra::{Matrix3, Vector3};
    use std::sync::Arc;

    /// The start of a free rotation at 3 rad/s about the y axis, from 0.4 rad, of a point at 0.7 m: the rate of its position is its
    /// velocity, and the rate of the velocity is `−ω² r`, without loads. Sixth-order differences over an angle of 2e-3 rad have an error of
    /// 1e-12.
    #[test]
    fn rates_at_the_start_of_a_turn_are_those_of_a_circle() {
        const SPEED_RAD_S: f64 = 3.0;
        let machine = Machine::builder("Turning")
            .body(
                Body::rigid("arm").inertia(1.0, [0.0; 3], Matrix3::identity()),
                Joint::revolute("hinge", [0.0, 1.0, 0.0]).start_angle_rad(0.4).start_rate_rad_s(SPEED_RAD_S),
            )
            .body(Body::rigid("hand"), Joint::clamped("grip").on("arm").offset_m([0.7, 0.0, 0.0]))
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let hand = plant.outputs().stations()[1];
        assert!((hand.position_m - 0.7 * Vector3::new(0.4f64.cos(), 0.0, -0.4f64.sin())).norm() < 1e-15);
        let rates = plant.study().output_rates();
        let rate = rates.stations()[1];
        assert!((rate.position_m - hand.velocity_m_s).norm() < 1e-11, "{} {}", rate.position_m, hand.velocity_m_s);
        let towards_m_s2 = -SPEED_RAD_S.powi(2) * hand.position_m;
        assert!((rate.velocity_m_s - towards_m_s2).norm() < 1e-11, "{} {towards_m_s2}", rate.velocity_m_s);
        assert!((rates.joints()[0].angle_rad - SPEED_RAD_S).abs() < 1e-11);
    }
}

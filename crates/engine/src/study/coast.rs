//! Equilibria of hinges with only aerodynamic stiffness: a fold angle at which the moments of lift and weight about the hinge balance.
//!
//! [`crate::system::System::settle_in_air`] iterates between a structure in equilibrium under constant loads and the flow around it. A
//! hinge without spring has no equilibrium under constant loads. Here its angle is an outer unknown instead: the hinge is held at each
//! angle, flow and structure are solved together, and the remaining torque on the hinge is reduced to zero, NOTATION eq. (Q6).

use crate::solve::EquationsOfMotion;
use crate::solve::equilibrium::Effort;
use crate::study::Study;
use crate::study::statics::Holding;
use crate::system::PlantError;
use nalgebra::{DMatrix, DVector};
use std::ops::AddAssign;

/// Step of the central differences for a hinge in rad, if its torque derivatives are differences; for a prismatic joint, displacement
/// divided by the model's length. The derivatives are accurate to 1e-6: aerodynamic loads vary over tenths of a rad, and are accurate to
/// 1e-9 at equilibrium.
const STEP_RAD: f64 = 1e-3;
/// Largest step of a hinge in one iteration in rad, or of a prismatic joint divided by the model's length: aerodynamic loads change sign
/// within a few tenths.
const LONGEST_RAD: f64 = 0.2;
/// Correction in rad, or displacement divided by the model's length, below which the angles and positions have converged.
const TOLERANCE_RAD: f64 = 1e-8;
/// Maximum number of iterations: with the largest step, two revolutions.
const MAXIMUM_ITERATIONS: usize = 60;

impl Study<'_> {
    /// Hinges that rotate freely at the current state, by their index in the equations.
    pub(crate) fn free_hinges(&self) -> Vec<usize> {
        let joints = self.system.equations.forces.joints().iter().enumerate();
        joints.filter(|(_, joint)| !joint.held && !joint.is_latched()).map(|(i, _)| i).collect()
    }

    /// Finds the aeroelastic equilibrium with the angles of `hinges` as outer unknowns, NOTATION eq. (Q6). A joint whose equilibrium lies
    /// beyond its enabled latch is captured by it, as in [`crate::system::System::settle_at_rest`].
    pub(crate) fn coast(&mut self, time_s: f64, hinges: &[usize]) -> Result<Effort, PlantError> {
        let mut start = self.system.state.now.q.clone();
        let joints = self.system.state.joints.clone();
        let mut angles = self.angles(hinges);
        let at = |study: &mut Self, start: &[f64], angles: &DVector<f64>| {
            study.system.state.now.q.copy_from_slice(start);
            study.system.state.joints.copy_from_slice(&joints);
            study.system.configure();
            for (angle, &hinge) in angles.iter().zip(hinges) {
                study.system.state.now.q[study.system.equations.forces.joints()[hinge].coordinate] =
                    *angle * study.scale(hinge);
            }
            let settled = study.settle_with_air(time_s, Holding::Stopped);
            settled.map_err(|error| study.with_held(error, hinges, angles))
        };
        let mut largest_n_m = f64::NAN;
        for _ in 0..MAXIMUM_ITERATIONS {
            let effort = at(self, &start, &angles)?;
            let torque = self.hinge_torques(time_s, hinges);
            largest_n_m = torque.amax();
            let slopes = match self.hinge_slopes(hinges) {
                Some(slopes) => slopes,
                None => {
                    let mut slopes = DMatrix::zeros(hinges.len(), hinges.len());
                    // both sides of the difference start from the same flow, as does the next angle
                    let air = self.system.state.air.clone();
                    for column in 0..hinges.len() {
                        for sign in [1.0, -1.0] {
                            let mut beside = angles.clone();
                            beside[column] += sign * STEP_RAD;
                            at(self, &start, &beside)?;
                            let share = self.hinge_torques(time_s, hinges) * (sign / (2.0 * STEP_RAD));
                            slopes.column_mut(column).add_assign(&share);
                            self.system.state.air.clone_from(&air);
                        }
                    }
                    slopes
                }
            };
            let Some(change) = downhill(&slopes, &torque) else { break };
            self.quest.corrections_rad.push(change.amax());
            if change.amax() <= TOLERANCE_RAD {
                angles += change;
                at(self, &start, &angles)?;
                return if self.caught(hinges, &mut start, &angles) {
                    let caught = self.system.state.joints.clone();
                    self.system.state.now.q.copy_from_slice(&start);
                    self.system.state.joints.copy_from_slice(&caught);
                    self.system.configure();
                    self.settle_in_air(time_s, Holding::AsReleased)
                } else {
                    Ok(effort)
                };
            }
            let share = (LONGEST_RAD / change.amax()).min(1.0);
            angles += change * share;
        }
        Err(self.no_coasting(time_s, hinges, &angles, largest_n_m))
    }

    fn angles(&self, hinges: &[usize]) -> DVector<f64> {
        let angle = |hinge: &usize| {
            self.system.state.now.q[self.system.equations.forces.joints()[*hinge].coordinate] / self.scale(*hinge)
        };
        DVector::from_iterator(hinges.len(), hinges.iter().map(angle))
    }

    /// Unit of the unknown: 1 rad, or the model's length in m for a prismatic joint.
    pub(super) fn scale(&self, hinge: usize) -> f64 {
        let slides = self.system.equations.model.bodies[self.system.equations.forces.joints()[hinge].body]
            .joint
            .kind
            .translations()
            > 0;
        if slides { self.system.equations.model.reference_length_m } else { 1.0 }
    }

    /// Torques in N·m required to hold free hinges in static equilibrium, minus those of their motors; for prismatic joints the force
    /// multiplied by the model's length.
    fn hinge_torques(&mut self, time_s: f64, hinges: &[usize]) -> DVector<f64> {
        let zero = vec![0.0; self.system.state.now.q.len()];
        let mut still = zero.clone();
        self.system.equations.stand(&mut still);
        self.system.equations.residual(time_s, &self.system.state.now.q, &still, &zero, &mut self.system.scratch[0]);
        let torque = |hinge: &usize| {
            self.system.scratch[0][self.system.equations.forces.joints()[*hinge].coordinate] * self.scale(*hinge)
        };
        DVector::from_iterator(hinges.len(), hinges.iter().map(torque))
    }

    /// Exact derivatives of [`Study::hinge_torques`] in an established flow around strips, from the static aeroelastic stiffness, with all
    /// other coordinates following the hinges: NOTATION eq. (Q6). `None` for other aerodynamic models, whose derivatives are computed by
    /// differences.
    fn hinge_slopes(&mut self, hinges: &[usize]) -> Option<DMatrix<f64>> {
        let air = self.system.machine.air.as_ref()?;
        if self.system.has_linear_lattice() || air.rotors().next().is_some() || !air.established {
            return None;
        }
        // static equations, for any rates at the start
        let kept = self.system.state.now.clone();
        self.system.equations.stand(&mut self.system.state.now.v);
        self.system.state.now.a.fill(0.0);
        let stiffness = self.lagged(false).ok().and_then(|(lagged, _)| lagged.rest_stiffness());
        self.system.state.now = kept;
        let (stiffness, freedoms) = (stiffness?, self.system.freedoms());
        let coordinate = |hinge: &usize| self.system.equations.forces.joints()[*hinge].coordinate;
        let place = |hinge: &usize| freedoms.iter().position(|freedom| freedom.index == coordinate(hinge));
        let own: Vec<usize> = hinges.iter().map(place).collect::<Option<_>>()?;
        let rest: Vec<usize> = (0..freedoms.len()).filter(|i| !own.contains(i)).collect();
        let part = |rows: &[usize], columns: &[usize]| stiffness.select_rows(rows).select_columns(columns);
        let follow = part(&rest, &rest).lu().solve(&part(&rest, &own))?;
        let mut slopes = part(&own, &own) - part(&own, &rest) * follow;
        for (i, one) in hinges.iter().enumerate() {
            slopes.row_mut(i).scale_mut(self.scale(*one));
            slopes.column_mut(i).scale_mut(self.scale(*one));
        }
        slopes.iter().all(|entry| entry.is_finite()).then_some(slopes)
    }

    /// Applies latches and stops to the joints between the angles of `start` and those of the equilibrium; returns whether any engages.
    fn caught(&mut self, hinges: &[usize], start: &mut [f64], to: &DVector<f64>) -> bool {
        let mut any = false;
        for (&hinge, to) in hinges.iter().zip(to) {
            let to_rad = *to * self.scale(hinge);
            let joint = &self.system.equations.forces.joints()[hinge];
            any |= joint.stops_at_rest(&mut start[joint.coordinate], to_rad, &mut self.system.state.joints[hinge]);
        }
        any
    }

    /// Adds the positions at which the hinges were held to an error of the search with held hinges, whose divergence speed is not that of the
    /// machine.
    fn with_held(&self, error: PlantError, hinges: &[usize], angles: &DVector<f64>) -> PlantError {
        let PlantError::Equilibrium { time_s, reached, tried, cause, diverges_m_s: _ } = error else { return error };
        let cause = format!("{cause}; released joints were held ({})", self.list_of(hinges, angles));
        PlantError::Equilibrium { time_s, reached, tried, cause, diverges_m_s: None }
    }

    /// Names and positions of hinges for messages.
    fn list_of(&self, hinges: &[usize], angles: &DVector<f64>) -> String {
        let list: Vec<String> = hinges
            .iter()
            .zip(angles)
            .map(|(&hinge, angle)| {
                let joint = &self.system.machine.bodies[self.system.equations.forces.joints()[hinge].body].joint;
                match joint.kind.slides() {
                    true => format!("{} at {:.4} m", joint.name, angle * self.scale(hinge)),
                    false => format!("{} at {:.1} deg", joint.name, angle.to_degrees()),
                }
            })
            .collect();
        list.join(", ")
    }

    fn no_coasting(&self, time_s: f64, hinges: &[usize], angles: &DVector<f64>, torque_n_m: f64) -> PlantError {
        let cause = format!(
            "an unbalanced torque of {torque_n_m:.1e} N.m remains on the released hinges in this wind ({}); try a \
             lower speed, lock them (release = false), or stiffen their springs",
            self.list_of(hinges, angles)
        );
        PlantError::Equilibrium { time_s, reached: 0.0, tried: 1.0, cause, diverges_m_s: None }
    }
}

/// Newton's step towards zero torque if the quasi-static motion `θ̇ = −τ` of the hinges is stable, that is if all eigenvalues of the
/// derivatives `S` have positive real parts. Otherwise a step of the same size in the direction of the torques: with `|S|` of the polar
/// decomposition instead of `S`. `None` if `S` is zero or singular.
fn downhill(slopes: &DMatrix<f64>, torque: &DVector<f64>) -> Option<DVector<f64>> {
    if slopes.iter().chain(torque.iter()).any(|entry| !entry.is_finite()) {
        return None;
    }
    let stable = slopes.complex_eigenvalues().iter().all(|value| value.re > 0.0);
    if stable {
        return slopes.clone().lu().solve(&-torque);
    }
    let parts = slopes.clone().svd(false, true);
    let turn = parts.v_t?;
    let scale = parts.singular_values.map(|value| 1.0 / value);
    let change = -(turn.transpose() * DMatrix::from_diagonal(&scale) * turn * torque);
    change.iter().all(|entry| entry.is_finite()).then_some(change)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Body, Joint, Machine};
    use crate::run::Plant;
    use nalgebra::Matrix3;
    use std::sync::Arc;

    /// If no equilibrium is found, the message lists each joint with its coordinate in its unit: angles in degrees, positions, which the
    /// iteration scales by the model's length, in m; and the torque in N.m.
    #[test]
    fn a_message_without_equilibrium_has_angles_in_degrees() {
        let body = |name: &str| Body::rigid(name).inertia(1.0, [0.0; 3], Matrix3::identity());
        let machine = Machine::builder("Two")
            .body(body("a"), Joint::revolute("fold", [0.0, 1.0, 0.0]))
            .body(body("b"), Joint::prismatic("slide", [1.0, 0.0, 0.0]).on("a"))
            .body(body("c"), Joint::revolute("turn", [0.0, 0.0, 1.0]).on("b"))
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        let study = plant.study();
        let hinges = study.free_hinges();
        assert_eq!(hinges, [0, 1, 2]);
        let coordinates = [75f64.to_radians(), 0.25, -2.0];
        let unknowns = hinges.iter().zip(coordinates).map(|(hinge, value)| value / study.scale(*hinge));
        let error = study.no_coasting(1.5, &hinges, &DVector::from_iterator(3, unknowns), 12.0);
        let PlantError::Equilibrium { cause, time_s, .. } = error else { panic!("{error}") };
        assert_eq!(time_s, 1.5);
        let joints = "(fold at 75.0 deg, slide at 0.2500 m, turn at -114.6 deg)";
        assert!(cause.contains(joints) && cause.contains("torque of 1.2e1 N.m"), "{cause}");
    }
}

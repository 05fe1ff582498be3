//! Free-flying models: a steady flight is a static equilibrium in a frame that moves with the model, NOTATION eq. (Q8).

use crate::load::Wrench;
use crate::solve::EquationsOfMotion;
use crate::study::Study;
use crate::study::statics::Holding;
use crate::system::shape::{ModeShape, NodeMotion};
use crate::system::{FlightMode, PlantError, System};
use nalgebra::{Complex, DMatrix, Vector3};

/// Maximum load that may remain on a free joint in equilibrium, relative to the weight of the model or to its largest load; moments are
/// also divided by the model's length. It is a thousand times the tolerance of a trim.
const BALANCED: f64 = 1e-6;

/// Load required to hold a free joint in equilibrium: zero if the model is trimmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlightLoad {
    /// Body attached by the joint.
    pub body: usize,
    /// Force in N, root frame.
    pub force_n: Vector3<f64>,
    /// Moment about the joint in N·m, root frame.
    pub moment_n_m: Vector3<f64>,
}

/// Singular values of the positions of sections, relative to 1 m, below which the sections lie on a line.
const ROUND_OFF: f64 = 1e-9;

/// Difference between an eigenvalue and the angular velocity of a steady turn, relative to the latter, below which the eigenvalue only
/// represents a displacement of the circle.
const CIRCLE: f64 = 1e-3;

impl Study<'_> {
    /// Finds [`Study::equilibrium`] with the free joints held at their initial position; returns the loads that hold them.
    ///
    /// # Errors
    /// If the model with its free joints held has no equilibrium.
    pub fn rest_held_in_flight(&mut self, time_s: f64) -> Result<Vec<FlightLoad>, PlantError> {
        self.come_to_rest(time_s, Holding::AsReleased)?;
        Ok(self.flight_loads(time_s))
    }

    /// Reference force in N for the force balance in flight: the maximum of the model's weight and the loads on it, with moments divided
    /// by the model's length.
    pub fn flight_scale_n(&self) -> f64 {
        let equations = &self.system.equations;
        let weight_n = self.system.mass_kg() * equations.root.apparent_gravity_m_s2().norm();
        let size_n = |load: &Wrench| load.force_n.norm().max(load.moment_n_m.norm() / self.flight_length_m());
        equations.stations.iter().map(size_n).fold(weight_n, f64::max)
    }

    /// Length in m by which [`Study::flight_scale_n`] divides moments.
    pub fn flight_length_m(&self) -> f64 {
        self.system.equations.model.reference_length_m
    }

    /// Loads that hold the free joints in the current equilibrium.
    fn flight_loads(&mut self, time_s: f64) -> Vec<FlightLoad> {
        if !self.system.equations.spatial.iter().any(|joint| joint.flies) {
            return Vec::new();
        }
        let zero = vec![0.0; self.system.state.now.q.len()];
        let mut residual = zero.clone();
        self.system.equations.residual(time_s, &self.system.state.now.q, &zero, &zero, &mut residual);
        let flying = self.system.equations.spatial.iter().filter(|joint| joint.flies);
        let load = flying.map(|joint| {
            let [force_n, moment_n_m] = joint.holding(&residual);
            FlightLoad { body: joint.body, force_n, moment_n_m }
        });
        load.collect()
    }

    /// Returns an error for an equilibrium with a remaining load on a free joint.
    pub(super) fn refuse_unbalanced_flight(&mut self, time_s: f64) -> Result<(), PlantError> {
        for load in self.flight_loads(time_s) {
            let size_n = self.flight_scale_n();
            let FlightLoad { body, force_n, moment_n_m } = load;
            // comparisons written so that NaN counts as unbalanced
            let balanced =
                force_n.norm() <= BALANCED * size_n && moment_n_m.norm() <= BALANCED * size_n * self.flight_length_m();
            if !balanced {
                let joint = self.system.machine.bodies[body].joint.name.clone();
                let (force_n, moment_n_m) = (force_n.norm(), moment_n_m.norm());
                return Err(PlantError::Flight { time_s, joint, force_n, moment_n_m });
            }
        }
        Ok(())
    }
}

/// Assigns each name to only one mode, NOTATION eq. (Q10): the slowest candidate, as elastic modes are faster. Real lateral modes are
/// distinguished by their rates: the slowest of several is the spiral, and a single one is the spiral if it is slower than the dutch roll;
/// of the others, those that decay are roll subsidences.
pub(super) fn tell_lateral_apart(modes: &mut [ModeShape]) {
    let rate = |mode: &ModeShape| mode.eigenvalue_1_s.norm();
    let mut order: Vec<usize> = (0..modes.len()).filter(|&i| modes[i].flight.is_some()).collect();
    order.sort_by(|&i, &j| rate(&modes[i]).total_cmp(&rate(&modes[j])));
    let dutch_roll = order.iter().find(|&&i| modes[i].flight == Some(FlightMode::DutchRoll));
    // a dutch roll that is not among the computed slowest modes is faster than all of them
    let dutch_roll_1_s = dutch_roll.map_or(f64::INFINITY, |&i| rate(&modes[i]));
    let lateral = |mode: &ModeShape| matches!(mode.flight, Some(FlightMode::Spiral | FlightMode::RollSubsidence));
    let real: Vec<usize> = order.iter().copied().filter(|&i| lateral(&modes[i])).collect();
    for (place, &i) in real.iter().enumerate() {
        let spiral = place == 0 && (real.len() > 1 || rate(&modes[i]) < dutch_roll_1_s);
        let decays = modes[i].eigenvalue_1_s.re < 0.0;
        modes[i].flight = if spiral { Some(FlightMode::Spiral) } else { decays.then_some(FlightMode::RollSubsidence) };
    }
    let mut given = Vec::new();
    for i in order {
        match modes[i].flight {
            Some(name) if given.contains(&name) => modes[i].flight = None,
            Some(name) => given.push(name),
            None => {}
        }
    }
}

impl System {
    /// Flight mode represented by a mode of a model with one free joint, if the mode includes the aerodynamics; `None` for other modes
    /// and models.
    pub(super) fn flight_mode(&self, mode: &ModeShape) -> Option<FlightMode> {
        let mut flying = self.equations.spatial.iter().filter(|joint| joint.flies);
        let (Some(joint), None) = (flying.next(), flying.next()) else { return None };
        let wind_m_s = self.state.applied_inputs.wind_m_s();
        let speed_m_s = wind_m_s.norm();
        if self.machine.air.is_none() || mode.is_free() {
            return None;
        }
        // in a steady turn, another point of the circle is also in equilibrium, and it rotates in the root frame
        let spin_rad_s = self.equations.root.angular_velocity_rad_s.norm();
        let around = Complex::new(0.0, spin_rad_s);
        if spin_rad_s > 0.0 && (mode.eigenvalue_1_s - around).norm() < CIRCLE * spin_rad_s {
            return None;
        }
        let ahead = (-wind_m_s).try_normalize(0.0)?;
        let right = self.equations.root.gravity_m_s2.cross(&ahead).try_normalize(0.0)?;
        let down = ahead.cross(&right);
        let complex = |read: &dyn Fn(&NodeMotion) -> Vector3<f64>, body: usize, section: usize| {
            let [re, im] = [&mode.real, &mode.imaginary].map(|part| read(&part[body][section]));
            Vector3::from_fn(|k, _| Complex::new(re[k], im[k]))
        };
        let (displacement, rotation) = (|node: &NodeMotion| node.displacement_m, |node: &NodeMotion| node.rotation_rad);
        let (shift, turn) = (complex(&displacement, joint.body, 0), complex(&rotation, joint.body, 0));
        // mean squares of the sections' displacements due to the best-fitting rigid-body motion, and due to deformation
        let shape = self.shape();
        let origin_m = shape[joint.body][0].position_m;
        let places = shape.iter().enumerate().flat_map(|(body, sections)| (0..sections.len()).map(move |i| (body, i)));
        let places: Vec<(usize, usize)> = places.collect();
        let mut by_rigid = DMatrix::zeros(3 * places.len(), 6);
        let mut moved = DMatrix::zeros(3 * places.len(), 2);
        for (i, &(body, section)) in places.iter().enumerate() {
            by_rigid.fixed_view_mut::<3, 3>(3 * i, 0).fill_with_identity();
            let arm_m = shape[body][section].position_m - origin_m;
            by_rigid.fixed_view_mut::<3, 3>(3 * i, 3).copy_from(&-arm_m.cross_matrix());
            for (k, part) in [&mode.real, &mode.imaginary].into_iter().enumerate() {
                moved.fixed_view_mut::<3, 1>(3 * i, k).copy_from(&part[body][section].displacement_m);
            }
        }
        // for sections on a line the rotation about it is undetermined: the pseudo-inverse sets it to zero
        let fit = by_rigid.clone().svd(true, true).solve(&moved, ROUND_OFF).ok()?;
        let rigid = by_rigid * fit;
        if (moved - &rigid).norm() > rigid.norm() {
            return None;
        }
        let along =
            |axis: &Vector3<f64>, vector: &Vector3<Complex<f64>>| vector.dot(&axis.map(|x| Complex::new(x, 0.0)));
        let per_speed = mode.eigenvalue_1_s / speed_m_s;
        let (roll, pitch, yaw) = (along(&ahead, &turn), along(&right, &turn), along(&down, &turn));
        let (speed, slip, sink) =
            (along(&ahead, &shift) * per_speed, along(&right, &shift) * per_speed, along(&down, &shift) * per_speed);
        let attack = pitch + sink;
        let symmetric = pitch.norm() + speed.norm() + sink.norm();
        let lateral = roll.norm() + yaw.norm() + slip.norm();
        let fast = speed.norm() > attack.norm();
        Some(match (symmetric > lateral, mode.is_real()) {
            (true, false) if fast => FlightMode::Phugoid,
            (true, false) => FlightMode::ShortPeriod,
            (true, true) if mode.eigenvalue_1_s.re > 0.0 => FlightMode::PitchDivergence,
            (true, true) if fast => FlightMode::SpeedSubsidence,
            (true, true) if pitch.norm() > sink.norm() => FlightMode::PitchSubsidence,
            (true, true) => FlightMode::HeaveSubsidence,
            (false, false) => FlightMode::DutchRoll,
            (false, true) if yaw.norm() > roll.norm() => FlightMode::Spiral,
            (false, true) => FlightMode::RollSubsidence,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::load::Wrench;
    use crate::machine::{Body, Joint, Machine};
    use crate::run::Plant;
    use crate::study::Holding;
    use crate::system::PlantError;
    use nalgebra::{Matrix3, Vector3};
    use std::sync::Arc;

    /// A free body of 2 kg is in steady flight only if force and moment are both balanced: not under its weight alone, which has no moment
    /// about the joint, nor under a moment alone, but with a load that balances the weight.
    #[test]
    fn a_steady_flight_is_balanced_in_force_and_in_moment() {
        let weight_n = Vector3::new(0.0, 0.0, 2.0 * 9.81);
        let body = || Body::rigid("body").inertia(2.0, [0.0; 3], Matrix3::identity());
        for (force_n, moment_n_m, told) in [
            (weight_n, 0.0, None),
            (Vector3::zeros(), 0.0, Some([weight_n.z, 0.0])),
            (weight_n * (1.0 + 1e-4), 0.0, Some([1e-4 * weight_n.z, 0.0])),
            (weight_n, 0.5, Some([0.0, 0.5])),
        ] {
            let moment_n_m = Vector3::new(moment_n_m, 0.0, 0.0);
            let machine = Machine::builder("Flying")
                .gravity_m_s2([0.0, 0.0, -9.81])
                .body(body(), Joint::free("flight"))
                .load("lift", "body", 1, Wrench { force_n, moment_n_m })
                .build()
                .unwrap_or_else(|refused| panic!("{refused}"));
            let mut plant = Plant::new(Arc::new(machine));
            plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
            let outcome = plant.study().equilibrium(0.0, Holding::AsReleased);
            match (outcome, told) {
                (Ok(_), None) => {}
                (Err(PlantError::Flight { force_n, moment_n_m, .. }), Some(expected)) => {
                    let off = [force_n - expected[0], moment_n_m - expected[1]];
                    assert!(off.iter().all(|off| off.abs() < 1e-9), "{force_n} N, {moment_n_m} N·m, not {expected:?}");
                }
                (outcome, told) => panic!("{outcome:?} where {told:?} is left"),
            }
        }
    }
}

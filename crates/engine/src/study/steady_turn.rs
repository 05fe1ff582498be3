//! Steady state of a model with a spinning rotor whose loads are the same at every azimuth, so that only the shaft moves.

use crate::multibody::norm::kinematic_norm;
use crate::solve::EquationsOfMotion;
use crate::study::Study;
use crate::study::whirl::scaled_solution;
use crate::system::PlantError;
use crate::system::freedoms::Freedom;
use nalgebra::DVector;

/// Further azimuths in rad at which the state must be the same; no symmetry of a rotor has these angles.
const AZIMUTHS_RAD: [f64; 2] = [0.7, 1.9];
/// Correction divided by the model's length, or in rad, at which the state has converged: aerodynamic loads are balanced to 1e-10 of
/// their magnitude.
const FOUND: f64 = 1e-9;
/// Largest correction.
const LONGEST: f64 = 0.3;
/// Maximum number of corrections.
const MAXIMUM_CORRECTIONS: usize = 100;

impl Study<'_> {
    /// Finds the state of a model with a shaft (given by its body) of given speed in which no other part moves, under gravity, loads and
    /// an established flow at its current azimuth, NOTATION eq. (L40). Returns the difference from the states at other azimuths, divided by
    /// the model's length, or in rad. If it is zero, the state rotates with the rotor and is steady; otherwise it is the initial guess of
    /// a periodic motion.
    ///
    /// # Errors
    /// [`PlantError::Periodic`] if no such state is found: a joint without stiffness, or an aeroelastic coupling that does not converge.
    /// The model is then in the last state of the search.
    pub(crate) fn turn_in_balance(&mut self, shaft: usize, speed_rad_s: f64) -> Result<f64, PlantError> {
        let time_s = self.system.state.now.time_s;
        let refused = |cause: String| PlantError::Periodic { time_s, cause };
        let freedoms = self.system.freedoms();
        let shaft = self.system.equations.model.bodies[shaft].joint.coordinate;
        let now = &mut self.system.state.now;
        now.v.fill(0.0);
        now.a.fill(0.0);
        now.auxiliary.fill(0.0);
        now.v[shaft] = speed_rad_s;
        let mut size = f64::NAN;
        for _ in 0..MAXIMUM_CORRECTIONS {
            let (change, own) = self.correction(time_s, &freedoms).map_err(refused)?;
            size = own;
            if !size.is_finite() {
                break;
            }
            let share = (LONGEST / size).min(1.0);
            let q = &mut self.system.state.now.q;
            q.iter_mut().zip(&change).for_each(|(q, change)| *q += share * change);
            if size <= FOUND {
                return self.swing(time_s, shaft, &freedoms).map_err(refused);
            }
        }
        Err(refused(format!(
            "no steady state at {speed_rad_s} rad/s: the equilibrium of structure and aerodynamics still changes by \
             {size:.1e} (rotation in rad, or displacement divided by the model's length) after {MAXIMUM_CORRECTIONS} \
             corrections"
        )))
    }

    /// Newton's step towards equilibrium under the aerodynamic loads of the current state, and its size.
    fn correction(&mut self, time_s: f64, freedoms: &[Freedom]) -> Result<(Vec<f64>, f64), String> {
        self.system.start_air(time_s).map_err(|error| error.to_string())?;
        let now = &self.system.state.now;
        let mut residual = vec![0.0; now.q.len()];
        self.system.equations.residual(time_s, &now.q, &now.v, &now.a, &mut residual);
        let right = DVector::from_iterator(freedoms.len(), freedoms.iter().map(|freedom| -residual[freedom.index]));
        let mut change = vec![0.0; residual.len()];
        if !freedoms.is_empty() {
            let stiffness = self.moving_stiffness(freedoms);
            let solved =
                scaled_solution(&stiffness, &right).ok_or("the bodies on the rotor's joints have no stiffness")?;
            for (freedom, amount) in freedoms.iter().zip(solved.iter()) {
                change.iter_mut().zip(self.direction(freedom)).for_each(|(sum, unit)| *sum += amount * unit);
            }
        }
        let equations = &mut self.system.equations;
        let size = kinematic_norm(&equations.model, &mut equations.work, &change);
        Ok((change, size))
    }

    /// Largest correction at other azimuths. The state is restored, with the loads at its azimuth.
    fn swing(&mut self, time_s: f64, shaft: usize, freedoms: &[Freedom]) -> Result<f64, String> {
        let kept = self.system.state.now.q.clone();
        let mut swing = 0.0f64;
        for azimuth_rad in AZIMUTHS_RAD {
            self.system.state.now.q[shaft] = kept[shaft] + azimuth_rad;
            let beside = self.correction(time_s, freedoms);
            self.system.state.now.q.copy_from_slice(&kept);
            let (_, size) = beside?;
            swing = if size.is_nan() { f64::INFINITY } else { swing.max(size) };
        }
        self.system.start_air(time_s).map_err(|error| error.to_string())?;
        let state = &mut self.system.state;
        for point in [&mut state.before, &mut state.start, &mut state.ahead] {
            point.copy_from(&state.now);
        }
        self.system.evaluate();
        Ok(swing)
    }
}

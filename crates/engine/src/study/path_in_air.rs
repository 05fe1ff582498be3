//! Equilibria with strips along the path from still air: the dynamic pressure is increased in steps, and Newton's method with the exact
//! aeroelastic tangent corrects each step, NOTATION eq. (Q12).

use crate::multibody::norm::kinematic_norm;
use crate::solve::EquationsOfMotion;
use crate::solve::equilibrium::Effort;
use crate::study::supports::Supports;
use crate::study::whirl::scaled_solution;
use crate::study::{Holding, Study};
use crate::system::PlantError;
use nalgebra::{DMatrix, DVector};

/// Correction in the kinematic norm at which an equilibrium has converged. Newton's method is quadratic down to the accuracy of the
/// aerodynamic derivatives, 1e-9.
const TOLERANCE: f64 = 1e-9;
/// Maximum of the first correction, which is the step along the tangent: follower loads change little over it.
const LONGEST: f64 = 0.25;
/// Fraction of the maximum at which the next step aims.
const GOAL: f64 = 0.7;
/// Largest ratio of a correction to the previous one. A larger one leads to another branch, or diverges.
const CONTRACTION: f64 = 0.5;
/// Maximum number of corrections of one step.
const MAXIMUM_CORRECTIONS: usize = 12;
/// Smallest step of the fraction of the dynamic pressure. Near a limit point the stiffness decreases with the square root of the distance:
/// to one hundredth here.
const SMALLEST_STEP: f64 = 1e-4;
/// Determinant of the stiffness, relative to that in still air, below which the path ends at a limit point.
const SINGULAR: f64 = 0.1;

/// Newton's step towards an equilibrium, and the stiffness from which it was computed.
struct Correction {
    change: Vec<f64>,
    size: f64,
    determinant: Determinant,
}

/// A determinant stored as sign and logarithm, so that it does not overflow or underflow.
#[derive(Clone, Copy)]
struct Determinant {
    logarithm: f64,
    negative: bool,
}

impl Determinant {
    fn of(matrix: &DMatrix<f64>) -> Self {
        let factors = matrix.clone().lu();
        let pivots = factors.u().diagonal();
        let swapped = factors.p().determinant::<f64>() < 0.0;
        Self {
            logarithm: pivots.iter().map(|pivot| pivot.abs().ln()).sum(),
            negative: pivots.iter().filter(|pivot| **pivot < 0.0).count() % 2 == usize::from(!swapped),
        }
    }

    /// Ratio to another determinant.
    fn over(&self, other: &Self) -> f64 {
        let size = (self.logarithm - other.logarithm).exp();
        if self.negative == other.negative { size } else { -size }
    }
}

impl Study<'_> {
    /// Whether the path from still air can be followed: with strips in an established flow, which have an exact tangent.
    pub(super) fn has_path_in_air(&self, holding: Holding) -> bool {
        let Some(air) = &self.system.air else { return false };
        air.continuous.is_some()
            && air.settings.rotors().next().is_none()
            && air.settings.established
            // hinges with only aerodynamic stiffness are outer unknowns, eq. (Q6)
            && (holding == Holding::Stopped || self.free_hinges().is_empty())
    }

    /// Finds the equilibrium along the path from still air, from the initial coordinates in the state, NOTATION eq. (Q12).
    ///
    /// # Errors
    /// If the path ends before the whole dynamic pressure; the error contains the wind speed at its end. The state is then invalid.
    pub(super) fn follow_in_air(&mut self, time_s: f64, holding: Holding) -> Result<Effort, PlantError> {
        let density_kg_m3 = self.system.state.applied_parameters.air_density_kg_m3();
        let followed = self.raise_pressure(time_s, holding, density_kg_m3);
        *self.system.state.applied_parameters.air_density_kg_m3_mut() = density_kg_m3;
        self.system.configure();
        followed
    }

    fn raise_pressure(&mut self, time_s: f64, holding: Holding, density_kg_m3: f64) -> Result<Effort, PlantError> {
        self.system.state.air = None;
        self.system.configure();
        let mut effort = self.settle_at_rest(time_s, holding)?;
        self.system.equations.stand(&mut self.system.state.now.v);
        self.system.state.now.a.fill(0.0);
        let still = self.correction_in_air(time_s, holding, 0.0)?.determinant;
        let (mut reached, mut step, mut determinant) = (0.0_f64, 1.0_f64, still);
        let mut failed = false;
        loop {
            let tried = if reached + step > 1.0 - 1e-12 { 1.0 } else { reached + step };
            let kept = self.system.state.now.q.clone();
            match self.correct_in_air(time_s, holding, tried * density_kg_m3, &mut effort)? {
                Some((found, first)) => {
                    effort.load_steps += 1;
                    (reached, determinant) = (tried, found);
                    if reached == 1.0 {
                        let tree = self.system.equations.model.tree_coordinates();
                        let now = &mut self.system.state.now;
                        // as after a search without air
                        now.q[tree..].copy_from_slice(&now.a[tree..]);
                        return Ok(effort);
                    }
                    // the first correction is proportional to the step; a step that has just failed is not tried again immediately
                    step *= if failed { 1.0 } else { (GOAL * LONGEST / first).clamp(0.5, 2.0) };
                    failed = false;
                }
                None => {
                    self.system.state.now.q.copy_from_slice(&kept);
                    effort.halvings += 1;
                    failed = true;
                    step = 0.5 * (tried - reached);
                    if step < SMALLEST_STEP {
                        return Err(self.end_of_path(time_s, [reached, tried], determinant.over(&still)));
                    }
                }
            }
        }
    }

    /// Newton's method with a given air density from the current state; returns the determinant of the stiffness and the size of the first
    /// correction, or `None` if it diverges.
    fn correct_in_air(
        &mut self,
        time_s: f64,
        holding: Holding,
        density_kg_m3: f64,
        effort: &mut Effort,
    ) -> Result<Option<(Determinant, f64)>, PlantError> {
        let (mut longest, mut first) = (LONGEST, None);
        for _ in 0..MAXIMUM_CORRECTIONS {
            effort.iterations += 1;
            let Correction { change, size, determinant } = self.correction_in_air(time_s, holding, density_kg_m3)?;
            if size.is_nan() || size > longest {
                return Ok(None);
            }
            let first = *first.get_or_insert(size);
            let q = &mut self.system.state.now.q;
            q.iter_mut().zip(&change).for_each(|(q, change)| *q += change);
            let mut rates = [vec![0.0; q.len()], vec![0.0; q.len()]];
            let [v, a] = &mut rates;
            self.system.equations.project(q, v, a);
            if self.system.equations.close_point(&mut self.system.state.now).is_err() {
                return Ok(None);
            }
            if size <= TOLERANCE {
                self.system.start_air(time_s)?;
                return Ok(Some((determinant, first)));
            }
            longest = (CONTRACTION * size).max(TOLERANCE);
        }
        Ok(None)
    }

    fn correction_in_air(
        &mut self,
        time_s: f64,
        holding: Holding,
        density_kg_m3: f64,
    ) -> Result<Correction, PlantError> {
        *self.system.state.applied_parameters.air_density_kg_m3_mut() = density_kg_m3;
        self.system.start_air(time_s)?;
        if holding == Holding::Stopped {
            let joints = self.system.equations.forces.joints_mut().iter_mut();
            joints.filter(|joint| !joint.is_latched()).for_each(|joint| joint.held = true);
        }
        if let Some(supports) = Supports::of(self.system) {
            supports.set(self.system);
        }
        let freedoms = self.system.freedoms();
        let model = &self.system.equations.model;
        let flying = |index: usize| {
            let joints = self.system.equations.spatial.iter().filter(|joint| joint.flies);
            joints.into_iter().any(|joint| model.bodies[joint.body].joint.range().contains(&index))
        };
        // free bodies are held, eq. (Q8)
        let own: Vec<usize> = (0..freedoms.len()).filter(|i| !flying(freedoms[*i].index)).collect();
        let stiffness = self.lagged(false)?.0.rest_stiffness();
        let now = &self.system.state.now;
        let mut residual = vec![0.0; now.q.len()];
        self.system.equations.residual(time_s, &now.q, &now.v, &now.a, &mut residual);
        let right = DVector::from_iterator(own.len(), own.iter().map(|i| -freedoms[*i].gather(&residual)));
        let mut change = vec![0.0; residual.len()];
        let singular = Determinant { logarithm: f64::NEG_INFINITY, negative: false };
        let Some(stiffness) = stiffness else {
            return Ok(Correction { change, size: f64::NAN, determinant: singular });
        };
        let stiffness = stiffness.select_rows(&own).select_columns(&own);
        let Some(solved) = scaled_solution(&stiffness, &right) else {
            return Ok(Correction { change, size: f64::NAN, determinant: singular });
        };
        for (i, amount) in own.iter().zip(solved.iter()) {
            let unit = self.direction(&freedoms[*i]);
            change.iter_mut().zip(unit).for_each(|(sum, unit)| *sum += amount * unit);
        }
        let equations = &mut self.system.equations;
        let size = kinematic_norm(&equations.model, &mut equations.work, &change);
        Ok(Correction { change, size, determinant: Determinant::of(&stiffness) })
    }

    /// Error for a path of equilibria that ends at a fraction of the dynamic pressure.
    fn end_of_path(&self, time_s: f64, [reached, tried]: [f64; 2], determinant: f64) -> PlantError {
        let wind_m_s = self.system.state.wind_at_m_s(time_s).norm();
        let at_m_s = wind_m_s * reached.sqrt();
        let diverges = determinant.abs() < SINGULAR;
        let cause = if diverges {
            format!(
                "the equilibrium path from still air ends at {at_m_s:.2} m/s (requested: {wind_m_s:.2} m/s), where the \
                 aeroelastic stiffness becomes singular: static divergence; the next equilibrium is far away; try a \
                 lower speed, or more stiffness"
            )
        } else {
            format!(
                "the equilibrium path from still air cannot be followed beyond {at_m_s:.2} m/s (requested: \
                 {wind_m_s:.2} m/s), although the aeroelastic stiffness is not singular there; check for discontinuous \
                 loads of a polar, a spring or an end stop"
            )
        };
        PlantError::Equilibrium { time_s, reached, tried, cause, diverges_m_s: diverges.then_some(at_m_s) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aero::polar::{Polar, PolarRow};
    use crate::aero::surface::Profile;
    use crate::beam::profile::Profile as Along;
    use crate::beam::section::{Material, Solid};
    use crate::machine::{Air, Body, Joint, LiftingSurface, Machine};
    use crate::run::Plant;
    use std::sync::Arc;

    /// Ratios of determinants have the correct sign for any row exchanges in the factorisation: the order of the unknowns has no effect.
    #[test]
    fn ratios_of_determinants_have_their_signs() {
        let mut random = fastrand::Rng::with_seed(7);
        for size in 1..=6 {
            let mut negative = 0;
            for _ in 0..40 {
                let [a, b] = [0, 1].map(|_| DMatrix::from_fn(size, size, |_, _| random.f64() - 0.5));
                let expected = a.determinant() / b.determinant();
                let ratio = Determinant::of(&a).over(&Determinant::of(&b));
                // round-off times the condition number of matrices that are far from singular
                assert!((ratio / expected - 1.0).abs() < 1e-9, "{size}: {ratio} for {expected}");
                negative += usize::from(ratio < 0.0);
            }
            assert!((5..35).contains(&negative), "both signs occur: {negative} of 40");
        }
    }

    /// A vane on a shaft of 4.5 N·m/rad with an aerodynamic moment `m(θ)`, from a piecewise linear polar, has equilibria at `θ = m(θ)`:
    /// 0.095 rad on a plateau, and 0.42 rad after a steep rise. The tangent at 0 points to 0.2 rad, beyond the rise, from where the next
    /// correction has the same length and leads to the distant equilibrium. The path from still air leads to the equilibrium on the
    /// plateau.
    #[test]
    fn the_path_does_not_jump_to_another_rest() {
        let corners =
            [(-1.0, -0.025), (-0.1, -0.025), (0.06, 0.095), (0.13, 0.095), (0.17, 0.22), (0.52, 0.5), (1.0, 0.5)];
        let row = |(angle_rad, moment): (f64, f64)| PolarRow { angle_rad, lift: 0.0, drag: 0.0, moment };
        let profile = Profile { polar: Some(Polar { rows: corners.map(row).to_vec() }), ..Profile::THIN };
        let material = Material { youngs_modulus_pa: 7e10, shear_modulus_pa: 3e10, density_kg_m3: 500.0 };
        let shaft = Solid::rectangle(0.1, 0.1, material).with_torsional_rigidity_n_m2(4.5);
        // dynamic pressure of 50 Pa, 0.09 m² times m of chord and 1 m of span: 4.5 N·m
        let machine = Machine::builder("Vane")
            .body(Body::beam("shaft", 1.0, shaft).elements(1), Joint::clamped("wall"))
            .body(
                Body::beam("vane", 1.0, Solid::rectangle(0.3, 0.1, material)).elements(1),
                Joint::clamped("end").on("shaft"),
            )
            .air(Air::strips().density_kg_m3(1.0).wind_m_s([0.0, -10.0, 0.0]).established(true))
            .surface(LiftingSurface::on("vane", 2).chord_m(Along::constant(0.3)).profile(profile))
            .build()
            .unwrap_or_else(|refused| panic!("{refused}"));
        let mut plant = Plant::new(Arc::new(machine));
        plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
        plant.study().follow_in_air(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
        let twist_rad = plant.system_mut().state.now.q[1];
        // the elastic twist of the vane is 1e-5
        assert!((twist_rad - 0.095).abs() < 1e-4, "{twist_rad} rad");
    }
}

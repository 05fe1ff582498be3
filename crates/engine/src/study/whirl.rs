//! Modes of a rotor with constant speed in the fixed frame: forward and backward whirl, collective motions.

use crate::math::strain::{EDGE, FLAP, NAMES};
use crate::multibody::norm::kinematic_norm;
use crate::solve::EquationsOfMotion;
use crate::solve::lagged::LaggedMode;
use crate::solve::linearize::SecondOrder;
use crate::solve::modes::modes_beyond;
use crate::solve::multiblade::{Multiblade, Whirl};
use crate::study::{Rotor, Study};
use crate::system::PlantError;
use crate::system::freedoms::Freedom;
use crate::system::shape::{ModeShape, WhirlShare};
use nalgebra::{DMatrix, DVector};

/// Further azimuths in rad at which the transformed equations must be the same; no symmetry of a rotor has these angles.
const AZIMUTHS_RAD: [f64; 2] = [0.7, 1.9];
/// Allowed difference between the equations at these azimuths, relative to the mass, damping and stiffness of the two coordinates. Rounded
/// angles of a model file cause 1e-7, a blade that is lighter by one per cent 1e-2.
const ISOTROPIC: f64 = 1e-6;
/// Round-off of the stiffness relative to its largest entry, eq. (L10).
const ROUND_OFF: f64 = 1e-10;
/// Correction of the steady state divided by the model's length, or in rad, at which it has converged.
const STEADY: f64 = 1e-10;
/// Largest step towards the steady state.
const LONGEST: f64 = 0.3;
/// Maximum number of iterations.
const MAXIMUM_ITERATIONS: usize = 50;

impl Study<'_> {
    /// The `count` modes of lowest frequency of the model whose rotor rotates at `speed_rad_s`, without loads, gravity, root motion and
    /// aerodynamics, NOTATION eqs. (L25) and (L26). Frequencies are in the fixed frame; shapes are those at the initial angles.
    ///
    /// The state is the steady one: deformed by centrifugal forces, with the torque on the shaft that balances them. A free shaft keeps its
    /// degree of freedom in the modes.
    ///
    /// # Errors
    /// If there is no steady state, or if the equations in the fixed frame change as the rotor rotates: the rotor is not isotropic, or it
    /// has two blades on an anisotropic support. The message names the coordinates.
    ///
    /// Afterwards the model is in the state of [`Study::undeformed`], also after an error.
    pub fn whirl_modes(
        &mut self,
        time_s: f64,
        rotor: &Rotor,
        speed_rad_s: f64,
        count: usize,
    ) -> Result<Vec<ModeShape>, PlantError> {
        self.undeformed(time_s)?;
        let found = self.turning_modes(time_s, rotor, speed_rad_s, count);
        self.undeformed(time_s)?;
        found
    }

    /// Computes the modes of [`Study::whirl_modes`], and leaves the model in the steady state.
    fn turning_modes(
        &mut self,
        time_s: f64,
        rotor: &Rotor,
        speed_rad_s: f64,
        count: usize,
    ) -> Result<Vec<ModeShape>, PlantError> {
        let refused = |cause: String| PlantError::Linearization { time_s, cause };
        if !speed_rad_s.is_finite() {
            return Err(refused(format!("the rotor's speed is {speed_rad_s} rad/s, not a finite number")));
        }
        if let Some(air) = &mut self.system.equations.air {
            air.clear();
        }
        let freedoms = self.system.freedoms();
        let blades = self.blades(rotor, &freedoms).map_err(refused)?;
        let shaft = self.system.equations.model.bodies[rotor.shaft].joint.coordinate;
        self.turn_steadily(shaft, speed_rad_s, &freedoms).map_err(refused)?;
        let seen = self.seen(&blades, 0.0, shaft, speed_rad_s)?;
        for azimuth_rad in AZIMUTHS_RAD {
            let other = self.seen(&blades, azimuth_rad, shaft, speed_rad_s)?;
            self.check_isotropy(&freedoms, [&seen, &other], speed_rad_s).map_err(refused)?;
        }
        let matrices = [&seen.mass, &seen.damping, &seen.stiffness];
        let list = modes_beyond(matrices, count, blades.shift_1_s2(speed_rad_s))
            .map_err(|error| refused(error.to_string()))?;
        let modes = list.into_iter().map(|mode| {
            let shares = blades.shares(&mode.shape, &seen.mass, speed_rad_s);
            let shape = blades.coordinates(&mode.shape, 0.0);
            let mut shape =
                self.mode_shape(LaggedMode { shape, eigenvalue_1_s: mode.eigenvalue_1_s, lag_share: 0.0 }, &freedoms);
            shape.whirl = self.named(&freedoms, rotor, &shares);
            shape
        });
        Ok(modes.collect())
    }

    /// Indices of the blades' coordinates among the degrees of freedom.
    pub(super) fn blades(&self, rotor: &Rotor, freedoms: &[Freedom]) -> Result<Multiblade, String> {
        let of = |bodies: &Vec<usize>| -> Vec<usize> {
            (0..freedoms.len()).filter(|&i| bodies.contains(&self.body_of(&freedoms[i]))).collect()
        };
        let blades: Vec<Vec<usize>> = rotor.blades.iter().map(of).collect();
        for (bodies, blade) in rotor.blades.iter().zip(&blades) {
            if blade.len() != blades[0].len() {
                let name = |bodies: &Vec<usize>| self.system.machine.bodies[bodies[0]].name.clone();
                return Err(format!(
                    "{} has {} degrees of freedom and {} has {}: the blades of a rotor must be equal",
                    name(&rotor.blades[0]),
                    blades[0].len(),
                    name(bodies),
                    blade.len()
                ));
            }
        }
        Ok(Multiblade { blades })
    }

    /// Body to which a degree of freedom belongs, by its strains, shapes or joint.
    fn body_of(&self, freedom: &Freedom) -> usize {
        let bodies = &self.system.equations.model.bodies;
        bodies.iter().rposition(|body| body.joint.coordinate <= freedom.index).unwrap_or(0)
    }

    /// Finds the state in which the shaft rotates at a speed and its parts have no other motion, by Newton's method.
    fn turn_steadily(&mut self, shaft: usize, speed_rad_s: f64, freedoms: &[Freedom]) -> Result<(), String> {
        let others: Vec<Freedom> = freedoms.iter().filter(|freedom| freedom.index != shaft).cloned().collect();
        let now = &mut self.system.state.now;
        now.v.fill(0.0);
        now.a.fill(0.0);
        now.v[shaft] = speed_rad_s;
        let mut residual = vec![0.0; now.q.len()];
        for _ in 0..MAXIMUM_ITERATIONS {
            let now = &self.system.state.now;
            self.system.equations.residual(now.time_s, &now.q, &now.v, &now.a, &mut residual);
            let right = DVector::from_iterator(others.len(), others.iter().map(|freedom| -residual[freedom.index]));
            let mut change = vec![0.0; residual.len()];
            if !others.is_empty() {
                let stiffness = self.moving_stiffness(&others);
                let solved = scaled_solution(&stiffness, &right).ok_or_else(|| {
                    format!("the bodies on the rotor's joints have no stiffness at {speed_rad_s} rad/s: add springs to free joints")
                })?;
                for (freedom, amount) in others.iter().zip(solved.iter()) {
                    change.iter_mut().zip(self.direction(freedom)).for_each(|(sum, unit)| *sum += amount * unit);
                }
            }
            let equations = &mut self.system.equations;
            let size = kinematic_norm(&equations.model, &mut equations.work, &change);
            let share = (LONGEST / size).min(1.0);
            if !size.is_finite() {
                break;
            }
            let q = &mut self.system.state.now.q;
            q.iter_mut().zip(&change).for_each(|(q, change)| *q += share * change);
            if size <= STEADY {
                return Ok(());
            }
        }
        Err(format!(
            "no steady state at {speed_rad_s} rad/s within {MAXIMUM_ITERATIONS} iterations: lower the speed of the rotor"
        ))
    }

    /// The equations in the fixed frame with the rotor rotated by an angle, eq. (L25). The state is restored.
    fn seen(
        &mut self,
        blades: &Multiblade,
        azimuth_rad: f64,
        shaft: usize,
        speed_rad_s: f64,
    ) -> Result<SecondOrder, PlantError> {
        let kept = self.system.state.now.q[shaft];
        self.system.state.now.q[shaft] = kept + azimuth_rad;
        let system = self.second_order();
        self.system.state.now.q[shaft] = kept;
        Ok(blades.transform(&system?, azimuth_rad, speed_rad_s))
    }

    /// Returns an error for equations that change as the rotor rotates.
    fn check_isotropy(
        &self,
        freedoms: &[Freedom],
        [one, other]: [&SecondOrder; 2],
        speed_rad_s: f64,
    ) -> Result<(), String> {
        let n = freedoms.len();
        let root = |i: usize| one.mass[(i, i)].sqrt();
        let pairs = [
            ("inertia", &one.mass, &other.mass, 0.0),
            ("damping", &one.damping, &other.damping, speed_rad_s.abs()),
            ("stiffness", &one.stiffness, &other.stiffness, speed_rad_s * speed_rad_s),
        ];
        for (what, a, b, of_speed) in pairs {
            let own = |i: usize| a[(i, i)].abs() / one.mass[(i, i)] + of_speed;
            let largest = (0..n).map(own).fold(0.0, f64::max);
            let excess = |i: usize, j: usize| {
                let change = (a[(i, j)] - b[(i, j)]).abs() / (root(i) * root(j));
                if change == 0.0 {
                    return 0.0; // without rotation and damping both terms are zero
                }
                change / ((own(i) * own(j)).sqrt() + ROUND_OFF / ISOTROPIC * largest)
            };
            let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            let worst = places.max_by(|a, b| excess(a.0, a.1).total_cmp(&excess(b.0, b.1)));
            if let Some((i, j)) = worst.filter(|&(i, j)| excess(i, j).is_nan() || excess(i, j) > ISOTROPIC) {
                return Err(format!(
                    "the rotor is not isotropic: the {what} between {} and {} in the fixed frame changes by {:.1e} of \
                     its magnitude during a revolution; allowed are three or more equal blades at equal start angles, \
                     or two on a support that does not move",
                    freedoms[i].name,
                    freedoms[j].name,
                    excess(i, j)
                ));
            }
        }
        Ok(())
    }

    /// Names of the moving parts of a mode with participations, largest first; parts of a blade are named without its number.
    pub(super) fn named(
        &self,
        freedoms: &[Freedom],
        rotor: &Rotor,
        shares: &[(usize, Option<Whirl>, f64)],
    ) -> Vec<WhirlShare> {
        let mut list: Vec<WhirlShare> = Vec::new();
        for &(i, whirl, share) in shares {
            let body = self.body_of(&freedoms[i]);
            let part = self.part(&freedoms[i], body, rotor.blades[0].contains(&body));
            match list.iter_mut().find(|known| known.part == part && known.whirl == whirl) {
                Some(known) => known.share += share,
                None => list.push(WhirlShare { part, whirl, share }),
            }
        }
        list.sort_by(|a, b| b.share.total_cmp(&a.share));
        list
    }

    /// Name of the part moved by a degree of freedom: the shape or strain of a body, or a joint.
    fn part(&self, freedom: &Freedom, body: usize, of_blade: bool) -> String {
        let described = &self.system.machine.bodies[body];
        let plain = |name: &str| match of_blade {
            true => name.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned(),
            false => name.to_owned(),
        };
        let model = &self.system.equations.model.bodies[body];
        if let Some(modal) = model.modal.as_ref().filter(|modal| modal.range().contains(&freedom.index)) {
            let (k, flaps) = (freedom.index - modal.coordinate, modal.element.flaps);
            let (strain, number) = if k < flaps { (FLAP, k + 1) } else { (EDGE, k - flaps + 1) };
            return format!("{} {} {number}", plain(&described.name), NAMES[strain].word);
        }
        match NAMES.iter().find(|strain| freedom.name.ends_with(strain.name)) {
            Some(strain) => format!("{} {}", plain(&described.name), strain.word),
            None => plain(&described.joint.name),
        }
    }
}

/// Solution of `A x = b` with the rows and columns scaled by the diagonal; `None` if `A` is singular to round-off.
pub(super) fn scaled_solution(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let n = right.len();
    let scale = |i: usize| 1.0 / matrix[(i, i)].abs().sqrt();
    let scaled = DMatrix::from_fn(n, n, |i, j| matrix[(i, j)] * scale(i) * scale(j));
    if !scaled.iter().all(|entry| entry.is_finite()) {
        return None;
    }
    let lu = scaled.lu();
    if lu.u().diagonal().iter().any(|pivot| pivot.abs() < 1e-13) {
        return None;
    }
    let solved = lu.solve(&DVector::from_fn(n, |i, _| right[i] * scale(i)))?;
    Some(DVector::from_fn(n, |i, _| solved[i] * scale(i)))
}

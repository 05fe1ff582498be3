//! Stiffness by differences of the residual without its elastic part: about moving states, and of machines with sliding joints, NOTATION
//! eqs. (L11), (J18).

use crate::load::Wrench;
use crate::multibody::dynamics::{Damping, Environment};
use crate::multibody::kinematics::Motion;
use crate::solve::Singular;
use crate::study::Study;
use crate::study::linear::{Bare, add_elastic, direction, displaced, pick, select, sixth_order};
use crate::system::equations::Equations;
use crate::system::freedoms::Freedom;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// Pivot of the scaled stiffness below which a motion has no stiffness: the error of the differences.
const NO_STIFFNESS: f64 = 1e-11;

impl Study<'_> {
    /// Derivative of the residual with respect to the coordinates about a moving state.
    pub(super) fn moving_stiffness(&self, freedoms: &[Freedom]) -> DMatrix<f64> {
        let (equations, now) = (&self.system.equations, &self.system.state.now);
        stiffness(equations, &mut Bare::new(self.system), Motion { q: &now.q, v: &now.v, a: &now.a }, freedoms)
    }
}

/// Derivative of the residual with respect to the degrees of freedom: sixth-order differences of the tree, and the stiffness of elements,
/// modal bodies and joints.
fn stiffness(equations: &Equations, bare: &mut Bare, motion: Motion, freedoms: &[Freedom]) -> DMatrix<f64> {
    let stations: &[Wrench] = if equations.loaded { &equations.stations } else { &[] };
    let environment = Environment { root: &equations.root, damping: &equations.damping, stations };
    let columns = freedoms.iter().map(|freedom| {
        let mut at = |steps: f64| {
            let q = displaced(equations, motion.q, freedom, steps * freedom.step);
            pick(&bare.residual(Motion { q: &q, ..motion }, environment), freedoms)
        };
        sixth_order(&mut at, freedom.step)
    });
    let mut matrix = DMatrix::from_columns(&columns.collect::<Vec<_>>());
    let count = motion.q.len();
    let mut springs = DMatrix::zeros(count, count);
    add_elastic(&mut springs, &equations.model, |_, _, _| 1.0);
    for modal in equations.model.bodies.iter().filter_map(|body| body.modal.as_ref()) {
        let (first, modes) = (modal.coordinate, modal.element.modes);
        let own = modal.element.stiffness.view((0, 0), (modes, modes));
        springs.view_mut((first, first), (modes, modes)).copy_from(&own);
    }
    for joint in equations.forces.joints().iter().filter(|joint| !joint.held) {
        springs[(joint.coordinate, joint.coordinate)] += equations.tangents[joint.body].stiffness;
    }
    for joint in equations.forces.spatial() {
        let Some(spring) = joint.attitude() else { continue };
        let (own, rows) = (spring.stiffness(&equations.work), joint.rows());
        for (i, row) in rows.clone().enumerate() {
            for (j, column) in rows.clone().enumerate() {
                springs[(row, column)] += own[(i, j)];
            }
        }
    }
    matrix += select(&springs, freedoms);
    matrix
}

/// The static tangent of a machine with sliding joints as a dense matrix; the elements of the carriages are those of the equations.
pub(super) struct DenseTangent {
    bare: Bare,
    freedoms: Vec<Freedom>,
    /// Factors of the matrix with its rows and columns scaled by `scale`.
    factors: Option<LU<f64, Dyn, Dyn>>,
    scale: DVector<f64>,
    scaled: DMatrix<f64>,
}

impl DenseTangent {
    /// Tangent over the given degrees of freedom without those of bodies in free flight, which are held at rest.
    pub fn new(equations: &Equations, freedoms: Vec<Freedom>) -> Self {
        let flies = |freedom: &Freedom| {
            let held = equations.spatial.iter().filter(|joint| joint.held);
            held.map(|joint| &equations.model.bodies[joint.body].joint)
                .any(|joint| joint.range().contains(&freedom.index))
        };
        let freedoms: Vec<Freedom> = freedoms.into_iter().filter(|freedom| !flies(freedom)).collect();
        let count = freedoms.len();
        Self {
            bare: Bare::of(equations),
            freedoms,
            factors: None,
            scale: DVector::zeros(count),
            scaled: DMatrix::zeros(count, count),
        }
    }

    /// Linearises about the static state `q` with the multiplied mass matrix added, eq. (L15), and factorises. Returns the number of negative
    /// directions of the symmetric part.
    pub fn factorize(&mut self, equations: &Equations, q: &[f64], shift_1_s2: f64) -> Result<usize, Singular> {
        for (own, current) in self.bare.work.slides.iter_mut().zip(&equations.work.slides) {
            own.element = current.element;
        }
        let zero = vec![0.0; q.len()];
        let mut matrix = stiffness(equations, &mut self.bare, Motion { q, v: &zero, a: &zero }, &self.freedoms);
        if shift_1_s2 != 0.0 {
            matrix += self.mass(equations, q, &zero) * shift_1_s2;
        }
        self.scale = DVector::from_iterator(matrix.nrows(), matrix.column_iter().map(|column| column.amax().sqrt()));
        if let Some(still) = self.scale.iter().position(|scale| *scale == 0.0 || !scale.is_finite()) {
            return Err(Singular { coordinate: self.freedoms[still].index });
        }
        self.scaled =
            DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] / (self.scale[i] * self.scale[j]));
        let factors = self.scaled.clone().lu();
        let pivots = factors.u().diagonal();
        if let Some(weak) = pivots.iter().position(|pivot| pivot.abs() < NO_STIFFNESS) {
            return Err(Singular { coordinate: self.freedoms[weak].index });
        }
        self.factors = Some(factors);
        let symmetric = (&self.scaled + self.scaled.transpose()) * 0.5;
        Ok(symmetric.symmetric_eigenvalues().iter().filter(|value| **value < 0.0).count())
    }

    /// Mass matrix at rest.
    fn mass(&mut self, equations: &Equations, q: &[f64], zero: &[f64]) -> DMatrix<f64> {
        let still = vec![Damping::default(); equations.model.bodies.len()];
        let environment = Environment { root: &Default::default(), damping: &still, stations: &[] };
        let rest = pick(&self.bare.residual(Motion { q, v: zero, a: zero }, environment), &self.freedoms);
        let columns = self.freedoms.iter().map(|freedom| {
            let unit = direction(equations, freedom);
            pick(&self.bare.residual(Motion { q, v: zero, a: &unit }, environment), &self.freedoms) - &rest
        });
        DMatrix::from_columns(&columns.collect::<Vec<_>>())
    }

    /// Solves with the last factors: `x` holds the residual and then the changes of the degrees of freedom.
    pub fn solve(&self, x: &mut [f64]) {
        let right = DVector::from_iterator(
            self.freedoms.len(),
            self.freedoms.iter().zip(&self.scale).map(|(freedom, scale)| x[freedom.index] / scale),
        );
        x.fill(0.0);
        let Some(solved) = self.factors.as_ref().and_then(|factors| factors.solve(&right)) else { return };
        for ((freedom, scale), value) in self.freedoms.iter().zip(&self.scale).zip(&solved) {
            x[freedom.index] = value / scale;
        }
    }

    /// Largest difference of the scaled matrix from its transpose.
    pub fn asymmetry(&self) -> f64 {
        (&self.scaled - self.scaled.transpose()).amax()
    }
}

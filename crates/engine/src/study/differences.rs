//! Stiffness by differences of the residual without its elastic part: about moving states, and of machines with sliding joints, NOTATION
//! eqs. (L11), (J18).

use crate::load::{RootMotion, Wrench};
use crate::math::difference::SIXTH_ORDER;
use crate::math::strain::{SHEARED, STRAINS, StrainMatrix};
use crate::multibody::dynamics::{self, Damping, Environment};
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Element, Strained};
use crate::multibody::tangent::Tangent;
use crate::multibody::{Model, Workspace};
use crate::solve::{EquationsOfMotion, Singular};
use crate::system::System;
use crate::system::equations::Equations;
use crate::system::freedoms::Freedom;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// Pivot of the scaled stiffness below which a motion has no stiffness: the error of the differences.
const NO_STIFFNESS: f64 = 1e-11;

/// Derivative of the residual with respect to the degrees of freedom: sixth-order differences of the tree, and the stiffness of elements,
/// modal bodies and joints.
pub(super) fn stiffness(equations: &Equations, bare: &mut Bare, motion: Motion, freedoms: &[Freedom]) -> DMatrix<f64> {
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

/// Change of the coordinates of some equations due to a unit of a degree of freedom.
pub(super) fn direction(equations: &Equations, freedom: &Freedom) -> Vec<f64> {
    let mut unit = vec![0.0; equations.model.coordinates];
    freedom.spread(1.0, &mut unit);
    Tangent::to_coordinates(&equations.model, &equations.work, &mut unit);
    unit
}

/// Coordinates of some equations with a degree of freedom changed by `amount`, in its unit.
pub(super) fn displaced(equations: &Equations, q: &[f64], freedom: &Freedom, amount: f64) -> Vec<f64> {
    let mut q = q.to_vec();
    q.iter_mut().zip(direction(equations, freedom)).for_each(|(q, unit)| *q += amount * unit);
    let (mut v, mut a) = (vec![0.0; q.len()], vec![0.0; q.len()]);
    equations.project(&mut q, &mut v, &mut a);
    q
}

/// The tree without its elastic forces: the remaining terms are smooth in all arguments and of similar magnitude.
pub(super) struct Bare {
    pub model: Model,
    pub work: Workspace,
}

impl Bare {
    /// Residual due to loads on the stations alone.
    pub fn of_loads(&mut self, q: &[f64], zero: &[f64], stations: &[Wrench]) -> Vec<f64> {
        let still = vec![Damping::default(); self.model.bodies.len()];
        let environment = Environment { root: &RootMotion::default(), damping: &still, stations };
        self.residual(Motion { q, v: zero, a: zero }, environment)
    }

    /// Residual due to accelerations alone.
    pub fn of_accelerations(&mut self, q: &[f64], accelerations: &[f64]) -> Vec<f64> {
        let still = vec![Damping::default(); self.model.bodies.len()];
        let environment = Environment { root: &RootMotion::default(), damping: &still, stations: &[] };
        self.residual(Motion { q, v: &vec![0.0; q.len()], a: accelerations }, environment)
    }

    /// Also omits the stiffness of closed loops: only rates, accelerations and loads remain.
    pub fn without_stiffness(system: &System) -> Self {
        let mut bare = Self::new(system);
        for closure in &mut bare.model.closures {
            closure.penalty.stiffness_n_m = 0.0;
        }
        bare
    }

    pub fn new(system: &System) -> Self {
        Self::of(&system.equations)
    }

    /// The tree of some equations, with the carriages of sliding joints in their elements.
    pub fn of(equations: &Equations) -> Self {
        let mut model = equations.model.clone();
        for element in &mut model.elements {
            element.elastic.release();
            if let Some(elastic) = &mut element.sheared {
                elastic.release();
            }
        }
        for modal in model.bodies.iter_mut().filter_map(|body| body.modal.as_mut()) {
            modal.element.stiffness.fill(0.0);
        }
        Self { work: equations.work.clone(), model }
    }

    pub fn residual(&mut self, motion: Motion, environment: Environment) -> Vec<f64> {
        let mut residual = vec![0.0; self.model.coordinates];
        dynamics::residual(&self.model, &mut self.work, motion, environment, &mut residual);
        residual
    }
}

/// Adds the elastic stiffness of all elements, weighted per body.
pub(super) fn add_elastic(matrix: &mut DMatrix<f64>, model: &Model, weight: impl Fn(usize, usize, usize) -> f64) {
    for index in 0..model.bodies.len() {
        match model.bodies[index].sheared {
            false => add_elastic_of::<STRAINS>(matrix, model, index, &weight),
            true => add_elastic_of::<SHEARED>(matrix, model, index, &weight),
        }
    }
}

/// Adds the elastic stiffness of the elements of a body, weighted.
fn add_elastic_of<const N: usize>(
    matrix: &mut DMatrix<f64>,
    model: &Model,
    index: usize,
    weight: &impl Fn(usize, usize, usize) -> f64,
) where
    Element: Strained<N>,
{
    let body = &model.bodies[index];
    let weights = StrainMatrix::<N>::from_fn(|i, j| weight(index, i, j));
    for i in 0..body.elements {
        let element = &model.elements[body.first_element + i];
        let mut add = |columns: &Element, block: &StrainMatrix<N>| {
            let mut view = matrix.view_mut((element.coordinate, columns.coordinate), (N, N));
            view += block.component_mul(&weights);
        };
        add(element, &element.elastic().stiffness);
        if element.elastic().coupling != StrainMatrix::<N>::zeros() {
            add(&model.elements[body.first_element + (i ^ 1)], &element.elastic().coupling);
        }
    }
}

pub(super) fn sixth_order(at: &mut dyn FnMut(f64) -> DVector<f64>, step: f64) -> DVector<f64> {
    let mut slope = (at(1.0) - at(-1.0)) * SIXTH_ORDER[0];
    slope += (at(2.0) - at(-2.0)) * SIXTH_ORDER[1];
    slope += (at(3.0) - at(-3.0)) * SIXTH_ORDER[2];
    slope / (60.0 * step)
}

pub(super) fn pick(vector: &[f64], freedoms: &[Freedom]) -> DVector<f64> {
    DVector::from_iterator(freedoms.len(), freedoms.iter().map(|freedom| freedom.gather(vector)))
}

pub(super) fn select(matrix: &DMatrix<f64>, freedoms: &[Freedom]) -> DMatrix<f64> {
    if freedoms.iter().all(|freedom| freedom.follow.is_empty()) {
        return DMatrix::from_fn(freedoms.len(), freedoms.len(), |i, j| matrix[(freedoms[i].index, freedoms[j].index)]);
    }
    let columns = freedoms.iter().map(|freedom| {
        let mut unit = DVector::zeros(matrix.ncols());
        freedom.spread(1.0, unit.as_mut_slice());
        pick((matrix * unit).as_slice(), freedoms)
    });
    DMatrix::from_columns(&columns.collect::<Vec<_>>())
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

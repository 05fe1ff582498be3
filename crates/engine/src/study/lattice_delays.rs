//! The nonlinear eigenvalue problem of a model with a lattice, NOTATION eq. (L30): the rows of the wake act as delays.

use crate::study::lattice_space::SampledLattice;
use crate::system::air::VELOCITY_WEIGHTS;
use nalgebra::{Complex, DMatrix};

type ComplexMatrix = DMatrix<Complex<f64>>;

/// The nonlinear eigenvalue problem.
pub(super) struct Delays<'a> {
    pub(super) system: &'a SampledLattice,
    /// Responses in the equations of motion, see [`Delays::new`], to the coordinates, to the averaged rates of the aerodynamic model, to
    /// displacements of the wake nodes and to the wake circulations, row by row.
    pub(super) by_place: DMatrix<f64>,
    by_velocity: DMatrix<f64>,
    pub(super) nodes: Vec<DMatrix<f64>>,
    pub(super) wake: Vec<DMatrix<f64>>,
    /// Displacements of the wake's first nodes, due to the coordinates and due to the rates.
    edge_by_place: DMatrix<f64>,
    edge_by_velocity: DMatrix<f64>,
}

/// A complex matrix with separate real and imaginary parts: products of real matrices are far faster than those of complex ones.
#[derive(Clone)]
struct Parts {
    re: DMatrix<f64>,
    im: DMatrix<f64>,
}

impl Parts {
    fn zeros(rows: usize, columns: usize) -> Self {
        Self { re: DMatrix::zeros(rows, columns), im: DMatrix::zeros(rows, columns) }
    }

    /// The sum `one + factor · other`.
    fn sum(one: &DMatrix<f64>, other: &DMatrix<f64>, factor: Complex<f64>) -> Self {
        Self { re: one.zip_map(other, |one, other| one + factor.re * other), im: other * factor.im }
    }

    fn rows(&self, first: usize, count: usize) -> Self {
        Self { re: self.re.rows(first, count).into_owned(), im: self.im.rows(first, count).into_owned() }
    }

    /// Adds the product of two matrices.
    fn add_product(&mut self, left: &Self, right: &Self) {
        self.re.gemm(1.0, &left.re, &right.re, 1.0);
        self.re.gemm(-1.0, &left.im, &right.im, 1.0);
        self.im.gemm(1.0, &left.re, &right.im, 1.0);
        self.im.gemm(1.0, &left.im, &right.re, 1.0);
    }

    /// `factor · self`, as one matrix.
    fn scaled(&self, factor: Complex<f64>) -> ComplexMatrix {
        self.re.zip_map(&self.im, |re, im| factor * Complex::new(re, im))
    }

    fn of(matrix: &ComplexMatrix) -> Self {
        Self { re: matrix.map(|entry| entry.re), im: matrix.map(|entry| entry.im) }
    }
}

/// `Σ factor⁻ʳ matrixᵣ`, `r = 1, 2, …`: terms with a delay of `r` steps.
fn delayed(rows: &[DMatrix<f64>], factor: Complex<f64>, size: (usize, usize)) -> Parts {
    let mut sum = Parts::zeros(size.0, size.1);
    let (back, mut gone) = (factor.inv(), Complex::from(1.0));
    for row in rows {
        gone *= back;
        let entries = sum.re.iter_mut().zip(sum.im.iter_mut()).zip(row.iter());
        entries.for_each(|((re, im), entry)| {
            *re += gone.re * entry;
            *im += gone.im * entry;
        });
    }
    sum
}

impl<'a> Delays<'a> {
    /// The response has one row per coordinate each for half of the circulatory forces and for the impulsive forces over a step, followed
    /// by the circulations at the trailing edge.
    pub(super) fn new(system: &'a SampledLattice) -> Self {
        let SampledLattice { slopes, step_s, by_place, by_velocity, force, .. } = system;
        let (loads, strips, edges) = (6 * slopes.sections, slopes.trailing.len(), 3 * slopes.edges);
        let impulse = force * slopes.impulse.rows(0, loads) / *step_s;
        let n = force.nrows();
        let needed = |response: &DMatrix<f64>| {
            let mut rows = DMatrix::zeros(2 * n + strips, response.ncols());
            rows.rows_mut(0, n).copy_from(&(force * response.rows(slopes.panels, loads) * 0.5));
            rows.rows_mut(n, n).copy_from(&(&impulse * response.rows(0, slopes.panels)));
            rows.rows_mut(2 * n, strips).copy_from(&response.select_rows(&slopes.trailing));
            rows
        };
        let by_row = |response: &DMatrix<f64>, width: usize, count: usize| -> Vec<DMatrix<f64>> {
            let all = needed(response);
            (0..count).map(|row| all.columns(row * width, width).into_owned()).collect()
        };
        Self {
            system,
            by_place: needed(by_place),
            by_velocity: needed(by_velocity),
            nodes: by_row(&slopes.node, edges, slopes.node_rows()),
            wake: by_row(&slopes.wake, strips, slopes.wake_rows),
            edge_by_place: by_place.rows(slopes.edge_row(), edges).into_owned(),
            edge_by_velocity: by_velocity.rows(slopes.edge_row(), edges).into_owned(),
        }
    }

    /// Forces on the coordinates in the step that ends now, per coordinate, for motions that grow by the factor `z` per step; the wake is
    /// delayed with the factor `late`.
    pub(super) fn forces(&self, z: Complex<f64>, late: Complex<f64>) -> Option<ComplexMatrix> {
        let SampledLattice { slopes, step_s, .. } = self.system;
        let one = Complex::from(1.0);
        let [own, earlier, last] = VELOCITY_WEIGHTS;
        let back = z.inv();
        // eq. (Q4)
        let seen = (one - back) / *step_s * (z * own + earlier) / (z - last);
        let mut motion = Parts::sum(&self.by_place, &self.by_velocity, seen);
        let rows = motion.re.nrows();
        // nodes of the wake are former positions of the edge
        if !self.nodes.is_empty() {
            let left = Parts::sum(&self.edge_by_place, &self.edge_by_velocity, seen);
            motion.add_product(&delayed(&self.nodes, late, (rows, left.re.nrows())), &left);
        }
        let strips = slopes.trailing.len();
        let wake = delayed(&self.wake, late, (rows, strips));
        let n = (rows - strips) / 2;
        let trailing = |parts: &Parts| parts.rows(2 * n, strips).scaled(one);
        let shed = (ComplexMatrix::identity(strips, strips) - trailing(&wake)).lu().solve(&trailing(&motion))?;
        motion.add_product(&wake, &Parts::of(&shed));
        Some(motion.rows(0, n).scaled(one + back) + motion.rows(n, n).scaled(one - back))
    }

    /// `z − E + z H Φ(z)`, with the wake delayed by `late`.
    pub(super) fn matrix(&self, z: Complex<f64>, late: Complex<f64>) -> Option<ComplexMatrix> {
        let n = self.by_place.ncols();
        let mut matrix = self.system.held.free.map(|entry| Complex::from(-entry));
        (0..2 * n).for_each(|i| matrix[(i, i)] += z);
        let forces = Parts::of(&self.forces(z, late)?);
        let by_force = &self.system.held.by_force;
        let air = Parts { re: by_force * forces.re, im: by_force * forces.im };
        let mut own = matrix.columns_mut(0, n);
        own += air.scaled(z);
        Some(matrix)
    }
}

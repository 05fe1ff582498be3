//! Damping of a beam by the damping ratios of its modes, NOTATION eqs. (D30) and (D31).
//!
//! The modes are those of the undamped body with its attached masses, clamped at its inner end, without loads, in its natural shape. The
//! damping `Σ 2ζω (Mφ)(Mφ)ᵀ` acts on the rates of the strains of this body alone: it is objective and internal to the body. It has the rank of
//! the number of ratios and is added to the factors of the tree together with the closed loops.

use crate::load::RootMotion;
use crate::multibody::dynamics::{Damping, Environment, residual};
use crate::multibody::joint::{Joint, JointKind};
use crate::multibody::kinematics::Motion;
use crate::multibody::model::{Base, Body, Element, Model};
use crate::multibody::workspace::Workspace;
use nalgebra::{Cholesky, DMatrix, DVector, Matrix3, SymmetricEigen, Vector3};

pub use crate::multibody::damped_mode::DampedMode;

/// Largest number of damped modes of a body: each adds a solution of the tree to a factorisation.
pub const MAXIMUM_DAMPED_MODES: usize = 12;

/// Modes of a clamped body in ascending frequency.
pub struct ClampedModes {
    /// Angular frequencies `ω` in rad/s.
    pub frequencies_rad_s: Vec<f64>,
    /// Momenta `Mφ`, `φᵀMφ = 1`, in columns.
    momenta: DMatrix<f64>,
}

impl Model {
    /// Damps the lowest modes of a body by their ratios, at most one per strain. The masses and stiffnesses must be final.
    pub fn damp_modes(&mut self, body: usize, ratios: &[f64]) {
        if ratios.iter().all(|ratio| *ratio == 0.0) {
            return;
        }
        let Some(modes) = ClampedModes::of(self, body) else { return };
        let first = self.elements[self.bodies[body].first_element].coordinate;
        for (i, ratio) in ratios.iter().enumerate().take(modes.frequencies_rad_s.len()) {
            if *ratio > 0.0 {
                let momenta = modes.momenta.column(i).iter().copied().collect();
                let rate_1_s = 2.0 * ratio * modes.frequencies_rad_s[i];
                self.damped_modes.push(DampedMode { body, first, momenta, rate_1_s });
            }
        }
    }

    /// Model of one body, given by its index, clamped to the root.
    fn clamped(&self, index: usize) -> Self {
        let body = &self.bodies[index];
        let elements = body.first_element..body.first_element + body.elements;
        let first = self.elements[elements.start].coordinate;
        let joint = Joint { kind: JointKind::Clamped, coordinate: 0, drive_inertia: 0.0, drive_carried: 0.0 };
        let own = Body {
            base: Base::Root(Vector3::zeros()),
            mount: Matrix3::identity(),
            offset_m: Vector3::zeros(),
            joint,
            first_node: 0,
            first_element: 0,
            carrier: None,
            ..body.clone()
        };
        let shifted = |element: &Element| Element { coordinate: element.coordinate - first, ..element.clone() };
        let elements: Vec<Element> = self.elements[elements].iter().map(shifted).collect();
        Self {
            coordinates: elements.iter().map(Element::count).sum(),
            sheared: body.sheared,
            bodies: vec![own],
            elements,
            nodes: self.nodes[body.first_node..=body.last_node()].to_vec(),
            stations: Vec::new(),
            closures: Vec::new(),
            rigid_loops: Vec::new(),
            no_slips: Vec::new(),
            damped_modes: Vec::new(),
            slides: Vec::new(),
            circuits: Vec::new(),
            reference_length_m: self.reference_length_m,
        }
    }
}

impl ClampedModes {
    /// Modes of a beam of a model; `None` if its stiffness is not positive definite, which does not occur for validated sections.
    pub fn of(model: &Model, body: usize) -> Option<Self> {
        let own = model.clamped(body);
        let n = own.coordinates;
        let natural = own.natural_coordinates();
        let mut work = Workspace::new(&own);
        let zero = vec![0.0; n];
        let environment = Environment { root: &RootMotion::default(), damping: &[Damping::default()], stations: &[] };
        let mut columns = |strained: bool| {
            let column = |j: usize| {
                let (mut q, mut a, mut forces) = (natural.clone(), zero.clone(), zero.clone());
                if strained {
                    // the elastic forces are linear in the strains, and there are no others without rates
                    q[j] += 1.0;
                } else {
                    a[j] = 1.0;
                }
                residual(&own, &mut work, Motion { q: &q, v: &zero, a: &a }, environment, &mut forces);
                DVector::from_vec(forces)
            };
            let matrix = DMatrix::from_columns(&(0..n).map(column).collect::<Vec<_>>());
            (&matrix + matrix.transpose()) * 0.5
        };
        let (stiffness, mass) = (columns(true), columns(false));
        // Mφ = μKφ with μ = 1/ω²: with K = LLᵀ and y = Lᵀφ, L⁻¹ML⁻ᵀy = μy
        let lower = Cholesky::new(stiffness)?.l();
        let half = lower.solve_lower_triangular(&mass)?;
        let whole = lower.solve_lower_triangular(&half.transpose())?;
        let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(whole);
        let mut order: Vec<usize> = (0..n).filter(|i| eigenvalues[*i] > 0.0).collect();
        order.sort_by(|a, b| eigenvalues[*b].total_cmp(&eigenvalues[*a]));
        // Mφ = μLy, and φᵀMφ = μyᵀy = 1
        let momenta =
            order.iter().map(|i| &lower * eigenvectors.column(*i) * eigenvalues[*i].sqrt()).collect::<Vec<_>>();
        Some(Self {
            frequencies_rad_s: order.iter().map(|i| eigenvalues[*i].sqrt().recip()).collect(),
            momenta: DMatrix::from_columns(&momenta),
        })
    }
}

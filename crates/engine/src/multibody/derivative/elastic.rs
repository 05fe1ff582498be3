//! Stiffness and stiffness-proportional damping of the strains, eq. (D8), and stiffness and damping of modal bodies, eqs. (M5) and (M6):
//! constant, and symmetric but for the damping of modal bodies.

use crate::beam::element::ElementKind;
use crate::math::strain::{SHEARED, STRAINS, Strain, StrainMatrix};
use crate::multibody::Model;
use crate::multibody::dynamics::Damping;
use crate::multibody::model::{Body, Element, Strained};

/// Rows of the products `K x` and `C y` with the stiffness and damping matrices of strains and shapes, one after the other: `add` is called
/// with the row and both values. `TRANSPOSED`: with `Cᵀ`.
pub fn elastic_products<const TRANSPOSED: bool>(
    model: &Model,
    damping: &[Damping],
    x: &[f64],
    y: &[f64],
    mut add: impl FnMut(usize, f64, f64),
) {
    for (body, damping) in model.bodies.iter().zip(damping) {
        if let Some(modal) = &body.modal {
            let (element, range) = (&modal.element, modal.range());
            let viscous =
                |i: usize, j: usize| if TRANSPOSED { element.damping[(j, i)] } else { element.damping[(i, j)] };
            for (i, row) in range.clone().enumerate() {
                let force = range.clone().enumerate().map(|(j, c)| element.stiffness[(i, j)] * x[c]).sum();
                add(row, force, range.clone().enumerate().map(|(j, c)| viscous(i, j) * y[c]).sum());
            }
        }
        match body.sheared {
            false => products_of::<STRAINS>(model, body, damping, (x, y), &mut add),
            true => products_of::<SHEARED>(model, body, damping, (x, y), &mut add),
        }
    }
}

fn products_of<const N: usize>(
    model: &Model,
    body: &Body,
    damping: &Damping,
    (x, y): (&[f64], &[f64]),
    add: &mut impl FnMut(usize, f64, f64),
) where
    Element: Strained<N>,
{
    let elements = &model.elements[body.first_element..body.first_element + body.elements];
    let roots = body.damping_roots.map_or_else(|| Strain::repeat(1.0), |roots| roots.fixed_rows::<N>(0).into_owned());
    for (i, element) in elements.iter().enumerate() {
        let (mut force, mut viscous) = (Strain::<N>::zeros(), Strain::<N>::zeros());
        let mut sum = |block: &StrainMatrix<N>, of: &Element| {
            force += block * Strain::from(of.strains(x));
            viscous += block * roots.component_mul(&Strain::from(of.strains(y)));
        };
        sum(&element.elastic().stiffness, element);
        if body.kind == ElementKind::Linear {
            sum(&element.elastic().coupling, &elements[i ^ 1]);
        }
        let viscous = roots.component_mul(&viscous) * damping.stiffness_s;
        for (j, row) in element.range().enumerate() {
            add(row, force[j], viscous[j]);
        }
    }
}

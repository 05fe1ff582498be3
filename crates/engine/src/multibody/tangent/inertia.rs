//! Stability from the factors: the number of negative pivots, and whether the loads have a potential.

use crate::multibody::Model;
use crate::multibody::tangent::Tangent;
use crate::multibody::tangent::elimination::Factor;
use crate::multibody::tangent::links::{strains_of, stride};
use nalgebra::{Const, DimMin};

impl Tangent {
    /// Number of negative eigenvalues of the tangent in the last factorisation, eq. (L16): unstable directions. Every elimination leaves
    /// its Schur complement, so the numbers of the pivot blocks add up (Sylvester's law of inertia); closed loops contribute as a border.
    /// Exact for a symmetric tangent, which loads with a potential have.
    pub fn negative_directions(&self) -> usize {
        let released = self.rigid.as_ref().map_or(0, |rigid| rigid.negative);
        self.negative_without_constraints().saturating_sub(released)
    }

    /// [`Self::negative_directions`] with the support in place of the constraints of rigid loops.
    fn negative_without_constraints(&self) -> usize {
        let blocks = self.plain.factors.iter().chain(&self.joint_factors).chain(&self.modal_factors).flatten();
        let sheared = self.sheared.factors.iter().flatten().map(|factor| factor.negative);
        let tree: usize = blocks.map(|factor| factor.negative).chain(sheared).sum();
        let Some(coupling) = &self.coupling else { return tree };
        let stiff = self.closures.iter().filter(|closure| closure.stiffness_n_m > 0.0).count();
        // each closure without stiffness contributes six eigenvalues of 1
        let slack = 6 * (self.closures.len() - stiff);
        (tree + coupling.positive).saturating_sub(3 * stiff + slack)
    }

    /// Largest `|uᵀKv − vᵀKu|` relative to `|u||Kv|` for some vectors, in coordinates scaled to unit pivots: at the level of round-off for
    /// loads with a potential. The factors of the same configuration must be current.
    pub fn asymmetry(&mut self, model: &Model) -> f64 {
        let scale = self.scales(model);
        let n = model.coordinates;
        let vector = |seed: usize| -> Vec<f64> {
            (0..n).map(|i| scale[i] * (1.0 + (i * i % 97 + seed * (i % 31)) as f64).sin()).collect()
        };
        let (mut largest, mut products) = (0.0f64, Vec::new());
        for seed in 0..SAMPLES {
            let x = vector(seed);
            let mut y = vec![0.0; n];
            self.apply(model, &x, &mut y);
            products.push((x, y));
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let size = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a * b).abs()).sum::<f64>();
        for (i, (u, ku)) in products.iter().enumerate() {
            for (v, kv) in &products[..i] {
                let scatter = size(u, kv).max(size(v, ku));
                if scatter > 0.0 {
                    largest = largest.max((dot(u, kv) - dot(v, ku)).abs() / scatter);
                }
            }
        }
        largest
    }

    /// Scale of each coordinate: the inverse square root of its pivot's magnitude; zero for held ones.
    fn scales(&self, model: &Model) -> Vec<f64> {
        let mut scale = vec![0.0; model.coordinates];
        for (index, body) in model.bodies.iter().enumerate() {
            let joint = &self.joints[index];
            if let Some(factor) = &self.joint_factors[index] {
                spread(factor, &mut scale[joint.coordinate..joint.coordinate + joint.freedoms]);
            }
            if let (Some(modal), Some(factor)) = (&self.modal[index], &self.modal_factors[index]) {
                spread(factor, &mut scale[modal.coordinate..modal.coordinate + modal.modes]);
            }
            for e in body.first_element..body.first_element + body.elements {
                let own = strains_of(model, e, stride(body).min(body.first_element + body.elements - e));
                if body.sheared {
                    self.sheared.factors[e].iter().for_each(|factor| spread(factor, &mut scale[own.clone()]));
                } else {
                    self.plain.factors[e].iter().for_each(|factor| spread(factor, &mut scale[own.clone()]));
                }
            }
        }
        scale
    }
}

/// Number of vectors that [`Tangent::asymmetry`] compares in pairs.
const SAMPLES: usize = 4;

fn spread<const U: usize>(factor: &Factor<U>, scale: &mut [f64])
where
    Const<U>: DimMin<Const<U>, Output = Const<U>>,
{
    scale.iter_mut().zip(factor.scale.iter()).for_each(|(to, from)| *to = *from);
}

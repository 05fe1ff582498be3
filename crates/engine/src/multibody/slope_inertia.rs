//! Inertia of an element with shear in the matrix of the accelerations, NOTATION eqs. (D10), (D11), (D19) and (D20).

use crate::multibody::model::Element;
use crate::multibody::node::{ArticulatedInertia, Node};
use crate::multibody::slope::inner_mass;
use crate::multibody::slope_vector::Slope;
use nalgebra::{Matrix3, Matrix4, Vector3};
use std::array::from_fn;

/// Inertia of one end, or between both ends, in twist form.
pub(super) struct Lump {
    pub mass: f64,
    /// First moments `Σ m_0k r_k` of the inner and the outer end; equal for one end.
    pub first: [Vector3<f64>; 2],
    /// `Σ m_kl r_k r_lᵀ`.
    pub spread: Matrix3<f64>,
}

impl Lump {
    /// Adds the inertia of one end, eq. (D10).
    #[inline(always)]
    pub fn add_to(&self, inertia: &mut ArticulatedInertia) {
        let [x, y, z] = [self.first[0].x, self.first[0].y, self.first[0].z];
        let trace = self.spread.trace();
        inertia.ww -= self.spread;
        for i in 0..3 {
            inertia.vv[(i, i)] += self.mass;
            inertia.ww[(i, i)] += trace;
        }
        for (place, moment) in [((0, 1), z), ((1, 2), x), ((2, 0), y)] {
            inertia.vw[place] += moment;
            inertia.vw[(place.1, place.0)] -= moment;
        }
    }
}

/// Coupling of the twist of one end with the linear strains: momentum and angular momentum per rate of each strain.
pub(super) struct Coupling {
    pub velocity: [Vector3<f64>; 3],
    pub spin: [Vector3<f64>; 3],
}

/// Inertia of an element in its linear strains and the twists of its ends, times a weight.
pub(super) struct SlopeInertia {
    /// Inertias of the inner and outer ends, eq. (D10) with the slope in place of `r_x`.
    pub lumps: [Lump; 2],
    /// Inertia that couples the twists of both ends, eq. (D11).
    pub cross: Lump,
    /// Couplings `H_{aε}` and `H_{bε}` of the inner and outer ends, eq. (D19).
    pub couplings: [Coupling; 2],
    /// Inertia `H_{εε}` of the strains.
    pub own: Matrix3<f64>,
}

impl SlopeInertia {
    /// Inertia of an element between two nodes, times `scale`; `relative` is the rotation of the outer end in the frame of the inner one.
    /// `SLIM`: the mass couples only `r` and `d`.
    #[inline(always)]
    pub fn new<const SLIM: bool>(
        element: &Element,
        (nodes, slopes): (&[Node], &[Slope; 2]),
        relative: &Matrix3<f64>,
        scale: f64,
    ) -> Self {
        let own = [inner_mass(element), &element.outer_mass];
        let cross = &element.cross_mass;
        let entry = |mass: &Matrix4<f64>, i: usize, j: usize| mass[(i, j)] * scale;
        let axes: [Matrix3<f64>; 2] = from_fn(|end| slopes[end].axes(&nodes[end]));
        let rotations = [&nodes[0].rotation, &nodes[1].rotation];
        // Σ m_k r_k of an end
        let along = |end: usize, mass: [f64; 3]| match SLIM {
            true => slopes[end].vector * mass[0],
            false => axes[end] * Vector3::from(mass),
        };
        // Σ m_kl r_k r_lᵀ with r_k of the first end and r_l of the second
        let spread = |mass: &Matrix4<f64>, [first, second]: [usize; 2]| {
            let weighted: [Vector3<f64>; 3] = from_fn(|l| match SLIM {
                true => axes[first].column(l) * entry(mass, l + 1, l + 1),
                false => axes[first] * Vector3::from_fn(|k, _| entry(mass, l + 1, k + 1)),
            });
            let by = &axes[second];
            let columns: [Vector3<f64>; 3] =
                from_fn(|j| weighted[0] * by[(j, 0)] + weighted[1] * by[(j, 1)] + weighted[2] * by[(j, 2)]);
            Matrix3::from_columns(&columns)
        };
        let lumps = from_fn(|end| {
            let mass = own[end];
            let first = along(end, from_fn(|k| entry(mass, 0, k + 1)));
            Lump { mass: entry(mass, 0, 0), first: [first; 2], spread: spread(mass, [end; 2]) }
        });
        let cross_first =
            [along(0, from_fn(|k| entry(cross, 0, k + 1))), along(1, from_fn(|k| entry(cross, k + 1, 0)))];
        let origins = [entry(cross, 1, 0), entry(cross, 0, 1)];
        let column = |end: usize, k: usize| rotations[end].fixed_view::<3, 1>(0, k).into_owned();
        let couplings = from_fn(|end| {
            let other = 1 - end;
            let velocity = from_fn(|k| column(end, k) * entry(own[end], 0, 1) + column(other, k) * origins[end]);
            let spin = match SLIM {
                true => {
                    let [within, across] = [entry(own[end], 1, 1), entry(cross, 1, 1)];
                    from_fn(|k| slopes[end].vector.cross(&(column(end, k) * within + column(other, k) * across)))
                }
                false => {
                    let within = along(end, from_fn(|k| entry(own[end], k + 1, 1)));
                    let across = match end {
                        0 => along(0, from_fn(|l| entry(cross, 1, l + 1))),
                        _ => along(1, from_fn(|k| entry(cross, k + 1, 1))),
                    };
                    from_fn(|k| within.cross(&column(end, k)) + across.cross(&column(other, k)))
                }
            };
            Coupling { velocity, spin }
        });
        let turned = relative * entry(cross, 1, 1);
        let both = entry(own[0], 1, 1) + entry(own[1], 1, 1);
        Self {
            lumps,
            cross: Lump { mass: entry(cross, 0, 0), first: cross_first, spread: spread(cross, [0, 1]) },
            couplings,
            own: Matrix3::from_diagonal_element(both) + turned + turned.transpose(),
        }
    }
}

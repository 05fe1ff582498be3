//! Variations of the forces of inertia, gravity and mass-proportional damping on the nodes, NOTATION eq. (X3).
//!
//! Each is a mass block times `L(e) = ë + α ė + 2 Ω × ė + (Ω̇× + Ω×Ω×) e − g` of the nodal vectors.

use crate::load::RootMotion;
use crate::math::so3::hat;
use crate::multibody::derivative::carried::CarriedDamping;
use crate::multibody::derivative::chain::Shift;
use crate::multibody::derivative::spot::{Field, Four, NONE, Spot, beam_forces};
use crate::multibody::dynamics::Environment;
use crate::multibody::model::Model;
use crate::multibody::nodal::multiply;
use crate::multibody::workspace::Node;
use nalgebra::Vector3;

fn add(sum: &mut Four, other: &Four) {
    sum.iter_mut().zip(other).for_each(|(sum, other)| *sum += other);
}

/// Workspace for the nodal vectors of all nodes.
#[derive(Debug, Clone)]
pub(super) struct Inertia {
    field: Field,
    loads: Vec<Four>,
    forces: Vec<Four>,
    /// Per body: its damping relative to a carrier.
    carried: Vec<Option<CarriedDamping>>,
}

impl Inertia {
    pub fn new(model: &Model) -> Self {
        let nodes = model.nodes.len();
        let carried = model.bodies.iter().map(CarriedDamping::of_body).collect();
        Self { field: Field::of(&RootMotion::default()), loads: vec![NONE; nodes], forces: vec![NONE; nodes], carried }
    }

    /// The root's motion.
    pub fn field(&self) -> &Field {
        &self.field
    }

    /// Whether the root rotates.
    pub fn rotates(&self) -> bool {
        self.field.rotates
    }

    /// Stores the forces at the point of the last residual.
    #[inline(always)]
    pub fn prepare(&mut self, model: &Model, nodes: &[Node], environment: &Environment, spots: &mut [Spot]) {
        self.field = Field::of(environment.root);
        for (own, node) in self.loads.iter_mut().zip(nodes) {
            *own = node.load_rate;
        }
        for ((body, damping), carried) in model.bodies.iter().zip(environment.damping).zip(&mut self.carried) {
            if let Some(carried) = carried.as_mut().filter(|_| damping.mass_1_s != 0.0) {
                carried.prepare(model, body, nodes);
            }
            let range = body.first_node..=body.last_node();
            beam_forces(model, body, &self.loads[range.clone()], &mut self.forces[range.clone()]);
            for n in range {
                if let Some(attached) = &model.nodes[n].attached {
                    let node = &nodes[n];
                    let mut loads = node.load_rate;
                    if !body.damps_attached {
                        // without damping: `ė` of the origin and the axes
                        let (velocity, spin) = match body.carrier {
                            Some(carrier) => node.relative_to(&nodes[carrier]),
                            None => (node.velocity, node.spin),
                        };
                        let turn = hat(&spin) * node.rotation;
                        loads[0] -= velocity * damping.mass_1_s;
                        for k in 0..3 {
                            loads[k + 1] -= turn.column(k) * damping.mass_1_s;
                        }
                    }
                    add(&mut self.forces[n], &multiply(attached, &loads));
                }
                spots[n].set_forces(&self.forces[n]);
            }
        }
    }

    /// Variations of the wrenches on all nodes.
    pub fn forward(
        &mut self,
        model: &Model,
        (spots, alphas): (&[Spot], &[f64]),
        shifts: &[Shift],
        wrenches: &mut [[Vector3<f64>; 2]],
    ) {
        for ((body, alpha), carried) in model.bodies.iter().zip(alphas).zip(&mut self.carried) {
            let mut carried = carried.as_mut().filter(|_| *alpha != 0.0);
            let range = body.first_node..=body.last_node();
            for n in range.clone() {
                self.loads[n] = match self.field.rotates {
                    true => spots[n].loads(&shifts[n], &self.field, *alpha),
                    false => spots[n].own_loads(&shifts[n], *alpha),
                };
            }
            if let Some(carried) = &mut carried {
                carried.subtract(body, (spots, *alpha), shifts, &mut self.loads);
            }
            beam_forces(model, body, &self.loads[range.clone()], &mut self.forces[range.clone()]);
            for n in range {
                if let Some(attached) = &model.nodes[n].attached {
                    let loads = match body.damps_attached || *alpha == 0.0 {
                        true => self.loads[n],
                        false => spots[n].loads(&shifts[n], &self.field, 0.0),
                    };
                    add(&mut self.forces[n], &multiply(attached, &loads));
                }
                wrenches[n] = spots[n].wrench(&shifts[n].angular[0], &self.forces[n]);
            }
            if let Some(carried) = carried {
                carried.react((model, body), (spots, *alpha), shifts, wrenches);
            }
        }
    }

    /// Adds the multipliers of the motion of all nodes, from those of their wrenches.
    pub fn reverse(
        &mut self,
        model: &Model,
        (spots, alphas): (&[Spot], &[f64]),
        on: &[[Vector3<f64>; 2]],
        sums: &mut [Shift],
    ) {
        for ((body, alpha), carried) in model.bodies.iter().zip(alphas).zip(&mut self.carried) {
            let range = body.first_node..=body.last_node();
            for n in range.clone() {
                self.forces[n] = spots[n].pulled(&on[n]);
                sums[n].angular[0] += spots[n].by_turn.tr_mul(&on[n][1]);
            }
            beam_forces(model, body, &self.forces[range.clone()], &mut self.loads[range.clone()]);
            for n in range {
                if let Some(attached) = &model.nodes[n].attached {
                    let own = multiply(attached, &self.forces[n]);
                    match body.damps_attached || *alpha == 0.0 {
                        true => add(&mut self.loads[n], &own),
                        false => spots[n].add_loads(&own, &self.field, 0.0, &mut sums[n]),
                    }
                }
                match self.field.rotates {
                    true => spots[n].add_loads(&self.loads[n], &self.field, *alpha, &mut sums[n]),
                    false => spots[n].add_own_loads(&self.loads[n], *alpha, &mut sums[n]),
                }
            }
            if let Some(carried) = carried.as_mut().filter(|_| *alpha != 0.0) {
                carried.pull_subtracted(body, (spots, *alpha), &self.loads, sums);
                carried.pull_reaction((model, body), (spots, *alpha), on, sums);
            }
        }
    }
}

//! Modes of the model about its current state, with linearised aerodynamics, and their shapes.

use crate::math::strain::{EDGE, FLAP, SHEARED, STRAINS, Strain};
use crate::multibody::model::Body;
use crate::multibody::tangent::Tangent;
use crate::solve::lagged::{Lagged, LaggedMode};
use crate::solve::modes::NoModes;
use crate::study::Study;
use crate::study::flight::tell_lateral_apart;
use crate::study::linear::determinant_is_positive;
use crate::system::PlantError;
use crate::system::freedoms::Freedom;
use crate::system::shape::{ENERGY_SHARES, JOINT_SHARE, ModeShape, NodeMotion, SHEAR_SHARE};
use nalgebra::{Complex, Vector3};

/// Coordinates of a mode, and motions of the nodes: displacement in m, rotation in rad.
type Shape = (Vec<f64>, Vec<(Vector3<f64>, Vector3<f64>)>);

impl Study<'_> {
    /// Modes of lowest frequency about the current state, with shapes. They include the loads of strips, rotors and slender bodies; those
    /// of lattices are constant.
    pub fn modes(&mut self, count: usize) -> Result<Vec<ModeShape>, PlantError> {
        let (mut modes, _) = self.modes_and_rest(count)?;
        modes.truncate(count);
        Ok(modes)
    }

    /// Modes of lowest frequency with constant aerodynamic loads: modes of the structure alone, for instance after [`Study::undeformed`].
    pub fn bare_modes(&mut self, count: usize) -> Result<Vec<ModeShape>, PlantError> {
        let system = Lagged::without(self.at_instant(Self::second_order)?);
        let mut list = system.modes(count).map_err(|error| self.no_modes(&error))?;
        list.truncate(count);
        let freedoms = self.system.freedoms();
        let shape = |mode| ModeShape { flight: None, ..self.mode_shape(mode, &freedoms) };
        Ok(list.into_iter().map(shape).collect())
    }

    fn no_modes(&self, error: &NoModes) -> PlantError {
        PlantError::Linearization { time_s: self.system.state.now.time_s, cause: error.to_string() }
    }

    /// The `count` aeroelastic modes of lowest frequency and every growing mode, with the sign of the determinant of the static stiffness
    /// in the established flow, which changes at divergence; `None` if there is a rigid-body mode.
    pub fn modes_and_rest(&mut self, count: usize) -> Result<(Vec<ModeShape>, Option<bool>), PlantError> {
        let (system, _) = self.at_instant(|study| study.lagged(false))?;
        let list = system.modes(count).map_err(|error| self.no_modes(&error))?;
        let sign = system.rest_stiffness().and_then(|stiffness| determinant_is_positive(&stiffness));
        let freedoms = self.system.freedoms();
        let mut shapes: Vec<ModeShape> = list.into_iter().map(|mode| self.mode_shape(mode, &freedoms)).collect();
        if self.system.air_is_linearised() {
            tell_lateral_apart(&mut shapes);
        } else {
            // with constant aerodynamic loads there are no flight modes
            shapes.iter_mut().for_each(|mode| mode.flight = None);
        }
        Ok((shapes, sign))
    }

    pub(super) fn mode_shape(&self, mode: LaggedMode, freedoms: &[Freedom]) -> ModeShape {
        let model = &self.system.equations.model;
        let mut tangent = Tangent::new(model);
        self.system.equations.linearize_at_rest(&mut tangent, &self.system.state.now.q);
        let mut part = |read: fn(&Complex<f64>) -> f64| {
            let mut x = vec![0.0; model.coordinates];
            freedoms.iter().zip(mode.shape.iter()).for_each(|(freedom, value)| freedom.spread(read(value), &mut x));
            let moved = tangent.node_displacements(model, &x);
            (x, moved)
        };
        let (real, imaginary) = (part(|x| x.re), part(|x| x.im));
        let size = real.1.iter().zip(&imaginary.1).fold(0.0f64, |size, (re, im)| {
            let linear = (re.0.norm_squared() + im.0.norm_squared()).sqrt() / model.reference_length_m;
            size.max(linear).max((re.1.norm_squared() + im.1.norm_squared()).sqrt())
        });
        let scale = if size > 0.0 { 1.0 / size } else { 1.0 };
        let nodes = |(x, part): &Shape| -> Vec<Vec<NodeMotion>> {
            let motion =
                |node: usize| NodeMotion { displacement_m: part[node].0 * scale, rotation_rad: part[node].1 * scale };
            let of_body = |(index, body): (usize, &Body)| match &body.modal {
                None => body.frames().map(motion).collect(),
                Some(modal) => {
                    let node = &self.system.equations.work.nodes[body.first_node];
                    let q = &self.system.state.now.q[modal.range()];
                    let moved = self.system.mesh_m(index).into_iter().map(|place_m| {
                        modal.displaced_at(node, (q, place_m), &part[body.first_node], &x[modal.range()])
                    });
                    moved
                        .map(|(linear, angular)| NodeMotion {
                            displacement_m: linear * scale,
                            rotation_rad: angular * scale,
                        })
                        .collect()
                }
            };
            model.bodies.iter().enumerate().map(of_body).collect()
        };
        let mut shape = ModeShape {
            frequency_hz: mode.eigenvalue_1_s.norm() / std::f64::consts::TAU,
            damping_ratio: damping_ratio(mode.eigenvalue_1_s),
            eigenvalue_1_s: mode.eigenvalue_1_s,
            shares: match mode.eigenvalue_1_s.norm() {
                0.0 => [0.0; ENERGY_SHARES],
                _ => self.energy_shares(&[&real.0, &imaginary.0]),
            },
            real: nodes(&real),
            imaginary: nodes(&imaginary),
            coordinates: freedoms.iter().zip(mode.shape.iter()).map(|(_, x)| *x * scale).collect(),
            length_m: model.reference_length_m,
            whirl: Vec::new(),
            flight: None,
        };
        shape.flight = self.system.flight_mode(&shape);
        shape
    }

    /// Fractions of the strains and of joint springs in the elastic energy of a motion.
    fn energy_shares(&self, parts: &[&Vec<f64>; 2]) -> [f64; ENERGY_SHARES] {
        let mut shares = [0.0; ENERGY_SHARES];
        for x in parts {
            for element in &self.system.equations.model.elements {
                let Some(elastic) = &element.sheared else {
                    let strain = Strain::from(element.strains(x));
                    let force = element.elastic.stiffness * strain;
                    for k in 0..STRAINS {
                        shares[k] += strain[k] * force[k];
                    }
                    continue;
                };
                let strain = Strain::<SHEARED>::from(element.strains(x));
                let force = elastic.stiffness * strain;
                for k in 0..SHEARED {
                    shares[k.min(SHEAR_SHARE)] += strain[k] * force[k];
                }
            }
            for modal in self.system.equations.model.bodies.iter().filter_map(|body| body.modal.as_ref()) {
                let first = modal.coordinate;
                for i in modal.range() {
                    let row = modal.range().map(|j| modal.element.stiffness[(i - first, j - first)] * x[j]);
                    shares[if i - first < modal.element.flaps { FLAP } else { EDGE }] += x[i] * row.sum::<f64>();
                }
            }
            for joint in self.system.equations.forces.joints().iter().filter(|joint| !joint.held) {
                let stiffness = self.system.equations.tangents[joint.body].stiffness;
                shares[JOINT_SHARE] += stiffness * x[joint.coordinate].powi(2);
            }
        }
        let sum: f64 = shares.iter().sum();
        if sum > 0.0 {
            return shares.map(|share| share / sum);
        }
        let mut of_joints = [0.0; ENERGY_SHARES];
        of_joints[JOINT_SHARE] = 1.0;
        of_joints
    }
}

/// Damping ratio `−Re λ/|λ|`; 0 for `λ = 0`.
fn damping_ratio(eigenvalue_1_s: Complex<f64>) -> f64 {
    let size = eigenvalue_1_s.norm();
    if size == 0.0 { 0.0 } else { -eigenvalue_1_s.re / size }
}

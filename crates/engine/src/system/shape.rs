//! Shapes along the bodies, at the current state and of modes.

use crate::beam::element::ElementKind;
use crate::beam::recovery::axial_row;
use crate::load::{LoadFrame, Wrench};
use crate::math::so3::rotation_vector;
use crate::math::strain::{NAMES, STRAINS, Strain};
pub use crate::multibody::internal_load::SectionPlace;
use crate::multibody::kinematics::{Motion, sweep_motion};
use crate::multibody::model::{Body, Station};
use crate::multibody::tangent::Tangent;
use crate::multibody::{gauge, station};
use crate::solve::modes::grows;
use crate::solve::multiblade::Whirl;
use crate::solve::tracking::Followed;
use crate::system::System;
use nalgebra::{Complex, Matrix3, Vector3};

/// A section of a body at a mesh boundary.
#[derive(Debug, Clone, PartialEq)]
pub struct SectionShape {
    /// Distance from the body's inner end along the undeformed axis in m.
    pub place_m: f64,
    /// Position in the root frame in m.
    pub position_m: Vector3<f64>,
    /// Attitude, root ← section.
    pub rotation: Matrix3<f64>,
    /// Strains `(εx, κx, κy, κz)`; –, 1/m.
    pub strain: Strain,
}

impl SectionShape {
    /// Rotation vector of the section in rad, root frame.
    pub fn rotation_vector_rad(&self) -> Vector3<f64> {
        rotation_vector(&self.rotation)
    }
}

/// Motion of a section in a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NodeMotion {
    /// Displacement in m, root frame.
    pub displacement_m: Vector3<f64>,
    /// Rotation vector in rad, root frame.
    pub rotation_rad: Vector3<f64>,
}

/// Number of parts of the elastic energy: one per strain without shear, in their order, one for both shears, and one for the springs of
/// joints.
pub const ENERGY_SHARES: usize = STRAINS + 2;
/// Index of the energy fraction of both shears, which only bodies with shear have.
pub const SHEAR_SHARE: usize = STRAINS;
/// Index of the energy fraction of the joint springs.
pub(crate) const JOINT_SHARE: usize = STRAINS + 1;

/// Names of [`ModeShape::shares`].
pub fn energy_share_names() -> [&'static str; ENERGY_SHARES] {
    std::array::from_fn(|part| match part {
        SHEAR_SHARE => "shear",
        JOINT_SHARE => "joints",
        strain => NAMES[strain].word,
    })
}

/// A mode with its shape: per body, the motion of the sections of [`System::shape`]. Normalised so that the largest rotation in rad, or
/// displacement divided by the model's length, is 1.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeShape {
    /// Frequency `|λ|/2π` in Hz.
    pub frequency_hz: f64,
    /// Damping ratio `−Re λ/|λ|`.
    pub damping_ratio: f64,
    /// Eigenvalue `λ` in 1/s.
    pub eigenvalue_1_s: Complex<f64>,
    /// Fractions of the elastic energy in the strains and in joint springs ([`energy_share_names`]); zero for rigid-body modes.
    pub shares: [f64; ENERGY_SHARES],
    /// Real part of the shape.
    pub real: Vec<Vec<NodeMotion>>,
    /// Imaginary part; zero without damping and gyroscopic forces.
    pub imaginary: Vec<Vec<NodeMotion>>,
    /// Changes of the degrees of freedom, in the order of [`System::freedoms`], scaled like `real` and `imaginary`;
    /// [`System::section_changes`] gives the changes of sections. Empty for modes about a periodic motion, whose coordinates vary over the
    /// revolution.
    pub coordinates: Vec<Complex<f64>>,
    /// Length of the model in m, by which displacements are divided.
    pub length_m: f64,
    /// Moving parts of a machine with a spinning rotor, largest participation first; empty for other machines.
    pub whirl: Vec<WhirlShare>,
    /// Flight mode of the whole model that this mode represents; `None` for other modes.
    pub flight: Option<FlightMode>,
}

/// Part of a mode of a spinning rotor.
#[derive(Debug, Clone, PartialEq)]
pub struct WhirlShare {
    /// Moving part, e.g. `blade flap 1` or `tower edge 1`.
    pub part: String,
    /// Relative motion of the blades; `None` for parts other than blades.
    pub whirl: Option<Whirl>,
    /// Participation; the sum over all parts is 1.
    pub share: f64,
}

/// Flight mode of a free-flying model, identified by its motion relative to the steady flight, NOTATION eq. (Q10).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FlightMode {
    /// Exchange between height and speed, at nearly constant angle of attack.
    Phugoid,
    /// Oscillation of angle of attack and pitch, at nearly constant speed.
    ShortPeriod,
    /// The angle of attack decays without oscillation, mainly by pitching, for example an overdamped short period.
    PitchSubsidence,
    /// The angle of attack decays without oscillation, mainly by heave.
    HeaveSubsidence,
    /// The speed decays without oscillation.
    SpeedSubsidence,
    /// Pitch, angle of attack or speed grow without oscillation.
    PitchDivergence,
    /// Oscillation of sideslip, yaw and roll.
    DutchRoll,
    /// Roll alone, damped by the wing.
    RollSubsidence,
    /// Slow change of bank and heading together.
    Spiral,
}

impl std::fmt::Display for FlightMode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Phugoid => "phugoid",
            Self::ShortPeriod => "short period",
            Self::PitchSubsidence => "pitch subsidence",
            Self::HeaveSubsidence => "heave subsidence",
            Self::SpeedSubsidence => "speed subsidence",
            Self::PitchDivergence => "pitch divergence",
            Self::DutchRoll => "dutch roll",
            Self::RollSubsidence => "roll subsidence",
            Self::Spiral => "spiral",
        })
    }
}

impl std::fmt::Display for WhirlShare {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.whirl {
            Some(whirl) => write!(f, "{} {whirl}", self.part),
            None => f.write_str(&self.part),
        }
    }
}

impl ModeShape {
    /// Whether the eigenvalue is real: the motion does not oscillate.
    pub fn is_real(&self) -> bool {
        self.eigenvalue_1_s.im.abs() <= 1e-9 * self.eigenvalue_1_s.norm()
    }

    /// Whether the motion has no stiffness.
    pub fn is_free(&self) -> bool {
        self.eigenvalue_1_s.norm() == 0.0
    }

    /// Whether the motion grows.
    pub fn grows(&self) -> bool {
        grows(self.eigenvalue_1_s)
    }
}

impl Followed for ModeShape {
    fn eigenvalue_1_s(&self) -> Complex<f64> {
        self.eigenvalue_1_s
    }

    /// Similarity `|aᴴb|²/(aᴴa bᴴb)` of two shapes over rotations and displacements divided by the model's length; 1 for different
    /// meshes. For modes about a periodic motion, which have no shape, the common participation of the moving parts.
    fn likeness(&self, other: &Self) -> f64 {
        if self.real.is_empty() && other.real.is_empty() && !self.whirl.is_empty() {
            return common_share(&self.whirl, &other.whirl);
        }
        let sizes = self.product(self).zip(other.product(other)).map_or(0.0, |(own, theirs)| own.re * theirs.re);
        match self.product(other) {
            Some(product) if sizes > 0.0 => product.norm_sqr() / sizes,
            _ => 1.0,
        }
    }

    /// Inner product over rotations and displacements divided by the model's length; `None` for different meshes.
    fn product(&self, other: &Self) -> Option<Complex<f64>> {
        let sections = |mode: &Self| mode.real.iter().map(Vec::len).collect::<Vec<_>>();
        if self.real.is_empty() || sections(self) != sections(other) {
            return None;
        }
        let [own, theirs] = [self, other].map(|mode| mode.real.iter().flatten().zip(mode.imaginary.iter().flatten()));
        let dot = |x: &NodeMotion, y: &NodeMotion| {
            x.displacement_m.dot(&y.displacement_m) / (self.length_m * other.length_m)
                + x.rotation_rad.dot(&y.rotation_rad)
        };
        let products = own.zip(theirs).map(|((a_re, a_im), (b_re, b_im))| {
            Complex::new(dot(a_re, b_re) + dot(a_im, b_im), dot(a_re, b_im) - dot(a_im, b_re))
        });
        Some(products.sum())
    }
}

/// Common participation of two modes, part by part: 1 if the participations are equal, 0 if different parts move.
fn common_share(one: &[WhirlShare], other: &[WhirlShare]) -> f64 {
    let of = |part: &WhirlShare| {
        let same = other.iter().find(|known| known.part == part.part && known.whirl == part.whirl);
        same.map_or(0.0, |known| known.share.min(part.share))
    };
    one.iter().map(of).sum()
}

/// Motion and strain of a section anywhere on a body, root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionState {
    /// Position in m.
    pub position_m: Vector3<f64>,
    /// Velocity in m/s.
    pub velocity_m_s: Vector3<f64>,
    /// Angular velocity in rad/s.
    pub angular_velocity_rad_s: Vector3<f64>,
    /// Attitude, root ← section.
    pub rotation: Matrix3<f64>,
    /// Strain measures `(γ₁, k₁, k₂, k₃)` of the element: strains minus the natural strains, NOTATION eq. (G7); –, 1/m.
    pub measures: Strain,
}

impl SectionState {
    /// Position in m and velocity in m/s of the point `[y, z]` (m) of the section.
    pub fn point(&self, [y_m, z_m]: [f64; 2]) -> (Vector3<f64>, Vector3<f64>) {
        let arm_m = self.rotation * Vector3::new(0.0, y_m, z_m);
        (self.position_m + arm_m, self.velocity_m_s + self.angular_velocity_rad_s.cross(&arm_m))
    }

    /// Longitudinal strain at the point `[y, z]` (m) of the section, NOTATION eqs. (R1), (G7).
    pub fn axial_strain(&self, [y_m, z_m]: [f64; 2]) -> f64 {
        axial_row(y_m, z_m).dot(&self.measures)
    }
}

/// Change of a section due to a change of the coordinates, root frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SectionChange {
    /// Displacement in m.
    pub displacement_m: Vector3<f64>,
    /// Rotation vector in rad.
    pub rotation_rad: Vector3<f64>,
    /// Strain measures of the element, NOTATION eq. (G7); –, 1/m.
    pub measures: Strain,
}

impl System {
    /// Changes of sections, linearised about the current state: displacement, rotation and strain measures due to a small `change` of
    /// [`System::freedoms`]. `places_m` are distances from the inner end in m, per body.
    pub fn section_changes(&self, change: &[f64], places_m: &[Vec<f64>]) -> Vec<Vec<SectionChange>> {
        let (model, now) = (&self.equations.model, &self.state.now);
        let still = vec![0.0; model.coordinates];
        let mut v = still.clone();
        self.freedoms().iter().zip(change).for_each(|(freedom, x)| freedom.spread(*x, &mut v));
        let mut work = self.equations.work.clone();
        Tangent::to_coordinates(model, &work, &mut v);
        // velocities relative to the root are linear in the rates
        let motion = Motion { q: &now.q, v: &v, a: &still };
        sweep_motion(model, &mut work, motion);
        let of_body = |(body, places_m): (usize, &Vec<f64>)| {
            let section = |&place_m: &f64| {
                let (element, offset_m) = model.locate(body, place_m);
                let point =
                    station::motion(model, &work, motion, &Station { body, element, offset_m, frame: LoadFrame::Root });
                let measures = |x: &[f64]| gauge::element_measures(model, x, body, place_m);
                SectionChange {
                    displacement_m: point.velocity_m_s,
                    rotation_rad: point.spin_rad_s,
                    measures: measures(&v) - measures(&still),
                }
            };
            places_m.iter().map(section).collect()
        };
        places_m.iter().enumerate().map(of_body).collect()
    }

    /// Mesh boundaries of a body: distances from its inner end in m, ascending; only 0 for a rigid body.
    pub fn mesh_m(&self, body: usize) -> Vec<f64> {
        let model = &self.equations.model;
        let body = &model.bodies[body];
        if let Some(modal) = &body.modal {
            let (cells, length_m) = (modal.element.masses.len(), modal.element.length_m);
            return (0..=cells).map(|k| length_m * k as f64 / cells as f64).collect();
        }
        if body.elements == 0 {
            return vec![0.0];
        }
        let elements = &model.elements[body.first_element..body.first_element + body.elements];
        let stride = if body.kind == ElementKind::Linear { 2 } else { 1 };
        let end = elements.last().map(|last| last.start_m + last.length_m);
        elements.iter().step_by(stride).map(|element| element.start_m).chain(end).collect()
    }

    /// Sections of a body at distances in m from its inner end, at the current time.
    pub fn sections(&self, body: usize, places_m: &[f64]) -> Vec<SectionState> {
        let (model, work, now) = (&self.equations.model, &self.equations.work, &self.state.now);
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        let section = |&place_m: &f64| {
            let (element, offset_m) = model.locate(body, place_m);
            let station = Station { body, element, offset_m, frame: LoadFrame::Root };
            let point = station::motion(model, work, motion, &station);
            SectionState {
                position_m: point.position_m,
                velocity_m_s: point.velocity_m_s,
                angular_velocity_rad_s: point.spin_rad_s,
                rotation: point.rotation,
                measures: gauge::element_measures(model, &now.q, body, place_m),
            }
        };
        places_m.iter().map(section).collect()
    }

    /// Positions on a beam at distances in m from its inner end, ascending, for [`System::internal_loads`]: the first section is cut
    /// outboard of masses and loads attached there, the others inboard. None on rigid and modal bodies.
    pub fn load_places(&self, body: usize, places_m: &[f64]) -> Vec<SectionPlace> {
        let model = &self.equations.model;
        if model.bodies[body].elements == 0 {
            return Vec::new();
        }
        let factors = &self.parameters().bodies()[body];
        let law = self.machine.bodies[body].section.scaled(factors.mass_factor, factors.stiffness_factor);
        let place = |(index, place_m): (usize, &f64)| {
            let side = if index == 0 { gauge::Side::Outboard } else { gauge::Side::Inboard };
            SectionPlace::new(model, &law, body, *place_m, side)
        };
        places_m.iter().enumerate().map(place).collect()
    }

    /// Internal loads at positions: force in N and moment in N·m of the part outboard of a section on the part inboard, in the frame of the
    /// section, at the current time; all outputs must have been evaluated. NOTATION eqs. (G5), (G6).
    pub fn internal_loads(&self, places: &[SectionPlace]) -> Vec<Wrench> {
        let (equations, now) = (&self.equations, &self.state.now);
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        let loads: &[Wrench] = if equations.loaded { &equations.stations } else { &[] };
        places.iter().map(|place| place.load(&equations.model, &equations.work, motion, loads)).collect()
    }

    /// Sections at the mesh boundaries of every body, inner end first, at the current time.
    pub fn shape(&self) -> Vec<Vec<SectionShape>> {
        let (model, work, now) = (&self.equations.model, &self.equations.work, &self.state.now);
        let motion = Motion { q: &now.q, v: &now.v, a: &now.a };
        let section = |index: usize, node: usize| {
            let body = &model.bodies[index];
            let next = body.first_element + node - body.first_node;
            let place_m = if body.elements == 0 {
                0.0
            } else if node == body.last_node() {
                let last = &model.elements[next - 1];
                last.start_m + last.length_m
            } else {
                model.elements[next].start_m
            };
            SectionShape {
                place_m,
                position_m: work.nodes[node].position,
                rotation: work.nodes[node].rotation,
                strain: gauge::section_strain(model, work, motion, &self.equations.damping, index, place_m),
            }
        };
        let modal = |index: usize| -> Vec<SectionShape> {
            let places_m = self.mesh_m(index);
            let sections = self.sections(index, &places_m).into_iter().zip(places_m);
            let shape = |(section, place_m): (SectionState, f64)| SectionShape {
                place_m,
                position_m: section.position_m,
                rotation: section.rotation,
                strain: Strain::zeros(),
            };
            sections.map(shape).collect()
        };
        let shape = |(index, body): (usize, &Body)| match &body.modal {
            Some(_) => modal(index),
            None => body.frames().map(|node| section(index, node)).collect(),
        };
        model.bodies.iter().enumerate().map(shape).collect()
    }
}

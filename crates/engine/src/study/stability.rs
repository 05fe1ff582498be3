//! Quality of an equilibrium: whether it is stable, the direction of the instability, and whether the mesh resolves it.

use crate::math::strain::TWIST;
use crate::multibody::kinematics::sweep_poses;
use crate::multibody::tangent::Tangent;
use crate::solve::EquationsOfMotion;
use crate::study::{PathPoint, Study};
use crate::system::PlantError;
use crate::system::shape::ModeShape;
use nalgebra::{Complex, Vector3};

/// Asymmetry of a tangent up to which it counts as round-off, so that the loads have a potential.
pub(crate) const SYMMETRIC: f64 = 1e-8;

/// Number of modes examined.
const MODES: usize = 10;
/// Number of modes by which the stability with a lattice is assessed: the number that `flutter` tracks by default.
pub const JUDGED_MODES: usize = 6;

/// Number of coordinates above which modes are not examined, because the matrices are dense.
const MAXIMUM_COORDINATES: usize = 1200;

/// Change of a beam's rotation from element to element, in rad, above which the mesh is reported as coarse.
const COARSE_RAD: f64 = 0.5;

/// Stability of an equilibrium under the current inputs.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stability {
    /// Number of negative pivots of the static tangent: directions in which the forces are destabilising, eq. (L16). It is exact if the
    /// loads have a potential.
    pub negative_directions: usize,
    /// Whether the loads have a potential, so that the tangent is symmetric. Follower loads and aerodynamic loads have none.
    pub potential: bool,
    /// Whether there is a motion without stiffness: the tangent is singular, and stability follows from the modes only.
    pub neutral: bool,
    /// Growing modes, fastest first, including the aerodynamic response.
    pub growing: Vec<Growth>,
    /// Whether stability was assessed in discrete time with a lattice, by its slowest modes, up to the [`JUDGED_MODES`]-th frequency of the
    /// structure.
    pub in_lattice: bool,
    /// Reason why stability is not assessed; `None` if it is.
    pub not_judged: Option<String>,
}

impl Stability {
    /// Result for an equilibrium whose stability is not assessed, with the reason.
    fn not_judged(cause: String) -> Self {
        Self { not_judged: Some(cause), ..Self::default() }
    }

    /// Number of unstable directions: negative pivots or, without a potential, growing modes; 0 if stability is not assessed.
    pub fn unstable_directions(&self) -> usize {
        if self.potential && !self.neutral { self.negative_directions } else { self.growing.len() }
    }

    /// Whether there are no unstable directions; false if stability is not assessed.
    pub fn is_stable(&self) -> bool {
        self.not_judged.is_none() && self.unstable_directions() == 0
    }

    /// Number of unstable directions without oscillation, which lead to another equilibrium.
    pub fn static_directions(&self) -> usize {
        let leaves = |growth: &&Growth| growth.eigenvalue_1_s.im.abs() <= 1e-9 * growth.eigenvalue_1_s.norm();
        match self.potential && !self.neutral {
            true => self.negative_directions,
            false => self.growing.iter().filter(leaves).count(),
        }
    }
}

/// A growing mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Growth {
    /// Eigenvalue in 1/s; real if the motion does not oscillate.
    pub eigenvalue_1_s: Complex<f64>,
    /// Body with the largest motion.
    pub body: usize,
    /// Section with the largest motion: distance from the body's inner end in m.
    pub place_m: f64,
    /// Direction of that motion as a unit vector, root frame; zero for a pure rotation.
    pub direction: Vector3<f64>,
}

/// The position where a beam's curvature changes the most from one element, or half of a pair, to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coarseness {
    /// Index of the body.
    pub body: usize,
    /// Distance from its inner end in m.
    pub place_m: f64,
    /// Change of the rotation there in rad.
    pub turn_rad: f64,
}

impl Coarseness {
    /// Whether the mesh is too coarse for a reliable result.
    pub fn is_coarse(&self) -> bool {
        self.turn_rad > COARSE_RAD
    }
}

impl Study<'_> {
    /// Stability of the current state, which must be an equilibrium, under the current inputs, including the aerodynamic response. It is
    /// not assessed if the aerodynamic model has no linear model, or if the loads have no potential and there are too many coordinates for
    /// modes.
    ///
    /// # Errors
    /// If the modes cannot be computed.
    pub fn stability(&mut self) -> Result<Stability, PlantError> {
        self.system.refuse_sliding("stability")?;
        self.system.refuse_no_slip("stability")?;
        if self.system.has_linear_lattice() && self.system.state.applied_parameters.air_density_kg_m3() > 0.0 {
            return match self.growing_in_air_of_lattice(JUDGED_MODES) {
                Ok(modes) => Ok(self.stability_in_lattice(&modes)),
                Err(PlantError::Linearization { cause, .. }) => Ok(Stability::not_judged(cause)),
                Err(error @ PlantError::DcMotor { .. }) => Ok(Stability::not_judged(error.to_string())),
                Err(error) => Err(error),
            };
        }
        let now = &self.system.state.now;
        let mut unused = vec![0.0; self.system.coordinates()];
        self.system.equations.residual(now.time_s, &now.q, &now.v, &now.a, &mut unused);
        let (equations, model) = (&self.system.equations, &self.system.equations.model);
        let (negative, asymmetry) = if let Some(mut dense) = self.dense_tangent() {
            let negative = dense.factorize(equations, &now.q, 0.0).ok();
            (negative, dense.asymmetry())
        } else {
            let mut tangent = Tangent::new(model);
            equations.linearize_at_rest(&mut tangent, &now.q);
            let negative = tangent.factorize(model).ok().map(|()| tangent.negative_directions());
            (negative, tangent.asymmetry(model))
        };
        let (neutral, negative_directions) = (negative.is_none(), negative.unwrap_or(0));
        // aerodynamic loads that respond to motion have no potential
        let blown = self.system.air_is_linearised() && self.system.state.applied_parameters.air_density_kg_m3() > 0.0;
        let potential = asymmetry < SYMMETRIC && !blown;
        let by_pivots = potential && !neutral;
        let coordinates = self.system.coordinates();
        let too_many = coordinates > MAXIMUM_COORDINATES;
        let growing = if by_pivots && negative_directions == 0 || too_many { Vec::new() } else { self.growing()? };
        let not_judged = (!by_pivots && too_many).then(|| {
            format!("{coordinates} coordinates exceed {MAXIMUM_COORDINATES}, the maximum for modes; use fewer elements")
        });
        Ok(Stability { negative_directions, potential, neutral, growing, in_lattice: false, not_judged })
    }

    /// Stability with a lattice, assessed by its `modes` of lowest frequency from [`Study::lattice_modes_and_rest`].
    pub fn stability_in_lattice(&self, modes: &[ModeShape]) -> Stability {
        Stability { growing: self.growing_of(modes), in_lattice: true, ..Stability::default() }
    }

    /// Eigenvalues in 1/s of the growing modes about the current state, fastest first, one of each pair, NOTATION eq. (L22). They include
    /// the loads of strips, rotors and slender bodies. `None` for machines with too many coordinates, and for those with a lattice, whose loads are
    /// constant in a continuous-time model.
    pub fn growing_1_s(&mut self) -> Result<Option<Vec<Complex<f64>>>, PlantError> {
        if self.system.coordinates() > MAXIMUM_COORDINATES || self.system.has_linear_lattice() {
            return Ok(None);
        }
        Ok(Some(self.growing()?.iter().map(|growth| growth.eigenvalue_1_s).collect()))
    }

    /// Eigenvalues in 1/s of the growing modes about the current equilibrium with a lattice, fastest first, one of each pair, as found by
    /// [`Study::stability`]. `None` if stability is not assessed.
    ///
    /// # Errors
    /// If the modes cannot be computed.
    pub fn growing_in_lattice_1_s(&mut self) -> Result<Option<Vec<Complex<f64>>>, PlantError> {
        let stability = self.stability()?;
        // the pivots may show that a large model is unstable without its modes being computed
        let judged = stability.not_judged.is_none() && (stability.is_stable() || !stability.growing.is_empty());
        Ok(judged.then(|| stability.growing.iter().map(|growth| growth.eigenvalue_1_s).collect()))
    }

    fn growing(&mut self) -> Result<Vec<Growth>, PlantError> {
        let (modes, _) = self.modes_and_rest(MODES)?;
        Ok(self.growing_of(&modes))
    }

    fn growing_of(&self, modes: &[ModeShape]) -> Vec<Growth> {
        let mut list: Vec<Growth> = modes.iter().filter(|mode| mode.grows()).map(|mode| self.growth(mode)).collect();
        list.sort_by(|a, b| b.eigenvalue_1_s.re.total_cmp(&a.eigenvalue_1_s.re));
        list
    }

    /// Position of the largest motion of a mode.
    pub(super) fn growth(&self, mode: &ModeShape) -> Growth {
        let mut growth =
            Growth { eigenvalue_1_s: mode.eigenvalue_1_s, body: 0, place_m: 0.0, direction: Vector3::zeros() };
        let mut largest_m = 0.0;
        for (body, (sections, places)) in mode.real.iter().zip(self.system.shape()).enumerate() {
            for (section, place) in sections.iter().zip(places) {
                let size_m = section.displacement_m.norm();
                if size_m > largest_m * (1.0 + 1e-9) {
                    largest_m = size_m;
                    (growth.body, growth.place_m) = (body, place.place_m);
                    growth.direction = section.displacement_m / size_m;
                }
            }
        }
        growth
    }

    /// Position of the largest change of curvature from element to element in the current shape.
    pub fn coarseness(&self) -> Coarseness {
        let (q, model) = (&self.system.state.now.q, &self.system.equations.model);
        let mut worst = Coarseness { body: 0, place_m: 0.0, turn_rad: 0.0 };
        for (index, body) in model.bodies.iter().enumerate() {
            let elements = &model.elements[body.first_element..body.first_element + body.elements];
            for pair in elements.windows(2) {
                let turn = |k: usize| {
                    let excess = |i: usize| q[pair[i].coordinate + k] - pair[i].natural_strain_of(k);
                    0.5 * (pair[0].length_m + pair[1].length_m) * (excess(1) - excess(0))
                };
                let turn_rad = Vector3::from_fn(|i, _| turn(TWIST + i)).norm();
                if turn_rad > worst.turn_rad {
                    worst = Coarseness { body: index, place_m: pair[1].start_m, turn_rad };
                }
            }
        }
        worst
    }

    /// Positions in m, root frame, of the free ends of [`crate::system::System::tip_bodies`] at a point of a path.
    pub fn tips_at(&mut self, point: &PathPoint) -> Vec<Vector3<f64>> {
        sweep_poses(&self.system.equations.model, &mut self.system.equations.work, &point.q);
        let tip = |&body: &usize| {
            let model = &self.system.equations.model;
            self.system.equations.work.nodes[model.bodies[body].last_node()].position
        };
        self.system.tip_bodies.iter().map(tip).collect()
    }
}

//! Aerodynamics in code: equivalent of the table `[aerodynamics]` of the model file.

use crate::aero::images::Plane;
use crate::aero::lattice::{LatticeOptions, LoadRule, WakeModel};
use crate::aero::strip::StripOptions;
use crate::aero::strip::indicial::Fit;
use crate::aero::strip::lifting_line::LiftingLineOptions;
use crate::machine::builder::place::air_place;
use crate::machine::builder::rotor::RotorSettings;
use crate::machine::builder::slender::SlenderBodySettings;
use crate::machine::fault::{Checker, Range, array_text};
use crate::machine::{Air, Coupling, LiftingSurface};
use nalgebra::Vector3;

/// Cosine of the angle between the normals of mirror and ground below which they count as perpendicular.
const ACROSS: f64 = 1e-9;
/// Default core radius divided by the chord of the smallest panel.
const CORE_SHARE: f64 = 1e-2;

/// Aerodynamic model in the builder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Model {
    Lattice,
    Strips,
    Rotor,
    SlenderBody,
    /// Several of the others.
    Parts,
    None,
}

/// Aerodynamics under construction: [`Air::lattice`], [`Air::strips`], [`Air::none`].
#[derive(Debug, Clone, PartialEq)]
pub struct AirBuilder {
    pub(super) model: Model,
    pub(super) density_kg_m3: f64,
    pub(super) wind_m_s: Vector3<f64>,
    pub(super) step_s: Option<f64>,
    pub(super) coupling: Coupling,
    pub(super) established: bool,
    pub(super) reports_circulation: bool,
    unsteady: bool,
    pub(super) apparent_mass: bool,
    fit: Fit,
    pub(super) tip_loss: bool,
    leading_edge_suction: Option<bool>,
    mirror_normal: Option<Vector3<f64>>,
    ground: Option<(Vector3<f64>, f64)>,
    speed_of_sound_m_s: Option<f64>,
    wake: WakeModel,
    pub(super) wake_rows: usize,
    core_radius_m: Option<f64>,
    threads: usize,
    pub(super) rotor: Option<RotorSettings>,
    pub(super) slender: Option<SlenderBodySettings>,
    pub(super) parts: Vec<(String, AirBuilder)>,
}

impl Air {
    pub(super) fn builder(model: Model) -> AirBuilder {
        AirBuilder {
            model,
            density_kg_m3: 1.225,
            wind_m_s: Vector3::zeros(),
            step_s: None,
            coupling: Coupling::Iterated { tolerance: 1e-4, most_iterations: 50 },
            established: true,
            reports_circulation: false,
            unsteady: true,
            apparent_mass: true,
            fit: Fit::Jones,
            tip_loss: false,
            leading_edge_suction: None,
            mirror_normal: None,
            ground: None,
            speed_of_sound_m_s: None,
            wake: WakeModel::Prescribed,
            wake_rows: 100,
            core_radius_m: None,
            threads: 1,
            rotor: None,
            slender: None,
            parts: Vec::new(),
        }
    }

    /// An unsteady vortex lattice.
    pub fn lattice() -> AirBuilder {
        Self::builder(Model::Lattice)
    }

    /// Strip theory.
    pub fn strips() -> AirBuilder {
        Self::builder(Model::Strips)
    }

    /// Blade-element momentum theory for the blades of one rotor; several rotors are [`Air::parts`].
    pub fn rotor(settings: RotorSettings) -> AirBuilder {
        AirBuilder { rotor: Some(settings), ..Self::builder(Model::Rotor) }
    }

    /// A slender body without lifting surfaces, such as a fuselage, mostly one of [`Air::parts`].
    pub fn slender_body(settings: SlenderBodySettings) -> AirBuilder {
        AirBuilder { slender: Some(settings), ..Self::builder(Model::SlenderBody) }
    }

    /// No aerodynamics: loads are external. Surfaces and gusts are checked and omitted.
    pub fn none() -> AirBuilder {
        Self::builder(Model::None)
    }
}

impl AirBuilder {
    /// Air density in kg/m³. Default 1.225.
    pub fn density_kg_m3(self, density_kg_m3: f64) -> Self {
        Self { density_kg_m3, ..self }
    }

    /// Wind velocity relative to the root in m/s, root frame: start value of the input. Default 0.
    pub fn wind_m_s(self, wind_m_s: impl Into<Vector3<f64>>) -> Self {
        Self { wind_m_s: wind_m_s.into(), ..self }
    }

    /// Aerodynamic step in s. Default: the time in which the fastest point of the trailing edge passes one panel at the start.
    pub fn step_s(self, step_s: f64) -> Self {
        Self { step_s: Some(step_s), ..self }
    }

    /// Coupling of aerodynamics and structure. Default: iteration to a tolerance of 1e-4, at most 50 times.
    pub fn coupling(self, coupling: Coupling) -> Self {
        Self { coupling, ..self }
    }

    /// Whether the run starts with an established flow. Default true.
    pub fn established(self, established: bool) -> Self {
        Self { established, ..self }
    }

    /// Whether the circulation of every strip is an output. Default false.
    pub fn reports_circulation(self, reports_circulation: bool) -> Self {
        Self { reports_circulation, ..self }
    }

    /// Whether strips have unsteady lift by Wagner's and Küssner's functions. Default true.
    pub fn unsteady(self, unsteady: bool) -> Self {
        Self { unsteady, ..self }
    }

    /// Whether strips and slender bodies have apparent mass. Default true.
    pub fn apparent_mass(self, apparent_mass: bool) -> Self {
        Self { apparent_mass, ..self }
    }

    /// Approximation of Wagner's and Küssner's functions; strips only. Default [`Fit::Jones`].
    pub fn fit(self, fit: Fit) -> Self {
        Self { fit, ..self }
    }

    /// Whether leading-edge suction is included. Default true for strips; false for the lattice, whose loads then follow Bernoulli's
    /// equation instead of the Kutta–Joukowski theorem.
    pub fn leading_edge_suction(self, suction: bool) -> Self {
        Self { leading_edge_suction: Some(suction), ..self }
    }

    /// Whether a lifting line through all strips models the loss of lift towards the ends of a wing and the induced drag; strips only,
    /// without polars. Default false.
    pub fn tip_loss(self, tip_loss: bool) -> Self {
        Self { tip_loss, ..self }
    }

    /// Normal of a mirror plane through the root's origin, of any nonzero length; lattice, or strips with [`AirBuilder::tip_loss`]. Default
    /// none.
    pub fn mirror_normal(self, normal: impl Into<Vector3<f64>>) -> Self {
        Self { mirror_normal: Some(normal.into()), ..self }
    }

    /// Ground under a lattice: its normal towards the wing, of any nonzero length and perpendicular to that of a mirror plane, and the
    /// distance of the root's origin above it in m. Default none.
    pub fn ground(self, normal: impl Into<Vector3<f64>>, distance_m: f64) -> Self {
        Self { ground: Some((normal.into(), distance_m)), ..self }
    }

    /// Speed of sound in m/s, for the Prandtl–Glauert correction. Default none: incompressible flow.
    pub fn speed_of_sound_m_s(self, speed_of_sound_m_s: f64) -> Self {
        Self { speed_of_sound_m_s: Some(speed_of_sound_m_s), ..self }
    }

    /// Convection model of the lattice's wake. Default [`WakeModel::Prescribed`].
    pub fn wake(self, wake: WakeModel) -> Self {
        Self { wake, ..self }
    }

    /// Number of panel rows that the wake of the lattice keeps. Default 100.
    pub fn wake_rows(self, wake_rows: usize) -> Self {
        Self { wake_rows, ..self }
    }

    /// Core radius of the vortices in m; lattice, or strips with [`AirBuilder::tip_loss`]. Default: one hundredth of the shortest panel's
    /// chord, or for strips of the shortest chord.
    pub fn core_radius_m(self, core_radius_m: f64) -> Self {
        Self { core_radius_m: Some(core_radius_m), ..self }
    }

    /// Number of threads for the influence of the wake; it does not change the result. Lattice only. Default 1.
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }
}

impl AirBuilder {
    /// Whether one of the models is a slender body.
    pub(super) fn has_slender_body(&self) -> bool {
        self.slender.is_some() || self.parts.iter().any(|(_, part)| part.slender.is_some())
    }

    /// Names and builders of the models: a single one has no name.
    pub(super) fn named(&self) -> Vec<(&str, &Self)> {
        match self.model {
            Model::Parts => self.parts.iter().map(|(name, part)| (name.as_str(), part)).collect(),
            Model::Lattice | Model::Strips | Model::Rotor | Model::SlenderBody | Model::None => vec![("", self)],
        }
    }

    /// Whether settings that are common to all parts differ from their defaults.
    pub(super) fn states_common_settings(&self) -> bool {
        let Self { density_kg_m3, wind_m_s, step_s, coupling, established, reports_circulation, .. } =
            Air::builder(self.model);
        let own = self.clone();
        *self != Self { density_kg_m3, wind_m_s, step_s, coupling, established, reports_circulation, ..own }
    }

    /// Normal of the mirror plane; `None` if it is invalid.
    pub(super) fn mirror(&self, name: &str, checker: &mut Checker) -> Option<Option<Vector3<f64>>> {
        let place = air_place(name, "mirror_normal");
        let Some(normal) = self.mirror_normal else { return Some(None) };
        if self.model != Model::Lattice && !self.tip_loss {
            checker.refuse_state(
                &place,
                "a mirror plane with strips",
                "a mirror plane with a lattice, or with strips that have a tip loss",
            );
            return None;
        }
        let unit = normal.try_normalize(0.0).filter(|unit| unit.norm() > 0.5);
        if unit.is_none() {
            checker.refuse(&place, array_text(normal.as_slice()), "an array of 3 finite numbers, not all 0");
        }
        unit.map(Some)
    }

    pub(super) fn lattice_options(
        &self,
        smallest_m: f64,
        (mirror, ground): (Option<Vector3<f64>>, Option<Plane>),
    ) -> LatticeOptions {
        LatticeOptions {
            wake: self.wake,
            wake_rows: self.wake_rows,
            core_radius_m: self.core_radius_m.unwrap_or(CORE_SHARE * smallest_m),
            load_rule: if self.leading_edge_suction.unwrap_or(false) {
                LoadRule::KuttaJoukowski
            } else {
                LoadRule::Bernoulli
            },
            mirror_normal: mirror,
            ground,
            speed_of_sound_m_s: self.speed_of_sound_m_s,
            threads: self.threads,
        }
    }

    pub(super) fn strip_options(&self, surfaces: &[LiftingSurface], mirror: Option<Vector3<f64>>) -> StripOptions {
        let chords = surfaces.iter().flat_map(|surface| &surface.chords);
        let shortest_m = chords.map(|chord| chord.length_m()).fold(f64::INFINITY, f64::min);
        StripOptions {
            unsteady: self.unsteady,
            apparent_mass: self.apparent_mass,
            fit: self.fit,
            leading_edge_suction: self.leading_edge_suction.unwrap_or(true),
            tip_loss: self.tip_loss.then(|| LiftingLineOptions {
                core_radius_m: self.core_radius_m.unwrap_or(CORE_SHARE * shortest_m),
                mirror_normal: mirror,
            }),
            speed_of_sound_m_s: self.speed_of_sound_m_s,
        }
    }

    /// The ground as a plane; `None` if it is invalid.
    pub(super) fn ground_plane(&self, mirror: Option<Vector3<f64>>, checker: &mut Checker) -> Option<Option<Plane>> {
        let Some((normal, distance_m)) = self.ground else { return Some(None) };
        if self.model != Model::Lattice {
            let allowed = "a ground only with a vortex lattice";
            checker.refuse_state(&["air", "ground_normal"], "a ground with another aerodynamic model", allowed);
            return None;
        }
        let place = ["air", "ground_normal"];
        let Some(unit) = normal.try_normalize(0.0).filter(|unit| unit.norm() > 0.5) else {
            checker.refuse(&place, array_text(normal.as_slice()), "an array of 3 finite numbers, not all 0");
            return None;
        };
        if mirror.is_some_and(|mirror| mirror.dot(&unit).abs() > ACROSS) {
            let allowed = "a normal perpendicular to mirror_normal";
            checker.refuse(&place, array_text(normal.as_slice()), allowed);
            return None;
        }
        checker
            .number(&["air", "ground_distance_m"], distance_m, Range::Finite)
            .then_some(Some(Plane { normal: unit, distance_m }))
    }
}

//! Aerodynamics in code: equivalents of the tables `[aerodynamics]`, `[surface.<name>]`, `[flap.<name>]` and `[gust.<name>]` of the model
//! file.

use crate::aero::AirOptions;
use crate::aero::flow::{Gust, GustShape};
use crate::aero::images::Plane;
use crate::aero::lattice::{LatticeOptions, LoadRule, WakeModel};
use crate::aero::strip::StripOptions;
use crate::aero::strip::indicial::Fit;
use crate::aero::strip::lifting_line::LiftingLineOptions;
use crate::machine::builder::flap::{self, FlapBuilder};
use crate::machine::builder::rotor::RotorSettings;
use crate::machine::builder::surfaces::{SurfaceBuilder, draft, place_all};
use crate::machine::edges::fastest_m_s;
use crate::machine::fault::{Checker, Range, array_text};
use crate::machine::units::shortest;
use crate::machine::validate::air::lattice_size;
use crate::machine::{Air, Body, Coupling};
use nalgebra::Vector3;

/// Cosine of the angle between the normals of mirror and ground below which they count as perpendicular.
const ACROSS: f64 = 1e-9;
/// Default core radius divided by the chord of the smallest panel.
const CORE_SHARE: f64 = 1e-2;

/// Aerodynamic model in the builder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Model {
    Lattice,
    Strips,
    Rotor,
    None,
}

/// Aerodynamics under construction: [`Air::lattice`], [`Air::strips`], [`Air::none`].
#[derive(Debug, Clone, PartialEq)]
pub struct AirBuilder {
    model: Model,
    density_kg_m3: f64,
    wind_m_s: Vector3<f64>,
    step_s: Option<f64>,
    coupling: Coupling,
    established: bool,
    reports_circulation: bool,
    unsteady: bool,
    apparent_mass: bool,
    fit: Fit,
    tip_loss: bool,
    leading_edge_suction: Option<bool>,
    mirror_normal: Option<Vector3<f64>>,
    ground: Option<(Vector3<f64>, f64)>,
    speed_of_sound_m_s: Option<f64>,
    wake: WakeModel,
    wake_rows: usize,
    core_radius_m: Option<f64>,
    threads: usize,
    rotor: Option<RotorSettings>,
}

impl Air {
    fn builder(model: Model) -> AirBuilder {
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

    /// Blade-element momentum theory for the blades of one rotor.
    pub fn rotor(settings: RotorSettings) -> AirBuilder {
        AirBuilder { rotor: Some(settings), ..Self::builder(Model::Rotor) }
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

    /// Whether strips have apparent mass. Default true.
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
    /// The ground as a plane; `None` if it is invalid.
    fn ground_plane(&self, mirror: Option<Vector3<f64>>, checker: &mut Checker) -> Option<Option<Plane>> {
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

/// A gust under construction, see [`GustBuilder::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct GustBuilder {
    name: String,
    shape: GustShape,
    velocity_m_s: Vector3<f64>,
    direction: Option<Vector3<f64>>,
    speed_m_s: Option<f64>,
    origin_m: Vector3<f64>,
    start_s: f64,
}

impl GustBuilder {
    /// A gust with its shape and its largest added velocity in m/s, root frame; for turbulence, its standard deviation. By default it
    /// travels with the wind and passes the root's origin at 0 s.
    pub fn new(name: impl Into<String>, shape: GustShape, velocity_m_s: impl Into<Vector3<f64>>) -> Self {
        Self {
            name: name.into(),
            shape,
            velocity_m_s: velocity_m_s.into(),
            direction: None,
            speed_m_s: None,
            origin_m: Vector3::zeros(),
            start_s: 0.0,
        }
    }

    /// Direction in which the gust travels, root frame, of any nonzero length.
    pub fn direction(self, direction: impl Into<Vector3<f64>>) -> Self {
        Self { direction: Some(direction.into()), ..self }
    }

    /// Speed at which the gust travels in m/s.
    pub fn speed_m_s(self, speed_m_s: f64) -> Self {
        Self { speed_m_s: Some(speed_m_s), ..self }
    }

    /// Position in m that its front passes at [`GustBuilder::start_s`].
    pub fn origin_m(self, origin_m: impl Into<Vector3<f64>>) -> Self {
        Self { origin_m: origin_m.into(), ..self }
    }

    /// Time in s at which the gust's front passes [`GustBuilder::origin_m`].
    pub fn start_s(self, start_s: f64) -> Self {
        Self { start_s, ..self }
    }

    fn build(&self, wind_m_s: &Vector3<f64>, checker: &mut Checker) -> Option<Gust> {
        let place = |key| ["gust", self.name.as_str(), key];
        let direction = self.direction.unwrap_or(*wind_m_s);
        let Some(unit) = direction.try_normalize(0.0).filter(|unit| unit.norm() > 0.5) else {
            let allowed = "an array of 3 finite numbers, not all 0; its default is the direction of wind_m_s";
            checker.refuse(&place("direction"), array_text(direction.as_slice()), allowed);
            return None;
        };
        let speed_m_s = self.speed_m_s.unwrap_or(wind_m_s.norm());
        if speed_m_s <= 0.0 {
            let allowed = "a finite speed > 0 m/s; its default is the magnitude of wind_m_s";
            checker.refuse(&place("speed_m_s"), shortest(speed_m_s), allowed);
            return None;
        }
        Some(Gust {
            name: self.name.clone(),
            shape: self.shape.clone(),
            velocity_m_s: self.velocity_m_s,
            direction: unit,
            speed_m_s,
            origin_m: self.origin_m,
            start_s: self.start_s,
        })
    }
}

/// Builds the aerodynamics around valid bodies; `None` without aerodynamics, or after errors that leave nothing to build. Bodies with
/// errors (not in `stand`) are only looked up by name.
pub(super) fn build(
    air: Option<&AirBuilder>,
    (surfaces, flaps): (&[SurfaceBuilder], &[FlapBuilder]),
    gusts: &[GustBuilder],
    bodies: &[Body],
    stand: bool,
    start_time_s: f64,
    checker: &mut Checker,
) -> Option<Air> {
    let Some(air) = air else {
        let stray = surfaces.first().map(|surface| ["surface", surface.body.as_str()]);
        let stray = stray.or(gusts.first().map(|gust| ["gust", gust.name.as_str()]));
        let stray = stray.or(flaps.first().map(|flap| ["control_surface", flap.name.as_str()]));
        if let Some(place) = stray {
            checker.refuse_state(
                &place,
                "a surface, gust or control surface without aerodynamics",
                "a model with aerodynamics",
            );
        }
        return None;
    };
    let drafts: Option<Vec<_>> = {
        let drafts: Vec<Option<_>> =
            surfaces.iter().enumerate().map(|(index, _)| draft(index, surfaces, bodies, checker)).collect();
        drafts.into_iter().collect()
    };
    let gusts: Vec<Option<Gust>> = gusts.iter().map(|gust| gust.build(&air.wind_m_s, checker)).collect();
    let whole = air.model == Model::Rotor || flap::check(flaps, surfaces, bodies, air.model == Model::Lattice, checker);
    if air.model == Model::None {
        return None;
    }
    if let (Model::Rotor, Some(flap)) = (air.model, flaps.first()) {
        let allowed = "no control surfaces on a rotor; they need strips or a lattice";
        checker.refuse_state(&["control_surface", flap.name.as_str()], "a control surface on a rotor's blade", allowed);
        return None;
    }
    if surfaces.is_empty() {
        let allowed = "at least one surface";
        checker.refuse_state(&["air", "model"], "aerodynamics without a surface", allowed);
        return None;
    }
    let mirror = match air.mirror_normal {
        None => None,
        Some(_) if air.model != Model::Lattice && !air.tip_loss => {
            checker.refuse_state(
                &["air", "mirror_normal"],
                "a mirror plane with strips",
                "a mirror plane with a lattice, or with strips that have a tip loss",
            );
            return None;
        }
        Some(normal) => match normal.try_normalize(0.0).filter(|unit| unit.norm() > 0.5) {
            Some(unit) => Some(unit),
            None => {
                let found = array_text(normal.as_slice());
                checker.refuse(&["air", "mirror_normal"], found, "an array of 3 finite numbers, not all 0");
                return None;
            }
        },
    };
    let ground = air.ground_plane(mirror, checker)?;
    let drafts = drafts?;
    if !whole {
        return None;
    }
    let gusts = gusts.into_iter().collect::<Option<Vec<_>>>()?;
    if !stand {
        return None;
    }
    let lattice = air.model == Model::Lattice;
    if lattice {
        let sizes = drafts.iter().map(|draft| (draft.surface.strips, draft.surface.chord_panels));
        if !lattice_size(sizes, air.wake_rows, checker) {
            return None;
        }
    }
    let builders = surfaces;
    let surfaces = place_all(&drafts, flaps, (lattice, lattice || air.tip_loss), bodies, mirror, checker)?;
    let smallest_m = surfaces
        .iter()
        .flat_map(|surface| surface.chords.iter().map(|chord| chord.length_m() / surface.chord_panels as f64))
        .fold(f64::INFINITY, f64::min);
    let chords = surfaces.iter().flat_map(|surface| &surface.chords);
    let shortest_m = chords.map(|chord| chord.length_m()).fold(f64::INFINITY, f64::min);
    let step_s = match air.step_s {
        Some(step_s) => step_s,
        None => match fastest_m_s(&surfaces, bodies, air.wind_m_s, start_time_s) {
            Some(speed_m_s) => smallest_m / speed_m_s,
            None => {
                let allowed =
                    "a finite time > 0 s: it has no default if the wing does not move relative to the air at the start";
                checker.refuse(&["air", "step_s"], "none", allowed);
                return None;
            }
        },
    };
    let options = if lattice {
        AirOptions::Lattice(LatticeOptions {
            wake: air.wake,
            wake_rows: air.wake_rows,
            core_radius_m: air.core_radius_m.unwrap_or(CORE_SHARE * smallest_m),
            load_rule: if air.leading_edge_suction.unwrap_or(false) {
                LoadRule::KuttaJoukowski
            } else {
                LoadRule::Bernoulli
            },
            mirror_normal: mirror,
            ground,
            speed_of_sound_m_s: air.speed_of_sound_m_s,
            threads: air.threads,
        })
    } else if let Some(rotor) = &air.rotor {
        if let Some(lag_s) = rotor.features.inflow_lag_s.filter(|lag_s| *lag_s < step_s) {
            let allowed = format!("a finite time >= {} s, the aerodynamic step", shortest(step_s));
            checker.refuse(&["air", "inflow_lag_s"], shortest(lag_s), allowed);
            return None;
        }
        AirOptions::Rotor(Box::new(rotor.options(builders, &surfaces, bodies, checker)?))
    } else {
        AirOptions::Strips(StripOptions {
            unsteady: air.unsteady,
            apparent_mass: air.apparent_mass,
            fit: air.fit,
            leading_edge_suction: air.leading_edge_suction.unwrap_or(true),
            tip_loss: air.tip_loss.then(|| LiftingLineOptions {
                core_radius_m: air.core_radius_m.unwrap_or(CORE_SHARE * shortest_m),
                mirror_normal: mirror,
            }),
            speed_of_sound_m_s: air.speed_of_sound_m_s,
        })
    };
    Some(Air {
        options,
        density_kg_m3: air.density_kg_m3,
        wind_m_s: air.wind_m_s,
        step_s,
        coupling: air.coupling,
        established: air.established,
        reports_circulation: air.reports_circulation,
        flaps: flap::build(flaps, builders, &surfaces, bodies),
        surfaces,
        gusts,
    })
}

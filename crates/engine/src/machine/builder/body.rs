//! Bodies and their attachments in code: equivalents of the tables `[body.<name>]`, `[mass.<name>]`, `[gauge.<name>]`,
//! `[internal_load.<name>]` and `[loop.<name>]` of the model file.

use crate::beam::axis::{AxisEnds, NaturalShape};
use crate::beam::law::{NaturalStrain, SectionLaw};
use crate::beam::profile::Profile;
use crate::beam::section::{Material, Solid};
use crate::load::{LoadFrame, Wrench};
use crate::machine::fault::{Checker, array_text};
use crate::machine::units::shortest;
use crate::machine::validate::MAXIMUM_STATIONS_OF_BODY;
use crate::machine::{
    AttachedMass, Body, Closure, ElementKind, Gauge, InternalLoad, Joint, LoopEnd, ModalLaw, SectionSide,
};
use crate::math::strain::{STRAINS, Strain};
use nalgebra::{Matrix3, Vector3};

/// Default number of load stations of a body.
const DEFAULT_STATIONS: usize = 4;

/// Load stations under construction.
#[derive(Debug, Clone, PartialEq)]
enum Stations {
    /// At the centres of this number of equal intervals.
    Equal(usize),
    /// At distances in m from the inner end.
    At(Vec<f64>),
}

/// A body under construction, see [`Body::beam`], [`Body::rigid`].
#[derive(Debug, Clone, PartialEq)]
pub struct BodyBuilder {
    pub(super) name: String,
    pub(super) length_m: f64,
    section: SectionLaw,
    aerofoil: Vec<[f64; 2]>,
    element: ElementKind,
    elements: usize,
    natural_strain: NaturalStrain,
    axis: Option<AxisEnds>,
    mass_damping_1_s: f64,
    damp_attached_masses: bool,
    stiffness_damping_s: f64,
    stiffness_damping_factors: Strain,
    shear_damping_factors: [f64; 2],
    modal_damping_ratios: Vec<f64>,
    stations: Stations,
    load_frame: LoadFrame,
    own_mass: Option<AttachedMass>,
}

impl Body {
    /// A beam with a name, its length in m and its section: a [`Solid`], a [`Section`](crate::beam::section::Section) or a [`SectionLaw`]
    /// that varies along it. The number of elements must be set.
    pub fn beam(name: impl Into<String>, length_m: f64, section: impl Into<SectionLaw>) -> BodyBuilder {
        BodyBuilder {
            name: name.into(),
            length_m,
            section: section.into(),
            aerofoil: Vec::new(),
            element: ElementKind::Linear,
            elements: 0,
            natural_strain: [0.0; STRAINS].into(),
            axis: None,
            mass_damping_1_s: 0.0,
            damp_attached_masses: false,
            stiffness_damping_s: 0.0,
            stiffness_damping_factors: Strain::repeat(1.0),
            shear_damping_factors: [1.0; 2],
            modal_damping_ratios: Vec::new(),
            stations: Stations::Equal(DEFAULT_STATIONS),
            load_frame: LoadFrame::Root,
            own_mass: None,
        }
    }

    /// A modal body with a name. It has no load stations by default.
    pub fn modal(name: impl Into<String>, law: ModalLaw) -> BodyBuilder {
        let (length_m, cells) = (law.length_m, law.cells);
        BodyBuilder { elements: cells, stations: Stations::Equal(0), ..Self::beam(name, length_m, law) }
    }

    /// A rigid body with a name: a frame with one load station, massless until [`BodyBuilder::inertia`] or attached masses add mass.
    /// Children are attached at a distance from its frame by [`JointBuilder::offset_m`](super::JointBuilder::offset_m).
    pub fn rigid(name: impl Into<String>) -> BodyBuilder {
        let unused = Solid::rectangle(1.0, 1.0, Material::isotropic(1.0, 0.0, 1.0));
        BodyBuilder { stations: Stations::At(vec![0.0]), ..Self::beam(name, 0.0, unused) }
    }
}

impl BodyBuilder {
    /// Mass in kg, centre of mass in m and inertia about the centre of mass in kg·m², body frame, of a rigid body.
    pub fn inertia(
        self,
        mass_kg: f64,
        centre_of_mass_m: impl Into<Vector3<f64>>,
        inertia_kg_m2: impl Into<Matrix3<f64>>,
    ) -> Self {
        let (offset_m, inertia_kg_m2) = (centre_of_mass_m.into(), inertia_kg_m2.into());
        let own = AttachedMass { offset_m, inertia_kg_m2, ..AttachedMass::point(&self.name, 0.0, mass_kg) };
        Self { own_mass: Some(own), ..self }
    }

    /// Requires of the principal moments of [`Self::inertia`] only that they are positive, for effective inertias such as one about a
    /// single axis.
    pub fn allow_nonphysical_inertia(mut self) -> Self {
        if let Some(own) = &mut self.own_mass {
            own.allow_nonphysical_inertia = true;
        }
        self
    }

    /// Number of elements along the body: 1 to 1000. Required.
    pub fn elements(self, elements: usize) -> Self {
        Self { elements, ..self }
    }

    /// Outline of the aerofoil whose skin is the section, used in pictures only: points `[x, z]` as fractions of the chord, `x` from the
    /// leading edge, from the trailing edge over one side to the leading edge and back along the other. Default: none.
    pub fn aerofoil(self, outline: impl Into<Vec<[f64; 2]>>) -> Self {
        Self { aerofoil: outline.into(), ..self }
    }

    /// Kind of strain element. Default [`ElementKind::Linear`].
    pub fn element(self, element: ElementKind) -> Self {
        Self { element, ..self }
    }

    /// Natural twist and curvatures `[κx, κy, κz]` in 1/m, constant along the body. Default 0.
    pub fn natural_curvature_1_m(self, curvature_1_m: [f64; 3]) -> Self {
        self.natural_curvature_along_1_m(curvature_1_m.map(Profile::constant))
    }

    /// Natural twist and curvatures `κx`, `κy`, `κz` in 1/m as functions of the distance from the inner end in m.
    pub fn natural_curvature_along_1_m(self, curvature_1_m: [Profile; 3]) -> Self {
        self.natural_strain(NaturalStrain::curved(curvature_1_m))
    }

    /// Natural strain `(εx, κx, κy, κz)` along the body. Default 0.
    pub fn natural_strain(self, natural_strain: NaturalStrain) -> Self {
        Self { natural_strain, ..self }
    }

    /// Unloaded shape given by the axis of a body, [`Axis::natural_shape`](crate::beam::axis::Axis::natural_shape); its first section has
    /// the frame of the body, at the joint.
    pub fn natural_shape(self, shape: NaturalShape) -> Self {
        Self { natural_strain: shape.strain, axis: Some(shape.ends), ..self }
    }

    /// Mass-proportional damping in 1/s. Default 0.
    pub fn mass_damping_1_s(self, damping_1_s: f64) -> Self {
        Self { mass_damping_1_s: damping_1_s, ..self }
    }

    /// Whether the mass-proportional damping also acts on attached masses. Default false.
    pub fn damp_attached_masses(self, damped: bool) -> Self {
        Self { damp_attached_masses: damped, ..self }
    }

    /// Stiffness-proportional damping in s. Default 0.
    pub fn stiffness_damping_s(self, damping_s: f64) -> Self {
        Self { stiffness_damping_s: damping_s, ..self }
    }

    /// Factors of the stiffness-proportional damping in stretch, twist, flapwise and edgewise bending, `(εx, κx, κy, κz)`. Default 1.
    pub fn stiffness_damping_factors(self, shares: impl Into<Strain>) -> Self {
        Self { stiffness_damping_factors: shares.into(), ..self }
    }

    /// Factors of the stiffness-proportional damping in the shears `(γy, γz)` of a body with shear. Default 1.
    pub fn shear_damping_factors(self, shares: [f64; 2]) -> Self {
        Self { shear_damping_factors: shares, ..self }
    }

    /// Damping ratios of the lowest modes of the beam, clamped at its inner end with its attached masses, in ascending frequency; at most
    /// [`MAXIMUM_DAMPED_MODES`](crate::multibody::mode_damping::MAXIMUM_DAMPED_MODES). Default: none.
    pub fn modal_damping_ratios(self, ratios: impl Into<Vec<f64>>) -> Self {
        Self { modal_damping_ratios: ratios.into(), ..self }
    }

    /// Load stations at the centres of this number of equal intervals, 0 to 1000. Default 4.
    pub fn load_stations(self, count: usize) -> Self {
        Self { stations: Stations::Equal(count), ..self }
    }

    /// Load stations at distances in m from the inner end, ascending.
    pub fn load_station_positions_m(self, positions_m: impl Into<Vec<f64>>) -> Self {
        Self { stations: Stations::At(positions_m.into()), ..self }
    }

    /// Frame of the loads at the stations. Default [`LoadFrame::Root`].
    pub fn load_frame(self, load_frame: LoadFrame) -> Self {
        Self { load_frame, ..self }
    }

    /// Builds the body with its joint; too many load stations are an error and are omitted.
    pub(super) fn build(&self, mut joint: Joint, checker: &mut Checker) -> Body {
        if let Some(axis) = &self.axis {
            joint.mount *= axis.first;
            joint.kind.turn_body_axis(&axis.first.transpose());
        }
        let station_positions_m: Vec<f64> = match &self.stations {
            Stations::At(positions_m) => positions_m.clone(),
            Stations::Equal(count) => {
                let fits = checker.count(&["body", &self.name, "load_stations"], *count, 0, MAXIMUM_STATIONS_OF_BODY);
                let count = if fits { *count } else { 0 };
                (0..count).map(|i| self.length_m * (i as f64 + 0.5) / count as f64).collect()
            }
        };
        Body {
            name: self.name.clone(),
            length_m: self.length_m,
            section: self.section.clone(),
            aerofoil: self.aerofoil.clone(),
            element: self.element,
            elements: self.elements,
            natural_strain: self.natural_strain.clone(),
            axis: self.axis,
            mass_damping_1_s: self.mass_damping_1_s,
            damp_attached_masses: self.damp_attached_masses,
            stiffness_damping_s: self.stiffness_damping_s,
            stiffness_damping_factors: self.stiffness_damping_factors,
            shear_damping_factors: self.shear_damping_factors,
            modal_damping_ratios: self.modal_damping_ratios.clone(),
            station_loads: vec![Wrench::default(); station_positions_m.len()],
            station_positions_m,
            load_frame: self.load_frame,
            masses: self.own_mass.iter().cloned().collect(),
            joint,
        }
    }
}

impl AttachedMass {
    /// A point mass in kg on the axis, at a distance in m from its body's inner end. Its offset and inertia can be set.
    pub fn point(name: impl Into<String>, position_m: f64, mass_kg: f64) -> Self {
        let (offset_m, inertia_kg_m2) = (Vector3::zeros(), Matrix3::zeros());
        Self { name: name.into(), position_m, mass_kg, offset_m, inertia_kg_m2, allow_nonphysical_inertia: false }
    }
}

/// A strain gauge under construction, see [`Gauge::on`].
#[derive(Debug, Clone, PartialEq)]
pub struct GaugeBuilder {
    pub(super) name: String,
    pub(super) body: String,
    position_m: f64,
    y_m: f64,
    z_m: Option<f64>,
    direction: Vector3<f64>,
}

impl Gauge {
    /// A gauge along the axis on the upper face of the named body, at a distance in m from its inner end.
    pub fn on(name: impl Into<String>, body: impl Into<String>, position_m: f64) -> GaugeBuilder {
        let (y_m, z_m, direction) = (0.0, None, Vector3::x());
        GaugeBuilder { name: name.into(), body: body.into(), position_m, y_m, z_m, direction }
    }
}

impl GaugeBuilder {
    /// Chordwise coordinate in m. Default 0.
    pub fn y_m(self, y_m: f64) -> Self {
        Self { y_m, ..self }
    }

    /// Thickness coordinate in m. Default: the upper face.
    pub fn z_m(self, z_m: f64) -> Self {
        Self { z_m: Some(z_m), ..self }
    }

    /// Direction of the fibre in the section frame, of any nonzero length. Default: along the axis.
    pub fn direction(self, direction: impl Into<Vector3<f64>>) -> Self {
        Self { direction: direction.into(), ..self }
    }

    /// Builds the gauge on its body; `None` if its direction has zero length.
    pub(super) fn build(&self, index: usize, law: &SectionLaw, checker: &mut Checker) -> Option<Gauge> {
        let Some(direction) = self.direction.try_normalize(0.0).filter(|unit| unit.norm() > 0.5) else {
            let found = array_text(self.direction.as_slice());
            checker.refuse(&["gauge", &self.name, "direction"], found, "an array of 3 finite numbers, not all 0");
            return None;
        };
        let z_m = self.z_m.unwrap_or_else(|| law.at(self.position_m).half_height_m);
        let (name, position_m) = (self.name.clone(), self.position_m);
        Some(Gauge { name, body: index, position_m, y_m: self.y_m, z_m, direction })
    }
}

/// An internal-load section under construction, see [`InternalLoad::on`].
#[derive(Debug, Clone, PartialEq)]
pub struct InternalLoadBuilder {
    pub(super) name: String,
    pub(super) body: String,
    position_m: f64,
    side: SectionSide,
}

impl InternalLoad {
    /// A section of the named body at a distance in m from its inner end, inboard of parts attached there.
    pub fn on(name: impl Into<String>, body: impl Into<String>, position_m: f64) -> InternalLoadBuilder {
        InternalLoadBuilder { name: name.into(), body: body.into(), position_m, side: SectionSide::Inboard }
    }
}

impl InternalLoadBuilder {
    /// Moves the section outboard of the parts attached at its position. Default: inboard.
    pub fn outboard(self) -> Self {
        Self { side: SectionSide::Outboard, ..self }
    }

    /// Builds the section on its body.
    pub(super) fn build(&self, index: usize) -> InternalLoad {
        InternalLoad { name: self.name.clone(), body: index, position_m: self.position_m, side: self.side }
    }
}

/// A closed loop under construction, see [`Closure::between`].
#[derive(Debug, Clone, PartialEq)]
pub struct ClosureBuilder {
    pub(super) name: String,
    pub(super) bodies: [String; 2],
    positions_m: Option<[f64; 2]>,
    offsets_m: [Vector3<f64>; 2],
    rigid: bool,
    stiffness_n_m: f64,
    damping_n_s_m: f64,
    inertia_kg: f64,
}

impl Closure {
    /// A ball joint that closes a loop between the outer ends of two bodies, with a penalty stiffness in N/m. `"root"` in place of a body is
    /// a point fixed in the root frame, at its offset from the origin.
    pub fn between(name: impl Into<String>, bodies: [&str; 2], stiffness_n_m: f64) -> ClosureBuilder {
        ClosureBuilder {
            name: name.into(),
            bodies: bodies.map(str::to_owned),
            positions_m: None,
            offsets_m: [Vector3::zeros(); 2],
            rigid: false,
            stiffness_n_m,
            damping_n_s_m: 0.0,
            inertia_kg: 0.0,
        }
    }

    /// A ball joint that closes a loop between the outer ends of two bodies, or a body and `"root"`, whose points coincide to round-off:
    /// constraint forces hold them, without a penalty.
    pub fn rigid(name: impl Into<String>, bodies: [&str; 2]) -> ClosureBuilder {
        ClosureBuilder { rigid: true, ..Self::between(name, bodies, 0.0) }
    }
}

impl ClosureBuilder {
    /// Distances of the sections from the bodies' inner ends in m, 0 for the root. Default: their outer ends.
    pub fn positions_m(self, positions_m: [f64; 2]) -> Self {
        Self { positions_m: Some(positions_m), ..self }
    }

    /// Offsets of the points from the sections' axes in m, section frames; for the root its position in the root frame. Default 0.
    pub fn offsets_m(self, offsets_m: [[f64; 3]; 2]) -> Self {
        Self { offsets_m: offsets_m.map(Into::into), ..self }
    }

    /// Penalty stiffness in N/m, which a rigid loop does not have.
    pub fn stiffness_n_m(self, stiffness_n_m: f64) -> Self {
        Self { stiffness_n_m, ..self }
    }

    /// Penalty damping in N·s/m. Default 0.
    pub fn damping_n_s_m(self, damping_n_s_m: f64) -> Self {
        Self { damping_n_s_m, ..self }
    }

    /// Penalty inertia in kg, which acts on the gap only. Default 0.
    pub fn inertia_kg(self, inertia_kg: f64) -> Self {
        Self { inertia_kg, ..self }
    }

    /// Builds the loop between bodies found by name, or the root; `None` if one does not exist.
    pub(super) fn build(&self, bodies: &[Body], checker: &mut Checker) -> Option<Closure> {
        let place = ["loop", self.name.as_str(), "bodies"];
        let mut ends = [LoopEnd::Root; 2];
        for (side, end) in ends.iter_mut().enumerate() {
            let name = self.bodies[side].as_str();
            if name == "root" {
                if let Some(positions_m) = self.positions_m.filter(|positions_m| positions_m[side] != 0.0) {
                    let allowed = "0 for the root: the point is fixed in the root frame at its offset in offsets_m";
                    checker.refuse(&["loop", &self.name, "positions_m"], array_text(&positions_m), allowed);
                }
                continue;
            }
            let Some(index) = bodies.iter().position(|body| body.name == name) else {
                checker.unknown_name(&place, name, "names of bodies", bodies.iter().map(|body| body.name.as_str()));
                return None;
            };
            let position_m = self.positions_m.map_or(bodies[index].length_m, |positions_m| positions_m[side]);
            *end = LoopEnd::Body { index, position_m };
        }
        Some(Closure {
            name: self.name.clone(),
            ends,
            offsets_m: self.offsets_m,
            rigid: self.rigid,
            inertia_kg: self.inertia_kg,
            damping_n_s_m: self.damping_n_s_m,
            stiffness_n_m: self.stiffness_n_m,
        })
    }
}

/// Adds a load at a station of a body, counted from 1; reports an error if the station does not exist.
pub(super) fn add_load(name: &str, station: usize, load: &Wrench, body: &mut Body, checker: &mut Checker) {
    let count = body.station_loads.len();
    match station.checked_sub(1).and_then(|index| body.station_loads.get_mut(index)) {
        Some(sum) => {
            sum.force_n += load.force_n;
            sum.moment_n_m += load.moment_n_m;
        }
        None => {
            let allowed = match count {
                0 => format!("a body with load stations: {:?} has none", body.name),
                count => format!("a whole number from 1 to {count}, the number of load stations of {:?}", body.name),
            };
            checker.refuse(&["load", name, "station"], shortest(station as f64), allowed);
        }
    }
}

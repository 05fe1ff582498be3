//! Aerodynamic models side by side in one flow: each has its own surfaces, and no model induces velocities at the surfaces of another.

use crate::aero::established::Established;
use crate::aero::flap::{Deflection, Flap, HingeMoment};
use crate::aero::flow::{AirPath, Flow};
use crate::aero::near_sheets::NoCirculation;
use crate::aero::rotor::loads::RotorLoads;
use crate::aero::surface::{Edge, Surface};
use crate::aero::{AirLoads, AirModel, AirOptions, AirState};
use crate::load::SectionMotion;
use serde::{Deserialize, Serialize};

/// A part of the aerodynamics: the model of some of the surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct AirPart {
    /// Name; empty for the single model of a machine whose aerodynamics has no named parts.
    pub name: String,
    /// Aerodynamic model with its settings.
    pub options: AirOptions,
    /// Indices of its surfaces in the list of all surfaces, ascending; empty for a slender body.
    pub surfaces: Vec<usize>,
}

/// One model with its place among all sections, surfaces and control surfaces, and its scratch.
pub(super) struct Placed {
    pub(super) model: AirModel,
    /// Sections in the model's order: those of its surfaces, then that of a rotor's hub, or those of a slender body.
    pub(super) sections: Vec<usize>,
    surfaces: Vec<usize>,
    pub(super) flaps: Vec<usize>,
    pub(super) motions: Vec<SectionMotion>,
    loads: AirLoads,
    pub(super) deflections: Vec<Deflection>,
}

/// The aerodynamic models of a machine. Sections are in the order of the surfaces, followed by those of rotors' hubs and slender bodies in
/// the order of the parts.
pub struct AirModels {
    pub(super) parts: Vec<Placed>,
    /// Per section: whether its model uses instantaneous velocities, [`AirModel::sees_instants`].
    instants: Vec<bool>,
}

/// States of the aerodynamic models of a machine, part by part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct AirStates(pub Vec<AirState>);

impl Placed {
    /// Copies the motions of the model's sections from those of all sections.
    pub(super) fn gather(&mut self, motions: &[SectionMotion]) {
        self.motions.iter_mut().zip(&self.sections).for_each(|(own, section)| *own = motions[*section]);
    }

    /// Copies the loads of the model's sections to those of all sections.
    fn scatter(&self, loads: &mut AirLoads) {
        for (own, section) in self.sections.iter().enumerate() {
            loads.circulatory[*section] = self.loads.circulatory[own];
            loads.impulsive[*section] = self.loads.impulsive[own];
        }
    }

    /// Replaces indices of the model's surfaces in an error by those in the list of all surfaces.
    pub(super) fn name(&self, error: NoCirculation) -> NoCirculation {
        error.with_surfaces(|surface| self.surfaces[surface])
    }
}

impl AirModels {
    /// Makes the models of all parts; every surface belongs to one part. Control surfaces have zero deflection and rate.
    pub fn new(surfaces: &[Surface], flaps: &[Flap], parts: &[AirPart], still: SectionMotion) -> Self {
        let mut hubs = surfaces.iter().map(|surface| surface.sections.len()).sum::<usize>();
        let mut sections_of = |part: &AirPart| {
            let of_surfaces = part.surfaces.iter().flat_map(|&surface| surfaces[surface].sections.clone());
            let mut sections: Vec<usize> = of_surfaces.collect();
            if part.options.is_rotor() {
                sections.push(hubs);
                hubs += 1;
            }
            if let Some(body) = part.options.slender_body() {
                sections.extend(hubs..hubs + body.positions_m.len());
                hubs += body.positions_m.len();
            }
            sections
        };
        let place = |part: &AirPart| {
            let mut first = 0;
            let own = part.surfaces.iter().map(|&surface| {
                let surface = &surfaces[surface];
                let begin = first;
                first += surface.sections.len();
                Surface { sections: begin..first, ..surface.clone() }
            });
            let mut model = AirModel::new(own.collect(), &part.options);
            let sections = sections_of(part);
            let local = |flap: &Flap| part.surfaces.iter().position(|surface| *surface == flap.surface);
            let found = flaps.iter().enumerate();
            let found = found.filter_map(|(index, flap)| Some((index, Flap { surface: local(flap)?, ..flap.clone() })));
            let (flaps, own): (Vec<usize>, Vec<Flap>) = found.unzip();
            model.add_flaps(&own);
            Placed {
                model,
                motions: vec![still; sections.len()],
                loads: AirLoads::still(sections.len()),
                deflections: vec![Deflection::default(); flaps.len()],
                sections,
                surfaces: part.surfaces.clone(),
                flaps,
            }
        };
        let parts: Vec<Placed> = parts.iter().map(place).collect();
        let mut instants = vec![false; hubs];
        for part in parts.iter().filter(|part| part.model.sees_instants()) {
            part.sections.iter().for_each(|section| instants[*section] = true);
        }
        Self { parts, instants }
    }

    /// Number of sections of all models.
    pub fn sections(&self) -> usize {
        self.instants.len()
    }

    /// The model of all surfaces; `None` if there are several.
    pub fn only(&self) -> Option<&AirModel> {
        match &self.parts[..] {
            [part] => Some(&part.model),
            _ => None,
        }
    }

    /// The model of all surfaces; `None` if there are several.
    pub fn only_mut(&mut self) -> Option<&mut AirModel> {
        match &mut self.parts[..] {
            [part] => Some(&mut part.model),
            _ => None,
        }
    }

    /// The models, each with the indices of its sections among all sections.
    pub fn each(&self) -> impl Iterator<Item = (&AirModel, &[usize])> {
        self.parts.iter().map(|part| (&part.model, &part.sections[..]))
    }

    /// The models of the last [`Self::solve`] with their sections, the motions of these, and their surfaces.
    pub fn each_mut(&mut self) -> impl Iterator<Item = (&mut AirModel, &[usize], &[SectionMotion], &[usize])> {
        self.parts.iter_mut().map(|part| (&mut part.model, &part.sections[..], &part.motions[..], &part.surfaces[..]))
    }

    /// Joins two surface edges where their bodies are connected, if one model has both (lattice and lifting line).
    pub fn join(&mut self, edges: [Edge; 2]) {
        for part in &mut self.parts {
            let local = edges.map(|edge| part.surfaces.iter().position(|surface| *surface == edge.surface));
            if let [Some(one), Some(two)] = local {
                part.model.join([Edge { surface: one, ..edges[0] }, Edge { surface: two, ..edges[1] }]);
            }
        }
    }

    /// Joins a surface edge at the mirror plane with its image, in the model that has it.
    pub fn join_image(&mut self, edge: Edge) {
        for part in &mut self.parts {
            if let Some(surface) = part.surfaces.iter().position(|surface| *surface == edge.surface) {
                part.model.join_image(Edge { surface, ..edge });
            }
        }
    }

    /// Sets the deflections of all control surfaces, as [`AirModel::deflect`].
    pub fn deflect(&mut self, deflections: &[Deflection]) {
        for Placed { model, flaps, deflections: own, .. } in &mut self.parts {
            own.iter_mut().zip(&*flaps).for_each(|(own, flap)| *own = deflections[*flap]);
            model.deflect(own);
        }
    }

    /// Returns empty states of the right sizes.
    pub fn blank_state(&self) -> AirStates {
        AirStates(self.parts.iter().map(|part| part.model.blank_state()).collect())
    }

    /// Computes the initial states and loads, as [`AirModel::start`].
    ///
    /// # Errors
    /// Those of [`AirModel::start`], with the index of a surface in the list of all surfaces.
    pub fn start(
        &mut self,
        motions: &[SectionMotion],
        flow: &Flow,
        established: Option<Established>,
        states: &mut AirStates,
        loads: &mut AirLoads,
    ) -> Result<(), NoCirculation> {
        for (part, state) in self.parts.iter_mut().zip(&mut states.0) {
            part.gather(motions);
            let started = part.model.start(&part.motions, flow, established, state, &mut part.loads);
            started.map_err(|error| part.name(error))?;
            part.scatter(loads);
        }
        Ok(())
    }

    /// Convects the flow to the end of a step, as [`AirModel::convect`].
    pub fn convect(&mut self, from: &AirStates, flow: &Flow, step_s: f64, to: &mut AirStates) {
        for (part, (from, to)) in self.parts.iter_mut().zip(from.0.iter().zip(&mut to.0)) {
            part.model.convect(from, flow, step_s, to);
        }
    }

    /// Computes states and loads at the end of a step, as [`AirModel::solve`].
    ///
    /// # Errors
    /// Those of [`AirModel::solve`], with the index of a surface in the list of all surfaces.
    pub fn solve(
        &mut self,
        from: &AirStates,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        to: &mut AirStates,
        loads: &mut AirLoads,
    ) -> Result<(), NoCirculation> {
        for (part, (from, to)) in self.parts.iter_mut().zip(from.0.iter().zip(&mut to.0)) {
            part.gather(motions);
            let solved = part.model.solve(from, &part.motions, flow, step_s, to, &mut part.loads);
            solved.map_err(|error| part.name(error))?;
            part.scatter(loads);
        }
        Ok(())
    }

    /// Length of the longest wake row of a step in panel chords, as [`AirModel::row_panels`].
    pub fn row_panels(&self, from: &AirStates, to: &AirStates, path: &AirPath) -> f64 {
        let states = from.0.iter().zip(&to.0);
        let rows = self.parts.iter().zip(states).map(|(part, (from, to))| part.model.row_panels(from, to, path));
        rows.fold(0.0, f64::max)
    }

    /// Whether strips of the lattice have stalled, as [`AirModel::lags_beyond_stall`].
    pub fn lags_beyond_stall(&self, states: &AirStates) -> bool {
        self.parts.iter().zip(&states.0).any(|(part, state)| part.model.lags_beyond_stall(state))
    }

    /// Per section: whether its model uses instantaneous velocities, as [`AirModel::sees_instants`].
    pub fn instants(&self) -> &[bool] {
        &self.instants
    }

    /// Circulation of a strip of a surface in m²/s, as [`AirModel::strip_circulation_m2_s`].
    pub fn strip_circulation_m2_s(&self, states: &AirStates, surface: usize, strip: usize) -> f64 {
        let found = self.parts.iter().zip(&states.0).find_map(|(part, state)| {
            let own = part.surfaces.iter().position(|own| *own == surface)?;
            Some(part.model.strip_circulation_m2_s(state, own, strip))
        });
        found.unwrap_or_default()
    }

    /// Hinge moment of a control surface.
    pub fn hinge_moment(&self, states: &AirStates, flap: usize) -> HingeMoment {
        let found = self.parts.iter().zip(&states.0).find_map(|(part, state)| {
            let own = part.flaps.iter().position(|own| *own == flap)?;
            state.hinge_moments().get(own).copied()
        });
        found.unwrap_or_default()
    }

    /// Index of the first surface that is a blade parallel to the shaft of its rotor.
    pub fn blade_along_shaft(&mut self, motions: &[SectionMotion]) -> Option<usize> {
        self.parts.iter_mut().find_map(|part| {
            part.gather(motions);
            match &part.model {
                AirModel::Rotor(rotor) => Some(part.surfaces[rotor.blade_along_shaft(&part.motions)?]),
                AirModel::Lattice(_) | AirModel::Strips(_) | AirModel::SlenderBody(_) => None,
            }
        })
    }
}

impl AirStates {
    /// Copies other states of the same models without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(own, other)| own.copy_from(other));
    }

    /// Copies the initial values for the search of a steady flow, as [`AirState::go_on_from`].
    pub fn go_on_from(&mut self, earlier: &Self) {
        self.0.iter_mut().zip(&earlier.0).for_each(|(own, earlier)| own.go_on_from(earlier));
    }

    /// The state of the model of all surfaces; `None` if there are several.
    pub fn only(&self) -> Option<&AirState> {
        match &self.0[..] {
            [state] => Some(state),
            _ => None,
        }
    }

    /// The state of the model of all surfaces; `None` if there are several.
    pub fn only_mut(&mut self) -> Option<&mut AirState> {
        match &mut self.0[..] {
            [state] => Some(state),
            _ => None,
        }
    }

    /// Loads of the rotors, in the order of the parts.
    pub fn rotor_loads(&self) -> impl Iterator<Item = &RotorLoads> {
        self.0.iter().filter_map(AirState::rotor_loads)
    }

    /// Whether other states have the same sizes.
    pub fn fits(&self, other: &Self) -> bool {
        self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(|(own, other)| own.fits(other))
    }
}

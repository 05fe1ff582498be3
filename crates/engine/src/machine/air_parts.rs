//! The aerodynamic models of a machine.

use crate::aero::rotor::options::RotorOptions;
use crate::aero::slender::SlenderBodyOptions;
use crate::machine::{Air, AirOptions, AirPart};

impl Air {
    /// The model of all surfaces with its settings; `None` if there are several.
    pub fn only(&self) -> Option<&AirOptions> {
        match &self.parts[..] {
            [part] => Some(&part.options),
            _ => None,
        }
    }

    /// The rotors with the parts that they are.
    pub fn rotors(&self) -> impl Iterator<Item = (&AirPart, &RotorOptions)> {
        self.parts.iter().filter_map(|part| Some((part, part.options.rotor()?)))
    }

    /// The slender bodies with the parts that they are.
    pub fn slender_bodies(&self) -> impl Iterator<Item = (&AirPart, &SlenderBodyOptions)> {
        self.parts.iter().filter_map(|part| Some((part, part.options.slender_body()?)))
    }

    /// Whether the machine has air loads on a body: from a lifting surface, or as a slender body.
    pub fn loads_body(&self, body: usize) -> bool {
        self.surfaces.iter().any(|surface| surface.body == body)
            || self.slender_bodies().any(|(_, slender)| slender.body == body)
    }

    /// Whether all surfaces are blades of rotors.
    pub fn is_rotor(&self) -> bool {
        self.parts.iter().all(|part| part.options.is_rotor())
    }

    /// The part to which a surface belongs, with the index of the surface in it.
    pub fn part_of(&self, surface: usize) -> Option<(&AirPart, usize)> {
        self.parts.iter().find_map(|part| Some((part, part.surfaces.iter().position(|own| *own == surface)?)))
    }

    /// Whether all models have a linear form with their lags, as [`AirOptions::is_linearised`].
    pub fn is_linearised(&self) -> bool {
        self.parts.iter().all(|part| part.options.is_linearised())
    }

    /// Whether the loads of all models can be evaluated at an instant for an external integrator, as [`AirOptions::is_continuous`].
    pub fn is_continuous(&self) -> bool {
        self.parts.iter().all(|part| part.options.is_continuous())
    }
}

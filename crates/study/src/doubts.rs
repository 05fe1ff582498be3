//! Doubts about a result: assumptions of the models of the air that a machine does not meet.

use foldwing_engine::machine::{Air, AirOptions, LoadRule, Machine};
use foldwing_engine::plant::Plant;
use nalgebra::Vector3;
use serde::{Serialize, Serializer};
use std::fmt;
use std::sync::Arc;

/// Angle between wind and chord in rad from which on the flow is along the span or from behind: 60 degrees, beyond which sweep theory
/// leaves less than a quarter of the dynamic pressure.
const MAXIMUM_FLOW_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0 - 1e-9;

/// An assumption that is not met. Its text is a sentence for people; serialised, it is that text.
#[derive(Debug, Clone, PartialEq)]
pub enum Doubt {
    /// The wind does not meet a surface from the leading edge: lattices, lifting lines and strips are those of attached flow that leaves
    /// at the trailing edge.
    Flow {
        /// Body of the surface.
        body: String,
        /// Largest angle between the wind and the chord in rad.
        angle_rad: f64,
    },
    /// A lattice without suction at the leading edge, where loads are to be balanced.
    NoSuction,
    /// Strips of a lattice beyond stall in an equilibrium, of which there may be others.
    Stall {
        /// Body and number of its strips.
        strips: Vec<(String, usize)>,
    },
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Flow { body, angle_rad } => {
                let from_behind = *angle_rad > std::f64::consts::FRAC_PI_2 + 1e-9;
                let from = if from_behind { "from behind" } else { "along the span" };
                write!(
                    f,
                    "the wind meets the surface of {body} {from}, at {} deg from its chord: the aerodynamic models assume attached flow \
                     that leaves at the trailing edge, and their loads are unreliable beyond {} deg; rotate the wind or the machine",
                    four_digits(angle_rad.to_degrees()),
                    MAXIMUM_FLOW_RAD.to_degrees().round()
                )
            }
            Self::NoSuction => f.write_str(
                "the lattice has no suction at the leading edge (leading_edge_suction = false): forces along the chord, as drag and the \
                 thrust that balances it, come out too large; with leading_edge_suction = true they are those of attached flow",
            ),
            Self::Stall { strips } => {
                let names: Vec<String> = strips.iter().map(|(body, count)| format!("{count} strips of {body}")).collect();
                write!(
                    f,
                    "{} are beyond stall, where the circulation is not unique: this equilibrium is the one reached from attached flow at \
                     the start angles; a run with another history may end in another one, and all depend on the number of strips",
                    names.join(", ")
                )
            }
        }
    }
}

impl Serialize for Doubt {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// The flow over the undeformed machine in its own wind.
pub fn flow(machine: &Machine) -> Option<Doubt> {
    let air = machine.air.as_ref().filter(|air| !air.options.is_rotor())?;
    let mut plant = Plant::new(Arc::new(machine.clone()));
    plant.study().undeformed(machine.experiment.start_time_s).ok()?;
    flow_over(&plant, air, *Plant::new(Arc::new(machine.clone())).inputs().wind_m_s())
}

/// The flow over a plant in its present state and wind.
pub fn flow_at(plant: &Plant) -> Option<Doubt> {
    let air = plant.machine().air.as_ref().filter(|air| !air.options.is_rotor())?;
    flow_over(plant, air, *plant.inputs().wind_m_s())
}

fn flow_over(plant: &Plant, air: &Air, wind_m_s: Vector3<f64>) -> Option<Doubt> {
    let wind = wind_m_s.try_normalize(0.0)?;
    let mut worst: Option<(f64, usize)> = None;
    for surface in &air.surfaces {
        let sections = plant.sections(surface.body, &surface.positions_m);
        for (section, chord) in sections.iter().zip(&surface.chords) {
            let line = section.rotation * (chord.trailing_m - chord.leading_m);
            let angle_rad = wind.angle(&line);
            if worst.is_none_or(|(largest, _)| angle_rad > largest) {
                worst = Some((angle_rad, surface.body));
            }
        }
    }
    let (angle_rad, body) = worst.filter(|(angle_rad, _)| *angle_rad >= MAXIMUM_FLOW_RAD)?;
    Some(Doubt::Flow { body: plant.machine().bodies[body].name.clone(), angle_rad })
}

/// Strips of a lattice beyond stall in the state of rest of a plant.
pub fn stall_at(plant: &Plant) -> Option<Doubt> {
    let name = |body: usize| plant.machine().bodies[body].name.clone();
    let strips: Vec<(String, usize)> =
        plant.strips_beyond_stall().iter().map(|(body, count)| (name(*body), *count)).collect();
    (!strips.is_empty()).then_some(Doubt::Stall { strips })
}

/// Doubts about thrust and drag where loads are balanced: a lattice without suction at the leading edge, and the flow.
pub fn balance(machine: &Machine) -> Vec<Doubt> {
    let without_suction = machine.air.as_ref().is_some_and(|air| match &air.options {
        AirOptions::Lattice(lattice) => lattice.load_rule == LoadRule::Bernoulli,
        AirOptions::Strips(_) | AirOptions::Rotor(_) => false,
    });
    without_suction.then_some(Doubt::NoSuction).into_iter().chain(flow(machine)).collect()
}

//! Warnings about a result: assumptions of the aerodynamic models that a machine does not meet, and joints of an equilibrium that may not
//! be where they are meant to be.

use foldwing_engine::machine::{AirOptions, JointMotion, LoadRule, Machine, Travel};
use foldwing_engine::plant::Plant;
use nalgebra::Vector3;
use serde::{Serialize, Serializer};
use std::fmt;
use std::sync::Arc;

/// Angle between wind and chord in rad from which on the flow counts as spanwise or reversed: 60 degrees, beyond which sweep theory
/// leaves less than a quarter of the dynamic pressure.
const MAXIMUM_FLOW_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0 - 1e-9;

/// Incidence in rad above which missing leading-edge suction matters: the force along the chord is then 1.7 % of the force normal to it.
const MINIMUM_INCIDENCE_RAD: f64 = std::f64::consts::PI / 180.0;

/// A warning about a result. Its `Display` text is a sentence for messages; it is serialised as this text.
#[derive(Debug, Clone, PartialEq)]
pub enum Warning {
    /// The wind does not meet a surface at its leading edge; lattices, lifting lines and strips assume attached flow that leaves at the
    /// trailing edge.
    Flow {
        /// Body of the surface.
        body: String,
        /// Largest angle between the wind and the chord in rad.
        angle_rad: f64,
    },
    /// Inner edges of two surfaces on one point that are not joined.
    Slit {
        /// Bodies of the surfaces.
        bodies: [String; 2],
        /// Distance of the edges at the start in chords.
        apart_chords: f64,
    },
    /// A lattice without leading-edge suction, at incidence or where loads are to be balanced.
    NoSuction,
    /// Strips of a lattice beyond stall in an equilibrium, which may not be the only one.
    Stall {
        /// Body and number of its strips.
        strips: Vec<(String, usize)>,
    },
    /// An enabled latch that is open in an equilibrium.
    OpenLatch {
        /// The joint.
        joint: String,
        /// Type of its motion.
        travel: Travel,
        /// Its angle in rad or position in m.
        angle_rad: f64,
        /// Angle in rad or position in m of its latch.
        latch_rad: f64,
    },
    /// A hinge without end stops that rotates by more than half a revolution from its start angle to an equilibrium.
    Turned {
        /// The joint.
        joint: String,
        /// The rotation in rad.
        turn_rad: f64,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Flow { body, angle_rad } => {
                let from_behind = *angle_rad > std::f64::consts::FRAC_PI_2 + 1e-9;
                let from = if from_behind { "from behind" } else { "along the span" };
                write!(
                    f,
                    "the wind meets the surface of {body} {from}, at {} deg from its chord: the aerodynamic models assume attached flow \
                     that leaves at the trailing edge, and their loads are unreliable beyond {} deg; rotate the wind or the model",
                    four_digits(angle_rad.to_degrees()),
                    MAXIMUM_FLOW_RAD.to_degrees().round()
                )
            }
            Self::Slit { bodies: [one, other], apart_chords } => write!(
                f,
                "the inner edges of the surfaces of {one} and {other} are attached to one point but lie {} chords apart at the start: they \
                 are not joined, and each has a free edge with a tip vortex; if they are halves of one wing, place the axis where their \
                 chords meet (elastic_axis_fraction), or give the incidence by the attitude of the root",
                four_digits(*apart_chords)
            ),
            Self::NoSuction => f.write_str(
                "the lattice has no suction at the leading edge (leading_edge_suction = false): forces along the \
                 chord, such as drag and the thrust that balances it, are too large; set leading_edge_suction = true \
                 for attached flow",
            ),
            Self::Stall { strips } => {
                let names: Vec<String> =
                    strips.iter().map(|(body, count)| format!("{count} strips of {body}")).collect();
                write!(
                    f,
                    "{} are beyond stall, where the circulation is not unique: this equilibrium is the one reached \
                     from attached flow at the start angles; a run with another history may reach a different one, and \
                     each depends on the number of strips",
                    names.join(", ")
                )
            }
            Self::OpenLatch { joint, travel, angle_rad, latch_rad } => {
                let (coordinate, unit, si) = (travel.coordinate(), travel.shown_unit(), travel.units()[0]);
                write!(
                    f,
                    "the latch of joint {joint} at {} {unit} is open in this equilibrium; motor, spring and loads \
                     alone hold the joint at {} {unit}; with {joint}.start_{coordinate} = {} {si} it is closed",
                    four_digits(travel.shown(*latch_rad)),
                    four_digits(travel.shown(*angle_rad)),
                    four_digits(*latch_rad),
                )
            }
            Self::Turned { joint, turn_rad } => write!(
                f,
                "{joint} rotates by {} deg from its start angle to this equilibrium; if its parts touch before that, \
                 add end_stops or choose another start angle",
                four_digits(turn_rad.to_degrees())
            ),
        }
    }
}

impl Serialize for Warning {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

fn four_digits(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

/// Warnings about the undeformed machine in the wind of its model: direction of the flow, a lattice without suction at incidence, and slits
/// between inner edges.
pub fn undeformed(machine: &Machine) -> Vec<Warning> {
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let wind_m_s = *plant.inputs().wind_m_s();
    let mut warnings = slits(machine);
    if plant.study().undeformed(machine.experiment.start_time_s).is_ok() {
        *plant.inputs_mut().wind_m_s_mut() = wind_m_s;
        warnings.extend(air_at(&plant));
    }
    warnings
}

/// Warnings about inner edges on one point that are not joined, each pair once.
fn slits(machine: &Machine) -> Vec<Warning> {
    let name = |body: usize| machine.bodies[body].name.clone();
    let mut pairs: Vec<([usize; 2], f64)> = Vec::new();
    for surface in machine.air.iter().flat_map(|air| &air.surfaces) {
        let Some((other, apart_chords)) = surface.slit else { continue };
        let pair = [surface.body.min(other), surface.body.max(other)];
        if !pairs.iter().any(|(known, _)| *known == pair) {
            pairs.push((pair, apart_chords));
        }
    }
    let warning = |(pair, apart_chords): ([usize; 2], f64)| Warning::Slit { bodies: pair.map(name), apart_chords };
    pairs.into_iter().map(warning).collect()
}

/// Warnings about a plant in its current state and wind: direction of the flow, and a lattice without suction at incidence.
pub fn air_at(plant: &Plant) -> Vec<Warning> {
    let Some(angles) = FlowAngles::over(plant) else { return Vec::new() };
    let at_incidence = lacks_suction(plant.machine()) && angles.incidence_rad > MINIMUM_INCIDENCE_RAD;
    at_incidence.then_some(Warning::NoSuction).into_iter().chain(angles.warning(plant)).collect()
}

/// Warning about the direction of the flow over a plant in its current state and wind.
pub fn flow_at(plant: &Plant) -> Option<Warning> {
    FlowAngles::over(plant)?.warning(plant)
}

/// Angles between the wind and the chords of all surfaces except those of rotors.
struct FlowAngles {
    /// Largest angle to a chord in rad.
    largest_rad: f64,
    /// Body of the surface that has it.
    body: usize,
    /// Largest angle out of the plane of chord and span in rad.
    incidence_rad: f64,
}

impl FlowAngles {
    fn over(plant: &Plant) -> Option<Self> {
        let air = plant.machine().air.as_ref()?;
        let wind = plant.inputs().wind_m_s().try_normalize(0.0)?;
        let mut worst: Option<Self> = None;
        let of_wings = air.parts.iter().filter(|part| !part.options.is_rotor()).flat_map(|part| &part.surfaces);
        for surface in of_wings.map(|surface| &air.surfaces[*surface]) {
            let sections = plant.sections(surface.body, &surface.positions_m);
            for (section, chord) in sections.iter().zip(&surface.chords) {
                let line = section.rotation * (chord.trailing_m - chord.leading_m);
                let normal = (section.rotation * Vector3::x()).cross(&line);
                let incidence_rad = normal.try_normalize(0.0).map_or(0.0, |normal| wind.dot(&normal).abs().asin());
                let largest_rad = wind.angle(&line);
                let worst = worst.get_or_insert(Self { largest_rad, body: surface.body, incidence_rad });
                worst.incidence_rad = worst.incidence_rad.max(incidence_rad);
                if largest_rad > worst.largest_rad {
                    (worst.largest_rad, worst.body) = (largest_rad, surface.body);
                }
            }
        }
        worst
    }

    fn warning(&self, plant: &Plant) -> Option<Warning> {
        let body = || plant.machine().bodies[self.body].name.clone();
        (self.largest_rad >= MAXIMUM_FLOW_RAD).then(|| Warning::Flow { body: body(), angle_rad: self.largest_rad })
    }
}

/// Warning about strips of a lattice beyond stall in the static equilibrium of a plant.
pub fn stall_at(plant: &Plant) -> Option<Warning> {
    let name = |body: usize| plant.machine().bodies[body].name.clone();
    let strips: Vec<(String, usize)> =
        plant.strips_beyond_stall().iter().map(|(body, count)| (name(*body), *count)).collect();
    (!strips.is_empty()).then_some(Warning::Stall { strips })
}

/// Warnings about the joints of a plant in equilibrium: open latches, and hinges without end stops that are more than half a revolution
/// from their start angle. Rotor shafts are excluded, as they rotate without limit.
pub fn joints_at(plant: &Plant) -> Vec<Warning> {
    let machine = plant.machine();
    let rotors = machine.air.iter().flat_map(|air| air.rotors());
    let hubs: Vec<usize> = rotors.map(|(_, rotor)| rotor.hub_body).collect();
    let states = plant.outputs().joints().iter().zip(plant.outputs().latches()).zip(plant.inputs().joints());
    let mut warnings = Vec::new();
    for ((body, joint), ((output, latch), input)) in machine.one_freedoms().zip(states) {
        let named = &machine.bodies[body].joint;
        let Some((travel, _)) = named.kind.one_freedom() else { continue };
        let (angle_rad, is_free) = (output.angle_rad, joint.motion == JointMotion::Free && input.release.is_on());
        if let Some(own) =
            joint.latch.as_ref().filter(|_| is_free && input.latch_enable.is_on() && !latch.closed.is_on())
        {
            warnings.push(Warning::OpenLatch {
                joint: named.name.clone(),
                travel,
                angle_rad,
                latch_rad: own.angle_rad,
            });
        }
        let turn_rad = angle_rad - joint.start_angle_rad;
        let is_hinge = travel == Travel::Rotation && joint.end_stops.is_none() && !hubs.contains(&body);
        if is_free && is_hinge && turn_rad.abs() > std::f64::consts::PI {
            warnings.push(Warning::Turned { joint: named.name.clone(), turn_rad });
        }
    }
    warnings
}

/// Warnings about thrust and drag where the loads of a plant are balanced: a lattice without leading-edge suction, and the direction of
/// the flow.
pub fn balance_at(plant: &Plant) -> Vec<Warning> {
    lacks_suction(plant.machine()).then_some(Warning::NoSuction).into_iter().chain(flow_at(plant)).collect()
}

/// Returns whether the aerodynamic model is a lattice without leading-edge suction.
fn lacks_suction(machine: &Machine) -> bool {
    machine.air.iter().flat_map(|air| &air.parts).any(|part| match &part.options {
        AirOptions::Lattice(lattice) => lattice.load_rule == LoadRule::Bernoulli,
        AirOptions::Strips(_) | AirOptions::Rotor(_) | AirOptions::SlenderBody(_) => false,
    })
}

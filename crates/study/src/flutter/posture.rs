//! Equilibria at two neighbouring speeds: whether one changes continuously into the other, or the equilibrium jumps.

use crate::flutter::found::{Change, Event, JointChange};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::Plant;
use nalgebra::Vector3;

/// Distance of two equilibria, in rad or relative to the model's extent, up to which they count as one that changes continuously with
/// the speed.
const NEAR: f64 = 1e-3;
/// Number of bisections between two distant equilibria. Along a path that turns back at its end, each one reduces their distance by a
/// factor of at least √½, to 1/16 after eight.
const HALVINGS: usize = 8;
/// Ratio of the distances after and before these bisections above which the equilibrium jumps.
const JUMPS: f64 = 0.25;

/// An equilibrium to be compared with one at another speed: latches, joint coordinates, and positions of the bodies' ends relative to
/// the largest.
#[derive(Clone)]
pub struct Posture {
    latched: Vec<bool>,
    travels: Vec<f64>,
    ends: Vec<Vector3<f64>>,
}

impl Posture {
    /// The posture of a plant in its current state.
    pub fn of(plant: &Plant) -> Self {
        let ends: Vec<Vector3<f64>> =
            plant.shape().iter().filter_map(|body| body.last().map(|section| section.position_m)).collect();
        let size_m = ends.iter().map(Vector3::norm).fold(f64::MIN_POSITIVE, f64::max);
        Self {
            latched: plant.outputs().latches().iter().map(|latch| latch.closed.is_on()).collect(),
            travels: plant.outputs().joints().iter().map(|joint| joint.angle_rad).collect(),
            ends: ends.iter().map(|end| end / size_m).collect(),
        }
    }

    fn distance(&self, other: &Self) -> f64 {
        let turns = self.travels.iter().zip(&other.travels).map(|(a, b)| (a - b).abs());
        let distances = self.ends.iter().zip(&other.ends).map(|(a, b)| (a - b).norm());
        turns.chain(distances).fold(0.0, f64::max)
    }
}

/// Finds a jump of the equilibrium between two speeds in m/s by bisection; `None` if the equilibrium changes continuously with the
/// speed. Latches that open or close count as a jump even if nothing else moves. `rest` computes the equilibrium at a speed, if there is
/// one.
pub fn jump(
    machine: &Machine,
    [low, high]: [&(f64, Posture); 2],
    rest: &mut dyn FnMut(f64) -> Option<Posture>,
) -> Option<Change> {
    let (mut low, mut high) = (low.clone(), high.clone());
    let latches = low.1.latched != high.1.latched;
    let whole = low.1.distance(&high.1);
    if !latches && whole < NEAR {
        return None;
    }
    let mut lost = false;
    for _ in 0..HALVINGS {
        let middle_m_s = 0.5 * (low.0 + high.0);
        let Some(middle) = rest(middle_m_s) else {
            lost = true;
            break;
        };
        let to_low = match latches {
            true => middle.latched != low.1.latched,
            false => low.1.distance(&middle) > middle.distance(&high.1),
        };
        *(if to_low { &mut high } else { &mut low }) = (middle_m_s, middle);
        if !latches && low.1.distance(&high.1) < JUMPS * whole {
            return None;
        }
    }
    let joints = joint_changes(machine, [&low.1, &high.1]);
    let event = if latches { Event::Latch { joints, lost } } else { Event::Jump { joints, lost } };
    Some(Change { between_m_s: [low.0, high.0], event })
}

/// Joints that latch, open or move between two equilibria.
fn joint_changes(machine: &Machine, ends: [&Posture; 2]) -> Vec<JointChange> {
    let kinds = machine.bodies.iter().filter_map(|body| {
        let (travel, _) = body.joint.kind.one_freedom()?;
        Some((travel, body.joint.name.as_str()))
    });
    let mut changes = Vec::new();
    for (i, (travel, name)) in kinds.enumerate() {
        let [before, after] = ends.map(|posture| (posture.latched[i], posture.travels[i]));
        let closes = (before.0 != after.0).then_some(after.0);
        let from_to = ((before.1 - after.1).abs() >= NEAR).then_some([before.1, after.1]);
        if closes.is_some() || from_to.is_some() {
            changes.push(JointChange { joint: name.to_owned(), closes, travel, from_to });
        }
    }
    changes
}

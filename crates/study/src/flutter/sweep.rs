//! The sweep over wind speeds.

use crate::branches::pool;
use crate::flutter::found::{Change, Ended, Event, Flutter};
use crate::flutter::posture::{Posture, jump};
use crate::warnings::{self, Warning};
use crate::watch::{Progress, Watch, unwatched};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Branches, Crossing, Holding, ModeShape, Plant, PlantError, change_of_sign};
use nalgebra::Vector3;

/// Maximum number of speeds of a sweep.
pub const MAXIMUM_SPEEDS: usize = 10_000;
/// Maximum number of modes to track.
pub const MAXIMUM_COUNT: usize = 60;

/// Options of [`sweep`].
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Wind speeds in m/s, in the direction of the plant's wind: two or more, positive and ascending.
    pub wind_m_s: Vec<f64>,
    /// Number of modes of lowest frequency to track: 1 to [`MAXIMUM_COUNT`].
    pub count: usize,
}

impl Default for Options {
    /// Six modes, and no speeds.
    fn default() -> Self {
        Self { wind_m_s: Vec::new(), count: 6 }
    }
}

/// Error of a sweep over wind speeds.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FlutterError {
    /// Fewer than two speeds, or speeds that are not finite, positive and ascending.
    #[error("wind_m_s: two or more positive speeds in m/s in ascending order are needed")]
    Speeds,
    /// More than [`MAXIMUM_SPEEDS`].
    #[error("wind_m_s: {count} speeds exceed the maximum of {MAXIMUM_SPEEDS}")]
    TooManySpeeds {
        /// Number of speeds.
        count: usize,
    },
    /// No modes, or more than [`MAXIMUM_COUNT`].
    #[error("count: {count} must be from 1 to {MAXIMUM_COUNT}")]
    Count {
        /// The rejected number of modes.
        count: usize,
    },
    /// The model has no aerodynamics.
    #[error(
        "{machine}: has no aerodynamics; flutter needs [aerodynamics] with model = \"strip\" or \"uvlm\", and surfaces"
    )]
    NoAir {
        /// Name of the model.
        machine: String,
    },
    /// The model has the aerodynamics of a rotor.
    #[error(
        "{machine}: has rotor aerodynamics, which flutter does not support; use strips or a lattice (aerodynamics.model = \"strip\" or \
         \"uvlm\"), or simulate the response to a gust"
    )]
    Rotor {
        /// Name of the model.
        machine: String,
    },
    /// The flow starts impulsively with the run, so that it is not developed.
    #[error("{machine}: aerodynamics.steady_initial_flow = false: flutter needs steady initial flow; omit the key")]
    UnsteadyStart {
        /// Name of the model.
        machine: String,
    },
    /// The wind has no direction.
    #[error(
        "{machine}: the model has no wind, so its direction is undefined; set aerodynamics.wind_m_s, or a start value \
         of wind.velocity"
    )]
    NoWind {
        /// Name of the model.
        machine: String,
    },
    /// There is no equilibrium at the first speed, or there are no modes about it.
    #[error("at {wind_m_s} m/s: {error}")]
    FirstSpeed {
        /// The first speed in m/s.
        wind_m_s: f64,
        /// The reason.
        error: PlantError,
    },
    /// The watch of [`sweep_watched`] stopped the sweep.
    #[error("the sweep was stopped")]
    Stopped,
}

/// Tracks the modes of a plant over wind speeds, and finds the speeds of flutter and divergence.
///
/// `plant` has its start values and is not yet initialised; its wind gives the direction. At each speed the modes are about the
/// equilibrium with strips or a lattice, with joints locked or free according to their release inputs. If modes cannot be matched, speeds
/// are inserted. A speed without an equilibrium ends the sweep: [`Flutter::ended`].
///
/// # Errors
/// Speeds or counts that are not allowed, a model without aerodynamics that can be linearised, no result at the first speed.
pub fn sweep(plant: Plant, options: &Options) -> Result<Flutter, FlutterError> {
    sweep_watched(plant, options, &mut unwatched)
}

/// [`sweep`] with `watch` called after each wind speed, and after each of the equilibria that refine the speeds of flutter and divergence.
///
/// # Errors
/// Those of [`sweep`], and [`FlutterError::Stopped`].
pub fn sweep_watched(plant: Plant, options: &Options, watch: &mut Watch<'_>) -> Result<Flutter, FlutterError> {
    sweep_with(plant, options, &mut |_, _| (), watch)
}

/// [`sweep_watched`] that also calls `seen` with the speed in m/s and the plant in equilibrium at every speed with modes, including
/// inserted speeds and those of the searches for flutter and divergence: for pictures of the state.
///
/// # Errors
/// Those of [`sweep_watched`].
pub fn sweep_with(
    plant: Plant,
    options: &Options,
    seen: &mut dyn FnMut(f64, &Plant),
    watch: &mut Watch<'_>,
) -> Result<Flutter, FlutterError> {
    check(options)?;
    let mut tunnel = Tunnel::new(plant, options.count, seen, watch)?;
    let mut visits = Vec::new();
    let total = options.wind_m_s.len();
    let mut done = 0;
    let (mut branches, ended) = Branches::follow(&options.wind_m_s, &mut |wind_m_s| {
        let (modes, visit) = tunnel.visit(wind_m_s).map_err(Some)?;
        visits.push(visit);
        // speeds inserted for the tracking do not count
        done = done.max(options.wind_m_s.iter().filter(|speed_m_s| **speed_m_s <= wind_m_s).count());
        match tunnel.goes_on(Progress { part: "wind speeds", done, total: Some(total) }) {
            true => Ok(modes),
            false => Err(None),
        }
    });
    let ended = match ended {
        Some((_, None)) => return Err(FlutterError::Stopped),
        Some((wind_m_s, Some(error))) => Some(Ended { wind_m_s, error }),
        None => None,
    };
    if branches.places.is_empty()
        && let Some(Ended { wind_m_s, error }) = ended
    {
        return Err(FlutterError::FirstSpeed { wind_m_s, error });
    }
    let mut crossings = branches.crossings(&mut |wind_m_s| tunnel.refined(wind_m_s).map(|(modes, _)| modes).ok_or(()));
    branches.keep(options.count, &mut crossings);
    visits.sort_by(|a, b| a.wind_m_s.total_cmp(&b.wind_m_s));
    let (mut divergence_m_s, mut changes) = tunnel.divergence(&visits);
    let jumps = tunnel.jumps(visits);
    if tunnel.stopped {
        return Err(FlutterError::Stopped);
    }
    // at a jump, sign and growth rate change without a zero crossing: it is not a speed of flutter or divergence
    let jumps_at =
        |wind_m_s: f64| jumps.iter().any(|Change { between_m_s: [low, high], .. }| (*low..=*high).contains(&wind_m_s));
    divergence_m_s.retain(|wind_m_s| !jumps_at(*wind_m_s));
    // a wing under load: the path of equilibria ends before the stiffness of a straight wing vanishes
    if let Some(Ended { error: PlantError::Equilibrium { diverges_m_s: Some(end_m_s), .. }, .. }) = &ended {
        divergence_m_s.push(*end_m_s);
    }
    crossings.retain(|crossing| !jumps_at(crossing.at));
    changes.extend(jumps);
    changes.extend(unexplained(&branches, &crossings, &divergence_m_s));
    changes.sort_by(|a, b| a.between_m_s[0].total_cmp(&b.between_m_s[0]));
    let warnings = tunnel.warning.into_iter().collect();
    Ok(Flutter { branches, crossings, divergence_m_s, changes, ended, warnings })
}

fn check(options: &Options) -> Result<(), FlutterError> {
    let speeds = &options.wind_m_s;
    let allowed = speeds.iter().all(|speed| speed.is_finite() && *speed > 0.0);
    if speeds.len() < 2 || !allowed || speeds.windows(2).any(|pair| pair[1] <= pair[0]) {
        return Err(FlutterError::Speeds);
    }
    if speeds.len() > MAXIMUM_SPEEDS {
        return Err(FlutterError::TooManySpeeds { count: speeds.len() });
    }
    if !(1..=MAXIMUM_COUNT).contains(&options.count) {
        return Err(FlutterError::Count { count: options.count });
    }
    Ok(())
}

/// The equilibrium at a speed of the sweep.
struct Visit {
    wind_m_s: f64,
    /// Sign of the determinant of the static stiffness; `None` if a motion is free.
    is_positive: Option<bool>,
    posture: Posture,
}

/// A model in a wind of fixed direction and variable speed.
struct Tunnel<'w> {
    plant: Plant,
    /// Unit vector of the wind, root frame.
    direction: Vector3<f64>,
    count: usize,
    /// The first warning about the flow over an equilibrium.
    warning: Option<Warning>,
    seen: &'w mut dyn FnMut(f64, &Plant),
    watch: &'w mut Watch<'w>,
    /// Number of equilibria computed between the given speeds.
    refined: usize,
    stopped: bool,
}

impl<'w> Tunnel<'w> {
    fn new(
        plant: Plant,
        count: usize,
        seen: &'w mut dyn FnMut(f64, &Plant),
        watch: &'w mut Watch<'w>,
    ) -> Result<Self, FlutterError> {
        let direction = direction(plant.machine(), &plant)?;
        Ok(Self { plant, direction, count, warning: None, seen, watch, refined: 0, stopped: false })
    }

    /// Reports progress; returns `false` once the study is to stop.
    fn goes_on(&mut self, progress: Progress) -> bool {
        self.stopped = self.stopped || (self.watch)(progress).is_break();
        !self.stopped
    }

    /// Reports an equilibrium between the given speeds; `false` once the study is to stop.
    fn refines(&mut self) -> bool {
        self.refined += 1;
        self.goes_on(Progress { part: "equilibria between the speeds", done: self.refined, total: None })
    }

    /// The result of [`Self::visit`] at a speed between the given ones; `None` without one or if the study is to stop.
    fn refined(&mut self, wind_m_s: f64) -> Option<(Vec<ModeShape>, Visit)> {
        let found = if self.stopped { None } else { self.visit(wind_m_s).ok() };
        found.filter(|_| self.refines())
    }

    /// Computes the equilibrium of the model at a speed.
    fn rest(&mut self, wind_m_s: f64) -> Result<Posture, PlantError> {
        *self.plant.inputs_mut().wind_m_s_mut() = self.direction * wind_m_s;
        let time_s = self.plant.machine().experiment.start_time_s;
        self.plant.study().equilibrium(time_s, Holding::AsReleased)?;
        Ok(Posture::of(&self.plant))
    }

    /// Modes at a speed, and the equilibrium about which they are computed.
    fn visit(&mut self, wind_m_s: f64) -> Result<(Vec<ModeShape>, Visit), PlantError> {
        let posture = self.rest(wind_m_s)?;
        self.warning = self.warning.take().or_else(|| warnings::flow_at(&self.plant));
        let count = pool(self.count);
        let (modes, is_positive) = match self.plant.has_linear_lattice() {
            true => self.plant.study().lattice_modes_and_rest(count)?,
            false => self.plant.study().modes_and_rest(count)?,
        };
        (self.seen)(wind_m_s, &self.plant);
        Ok((modes, Visit { wind_m_s, is_positive, posture }))
    }

    /// Speeds at which the static stiffness changes sign, and changes whose speed is not found. `visits` are ascending.
    fn divergence(&mut self, visits: &[Visit]) -> (Vec<f64>, Vec<Change>) {
        let (mut divergence_m_s, mut changes) = (Vec::new(), Vec::new());
        for pair in visits.windows(2) {
            let [low, high] = [&pair[0], &pair[1]];
            let (Some(low_sign), Some(high_sign)) = (low.is_positive, high.is_positive) else { continue };
            if low_sign == high_sign {
                continue;
            }
            let between_m_s = [low.wind_m_s, high.wind_m_s];
            let mut sign = |wind_m_s| self.refined(wind_m_s).map(|(_, visit)| visit.is_positive).ok_or(());
            match change_of_sign(between_m_s, low_sign, &mut sign) {
                Some(wind_m_s) => divergence_m_s.push(wind_m_s),
                None => changes.push(Change { between_m_s, event: Event::Divergence }),
            }
        }
        (divergence_m_s, changes)
    }

    /// Jumps of the equilibrium, and latches that open or close. `visits` are ascending.
    fn jumps(&mut self, visits: Vec<Visit>) -> Vec<Change> {
        let mut postures: Vec<(f64, Posture)> =
            visits.into_iter().map(|visit| (visit.wind_m_s, visit.posture)).collect();
        postures.dedup_by(|a, b| a.0 == b.0);
        let machine = self.plant.machine().clone();
        let mut rest = |wind_m_s: f64| if self.refines() { self.rest(wind_m_s).ok() } else { None };
        postures.windows(2).filter_map(|pair| jump(&machine, [&pair[0], &pair[1]], &mut rest)).collect()
    }
}

/// Modes that become unstable without a speed of flutter or divergence that represents it.
fn unexplained(
    branches: &Branches<ModeShape>,
    crossings: &[Crossing<ModeShape>],
    divergence_m_s: &[f64],
) -> Vec<Change> {
    let mut changes = Vec::new();
    for (branch, [low, high], mode) in branches.beginnings() {
        let within = |wind_m_s: f64| (low..=high).contains(&wind_m_s);
        let own = |crossing: &Crossing<ModeShape>| crossing.branch == branch && crossing.begins && within(crossing.at);
        let explained = match mode.is_real() {
            true => divergence_m_s.iter().any(|wind_m_s| within(*wind_m_s)),
            false => crossings.iter().any(own),
        };
        if !explained {
            let frequency_hz = (!mode.is_real()).then_some(mode.frequency_hz);
            let event = Event::Unstable { branch, eigenvalue_1_s: mode.eigenvalue_1_s, frequency_hz };
            changes.push(Change { between_m_s: [low, high], event });
        }
    }
    changes
}

/// Direction of the wind; rejects models without wind or without aerodynamics that can be linearised.
fn direction(machine: &Machine, plant: &Plant) -> Result<Vector3<f64>, FlutterError> {
    let name = || machine.name.clone();
    let Some(air) = &machine.air else { return Err(FlutterError::NoAir { machine: name() }) };
    if air.rotors().next().is_some() {
        return Err(FlutterError::Rotor { machine: name() });
    }
    if !air.established {
        return Err(FlutterError::UnsteadyStart { machine: name() });
    }
    plant.inputs().wind_m_s().try_normalize(0.0).ok_or_else(|| FlutterError::NoWind { machine: name() })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Invalid speeds and counts out of range have separate errors, which are reported before errors of the model.
    #[test]
    fn options_are_refused_by_their_fields() {
        let error = |wind_m_s: &[f64], count: usize| check(&Options { wind_m_s: wind_m_s.to_vec(), count }).err();
        for speeds in [&[][..], &[50.0], &[2.0, 1.0], &[1.0, 1.0], &[0.0, 1.0], &[1.0, f64::INFINITY], &[f64::NAN, 2.0]]
        {
            assert_eq!(error(speeds, 6), Some(FlutterError::Speeds), "{speeds:?}");
        }
        let many: Vec<f64> = (1..=MAXIMUM_SPEEDS + 1).map(|i| i as f64).collect();
        assert_eq!(error(&many, 6), Some(FlutterError::TooManySpeeds { count: MAXIMUM_SPEEDS + 1 }));
        assert_eq!(error(&[1.0, 2.0], 0), Some(FlutterError::Count { count: 0 }));
        assert_eq!(error(&[1.0, 2.0], 61), Some(FlutterError::Count { count: 61 }));
        assert_eq!(error(&[1.0, 2.0], Options::default().count), None);
    }
}

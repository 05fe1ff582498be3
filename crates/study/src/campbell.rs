//! Modes of a rotor as functions of its speed, in the fixed frame: the Campbell diagram.

use crate::branches::pool;
use crate::values::{Setting, SettingError, plant_with};
use crate::watch::{Progress, Watch, unwatched};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{Branches, ModeShape, OutputSet, Plant, PlantError, Rotor, Settled, Turn};
use foldwing_fmi::interface::Interface;
use std::f64::consts::PI;
use std::fmt;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Error message of the transformation to the fixed frame if coefficients change with the azimuth.
const ANISOTROPIC: &str = "the rotor is not isotropic";
/// Steps per revolution. With 24 of them in a period, the fourth-order method has a frequency error of 4e-6.
const STEPS: usize = 720;
/// Periodicity tolerance, small compared with the differences of 1e-4 from which modes are computed.
const TOLERANCE: f64 = 1e-8;
/// Maximum number of perturbations integrated over a revolution for the Floquet modes.
const PERTURBATIONS: usize = 120;

/// Options of [`over_speed`].
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Speeds of the rotor in rpm: two or more that rise or fall.
    pub speed_rpm: Vec<f64>,
    /// Joint of the shaft; `None`: the only joint that rotates without limit and carries a hub.
    pub shaft: Option<String>,
    /// Computes the modes of the undeformed structure, without loads, gravity, root motion and aerodynamics. Otherwise, if any of these
    /// acts, the modes are about a periodic motion.
    pub undeformed: bool,
    /// Number of modes of lowest frequency to track.
    pub count: usize,
    /// Start values.
    pub settings: Vec<Setting>,
}

impl Default for Options {
    /// Ten modes, and no speeds.
    fn default() -> Self {
        Self { speed_rpm: Vec::new(), shaft: None, undeformed: false, count: 10, settings: Vec::new() }
    }
}

/// Modes of a rotor as functions of its speed, in the fixed frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Campbell {
    /// Name of the model.
    pub machine: String,
    /// Number of blades; 1 if they are not identical.
    pub blades: usize,
    /// Modes as functions of the speed in rpm.
    pub branches: Branches<ModeShape>,
    /// Reason why the state is a periodic motion, with Floquet modes about it; `None` if it is steady in the rotating frame.
    pub disturbance: Option<Disturbance>,
    /// The first speed in rpm without modes, and the reason.
    pub ended: Option<(f64, CampbellError)>,
}

/// Reason why a rotor at constant speed is not steady in the rotating frame. Its `Display` text is a phrase for messages.
#[derive(Debug, Clone, PartialEq)]
pub enum Disturbance {
    /// The model has aerodynamics.
    Air,
    /// Gravity or the motion of the root.
    Root {
        /// Name of the input.
        input: String,
        /// Its value.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A load at a station.
    Load,
    /// Coefficients change with the azimuth.
    Anisotropy,
}

impl fmt::Display for Disturbance {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Air => f.write_str("the model has [aerodynamics]"),
            Self::Root { input, value, unit } => write!(f, "{input} is {value} {unit}"),
            Self::Load => f.write_str("a load station carries a load"),
            Self::Anisotropy => f.write_str(ANISOTROPIC),
        }
    }
}

/// Error of a Campbell diagram.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CampbellError {
    /// Fewer than two speeds, or speeds that neither rise nor fall.
    #[error("speed_rpm: needs two or more values in ascending or descending order")]
    Speeds,
    /// A start value that is rejected.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The model has no rotor, no state at a speed, or no modes about this state.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// The motion of the model at a speed is not periodic.
    #[error("no periodic motion: {cause}")]
    NoTurn {
        /// The reason.
        cause: String,
    },
    /// There are no modes at the first speed.
    #[error("at {speed_rpm} rpm: {error}")]
    FirstSpeed {
        /// The first speed in rpm.
        speed_rpm: f64,
        /// The reason.
        error: Box<CampbellError>,
    },
    /// The watch of [`over_speed_watched`] stopped the study.
    #[error("the study was stopped")]
    Stopped,
}

/// Tracks the modes of a rotor as its speed varies.
///
/// Without aerodynamics, gravity, loads and root motion, and with identical blades, they are the modes of one linearisation in the fixed
/// frame; otherwise the modes about the periodic motion, with the shaft held at its speed. If modes cannot be matched, speeds are
/// inserted. A speed without modes ends the sweep: [`Campbell::ended`].
///
/// # Errors
/// Speeds and start values that are not allowed, a model without rotor, no modes at the first speed.
pub fn over_speed(machine: impl Into<Arc<Machine>>, options: &Options) -> Result<Campbell, CampbellError> {
    over_speed_watched(machine, options, &mut unwatched)
}

/// [`over_speed`] with `watch` called after each speed.
///
/// # Errors
/// Those of [`over_speed`], and [`CampbellError::Stopped`].
pub fn over_speed_watched(
    machine: impl Into<Arc<Machine>>,
    options: &Options,
    watch: &mut Watch<'_>,
) -> Result<Campbell, CampbellError> {
    let speeds = &options.speed_rpm;
    let rises = speeds.windows(2).all(|pair| pair[1] > pair[0]);
    if speeds.len() < 2 || !(rises || speeds.windows(2).all(|pair| pair[1] < pair[0])) {
        return Err(CampbellError::Speeds);
    }
    let machine = machine.into();
    let mut plant = plant_with(Arc::clone(&machine), &Interface::new(&machine), &options.settings)?;
    let time_s = machine.experiment.start_time_s;
    let mut disturbance = if options.undeformed { None } else { disturbance_of(&plant) };
    let rotor = plant.study().rotor(time_s, options.shaft.as_deref());
    let blades = rotor.as_ref().map_or(1, Rotor::blades);
    let mut done = 0;
    let mut counted = |modes: Vec<ModeShape>, speed_rpm: f64| {
        // speeds inserted for the tracking do not count
        let passed = |own: &&f64| if rises { **own <= speed_rpm } else { **own >= speed_rpm };
        done = done.max(speeds.iter().filter(passed).count());
        match watch(Progress { part: "rotor speeds", done, total: Some(speeds.len()) }) {
            ControlFlow::Continue(()) => Ok(modes),
            ControlFlow::Break(()) => Err(CampbellError::Stopped),
        }
    };
    let (mut branches, ended) = loop {
        if disturbance.is_some() {
            break Branches::follow(speeds, &mut |speed_rpm| {
                about_motion(&machine, options, speed_rpm).and_then(|modes| counted(modes, speed_rpm))
            });
        }
        let rotor = rotor.as_ref().map_err(PlantError::clone)?;
        let mut modes_at = |speed_rpm: f64| -> Result<Vec<ModeShape>, CampbellError> {
            let modes = plant.study().whirl_modes(time_s, rotor, speed_rpm * PI / 30.0, pool(options.count))?;
            counted(modes, speed_rpm)
        };
        let (branches, ended) = Branches::follow(speeds, &mut modes_at);
        match &ended {
            Some((_, error))
                if !options.undeformed && branches.places.is_empty() && error.to_string().contains(ANISOTROPIC) =>
            {
                disturbance = Some(Disturbance::Anisotropy);
            }
            _ => break (branches, ended),
        }
    };
    if let Some((_, CampbellError::Stopped)) = ended {
        return Err(CampbellError::Stopped);
    }
    if branches.places.is_empty()
        && let Some((speed_rpm, error)) = ended
    {
        return Err(CampbellError::FirstSpeed { speed_rpm, error: Box::new(error) });
    }
    branches.keep(options.count, &mut []);
    Ok(Campbell { machine: machine.name.clone(), blades, branches, disturbance, ended })
}

/// Floquet modes about the periodic motion, NOTATION eqs. (L32) to (L35), in the fixed frame.
fn about_motion(machine: &Machine, options: &Options, speed_rpm: f64) -> Result<Vec<ModeShape>, CampbellError> {
    let start_s = machine.experiment.start_time_s;
    let (machine, turn) = Turn::of(machine, options.shaft.as_deref(), Some(speed_rpm * PI / 30.0), STEPS)
        .map_err(|cause| CampbellError::NoTurn { cause })?;
    let interface = Interface::new(&machine);
    let mut turning = plant_with(machine, &interface, &options.settings)?;
    turning.watch(OutputSet::NONE);
    turning.initialize(start_s)?;
    let motion = match turning.settle(&turn, TOLERANCE)? {
        Settled::Periodic(motion) => motion,
        // a steady state is periodic too
        Settled::Steady => turning.periodic(&turn, TOLERANCE)?,
    };
    let floquet = turning.floquet(&turn, &motion, PERTURBATIONS)?;
    let mut list: Vec<ModeShape> = floquet.modes.into_iter().map(ModeShape::of_floquet).collect();
    list.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    list.truncate(pool(options.count));
    Ok(list)
}

/// Returns the reason why a rotor has no steady state in the rotating frame: gravity, root motion, loads, aerodynamics.
fn disturbance_of(plant: &Plant) -> Option<Disturbance> {
    if plant.machine().air.is_some() {
        return Some(Disturbance::Air);
    }
    let root = plant.inputs().root();
    let vectors = [
        ("gravity", root.gravity_m_s2, "m/s²"),
        ("root.acceleration", root.acceleration_m_s2, "m/s²"),
        ("root.angular_velocity", root.angular_velocity_rad_s, "rad/s"),
        ("root.angular_acceleration", root.angular_acceleration_rad_s2, "rad/s²"),
    ];
    for (name, vector, unit) in vectors {
        for (axis, &value) in ["x", "y", "z"].iter().zip(vector.iter()) {
            if value != 0.0 {
                return Some(Disturbance::Root { input: format!("{name}.{axis}"), value, unit });
            }
        }
    }
    let loaded = plant.inputs().stations().iter().any(|load| load.force_n.norm() + load.moment_n_m.norm() != 0.0);
    loaded.then_some(Disturbance::Load)
}

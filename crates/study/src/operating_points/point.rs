//! A rotor at one operating point.

use crate::names::{choose, of_variable};
use crate::operating_points::error::{PointError, PointsError};
use crate::operating_points::options::Options;
use crate::operating_points::pitch::{pitch_joints, set_pitch};
use crate::values::{Setting, Target, no_row, plant_with};
use crate::watch::{Progress, Watch};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{NearbyMotion, OutputSet, Plant, SAMPLES, Settled, Turn};
use foldwing_fmi::interface::{Interface, Value, Variable};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Speed of a rotor in rad/s per rpm.
const RPM: f64 = PI / 30.0;

/// A state that was found.
#[derive(Clone)]
pub struct Found {
    /// Speed in rpm.
    pub speed_rpm: f64,
    /// Pitch in degrees; NaN if no joint pitches the blades.
    pub pitch_deg: f64,
    /// The state is a motion that repeats every revolution.
    pub is_periodic: bool,
    /// Difference between the ends of the revolution below which the motion counts as periodic.
    pub tolerance: f64,
    /// Mean and peak-to-peak value of each output, followed by those of the target.
    pub values: Vec<[f64; 2]>,
}

/// A model with its rotor, and the data shared by its operating points.
pub struct Rotor<'w> {
    machine: Arc<Machine>,
    interface: Interface,
    settings: Vec<Setting>,
    shaft: Option<String>,
    blade: Option<String>,
    pitch: Vec<usize>,
    /// Unit vector of the wind, root frame.
    downwind: Vector3<f64>,
    /// Names, units and references of the outputs.
    outputs: Vec<(String, &'static str, u32)>,
    /// Reference of the target's output.
    target: Option<u32>,
    steps: usize,
    /// Difference between the ends of a revolution below which a point counts as periodic.
    pub tolerance: f64,
    radius_m: Option<f64>,
    /// The last periodic state: initial guess for neighbouring points.
    pub nearby: Option<NearbyMotion>,
    /// Called after every state.
    watch: &'w mut Watch<'w>,
    /// Progress by points, as passed to the watch.
    pub progress: Progress,
}

impl<'w> Rotor<'w> {
    /// Rejects models without aerodynamics, shaft or wind, and unknown names.
    pub fn new(machine: Arc<Machine>, options: &Options, watch: &'w mut Watch<'w>) -> Result<Self, PointsError> {
        let name = || machine.name.clone();
        if machine.air.is_none() {
            return Err(PointsError::NoAir { machine: name() });
        }
        let shaft = options.shaft.as_deref();
        // the checks do not depend on the speed
        let (turning, _) = Turn::of(&machine, shaft, Some(1.0), options.steps).map_err(no_turn)?;
        let interface = Interface::new(&turning);
        let plant = plant_with(turning, &interface, &options.settings)?;
        let downwind = plant.inputs().wind_m_s().try_normalize(0.0);
        let downwind = downwind.ok_or_else(|| PointsError::NoWind { machine: name() })?;
        let mut plain = Plant::new(Arc::clone(&machine));
        let rotor = plain.study().rotor(machine.experiment.start_time_s, shaft).ok();
        let blades: Vec<&[usize]> = rotor.iter().flat_map(|rotor| rotor.bodies()).map(Vec::as_slice).collect();
        let pitch = pitch_joints(&machine, options.pitch_joints.as_deref(), &blades)?;
        let pitches =
            options.pitch_deg.is_some() || options.search.as_ref().is_some_and(|search| search.unknown.is_pitch());
        if pitch.is_empty() && pitches {
            return Err(PointsError::NoPitchJoints { machine: name() });
        }
        let all: Vec<&Variable> = interface.real_outputs().collect();
        let rows = match options.outputs.is_empty() {
            false => choose(&options.outputs, &all, of_variable, "real output")?,
            true => usual(&all, &machine, &blades),
        };
        let target = options.search.as_ref().map(|search| target_row(&search.target, &interface)).transpose()?;
        let outputs = rows.iter().map(|row| (row.name.clone(), row.unit(), row.value_reference)).collect();
        Ok(Self {
            settings: options.settings.clone(),
            shaft: options.shaft.clone(),
            blade: blades.first().and_then(|bodies| bodies.last()).map(|body| machine.bodies[*body].name.clone()),
            pitch,
            downwind,
            outputs,
            target,
            steps: options.steps,
            tolerance: options.tolerance,
            radius_m: None,
            nearby: None,
            watch,
            progress: Progress { part: "operating points", done: 0, total: None },
            interface,
            machine,
        })
    }

    /// Name of the model.
    pub fn name(&self) -> &str {
        &self.machine.name
    }

    /// Outermost body of the first blade.
    pub fn blade(&self) -> Option<String> {
        self.blade.clone()
    }

    /// Names and units of the outputs.
    pub fn outputs(&self) -> Vec<(String, &'static str)> {
        self.outputs.iter().map(|(name, unit, _)| (name.clone(), *unit)).collect()
    }

    /// Speed in rpm from a tip speed ratio and a wind speed, at most `greatest_rpm`.
    pub fn speed_rpm(&mut self, ratio: f64, wind_m_s: f64, greatest_rpm: Option<f64>) -> Result<f64, PointsError> {
        let radius_m = match self.radius_m {
            Some(radius_m) => radius_m,
            None => {
                let (mut plant, _) = self.plant([1.0, RPM.recip(), f64::NAN])?;
                plant.initialize(self.machine.experiment.start_time_s).map_err(PointError::Plant)?;
                let rotor = plant.outputs().rotor().first().copied();
                let radius_m =
                    rotor.map_or(0.0, |rotor| rotor.tip_speed_ratio * rotor.wind_m_s / rotor.speed_rad_s.abs());
                if !(radius_m.is_finite() && radius_m > 0.0) {
                    return Err(PointsError::NoRadius);
                }
                *self.radius_m.insert(radius_m)
            }
        };
        let speed_rpm = ratio * wind_m_s / radius_m / RPM;
        Ok(greatest_rpm.map_or(speed_rpm, |greatest| speed_rpm.min(greatest.abs()).copysign(greatest)))
    }

    /// Reports the progress.
    pub fn report(&mut self) -> Result<(), PointsError> {
        if (self.watch)(self.progress).is_break() { Err(PointsError::Stopped) } else { Ok(()) }
    }

    /// The state at a wind in m/s, a speed in rpm and a pitch in degrees; NaN selects the value of the model. `tolerance`
    /// is the difference between the ends of the revolution below which the motion counts as periodic.
    pub fn state(&mut self, at: [f64; 3], tolerance: f64) -> Result<Found, PointsError> {
        let (mut plant, turn) = self.plant(at)?;
        plant.watch(OutputSet::NONE);
        plant.initialize(self.machine.experiment.start_time_s).map_err(PointError::Plant)?;
        let rows: Vec<u32> = self.outputs.iter().map(|(_, _, row)| *row).chain(self.target).collect();
        let needs = self.interface.needs(rows.as_slice());
        if needs.contains(OutputSet::ACCOUNTS) {
            plant.watch(OutputSet::ACCOUNTS);
        }
        let interface = &self.interface;
        let read = |plant: &Plant, row: &u32| match interface.get(plant, plant.outputs(), *row) {
            Some(Value::Real(value)) => value,
            _ => f64::NAN,
        };
        let mut series: Vec<Vec<f64>> = vec![Vec::new(); rows.len()];
        let settled = {
            let mut seen = |sample: usize, plant: &mut Plant| {
                if sample == 0 {
                    series.iter_mut().for_each(Vec::clear);
                }
                if sample < SAMPLES {
                    plant.provide(needs);
                    series.iter_mut().zip(&rows).for_each(|(series, row)| series.push(read(plant, row)));
                }
                Ok(())
            };
            plant.settle_beside(&turn, tolerance, &mut self.nearby, &mut seen).map_err(PointError::Plant)?
        };
        let is_periodic = matches!(settled, Settled::Periodic(_));
        if !is_periodic {
            plant.provide(needs);
            series.iter_mut().zip(&rows).for_each(|(series, row)| *series = vec![read(&plant, row)]);
        }
        let values = series.iter().map(|series| {
            let high = series.iter().fold(f64::MIN, |high, value| high.max(*value));
            let low = series.iter().fold(f64::MAX, |low, value| low.min(*value));
            [series.iter().sum::<f64>() / series.len() as f64, high - low]
        });
        let found = Found {
            speed_rpm: turn.speed_rad_s / RPM,
            pitch_deg: self.pitch_deg(at[2]),
            is_periodic,
            tolerance: if is_periodic { tolerance } else { 0.0 },
            values: values.collect(),
        };
        self.report()?;
        Ok(found)
    }

    /// Creates the plant at a wind, speed and pitch, with prescribed shaft; it is not initialised.
    fn plant(&self, [wind_m_s, speed_rpm, pitch_deg]: [f64; 3]) -> Result<(Plant, Turn), PointsError> {
        let mut machine = Machine::clone(&self.machine);
        let mut commands = Vec::new();
        if !pitch_deg.is_nan() {
            for &body in &self.pitch {
                set_pitch(&mut machine, body, pitch_deg.to_radians())?;
            }
        }
        for (index, (body, _)) in machine.one_freedoms().enumerate() {
            if self.pitch.contains(&body) && !pitch_deg.is_nan() {
                commands.push(index);
            }
        }
        let speed_rad_s = Some(speed_rpm * RPM).filter(|speed| !speed.is_nan());
        let (machine, turn) = Turn::of(&machine, self.shaft.as_deref(), speed_rad_s, self.steps).map_err(no_turn)?;
        let mut plant = plant_with(machine, &self.interface, &self.settings)?;
        *plant.inputs_mut().wind_m_s_mut() = self.downwind * wind_m_s;
        for index in commands {
            plant.inputs_mut().joints_mut()[index].command_rad = pitch_deg.to_radians();
        }
        Ok((plant, turn))
    }

    /// The given pitch or, if it is NaN, that of the model.
    fn pitch_deg(&self, given_deg: f64) -> f64 {
        if !given_deg.is_nan() {
            return given_deg;
        }
        let joint = self.pitch.first().and_then(|body| self.machine.bodies[*body].joint.kind.one_freedom());
        joint.map_or(f64::NAN, |(_, joint)| joint.start_angle_rad.to_degrees())
    }
}

/// Outputs in the table if none are named; those of the first blade represent all blades.
fn usual<'a>(all: &[&'a Variable], machine: &Machine, blades: &[&[usize]]) -> Vec<&'a Variable> {
    let others: Vec<String> = blades
        .iter()
        .skip(1)
        .flat_map(|bodies| bodies.iter())
        .map(|body| format!("body.{}.", machine.bodies[*body].name))
        .collect();
    let of_other = |name: &str| others.iter().any(|other| name.starts_with(other));
    let is_usual = |name: &str| {
        name.starts_with("rotor.")
            || name.ends_with(".holding_torque")
            || [".deflection.", ".root_force.", ".root_moment."].iter().any(|part| name.contains(part))
    };
    all.iter().copied().filter(|row| is_usual(&row.name) && !of_other(&row.name)).collect()
}

/// Reference of the target's output.
fn target_row(target: &Target, interface: &Interface) -> Result<u32, PointsError> {
    let row = interface.find(&target.output).ok_or_else(|| no_row(&target.output, "output", interface))?;
    if interface.real_outputs().all(|output| output.value_reference != row.value_reference) {
        return Err(PointsError::NotAnOutput { target: target.clone() });
    }
    Ok(row.value_reference)
}

fn no_turn(cause: String) -> PointError {
    PointError::NoTurn { cause }
}

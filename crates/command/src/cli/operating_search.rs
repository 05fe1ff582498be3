//! One operating point of a rotor, and the search for the pitch or the speed that holds an output.

use crate::cli::Failure;
use crate::cli::choice::chosen;
use crate::cli::operating_pitch::{pitch_joints, set_pitch};
use crate::cli::operating_points::Wanted;
use crate::cli::settings::plant_with;
use crate::cli::simulate::unknown;
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::{NearbyMotion, OutputSet, Plant, PlantError, SAMPLES, Settled, Turn};
use foldwing_fmi::interface::{Interface, Value, Variable};
use nalgebra::Vector3;
use std::f64::consts::PI;
use std::sync::Arc;

/// Speed of a rotor in rad/s per rpm.
const RPM: f64 = PI / 30.0;
/// Parts into which a range is cut that is searched from its begin.
const PARTS: f64 = 30.0;
/// Distance of what is held from its value, relative to it.
const HELD: f64 = 1e-6;
/// Width of the interval of what is sought, over its range, below which it is found: an output that leaps has no better one.
const NARROW: f64 = 1e-9;
/// Distance of the ends of a turn from which a search sees on which side it is.
const ROUGH: f64 = 1e-2;
/// Distance of what is held from its value, relative to it and over that of the ends of the turn, from which on the side is certain: a turn
/// that ends 1e-2 rad off where it began has a mean that is some 1e-2 of itself off.
const CERTAIN: f64 = 5.0;
/// Shrinking of that distance where the side is not certain.
const FINER: f64 = 1e-3;
/// What a step between two values of which one is above and one below is expected to leave of the smaller distance.
const NEARER: f64 = 0.02;
/// Largest share of the way between the last two values by which a motion is sought beyond them on the line through theirs.
const FARTHEST: f64 = 2.0;
/// Maximum number of steps between two values of which one is above and one below.
const MAXIMUM_STEPS: usize = 60;

/// What is sought, and between which values.
pub(super) struct Find {
    /// As it was given.
    pub text: String,
    /// The pitch in degrees; otherwise the speed in rpm.
    pub is_pitch: bool,
    from: f64,
    to: f64,
}

impl Find {
    /// `pitch_deg=FROM:TO` or `speed_rpm=FROM:TO`.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let refused = || {
            Failure::Usage(format!(
                "--solve-for {text}: must be pitch_deg=FROM:TO or speed_rpm=FROM:TO with two different finite numbers"
            ))
        };
        let (key, range) = text.split_once('=').ok_or_else(refused)?;
        let (from, to) = range.split_once(':').ok_or_else(refused)?;
        let number = |text: &str| text.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(refused);
        let (from, to) = (number(from)?, number(to)?);
        if from == to || !["pitch_deg", "speed_rpm"].contains(&key) {
            return Err(refused());
        }
        Ok(Self { text: text.to_owned(), is_pitch: key == "pitch_deg", from, to })
    }
}

/// An output with the mean that it shall have.
pub(super) struct Target {
    text: String,
    name: String,
    value: f64,
}

impl Target {
    /// `OUTPUT=VALUE`.
    pub fn parse(text: &str) -> Result<Self, Failure> {
        let refused =
            || Failure::Usage(format!("--target {text}: must be OUTPUT=VALUE with a finite number in SI units"));
        let (name, value) = text.split_once('=').ok_or_else(refused)?;
        let value = value.trim().parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(refused)?;
        Ok(Self { text: text.to_owned(), name: name.to_owned(), value })
    }
}

/// A point that was found.
#[derive(Clone)]
pub(super) struct Found {
    /// Speed in rpm.
    pub speed_rpm: f64,
    /// Pitch in degrees; not a number where no joint pitches the blades.
    pub pitch_deg: f64,
    /// The state is a motion that every turn repeats.
    pub is_periodic: bool,
    /// Whether what is to be held has its value.
    pub held: Option<bool>,
    /// Accuracy to which the motion is closed.
    accuracy: f64,
    /// Mean and peak-to-peak value of each output; behind them those of what is to be held.
    pub values: Vec<[f64; 2]>,
}

/// A machine whose points are asked for.
pub(super) struct Asked {
    machine: Arc<Machine>,
    interface: Interface,
    settings: Vec<String>,
    shaft: Option<String>,
    blade: Option<String>,
    pitch: Vec<usize>,
    /// Unit vector of the wind.
    downwind: Vector3<f64>,
    /// Names, units and references of the outputs.
    outputs: Vec<(String, &'static str, u32)>,
    /// Reference of what is to be held.
    held: Option<u32>,
    steps: usize,
    accuracy: f64,
    radius_m: Option<f64>,
    /// The last value found by a search.
    last: Option<f64>,
    /// The last two values of what is sought at which a motion was found in the present search.
    tried: Option<[f64; 2]>,
    /// The last motion found: points beside one another have motions beside one another.
    nearby: Option<NearbyMotion>,
}

impl Asked {
    /// Reads what is asked for; refuses machines without air or shaft, names that are none.
    pub fn new(machine: Arc<Machine>, wanted: &Wanted, target: Option<&Target>) -> Result<Self, Failure> {
        if machine.air.is_none() {
            return Err(Failure::Usage(format!(
                "{}: has no air; operating points need [aerodynamics] with model = \"bem\" or \"strip\" and the blades' surfaces",
                machine.name
            )));
        }
        let shaft = wanted.shaft.as_deref();
        // any speed shows what the machine has
        let (turning, _) = Turn::of(&machine, shaft, Some(1.0), wanted.steps).map_err(no_point)?;
        let interface = Interface::new(&turning);
        let plant = plant_with(turning, &interface, &wanted.settings)?;
        let downwind = plant.inputs().wind_m_s().try_normalize(0.0).ok_or_else(|| {
            Failure::Usage(format!(
                "{}: has no wind to give the direction; set aerodynamics.wind_m_s, or --set wind.velocity.x=1",
                machine.name
            ))
        })?;
        let mut plain = Plant::new(Arc::clone(&machine));
        let rotor = plain.study().rotor(machine.experiment.start_time_s, shaft).ok();
        let blades: Vec<&[usize]> = rotor.iter().flat_map(|rotor| rotor.bodies()).map(Vec::as_slice).collect();
        let pitch = pitch_joints(&machine, wanted.pitch_joints.as_deref(), &blades)?;
        if pitch.is_empty()
            && (wanted.pitch_deg.is_some() || wanted.find.as_ref().is_some_and(|find| find.starts_with("pitch")))
        {
            return Err(Failure::Usage(format!(
                "{}: no revolute joints bear the blades on the hub, so nothing pitches them; name the joints with --pitch-joints",
                machine.name
            )));
        }
        let all: Vec<&Variable> = interface.real_outputs().collect();
        let rows = match wanted.outputs.is_empty() {
            false => chosen(&wanted.outputs, &all, "real output")?,
            true => {
                let others: Vec<String> = blades
                    .iter()
                    .skip(1)
                    .flat_map(|bodies| bodies.iter())
                    .map(|body| format!("body.{}.", machine.bodies[*body].name))
                    .collect();
                all.into_iter()
                    .filter(|row| is_usual(&row.name) && !others.iter().any(|other| row.name.starts_with(other)))
                    .collect()
            }
        };
        let held = target.map(|target| held_row(target, &interface)).transpose()?;
        let outputs = rows.iter().map(|row| (row.name.clone(), row.unit(), row.value_reference)).collect();
        Ok(Self {
            settings: wanted.settings.clone(),
            shaft: wanted.shaft.clone(),
            blade: blades.first().and_then(|bodies| bodies.last()).map(|body| machine.bodies[*body].name.clone()),
            pitch,
            downwind,
            outputs,
            held,
            steps: wanted.steps,
            accuracy: wanted.accuracy,
            radius_m: None,
            last: None,
            tried: None,
            nearby: None,
            interface,
            machine,
        })
    }

    /// Name of the machine.
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

    /// Speed in rpm of a tip speed ratio in a wind, no faster than the greatest.
    pub fn speed_rpm(&mut self, ratio: f64, wind_m_s: f64, greatest_rpm: Option<f64>) -> Result<f64, Failure> {
        let radius_m = match self.radius_m {
            Some(radius_m) => radius_m,
            None => {
                let (mut plant, _) = self.plant([1.0, RPM.recip(), f64::NAN])?;
                plant.initialize(self.machine.experiment.start_time_s).map_err(failed)?;
                let rotor = plant.outputs().rotor().first().copied();
                let radius_m =
                    rotor.map_or(0.0, |rotor| rotor.tip_speed_ratio * rotor.wind_m_s / rotor.speed_rad_s.abs());
                if !(radius_m.is_finite() && radius_m > 0.0) {
                    return Err(Failure::Usage(
                        "--tip-speed-ratio: needs the air of a rotor (aerodynamics.model = \"bem\"); give --speed-rpm"
                            .to_owned(),
                    ));
                }
                *self.radius_m.insert(radius_m)
            }
        };
        let speed_rpm = ratio * wind_m_s / radius_m / RPM;
        Ok(greatest_rpm.map_or(speed_rpm, |greatest| speed_rpm.min(greatest.abs()).copysign(greatest)))
    }

    /// The state at a wind in m/s, a speed in rpm and a pitch in degrees; what is not a number is the model's own.
    pub fn point(&mut self, at: [f64; 3]) -> Result<Found, Failure> {
        self.point_to(at, self.accuracy)
    }

    /// The same to a given accuracy of the motion.
    fn point_to(&mut self, at: [f64; 3], accuracy: f64) -> Result<Found, Failure> {
        let (mut plant, turn) = self.plant(at)?;
        plant.watch(OutputSet::NONE);
        plant.initialize(self.machine.experiment.start_time_s).map_err(failed)?;
        let rows: Vec<u32> = self.outputs.iter().map(|(_, _, row)| *row).chain(self.held).collect();
        let needs = self.interface.needs(rows.as_slice());
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
            plant.settle_beside(&turn, accuracy, &mut self.nearby, &mut seen).map_err(failed)?
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
        Ok(Found {
            speed_rpm: turn.speed_rad_s / RPM,
            pitch_deg: self.pitch_deg(at[2]),
            is_periodic,
            held: None,
            accuracy: if is_periodic { accuracy } else { 0.0 },
            values: values.collect(),
        })
    }

    /// Distance of what is to be held from its value, with a value of what is sought: from a motion that is closed as far as tells on which
    /// side it is if that is no less than `near`, or, where it may be held, as far as those of points are.
    fn off(
        &mut self,
        mut at: [f64; 3],
        (find, target): (&Find, &Target),
        value: f64,
        near: f64,
    ) -> Result<(f64, Found), Failure> {
        at[if find.is_pitch { 2 } else { 1 }] = value;
        let size = if target.value == 0.0 { 1.0 } else { target.value.abs() };
        // motions lie on a line as the values do
        if let (Some(nearby), Some([before, last])) = (&mut self.nearby, self.tried)
            && last != before
            && (value - last).abs() <= FARTHEST * (last - before).abs()
        {
            nearby.go_on((value - last) / (last - before));
        }
        self.tried = Some([self.tried.map_or(value, |[_, last]| last), value]);
        let mut accuracy = (near / (CERTAIN * size)).min(ROUGH).max(self.accuracy);
        loop {
            let mut found = self.point_to(at, accuracy)?;
            let [mean, _] = found.values.pop().unwrap_or([f64::NAN; 2]);
            let off = mean - target.value;
            if found.accuracy <= self.accuracy || off.abs() > CERTAIN * accuracy * size {
                return Ok((off, found));
            }
            // as far as this distance needs, if it is to be believed
            accuracy = (0.5 * off.abs() / (CERTAIN * size)).clamp(FINER * accuracy, 0.5 * accuracy).max(self.accuracy);
        }
    }

    /// The pitch or the speed at which an output has its value, eq. (L41): where it falls through the value on the way through the range,
    /// seen from the last point found, else from the begin. Where the output is below the value at the begin, that is kept.
    pub fn search(&mut self, at: [f64; 3], find: &Find, target: &Target) -> Result<Found, Failure> {
        let last = self.last;
        // an output that leaps is not held either; a side that was mistaken from a motion not closed is none with closed ones
        match self.searched(at, find, target, false)? {
            Some(found) => Ok(found),
            None => {
                self.last = last;
                let found = self.searched(at, find, target, true)?;
                found.ok_or_else(|| Failure::Statics(format!("--target {}: no value found that gives it", target.text)))
            }
        }
    }

    /// The search, with motions that are all closed if `whole`; `None` if something other than a leap of the output may have ended it.
    fn searched(&mut self, at: [f64; 3], find: &Find, target: &Target, whole: bool) -> Result<Option<Found>, Failure> {
        self.tried = None;
        let size = if target.value == 0.0 { 1.0 } else { target.value.abs() };
        let held = |off: f64| off.abs() <= HELD * size;
        let with = |found: Found, held: bool| Some(Found { held: Some(held), ..found });
        let (from, to) = (find.from, find.to);
        let far = if whole { 0.0 } else { f64::INFINITY };
        let (mut above, first) = self.off(at, (find, target), from, far)?;
        // what is no number cannot be held either
        if above.is_nan() || above <= 0.0 || held(above) {
            let closed =
                if first.accuracy <= self.accuracy { (above, first) } else { self.off(at, (find, target), from, 0.0)? };
            return Ok(with(closed.1, held(closed.0)));
        }
        let part = (to - from) / PARTS;
        let mut high = from;
        let mut low: Option<(f64, f64, Found)> = None;
        // from the last point back in growing strides, no farther than the begin
        if let Some(last) = self.last {
            let (off, found) = self.off(at, (find, target), last, far)?;
            if off > 0.0 {
                (high, above) = (last, off);
            } else {
                let (mut nearest, mut stride) = ((last, off, found), part);
                while (nearest.0 - stride - from) * part.signum() > 0.0 {
                    let back = nearest.0 - stride;
                    let (off, found) = self.off(at, (find, target), back, far)?;
                    if off > 0.0 {
                        (high, above) = (back, off);
                        break;
                    }
                    (nearest, stride) = ((back, off, found), 2.0 * stride);
                }
                low = Some(nearest);
            }
        }
        while low.is_none() {
            let on = high + part;
            let next = if (on - to) * part.signum() >= -1e-9 * part.abs() { to } else { on };
            let (off, found) = self.off(at, (find, target), next, far)?;
            if off <= 0.0 {
                low = Some((next, off, found));
            } else if next == to || off.is_nan() {
                return Err(Failure::Statics(format!(
                    "--target {}: from {from} to {to} {} is always above it, and by {off:.6e} at the end; extend the range of --solve-for",
                    target.text, target.name
                )));
            } else {
                (high, above) = (next, off);
            }
        }
        let Some((mut end, mut below, mut found)) = low else { return Ok(with(first, false)) };
        let mut side = 0i32;
        for _ in 0..MAXIMUM_STEPS {
            if held(below) || (end - high).abs() <= NARROW * (to - from).abs() {
                break;
            }
            // the Illinois rule: an end that stays twice counts half
            let middle = (high * below - end * above) / (below - above);
            let (off, at_middle) = self.off(at, (find, target), middle, far.min(NEARER * above.min(-below)))?;
            if held(off) {
                (end, below, found) = (middle, off, at_middle);
            } else if off > 0.0 {
                (high, above) = (middle, off);
                if side == 1 {
                    below *= 0.5;
                }
                side = 1;
            } else {
                (end, below, found) = (middle, off, at_middle);
                if side == -1 {
                    above *= 0.5;
                }
                side = -1;
            }
        }
        if !held(below) && !whole {
            return Ok(None);
        }
        self.last = Some(end);
        Ok(with(found, true))
    }

    /// The machine with wind, speed and pitch, its shaft prescribed; not initialised.
    fn plant(&self, [wind_m_s, speed_rpm, pitch_deg]: [f64; 3]) -> Result<(Plant, Turn), Failure> {
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
        let (machine, turn) = Turn::of(&machine, self.shaft.as_deref(), speed_rad_s, self.steps).map_err(no_point)?;
        let mut plant = plant_with(machine, &self.interface, &self.settings)?;
        *plant.inputs_mut().wind_m_s_mut() = self.downwind * wind_m_s;
        for index in commands {
            plant.inputs_mut().joints_mut()[index].command_rad = pitch_deg.to_radians();
        }
        Ok((plant, turn))
    }

    /// The pitch that is set, or that of the model.
    fn pitch_deg(&self, asked_deg: f64) -> f64 {
        if !asked_deg.is_nan() {
            return asked_deg;
        }
        let joint = self.pitch.first().and_then(|body| self.machine.bodies[*body].joint.kind.one_freedom());
        joint.map_or(f64::NAN, |(_, joint)| joint.start_angle_rad.to_degrees())
    }
}

/// Outputs that are in the table if none are named.
fn is_usual(name: &str) -> bool {
    name.starts_with("rotor.")
        || name.ends_with(".holding_torque")
        || [".deflection.", ".root_force.", ".root_moment."].iter().any(|part| name.contains(part))
}

/// Reference of what is to be held.
fn held_row(target: &Target, interface: &Interface) -> Result<u32, Failure> {
    let row = interface.find(&target.name).ok_or_else(|| unknown(&target.name, "output", interface.variables()))?;
    if interface.real_outputs().all(|output| output.value_reference != row.value_reference) {
        return Err(Failure::Usage(format!("--target {}: is not a real output", target.text)));
    }
    Ok(row.value_reference)
}

fn no_point(cause: String) -> Failure {
    Failure::Statics(format!("no operating point: {cause}"))
}

fn failed(error: PlantError) -> Failure {
    Failure::Statics(error.to_string())
}

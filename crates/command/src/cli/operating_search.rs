//! One operating point of a rotor, and the solution for the pitch or speed at which an output has its target value.

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
/// Number of steps in which a range is searched from its start.
const PARTS: f64 = 30.0;
/// Relative tolerance of the target output.
const HELD: f64 = 1e-6;
/// Width of the bracket over the range below which the search ends: a discontinuous output cannot come closer.
const NARROW: f64 = 1e-9;
/// Initial periodicity tolerance in a search for the sign of the residual.
const ROUGH: f64 = 1e-2;
/// Relative residual over the periodicity error above which its sign is certain: a revolution whose ends differ by 1e-2 rad has a relative
/// error of the mean of about 1e-2.
const CERTAIN: f64 = 5.0;
/// Factor on the periodicity tolerance if the sign is not certain.
const FINER: f64 = 1e-3;
/// Expected ratio of the residual after a step inside the bracket to the smaller one of its ends.
const NEARER: f64 = 0.02;
/// Maximum extrapolation of the periodic state from the last two values, over their distance.
const FARTHEST: f64 = 2.0;
/// Maximum number of steps inside the bracket.
const MAXIMUM_STEPS: usize = 60;

/// Unknown and its range.
pub(super) struct Find {
    /// Text of the option.
    pub text: String,
    /// The unknown is the pitch in degrees; otherwise the speed in rpm.
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

/// Output with the target value of its mean.
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

/// A solution at an operating point.
#[derive(Clone)]
pub(super) struct Found {
    /// Speed in rpm.
    pub speed_rpm: f64,
    /// Pitch in degrees; NaN if no joint pitches the blades.
    pub pitch_deg: f64,
    /// The state is periodic.
    pub is_periodic: bool,
    /// Whether the target is met.
    pub held: Option<bool>,
    /// Periodicity tolerance to which the state was computed.
    accuracy: f64,
    /// Mean and peak-to-peak value of each output, then those of the target output.
    pub values: Vec<[f64; 2]>,
}

/// A rotor and the settings of its operating points.
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
    /// Value reference of the target output.
    held: Option<u32>,
    steps: usize,
    accuracy: f64,
    radius_m: Option<f64>,
    /// The last solution of a search.
    last: Option<f64>,
    /// The last two values of the unknown with a periodic state in the present search.
    tried: Option<[f64; 2]>,
    /// The last periodic state: initial guess for neighbouring points.
    nearby: Option<NearbyMotion>,
}

impl Asked {
    /// Reads the settings; fails for machines without aerodynamics or shaft and for unknown names.
    pub fn new(machine: Arc<Machine>, wanted: &Wanted, target: Option<&Target>) -> Result<Self, Failure> {
        if machine.air.is_none() {
            return Err(Failure::Usage(format!(
                "{}: has no air; operating points need [aerodynamics] with model = \"bem\" or \"strip\" and the blades' surfaces",
                machine.name
            )));
        }
        let shaft = wanted.shaft.as_deref();
        // the checks do not depend on the speed
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

    /// Speed in rpm from a tip speed ratio and a wind speed, at most `greatest_rpm`.
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

    /// Computes the state at a wind in m/s, a speed in rpm and a pitch in degrees; NaN stands for the value of the model.
    pub fn point(&mut self, at: [f64; 3]) -> Result<Found, Failure> {
        self.point_to(at, self.accuracy)
    }

    /// The same with a given periodicity tolerance.
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

    /// Residual of the target at a value of the unknown: computed with a periodicity tolerance that makes its sign certain if it is at
    /// least `near`, or, near the target, with that of the points.
    fn off(
        &mut self,
        mut at: [f64; 3],
        (find, target): (&Find, &Target),
        value: f64,
        near: f64,
    ) -> Result<(f64, Found), Failure> {
        at[if find.is_pitch { 2 } else { 1 }] = value;
        let size = if target.value == 0.0 { 1.0 } else { target.value.abs() };
        // the periodic state is extrapolated linearly, as the unknown
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
            // the tolerance at which the sign of this residual would be certain
            accuracy = (0.5 * off.abs() / (CERTAIN * size)).clamp(FINER * accuracy, 0.5 * accuracy).max(self.accuracy);
        }
    }

    /// Finds the pitch or speed at which an output has its target value, eq. (L41): where it falls through the target along the range,
    /// searched from the last solution, else from the start. If the output is below the target at the start of the range, that value is
    /// used.
    pub fn search(&mut self, at: [f64; 3], find: &Find, target: &Target) -> Result<Found, Failure> {
        let last = self.last;
        // a discontinuous output has no solution; a sign error from a coarse periodicity tolerance is excluded by a search with the full
        // one
        match self.searched(at, find, target, false)? {
            Some(found) => Ok(found),
            None => {
                self.last = last;
                let found = self.searched(at, find, target, true)?;
                found.ok_or_else(|| Failure::Statics(format!("--target {}: no value found that gives it", target.text)))
            }
        }
    }

    /// The search, with the full periodicity tolerance everywhere if `whole`; `None` if its failure may have another cause than a
    /// discontinuity of the output.
    fn searched(&mut self, at: [f64; 3], find: &Find, target: &Target, whole: bool) -> Result<Option<Found>, Failure> {
        self.tried = None;
        let size = if target.value == 0.0 { 1.0 } else { target.value.abs() };
        let held = |off: f64| off.abs() <= HELD * size;
        let with = |found: Found, held: bool| Some(Found { held: Some(held), ..found });
        let (from, to) = (find.from, find.to);
        let far = if whole { 0.0 } else { f64::INFINITY };
        let (mut above, first) = self.off(at, (find, target), from, far)?;
        // NaN cannot meet the target
        if above.is_nan() || above <= 0.0 || held(above) {
            let closed =
                if first.accuracy <= self.accuracy { (above, first) } else { self.off(at, (find, target), from, 0.0)? };
            return Ok(with(closed.1, held(closed.0)));
        }
        let part = (to - from) / PARTS;
        let mut high = from;
        let mut low: Option<(f64, f64, Found)> = None;
        // from the last solution back in growing steps, at most to the start
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
            // Illinois rule: the residual of an end that is kept twice is halved
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

    /// The given pitch, or that of the model.
    fn pitch_deg(&self, asked_deg: f64) -> f64 {
        if !asked_deg.is_nan() {
            return asked_deg;
        }
        let joint = self.pitch.first().and_then(|body| self.machine.bodies[*body].joint.kind.one_freedom());
        joint.map_or(f64::NAN, |(_, joint)| joint.start_angle_rad.to_degrees())
    }
}

/// Returns whether an output is in the table by default.
fn is_usual(name: &str) -> bool {
    name.starts_with("rotor.")
        || name.ends_with(".holding_torque")
        || [".deflection.", ".root_force.", ".root_moment."].iter().any(|part| name.contains(part))
}

/// Value reference of the target output.
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

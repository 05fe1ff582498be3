//! Assessment of a model without a run: mass properties, static deflection, natural frequencies, joint efforts, and whether the joints
//! reach their latches; computed without aerodynamics and applied loads, with the joints held.

use crate::cli::implausible;
use foldwing_engine::machine::{JointKind, JointMotion, Machine, OneFreedom, Parent, Travel};
use foldwing_engine::plant::{Holding, Plant, PlantError, Search};
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;
use std::fmt::Write;
use std::sync::Arc;

/// Number of points at which the efforts between start and latch are computed.
const POINTS: usize = 13;
/// Number of natural frequencies in the summary.
const MODES: usize = 3;
/// Fraction of the largest effort along the path below which a joint counts as not driven.
const NO_EFFORT: f64 = 1e-6;
/// Gauss points on (−1, 1) of an interval of the mesh, and their weights: exact for polynomials up to degree 9.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// Results of the assessment.
#[derive(Serialize)]
pub(super) struct Assessment {
    /// Centre of mass in the root frame, for the unstrained model at its start angles.
    centre_of_mass_m: [f64; 3],
    /// Inertia about the centre of mass in axes of the root frame: `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]`, where `Ixy = −∫xy dm`.
    inertia_kg_m2: [f64; 6],
    /// Largest displacement of a tip between the unstrained position and static equilibrium under gravity.
    pub(super) static_deflection: Option<StaticDeflection>,
    /// Lowest natural frequencies about this equilibrium, joints held.
    #[serde(rename = "natural_frequencies_Hz")]
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) joints: Vec<Effort>,
    /// Whether the model has wind, which deflection, frequencies and efforts do not include.
    pub(super) air_left_out: bool,
    /// Reason why deflection and frequencies are missing.
    unknown: Option<String>,
    /// Warnings about implausible values.
    pub warnings: Vec<String>,
}

#[derive(Serialize)]
pub(super) struct StaticDeflection {
    pub body: String,
    pub deflection_m: f64,
    /// Longest distance from the root to a tip, measured along the bodies.
    pub length_m: f64,
}

/// Efforts on a joint between its start and its latch or neutral angle, in N·m and degrees; N and m for a prismatic joint.
#[derive(Serialize)]
pub(super) struct Effort {
    pub name: String,
    #[serde(skip)]
    pub travel: Travel,
    /// Largest effort due to gravity about the joint between start and end.
    #[serde(rename = "gravity_effort")]
    gravity: f64,
    #[serde(rename = "gravity_effort_at")]
    gravity_at: f64,
    /// Smallest and largest effort of motor and spring, positive towards the end.
    #[serde(rename = "available_effort")]
    pub(super) drive: [f64; 2],
    #[serde(rename = "target")]
    pub end: f64,
    pub has_latch: bool,
    pub reaches: Reach,
}

/// Position that the joint reaches in quasi-static motion.
#[derive(Serialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum Reach {
    /// The end, because the joint is driven towards it at all points.
    #[serde(rename = "reached")]
    Arrives,
    /// The end, where the joint already is at the start.
    #[serde(rename = "starts_there")]
    Stands,
    /// This position, at which the joint stalls.
    StallsAt(f64),
    /// No motion towards the end: the joint is driven away from it at the start.
    #[serde(rename = "moves_away")]
    TurnsAway,
    /// Unknown: the model has wind, which the efforts do not include.
    NotJudged,
}

/// Returns whether the model has a wind velocity at the start, or gusts.
fn blown(machine: &Machine) -> bool {
    let Some(air) = &machine.air else { return false };
    air.rotors().next().is_some()
        || !air.gusts.is_empty()
        || Plant::new(Arc::new(machine.clone())).inputs().wind_m_s().norm() > 0.0
}

/// Reason for which runs of a model with aerodynamics do not start, such as lifting surfaces that overlap.
fn no_start(machine: &Machine) -> Option<String> {
    machine.air.as_ref()?;
    let error = Plant::new(Arc::new(machine.clone())).initialize(machine.experiment.start_time_s).err()?;
    Some(format!("simulations of this model do not start: {error}"))
}

impl Assessment {
    /// Assesses a model with the start values of its inputs.
    pub fn new(machine: &Machine) -> Self {
        let bare = bare(machine);
        let mut plant = Plant::new(Arc::new(bare.clone()));
        let start_s = machine.experiment.start_time_s;
        let mut answer = Self {
            centre_of_mass_m: [0.0; 3],
            inertia_kg_m2: [0.0; 6],
            static_deflection: None,
            frequencies_hz: Vec::new(),
            joints: Vec::new(),
            unknown: None,
            air_left_out: false,
            warnings: Vec::new(),
        };
        if let Err(error) = plant.study().undeformed(start_s) {
            answer.unknown = Some(error.to_string());
            return answer;
        }
        (answer.centre_of_mass_m, answer.inertia_kg_m2) = mass_properties(&plant);
        let unstrained: Vec<Vector3<f64>> = plant.outputs().tips().iter().map(|tip| tip.position_m).collect();
        // a new plant, because that of the bare model has no gravity
        match at_rest(&bare, &unstrained) {
            Ok((deflection, frequencies_hz)) => {
                (answer.static_deflection, answer.frequencies_hz) = (deflection, frequencies_hz)
            }
            Err(cause) => answer.unknown = Some(cause),
        }
        answer.joints = efforts(machine, |_| true);
        answer.air_left_out = blown(machine);
        if answer.air_left_out {
            answer.joints.iter_mut().filter(|joint| joint.reaches != Reach::Stands).for_each(|joint| {
                joint.reaches = Reach::NotJudged;
            });
        }
        answer.warnings = implausible::model(&answer, machine);
        answer.warnings.extend(no_start(machine));
        answer
    }

    /// Returns the results as text.
    pub fn text(&self) -> String {
        let ([x, y, z], [xx, yy, zz, ..]) = (self.centre_of_mass_m.map(tidy), self.inertia_kg_m2);
        let mut text = format!(
            "centre of mass ({x:.4}, {y:.4}, {z:.4}) m; inertia about it Ixx {xx:.3e}, Iyy {yy:.3e}, Izz {zz:.3e} kg.m2\n"
        );
        if let Some(deflection) = &self.static_deflection {
            let share = 100.0 * deflection.deflection_m / deflection.length_m.max(f64::MIN_POSITIVE);
            let deflection_mm = 1e3 * deflection.deflection_m;
            let _ = writeln!(
                text,
                "static deflection under gravity {} mm at the tip of {} ({share:.1} % of {:.3} m), joints locked at their start",
                short(deflection_mm),
                deflection.body,
                deflection.length_m
            );
        }
        if !self.frequencies_hz.is_empty() {
            let list: Vec<String> = self.frequencies_hz.iter().map(|hz| short(*hz).to_string()).collect();
            let _ = writeln!(text, "first natural frequencies {} Hz, joints locked", list.join(", "));
        }
        if self.air_left_out {
            text.push_str("deflection, frequencies and torques do not include the wind of the model: `static`, `modes` and `simulate` do\n");
        }
        if let Some(cause) = &self.unknown {
            let _ = writeln!(text, "static deflection and frequencies not computed: {cause}");
        }
        self.joints.iter().for_each(|joint| text.push_str(&joint.text()));
        text
    }
}

impl Effort {
    fn text(&self) -> String {
        let (shown, unit) = (self.travel.shown_unit(), self.travel.effort_unit());
        let end = if self.has_latch { "the latch" } else { "its neutral position" };
        let reach = match self.reaches {
            Reach::Arrives => format!("reaches {end} at {} {shown}", short(self.end)),
            Reach::Stands => format!("starts at {end}"),
            Reach::StallsAt(place) => format!("stalls at {} {shown} (quasi-static)", short(place)),
            Reach::TurnsAway => format!("moves away from {end} at {} {shown}", short(self.end)),
            Reach::NotJudged => format!("whether it reaches {end} at {} {shown} depends on the wind", short(self.end)),
        };
        let asked = format!(
            "{}: needs up to {} {unit} against gravity (at {} {shown})",
            self.name,
            short(self.gravity),
            short(self.gravity_at)
        );
        if self.drive == [0.0; 2] {
            return format!("{asked}, which motor and spring do not provide\n");
        }
        format!(
            "{asked}, has {} to {} {unit} from motor and spring towards {end}; {reach}\n",
            short(self.drive[0]),
            short(self.drive[1])
        )
    }
}

/// Rounds to four digits.
pub(super) fn short(value: f64) -> f64 {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if rounded.abs() < 1e-12 { 0.0 } else { rounded }
}

/// Removes the sign of zeros and of values that round to zero.
fn tidy(value: f64) -> f64 {
    if value.abs() < 5e-5 { 0.0 } else { value }
}

/// Returns the model without aerodynamics and loads, with held joints.
fn bare(machine: &Machine) -> Machine {
    let mut bare = machine.clone();
    bare.air = None;
    bare.bodies.iter_mut().for_each(|body| body.station_loads.clear());
    each_joint(&mut bare, |joint| joint.release = false);
    bare
}

/// Returns the model with all latches open.
fn unlatched(mut machine: Machine) -> Machine {
    each_joint(&mut machine, |joint| {
        joint.latch.iter_mut().for_each(|latch| {
            latch.enable = false;
            latch.initially_closed = false;
        });
    });
    machine
}

/// Returns the efforts of the joints whose indices `asked` accepts.
pub(super) fn efforts(machine: &Machine, asked: impl Fn(usize) -> bool) -> Vec<Effort> {
    let held = unlatched(bare(machine));
    let rows = machine.one_freedoms().enumerate().filter(|(row, _)| asked(*row));
    rows.filter_map(|(_, (body, joint))| effort(&held, body, joint).ok()?).collect()
}

/// Natural frequencies in Hz of the model in static equilibrium under gravity, joints held; empty if there is no equilibrium.
pub(super) fn frequencies_hz(machine: &Machine) -> Vec<f64> {
    at_rest(&bare(machine), &[]).map_or_else(|_| Vec::new(), |(_, frequencies_hz)| frequencies_hz)
}

fn each_joint(machine: &mut Machine, change: impl Fn(&mut OneFreedom)) {
    for body in &mut machine.bodies {
        if let JointKind::Revolute(joint) | JointKind::Prismatic(joint) | JointKind::Sliding(joint) =
            &mut body.joint.kind
        {
            change(joint);
        }
    }
}

/// Returns static deflection and natural frequencies of a model with held joints.
fn at_rest(machine: &Machine, unstrained: &[Vector3<f64>]) -> Result<(Option<StaticDeflection>, Vec<f64>), String> {
    if machine.spatials().next().is_some() {
        return Err(
            "joints with several degrees of freedom cannot be held; `foldwing static` and `foldwing modes` leave them free"
                .to_owned(),
        );
    }
    let mut plant = Plant::new(Arc::new(machine.clone()));
    let failed = |error: PlantError| error.to_string();
    plant.study().rest(machine.experiment.start_time_s, Holding::AsReleased, Search::default()).map_err(failed)?;
    let length_m = plant.tip_bodies().iter().map(|body| distance_to_tip_m(machine, *body)).fold(0.0, f64::max);
    let distances = plant.outputs().tips().iter().zip(unstrained).map(|(tip, place)| (tip.position_m - place).norm());
    let pulled = machine.gravity_m_s2.norm() > 0.0;
    let deflection = distances.zip(plant.tip_bodies()).filter(|_| pulled).max_by(|a, b| a.0.total_cmp(&b.0)).map(
        |(deflection_m, body)| StaticDeflection { body: machine.bodies[*body].name.clone(), deflection_m, length_m },
    );
    let flexible = machine.bodies.iter().any(|body| !body.is_rigid());
    let modes = if flexible { plant.study().modes(MODES).map_err(failed)? } else { Vec::new() };
    Ok((deflection, modes.iter().map(|mode| mode.frequency_hz).collect()))
}

/// Distance in m from the root to the outer end of a body, measured along the bodies.
fn distance_to_tip_m(machine: &Machine, body: usize) -> f64 {
    let (mut distance_m, mut at) = (machine.bodies[body].length_m, body);
    while let Parent::Body { index, position_m } = machine.bodies[at].joint.parent {
        distance_m += position_m;
        at = index;
    }
    distance_m
}

/// Returns the efforts of a joint between its start and end positions; `None` if the joint cannot move or cannot be held.
fn effort(held: &Machine, body: usize, joint: &OneFreedom) -> Result<Option<Effort>, PlantError> {
    let Some((travel, _)) = held.bodies[body].joint.kind.one_freedom() else { return Ok(None) };
    if joint.motion != JointMotion::Free || held.spatials().next().is_some() || !held.closures.is_empty() {
        return Ok(None);
    }
    let (start, end) = (joint.start_angle_rad, joint.latch.as_ref().map_or(0.0, |latch| latch.angle_rad));
    let towards = if end < start { -1.0 } else { 1.0 };
    let row = held.one_freedoms().position(|(other, _)| other == body).unwrap_or_default();
    let mut machine = held.clone();
    let mut points = Vec::with_capacity(POINTS);
    for point in 0..POINTS {
        let place = start + (end - start) * point as f64 / (POINTS - 1) as f64;
        if let JointKind::Revolute(own) | JointKind::Prismatic(own) | JointKind::Sliding(own) =
            &mut machine.bodies[body].joint.kind
        {
            own.start_angle_rad = place;
        }
        let mut plant = Plant::new(Arc::new(machine.clone()));
        plant.study().rest(machine.experiment.start_time_s, Holding::AsReleased, Search::default())?;
        let outputs = &plant.outputs().joints()[row];
        // in equilibrium, motor, end stop and gravity balance
        let drive = outputs.torque_applied_n_m;
        points.push((place, drive, -drive - outputs.holding_torque_n_m));
    }
    let largest = points.iter().map(|(_, drive, gravity)| drive.abs().max(gravity.abs())).fold(0.0, f64::max);
    let driven_on = |(_, drive, gravity): &&(f64, f64, f64)| towards * (drive + gravity) > NO_EFFORT * largest;
    let stands = (end - start).abs() <= joint.latch.as_ref().map_or(1e-6, |latch| latch.capture_rad.max(1e-6));
    let reaches = if stands {
        Reach::Stands
    } else if largest == 0.0 || !points.iter().take(1).all(|point| driven_on(&point)) {
        Reach::TurnsAway
    } else {
        // at the end position itself the springs may be unloaded
        match points[..POINTS - 1].iter().find(|point| !driven_on(point)) {
            Some((place, ..)) => Reach::StallsAt(travel.shown(*place)),
            None => Reach::Arrives,
        }
    };
    let worst = points.iter().max_by(|a, b| a.2.abs().total_cmp(&b.2.abs())).copied().unwrap_or_default();
    let along = points.iter().map(|(_, drive, _)| towards * drive);
    Ok(Some(Effort {
        name: held.bodies[body].joint.name.clone(),
        travel,
        gravity: worst.2.abs(),
        gravity_at: travel.shown(worst.0),
        drive: [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)],
        end: travel.shown(end),
        has_latch: joint.latch.as_ref().is_some_and(|latch| latch.enable),
        reaches,
    }))
}

/// Centre of mass of the model in its current position, and inertia about it.
fn mass_properties(plant: &Plant) -> ([f64; 3], [f64; 6]) {
    let (mut mass_kg, mut first, mut second, mut own) =
        (0.0, Vector3::zeros(), Matrix3::zeros(), Matrix3::<f64>::zeros());
    let shape = plant.shape();
    for (index, body) in plant.machine().bodies.iter().enumerate() {
        let mesh_m = plant.mesh_m(index);
        for ends in mesh_m.windows(2) {
            let half_m = 0.5 * (ends[1] - ends[0]);
            // the mass of a modal body is lumped at the midpoints of its cells
            let rule: &[(f64, f64)] = if body.is_modal() { &[(0.0, 2.0)] } else { &GAUSS };
            let places_m: Vec<f64> = rule.iter().map(|(at, _)| ends[0] + half_m * (1.0 + at)).collect();
            let sections = plant.sections(index, &places_m);
            for ((section, place_m), (_, weight)) in sections.iter().zip(places_m).zip(rule) {
                let law = body.section.at(place_m);
                let (length_m, position) = (weight * half_m, section.position_m);
                let [y, z] = law.first_moment_kg;
                let [yy, yz, zz] = law.second_moment_kg_m;
                let off_axis = section.rotation * Vector3::new(0.0, y, z);
                let spread = Matrix3::new(0.0, 0.0, 0.0, 0.0, yy, yz, 0.0, yz, zz);
                mass_kg += length_m * law.mass_kg_m;
                first += length_m * (law.mass_kg_m * position + off_axis);
                second += length_m
                    * (law.mass_kg_m * position * position.transpose()
                        + position * off_axis.transpose()
                        + off_axis * position.transpose()
                        + section.rotation * spread * section.rotation.transpose());
            }
        }
        for mass in &body.masses {
            let (position, rotation) = if body.is_rigid() {
                (shape[index][0].position_m, shape[index][0].rotation)
            } else {
                let section = &plant.sections(index, &[mass.position_m])[0];
                (section.position_m, section.rotation)
            };
            let place = position + rotation * mass.offset_m;
            mass_kg += mass.mass_kg;
            first += mass.mass_kg * place;
            second += mass.mass_kg * place * place.transpose();
            own += rotation * mass.inertia_kg_m2 * rotation.transpose();
        }
    }
    let centre = if mass_kg > 0.0 { first / mass_kg } else { first };
    let about_centre = second - mass_kg * centre * centre.transpose();
    let inertia = Matrix3::identity() * about_centre.trace() - about_centre + own;
    let six = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].map(|place| inertia[place]);
    (centre.into(), six)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assessed(text: &str) -> Assessment {
        Assessment::new(&foldwing_file::parse(text, "rod.toml").unwrap_or_else(|error| panic!("{error}")))
    }

    /// A clamped rod with a tip mass agrees with closed-form results: mass, centre of mass and inertia to a relative 1e-12; the tip
    /// deflection `q L⁴/8EI + P L³/3EI` to 1e-4 (a deflection of a twentieth of the length would already show the effect of large
    /// rotations); the first frequency of the rod alone (root 1.87510) to 1e-5.
    #[test]
    fn a_clamped_rod_has_what_textbooks_say() {
        let rod = |mass_kg: f64| {
            let mass = if mass_kg > 0.0 {
                format!(
                    "[mass.tip]\nbody = \"rod\"\nposition_m = 0.5\nmass_kg = {mass_kg:?}\noffset_m = [0.0, 0.1, 0.0]\n"
                )
            } else {
                String::new()
            };
            format!(
                "name = \"Rod\"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[section.s]\nshape = \"rectangle\"\nwidth_m = 0.02\n\
                 height_m = 0.01\ndensity_kg_m3 = 2700.0\nyoungs_modulus_Pa = 7.0e10\npoisson_ratio = 0.3\n[body.rod]\nlength_m = 0.5\n\
                 section = \"s\"\nelements = 8\n[joint.mount]\ntype = \"clamped\"\nparent = \"root\"\nchild = \"rod\"\n{mass}"
            )
        };
        let (length, per_length, stiffness) = (0.5f64, 2700.0 * 0.02 * 0.01, 7.0e10 * 0.02 * 0.01f64.powi(3) / 12.0);
        let near = |found: f64, expected: f64, share: f64| {
            assert!((found - expected).abs() <= share * expected.abs(), "{found} is not {expected}");
        };
        let (own, tip) = (per_length * length, 0.3);
        let total = own + tip;
        let answer = assessed(&rod(tip));
        let [x, y, z] = answer.centre_of_mass_m;
        near(x, (own * 0.25 + tip * 0.5) / total, 1e-12);
        near(y, tip * 0.1 / total, 1e-12);
        assert!(z.abs() < 1e-15);
        let [xx, yy, zz, xy, ..] = answer.inertia_kg_m2;
        let reduced = own * tip / total; // two bodies about their common centre of mass
        let (across, thick) = (own * 0.02f64.powi(2) / 12.0, own * 0.01f64.powi(2) / 12.0);
        let along = own * length * length / 12.0;
        near(xx, across + thick + reduced * 0.01, 1e-12);
        near(yy, along + thick + reduced * 0.0625, 1e-12);
        near(zz, along + across + reduced * 0.0725, 1e-12);
        near(xy, -reduced * 0.25 * 0.1, 1e-12);

        let bare = assessed(&rod(0.0));
        let deflection = bare.static_deflection.expect("a clamped rod sags");
        near(deflection.deflection_m, per_length * 9.81 * length.powi(4) / (8.0 * stiffness), 1e-4);
        let first_hz =
            1.875_104f64.powi(2) / std::f64::consts::TAU * (stiffness / (per_length * length.powi(4))).sqrt();
        near(bare.frequencies_hz[0], first_hz, 1e-3); // rotary inertia lowers the frequency by about 5e-4
        assert!(bare.warnings.is_empty(), "{:?}", bare.warnings);
    }

    /// The gravity torque on a horizontal hinge is weight times lever arm. A motor that cannot lift the weight stalls where the two
    /// torques are equal, and one that can reaches the end; a latch on the opposite side is never reached.
    #[test]
    fn a_hinge_must_bear_weight_times_arm() {
        let arm = |limit: f64, latch: f64| {
            format!(
                "name = \"Arm\"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[section.s]\nshape = \"rectangle\"\nwidth_m = 0.02\n\
                 height_m = 0.02\ndensity_kg_m3 = 2700.0\nyoungs_modulus_Pa = 2.0e12\npoisson_ratio = 0.3\n[body.rod]\nlength_m = 0.5\n\
                 section = \"s\"\nelements = 2\n[joint.h]\ntype = \"revolute\"\nparent = \"root\"\nchild = \"rod\"\n\
                 axis = [0.0, 1.0, 0.0]\nstart_angle_deg = 90.0\n[joint.h.motor]\nstiffness_N_m_rad = 100.0\n\
                 torque_limit_N_m = {limit:?}\n[joint.h.latch]\nangle_deg = {latch:?}\nstiffness_ratio = 1e3\n"
            )
        };
        let weight = 2700.0 * 4e-4 * 0.5 * 9.81;
        let answer = assessed(&arm(5.0, 0.0));
        let joint = &answer.joints[0];
        assert!((joint.gravity - weight * 0.25).abs() < 1e-4 * weight, "{} at {}", joint.gravity, joint.gravity_at);
        assert!(joint.gravity_at.abs() < 1e-9 && joint.reaches == Reach::Arrives, "{}", joint.text());
        // the lever arm is vertical at 90 deg; 1 N·m lifts the weight until weight · arm · cos θ = 1
        let stall_deg = (1.0 / (weight * 0.25)).acos().to_degrees();
        let Reach::StallsAt(place) = assessed(&arm(1.0, 0.0)).joints[0].reaches else { panic!("{}", answer.text()) };
        assert!(place <= stall_deg && place > stall_deg - 8.0, "{place} of {stall_deg}");
        let away = assessed(&arm(5.0, 130.0));
        assert!(
            away.warnings[0].contains("joint h: the latch at 130 deg is never reached without a command"),
            "{:?}",
            away.warnings
        );
    }
}

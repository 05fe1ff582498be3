//! Gradients of runs with strip theory, against each other and against differences of runs.

use super::*;
use crate::aero::flow::GustShape;
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::strip::indicial::Fit;
use crate::aero::surface::Profile;
use crate::machine::Coupling;
use crate::machine::builder::{FlapBuilder, GustBuilder, RotorSettings};
use nalgebra::{Rotation3, Vector3};

/// Numbers of a folding wing in wind.
#[derive(Clone, Copy)]
pub(super) struct InAir {
    pub(super) wing: Numbers,
    pub(super) wind: f64,
    pub(super) density: f64,
    pub(super) chord: f64,
    pub(super) axis: f64,
    pub(super) incidence: f64,
    pub(super) gust: f64,
    pub(super) flap: f64,
    pub(super) radius: f64,
}

/// Joint of the inner wing.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Root {
    Hinge,
    Free,
    Ball,
    Universal,
}

/// Kind of the run.
#[derive(Clone, Copy)]
pub(super) struct Kind {
    pub(super) latched: bool,
    /// With a rigid latch.
    pub(super) rigid: bool,
    /// On a root joint that follows a table.
    pub(super) driven: bool,
    pub(super) unsteady: bool,
    pub(super) established: bool,
    /// With apparent mass, leading-edge suction, profile drag and compressibility.
    pub(super) full: bool,
    /// With a gust and a control surface, from an equilibrium.
    pub(super) gusty: bool,
    /// With a motor that loses its torque within an aerodynamic step.
    pub(super) fails: bool,
    /// With a polar that falls beyond stall.
    pub(super) stalls: bool,
    pub(super) root: Root,
    /// With a slender boom and a propeller.
    pub(super) several: bool,
    /// With a lifting line.
    pub(super) line: bool,
    /// With the staggered coupling.
    pub(super) staggered: bool,
    /// With shear in both bodies, soft enough to matter.
    pub(super) sheared: bool,
}

impl Kind {
    /// A latched wing at a hinge, without lags, in an established flow.
    pub(super) const PLAIN: Self = Self {
        latched: true,
        rigid: false,
        driven: false,
        unsteady: false,
        established: true,
        full: false,
        gusty: false,
        fails: false,
        stalls: false,
        root: Root::Hinge,
        several: false,
        line: false,
        staggered: false,
        sheared: false,
    };
    /// The same with lags and everything else that strips without a polar have.
    pub(super) const FULL: Self = Self { unsteady: true, full: true, ..Self::PLAIN };
}

impl InAir {
    pub(super) const USUAL: Self = Self {
        // stopped well within a step
        wing: Numbers { stop: 0.31, ..Numbers::USUAL },
        wind: 14.0,
        density: 1.2,
        chord: 0.06,
        axis: 0.35,
        incidence: 4.0,
        gust: 0.8,
        flap: 0.1,
        radius: 0.03,
    };

    pub(super) fn machine(self, kind: Kind) -> Result<Machine, String> {
        let strips = Air::strips().unsteady(kind.unsteady).apparent_mass(kind.full).leading_edge_suction(kind.full);
        let strips = strips.tip_loss(kind.line);
        let strips = if kind.full && !kind.stalls { strips.speed_of_sound_m_s(60.0).fit(Fit::Fine) } else { strips };
        let air = if kind.several {
            let boom = Air::slender_body(self.boom()).apparent_mass(kind.full);
            let mut propeller = RotorSettings::on("spinner", 0.02);
            propeller.polars = vec![("foil".to_owned(), stalling())];
            propeller.features.dynamic_inflow = kind.full;
            Air::parts().part("boom", boom).part("lift", strips).part("propeller", Air::rotor(propeller))
        } else {
            strips
        };
        let air = air
            .density_kg_m3(self.density)
            .wind_m_s([0.6, -self.wind, 0.3])
            .step_s(8e-3)
            .established(kind.established)
            .coupling(match kind.staggered {
                true => Coupling::Staggered,
                false => Coupling::Iterated { tolerance: 1e-12, most_iterations: 200 },
            });
        let surface = |body: &str| {
            let profile = Profile { drag_coefficient: 0.02, ..Profile::THIN };
            let surface = LiftingSurface::on(body, 2)
                .chord_m(Along::constant(self.chord))
                .elastic_axis_fraction(self.axis)
                .incidence_deg(Along::constant(self.incidence));
            if kind.stalls {
                surface.profile(Profile { polar: Some(stalling()), ..Profile::THIN })
            } else if kind.full {
                surface.profile(profile)
            } else {
                surface
            }
        };
        // the equilibrium has the stop far away
        let wing = if kind.gusty { Numbers { stop: -2.0, ..self.wing } } else { self.wing };
        let root = match kind.root {
            Root::Hinge => None,
            Root::Free => Some(Joint::free("flight").start_velocity_m_s([0.4, -3.0, 0.2])),
            Root::Ball => Some(Joint::ball("hook")),
            // axes that are not at right angles
            Root::Universal => Some(Joint::universal("cardan", [0.0, 1.0, 0.2], [0.1, 0.3, 1.0])),
        };
        let builder = match root {
            None if kind.sheared => {
                wing.builder_with(|solid| Solid { shear_factor: Some(0.05), ..solid }, hinge(), kind.latched)
            }
            None => wing.builder(kind.latched),
            Some(root) => {
                let rate = 10.0 * self.wing.start_rate;
                let mount = Rotation3::new(Vector3::new(0.1, -0.2, 0.05)).into_inner();
                let root = root.at_root([0.1, 0.2, 0.3]).mount(mount);
                let root = match kind.root {
                    Root::Universal => {
                        root.motor(Motor { stiffness_n_m_rad: 40.0, damping_n_m_s_rad: 0.2, ..Motor::default() })
                    }
                    Root::Hinge | Root::Free | Root::Ball => root.start_angular_velocity_rad_s([rate, 2.0, -1.5]),
                };
                // without stiffness the remainder of the iteration moves the wing
                wing.builder_on(root, kind.latched).solver(Solver { tolerance: 1e-12, ..solver() })
            }
        };
        let builder = builder.air(air).surface(surface("inner")).surface(surface("outer"));
        let builder = if kind.several { self.with_boom_and_propeller(builder) } else { builder };
        if !kind.gusty {
            let mut machine = builder.build().map_err(|refused| refused.to_string())?;
            if kind.driven
                && let JointKind::Revolute(flap) = &mut machine.bodies[0].joint.kind
            {
                let knots = vec![(0.0, 0.0), (0.016, 0.3 * self.wing.stop), (0.05, -0.04), (0.132, 0.08), (0.3, 0.0)];
                flap.motion = JointMotion::Prescribed(Motion::Table(knots));
            }
            if kind.fails {
                let (effect, at_time_s) = (Effect::MotorLoss { body: 1 }, Some(self.wing.fail_s));
                let name = "dies".to_owned();
                machine.failures.push(Failure { name, effect, at_time_s, after: None, when: None, delay_s: 0.0 });
            }
            return Ok(if kind.rigid { rigid::hardened(machine) } else { machine });
        }
        let gust = GustBuilder::new("bump", GustShape::OneMinusCosine { length_m: 0.5 }, [0.1, 0.2, self.gust])
            .direction([0.0, -1.0, 0.0])
            .speed_m_s(14.0)
            .origin_m([0.0, 0.2, 0.0]);
        let flap = FlapBuilder::new("aileron", "outer", [0.1, 0.3], 0.75).command_rad(self.flap);
        let mut machine = builder.gust(gust).flap(flap).build().map_err(|refused| refused.to_string())?;
        machine.experiment.start = StartState::Equilibrium;
        Ok(machine)
    }
}

/// A polar with a drop of the lift at 14°, with drag and moment.
pub(super) fn stalling() -> Polar {
    let row = |angle_deg: f64, lift, drag, moment| PolarRow { angle_rad: angle_deg.to_radians(), lift, drag, moment };
    let rows = vec![
        row(-180.0, 0.0, 0.05, 0.0),
        row(-90.0, -1.1, 1.8, 0.4),
        row(-30.0, -0.8, 0.5, 0.15),
        row(-9.0, -0.7, 0.03, -0.02),
        row(0.7, 0.3, 0.01, -0.05),
        row(7.3, 0.95, 0.016, -0.06),
        row(14.0, 1.35, 0.04, -0.04),
        row(19.0, 0.9, 0.2, -0.1),
        row(45.0, 1.1, 0.9, -0.25),
        row(90.0, 0.1, 1.9, -0.5),
        row(180.0, 0.0, 0.05, 0.0),
    ];
    Polar { rows }
}

/// A number and its place.
pub(super) type AirPlace = (&'static str, fn(&mut InAir) -> &mut f64);

pub(super) const AIR_PLACES: [AirPlace; 13] = [
    ("wind", |n| &mut n.wind),
    ("density", |n| &mut n.density),
    ("chord", |n| &mut n.chord),
    ("axis", |n| &mut n.axis),
    ("incidence", |n| &mut n.incidence),
    ("stiffness", |n| &mut n.wing.stiffness),
    ("torque", |n| &mut n.wing.torque),
    ("start_angle", |n| &mut n.wing.start_angle),
    ("start_rate", |n| &mut n.wing.start_rate),
    ("length", |n| &mut n.wing.length),
    ("thickness", |n| &mut n.wing.thickness),
    ("mass", |n| &mut n.wing.mass),
    ("beta", |n| &mut n.wing.beta),
];

fn air_beside((_, place): AirPlace, shift: f64) -> InAir {
    let mut numbers = InAir::USUAL;
    *place(&mut numbers) += shift;
    numbers
}

fn air_size(place: AirPlace) -> f64 {
    *(place.1)(&mut { InAir::USUAL })
}

/// Results: gauge, tip, energy, angle of the fold or, where it is latched rigidly, another coordinate of the tip, the force of the air and, if
/// there is one, the reaction of the root, at both times.
fn air_results(plant: &Plant, kind: Kind) -> Vec<RunResult> {
    let layout = *plant.outputs().layout();
    let indices = [
        layout.gauges.place(0, 0),
        layout.tips.place(0, 0) + 2,
        layout.energy.place(0, 0),
        if kind.rigid { layout.tips.place(0, 0) } else { layout.joints.place(fold_of(kind), 0) },
        layout.air_total.place(0, 0) + 2,
        layout.root.place(0, 0) + 3,
    ];
    let indices = &indices[..indices.len() - usize::from(kind.root == Root::Free)];
    (0..2).flat_map(|time| indices.iter().map(move |&index| RunResult::Output { index, time })).collect()
}

/// Place of the fold among the joints with one degree of freedom.
fn fold_of(kind: Kind) -> usize {
    usize::from(kind.root == Root::Hinge)
}

/// The largest differences of forward and adjoint, and of forward and the slopes of `run`, relative to the largest entry of a result.
pub(super) fn compare_in_air(
    kind: Kind,
    at: (&[f64], &[AirPlace]),
    run: impl Fn(&Tape, Machine, &[RunResult]) -> Vec<f64>,
) -> (f64, f64, usize) {
    compare_results_in_air(kind, at, |plant| air_results(plant, kind), run)
}

/// The same for results that a function gives.
pub(super) fn compare_results_in_air(
    kind: Kind,
    (times_s, places): (&[f64], &[AirPlace]),
    results: impl Fn(&Plant) -> Vec<RunResult>,
    run: impl Fn(&Tape, Machine, &[RunResult]) -> Vec<f64>,
) -> (f64, f64, usize) {
    let machine = |numbers: InAir| numbers.machine(kind).unwrap_or_else(|error| panic!("{error}"));
    let mut plant = started(machine(InAir::USUAL));
    let tape = plant.run_on_tape(times_s).unwrap_or_else(|error| panic!("{error}"));
    let events = tape.crossings_s().count();
    let mut results = results(&plant);
    if events > 0 && kind.latched {
        results.push(RunResult::LatchTime { joint: fold_of(kind) });
    }
    let parameter = |place: &AirPlace| {
        let machine = |shift: f64| plant_of(air_beside(*place, shift).machine(kind));
        Parameter::new(place.0, 0.0, 1e-3 * air_size(*place), machine).unwrap_or_else(|error| panic!("{error}"))
    };
    let parameters = places.iter().map(parameter).collect();
    let mut gradient = Gradient::new(&mut plant, &tape, parameters).unwrap_or_else(|error| panic!("{error}"));
    let forward = gradient.forward(&results).unwrap_or_else(|error| panic!("{error}"));
    let adjoint: Vec<Vec<f64>> =
        results.iter().map(|result| gradient.adjoint(*result).unwrap_or_else(|error| panic!("{error}"))).collect();
    let own = gradient.values(&results).unwrap_or_else(|error| panic!("{error}"));
    same_values(&own, &run(&tape, machine(InAir::USUAL), &results));
    let mut known = vec![vec![0.0; places.len()]; results.len()];
    // with a polar, small enough that no section passes a row, and with shear, that the stop meets the same waves
    let share = if kind.stalls || kind.several || kind.sheared { 1e-5 } else { 1e-3 };
    for (column, place) in places.iter().enumerate() {
        let step = share * air_size(*place);
        for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
            for (row, value) in known.iter_mut().zip(run(&tape, machine(air_beside(*place, steps * step)), &results)) {
                row[column] += weight / (12.0 * step) * value;
            }
        }
    }
    let places: Vec<(&str, f64)> = places.iter().map(|place| (place.0, air_size(*place))).collect();
    let [both, differences] = disagreements((&results, &own), &places, [&forward, &adjoint, &known]);
    (both, differences, events)
}

/// Outputs of a simulation at times, those of its own steps: fixed steps divide the aerodynamic ones, so that neighbouring machines take the
/// same.
pub(super) fn simulated(times_s: &[f64], machine: Machine, results: &[RunResult]) -> Vec<f64> {
    let mut plant = started(machine);
    let mut values = vec![f64::NAN; results.len()];
    for (index, time_s) in times_s.iter().enumerate() {
        plant.step(*time_s).unwrap_or_else(|error| panic!("{error}"));
        for (value, result) in values.iter_mut().zip(results) {
            if let RunResult::Output { index: output, time } = *result
                && time == index
            {
                *value = plant.outputs().values()[output];
            }
        }
    }
    values
}

/// GR-22: of a wing with strips, quasi-steady and with lags, from a sudden and an established flow, by numbers of air, surfaces,
/// structure and start: both ways, and by fourth-order differences of simulations, before any event and at ends of steps.
#[test]
fn gradients_in_air_are_those_of_simulations() {
    for (unsteady, established, full) in [(false, true, false), (true, true, true), (true, false, false)] {
        let kind = Kind { unsteady, established, full, ..Kind::PLAIN };
        let times_s = [0.032, 0.064];
        let places = if full { &AIR_PLACES[..] } else { &AIR_PLACES[..4] };
        let (both, differences, events) =
            compare_in_air(kind, (&times_s, places), |_, machine, results| simulated(&times_s, machine, results));
        assert_eq!(events, 0);
        assert!(both < 1e-10, "{unsteady} {established}: {both:.1e}");
        assert!(differences < 1e-6, "{unsteady} {established}: {differences:.1e}");
    }
}

/// GR-45: of a wing on a joint that follows a table, one knot within an aerodynamic step, by an angle of the table and numbers of air and
/// structure: both ways, and by fourth-order differences of simulations.
#[test]
fn gradients_in_air_by_a_prescribed_motion() {
    let kind = Kind { driven: true, ..Kind::FULL };
    let times_s = [0.032, 0.064];
    let knot: AirPlace = ("knot", |n| &mut n.wing.stop);
    let places = [&AIR_PLACES[..4], &AIR_PLACES[9..11], &[knot]].concat();
    let (both, differences, events) =
        compare_in_air(kind, (&times_s, &places), |_, machine, results| simulated(&times_s, machine, results));
    assert_eq!(events, 0);
    assert!(both < 1e-10, "{both:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-24: of a wing that starts in its equilibrium in air and meets a gust, with a control surface at an angle: the slopes of the
/// start, which converges to 1e-9 of the loads, included.
#[test]
fn gradients_in_a_gust_start_in_an_equilibrium() {
    let kind = Kind { latched: false, gusty: true, ..Kind::FULL };
    let times_s = [0.032, 0.064];
    let own: [AirPlace; 2] = [("gust", |n| &mut n.gust), ("flap", |n| &mut n.flap)];
    let places = [&AIR_PLACES[..6], &own].concat();
    let (both, differences, events) =
        compare_in_air(kind, (&times_s, &places), |_, machine, results| simulated(&times_s, machine, results));
    assert_eq!(events, 0);
    assert!(both < 1e-10, "{both:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

/// GR-23: the same through a latch, elastic or rigid with a prescribed root joint, and onto a stop within an aerodynamic step, and at times within steps, by differences of runs with the
/// same steps.
#[test]
fn gradients_in_air_pass_through_events() {
    for (latched, rigid) in [(true, false), (true, true), (false, false)] {
        let kind = Kind { latched, rigid, driven: rigid, ..Kind::FULL };
        let times_s = [0.1213, 0.159];
        let knot: AirPlace = ("knot", |n| &mut n.wing.stop);
        let mut places = [0, 2, 5, 7, 9, 11].map(|place| AIR_PLACES[place]).to_vec();
        places.extend(rigid.then_some(knot));
        let (both, differences, events) = compare_in_air(kind, (&times_s, &places), |tape, machine, results| {
            retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
        });
        assert!(events > 0, "no event");
        assert!(both < 1e-10, "{latched} {rigid}: {both:.1e}");
        assert!(differences < 1e-6, "{latched} {rigid}: {differences:.1e}");
    }
}

/// GR-81: the same through a failure within an aerodynamic step, by its time and numbers of air and structure.
#[test]
fn gradients_in_air_pass_through_a_failure() {
    let kind = Kind { latched: false, fails: true, ..Kind::FULL };
    let times_s = [0.1213, 0.159];
    let time: AirPlace = ("fail_s", |n| &mut n.wing.fail_s);
    let places = [&[0, 2, 5, 7, 9].map(|place| AIR_PLACES[place])[..], &[time]].concat();
    let (both, differences, _) = compare_in_air(kind, (&times_s, &places), |tape, machine, results| {
        retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
    });
    println!("GR-81 {both:.1e} {differences:.1e}");
    assert!(both < 1e-10, "{both:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

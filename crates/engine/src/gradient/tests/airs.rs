//! Gradients of runs in air with polars, in free flight and with several aerodynamic models.

use super::air::{AIR_PLACES, AirPlace, InAir, Kind, Root, compare_in_air, simulated};
use super::*;
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::surface::Profile;
use crate::machine::builder::SlenderBodySettings;
use crate::solve::EquationsOfMotion;
use crate::solve::point::Point;
use nalgebra::{Matrix3, Vector3};

impl InAir {
    pub(super) fn boom(self) -> SlenderBodySettings {
        let radius_m = vec![[0.0, 0.01], [0.12, self.radius], [0.3, 0.5 * self.radius]];
        SlenderBodySettings {
            segments: Some(3),
            cross_flow_drag_coefficient: 1.1,
            axial_drag_coefficient: 0.3,
            ..SlenderBodySettings::on("boom", radius_m)
        }
    }

    /// Adds a flexible boom behind the inner wing, and a propeller of two blades on a stand, in oblique wind.
    pub(super) fn with_boom_and_propeller(self, builder: MachineBuilder) -> MachineBuilder {
        let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: 1400.0 };
        let boom =
            Body::beam("boom", 0.3, Solid::rectangle(0.02, 0.02, material)).elements(2).stiffness_damping_s(1e-3);
        let behind = Matrix3::from_columns(&[-Vector3::y(), Vector3::x(), Vector3::z()]);
        let boom_joint = Joint::clamped("tail").on("inner").mount(behind);
        let drag = Motor { damping_n_m_s_rad: 1e-3, ..Motor::default() };
        let spinner = Body::rigid("spinner").inertia(0.02, [0.0; 3], Matrix3::identity() * 4e-5);
        let shaft = Joint::revolute("shaft", [1.0, 0.0, 0.0])
            .at_root([2.0, 0.0, 0.0])
            .mount(behind)
            .motor(drag)
            .start_rate_rad_s(30.0);
        let mut builder = builder.body(boom, boom_joint).body(spinner, shaft);
        for (name, side) in [("blade0", 1.0), ("blade1", -1.0)] {
            let along = Vector3::z() * side;
            let ahead = Vector3::x().cross(&along);
            let mount = Matrix3::from_columns(&[along, ahead, along.cross(&ahead)]);
            let blade =
                Body::rigid(name).inertia(0.01, [0.05, 0.0, 0.0], Matrix3::from_diagonal(&[1e-6, 4e-5, 4e-5].into()));
            let surface = LiftingSurface::on(name, 3)
                .blade([0.0, 0.03, 0.07, 0.1].to_vec(), vec!["foil".to_owned(); 4])
                .chord_m(Along::constant(0.02))
                .elastic_axis_fraction(0.3)
                .incidence_deg(Along::constant(-12.0))
                .length_m(0.1);
            let root = Joint::clamped(format!("root_{name}")).on("spinner").offset_m(along * 0.02).mount(mount);
            builder = builder.body(blade, root).surface(surface);
        }
        builder
    }
}

/// GR-95: of a wing whose strips have a polar, attached and stalled, quasi-steady and with lags, from a sudden and an established flow and
/// through a latch or onto a stop: both ways, and by differences of simulations or of runs with the same steps, so small that no strip passes
/// a row of the polar.
#[test]
fn gradients_in_air_with_polars() {
    for (unsteady, established, full) in [(false, true, false), (true, true, true), (true, false, false)] {
        let kind = Kind { unsteady, established, full, stalls: true, ..Kind::PLAIN };
        let times_s = [0.032, 0.064];
        let places = if full { &AIR_PLACES[..] } else { &AIR_PLACES[..5] };
        let (both, differences, events) =
            compare_in_air(kind, (&times_s, places), |_, machine, results| simulated(&times_s, machine, results));
        println!("GR-95 {unsteady} {established}: {both:.1e} {differences:.1e}");
        assert_eq!(events, 0);
        assert!(both < 1e-10, "{unsteady} {established}: {both:.1e}");
        assert!(differences < 1e-6, "{unsteady} {established}: {differences:.1e}");
    }
    for latched in [true, false] {
        let kind = Kind { latched, stalls: true, ..Kind::FULL };
        let times_s = [0.1213, 0.159];
        let places = [0, 2, 4, 5, 7, 9].map(|place| AIR_PLACES[place]);
        let (both, differences, events) = compare_in_air(kind, (&times_s, &places), |tape, machine, results| {
            retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
        });
        println!("GR-95 {latched}: {both:.1e} {differences:.1e}");
        assert!(events > 0, "no event");
        assert!(both < 1e-10, "{latched}: {both:.1e}");
        assert!(differences < 1e-6, "{latched}: {differences:.1e}");
    }
}

/// GR-96: of a wing in free flight in air, and on a ball and a universal joint, through a latch, both ways and by differences of runs with the
/// same steps.
#[test]
fn gradients_of_free_flight_in_air() {
    let cases = [
        (Root::Free, false, false),
        (Root::Free, true, true),
        (Root::Ball, true, false),
        (Root::Universal, false, false),
    ];
    for (root, rigid, stalls) in cases {
        let kind = Kind { root, rigid, stalls, ..Kind::FULL };
        let times_s = [0.1213, 0.159];
        let rate = if root == Root::Universal { 5 } else { 8 };
        let places = [0, 2, 4, 7, rate, 9, 11].map(|place| AIR_PLACES[place]);
        let (both, differences, events) = compare_in_air(kind, (&times_s, &places), |tape, machine, results| {
            retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
        });
        println!("GR-96 {} {rigid} {stalls}: {both:.1e} {differences:.1e}", root as usize);
        assert!(events > 0, "no event");
        // on a universal joint 8.1e-9, for a reason that is not known; loads and displacements are transposes there too (below)
        let allowed = if root == Root::Universal { 2e-8 } else { 1e-10 };
        assert!(both < allowed, "{rigid} {stalls}: {both:.1e}");
        assert!(differences < 1e-6, "{rigid} {stalls}: {differences:.1e}");
    }
}

/// CR-85: at the start of an aerodynamic step, accelerations of a wing in free flight are those of the equations; the end of the step before
/// has a rest, (J6).
#[test]
fn accelerations_in_free_flight_are_those_of_the_equations() {
    let kind = Kind { root: Root::Free, ..Kind::FULL };
    let machine = InAir::USUAL.machine(kind).unwrap_or_else(|error| panic!("{error}"));
    let mut plant = started(machine);
    let tape = plant.run_on_tape(&[0.0437]).unwrap_or_else(|error| panic!("{error}"));
    let mut worst = 0.0f64;
    for step in tape.steps.iter().filter(|step| step.renewed) {
        let system = plant.system_mut();
        parameter::adopt(system, step, &tape.inputs);
        system.equations.branch_s = step.middle_s();
        let Point { time_s, q, v, a, .. } = &step.start;
        let mut left = [a.clone(), vec![0.0; a.len()]].map(|a| {
            let mut rows = vec![0.0; a.len()];
            system.equations.residual(*time_s, q, v, &a, &mut rows);
            system.equations.clear_held(&mut rows);
            rows.into_iter().fold(0.0f64, |most, row| most.max(row.abs()))
        });
        left[0] /= left[1];
        worst = worst.max(left[0]);
    }
    println!("CR-85 {worst:.1e}");
    // round-off of the solution for the accelerations
    assert!(worst < 1e-10, "{worst:.1e}");
}

/// GR-98: of a wing on strips with a slender boom and beside a propeller, without apparent mass and lags and with all of them, by numbers of
/// air, surfaces, boom and structure, through the latch: both ways, and by differences of runs with the same steps.
#[test]
fn gradients_with_several_airs() {
    let radius: AirPlace = ("radius", |n| &mut n.radius);
    for full in [false, true] {
        let kind = Kind { several: true, full, unsteady: full, ..Kind::PLAIN };
        let times_s = [0.0583, 0.1213];
        let places = [&[0, 1, 2, 5, 7, 9].map(|place| AIR_PLACES[place])[..], &[radius]].concat();
        let (both, differences, events) = compare_in_air(kind, (&times_s, &places), |tape, machine, results| {
            retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
        });
        println!("GR-98 {full}: {both:.1e} {differences:.1e}");
        assert!(events > 0, "no event");
        assert!(both < 1e-10, "{full}: {both:.1e}");
        assert!(differences < 1e-6, "{full}: {differences:.1e}");
    }
}

/// GR-95: a strip exactly at a row of its polar is an error by name, unless the row lies on a straight line.
#[test]
fn a_strip_at_a_row_of_its_polar_is_an_error() {
    // so heavy that the loads move it by less than round-off
    let material = Material { youngs_modulus_pa: 3e9, shear_modulus_pa: 1.2e9, density_kg_m3: 1e13 };
    let plate = Solid::rectangle(0.05, 0.004, material);
    for (lift, is_kink) in [(0.4, true), (0.5, false)] {
        let row = |angle_deg: f64, lift| PolarRow { angle_rad: angle_deg.to_radians(), lift, drag: 0.01, moment: 0.0 };
        let polar = Polar { rows: vec![row(-180.0, -18.0), row(5.0, lift), row(180.0, 18.0)] };
        let machine = Machine::builder("Row")
            .gravity_m_s2([0.0; 3])
            .body(Body::beam("wing", 0.4, plate).elements(1), Joint::clamped("mount"))
            .air(Air::strips().density_kg_m3(1.2).wind_m_s([0.0, -5.0, 0.0]).step_s(4e-3))
            .surface(
                LiftingSurface::on("wing", 2)
                    .chord_m(Along::constant(0.1))
                    .incidence_deg(Along::constant(5.0))
                    .profile(Profile { polar: Some(polar), ..Profile::THIN }),
            )
            .solver(solver())
            .build()
            .unwrap_or_else(|error| panic!("{error}"));
        let mut plant = started(machine);
        let tape = plant.run_on_tape(&[0.01]).unwrap_or_else(|error| panic!("{error}"));
        let result = RunResult::Output { index: plant.outputs().layout().air_total.place(0, 0) + 2, time: 0 };
        let mut gradient = Gradient::new(&mut plant, &tape, Vec::new()).unwrap_or_else(|error| panic!("{error}"));
        match gradient.forward(&[result]) {
            Ok(_) => assert!(!is_kink, "no error"),
            Err(error) => {
                let text = error.to_string();
                assert!(is_kink, "{text}");
                assert!(text.starts_with("wing, at 0.004 s: a section is exactly at a row of its polar"), "{text}");
            }
        }
    }
}

/// GR-96: displacements of sections by the coordinates and their loads on these are transposes, at stages too, whose parameters do not fulfil the
/// constraints.
#[test]
fn sections_and_their_loads_are_transposes() {
    let mut random = fastrand::Rng::with_seed(3);
    for root in [Root::Hinge, Root::Free, Root::Ball, Root::Universal] {
        let kind = Kind { root, ..Kind::FULL };
        let mut plant = started(InAir::USUAL.machine(kind).unwrap_or_else(|error| panic!("{error}")));
        let tape = plant.run_on_tape(&[0.0437]).unwrap_or_else(|error| panic!("{error}"));
        let equations = &mut plant.system_mut().equations;
        let mut sections = sections::Sections::new(equations, false);
        let mut worst = [0.0f64; 2];
        for step in &tape.steps {
            for at in step.stages.iter().chain([&step.end]) {
                let n = at.q.len();
                let mut draw = |count: usize| (0..count).map(|_| 2.0 * random.f64() - 1.0).collect::<Vec<f64>>();
                let (w, loads, change, on) =
                    (draw(n), draw(sections.entries(equations)), draw(n), draw(sections.entries(equations)));
                let mut rows = vec![0.0; n];
                sections.place(equations, &at.q);
                sections.add_rows(equations, &at.q, &loads, &mut rows);
                let mut on_loads = vec![0.0; loads.len()];
                sections.add_on_loads(equations, &at.q, &w, &mut on_loads);
                // rows are those of the residual
                worst[0] =
                    worst[0].max((dot(&rows, &w) + dot(&on_loads, &loads)).abs() / dot(&on_loads, &on_loads).sqrt());
                let poses = sections.poses(equations, [&at.q, &at.v], [&change, &w]);
                let [on_q, _] = sections.on_motion(equations, [&at.q, &at.v], &on);
                worst[1] = worst[1].max((dot(&on_q, &change) - dot(&on, &poses)).abs() / dot(&poses, &poses).sqrt());
            }
        }
        println!("GR-96 {}: {worst:?}", root as usize);
        assert!(worst[0].max(worst[1]) < 1e-12, "{}: {worst:?}", root as usize);
    }
}

/// GR-103: of a wing with a lifting line, whose folding joint is bent, quasi-steady and with lags, from a sudden and an established flow, in a
/// gust with a control surface, and through a latch: both ways, and by differences of simulations or of runs with the same steps.
#[test]
fn gradients_in_air_with_a_lifting_line() {
    let line = Kind { line: true, ..Kind::PLAIN };
    let full = Kind { line: true, ..Kind::FULL };
    let gusty = Kind { latched: false, gusty: true, ..full };
    for kind in [line, full, Kind { established: false, unsteady: true, ..line }, gusty] {
        let times_s = [0.032, 0.064];
        let places = &AIR_PLACES[..if kind.full { 6 } else { 4 }];
        let (both, differences, _) =
            compare_in_air(kind, (&times_s, places), |_, machine, results| simulated(&times_s, machine, results));
        println!("GR-103 {both:.1e} {differences:.1e}");
        assert!(both < 1e-10, "{both:.1e}");
        assert!(differences < 1e-6, "{differences:.1e}");
    }
    let places = [0, 2, 5, 9].map(|place| AIR_PLACES[place]);
    let times_s = [0.1213, 0.159];
    let (both, differences, events) = compare_in_air(full, (&times_s, &places), |tape, machine, results| {
        retraced_at(tape, machine, &InputRows::default(), (&times_s, results))
    });
    println!("GR-103 latch {both:.1e} {differences:.1e}");
    assert!(events > 0, "no event");
    assert!(both < 1e-10, "{both:.1e}");
    assert!(differences < 1e-6, "{differences:.1e}");
}

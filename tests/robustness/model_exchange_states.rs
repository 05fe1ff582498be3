//! Model Exchange: energy accounts as states or not, nominal rates of strains, the frequency limit.

use crate::counting_allocator::allocations;
use crate::fmu::{Attempt, Fmu, Resources, WING};
use crate::model_exchange::{Outside, Phase};
use foldwing::instance::Version;
use foldwing::interface::{Interface, Value, guid};
use foldwing::packaging::Kinds;
use foldwing::plant::Plant;
use foldwing_fmu::exchange::*;
use foldwing_fmu::functions::*;
use foldwing_fmu::states::*;
use foldwing_fmu::types::*;
use nalgebra::DMatrix;
use std::ptr;
use std::sync::Arc;

const GOLAND: &str = include_str!("../../examples/models/goland_wing.toml");
/// Outputs that need the accounts.
const ACCOUNTED: [&str; 2] = ["energy.work", "energy.dissipated"];

fn kinds(version: Version, co_simulation: bool, accounts: bool) -> Kinds {
    Kinds { version, co_simulation, model_exchange: true, accounts, ..Kinds::default() }
}

fn table(text: &str, kinds: Kinds) -> Interface {
    kinds.interface(&foldwing::config::parse(text, "model.toml").expect("a model"))
}

/// An instance for Model Exchange only, with or without the energy accounts.
fn exchanged(text: &str, accounts: bool) -> Fmu {
    let resources = Resources::with(text);
    let table = table(text, kinds(Version::Fmi2, false, accounts));
    let guid = Some(guid(text, table.variables()));
    let attempt = Attempt { fmu_type: fmi2ModelExchange, guid, ..Attempt::of(text, &resources) };
    let (component, messages) = attempt.run();
    assert!(!component.is_null(), "refused: {messages:?}");
    Fmu { component, messages, table }
}

/// ME-15. In an FMU for Model Exchange only, the energy accounts are neither states nor outputs unless requested: derivatives, indicators
/// and outputs are bit-identical without them, through an event and after a reset; co-simulation always has them. Saved states of the two
/// kinds are incompatible.
#[test]
fn me15_accounts_are_states_if_asked_for() {
    for version in [Version::Fmi2, Version::Fmi3] {
        let with = |co_simulation, accounts| table(WING, kinds(version, co_simulation, accounts));
        let (bare, full, both) = (with(false, false), with(false, true), with(true, false));
        let named =
            |table: &Interface, part: &str| table.variables().iter().filter(|row| row.name.contains(part)).count();
        for (table, expected) in [(&bare, 0), (&full, 2), (&both, 2)] {
            assert_eq!(named(table, "state.energy."), 2 * expected, "states and their derivatives");
            assert_eq!(ACCOUNTED.iter().filter(|name| table.find(name).is_some()).count(), expected);
            assert!(table.find("energy.total").is_some() && table.find("solver.frequency_limit").is_some());
        }
        assert_eq!(full.nominals().len(), bare.nominals().len() + 2);
        assert!(!bare.find("energy.total").expect("a row").description.contains("work"));
        assert!(
            Interface::new(&foldwing::config::parse(WING, "m").expect("a model"))
                .find("solver.frequency_limit")
                .is_none()
        );
    }

    let names = ["fold.angle", "gauge.root.strain", "energy.total", "root.moment.y"];
    let [mut bare, mut full] =
        [false, true].map(|accounts| Outside::new(exchanged(WING, accounts)).in_phase(Phase::Continuous));
    for round in 0..2 {
        let n = bare.states.len();
        assert_eq!(full.states.len(), n + 2);
        assert_eq!(bare.states, full.states[..n], "round {round}");
        for k in 0..40 {
            let (crossed, other) = (bare.step(4e-6), full.step(4e-6));
            assert_eq!((crossed, &bare.states[..]), (other, &full.states[..n]), "round {round}, step {k}");
        }
        for name in names {
            assert_eq!(bare.fmu.get(name).to_bits(), full.fmu.get(name).to_bits(), "{name}");
        }
        assert!(full.states[n + 1] > 0.0, "energy is dissipated: {:?}", &full.states[n..]);
        // a wrong number of states is rejected with the name of the call
        let status = unsafe { fmi2SetContinuousStates(bare.fmu.component, full.states.as_ptr(), n + 2) };
        bare.fmu.refused(status, fmi2Error, &["nx", &n.to_string()]);
        for outside in [&mut bare, &mut full] {
            outside.fmu.ok(unsafe { fmi2Reset(outside.fmu.component) });
        }
        [bare, full] = [bare, full].map(|outside| outside.in_phase(Phase::Continuous));
    }

    let bytes = serialised(&full.fmu);
    let mut state: fmi2FMUstate = ptr::null_mut();
    let status = unsafe { fmi2DeSerializeFMUstate(bare.fmu.component, bytes.as_ptr().cast(), bytes.len(), &mut state) };
    bare.fmu.refused(status, fmi2Error, &["belongs to the model"]);
    let own = serialised(&bare.fmu);
    bare.fmu.ok(unsafe { fmi2DeSerializeFMUstate(bare.fmu.component, own.as_ptr().cast(), own.len(), &mut state) });
    bare.fmu.ok(unsafe { fmi2SetFMUstate(bare.fmu.component, state) });
}

fn serialised(fmu: &Fmu) -> Vec<u8> {
    let (mut state, mut size): (fmi2FMUstate, usize) = (ptr::null_mut(), 0);
    unsafe {
        fmu.ok(fmi2GetFMUstate(fmu.component, &mut state));
        fmu.ok(fmi2SerializedFMUstateSize(fmu.component, state, &mut size));
        let mut bytes = vec![0_u8; size];
        fmu.ok(fmi2SerializeFMUstate(fmu.component, state, bytes.as_mut_ptr().cast(), size));
        bytes
    }
}

/// ME-16. The nominal rate of stretch is that of the shortest wave on the mesh: for the folding wing, whose half-elements have a length of
/// 18.75 mm, 0.01 times `2c/l`. Curvatures and hinges have 10 1/s.
#[test]
fn me16_nominal_rates_of_stretch_are_those_of_the_shortest_wave() {
    let table = table(WING, kinds(Version::Fmi2, false, false));
    let nominal =
        |name: &str| table.find(name).and_then(|row| row.nominal).unwrap_or_else(|| panic!("no state {name}"));
    let (speed_m_s, length_m) = (f64::sqrt(2.83e9 / 1425.0), 0.15 / 8.0);
    for (name, expected, allowed) in [
        ("state.inner.element[3].epsilon_x", 1e-2, 1e-15),
        ("state_rate.inner.element[3].epsilon_x", 1e-2 * 2.0 * speed_m_s / length_m, 1e-9),
        ("state_rate.outer.element[8].kappa_y", 10.0, 1e-15),
        ("state.fold.angle", 1.0, 1e-15),
        ("state_rate.fold.angle", 10.0, 1e-15),
    ] {
        let found = nominal(name);
        assert!((found / expected - 1.0).abs() <= allowed, "{name}: {found}, expected {expected}");
    }
}

/// A cantilever without loads; `element` contains the keys of its elements.
fn cantilever(element: &str) -> String {
    format!(
        "name = 'C'\n[section.s]\nshape = 'rectangle'\nwidth_m = 0.05\nheight_m = 0.02\ndensity_kg_m3 = 1425.0\n\
         youngs_modulus_Pa = 2.83e9\nshear_modulus_Pa = 1.0e9\n[body.beam]\nlength_m = 0.6\nsection = 's'\nelements = 2\n{element}\n\
         [joint.wall]\ntype = 'clamped'\nparent = 'root'\nchild = 'beam'\n"
    )
}

/// A machine under the integrator of the test, with a frequency limit in rad/s, or 0 for none.
fn plant(text: &str, limit_rad_s: f64) -> Plant {
    let mut plant = Plant::new(Arc::new(foldwing::config::parse(text, "m").expect("a model")));
    plant.parameters_mut().solver_mut().frequency_limit_rad_s = limit_rad_s;
    plant.initialize(0.0).expect("starts");
    let system = plant.system_mut();
    system.keep_exchange_accounts(false);
    system.begin_exchange().expect("has states");
    system.make_exchange_event().expect("an event");
    system.leave_exchange_event();
    plant
}

/// Accelerations of the coordinates, at rates and lags of zero.
fn accelerations(plant: &mut Plant, coordinates: &[f64]) -> Vec<f64> {
    let system = plant.system_mut();
    let mut states = vec![0.0; system.exchange_state_count()];
    states[..coordinates.len()].copy_from_slice(coordinates);
    system.set_exchange_states(&states);
    system.update_exchange().expect("derivatives");
    system.exchange_derivatives()[coordinates.len()..2 * coordinates.len()].to_vec()
}

/// Squares of the natural frequencies about the straight state, ascending, in rad²/s².
fn squares(plant: &mut Plant) -> Vec<f64> {
    let n = plant.exchange_coordinates().len();
    let mut matrix = DMatrix::zeros(n, n);
    for column in 0..n {
        let step = 1e-7;
        let mut at = |step: f64| {
            let mut q = vec![0.0; n];
            q[column] = step;
            accelerations(plant, &q)
        };
        for (row, (above, below)) in at(step).into_iter().zip(at(-step)).enumerate() {
            matrix[(row, column)] = (below - above) / (2.0 * step);
        }
    }
    let mut squares: Vec<f64> = matrix.complex_eigenvalues().iter().map(|value| value.re).collect();
    squares.sort_by(f64::total_cmp);
    squares
}

/// ME-17. With a limit `ω_c` every natural frequency `ω` of a beam becomes `ω/√(1 + ω²/ω_c²)`, NOTATION (D21): constant and linear
/// elements, with shear, and with damping factors. Tolerance: round-off of the eigenvalues of a matrix whose entries span eight decades.
#[test]
fn me17_a_limit_lowers_frequencies_by_its_formula() {
    let limit_rad_s = 3000.0;
    for element in [
        "element = 'constant'",
        "element = 'linear'",
        "shear = true",
        // so little damping that frequencies change by 1e-8
        "stiffness_damping_s = 1e-9\nstiffness_damping_factors = [1.0, 2.0, 3.0, 4.0]",
    ] {
        let text = cantilever(element);
        let (free, limited) = (squares(&mut plant(&text, 0.0)), squares(&mut plant(&text, limit_rad_s)));
        assert!(free[0] > 0.0 && free[0].sqrt() < 0.1 * limit_rad_s, "{element}: {}", free[0].sqrt());
        assert!(free[free.len() - 1].sqrt() > 3.0 * limit_rad_s, "{element}");
        for (free, limited) in free.iter().zip(&limited) {
            let expected = 1.0 / (1.0 / free + limit_rad_s.powi(-2));
            assert!((limited / expected - 1.0).abs() < 1e-6, "{element}: {} of {} rad/s", limited.sqrt(), free.sqrt());
        }
    }
}

/// ME-18. The limit with aerodynamics, where accelerations and apparent mass are solved for together: with the inertia `M` of structure and
/// air, `(M + K/ω_c²) a = M a₀`, so that the limit reduces the accelerations `a₀` by `M⁻¹K a/ω_c²`, the accelerations due to strains of
/// `a/ω_c²`. In air at rest there are no other forces. Tolerance: that of the iteration for the apparent mass.
#[test]
fn me18_the_limit_holds_in_air() {
    let text = GOLAND.replace("wind_m_s = [0.0, -130.0, 0.0]", "wind_m_s = [0.0, 0.0, 0.0]");
    let text = &text[..text.find("[gust.bump]").expect("a gust at the end")];
    let limit_rad_s = 500.0;
    let (mut free, mut limited) = (plant(text, 0.0), plant(text, limit_rad_s));
    let n = free.exchange_coordinates().len();
    let q: Vec<f64> = (0..n).map(|i| 1e-6 * (1.0 + i as f64).sin()).collect();
    let rest = vec![0.0; n];
    let (of_strains, at_rest) = (accelerations(&mut free, &q), accelerations(&mut free, &rest));
    let found = accelerations(&mut limited, &q);
    let moved: Vec<f64> = found.iter().map(|a| a / (limit_rad_s * limit_rad_s)).collect();
    let taken = accelerations(&mut free, &moved);
    let largest = of_strains.iter().fold(0.0, |max: f64, a| max.max(a.abs()));
    for i in 0..n {
        let expected = of_strains[i] + (taken[i] - at_rest[i]);
        assert!((found[i] - expected).abs() < 1e-5 * largest, "{i}: {} {expected} {}", found[i], of_strains[i]);
    }
    assert!((0..n).any(|i| (found[i] - of_strains[i]).abs() > 0.1 * largest), "the limit acts");
}

/// ME-19. The limit is a fixed parameter for Model Exchange only, in rad/s: a negative value and later changes are rejected, and
/// co-simulation of the same FMU gives the same bits with and without a limit. The parameter is part of a saved state and is reset by
/// `fmi2Reset`.
#[test]
fn me19_the_limit_is_a_parameter_of_model_exchange() {
    let acceleration = |outside: &Outside| {
        let mut derivatives = vec![0.0; outside.states.len()];
        let n = derivatives.len();
        outside.fmu.ok(unsafe { fmi2GetDerivatives(outside.fmu.component, derivatives.as_mut_ptr(), n) });
        derivatives
    };
    let started = |limit_rad_s: f64| {
        let outside = Outside::new(exchanged(WING, false));
        outside.fmu.ok(outside.fmu.try_set("solver.frequency_limit", limit_rad_s));
        outside.in_phase(Phase::Continuous)
    };
    let (free, limited) = (started(0.0), started(2000.0));
    assert_ne!(acceleration(&free), acceleration(&limited));
    let fmu = &limited.fmu;
    fmu.refused(fmu.try_set("solver.frequency_limit", 1000.0), fmi2Error, &["solver.frequency_limit is fixed"]);
    let mut state: fmi2FMUstate = ptr::null_mut();
    let bytes = serialised(fmu);
    unsafe {
        free.fmu.ok(fmi2DeSerializeFMUstate(free.fmu.component, bytes.as_ptr().cast(), bytes.len(), &mut state));
        free.fmu.ok(fmi2SetFMUstate(free.fmu.component, state));
    }
    assert_eq!(acceleration(&free), acceleration(&limited), "restored");
    free.fmu.ok(unsafe { fmi2Reset(free.fmu.component) });
    let again = free.in_phase(Phase::Continuous);
    assert_eq!(acceleration(&again), acceleration(&started(0.0)), "reset");
    again.fmu.ok(unsafe { fmi2Reset(again.fmu.component) });
    again.fmu.refused(
        again.fmu.try_set("solver.frequency_limit", -1.0),
        fmi2Discard,
        &["solver.frequency_limit", "≥ 0 rad/s"],
    );

    let stepped = |limit_rad_s: f64| {
        let fmu = Fmu::of_kind(WING, fmi2CoSimulation);
        fmu.ok(fmu.try_set("solver.frequency_limit", limit_rad_s));
        fmu.setup(0.0, None);
        unsafe {
            fmu.ok(fmi2EnterInitializationMode(fmu.component));
            fmu.ok(fmi2ExitInitializationMode(fmu.component));
            fmu.ok(fmi2DoStep(fmu.component, 0.0, 0.01, fmi2True));
        }
        fmu.get("gauge.root.strain").to_bits()
    };
    assert_eq!(stepped(0.0), stepped(2000.0), "co-simulation");
    let row = table(WING, kinds(Version::Fmi3, true, false));
    let row = row.find("solver.frequency_limit").expect("a row");
    assert_eq!((row.value, row.declared_type), (Value::Real(0.0), Some("AngularVelocity")));
}

/// ME-32. Two rotors with dynamic inflow on a tower, through the C functions: no step allocates memory; a run from a saved state, also from
/// its bytes in another instance and after a reset, has the same bits.
#[test]
fn me32_states_of_rotors_are_whole() {
    const STEP_S: f64 = 5e-5;
    let text = include_str!("../../examples/airs/twin_rotor.toml");
    let mut outside = Outside::started(text);
    outside.run(0.01, STEP_S);
    let before = allocations();
    outside.run(0.02, STEP_S);
    assert_eq!(allocations() - before, 0, "allocations in 200 steps of the importer's");
    let (saved, time_s, states) = (outside.fmu.save(), outside.time_s, outside.states.clone());
    let bytes = outside.fmu.serialize(saved);
    outside.run(0.025, STEP_S);
    let (end, last) = (outside.fmu.bits(), outside.states.clone());
    assert!(last != states);
    let mut elsewhere = Outside::started(text);
    let (status, handle) = elsewhere.fmu.deserialize(&bytes);
    elsewhere.fmu.ok(status);
    elsewhere.fmu.ok(unsafe { fmi2SetFMUstate(elsewhere.fmu.component, handle) });
    outside.fmu.ok(unsafe { fmi2SetFMUstate(outside.fmu.component, saved) });
    for again in [&mut outside, &mut elsewhere] {
        again.read();
        assert_eq!(again.states, states);
        again.time_s = time_s;
        again.run(0.025, STEP_S);
        assert_eq!(again.states, last);
        assert_eq!(again.fmu.bits(), end);
    }
    let rows = outside.fmu.table.variables().iter();
    let lags: Vec<(&str, Option<&str>)> = rows
        .filter(|row| row.nominal.is_some() && row.name.contains(".station["))
        .map(|row| (row.name.as_str(), row.declared_type))
        .collect();
    assert!(lags.contains(&("state.port_blade1.station[3].induced_axial", Some("Velocity"))), "{lags:?}");
}

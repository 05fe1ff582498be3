//! Rotors under an external integrator: `Plant::hybrid` and Model Exchange, NOTATION eq. (W24).

use crate::counting_allocator::allocations;
use crate::plant::hybrid::Outside;
use crate::rotor::order::model;
use crate::rotor::polar;
use crate::rotor::several::{PROPELLERS, TWIN, machine};
use crate::turbine::machine::{WIND_TEXT, with_polars};
use foldwing::aero::rotor::dynamic_stall::{SplitPolar, StallInflow, StallState};
use foldwing::interface::Interface;
use foldwing::plant::{Holding, OutputSet, Outputs, Plant};
use nalgebra::DVector;
use std::sync::Arc;

/// Both lags, and the wake skewed by the wind from the side.
const BOTH: &str = "dynamic_inflow = true\ndynamic_stall = true\nskewed_wake = true\n";

fn initialised(text: &str) -> Plant {
    let mut plant = Plant::new(Arc::new(machine(text)));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Values that `read` takes from the outputs at the end of a run with `steps_s` as aerodynamic steps and, first, of an integration from outside
/// by the Runge–Kutta rule with `own_step_s`; all from the start, or from other states.
fn ends(
    text: &dyn Fn(f64) -> String,
    steps_s: &[f64],
    (end_s, own_step_s): (f64, f64),
    from: Option<&[f64]>,
    read: &dyn Fn(&Outputs) -> Vec<f64>,
) -> Vec<DVector<f64>> {
    let begun = |step_s: f64| {
        let mut plant = initialised(&text(step_s));
        if let Some(states) = from {
            let mut hybrid = plant.hybrid().expect("no lattice");
            hybrid.set(0.0, states);
            hybrid.derivatives(&mut vec![0.0; states.len()]).unwrap_or_else(|error| panic!("{error}"));
            hybrid.complete();
        }
        plant
    };
    let mut plant = begun(steps_s[0]);
    let mut outside = Outside::of(plant.hybrid().expect("no lattice"));
    outside.run(end_s, own_step_s);
    let mut found = vec![DVector::from_vec(read(outside.system.outputs()))];
    for step_s in steps_s {
        let mut plant = begun(*step_s);
        plant.step(end_s).unwrap_or_else(|error| panic!("{error}"));
        found.push(DVector::from_vec(read(plant.outputs())));
    }
    found
}

/// Differences of co-simulation from the integration from outside, all values together, each relative to its magnitude; then their orders
/// in the step, which is halved.
fn apart(name: &str, ends: &[DVector<f64>]) -> (Vec<f64>, Vec<f64>) {
    let size = ends[0].map(|value| value.abs().max(1e-3));
    let misses: Vec<f64> = ends[1..].iter().map(|end| (end - &ends[0]).component_div(&size).norm()).collect();
    let orders: Vec<f64> = misses.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    let shown: Vec<String> = misses.iter().map(|miss| format!("{miss:.2e}")).collect();
    println!("{name}: {:.5?}, apart {}, orders {orders:.3?}", ends[0].as_slice(), shown.join(" "));
    (misses, orders)
}

/// Flap angle, shaft speed, thrust and torque.
fn of_blade(outputs: &Outputs) -> Vec<f64> {
    let (rotor, joints) = (outputs.rotor()[0], outputs.joints());
    vec![joints[1].angle_rad, joints[0].rate_rad_s, rotor.thrust_n, rotor.torque_n_m]
}

/// ME-24. A rotor of rigid blades, accelerated by a wind from the side, with each lag and all of them, from a steady and an impulsive start:
/// co-simulation converges in second order in the aerodynamic step to an integration from outside.
#[test]
fn me24_steps_tend_to_the_rotor_of_the_instant() {
    let sets_in = format!("{BOTH}steady_initial_flow = false\n");
    let cases = [
        "",
        "dynamic_inflow = true\nsteady_initial_flow = false\n",
        "dynamic_stall = true\n",
        "inflow_lag_s = 0.15\npitch_rate = \"hub\"\nsteady_initial_flow = false\n",
        BOTH,
        &sets_in,
    ];
    for air in cases {
        let found = ends(&|step_s| model(air, step_s), &[4e-3, 2e-3, 1e-3], (0.32, 1e-3), None, &of_blade);
        let (misses, orders) = apart(&format!("ME-24 {air:?}"), &found);
        assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15), "{air}: {orders:?}");
        assert!(misses[2] < 1e-3, "{air}: {misses:?}");
    }
}

/// ME-25. Flexible blades: two rotors of beams on one tower with wind shear, one of them with dynamic stall, and a wing with strips beside
/// two propellers. All models share one response.
#[test]
fn me25_several_models_with_flexible_blades() {
    let twin = |step_s: f64| {
        let stall = TWIN.replacen("dynamic_inflow = true", "dynamic_inflow = true\ndynamic_stall = true", 1);
        stall.replacen("step_s = 0.01", &format!("step_s = {step_s:?}"), 1)
    };
    let of_twin = |outputs: &Outputs| {
        let [one, other] = [0, 1].map(|rotor| outputs.rotor()[rotor]);
        vec![one.thrust_n, one.torque_n_m, other.thrust_n, other.speed_rad_s, outputs.tips()[0].position_m.x]
    };
    let found = ends(&twin, &[4e-3, 2e-3, 1e-3], (0.2, 5e-5), None, &of_twin);
    let (misses, orders) = apart("ME-25 two rotors", &found);
    assert!(misses[2] < 1e-3 && orders.iter().all(|order| (order - 2.0).abs() < 0.3), "{misses:?} {orders:?}");
    let wing = |step_s: f64| {
        let line = PROPELLERS.lines().find(|line| line.starts_with("step_s")).expect("a step");
        // an explicit rule resolves the damping of the fastest waves too
        let soft = PROPELLERS.replace("stiffness_damping_s = 0.001", "stiffness_damping_s = 1e-5");
        soft.replacen(line, &format!("step_s = {step_s:?}"), 1) + "\n[solver]\ntolerance = 1e-9\n"
    };
    let of_wing = |outputs: &Outputs| {
        let [one, other] = [0, 1].map(|rotor| outputs.rotor()[rotor]);
        vec![one.thrust_n, other.torque_n_m, other.speed_rad_s, outputs.tips()[0].position_m.z]
    };
    let found = ends(&wing, &[2e-3, 1e-3, 5e-4, 2.5e-4], (0.04, 1e-5), None, &of_wing);
    let (misses, orders) = apart("ME-25 propellers", &found);
    assert!(misses[2] < 1e-3 && orders.iter().all(|order| *order > 0.8), "{misses:?} {orders:?}");
}

/// ME-26. The shipped turbine, as shipped and with dynamic inflow and dynamic stall: speed, thrust, torque and induction of the rotor, tips.
/// Second order over half a second from its motion after 20 s; over a second from the start, in which annuli jump, differences below
/// 2e-4.
#[test]
fn me26_the_shipped_turbine() {
    let read = |outputs: &Outputs| {
        let rotor = outputs.rotor()[0];
        let mut values = vec![rotor.speed_rad_s, rotor.thrust_n, rotor.torque_n_m, rotor.induction];
        values.extend(outputs.tips().iter().take(2).flat_map(|tip| tip.position_m.iter().copied()));
        values
    };
    for air in ["", "dynamic_inflow = true\ndynamic_stall = true\n"] {
        let text = |step_s: f64| {
            let text = WIND_TEXT.replacen("step_s = 0.02", &format!("step_s = {step_s:?}"), 1);
            let text = text.replacen("tolerance = 1e-6", "tolerance = 1e-9", 1);
            with_polars(&text.replacen("hub = \"hub\"\n", &format!("hub = \"hub\"\n{air}"), 1))
        };
        let mut plant = initialised(&text(0.02));
        plant.step(20.0).unwrap_or_else(|error| panic!("{error}"));
        let hybrid = plant.hybrid().expect("no lattice");
        let mut states = vec![0.0; hybrid.states()];
        hybrid.read(&mut states);
        let found = ends(&text, &[2e-2, 1e-2, 5e-3, 2.5e-3], (0.5, 1e-3), Some(&states), &read);
        let (misses, orders) = apart(&format!("ME-26 {air:?} moving"), &found);
        assert!(misses[3] < 1e-6 && orders.iter().all(|order| (order - 2.0).abs() < 0.3), "{misses:?} {orders:?}");
        let found = ends(&text, &[1e-2, 5e-3, 2.5e-3, 1.25e-3], (1.0, 5e-4), None, &read);
        let (misses, _) = apart(&format!("ME-26 {air:?} from the start"), &found);
        assert!(misses[3] < 2e-4 && misses[3] < 0.1 * misses[0], "{misses:?}");
    }
}

/// The rotor with a locked shaft in a static equilibrium.
fn parked(air: &str) -> Plant {
    let text = model(air, 2e-3).replacen("start_rate_deg_s = 500.0", "motion = \"locked\"", 1);
    let mut plant = Plant::new(Arc::new(machine(&text)));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// ME-27. In a static equilibrium the states of an external integrator are those of the linear model, with the same names, units and
/// order, and none of them moves.
#[test]
fn me27_states_at_rest_are_those_of_the_linear_model() {
    for air in ["", BOTH, "inflow_lag_s = 0.15\n"] {
        let mut plant = parked(air);
        let interface = Interface::new(plant.machine());
        let linear = interface.linearize(&mut plant, &[], &[]).unwrap_or_else(|error| panic!("{error}"));
        let (names, units) = (plant.exchange_lags(), plant.exchange_lag_units());
        let mut hybrid = plant.hybrid().expect("no lattice");
        let mut states = vec![0.0; hybrid.states()];
        hybrid.read(&mut states);
        assert_eq!(states.len(), linear.states.len());
        let lags = states.len() - names.len();
        let mut slope = states.clone();
        hybrid.set(0.0, &states);
        hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
        let (mut off, mut moves) = (0.0_f64, 0.0_f64);
        for (place, state) in linear.states.iter().enumerate().skip(lags) {
            assert_eq!((&state.name, state.unit.as_str()), (&names[place - lags], units[place - lags]));
            off = off.max((state.value - states[place]).abs());
            moves = moves.max(slope[place].abs());
        }
        let accelerations = slope[..lags].iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
        println!("ME-27 {air:?}: {} lags, off {off:.1e}, rates {moves:.1e}, {accelerations:.1e}", names.len());
        // values in m/s, rad and of coefficients; the equilibrium is found to 1e-8 in the kinematic norm
        assert!(off < 1e-12 && moves < 1e-6 && accelerations < 1e-5, "{air}");
        // the Jacobian, except at separated sections, where the square root of the attachment has none
        let mut worst = 0.0_f64;
        for (column, state) in linear.states.iter().enumerate() {
            if state.name.ends_with(".attachment") && state.value < 1e-3 {
                continue;
            }
            let step = 1e-6;
            let [above, below] = [step, -step].map(|step| {
                let mut moved = states.clone();
                moved[column] += step;
                hybrid.set(0.0, &moved);
                let mut slope = vec![0.0; states.len()];
                hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
                slope
            });
            for row in 0..states.len() {
                let entry = linear.matrices.a[(row, column)];
                let size = linear.matrices.a.row(row).amax().max(1e-9);
                worst = worst.max(((above[row] - below[row]) / (2.0 * step) - entry).abs() / size);
            }
        }
        println!("ME-27 {air:?}: Jacobian off by {worst:.1e} of the largest entry of a row");
        assert!(worst < 1e-6, "{air}");
    }
}

/// ME-28. Derivatives allocate nothing, with turbulence, a tower and every lag. A saved state continues with the same bits, and steps of
/// co-simulation continue from states that were set.
#[test]
fn me28_derivatives_allocate_nothing_and_states_are_whole() {
    for text in [model(BOTH, 2e-3), PROPELLERS.to_owned(), with_polars(WIND_TEXT)] {
        let mut plant = initialised(&text);
        plant.step(0.02).unwrap_or_else(|error| panic!("{error}"));
        let snapshot = plant.snapshot();
        let mut hybrid = plant.hybrid().expect("no lattice");
        let (mut states, mut slope) = (vec![0.0; hybrid.states()], vec![0.0; hybrid.states()]);
        hybrid.read(&mut states);
        let time_s = hybrid.time_s();
        let mut switches = vec![0.0; hybrid.switches()];
        let mut evaluate = |shift: f64| {
            states.iter_mut().for_each(|state| *state += shift);
            hybrid.set(time_s, &states);
            hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
            hybrid.read_switches(&mut switches);
        };
        evaluate(1e-7);
        let before = allocations();
        assert!(before > 0, "the counter counts");
        (0..5).for_each(|_| evaluate(1e-7));
        assert_eq!(allocations(), before);
        // from a saved state, in another plant
        let last = slope.clone();
        let mut other = Plant::new(Arc::new(plant.machine().clone()));
        other.restore(&snapshot).unwrap_or_else(|error| panic!("{error}"));
        let mut hybrid = other.hybrid().expect("no lattice");
        hybrid.set(time_s, &states);
        hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(slope, last);
        hybrid.complete();
        let mut read = states.clone();
        hybrid.read(&mut read);
        assert_eq!(read, states);
    }
    // states that were set are those of the machine before any derivative has been evaluated
    let mut plant = initialised(&model(BOTH, 2e-3));
    let mut hybrid = plant.hybrid().expect("no lattice");
    let mut states = vec![0.0; hybrid.states()];
    hybrid.read(&mut states);
    states.iter_mut().enumerate().for_each(|(place, state)| *state += 1e-3 * (place as f64).sin());
    hybrid.set(0.0, &states);
    let mut read = states.clone();
    plant.hybrid().expect("no lattice").read(&mut read);
    let off = states.iter().zip(&read).map(|(set, read)| (set - read).abs()).fold(0.0, f64::max);
    println!("ME-28 states set and read: {off:.1e}");
    // the direct fraction of the balance is added and subtracted
    assert!(off < 1e-14);
    // the induced velocity that was set decays with its time constant in the steps that follow
    let mut plant = initialised(&model("inflow_lag_s = 0.15\n", 1e-3));
    let names = plant.exchange_lags();
    let mut hybrid = plant.hybrid().expect("no lattice");
    let (mut states, mut slope) = (vec![0.0; hybrid.states()], vec![0.0; hybrid.states()]);
    hybrid.read(&mut states);
    let (lag, set_m_s) = (states.len() - names.len() + 2, 3.0);
    states[lag] += set_m_s;
    hybrid.set(0.0, &states);
    hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
    hybrid.complete();
    plant.step(1e-3).unwrap_or_else(|error| panic!("{error}"));
    let hybrid = plant.hybrid().expect("no lattice");
    let mut after = states.clone();
    hybrid.read(&mut after);
    let due_m_s = states[lag] + 1e-3 * slope[lag];
    println!("ME-28 {}: {:.6} of {due_m_s:.6} m/s, set {:.6}", names[2], after[lag], states[lag]);
    assert!((after[lag] - due_m_s).abs() < 2e-2 * (states[lag] - due_m_s).abs());
}

/// The rotor with blades at a flat pitch, which load the annuli up to the propeller-brake state in little wind.
fn loaded(air: &str) -> Plant {
    let text = model(air, 2e-3).replacen("[14.0, 3.0, 0.0]", "[4.0, 0.0, 0.0]", 1);
    initialised(&text.replacen("[[0.0, -15.0], [4.0, -1.0]]", "[[0.0, 3.0], [4.0, 3.0]]", 1))
}

/// ME-29. Annuli pass between windmill and propeller-brake state while the wind falls: the indicator changes its sign where thrust jumps in
/// steady inflow. With dynamic inflow there are no indicators: loads are continuous there, and rates of lag states jump.
#[test]
fn me29_indicators_fall_through_zero_at_jumps_of_the_balance() {
    // signs of the indicators, thrust in N, and rates of the states, at the start in a wind
    let at = |plant: &mut Plant, wind_m_s: f64| {
        let mut hybrid = plant.hybrid().expect("no lattice");
        let mut states = vec![0.0; hybrid.states()];
        hybrid.read(&mut states);
        hybrid.system_mut().inputs_mut().wind_m_s_mut().x = wind_m_s;
        hybrid.follow_inputs();
        hybrid.set(0.0, &states);
        let mut slope = states;
        hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{error}"));
        let mut switches = vec![0.0; hybrid.switches()];
        hybrid.read_switches(&mut switches);
        let signs: Vec<bool> = switches.iter().map(|switch| *switch > 0.0).collect();
        (signs, hybrid.outputs().rotor()[0].thrust_n, DVector::from_vec(slope))
    };
    let mut steady = loaded("");
    let (mut jumps, mut smooth_n, mut wind_m_s) = (Vec::new(), 0.0_f64, 20.0);
    let mut before = at(&mut steady, wind_m_s);
    while wind_m_s > 0.05 {
        wind_m_s -= 0.05;
        let here = at(&mut steady, wind_m_s);
        if here.0 == before.0 {
            smooth_n = smooth_n.max((here.1 - before.1).abs());
        } else {
            let (mut low, mut high) = (wind_m_s, wind_m_s + 0.05);
            while high - low > 1e-9 {
                let middle = 0.5 * (low + high);
                if at(&mut steady, middle).0 == before.0 { high = middle } else { low = middle }
            }
            let jump_n = (at(&mut steady, high).1 - at(&mut steady, low).1).abs();
            jumps.push((low, high, jump_n));
        }
        before = here;
    }
    println!("ME-29: jumps {jumps:?}, changes over 0.05 m/s between them up to {smooth_n:.1} N");
    assert!(jumps.len() == 3 && jumps.iter().all(|(.., jump_n)| *jump_n > 10.0), "{jumps:?}");
    let mut lagged = loaded("dynamic_inflow = true\n");
    assert_eq!(lagged.hybrid().expect("no lattice").switches(), 0);
    for (low, high, _) in jumps {
        let [below, above] = [low, high].map(|wind_m_s| at(&mut lagged, wind_m_s));
        let rates = (&above.2 - &below.2).amax();
        println!("ME-29 dynamic inflow: thrust {:.1e} N, rates {rates:.2}", (above.1 - below.1).abs());
        assert!((above.1 - below.1).abs() < 1e-5 && rates > 0.1, "at {low} m/s");
    }
}

/// ME-30. Directional derivatives of Model Exchange: thrust by wind next to a jump, against a difference of thrusts in the engine; across
/// the jump they are refused with the station.
#[test]
fn me30_no_derivative_across_a_jump() {
    let mut plant = loaded("");
    let interface = Interface::with_states(plant.machine(), &plant);
    let reference = |name: &str| {
        let row = interface.variables().iter().find(|row| row.name == name);
        row.unwrap_or_else(|| panic!("no {name}")).value_reference
    };
    let (thrust, wind) = (reference("rotor.thrust"), reference("wind.velocity.x"));
    let system = plant.system_mut();
    system.begin_exchange().unwrap_or_else(|error| panic!("{error}"));
    system.make_exchange_event().unwrap_or_else(|error| panic!("{error}"));
    system.leave_exchange_event();
    let thrust_n = |plant: &mut Plant, wind_m_s: f64| {
        plant.inputs_mut().wind_m_s_mut().x = wind_m_s;
        plant.system_mut().exchange_inputs_set();
        plant.system_mut().update_exchange().unwrap_or_else(|error| panic!("{error}"));
        plant.provide(OutputSet::ALL);
        (plant.system_mut().exchange_flows(), plant.outputs().rotor()[0].thrust_n)
    };
    // the first jump from high winds
    let (mut low, mut high) = (2.4, 2.6);
    let above = thrust_n(&mut plant, high).0;
    assert!(thrust_n(&mut plant, low).0 != above, "a jump between");
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        if thrust_n(&mut plant, middle).0 == above { high = middle } else { low = middle }
    }
    let slope = |plant: &mut Plant, wind_m_s: f64| {
        thrust_n(plant, wind_m_s);
        let mut value = [0.0];
        let told = interface.exchange_directional_derivative(plant, (&[thrust], &mut value), (&[wind], &[1.0]));
        told.map(|()| value[0]).map_err(|error| error.to_string())
    };
    for wind_m_s in [high + 2e-3, low - 2e-3] {
        let found = slope(&mut plant, wind_m_s).unwrap_or_else(|error| panic!("{error}"));
        let [more, less] = [1e-5, -1e-5].map(|change| thrust_n(&mut plant, wind_m_s + change).1);
        let due = (more - less) / 2e-5;
        println!("ME-30 {found:.4} of {due:.4} N s/m at {wind_m_s:.4} m/s");
        assert!((found - due).abs() < 1e-3 * due.abs(), "{found} for {due}");
    }
    let told = slope(&mut plant, low).expect_err("no derivative");
    println!("ME-30 {told}");
    assert!(told.contains("the momentum balance of blade.station[") && told.contains("is discontinuous"), "{told}");
}

/// Largest relative error of the directional derivative of an output by a component of the wind at some winds in m/s, against differences over
/// 1e-5 m/s in the engine, and the number of winds within 0.01 m/s of a row of a polar.
fn beside_rows(
    plant: &mut Plant,
    [output, wind]: [&str; 2],
    component: usize,
    winds_m_s: impl Iterator<Item = f64>,
    read: fn(&Outputs) -> f64,
) -> (f64, usize) {
    let interface = Interface::with_states(plant.machine(), plant);
    let [output, wind] = [output, wind].map(|name| {
        let row = interface.variables().iter().find(|row| row.name == name);
        row.unwrap_or_else(|| panic!("no {name}")).value_reference
    });
    let system = plant.system_mut();
    system.begin_exchange().unwrap_or_else(|error| panic!("{error}"));
    system.make_exchange_event().unwrap_or_else(|error| panic!("{error}"));
    system.leave_exchange_event();
    let value = |plant: &mut Plant, wind_m_s: f64| {
        plant.inputs_mut().wind_m_s_mut()[component] = wind_m_s;
        plant.system_mut().exchange_inputs_set();
        plant.system_mut().update_exchange().unwrap_or_else(|error| panic!("{error}"));
        plant.provide(OutputSet::ALL);
        read(plant.outputs())
    };
    let (mut worst, mut passed) = (0.0_f64, 0);
    for wind_m_s in winds_m_s {
        let [wide, close] = [1e-2, 1e-5].map(|change| {
            let [more, less] = [change, -change].map(|change| value(plant, wind_m_s + change));
            (more - less) / (2.0 * change)
        });
        passed += usize::from((wide / close - 1.0).abs() > 1e-4);
        value(plant, wind_m_s);
        let mut found = [0.0];
        interface
            .exchange_directional_derivative(plant, (&[output], &mut found), (&[wind], &[1.0]))
            .unwrap_or_else(|error| panic!("{error}"));
        worst = worst.max((found[0] / close - 1.0).abs());
    }
    (worst, passed)
}

/// ME-34. Directional derivatives next to rows of polars, which the first steps of the differences pass: thrust by wind at 200 winds,
/// against differences over 1e-5 m/s in the engine.
#[test]
fn me34_derivatives_next_to_rows_of_polars() {
    let winds_m_s = (0..200_u32).map(|number| 8.0 + 0.0301 * f64::from(number));
    let names = ["rotor.thrust", "wind.velocity.x"];
    let (worst, passed) = beside_rows(&mut loaded(""), names, 0, winds_m_s, |outputs| outputs.rotor()[0].thrust_n);
    println!("ME-34: {worst:.1e}; {passed} of 200 within 0.01 m/s of a row");
    assert!(passed > 20 && worst < 1e-5, "{worst:e}, {passed}");
}

/// ME-35. The same for two wings in strips, one with a polar and one without: moment at the root by vertical wind.
#[test]
fn me35_derivatives_next_to_rows_of_one_of_two_wings() {
    let wing = |name: &str, turn_deg: f64, edge: &str, polar: &str| {
        format!(
            "[body.{name}]\nlength_m = 0.5\nsection = 'wing'\nelements = 1\n[joint.{name}]\ntype = 'clamped'\nparent = 'root'\n\
             child = '{name}'\nmount_rotation_deg = [0.0, 0.0, {turn_deg:?}]\n[surface.{name}]\nbody = '{name}'\n\
             leading_edge = '{edge}'\nchord_m = 0.2\nstrips = 2\nincidence_deg = 4.0\n{polar}\n"
        )
    };
    let polar = "polar = [[-180.0, 0.0, 0.0, 0.0], [-10.0, -0.9, 0.05, 0.0], [0.0, 0.1, 0.01, 0.0], [2.0, 0.5, 0.011, 0.0], \
                 [5.0, 0.6, 0.02, 0.01], [9.0, 1.4, 0.03, 0.0], [180.0, 0.0, 0.0, 0.0]]";
    let text = format!(
        "name = 'wings'\n[section.wing]\nshape = 'rectangle'\nwidth_m = 0.1\nheight_m = 0.02\nmaterial = 'aluminium 7075-T6'\n\
         {}{}[aerodynamics]\nmodel = 'strip'\nquasi_steady = true\ndensity_kg_m3 = 1.2\nwind_m_s = [20.0, 0.0, 0.0]\n",
        wing("left", 90.0, "+y", polar),
        wing("right", -90.0, "-y", "")
    );
    let winds_m_s = (0..200_u32).map(|number| -0.9 + 0.0067 * f64::from(number));
    let names = ["root.moment.x", "wind.velocity.z"];
    let read = |outputs: &Outputs| outputs.root().moment_n_m.x;
    let (worst, passed) = beside_rows(&mut initialised(&text), names, 2, winds_m_s, read);
    println!("ME-35: {worst:.1e}; {passed} of 200 within 0.01 m/s of a row");
    assert!(passed > 4 && worst < 1e-5, "{worst:e}, {passed}");
}

/// ME-31. Rates of dynamic stall are the limit of short steps at any angle of attack, across 180° too, where derivatives unwrap the angle;
/// coefficients are finite and continuous for a degree of attachment that an integrator sets below 0.
#[test]
fn me31_rates_of_dynamic_stall_are_the_limit_of_steps() {
    let split = SplitPolar::new(polar("naca64_a17")).expect("it lifts");
    let (mut worst, mut turned) = (0.0_f64, 0);
    for number in 0..200_u32 {
        let angle = |factor: f64| 3.1 * (factor * f64::from(number)).sin();
        let at = |attack_rad: f64| StallInflow { speed_m_s: 40.0, attack_rad, pitch_rate_rad_s: 0.3, chord_m: 1.5 };
        let (before, met) = (StallState::steady(at(angle(1.7)), &split), at(angle(2.9)));
        // the inflow jumps, then stays
        let state = StallState { met, ..before };
        let step_s = 1e-7;
        let next = state.after(met, step_s, &split);
        let steps = [
            next.wake_rad[0] - state.wake_rad[0],
            next.wake_rad[1] - state.wake_rad[1],
            next.lagged_lift - state.lagged_lift,
            next.attached - state.attached,
        ];
        let [rates, unwrapped] = [false, true].map(|unwrapped| state.rates_1_s(&split, unwrapped));
        let size = 1.0 + rates.iter().fold(0.0, |most: f64, rate| most.max(rate.abs()));
        for (step, rate) in steps.iter().zip(rates) {
            worst = worst.max((step / step_s - rate).abs() / size);
        }
        turned += usize::from(rates[0] != unwrapped[0]);
    }
    println!("ME-31: off by {worst:.1e} of the rates, {turned} of 200 across 180 degrees");
    // round-off of the step over its length, and its square
    assert!(worst < 1e-4 && turned > 20, "{worst:e} {turned}");
    let state = StallState::steady(
        StallInflow { speed_m_s: 40.0, attack_rad: 0.5, pitch_rate_rad_s: 0.0, chord_m: 1.5 },
        &split,
    );
    let drag = |attached: f64| StallState { attached, ..state }.coefficients(&split).drag;
    assert!((drag(-1e-9) - drag(0.0)).abs() < 1e-8 && (drag(1e-9) - drag(0.0)).abs() < 1e-4);
}

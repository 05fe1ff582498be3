//! The machine as a hybrid system under an external integrator: classical Runge–Kutta with fixed steps, events located by the indicators,
//! and transitions applied at them.

use crate::agreement::agree;
use crate::whole::is_whole;
use foldwing::machine::Machine;
use foldwing::plant::{AccountRates, Holding, Hybrid, Jump, NotHybrid, Plant};
use std::sync::Arc;

fn machine(text: &str) -> Machine {
    foldwing::config::parse(text, "model.toml").expect("a model that is accepted")
}

/// Integrates with steps of `step_s`, using only [`Hybrid`].
pub struct Outside<'a> {
    pub system: Hybrid<'a>,
    pub states: Vec<f64>,
    /// Work of the inputs and dissipated energy, J.
    accounts: [f64; 2],
    /// Times of events in s, with their energy terms.
    events: Vec<(f64, Jump)>,
    /// Whether jumps of the balance of annuli are located.
    pub locates: bool,
    /// Number of jumps that have been located.
    pub jumps: usize,
}

/// Index of an event that is the jump of an annulus.
const ANNULUS: usize = usize::MAX;

impl<'a> Outside<'a> {
    pub fn of(system: Hybrid<'a>) -> Self {
        let mut states = vec![0.0; system.states()];
        system.read(&mut states);
        Self { system, states, accounts: [0.0; 2], events: Vec::new(), locates: false, jumps: 0 }
    }

    pub fn slope(&mut self, time_s: f64, states: &[f64]) -> (Vec<f64>, AccountRates) {
        let mut slope = vec![0.0; states.len()];
        self.system.set(time_s, states);
        let rates = self.system.derivatives(&mut slope).expect("derivatives");
        (slope, rates)
    }

    /// States and energy terms after a step.
    fn tried(&mut self, step_s: f64) -> (Vec<f64>, [f64; 2]) {
        let (begin_s, begin) = (self.system.time_s(), self.states.clone());
        let (mut end, mut accounts) = (begin.clone(), self.accounts);
        let mut last = (vec![0.0; begin.len()], AccountRates::default());
        for (place, weight) in [(0.0, 1.0), (0.5, 2.0), (0.5, 2.0), (1.0, 1.0)] {
            let at: Vec<f64> = begin.iter().zip(&last.0).map(|(x, slope)| x + place * step_s * slope).collect();
            last = self.slope(begin_s + place * step_s, &at);
            let share_s = weight / 6.0 * step_s;
            end.iter_mut().zip(&last.0).for_each(|(x, slope)| *x += share_s * slope);
            accounts[0] += share_s * last.1.work_w;
            accounts[1] += share_s * last.1.dissipated_w;
        }
        self.system.set(begin_s, &begin);
        (end, accounts)
    }

    /// Indices of the indicators of forces that are crossed, and [`ANNULUS`] if the flow through annuli is other than `before`.
    fn crossed_at(&mut self, time_s: f64, states: &[f64], before: &[bool]) -> Vec<usize> {
        let mut values = vec![1.0; self.system.indicators()];
        self.system.set(time_s, states);
        self.system.read_indicators(&mut values);
        let mut crossed: Vec<usize> = (0..values.len()).filter(|&i| values[i] <= 0.0).collect();
        if self.locates && self.flows_at(time_s, states) != before {
            crossed.push(ANNULUS);
        }
        crossed
    }

    /// Directions of the flow through the annuli.
    fn flows_at(&mut self, time_s: f64, states: &[f64]) -> Vec<bool> {
        let mut values = vec![1.0; self.system.switches()];
        self.slope(time_s, states);
        self.system.read_switches(&mut values);
        values.iter().map(|value| *value > 0.0).collect()
    }

    /// Integrates to `end_s`, with steps of at most `step_s`, through events and kinks.
    pub fn run(&mut self, end_s: f64, step_s: f64) {
        while self.system.time_s() < end_s - 1e-12 {
            let begin_s = self.system.time_s();
            let kink_s = self.system.next_kink_s();
            let stop_s = (begin_s + step_s).min(end_s).min(kink_s);
            let (mut end, mut accounts) = self.tried(stop_s - begin_s);
            let mut arrived_s = stop_s;
            let begin = self.states.clone();
            let flows = if self.locates { self.flows_at(begin_s, &begin) } else { Vec::new() };
            let mut events = self.crossed_at(stop_s, &end, &flows);
            if !events.is_empty() {
                let (mut low_s, mut high_s) = (begin_s, stop_s);
                while high_s - low_s > 1e-12 {
                    let middle_s = 0.5 * (low_s + high_s);
                    self.system.set(begin_s, &begin);
                    let tried = self.tried(middle_s - begin_s);
                    let found = self.crossed_at(middle_s, &tried.0, &flows);
                    if found.is_empty() {
                        low_s = middle_s;
                    } else {
                        (high_s, events, (end, accounts), arrived_s) = (middle_s, found, tried, middle_s);
                    }
                }
            }
            (self.states, self.accounts) = (end, accounts);
            let states = self.states.clone();
            self.slope(arrived_s, &states);
            self.jumps += usize::from(events.contains(&ANNULUS));
            events.retain(|event| *event != ANNULUS);
            if events.is_empty() && arrived_s < kink_s {
                self.system.complete();
            } else {
                let jump = self.system.transition(&events).expect("a transition");
                self.accounts[0] += jump.work_j;
                self.accounts[1] += jump.dissipated_j;
                self.events.push((arrived_s, jump));
            }
            self.system.read(&mut self.states);
        }
        let states = self.states.clone();
        self.slope(end_s, &states);
    }
}

/// The folding wing in wind with strips, for an aerodynamic step in s.
fn folding_wing_in_air(step_s: f64) -> String {
    let wing = include_str!("../../../examples/models/folding_wing.toml");
    let air = format!(
        "[aerodynamics]\nmodel = \"strip\"\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -1.0, 0.0]\nstep_s = {step_s:e}\n\n\
         [surface.inner]\nbody = \"inner\"\nstrips = 4\n\n[surface.outer]\nbody = \"outer\"\nstrips = 4\n"
    );
    wing.replacen("[simulation]", &(air + "\n[simulation]"), 1)
}

/// HY-02. With strip theory, with lag and apparent mass: the result of co-simulation with aerodynamic steps converges, in second order, to
/// that of an external integrator with instantaneous loads: the tip of Goland's wing in a gust. The folding wing unfolds in the same way:
/// the difference at 0.5 ms is 5e-7 s of the latch time, close to the tolerance of the structural steps.
#[test]
#[ignore = "long; `make long` runs it"]
fn hy02_strips_tend_to_the_air_of_the_instant() {
    let goland = |step_s: f64| {
        let text = include_str!("../../../examples/models/goland_wing.toml");
        text.replacen("step_s = 2e-3", &format!("step_s = {step_s:e}"), 1)
    };
    let tip_m = |plant: &Plant| plant.outputs().tips()[0].position_m.z;
    let latch_s = |plant: &Plant| plant.outputs().latches()[0].time_s;
    type Case<'a> = (&'a str, &'a dyn Fn(f64) -> String, [f64; 2], f64, f64, &'a dyn Fn(&Plant) -> f64, Option<f64>);
    let cases: [Case; 2] = [
        ("tip of Goland's wing, m", &goland, [1e-3, 5e-4], 0.3, 5e-5, &tip_m, None),
        ("latch of the folding wing, s", &folding_wing_in_air, [1e-3, 5e-4], 0.14, 4e-6, &latch_s, Some(1e-6)),
    ];
    for (name, text, steps_s, end_s, own_step_s, read, near) in cases.into_iter().take(if is_whole() { 2 } else { 1 }) {
        let stepped = |step_s: f64| {
            let mut plant = Plant::new(Arc::new(machine(&text(step_s))));
            plant.parameters_mut().solver_mut().tolerance = 1e-9;
            plant.initialize(0.0).expect("initialises");
            plant.step(end_s).expect("steps");
            read(&plant)
        };
        let mut plant = Plant::new(Arc::new(machine(&text(steps_s[0]))));
        plant.initialize(0.0).expect("initialises");
        let mut outside = Outside::of(plant.hybrid().expect("strips"));
        outside.run(end_s, own_step_s);
        outside.system.outputs();
        let instant = read(&plant);
        let [coarse, fine] = steps_s.map(|step_s| stepped(step_s) - instant);
        let order = (coarse / fine).log2();
        // Richardson extrapolation: the remaining error is of higher order
        let left = fine - (coarse - fine) / 3.0;
        println!("HY-02 {name}: {instant}, steps {coarse:e} {fine:e}, order {order:.2}, extrapolated {left:e}");
        if let Some(near) = near {
            assert!(fine.abs() < near && fine.abs() < 0.7 * coarse.abs(), "{name}: {coarse:e}, {fine:e}");
            continue;
        }
        assert!((order - 2.0).abs() < 0.15, "{name}: order {order}");
        // an order of 2 ± 0.1 leaves 2 % of the coarser difference
        assert!(left.abs() < 0.03 * coarse.abs(), "{name}: {left:e}");
    }
}

/// HY-03. Derivatives with strip theory compared with the linear model, which computes lag, apparent mass and aerodynamic stiffness
/// independently: the whole Jacobian about an equilibrium in upward wind, relative to the largest entry of each row. Central differences of
/// 1e-4 rad leave 1e-8 of third-order terms, and 1e-12 of round-off over the step.
#[test]
fn hy03_derivatives_in_air_are_those_of_the_linear_model() {
    let text = include_str!("../../../examples/models/goland_wing.toml");
    let (before, after) = (text.find("[gust.bump]").expect("a gust"), text.find("[solver]").expect("a solver"));
    let calm = format!("{}{}", &text[..before], &text[after..]).replacen("[0.0, -130.0, 0.0]", "[0.0, -100.0, 4.0]", 1);
    let mut plant = Plant::new(Arc::new(machine(&calm)));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let a = plant.study().state_space(&[], &|_| nalgebra::DVector::zeros(0)).expect("a linear model").a;
    let mut hybrid = plant.hybrid().expect("strips");
    let mut states = vec![0.0; hybrid.states()];
    hybrid.read(&mut states);
    assert_eq!(states.len(), a.nrows());
    let mut slope = |states: &[f64]| {
        let mut slope = vec![0.0; states.len()];
        hybrid.set(0.0, states);
        hybrid.derivatives(&mut slope).expect("derivatives");
        nalgebra::DVector::from_vec(slope)
    };
    let still = slope(&states);
    let lift = a.row_iter().map(|row| row.amax()).fold(0.0, f64::max);
    assert!(still.amax() < 1e-9 * lift, "not at rest: {:e}", still.amax());
    let mut worst = 0.0_f64;
    for column in 0..states.len() {
        let step = if column < states.len() / 2 { 1e-4 } else { 1e-2 };
        let beside = [1.0, -1.0].map(|sign| {
            let mut moved = states.clone();
            moved[column] += sign * step;
            slope(&moved)
        });
        let found = (&beside[0] - &beside[1]) * (0.5 / step);
        for (row, value) in found.iter().enumerate() {
            worst = worst.max((value - a[(row, column)]).abs() / a.row(row).amax().max(1e-12));
        }
    }
    println!("HY-03 Jacobian {} by {}: {worst:.1e}", states.len(), states.len());
    agree("HY-03", worst, 2e-8);
}

/// HY-04. A control surface in a hybrid system: in equilibrium with a deflected aileron nothing moves, and its hinge moment is that of the
/// static analysis; a further deflection accelerates the wing at once, twice as much for twice the angle.
#[test]
fn hy04_a_flap_acts_between_events() {
    let mut plant = Plant::new(Arc::new(machine(include_str!("../../../examples/aileron/folding_aileron.toml"))));
    plant.inputs_mut().flaps_mut()[0].command_rad = 0.05;
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    let hinge_n_m = plant.outputs().flaps()[0].hinge_moment_n_m;
    let mut hybrid = plant.hybrid().expect("strips");
    let mut states = vec![0.0; hybrid.states()];
    hybrid.read(&mut states);
    let mut slope = |command_rad: f64| {
        hybrid.system_mut().inputs_mut().flaps_mut()[0].command_rad = command_rad;
        hybrid.follow_inputs();
        hybrid.set(0.0, &states);
        let mut slope = vec![0.0; states.len()];
        hybrid.derivatives(&mut slope).expect("derivatives");
        (nalgebra::DVector::from_vec(slope), hybrid.outputs().flaps()[0].hinge_moment_n_m)
    };
    let [still, further, twice] = [0.05, 0.06, 0.07].map(&mut slope);
    let (moves, twice_moves) = (further.0.norm(), twice.0.norm());
    println!("HY-04 still {:.1e}, moved {moves:.1e}, ratio {}", still.0.norm() / moves, twice_moves / moves);
    // the equilibrium is found to 1e-8 in the kinematic norm, which 0.01 rad of the control surface change by a few per cent
    agree("HY-04", still.0.norm() / moves, 2e-8);
    assert!(
        (still.1 - hinge_n_m).abs() < 1e-9 * hinge_n_m.abs() && further.1 < still.1,
        "{} {} {hinge_n_m}",
        still.1,
        further.1
    );
    // the loads rotate with the flap: quadratic in the angle
    assert!((twice_moves / moves - 2.0).abs() < 0.02);
}

/// Goland's wing without its gust, under gravity and a wind along its chord, in equilibrium.
fn goland_at_rest(keys: &str, wind_m_s: f64) -> Plant {
    let text = include_str!("../../../examples/models/goland_wing.toml");
    let (before, after) = (text.find("[gust.bump]").expect("a gust"), text.find("[solver]").expect("a solver"));
    let wind = format!("[0.0, -{wind_m_s:?}, 0.0]\n{keys}");
    let calm = format!("{}{}", &text[..before], &text[after..]).replacen("[0.0, -130.0, 0.0]", &wind, 1);
    let text = calm.replacen("name = ", "gravity_m_s2 = [0.0, 0.0, -9.81]\nname = ", 1);
    let mut plant = Plant::new(Arc::new(machine(&text)));
    plant.study().equilibrium(0.0, Holding::AsReleased).expect("an equilibrium");
    plant
}

/// HY-05. Still or slow air: its loads are below the structure's round-off, and derivatives still exist, at the equilibrium and next to it.
/// Mach 1 is an error with compressibility. When the equations are re-entered after a set, the machine is in the state that was set.
#[test]
fn hy05_light_air_and_mach_1() {
    for wind_m_s in [0.0, 0.01, 0.1, 1.0, 2.0, 3.0, 30.0] {
        let mut plant = goland_at_rest("", wind_m_s);
        let mut hybrid = plant.hybrid().expect("strips");
        let mut states = vec![0.0; hybrid.states()];
        hybrid.read(&mut states);
        let mut slope = states.clone();
        for number in 0..50 {
            let near: Vec<f64> =
                states.iter().enumerate().map(|(i, x)| x + 1e-12 * ((i * 7 + number * 13) % 11) as f64).collect();
            hybrid.set(0.0, &near);
            hybrid.derivatives(&mut slope).unwrap_or_else(|error| panic!("{wind_m_s} m/s: {error}"));
        }
        let set: Vec<f64> = states.iter().map(|x| x + 1e-3).collect();
        hybrid.set(0.0, &set);
        let again = plant.hybrid().expect("strips");
        let mut read = vec![0.0; again.states()];
        again.read(&mut read);
        assert_eq!(read, set, "{wind_m_s} m/s");
    }
    for (wind_m_s, fits) in [(330.0, true), (341.0, false)] {
        let mut plant = goland_at_rest("speed_of_sound_m_s = 340.0", 50.0);
        plant.inputs_mut().wind_m_s_mut().y = -wind_m_s;
        let mut hybrid = plant.hybrid().expect("strips");
        hybrid.follow_inputs();
        let mut slope = vec![0.0; hybrid.states()];
        let told = hybrid.derivatives(&mut slope).map_err(|error| error.to_string());
        assert_eq!(told.is_ok(), fits, "{told:?}");
        assert!(fits || told.is_err_and(|told| told.contains("Mach 1.003")));
    }
}

/// HY-01. The shipped wing, integrated externally by the Runge–Kutta method at 4 µs, latches at the same time and with the same energies as
/// in co-simulation at a tolerance of 1e-9: to 1e-7 s and 1e-7 J, about ten times the error of the two.
#[test]
fn shipped_wing_unfolds_and_latches_under_an_integrator_from_outside() {
    let text = include_str!("../../../examples/models/folding_wing.toml");
    let end_s = if is_whole() { 0.37 } else { 0.14 }; // the latch closes at 0.122 s
    let mut own = Plant::new(Arc::new(machine(text)));
    own.parameters_mut().solver_mut().tolerance = 1e-9;
    own.initialize(0.0).expect("initialises");
    own.step(end_s).expect("steps");
    let reference = own.outputs().clone();

    let mut plant = Plant::new(Arc::new(machine(text)));
    plant.initialize(0.0).expect("initialises");
    let mut outside = Outside::of(plant.hybrid().expect("a machine without air"));
    outside.run(end_s, 4e-6);
    let (accounts, events) = (outside.accounts, outside.events.clone());
    let found = outside.system.outputs().clone();
    let [latched] = events[..] else { panic!("one event: {events:?}") };
    println!("HY-01 latch {} s against {} s", latched.0, reference.latches()[0].time_s);
    println!("angle {} {}", found.joints()[0].angle_rad, reference.joints()[0].angle_rad);
    println!("total {} {}", found.energy().total, reference.energy().total);
    println!(
        "dissipated {} {}, work {} {}",
        accounts[1],
        reference.energy().dissipated,
        accounts[0],
        reference.energy().work
    );
    let energies_j = [
        found.energy().total - reference.energy().total,
        accounts[1] - reference.energy().dissipated,
        accounts[0] - reference.energy().work,
    ];
    assert!((latched.0 - reference.latches()[0].time_s).abs() < 1e-7);
    assert!(energies_j.iter().all(|error| error.abs() < 1e-7), "{energies_j:?}");
    assert!(found.latches()[0].closed.is_on() && found.latches()[0].count.get() == 1);
}

#[test]
fn what_cannot_be_integrated_from_outside_is_refused() {
    let mut plant = Plant::new(Arc::new(machine(include_str!("../../../examples/models/folding_wing.toml"))));
    assert_eq!(plant.hybrid().err(), Some(NotHybrid::Uninitialized));
    let mut plant = Plant::new(Arc::new(machine(include_str!("../../../examples/models/folding_wing_in_tunnel.toml"))));
    plant.initialize(0.0).expect("initialises");
    assert_eq!(plant.hybrid().err(), Some(NotHybrid::Air));
}

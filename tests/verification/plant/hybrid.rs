//! The machine as a hybrid system under an integrator that is not ours: classical Runge–Kutta of fixed step, events located
//! by the indicators, transitions made at them.

use crate::whole::is_whole;
use foldwing::machine::Machine;
use foldwing::plant::{AccountRates, Hybrid, Jump, NotHybrid, Plant};
use std::sync::Arc;

fn machine(text: &str) -> Machine {
    foldwing::config::parse(text, "model.toml").expect("a model that is accepted")
}

/// Integrates with steps of `step_s`, sees the machine through [`Hybrid`] alone.
struct Outside<'a> {
    system: Hybrid<'a>,
    states: Vec<f64>,
    /// Work of the inputs and energy dissipated, J.
    accounts: [f64; 2],
    /// Times of events in s, with what they book.
    events: Vec<(f64, Jump)>,
}

impl<'a> Outside<'a> {
    fn of(system: Hybrid<'a>) -> Self {
        let mut states = vec![0.0; system.states()];
        system.read(&mut states);
        Self { system, states, accounts: [0.0; 2], events: Vec::new() }
    }

    fn slope(&mut self, time_s: f64, states: &[f64]) -> (Vec<f64>, AccountRates) {
        let mut slope = vec![0.0; states.len()];
        self.system.set(time_s, states);
        let rates = self.system.derivatives(&mut slope).expect("derivatives");
        (slope, rates)
    }

    /// States and accounts a step further.
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

    fn indicators_at(&mut self, time_s: f64, states: &[f64]) -> Vec<f64> {
        let mut values = vec![1.0; self.system.indicators()];
        self.system.set(time_s, states);
        self.system.read_indicators(&mut values);
        values
    }

    /// Goes on to `end_s`, at most `step_s` at a time, through events and kinks.
    fn run(&mut self, end_s: f64, step_s: f64) {
        while self.system.time_s() < end_s - 1e-12 {
            let begin_s = self.system.time_s();
            let kink_s = self.system.next_kink_s();
            let stop_s = (begin_s + step_s).min(end_s).min(kink_s);
            let (mut end, mut accounts) = self.tried(stop_s - begin_s);
            let mut arrived_s = stop_s;
            let crossed = |values: &[f64]| (0..values.len()).filter(|&i| values[i] <= 0.0).collect::<Vec<_>>();
            let mut events = crossed(&self.indicators_at(stop_s, &end));
            if !events.is_empty() {
                let (mut low_s, mut high_s) = (begin_s, stop_s);
                while high_s - low_s > 1e-12 {
                    let middle_s = 0.5 * (low_s + high_s);
                    let begin = self.states.clone();
                    self.system.set(begin_s, &begin);
                    let tried = self.tried(middle_s - begin_s);
                    let found = crossed(&self.indicators_at(middle_s, &tried.0));
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

/// HY-01. The shipped wing, integrated from outside by Runge and Kutta's method at 4 µs, latches when co-simulation at a tolerance of
/// 1e-9 says, and has its energies: to 1e-7 s and 1e-7 J, some ten times what the two leave.
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

//! Linear models of several rotors: RT-31 and following.

use super::several::{COMMON, machine, rotor_part, turbines};
use foldwing::interface::{Interface, LinearModel, LinearSignal};
use foldwing::plant::{ModeShape, Plant};
use nalgebra::DMatrix;
use std::sync::Arc;

const LAGS: &str = "dynamic_inflow = true\ndynamic_stall = true\n";

/// Two rotors of a text at 0.1 s, and the linear model between wind and loads of the rotors.
fn linear(text: &str, outputs: &[&str]) -> (Plant, LinearModel) {
    let mut plant = Plant::new(Arc::new(machine(text)));
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant.step(0.1).unwrap_or_else(|error| panic!("{error}"));
    let interface = Interface::new(plant.machine());
    let row = |name: &str| interface.find(name).unwrap_or_else(|| panic!("{name}"));
    let inputs = ["wind.velocity.x", "wind.velocity.y", "wind.velocity.z"].map(row);
    let outputs: Vec<_> = outputs.iter().map(|name| row(name)).collect();
    let model = interface.linearize(&mut plant, &inputs, &outputs).unwrap_or_else(|error| panic!("{error}"));
    (plant, model)
}

/// The machines of one rotor and of two that are 400 m apart, with a steady run up to the last bits.
fn both() -> [(Plant, LinearModel); 2] {
    let air = |parts: &[&str]| {
        let parts: Vec<String> = parts.iter().map(|name| rotor_part(name, LAGS)).collect();
        format!("[aerodynamics]\n{COMMON}{}", parts.concat())
    };
    let one = turbines(&[("one", 0.0)], &air(&["one"]));
    let two = turbines(&[("one", -200.0), ("two", 200.0)], &air(&["one", "two"]));
    [
        linear(&one, &["rotor.one.thrust", "rotor.one.power_coefficient", "aero.force.x"]),
        linear(&two, &["rotor.one.thrust", "rotor.one.power_coefficient", "rotor.two.thrust", "aero.force.x"]),
    ]
}

/// Places of the signals of one rotor's machine among those of two, for the rotor `name`.
fn places(of_one: &[LinearSignal], of_two: &[LinearSignal], name: &str) -> Vec<usize> {
    let place = |signal: &LinearSignal| {
        let wanted = signal.name.replacen("one", name, 1);
        of_two.iter().position(|other| other.name == wanted).unwrap_or_else(|| panic!("{wanted}"))
    };
    of_one.iter().map(place).collect()
}

/// Largest difference of entries over the largest entry of the same column.
fn apart(found: &DMatrix<f64>, due: &DMatrix<f64>) -> f64 {
    let columns = found.column_iter().zip(due.column_iter());
    columns.map(|(found, due)| (found - due).amax() / due.amax().max(1e-9)).fold(0.0, f64::max)
}

/// RT-31. The linear model of two distant equal rotors is twice that of one: the same blocks on the diagonal, none between the rotors, and
/// the total force is the sum. States of a rotor have the names of its blades' stations. The runs agree by the tolerance of their iterations.
#[test]
fn rt31_two_distant_rotors_are_twice_one() {
    let [(_, one), (_, two)] = both();
    let (n, m) = (one.states.len(), two.states.len());
    assert_eq!(m, 2 * n);
    let own = ["one", "two"].map(|name| places(&one.states, &two.states, name));
    let mut largest = 0.0_f64;
    for (a, rows) in own.iter().enumerate() {
        for (b, columns) in own.iter().enumerate() {
            let block = two.matrices.a.select_rows(rows).select_columns(columns);
            match a == b {
                true => largest = largest.max(apart(&block, &one.matrices.a)),
                false => assert_eq!(block.amax(), 0.0),
            }
        }
        largest = largest.max(apart(&two.matrices.b.select_rows(rows), &one.matrices.b));
        let thrust = two.matrices.c.rows(2 * a, 1).select_columns(rows);
        largest = largest.max(apart(&thrust.transpose(), &one.matrices.c.rows(0, 1).transpose()));
        let total = two.matrices.c.rows(3, 1).select_columns(rows);
        largest = largest.max(apart(&total.transpose(), &one.matrices.c.rows(2, 1).transpose()));
        let gain = two.matrices.d.rows(2 * a, 1).transpose();
        largest = largest.max(apart(&gain, &one.matrices.d.rows(0, 1).transpose()));
    }
    let total = two.matrices.d.rows(3, 1).transpose();
    largest = largest.max(apart(&total, &(one.matrices.d.rows(2, 1).transpose() * 2.0)));
    // the power coefficient of one rotor does not depend on the other
    let foreign = two.matrices.c.rows(1, 1).select_columns(&own[1]);
    assert_eq!(foreign.amax(), 0.0);
    println!("RT-31: {n} and {m} states, {largest:.1e}");
    assert!(largest < 1e-6, "{largest:e}");
}

/// RT-32. Modes of two distant equal rotors are those of one, twice.
#[test]
fn rt32_modes_of_two_rotors_are_those_of_one_twice() {
    let [(mut one, _), (mut two, _)] = both();
    let modes = |plant: &mut Plant, count: usize| -> Vec<ModeShape> {
        plant.study().modes(count).unwrap_or_else(|error| panic!("{error}"))
    };
    let (alone, twins) = (modes(&mut one, 4), modes(&mut two, 8));
    for mode in &alone {
        let near = twins.iter().filter(|twin| {
            (twin.eigenvalue_1_s - mode.eigenvalue_1_s).norm() < 1e-6 * mode.eigenvalue_1_s.norm().max(1.0)
        });
        let count = near.count();
        println!("RT-32: {:.6} Hz, damping {:.6}: {count}", mode.frequency_hz, mode.damping_ratio);
        assert_eq!(count, 2, "{:?}", mode.eigenvalue_1_s);
    }
}

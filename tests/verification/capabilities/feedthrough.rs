//! E-11 and E-12: between steps, outputs reflect the inputs that are set.

use super::Bench;
use crate::coupling::wings;
use foldwing::interface::{Causality, Stage, Value};
use foldwing::plant::{OutputSet, Snapshot};

/// Values of the Real outputs with the inputs as set.
fn shown(bench: &mut Bench, outputs: &[u32]) -> Vec<f64> {
    bench.plant.provide(OutputSet::ALL);
    bench.values(outputs)
}

/// Names and value references of the Real variables of a causality.
fn rows(bench: &Bench, causality: Causality) -> Vec<(String, u32)> {
    bench.reals(causality).iter().map(|row| (row.name.clone(), row.value_reference)).collect()
}

/// Adds `amount` to an input in a given state, reads the outputs, and restores the state.
fn shown_with(bench: &mut Bench, start: &Snapshot, outputs: &[u32], input: u32, amount: f64) -> Vec<f64> {
    let value = bench.values(&[input])[0] + amount;
    bench.table.set(&mut bench.plant, input, Value::Real(value)).expect("an input");
    let values = shown(bench, outputs);
    bench.plant.restore(start).expect("own snapshot");
    values
}

/// E-11. The outputs after an input has been set equal those after a step of zero length: at the start, in motion, around the latch, at
/// motor limits, with free bodies and loops. Only round-off may differ: 1e-9 of the largest value of the same vector, and 1e-11 in SI
/// units, because the solution for the accelerations has the condition number of the mass matrix.
#[test]
fn e11_outputs_show_the_inputs_that_are_set() {
    for name in ["folding_wing", "branched", "flying_wing", "four_bar", "three_bodies", "roll_fold"] {
        let mut bench = Bench::shipped(name);
        let outputs = rows(&bench, Causality::Output);
        let references: Vec<u32> = outputs.iter().map(|(_, reference)| *reference).collect();
        let (mut worst, mut moved) = (0.0_f64, 0);
        for end_s in [0.0, 0.0307, 0.1223, 0.15] {
            if end_s > 0.0 {
                bench.march(end_s, 20);
            }
            let start = bench.plant.snapshot();
            let before = shown(&mut bench, &references);
            for (input, reference) in rows(&bench, Causality::Input) {
                // 0.3 rad and 0.3 N·m reach the limits of any motors
                let now = shown_with(&mut bench, &start, &references, reference, 0.3);
                assert_eq!(shown(&mut bench, &references), before, "{name}: {input} set back");
                bench.set(&input, bench.get(&input) + 0.3);
                bench.step(bench.plant.time_s());
                let stepped = shown(&mut bench, &references);
                bench.plant.restore(&start).expect("own snapshot");
                let stem = |name: &str| name.rsplit_once('.').map_or("", |(stem, _)| stem).to_owned();
                for (i, (output, _)) in outputs.iter().enumerate() {
                    let peers = outputs.iter().enumerate().filter(|(_, (other, _))| stem(other) == stem(output));
                    let size = peers.fold(0.0_f64, |size, (j, _)| size.max(stepped[j].abs()).max(before[j].abs()));
                    let error = (now[i] - stepped[i]).abs();
                    assert!(
                        error <= 1e-9 * size + 1e-11,
                        "{name} at {end_s} s: {output} after {input}: shown {}, after a step {}",
                        now[i],
                        stepped[i]
                    );
                    worst = worst.max(error / (size + 1e-2));
                }
                moved += usize::from(now != before);
            }
        }
        println!("E-11 {name}: {moved} inputs show at once, worst {worst:.1e} of the largest of the vector");
        assert!(moved > 0, "{name}");
    }
}

/// E-11. Aerodynamic loads are held between steps: the outputs follow the declared derivatives, each of which E-08 compares with steps.
/// Differences of a polynomial of second degree are exact; the allowed difference is round-off.
#[test]
fn e11_in_air_outputs_follow_the_derivatives() {
    let strips = "model = \"strip\"\nstep_s = 1e-3\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 1.0]";
    let mut bench = Bench::of(wings::folding_wing(strips, 3, 1));
    bench.march(0.0307, 20);
    let outputs = rows(&bench, Causality::Output);
    let references: Vec<u32> = outputs.iter().map(|(_, reference)| *reference).collect();
    let start = bench.plant.snapshot();
    let mut moved = 0;
    for (input, reference) in rows(&bench, Causality::Input) {
        let amount = if input.starts_with("fold.") { 1e-4 } else { 1.0 };
        let [above, below] =
            [1.0, -1.0].map(|sign| shown_with(&mut bench, &start, &references, reference, sign * amount));
        let mut given = vec![0.0; references.len()];
        let unknowns = (&*references, &mut *given);
        let stage = (Stage::Running, 0.0);
        bench.table.directional_derivative(&mut bench.plant, stage, unknowns, (&[reference], &[1.0])).expect("one");
        for (i, (output, _)) in outputs.iter().enumerate() {
            let slope = (above[i] - below[i]) / (2.0 * amount);
            let noise = 1e-11 * (1.0 + above[i].abs()) / amount;
            assert!(
                (slope - given[i]).abs() <= 1e-8 * given[i].abs() + noise,
                "{output} by {input}: {slope}, {}",
                given[i]
            );
        }
        moved += usize::from(above != below);
        assert!(!input.starts_with("wind.") || above == below, "wind acts on loads to come");
    }
    assert!(moved > 20, "{moved} inputs show at once");
}

/// E-12. Reading outputs after an input is set does not change any later result (bit-identical); a switch that is set takes effect only
/// with the next step.
#[test]
fn e12_looking_changes_nothing() {
    let mut runs = [false, true].map(|looks| {
        let mut bench = Bench::shipped("folding_wing");
        let outputs: Vec<u32> = rows(&bench, Causality::Output).iter().map(|(_, reference)| *reference).collect();
        for i in 1..=200 {
            bench.set("fold.external_torque", 1e-3 * f64::from(i % 7));
            bench.set("load.outer[4].force.x", 1e-2 * f64::from(i % 3));
            if looks {
                let first = shown(&mut bench, &outputs);
                bench.set("fold.external_torque", 0.5);
                assert_ne!(shown(&mut bench, &outputs), first);
                bench.set("fold.external_torque", 1e-3 * f64::from(i % 7));
                assert_eq!(shown(&mut bench, &outputs), first);
            }
            bench.step(1e-3 * f64::from(i));
        }
        bench.plant.provide(OutputSet::ALL);
        (bench.plant.snapshot(), bench.values(&outputs))
    });
    let [(state, values), (looked_state, looked_values)] = &mut runs;
    assert!(state == looked_state && values == looked_values);

    let mut bench = Bench::shipped("folding_wing");
    bench.march(0.05, 10);
    let before = bench.plant.outputs().clone();
    let release = bench.reference("fold.release");
    bench.table.set(&mut bench.plant, release, Value::Boolean(false)).expect("an input");
    bench.plant.provide(OutputSet::ALL);
    assert_eq!(bench.plant.outputs(), &before);
}

/// E-13. Requesting rates and derivatives, or saving and restoring, does not change the outputs shown for an input that is set.
#[test]
fn e13_other_calls_leave_what_is_shown() {
    let strips = "model = \"strip\"\nstep_s = 1e-3\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 1.0]";
    for mut bench in [Bench::shipped("folding_wing"), Bench::of(wings::folding_wing(strips, 3, 1))] {
        bench.march(0.0307, 20);
        let outputs: Vec<u32> = rows(&bench, Causality::Output).iter().map(|(_, reference)| *reference).collect();
        let before = shown(&mut bench, &outputs);
        bench.set("fold.external_torque", 0.01);
        let now = shown(&mut bench, &outputs);
        assert_ne!(now, before);
        bench.plant.study().output_rates();
        assert_eq!(shown(&mut bench, &outputs), now, "after rates");
        let torque = bench.reference("fold.external_torque");
        let mut values = vec![0.0; outputs.len()];
        let unknowns = (&*outputs, &mut *values);
        let stage = (Stage::Running, 0.0);
        bench.table.directional_derivative(&mut bench.plant, stage, unknowns, (&[torque], &[1.0])).expect("one");
        assert_eq!(shown(&mut bench, &outputs), now, "after derivatives");
        let saved = bench.plant.snapshot();
        bench.step(0.04);
        bench.plant.restore(&saved).expect("own snapshot");
        assert_eq!(shown(&mut bench, &outputs), now, "after a rollback");
    }
}

//! Time derivatives of outputs.

use super::Bench;
use crate::coupling::wings;
use foldwing::interface::{AccessError, Causality};

/// Outputs that depend on accelerations.
fn follows_from_accelerations(name: &str) -> bool {
    ["root.force", "root.moment", "acceleration.", "specific_force.", ".reaction", "joint.", "internal_load."]
        .iter()
        .any(|part| name.contains(part))
        || (name.starts_with("gauge.")
            || name.ends_with(".holding_torque")
            || name.contains(".force.")
            || name.contains(".moment."))
            && !name.starts_with("aero.")
}

fn rates(bench: &mut Bench, references: &[u32]) -> Vec<f64> {
    let mut values = vec![f64::NAN; references.len()];
    let orders = vec![1; references.len()];
    bench.table.output_rates(&mut bench.plant, references, &orders, &mut values).expect("outputs");
    values
}

/// Kind of a variable, for a common scale: the components of a vector.
fn kind(name: &str) -> String {
    name.rsplit('.').nth(1).unwrap_or(name).to_owned()
}

/// Outputs that also depend on the rates of the coordinates, or change as fast as those (gaps of loops).
fn follows_from_rates(name: &str) -> bool {
    [".angular_velocity", ".velocity.", ".angular_velocity.", "total_torque", "loop."]
        .iter()
        .any(|part| name.contains(part))
        || (name.starts_with("energy.") && !name.ends_with(".elastic") && !name.ends_with(".gravity"))
}

/// E-05. Rates of outputs that depend on coordinates and rates equal central differences over ±0.2 µs of the motion to 1e-5 of the largest
/// rate of their kind; where rates of coordinates enter, to 1e-3, because accelerations contain modes above 100 kHz, which such differences
/// smooth. For every shipped kind of machine, with varying inputs, and with aerodynamics.
#[test]
fn e05_rates_of_the_state_equal_differences_of_the_motion() {
    let air = "model = \"uvlm\"\nstep_s = 1e-3\nwake_rows = 10\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 1.0]";
    let machines = ["folding_wing_constant", "branched", "flying_wing", "four_bar", "three_bodies"];
    let benches = machines.map(|name| (name, Bench::shipped(name))).into_iter();
    for (name, mut bench) in benches.chain([("in air", Bench::of(wings::folding_wing(air, 3, 2)))]) {
        bench.march(0.0303, 7);
        let rows: Vec<(u32, String)> = bench
            .reals(Causality::Output)
            .iter()
            .filter(|row| !follows_from_accelerations(&row.name))
            .map(|row| (row.value_reference, row.name.clone()))
            .collect();
        let references: Vec<u32> = rows.iter().map(|row| row.0).collect();
        let side_s = 2e-7;
        // a change of the inputs recomputes the aerodynamic loads: no smooth motion
        let push = |bench: &mut Bench| {
            if name != "in air" {
                bench.set_rate("gravity.z", 30.0);
            }
        };
        push(&mut bench);
        bench.step(0.0303 + side_s);
        let low = bench.values(&references);
        push(&mut bench);
        bench.step(0.0303 + 2.0 * side_s);
        let before = bench.values(&references);
        let given = rates(&mut bench, &references);
        assert_eq!(bench.values(&references), before, "{name}: asking changes nothing");
        push(&mut bench);
        bench.step(0.0303 + 3.0 * side_s);
        let high = bench.values(&references);
        // where inputs vary, internal steps are as short as these, and rates come from points 1/64 of a step apart: round-off of the
        // velocities divided by that distance, with weights of ten in total
        let speeds = rows.iter().zip(&before).filter(|((_, row), _)| row.contains("velocity"));
        let length_s = if name == "in air" { f64::INFINITY } else { side_s };
        let drawn = 640.0 * 1e-14 * speeds.map(|(_, speed)| speed.abs()).fold(0.0, f64::max) / length_s;
        let mut worst = (0.0_f64, String::new());
        for (i, (_, row)) in rows.iter().enumerate() {
            let slope = (high[i] - low[i]) / (2.0 * side_s);
            let alike = rows.iter().zip(&given).filter(|((_, other), _)| kind(other) == kind(row));
            let scale = alike.map(|(_, rate)| rate.abs()).fold(0.0, f64::max);
            // round-off of the difference quotient
            let noise = 1e-15 * (high[i].abs() + low[i].abs()) / side_s;
            let error = ((given[i] - slope).abs() - 10.0 * noise - drawn).max(0.0);
            if error > worst.0 * scale {
                worst = (error / scale.max(f64::MIN_POSITIVE), row.clone());
            }
            let allowed = if follows_from_rates(row) { 1e-3 } else { 1e-5 };
            assert!(
                error <= allowed * scale,
                "{name}: {row}: {} against {slope} by differences, scale {scale}",
                given[i]
            );
        }
        println!("E-05: {name}: {} rows, worst {:.1e} at {}", rows.len(), worst.0, worst.1);
    }
}

/// E-06. The rates of forces, accelerations and recovered strains are the time derivatives of the values read within the internal step:
/// they equal central differences over ±0.1 µs to 1e-3, plus the round-off of the difference and 1e-6 of the largest rate of their kind.
/// Instants with the end of an internal step inside the difference are skipped: the rate may jump there.
#[test]
fn e06_rates_of_what_follows_from_accelerations_are_the_slopes_of_what_is_read() {
    let air = "model = \"uvlm\"\nstep_s = 1e-3\nwake_rows = 10\ndensity_kg_m3 = 1.2\nwind_m_s = [0.0, -10.0, 1.0]";
    let machines = ["folding_wing", "folding_wing_constant", "branched", "flying_wing", "four_bar", "three_bodies"];
    let benches = machines.map(|name| (name, Bench::shipped(name))).into_iter();
    let side_s = 1e-7;
    for (name, mut bench) in benches.chain([("in air", Bench::of(wings::folding_wing(air, 3, 2)))]) {
        let (rows, references) = following_accelerations(&bench);
        assert!(rates(&mut bench, &references).iter().all(|rate| rate.is_finite()), "{name}: no step yet");
        let (mut compared, mut worst) = (0, 0.0_f64);
        for i in 0..12 {
            let time_s = 0.02 + 5.3e-3 * f64::from(i);
            bench.step(time_s - side_s);
            let (low, steps) = (bench.values(&references), bench.plant.statistics().steps);
            bench.step(time_s);
            let given = rates(&mut bench, &references);
            bench.step(time_s + side_s);
            let high = bench.values(&references);
            if bench.plant.statistics().steps != steps {
                continue; // a kink: an internal step ends in between
            }
            compared += 1;
            for (k, row) in rows.iter().enumerate() {
                let slope = (high[k] - low[k]) / (2.0 * side_s);
                let alike = rows.iter().zip(&given).filter(|(other, _)| kind(other) == kind(row));
                let scale = alike.map(|(_, rate)| rate.abs()).fold(0.0, f64::max);
                let values = rows.iter().zip(high.iter().zip(&low)).filter(|(other, _)| kind(other) == kind(row));
                let size = values.map(|(_, (high, low))| high.abs() + low.abs()).fold(0.0, f64::max);
                // of sums as large as the kind, of strains relative to 1, and of weight and inertia forces that cancel in free flight
                let floor = if row.contains(".reaction_") { 1e-15 } else { 1e-16 };
                let noise = (1e-11 * size + floor) / side_s;
                let error = ((given[k] - slope).abs() - noise - 1e-6 * scale).max(0.0);
                worst = worst.max(error / slope.abs().max(f64::MIN_POSITIVE));
                assert!(error <= 1e-3 * slope.abs(), "{name} at {time_s} s: {row}: {}, not {slope}", given[k]);
            }
        }
        println!("E-06: {name}: {} rows at {compared} times, worst {worst:.1e}", rows.len());
        assert!(compared >= 6, "{name}: {compared} times without a kink");
    }
}

/// Outputs that depend on accelerations: names and value references.
fn following_accelerations(bench: &Bench) -> (Vec<String>, Vec<u32>) {
    let rows = bench.reals(Causality::Output);
    rows.iter()
        .filter(|row| follows_from_accelerations(&row.name))
        .map(|row| (row.name.clone(), row.value_reference))
        .unzip()
}

/// E-07. Higher-order derivatives are returned as zero; order zero, inputs and Booleans are rejected.
#[test]
fn e07_other_orders_and_rows() {
    let mut bench = Bench::shipped("folding_wing");
    bench.step(1e-3);
    let angle = bench.reference("fold.angle");
    let mut value = [f64::NAN; 2];
    bench.table.output_rates(&mut bench.plant, &[angle, angle], &[1, 2], &mut value).expect("legal");
    assert!(value[0] < 0.0 && value[1] == 0.0, "{value:?}");
    let mut refuse = |name: &str, order| {
        let reference = bench.reference(name);
        bench.table.output_rates(&mut bench.plant, &[reference], &[order], &mut [0.0]).expect_err("refused")
    };
    assert!(matches!(refuse("fold.angle", 0), AccessError::Order { order: 0, .. }));
    assert!(matches!(refuse("fold.external_torque", 1), AccessError::NotAnUnknown { .. }));
    assert!(matches!(refuse("fold.latched", 1), AccessError::WrongType { .. }));
}

//! Results as functions of communication steps, start times and tolerances.

use crate::plant::machines::*;
use foldwing::machine::{ElementKind, Method};
use foldwing::plant::{Plant, Statistics};

/// Simulates in communication steps to slightly beyond the latch, from `start_s`; returns the latch time since the start.
fn latch_time_s(start_s: f64, step_s: f64, before: impl FnMut(&mut Plant)) -> f64 {
    let mut plant = start_at(default_wing(1e-5), start_s);
    let steps = (0.13 / step_s).ceil();
    run(&mut plant, start_s + steps * step_s, steps as usize, before, |_| {});
    plant.outputs().latches()[0].time_s - start_s
}

/// P-20. With constant inputs the communication step and the start time do not change the latch time.
///
/// The integrator takes the same steps for any communication steps: only the rounding of `start + t` differs (1e-13 s at a start of 1000 s,
/// amplified by the motion).
#[test]
fn p20_latch_time_is_independent_of_the_communication_step() {
    let reference_s = latch_time_s(0.0, 1e-3, |_| {});
    for start_s in [0.0, 7.3, 1000.0] {
        for step_s in [1e-4, 3.7e-4, 5e-4, 1.3e-3, 2e-3, 5e-3, 0.13] {
            let error_s = latch_time_s(start_s, step_s, |_| {}) - reference_s;
            println!("start {start_s} s, step {step_s} s: latch moves by {error_s:.1e} s");
            assert!(error_s.abs() < 1e-9, "start {start_s} s, step {step_s} s: latch moves by {error_s:.1e} s");
        }
    }
}

/// P-21. With an input that changes negligibly at every step, the integrator stops at every communication point; the latch time stays
/// within the integrator's error at this tolerance.
#[test]
fn p21_changing_inputs_leave_the_latch_time() {
    let reference_s = latch_time_s(0.0, 1e-3, |_| {});
    for step_s in [1e-4, 3.7e-4, 1e-3, 2.3e-3, 5e-3] {
        let mut sign = 1.0;
        let error_s = latch_time_s(0.0, step_s, |plant| {
            sign = -sign;
            plant.inputs_mut().joints_mut()[0].torque_n_m = sign * 1e-12;
        }) - reference_s;
        println!("step {step_s} s: latch moves by {error_s:.1e} s");
        assert!(error_s.abs() < 2e-5, "step {step_s} s: latch moves by {error_s:.1e} s");
    }
}

/// P-22. The latch time converges with the tolerance; prints a table of the cost.
///
/// Reference: ESDIRK4 at 1e-9 on the same mesh. For the default method, reducing the tolerance a thousandfold must reduce the error at
/// least tenfold (errors are not monotone: the tolerance bounds the step's error, not the run's).
#[test]
fn p22_latch_time_converges_with_tolerance() {
    let run = |method: Method, tolerance: f64| -> (f64, f64, Statistics) {
        let mut plant = start(wing(ElementKind::Linear, 2, method, tolerance));
        let mut peak = 0f64;
        run(&mut plant, 0.4, 800, |_| {}, |outputs| peak = peak.max(outputs.gauges()[0].abs()));
        (plant.outputs().latches()[0].time_s, peak, plant.statistics())
    };
    let (reference_s, reference_peak, _) = run(Method::Esdirk4, 1e-9);
    println!("reference: latch {reference_s:.9} s, peak {reference_peak:.6e}");
    println!("| method | tolerance | steps | rejected | iterations | factorisations | latch error s | peak error % |");
    println!("|---|---|---|---|---|---|---|---|");
    for method in [Method::Esdirk4, Method::Esdirk3, Method::TrBdf2, Method::GeneralizedAlpha] {
        let errors_s = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7].map(|tolerance| {
            let (latch_s, peak, counted) = run(method, tolerance);
            let (error_s, peak_error) = (latch_s - reference_s, 100.0 * (peak / reference_peak - 1.0));
            println!(
                "| {method:?} | {tolerance:.0e} | {} | {} | {} | {} | {error_s:.1e} | {peak_error:.2} |",
                counted.steps, counted.rejections, counted.iterations, counted.factorizations
            );
            error_s.abs()
        });
        assert!(errors_s[2] < 1.0e-4, "{method:?}: latch error {:.1e} s at tolerance 1e-5", errors_s[2]);
        if method == Method::Esdirk4 {
            assert!(errors_s[3] < 0.1 * errors_s[0] + 1e-9, "latch errors {errors_s:?} s do not fall with tolerance");
            assert!(errors_s[4] < 0.1 * errors_s[1] + 1e-9, "latch errors {errors_s:?} s do not fall with tolerance");
        }
    }
}

/// P-131. If the convergence of Newton's iteration limits the step length, the run prints a note with the remedy: a thin, stiff rod with a
/// bob on a ball joint. Before, a thousand failed steps were only a number in the summary. There is no note for the shipped wing.
#[test]
fn p131_steps_that_newton_decides_on_are_told() {
    let statistics = |text: &str| {
        let machine = foldwing::config::parse(text, "rod.toml").unwrap_or_else(|error| panic!("{error}"));
        let mut plant = start(machine);
        plant.step(0.5).unwrap_or_else(|error| panic!("{error}"));
        plant.statistics()
    };
    let rod = "name = \"Rod\"\ngravity_m_s2 = [0.0, 0.0, -9.81]\n[section.rod]\nshape = \"explicit\"\n\
               axial_stiffness_N = 1.2e4\ntorsional_rigidity_N_m2 = 1.26e-3\nflap_stiffness_N_m2 = 1.57e-3\n\
               edge_stiffness_N_m2 = 1.57e-3\nmass_kg_m = 0.458\nsecond_moments_kg_m = [5.97e-8, 0.0, 5.97e-8]\n\
               half_width_m = 0.001\nhalf_height_m = 0.001\n[body.rod]\nlength_m = 1.0\nsection = \"rod\"\nelements = 2\n\
               [joint.hinge]\ntype = \"ball\"\nparent = \"root\"\nchild = \"rod\"\n\
               start_angular_velocity_deg_s = [0.0, 100.0, 30.0]\n[mass.bob]\nbody = \"rod\"\nposition_m = 1.0\n\
               mass_kg = 4.55\ninertia_kg_m2 = [7.3e-4, 7.3e-4, 7.3e-4, 0.0, 0.0, 0.0]\n[solver]\ntolerance = 1e-8\n";
    let before = statistics(rod);
    let cured = statistics(&rod.replace("[solver]", "[solver]\nmethod = \"generalized_alpha\""));
    let advice = before.advice_on_failures().expect("most steps fail");
    println!("P-131 {advice}; {} failures by generalised-α", cured.failures);
    assert!(advice.contains("solver.method = \"generalized_alpha\""), "{advice}");
    assert!(before.failures > before.steps / 2 && cured.failures == 0, "{before:?}, {cured:?}");
    assert!(cured.iterations < before.iterations / 2, "{} of {} iterations", cured.iterations, before.iterations);
    let wing = statistics(include_str!("../../../examples/models/folding_wing.toml"));
    assert_eq!((wing.advice_on_failures(), wing.failures), (None, 0));
}

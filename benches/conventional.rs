//! Two-body system of Otsuka et al. §4.4, 5 s in steps of 10 ms by generalised-α as in the paper: this product against
//! planar finite segments, time for an error, and the paper's 97 %.
//!
//! `cargo bench --bench conventional`. All run on the same integrator in one process; the time is the best of five
//! runs of the whole 5 s, outputs every 10 ms included. Results stand in `docs/validation/conventional.md`.

#[allow(dead_code)]
#[path = "../tests/verification/plant/machines.rs"]
mod machines;
#[allow(dead_code)]
#[path = "../tests/verification/conventional/segments.rs"]
mod segments;

use foldwing::beam::section::Section;
use foldwing::config::machine::*;
use foldwing::solve::stepper;
use nalgebra::{Matrix4, Vector2, Vector3, Vector4};
use segments::{Algebra, RootSpring, Segments, fall, table_4};
use std::time::Instant;

/// Converged RMS(Z) in m: inextensible, and with the EA = 1e7 N of the beams.
const CONVERGED_M: [f64; 2] = [10.145_988_56, 10.146_183_3];
const RUNS: usize = 5;
const STEP_S: f64 = 0.01;
const RHO_INFINITY: f64 = 0.9;

fn rms_m(path: &[Vector2<f64>]) -> f64 {
    (path.iter().map(|tip| tip.y * tip.y).sum::<f64>() / path.len() as f64).sqrt()
}

fn beams(kind: ElementKind, count: usize) -> Vec<Vector2<f64>> {
    let bending = table_4::BENDING_N_M2;
    let section = Section {
        stiffness: Matrix4::from_diagonal(&Vector4::new(1e7, bending, bending, bending)),
        mass_kg_m: table_4::MASS_KG_M,
        first_moment_kg: [0.0, 0.0],
        second_moment_kg_m: [table_4::ROTARY_KG_M, 0.0, table_4::ROTARY_KG_M],
        half_width_m: 0.5,
        half_height_m: 0.5,
    };
    let mut bodies = vec![machines::body("a", table_4::LENGTH_M, &section, kind, count, machines::clamped())];
    let joint = machines::hinged_to(&bodies, machines::free_hinge(0.0));
    bodies.push(machines::body("b", table_4::LENGTH_M, &section, kind, count, joint));
    let solver = Solver {
        fixed_step_s: Some(STEP_S),
        max_step_s: STEP_S,
        rho_infinity: RHO_INFINITY,
        ..machines::solver(Method::GeneralizedAlpha, 1e-6)
    };
    let machine =
        Machine { gravity_m_s2: Vector3::new(0.0, 0.0, -table_4::GRAVITY_M_S2), solver, ..machines::machine(bodies) };
    let mut plant = machines::start(machine);
    let mut path = Vec::with_capacity(500);
    machines::run(
        &mut plant,
        5.0,
        500,
        |_| {},
        |outputs| path.push(Vector2::new(outputs.tips[0].position_m.x, outputs.tips[0].position_m.z)),
    );
    path
}

fn chain(segments: usize, root: RootSpring, algebra: Algebra) -> Vec<Vector2<f64>> {
    let mut segments = Segments::table_4(segments, root, algebra);
    fall(&mut segments, stepper::Method::GeneralizedAlpha { rho_infinity: RHO_INFINITY }, STEP_S)
}

/// Prints a row and returns the best time in ms.
fn row(name: &str, sections: usize, converged_m: f64, run: impl Fn() -> Vec<Vector2<f64>>) -> f64 {
    let mut best_s = f64::INFINITY;
    let mut error = 0.0;
    for _ in 0..RUNS {
        let begin = Instant::now();
        let path = run();
        best_s = best_s.min(begin.elapsed().as_secs_f64());
        error = (rms_m(&path) / converged_m - 1.0).abs();
    }
    println!("| {name} | {sections} | {error:.1e} | {:.2} |", 1e3 * best_s);
    1e3 * best_s
}

fn main() {
    println!("| method | sections per body | error of RMS(Z) | time for 5 s, ms |\n|---|---|---|---|");
    let [rigid_m, elastic_m] = CONVERGED_M;
    let six = row("constant elements", 6, elastic_m, || beams(ElementKind::Constant, 6));
    let ten = row("constant elements", 10, elastic_m, || beams(ElementKind::Constant, 10));
    let pairs = row("linear elements", 4, elastic_m, || beams(ElementKind::Linear, 2));
    let mut thirty_dense = 0.0;
    let mut thirty = 0.0;
    for (root, name, sections) in [
        (RootSpring::HalfSegment, "2EI/l at the clamp", &[6, 9, 14, 30, 70][..]),
        (RootSpring::WholeSegment, "EI/l at the clamp", &[6, 30, 210][..]),
    ] {
        for &n in sections {
            let time = row(&format!("segments, {name}, O(n)"), n, rigid_m, || chain(n, root, Algebra::Recursive));
            if n == 30 && root == RootSpring::WholeSegment {
                thirty = time;
            }
            if n <= 70 {
                let dense = row(&format!("segments, {name}, dense"), n, rigid_m, || chain(n, root, Algebra::Dense));
                if n == 30 && root == RootSpring::WholeSegment {
                    thirty_dense = dense;
                }
            }
        }
    }
    println!(
        "\n6 constant elements against 30 segments: {:.1} % less time than dense segments,",
        100.0 * (1.0 - six / thirty_dense)
    );
    println!("{:.1} % less than segments by recursion (the paper: 97 %, dense both);", 100.0 * (1.0 - six / thirty));
    println!(
        "2 linear elements: {:.1} % and {:.1} %; constant 10 / linear 2: {:.1}",
        100.0 * (1.0 - pairs / thirty_dense),
        100.0 * (1.0 - pairs / thirty),
        ten / pairs
    );
}

//! Two-body system of Otsuka et al. §4.4, 5 s in steps of 10 ms by generalised-α as in the paper: comparison of Foldwing with planar
//! finite segments: time for a given error, and the paper's 97 %. Foldwing is three-dimensional; the paper's method in the plane is
//! included for a fair comparison with the planar segments.
//!
//! `cargo bench -p foldwing-benches --bench conventional`. All methods use the same integrator in one process; the time is the mean
//! processor time of runs over the whole 5 s, including outputs every 10 ms. Results are listed in `docs/validation/conventional.md`.

#[allow(dead_code)]
#[path = "../tests/verification/plant/machines.rs"]
mod machines;
#[allow(dead_code)]
#[path = "../tests/verification/conventional/planar.rs"]
mod planar;
#[allow(dead_code)]
#[path = "../tests/verification/conventional/segments.rs"]
mod segments;

use foldwing::beam::section::Section;
use foldwing::machine::*;
use foldwing::solve::stepper;
use nalgebra::{Matrix4, Vector2, Vector3, Vector4};
use segments::{Algebra, RootSpring, Segments, fall, table_4};
use std::time::Instant;

/// Converged RMS(Z) in m: for inextensible beams, and with EA = 1e7 N.
const CONVERGED_M: [f64; 2] = [10.145_988_56, 10.146_183_3];
/// Time in s for which each case is repeated: the system counts processor time in ticks of 4 ms.
const MEASURED_S: f64 = 1.0;
const STEP_S: f64 = 0.01;
const RHO_INFINITY: f64 = 0.9;

fn rms_m(path: &[Vector2<f64>]) -> f64 {
    (path.iter().map(|tip| tip.y * tip.y).sum::<f64>() / path.len() as f64).sqrt()
}

fn beams(kind: ElementKind, count: usize) -> Vec<Vector2<f64>> {
    let bending = table_4::BENDING_N_M2;
    let section = Section {
        shear: None,
        stiffness: Matrix4::from_diagonal(&Vector4::new(1e7, bending, bending, bending)),
        mass_kg_m: table_4::MASS_KG_M,
        first_moment_kg: [0.0, 0.0],
        second_moment_kg_m: [table_4::ROTARY_KG_M, 0.0, table_4::ROTARY_KG_M],
        half_width_m: 0.5,
        half_height_m: 0.5,
    };
    let beam = |name| machines::body(name, table_4::LENGTH_M, &section, kind, count);
    let hinge = Joint::hinge("fold", machines::free_hinge(0.0)).on("a");
    let bodies = [(beam("a"), machines::clamped()), (beam("b"), hinge)];
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
        |outputs| path.push(Vector2::new(outputs.tips()[0].position_m.x, outputs.tips()[0].position_m.z)),
    );
    path
}

fn chain(mut equations: impl segments::PlanarChain) -> Vec<Vector2<f64>> {
    fall(&mut equations, stepper::Method::GeneralizedAlpha { rho_infinity: RHO_INFINITY }, STEP_S)
}

/// Processor time of this thread in s if the system provides it (Linux), otherwise wall-clock time, which other programs disturb.
fn now_s(begin: &Instant) -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next().and_then(|first| first.parse::<f64>().ok()))
        .map_or_else(|| begin.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// Prints a row and returns the mean time in ms.
fn row(name: &str, sections: usize, converged_m: f64, run: impl Fn() -> Vec<Vector2<f64>>) -> f64 {
    let begin = Instant::now();
    let start_s = now_s(&begin);
    let (mut runs, mut error, mut spent_s) = (0, 0.0, 0.0);
    while spent_s < MEASURED_S || runs < 2 {
        error = (rms_m(&run()) / converged_m - 1.0).abs();
        runs += 1;
        spent_s = now_s(&begin) - start_s;
    }
    let mean_s = spent_s / f64::from(runs);
    println!("| {name} | {sections} | {error:.1e} | {:.2} |", 1e3 * mean_s);
    1e3 * mean_s
}

fn main() {
    println!("| method | sections per body | error of RMS(Z) | time for 5 s, ms |\n|---|---|---|---|");
    let [rigid_m, elastic_m] = CONVERGED_M;
    for n in [6, 10, 30] {
        row("product, constant elements", n, elastic_m, || beams(ElementKind::Constant, n));
    }
    let pairs = row("product, linear elements", 4, elastic_m, || beams(ElementKind::Linear, 2));
    for (algebra, how) in [(Algebra::Recursive, "O(n)"), (Algebra::Dense, "dense")] {
        let beam = |n: usize| {
            row(&format!("planar beams, {how}"), n, rigid_m, || chain(planar::PlanarBeams::table_4(n, algebra)))
        };
        let segment = |n: usize, root: RootSpring| {
            let name = format!(
                "segments, {} at the clamp, {how}",
                if root == RootSpring::HalfSegment { "2EI/l" } else { "EI/l" }
            );
            row(&name, n, rigid_m, || chain(Segments::table_4(n, root, algebra)))
        };
        let (six, thirty) = (beam(6), beam(30));
        segment(6, RootSpring::HalfSegment);
        let nine = segment(9, RootSpring::HalfSegment);
        segment(30, RootSpring::HalfSegment);
        segment(6, RootSpring::WholeSegment);
        let printed = segment(30, RootSpring::WholeSegment);
        let ratio = |what: &str, time: f64| println!("| *{how}: {what}* | | | *{time:.2}* |");
        ratio("6 beam sections over 30 segments with EI/l (the paper: 0.03)", six / printed);
        ratio("30 beam sections over 30 segments", thirty / printed);
        ratio("same error: 6 beam sections over 9 segments with 2EI/l", six / nine);
        if algebra == Algebra::Recursive {
            // with a dense matrix these would take minutes
            ratio(
                "same error: 6 beam sections over 212 segments with EI/l",
                six / segment(212, RootSpring::WholeSegment),
            );
            ratio(
                "same error: product's 2 linear elements over 73 segments with 2EI/l",
                pairs / segment(73, RootSpring::HalfSegment),
            );
        }
    }
}

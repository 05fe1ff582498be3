//! Motions of the double pendulum, sampled with all quantities of figs. 4 to 6 of the paper, and their tables.

use crate::conventional::assembly::{Assembly, row};
use crate::conventional::constraint::Constraint;
use crate::conventional::link::{self, Node};
use crate::conventional::pendulum::{STEP_S, runge_kutta};
use crate::whole::is_whole;
use nalgebra::{DVector, Vector3};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Sample of a motion at one instant.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Time in s.
    pub time_s: f64,
    /// Strains of A's first element.
    pub root_strain: [f64; 4],
    /// Tip of B in m.
    pub tip_m: Vector3<f64>,
    /// Kinetic, elastic and gravitational energy in J.
    pub energy_j: [f64; 3],
    /// Distance in m between P, computed from the origin outward, and Q, computed from the tip inward.
    pub gap_m: f64,
    /// `r_y^P · r_z^Q` of the same nodes.
    pub cardan: f64,
    /// `|r_x^P + r_z^Q|` of the same nodes.
    pub hinge: f64,
    /// Largest residual of `Ψ` (joint parameters) or of the rigid root nodes (DAE).
    pub own: f64,
    /// Force in N and moment in N·m of A on B at the joint.
    pub reaction: [Vector3<f64>; 2],
}

impl Sample {
    /// Evaluates a state.
    pub fn of(system: &Assembly, time_s: f64, q: &DVector<f64>, v: &DVector<f64>) -> Self {
        let [a, b] = beams(system);
        let motion = system.motion(q, v);
        let p = motion[a].nodes[system.bodies[a].elements].h;
        let tip = motion[b].nodes[system.bodies[b].elements].h;
        let beginning = inward(system, b, tip, q);
        let energies = system.energies(q, v);
        let strain = system.strain(a, 0);
        let own = system.constraints.iter().filter(|constraint| constraint.is_local());
        Self {
            time_s,
            root_strain: std::array::from_fn(|i| q[strain + i]),
            tip_m: row(&tip, 0),
            energy_j: [energies.kinetic, energies.elastic, energies.gravity],
            gap_m: (row(&p, 0) - row(&beginning, 0)).norm(),
            cardan: row(&p, 2).dot(&row(&beginning, 3)),
            hinge: (row(&p, 1) + row(&beginning, 3)).norm(),
            own: own.flat_map(|constraint| constraint.value(&motion, q)).fold(0.0, |m: f64, x| m.max(x.abs())),
            reaction: multiplier_wrench(system, q, v).unwrap_or_else(|| system.reaction(b, q, v)),
        }
    }

    /// Sum of the energies in J: zero in this motion.
    pub fn total_j(&self) -> f64 {
        self.energy_j.iter().sum()
    }
}

/// Indices of A and B among bodies that may also include massless carriers.
pub fn beams(system: &Assembly) -> [usize; 2] {
    let beams: Vec<usize> = (0..system.bodies.len()).filter(|&i| system.bodies[i].elements > 0).collect();
    [beams[0], beams[1]]
}

/// First node of a body from its last one: the elements' maps in reverse.
fn inward(system: &Assembly, body: usize, tip: Node, q: &DVector<f64>) -> Node {
    let beam = &system.bodies[body];
    (0..beam.elements).rev().fold(tip, |node, element| {
        let at = system.strain(body, element);
        let jet = link::element(-beam.length_m / beam.elements as f64, &q.as_slice()[at..at + 4], &[0.0; 4]);
        jet.value.apply(&node)
    })
}

/// Wrench of A on B from the multipliers of the constraints between nodes of two bodies; `None` without such constraints.
fn multiplier_wrench(system: &Assembly, q: &DVector<f64>, v: &DVector<f64>) -> Option<[Vector3<f64>; 2]> {
    let motion = system.motion(q, v);
    let (_, lambda) = system.accelerations(q, v);
    let (mut line, mut wrench) = (0, None);
    for constraint in &system.constraints {
        let [force, moment] = wrench.get_or_insert([Vector3::zeros(); 2]);
        match constraint {
            Constraint::Coincident(..) => *force -= lambda.fixed_rows::<3>(line),
            Constraint::Product { a, b, .. } if a.0.body != b.0.body => {
                let vector = |(end, k): (crate::conventional::constraint::End, usize)| {
                    row(&motion[end.body].nodes[end.node].h, k)
                };
                *moment -= vector(*b).cross(&vector(*a)) * lambda[line];
            }
            _ => {}
        }
        line += constraint.rows();
    }
    let joined = system.constraints.iter().any(|constraint| matches!(constraint, Constraint::Coincident(..)));
    wrench.filter(|_| joined)
}

/// Integrates with `step_s` and samples every `every` steps, the start included; with `project`, positions and rates are projected onto the
/// constraints.
pub fn run(
    system: &Assembly,
    start: &DVector<f64>,
    [end_s, step_s]: [f64; 2],
    every: usize,
    project: bool,
) -> Vec<Sample> {
    let (mut q, mut v) = (start.clone(), DVector::zeros(start.len()));
    let mut samples = vec![Sample::of(system, 0.0, &q, &v)];
    for step in 1..=(end_s / step_s).round() as usize {
        runge_kutta(system, &mut q, &mut v, step_s, project);
        if step % every == 0 {
            samples.push(Sample::of(system, step as f64 * step_s, &q, &v));
        }
    }
    samples
}

/// [`run`] with the paper's step, sampled every 10 ms.
pub fn run_as_printed(system: &Assembly, start: &DVector<f64>, end_s: f64, project: bool) -> Vec<Sample> {
    run(system, start, [end_s, STEP_S], 100, project)
}

/// Largest value of a quantity over a motion.
pub fn largest(samples: &[Sample], quantity: impl Fn(&Sample) -> f64) -> f64 {
    samples.iter().map(quantity).fold(0.0, |m, x| if x.is_nan() { f64::NAN } else { m.max(x.abs()) })
}

/// Writes `target/verification/<name>.csv` in full studies.
pub fn write_table(name: &str, header: &str, rows: impl Iterator<Item = Vec<f64>>) {
    if !is_whole() {
        return;
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).with_file_name("verification");
    std::fs::create_dir_all(&folder).expect("folder of the results");
    let mut text = format!("{header}\n");
    for row in rows {
        let cells: Vec<String> = row.iter().map(|x| format!("{x:.15e}")).collect();
        writeln!(text, "{}", cells.join(",")).expect("text");
    }
    std::fs::write(folder.join(format!("{name}.csv")), text).expect("table of results");
}

/// Writes a motion.
pub fn write_motion(name: &str, samples: &[Sample]) {
    let header = "t_s,ex,kx_1_m,ky_1_m,kz_1_m,tip_x_m,tip_y_m,tip_z_m,kinetic_j,elastic_j,gravity_j,\
                  gap_m,cardan,hinge,own,fx_n,fy_n,fz_n,mx_n_m,my_n_m,mz_n_m";
    let rows = samples.iter().map(|s| {
        let mut row = vec![s.time_s];
        row.extend(s.root_strain);
        row.extend(s.tip_m.iter());
        row.extend(s.energy_j);
        row.extend([s.gap_m, s.cardan, s.hinge, s.own]);
        row.extend(s.reaction.iter().flat_map(|vector| vector.iter()));
        row
    });
    write_table(name, header, rows);
}

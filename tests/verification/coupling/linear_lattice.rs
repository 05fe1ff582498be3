//! the discrete-time linear model of a machine with a lattice, against small motions of the nonlinear machine in time.

use crate::coupling::goland::{Goland, LATTICE_WITH_SUCTION};
use crate::whole::is_whole;
use foldwing::config;
use foldwing::machine::Machine;
use foldwing::plant::{Holding, InputSlope, Inputs, Outputs, Plant, SampledSpace};
use nalgebra::{DVector, Vector3};
use std::sync::Arc;

/// Aerodynamic steps of the input pulse and of the record. The wind travels one panel per step.
const BUMP: u32 = 24;
const END: u32 = 40;
const STEP_S: f64 = 2.5e-3;
const SPEED_M_S: f64 = 20.0;

/// Input that has the pulse.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Bump {
    Gust,
    Wind,
    Aileron,
}

impl Bump {
    /// Amplitude, small compared with wind and chord: in m/s and rad.
    fn size(self) -> f64 {
        match self {
            Self::Gust | Self::Wind => 0.2,
            Self::Aileron => 1e-2,
        }
    }

    fn add(self, inputs: &mut Inputs, amount: f64) {
        match self {
            Self::Gust => {}
            Self::Wind => inputs.wind_m_s_mut().z += amount,
            Self::Aileron => inputs.flaps_mut()[0].command_rad += amount,
        }
    }
}

/// `(1 − cos)/2` over [`BUMP`] steps.
fn bump(step: u32) -> f64 {
    if step < BUMP { 0.5 * (1.0 - (std::f64::consts::TAU * f64::from(step) / f64::from(BUMP)).cos()) } else { 0.0 }
}

/// A wing and its mesh.
#[derive(Clone, Copy, Debug)]
struct Wing {
    fold_deg: f64,
    incidence_deg: f64,
    suction: bool,
    /// Strips of the inner wing and of the tip.
    strips: [usize; 2],
}

/// The shipped wing with a folding tip and an aileron, with a vortex lattice, the tip held at an angle. The gust travels with the wind and
/// reaches the foremost line of the lattice at time 0.
fn machine(wing: Wing, gust_m_s: f64) -> Machine {
    let Wing { fold_deg, incidence_deg, suction, strips } = wing;
    // the edges of a coarse tip's strips coincide with those of its aileron
    let aileron_m = if strips[1] < 8 { [0.1, 0.3] } else { [0.05, 0.35] };
    let text = include_str!("../../../examples/aileron/folding_aileron.toml");
    let way_m = SPEED_M_S * STEP_S;
    let rows: Vec<String> = (0..=BUMP).map(|i| format!("[{:?}, {:?}]", f64::from(i) * way_m, bump(i))).collect();
    let text = text
        .replace("start_angle_deg = 0.0", &format!("start_angle_deg = {fold_deg:?}"))
        .replace("incidence_deg = 2.0", &format!("incidence_deg = {incidence_deg:?}"))
        .replace("strips = 6\n", &format!("strips = {}\nchord_panels = 4\n", strips[0]))
        .replace("strips = 8\n", &format!("strips = {}\nchord_panels = 4\n", strips[1]))
        .replace("from_m = 0.05", &format!("from_m = {:?}", aileron_m[0]))
        .replace("to_m = 0.35", &format!("to_m = {:?}", aileron_m[1]))
        .replace("indicial = \"fine\"\n", "")
        .replace(
            "model = \"strip\"\n",
            &format!(
                "model = \"uvlm\"\nstep_s = {STEP_S:?}\nwake_rows = 44\ncoupling_tolerance = 1e-9\nmirror_normal = [1.0, 0.0, 0.0]\n\
                 leading_edge_suction = {suction}\n"
            ),
        );
    let text = text.replace(
        "[simulation]",
        &format!(
            "[gust.bump]\nshape = \"table\"\ntable = [{}]\nvelocity_m_s = [0.0, 0.0, {gust_m_s:?}]\n\
             origin_m = [0.0, {:?}, 0.0]\n[simulation]",
            rows.join(", "),
            // a quarter of the first panel behind the leading edge
            (0.07 - 0.2 / 16.0) * incidence_deg.to_radians().cos(),
        ),
    );
    config::parse(&text, "wing.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Height of the tip, bending strain and hinge moment.
fn read(outputs: &Outputs) -> DVector<f64> {
    DVector::from_vec(vec![outputs.tips()[0].position_m.z, outputs.gauges()[0], outputs.flaps()[0].hinge_moment_n_m])
}

fn started(machine: Machine) -> Plant {
    let mut plant = Plant::new(Arc::new(machine));
    plant.parameters_mut().solver_mut().tolerance = 1e-9;
    // the first response to a jump contains frequencies that steps of the aerodynamic length do not resolve
    plant.parameters_mut().solver_mut().max_step_s = STEP_S / 8.0;
    plant.initialize(0.0).unwrap_or_else(|error| panic!("{error}"));
    plant
}

/// Outputs of the simulated machine at the ends of the steps.
fn marched(wing: Wing, kind: Bump, size: f64) -> Vec<DVector<f64>> {
    let gust_m_s = if kind == Bump::Gust { size } else { 0.0 };
    let mut plant = started(machine(wing, gust_m_s));
    let kept = plant.inputs().clone();
    (0..END)
        .map(|i| {
            plant.inputs_mut().clone_from(&kept);
            kind.add(plant.inputs_mut(), size * bump(i + 1));
            plant.step(f64::from(i + 1) * STEP_S).unwrap_or_else(|error| panic!("{error}"));
            read(plant.outputs())
        })
        .collect()
}

/// Outputs of the linear model at the ends of the steps.
fn linear(model: &SampledSpace, size: f64) -> Vec<DVector<f64>> {
    let m = &model.matrices;
    let mut x = DVector::zeros(m.a.nrows());
    (0..END)
        .map(|i| {
            let u = DVector::from_element(1, size * bump(i + 1));
            x = &m.a * &x + &m.b * &u;
            &m.c * &x + &m.d * &u
        })
        .collect()
}

/// Linear model of one input.
fn model(wing: Wing, kind: Bump) -> SampledSpace {
    let mut plant = started(machine(wing, 0.0));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let add = |inputs: &mut Inputs, amount: f64| kind.add(inputs, amount);
    let gust_m_s = if kind == Bump::Gust { Vector3::z() } else { Vector3::zeros() };
    let input = InputSlope { add: &add, step: 1e-3, gust_m_s };
    plant.study().lattice_space(&[input], &read).unwrap_or_else(|error| panic!("{error}"))
}

/// The part of a simulated response that is odd in the input, divided by the input: the even part is nonlinear.
fn odd(wing: Wing, kind: Bump, size: f64) -> Vec<DVector<f64>> {
    let [above, below] = [size, -size].map(|size| marched(wing, kind, size));
    above.iter().zip(&below).map(|(above, below)| (above - below) / (2.0 * size)).collect()
}

/// Largest difference of each output relative to its largest value.
fn off(expected: &[DVector<f64>], found: &[DVector<f64>]) -> [f64; 3] {
    std::array::from_fn(|output| {
        let size = expected.iter().map(|y| y[output].abs()).fold(0.0, f64::max);
        let off = expected.iter().zip(found).map(|(expected, found)| (expected[output] - found[output]).abs());
        off.fold(0.0, f64::max) / size
    })
}

/// Folded by 60° with leading-edge suction and deployed without: tip, root strain and hinge moment after a travelling gust and after
/// an aileron deflection. The wake is longer than the record: in time its last ring grows, in the linear model it always extends far.
#[test]
fn q71_small_inputs_move_the_linear_lattice_as_the_machine() {
    for (fold_deg, suction) in [(60.0, true), (0.0, false)] {
        for kind in [Bump::Gust, Bump::Aileron] {
            if !is_whole() && !suction {
                continue;
            }
            let wing = Wing { fold_deg, incidence_deg: 0.0, suction, strips: [6, 8] };
            let found = off(&linear(&model(wing, kind), 1.0), &odd(wing, kind, kind.size()));
            println!("Q-71 {wing:?}, {kind:?}: off {:.2e} {:.2e} {:.2e}", found[0], found[1], found[2]);
            // hinge moments contain second differences of the structural motion, and so more of its time discretisation error
            let allowed = [1e-4, 1e-4, 5e-4];
            assert!(found.iter().zip(allowed).all(|(off, allowed)| *off < allowed), "{wing:?} {kind:?}: {found:?}");
        }
    }
}

/// Q-71 with lift, at 6° and in full studies also at 2° of incidence: folded by 60° and deployed, on a coarse mesh, after a gust, an upward
/// wind and an aileron deflection; short studies: folded after a gust and the aileron, deployed in an upward wind. Halving the input
/// removes its third-order term. Without the displacements of the wake's nodes the same model is off by a hundred times the tolerance for
/// the folded wing: so lift matters, and the comparison detects it. With a start whose wake begins at the trailing edge, a steady flow
/// different from that of the steps, the folded tip was off by 3e-4 at 6°.
#[test]
#[ignore = "long; `make long` runs it"]
fn q71_with_lift_small_inputs_move_the_linear_lattice_as_the_machine() {
    for incidence_deg in if is_whole() { vec![2.0, 6.0] } else { vec![6.0] } {
        for (fold_deg, suction) in [(60.0, true), (0.0, false)] {
            for kind in [Bump::Gust, Bump::Wind, Bump::Aileron] {
                if !is_whole() && (kind == Bump::Wind) == (fold_deg > 0.0) {
                    continue;
                }
                let wing = Wing { fold_deg, incidence_deg, suction, strips: [3, 4] };
                let mut model = model(wing, kind);
                let expected = linear(&model, 1.0);
                let [whole, half] = [1.0, 0.5].map(|share| odd(wing, kind, share * kind.size()));
                let limit: Vec<_> = whole.iter().zip(&half).map(|(whole, half)| (half * 4.0 - whole) / 3.0).collect();
                let found = off(&expected, &limit);
                let nodes = model.states.iter().enumerate().filter(|(_, (name, _))| name.contains("].position."));
                nodes.for_each(|(state, _)| model.matrices.a.column_mut(state).fill(0.0));
                let frozen = off(&linear(&model, 1.0), &limit);
                println!(
                    "Q-71 {wing:?}, {kind:?}: off {:.2e} {:.2e} {:.2e}, without the nodes {:.2e} {:.2e} {:.2e}",
                    found[0], found[1], found[2], frozen[0], frozen[1], frozen[2]
                );
                // strains and hinge moments have the discretisation error of the structure: with steps of a 32nd and tolerances of 1e-12
                // the latter are off by 4e-4
                let tip = 4e-5;
                let allowed = [tip, 1.5e-4, 2e-3];
                assert!(found.iter().zip(allowed).all(|(off, allowed)| *off < allowed), "{wing:?} {kind:?}: {found:?}");
                assert!(fold_deg == 0.0 || frozen[0].min(frozen[1]) > 100.0 * tip, "{wing:?} {kind:?}: {frozen:?}");
            }
        }
    }
}

/// Growth rate in 1/s and frequency in rad/s of the flutter mode with the linear lattice: the least damped mode in its range.
fn eigenvalue(goland: &Goland, speed_m_s: f64) -> [f64; 2] {
    let machine = Goland { gust_m_s: 0.0, ..*goland }.machine(speed_m_s, |structure| structure);
    let mut plant = Plant::new(Arc::new(machine));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let (modes, _) = plant.study().lattice_modes_and_rest(6).unwrap_or_else(|error| panic!("{error}"));
    let near = modes.iter().map(|mode| mode.eigenvalue_1_s).filter(|value| value.im > 40.0 && value.im < 110.0);
    let found = near.max_by(|a, b| a.re.total_cmp(&b.re)).unwrap_or_else(|| panic!("no mode at {speed_m_s} m/s"));
    [found.re, found.im]
}

/// Flutter speed in m/s and frequency in rad/s between two speeds, by false position and bisection.
fn flutter(goland: &Goland, mut low_m_s: f64, mut high_m_s: f64) -> [f64; 2] {
    let (mut low, mut high) = (eigenvalue(goland, low_m_s), eigenvalue(goland, high_m_s));
    assert!(low[0] < 0.0 && high[0] > 0.0, "no flutter between {low_m_s} and {high_m_s} m/s: {low:?} {high:?}");
    while high_m_s - low_m_s > 1e-4 * low_m_s {
        let share = (low[0] / (low[0] - high[0])).clamp(0.02, 0.98);
        // a little beyond the secant's zero, so that both ends converge
        let side = if share < 0.5 { 1.02 } else { 0.98 };
        let middle_m_s = low_m_s + (high_m_s - low_m_s) * (share * side).clamp(0.01, 0.99);
        let middle = eigenvalue(goland, middle_m_s);
        if middle[0] < 0.0 { (low_m_s, low) = (middle_m_s, middle) } else { (high_m_s, high) = (middle_m_s, middle) }
    }
    [low_m_s, low[1]]
}

/// Goland's wing: flutter with the linear lattice, compared with simulations of the same lattice, with refined meshes, and with the
/// 166 m/s of the literature. Short studies: only the coarsest mesh.
#[test]
fn q72_goland_flutters_in_the_linear_lattice_where_it_does_in_time() {
    let coarse = Goland::lattice(2, 4);
    let found = flutter(&coarse, 165.0, 195.0);
    let marched = coarse.flutter(found[0].round(), 0.03);
    let off: [f64; 2] = std::array::from_fn(|i| found[i] / marched[i] - 1.0);
    println!("Q-72 2 x 4 panels: {found:.3?} (m/s, rad/s), marched {marched:.3?}, {off:+.5?}");
    assert!(off.iter().all(|off| off.abs() < 3e-3), "{off:?}");
    if is_whole() {
        for (air, name) in [(Goland::lattice(4, 8).air, "pressures"), (LATTICE_WITH_SUCTION, "suction")] {
            for (panels, strips) in [(4, 8), (8, 8), (8, 16)] {
                let goland = Goland { air, ..Goland::lattice(panels, strips) };
                let found = flutter(&goland, 150.0, 195.0);
                println!(
                    "Q-72 {name}, {panels} x {strips} panels: {found:.3?}, {:+.4} from 166 m/s",
                    found[0] / 166.0 - 1.0
                );
            }
        }
        let middle = Goland::lattice(4, 8);
        let (found, marched) = (flutter(&middle, 165.0, 195.0), middle.flutter(177.0, 0.03));
        let off: [f64; 2] = std::array::from_fn(|i| found[i] / marched[i] - 1.0);
        println!("Q-72 4 x 8 panels: {found:.3?} (m/s, rad/s), marched {marched:.3?}, {off:+.5?}");
        assert!(off.iter().all(|off| off.abs() < 3e-3), "{off:?}");
    }
}

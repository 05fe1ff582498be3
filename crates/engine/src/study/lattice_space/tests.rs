//! LR-11: the linear model in discrete time in comparison with finite differences of the machine, over one aerodynamic step from states
//! near static equilibrium.

use super::*;
use crate::load::SectionMotion;
use crate::run::Plant;
use crate::signal::Inputs;
use crate::study::Holding;
use crate::system::air::test_wing::{PANELS, STEP_S, STRIPS, WAKE_ROWS, lattice, wing};
use crate::system::outputs::EnergyOutputs;
use crate::system::state::{Snapshot, State};
use std::sync::Arc;

/// Largest difference relative to the scale of a row. Contributions: terms of fourth order in the amplitudes, and the convergence of the
/// coupling divided by the amplitudes.
const TOLERANCE: f64 = 1e-6;

/// The machine in equilibrium after a number of steps that is one less than the rows of its wake, so that the ring of the established flow
/// is the last row of the linear model.
struct AtRest {
    plant: Plant,
    snapshot: Snapshot,
    time_s: f64,
    freedoms: Vec<Freedom>,
    /// Derivatives of the sections' velocities and angular velocities with respect to the rates of the degrees of freedom, six rows each.
    sections_by_rate: DMatrix<f64>,
}

/// Outputs without energies: accounts of work are integrals, not functions of a state.
fn shown(outputs: &Outputs) -> DVector<f64> {
    let mut outputs = outputs.clone();
    *outputs.energy_mut() = EnergyOutputs::default();
    DVector::from_column_slice(outputs.values())
}

/// Rows of the state after a step, by kind.
type Kinds<T> = Vec<(&'static str, T)>;

impl AtRest {
    fn step(&mut self, state: &State, inputs: &dyn Fn(&mut [f64])) -> Kinds<DVector<f64>> {
        self.plant.restore(&Snapshot::of(state)).unwrap_or_else(|error| panic!("{error}"));
        // the structure continues from the accelerations of the changed state
        self.plant.system_mut().settle_present(None).unwrap_or_else(|error| panic!("{error}"));
        let mut settled = self.plant.snapshot().state().clone();
        let State { now, start, ahead, .. } = &mut settled;
        (start.a, ahead.a) = (now.a.clone(), now.a.clone());
        self.plant.restore(&Snapshot::of(&settled)).unwrap_or_else(|error| panic!("{error}"));
        inputs(self.plant.inputs_mut().values_mut());
        self.plant.step(self.time_s + STEP_S).unwrap_or_else(|error| panic!("{error}"));
        let outputs = shown(self.plant.outputs());
        let mut state = self.plant.snapshot().state().clone();
        let pick =
            |vector: &[f64]| DVector::from_iterator(self.freedoms.len(), self.freedoms.iter().map(|f| vector[f.index]));
        let (position, rate) = (pick(&state.now.q), pick(&state.now.v));
        let history = state.air.as_mut().expect("air");
        let six = |force: &Vector3<f64>, moment: &Vector3<f64>| {
            force.iter().chain(moment.iter()).copied().collect::<Vec<_>>()
        };
        let sampled = |of: &dyn Fn(&crate::system::air::Sample) -> [Vector3<f64>; 2]| {
            let both = history.end.iter().map(of);
            DVector::from_vec(both.flat_map(|[one, other]| six(&one, &other)).collect())
        };
        let mean = sampled(&|sample| [sample.mean_m_s, sample.mean_rad_s]);
        let seen = sampled(&|sample| [sample.motion.velocity_m_s, sample.motion.spin_rad_s]);
        let loads = &history.loads;
        let mut load: Vec<f64> = loads.to.iter().flat_map(|load| six(&load.force_n, &load.moment_n_m)).collect();
        let acting = loads.from.iter().zip(&loads.to).zip(&loads.impulsive).map(|((from, to), impulsive)| {
            let force = (from.force_n + to.force_n) * 0.5 + impulsive.force_n;
            six(&force, &((from.moment_n_m + to.moment_n_m) * 0.5 + impulsive.moment_n_m))
        });
        let mut acting: Vec<f64> = acting.flatten().collect();
        let lattice = lattice(&mut state);
        load.extend(lattice.hinges.iter().map(|hinge| hinge.circulatory_n_m));
        acting.extend(lattice.hinges.iter().map(|hinge| hinge.circulatory_n_m + hinge.impulsive_n_m));
        assert_eq!(lattice.wake_rows, WAKE_ROWS + 1);
        let nodes = &lattice.wake_node_m[..WAKE_ROWS * (STRIPS + 1)];
        let nodes: Vec<f64> = nodes.iter().flat_map(|node| [node.x, node.y, node.z]).collect();
        vec![
            ("position", position),
            ("rate", rate),
            ("mean", mean),
            ("seen", seen),
            ("bound", DVector::from_column_slice(&lattice.circulation_m2_s[..PANELS])),
            ("load", DVector::from_vec(load)),
            ("acting", DVector::from_vec(acting)),
            ("wake", DVector::from_column_slice(&lattice.wake_circulation_m2_s[..(WAKE_ROWS - 1) * STRIPS])),
            ("nodes", DVector::from_vec(nodes)),
            ("outputs", outputs),
        ]
    }

    /// Central differences of a step with respect to an amount, extrapolated from this amount, its half and its quarter.
    fn derivative(
        &mut self,
        amount: f64,
        change: &dyn Fn(&mut State, f64),
        inputs: &dyn Fn(&mut [f64], f64),
    ) -> Kinds<DVector<f64>> {
        let base = self.snapshot.state().clone();
        let mut difference = |amount: f64| {
            let [above, below] = [amount, -amount].map(|amount| {
                let mut beside = base.clone();
                change(&mut beside, amount);
                self.step(&beside, &|values| inputs(values, amount))
            });
            above
                .into_iter()
                .zip(below)
                .map(|((kind, above), (_, below))| (kind, (above - below) / (2.0 * amount)))
                .collect()
        };
        let [whole, half, quarter]: [Kinds<DVector<f64>>; 3] = [1.0, 0.5, 0.25].map(|share| difference(share * amount));
        let extrapolated =
            whole.into_iter().zip(half).zip(quarter).map(|(((kind, whole), (_, half)), (_, quarter))| {
                let [first, second] = [(&half * 4.0 - whole) / 3.0, (quarter * 4.0 - &half) / 3.0];
                (kind, (second * 16.0 - first) / 15.0)
            });
        extrapolated.collect()
    }
}

/// Change of the model's state by an amount.
type Change = Box<dyn Fn(&mut State, f64)>;

/// Change of the machine's state that corresponds to one state or input of the linear model.
struct Column {
    kind: &'static str,
    /// Column of `A` or, if `is_input`, of `B`.
    place: usize,
    is_input: bool,
    amount: f64,
    change: Change,
}

/// The states of the linear model that affect the next step, and their counterparts.
fn columns(rest: &mut AtRest, layout: &Layout) -> Vec<Column> {
    let mut list = Vec::new();
    let mut add = |kind, place, amount, change: Change| {
        list.push(Column { kind, place, is_input: false, amount, change });
    };
    let n = rest.freedoms.len();
    for j in 0..n {
        let freedom = &rest.freedoms[j];
        let mut study = rest.plant.study();
        // the coordinates are independent and determine the motion of the sections
        let unit = study.direction(freedom);
        let now = study.system.state.now.q.clone();
        let places = move |amount: f64, study: &mut Study| -> Vec<SectionMotion> {
            let q: Vec<f64> = now.iter().zip(&unit).map(|(q, unit)| q + amount * unit).collect();
            study.sections_at(&q, None, None).into_iter().map(|(motion, _)| motion).collect()
        };
        let amount = 1e-2 * if freedom.unit == "1/m" { 5.0 } else { 1.0 };
        // the values for all amounts of the differences
        let shares = [1.0, 0.5, 0.25, -1.0, -0.5, -0.25];
        let at: Vec<(f64, Vec<SectionMotion>)> =
            shares.iter().map(|share| (share * amount, places(share * amount, &mut study))).collect();
        let unit = study.direction(freedom);
        let by_rate = unit.clone();
        let position = move |state: &mut State, amount: f64| {
            for point in [&mut state.start, &mut state.ahead, &mut state.now] {
                point.q.iter_mut().zip(&unit).for_each(|(q, unit)| *q += amount * unit);
            }
            let moved = &at.iter().find(|(there, _)| *there == amount).expect("an amount").1;
            for (sample, moved) in state.air.as_mut().expect("air").end.iter_mut().zip(moved) {
                (sample.motion.position_m, sample.motion.rotation) = (moved.position_m, moved.rotation);
            }
        };
        add("position", layout.position.start + j, amount, Box::new(position));
        let rate = move |state: &mut State, amount: f64| {
            for point in [&mut state.start, &mut state.ahead, &mut state.now] {
                point.v.iter_mut().zip(&by_rate).for_each(|(v, unit)| *v += amount * unit);
            }
        };
        add("rate", layout.rate.start + j, 10.0 * amount, Box::new(rate));
        for (kind, first) in [("mean", layout.mean.start), ("seen", layout.seen.start)] {
            let along = rest.sections_by_rate.column(j).into_owned();
            let change = move |state: &mut State, amount: f64| {
                let samples = state.air.as_mut().expect("air").end.iter_mut();
                for (sample, along) in samples.zip(along.as_slice().chunks_exact(6)) {
                    let [velocity, spin] =
                        [&along[..3], &along[3..]].map(|part| Vector3::from_column_slice(part) * amount);
                    if kind == "mean" {
                        sample.mean_m_s += velocity;
                        sample.mean_rad_s += spin;
                    } else {
                        sample.motion.velocity_m_s += velocity;
                        sample.motion.spin_rad_s += spin;
                    }
                }
            };
            add(kind, first + j, 10.0 * amount, Box::new(change));
        }
    }
    for panel in 0..PANELS {
        let change = move |state: &mut State, amount: f64| {
            let rings = &mut lattice(state).circulation_m2_s;
            rings[panel] += amount;
            // the ring after the trailing edge has the circulation of the panel before it
            if panel >= PANELS - STRIPS {
                rings[panel + STRIPS] += amount;
            }
        };
        add("bound", layout.bound.start + panel, 0.1, Box::new(change));
    }
    for row in 0..layout.load.len() - 1 {
        let change = move |state: &mut State, amount: f64| {
            let load = &mut state.air.as_mut().expect("air").loads.to[row / ENTRIES];
            if row % ENTRIES < 3 { load.force_n[row % 3] += amount } else { load.moment_n_m[row % 3] += amount }
        };
        add("load", layout.load.start + row, 0.1, Box::new(change));
    }
    for place in 0..(WAKE_ROWS - 1) * STRIPS {
        // the last row of the linear model has the length of all remaining rows
        let is_last = place / STRIPS == WAKE_ROWS - 2;
        let change = move |state: &mut State, amount: f64| {
            let rings = &mut lattice(state).wake_circulation_m2_s;
            rings[place] += amount;
            if is_last {
                rings[place + STRIPS] += amount;
            }
        };
        add("wake", layout.wake.start + place, 0.1, Box::new(change));
    }
    let wide = STRIPS + 1;
    for place in 0..3 * wide * WAKE_ROWS {
        let (row, column) = (place / (3 * wide), place / 3 % wide);
        let change = move |state: &mut State, amount: f64| {
            let nodes = &mut lattice(state).wake_node_m;
            // in the linear model the last two rows of nodes are the ends of one straight row of rings, which corresponds to two rows in
            // the machine
            let [begin, joint, end] = [WAKE_ROWS - 2, WAKE_ROWS - 1, WAKE_ROWS].map(|row| row * wide + column);
            let share = (nodes[joint] - nodes[begin]).norm() / (nodes[end] - nodes[begin]).norm();
            let moved = if row < WAKE_ROWS - 1 { row * wide + column } else { end };
            nodes[moved][place % 3] += amount;
            if moved == begin {
                nodes[joint][place % 3] += (1.0 - share) * amount;
            } else if moved == end {
                nodes[joint][place % 3] += share * amount;
            }
        };
        add("nodes", layout.edge.start + place, 2e-3, Box::new(change));
    }
    list
}

/// LR-11. `A`, `B` and their products with `C` and `D`, by kind: a separate change of each state and input, in the linear model and in the
/// machine. The displacement of the air in a step, 0.6 panels, lies between two rows of the table for (U9), at which the left and right
/// derivatives differ.
#[test]
fn a_step_of_the_linear_lattice_is_the_machines() {
    let mut plant = Plant::new(Arc::new(wing()));
    plant.study().equilibrium(0.0, Holding::AsReleased).unwrap_or_else(|error| panic!("{error}"));
    let inputs = plant.inputs().values().len();
    let adders: Vec<_> =
        (0..inputs).map(|place| move |inputs: &mut Inputs, amount: f64| inputs.values_mut()[place] += amount).collect();
    let slopes: Vec<InputSlope> =
        adders.iter().map(|add| InputSlope { add, step: 1e-3, gust_m_s: Vector3::zeros() }).collect();
    let SampledSpace { matrices, .. } =
        plant.study().lattice_space(&slopes, &shown).unwrap_or_else(|error| panic!("{error}"));
    let freedoms = plant.freedoms();
    let sampled = plant.study().sampled_lattice(false).unwrap_or_else(|error| panic!("{error}"));
    let layout = Layout::new(freedoms.len(), &sampled.slopes);
    assert!(!layout.node.is_empty(), "lift");
    let [_, by_rate, _] = plant.study().section_slopes(&freedoms);
    let sections = by_rate.nrows() / SECTION_VARIABLES;
    let velocities =
        (0..sections).flat_map(|section| SECTION_VARIABLES * section + 6..SECTION_VARIABLES * section + 12);
    let sections_by_rate = by_rate.select_rows(&velocities.collect::<Vec<_>>());
    let time_s = (WAKE_ROWS - 1) as f64 * STEP_S;
    plant.step(time_s).unwrap_or_else(|error| panic!("{error}"));
    let mut state = plant.snapshot().state().clone();
    let displacement_m = plant.inputs().wind_m_s() * (STEP_S * WAKE_ROWS as f64);
    // the far end has moved with the wind, while that of the linear model is fixed
    let wide = STRIPS + 1;
    let nodes = &mut lattice(&mut state).wake_node_m;
    nodes[WAKE_ROWS * wide..][..wide].iter_mut().for_each(|node| *node -= displacement_m);
    let snapshot = Snapshot::of(&state);
    let mut rest = AtRest { plant, snapshot, time_s, freedoms, sections_by_rate };
    let mut list = columns(&mut rest, &layout);
    let nothing = |_: &mut State, _: f64| {};
    // switches are not real inputs
    for place in [0, 1].into_iter().chain(5..inputs) {
        list.push(Column { kind: "input", place, is_input: true, amount: 1e-2, change: Box::new(nothing) });
    }

    // rows of the linear model, kind by kind
    let of_outputs = [&matrices.c * &matrices.a, &matrices.c * &matrices.b + &matrices.d];
    let linear = |column: &Column| -> Kinds<DVector<f64>> {
        let whole = if column.is_input { &matrices.b } else { &matrices.a }.column(column.place).into_owned();
        let part = |rows: &Range<usize>| whole.rows(rows.start, rows.len()).into_owned();
        let nodes = layout.edge.start..layout.edge.start + 3 * WAKE_ROWS * (STRIPS + 1);
        vec![
            ("position", part(&layout.position)),
            ("rate", part(&layout.rate)),
            ("mean", &rest.sections_by_rate * part(&layout.mean)),
            ("seen", &rest.sections_by_rate * part(&layout.seen)),
            ("bound", part(&layout.bound)),
            ("load", part(&layout.load)),
            ("acting", part(&layout.acting)),
            ("wake", part(&(layout.wake.start..layout.wake.end - STRIPS))),
            ("nodes", part(&nodes)),
            ("outputs", of_outputs[usize::from(column.is_input)].column(column.place).into_owned()),
        ]
    };
    let expected: Vec<_> = list.iter().map(linear).collect();
    let found: Vec<_> = list
        .iter()
        .map(|column| {
            let (is_input, place) = (column.is_input, column.place);
            rest.derivative(column.amount, &column.change, &move |values, amount| {
                if is_input {
                    values[place] += amount;
                }
            })
        })
        .collect();
    let (mut worst, mut told) = (0.0f64, String::new());
    let mut kinds: Vec<&str> = list.iter().map(|column| column.kind).collect();
    kinds.dedup();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        let own: Vec<usize> = (0..list.len()).filter(|&j| list[j].kind == kind).collect();
        for rows in 0..expected[0].len() {
            let count = expected[0][rows].1.len();
            let size = |i: usize| own.iter().map(|&j| found[j][rows].1[i].abs() * list[j].amount).fold(0.0, f64::max);
            let largest = (0..count).map(size).fold(0.0, f64::max);
            let (mut off, mut at) = (0.0f64, (0, 0));
            for i in 0..count {
                // at least the round-off of rows without a response
                let scale = size(i).max(1e-2 * largest).max(1e-6);
                for &j in &own {
                    let this = (found[j][rows].1[i] - expected[j][rows].1[i]).abs() * list[j].amount / scale;
                    if this > off {
                        (off, at) = (this, (i, j));
                    }
                }
            }
            let (i, j) = at;
            let Column { place, .. } = list[j];
            told += &format!(
                "{} by {kind}: off {off:.1e} at row {i}, column {place}: {:e} for {:e}\n",
                expected[0][rows].0, expected[j][rows].1[i], found[j][rows].1[i]
            );
            worst = worst.max(off);
        }
    }
    assert!(worst < TOLERANCE, "{worst:e}\n{told}");
}

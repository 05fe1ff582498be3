//! The sections on which air acts: their displacements by the coordinates, and their loads on them.

use crate::load::Wrench;
use crate::math::difference::SIXTH_ORDER;
use crate::multibody::derivative::{to_freedoms, to_multipliers, to_turning};
use crate::multibody::joint::{Joint, RedundantWork};
use crate::multibody::kinematics::{Motion, sweep_motion, sweep_poses};
use crate::multibody::{Workspace, dynamics, station};
use crate::system::equations::Equations;
use nalgebra::{Matrix3, Vector3};

/// Entries of a section: of a load, or of a displacement and rotation.
const ENTRIES: usize = 6;

/// Entries of a section whose model uses its velocities: the same, velocity and angular velocity.
const WITH_RATES: usize = 12;
/// Rotation in rad, or displacement over the machine's length, of the difference steps along the motion.
const STEP: f64 = 2e-3;

/// Scratch of the sweeps.
pub(super) struct Sections {
    /// Whether the model uses velocities at the instant.
    with_rates: bool,
    work: Workspace,
    loads: Vec<Wrench>,
    zeros: Vec<f64>,
    /// Rows of loads.
    rows: Vec<f64>,
}

impl Sections {
    pub fn new(equations: &Equations, with_rates: bool) -> Self {
        Self {
            with_rates,
            work: Workspace::new(&equations.model),
            loads: vec![Wrench::default(); equations.stations.len()],
            zeros: vec![0.0; equations.model.coordinates],
            rows: vec![0.0; equations.model.coordinates],
        }
    }

    /// Entries of the loads of all sections.
    pub fn entries(&self, equations: &Equations) -> usize {
        ENTRIES * (self.loads.len() - equations.load_stations)
    }

    /// Puts the nodes to their places.
    pub fn place(&mut self, equations: &Equations, q: &[f64]) {
        sweep_poses(&equations.model, &mut self.work, q);
    }

    /// Attitude, displacement and rotation of each section by a change of the degrees of freedom, root frame.
    fn moved<'s>(
        &'s mut self,
        equations: &'s Equations,
        q: &'s [f64],
        change: &'s mut [f64],
    ) -> impl Iterator<Item = (Matrix3<f64>, [Vector3<f64>; 2])> + 's {
        let model = &equations.model;
        self.convert(equations, to_turning, change);
        // velocities are linear in the rates by the same columns
        let motion = Motion { q, v: change, a: &self.zeros };
        sweep_motion(model, &mut self.work, motion);
        let work = &self.work;
        model.stations[equations.load_stations..].iter().map(move |place| {
            let moved = station::motion(model, work, motion, place);
            (moved.rotation, [moved.velocity_m_s, moved.spin_rad_s])
        })
    }

    /// Converts the entries of joints with redundant parameters, at the poses of the last sweep. Loads have rows by the degrees of freedom,
    /// eq. (J5), so that displacements and their transpose use these too.
    fn convert(&self, equations: &Equations, by: impl Fn(&Joint, &RedundantWork, &mut [f64]), entries: &mut [f64]) {
        for (body, joint) in equations.model.bodies.iter().zip(&self.work.joints) {
            if let Some(redundant) = joint.redundant() {
                by(&body.joint, redundant, entries);
            }
        }
    }

    /// Displacements and rotations of the sections by a change of the coordinates, root frame.
    fn displacements(&mut self, equations: &Equations, q: &[f64], change: &[f64]) -> Vec<f64> {
        let mut change = change.to_vec();
        self.place(equations, q);
        self.convert(equations, to_freedoms, &mut change);
        let moved = self.moved(equations, q, &mut change);
        moved.flat_map(|(_, parts)| parts.into_iter().flat_map(<[f64; 3]>::from)).collect()
    }

    /// Displacements and rotations of the sections by a change of the coordinates, root frame. If the model uses velocities, also their
    /// changes, by changes of the rates too, eq. (X37).
    pub fn poses(
        &mut self,
        equations: &mut Equations,
        [q, v]: [&[f64]; 2],
        [change_q, change_v]: [&[f64]; 2],
    ) -> Vec<f64> {
        let poses = self.displacements(equations, q, change_q);
        if !self.with_rates {
            return poses;
        }
        let mut rates = self.displacements(equations, q, change_v);
        for (place, weight) in along_motion(equations, q, v) {
            let there = self.displacements(equations, &place, change_q);
            rates.iter_mut().zip(there).for_each(|(sum, entry)| *sum += weight * entry);
        }
        let motion = self.displacements(equations, q, v);
        let each = poses.chunks_exact(ENTRIES).zip(rates.chunks_exact(ENTRIES)).zip(motion.chunks_exact(ENTRIES));
        each.flat_map(|((pose, rate), motion)| {
            let [turn, spin] = [pose, motion].map(|entries| Vector3::from_column_slice(&entries[3..]));
            let mut all = [0.0; WITH_RATES];
            all[..ENTRIES].copy_from_slice(pose);
            all[ENTRIES..].copy_from_slice(rate);
            all[ENTRIES + 3..].iter_mut().zip(&turn.cross(&spin)).for_each(|(sum, entry)| *sum += entry);
            all
        })
        .collect()
    }

    /// The transpose of [`Self::poses`]: multipliers of coordinates and rates.
    pub fn on_motion(&mut self, equations: &mut Equations, [q, v]: [&[f64]; 2], on: &[f64]) -> [Vec<f64>; 2] {
        if !self.with_rates {
            return [self.on_coordinates(equations, q, on), self.zeros.clone()];
        }
        let motion = self.displacements(equations, q, v);
        let (mut on_poses, mut on_rates) = (Vec::new(), Vec::new());
        for (on, motion) in on.chunks_exact(WITH_RATES).zip(motion.chunks_exact(ENTRIES)) {
            let spin = Vector3::from_column_slice(&motion[3..]);
            let turned = spin.cross(&Vector3::from_column_slice(&on[ENTRIES + 3..]));
            on_poses.extend_from_slice(&on[..3]);
            on_poses.extend(on[3..ENTRIES].iter().zip(&turned).map(|(on, turned)| on + turned));
            on_rates.extend_from_slice(&on[ENTRIES..]);
        }
        let mut on_q = self.on_coordinates(equations, q, &on_poses);
        for (place, weight) in along_motion(equations, q, v) {
            let there = self.on_coordinates(equations, &place, &on_rates);
            on_q.iter_mut().zip(there).for_each(|(sum, entry)| *sum += weight * entry);
        }
        [on_q, self.on_coordinates(equations, q, &on_rates)]
    }

    /// Adds the multipliers of the loads, in the frames of the sections, by those of the residual: `−r_ℓᵀ w`.
    pub fn add_on_loads(&mut self, equations: &Equations, q: &[f64], w: &[f64], sum: &mut [f64]) {
        self.place(equations, q);
        let mut change = w.to_vec();
        for ((rotation, parts), sum) in self.moved(equations, q, &mut change).zip(sum.chunks_exact_mut(ENTRIES)) {
            for (part, sum) in parts.iter().zip(sum.chunks_exact_mut(3)) {
                sum.iter_mut().zip(&rotation.tr_mul(part)).for_each(|(sum, part)| *sum += part);
            }
        }
    }

    /// Adds the rows of loads, in the frames of the sections, in the residual; the nodes are in their places.
    pub fn add_rows(&mut self, equations: &Equations, q: &[f64], loads: &[f64], rows: &mut [f64]) {
        self.find_rows(equations, q, loads);
        rows.iter_mut().zip(&self.rows).for_each(|(row, own)| *row += own);
    }

    /// Computes the rows of loads; the nodes are in their places.
    fn find_rows(&mut self, equations: &Equations, q: &[f64], loads: &[f64]) {
        let own = &mut self.loads[equations.load_stations..];
        for (load, entries) in own.iter_mut().zip(loads.chunks_exact(ENTRIES)) {
            load.force_n.copy_from_slice(&entries[..3]);
            load.moment_n_m.copy_from_slice(&entries[3..]);
        }
        self.rows.fill(0.0);
        dynamics::project_loads(&equations.model, &mut self.work, q, &self.loads, &mut self.rows);
    }

    /// Multipliers of the coordinates by those of displacements and rotations of the sections.
    fn on_coordinates(&mut self, equations: &Equations, q: &[f64], on: &[f64]) -> Vec<f64> {
        let rotations: Vec<Matrix3<f64>> = {
            self.place(equations, q);
            let mut zeros = self.zeros.clone();
            self.moved(equations, q, &mut zeros).map(|(rotation, _)| rotation).collect()
        };
        let local: Vec<f64> = rotations
            .iter()
            .zip(on.chunks_exact(ENTRIES))
            .flat_map(|(rotation, on)| {
                let local = |part: &[f64]| <[f64; 3]>::from(rotation.tr_mul(&Vector3::from_column_slice(part)));
                [local(&on[..3]), local(&on[3..])].concat()
            })
            .collect();
        self.find_rows(equations, q, &local);
        let mut rows = std::mem::take(&mut self.rows);
        self.convert(equations, to_multipliers, &mut rows);
        let on = rows.iter().map(|row| -row).collect();
        self.rows = rows;
        on
    }
}

/// Coordinates on both sides along the motion, with weights of sixth-order differences, for the rate of a function of them.
fn along_motion(equations: &mut Equations, q: &[f64], v: &[f64]) -> Vec<(Vec<f64>, f64)> {
    let size = equations.size_of(v);
    if size.is_nan() || size <= 0.0 {
        return Vec::new();
    }
    let step_s = STEP / size;
    let sides = (1..).map(f64::from).zip(SIXTH_ORDER).flat_map(|(steps, weight)| [(steps, weight), (-steps, -weight)]);
    sides
        .map(|(steps, weight)| {
            let place = q.iter().zip(v).map(|(q, v)| q + steps * step_s * v).collect();
            (place, weight / (60.0 * step_s))
        })
        .collect()
}

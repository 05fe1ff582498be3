//! The sections on which air acts: their displacements by the coordinates, and their loads on them.

use crate::load::Wrench;
use crate::multibody::kinematics::{Motion, sweep_motion, sweep_poses};
use crate::multibody::{Workspace, dynamics, station};
use crate::system::equations::Equations;
use nalgebra::{Matrix3, Vector3};

/// Entries of a section: of a load, or of a displacement and rotation.
const ENTRIES: usize = 6;

/// Scratch of the sweeps.
pub(super) struct Sections {
    work: Workspace,
    loads: Vec<Wrench>,
    zeros: Vec<f64>,
}

impl Sections {
    pub fn new(equations: &Equations) -> Self {
        Self {
            work: Workspace::new(&equations.model),
            loads: vec![Wrench::default(); equations.stations.len()],
            zeros: vec![0.0; equations.model.coordinates],
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

    /// Attitude, displacement and rotation of each section by a change of the coordinates, root frame.
    fn moved<'s>(
        &'s mut self,
        equations: &'s Equations,
        q: &'s [f64],
        change: &'s [f64],
    ) -> impl Iterator<Item = (Matrix3<f64>, [Vector3<f64>; 2])> + 's {
        let model = &equations.model;
        // velocities are linear in the rates by the same columns
        let motion = Motion { q, v: change, a: &self.zeros };
        sweep_motion(model, &mut self.work, motion);
        let work = &self.work;
        model.stations[equations.load_stations..].iter().map(move |place| {
            let moved = station::motion(model, work, motion, place);
            (moved.rotation, [moved.velocity_m_s, moved.spin_rad_s])
        })
    }

    /// Displacements and rotations of the sections by a change of the coordinates, root frame.
    pub fn poses(&mut self, equations: &Equations, q: &[f64], change: &[f64]) -> Vec<f64> {
        let moved = self.moved(equations, q, change);
        moved.flat_map(|(_, parts)| parts.into_iter().flat_map(<[f64; 3]>::from)).collect()
    }

    /// Adds the multipliers of the loads, in the frames of the sections, by those of the residual: `−r_ℓᵀ w`.
    pub fn add_on_loads(&mut self, equations: &Equations, q: &[f64], w: &[f64], sum: &mut [f64]) {
        for ((rotation, parts), sum) in self.moved(equations, q, w).zip(sum.chunks_exact_mut(ENTRIES)) {
            for (part, sum) in parts.iter().zip(sum.chunks_exact_mut(3)) {
                sum.iter_mut().zip(&rotation.tr_mul(part)).for_each(|(sum, part)| *sum += part);
            }
        }
    }

    /// Adds the rows of loads, in the frames of the sections, in the residual; the nodes are in their places.
    pub fn add_rows(&mut self, equations: &Equations, q: &[f64], loads: &[f64], rows: &mut [f64]) {
        let own = &mut self.loads[equations.load_stations..];
        for (load, entries) in own.iter_mut().zip(loads.chunks_exact(ENTRIES)) {
            load.force_n.copy_from_slice(&entries[..3]);
            load.moment_n_m.copy_from_slice(&entries[3..]);
        }
        dynamics::project_loads(&equations.model, &mut self.work, q, &self.loads, rows);
    }

    /// Multipliers of the coordinates by those of displacements and rotations of the sections.
    pub fn on_coordinates(&mut self, equations: &Equations, q: &[f64], on: &[f64]) -> Vec<f64> {
        let rotations: Vec<Matrix3<f64>> = {
            let zeros = self.zeros.clone();
            self.moved(equations, q, &zeros).map(|(rotation, _)| rotation).collect()
        };
        let local: Vec<f64> = rotations
            .iter()
            .zip(on.chunks_exact(ENTRIES))
            .flat_map(|(rotation, on)| {
                let local = |part: &[f64]| <[f64; 3]>::from(rotation.tr_mul(&Vector3::from_column_slice(part)));
                [local(&on[..3]), local(&on[3..])].concat()
            })
            .collect();
        let mut rows = self.zeros.clone();
        self.add_rows(equations, q, &local, &mut rows);
        rows.iter_mut().for_each(|row| *row = -*row);
        rows
    }
}

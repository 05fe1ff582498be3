//! STUB
#![allow(missing_docs, unused)]
use crate::aero::flow::Flow;
use crate::aero::surface::Surface;
use crate::aero::*;
use serde::{Deserialize, Serialize};
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WakeModel {
    Prescribed,
    Free,
}
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoadRule {
    Bernoulli,
    KuttaJoukowski,
}
#[derive(Debug, Clone, PartialEq)]
pub struct LatticeOptions {
    pub wake: WakeModel,
    pub wake_rows: usize,
    pub core_radius_m: f64,
    pub load_rule: LoadRule,
    pub mirror_normal: Option<Vector3<f64>>,
    pub threads: usize,
}
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LatticeState {}
#[derive(Debug, thiserror::Error)]
#[error("x")]
pub struct SingularLattice;
pub struct VortexLattice {}
impl LatticeState {
    pub fn copy_from(&mut self, _o: &Self) {}
    pub fn fits(&self, _o: &Self) -> bool {
        true
    }
}
impl VortexLattice {
    pub fn new(_s: Vec<Surface>, _o: LatticeOptions) -> Self {
        Self {}
    }
    pub fn blank_state(&self) -> LatticeState {
        LatticeState {}
    }
    pub fn start(
        &mut self,
        m: &[SectionMotion],
        f: &Flow,
        e: bool,
        s: &mut LatticeState,
        l: &mut AirLoads,
    ) -> Result<(), SingularLattice> {
        l.clear();
        Ok(())
    }
    pub fn convect(&mut self, a: &LatticeState, f: &Flow, h: f64, b: &mut LatticeState) {}
    pub fn solve(
        &mut self,
        a: &LatticeState,
        m: &[SectionMotion],
        f: &Flow,
        h: f64,
        b: &mut LatticeState,
        l: &mut AirLoads,
    ) -> Result<(), SingularLattice> {
        l.clear();
        Ok(())
    }
    pub fn strip_circulation(&self, s: &LatticeState, a: usize, b: usize) -> f64 {
        0.0
    }
}

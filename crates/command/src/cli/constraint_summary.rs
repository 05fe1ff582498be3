//! Constraints between bodies and on planes in the summary of a model: closed loops, skates and wheels.

use foldwing_engine::machine::{Closure, Machine, NoSlip, Runner};
use serde::Serialize;

#[derive(Serialize)]
pub struct LoopSummary {
    name: String,
    bodies: [String; 2],
    positions_m: [f64; 2],
    rigid: bool,
    stiffness_n_m: f64,
    damping_n_s_m: f64,
    inertia_kg: f64,
}

/// A skate or a wheel on its plane.
#[derive(Serialize)]
pub struct NoSlipSummary {
    name: String,
    kind: &'static str,
    body: String,
    position_m: f64,
    radius_m: Option<f64>,
    rolling: bool,
    hold_normal: bool,
}

impl LoopSummary {
    pub fn new(closure: &Closure, machine: &Machine) -> Self {
        Self {
            name: closure.name.clone(),
            bodies: closure.ends.map(|end| {
                end.on_body().map_or_else(|| "root".to_owned(), |(body, _)| machine.bodies[body].name.clone())
            }),
            positions_m: closure.ends.map(|end| end.on_body().map_or(0.0, |(_, position_m)| position_m)),
            rigid: closure.rigid,
            stiffness_n_m: closure.stiffness_n_m,
            damping_n_s_m: closure.damping_n_s_m,
            inertia_kg: closure.inertia_kg,
        }
    }

    pub fn text(&self) -> String {
        let end = |side: usize| match self.bodies[side].as_str() {
            "root" => "root".to_owned(),
            body => format!("{body} at {} m", self.positions_m[side]),
        };
        if self.rigid {
            return format!("  {}: {} to {}, rigid\n", self.name, end(0), end(1));
        }
        format!(
            "  {}: {} to {}, k {} N/m, c {} N.s/m, m {} kg\n",
            self.name,
            end(0),
            end(1),
            self.stiffness_n_m,
            self.damping_n_s_m,
            self.inertia_kg
        )
    }
}

impl NoSlipSummary {
    pub fn new(no_slip: &NoSlip, machine: &Machine) -> Self {
        let (radius_m, rolling) = match no_slip.runner {
            Runner::Skate { .. } => (None, false),
            Runner::Wheel { radius_m, rolling, .. } => (Some(radius_m), rolling),
        };
        Self {
            name: no_slip.name.clone(),
            kind: no_slip.table(),
            body: machine.bodies[no_slip.body].name.clone(),
            position_m: no_slip.position_m,
            radius_m,
            rolling,
            hold_normal: no_slip.hold_normal,
        }
    }

    pub fn text(&self) -> String {
        let radius = self.radius_m.map_or_else(String::new, |radius_m| format!(" of radius {radius_m} m"));
        let rolls = if self.rolling { ", rolling" } else { "" };
        let normal = if self.hold_normal { "held on its plane" } else { "free along the normal of its plane" };
        format!("  {}: {}{radius} on {} at {} m{rolls}, {normal}\n", self.name, self.kind, self.body, self.position_m)
    }
}

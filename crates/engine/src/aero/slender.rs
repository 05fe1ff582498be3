//! Slender bodies: loads of the flow across a body of circular cross-sections that change slowly along it, such as a fuselage, a nacelle or
//! a boom.
//!
//! The air in a plane across the body has the momentum of the apparent mass `ρ A` times the velocity of the section across its axis; its
//! rate, in planes that drift along the body with the flow, is the load per length (Munk, NACA Report 184; Lighthill, J. Fluid Mech. 9):
//! eqs. (W17) to (W20). The theory has no nose and no tail: a body in a flow from behind has the loads of the reversed body.

use crate::aero::AirLoads;
use crate::aero::flow::{AirPath, Flow};
use crate::load::{SectionMotion, Wrench};
use nalgebra::{Rotation3, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Settings of a slender body.
#[derive(Debug, Clone, PartialEq)]
pub struct SlenderBodyOptions {
    /// Index of the body that carries it.
    pub body: usize,
    /// Whether that body is rigid: all sections are then fixed to its frame.
    pub rigid: bool,
    /// Positions of the sections along the body's x axis in m, ascending: the ends of frustums.
    pub positions_m: Vec<f64>,
    /// Radii of the sections in m.
    pub radii_m: Vec<f64>,
    /// Whether the loads include the apparent mass of the air.
    pub apparent_mass: bool,
    /// Drag coefficient of a circular cylinder in the flow across the body, referred to its diameter.
    pub cross_flow_drag_coefficient: f64,
    /// Drag coefficient of the flow along the body, referred to its largest cross-section.
    pub axial_drag_coefficient: f64,
}

impl SlenderBodyOptions {
    /// Positions of the sections along the body in m: of a rigid body, which has a single frame, 0 for all.
    pub fn stations_m(&self) -> Vec<f64> {
        if self.rigid { vec![0.0; self.positions_m.len()] } else { self.positions_m.clone() }
    }

    /// Volume in m³.
    pub fn volume_m3(&self) -> f64 {
        let frustums = self.positions_m.windows(2).zip(self.radii_m.windows(2));
        frustums
            .map(|(ends_m, radii_m)| Frustum::new([ends_m[0], ends_m[1]], [radii_m[0], radii_m[1]]).volume_m3())
            .sum()
    }

    /// Largest radius in m.
    pub fn largest_m(&self) -> f64 {
        self.radii_m.iter().copied().fold(0.0, f64::max)
    }
}

/// State of a slender body on which later loads depend.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct SlenderBodyState {
    /// Momentum of the apparent mass at the sections, divided by the density, root frame, in m⁴/s.
    pub momenta_m4_s: Vec<Vector3<f64>>,
}

impl SlenderBodyState {
    /// Copies another state of the same model without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        self.momenta_m4_s.copy_from_slice(&other.momenta_m4_s);
    }

    /// Whether another state has the same sizes.
    pub fn fits(&self, other: &Self) -> bool {
        self.momenta_m4_s.len() == other.momenta_m4_s.len()
    }
}

/// Part of the body between two sections, whose radius is linear along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frustum {
    /// Integrals along the body of the cross-section times the shape functions `φ₀²`, `φ₀ φ₁`, `φ₁²` in m³.
    pub(super) volumes_m3: [f64; 3],
    /// Cross-sections at the ends in m².
    areas_m2: [f64; 2],
    /// Integrals along the body of the diameter times the shape functions in m².
    sides_m2: [f64; 2],
}

impl Frustum {
    /// Exact integrals of a linear radius.
    fn new(ends_m: [f64; 2], [inner_m, outer_m]: [f64; 2]) -> Self {
        let length_m = ends_m[1] - ends_m[0];
        let (inner_m2, mixed_m2, outer_m2) = (inner_m * inner_m, inner_m * outer_m, outer_m * outer_m);
        Self {
            volumes_m3: [
                inner_m2 / 5.0 + mixed_m2 / 10.0 + outer_m2 / 30.0,
                inner_m2 / 20.0 + mixed_m2 / 15.0 + outer_m2 / 20.0,
                inner_m2 / 30.0 + mixed_m2 / 10.0 + outer_m2 / 5.0,
            ]
            .map(|share_m2| PI * length_m * share_m2),
            areas_m2: [PI * inner_m2, PI * outer_m2],
            sides_m2: [2.0 * inner_m + outer_m, inner_m + 2.0 * outer_m].map(|sum_m| length_m * sum_m / 3.0),
        }
    }

    fn volume_m3(&self) -> f64 {
        let [inner, both, outer] = self.volumes_m3;
        inner + 2.0 * both + outer
    }

    /// Integrals of the slope of the cross-section along the body times the shape functions, in m².
    fn widening_m2(&self, length_m: f64) -> [f64; 2] {
        let mean_m2 = self.volume_m3() / length_m;
        [mean_m2 - self.areas_m2[0], self.areas_m2[1] - mean_m2]
    }
}

/// Velocity of a section relative to the air, along and across a frustum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    /// Velocity of the air along the frustum, from the inner to the outer end, without gusts, in m/s.
    along_m_s: f64,
    /// Velocity of the section across the frustum relative to the air without gusts, in m/s.
    across_m_s: Vector3<f64>,
    /// Velocity of the gusts across the frustum in m/s.
    gust_m_s: Vector3<f64>,
    /// Velocity of the gusts along the frustum in m/s.
    gust_along_m_s: f64,
}

/// Velocity of the air relative to a section, gusts included, about which its drag is linearised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DragPoint {
    /// Across the frustum, in m/s.
    across_m_s: Vector3<f64>,
    /// Along the frustum, in m/s.
    along_m_s: f64,
}

impl DragPoint {
    /// Velocities whose products with the magnitudes at this point are the tangents of `|q| q` at it.
    fn doubled(&self, own: &Self) -> Self {
        let way = self.across_m_s.try_normalize(0.0).unwrap_or_default();
        Self {
            across_m_s: own.across_m_s + way * way.dot(&(own.across_m_s - self.across_m_s)),
            along_m_s: 2.0 * own.along_m_s - self.along_m_s,
        }
    }
}

impl Meeting {
    /// Velocity of the air relative to the section, gusts included.
    pub(super) fn drag_point(&self) -> DragPoint {
        DragPoint { across_m_s: self.gust_m_s - self.across_m_s, along_m_s: self.along_m_s + self.gust_along_m_s }
    }
}

/// A slender body with its frustums.
#[derive(Debug, Clone, PartialEq)]
pub struct SlenderBody {
    pub(super) options: SlenderBodyOptions,
    pub(super) frustums: Vec<Frustum>,
    /// Lengths of the frustums in m.
    pub(super) lengths_m: Vec<f64>,
    /// Largest cross-section divided by the sum of the side areas.
    front_share: f64,
    /// Loads and momenta of the last response at an instant.
    pub(super) loads: AirLoads,
    pub(super) present: SlenderBodyState,
}

impl SlenderBody {
    /// Makes the model; its sections are those of the options, in their order.
    pub fn new(options: &SlenderBodyOptions) -> Self {
        let ends = options.positions_m.windows(2).zip(options.radii_m.windows(2));
        let frustums: Vec<Frustum> =
            ends.map(|(ends_m, radii_m)| Frustum::new([ends_m[0], ends_m[1]], [radii_m[0], radii_m[1]])).collect();
        Self {
            lengths_m: options.positions_m.windows(2).map(|ends_m| ends_m[1] - ends_m[0]).collect(),
            front_share: PI * options.largest_m().powi(2)
                / frustums.iter().flat_map(|frustum| frustum.sides_m2).sum::<f64>(),
            frustums,
            options: options.clone(),
            loads: AirLoads::still(options.positions_m.len()),
            present: SlenderBodyState { momenta_m4_s: vec![Vector3::zeros(); options.positions_m.len()] },
        }
    }

    /// Returns an empty state, to be filled by [`SlenderBody::start`].
    pub fn blank_state(&self) -> SlenderBodyState {
        SlenderBodyState { momenta_m4_s: vec![Vector3::zeros(); self.options.positions_m.len()] }
    }

    /// Sets the initial state and the loads of the present motion; loads of accelerations are zero.
    pub fn start(&self, motions: &[SectionMotion], flow: &Flow, state: &mut SlenderBodyState, loads: &mut AirLoads) {
        loads.clear();
        self.add_flow_loads(motions, flow, &[], state, loads);
    }

    /// Computes state and loads after a step of `step_s` from `from`, for the motions and the flow at its end. The result depends only on
    /// the arguments.
    pub fn solve(
        &self,
        from: &SlenderBodyState,
        motions: &[SectionMotion],
        flow: &Flow,
        step_s: f64,
        to: &mut SlenderBodyState,
        loads: &mut AirLoads,
    ) {
        loads.clear();
        self.add_flow_loads(motions, flow, &[], to, loads);
        if !(self.options.apparent_mass && step_s > 0.0) {
            return;
        }
        for (section, momenta) in from.momenta_m4_s.iter().zip(&to.momenta_m4_s).enumerate() {
            self.add_impulse(section, momenta, motions, (flow, step_s), &mut loads.impulsive[section]);
        }
    }

    /// Adds the load of the mean rate over a step of a section's momentum, whose direction is fixed in the air: eq. (W18).
    pub(super) fn add_impulse(
        &self,
        section: usize,
        (before, after): (&Vector3<f64>, &Vector3<f64>),
        motions: &[SectionMotion],
        (flow, step_s): (&Flow, f64),
        load: &mut Wrench,
    ) {
        let path = AirPath::new(flow, step_s);
        let force_n = (path.turned(before) - after) * (flow.density_kg_m3 / step_s);
        // the load turns with the section during the step, so that it has this direction in the middle
        let half_turn = (motions[section].spin_rad_s + flow.spin_rad_s) * (0.5 * step_s);
        let force_n = Rotation3::new(half_turn) * force_n;
        load.add_force_at(&self.arm_m(section, motions), &force_n);
    }

    /// Vector from the reference point of a section to its centre, root frame, m.
    pub(super) fn arm_m(&self, section: usize, motions: &[SectionMotion]) -> Vector3<f64> {
        let along_m = if self.options.rigid { self.options.positions_m[section] } else { 0.0 };
        motions[section].rotation.column(0) * along_m
    }

    /// Velocities at a section, for a frustum with the unit vector `along`.
    pub(super) fn meet(&self, section: usize, along: &Vector3<f64>, motions: &[SectionMotion], flow: &Flow) -> Meeting {
        let motion = &motions[section];
        let arm_m = self.arm_m(section, motions);
        let centre_m = motion.position_m + arm_m;
        let convection_m_s = flow.convection_m_s(&centre_m);
        let moving_m_s = motion.velocity_m_s + motion.spin_rad_s.cross(&arm_m) - convection_m_s;
        let gust_m_s = flow.velocity_m_s(&centre_m) - convection_m_s;
        let (moving_along_m_s, gust_along_m_s) = (moving_m_s.dot(along), gust_m_s.dot(along));
        Meeting {
            along_m_s: -moving_along_m_s,
            across_m_s: moving_m_s - along * moving_along_m_s,
            gust_m_s: gust_m_s - along * gust_along_m_s,
            gust_along_m_s,
        }
    }

    /// Centres of the sections of a frustum in m, its direction and its length in m.
    pub(super) fn axis(&self, inner: usize, motions: &[SectionMotion]) -> ([Vector3<f64>; 2], Vector3<f64>, f64) {
        let centres_m = [inner, inner + 1].map(|section| motions[section].position_m + self.arm_m(section, motions));
        let axis_m = centres_m[1] - centres_m[0];
        let length_m = axis_m.norm();
        (centres_m, axis_m / length_m, length_m)
    }

    /// Adds all loads but those of accelerations, and writes the momenta of the apparent mass: eqs. (W17), (W19) and (W20). With the
    /// points `about`, a pair for each frustum, the drag is linear in the velocities.
    pub(super) fn add_flow_loads(
        &self,
        motions: &[SectionMotion],
        flow: &Flow,
        about: &[[DragPoint; 2]],
        state: &mut SlenderBodyState,
        loads: &mut AirLoads,
    ) {
        state.momenta_m4_s.fill(Vector3::zeros());
        for inner in 0..self.frustums.len() {
            self.add_frustum(inner, motions, flow, about.get(inner), state, loads);
        }
        for end in self.ends() {
            self.add_end(end, motions, flow, loads);
        }
    }

    /// Adds loads and momenta of a frustum to its sections.
    pub(super) fn add_frustum(
        &self,
        inner: usize,
        motions: &[SectionMotion],
        flow: &Flow,
        about: Option<&[DragPoint; 2]>,
        state: &mut SlenderBodyState,
        loads: &mut AirLoads,
    ) {
        let (frustum, density_kg_m3) = (&self.frustums[inner], flow.density_kg_m3);
        let sections = [inner, inner + 1];
        let arms_m = sections.map(|section| self.arm_m(section, motions));
        let (_, along, length_m) = self.axis(inner, motions);
        let meetings = sections.map(|section| self.meet(section, &along, motions, flow));
        let [inner_m3, both_m3, outer_m3] = frustum.volumes_m3;
        let [first, second] = meetings.map(|meeting| meeting.across_m_s);
        let momenta_m4_s = [first * inner_m3 + second * both_m3, first * both_m3 + second * outer_m3];
        // the momentum that drifts along the body: a couple of forces across it
        let drift_n = (momenta_m4_s[0] * meetings[0].along_m_s + momenta_m4_s[1] * meetings[1].along_m_s)
            * (density_kg_m3 / length_m);
        let mean_m_s = 0.5 * (meetings[0].along_m_s + meetings[1].along_m_s);
        let widening_m2 = frustum.widening_m2(self.lengths_m[inner]);
        for (end, meeting) in meetings.iter().enumerate() {
            state.momenta_m4_s[sections[end]] += momenta_m4_s[end];
            let drift_n = if end == 0 { -drift_n } else { drift_n };
            let gust_n = meeting.gust_m_s * (density_kg_m3 * mean_m_s * widening_m2[end]);
            let about = about.map(|ends| &ends[end]);
            let drag_n = self.drag_n(meeting, about, &along, frustum.sides_m2[end], density_kg_m3);
            let force_n = drift_n + gust_n + drag_n;
            loads.circulatory[sections[end]].add_force_at(&arms_m[end], &force_n);
        }
    }

    /// Adds the load of an end: section, direction out of the body along the axis, and cross-section.
    pub(super) fn add_end(
        &self,
        (section, outward, area_m2): (usize, f64, f64),
        motions: &[SectionMotion],
        flow: &Flow,
        loads: &mut AirLoads,
    ) {
        let along = motions[section].rotation.column(0).into_owned();
        let meeting = self.meet(section, &along, motions, flow);
        let force_n = end_force_n(&meeting, &along, outward, area_m2) * flow.density_kg_m3;
        loads.circulatory[section].add_force_at(&self.arm_m(section, motions), &force_n);
    }

    /// Section, direction out of the body along the axis, and cross-section of both ends.
    pub(super) fn ends(&self) -> [(usize, f64, f64); 2] {
        let last = self.frustums.len() - 1;
        [(0, -1.0, self.frustums[0].areas_m2[0]), (last + 1, 1.0, self.frustums[last].areas_m2[1])]
    }

    /// Drag in N across and along a frustum on the side area of one of its sections, eq. (W20), or its tangent at `about`.
    fn drag_n(
        &self,
        meeting: &Meeting,
        about: Option<&DragPoint>,
        along: &Vector3<f64>,
        side_m2: f64,
        density_kg_m3: f64,
    ) -> Vector3<f64> {
        let options = &self.options;
        let pressure_kg_m3 = 0.5 * density_kg_m3;
        let own = meeting.drag_point();
        // a square is the product of a velocity and a magnitude; in its tangent the magnitude is fixed
        let (moved, [across_size_m_s, along_size_m_s]) = match about {
            None => (own, [own.across_m_s.norm(), own.along_m_s.abs()]),
            Some(about) => (about.doubled(&own), [about.across_m_s.norm(), about.along_m_s.abs()]),
        };
        let front_m2 = self.front_share * side_m2;
        moved.across_m_s * (pressure_kg_m3 * options.cross_flow_drag_coefficient * side_m2 * across_size_m_s)
            + along * (pressure_kg_m3 * options.axial_drag_coefficient * front_m2 * moved.along_m_s * along_size_m_s)
    }
}

/// Force per density, in m⁴/s², at an end of the body with a cross-section of `area_m2`; `outward`: 1 at the outer end, −1 at the inner
/// one. Eq. (W19): air that flows off the base keeps its momentum, and the suction on the body in front of the base inclines the force by
/// half of the angle; at an end towards the flow only gusts have an effect, because the air was at rest.
fn end_force_n(meeting: &Meeting, along: &Vector3<f64>, outward: f64, area_m2: f64) -> Vector3<f64> {
    let leaving_m_s = outward * meeting.along_m_s;
    if leaving_m_s <= 0.0 {
        return meeting.gust_m_s * (-area_m2 * leaving_m_s);
    }
    let across_m_s = meeting.across_m_s - meeting.gust_m_s;
    let square_m2_s2 = across_m_s.norm_squared();
    let suction_m2_s2 = leaving_m_s * square_m2_s2 / (leaving_m_s + leaving_m_s.hypot(square_m2_s2.sqrt()));
    (meeting.across_m_s * -leaving_m_s - along * (outward * suction_m2_s2)) * area_m2
}

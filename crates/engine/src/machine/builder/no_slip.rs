//! Skates and wheels in code.

use crate::machine::fault::{Checker, array_text};
use crate::machine::{Body, NoSlip, Runner};
use nalgebra::Vector3;

/// A skate or a wheel under construction, see [`NoSlip::skate`] and [`NoSlip::wheel`].
#[derive(Debug, Clone)]
pub struct NoSlipBuilder {
    name: String,
    body: String,
    position_m: Option<f64>,
    offset_m: Vector3<f64>,
    runner: Runner,
    plane_normal: Vector3<f64>,
    plane_point_m: Vector3<f64>,
    hold_normal: bool,
}

impl NoSlip {
    /// A skate at the outer end of a body: its point moves along `direction`, in the section frame and of any nonzero length, and in the plane
    /// `z = 0` of the root frame.
    pub fn skate(
        name: impl Into<String>,
        body: impl Into<String>,
        direction: impl Into<Vector3<f64>>,
    ) -> NoSlipBuilder {
        NoSlipBuilder::of(name.into(), body.into(), Runner::Skate { direction: direction.into() })
    }

    /// A wheel of a given radius in m that is part of a body, with its centre at the outer end, about `axis`, in the section frame and of any
    /// nonzero length: it rolls without slip on the plane `z = 0` of the root frame, along `axis × normal` for positive rotations.
    pub fn wheel(
        name: impl Into<String>,
        body: impl Into<String>,
        axis: impl Into<Vector3<f64>>,
        radius_m: f64,
    ) -> NoSlipBuilder {
        NoSlipBuilder::of(name.into(), body.into(), Runner::Wheel { axis: axis.into(), radius_m, rolling: true })
    }
}

impl NoSlipBuilder {
    fn of(name: String, body: String, runner: Runner) -> Self {
        Self {
            name,
            body,
            position_m: None,
            offset_m: Vector3::zeros(),
            runner,
            plane_normal: Vector3::z(),
            plane_point_m: Vector3::zeros(),
            hold_normal: true,
        }
    }

    /// Distance of the section from the body's inner end in m. Default: its outer end.
    pub fn position_m(self, position_m: f64) -> Self {
        Self { position_m: Some(position_m), ..self }
    }

    /// Position of the skate's point, or of the wheel's centre, relative to the section's axis, section frame, m. Default 0.
    pub fn offset_m(self, offset_m: impl Into<Vector3<f64>>) -> Self {
        Self { offset_m: offset_m.into(), ..self }
    }

    /// Normal of the plane, of any nonzero length, on the side of the body, and a point of the plane in m, root frame. Default `z` and the
    /// origin.
    pub fn plane(self, normal: impl Into<Vector3<f64>>, point_m: impl Into<Vector3<f64>>) -> Self {
        Self { plane_normal: normal.into(), plane_point_m: point_m.into(), ..self }
    }

    /// Whether the wheel rolls without slip along its heading, or slips along it without friction. Default true; no effect on a skate.
    pub fn rolling(mut self, rolls: bool) -> Self {
        match &mut self.runner {
            Runner::Skate { .. } => {}
            Runner::Wheel { rolling, .. } => *rolling = rolls,
        }
        self
    }

    /// Whether the point of contact stays in the plane. Default true.
    pub fn hold_normal(self, hold_normal: bool) -> Self {
        Self { hold_normal, ..self }
    }

    /// Builds the constraint on its body, found by name; `None` if that does not exist or a direction has no length.
    pub(super) fn build(&self, bodies: &[Body], checker: &mut Checker) -> Option<NoSlip> {
        let mut built = NoSlip {
            name: self.name.clone(),
            body: 0,
            position_m: 0.0,
            offset_m: self.offset_m,
            runner: self.runner,
            plane_normal: self.plane_normal,
            plane_point_m: self.plane_point_m,
            hold_normal: self.hold_normal,
        };
        let table = built.table();
        let mut unit = |key: &str, direction: &mut Vector3<f64>| {
            let largest = direction.amax();
            if largest > 0.0 && largest < f64::INFINITY {
                *direction = (*direction / largest).normalize();
                return true;
            }
            let found = array_text(direction.as_slice());
            checker.refuse(&[table, &self.name, key], found, "an array of 3 finite numbers, not all 0");
            false
        };
        let stands = match &mut built.runner {
            Runner::Skate { direction } => unit("direction", direction),
            Runner::Wheel { axis, .. } => unit("axis", axis),
        };
        let lies = unit("plane_normal", &mut built.plane_normal);
        let Some(body) = bodies.iter().position(|body| body.name == self.body) else {
            let names = bodies.iter().map(|body| body.name.as_str());
            checker.unknown_name(&[table, &self.name, "body"], &self.body, "names of bodies", names);
            return None;
        };
        (built.body, built.position_m) = (body, self.position_m.unwrap_or(bodies[body].length_m));
        (stands && lies).then_some(built)
    }
}

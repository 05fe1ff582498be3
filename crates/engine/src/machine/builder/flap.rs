//! Control surfaces in code: equivalent of a table `[flap.<name>]` of the model file.

use crate::aero::flap::Flap;
use crate::machine::builder::surfaces::SurfaceBuilder;
use crate::machine::fault::{Checker, Range};
use crate::machine::units::{quoted, shortest};
use crate::machine::{Body, LiftingSurface};
use std::f64::consts::FRAC_PI_6;

/// Distance, relative to a body's length, below which two positions coincide.
const NEAR: f64 = 1e-9;

/// A control surface under construction, see [`FlapBuilder::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct FlapBuilder {
    pub(super) name: String,
    body: String,
    from_m: f64,
    to_m: f64,
    hinge_fraction: f64,
    lower_rad: f64,
    upper_rad: f64,
    command_rad: f64,
}

impl FlapBuilder {
    /// A control surface on the surface of a body, between two distances in m from the body's inner end, with its hinge at a fraction of
    /// the chord behind the leading edge.
    pub fn new(
        name: impl Into<String>,
        body: impl Into<String>,
        [from_m, to_m]: [f64; 2],
        hinge_fraction: f64,
    ) -> Self {
        Self {
            name: name.into(),
            body: body.into(),
            from_m,
            to_m,
            hinge_fraction,
            lower_rad: -FRAC_PI_6,
            upper_rad: FRAC_PI_6,
            command_rad: 0.0,
        }
    }

    /// Smallest and largest angle in rad. Default ±30°.
    pub fn limits_rad(self, [lower_rad, upper_rad]: [f64; 2]) -> Self {
        Self { lower_rad, upper_rad, ..self }
    }

    /// Initial angle in rad: start value of the input. Default 0.
    pub fn command_rad(self, command_rad: f64) -> Self {
        Self { command_rad, ..self }
    }

    /// Whether it belongs to the surface of a body.
    pub(super) fn is_on(&self, body: &str) -> bool {
        self.body == body
    }

    /// Positions of its ends in m on a body of this length: positions very close to the body's ends are moved to these.
    pub(super) fn ends_m(&self, length_m: f64) -> [f64; 2] {
        let near = |place_m: f64, end_m: f64| (place_m - end_m).abs() <= NEAR * length_m;
        [self.from_m, self.to_m].map(|place_m| match place_m {
            place_m if near(place_m, 0.0) => 0.0,
            place_m if near(place_m, length_m) => length_m,
            place_m => place_m,
        })
    }
}

/// Checks all control surfaces: their bodies, ranges and hinges. Returns false after an error.
pub(super) fn check(
    flaps: &[FlapBuilder],
    surfaces: &[SurfaceBuilder],
    bodies: &[Body],
    lattice: bool,
    checker: &mut Checker,
) -> bool {
    let mut fine = true;
    for (index, flap) in flaps.iter().enumerate() {
        let place = |key| ["control_surface", flap.name.as_str(), key];
        let Some(body) = bodies.iter().find(|body| body.name == flap.body) else {
            checker.unknown_name(&place("body"), &flap.body, "a body", bodies.iter().map(|body| body.name.as_str()));
            fine = false;
            continue;
        };
        let Some(surface) = surfaces.iter().find(|surface| surface.body == flap.body) else {
            let known: Vec<&str> = surfaces.iter().map(|surface| surface.body.as_str()).collect();
            let allowed = match known.is_empty() {
                true => "a body with a lifting surface; there is none".to_owned(),
                false => format!("a body with a lifting surface: {}", quoted(&known)),
            };
            checker.refuse(&place("body"), format!("{:?}", flap.body), allowed);
            fine = false;
            continue;
        };
        let length_m = body.length_m;
        let before = checker.faults.len();
        for (key, place_m) in [("from_m", flap.from_m), ("to_m", flap.to_m)] {
            checker.on_body(&place(key), place_m, length_m);
        }
        let [from_m, to_m] = flap.ends_m(length_m);
        if checker.faults.len() == before && to_m - from_m <= NEAR * length_m {
            let allowed = format!("a length > from_m = {} m", shortest(flap.from_m));
            checker.refuse(&place("to_m"), shortest(flap.to_m), allowed);
        }
        let hinge = flap.hinge_fraction;
        if !(hinge > 0.0 && hinge < 1.0) {
            let allowed = "a fraction of the chord > 0 and < 1: between the leading and the trailing edge";
            checker.refuse(&place("hinge_fraction"), shortest(hinge), allowed);
        } else if lattice {
            check_row(flap, surface.chord_panels, checker);
        }
        limits(flap, checker);
        if checker.faults.len() == before {
            let meets = |other: &&FlapBuilder| {
                let [other_from_m, other_to_m] = other.ends_m(length_m);
                let common_m = to_m.min(other_to_m) - from_m.max(other_from_m);
                other.body == flap.body && common_m > NEAR * length_m
            };
            if let Some(other) = flaps[..index].iter().find(meets) {
                let [begin_m, end_m] = other.ends_m(length_m).map(shortest);
                let state = format!(
                    "a control surface that overlaps control surface {:?}, from {begin_m} to {end_m} m",
                    other.name
                );
                checker.refuse_state(&place("from_m"), state, "control surfaces side by side on a body");
            }
        }
        fine &= checker.faults.len() == before;
    }
    fine
}

/// Checks that the hinge of a control surface in a lattice lies between two rows of panels.
fn check_row(flap: &FlapBuilder, chord_panels: usize, checker: &mut Checker) {
    let rows = flap.hinge_fraction * chord_panels as f64;
    let fits = |panels: usize| {
        let (rows, all) = (flap.hinge_fraction * panels as f64, panels as f64);
        (rows - rows.round()).abs() <= NEAR * all && rows.round() >= 1.0 && rows.round() < all
    };
    if fits(chord_panels) {
        return;
    }
    let cure = match (chord_panels.max(1)..=100).find(|&panels| fits(panels)) {
        Some(panels) => format!("for example chord_panels = {panels}"),
        None => "no count up to 100 has one there".to_owned(),
    };
    let nearest = (rows.round().clamp(1.0, (chord_panels.max(2) - 1) as f64)) / chord_panels.max(2) as f64;
    let allowed = format!(
        "a hinge on a line between panels, at a multiple of 1/{chord_panels} with chord_panels = {chord_panels}, such \
         as {}; {cure}",
        shortest(nearest)
    );
    checker.refuse(&["control_surface", &flap.name, "hinge_fraction"], shortest(flap.hinge_fraction), allowed);
}

/// Checks the limits: around the start value, below a right angle.
fn limits(flap: &FlapBuilder, checker: &mut Checker) {
    let place = |key| ["control_surface", flap.name.as_str(), key];
    let maximum_rad = 60.0_f64.to_radians();
    let within = checker.number(&place("lower_rad"), flap.lower_rad, Range::Within(-maximum_rad, maximum_rad))
        & checker.number(&place("upper_rad"), flap.upper_rad, Range::Within(-maximum_rad, maximum_rad));
    if !within {
        return;
    }
    if flap.lower_rad >= flap.upper_rad {
        checker.refuse_state(
            &place("lower_rad"),
            "a lower limit that is not below the upper one",
            "lower_rad < upper_rad",
        );
    } else if !(flap.lower_rad..=flap.upper_rad).contains(&flap.command_rad) {
        let allowed = "an angle from lower_rad to upper_rad";
        checker.refuse_state(&place("command_rad"), "a start value beyond the limits", allowed);
    }
}

/// Builds the control surfaces on surfaces with valid strips.
pub(super) fn build(
    flaps: &[FlapBuilder],
    builders: &[SurfaceBuilder],
    surfaces: &[LiftingSurface],
    bodies: &[Body],
) -> Vec<Flap> {
    let of = |flap: &FlapBuilder| {
        let body = bodies.iter().position(|body| body.name == flap.body)?;
        let index = surfaces.iter().position(|surface| surface.body == body)?;
        let builder = builders.iter().find(|surface| surface.body == flap.body)?;
        let positions_m = &surfaces[index].positions_m;
        // strips with their middle on the control surface, whose ends are edges of strips
        let [from_m, to_m] = flap.ends_m(bodies[body].length_m);
        let held = |edges: &[f64]| (from_m..to_m).contains(&(0.5 * (edges[0] + edges[1])));
        let start = positions_m.windows(2).position(held)?;
        let count = positions_m.windows(2).filter(|edges| held(edges)).count();
        Some(Flap {
            name: flap.name.clone(),
            surface: index,
            strips: start..start + count,
            hinge_fraction: flap.hinge_fraction,
            lower_rad: flap.lower_rad,
            upper_rad: flap.upper_rad,
            command_rad: flap.command_rad,
            downward: builder.forward,
        })
    };
    flaps.iter().filter_map(of).collect()
}

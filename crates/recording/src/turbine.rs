//! Tower, nacelle and hub of a turbine as solids, for pictures: dimensions of the model as far as it has them, otherwise proportions.

use foldwing_engine::machine::{Machine, Parent, Travel};
use foldwing_engine::plant::Plant;
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Diameters of a tower at its foot and top relative to its length, if the model has none: those of the NREL 5 MW turbine.
const TOWER: [f64; 2] = [0.068, 0.044];
/// Radius of a hub relative to the length of the blades, if their roots lie on the shaft.
const HUB: f64 = 0.025;
/// Height of a nacelle over its underside relative to the length of the blades, if the shaft crosses the top of the tower.
const NACELLE: f64 = 0.04;
/// Points around the hub.
const AROUND: usize = 20;

/// A closed surface on a rigid body: rings of equally many points in the body's frame in m, the first and the last closed by faces.
#[derive(Debug, Clone, PartialEq)]
pub struct SolidScene {
    /// Part of the turbine.
    pub part: &'static str,
    /// Index into the model's bodies.
    pub body: usize,
    /// Rings of points.
    pub rings_m: Vec<Vec<[f64; 3]>>,
    /// The surface is round; otherwise its faces are flat.
    pub is_round: bool,
}

/// The parts of a turbine as indices into the model's bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Turbine {
    /// Flexible body that carries the nacelle.
    pub tower: Option<usize>,
    /// Rigid body that carries the shaft.
    pub nacelle: Option<usize>,
    /// Rigid body that carries the blades.
    pub hub: usize,
    /// Bodies on the hub.
    pub blades: Vec<usize>,
    /// The model has the diameters of the tower.
    pub has_diameters: bool,
}

/// Heights in m, diameters in m and drag coefficients of the tower that disturbs the wind of the rotors.
fn tower_of(machine: &Machine) -> Option<&[[f64; 3]]> {
    let mut rotors = machine.air.iter().flat_map(|air| air.rotors());
    rotors.find_map(|(_, rotor)| rotor.features.tower.as_ref()).map(|tower| &tower.rows[..])
}

impl Turbine {
    /// The turbine of a model: at least two blades across the shaft on a rigid hub, the outermost one that rotates on a revolute
    /// joint. `None` with several aerodynamic models: a wing with a propeller is no tower.
    pub fn of(plant: &Plant) -> Option<Self> {
        let machine = plant.machine();
        if machine.air.as_ref().is_some_and(|air| air.parts.len() > 1) {
            return None;
        }
        (0..machine.bodies.len()).rev().find_map(|hub| Self::with_hub(plant, hub))
    }

    fn with_hub(plant: &Plant, hub: usize) -> Option<Self> {
        let machine = plant.machine();
        if !machine.bodies[hub].is_rigid() {
            return None;
        }
        let mut turning = hub;
        let shaft = loop {
            if let Some(axis) = axis(plant, turning) {
                break axis;
            }
            if !machine.bodies[turning].joint.kind.is_clamped() {
                return None;
            }
            turning = carrier(machine, turning).filter(|body| machine.bodies[*body].is_rigid())?;
        };
        let has_surface =
            |body: usize| machine.air.iter().flat_map(|air| &air.surfaces).any(|surface| surface.body == body);
        let is_blade = |body: &usize| {
            let across = plant.sections(*body, &[0.0])[0].rotation.column(0).dot(&shaft).abs() < 0.5;
            let has_span = !machine.bodies[*body].is_rigid() || has_surface(*body);
            let mut on = carrier(machine, *body);
            while let Some(root) = on.filter(|root| *root != hub && machine.bodies[*root].is_rigid()) {
                on = carrier(machine, root);
            }
            on == Some(hub) && has_span && across
        };
        let blades: Vec<usize> = (0..machine.bodies.len()).filter(is_blade).collect();
        if blades.len() < 2 {
            return None;
        }
        // the shaft ends at the first body below that does not rotate about it
        let mut fixed = carrier(machine, turning);
        while let Some(body) = fixed.filter(|body| {
            axis(plant, *body).is_some_and(|own| own.dot(&shaft).abs() > 0.9) && machine.bodies[*body].is_rigid()
        }) {
            fixed = carrier(machine, body);
        }
        let nacelle = fixed.filter(|body| machine.bodies[*body].is_rigid());
        let mut tower = fixed;
        while let Some(body) = tower.filter(|body| machine.bodies[*body].is_rigid()) {
            tower = carrier(machine, body);
        }
        let has_diameters = tower_of(machine).is_some();
        Some(Self { tower, nacelle, hub, blades, has_diameters })
    }

    /// Half of the tower's diameter in m at a distance from its foot.
    pub fn tower_radius_m(&self, machine: &Machine, place_m: f64) -> f64 {
        if let Some(tower) = tower_of(machine) {
            let rows: Vec<[f64; 2]> = tower.iter().map(|[height_m, diameter_m, _]| [*height_m, *diameter_m]).collect();
            return 0.5 * linear(&rows, place_m);
        }
        let length_m = self.tower.map_or(0.0, |tower| machine.bodies[tower].length_m);
        let part = if length_m > 0.0 { place_m / length_m } else { 0.0 };
        0.5 * length_m * (TOWER[0] + part * (TOWER[1] - TOWER[0]))
    }

    /// Nacelle and hub as solids.
    pub fn solids(&self, plant: &Plant) -> Vec<SolidScene> {
        let machine = plant.machine();
        let frame = |body: usize| plant.sections(body, &[0.0])[0];
        let hub = frame(self.hub);
        let Some(mut shaft) = self.shaft(plant) else { return Vec::new() };
        if let Some(nacelle) = self.nacelle {
            let ahead = (hub.position_m - frame(nacelle).position_m).dot(&shaft);
            shaft *= if ahead < 0.0 { -1.0 } else { 1.0 };
        }
        let blade_m = self.blades.iter().map(|body| span_m(machine, *body)).fold(0.0, f64::max);
        let root_m = |body: &usize| {
            let offset = frame(*body).position_m - hub.position_m;
            (offset - shaft * offset.dot(&shaft)).norm()
        };
        let radius_m = self.blades.iter().map(root_m).fold(f64::INFINITY, f64::min);
        let root_chord_m = self.blades.iter().map(|body| root_chord_m(machine, *body)).fold(0.0, f64::max);
        let radius_m = if radius_m > 1e-3 * blade_m { radius_m } else { HUB * blade_m }.max(0.55 * root_chord_m);
        let mut found = vec![SolidScene {
            part: "hub",
            body: self.hub,
            rings_m: hub_rings(hub.rotation.transpose() * shaft, radius_m),
            is_round: true,
        }];
        if let Some(nacelle) = self.nacelle {
            let own = frame(nacelle);
            let into = own.rotation.transpose();
            // the axis of the tower at its end, or the vertical of the root
            let up = self.tower.map_or_else(Vector3::z, |tower| {
                let end = plant.sections(tower, &[machine.bodies[tower].length_m])[0];
                end.rotation.column(0).into()
            });
            let apex = into * (hub.position_m - own.position_m);
            let rings_m = nacelle_rings(apex, into * -shaft, into * up, (radius_m, blade_m));
            found.extend(rings_m.map(|rings_m| SolidScene {
                part: "nacelle",
                body: nacelle,
                rings_m,
                is_round: false,
            }));
        }
        found
    }

    fn shaft(&self, plant: &Plant) -> Option<Vector3<f64>> {
        let mut body = self.hub;
        loop {
            if let Some(axis) = axis(plant, body) {
                return Some(axis);
            }
            body = carrier(plant.machine(), body)?;
        }
    }

    /// Sentence that names the dimensions in proportion.
    pub fn note(&self) -> String {
        let tower = if self.tower.is_some() && !self.has_diameters { "diameter of the tower, " } else { "" };
        let nacelle = if self.nacelle.is_some() { "sizes of nacelle and hub" } else { "size of the hub" };
        format!("In proportion, not in the model: {tower}{nacelle}.")
    }
}

/// Index of the body that carries another one.
fn carrier(machine: &Machine, body: usize) -> Option<usize> {
    match machine.bodies[body].joint.parent {
        Parent::Root { .. } => None,
        Parent::Body { index, .. } => Some(index),
    }
}

/// Direction of the axis of a revolute joint in the root frame; `None` for other joints.
fn axis(plant: &Plant, body: usize) -> Option<Vector3<f64>> {
    let joint = &plant.machine().bodies[body].joint;
    let (travel, own) = joint.kind.one_freedom()?;
    let first = plant.sections(body, &[0.0])[0].rotation;
    (travel == Travel::Rotation).then(|| first * (joint.mount.transpose() * own.axis.normalize()))
}

/// Length of a blade in m, from its body or its surface.
fn span_m(machine: &Machine, body: usize) -> f64 {
    let surfaces = machine.air.iter().flat_map(|air| &air.surfaces).filter(|surface| surface.body == body);
    let ends = surfaces.filter_map(|surface| surface.positions_m.last().copied());
    ends.fold(machine.bodies[body].length_m, f64::max)
}

/// Chord at the root of a blade in m; 0 without a surface.
fn root_chord_m(machine: &Machine, body: usize) -> f64 {
    let surfaces = machine.air.iter().flat_map(|air| &air.surfaces).filter(|surface| surface.body == body);
    surfaces.map(|surface| (surface.chords[0].trailing_m - surface.chords[0].leading_m).norm()).fold(0.0, f64::max)
}

/// Linear interpolation in rows `[x, y]` of ascending x, constant beyond the ends.
fn linear(rows: &[[f64; 2]], x: f64) -> f64 {
    let after = rows.partition_point(|row| row[0] <= x);
    match (after.checked_sub(1).map(|i| rows[i]), rows.get(after).copied()) {
        (Some([x0, y0]), Some([x1, y1])) => y0 + (x - x0) / (x1 - x0) * (y1 - y0),
        (Some([_, y]), None) | (None, Some([_, y])) => y,
        (None, None) => 0.0,
    }
}

/// Unit vectors normal to a unit vector and to each other.
fn across(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let other = if axis.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let first = axis.cross(&other).normalize();
    [first, axis.cross(&first)]
}

/// Cylinder about the shaft with a nose in its direction.
fn hub_rings(nose: Vector3<f64>, radius_m: f64) -> Vec<Vec<[f64; 3]>> {
    let sides = across(&nose);
    let ring = |along: f64, radius: f64| {
        let point = |i: usize| {
            let (sine, cosine) = (i as f64 * TAU / AROUND as f64).sin_cos();
            radius_m * (along * nose + radius * (cosine * sides[0] + sine * sides[1]))
        };
        (0..AROUND).map(|i| point(i).into()).collect()
    };
    let dome = (1..=5).map(|i| {
        let (sine, cosine) = (f64::from(i) * FRAC_PI_2 / 5.2).sin_cos();
        ring(0.7 + 1.1 * sine, cosine)
    });
    [ring(-1.0, 0.96), ring(-0.95, 1.0), ring(0.7, 1.0)].into_iter().chain(dome).collect()
}

/// Box with chamfers from the hub to beyond the tower, its underside at the tower's top; `None` where the shaft is along the tower.
fn nacelle_rings(
    apex: Vector3<f64>,
    rear: Vector3<f64>,
    up: Vector3<f64>,
    (hub_m, blade_m): (f64, f64),
) -> Option<Vec<Vec<[f64; 3]>>> {
    let up = (up - rear * up.dot(&rear)).try_normalize(1e-3)?;
    let side = rear.cross(&up);
    let overhang_m = -apex.dot(&rear);
    let above = apex + overhang_m * rear;
    let height_m = above.dot(&up);
    let half_m = if height_m > 0.01 * blade_m { height_m } else { NACELLE * blade_m };
    let behind_m = (1.5 * overhang_m).max(2.0 * half_m);
    let ring = |along_m: f64, size: f64| {
        let corner = |[w, h]: [f64; 2]| (above + along_m * rear + half_m * size * (0.9 * w * side + h * up)).into();
        const CHAMFERED: [[f64; 2]; 8] =
            [[1.0, -0.7], [1.0, 0.7], [0.7, 1.0], [-0.7, 1.0], [-1.0, 0.7], [-1.0, -0.7], [-0.7, -1.0], [0.7, -1.0]];
        CHAMFERED.map(corner).into()
    };
    let front_m = -(overhang_m - 0.9 * hub_m).max(0.5 * half_m);
    let edge_m = 0.25 * half_m;
    Some(vec![ring(front_m, 0.75), ring(front_m + edge_m, 1.0), ring(behind_m - edge_m, 1.0), ring(behind_m, 0.8)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::tests::started;
    use foldwing_file as config;

    fn shipped(path: &str) -> Plant {
        let root = format!("{}/../../examples", env!("CARGO_MANIFEST_DIR"));
        started(config::read(format!("{root}/{path}.toml")).unwrap().0)
    }

    /// Parts of the 5 MW turbine; aircraft, wings and pendulums are none.
    #[test]
    fn a_turbine_is_known_by_its_joints() {
        let plant = shipped("turbine/nrel_5mw");
        let found = Turbine::of(&plant).unwrap();
        let name = |body: usize| plant.machine().bodies[body].name.as_str();
        assert_eq!(found.tower.map(name), Some("tower"));
        assert_eq!(found.nacelle.map(name), Some("nacelle"));
        assert_eq!((name(found.hub), found.blades.len()), ("hub", 3));
        for other in [
            "models/folding_wing",
            "models/flying_wing",
            "flying_aircraft",
            "models/double_pendulum",
            "models/four_bar",
            "models/branched",
        ] {
            assert_eq!(Turbine::of(&shipped(other)), None, "{other}");
        }
    }

    /// The radius of the hub is the distance of the blade roots from the shaft; the underside of the nacelle is at the top of the tower, and
    /// the nacelle contains the shaft; all rings have equally many points.
    #[test]
    fn solids_are_where_the_model_is() {
        let plant = shipped("turbine/nrel_5mw");
        let turbine = Turbine::of(&plant).unwrap();
        let solids = turbine.solids(&plant);
        assert_eq!(solids.iter().map(|solid| solid.part).collect::<Vec<_>>(), ["hub", "nacelle"]);
        for solid in &solids {
            assert!(solid.rings_m.iter().all(|ring| ring.len() == solid.rings_m[0].len()));
        }
        let largest = |solid: &SolidScene, i: usize| {
            let all = solid.rings_m.iter().flatten().map(|point| point[i]);
            [all.clone().fold(f64::INFINITY, f64::min), all.fold(f64::NEG_INFINITY, f64::max)]
        };
        // HubRad = 1.5 m in the plane of the precone, 1.4986 across the shaft
        let [low, high] = largest(&solids[0], 1);
        assert!((high - 1.4986).abs() < 1e-3 && (low + 1.4986).abs() < 1e-3, "{low} {high}");
        // underside at the tower's top, shaft 2.4 m above it at the apex and 1.9626 m at the tower's axis
        let [low, high] = largest(&solids[1], 2);
        assert!(low > -1.0 && low < 0.0 && high > 3.5, "{low} {high}");
        let [front, rear] = largest(&solids[1], 0);
        assert!(front < -3.0 && front > -5.0 && rear > 4.0, "{front} {rear}");
    }

    /// Without diameters the tower tapers in proportion to its height.
    #[test]
    fn a_tower_without_diameters_is_in_proportion() {
        let plant = shipped("turbine/nrel_5mw");
        let turbine = Turbine::of(&plant).unwrap();
        let [foot, top] = [0.0, 87.6].map(|place_m| turbine.tower_radius_m(plant.machine(), place_m));
        assert!((foot - 0.034 * 87.6).abs() < 1e-12 && (top - 0.022 * 87.6).abs() < 1e-12);
        assert_eq!(turbine.note(), "In proportion, not in the model: diameter of the tower, sizes of nacelle and hub.");
    }

    /// Blades across the axis of a rigid hub: two are a turbine, one is a body on a hinge.
    #[test]
    fn one_blade_is_no_turbine() {
        let text = |count: i32| {
            let blades = (0..count).map(|blade| {
                // along z, up and down
                format!(
                    "[body.blade_{blade}]\nlength_m = 1\nsection = \"plate\"\nelements = 1\n[joint.root_{blade}]\ntype = \"clamped\"\nparent = \
                     \"hub\"\nparent_position_m = 0\nchild = \"blade_{blade}\"\nmount_rotation_deg = [0, {}, 0]\n",
                    90 - 180 * blade
                )
            });
            format!(
                "name = \"blades\"\n[section.plate]\nshape = \"rectangle\"\nwidth_m = 0.05\nheight_m = 0.004\ndensity_kg_m3 = 1400\n\
                 youngs_modulus_Pa = 3e9\npoisson_ratio = 0.3\n[rigid_body.hub]\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1, 0, 0, 0]\n[joint.shaft]\n\
                 type = \"revolute\"\nparent = \"root\"\nchild = \"hub\"\naxis = [1, 0, 0]\n{}",
                blades.collect::<String>()
            )
        };
        let found = |count: i32| {
            let machine = config::parse(&text(count), "blades").unwrap_or_else(|error| panic!("{error:?}"));
            Turbine::of(&started(machine)).map(|turbine| turbine.blades.len())
        };
        assert_eq!([1, 2].map(found), [None, Some(2)]);
    }
}

//! What sits on bodies: point masses, rigid bodies, loads and gauges.

use crate::beam::law::SectionLaw;
use crate::beam::section::{Outline, Section};
use crate::config::body;
use crate::config::file::{GaugeFile, MassFile, ModelFile};
use crate::config::sections::Sections;
use crate::config::tree::Tree;
use crate::config::validate::Checker;
use crate::load::Wrench;
use crate::machine::{AttachedMass, Body, Gauge};
use nalgebra::{Matrix3, Vector3};

/// Violation of an inequality between moments of inertia that is taken for round-off, relative to the largest.
const INERTIA_TOLERANCE: f64 = 1e-9;

/// Attached masses per body of the file.
pub(super) fn masses(file: &ModelFile, checker: &mut Checker) -> Vec<Vec<AttachedMass>> {
    let mut masses = vec![Vec::new(); file.body.len()];
    for (name, mass) in &file.mass {
        let inertia_kg_m2 = inertia(name, mass, checker);
        let Some((index, _, body)) = file.body.get_full(&mass.body) else {
            let bodies = file.body.keys().map(String::as_str);
            checker.unknown_name(&["mass", name, "body"], &mass.body, "a body", bodies);
            continue;
        };
        checker.on_body(&["mass", name, "position_m"], mass.position_m, body);
        masses[index].push(AttachedMass {
            name: name.clone(),
            position_m: mass.position_m,
            mass_kg: mass.mass_kg,
            offset_m: mass.offset_m.into(),
            inertia_kg_m2,
        });
    }
    masses
}

/// The inertia tensor; refused where no rigid body has it.
fn inertia(name: &str, mass: &MassFile, checker: &mut Checker) -> Matrix3<f64> {
    let [xx, yy, zz, xy, xz, yz] = mass.inertia_kg_m2;
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    if !is_rigid_body(&tensor) {
        let allowed = "[Ixx, Iyy, Izz, Ixy, Ixz, Iyz] in kg·m² with principal moments >= 0, none larger than the sum \
                       of the other two";
        checker.refuse(&["mass", name, "inertia_kg_m2"], allowed);
    }
    tensor
}

/// True where the principal moments are not negative and obey the triangle inequality.
fn is_rigid_body(tensor: &Matrix3<f64>) -> bool {
    let scale = tensor.amax();
    if scale == 0.0 {
        return true;
    }
    let moments = (tensor / scale).symmetric_eigenvalues();
    moments.min() >= -INERTIA_TOLERANCE && moments.max() <= 0.5 * moments.sum() + INERTIA_TOLERANCE
}

/// A load of the file: its name, station and wrench.
pub(super) type NamedLoad = (String, usize, Wrench);

/// Loads per body of the file.
pub(super) fn loads(file: &ModelFile, checker: &mut Checker) -> Vec<Vec<NamedLoad>> {
    let mut loads = vec![Vec::new(); file.body.len()];
    for (name, load) in &file.load {
        let Some(index) = file.body.get_index_of(&load.body) else {
            let bodies = file.body.keys().map(String::as_str);
            checker.unknown_name(&["load", name, "body"], &load.body, "a body", bodies);
            continue;
        };
        let wrench = Wrench { force_n: load.force_n.into(), moment_n_m: load.moment_n_m.into() };
        loads[index].push((name.clone(), load.station, wrench));
    }
    loads
}

/// Puts the loads of a body on its stations.
pub(super) fn place_loads(loads: Vec<NamedLoad>, body: &mut Body, checker: &mut Checker) {
    for (name, station, load) in loads {
        let count = body.station_loads.len();
        match station.checked_sub(1).and_then(|i| body.station_loads.get_mut(i)) {
            Some(sum) => {
                sum.force_n += load.force_n;
                sum.moment_n_m += load.moment_n_m;
            }
            None => checker.refuse(
                &["load", &name, "station"],
                match count {
                    0 => format!("a body with load stations: {:?} has none", body.name),
                    count => format!("a whole number from 1 to {count}, the load stations of {:?}", body.name),
                },
            ),
        }
    }
}

/// All gauges; `None` if one cannot be placed.
pub(super) fn gauges(
    file: &ModelFile,
    sections: &Sections,
    tree: Option<&Tree>,
    checker: &mut Checker,
) -> Option<Vec<Gauge>> {
    let mut gauges = Vec::with_capacity(file.gauge.len());
    for (name, gauge) in &file.gauge {
        let Some((index, _, body)) = file.body.get_full(&gauge.body) else {
            let bodies = file.body.keys().map(String::as_str);
            checker.unknown_name(&["gauge", name, "body"], &gauge.body, "a body", bodies);
            continue;
        };
        checker.on_body(&["gauge", name, "position_m"], gauge.position_m, body);
        let outer = body.outer_section.as_ref().unwrap_or(&body.section);
        let (Some(Some(inner)), Some(Some(outer))) =
            (sections.get(body.section.as_str()), sections.get(outer.as_str()))
        else {
            continue;
        };
        if !(inner.has_outline() && outer.has_outline()) {
            let allowed = "a body whose section states half_width_m and half_height_m";
            checker.refuse(&["gauge", name, "body"], allowed);
            continue;
        }
        // a law that does not stand is refused with its body
        let Some(law) = body::section_law(&gauge.body, body, sections, &mut checker.silent()) else { continue };
        let body = tree.map_or(index, |tree| tree.rank[index]);
        gauges.extend(build_gauge(name, gauge, body, &law, checker));
    }
    (gauges.len() == file.gauge.len()).then_some(gauges)
}

/// A gauge on the section at its position; `None` if a problem was found.
fn build_gauge(name: &str, file: &GaugeFile, body: usize, law: &SectionLaw, checker: &mut Checker) -> Option<Gauge> {
    let (section, solid) = (law.at(file.position_m), law.solid_at(file.position_m));
    let (y_m, z_m) = (file.y_m, file.z_m.unwrap_or(section.half_height_m));
    let outline = solid.map(|solid| solid.outline);
    check_point(name, (y_m, z_m), &section, outline, checker);
    let direction = Vector3::from(file.direction.unwrap_or([1.0, 0.0, 0.0]));
    let Some(direction) = direction.try_normalize(0.0) else {
        checker.refuse(&["gauge", name, "direction"], "an array of 3 finite numbers, not all 0");
        return None;
    };
    let gauge = Gauge { name: name.to_owned(), body, position_m: file.position_m, y_m, z_m, direction };
    if gauge.row(law).is_none() {
        let allowed = "the axis, [1, 0, 0], on a section that is not a rectangle or an ellipse with shear_Pa or \
                           poisson_ratio";
        checker.refuse(&["gauge", name, "direction"], allowed);
        return None;
    }
    Some(gauge)
}

/// Refuses a point off the section; round-off of the rim is forgiven.
fn check_point(name: &str, (y_m, z_m): (f64, f64), section: &Section, outline: Option<Outline>, checker: &mut Checker) {
    let (width, height) = (section.half_width_m, section.half_height_m);
    let (y, z) = (y_m.abs() / width, z_m.abs() / height);
    let (reach, allowed) = match outline {
        Some(Outline::Ellipse) => {
            (y.hypot(z), format!("a point on the section: (y/{width})² + (z/{height})² <= 1, in m"))
        }
        _ => (y.max(z), format!("a point on the section: |y| <= {width} m, |z| <= {height} m")),
    };
    if reach > 1.0 + 1e-9 {
        let off_in_z = z_m.abs() > height || !checker.states(&["gauge", name, "y_m"]);
        checker.refuse(&["gauge", name, if off_in_z { "z_m" } else { "y_m" }], allowed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inertia_of_real_bodies_is_accepted() {
        for moments in [[0.0, 0.0, 0.0], [0.0, 2.0, 2.0], [1.0, 1.0, 2.0], [1e-30, 1e-30, 1e-30]] {
            assert!(is_rigid_body(&Matrix3::from_diagonal(&moments.into())), "{moments:?}");
        }
        for moments in [[1.0, 1.0, 2.1], [-1.0, 1.0, 1.0], [0.0, 0.0, 1.0]] {
            assert!(!is_rigid_body(&Matrix3::from_diagonal(&moments.into())), "{moments:?}");
        }
    }
}

//! `documentation/index.html`: a page without external references, generated from the model and the variable table.

use crate::packaging::extras::Extras;
use crate::packaging::html::{number, table, vector};
use crate::packaging::{VERSION, air_section, drawing, palette, use_section};
use foldwing_engine::beam::section::Section;
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{
    Body, ElementKind, JointKind, LatchKind, OneFreedom, Parent, Runner, Spatial, SpatialFreedom, Travel,
};
use foldwing_engine::math::so3::rotation_vector;
use foldwing_engine::math::strain::STRAINS;
use foldwing_fmi::interface::{Causality, TYPES, UNITS, Value, Variability, Variable};
use nalgebra::Matrix3;
use quick_xml::escape::escape;
use std::fmt::Write;

const STYLE: &str = include_str!("documentation.css");
const EQUATIONS: &str = include_str!("equations.html");

/// Sections linked at the top of the page: anchor and title.
const SECTIONS: [(&str, &str); 9] = [
    ("wing", "The wing"),
    ("use", "How to use it"),
    ("inputs", "Inputs"),
    ("outputs", "Outputs"),
    ("parameters", "Parameters"),
    ("equations", "Equations"),
    ("validation", "Validation"),
    ("archive", "Archive"),
    ("licence", "Licence"),
];

/// Returns the complete page; `extras` are the optional contents of the archive.
pub fn page(machine: &Machine, variables: &[Variable], extras: &Extras) -> String {
    let name = escape(&machine.name);
    let mut html = String::new();
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{name}</title>\n<style>\n{STYLE}{}</style>\n</head>\n<body>\n<h1>{name}</h1>\n<p>{}</p>\n\
         <p>FMI {} {} FMU made by foldwing {VERSION}. All quantities are in SI units and radians; \
         vectors are resolved in the root frame unless a description says otherwise.</p>\n<nav>",
        palette::style(),
        escape(&machine.description),
        extras.kinds.standard(),
        extras.kinds
    );
    for (anchor, title) in SECTIONS {
        let _ = write!(html, "<a href=\"#{anchor}\">{title}</a>");
    }
    html.push_str("</nav>\n");
    drawing_section(&mut html, machine);
    bodies_section(&mut html, machine);
    joints_section(&mut html, machine);
    loops_section(&mut html, machine);
    no_slips_section(&mut html, machine);
    air_section::write(&mut html, machine);
    experiment_section(&mut html, machine);
    use_section::drive(&mut html, machine, variables, extras.kinds);
    variables_section(&mut html, variables);
    html.push_str(EQUATIONS);
    use_section::validation(&mut html);
    use_section::archive(&mut html, extras);
    html.push_str("</body>\n</html>\n");
    html
}

fn drawing_section(html: &mut String, machine: &Machine) {
    let folds = machine.bodies.iter().any(|body| body.joint.kind.one_freedom().is_some());
    let turns = machine.bodies.iter().any(|body| body.joint.kind.spatial().is_some());
    let shown = match (folds, turns) {
        _ if !machine.closures.is_empty() => "at its start angles, where its closed loops close",
        (true, false) => "deployed (filled), at its start angles (outlined) and between",
        (true, true) => {
            "deployed (filled), at its start angles (outlined) and between; universal, ball and free joints in their \
             start attitude"
        }
        (false, true) => "in its start attitude",
        (false, false) => "clamped",
    };
    let drawing = drawing::drawing(machine);
    let keys: Vec<String> = drawing::KEYS
        .iter()
        .filter(|(role, _)| drawing.shows(*role))
        .map(|(role, name)| {
            let name = if *role == palette::Role::Hinge { drawing::axes(machine) } else { name };
            format!("<span class=\"key {}\"></span> {name}", palette::ink(*role).class)
        })
        .collect();
    let _ = write!(
        html,
        "<h2 id=\"wing\">The wing</h2>\n<figure>\n{}<figcaption>Undeformed wing: {shown}. {}. The axes show the \
         directions of the root frame.</figcaption>\n</figure>\n",
        drawing::svg(&drawing),
        keys.join(", ")
    );
}

fn bodies_section(html: &mut String, machine: &Machine) {
    html.push_str("<h2>Bodies</h2>\n");
    let head = [
        "body",
        "length (m)",
        "mass (kg/m)",
        "EA (N)",
        "GJ (N·m²)",
        "EI<sub>y</sub> (N·m²)",
        "EI<sub>z</sub> (N·m²)",
        "elements",
        "stations",
        "α (1/s)",
        "β (s)",
    ];
    table(
        html,
        &head,
        machine.bodies.iter().map(|body| {
            if body.is_rigid() {
                let mass_kg: f64 = body.masses.iter().map(|mass| mass.mass_kg).sum();
                let mut row = vec![escape(&body.name).into_owned(), format!("rigid, {} kg", number(mass_kg))];
                row.extend(std::iter::repeat_n("–".to_owned(), 6));
                row.extend([body.station_positions_m.len().to_string(), "–".to_owned(), "–".to_owned()]);
                return row;
            }
            if let Some(law) = body.section.modal() {
                let mass_kg = number(law.mass_in_all_kg());
                let mut row =
                    vec![escape(&body.name).into_owned(), number(body.length_m), format!("{mass_kg} kg in all")];
                row.extend(std::iter::repeat_n("–".to_owned(), 4));
                row.push(format!("{} shapes, {} cells", law.modes(), law.cells));
                row.extend([body.station_positions_m.len().to_string(), "–".to_owned(), "–".to_owned()]);
                return row;
            }
            // a section that varies along the body is shown at both ends
            let ends = match body.section.is_uniform() {
                true => vec![body.section.at(0.0)],
                false => vec![body.section.at(0.0), body.section.at(body.length_m)],
            };
            let range = |of: &dyn Fn(&Section) -> f64| {
                ends.iter().map(|section| number(of(section))).collect::<Vec<_>>().join(" … ")
            };
            let mut row = vec![escape(&body.name).into_owned(), number(body.length_m)];
            row.push(range(&|section| section.mass_kg_m));
            row.extend((0..STRAINS).map(|i| range(&|section| section.stiffness[(i, i)])));
            row.extend([elements(body), body.station_positions_m.len().to_string()]);
            row.extend([number(body.mass_damping_1_s), number(body.stiffness_damping_s)]);
            row
        }),
    );
}

fn elements(body: &Body) -> String {
    match body.element {
        _ if body.is_modal() => format!("{} shapes", body.elastic_freedoms()),
        ElementKind::Constant => format!("{} constant", body.elements),
        ElementKind::Linear => format!("{} linear pairs", body.elements),
    }
}

fn joints_section(html: &mut String, machine: &Machine) {
    html.push_str("<h2>Joints</h2>\n");
    let head = [
        "joint",
        "holds",
        "on",
        "kind",
        "start (rad)",
        "k (N·m/rad)",
        "c (N·m·s/rad)",
        "T (N·m)",
        "motor's limit (N·m)",
        "latch",
    ];
    table(
        html,
        &head,
        machine.bodies.iter().map(|body| {
            let on = match body.joint.parent {
                Parent::Root { .. } => "root".to_owned(),
                Parent::Body { index, .. } if body.joint.kind.rides() => {
                    format!("along {}", escape(&machine.bodies[index].name))
                }
                Parent::Body { index, position_m } => {
                    format!("{} at {} m", escape(&machine.bodies[index].name), number(position_m))
                }
            };
            let mut row = vec![escape(&body.joint.name).into_owned(), escape(&body.name).into_owned(), on];
            match (body.joint.kind.one_freedom(), body.joint.kind.spatial()) {
                (Some((travel, joint)), _) => row.extend(one_freedom(&body.joint.kind, travel, joint)),
                (_, Some(joint)) => row.extend(spatial(joint, &body.joint.mount)),
                (None, None) => row.extend(["clamped", "", "", "", "", "", ""].map(str::to_owned)),
            }
            row
        }),
    );
}

/// Writes the section on closed loops; empty for a tree.
fn loops_section(html: &mut String, machine: &Machine) {
    if machine.closures.is_empty() {
        return;
    }
    html.push_str(
        "<h2>Closed loops</h2>\n<p>A loop holds two points together by the force <i>m</i> <b>g̈</b> + <i>c</i> <b>ġ</b> + \
         <i>k</i> <b>g</b> on the gap <b>g</b> between them: a ball joint by the penalty method. A rigid loop has no gap: constraint \
         forces hold its points.</p>\n",
    );
    let head = ["loop", "from", "offset (m)", "to", "offset (m)", "k (N/m)", "c (N·s/m)", "m (kg)"];
    table(
        html,
        &head,
        machine.closures.iter().map(|closure| {
            let mut row = vec![escape(&closure.name).into_owned()];
            for (end, offset_m) in closure.ends.into_iter().zip(&closure.offsets_m) {
                row.push(end.on_body().map_or_else(
                    || "root".to_owned(),
                    |(body, position_m)| format!("{} at {} m", escape(&machine.bodies[body].name), number(position_m)),
                ));
                row.push(vector(offset_m.as_slice()));
            }
            let penalty = [closure.stiffness_n_m, closure.damping_n_s_m, closure.inertia_kg];
            row.extend(match closure.rigid {
                true => ["rigid", "", ""].map(str::to_owned),
                false => penalty.map(number),
            });
            row
        }),
    );
}

/// Writes the section on skates and wheels; empty without them.
fn no_slips_section(html: &mut String, machine: &Machine) {
    if machine.no_slips.is_empty() {
        return;
    }
    html.push_str(
        "<h2>Skates and wheels</h2>\n<p>A skate moves along its direction only, the point of contact of a wheel does not slip, on planes \
         that are fixed in the root frame.</p>\n",
    );
    let head =
        ["name", "on", "offset (m)", "kind", "direction or axis", "plane normal", "point of the plane (m)", "normal"];
    table(
        html,
        &head,
        machine.no_slips.iter().map(|no_slip| {
            let body = escape(&machine.bodies[no_slip.body].name);
            let (kind, direction) = match &no_slip.runner {
                Runner::Skate { direction } => ("skate".to_owned(), direction),
                Runner::Wheel { axis, radius_m, rolling } => {
                    let rolls = if *rolling { "rolling" } else { "sliding along its heading" };
                    (format!("wheel of radius {} m, {rolls}", number(*radius_m)), axis)
                }
            };
            vec![
                escape(&no_slip.name).into_owned(),
                format!("{body} at {} m", number(no_slip.position_m)),
                vector(no_slip.offset_m.as_slice()),
                kind,
                vector(direction.as_slice()),
                vector(no_slip.plane_normal.as_slice()),
                vector(no_slip.plane_point_m.as_slice()),
                if no_slip.hold_normal { "held" } else { "free" }.to_owned(),
            ]
        }),
    );
}

/// Describes a spatial joint. The start attitude is given as a rotation vector; a free joint has no spring and no damper.
fn spatial(joint: &Spatial, mount: &Matrix3<f64>) -> Vec<String> {
    let kind = match &joint.freedom {
        SpatialFreedom::Universal { parent_axis, body_axis } => {
            format!("universal about {} and {}", vector(parent_axis.as_slice()), vector(body_axis.as_slice()))
        }
        SpatialFreedom::Ball => "ball".to_owned(),
        SpatialFreedom::Free => "free".to_owned(),
    };
    let mut row = vec![kind, vector(rotation_vector(mount).as_slice())];
    let drive = [joint.stiffness_n_m_rad, joint.damping_n_m_s_rad];
    row.extend(drive.map(|value| if joint.freedom == SpatialFreedom::Free { String::new() } else { number(value) }));
    row.extend(["", "", ""].map(str::to_owned));
    row
}

/// Describes a joint with one degree of freedom. The columns have the units of a revolute joint; cells of a prismatic joint include
/// their units.
fn one_freedom(kind: &JointKind, travel: Travel, joint: &OneFreedom) -> Vec<String> {
    let motion = kind.described();
    let unit = travel.units()[0];
    let drive = &joint.motor;
    let latch = joint.latch.as_ref().map_or("none".to_owned(), |latch| match latch.kind {
        LatchKind::Elastic => {
            let stiffness = travel.words("N·m/rad");
            format!("at {} {unit}, {} {stiffness}", number(latch.angle_rad), number(latch.stiffness_n_m_rad))
        }
        LatchKind::Rigid => format!("rigid, at {} {unit}", number(latch.angle_rad)),
    });
    let spring = joint.spring.as_ref().map_or(String::new(), |spring| {
        let [stiffness, damping] = [spring.stiffness_n_m_rad, spring.damping_n_m_s_rad].map(number);
        format!(
            ", own spring {stiffness} {} and {damping} {}, slack at {} {unit}",
            travel.words("N·m/rad"),
            travel.words("N·m·s/rad"),
            number(spring.rest_angle_rad)
        )
    });
    let about = if travel == Travel::Rotation { "about" } else { "along" };
    let kind = format!("{motion} {about} {}{spring}", vector(joint.axis.as_slice()));
    let numbers = [
        (joint.start_angle_rad, "rad"),
        (drive.stiffness_n_m_rad, "N·m/rad"),
        (drive.damping_n_m_s_rad, "N·m·s/rad"),
        (drive.constant_torque_n_m, "N·m"),
        (drive.torque_limit_n_m, "N·m"),
    ];
    let numbers = numbers.map(|(value, unit)| match travel {
        Travel::Rotation => number(value),
        Travel::Translation => {
            format!("{} {}", number(value), if unit == "rad" { "m".into() } else { travel.words(unit) })
        }
    });
    [kind].into_iter().chain(numbers).chain([latch]).collect()
}

fn experiment_section(html: &mut String, machine: &Machine) {
    let (experiment, solver) = (&machine.experiment, &machine.solver);
    let steps = match solver.fixed_step_s {
        None => "Any other step works: the integrator chooses its own steps".to_owned(),
        Some(step_s) => {
            format!("Any other step works: the integrator takes fixed steps of at most {} s", number(step_s))
        }
    };
    let _ = write!(
        html,
        "<h2>Default experiment</h2>\n<p>From {} s to {} s with a communication step of {} s and a solver tolerance of \
         {}. {steps} and locates releases and latch closings inside them. Gravity is {} m/s².</p>\n",
        number(experiment.start_time_s),
        number(experiment.stop_time_s),
        number(experiment.step_s),
        number(solver.tolerance),
        vector(machine.gravity_m_s2.as_slice())
    );
}

fn variables_section(html: &mut String, variables: &[Variable]) {
    for (title, causality) in
        [("Inputs", Causality::Input), ("Outputs", Causality::Output), ("Parameters", Causality::Parameter)]
    {
        let rows: Vec<&Variable> = variables.iter().filter(|v| v.causality == causality).collect();
        let _ = writeln!(html, "<h2 id=\"{}\">{title} ({})</h2>", title.to_lowercase(), rows.len());
        let head: &[&str] = match causality {
            Causality::Output => &["name", "type", "unit", "meaning"],
            Causality::Input | Causality::Parameter | Causality::Local | Causality::Independent => {
                &["name", "type", "unit", "start", "meaning"]
            }
        };
        table(
            html,
            head,
            rows.into_iter().map(|variable| {
                let mut row =
                    vec![format!("<code>{}</code>", escape(&variable.name)), type_name(variable), unit(variable)];
                if causality != Causality::Output {
                    row.push(start(&variable.value));
                }
                row.push(escape(&variable.description).into_owned());
                row
            }),
        );
    }
}

fn type_name(variable: &Variable) -> String {
    let name = match variable.value {
        Value::Real(_) => "Real",
        Value::Integer(_) => "Integer",
        Value::Boolean(_) => "Boolean",
    };
    match (variable.causality, variable.variability) {
        (Causality::Parameter, Variability::Fixed) => format!("{name}, fixed"),
        (Causality::Parameter, _) => format!("{name}, tunable"),
        _ => name.to_owned(),
    }
}

/// Unit followed by the display unit, such as `rad (deg)`.
fn unit(variable: &Variable) -> String {
    let declared = TYPES.iter().find(|t| Some(t.name) == variable.declared_type);
    let Some(unit) = declared.and_then(|t| UNITS.iter().find(|unit| unit.name == t.unit)) else {
        return String::new();
    };
    match unit.display {
        Some((display, _)) => format!("{} ({display})", unit.name),
        None => unit.name.to_owned(),
    }
}

fn start(value: &Value) -> String {
    match value {
        Value::Real(value) => number(*value),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packaging::drawing::tests::two_body_machine;
    use foldwing_engine::machine::{Closure, JointKind, LoopEnd};

    /// The page contains the names of the model, escapes its texts, has no external references and closes its tags.
    #[test]
    fn page_is_complete_and_self_contained() {
        let html = page(&two_body_machine(), &[], &Extras::default());
        for expected in ["<h1>TwoBodies</h1>", "one wing &amp; a joint", "<svg", "<td>outer</td>", "260 N·m/rad"] {
            assert!(html.contains(expected), "{expected} is missing");
        }
        assert!(!html.contains("http"), "the page must stand alone");
        for tag in ["table", "tr", "td", "th", "figure", "svg", "p", "h2"] {
            let open = html.matches(&format!("<{tag}>")).count() + html.matches(&format!("<{tag} ")).count();
            assert_eq!(open, html.matches(&format!("</{tag}>")).count(), "<{tag}> and </{tag}>");
        }
    }

    /// The start attitude is shown for a universal, ball or free joint; the caption describes the drawing; every table row has all
    /// cells.
    #[test]
    fn joints_of_several_degrees_of_freedom_are_described() {
        let mut machine = two_body_machine();
        machine.bodies[1].joint.mount = *nalgebra::Rotation3::new(nalgebra::Vector3::new(0.0, 0.5, 0.0)).matrix();
        let joint = |freedom| {
            JointKind::Spatial(Box::new(Spatial {
                freedom,
                stiffness_n_m_rad: 2.5,
                damping_n_m_s_rad: 0.0,
                start_angular_velocity_rad_s: nalgebra::Vector3::zeros(),
                start_velocity_m_s: nalgebra::Vector3::zeros(),
            }))
        };
        machine.bodies[1].joint.kind = joint(SpatialFreedom::Ball);
        let html = page(&machine, &[], &Extras::default());
        assert!(html.contains("<td>ball</td><td>(0, 0.5, 0)</td><td>2.5</td><td>0</td>"), "{html}");
        assert!(html.contains("Undeformed wing: in its start attitude."));
        machine.bodies[1].joint.kind = joint(SpatialFreedom::Free);
        let html = page(&machine, &[], &Extras::default());
        assert!(html.contains("<td>free</td><td>(0, 0.5, 0)</td><td></td><td></td><td></td><td></td><td></td></tr>"));
    }

    /// Loops are listed with both ends and their penalty in the table, and shown in the drawing, which has only the start position.
    #[test]
    fn closed_loops_are_described() {
        let mut machine = two_body_machine();
        machine.closures.push(Closure {
            name: "pin".into(),
            ends: [LoopEnd::Body { index: 0, position_m: 0.1 }, LoopEnd::Body { index: 1, position_m: 0.05 }],
            offsets_m: [nalgebra::Vector3::zeros(), nalgebra::Vector3::new(0.0, 0.02, 0.0)],
            rigid: false,
            inertia_kg: 0.0,
            damping_n_s_m: 25.0,
            stiffness_n_m: 4e5,
        });
        let html = page(&machine, &[], &Extras::default());
        let row = "<td>pin</td><td>inner at 0.1 m</td><td>(0, 0, 0)</td><td>outer at 0.05 m</td><td>(0, 0.02, 0)</td>\
                   <td>400000</td><td>25</td><td>0</td>";
        assert!(html.contains(row), "{html}");
        assert_eq!(html.matches("<title>loop pin</title>").count(), 2);
        assert!(
            html.contains("at its start angles, where its closed loops close") && !html.contains("class=\"ghost\"")
        );
    }
}

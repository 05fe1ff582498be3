//! Third pass: builds the machine with a [`MachineBuilder`], and reports errors of the machine with the keys and lines
//! of the file.

use crate::checker::Checker;
use crate::copies::Copies;
use crate::document::Document;
use crate::error::Problem;
use crate::file::ModelFile;
use crate::meant::did_you_mean;
use crate::run::{MethodFile, ModeFile};
use crate::{air, attachments, body, failures, joints, loops, modal_body, no_slips, sections, shaped};
use foldwing_engine::machine::builder::MachineBuilder;
use foldwing_engine::machine::fault::{Fault as MachineFault, Subject};
use foldwing_engine::machine::{Machine, Method, Solver};
use sections::Sections;

/// Default fixed step of real-time mode, in s.
const REAL_TIME_STEP_S: f64 = 1e-3;

/// Reports an error of the machine with the key and line in the file.
fn tell(fault: &MachineFault, file: &ModelFile, checker: &mut Checker) {
    if checker.has_stand_in(&fault.place.0) {
        return;
    }
    let path = path_of(&fault.place.0, file, checker);
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    let mut allowed = fault.allowed.clone();
    for (machine, file) in WORDS {
        allowed = allowed.replace(machine, file);
    }
    match &fault.subject {
        Subject::Value => checker.refuse(&path, allowed),
        Subject::State => match checker.plain_number(&path) {
            Some(allowed) => checker.refuse(&path, allowed),
            None => checker.refuse_as(&path, &fault.value, allowed),
        },
        Subject::Name { known } => {
            let name = fault.value.trim_matches('"');
            let hint = did_you_mean(name, known.iter().map(String::as_str));
            checker.refuse(&path, allowed + &hint);
        }
    }
}

/// Path in the file for a path in the machine.
fn path_of(place: &[String], file: &ModelFile, checker: &Checker) -> Vec<String> {
    let mut path: Vec<String> = place.to_vec();
    for part in path.iter_mut().skip(1) {
        if let Some((_, key)) = KEYS.iter().find(|(field, _)| field == part) {
            *part = (*key).to_owned();
        }
    }
    let states = |keys: &[&'static str], table: &[String]| -> Option<&'static str> {
        let path = |key| -> Vec<&str> { table.iter().map(String::as_str).chain([key]).collect() };
        keys.iter().copied().find(|key| checker.states(&path(*key)))
    };
    let kind = path[0].clone();
    match (kind.as_str(), path.get(2).map(String::as_str)) {
        ("air", _) => path[0] = "aerodynamics".to_owned(),
        ("surface", _) => {
            let stated = file.surface.iter().find(|(_, surface)| path.get(1) == Some(&surface.body));
            if let Some((name, _)) = stated {
                path[1] = name.clone();
            }
        }
        ("failure", Some("when")) if path.get(3).is_some_and(|part| part == "value") => {
            if let Some(key) = states(&failures::BOUNDS, &path[..3]) {
                path[3] = key.to_owned();
            }
        }
        ("joint", Some("offset_m")) => path[2] = "parent_offset_m".to_owned(),
        // rigid bodies have a separate table that includes their mass; an error that concerns all bodies has no
        // name
        ("body" | "mass", _)
            if path.get(1).is_some_and(|name| file.rigid_body.contains_key(name) && !file.mass.contains_key(name)) =>
        {
            path[0] = "rigid_body".to_owned();
            if path.get(2).is_some_and(|part| part == "offset_m") {
                path[2] = "centre_of_mass_m".to_owned();
            }
        }
        // so do modal bodies
        ("body", _) if path.get(1).is_some_and(|name| file.modal_body.contains_key(name)) => {
            path[0] = "modal_body".to_owned();
            // mode shapes are in separate arrays for each type
            if let ("flap" | "edge", Some(field)) = (path[2].as_str(), path.get(3).cloned()) {
                let key = match field.as_str() {
                    "coefficients" => "shapes",
                    "damping_ratio" => "damping_ratios",
                    _ => "start_m",
                };
                path[2] = format!("{}_{key}", path[2]);
                path.truncate(3);
            } else if path[2] == "flap" {
                path[2] = "flap_shapes".to_owned();
            }
        }
        ("body", Some("natural_strain")) => {
            let key = states(&["twist_1_m", "curvature_y_1_m", "curvature_z_1_m"], &path[..2]);
            path[2] = key.unwrap_or("natural_curvature_1_m").to_owned();
        }
        ("body", Some("section")) => {
            if let Some(key) = states(&["width_taper", "height_taper"], &path[..2]) {
                path[2] = key.to_owned();
            }
        }
        ("loop", Some("positions_m")) if states(&["positions_m"], &path[..2]).is_none() => {
            path[2] = "bodies".to_owned();
        }
        _ => {}
    }
    path
}

/// Fields of the machine and its builder whose keys have different names, with these keys.
const KEYS: &[(&str, &str)] = &[
    ("start_angle_rad", "start_angle_deg"),
    ("start_rate_rad_s", "start_rate_deg_s"),
    ("start_angular_velocity_rad_s", "start_angular_velocity_deg_s"),
    ("rate_limit_rad_s", "rate_limit_deg_s"),
    ("command_rad", "command_deg"),
    ("rest_angle_rad", "rest_angle_deg"),
    ("angle_rad", "angle_deg"),
    ("capture_rad", "capture_deg"),
    ("lower_rad", "lower_deg"),
    ("upper_rad", "upper_deg"),
    ("twist_rad", "twist_deg"),
    ("flap_stiffness_n_m2", "flap_stiffness_N_m2"),
    ("edge_stiffness_n_m2", "edge_stiffness_N_m2"),
    ("zero_lift_angle_rad", "zero_lift_angle_deg"),
    ("stiffness_n_m_rad", "stiffness_N_m_rad"),
    ("damping_n_m_s_rad", "damping_N_m_s_rad"),
    ("constant_torque_n_m", "constant_torque_N_m"),
    ("torque_limit_n_m", "torque_limit_N_m"),
    ("torque_constant_n_m_a", "torque_constant_N_m_A"),
    ("force_constant_n_a", "force_constant_N_A"),
    ("inductance_h", "inductance_H"),
    ("voltage_v", "voltage_V"),
    ("start_current_a", "start_current_A"),
    ("constant_force_n", "constant_force_N"),
    ("force_limit_n", "force_limit_N"),
    ("stiffness_n_m", "stiffness_N_m"),
    ("damping_n_s_m", "damping_N_s_m"),
    ("station_positions_m", "load_station_positions_m"),
    ("most_iterations", "max_iterations"),
    ("to_rad", "to_deg"),
    ("rate_rad_s", "rate_deg_s"),
    ("slip_rad_s", "slip_deg_s"),
    ("torque_n_m", "torque_N_m"),
    ("force_n", "force_N"),
];

/// Words in messages of the machine, and their replacements in messages about the file.
const WORDS: &[(&str, &str)] = &[
    ("rad/s", "deg/s"),
    ("mount_rotation ", "mount_rotation_deg "),
    ("stiffness_n_m_rad", "stiffness_N_m_rad"),
    ("lower_rad", "lower_deg"),
    ("upper_rad", "upper_deg"),
    ("write stiffness_n_m ", "write stiffness_N_m "),
    ("start_angle lies within capture of angle", "start_angle_deg lies within capture_deg of angle_deg"),
    ("start_position lies within capture of position", "start_position_m lies within capture_m of position_m"),
    ("at least one surface", "at least one table [surface.<name>]"),
];

/// Validates a file that conforms to the schema.
///
/// # Errors
/// All problems, in the order of the file.
pub(super) fn machine(file: &ModelFile, document: &Document, copies: &Copies) -> Result<Machine, Vec<Problem>> {
    let mut checker = Checker::new(document, &copies.names);
    for (table, name, copy) in &copies.taken {
        let allowed = format!("a table under another name: {copy:?} is one of the copies of {name:?}");
        checker.refuse_as(&[table, copy], format!("the name {copy:?}"), allowed);
    }
    let machine = describe(file, &mut checker).build();
    if let Err(refused) = &machine {
        refused.faults.iter().for_each(|fault| tell(fault, file, &mut checker));
    }
    let mut problems = checker.into_problems();
    problems.sort_by_key(|problem| problem.line);
    match machine {
        Ok(machine) if problems.is_empty() => Ok(machine),
        _ => Err(problems),
    }
}

/// Creates the machine described by the file.
fn describe(file: &ModelFile, checker: &mut Checker) -> MachineBuilder {
    let materials = shaped::materials(file, checker);
    let build = |(name, section)| (String::as_str(name), sections::build(name, section, &materials, checker));
    let sections: Sections = file.section.iter().map(build).collect();
    let mut machine = Machine::builder(&file.name)
        .description(&file.description)
        .gravity_m_s2(file.gravity_m_s2)
        .solver(solver(file, checker));
    let mut lawless = Vec::new();
    let mut joints = joints::build_all(file, checker);
    for ((name, body), joint) in file.body.iter().zip(joints.iter().cloned()) {
        let law = body::section_law(name, body, &sections, checker);
        if law.is_none() {
            lawless.push(name.as_str());
        }
        let outline =
            sections.get(body.section.as_str()).and_then(Option::as_ref).map_or(&[][..], |built| built.aerofoil());
        machine = machine.body(body::build(name, body, law, checker).aerofoil(outline), joint);
    }
    let mut others = joints.split_off(file.body.len());
    let modal = others.split_off(file.rigid_body.len());
    for ((name, body), joint) in file.rigid_body.iter().zip(others) {
        machine = machine.body(body::build_rigid(name, body), joint);
    }
    for ((name, body), joint) in file.modal_body.iter().zip(modal) {
        machine = machine.body(modal_body::build(name, body, checker), joint);
    }
    machine = attachments::add(file, &lawless, machine);
    machine = no_slips::add(file, loops::add(file, machine));
    machine = failures::add(file, machine, checker);
    machine = air::add(file, &lawless, machine, checker);
    let simulation = &file.simulation;
    if checker.states(&["simulation", "step_s"]) {
        machine = machine.step_s(simulation.step_s);
    }
    let machine = machine.start_time_s(simulation.start_time_s).stop_time_s(simulation.stop_time_s);
    machine.start(simulation.start.into())
}

fn solver(file: &ModelFile, checker: &mut Checker) -> Solver {
    let solver = &file.solver;
    let real_time = solver.mode == ModeFile::RealTime;
    if !real_time && checker.states(&["solver", "max_iterations"]) {
        checker.refuse(&["solver", "max_iterations"], "this key only with mode = \"real_time\"");
    }
    let method = if real_time && !checker.states(&["solver", "method"]) { MethodFile::Sdirk2 } else { solver.method };
    Solver {
        method: Method::from(method),
        tolerance: solver.tolerance,
        max_step_s: solver.max_step_s,
        min_step_s: solver.min_step_s,
        fixed_step_s: solver.fixed_step_s.or(real_time.then_some(REAL_TIME_STEP_S)),
        rho_infinity: solver.rho_infinity,
        most_iterations: real_time.then_some(solver.max_iterations as usize),
    }
}

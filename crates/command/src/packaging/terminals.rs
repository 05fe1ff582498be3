//! `terminalsAndIcons/terminalsAndIcons.xml` of FMI 3.0: the path of the icon, and groups of variables at the root, at each driven
//! joint and at each tip, which a tool can connect as a unit.

use crate::packaging::xml::{self, Xml, leaf, nest};
use foldwing_engine::machine::Machine;
use foldwing_fmi::interface::{Causality, Interface};
use std::io;

/// Folder in the archive.
pub(super) const FOLDER: &str = "terminalsAndIcons";

/// Half the side of the square in which tools draw the icon, in their units, and the size of one such unit in mm.
const HALF: &str = "100.0";
const UNIT_MM: &str = "0.1";

/// A terminal: name, description, prefix of the names of its variables, and further variables.
struct Terminal {
    name: String,
    description: String,
    prefix: String,
    further: &'static [&'static str],
}

/// Returns the complete text, ending in a line feed.
pub(super) fn document(machine: &Machine, interface: &Interface) -> String {
    let root = Terminal {
        name: "root".to_owned(),
        description: "flange at the root: loads on the support, motion of the root".to_owned(),
        prefix: "root.".to_owned(),
        further: &["gravity"],
    };
    let joints = machine.one_freedoms().map(|(body, _)| {
        let joint = &machine.bodies[body].joint.name;
        Terminal {
            name: joint.clone(),
            description: format!("joint {joint}: motor, latch and motion"),
            prefix: format!("{joint}."),
            further: &[],
        }
    });
    let one = machine.tip_bodies().count() == 1;
    let tips = machine.tip_bodies().map(|body| {
        let body = &machine.bodies[body].name;
        let name = if one { "tip".to_owned() } else { format!("tip.{body}") };
        Terminal { prefix: format!("{name}."), description: format!("free end of body {body}"), name, further: &[] }
    });
    let terminals: Vec<Terminal> = std::iter::once(root).chain(joints).chain(tips).collect();
    xml::document(|xml| {
        nest(xml, "fmiTerminalsAndIcons", &vec![("fmiVersion", "3.0".to_owned())], |xml| {
            write_picture(xml)?;
            nest(xml, "Terminals", &vec![], |xml| {
                terminals.iter().try_for_each(|terminal| write_terminal(xml, terminal, interface))
            })
        })
    })
}

fn write_picture(xml: &mut Xml) -> io::Result<()> {
    let corners = || {
        let at = |name, sign| (name, format!("{sign}{HALF}"));
        vec![at("x1", "-"), at("y1", "-"), at("x2", ""), at("y2", "")]
    };
    nest(xml, "GraphicalRepresentation", &vec![], |xml| {
        let mut system = corners();
        system.push(("suggestedScalingFactorTo_mm", UNIT_MM.to_owned()));
        leaf(xml, "CoordinateSystem", &system)?;
        leaf(xml, "Icon", &corners())
    })
}

fn write_terminal(xml: &mut Xml, terminal: &Terminal, interface: &Interface) -> io::Result<()> {
    let attributes = vec![
        ("name", terminal.name.clone()),
        ("matchingRule", "plug".to_owned()),
        ("description", terminal.description.clone()),
    ];
    let member = |name: &str| match name.strip_prefix(&terminal.prefix) {
        Some(member) => Some(member.to_owned()),
        None => terminal.further.contains(&name).then(|| name.to_owned()),
    };
    nest(xml, "Terminal", &attributes, |xml| {
        let connected = |causality| matches!(causality, Causality::Input | Causality::Output);
        let arrays = interface.arrays().iter().filter(|array| connected(interface.head(array).causality));
        arrays.filter_map(|array| Some((array, member(&array.name)?))).try_for_each(|(array, member)| {
            let attributes = vec![
                ("variableName", array.name.clone()),
                ("memberName", member),
                ("variableKind", "signal".to_owned()),
            ];
            leaf(xml, "TerminalMemberVariable", &attributes)
        })
    })
}

//! A system of one FMU as an SSP 1.0 archive: its structure (SSD), the values of its parameters (SSV) with angles in degrees, and the
//! mapping of these onto the variables of the FMU (SSM).
//!
//! Like the FMU, the archive depends only on the model and the version, not on dates or paths.

use crate::packaging::archive::{Entry, archive};
use crate::packaging::xml::{self, Attributes, Xml, leaf, nest, real};
use crate::packaging::{Kinds, TOOL, VERSION};
use foldwing_engine::machine::Machine;
use foldwing_fmi::interface::{BASES, Causality, TYPES, UNITS, Unit, Value, Variable};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::io;

/// Name of the component in the system.
pub const COMPONENT: &str = "model";
/// File of the system structure; it is the first member of the archive.
pub const STRUCTURE: &str = "SystemStructure.ssd";

const FMU: &str = "resources/model.fmu";
const VALUES: &str = "resources/parameters.ssv";
const MAPPING: &str = "resources/parameters.ssm";
const NAMESPACE: &str = "http://ssp-standard.org/SSP1/SystemStructure";
/// Magnitude that means that there is no limit.
const NO_LIMIT: f64 = 1e30;
/// rad per degree.
const RADIANS: f64 = PI / 180.0;
/// Digits after which a rounded number of degrees is tried: model files contain fewer.
const DIGITS: usize = 14;

/// Returns the bytes of the archive; `variables` are the scalar variables of the FMU of the model, whose bytes are `fmu`.
pub fn system(machine: &Machine, variables: &[Variable], kinds: Kinds, fmu: Vec<u8>) -> Vec<u8> {
    let texts = [
        (STRUCTURE, structure(machine, variables, kinds)),
        (VALUES, values(machine, variables)),
        (MAPPING, mapping(variables)),
    ];
    let mut entries: BTreeMap<String, Entry> =
        texts.into_iter().map(|(path, text)| (path.to_owned(), Entry::data(text.into_bytes()))).collect();
    entries.insert(FMU.to_owned(), Entry::data(fmu));
    archive(&entries)
}

fn structure(machine: &Machine, variables: &[Variable], kinds: Kinds) -> String {
    let mut root = spaces(&[("xmlns:ssd", "Description"), ("xmlns:ssc", "Common")]);
    root.extend([
        ("name", machine.name.clone()),
        ("version", "1.0".to_owned()),
        ("description", machine.description.clone()),
        ("generationTool", format!("{TOOL} {VERSION}")),
    ]);
    let experiment = &machine.experiment;
    xml::document(|xml| {
        nest(xml, "ssd:SystemStructureDescription", &root, |xml| {
            nest(xml, "ssd:System", &vec![("name", machine.name.clone())], |xml| {
                nest(xml, "ssd:Elements", &vec![], |xml| component(xml, variables, kinds))
            })?;
            write_units(xml, "ssd:Units", variables)?;
            leaf(
                xml,
                "ssd:DefaultExperiment",
                &vec![("startTime", real(experiment.start_time_s)), ("stopTime", real(experiment.stop_time_s))],
            )
        })
    })
}

fn component(xml: &mut Xml, variables: &[Variable], kinds: Kinds) -> io::Result<()> {
    let implementation = match (kinds.co_simulation, kinds.model_exchange) {
        (true, true) => "any",
        (_, false) => "CoSimulation",
        (false, true) => "ModelExchange",
    };
    let attributes = vec![
        ("name", COMPONENT.to_owned()),
        ("type", "application/x-fmu-sharedlibrary".to_owned()),
        ("source", FMU.to_owned()),
        ("implementation", implementation.to_owned()),
    ];
    nest(xml, "ssd:Component", &attributes, |xml| {
        nest(xml, "ssd:Connectors", &vec![], |xml| {
            variables.iter().try_for_each(|variable| {
                let Some(kind) = connector(variable.causality) else { return Ok(()) };
                let attributes = vec![("name", variable.name.clone()), ("kind", kind.to_owned())];
                nest(xml, "ssd:Connector", &attributes, |xml| match (variable.value, unit_of(variable)) {
                    (Value::Real(_), Some(unit)) => leaf(xml, "ssc:Real", &vec![("unit", unit.name.to_owned())]),
                    (Value::Real(_), None) => leaf(xml, "ssc:Real", &vec![]),
                    (Value::Integer(_), _) => leaf(xml, "ssc:Integer", &vec![]),
                    (Value::Boolean(_), _) => leaf(xml, "ssc:Boolean", &vec![]),
                })
            })
        })?;
        nest(xml, "ssd:ParameterBindings", &vec![], |xml| {
            nest(xml, "ssd:ParameterBinding", &vec![("source", VALUES.to_owned())], |xml| {
                leaf(xml, "ssd:ParameterMapping", &vec![("source", MAPPING.to_owned())])
            })
        })
    })
}

/// Kind of the connector of a variable with this causality; states and time have none.
fn connector(causality: Causality) -> Option<&'static str> {
    match causality {
        Causality::Input => Some("input"),
        Causality::Output => Some("output"),
        Causality::Parameter => Some("parameter"),
        Causality::Local | Causality::Independent => None,
    }
}

fn values(machine: &Machine, variables: &[Variable]) -> String {
    let mut root = spaces(&[("xmlns:ssv", "ParameterValues"), ("xmlns:ssc", "Common")]);
    root.extend([("name", format!("{} parameters", machine.name)), ("version", "1.0".to_owned())]);
    let shown: Vec<Variable> = parameters(variables).cloned().collect();
    xml::document(|xml| {
        nest(xml, "ssv:ParameterSet", &root, |xml| {
            nest(xml, "ssv:Parameters", &vec![], |xml| {
                shown.iter().try_for_each(|variable| {
                    nest(xml, "ssv:Parameter", &vec![("name", source(variable))], |xml| value(xml, variable))
                })
            })?;
            write_units(xml, "ssv:Units", &shown)
        })
    })
}

fn value(xml: &mut Xml, variable: &Variable) -> io::Result<()> {
    let number = match variable.value {
        Value::Real(number) => number,
        Value::Integer(number) => return leaf(xml, "ssv:Integer", &vec![("value", number.to_string())]),
        Value::Boolean(truth) => return leaf(xml, "ssv:Boolean", &vec![("value", truth.to_string())]),
    };
    let mut attributes = vec![("value", real(if in_degrees(variable) { degrees(number) } else { number }))];
    if let Some(unit) = unit_of(variable) {
        let shown = unit.display.filter(|_| in_degrees(variable)).map_or(unit.name, |(name, _)| name);
        attributes.push(("unit", shown.to_owned()));
    }
    leaf(xml, "ssv:Real", &attributes)
}

/// The entries also name parameters without a transformation: those without an entry would not be set.
fn mapping(variables: &[Variable]) -> String {
    let mut root = spaces(&[("xmlns:ssm", "ParameterMapping"), ("xmlns:ssc", "Common")]);
    root.push(("version", "1.0".to_owned()));
    xml::document(|xml| {
        nest(xml, "ssm:ParameterMapping", &root, |xml| {
            parameters(variables).try_for_each(|variable| {
                let mut attributes = vec![("source", source(variable)), ("target", variable.name.clone())];
                if !in_degrees(variable) {
                    return leaf(xml, "ssm:MappingEntry", &attributes);
                }
                // the transformation is the conversion
                attributes.push(("suppressUnitConversion", "true".to_owned()));
                nest(xml, "ssm:MappingEntry", &attributes, |xml| {
                    leaf(xml, "ssc:LinearTransformation", &vec![("factor", real(RADIANS)), ("offset", real(0.0))])
                })
            })
        })
    })
}

/// Namespaces of SSP 1.0 by prefix.
fn spaces(of: &[(&'static str, &str)]) -> Attributes {
    of.iter().map(|(prefix, name)| (*prefix, format!("{NAMESPACE}{name}"))).collect()
}

fn parameters(variables: &[Variable]) -> impl Iterator<Item = &Variable> {
    variables.iter().filter(|variable| variable.causality == Causality::Parameter)
}

/// Name of a parameter in the SSV: that of the variable, with its unit if the value is in degrees, as in model files.
fn source(variable: &Variable) -> String {
    match unit_of(variable).and_then(|unit| unit.display) {
        Some((unit, _)) if in_degrees(variable) => format!("{}_{}", variable.name, unit.replace('/', "_")),
        _ => variable.name.clone(),
    }
}

fn unit_of(variable: &Variable) -> Option<&'static Unit> {
    let declared = TYPES.iter().find(|declared| Some(declared.name) == variable.declared_type)?;
    UNITS.iter().find(|unit| unit.name == declared.unit)
}

/// Returns whether a parameter is in degrees; [`NO_LIMIT`] is not, since it would be a limit after the conversion.
fn in_degrees(variable: &Variable) -> bool {
    let bounded = !matches!(variable.value, Value::Real(number) if number.abs() >= NO_LIMIT);
    bounded && unit_of(variable).is_some_and(|unit| unit.display.is_some())
}

/// Degrees whose product with [`RADIANS`] is the number in rad to the last bit, if there are such degrees, as for all angles of model
/// files, and otherwise smaller by the last bit, so that it stays within its bounds.
fn degrees(rad: f64) -> f64 {
    let near = rad / RADIANS;
    let short = format!("{near:.DIGITS$e}").parse().expect("the text is a number");
    let (above, below) = (near.next_up(), near.next_down());
    let same = |found: &f64| (found * RADIANS).to_bits() == rad.to_bits();
    let within = |found: &f64| (found * RADIANS).abs() <= rad.abs();
    let exact = [short, near, above, below].into_iter().find(same);
    exact.or_else(|| [near, above, below].into_iter().find(within)).unwrap_or(near)
}

/// Writes the units in use, with the display unit of each.
fn write_units(xml: &mut Xml, element: &str, variables: &[Variable]) -> io::Result<()> {
    let exposed: Vec<&Variable> = variables.iter().filter(|row| connector(row.causality).is_some()).collect();
    let used: Vec<&Unit> = UNITS.iter().filter(|unit| exposed.iter().any(|row| unit_of(row) == Some(*unit))).collect();
    if used.is_empty() {
        return Ok(());
    }
    nest(xml, element, &vec![], |xml| {
        used.iter().try_for_each(|unit| {
            write_unit(xml, unit.name, unit, None)?;
            unit.display.map_or(Ok(()), |(name, _)| write_unit(xml, name, unit, Some(RADIANS)))
        })
    })
}

fn write_unit(xml: &mut Xml, name: &str, unit: &Unit, factor: Option<f64>) -> io::Result<()> {
    nest(xml, "ssc:Unit", &vec![("name", name.to_owned())], |xml| {
        let bases = BASES.into_iter().zip(unit.exponents);
        let mut attributes: Attributes =
            bases.filter(|(_, power)| *power != 0).map(|(base, power)| (base, power.to_string())).collect();
        attributes.extend(factor.map(|factor| ("factor", real(factor))));
        leaf(xml, "ssc:BaseUnit", &attributes)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Degrees of model files are reproduced as they were written, and give the same bits in rad.
    #[test]
    fn degrees_are_those_of_the_model_file() {
        for tenth in -3600..=3600 {
            let written = f64::from(tenth) / 10.0;
            let rad = written.to_radians();
            assert_eq!((degrees(rad) * RADIANS).to_bits(), rad.to_bits(), "{written}");
            assert!((degrees(rad) - written).abs() < 1e-12, "{written}");
        }
        assert_eq!(degrees(170.0_f64.to_radians()), 170.0);
        // other angles in rad may have no such degrees, and the converted value never exceeds its bounds
        for thousandth in -3000..=3000 {
            let rad = f64::from(thousandth) / 1000.0;
            let found = degrees(rad) * RADIANS;
            assert!(found.abs() <= rad.abs() && (found - rad).abs() <= rad.abs() * f64::EPSILON, "{rad}");
        }
    }
}

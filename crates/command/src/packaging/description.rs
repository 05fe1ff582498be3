//! `modelDescription.xml`, generated from the variable table, in the element order of the FMI 2.0 schema.
//!
//! The text depends only on the model, the table and the version; it contains no date or path, so that packaging twice gives the same
//! bytes.

use crate::packaging::xml::{self, Attributes, Xml, leaf, nest, real};
use crate::packaging::{Kinds, TOOL, VERSION};
use foldwing_engine::machine::Machine;
use foldwing_engine::plant::Plant;
use foldwing_fmi::instance::LOG_CATEGORIES;
use foldwing_fmi::interface::{
    BASES, Causality, Dependencies, DependencyKind, Initial, RealType, TYPES, UNITS, Unit, Value, Variability, Variable,
};
use std::io;
use std::sync::Arc;

/// Capability flags of the `CoSimulation` element.
///
/// A flag may be true only if the capability is implemented, because importers rely on it.
const CAPABILITIES: [(&str, &str); 9] = [
    ("needsExecutionTool", "false"),
    ("canHandleVariableCommunicationStepSize", "true"),
    ("canInterpolateInputs", "true"),
    ("maxOutputDerivativeOrder", "1"),
    ("canRunAsynchronuously", "false"), // spelled as in the standard
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canNotUseMemoryManagementFunctions", "true"),
    ("canGetAndSetFMUstate", "true"),
    ("canSerializeFMUstate", "true"),
];

/// Capability flags of the `ModelExchange` element.
const EXCHANGE_CAPABILITIES: [(&str, &str); 7] = [
    ("needsExecutionTool", "false"),
    ("completedIntegratorStepNotNeeded", "false"),
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canNotUseMemoryManagementFunctions", "true"),
    ("canGetAndSetFMUstate", "true"),
    ("canSerializeFMUstate", "true"),
    ("providesDirectionalDerivative", "true"),
];

/// Maximum number of dependencies listed in `InitialUnknowns`, for 3 MB.
const MAXIMUM_INITIAL: usize = 200_000;

/// Returns the complete text of `modelDescription.xml`, ending in a line feed.
///
/// `variables` is the table of `machine`, in order, with the dependencies of each row; `guid` is the hash that the library checks on
/// instantiation. For Model Exchange the table must include the continuous states.
pub fn model_description(
    machine: &Machine,
    variables: &[Variable],
    dependencies: &[Dependencies],
    guid: &str,
    kinds: Kinds,
) -> String {
    xml::document(|xml| write_root(xml, machine, (variables, dependencies), guid, kinds))
}

fn write_root(
    xml: &mut Xml,
    machine: &Machine,
    (variables, dependencies): (&[Variable], &[Dependencies]),
    guid: &str,
    kinds: Kinds,
) -> io::Result<()> {
    let mut attributes: Attributes = vec![
        ("fmiVersion", "2.0".to_owned()),
        ("modelName", machine.name.clone()),
        ("guid", guid.to_owned()),
        ("description", machine.description.clone()),
        ("version", VERSION.to_owned()),
        ("license", "MIT OR Apache-2.0".to_owned()),
        ("generationTool", format!("{TOOL} {VERSION}")),
        ("variableNamingConvention", "structured".to_owned()),
    ];
    if kinds.model_exchange {
        let indicators = Plant::new(Arc::new(machine.clone())).exchange_indicator_count();
        attributes.push(("numberOfEventIndicators", indicators.to_string()));
    }
    nest(xml, "fmiModelDescription", &attributes, |xml| {
        let identifier = || vec![("modelIdentifier", machine.name.clone())];
        if kinds.model_exchange {
            let mut model_exchange: Attributes = identifier();
            model_exchange.extend(EXCHANGE_CAPABILITIES.map(|(name, value)| (name, value.to_owned())));
            leaf(xml, "ModelExchange", &model_exchange)?;
        }
        if kinds.co_simulation {
            let mut co_simulation: Attributes = identifier();
            co_simulation.extend(CAPABILITIES.map(|(name, value)| (name, value.to_owned())));
            // with aerodynamics the derivatives would be wrong, since they hold the aerodynamic loads constant
            co_simulation.push(("providesDirectionalDerivative", machine.air.is_none().to_string()));
            leaf(xml, "CoSimulation", &co_simulation)?;
        }
        write_units(xml, variables)?;
        write_types(xml, variables)?;
        write_log_categories(xml)?;
        write_experiment(xml, machine)?;
        nest(xml, "ModelVariables", &vec![], |xml| variables.iter().try_for_each(|v| write_variable(xml, v)))?;
        write_structure(xml, variables, dependencies)
    })
}

/// Writes the log categories.
pub(super) fn write_log_categories(xml: &mut Xml) -> io::Result<()> {
    nest(xml, "LogCategories", &vec![], |xml| {
        LOG_CATEGORIES.iter().try_for_each(|(name, description)| {
            leaf(xml, "Category", &vec![("name", name.to_string()), ("description", description.to_string())])
        })
    })
}

/// Units of the types in use: non-zero exponents of the base units, and the display unit.
pub(super) fn write_units(xml: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    let types = types_in_use(variables);
    let used: Vec<&Unit> = UNITS.iter().filter(|unit| types.iter().any(|t| t.unit == unit.name)).collect();
    if used.is_empty() {
        return Ok(());
    }
    nest(xml, "UnitDefinitions", &vec![], |xml| {
        used.iter().try_for_each(|unit| {
            nest(xml, "Unit", &vec![("name", unit.name.to_owned())], |xml| {
                let exponents: Attributes = BASES
                    .into_iter()
                    .zip(unit.exponents)
                    .filter(|(_, exponent)| *exponent != 0)
                    .map(|(base, exponent)| (base, exponent.to_string()))
                    .collect();
                leaf(xml, "BaseUnit", &exponents)?;
                match unit.display {
                    Some((name, factor)) => {
                        leaf(xml, "DisplayUnit", &vec![("name", name.to_owned()), ("factor", real(factor))])
                    }
                    None => Ok(()),
                }
            })
        })
    })
}

fn write_types(xml: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    let types = types_in_use(variables);
    if types.is_empty() {
        return Ok(());
    }
    nest(xml, "TypeDefinitions", &vec![], |xml| {
        types.iter().try_for_each(|t| {
            nest(xml, "SimpleType", &vec![("name", t.name.to_owned())], |xml| {
                let mut attributes = vec![("quantity", t.quantity.to_owned()), ("unit", t.unit.to_owned())];
                if let Some((display, _)) = UNITS.iter().find(|unit| unit.name == t.unit).and_then(|u| u.display) {
                    attributes.push(("displayUnit", display.to_owned()));
                }
                leaf(xml, "Real", &attributes)
            })
        })
    })
}

/// Declared types that occur in the table, in the order of [`TYPES`].
pub(super) fn types_in_use(variables: &[Variable]) -> Vec<&'static RealType> {
    TYPES.iter().filter(|t| variables.iter().any(|v| v.declared_type == Some(t.name))).collect()
}

pub(super) fn write_experiment(xml: &mut Xml, machine: &Machine) -> io::Result<()> {
    let experiment = &machine.experiment;
    leaf(
        xml,
        "DefaultExperiment",
        &vec![
            ("startTime", real(experiment.start_time_s)),
            ("stopTime", real(experiment.stop_time_s)),
            ("tolerance", real(machine.solver.tolerance)),
            ("stepSize", real(experiment.step_s)),
        ],
    )
}

fn write_variable(xml: &mut Xml, variable: &Variable) -> io::Result<()> {
    let mut attributes: Attributes = vec![
        ("name", variable.name.clone()),
        ("valueReference", variable.value_reference.to_string()),
        ("description", variable.description.clone()),
        ("causality", causality(variable.causality).to_owned()),
        ("variability", variability(variable.variability).to_owned()),
    ];
    if let Some(initial) = variable.initial {
        attributes.push(("initial", initial_word(initial).to_owned()));
    }
    nest(xml, "ScalarVariable", &attributes, |xml| write_type(xml, variable))
}

/// Writes the element for the type of a variable: declared type, bounds, and a start value if the standard requires one.
fn write_type(xml: &mut Xml, variable: &Variable) -> io::Result<()> {
    let mut attributes: Attributes = vec![];
    if let Some(name) = variable.declared_type {
        attributes.push(("declaredType", name.to_owned()));
    }
    attributes.extend(range(variable));
    let (element, start) = match variable.value {
        Value::Real(value) => ("Real", real(value)),
        Value::Integer(value) => ("Integer", value.to_string()),
        Value::Boolean(value) => ("Boolean", value.to_string()),
    };
    if let Some(nominal) = variable.nominal {
        attributes.push(("nominal", real(nominal)));
    }
    if has_start(variable) {
        attributes.push(("start", start));
    }
    if let Some(state) = variable.derivative_of {
        attributes.push(("derivative", (state + 1).to_string()));
    }
    // latches change rates and the work at events, and projections change redundant parameters
    if variable.nominal.is_some() {
        attributes.push(("reinit", "true".to_owned()));
    }
    leaf(xml, element, &attributes)
}

/// Attributes with the bounds of a variable, if it has any.
pub(super) fn range(variable: &Variable) -> Attributes {
    let Some((smallest, largest)) = variable.range else { return vec![] };
    let integer = matches!(variable.value, Value::Integer(_));
    let bound = |value: f64| if integer { format!("{value:.0}") } else { real(value) };
    vec![("min", bound(smallest)), ("max", bound(largest))]
}

/// `ModelStructure`: outputs and unknowns of Initialization Mode, with their dependencies.
fn write_structure(xml: &mut Xml, variables: &[Variable], dependencies: &[Dependencies]) -> io::Result<()> {
    let of = |index: usize| &dependencies[index - 1];
    nest(xml, "ModelStructure", &vec![], |xml| {
        let outputs: Vec<_> = rows(variables).filter(|(_, v)| v.causality == Causality::Output).collect();
        if !outputs.is_empty() {
            nest(xml, "Outputs", &vec![], |xml| {
                outputs.iter().try_for_each(|(index, _)| unknown(xml, *index, of(*index).on_all, &of(*index).running))
            })?;
        }
        let derivatives: Vec<_> = rows(variables).filter(|(_, v)| v.derivative_of.is_some()).collect();
        if !derivatives.is_empty() {
            nest(xml, "Derivatives", &vec![], |xml| {
                derivatives
                    .iter()
                    .try_for_each(|(index, _)| unknown(xml, *index, of(*index).on_all, &of(*index).running))
            })?;
        }
        let unknowns: Vec<_> = rows(variables).filter(|(_, v)| is_initial_unknown(v)).collect();
        if !unknowns.is_empty() {
            let short = has_short_lists(variables, dependencies);
            nest(xml, "InitialUnknowns", &vec![], |xml| {
                unknowns.iter().try_for_each(|(index, row)| {
                    // start values of states and derivatives depend on all quantities that act at the start
                    let on_all = of(*index).on_all || row.causality == Causality::Local || !short;
                    unknown(xml, *index, on_all, &of(*index).initial)
                })
            })?;
        }
        Ok(())
    })
}

/// Returns whether a variable is an unknown of Initialization Mode: an output, continuous state or state derivative whose initial value
/// is calculated. The standard requires exactly these (there are no calculated parameters).
pub(super) fn is_initial_unknown(variable: &Variable) -> bool {
    let exposed = variable.nominal.is_some() || variable.derivative_of.is_some();
    (variable.causality == Causality::Output || exposed)
        && matches!(variable.initial, Some(Initial::Calculated | Initial::Approximate))
}

/// Returns whether the lists of `InitialUnknowns` are written. Initial values depend on nearly all inputs and parameters: with many
/// outputs and loads the lists would be most of the description (10 of 13 MB for a wing with 1628 outputs), and a missing list means all.
fn has_short_lists(variables: &[Variable], dependencies: &[Dependencies]) -> bool {
    let lists = variables.iter().zip(dependencies).filter(|(variable, _)| is_initial_unknown(variable));
    lists.map(|(_, dependencies)| dependencies.initial.len()).sum::<usize>() <= MAXIMUM_INITIAL
}

/// Rows with their indices in `ModelVariables`, which start at 1.
fn rows(variables: &[Variable]) -> impl Iterator<Item = (usize, &Variable)> {
    variables.iter().enumerate().map(|(row, variable)| (row + 1, variable))
}

/// Writes one `Unknown`. An empty list of dependencies means that there are none and must be written; a missing list means all.
fn unknown(xml: &mut Xml, index: usize, on_all: bool, dependencies: &[(u32, DependencyKind)]) -> io::Result<()> {
    if on_all {
        return leaf(xml, "Unknown", &vec![("index", index.to_string())]);
    }
    let mut attributes = vec![("index", index.to_string())];
    attributes.extend(dependency_lists(dependencies, 1));
    leaf(xml, "Unknown", &attributes)
}

/// Lists of the dependencies and of their kinds, in order; the first row of the table has the index `first`.
pub(super) fn dependency_lists(dependencies: &[(u32, DependencyKind)], first: u32) -> Attributes {
    let mut sorted = dependencies.to_vec();
    sorted.sort_by_key(|(row, _)| *row);
    let join = |words: Vec<String>| words.join(" ");
    let rows = join(sorted.iter().map(|(row, _)| (row + first).to_string()).collect());
    let kinds = join(sorted.iter().map(|(_, kind)| dependency_kind(*kind).to_owned()).collect());
    vec![("dependencies", rows), ("dependenciesKind", kinds)]
}

/// Returns whether a variable has a start value: inputs, parameters, and continuous states with a known start value.
pub(super) fn has_start(variable: &Variable) -> bool {
    variable.causality == Causality::Input || matches!(variable.initial, Some(Initial::Exact | Initial::Approximate))
}

pub(super) fn initial_word(initial: Initial) -> &'static str {
    match initial {
        Initial::Exact => "exact",
        Initial::Approximate => "approx",
        Initial::Calculated => "calculated",
    }
}

pub(super) fn causality(causality: Causality) -> &'static str {
    match causality {
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Parameter => "parameter",
        Causality::Local => "local",
        Causality::Independent => "independent",
    }
}

pub(super) fn variability(variability: Variability) -> &'static str {
    match variability {
        Variability::Fixed => "fixed",
        Variability::Tunable => "tunable",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    }
}

fn dependency_kind(kind: DependencyKind) -> &'static str {
    match kind {
        DependencyKind::Dependent => "dependent",
        DependencyKind::Constant => "constant",
        DependencyKind::Fixed => "fixed",
        DependencyKind::Tunable => "tunable",
        DependencyKind::Discrete => "discrete",
    }
}

#[cfg(test)]
#[path = "description_tests.rs"]
mod tests;

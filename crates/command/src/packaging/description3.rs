//! `modelDescription.xml` of FMI 3.0, generated from the variable table, in the element order of its schema. Parts common to both versions
//! are in `description.rs`.

use crate::packaging::description::{
    causality, dependency_lists, has_start, initial_word, is_initial_unknown, range, types_in_use, variability,
    write_experiment, write_log_categories, write_units,
};
use crate::packaging::xml::{self, Attributes, Xml, leaf, nest, real};
use crate::packaging::{Kinds, TOOL, VERSION};
use foldwing_engine::machine::Machine;
use foldwing_fmi::interface::{Array, Causality, Dependencies, Interface, RealType, UNITS, Value, Variable};
use std::io;

/// Capability flags of the `CoSimulation` element. A flag may be true only if the capability is implemented, because importers rely on it.
const CAPABILITIES: [(&str, &str); 11] = [
    ("needsExecutionTool", "false"),
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canGetAndSetFMUState", "true"),
    ("canSerializeFMUState", "true"),
    ("providesPerElementDependencies", "false"),
    ("canHandleVariableCommunicationStepSize", "true"),
    ("maxOutputDerivativeOrder", "1"),
    ("providesIntermediateUpdate", "true"),
    ("mightReturnEarlyFromDoStep", "true"),
    ("canReturnEarlyAfterIntermediateUpdate", "true"),
    ("hasEventMode", "true"),
];

/// Capability flags of the `ModelExchange` element.
const EXCHANGE_CAPABILITIES: [(&str, &str); 8] = [
    ("needsExecutionTool", "false"),
    ("canBeInstantiatedOnlyOncePerProcess", "false"),
    ("canGetAndSetFMUState", "true"),
    ("canSerializeFMUState", "true"),
    ("providesDirectionalDerivatives", "true"),
    ("providesAdjointDerivatives", "true"),
    ("providesPerElementDependencies", "false"),
    ("needsCompletedIntegratorStep", "true"),
];

/// Returns the complete text of `modelDescription.xml`, ending in a line feed.
///
/// `interface` is the table of `machine`, for Model Exchange with continuous states and event indicators; `rows` has the dependencies of
/// each of its rows, and `token` is checked by the library on instantiation.
pub(super) fn model_description(
    machine: &Machine,
    interface: &Interface,
    rows: &[Dependencies],
    token: &str,
    kinds: Kinds,
) -> String {
    let dependencies = interface.array_dependencies(rows);
    xml::document(|xml| write_root(xml, machine, (interface, &dependencies), token, kinds))
}

fn write_root(
    xml: &mut Xml,
    machine: &Machine,
    (interface, dependencies): (&Interface, &[Dependencies]),
    token: &str,
    kinds: Kinds,
) -> io::Result<()> {
    let attributes: Attributes = vec![
        ("fmiVersion", "3.0".to_owned()),
        ("modelName", machine.name.clone()),
        ("instantiationToken", token.to_owned()),
        ("description", machine.description.clone()),
        ("version", VERSION.to_owned()),
        ("license", "MIT OR Apache-2.0".to_owned()),
        ("generationTool", format!("{TOOL} {VERSION}")),
        ("variableNamingConvention", "structured".to_owned()),
    ];
    let kind = |xml: &mut Xml, name: &str, capabilities: &[(&'static str, &str)], more: Attributes| {
        let mut attributes: Attributes = vec![("modelIdentifier", machine.name.clone())];
        attributes.extend(capabilities.iter().map(|(name, value)| (*name, (*value).to_owned())));
        attributes.extend(more);
        leaf(xml, name, &attributes)
    };
    nest(xml, "fmiModelDescription", &attributes, |xml| {
        if kinds.model_exchange {
            kind(xml, "ModelExchange", &EXCHANGE_CAPABILITIES, vec![])?;
        }
        if kinds.co_simulation {
            // with aerodynamics the derivatives would be wrong, since they hold the aerodynamic loads constant
            let derivatives = machine.air.is_none().to_string();
            let more = vec![
                ("providesDirectionalDerivatives", derivatives.clone()),
                ("providesAdjointDerivatives", derivatives),
            ];
            kind(xml, "CoSimulation", &CAPABILITIES, more)?;
        }
        write_units(xml, interface.variables())?;
        write_types(xml, interface.variables())?;
        write_log_categories(xml)?;
        write_experiment(xml, machine)?;
        nest(xml, "ModelVariables", &vec![], |xml| {
            (0..)
                .zip(interface.arrays())
                .try_for_each(|(reference, array)| write_variable(xml, interface, reference, array))
        })?;
        write_structure(xml, interface, dependencies, kinds.scalars)
    })
}

fn write_types(xml: &mut Xml, variables: &[Variable]) -> io::Result<()> {
    let types = types_in_use(variables);
    if types.is_empty() {
        return Ok(());
    }
    nest(xml, "TypeDefinitions", &vec![], |xml| types.iter().try_for_each(|&of| write_type(xml, of)))
}

fn write_type(xml: &mut Xml, of: &RealType) -> io::Result<()> {
    let mut attributes =
        vec![("name", of.name.to_owned()), ("quantity", of.quantity.to_owned()), ("unit", of.unit.to_owned())];
    if let Some((display, _)) = UNITS.iter().find(|unit| unit.name == of.unit).and_then(|unit| unit.display) {
        attributes.push(("displayUnit", display.to_owned()));
    }
    leaf(xml, "Float64Type", &attributes)
}

/// Writes a variable with its dimensions, and its start values if the standard requires them, the last index varying fastest.
fn write_variable(xml: &mut Xml, interface: &Interface, reference: u32, array: &Array) -> io::Result<()> {
    let head = interface.head(array);
    let mut attributes: Attributes = vec![
        ("name", array.name.clone()),
        ("valueReference", reference.to_string()),
        ("description", array.description.clone()),
        ("causality", causality(head.causality).to_owned()),
        ("variability", variability(head.variability).to_owned()),
    ];
    if let Some(initial) = head.initial {
        attributes.push(("initial", initial_word(initial).to_owned()));
    }
    if let Some(name) = head.declared_type {
        attributes.push(("declaredType", name.to_owned()));
    }
    attributes.extend(range(head));
    if let Some(nominal) = head.nominal {
        attributes.extend([("nominal", real(nominal)), ("reinit", "true".to_owned())]);
    }
    if has_start(head) {
        let starts: Vec<String> =
            array.rows.iter().map(|&row| start(interface.variables()[row as usize].value)).collect();
        attributes.push(("start", starts.join(" ")));
    }
    if let Some(state) = head.derivative_of {
        attributes.push(("derivative", interface.array_of(state).to_string()));
    }
    let element = head.value.kind().name_of_fmi3();
    if array.dimensions.is_empty() {
        return leaf(xml, element, &attributes);
    }
    nest(xml, element, &attributes, |xml| {
        array.dimensions.iter().try_for_each(|length| leaf(xml, "Dimension", &vec![("start", length.to_string())]))
    })
}

fn start(value: Value) -> String {
    match value {
        Value::Real(value) => real(value),
        Value::Integer(value) => value.to_string(),
        Value::Boolean(value) => value.to_string(),
    }
}

/// `ModelStructure`: outputs, derivatives, unknowns of Initialization Mode and event indicators, with their dependencies.
fn write_structure(
    xml: &mut Xml,
    interface: &Interface,
    dependencies: &[Dependencies],
    scalars: bool,
) -> io::Result<()> {
    let everything = if scalars { interface.everything(false).zip(interface.everything(true)) } else { None };
    let everything = everything.map(|(running, initial)| [running, initial]);
    let each = |xml: &mut Xml, element: &str, which: &dyn Fn(&Variable) -> bool, initial: bool| {
        let arrays = (0_u32..).zip(interface.arrays()).zip(dependencies);
        arrays.filter(|((_, array), _)| which(interface.head(array))).try_for_each(|((reference, array), found)| {
            let local = interface.head(array).causality == Causality::Local;
            let list = if initial { &found.initial } else { &found.running };
            // start values of states and derivatives depend on all quantities that act at the start; indicators may depend on any quantity
            let on_all = found.on_all || local && (initial || interface.head(array).derivative_of.is_none());
            let mut attributes = vec![("valueReference", reference.to_string())];
            match (&everything, on_all) {
                (None, true) => {}
                (None, false) => attributes.extend(dependency_lists(list, 0)),
                // importers that do not support arrays, such as CasADi, may need the list even so
                (Some(all), true) => attributes.extend(dependency_lists(&all[usize::from(initial)], 0)),
                (Some(_), false) => attributes.extend(dependency_lists(&interface.with_tunables(list, initial), 0)),
            }
            leaf(xml, element, &attributes)
        })
    };
    let is_indicator = |row: &Variable| row.name.starts_with("event_indicator[");
    nest(xml, "ModelStructure", &vec![], |xml| {
        each(xml, "Output", &|row| row.causality == Causality::Output, false)?;
        each(xml, "ContinuousStateDerivative", &|row| row.derivative_of.is_some(), false)?;
        each(xml, "InitialUnknown", &is_initial_unknown, true)?;
        each(xml, "EventIndicator", &is_indicator, false)
    })
}

//! Variables of FMI 3.0 in a description: each element of an array becomes a separate variable.

use crate::description::{Element, Kind, NativeType, Unit, Variable};
use serde::Deserialize;
use std::collections::HashMap;

/// Maximum number of array elements that are listed.
const MAXIMUM_ELEMENTS: usize = 1_000_000;

/// Elements whose form in FMI 3.0 differs from FMI 2.0.
#[derive(Deserialize)]
pub(super) struct Root3 {
    #[serde(rename = "TypeDefinitions", default)]
    types: Types,
    #[serde(rename = "ModelVariables", default)]
    variables: Variables,
}

#[derive(Deserialize, Default)]
struct Types {
    #[serde(rename = "$value", default)]
    list: Vec<Declared>,
}

/// Declared type.
#[derive(Deserialize)]
struct Declared {
    #[serde(rename = "@name")]
    name: Option<String>,
    #[serde(rename = "@unit")]
    unit: Option<String>,
    #[serde(rename = "@relativeQuantity")]
    relative: Option<bool>,
    #[serde(rename = "@min")]
    min: Option<String>,
    #[serde(rename = "@max")]
    max: Option<String>,
    #[serde(rename = "Item", default)]
    items: Vec<Item>,
}

#[derive(Deserialize)]
struct Item {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@value")]
    value: i32,
}

#[derive(Deserialize, Default)]
struct Variables {
    #[serde(rename = "$value", default)]
    list: Vec<Tagged>,
}

#[derive(Deserialize)]
enum Tagged {
    Float32(Attributes),
    Float64(Attributes),
    Int8(Attributes),
    UInt8(Attributes),
    Int16(Attributes),
    UInt16(Attributes),
    Int32(Attributes),
    UInt32(Attributes),
    Int64(Attributes),
    UInt64(Attributes),
    Boolean(Attributes),
    String(Attributes),
    Binary(Attributes),
    Enumeration(Attributes),
    Clock(Attributes),
}

#[derive(Deserialize)]
struct Attributes {
    #[serde(rename = "@name")]
    name: String,
    #[serde(rename = "@valueReference")]
    reference: u32,
    #[serde(rename = "@causality")]
    causality: Option<String>,
    #[serde(rename = "@variability")]
    variability: Option<String>,
    #[serde(rename = "@initial")]
    initial: Option<String>,
    #[serde(rename = "@declaredType")]
    declared_type: Option<String>,
    #[serde(rename = "@unit")]
    unit: Option<String>,
    #[serde(rename = "@relativeQuantity")]
    relative: Option<bool>,
    #[serde(rename = "@min")]
    min: Option<String>,
    #[serde(rename = "@max")]
    max: Option<String>,
    #[serde(rename = "@start")]
    start: Option<String>,
    #[serde(rename = "Start", default)]
    starts: Vec<Start>,
    #[serde(rename = "Dimension", default)]
    dimensions: Vec<Dimension>,
    #[serde(rename = "Alias", default)]
    aliases: Vec<Alias>,
}

#[derive(Deserialize)]
struct Start {
    #[serde(rename = "@value")]
    value: String,
}

#[derive(Deserialize)]
struct Dimension {
    #[serde(rename = "@start")]
    start: Option<usize>,
    #[serde(rename = "@valueReference")]
    reference: Option<u32>,
}

#[derive(Deserialize)]
struct Alias {
    #[serde(rename = "@name")]
    name: String,
}

impl Tagged {
    fn parts(self) -> (NativeType, Attributes) {
        macro_rules! parts {
            ($($tag:ident $native:ident),*) => {
                match self { $(Self::$tag(attributes) => (NativeType::$native, attributes),)* }
            };
        }
        parts!(
            Float32 Float32, Float64 Float64, Int8 Int8, UInt8 UInt8, Int16 Int16, UInt16 UInt16, Int32 Int32,
            UInt32 UInt32, Int64 Int64, UInt64 UInt64, Boolean Boolean, String String, Binary Binary,
            // enumerations are read and set as Int64
            Enumeration Int64, Clock Clock
        )
    }
}

/// Variables of a description, with units by name.
///
/// # Errors
/// Contradictory entries, or too many elements.
pub(super) fn variables(root: Root3, units: &HashMap<String, Unit>) -> Result<Vec<Variable>, String> {
    let types = root.types.list.into_iter().filter_map(|declared| Some((declared.name.clone()?, declared)));
    let types: HashMap<String, Declared> = types.collect();
    let list: Vec<(bool, NativeType, Attributes)> = root
        .variables
        .list
        .into_iter()
        .map(|tagged| {
            let words = matches!(tagged, Tagged::Enumeration(_));
            let (native, attributes) = tagged.parts();
            (words, native, attributes)
        })
        .collect();
    // lengths may be structural parameters, which keep their start values here
    let length_of = |of: u32| {
        let parameter = list.iter().find(|(_, _, attributes)| attributes.reference == of);
        parameter.and_then(|(.., attributes)| attributes.start.as_deref()?.trim().parse::<usize>().ok())
    };
    let mut found = Vec::new();
    for (words, native, attributes) in &list {
        let mut lengths = Vec::new();
        for dimension in &attributes.dimensions {
            let length = dimension.start.or_else(|| dimension.reference.and_then(length_of));
            lengths.push(length.ok_or_else(|| format!("variable {}: a dimension without a length", attributes.name))?);
        }
        let count = lengths.iter().try_fold(1_usize, |count, &length| count.checked_mul(length));
        let count = count.filter(|count| count.saturating_add(found.len()) <= MAXIMUM_ELEMENTS).ok_or_else(|| {
            format!("variable {}: more than {MAXIMUM_ELEMENTS} elements of arrays in all", attributes.name)
        })?;
        let one = Element { native: *native, place: 0, length: count };
        let whole = scalar(attributes, *words, one, &types, units)?;
        let starts = starts(attributes, *native, count)?;
        let names = std::iter::once(&attributes.name).chain(attributes.aliases.iter().map(|alias| &alias.name));
        for name in names {
            for place in 0..count {
                let start = starts.get(place).or(starts.first()).cloned();
                let name = if lengths.is_empty() { name.clone() } else { element_name(name, place, &lengths) };
                found.push(Variable { name, start, element: Some(Element { place, ..one }), ..whole.clone() });
            }
        }
    }
    Ok(found)
}

/// Name of an element, such as `name[1,3]`: indices start at 1, and the last one varies fastest.
fn element_name(name: &str, place: usize, lengths: &[usize]) -> String {
    let mut rest = place;
    let mut indices: Vec<String> = lengths
        .iter()
        .rev()
        .map(|&length| {
            let index = rest % length + 1;
            rest /= length;
            index.to_string()
        })
        .collect();
    indices.reverse();
    format!("{name}[{}]", indices.join(","))
}

/// Start values in row-major order: one for each element, one for all elements, or none.
fn starts(attributes: &Attributes, native: NativeType, count: usize) -> Result<Vec<String>, String> {
    let starts: Vec<String> = match native {
        NativeType::String | NativeType::Binary => attributes.starts.iter().map(|start| start.value.clone()).collect(),
        NativeType::Float32
        | NativeType::Float64
        | NativeType::Boolean
        | NativeType::Clock
        | NativeType::Int8
        | NativeType::UInt8
        | NativeType::Int16
        | NativeType::UInt16
        | NativeType::Int32
        | NativeType::UInt32
        | NativeType::Int64
        | NativeType::UInt64 => {
            attributes.start.iter().flat_map(|text| text.split_whitespace().map(str::to_owned)).collect()
        }
    };
    if starts.len() <= 1 || starts.len() == count {
        return Ok(starts);
    }
    Err(format!("variable {}: {} start values for {count} elements", attributes.name, starts.len()))
}

fn scalar(
    own: &Attributes,
    words: bool,
    element: Element,
    types: &HashMap<String, Declared>,
    units: &HashMap<String, Unit>,
) -> Result<Variable, String> {
    let declared = own.declared_type.as_ref().and_then(|name| types.get(name));
    let unit = own.unit.as_ref().or(declared.and_then(|declared| declared.unit.as_ref()));
    let mut unit =
        unit.map(|name| units.get(name).cloned().unwrap_or_else(|| Unit { name: name.clone(), display: vec![] }));
    if own.relative.or(declared.and_then(|declared| declared.relative)) == Some(true) {
        let displays = unit.iter_mut().flat_map(|unit| &mut unit.display);
        displays.for_each(|display| display.offset = 0.0); // a temperature difference has no offset: 5 K are 5 °C
    }
    let kind = match element.native {
        NativeType::Float32 | NativeType::Float64 => Kind::Real,
        NativeType::Boolean => Kind::Boolean,
        NativeType::String => Kind::String,
        NativeType::Binary | NativeType::Clock => Kind::Opaque,
        NativeType::Int8
        | NativeType::UInt8
        | NativeType::Int16
        | NativeType::UInt16
        | NativeType::Int32
        | NativeType::UInt32
        | NativeType::Int64
        | NativeType::UInt64
            if words =>
        {
            let items = declared.map_or(&[][..], |declared| &declared.items);
            Kind::Enumeration(items.iter().map(|item| (item.name.clone(), item.value)).collect())
        }
        NativeType::Int8
        | NativeType::UInt8
        | NativeType::Int16
        | NativeType::UInt16
        | NativeType::Int32
        | NativeType::UInt32
        | NativeType::Int64
        | NativeType::UInt64 => Kind::Integer,
    };
    let bound = |text: &Option<String>, other: Option<&String>, what: &str| {
        let text = text.as_ref().or(other);
        text.map(|text| text.trim().parse::<f64>().map_err(|_| format!("variable {}: {what} {text:?}", own.name)))
            .transpose()
    };
    let min = bound(&own.min, declared.and_then(|declared| declared.min.as_ref()), "min")?;
    let max = bound(&own.max, declared.and_then(|declared| declared.max.as_ref()), "max")?;
    let (least, most) = if words { (None, None) } else { element.native.bounds() };
    let (min, max) = (min.or(least), max.or(most));
    let range =
        (min.is_some() || max.is_some()).then(|| (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY)));
    let causality = own.causality.clone().unwrap_or_else(|| "local".to_owned());
    // without the attribute, the standard's default applies, which is "exact" only for inputs and parameters
    let given = matches!(own.initial.as_deref(), Some("exact" | "approx"));
    let opaque = kind == Kind::Opaque;
    let settable = (matches!(causality.as_str(), "input" | "parameter") || given)
        && own.variability.as_deref() != Some("constant")
        && causality != "structuralParameter"
        && !opaque;
    Ok(Variable {
        name: own.name.clone(),
        value_reference: own.reference,
        causality,
        settable,
        kind,
        unit,
        range,
        start: None,
        element: Some(element),
    })
}

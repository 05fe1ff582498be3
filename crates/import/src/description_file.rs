//! `modelDescription.xml` of an FMU: the elements that an importer needs, without interpretation.

use serde::Deserialize;

/// Root element. Everything is optional, so that a missing item is reported with the file's name rather than by the parser's
/// message.
#[derive(Deserialize)]
pub(super) struct Root {
    #[serde(rename = "@fmiVersion")]
    pub version: Option<String>,
    #[serde(rename = "@modelName")]
    pub model_name: Option<String>,
    #[serde(rename = "@guid")]
    pub guid: Option<String>,
    #[serde(rename = "@instantiationToken")]
    pub token: Option<String>,
    #[serde(rename = "CoSimulation")]
    pub co_simulation: Option<CoSimulation>,
    #[serde(rename = "DefaultExperiment", default)]
    pub experiment: Experiment,
    #[serde(rename = "UnitDefinitions", default)]
    pub units: Units,
    #[serde(rename = "TypeDefinitions", default)]
    pub types: Types,
    #[serde(rename = "ModelVariables", default)]
    pub variables: Variables,
}

#[derive(Deserialize)]
pub(super) struct CoSimulation {
    #[serde(rename = "@modelIdentifier")]
    pub identifier: String,
    #[serde(rename = "@canHandleVariableCommunicationStepSize", default)]
    pub varies_step: bool,
}

#[derive(Deserialize, Default)]
pub(super) struct Experiment {
    #[serde(rename = "@startTime")]
    pub start: Option<f64>,
    #[serde(rename = "@stopTime")]
    pub stop: Option<f64>,
    #[serde(rename = "@stepSize")]
    pub step: Option<f64>,
}

#[derive(Deserialize, Default)]
pub(super) struct Units {
    #[serde(rename = "Unit", default)]
    pub list: Vec<Unit>,
}

#[derive(Deserialize)]
pub(super) struct Unit {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "DisplayUnit", default)]
    pub display: Vec<DisplayUnit>,
}

#[derive(Deserialize)]
pub(super) struct DisplayUnit {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "@factor")]
    pub factor: Option<f64>,
    #[serde(rename = "@offset")]
    pub offset: Option<f64>,
}

#[derive(Deserialize, Default)]
pub(super) struct Types {
    #[serde(rename = "SimpleType", default)]
    pub list: Vec<SimpleType>,
}

#[derive(Deserialize)]
pub(super) struct SimpleType {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "Real", alias = "Integer", alias = "Enumeration", default)]
    pub attributes: Attributes,
}

#[derive(Deserialize, Default)]
pub(super) struct Variables {
    #[serde(rename = "ScalarVariable", default)]
    pub list: Vec<ScalarVariable>,
}

#[derive(Deserialize)]
pub(super) struct ScalarVariable {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "@valueReference")]
    pub reference: u32,
    #[serde(rename = "@causality")]
    pub causality: Option<String>,
    #[serde(rename = "@variability")]
    pub variability: Option<String>,
    #[serde(rename = "@initial")]
    pub initial: Option<String>,
    #[serde(rename = "Real")]
    pub real: Option<Attributes>,
    #[serde(rename = "Integer")]
    pub integer: Option<Attributes>,
    #[serde(rename = "Boolean")]
    pub boolean: Option<Attributes>,
    #[serde(rename = "String")]
    pub string: Option<Attributes>,
    #[serde(rename = "Enumeration")]
    pub enumeration: Option<Attributes>,
}

/// Attributes of the element `Real`, `Integer`, `Boolean`, `String` or `Enumeration` of a variable or declared type.
#[derive(Deserialize, Default)]
pub(super) struct Attributes {
    #[serde(rename = "@declaredType")]
    pub declared_type: Option<String>,
    #[serde(rename = "@unit")]
    pub unit: Option<String>,
    #[serde(rename = "@relativeQuantity")]
    pub relative: Option<bool>,
    #[serde(rename = "@min")]
    pub min: Option<f64>,
    #[serde(rename = "@max")]
    pub max: Option<f64>,
    #[serde(rename = "@start")]
    pub start: Option<String>,
    #[serde(rename = "Item", default)]
    pub items: Vec<Item>,
}

/// An item of an enumeration.
#[derive(Deserialize)]
pub(super) struct Item {
    #[serde(rename = "@name")]
    pub name: String,
    #[serde(rename = "@value")]
    pub value: i32,
}

//! Description of a small table: elements and attributes required by the standard, at the required positions.

use super::*;
use crate::packaging::drawing::tests::two_body_machine;

fn row(row: u32, name: &str, causality: Causality, value: Value) -> Variable {
    let (variability, initial) = match causality {
        Causality::Output => (Variability::Continuous, Some(Initial::Calculated)),
        Causality::Parameter => (Variability::Fixed, Some(Initial::Exact)),
        Causality::Input | Causality::Local | Causality::Independent => (Variability::Continuous, None),
    };
    Variable {
        name: name.to_owned(),
        value_reference: row,
        causality,
        variability,
        initial,
        value,
        declared_type: None,
        range: None,
        description: format!("{name} < & \" of the wing"),
        nominal: None,
        derivative_of: None,
    }
}

fn table() -> Vec<Variable> {
    let mut rows = vec![
        row(0, "time", Causality::Independent, Value::Real(0.0)),
        row(1, "fold.angle_command", Causality::Input, Value::Real(0.25)),
        row(2, "fold.release", Causality::Input, Value::Boolean(true)),
        row(3, "parameter.limit", Causality::Parameter, Value::Real(1e30)),
        row(4, "fold.angle", Causality::Output, Value::Real(0.0)),
        row(5, "fold.latch_count", Causality::Output, Value::Integer(0)),
    ];
    rows[2].variability = Variability::Discrete;
    rows[5].variability = Variability::Discrete;
    rows[3].range = Some((0.0, 1e30));
    rows
}

fn dependencies() -> Vec<Dependencies> {
    let mut all = vec![Dependencies::default(); table().len()];
    all[4].running = vec![(2, DependencyKind::Dependent), (1, DependencyKind::Constant)];
    all[4].initial = vec![(3, DependencyKind::Dependent)];
    all
}

fn text() -> String {
    model_description(&two_body_machine(), &table(), &dependencies(), "{guid}", Kinds::default())
}

/// Elements are in the order of the schema.
#[test]
fn elements_follow_the_schema_order() {
    let text = text();
    let order = ["<CoSimulation", "<LogCategories", "<DefaultExperiment", "<ModelVariables", "<ModelStructure"];
    let positions: Vec<_> = order.iter().map(|element| text.find(element).expect(element)).collect();
    assert!(positions.is_sorted(), "{positions:?}");
}

/// Inputs and parameters have a start value; outputs and time do not.
#[test]
fn start_values_stand_where_the_standard_wants_them() {
    let text = text();
    for expected in [
        "<Real start=\"0.25\"/>",
        "<Boolean start=\"true\"/>",
        "<Real min=\"0.0\" max=\"1e30\" start=\"1e30\"/>",
        "<Integer/>",
    ] {
        assert!(text.contains(expected), "{expected} is missing in\n{text}");
    }
    assert_eq!(text.matches("start=").count(), 3);
}

/// Dependencies are ascending indices, which start at 1, each with its kind; an empty list means none.
#[test]
fn structure_counts_from_one_and_sorts() {
    let text = text();
    for expected in [
        "<Unknown index=\"5\" dependencies=\"2 3\" dependenciesKind=\"constant dependent\"/>",
        "<Unknown index=\"6\" dependencies=\"\" dependenciesKind=\"\"/>",
        "<Unknown index=\"5\" dependencies=\"4\" dependenciesKind=\"dependent\"/>",
    ] {
        assert!(text.contains(expected), "{expected} is missing in\n{text}");
    }
}

/// Markup in a description is escaped, and the text does not depend on the time or folder of packaging.
#[test]
fn text_is_escaped_and_reproducible() {
    let text = text();
    assert!(text.contains("fold.angle &lt; &amp; &quot; of the wing"));
    assert!(!text.contains("generationDateAndTime"));
    assert!(text.contains(&format!("generationTool=\"foldwing {VERSION}\"")));
    assert_eq!(text, self::text());
}

/// Lists of initial values that would be most of the description are left out, which means that these depend on everything.
#[test]
fn initial_lists_are_bounded() {
    let with = |count: usize| {
        let mut all = dependencies();
        all[4].initial = vec![(3, DependencyKind::Dependent); count];
        let text = model_description(&two_body_machine(), &table(), &all, "{guid}", Kinds::default());
        text[text.find("<InitialUnknowns").unwrap()..].contains("dependencies=")
    };
    assert!(with(MAXIMUM_INITIAL) && !with(MAXIMUM_INITIAL + 1));
}

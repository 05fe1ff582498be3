//! Model descriptions written by other tools, and values of `--set` for them.

use super::*;

const FOREIGN: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" fmiVersion="2.0" modelName="A &amp; B" guid="{1}"
    xsi:noNamespaceSchemaLocation="fmi2ModelDescription.xsd">
  <ModelExchange modelIdentifier="ab_me"/>
  <CoSimulation modelIdentifier="ab" canHandleVariableCommunicationStepSize="1"><SourceFiles><File name="a.c"/></SourceFiles></CoSimulation>
  <UnitDefinitions>
    <Unit name="rad"><BaseUnit rad="1"/><DisplayUnit name="deg" factor="57.29577951308232"/></Unit>
    <Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Angle"><Real quantity="Angle" unit="rad" min="-4"/></SimpleType>
    <SimpleType name="Gear"><Enumeration><Item name="park" value="1"/><Item name="drive" value="4"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <DefaultExperiment startTime="1" stopTime="3"/>
  <VendorAnnotations><Tool name="x"><ScalarVariable name="no"/></Tool></VendorAnnotations>
  <ModelVariables>
    <ScalarVariable name="angle" valueReference="7" causality="input" canHandleMultipleSetPerTimeInstant="false">
      <Real declaredType="Angle" max="3" start="0.5"/>
      <Annotations><Tool name="x"/></Annotations>
    </ScalarVariable>
    <ScalarVariable name="heat" valueReference="8" causality="parameter" variability="fixed"><Real unit="K" start="293.15"/></ScalarVariable>
    <ScalarVariable name="rise" valueReference="9" causality="parameter" variability="tunable"><Real unit="K" relativeQuantity="true"/></ScalarVariable>
    <ScalarVariable name="gear" valueReference="7" causality="parameter"><Enumeration declaredType="Gear" start="1"/></ScalarVariable>
    <ScalarVariable name="on" valueReference="7" causality="input" variability="discrete"><Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="count" valueReference="7" initial="approx" variability="discrete"><Integer start="2" max="9"/></ScalarVariable>
    <ScalarVariable name="label" valueReference="7" causality="parameter" variability="fixed"><String start="a"/></ScalarVariable>
    <ScalarVariable name="pi" valueReference="1" causality="parameter" variability="constant"><Real start="3.14"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="output"><Real unit="furlong"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>"#;

fn foreign() -> Description {
    let root: Root = quick_xml::de::from_str(FOREIGN).expect("well-formed");
    Description::new(root, None).expect("complete")
}

/// Everything that the standard allows is read: other namespaces, annotations, unused attributes.
#[test]
fn descriptions_of_other_tools_are_understood() {
    let description = foreign();
    assert_eq!((description.model_name.as_str(), description.identifier.as_str()), ("A & B", "ab"));
    assert!(description.varies_step);
    assert_eq!(description.experiment, Experiment { start_s: 1.0, stop_s: 3.0, step_s: 2.0 / 500.0 });
    let names: Vec<&str> = description.variables.iter().map(|variable| variable.name.as_str()).collect();
    assert_eq!(names, ["angle", "heat", "rise", "gear", "on", "count", "label", "pi", "y"]);
    let settable: Vec<bool> = description.variables.iter().map(|variable| variable.settable).collect();
    assert_eq!(settable, [true, true, true, true, true, true, true, false, false]);
    let angle = description.find("angle").expect("listed");
    assert_eq!((angle.range, angle.value_reference), (Some((-4.0, 3.0)), 7));
    assert_eq!(description.find("y").expect("listed").unit_after_number(), " furlong");
}

/// Values with and without units, enumeration items and numbers are converted; each error lists the allowed values.
#[test]
fn settings_are_converted_or_refused() {
    let description = foreign();
    let set = |name: &str, text: &str| description.find(name).expect("listed").parse(text);
    let real = |name: &str, text: &str| match set(name, text) {
        Ok(Datum::Number(Value::Real(value))) => value,
        other => panic!("{name}={text}: {other:?}"),
    };
    assert_eq!(real("angle", "0.25"), 0.25);
    assert_eq!(real("angle", "0.25 rad"), 0.25);
    assert!((real("angle", "90 deg") - 90f64.to_radians()).abs() < 1e-15);
    assert!((real("heat", "20 degC") - 293.15).abs() < 1e-12, "an offset");
    assert_eq!(real("rise", "5 degC"), 5.0, "a difference has no offset");
    assert_eq!(set("gear", "drive"), Ok(Datum::Number(Value::Integer(4))));
    assert_eq!(set("gear", "1"), Ok(Datum::Number(Value::Integer(1))));
    assert_eq!(set("on", "false"), Ok(Datum::Number(Value::Boolean(false))));
    assert_eq!(set("label", "a b"), Ok(Datum::Text("a b".to_owned())));
    for (name, text, message) in [
        ("angle", "90 ft", "`ft` is not one of its units; allowed: rad, deg"),
        ("angle", "x", "`x` is not a number"),
        ("angle", "200 deg", "`200 deg` is out of range; allowed is -4.0 to 3.0 rad"),
        ("pi", "1 m", "`m`: the variable has no unit"),
        ("gear", "fly", "`fly` is not one of park (1), drive (4)"),
        ("on", "yes", "`yes` is not a Boolean; allowed are 0, 1, false and true"),
        ("count", "1.5", "`1.5` is not a whole number"),
        ("count", "10", "`10` is out of range; allowed is -inf to 9.0"),
    ] {
        assert_eq!(set(name, text), Err(message.to_owned()), "{name}={text}");
    }
}

/// Errors name the missing items.
#[test]
fn incomplete_descriptions_are_refused() {
    for (taken, put, message) in [
        (" guid=\"{1}\"", "", "no attribute guid"),
        ("<Real start=\"3.14\"/>", "", "variable pi: no type"),
        (" modelName=\"A &amp; B\"", "", "no attribute modelName"),
    ] {
        assert!(FOREIGN.contains(taken), "{taken}");
        let root: Root = quick_xml::de::from_str(&FOREIGN.replace(taken, put)).expect("well-formed");
        assert_eq!(Description::new(root, None), Err(message.to_owned()));
    }
}

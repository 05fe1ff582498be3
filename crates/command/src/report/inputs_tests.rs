//! Input files: interpretation and errors.

use super::*;
use foldwing_fmi::interface::Variability;

fn variable(row: u32, name: &str, causality: Causality, value: Value) -> Variable {
    Variable {
        name: name.to_owned(),
        value_reference: row,
        causality,
        variability: Variability::Continuous,
        initial: None,
        value,
        declared_type: None,
        range: Some((-10.0, 10.0)),
        description: String::new(),
        nominal: None,
        derivative_of: None,
    }
}

fn variables() -> Vec<Variable> {
    vec![
        variable(0, "time", Causality::Independent, Value::Real(0.0)),
        variable(1, "fold.angle_command", Causality::Input, Value::Real(0.0)),
        variable(2, "fold.release", Causality::Input, Value::Boolean(true)),
        variable(3, "fold.angle", Causality::Output, Value::Real(0.0)),
    ]
}

fn read(text: &str) -> Result<InputTable, InputsError> {
    InputTable::read(text.as_bytes(), "in.csv", &variables())
}

fn message(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

/// Reals are interpolated linearly, Booleans are held, and both are constant outside the rows.
#[test]
fn reals_interpolate_and_booleans_hold() {
    let table = read("# a remark\ntime, fold.angle_command, fold.release\n0, 1, false\n2, 3, true\n").unwrap();
    let at = |time: f64| table.at(time).map(|(_, value)| value).collect::<Vec<_>>();
    assert_eq!(at(-1.0), [Value::Real(1.0), Value::Boolean(false)]);
    assert_eq!(at(0.5), [Value::Real(1.5), Value::Boolean(false)]);
    assert_eq!(at(1.75), [Value::Real(2.75), Value::Boolean(false)]); // close to the row that changes it, too
    assert_eq!(at(2.0), [Value::Real(3.0), Value::Boolean(true)]);
    assert_eq!(at(9.0), [Value::Real(3.0), Value::Boolean(true)]);
}

/// Two rows at the same time are a jump: the interpolation before it ends at the first, and the second is valid from there on. Huge
/// values of opposite sign are interpolated without overflow.
#[test]
fn two_rows_at_one_time_jump() {
    let table = read("time,fold.angle_command,fold.release\n0,1,1\n1,2,1\n1,-5,0\n3,-3,0\n3,4,1\n").unwrap();
    let at = |time: f64| table.at(time).map(|(_, value)| value).collect::<Vec<_>>();
    assert_eq!(at(0.5), [Value::Real(1.5), Value::Boolean(true)]);
    assert_eq!(at(0.75), [Value::Real(1.75), Value::Boolean(true)]);
    assert_eq!(at(1.0), [Value::Real(-5.0), Value::Boolean(false)]);
    assert_eq!(at(2.0), [Value::Real(-4.0), Value::Boolean(false)]);
    assert_eq!(at(3.0), [Value::Real(4.0), Value::Boolean(true)]);
    assert_eq!(at(9.0), [Value::Real(4.0), Value::Boolean(true)]);
    let mut wide = variables();
    wide[1].range = None;
    let text = "time,fold.angle_command\n0,-1e308\n1,1e308\n";
    let table = InputTable::read(text.as_bytes(), "in.csv", &wide).unwrap();
    assert_eq!(table.at(0.5).map(|(_, value)| value).collect::<Vec<_>>(), [Value::Real(0.0)]);
}

/// Each error states file, line, column, value and the allowed values.
#[test]
fn mistakes_are_named_with_their_place() {
    let head = "time,fold.angle_command,fold.release\n";
    let cases = [
        (
            "t,fold.angle_command\n0,1\n".to_owned(),
            "in.csv:1: column 1: `t`: the first column must be named `time` (s)",
        ),
        (
            "time,fold.comand\n0,1\n".to_owned(),
            "in.csv:1: column 2: no input is named `fold.comand`; did you mean `fold.angle_command`?",
        ),
        ("time,xyz\n0,1\n".to_owned(), "in.csv:1: column 2: no input is named `xyz`; `foldwing check` lists the names"),
        ("time,fold.angle\n0,1\n".to_owned(), "in.csv:1: column 2: `fold.angle` is not an input"),
        (
            "time,fold.angle_command,fold.angle_command\n0,1,1\n".to_owned(),
            "in.csv:1: column 3: `fold.angle_command` appears twice",
        ),
        (format!("{head}0,1,1\n1,x,1\n"), "in.csv:3: column 2 (fold.angle_command): `x` is not a finite number"),
        (format!("{head}0,inf,1\n"), "in.csv:2: column 2 (fold.angle_command): `inf` is not a finite number"),
        (
            format!("{head}0,11,1\n"),
            "in.csv:2: column 2 (fold.angle_command): `11` is out of range; allowed is -10.0 to 10.0",
        ),
        (
            format!("{head}0,1,yes\n"),
            "in.csv:2: column 3 (fold.release): `yes` is not a Boolean; allowed are 0, 1, false and true",
        ),
        (
            format!("{head}1,1,1\n0.5,1,1\n"),
            "in.csv:3: column 1 (time): `0.5` is before the previous row (1 s); times must ascend, and two rows at one time make a jump",
        ),
        (
            format!("{head}1,1,1\n1,2,1\n1,3,1\n"),
            "in.csv:4: column 1 (time): `1` is the time of three rows; a jump has two rows, with the values before and after it",
        ),
        (format!("{head}1,1\n"), "in.csv: line 2: 2 columns where the header has 3"),
        (head.to_owned(), "in.csv: no rows below the header; at least one is needed"),
        (String::new(), "in.csv:1: column 1: ``: the first column must be named `time` (s)"),
    ];
    for (text, expected) in cases {
        assert_eq!(message(&text), expected, "for\n{text}");
    }
}

use foldwing::interface::Interface;
use foldwing::plant::{InputColumn, InputRows, Parameter, Plant};
use foldwing::study::sensitivity::{By, Mode, Numbers, Options, Recorded};
use std::sync::Arc;

fn plant(text: &str) -> Result<Plant, String> {
    foldwing::config::parse(text, "m.toml").map(|m| Plant::new(Arc::new(m))).map_err(|e| e.to_string())
}

fn replaced(file: &toml::Table, path: &str, value: f64) -> String {
    let mut file = file.clone();
    let mut parts: Vec<&str> = path.split('.').collect();
    let last = parts.pop().unwrap();
    let mut table = &mut file;
    for part in parts {
        table = table.get_mut(part).and_then(|t| t.as_table_mut()).expect(path);
    }
    table.insert(last.to_owned(), toml::Value::Float(value));
    file.to_string()
}

#[test]
fn scratch() {
    let Ok(path) = std::env::var("SCRATCH") else { return };
    let spec: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let text = std::fs::read_to_string(spec["model"].as_str().unwrap()).unwrap();
    let file: toml::Table = text.parse().unwrap();
    let own = plant(&text).unwrap();
    let interface = Interface::new(own.machine());
    let start_s = own.machine().experiment.start_time_s;
    let list = |key: &str| -> Vec<String> { spec[key].as_array().map_or(vec![], |l| l.iter().map(|v| v.as_str().unwrap().to_owned()).collect()) };
    let floats = |v: &serde_json::Value| -> Vec<f64> { v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect() };
    let inputs = match spec.get("inputs") {
        None => InputRows::default(),
        Some(rows) => {
            let columns = rows["columns"].as_object().unwrap().iter().map(|(name, values)| InputColumn {
                index: match name.strip_prefix("command:") { Some(j) => own.inputs().layout().joints.place(j.parse().unwrap(), std::mem::offset_of!(foldwing::plant::JointInputs, command_rad)), None => name.parse().unwrap() }, held: false, values: floats(values),
            }).collect();
            InputRows::new(floats(&rows["times"]), columns).unwrap()
        }
    };
    println!("inputs: {:?}", (0..own.inputs().values().len()).collect::<Vec<_>>().len());
    let _ = &interface;
    let options = Options { inputs: inputs.clone(), stop_s: spec["stop"].as_f64().map(|s| s + start_s), ..Options::default() };
    let mut recorded = Recorded::new(own, &options).unwrap_or_else(|e| panic!("{e}"));
    println!("steps {}, crossings {:?}", recorded.tape().steps(), recorded.tape().crossings_s().collect::<Vec<_>>());
    let results = recorded.find(&list("of")).unwrap();
    let by = list("by");
    let value = |path: &str| -> f64 {
        let mut v = &toml::Value::Table(file.clone());
        for p in path.split('.') { v = v.get(p).expect(path); }
        v.as_float().or(v.as_integer().map(|i| i as f64)).unwrap()
    };
    let numbers = || -> Vec<Numbers> {
        let mut all: Vec<Numbers> = by.iter().map(|name| {
            let v = value(name);
            let parameter = Parameter::new(name.clone(), v, 1e-3 * v.abs().max(1e-9), |x| plant(&replaced(&file, name, x))).unwrap();
            Numbers { by: vec![By { name: name.clone(), value: v, unit: "" }], parameter }
        }).collect();
        for column in 0..inputs.columns().len() {
            let rows: Vec<usize> = (0..inputs.times_s().len()).collect();
            let by = rows.iter().map(|r| By { name: format!("row {r}"), value: inputs.columns()[column].values[*r], unit: "" }).collect();
            all.push(Numbers { by, parameter: Parameter::of_rows("rows", (column, rows), 1e-3, || plant(&text)).unwrap() });
        }
        all
    };
    let forward = recorded.derivatives(&results, numbers(), Mode::Forward).unwrap();
    let adjoint = recorded.derivatives(&results, numbers(), Mode::Adjoint).unwrap();
    let shares = floats(&spec["shares"]);
    let names: Vec<(String, f64)> = forward.by.iter().map(|b| (b.name.clone(), b.value)).collect();
    let mut columns: Vec<Vec<Option<Vec<f64>>>> = Vec::new();
    for (place, (name, v)) in names.iter().enumerate() {
        let size = if place < by.len() { v.abs() } else { 1.0 };
        columns.push(shares.iter().map(|share| {
            let mut slopes = vec![0.0; forward.of.len()];
            for (steps, weight) in [(-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)] {
                let x = v + steps * share * size;
                let outcome = if place < by.len() {
                    recorded.along(plant(&replaced(&file, name, x)).unwrap(), &inputs, &results)
                } else {
                    let mut c = inputs.columns().to_vec();
                    let rows = inputs.times_s().len();
                    let k = place - by.len();
                    c[k / rows].values[k % rows] = x;
                    recorded.along(plant(&text).unwrap(), &InputRows::new(inputs.times_s().to_vec(), c).unwrap(), &results)
                };
                match outcome {
                    Ok(Some(values)) => slopes.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v / (12.0 * share)),
                    Ok(None) => { println!("{name} {share}: pieces"); return None }
                    Err(e) => { println!("{name} {share}: {e}"); return None }
                }
            }
            Some(slopes)
        }).collect());
    }
    for (r, row) in forward.of.iter().enumerate() {
        println!("{} = {} at {}", row.name, row.value, row.time_s);
        let size = |place: usize| if place < by.len() { names[place].1.abs() } else { 1.0 };
        let largest = (0..names.len()).fold(0.0f64, |l, p| l.max((row.derivatives[p] * size(p)).abs()));
        for (place, (name, _)) in names.iter().enumerate() {
            let f = row.derivatives[place] * size(place) / largest;
            let a = adjoint.of[r].derivatives[place] * size(place) / largest;
            let d: Vec<String> = columns[place].iter().map(|c| c.as_ref().map_or("-".into(), |c| format!("{:.2e}", c[r] / largest - f))).collect();
            println!("   {name:40} {f:+.9e} adjoint {:.1e} differences {}", a - f, d.join(" "));
        }
    }
}

//! Instances without an importer: clock, log, saved states.

use super::*;
use std::cell::RefCell;
use std::rc::Rc;

const WING: &str = include_str!("../../../../examples/models/folding_wing.toml");

/// A co-simulation of the folding wing after its initialisation.
fn running() -> Instance {
    let machine = Arc::new(config::parse(&WING.replace("elements = 4", "elements = 1"), "wing.toml").expect("valid"));
    let interface = Interface::new(&machine);
    let mut instance = Instance {
        plant: unwatched(&machine),
        version: Version::Fmi2,
        kind: InterfaceKind::CoSimulation,
        manner: Manner::default(),
        experiment: default_experiment(&machine),
        machine,
        guid: guid(WING, interface.variables()),
        interface,
        phase: Phase::Instantiated,
        stale: true,
        step_failed: false,
        spent_s: 0.0,
        read: OutputSet::NONE,
        read_before: OutputSet::NONE,
        states: Registry::new(),
        log: Log::new(None, false),
    };
    instance.enter_initialization();
    instance.exit_initialization().expect("an initial state");
    instance
}

fn real(instance: &mut Instance, name: &str) -> f64 {
    let row = instance.interface.find(name).expect(name).value_reference;
    instance.plant.provide(OutputSet::ALL);
    match instance.interface.get(&instance.plant, instance.plant.outputs(), row) {
        Some(Value::Real(value)) => value,
        other => panic!("{name}: {other:?}"),
    }
}

fn switch(instance: &mut Instance, name: &str, on: bool) {
    let row = instance.interface.find(name).expect(name).value_reference;
    instance.interface.set(&mut instance.plant, row, Value::Boolean(on)).expect("a switch");
}

/// The wing advances by the step size given by the importer, regardless of round-off in the importer's clock: with communication points
/// that are late by 9·10⁻¹⁰ s, the fold, at more than 10 rad/s, rotates no farther than with exact ones. If the steps started at the
/// plant's time, they would be longer by that amount and the angle would be wrong by 10⁻⁸ rad; nothing here depends on the time itself.
#[test]
fn a_step_has_its_length_on_the_clock_of_the_importer() {
    let angle_rad = |late_s: f64| {
        let mut instance = running();
        instance.do_step(0.0, 0.0625).expect("a step");
        instance.do_step(0.0625 + late_s, 1e-3).expect("a step");
        assert_eq!(instance.last_successful_time_s(), 0.0625 + late_s + 1e-3);
        assert!(real(&mut instance, "fold.angular_velocity").abs() > 10.0);
        real(&mut instance, "fold.angle")
    };
    let (exact_rad, late_rad) = (angle_rad(0.0), angle_rad(9e-10));
    assert!((late_rad - exact_rad).abs() < 1e-11, "{exact_rad} {late_rad}"); // 10 rad/s times the resolution of the clock, with a margin
}

/// Each release, lock, latch closing or opening gives one message, with joint and time.
#[test]
fn the_log_tells_releases_and_holds() {
    let told: Rc<RefCell<Vec<String>>> = Rc::default();
    let into = Rc::clone(&told);
    let mut instance = running();
    instance.log = Log::new(Some(Box::new(move |_, _, text| into.borrow_mut().push(text.to_owned()))), true);
    for (step, release) in [true, false, false, true, true].into_iter().enumerate() {
        switch(&mut instance, "fold.release", release);
        instance.do_step(step as f64 * 0.0078125, 0.0078125).expect("a step");
    }
    let expected = ["held at t = 0.007812500 s", "released at t = 0.023437500 s"];
    assert_eq!(*told.borrow(), expected.map(|event| format!("fmi2DoStep: joint fold: {event}")));
}

/// Extra bytes after the end of a state are an error, like missing bytes, even if the length and checksum in the header match them.
#[test]
fn a_state_ends_where_its_bytes_end() {
    let mut instance = running();
    let handle = instance.save_state(0).expect("a state");
    let bytes = instance.serialize_state(handle).expect("bytes");
    assert!(instance.deserialize_state(&bytes).is_ok());
    let refused = |change: &dyn Fn(&mut Vec<u8>)| {
        let mut payload = bytes[state::HEADER_LENGTH..].to_vec();
        change(&mut payload);
        let mut whole = bytes[..state::HEADER_LENGTH - 12].to_vec();
        whole.extend((payload.len() as u64).to_le_bytes());
        let checksum = state::checksum(&whole, &payload);
        whole.extend(checksum.to_le_bytes());
        whole.extend(payload);
        SavedState::from_bytes(&whole, &instance.guid).err().map(|error| error.to_string())
    };
    assert_eq!(refused(&|_| ()), None);
    let longer = refused(&|payload| payload.extend([0, 0, 7])).expect("refused");
    assert!(longer.contains("damaged") && longer.contains("3 bytes too many"), "{longer}");
    assert!(refused(&|payload| payload.truncate(payload.len() - 1)).expect("refused").contains("damaged"));
}

/// An instance of a text instead of a folder, as in the WebAssembly component: the GUID must belong to the text, and messages state the name
/// of the file.
#[test]
fn an_instance_of_a_text_needs_no_folder() {
    let machine = config::parse(WING, "wing.toml").expect("valid");
    let own = Interface::new(&machine).instantiation_token(WING);
    let made = |name: Option<&'static str>, token: &str, text: &str| {
        let request = Request {
            version: Version::Fmi3,
            name,
            fmu_type: 1,
            guid: Some(token),
            resource_location: None,
            manner: Manner::default(),
        };
        Instance::of_text(&request, text, "model.toml")
    };
    let mut instance = made(Some("wing"), &own, WING).expect("an instance");
    instance.enter_initialization();
    instance.exit_initialization().expect("an initial state");
    instance.do_step(0.0, 1e-3).expect("a step");
    assert_eq!(instance.last_successful_time_s(), 1e-3);

    let refused = |outcome: Result<Instance, InstantiationError>| match outcome {
        Ok(_) => panic!("not refused"),
        Err(error) => error.to_string(),
    };
    assert!(refused(made(Some("wing"), "{other}", WING)).contains(&own));
    assert!(refused(made(Some("wing"), &own, "name = 3")).contains("model.toml"));
    assert!(refused(made(Some(""), &own, WING)).contains("instance name is missing"));
    assert!(refused(made(None, &own, WING)).contains("instance name is missing"));
}

//! Tests of the simulation of the page, without a network.

use crate::live::order::{Given, Order};
use crate::live::session::Session;
use crate::live::tests::{changed, started};
use foldwing_engine::plant::Holding;
use serde_json::Value;
use std::time::{Duration, Instant};

fn session(model: &str) -> Session {
    let (interface, plant) = started(model);
    Session::new(plant, interface, 1.0)
}

fn step(session: &mut Session, steps: usize) {
    (0..steps).for_each(|_| assert_eq!(session.execute(&Order::Step {}), Ok(None)));
}

fn set(name: &str, value: f64) -> Order {
    Order::Set { name: name.to_owned(), value: Given::Number(value), machine: None }
}

/// Splits a frame into header and numbers.
fn read(frame: &[u8]) -> (Value, Vec<f32>) {
    let length = u32::from_le_bytes(frame[..4].try_into().unwrap()) as usize;
    assert_eq!(length % 4, 0, "the numbers are not aligned");
    let numbers = frame[4 + length..].chunks_exact(4).map(|four| f32::from_le_bytes(four.try_into().unwrap()));
    (serde_json::from_slice(&frame[4..4 + length]).unwrap(), numbers.collect())
}

fn sent_frame(session: &mut Session) -> (Value, Vec<f32>) {
    read(&session.next_frame().unwrap())
}

/// The simulated time is never ahead of the clock, and follows it up to the last complete step.
#[test]
fn time_follows_the_clock() {
    let mut session = session("folding_wing");
    session.advance();
    assert_eq!((session.time_s(), session.runs(), session.until_step()), (0.0, false, None));
    let begun = Instant::now();
    session.execute(&Order::Run {}).unwrap();
    while begun.elapsed() < Duration::from_millis(300) {
        session.advance();
        // the clock was started after `begun`
        assert!(session.time_s() <= begun.elapsed().as_secs_f64(), "ahead: {} s", session.time_s());
    }
    let summary = session.summary();
    let behind_s = summary.ran_s - session.time_s() - summary.lost_s;
    assert!((-1e-9..session.step_s() + summary.latest_s).contains(&behind_s), "{behind_s}: {summary:?}");
    assert!(session.time_s() > 0.02 && (summary.simulated_s - session.time_s()).abs() < 1e-12, "{summary:?}");
    assert_eq!(summary.steps, (session.time_s() / session.step_s()).round() as u64);
    session.execute(&Order::Pause {}).unwrap();
    let stood_s = session.time_s();
    std::thread::sleep(Duration::from_millis(5));
    session.advance();
    assert_eq!(session.time_s(), stood_s);
    // from here on ten times as fast
    session.execute(&Order::Speed { value: 10.0 }).unwrap();
    session.execute(&Order::Run {}).unwrap();
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_millis(50) {
        session.advance();
    }
    let (gone_s, wall_s) = (session.time_s() - stood_s, begun.elapsed().as_secs_f64());
    assert!(
        gone_s > 0.5 * 10.0 * (wall_s - session.summary().lost_s) - 0.3 && gone_s > 0.055,
        "{gone_s} s in {wall_s} s"
    );
}

/// A frame has the state at its time, and the samples of the plotted signals since the last frame; without a change there is no
/// frame.
#[test]
fn frames_have_the_state_and_samples() {
    let mut session = session("folding_wing");
    session.execute(&Order::Watch { names: vec!["fold.angle".to_owned(), "tip.position.z".to_owned()] }).unwrap();
    let (header, first) = sent_frame(&mut session);
    assert_eq!(
        (header["time"].as_f64(), header["samples"].as_u64(), header["running"].as_bool()),
        (Some(0.0), Some(0), Some(false))
    );
    assert_eq!(first[0], 0.0);
    assert_eq!(session.next_frame(), None);
    step(&mut session, 40);
    let (header, numbers) = sent_frame(&mut session);
    assert_eq!(header["names"], serde_json::json!(["fold.angle", "tip.position.z"]));
    let rows = header["samples"].as_u64().unwrap() as usize;
    // one sample every 4 ms for 20 ms
    assert_eq!((rows, numbers.len()), (5, 3 * rows + first.len()));
    let frame = &numbers[3 * rows..];
    assert!((frame[0] - 0.02).abs() < 1e-8, "{}", frame[0]);
    let last = &numbers[3 * (rows - 1)..3 * rows];
    assert!((last[0] - 0.0165).abs() < 1e-6, "{last:?}");
    // the joint angle of the frame is in degrees
    let turned = last[1].to_degrees() - frame[1];
    assert!((0.0..6.0).contains(&turned), "{} then {}", last[1].to_degrees(), frame[1]);
}

/// A rollback restores inputs, events and state bit for bit: the same steps give the same frame again.
#[test]
fn rolling_back_repeats_the_run() {
    let mut session = session("folding_wing");
    step(&mut session, 200);
    let (before, _) = sent_frame(&mut session);
    step(&mut session, 60);
    let (after, numbers) = sent_frame(&mut session);
    let latches = |header: &Value| header["events"].as_array().unwrap().len();
    assert_eq!((latches(&before), latches(&after)), (0, 1), "the wing latches at 0.1222 s");
    session.execute(&set("fold.external_torque", 0.01)).unwrap();
    session.execute(&Order::Pull { station: 7, target_m: [0.3, 0.0, 0.1], stiffness_n_m: 5.0, machine: 0 }).unwrap();
    step(&mut session, 20);
    let rolled: Value =
        serde_json::from_str(&session.execute(&Order::Rollback { time_s: 0.1099 }).unwrap().unwrap()).unwrap();
    assert_eq!((rolled["kind"].as_str(), rolled["time"].as_f64()), (Some("rolled_back"), Some(0.1)));
    let torque = session.machines[0].controls.iter().position(|one| one.name == "fold.external_torque").unwrap();
    assert_eq!(rolled["values"][torque], 0.0);
    step(&mut session, 60);
    let (again, repeated) = sent_frame(&mut session);
    assert_eq!((latches(&again), again["time"].as_f64()), (1, after["time"].as_f64()));
    assert_eq!(numbers, repeated);
    let message: Value = serde_json::from_str(&session.connected_message()).unwrap();
    assert_eq!(latches(&message), 1, "the latching that was taken back is told: {message}");
    // back to the start
    session.execute(&Order::Restart {}).unwrap();
    let (header, _) = sent_frame(&mut session);
    assert_eq!((header["time"].as_f64(), header["oldest"].as_f64()), (Some(0.0), Some(0.0)));
}

/// A frame taken while the spring pulls does not store the spring: after a rollback to it, the load is that of the input.
#[test]
fn a_rollback_into_a_pull_has_no_spring() {
    let mut session = session("folding_wing");
    session.execute(&set("load.outer[4].force.z", 0.25)).unwrap();
    session.execute(&Order::Pull { station: 7, target_m: [0.3, 0.0, 0.2], stiffness_n_m: 5.0, machine: 0 }).unwrap();
    step(&mut session, 10);
    let (header, _) = sent_frame(&mut session);
    assert!(header["pull"]["force"][2].as_f64().unwrap().abs() > 0.1, "{header}");
    // a value set during a pull changes the load without the pull
    session.execute(&set("load.outer[4].force.z", 0.5)).unwrap();
    step(&mut session, 10);
    let at_s = session.time_s();
    session.next_frame().unwrap();
    step(&mut session, 10);
    session.execute(&Order::Rollback { time_s: at_s }).unwrap();
    assert_eq!(session.machines[0].plant.inputs().stations()[7].force_n.as_slice(), [0.0, 0.0, 0.5]);
    assert!(session.machines[0].pull.is_none());
    session.execute(&Order::Pull { station: 7, target_m: [0.3, 0.0, 0.2], stiffness_n_m: 5.0, machine: 0 }).unwrap();
    step(&mut session, 1);
    session.execute(&Order::Release {}).unwrap();
    assert_eq!(session.machines[0].plant.inputs().stations()[7].force_n.as_slice(), [0.0, 0.0, 0.5]);
}

/// The latched wing, pulled by a spring, settles at the static equilibrium under the force of the spring; with eight times its damping,
/// within four seconds. The tolerance covers the errors of the statics and of the time steps.
#[test]
fn a_pull_at_rest_is_a_static_load() {
    let mut session = session("folding_wing");
    for damping in ["body.inner.mass_damping", "body.outer.mass_damping"] {
        session.execute(&set(damping, 20.0)).unwrap();
    }
    step(&mut session, 400);
    session
        .execute(&Order::Pull { station: 7, target_m: [0.28125, 0.0, 0.03], stiffness_n_m: 10.0, machine: 0 })
        .unwrap();
    step(&mut session, 8000);
    let (header, _) = sent_frame(&mut session);
    let force: [f64; 3] = serde_json::from_value(header["pull"]["force"].clone()).unwrap();
    let tip_m = session.machines[0].plant.outputs().tips()[0].position_m;
    assert!(force[2] > 0.05, "{force:?}");
    let (_, mut still) = started("folding_wing");
    still.inputs_mut().stations_mut()[7].force_n = force.into();
    let rest = still.study().equilibrium(0.0, Holding::AsReleased);
    assert!(rest.is_ok(), "{rest:?}");
    let statics_m = still.outputs().tips()[0].position_m;
    assert!(statics_m.z > 4e-3 && (tip_m - statics_m).norm() < 1e-6, "{tip_m} against {statics_m}");
}

/// The force of a spring is in the root frame for either load frame of the body, although follower loads rotate with the section.
#[test]
fn a_spring_pulls_alike_in_both_load_frames() {
    let forces = ["root", "section"].map(|frame| {
        let (interface, plant) =
            changed("folding_wing", "[body.outer]\n", &format!("[body.outer]\nload_frame = \"{frame}\"\n"));
        let mut session = Session::new(plant, interface, 1.0);
        session
            .execute(&Order::Pull { station: 7, target_m: [0.2, 0.05, 0.1], stiffness_n_m: 1.0, machine: 0 })
            .unwrap();
        step(&mut session, 100);
        session.machines[0].plant.provide(foldwing_engine::plant::OutputSet::ALL);
        session.machines[0].plant.outputs().tips()[0].position_m
    });
    // over a step, the force is constant in its load frame, which rotates by 0.02 rad meanwhile
    assert!((forces[0] - forces[1]).norm() < 1e-4, "{forces:?}");
}

/// A spring does not feed energy into an oscillation, as it would if its force depended only on the position at the start of the step.
#[test]
fn a_stiff_spring_does_not_feed_the_oscillation() {
    let mut session = session("folding_wing");
    for damping in ["body.inner.mass_damping", "body.outer.mass_damping"] {
        session.execute(&set(damping, 0.0)).unwrap();
    }
    step(&mut session, 400);
    session
        .execute(&Order::Pull { station: 7, target_m: [0.28125, 0.0, 0.0], stiffness_n_m: 200.0, machine: 0 })
        .unwrap();
    let mut energies = Vec::new();
    for _ in 0..2 {
        let mut most = 0.0_f64;
        for _ in 0..1000 {
            step(&mut session, 1);
            session.next_frame().unwrap();
            let energy = session.machines[0].plant.outputs().energy();
            let stretch_m = session.machines[0].plant.outputs().stations()[7].position_m
                - nalgebra::Vector3::new(0.28125, 0.0, 0.0);
            most = most.max(energy.kinetic + energy.elastic + 100.0 * stretch_m.norm_squared());
        }
        energies.push(most);
    }
    // the joint damper dissipates some energy; a force held from the start of the step would feed in ten times as much
    assert!(energies[1] < 1.05 * energies[0], "{energies:?}");
}

/// An invalid value or pull returns a message, and changes nothing.
#[test]
fn wrong_orders_are_refused_with_what_is_allowed() {
    let mut session = session("folding_wing");
    let before = session.values();
    let switch = |name: &str| Order::Set { name: name.to_owned(), value: Given::Switch(true), machine: None };
    for (order, needed) in [
        (set("fold.angel_command", 0.0), "did you mean `fold.angle_command`?"),
        (set("fold.angle", 0.0), "fold.angle cannot be set during a run: only inputs and tunable parameters can"),
        (set("body.outer.mass_factor", 2.0), "cannot be set during a run"),
        (set("fold.motor_damping", -1.0), "variable fold.motor_damping cannot be -1: it must be ≥ 0 N.m.s/rad"),
        (set("fold.release", 1.0), "fold.release cannot be 1: it must be true or false"),
        (switch("fold.angle_command"), "fold.angle_command cannot be true or false: it must be a number"),
        (Order::Watch { names: vec!["fold.angel".to_owned()] }, "did you mean `fold.angle`?"),
        (Order::Watch { names: vec!["fold.release".to_owned()] }, "output"),
        (
            Order::Pull { station: 8, target_m: [0.0; 3], stiffness_n_m: 1.0, machine: 0 },
            "there is no load station 8: they are numbered from 0 to 7",
        ),
    ] {
        let message = session.execute(&order).unwrap_err();
        assert!(message.contains(needed), "{order:?}: {message}");
    }
    assert_eq!(session.values(), before);
    assert!(session.machines[0].pull.is_none() && session.machines[0].watched.is_empty());
}

/// A failed step stops the simulation and reports the reason; after a rollback the simulation can continue.
#[test]
fn a_failure_stops_the_time_until_it_is_rolled_back() {
    let mut session = session("folding_wing");
    step(&mut session, 10);
    session.next_frame().unwrap();
    let good_s = session.time_s();
    session.execute(&set("load.outer[4].force.z", 1e28)).unwrap();
    step(&mut session, 1);
    let (header, _) = sent_frame(&mut session);
    let failure = header["failure"].as_str().unwrap().to_owned();
    let message = session.execute(&Order::Run {}).unwrap_err();
    assert!(message.contains(&failure) && message.contains("roll back on the time bar"), "{message}");
    session.execute(&Order::Rollback { time_s: good_s }).unwrap();
    assert_eq!(session.machines[0].plant.inputs().stations()[7].force_n.z, 0.0);
    step(&mut session, 5);
    let (header, _) = sent_frame(&mut session);
    assert!(header["failure"].is_null() && session.time_s() > good_s);
}

/// The page contains the elements that its scripts use, and no text of the model that would close an HTML element.
#[test]
fn the_page_holds_the_machine_and_its_controls() {
    let mut session = session("folding_wing_in_tunnel");
    let page = session.page();
    let begin = page.find("class=\"live\">").unwrap() + "class=\"live\">".len();
    let live: Value = serde_json::from_str(&page[begin..begin + page[begin..].find("</script").unwrap()]).unwrap();
    assert_eq!(live["controls"].as_array().unwrap().len(), session.machines[0].controls.len());
    // the inner body is 0.15 m long, and the outer one, of 0.15 m, is attached to its end
    assert!((live["reach_m"].as_f64().unwrap() - 0.3).abs() < 1e-12 && live["step_s"] == 5e-4);
    assert!((live["weight_n"].as_f64().unwrap() - 9.81 * 0.06305).abs() < 1e-9);
}

/// Two machines of one session, the second with another damper of the joint.
fn pair() -> Session {
    let (interface, plant) = started("folding_wing");
    let (other_interface, other) = changed("folding_wing", "damping_N_m_s_rad = 0.0008", "damping_N_m_s_rad = 0.002");
    assert_ne!(plant.machine(), other.machine(), "the model file has no such damping");
    Session::of_machines([("a".to_owned(), plant, interface), ("b".to_owned(), other, other_interface)], 1.0)
}

/// Two machines step together, each as it does alone: the numbers of a frame are those of two sessions of one machine, bit for bit, also
/// after a rollback.
#[test]
fn machines_in_step_run_as_each_alone() {
    let mut both = pair();
    let single = |machine: &str| {
        let (interface, plant) = match machine {
            "a" => started("folding_wing"),
            _ => changed("folding_wing", "damping_N_m_s_rad = 0.0008", "damping_N_m_s_rad = 0.002"),
        };
        let mut alone = Session::new(plant, interface, 1.0);
        alone.execute(&Order::Watch { names: vec!["fold.angle".to_owned()] }).unwrap();
        step(&mut alone, 300);
        sent_frame(&mut alone).1
    };
    let (a, b) = (single("a"), single("b"));
    assert_ne!(a, b);
    both.execute(&Order::Watch { names: vec!["fold.angle".to_owned()] }).unwrap();
    sent_frame(&mut both);
    step(&mut both, 300);
    let (header, numbers) = sent_frame(&mut both);
    assert_eq!(numbers, [a, b.clone()].concat());
    let other = &header["others"][0];
    let width =
        |part: &Value| part["numbers"].as_u64().unwrap() as usize + 2 * part["samples"].as_u64().unwrap() as usize;
    assert_eq!((width(&header) + width(other), width(other)), (numbers.len(), b.len()));
    let events: Vec<&str> =
        header["events"].as_array().unwrap().iter().map(|event| event["text"].as_str().unwrap()).collect();
    assert!(
        events[0].starts_with("a: ") && events.iter().all(|text| text.starts_with("a: ") || text.starts_with("b: "))
    );
    // back to the first frame, and again
    both.execute(&Order::Rollback { time_s: 0.0 }).unwrap();
    assert!(both.machines.iter().all(|one| one.plant.time_s() == 0.0));
    step(&mut both, 300);
    assert_eq!(sent_frame(&mut both).1, numbers);
}

/// A value is set on all machines that have its name or on one; if it is invalid for one of them, none is changed. Pulls belong to one
/// machine.
#[test]
fn orders_act_on_all_machines_or_one() {
    let mut both = pair();
    let on = |name: &str, value: f64, machine: Option<usize>| Order::Set {
        name: name.to_owned(),
        value: Given::Number(value),
        machine,
    };
    let torques = |both: &mut Session| {
        both.machines.iter_mut().map(|one| one.value("fold.external_torque").unwrap()).collect::<Vec<_>>()
    };
    both.execute(&on("fold.external_torque", 0.02, None)).unwrap();
    assert_eq!(torques(&mut both), [Given::Number(0.02); 2]);
    both.execute(&on("fold.external_torque", 0.03, Some(1))).unwrap();
    assert_eq!(torques(&mut both), [Given::Number(0.02), Given::Number(0.03)]);
    let message = both.execute(&on("fold.external_torque", 0.03, Some(2))).unwrap_err();
    assert_eq!(message, "there is no model 2: models are numbered from 0 to 1");
    let message = both.execute(&on("fold.motor_damping", -1.0, Some(1))).unwrap_err();
    assert!(message.starts_with("b: variable fold.motor_damping cannot be -1"), "{message}");
    let target_m = [0.3, 0.0, 0.1];
    both.execute(&Order::Pull { station: 7, target_m, stiffness_n_m: 5.0, machine: 1 }).unwrap();
    step(&mut both, 5);
    let (header, _) = sent_frame(&mut both);
    assert!(header["pull"].is_null() && header["others"][0]["pull"]["station"] == 7, "{header}");
    both.execute(&Order::Release {}).unwrap();
    assert!(both.machines.iter().all(|one| one.pull.is_none()));
    let message = both.execute(&Order::Pull { station: 7, target_m, stiffness_n_m: 5.0, machine: 2 }).unwrap_err();
    assert!(message.contains("no model 2"), "{message}");
}

/// A value that is invalid only for the second machine leaves the first unchanged, and the message has the name of the second. Machines
/// without a name are left out.
#[test]
fn a_value_refused_by_one_machine_changes_none() {
    let (interface, plant) = started("folding_wing");
    let (other_interface, other) = started("folding_wing_in_tunnel");
    let mut both =
        Session::of_machines([("a".to_owned(), plant, interface), ("b".to_owned(), other, other_interface)], 1.0);
    // the name of the tunnel's wind is unknown to the first machine
    let only = both.machines[1].controls.iter().find(|one| !both.machines[0].has_control(&one.name)).unwrap();
    let (name, kind) = (only.name.clone(), only.kind);
    assert_eq!(kind, "real", "{name}");
    both.execute(&set(&name, 0.0)).unwrap();
    assert!(both.execute(&set("no.such_name", 0.0)).unwrap_err().starts_with("a: "));
    // an input of both, which is a switch in the second
    let name = "fold.external_torque";
    let at = both.machines[1].controls.iter().position(|one| one.name == name).unwrap();
    both.machines[1].controls[at].kind = "switch";
    let before = both.values();
    let message = both.execute(&set(name, 0.02)).unwrap_err();
    assert_eq!(message, format!("b: {name} cannot be 0.02: it must be true or false"));
    assert_eq!(both.values(), before);
    // outputs of one machine are plotted, those of none are errors
    let watch = |name: &str| Order::Watch { names: vec!["fold.angle".to_owned(), name.to_owned()] };
    both.execute(&watch("aero.force.z")).unwrap();
    assert_eq!(both.machines.iter().map(|one| one.watched.len()).collect::<Vec<_>>(), [1, 2]);
    let message = both.execute(&watch("fold.angel")).unwrap_err();
    assert!(message.contains("did you mean `fold.angle`?"), "{message}");
}

/// A machine that fails stops all machines, and the message names it; after a rollback both continue.
#[test]
fn a_failure_of_one_machine_stops_all() {
    let mut both = pair();
    step(&mut both, 10);
    both.next_frame().unwrap();
    let good_s = both.time_s();
    let name = "load.outer[4].force.z".to_owned();
    both.execute(&Order::Set { name, value: Given::Number(1e28), machine: Some(1) }).unwrap();
    step(&mut both, 1);
    let (header, _) = sent_frame(&mut both);
    assert!(header["failure"].as_str().unwrap().starts_with("b: "), "{header}");
    both.execute(&Order::Rollback { time_s: good_s }).unwrap();
    step(&mut both, 5);
    let times: Vec<f64> = both.machines.iter().map(|one| one.plant.time_s()).collect();
    assert!(times[0] == times[1] && times[0] > good_s, "{times:?}");
}

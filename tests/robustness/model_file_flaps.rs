//! Control surfaces: errors, and the meaning of an accepted file.

use crate::model_file::{MODEL, message_of};
use foldwing::config;
use foldwing::machine::Machine;

const AIR: &str = "[aerodynamics]\nmodel = \"strip\"\nwind_m_s = [0, -10, 0]\n";
const SURFACE: &str = "[surface.in]\nbody = \"inner\"\nstrips = 6\n";
const FLAP: &str = "[control_surface.f]\nbody = \"inner\"\nfrom_m = 0.05\nto_m = 0.1\nhinge_fraction = 0.75\n";

fn machine(lines: &str) -> Machine {
    config::parse(&format!("{MODEL}{lines}"), "wing.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// Strips end at the ends of a flap, whatever their number; without flaps they are unchanged.
#[test]
fn strips_end_where_flaps_end() {
    let air = machine(&format!("{AIR}{SURFACE}{FLAP}")).air.expect("air");
    assert_eq!(air.flaps[0].strips, 2..4);
    assert_eq!((air.surfaces[0].positions_m[2], air.surfaces[0].positions_m[4]), (0.05, 0.1));
    let odd = FLAP.replace("0.05", "0.013").replace("to_m = 0.1", "to_m = 0.15");
    let air = machine(&format!("{AIR}{SURFACE}{odd}")).air.expect("air");
    assert_eq!((air.flaps[0].strips.clone(), air.surfaces[0].positions_m.len()), (1..6, 7));
    assert_eq!(air.surfaces[0].positions_m[1], 0.013);
    let flap = &air.flaps[0];
    let thirty = 30f64.to_radians();
    assert_eq!((flap.lower_rad, flap.upper_rad, flap.command_rad, flap.downward), (-thirty, thirty, 0.0, 1.0));
}

/// A flap in a lattice that reaches the tip ends with the lattice, a quarter of a strip before it.
#[test]
fn flaps_reach_the_tip_of_a_lattice() {
    let whole = FLAP.replace("0.05", "0").replace("to_m = 0.1", "to_m = 0.15");
    let air = machine(&format!("{}{SURFACE}{whole}", AIR.replace("strip", "uvlm"))).air.expect("air");
    assert_eq!(air.flaps[0].strips, 0..6);
}

/// Each error gives location, value, allowed values and the remedy.
#[test]
fn flaps_that_cannot_be() {
    let refused = |change: &dyn Fn(&str) -> String, parts: &[&str]| {
        let message = message_of(&format!("{MODEL}{}", change(&format!("{AIR}{SURFACE}{FLAP}"))));
        assert!(parts.iter().all(|part| message.contains(part)), "{message}\nlacks some of {parts:?}");
    };
    let replaced = |from: &'static str, to: &'static str| move |text: &str| text.replace(from, to);
    refused(&replaced("to_m = 0.1", "to_m = 0.2"), &["control_surface.f.to_m", "0.2", "0 to 0.15 m"]);
    refused(&replaced("from_m = 0.05", "from_m = -0.01"), &["control_surface.f.from_m", "-0.01", "0 to 0.15 m"]);
    refused(&replaced("from_m = 0.05", "from_m = 0.1"), &["control_surface.f.to_m", "from_m = 0.1 m"]);
    refused(&replaced("= 0.75", "= 1.0"), &["control_surface.f.hinge_fraction", "> 0 and < 1"]);
    refused(&replaced("= 0.75", "= 0.0"), &["control_surface.f.hinge_fraction", "> 0 and < 1"]);
    refused(&replaced("= 0.75", "= nan"), &["control_surface.f.hinge_fraction"]);
    refused(
        &replaced("[control_surface.f]\nbody = \"inner\"", "[control_surface.f]\nbody = \"outer\""),
        &["control_surface.f.body", "lifting surface", "inner"],
    );
    refused(
        &replaced("[control_surface.f]\nbody = \"inner\"", "[control_surface.f]\nbody = \"iner\""),
        &["control_surface.f.body", "inner"],
    );
    refused(&replaced(AIR, ""), &["aerodynamics"]);
    let second = |text: &str| {
        format!(
            "{text}{}",
            FLAP.replace("control_surface.f", "control_surface.g")
                .replace("0.05", "0.09")
                .replace("to_m = 0.1", "to_m = 0.12")
        )
    };
    refused(&second, &["control_surface.g.from_m", "overlaps control surface \"f\"", "side by side"]);
    refused(&replaced("strips = 6", "strips = 2"), &["surface.in.strips", "at least 3 strips"]);
    refused(&|text: &str| format!("{text}lower_deg = 5\nupper_deg = -5\n"), &["control_surface.f.lower_deg"]);
    refused(&|text: &str| format!("{text}command_deg = 45\n"), &["control_surface.f.command_deg", "limits"]);
    refused(&|text: &str| format!("{text}upper_deg = 75\n"), &["control_surface.f.upper_deg", "60"]);
    let lattice = |text: &str| text.replace("strip\"", "uvlm\"").replace("= 0.75", "= 0.8");
    refused(&lattice, &["control_surface.f.hinge_fraction", "0.8", "chord_panels = 4", "chord_panels = 5"]);
}

/// Ground and speed of sound: complete keys, a ground normal to mirrors, only with aerodynamic models that support them.
#[test]
fn grounds_and_speeds_of_sound_that_cannot_be() {
    let refused = |keys: &str, more: &str, parts: &[&str]| {
        let message = message_of(&format!("{MODEL}{}{keys}{SURFACE}{more}", AIR.replace("strip", "uvlm")));
        assert!(parts.iter().all(|part| message.contains(part)), "{message}\nlacks some of {parts:?}");
    };
    refused("ground_normal = [0, 0, 1]\n", "", &["aerodynamics.ground_distance_m", "both"]);
    refused("ground_distance_m = 1.0\n", "", &["aerodynamics.ground_normal", "both"]);
    refused("ground_normal = [0, 0, 0]\nground_distance_m = 1.0\n", "", &["aerodynamics.ground_normal", "not all 0"]);
    let tilted = "mirror_normal = [1, 0, 0]\nground_normal = [1, 0, 1]\nground_distance_m = 1.0\n";
    refused(tilted, "", &["aerodynamics.ground_normal", "perpendicular to mirror_normal"]);
    refused("speed_of_sound_m_s = 0.0\n", "", &["aerodynamics.speed_of_sound_m_s", "> 0"]);
    let message = message_of(&format!("{MODEL}{AIR}ground_normal = [0, 0, 1]\nground_distance_m = 1.0\n{SURFACE}"));
    assert!(message.contains("ground_normal") && message.contains("uvlm"), "{message}");
    let polar = "polar = [[-10.0, -1.0, 0.01, 0.0], [10.0, 1.0, 0.01, 0.0]]\n";
    let message = message_of(&format!("{MODEL}{AIR}speed_of_sound_m_s = 340.0\n{SURFACE}{polar}"));
    assert!(message.contains("surface.in.polar") && message.contains("Mach"), "{message}");
    let air = machine(&format!(
        "{}mirror_normal = [2, 0, 0]\nground_normal = [0, 0, 3]\nground_distance_m = 1.0\nspeed_of_sound_m_s = 340.0\n{SURFACE}",
        AIR.replace("strip", "uvlm")
    ));
    let air = air.air.expect("air");
    let foldwing::machine::AirOptions::Lattice(options) = &air.parts[0].options else { panic!("a lattice") };
    assert_eq!(options.ground.map(|ground| (ground.normal.z, ground.distance_m)), Some((1.0, 1.0)));
    assert_eq!(options.speed_of_sound_m_s, Some(340.0));
}

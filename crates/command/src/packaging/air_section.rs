//! Aerodynamics on the documentation page.

use crate::packaging::html::{number, table, vector};
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::{AirOptions, AirPart, Coupling, EndRule, LoadRule, PitchRate, WakeModel};
use quick_xml::escape::escape;

/// Writes the section; empty without aerodynamics.
pub(super) fn write(html: &mut String, machine: &Machine) {
    let Some(air) = &machine.air else { return };
    html.push_str("<h2>Air</h2>\n<p>");
    for part in &air.parts {
        if !part.name.is_empty() {
            html.push_str(&format!("{}: ", escape(&part.name)));
        }
        html.push_str(&describe(part));
        html.push(' ');
    }
    html.push_str(&format!(
        "Density {} kg/m³, wind {} m/s at the start, aerodynamic steps of {} s, {}. The aerodynamic loads of a step are \
         constant and rotate with the sections; wind and other inputs act from the end of the current aerodynamic step \
         on.</p>\n",
        number(air.density_kg_m3),
        vector(air.wind_m_s.as_slice()),
        number(air.step_s),
        match air.coupling {
            Coupling::Staggered => "one correction per step",
            Coupling::Iterated { .. } => "iterated with the structure",
        }
    ));
    if air.surfaces.is_empty() {
        return;
    }
    let head = ["surface on", "strips", "panels along the chord", "from (m)", "to (m)", "chord (m)"];
    table(
        html,
        &head,
        air.surfaces.iter().map(|surface| {
            let last = surface.positions_m.len() - 1;
            let chords = [&surface.chords[0], &surface.chords[last]].map(|chord| number(chord.length_m()));
            vec![
                escape(&machine.bodies[surface.body].name).into_owned(),
                last.to_string(),
                surface.chord_panels.to_string(),
                number(surface.positions_m[0]),
                number(surface.positions_m[last]),
                if chords[0] == chords[1] { chords[0].clone() } else { chords.join(" … ") },
            ]
        }),
    );
}

/// Describes an aerodynamic model.
fn describe(part: &AirPart) -> String {
    match &part.options {
        AirOptions::Lattice(lattice) => format!(
            "Unsteady vortex lattice, {} wake of {} rows, core radius {} m, loads by {}{}.",
            match lattice.wake {
                WakeModel::Prescribed => "prescribed",
                WakeModel::Free => "free",
            },
            lattice.wake_rows,
            number(lattice.core_radius_m),
            match lattice.load_rule {
                LoadRule::Bernoulli => "Bernoulli's equation",
                LoadRule::KuttaJoukowski => "Kutta–Joukowski's theorem",
            },
            lattice.mirror_normal.map_or(String::new(), |normal| {
                format!(", mirror plane through the origin with normal {}", vector(normal.as_slice()))
            })
        ),
        AirOptions::Rotor(rotor) => format!(
            "Blade-element momentum theory on {} blades{}{}{}{}{}; {}.",
            rotor.features.blades.unwrap_or(part.surfaces.len()),
            rotor
                .features
                .inflow_lag_s
                .map_or(String::new(), |lag_s| { format!(", induced velocity with a lag of {} s", number(lag_s)) }),
            match rotor.features.pitch_rate {
                PitchRate::None => "",
                PitchRate::Hub => ", pitch rate relative to the hub",
                PitchRate::Air => ", pitch rate relative to the air",
            },
            if rotor.features.skewed_wake { ", skewed wake" } else { "" },
            if rotor.features.dynamic_inflow { ", dynamic inflow" } else { "" },
            if rotor.features.dynamic_stall { ", dynamic stall" } else { "" },
            match rotor.features.end_loads {
                _ if rotor.features.inflow_lag_s.is_some() => "no losses at tip and hub",
                EndRule::ZeroLoad => "no load where the tip or hub loss is complete",
                EndRule::Stopped => "the wind stopped where the tip or hub loss is complete",
            }
        ),
        AirOptions::SlenderBody(body) => format!(
            "Slender body of {} parts from {} to {} m, largest radius {} m, volume {} m³{}, cross-flow drag coefficient {}, \
             axial drag coefficient {}.",
            body.positions_m.len() - 1,
            number(body.positions_m[0]),
            number(body.positions_m[body.positions_m.len() - 1]),
            number(body.largest_m()),
            number(body.volume_m3()),
            if body.apparent_mass { "" } else { ", without apparent mass" },
            number(body.cross_flow_drag_coefficient),
            number(body.axial_drag_coefficient)
        ),
        AirOptions::Strips(strips) => format!(
            "{} strips{}{}.",
            if strips.unsteady { "Unsteady" } else { "Quasi-steady" },
            if strips.apparent_mass { " with apparent mass" } else { "" },
            strips.tip_loss.map_or(String::new(), |line| {
                let mirror = line.mirror_normal.map_or(String::new(), |normal| {
                    format!(", mirror plane through the origin with normal {}", vector(normal.as_slice()))
                });
                format!(", tip loss by a lifting line, core radius {} m{mirror}", number(line.core_radius_m))
            })
        ),
    }
}

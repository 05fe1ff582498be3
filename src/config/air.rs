//! Air of the file: the tables `[aerodynamics]`, `[surface.<name>]` and `[gust.<name>]`.

use crate::aero::AirOptions;
use crate::aero::flow::{Gust, GustShape};
use crate::aero::lattice::{LatticeOptions, LoadRule, WakeModel};
use crate::aero::polar::{Polar, PolarRow};
use crate::aero::strip::StripOptions;
use crate::aero::strip::indicial::Fit;
use crate::aero::surface::{ChordLine, Profile};
use crate::beam::profile::Profile as Along;
use crate::config::air_file::{
    AirModelFile, CouplingFile, GustFile, GustShapeFile, IndicialFile, LeadingEdgeFile, SurfaceFile,
};
use crate::config::body::{self, BodyFile};
use crate::config::file::ModelFile;
use crate::config::function::{FunctionFile, along_body};
use crate::config::schema::shortest;
use crate::config::sections::Sections;
use crate::config::tree::Tree;
use crate::config::validate::Checker;
use crate::machine::edges::{RootEdge, fastest_m_s, free_edges, other_half};
use crate::machine::{Air, Body, Coupling, LiftingSurface};
use nalgebra::Vector3;

/// Inset of a free edge of the lattice in panels: uniform lattices that reach the tip converge only as `1/N`.
const INSET_PANELS: f64 = 0.25;
/// Most panels of a lattice: its matrix then takes 200 MB, and its factors half a minute.
const MOST_PANELS: usize = 5_000;
/// Most panels of a wake.
const MOST_WAKE_PANELS: usize = 200_000;
/// Core radius over the smallest panel's chord where the file states none.
const CORE_SHARE: f64 = 1e-2;

/// A surface of the file with what its place along the span is made of.
struct Draft {
    body: usize,
    strips: usize,
    chord_panels: usize,
    axis_fraction: f64,
    forward: f64,
    chord_m: Along,
    incidence_deg: Along,
    profile: Profile,
}

impl Draft {
    /// Chord at a distance in m from the body's inner end.
    fn chord_line(&self, s: f64) -> ChordLine {
        let (chord_m, incidence_rad) = (self.chord_m.at(s), self.incidence_deg.at(s).to_radians());
        let forward = Vector3::new(0.0, self.forward * incidence_rad.cos(), incidence_rad.sin());
        ChordLine {
            leading_m: forward * (self.axis_fraction * chord_m),
            trailing_m: forward * ((self.axis_fraction - 1.0) * chord_m),
        }
    }
}

/// The air; `Err` where a problem was found, `Ok(None)` where the file has no air.
pub(super) fn build(
    file: &ModelFile,
    sections: &Sections,
    tree: Option<&Tree>,
    bodies: &[Body],
    checker: &mut Checker,
) -> Result<Option<Air>, ()> {
    let drafts: Vec<Option<Draft>> = file
        .surface
        .iter()
        .enumerate()
        .map(|(index, (name, surface))| draft(index, name, surface, file, sections, tree, checker))
        .collect();
    let gusts: Vec<Option<Gust>> = file.gust.iter().map(|(name, gust)| build_gust(name, gust, file, checker)).collect();
    let Some(air) = file.aerodynamics.as_ref().filter(|air| air.model != AirModelFile::None) else {
        let stray = file.surface.keys().next().map(|name| ["surface", name]);
        let stray = stray.or(file.gust.keys().next().map(|name| ["gust", name]));
        if let (Some(path), None) = (stray, &file.aerodynamics) {
            checker.refuse_as(&path, "a table without air", "a model file with [aerodynamics]");
            return Err(());
        }
        return Ok(None);
    };
    if file.surface.is_empty() {
        checker.refuse_as(&["aerodynamics", "model"], "air without a surface", "at least one table [surface.<name>]");
        return Err(());
    }
    let mirror = match air.mirror_normal {
        None => None,
        Some(normal) => match Vector3::from(normal).try_normalize(0.0) {
            Some(normal) => Some(normal),
            None => {
                checker.refuse(&["aerodynamics", "mirror_normal"], "an array of 3 finite numbers, not all 0");
                return Err(());
            }
        },
    };
    let drafts = drafts.into_iter().collect::<Option<Vec<_>>>().ok_or(())?;
    let gusts = gusts.into_iter().collect::<Option<Vec<_>>>().ok_or(())?;
    if bodies.is_empty() {
        return Err(());
    }
    let lattice = air.model == AirModelFile::Uvlm;
    let edges: Vec<RootEdge> =
        drafts.iter().map(|draft| RootEdge { body: draft.body, chord: draft.chord_line(0.0) }).collect();
    let free = |draft: &Draft| if lattice { free_edges(draft.body, &edges, bodies, mirror) } else { [false; 2] };
    let mut surfaces: Vec<LiftingSurface> = drafts.iter().map(|draft| place(draft, free(draft), bodies)).collect();
    for surface in &mut surfaces {
        surface.other_half = other_half(surface.body, &edges, bodies).filter(|_| lattice);
    }
    surfaces.sort_by_key(|surface| surface.body);
    let smallest_m = surfaces
        .iter()
        .flat_map(|surface| surface.chords.iter().map(|chord| chord.length_m() / surface.chord_panels as f64))
        .fold(f64::INFINITY, f64::min);
    if lattice {
        check_size(&drafts, air.wake_rows, checker)?;
    }
    let wind_m_s = Vector3::from(air.wind_m_s);
    let step_s = match air.step_s {
        Some(step_s) => step_s,
        None => match fastest_m_s(&surfaces, bodies, wind_m_s, file.experiment.start_time_s) {
            Some(speed_m_s) => smallest_m / speed_m_s,
            None => {
                let allowed = "a finite time > 0 s: it has no default where wing and air do not move against each other at the start";
                checker.refuse(&["aerodynamics", "step_s"], allowed);
                return Err(());
            }
        },
    };
    let options = match air.model {
        AirModelFile::Uvlm => AirOptions::Lattice(LatticeOptions {
            wake: if air.free_wake { WakeModel::Free } else { WakeModel::Prescribed },
            wake_rows: air.wake_rows,
            core_radius_m: air.core_radius_m.unwrap_or(CORE_SHARE * smallest_m),
            load_rule: if air.leading_edge_suction.unwrap_or(false) {
                LoadRule::KuttaJoukowski
            } else {
                LoadRule::Bernoulli
            },
            mirror_normal: mirror,
            threads: air.threads,
        }),
        AirModelFile::Strip | AirModelFile::None => AirOptions::Strips(StripOptions {
            unsteady: !air.quasi_steady,
            apparent_mass: air.apparent_mass,
            fit: match air.indicial {
                IndicialFile::Jones => Fit::Jones,
                IndicialFile::Fine => Fit::Fine,
            },
            leading_edge_suction: air.leading_edge_suction.unwrap_or(true),
        }),
    };
    Ok(Some(Air {
        options,
        density_kg_m3: air.density_kg_m3,
        wind_m_s,
        step_s,
        coupling: match air.coupling {
            CouplingFile::Staggered => Coupling::Staggered,
            CouplingFile::Iterated => {
                Coupling::Iterated { tolerance: air.coupling_tolerance, most_iterations: air.coupling_iterations }
            }
        },
        established: air.established,
        reports_circulation: air.report_circulation,
        surfaces,
        gusts,
    }))
}

/// Refuses lattices that memory or patience do not hold.
fn check_size(drafts: &[Draft], wake_rows: usize, checker: &mut Checker) -> Result<(), ()> {
    let panels: usize = drafts.iter().map(|draft| draft.strips * draft.chord_panels).sum();
    if panels > MOST_PANELS {
        let allowed = format!("at most {MOST_PANELS} panels: strips times chord_panels, of all surfaces together");
        checker.refuse_as(&["surface"], format!("a lattice of {panels} panels"), allowed);
        return Err(());
    }
    let wake_panels = wake_rows * drafts.iter().map(|draft| draft.strips).sum::<usize>();
    if wake_panels > MOST_WAKE_PANELS {
        let allowed = format!("at most {MOST_WAKE_PANELS} panels: wake_rows times the strips of all surfaces");
        checker.refuse_as(&["aerodynamics", "wake_rows"], format!("a wake of {wake_panels} panels"), allowed);
        return Err(());
    }
    Ok(())
}

fn draft(
    index: usize,
    name: &str,
    surface: &SurfaceFile,
    file: &ModelFile,
    sections: &Sections,
    tree: Option<&Tree>,
    checker: &mut Checker,
) -> Option<Draft> {
    let path = ["surface", name, "body"];
    let Some((place, _, body)) = file.body.get_full(&surface.body) else {
        checker.unknown_name(&path, &surface.body, "a body", file.body.keys().map(String::as_str));
        return None;
    };
    let earlier = file.surface.iter().take(index).find(|(_, other)| other.body == surface.body);
    if let Some((other, _)) = earlier {
        checker.refuse(&path, format!("a body without a surface; {other:?} is on this one"));
        return None;
    }
    let chord_m = chord(name, surface, body, sections, checker)?;
    let incidence_deg = match &surface.incidence_deg {
        None => Along::constant(0.0),
        Some(incidence) => along_body(&["surface", name, "incidence_deg"], incidence, body.length_m, checker)?,
    };
    Some(Draft {
        body: tree.map_or(place, |tree| tree.rank[place]),
        strips: surface.strips,
        chord_panels: surface.chord_panels,
        axis_fraction: surface.axis_fraction,
        forward: match surface.leading_edge {
            LeadingEdgeFile::Plus => 1.0,
            LeadingEdgeFile::Minus => -1.0,
        },
        chord_m,
        incidence_deg,
        profile: Profile {
            lift_slope_1_rad: surface.lift_slope_1_rad,
            zero_lift_angle_rad: surface.zero_lift_angle_deg.to_radians(),
            moment_coefficient: surface.moment_coefficient,
            drag_coefficient: surface.drag_coefficient,
            polar: match &surface.polar {
                None => None,
                Some(rows) => Some(polar(name, rows, checker)?),
            },
        },
    })
}

/// Polar of a profile.
fn polar(name: &str, rows: &[[f64; 4]], checker: &mut Checker) -> Option<Polar> {
    let ascending = rows.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    if !ascending || rows.iter().any(|row| row[0].abs() > 180.0) {
        let allowed =
            "rows [angle of attack in deg, lift, drag, moment coefficient] with angles ascending from -180 to 180";
        checker.refuse(&["surface", name, "polar"], allowed);
        return None;
    }
    let row = |row: &[f64; 4]| PolarRow { angle_rad: row[0].to_radians(), lift: row[1], drag: row[2], moment: row[3] };
    Some(Polar { rows: rows.iter().map(row).collect() })
}

/// Chord along the body: stated, or the width of its section.
fn chord(
    name: &str,
    surface: &SurfaceFile,
    body: &BodyFile,
    sections: &Sections,
    checker: &mut Checker,
) -> Option<Along> {
    let path = ["surface", name, "chord_m"];
    let chord_m = match &surface.chord_m {
        Some(chord) => along_body(&path, chord, body.length_m, checker)?,
        None => {
            // a law that does not stand is refused with its body
            let law = body::section_law(&surface.body, body, sections, &mut checker.silent())?;
            let samples = law.samples_m(body.length_m);
            let widths: Option<Vec<[f64; 2]>> =
                samples.iter().map(|&s| law.solid_at(s).map(|_| [s, 2.0 * law.at(s).half_width_m])).collect();
            let Some(mut widths) = widths else {
                checker.refuse(&path, "a finite length > 0 m: the body's section has no width to take it from");
                return None;
            };
            widths.sort_by(|a, b| a[0].total_cmp(&b[0]));
            widths.dedup_by(|b, a| b[0] <= a[0]);
            match widths.len() {
                1 => Along::constant(widths[0][1]),
                _ => Along::Table(widths),
            }
        }
    };
    let least = chord_m.samples_m(body.length_m).into_iter().map(|s| chord_m.at(s)).fold(f64::INFINITY, f64::min);
    if least > 0.0 {
        return Some(chord_m);
    }
    match &surface.chord_m {
        Some(FunctionFile::Number(_)) => checker.refuse(&path, "a finite length > 0 m"),
        _ => checker.refuse_as(
            &path,
            format!("a chord that falls to {} m on the body", shortest(least)),
            "a chord > 0 m all along the body",
        ),
    }
    None
}

/// Edges of the strips along the span and their chord lines.
fn place(draft: &Draft, free: [bool; 2], bodies: &[Body]) -> LiftingSurface {
    let length_m = bodies[draft.body].length_m;
    let inset = free.map(|free| if free { INSET_PANELS } else { 0.0 });
    let width_m = length_m / (draft.strips as f64 + inset[0] + inset[1]);
    let positions_m: Vec<f64> = (0..=draft.strips)
        .map(|edge| match edge == draft.strips && !free[1] {
            true => length_m,
            false => (inset[0] + edge as f64) * width_m,
        })
        .collect();
    let chords = positions_m.iter().map(|&s| draft.chord_line(s)).collect();
    LiftingSurface {
        body: draft.body,
        other_half: None,
        positions_m,
        chords,
        chord_panels: draft.chord_panels,
        profile: draft.profile.clone(),
    }
}

fn build_gust(name: &str, gust: &GustFile, file: &ModelFile, checker: &mut Checker) -> Option<Gust> {
    let wind_m_s = file.aerodynamics.as_ref().map_or(Vector3::zeros(), |air| Vector3::from(air.wind_m_s));
    let direction = match gust.direction {
        Some(direction) => Vector3::from(direction).try_normalize(0.0),
        None => wind_m_s.try_normalize(0.0),
    };
    let Some(direction) = direction else {
        let allowed = "an array of 3 finite numbers, not all 0; its default is the direction of wind_m_s";
        checker.refuse(&["gust", name, "direction"], allowed);
        return None;
    };
    let speed_m_s = gust.speed_m_s.unwrap_or(wind_m_s.norm());
    if speed_m_s <= 0.0 {
        let allowed = "a finite speed > 0 m/s; its default is that of wind_m_s";
        checker.refuse(&["gust", name, "speed_m_s"], allowed);
        return None;
    }
    let shape = match (gust.shape, gust.length_m) {
        (GustShapeFile::SharpEdge, None) => GustShape::SharpEdge,
        (GustShapeFile::OneMinusCosine, Some(length_m)) => GustShape::OneMinusCosine { length_m },
        (GustShapeFile::SharpEdge, Some(_)) => {
            checker.refuse(&["gust", name, "length_m"], "no length: a sharp edge has none");
            return None;
        }
        (GustShapeFile::OneMinusCosine, None) => {
            checker.refuse(&["gust", name, "length_m"], "a finite length > 0 m");
            return None;
        }
    };
    Some(Gust {
        name: name.to_owned(),
        shape,
        velocity_m_s: gust.velocity_m_s.into(),
        direction,
        speed_m_s,
        origin_m: gust.origin_m.into(),
        start_s: gust.start_s,
    })
}

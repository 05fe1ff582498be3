//! Aerodynamics of a rotor in the model file: settings, polars, wind and tower.

use crate::air_file::AirFile;
use crate::base64;
use crate::checker::Checker;
use crate::file::ModelFile;
use crate::rotor_file::{
    EndRuleFile, PitchRateFile, PolarFile, PotentialFile, ShadowFile, SideFile, SpreadFile, TowerFile, TurnsFile,
    WindFile,
};
use crate::wind_file::{BladedSettings, is_bladed, read_field};
use foldwing_engine::aero::polar::{Polar, PolarRow};
use foldwing_engine::aero::rotor::induction::EndRule;
use foldwing_engine::aero::rotor::options::{PitchRate, Spread};
use foldwing_engine::aero::rotor::tower::{Potential, Shadow, Tower};
use foldwing_engine::aero::rotor::turbulence::Turbulence;
use foldwing_engine::aero::rotor::viterna::{drag_across, extend, extend_both, is_full_circle};
use foldwing_engine::aero::rotor::wind::{Shear, Source, TableRow, WindField, WindTable};
use foldwing_engine::machine::Air;
use foldwing_engine::machine::builder::{AirBuilder, RotorSettings};
use nalgebra::Vector3;

/// Keys of `[aerodynamics]` and of `[surface.<name>]` that only a rotor uses.
pub(super) const KEYS: &[&str] = &[
    "hub",
    "hub_radius_m",
    "shaft_axis",
    "rotation_direction",
    "end_loads",
    "skewed_wake",
    "dynamic_inflow",
    "inflow_lag_s",
    "blades",
    "pitch_rate",
    "load_interpolation",
    "dynamic_stall",
    "aerodyn_compatible",
];
pub(super) const SURFACE_KEYS: &[&str] = &["stations_m", "polars", "length_m"];

/// Path of a key of an aerodynamic model; a single model has no name.
pub(super) fn air_path<'p>(part: &'p str, key: &'p str) -> Vec<&'p str> {
    match part {
        "" => vec!["aerodynamics", key],
        part => vec!["aerodynamics", part, key],
    }
}

/// Builds the aerodynamics of the rotor; `part`: its name, empty for the single model of a machine. `None` after an error.
pub(super) fn build(part: &str, air: &AirFile, file: &ModelFile, checker: &mut Checker) -> Option<AirBuilder> {
    let hub = needed(&air.hub, &air_path(part, "hub"), "the body that rotates with the blades", checker);
    let radius = needed(
        &air.hub_radius_m,
        &air_path(part, "hub_radius_m"),
        "a finite length > 0 m: from the apex to the blades",
        checker,
    );
    let mut settings = RotorSettings::on(hub?, radius?);
    settings.shaft_axis = Vector3::from(air.shaft_axis);
    settings.features.clockwise = air.rotation_direction == TurnsFile::Clockwise;
    settings.features.end_loads = match air.end_loads {
        EndRuleFile::Zero => EndRule::ZeroLoad,
        EndRuleFile::FullInduction => EndRule::Stopped,
    };
    settings.features.skewed_wake = air.skewed_wake;
    settings.features.dynamic_inflow = air.dynamic_inflow;
    settings.features.inflow_lag_s = air.inflow_lag_s;
    settings.features.blades = air.blades;
    settings.features.pitch_rate = match air.pitch_rate {
        PitchRateFile::None => PitchRate::None,
        PitchRateFile::Hub => PitchRate::Hub,
        PitchRateFile::Air => PitchRate::Air,
    };
    settings.features.spread = match air.load_interpolation {
        SpreadFile::Linear => Spread::Linear,
        SpreadFile::PiecewiseConstant => Spread::Cells,
    };
    refuse_rivals(part, air, checker);
    settings.features.dynamic_stall = air.dynamic_stall;
    settings.features.aerodyn_compatible = air.aerodyn_compatible;
    for (name, polar) in &file.polar {
        settings.polars.push((name.clone(), full_circle(name, polar, checker)?));
    }
    if let Some(tower) = &file.tower {
        settings.features.tower = Some(build_tower(tower, checker)?);
    }
    if let Some(wind) = &file.wind {
        settings.features.field = Some(field(wind, air, checker)?);
    }
    Some(Air::rotor(settings))
}

/// Reports keys that exclude each other.
fn refuse_rivals(part: &str, air: &AirFile, checker: &mut Checker) {
    let stated = [
        ("dynamic_inflow", air.dynamic_inflow),
        ("skewed_wake", air.skewed_wake),
        ("aerodyn_compatible", air.aerodyn_compatible),
        ("end_loads", air.end_loads == EndRuleFile::FullInduction),
    ];
    for (key, _) in stated.into_iter().filter(|(_, stated)| *stated && air.inflow_lag_s.is_some()) {
        checker.refuse(
            &air_path(part, key),
            "this setting only without inflow_lag_s, which replaces the momentum balance",
        );
    }
    if air.dynamic_stall && air.pitch_rate != PitchRateFile::None {
        checker
            .refuse(&air_path(part, "pitch_rate"), "\"none\" with dynamic_stall, whose states include the pitch rate");
    }
}

fn needed<T: Clone>(value: &Option<T>, path: &[&str], allowed: &str, checker: &mut Checker) -> Option<T> {
    if value.is_none() {
        checker.refuse(path, allowed);
    }
    value.clone()
}

/// Builds a polar from −180° to 180°.
fn full_circle(name: &str, polar: &PolarFile, checker: &mut Checker) -> Option<Polar> {
    let rows = match (&polar.rows, &polar.file) {
        (Some(rows), None) => rows,
        (Some(_), Some(_)) => {
            checker.refuse(&["polar", name, "file"], "either rows or file, not both");
            return None;
        }
        (None, Some(_)) => {
            let allowed = "a file name, if the model itself is read from a file; a model given as text must have rows";
            checker.refuse(&["polar", name, "file"], allowed);
            return None;
        }
        (None, None) => {
            checker.refuse(
                &["polar", name, "rows"],
                "rows [angle of attack in deg, lift, drag, moment coefficient], or a file",
            );
            return None;
        }
    };
    let ascending = rows.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    let finite = rows.iter().flatten().all(|value| value.is_finite());
    if !ascending || !finite || rows.is_empty() || rows.iter().any(|row| row[0].abs() > 180.0) {
        let allowed = "rows [angle of attack in deg, lift, drag, moment coefficient] of finite numbers with angles ascending from -180 to 180";
        checker.refuse(&["polar", name, "rows"], allowed);
        return None;
    }
    let row = |row: &[f64; 4]| PolarRow { angle_rad: row[0].to_radians(), lift: row[1], drag: row[2], moment: row[3] };
    let rows: Vec<PolarRow> = rows.iter().map(row).collect();
    let path = ["polar", name, "pressure_shift_deg"];
    match polar.pressure_shift_deg {
        Some(shift_deg) if !(shift_deg > 0.0 && shift_deg <= 80.0) => {
            checker.refuse(&path, "an angle > 0 deg, at most 80");
            return None;
        }
        Some(_) if polar.aspect_ratio.is_none() => {
            checker.refuse(&path, "this key only with aspect_ratio");
            return None;
        }
        _ => {}
    }
    match polar.aspect_ratio {
        Some(_) if is_full_circle(&rows) => {
            checker.refuse(
                &["polar", name, "aspect_ratio"],
                "this key only with rows that end at stall: these go from -180 to 180 deg",
            );
            None
        }
        Some(ratio) => match match polar.pressure_shift_deg {
            Some(shift_deg) => extend_both(&rows, drag_across(ratio), shift_deg.to_radians()),
            None => extend(&rows, drag_across(ratio)),
        } {
            Ok(polar) => Some(polar),
            Err(reason) => {
                checker.refuse_as(
                    &["polar", name, "rows"],
                    reason.to_string(),
                    "rows from at least -90 deg to stall, or from -180 to 180 deg",
                );
                None
            }
        },
        None if is_full_circle(&rows) => Some(Polar { rows }),
        None => {
            let found = format!(
                "a polar from {} to {} deg",
                rows[0].angle_rad.to_degrees(),
                rows[rows.len() - 1].angle_rad.to_degrees()
            );
            let allowed = "rows from -180 to 180 deg: the flow at a blade can come from any side; or aspect_ratio, which extends them beyond stall";
            checker.refuse_as(&["polar", name, "rows"], found, allowed);
            None
        }
    }
}

fn unit(path: &[&str], vector: [f64; 3], checker: &mut Checker) -> Option<Vector3<f64>> {
    let unit = Vector3::from(vector).try_normalize(0.0).filter(|unit| unit.norm() > 0.5);
    if unit.is_none() {
        checker.refuse(path, "an array of 3 finite numbers, not all 0");
    }
    unit
}

fn build_tower(tower: &TowerFile, checker: &mut Checker) -> Option<Tower> {
    let rows = &tower.rows;
    let fine = rows.windows(2).all(|pair| pair[0][0] < pair[1][0])
        && rows.iter().all(|[height_m, diameter_m, drag]| height_m.is_finite() && *diameter_m > 0.0 && *drag >= 0.0)
        && rows.iter().flatten().all(|value| value.is_finite());
    if !fine {
        let allowed =
            "rows [height above the foot in m, diameter in m > 0, drag coefficient >= 0] with ascending heights";
        checker.refuse(&["tower", "rows"], allowed);
        return None;
    }
    Some(Tower {
        base_m: Vector3::from(tower.base_m),
        up: unit(&["tower", "up"], tower.up, checker)?,
        rows: rows.clone(),
        potential: match tower.potential {
            PotentialFile::None => Potential::None,
            PotentialFile::Cylinder => Potential::Cylinder,
            PotentialFile::Bak => Potential::Bak,
        },
        shadow: match tower.shadow {
            ShadowFile::None => Shadow::None,
            ShadowFile::Powles => Shadow::Powles,
        },
    })
}

/// The first key for Bladed fields that is stated, if any.
fn of_bladed(wind: &WindFile) -> Option<&'static str> {
    let stated =
        [("field_centre_height_m", wind.field_centre_height_m.is_some()), ("field_from", wind.field_from.is_some())];
    stated.into_iter().find_map(|(key, stated)| stated.then_some(key))
}

fn field(wind: &WindFile, air: &AirFile, checker: &mut Checker) -> Option<WindField> {
    let up = unit(&["wind", "up"], wind.up, checker)?;
    let direction = unit(&["wind", "downwind"], wind.downwind.unwrap_or(air.wind_m_s), checker)?;
    let Some(downwind) = (direction - up * direction.dot(&up)).try_normalize(1e-6) else {
        checker.refuse(&["wind", "downwind"], "a direction that is not upward");
        return None;
    };
    let files = [
        ("table_file", "table", wind.table_file.is_some(), wind.table.is_some()),
        ("field_file", "field", wind.field_file.is_some(), wind.field.is_some()),
    ];
    if let Some((key, becomes, _, twice)) = files.into_iter().find(|(_, _, stated, _)| *stated) {
        let allowed = match twice {
            true => format!("either {key} or {becomes}, not both"),
            false => {
                format!(
                    "a file name, if the model itself is read from a file; a model given as text must have {becomes}"
                )
            }
        };
        checker.refuse(&["wind", key], allowed);
        return None;
    }
    let stated: Vec<&str> = [
        ("shear_exponent", wind.shear_exponent.is_some()),
        ("roughness_m", wind.roughness_m.is_some()),
        ("table", wind.table.is_some()),
        ("turbulence", wind.turbulence.is_some()),
        ("field", wind.field.is_some()),
    ]
    .into_iter()
    .filter_map(|(key, stated)| stated.then_some(key))
    .collect();
    let both = stated == ["shear_exponent", "turbulence"]; // the exponent is then that of the mean wind profile in the turbulence box
    if stated.len() > 1 && !both {
        let allowed = "only one of shear_exponent, roughness_m, table, field and turbulence, except that turbulence \
                       may have a shear_exponent";
        checker.refuse(&["wind", stated[1]], allowed);
        return None;
    }
    if wind.reference_length_m.is_some() != wind.table.is_some() {
        let allowed = "a finite length > 0 m together with table; this key only with table";
        checker.refuse(&["wind", "reference_length_m"], allowed);
        return None;
    }
    if wind.field.is_none()
        && let Some(key) = of_bladed(wind)
    {
        checker.refuse(&["wind", key], "this key only with a wind field of Bladed in field_file or field");
        return None;
    }
    let source = if let Some(asked) = &wind.turbulence {
        let turbulence = Turbulence {
            seed: asked.seed,
            mean_m_s: asked.mean_m_s,
            power_exponent: wind.shear_exponent.unwrap_or(0.0),
            standard_deviation_m_s: asked.standard_deviation_m_s,
            reference_height_m: wind.reference_height_m,
            points: asked.points,
            spacing_m: asked.spacing_m,
            planes: asked.planes,
            plane_interval_s: asked.plane_interval_s,
        };
        match turbulence.generate() {
            Ok(grid) => Source::Box(Box::new(grid)),
            Err(reason) => {
                checker.refuse_as(&["wind", "turbulence"], reason.to_string(), "values within their ranges");
                return None;
            }
        }
    } else if let Some(field) = &wind.field {
        let settings = BladedSettings {
            middle_height_m: wind.field_centre_height_m.unwrap_or(wind.reference_height_m),
            from_port: wind.field_from != Some(SideFile::Starboard),
        };
        let bytes = base64::decoded(field);
        if !bytes.as_deref().is_some_and(is_bladed)
            && let Some(key) = of_bladed(wind)
        {
            checker.refuse(
                &["wind", key],
                "this key only with a wind field of Bladed (.wnd); a field of TurbSim \
                                            contains this value",
            );
            return None;
        }
        match bytes.map(|bytes| read_field(&bytes, settings)) {
            Some(Ok(grid)) => Source::Box(Box::new(grid)),
            Some(Err(fault)) => {
                checker.refuse_as(
                    &["wind", "field"],
                    fault.to_string(),
                    "the contents of a complete file of TurbSim (.bts) or Bladed (.wnd)",
                );
                return None;
            }
            None => {
                checker.refuse(
                    &["wind", "field"],
                    "a file of TurbSim or Bladed in base64; to name the file itself use field_file",
                );
                return None;
            }
        }
    } else if let Some(rows) = &wind.table {
        if !rows.windows(2).all(|pair| pair[0][0] < pair[1][0]) || !rows.iter().flatten().all(|value| value.is_finite())
        {
            checker.refuse(&["wind", "table"], "rows of 8 finite numbers with ascending times");
            return None;
        }
        let row = |row: &[f64; 8]| TableRow {
            time_s: row[0],
            speed_m_s: row[1],
            direction_rad: row[2].to_radians(),
            vertical_m_s: row[3],
            horizontal_shear: row[4],
            power_exponent: row[5],
            vertical_shear: row[6],
            gust_m_s: row[7],
        };
        let rows = rows.iter().map(row).collect();
        Source::Table(WindTable { reference_length_m: wind.reference_length_m.unwrap_or(1.0), rows })
    } else {
        Source::Steady(match (wind.shear_exponent, wind.roughness_m) {
            (Some(exponent), _) => Shear::Power { exponent },
            (None, Some(roughness_m)) if roughness_m < wind.reference_height_m => Shear::Logarithmic { roughness_m },
            (None, Some(_)) => {
                checker.refuse(&["wind", "roughness_m"], "a length > 0 m below reference_height_m");
                return None;
            }
            (None, None) => Shear::None,
        })
    };
    Some(WindField {
        source,
        ground_m: Vector3::from(wind.ground_m),
        up,
        downwind,
        reference_height_m: wind.reference_height_m,
    })
}

//! Computation of all points of the lists in succession.

use crate::operating_points::error::{List, PointsError};
use crate::operating_points::found::{OperatingPoints, Point, State, Statistics};
use crate::operating_points::options::{Options, Search, Unknown};
use crate::operating_points::point::{Found, Rotor};
use crate::operating_points::search::Searcher;
use crate::watch::{Watch, unwatched};
use foldwing_engine::machine::Machine;
use std::sync::Arc;

/// Maximum number of points: a larger grid is probably unintended.
pub const MAXIMUM_POINTS: usize = 100_000;

/// Computes operating points of a rotor over wind, speed and pitch.
///
/// Each is the steady state in the rotating frame or, with tilt, gravity or shear, the motion that repeats every revolution, at
/// constant shaft speed. A point for which no state is found contains the error; the others are computed.
///
/// # Errors
/// Lists and ranges that are not allowed, models without aerodynamics, wind or shaft, unknown names, and the error of the first point
/// if none has a state.
pub fn tabulate(machine: impl Into<Arc<Machine>>, options: &Options) -> Result<OperatingPoints, PointsError> {
    tabulate_watched(machine, options, &mut unwatched)
}

/// [`tabulate`] with `watch` called after each point, and after each state that a search computes for one.
///
/// # Errors
/// Those of [`tabulate`], and [`PointsError::Stopped`].
pub fn tabulate_watched(
    machine: impl Into<Arc<Machine>>,
    options: &Options,
    watch: &mut Watch<'_>,
) -> Result<OperatingPoints, PointsError> {
    let combinations = combinations(options)?;
    if !(options.tolerance > 0.0 && options.tolerance < 1.0) {
        return Err(PointsError::Tolerance { tolerance: options.tolerance });
    }
    if let Some(search) = &options.search {
        check_search(search, options)?;
    }
    let mut rotor = Rotor::new(machine.into(), options, watch)?;
    rotor.progress.total = Some(combinations.len());
    let mut searcher = options.search.as_ref().map(Searcher::new);
    let mut points = Vec::with_capacity(combinations.len());
    for [wind_m_s, speed_rpm, pitch_deg] in combinations {
        let wind_m_s = wind_m_s.unwrap_or(0.0);
        let speed_rpm = match options.tip_speed_ratio {
            Some(ratio) => Some(rotor.speed_rpm(ratio, wind_m_s, speed_rpm)?),
            None => speed_rpm,
        };
        let at = [wind_m_s, speed_rpm.unwrap_or(f64::NAN), pitch_deg.unwrap_or(f64::NAN)];
        let tolerance = rotor.tolerance;
        let found = match &mut searcher {
            Some(searcher) => searcher.find(&mut rotor, at).map(|(found, held)| (found, Some(held))),
            None => rotor.state(at, tolerance).map(|found| (found, None)),
        };
        points.push(match found {
            Ok((found, held)) => point_of(wind_m_s, found, held),
            Err(PointsError::Point(error)) => {
                let [wind_m_s, speed_rpm, pitch_deg] = at;
                Point { wind_m_s, speed_rpm, pitch_deg, state: Err(error) }
            }
            Err(other) => return Err(other),
        });
        rotor.progress.done = points.len();
        rotor.report()?;
    }
    if points.iter().all(|point| point.state.is_err())
        && let Some(Err(error)) = points.first().map(|point| &point.state)
    {
        return Err(error.clone().into());
    }
    Ok(OperatingPoints { machine: rotor.name().to_owned(), blade: rotor.blade(), outputs: rotor.outputs(), points })
}

fn point_of(wind_m_s: f64, found: Found, held: Option<bool>) -> Point {
    let Found { speed_rpm, pitch_deg, is_periodic, values, .. } = found;
    let outputs = values.into_iter().map(|[mean, peak_to_peak]| Statistics { mean, peak_to_peak }).collect();
    Point { wind_m_s, speed_rpm, pitch_deg, state: Ok(State { is_periodic, held, outputs }) }
}

fn check_search(search: &Search, options: &Options) -> Result<(), PointsError> {
    let unknown = search.unknown;
    let [from, to] = unknown.range();
    if !(from.is_finite() && to.is_finite()) || from == to {
        return Err(PointsError::Range { unknown });
    }
    let given = match unknown {
        Unknown::PitchDeg { .. } => options.pitch_deg.is_some(),
        Unknown::SpeedRpm { .. } => options.speed_rpm.is_some() || options.tip_speed_ratio.is_some(),
    };
    if given {
        return Err(PointsError::SoughtAndGiven { unknown });
    }
    if !search.target.value.is_finite() {
        return Err(PointsError::TargetNotFinite { target: search.target.clone() });
    }
    Ok(())
}

/// Wind, speed and pitch of every point; `None` selects the value of the model.
fn combinations(options: &Options) -> Result<Vec<[Option<f64>; 3]>, PointsError> {
    let own = |list: &Option<Vec<f64>>| -> Vec<Option<f64>> {
        list.as_ref().map_or(vec![None], |list| list.iter().map(|value| Some(*value)).collect())
    };
    let lists = [own(&Some(options.wind_m_s.clone())), own(&options.speed_rpm), own(&options.pitch_deg)];
    let names = [List::WindMS, List::SpeedRpm, List::PitchDeg];
    for (&name, list) in names.iter().zip(&lists) {
        if list.is_empty() {
            return Err(PointsError::Empty { list: name });
        }
        if let Some(&value) = list.iter().flatten().find(|value| !value.is_finite()) {
            return Err(PointsError::NotFinite { list: name, value });
        }
    }
    if let Some(&value) = options.wind_m_s.iter().find(|value| **value < 0.0) {
        return Err(PointsError::NegativeWind { value });
    }
    if let Some(ratio) = options.tip_speed_ratio {
        if !(ratio.is_finite() && ratio > 0.0) {
            return Err(PointsError::TipSpeedRatio { ratio });
        }
        if lists[1].len() > 1 {
            return Err(PointsError::SeveralSpeeds);
        }
    }
    let longest = lists.iter().map(Vec::len).max().unwrap_or(1);
    let count = if options.paired { longest } else { lists.iter().map(Vec::len).fold(1, usize::saturating_mul) };
    if count > MAXIMUM_POINTS {
        return Err(PointsError::TooMany { count, most: MAXIMUM_POINTS });
    }
    if !options.paired {
        let [wind, speed, pitch] = &lists;
        let of = |w: &Option<f64>| -> Vec<[Option<f64>; 3]> {
            speed.iter().flat_map(|s| pitch.iter().map(|p| [*w, *s, *p])).collect()
        };
        return Ok(wind.iter().flat_map(of).collect());
    }
    if let Some((&name, list)) = names.iter().zip(&lists).find(|(_, list)| ![1, longest].contains(&list.len())) {
        return Err(PointsError::Unpaired { list: name, count: list.len(), longest });
    }
    Ok((0..longest).map(|i| std::array::from_fn(|k| lists[k][i.min(lists[k].len() - 1)])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::values::Target;

    /// Lists are combined value by value or in all combinations, with pitch varying fastest; values not given are those of the model.
    #[test]
    fn lists_are_combined() {
        let options = |paired: bool, wind_m_s: &[f64], speed_rpm: Option<&[f64]>, pitch_deg: Option<&[f64]>| Options {
            wind_m_s: wind_m_s.to_vec(),
            speed_rpm: speed_rpm.map(<[f64]>::to_vec),
            pitch_deg: pitch_deg.map(<[f64]>::to_vec),
            paired,
            ..Options::default()
        };
        let all = combinations(&options(false, &[8.0, 9.0], None, Some(&[0.0, 1.0])));
        let expected = [[8.0, 0.0], [8.0, 1.0], [9.0, 0.0], [9.0, 1.0]];
        assert_eq!(all, Ok(expected.map(|[wind, pitch]| [Some(wind), None, Some(pitch)]).to_vec()));
        let pairs = combinations(&options(true, &[8.0, 9.0], Some(&[12.0]), Some(&[0.0, 1.0])));
        assert_eq!(pairs, Ok(vec![[Some(8.0), Some(12.0), Some(0.0)], [Some(9.0), Some(12.0), Some(1.0)]]));
        let unpaired = combinations(&options(true, &[8.0, 9.0, 10.0], None, Some(&[0.0, 1.0])));
        assert_eq!(unpaired, Err(PointsError::Unpaired { list: List::PitchDeg, count: 2, longest: 3 }));
        assert_eq!(combinations(&options(false, &[], None, None)), Err(PointsError::Empty { list: List::WindMS }));
        assert_eq!(combinations(&options(false, &[-1.0], None, None)), Err(PointsError::NegativeWind { value: -1.0 }));
        let speeds = vec![1.0; MAXIMUM_POINTS + 1];
        let many = combinations(&options(false, &[8.0], Some(&speeds), None));
        assert_eq!(many, Err(PointsError::TooMany { count: MAXIMUM_POINTS + 1, most: MAXIMUM_POINTS }));
    }

    /// An unknown must have a range and a target, and must not be given as well.
    #[test]
    fn searches_are_checked() {
        let search = |from: f64, to: f64, value: f64| Search {
            unknown: Unknown::PitchDeg { from, to },
            target: Target { output: "rotor.power".to_owned(), value },
        };
        let options = Options { speed_rpm: Some(vec![12.0]), ..Options::default() };
        assert_eq!(check_search(&search(0.0, 40.0, 5e6), &options), Ok(()));
        let same = search(1.0, 1.0, 5e6);
        assert_eq!(check_search(&same, &options), Err(PointsError::Range { unknown: same.unknown }));
        let endless = search(0.0, 40.0, f64::INFINITY);
        let error = PointsError::TargetNotFinite { target: endless.target.clone() };
        assert_eq!(check_search(&endless, &options), Err(error));
        let given = Options { pitch_deg: Some(vec![0.0]), ..options };
        let sought = search(0.0, 40.0, 5e6);
        assert_eq!(check_search(&sought, &given), Err(PointsError::SoughtAndGiven { unknown: sought.unknown }));
    }
}

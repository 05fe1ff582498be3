//! Path of equilibria under an increasing load, followed by arc length through limit points.
//!
//! The unknowns are the coordinates and the load factor; a step along the tangent of the path is corrected perpendicularly to it (Riks,
//! Int. J. Solids Struct. 15, 1979). NOTATION eq. (L17).

use crate::solve::equilibrium::{Cause, Effort, NoEquilibrium, Settings, StaticEquations, iterate};

/// One equilibrium on the path.
#[derive(Debug, Clone, PartialEq)]
pub struct PathPoint {
    /// Load factor.
    pub factor: f64,
    /// Number of directions in which the tangent stiffness is negative there.
    pub negative_directions: usize,
    /// Coordinates.
    pub q: Vec<f64>,
}

/// Maximum number of points of the path.
const MAXIMUM_POINTS: usize = 4000;

/// First and largest step: rotations in rad and load factor combined.
const LONGEST_STEP: f64 = 0.05;

/// Smallest step.
const SHORTEST_STEP: f64 = 1e-7;

/// Maximum number of corrections per point, and the number below which the next step is longer.
const MAXIMUM_CORRECTIONS: usize = 10;
const FEW_CORRECTIONS: usize = 4;

/// Change of the load factor for the difference quotient of the loads, which are linear in it.
const FACTOR_CHANGE: f64 = 1e-2;

/// A tangent to the path, of unit length.
struct Direction {
    q: Vec<f64>,
    factor: f64,
}

/// Follows the path from `q` at zero load until the load factor reaches 1 for the first time. After success `q` holds that equilibrium and
/// the equations are evaluated there; after failure `q` holds the last equilibrium found.
pub fn trace(
    equations: &mut impl StaticEquations,
    q: &mut [f64],
    settings: Settings,
) -> Result<(Effort, Vec<PathPoint>), NoEquilibrium> {
    let mut effort = Effort::default();
    let failed = |reached: f64, cause: Cause| NoEquilibrium { reached, tried: 1.0, cause };
    equations.load(0.0);
    iterate(equations, q, settings, &mut effort).map_err(|cause| failed(0.0, cause))?;
    let (mut factor, mut step) = (0.0, LONGEST_STEP);
    let mut points: Vec<PathPoint> = Vec::new();
    let mut before: Option<Direction> = None;
    while points.len() < MAXIMUM_POINTS {
        let (direction, negative_directions) =
            tangent(equations, q, factor, before.as_ref()).map_err(|cause| failed(factor, cause))?;
        points.push(PathPoint { factor, negative_directions, q: q.to_vec() });
        if factor == 1.0 {
            let mut scratch = vec![0.0; q.len()];
            equations.residual(q, &mut scratch);
            return Ok((effort, points));
        }
        loop {
            let mut trial = q.to_vec();
            match advance(equations, &mut trial, factor, (&direction, step), settings, &mut effort) {
                Ok((reached, corrections)) => {
                    effort.load_steps += 1;
                    q.copy_from_slice(&trial);
                    factor = reached;
                    if corrections <= FEW_CORRECTIONS {
                        step = (1.5 * step).min(LONGEST_STEP);
                    }
                    break;
                }
                Err(cause) => {
                    effort.halvings += 1;
                    step *= 0.5;
                    if step < SHORTEST_STEP {
                        return Err(failed(factor, cause));
                    }
                }
            }
        }
        before = Some(direction);
    }
    Err(failed(factor, Cause::PathTooLong(MAXIMUM_POINTS)))
}

/// Unit tangent at an equilibrium, in the direction of progress, and the number of negative directions there.
fn tangent(
    equations: &mut impl StaticEquations,
    q: &[f64],
    factor: f64,
    before: Option<&Direction>,
) -> Result<(Direction, usize), Cause> {
    let mut along = load_rate(equations, q, factor);
    let negative = equations.factorize(q, 0.0).map_err(|singular| Cause::Singular(singular.coordinate))?;
    equations.solve(&mut along);
    along.iter_mut().for_each(|x| *x = -*x);
    let length = (equations.product(&along, &along) + 1.0).sqrt();
    let onward = before.map_or(1.0, |before| equations.product(&before.q, &along) + before.factor);
    let scale = if onward < 0.0 { -1.0 } else { 1.0 } / length;
    along.iter_mut().for_each(|x| *x *= scale);
    Ok((Direction { q: along, factor: scale }, negative))
}

/// Derivative of the residual with respect to the load factor at `q`. The equations are evaluated at `factor` and `q` afterwards.
fn load_rate(equations: &mut impl StaticEquations, q: &[f64], factor: f64) -> Vec<f64> {
    let (mut more, mut here) = (vec![0.0; q.len()], vec![0.0; q.len()]);
    equations.load(factor + FACTOR_CHANGE);
    equations.residual(q, &mut more);
    equations.load(factor);
    equations.residual(q, &mut here);
    more.iter_mut().zip(&here).for_each(|(more, here)| *more = (*more - here) / FACTOR_CHANGE);
    more
}

/// Performs one step: a prediction, and corrections in the plane perpendicular to it. Returns the load factor and the number of
/// corrections.
fn advance(
    equations: &mut impl StaticEquations,
    q: &mut [f64],
    from: f64,
    (direction, step): (&Direction, f64),
    settings: Settings,
    effort: &mut Effort,
) -> Result<(f64, usize), Cause> {
    let mut factor = from + step * direction.factor;
    let last = factor >= 1.0;
    // the last point is at the full load: Newton's iteration from the predicted point
    let step = if last { (1.0 - from) / direction.factor } else { step };
    q.iter_mut().zip(&direction.q).for_each(|(q, along)| *q += step * along);
    equations.project(q);
    if last {
        equations.load(1.0);
        iterate(equations, q, settings, effort)?;
        return Ok((1.0, 0));
    }
    let mut moved = 0.0;
    for correction in 1..=MAXIMUM_CORRECTIONS {
        effort.iterations += 1;
        let mut along = load_rate(equations, q, factor);
        let mut change = vec![0.0; q.len()];
        equations.residual(q, &mut change);
        equations.factorize(q, 0.0).map_err(|singular| Cause::Singular(singular.coordinate))?;
        equations.solve(&mut change);
        equations.solve(&mut along);
        let more =
            equations.product(&direction.q, &change) / (direction.factor - equations.product(&direction.q, &along));
        change.iter_mut().zip(&along).for_each(|(change, along)| *change += more * along);
        let size = equations.norm(&change);
        if !(size.is_finite() && more.is_finite()) {
            return Err(Cause::NotFinite(correction));
        }
        moved += equations.product(&change, &change).sqrt() + more.abs();
        // corrections that add up to more than the step lead to another branch
        if moved > step {
            return Err(Cause::NotConverged { iterations: correction, correction: size });
        }
        q.iter_mut().zip(&change).for_each(|(q, change)| *q -= change);
        equations.project(q);
        factor += more;
        equations.load(factor);
        if size <= settings.tolerance && more.abs() <= settings.tolerance {
            return Ok((factor, correction));
        }
    }
    Err(Cause::NotConverged { iterations: MAXIMUM_CORRECTIONS, correction: moved })
}

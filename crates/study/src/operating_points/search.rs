//! The search for the pitch or the speed at which an output has its target, NOTATION eq. (L41).

use crate::operating_points::error::{PointError, PointsError};
use crate::operating_points::options::Search;
use crate::operating_points::point::{Found, Rotor};

/// Number of steps by which a range is searched from its start.
const PARTS: f64 = 30.0;
/// Distance of the output from its target, relative to the target, below which the target is met.
const HELD: f64 = 1e-6;
/// Width of the bracket of the unknown, relative to its range, below which the search ends: an output that jumps there gets no closer to
/// its target.
const NARROW: f64 = 1e-9;
/// Largest difference between the ends of a revolution at which the mean may decide on which side of the target the output is.
const ROUGH: f64 = 1e-2;
/// Distance of the output from its target, relative to the target and to the difference between the ends of the revolution, from which on
/// the side is certain: a revolution that ends 1e-2 rad from its beginning has a mean with a relative error of about 1e-2.
const CERTAIN: f64 = 5.0;
/// Smallest factor by which the periodicity tolerance is refined at once while the sign is not certain.
const FINER: f64 = 1e-3;
/// Expected ratio of the residual after a step inside the bracket to the smaller residual at its ends.
const NEARER: f64 = 0.02;
/// Maximum extrapolation of the periodic state from the last two values of the unknown, relative to their distance.
const FARTHEST: f64 = 2.0;
/// Maximum number of steps inside the bracket.
const MAXIMUM_STEPS: usize = 60;

/// A search from point to point.
pub struct Searcher<'a> {
    search: &'a Search,
    /// The last value found.
    last: Option<f64>,
    /// The last two values of the unknown at which a motion was found in the current search.
    tried: Option<[f64; 2]>,
}

impl<'a> Searcher<'a> {
    /// A search at its start.
    pub fn new(search: &'a Search) -> Self {
        Self { search, last: None, tried: None }
    }

    /// Finds the state at which the output crosses its target downwards within the range, starting at the last value found or else at the
    /// start of the range; also returns whether the target is met. If the output is below the target at the start, the start is kept.
    pub fn find(&mut self, rotor: &mut Rotor<'_>, at: [f64; 3]) -> Result<(Found, bool), PointsError> {
        let last = self.last;
        // a discontinuous output has no solution; a sign error from a coarse periodicity tolerance is excluded by a search with the full
        // one
        if let Some(found) = self.searched(rotor, at, false)? {
            return Ok(found);
        }
        self.last = last;
        let target = &self.search.target;
        let error = PointError::NotHeld { output: target.output.clone(), target: target.value };
        self.searched(rotor, at, true)?.ok_or_else(|| error.into())
    }

    /// Reference magnitude of the target.
    fn size(&self) -> f64 {
        let value = self.search.target.value;
        if value == 0.0 { 1.0 } else { value.abs() }
    }

    /// Distance of the output from its target at a value of the unknown. The periodicity tolerance is the largest at which the sign of
    /// this distance is certain, first assuming a distance of `near`; if the output may meet its target, it is the tolerance of the
    /// points.
    fn off(
        &mut self,
        rotor: &mut Rotor<'_>,
        mut at: [f64; 3],
        value: f64,
        near: f64,
    ) -> Result<(f64, Found), PointsError> {
        at[if self.search.unknown.is_pitch() { 2 } else { 1 }] = value;
        let size = self.size();
        // the periodic state is extrapolated linearly, like the unknown
        if let (Some(nearby), Some([before, last])) = (&mut rotor.nearby, self.tried)
            && last != before
            && (value - last).abs() <= FARTHEST * (last - before).abs()
        {
            nearby.go_on((value - last) / (last - before));
        }
        self.tried = Some([self.tried.map_or(value, |[_, last]| last), value]);
        let mut tolerance = (near / (CERTAIN * size)).min(ROUGH).max(rotor.tolerance);
        loop {
            let mut found = rotor.state(at, tolerance)?;
            let [mean, _] = found.values.pop().unwrap_or([f64::NAN; 2]);
            let off = mean - self.search.target.value;
            if found.tolerance <= rotor.tolerance || off.abs() > CERTAIN * tolerance * size {
                return Ok((off, found));
            }
            // the tolerance at which the sign of this residual would be certain
            tolerance =
                (0.5 * off.abs() / (CERTAIN * size)).clamp(FINER * tolerance, 0.5 * tolerance).max(rotor.tolerance);
        }
    }

    /// The search, with the full periodicity tolerance everywhere if `whole`; `None` if its failure may have a cause other than a
    /// discontinuity of the output.
    fn searched(
        &mut self,
        rotor: &mut Rotor<'_>,
        at: [f64; 3],
        whole: bool,
    ) -> Result<Option<(Found, bool)>, PointsError> {
        self.tried = None;
        let size = self.size();
        let held = |off: f64| off.abs() <= HELD * size;
        let [from, to] = self.search.unknown.range();
        let far = if whole { 0.0 } else { f64::INFINITY };
        let (mut above, first) = self.off(rotor, at, from, far)?;
        // NaN cannot meet the target
        if above.is_nan() || above <= 0.0 || held(above) {
            let (off, closed) = match first.tolerance <= rotor.tolerance {
                true => (above, first),
                false => self.off(rotor, at, from, 0.0)?,
            };
            return Ok(Some((closed, held(off))));
        }
        let part = (to - from) / PARTS;
        let mut high = from;
        let mut low: Option<(f64, f64, Found)> = None;
        // from the last solution back in growing steps, at most to the start
        if let Some(last) = self.last {
            let (off, found) = self.off(rotor, at, last, far)?;
            if off > 0.0 {
                (high, above) = (last, off);
            } else {
                let (mut nearest, mut stride) = ((last, off, found), part);
                while (nearest.0 - stride - from) * part.signum() > 0.0 {
                    let back = nearest.0 - stride;
                    let (off, found) = self.off(rotor, at, back, far)?;
                    if off > 0.0 {
                        (high, above) = (back, off);
                        break;
                    }
                    (nearest, stride) = ((back, off, found), 2.0 * stride);
                }
                low = Some(nearest);
            }
        }
        while low.is_none() {
            let on = high + part;
            let next = if (on - to) * part.signum() >= -1e-9 * part.abs() { to } else { on };
            let (off, found) = self.off(rotor, at, next, far)?;
            if off <= 0.0 {
                low = Some((next, off, found));
            } else if next == to || off.is_nan() {
                let target = &self.search.target;
                let (output, target) = (target.output.clone(), target.value);
                return Err(PointError::AboveTarget { output, target, from, to, excess: off }.into());
            } else {
                (high, above) = (next, off);
            }
        }
        let Some((mut end, mut below, mut found)) = low else { return Ok(Some((first, false))) };
        let mut side = 0i32;
        for _ in 0..MAXIMUM_STEPS {
            if held(below) || (end - high).abs() <= NARROW * (to - from).abs() {
                break;
            }
            // Illinois rule: the residual at an end that is kept twice is halved
            let middle = (high * below - end * above) / (below - above);
            let (off, at_middle) = self.off(rotor, at, middle, far.min(NEARER * above.min(-below)))?;
            if held(off) {
                (end, below, found) = (middle, off, at_middle);
            } else if off > 0.0 {
                (high, above) = (middle, off);
                if side == 1 {
                    below *= 0.5;
                }
                side = 1;
            } else {
                (end, below, found) = (middle, off, at_middle);
                if side == -1 {
                    above *= 0.5;
                }
                side = -1;
            }
        }
        if !held(below) && !whole {
            return Ok(None);
        }
        self.last = Some(end);
        Ok(Some((found, true)))
    }
}

//! Mode tracking over a parameter, NOTATION eq. (L24): matching of modes from one value to the next, and onset of growth.

use crate::solve::modes;
use nalgebra::{Complex, DMatrix, DVector};

/// A mode that can be tracked.
pub trait Followed {
    /// Eigenvalue in 1/s.
    fn eigenvalue_1_s(&self) -> Complex<f64>;

    /// Similarity of the shapes, from 0 to 1: the modal assurance criterion, or 1 if the shapes cannot be compared.
    fn likeness(&self, other: &Self) -> f64;

    /// Inner product `aᴴb` of the shapes; `None` if they cannot be compared.
    fn product(&self, other: &Self) -> Option<Complex<f64>>;
}

/// Modes farther apart than this are never matched.
const STRANGERS: f64 = 0.9;
/// Distance above which the interval between two values is halved to resolve the matching.
const AMBIGUOUS: f64 = 0.25;
/// Relative difference of two eigenvalues up to which any combination of their shapes counts as a mode: rounded angles of a model file
/// separate modes of equal blades by 1e-7.
const EQUAL: f64 = 1e-6;
/// Maximum number of halvings of one interval.
const MAXIMUM_HALVINGS: u32 = 4;
/// Width of the interval that contains a zero of the growth rate, relative to that of the sweep.
const NARROW: f64 = 1e-10;
/// Maximum number of steps towards a zero.
const MAXIMUM_STEPS: usize = 60;

/// Modes at one value; each branch has one mode, or none if it was not found.
#[derive(Debug, Clone, PartialEq)]
pub struct Place<M> {
    /// Value of the parameter.
    pub at: f64,
    /// Mode of each branch.
    pub modes: Vec<Option<M>>,
}

/// Value at which a branch starts or ceases to grow.
#[derive(Debug, Clone, PartialEq)]
pub struct Crossing<M> {
    /// Index of the branch.
    pub branch: usize,
    /// Value of the parameter.
    pub at: f64,
    /// The mode at that value.
    pub mode: M,
    /// Whether the mode grows beyond this value; otherwise it grows before it.
    pub begins: bool,
}

/// Whether a mode grows by more than the round-off of an undamped mode.
fn grows<M: Followed>(mode: &M) -> bool {
    modes::grows(mode.eigenvalue_1_s())
}

/// Distance of two eigenvalues divided by their mean magnitude.
fn apart(a: Complex<f64>, b: Complex<f64>) -> f64 {
    let size = 0.5 * (a.norm() + b.norm());
    if size > 0.0 { (a - b).norm() / size } else { 0.0 }
}

/// Distance of a mode from the predicted continuation of a branch, from eigenvalue and shape. Real and oscillating modes are far apart
/// unless their eigenvalues are close.
fn distance<M: Followed>(branch: &M, expected: Complex<f64>, mode: &M) -> f64 {
    apart(mode.eigenvalue_1_s(), expected) + (1.0 - branch.likeness(mode))
}

/// For each mode, all modes with its eigenvalue, including itself.
fn equals<'m, M: Followed>(modes: &[&'m M]) -> Vec<Vec<&'m M>> {
    let same = |mode: &M| {
        let value = mode.eigenvalue_1_s();
        modes.iter().copied().filter(|other| apart(value, other.eigenvalue_1_s()) <= EQUAL).collect()
    };
    modes.iter().map(|mode| same(mode)).collect()
}

/// Similarity of a mode to the closest combination of several shapes with one eigenvalue, all of which are modes.
fn likeness_to_all<M: Followed>(mode: &M, all: &[&M]) -> f64 {
    let single = all.iter().map(|other| other.likeness(mode)).fold(0.0, f64::max);
    if all.len() < 2 {
        return single;
    }
    let product = |a: &M, b: &M| a.product(b).filter(|value| value.is_finite());
    let combined = || {
        let n = all.len();
        let mut gram = DMatrix::<Complex<f64>>::zeros(n, n);
        let mut right = DVector::<Complex<f64>>::zeros(n);
        for i in 0..n {
            right[i] = product(all[i], mode)?;
            for j in 0..n {
                gram[(i, j)] = product(all[i], all[j])?;
            }
        }
        let amounts = gram.cholesky()?.solve(&right);
        Some(right.dotc(&amounts).re / product(mode, mode)?.re)
    };
    combined().map_or(single, |share| share.min(1.0).max(single))
}

/// Matches a mode to each branch, closest pairs first, and returns the largest distance of these pairs. If several modes have one
/// eigenvalue, on either side, any combination of them is a mode, as for the blades of a parked rotor: if no single shape matches, a shape
/// in their common space is sufficient.
fn pairs<M: Followed>(branches: &[Option<(&M, Complex<f64>)>], modes: &[M]) -> (Vec<Option<usize>>, f64) {
    let known: Vec<(usize, &M, Complex<f64>)> = (branches.iter().enumerate())
        .filter_map(|(i, branch)| branch.map(|(last, expected)| (i, last, expected)))
        .collect();
    let lasts: Vec<&M> = known.iter().map(|(_, last, _)| *last).collect();
    let found: Vec<&M> = modes.iter().collect();
    let (equal_lasts, equal_found) = (equals(&lasts), equals(&found));
    // order, distance, branch, mode
    let mut list: Vec<(f64, f64, usize, usize)> = Vec::new();
    for ((i, last, expected), before) in known.iter().zip(&equal_lasts) {
        for ((j, mode), beside) in modes.iter().enumerate().zip(&equal_found) {
            let own = distance(*last, *expected, mode);
            let likeness = likeness_to_all(mode, before).max(likeness_to_all(*last, beside));
            let of_all = apart(mode.eigenvalue_1_s(), *expected) + (1.0 - likeness);
            if own.min(of_all) < STRANGERS {
                list.push((own.min(of_all + AMBIGUOUS), own.min(of_all), *i, j));
            }
        }
    }
    list.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut taken, mut of) = (vec![false; modes.len()], vec![None; branches.len()]);
    let mut worst = 0.0f64;
    for (_, distance, i, j) in list {
        if of[i].is_none() && !taken[j] {
            (of[i], taken[j]) = (Some(j), true);
            worst = worst.max(distance);
        }
    }
    (of, worst)
}

/// The modes of a sweep, sorted into branches.
#[derive(Debug, Clone, PartialEq)]
pub struct Branches<M> {
    /// Values in the order of the sweep, without intermediate ones that were added to distinguish modes.
    pub places: Vec<Place<M>>,
    /// All values, including the intermediate ones.
    all: Vec<Place<M>>,
}

impl<M: Followed + Clone> Branches<M> {
    /// Tracks the modes returned by `modes_at` from value to value. Stops at the first value where `modes_at` fails, and returns the
    /// results so far, with the value and the error.
    pub fn follow<E>(places: &[f64], modes_at: &mut impl FnMut(f64) -> Result<Vec<M>, E>) -> (Self, Option<(f64, E)>) {
        let mut found = Self { places: Vec::new(), all: Vec::new() };
        for &at in places {
            let outcome = match found.all.is_empty() {
                true => modes_at(at).map(|modes| {
                    found.all.push(Place { at, modes: modes.into_iter().map(Some).collect() });
                }),
                false => found.go_on(at, modes_at, 0),
            };
            if let Err(error) = outcome {
                found.fill();
                return (found, Some((at, error)));
            }
            found.places.extend(found.all.last().cloned());
        }
        found.fill();
        (found, None)
    }

    /// Continues to a value, and halves the interval if the matching is ambiguous.
    fn go_on<E>(
        &mut self,
        at: f64,
        modes_at: &mut impl FnMut(f64) -> Result<Vec<M>, E>,
        halvings: u32,
    ) -> Result<(), E> {
        let modes = modes_at(at)?;
        let (of, worst) = pairs(&self.expected(at), &modes);
        if worst > AMBIGUOUS && halvings < MAXIMUM_HALVINGS {
            let from = self.all.last().map_or(at, |place| place.at);
            self.go_on(0.5 * (from + at), modes_at, halvings + 1)?;
            return self.go_on(at, modes_at, halvings + 1);
        }
        let mut rest: Vec<Option<M>> = modes.into_iter().map(Some).collect();
        let mut own: Vec<Option<M>> = of.iter().map(|j| j.and_then(|j| rest[j].take())).collect();
        own.extend(rest.into_iter().filter(Option::is_some));
        self.all.push(Place { at, modes: own });
        Ok(())
    }

    /// The last mode of each branch and its eigenvalue at a value, extrapolated linearly from the last two.
    fn expected(&self, at: f64) -> Vec<Option<(&M, Complex<f64>)>> {
        let count = self.all.iter().map(|place| place.modes.len()).max().unwrap_or(0);
        let of = |branch: usize| {
            let mut known =
                self.all.iter().rev().filter_map(|place| Some((place.at, place.modes.get(branch)?.as_ref()?)));
            let (last_at, last) = known.next()?;
            let value = last.eigenvalue_1_s();
            let expected = match known.next() {
                Some((before_at, before)) if before_at != last_at => {
                    value + (value - before.eigenvalue_1_s()) * ((at - last_at) / (last_at - before_at))
                }
                _ => value,
            };
            Some((last, expected))
        };
        (0..count).map(of).collect()
    }

    /// Extends all values to the same number of branches.
    fn fill(&mut self) {
        let count = self.all.iter().map(|place| place.modes.len()).max().unwrap_or(0);
        for place in self.places.iter_mut().chain(&mut self.all) {
            place.modes.resize(count, None);
        }
    }

    /// Keeps only the first `count` branches at the first value, those of `crossings`, and those that grow anywhere. More than `count`
    /// modes should be computed, because others of lower frequency may appear along the sweep.
    pub fn keep(&mut self, count: usize, crossings: &mut [Crossing<M>]) {
        let all = self.all.first().map_or(0, |place| place.modes.len());
        let ever = |branch: usize| self.all.iter().filter_map(|place| place.modes[branch].as_ref()).any(grows);
        let kept: Vec<usize> = (0..all)
            .filter(|&branch| {
                branch < count || crossings.iter().any(|crossing| crossing.branch == branch) || ever(branch)
            })
            .collect();
        for place in self.places.iter_mut().chain(&mut self.all) {
            place.modes = kept.iter().map(|&branch| place.modes[branch].take()).collect();
        }
        for crossing in crossings {
            crossing.branch = kept.iter().position(|&branch| branch == crossing.branch).unwrap_or(0);
        }
    }

    /// Modes that grow at a value but not at the previous one, where the branch is missing or does not grow: branch, the two values and the
    /// mode. Intermediate values that were added to resolve the matching are included.
    pub fn beginnings(&self) -> Vec<(usize, [f64; 2], &M)> {
        let mut list = Vec::new();
        for pair in self.all.windows(2) {
            for (branch, ends) in pair[0].modes.iter().zip(&pair[1].modes).enumerate() {
                if let (before, Some(mode)) = ends
                    && grows(mode)
                    && !before.as_ref().is_some_and(grows)
                {
                    list.push((branch, [pair[0].at, pair[1].at], mode));
                }
            }
        }
        list
    }

    /// Values at which branches start or cease to grow, in the order of the sweep, with the mode of the branch: by the false-position
    /// method (Illinois) between two values with a change of sign. If `modes_at` fails, the crossing is omitted.
    pub fn crossings<E>(&self, modes_at: &mut impl FnMut(f64) -> Result<Vec<M>, E>) -> Vec<Crossing<M>> {
        let mut list = Vec::new();
        let width = match (self.all.first(), self.all.last()) {
            (Some(first), Some(last)) => (last.at - first.at).abs(),
            _ => return list,
        };
        for pair in self.all.windows(2) {
            for (branch, ends) in pair[0].modes.iter().zip(&pair[1].modes).enumerate() {
                let (Some(low), Some(high)) = ends else { continue };
                let [before, begins] = [low, high].map(grows);
                if before == begins {
                    continue;
                }
                let ends = [(pair[0].at, low.clone()), (pair[1].at, high.clone())];
                if let Some((at, mode)) = zero(ends, begins, NARROW * width, modes_at) {
                    list.push(Crossing { branch, at, mode, begins });
                }
            }
        }
        list.sort_by(|a, b| a.at.total_cmp(&b.at));
        list
    }
}

/// Zero of the growth rate of a mode between two values; it grows at the second if `begins`, otherwise at the first.
fn zero<M: Followed + Clone, E>(
    mut ends: [(f64, M); 2],
    begins: bool,
    narrow: f64,
    modes_at: &mut impl FnMut(f64) -> Result<Vec<M>, E>,
) -> Option<(f64, M)> {
    // at the end without growth, round-off may have either sign
    let mut weights = [0, 1].map(|i| {
        let growth = ends[i].1.eigenvalue_1_s().re;
        if (i == 1) == begins { growth } else { growth.min(0.0) }
    });
    let mut last = 2;
    for _ in 0..MAXIMUM_STEPS {
        let share = weights[0] / (weights[0] - weights[1]);
        let at = ends[0].0 + (ends[1].0 - ends[0].0) * share.clamp(1e-3, 1.0 - 1e-3);
        let part = (at - ends[0].0) / (ends[1].0 - ends[0].0);
        let values = [0, 1].map(|i: usize| ends[i].1.eigenvalue_1_s());
        let expected = values[0] + (values[1] - values[0]) * part;
        let modes = modes_at(at).ok()?;
        let far = |mode: &M| ends.iter().map(|(_, end)| distance(end, expected, mode)).fold(f64::INFINITY, f64::min);
        let mode = modes.into_iter().min_by(|a, b| far(a).total_cmp(&far(b)))?;
        let growth = mode.eigenvalue_1_s().re;
        let side = usize::from((growth > 0.0) == begins);
        let close = (ends[1].0 - ends[0].0).abs() <= narrow
            || growth.abs() <= 1e-12 * mode.eigenvalue_1_s().norm()
            || (at - ends[side].0).abs() <= narrow;
        ends[side] = (at, mode);
        weights[side] = growth;
        if close {
            return Some(ends[side].clone());
        }
        if last == side {
            weights[1 - side] *= 0.5;
        }
        last = side;
    }
    None
}

/// Value between two others at which a sign changes, for example that of a static stiffness that becomes singular, by bisection. `None` if
/// the sign is undefined.
pub fn change_of_sign<E>(
    [mut low, mut high]: [f64; 2],
    sign_low: bool,
    sign_at: &mut impl FnMut(f64) -> Result<Option<bool>, E>,
) -> Option<f64> {
    let narrow = NARROW * (high - low).abs().max(high.abs());
    while (high - low).abs() > narrow {
        let middle = 0.5 * (low + high);
        match sign_at(middle) {
            Ok(Some(sign)) if sign == sign_low => low = middle,
            Ok(Some(_)) => high = middle,
            _ => return None,
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone, Debug, PartialEq)]
    struct Mode(Complex<f64>, [f64; 2]);

    impl Followed for Mode {
        fn eigenvalue_1_s(&self) -> Complex<f64> {
            self.0
        }
        fn likeness(&self, other: &Self) -> f64 {
            (self.1[0] * other.1[0] + self.1[1] * other.1[1]).powi(2)
        }
        fn product(&self, other: &Self) -> Option<Complex<f64>> {
            Some(Complex::new(self.1[0] * other.1[0] + self.1[1] * other.1[1], 0.0))
        }
    }

    /// Two modes with one eigenvalue at the first value and at one in the middle, with arbitrary shapes there: no branch ends, in either
    /// direction of the sweep, and elsewhere each keeps its shape from value to value.
    #[test]
    fn modes_of_one_eigenvalue_go_on() {
        for turn_rad in [0.0, 0.3, 0.25 * std::f64::consts::PI, 1.2] {
            let mut modes_at = |x: f64| -> Result<Vec<Mode>, ()> {
                let (sine, cosine) = if x == 0.0 || x == 2.0 { f64::sin_cos(turn_rad) } else { (0.0, 1.0) };
                let apart = 0.2 * x * (2.0 - x);
                Ok(vec![
                    Mode(Complex::new(-0.1, 10.0 + apart), [cosine, sine]),
                    Mode(Complex::new(-0.1, 10.0 - apart), [-sine, cosine]),
                ])
            };
            for places in [[0.0, 1.0, 1.5, 2.0, 3.0], [3.0, 2.0, 1.5, 1.0, 0.0]] {
                let (branches, failed) = Branches::follow(&places, &mut modes_at);
                assert!(failed.is_none());
                for place in &branches.places {
                    assert!(place.modes.len() == 2 && place.modes.iter().all(Option::is_some), "{turn_rad} {place:?}");
                }
            }
        }
    }

    /// Two modes whose frequencies cross at 1.05 without interaction, sorted by frequency: branches keep their shapes, and the zero of one
    /// growth rate, at `x³ = 2`, is found to the last digits.
    #[test]
    fn crossing_frequencies_are_told_apart_by_their_shapes() {
        let mut modes_at = |x: f64| -> Result<Vec<Mode>, ()> {
            let mut list = vec![
                Mode(Complex::new(x.powi(3) - 2.0, 10.0 + 2.0 * x), [1.0, 0.0]),
                Mode(Complex::new(-1.0, 14.2 - 2.0 * x), [0.0, 1.0]),
            ];
            list.sort_by(|a, b| a.0.norm().total_cmp(&b.0.norm()));
            Ok(list)
        };
        let places: Vec<f64> = (0..=8).map(|i| 0.25 * f64::from(i)).collect();
        let (branches, failed) = Branches::follow(&places, &mut modes_at);
        assert!(failed.is_none());
        for place in &branches.places {
            assert_eq!(place.modes.len(), 2);
            assert_eq!(place.modes[0].as_ref().unwrap().1, [1.0, 0.0], "at {}", place.at);
        }
        let crossings = branches.crossings(&mut modes_at);
        assert_eq!((crossings.len(), crossings[0].branch, crossings[0].begins), (1, 0, true));
        assert!((crossings[0].at - 2f64.cbrt()).abs() < 1e-9, "{}", crossings[0].at);
    }

    /// An undamped mode, whose growth rate is round-off of either sign, neither starts nor ceases to grow.
    #[test]
    fn round_off_is_no_growth() {
        let mut modes_at = |x: f64| -> Result<Vec<Mode>, ()> {
            let sign = if (x * 10.0).round() as i64 % 2 == 0 { 1.0 } else { -1.0 };
            Ok(vec![Mode(Complex::new(sign * 1e-13, 487.0), [1.0, 0.0])])
        };
        let places: Vec<f64> = (0..=8).map(|i| 0.1 * f64::from(i)).collect();
        let (branches, _) = Branches::follow(&places, &mut modes_at);
        assert!(branches.crossings(&mut modes_at).is_empty());
    }

    /// A mode that appears later starts a new branch; a value that fails ends the sweep with the results so far.
    #[test]
    fn branches_begin_and_sweeps_end_early() {
        let mut modes_at = |x: f64| -> Result<Vec<Mode>, &'static str> {
            if x > 3.0 {
                return Err("no equilibrium");
            }
            let mut list = vec![Mode(Complex::new(-1.0, 10.0), [1.0, 0.0])];
            if x > 1.0 {
                list.push(Mode(Complex::new(-0.1, 30.0), [0.0, 1.0]));
            }
            Ok(list)
        };
        let (branches, failed) = Branches::follow(&[0.0, 1.0, 2.0, 3.0, 4.0], &mut modes_at);
        assert_eq!(failed, Some((4.0, "no equilibrium")));
        let present: Vec<[bool; 2]> =
            branches.places.iter().map(|place| [0, 1].map(|branch: usize| place.modes[branch].is_some())).collect();
        assert_eq!(present, [[true, false], [true, false], [true, true], [true, true]]);
    }

    /// A change of sign is found from either end by halving: the number of calls, each of which may require an equilibrium, is the number
    /// of halvings of the interval down to the requested width.
    #[test]
    fn changes_of_sign_are_found_by_halving() {
        let expected = (NARROW.recip().log2().ceil()) as usize;
        for at in [0.01, 0.7, 1.3, 1.99] {
            for (ends, sign) in [([0.0, 2.0], true), ([2.0, 0.0], false)] {
                let mut calls = 0;
                let zero = change_of_sign::<()>(ends, sign, &mut |x| {
                    calls += 1;
                    Ok(Some(x < at))
                });
                assert!(zero.is_some_and(|zero| (zero - at).abs() <= 2.0 * NARROW), "{zero:?} for {at}");
                assert!(calls <= expected, "{calls} calls for {at}");
            }
        }
    }
}

//! Natural cubic splines.

/// Natural cubic spline: twice continuously differentiable, with zero second derivative at both ends; a straight line through two points.
#[derive(Debug, Clone, PartialEq)]
pub struct CubicSpline {
    /// Abscissae, ascending.
    places: Vec<f64>,
    /// Values at the abscissae.
    values: Vec<f64>,
    /// Second derivatives at the abscissae.
    bends: Vec<f64>,
}

impl CubicSpline {
    /// Spline through values at ascending abscissae, at least two.
    pub fn new(places: &[f64], values: &[f64]) -> Self {
        let count = places.len();
        let mut bends = vec![0.0; count];
        // elimination of the tridiagonal system, then back substitution
        let mut factors = vec![0.0; count];
        for i in 1..count.saturating_sub(1) {
            let (before, after) = (places[i] - places[i - 1], places[i + 1] - places[i]);
            let jump = (values[i + 1] - values[i]) / after - (values[i] - values[i - 1]) / before;
            let pivot = 2.0 * (before + after) - before * factors[i - 1];
            factors[i] = after / pivot;
            bends[i] = (6.0 * jump - before * bends[i - 1]) / pivot;
        }
        for i in (1..count.saturating_sub(1)).rev() {
            bends[i] -= factors[i] * bends[i + 1];
        }
        Self { places: places.to_vec(), values: values.to_vec(), bends }
    }

    /// Index of the interval of a position; the first or the last one for positions beyond the ends.
    fn interval(&self, place: f64) -> usize {
        self.places.partition_point(|known| *known <= place).clamp(1, self.places.len() - 1) - 1
    }

    /// Value at a position.
    pub fn at(&self, place: f64) -> f64 {
        let i = self.interval(place);
        let width = self.places[i + 1] - self.places[i];
        let b = (place - self.places[i]) / width;
        let a = 1.0 - b;
        let bent = (a * a * a - a) * self.bends[i] + (b * b * b - b) * self.bends[i + 1];
        a * self.values[i] + b * self.values[i + 1] + bent * width * width / 6.0
    }

    /// First and second derivative at a position.
    pub fn slopes(&self, place: f64) -> [f64; 2] {
        let i = self.interval(place);
        let width = self.places[i + 1] - self.places[i];
        let b = (place - self.places[i]) / width;
        let a = 1.0 - b;
        let bent = (3.0 * b * b - 1.0) * self.bends[i + 1] - (3.0 * a * a - 1.0) * self.bends[i];
        let slope = (self.values[i + 1] - self.values[i]) / width + bent * width / 6.0;
        [slope, a * self.bends[i] + b * self.bends[i + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Linear functions are reproduced exactly; other splines pass through their points with continuous first and second derivatives and
    /// natural ends.
    #[test]
    fn passes_through_its_points_smoothly() {
        let places = [0.0, 0.3, 1.0, 1.4, 2.0];
        let spline = CubicSpline::new(&places, &places.map(|x: f64| 2.0 - 3.0 * x));
        for x in [0.0, 0.1, 0.9, 1.99, 2.0] {
            assert!((spline.at(x) - (2.0 - 3.0 * x)).abs() < 1e-14 && (spline.slopes(x)[0] + 3.0).abs() < 1e-13);
        }
        let spline = CubicSpline::new(&places, &[0.0, 1.0, -1.0, 0.5, 0.0]);
        for (place, value) in places.iter().zip([0.0, 1.0, -1.0, 0.5, 0.0]) {
            assert!((spline.at(*place) - value).abs() < 1e-14);
        }
        for place in &places[1..4] {
            let [before, after] = [place - 1e-9, place + 1e-9].map(|x| spline.slopes(x));
            assert!((before[0] - after[0]).abs() < 1e-6 && (before[1] - after[1]).abs() < 1e-5);
        }
        assert!(spline.slopes(0.0)[1].abs() < 1e-12 && spline.slopes(2.0)[1].abs() < 1e-12);
    }

    /// A sine over half a period satisfies the natural conditions at both ends: halving the intervals divides the error by sixteen.
    #[test]
    fn is_of_fourth_order() {
        let error = |count: usize| {
            let places: Vec<f64> = (0..=count).map(|i| std::f64::consts::PI * i as f64 / count as f64).collect();
            let values: Vec<f64> = places.iter().map(|x| x.sin()).collect();
            let spline = CubicSpline::new(&places, &values);
            (0..200).map(|i| 0.0157 * f64::from(i)).map(|x| (spline.at(x) - x.sin()).abs()).fold(0.0, f64::max)
        };
        let order = (error(8) / error(16)).log2();
        assert!((order - 4.0).abs() < 0.1, "{order}");
    }
}

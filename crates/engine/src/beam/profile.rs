//! Functions of the distance along a body: constants, polynomials, tables.

/// A scalar function of the distance `s` from a body's inner end, in m.
#[derive(Debug, Clone, PartialEq)]
pub enum Profile {
    /// Polynomial `Σ coefficients[i] sⁱ`, NOTATION eq. (S4).
    Polynomial(Vec<f64>),
    /// Linear interpolation between rows `[s, value]` in ascending order of `s`; constant before the first and after the last. Every
    /// integral over an element is split at the rows, so that the kinks cause no loss of accuracy.
    Table(Vec<[f64; 2]>),
    /// Piecewise polynomials `[start, c0, c1, c2, c3]` in ascending order of their starts in m: `Σ c_i (s − start)ⁱ` from each start to the
    /// next. Integrals are split at the starts.
    Pieces(Vec<[f64; 5]>),
}

impl Profile {
    /// Constant function.
    pub fn constant(value: f64) -> Self {
        Self::Polynomial(vec![value])
    }

    /// Linear function from `inner` at the inner end to `outer` at `length_m`.
    pub fn linear(inner: f64, outer: f64, length_m: f64) -> Self {
        Self::Polynomial(vec![inner, (outer - inner) / length_m])
    }

    /// Value at `s_m`.
    pub fn at(&self, s_m: f64) -> f64 {
        match self {
            Self::Polynomial(coefficients) => coefficients.iter().rev().fold(0.0, |value, c| value * s_m + c),
            Self::Table(rows) => {
                let after = rows.partition_point(|row| row[0] <= s_m);
                match (after.checked_sub(1).and_then(|before| rows.get(before)), rows.get(after)) {
                    (Some([s0, v0]), Some([s1, v1])) => v0 + (v1 - v0) * (s_m - s0) / (s1 - s0),
                    (Some([_, value]), None) | (None, Some([_, value])) => *value,
                    (None, None) => 0.0,
                }
            }
            Self::Pieces(pieces) => {
                let piece = pieces.partition_point(|piece| piece[0] <= s_m).max(1) - 1;
                pieces.get(piece).map_or(0.0, |[start, c0, c1, c2, c3]| {
                    let t = s_m - start;
                    c0 + t * (c1 + t * (c2 + t * c3))
                })
            }
        }
    }

    /// Positions in m at which the derivative may jump.
    pub fn kinks_m(&self) -> Vec<f64> {
        match self {
            Self::Polynomial(_) => Vec::new(),
            Self::Table(rows) => rows.iter().map(|row| row[0]).collect(),
            Self::Pieces(pieces) => pieces.iter().map(|piece| piece[0]).collect(),
        }
    }

    /// Whether the function is constant.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Polynomial(coefficients) => coefficients.iter().skip(1).all(|c| *c == 0.0),
            Self::Table(rows) => rows.windows(2).all(|pair| pair[0][1] == pair[1][1]),
            Self::Pieces(pieces) => pieces.iter().all(|piece| piece[1] == pieces[0][1] && piece[2..] == [0.0; 3]),
        }
    }

    /// Positions on `[0, length_m]` that show the function's shape: 200 equal steps and the kinks.
    pub fn samples_m(&self, length_m: f64) -> Vec<f64> {
        let mut places: Vec<f64> = (0..=200).map(|i| length_m * f64::from(i) / 200.0).collect();
        places.extend(self.kinks_m().into_iter().filter(|s| (0.0..=length_m).contains(s)));
        places
    }
}

impl From<f64> for Profile {
    /// Constant function.
    fn from(value: f64) -> Self {
        Self::constant(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_and_tables() {
        let polynomial = Profile::Polynomial(vec![1.0, -2.0, 3.0]);
        assert_eq!(polynomial.at(2.0), 1.0 - 4.0 + 12.0);
        let table = Profile::Table(vec![[1.0, 5.0], [2.0, 7.0], [4.0, 3.0]]);
        for (s, value) in [(0.0, 5.0), (1.0, 5.0), (1.5, 6.0), (2.0, 7.0), (3.0, 5.0), (4.0, 3.0), (9.0, 3.0)] {
            assert_eq!(table.at(s), value, "at {s} m");
        }
        assert!(!table.is_constant() && !polynomial.is_constant() && Profile::constant(2.0).is_constant());
    }
}

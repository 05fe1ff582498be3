//! Formatting of numbers.

/// Formats six significant digits like C's `%.6g`: `-7.99746`, `0.000123`, `1.5e-07`, `2.5e+09`; −0 becomes `0`.
pub fn six(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{}", value + 0.0);
    }
    let scientific = format!("{value:.5e}");
    let (digits, exponent) = scientific.split_once('e').expect("an exponent");
    let exponent: i32 = exponent.parse().expect("a whole number");
    let trimmed = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text.to_owned(),
    };
    if (-4..6).contains(&exponent) {
        return trimmed(&format!("{value:.*}", (5 - exponent) as usize));
    }
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{}e{sign}{:02}", trimmed(digits), exponent.abs())
}

#[cfg(test)]
mod tests {
    use super::six;

    #[test]
    fn numbers_are_those_of_printf() {
        let pairs = [
            (-7.997464, "-7.99746"),
            (51.8, "51.8"),
            (1.0, "1"),
            (123456.7, "123457"),
            (999999.6, "1e+06"),
            (1.5e-7, "1.5e-07"),
            (1.234e-4, "0.0001234"),
            (2.5e9, "2.5e+09"),
            (0.0, "0"),
            (-0.0, "0"),
            (f64::INFINITY, "inf"),
        ];
        for (value, text) in pairs {
            assert_eq!(six(value), text);
        }
    }
}

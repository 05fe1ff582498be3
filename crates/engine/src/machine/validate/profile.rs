//! Checks of a function along a body.

use crate::beam::profile::Profile;
use crate::machine::fault::{Checker, array_text, is_finite};
use crate::machine::units::shortest;

/// Checks a function along a body: finite, with rows in order and on the body.
pub(crate) fn profile(place: &[&str], profile: &Profile, length_m: f64, checker: &mut Checker) -> bool {
    match profile {
        Profile::Polynomial(coefficients) => {
            let fits =
                !coefficients.is_empty() && coefficients.len() <= 100 && coefficients.iter().copied().all(is_finite);
            if !fits {
                let place = [place, &["polynomial"]].concat();
                checker.refuse(&place, array_text(coefficients), "an array of 1 to 100 finite numbers");
            }
            fits
        }
        Profile::Pieces(pieces) => {
            let finite = !pieces.is_empty() && pieces.iter().flatten().copied().all(is_finite);
            let ascending = pieces.windows(2).all(|pair| pair[0][0] < pair[1][0]);
            let on_body = pieces.iter().all(|piece| (0.0..length_m).contains(&piece[0]));
            let fits = finite && ascending && on_body;
            if !fits {
                let allowed = format!(
                    "pieces [start, c0, c1, c2, c3] of finite numbers with starts ascending from 0 to below {} m",
                    shortest(length_m)
                );
                checker.refuse_state(place, format!("{} invalid pieces", pieces.len()), allowed);
            }
            fits
        }
        Profile::Table(rows) => {
            let finite = !rows.is_empty() && rows.iter().flatten().copied().all(is_finite);
            let ascending = rows.windows(2).all(|pair| pair[0][0] < pair[1][0]);
            let on_body = rows.iter().all(|row| (0.0..=length_m).contains(&row[0]));
            let fits = finite && ascending && on_body;
            if !fits {
                let length = shortest(length_m);
                let allowed =
                    format!("rows [s, value] with s ascending from 0 to at most {length} m, the body's length");
                let rows: Vec<String> = rows.iter().map(|row| array_text(row)).collect();
                checker.refuse(&[place, &["table"]].concat(), format!("[{}]", rows.join(", ")), allowed);
            }
            fits
        }
    }
}

/// Minimum value of a function on a body; NaN if a value is NaN.
pub(crate) fn least_of(profile: &Profile, length_m: f64) -> f64 {
    let values = profile.samples_m(length_m).into_iter().map(|s| profile.at(s));
    values.fold(f64::INFINITY, |least, value| if value.is_nan() { value } else { least.min(value) })
}

//! Numbers and tables on the documentation page.

use foldwing_engine::machine::UNLIMITED;
use std::fmt::Write;

/// Formats at most six significant digits, as a power of ten if this is shorter; infinite limits as `unlimited`.
pub(super) fn number(value: f64) -> String {
    if value.abs() >= UNLIMITED {
        return "unlimited".to_owned();
    }
    let rounded: f64 = format!("{value:.5e}").parse().expect("a number just written");
    let plain = rounded.to_string();
    let short = format!("{rounded:e}");
    let longest = if rounded.abs() < 1.0 { short.len() + 3 } else { short.len().max(7) };
    if plain.len() <= longest { plain } else { short }
}

/// Formats the components of a vector in parentheses.
pub(super) fn vector(components: &[f64]) -> String {
    format!("({})", components.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", "))
}

/// Writes a table of cells that are already HTML.
pub(super) fn table(html: &mut String, head: &[&str], rows: impl Iterator<Item = Vec<String>>) {
    let line = |cell: &str, cells: &[String]| -> String {
        let cells: String = cells.iter().map(|text| format!("<{cell}>{text}</{cell}>")).collect();
        format!("<tr>{cells}</tr>\n")
    };
    // descriptions may wrap, numbers and names may not
    let prose = match head.last() {
        Some(&"meaning") => " meaning",
        Some(&"case") => " cases",
        _ => "",
    };
    let head: Vec<String> = head.iter().map(|text| (*text).to_owned()).collect();
    let _ = write!(
        html,
        "<div class=\"wide{}\"><table>\n<thead>{}</thead>\n<tbody>\n",
        prose,
        line("th", &head).trim_end()
    );
    rows.for_each(|row| html.push_str(&line("td", &row)));
    html.push_str("</tbody>\n</table></div>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers are short and readable.
    #[test]
    fn numbers_are_short() {
        let cases = [
            (0.15, "0.15"),
            (2.83e5, "283000"),
            (3.17044e10, "3.17044e10"),
            (1e-9, "1e-9"),
            (2.0 / 3.0, "0.666667"),
            (UNLIMITED, "unlimited"),
        ];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
    }
}

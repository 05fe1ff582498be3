//! Colours of the drawing, in a table shared by the page (light and dark) and the icon.

use std::fmt::Write;

/// Role of a shape in the drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// The wing between its start angles and deployed.
    Ghost,
    /// The wing at its start angles.
    Start,
    /// Lifting surface of the deployed wing.
    Surface,
    /// The wing deployed.
    Deployed,
    /// Axis of the root frame.
    Axis,
    /// Load station.
    Station,
    /// Attached mass.
    Mass,
    /// Fold axis.
    Hinge,
    /// Joint.
    Joint,
    /// Closed loop.
    Loop,
    /// Strain gauge.
    Gauge,
}

/// A colour as `[red, green, blue]`.
pub type Colour = [u8; 3];

/// Fill and line colour of a role on a light or dark background; `None` if not drawn.
#[derive(Debug, Clone, Copy)]
pub struct Tint {
    /// Colour of the interior.
    pub fill: Option<Colour>,
    /// Colour of the line.
    pub line: Option<Colour>,
}

/// Style of a role; lengths in user units of the drawing.
#[derive(Debug, Clone, Copy)]
pub struct Ink {
    /// Role.
    pub role: Role,
    /// Style class on the page.
    pub class: &'static str,
    /// Colours on a light background and in the icon.
    pub light: Tint,
    /// Colours on a dark background.
    pub dark: Tint,
    /// Opacity of the fill, 0 to 1.
    pub opacity: f64,
    /// Width of the line.
    pub width: f64,
    /// Lengths of dash and gap, `None` for a solid line.
    pub dash: Option<[f64; 2]>,
    /// Radius of the dot; 0 for roles that are not dots.
    pub radius: f64,
}

/// Background colours, light and dark.
pub const PAPER: [Colour; 2] = [[0xff, 0xff, 0xff], [0x14, 0x1a, 0x21]];

const NAVY: Colour = [0x0f, 0x35, 0x57];
const SKY: Colour = [0xa9, 0xcd, 0xee];
const BLUE: Colour = [0x4d, 0x8f, 0xc4];
const TEAL: Colour = [0x5f, 0xa8, 0x9c];
const RUST: [Colour; 2] = [[0xb3, 0x54, 0x1e], [0xf0, 0xa3, 0x6c]];
const GREY: [Colour; 2] = [[0x9f, 0xb0, 0xbf], [0x5c, 0x6b, 0x79]];
const TEXT: [Colour; 2] = [[0x1b, 0x27, 0x33], [0xdc, 0xe4, 0xec]];
const VIOLET: [Colour; 2] = [[0x6b, 0x4f, 0x9a], [0xc0, 0xa8, 0xe8]];
const RED: [Colour; 2] = [[0xb0, 0x1e, 0x3c], [0xf0, 0x7c, 0x94]];
const GOLD: [Colour; 2] = [[0xc8, 0xa2, 0x00], [0xee, 0xd0, 0x4a]];

/// Tints for both backgrounds.
const fn tints(fill: Option<[Colour; 2]>, line: Option<[Colour; 2]>) -> [Tint; 2] {
    const fn pick(pair: Option<[Colour; 2]>, dark: usize) -> Option<Colour> {
        match pair {
            Some(pair) => Some(pair[dark]),
            None => None,
        }
    }
    [Tint { fill: pick(fill, 0), line: pick(line, 0) }, Tint { fill: pick(fill, 1), line: pick(line, 1) }]
}

const fn line(role: Role, class: &'static str, colours: [Colour; 2], width: f64, dash: Option<[f64; 2]>) -> Ink {
    let [light, dark] = tints(None, Some(colours));
    Ink { role, class, light, dark, opacity: 1.0, width, dash, radius: 0.0 }
}

const fn dot(role: Role, class: &'static str, fill: [Colour; 2], ring: Option<[Colour; 2]>, radius: f64) -> Ink {
    let [light, dark] = tints(Some(fill), ring);
    let width = if ring.is_some() { 2.0 } else { 0.0 };
    Ink { role, class, light, dark, opacity: 1.0, width, dash: None, radius }
}

const fn shape(role: Role, class: &'static str, fill: [Colour; 2], line: [Colour; 2], opacity: f64, width: f64) -> Ink {
    let [light, dark] = tints(Some(fill), Some(line));
    Ink { role, class, light, dark, opacity, width, dash: None, radius: 0.0 }
}

/// Styles of all roles.
pub const INKS: [Ink; 11] = [
    line(Role::Ghost, "ghost", GREY, 0.8, None),
    line(Role::Start, "start", RUST, 1.4, Some([6.0, 4.0])),
    shape(Role::Surface, "surface", [TEAL, TEAL], [[0x4f, 0x8f, 0x86], [0x74, 0xb8, 0xad]], 0.2, 0.8),
    shape(Role::Deployed, "deployed", [BLUE, BLUE], [NAVY, SKY], 0.55, 1.4),
    line(Role::Axis, "axis", TEXT, 1.3, None),
    line(Role::Hinge, "hinge", RED, 2.2, None),
    dot(Role::Station, "station", [NAVY, SKY], None, 3.0),
    dot(Role::Mass, "mass", VIOLET, None, 6.0),
    dot(Role::Joint, "joint", PAPER, Some([NAVY, SKY]), 4.5),
    dot(Role::Loop, "loop", PAPER, Some(RUST), 4.0),
    dot(Role::Gauge, "gauge", GOLD, None, 3.5),
];

/// Style of a role.
pub fn ink(role: Role) -> &'static Ink {
    INKS.iter().find(|ink| ink.role == role).expect("every role has a row")
}

/// Style sheet of the drawing and of the symbols in its caption.
pub fn style() -> String {
    let mut css = String::new();
    for (dark, paper) in [(false, PAPER[0]), (true, PAPER[1])] {
        let mut variables = format!("--paper:{};", hex(paper));
        for ink in &INKS {
            let tint = if dark { ink.dark } else { ink.light };
            for (what, colour) in [("fill", tint.fill), ("line", tint.line)] {
                if let Some(colour) = colour {
                    let _ = write!(variables, "--{}-{what}:{};", ink.class, hex(colour));
                }
            }
        }
        let _ = match dark {
            false => writeln!(css, ":root{{{variables}}}"),
            true => writeln!(css, "@media (prefers-color-scheme:dark){{:root{{{variables}}}}}"),
        };
    }
    for Ink { class, light, opacity, width, dash, radius, .. } in &INKS {
        let fill = light.fill.map_or("none".to_owned(), |_| format!("var(--{class}-fill)"));
        let _ = write!(css, "svg .{class}{{fill:{fill};");
        if *opacity < 1.0 {
            let _ = write!(css, "fill-opacity:{opacity};");
        }
        if light.line.is_some() {
            let _ = write!(css, "stroke:var(--{class}-line);stroke-width:{width};");
        }
        if let Some([on, off]) = dash {
            let _ = write!(css, "stroke-dasharray:{on} {off};");
        }
        css.push_str("}\n");
        if *radius > 0.0 {
            let border = if light.line.is_some() { format!("{width}px solid var(--{class}-line)") } else { "0".into() };
            let _ = writeln!(css, ".key.{class}{{background:{fill};border:{border}}}");
        } else if light.fill.is_some() {
            // the symbol is small, so it is half as transparent as the shape
            let share = 50.0 * (1.0 + opacity);
            let _ = writeln!(
                css,
                ".key.{class}{{background:color-mix(in srgb,{fill} {share:.0}%,var(--paper));border-radius:2px;\
                 border:1px solid var(--{class}-line)}}"
            );
        } else {
            let _ = writeln!(
                css,
                ".key.{class}{{background:var(--{class}-line);border-radius:0;height:3px;vertical-align:3px}}"
            );
        }
    }
    css
}

/// Style sheet of the drawing on white, without CSS variables, which many SVG viewers do not support.
pub fn print_style() -> String {
    let colour = |colour: Option<Colour>| colour.map_or("none".to_owned(), hex);
    let rule = |ink: &Ink| {
        let dash = ink.dash.map_or(String::new(), |[on, off]| format!(";stroke-dasharray:{on} {off}"));
        format!(
            ".{}{{fill:{};fill-opacity:{};stroke:{};stroke-width:{}{dash}}}\n",
            ink.class,
            colour(ink.light.fill),
            ink.opacity,
            colour(ink.light.line),
            ink.width
        )
    };
    INKS.iter().map(rule).collect()
}

fn hex([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast of two colours according to WCAG 2: ratio of relative luminances with the sRGB curve, 1 to 21.
    fn contrast(a: Colour, b: Colour) -> f64 {
        let luminance = |colour: Colour| -> f64 {
            let linear = colour.map(|value| {
                let value = f64::from(value) / 255.0;
                if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            });
            0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// Each role differs from either background by its line or fill: WCAG requires a contrast of 3 for graphics. Intermediate positions
    /// are meant to be faint, and the gold of a gauge lies on the blue of the wing.
    #[test]
    fn every_role_is_visible_on_both_papers() {
        for ink in INKS.iter().filter(|ink| ink.role != Role::Ghost) {
            for (tint, paper) in [(ink.light, PAPER[0]), (ink.dark, PAPER[1])] {
                let colour = tint.line.or(tint.fill).expect("every role has a colour");
                let least = if ink.role == Role::Gauge { 2.3 } else { 3.0 };
                let found = contrast(colour, paper);
                assert!(found >= least, "{}: contrast {found:.2}, at least {least} is needed", ink.class);
            }
        }
    }
}

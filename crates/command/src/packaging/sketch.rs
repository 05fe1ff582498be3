//! Drawing of the wing with text characters, for terminals: from above and from the side, at its start angles.
//!
//! Only ASCII, which every terminal, log and continuous integration service displays correctly; at most 80 columns.

use crate::packaging::drawing::{axes, hinges, outline, places, planforms, undeformed};
use crate::packaging::palette::Role;
use foldwing_engine::machine::Machine;
use foldwing_engine::machine::pose::Frame;
use nalgebra::Vector3;
use std::fmt::Write;

/// Columns of a view; with its indentation it fits into 80 columns.
const COLUMNS: usize = 76;
/// Maximum number of rows of a view.
const MAXIMUM_ROWS: usize = 22;
/// Ratio of height to width of a character.
const ASPECT: f64 = 2.0;
/// Characters that fill the bodies, used in rotation.
const FILLS: [char; 6] = ['=', '#', '~', '%', ':', '&'];
/// Lifting surface that extends beyond its body.
const SURFACE: char = '.';

/// Characters of parts on the wing, with their names; later ones cover earlier ones.
const SIGNS: [(Role, char, &str); 4] = [
    (Role::Station, '+', "load station"),
    (Role::Mass, 'M', "mass"),
    (Role::Loop, 'L', "closed loop"),
    (Role::Gauge, 'G', "strain gauge"),
];
/// Characters of joints: fold joint without and with a latch, other joints.
const JOINTS: [(char, &str); 6] = [
    ('O', "fold joint"),
    ('@', "fold joint with latch"),
    ('X', "clamp"),
    ('*', "joint with several degrees of freedom"),
    ('S', "sliding joint"),
    ('$', "sliding joint with latch"),
];

/// Draws the undeformed model at its start angles, in two views of the same scale with a legend. Every line is ASCII and at most 80
/// characters long.
pub fn sketch(machine: &Machine) -> String {
    let wing = undeformed(machine, 1.0);
    let mut painter = Painter::new(machine, &wing);
    if !painter.scale_m.is_finite() {
        return "  (no drawing: the model is too large)\n".to_owned();
    }
    let mut text = String::new();
    for (title, up) in [("from above: x to the right, y up", 1), ("from the side: x to the right, z up", 2)] {
        let _ = writeln!(text, "  {title}");
        for row in painter.view(up) {
            let _ = writeln!(text, "  {}", row.trim_end());
        }
        text.push('\n');
    }
    text + &painter.legend(machine)
}

/// Shape to draw; points are in the root frame in m.
enum Mark {
    /// Quadrilaterals between two edges, filled with a character.
    Area(char, Vec<Vector3<f64>>, Vec<Vector3<f64>>),
    /// Fold axis, drawn as a line between its ends.
    Line([Vector3<f64>; 2]),
    /// Single character at a point.
    Sign(char, Vector3<f64>),
}

struct Painter {
    marks: Vec<Mark>,
    /// Metres per column.
    scale_m: f64,
    least_m: Vector3<f64>,
    most_m: Vector3<f64>,
    /// Visible characters.
    seen: String,
}

impl Painter {
    fn new(machine: &Machine, wing: &[Vec<Frame>]) -> Self {
        let halves = |mut edge: Vec<Vector3<f64>>| {
            let mut other = edge.split_off(edge.len() / 2);
            other.reverse();
            (edge, other)
        };
        let mut marks = Vec::new();
        for (_, edges) in planforms(machine, wing) {
            let (leading, trailing) = halves(edges);
            marks.push(Mark::Area(SURFACE, leading, trailing));
        }
        for (index, (body, frames)) in machine.bodies.iter().zip(wing).enumerate() {
            let (front, rear) = halves(outline(body, frames));
            marks.push(Mark::Area(FILLS[index % FILLS.len()], front, rear));
        }
        marks.extend(hinges(machine, wing).into_iter().map(Mark::Line));
        let places = places(machine, wing);
        for (role, sign, _) in SIGNS {
            marks.extend(places.iter().filter(|place| place.0 == role).map(|place| Mark::Sign(sign, place.1)));
        }
        for (body, frames) in machine.bodies.iter().zip(wing) {
            let kind = &body.joint.kind;
            let sign = match kind.one_freedom() {
                Some((_, joint)) => 4 * usize::from(kind.slides()) + usize::from(joint.latch.is_some()),
                None if kind.is_clamped() => 2,
                None => 3,
            };
            marks.push(Mark::Sign(JOINTS[sign].0, frames[0].position_m));
        }
        let mut painter = Self {
            marks,
            scale_m: 1.0,
            least_m: Vector3::repeat(f64::INFINITY),
            most_m: Vector3::repeat(f64::NEG_INFINITY),
            seen: String::new(),
        };
        painter.fit();
        painter
    }

    /// Sets the scale so that both views fit.
    fn fit(&mut self) {
        for mark in &self.marks {
            let points: Vec<Vector3<f64>> = match mark {
                Mark::Area(_, front, rear) => front.iter().chain(rear).copied().collect(),
                Mark::Line(ends) => ends.to_vec(),
                Mark::Sign(_, at) => vec![*at],
            };
            for point in points {
                self.least_m = self.least_m.inf(&point);
                self.most_m = self.most_m.sup(&point);
            }
        }
        // NaN if a point is not finite
        let span = (self.most_m - self.least_m).map(|length| if length >= 0.0 { length } else { f64::INFINITY });
        let columns = span.x / (COLUMNS - 1) as f64;
        let rows = span.y.max(span.z) / ((MAXIMUM_ROWS - 1) as f64 * ASPECT);
        self.scale_m = columns.max(rows);
        if self.scale_m <= 0.0 {
            self.scale_m = 1.0; // the model has zero size
        }
    }

    /// Column and row of a point, not rounded; rows increase downwards.
    fn place(&self, point: &Vector3<f64>, up: usize) -> [f64; 2] {
        [(point.x - self.least_m.x) / self.scale_m, (self.most_m[up] - point[up]) / (self.scale_m * ASPECT)]
    }

    /// Rows of the view in which the axis `up` points upwards.
    fn view(&mut self, up: usize) -> Vec<String> {
        let [_, bottom] = self.place(&self.least_m, up);
        let mut rows = vec![vec![' '; COLUMNS]; bottom.round() as usize + 1];
        let mut put = |[column, row]: [f64; 2], sign: char| {
            rows[row.round() as usize][(column.round() as usize).min(COLUMNS - 1)] = sign;
        };
        for mark in &self.marks {
            match mark {
                Mark::Area(sign, front, rear) => {
                    for ((a, b), (c, d)) in front.iter().zip(&front[1..]).zip(rear.iter().zip(&rear[1..])) {
                        let [a, b, c, d] = [a, b, c, d].map(|point| self.place(point, up));
                        fill([a, b, c, d], |at| put(at, *sign));
                    }
                }
                Mark::Line(ends) => {
                    let [from, to] = ends.map(|end| self.place(&end, up));
                    let sign = stroke(from, to);
                    fill([from, to, from, to], |at| put(at, sign));
                }
                Mark::Sign(sign, at) => put(self.place(at, up), *sign),
            }
        }
        let rows: Vec<String> = rows.into_iter().map(String::from_iter).collect();
        self.seen.extend(rows.iter().map(String::as_str));
        rows
    }

    /// Legend of the visible characters.
    fn legend(&self, machine: &Machine) -> String {
        let mut words: Vec<String> = Vec::new();
        for (index, fill) in FILLS.iter().enumerate().filter(|(_, fill)| self.seen.contains(**fill)) {
            let names: Vec<&str> =
                machine.bodies.iter().skip(index).step_by(FILLS.len()).map(|body| body.name.as_str()).collect();
            words.push(format!("{fill} {}", names.join(", ")));
        }
        let mut sign = |sign: char, word: &str| {
            if self.seen.contains(sign) {
                words.push(format!("{sign} {word}"));
            }
        };
        sign(SURFACE, "lifting surface");
        JOINTS.iter().for_each(|(letter, word)| sign(*letter, word));
        SIGNS.iter().for_each(|(_, letter, word)| sign(*letter, word));
        if self.marks.iter().any(|mark| matches!(mark, Mark::Line(_))) {
            words.push(format!("/ | \\ - {}", axes(machine)));
        }
        words.push(format!("one column is {} m", significant(self.scale_m)));
        wrap(&words)
    }
}

/// Calls `put` at points of the quadrilateral between the lines `a b` and `c d`, dense enough to leave no gap.
fn fill([a, b, c, d]: [[f64; 2]; 4], mut put: impl FnMut([f64; 2])) {
    let length = |p: [f64; 2], q: [f64; 2]| (p[0] - q[0]).hypot(p[1] - q[1]);
    let mix = |p: [f64; 2], q: [f64; 2], share: f64| [0, 1].map(|i| p[i] + share * (q[i] - p[i]));
    let steps = |longest: f64| (2.0 * longest).ceil().max(1.0) as usize;
    let along = steps(length(a, b).max(length(c, d)));
    let across = steps(length(a, c).max(length(b, d)));
    for i in 0..=along {
        let share = i as f64 / along as f64;
        let (front, rear) = (mix(a, b, share), mix(c, d, share));
        (0..=across).for_each(|j| put(mix(front, rear, j as f64 / across as f64)));
    }
}

/// Character that best matches the direction of a line.
fn stroke(from: [f64; 2], to: [f64; 2]) -> char {
    let (right, down) = (to[0] - from[0], to[1] - from[1]);
    match (right.abs(), down.abs()) {
        (right, down) if right <= 0.4 * down => '|',
        (right, down) if down <= 0.2 * right => '-',
        _ if right * down > 0.0 => '\\',
        _ => '/',
    }
}

/// Formats three significant digits.
fn significant(value: f64) -> String {
    let digits = (2.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{value:.digits$}")
}

/// Joins words with commas and wraps the lines; words that are too long are truncated.
fn wrap(words: &[String]) -> String {
    let mut lines = vec![String::new()];
    for word in words {
        let word: String = word.chars().take(COLUMNS - 1).collect();
        let last = lines.last_mut().expect("there is one");
        if last.is_empty() {
            *last = word;
        } else if last.len() + 3 + word.len() <= COLUMNS {
            *last += &format!("   {word}");
        } else {
            lines.push(word);
        }
    }
    lines.iter().map(|line| format!("  {line}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packaging::drawing::tests::two_body_machine;

    /// Rows of the view with this title.
    fn rows<'a>(text: &'a str, title: &str) -> Vec<&'a str> {
        text.lines().skip_while(|line| !line.contains(title)).skip(1).take_while(|line| !line.is_empty()).collect()
    }

    /// Folded down by 90 degrees, in the view from the side: the inner body is at the top, and the outer body extends down from its
    /// end; the inner body has twice as many columns as the outer one has rows.
    #[test]
    fn a_folded_wing_hangs_from_its_hinge() {
        let text = sketch(&two_body_machine());
        assert!(text.is_ascii() && text.lines().all(|line| line.len() <= 80), "{text}");
        let side = rows(&text, "from the side");
        let width = side[0].trim().len();
        assert!(side[0].starts_with("  X") && side[0].ends_with('@'), "{text}");
        assert!(side[1..].iter().all(|row| row.trim().len() == 1 && row.len() == side[0].len()), "{text}");
        assert!(
            (side.len() as i64 - 1 - (width as i64 - 1) / 2).abs() <= 1,
            "{} rows, {width} columns\n{text}",
            side.len()
        );
        assert!(side[side.len() - 1].ends_with('#'));

        // in the view from above, the hinge spans the chord, and the inner body is as wide as its section
        let above = rows(&text, "from above");
        assert!(above.len() >= 3 && above.iter().all(|row| row.contains('|') || row.contains('@')), "{text}");
        assert!(text.contains("= inner   # outer   @ fold joint with latch   X clamp   + load station"), "{text}");
    }

    /// A model of zero size is drawn, too.
    #[test]
    fn a_point_is_drawn() {
        let mut machine = two_body_machine();
        machine.bodies.truncate(1);
        machine.bodies[0].length_m = 1e-300;
        machine.bodies[0].station_positions_m.clear();
        assert!(sketch(&machine).contains("one column is"));
    }

    /// A model with infinite coordinates gives no drawing, and no panic.
    #[test]
    fn an_endless_machine_is_not_drawn() {
        for position_m in [f64::INFINITY, f64::NAN] {
            let mut machine = two_body_machine();
            machine.bodies[0].joint.parent =
                foldwing_engine::machine::Parent::Root { position_m: Vector3::repeat(position_m) };
            assert_eq!(sketch(&machine), "  (no drawing: the model is too large)\n");
        }
    }

    /// Characters have the slope of their lines, with rows increasing downwards.
    #[test]
    fn strokes_lean() {
        let signs = [([0.0, 5.0], '|'), ([5.0, 0.0], '-'), ([5.0, 5.0], '\\'), ([5.0, -5.0], '/')];
        assert!(signs.iter().all(|(to, sign)| stroke([0.0, 0.0], *to) == *sign));
    }

    #[test]
    fn scales_have_three_digits() {
        assert_eq!([0.004_123, 0.5, 12.34, 1234.0].map(significant), ["0.00412", "0.500", "12.3", "1234"]);
    }
}

//! Figures of a run: fold angles, strains, tip paths, deformed shapes and energies, or any variables over time.

use crate::report::figure::{Curve, Figure, Look, PALETTE};
use crate::report::recording::{Frame, MAXIMUM_POINTS, Recording, Thinning};
use foldwing_engine::machine::{Travel, UNLIMITED};
use foldwing_engine::plant::EnergyOutputs;
use nalgebra::Vector3;

/// Maximum number of shapes in a figure.
const SHAPES: usize = 9;

/// Maximum number of curves in a figure of selected variables: two styles per colour.
const CURVES: usize = 2 * PALETTE.len();

/// Maximum number of changes of a Boolean variable over a run that are marked.
const MAXIMUM_CHANGES: usize = 6;

/// Axes of the root frame.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Figure with the base name of its files.
pub type Named = (&'static str, Figure);

/// Names of the figures of [`figures`].
pub const NAMES: [&str; 11] = [
    "fold_angles",
    "fold_torques",
    "tips",
    "root_moment",
    "strains",
    "air_force",
    "energies",
    "tip_path",
    "shapes",
    "positions",
    "slide_forces",
];

/// Measured values over time, or values of another run, under variable names.
pub struct Measured {
    /// Label in the figures.
    pub label: String,
    /// Names of the variables.
    pub names: Vec<String>,
    /// Rows: time in s, followed by a value for each name; NaN if there is none.
    pub rows: Vec<f32>,
}

impl Measured {
    /// Points of a variable, with values multiplied by a factor.
    fn points(&self, name: &str, factor: f64) -> Option<Vec<[f64; 2]>> {
        let column = self.names.iter().position(|own| own == name)? + 1;
        let rows = self.rows.chunks_exact(self.names.len() + 1);
        Some(rows.map(|row| [f64::from(row[0]), factor * f64::from(row[column])]).collect())
    }
}

/// Curve of a variable, with measured values as dots in the same colour; `n` is its number in the figure.
fn with_measured(curve: Curve, variable: &str, factor: f64, measured: &[Measured]) -> Vec<Curve> {
    let dots = measured.iter().filter_map(|table| {
        let points = table.points(variable, factor)?;
        let name = format!("{}, {}", curve.name, table.label);
        Some(Curve { name, colour: curve.colour, look: Look::Dots, points })
    });
    let dots: Vec<Curve> = dots.collect();
    std::iter::once(curve).chain(dots).collect()
}

/// All figures for which the recording has data, the most important first; measured values are dots.
pub fn figures(recording: &Recording, measured: &[Measured]) -> Vec<Named> {
    let history = &recording.history;
    let over_time = |values: &[f64], factor: f64| -> Vec<[f64; 2]> {
        history.time_s.iter().zip(values).map(|(time_s, value)| [*time_s, factor * value]).collect()
    };
    let scene = &recording.scene;
    let named = |(what, y_label): (&str, &str), curves: Vec<Curve>| Figure {
        title: format!("{}: {what}", scene.name),
        x_label: "time (s)".to_owned(),
        y_label: y_label.to_owned(),
        curves,
        marks: marks(recording),
        ..Figure::default()
    };
    let of_joints = |travel: Travel, values: &[Vec<f64>], factor: f64, variable: &str| -> Vec<Curve> {
        let joints = scene.joints.iter().zip(&scene.travels).zip(values);
        let own = joints.filter(|((_, other), _)| **other == travel).enumerate();
        own.flat_map(|(n, (((name, _), _), values))| {
            let curve = Curve::nth(n, name, over_time(values, factor));
            with_measured(curve, &format!("{name}.{}", travel.words(variable)), factor, measured)
        })
        .collect()
    };
    let coordinates = |travel: Travel| of_joints(travel, &history.angles_rad, travel.shown(1.0), "angle");
    let efforts = |travel: Travel| of_joints(travel, &history.torques_n_m, 1.0, "total_torque");
    let gauges = scene.gauges.iter().zip(&history.gauges).enumerate();
    let strains = gauges.flat_map(|(n, (gauge, strain))| {
        let curve = Curve::nth(n, &gauge.name, over_time(strain, 1e3));
        with_measured(curve, &format!("gauge.{}.strain", gauge.name), 1e3, measured)
    });
    let components = |what: &str, values: &[Vector3<f64>], variable: &str, from: usize| -> Vec<Curve> {
        let component = |axis: usize| {
            let values: Vec<f64> = values.iter().map(|value| value[axis]).collect();
            let name = if what.is_empty() { AXES[axis].to_owned() } else { format!("{what} {}", AXES[axis]) };
            with_measured(
                Curve::nth(from + axis, name, over_time(&values, 1.0)),
                &format!("{variable}.{}", AXES[axis]),
                1.0,
                measured,
            )
        };
        (0..3).flat_map(component).collect()
    };
    let single = scene.tips.len() == 1;
    let tips = scene.tips.iter().zip(&history.tips_m).enumerate().flat_map(|(n, (name, path))| {
        let (what, variable) = if single { ("", "tip".to_owned()) } else { (name.as_str(), format!("tip.{name}")) };
        components(what, path, &format!("{variable}.position"), 3 * n)
    });
    let air = if history.air_n.iter().all(|force| *force == Vector3::zeros()) { &[][..] } else { &history.air_n };
    let air = if air.is_empty() { Vec::new() } else { components("", air, "air", 0) };
    let energies = ENERGIES.iter().enumerate().map(|(n, (name, value))| {
        Curve::nth(n, *name, over_time(&history.energies.iter().map(value).collect::<Vec<_>>(), 1.0))
    });
    let plots = [
        named(("fold angles", "fold angle (°)"), coordinates(Travel::Rotation)),
        named(("torques of motors, springs and inputs", "torque on the outer body (N·m)"), efforts(Travel::Rotation)),
        named(("tips", "position, root frame (m)"), tips.collect()),
        named(("moment on the root", "moment, root frame (N·m)"), components("", &history.root_n_m, "root.moment", 0)),
        named(("strains of the gauges", "strain (10⁻³)"), strains.collect()),
        named(("total aerodynamic force at the load stations", "force, root frame (N)"), air),
        named(("energies", "energy (J)"), energies.collect()),
        tip_path(recording),
        shapes(recording),
        named(("positions of slides", "position (m)"), coordinates(Travel::Translation)),
        named(("forces of motors, springs and inputs", "force on the joint's body (N)"), efforts(Travel::Translation)),
    ];
    NAMES.into_iter().zip(plots).filter(|(_, figure)| !figure.curves.is_empty()).collect()
}

/// Name of the file of [`overview`].
pub const OVERVIEW: &str = "overview";

/// Figures of an overview in their order, with shorter labels of the vertical axes, which have less space there.
const PANELS: [(&str, &str); 8] = [
    ("fold_angles", "angle (°)"),
    ("positions", "position (m)"),
    ("shapes", ""),
    ("tips", "position (m)"),
    ("strains", "strain (10⁻³)"),
    ("root_moment", "moment (N·m)"),
    ("air_force", "force (N)"),
    ("energies", "energy (J)"),
];

/// Width of an overview and height of a row of it, in user units: 180 mm, the width of a page of two columns.
const OVERVIEW_SIZE: [u32; 2] = [680, 236];

/// The figures of a run on one sheet with letters of 8 points; `None` if there are none.
pub fn overview(name: &str, figures: &[Named]) -> Option<Figure> {
    let panel = |(wanted, y_label): &(&str, &str)| {
        let (_, figure) = figures.iter().find(|(name, _)| name == wanted)?;
        let mut panel = figure.clone();
        panel.title = figure.title.rsplit(": ").next().unwrap_or_default().to_owned();
        panel.x_label = figure.x_label.replace(", root frame", "");
        panel.y_label =
            if y_label.is_empty() { figure.y_label.replace(", root frame", "") } else { (*y_label).to_owned() };
        Some(panel)
    };
    let panels: Vec<Figure> = PANELS.iter().filter_map(panel).collect();
    let rows = (panels.len() as u32).div_ceil(2);
    let own_size = Some([OVERVIEW_SIZE[0], 20 + rows * OVERVIEW_SIZE[1]]);
    let sheet = Figure { title: name.to_owned(), panels, columns: 2, own_size, ..Figure::default() };
    (rows > 0).then_some(sheet)
}

type Energy = fn(&EnergyOutputs) -> f64;

/// Energies with their names.
const ENERGIES: [(&str, Energy); 7] = [
    ("kinetic", |energy| energy.kinetic),
    ("elastic", |energy| energy.elastic),
    ("gravity", |energy| energy.gravity),
    ("motor", |energy| energy.motor),
    ("work of inputs", |energy| energy.work),
    ("dissipated", |energy| energy.dissipated),
    ("total", |energy| energy.total),
];

/// Events of the run in order: latches that closed or opened, joints released or locked, gusts; times in s with labels.
pub fn marks(recording: &Recording) -> Vec<(f64, String)> {
    let times = &recording.history.time_s;
    let (Some(first_s), Some(last_s)) = (times.first(), times.last()) else { return Vec::new() };
    let within = recording.watch.events.iter().filter(|event| (*first_s..=*last_s).contains(&event.time_s));
    let mut marks: Vec<_> = within.map(|event| mark(event.time_s, &event.text)).collect();
    marks.sort_by(|a, b| a.0.total_cmp(&b.0));
    marks
}

/// A time with its label.
fn mark(time_s: f64, what: &str) -> (f64, String) {
    (time_s, format!("{what}, {time_s:.4} s"))
}

/// The two axes along which the points have the largest spread; the vertical one is second.
fn plane<'a>(points: impl Iterator<Item = &'a Vector3<f64>>) -> [usize; 2] {
    let (mut least, mut most) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    for point in points {
        least = least.inf(point);
        most = most.sup(point);
    }
    let span = most - least;
    let flattest = (0..3).min_by(|&i, &j| span[i].total_cmp(&span[j])).unwrap_or(1);
    match flattest {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

fn seen(recording: &Recording, what: &str, [across, up]: [usize; 2], curves: Vec<Curve>) -> Figure {
    Figure {
        title: format!("{}: {what}", recording.scene.name),
        x_label: format!("{} (m), root frame", AXES[across]),
        y_label: format!("{} (m), root frame", AXES[up]),
        curves,
        marks: Vec::new(),
        equal: true,
        ..Figure::default()
    }
}

/// Figure of the paths of the free ends in the plane of their largest motion, with their start points.
fn tip_path(recording: &Recording) -> Figure {
    let tips = &recording.history.tips_m;
    let axes = plane(tips.iter().flatten());
    let flat = |point: &Vector3<f64>| axes.map(|axis| point[axis]);
    let mut curves = Vec::new();
    for (n, (name, path)) in recording.scene.tips.iter().zip(tips).enumerate() {
        let path: Vec<[f64; 2]> = path.iter().map(flat).collect();
        let begin = Curve { points: path.first().copied().into_iter().collect(), ..Curve::nth(n, "", Vec::new()) };
        curves.extend([Curve::nth(n, name, path), begin]);
    }
    seen(recording, "tip paths (dot: start)", axes, curves)
}

/// Largest displacement of a section between two frames, in m.
fn moved_m(pair: &[Frame]) -> f64 {
    let sections = pair[0].sections.iter().flatten().zip(pair[1].sections.iter().flatten());
    sections.map(|(old, new)| (new.position_m - old.position_m).norm()).fold(0.0, f64::max)
}

/// Indices of at most `count` frames among `moved_m.len() + 1`, including the first and the last, between which the displacements are
/// equal; without motion, at equal intervals. `moved_m`: displacements from frame to frame in m.
fn by_motion(moved_m: &[f64], count: usize) -> Vec<usize> {
    let last = moved_m.len();
    let steps = count.min(last + 1).saturating_sub(1).max(1);
    let mut travelled_m = vec![0.0];
    travelled_m.extend(moved_m.iter().scan(0.0, |sum, moved| {
        *sum += moved;
        Some(*sum)
    }));
    let whole_m = travelled_m[last];
    let at = |i: usize| match whole_m > 0.0 {
        // so that round-off does not select the next frame
        true => travelled_m.partition_point(|m| *m < whole_m * i as f64 / steps as f64 * (1.0 - 1e-12)).min(last),
        false => last * i / steps,
    };
    let mut chosen: Vec<usize> = (0..steps).map(at).chain([last]).collect();
    chosen.dedup();
    chosen
}

/// Figure of the body axes at instants between which the displacements are equal, from blue (early) to red (late).
fn shapes(recording: &Recording) -> Figure {
    let frames = &recording.frames;
    let points = frames.iter().flat_map(|frame| frame.sections.iter().flatten().map(|section| &section.position_m));
    let axes = plane(points);
    let moved: Vec<f64> = frames.windows(2).map(moved_m).collect();
    let chosen = by_motion(&moved, SHAPES);
    let count = chosen.len();
    let curves = chosen.iter().map(|n| &frames[*n]).enumerate().flat_map(|(i, frame)| {
        let colour = hue(i as f64 / (count - 1).max(1) as f64);
        let body = move |(body, points): (usize, Vec<[f64; 2]>)| {
            let name = if body == 0 { format!("{:.4} s", frame.time_s) } else { String::new() };
            Curve { name, colour, look: Look::Line, points }
        };
        axis_lines(frame, axes).into_iter().enumerate().map(body)
    });
    seen(recording, "deformed shapes over time", axes, curves.collect())
}

fn axis_lines(frame: &Frame, axes: [usize; 2]) -> Vec<Vec<[f64; 2]>> {
    let flat = |sections: &Vec<_>| -> Vec<[f64; 2]> {
        sections
            .iter()
            .map(|section: &foldwing_engine::plant::SectionState| axes.map(|axis| section.position_m[axis]))
            .collect()
    };
    frame.sections.iter().map(flat).collect()
}

/// Colour scale from dark blue over violet and orange-red to gold, in an order that readers with red-green blindness can distinguish.
fn hue(fraction: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 4] = [[13.0, 8.0, 135.0], [126.0, 3.0, 168.0], [204.0, 71.0, 120.0], [240.0, 150.0, 50.0]];
    let place = fraction.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    let before = (place as usize).min(STOPS.len() - 2);
    std::array::from_fn(|i| {
        let [from, to] = [STOPS[before][i], STOPS[before + 1][i]];
        (from + (to - from) * (place - before as f64)).round() as u8
    })
}

/// Values of a variable over time.
#[derive(Debug, Clone, PartialEq)]
struct Column {
    name: String,
    /// Unit; empty for none.
    unit: String,
    values: Vec<f64>,
}

/// Variables over time, of a model or of an FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    time_s: Vec<f64>,
    columns: Vec<Column>,
    thinning: Thinning,
}

impl Series {
    /// Creates an empty series of variables with these names and units, for a run of `steps` steps.
    pub fn new<'a>(variables: impl IntoIterator<Item = (&'a str, &'a str)>, steps: u64) -> Self {
        let column = |(name, unit): (&str, &str)| Column { name: name.into(), unit: unit.into(), values: Vec::new() };
        let columns = variables.into_iter().map(column).collect();
        Self { time_s: Vec::new(), columns, thinning: Thinning::new(steps, MAXIMUM_POINTS) }
    }

    /// Adds the values of all variables, in order; NaN is not drawn.
    pub fn include(&mut self, time_s: f64, values: impl IntoIterator<Item = f64>) {
        if self.thinning.keeps() {
            self.time_s.push(time_s);
            self.columns.iter_mut().zip(values).for_each(|(column, value)| column.values.push(value));
        }
    }

    /// Changes of Boolean variables: times in s with labels. `is_switch` returns whether the variable with an index is Boolean; one that
    /// changes throughout the run is omitted. A latch is marked at its latch time if this is among the variables, other changes at the time
    /// of their row.
    pub fn marks(&self, is_switch: impl Fn(usize) -> bool) -> Vec<(f64, String)> {
        let mut marks = Vec::new();
        for (_, column) in self.columns.iter().enumerate().filter(|(number, _)| is_switch(*number)) {
            let changes = (1..column.values.len()).filter(|row| column.values[*row] != column.values[row - 1]);
            let changes: Vec<usize> = changes.collect();
            if changes.len() > MAXIMUM_CHANGES {
                continue;
            }
            let name = &column.name;
            let words = |on: bool| match (name.strip_suffix(".latched"), name.strip_suffix(".release"), on) {
                (Some(joint), _, true) => format!("{joint} latched"),
                (Some(joint), _, false) => format!("{joint} latch opened"),
                (_, Some(joint), true) => format!("{joint} released"),
                (_, Some(joint), false) => format!("{joint} held"),
                (None, None, true) => name.clone(),
                (None, None, false) => format!("{name} off"),
            };
            let told = name.strip_suffix(".latched").map(|joint| format!("{joint}.latch_time"));
            let told = self.columns.iter().find(|other| Some(&other.name) == told.as_ref());
            marks.extend(changes.into_iter().map(|row| {
                let on = column.values[row] != 0.0;
                let time_s = told.filter(|_| on).map_or(self.time_s[row], |told| told.values[row]);
                mark(time_s, &words(on))
            }));
        }
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        marks
    }

    /// Figures with one unit each, in the order of first appearance, and no more curves than can be distinguished.
    pub fn figures(&self, title: &str, measured: &[Measured], marks: &[(f64, String)]) -> Vec<Figure> {
        // omit infinite limits, which would compress everything else
        let drawn = self.columns.iter().filter(|column| column.values.iter().any(|value| value.abs() < UNLIMITED));
        let mut groups: Vec<(&str, Vec<&Column>)> = Vec::new();
        for column in drawn {
            let has_room = |(unit, group): &&mut (&str, Vec<&Column>)| *unit == column.unit && group.len() < CURVES;
            match groups.iter_mut().find(has_room) {
                Some((_, group)) => group.push(column),
                None => groups.push((&column.unit, vec![column])),
            }
        }
        groups.into_iter().map(|(unit, group)| self.figure(title, unit, &group, measured, marks)).collect()
    }

    fn figure(
        &self,
        title: &str,
        unit: &str,
        columns: &[&Column],
        measured: &[Measured],
        marks: &[(f64, String)],
    ) -> Figure {
        let points = |values: &[f64]| self.time_s.iter().zip(values).map(|(time_s, value)| [*time_s, *value]).collect();
        let curves = columns.iter().enumerate().flat_map(|(n, column)| {
            with_measured(Curve::nth(n, &column.name, points(&column.values)), &column.name, 1.0, measured)
        });
        // the axis label is the last part of the names, if all have it in common
        let last = |name: &str| name.rsplit('.').next().unwrap_or(name).replace('_', " ");
        let common = last(&columns[0].name);
        let quantity = match columns {
            [column] => column.name.clone(),
            columns if columns.iter().all(|column| last(&column.name) == common) => common,
            _ => quantity_of(unit).to_owned(),
        };
        Figure {
            title: title.to_owned(),
            x_label: "time (s)".to_owned(),
            y_label: match unit {
                "" => format!("{quantity} (–)"),
                unit => format!("{quantity} ({})", unit.replace('.', "·")),
            },
            curves: curves.collect(),
            marks: marks.to_vec(),
            ..Figure::default()
        }
    }
}

/// Axis label derived from the unit, if the curve names have nothing in common.
fn quantity_of(unit: &str) -> &'static str {
    match unit {
        "rad" => "angle",
        "rad/s" => "angular velocity",
        "rad/s2" => "angular acceleration",
        "m" => "length",
        "m/s" => "velocity",
        "m/s2" => "acceleration",
        "N" => "force",
        "N.m" => "moment",
        "J" => "energy",
        "W" => "power",
        "s" => "time",
        "kg" => "mass",
        _ => "value",
    }
}

#[cfg(test)]
mod tests {
    use super::{OVERVIEW_SIZE, by_motion, figures, overview};
    use crate::report::figure::Sheet;
    use crate::report::sample_tests::{recorded, shipped};

    /// For a wing that unfolds early and then no longer moves, the shapes are taken during the motion.
    #[test]
    fn shapes_are_at_instants_of_equal_motion() {
        let early: Vec<f64> = (0..100).map(|i| if i < 8 { 0.25 } else { 0.0 }).collect();
        assert_eq!(by_motion(&early, 9), [0, 1, 2, 3, 4, 5, 6, 7, 100]);
        let steady = vec![0.1; 80];
        assert_eq!(by_motion(&steady, 9), (0..9).map(|i| 10 * i).collect::<Vec<_>>());
        assert_eq!(by_motion(&[0.0; 16], 9), (0..9).map(|i| 2 * i).collect::<Vec<_>>());
        assert_eq!(by_motion(&[0.5, 0.5], 9), [0, 1, 2]);
        assert_eq!(by_motion(&[], 9), [0]);
    }

    /// The overview has the important figures of the run in their order, on a sheet of its own size; a mark has its label in each.
    #[test]
    fn overviews_have_the_figures_of_the_run() {
        let recording = recorded(shipped("folding_wing"), 160);
        let sheet = overview("wing", &figures(&recording, &[])).expect("figures");
        let titles: Vec<&str> = sheet.panels.iter().map(|panel| panel.title.as_str()).collect();
        let expected = [
            "fold angles",
            "deformed shapes over time",
            "tips",
            "strains of the gauges",
            "moment on the root",
            "energies",
        ];
        assert_eq!(titles, expected);
        let svg = sheet.svg(Sheet::default()).expect("a sheet");
        let size = format!("width=\"{}\" height=\"{}\"", OVERVIEW_SIZE[0], 20 + 3 * OVERVIEW_SIZE[1]);
        assert!(svg.contains(&size) && svg.trim_end().ends_with("</svg>"), "{}", &svg[..200]);
        assert_eq!(svg.matches("</svg>").count(), 1);
        assert_eq!(svg.matches("fold latched, ").count(), 5, "each figure over time");
        // names, titles and axes stay on their panels
        for title in expected {
            assert_eq!(svg.matches(title).count(), 1, "{title}");
        }
        assert!(overview("nothing", &[]).is_none());
    }
}

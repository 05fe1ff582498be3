//! Surroundings of the model: a numbered grid on the ground, the axes of the root frame, title, clock, colour scales.

use super::colours::{self, Rgb, Scale, tint};
use super::drawing::{Drawing, Label, Line};
use super::letters::{Anchor, Letters};
use super::raster::Raster;
use crate::report::film::machine::Measures;
use crate::report::film::run::{Extents, Run, Vector};

/// Opacity of the background of a colour scale.
const FAINT_BEHIND: f32 = 0.82;

/// Ground and axes, identical in all images of a video.
#[derive(Debug)]
pub(super) struct Stage {
    floor_m: f64,
    grid: Vec<Line>,
    axes: Vec<Line>,
    labels: Vec<Label>,
}

impl Stage {
    /// Creates a grid below the model with a round spacing, numbered in metres, and the axes of the root frame.
    pub fn new(extents: Extents, width_m: f64) -> Self {
        let size = extents.size();
        let floor_m = extents.least.z - 0.06 * size;
        let spacing = rounded_up(size / 7.0);
        let end = |i: usize, upper: bool| {
            let reach = if upper { extents.most[i] + 0.04 * size } else { extents.least[i] - 0.04 * size };
            let steps = reach / spacing;
            spacing * if upper { (steps - 1e-9).ceil() } else { (steps - 1e-9).floor() }
        };
        let (from, to) = ([end(0, false), end(1, false)], [end(0, true), end(1, true)]);
        let digits = (-(spacing.log10() + 1e-9).floor()).max(0.0) as usize;
        let mut stage = Self { floor_m, grid: Vec::new(), axes: Vec::new(), labels: Vec::new() };
        for i in [0, 1] {
            let count = ((to[i] - from[i]) / spacing).round() as usize;
            for step in 0..=count {
                let value = from[i] + step as f64 * spacing;
                let at = |other: f64| {
                    if i == 0 { Vector::new(value, other, floor_m) } else { Vector::new(other, value, floor_m) }
                };
                let ends = [at(from[1 - i]), at(to[1 - i])];
                stage.grid.push(Line { ends, rgb: colours::GRID, opacity: 0.9, width: 1.0 });
                let beside = if i == 0 { from[1] - 0.3 * spacing } else { to[0] + 0.3 * spacing };
                let unit = if step == count { " m" } else { "" };
                let text = format!("{}{unit}", number(value, digits));
                stage.labels.push(Label { at: at(beside), text, height: 11.0, rgb: colours::FAINT, on_top: false });
            }
        }
        for (i, name) in ["x", "y", "z"].into_iter().enumerate() {
            let end = Vector::ith(i, 0.14 * width_m);
            let rgb = colours::AXES[i];
            stage.axes.push(Line { ends: [Vector::zeros(), end], rgb, opacity: 1.0, width: 1.5 });
            stage.labels.push(Label { at: 1.15 * end, text: name.to_owned(), height: 14.0, rgb, on_top: true });
        }
        stage
    }

    /// Adds grid and axes to an image.
    pub fn add(&self, into: &mut Drawing) {
        into.floor_m = Some(self.floor_m);
        into.grid.extend(&self.grid);
        into.lines.extend(&self.axes);
        into.labels.extend(self.labels.iter().cloned());
    }
}

/// Rounds a length up to 1, 2 or 5 times a power of ten.
fn rounded_up(length: f64) -> f64 {
    let power = 10.0_f64.powf(length.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    power * steps.into_iter().find(|step| step * power >= 0.999 * length).unwrap_or(10.0)
}

/// Formats a number with a typographic minus sign, which is omitted for zero.
pub(super) fn number(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    let is_zero = text.chars().all(|letter| matches!(letter, '-' | '0' | '.'));
    if is_zero { text.replace('-', "") } else { text.replace('-', "\u{2212}") }
}

/// Number of decimals with which the largest value has the requested number of digits.
fn digits_for(largest: f64, wanted: i32) -> usize {
    let largest = if largest > 0.0 { largest } else { 1.0 };
    usize::try_from((wanted - 1 - largest.log10().floor() as i32).clamp(0, 9)).unwrap_or(0)
}

/// Creates the title with the clock at the top, and the colour scales at the bottom; `unit` is the number of pixels per
/// unit.
pub(super) fn lettering(run: &Run, measures: &Measures, time_s: f64, (size, unit): ([u32; 2], f64)) -> Overlay {
    let mut overlay = Overlay { texts: Vec::new(), bars: Vec::new(), unit };
    let title = format!("{}   t = {} s", run.about.name, number(time_s, 4));
    overlay.text(&title, [14.0, 26.0], 15.0, Anchor::Left);
    let bottom = f64::from(size[1]) / unit - 14.0;
    let mut left = 14.0;
    let mut scale = |title: &str, scale: &'static Scale, most: f64, wanted: i32| {
        let digits = digits_for(most, wanted);
        overlay.bars.push(Bar { at: [left, bottom - 25.0], size: [200.0, 10.0], scale });
        overlay.text(title, [left, bottom - 30.0], 13.0, Anchor::Left);
        for (value, along, anchor) in
            [(-most, 0.0, Anchor::Left), (0.0, 100.0, Anchor::Middle), (most, 200.0, Anchor::Right)]
        {
            overlay.text(&number(value, digits), [left + along, bottom], 13.0, anchor);
        }
        left += 230.0;
    };
    if measures.has_strain(run) {
        scale("longitudinal strain (µm/m)", &colours::STRAIN, 1e6 * measures.strain, 3);
    }
    if measures.circulation_m2_s > 0.0 {
        scale("circulation (m²/s)", &colours::CIRCULATION, measures.circulation_m2_s, 2);
    }
    overlay
}

/// Texts and colour scales drawn over the image.
pub(super) struct Overlay {
    texts: Vec<(String, [f64; 2], f64, Anchor)>,
    bars: Vec<Bar>,
    unit: f64,
}

/// Bar of a colour scale: upper left corner and size in units.
struct Bar {
    at: [f64; 2],
    size: [f64; 2],
    scale: &'static Scale,
}

impl Overlay {
    fn text(&mut self, text: &str, at: [f64; 2], height: f64, anchor: Anchor) {
        self.texts.push((text.to_owned(), at, height, anchor));
    }

    /// Draws the overlay in front of everything.
    pub fn draw(&self, letters: &Letters, raster: &mut Raster) {
        for Bar { at: [left, top], size: [wide, _], .. } in &self.bars {
            // as on the page, the background of a scale is faint
            let [from, to] = [[left - 6.0, top - 24.0], [left + wide + 6.0, top + 31.0]]
                .map(|corner| corner.map(|place| (place * self.unit).round() as i64));
            for y in from[1]..to[1] {
                (from[0]..to[0]).for_each(|x| raster.dot([x, y], f64::INFINITY, colours::BACKGROUND, FAINT_BEHIND));
            }
        }
        for bar in &self.bars {
            let [left, top] = bar.at.map(|place| (place * self.unit).round() as i64);
            let [wide, high] = bar.size.map(|length| (length * self.unit).round() as i64);
            for x in 0..wide {
                let rgb: Rgb = tint(bar.scale, x as f64 / (wide - 1).max(1) as f64);
                (0..high).for_each(|y| raster.dot([left + x, top + y], f64::INFINITY, rgb, 1.0));
            }
        }
        for (text, at, height, anchor) in &self.texts {
            let place = at.map(|place| place * self.unit);
            letters.draw(text, place, (height * self.unit, *anchor), (f64::INFINITY, colours::TEXT), raster);
        }
    }
}

//! Names of curves and labels of marks around a chart.

use super::ends::spread;
use super::layout::{self, Layout};
use super::{Chart, Curve, Drawn, FAINT, Figure, INK, Look, UNIT, at, colour, line, short, style};
use plotters::coord::Shift;
use plotters::prelude::{Circle, Color, DashedLineSeries, DrawingArea, DrawingBackend, PathElement};
use plotters::style::text_anchor::{HPos, VPos};
use std::ops::Range;

/// Height of a name's line at the end of a curve, in user units.
const NAME_LINE: u32 = 17;

impl Figure {
    /// Dashed lines at the marks, with labels above the chart that do not overlap; labels without space are omitted.
    pub(super) fn draw_marks<B: DrawingBackend>(
        &self,
        size: [u32; 2],
        area: &DrawingArea<B, Shift>,
        chart: &mut Chart<'_, B>,
        y: &Range<f64>,
    ) -> Drawn<B> {
        let mut labels = Vec::new();
        for (x, label) in &self.marks {
            let ends = [(*x, y.start), (*x, y.end)];
            chart.draw_series(DashedLineSeries::new(ends, 6 * UNIT, 4 * UNIT, line(FAINT, 1.2)))?;
            let (pixel, _) = chart.backend_coord(&ends[1]);
            labels.push((f64::from(pixel - area.get_base_pixel().0), pixel, label));
        }
        let layout = Layout::of(size, self);
        let longest = labels.iter().map(|(_, _, label)| label.chars().count()).max().unwrap_or_default();
        let wide = f64::from(layout.letter) * longest as f64;
        let range = [f64::from(layout.border * UNIT), f64::from((size[0] - layout.border) * UNIT)];
        labels.truncate(((range[1] - range[0]) / wide.max(1.0)) as usize);
        spread(&mut labels, wide, [range[0] + 0.5 * wide, range[1] - 0.5 * wide]);
        for (place, _, label) in labels {
            let label_style = style(layout.small, &FAINT, HPos::Center, VPos::Center);
            area.draw_text(
                label,
                &label_style,
                (place as i32, at(0, layout.border + layout.top() - layout.small * 2 / 3).1),
            )?;
        }
        Ok(())
    }

    /// The name of every curve at its end, in its colour, without overlap.
    pub(super) fn draw_names<B: DrawingBackend>(
        &self,
        size: [u32; 2],
        area: &DrawingArea<B, Shift>,
        chart: &Chart<'_, B>,
    ) -> Drawn<B> {
        let layout = Layout::of(size, self);
        let base = area.get_base_pixel().1;
        let last = |curve: &&Curve| curve.points.iter().rfind(|point| point.iter().all(|c| c.is_finite())).copied();
        let named = self.curves.iter().filter(|curve| !curve.name.is_empty());
        let mut ends: Vec<(f64, i32, &Curve)> = named
            .filter_map(|curve| {
                let [x, y] = last(&curve)?;
                let pixel = chart.backend_coord(&(x, y)).1 - base;
                Some((f64::from(pixel), pixel, curve))
            })
            .collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (top, bottom) =
            (f64::from((layout.border + layout.title) * UNIT), f64::from((size[1] - layout.border) * UNIT));
        let apart = f64::from(NAME_LINE * UNIT).min((bottom - top) / ends.len().max(1) as f64);
        spread(&mut ends, apart, [top, bottom]);
        let left = (size[0] - layout.names - layout.border) * UNIT;
        for (y, end, curve) in &ends {
            let (from, to) = ((left + 3 * UNIT) as i32, (left + 15 * UNIT) as i32);
            area.draw(&PathElement::new(vec![(from, *end), (to, *y as i32)], line(colour(curve), 0.9)))?;
            let ink = colour(curve);
            let text = style(13, &INK, HPos::Left, VPos::Center).color(&ink);
            area.draw_text(&short(&curve.name), &text, (to + (4 * UNIT) as i32, *y as i32))?;
        }
        Ok(())
    }

    /// Names with their strokes at the right.
    pub(super) fn draw_legend<B: DrawingBackend>(&self, size: [u32; 2], area: &DrawingArea<B, Shift>) -> Drawn<B> {
        let named = self.curves.iter().filter(|curve| !curve.name.is_empty());
        for (row, curve) in named.enumerate() {
            let y = layout::WIDE.top() + layout::WIDE.border + 12 + 22 * row as u32;
            if y + 22 > size[1] {
                break; // a figure with this many curves is read from its file, not from its legend
            }
            let stroke = line(colour(curve), 2.2);
            match curve.look {
                _ if curve.points.len() == 1 => area.draw(&Circle::new(at(14, y), 4 * UNIT, colour(curve).filled()))?,
                Look::Dots => area.draw(&Circle::new(at(14, y), 3 * UNIT, colour(curve).filled()))?,
                Look::Dashed => {
                    area.draw(&PathElement::new(vec![at(2, y), at(11, y)], stroke))?;
                    area.draw(&PathElement::new(vec![at(17, y), at(26, y)], stroke))?;
                }
                Look::Line => area.draw(&PathElement::new(vec![at(2, y), at(26, y)], stroke))?,
            }
            let text = style(13, &INK, HPos::Left, VPos::Center);
            area.draw_text(&short(&curve.name), &text, at(34, y))?;
        }
        Ok(())
    }

    /// Names with their strokes in rows between title and chart.
    pub(super) fn draw_rows<B: DrawingBackend>(
        &self,
        layout: &Layout,
        size: [u32; 2],
        area: &DrawingArea<B, Shift>,
    ) -> Drawn<B> {
        for ([x, row], curve) in layout::rows(self, size) {
            if row >= layout.rows {
                break; // a figure with this many curves is read from its file, not from its legend
            }
            let y = layout.border + layout.title + layout::ROW * row + layout::ROW / 2;
            let stroke = line(colour(curve), 1.8);
            let (from, to) = (at(x, y), at(x + layout::STROKE, y));
            match curve.look {
                Look::Dots => {
                    area.draw(&Circle::new(at(x + layout::STROKE / 2, y), 3 * UNIT, colour(curve).filled()))?
                }
                Look::Dashed => {
                    area.draw(&PathElement::new(vec![from, at(x + 6, y)], stroke))?;
                    area.draw(&PathElement::new(vec![at(x + 10, y), to], stroke))?;
                }
                Look::Line => area.draw(&PathElement::new(vec![from, to], stroke))?,
            }
            let text = style(layout.text, &INK, HPos::Left, VPos::Center);
            area.draw_text(&short(&curve.name), &text, at(x + layout::STROKE + 4, y))?;
        }
        Ok(())
    }
}

//! Rasteriser of triangles, lines and text: four samples per pixel, each with a separate depth.
//!
//! Depth is the inverse of the distance from the plane of the eye, which is linear over the image. A face covers another one only if it
//! is nearer by more than round-off, so that of two coplanar faces the one drawn first remains visible, without flicker.

/// Positions of the samples in a pixel, each in a different row and column.
const SAMPLES: [[f64; 2]; 4] = [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];
/// Relative difference of inverse distances up to which two faces count as coplanar.
const SAME_PLANE: f32 = 2e-6;

/// Vertex of a triangle: position in pixels, inverse distance in 1/m, colour from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corner {
    pub x: f64,
    pub y: f64,
    pub near: f64,
    pub rgb: [f32; 3],
}

/// Rule for combining a triangle with the pixels behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Ink {
    /// Covers the pixels behind it.
    Solid,
    /// Is blended with this opacity, from 0 to 1; does not cover objects drawn later.
    Glass(f32),
    /// Is blended with this opacity, at most once per image.
    Shadow(f32),
}

/// An image under construction.
pub(super) struct Raster {
    width: usize,
    height: usize,
    depth: Vec<[f32; 4]>,
    colour: Vec<[u32; 4]>,
    in_shadow: Vec<u8>,
}

/// Linear function of the position in the image.
#[derive(Clone, Copy)]
struct Plane {
    at_origin: f64,
    by_x: f64,
    by_y: f64,
}

impl Plane {
    fn through(corners: &[Corner; 3], twice_area: f64, values: [f64; 3]) -> Self {
        let [a, b, c] = corners;
        let (u, v) = (values[1] - values[0], values[2] - values[0]);
        let by_x = (u * (c.y - a.y) - v * (b.y - a.y)) / twice_area;
        let by_y = (v * (b.x - a.x) - u * (c.x - a.x)) / twice_area;
        Self { at_origin: values[0] - by_x * a.x - by_y * a.y, by_x, by_y }
    }

    fn at(&self, x: f64, y: f64) -> f64 {
        self.at_origin + self.by_x * x + self.by_y * y
    }
}

/// Edge function of a triangle: not negative inside; exactly opposite for the triangle on the other side of the edge.
#[derive(Clone, Copy)]
struct Edge(Plane);

impl Edge {
    fn of(a: &Corner, b: &Corner) -> Self {
        Self(Plane { at_origin: a.x * b.y - b.x * a.y, by_x: a.y - b.y, by_y: b.x - a.x })
    }

    /// Narrows an interval of x in a row of pixels to where a sample may be inside.
    fn narrow(&self, row: f64, [from, to]: [f64; 2]) -> [f64; 2] {
        let Plane { at_origin, by_x, by_y } = self.0;
        // the largest value in the row
        let along = at_origin + by_y * if by_y > 0.0 { row + 1.0 } else { row };
        if by_x > 0.0 {
            [from.max(-along / by_x - 1.0), to]
        } else if by_x < 0.0 {
            [from, to.min(-along / by_x + 1.0)]
        } else if along < 0.0 {
            [1.0, 0.0]
        } else {
            [from, to]
        }
    }
}

fn packed(rgb: [f32; 3]) -> u32 {
    let [red, green, blue] = rgb.map(|part| (255.0 * part.clamp(0.0, 1.0) + 0.5) as u32);
    red << 16 | green << 8 | blue
}

fn parts(colour: u32) -> [f32; 3] {
    [colour >> 16 & 255, colour >> 8 & 255, colour & 255].map(|part| part as f32 / 255.0)
}

fn over(below: u32, rgb: [f32; 3], opacity: f32) -> u32 {
    let below = parts(below);
    packed(std::array::from_fn(|i| below[i] + opacity * (rgb[i] - below[i])))
}

impl Raster {
    /// Allocates an image.
    pub fn new([width, height]: [u32; 2]) -> Self {
        let (width, height) = (width as usize, height as usize);
        let count = width * height;
        Self { width, height, depth: vec![[0.0; 4]; count], colour: vec![[0; 4]; count], in_shadow: vec![0; count] }
    }

    /// Fills the image with the background colour.
    pub fn clear(&mut self, background: [f32; 3]) {
        self.depth.fill([0.0; 4]);
        self.colour.fill([packed(background); 4]);
        self.in_shadow.fill(0);
    }

    /// Draws a triangle; one with vertices that are not finite is omitted.
    pub fn triangle(&mut self, corners: [Corner; 3], ink: Ink) {
        let [a, b, c] = corners;
        let twice_area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if !twice_area.is_finite() || twice_area == 0.0 {
            return;
        }
        if twice_area < 0.0 {
            return self.triangle([a, c, b], ink);
        }
        let edges = [Edge::of(&a, &b), Edge::of(&b, &c), Edge::of(&c, &a)];
        let near = Plane::through(&corners, twice_area, corners.map(|corner| corner.near));
        let flat = a.rgb == b.rgb && b.rgb == c.rgb;
        let shades: [Plane; 3] =
            std::array::from_fn(|i| Plane::through(&corners, twice_area, corners.map(|corner| corner.rgb[i].into())));
        let ends: [[f32; 2]; 3] = std::array::from_fn(|i| {
            let [a, b, c] = corners.map(|corner| corner.rgb[i]);
            [a.min(b).min(c), a.max(b).max(c)]
        });
        let least = |of: fn(&Corner) -> f64| corners.iter().map(of).fold(f64::INFINITY, f64::min);
        let most = |of: fn(&Corner) -> f64| corners.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        let span = [least(|corner| corner.x).floor().max(0.0), most(|corner| corner.x).ceil().min(self.width as f64)];
        let rows = [least(|corner| corner.y).floor().max(0.0), most(|corner| corner.y).ceil().min(self.height as f64)];
        for row in rows[0] as usize..rows[1].max(0.0) as usize {
            let y = row as f64;
            let [from, to] = edges.iter().fold(span, |span, edge| edge.narrow(y, span));
            for column in from.max(0.0) as usize..(to.ceil().max(0.0) as usize).min(self.width) {
                let x = column as f64;
                let covered = |[right, down]: [f64; 2]| edges.iter().all(|edge| edge.0.at(x + right, y + down) >= 0.0);
                let inside = SAMPLES.map(covered);
                if inside == [false; 4] {
                    continue;
                }
                let rgb = if flat {
                    a.rgb
                } else {
                    std::array::from_fn(|i| (shades[i].at(x + 0.5, y + 0.5) as f32).clamp(ends[i][0], ends[i][1]))
                };
                let nears = SAMPLES.map(|[right, down]| near.at(x + right, y + down) as f32);
                self.mix(row * self.width + column, inside, nears, rgb, ink);
            }
        }
    }

    fn mix(&mut self, pixel: usize, inside: [bool; 4], nears: [f32; 4], rgb: [f32; 3], ink: Ink) {
        let (depth, colour) = (&mut self.depth[pixel], &mut self.colour[pixel]);
        let solid = packed(rgb);
        let seen: [bool; 4] =
            std::array::from_fn(|sample| inside[sample] && nears[sample] > depth[sample] * (1.0 + SAME_PLANE));
        if let Ink::Glass(opacity) = ink
            && seen == [true; 4]
            && colour.iter().all(|other| *other == colour[0])
        {
            *colour = [over(colour[0], rgb, opacity); 4]; // all four samples have the same colour
            return;
        }
        for sample in (0..4).filter(|sample| seen[*sample]) {
            match ink {
                Ink::Solid => {
                    depth[sample] = nears[sample];
                    colour[sample] = solid;
                }
                Ink::Glass(opacity) => colour[sample] = over(colour[sample], rgb, opacity),
                Ink::Shadow(opacity) => {
                    let bit = 1 << sample;
                    if self.in_shadow[pixel] & bit == 0 {
                        self.in_shadow[pixel] |= bit;
                        colour[sample] = over(colour[sample], rgb, opacity);
                    }
                }
            }
        }
    }

    /// Draws a line with a width in pixels.
    pub fn line(&mut self, [a, b]: [Corner; 2], width: f64, ink: Ink) {
        let (dx, dy) = (b.x - a.x, b.y - a.y);
        let length = dx.hypot(dy);
        if length.is_nan() || length <= 1e-9 {
            return;
        }
        let (right, down) = (-0.5 * width * dy / length, 0.5 * width * dx / length);
        let off =
            |corner: Corner, side: f64| Corner { x: corner.x + side * right, y: corner.y + side * down, ..corner };
        self.triangle([off(a, -1.0), off(b, -1.0), off(b, 1.0)], ink);
        self.triangle([off(a, -1.0), off(b, 1.0), off(a, 1.0)], ink);
    }

    /// Blends a colour into a pixel; `near` is the inverse distance of the object, infinite if it is in front of everything.
    pub fn dot(&mut self, [x, y]: [i64; 2], near: f64, rgb: [f32; 3], opacity: f32) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.width && y < self.height {
            self.mix(y * self.width + x, [true; 4], [near as f32; 4], rgb, Ink::Glass(opacity));
        }
    }

    /// Returns the image as red, green and blue per pixel, row by row.
    pub fn pixels(&self) -> Vec<u8> {
        let mut pixels = Vec::with_capacity(3 * self.colour.len());
        for samples in &self.colour {
            let [a, b, c, d] = *samples;
            if a == b && b == c && c == d {
                pixels.extend([(a >> 16) as u8, (a >> 8) as u8, a as u8]);
                continue;
            }
            let mean = |shift: u32| (samples.iter().map(|sample| sample >> shift & 255).sum::<u32>() + 2) / 4;
            pixels.extend([mean(16) as u8, mean(8) as u8, mean(0) as u8]);
        }
        pixels
    }
}

#[cfg(test)]
#[path = "raster_tests.rs"]
mod tests;

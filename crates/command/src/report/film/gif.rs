//! GIF files: one palette for the whole video, and in every frame only the pixels that changed.

use gif::{AnyExtension, DisposalMethod, Encoder, EncodingError, Frame, Repeat};

/// Number of colours of the palette; the last index is transparent.
const COLOURS: usize = 255;
/// Bits per channel of the colour histogram.
const BITS: u32 = 6;

/// Video as GIF in an endless loop.
pub struct Gif {
    encoder: Encoder<Vec<u8>>,
    size: [u32; 2],
    palette: Vec<[u8; 3]>,
    /// Palette index for each colour of the histogram; larger numbers where it is not yet known.
    nearest: Vec<u16>,
    /// Indices of the previous frame.
    before: Option<Vec<u8>>,
    frames_per_s: f64,
    frames: u32,
}

impl Gif {
    /// The first bytes of a file.
    pub const BEGINS: &[u8] = b"GIF89a";
    /// Text near the beginning of a file.
    pub const MARK: &[u8] = b"made by foldwing";
    /// Maximum frame rate in 1/s: players slow down shorter frames.
    pub const MAXIMUM_PER_S: f64 = 50.0;
    /// Maximum width and height in pixels.
    pub const MAXIMUM_SIZE: u32 = 65_535;

    /// Creates a video whose palette is selected from some of its frames.
    ///
    /// # Errors
    /// The size is too large for the format.
    pub fn new(size: [u32; 2], frames_per_s: f64, some: &[Vec<u8>]) -> Result<Self, EncodingError> {
        let palette = palette(some);
        let too_large = |_| EncodingError::Io(std::io::Error::other("the frame is too large for a GIF"));
        let width = u16::try_from(size[0]).map_err(too_large)?;
        let height = u16::try_from(size[1]).map_err(too_large)?;
        let mut encoder = Encoder::new(Vec::new(), width, height, palette.as_flattened())?;
        encoder.write_raw_extension(AnyExtension(0xfe), &[Self::MARK])?;
        encoder.set_repeat(Repeat::Infinite)?;
        let nearest = vec![u16::MAX; 1 << (3 * BITS)];
        Ok(Self { encoder, size, palette, nearest, before: None, frames_per_s, frames: 0 })
    }

    /// Appends a frame: red, green and blue per pixel, row by row.
    ///
    /// # Errors
    /// None, since it writes to memory.
    pub fn add(&mut self, pixels: &[u8]) -> Result<(), EncodingError> {
        let indices: Vec<u8> = pixels.chunks_exact(3).map(|rgb| self.index([rgb[0], rgb[1], rgb[2]])).collect();
        let width = self.size[0] as usize;
        let [rows, columns] = match &self.before {
            Some(before) => changed(before, &indices, width),
            None => [0..self.size[1] as usize, 0..width],
        };
        let mut buffer = Vec::with_capacity(rows.len() * columns.len());
        for row in rows.clone() {
            for pixel in row * width + columns.start..row * width + columns.end {
                let same = self.before.as_ref().is_some_and(|before| before[pixel] == indices[pixel]);
                buffer.push(if same { COLOURS as u8 } else { indices[pixel] });
            }
        }
        // durations in hundredths of a second, rounded so that their sum is correct
        let end = |frames: u32| (f64::from(frames) * 100.0 / self.frames_per_s).round();
        let frame = Frame {
            delay: (end(self.frames + 1) - end(self.frames)) as u16,
            dispose: DisposalMethod::Keep,
            transparent: self.before.is_some().then_some(COLOURS as u8),
            left: columns.start as u16,
            top: rows.start as u16,
            width: columns.len() as u16,
            height: rows.len() as u16,
            buffer: buffer.into(),
            ..Frame::default()
        };
        self.encoder.write_frame(&frame)?;
        self.before = Some(indices);
        self.frames += 1;
        Ok(())
    }

    /// Returns the finished file.
    ///
    /// # Errors
    /// None, since it writes to memory.
    pub fn finish(self) -> Result<Vec<u8>, EncodingError> {
        self.encoder.into_inner()
    }

    fn index(&mut self, rgb: [u8; 3]) -> u8 {
        let cell = cell(rgb);
        if self.nearest[cell] == u16::MAX {
            let middle = colour_of(cell);
            let far = |colour: &[u8; 3]| -> i32 {
                // weights of the channels in human vision
                (0..3).map(|i| [2, 4, 1][i] * (i32::from(colour[i]) - i32::from(middle[i])).pow(2)).sum()
            };
            let found = self.palette[..COLOURS].iter().enumerate().min_by_key(|(_, colour)| far(colour));
            self.nearest[cell] = found.map_or(0, |(index, _)| index as u16);
        }
        self.nearest[cell] as u8
    }
}

fn cell(rgb: [u8; 3]) -> usize {
    rgb.iter().fold(0, |cell, part| cell << BITS | usize::from(part >> (8 - BITS)))
}

/// Colour at the middle of a histogram cell; the outermost cells are black and white.
fn colour_of(cell: usize) -> [u8; 3] {
    let most = (1 << BITS) - 1;
    std::array::from_fn(|i| {
        let part = cell >> (BITS as usize * (2 - i)) & most;
        ((part * 255 + most / 2) / most) as u8
    })
}

/// Rows and columns in which two frames differ; one pixel if they are equal.
fn changed(before: &[u8], after: &[u8], width: usize) -> [std::ops::Range<usize>; 2] {
    let mut found: Option<[std::ops::Range<usize>; 2]> = None;
    for (row, (a, b)) in before.chunks(width).zip(after.chunks(width)).enumerate() {
        let differs = |column: &usize| a[*column] != b[*column];
        let Some(first) = (0..width).find(differs) else { continue };
        let end = (0..width).rev().find(differs).map_or(width, |last| last + 1);
        found = Some(match found {
            Some([rows, columns]) => [rows.start..row + 1, columns.start.min(first)..columns.end.max(end)],
            None => [row..row + 1, first..end],
        });
    }
    found.unwrap_or([0..1, 0..1])
}

/// Selects a palette by dividing the colours of frames at medians until there are enough (Heckbert 1982).
fn palette(frames: &[Vec<u8>]) -> Vec<[u8; 3]> {
    let mut counts = vec![0_u32; 1 << (3 * BITS)];
    for rgb in frames.iter().flat_map(|frame| frame.chunks_exact(3)) {
        counts[cell([rgb[0], rgb[1], rgb[2]])] += 1;
    }
    // so that the background does not outweigh the objects in front of it
    let weight = |count: u32| f64::from(count).sqrt();
    let present = counts.iter().enumerate().filter(|(_, count)| **count > 0);
    let all: Vec<([u8; 3], f64)> = present.map(|(cell, count)| (colour_of(cell), weight(*count))).collect();
    let mut boxes = vec![all];
    while boxes.len() < COLOURS {
        let Some((largest, channel)) = widest(&boxes) else { break };
        let mut cut = boxes.swap_remove(largest);
        cut.sort_by_key(|(colour, _)| (colour[channel], *colour));
        let half = cut.iter().map(|(_, weight)| weight).sum::<f64>() / 2.0;
        let mut sum = 0.0;
        let middle = cut.iter().position(|(_, weight)| {
            sum += weight;
            sum >= half
        });
        let rest = cut.split_off((middle.unwrap_or(0) + 1).min(cut.len() - 1));
        boxes.extend([cut, rest]);
    }
    let mut palette: Vec<[u8; 3]> =
        boxes.iter().filter(|colours| !colours.is_empty()).map(|colours| mean(colours)).collect();
    // represent the background exactly
    if let Some(brightest) =
        palette.iter_mut().max_by_key(|colour| colour.iter().map(|part| u32::from(*part)).sum::<u32>())
        && brightest.iter().all(|part| *part > 247)
    {
        *brightest = [255; 3];
    }
    palette.resize(COLOURS + 1, [255; 3]);
    palette
}

/// Set of colours with the largest spread, weighted by its size, and the channel of that spread; `None` if all sets are single colours.
fn widest(boxes: &[Vec<([u8; 3], f64)>]) -> Option<(usize, usize)> {
    let spread = |colours: &[([u8; 3], f64)]| {
        let along = |i: usize| {
            let parts = colours.iter().map(|(colour, _)| colour[i]);
            parts.clone().max().unwrap_or(0) - parts.min().unwrap_or(0)
        };
        let channel = (0..3).max_by_key(|i| along(*i)).unwrap_or(0);
        let weight: f64 = colours.iter().map(|(_, weight)| weight).sum();
        (f64::from(along(channel)).powi(2) * weight, channel)
    };
    let open = boxes.iter().enumerate().filter(|(_, colours)| colours.len() > 1);
    let found = open.map(|(i, colours)| (spread(colours), i)).max_by(|((a, _), _), ((b, _), _)| a.total_cmp(b))?;
    Some((found.1, found.0.1))
}

fn mean(colours: &[([u8; 3], f64)]) -> [u8; 3] {
    let total: f64 = colours.iter().map(|(_, weight)| weight).sum();
    std::array::from_fn(|i| {
        let sum: f64 = colours.iter().map(|(colour, weight)| f64::from(colour[i]) * weight).sum();
        (sum / total).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use gif::{ColorOutput, DecodeOptions};

    const SIZE: [u32; 2] = [40, 30];

    /// Frame of a square that moves over a plain background.
    fn scene(frame: usize) -> Vec<u8> {
        let pixel = |i: usize| {
            let (x, y) = (i % 40, i / 40);
            if (frame..frame + 8).contains(&x) && (5..15).contains(&y) { [200, 40, 10] } else { [255; 3] }
        };
        (0..1200).flat_map(pixel).collect()
    }

    /// A GIF with 30 frames per second has the duration of its video within half a hundredth of a second, and represents a few colours
    /// exactly; a frame without changes has one pixel.
    #[test]
    fn gifs_last_as_long_as_their_film() {
        let frames: Vec<Vec<u8>> = [0, 1, 2, 2, 2, 7, 11].into_iter().cycle().take(31).map(scene).collect();
        let mut film = Gif::new(SIZE, 30.0, &frames[..6]).unwrap();
        frames.iter().for_each(|frame| film.add(frame).unwrap());
        let file = film.finish().unwrap();
        assert!(file.starts_with(Gif::BEGINS) && file[..1000].windows(16).any(|part| part == Gif::MARK));
        let mut options = DecodeOptions::new();
        options.set_color_output(ColorOutput::RGBA);
        let mut decoder = options.read_info(file.as_slice()).unwrap();
        let (mut shown, mut hundredths, mut count) = (vec![0; 3 * 1200], 0, 0);
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            hundredths += u32::from(frame.delay);
            for (i, rgba) in frame.buffer.chunks(4).enumerate().filter(|(_, rgba)| rgba[3] > 0) {
                let (right, down) = (i % usize::from(frame.width), i / usize::from(frame.width));
                let first = 3 * ((usize::from(frame.top) + down) * 40 + usize::from(frame.left) + right);
                shown[first..first + 3].copy_from_slice(&rgba[..3]);
            }
            // six bits per channel: errors up to 2 of 255
            let off = shown.iter().zip(&frames[count]).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(off <= 2, "frame {count}: {off}");
            if count % 7 == 3 || count % 7 == 4 {
                assert_eq!((frame.width, frame.height), (1, 1));
            }
            count += 1;
        }
        assert_eq!((count, hundredths), (31, 103));
    }
}

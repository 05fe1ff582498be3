//! An encoder for the constrained baseline profile of H.264 (ITU-T H.264, 08/2021), which browsers, players and office programs can
//! decode.
//!
//! Videos of models have static cameras and plain backgrounds. Macroblocks of 16 × 16 pixels are skipped, predicted from the previous
//! picture, or predicted from their neighbours. There is no motion search, no deblocking filter, and one quantiser.

mod bits;
mod residual;
mod transform;

use bits::Bits;
use residual::{Neighbours, write};
use transform::{
    Block, QP, SCAN, constant_level, constant_of_chroma, constant_of_luma, forward, hadamard, inverse, quantised,
    restored,
};

/// Coded block patterns of inter-predicted macroblocks (table 9-4), in the order of their code numbers.
const PATTERNS: [u8; 48] = [
    0, 16, 1, 2, 4, 8, 32, 3, 5, 10, 12, 15, 47, 7, 11, 13, 14, 6, 9, 31, 35, 37, 42, 44, 33, 34, 36, 40, 39, 43, 45,
    46, 17, 18, 20, 24, 19, 21, 26, 28, 23, 27, 29, 30, 22, 25, 38, 41,
];
/// Maximum number of macroblocks per picture for each level (table A-1).
const LEVELS: [(usize, u8); 7] =
    [(1_620, 30), (3_600, 31), (5_120, 32), (8_192, 40), (8_704, 42), (22_080, 50), (36_864, 52)];
/// Advantage, in the sum of absolute differences, of a prediction from the previous picture, which needs no mode.
const BEFORE: i32 = 64;

/// Plane of samples whose width and height are multiples of the macroblock size.
#[derive(Debug, Clone, PartialEq)]
struct Plane {
    width: usize,
    samples: Vec<u8>,
}

impl Plane {
    fn new(width: usize, height: usize) -> Self {
        Self { width, samples: vec![0; width * height] }
    }

    fn at(&self, x: usize, y: usize) -> i32 {
        self.samples[y * self.width + x].into()
    }

    fn put(&mut self, x: usize, y: usize, value: i32) {
        self.samples[y * self.width + x] = value.clamp(0, 255) as u8;
    }

    /// Returns whether both planes are equal in a square.
    fn agrees(&self, other: &Self, [x, y]: [usize; 2], side: usize) -> bool {
        (y..y + side).all(|row| {
            let part = row * self.width + x..row * self.width + x + side;
            self.samples[part.clone()] == other.samples[part]
        })
    }
}

/// Luma and two chroma planes.
type Picture = [Plane; 3];

/// Quantised levels of a macroblock.
struct Coded {
    luma: [Block; 16],
    /// DC coefficients of luma in an intra-predicted macroblock.
    constants: Option<Block>,
    chroma_constants: [[i32; 4]; 2],
    chroma: [[Block; 4]; 2],
}

/// Encoder of a video.
pub(super) struct Encoder {
    size: [u32; 2],
    /// Number of columns and rows of macroblocks.
    blocks: [usize; 2],
    restored: Picture,
    before: Option<Picture>,
    /// Number of coefficients of each 4 × 4 block of the planes.
    counts: [Vec<u8>; 3],
    pictures: u32,
    /// Number of pictures from one key frame to the next.
    interval: u32,
}

/// Encoded picture.
pub(super) struct Encoded {
    /// NAL unit, preceded by its length.
    pub bytes: Vec<u8>,
    /// Whether it is a key frame, which can be decoded without other pictures.
    pub stands_alone: bool,
}

impl Encoder {
    /// Creates an encoder of pictures with even width and height; every `interval`-th is a key frame.
    pub fn new(size: [u32; 2], interval: u32) -> Self {
        let [wide, high] = size.map(|length| length.div_ceil(16) as usize);
        let planes = [Plane::new(16 * wide, 16 * high), Plane::new(8 * wide, 8 * high), Plane::new(8 * wide, 8 * high)];
        let counts = [vec![0; 16 * wide * high], vec![0; 4 * wide * high], vec![0; 4 * wide * high]];
        let interval = interval.max(1);
        Self { size, blocks: [wide, high], restored: planes, before: None, counts, pictures: 0, interval }
    }

    /// Ten times the number of the H.264 level.
    fn level(&self) -> u8 {
        let count = self.blocks[0] * self.blocks[1];
        LEVELS.into_iter().find(|(most, _)| count <= *most).map_or(52, |(_, level)| level)
    }

    /// Sequence parameter set: profile, size, colours according to BT.709.
    pub fn sequence(&self) -> Vec<u8> {
        let mut bits = Bits::default();
        bits.put(66, 8); // baseline profile
        bits.put(0xc0, 8); // constrained baseline profile
        bits.put(self.level().into(), 8);
        for value in [0, 0, 2, 1] {
            bits.ue(value); // identifier, frame numbers modulo 16, output in decoding order, one reference picture
        }
        bits.put(0, 1);
        self.blocks.iter().for_each(|count| bits.ue(*count as u32 - 1));
        bits.put(0b11, 2); // frames only, no fields
        let cut = [0, 1].map(|i| (16 * self.blocks[i] as u32 - self.size[i]) / 2);
        bits.put(u32::from(cut != [0, 0]), 1);
        if cut != [0, 0] {
            [0, cut[0], 0, cut[1]].into_iter().for_each(|side| bits.ue(side));
        }
        bits.put(1, 1);
        bits.put(0b001, 3); // no aspect ratio, no overscan, a video signal type:
        bits.put(5, 3);
        bits.put(0b01, 2);
        [1, 1, 1].into_iter().for_each(|of| bits.put(of, 8));
        bits.put(0b0_0000, 5); // no chroma sample location, no timing, no buffer parameters, no picture structure
        bits.put(0b11, 2); // restrictions: motion vectors may point outside the picture
        for value in [0, 0, 16, 16, 0, 1] {
            bits.ue(value);
        }
        bits.unit(0x67)
    }

    /// Picture parameter set: variable-length codes, the quantiser.
    pub fn parameters(&self) -> Vec<u8> {
        let mut bits = Bits::default();
        bits.ue(0);
        bits.ue(0);
        bits.put(0, 2);
        [0, 0, 0].into_iter().for_each(|value| bits.ue(value));
        bits.put(0, 3);
        bits.se(QP - 26);
        bits.se(0);
        bits.se(0);
        bits.put(0b100, 3); // the deblocking filter is controlled per slice
        bits.unit(0x68)
    }

    /// Encodes a picture given as red, green and blue per pixel, row by row.
    pub fn encode(&mut self, pixels: &[u8]) -> Encoded {
        let picture = self.planes(pixels);
        let number = self.pictures % self.interval;
        let stands_alone = number == 0;
        let mut bits = Bits::default();
        bits.ue(0);
        bits.ue(if stands_alone { 7 } else { 5 });
        bits.ue(0);
        bits.put(number % 16, 4);
        if stands_alone {
            bits.ue(self.pictures / self.interval % 2);
            bits.put(0, 2);
        } else {
            bits.put(0, 3); // one reference picture, no reordering, sliding-window marking
        }
        bits.se(0);
        bits.ue(1); // no deblocking filter
        self.counts.iter_mut().for_each(|counts| counts.fill(0));
        let mut kept = 0;
        for row in 0..self.blocks[1] {
            for column in 0..self.blocks[0] {
                self.block([column, row], &picture, (stands_alone, &mut kept), &mut bits);
            }
        }
        if kept > 0 {
            bits.ue(kept);
        }
        self.before = Some(picture);
        self.pictures += 1;
        let unit = bits.unit(if stands_alone { 0x65 } else { 0x41 });
        let mut bytes = (unit.len() as u32).to_be_bytes().to_vec();
        bytes.extend(unit);
        Encoded { bytes, stands_alone }
    }

    /// Planes of a picture according to BT.709 with limited video range; edges are repeated to complete macroblocks.
    fn planes(&self, pixels: &[u8]) -> Picture {
        let [width, height] = self.size.map(|length| length as usize);
        let mut planes = self.restored.clone();
        let [luma, blue, red] = &mut planes;
        let rgb = |x: usize, y: usize| -> [i32; 3] {
            let first = 3 * (y.min(height - 1) * width + x.min(width - 1));
            [pixels[first].into(), pixels[first + 1].into(), pixels[first + 2].into()]
        };
        let (wide, high) = (luma.width, luma.samples.len() / luma.width);
        for y in 0..high {
            for x in 0..wide {
                let [r, g, b] = rgb(x, y);
                luma.put(x, y, 16 + ((11_966 * r + 40_254 * g + 4_064 * b + 32_768) >> 16));
            }
        }
        for y in 0..high / 2 {
            for x in 0..wide / 2 {
                let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(right, down)| rgb(2 * x + right, 2 * y + down));
                let [r, g, b]: [i32; 3] = std::array::from_fn(|i| four.iter().map(|rgb| rgb[i]).sum());
                blue.put(x, y, 128 + ((-6_596 * r - 22_189 * g + 28_785 * b + 131_072) >> 18));
                red.put(x, y, 128 + ((28_785 * r - 26_145 * g - 2_640 * b + 131_072) >> 18));
            }
        }
        planes
    }

    /// Encodes a macroblock.
    fn block(&mut self, at: [usize; 2], picture: &Picture, (alone, kept): (bool, &mut u32), bits: &mut Bits) {
        let [x, y] = at.map(|place| 16 * place);
        if !alone
            && let Some(before) = &self.before
            && (0..3).all(|plane| {
                let part = if plane == 0 { 1 } else { 2 };
                picture[plane].agrees(&before[plane], [x / part, y / part], 16 / part)
            })
        {
            *kept += 1;
            return; // skipped: the previous picture is kept here
        }
        let (mode, predicted, apart) = self.best_of_neighbours(at, &picture[0]);
        let from_before = !alone && {
            let all = (0..256).map(|i| (x + i % 16, y + i / 16));
            all.map(|(x, y)| (picture[0].at(x, y) - self.restored[0].at(x, y)).abs()).sum::<i32>() <= apart + BEFORE
        };
        let luma_prediction: [i32; 256] =
            if from_before { std::array::from_fn(|i| self.restored[0].at(x + i % 16, y + i / 16)) } else { predicted };
        let chroma_prediction = [1, 2].map(|plane| self.chroma_prediction(at, plane, from_before));
        let share = if from_before { 6 } else { 3 };
        let coded = self.coded(at, picture, (&luma_prediction, &chroma_prediction), share, from_before);
        let has_luma = |part: usize| (0..4).any(|i| coded.luma[4 * part + i] != [0; 16]);
        let luma: u32 = (0..4).map(|part| u32::from(has_luma(part)) << part).sum();
        let any = |blocks: &[Block; 4]| blocks.iter().any(|block| *block != [0; 16]);
        let chroma = if coded.chroma.iter().any(any) { 2 } else { u32::from(coded.chroma_constants != [[0; 4]; 2]) };
        if from_before && luma == 0 && chroma == 0 {
            *kept += 1;
            return;
        }
        if !alone {
            bits.ue(*kept);
            *kept = 0;
        }
        if from_before {
            bits.ue(0);
            bits.put(0b11, 2); // motion vector zero
            let pattern = (luma | chroma << 4) as u8;
            bits.ue(PATTERNS.iter().position(|other| *other == pattern).unwrap_or(0) as u32);
        } else {
            let offset = if alone { 0 } else { 5 };
            bits.ue(offset + 1 + mode + 4 * chroma + if luma > 0 { 12 } else { 0 });
            bits.ue(0); // DC prediction of chroma
        }
        bits.se(0); // unchanged quantiser
        self.write(at, &coded, (luma, chroma), bits);
    }

    /// Best intra prediction of luma (vertical, horizontal or DC): number of the mode, samples, sum of absolute differences.
    fn best_of_neighbours(&self, at: [usize; 2], picture: &Plane) -> (u32, [i32; 256], i32) {
        let [x, y] = at.map(|place| 16 * place);
        let plane = &self.restored[0];
        let above = (y > 0).then(|| std::array::from_fn::<i32, 16, _>(|i| plane.at(x + i, y - 1)));
        let left = (x > 0).then(|| std::array::from_fn::<i32, 16, _>(|i| plane.at(x - 1, y + i)));
        let sum = |side: &[i32; 16]| side.iter().sum::<i32>();
        let mean = match (&above, &left) {
            (Some(above), Some(left)) => (sum(above) + sum(left) + 16) >> 5,
            (Some(side), None) | (None, Some(side)) => (sum(side) + 8) >> 4,
            (None, None) => 128,
        };
        let candidates = [
            above.map(|above| (0, std::array::from_fn::<i32, 256, _>(|i| above[i % 16]))),
            left.map(|left| (1, std::array::from_fn(|i| left[i / 16]))),
            Some((2, [mean; 256])),
        ];
        let apart = |samples: &[i32; 256]| {
            samples.iter().enumerate().map(|(i, sample)| (picture.at(x + i % 16, y + i / 16) - sample).abs()).sum()
        };
        let judged = candidates.into_iter().flatten().map(|(mode, samples)| (mode, samples, apart(&samples)));
        judged.min_by_key(|(_, _, apart)| *apart).unwrap_or((2, [mean; 256], i32::MAX))
    }

    /// Prediction of chroma: from the previous picture, or DC prediction from the neighbours of each 4 × 4 block (clause 8.3.4.1).
    fn chroma_prediction(&self, at: [usize; 2], plane: usize, from_before: bool) -> [i32; 64] {
        let ([x, y], plane) = (at.map(|place| 8 * place), &self.restored[plane]);
        if from_before {
            return std::array::from_fn(|i| plane.at(x + i % 8, y + i / 8));
        }
        let above = |part: usize| (y > 0).then(|| (0..4).map(|i| plane.at(x + 4 * part + i, y - 1)).sum::<i32>());
        let left = |part: usize| (x > 0).then(|| (0..4).map(|i| plane.at(x - 1, y + 4 * part + i)).sum::<i32>());
        let one = |side: Option<i32>| side.map(|sum| (sum + 2) >> 2);
        let mean = |column: usize, row: usize| {
            let found = match (column, row) {
                (1, 0) => one(above(1)).or(one(left(0))),
                (0, 1) => one(left(1)).or(one(above(0))),
                (column, row) => match (above(column), left(row)) {
                    (Some(above), Some(left)) => Some((above + left + 4) >> 3),
                    (above, left) => one(above).or(one(left)),
                },
            };
            found.unwrap_or(128)
        };
        let means = [[mean(0, 0), mean(1, 0)], [mean(0, 1), mean(1, 1)]];
        std::array::from_fn(|i| means[i / 32][i % 8 / 4])
    }

    /// Returns the quantised levels of the differences from a prediction, and stores the reconstructed picture.
    fn coded(
        &mut self,
        at: [usize; 2],
        picture: &Picture,
        (luma, chroma): (&[i32; 256], &[[i32; 64]; 2]),
        share: i32,
        from_before: bool,
    ) -> Coded {
        let [x, y] = at.map(|place| 16 * place);
        let transformed: [Block; 16] = std::array::from_fn(|block| {
            let (right, down) = place_of(block);
            forward(&std::array::from_fn(|i| {
                let (column, row) = (4 * right + i % 4, 4 * down + i / 4);
                picture[0].at(x + column, y + row) - luma[16 * row + column]
            }))
        });
        let mut levels = transformed.map(|block| quantised(&block, share));
        let mut constants = None;
        let mut restored_luma = levels.map(|block| restored(&block));
        if !from_before {
            let mut first = [0; 16];
            for (block, coefficients) in transformed.iter().enumerate() {
                let (right, down) = place_of(block);
                first[4 * down + right] = coefficients[0];
            }
            let found = hadamard(&first).map(|value| constant_level((value + 1) >> 1, share));
            let back = hadamard(&found).map(constant_of_luma);
            for block in 0..16 {
                let (right, down) = place_of(block);
                levels[block][0] = 0;
                restored_luma[block][0] = back[4 * down + right];
            }
            constants = Some(found);
        }
        for (block, coefficients) in restored_luma.iter().enumerate() {
            let (right, down) = place_of(block);
            for (i, difference) in inverse(coefficients).into_iter().enumerate() {
                let (column, row) = (4 * right + i % 4, 4 * down + i / 4);
                self.restored[0].put(x + column, y + row, luma[16 * row + column] + difference);
            }
        }
        let mut coded = Coded { luma: levels, constants, chroma_constants: [[0; 4]; 2], chroma: [[[0; 16]; 4]; 2] };
        for (plane, prediction) in chroma.iter().enumerate() {
            self.code_chroma(at, (plane, &picture[plane + 1]), prediction, share, &mut coded);
        }
        coded
    }

    fn code_chroma(
        &mut self,
        at: [usize; 2],
        (plane, picture): (usize, &Plane),
        prediction: &[i32; 64],
        share: i32,
        coded: &mut Coded,
    ) {
        let [x, y] = at.map(|place| 8 * place);
        let place = |block: usize, i: usize| (4 * (block % 2) + i % 4, 4 * (block / 2) + i / 4);
        let transformed: [Block; 4] = std::array::from_fn(|block| {
            forward(&std::array::from_fn(|i| {
                let (column, row) = place(block, i);
                picture.at(x + column, y + row) - prediction[8 * row + column]
            }))
        });
        let sums = |[a, b, c, d]: [i32; 4]| [a + b + c + d, a - b + c - d, a + b - c - d, a - b - c + d];
        let found = sums(transformed.map(|block| block[0])).map(|value| constant_level(value, share));
        let back = sums(found).map(constant_of_chroma);
        coded.chroma_constants[plane] = found;
        for block in 0..4 {
            let mut levels = quantised(&transformed[block], share);
            levels[0] = 0;
            let mut coefficients = restored(&levels);
            coefficients[0] = back[block];
            coded.chroma[plane][block] = levels;
            for (i, difference) in inverse(&coefficients).into_iter().enumerate() {
                let (column, row) = place(block, i);
                self.restored[plane + 1].put(x + column, y + row, prediction[8 * row + column] + difference);
            }
        }
    }

    /// Appends the levels of a macroblock.
    fn write(&mut self, at: [usize; 2], coded: &Coded, (luma, chroma): (u32, u32), bits: &mut Bits) {
        let first = at.map(|place| 4 * place);
        if let Some(constants) = &coded.constants {
            let around = self.around(0, first);
            write(bits, &SCAN.map(|i| constants[i]), Neighbours::Count(around));
        }
        for (block, levels) in coded.luma.iter().enumerate() {
            // an intra-predicted macroblock has all parts of luma or none
            let written = if coded.constants.is_some() { luma > 0 } else { luma >> (block / 4) & 1 == 1 };
            if written {
                let (right, down) = place_of(block);
                let from = usize::from(coded.constants.is_some());
                self.write_at(0, [first[0] + right, first[1] + down], (levels, from), bits);
            }
        }
        if chroma > 0 {
            coded.chroma_constants.iter().for_each(|constants| {
                write(bits, constants, Neighbours::Chroma);
            });
        }
        if chroma == 2 {
            for (plane, blocks) in coded.chroma.iter().enumerate() {
                for (block, levels) in blocks.iter().enumerate() {
                    let place = [2 * at[0] + block % 2, 2 * at[1] + block / 2];
                    self.write_at(plane + 1, place, (levels, 1), bits);
                }
            }
        }
    }

    fn write_at(&mut self, plane: usize, at: [usize; 2], (levels, from): (&Block, usize), bits: &mut Bits) {
        let around = self.around(plane, at);
        let scanned = SCAN.map(|i| levels[i]);
        let width = self.width(plane);
        self.counts[plane][at[1] * width + at[0]] = write(bits, &scanned[from..], Neighbours::Count(around));
    }

    /// Number of 4 × 4 blocks in a row of a plane.
    fn width(&self, plane: usize) -> usize {
        self.blocks[0] * if plane == 0 { 4 } else { 2 }
    }

    /// Mean number of coefficients in the 4 × 4 blocks on the left and above.
    fn around(&self, plane: usize, [x, y]: [usize; 2]) -> u32 {
        let (counts, width) = (&self.counts[plane], self.width(plane));
        let left = (x > 0).then(|| u32::from(counts[y * width + x - 1]));
        let above = (y > 0).then(|| u32::from(counts[(y - 1) * width + x]));
        match (left, above) {
            (Some(left), Some(above)) => (left + above).div_ceil(2),
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => 0,
        }
    }
}

/// Column and row of a 4 × 4 block in coding order.
fn place_of(block: usize) -> (usize, usize) {
    (block % 2 + 2 * (block / 4 % 2), block / 2 % 2 + 2 * (block / 8))
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;

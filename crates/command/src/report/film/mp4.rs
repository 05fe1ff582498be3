//! MP4 files (ISO/IEC 14496-12 and 14496-15) with one H.264 track and the index before the frames.

use super::h264::Encoder;

/// Interval in s of key frames, to which players can seek.
const INTERVAL_S: f64 = 4.0;
/// Time units per frame.
const TICKS: u32 = 1000;

/// Video as MP4.
pub struct Mp4 {
    encoder: Encoder,
    size: [u32; 2],
    /// Time units per second.
    timescale: u32,
    /// Sizes of the frames in bytes.
    sizes: Vec<u32>,
    /// Numbers of the key frames, starting at 1.
    alone: Vec<u32>,
    data: Vec<u8>,
}

impl Mp4 {
    /// The first bytes of a file.
    pub const BEGINS: &[u8] = b"\0\0\0\x1cftypisom";
    /// Text near the beginning of a file.
    pub const MARK: &[u8] = b"made by foldwing";

    /// Creates a video with frames of even width and height.
    pub fn new(size: [u32; 2], frames_per_s: f64) -> Self {
        let encoder = Encoder::new(size, (INTERVAL_S * frames_per_s).ceil() as u32);
        let timescale = (frames_per_s * f64::from(TICKS)).round() as u32;
        Self { encoder, size, timescale, sizes: Vec::new(), alone: Vec::new(), data: Vec::new() }
    }

    /// Appends a frame, given as red, green and blue per pixel, row by row.
    pub fn add(&mut self, pixels: &[u8]) {
        let encoded = self.encoder.encode(pixels);
        self.sizes.push(encoded.bytes.len() as u32);
        if encoded.stands_alone {
            self.alone.push(self.sizes.len() as u32);
        }
        self.data.extend(encoded.bytes);
    }

    /// Returns the finished file.
    pub fn finish(self) -> Vec<u8> {
        let mut file = boxed(b"ftyp", &[b"isom", &0x200_u32.to_be_bytes(), b"isom", b"avc1", b"mp41"]);
        file.extend(boxed(b"free", &[Self::MARK]));
        let length = self.index(0).len();
        let data_at = (file.len() + length + 8) as u32;
        file.extend(self.index(data_at));
        file.extend(boxed(b"mdat", &[&self.data]));
        file
    }

    /// Index of a file whose frame data start at the byte `data_at`.
    fn index(&self, data_at: u32) -> Vec<u8> {
        let count = self.sizes.len() as u32;
        let duration = count * TICKS;
        let matrix = words(&[0x1_0000, 0, 0, 0, 0x1_0000, 0, 0, 0, 0x4000_0000]);
        let movie = [words(&[0, 0, 0, self.timescale, duration, 0x1_0000, 0x100_0000, 0, 0]), matrix.clone()].concat();
        let movie = [movie, words(&[0, 0, 0, 0, 0, 0, 2])].concat();
        let sides = self.size.map(|length| length << 16);
        let track = [words(&[3, 0, 0, 1, 0, duration, 0, 0, 0, 0]), matrix, words(&sides)].concat();
        let media = words(&[0, 0, 0, self.timescale, duration, 0x55c4_0000]); // undefined language
        let handler = [words(&[0, 0]), b"vide".to_vec(), words(&[0, 0, 0]), b"film\0".to_vec()].concat();
        let reference = boxed(b"dref", &[&words(&[0, 1]), &boxed(b"url ", &[&words(&[1])])]);
        let samples = self.samples(data_at);
        let information = boxed(
            b"minf",
            &[&boxed(b"vmhd", &[&words(&[1, 0, 0])]), &boxed(b"dinf", &[&reference]), &boxed(b"stbl", &[&samples])],
        );
        let media = boxed(b"mdia", &[&boxed(b"mdhd", &[&media]), &boxed(b"hdlr", &[&handler]), &information]);
        let track = boxed(b"trak", &[&boxed(b"tkhd", &[&track]), &media]);
        boxed(b"moov", &[&boxed(b"mvhd", &[&movie]), &track])
    }

    /// Tables of the frames: format, times, sizes, file offsets.
    fn samples(&self, data_at: u32) -> Vec<u8> {
        let count = self.sizes.len() as u32;
        let (sequence, parameters) = (self.encoder.sequence(), self.encoder.parameters());
        let length = |unit: &[u8]| (unit.len() as u16).to_be_bytes();
        let configuration = boxed(
            b"avcC",
            &[
                &[1, sequence[1], sequence[2], sequence[3], 0xff, 0xe1],
                &length(&sequence),
                &sequence,
                &[1],
                &length(&parameters),
                &parameters,
            ],
        );
        let colours = boxed(b"colr", &[b"nclx", &[0, 1, 0, 1, 0, 1, 0]]);
        let [width, height] = self.size.map(|length| (length as u16).to_be_bytes());
        let mut name = [0; 32];
        name[..9].copy_from_slice(b"\x08foldwing");
        let resolution = words(&[0x48_0000, 0x48_0000, 0]);
        let format = boxed(
            b"avc1",
            &[
                &[0, 0, 0, 0, 0, 0, 0, 1],
                &[0; 16],
                &width,
                &height,
                &resolution,
                &[0, 1],
                &name,
                &[0, 24, 0xff, 0xff],
                &configuration,
                &colours,
            ],
        );
        [
            boxed(b"stsd", &[&words(&[0, 1]), &format]),
            boxed(b"stts", &[&words(&[0, 1, count, TICKS])]),
            boxed(b"stss", &[&words(&[0, self.alone.len() as u32]), &words(&self.alone)]),
            boxed(b"stsc", &[&words(&[0, 1, 1, count, 1])]),
            boxed(b"stsz", &[&words(&[0, 0, count]), &words(&self.sizes)]),
            boxed(b"stco", &[&words(&[0, 1, data_at])]),
        ]
        .concat()
    }
}

fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

/// A box of the format: its length, type and parts.
fn boxed(kind: &[u8; 4], parts: &[&[u8]]) -> Vec<u8> {
    let length = 8 + parts.iter().map(|part| part.len()).sum::<usize>();
    let mut whole = (length as u32).to_be_bytes().to_vec();
    whole.extend(kind);
    parts.iter().for_each(|part| whole.extend(*part));
    whole
}

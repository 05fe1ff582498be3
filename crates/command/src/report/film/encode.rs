//! Videos as files: frames are drawn on all processors, and encoded in order.

use super::{Film, Gif, Mp4};
use crate::report::figure::signed;
use rayon::prelude::*;
use std::path::Path;
use tiny_skia::{IntSize, Pixmap};

/// Number of frames from which the colour table of the GIF is selected.
const SAMPLED: usize = 7;

/// Format of a video.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// H.264 in MP4.
    Mp4,
    /// GIF in an endless loop.
    Gif,
    /// One PNG file per frame.
    Png,
}

impl Format {
    /// Returns the format given by a file extension.
    ///
    /// # Errors
    /// The extension is not supported; the message lists the formats.
    pub fn of(path: &Path) -> Result<Self, String> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        let formats = "videos are .mp4 (H.264), .gif, or .png (one numbered file per frame)";
        match ending.as_str() {
            "mp4" | "m4v" => Ok(Self::Mp4),
            "gif" => Ok(Self::Gif),
            "png" => Ok(Self::Png),
            "webm" => Err(format!(
                "WebM is not written; {formats}. The page of --view records WebM in a browser, or convert the .mp4 with ffmpeg"
            )),
            "avi" | "mov" | "mkv" | "ogv" | "apng" | "webp" => {
                Err(format!(".{ending} is not written; {formats}; ffmpeg converts them"))
            }
            _ => Err(format!("the name must end in the format; {formats}")),
        }
    }

    /// Checks the size and the frame rate.
    ///
    /// # Errors
    /// Values that the format does not allow.
    pub fn check(self, [width, height]: [u32; 2], frames_per_s: f64) -> Result<(), String> {
        match self {
            Self::Mp4 if width % 2 == 1 || height % 2 == 1 => {
                Err(format!("--size {width}x{height}: width and height of an MP4 must be even"))
            }
            Self::Gif if frames_per_s > Gif::MAXIMUM_PER_S => Err(format!(
                "--fps {frames_per_s}: a GIF has at most {} frames per second; write an .mp4",
                Gif::MAXIMUM_PER_S
            )),
            Self::Mp4 | Self::Gif | Self::Png => Ok(()),
        }
    }
}

/// Draws a video and passes its file, or its numbered files, to `file`; `drawn` is called with the number of finished frames.
///
/// # Errors
/// Errors of `file` and `drawn`, which end the work.
pub fn encode<E: Send>(
    film: &Film,
    (format, frames_per_s): (Format, f64),
    mut file: impl FnMut(Option<usize>, Vec<u8>) -> Result<(), E> + Send,
    mut drawn: impl FnMut(usize) -> Result<(), E>,
) -> Result<(), E> {
    let count = film.times_s.len();
    match format {
        Format::Png => in_order(film, |index, pixels| file(Some(index), png(film.size, &pixels)), &mut drawn),
        Format::Mp4 => {
            let mut mp4 = Mp4::new(film.size, frames_per_s);
            in_order(
                film,
                |_, pixels| {
                    mp4.add(&pixels);
                    Ok(())
                },
                &mut drawn,
            )?;
            file(None, mp4.finish())
        }
        Format::Gif => {
            let few = count.min(SAMPLED);
            let chosen: Vec<usize> = (0..few).map(|i| (count - 1) * i / (few - 1).max(1)).collect();
            let some: Vec<Vec<u8>> = chosen.into_par_iter().map(|index| film.frame(index)).collect();
            let mut gif = Gif::new(film.size, frames_per_s, &some).expect("writing to memory does not fail");
            in_order(
                film,
                |_, pixels| {
                    gif.add(&pixels).expect("writing to memory does not fail");
                    Ok(())
                },
                &mut drawn,
            )?;
            file(None, gif.finish().expect("writing to memory does not fail"))
        }
    }
}

/// Draws frames in parallel while the preceding ones are used in order.
fn in_order<E: Send>(
    film: &Film,
    mut each: impl FnMut(usize, Vec<u8>) -> Result<(), E> + Send,
    drawn: &mut impl FnMut(usize) -> Result<(), E>,
) -> Result<(), E> {
    let count = film.times_s.len();
    let at_once = rayon::current_num_threads().max(1);
    let mut ready: Vec<(usize, Vec<u8>)> = Vec::new();
    let mut next = 0;
    while next < count || !ready.is_empty() {
        let range = next..(next + at_once).min(count);
        next = range.end;
        let used = std::mem::take(&mut ready);
        let (fresh, outcome) = rayon::join(
            || range.into_par_iter().map(|index| (index, film.frame(index))).collect::<Vec<_>>(),
            || used.into_iter().try_for_each(|(index, pixels)| each(index, pixels)),
        );
        outcome?;
        ready = fresh;
        drawn(next)?;
    }
    Ok(())
}

/// Returns a frame as a PNG file that names the program.
fn png([width, height]: [u32; 2], pixels: &[u8]) -> Vec<u8> {
    let opaque = pixels.chunks_exact(3).flat_map(|rgb| [rgb[0], rgb[1], rgb[2], 255]).collect();
    let size = IntSize::from_wh(width, height).expect("the size is not zero");
    let map = Pixmap::from_vec(opaque, size).expect("the size fits the pixels");
    signed(map.encode_png().expect("writing to memory does not fail"))
}

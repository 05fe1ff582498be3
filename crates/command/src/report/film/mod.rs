//! Videos of a run without a browser or a display: the data of the page (`viewer/packed.rs`), drawn by a rasteriser.
//!
//! Reasons and formats: `docs/decisions/0061-films.md`.

mod camera;
mod colours;
mod drawing;
mod encode;
mod gif;
mod h264;
mod letters;
mod machine;
mod mp4;
mod outlines;
mod raster;
mod run;
mod skin;
mod solids;
mod stage;

pub use camera::View;
pub use encode::{Format, encode};
pub use gif::Gif;
pub use mp4::Mp4;

use crate::report::viewer::PackedRun;
use camera::{Camera, Motion};
use drawing::Drawing;
use letters::{Anchor, Letters};
use machine::Measures;
use raster::Raster;
use run::{Extents, Run, State};
use stage::Stage;
use std::sync::{Mutex, PoisonError};

/// Playback speeds among which the default is chosen, as on the page.
const SPEEDS: [f64; 14] = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
/// Approximate length of a video in s at the default speed.
const LENGTH_S: f64 = 8.0;
/// Maximum number of frames of a video.
pub const MAXIMUM_FRAMES: usize = 36_000;
/// Length of the shorter side of a frame in the units of widths, with which text and lines have the sizes of the
/// page.
const UNITS: f64 = 640.0;

/// Settings of a video.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames per second.
    pub frames_per_s: f64,
    /// Seconds of the run per second of the video; `None` for the default.
    pub speed: Option<f64>,
    /// Viewing direction.
    pub view: View,
    /// Whether the camera moves with the model; `None` follows a flying model only.
    pub follows: Option<bool>,
    /// First and last time in s; `None` takes the limits of the run.
    pub span_s: [Option<f64>; 2],
}

/// Video of a run, with frames at equal time intervals.
pub struct Film {
    run: Run,
    measures: Measures,
    stage: Stage,
    motion: Motion,
    letters: Letters,
    size: [u32; 2],
    /// Buffers of finished frames, reused for the next ones.
    rasters: Mutex<Vec<Raster>>,
    /// Times of the frames in s.
    pub times_s: Vec<f64>,
    /// Seconds of the run per second of the video.
    pub speed: f64,
    /// Whether the camera moves with the model.
    pub follows: bool,
}

/// Returns the default playback speed, at which the video takes about eight seconds.
pub fn default_speed(duration_s: f64) -> f64 {
    let off = |speed: &f64| (speed / (duration_s / LENGTH_S)).ln().abs();
    SPEEDS.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(1.0)
}

/// Number of frames for a time span of a run.
pub fn frame_count(duration_s: f64, frames_per_s: f64, speed: f64) -> f64 {
    (duration_s / speed * frames_per_s - 1e-6).ceil().max(0.0) + 1.0
}

impl Film {
    /// Creates a video of a run.
    ///
    /// # Errors
    /// Damaged data, a time span outside the run, or too many frames; the message states the remedy.
    pub fn new(packed: &PackedRun, options: &Options) -> Result<Self, String> {
        let run = Run::read(packed)?;
        let [first_s, last_s] = run.span_s();
        // the recorded times are in single precision
        let slack_s = 1e-6 * (first_s.abs().max(last_s.abs()));
        let [from_s, to_s] = [options.span_s[0].unwrap_or(first_s), options.span_s[1].unwrap_or(last_s)];
        for (option, time_s) in [("--from", from_s), ("--to", to_s)] {
            if !(first_s - slack_s..=last_s + slack_s).contains(&time_s) {
                return Err(format!("{option} {time_s}: the run is from {first_s} to {last_s} s"));
            }
        }
        if to_s < from_s {
            return Err(format!("--to {to_s}: is before --from {from_s}"));
        }
        let speed = options.speed.unwrap_or_else(|| default_speed(to_s - from_s));
        let count = frame_count(to_s - from_s, options.frames_per_s, speed);
        if count > MAXIMUM_FRAMES as f64 {
            return Err(format!(
                "{count:.0} frames exceed the maximum of {MAXIMUM_FRAMES}; increase --speed ({speed}) or reduce --fps"
            ));
        }
        let time_s = |frame: usize| (from_s + frame as f64 * speed / options.frames_per_s).min(to_s);
        let times_s = (0..count as usize).map(time_s).collect();
        let measures = Measures::of(&run);
        let extents = Extents::of(run.sampled(Motion::STATES).flat_map(|state| state.points()));
        let stage = Stage::new(extents, measures.width_m);
        let follows = options.follows.unwrap_or_else(|| run.flies_away());
        let states = run.sampled(Motion::STATES);
        let motion = Motion::new(&run, (options.view, follows), options.size, states);
        let (letters, size, rasters) = (Letters::new(), options.size, Mutex::default());
        Ok(Self { run, measures, stage, motion, letters, size, rasters, times_s, speed, follows })
    }

    /// Draws a frame, returned as red, green and blue per pixel, row by row.
    pub fn frame(&self, index: usize) -> Vec<u8> {
        let time_s = self.times_s[index];
        self.drawn(&self.run.at(time_s), time_s)
    }

    fn drawn(&self, state: &State<'_>, time_s: f64) -> Vec<u8> {
        let mut rasters = self.rasters.lock().unwrap_or_else(PoisonError::into_inner);
        let spare = rasters.pop();
        drop(rasters);
        let mut raster = spare.unwrap_or_else(|| Raster::new(self.size));
        raster.clear(colours::BACKGROUND);
        let unit = f64::from(self.size[0].min(self.size[1])) / UNITS;
        let camera = self.motion.at(state);
        let mut drawing = Drawing { lifted_m: 0.002 * self.measures.width_m, ..Drawing::default() };
        self.stage.add(&mut drawing);
        machine::draw(&self.run, &self.measures, state, &mut drawing);
        drawing.draw(&camera, unit, &mut raster);
        self.label(&drawing, &camera, unit, &mut raster);
        stage::lettering(&self.run, &self.measures, time_s, (self.size, unit)).draw(&self.letters, &mut raster);
        let pixels = raster.pixels();
        self.rasters.lock().unwrap_or_else(PoisonError::into_inner).push(raster);
        pixels
    }

    fn label(&self, drawing: &Drawing, camera: &Camera, unit: f64, raster: &mut Raster) {
        for label in &drawing.labels {
            if camera.depth_m(&label.at) <= camera.nearest_m() {
                continue;
            }
            let seen = camera.seen(&label.at);
            let near = if label.on_top { f64::INFINITY } else { seen.near };
            let size = f64::from(label.height) * unit;
            self.letters.draw(&label.text, [seen.x, seen.y], (size, Anchor::Centre), (near, label.rgb), raster);
        }
    }
}

#[cfg(test)]
mod tests;
